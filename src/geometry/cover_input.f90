!> Blocks to elements and covers (Shi's mc).
!>
!> A block of the DDA is one element with its own cover. In the NMM a mathematical mesh lies over the blocks; what a triangle
!> has in common with a block are manifold elements, one or more polygons of any shape, and every node of the mesh makes
!> as many physical covers as its triangles' elements fall into connected parts. Without a mesh each block is one element
!> on three covers of its own: those of the block itself where it is a triangle and no sliver, else of the equilateral
!> triangle around the circle that holds it; the field is affine and its integrals exact, so the choice does not matter.
module scree_cover_input
  use scree_block_finder, only: block_at, block_finder_t, set_up_finder
  use scree_block_input, only: blocks_t
  use scree_kinds, only: dp
  use scree_line_cutting, only: cut_lines, graph_t
  use scree_loop_tracing, only: trace_regions
  use scree_errors, only: error_t
  use scree_mathematical_mesh, only: mesh_edges, mesh_regions
  use scree_mesh, only: mesh_t
  use scree_polygon, only: inner_place, twice_area
  use scree_regions, only: first_vertex_of, keep_regions, last_vertex_of, loops_of, region_count, regions_t
  use scree_simplex_integration, only: moments_t, polygon_moments
  use scree_sorting, only: sort_by
  use scree_system, only: element_unknowns, elements_t, extension_t
  implicit none
  private
  public :: cover_blocks, cover_with_mesh, cover_quality_t

  real(dp), parameter :: no_sliver = 0.2_dp !! twice the area over the longest edge squared; 0.87 for equal edges

  !> What the cut made of the mesh.
  type :: cover_quality_t
    integer :: small = 0                !! elements below the least share of their triangle
    integer :: extended = 0             !! covers that follow others
    real(dp) :: least_share = 1.0_dp    !! smallest area of an element over that of its triangle
    real(dp) :: farthest = 0.0_dp       !! largest weight of an extension
    integer :: uncovered = 0            !! blocks that the mesh does not hold
  end type cover_quality_t

  !> Elements as the cut makes them.
  type :: faces_t
    type(regions_t) :: shape
    real(dp), allocatable :: vertex(:, :)    !! (2, n_vertices)
    integer, allocatable :: block(:)         !! (n)
    integer, allocatable :: triangle(:)      !! (n)
    real(dp), allocatable :: share(:)        !! (n) area over that of the triangle
    integer, allocatable :: neighbours(:, :) !! (2, m) pairs that share a piece of the mesh
  end type faces_t

contains

  !> Elements and covers of blocks without a mesh.
  pure subroutine cover_blocks(dda, shape, vertex, material, elements, cover)
    logical, intent(in) :: dda                         !! one cover a block, else three
    type(regions_t), intent(in) :: shape               !! of the blocks
    real(dp), intent(in) :: vertex(:, :)               !! (2, n_vertices), length
    integer, intent(in) :: material(:)                 !! (n_blocks)
    type(elements_t), intent(out) :: elements
    real(dp), allocatable, intent(out) :: cover(:, :)  !! (2, n_covers) nodes of the mathematical mesh, none for DDA
    integer :: b, i, n, per_block

    n = size(material)
    per_block = merge(1, 3, dda)
    elements%shape = shape
    elements%block = [(b, b=1, n)]
    elements%material = material
    elements%cover = reshape([(i, i=1, per_block*n)], [per_block, n])
    elements%unknown = reshape([(i, i=1, element_unknowns*n)], [element_unknowns, n])
    allocate (elements%alone(n), source=.true.)
    if (dda) then
      allocate (cover(2, 0))
    else
      allocate (cover(2, 3*n))
      do b = 1, n
        cover(:, 3*b - 2:3*b) = mathematical_triangle(vertex(:, first_vertex_of(shape, b):last_vertex_of(shape, b)))
      end do
    end if
  end subroutine cover_blocks

  !> Nodes of one triangle that holds the polygon, counter-clockwise.
  pure function mathematical_triangle(polygon) result(node)
    real(dp), intent(in) :: polygon(:, :) !! (2, n)
    real(dp) :: node(2, 3), centre(2), radius
    real(dp), parameter :: half_root_three = sqrt(0.75_dp)

    if (size(polygon, 2) == 3) then
      node = polygon
      if (twice_area(node) > no_sliver*maxval(sum((node - node(:, [2, 3, 1]))**2, 1))) return
    end if
    centre = 0.5_dp*(minval(polygon, 2) + maxval(polygon, 2))
    radius = sqrt(maxval(sum((polygon - spread(centre, 2, size(polygon, 2)))**2, 1)))
    node = 2*radius*reshape([0.0_dp, 1.0_dp, -half_root_three, -0.5_dp, half_root_three, -0.5_dp], [2, 3]) &
           + spread(centre, 2, 3)
  end function mathematical_triangle

  !> Elements and covers of blocks under a mathematical mesh, and the covers that follow others.
  !>
  !> The lines of the mesh join the edges of the blocks and the cracks in them in one cut. Elements are connected across
  !> lines of the mesh, never across joints.
  !>
  !> A cover whose elements all have less than `least_share` of their triangles is too small to stand on its own: its
  !> stiffness and mass go to zero with the area, and the condition of the equations with them (the small-cut problem).
  !> It follows the nearest element that is large enough: the linear field of that element, extended to the node
  !> (aggregation; Badia, Verdugo, Martin 2018). The fields that are left hold every linear field and stay continuous, so
  !> that nothing else changes.
  subroutine cover_with_mesh(blocks, vertex, crack, mesh, least_share, elements, element_vertex, cover, extension, quality, error)
    type(blocks_t), intent(in) :: blocks
    real(dp), intent(in) :: vertex(:, :)                        !! (2, n_vertices) of the blocks, length
    real(dp), intent(in) :: crack(:, :, :)                      !! (xy, end, n) pieces of joints inside blocks, length
    type(mesh_t), intent(in) :: mesh
    real(dp), intent(in) :: least_share                         !! 0: every cover stands on its own
    type(elements_t), intent(out) :: elements
    real(dp), allocatable, intent(out) :: element_vertex(:, :)  !! (2, n) vertices of the elements, length
    real(dp), allocatable, intent(out) :: cover(:, :)           !! (2, n_covers) their nodes, length
    type(extension_t), allocatable, intent(out) :: extension    !! where covers follow others
    type(cover_quality_t), intent(out) :: quality
    type(error_t), allocatable, intent(out) :: error
    type(faces_t) :: faces

    call cut_faces(blocks, vertex, crack, mesh, faces, quality%uncovered, error)
    if (allocated(error) .or. quality%uncovered > 0) return
    call connect_faces(mesh, faces, elements, cover)
    elements%material = blocks%material(faces%block)
    element_vertex = faces%vertex
    quality%least_share = minval(faces%share)
    quality%small = count(faces%share < least_share)
    call extend_covers(faces, least_share, cover, elements, extension)
    if (.not. allocated(extension)) return
    quality%extended = size(extension%cover)
    quality%farthest = maxval(abs(extension%weight))
  end subroutine cover_with_mesh

  !> Cuts blocks and mesh together, and keeps what lies in blocks, block after block.
  subroutine cut_faces(blocks, vertex, crack, mesh, faces, uncovered, error)
    type(blocks_t), intent(in) :: blocks
    real(dp), intent(in) :: vertex(:, :), crack(:, :, :)
    type(mesh_t), intent(in) :: mesh
    type(faces_t), intent(out) :: faces
    integer, intent(out) :: uncovered
    type(error_t), allocatable, intent(out) :: error
    type(graph_t) :: graph
    type(regions_t) :: triangles
    type(block_finder_t) :: finder
    real(dp), allocatable :: ends(:, :, :), triangle_vertex(:, :), area(:)
    integer, allocatable :: beside(:, :), edge(:, :), line(:), material(:), number(:), order(:), root(:), kept(:), largest(:)
    type(moments_t) :: moments
    logical, allocatable :: keep(:)
    integer :: b, f, i, k, n, n_joints, next

    uncovered = 0
    edge = mesh_edges(mesh)
    n_joints = size(vertex, 2) + size(crack, 3)
    allocate (ends(2, 2, n_joints + size(edge, 2)), material(n_joints + size(edge, 2)))
    n = 0
    do b = 1, region_count(blocks%shape)
      do i = blocks%shape%first_loop(b), blocks%shape%first_loop(b + 1) - 1
        do k = blocks%shape%first_vertex(i), blocks%shape%first_vertex(i + 1) - 1
          next = k + 1
          if (next == blocks%shape%first_vertex(i + 1)) next = blocks%shape%first_vertex(i)
          n = n + 1
          ends(:, :, n) = vertex(:, [k, next])
          material(n) = blocks%shape%joint(k)
        end do
      end do
    end do
    ends(:, :, n + 1:n_joints) = crack
    material(n + 1:n_joints) = blocks%crack_joint
    do i = 1, size(edge, 2)
      ends(:, :, n_joints + i) = mesh%node(:, edge(:, i))
    end do
    material(n_joints + 1:) = 0
    call cut_lines(ends, 0, 0.0_dp, graph, error)
    if (allocated(error)) return
    call trace_regions(graph, material, faces%shape, faces%vertex, line, beside)

    ! Faces connected across the mesh lie in one block: that of the largest of them.
    n = region_count(faces%shape)
    kept = pack([(i, i=1, size(graph%line))], graph%line > n_joints .and. minval(beside, 1) > 0 .and. &
                beside(1, :) /= beside(2, :))
    faces%neighbours = beside(:, kept)
    root = [(f, f=1, n)]
    do i = 1, size(kept)
      call unite(root, faces%neighbours(1, i), faces%neighbours(2, i))
    end do
    allocate (area(n), faces%block(n), faces%triangle(n), faces%share(n))
    largest = [(f, f=1, n)]
    do f = 1, n
      moments = moments_of(f)
      area(f) = moments%area
      root(f) = root_of(root, f)
    end do
    do f = 1, n
      if (area(f) > area(largest(root(f)))) largest(root(f)) = f
    end do
    call set_up_finder(finder, blocks%shape, vertex, 0.0_dp)
    faces%block = 0
    do f = 1, n
      if (root(f) == f) faces%block(f) = block_at(finder, blocks%shape, vertex, inner_place_of(largest(f)))
    end do
    faces%block = faces%block(root)

    call mesh_regions(mesh, triangles, triangle_vertex)
    call set_up_finder(finder, triangles, triangle_vertex, graph%rounding)
    faces%triangle = 0
    do f = 1, n
      if (faces%block(f) == 0) cycle
      faces%triangle(f) = block_at(finder, triangles, triangle_vertex, inner_place_of(f))
      if (faces%triangle(f) == 0) uncovered = uncovered + 1
    end do
    if (uncovered > 0) return
    do b = 1, region_count(blocks%shape)
      if (.not. any(faces%block == b)) uncovered = uncovered + 1
    end do

    keep = faces%block > 0
    allocate (number(n), source=0)
    k = 0
    do f = 1, n
      if (.not. keep(f)) cycle
      k = k + 1
      number(f) = k
    end do
    call keep_regions(faces%shape, keep, kept)
    faces%vertex = faces%vertex(:, kept)
    faces%block = pack(faces%block, keep)
    faces%triangle = pack(faces%triangle, keep)
    faces%share = pack(area, keep)
    do f = 1, k
      associate (node => mesh%node(:, mesh%triangle(:, faces%triangle(f))))
        moments = polygon_moments(node, [1, 4])
        faces%share(f) = faces%share(f)/moments%area
      end associate
    end do
    kept = pack([(i, i=1, size(faces%neighbours, 2))], keep(faces%neighbours(1, :)))
    faces%neighbours = faces%neighbours(:, kept)
    do i = 1, size(kept)
      faces%neighbours(:, i) = number(faces%neighbours(:, i))
    end do
    order = [(f, f=1, k)]
    area = real(faces%block, dp)
    call sort_by(area, order)
    call put_in_order(order, faces)

  contains

    !> Area and centroid of a face.
    pure function moments_of(f) result(moments)
      integer, intent(in) :: f
      type(moments_t) :: moments

      moments = polygon_moments(faces%vertex(:, first_vertex_of(faces%shape, f):last_vertex_of(faces%shape, f)), &
                                loops_of(faces%shape, f))
    end function moments_of

    !> A position inside a face.
    pure function inner_place_of(f) result(position)
      integer, intent(in) :: f
      real(dp) :: position(2)

      position = inner_place(faces%vertex(:, first_vertex_of(faces%shape, f):last_vertex_of(faces%shape, f)), &
                          loops_of(faces%shape, f))
    end function inner_place_of

  end subroutine cut_faces

  !> Brings the faces into an order.
  pure subroutine put_in_order(order, faces)
    integer, intent(in) :: order(:)
    type(faces_t), intent(inout) :: faces
    type(faces_t) :: sorted
    integer :: f, i, n_loops, n_vertices, position(size(order)), vertex(size(faces%vertex, 2))

    sorted%block = faces%block(order)
    sorted%triangle = faces%triangle(order)
    sorted%share = faces%share(order)
    position(order) = [(f, f=1, size(order))]
    allocate (sorted%neighbours(2, size(faces%neighbours, 2)))
    do i = 1, size(faces%neighbours, 2)
      sorted%neighbours(:, i) = position(faces%neighbours(:, i))
    end do
    allocate (sorted%shape%first_loop(size(order) + 1), sorted%shape%first_vertex(size(faces%shape%first_vertex)))
    n_loops = 0
    n_vertices = 0
    do f = 1, size(order)
      sorted%shape%first_loop(f) = n_loops + 1
      associate (shape => faces%shape)
        do i = shape%first_loop(order(f)), shape%first_loop(order(f) + 1) - 1
          n_loops = n_loops + 1
          sorted%shape%first_vertex(n_loops) = n_vertices + 1
          associate (length => shape%first_vertex(i + 1) - shape%first_vertex(i))
            vertex(n_vertices + 1:n_vertices + length) = indices(shape%first_vertex(i), shape%first_vertex(i + 1) - 1)
            n_vertices = n_vertices + length
          end associate
        end do
      end associate
    end do
    sorted%shape%first_loop(size(order) + 1) = n_loops + 1
    sorted%shape%first_vertex(n_loops + 1) = n_vertices + 1
    sorted%shape%joint = faces%shape%joint(vertex)
    sorted%vertex = faces%vertex(:, vertex)
    faces = sorted

  contains

    !> Whole numbers from one to another.
    pure function indices(from, to)
      integer, intent(in) :: from, to
      integer :: indices(to - from + 1), k

      indices = [(k, k=from, to)]
    end function indices

  end subroutine put_in_order

  !> Physical covers: corners of elements that are one node of the mesh are one cover where the elements are connected
  !> around it.
  pure subroutine connect_faces(mesh, faces, elements, cover)
    type(mesh_t), intent(in) :: mesh
    type(faces_t), intent(in) :: faces
    type(elements_t), intent(out) :: elements
    real(dp), allocatable, intent(out) :: cover(:, :)
    integer :: root(3*size(faces%block)), number(3*size(faces%block)), users(3*size(faces%block))
    integer :: f, g, i, k, l, n

    n = size(faces%block)
    root = [(i, i=1, 3*n)]
    do i = 1, size(faces%neighbours, 2)
      f = faces%neighbours(1, i)
      g = faces%neighbours(2, i)
      do k = 1, 3
        do l = 1, 3
          if (mesh%triangle(k, faces%triangle(f)) == mesh%triangle(l, faces%triangle(g))) &
            call unite(root, 3*f - 3 + k, 3*g - 3 + l)
        end do
      end do
    end do
    elements%shape = faces%shape
    elements%block = faces%block
    allocate (elements%cover(3, n), elements%unknown(element_unknowns, n), elements%alone(n))
    number = 0
    users = 0
    l = 0
    do f = 1, n
      do k = 1, 3
        i = root_of(root, 3*f - 3 + k)
        if (number(i) == 0) then
          l = l + 1
          number(i) = l
        end if
        elements%cover(k, f) = number(i)
        users(number(i)) = users(number(i)) + 1
        elements%unknown(2*k - 1:2*k, f) = [2*number(i) - 1, 2*number(i)]
      end do
    end do
    allocate (cover(2, l))
    do f = 1, n
      cover(:, elements%cover(:, f)) = mesh%node(:, mesh%triangle(:, faces%triangle(f)))
      elements%alone(f) = all(users(elements%cover(:, f)) == 1)
    end do
  end subroutine connect_faces

  !> Covers without an element of the least share follow the nearest that has one, by steps across lines of the mesh; where
  !> a part of a block has none, its largest.
  subroutine extend_covers(faces, least_share, cover, elements, extension)
    type(faces_t), intent(in) :: faces
    real(dp), intent(in) :: least_share
    real(dp), intent(in) :: cover(:, :)
    type(elements_t), intent(inout) :: elements
    type(extension_t), allocatable, intent(out) :: extension
    logical :: large(size(faces%block)), stands(size(cover, 2))
    integer :: from(size(faces%block)), queue(size(faces%block)), part(size(faces%block)), best(size(faces%block))
    integer :: first(size(faces%block) + 1), to(2*size(faces%neighbours, 2)), head, tail, f, g, i, k, n

    n = size(faces%block)
    large = faces%share >= least_share
    if (all(large)) return
    part = [(f, f=1, n)]
    do i = 1, size(faces%neighbours, 2)
      call unite(part, faces%neighbours(1, i), faces%neighbours(2, i))
    end do
    best = 0
    do f = 1, n
      g = root_of(part, f)
      if (best(g) == 0) best(g) = f
      if (faces%share(f) > faces%share(best(g))) best(g) = f
    end do
    do f = 1, n
      if (best(f) > 0) large(best(f)) = .true.
    end do

    stands = .false.
    do f = 1, n
      if (large(f)) stands(elements%cover(:, f)) = .true.
    end do
    if (all(stands)) return

    call list_neighbours()
    from = 0
    tail = 0
    do f = 1, n ! all large ones at once, then ring by ring
      if (.not. large(f)) cycle
      tail = tail + 1
      queue(tail) = f
      from(f) = f
    end do
    head = 0
    do while (head < tail)
      head = head + 1
      f = queue(head)
      do i = first(f), first(f + 1) - 1
        if (from(to(i)) > 0) cycle
        from(to(i)) = from(f)
        tail = tail + 1
        queue(tail) = to(i)
      end do
    end do

    allocate (extension)
    allocate (extension%cover(count(.not. stands)), extension%master(3, count(.not. stands)), &
              extension%weight(3, count(.not. stands)))
    i = 0
    do head = 1, n ! in the order of rings, so that the nearest is followed
      f = queue(head)
      do k = 1, 3
        associate (c => elements%cover(k, f), leader => from(f))
          if (stands(c)) cycle
          stands(c) = .true.
          i = i + 1
          extension%cover(i) = c
          extension%master(:, i) = elements%cover(:, leader)
          extension%weight(:, i) = weights(cover(:, elements%cover(:, leader)), cover(:, c))
          elements%alone(leader) = .false.
          elements%alone(f) = .false.
        end associate
      end do
    end do

  contains

    !> Neighbours of each face.
    subroutine list_neighbours()
      integer :: at(n), j, pair

      first = 0
      do pair = 1, size(faces%neighbours, 2)
        do j = 1, 2
          first(faces%neighbours(j, pair) + 1) = first(faces%neighbours(j, pair) + 1) + 1
        end do
      end do
      first(1) = 1
      do j = 1, n
        first(j + 1) = first(j + 1) + first(j)
      end do
      at = first(:n)
      do pair = 1, size(faces%neighbours, 2)
        do j = 1, 2
          to(at(faces%neighbours(j, pair))) = faces%neighbours(3 - j, pair)
          at(faces%neighbours(j, pair)) = at(faces%neighbours(j, pair)) + 1
        end do
      end do
    end subroutine list_neighbours

  end subroutine extend_covers

  !> Linear weights of a triangle at a position, which may lie outside.
  pure function weights(node, position)
    real(dp), intent(in) :: node(2, 3), position(2)
    real(dp) :: weights(3), a(2), b(2), x(2), det

    a = node(:, 2) - node(:, 1)
    b = node(:, 3) - node(:, 1)
    x = position - node(:, 1)
    det = a(1)*b(2) - a(2)*b(1)
    weights(2) = (x(1)*b(2) - x(2)*b(1))/det
    weights(3) = (a(1)*x(2) - a(2)*x(1))/det
    weights(1) = 1 - weights(2) - weights(3)
  end function weights

  !> Root of a set.
  pure integer function root_of(root, i)
    integer, intent(in) :: root(:), i

    root_of = i
    do while (root(root_of) /= root_of)
      root_of = root(root_of)
    end do
  end function root_of

  !> Makes two sets one, whose root is the lower.
  pure subroutine unite(root, i, j)
    integer, intent(inout) :: root(:)
    integer, intent(in) :: i, j
    integer :: a, b, next

    a = root_of(root, i)
    b = root_of(root, j)
    root(max(a, b)) = min(a, b)
    b = min(a, b)
    a = i
    do while (root(a) /= b) ! shorter ways from now on
      next = root(a)
      root(a) = b
      a = next
    end do
    a = j
    do while (root(a) /= b)
      next = root(a)
      root(a) = b
      a = next
    end do
  end subroutine unite

end module scree_cover_input
