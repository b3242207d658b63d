!> Lines or given polygons to blocks, with their materials and points (Shi's dc10 to dc17).
!>
!> The rules are those of Shi's dc as the derivative ntdda has them (doc/decks.md).
module scree_block_input
  use scree_block_finder, only: block_at, block_finder_t, distance_outside, find_crossings, set_up_finder
  use scree_bolt_ends, only: carried_bolts_t, carry_bolts
  use scree_boundary_rock, only: boundary_t, is_air, lone_ends, outside_text
  use scree_carried_points, only: add_point, check_inside, found_points_t, near_blocks, region_size
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_given_blocks, only: take_polygons
  use scree_kinds, only: dp
  use scree_line_cutting, only: cut_lines, graph_t
  use scree_loop_tracing, only: trace_regions
  use scree_polygon, only: twice_area
  use scree_regions, only: first_vertex_of, keep_regions, last_vertex_of, loops_of, region_count, regions_t
  use scree_scene, only: line_t, point_t, scene_t
  use scree_simplex_integration, only: moments_t, polygon_moments
  use scree_small_regions, only: join_small_regions
  use scree_system, only: fixed_point, load_point, measured_point
  use scree_text, only: number_text, real_text
  implicit none
  private
  public :: block_area, block_moments, block_size, block_source, blocks_t, joined_text, make_blocks, scale_of_lines

  !> A fixed point lies this fraction of the scale inside the edge that its line crosses.
  real(dp), parameter :: inwards = 0.005_dp
  !> The origin of blocks is not 0 where they are this many times their extent away from it.
  real(dp), parameter :: far_away = 4.0_dp

  !> Blocks of a scene with their points and bolts.
  !>
  !> Places count from `origin`, which is 0 unless the deck's coordinates are large against its extent: differences of
  !> such coordinates are exact, sums are not.
  type, extends(carried_bolts_t) :: blocks_t
    type(regions_t) :: shape
    real(dp) :: origin(2) = 0.0_dp             !! length
    real(dp) :: nearest = 0.0_dp               !! e of the cut: what is nearer is one; 0 where blocks are given, length
    real(dp), allocatable :: vertex(:, :)      !! (2, n_vertices), length
    integer :: n_joined = 0                    !! that were too small and joined a neighbour
    type(boundary_t) :: boundary
    integer, allocatable :: material(:)        !! (n_blocks)
    integer, allocatable :: drawn(:)           !! (n_blocks) block of the decks that it is, or that it has broken off
    integer, allocatable :: line(:)            !! (n_blocks) of the block file, where the outline begins; 0: cut from lines
    integer, allocatable :: point_kind(:)      !! (n_points) fixed, load, measured, ends of bolts: in this order
    real(dp), allocatable :: point(:, :)       !! (2, n_points), length
    integer, allocatable :: point_block(:)     !! (n_points) block that carries it
    integer, allocatable :: points_of_line(:)  !! (n_fixed_lines) fixed points that each fixed line made: the first of the points
    real(dp), allocatable :: crack(:, :, :)    !! (xy, end, n) pieces of joints that end inside blocks, length
    integer, allocatable :: crack_joint(:)     !! (n) their joint materials
    integer :: n_grown = 0                     !! pieces by which they have grown
    real(dp), allocatable :: seat(:, :)        !! (2, n) places of nodes of the mesh at tips, length; not allocated: none
  end type blocks_t

contains

  !> Makes the blocks of a scene whose geometry has been read.
  !>
  !> Errors, with the line of the deck: lines that enclose nothing, points and material lines outside every block, bolts without an
  !> end in one, grouted ones that cross no joint.
  subroutine make_blocks(scene, blocks, error)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(out) :: blocks
    type(error_t), allocatable, intent(out) :: error

    call find_blocks(scene, blocks, error)
    if (allocated(error) .and. blocks%boundary%n_outside > 0) &
      error%message = error%message//' (the boundary lines enclose the rock: '//outside_text(blocks%boundary)//')'
  end subroutine make_blocks

  !> Does what `make_blocks` says.
  subroutine find_blocks(scene, blocks, error)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(inout) :: blocks
    type(error_t), allocatable, intent(out) :: error
    type(block_finder_t) :: finder
    type(found_points_t) :: points
    real(dp) :: scale
    integer :: before, i

    allocate (points%kind(64), points%block(64), points%position(2, 64))
    if (allocated(scene%blocks)) then
      call enter_polygons(scene, blocks, error)
      if (allocated(error)) return
      allocate (blocks%points_of_line(0))
      scale = deck_scale(minval(blocks%vertex, 2), maxval(blocks%vertex, 2))
      call set_up_finder(finder, blocks%shape, blocks%vertex, near_blocks*scale)
      call add_points(scene, fixed_point, 'fixed', scene%fixed_points, finder, blocks, points, error)
      if (allocated(error)) return
    else
      call enclose_blocks(scene, blocks, scale, error)
      if (allocated(error)) return
      call set_up_finder(finder, blocks%shape, blocks%vertex, near_blocks*scale)
      call name_materials(scene, finder, blocks, error)
      if (allocated(error)) return
      if (size(scene%hole_points) > 0) then
        call remove_blocks(scene, finder, blocks, error)
        if (allocated(error)) return
        call set_up_finder(finder, blocks%shape, blocks%vertex, near_blocks*scale)
      end if
      allocate (blocks%points_of_line(size(scene%fixed_lines)))
      do i = 1, size(scene%fixed_lines)
        before = points%n
        call fix_line(scene, scene%fixed_lines(i), inwards*scale, finder, blocks, points, error)
        if (allocated(error)) return
        blocks%points_of_line(i) = points%n - before
      end do
    end if
    call add_points(scene, load_point, 'load', scene%load_points, finder, blocks, points, error)
    if (allocated(error)) return
    call add_points(scene, measured_point, 'measured', scene%measured_points, finder, blocks, points, error)
    if (allocated(error)) return
    call carry_bolts(scene%bolts, finder, blocks%shape, blocks%vertex, blocks%origin, points, blocks%carried_bolts_t, error)
    blocks%point_kind = points%kind(:points%n)
    blocks%point_block = points%block(:points%n)
    blocks%point = points%position(:, :points%n)
    blocks%drawn = [(i, i=1, size(blocks%material))]
  end subroutine find_blocks

  !> Area, centroid and second moments of a block; the centroid from the origin of the blocks.
  pure function block_moments(blocks, b) result(moments)
    type(blocks_t), intent(in) :: blocks
    integer, intent(in) :: b
    type(moments_t) :: moments

    moments = polygon_moments(blocks%vertex(:, first_vertex_of(blocks%shape, b):last_vertex_of(blocks%shape, b)), &
                              loops_of(blocks%shape, b))
  end function block_moments

  !> Area of a block whose vertices are at other positions, length^2.
  pure real(dp) function block_area(blocks, vertex, b)
    type(blocks_t), intent(in) :: blocks
    real(dp), intent(in) :: vertex(:, :) !! (2, n_vertices), length
    integer, intent(in) :: b
    integer :: loop

    block_area = 0.0_dp
    associate (shape => blocks%shape)
      do loop = shape%first_loop(b), shape%first_loop(b + 1) - 1
        block_area = block_area + 0.5_dp*twice_area(vertex(:, shape%first_vertex(loop):shape%first_vertex(loop + 1) - 1))
      end do
    end associate
  end function block_area

  !> Where a block comes from, for an error: the geometry, with the line of a block file.
  pure function block_source(scene, blocks, b) result(source)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    integer, intent(in) :: b
    character(len=:), allocatable :: source

    source = scene%geometry_name
    if (blocks%line(b) > 0) source = source//':'//number_text(blocks%line(b))
  end function block_source

  !> How many blocks joined a neighbour, in words.
  pure function joined_text(blocks, scene) result(text)
    type(blocks_t), intent(in) :: blocks
    type(scene_t), intent(in) :: scene
    character(len=:), allocatable :: text

    text = number_text(blocks%n_joined)//' blocks smaller than '//real_text(scene%settings%least_block_area)// &
           ' joined their neighbours'
  end function joined_text

  !> Scale of lines for the distances of the cutter; length.
  pure real(dp) function scale_of_lines(lines)
    type(line_t), intent(in) :: lines(:)
    real(dp) :: low(2), high(2)
    integer :: i

    low = huge(low)
    high = -huge(high)
    do i = 1, size(lines)
      low = min(low, minval(lines(i)%ends, 2))
      high = max(high, maxval(lines(i)%ends, 2))
    end do
    scale_of_lines = deck_scale(low, high)
  end function scale_of_lines

  !> Scale of Shi's cutter (w0): half the height, or half the width over 1.3, and 2 % more; length.
  pure real(dp) function deck_scale(low, high)
    real(dp), intent(in) :: low(2), high(2) !! corners of the box around all lines, length

    deck_scale = 1.02_dp*max((high(2) - low(2))/2, (high(1) - low(1))/2/1.3_dp)
  end function deck_scale

  !> Where places are to count from: 0, or a corner of a box that is far away from it.
  pure function origin_for(low, high) result(origin)
    real(dp), intent(in) :: low(2), high(2) !! length
    real(dp) :: origin(2)

    origin = merge(low, 0.0_dp, max(abs(low), abs(high)) > far_away*maxval(high - low))
  end function origin_for

  !> Cuts the lines and keeps what they enclose. Errors: nothing.
  subroutine enclose_blocks(scene, blocks, scale, error)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(inout) :: blocks
    real(dp), intent(out) :: scale
    type(error_t), allocatable, intent(out) :: error
    type(graph_t) :: graph
    real(dp) :: ends(2, 2, size(scene%lines)), low(2), high(2)
    integer, allocatable :: beside(:, :), crack(:)
    logical, allocatable :: straight(:)
    integer :: i

    do i = 1, size(scene%lines)
      ends(:, :, i) = scene%lines(i)%ends
    end do
    low = minval(minval(ends, 3), 2)
    high = maxval(maxval(ends, 3), 2)
    blocks%origin = origin_for(low, high)
    do i = 1, 2
      ends(:, i, :) = ends(:, i, :) - spread(blocks%origin, 2, size(ends, 3))
    end do
    scale = scale_of_lines(scene%lines)
    if (.not. scale > 0) then
      call wrong(scene, scene%lines(1)%deck_line, 'lines that enclose a block', 'lines without length', error)
      return
    end if
    blocks%nearest = scene%least_distance*scale
    straight = [(stays_straight(scene, i, blocks%nearest), i=1, size(scene%lines))]
    call cut_lines(ends, straight, blocks%nearest, graph, error)
    if (allocated(error)) return
    call trace_blocks(scene, graph, blocks, beside)
    if (region_count(blocks%shape) == 0) then
      call wrong(scene, scene%lines(1)%deck_line, 'lines that enclose a block', number_text(size(scene%lines))// &
                 ' lines that enclose nothing', error)
      return
    end if
    if (scene%n_boundary > 0) call leave_out_air(scene, scale, graph, blocks, beside)
    if (scene%settings%least_block_area > 0) call join_small_blocks(scene, scale, straight, graph, blocks, beside)
    crack = pack([(i, i=1, size(graph%line))], beside(1, :) == beside(2, :) .and. beside(1, :) > 0)
    allocate (blocks%crack(2, 2, size(crack)))
    do i = 1, size(crack)
      blocks%crack(:, :, i) = graph%position(:, graph%ends(:, crack(i)))
    end do
    blocks%crack_joint = scene%lines(graph%line(crack))%material
  end subroutine enclose_blocks

  !> Traces the regions that the pieces of a graph enclose as blocks.
  subroutine trace_blocks(scene, graph, blocks, beside)
    type(scene_t), intent(in) :: scene
    type(graph_t), intent(in) :: graph
    type(blocks_t), intent(inout) :: blocks
    integer, allocatable, intent(out) :: beside(:, :) !! (2, n_pieces) block left and right of each piece, 0: none
    integer, allocatable :: line(:)

    call trace_regions(graph, spread(scene%lines(graph%line)%material, 1, 2), blocks%shape, blocks%vertex, line, beside)
  end subroutine trace_blocks

  !> Leaves out the regions outside of the boundary lines, and the pieces of joints there.
  !>
  !> Where the boundary lines enclose nothing but the regions of hole points, as around a tunnel alone, they enclose no rock: then
  !> every region is a block.
  subroutine leave_out_air(scene, scale, graph, blocks, beside)
    type(scene_t), intent(in) :: scene
    real(dp), intent(in) :: scale
    type(graph_t), intent(inout) :: graph
    type(blocks_t), intent(inout) :: blocks
    integer, allocatable, intent(inout) :: beside(:, :) !! (2, n_pieces) block left and right of each piece, 0: none
    type(moments_t) :: moments(region_count(blocks%shape))
    logical :: air(0:size(moments)), rock(size(moments))
    integer, allocatable :: at_hole(:), kept(:)
    integer :: b, i, number(0:size(moments)) !! of each region as a block

    air = [.true., is_air(size(moments), scene%n_boundary, beside, graph)]
    if (.not. any(air(1:))) return
    at_hole = blocks_at_holes(scene, scale, blocks)
    rock = .not. air(1:)
    rock(pack(at_hole, at_hole > 0)) = .false.
    blocks%boundary%scale = scale
    blocks%boundary%encloses = any(rock)
    if (.not. blocks%boundary%encloses) then
      blocks%boundary%lone_end = lone_ends(scene%n_boundary, graph)
      do i = 1, size(blocks%boundary%lone_end, 2)
        blocks%boundary%lone_end(:, i) = blocks%boundary%lone_end(:, i) + blocks%origin
      end do
      return
    end if
    moments = [(block_moments(blocks, b), b=1, size(moments))]
    blocks%boundary%n_outside = count(air(1:))
    blocks%boundary%area = sum(moments%area, air(1:))
    blocks%boundary%largest = moments(maxloc(moments%area, 1, air(1:)))%centroid + blocks%origin
    blocks%boundary%has_hole = at_hole > 0 .and. air(at_hole)
    kept = pack([(i, i=1, size(graph%line))], graph%line <= scene%n_boundary .or. .not. (air(beside(1, :)) .and. air(beside(2, :))))
    graph%ends = graph%ends(:, kept)
    graph%line = graph%line(kept)
    graph%against = graph%against(kept)
    number = 0
    i = 0
    do b = 1, size(moments)
      if (air(b)) cycle
      i = i + 1
      number(b) = i
    end do
    beside = reshape(number([beside(:, kept)]), [2, size(kept)])
    call keep_regions(blocks%shape, .not. air(1:), kept)
    blocks%vertex = blocks%vertex(:, kept)
  end subroutine leave_out_air

  !> The blocks at the hole points, 0 where there is none.
  function blocks_at_holes(scene, scale, blocks) result(at_hole)
    type(scene_t), intent(in) :: scene
    real(dp), intent(in) :: scale
    type(blocks_t), intent(in) :: blocks
    integer :: at_hole(size(scene%hole_points))
    type(block_finder_t) :: finder
    integer :: i

    if (size(at_hole) == 0) return
    call set_up_finder(finder, blocks%shape, blocks%vertex, near_blocks*scale)
    do i = 1, size(at_hole)
      at_hole(i) = block_at(finder, blocks%shape, blocks%vertex, scene%hole_points(i)%position - blocks%origin)
    end do
  end function blocks_at_holes

  !> Whether nothing bends a line: a boundary line, or a line that runs along one on which a stage holds, loads, absorbs or removes.
  pure logical function stays_straight(scene, i, nearest)
    type(scene_t), intent(in) :: scene
    integer, intent(in) :: i                !! number of the line
    real(dp), intent(in) :: nearest         !! length
    real(dp) :: off(2), v(2)
    integer :: k, m

    stays_straight = i <= scene%n_boundary
    if (stays_straight .or. .not. allocated(scene%named_lines)) return
    associate (line => scene%lines(i)%ends)
      do k = 1, size(scene%named_lines, 3)
        v = scene%named_lines(:, 2, k) - scene%named_lines(:, 1, k)
        off = [(v(1)*(line(2, m) - scene%named_lines(2, 1, k)) - v(2)*(line(1, m) - scene%named_lines(1, 1, k)), m=1, 2)]
        stays_straight = maxval(abs(off)) <= nearest*norm2(v)
        if (stays_straight) return
      end do
    end associate
  end function stays_straight

  !> Lets blocks smaller than `&blocks least_area` join their neighbours; not those of hole points.
  subroutine join_small_blocks(scene, scale, straight, graph, blocks, beside)
    type(scene_t), intent(in) :: scene
    real(dp), intent(in) :: scale
    logical, intent(in) :: straight(:)      !! (n_lines)
    type(graph_t), intent(inout) :: graph
    type(blocks_t), intent(inout) :: blocks
    integer, allocatable, intent(inout) :: beside(:, :) !! (2, n_pieces) block left and right of each piece, 0: none
    real(dp) :: area(region_count(blocks%shape))
    logical :: held(size(area))
    integer, allocatable :: at_hole(:)
    integer :: b

    area = [(block_area(blocks, blocks%vertex, b), b=1, size(area))]
    at_hole = blocks_at_holes(scene, scale, blocks)
    held = .false.
    held(pack(at_hole, at_hole > 0)) = .true.
    call join_small_regions(scene%settings%least_block_area, area, held, straight, beside, graph, blocks%n_joined)
    if (blocks%n_joined > 0) call trace_blocks(scene, graph, blocks, beside)
  end subroutine join_small_blocks

  !> Polygons of a block file as blocks. Errors: those that bound no block.
  subroutine enter_polygons(scene, blocks, error)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(inout) :: blocks
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: corner(:)

    associate (given => scene%blocks)
      call take_polygons(scene%geometry_name, given, blocks%shape, corner, error)
      if (allocated(error)) return
      blocks%material = given%material
      blocks%line = given%vertex_line(given%first_vertex(:size(given%material)))
      blocks%origin = origin_for(minval(given%vertex, 2), maxval(given%vertex, 2))
      blocks%vertex = given%vertex(:, corner) - spread(blocks%origin, 2, size(corner))
    end associate
    allocate (blocks%crack(2, 2, 0), blocks%crack_joint(0))
  end subroutine enter_polygons

  !> Gives each block the material of the last line that crosses it, or whose first end lies in it; else 1.
  subroutine name_materials(scene, finder, blocks, error)
    type(scene_t), intent(in) :: scene
    type(block_finder_t), intent(in) :: finder
    type(blocks_t), intent(inout) :: blocks
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: crossed(:)
    real(dp), allocatable :: at(:, :)
    real(dp) :: ends(2, 2)
    integer :: b, i

    allocate (blocks%material(region_count(blocks%shape)), source=1)
    allocate (blocks%line(region_count(blocks%shape)), source=0)
    do i = 1, size(scene%material_lines)
      associate (line => scene%material_lines(i))
        ends = line%ends - spread(blocks%origin, 2, 2)
        call find_crossings(finder, blocks%shape, blocks%vertex, ends, at, crossed)
        if (size(crossed) == 0) then
          b = block_at(finder, blocks%shape, blocks%vertex, ends(:, 1))
          if (b == 0) then
            call wrong(scene, line%deck_line, 'a material line that crosses a block or begins in one', 'one outside', error)
            return
          end if
          crossed = [b]
        end if
        blocks%material(crossed) = line%material
      end associate
    end do
  end subroutine name_materials

  !> Removes the blocks at hole points, and the cracks in them.
  subroutine remove_blocks(scene, finder, blocks, error)
    type(scene_t), intent(in) :: scene
    type(block_finder_t), intent(in) :: finder
    type(blocks_t), intent(inout) :: blocks
    type(error_t), allocatable, intent(out) :: error
    logical :: keep(region_count(blocks%shape)), inside(size(blocks%crack_joint))
    integer, allocatable :: vertex(:), kept(:)
    integer :: b, i

    keep = .true.
    do i = 1, size(scene%hole_points)
      b = block_at(finder, blocks%shape, blocks%vertex, scene%hole_points(i)%position - blocks%origin)
      if (b == 0 .and. allocated(blocks%boundary%has_hole)) then
        if (blocks%boundary%has_hole(i)) cycle
      end if
      if (b == 0) then
        call wrong(scene, scene%hole_points(i)%deck_line, 'a hole point inside a block', 'one outside', error)
        return
      end if
      keep(b) = .false.
      if (any(keep)) cycle
      call wrong(scene, scene%hole_points(i)%deck_line, 'a block left after the holes', 'none', error)
      return
    end do
    do i = 1, size(inside)
      b = block_at(finder, blocks%shape, blocks%vertex, 0.5_dp*(blocks%crack(:, 1, i) + blocks%crack(:, 2, i)))
      inside(i) = .true.
      if (b > 0) inside(i) = keep(b)
    end do
    kept = pack([(i, i=1, size(inside))], inside)
    blocks%crack = blocks%crack(:, :, kept)
    blocks%crack_joint = blocks%crack_joint(kept)
    call keep_regions(blocks%shape, keep, vertex)
    blocks%vertex = blocks%vertex(:, vertex)
    blocks%material = pack(blocks%material, keep)
    blocks%line = pack(blocks%line, keep)
  end subroutine remove_blocks

  !> A fixed point at each crossing with the edge of a block, moved inwards, in thin blocks by less; at the first end where
  !> there is none.
  subroutine fix_line(scene, line, depth, finder, blocks, points, error)
    type(scene_t), intent(in) :: scene
    type(line_t), intent(in) :: line
    real(dp), intent(in) :: depth !! length
    type(block_finder_t), intent(in) :: finder
    type(blocks_t), intent(in) :: blocks
    type(found_points_t), intent(inout) :: points
    type(error_t), allocatable, intent(out) :: error
    real(dp), allocatable :: at(:, :)
    integer, allocatable :: crossed(:)
    real(dp) :: ends(2, 2), way
    integer :: b, i

    ends = line%ends - spread(blocks%origin, 2, 2)
    call find_crossings(finder, blocks%shape, blocks%vertex, ends, at, crossed)
    do i = 1, size(crossed)
      way = depth
      do while (distance_outside(blocks%shape, blocks%vertex, crossed(i), at(1:2, i) + way*at(3:4, i)) > finder%beside)
        way = 0.5_dp*way
      end do
      call add_point(points, fixed_point, at(1:2, i) + way*at(3:4, i), crossed(i))
    end do
    if (size(crossed) > 0) return
    b = block_at(finder, blocks%shape, blocks%vertex, ends(:, 1))
    if (b == 0) then
      call wrong(scene, line%deck_line, 'a fixed line that crosses a block, or a fixed point in one', 'one outside', error)
      return
    end if
    call add_point(points, fixed_point, ends(:, 1), b)
  end subroutine fix_line

  !> Adds points to the blocks that hold them.
  subroutine add_points(scene, kind, what, given, finder, blocks, points, error)
    type(scene_t), intent(in) :: scene
    integer, intent(in) :: kind
    character(len=*), intent(in) :: what
    type(point_t), intent(in) :: given(:)
    type(block_finder_t), intent(in) :: finder
    type(blocks_t), intent(in) :: blocks
    type(found_points_t), intent(inout) :: points
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: position(2)
    integer :: b, i

    do i = 1, size(given)
      position = given(i)%position - blocks%origin
      b = given(i)%block
      if (b == 0) then
        b = block_at(finder, blocks%shape, blocks%vertex, position)
        if (b == 0) call wrong(scene, given(i)%deck_line, 'a '//what//' point inside a block', 'one outside', error)
      else
        call check_inside(blocks%shape, blocks%vertex, b, position, 'a '//what//' point', &
                          source_of(scene, given(i)%deck_line), error)
      end if
      if (allocated(error)) return
      call add_point(points, kind, position, b)
    end do
  end subroutine add_points

  !> Larger side of the box around a block, length.
  pure real(dp) function block_size(blocks, b)
    type(blocks_t), intent(in) :: blocks
    integer, intent(in) :: b

    block_size = region_size(blocks%shape, blocks%vertex, b)
  end function block_size

  !> Error at a line of the geometry.
  subroutine wrong(scene, line, expected, found, error)
    type(scene_t), intent(in) :: scene
    integer, intent(in) :: line
    character(len=*), intent(in) :: expected, found
    type(error_t), allocatable, intent(out) :: error

    call fail(error, status_bad_input, source_of(scene, line)//': expected '//expected//', found '//found)
  end subroutine wrong

  !> A line of the geometry, for an error.
  pure function source_of(scene, line) result(source)
    type(scene_t), intent(in) :: scene
    integer, intent(in) :: line
    character(len=:), allocatable :: source

    source = scene%geometry_name//':'//number_text(line)
  end function source_of

end module scree_block_input
