!> The frames as Shi's programs keep them for drawing again: polygons and points as text, the `.replay` of ntdda.
!>
!> doc/classic-output.md has the layout. The file is closed after every frame. The number of frames is the first number of the file,
!> has a fixed width, and is written over once a frame is complete. So a run that is killed leaves the number of whole frames.
module scree_classic_output
  use, intrinsic :: iso_fortran_env, only: int64
  use scree_errors, only: error_t, fail, status_bad_input, status_run_failed
  use scree_files, only: beginning_of, check_size, holds_something
  use scree_kinds, only: dp
  use scree_simplex_integration, only: moments_t, polygon_moments
  use scree_system, only: fixed_point, load_point, measured_point
  use scree_text, only: number_text, with_ending
  implicit none
  private
  public :: add_classic_frame, begin_classic_output, classic_output_t, classic_path, may_replace_classic

  character(len=1), parameter :: lf = achar(10)
  integer, parameter :: scratch_rows = 4    !! after the vertices of each polygon
  integer, parameter :: type_code(3) = [0, 2, 1] !! in the file, of `fixed_point`, `load_point`, `measured_point`

  !> The file and what never changes in it.
  type :: classic_output_t
    character(len=:), allocatable :: path
    integer, allocatable :: first(:)         !! (n_polygons+1) polygon i has the vertices corner(first(i):first(i+1)-1)
    integer, allocatable :: corner(:)
    integer, allocatable :: joint(:)         !! joint material of the edge that ends at each corner
    integer, allocatable :: point_kind(:)    !! (n_points) fixed, load, measured: in this order
    integer, allocatable :: point_polygon(:) !! (n_points) polygon that carries it
    integer :: n_frames = 0
    integer(int64) :: end_at = 1             !! where the next frame begins
  end type classic_output_t

