!> Pieces by which cracks grow, and where such a piece ends: on a side of a triangle of the mesh.
module scree_crack_piece
  use scree_block_finder, only: block_at, block_finder_t
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_regions, only: first_vertex_of, last_vertex_of, loops_of, vertices_after
  implicit none
  private
  public :: find_end, growth_t

  !> Of an edge of the mesh: a piece that would end nearer to a vertex of an element ends in it, as smaller elements would have next
  !> to no stiffness. This turns the piece by at most 1.3 degrees, as it passes a triangle of equal sides.
  real(dp), parameter :: to_vertex = 0.02_dp
  !> Likewise: how far before the tip it is looked which element comes next, and length of a piece that is none. Also the angle,
  !> rad, within which a crack runs along an edge; it leaves the element where the edge ends.
  real(dp), parameter :: ahead = 1e-6_dp

  !> Pieces by which cracks are to grow.
  type :: growth_t
    real(dp), allocatable :: piece(:, :)   !! (4, n) x1 y1 x2 y2, from the tip on, at the start, in coordinates of the model, length
    integer, allocatable :: tip(:)         !! (n) of the model; 0: the crack begins
    integer, allocatable :: number(:)      !! (n) number of the tip
    integer, allocatable :: joint(:)       !! (n) joint material of the faces
  end type growth_t

contains

  !> Finds where a crack that goes on in a direction leaves the next element. It goes to a vertex of that where one is near.
  subroutine find_end(from, direction, edge, block, finder, model, end, is_there)
    real(dp), intent(in) :: from(2)        !! length
    real(dp), intent(in) :: direction(2)   !! of length 1
    real(dp), intent(in) :: edge           !! of the mesh, length
    integer, intent(in) :: block
    type(block_finder_t), intent(in) :: finder !! of the elements at the start
    type(model_t), intent(in) :: model
    real(dp), intent(out) :: end(2)        !! length
    logical, intent(out) :: is_there       !! else no element of the block is ahead
    real(dp), allocatable :: vertex(:, :)
    integer, allocatable :: next(:)
    real(dp) :: a(2), b(2), across, nearest, t, way
    integer :: e, k

    end = from
    is_there = .false.
    e = block_at(finder, model%elements%shape, model%start, from + ahead*edge*direction, model%elements%block, block)
    if (e == 0) return
    vertex = model%start(:, first_vertex_of(model%elements%shape, e):last_vertex_of(model%elements%shape, e))
    next = vertices_after(loops_of(model%elements%shape, e))
    way = huge(way)
    do k = 1, size(next)
      a = vertex(:, k) - from
      b = vertex(:, next(k)) - vertex(:, k)
      across = direction(1)*b(2) - direction(2)*b(1)
      if (.not. abs(across) > ahead*norm2(b)) cycle
      t = (a(1)*b(2) - a(2)*b(1))/across
      if (t < ahead*edge .or. t > way) cycle
      a = a - t*direction ! from the crossing to the beginning of the edge
      if (dot_product(a, b) > ahead*edge*norm2(b) .or. dot_product(a + b, b) < -ahead*edge*norm2(b)) cycle
      way = t
    end do
    if (.not. way < huge(way)) return
    is_there = .true.
    end = from + way*direction
    nearest = to_vertex*edge
    do k = 1, size(next)
      if (norm2(vertex(:, k) - from) <= to_vertex*edge) cycle
      if (norm2(vertex(:, k) - from - way*direction) > nearest) cycle
      nearest = norm2(vertex(:, k) - from - way*direction)
      end = vertex(:, k)
    end do
  end subroutine find_end

end module scree_crack_piece
