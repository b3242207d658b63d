!> The pieces of edges of blocks that lie on lines of the deck, or below a water table.
module scree_edges_on_lines
  use scree_kinds, only: dp
  use scree_sorting, only: sort_by
  use scree_state, only: state_t
  use scree_system, only: system_t
  implicit none
  private
  public :: add_point, depth_at, gap_t, largest_gap, piece_t, pieces_beside, pieces_on_line, pieces_under_water

  !> An edge that lies on a line leans from it by less than this (sine).
  real(dp), parameter :: least_turn = 1e-2_dp
  !> Pieces shorter than this fraction of their line are none.
  real(dp), parameter :: shortest = 1e-9_dp

  !> Parts of a line without an edge on it.
  type :: gap_t
    real(dp) :: length = 0.0_dp     !! of all gaps, length
    real(dp) :: within = 0.0_dp     !! part of the line that is in the box around the blocks, length
    real(dp) :: ends(2, 2) = 0.0_dp !! (xy, end) of the largest gap, in coordinates of the deck, length
  end type gap_t

  !> A piece of an edge.
  type :: piece_t
    integer :: element = 0
    real(dp) :: ends(2, 2) = 0.0_dp !! (xy, end), counter-clockwise around the element, length
    real(dp) :: share(2) = 0.0_dp   !! of the line, from its first end, at these
    real(dp) :: depth(2) = 0.0_dp   !! below the water table at these, length
  end type piece_t

