!> Polygons: area, and what is inside.
module scree_polygon
  use scree_kinds, only: dp
  use scree_predicates, only: orientation
  implicit none
  private
  public :: holds, twice_area

contains

  !> Twice the area inside a polygon, negative where it turns clockwise.
  pure real(dp) function twice_area(vertex)
    real(dp), intent(in) :: vertex(:, :) !! (2, n), length
    real(dp) :: a(2), b(2)
    integer :: k

    twice_area = 0.0_dp
    do k = 2, size(vertex, 2) - 1
      a = vertex(:, k) - vertex(:, 1)
      b = vertex(:, k + 1) - vertex(:, 1)
      twice_area = twice_area + a(1)*b(2) - a(2)*b(1)
    end do
  end function twice_area

  !> Whether loops hold a place, their edges included: a ray to the right crosses them an odd number of times.
  pure logical function holds(vertex, place, first)
    real(dp), intent(in) :: vertex(:, :)       !! (2, n), length
    real(dp), intent(in) :: place(2)           !! length
    integer, intent(in), optional :: first(:)  !! (n_loops+1) loop k owns vertices first(k):first(k+1)-1; one loop where absent
    integer :: k, loop, n_loops, next, from, to, turn

    holds = .false.
    n_loops = 1
    if (present(first)) n_loops = size(first) - 1
    do loop = 1, n_loops
      from = 1
      to = size(vertex, 2)
      if (present(first)) then
        from = first(loop)
        to = first(loop + 1) - 1
      end if
      do k = from, to
        next = k + 1
        if (k == to) next = from
        associate (p => vertex(:, k), q => vertex(:, next))
          if ((p(1) < place(1) .and. q(1) < place(1)) .or. (p(2) < place(2) .and. q(2) < place(2)) .or. &
              (p(2) > place(2) .and. q(2) > place(2))) cycle
          turn = orientation(p, q, place)
          if (turn == 0 .and. dot_product(p - place, q - place) <= 0) then
            holds = .true. ! on the edge
            return
          end if
          if ((p(2) > place(2)) .eqv. (q(2) > place(2))) cycle
          if ((turn > 0) .eqv. (q(2) > p(2))) holds = .not. holds
        end associate
      end do
    end do
  end function holds

end module scree_polygon
