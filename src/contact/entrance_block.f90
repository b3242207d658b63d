!> The entrance block E(A,B) of two convex chains: its lines, which of them leads, and where the two bodies meet at it.
!>
!> A touches B where the origin is in E(A,B) = {b - a}. The edges of both chains, merged by direction, bound it; each lies on an
!> *entrance line*: the line of an edge of one chain and the vertex of the other that comes first to it. The gap of the two is the
!> largest gap of these lines, that of the *leading line*: above 0 it separates them, below 0 it is the way by which they part.
!>
!> G.-H. Shi, *Contact theory*, Science China Technological Sciences 58 (2015) 1450-1496; *Discontinuous deformation analysis*
!> (thesis, Berkeley 1988). The leading line is the separating axis of convex polygons, found by rotating calipers (G. Toussaint,
!> 1983).
module scree_entrance_block
  use scree_kinds, only: dp, pi
  use scree_sorting, only: sort_by
  implicit none
  private
  public :: entrance_block, entrance_line_t, find_leading_line, leading_line, meet, meeting_t, normals_of

  !> Largest angle between two edges that lie on each other as faces, rad. Beyond it the corner of the edge that leads bears nothing
  !> on the other one: two corners that are so deep in each other would push in two directions and lock.
  real(dp), parameter :: faces = 20*pi/180
  !> Overlap of faces over that of a cut beyond which the overlap belongs to the piece behind the cut. A tip that comes in along a
  !> cut is wider than a tenth of its depth, unless it is sharper than 2 atan(1/10), 11 degrees.
  real(dp), parameter :: beside_cut = 10.0_dp
  !> Interval that two edges have in common where they have none.
  real(dp), parameter :: nothing(2) = [0.0_dp, -1.0_dp]

  !> The line of an edge and the vertex of the other chain that meets it. Edges of B are numbered on from those of A.
  type :: entrance_line_t
    integer :: edge = 0
    integer :: vertex = 0                 !! of the other chain
    real(dp) :: gap = 0.0_dp              !! of the vertex from the line, length
    real(dp) :: normal(2) = 0.0_dp        !! outward of the chain that has the edge, of length 1
    real(dp) :: common(2) = nothing       !! where an edge that is parallel lies beside it, from its start, length; empty: end first
  end type entrance_line_t

  !> The one or two points at which two bodies meet: a vertex of one at an edge of the other, with the normal of that edge. Vertices
  !> and edges of B are numbered on from those of A.
  type :: meeting_t
    integer :: n = 0
    integer :: slot(2) = 0                !! 1 and 2: at which end of what the two have in common
    integer :: vertex(2) = 0
    integer :: edge(2) = 0
    real(dp) :: position(2, 2) = 0.0_dp   !! (xy, point) halfway between the vertex and the line of the edge, length
    real(dp) :: gap(2) = 0.0_dp           !! below 0: overlap, length
    real(dp) :: normal(2, 2) = 0.0_dp     !! (xy, point) from A to B, of length 1
  end type meeting_t

