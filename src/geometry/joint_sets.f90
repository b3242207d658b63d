!> Statistical joint sets (Shi: dl): parallel lines, on each of them traces and bridges of rock by turns, clipped to the rock.
!>
!> Spacing, length and bridge are mean (1 + randomness (2u - 1)) with u uniform in [0, 1). The first line, and the first trace of
!> each line, belong to a stationary process. The interval that covers the edge is drawn with a probability in proportion to its
!> length, and the edge lies at a uniform place in it. So the means hold from the edge on.
module scree_joint_sets
  use scree_kinds, only: dp, pi
  use scree_random_numbers, only: next_uniform, random_t, split_random
  use scree_rock_outline, only: clip_line, rock_t
  use scree_scene, only: line_t
  implicit none
  private
  public :: bounds_of, draw_joints, draw_traces, expected_traces, joint_set_t

  !> Mean values of a joint set.
  type :: joint_set_t
    real(dp) :: dip = 0.0_dp        !! of the traces from the x axis, counter-clockwise, degrees
    real(dp) :: spacing = 1.0_dp    !! of neighbouring lines, length
    real(dp) :: length = 1.0_dp     !! of a trace, length
    real(dp) :: bridge = 0.0_dp     !! of rock between traces of a line, length
    real(dp) :: randomness = 0.0_dp !! 0 regular, 1 from nothing to twice the mean
    integer :: material = 1         !! joint material
    integer :: deck_line = 0        !! where it stands in its deck
  end type joint_set_t

contains

  !> Draws joint sets and clips them to the rock. Each set has its own stream of random numbers, so that the others stay
  !> as they are when one is changed. Parts that are not longer than `shortest` are left out.
  pure subroutine draw_joints(rock, sets, seed, shortest, lines)
    type(rock_t), intent(in) :: rock
    type(joint_set_t), intent(in) :: sets(:)
    integer, intent(in) :: seed
    real(dp), intent(in) :: shortest
    type(line_t), allocatable, intent(out) :: lines(:)
    type(random_t) :: random, own
    real(dp), allocatable :: trace(:, :, :)
    real(dp) :: low(2), high(2)
    integer :: i, k, n

    allocate (lines(16))
    n = 0
    random%state = seed
    do i = 1, size(sets)
      call split_random(random, own)
      call bounds_of(rock%outline(1)%corner, sets(i)%dip, low, high)
      call draw_traces(sets(i), low, high, own, trace)
      do k = 1, size(trace, 3)
        call clip_line(rock, trace(:, :, k), shortest, sets(i)%material, sets(i)%deck_line, lines, n)
      end do
    end do
    lines = lines(:n)
  end subroutine draw_joints

  !> Draws the traces of a set that reach into a rectangle along and across it; whole, line by line.
  pure subroutine draw_traces(set, low, high, random, trace)
    type(joint_set_t), intent(in) :: set
    real(dp), intent(in) :: low(2), high(2) !! of the rectangle: along the traces, across to their left, length
    type(random_t), intent(inout) :: random
    real(dp), allocatable, intent(out) :: trace(:, :, :) !! (xy, end, trace), length
    real(dp), allocatable :: longer(:, :, :)
    real(dp) :: along(2), across(2), at, line, interval(1), pair(2), u
    integer :: n

    along = direction(set%dip)
    across = [-along(2), along(1)]
    allocate (trace(2, 2, 64))
    n = 0
    call draw_covering(random, [set%spacing], set%randomness, interval)
    call next_uniform(random, u)
    line = low(2) + (1 - u)*interval(1)
    do while (line <= high(2))
      call draw_covering(random, [set%length, set%bridge], set%randomness, pair)
      call next_uniform(random, u)
      at = low(1) - u*sum(pair)
      do while (at <= high(1))
        if (at + pair(1) >= low(1)) then
          if (n == size(trace, 3)) then
            allocate (longer(2, 2, 2*n))
            longer(:, :, :n) = trace
            call move_alloc(longer, trace)
          end if
          n = n + 1
          trace(:, 1, n) = at*along + line*across
          trace(:, 2, n) = (at + pair(1))*along + line*across
        end if
        at = at + sum(pair)
        call draw(random, [set%length, set%bridge], set%randomness, pair)
      end do
      call draw(random, [set%spacing], set%randomness, interval)
      line = line + interval(1)
    end do
    trace = trace(:, :, :n)
  end subroutine draw_traces

  !> Draws numbers about their means.
  pure subroutine draw(random, mean, randomness, x)
    type(random_t), intent(inout) :: random
    real(dp), intent(in) :: mean(:), randomness
    real(dp), intent(out) :: x(:)
    real(dp) :: u
    integer :: i

    do i = 1, size(x)
      call next_uniform(random, u)
      x(i) = mean(i)*(1 + randomness*(2*u - 1))
    end do
  end subroutine draw

  !> Draws numbers about their means, with a probability in proportion to their sum: by rejection.
  pure subroutine draw_covering(random, mean, randomness, x)
    type(random_t), intent(inout) :: random
    real(dp), intent(in) :: mean(:), randomness
    real(dp), intent(out) :: x(:)
    real(dp) :: u

    do
      call draw(random, mean, randomness, x)
      call next_uniform(random, u)
      if (u*(1 + randomness)*sum(mean) <= sum(x)) return
    end do
  end subroutine draw_covering

  !> Least and largest coordinate of corners along a dip and across it, to its left.
  pure subroutine bounds_of(corner, dip, low, high)
    real(dp), intent(in) :: corner(:, :), dip
    real(dp), intent(out) :: low(2), high(2)
    real(dp) :: along(2), turned(2, size(corner, 2))

    along = direction(dip)
    turned(1, :) = along(1)*corner(1, :) + along(2)*corner(2, :)
    turned(2, :) = along(1)*corner(2, :) - along(2)*corner(1, :)
    low = minval(turned, 2)
    high = maxval(turned, 2)
  end subroutine bounds_of

  !> Traces that a set has in the mean in a rectangle.
  pure real(dp) function expected_traces(set, low, high)
    type(joint_set_t), intent(in) :: set
    real(dp), intent(in) :: low(2), high(2)

    expected_traces = (1 + (high(2) - low(2))/set%spacing)*(1 + (high(1) - low(1))/(set%length + set%bridge))
  end function expected_traces

  !> Unit vector of a dip in degrees.
  pure function direction(dip)
    real(dp), intent(in) :: dip
    real(dp) :: direction(2)
    real(dp), parameter :: degree = pi/180

    direction = [cos(dip*degree), sin(dip*degree)]
  end function direction

end module scree_joint_sets
