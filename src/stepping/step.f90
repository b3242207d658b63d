!> A step of the run, by the integrator of its stage.
module scree_step
  use scree_effects, only: mean_share_of_weight
  use scree_errors, only: error_t
  use scree_integrator, only: step_rule_for
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_small_steps, only: advance_by_small_steps, small_outcome_t
  use scree_state, only: state_t
  use scree_step_checks, only: check_state
  use scree_step_try, only: begin_outcome
  use scree_time_stepper, only: advance_by_solving, step_report_t
  implicit none
  private
  public :: advance

contains

  !> Takes `state` to the end of one step of size `dt`, or of a smaller one.
  !>
  !> Errors: as of `advance_by_solving` and `advance_by_small_steps`.
  subroutine advance(model, dt, cache, state, report, error)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: dt                !! size to try, time
    type(cache_t), intent(inout) :: cache     !! of `state`, at the beginning and at the end
    type(state_t), intent(inout) :: state
    type(step_report_t), intent(out) :: report
    type(error_t), allocatable, intent(out) :: error
    type(small_outcome_t) :: outcome

    if (.not. model%settings%takes_small_steps()) then
      call advance_by_solving(model, dt, cache, state, report, error)
      return
    end if
    call begin_outcome(report%outcome_t)
    report%weight_share = mean_share_of_weight(model, step_rule_for(model%settings, state%step, state%time, state%pace%last, dt))
    call advance_by_small_steps(model, dt, cache, state, outcome, error)
    if (allocated(error)) return
    report%dt = dt
    report%iterations = outcome%steps
    report%solves = outcome%sweeps
    report%work = outcome%work
    if (allocated(outcome%reached)) call move_alloc(outcome%reached, report%reached)
    if (.not. allocated(report%reached)) call check_state(model, state, error)
  end subroutine advance

end module scree_step
