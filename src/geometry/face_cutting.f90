!> Blocks and a mathematical mesh in one cut: the faces that become manifold elements.
module scree_face_cutting
  use scree_block_finder, only: block_at, block_finder_t, set_up_finder
  use scree_block_input, only: blocks_t
  use scree_cell_grid, only: cell_grid_t, cells_of_box, number_of_cell, place_segments, set_up_grid
  use scree_crack_cutting, only: lines_of_blocks
  use scree_errors, only: error_t
  use scree_kinds, only: dp
  use scree_line_cutting, only: cut_lines, graph_t
  use scree_loop_tracing, only: trace_regions
  use scree_mathematical_mesh, only: between_triangles, mesh_edges, mesh_regions, shortest_edge
  use scree_mesh, only: mesh_t
  use scree_polygon, only: inner_place
  use scree_regions, only: first_vertex_of, keep_regions, last_vertex_of, loops_of, region_count, regions_t, &
                           take_regions
  use scree_sets, only: root_of, unite
  use scree_simplex_integration, only: polygon_area
  use scree_sorting, only: sort_by
  use scree_straight_lines, only: drop_perpendicular
  implicit none
  private
  public :: cut_faces, cut_faces_t

  !> Of the shortest edge of the mesh: a node that lies so near to a joint is on it. Those far from the origin of a regular mesh are
  !> rounded, and those of a file.
  real(dp), parameter :: beside = 1e-9_dp

  !> Elements as the cut makes them.
  type :: cut_faces_t
    type(regions_t) :: shape
    real(dp), allocatable :: vertex(:, :)    !! (2, n_vertices)
    integer, allocatable :: block(:)         !! (n)
    integer, allocatable :: triangle(:)      !! (n)
    real(dp), allocatable :: share(:)        !! (n) area over that of the triangle
    integer, allocatable :: neighbours(:, :) !! (2, m) pairs that share a piece of the mesh
    real(dp), allocatable :: torn(:)         !! (2) a place in a block where the mesh is torn; then there are no faces
  end type cut_faces_t

