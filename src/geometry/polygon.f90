!> Polygons of one or more loops: area, and what is inside.
module scree_polygon
  use scree_kinds, only: dp
  use scree_predicates, only: orientation
  use scree_regions, only: vertices_after
  use scree_simplex_integration, only: polygon_centroid
  use scree_sorting, only: sort_by
  implicit none
  private
  public :: distance_to_segment, holds, inner_place, nearest_on_segment, twice_area, winding_numbers

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

  !> Distance of a position from the straight between two others.
  pure real(dp) function distance_to_segment(position, a, b)
    real(dp), intent(in) :: position(2), a(2), b(2) !! length

    distance_to_segment = norm2(nearest_on_segment(position, a, b) - position)
  end function distance_to_segment

  !> The place on the straight between two others that is nearest to a position, length.
  pure function nearest_on_segment(position, a, b) result(nearest)
    real(dp), intent(in) :: position(2), a(2), b(2) !! length
    real(dp) :: nearest(2), side(2)

    side = b - a
    nearest = a + max(0.0_dp, min(1.0_dp, dot_product(position - a, side)/max(dot_product(side, side), tiny(1.0_dp))))*side
  end function nearest_on_segment

  !> How often loops run counter-clockwise around each of some positions that are on none of their edges.
  !>
  !> Each edge is held against the positions that are level with it alone.
  pure function winding_numbers(vertex, position, first) result(winding)
    real(dp), intent(in) :: vertex(:, :)       !! (2, n), length
    real(dp), intent(in) :: position(:, :)     !! (2, m), length
    integer, intent(in) :: first(:)            !! (n_loops+1) loop k owns vertices first(k):first(k+1)-1
    integer :: winding(size(position, 2))
    integer :: i, k, next(first(size(first)) - 1), order(size(position, 2))
    real(dp) :: y(size(position, 2))

    winding = 0
    order = [(k, k=1, size(order))]
    y = position(2, :)
    call sort_by(y, order)
    next = vertices_after(first)
    do k = 1, size(next)
      associate (p => vertex(:, k), q => vertex(:, next(k)))
        do i = n_below(y, min(p(2), q(2))) + 1, n_below(y, max(p(2), q(2)))
          if (q(2) > p(2)) then
            if (orientation(p, q, position(:, order(i))) > 0) winding(order(i)) = winding(order(i)) + 1
          else
            if (orientation(p, q, position(:, order(i))) < 0) winding(order(i)) = winding(order(i)) - 1
          end if
        end do
      end associate
    end do
  end function winding_numbers

  !> How many of some ascending numbers are below a limit.
  pure integer function n_below(x, limit)
    real(dp), intent(in) :: x(:), limit
    integer :: high, middle

    n_below = 0
    high = size(x)
    do while (n_below < high)
      middle = (n_below + high + 1)/2
      if (x(middle) < limit) then
        n_below = middle
      else
        high = middle - 1
      end if
    end do
  end function n_below

  !> Whether loops hold a position, their edges included: a ray to the right crosses them an odd number of times.
  pure logical function holds(vertex, position, first)
    real(dp), intent(in) :: vertex(:, :)       !! (2, n), length
    real(dp), intent(in) :: position(2)           !! length
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
          if ((p(1) < position(1) .and. q(1) < position(1)) .or. (p(2) < position(2) .and. q(2) < position(2)) .or. &
              (p(2) > position(2) .and. q(2) > position(2))) cycle
          turn = orientation(p, q, position)
          if (turn == 0 .and. dot_product(p - position, q - position) <= 0) then
            holds = .true. ! on the edge
            return
          end if
          if ((p(2) > position(2)) .eqv. (q(2) > position(2))) cycle
          if ((turn > 0) .eqv. (q(2) > p(2))) holds = .not. holds
        end associate
      end do
    end do
  end function holds

  !> A position well inside a polygon.
  !>
  !> It is the centroid where that lies inside, else the middle of a horizontal run between two levels of corners.
  pure function inner_place(vertex, first) result(position)
    real(dp), intent(in) :: vertex(:, :)       !! (2, n), length
    integer, intent(in), optional :: first(:)  !! (n_loops+1), as in `holds`
    real(dp) :: position(2)
    real(dp), parameter :: close = 0.05_dp ! of the size of the polygon
    real(dp) :: room
    integer, allocatable :: next(:), start(:)
    integer :: k

    start = [1, size(vertex, 2) + 1]
    if (present(first)) start = first
    next = vertices_after(start)
    position = polygon_centroid(vertex, start)
    room = huge(room)
    do k = 1, size(vertex, 2)
      room = min(room, distance_to_segment(position, vertex(:, k), vertex(:, next(k))))
    end do
    if (room > close*maxval(maxval(vertex, 2) - minval(vertex, 2))) then
      if (holds(vertex, position, start)) return
    end if
    position = middle_of_run(vertex, next)
  end function inner_place

  !> The middle of the horizontal run between two levels of corners for which the smaller of its length and of the distance between
  !> the levels is the largest.
  pure function middle_of_run(vertex, next) result(position)
    real(dp), intent(in) :: vertex(:, :)       !! (2, n), length
    integer, intent(in) :: next(:)             !! (n) vertex after each, around its loop
    real(dp) :: position(2)
    real(dp) :: above, best, crossing(size(vertex, 2)), level(size(vertex, 2)), room, y
    real(dp), allocatable :: drop(:)
    integer :: best_corner, corner(size(vertex, 2)), g, k, n, none(size(vertex, 2))
    integer, allocatable :: gap(:), top(:)

    position = vertex(:, 1)
    corner = [(k, k=1, size(corner))]
    level = vertex(2, :)
    call sort_by(level, corner)
    top = pack([(k, k=2, size(level))], level(2:) > level(:size(level) - 1)) ! the first corner above each gap between levels
    drop = level(top - 1) - level(top)
    gap = [(g, g=1, size(top))]
    call sort_by(drop, gap)
    best = -1.0_dp
    best_corner = 0
    do g = 1, size(gap) ! from the widest gap, as a narrower one has no more room
      if (-drop(g) < best) exit
      k = 1
      if (gap(g) > 1) k = top(gap(g) - 1)
      associate (i => (corner(k))) ! the first corner below the gap
        above = level(top(gap(g)))
        y = vertex(2, i) + (above - vertex(2, i))/2
        n = 0
        do k = 1, size(vertex, 2)
          associate (a => vertex(:, k), b => vertex(:, next(k)))
            if (a(2) > y .eqv. b(2) > y) cycle
            n = n + 1
            crossing(n) = a(1) + (b(1) - a(1))*((y - a(2))/(b(2) - a(2)))
          end associate
        end do
        call sort_by(crossing(:n), none(:n))
        do k = 1, n - 1, 2
          room = min(crossing(k + 1) - crossing(k), above - vertex(2, i))
          if (room < best .or. (i >= best_corner .and. .not. room > best)) cycle
          best = room
          best_corner = i
          position = [(crossing(k) + crossing(k + 1))/2, y]
        end do
      end associate
    end do
  end function middle_of_run

end module scree_polygon
