!> How the iteration of the deformation ends: what the next correction would change, told from the last one, or an iterate that no
!> other can come from.
!>
!> A correction by the tangent that changes theta by c leaves forces of second degree, E c^2. They change stretches by c^2, and the
!> rotation, that inertia alone resists, by as much as a stress turns an element in a step over its strain,
!>
!>     k = E area gamma dt^2/(polar moment of inertia).
!>
!> The tangent leaves out what contacts and bolts change by as they turn, s c of s, the stress as a strain. So the next change is
!> about k c (c + s), and the stress is off by less than c (c + s) E.
!>
!> Elastic forces have no torque about the middle of a step, so of the first of these k c e is left, with e the strain of the
!> correction, and c^2. Where the step begins with the acceleration of the one before, d is predicted but for gamma dt^3 times what
!> that changes by a time, and the first correction is that: 12 gamma, 6.75, times what the step is off by. What is left works E
!> area c (c u + (e + c^2) w) at most, u the strain of the step and w what it turns by (doc/theory/kinematics.md,
!> eq-next-correction).
module scree_iteration_end
  use scree_element_term, only: step_rule_t
  use scree_green_strain, only: green_strain
  use scree_inertia, only: kinetic_energy
  use scree_kinds, only: dp
  use scree_model, only: cache_t, element_cache_t, model_t
  use scree_state, only: state_t
  use scree_step_try, only: cut_by_deformation, outcome_t, reject, try_t
  use scree_system, only: element_unknowns, values_of
  use scree_text, only: number_text, real_text
  implicit none
  private
  public :: check_areas, leaves_little, leaves_nothing, reject_unsettled, turn_by_strain

  !> Shares of the tolerance: of what the next correction may change, which is rounding over many steps; and of its stress that an
  !> element may be off by.
  real(dp), parameter :: share_of_change = 1e-6_dp, share_of_stress = 1e4_dp
  !> Shares of the first correction and of the stress, where that is several times what the step is off by: 2 % of this at most; and
  !> of the energy that the step loses. With tolerances below the usual one they are less.
  real(dp), parameter :: share_of_first = 3e-3_dp, share_of_loss = 0.3_dp
  real(dp), parameter :: share_of_moving_stress = 1e-3_dp, usual_tolerance = 1e-10_dp

  !> An area that changes by more than this factor in a step is no iterate worth going on with.
  real(dp), parameter :: largest_area_change = 5.0_dp

