!> Whose turn it is among programs that would make a file in one directory at once.
module scree_turns
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_int, c_null_char, c_null_ptr, c_ptr
  implicit none
  private
  public :: give_turn, take_turn

  integer(c_int), parameter :: lock_alone = 2 !! LOCK_EX

  interface
    !> C: opens a directory.
    type(c_ptr) function c_opendir(path) bind(c, name='opendir')
      import :: c_char, c_ptr
      character(kind=c_char), intent(in) :: path(*)
    end function c_opendir

    !> C: the descriptor of an open directory.
    integer(c_int) function c_dirfd(directory) bind(c, name='dirfd')
      import :: c_int, c_ptr
      type(c_ptr), value :: directory
    end function c_dirfd

    !> C: closes a directory.
    integer(c_int) function c_closedir(directory) bind(c, name='closedir')
      import :: c_int, c_ptr
      type(c_ptr), value :: directory
    end function c_closedir

    !> C: locks a file; waits for its turn.
    integer(c_int) function c_flock(descriptor, operation) bind(c, name='flock')
      import :: c_int
      integer(c_int), value :: descriptor, operation
    end function c_flock
  end interface

contains

  !> Waits until no other program has its turn in the directory of a file. The system ends the turn of a program that is killed.
  !> Where the directory cannot be opened or locked, as on some file systems of a net, nobody waits.
  subroutine take_turn(path, turn)
    character(len=*), intent(in) :: path
    type(c_ptr), intent(out) :: turn         !! to be given up; null: there is none
    integer(c_int) :: status

    turn = c_opendir(path(:index(path, '/', back=.true.))//'.'//c_null_char)
    if (c_associated(turn)) status = c_flock(c_dirfd(turn), lock_alone)
  end subroutine take_turn

  !> Lets others have their turn.
  subroutine give_turn(turn)
    type(c_ptr), intent(inout) :: turn
    integer(c_int) :: status

    if (c_associated(turn)) status = c_closedir(turn)
    turn = c_null_ptr
  end subroutine give_turn

end module scree_turns
