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
!> that changes by a time, and the first correction is that: 12 gamma, 6.75, times what the step is off by.
module scree_iteration_end
  use scree_element_term, only: step_rule_t
  use scree_kinds, only: dp
  use scree_model, only: cache_t, element_cache_t, model_t
  use scree_stiffness, only: small_strain
  use scree_step_try, only: cut_by_deformation, outcome_t, reject
  use scree_system, only: element_unknowns, values_of
  use scree_text, only: number_text
  implicit none
  private
  public :: check_area, check_areas, leaves_nothing, reject_unsettled, turn_by_strain

  !> Shares of the tolerance: of what the next correction may change, which is rounding over many steps; and of its stress that an
  !> element may be off by.
  real(dp), parameter :: share_of_change = 1e-6_dp, share_of_stress = 1e4_dp
  !> Shares of the first correction and of the stress, where that is several times what the step is off by: 2 % of this at most.
  !> With tolerances below the usual one they are less.
  real(dp), parameter :: share_of_first = 3e-3_dp, share_of_moving_stress = 1e-3_dp, usual_tolerance = 1e-10_dp

  !> An area that changes by more than this factor in a step is no iterate worth going on with.
  real(dp), parameter :: largest_area_change = 5.0_dp

contains

  !> Whether a correction by the tangent leaves nothing to the next one: that would change a millionth of the tolerance, and the
  !> stress by a share of 1e4 tolerances; or a small share of what the step is off by, and of the stress.
  !>
  !> The first is much less than the tolerance, as what is left has one sign: with the whole of it a free spin lost 5e-6 of its
  !> angular momentum in 1000 turns of 100 steps, where it loses 2e-12.
  pure logical function leaves_nothing(tolerance, cache, member, rule, change, first, touching) result(nothing)
    real(dp), intent(in) :: tolerance     !! largest change of theta
    type(cache_t), intent(in) :: cache    !! its equations have the correction
    integer, intent(in) :: member(:)      !! elements that settle together
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: change        !! of theta by the correction
    real(dp), intent(in) :: first         !! of theta by the first correction, several times what the step is off by; 0: not known,
                                          !! and where they touch
    logical, intent(in) :: touching       !! contacts or bolts press on them
    real(dp) :: largest, left, share, strain, strained
    integer :: k

    largest = 0.0_dp
    strain = 0.0_dp
    strained = 0.0_dp
    do k = 1, size(member)
      associate (own => cache%element(member(k)))
        largest = max(largest, turn_by_strain(own, rule))
        strained = max(strained, maxval(abs(own%stress))/own%elasticity(1, 1))
        if (first > 0) strain = max(strain, strain_of_correction(cache, member(k)))
      end associate
    end do
    left = change*(change + merge(strained, 0.0_dp, touching))
    nothing = left*max(largest, 1.0_dp) < share_of_change*tolerance .and. left <= share_of_stress*tolerance*strained
    if (nothing .or. .not. first > 0) return
    share = min(tolerance/usual_tolerance, 1.0_dp)
    nothing = change*(change + largest*strain) < share*share_of_first*first &
              .and. left <= share*share_of_moving_stress*strained
  end function leaves_nothing

  !> Largest strain of an element by the last correction.
  pure real(dp) function strain_of_correction(cache, e) result(strain)
    type(cache_t), intent(in) :: cache
    integer, intent(in) :: e
    real(dp) :: own(element_unknowns)
    integer :: i

    do i = 1, element_unknowns
      own(i) = cache%equations%correction(cache%equations%unknown(i, e))
    end do
    strain = maxval(abs(small_strain(matmul(cache%element(e)%kinematics%gradient, own))))
  end function strain_of_correction

  !> The angle by which the stress of a strain turns an element in a step, over that strain.
  pure real(dp) function turn_by_strain(own, rule) result(turn)
    type(element_cache_t), intent(in) :: own
    type(step_rule_t), intent(in) :: rule

    associate (element => own%kinematics)
      turn = own%elasticity(1, 1)*element%area**2*rule%displacement_weight*rule%dt**2 &
             /max(rule%inertia_weight*own%mass*(element%second(1) + element%second(2)), tiny(turn))
    end associate
  end function turn_by_strain

  !> Rejects a try in which an element has not kept a finite area.
  subroutine check_areas(model, cache, member, d, outcome, strays)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    integer, intent(in) :: member(:)
    real(dp), intent(in) :: d(:)
    type(outcome_t), intent(inout) :: outcome
    logical, intent(in), optional :: strays   !! any that is a number will do
    integer :: k

    do k = 1, size(member)
      call check_area(model, cache, member(k), d, outcome, strays)
      if (allocated(outcome%trouble%what)) return
    end do
  end subroutine check_areas

  !> Rejects a try in which an element has not kept a finite area.
  subroutine check_area(model, cache, e, d, outcome, strays)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    integer, intent(in) :: e
    real(dp), intent(in) :: d(:)
    type(outcome_t), intent(inout) :: outcome
    logical, intent(in), optional :: strays   !! any that is a number will do
    real(dp) :: theta(4), ratio

    theta = matmul(cache%element(e)%kinematics%gradient, values_of(model%elements, e, d))
    ratio = (1 + theta(1))*(1 + theta(4)) - theta(2)*theta(3)
    if (ratio < largest_area_change .and. ratio*largest_area_change > 1.0_dp) return ! not so for NaN
    if (present(strays)) then
      if (strays .and. abs(ratio) < huge(ratio)) return
    end if
    call reject(outcome, cut_by_deformation, 'the iteration ran away (its area changed by more than a factor of 5)', &
                'a smaller step.size, and check density, E and loads there', e, cache%element(e)%kinematics%centroid)
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
