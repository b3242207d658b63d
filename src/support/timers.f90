!> Cost of each phase of a run: how often it begins, its wall-clock time and its processor time.
!>
!> One phase goes on at any time; where the next begins it ends, so the phases make up the whole run. All begins are counted,
!> but not each lap from one phase to the next is timed: a step of one block takes 4 us, and a reading of the clock 30 ns. Readings
!> may cost a small fraction of the time of a phase.
!>
!> - In a phase with long laps both clocks time each lap.
!> - In a phase with shorter laps the clock of the processor, which costs a system call, is left out.
!> - In a phase with short laps a random sample is timed, and each timed lap counts for those since the one before.
!>
!> The time that the first kind leaves of the whole is divided among the other phases in proportion to their samples. So times add
!> up to the whole.
module scree_timers
  use scree_kinds, only: dp, i8
  use scree_random_numbers, only: next_uniform, random_t
  implicit none
  private
  public :: begin_phase, begin_timers, cost_t, costs_of, end_phase, timers_t

  integer, parameter, public :: phase_read = 1, phase_set_up = 2, phase_search = 3, phase_alone = 4, phase_assemble = 5, &
                                phase_factor = 6, phase_solve = 7, phase_judge = 8, phase_friction = 9, &
                                phase_restitution = 10, phase_check = 11, phase_update = 12, phase_sleep = 13, &
                                phase_history = 14, phase_frames = 15, phase_other = 16
  integer, parameter :: n = 16
  character(len=*), parameter :: phase_name(n) = [character(len=12) :: &
    'read', 'set-up', 'search', 'alone', 'assemble', 'factor', 'solve', 'judge', 'friction', 'restitution', 'check', 'update', &
    'sleep', 'history', 'frames', 'other']

  !> Fraction of the time of a phase that reading the clocks may take. A timed lap takes two readings, and their evaluation as long.
  real(dp), parameter :: share = 1.0_dp/1000
  real(dp), parameter :: most_laps = 1000.0_dp !! between two that are timed, on average
  !> Times the mean of its phase from which on a lap counts once, not for others: the process had to wait, or it is a rare one.
  real(dp), parameter :: longest = 50.0_dp

  !> Cost of a phase.
  type :: cost_t
    character(len=12) :: phase = ''
    integer :: calls = 0
    real(dp) :: wall = 0.0_dp        !! s
    real(dp) :: processor = 0.0_dp   !! s
    real(dp) :: share = 0.0_dp       !! of the wall time of the run
  end type cost_t

  !> Instants of both clocks, s.
  type :: instant_t
    real(dp) :: wall = 0.0_dp, processor = 0.0_dp
  end type instant_t

  !> The laps of a phase.
  type :: laps_t
    integer(i8) :: resumed = 0       !! laps with which it went on, after one within it
    integer(i8) :: timed = 0         !! lap that was timed last
    logical :: long = .true.         !! laps are worth reading the clock of the processor
    type(instant_t) :: whole         !! time of the laps that were timed by both clocks, s
    real(dp) :: shared = 0.0_dp      !! wall time of the others, as those that were timed say, s
  end type laps_t

  !> All phases, and the lap that goes on.
  type :: timers_t
    private
    integer(i8) :: laps(n) = 0       !! of each phase so far
    integer(i8) :: next(n) = 1       !! lap of each that is to be timed next
    type(laps_t) :: of(n)
    integer :: phase = phase_other, outer = phase_other !! now, and before
    logical :: timed = .false.       !! the lap is
    logical :: by_both = .false.     !! by both clocks
    type(instant_t) :: begun, from   !! when the timers began, and the lap
    type(instant_t) :: price         !! of one reading, s
    type(random_t) :: random
  end type timers_t

