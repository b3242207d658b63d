!> The bytes of a file, read once and in order, so that it may be a pipe (`<(...)` of a shell) as well.
module scree_file_bytes
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_int, c_null_char, c_ptr, c_size_t
  implicit none
  private
  public :: read_bytes

  integer, parameter :: first_room = 65536 !! bytes, doubled as often as the file needs

  interface
    type(c_ptr) function fopen(path, mode) bind(c, name='fopen')
      import :: c_char, c_ptr
      character(kind=c_char), intent(in) :: path(*), mode(*)
    end function fopen

    integer(c_size_t) function fread(buffer, size, count, file) bind(c, name='fread')
      import :: c_char, c_ptr, c_size_t
      character(kind=c_char), intent(inout) :: buffer(*)
      integer(c_size_t), value :: size, count
      type(c_ptr), value :: file
    end function fread

    integer(c_int) function ferror(file) bind(c, name='ferror')
      import :: c_int, c_ptr
      type(c_ptr), value :: file
    end function ferror

    integer(c_int) function fclose(file) bind(c, name='fclose')
      import :: c_int, c_ptr
      type(c_ptr), value :: file
    end function fclose
  end interface

contains

  !> Reads a file to its end, or up to one byte more than `most`.
  subroutine read_bytes(path, most, bytes, is_read)
    character(len=*), intent(in) :: path
    integer, intent(in) :: most
    character(len=:), allocatable, intent(out) :: bytes
    logical, intent(out) :: is_read !! else the system does not open or read it
    character(len=:), allocatable :: more
    type(c_ptr) :: file
    integer :: n, got

    bytes = ''
    file = fopen(path//c_null_char, 'rb'//c_null_char)
    is_read = c_associated(file)
    if (.not. is_read) return
    allocate (character(len=first_room) :: more)
    n = 0
    do
      got = int(fread(more(n + 1:), 1_c_size_t, int(len(more) - n, c_size_t), file))
      n = n + got
      if (n < len(more) .or. n > most) exit
      bytes = more
      deallocate (more)
      allocate (character(len=min(2*n, most + 1)) :: more)
      more(:n) = bytes
    end do
    is_read = ferror(file) == 0
    if (fclose(file) /= 0) is_read = .false.
    bytes = more(:n)
  end subroutine read_bytes

end module scree_file_bytes