contains

  !> Name of the file beside a results file.
  pure function classic_path(results_path)
    character(len=*), intent(in) :: results_path
    character(len=:), allocatable :: classic_path

    classic_path = with_ending(results_path, '.replay')
  end function classic_path

  !> Whether classic output may take the place of a file: it holds nothing, or begins with the number of frames in its fixed width,
  !> and the counts.
  logical function may_replace_classic(path)
    character(len=*), intent(in) :: path
    character(len=:), allocatable :: head
    integer :: count_(4), end_, n_points(3), status

    may_replace_classic = .not. holds_something(path)
    if (may_replace_classic) return
    head = beginning_of(path, 200)
    end_ = index(head, lf)
    if (end_ < 12) return
    read (head(:end_ - 1), *, iostat=status) count_
    if (status /= 0) return
    if (count_text(count_(1)) /= head(:10) .or. count_(3) /= 0) return
    head = head(end_ + 1:)
    end_ = index(head, lf)
    read (head(:max(0, end_ - 1)), *, iostat=status) n_points
    may_replace_classic = status == 0 .and. index(head, lf//'0 0 0'//lf) == end_
  end function may_replace_classic

  !> Starts the file beside a results file, with no frame. Errors: it cannot be written.
  subroutine begin_classic_output(output, results_path, material, first, corner, joint, point_kind, point_polygon, error)
    type(classic_output_t), intent(out) :: output
    character(len=*), intent(in) :: results_path
    integer, intent(in) :: material(:)       !! (n_polygons)
    integer, intent(in) :: first(:), corner(:), joint(:), point_kind(:), point_polygon(:)
    type(error_t), allocatable, intent(out) :: error
    character(len=200) :: reason
    integer :: i, row, status, unit

    output%path = classic_path(results_path)
    output%first = first
    output%corner = corner
    output%joint = joint
    output%point_kind = point_kind
    output%point_polygon = point_polygon
    open (newunit=unit, file=output%path, access='stream', form='unformatted', action='readwrite', status='replace', &
          iostat=status, iomsg=reason)
    if (status == 0) then
      write (unit, iostat=status, iomsg=reason) count_text(0)//' '//number_text(size(material))//' 0 '// &
        number_text(size(corner) + scratch_rows*size(material))//lf//number_text(count(point_kind == fixed_point))//' '// &
        number_text(count(point_kind == load_point))//' '//number_text(count(point_kind == measured_point))//lf//'0 0 0'//lf
      row = 1
      do i = 1, size(material)
        if (status /= 0) exit
        associate (n => first(i + 1) - first(i))
          write (unit, iostat=status, iomsg=reason) number_text(material(i))//' '//number_text(row)//' '// &
            number_text(row + n - 1)//lf
          row = row + n + scratch_rows
        end associate
      end do
      inquire (unit, pos=output%end_at)
      close (unit)
      if (status == 0) call check_size(output%path, output%end_at - 1, status, reason)
    end if
    if (status /= 0) call fail(error, status_bad_input, output%path//': expected a file that can be written, found: '// &
                               trim(reason))
  end subroutine begin_classic_output

  !> Adds a frame, then counts it. Errors: a failed write.
  subroutine add_classic_frame(output, position, point, error)
    type(classic_output_t), intent(inout) :: output
    real(dp), intent(in) :: position(:, :) !! (2, n_vertices), length
    real(dp), intent(in) :: point(:, :) !! (2, n_points), length
    type(error_t), allocatable, intent(out) :: error
    type(moments_t) :: moments
    real(dp), allocatable :: vertex(:, :)
    character(len=200) :: reason
    integer :: i, k, n, status, unit
    integer(int64) :: after

    open (newunit=unit, file=output%path, access='stream', form='unformatted', action='readwrite', status='old', &
          iostat=status, iomsg=reason)
    if (status == 0) then
      n = size(output%first) - 1
      write (unit, pos=output%end_at, iostat=status, iomsg=reason) corner_row(output%first(2) - 1)//lf
      do i = 1, n
        vertex = position(:, output%corner(output%first(i):output%first(i + 1) - 1))
        moments = polygon_moments(vertex, [1, size(vertex, 2) + 1])
        do k = output%first(i), output%first(i + 1) - 1
          call put(corner_row(k))
        end do
        call put(corner_row(output%first(i)))
        call put(row_text(0, [sqrt(maxval(sum((vertex - spread(moments%centroid, 2, size(vertex, 2)))**2, 1))), &
                              moments%area]))
        call put(row_text(0, moments%area*moments%centroid))
        if (i < n) then
          call put(corner_row(output%first(i + 2) - 1))
        else
          call put(row_text(0, moments%centroid))
        end if
      end do
      call put('0 0 0 0')
      do i = 1, size(output%point_kind)
        call put(row_text(type_code(output%point_kind(i)), point(:, i))//' '//number_text(output%point_polygon(i)))
      end do
      inquire (unit, pos=after)
      close (unit)
      if (status == 0) call check_size(output%path, after - 1, status, reason)
    end if
    if (status == 0) open (newunit=unit, file=output%path, access='stream', form='unformatted', action='readwrite', &
                           status='old', iostat=status, iomsg=reason)
    if (status == 0) then
      write (unit, iostat=status, iomsg=reason) count_text(output%n_frames + 1)
      close (unit)
    end if
    if (status /= 0) then
      call fail(error, status_run_failed, output%path//': cannot write: '//trim(reason))
      return
    end if
    output%end_at = after
    output%n_frames = output%n_frames + 1

  contains

    !> Writes a line, unless something failed before.
    subroutine put(text)
      character(len=*), intent(in) :: text

      if (status == 0) write (unit, iostat=status, iomsg=reason) text//lf
    end subroutine put

    !> The row of a corner.
    function corner_row(c)
      integer, intent(in) :: c
      character(len=:), allocatable :: corner_row

      corner_row = row_text(output%joint(c), position(:, output%corner(c)))
    end function corner_row

  end subroutine add_classic_frame

  !> A row of a whole number and two, with digits that read back as the same numbers.
  function row_text(whole, number)
    integer, intent(in) :: whole
    real(dp), intent(in) :: number(2)
    character(len=:), allocatable :: row_text
    character(len=64) :: buffer

    write (buffer, '(i0,2(1x,es24.16e3))') whole, number
    row_text = trim(buffer)
  end function row_text

  !> A number of frames, always as wide.
  function count_text(n)
    integer, intent(in) :: n
    character(len=10) :: count_text

    write (count_text, '(i10)') n
  end function count_text

end module scree_classic_output
