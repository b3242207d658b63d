!> Triangles of a mathematical mesh.
module scree_mesh
  use scree_kinds, only: dp
  implicit none
  private
  public :: mesh_t

  !> Triangles between nodes.
  type :: mesh_t
    real(dp), allocatable :: node(:, :)      !! (2, n_nodes), length
    integer, allocatable :: triangle(:, :)   !! (3, n_triangles) nodes, counter-clockwise
  end type mesh_t

end module scree_mesh
