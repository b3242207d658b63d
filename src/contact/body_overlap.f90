!> Where bodies overlap in area, and by which of their edges they got there.
!>
!> The places where an outline enters or leaves another, and the vertices that lie inside, are the corners of the common area. They
!> are joined to pieces along the edges between them. The depth of a piece across an edge is its largest distance behind the line of
!> the edge. The bodies entered each other by the edge across which the piece is least deep, because the shortest displacement that
!> separates two convex bodies is across an edge of one of them. A single vertex does not decide this. If bodies lie flush, a vertex
!> is on the line of an edge that its whole body is behind.
module scree_body_overlap
  use scree_cell_grid, only: cell_grid_t, cells_of_box, number_of_cell, place_boxes, set_up_grid
  use scree_contact_geometry, only: frame_of_edge, gap_of
  use scree_contacts, only: outlines_t, overlap_t, parallel
  use scree_kinds, only: dp
  use scree_polygon, only: distance_to_segment
  implicit none
  private
  public :: body_overlap_t, entered_by, find_overlaps, overlap_of_bodies

  real(dp), parameter, public :: still_outside = 1e-9_dp !! of a body or an edge: overlap that is none
  real(dp), parameter :: no_depth = 0.1_dp               !! of rounding: a vertex of a piece of some area is behind an edge by more
  real(dp), parameter :: hardly = 10.0_dp               !! of rounding: a vertex of a piece without area is at an edge up to this
  real(dp), parameter :: as_deep = 1e-3_dp               !! of a depth: one that exceeds it by less is the same

  !> A corner of the common area of two bodies.
  type :: overlap_corner_t
    real(dp) :: position(2) = 0.0_dp !! length
    integer :: vertex = 0         !! of the outlines; 0 where two edges cross
    integer :: edge(2) = 0        !! of the first and the second body, where these cross
    integer :: piece = 0          !! of the common area
    real(dp) :: swept = 0.0_dp    !! twice the area between the first corner and the stretches of outline that end there, length^2
    real(dp) :: way(2) = 0.0_dp   !! from the beginning of these stretches to their end, length
  end type overlap_corner_t

  !> The common area of two bodies; empty where `corner` is.
  type :: body_overlap_t
    integer :: body(2) = 0                    !! blocks
    type(overlap_corner_t), allocatable :: corner(:)
    real(dp) :: rounding = 0.0_dp             !! a distance below is none, length
  end type body_overlap_t

