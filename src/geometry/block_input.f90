!> Lines or given polygons to blocks, with their materials and points.
!>
!> The rules are those of Shi's dc as the derivative ntdda has them (doc/decks.md).
module scree_block_input
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_kinds, only: dp
  use scree_loop_tracing, only: trace_loops
  use scree_regions, only: first_vertex_of, last_vertex_of, regions_t
  use scree_scene, only: line_t, point_t, scene_t
  use scree_simplex_integration, only: moments_t, polygon_moments
  use scree_system, only: fixed_point, load_point, measured_point
  use scree_text, only: number_text
  implicit none
  private
  public :: blocks_t, make_blocks

  !> A fixed point lies this share of the size inside the edge that its line crosses.
  real(dp), parameter :: inwards = 0.005_dp

  !> What the geometry made of a scene, in the coordinates of its decks.
  type :: blocks_t
    type(regions_t) :: shape
    real(dp), allocatable :: vertex(:, :)      !! (2, n_vertices), length
    integer, allocatable :: material(:)        !! (n_blocks)
    integer, allocatable :: point_kind(:)      !! (n_points) fixed, load, measured: in this order
    real(dp), allocatable :: point(:, :)       !! (2, n_points), length
    integer, allocatable :: point_block(:)     !! (n_points) block that carries it
  end type blocks_t

