!> The displacement that the iteration of a step begins with.
!>
!> Small strain is linear, so any beginning will do. With Green strain a body that turns by the angle alpha is off by alpha^2/2 if
!> it moves by its velocity alone. So the prediction includes the acceleration of the step before. It is exact for a body that spins
!> freely, because its acceleration has turned with it. A body may turn about a point in it or near it, such as a pendulum or a
!> rocking block. Then only an angle is off, if the body keeps its distance from that point.
!>
!> An impact is no acceleration that goes on. Bodies that move and may touch each other begin with their velocities alone, because
!> another beginning may lead to other states of contacts.
module scree_step_prediction
  use scree_element_term, only: step_rule_t
  use scree_green_strain, only: green_strain
  use scree_inertia, only: kinetic_energy
  use scree_interpolation, only: kept_distance
  use scree_iteration_end, only: turn_by_strain
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_state, only: state_t
  use scree_system, only: last_of_block, values_of
  implicit none
  private
  public :: predict, turns_unstrained

  !> Change of velocity in the step before over the velocity, up to which a body is taken to go on so.
  real(dp), parameter :: most_change = 0.5_dp
  !> Strain of a prediction over the square of what it turns by: by the velocity alone it is 1/2. And the angle by which such a
  !> strain turns an element in a step.
  real(dp), parameter :: unstrained = 0.05_dp, turned = 0.05_dp

contains

  !> Predicts the displacement of a step: by the velocity, and of elements with Green strain by the acceleration too.
  pure subroutine predict(model, cache, state, rule, pair, d, smooth)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(step_rule_t), intent(in) :: rule
    integer, intent(in) :: pair(:, :)          !! (2, n_pairs) elements that something acts between
    real(dp), allocatable, intent(out) :: d(:) !! (n_unknowns)
    logical, allocatable, intent(out) :: smooth(:) !! (n_elements) they begin with their acceleration
    real(dp) :: weight
    logical :: meets(model%n_elements)         !! another that can move
    integer :: from, to, k

    meets = .false.
    do k = 1, size(pair, 2)
      if (all(cache%equations%group_of(pair(:, k)) > 0)) meets(pair(:, k)) = .true.
    end do
    allocate (smooth(model%n_elements), source=.false.)
    d = rule%dt*state%velocity
    weight = (rule%carried_weight + rule%displacement_weight)*rule%dt**2
    from = 1
    associate (free => model%elements%free)
      do while (from <= size(free))
        to = last_of_block(model%elements, from)
        if (goes_on(free(from:to))) then
          smooth(free(from:to)) = .true.
          do k = from, to
            associate (ids => model%elements%unknown(:, free(k)))
              d(ids) = kept_distance(model%model, cache%element(free(k))%kinematics, &
                                     rule%dt*state%velocity(ids) + weight*state%acceleration(ids))
            end associate
          end do
        end if
        from = to + 1
      end do
    end associate

  contains

    !> Whether the acceleration of the elements of a block is taken to go on, and any of them has Green strain.
    pure logical function goes_on(list)
      integer, intent(in) :: list(:)
      real(dp) :: energy, change
      integer :: i

      goes_on = any(cache%element(list)%green) .and. .not. any(meets(list))
      if (.not. goes_on) return
      energy = 0.0_dp
      change = 0.0_dp
      do i = 1, size(list)
        associate (M => cache%element(list(i))%mass_matrix)
          energy = energy + kinetic_energy(M, values_of(model%elements, list(i), state%velocity))
          change = change + kinetic_energy(M, values_of(model%elements, list(i), state%acceleration))
        end associate
      end do
      goes_on = rule%dt**2*change < most_change**2*energy
    end function goes_on

  end subroutine predict

  !> Whether elements turn by a displacement and are not strained by that, as they are by their velocity alone; or so little that
  !> the stress of it turns them by next to nothing.
  pure logical function turns_unstrained(model, cache, member, d, rule, smooth)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    integer, intent(in) :: member(:)           !! elements
    real(dp), intent(in) :: d(:)               !! (n_unknowns)
    type(step_rule_t), intent(in) :: rule
    logical, intent(in) :: smooth              !! they begin with their acceleration
    real(dp) :: theta(4), largest, strain, turn
    integer :: k

    strain = 0.0_dp
    turn = 0.0_dp
    largest = 0.0_dp
    do k = 1, size(member)
      if (.not. cache%element(member(k))%green) cycle
      theta = matmul(cache%element(member(k))%kinematics%gradient, values_of(model%elements, member(k), d))
      strain = max(strain, maxval(abs(green_strain(theta))))
      turn = max(turn, maxval(abs(theta)))
      if (smooth) largest = max(largest, turn_by_strain(cache%element(member(k)), rule))
    end do
    turns_unstrained = strain < unstrained*turn**2 .or. (smooth .and. largest*strain < turned)
  end function turns_unstrained

end module scree_step_prediction
