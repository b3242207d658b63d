!> How the iteration of the deformation ends: by the change that the next correction would make, or at an iterate from which no
!> other can follow.
!>
!> A correction by the tangent that changes theta by c leaves forces of second degree, E c^2. They change stretches by c^2. They
!> change the rotation, which inertia alone resists, by k c^2, with k the rotation by a stress in a step over its strain,
!>
!>     k = E area gamma dt^2/(polar moment of inertia).
!>
!> The tangent leaves out what contacts and bolts change by as they turn, s c of s, the stress as a strain. So the next change is
!> about k c (c + s), and the stress is off by less than c (c + s) E.
!>
!> Elastic forces have no torque about the middle of a step, so of the first of these k c e is left, with e the strain of the
!> correction, and c^2. A step that begins with the acceleration of the one before predicts d but for gamma dt^3 times the rate of
!> change of the acceleration. The first correction is that difference: 12 gamma = 6.75 times the error of the step. The remaining
!> forces do a work of at most E area c (c u + (e + c^2) w), with u the strain and w the rotation of the step
!> (doc/theory/kinematics.md, eq-next-correction).
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

  !> Fractions of the tolerance: the change by the next correction, which is rounding over many steps; and the error of the stress
  !> of an element.
  real(dp), parameter :: share_of_change = 1e-6_dp, share_of_stress = 1e4_dp
  !> Fraction of the first correction, which is several times the error of the step: 2 % of the error at most. Fraction of the
  !> energy that the step loses. With tolerances below the usual one they are smaller.
  real(dp), parameter :: share_of_first = 3e-3_dp, share_of_loss = 0.3_dp
  real(dp), parameter :: share_of_moving_stress = 1e-3_dp, usual_tolerance = 1e-10_dp

  !> An area that changes by more than this factor in a step is no iterate worth going on with.
  real(dp), parameter :: largest_area_change = 5.0_dp

contains

  !> Whether a correction by the tangent leaves nothing to the next one, which would change theta by a millionth of the tolerance,
  !> and the stress by 1e4 tolerances, relative.
  !>
  !> The first is much smaller than the tolerance, because the remaining error has one sign. With the whole tolerance a free spin
  !> lost 5e-6 of its angular momentum in 1000 turns of 100 steps; it loses 2e-12.
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

  !> Whether a correction by the tangent leaves little to the next one.
  !>
  !> The next correction must be a small fraction of the error of the step, and of the stress. The work of the remaining forces must
  !> be a fraction of the energy that the step loses, so that the step makes no energy and friction loses no more than it should.
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
