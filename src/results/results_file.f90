!> The results of a run in one HDF5 file (doc/results.md): VTKHDF frames, series a step, series a frame.
!>
!> The module knows nothing of steps or systems: numbers come in as arrays. Rows and frames wait in memory. They are written at the
!> first frame, at one with a checkpoint, and at one for which a quarter of a second has passed or 16 MB wait. A write takes HDF5 a
!> millisecond, more than a step of a few blocks. Frames are written, flushed, and only then counted in `Steps@NSteps`, so a run
!> that is killed leaves every counted frame readable. The head of the file is that of HDF5 1.8, which has no mark of being open.
!> Chunks are large, so the index of a dataset hardly ever changes.
module scree_results_file
  use hdf5
  use, intrinsic :: iso_c_binding, only: c_int
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use, intrinsic :: iso_fortran_env, only: int64
  use scree_classic_output, only: classic_output_t
  use scree_disk_room, only: disk_room_t, give_back, hold_again
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_files, only: remove_file, set_length, without_links
  use scree_frame_layout, only: layout_parts, layout_rows, layout_t, part_block, part_corners, part_parent, part_types, &
                                units_of_part, words_of_part
  use scree_hdf5_reading, only: begin_hdf5
  use scree_hdf5_writing, only: check_status, create_rows, fixed_rows, flush_file, grow_in_place, write_text, write_whole, &
                                write_words
  use scree_interruption, only: ignore_size_limit
  use scree_kinds, only: dp, i8
  use scree_results_target, only: create_file, is_in_place, take_place_of
  use scree_row_series, only: add_row, bytes_to_write, more_series, rows_with_waiting, series_t, write_waiting
  use scree_text, only: number_text, same_length, text_t
  use scree_timers, only: cost_t
  use scree_xdmf, only: add_xdmf_frame, begin_xdmf, xdmf_t
  implicit none
  private

  public :: abandon_results, add_frame, add_layout, close_results, count_frames, declare_series, expect_place_still, make_room, &
            open_results, put_series, results_t, rows_of_series, store_rows, store_text, store_words, take_place, &
            work_row_t, write_rows, write_where_due

  integer, parameter :: chunk_bytes = 131072 !! of a chunk, where as many rows are expected
  integer(hsize_t), parameter :: closing_bytes = 131072 !! of what the run came to and cost, with its indices
  real, parameter :: longest_wait = 0.25     !! seconds between two times that rows are written
  integer, parameter :: most_waiting = 2000000 !! numbers, beyond which they are written
  character(len=*), parameter :: point_fields(2) = [character(len=12) :: 'displacement', 'velocity']
  character(len=*), parameter :: cell_fields(3) = [character(len=12) :: 'stress_xx', 'stress_yy', 'stress_xy']

  !> Field by which programs that read VTK know cells that are not drawn (vtkDataSetAttributes: HIDDENCELL).
  character(len=*), parameter :: ghost_field = 'vtkGhostType'
  real(dp), parameter :: hidden = 32

  !> Numbers of the series of the frames.
  type :: frame_series_t
    integer :: points = 0, time = 0
    integer :: point_field(size(point_fields)) = 0, cell_field(size(cell_fields)) = 0
    integer :: offset(5) = 0                !! parts, number of parts, points, cells, connectivity
    integer :: point_offset(size(point_fields)) = 0, cell_offset(size(cell_fields) + 2) = 0
    integer :: layout(size(layout_parts)) = 0 !! 0: all frames have the same polygons
    integer :: ghost = 0, ghost_offset = 0  !! which elements are gone; 0: frames have none such
  end type frame_series_t

  !> One line of the table of work.
  type :: work_row_t
    character(len=32) :: kind
    integer :: count = 0
  end type work_row_t

  !> The open file.
  type :: results_t
    character(len=:), allocatable :: path   !! as it was asked for
    character(len=:), allocatable :: name   !! that the file has now
    integer(hid_t) :: file = -1
    integer :: unit = -1                    !! by which `is_in_place` knows the file
    logical :: lost = .false.               !! it was taken away, or another one has its place
    integer(hid_t) :: steps = -1            !! group /VTKHDF/Steps
    type(disk_room_t) :: room
    integer :: n_frames = 0                 !! with those that wait
    integer :: n_counted = 0                !! frames that the file counts
    integer(int64) :: written = 0           !! ticks of the clock when rows were written last
    integer(int64) :: looked = 0            !! likewise when the file was last seen in its place
    integer :: n_corners = 0                !! of the polygons of the last frame
    integer :: expected_frames = 1, expected_steps = 1
    type(frame_series_t) :: frame
    type(series_t), allocatable :: series(:)
    integer :: n_series = 0
    type(xdmf_t), allocatable :: xdmf
    type(classic_output_t), allocatable :: classic !! the frames as Shi's programs keep them
  end type results_t