contains

  !> Begins to time the whole.
  subroutine begin_timers(timers)
    type(timers_t), intent(out) :: timers
    type(instant_t) :: first, second
    integer :: i

    timers%price = instant_t(huge(1.0_dp), huge(1.0_dp))
    do i = 1, 10
      first = instant_t(wall_clock(), processor_clock())
      timers%price%processor = min(timers%price%processor, max(0.0_dp, wall_clock() - first%wall))
      first%wall = wall_clock()
      second%wall = wall_clock()
      timers%price%wall = min(timers%price%wall, max(0.0_dp, second%wall - first%wall))
    end do
    timers%begun = instant_t(wall_clock(), processor_clock())
    call begin_phase(timers, phase_other)
  end subroutine begin_timers

  !> Begins a phase; the one before ends.
  subroutine begin_phase(timers, phase)
    type(timers_t), intent(inout) :: timers
    integer, intent(in) :: phase

    logical :: timed

    timers%laps(phase) = timers%laps(phase) + 1
    timed = timers%laps(phase) >= timers%next(phase)
    if (timed .or. timers%timed) call read_clocks(phase, timed, timers)
    timers%outer = timers%phase
    timers%phase = phase
  end subroutine begin_phase

  !> Ends a phase that began within another one, which goes on.
  subroutine end_phase(timers)
    type(timers_t), intent(inout) :: timers

    integer :: outer

    outer = timers%outer
    timers%of(outer)%resumed = timers%of(outer)%resumed + 1
    call begin_phase(timers, outer)
  end subroutine end_phase

  !> Costs so far of all phases that began.
  function costs_of(timers) result(cost)
    type(timers_t), intent(in) :: timers
    type(cost_t), allocatable :: cost(:)
    type(timers_t) :: ended
    type(instant_t) :: left, whole
    real(dp) :: shared
    integer :: i

    ended = timers
    call read_clocks(phase_other, .false., ended)
    whole = instant_t(wall_clock() - timers%begun%wall, processor_clock() - timers%begun%processor)
    left = instant_t(max(0.0_dp, whole%wall - sum(ended%of%whole%wall)), &
                     max(0.0_dp, whole%processor - sum(ended%of%whole%processor)))
    if (.not. sum(ended%of%shared) > 0) ended%of(phase_other)%shared = 1.0_dp
    shared = sum(ended%of%shared)
    allocate (cost(n))
    do i = 1, n
      associate (own => ended%of(i))
        cost(i) = cost_t(phase_name(i), int(timers%laps(i) - own%resumed), own%whole%wall + left%wall*own%shared/shared, &
                         own%whole%processor + left%processor*own%shared/shared)
      end associate
    end do
    cost%share = cost%wall/max(sum(cost%wall), tiny(1.0_dp))
    cost = pack(cost, ended%laps > 0)
  end function costs_of

  !> Ends a lap, and begins the next, if they are timed.
  subroutine read_clocks(phase, timed, timers)
    integer, intent(in) :: phase       !! that begins
    logical, intent(in) :: timed       !! its lap is to be
    type(timers_t), intent(inout) :: timers
    type(instant_t) :: now
    logical :: by_both

    now%wall = wall_clock()
    by_both = timed .and. timers%of(phase)%long
    if (by_both .or. timers%timed .and. timers%by_both) now%processor = processor_clock()
    if (timers%timed) call take_lap(timers, now)
    timers%timed = timed
    timers%by_both = by_both
    timers%from = now
  end subroutine read_clocks

  !> Takes in a lap that was timed, and draws the one of its phase that is to be timed next.
  subroutine take_lap(timers, now)
    type(timers_t), intent(inout) :: timers
    type(instant_t), intent(in) :: now
    real(dp) :: between, drawn, lap, mean

    associate (own => timers%of(timers%phase), laps => timers%laps(timers%phase), next => timers%next(timers%phase))
      lap = now%wall - timers%from%wall
      if (timers%by_both) then
        own%whole%wall = own%whole%wall + lap
        own%whole%processor = own%whole%processor + now%processor - timers%from%processor
      else
        mean = (own%whole%wall + own%shared)/real(own%timed, dp)
        own%shared = own%shared + lap + real(laps - own%timed - 1, dp)*min(lap, longest*mean)
      end if
      own%timed = laps
      mean = (own%whole%wall + own%shared)/real(laps, dp)
      own%long = 2*timers%price%processor <= share*mean
      between = min(most_laps, real(laps, dp), 2*timers%price%wall/max(share*mean, tiny(mean)))
      call next_uniform(timers%random, drawn)
      next = laps + 1
      if (between > 1) next = next + nint(2*drawn*(between - 1))
    end associate
  end subroutine take_lap

  !> Time of the wall, s.
  real(dp) function wall_clock()
    integer(i8) :: now, rate

    call system_clock(now, rate)
    wall_clock = real(now, dp)/real(rate, dp)
  end function wall_clock

  !> Time of the processor in this process, s.
  real(dp) function processor_clock()
    call cpu_time(processor_clock)
  end function processor_clock

end module scree_timers
