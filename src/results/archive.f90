!> The parts of something as one list of numbers: the same calls, in the same order, list them and take them back.
!>
!> So there is one place that says what the parts are. Their names are kept beside the numbers: a list is taken back by the names
!> that it was made with alone.
module scree_archive
  use scree_kinds, only: dp
  implicit none
  private
  public :: archive_t

  !> A list of numbers, and how far it has come. Whole numbers and logicals are listed as reals.
  type :: archive_t
    logical :: reading = .false.             !! takes parts back, else lists them
    real(dp), allocatable :: number(:)       !! room for more than there are, where it lists
    integer :: n = 0                         !! numbers so far
    character(len=:), allocatable :: names   !! of the parts so far, a blank after each
    logical :: damaged = .false.             !! a part asked for more than there is
  contains
    procedure, private :: one_real, one_whole, one_logical
    procedure, private :: some_reals, some_wholes, some_logicals
    procedure, private :: list_of_reals, table_of_reals, list_of_wholes, table_of_wholes, list_of_logicals
    generic :: part => one_real, one_whole, one_logical, some_reals, some_wholes, some_logicals
    generic :: array => list_of_reals, table_of_reals, list_of_wholes, table_of_wholes, list_of_logicals
  end type archive_t

contains

  !> Names a part.
  subroutine name_part(archive, name)
    class(archive_t), intent(inout) :: archive
    character(len=*), intent(in) :: name

    if (.not. allocated(archive%names)) archive%names = ''
    archive%names = archive%names//name//' '
  end subroutine name_part

  !> Lists numbers, or takes them back.
  subroutine pass(archive, values)
    class(archive_t), intent(inout) :: archive
    real(dp), intent(inout) :: values(:)
    real(dp), allocatable :: longer(:)

    if (.not. allocated(archive%number)) allocate (archive%number(0))
    if (archive%n + size(values) > size(archive%number)) then
      if (archive%reading) then
        archive%damaged = .true.
        return
      end if
      allocate (longer(archive%n + max(archive%n, size(values))))
      longer(:archive%n) = archive%number(:archive%n)
      call move_alloc(longer, archive%number)
    end if
    associate (here => archive%number(archive%n + 1:archive%n + size(values)))
      if (archive%reading) then
        values = here
      else
        here = values
      end if
    end associate
    archive%n = archive%n + size(values)
  end subroutine pass

  !> A real number.
  subroutine one_real(archive, name, value)
    class(archive_t), intent(inout) :: archive
    character(len=*), intent(in) :: name
    real(dp), intent(inout) :: value
    real(dp) :: values(1)

    values = value
    call some_reals(archive, name, values)
    value = values(1)
  end subroutine one_real

  !> A whole number.
  subroutine one_whole(archive, name, value)
    class(archive_t), intent(inout) :: archive
    character(len=*), intent(in) :: name
    integer, intent(inout) :: value
    integer :: values(1)

    values = value
    call some_wholes(archive, name, values)
    value = values(1)
  end subroutine one_whole

  !> A logical.
  subroutine one_logical(archive, name, value)
    class(archive_t), intent(inout) :: archive
    character(len=*), intent(in) :: name
    logical, intent(inout) :: value
    logical :: values(1)

    values = value
    call some_logicals(archive, name, values)
    value = values(1)
  end subroutine one_logical

  !> Real numbers, as many as there are.
  subroutine some_reals(archive, name, values)
    class(archive_t), intent(inout) :: archive
    character(len=*), intent(in) :: name
    real(dp), intent(inout) :: values(:)

    call name_part(archive, name)
    call pass(archive, values)
  end subroutine some_reals

  !> Whole numbers, as many as there are.
  subroutine some_wholes(archive, name, values)
    class(archive_t), intent(inout) :: archive
    character(len=*), intent(in) :: name
    integer, intent(inout) :: values(:)
    real(dp), allocatable :: numbers(:)

    numbers = real(values, dp)
    call some_reals(archive, name, numbers)
    if (archive%reading) values = nint(numbers)
  end subroutine some_wholes

  !> Logicals, as many as there are.
  subroutine some_logicals(archive, name, values)
    class(archive_t), intent(inout) :: archive
    character(len=*), intent(in) :: name
    logical, intent(inout) :: values(:)
    real(dp), allocatable :: numbers(:)

    numbers = merge(1.0_dp, 0.0_dp, values)
    call some_reals(archive, name, numbers)
    if (archive%reading) values = numbers > 0
  end subroutine some_logicals

  !> The shape of an array; below 0 where it is not allocated, and where what is taken back is not all there.
  subroutine pass_shape(archive, extent)
    class(archive_t), intent(inout) :: archive
    integer, intent(inout) :: extent(:)
    real(dp) :: numbers(size(extent))

    numbers = extent
    call pass(archive, numbers)
    if (.not. archive%reading) return
    if (product(max(numbers, 0.0_dp)) > size(archive%number) - archive%n) archive%damaged = .true.
    if (archive%damaged) numbers = -1
    extent = nint(numbers)
  end subroutine pass_shape

  !> An array of reals, of any size, or none.
  subroutine list_of_reals(archive, name, values)
    class(archive_t), intent(inout) :: archive
    character(len=*), intent(in) :: name
    real(dp), allocatable, intent(inout) :: values(:)
    integer :: extent(1)

    call name_part(archive, name)
    extent = -1
    if (allocated(values)) extent = shape(values)
    call pass_shape(archive, extent)
    if (archive%reading .and. allocated(values)) deallocate (values)
    if (extent(1) < 0) return
    if (archive%reading) allocate (values(extent(1)))
    call pass(archive, values)
  end subroutine list_of_reals

  !> Likewise of two dimensions.
  subroutine table_of_reals(archive, name, values)
    class(archive_t), intent(inout) :: archive
    character(len=*), intent(in) :: name
    real(dp), allocatable, intent(inout) :: values(:, :)
    real(dp), allocatable :: row(:)
    integer :: extent(2)

    call name_part(archive, name)
    extent = -1
    if (allocated(values)) extent = shape(values)
    call pass_shape(archive, extent)
    if (archive%reading .and. allocated(values)) deallocate (values)
    if (extent(1) < 0) return
    if (archive%reading) then
      allocate (row(product(extent)))
      call pass(archive, row)
      values = reshape(row, extent)
    else
      row = [values]
      call pass(archive, row)
    end if
  end subroutine table_of_reals

  !> An array of whole numbers, of any size, or none.
  subroutine list_of_wholes(archive, name, values)
    class(archive_t), intent(inout) :: archive
    character(len=*), intent(in) :: name
    integer, allocatable, intent(inout) :: values(:)
    real(dp), allocatable :: numbers(:)

    if (allocated(values)) numbers = real(values, dp)
    call list_of_reals(archive, name, numbers)
    if (.not. archive%reading) return
    if (allocated(values)) deallocate (values)
    if (allocated(numbers)) values = nint(numbers)
  end subroutine list_of_wholes

  !> Likewise of two dimensions.
  subroutine table_of_wholes(archive, name, values)
    class(archive_t), intent(inout) :: archive
    character(len=*), intent(in) :: name
    integer, allocatable, intent(inout) :: values(:, :)
    real(dp), allocatable :: numbers(:, :)

    if (allocated(values)) numbers = real(values, dp)
    call table_of_reals(archive, name, numbers)
    if (.not. archive%reading) return
    if (allocated(values)) deallocate (values)
    if (allocated(numbers)) values = nint(numbers)
  end subroutine table_of_wholes

  !> An array of logicals, of any size, or none.
  subroutine list_of_logicals(archive, name, values)
    class(archive_t), intent(inout) :: archive
    character(len=*), intent(in) :: name
    logical, allocatable, intent(inout) :: values(:)
    real(dp), allocatable :: numbers(:)

    if (allocated(values)) numbers = merge(1.0_dp, 0.0_dp, values)
    call list_of_reals(archive, name, numbers)
    if (.not. archive%reading) return
    if (allocated(values)) deallocate (values)
    if (allocated(numbers)) values = numbers > 0
  end subroutine list_of_logicals

end module scree_archive