contains

  !> Whether a correction by the tangent leaves nothing to the next one: that would change a millionth of the tolerance, and the
  !> stress by a share of 1e4 tolerances.
  !>
  !> The first is much less than the tolerance, as what is left has one sign: with the whole of it a free spin lost 5e-6 of its
  !> angular momentum in 1000 turns of 100 steps, where it loses 2e-12.
  pure logical function leaves_nothing(model, cache, try, change)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(try_t), intent(in) :: try
    real(dp), intent(in) :: change        !! of theta by the correction
    real(dp) :: largest, left, strained
    integer :: k

    largest = 1.0_dp
    strained = 0.0_dp
    do k = 1, size(try%group%member)
      associate (own => cache%element(try%group%member(k)))
        largest = max(largest, turn_by_strain(own, try%rule))
        strained = max(strained, stress_as_strain(own))
      end associate
    end do
    left = change*(change + merge(strained, 0.0_dp, try%group%in_contact .or. try%group%bolted))
    associate (tolerance => model%settings%tolerance)
      leaves_nothing = left*largest < share_of_change*tolerance .and. left <= share_of_stress*tolerance*strained
    end associate
  end function leaves_nothing

  !> Whether a correction by the tangent leaves little to the next one: a small share of what the step is off by, and of the stress;
  !> and forces whose work is a share of what the step loses, so that it makes no energy, and friction takes no more than is lost.
  pure logical function leaves_little(model, cache, state, try, change)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache    !! its equations have the correction
    type(state_t), intent(in) :: state    !! at the beginning of the step
    type(try_t), intent(in) :: try        !! whose first correction is several times what the step is off by
    real(dp), intent(in) :: change        !! of theta by the correction
    real(dp) :: largest, share, corrected, left, lost, strained, worst, now(4), before(4)
    integer :: k

    largest = 0.0_dp
    worst = 0.0_dp
    left = 0.0_dp
    lost = 0.0_dp
    strained = 0.0_dp
    do k = 1, size(try%group%member)
      associate (e => try%group%member(k), own => cache%element(try%group%member(k)), &
                 gradient => cache%element(try%group%member(k))%kinematics%gradient)
        now = matmul(gradient, values_of(model%elements, e, try%d))
        before = now - matmul(gradient, values_of(model%elements, e, cache%equations%correction))
        corrected = maxval(abs(green_strain(now) - green_strain(before)))
        left = left + own%kinematics%area*own%elasticity(1, 1)*change*(change*maxval(abs(green_strain(now))) &
                                                                       + (corrected + change**2)*maxval(abs(now)))
        lost = lost + lost_by_step(model, own, state, e, try)
        worst = max(worst, corrected)
        largest = max(largest, turn_by_strain(own, try%rule))
        strained = max(strained, stress_as_strain(own))
      end associate
    end do
    share = min(model%settings%tolerance/usual_tolerance, 1.0_dp)
    leaves_little = change*(change + largest*worst) < share*share_of_first*try%iteration%first_change &
                    .and. change**2 <= share*share_of_moving_stress*strained .and. left < share*share_of_loss*lost
  end function leaves_little

  !> Energy that an element loses in a step that ends where its try is, by its change of acceleration (doc/theory/integrators.md,
  !> eq-held-energy).
  pure real(dp) function lost_by_step(model, own, state, e, try) result(lost)
    type(model_t), intent(in) :: model
    type(element_cache_t), intent(in) :: own
    type(state_t), intent(in) :: state    !! at the beginning of the step
    integer, intent(in) :: e
    type(try_t), intent(in) :: try
    real(dp) :: change(element_unknowns)  ! of the acceleration

    associate (rule => try%rule)
      change = (values_of(model%elements, e, try%d) - rule%dt*values_of(model%elements, e, state%velocity)) &
               /(rule%displacement_weight*rule%dt**2) &
               - (rule%carried_weight/rule%displacement_weight + 1)*values_of(model%elements, e, state%acceleration)
      lost = (rule%displacement_weight - 0.5_dp)*rule%dt**2*kinetic_energy(own%mass_matrix, change)
    end associate
  end function lost_by_step

  !> Largest stress of an element, over what resists a strain.
  pure real(dp) function stress_as_strain(own)
    type(element_cache_t), intent(in) :: own

    stress_as_strain = maxval(abs(own%stress))/own%elasticity(1, 1)
  end function stress_as_strain

  !> The angle by which the stress of a strain turns an element in a step, over that strain.
  pure real(dp) function turn_by_strain(own, rule) result(turn)
    type(element_cache_t), intent(in) :: own
    type(step_rule_t), intent(in) :: rule

    associate (element => own%kinematics)
      turn = own%elasticity(1, 1)*element%area**2*rule%displacement_weight*rule%dt**2 &
             /max(rule%inertia_weight*own%mass*(element%second(1) + element%second(2)), tiny(turn))
    end associate
  end function turn_by_strain

  !> Rejects a try in which an element that settles now has not kept a finite area.
  subroutine check_areas(model, cache, try, of_iterate)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(try_t), intent(inout) :: try
    logical, intent(in) :: of_iterate         !! any that is a number will do, where iterates may stray
    integer :: k

    do k = 1, size(try%group%member)
      call check_area(model, cache, k, of_iterate, try)
      if (allocated(try%outcome%trouble%what)) return
    end do
  end subroutine check_areas

  !> Rejects a try in which one of these elements has not.
  subroutine check_area(model, cache, k, of_iterate, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    integer, intent(in) :: k                  !! of the members
    logical, intent(in) :: of_iterate
    type(try_t), intent(inout) :: try
    real(dp) :: theta(4), ratio

    associate (e => try%group%member(k))
      theta = matmul(cache%element(e)%kinematics%gradient, values_of(model%elements, e, try%d))
      ratio = (1 + theta(1))*(1 + theta(4)) - theta(2)*theta(3)
      if (ratio < largest_area_change .and. ratio*largest_area_change > 1.0_dp) return ! not so for NaN
      if (of_iterate .and. try%group%may_stray .and. abs(ratio) < huge(ratio)) return
      call reject(try%outcome, cut_by_deformation, 'the iteration ran away (its area changed by more than a factor of '// &
                  real_text(largest_area_change)//')', 'a smaller step.size, and check density, E and loads there', &
                  e, cache%element(e)%kinematics%centroid)
    end associate
  end subroutine check_area

  !> Rejects a try whose deformation did not settle.
  subroutine reject_unsettled(cache, e, outcome)
    type(cache_t), intent(in) :: cache
    integer, intent(in) :: e       !! element that changed most
    type(outcome_t), intent(inout) :: outcome

    call reject(outcome, cut_by_deformation, 'the deformation did not settle in '//number_text(outcome%iterations)//' iterations', &
                'iteration.method=newton or a larger iteration.most, and check E, density and loads there', e, &
                cache%element(e)%kinematics%centroid)
  end subroutine reject_unsettled

end module scree_iteration_end
