!> How a failure travels: an allocated `error_t` is a failure, an unallocated one is success.
module scree_errors
  implicit none
  private
  public :: error_t, fail

  integer, parameter, public :: status_run_failed = 1 !! exit status of a run that failed
  integer, parameter, public :: status_bad_input = 2  !! exit status of input that cannot be run
  integer, parameter, public :: status_signal = 128   !! and the number of a signal: exit status of a run that it stopped

  !> The message of a failure, written once, for a person.
  type :: error_t
    integer :: status = status_run_failed    !! exit status of the program
    character(len=:), allocatable :: message !! one line: where, expected, found
  end type error_t

contains

  !> Makes `error` a failure.
  pure subroutine fail(error, status, message)
    type(error_t), allocatable, intent(out) :: error
    integer, intent(in) :: status           !! one of the `status_...` constants
    character(len=*), intent(in) :: message !! one line

    allocate (error)
    error%status = status
    error%message = message
  end subroutine fail

end module scree_errors
