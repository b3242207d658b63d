!> Standard output: how wide it is, and lines of it that are known to be written or not. The compiler's library does not say where
!> it could not write them.
module scree_screen
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_long, c_short, c_size_t, c_intptr_t
  use scree_c_errors, only: last_error, words_of_error
  implicit none
  private
  public :: folded, is_terminal, print_text, screen_columns

  integer(c_int), parameter :: standard_output = 1
  integer(c_long), parameter :: ask_window = 21523 !! TIOCGWINSZ of Linux
  integer, parameter :: usual_columns = 80         !! of a terminal that does not say
  character(len=*), parameter :: indent = '  '     !! of what follows the first piece of a line

  !> C: struct winsize of Linux and the BSDs.
  type, bind(c) :: window_t
    integer(c_short) :: rows = 0, columns = 0, width = 0, height = 0
  end type window_t

  interface
    integer(c_int) function c_isatty(descriptor) bind(c, name='isatty')
      import :: c_int
      integer(c_int), value :: descriptor
    end function c_isatty

    !> C: asks a terminal. The argument after the request is the address of the answer.
    integer(c_int) function c_ioctl(descriptor, request, window) bind(c, name='ioctl')
      import :: c_int, c_long, window_t
      integer(c_int), value :: descriptor
      integer(c_long), value :: request
      type(window_t), intent(inout) :: window
    end function c_ioctl

    !> POSIX: writes bytes, and says how many; below 0 where it fails.
    integer(c_intptr_t) function c_write(descriptor, bytes, n) bind(c, name='write')
      import :: c_char, c_int, c_intptr_t, c_size_t
      integer(c_int), value :: descriptor
      character(kind=c_char), intent(in) :: bytes(*)
      integer(c_size_t), value :: n
    end function c_write
  end interface

contains

  !> Whether standard output is a terminal.
  logical function is_terminal()
    is_terminal = c_isatty(standard_output) /= 0
  end function is_terminal

  !> Letters that a line of the terminal has room for.
  integer function screen_columns() result(columns)
    type(window_t) :: window

    columns = 0
    if (c_ioctl(standard_output, ask_window, window) == 0) columns = window%columns
    if (columns <= 0) columns = usual_columns
  end function screen_columns

  !> Writes a text at once. `reason` says why it could not be written, and is empty where it was.
  subroutine print_text(text, reason)
    character(len=*), intent(in) :: text
    character(len=:), allocatable, intent(out) :: reason
    integer :: done, n

    reason = ''
    done = 0
    do while (done < len(text))
      n = int(c_write(standard_output, text(done + 1:), int(len(text) - done, c_size_t)))
      if (n < 0) then
        reason = words_of_error(last_error())
        return
      end if
      done = done + n
    end do
  end subroutine print_text

  !> A line in pieces of so many letters at most, a line each, parted at blanks. A word that is longer stays whole.
  pure function folded(line, columns)
    character(len=*), intent(in) :: line
    integer, intent(in) :: columns
    character(len=:), allocatable :: folded, rest
    integer :: at, more

    folded = ''
    rest = line
    do while (len(rest) > columns)
      at = index(rest(:columns + 1), ' ', back=.true.)
      if (verify(rest(:max(0, at - 1)), ' ') == 0) then ! its first word is longer
        more = index(rest(verify(rest, ' '):), ' ')
        if (more == 0) exit
        at = verify(rest, ' ') + more - 1
      end if
      folded = folded//trim(rest(:at - 1))//new_line('a')
      rest = indent//trim(adjustl(rest(at + 1:)))
    end do
    folded = folded//rest
  end function folded

end module scree_screen