contains

  !> Common area of two bodies.
  pure subroutine overlap_of_bodies(outlines, position, a, b, overlap)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)  !! (2, n_vertices) of the elements, length
    integer, intent(in) :: a, b          !! blocks
    type(body_overlap_t), intent(out) :: overlap
    real(dp) :: low(2), high(2), low_b(2), high_b(2)

    overlap%body = [a, b]
    allocate (overlap%corner(0))
    call box_of(outlines, position, a, low, high)
    call box_of(outlines, position, b, low_b, high_b)
    overlap%rounding = still_outside*min(maxval(high - low), maxval(high_b - low_b))
    low = max(low, low_b) - overlap%rounding
    high = min(high, high_b) + overlap%rounding
    if (any(low > high)) return
    associate (edges_a => outlines%of_block(outlines%first(a):outlines%first(a + 1) - 1), &
               edges_b => outlines%of_block(outlines%first(b):outlines%first(b + 1) - 1))
      if (parted(outlines, position, edges_a, edges_b) .or. parted(outlines, position, edges_b, edges_a)) return
      call list_corners(outlines, position, near(edges_a), edges_a, near(edges_b), edges_b, overlap)
      call join_corners(outlines, position, near(edges_a), edges_b, 1, overlap)
      call join_corners(outlines, position, near(edges_b), edges_a, 2, overlap)
    end associate

  contains

    !> The edges that reach into the common box of the bodies.
    pure function near(edge)
      integer, intent(in) :: edge(:)
      integer, allocatable :: near(:)
      logical :: is_near(size(edge))
      integer :: k

      do k = 1, size(edge)
        associate (x => position(:, outlines%start(edge(k))), y => position(:, outlines%finish(edge(k))))
          is_near(k) = all(max(x, y) >= low .and. min(x, y) <= high)
        end associate
      end do
      near = pack(edge, is_near)
    end function near

  end subroutine overlap_of_bodies

  !> Whether a line of an edge parts two bodies: the one lies behind it, the other in front.
  pure logical function parted(outlines, position, edge, other)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)
    integer, intent(in) :: edge(:), other(:) !! of the body whose edges are tried, and of the other
    integer :: j, k

    parted = .false.
    do j = 1, size(edge)
      associate (from => position(:, outlines%start(edge(j))), to => position(:, outlines%finish(edge(j))))
        do k = 1, size(other)
          if (gap_of(position(:, outlines%start(other(k))), from, to) < 0) exit
        end do
        if (k <= size(other)) cycle
        do k = 1, size(edge)
          if (gap_of(position(:, outlines%start(edge(k))), from, to) > still_outside*norm2(to - from)) exit
        end do
        parted = k > size(edge)
        if (parted) return
      end associate
    end do
  end function parted

  !> Finds the corners of the common area: vertices of either body in the other, and crossings of their edges.
  pure subroutine list_corners(outlines, position, near_a, edges_a, near_b, edges_b, overlap)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)
    integer, intent(in) :: near_a(:), edges_a(:), near_b(:), edges_b(:)
    type(body_overlap_t), intent(inout) :: overlap
    real(dp) :: gap(4)
    integer :: i, j

    overlap%corner = [vertices_in(near_a, edges_b), vertices_in(near_b, edges_a)]
    do i = 1, size(near_a)
      associate (a1 => position(:, outlines%start(near_a(i))), a2 => position(:, outlines%finish(near_a(i))))
        do j = 1, size(near_b)
          associate (b1 => position(:, outlines%start(near_b(j))), b2 => position(:, outlines%finish(near_b(j))))
            gap = [gap_of(a1, b1, b2), gap_of(a2, b1, b2), gap_of(b1, a1, a2), gap_of(b2, a1, a2)]
            if (max(min(gap(1), gap(2)), min(gap(3), gap(4))) < -overlap%rounding .and. &
                min(max(gap(1), gap(2)), max(gap(3), gap(4))) > overlap%rounding) & ! else an end is on the other edge
              overlap%corner = [overlap%corner, overlap_corner_t(a1 &
                  + gap(1)/(gap(1) - gap(2))*(a2 - a1), edge=[near_a(i), near_b(j)])]
          end associate
        end do
      end associate
    end do
    overlap%corner%piece = [(i, i=1, size(overlap%corner))]

  contains

    !> The vertices that begin some edges and are inside a body or on its outline.
    pure function vertices_in(near, body) result(corner)
      integer, intent(in) :: near(:), body(:) !! edges
      type(overlap_corner_t), allocatable :: corner(:)
      logical :: inside(size(near))
      integer :: k

      do k = 1, size(near)
        inside(k) = is_in(outlines, position, body, position(:, outlines%start(near(k))), overlap%rounding)
      end do
      corner = [(overlap_corner_t(position(:, outlines%start(near(k))), near(k)), k=1, size(near))]
      corner = pack(corner, inside)
    end function vertices_in

  end subroutine list_corners

  !> Puts corners into one piece where a stretch of an edge between them is in the other body, and sums the area that these
  !> stretches go round. Where edges of both run the same way one of them counts; where they face each other the bodies only touch.
  pure subroutine join_corners(outlines, position, near, other, which, overlap)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)
    integer, intent(in) :: near(:)           !! edges of one body
    integer, intent(in) :: other(:)          !! edges of the other
    integer, intent(in) :: which             !! of the two bodies of the overlap has the edges `near`
    type(body_overlap_t), intent(inout) :: overlap
    real(dp) :: t(2), normal(2), length, along(size(overlap%corner)), middle(2), way(2), x(2), y(2)
    integer :: k, m, n, on(size(overlap%corner)), next

    do k = 1, size(near)
      associate (from => position(:, outlines%start(near(k))), to => position(:, outlines%finish(near(k))))
        call frame_of_edge(from, to, t, normal, length)
        n = 0
        do m = 1, size(overlap%corner)
          associate (corner => overlap%corner(m))
            if (.not. (corner%edge(which) == near(k) .or. corner%vertex == near(k) .or. corner%vertex == outlines%next(near(k)) &
                       .or. is_beside(corner%position, from, to, overlap%rounding))) cycle
            n = n + 1
            on(n) = m
            along(n) = dot_product(t, corner%position - from)
          end associate
        end do
        do while (n > 1) ! from the last along the edge back to the first
          m = maxloc(along(:n), 1)
          next = on(m)
          on(m) = on(n)
          along(m) = along(n)
          n = n - 1
          m = on(maxloc(along(:n), 1))
          x = overlap%corner(m)%position - overlap%corner(1)%position
          y = overlap%corner(next)%position - overlap%corner(1)%position
          middle = 0.5_dp*(overlap%corner(m)%position + overlap%corner(next)%position)
          if (.not. is_in(outlines, position, other, middle, overlap%rounding) .or. runs_along(middle, -t)) cycle
          if (which == 1 .or. .not. runs_along(middle, t)) then
            way = y - x
            overlap%corner(next)%swept = overlap%corner(next)%swept + x(1)*way(2) - x(2)*way(1) ! x y' - y x', and nothing cancels
            overlap%corner(next)%way = overlap%corner(next)%way + way
          end if
          if (overlap%corner(m)%piece == overlap%corner(next)%piece) cycle
          where (overlap%corner%piece == overlap%corner(m)%piece) overlap%corner%piece = overlap%corner(next)%piece
        end do
      end associate
    end do

  contains

    !> Whether an edge of the other body runs through a place in a direction.
    pure logical function runs_along(x, t)
      real(dp), intent(in) :: x(2), t(2)
      integer :: j

      runs_along = .true.
      do j = 1, size(other)
        associate (from => position(:, outlines%start(other(j))), to => position(:, outlines%finish(other(j))))
          if (is_beside(x, from, to, overlap%rounding) .and. dot_product(t, to - from) > 0.5_dp*norm2(to - from)) return
        end associate
      end do
      runs_along = .false.
    end function runs_along

  end subroutine join_corners

  !> Whether a piece has any area: more than rounding all along it. Areas are those about its own middle, as the outline of a piece
  !> that is made by rounding is not closed.
  pure logical function has_area(overlap, piece)
    type(body_overlap_t), intent(in) :: overlap
    integer, intent(in) :: piece
    type(overlap_corner_t), allocatable :: corner(:)
    real(dp) :: extent(2), middle(2), way(2)
    integer :: k

    corner = pack(overlap%corner, overlap%corner%piece == piece)
    do k = 1, 2
      extent(k) = maxval(corner%position(k)) - minval(corner%position(k))
      middle(k) = sum(corner%position(k) - overlap%corner(1)%position(k))/size(corner)
      way(k) = sum(corner%way(k))
    end do
    has_area = 0.5_dp*(sum(corner%swept) - (middle(1)*way(2) - middle(2)*way(1))) > overlap%rounding*norm2(extent)
  end function has_area

  !> Whether a vertex of one body of an overlap entered the other by an edge, as a part of its body.
  !>
  !> The vertex did if the common piece is not less deep across any other edge by which it may be left. Edges that lead the same way
  !> as this edge do not count. Nor does its neighbour at a hollow corner, because both edges are entered together.
  pure logical function entered_by(outlines, position, overlap, vertex, edge) result(entered)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)      !! (2, n_vertices), length
    type(body_overlap_t), intent(in) :: overlap
    integer, intent(in) :: vertex, edge      !! of the outlines
    real(dp) :: depth
    integer, allocatable :: out(:)
    integer :: at, k

    entered = .false.
    at = findloc(overlap%corner%vertex, vertex, 1)
    if (at == 0) return
    associate (piece => overlap%corner(at)%piece)
      if (.not. has_area(overlap, piece)) then ! it is at the edge
        associate (x => position(:, outlines%start(vertex)))
          entered = gap_of(x, position(:, outlines%start(edge)), position(:, outlines%finish(edge))) >= -hardly*overlap%rounding
        end associate
        return
      end if
      out = ways_out(outlines, position, overlap, piece)
      depth = depth_across(outlines, position, overlap, piece, edge)
      do k = 1, size(out)
        if (out(k) == edge) cycle
        if (goes_on(out(k)) .or. meet_hollow(outlines, position, out(k), edge)) cycle
        if (depth > (1 + as_deep)*depth_across(outlines, position, overlap, piece, out(k)) + overlap%rounding) return
      end do
    end associate
    entered = .true.

  contains

    !> Whether another edge leads the same way as the edge: that of the other body faces it, and that of its own goes on with it,
    !> but for what the two may lean. One of its own that the vertex is less deep behind, as of another step of a stair, does not.
    pure logical function goes_on(other)
      integer, intent(in) :: other

      goes_on = leads_alike(outlines, position, other, edge)
      if (.not. goes_on .or. outlines%block(other) /= outlines%block(edge)) return
      associate (x => position(:, outlines%start(vertex)), from => position(:, outlines%start(other)), &
                 to => position(:, outlines%finish(other)))
        goes_on = gap_of(x, from, to) - gap_of(x, position(:, outlines%start(edge)), position(:, outlines%finish(edge))) &
                  <= parallel*distance_to_segment(x, from, to) + overlap%rounding
      end associate
    end function goes_on

  end function entered_by

  !> Edges by which a piece may be left. A vertex of the other body in the piece must be behind such an edge, and the edge must
  !> bound the piece. If no edge of its body bounds the piece, as where one body lies in the other, the whole piece must be behind
  !> the edge.
  pure function ways_out(outlines, position, overlap, piece) result(out)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)
    type(body_overlap_t), intent(in) :: overlap
    integer, intent(in) :: piece
    integer, allocatable :: out(:)
    type(overlap_corner_t), allocatable :: corner(:)
    integer :: m, which

    allocate (out(0))
    corner = pack(overlap%corner, overlap%corner%piece == piece)
    do which = 1, 2
      associate (edges => outlines%of_block(outlines%first(overlap%body(which)):outlines%first(overlap%body(which) + 1) - 1))
        associate (bounding => [(bounds(edges(m), which), m=1, size(edges))])
          out = [out, pack(edges, [(has_vertex_behind(edges(m)), m=1, size(edges))] &
                           .and. (bounding .or. .not. any(bounding) .and. [(is_behind(edges(m)), m=1, size(edges))]))]
        end associate
      end associate
    end do

  contains

    !> Whether a vertex of the other body in the piece is behind the line of an edge.
    pure logical function has_vertex_behind(edge)
      integer, intent(in) :: edge
      integer :: k

      has_vertex_behind = .false.
      do k = 1, size(corner)
        if (corner(k)%vertex == 0) cycle
        if (outlines%block(corner(k)%vertex) /= outlines%block(edge)) &
          has_vertex_behind = has_vertex_behind .or. gap_at(corner(k), edge) < -no_depth*overlap%rounding
      end do
    end function has_vertex_behind

    !> Whether the whole piece is behind the line of an edge.
    pure logical function is_behind(edge)
      integer, intent(in) :: edge
      integer :: k

      is_behind = .true.
      do k = 1, size(corner)
        is_behind = is_behind .and. gap_at(corner(k), edge) < overlap%rounding
      end do
    end function is_behind

    !> Whether an edge of a body has a corner of the piece.
    pure logical function bounds(edge, which)
      integer, intent(in) :: edge, which
      integer :: k

      bounds = .true.
      do k = 1, size(corner)
        if (corner(k)%edge(which) == edge .or. corner(k)%vertex == edge .or. corner(k)%vertex == outlines%next(edge)) return
        if (is_beside(corner(k)%position, position(:, outlines%start(edge)), position(:, outlines%finish(edge)), &
                      overlap%rounding)) return
      end do
      bounds = .false.
    end function bounds

    !> Gap of a corner at the line of an edge.
    pure real(dp) function gap_at(corner, edge)
      type(overlap_corner_t), intent(in) :: corner
      integer, intent(in) :: edge

      gap_at = gap_of(corner%position, position(:, outlines%start(edge)), position(:, outlines%finish(edge)))
    end function gap_at

  end function ways_out

  !> How far a piece reaches behind the line of an edge.
  pure real(dp) function depth_across(outlines, position, overlap, piece, edge) result(depth)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)
    type(body_overlap_t), intent(in) :: overlap
    integer, intent(in) :: piece, edge
    integer :: k

    depth = 0.0_dp
    do k = 1, size(overlap%corner)
      if (overlap%corner(k)%piece == piece) &
        depth = max(depth, -gap_of(overlap%corner(k)%position, position(:, outlines%start(edge)), &
                                   position(:, outlines%finish(edge))))
    end do
  end function depth_across

  !> Whether two edges lead out of a piece in the same direction: parallel ones of one body, or facing ones of two.
  pure logical function leads_alike(outlines, position, i, j)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)
    integer, intent(in) :: i, j
    real(dp) :: a(2), b(2)

    a = position(:, outlines%finish(i)) - position(:, outlines%start(i))
    b = position(:, outlines%finish(j)) - position(:, outlines%start(j))
    leads_alike = merge(1, -1, outlines%block(i) == outlines%block(j))*dot_product(a, b) > cos(parallel)*norm2(a)*norm2(b)
  end function leads_alike

  !> Whether two edges meet at a corner of more than half a turn.
  pure logical function meet_hollow(outlines, position, i, j)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)
    integer, intent(in) :: i, j
    integer :: first, second

    meet_hollow = .false.
    if (outlines%next(i) /= j .and. outlines%next(j) /= i) return
    first = merge(i, j, outlines%next(i) == j)
    second = merge(j, i, outlines%next(i) == j)
    meet_hollow = gap_of(position(:, outlines%finish(second)), position(:, outlines%start(first)), &
                         position(:, outlines%finish(first))) > 0
  end function meet_hollow

  !> Whether a position is in a body or on its outline.
  pure logical function is_in(outlines, position, edge, x, rounding)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)
    integer, intent(in) :: edge(:)     !! of the body
    real(dp), intent(in) :: x(2)       !! length
    real(dp), intent(in) :: rounding   !! length
    integer :: k

    is_in = .false.
    do k = 1, size(edge)
      associate (a => position(:, outlines%start(edge(k))), b => position(:, outlines%finish(edge(k))))
        if (is_beside(x, a, b, rounding)) then
          is_in = .true.
          return
        end if
        if (a(2) > x(2) .neqv. b(2) > x(2)) then ! the outline crosses the ray from the place to the right
          if (gap_of(x, a, b) < 0 .eqv. b(2) > a(2)) is_in = .not. is_in
        end if
      end associate
    end do
  end function is_in

  !> Whether a position is nearer to a segment than `rounding`.
  pure logical function is_beside(x, a, b, rounding)
    real(dp), intent(in) :: x(2), a(2), b(2), rounding !! length

    is_beside = all(x >= min(a, b) - rounding .and. x <= max(a, b) + rounding)
    if (is_beside) is_beside = distance_to_segment(x, a, b) <= rounding
  end function is_beside

  !> Corners of the box around a body.
  pure subroutine box_of(outlines, position, body, low, high)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)
    integer, intent(in) :: body
    real(dp), intent(out) :: low(2), high(2) !! length
    integer :: k

    low = huge(low)
    high = -huge(high)
    do k = outlines%first(body), outlines%first(body + 1) - 1
      low = min(low, position(:, outlines%start(outlines%of_block(k))))
      high = max(high, position(:, outlines%start(outlines%of_block(k))))
    end do
  end subroutine box_of

  !> Area of a body, without that of its holes.
  pure real(dp) function area_of(outlines, position, body) result(area)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)
    integer, intent(in) :: body
    integer :: k

    area = 0.0_dp
    associate (origin => position(:, outlines%start(outlines%of_block(outlines%first(body)))))
      do k = outlines%first(body), outlines%first(body + 1) - 1
        associate (a => position(:, outlines%start(outlines%of_block(k))) - origin, &
                   b => position(:, outlines%finish(outlines%of_block(k))) - origin)
          area = area + 0.5_dp*(a(1)*b(2) - a(2)*b(1))
        end associate
      end do
    end associate
  end function area_of

  !> All overlaps of bodies in area, and the pairs of a vertex and an edge by which they entered each other.
  subroutine find_overlaps(outlines, position, found, inside)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)                     !! (2, n_vertices) of the elements, length
    type(overlap_t), allocatable, intent(out) :: found(:)
    integer, allocatable, intent(out) :: inside(:, :)       !! (2, n) vertices and edges of the outlines
    type(cell_grid_t) :: grid
    type(body_overlap_t) :: overlap
    real(dp), dimension(2, size(outlines%first) - 1) :: low, high
    real(dp) :: area(size(outlines%first) - 1)
    integer :: a, b, c, column, k, range(2, 2), row, seen(size(outlines%first) - 1)

    allocate (found(0), inside(2, 0))
    if (size(seen) < 2) return
    do b = 1, size(seen)
      call box_of(outlines, position, b, low(:, b), high(:, b))
      area(b) = area_of(outlines, position, b)
    end do
    call set_up_grid(grid, reshape([low, high], [2, 2*size(seen)]), size(seen))
    call place_boxes(grid, low, high)
    seen = 0
    do a = 1, size(seen)
      range = cells_of_box(grid, low(:, a), high(:, a))
      do row = range(2, 1), range(2, 2)
        do column = range(1, 1), range(1, 2)
          c = number_of_cell(grid, column, row)
          do k = grid%first(c), grid%first(c + 1) - 1
            b = grid%item(k)
            if (b <= a .or. seen(b) == a) cycle
            seen(b) = a
            if (any(low(:, a) >= high(:, b) .or. low(:, b) >= high(:, a))) cycle
            call overlap_of_bodies(outlines, position, a, b, overlap)
            if (size(overlap%corner) > 0) call add_pieces()
          end do
        end do
      end do
    end do

  contains

    !> Adds the pieces of an overlap that have an area.
    subroutine add_pieces()
      integer, allocatable :: out(:)
      integer :: m, piece
      type(overlap_t) :: new

      do piece = 1, size(overlap%corner)
        if (all(overlap%corner%piece /= piece)) cycle
        if (.not. has_area(overlap, piece)) cycle
        out = ways_out(outlines, position, overlap, piece)
        new = describe(piece, out)
        new%share = min(1.0_dp, new%depth/sqrt(min(area(a), area(b))))
        found = [found, new]
        do m = 1, size(overlap%corner)
          if (overlap%corner(m)%piece == piece .and. overlap%corner(m)%vertex > 0) call add_entered(overlap%corner(m)%vertex, out)
        end do
      end do
    end subroutine add_pieces

    !> Depth and position of a piece; where no edge leads out of it, across those that cross.
    type(overlap_t) function describe(piece, out) result(it)
      integer, intent(in) :: piece, out(:)
      integer, allocatable :: edge(:)
      integer :: m

      it%body = overlap%body
      it%crossing = size(out) == 0
      edge = out
      if (it%crossing) then
        do m = 1, 2
          edge = [edge, pack(overlap%corner%edge(m), overlap%corner%piece == piece .and. overlap%corner%edge(m) > 0)]
        end do
      end if
      it%depth = huge(it%depth)
      do m = 1, size(edge)
        it%depth = min(it%depth, depth_across(outlines, position, overlap, piece, edge(m)))
      end do
      do m = 1, 2
        it%position(m) = sum(overlap%corner%position(m), overlap%corner%piece == piece)/count(overlap%corner%piece == piece)
      end do
    end function describe

    !> Adds the edges by which a vertex entered.
    subroutine add_entered(vertex, out)
      integer, intent(in) :: vertex, out(:)
      integer :: m

      do m = 1, size(out)
        if (outlines%block(out(m)) == outlines%block(vertex)) cycle
        if (gap_of(position(:, outlines%start(vertex)), position(:, outlines%start(out(m))), position(:, outlines%finish(out(m)))) &
            >= -no_depth*overlap%rounding) cycle
        if (entered_by(outlines, position, overlap, vertex, out(m))) &
          inside = reshape([inside, vertex, out(m)], [2, size(inside, 2) + 1])
      end do
    end subroutine add_entered

  end subroutine find_overlaps

end module scree_body_overlap
