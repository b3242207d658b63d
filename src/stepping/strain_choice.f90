!> Which elements take Green strain in a step, where the scene leaves that to the step.
!>
!> Small strain is off by what it neglects (`error_of_small_strain`), and contacts between elements of small strain by the turn of
!> an edge times the way along it. Where that exceeds the accuracy asked for an element takes Green strain. The choice changes no
!> part of the state: stress, stiffness and shape follow the displacement of the step in the same way with both, so that there is
!> nothing to convert and nothing to lose.
module scree_strain_choice
  use scree_green_strain, only: error_of_small_strain
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_state, only: state_t
  use scree_system, only: values_of
  implicit none
  private
  public :: add_where_needed, choose_at_start

  !> An element that took Green strain takes small strain again below this share of the accuracy: at half the rotation.
  real(dp), parameter :: enough = 0.25_dp

contains

  !> Elements that take Green strain by the velocities with which a step begins.
  pure subroutine choose_at_start(model, cache, state, dt, green)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    real(dp), intent(in) :: dt                    !! time
    logical, allocatable, intent(out) :: green(:) !! (n_elements)

    green = errors_in_step(model, cache, state%pair, dt*state%velocity) > &
            merge(enough, 1.0_dp, state%green)*model%effects%accuracy
  end subroutine choose_at_start

  !> Adds the elements that small strain turned out not to be enough for, and where there are any those that it hardly was.
  pure subroutine add_where_needed(model, cache, pair, d, green, found)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    integer, intent(in) :: pair(:, :)             !! (2, n_pairs) elements that may touch in the step
    real(dp), intent(in) :: d(:)                  !! (n_unknowns) of the step
    logical, intent(inout) :: green(:)            !! (n_elements)
    logical, intent(out) :: found                 !! some are not what they were
    real(dp) :: error(size(green))

    found = .false.
    if (all(green)) return
    error = errors_in_step(model, cache, pair, d)
    found = any(error > model%effects%accuracy .and. .not. green)
    if (found) green = green .or. error > enough*model%effects%accuracy
  end subroutine add_where_needed

  !> Errors of the small strain of all elements for a displacement, and of the gaps and slips of those that touch, over their size.
  pure function errors_in_step(model, cache, pair, d) result(error)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    integer, intent(in) :: pair(:, :)             !! (2, n_pairs) elements that may touch
    real(dp), intent(in) :: d(:)                  !! (n_unknowns)
    real(dp) :: error(model%n_elements)
    real(dp) :: theta(4), turn(model%n_elements), way(2, model%n_elements), apart
    integer :: e, i

    do e = 1, model%n_elements
      associate (own => cache%element(e), unknown => values_of(model%elements, e, d))
        theta = matmul(own%kinematics%gradient, unknown)
        error(e) = error_of_small_strain(theta, own%stress/own%elasticity(1, 1))
        turn(e) = maxval(abs(theta))
        way(:, e) = matmul(own%kinematics%at_centroid, unknown)
      end associate
    end do
    do i = 1, size(pair, 2)
      associate (a => pair(1, i), b => pair(2, i))
        apart = norm2(way(:, a) - way(:, b))/sqrt(min(cache%element(a)%kinematics%area, cache%element(b)%kinematics%area))
        error(a) = max(error(a), turn(a)*apart)
        error(b) = max(error(b), turn(b)*apart)
      end associate
    end do
  end function errors_in_step

end module scree_strain_choice
