!> A step with an estimate of its error, and steps of the sizes that an accuracy asks for.
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
module scree_accurate_step
  use scree_block_motion, only: motion_t, motions_of
  use scree_cache, only: rebuild_cache
  use scree_deviation, only: estimate_step, order_of, remembered_time, step_error_t, way_of_run
  use scree_errors, only: error_t
  use scree_interruption, only: stop_signal
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_scene, only: settings_t
  use scree_sleep, only: advance_awake
  use scree_state, only: state_t
  use scree_step_control, only: next_size
  use scree_time_stepper, only: step_report_t
  implicit none
  private
  public :: advance_estimated, excess_of, first_share, following_factor

  !> Of the largest step the first has this fraction, as nothing is known before it.
  real(dp), parameter :: first_share = 0.01_dp
  !> Of what is asked, what a step may always add, spread over the time left, whatever those before it took.
  real(dp), parameter :: least_spent = 0.1_dp
  !> Of what is left of it, and of all of it, what the unknown instant of an impact may take.
  real(dp), parameter :: struck = 0.25_dp, least_struck = 0.05_dp
  !> Exponents of the controller, and its bounds.
  real(dp), parameter :: integral = 0.3_dp, proportional = 0.4_dp, shrinks = 0.2_dp, grows = 1.25_dp
  !> Over what a step may add, that has it made again, and what is aimed at then.
  real(dp), parameter :: refused = 4.0_dp, safety = 0.9_dp
  !> A step that would be shorter by no more than this fraction of it is not made again.
  real(dp), parameter :: in_vain = 1e-6_dp
  !> A step over a period that it resolves to an accuracy of 1 with a scheme of order 2: sqrt(12)/(2 pi), rounded.
  real(dp), parameter :: resolved = 0.5_dp

contains

  !> Takes `state` to the end of one step, as `advance` does, with an estimate of its error.
  !>
  !> Errors: as of `advance`.
  subroutine advance_estimated(model, awake, cache, state, report, error)
    type(model_t), intent(in) :: model
    type(model_t), allocatable, intent(inout) :: awake !! the model in which what sleeps cannot move
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(inout) :: state
    type(step_report_t), intent(out) :: report
    type(error_t), allocatable, intent(out) :: error
    type(state_t) :: began
    type(motion_t) :: before, after
    type(step_error_t) :: step
    real(dp) :: again, excess, late, latest, shorter, way
    integer :: tries
    logical :: ends_at_blow

    began = state
    before = motions_of(model, cache, state)
    tries = 0
    ends_at_blow = .false.
    do
      call advance_awake(model, next_size(model%settings, state), awake, cache, state, report, error)
      if (state%step == began%step) state%pace = began%pace ! a signal came: the step is begun anew
      if (allocated(error) .or. state%step == began%step) return
      after = motions_of(model, cache, state)
      call estimate_step(model, before, after, began, state, step)
      report%refused = tries
      if (.not. model%settings%aim > 0) return
      way = way_of_run(model, cache, state, after)
      excess = excess_of(model%settings, step, way, state, report%dt)
      again = max(excess, excess_of_impact(model%settings, step, way))
      late = excess_of_blow(model%settings, step, way)
      if ((again**order_of(model%settings) <= refused .and. late <= 1) .or. &
          shrinks*report%dt < least_size(model%settings, began)) exit
      ends_at_blow = late > again
      latest = latest_blow(step, late)*report%dt
      if (ends_at_blow) then
        shorter = step%struck_at(maxloc(step%blow, dim=1))*report%dt + latest
      else
        shorter = report%dt*max(shrinks, safety/again)
      end if
      if (.not. shorter < (1 - in_vain)*report%dt) exit ! it ends at the blow as it is
      tries = tries + 1
      state = began
      state%pace%size = shorter
      call rebuild_cache(model, state, cache)
      if (allocated(awake)) deallocate (awake)
      if (stop_signal() > 0) then
        state%pace = began%pace
        return
      end if
    end do
    if (ends_at_blow) then
      state%pace%size = max(least_size(model%settings, state), latest) ! what it starts, as lifting off, is as short
    else
      call choose_size(model%settings, excess, report, any(step%known), state)
    end if
  end subroutine advance_estimated

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
  pure subroutine choose_size(settings, excess, report, known, state)
    type(settings_t), intent(in) :: settings
    real(dp), intent(in) :: excess
    type(step_report_t), intent(in) :: report
    logical, intent(in) :: known            !! it was judged
    type(state_t), intent(inout) :: state
    real(dp) :: longest, size

    longest = min(settings%step_size, grows*state%pace%size)
    if (report%rejected > 0) longest = report%dt
    if (known .or. excess > 0) then
      size = report%dt*following_factor(excess, state%deviation%excess)
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

end module scree_accurate_step
