!> On which side of a line a point lies, right for every input.
!>
!> The sign of a 2 x 2 determinant of differences. A bound on the rounding settles almost every case; the rest is summed
!> exactly as an expansion of non-overlapping doubles (Shewchuk 1997, "Adaptive Precision Floating-Point Arithmetic and
!> Fast Robust Geometric Predicates", sections 2 and 4.1). Exact as long as nothing overflows or underflows, in IEEE
!> arithmetic that does not fuse a product and a sum.
module scree_predicates
  use scree_kinds, only: dp
  implicit none
  private
  public :: orientation

  real(dp), parameter :: half_ulp = epsilon(1.0_dp)/2
  real(dp), parameter :: rounding = (3 + 16*half_ulp)*half_ulp !! Shewchuk: ccwerrboundA
  real(dp), parameter :: splitter = 2.0_dp**27 + 1

contains

  !> 1 where a, b, c turn counter-clockwise, -1 where clockwise, 0 where they are on one line.
  pure integer function orientation(a, b, c)
    real(dp), intent(in) :: a(2), b(2), c(2)
    real(dp) :: left, right, det

    left = (a(1) - c(1))*(b(2) - c(2))
    right = (a(2) - c(2))*(b(1) - c(1))
    det = left - right
    if (abs(det) > rounding*(abs(left) + abs(right))) then
      orientation = merge(1, -1, det > 0)
    else
      orientation = exact_orientation(a, b, c)
    end if
  end function orientation

  !> The sign of a_x b_y - a_x c_y - c_x b_y - a_y b_x + a_y c_x + c_y b_x, without rounding.
  pure integer function exact_orientation(a, b, c)
    real(dp), intent(in) :: a(2), b(2), c(2)
    real(dp) :: expansion(12), factor(2, 6), product(2)
    integer :: i

    factor = reshape([a(1), b(2), -a(1), c(2), -c(1), b(2), -a(2), b(1), a(2), c(1), c(2), b(1)], [2, 6])
    expansion = 0.0_dp
    do i = 1, 6
      product = exact_product(factor(1, i), factor(2, i))
      call grow(expansion(:2*i - 1), product(2))
      call grow(expansion(:2*i), product(1))
    end do
    exact_orientation = 0
    do i = 12, 1, -1 ! the last that is not zero is larger than all others together
      if (expansion(i) > 0) exact_orientation = 1
      if (expansion(i) < 0) exact_orientation = -1
      if (exact_orientation /= 0) return
    end do
  end function exact_orientation

  !> Adds a number to an expansion, whose last position is free.
  pure subroutine grow(expansion, number)
    real(dp), intent(inout) :: expansion(:)
    real(dp), intent(in) :: number
    real(dp) :: carried, sum, part
    integer :: i, n

    n = size(expansion)
    carried = number
    do i = 1, n - 1
      sum = carried + expansion(i)
      part = sum - carried
      expansion(i) = (carried - (sum - part)) + (expansion(i) - part)
      carried = sum
    end do
    expansion(n) = carried
  end subroutine grow

  !> The rounded product, and what the rounding lost (Dekker 1971).
  pure function exact_product(x, y) result(product)
    real(dp), intent(in) :: x, y
    real(dp) :: product(2), a(2), b(2)

    a = halves(x)
    b = halves(y)
    product(1) = x*y
    product(2) = a(2)*b(2) - (((product(1) - a(1)*b(1)) - a(2)*b(1)) - a(1)*b(2))
  end function exact_product

  !> A number as the sum of two whose products are exact (Veltkamp 1968).
  pure function halves(x)
    real(dp), intent(in) :: x
    real(dp) :: halves(2), large

    large = splitter*x
    halves(1) = large - (large - x)
    halves(2) = x - halves(1)
  end function halves

end module scree_predicates