contains

  !> Cuts blocks and mesh together, and keeps what lies in blocks, block after block.
  !>
  !> Errors: those of the cutting of lines.
  subroutine cut_faces(blocks, mesh, faces, uncovered, error)
    type(blocks_t), intent(in) :: blocks
    type(mesh_t), intent(in) :: mesh       !! in the coordinates of the blocks
    type(cut_faces_t), intent(out) :: faces
    integer, intent(out) :: uncovered      !! parts of blocks that the mesh does not hold; above 0 there are no faces
    type(error_t), allocatable, intent(out) :: error
    type(graph_t) :: graph
    real(dp), allocatable :: ends(:, :, :), area(:)
    integer, allocatable :: beside(:, :), line(:), joint(:), material(:, :), kept(:)
    integer :: b, f, i, n_joints

    uncovered = 0
    n_joints = size(blocks%vertex, 2) + size(blocks%crack, 3)
    call gather_lines(blocks, mesh, ends, joint)
    call cut_lines(ends, spread(.false., 1, size(ends, 3)), 0.0_dp, graph, error)
    if (allocated(error)) return
    allocate (material(2, size(graph%line)))
    material(1, :) = joint(graph%line)
    material(2, :) = joint(merge(graph%against, graph%line, graph%against <= n_joints)) ! either block has its own
    call trace_regions(graph, material, faces%shape, faces%vertex, line, beside)
    kept = pack([(i, i=1, size(graph%line))], graph%line > n_joints .and. minval(beside, 1) > 0 .and. &
                beside(1, :) /= beside(2, :))
    faces%neighbours = beside(:, kept)
    area = [(polygon_area(corners_of(faces, f), loops_of(faces%shape, f)), f=1, region_count(faces%shape))]
    call find_blocks(blocks, area, faces)
    call find_triangles(mesh, graph%rounding, faces)
    uncovered = count(faces%block > 0 .and. faces%triangle == 0)
    if (uncovered > 0) return
    call find_tear(between_triangles(mesh), graph%line(kept) - n_joints, graph%position, graph%ends(:, kept), faces)
    if (allocated(faces%torn)) return
    uncovered = count([(.not. any(faces%block == b), b=1, region_count(blocks%shape))])
    call keep_faces(mesh, area, faces)
  end subroutine cut_faces

  !> The edges of blocks, the cracks in them, and the lines of the mesh, in this order.
  pure subroutine gather_lines(blocks, mesh, ends, joint)
    type(blocks_t), intent(in) :: blocks
    type(mesh_t), intent(in) :: mesh
    real(dp), allocatable, intent(out) :: ends(:, :, :)    !! (xy, end, n), length
    integer, allocatable, intent(out) :: joint(:)          !! (n) their materials, 0 of the mesh
    real(dp), allocatable :: drawn(:, :, :), node(:, :)
    integer, allocatable :: drawn_joint(:), edge(:, :)
    integer :: i, n_joints

    call lines_of_blocks(blocks, drawn, drawn_joint)
    edge = mesh_edges(mesh)
    n_joints = size(drawn_joint)
    allocate (ends(2, 2, n_joints + size(edge, 2)), joint(n_joints + size(edge, 2)))
    ends(:, :, :n_joints) = drawn
    joint(:n_joints) = drawn_joint
    node = brought_onto(ends(:, :, :n_joints), beside*shortest_edge(mesh), mesh%node)
    do i = 1, size(edge, 2)
      ends(:, :, n_joints + i) = node(:, edge(:, i))
    end do
    joint(n_joints + 1:) = 0
  end subroutine gather_lines

  !> Nodes, where they lie beside a line on its end or the foot on it.
  pure function brought_onto(ends, reach, node) result(on)
    real(dp), intent(in) :: ends(:, :, :)    !! (xy, end, n) of the lines, length
    real(dp), intent(in) :: reach            !! of a node, length
    real(dp), intent(in) :: node(:, :)       !! (2, n_nodes)
    real(dp) :: on(2, size(node, 2))
    type(cell_grid_t) :: grid
    real(dp) :: distance, foot(2), nearest, position(2, 2*size(ends, 3))
    integer :: at, i, k, line, range(2, 2)

    on = node
    position = reshape(ends, shape(position))
    call set_up_grid(grid, position, size(ends, 3))
    call place_segments(grid, position, reshape([(i, i=1, size(position, 2))], [2, size(ends, 3)]), 2*reach)
    do i = 1, size(node, 2)
      range = cells_of_box(grid, node(:, i), node(:, i)) ! the lists of the grid have the margin
      nearest = reach
      associate (cell => number_of_cell(grid, range(1, 1), range(2, 1)))
        do at = grid%first(cell), grid%first(cell + 1) - 1
          line = grid%item(at)
          call drop_perpendicular(ends(:, 1, line), ends(:, 2, line), node(:, i), foot, distance)
          if (distance <= nearest) then
            nearest = distance
            on(:, i) = foot
          end if
        end do
        do at = grid%first(cell), grid%first(cell + 1) - 1
          do k = 1, 2
            if (norm2(node(:, i) - ends(:, k, grid%item(at))) <= reach) on(:, i) = ends(:, k, grid%item(at))
          end do
        end do
      end associate
    end do
  end function brought_onto

  !> Finds the block of each face, 0 outside of all: faces connected across the mesh lie in one, that of the largest of them.
  subroutine find_blocks(blocks, area, faces)
    type(blocks_t), intent(in) :: blocks
    real(dp), intent(in) :: area(:)        !! (n) of the faces
    type(cut_faces_t), intent(inout) :: faces
    type(block_finder_t) :: finder
    integer :: largest(size(area)), root(size(area)), f, i

    root = [(f, f=1, size(area))]
    do i = 1, size(faces%neighbours, 2)
      call unite(root, faces%neighbours(1, i), faces%neighbours(2, i))
    end do
    root = [(root_of(root, f), f=1, size(area))]
    largest = [(f, f=1, size(area))]
    do f = 1, size(area)
      if (area(f) > area(largest(root(f)))) largest(root(f)) = f
    end do
    call set_up_finder(finder, blocks%shape, blocks%vertex, 0.0_dp)
    allocate (faces%block(size(area)), source=0)
    do f = 1, size(area)
      if (root(f) == f) faces%block(f) = block_at(finder, blocks%shape, blocks%vertex, &
                                                  inner_place(corners_of(faces, largest(f)), loops_of(faces%shape, largest(f))))
    end do
    faces%block = faces%block(root)
  end subroutine find_blocks

  !> Finds the triangle of the mesh that holds each face of a block, 0 where none does.
  subroutine find_triangles(mesh, rounding, faces)
    type(mesh_t), intent(in) :: mesh
    real(dp), intent(in) :: rounding       !! of positions in the cut, length
    type(cut_faces_t), intent(inout) :: faces
    type(block_finder_t) :: finder
    type(regions_t) :: triangles
    real(dp), allocatable :: vertex(:, :)
    integer :: f

    call mesh_regions(mesh, triangles, vertex)
    call set_up_finder(finder, triangles, vertex, rounding)
    allocate (faces%triangle(size(faces%block)), source=0)
    do f = 1, size(faces%block)
      if (faces%block(f) == 0) cycle
      faces%triangle(f) = block_at(finder, triangles, vertex, inner_place(corners_of(faces, f), loops_of(faces%shape, f)))
    end do
  end subroutine find_triangles

  !> Finds a place in a block where the triangles of the mesh do not fit together, if any.
  !>
  !> There a line between neighbours has not exactly one triangle on either side, because nodes hang on it or are doubled, or
  !> because triangles overlap.
  pure subroutine find_tear(between, edge, position, ends, faces)
    logical, intent(in) :: between(:)      !! whether an edge of the mesh has one triangle on either side
    integer, intent(in) :: edge(:)         !! (m) of the mesh, between two neighbours
    real(dp), intent(in) :: position(:, :) !! (2, n) of nodes of the cut, length
    integer, intent(in) :: ends(:, :)      !! (2, m) nodes of the cut that the piece between two neighbours joins
    type(cut_faces_t), intent(inout) :: faces
    integer :: i

    do i = 1, size(edge)
      if (between(edge(i)) .or. faces%block(faces%neighbours(1, i)) == 0) cycle
      faces%torn = 0.5_dp*(position(:, ends(1, i)) + position(:, ends(2, i)))
      return
    end do
  end subroutine find_tear

  !> Keeps the faces of blocks, in the order of these, with the fraction that each has of its triangle.
  subroutine keep_faces(mesh, area, faces)
    type(mesh_t), intent(in) :: mesh
    real(dp), intent(in) :: area(:)        !! (n) of the faces
    type(cut_faces_t), intent(inout) :: faces
    real(dp), allocatable :: key(:)
    logical :: keep(size(area))
    integer :: number(size(area)), f, i
    integer, allocatable :: kept(:), order(:)

    keep = faces%block > 0
    number = 0
    number(pack([(f, f=1, size(keep))], keep)) = [(f, f=1, count(keep))]
    call keep_regions(faces%shape, keep, kept)
    faces%vertex = faces%vertex(:, kept)
    faces%block = pack(faces%block, keep)
    faces%triangle = pack(faces%triangle, keep)
    faces%share = pack(area, keep)
    do f = 1, size(faces%share)
      faces%share(f) = faces%share(f)/polygon_area(mesh%node(:, mesh%triangle(:, faces%triangle(f))), [1, 4])
    end do
    kept = pack([(i, i=1, size(faces%neighbours, 2))], keep(faces%neighbours(1, :)))
    faces%neighbours = faces%neighbours(:, kept)
    do i = 1, size(kept)
      faces%neighbours(:, i) = number(faces%neighbours(:, i))
    end do
    order = [(f, f=1, size(faces%block))]
    key = real(faces%block, dp)
    call sort_by(key, order)
    call put_in_order(order, faces)
  end subroutine keep_faces

  !> Corners of a face.
  pure function corners_of(faces, f) result(corner)
    type(cut_faces_t), intent(in) :: faces
    integer, intent(in) :: f
    real(dp), allocatable :: corner(:, :)

    corner = faces%vertex(:, first_vertex_of(faces%shape, f):last_vertex_of(faces%shape, f))
  end function corners_of

  !> Brings the faces into an order.
  pure subroutine put_in_order(order, faces)
    integer, intent(in) :: order(:)
    type(cut_faces_t), intent(inout) :: faces
    type(cut_faces_t) :: sorted
    integer :: f, i, position(size(order))
    integer, allocatable :: vertex(:)

    sorted%block = faces%block(order)
    sorted%triangle = faces%triangle(order)
    sorted%share = faces%share(order)
    position(order) = [(f, f=1, size(order))]
    allocate (sorted%neighbours(2, size(faces%neighbours, 2)))
    do i = 1, size(faces%neighbours, 2)
      sorted%neighbours(:, i) = position(faces%neighbours(:, i))
    end do
    sorted%shape = faces%shape
    call take_regions(sorted%shape, order, vertex)
    sorted%vertex = faces%vertex(:, vertex)
    faces = sorted
  end subroutine put_in_order

end module scree_face_cutting
