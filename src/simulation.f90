!> A run: from a scene and its blocks to a results file, stage after stage, step by step, or to its model alone.
module scree_simulation
  use scree_accurate_step, only: advance_estimated
  use scree_block_input, only: blocks_t
  use scree_cache, only: rebuild_cache
  use scree_carry_over, only: take_supports
  use scree_check_scene, only: warn_of_model
  use scree_critical_step, only: find_largest_step
  use scree_departures, only: remove_departed
  use scree_effects, only: refresh_elements, steady_from
  use scree_equilibrium, only: is_balanced, words_of_balance
  use scree_errors, only: error_t, fail, status_signal
  use scree_initial_overlaps, only: refuse_overlaps
  use scree_interruption, only: heed_signals, signal_name, stop_signal
  use scree_islands, only: release_equations
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_growth, only: grow_cracks, resume_cut
  use scree_forecast, only: enough, note_step, probe_t
  use scree_next_stage, only: set_up_next
  use scree_progress, only: check_told, end_progress, progress_t, set_up_progress, tell, tell_whole, warn
  use scree_restart, only: leave_past, open_past, past_run_t, resume_output, take_past
  use scree_results_file, only: abandon_results, take_place
  use scree_results_target, only: check_targets
  use scree_run_records, only: note_kinds
  use scree_run_summary, only: add_step, begin_stage, begin_summary, end_stage, sum_up, summary_t
  use scree_run_output, only: begin_output, change_layout, end_output, put_frame, put_problems, put_rest, put_step, run_output_t
  use scree_scene, only: effect_t, kind_of, order_text, run_options_t, scene_of_stage, scene_t, scheme_central_difference
  use scree_set_up, only: set_up
  use scree_shi_control, only: first_size, following_size
  use scree_sleep, only: advance_awake
  use scree_start, only: begin_run
  use scree_state, only: cracks_t, state_t, step_of_run, time_of_run
  use scree_step_control, only: after_step, at_end, frame_due, has_no_step, is_settled, next_size, share_done
  use scree_step_progress, only: share_of_stage, show_step
  use scree_summary_words, only: ending_t, json_of, lines_of, warning_of_blows, warning_of_error, warning_of_swings
  use scree_text, only: number_text, rounded_text, text_t
  use scree_time_stepper, only: step_report_t
  use scree_timers, only: begin_phase, costs_of, phase_check, phase_frames, phase_history, phase_other, phase_set_up, timers_t
  use scree_trouble, only: trouble_t
  use scree_watch, only: begin_watch, check_numbers, watch_impact, watch_step, watch_t
  implicit none
  private
  public :: simulate

  !> Status of a static run whose steps ran out before it came to rest, and of one that ends as a body moves on and on.
  character(len=*), parameter :: unsettled = 'not in equilibrium', moving = 'moves'

  !> A run as it goes.
  type :: run_t
    type(scene_t) :: scene               !! of the stage
    type(blocks_t) :: blocks             !! as cracks have cut them
    integer :: n_drawn = 0               !! blocks of the decks
    integer :: n_stages = 1
    type(model_t) :: model               !! likewise
    type(model_t), allocatable :: awake  !! the model in which what sleeps cannot move
    type(state_t) :: state
    type(cache_t) :: cache
    type(watch_t) :: watch
    type(run_output_t) :: output
    type(progress_t) :: progress
    type(summary_t), allocatable :: summary !! of its steps
    type(trouble_t) :: cut               !! why a try was cut last
    integer :: threads = 1               !! that small steps may use
    integer :: last_step = huge(1)       !! of the run, after which it pauses
    integer :: framed = 0                !! step of the last frame, or one that none is to follow
    type(probe_t), allocatable :: probe  !! of a run that measures its own time and leaves no results
  end type run_t

