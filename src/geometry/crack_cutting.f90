!> Blocks that cracks cut further.
!>
!> A piece of a crack that ends inside a block is a crack in that block. Pieces that cut a block through make several blocks of it.
!> The largest keeps the number, and the others get numbers after those of all blocks. So the numbers of blocks never change.
module scree_crack_cutting
  use scree_block_finder, only: block_at, block_finder_t, set_up_finder
  use scree_block_input, only: blocks_t
  use scree_carried_points, only: near_blocks
  use scree_errors, only: error_t
  use scree_kinds, only: dp
  use scree_line_cutting, only: cut_lines, graph_t
  use scree_loop_tracing, only: trace_regions
  use scree_polygon, only: inner_place
  use scree_regions, only: first_vertex_of, last_vertex_of, loops_of, region_count, regions_t, take_regions
  use scree_simplex_integration, only: polygon_area
  implicit none
  private
  public :: cut_blocks, lines_of_blocks

contains

  !> The edges of blocks, and then the cracks in them, with their joint materials.
  pure subroutine lines_of_blocks(blocks, ends, joint)
    type(blocks_t), intent(in) :: blocks
    real(dp), allocatable, intent(out) :: ends(:, :, :)    !! (xy, end, n), length
    integer, allocatable, intent(out) :: joint(:)          !! (n)
    integer :: i, k, n, next

    n = size(blocks%vertex, 2)
    allocate (ends(2, 2, n + size(blocks%crack, 3)))
    associate (shape => blocks%shape)
      do i = 1, size(shape%first_vertex) - 1
        do k = shape%first_vertex(i), shape%first_vertex(i + 1) - 1
          next = k + 1
          if (next == shape%first_vertex(i + 1)) next = shape%first_vertex(i)
          ends(:, :, k) = blocks%vertex(:, [k, next])
        end do
      end do
    end associate
    ends(:, :, n + 1:) = blocks%crack
    joint = [blocks%shape%joint, blocks%crack_joint]
  end subroutine lines_of_blocks

  !> Cuts blocks by further pieces of cracks. Points stay in the parts that hold them. Errors: those of the cutting of lines.
  subroutine cut_blocks(piece, joint, blocks, error)
    real(dp), intent(in) :: piece(:, :)    !! (4, n) x1 y1 x2 y2, in the coordinates of the blocks, length
    integer, intent(in) :: joint(:)        !! (n) joint materials of their faces
    type(blocks_t), intent(inout) :: blocks
    type(error_t), allocatable, intent(out) :: error
    type(graph_t) :: graph
    type(regions_t) :: shape
    real(dp), allocatable :: drawn(:, :, :), ends(:, :, :), vertex(:, :)
    integer, allocatable :: beside(:, :), crack(:), drawn_joint(:), kept(:), line(:), list(:), material(:), parent(:)
    integer :: i, n

    call lines_of_blocks(blocks, drawn, drawn_joint)
    n = size(drawn, 3)
    allocate (ends(2, 2, n + size(joint)))
    ends(:, :, :n) = drawn
    ends(:, :, n + 1:) = reshape(piece, [2, 2, size(joint)])
    material = [drawn_joint, joint]
    call cut_lines(ends, spread(.false., 1, size(material)), 0.0_dp, graph, error)
    if (allocated(error)) return
    call trace_regions(graph, reshape([material(graph%line), material(graph%against)], [2, size(graph%line)], order=[2, 1]), &
                       shape, vertex, line, beside)
    parent = parents_of(blocks, shape, vertex)
    list = in_order_of_blocks(size(blocks%material), parent, [(area_of(i), i=1, size(parent))])
    crack = pack([(i, i=1, size(graph%line))], beside(1, :) == beside(2, :))
    crack = pack(crack, [(is_inside(beside(1, crack(i))), i=1, size(crack))])
    deallocate (blocks%crack)
    allocate (blocks%crack(2, 2, size(crack)))
    do i = 1, size(crack)
      blocks%crack(:, :, i) = graph%position(:, graph%ends(:, crack(i)))
    end do
    blocks%crack_joint = material(graph%line(crack))
    blocks%n_grown = blocks%n_grown + size(joint)
    call take_regions(shape, list, kept)
    blocks%shape = shape
    blocks%vertex = vertex(:, kept)
    parent = parent(list)
    blocks%material = blocks%material(parent)
    blocks%line = blocks%line(parent)
    blocks%drawn = blocks%drawn(parent)
    call find_carriers(parent, blocks)

  contains

    !> Area of a region, length^2.
    real(dp) function area_of(i)
      integer, intent(in) :: i

      area_of = polygon_area(vertex(:, first_vertex_of(shape, i):last_vertex_of(shape, i)), loops_of(shape, i))
    end function area_of

    !> Whether a region is part of a block.
    pure logical function is_inside(region)
      integer, intent(in) :: region

      is_inside = region > 0
      if (is_inside) is_inside = parent(region) > 0
    end function is_inside

  end subroutine cut_blocks

  !> The block that each region is part of, 0 outside of all.
  function parents_of(blocks, shape, vertex) result(parent)
    type(blocks_t), intent(in) :: blocks
    type(regions_t), intent(in) :: shape
    real(dp), intent(in) :: vertex(:, :)   !! (2, n_vertices), length
    integer :: parent(region_count(shape))
    type(block_finder_t) :: finder
    integer :: i

    call set_up_finder(finder, blocks%shape, blocks%vertex, 0.0_dp)
    do i = 1, size(parent)
      parent(i) = block_at(finder, blocks%shape, blocks%vertex, &
                           inner_place(vertex(:, first_vertex_of(shape, i):last_vertex_of(shape, i)), loops_of(shape, i)))
    end do
  end function parents_of

  !> The regions that are parts of blocks: first the largest of each block, then all others.
  pure function in_order_of_blocks(n_blocks, parent, area) result(list)
    integer, intent(in) :: n_blocks
    integer, intent(in) :: parent(:)       !! (n_regions)
    real(dp), intent(in) :: area(:)        !! (n_regions) length^2
    integer, allocatable :: list(:)
    integer :: b, i, largest(n_blocks)

    largest = [(maxloc(area, 1, parent == b), b=1, n_blocks)]
    list = [largest, pack([(i, i=1, size(parent))], [(parent(i) > 0 .and. .not. any(largest == i), i=1, size(parent))])]
  end function in_order_of_blocks

  !> Finds the parts of blocks that carry the points.
  subroutine find_carriers(parent, blocks)
    integer, intent(in) :: parent(:)       !! (n_blocks) block of before that each is part of
    type(blocks_t), intent(inout) :: blocks
    type(block_finder_t) :: finder
    integer :: i

    call set_up_finder(finder, blocks%shape, blocks%vertex, near_blocks*maxval(maxval(blocks%vertex, 2) - minval(blocks%vertex, 2)))
    do i = 1, size(blocks%point_block)
      if (count(parent == blocks%point_block(i)) == 1) cycle
      blocks%point_block(i) = block_at(finder, blocks%shape, blocks%vertex, blocks%point(:, i), parent, blocks%point_block(i))
    end do
  end subroutine find_carriers

end module scree_crack_cutting
