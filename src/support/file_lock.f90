!> The lock of the run that writes a file. The system gives it up with the file, so a run that is killed leaves none behind.
!>
!> It is a lock of POSIX (`lockf`), which programs that only read do not ask for: they may read while the run goes on. Of a
!> process the system drops it as soon as any descriptor of the same file is closed, so whoever holds it opens the file once.
!> Beside it stands a shared lock of the BSDs (`flock`), as other programs with HDF5 take to read: they may read, not write.
module scree_file_lock
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_int, c_int64_t, c_null_char, c_ptr
  use scree_c_errors, only: last_error
  implicit none
  private
  public :: is_locked, lock_file, may_write

  integer(c_int), parameter :: try_to_lock = 2, test_lock = 3 !! F_TLOCK, F_TEST
  integer(c_int), parameter :: shared_at_once = 5             !! LOCK_SH and LOCK_NB
  integer(c_int), parameter :: held(2) = [11, 13]             !! EAGAIN, EACCES of Linux: another program has it

  interface
    !> C: opens a file.
    type(c_ptr) function c_fopen(path, mode) bind(c, name='fopen')
      import :: c_char, c_ptr
      character(kind=c_char), intent(in) :: path(*), mode(*)
    end function c_fopen

    !> C: closes a file.
    integer(c_int) function c_fclose(file) bind(c, name='fclose')
      import :: c_int, c_ptr
      type(c_ptr), value :: file
    end function c_fclose

    !> C: the descriptor of an open file.
    integer(c_int) function c_fileno(file) bind(c, name='fileno')
      import :: c_int, c_ptr
      type(c_ptr), value :: file
    end function c_fileno

    !> C: locks a file from where it stands, here its beginning; length 0: all of it.
    integer(c_int) function c_lockf(descriptor, command, length) bind(c, name='lockf')
      import :: c_int, c_int64_t
      integer(c_int), value :: descriptor, command
      integer(c_int64_t), value :: length
    end function c_lockf

    !> C: locks a file as the BSDs do.
    integer(c_int) function c_flock(descriptor, operation) bind(c, name='flock')
      import :: c_int
      integer(c_int), value :: descriptor, operation
    end function c_flock
  end interface

contains

  !> Locks a file that is open to be written, until it is closed. False where another program holds its lock.
  !>
  !> Some file systems of a net have no locks: there nothing is locked, and the file is ours like any other.
  logical function lock_file(descriptor)
    integer(c_int), intent(in) :: descriptor
    integer(c_int) :: status

    lock_file = .true.
    if (c_lockf(descriptor, try_to_lock, 0_c_int64_t) /= 0) lock_file = .not. any(last_error() == held)
    if (lock_file) status = c_flock(descriptor, shared_at_once)
  end function lock_file

  !> Whether another program holds the lock of a file.
  logical function is_locked(path)
    character(len=*), intent(in) :: path
    type(c_ptr) :: file
    integer(c_int) :: status

    is_locked = .false.
    file = c_fopen(path//c_null_char, 'rb'//c_null_char)
    if (.not. c_associated(file)) return
    if (c_lockf(c_fileno(file), test_lock, 0_c_int64_t) /= 0) is_locked = any(last_error() == held)
    status = c_fclose(file)
  end function is_locked

  !> Whether the system lets us write a file that is there; nothing in it changes.
  logical function may_write(path)
    character(len=*), intent(in) :: path
    type(c_ptr) :: file
    integer(c_int) :: status

    file = c_fopen(path//c_null_char, 'r+b'//c_null_char)
    may_write = c_associated(file)
    if (may_write) status = c_fclose(file)
  end function may_write

end module scree_file_lock
