!> Sizes of the steps that an accuracy asks for.
!>
!> The accuracy is a bound of the error at the end of the run, relative to the displacement of the scene. The error that all steps
!> so far will have made by then is subtracted. The rest is spread over the remaining time, and gives the error that a step may add
!> per time. So errors that cancel each other leave more to be spent. The constants below are choices, tried on the shipped scenes.
!>
!> The error of a step per time goes with its size to the power of the order of the scheme. Sizes follow it by a controller with a
!> proportional and an integral part (Gustafsson 1991). A step that adds more than four times its allowance is made again, shorter.
!> Steps in which contacts of a block open or close have no order, so such blocks limit no step. A block in flight may be struck too
!> early in a step for the accuracy: then the step is made again to end at the blow.
!>
!> The control of the sizes is in doc/theory/error-estimate.md, eq-step-control.
module scree_accurate_size
  use scree_deviation, only: order_of, remembered_time, step_error_t
  use scree_kinds, only: dp
  use scree_scene, only: settings_t
  use scree_state, only: state_t
  implicit none
  private
  public :: choose_size, excess_of, excess_of_blow, excess_of_impact, first_share, following_factor, latest_blow, least_size

  !> Of the largest step the first has this fraction, as nothing is known before it.
  real(dp), parameter :: first_share = 0.01_dp
  !> Of what is asked, what a step may always add, spread over the time left, whatever those before it took.
  real(dp), parameter :: least_spent = 0.1_dp
  !> Of what is left of it, and of all of it, what the unknown instant of an impact may take.
  real(dp), parameter :: struck = 0.25_dp, least_struck = 0.05_dp
  !> Exponents of the controller.
  real(dp), parameter :: integral = 0.3_dp, proportional = 0.4_dp
  !> Bounds of the size of a step over that of the step before it.
  real(dp), parameter, public :: shrinks = 0.2_dp
  real(dp), parameter :: grows = 1.25_dp
  !> A step over a period that it resolves to an accuracy of 1 with a scheme of order 2: sqrt(12)/(2 pi), rounded.
  real(dp), parameter :: resolved = 0.5_dp

contains

  !> Size of a step over that with which it would add what it may.
  pure real(dp) function excess_of(settings, step, way, state, dt) result(excess)
    type(settings_t), intent(in) :: settings
    type(step_error_t), intent(in) :: step
    real(dp), intent(in) :: way            !! displacement that the accuracy is a fraction of, length
    type(state_t), intent(in) :: state     !! at the end of the step
    real(dp), intent(in) :: dt             !! time
    real(dp) :: left, share

    left = max(dt, settings%end_time - state%time + dt)
    excess = 0.0_dp
    if (any(step%known)) then
      share = max(settings%aim*way - maxval(step%total), least_spent*settings%aim*way)
      excess = (maxval(step%at_end)/(share*dt/left))**(1.0_dp/order_of(settings))
    end if
    share = max(settings%aim - maxval(abs(state%deviation%growth)), least_spent*settings%aim)
    excess = max(excess, maxval(step%growth)/(share*dt/left))
  end function excess_of

  !> Size of a step in which bodies meet over that with which the instant of that may stay unknown.
  pure real(dp) function excess_of_impact(settings, step, way) result(excess)
    type(settings_t), intent(in) :: settings
    type(step_error_t), intent(in) :: step
    real(dp), intent(in) :: way            !! displacement that the accuracy is a fraction of, length

    excess = maxval(step%impact)/max(struck*(settings%aim*way - maxval(step%total + step%impacts)), least_struck*settings%aim*way)
  end function excess_of_impact

  !> What a blow makes in flight, as it acts at the end of the step, over what is left of what is asked, which it may take.
  pure real(dp) function excess_of_blow(settings, step, way) result(excess)
    type(settings_t), intent(in) :: settings
    type(step_error_t), intent(in) :: step !! with what the blow makes in its total
    real(dp), intent(in) :: way            !! displacement that the accuracy is a fraction of, length

    excess = maxval(step%blow)/max(settings%aim*way - maxval(step%total - step%blow), least_struck*settings%aim*way)
  end function excess_of_blow

  !> Fraction of a step that may come after a blow, by half.
  pure real(dp) function latest_blow(step, excess) result(share)
    type(step_error_t), intent(in) :: step
    real(dp), intent(in) :: excess         !! of `excess_of_blow`

    share = 0.0_dp
    if (excess > 0) share = 0.5_dp*(1 - step%struck_at(maxloc(step%blow, dim=1)))/excess
  end function latest_blow

  !> Size of the next step over that of the last, by how much that and the one before it went beyond. Excesses are sizes over a
  !> size, and sizes grow by `grows` at most: an excess that has grown by more is one of errors that come and go, and no trend.
  pure real(dp) function following_factor(excess, before) result(factor)
    real(dp), intent(in) :: excess, before
    real(dp) :: earlier

    factor = grows
    if (.not. excess > 0) return
    earlier = max(before, excess/grows)
    factor = min(grows, max(shrinks, excess**(-integral - proportional)*earlier**proportional))
  end function following_factor

  !> Chooses the size of the next step. One that was shorter, to end at a frame, tells of those that are not.
  pure subroutine choose_size(settings, excess, dt, rejected, known, state)
    type(settings_t), intent(in) :: settings
    real(dp), intent(in) :: excess
    real(dp), intent(in) :: dt              !! size of the last step, time
    integer, intent(in) :: rejected         !! tries of it
    logical, intent(in) :: known            !! its error is known
    type(state_t), intent(inout) :: state
    real(dp) :: longest, size

    longest = min(settings%step_size, grows*state%pace%size)
    if (rejected > 0) longest = dt
    if (known .or. excess > 0) then
      size = dt*following_factor(excess, state%deviation%excess)
      if (.not. excess > 0) size = longest
      state%deviation%excess = excess
    else
      size = state%pace%size
    end if
    state%pace%size = min(longest, max(least_size(settings, state), size))
  end subroutine choose_size

  !> Smallest step that an error asks for, time. Means over `remembered_time` tell motion from ringing at the start, such as that of
  !> contacts that are loaded at once. Until then a step is no shorter than needed to resolve a period of that time.
  pure real(dp) function least_size(settings, state) result(least)
    type(settings_t), intent(in) :: settings
    type(state_t), intent(in) :: state
    real(dp) :: told

    told = remembered_time*settings%end_time
    least = settings%least_step
    if (state%time < told) least = max(least, told*resolved*settings%aim**(1.0_dp/order_of(settings)))
  end function least_size

end module scree_accurate_size
