!> Forecast of the time that a run takes, from its first steps.
!>
!> A probe records how far each step got and when. The rest of the run is assumed to cost as much as the steps of the probe, or as
!> the rest of another run of the scene that reached its end. Seconds are processor seconds. A run uses one processor, so other work
!> of the machine is not in them.
module scree_forecast
  use scree_kinds, only: dp
  implicit none
  private
  public :: amounts_t, begin_probe, enough, forecast_of, forecast_t, note_step, probe_t, seconds_of, steps_of

  !> Fractions of a probe from which on its speed is measured: the first gives the forecast, the others its range.
  real(dp), parameter :: pace_from(4) = [0.75_dp, 0.0_dp, 0.25_dp, 0.5_dp]

  !> The steps of a run that may end early.
  type :: probe_t
    real(dp) :: most = 0.0_dp              !! what it may take, s
    logical :: ended = .false.             !! the run came to its end
    integer :: n = 0                       !! steps noted
    real(dp), allocatable :: share(:)      !! (>= n) of the run that is done with each
    real(dp), allocatable :: seconds(:)    !! (>= n) since the probe began, of the processor, s
    real(dp), private :: begun = 0.0_dp    !! of the processor, s
  end type probe_t

  !> How much a run had taken, of seconds or steps, where it had got to.
  type :: amounts_t
    logical :: ended = .false.
    real(dp), allocatable :: share(:)      !! (n) of the run, rising
    real(dp), allocatable :: amount(:)     !! (n) rising
  end type amounts_t

  !> Forecast of an amount, with its range.
  type :: forecast_t
    real(dp) :: value = 0.0_dp, low = 0.0_dp, high = 0.0_dp
  end type forecast_t

contains

  !> Begins a probe.
  subroutine begin_probe(most, probe)
    real(dp), intent(in) :: most  !! s
    type(probe_t), intent(out) :: probe

    probe%most = most
    allocate (probe%share(1000), probe%seconds(1000))
    call cpu_time(probe%begun)
  end subroutine begin_probe

  !> Records a step, or, with a fraction of 0, that steps begin.
  subroutine note_step(share, probe)
    real(dp), intent(in) :: share !! of the run that is done
    type(probe_t), intent(inout) :: probe
    real(dp) :: now

    if (probe%n == size(probe%share)) then
      probe%share = [probe%share, probe%share]
      probe%seconds = [probe%seconds, probe%seconds]
    end if
    probe%n = probe%n + 1
    probe%share(probe%n) = share
    call cpu_time(now)
    probe%seconds(probe%n) = now - probe%begun
  end subroutine note_step

  !> Whether a probe has used its time, and allows a forecast.
  logical function enough(probe)
    type(probe_t), intent(in) :: probe

    enough = .false.
    if (probe%n > 1) enough = probe%seconds(probe%n) - probe%seconds(1) > probe%most
  end function enough

  !> The seconds of a probe.
  pure function seconds_of(probe) result(amounts)
    type(probe_t), intent(in) :: probe
    type(amounts_t) :: amounts

    amounts = amounts_t(probe%ended, probe%share(:probe%n), probe%seconds(:probe%n))
  end function seconds_of

  !> The steps of a probe.
  pure function steps_of(probe) result(amounts)
    type(probe_t), intent(in) :: probe
    type(amounts_t) :: amounts
    integer :: i

    amounts = amounts_t(probe%ended, probe%share(:probe%n), [(real(i - 1, dp), i=1, probe%n)])
  end function steps_of

  !> Forecast of the amount of work of a run, which is known for a run that ended.
  !>
  !> The speed of the last quarter of the probe is extrapolated; the range comes from the speeds from other points on. Where another
  !> run ended, the rest over what was done is that of the other run; otherwise it follows from the fraction of the run that is
  !> done.
  pure function forecast_of(done, shape) result(forecast)
    type(amounts_t), intent(in) :: done            !! at least of two points
    type(amounts_t), intent(in), optional :: shape !! of another run
    type(forecast_t) :: forecast
    real(dp) :: whole(size(pace_from))
    integer :: from, i, n

    n = size(done%share)
    whole = done%amount(n)
    if (.not. done%ended) then
      do i = 1, size(pace_from)
        from = count(done%share < pace_from(i)*done%share(n))
        from = max(1, min(n - 1, from))
        associate (now => work_until(done%share(n), shape), before => work_until(done%share(from), shape))
          whole(i) = done%amount(n) + (done%amount(n) - done%amount(from))*(1 - now)/max(epsilon(now), now - before)
        end associate
      end do
    end if
    forecast = forecast_t(whole(1), minval(whole), maxval(whole))
  end function forecast_of

  !> Fraction of the work of a run that is done at a fraction of its time.
  pure real(dp) function work_until(share, shape) result(work)
    real(dp), intent(in) :: share
    type(amounts_t), intent(in), optional :: shape
    integer :: i, n

    work = share
    if (.not. present(shape)) return
    n = size(shape%share)
    if (.not. shape%amount(n) > shape%amount(1)) return
    i = max(1, min(n - 1, count(shape%share <= share)))
    work = shape%amount(i)
    if (shape%share(i + 1) > shape%share(i)) &
      work = work + (shape%amount(i + 1) - shape%amount(i))*(share - shape%share(i))/(shape%share(i + 1) - shape%share(i))
    work = (work - shape%amount(1))/(shape%amount(n) - shape%amount(1))
  end function work_until

end module scree_forecast
