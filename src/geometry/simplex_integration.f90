!> Integrals of x^i y^j over polygons (Shi 1984; the closed form of every DDA and NMM matrix).
module scree_simplex_integration
  use scree_kinds, only: dp
  implicit none
  private
  public :: moments_t, polygon_area, polygon_centroid, polygon_moments, simplex_integrals

  !> Area, centroid and second moments about the centroid.
  type :: moments_t
    real(dp) :: area = 0.0_dp        !! length^2
    real(dp) :: centroid(2) = 0.0_dp !! length
    real(dp) :: second(3) = 0.0_dp   !! integrals of X^2, Y^2, X Y about the centroid, length^4
  end type moments_t

contains

  !> Integrals of x^i y^j for all i + j <= order over the inside of closed loops.
  !>
  !> The sum over edges of the signed simplex (origin, p, q). With f = p_x q_y - q_x p_y,
  !>
  !>     int x^i y^j = f i! j! / (i+j+2)! c_ij,
  !>
  !> where c_ij is the coefficient of s^i t^j in 1 / ((1 - s p_x - t p_y)(1 - s q_x - t q_y)): two
  !> recursions, one a factor. Take the origin near the polygon: far from it the simplices cancel.
  pure function simplex_integrals(vertex, first, order) result(integral)
    real(dp), intent(in) :: vertex(:, :) !! (2, n), length
    integer, intent(in) :: first(:)      !! (n_loops+1) loop k owns vertices first(k):first(k+1)-1
    integer, intent(in) :: order         !! largest i + j
    real(dp) :: integral(0:order, 0:order) !! (i, j), length^(i+j+2); 0 where i + j > order
    real(dp) :: c(0:order, 0:order), f
    integer :: i, j, k, loop, next

    integral = 0.0_dp
    do loop = 1, size(first) - 1
      do k = first(loop), first(loop + 1) - 1
        next = k + 1
        if (next == first(loop + 1)) next = first(loop)
        f = vertex(1, k)*vertex(2, next) - vertex(1, next)*vertex(2, k)
        c = 0.0_dp
        c(0, 0) = 1.0_dp
        call multiply_by_geometric_series(vertex(:, k), c)
        call multiply_by_geometric_series(vertex(:, next), c)
        integral = integral + f*c
      end do
    end do
    do j = 0, order
      do i = 0, order - j
        integral(i, j) = integral(i, j)*factor(i, j)
      end do
      integral(order - j + 1:, j) = 0.0_dp
    end do
  end function simplex_integrals

  !> Multiplies the power series c(s, t) by 1 / (1 - s p_x - t p_y), up to its order.
  pure subroutine multiply_by_geometric_series(p, c)
    real(dp), intent(in) :: p(2)
    real(dp), intent(inout) :: c(0:, 0:)
    integer :: i, j, order

    order = ubound(c, 1)
    do i = 1, order
      c(i, 0) = c(i, 0) + p(1)*c(i - 1, 0)
    end do
    do j = 1, order
      c(0, j) = c(0, j) + p(2)*c(0, j - 1)
      do i = 1, order - j
        c(i, j) = c(i, j) + p(1)*c(i - 1, j) + p(2)*c(i, j - 1)
      end do
    end do
  end subroutine multiply_by_geometric_series

  !> i! j! / (i+j+2)!
  pure real(dp) function factor(i, j)
    integer, intent(in) :: i, j
    integer :: k

    factor = 1.0_dp/real((i + j + 1)*(i + j + 2), dp)
    do k = 1, j
      factor = factor*k/real(i + k, dp)
    end do
  end function factor

  !> Area, centroid and central second moments of the inside of closed loops (Shi: S, Sx, Sy, Sxx, Syy, Sxy).
  !>
  !> Integrated from the first vertex, then from the centroid, so that a polygon far from the origin loses nothing.
  pure function polygon_moments(vertex, first) result(moments)
    real(dp), intent(in) :: vertex(:, :) !! (2, n), length
    integer, intent(in) :: first(:)      !! (n_loops+1) loop k owns vertices first(k):first(k+1)-1
    type(moments_t) :: moments
    real(dp) :: local(2, size(vertex, 2)), quadratic(0:2, 0:2), shift(2)

    call integrate_linear(vertex, first, moments%area, shift)
    moments%centroid = vertex(:, 1) + shift
    local = vertex - spread(vertex(:, 1), 2, size(vertex, 2)) - spread(shift, 2, size(vertex, 2))
    quadratic = simplex_integrals(local, first, 2)
    moments%second = [quadratic(2, 0), quadratic(0, 2), quadratic(1, 1)]
  end function polygon_moments

  !> Area of the inside of closed loops, as of `polygon_moments`.
  pure real(dp) function polygon_area(vertex, first) result(area)
    real(dp), intent(in) :: vertex(:, :) !! (2, n), length
    integer, intent(in) :: first(:)      !! (n_loops+1), as there
    real(dp) :: shift(2)

    call integrate_linear(vertex, first, area, shift)
  end function polygon_area

  !> Centroid of the inside of closed loops, as of `polygon_moments`.
  pure function polygon_centroid(vertex, first) result(centroid)
    real(dp), intent(in) :: vertex(:, :) !! (2, n), length
    integer, intent(in) :: first(:)      !! (n_loops+1), as there
    real(dp) :: centroid(2), area

    call integrate_linear(vertex, first, area, centroid)
    centroid = vertex(:, 1) + centroid
  end function polygon_centroid

  !> Area of the inside of closed loops, and the way from their first vertex to its centroid; 0 where there is no area.
  !>
  !> These are the integrals of 1, x and y from the first vertex, edge by edge, as of `simplex_integrals`.
  pure subroutine integrate_linear(vertex, first, area, shift)
    real(dp), intent(in) :: vertex(:, :) !! (2, n), length
    integer, intent(in) :: first(:)      !! (n_loops+1) loop k owns vertices first(k):first(k+1)-1
    real(dp), intent(out) :: area        !! length^2
    real(dp), intent(out) :: shift(2)    !! length
    real(dp) :: f, p(2), q(2)
    integer :: k, loop

    area = 0.0_dp
    shift = 0.0_dp
    do loop = 1, size(first) - 1
      q = vertex(:, first(loop)) - vertex(:, 1)
      do k = first(loop), first(loop + 1) - 1
        p = q
        q = vertex(:, merge(first(loop), k + 1, k + 1 == first(loop + 1))) - vertex(:, 1)
        f = p(1)*q(2) - q(1)*p(2)
        area = area + f
        shift = shift + f*(p + q)
      end do
    end do
    area = factor(0, 0)*area
    if (abs(area) > 0) then
      shift = factor(1, 0)*shift/area
    else
      shift = 0.0_dp
    end if
  end subroutine integrate_linear

end module scree_simplex_integration