contains

  !> Runs a scene to its end and writes the results; or its model alone, one frame with the model as set up.
  !>
  !> With a probe it is left as soon as that has enough, and leaves no file.
  !>
  !> Errors: bad input that only the set-up can see, and a run that fails or that a signal stops; what was written until then stays.
  subroutine simulate(scene, blocks, timers, options, error, probe)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(timers_t), intent(in) :: timers !! of what was done for it before
    type(run_options_t), intent(in) :: options
    type(error_t), allocatable, intent(out) :: error
    type(probe_t), intent(inout), optional :: probe
    type(run_t) :: run
    type(past_run_t) :: past
    type(state_t) :: first
    type(model_t) :: drawn               ! before any crack grew
    integer :: e
    type(effect_t), allocatable :: list(:)

    call check_targets(options%results_path, options%with_xdmf, options%with_classic, error)
    if (allocated(error)) return
    run%cache%timers = timers
    call begin_phase(run%cache%timers, phase_set_up)
    call set_up_progress(options%quiet, run%progress)
    run%n_stages = 1 + size(scene%later)
    if (len(options%restart_path) > 0) call open_past(options%restart_path, scene, past, error)
    if (allocated(error)) return
    call prepare(scene, blocks, options, past, run, list, error)
    if (allocated(error)) then
      call leave_past(past)
      return
    end if
    first = run%state
    drawn = run%model
    if (len(options%restart_path) > 0) then
      if (allocated(past%cracks)) call prepare_cut(past%cracks, run, error)
      if (.not. allocated(error)) call take_past(past, run%scene, run%n_stages, drawn, run%state, run%watch, error)
      if (allocated(error)) then
        call leave_past(past)
        return
      end if
      call take_supports(run%state, run%model)
      call rebuild_cache(run%model, run%state, run%cache)
      run%progress%from = (run%state%stage%number - 1 + share_of_stage(run%scene%settings, run%state))/run%n_stages
      run%progress%shown_tenths = int(10*run%progress%from)
    end if

    call tell(run%progress, 'order of the numbers: '//order_text(scene))
    call tell_effects(run%progress, list)
    if (options%runs) call tell_largest_step(run)
    call heed_signals()
    call begin_phase(run%cache%timers, phase_frames)
    call begin_output(options, scene, list, drawn, first, run%watch, run%output, error)
    if (.not. allocated(error)) then
      if (len(options%restart_path) > 0) then
        call resume_output(past, run%state, run%watch, run%output, error)
        if (run%output%layout%changes) call change_layout(run%output, run%model, [(e, e=1, run%model%n_elements)], .true.)
      else
        call put_frame(run%output, run%model, run%cache, run%state, run%watch, error)
      end if
    end if
    if (.not. allocated(error)) call take_place(run%output%file, error)
    if (allocated(error)) then
      call leave_past(past)
      call abandon_results(run%output%file)
      return
    end if
    call begin_phase(run%cache%timers, phase_other)
    if (present(probe)) run%probe = probe
    run%threads = options%threads
    if (options%steps > 0) run%last_step = step_of_run(run%state) + options%steps
    if (options%runs .and. .not. allocated(error)) call run_stages(scene, run, error)

    call release_equations(run%cache%equations)
    call end_progress(run%progress)
    if (present(probe)) then
      probe = run%probe
      call abandon_results(run%output%file)
    else
      call end_run(options, run, error)
    end if
  end subroutine simulate

  !> Writes how a run ended, and prints its summary.
  subroutine end_run(options, run, error)
    type(run_options_t), intent(in) :: options
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(inout) :: error !! that it ended with, or one of its end
    type(error_t), allocatable :: close_error
    type(ending_t) :: ending
    type(text_t), allocatable :: line(:)
    character(len=:), allocatable :: warning
    integer :: i

    call begin_phase(run%cache%timers, phase_frames)
    call put_rest(run%output, run%state, run%watch, close_error)
    if (allocated(close_error)) close_error%message = reached(run%state)//close_error%message
    if (.not. allocated(error)) call move_alloc(close_error, error)
    call begin_phase(run%cache%timers, phase_other)
    ending%path = options%results_path
    ending%status = status_of(options, run, error)
    call warn_of_loose(run)
    if (index(ending%status, unsettled) == 1 .or. index(ending%status, moving) == 1) call warn(run%progress, ending%status)
    ending%cost = costs_of(run%cache%timers)
    if (allocated(run%summary)) then
      if (run%n_stages > 1) &
        call end_stage(words_of_stage(run), ending%status(:index(ending%status//':', ':') - 1), run%model, run%state, run%summary)
      call sum_up(run%model, run%cache, run%state, run%summary)
      warning = warning_of_blows(run%summary)
      if (len(warning) > 0) call warn(run%progress, warning)
      warning = warning_of_error(run%summary)
      if (len(warning) > 0) call warn(run%progress, warning)
      warning = warning_of_swings(run%summary)
      if (len(warning) > 0) call warn(run%progress, warning)
    end if
    ending%warning = run%progress%warning
    call end_output(run%output, run%cache, ending, run%summary, close_error)
    if (.not. allocated(error)) call move_alloc(close_error, error)
    if (run%output%file%lost) ending%path = ''
    if (.not. allocated(run%summary)) then
      if (.not. allocated(error)) call tell(run%progress, 'results: '//options%results_path)
      return
    end if
    ending%status = status_of(options, run, error)
    if (options%with_json) then
      call tell_whole(run%progress, json_of(run%summary, ending))
    else
      line = lines_of(run%summary, ending)
      do i = 1, size(line)
        call tell(run%progress, line(i)%text)
      end do
    end if
    call check_told(run%progress, options%results_path, close_error)
    if (.not. allocated(error)) call move_alloc(close_error, error)
  end subroutine end_run

  !> How a run ended, in a word, or in those of its error.
  pure function status_of(options, run, error) result(status)
    type(run_options_t), intent(in) :: options
    type(run_t), intent(in) :: run
    type(error_t), allocatable, intent(in) :: error
    character(len=:), allocatable :: status

    status = trim(merge('complete', 'cut     ', options%runs))
    if (.not. allocated(error)) then
      if (.not. allocated(run%summary)) return
      if (pauses(run) .and. .not. (run%state%stage%number == run%n_stages .and. at_end(run%scene%settings, run%state))) &
        status = 'paused'
      if (status == 'paused' .or. .not. allocated(run%summary%balance)) return
      associate (balance => run%summary%balance)
        if (is_at_rest(run)) return
        status = unsettled
        if (balance%moves) status = moving
        status = status//': '
        if (run%n_stages > 1) status = status//words_of_stage(run)//': '
        if (is_balanced(run%model%settings, balance)) then
          status = status//'loads or supports change until time '//rounded_text(run%state%stage%begins + steady_from(run%model))// &
                   ', after the last step; try more steps (step.end_time, step.count, n5)'
        else
          status = status//words_of_balance(balance)
        end if
      end associate
      return
    end if
    status = 'stopped: '//error%message
    if (error%status > status_signal) status = 'interrupted'
  end function status_of

  !> Whether a static run, or a stage of one, has ended in equilibrium: with all its loads, where it asks for that.
  pure logical function is_at_rest(run)
    type(run_t), intent(in) :: run

    is_at_rest = is_balanced(run%model%settings, run%summary%balance)
    if (run%model%settings%balance > 0) is_at_rest = is_at_rest .and. run%state%time >= steady_from(run%model)
  end function is_at_rest

  !> The stage in words.
  pure function words_of_stage(run) result(words)
    type(run_t), intent(in) :: run
    character(len=:), allocatable :: words

    words = 'stage '//number_text(run%state%stage%number)
    if (allocated(run%scene%settings%stage_name)) then
      if (run%scene%settings%stage_name /= words) words = words//' ('//run%scene%settings%stage_name//')'
    end if
  end function words_of_stage

  !> Makes the model and its first state, and begins the run of it where there is to be one. Of what is gone on with, those of its
  !> stage; the effects are those of the first.
  subroutine prepare(scene, blocks, options, past, run, list, error)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(run_options_t), intent(in) :: options
    type(past_run_t), intent(in) :: past
    type(run_t), intent(inout) :: run
    type(effect_t), allocatable, intent(out) :: list(:)
    type(error_t), allocatable, intent(out) :: error
    type(state_t) :: state
    type(model_t) :: model
    type(effect_t), allocatable :: own(:)
    integer :: k

    run%scene = scene_of_stage(scene, past%stage%number, past%stage%begins)
    if (allocated(past%departed)) run%scene%removed(blocks%drawn(past%departed)) = .true.
    run%blocks = blocks
    run%n_drawn = size(blocks%material)
    call set_up(run%scene, blocks, run%model, run%state, list, error)
    if (allocated(error)) return
    call note_kinds(run%model, run%output%kinds)
    do k = 1, run%n_stages
      if (k == past%stage%number) cycle
      call set_up(scene_of_stage(scene, k, past%stage%begins), blocks, model, state, own, error)
      if (allocated(error)) return
      call note_kinds(model, run%output%kinds)
      if (k == 1) list = own
    end do
    call refresh_elements(run%model, run%state, run%cache)
    call refuse_overlaps(scene, blocks, run%model, error)
    if (allocated(error) .or. .not. options%runs) return
    if (past%stage%number == 1) call warn_of_model(run%scene, blocks, run%model, run%state, options%strict, run%progress, error)
    if (allocated(error)) return
    call begin_steps(run, error)
  end subroutine prepare

  !> Makes the model that cracks have cut, of a run that is gone on with.
  subroutine prepare_cut(cracks, run, error)
    type(cracks_t), intent(in) :: cracks
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error

    call resume_cut(run%scene, cracks, run%blocks, run%model, run%state, error)
    if (.not. allocated(error)) call begin_steps(run, error)
  end subroutine prepare_cut

  !> Begins the steps of a stage.
  subroutine begin_steps(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error

    call begin_run(run%model, run%cache, run%state, error)
    if (allocated(error)) return
    if (run%scene%settings%chooses_step) run%state%pace%size = first_size(run%scene, run%model, run%state)
    call begin_watch(run%model, run%cache, run%state, run%watch)
  end subroutine begin_steps

  !> Names the effects.
  subroutine tell_effects(progress, list)
    type(progress_t), intent(inout) :: progress
    type(effect_t), intent(in) :: list(:)
    integer :: i

    do i = 1, size(list)
      call tell(progress, 'effect: '//list(i)%name//' - '//list(i)%because)
    end do
  end subroutine tell_effects

  !> Says how large steps may be, where they are explicit.
  subroutine tell_largest_step(run)
    type(run_t), intent(inout) :: run
    real(dp) :: dt
    integer :: e

    if (run%scene%settings%scheme /= scheme_central_difference) return
    call find_largest_step(run%model, run%cache, dt, e)
    if (e > 0) call tell(run%progress, 'explicit steps: at most '//rounded_text(dt)//', by block '// &
                         number_text(run%model%elements%block(e)))
  end subroutine tell_largest_step

  !> The stages, from the one that the state is in. A stage that asks for equilibrium and does not reach it ends the run.
  subroutine run_stages(scene, run, error)
    type(scene_t), intent(in) :: scene
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error

    run%framed = run%state%step
    allocate (run%summary)
    call begin_summary(run%n_stages, run%model, run%cache, run%state, run%summary)
    do
      if (run%n_stages > 1) call tell_stage(run)
      call run_steps(run, error)
      if (allocated(error) .or. run%state%stage%number == run%n_stages .or. pauses(run)) exit
      if (.not. (at_end(run%scene%settings, run%state) .and. is_settled(run%scene%settings, run%state))) exit
      call begin_next_stage(scene, run, error)
      if (allocated(error)) exit
    end do
  end subroutine run_stages

  !> Says which stage begins or goes on.
  subroutine tell_stage(run)
    type(run_t), intent(inout) :: run

    call tell(run%progress, words_of_stage(run)//' of '//number_text(run%n_stages)//', '//kind_of(run%scene)//', from time '// &
              rounded_text(time_of_run(run%state)))
  end subroutine tell_stage

  !> Goes over to the next stage: its model, and the state that goes on in it.
  subroutine begin_next_stage(scene, run, error)
    type(scene_t), intent(in) :: scene
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error
    type(scene_t) :: next
    type(model_t) :: model
    type(state_t) :: state
    character(len=:), allocatable :: said

    call begin_phase(run%cache%timers, phase_set_up)
    next = scene_of_stage(scene, run%state%stage%number + 1, time_of_run(run%state))
    if (allocated(run%state%departed)) next%removed(run%blocks%drawn(run%state%departed)) = .true.
    call set_up_next(next, run%blocks, run%model, run%state, run%cache, model, state, said, error)
    if (allocated(error)) return
    call warn_of_loose(run)
    call end_stage(words_of_stage(run), verdict_of(run), run%model, run%state, run%summary)
    run%scene = next
    if (len(said) > 0) call tell(run%progress, said)
    if (allocated(run%awake)) deallocate (run%awake)
    run%model = model
    run%state = state
    run%framed = 0
    call begin_steps(run, error)
    if (allocated(error)) then
      error%message = words_of_stage(run)//': '//error%message
      return
    end if
    call begin_stage(run%model, run%state, run%summary)
    call begin_phase(run%cache%timers, phase_other)
  end subroutine begin_next_stage

  !> Warns of blocks that a stage ends without, as they move on and on.
  subroutine warn_of_loose(run)
    type(run_t), intent(inout) :: run
    character(len=:), allocatable :: others

    if (.not. allocated(run%state%settling)) return
    associate (loose => run%state%settling%loose)
      if (.not. any(loose)) return
      others = ''
      if (count(loose) > 1) others = ' and '//number_text(count(loose) - 1)//' others'
      call warn(run%progress, words_of_stage(run)//' ended without block '//number_text(findloc(loose, .true., 1))//others// &
                ', which nothing stops')
    end associate
  end subroutine warn_of_loose

  !> What a stage that others follow came to.
  pure function verdict_of(run) result(verdict)
    type(run_t), intent(in) :: run
    character(len=:), allocatable :: verdict

    verdict = 'complete'
    if (.not. allocated(run%summary%balance)) return
    if (.not. is_at_rest(run)) verdict = unsettled
  end function verdict_of

  !> The time loop. A run that fails or is stopped ends with a frame of its last step.
  subroutine run_steps(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error
    type(error_t), allocatable :: frame_error

    run%model%settings%threads = run%threads
    do while (.not. (allocated(error) .or. has_no_step(run%scene%settings, run%state) .or. pauses(run)) .and. stop_signal() == 0)
      if (allocated(run%probe)) then
        call note_step(share_of_run(run), run%probe)
        if (enough(run%probe)) return
      end if
      call let_cracks_grow(run, error)
      if (.not. allocated(error)) call let_blocks_leave(run, error)
      if (allocated(error) .or. at_end(run%scene%settings, run%state)) exit
      call run_step(run, error)
    end do
    if (allocated(run%probe)) then
      call note_step(share_of_run(run), run%probe)
      run%probe%ended = .not. allocated(error) .and. at_end(run%scene%settings, run%state)
    end if
    if (.not. (allocated(error) .or. at_end(run%scene%settings, run%state) .or. pauses(run))) &
      call fail(error, status_signal + stop_signal(), 'interrupted by '//signal_name(stop_signal())//' after step '// &
                number_text(step_of_run(run%state))//', at time '//rounded_text(time_of_run(run%state))// &
                '; what was done is in '//run%output%file%path)
    if ((allocated(error) .or. pauses(run)) .and. run%framed < run%state%step) &
      call put_frame(run%output, run%model, run%cache, run%state, run%watch, frame_error)
  end subroutine run_steps

  !> Whether the run has made all steps that it was to make before a pause.
  pure logical function pauses(run)
    type(run_t), intent(in) :: run

    pauses = step_of_run(run%state) >= run%last_step
  end function pauses

  !> Lets cracks grow before a step. They do by the state alone, so a run that goes on from there does the same.
  subroutine let_cracks_grow(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error
    logical :: have_grown

    if (.not. run%model%settings%cracks_may_grow()) return
    call begin_phase(run%cache%timers, phase_set_up)
    call grow_cracks(run%scene, run%n_drawn, run%blocks, run%output, run%progress, run%model, run%cache, run%state, run%watch, &
                     have_grown, error)
    if (have_grown .and. allocated(run%awake)) deallocate (run%awake)
    if (allocated(error)) error%message = reached(run%state)//error%message
    call begin_phase(run%cache%timers, phase_other)
  end subroutine let_cracks_grow

  !> Removes the blocks that have left the scene. They do by the state alone, as cracks grow.
  subroutine let_blocks_leave(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error
    logical :: have_left

    if (.not. allocated(run%model%settings%scene_rectangle)) return
    call begin_phase(run%cache%timers, phase_set_up)
    call remove_departed(run%scene, run%blocks, run%output, run%progress, run%model, run%cache, run%state, run%watch, have_left, &
                         error)
    if (have_left .and. allocated(run%awake)) deallocate (run%awake)
    if (allocated(error)) error%message = reached(run%state)//error%message
    call begin_phase(run%cache%timers, phase_other)
  end subroutine let_blocks_leave

  !> Fraction of a run that is done, its stages taken for equally long.
  pure real(dp) function share_of_run(run) result(share)
    type(run_t), intent(in) :: run

    share = (run%state%stage%number - 1 + share_done(run%scene%settings, run%state))/run%n_stages
  end function share_of_run

  !> One step, what is written of it, and a look at what it made.
  subroutine run_step(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error
    type(step_report_t) :: report
    type(error_t), allocatable :: write_error
    type(error_t), allocatable :: nonsense
    integer :: before

    before = run%state%step
    if (allocated(run%state%deviation)) then
      call advance_estimated(run%model, run%awake, run%cache, run%state, report, error)
    else
      call advance_awake(run%model, next_size(run%scene%settings, run%state), run%awake, run%cache, run%state, report, error)
    end if
    call put_problems(run%output, run%state%stage%steps + before + 1, run%cache, write_error)
    if (.not. allocated(error)) call move_alloc(write_error, error)
    if (allocated(error)) then
      if (run%state%step == before) then
        error%message = 'step '//number_text(run%state%stage%steps + before + 1)//' from time '// &
                        rounded_text(time_of_run(run%state))//': '//error%message
      else
        error%message = reached(run%state)//error%message
      end if
      return
    end if
    if (run%state%step == before) return ! a signal came
    call after_step(run%scene%settings, report%dt, report%rejected, run%state)
    if (run%scene%settings%chooses_step) &
      run%state%pace%size = following_size(run%scene, run%model, run%state%contacts, report%dt, report%travel)
    call watch_impact(run%watch, run%model, time_of_run(run%state), report%impact, report%as_one, run%progress)
    call begin_phase(run%cache%timers, phase_check)
    call check_numbers(run%model, run%cache, run%state, error)
    if (.not. allocated(error)) then
      call watch_step(run%watch, run%model, run%cache, run%state, report%work, report%weight_share, run%progress, nonsense)
      call write_step(run, report, error)
      if (.not. allocated(error)) call move_alloc(nonsense, error)
    else
      run%framed = run%state%step ! such numbers are not written
    end if
    if (allocated(error)) then
      error%message = reached(run%state)//error%message
      return
    end if
    call show_step(run%progress, run%n_stages, run%model, run%cache, run%state, report, run%cut)
  end subroutine run_step

  !> The step that was done last, for an error that it ends with.
  pure function reached(state)
    type(state_t), intent(in) :: state
    character(len=:), allocatable :: reached

    reached = 'step '//number_text(step_of_run(state))//' to time '//rounded_text(time_of_run(state))//': '
  end function reached

  !> Writes the series of a step, and its frame where one is due.
  subroutine write_step(run, report, error)
    type(run_t), intent(inout) :: run
    type(step_report_t), intent(in) :: report
    type(error_t), allocatable, intent(out) :: error
    integer :: framed

    call begin_phase(run%cache%timers, phase_history)
    framed = run%framed
    run%framed = run%state%step ! where nothing can be written any more
    call put_step(run%output, run%model, run%cache, run%state, report, error)
    if (allocated(error)) return
    call add_step(run%model, run%state, report, run%summary)
    if (frame_due(run%scene%settings, run%state)) then
      call begin_phase(run%cache%timers, phase_frames)
      call put_frame(run%output, run%model, run%cache, run%state, run%watch, error)
      if (allocated(error)) return
    else
      run%framed = framed
    end if
    call begin_phase(run%cache%timers, phase_other)
  end subroutine write_step

end module scree_simulation
