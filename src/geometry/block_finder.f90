!> Finds the block that holds a position, and the edges that a line crosses.
module scree_block_finder
  use scree_cell_grid, only: cell_grid_t, cells_of_box, number_of_cell, place_boxes, set_up_grid
  use scree_kinds, only: dp
  use scree_polygon, only: distance_to_segment, holds, nearest_on_segment
  use scree_regions, only: first_vertex_of, last_vertex_of, loops_of, region_count, regions_t
  use scree_sorting, only: sort_by
  implicit none
  private
  public :: block_at, block_finder_t, block_path_t, blocks_along, distance_outside, find_crossings, find_nearest_block, &
            set_up_finder

  !> Blocks by cell of a grid.
  type :: block_finder_t
    type(cell_grid_t) :: grid
    real(dp), allocatable :: low(:, :), high(:, :) !! (2, n_blocks) corners of the box of each block, length
    real(dp) :: beside = 0.0_dp !! a position this far outside still belongs to a block, length
  end type block_finder_t

  !> The blocks that a line goes through, one after the other.
  type :: block_path_t
    integer, allocatable :: block(:)  !! (n)
    real(dp), allocatable :: from(:)  !! (n) where it enters and leaves them, fraction of the line
    real(dp), allocatable :: to(:)
  end type block_path_t

  !> Sine of an angle between a line and an edge below which they are parallel, and fraction of an edge that is none.
  real(dp), parameter :: along = 1e-12_dp
  !> Of a line, a piece that is too short to tell in which block it lies.
  real(dp), parameter :: no_piece = 1e-9_dp

