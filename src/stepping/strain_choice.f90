!> Which elements take Green strain in a step, where the scene leaves that to the step.
!>
!> Small strain is off by what it neglects (`error_of_small_strain`), and contacts between elements of small strain by the turn of
!> an edge times the way along it. Where that exceeds the accuracy asked for an element takes Green strain. The choice changes no
!> part of the state: stress, stiffness and shape follow the displacement of the step in the same way with both, so that there is
!> nothing to convert and nothing to lose.
!>
!> The bound of the error is in doc/theory/kinematics.md, eq-error-of-small-strain.
module scree_strain_choice
  use scree_green_strain, only: error_of_small_strain, largest_stretch
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_state, only: state_t
  use scree_system, only: values_of
  implicit none
  private
  public :: add_where_needed, choose_at_start, take_choice

  !> An element that took Green strain takes small strain again below this fraction of the accuracy: at half the rotation.
  real(dp), parameter :: enough = 0.25_dp

contains

  !> Elements that take Green strain by the velocities with which a step begins.
  pure subroutine choose_at_start(model, cache, state, dt, green)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    real(dp), intent(in) :: dt                    !! time
    logical, allocatable, intent(out) :: green(:) !! of the elements that can move
    real(dp) :: error(model%n_elements)
    integer :: e, i

    call find_errors(model, cache, state%pair, dt*state%velocity, error)
    allocate (green(size(model%elements%free)))
    do i = 1, size(green)
      e = model%elements%free(i)
      green(i) = error(e) > merge(enough, 1.0_dp, state%green(e))*model%effects%accuracy
    end do
  end subroutine choose_at_start

  !> Adds the elements that small strain turned out not to be enough for, and where there are any those that it hardly was.
  pure subroutine add_where_needed(model, cache, pair, d, green, found)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    integer, intent(in) :: pair(:, :)             !! (2, n_pairs) elements that may touch in the step
    real(dp), intent(in) :: d(:)                  !! (n_unknowns) of the step
    logical, intent(inout) :: green(:)            !! of the elements that can move
    logical, intent(out) :: found                 !! some are not what they were
    real(dp) :: error(model%n_elements)

    found = .false.
    if (all(green)) return
    call find_errors(model, cache, pair, d, error)
    associate (free => model%elements%free)
      found = any(error(free) > model%effects%accuracy .and. .not. green)
      if (found) green = green .or. error(free) > enough*model%effects%accuracy
    end associate
  end subroutine add_where_needed

  !> Errors of the small strain of elements that can move for a displacement, and of the gaps and slips of those that touch, over
  !> their size.
  pure subroutine find_errors(model, cache, pair, d, error)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    integer, intent(in) :: pair(:, :)             !! (2, n_pairs) elements that may touch
    real(dp), intent(in) :: d(:)                  !! (n_unknowns)
    real(dp), intent(out) :: error(:)             !! (n_elements) of those that can move
    real(dp), allocatable :: turn(:), way(:, :)   !! where there are pairs
    real(dp) :: theta(4), apart
    integer :: e, i, side

    if (size(pair, 2) > 0) allocate (turn(model%n_elements), way(2, model%n_elements), source=0.0_dp)
    do i = 1, size(model%elements%free)
      e = model%elements%free(i)
      associate (own => cache%element(e), unknown => values_of(model%elements, e, d))
        theta = matmul(own%kinematics%gradient, unknown)
        error(e) = error_of_small_strain(theta, own%stress/own%elasticity(1, 1))
        if (.not. allocated(turn)) cycle
        turn(e) = largest_stretch(theta)
        way(:, e) = matmul(own%kinematics%at_centroid, unknown)
      end associate
    end do
    do i = 1, size(pair, 2)
      associate (a => pair(1, i), b => pair(2, i))
        apart = norm2(way(:, a) - way(:, b))/min(cache%element(a)%kinematics%size, cache%element(b)%kinematics%size)
      end associate
      do side = 1, 2
        associate (e_of => pair(side, i))
          if (turn(e_of) > 0) error(e_of) = max(error(e_of), turn(e_of)*apart)
        end associate
      end do
    end do
  end subroutine find_errors

  !> Has the elements that can move take the strain that was chosen.
  pure subroutine take_choice(model, green, cache)
    type(model_t), intent(in) :: model
    logical, intent(in) :: green(:)               !! of the elements that can move
    type(cache_t), intent(inout) :: cache
    integer :: i

    do i = 1, size(green)
      cache%element(model%elements%free(i))%green = green(i)
    end do
  end subroutine take_choice

end module scree_strain_choice