contains

  !> Finds the pieces of outer edges, and of both sides of joints, that lie on a line, in the order of their elements.
  pure function pieces_on_line(system, state, line, nearest) result(pieces)
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    real(dp), intent(in) :: line(2, 2)      !! its ends in coordinates of the deck, length
    real(dp), intent(in) :: nearest         !! an edge that is nearer to the line lies on it, length
    type(piece_t), allocatable :: pieces(:)
    type(piece_t) :: piece
    integer, allocatable :: edge(:, :)
    integer :: i
    logical :: found

    allocate (pieces(0))
    edge = outer_edges(system)
    do i = 1, size(edge, 2)
      call cut(state%vertex(:, edge(2:3, i)), line - spread(system%origin, 2, 2), nearest, piece, found)
      if (.not. found) cycle
      piece%element = edge(1, i)
      pieces = [pieces, piece]
    end do
  end function pieces_on_line

  !> Edges of elements but for lines of the mesh, in their order: the element, and the vertices from which and to which each goes.
  pure function outer_edges(system) result(edge)
    type(system_t), intent(in) :: system
    integer, allocatable :: edge(:, :)      !! (3, n)
    integer :: e, k, l, last, n

    associate (shape => system%elements%shape)
      allocate (edge(3, count(shape%joint /= 0)))
      n = 0
      do e = 1, system%n_elements
        do l = shape%first_loop(e), shape%first_loop(e + 1) - 1
          last = shape%first_vertex(l + 1) - 1
          do k = shape%first_vertex(l), last
            if (shape%joint(k) == 0) cycle
            n = n + 1
            edge(:, n) = [e, k, merge(shape%first_vertex(l), k + 1, k == last)]
          end do
        end do
      end do
    end associate
  end function outer_edges

  !> Cuts out the piece of an edge that lies on a line, if any.
  pure subroutine cut(edge, line, nearest, piece, found)
    real(dp), intent(in) :: edge(2, 2), line(2, 2) !! (xy, end), length
    real(dp), intent(in) :: nearest         !! length
    type(piece_t), intent(out) :: piece
    logical, intent(out) :: found
    real(dp) :: along(2), s(2), side(2), span
    integer :: k

    span = norm2(line(:, 2) - line(:, 1))
    along = (line(:, 2) - line(:, 1))/span
    do k = 1, 2
      s(k) = dot_product(edge(:, k) - line(:, 1), along)/span
      side(k) = along(1)*(edge(2, k) - line(2, 1)) - along(2)*(edge(1, k) - line(1, 1))
    end do
    piece%share = min(1.0_dp, max(0.0_dp, s))
    found = maxval(abs(side)) <= nearest .and. abs(side(2) - side(1)) <= least_turn*norm2(edge(:, 2) - edge(:, 1)) .and. &
            abs(piece%share(2) - piece%share(1)) >= shortest
    if (.not. found) return
    do k = 1, 2
      piece%ends(:, k) = edge(:, 1) + (piece%share(k) - s(1))/(s(2) - s(1))*(edge(:, 2) - edge(:, 1))
    end do
  end subroutine cut

  !> The part of a line that no piece covers. Only the part in the box around the blocks counts, so a line may be longer than
  !> the rock.
  pure type(gap_t) function largest_gap(line, pieces, low, high, nearest) result(gap)
    real(dp), intent(in) :: line(2, 2)      !! its ends in coordinates of the deck, length
    type(piece_t), intent(in) :: pieces(:)  !! on the line
    real(dp), intent(in) :: low(2), high(2) !! corners of the box, in coordinates of the deck, length
    real(dp), intent(in) :: nearest         !! an edge that is nearer to the line lies on it, length
    real(dp) :: at, from(size(pieces)), inside(2), largest, next, span, to(size(pieces))
    integer :: i, order(size(pieces))

    inside = share_in_box(line, low, high, nearest)
    span = norm2(line(:, 2) - line(:, 1))
    if (inside(2) <= inside(1)) return
    gap%within = span*(inside(2) - inside(1))
    do i = 1, size(pieces)
      from(i) = minval(pieces(i)%share)
      to(i) = maxval(pieces(i)%share)
      order(i) = i
    end do
    call sort_by(from, order)
    at = inside(1)
    largest = 0.0_dp
    do i = 1, size(pieces) + 1
      next = inside(2)
      if (i <= size(pieces)) next = min(from(i), next)
      if (next > at) gap%length = gap%length + span*(next - at)
      if (next - at > largest) then
        largest = next - at
        gap%ends(:, 1) = (1 - at)*line(:, 1) + at*line(:, 2)
        gap%ends(:, 2) = (1 - next)*line(:, 1) + next*line(:, 2)
      end if
      if (i <= size(pieces)) at = max(at, to(order(i)))
    end do
  end function largest_gap

  !> First and last fraction of a line that lie in a box; the second is smaller where no part does. A line along a side of the box
  !> may lie beside it by the distance by which edges may lie beside the line.
  pure function share_in_box(line, low, high, nearest) result(share)
    real(dp), intent(in) :: line(2, 2), low(2), high(2), nearest !! length
    real(dp) :: share(2)
    real(dp) :: at(2), v(2)
    integer :: i

    share = [0.0_dp, 1.0_dp]
    v = line(:, 2) - line(:, 1)
    do i = 1, 2
      if (abs(v(i)) > least_turn*norm2(v)) then
        at = ([low(i), high(i)] - line(i, 1))/v(i)
        share = [max(share(1), minval(at)), min(share(2), maxval(at))]
      else if (maxval(line(i, :)) < low(i) - nearest .or. minval(line(i, :)) > high(i) + nearest) then
        share(2) = -1.0_dp
      end if
    end do
  end function share_in_box

  !> Parts of pieces that no other piece covers.
  pure function pieces_beside(pieces, others) result(left)
    type(piece_t), intent(in) :: pieces(:), others(:)
    type(piece_t), allocatable :: left(:)
    type(piece_t), allocatable :: rest(:)
    integer :: i, k

    allocate (left(0))
    do i = 1, size(pieces)
      rest = pieces(i:i)
      do k = 1, size(others)
        if (others(k)%element == pieces(i)%element) rest = less(rest, others(k))
      end do
      left = [left, rest]
    end do
  end function pieces_beside

  !> Pieces of one edge without a piece of the same element, which may lie on that edge.
  pure function less(pieces, other) result(left)
    type(piece_t), intent(in) :: pieces(:), other
    type(piece_t), allocatable :: left(:)
    real(dp) :: aside(2), from, length, to, way(2)
    integer :: i, k

    allocate (left(0))
    do i = 1, size(pieces)
      associate (own => pieces(i))
        length = norm2(own%ends(:, 2) - own%ends(:, 1))
        way = (own%ends(:, 2) - own%ends(:, 1))/length
        aside = [(way(1)*(other%ends(2, k) - own%ends(2, 1)) - way(2)*(other%ends(1, k) - own%ends(1, 1)), k=1, 2)]
        from = dot_product(way, other%ends(:, 1) - own%ends(:, 1))
        to = dot_product(way, other%ends(:, 2) - own%ends(:, 1))
        if (maxval(abs(aside)) > shortest*length .or. min(to, length) - max(from, 0.0_dp) <= shortest*length) then
          left = [left, own]
          cycle
        end if
        if (from > shortest*length) left = [left, part_of(own, 0.0_dp, from/length)]
        if (to < (1 - shortest)*length) left = [left, part_of(own, to/length, 1.0_dp)]
      end associate
    end do
  end function less

  !> The part of a piece between two fractions of it.
  pure type(piece_t) function part_of(piece, from, to) result(part)
    type(piece_t), intent(in) :: piece
    real(dp), intent(in) :: from, to
    integer :: k
    real(dp) :: at(2)

    part = piece
    at = [from, to]
    do k = 1, 2
      part%ends(:, k) = piece%ends(:, 1) + at(k)*(piece%ends(:, 2) - piece%ends(:, 1))
      part%share(k) = piece%share(1) + at(k)*(piece%share(2) - piece%share(1))
      part%depth(k) = piece%depth(1) + at(k)*(piece%depth(2) - piece%depth(1))
    end do
  end function part_of

  !> Finds the pieces of outer edges, and of both sides of joints, that lie below a water table, in the order of their elements.
  pure function pieces_under_water(system, state, table) result(pieces)
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    real(dp), intent(in) :: table(:, :)     !! (2, n) x ascending, y; level beyond its ends; in coordinates of the deck, length
    type(piece_t), allocatable :: pieces(:)
    real(dp) :: level(2, size(table, 2)), ends(2, 2)
    integer, allocatable :: edge(:, :)
    integer :: i

    allocate (pieces(0))
    level = table - spread(system%origin, 2, size(table, 2))
    edge = outer_edges(system)
    do i = 1, size(edge, 2)
      ends = state%vertex(:, edge(2:3, i))
      if (minval(ends(2, :)) < maxval(level(2, :))) call drown(edge(1, i), ends, level, pieces)
    end do
  end function pieces_under_water

  !> Adds the pieces of an edge that lie below a water table, on each part of which their depth is linear.
  pure subroutine drown(e, edge, level, pieces)
    integer, intent(in) :: e
    real(dp), intent(in) :: edge(2, 2)      !! (xy, end), length
    real(dp), intent(in) :: level(:, :)     !! (2, n)
    type(piece_t), allocatable, intent(inout) :: pieces(:)
    real(dp) :: at(size(level, 2) + 2), depth(2), from, to, dry
    integer :: i, n

    n = size(level, 2)
    at = 1.0_dp
    at(1) = 0.0_dp
    if (abs(edge(1, 2) - edge(1, 1)) > 0) at(2:n + 1) = (level(1, :) - edge(1, 1))/(edge(1, 2) - edge(1, 1))
    if (edge(1, 2) < edge(1, 1)) at(2:n + 1) = at(n + 1:2:-1)
    at = min(1.0_dp, max(0.0_dp, at))
    do i = 1, n + 1
      from = at(i)
      to = at(i + 1)
      if (to - from < shortest) cycle
      depth = [depth_at(level, place(from)), depth_at(level, place(to))]
      if (all(depth <= 0)) cycle
      if (any(depth < 0)) then
        dry = at(i) + depth(1)/(depth(1) - depth(2))*(at(i + 1) - at(i))
        if (depth(1) < 0) from = dry
        if (depth(2) < 0) to = dry
      end if
      pieces = [pieces, piece_t(e, reshape([place(from), place(to)], [2, 2]), [0.0_dp, 0.0_dp], max(depth, 0.0_dp))]
    end do

  contains

    !> A place on the edge.
    pure function place(t)
      real(dp), intent(in) :: t
      real(dp) :: place(2)

      place = (1 - t)*edge(:, 1) + t*edge(:, 2)
    end function place

  end subroutine drown

  !> Depth of a place below a water table; below 0 it is above.
  pure real(dp) function depth_at(level, place) result(depth)
    real(dp), intent(in) :: level(:, :)     !! (2, n) x ascending, y; level beyond its ends
    real(dp), intent(in) :: place(2)
    real(dp) :: share
    integer :: i

    i = count(level(1, :) <= place(1))
    if (i == 0 .or. i == size(level, 2)) then
      depth = level(2, max(1, i)) - place(2)
    else
      share = (place(1) - level(1, i))/(level(1, i + 1) - level(1, i))
      depth = (1 - share)*level(2, i) + share*level(2, i + 1) - place(2)
    end if
  end function depth_at

  !> Adds a point of an element to the system, after all others.
  pure subroutine add_point(kind, element, position, system, state)
    integer, intent(in) :: kind, element
    real(dp), intent(in) :: position(2)     !! length
    type(system_t), intent(inout) :: system
    type(state_t), intent(inout) :: state

    system%points%kind = [system%points%kind, kind]
    system%points%element = [system%points%element, element]
    state%point = reshape([state%point, position], [2, size(state%point, 2) + 1])
  end subroutine add_point

end module scree_edges_on_lines
