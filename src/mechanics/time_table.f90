!> Values of a table at a time, and their mean over a step (Shi's df09).
module scree_time_table
  use scree_kinds, only: dp
  use scree_scene, only: time_table_t
  implicit none
  private
  public :: last_change, mean_of_ramp, mean_over, ramp_at, value_at

contains

  !> Time from which each of some tables has the value that it has for ever; before all times where none changes.
  pure real(dp) function last_change(table) result(time)
    type(time_table_t), intent(in) :: table(:)
    integer :: i, last

    time = -huge(time)
    do i = 1, size(table)
      if (.not. allocated(table(i)%time)) cycle
      associate (t => table(i)%time, v => table(i)%value)
        last = size(t)
        if (table(i)%kept .or. maxval(abs(v(:, last))) <= 0) then
          do while (last > 1)
            if (maxval(abs(v(:, last) - v(:, last - 1))) > 0) exit
            last = last - 1
          end do
          if (last == 1) cycle
        end if
        time = max(time, t(last))
      end associate
    end do
  end function last_change

  !> Value of a table: linear between its times; outside its first and last value, or zero where it does not keep them.
  pure function value_at(table, time) result(value)
    type(time_table_t), intent(in) :: table
    real(dp), intent(in) :: time
    real(dp) :: value(2)
    integer :: i

    associate (t => table%time, v => table%value)
      i = times_until(t, time)
      if (i > 0 .and. i < size(t)) then
        value = v(:, i) + (time - t(i))/(t(i + 1) - t(i))*(v(:, i + 1) - v(:, i))
      else if (table%kept .or. .not. (time < t(1) .or. time > t(size(t)))) then
        value = v(:, max(i, 1))
      else
        value = 0.0_dp
      end if
    end associate
  end function value_at

  !> Mean of a table from one time to another, exact; at one time its value.
  pure function mean_over(table, from, to) result(mean)
    type(time_table_t), intent(in) :: table
    real(dp), intent(in) :: from, to !! time, `from` not after `to`
    real(dp) :: mean(2), left, right
    integer :: i

    if (.not. to > from) then
      mean = value_at(table, to)
      return
    end if
    mean = 0.0_dp
    left = from
    i = times_until(table%time, from)
    do while (left < to)
      i = i + 1
      right = to
      if (i <= size(table%time)) right = min(to, table%time(i))
      mean = mean + (right - left)/(to - from)*value_at(table, 0.5_dp*(left + right))
      left = right
    end do
  end function mean_over

  !> Fraction of a load that grows evenly from 0 at time 0 to all of it at the end of a ramp.
  pure real(dp) function ramp_at(ramp, time) result(share)
    real(dp), intent(in) :: ramp     !! time; 0: none
    real(dp), intent(in) :: time

    share = 1.0_dp
    if (ramp > 0 .and. time < ramp) share = max(0.0_dp, time)/ramp
  end function ramp_at

  !> Its mean from one time to another, exact; at one time its value.
  pure real(dp) function mean_of_ramp(ramp, from, to) result(mean)
    real(dp), intent(in) :: ramp     !! time; 0: none
    real(dp), intent(in) :: from, to !! time, `from` not after `to`

    if (.not. ramp > 0 .or. from >= ramp) then
      mean = 1.0_dp
    else if (.not. to > from) then
      mean = ramp_at(ramp, to)
    else
      mean = (area_until(to) - area_until(from))/(to - from)
    end if

  contains

    !> Integral of the fraction up to a time.
    pure real(dp) function area_until(time)
      real(dp), intent(in) :: time

      area_until = 0.5_dp*max(0.0_dp, min(time, ramp))**2/ramp + max(0.0_dp, time - ramp)
    end function area_until

  end function mean_of_ramp

  !> How many of the times are not after one.
  pure integer function times_until(times, time)
    real(dp), intent(in) :: times(:) !! ascending
    real(dp), intent(in) :: time
    integer :: above, middle

    times_until = 0
    above = size(times) + 1
    do while (above - times_until > 1)
      middle = (times_until + above)/2
      if (times(middle) <= time) then
        times_until = middle
      else
        above = middle
      end if
    end do
  end function times_until

end module scree_time_table
