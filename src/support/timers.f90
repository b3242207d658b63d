!> What each phase of a run costs.
module scree_timers
  use scree_kinds, only: dp, i8
  implicit none
  private
  public :: start_phase, stop_phase, timer_t

  !> Time of one phase.
  type :: timer_t
    integer :: calls = 0
    real(dp) :: wall = 0.0_dp          !! s
    real(dp) :: processor = 0.0_dp     !! s
    integer(i8) :: wall_from = 0
    real(dp) :: processor_from = 0.0_dp
  end type timer_t

contains

  !> Begins to count.
  subroutine start_phase(timer)
    type(timer_t), intent(inout) :: timer

    timer%calls = timer%calls + 1
    call system_clock(timer%wall_from)
    call cpu_time(timer%processor_from)
  end subroutine start_phase

  !> Ends to count.
  subroutine stop_phase(timer)
    type(timer_t), intent(inout) :: timer
    integer(i8) :: now, rate
    real(dp) :: processor

    call system_clock(now, rate)
    call cpu_time(processor)
    timer%wall = timer%wall + real(now - timer%wall_from, dp)/real(rate, dp)
    timer%processor = timer%processor + processor - timer%processor_from
  end subroutine stop_phase

end module scree_timers
