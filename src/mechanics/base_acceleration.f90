!> Inertia force of the elements in the frame of a ground that accelerates.
module scree_base_acceleration
  use scree_element_term, only: add_force, step_rule_t, term_t
  use scree_interpolation, only: kinematics_t
  use scree_kinds, only: dp
  use scree_scene, only: time_table_t
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: add_base_acceleration, base_acceleration_t, mean_over, work_of_base

  !> Called for when the ground accelerates at some time.
  type :: base_acceleration_t
    type(time_table_t) :: record !! acceleration of the ground, length/time^2
  end type base_acceleration_t

contains

  !> Adds -m T(c)^T a: the integral of rho T^T over a linear field is m T(c)^T, as that of X about the centroid is 0.
  pure subroutine add_base_acceleration(self, mass, rule, element, term)
    type(base_acceleration_t), intent(in) :: self
    real(dp), intent(in) :: mass !! mass/length
    type(step_rule_t), intent(in) :: rule
    type(kinematics_t), intent(in) :: element
    type(term_t), intent(inout) :: term

    call add_force(term, -mass*matmul(mean_over(self%record, rule%record_from, rule%record_to), element%at_centroid))
  end subroutine add_base_acceleration

  !> Work of the inertia force of one element in a step, force per unit thickness times length.
  pure real(dp) function work_of_base(self, mass, rule, element, unknown)
    type(base_acceleration_t), intent(in) :: self
    real(dp), intent(in) :: mass                      !! mass/length
    type(step_rule_t), intent(in) :: rule
    type(kinematics_t), intent(in) :: element
    real(dp), intent(in) :: unknown(element_unknowns) !! of the step

    work_of_base = -mass*dot_product(mean_over(self%record, rule%end_time - rule%dt, rule%end_time), &
                                     matmul(element%at_centroid, unknown))
  end function work_of_base

  !> Mean of a record from one time to another, exact; at one time its value.
  !>
  !> Linear between the times of the record, zero before the first and after the last.
  pure function mean_over(record, from, to) result(mean)
    type(time_table_t), intent(in) :: record
    real(dp), intent(in) :: from, to !! time, `from` not after `to`
    real(dp) :: mean(2), left, right, last
    integer :: i

    mean = 0.0_dp
    left = max(from, record%time(1))
    last = min(to, record%time(size(record%time)))
    if (left > last) return
    i = interval_of(record%time, left)
    if (.not. to > from) then
      mean = value_in(i, left)
      return
    end if
    do while (left < last)
      right = min(last, record%time(i + 1))
      mean = mean + (right - left)*value_in(i, 0.5_dp*(left + right))
      left = right
      i = i + 1
    end do
    mean = mean/(to - from)

  contains

    !> Value within interval `i`.
    pure function value_in(i, time) result(value)
      integer, intent(in) :: i
      real(dp), intent(in) :: time
      real(dp) :: value(2)

      associate (t => record%time, v => record%value)
        value = v(:, i) + (time - t(i))/(t(i + 1) - t(i))*(v(:, i + 1) - v(:, i))
      end associate
    end function value_in

  end function mean_over

  !> The interval between two of the times that holds one, the later where two do.
  pure integer function interval_of(times, time)
    real(dp), intent(in) :: times(:) !! ascending, two or more
    real(dp), intent(in) :: time
    integer :: above, middle

    interval_of = 1
    above = size(times)
    do while (above - interval_of > 1)
      middle = (interval_of + above)/2
      if (times(middle) <= time) then
        interval_of = middle
      else
        above = middle
      end if
    end do
  end function interval_of

end module scree_base_acceleration
