!> Going on with a run from the last checkpoint of its results file (doc/running.md).
!>
!> The new file begins with the rows of the old one up to the checkpoint, and with the checkpoint. Only then does it take the place
!> of the old one. So a results file is always that of one run, and there is always one to go on from.
module scree_restart
  use hdf5, only: h5iget_name_f, hid_t, hsize_t, size_t
  use scree_checkpoint, only: components_of, put_checkpoint, take_beginning, take_checkpoint
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_file_lock, only: is_locked
  use scree_hdf5_reading, only: close_for_reading, count_rows, open_for_reading, read_attribute, read_count, read_rows, read_words
  use scree_hdf5_writing, only: append_rows, rows_t
  use scree_kinds, only: dp
  use scree_made_by, only: version
  use scree_model, only: model_t
  use scree_results_file, only: count_frames, make_room, results_t
  use scree_run_output, only: run_output_t
  use scree_scene, only: scene_t
  use scree_stages, only: end_of_stage_prefix
  use scree_sleep, only: wake_all
  use scree_state, only: cracks_t, stage_clock_t, state_t, step_of_run, time_of_run
  use scree_step_control, only: at_end, has_no_step, is_settled, resume_pace
  use scree_text, only: append, number_text, rounded_text, text_t
  use scree_watch, only: watch_t
  use scree_xdmf, only: add_xdmf_frame
  implicit none
  private
  public :: find_decks, leave_past, open_past, past_run_t, resume_output, take_past

  !> Datasets of the checkpoints: three with a row each, and the numbers of all.
  character(len=*), parameter :: of_checkpoint(4) = [character(len=7) :: 'frame', 'end', 'rows', 'numbers']

  !> Settings that say how a run goes on, and strengths of joints. All others made the model, the state or the series of results.
  character(len=*), parameter :: may_change(*) = [character(len=23) :: 'step.size', 'step.end_time', 'step.count', 'step.travel', &
                                                  'step.least', 'step.balance', 'step.past_peak', 'output.every', &
                                                  'output.interval', 'output.problems', 'output.checkpoint', 'joints.phi', &
                                                  'joints.cohesion', 'joints.tensile_strength']
  character(len=*), parameter :: of_joint = 'joint' !! how the name of a strength begins: joints.phi, or joint(1).phi of a deck
  integer(hsize_t), parameter :: copied_at_once = 1000000 !! numbers

  !> A run at a checkpoint.
  type :: past_run_t
    character(len=:), allocatable :: path
    integer(hid_t) :: file = -1
    integer :: frame = 0                  !! that the checkpoint goes with, from 0
    integer(hsize_t), allocatable :: rows(:) !! (n_series) of each series then
    real(dp), allocatable :: numbers(:)   !! of the checkpoint
    type(stage_clock_t) :: stage          !! that it is of
    type(cracks_t), allocatable :: cracks !! as they had grown
    integer, allocatable :: departed(:)   !! blocks that had left the scene
  end type past_run_t

