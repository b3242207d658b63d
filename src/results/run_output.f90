!> Output of a run: the model and its scene at the start, series by step, frames, costs at the end.
module scree_run_output
  use scree_checkpoint, only: checkpoints_t, declare_checkpoints, put_checkpoint
  use scree_classic_output, only: add_classic_frame, begin_classic_output
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_frame_layout, only: layout_t
  use scree_idle_points, only: places_of_points
  use scree_islands, only: size_of_equations, work_of_solutions
  use scree_keyholes, only: polygons_of
  use scree_kinds, only: dp
  use scree_linear_solver, only: solver_work_t
  use scree_made_by, only: fact_t, facts_of_program
  use scree_model, only: cache_t, model_t
  use scree_problem_output, only: store_problem
  use scree_regions, only: joint_between
  use scree_results_file, only: add_frame, add_layout, close_results, expect_place_still, open_results, results_t, &
                                store_rows, store_text, store_words, work_row_t, write_rows, write_where_due
  use scree_run_records, only: declare_records, displacement_of_vertices, kinds_t, put_frame_records, put_step_records, records_t, &
                               velocity_of_vertices
  use scree_run_summary, only: summary_t
  use scree_scene, only: effect_t, kind_of, model_nmm, run_options_t, scene_t, settings_t, word_t
  use scree_setting_table, only: is_given_by
  use scree_state, only: state_t, step_of_run, time_of_run
  use scree_summary_words, only: ending_t, json_of
  use scree_system, only: bolt_end
  use scree_text, only: number_text
  use scree_time_stepper, only: step_report_t
  use scree_watch, only: watch_t
  implicit none
  private
  public :: begin_output, change_layout, end_output, put_frame, put_problems, put_rest, put_step, run_output_t

  !> The results file of a run, and what it is written by.
  type :: run_output_t
    type(results_t) :: file
    type(kinds_t) :: kinds                   !! of all stages of the run, noted before it begins
    type(records_t) :: records
    type(checkpoints_t) :: checkpoints
    integer :: checkpoint_every = 0          !! frames; 0: the last alone has one
    integer :: framed = -1                   !! step of the last frame
    type(layout_t) :: layout                 !! of the next frame
    logical :: has_layout = .false.          !! the file has it
    integer :: n_problems = 0                !! of friction, written so far
  end type run_output_t

