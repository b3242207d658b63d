!> A step with an estimate of its error, made again where it adds more error than the accuracy allows (`accurate_size`).
module scree_accurate_step
  use scree_accurate_size, only: choose_size, excess_of, excess_of_blow, excess_of_impact, latest_blow, least_size, shrinks
  use scree_block_motion, only: block_motions_t, motions_of
  use scree_cache, only: rebuild_cache
  use scree_deviation, only: estimate_step, order_of, step_error_t, way_of_run
  use scree_errors, only: error_t
  use scree_interruption, only: stop_signal
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_sleep, only: advance_awake
  use scree_state, only: state_t
  use scree_step_control, only: next_size
  use scree_time_stepper, only: step_report_t
  implicit none
  private
  public :: advance_estimated

  !> A step is made again if its error is over this ratio to what it may add. It then aims at a fraction `safety` of that.
  real(dp), parameter :: refused = 4.0_dp, safety = 0.9_dp
  !> A step that would be shorter by no more than this fraction of it is not made again.
  real(dp), parameter :: in_vain = 1e-6_dp

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
    type(block_motions_t) :: before, after
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
      call choose_size(model%settings, excess, report%dt, report%rejected, any(step%known), state)
    end if
  end subroutine advance_estimated

end module scree_accurate_step
