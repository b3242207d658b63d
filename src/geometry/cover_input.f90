!> Blocks to elements and covers (Shi's mc).
!>
!> A block of the DDA is one element with its own cover. In the NMM a mathematical mesh lies over the blocks. The regions that a
!> triangle has in common with a block are manifold elements: one or more polygons of any shape. The elements of the triangles of a
!> node fall into connected parts, and each part is a physical cover.
!>
!> Without a mesh each block is one element on three covers of its own. They are those of the block where it is a triangle and no
!> sliver, else those of the equilateral triangle around the circle that holds it. The field is affine and its integrals are exact,
!> so the choice does not matter.
module scree_cover_input
  use scree_block_input, only: blocks_t
  use scree_errors, only: error_t
  use scree_face_cutting, only: cut_faces, cut_faces_t
  use scree_kinds, only: dp
  use scree_mathematical_mesh, only: with_middles
  use scree_mesh, only: mesh_t
  use scree_polygon, only: twice_area
  use scree_regions, only: first_vertex_of, last_vertex_of, regions_t
  use scree_second_order, only: six_weights
  use scree_sets, only: root_of, unite
  use scree_system, only: element_unknowns, elements_t, extension_t
  use scree_tip_seats, only: put_nodes
  implicit none
  private
  public :: cover_blocks, cover_quality_t, cover_with_mesh, covered_t

  real(dp), parameter :: no_sliver = 0.2_dp !! twice the area over the longest edge squared; 0.87 for equal edges
  real(dp), parameter :: as_near = 1e-9_dp  !! lengths and shares that differ by less are the same

  !> Result of the cut of the mesh.
  type :: cover_quality_t
    integer :: small = 0                !! elements below the least fraction of their triangle
    integer :: extended = 0             !! covers that follow others
    real(dp) :: least_share = 1.0_dp    !! smallest area of an element over that of its triangle
    real(dp) :: farthest = 0.0_dp       !! largest weight of an extension
    integer :: uncovered = 0            !! blocks that the mesh does not hold
  end type cover_quality_t

  !> Blocks under a mathematical mesh.
  type :: covered_t
    type(elements_t) :: elements
    real(dp), allocatable :: vertex(:, :)        !! (2, n) vertices of the elements, length
    real(dp), allocatable :: cover(:, :)         !! (2, n_covers) nodes of the covers, length
    type(extension_t), allocatable :: extension  !! where covers follow others
    real(dp), allocatable :: torn(:)             !! (2) a place where the mesh does not hold together; then nothing is covered
    type(cover_quality_t) :: quality
  end type covered_t

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
    elements%linked = [(b, b=1, n)]
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
  !> A cover whose elements all have less than `least_share` of their triangles is too small to stand on its own. Its stiffness and
  !> mass go to zero with the area, and the condition number of the equations grows without bound (the small-cut problem). The cover
  !> follows the nearest element that is large enough: the linear field of that element, extended to the node (aggregation; Badia,
  !> Verdugo, Martin 2018). The remaining fields hold every linear field and stay continuous, so nothing else changes. Covers of
  !> second order are those of nodes and of edges. They follow the extended field of second order.
  subroutine cover_with_mesh(blocks, mesh, least_share, second_order, covered, error)
    type(blocks_t), intent(in) :: blocks
    type(mesh_t), intent(in) :: mesh       !! in the coordinates of the blocks, as it is laid
    real(dp), intent(in) :: least_share    !! 0: every cover stands on its own
    logical, intent(in) :: second_order
    type(covered_t), intent(out) :: covered
    type(error_t), allocatable, intent(out) :: error
    type(cut_faces_t) :: faces
    type(mesh_t) :: seated                 !! with nodes at tips of cracks

    seated = mesh
    if (allocated(blocks%seat)) call put_nodes(blocks%seat, seated)
    call cut_faces(blocks, seated, faces, covered%quality%uncovered, error)
    if (allocated(error) .or. covered%quality%uncovered > 0) return
    if (allocated(faces%torn)) then
      covered%torn = faces%torn
      return
    end if
    if (second_order) then
      call connect_faces(with_middles(seated), faces, covered%elements, covered%cover)
    else
      call connect_faces(seated, faces, covered%elements, covered%cover)
    end if
    covered%elements%material = blocks%material(faces%block)
    covered%vertex = faces%vertex
    call extend_covers(faces, least_share, covered%cover, covered%elements, covered%extension)
    associate (quality => covered%quality)
      quality%least_share = minval(faces%share)
      quality%small = count(faces%share < least_share)
      if (.not. allocated(covered%extension)) return
      quality%extended = size(covered%extension%cover)
      quality%farthest = maxval(abs(covered%extension%weight))
    end associate
  end subroutine cover_with_mesh

  !> Physical covers: corners of elements that are one node of the mesh are one cover where the elements are connected
  !> around it. So are middles of edges.
  pure subroutine connect_faces(mesh, faces, elements, cover)
    type(mesh_t), intent(in) :: mesh
    type(cut_faces_t), intent(in) :: faces
    type(elements_t), intent(out) :: elements
    real(dp), allocatable, intent(out) :: cover(:, :)
    integer, dimension(size(mesh%triangle, 1)*size(faces%block)) :: root, number, user
    integer :: f, g, i, k, l, m, n

    m = size(mesh%triangle, 1)
    n = size(faces%block)
    root = [(i, i=1, m*n)]
    do i = 1, size(faces%neighbours, 2)
      f = faces%neighbours(1, i)
      g = faces%neighbours(2, i)
      do k = 1, m
        do l = 1, m
          if (mesh%triangle(k, faces%triangle(f)) == mesh%triangle(l, faces%triangle(g))) &
            call unite(root, m*(f - 1) + k, m*(g - 1) + l)
        end do
      end do
    end do
    elements%shape = faces%shape
    elements%block = faces%block
    allocate (elements%cover(m, n), elements%unknown(2*m, n))
    number = 0
    elements%linked = [(f, f=1, n)]
    l = 0
    do f = 1, n
      do k = 1, m
        i = root_of(root, m*(f - 1) + k)
        if (number(i) == 0) then
          l = l + 1
          number(i) = l
          user(l) = f
        end if
        elements%cover(k, f) = number(i)
        call unite(elements%linked, f, user(number(i)))
        elements%unknown(2*k - 1:2*k, f) = [2*number(i) - 1, 2*number(i)]
      end do
    end do
    allocate (cover(2, l))
    do f = 1, n
      cover(:, elements%cover(:, f)) = mesh%node(:, mesh%triangle(:, faces%triangle(f)))
    end do
    elements%linked = [(root_of(elements%linked, f), f=1, n)]
  end subroutine connect_faces

  !> Lets covers without an element of the least fraction follow the nearest large element.
  !>
  !> Distance is counted in steps across lines of the mesh. Of elements at one distance the one is taken whose triangle has its
  !> middle nearest to the cover. In a part of a block without a large element the largest element is taken.
  subroutine extend_covers(faces, least_share, cover, elements, extension)
    type(cut_faces_t), intent(in) :: faces
    real(dp), intent(in) :: least_share
    real(dp), intent(in) :: cover(:, :)
    type(elements_t), intent(inout) :: elements
    type(extension_t), allocatable, intent(out) :: extension
    logical :: large(size(faces%block)), stands(size(cover, 2))
    real(dp) :: middle(2, size(faces%block)), slope(2, 6)
    integer :: leader(size(faces%block)), ring(size(faces%block)), by(size(cover, 2)), c, f, i, k

    if (all(faces%share >= least_share)) return
    large = stand_alone(faces, least_share)
    stands = .false.
    do f = 1, size(large)
      middle(:, f) = sum(cover(:, elements%cover(:3, f)), 2)/3
      if (large(f)) stands(elements%cover(:, f)) = .true.
    end do
    if (all(stands)) return
    call find_leaders(faces, large, middle, leader, ring)
    by = 0
    do f = 1, size(large)
      do k = 1, size(elements%cover, 1)
        c = elements%cover(k, f)
        if (stands(c)) cycle
        if (by(c) > 0) then
          if (ring(f) > ring(by(c))) cycle
          if (ring(f) == ring(by(c)) .and. .not. leads_better(faces, middle, cover(:, c), leader(f), leader(by(c)))) cycle
        end if
        by(c) = f
      end do
    end do
    allocate (extension)
    allocate (extension%cover(count(.not. stands)), extension%master(size(elements%cover, 1), count(.not. stands)), &
              extension%weight(size(elements%cover, 1), count(.not. stands)))
    i = 0
    do c = 1, size(stands)
      if (stands(c)) cycle
      i = i + 1
      associate (follows => elements%cover(:, leader(by(c))))
        extension%cover(i) = c
        extension%master(:, i) = follows
        if (size(follows) == 6) then
          call six_weights(cover(:, follows(:3)), cover(:, c), extension%weight(:, i), slope)
        else
          extension%weight(:, i) = weights(cover(:, follows), cover(:, c))
        end if
      end associate
      call unite(elements%linked, by(c), leader(by(c)))
    end do
    elements%linked = [(root_of(elements%linked, f), f=1, size(large))]
  end subroutine extend_covers

  !> Whether a position follows face a rather than b: the middle of its triangle is nearer, or as near, and its share is larger.
  pure logical function leads_better(faces, middle, position, a, b)
    type(cut_faces_t), intent(in) :: faces
    real(dp), intent(in) :: middle(:, :)   !! (2, n) of the triangle of each face, length
    real(dp), intent(in) :: position(2)    !! length
    integer, intent(in) :: a, b
    real(dp) :: to_a, to_b

    to_a = norm2(middle(:, a) - position)
    to_b = norm2(middle(:, b) - position)
    leads_better = to_a < to_b
    if (abs(to_a - to_b) <= as_near*to_b) leads_better = faces%share(a) > (1 + as_near)*faces%share(b)
  end function leads_better

  !> Faces that others may follow: those of the least fraction; of a part of a block that has none, its largest.
  pure function stand_alone(faces, least_share) result(large)
    type(cut_faces_t), intent(in) :: faces
    real(dp), intent(in) :: least_share
    logical :: large(size(faces%block))
    integer :: best(size(faces%block)), part(size(faces%block)), f, g, i

    large = faces%share >= least_share
    part = [(f, f=1, size(part))]
    do i = 1, size(faces%neighbours, 2)
      call unite(part, faces%neighbours(1, i), faces%neighbours(2, i))
    end do
    best = 0
    do f = 1, size(part)
      g = root_of(part, f)
      if (best(g) == 0) best(g) = f
      if (faces%share(f) > faces%share(best(g))) best(g) = f
    end do
    do f = 1, size(part)
      if (best(f) > 0) large(best(f)) = .true.
    end do
  end function stand_alone

  !> The nearest large face of each, by steps across lines of the mesh, of those as near the one that leads better; and the steps.
  pure subroutine find_leaders(faces, large, middle, leader, ring)
    type(cut_faces_t), intent(in) :: faces
    logical, intent(in) :: large(:)        !! (n)
    real(dp), intent(in) :: middle(:, :)   !! (2, n) of the triangle of each face, length
    integer, intent(out) :: leader(:)      !! (n)
    integer, intent(out) :: ring(:)        !! (n)
    integer :: first(size(large) + 1), to(2*size(faces%neighbours, 2)), queue(size(large)), f, g, head, i, tail

    call list_neighbours(faces%neighbours, first, to)
    ring = merge(0, huge(1), large)
    leader = merge([(f, f=1, size(large))], 0, large)
    tail = count(large)
    queue(:tail) = pack([(f, f=1, size(large))], large)
    head = 0
    do while (head < tail) ! ring by ring
      head = head + 1
      f = queue(head)
      do i = first(f), first(f + 1) - 1
        g = to(i)
        if (ring(g) <= ring(f)) cycle
        if (leader(g) == 0) then
          ring(g) = ring(f) + 1
          leader(g) = leader(f)
          tail = tail + 1
          queue(tail) = g
        else if (leads_better(faces, middle, middle(:, g), leader(f), leader(g))) then
          leader(g) = leader(f)
        end if
      end do
    end do
  end subroutine find_leaders

  !> Neighbours of each face, from pairs of neighbours.
  pure subroutine list_neighbours(pairs, first, to)
    integer, intent(in) :: pairs(:, :)     !! (2, m)
    integer, intent(out) :: first(:)       !! (n+1) face f has the neighbours to(first(f):first(f+1)-1)
    integer, intent(out) :: to(:)          !! (2 m)
    integer :: at(size(first) - 1), j, pair

    first = 0
    do pair = 1, size(pairs, 2)
      do j = 1, 2
        first(pairs(j, pair) + 1) = first(pairs(j, pair) + 1) + 1
      end do
    end do
    first(1) = 1
    do j = 1, size(at)
      first(j + 1) = first(j + 1) + first(j)
    end do
    at = first(:size(at))
    do pair = 1, size(pairs, 2)
      do j = 1, 2
        to(at(pairs(j, pair))) = pairs(3 - j, pair)
        at(pairs(j, pair)) = at(pairs(j, pair)) + 1
      end do
    end do
  end subroutine list_neighbours

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

end module scree_cover_input
