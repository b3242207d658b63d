!> How far a run is: one line rewritten on a terminal, a line each tenth of the time in a log, nothing when quiet.
module scree_progress
  use, intrinsic :: iso_c_binding, only: c_int
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use scree_kinds, only: dp, i8
  use scree_text, only: text_t
  implicit none
  private
  public :: end_progress, progress_t, set_up_progress, show_step, stays_short, tell, warn

  real(dp), parameter :: between_lines = 0.1_dp !! s, on a terminal
  !> Steps below this share of the size that was asked for are short; so many in a row that take so long are worth a word.
  real(dp), parameter :: short_share = 0.5_dp, long = 3.0_dp !! long: s
  integer, parameter :: many = 20

  !> What was shown and when.
  type :: progress_t
    logical :: quiet = .false.
    logical :: terminal = .false.
    integer :: shown_tenths = 0
    logical :: line_open = .false.
    integer(i8) :: begun = 0, shown = 0         !! clock
    real(dp) :: from = 0.0_dp                   !! time of the run when it began
    type(text_t), allocatable :: warning(:)     !! that were given
    integer :: short = 0                        !! steps in a row that are short
    integer(i8) :: short_since = 0              !! clock
    logical :: told_of_short = .false.
  end type progress_t

  interface
    integer(c_int) function isatty(descriptor) bind(c, name='isatty')
      import :: c_int
      integer(c_int), value :: descriptor
    end function isatty
  end interface

contains

  !> Begins.
  subroutine set_up_progress(quiet, progress)
    logical, intent(in) :: quiet
    type(progress_t), intent(out) :: progress

    progress%quiet = quiet
    allocate (progress%warning(0))
    progress%terminal = isatty(1_c_int) /= 0
    call system_clock(progress%begun)
    progress%shown = progress%begun
  end subroutine set_up_progress

  !> Shows a step where it is time to.
  subroutine show_step(progress, step, time, end_time, dt, iterations)
    type(progress_t), intent(inout) :: progress
    integer, intent(in) :: step, iterations
    real(dp), intent(in) :: time, end_time, dt
    character(len=120) :: line
    real(dp) :: left, spent
    integer(i8) :: now, rate
    integer :: tenths

    if (progress%quiet) return
    tenths = int(10*time/end_time)
    if (.not. progress%terminal .and. tenths <= progress%shown_tenths) return
    call system_clock(now, rate)
    if (progress%terminal .and. real(now - progress%shown, dp) < between_lines*real(rate, dp) .and. time < end_time) return
    progress%shown = now
    progress%shown_tenths = tenths
    spent = real(now - progress%begun, dp)/real(rate, dp)
    left = spent*(end_time - time)/max(time - progress%from, tiny(time))
    write (line, '(a,i0,a,es11.4,a,es11.4,a,es10.3,a,i0,a,a)') 'step ', step, '  time', time, ' of', end_time, '  dt', dt, &
      '  iterations ', iterations, '  left ', duration(left)
    if (progress%terminal) then
      write (output_unit, '(a)', advance='no') achar(13)//line(:78)
      progress%line_open = .true.
    else
      write (output_unit, '(a)') trim(line)
    end if
    flush (output_unit)
  end subroutine show_step

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

    if (progress%line_open) write (output_unit, '(a)') ''
    progress%line_open = .false.
  end subroutine end_progress

  !> Says a line, unless quiet.
  subroutine tell(progress, line)
    type(progress_t), intent(inout) :: progress
    character(len=*), intent(in) :: line

    if (progress%quiet) return
    call end_progress(progress)
    write (output_unit, '(a)') line
  end subroutine tell

  !> Warns on the error unit, quiet or not.
  subroutine warn(progress, line)
    type(progress_t), intent(inout) :: progress
    character(len=*), intent(in) :: line

    progress%warning = [progress%warning, text_t(line)]
    call end_progress(progress)
    write (error_unit, '(a)') 'scree: warning: '//line
  end subroutine warn

  !> Seconds as a person says them.
  function duration(seconds)
    real(dp), intent(in) :: seconds
    character(len=:), allocatable :: duration
    character(len=16) :: buffer
    integer :: s

    if (seconds > 359999.0_dp) then
      duration = 'days'
      return
    end if
    s = nint(seconds)
    write (buffer, '(i0,a,i2.2,a,i2.2)') s/3600, ':', modulo(s/60, 60), ':', modulo(s, 60)
    duration = trim(buffer)
  end function duration

end module scree_progress
