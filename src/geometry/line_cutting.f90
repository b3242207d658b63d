!> Lines to a planar graph: nodes, and pieces that meet at nodes and nowhere else (Shi's dc03 to dc06).
!>
!> Shi's rules with two distances, e = e0 w0 for a node and a piece, 1.25 e for two nodes: what is nearer is one. Where
!> he deletes what lies too near, here it is bent through the node, which loses no area. One pass finds all crossings
!> and all nodes too near to a piece, splits the pieces there, and the passes repeat until there are none (iterated
!> snapping; Halperin and Packer 2002 for the idea). They end: a new node lies apart from all others, so there are
!> finitely many, and a piece is split only into shorter ones: at nodes nearer to both its ends than they are to each
!> other. What remains is planar by an exact test (scree_predicates), however nearly parallel the lines.
module scree_line_cutting
  use scree_cell_grid, only: cell_grid_t, cells_of_box, number_of_cell, place_segments, set_up_grid
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_kinds, only: dp
  use scree_predicates, only: orientation
  use scree_sorting, only: columns, sort_by
  implicit none
  private
  public :: cut_lines, drop_perpendicular, graph_t

  real(dp), parameter :: node_share = 1.25_dp                !! of e: distance at which two nodes are one
  real(dp), parameter :: least_share = 64*epsilon(1.0_dp)    !! of the extent: e is never less, as crossings are rounded
  integer, parameter :: most_passes = 200

  !> Nodes and the pieces between them.
  type :: graph_t
    real(dp), allocatable :: position(:, :)   !! (2, n_nodes), length
    integer, allocatable :: ends(:, :)     !! (2, n_pieces) nodes
    integer, allocatable :: line(:)        !! (n_pieces) line that a piece is of, and runs along; the first of those that coincide
    integer, allocatable :: against(:)     !! (n_pieces) the first of these that runs the other way; `line` where none does
    real(dp) :: nearest = 0.0_dp           !! e as used, length
    real(dp) :: rounding = 0.0_dp          !! the least e: what lies nearer to a line is on it, length
  end type graph_t

  !> Nodes by cell, so that the one next to a position is found at once.
  type :: nodes_t
    type(cell_grid_t) :: grid
    integer, allocatable :: head(:)        !! (n_cells) last node of a cell
    integer, allocatable :: before(:)      !! (n) node before it in its cell
    real(dp), allocatable :: position(:, :)   !! (2, n)
    logical, allocatable :: boundary(:)    !! (n) made by boundary lines alone
    logical, allocatable :: free(:)        !! (n) end of one line that touches nothing
    integer :: n = 0
  end type nodes_t

  !> Nodes that split pieces.
  type :: splits_t
    integer, allocatable :: piece(:), node(:)
    integer :: n = 0
  end type splits_t

contains

  !> Cuts lines at each other.
  !>
  !> Boundary lines are the first; among themselves they keep details smaller than e, as in dc. Ends are joined before
  !> anything is cut, so that the argument above holds for the lines as they are then. A single end within e of
  !> another line is brought onto it. Errors: the passes do not end, which the argument above excludes.
  subroutine cut_lines(ends, n_boundary, nearest, graph, error)
    real(dp), intent(in) :: ends(:, :, :)     !! (xy, end, n_lines), length
    integer, intent(in) :: n_boundary         !! lines that are boundary
    real(dp), intent(in) :: nearest           !! e, length
    type(graph_t), intent(out) :: graph
    type(error_t), allocatable, intent(out) :: error
    type(nodes_t) :: nodes
    type(cell_grid_t) :: grid
    type(splits_t) :: splits
    real(dp) :: low(2), high(2)
    integer :: pass

    low = minval(minval(ends, 3), 2)
    high = maxval(maxval(ends, 3), 2)
    graph%rounding = least_share*maxval(high - low)
    graph%nearest = max(nearest, graph%rounding)
    call set_up_grid(nodes%grid, reshape(ends, [2, 2*size(ends, 3)]), 2*size(ends, 3))
    call take_ends(ends, n_boundary, nodes, graph)
    do pass = 1, most_passes
      if (size(graph%line) == 0) exit ! all are of no length
      call set_up_grid(grid, nodes%position(:, :nodes%n), size(graph%line))
      call place_segments(grid, nodes%position(:, :nodes%n), graph%ends, 2*graph%nearest)
      splits%n = 0
      call cross_pieces(grid, n_boundary, pass == 1, graph, nodes, splits)
      if (pass == 1) call settle_free_ends(grid, graph, nodes, splits)
      call snap_to_nodes(grid, n_boundary, graph, nodes, splits)
      deallocate (grid%first, grid%item)
      if (splits%n == 0 .and. pass > 1) exit
      call split_pieces(nodes, splits, graph)
    end do
    graph%position = nodes%position(:, :nodes%n)
    if (pass > most_passes) call fail(error, status_run_failed, 'cutting the lines does not come to an end')
  end subroutine cut_lines

  !> Nodes of the ends of lines, one where they coincide, and one where ends that coincide with others lie near each
  !> other; lines without length are dropped.
  subroutine take_ends(ends, n_boundary, nodes, graph)
    real(dp), intent(in) :: ends(:, :, :)
    integer, intent(in) :: n_boundary
    type(nodes_t), intent(inout) :: nodes
    type(graph_t), intent(inout) :: graph
    type(nodes_t) :: met
    integer :: node(2, size(ends, 3)), i, k
    integer, allocatable :: into(:), number(:)

    met%grid = nodes%grid
    call make_room(met, size(node))
    do i = 1, size(ends, 3)
      do k = 1, 2
        node(k, i) = node_at(met, ends(:, k, i), graph%rounding, graph%rounding, .false., .true.)
        if (node(k, i) > 0) then
          met%free(node(k, i)) = met%free(node(k, i)) .and. k == 2 .and. node(1, i) == node(2, i)
        else
          call add_node(met, ends(:, k, i), i <= n_boundary, .true., node(k, i))
        end if
      end do
    end do
    call merge_shared_ends(met, graph, into)
    call make_room(nodes, 2*size(node))
    graph%line = pack([(i, i=1, size(ends, 3))], into(node(1, :)) /= into(node(2, :)))
    graph%against = graph%line
    graph%ends = reshape([(into(node(:, graph%line(i))), i=1, size(graph%line))], [2, size(graph%line)])
    allocate (number(met%n), source=0)
    do i = 1, size(graph%line)
      do k = 1, 2
        associate (n => graph%ends(k, i))
          if (number(n) == 0) call add_node(nodes, met%position(:, n), met%boundary(n), met%free(n), number(n))
          n = number(n)
        end associate
      end do
    end do
  end subroutine take_ends

  !> The node that each node becomes: a shared end joins the nearest of those before it that stay, within 1.25 e, all
  !> others stay. The order is of positions, so that neither the numbers of the lines nor the lengths of chains of near
  !> nodes matter: what stays is apart, and nothing moves farther than 1.25 e.
  subroutine merge_shared_ends(nodes, graph, into)
    type(nodes_t), intent(in) :: nodes
    type(graph_t), intent(in) :: graph
    integer, allocatable, intent(out) :: into(:)  !! (n)
    type(nodes_t) :: staying
    integer :: i, k, near, shared(count(.not. nodes%free(:nodes%n))), node_of(size(shared))

    into = [(i, i=1, nodes%n)]
    shared = in_order(nodes, pack(into, .not. nodes%free(:nodes%n)))
    staying%grid = nodes%grid
    call make_room(staying, size(shared))
    do i = 1, size(shared)
      k = shared(i)
      near = node_at(staying, nodes%position(:, k), graph%nearest, graph%rounding, nodes%boundary(k), .true.)
      if (near > 0) then
        into(k) = node_of(near)
      else
        call add_node(staying, nodes%position(:, k), nodes%boundary(k), .false., near)
        node_of(near) = k
      end if
    end do
  end subroutine merge_shared_ends

  !> Nodes by position: those of the boundary first, then from left to right, then upwards.
  pure function in_order(nodes, list) result(sorted)
    type(nodes_t), intent(in) :: nodes
    integer, intent(in) :: list(:)
    integer :: sorted(size(list))
    real(dp) :: key(size(list))

    sorted = list
    key = nodes%position(2, sorted)
    call sort_by(key, sorted)
    key = nodes%position(1, sorted)
    call sort_by(key, sorted)
    key = merge(0.0_dp, 1.0_dp, nodes%boundary(sorted))
    call sort_by(key, sorted)
  end function in_order

  !> Makes empty lists for a number of nodes, which may grow.
  pure subroutine make_room(nodes, n)
    type(nodes_t), intent(inout) :: nodes
    integer, intent(in) :: n

    allocate (nodes%head(nodes%grid%n(1)*nodes%grid%n(2)), source=0)
    allocate (nodes%position(2, n), nodes%before(n), nodes%boundary(n), nodes%free(n))
  end subroutine make_room

  !> Adds a node.
  pure subroutine add_node(nodes, position, boundary, free, node)
    type(nodes_t), intent(inout) :: nodes
    real(dp), intent(in) :: position(2)
    logical, intent(in) :: boundary, free
    integer, intent(out) :: node
    integer, allocatable :: before(:)
    logical, allocatable :: flag(:)
    real(dp), allocatable :: places(:, :)
    integer :: n

    n = nodes%n
    if (n == size(nodes%before)) then
      allocate (before(2*n), places(2, 2*n))
      allocate (flag(2*n), source=.false.)
      before(:n) = nodes%before
      call move_alloc(before, nodes%before)
      places(:, :n) = nodes%position
      call move_alloc(places, nodes%position)
      flag(:n) = nodes%boundary
      nodes%boundary = flag
      flag(:n) = nodes%free
      call move_alloc(flag, nodes%free)
    end if
    node = n + 1
    nodes%n = node
    nodes%position(:, node) = position
    nodes%boundary(node) = boundary
    nodes%free(node) = free
    call list_node(nodes, node)
  end subroutine add_node

  !> Puts a node into its cell.
  pure subroutine list_node(nodes, node)
    type(nodes_t), intent(inout) :: nodes
    integer, intent(in) :: node
    integer :: cell, range(2, 2)

    range = cells_of_box(nodes%grid, nodes%position(:, node), nodes%position(:, node))
    cell = number_of_cell(nodes%grid, range(1, 1), range(2, 1))
    nodes%before(node) = nodes%head(cell)
    nodes%head(cell) = node
  end subroutine list_node

  !> Takes a node out of its cell.
  pure subroutine unlist_node(nodes, node)
    type(nodes_t), intent(inout) :: nodes
    integer, intent(in) :: node
    integer :: cell, k, range(2, 2)

    range = cells_of_box(nodes%grid, nodes%position(:, node), nodes%position(:, node))
    cell = number_of_cell(nodes%grid, range(1, 1), range(2, 1))
    k = nodes%head(cell)
    if (k == node) then
      nodes%head(cell) = nodes%before(node)
      return
    end if
    do while (nodes%before(k) /= node)
      k = nodes%before(k)
    end do
    nodes%before(k) = nodes%before(node)
  end subroutine unlist_node

  !> The node that a position is one with, 0 where there is none.
  pure integer function node_at(nodes, position, nearest, least, boundary, with_free, but)
    type(nodes_t), intent(in) :: nodes
    real(dp), intent(in) :: position(2)
    real(dp), intent(in) :: nearest, least   !! e, and its least
    logical, intent(in) :: boundary          !! the place is of boundary lines alone
    logical, intent(in) :: with_free         !! free ends count
    integer, intent(in), optional :: but     !! a node that does not count
    real(dp) :: distance, nearest_yet
    integer :: column, k, left_out, range(2, 2), row

    left_out = 0
    if (present(but)) left_out = but
    node_at = 0
    nearest_yet = node_share*nearest
    range = cells_of_box(nodes%grid, position - nearest_yet, position + nearest_yet)
    do row = range(2, 1), range(2, 2)
      do column = range(1, 1), range(1, 2)
        k = nodes%head(number_of_cell(nodes%grid, column, row))
        do while (k > 0)
          distance = norm2(nodes%position(:, k) - position)
          if (distance <= nearest_yet .and. (with_free .or. .not. nodes%free(k)) .and. k /= left_out) then
            if (.not. (boundary .and. nodes%boundary(k)) .or. distance <= node_share*least) then
              node_at = k
              nearest_yet = distance
            end if
          end if
          k = nodes%before(k)
        end do
      end do
    end do
  end function node_at

  !> Finds where pieces cross, and the node there.
  subroutine cross_pieces(grid, n_boundary, settling, graph, nodes, splits)
    type(cell_grid_t), intent(in) :: grid
    integer, intent(in) :: n_boundary
    logical, intent(in) :: settling            !! free ends will be joined to what they lie beside
    type(graph_t), intent(in) :: graph
    type(nodes_t), intent(inout) :: nodes
    type(splits_t), intent(inout) :: splits
    real(dp) :: low(2, size(graph%line)), high(2, size(graph%line))
    integer :: cell, i, k, p, q

    do i = 1, size(graph%line)
      low(:, i) = min(nodes%position(:, graph%ends(1, i)), nodes%position(:, graph%ends(2, i)))
      high(:, i) = max(nodes%position(:, graph%ends(1, i)), nodes%position(:, graph%ends(2, i)))
    end do
    do cell = 1, size(grid%first) - 1
      do i = grid%first(cell), grid%first(cell + 1) - 1
        p = grid%item(i)
        do k = i + 1, grid%first(cell + 1) - 1
          q = grid%item(k)
          if (low(1, p) > high(1, q) .or. low(1, q) > high(1, p)) cycle
          if (low(2, p) > high(2, q) .or. low(2, q) > high(2, p)) cycle
          call cross(p, q)
        end do
      end do
    end do

  contains

    !> One pair: where each has the ends of the other on different sides.
    subroutine cross(p, q)
      integer, intent(in) :: p, q
      real(dp) :: along, off(2), position(2), v(2)
      integer :: node
      logical :: boundary

      associate (a => graph%ends(1, p), b => graph%ends(2, p), c => graph%ends(1, q), d => graph%ends(2, q))
        if (a == c .or. a == d .or. b == c .or. b == d) return
        associate (pa => nodes%position(:, a), pb => nodes%position(:, b), pc => nodes%position(:, c), pd => nodes%position(:, d))
          if (orientation(pa, pb, pc)*orientation(pa, pb, pd) >= 0) return
          if (orientation(pc, pd, pa)*orientation(pc, pd, pb) >= 0) return
          v = pd - pc
          off = [v(1)*(pa(2) - pc(2)) - v(2)*(pa(1) - pc(1)), v(1)*(pb(2) - pc(2)) - v(2)*(pb(1) - pc(1))]
          position = pa + (pb - pa)*(abs(off(1))/max(abs(off(1)) + abs(off(2)), tiny(1.0_dp)))
          along = dot_product(position - pc, v)
          if (along < 0) position = pc ! where the two are parallel to rounding, any position that both pass will do
          if (along > dot_product(v, v)) position = pd
          where (.not. abs(v) > 0) position = pc ! on a line along an axis without rounding
        end associate
      end associate
      boundary = graph%line(p) <= n_boundary .and. graph%line(q) <= n_boundary
      node = node_at(nodes, position, graph%nearest, graph%rounding, boundary, .false.)
      if (node > 0) then
        if (.not. (may_meet(p, node) .and. may_meet(q, node))) node = 0
      end if
      if (node == 0) node = node_at(nodes, position, 0.0_dp, graph%rounding, .false., .false.)
      if (node == 0) call add_node(nodes, position, boundary, .false., node)
      if (may_split(graph, nodes, p, node)) call add_split(splits, p, node)
      if (may_split(graph, nodes, q, node)) call add_split(splits, q, node)
    end subroutine cross

    !> Whether a piece ends at a node, or can be split there, or has a free end that will be joined to it.
    pure logical function may_meet(piece, node)
      integer, intent(in) :: piece, node
      integer :: k

      may_meet = any(graph%ends(:, piece) == node) .or. may_split(graph, nodes, piece, node)
      do k = 1, 2
        associate (at => graph%ends(k, piece))
          may_meet = may_meet .or. (settling .and. nodes%free(at) .and. &
                                    norm2(nodes%position(:, at) - nodes%position(:, node)) <= node_share*graph%nearest)
        end associate
      end do
    end function may_meet

  end subroutine cross_pieces

  !> Whether a node is no end of a piece, and nearer to both ends than they are to each other.
  pure logical function may_split(graph, nodes, piece, node)
    type(graph_t), intent(in) :: graph
    type(nodes_t), intent(in) :: nodes
    integer, intent(in) :: piece, node
    real(dp) :: length

    may_split = .false.
    if (any(graph%ends(:, piece) == node)) return
    associate (a => nodes%position(:, graph%ends(1, piece)), b => nodes%position(:, graph%ends(2, piece)), &
               c => nodes%position(:, node))
      length = sum((b - a)**2)
      may_split = sum((c - a)**2) < length .and. sum((c - b)**2) < length
    end associate
  end function may_split

  !> Adds to the list.
  pure subroutine add_split(splits, piece, node)
    type(splits_t), intent(inout) :: splits
    integer, intent(in) :: piece, node
    integer, allocatable :: longer(:)

    if (.not. allocated(splits%piece)) allocate (splits%piece(1024), splits%node(1024))
    if (splits%n == size(splits%piece)) then
      allocate (longer(2*splits%n))
      longer(:splits%n) = splits%piece
      splits%piece = longer
      longer(:splits%n) = splits%node
      call move_alloc(longer, splits%node)
    end if
    splits%n = splits%n + 1
    splits%piece(splits%n) = piece
    splits%node(splits%n) = node
  end subroutine add_split

  !> Joins ends that coincide with no other to a node beside them, or to another such end, or brings them onto the line
  !> beside them, in the order of their places.
  subroutine settle_free_ends(grid, graph, nodes, splits)
    type(cell_grid_t), intent(in) :: grid
    type(graph_t), intent(inout) :: graph
    type(nodes_t), intent(inout) :: nodes
    type(splits_t), intent(inout) :: splits
    real(dp) :: distance, foot(2), foot_yet(2), nearest_yet
    integer :: at_end(2, nodes%n), i, k, l, node, other, piece
    integer, allocatable :: ends(:)

    at_end = 0
    do i = 1, size(graph%line)
      do k = 1, 2
        if (nodes%free(graph%ends(k, i))) at_end(:, graph%ends(k, i)) = [k, i]
      end do
    end do
    ends = in_order(nodes, pack([(l, l=1, nodes%n)], at_end(1, :) > 0))
    do l = 1, size(ends)
      node = ends(l)
      if (.not. nodes%free(node) .or. at_end(1, node) == 0) cycle ! it has met one before it
      i = at_end(2, node)
      other = node_at(nodes, nodes%position(:, node), graph%nearest, graph%rounding, .false., .false.)
      if (other > 0) then
        call move_end(node, other)
        cycle
      end if
      other = node_at(nodes, nodes%position(:, node), graph%nearest, graph%rounding, nodes%boundary(node), .true., node)
      if (other > 0) then ! two free ends meet
        nodes%free(node) = .false.
        call move_end(other, node)
        cycle
      end if
      piece = 0
      nearest_yet = graph%nearest
      call look_around()
      if (piece == 0) cycle
      if (nearest_yet <= graph%rounding) foot_yet = nodes%position(:, node) ! on the line as it is
      call add_node(nodes, foot_yet, .false., .false., other)
      call move_end(node, other)
      if (may_split(graph, nodes, piece, other)) call add_split(splits, piece, other)
    end do

  contains

    !> Moves a free end to a node, and takes its own away.
    subroutine move_end(from, to)
      integer, intent(in) :: from, to

      graph%ends(at_end(1, from), at_end(2, from)) = to
      at_end(:, from) = 0
      call unlist_node(nodes, from)
    end subroutine move_end

    !> The nearest piece of another line that the end lies beside.
    subroutine look_around()
      integer :: at, column, q, range(2, 2), row

      range = cells_of_box(grid, nodes%position(:, node), nodes%position(:, node))
      do row = range(2, 1), range(2, 2)
        do column = range(1, 1), range(1, 2)
          do at = grid%first(number_of_cell(grid, column, row)), grid%first(number_of_cell(grid, column, row) + 1) - 1
            q = grid%item(at)
            if (q == i) cycle
            call drop_perpendicular(nodes%position(:, graph%ends(1, q)), nodes%position(:, graph%ends(2, q)), &
                                    nodes%position(:, node), foot, distance)
            if (distance > nearest_yet) cycle
            nearest_yet = distance
            foot_yet = foot
            piece = q
          end do
        end do
      end do
    end subroutine look_around

  end subroutine settle_free_ends

  !> Foot of the perpendicular from a position to a segment, and its length; huge where the foot is not between the ends.
  pure subroutine drop_perpendicular(a, b, position, foot, distance)
    real(dp), intent(in) :: a(2), b(2), position(2)
    real(dp), intent(out) :: foot(2), distance
    real(dp) :: share

    foot = a
    distance = huge(distance)
    if (.not. sum((b - a)**2) > 0) return ! both ends of a short line have become one
    share = dot_product(position - a, b - a)/dot_product(b - a, b - a)
    foot = a + share*(b - a)
    if (share > 0 .and. share < 1) distance = norm2(position - foot)
  end subroutine drop_perpendicular

  !> Finds nodes that lie too near to a piece.
  subroutine snap_to_nodes(grid, n_boundary, graph, nodes, splits)
    type(cell_grid_t), intent(in) :: grid
    integer, intent(in) :: n_boundary
    type(graph_t), intent(in) :: graph
    type(nodes_t), intent(in) :: nodes
    type(splits_t), intent(inout) :: splits
    real(dp) :: distance, foot(2), reach
    integer :: at, cell, node, p, range(2, 2)

    do node = 1, nodes%n
      if (nodes%free(node)) cycle
      range = cells_of_box(grid, nodes%position(:, node), nodes%position(:, node)) ! the lists of the grid have the margin
      cell = number_of_cell(grid, range(1, 1), range(2, 1))
      do at = grid%first(cell), grid%first(cell + 1) - 1
        p = grid%item(at)
        if (.not. may_split(graph, nodes, p, node)) cycle
        reach = graph%nearest
        if (nodes%boundary(node) .and. graph%line(p) <= n_boundary) reach = graph%rounding
        call drop_perpendicular(nodes%position(:, graph%ends(1, p)), nodes%position(:, graph%ends(2, p)), nodes%position(:, node), &
                                foot, distance)
        if (distance <= reach) call add_split(splits, p, node)
      end do
    end do
  end subroutine snap_to_nodes

  !> Splits the pieces at their nodes, in order along them, and keeps one of those that coincide.
  subroutine split_pieces(nodes, splits, graph)
    type(nodes_t), intent(in) :: nodes
    type(splits_t), intent(in) :: splits
    type(graph_t), intent(inout) :: graph
    integer :: first(size(graph%line) + 1), order(splits%n), i, k, n
    integer, allocatable :: ends(:, :), piece(:), line(:), against(:), chain(:)
    real(dp), allocatable :: along(:)

    first = 0
    do i = 1, splits%n
      first(splits%piece(i)) = first(splits%piece(i)) + 1
    end do
    n = 1
    do i = 1, size(first)
      k = first(i)
      first(i) = n
      n = n + k
    end do
    do i = 1, splits%n
      associate (at => first(splits%piece(i)))
        order(at) = splits%node(i)
        at = at + 1
      end associate
    end do
    first = [1, first(:size(first) - 1)]

    allocate (ends(2, size(graph%line) + splits%n), piece(size(graph%line) + splits%n))
    n = 0
    do i = 1, size(graph%line)
      associate (a => graph%ends(1, i), b => graph%ends(2, i))
        chain = order(first(i):first(i + 1) - 1)
        along = real(chain, dp)
        call sort_by(along, chain) ! so that one found twice stands side by side
        along = [(dot_product(nodes%position(:, chain(k)) - nodes%position(:, a), nodes%position(:, b) - nodes%position(:, a)), &
                  k=1, size(chain))]
        call sort_by(along, chain)
        chain = [a, chain, b]
        if (grows(nodes, chain)) chain = [a, chain(2), b] ! nodes on both sides of a short piece: the others wait for a pass
        do k = 1, size(chain) - 1
          if (chain(k) == chain(k + 1)) cycle
          n = n + 1
          ends(:, n) = chain(k:k + 1)
          piece(n) = i
        end do
      end associate
    end do
    line = graph%line(piece(:n))
    against = graph%against(piece(:n))
    call drop_doubles(nodes%n, ends(:, :n), line, against, graph)
  end subroutine split_pieces

  !> Whether a step of a chain is not shorter than the straight between its ends.
  pure logical function grows(nodes, chain)
    type(nodes_t), intent(in) :: nodes
    integer, intent(in) :: chain(:)
    integer :: k

    grows = .false.
    if (size(chain) < 4) return ! one node: may_split has seen to it
    associate (position => nodes%position(:, chain))
      do k = 2, size(chain)
        if (chain(k) == chain(k - 1)) cycle
        grows = grows .or. sum((position(:, k) - position(:, k - 1))**2) >= sum((position(:, size(chain)) - position(:, 1))**2)
      end do
    end associate
  end function grows

  !> Keeps, of the pieces between two nodes, the one of the first line, with the first line that runs the other way.
  subroutine drop_doubles(n_nodes, ends, line, against, graph)
    integer, intent(in) :: n_nodes, ends(:, :), line(:), against(:)
    type(graph_t), intent(inout) :: graph
    integer :: head(n_nodes), before(size(line)), other(size(line)), i, k, low
    logical :: keep(size(line))

    head = 0
    other = against
    do i = 1, size(line) ! in the order of lines
      low = minval(ends(:, i))
      k = head(low)
      do while (k > 0)
        if (sum(ends(:, k)) == sum(ends(:, i)) .and. any(ends(:, k) == low)) exit
        k = before(k)
      end do
      keep(i) = k == 0
      if (keep(i)) then
        before(i) = head(low)
        head(low) = i
      else if (other(k) == line(k)) then
        if (ends(1, i) /= ends(1, k)) other(k) = line(i)
        if (ends(1, i) == ends(1, k) .and. against(i) /= line(i)) other(k) = against(i)
      end if
    end do
    graph%ends = columns(ends, keep)
    graph%line = pack(line, keep)
    graph%against = pack(other, keep)
  end subroutine drop_doubles

end module scree_line_cutting
