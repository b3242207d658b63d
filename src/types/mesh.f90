!> Triangles of a mathematical mesh.
module scree_mesh
  use scree_kinds, only: dp
  implicit none
  private
  public :: mesh_t

  !> Triangles between nodes.
  type :: mesh_t
    real(dp), allocatable :: node(:, :)      !! (2, n_nodes), length
    integer, allocatable :: triangle(:, :)   !! (3, n_triangles) nodes, counter-clockwise; or (6, n_triangles), with the
                                             !! middles of edges 1-2, 2-3 and 3-1
  end type mesh_t

end module scree_mesh
