!> Lines to a planar graph: nodes, and pieces that meet at nodes and nowhere else (Shi's dc03 to dc06).
!>
!> Shi's rules have two distances: e = e0 w0 between a node and a piece, and 1.25 e between two nodes. Nodes and pieces that
!> are nearer to each other become one. Shi deletes a piece that is too near to a node. Here the piece is bent through the
!> node, which loses no area. A straight line is never bent: the node goes onto the line.
!>
!> One pass finds all crossings and all nodes that are too near to a piece, and splits the pieces there. The passes repeat until
!> they find nothing (iterated snapping; Halperin and Packer 2002). Each looks near what the pass before has changed. The passes end
!> for two reasons. New nodes lie apart from all others, so there are finitely many. A piece is split only into shorter pieces, at
!> nodes that are nearer to both its ends than these are to each other. The result is planar by an exact test (scree_predicates),
!> even where lines are nearly parallel.
module scree_line_cutting
  use scree_cell_grid, only: cell_grid_t, cells_of_box, number_of_cell, place_boxes, place_segments, set_up_grid
  use scree_cut_nodes, only: add_node, cut_nodes_t, in_order, make_room, node_at, node_share, unlist_node
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_kinds, only: dp
  use scree_pairs, only: add_pair, list_others, pairs_t
  use scree_predicates, only: orientation
  use scree_sorting, only: columns, sort_by
  use scree_straight_lines, only: drop_perpendicular, list_straight_lines, nearest_straight_line, straight_lines_t
  implicit none
  private
  public :: cut_lines, graph_t

  real(dp), parameter :: least_share = 64*epsilon(1.0_dp)    !! of the extent: e is never less, as crossings are rounded
  integer, parameter :: most_passes = 200

  !> Nodes and the pieces between them.
  type :: graph_t
    real(dp), allocatable :: position(:, :)   !! (2, n_nodes), length
    integer, allocatable :: ends(:, :)     !! (2, n_pieces) nodes
    integer, allocatable :: line(:)        !! (n_pieces) line that a piece is of, and runs along; the first of those that coincide
    integer, allocatable :: against(:)     !! (n_pieces) the first of these in reverse direction; `line` where none is
    real(dp) :: nearest = 0.0_dp           !! e as used, length
    real(dp) :: rounding = 0.0_dp          !! the least e: what lies nearer to a line is on it, length
  end type graph_t

contains

  !> Cuts lines at each other.
  !>
  !> Straight lines keep their course to rounding, and among themselves they keep details that are smaller than e. A crossing or an
  !> end of other lines that lies within 1.25 e of a straight line is moved onto it. Ends are joined before anything is cut, so that
  !> the argument above holds for the lines as they are then. A single end within e of another line is brought onto that line.
  !> Errors: the passes do not end, which the argument above excludes.
  subroutine cut_lines(ends, straight, nearest, graph, error)
    real(dp), intent(in) :: ends(:, :, :)     !! (xy, end, n_lines), length
    logical, intent(in) :: straight(:)        !! (n_lines) lines that nothing bends
    real(dp), intent(in) :: nearest           !! e, length
    type(graph_t), intent(out) :: graph
    type(error_t), allocatable, intent(out) :: error
    type(cut_nodes_t) :: nodes
    type(cell_grid_t) :: grid
    type(pairs_t) :: splits                   ! pieces, and a node that splits each
    type(straight_lines_t) :: lines
    integer, allocatable :: list(:)           ! pieces to look at
    logical, allocatable :: changed(:)        ! (n_pieces) by the last pass
    real(dp) :: low(2), high(2)
    integer :: i, n_before, pass

    low = minval(minval(ends, 3), 2)
    high = maxval(maxval(ends, 3), 2)
    graph%rounding = least_share*maxval(high - low)
    graph%nearest = max(nearest, graph%rounding)
    call set_up_grid(nodes%grid, reshape(ends, [2, 2*size(ends, 3)]), 2*size(ends, 3))
    call list_straight_lines(ends, straight, node_share*graph%nearest, lines)
    call take_ends(ends, straight, lines, nodes, graph)
    allocate (changed(size(graph%line)), source=.true.)
    n_before = 0
    do pass = 1, most_passes
      list = [(i, i=1, size(graph%line))]
      if (2*count(changed) < size(changed)) list = pack(list, are_near(graph, nodes, changed, n_before))
      if (size(list) == 0) exit
      call set_up_grid(grid, nodes%position(:, :nodes%n), size(list))
      call place_segments(grid, nodes%position(:, :nodes%n), graph%ends(:, list), 2*graph%nearest)
      grid%item = list(grid%item)
      n_before = nodes%n
      changed = .false.
      splits%n = 0
      call cross_pieces(grid, straight, lines, pass == 1, graph, nodes, splits, changed)
      if (pass == 1) call settle_free_ends(grid, lines, graph, nodes, splits, changed)
      call snap_to_nodes(grid, straight, graph, nodes, splits)
      deallocate (grid%first, grid%item)
      if (splits%n == 0 .and. pass > 1) exit
      call split_pieces(nodes, splits, graph, changed)
    end do
    graph%position = nodes%position(:, :nodes%n)
    if (pass > most_passes) call fail(error, status_run_failed, 'cutting the lines does not come to an end')
  end subroutine cut_lines

  !> Which pieces lie near to one that the last pass has changed, or to a node that it has added. All others have been looked at as
  !> they are.
  pure function are_near(graph, nodes, changed, n_before) result(near)
    type(graph_t), intent(in) :: graph
    type(cut_nodes_t), intent(in) :: nodes
    logical, intent(in) :: changed(:)         !! (n_pieces)
    integer, intent(in) :: n_before           !! nodes before that pass
    logical :: near(size(changed))
    type(cell_grid_t) :: grid
    real(dp), allocatable :: low(:, :), high(:, :)
    real(dp) :: least(2), most(2)
    integer, allocatable :: ends(:, :)
    integer :: at, cell, column, i, k, range(2, 2), row

    ends = reshape([graph%ends(:, pack([(i, i=1, size(changed))], changed)), spread([(k, k=n_before + 1, nodes%n)], 1, 2)], &
                   [2, count(changed) + nodes%n - n_before])
    near = .false.
    if (size(ends, 2) == 0) return
    low = min(nodes%position(:, ends(1, :)), nodes%position(:, ends(2, :))) - 2*graph%nearest
    high = max(nodes%position(:, ends(1, :)), nodes%position(:, ends(2, :))) + 2*graph%nearest
    call set_up_grid(grid, reshape([low, high], [2, 2*size(ends, 2)]), size(ends, 2))
    call place_boxes(grid, low, high)
    do i = 1, size(near)
      least = min(nodes%position(:, graph%ends(1, i)), nodes%position(:, graph%ends(2, i)))
      most = max(nodes%position(:, graph%ends(1, i)), nodes%position(:, graph%ends(2, i)))
      range = cells_of_box(grid, least, most)
      search: do row = range(2, 1), range(2, 2)
        do column = range(1, 1), range(1, 2)
          cell = number_of_cell(grid, column, row)
          do at = grid%first(cell), grid%first(cell + 1) - 1
            k = grid%item(at)
            near(i) = all(most >= low(:, k)) .and. all(least <= high(:, k))
            if (near(i)) exit search
          end do
        end do
      end do search
    end do
  end function are_near

  !> Makes the nodes at the ends of lines: one node where ends coincide, and one where ends that coincide with others lie near
  !> each other. An end within 1.25 e of a straight line is moved onto it. Lines without length are dropped.
  subroutine take_ends(ends, straight, lines, nodes, graph)
    real(dp), intent(in) :: ends(:, :, :)
    logical, intent(in) :: straight(:)
    type(straight_lines_t), intent(in) :: lines
    type(cut_nodes_t), intent(inout) :: nodes
    type(graph_t), intent(inout) :: graph
    type(cut_nodes_t) :: met
    integer :: node(2, size(ends, 3)), i, k
    integer, allocatable :: into(:), number(:)
    real(dp) :: position(2)

    met%grid = nodes%grid
    call make_room(met, size(node))
    do i = 1, size(ends, 3)
      do k = 1, 2
        position = ends(:, k, i)
        if (.not. straight(i)) call move_onto_straight(lines, graph, position)
        node(k, i) = node_at(met, position, graph%rounding, .true.)
        if (node(k, i) > 0) then
          met%free(node(k, i)) = met%free(node(k, i)) .and. k == 2 .and. node(1, i) == node(2, i)
          met%corner(node(k, i)) = met%corner(node(k, i)) .or. straight(i)
        else
          call add_node(met, position, straight(i), .true., node(k, i))
        end if
      end do
    end do
    call merge_shared_ends(met, lines, graph, into)
    call make_room(nodes, 2*size(node))
    graph%line = pack([(i, i=1, size(ends, 3))], into(node(1, :)) /= into(node(2, :)))
    graph%against = graph%line
    graph%ends = reshape([(into(node(:, graph%line(i))), i=1, size(graph%line))], [2, size(graph%line)])
    allocate (number(met%n), source=0)
    do i = 1, size(graph%line)
      do k = 1, 2
        associate (n => graph%ends(k, i))
          if (number(n) == 0) call add_node(nodes, met%position(:, n), met%corner(n), met%free(n), number(n))
          n = number(n)
        end associate
      end do
    end do
  end subroutine take_ends

  !> Moves a position that lies within 1.25 e of a straight line onto that line. Two nodes are one at the same distance, so a
  !> position that stays off the line joins no node on it or beyond it.
  pure subroutine move_onto_straight(lines, graph, position)
    type(straight_lines_t), intent(in) :: lines
    type(graph_t), intent(in) :: graph
    real(dp), intent(inout) :: position(2)
    real(dp) :: foot(2)
    integer :: line

    call nearest_straight_line(lines, position, node_share*graph%nearest, line, foot)
    if (line > 0 .and. norm2(foot - position) > graph%rounding) position = foot
  end subroutine move_onto_straight

  !> The node that a position joins: the nearest within 1.25 e, and on the straight line that the position lies on, if any. A
  !> corner joins no node but one at the same place. 0 where there is none.
  pure integer function node_to_join(lines, graph, nodes, position, corner, with_free, but) result(node)
    type(straight_lines_t), intent(in) :: lines
    type(graph_t), intent(in) :: graph
    type(cut_nodes_t), intent(in) :: nodes
    real(dp), intent(in) :: position(2)      !! length
    logical, intent(in) :: corner            !! made by straight lines alone
    logical, intent(in) :: with_free         !! free ends count
    integer, intent(in), optional :: but     !! a node that does not count
    real(dp) :: foot(2), within
    integer :: line

    within = merge(graph%rounding, graph%nearest, corner)
    call nearest_straight_line(lines, position, graph%rounding, line, foot)
    if (line > 0) then
      node = node_at(nodes, position, within, with_free, but, lines%ends(:, :, line), graph%rounding)
    else
      node = node_at(nodes, position, within, with_free, but)
    end if
  end function node_to_join

  !> The node that each node becomes: a shared end joins the nearest of those before it that stay, within 1.25 e, and all others
  !> stay. The order is of positions: corners first, then nodes on straight lines. So neither the numbers of the lines nor the
  !> lengths of chains of near nodes matter. Nodes that stay are apart, and no node moves farther than 1.25 e here.
  subroutine merge_shared_ends(nodes, lines, graph, into)
    type(cut_nodes_t), intent(in) :: nodes
    type(straight_lines_t), intent(in) :: lines
    type(graph_t), intent(in) :: graph
    integer, allocatable, intent(out) :: into(:)  !! (n)
    type(cut_nodes_t) :: staying
    integer :: i, k, near, shared(count(.not. nodes%free(:nodes%n))), node_of(size(shared))

    into = [(i, i=1, nodes%n)]
    shared = in_order(nodes, pack(into, .not. nodes%free(:nodes%n)), priority_of(nodes, lines, graph))
    staying%grid = nodes%grid
    call make_room(staying, size(shared))
    do i = 1, size(shared)
      k = shared(i)
      near = node_to_join(lines, graph, staying, nodes%position(:, k), nodes%corner(k), .true.)
      if (near > 0) then
        into(k) = node_of(near)
      else
        call add_node(staying, nodes%position(:, k), nodes%corner(k), .false., near)
        node_of(near) = k
      end if
    end do
  end subroutine merge_shared_ends

  !> Which nodes come first where nodes join: corners (0), then nodes on straight lines (1), then all others (2).
  pure function priority_of(nodes, lines, graph) result(priority)
    type(cut_nodes_t), intent(in) :: nodes
    type(straight_lines_t), intent(in) :: lines
    type(graph_t), intent(in) :: graph
    real(dp) :: priority(nodes%n)
    real(dp) :: foot(2)
    integer :: k, line

    do k = 1, nodes%n
      priority(k) = 0.0_dp
      if (nodes%corner(k)) cycle
      call nearest_straight_line(lines, nodes%position(:, k), graph%rounding, line, foot)
      priority(k) = merge(1.0_dp, 2.0_dp, line > 0)
    end do
  end function priority_of

  !> Finds where pieces cross, and the node there. Crossings of two straight lines come first, and crossings with one of them
  !> before those of other lines, so that others go to them.
  subroutine cross_pieces(grid, straight, lines, settling, graph, nodes, splits, changed)
    type(cell_grid_t), intent(in) :: grid
    logical, intent(in) :: straight(:)         !! (n_lines)
    type(straight_lines_t), intent(in) :: lines
    logical, intent(in) :: settling            !! free ends will be joined to what they lie beside
    type(graph_t), intent(in) :: graph
    type(cut_nodes_t), intent(inout) :: nodes
    type(pairs_t), intent(inout) :: splits
    logical, intent(inout) :: changed(:)       !! (n_pieces) those that cross others, as one may stay as it is for now
    type(pairs_t) :: crossing(0:2) ! by how many of the two are straight
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
          if (are_crossing(p, q)) call add_pair(crossing(count(straight(graph%line([p, q])))), p, q)
        end do
      end do
    end do
    do k = 2, 0, -1
      do i = 1, crossing(k)%n
        p = crossing(k)%one(i)
        q = crossing(k)%other(i)
        changed([p, q]) = .true.
        if (straight(graph%line(q)) .and. .not. straight(graph%line(p))) then
          call meet(q, p)
        else
          call meet(p, q)
        end if
      end do
    end do

  contains

    !> Whether each of two pieces has the ends of the other on different sides.
    pure logical function are_crossing(p, q)
      integer, intent(in) :: p, q

      are_crossing = .false.
      associate (a => graph%ends(1, p), b => graph%ends(2, p), c => graph%ends(1, q), d => graph%ends(2, q))
        if (a == c .or. a == d .or. b == c .or. b == d) return
        associate (pa => nodes%position(:, a), pb => nodes%position(:, b), pc => nodes%position(:, c), pd => nodes%position(:, d))
          if (orientation(pa, pb, pc)*orientation(pa, pb, pd) >= 0) return
          are_crossing = orientation(pc, pd, pa)*orientation(pc, pd, pb) < 0
        end associate
      end associate
    end function are_crossing

    !> Splits two pieces at the node of their crossing: a node that is near, or a new one. If one of the two is straight, it is p.
    subroutine meet(p, q)
      integer, intent(in) :: p, q
      real(dp) :: position(2), onto(2)
      integer :: node
      logical :: corner

      position = crossing_of(p, q)
      corner = straight(graph%line(p)) .and. straight(graph%line(q))
      onto = position
      if (straight(graph%line(p)) .and. .not. corner) then
        node = node_at(nodes, position, graph%nearest, .false., line=nodes%position(:, graph%ends(:, p)), off=graph%rounding)
      else
        if (.not. corner) call move_onto_straight(lines, graph, onto)
        node = node_to_join(lines, graph, nodes, onto, corner, .false.)
      end if
      if (node > 0) then
        if (.not. (can_be_at(p, node) .and. can_be_at(q, node))) node = 0
      else if (may_meet(p, onto) .and. may_meet(q, onto)) then
        position = onto
      end if
      if (node == 0) node = node_at(nodes, position, 0.0_dp, .false.)
      if (node == 0) call add_node(nodes, position, corner, .false., node)
      if (may_split(graph, nodes, p, node)) call add_pair(splits, p, node)
      if (may_split(graph, nodes, q, node)) call add_pair(splits, q, node)
    end subroutine meet

    !> Whether a piece ends at a node or may meet it.
    pure logical function can_be_at(piece, node)
      integer, intent(in) :: piece, node

      can_be_at = any(graph%ends(:, piece) == node) .or. may_meet(piece, nodes%position(:, node))
    end function can_be_at

    !> Where two pieces cross, on the first of them to rounding.
    pure function crossing_of(p, q) result(position)
      integer, intent(in) :: p, q
      real(dp) :: position(2)
      real(dp) :: along, off(2), v(2)

      associate (pa => nodes%position(:, graph%ends(1, p)), pb => nodes%position(:, graph%ends(2, p)), &
                 pc => nodes%position(:, graph%ends(1, q)), pd => nodes%position(:, graph%ends(2, q)))
        v = pd - pc
        off = [v(1)*(pa(2) - pc(2)) - v(2)*(pa(1) - pc(1)), v(1)*(pb(2) - pc(2)) - v(2)*(pb(1) - pc(1))]
        position = pa + (pb - pa)*(abs(off(1))/max(abs(off(1)) + abs(off(2)), tiny(1.0_dp)))
        along = dot_product(position - pc, v)
        if (along < 0) position = pc ! where the two are parallel to rounding, any position that both pass will do
        if (along > dot_product(v, v)) position = pd
        where (.not. abs(v) > 0) position = pc ! on a line along an axis without rounding
      end associate
    end function crossing_of

    !> Whether a piece can be split at a position, or has a free end that will be joined to a node there.
    pure logical function may_meet(piece, position)
      integer, intent(in) :: piece
      real(dp), intent(in) :: position(2)
      integer :: k

      may_meet = is_between(nodes%position(:, graph%ends(1, piece)), nodes%position(:, graph%ends(2, piece)), position)
      do k = 1, 2
        associate (at => graph%ends(k, piece))
          may_meet = may_meet .or. (settling .and. nodes%free(at) .and. &
                                    norm2(nodes%position(:, at) - position) <= node_share*graph%nearest)
        end associate
      end do
    end function may_meet

  end subroutine cross_pieces

  !> Whether a node is no end of a piece, and nearer to both ends than they are to each other.
  pure logical function may_split(graph, nodes, piece, node)
    type(graph_t), intent(in) :: graph
    type(cut_nodes_t), intent(in) :: nodes
    integer, intent(in) :: piece, node

    may_split = .not. any(graph%ends(:, piece) == node)
    if (may_split) may_split = is_between(nodes%position(:, graph%ends(1, piece)), nodes%position(:, graph%ends(2, piece)), &
                                          nodes%position(:, node))
  end function may_split

  !> Whether a position is nearer to both of two others than they are to each other.
  pure logical function is_between(a, b, position)
    real(dp), intent(in) :: a(2), b(2), position(2)
    real(dp) :: length

    length = sum((b - a)**2)
    is_between = sum((position - a)**2) < length .and. sum((position - b)**2) < length
  end function is_between

  !> Joins ends that coincide with no other to a node beside them, or to another such end, or brings them onto the line
  !> beside them, in the order of their places.
  subroutine settle_free_ends(grid, lines, graph, nodes, splits, changed)
    type(cell_grid_t), intent(in) :: grid
    type(straight_lines_t), intent(in) :: lines
    type(graph_t), intent(inout) :: graph
    type(cut_nodes_t), intent(inout) :: nodes
    type(pairs_t), intent(inout) :: splits
    logical, intent(inout) :: changed(:)       !! (n_pieces) those with an end that has moved
    real(dp) :: distance, foot(2), foot_yet(2), nearest_yet
    integer :: at_end(2, nodes%n), i, k, l, node, other, piece
    integer, allocatable :: ends(:)

    at_end = 0
    do i = 1, size(graph%line)
      do k = 1, 2
        if (nodes%free(graph%ends(k, i))) at_end(:, graph%ends(k, i)) = [k, i]
      end do
    end do
    ends = in_order(nodes, pack([(l, l=1, nodes%n)], at_end(1, :) > 0), priority_of(nodes, lines, graph))
    do l = 1, size(ends)
      node = ends(l)
      if (.not. nodes%free(node) .or. at_end(1, node) == 0) cycle ! it has met one before it
      i = at_end(2, node)
      other = node_to_join(lines, graph, nodes, nodes%position(:, node), nodes%corner(node), .false.)
      if (other > 0) then
        call move_end(node, other)
        cycle
      end if
      other = node_to_join(lines, graph, nodes, nodes%position(:, node), nodes%corner(node), .true., node)
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
      call move_onto_straight(lines, graph, foot_yet)
      call add_node(nodes, foot_yet, .false., .false., other)
      call move_end(node, other)
      if (may_split(graph, nodes, piece, other)) call add_pair(splits, piece, other)
    end do

  contains

    !> Moves a free end to a node, and takes its own away.
    subroutine move_end(from, to)
      integer, intent(in) :: from, to

      graph%ends(at_end(1, from), at_end(2, from)) = to
      changed(at_end(2, from)) = .true.
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

  !> Finds nodes that lie too near to a piece.
  subroutine snap_to_nodes(grid, straight, graph, nodes, splits)
    type(cell_grid_t), intent(in) :: grid
    logical, intent(in) :: straight(:)         !! (n_lines)
    type(graph_t), intent(in) :: graph
    type(cut_nodes_t), intent(in) :: nodes
    type(pairs_t), intent(inout) :: splits
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
        if (straight(graph%line(p))) reach = graph%rounding
        call drop_perpendicular(nodes%position(:, graph%ends(1, p)), nodes%position(:, graph%ends(2, p)), nodes%position(:, node), &
                                foot, distance)
        if (distance <= reach) call add_pair(splits, p, node)
      end do
    end do
  end subroutine snap_to_nodes

  !> Splits the pieces at their nodes, in order along them, and keeps one of those that coincide.
  subroutine split_pieces(nodes, splits, graph, changed)
    type(cut_nodes_t), intent(in) :: nodes
    type(pairs_t), intent(in) :: splits
    type(graph_t), intent(inout) :: graph
    logical, allocatable, intent(inout) :: changed(:) !! (n_pieces) pieces that are others than before, in this pass
    integer :: first(size(graph%line) + 1), order(splits%n), i, k, n
    integer, allocatable :: ends(:, :), piece(:), line(:), against(:), chain(:)
    real(dp), allocatable :: along(:)

    call list_others(splits, first, order)
    allocate (ends(2, size(graph%line) + splits%n), piece(size(graph%line) + splits%n))
    n = 0
    do i = 1, size(graph%line)
      if (first(i) == first(i + 1)) then
        if (graph%ends(1, i) == graph%ends(2, i)) cycle
        n = n + 1
        ends(:, n) = graph%ends(:, i)
        piece(n) = i
        cycle
      end if
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
    changed = changed(piece(:n)) .or. first(piece(:n) + 1) > first(piece(:n))
    line = graph%line(piece(:n))
    against = graph%against(piece(:n))
    call drop_doubles(nodes%n, ends(:, :n), line, against, graph, changed)
  end subroutine split_pieces

  !> Whether a step of a chain is not shorter than the straight between its ends.
  pure logical function grows(nodes, chain)
    type(cut_nodes_t), intent(in) :: nodes
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

  !> Keeps one of the pieces between two nodes: that of the first line, with the first line in reverse direction.
  subroutine drop_doubles(n_nodes, ends, line, against, graph, changed)
    integer, intent(in) :: n_nodes, ends(:, :), line(:), against(:)
    type(graph_t), intent(inout) :: graph
    logical, allocatable, intent(inout) :: changed(:) !! (n_pieces)
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
    changed = pack(changed, keep)
  end subroutine drop_doubles

end module scree_line_cutting
