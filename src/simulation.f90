!> A run: from a scene and its blocks to a results file, step by step, or to its model alone.
module scree_simulation
  use, intrinsic :: iso_fortran_env, only: compiler_version
  use scree_blas, only: blas_kernel
  use scree_block_input, only: blocks_t
  use scree_check_scene, only: warn_of_model
  use scree_classic_output, only: add_classic_frame, begin_classic_output
  use scree_effects, only: refresh_elements
  use scree_equations, only: release_equations
  use scree_errors, only: error_t, fail, status_signal
  use scree_initial_overlaps, only: refuse_overlaps
  use scree_interpolation, only: displacement_matrix
  use scree_interruption, only: heed_signals, signal_name, stop_signal
  use scree_keyholes, only: polygons_of
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_progress, only: end_progress, progress_t, set_up_progress, show_step, tell
  use scree_regions, only: first_vertex_of, joint_between, last_vertex_of
  use scree_results_file, only: add_frame, check_targets, close_results, cost_row_t, layout_t, open_results, results_t, &
                                store_rows, store_text, store_words
  use scree_run_records, only: declare_records, put_frame_records, put_step_records, records_t
  use scree_scene, only: effect_t, model_nmm, scene_t
  use scree_set_up, only: set_up
  use scree_settings, only: settings_table
  use scree_shi_control, only: first_size, following_size
  use scree_start, only: begin_run
  use scree_state, only: state_t
  use scree_step_control, only: after_step, at_end, frame_due, next_size
  use scree_time_stepper, only: advance, step_report_t
  use scree_timers, only: start_phase, stop_phase, timer_t
  use scree_text, only: number_text, rounded_text
  use scree_watch, only: begin_watch, check_numbers, watch_step, watch_t
  implicit none
  private
  public :: simulate, version

  character(len=*), parameter :: version = '0.1.0'

  integer, parameter :: phase_read = 1, phase_set_up = 2, phase_steps = 3, phase_results = 4
  character(len=*), parameter :: phase_name(4) = [character(len=12) :: 'read', 'set-up', 'steps', 'results']