contains

  !> Outward normals of the edges of a polygon; edge k begins at vertex k. An edge without length has none, and gets 0.
  pure function normals_of(x) result(normal)
    real(dp), intent(in) :: x(:, :)       !! (2, n) counterclockwise, length
    real(dp) :: normal(2, size(x, 2))     !! of length 1
    real(dp) :: along(2)
    integer :: k

    do k = 1, size(x, 2)
      along = x(:, modulo(k, size(x, 2)) + 1) - x(:, k)
      normal(:, k) = [along(2), -along(1)]/max(tiny(1.0_dp), norm2(along))
    end do
  end function normals_of

  !> The entrance lines of two chains in the order of their directions from A to B, counterclockwise up to pi. An edge has a line
  !> for each vertex of the other chain whose two edges enclose its direction: just one for a closed chain. The ends of an open one
  !> are hollow corners and meet nothing.
  pure function entrance_block(a, a_is_closed, b, b_is_closed, parallel) result(lines)
    real(dp), intent(in) :: a(:, :), b(:, :) !! (2, n) vertices of the chains, counterclockwise, length
    logical, intent(in) :: a_is_closed, b_is_closed
    real(dp), intent(in) :: parallel         !! largest angle between edges that have an interval in common, rad
    type(entrance_line_t), allocatable :: lines(:)
    type(entrance_line_t), allocatable :: of_a(:), of_b(:)
    real(dp), allocatable :: direction(:)
    integer, allocatable :: order(:)
    integer :: i

    call lines_along(a, a_is_closed, b, b_is_closed, parallel, 0, of_a)
    call lines_along(b, b_is_closed, a, a_is_closed, parallel, merge(size(a, 2), size(a, 2) - 1, a_is_closed), of_b)
    lines = [of_a, of_b]
    direction = [(atan2(of_a(i)%normal(2) + 0.0_dp, of_a(i)%normal(1)), i=1, size(of_a)), &
                 (atan2(0.0_dp - of_b(i)%normal(2), -of_b(i)%normal(1)), i=1, size(of_b))] ! no zero has a sign
    order = [(i, i=1, size(lines))]
    call sort_by(direction, order)
    lines = lines(order)
  end function entrance_block

  !> Entrance lines along the edges of one chain.
  pure subroutine lines_along(own, own_is_closed, other, other_is_closed, parallel, offset, lines)
    real(dp), intent(in) :: own(:, :), other(:, :)
    logical, intent(in) :: own_is_closed, other_is_closed
    real(dp), intent(in) :: parallel
    integer, intent(in) :: offset            !! added to the numbers of edges
    type(entrance_line_t), allocatable, intent(out) :: lines(:)
    real(dp) :: normal(2, size(own, 2)), other_normal(2, size(other, 2))
    type(entrance_line_t) :: line
    integer :: inner, j, k

    allocate (lines(0))
    normal = normals_of(own)
    other_normal = normals_of(other)
    inner = merge(0, 1, other_is_closed)     ! vertices at either end that are none of the chain's own corners
    do k = 1, size(own, 2) - merge(0, 1, own_is_closed)
      do j = 1 + inner, size(other, 2) - inner
        associate (n => normal(:, k), into => other_normal(:, modulo(j - 2, size(other, 2)) + 1), from => other_normal(:, j))
          if (.not. (cross(into, -n) >= 0 .and. cross(-n, from) > 0)) cycle
          line = entrance_line_t(offset + k, j, dot_product(n, other(:, j) - own(:, k)), n)
          if (dot_product(n, from) < -cos(parallel)) line%common = common(k, j)
          if (dot_product(n, into) < -cos(parallel) .and. dot_product(n, into) < dot_product(n, from)) &
            line%common = common(k, modulo(j - 2, size(other, 2)) + 1)
          lines = [lines, line]
        end associate
      end do
    end do

  contains

    !> Part of edge k beside which edge m of the other chain lies, from the start of edge k.
    pure function common(k, m)
      integer, intent(in) :: k, m
      real(dp) :: common(2), along(2)

      associate (begins => own(:, k), ends => own(:, modulo(k, size(own, 2)) + 1))
        along = (ends - begins)/norm2(ends - begins)
        common(1) = max(0.0_dp, dot_product(along, other(:, modulo(m, size(other, 2)) + 1) - begins))
        common(2) = min(norm2(ends - begins), dot_product(along, other(:, m) - begins))
      end associate
      if (common(1) > common(2)) common = nothing
    end function common

  end subroutine lines_along

  !> Place of the leading line in a list: that with the largest gap, and of equal ones that of the lowest edge; 0 for an empty list.
  pure integer function leading_line(lines) result(leading)
    type(entrance_line_t), intent(in) :: lines(:)
    integer :: i

    leading = min(1, size(lines))
    do i = 2, size(lines)
      if (lines(i)%gap < lines(leading)%gap) cycle
      if (lines(i)%gap > lines(leading)%gap .or. lines(i)%edge < lines(leading)%edge) leading = i
    end do
  end function leading_line

  !> Finds the leading line of two convex polygons, or any line with a gap of `far` or more.
  !>
  !> The line of the edge passed in is looked at first, because it mostly still separates or leads. Neither the existence of a
  !> line with such a gap nor the leading line otherwise depends on this edge. Edges that are cuts through a body do not lead,
  !> because a vertex behind one is in the piece beside. If the overlap at the line of a cut is far smaller than at any face
  !> (`beside_cut`), the overlap is that of the piece beside alone, and the two polygons are apart. Of equal gaps the edge with the
  !> lowest number leads, and of vertices that are equally near to it the first one. The time grows with the number of edges.
  pure subroutine find_leading_line(n_a, a, normal_a, face_a, n_b, b, normal_b, face_b, far, edge, vertex, gap)
    integer, intent(in) :: n_a, n_b                           !! vertices
    real(dp), intent(in) :: a(2, n_a), b(2, n_b)              !! vertices, counterclockwise, length
    real(dp), intent(in) :: normal_a(2, n_a), normal_b(2, n_b) !! outward normals of the edges, of length 1
    logical, intent(in) :: face_a(n_a), face_b(n_b)           !! edges that may lead
    real(dp), intent(in) :: far                               !! length
    integer, intent(inout) :: edge                            !! of A, or of B on from those; in: where to begin, 0: anywhere
    integer, intent(inout) :: vertex                          !! of the other one
    real(dp), intent(out) :: gap                              !! length
    real(dp) :: cut_gap, least
    logical :: may_lead

    least = -huge(gap)                                        ! lines with smaller gaps cannot lead
    if (edge > n_a) then
      call look_at(n_b, b, normal_b, n_a, a, edge - n_a, vertex, gap)
      may_lead = face_b(edge - n_a)
    else if (edge > 0) then
      call look_at(n_a, a, normal_a, n_b, b, edge, vertex, gap)
      may_lead = face_a(edge)
    end if
    if (edge > 0) then
      if (gap >= far) return
      if (may_lead) least = gap
    end if
    gap = -huge(gap)
    cut_gap = -huge(gap)
    call look_along(n_a, a, normal_a, face_a, n_b, b, 0, far, least, edge, vertex, gap, cut_gap)
    if (gap >= far) return
    call look_along(n_b, b, normal_b, face_b, n_a, a, n_a, far, max(least, gap), edge, vertex, gap, cut_gap)
    if (gap/beside_cut < min(cut_gap, 0.0_dp)) gap = far
  end subroutine find_leading_line

  !> Gap of the line of edge k, with the vertex that meets it, looked for from a vertex on; of two that are equally near the first.
  pure subroutine look_at(n_own, own, normal, n_other, other, k, vertex, gap)
    integer, intent(in) :: n_own, n_other
    real(dp), intent(in) :: own(2, n_own), normal(2, n_own), other(2, n_other)
    integer, intent(in) :: k
    integer, intent(inout) :: vertex
    real(dp), intent(out) :: gap
    real(dp) :: least, next
    integer :: q

    least = normal(1, k)*other(1, vertex) + normal(2, k)*other(2, vertex)
    do
      q = vertex + 1
      if (q > n_other) q = 1
      next = normal(1, k)*other(1, q) + normal(2, k)*other(2, q)
      if (next >= least) exit
      vertex = q
      least = next
    end do
    do
      q = vertex - 1
      if (q < 1) q = n_other
      next = normal(1, k)*other(1, q) + normal(2, k)*other(2, q)
      if (next >= least) exit
      vertex = q
      least = next
    end do
    if (next <= least) vertex = q
    gap = least - normal(1, k)*own(1, k) - normal(2, k)*own(2, k)
  end subroutine look_at

  !> Looks at the lines of the edges of one polygon, until one is far. A line on whose inner side some vertex is too deep cannot
  !> lead, and its vertex is not looked for.
  pure subroutine look_along(n_own, own, normal, face, n_other, other, offset, far, deep, edge, vertex, gap, cut_gap)
    integer, intent(in) :: n_own, n_other
    real(dp), intent(in) :: own(2, n_own), normal(2, n_own), other(2, n_other)
    logical, intent(in) :: face(n_own)
    integer, intent(in) :: offset                             !! added to the number of the edge
    real(dp), intent(in) :: far, deep                         !! gaps from which on and below which nothing is looked for
    integer, intent(inout) :: edge, vertex                    !! of the line with the largest gap so far
    real(dp), intent(inout) :: gap                            !! of that
    real(dp), intent(inout) :: cut_gap                        !! largest gap of a cut so far
    real(dp) :: its_gap
    integer :: j, k

    j = 1
    do k = 1, n_own
      its_gap = normal(1, k)*other(1, j) + normal(2, k)*other(2, j) - normal(1, k)*own(1, k) - normal(2, k)*own(2, k)
      if (its_gap < deep) cycle
      call look_at(n_own, own, normal, n_other, other, k, j, its_gap)
      if (.not. (face(k) .or. its_gap >= far)) then
        cut_gap = max(cut_gap, its_gap)
      else if (its_gap > gap) then
        gap = its_gap
        edge = offset + k
        vertex = j
        if (gap >= far) return
      end if
    end do
  end subroutine look_along

  !> Where two convex polygons meet at their leading line: at the ends of what the edge that leads and the edge before it have in
  !> common. Each is a vertex of one at an edge of the other, with that edge's own normal; those with a gap of `far` or more are
  !> left out.
  pure subroutine meet(n_a, a, normal_a, face_a, n_b, b, normal_b, face_b, far, edge, vertex, meeting)
    integer, intent(in) :: n_a, n_b                           !! as `find_leading_line` has them
    real(dp), intent(in) :: a(2, n_a), b(2, n_b), normal_a(2, n_a), normal_b(2, n_b)
    logical, intent(in) :: face_a(n_a), face_b(n_b)
    real(dp), intent(in) :: far
    integer, intent(in) :: edge, vertex                       !! the leading line
    type(meeting_t), intent(out) :: meeting

    if (edge <= n_a) then
      call meet_along(n_a, a, normal_a, 0, n_b, b, normal_b, face_b, n_a, far, edge, vertex, 1, meeting)
    else
      call meet_along(n_b, b, normal_b, n_a, n_a, a, normal_a, face_a, 0, far, edge - n_a, vertex, -1, meeting)
    end if
  end subroutine meet

  !> `meet`, along an edge of one polygon.
  pure subroutine meet_along(n_own, own, own_normal, own_offset, n_other, other, other_normal, other_face, other_offset, far, k, &
                             j, side, meeting)
    integer, intent(in) :: n_own, n_other
    real(dp), intent(in) :: own(2, n_own), own_normal(2, n_own), other(2, n_other), other_normal(2, n_other)
    logical, intent(in) :: other_face(n_other)
    integer, intent(in) :: own_offset, other_offset           !! added to numbers
    real(dp), intent(in) :: far
    integer, intent(in) :: k, j                               !! edge that leads, vertex that meets it
    integer, intent(in) :: side                               !! 1 where the edge is one of A, else -1
    type(meeting_t), intent(inout) :: meeting
    integer :: before, low, m, next_k, next_m
    real(dp) :: begins, ends, length, n(2), o(2), t(2)
    logical :: flat

    before = j - 1
    if (before < 1) before = n_other
    n = own_normal(:, k)
    m = j                                                     ! the edge at the vertex that lies on the leading one
    if (dot_product(other_normal(:, before), n) < dot_product(other_normal(:, j), n)) m = before
    next_k = k + 1
    if (next_k > n_own) next_k = 1
    next_m = m + 1
    if (next_m > n_other) next_m = 1
    o = other_normal(:, m)
    t = [-n(2), n(1)]
    flat = -dot_product(n, o) > cos(faces) .and. other_face(m)
    begins = dot_product(t, other(:, next_m) - own(:, k))
    ends = dot_product(t, other(:, m) - own(:, k))
    length = dot_product(t, own(:, next_k) - own(:, k))
    low = merge(1, 2, side > 0)
    if (begins >= 0) then
      call add_point(other(:, next_m), own(:, k), n, side, far, next_m + other_offset, k + own_offset, low, meeting)
    else if (flat) then
      call add_point(own(:, k), other(:, m), o, -side, far, k + own_offset, m + other_offset, low, meeting)
    end if
    if (ends <= length) then
      call add_point(other(:, m), own(:, k), n, side, far, m + other_offset, k + own_offset, 3 - low, meeting)
    else if (flat) then
      call add_point(own(:, next_k), other(:, m), o, -side, far, next_k + own_offset, m + other_offset, 3 - low, meeting)
    end if
    if (meeting%n == 0) & ! the foot is past an end: edges that would lead before this one are cuts
      call add_point(other(:, j), own(:, k), n, side, far, j + other_offset, k + own_offset, low, meeting)
  end subroutine meet_along

  !> Adds a vertex at an edge to the points of a meeting, unless it is far.
  pure subroutine add_point(vertex, begins, normal, side, far, its_number, edge, slot, meeting)
    real(dp), intent(in) :: vertex(2)                         !! length
    real(dp), intent(in) :: begins(2)                         !! start of the edge, length
    real(dp), intent(in) :: normal(2)                         !! of the edge, outward
    integer, intent(in) :: side                               !! 1 where the edge is one of A, else -1
    real(dp), intent(in) :: far                               !! length
    integer, intent(in) :: its_number, edge, slot
    type(meeting_t), intent(inout) :: meeting
    real(dp) :: gap
    integer :: i

    gap = dot_product(normal, vertex - begins)
    if (gap >= far) return
    i = meeting%n + 1
    meeting%n = i
    meeting%slot(i) = slot
    meeting%vertex(i) = its_number
    meeting%edge(i) = edge
    meeting%position(:, i) = vertex - gap/2*normal
    meeting%gap(i) = gap
    meeting%normal(:, i) = side*normal
  end subroutine add_point

  !> Of two vectors.
  pure real(dp) function cross(a, b)
    real(dp), intent(in) :: a(2), b(2)

    cross = a(1)*b(2) - a(2)*b(1)
  end function cross

end module scree_entrance_block
