!> Load points without a force: no step moves them, and where they are follows from what their element has become.
module scree_idle_points
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_regions, only: first_vertex_of
  use scree_state, only: state_t
  use scree_system, only: load_point
  implicit none
  private
  public :: are_idle, place_now, places_of_points

contains

  !> Which points are load points without a force.
  pure function are_idle(model) result(idle)
    type(model_t), intent(in) :: model
    logical :: idle(size(model%points%kind))

    idle = model%points%kind == load_point
    if (allocated(model%effects%point_load)) idle(model%effects%point_load%point) = .false.
  end function are_idle

  !> Where an element has taken a point that is there in its first shape, length.
  pure function place_now(model, state, e, place) result(now)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: e
    real(dp), intent(in) :: place(2)         !! at the start, length
    real(dp) :: now(2)
    integer :: k

    k = first_vertex_of(model%elements%shape, e)
    now = state%vertex(:, k) + matmul(reshape(state%deformation(:, e), [2, 2]), place - model%start(:, k))
  end function place_now

  !> Where all points are, length.
  pure function places_of_points(model, state) result(places)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(dp) :: places(2, size(state%point, 2))
    logical :: idle(size(model%points%kind))
    integer :: i

    places = state%point
    idle = are_idle(model)
    do i = 1, size(idle)
      if (idle(i)) places(:, i) = place_now(model, state, model%points%element(i), model%start_point(:, i))
    end do
  end function places_of_points

end module scree_idle_points
