!> The nodes of a cut, listed by cell, so that the node next to a position is found at once.
module scree_cut_nodes
  use scree_cell_grid, only: cell_grid_t, cells_of_box, number_of_cell
  use scree_kinds, only: dp
  use scree_sorting, only: sort_by
  implicit none
  private
  public :: add_node, cut_nodes_t, in_order, make_room, node_at, unlist_node

  !> Two nodes that are nearer than this multiple of e are one.
  real(dp), parameter, public :: node_share = 1.25_dp

  !> Nodes, and the last one of each cell.
  type :: cut_nodes_t
    type(cell_grid_t) :: grid
    integer, allocatable :: head(:)        !! (n_cells) last node of a cell
    integer, allocatable :: before(:)      !! (n) node before it in its cell
    real(dp), allocatable :: position(:, :)   !! (2, n), length
    logical, allocatable :: corner(:)      !! (n) made by straight lines alone: one of their ends or crossings
    logical, allocatable :: free(:)        !! (n) end of one line that touches nothing
    integer :: n = 0
  end type cut_nodes_t

contains

  !> Makes empty lists for a number of nodes, which may grow.
  pure subroutine make_room(nodes, n)
    type(cut_nodes_t), intent(inout) :: nodes
    integer, intent(in) :: n

    allocate (nodes%head(nodes%grid%n(1)*nodes%grid%n(2)), source=0)
    allocate (nodes%position(2, n), nodes%before(n), nodes%corner(n), nodes%free(n))
  end subroutine make_room

  !> Adds a node.
  pure subroutine add_node(nodes, position, corner, free, node)
    type(cut_nodes_t), intent(inout) :: nodes
    real(dp), intent(in) :: position(2)     !! length
    logical, intent(in) :: corner, free
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
      flag(:n) = nodes%corner
      nodes%corner = flag
      flag(:n) = nodes%free
      call move_alloc(flag, nodes%free)
    end if
    node = n + 1
    nodes%n = node
    nodes%position(:, node) = position
    nodes%corner(node) = corner
    nodes%free(node) = free
    call list_node(nodes, node)
  end subroutine add_node

  !> Puts a node into its cell.
  pure subroutine list_node(nodes, node)
    type(cut_nodes_t), intent(inout) :: nodes
    integer, intent(in) :: node
    integer :: cell, range(2, 2)

    range = cells_of_box(nodes%grid, nodes%position(:, node), nodes%position(:, node))
    cell = number_of_cell(nodes%grid, range(1, 1), range(2, 1))
    nodes%before(node) = nodes%head(cell)
    nodes%head(cell) = node
  end subroutine list_node

  !> Removes a node from its cell.
  pure subroutine unlist_node(nodes, node)
    type(cut_nodes_t), intent(inout) :: nodes
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

  !> The nearest node within 1.25 e of a position, 0 where there is none. With `line`, only nodes on that line count.
  pure integer function node_at(nodes, position, nearest, with_free, but, line, off)
    type(cut_nodes_t), intent(in) :: nodes
    real(dp), intent(in) :: position(2)      !! length
    real(dp), intent(in) :: nearest          !! e, length
    logical, intent(in) :: with_free         !! free ends count
    integer, intent(in), optional :: but     !! a node that does not count
    real(dp), intent(in), optional :: line(2, 2) !! (xy, end), length
    real(dp), intent(in), optional :: off    !! distance from the line at which a node is on it, length
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
            if (is_on_line(nodes%position(:, k))) then
              node_at = k
              nearest_yet = distance
            end if
          end if
          k = nodes%before(k)
        end do
      end do
    end do

  contains

    !> Whether a place is on the line, or there is no line.
    pure logical function is_on_line(place)
      real(dp), intent(in) :: place(2)

      is_on_line = .true.
      if (.not. present(line)) return
      associate (a => line(:, 1), v => line(:, 2) - line(:, 1))
        is_on_line = abs(v(1)*(place(2) - a(2)) - v(2)*(place(1) - a(1))) <= off*norm2(v)
      end associate
    end function is_on_line

  end function node_at

  !> Nodes in the order of a first key, then from left to right, then upwards.
  pure function in_order(nodes, list, key) result(sorted)
    type(cut_nodes_t), intent(in) :: nodes
    integer, intent(in) :: list(:)
    real(dp), intent(in) :: key(:)          !! (n) of all nodes
    integer :: sorted(size(list))
    real(dp) :: own(size(list))

    sorted = list
    own = nodes%position(2, sorted)
    call sort_by(own, sorted)
    own = nodes%position(1, sorted)
    call sort_by(own, sorted)
    own = key(sorted)
    call sort_by(own, sorted)
  end function in_order

end module scree_cut_nodes
