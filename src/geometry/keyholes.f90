!> A region with holes as one polygon, and back.
!>
!> Where a format knows polygons only (block files, VTK), a hole is joined to the outline by a seam (scree_seams): an edge that the
!> polygon runs through both ways. The polygon encloses the same area.
module scree_keyholes
  use scree_kinds, only: dp
  use scree_polygon, only: twice_area
  use scree_regions, only: first_vertex_of, last_vertex_of, loops_of, region_count, regions_t, vertices_after
  use scree_seams, only: find_seams
  use scree_sorting, only: order_of_pairs, order_of_places
  implicit none
  private
  public :: join_loops, part_loops, polygons_of

  integer, parameter :: least_corners = 3 !! of a loop

contains

  !> Vertices of all loops in the order of one polygon, which begins at the first vertex of the outline.
  function join_loops(vertex, first) result(order)
    real(dp), intent(in) :: vertex(:, :)   !! (2, n), length
    integer, intent(in) :: first(:)        !! (n_loops+1) loop k owns vertices first(k):first(k+1)-1, the outline first
    integer, allocatable :: order(:)
    integer :: after(size(vertex, 2)), k, next, slot, v
    integer, allocatable :: seam(:, :)

    call find_seams(vertex, first, seam)
    after = vertices_after(first)
    allocate (order(size(after) + 2*(size(first) - 2)))
    v = first(1)
    slot = 1
    do k = 1, size(order)
      order(k) = v
      do while (slot <= size(seam, 1)) ! the polygon leaves by the next seam of the vertex, after all of them along the loop
        if (seam(slot, v) > 0) exit
        slot = slot + 1
      end do
      if (slot > size(seam, 1)) then
        v = after(v)
        slot = 1
      else
        next = seam(slot, v)
        slot = findloc(seam(:, next), v, 1) + 1
        v = next
      end if
    end do
  end function join_loops

  !> Every region as one polygon: region i has the vertices corner(first(i):first(i+1)-1) in this order.
  subroutine polygons_of(shape, vertex, first, corner)
    type(regions_t), intent(in) :: shape
    real(dp), intent(in) :: vertex(:, :)             !! (2, n_vertices), length
    integer, allocatable, intent(out) :: first(:)    !! (n+1)
    integer, allocatable, intent(out) :: corner(:)
    integer :: i, k

    allocate (first(region_count(shape) + 1))
    first(1) = 1
    do i = 1, region_count(shape)
      first(i + 1) = first(i) + last_vertex_of(shape, i) - first_vertex_of(shape, i) + 1 &
                     + 2*(shape%first_loop(i + 1) - shape%first_loop(i) - 1)
    end do
    allocate (corner(first(region_count(shape) + 1) - 1))
    do i = 1, region_count(shape)
      associate (from => first_vertex_of(shape, i), to => last_vertex_of(shape, i))
        if (shape%first_loop(i + 1) == shape%first_loop(i) + 1) then
          corner(first(i):first(i + 1) - 1) = [(k, k=from, to)]
        else
          corner(first(i):first(i + 1) - 1) = from - 1 + join_loops(vertex(:, from:to), loops_of(shape, i))
        end if
      end associate
    end do
  end subroutine polygons_of

  !> The loops of a polygon whose seams are edges that it runs through both ways, the outline first.
  !>
  !> Each loop has its vertices in their order in the polygon; of those that a seam brings there twice, it has the one that the loop
  !> leaves from. Loops that touch have a seam without length: an edge from the place to itself, and one on the way back.
  subroutine part_loops(vertex, order, first)
    real(dp), intent(in) :: vertex(:, :)              !! (2, n), length
    integer, allocatable, intent(out) :: order(:)     !! vertices by loop
    integer, allocatable, intent(out) :: first(:)     !! (n_loops+1)
    integer :: k, n, place(size(vertex, 2))
    integer, allocatable :: back(:), closed(:), stays(:)
    logical, allocatable :: is_pinched(:)

    n = size(vertex, 2)
    order = [(k, k=1, n)]
    first = [1, n + 1]
    if (n < 2*(least_corners + 1)) return
    place = places_of(vertex)
    if (maxval(place) == n) return
    back = ways_back(place)
    allocate (stays(maxval(place)), source=0)
    do k = 1, n
      if (place(k) == place(modulo(k, n) + 1)) stays(place(k)) = stays(place(k)) + 1
    end do
    is_pinched = modulo(stays, 2) == 0 .and. stays > 0
    do
      call take_apart(place, back, is_pinched, order, first, closed)
      if (all(2*closed >= stays .or. .not. is_pinched)) exit
      is_pinched = is_pinched .and. 2*closed >= stays ! elsewhere a corner is there twice, and no seam
    end do
    call put_outline_first(vertex, order, first)
  end subroutine part_loops

  !> Splits a polygon into loops, on one walk around it: each loop is removed as soon as the walk has been around it.
  !>
  !> The loops are listed from the one that is closed last. What a seam encloses is closed where the walk comes back through the
  !> seam, and at a place where seams without length begin, each loop is closed where the walk comes back to the place.
  subroutine take_apart(place, back, is_pinched, order, first, closed)
    integer, intent(in) :: place(:)                   !! (n)
    integer, intent(in) :: back(:)                    !! (n) edge that runs the way back, 0: none
    logical, intent(in) :: is_pinched(:)              !! (n_places) whether an edge from the place to itself is a seam
    integer, allocatable, intent(out) :: order(:)     !! edges by loop, each with the number of the vertex that it leaves from
    integer, allocatable, intent(out) :: first(:)     !! (n_loops+1)
    integer, allocatable, intent(out) :: closed(:)    !! (n_places) loops that were closed at a pinched place
    integer :: edge(size(place)), earlier(size(place)), n_open       ! edges of loops that are not closed
    integer :: begun(size(is_pinched))                               ! which of these left a pinched place last
    integer :: base(0:size(place)), until(0:size(place)), level      ! open edges before a seam, its way back, seams around
    integer :: k, n, n_free, n_loops, start(size(place))

    n = size(place)
    allocate (order(n))
    allocate (closed(size(is_pinched)), source=0)
    begun = 0
    n_open = 0
    base(0) = 0
    until(0) = n + 1
    level = 0
    n_free = n
    n_loops = 0
    do k = 1, n
      associate (p => place(k))
        if (is_pinched(p)) then
          if (begun(p) > base(level)) then
            closed(p) = closed(p) + 1
            call close_loop((begun(p))) ! a copy, as it changes there
          end if
          if (place(modulo(k, n) + 1) == p) cycle
        end if
        if (k == until(level)) then
          call close_loop(base(level) + 1)
          level = level - 1
        else if (back(k) - k > least_corners .and. n - (back(k) - k) > least_corners .and. back(k) < until(level)) then
          level = level + 1
          base(level) = n_open
          until(level) = back(k)
        else
          n_open = n_open + 1
          edge(n_open) = k
          earlier(n_open) = begun(p)
          begun(p) = n_open
        end if
      end associate
    end do
    call close_loop(1)
    order = order(n_free + 1:)
    first = [start(n_loops:1:-1) - n_free, n - n_free + 1]

  contains

    !> Removes the open edges from the one at `from` on, as a loop.
    subroutine close_loop(from)
      integer, intent(in) :: from
      integer :: i

      if (from > n_open) return ! seams that meet at a place without a loop
      do i = n_open, from, -1
        begun(place(edge(i))) = earlier(i)
        order(n_free) = edge(i)
        n_free = n_free - 1
      end do
      n_open = from - 1
      n_loops = n_loops + 1
      start(n_loops) = n_free + 1
    end subroutine close_loop

  end subroutine take_apart

  !> Puts the first loop that turns counter-clockwise before the others.
  pure subroutine put_outline_first(vertex, order, first)
    real(dp), intent(in) :: vertex(:, :)
    integer, intent(inout) :: order(:), first(:)
    integer :: k, n

    do k = 1, size(first) - 1
      if (twice_area(vertex(:, order(first(k):first(k + 1) - 1))) > 0) exit
    end do
    if (k == 1 .or. k == size(first)) return
    n = first(k + 1) - first(k)
    order(:first(k + 1) - 1) = cshift(order(:first(k + 1) - 1), -n)
    first(2:k) = first(:k - 1) + n
  end subroutine put_outline_first

  !> Numbers of the places of vertices, from 1; vertices that coincide are at one place.
  pure function places_of(vertex) result(place)
    real(dp), intent(in) :: vertex(:, :)  !! (2, n), n > 0
    integer :: place(size(vertex, 2))
    integer :: k, n_places, order(size(vertex, 2))

    order = order_of_places(vertex)
    n_places = 1
    place(order(1)) = 1
    do k = 2, size(order)
      if (any(abs(vertex(:, order(k)) - vertex(:, order(k - 1))) > 0)) n_places = n_places + 1
      place(order(k)) = n_places
    end do
  end function places_of

  !> The edge of a polygon that runs along each edge in reverse, 0 where there is none; edge k leaves vertex k.
  pure function ways_back(place) result(back)
    integer, intent(in) :: place(:)   !! (n)
    integer :: back(size(place))
    integer :: high(size(place)), i, k, low(size(place)), n_waiting, next(size(place)), order(size(place)), waiting(size(place))

    next = cshift(place, 1)
    low = min(place, next)
    high = max(place, next)
    order = order_of_pairs(low, high)
    back = 0
    n_waiting = 0
    do i = 1, size(order)
      k = order(i)
      if (low(k) == high(k)) cycle
      if (n_waiting > 0) then
        associate (last => waiting(n_waiting))
          if (low(last) /= low(k) .or. high(last) /= high(k)) then
            n_waiting = 0
          else if (place(last) /= place(k)) then
            back([last, k]) = [k, last]
            n_waiting = n_waiting - 1
            cycle
          end if
        end associate
      end if
      n_waiting = n_waiting + 1
      waiting(n_waiting) = k
    end do
  end function ways_back

end module scree_keyholes
