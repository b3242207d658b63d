!> A planar graph to the regions it encloses, blocks with holes among them (Shi's dc07 to dc09, dc16).
!>
!> Every piece is two half-edges, one each way; at a node the next of a loop is the first clockwise from the way back,
!> so that the region lies on the left. A piece with one loop on both sides encloses nothing - a dangling end, a tree,
!> a bridge - and is left out. Loops that turn counter-clockwise bound a region from outside; the others are holes of
!> the region around them. Shi's dc deletes what lies in a hole; here the block keeps its hole, and what lies in it too.
module scree_loop_tracing
  use scree_cell_grid, only: cell_grid_t, cells_of_box, left_of_column, number_of_cell, place_segments, set_up_grid
  use scree_kinds, only: dp
  use scree_line_cutting, only: graph_t
  use scree_polygon, only: twice_area
  use scree_predicates, only: orientation
  use scree_regions, only: regions_t
  use scree_sorting, only: sort_by, sort_into
  implicit none
  private
  public :: trace_regions

  !> A corner nearer to its chord than this fraction of the graph's rounding is none. Nodes are farther than that rounding
  !> from the pieces they are no end of, so that no region loses its area.
  real(dp), parameter :: straight = 0.25_dp

  !> Simple loops, and the cycle of half-edges that each was part of: a cycle has the same region on its left.
  type :: loops_t
    integer :: n = 0
    integer, allocatable :: first(:)        !! (n+1) loop k owns half(first(k):first(k+1)-1)
    integer, allocatable :: half(:)         !! half-edges in order
    integer, allocatable :: cycle(:)        !! (n)
    logical, allocatable :: around(:)       !! (n) counter-clockwise
  end type loops_t

contains

  !> Regions enclosed by the pieces, in the order in which Shi's dc meets them: by the first node, nodes in the order in
  !> which each line meets the lines before it.
  !>
  !> Outer loop counter-clockwise, holes clockwise. A corner on the straight between its neighbours is dropped where
  !> the material on both sides of it is one.
  subroutine trace_regions(graph, material, shape, vertex, line, beside)
    type(graph_t), intent(in) :: graph
    integer, intent(in) :: material(:, :)                  !! (2, n_pieces) of the side on the left of each, and on its right
    type(regions_t), intent(out) :: shape                  !! its joint is the material
    real(dp), allocatable, intent(out) :: vertex(:, :)     !! (2, n_vertices), length
    integer, allocatable, intent(out) :: line(:)           !! (n_vertices) line of the edge to the next vertex
    integer, allocatable, intent(out) :: beside(:, :)      !! (2, n_pieces) region left and right of each piece, 0: none
    type(graph_t) :: enclosing
    type(loops_t) :: loops
    integer, allocatable :: before(:), cycle_of(:), kept(:), now(:), region(:)
    integer :: i, k

    enclosing = graph
    call trace_cycles(enclosing, loops, cycle_of)
    region = regions_of(enclosing, loops, cycle_of)
    before = region(cycle_of) ! of each half-edge
    kept = pack([(i, i=1, size(graph%line))], cycle_of(1::2) /= cycle_of(2::2))
    if (size(kept) < size(graph%line)) then
      enclosing%ends = graph%ends(:, kept)
      enclosing%line = graph%line(kept)
      enclosing%against = graph%against(kept)
      call trace_cycles(enclosing, loops, cycle_of)
      region = regions_of(enclosing, loops, cycle_of)
    end if

    allocate (now(0:maxval([0, before])), source=0) ! the regions are the same, their numbers may not be
    do i = 1, size(kept)
      do k = 1, 2
        now(before(2*kept(i) - 2 + k)) = region(cycle_of(2*i - 2 + k))
      end do
    end do
    now(0) = 0
    beside = reshape(now(before), [2, size(graph%line)])
    region = region(loops%cycle(:loops%n))
    call keep_corners(enclosing, loops, region, material(:, kept), shape, vertex, line)
  end subroutine trace_regions

  !> Node that a half-edge leaves: piece p has the half-edges 2p-1, from its first end, and 2p, from its second.
  pure integer function origin_of(graph, half)
    type(graph_t), intent(in) :: graph
    integer, intent(in) :: half

    origin_of = graph%ends(2 - modulo(half, 2), (half + 1)/2)
  end function origin_of

  !> The other half-edge of the piece.
  pure integer function way_back(half)
    integer, intent(in) :: half

    way_back = half - 1 + 2*modulo(half, 2)
  end function way_back

  !> All cycles of half-edges, taken apart into simple loops where they touch themselves.
  subroutine trace_cycles(graph, loops, cycle_of)
    type(graph_t), intent(in) :: graph
    type(loops_t), intent(out) :: loops
    integer, allocatable, intent(out) :: cycle_of(:)   !! (2 n_pieces)
    integer, allocatable :: first(:), half(:), next(:), order(:), stack(:), place_of(:)
    integer :: at, i, k, n_cycles, n_half, n_out, depth, start

    n_half = 2*size(graph%line)
    call sort_half_edges(graph, first, half)
    allocate (next(n_half), cycle_of(n_half), stack(n_half), place_of(size(graph%position, 2)))
    cycle_of = 0
    do i = 1, size(first) - 1
      do k = first(i), first(i + 1) - 1
        at = k - 1
        if (at < first(i)) at = first(i + 1) - 1
        next(way_back(half(k))) = half(at)
      end do
    end do

    allocate (loops%first(n_half + 1), loops%half(n_half), loops%cycle(n_half), loops%around(n_half))
    loops%first(1) = 1
    place_of = 0
    n_cycles = 0
    n_out = 0
    order = order_of_nodes(graph, first, half)
    do i = 1, size(order)
      do k = first(order(i)), first(order(i) + 1) - 1
        start = half(k)
        if (cycle_of(start) /= 0) cycle
        n_cycles = n_cycles + 1
        at = start
        depth = 0
        do while (cycle_of(at) == 0)
          cycle_of(at) = n_cycles
          if (place_of(origin_of(graph, at)) > 0) call close_loop((place_of(origin_of(graph, at)))) ! a copy, as it changes there
          depth = depth + 1
          stack(depth) = at
          place_of(origin_of(graph, at)) = depth
          at = next(at)
        end do
        call close_loop(1)
      end do
    end do

  contains

    !> Removes the half-edges from `from` on from the stack, as a loop.
    subroutine close_loop(from)
      integer, intent(in) :: from
      integer :: j

      loops%n = loops%n + 1
      do j = from, depth
        n_out = n_out + 1
        loops%half(n_out) = stack(j)
        place_of(origin_of(graph, stack(j))) = 0
      end do
      loops%first(loops%n + 1) = n_out + 1
      loops%cycle(loops%n) = n_cycles
      associate (loop => loops%half(loops%first(loops%n):n_out))
        loops%around(loops%n) = twice_area(graph%position(:, [(origin_of(graph, loop(j)), j=1, size(loop))])) > 0
      end associate
      depth = from - 1
    end subroutine close_loop

  end subroutine trace_cycles

  !> Half-edges by the node they leave, counter-clockwise from the direction of -x.
  subroutine sort_half_edges(graph, first, half)
    type(graph_t), intent(in) :: graph
    integer, allocatable, intent(out) :: first(:)     !! (n_nodes+1)
    integer, allocatable, intent(out) :: half(:)      !! (2 n_pieces)
    integer :: h, i

    call sort_into([(origin_of(graph, h), h=1, 2*size(graph%line))], size(graph%position, 2), first, half)
    do i = 1, size(graph%position, 2)
      call sort_around(half(first(i):first(i + 1) - 1))
    end do

  contains

    !> Merge sort of half-edges of one node.
    recursive subroutine sort_around(list)
      integer, intent(inout) :: list(:)
      integer :: sorted(size(list)), k, left, middle, right

      if (size(list) < 2) return
      middle = size(list)/2
      call sort_around(list(:middle))
      call sort_around(list(middle + 1:))
      left = 1
      right = middle + 1
      do k = 1, size(list)
        if (right > size(list)) then
          sorted(k) = list(left)
          left = left + 1
        else if (left > middle) then
          sorted(k) = list(right)
          right = right + 1
        else if (comes_before(list(right), list(left))) then
          sorted(k) = list(right)
          right = right + 1
        else
          sorted(k) = list(left)
          left = left + 1
        end if
      end do
      list = sorted
    end subroutine sort_around

    !> Whether a half-edge comes before another, both from the same node.
    logical function comes_before(p, q)
      integer, intent(in) :: p, q
      logical :: upper(2)

      associate (o => graph%position(:, origin_of(graph, p)), a => graph%position(:, origin_of(graph, way_back(p))), &
                 b => graph%position(:, origin_of(graph, way_back(q))))
        upper = [a(2) > o(2) .or. (.not. a(2) < o(2) .and. a(1) > o(1)), &
                 b(2) > o(2) .or. (.not. b(2) < o(2) .and. b(1) > o(1))]
        if (upper(1) .neqv. upper(2)) then
          comes_before = upper(2)
        else
          comes_before = orientation(o, a, b) > 0
        end if
      end associate
    end function comes_before

  end subroutine sort_half_edges

  !> Nodes in the order of dc04: line after line, each with the lines before it.
  function order_of_nodes(graph, first, half) result(order)
    type(graph_t), intent(in) :: graph
    integer, intent(in) :: first(:), half(:)
    integer, allocatable :: order(:)
    integer :: lowest(2, size(first) - 1), i, k, line

    lowest = huge(1)
    do i = 1, size(lowest, 2)
      do k = first(i), first(i + 1) - 1
        line = graph%line((half(k) + 1)/2)
        if (line < lowest(1, i)) then
          lowest(:, i) = [line, lowest(1, i)]
        else if (line > lowest(1, i) .and. line < lowest(2, i)) then
          lowest(2, i) = line
        end if
      end do
    end do
    order = [(i, i=1, size(lowest, 2))]
    order = order(stable_order(lowest(1, order), order))
    order = order(stable_order(lowest(2, order), order))
  end function order_of_nodes

  !> Places of keys in ascending order, equal ones as they come, by counting; a key that is huge comes last.
  function stable_order(key, alike) result(position)
    integer, intent(in) :: key(:)
    integer, intent(in) :: alike(:) !! of the same size
    integer :: position(size(alike))
    integer, allocatable :: start(:)
    integer :: bucket, i, next, count, most

    most = 1
    if (any(key < huge(1))) most = maxval(key, key < huge(1)) + 1
    allocate (start(most), source=0)
    do i = 1, size(key)
      bucket = min(key(i), most)
      start(bucket) = start(bucket) + 1
    end do
    next = 1
    do i = 1, most
      count = start(i)
      start(i) = next
      next = next + count
    end do
    do i = 1, size(key)
      bucket = min(key(i), most)
      position(start(bucket)) = i
      start(bucket) = start(bucket) + 1
    end do
  end function stable_order

  !> Region on the left of each cycle, 0 outside everything: the loop around it, of its own or found by looking towards -x.
  function regions_of(graph, loops, cycle_of) result(region)
    type(graph_t), intent(in) :: graph
    type(loops_t), intent(in) :: loops
    integer, intent(in) :: cycle_of(:)
    integer, allocatable :: region(:)
    integer, allocatable :: of_cycle(:), first_node(:), open(:)
    type(cell_grid_t) :: grid
    integer :: c, i, k, n_open, n_regions
    real(dp), allocatable :: x(:)

    n_regions = 0
    allocate (of_cycle(maxval([0, cycle_of])))
    of_cycle = -1
    do i = 1, loops%n
      if (.not. loops%around(i)) cycle
      n_regions = n_regions + 1
      of_cycle(loops%cycle(i)) = n_regions
    end do

    ! Cycles around which there is something else: the leftmost node of each, from left to right.
    allocate (first_node(size(of_cycle)), source=0)
    do i = 1, loops%n
      c = loops%cycle(i)
      if (of_cycle(c) > 0) cycle
      do k = loops%first(i), loops%first(i + 1) - 1
        associate (node => origin_of(graph, loops%half(k)))
          if (first_node(c) == 0) first_node(c) = node
          if (graph%position(1, node) < graph%position(1, first_node(c))) first_node(c) = node
        end associate
      end do
    end do
    open = pack([(c, c=1, size(of_cycle))], first_node > 0)
    n_open = size(open)
    x = graph%position(1, first_node(open))
    call sort_by(x, open)
    if (n_open > 1) then
      call set_up_grid(grid, graph%position, size(graph%line))
      call place_segments(grid, graph%position, graph%ends, graph%rounding)
    end if
    do i = 1, n_open
      k = 0
      if (i > 1) k = piece_at_left(graph, grid, first_node(open(i)))
      of_cycle(open(i)) = 0
      if (k > 0) of_cycle(open(i)) = of_cycle(cycle_of(k))
    end do
    region = of_cycle
  end function regions_of

  !> Half-edge of the first piece to the left of a node that has the node's side on its left; 0 where there is none.
  !>
  !> A piece counts from its lower end up to below its upper one. Errors of rounding cannot mislead: the pieces that
  !> share a position there are compared by the exact test.
  integer function piece_at_left(graph, grid, node)
    type(graph_t), intent(in) :: graph
    type(cell_grid_t), intent(in) :: grid
    integer, intent(in) :: node
    real(dp) :: x, x_yet
    integer :: column, i, low, low_yet, p, p_yet, range(2, 2), row, up, up_yet

    p_yet = 0
    low_yet = 0
    up_yet = 0
    x_yet = -huge(x_yet)
    associate (position => graph%position(:, node))
      range = cells_of_box(grid, position, position)
      row = range(2, 1)
      do column = range(1, 1), 0, -1
        do i = grid%first(number_of_cell(grid, column, row)), grid%first(number_of_cell(grid, column, row) + 1) - 1
          p = grid%item(i)
          low = graph%ends(1, p)
          up = graph%ends(2, p)
          if (graph%position(2, low) > graph%position(2, up)) then
            low = up
            up = graph%ends(1, p)
          end if
          if (graph%position(2, low) > position(2) .or. .not. graph%position(2, up) > position(2)) cycle
          if (orientation(graph%position(:, low), graph%position(:, up), position) >= 0) cycle ! the node is not on its right
          x = graph%position(1, low) + (graph%position(1, up) - graph%position(1, low))* &
              ((position(2) - graph%position(2, low))/(graph%position(2, up) - graph%position(2, low)))
          if (p_yet > 0 .and. p /= p_yet) then
            if (low == low_yet) then
              if (orientation(graph%position(:, low), graph%position(:, up_yet), graph%position(:, up)) >= 0) cycle
            else if (up == up_yet) then
              if (orientation(graph%position(:, up), graph%position(:, low), graph%position(:, low_yet)) >= 0) cycle
            else if (x <= x_yet) then
              cycle
            end if
          end if
          p_yet = p
          low_yet = low
          up_yet = up
          x_yet = x
        end do
        if (p_yet > 0 .and. x_yet >= left_of_column(grid, column)) exit
      end do
    end associate
    piece_at_left = 0
    if (p_yet > 0) piece_at_left = 2*p_yet - merge(1, 0, graph%ends(1, p_yet) == up_yet) ! downwards
  end function piece_at_left

  !> Regions with their loops, without corners that are none.
  subroutine keep_corners(graph, loops, region, material, shape, vertex, line)
    type(graph_t), intent(in) :: graph
    type(loops_t), intent(in) :: loops
    integer, intent(in) :: region(:), material(:, :)
    type(regions_t), intent(out) :: shape
    real(dp), allocatable, intent(out) :: vertex(:, :)
    integer, allocatable, intent(out) :: line(:)
    integer :: first(0:maxval([0, region]) + 1), list(loops%n), at_node(size(graph%position, 2)), i, k, n_regions, n_vertices
    logical :: twice(size(graph%position, 2))

    n_regions = maxval([0, region])
    first = 0
    do i = 1, loops%n ! loops by region, the one around it first
      first(region(i) + 1) = first(region(i) + 1) + 1
    end do
    first(0) = 1
    do i = 1, n_regions + 1
      first(i) = first(i) + first(i - 1)
    end do
    shape%first_loop = first(1:) - first(1) + 1
    do k = 1, 2
      do i = 1, loops%n
        if (loops%around(i) .neqv. k == 1) cycle
        list(first(region(i))) = i
        first(region(i)) = first(region(i)) + 1
      end do
    end do
    allocate (vertex(2, size(loops%half)), line(size(loops%half)), shape%joint(size(loops%half)))
    allocate (shape%first_vertex(shape%first_loop(n_regions + 1)))
    twice = .false. ! nodes at which a region touches itself stay corners
    at_node = 0
    do i = 1, shape%first_loop(n_regions + 1) - 1
      k = list(first(0) - 1 + i)
      call mark_nodes(loops%half(loops%first(k):loops%first(k + 1) - 1), region(k))
    end do
    shape%first_vertex(1) = 1
    n_vertices = 0
    do i = 1, shape%first_loop(n_regions + 1) - 1
      k = list(first(0) - 1 + i)
      call take_loop(loops%half(loops%first(k):loops%first(k + 1) - 1))
      shape%first_vertex(i + 1) = n_vertices + 1
    end do
    vertex = vertex(:, :n_vertices)
    line = line(:n_vertices)
    shape%joint = shape%joint(:n_vertices)

  contains

    !> Marks the nodes that a region comes to more than once.
    subroutine mark_nodes(half, mark)
      integer, intent(in) :: half(:), mark
      integer :: j

      do j = 1, size(half)
        associate (node => origin_of(graph, half(j)))
          if (at_node(node) == mark) twice(node) = .true.
          at_node(node) = mark
        end associate
      end do
    end subroutine mark_nodes

    !> Adds the corners of a loop.
    subroutine take_loop(half)
      integer, intent(in) :: half(:)
      logical :: dropped(size(half))
      integer :: after, before, j, left

      dropped = .false.
      left = size(half)
      do j = 1, size(half)
        if (left == 3) exit
        before = j
        do
          before = modulo(before - 2, size(half)) + 1
          if (.not. dropped(before)) exit
        end do
        after = j
        do
          after = modulo(after, size(half)) + 1
          if (.not. dropped(after)) exit
        end do
        if (twice(origin_of(graph, half(j)))) cycle
        if (material_at(half(before)) /= material_at(half(j))) cycle
        dropped(j) = is_straight(graph%position(:, origin_of(graph, half(before))), graph%position(:, origin_of(graph, half(j))), &
                                 graph%position(:, origin_of(graph, half(after))))
        if (dropped(j)) left = left - 1
      end do
      do j = 1, size(half)
        if (dropped(j)) cycle
        n_vertices = n_vertices + 1
        vertex(:, n_vertices) = graph%position(:, origin_of(graph, half(j)))
        line(n_vertices) = graph%line((half(j) + 1)/2)
        shape%joint(n_vertices) = material_at(half(j))
      end do
    end subroutine take_loop

    !> Material of a half-edge: that of the side on its left.
    pure integer function material_at(half)
      integer, intent(in) :: half

      material_at = material(2 - modulo(half, 2), (half + 1)/2)
    end function material_at

    !> Whether b lies between a and c on their line, to rounding.
    pure logical function is_straight(a, b, c)
      real(dp), intent(in) :: a(2), b(2), c(2)
      real(dp) :: chord(2), way(2)

      chord = c - a
      way = b - a
      is_straight = dot_product(way, chord) > 0 .and. dot_product(c - b, chord) > 0 .and. &
                    abs(chord(1)*way(2) - chord(2)*way(1)) <= straight*graph%rounding*norm2(chord)
    end function is_straight

  end subroutine keep_corners

end module scree_loop_tracing
