!> A side-car for programs that do not read VTKHDF: XDMF 3 text that points into the HDF5 file.
!>
!> Closed after every frame, so that it is always well-formed.
module scree_xdmf
  use, intrinsic :: iso_fortran_env, only: int64
  use scree_errors, only: error_t, fail, status_bad_input, status_run_failed
  use scree_files, only: beginning_of, check_size, holds_something
  use scree_kinds, only: dp
  use scree_text, only: number_text, with_ending
  implicit none
  private
  public :: add_xdmf_frame, begin_xdmf, may_replace_xdmf, xdmf_path, xdmf_t

  character(len=1), parameter :: lf = achar(10)
  character(len=*), parameter :: head = '<?xml version="1.0"?>'//lf//'<Xdmf Version="3.0"><Domain><Grid GridType="Collection" '// &
                                 'CollectionType="Temporal">'//lf
  character(len=*), parameter :: tail = '</Grid></Domain></Xdmf>'//lf

  !> The open side-car.
  type :: xdmf_t
    character(len=:), allocatable :: path
    character(len=:), allocatable :: hdf5_name !! as XML has it
    character(len=:), allocatable :: topology !! the polygons, the same in every frame
    integer :: n_vertices = 0
    integer :: n_elements = 0
    logical :: hides = .false.                !! elements may be gone
    integer :: tail_at = 1                    !! where the tail begins
  end type xdmf_t

