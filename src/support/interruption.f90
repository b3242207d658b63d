!> Signals that ask a run to stop, and the signal of a limit of file size.
!>
!> The handler of SIGINT (Ctrl-C) and SIGTERM (kill, the end of a batch job) sets a flag. The run stops between two tries of a step,
!> where no file is being written. Another signal, a second or two later, ends the program at once. Signals that come with the first
!> are the same request: `timeout` and batch systems send one to a process and one to its group. Blocking the signals and polling
!> them would need no flag, but the threads of the linear algebra would take a signal that only this thread blocks.
module scree_interruption
  use, intrinsic :: iso_c_binding, only: c_funloc, c_int, c_intptr_t, c_long, c_null_ptr, c_ptr
  implicit none
  private
  public :: heed_signals, ignore_size_limit, signal_name, stop_signal

  integer(c_int), parameter :: interrupt = 2, terminate = 15, file_too_large = 25 !! SIGINT, SIGTERM, SIGXFSZ of Linux
  integer(c_intptr_t), parameter :: default_action = 0, ignored = 1 !! SIG_DFL, SIG_IGN

  !> The signal that came first, 0: none, and when. A handler takes no arguments of ours and can leave word nowhere else.
  integer(c_int), volatile :: received = 0
  integer(c_long), volatile :: came_at = 0 !! s

  interface
    !> C: sets the handler of a signal, and returns the handler before.
    function c_signal(number, handler) bind(c, name='signal')
      import :: c_int, c_intptr_t
      integer(c_int), value :: number
      integer(c_intptr_t), value :: handler
      integer(c_intptr_t) :: c_signal
    end function c_signal

    !> C: sends the program a signal.
    integer(c_int) function c_raise(number) bind(c, name='raise')
      import :: c_int
      integer(c_int), value :: number
    end function c_raise

    !> C: the time in seconds.
    integer(c_long) function c_time(there) bind(c, name='time')
      import :: c_long, c_ptr
      type(c_ptr), value :: there
    end function c_time
  end interface

contains

  !> Lets SIGINT and SIGTERM leave word from now on, unless they are ignored, as in a background job.
  subroutine heed_signals()
    integer(c_int), parameter :: number(2) = [interrupt, terminate]
    integer(c_intptr_t) :: before
    integer :: i

    do i = 1, size(number)
      before = c_signal(number(i), transfer(c_funloc(leave_word), 0_c_intptr_t))
      if (before == ignored) before = c_signal(number(i), ignored)
    end do
  end subroutine heed_signals

  !> The handler.
  subroutine leave_word(number) bind(c)
    integer(c_int), value :: number
    integer(c_intptr_t) :: before
    integer(c_int) :: sent

    if (received == 0) then
      came_at = c_time(c_null_ptr)
      received = number
    else if (c_time(c_null_ptr) - came_at > 1) then
      before = c_signal(number, default_action)
      sent = c_raise(number)
    end if
  end subroutine leave_word

  !> The signal that asks to stop, 0: none has.
  integer function stop_signal()
    stop_signal = received
  end function stop_signal

  !> Name of a signal that asks to stop.
  pure function signal_name(number) result(name)
    integer, intent(in) :: number
    character(len=:), allocatable :: name

    name = trim(merge('SIGINT ', 'SIGTERM', number == interrupt))
  end function signal_name

  !> Makes a write beyond a limit of file size an error with words, not the end.
  subroutine ignore_size_limit()
    integer(c_intptr_t) :: before

    before = c_signal(file_too_large, ignored)
  end subroutine ignore_size_limit

end module scree_interruption
