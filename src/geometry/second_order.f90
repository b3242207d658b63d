!> Manifold elements of second order: the weights of their covers, and the cells that they are cut up into.
!>
!> Linear functions on the covers of a triangle make displacements of second order,
!>
!>     u = sum_i w_i [a_i + B_i (x - x_i)] = sum_i w_i a_i + sum_(ij) w_i w_j (B_i - B_j)(x_j - x_i),
!>
!> with w_i the linear weights and (ij) the edges. So 18 numbers describe 12. A B that is the same on all covers, or a turn, B_i =
!> b0 + b1 rot (x_i), has no effect. For each component of u a mesh has three functions too many, whatever its size: as many as a
!> framework of its edges has rigid motions (An, Li, Ma, Zhang 2011 predict such numbers). Here edges have covers of their own
!> besides those of nodes. All have constant functions, the displacements of nodes and of middles of edges, with the weights
!>
!>     w_i (2 w_i - 1),   4 w_i w_j
!>
!> of six-node triangles, which sum up to 1. They hold every field of linear cover functions and are independent, so the equations
!> have full rank.
!>
!> An element of any shape is cut up into triangles, and each of these into six cells. On a cell every quantity has its value at one
!> point. The points are those of the rule that integrates polynomials of degree four (Cowper 1973; Dunavant 1985), and each cell is
!> as large as the weight of its point. Mass, the forces of Green strain and their changes are of degree four, so they equal those
!> of simplex integration (Shi 1984).
module scree_second_order
  use scree_ear_cutting, only: ears_of
  use scree_kinds, only: dp
  use scree_keyholes, only: polygons_of
  use scree_polygon, only: twice_area
  use scree_regions, only: joint_between, regions_t
  use scree_system, only: element_unknowns, elements_t, sampling_t
  implicit none
  private
  public :: cut_into_cells, six_weights

  integer, parameter :: per_triangle = 6 !! cells of a triangle
  integer, parameter :: corners(per_triangle) = [3, 3, 3, 5, 5, 5] !! of each of them
  real(dp), parameter :: root_ten = sqrt(10.0_dp)
  !> Weights of the points over the area: of the three near corners, of the three near the middles of sides.
  real(dp), parameter :: weight(2) = (620 + [-1, 1]*sqrt(213125 - 53320*root_ten))/3720
  !> Their place: of a point near a corner the weights of the two other corners, of one near a side those of its ends.
  real(dp), parameter :: place(2) = (8 - root_ten + [-1, 1]*sqrt(38 - 44*sqrt(0.4_dp)))/18

