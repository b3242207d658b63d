!> How far a run is: one line rewritten on a terminal, lines in a log, nothing when quiet. A log has a line at each tenth of a run,
!> and after ten seconds without one.
module scree_progress
  use, intrinsic :: iso_fortran_env, only: error_unit
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_kinds, only: dp, i8
  use scree_screen, only: folded, is_terminal, print_text, screen_columns
  use scree_text, only: append, number_text, text_t
  implicit none
  private
  public :: check_told, end_progress, is_due, line_is_due, line_of_run, progress_t, set_up_progress, show_line, stays_short, tell, &
            tell_whole, warn

  real(dp), parameter :: between_lines = 0.1_dp, most_silent = 10.0_dp !! s, on a terminal; in a log
  real(dp), parameter :: hour = 3600.0_dp, day = 24*hour               !! s
  !> Steps below this fraction of the size that was asked for are short; so many in a row that take so long are worth a message.
  real(dp), parameter :: short_share = 0.5_dp, long = 3.0_dp !! long: s
  integer, parameter :: many = 20

  !> The last line shown, and when.
  type :: progress_t
    logical :: quiet = .false.
    logical :: terminal = .false.
    integer :: shown_tenths = 0
    integer :: open_letters = 0                 !! of the line that stands on the terminal and is written over
    character(len=:), allocatable :: reason     !! why something could not be told; empty: all could
    integer(i8) :: begun = 0, shown = 0         !! clock
    real(dp) :: from = 0.0_dp                   !! fraction of the run that was done when it began
    type(text_t), allocatable :: warning(:)     !! that were given
    integer :: short = 0                        !! steps in a row that are short
    integer(i8) :: short_since = 0              !! clock
    logical :: told_of_short = .false.
  end type progress_t