contains

  !> Makes the file, by the name that it has until it takes its place, and what never changes in it.
  !>
  !> Errors: `status_bad_input` where the path cannot be a file; `status_run_failed` where writing fails.
  subroutine open_results(results, path, layout, with_xdmf, hides, error)
    type(results_t), intent(out) :: results
    character(len=*), intent(in) :: path
    type(layout_t), intent(in) :: layout
    logical, intent(in) :: with_xdmf
    logical, intent(in) :: hides            !! frames may have elements that are gone
    type(error_t), allocatable, intent(out) :: error
    integer(hid_t) :: group
    integer :: status

    results%path = path
    results%name = without_links(path)//'.part'
    results%n_corners = size(layout%corner)
    results%expected_frames = max(1, layout%expected_frames)
    results%expected_steps = max(1, layout%expected_steps)
    allocate (results%series(32))

    call ignore_size_limit()
    call begin_hdf5()
    call create_file(results%name, path, results%file, results%unit, error)
    if (allocated(error)) return
    call grow_in_place(results%file, error)
    if (allocated(error)) return
    call h5gcreate_f(results%file, '/VTKHDF', group, status)
    call check_status(status, results%path//': cannot write the results', error)
    if (allocated(error)) return
    call write_whole(group, 'Version', [2, 0], error)
    if (allocated(error)) return
    call write_text(group, 'Type', 'UnstructuredGrid', error)
    if (allocated(error)) return
    call h5gcreate_f(results%file, '/VTKHDF/Steps', results%steps, status)
    call write_whole(results%steps, 'NSteps', [0], error)
    if (allocated(error)) return
    call h5gclose_f(group, status)
    call make_frames(results, layout, hides, error)
    if (allocated(error)) return
    if (with_xdmf) then
      allocate (results%xdmf)
      call begin_xdmf(results%xdmf, path, layout%n_vertices, layout%first, layout%corner, hides, error)
      if (allocated(error)) return
    end if
    call h5gcreate_f(results%file, '/scene', group, status)
    call h5gclose_f(group, status)
    call h5gcreate_f(results%file, '/cost', group, status) ! a name more at the end could not be listed on a full disk
    call h5gclose_f(group, status)
    call h5gcreate_f(results%file, '/ending', group, status)
    call h5gclose_f(group, status)
    call store_text(results, 'status', 'running', error, room=300)
  end subroutine open_results

  !> Datasets of the frames: the polygons once, places and fields to grow. After an error nothing more is made.
  subroutine make_frames(results, layout, with_ghosts, error)
    type(results_t), intent(inout) :: results
    type(layout_t), intent(in) :: layout
    logical, intent(in) :: with_ghosts       !! frames may have elements that are gone
    type(error_t), allocatable, intent(out) :: error
    integer :: i, frames

    associate (n_v => layout%n_vertices, n_e => size(layout%block), frame => results%frame)
      do i = 1, size(layout_parts)
        if (layout%changes) then
          call grow_part(i, layout_rows(layout, i), frame%layout(i))
        else if (i /= part_parent) then
          call fixed(i, layout_rows(layout, i))
        end if
      end do
      frames = max(1, min(results%expected_frames, chunk_bytes/(24*n_v)))
      call grow('Points', [3], .false., 'length', 'place of each vertex', n_v*frames, frame%points)
      call grow('PointData/displacement', [3], .false., 'length', 'displacement since the start', n_v*frames, frame%point_field(1))
      call grow('PointData/velocity', [3], .false., 'length/time', 'velocity', n_v*frames, frame%point_field(2))
      do i = 1, size(cell_fields)
        call grow('CellData/'//trim(cell_fields(i)), [integer ::], .false., 'force/length^2', &
                  'Cauchy stress, tension positive', n_e*frames, frame%cell_field(i))
      end do
      if (with_ghosts) &
        call grow('CellData/'//ghost_field, [integer ::], .true., '1', '32 where an element is gone and is not drawn, else 0', &
                  n_e*frames, frame%ghost, byte=.true.)
      call grow_step('Values', frame%time)
      call grow_step('PartOffsets', frame%offset(1))
      call grow_step('NumberOfParts', frame%offset(2))
      call grow_step('PointOffsets', frame%offset(3))
      call grow_step('CellOffsets', frame%offset(4))
      call grow_step('ConnectivityIdOffsets', frame%offset(5))
      do i = 1, size(point_fields)
        call grow_step('PointDataOffsets/'//trim(point_fields(i)), frame%point_offset(i))
      end do
      do i = 1, size(cell_fields)
        call grow_step('CellDataOffsets/'//trim(cell_fields(i)), frame%cell_offset(i))
      end do
      if (with_ghosts) call grow_step('CellDataOffsets/'//ghost_field, frame%ghost_offset)
      call grow_step('CellDataOffsets/block', frame%cell_offset(size(cell_fields) + 1))
      call grow_step('CellDataOffsets/material', frame%cell_offset(size(cell_fields) + 2))
    end associate

  contains

    !> A part of polygons that never change.
    subroutine fixed(part, values)
      integer, intent(in) :: part
      real(dp), intent(in) :: values(:)

      if (allocated(error)) return
      call fixed_rows(results%file, trim(layout_parts(part)), [integer ::], .true., units_of_part(part), &
                      words_of_part(part), values, error, part == part_types)
      call name_file(results, error)
    end subroutine fixed

    !> A part of polygons that may change.
    subroutine grow_part(part, values, handle)
      integer, intent(in) :: part
      real(dp), intent(in) :: values(:)        !! of the first
      integer, intent(inout) :: handle

      if (.not. allocated(error)) &
        call make_series(results, trim(layout_parts(part)), [integer ::], .true., units_of_part(part), words_of_part(part), &
                         min(4*size(values), chunk_bytes/8), handle, error, part == part_types)
    end subroutine grow_part

    !> Rows that grow with the frames.
    subroutine grow(name, shape, whole, units, description, chunk_rows, handle, byte)
      character(len=*), intent(in) :: name, units, description
      integer, intent(in) :: shape(:), chunk_rows
      logical, intent(in) :: whole
      integer, intent(out) :: handle
      logical, intent(in), optional :: byte !! of one byte each

      handle = 0
      if (allocated(error)) return
      call make_series(results, '/VTKHDF/'//name, shape, whole, units, description, chunk_rows, handle, error, byte)
    end subroutine grow

    !> One number a frame.
    subroutine grow_step(name, handle)
      character(len=*), intent(in) :: name
      integer, intent(out) :: handle
      integer :: chunk

      chunk = min(results%expected_frames + 1, chunk_bytes/8)
      if (name == 'Values') then
        call grow('Steps/'//name, [integer ::], .false., 'time', 'time of each frame', chunk, handle)
      else if (name == 'CellOffsets' .or. name == 'ConnectivityIdOffsets') then
        call grow('Steps/'//name, [1], .true., '', '', chunk, handle)
      else
        call grow('Steps/'//name, [integer ::], .true., '', '', chunk, handle)
      end if
    end subroutine grow_step

  end subroutine make_frames

  !> Adds the polygons that frames have from here on, where they may change; they wait in memory.
  subroutine add_layout(results, layout, error)
    type(results_t), intent(inout) :: results
    type(layout_t), intent(in) :: layout
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    do i = 1, size(layout_parts)
      call put_series(results, (results%frame%layout(i)), layout_rows(layout, i), error)
      if (allocated(error)) return
    end do
  end subroutine add_layout

  !> Makes a series and returns its number. Rows have the given shape as h5py sees it reversed.
  subroutine declare_series(results, path, shape, units, description, handle, error, whole, per_frame, expected_rows)
    type(results_t), intent(inout) :: results
    character(len=*), intent(in) :: path, units, description
    integer, intent(in) :: shape(:)
    integer, intent(out) :: handle             !! 0 after an error
    type(error_t), allocatable, intent(inout) :: error !! of the series before; nothing is declared after one
    logical, intent(in), optional :: whole     !! whole numbers
    logical, intent(in), optional :: per_frame !! a row a frame, else a row a step
    integer, intent(in), optional :: expected_rows !! where they are neither
    integer :: expected
    logical :: whole_numbers

    handle = 0
    if (allocated(error)) return
    whole_numbers = .false.
    if (present(whole)) whole_numbers = whole
    expected = results%expected_steps
    if (present(per_frame)) expected = merge(results%expected_frames + 1, expected, per_frame)
    if (present(expected_rows)) expected = expected_rows
    call make_series(results, path, shape, whole_numbers, units, description, &
                     min(expected, max(1, chunk_bytes/(8*max(1, product(shape))))), handle, error)
  end subroutine declare_series

  !> Makes a series with chunks of so many rows.
  subroutine make_series(results, path, shape, whole, units, description, chunk_rows, handle, error, byte)
    type(results_t), intent(inout) :: results
    character(len=*), intent(in) :: path, units, description
    integer, intent(in) :: shape(:), chunk_rows
    logical, intent(in) :: whole               !! whole numbers
    integer, intent(out) :: handle
    type(error_t), allocatable, intent(out) :: error
    logical, intent(in), optional :: byte      !! of one byte each

    if (results%n_series == size(results%series)) call more_series(results%series)
    results%n_series = results%n_series + 1
    handle = results%n_series
    associate (series => results%series(handle))
      series%path = path
      series%width = product(shape)
      call create_rows(results%file, path, shape, whole, units, description, chunk_rows, series%rows, error, byte)
      call name_file(results, error)
      allocate (series%waiting(16*max(1, series%width)))
    end associate
  end subroutine make_series

  !> Adds a row to a series; it waits in memory. Errors: a number that is not finite.
  subroutine put_series(results, handle, values, error)
    type(results_t), intent(inout) :: results
    integer, intent(in) :: handle
    real(dp), intent(in) :: values(:)
    type(error_t), allocatable, intent(out) :: error

    call add_row(results%series(handle), values, error)
  end subroutine put_series

  !> Rows of a series, with those that wait.
  pure integer(i8) function rows_of_series(results, handle)
    type(results_t), intent(in) :: results
    integer, intent(in) :: handle

    rows_of_series = rows_with_waiting(results%series(handle))
  end function rows_of_series

  !> Adds a frame; it waits in memory. Errors: a number that is not finite.
  subroutine add_frame(results, time, position, displacement, velocity, stress, present, error)
    type(results_t), intent(inout) :: results
    real(dp), intent(in) :: time
    real(dp), intent(in) :: position(:, :), displacement(:, :), velocity(:, :) !! (2, n_vertices)
    real(dp), intent(in) :: stress(:, :)                                    !! (3, n_elements) xx, yy, xy
    logical, intent(in) :: present(:)                                       !! (n_elements) the others are gone
    type(error_t), allocatable, intent(out) :: error
    integer :: i
    real(dp) :: cells, corners, parts        ! of the layouts before that of the frame

    if (.not. (ieee_is_finite(time) .and. all(ieee_is_finite(position)) .and. all(ieee_is_finite(displacement)) .and. &
               all(ieee_is_finite(velocity)) .and. all(ieee_is_finite(stress)))) then
      call fail(error, status_run_failed, 'a number of the frame is not finite')
      return
    end if
    parts = 0.0_dp
    cells = 0.0_dp
    corners = 0.0_dp
    associate (frame => results%frame)
      if (frame%layout(1) > 0) then
        parts = rows_before(frame%layout(1)) - 1
        cells = rows_before(frame%layout(part_block)) - size(present)
        corners = rows_before(frame%layout(part_corners)) - results%n_corners
      end if
      do i = 1, size(point_fields)
        call put(frame%point_offset(i), [rows_before(frame%point_field(i))])
      end do
      do i = 1, size(cell_fields)
        call put(frame%cell_offset(i), [rows_before(frame%cell_field(i))])
      end do
      call put(frame%cell_offset(size(cell_fields) + 1), [cells])
      call put(frame%cell_offset(size(cell_fields) + 2), [cells])
      call put(frame%time, [time])
      call put(frame%offset(1), [parts])
      call put(frame%offset(2), [1.0_dp])
      call put(frame%offset(3), [rows_before(frame%points)])
      call put(frame%offset(4), [cells])
      call put(frame%offset(5), [corners])
      if (frame%ghost > 0) then
        call put(frame%ghost_offset, [rows_before(frame%ghost)])
        call put(frame%ghost, merge(0.0_dp, hidden, present))
      end if
      call put(frame%points, in_space(position))
      call put(frame%point_field(1), in_space(displacement))
      call put(frame%point_field(2), in_space(velocity))
      do i = 1, size(cell_fields)
        call put(frame%cell_field(i), stress(i, :))
      end do
    end associate
    results%n_frames = results%n_frames + 1

  contains

    !> Rows of a series so far.
    real(dp) function rows_before(handle)
      integer, intent(in) :: handle

      rows_before = real(rows_of_series(results, handle), dp)
    end function rows_before

    !> Lets a row, or rows, of a series wait.
    subroutine put(handle, values)
      integer, intent(in) :: handle
      real(dp), intent(in) :: values(:)

      if (.not. allocated(error)) call put_series(results, handle, values, error)
    end subroutine put

  end subroutine add_frame

  !> Writes all rows that wait, where that is due: with the first frame, and where they have waited long or are many.
  !> Errors: a failed write.
  subroutine write_where_due(results, error)
    type(results_t), intent(inout) :: results
    type(error_t), allocatable, intent(out) :: error
    integer(int64) :: now, rate

    call system_clock(now, rate)
    if (results%n_counted > 0 .and. real(now - results%written) < longest_wait*real(rate) .and. &
        sum(results%series(:results%n_series)%n) < most_waiting) return
    call write_rows(results, error)
  end subroutine write_where_due

  !> Writes all rows that wait and flushes; counts the frames among them. Errors: the disk has not so much room, a failed write.
  subroutine write_rows(results, error)
    type(results_t), intent(inout) :: results
    type(error_t), allocatable, intent(out) :: error
    real(dp), allocatable :: time(:)
    integer :: counted, i

    call make_room(results, error)
    if (allocated(error)) return
    counted = results%n_counted
    associate (series => results%series(results%frame%time))
      time = series%waiting(:series%n)
    end associate
    call count_frames(results, results%n_frames, error)
    call system_clock(results%written)
    if (.not. allocated(results%xdmf)) return
    do i = 1, size(time)
      if (allocated(error)) return
      call add_xdmf_frame(results%xdmf, counted + i, time(i), error)
    end do
  end subroutine write_rows

  !> Does as `expect_place`, where that was not looked at for a second: frames may be hours apart.
  subroutine expect_place_still(results, error)
    type(results_t), intent(inout) :: results
    type(error_t), allocatable, intent(out) :: error
    integer(int64) :: now, rate

    call system_clock(now, rate)
    if (now - results%looked < rate) return
    results%looked = now
    call expect_place(results, error)
  end subroutine expect_place_still

  !> Error where the file was taken away, or another one has its place: what is written to it then is in no file that has a name.
  subroutine expect_place(results, error)
    type(results_t), intent(inout) :: results
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: expected, frames
    logical :: there

    results%lost = .not. is_in_place(results%name, results%unit)
    if (.not. results%lost) return
    expected = results%path//': expected the results file in its place until the run ends, found that '
    frames = '; the '//number_text(results%n_counted)//' frames of this run are '
    inquire (file=results%name, exist=there)
    if (there) then
      call fail(error, status_run_failed, expected//'another program has put another file there'//frames//'lost; write to '// &
                'another file (-o)')
    else
      call fail(error, status_run_failed, expected//'it was removed or renamed'//frames//'kept under its new name, if it has one')
    end if
  end subroutine expect_place

  !> Gives back held space for the rows that wait, and the end. Errors: the file was taken away; the disk has not so much room.
  subroutine make_room(results, error)
    type(results_t), intent(inout) :: results
    type(error_t), allocatable, intent(out) :: error

    call expect_place(results, error)
    if (allocated(error)) return
    call give_back(results%room, results%file, bytes_of_waiting(results) + closing_bytes, error)
    call name_file(results, error)
    if (allocated(error) .and. results%n_counted > 0) error%message = error%message//'; the first '// &
      number_text(results%n_counted)//' frames are kept; try more room, or fewer frames (output.every, output.interval)'
  end subroutine make_room

  !> Writes all rows that wait, and counts that many frames. Errors: a failed write.
  subroutine count_frames(results, n, error)
    type(results_t), intent(inout) :: results
    integer, value :: n ! a value: it may be the number of frames of these results
    type(error_t), allocatable, intent(out) :: error

    call append_waiting(results, error)
    if (allocated(error)) return
    call hold_again(results%room, results%file, error)
    if (.not. allocated(error)) call flush_file(results%file, error)
    if (.not. allocated(error)) then
      results%n_frames = n
      results%n_counted = n
      call write_whole(results%steps, 'NSteps', [n], error)
    end if
    if (.not. allocated(error)) call flush_file(results%file, error)
    call name_file(results, error)
  end subroutine count_frames

  !> Says in an error, where there is one, which file it is of.
  pure subroutine name_file(results, error)
    type(results_t), intent(in) :: results
    type(error_t), allocatable, intent(inout) :: error

    if (allocated(error)) error%message = results%path//': '//error%message
  end subroutine name_file

  !> Space that the rows that wait may take.
  pure integer(hsize_t) function bytes_of_waiting(results) result(bytes)
    type(results_t), intent(in) :: results

    bytes = sum(bytes_to_write(results%series(:results%n_series)))
  end function bytes_of_waiting

  !> Places or vectors of the plane with a third coordinate 0.
  pure function in_space(plane) result(space)
    real(dp), intent(in) :: plane(:, :) !! (2, n)
    real(dp) :: space(3*size(plane, 2))
    integer :: i

    do i = 1, size(plane, 2)
      space(3*i - 2:3*i) = [plane(:, i), 0.0_dp]
    end do
  end function in_space

  !> Writes all rows that wait.
  subroutine append_waiting(results, error)
    type(results_t), intent(inout) :: results
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    do i = 1, results%n_series
      call write_waiting(results%series(i), error)
      call name_file(results, error)
      if (allocated(error)) return
    end do
  end subroutine append_waiting

  !> Keeps a text as an attribute of /scene.
  subroutine store_text(results, name, text, error, room)
    type(results_t), intent(in) :: results
    character(len=*), intent(in) :: name, text
    type(error_t), allocatable, intent(out) :: error
    integer, intent(in), optional :: room        !! letters for later texts
    integer(hid_t) :: group
    integer :: status

    call h5gopen_f(results%file, '/scene', group, status)
    call write_text(group, name, text, error, room)
    call name_file(results, error)
    call h5gclose_f(group, status)
  end subroutine store_text

  !> Keeps a column of texts as a dataset.
  subroutine store_words(results, path, words, error)
    type(results_t), intent(in) :: results
    character(len=*), intent(in) :: path
    character(len=*), intent(in) :: words(:)
    type(error_t), allocatable, intent(out) :: error

    call write_words(results%file, path, words, error)
    call name_file(results, error)
  end subroutine store_words

  !> Keeps rows that never change as a dataset.
  subroutine store_rows(results, path, shape, whole, units, description, values, error)
    type(results_t), intent(in) :: results
    character(len=*), intent(in) :: path, units, description
    integer, intent(in) :: shape(:)              !! of a row
    logical, intent(in) :: whole                 !! whole numbers
    real(dp), intent(in) :: values(:)            !! row after row
    type(error_t), allocatable, intent(out) :: error

    call fixed_rows(results%file, path, shape, whole, units, description, values, error)
    call name_file(results, error)
  end subroutine store_rows

  !> Writes what the run came to, the costs and the status, and closes. Always closes; the first failure is the error.
  !>
  !> The status has its room in the file, so a full disk cannot keep it out: it says of a run that was complete that it stopped
  !> there. A file without a frame is taken away.
  subroutine close_results(results, status_text, summary, warning, cost, work, error)
    type(results_t), intent(inout) :: results
    character(len=*), intent(in) :: status_text  !! as in doc/results.md: complete, cut, interrupted, stopped: reason, ...
    character(len=*), intent(in) :: summary      !! as a JSON object; empty: none
    type(text_t), intent(in) :: warning(:)       !! that were given
    type(cost_t), intent(in) :: cost(:)
    type(work_row_t), intent(in) :: work(:)
    type(error_t), allocatable, intent(out) :: error
    type(error_t), allocatable :: lost_error, status_error
    integer(hsize_t) :: length
    integer(c_int) :: code
    integer :: status
    logical :: was_set

    if (results%file < 0) return
    call give_back(results%room, results%file, closing_bytes, error)
    call name_file(results, error)
    if (.not. allocated(error) .and. len(summary) > 0) call write_words(results%file, '/ending/summary', [summary], error)
    if (.not. allocated(error)) call write_words(results%file, '/ending/warnings', same_length(warning), error)
    if (.not. allocated(error)) call write_costs(results%file, cost, work, error)
    if (allocated(error) .and. any(status_text == [character(len=8) :: 'complete', 'cut'])) then
      call store_text(results, 'status', 'stopped: '//error%message, status_error)
    else
      call store_text(results, 'status', status_text, status_error)
    end if
    if (.not. allocated(status_error)) call flush_file(results%file, status_error)
    call name_file(results, status_error)
    if (.not. allocated(error)) call move_alloc(status_error, error)
    call h5fget_filesize_f(results%file, length, status)
    if (results%room%dataset >= 0) call h5dclose_f(results%room%dataset, code)
    call h5fclose_f(results%file, status)
    if (.not. allocated(error)) call check_status(status, results%path//': cannot close', error)
    results%file = -1
    call expect_place(results, lost_error)
    if (.not. allocated(error)) call move_alloc(lost_error, error)
    close (results%unit, iostat=code)
    if (results%lost) return
    if (results%n_counted == 0) then
      call remove_file(results%name)
    else if (.not. allocated(error)) then
      call h5close_f(status) ! after a failure it would try to write again
    else if (status < 0) then
      ! the failure may have cut the file shorter than its head says, and it would not open
      was_set = set_length(results%name, int(length + results%room%bytes, int64))
    end if
  end subroutine close_results

  !> Gives the file its place, once it has a frame: there is never one without, and what was there is there until then.
  !> Errors: what is there now is not to be replaced; it cannot be.
  subroutine take_place(results, error)
    type(results_t), intent(inout) :: results
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: place

    place = without_links(results%path)
    call take_place_of(results%name, place, error)
    if (.not. allocated(error)) results%name = place
  end subroutine take_place

  !> Closes a file that never took its place, or that of a run which only probes, and takes it away.
  subroutine abandon_results(results)
    type(results_t), intent(inout) :: results
    integer :: status

    if (results%file < 0) return
    call h5fclose_f(results%file, status)
    results%file = -1
    results%lost = .not. is_in_place(results%name, results%unit)
    close (results%unit, iostat=status)
    if (.not. results%lost) call remove_file(results%name)
  end subroutine abandon_results

  !> The tables of costs and of work.
  subroutine write_costs(file, cost, work, error)
    integer(hid_t), intent(in) :: file
    type(cost_t), intent(in) :: cost(:)
    type(work_row_t), intent(in) :: work(:)
    type(error_t), allocatable, intent(out) :: error

    call write_words(file, '/cost/phase', cost%phase, error)
    if (allocated(error)) return
    call fixed_rows(file, '/cost/calls', [integer ::], .true., '1', 'how often it began', real(cost%calls, dp), error)
    if (allocated(error)) return
    call fixed_rows(file, '/cost/wall_seconds', [integer ::], .false., 's', 'wall-clock time', cost%wall, error)
    if (allocated(error)) return
    call fixed_rows(file, '/cost/processor_seconds', [integer ::], .false., 's', 'processor time', cost%processor, error)
    if (allocated(error)) return
    call fixed_rows(file, '/cost/share', [integer ::], .false., '1', 'fraction of the wall-clock time', cost%share, error)
    if (allocated(error)) return
    call write_words(file, '/cost/work', work%kind, error)
    if (allocated(error)) return
    call fixed_rows(file, '/cost/count', [integer ::], .true., '1', 'how often', real(work%count, dp), error)
  end subroutine write_costs

end module scree_results_file