contains

  !> Lists the blocks in the cells of a grid.
  pure subroutine set_up_finder(finder, shape, vertex, beside)
    type(block_finder_t), intent(out) :: finder
    type(regions_t), intent(in) :: shape
    real(dp), intent(in) :: vertex(:, :)  !! (2, n_vertices), length
    real(dp), intent(in) :: beside        !! length
    integer :: b, k

    finder%beside = beside
    allocate (finder%low(2, region_count(shape)), finder%high(2, region_count(shape)))
    do b = 1, region_count(shape)
      associate (low => finder%low(:, b), high => finder%high(:, b))
        low = vertex(:, first_vertex_of(shape, b))
        high = low
        do k = first_vertex_of(shape, b) + 1, last_vertex_of(shape, b)
          low = min(low, vertex(:, k))
          high = max(high, vertex(:, k))
        end do
      end associate
    end do
    call set_up_grid(finder%grid, vertex, region_count(shape))
    call place_boxes(finder%grid, finder%low - beside, finder%high + beside)
  end subroutine set_up_finder

  !> First block that holds a position, its edge included, else the nearest within reach; 0 where none is.
  pure integer function block_at(finder, shape, vertex, position, group, wanted)
    type(block_finder_t), intent(in) :: finder
    type(regions_t), intent(in) :: shape
    real(dp), intent(in) :: vertex(:, :), position(2)
    integer, intent(in), optional :: group(:) !! (n_blocks) blocks count whose group is ...
    integer, intent(in), optional :: wanted   !! ... this one; all where absent
    real(dp) :: distance, nearest
    integer :: b, cell, i, range(2, 2)

    block_at = 0
    range = cells_of_box(finder%grid, position, position)
    cell = number_of_cell(finder%grid, range(1, 1), range(2, 1))
    do i = finder%grid%first(cell), finder%grid%first(cell + 1) - 1
      b = finder%grid%item(i)
      if (present(group)) then
        if (group(b) /= wanted) cycle
      end if
      if (any(position < finder%low(:, b)) .or. any(position > finder%high(:, b))) cycle
      if (holds(vertex(:, first_vertex_of(shape, b):last_vertex_of(shape, b)), position, loops_of(shape, b))) then
        block_at = b
        return
      end if
    end do
    nearest = finder%beside
    do i = finder%grid%first(cell), finder%grid%first(cell + 1) - 1
      b = finder%grid%item(i)
      if (present(group)) then
        if (group(b) /= wanted) cycle
      end if
      distance = distance_to(shape, vertex, b, position)
      if (distance > nearest .or. (block_at > 0 .and. .not. distance < nearest)) cycle
      nearest = distance
      block_at = b
    end do
  end function block_at

  !> Distance of a position from a block; 0 inside and on its edge.
  pure real(dp) function distance_outside(shape, vertex, b, position) result(distance)
    type(regions_t), intent(in) :: shape
    real(dp), intent(in) :: vertex(:, :), position(2) !! length
    integer, intent(in) :: b

    distance = 0.0_dp
    if (.not. holds(vertex(:, first_vertex_of(shape, b):last_vertex_of(shape, b)), position, loops_of(shape, b))) &
      distance = distance_to(shape, vertex, b, position)
  end function distance_outside

  !> Vertex after `k` in its loop; `loop` is the loop's number and moves on with `k`.
  pure subroutine step_round(shape, k, loop, next)
    type(regions_t), intent(in) :: shape
    integer, intent(in) :: k
    integer, intent(inout) :: loop
    integer, intent(out) :: next

    if (k == shape%first_vertex(loop + 1)) loop = loop + 1
    next = k + 1
    if (next == shape%first_vertex(loop + 1)) next = shape%first_vertex(loop)
  end subroutine step_round

  !> Distance of a position from the edges of a block.
  pure real(dp) function distance_to(shape, vertex, b, position) result(distance)
    type(regions_t), intent(in) :: shape
    real(dp), intent(in) :: vertex(:, :), position(2)
    integer, intent(in) :: b
    integer :: k, loop, next

    distance = huge(distance)
    loop = shape%first_loop(b)
    do k = first_vertex_of(shape, b), last_vertex_of(shape, b)
      call step_round(shape, k, loop, next)
      distance = min(distance, distance_to_segment(position, vertex(:, k), vertex(:, next)))
    end do
  end function distance_to

  !> The block whose outline is nearest to a position outside all blocks, and the nearest place on that outline.
  pure subroutine find_nearest_block(shape, vertex, position, block, place)
    type(regions_t), intent(in) :: shape
    real(dp), intent(in) :: vertex(:, :), position(2)     !! length
    integer, intent(out) :: block
    real(dp), intent(out) :: place(2)                     !! length
    real(dp) :: another(2)
    integer :: b, k, loop, next

    block = 0
    do b = 1, region_count(shape)
      loop = shape%first_loop(b)
      do k = first_vertex_of(shape, b), last_vertex_of(shape, b)
        call step_round(shape, k, loop, next)
        another = nearest_on_segment(position, vertex(:, k), vertex(:, next))
        if (block > 0) then
          if (.not. norm2(another - position) < norm2(place - position)) cycle
        end if
        place = another
        block = b
      end do
    end do
  end subroutine find_nearest_block

  !> Where a line crosses the edges that it is not parallel to, block after block, with the unit normal inwards there. Through a
  !> corner it crosses once, and so at each of the two where it runs along an edge.
  pure subroutine find_crossings(finder, shape, vertex, ends, at, block)
    type(block_finder_t), intent(in) :: finder
    type(regions_t), intent(in) :: shape
    real(dp), intent(in) :: vertex(:, :)
    real(dp), intent(in) :: ends(2, 2)                    !! (xy, end) of the line, length
    real(dp), allocatable, intent(out) :: at(:, :)        !! (4, n) x, y, normal
    integer, allocatable, intent(out) :: block(:)         !! (n)
    integer, allocatable :: near(:)
    real(dp) :: p(2), edge(2), way(2), det, s, t
    integer :: b, i, first, k, last, loop, n, next

    near = blocks_near(finder, minval(ends, 2), maxval(ends, 2))
    n = sum([(last_vertex_of(shape, near(i)) - first_vertex_of(shape, near(i)) + 1, i=1, size(near))])
    allocate (at(4, n), block(n))
    n = 0
    way = ends(:, 2) - ends(:, 1)
    do i = 1, size(near)
      b = near(i)
      loop = shape%first_loop(b)
      do k = first_vertex_of(shape, b), last_vertex_of(shape, b)
        call step_round(shape, k, loop, next)
        p = vertex(:, k) - ends(:, 1)
        edge = vertex(:, next) - vertex(:, k)
        det = way(1)*edge(2) - way(2)*edge(1)
        if (runs_along(k, next)) cycle
        t = (p(1)*edge(2) - p(2)*edge(1))/det
        s = (p(1)*way(2) - p(2)*way(1))/det
        if (t < 0 .or. t > 1) cycle
        first = shape%first_vertex(loop)
        last = shape%first_vertex(loop + 1) - 1
        if (s < merge(-along, 0.0_dp, runs_along(merge(last, k - 1, k == first), k))) cycle
        if (runs_along(next, merge(first, next + 1, next == last))) then
          if (s > 1 + along) cycle
        else if (s >= 1) then
          cycle ! the next edge begins there
        end if
        n = n + 1
        at(:, n) = [ends(:, 1) + t*way, [-edge(2), edge(1)]/norm2(edge)]
        block(n) = b
      end do
    end do
    at = at(:, :n)
    block = block(:n)

  contains

    !> Whether the line is parallel to the edge from one vertex to another.
    pure logical function runs_along(from, to)
      integer, intent(in) :: from, to

      associate (beside => vertex(:, to) - vertex(:, from))
        runs_along = abs(way(1)*beside(2) - way(2)*beside(1)) <= along*norm2(way)*norm2(beside)
      end associate
    end function runs_along

  end subroutine find_crossings

  !> The blocks that a line goes through, in their order along it; pieces outside all blocks are left out.
  pure type(block_path_t) function blocks_along(finder, shape, vertex, ends) result(path)
    type(block_finder_t), intent(in) :: finder
    type(regions_t), intent(in) :: shape
    real(dp), intent(in) :: vertex(:, :)
    real(dp), intent(in) :: ends(2, 2)   !! (xy, end) of the line, length
    real(dp), allocatable :: at(:, :), share(:)
    integer, allocatable :: block(:)
    real(dp) :: last, way(2)
    integer :: i, n, now

    call find_crossings(finder, shape, vertex, ends, at, block)
    way = ends(:, 2) - ends(:, 1)
    share = [matmul(way, at(1:2, :) - spread(ends(:, 1), 2, size(block)))/dot_product(way, way), 1.0_dp]
    block = [block, 0]
    call sort_by(share, block)
    allocate (path%block(size(share)), path%from(size(share)), path%to(size(share)))
    last = 0.0_dp
    n = 0
    do i = 1, size(share)
      if (share(i) - last < no_piece) cycle
      now = block_at(finder, shape, vertex, ends(:, 1) + 0.5_dp*(last + share(i))*way)
      if (now > 0) then
        if (n == 0) then
          n = 1
          path%from(n) = last
        else if (path%block(n) /= now .or. path%to(n) < last) then
          n = n + 1
          path%from(n) = last
        end if
        path%block(n) = now
        path%to(n) = share(i)
      end if
      last = share(i)
    end do
    path%block = path%block(:n)
    path%from = path%from(:n)
    path%to = path%to(:n)
  end function blocks_along

  !> Blocks in the cells that a box touches, each once, ascending.
  pure function blocks_near(finder, low, high) result(near)
    type(block_finder_t), intent(in) :: finder
    real(dp), intent(in) :: low(2), high(2)  !! length
    integer, allocatable :: near(:)
    real(dp), allocatable :: key(:)
    integer :: cell, column, k, n, pass, range(2, 2), row

    range = cells_of_box(finder%grid, low, high)
    do pass = 1, 2 ! count, then list
      n = 0
      do row = range(2, 1), range(2, 2)
        do column = range(1, 1), range(1, 2)
          cell = number_of_cell(finder%grid, column, row)
          associate (item => finder%grid%item(finder%grid%first(cell):finder%grid%first(cell + 1) - 1))
            if (pass == 2) near(n + 1:n + size(item)) = item
            n = n + size(item)
          end associate
        end do
      end do
      if (pass == 1) allocate (near(n))
    end do
    key = near
    call sort_by(key, near)
    near = pack(near, [(k == 1 .or. near(max(k - 1, 1)) < near(k), k=1, n)])
  end function blocks_near

end module scree_block_finder