contains

  !> Runs a scene to its end and writes the results; or its model alone, one frame with the system as set up.
  !>
  !> Errors: bad input that only the set-up can see, and a run that fails or that a signal stops; what was written until then stays.
  subroutine simulate(scene, blocks, reading, results_path, runs, with_xdmf, with_classic, quiet, strict, error)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(timer_t), intent(in) :: reading !! what reading the decks and making the blocks took
    character(len=*), intent(in) :: results_path
    logical, intent(in) :: runs         !! else the model alone
    logical, intent(in) :: with_xdmf
    logical, intent(in) :: with_classic !! output of a run in Shi's form
    logical, intent(in) :: quiet
    logical, intent(in) :: strict       !! a model that calls for warnings does not run
    type(error_t), allocatable, intent(out) :: error
    type(model_t) :: model
    type(state_t) :: state
    type(cache_t) :: cache
    type(effect_t), allocatable :: list(:)
    type(layout_t) :: layout
    type(results_t) :: results
    type(records_t) :: records
    type(progress_t) :: progress
    type(timer_t) :: timer(size(phase_name))
    type(error_t), allocatable :: close_error
    character(len=:), allocatable :: status

    call check_targets(results_path, with_xdmf, with_classic, error)
    if (allocated(error)) return
    timer(phase_read) = reading
    call set_up_progress(quiet, progress)
    call start_phase(timer(phase_set_up))
    call set_up(scene, blocks, model, state, list, error)
    if (allocated(error)) return
    call refresh_elements(model, state, cache)
    call refuse_overlaps(scene, blocks, model, error)
    if (allocated(error)) return
    if (runs) then
      call warn_of_model(scene, blocks, model, state, strict, progress, error)
      if (allocated(error)) return
      call begin_run(model, cache, state, error)
      if (allocated(error)) return
      if (scene%settings%chooses_step) state%pace%size = first_size(scene, model, state)
    end if
    call stop_phase(timer(phase_set_up))

    call tell_effects(progress, list)
    call heed_signals()
    call start_phase(timer(phase_results))
    layout = layout_of(scene, model, state, runs)
    call begin_results(results_path, with_xdmf, scene, model, state, list, layout, results, records, error)
    if (runs .and. with_classic .and. .not. allocated(error)) call begin_classic(results, model, layout, error)
    if (.not. (runs .or. allocated(error))) call put_frame(results, records, model, cache, state, error)
    call stop_phase(timer(phase_results))
    if (runs .and. .not. allocated(error)) call run_steps(scene, model, cache, state, results, records, &
                                                          progress, timer, error)

    call release_equations(cache%equations)
    call end_progress(progress)
    if (allocated(error)) then
      status = 'stopped: '//error%message
      if (error%status > status_signal) status = 'interrupted'
      call close_results(results, status, costs(timer), close_error)
    else
      call close_results(results, trim(merge('complete', 'cut     ', runs)), costs(timer), error)
      if (.not. allocated(error)) call tell(progress, 'results: '//results_path)
    end if

  end subroutine simulate

  !> Names the effects.
  subroutine tell_effects(progress, list)
    type(progress_t), intent(inout) :: progress
    type(effect_t), intent(in) :: list(:)
    integer :: i

    do i = 1, size(list)
      call tell(progress, 'effect: '//list(i)%name//' - '//list(i)%because)
    end do
  end subroutine tell_effects

  !> Opens the results file and writes what is known before the first frame.
  subroutine begin_results(path, with_xdmf, scene, model, state, list, layout, results, records, error)
    character(len=*), intent(in) :: path
    logical, intent(in) :: with_xdmf
    type(scene_t), intent(in) :: scene
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(effect_t), intent(in) :: list(:)
    type(layout_t), intent(in) :: layout
    type(results_t), intent(out) :: results
    type(records_t), intent(out) :: records
    type(error_t), allocatable, intent(out) :: error

    call open_results(results, path, layout, with_xdmf, error)
    if (.not. allocated(error)) call describe_scene(results, scene, list, error)
    if (.not. allocated(error)) call store_parts(results, model, state, layout, error)
    if (.not. allocated(error) .and. model%model == model_nmm) call store_covers(results, model, state, error)
    if (.not. allocated(error)) call declare_records(results, model, records, error)
  end subroutine begin_results

  !> Starts the classic output: the polygons of the frames.
  subroutine begin_classic(results, model, layout, error)
    type(results_t), intent(inout) :: results
    type(model_t), intent(in) :: model
    type(layout_t), intent(in) :: layout
    type(error_t), allocatable, intent(out) :: error
    integer :: before, e, i, joint(size(layout%corner))

    do e = 1, model%n_elements
      before = layout%corner(layout%first(e + 1) - 1)
      do i = layout%first(e), layout%first(e + 1) - 1
        joint(i) = joint_between(model%elements%shape, e, before, layout%corner(i))
        before = layout%corner(i)
      end do
    end do
    allocate (results%classic)
    call begin_classic_output(results%classic, results%path, layout%material, layout%first, layout%corner, joint, &
                              model%points%kind, model%points%element, error)
  end subroutine begin_classic

  !> Joints of the edges, and the points with the elements that carry them.
  subroutine store_parts(results, model, state, layout, error)
    type(results_t), intent(in) :: results
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(layout_t), intent(in) :: layout
    type(error_t), allocatable, intent(out) :: error

    call store_rows(results, '/elements/joint', [integer ::], .true., '1', 'joint material of the edge from each vertex to the '// &
                    'next, 0: a line of the mesh', real(model%elements%shape%joint(layout%corner), dp), error)
    if (allocated(error) .or. size(model%points%kind) == 0) return
    call store_rows(results, '/points/kind', [integer ::], .true., '1', '1 fixed, 2 load, 3 measured point', &
                    real(model%points%kind, dp), error)
    if (allocated(error)) return
    call store_rows(results, '/points/place', [2], .false., 'length', 'place at the start', &
                    [state%point + spread(model%origin, 2, size(state%point, 2))], error)
    if (allocated(error)) return
    call store_rows(results, '/points/element', [integer ::], .true., '1', 'element that carries it', &
                    real(model%points%element, dp), error)
  end subroutine store_parts

  !> Covers of manifold elements, from 1, at the start.
  subroutine store_covers(results, model, state, error)
    type(results_t), intent(in) :: results
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: follows(:, :)

    call store_rows(results, '/covers/node', [2], .false., 'length', 'place of the node of each cover', &
                    [state%cover + spread(model%origin, 2, model%n_covers)], error)
    if (allocated(error)) return
    call store_rows(results, '/covers/of_element', [3], .true., '1', 'covers of each element, counter-clockwise', &
                    [real(model%elements%cover, dp)], error)
    if (allocated(error) .or. .not. allocated(model%extension)) return
    allocate (follows(4, size(model%extension%cover)))
    follows(1, :) = model%extension%cover
    follows(2:, :) = model%extension%master
    call store_rows(results, '/covers/follows', [4], .true., '1', 'a cover, and the three whose linear field it follows', &
                    [real(follows, dp)], error)
  end subroutine store_covers

  !> The time loop.
  subroutine run_steps(scene, model, cache, state, results, records, progress, timer, error)
    type(scene_t), intent(in) :: scene
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(inout) :: state
    type(results_t), intent(inout) :: results
    type(records_t), intent(inout) :: records
    type(progress_t), intent(inout) :: progress
    type(timer_t), intent(inout) :: timer(:)
    type(error_t), allocatable, intent(out) :: error
    type(step_report_t) :: report
    type(watch_t) :: watch
    type(error_t), allocatable :: frame_error
    integer :: before, framed !! step before this one, and that of the last frame

    call begin_watch(model, cache, state, watch)
    call put_frame(results, records, model, cache, state, error)
    if (allocated(error)) return
    framed = state%step
    do while (.not. at_end(scene%settings, state) .and. stop_signal() == 0)
      before = state%step
      call start_phase(timer(phase_steps))
      call advance(model, next_size(scene%settings, state), cache, state, report, error)
      call stop_phase(timer(phase_steps))
      if (allocated(error)) then
        error%message = 'step '//number_text(state%step + 1)//' from time '//rounded_text(state%time)//': '//error%message
        exit
      end if
      if (state%step == before) exit ! a signal came
      call after_step(scene%settings, report%dt, report%rejected, state)
      if (scene%settings%chooses_step) &
        state%pace%size = following_size(scene, model, state%contacts, report%dt, report%travel)

      call check_numbers(model, cache, state, error)
      if (allocated(error)) then
        error%message = 'step '//number_text(state%step)//' to time '//rounded_text(state%time)//': '//error%message
        return
      end if
      call start_phase(timer(phase_results))
      call put_step_records(results, records, model, cache, state, report, error)
      if (allocated(error)) return
      if (frame_due(scene%settings, state)) then
        call put_frame(results, records, model, cache, state, error)
        framed = state%step
      end if
      call stop_phase(timer(phase_results))
      if (allocated(error)) return
      call watch_step(watch, model, cache, state, report%work, progress, error)
      if (allocated(error)) then
        error%message = 'step '//number_text(state%step)//' to time '//rounded_text(state%time)//': '//error%message
        exit
      end if
      call show_step(progress, state%step, state%time, &
                     min(scene%settings%end_time, state%time*(scene%settings%most_steps/real(state%step, dp))), report%dt, &
                     report%iterations)
    end do
    if (.not. (allocated(error) .or. at_end(scene%settings, state))) &
      call fail(error, status_signal + stop_signal(), 'interrupted by '//signal_name(stop_signal())//' after step '// &
                number_text(state%step)//', at time '//rounded_text(state%time)//'; what was done is in '//results%path)
    if (allocated(error) .and. framed < state%step) &
      call put_frame(results, records, model, cache, state, frame_error)
  end subroutine run_steps

  !> A frame of the present state.
  subroutine put_frame(results, records, model, cache, state, error)
    type(results_t), intent(inout) :: results
    type(records_t), intent(in) :: records
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: position(2, size(state%vertex, 2)), velocity(2, size(state%vertex, 2))
    integer :: e, k

    do e = 1, model%n_elements
      do k = first_vertex_of(model%elements%shape, e), last_vertex_of(model%elements%shape, e)
        position(:, k) = state%vertex(:, k) + model%origin
        velocity(:, k) = matmul(displacement_matrix(cache%element(e)%kinematics, state%vertex(:, k)), &
                                state%velocity(model%elements%unknown(:, e)))
      end do
    end do
    call put_frame_records(results, records, model, cache, state, error)
    if (allocated(error)) return
    call add_frame(results, state%time, position, state%vertex - model%start, velocity, state%stress, error)
    if (allocated(error) .or. .not. allocated(results%classic)) return
    call add_classic_frame(results%classic, position, state%point + spread(model%origin, 2, size(state%point, 2)), error)
  end subroutine put_frame

  !> What the frames look like: an element with holes is one polygon with seams. The model alone has one.
  function layout_of(scene, model, state, runs) result(layout)
    type(scene_t), intent(in) :: scene
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    logical, intent(in) :: runs
    type(layout_t) :: layout
    real(dp) :: frames, steps

    layout%n_vertices = size(state%vertex, 2)
    call polygons_of(model%elements%shape, state%vertex, layout%first, layout%corner)
    layout%block = model%elements%block
    layout%material = model%elements%material
    if (.not. runs) return
    associate (s => scene%settings)
      steps = s%most_steps
      if (s%end_time < steps*s%step_size) steps = s%end_time/s%step_size + 1
      if (s%frame_every > 0) then
        frames = steps/s%frame_every + 2
      else
        frames = min(s%end_time, s%most_steps*s%step_size)/max(s%frame_interval, s%frame_spacing) + 2
      end if
    end associate
    layout%expected_steps = int(min(steps, 1e9_dp))
    layout%expected_frames = int(min(frames, 1e9_dp))
  end function layout_of

  !> Decks, settings, effects and versions in /scene.
  subroutine describe_scene(results, scene, list, error)
    type(results_t), intent(in) :: results
    type(scene_t), intent(in) :: scene
    type(effect_t), intent(in) :: list(:)
    type(error_t), allocatable, intent(out) :: error
    character(len=160) :: word(size(settings_table)), effect(size(list)), reason(size(list))
    character(len=19) :: date
    integer :: i, now(8), n

    call date_and_time(values=now)
    write (date, '(i4.4,2("-",i2.2),"T",2(i2.2,":"),i2.2)') now(1:3), now(5:7)
    call store_text(results, 'version', 'scree '//version, error)
    if (allocated(error)) return
    call store_text(results, 'compiler', compiler_version(), error)
    if (allocated(error)) return
    call store_text(results, 'blas', blas_kernel(), error)
    if (allocated(error)) return
    call store_text(results, 'date', date, error)
    if (allocated(error)) return
    call store_words(results, '/scene/geometry_deck', [scene%geometry_text], error)
    if (allocated(error)) return
    call store_words(results, '/scene/analysis_deck', [scene%analysis_text], error)
    if (allocated(error)) return
    n = 0
    do i = 1, size(settings_table)
      if (.not. allocated(scene%words(i)%value)) cycle
      n = n + 1
      word(n) = trim(settings_table(i)%group)//'.'//trim(settings_table(i)%name)//' = '//scene%words(i)%value// &
                '  ('//scene%words(i)%from//')'
    end do
    call store_words(results, '/scene/settings', word(:n), error)
    if (allocated(error)) return
    do i = 1, size(list)
      effect(i) = list(i)%name
      reason(i) = list(i)%because
    end do
    call store_words(results, '/scene/effects', effect, error)
    if (allocated(error)) return
    call store_words(results, '/scene/effect_reasons', reason, error)
  end subroutine describe_scene

  !> The table of costs.
  function costs(timer) result(rows)
    type(timer_t), intent(in) :: timer(:)
    type(cost_row_t), allocatable :: rows(:)
    integer :: i

    rows = [(cost_row_t(phase_name(i), timer(i)%calls, timer(i)%wall, timer(i)%processor), i=1, size(timer))]
    rows = pack(rows, timer%calls > 0)
  end function costs

end module scree_simulation