contains

  !> Weights of the six covers of a triangle at a position, and their gradients.
  pure subroutine six_weights(node, position, value, slope)
    real(dp), intent(in) :: node(2, 3)      !! corners of the triangle, length
    real(dp), intent(in) :: position(2)     !! it may lie outside, length
    real(dp), intent(out) :: value(6)       !! of nodes 1, 2, 3, of edges 1-2, 2-3, 3-1
    real(dp), intent(out) :: slope(2, 6)    !! 1/length
    real(dp) :: a(2), b(2), w(3), g(2, 3), x(2), det
    integer :: i, j

    a = node(:, 2) - node(:, 1)
    b = node(:, 3) - node(:, 1)
    x = position - node(:, 1)
    det = a(1)*b(2) - a(2)*b(1)
    g(:, 2) = [b(2), -b(1)]/det
    g(:, 3) = [-a(2), a(1)]/det
    g(:, 1) = -g(:, 2) - g(:, 3)
    w(2:) = matmul(x, g(:, 2:))
    w(1) = 1 - w(2) - w(3)
    do i = 1, 3
      j = modulo(i, 3) + 1
      value(i) = w(i)*(2*w(i) - 1)
      slope(:, i) = (4*w(i) - 1)*g(:, i)
      value(3 + i) = 4*w(i)*w(j)
      slope(:, 3 + i) = 4*(w(i)*g(:, j) + w(j)*g(:, i))
    end do
  end subroutine six_weights

  !> Cuts elements up into cells, which become the elements. Each point gets one more of its own, without area.
  subroutine cut_into_cells(cover, point, elements, vertex, carrier, sampling)
    real(dp), intent(in) :: cover(:, :)                   !! (2, n_covers) nodes and middles of edges, length
    real(dp), intent(in) :: point(:, :)                   !! (2, n_points) length
    type(elements_t), intent(inout) :: elements           !! on six covers, block after block
    real(dp), allocatable, intent(inout) :: vertex(:, :)  !! (2, n_vertices) of the elements
    integer, intent(inout) :: carrier(:)                  !! (n_points) element that carries each point
    type(sampling_t), intent(out) :: sampling
    type(elements_t) :: cell
    real(dp), allocatable :: at(:, :)
    integer, allocatable :: triangle(:, :), first(:), element_of(:)
    integer :: c, e, first_cell(size(elements%block)), i, of_point(size(carrier)), v

    call cut_into_triangles(elements%shape, vertex, first, triangle)
    call make_room(per_triangle*size(triangle, 2) + size(carrier), sum(corners)*size(triangle, 2) + 3*size(carrier))
    of_point = carrier
    c = 0
    v = 0
    do e = 1, size(elements%block)
      first_cell(e) = c + 1
      do i = first(e), first(e + 1) - 1
        call cut_triangle(triangle(:, i))
      end do
      if (e < size(elements%block)) then
        if (elements%block(e + 1) == elements%block(e)) cycle
      end if
      do i = 1, size(carrier) ! behind the other cells of its block
        if (elements%block(of_point(i)) /= elements%block(e)) cycle
        call add_cell(of_point(i), point(:, i), 0.0_dp, spread(point(:, i), 2, 3), [0, 0, 0])
        carrier(i) = c
      end do
    end do
    cell%block = elements%block(element_of)
    cell%material = elements%material(element_of)
    cell%cover = elements%cover(:, element_of)
    cell%linked = first_cell(elements%linked(element_of))
    cell%unknown = reshape([(i, i=1, element_unknowns*c)], [element_unknowns, c]) + 2*size(cover, 2)
    call move_alloc(at, vertex)
    elements = cell

  contains

    !> Makes room for so many cells and their vertices.
    subroutine make_room(n_cells, n_vertices)
      integer, intent(in) :: n_cells, n_vertices

      allocate (element_of(n_cells), sampling%value(6, n_cells), sampling%slope(2, 6, n_cells), sampling%area(n_cells))
      allocate (at(2, n_vertices), sampling%at_vertex(6, n_vertices), cell%shape%joint(n_vertices))
      allocate (cell%shape%first_vertex(n_cells + 1))
      cell%shape%first_vertex(1) = 1
      cell%shape%first_loop = [(i, i=1, n_cells + 1)]
    end subroutine make_room

    !> Cuts a triangle of element `e` up: a triangle at each corner, and what is left in three parts, one at each side.
    subroutine cut_triangle(number)
      integer, intent(in) :: number(3)   !! vertices of the element at its corners
      real(dp) :: x(2, 3), area, middle(2), near(2, 3)
      real(dp), parameter :: s = sqrt(weight(1)) !! side of a corner over that of the triangle
      integer :: joint(3), k, l, m

      x = vertex(:, number)
      area = 0.5_dp*twice_area(x)
      middle = sum(x, 2)/3
      do k = 1, 3
        l = modulo(k, 3) + 1
        joint(k) = joint_between(elements%shape, e, number(k), number(l))
        near(:, k) = (1 - s)*x(:, k) + s*(sum(x, 2) - x(:, k))/2
      end do
      do k = 1, 3
        l = modulo(k, 3) + 1
        m = modulo(l, 3) + 1
        call add_cell(e, (1 - 3*place(1))*x(:, k) + place(1)*sum(x, 2), weight(1)*area, &
                      reshape([x(:, k), x(:, k) + s*(x(:, l) - x(:, k)), x(:, k) + s*(x(:, m) - x(:, k))], [2, 3]), &
                      [joint(k), 0, joint(m)])
      end do
      do k = 1, 3
        l = modulo(k, 3) + 1
        m = modulo(l, 3) + 1
        call add_cell(e, (1 - 3*place(2))*x(:, m) + place(2)*sum(x, 2), weight(2)*area, &
                      reshape([x(:, k) + s*(x(:, l) - x(:, k)), x(:, l) + s*(x(:, k) - x(:, l)), near(:, l), middle, &
                               near(:, k)], [2, 5]), [joint(k), 0, 0, 0, 0])
      end do
    end subroutine cut_triangle

    !> Adds a cell of an element.
    subroutine add_cell(of, position, area, corner, joint)
      integer, intent(in) :: of                 !! element
      real(dp), intent(in) :: position(2), area !! of its point
      real(dp), intent(in) :: corner(:, :)      !! (2, n)
      integer, intent(in) :: joint(:)           !! (n) joint material of the edge to the next corner
      real(dp) :: slope(2, 6)
      integer :: k

      c = c + 1
      element_of(c) = of
      sampling%area(c) = area
      associate (node => cover(:, elements%cover(:3, of)))
        call six_weights(node, position, sampling%value(:, c), sampling%slope(:, :, c))
        do k = 1, size(joint)
          v = v + 1
          at(:, v) = corner(:, k)
          cell%shape%joint(v) = joint(k)
          call six_weights(node, corner(:, k), sampling%at_vertex(:, v), slope)
        end do
      end associate
      cell%shape%first_vertex(c + 1) = v + 1
    end subroutine add_cell

  end subroutine cut_into_cells

  !> Cuts polygons up into triangles: element e has the triangles first(e) to first(e+1)-1.
  subroutine cut_into_triangles(shape, vertex, first, triangle)
    type(regions_t), intent(in) :: shape
    real(dp), intent(in) :: vertex(:, :)                  !! (2, n_vertices) length
    integer, allocatable, intent(out) :: first(:)         !! (n_elements+1)
    integer, allocatable, intent(out) :: triangle(:, :)   !! (3, n) vertices, counter-clockwise
    integer, allocatable :: corner(:), ears(:, :), first_corner(:)
    integer :: all_of_them(3, 3*size(shape%joint)), e, k, n

    call polygons_of(shape, vertex, first_corner, corner)
    allocate (first(size(first_corner)))
    n = 0
    do e = 1, size(first) - 1
      first(e) = n + 1
      associate (own => corner(first_corner(e):first_corner(e + 1) - 1))
        ears = ears_of(vertex(:, own))
        do k = 1, size(ears, 2)
          all_of_them(:, n + k) = own(ears(:, k))
        end do
      end associate
      n = n + size(ears, 2)
    end do
    first(size(first)) = n + 1
    triangle = all_of_them(:, :n)
  end subroutine cut_into_triangles

end module scree_second_order