contains

  !> Name of the side-car of a results file.
  pure function xdmf_path(results_path)
    character(len=*), intent(in) :: results_path
    character(len=:), allocatable :: xdmf_path

    xdmf_path = with_ending(results_path, '.xdmf')
  end function xdmf_path

  !> Whether a side-car may take the place of a file: it holds nothing, or begins as one.
  logical function may_replace_xdmf(path)
    character(len=*), intent(in) :: path

    may_replace_xdmf = .not. holds_something(path)
    if (.not. may_replace_xdmf) may_replace_xdmf = beginning_of(path, len(head)) == head
  end function may_replace_xdmf

  !> Starts the side-car of a results file. Errors: it cannot be written.
  subroutine begin_xdmf(xdmf, results_path, n_vertices, first, corner, hides, error)
    type(xdmf_t), intent(out) :: xdmf
    character(len=*), intent(in) :: results_path
    integer, intent(in) :: n_vertices
    integer, intent(in) :: first(:)           !! (n_elements+1) element e has the vertices corner(first(e):first(e+1)-1)
    integer, intent(in) :: corner(:)
    logical, intent(in) :: hides              !! frames may have elements that are gone
    type(error_t), allocatable, intent(out) :: error

    xdmf%path = xdmf_path(results_path)
    xdmf%hdf5_name = in_xml(results_path(index(results_path, '/', back=.true.) + 1:))
    xdmf%n_elements = size(first) - 1
    xdmf%n_vertices = n_vertices
    xdmf%hides = hides
    xdmf%topology = '<Topology TopologyType="Mixed" NumberOfElements="'//number_text(xdmf%n_elements)//'">'// &
                    '<DataItem Dimensions="'//number_text(size(corner) + 2*xdmf%n_elements)// &
                    '" NumberType="Int" Format="XML">'//lf//polygon_rows(first, corner)//'</DataItem></Topology>'//lf
    call put(xdmf, head, .true., error)
    if (allocated(error)) error%status = status_bad_input
  end subroutine begin_xdmf

  !> A text as XML has it between its tags: `&` and `<` begin something else there, and `>` may end it.
  pure function in_xml(text) result(escaped)
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: escaped
    integer :: i

    escaped = ''
    do i = 1, len(text)
      select case (text(i:i))
      case ('&')
        escaped = escaped//'&amp;'
      case ('<')
        escaped = escaped//'&lt;'
      case ('>')
        escaped = escaped//'&gt;'
      case default
        escaped = escaped//text(i:i)
      end select
    end do
  end function in_xml

  !> A row of text for each element: 3 for polygon, its number of vertices, the vertices from 0.
  function polygon_rows(first, corner) result(rows)
    integer, intent(in) :: first(:), corner(:)
    character(len=:), allocatable :: rows
    integer, parameter :: digits = 10         !! of the largest integer
    integer :: e, i, n

    allocate (character(len=(digits + 3)*(size(first) - 1) + (digits + 1)*size(corner)) :: rows)
    n = 0
    do e = 1, size(first) - 1
      call append('3 '//number_text(first(e + 1) - first(e)))
      do i = first(e), first(e + 1) - 1
        call append(' '//number_text(corner(i) - 1))
      end do
      call append(lf)
    end do
    rows = rows(:n)

  contains

    !> Adds text, for which there is room.
    subroutine append(text)
      character(len=*), intent(in) :: text

      rows(n + 1:n + len(text)) = text
      n = n + len(text)
    end subroutine append

  end function polygon_rows

  !> Adds a frame.
  subroutine add_xdmf_frame(xdmf, frame, time, error)
    type(xdmf_t), intent(inout) :: xdmf
    integer, intent(in) :: frame     !! from 1
    real(dp), intent(in) :: time
    type(error_t), allocatable, intent(out) :: error
    character(len=26) :: when
    character(len=:), allocatable :: hidden

    hidden = ''
    if (xdmf%hides) hidden = field('vtkGhostType', 'Cell', 'Scalar', 'CellData/vtkGhostType', xdmf%n_elements, 1, &
                                   'UChar" Precision="1')
    write (when, '(es25.17)') time
    call put(xdmf, '<Grid GridType="Uniform"><Time Value="'//trim(adjustl(when))//'"/>'//lf//xdmf%topology// &
             '<Geometry GeometryType="XYZ">'//rows('Points', xdmf%n_vertices, 3)//'</Geometry>'//lf// &
             field('displacement', 'Node', 'Vector', 'PointData/displacement', xdmf%n_vertices, 3)// &
             field('velocity', 'Node', 'Vector', 'PointData/velocity', xdmf%n_vertices, 3)// &
             field('stress_xx', 'Cell', 'Scalar', 'CellData/stress_xx', xdmf%n_elements, 1)// &
             field('stress_yy', 'Cell', 'Scalar', 'CellData/stress_yy', xdmf%n_elements, 1)// &
             field('stress_xy', 'Cell', 'Scalar', 'CellData/stress_xy', xdmf%n_elements, 1)//hidden//'</Grid>'//lf, .false., error)

  contains

    !> A field of this frame.
    function field(name, centre, kind, dataset, n, width, type)
      character(len=*), intent(in) :: name, centre, kind, dataset
      integer, intent(in) :: n, width
      character(len=*), intent(in), optional :: type !! of the numbers, else as of `rows`
      character(len=:), allocatable :: field

      field = '<Attribute Name="'//name//'" Center="'//centre//'" AttributeType="'//kind//'">'// &
              rows(dataset, n, width, type)//'</Attribute>'//lf
    end function field

    !> The rows of this frame in a dataset.
    function rows(dataset, n, width, type)
      character(len=*), intent(in) :: dataset
      integer, intent(in) :: n, width
      character(len=*), intent(in), optional :: type !! of the numbers, else reals of double precision
      character(len=:), allocatable :: rows, extent, more, of_type, total

      of_type = 'Float" Precision="8'
      if (present(type)) of_type = type
      extent = number_text(n)
      if (width > 1) then
        extent = extent//' '//number_text(width)
        more = number_text((frame - 1)*n)//' 0 1 1 '//extent
      else
        more = number_text((frame - 1)*n)//' 1 '//extent
      end if
      total = number_text(frame*n)
      if (width > 1) total = total//' 3'
      rows = '<DataItem ItemType="HyperSlab" Dimensions="'//extent//'"><DataItem Dimensions="3 '// &
             number_text(merge(2, 1, width > 1))//'" Format="XML">'//more//'</DataItem><DataItem Dimensions="'// &
             total//'" NumberType="'//of_type//'" Format="HDF">'//xdmf%hdf5_name//':/VTKHDF/'//dataset// &
             '</DataItem></DataItem>'
    end function rows

  end subroutine add_xdmf_frame

  !> Writes text and the tail over the old tail.
  subroutine put(xdmf, new, fresh, error)
    type(xdmf_t), intent(inout) :: xdmf
    character(len=*), intent(in) :: new
    logical, intent(in) :: fresh
    type(error_t), allocatable, intent(out) :: error
    character(len=200) :: reason
    character(len=7) :: state
    integer :: status, unit

    state = 'old'
    if (fresh) state = 'replace'
    open (newunit=unit, file=xdmf%path, access='stream', form='unformatted', action='readwrite', status=state, &
          iostat=status, iomsg=reason)
    if (status == 0) then
      write (unit, pos=xdmf%tail_at, iostat=status, iomsg=reason) new//tail
      close (unit)
      if (status == 0) call check_size(xdmf%path, int(xdmf%tail_at, int64) + len(new) + len(tail) - 1, status, reason)
    end if
    if (status /= 0) then
      call fail(error, status_run_failed, xdmf%path//': expected a file that can be written, found: '//trim(reason))
      return
    end if
    xdmf%tail_at = xdmf%tail_at + len(new)
  end subroutine put

end module scree_xdmf
