!> A run: from a scene and its blocks to a results file, step by step, or to its model alone.
module scree_simulation
  use, intrinsic :: iso_fortran_env, only: compiler_version
  use scree_blas, only: blas_kernel
  use scree_block_input, only: blocks_t
  use scree_check_scene, only: warn_of_model
  use scree_classic_output, only: add_classic_frame, begin_classic_output
  use scree_effects, only: effects_t, element_cache_t, cache_of_element
  use scree_energy, only: books_t, close_books
  use scree_equations, only: equations_t, release_equations, set_up_equations
  use scree_errors, only: error_t, fail, status_signal
  use scree_initial_overlaps, only: refuse_overlaps
  use scree_interpolation, only: displacement_matrix
  use scree_interruption, only: heed_signals, signal_name, stop_signal
  use scree_keyholes, only: polygons_of
  use scree_kinds, only: dp
  use scree_progress, only: end_progress, progress_t, set_up_progress, show_step, tell
  use scree_regions, only: first_vertex_of, joint_between, last_vertex_of
  use scree_results_file, only: add_frame, check_targets, close_results, cost_row_t, layout_t, open_results, results_t, &
                                store_rows, store_text, store_words
  use scree_run_records, only: declare_records, put_frame_records, put_step_records, records_t
  use scree_scene, only: effect_t, model_nmm, scene_t
  use scree_set_up, only: set_up
  use scree_settings, only: settings_table
  use scree_shi_control, only: first_size, following_size
  use scree_start, only: begin_motion
  use scree_step_control, only: step_control_t, next_size, begin_control, after_step, at_end, frame_due
  use scree_system, only: state_t, system_t
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
    type(system_t) :: system
    type(state_t) :: state
    type(effects_t) :: effects
    type(effect_t), allocatable :: list(:)
    type(equations_t) :: equations
    type(element_cache_t), allocatable :: share(:)
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
    call prepare(scene, blocks, system, state, effects, list, share, error)
    if (allocated(error)) return
    call refuse_overlaps(scene, blocks, system, error)
    if (allocated(error)) return
    if (runs) then
      call warn_of_model(scene, blocks, system, state, effects, strict, progress, error)
      if (allocated(error)) return
      call set_up_equations(system%elements, system%n_unknowns, equations)
      call begin_motion(system, effects, scene%settings, share, equations, state, error)
      if (allocated(error)) return
    end if
    call stop_phase(timer(phase_set_up))

    call tell_effects(progress, list)
    call heed_signals()
    call start_phase(timer(phase_results))
    layout = layout_of(scene, system, state, runs)
    call begin_results(results_path, with_xdmf, scene, system, state, effects, list, share, layout, results, records, error)
    if (runs .and. with_classic .and. .not. allocated(error)) call begin_classic(results, system, layout, error)
    if (.not. (runs .or. allocated(error))) call put_frame(results, records, system, share, state, state%vertex, error)
    call stop_phase(timer(phase_results))
    if (runs .and. .not. allocated(error)) call run_steps(scene, system, effects, equations, share, state, results, records, &
                                                          progress, timer, error)

    call release_equations(equations)
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

  !> Sets the system up, and what each element contributes.
  subroutine prepare(scene, blocks, system, state, effects, list, share, error)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(system_t), intent(out) :: system
    type(state_t), intent(out) :: state
    type(effects_t), intent(out) :: effects
    type(effect_t), allocatable, intent(out) :: list(:)
    type(element_cache_t), allocatable, intent(out) :: share(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: e

    call set_up(scene, blocks, system, state, effects, list, error)
    if (allocated(error)) return
    allocate (share(system%n_elements))
    do e = 1, system%n_elements
      share(e) = cache_of_element(effects, system, state, e)
    end do
  end subroutine prepare

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
  subroutine begin_results(path, with_xdmf, scene, system, state, effects, list, share, layout, results, records, error)
    character(len=*), intent(in) :: path
    logical, intent(in) :: with_xdmf
    type(scene_t), intent(in) :: scene
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    type(effects_t), intent(in) :: effects
    type(effect_t), intent(in) :: list(:)
    type(element_cache_t), intent(in) :: share(:)
    type(layout_t), intent(in) :: layout
    type(results_t), intent(out) :: results
    type(records_t), intent(out) :: records
    type(error_t), allocatable, intent(out) :: error

    call open_results(results, path, layout, with_xdmf, error)
    if (.not. allocated(error)) call describe_scene(results, scene, list, error)
    if (.not. allocated(error)) call store_parts(results, system, state, layout, error)
    if (.not. allocated(error) .and. system%model == model_nmm) call store_covers(results, system, state, error)
    if (.not. allocated(error)) call declare_records(results, system, effects, state, &
                                                     close_books(system, effects, share, state), records, error)
  end subroutine begin_results

  !> Starts the classic output: the polygons of the frames.
  subroutine begin_classic(results, system, layout, error)
    type(results_t), intent(inout) :: results
    type(system_t), intent(in) :: system
    type(layout_t), intent(in) :: layout
    type(error_t), allocatable, intent(out) :: error
    integer :: before, e, i, joint(size(layout%corner))

    do e = 1, system%n_elements
      before = layout%corner(layout%first(e + 1) - 1)
      do i = layout%first(e), layout%first(e + 1) - 1
        joint(i) = joint_between(system%elements%shape, e, before, layout%corner(i))
        before = layout%corner(i)
      end do
    end do
    allocate (results%classic)
    call begin_classic_output(results%classic, results%path, layout%material, layout%first, layout%corner, joint, &
                              system%points%kind, system%points%element, error)
  end subroutine begin_classic

  !> Joints of the edges, and the points with the elements that carry them.
  subroutine store_parts(results, system, state, layout, error)
    type(results_t), intent(in) :: results
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    type(layout_t), intent(in) :: layout
    type(error_t), allocatable, intent(out) :: error

    call store_rows(results, '/elements/joint', [integer ::], .true., '1', 'joint material of the edge from each vertex to the '// &
                    'next, 0: a line of the mesh', real(system%elements%shape%joint(layout%corner), dp), error)
    if (allocated(error) .or. size(system%points%kind) == 0) return
    call store_rows(results, '/points/kind', [integer ::], .true., '1', '1 fixed, 2 load, 3 measured point', &
                    real(system%points%kind, dp), error)
    if (allocated(error)) return
    call store_rows(results, '/points/place', [2], .false., 'length', 'place at the start', &
                    [state%point + spread(system%origin, 2, size(state%point, 2))], error)
    if (allocated(error)) return
    call store_rows(results, '/points/element', [integer ::], .true., '1', 'element that carries it', &
                    real(system%points%element, dp), error)
  end subroutine store_parts

  !> Covers of manifold elements, from 1, at the start.
  subroutine store_covers(results, system, state, error)
    type(results_t), intent(in) :: results
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: follows(:, :)

    call store_rows(results, '/covers/node', [2], .false., 'length', 'place of the node of each cover', &
                    [state%cover + spread(system%origin, 2, system%n_covers)], error)
    if (allocated(error)) return
    call store_rows(results, '/covers/of_element', [3], .true., '1', 'covers of each element, counter-clockwise', &
                    [real(system%elements%cover, dp)], error)
    if (allocated(error) .or. .not. allocated(system%extension)) return
    allocate (follows(4, size(system%extension%cover)))
    follows(1, :) = system%extension%cover
    follows(2:, :) = system%extension%master
    call store_rows(results, '/covers/follows', [4], .true., '1', 'a cover, and the three whose linear field it follows', &
                    [real(follows, dp)], error)
  end subroutine store_covers

  !> The time loop.
  subroutine run_steps(scene, system, effects, equations, share, state, results, records, progress, timer, error)
    type(scene_t), intent(in) :: scene
    type(system_t), intent(in) :: system
    type(effects_t), intent(inout) :: effects      !! the stiffness of contacts may adapt
    type(equations_t), intent(inout) :: equations
    type(element_cache_t), intent(inout) :: share(:)
    type(state_t), intent(inout) :: state
    type(results_t), intent(inout) :: results
    type(records_t), intent(inout) :: records
    type(progress_t), intent(inout) :: progress
    type(timer_t), intent(inout) :: timer(:)
    type(error_t), allocatable, intent(out) :: error
    type(step_control_t) :: control
    type(step_report_t) :: report
    type(books_t) :: books
    type(watch_t) :: watch
    type(error_t), allocatable :: frame_error
    real(dp) :: at_start(2, size(state%vertex, 2))
    integer :: before, framed !! step before this one, and that of the last frame

    at_start = state%vertex
    control = begin_control(scene%settings)
    if (scene%settings%chooses_step) control%size = first_size(scene, system, state)
    call begin_watch(system, effects, share, state, close_books(system, effects, share, state), watch)
    call put_frame(results, records, system, share, state, at_start, error)
    if (allocated(error)) return
    framed = state%step
    do while (.not. at_end(control, state%time) .and. stop_signal() == 0)
      before = state%step
      call start_phase(timer(phase_steps))
      call advance(system, effects, scene%settings, next_size(control, state%time), equations, share, state, report, error)
      call stop_phase(timer(phase_steps))
      if (allocated(error)) then
        error%message = 'step '//number_text(state%step + 1)//' from time '//rounded_text(state%time)//': '//error%message
        exit
      end if
      if (state%step == before) exit ! a signal came
      call after_step(control, report%dt, report%rejected, state%time)
      if (scene%settings%chooses_step) &
        control%size = following_size(scene, system, state%contacts, report%dt, report%travel)

      books = close_books(system, effects, share, state)
      call check_numbers(system, share, state, books, error)
      if (allocated(error)) then
        error%message = 'step '//number_text(state%step)//' to time '//rounded_text(state%time)//': '//error%message
        return
      end if
      call start_phase(timer(phase_results))
      call put_step_records(results, records, system, share, state, report, books, error)
      if (allocated(error)) return
      if (frame_due(control, state%step, state%time)) then
        call put_frame(results, records, system, share, state, at_start, error)
        framed = state%step
      end if
      call stop_phase(timer(phase_results))
      if (allocated(error)) return
      call watch_step(watch, system, effects, share, state, books, report%work, progress, error)
      if (allocated(error)) then
        error%message = 'step '//number_text(state%step)//' to time '//rounded_text(state%time)//': '//error%message
        exit
      end if
      call show_step(progress, state%step, state%time, &
                     min(scene%settings%end_time, state%time*(scene%settings%most_steps/real(state%step, dp))), report%dt, &
                     report%iterations)
    end do
    if (.not. (allocated(error) .or. at_end(control, state%time))) &
      call fail(error, status_signal + stop_signal(), 'interrupted by '//signal_name(stop_signal())//' after step '// &
                number_text(state%step)//', at time '//rounded_text(state%time)//'; what was done is in '//results%path)
    if (allocated(error) .and. framed < state%step) &
      call put_frame(results, records, system, share, state, at_start, frame_error)
  end subroutine run_steps

  !> A frame of the present state.
  subroutine put_frame(results, records, system, share, state, at_start, error)
    type(results_t), intent(inout) :: results
    type(records_t), intent(in) :: records
    type(system_t), intent(in) :: system
    type(element_cache_t), intent(in) :: share(:)
    type(state_t), intent(in) :: state
    real(dp), intent(in) :: at_start(:, :)  !! (2, n_vertices) places at the start, length
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: position(2, size(state%vertex, 2)), velocity(2, size(state%vertex, 2))
    integer :: e, k

    do e = 1, system%n_elements
      do k = first_vertex_of(system%elements%shape, e), last_vertex_of(system%elements%shape, e)
        position(:, k) = state%vertex(:, k) + system%origin
        velocity(:, k) = matmul(displacement_matrix(share(e)%kinematics, state%vertex(:, k)), &
                                state%velocity(system%elements%unknown(:, e)))
      end do
    end do
    call put_frame_records(results, records, system, share, state, error)
    if (allocated(error)) return
    call add_frame(results, state%time, position, state%vertex - at_start, velocity, state%stress, error)
    if (allocated(error) .or. .not. allocated(results%classic)) return
    call add_classic_frame(results%classic, position, state%point + spread(system%origin, 2, size(state%point, 2)), error)
  end subroutine put_frame

  !> What the frames look like: an element with holes is one polygon with seams. The model alone has one.
  function layout_of(scene, system, state, runs) result(layout)
    type(scene_t), intent(in) :: scene
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    logical, intent(in) :: runs
    type(layout_t) :: layout
    real(dp) :: frames, steps

    layout%n_vertices = size(state%vertex, 2)
    call polygons_of(system%elements%shape, state%vertex, layout%first, layout%corner)
    layout%block = system%elements%block
    layout%material = system%elements%material
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