contains

  !> Begins.
  subroutine set_up_progress(quiet, progress)
    logical, intent(in) :: quiet
    type(progress_t), intent(out) :: progress

    progress%quiet = quiet
    allocate (progress%warning(0))
    progress%terminal = is_terminal()
    progress%reason = ''
    call system_clock(progress%begun)
    progress%shown = progress%begun
  end subroutine set_up_progress

  !> Whether it is time for a line of the run.
  logical function line_is_due(progress, share, goes_on)
    type(progress_t), intent(in) :: progress
    real(dp), intent(in) :: share           !! of the run that is done, from 0 to 1
    logical, intent(in) :: goes_on          !! after this step
    integer(i8) :: now, rate

    line_is_due = .false.
    if (progress%quiet) return
    call system_clock(now, rate)
    line_is_due = is_due(progress%terminal, real(now - progress%shown, dp)/real(rate, dp), int(10*share) - progress%shown_tenths, &
                         goes_on)
  end function line_is_due

  !> Shows the line of a run: on a terminal over the line before it.
  subroutine show_line(progress, share, facts)
    type(progress_t), intent(inout) :: progress
    real(dp), intent(in) :: share           !! of the run that is done, from 0 to 1
    type(text_t), intent(in) :: facts(:)    !! what more there is to say, the most important first
    character(len=:), allocatable :: line
    real(dp) :: left, spent
    integer(i8) :: now, rate
    integer :: columns

    call system_clock(now, rate)
    progress%shown = now
    progress%shown_tenths = int(10*share)
    spent = real(now - progress%begun, dp)/real(rate, dp)
    left = huge(left)
    if (share > progress%from) left = spent*((1 - share)/(share - progress%from))
    if (progress%terminal) then
      columns = screen_columns() - 1 ! some terminals go on to the next line where the last column is taken
      line = line_of_run(left, share, facts, columns)
      call print(progress, achar(13)//line//repeat(' ', max(0, min(progress%open_letters, columns) - len(line))))
      progress%open_letters = len(line)
    else
      call print(progress, line_of_run(left, share, facts, huge(columns))//new_line('a'))
    end if
  end subroutine show_line

  !> Whether it is time for a line.
  pure logical function is_due(terminal, silent, tenths, goes_on)
    logical, intent(in) :: terminal
    real(dp), intent(in) :: silent  !! time since the last line, s
    integer, intent(in) :: tenths   !! of the time of the run that were done since then
    logical, intent(in) :: goes_on  !! after this step

    if (terminal) then
      is_due = silent >= between_lines .or. .not. goes_on
    else
      is_due = silent >= most_silent .or. tenths > 0
    end if
  end function is_due

  !> The line of a run with at most so many letters: the time that is left, the fraction that is done, and as many facts as fit.
  pure function line_of_run(left, share, facts, columns) result(line)
    real(dp), intent(in) :: left            !! s, of the clock
    real(dp), intent(in) :: share           !! of the run that is done, from 0 to 1
    type(text_t), intent(in) :: facts(:)    !! the most important first
    integer, intent(in) :: columns
    character(len=:), allocatable :: line, longer
    integer :: i

    line = 'left '//duration(left)
    if (len(line) > columns) line = duration(left)
    line = line(:min(len(line), columns))
    longer = line//'  '//number_text(int(100*share))//' %'
    do i = 1, size(facts) + 1
      if (len(longer) > columns) return
      line = longer
      if (i <= size(facts)) longer = line//'  '//facts(i)%text
    end do
  end function line_of_run

  !> Whether steps have been short for so long that one who waits at a terminal is to know why: true once in a run.
  logical function stays_short(progress, dt, asked)
    type(progress_t), intent(inout) :: progress
    real(dp), intent(in) :: dt, asked   !! time
    integer(i8) :: now, rate

    stays_short = .false.
    if (progress%quiet .or. .not. progress%terminal .or. progress%told_of_short) return
    if (dt >= short_share*asked) progress%short = 0
    if (dt >= short_share*asked) return
    if (progress%short == 0) call system_clock(progress%short_since)
    progress%short = progress%short + 1
    if (progress%short < many) return
    call system_clock(now, rate)
    stays_short = real(now - progress%short_since, dp) > long*real(rate, dp)
    progress%told_of_short = stays_short
  end function stays_short

  !> Ends the line on a terminal.
  subroutine end_progress(progress)
    type(progress_t), intent(inout) :: progress

    if (progress%open_letters > 0) call print(progress, new_line('a'))
    progress%open_letters = 0
  end subroutine end_progress

  !> Says a line, unless quiet. On a terminal it is parted at blanks where it is longer than that is wide.
  subroutine tell(progress, line)
    type(progress_t), intent(inout) :: progress
    character(len=*), intent(in) :: line

    if (progress%quiet) return
    call end_progress(progress)
    if (progress%terminal) then
      call print(progress, folded(line, screen_columns() - 1)//new_line('a'))
    else
      call print(progress, line//new_line('a'))
    end if
  end subroutine tell

  !> Says a line as it is, quiet or not.
  subroutine tell_whole(progress, line)
    type(progress_t), intent(inout) :: progress
    character(len=*), intent(in) :: line

    call end_progress(progress)
    call print(progress, line//new_line('a'))
  end subroutine tell_whole

  !> Writes to standard output; keeps why that could not be.
  subroutine print(progress, text)
    type(progress_t), intent(inout) :: progress
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: reason

    call print_text(text, reason)
    if (len(reason) > 0) progress%reason = reason
  end subroutine print

  !> Error where something could not be told. A run goes on without, and ends with this.
  pure subroutine check_told(progress, kept, error)
    type(progress_t), intent(in) :: progress
    character(len=*), intent(in) :: kept     !! file that has all of it
    type(error_t), allocatable, intent(out) :: error

    if (len(progress%reason) > 0) &
      call fail(error, status_run_failed, 'standard output: cannot write: '//progress%reason//'; what there is to know is in '// &
                kept)
  end subroutine check_told

  !> Warns on the error unit, quiet or not.
  subroutine warn(progress, line)
    type(progress_t), intent(inout) :: progress
    character(len=*), intent(in) :: line

    call append(progress%warning, line)
    call end_progress(progress)
    write (error_unit, '(a)') 'scree: warning: '//line
  end subroutine warn

  !> Seconds as a person says them.
  pure function duration(seconds)
    real(dp), intent(in) :: seconds
    character(len=:), allocatable :: duration
    character(len=16) :: buffer
    integer :: s

    if (.not. seconds < 1e6_dp*day) then
      duration = '?'
      return
    else if (seconds >= 100*hour) then
      duration = number_text(nint(seconds/day))//' days'
      return
    end if
    s = nint(seconds)
    write (buffer, '(i0,a,i2.2,a,i2.2)') s/3600, ':', modulo(s/60, 60), ':', modulo(s, 60)
    duration = trim(buffer)
  end function duration

end module scree_progress
