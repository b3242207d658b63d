!> How far a run is, shown after its steps: the time that is left, the fraction that is done, and facts of the last step.
module scree_step_progress
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_progress, only: line_is_due, progress_t, show_line, stays_short, tell
  use scree_run_summary, only: count_moving
  use scree_scene, only: settings_t
  use scree_state, only: state_t, step_of_run
  use scree_step_control, only: at_end, share_done
  use scree_text, only: append, number_text, rounded_text, short_text, text_t
  use scree_time_stepper, only: step_report_t
  use scree_trouble, only: trouble_t, words_of
  implicit none
  private
  public :: share_of_stage, show_step

  integer, parameter :: digits = 4, few_digits = 2 !! of times; of the unbalanced force

contains

  !> Shows how far the run is where it is time for a line, and warns of steps that stay short because tries are cut.
  subroutine show_step(progress, n_stages, model, cache, state, report, cut)
    type(progress_t), intent(inout) :: progress
    integer, intent(in) :: n_stages
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state           !! at the end of the step
    type(step_report_t), intent(in) :: report    !! of the step
    type(trouble_t), intent(inout) :: cut        !! why a try was cut last
    real(dp) :: share

    associate (s => model%settings)
      if (allocated(report%cut%what)) then
        cut = report%cut
      else if (.not. report%dt < s%step_size) then
        cut = trouble_t()
      end if
      share = (state%stage%number - 1 + share_of_stage(s, state))/n_stages
      if (line_is_due(progress, share, .not. at_end(s, state))) &
        call show_line(progress, share, facts_of(model, cache, state, report))
      if (.not. (s%chooses_step .or. s%aim > 0 .or. s%balance > 0) .and. allocated(cut%what)) then
        if (stays_short(progress, report%dt, s%step_size)) call tell(progress, 'steps stay short, '//rounded_text(report%dt)// &
          ' of '//rounded_text(s%step_size)//', as tries are cut: '//words_of(cut, model))
      end if
    end associate
  end subroutine show_step

  !> Fraction of a stage that is done, from 0 to 1.
  !>
  !> A stage that ends in equilibrium comes to it by steps that each take a fraction of the unbalanced force. So at least a fraction
  !> log u/log u_end is done, with u the unbalanced force over the forces on its block, and u_end the value at which the stage ends.
  pure real(dp) function share_of_stage(settings, state) result(share)
    type(settings_t), intent(in) :: settings
    type(state_t), intent(in) :: state

    share = share_done(settings, state)
    if (at_end(settings, state)) share = 1.0_dp
    if (.not. (allocated(state%settling) .and. settings%balance < 1)) return
    if (state%settling%steady) &
      share = max(share, log(max(settings%balance, state%settling%unbalanced))/log(settings%balance))
  end function share_of_stage

  !> Facts of a step, the most important first. The time is that of the stage, as the deck has it. The path of a static run means
  !> nothing, so its time is none of them.
  function facts_of(model, cache, state, report) result(facts)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state           !! at the end of the step
    type(step_report_t), intent(in) :: report    !! of the step
    type(text_t), allocatable :: facts(:)
    integer :: moving

    allocate (facts(0))
    moving = count_moving(model, cache, state, report%balance)
    if (allocated(report%balance)) then
      call append(facts, 'unbalanced '//short_text(report%balance%share, few_digits))
    else
      associate (s => model%settings)
        call append(facts, 'time '//short_text(state%time, digits)//' of '// &
                    short_text(min(s%end_time, state%time*(s%most_steps/real(state%step, dp))), digits))
      end associate
    end if
    call append(facts, 'step '//number_text(step_of_run(state)))
    if (moving >= 0) &
      call append(facts, 'moving '//number_text(moving)//' of '//number_text(size(model%free_block)))
    if (.not. allocated(report%balance)) call append(facts, 'dt '//short_text(report%dt, digits))
    call append(facts, 'iterations '//number_text(report%iterations))
  end function facts_of

end module scree_step_progress