contains

  !> Names the decks that a run was made from, where none are given, and puts its settings before those that are given.
  !>
  !> Those that say how a run goes on, and strengths of joints, may be given, of all stages or from one on.
  !> Errors: another setting; a file that is no run's, or one of another version.
  subroutine find_decks(path, geometry, analysis, options, error)
    character(len=*), intent(in) :: path
    character(len=:), allocatable, intent(inout) :: geometry, analysis !! '' where not given
    type(text_t), allocatable, intent(inout) :: options(:)             !! GROUP.NAME=VALUE
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: deck(:), set(:), setting
    type(text_t), allocatable :: of_run(:)
    integer(hid_t) :: file
    integer :: i

    do i = 1, size(options)
      setting = options(i)%text(end_of_stage_prefix(options(i)%text) + 1:)
      if (any(may_change == setting(:index(setting//'=', '=') - 1)) .or. index(setting, of_joint//'(') == 1) cycle
      call fail(error, status_bad_input, '--set '//options(i)%text//': expected one of '//names()// &
                ' with --restart, as others made what the run goes on from')
      return
    end do
    call open_run(path, file, error)
    if (allocated(error)) return
    deck = read_words(file, '/scene/decks')
    set = read_words(file, '/scene/options')
    call close_for_reading(file)
    if (len(analysis) == 0 .and. size(deck) == 2) then
      geometry = trim(deck(1))
      analysis = trim(deck(2))
    end if
    allocate (of_run(0))
    do i = 1, size(set)
      call append(of_run, trim(set(i)))
    end do
    options = [of_run, options]

  contains

    !> Names of the settings that may be given.
    pure function names()
      character(len=:), allocatable :: names
      integer :: k

      names = trim(may_change(1))
      do k = 2, size(may_change)
        names = names//', '//trim(may_change(k))
      end do
      names = names//', joint(N).NAME'
    end function names

  end subroutine find_decks

  !> Opens the results file of a run. Errors: it is none, or one that a run still writes; of another version.
  subroutine open_run(path, file, error)
    character(len=*), intent(in) :: path
    integer(hid_t), intent(out) :: file
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: found
    logical :: there

    file = -1
    inquire (file=path, exist=there)
    if (.not. there) then
      call fail(error, status_bad_input, path//': expected the results file of a run to go on with, found no such file')
      return
    end if
    if (is_locked(path)) then
      call fail(error, status_bad_input, path//': expected the results file of a run that has ended, found one that a run '// &
                'still writes; wait until that ends, or stop it')
      return
    end if
    call open_for_reading(path, file)
    found = ''
    if (file >= 0) found = read_attribute(file, '/scene', 'version')
    if (len(found) == 0) then
      call fail(error, status_bad_input, path//': expected the results file of a run to go on with, found another file')
    else if (found /= 'scree '//version) then
      call fail(error, status_bad_input, path//': expected a run of scree '//version//' to go on with, found one of '//found)
    end if
    if (allocated(error)) call close_for_reading(file)
  end subroutine open_run

  !> Opens the run that a scene goes on with, and finds its last checkpoint that counts.
  !>
  !> Errors: as of `open_run`; other decks; no checkpoint, or one of other components.
  subroutine open_past(path, scene, past, error)
    character(len=*), intent(in) :: path
    type(scene_t), intent(in) :: scene
    type(past_run_t), intent(out) :: past
    type(error_t), allocatable, intent(out) :: error

    past%path = path
    call open_run(path, past%file, error)
    if (.not. allocated(error)) call compare_decks(past, scene, error)
    if (.not. allocated(error)) call read_checkpoint(past, error)
    if (allocated(error)) call leave_past(past)
  end subroutine open_past

  !> Closes what is open of a run that is not gone on with.
  subroutine leave_past(past)
    type(past_run_t), intent(inout) :: past

    call close_for_reading(past%file)
  end subroutine leave_past

  !> Reads state and watch from the checkpoint. Where strengths change all blocks wake.
  !>
  !> Errors: another model; a damaged checkpoint; nothing is left to do.
  subroutine take_past(past, scene, n_stages, model, state, watch, error)
    type(past_run_t), intent(inout) :: past
    type(scene_t), intent(in) :: scene           !! of the stage
    integer, intent(in) :: n_stages
    type(model_t), intent(in) :: model           !! before any crack grew
    type(state_t), intent(inout) :: state        !! as set up
    type(watch_t), intent(inout) :: watch
    type(error_t), allocatable, intent(out) :: error
    logical :: goes_on

    call compare_model(past, model, error)
    if (.not. allocated(error)) then
      if (.not. take_checkpoint(past%numbers, state, watch)) &
        call fail(error, status_bad_input, past%path//': expected a whole checkpoint, found one that is damaged')
    end if
    if (.not. allocated(error)) then
      if (changes_strength(past, scene)) call wake_all(model, state)
      call resume_pace(scene%settings, state)
      goes_on = state%stage%number < n_stages .or. (scene%settings%cracks_may_grow() .and. .not. has_no_step(scene%settings, state))
      if (at_end(scene%settings, state) .and. .not. (goes_on .and. is_settled(scene%settings, state))) &
        call fail(error, status_bad_input, past%path//': the run has come to its end, at time '// &
        rounded_text(time_of_run(state))//'; to go on beyond the checkpoint give a larger --set step.end_time=... '// &
        'and step.count=...')
    end if
    if (allocated(error)) call leave_past(past)
  end subroutine take_past

  !> Whether the settings of the run that goes on, behind those that it had, change a strength.
  logical function changes_strength(past, scene) result(changes)
    type(past_run_t), intent(in) :: past
    type(scene_t), intent(in) :: scene
    character(len=:), allocatable :: had(:)
    integer :: i

    had = read_words(past%file, '/scene/options')
    changes = .false.
    do i = size(had) + 1, size(scene%options)
      associate (option => scene%options(i)%text)
        changes = changes .or. index(option(end_of_stage_prefix(option) + 1:), of_joint) == 1
      end associate
    end do
  end function changes_strength

  !> Error where the decks are not those of the run.
  subroutine compare_decks(past, scene, error)
    type(past_run_t), intent(in) :: past
    type(scene_t), intent(in) :: scene
    type(error_t), allocatable, intent(out) :: error

    call compare('/scene/geometry_deck', scene%geometry_name, scene%geometry_text)
    if (.not. allocated(error)) call compare('/scene/analysis_deck', scene%analysis_name, scene%analysis_text)

  contains

    !> Error where a deck is not the one that was kept.
    subroutine compare(dataset, name, text)
      character(len=*), intent(in) :: dataset, name, text
      character(len=:), allocatable :: kept(:)

      kept = read_words(past%file, dataset)
      if (size(kept) == 1) then
        if (len(kept) == len(text) .and. kept(1) == text) return
      end if
      call fail(error, status_bad_input, name//': expected the deck that '//past%path//' was run with, found another')
    end subroutine compare

  end subroutine compare_decks

  !> Error where the model does not begin, to the last digit, as the run did: another mesh, or what cut the blocks was changed.
  subroutine compare_model(past, model, error)
    type(past_run_t), intent(in) :: past
    type(model_t), intent(in) :: model
    type(error_t), allocatable, intent(out) :: error
    real(dp), allocatable :: place(:)
    integer :: n
    logical :: same

    n = size(model%start, 2)
    place = read_rows(past%file, '/VTKHDF/Points', 0_hsize_t, int(n, hsize_t))
    same = size(place) == 3*n
    if (same) same = .not. any(abs(reshape(place, [3, n]) - spread_out()) > 0)
    if (.not. same) call fail(error, status_bad_input, past%path//': expected a run of the same model to go on with, found one '// &
                              'that begins with other vertices')

  contains

    !> Vertices of the model as the results have them.
    pure function spread_out() result(space)
      real(dp) :: space(3, n)

      space(:2, :) = model%start + spread(model%origin, 2, n)
      space(3, :) = 0.0_dp
    end function spread_out

  end subroutine compare_model

  !> Reads the last checkpoint whose frame counts.
  subroutine read_checkpoint(past, error)
    type(past_run_t), intent(inout) :: past
    type(error_t), allocatable, intent(out) :: error
    type(state_t) :: state
    type(watch_t) :: watch
    real(dp), allocatable :: end_(:), frame(:), rows(:)
    character(len=:), allocatable :: names(:)
    integer(hsize_t) :: from, last, n, n_rows(size(of_checkpoint))
    integer :: i, width

    names = read_words(past%file, '/checkpoint/components')
    do i = 1, size(n_rows)
      call count_rows(past%file, '/checkpoint/'//trim(of_checkpoint(i)), n_rows(i), width)
    end do
    n = minval(n_rows(:3)) + 1
    do ! a run that was killed may have written some of the last, and not where it is
      n = n - 1
      frame = read_rows(past%file, '/checkpoint/frame', 0_hsize_t, n)
      end_ = read_rows(past%file, '/checkpoint/end', 0_hsize_t, n)
      if (size(frame) == n .and. size(end_) == n) exit
    end do
    last = count(frame < read_count(past%file, '/VTKHDF/Steps', 'NSteps') .and. end_ <= n_rows(4))
    if (last == 0) then
      call fail(error, status_bad_input, past%path//': expected a run with a checkpoint to go on from (output.checkpoint=... '// &
                'writes them), found none')
      return
    end if
    if (names(1) /= components_of(state, watch)) then
      call fail(error, status_bad_input, past%path//': expected a checkpoint of this program, found one of another version')
      return
    end if
    past%frame = nint(frame(last))
    rows = read_rows(past%file, '/checkpoint/rows', last - 1, 1_hsize_t)
    past%rows = nint(rows, hsize_t)
    from = 0
    if (last > 1) from = nint(end_(last - 1), hsize_t)
    past%numbers = read_rows(past%file, '/checkpoint/numbers', from, nint(end_(last), hsize_t) - from)
    call take_beginning(past%numbers, past%stage, past%cracks, past%departed)
  end subroutine read_checkpoint

  !> Begins a results file with what there was up to the checkpoint. Errors: a failed write; rows that are not there; other series.
  subroutine resume_output(past, state, watch, output, error)
    type(past_run_t), intent(inout) :: past
    type(state_t), intent(in) :: state         !! of the checkpoint
    type(watch_t), intent(in) :: watch
    type(run_output_t), intent(inout) :: output
    type(error_t), allocatable, intent(out) :: error

    if (size(past%rows) /= output%checkpoints%n_series) then
      call fail(error, status_bad_input, past%path//': expected a run with '//number_text(output%checkpoints%n_series)// &
                ' series, as this scene has, found '//number_text(size(past%rows))//'; a restart cannot add bonds')
    else
      call copy_rows_of(past, output%file, error)
    end if
    call close_for_reading(past%file)
    if (.not. allocated(error)) call put_checkpoint(output%file, output%checkpoints, past%frame, state, watch, error)
    if (.not. allocated(error)) call count_frames(output%file, past%frame + 1, error)
    output%framed = step_of_run(state)
  end subroutine resume_output

  !> Copies the rows of all frames and series up to the checkpoint.
  subroutine copy_rows_of(past, results, error)
    type(past_run_t), intent(in) :: past
    type(results_t), intent(inout) :: results
    type(error_t), allocatable, intent(out) :: error
    real(dp), allocatable :: time(:)
    integer :: frames, i

    frames = past%frame + 1
    call make_room(results, error)
    do i = 1, size(past%rows)
      call copy(results%series(i)%rows, past%rows(i))
    end do
    if (allocated(error) .or. .not. allocated(results%xdmf)) return
    time = read_rows(past%file, '/VTKHDF/Steps/Values', 0_hsize_t, int(frames, hsize_t))
    do i = 1, frames
      call add_xdmf_frame(results%xdmf, i, time(i), error)
      if (allocated(error)) return
    end do

  contains

    !> Copies the first rows of a dataset, unless something failed before.
    subroutine copy(rows, n_rows)
      type(rows_t), intent(inout) :: rows
      integer(hsize_t), intent(in) :: n_rows
      character(len=200) :: name
      real(dp), allocatable :: values(:)
      integer(hsize_t) :: at, n
      integer(size_t) :: letters
      integer :: status, width

      if (allocated(error)) return
      call h5iget_name_f(rows%id, name, len(name, size_t), letters, status)
      width = max(1, product(rows%shape))
      at = 0
      do while (at < n_rows)
        n = min(n_rows - at, max(1_hsize_t, copied_at_once/width))
        values = read_rows(past%file, trim(name), at, n)
        if (size(values) /= n*width) then
          call fail(error, status_bad_input, past%path//': expected '//trim(name)//' up to its checkpoint, found less')
          return
        end if
        call append_rows(rows, values, error)
        if (allocated(error)) return
        at = at + n
      end do
    end subroutine copy

  end subroutine copy_rows_of

end module scree_restart