contains

  !> Opens the results file and writes what is known before the first frame.
  subroutine begin_output(options, scene, list, model, state, watch, output, error)
    type(run_options_t), intent(in) :: options
    type(scene_t), intent(in) :: scene
    type(effect_t), intent(in) :: list(:)       !! effects that the scene calls for
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state          !! the first
    type(watch_t), intent(in) :: watch
    type(run_output_t), intent(inout) :: output
    type(error_t), allocatable, intent(out) :: error

    output%checkpoint_every = scene%settings%checkpoint_every
    output%layout = layout_of(scene, model, state, options%runs)
    output%layout%changes = output%kinds%parts > 0
    if (output%layout%changes) call refuse_other_files(options, error)
    if (allocated(error)) return
    call open_results(output%file, options%results_path, output%layout, options%with_xdmf, output%kinds%removal, error)
    if (.not. allocated(error)) call describe_scene(output%file, scene, list, options%threads, error)
    if (.not. allocated(error)) call store_parts(output%file, model, state, error)
    if (.not. allocated(error) .and. model%model == model_nmm) call store_covers(output%file, model, state, error)
    if (.not. allocated(error)) call declare_records(output%file, model, output%kinds, output%records, error)
    if (options%runs .and. .not. allocated(error)) &
      call declare_checkpoints(output%file, state, watch, output%checkpoints, error)
    if (options%with_classic .and. options%runs .and. .not. allocated(error)) &
      call begin_classic(output%file, model, output%layout, error)
  end subroutine begin_output

  !> Notes that frames have other polygons from here on, or, of a run that goes on, which they have by now.
  subroutine change_layout(output, model, parent, is_written)
    type(run_output_t), intent(inout) :: output
    type(model_t), intent(in) :: model
    integer, intent(in) :: parent(:)            !! (n_elements) element before that each is part of
    logical, intent(in) :: is_written           !! the file has them
    integer :: of_file(size(parent))            !! likewise of the polygons that the file has

    of_file = parent
    if (.not. output%has_layout .and. .not. is_written) of_file = output%layout%parent(parent)
    call take_polygons(model, model%start, output%layout)
    output%layout%parent = of_file
    output%file%n_corners = size(output%layout%corner)
    output%has_layout = is_written
  end subroutine change_layout

  !> Error where files are asked for whose frames all have the same polygons.
  subroutine refuse_other_files(options, error)
    type(run_options_t), intent(in) :: options
    type(error_t), allocatable, intent(out) :: error

    if (options%with_xdmf) then
      call refuse('--xdmf')
    else if (options%with_classic) then
      call refuse('--classic-output')
    end if

  contains

    !> Error at an option.
    subroutine refuse(option)
      character(len=*), intent(in) :: option

      call fail(error, status_bad_input, option//': expected a scene without &cracks, as its polygons cannot change, found one '// &
                'with them')
    end subroutine refuse

  end subroutine refuse_other_files

  !> A row of each series of the steps. Errors: a number that is not finite; the results file was taken away.
  subroutine put_step(output, model, cache, state, report, error)
    type(run_output_t), intent(inout) :: output
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(step_report_t), intent(in) :: report
    type(error_t), allocatable, intent(out) :: error

    call put_step_records(output%file, output%records, model, cache, state, report, error)
    if (.not. allocated(error)) call expect_place_still(output%file, error)
  end subroutine put_step

  !> The friction problems that a step posed, where they are to be written.
  subroutine put_problems(output, step, cache, error)
    type(run_output_t), intent(inout) :: output
    integer, intent(in) :: step
    type(cache_t), intent(inout) :: cache
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    if (.not. allocated(cache%posed)) return
    do i = 1, size(cache%posed)
      output%n_problems = output%n_problems + 1
      call store_problem(output%file, output%n_problems, step, cache%posed(i), error)
      if (allocated(error)) return
    end do
    deallocate (cache%posed)
  end subroutine put_problems

  !> A frame of the present state, with a checkpoint where one is due.
  subroutine put_frame(output, model, cache, state, watch, error)
    type(run_output_t), intent(inout) :: output
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(watch_t), intent(in) :: watch
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: position(2, size(state%vertex, 2))

    position = state%vertex + spread(model%origin, 2, size(state%vertex, 2))
    call put_frame_records(output%file, output%records, model, cache, state, error)
    if (output%layout%changes .and. .not. (output%has_layout .or. allocated(error))) then
      call add_layout(output%file, output%layout, error)
      output%has_layout = .true.
    end if
    if (allocated(error)) return
    call add_frame(output%file, time_of_run(state), position, displacement_of_vertices(model, state), &
                   velocity_of_vertices(model, cache, state), state%stress, model%present(model%elements%block), error)
    if (allocated(error)) return
    output%framed = step_of_run(state)
    if (checkpoint_is_due(output%file%n_frames - 1, output%checkpoint_every)) then
      call put_checkpoint(output%file, output%checkpoints, output%file%n_frames - 1, state, watch, error)
      if (.not. allocated(error)) call write_rows(output%file, error)
    else
      call write_where_due(output%file, error)
    end if
    if (allocated(error)) return
    if (.not. allocated(output%file%classic)) return
    call add_classic_frame(output%file%classic, position, places_of_points(model, state) + &
                           spread(model%origin, 2, size(state%point, 2)), error)
  end subroutine put_frame

  !> Whether a frame, counted from 0, has a checkpoint.
  pure logical function checkpoint_is_due(frame, every)
    integer, intent(in) :: frame, every !! 0: none has

    checkpoint_is_due = frame > 0 .and. every > 0
    if (checkpoint_is_due) checkpoint_is_due = modulo(frame, every) == 0
  end function checkpoint_is_due

  !> Writes all that waits, with a checkpoint of the last frame.
  subroutine put_rest(output, state, watch, error)
    type(run_output_t), intent(inout) :: output
    type(state_t), intent(in) :: state           !! the last
    type(watch_t), intent(in) :: watch
    type(error_t), allocatable, intent(out) :: error

    if (output%framed < 0) return
    if (output%checkpoints%numbers > 0 .and. output%framed == step_of_run(state) .and. &
        output%checkpoints%step /= step_of_run(state)) &
      call put_checkpoint(output%file, output%checkpoints, output%file%n_frames - 1, state, watch, error)
    if (.not. allocated(error)) call write_rows(output%file, error)
  end subroutine put_rest

  !> Writes how the run ended and what it cost, and closes the file.
  subroutine end_output(output, cache, ending, summary, error)
    type(run_output_t), intent(inout) :: output
    type(cache_t), intent(in) :: cache           !! whose equations were solved
    type(ending_t), intent(in) :: ending
    type(summary_t), allocatable, intent(in) :: summary !! of the steps, where there are some
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: text
    type(solver_work_t) :: work
    integer :: numbers(2)

    numbers = size_of_equations(cache%equations)
    work = work_of_solutions(cache%equations)
    text = ''
    if (allocated(summary)) text = json_of(summary, ending)
    call close_results(output%file, ending%status, text, ending%warning, ending%cost, &
                       [work_row_t('factors by CHOLMOD', work%symmetric_factors), &
                       work_row_t('factors by LU', work%other_factors), &
                       work_row_t('iterations of GMRES', work%iterations), work_row_t('unknowns', numbers(1)), &
                       work_row_t('entries', numbers(2))], error)
  end subroutine end_output

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
                              model%points%kind(:n_marked(model)), model%points%element, error)
  end subroutine begin_classic

  !> The points with the elements that carry them at the start.
  subroutine store_parts(results, model, state, error)
    type(results_t), intent(in) :: results
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(error_t), allocatable, intent(out) :: error
    integer :: n

    n = n_marked(model)
    if (n == 0) return
    call store_rows(results, '/points/kind', [integer ::], .true., '1', '1 fixed, 2 load, 3 measured point', &
                    real(model%points%kind(:n), dp), error)
    if (allocated(error)) return
    call store_rows(results, '/points/place', [2], .false., 'length', 'place at the start', &
                    [state%point(:, :n) + spread(model%origin, 2, n)], error)
    if (allocated(error)) return
    call store_rows(results, '/points/element', [integer ::], .true., '1', 'element that carries it', &
                    real(model%points%element(:n), dp), error)
  end subroutine store_parts

  !> Points that a deck marks: all but the ends of bolts and of edges that are loaded, which are the last.
  pure integer function n_marked(model)
    type(model_t), intent(in) :: model

    n_marked = count(model%points%kind < bolt_end)
  end function n_marked

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
    call store_rows(results, '/covers/of_element', [size(model%elements%cover, 1)], .true., '1', &
                    'covers of each element, counter-clockwise; with order 1 those of nodes, then those of edges', &
                    [real(model%elements%cover, dp)], error)
    if (allocated(error) .or. .not. allocated(model%extension)) return
    allocate (follows(1 + size(model%extension%master, 1), size(model%extension%cover)))
    follows(1, :) = model%extension%cover
    follows(2:, :) = model%extension%master
    call store_rows(results, '/covers/follows', [size(follows, 1)], .true., '1', 'a cover, and those whose field it follows', &
                    [real(follows, dp)], error)
  end subroutine store_covers

  !> Layout of the frames: an element with holes is one polygon with seams.
  function layout_of(scene, model, state, runs) result(layout)
    type(scene_t), intent(in) :: scene
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    logical, intent(in) :: runs
    type(layout_t) :: layout
    real(dp) :: frames, steps
    integer :: k

    call take_polygons(model, state%vertex, layout)
    if (.not. runs) return
    steps = 0.0_dp
    frames = 0.0_dp
    call expect_more(scene%settings)
    do k = 1, size(scene%later)
      call expect_more(scene%later(k)%settings)
    end do
    layout%expected_steps = int(min(steps, 1e9_dp))
    layout%expected_frames = int(min(frames, 1e9_dp))

  contains

    !> Adds the steps and frames of a stage.
    subroutine expect_more(s)
      type(settings_t), intent(in) :: s
      real(dp) :: own

      own = s%most_steps
      if (s%end_time < own*s%step_size) own = s%end_time/s%step_size + 1
      steps = steps + own
      if (s%frame_every > 0) then
        frames = frames + own/s%frame_every + 2
      else
        frames = frames + min(s%end_time, s%most_steps*s%step_size)/max(s%frame_interval, s%frame_spacing) + 2
      end if
    end subroutine expect_more

  end function layout_of

  !> Takes the polygons of a model.
  subroutine take_polygons(model, vertex, layout)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: vertex(:, :)     !! (2, n_vertices) at the start, length
    type(layout_t), intent(inout) :: layout
    integer :: e

    layout%n_vertices = size(vertex, 2)
    call polygons_of(model%elements%shape, vertex, layout%first, layout%corner)
    layout%block = model%elements%block
    layout%material = model%elements%material
    layout%joint = model%elements%shape%joint(layout%corner)
    layout%parent = [(e, e=1, model%n_elements)]
  end subroutine take_polygons

  !> Decks, settings, effects and versions in /scene.
  subroutine describe_scene(results, scene, list, threads, error)
    type(results_t), intent(in) :: results
    type(scene_t), intent(in) :: scene
    type(effect_t), intent(in) :: list(:)
    integer, intent(in) :: threads              !! of small steps
    type(error_t), allocatable, intent(out) :: error
    character(len=max(len(scene%geometry_name), len(scene%analysis_name))) :: deck(2)
    character(len=:), allocatable :: option(:)
    character(len=160) :: effect(size(list)), reason(size(list))
    character(len=19) :: date
    type(fact_t), allocatable :: fact(:)
    integer :: i, now(8), n

    call date_and_time(values=now)
    write (date, '(i4.4,2("-",i2.2),"T",2(i2.2,":"),i2.2)') now(1:3), now(5:7)
    fact = facts_of_program(threads)
    do i = 1, size(fact)
      call store_text(results, trim(fact(i)%name), fact(i)%value, error)
      if (allocated(error)) return
    end do
    call store_text(results, 'date', date, error)
    if (allocated(error)) return
    deck = [character(len=len(deck)) :: scene%geometry_name, scene%analysis_name]
    call store_words(results, '/scene/decks', deck, error)
    if (allocated(error)) return
    n = 1
    do i = 1, size(scene%options)
      n = max(n, len(scene%options(i)%text))
    end do
    allocate (character(len=n) :: option(size(scene%options)))
    do i = 1, size(scene%options)
      option(i) = scene%options(i)%text
    end do
    call store_words(results, '/scene/options', option, error)
    if (allocated(error)) return
    call store_words(results, '/scene/geometry_deck', [scene%geometry_text], error)
    if (allocated(error)) return
    call store_words(results, '/scene/analysis_deck', [scene%analysis_text], error)
    if (allocated(error)) return
    call store_settings(results, '/scene/settings', scene%words, .true., error)
    if (allocated(error)) return
    call store_stages(results, scene, error)
    if (allocated(error)) return
    do i = 1, size(list)
      effect(i) = list(i)%name
      reason(i) = list(i)%because
    end do
    call store_words(results, '/scene/effects', effect, error)
    if (allocated(error)) return
    call store_words(results, '/scene/effect_reasons', reason, error)
  end subroutine describe_scene

  !> Stores the values of settings and where they are from, a text each.
  subroutine store_settings(results, path, words, defaults, error)
    type(results_t), intent(in) :: results
    character(len=*), intent(in) :: path
    type(word_t), intent(in) :: words(:)
    logical, intent(in) :: defaults !! too
    type(error_t), allocatable, intent(out) :: error
    character(len=160) :: text(size(words))
    integer :: i, n

    n = 0
    do i = 1, size(words)
      if (.not. allocated(words(i)%value)) cycle
      if (.not. (defaults .or. is_given_by(words(i)))) cycle
      n = n + 1
      text(n) = words(i)%name//' = '//words(i)%value//'  ('//words(i)%from//')'
    end do
    call store_words(results, path, text(:n), error)
  end subroutine store_settings

  !> Names of the stages in /stages, where there are several, and of each after the first what stands in it.
  subroutine store_stages(results, scene, error)
    type(results_t), intent(in) :: results
    type(scene_t), intent(in) :: scene
    type(error_t), allocatable, intent(out) :: error
    character(len=160) :: name(size(scene%later) + 1)
    character(len=7) :: kind(size(scene%later) + 1)
    integer :: k

    if (size(scene%later) == 0) return
    name(1) = 'stage 1'
    kind(1) = kind_of(scene)
    do k = 1, size(scene%later)
      name(k + 1) = scene%later(k)%settings%stage_name
      kind(k + 1) = kind_of(scene%later(k))
    end do
    call store_words(results, '/stages/name', name, error)
    if (.not. allocated(error)) call store_words(results, '/stages/kind', kind, error)
    do k = 1, size(scene%later)
      if (allocated(error)) return
      call store_settings(results, '/stages/settings_'//number_text(k + 1), scene%later(k)%words, .false., error)
    end do
  end subroutine store_stages

end module scree_run_output
