!> The mathematical mesh: triangles that hold the model and know nothing of its joints (Shi 1991).
module scree_mathematical_mesh
  use, intrinsic :: iso_fortran_env, only: int64
  use scree_kinds, only: dp
  use scree_mesh, only: mesh_t
  use scree_regions, only: regions_t
  implicit none
  private
  public :: between_triangles, mesh_edges, mesh_regions, regular_mesh, shortest_edge, with_middles

contains

  !> Equilateral triangles that touch a box.
  pure subroutine regular_mesh(edge, origin, angle, low, high, mesh)
    real(dp), intent(in) :: edge              !! length
    real(dp), intent(in) :: origin(2)         !! a node, length
    real(dp), intent(in) :: angle             !! of one family of edges against x, rad
    real(dp), intent(in) :: low(2), high(2)   !! corners of the box, length
    type(mesh_t), intent(out) :: mesh
    real(dp) :: across(2), along(2), corner(2, 4), lattice(2, 4)
    integer, allocatable :: number(:, :)
    integer(int64) :: first(2), i, j, last(2), three(2, 3) ! a scene may lie many edges from its origin
    integer :: k, n_nodes, n_triangles, pass

    along = edge*[cos(angle), sin(angle)]
    across = edge*[cos(angle + acos(0.5_dp)), sin(angle + acos(0.5_dp))]
    corner = reshape([low, high(1), low(2), high, low(1), high(2)], [2, 4])
    do k = 1, 4 ! corner = origin + i along + j across
      associate (x => corner(:, k) - origin, det => along(1)*across(2) - along(2)*across(1))
        lattice(:, k) = [(x(1)*across(2) - x(2)*across(1))/det, (along(1)*x(2) - along(2)*x(1))/det]
      end associate
    end do
    first = floor(minval(lattice, 2), int64) - 1
    last = ceiling(maxval(lattice, 2), int64) + 1
    allocate (number(first(1):last(1), first(2):last(2)), source=0)
    do pass = 1, 2 ! number the nodes of triangles that touch the box, then list
      n_triangles = 0
      do j = first(2), last(2) - 1
        do i = first(1), last(1) - 1
          do k = 1, 2
            three = reshape([i + k - 1, j, i + 1, j + k - 1, i, j + 1], [2, 3])
            if (.not. touches(three)) cycle
            n_triangles = n_triangles + 1
            if (pass == 1) then
              number(three(1, 1), three(2, 1)) = 1
              number(three(1, 2), three(2, 2)) = 1
              number(three(1, 3), three(2, 3)) = 1
            else
              mesh%triangle(:, n_triangles) = [number(three(1, 1), three(2, 1)), number(three(1, 2), three(2, 2)), &
                                               number(three(1, 3), three(2, 3))]
            end if
          end do
        end do
      end do
      if (pass == 2) exit
      n_nodes = 0
      allocate (mesh%node(2, count(number > 0)), mesh%triangle(3, n_triangles))
      do j = first(2), last(2)
        do i = first(1), last(1)
          if (number(i, j) == 0) cycle
          n_nodes = n_nodes + 1
          number(i, j) = n_nodes
          mesh%node(:, n_nodes) = position(i, j)
        end do
      end do
    end do

  contains

    !> A node of the lattice.
    pure function position(i, j)
      integer(int64), intent(in) :: i, j
      real(dp) :: position(2)

      position = origin + i*along + j*across
    end function position

    !> Whether the box around three nodes touches the box.
    pure logical function touches(three)
      integer(int64), intent(in) :: three(2, 3)
      real(dp) :: x(2, 3)
      integer :: k

      do k = 1, 3
        x(:, k) = position(three(1, k), three(2, k))
      end do
      touches = all(minval(x, 2) <= high) .and. all(maxval(x, 2) >= low)
    end function touches

  end subroutine regular_mesh

  !> Pairs of nodes that the edges of the triangles join, each once.
  pure function mesh_edges(mesh) result(edge)
    type(mesh_t), intent(in) :: mesh
    integer, allocatable :: edge(:, :)        !! (2, n)
    integer, allocatable :: of_triangle(:, :)

    call list_edges(mesh, edge, of_triangle)
  end function mesh_edges

  !> Whether each edge, as `mesh_edges` lists them, has one triangle on either side; triangles are counter-clockwise.
  pure function between_triangles(mesh) result(between)
    type(mesh_t), intent(in) :: mesh
    logical, allocatable :: between(:)
    integer, allocatable :: edge(:, :), of_triangle(:, :), beside(:, :)
    integer :: k, side, t

    call list_edges(mesh, edge, of_triangle)
    allocate (beside(2, size(edge, 2)), source=0)
    do t = 1, size(mesh%triangle, 2)
      do k = 1, 3
        associate (i => of_triangle(k, t))
          side = merge(1, 2, mesh%triangle(k, t) == edge(1, i))
          beside(side, i) = beside(side, i) + 1
        end associate
      end do
    end do
    between = all(beside == 1, 1)
  end function between_triangles

  !> The mesh with a node in the middle of each edge, after the others.
  pure type(mesh_t) function with_middles(mesh) result(finer)
    type(mesh_t), intent(in) :: mesh
    integer, allocatable :: edge(:, :), of_triangle(:, :)
    integer :: i, n

    call list_edges(mesh, edge, of_triangle)
    n = size(mesh%node, 2)
    allocate (finer%node(2, n + size(edge, 2)), finer%triangle(6, size(mesh%triangle, 2)))
    finer%node(:, :n) = mesh%node
    do i = 1, size(edge, 2)
      finer%node(:, n + i) = 0.5_dp*(mesh%node(:, edge(1, i)) + mesh%node(:, edge(2, i)))
    end do
    finer%triangle(:3, :) = mesh%triangle
    finer%triangle(4:, :) = n + of_triangle
  end function with_middles

  !> Lists the edges of the triangles, each once, and which a triangle has: from its first node to its second, and so on.
  pure subroutine list_edges(mesh, edge, of_triangle)
    type(mesh_t), intent(in) :: mesh
    integer, allocatable, intent(out) :: edge(:, :)        !! (2, n)
    integer, allocatable, intent(out) :: of_triangle(:, :) !! (3, n_triangles)
    integer :: head(size(mesh%node, 2)), before(3*size(mesh%triangle, 2)), ends(2), i, k, n, t
    integer :: found(2, 3*size(mesh%triangle, 2))

    allocate (of_triangle(3, size(mesh%triangle, 2)))
    head = 0
    n = 0
    do t = 1, size(mesh%triangle, 2)
      do k = 1, 3
        ends = mesh%triangle([k, modulo(k, 3) + 1], t)
        ends = [minval(ends), maxval(ends)]
        i = head(ends(1))
        do while (i > 0)
          if (found(2, i) == ends(2)) exit
          i = before(i)
        end do
        if (i == 0) then
          n = n + 1
          found(:, n) = ends
          before(n) = head(ends(1))
          head(ends(1)) = n
          i = n
        end if
        of_triangle(k, t) = i
      end do
    end do
    edge = found(:, :n)
  end subroutine list_edges

  !> The triangles as regions.
  pure subroutine mesh_regions(mesh, shape, vertex)
    type(mesh_t), intent(in) :: mesh
    type(regions_t), intent(out) :: shape
    real(dp), allocatable, intent(out) :: vertex(:, :) !! (2, 3 n_triangles)
    integer :: i, n

    n = size(mesh%triangle, 2)
    shape%first_loop = [(i, i=1, n + 1)]
    shape%first_vertex = [(3*i - 2, i=1, n + 1)]
    allocate (shape%joint(3*n), source=0)
    vertex = mesh%node(:, reshape(mesh%triangle, [3*n]))
  end subroutine mesh_regions

  !> Length of the shortest edge of all triangles.
  pure real(dp) function shortest_edge(mesh)
    type(mesh_t), intent(in) :: mesh
    integer :: i, k

    shortest_edge = huge(shortest_edge)
    do k = 1, size(mesh%triangle, 2)
      do i = 1, 3
        associate (a => mesh%triangle(i, k), b => mesh%triangle(1 + modulo(i, 3), k))
          shortest_edge = min(shortest_edge, norm2(mesh%node(:, b) - mesh%node(:, a)))
        end associate
      end do
    end do
  end function shortest_edge

end module scree_mathematical_mesh