contains

  !> Makes the blocks of a scene whose geometry has been read.
  !>
  !> Errors, with the line of the deck: lines that enclose nothing or are more than closed loops, points and material
  !> lines outside every block.
  subroutine make_blocks(scene, blocks, error)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(out) :: blocks
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: scale
    integer :: i

    allocate (blocks%point_kind(0), blocks%point(2, 0), blocks%point_block(0))
    if (allocated(scene%blocks)) then
      call take_polygons(scene, blocks, error)
      if (allocated(error)) return
      do i = 1, size(scene%fixed_points)
        call add_point(blocks, fixed_point, scene%fixed_points(i)%place, scene%fixed_points(i)%block)
      end do
    else
      scale = deck_scale(scene%lines)
      call trace_loops(scene%geometry_name, scene%lines, scene%least_distance*scale, blocks%shape, blocks%vertex, error)
      if (allocated(error)) return
      call refuse_nesting(scene, blocks, error)
      if (allocated(error)) return
      call name_materials(scene, blocks, error)
      if (allocated(error)) return
      do i = 1, size(scene%hole_points)
        call remove_block(scene, scene%hole_points(i), blocks, error)
        if (allocated(error)) return
      end do
      do i = 1, size(scene%fixed_lines)
        call fix_line(scene, scene%fixed_lines(i), inwards*scale, blocks, error)
        if (allocated(error)) return
      end do
    end if
    call add_points(scene, load_point, 'load', scene%load_points, blocks, error)
    if (allocated(error)) return
    call add_points(scene, measured_point, 'measured', scene%measured_points, blocks, error)
  end subroutine make_blocks

  !> Scale of Shi's cutter (w0): half the height, or half the width over 1.3, and 2 % more; length.
  pure real(dp) function deck_scale(lines)
    type(line_t), intent(in) :: lines(:)
    real(dp) :: low(2), high(2)
    integer :: i

    low = huge(low)
    high = -huge(high)
    do i = 1, size(lines)
      low = min(low, minval(lines(i)%ends, 2))
      high = max(high, maxval(lines(i)%ends, 2))
    end do
    deck_scale = 1.02_dp*max((high(2) - low(2))/2, (high(1) - low(1))/2/1.3_dp)
  end function deck_scale

  !> Polygons of a block file as blocks. Errors: one that is not counter-clockwise or has no area.
  subroutine take_polygons(scene, blocks, error)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(inout) :: blocks
    type(error_t), allocatable, intent(out) :: error
    type(moments_t) :: moments
    integer :: i

    associate (given => scene%blocks)
      blocks%shape%first_vertex = given%first_vertex
      blocks%shape%first_loop = [(i, i=1, size(given%first_vertex))]
      blocks%shape%joint = given%joint
      blocks%vertex = given%vertex
      blocks%material = given%material
      do i = 1, size(given%material)
        associate (polygon => given%vertex(:, given%first_vertex(i):given%first_vertex(i + 1) - 1))
          moments = polygon_moments(polygon, [1, size(polygon, 2) + 1])
          if (moments%area > 1e-12_dp*maxval(maxval(polygon, 2) - minval(polygon, 2))**2) cycle
        end associate
        call wrong(scene, given%deck_line(i), 'vertices counter-clockwise around an area', 'block '//number_text(i)// &
                   ' without or the other way round', error)
        return
      end do
    end associate
  end subroutine take_polygons

  !> Error where a loop lies inside another: blocks with holes need the cutting of lines.
  subroutine refuse_nesting(scene, blocks, error)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(error_t), allocatable, intent(out) :: error
    real(dp), dimension(2, size(blocks%shape%first_loop) - 1) :: low, high
    integer :: i, k

    do i = 1, size(low, 2)
      low(:, i) = minval(block_polygon(blocks, i), 2)
      high(:, i) = maxval(block_polygon(blocks, i), 2)
    end do
    do i = 1, size(low, 2)
      associate (corner => blocks%vertex(:, first_vertex_of(blocks%shape, i)))
        do k = 1, size(low, 2)
          if (corner(1) < low(1, k) .or. corner(1) > high(1, k) .or. corner(2) < low(2, k) .or. corner(2) > high(2, k) &
              .or. k == i) cycle
          if (.not. holds(block_polygon(blocks, k), corner)) cycle
          call wrong(scene, scene%lines(1)%deck_line, 'closed loops side by side', 'one inside another', error)
          return
        end do
      end associate
    end do
  end subroutine refuse_nesting

  !> Gives each block the material of the last line that crosses it, or whose first end lies in it; else 1.
  subroutine name_materials(scene, blocks, error)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(inout) :: blocks
    type(error_t), allocatable, intent(out) :: error
    integer :: b, i
    logical :: found

    allocate (blocks%material(size(blocks%shape%first_loop) - 1), source=1)
    do i = 1, size(scene%material_lines)
      associate (line => scene%material_lines(i))
        found = .false.
        do b = 1, size(blocks%material)
          if (size(crossings(blocks, b, line%ends), 2) == 0) cycle
          blocks%material(b) = line%material
          found = .true.
        end do
        if (found) cycle
        b = block_at(blocks, line%ends(:, 1))
        if (b == 0) then
          call wrong(scene, line%deck_line, 'a material line that crosses a block or begins in one', 'one outside', error)
          return
        end if
        blocks%material(b) = line%material
      end associate
    end do
  end subroutine name_materials

  !> Removes the block at a hole point.
  subroutine remove_block(scene, hole, blocks, error)
    type(scene_t), intent(in) :: scene
    type(point_t), intent(in) :: hole
    type(blocks_t), intent(inout) :: blocks
    type(error_t), allocatable, intent(out) :: error
    integer :: b, first, i, last, n

    b = block_at(blocks, hole%place)
    if (b == 0) then
      call wrong(scene, hole%deck_line, 'a hole point inside a block', 'one outside', error)
      return
    end if
    n = size(blocks%material)
    if (n == 1) then
      call wrong(scene, hole%deck_line, 'a block left after the holes', 'none', error)
      return
    end if
    first = first_vertex_of(blocks%shape, b)
    last = last_vertex_of(blocks%shape, b)
    blocks%vertex = blocks%vertex(:, [(i, i=1, first - 1), (i, i=last + 1, size(blocks%vertex, 2))])
    blocks%shape%joint = [blocks%shape%joint(:first - 1), blocks%shape%joint(last + 1:)]
    blocks%shape%first_vertex = [blocks%shape%first_vertex(:b), blocks%shape%first_vertex(b + 2:) - (last - first + 1)]
    blocks%shape%first_loop = blocks%shape%first_loop(:n)
    blocks%material = [blocks%material(:b - 1), blocks%material(b + 1:)]
  end subroutine remove_block

  !> A fixed point at each crossing with the edge of a block, moved inwards; at the first end where there is none.
  subroutine fix_line(scene, line, depth, blocks, error)
    type(scene_t), intent(in) :: scene
    type(line_t), intent(in) :: line
    real(dp), intent(in) :: depth !! length
    type(blocks_t), intent(inout) :: blocks
    type(error_t), allocatable, intent(out) :: error
    real(dp), allocatable :: at(:, :)
    integer :: b, i
    logical :: found

    found = .false.
    do b = 1, size(blocks%material)
      at = crossings(blocks, b, line%ends)
      do i = 1, size(at, 2)
        call add_point(blocks, fixed_point, at(1:2, i) + depth*at(3:4, i), b)
        found = .true.
      end do
    end do
    if (found) return
    b = block_at(blocks, line%ends(:, 1))
    if (b == 0) then
      call wrong(scene, line%deck_line, 'a fixed line that crosses a block, or a fixed point in one', 'one outside', error)
      return
    end if
    call add_point(blocks, fixed_point, line%ends(:, 1), b)
  end subroutine fix_line

  !> Adds points to the blocks that hold them.
  subroutine add_points(scene, kind, what, points, blocks, error)
    type(scene_t), intent(in) :: scene
    integer, intent(in) :: kind
    character(len=*), intent(in) :: what
    type(point_t), intent(in) :: points(:)
    type(blocks_t), intent(inout) :: blocks
    type(error_t), allocatable, intent(out) :: error
    integer :: b, i

    do i = 1, size(points)
      b = points(i)%block
      if (b == 0) b = block_at(blocks, points(i)%place)
      if (b == 0) then
        call wrong(scene, points(i)%deck_line, 'a '//what//' point inside a block', 'one outside', error)
        return
      end if
      call add_point(blocks, kind, points(i)%place, b)
    end do
  end subroutine add_points

  !> Adds one point.
  pure subroutine add_point(blocks, kind, place, block)
    type(blocks_t), intent(inout) :: blocks
    integer, intent(in) :: kind, block
    real(dp), intent(in) :: place(2)

    blocks%point = reshape([blocks%point, place], [2, size(blocks%point_kind) + 1])
    blocks%point_kind = [blocks%point_kind, kind]
    blocks%point_block = [blocks%point_block, block]
  end subroutine add_point

  !> Where a line crosses the edges of a block that it is not parallel to, and the unit normal inwards there.
  pure function crossings(blocks, b, ends) result(at)
    type(blocks_t), intent(in) :: blocks
    integer, intent(in) :: b
    real(dp), intent(in) :: ends(2, 2)
    real(dp), allocatable :: at(:, :)  !! (4, n) x, y, normal
    real(dp) :: p(2), edge(2), way(2), det, s, t
    integer :: k, next

    allocate (at(4, 0))
    way = ends(:, 2) - ends(:, 1)
    do k = first_vertex_of(blocks%shape, b), last_vertex_of(blocks%shape, b)
      next = k + 1
      if (k == last_vertex_of(blocks%shape, b)) next = first_vertex_of(blocks%shape, b)
      p = blocks%vertex(:, k) - ends(:, 1)
      edge = blocks%vertex(:, next) - blocks%vertex(:, k)
      det = way(1)*edge(2) - way(2)*edge(1)
      if (abs(det) <= 1e-12_dp*norm2(way)*norm2(edge)) cycle
      t = (p(1)*edge(2) - p(2)*edge(1))/det
      s = (p(1)*way(2) - p(2)*way(1))/det
      if (t < 0 .or. t > 1 .or. s < 0 .or. s >= 1) cycle
      at = reshape([at, ends(:, 1) + t*way, [-edge(2), edge(1)]/norm2(edge)], [4, size(at, 2) + 1])
    end do
  end function crossings

  !> First block that holds a place, its edge included; 0 where none does.
  pure integer function block_at(blocks, place)
    type(blocks_t), intent(in) :: blocks
    real(dp), intent(in) :: place(2)

    do block_at = 1, size(blocks%shape%first_loop) - 1
      if (holds(block_polygon(blocks, block_at), place)) return
    end do
    block_at = 0
  end function block_at

  !> Vertices of a block.
  pure function block_polygon(blocks, b) result(polygon)
    type(blocks_t), intent(in) :: blocks
    integer, intent(in) :: b
    real(dp), allocatable :: polygon(:, :)

    polygon = blocks%vertex(:, first_vertex_of(blocks%shape, b):last_vertex_of(blocks%shape, b))
  end function block_polygon

  !> Whether a polygon holds a place: a ray to the right crosses its edges an odd number of times.
  pure logical function holds(polygon, place)
    real(dp), intent(in) :: polygon(:, :) !! (2, n)
    real(dp), intent(in) :: place(2)
    real(dp) :: a(2), b(2), area
    integer :: k, n

    n = size(polygon, 2)
    holds = .false.
    do k = 1, n
      a = polygon(:, k) - place
      b = polygon(:, modulo(k, n) + 1) - place
      area = a(1)*b(2) - a(2)*b(1)
      if (abs(area) <= 4*epsilon(area)*(abs(a(1)*b(2)) + abs(a(2)*b(1))) .and. dot_product(a, b) <= 0.0_dp) then
        holds = .true. ! on the edge
        return
      end if
      if ((a(2) > 0.0_dp) .eqv. (b(2) > 0.0_dp)) cycle
      if ((area > 0.0_dp) .eqv. (b(2) > a(2))) holds = .not. holds
    end do
  end function holds

  !> Error at a line of the geometry.
  subroutine wrong(scene, line, expected, found, error)
    type(scene_t), intent(in) :: scene
    integer, intent(in) :: line
    character(len=*), intent(in) :: expected, found
    type(error_t), allocatable, intent(out) :: error

    call fail(error, status_bad_input, scene%geometry_name//':'//number_text(line)//': expected '//expected//', found '//found)
  end subroutine wrong

end module scree_block_input
