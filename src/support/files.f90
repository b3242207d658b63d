!> Existing files: whether two names mean one file, how a file begins, whether the system has stored all of it.
module scree_files
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t, c_intptr_t, c_null_char, c_size_t
  use, intrinsic :: iso_fortran_env, only: int64
  use scree_errors, only: error_t, fail, status_bad_input
  implicit none
  private
  public :: beginning_of, check_size, expect_regular, holds_something, is_directory, move_file, refuse_to_replace, remove_file, &
            same_file, set_length, without_links

  interface
    !> C: sets the length of a file.
    integer(c_int) function c_truncate(path, length) bind(c, name='truncate')
      import :: c_char, c_int, c_int64_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int64_t), value :: length
    end function c_truncate

    !> C: gives a file another name, that of a file which is there where that is so.
    integer(c_int) function c_rename(from, to) bind(c, name='rename')
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: from(*), to(*)
    end function c_rename

    !> POSIX: takes a name of a file away, and with the last one the file, once nobody has it open.
    integer(c_int) function c_unlink(path) bind(c, name='unlink')
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: path(*)
    end function c_unlink

    !> POSIX: the bytes that a symbolic link holds, and how many they are; below 0 where a name is no link.
    integer(c_intptr_t) function c_readlink(path, bytes, most) bind(c, name='readlink')
      import :: c_char, c_intptr_t, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      character(kind=c_char), intent(inout) :: bytes(*)
      integer(c_size_t), value :: most
    end function c_readlink
  end interface

  integer, parameter :: longest_path = 4096, most_links = 40 !! PATH_MAX of Linux, and links that it follows

contains

  !> Whether a name is of a file with something in it, that writing would lose. A device, a pipe and a directory are none.
  logical function holds_something(path)
    character(len=*), intent(in) :: path
    integer(int64) :: size_
    logical :: there

    inquire (file=path, exist=there, size=size_)
    holds_something = there .and. size_ > 0 .and. .not. is_directory(path)
  end function holds_something

  !> Whether a name is of a directory.
  logical function is_directory(path)
    character(len=*), intent(in) :: path

    inquire (file=path//'/.', exist=is_directory)
  end function is_directory

  !> Error where a name is of what is no regular file: a directory, a device and a pipe cannot be written at any place in them, and
  !> must not be taken away. Nothing but a regular file that is empty can be cut to nothing.
  subroutine expect_regular(path, purpose, error)
    character(len=*), intent(in) :: path
    character(len=*), intent(in) :: purpose   !! what the file is for, with an article
    type(error_t), allocatable, intent(out) :: error
    logical :: there

    inquire (file=path, exist=there)
    if (is_directory(path)) then
      call fail(error, status_bad_input, path//': expected a file for '//purpose//', found a directory')
    else if (there .and. .not. holds_something(path)) then
      if (.not. set_length(path, 0_int64)) &
        call fail(error, status_bad_input, path//': expected a file for '//purpose//', found a device, a pipe or a protected file')
    end if
  end subroutine expect_regular

  !> Cuts a regular file, or lengthens it with a hole, which takes no space. False where that cannot be.
  logical function set_length(path, length)
    character(len=*), intent(in) :: path
    integer(int64), intent(in) :: length    !! bytes

    set_length = c_truncate(path//c_null_char, int(length, c_int64_t)) == 0
  end function set_length

  !> Whether two names, by any path or link, mean one file that is not empty.
  logical function same_file(a, b)
    character(len=*), intent(in) :: a, b
    integer :: number, status, unit

    same_file = holds_something(a)
    if (same_file) same_file = holds_something(b)
    if (.not. same_file) return
    same_file = .false.
    open (newunit=unit, file=a, access='stream', form='unformatted', action='read', status='old', iostat=status)
    if (status /= 0) return
    inquire (file=b, number=number) ! the compiler's library knows an open file by device and number, not by its name
    same_file = number == unit
    close (unit)
  end function same_file

  !> The first `n` bytes of a file, or as many as it has; '' where it cannot be read.
  function beginning_of(path, n) result(text)
    character(len=*), intent(in) :: path
    integer, intent(in) :: n
    character(len=:), allocatable :: text
    integer(int64) :: size_
    integer :: status, unit

    text = ''
    open (newunit=unit, file=path, access='stream', form='unformatted', action='read', status='old', iostat=status)
    if (status /= 0) return
    inquire (unit, size=size_)
    text = repeat(' ', int(min(int(n, int64), max(0_int64, size_))))
    read (unit, iostat=status) text
    close (unit)
    if (status /= 0) text = ''
  end function beginning_of

  !> Error that a file is not written over.
  subroutine refuse_to_replace(path, kind, error)
    character(len=*), intent(in) :: path
    character(len=*), intent(in) :: kind !! that would be written, with an article
    type(error_t), allocatable, intent(out) :: error

    call fail(error, status_bad_input, path//': expected a new file or '//kind//' to write over, found another file')
  end subroutine refuse_to_replace

  !> Whether the system has taken every byte: the compiler's library does not say where a close could not write.
  subroutine check_size(path, expected, status, reason)
    character(len=*), intent(in) :: path
    integer(int64), intent(in) :: expected   !! bytes
    integer, intent(out) :: status           !! 0: it has
    character(len=*), intent(inout) :: reason
    integer(int64) :: found

    inquire (file=path, size=found)
    status = merge(0, 1, found >= expected)
    if (status /= 0) write (reason, '(2(a,i0),a)') 'the system has taken ', max(found, 0_int64), ' of ', expected, &
      ' bytes: the disk may be full'
  end subroutine check_size

  !> The name that symbolic links lead to, whether there is a file yet or not.
  function without_links(path) result(name)
    character(len=*), intent(in) :: path
    character(len=:), allocatable :: name, target_
    character(kind=c_char) :: bytes(longest_path)
    integer :: i, k, n

    name = path
    do k = 1, most_links
      n = int(c_readlink(name//c_null_char, bytes, size(bytes, kind=c_size_t)))
      if (n < 0) return
      allocate (character(len=n) :: target_)
      do i = 1, n
        target_(i:i) = bytes(i)
      end do
      if (index(target_, '/') /= 1) target_ = name(:index(name, '/', back=.true.))//target_
      call move_alloc(target_, name)
    end do
  end function without_links

  !> Gives a file another name, at once, that of a file which is there where that is so. False where that cannot be.
  logical function move_file(from, to)
    character(len=*), intent(in) :: from, to

    move_file = c_rename(from//c_null_char, to//c_null_char) == 0
  end function move_file

  !> Takes a file away, if it is there.
  subroutine remove_file(path)
    character(len=*), intent(in) :: path
    integer(c_int) :: status

    status = c_unlink(path//c_null_char)
  end subroutine remove_file

end module scree_files
