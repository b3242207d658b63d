!> Many closed regions in flat arrays.
module scree_regions
  implicit none
  private
  public :: first_vertex_of, last_vertex_of, regions_t

  !> Regions made of loops: the outer loop of a region first and counter-clockwise, its holes clockwise
  !> (Shi: d and k0). The vertices of a region are consecutive.
  type :: regions_t
    integer, allocatable :: first_loop(:)   !! (n+1) region i owns loops first_loop(i):first_loop(i+1)-1
    integer, allocatable :: first_vertex(:) !! (n_loops+1) loop j owns vertices first_vertex(j):first_vertex(j+1)-1
    integer, allocatable :: joint(:)        !! (n_vertices) joint material of the edge to the next vertex
  end type regions_t

contains

  !> First vertex of region `i`.
  pure integer function first_vertex_of(regions, i)
    type(regions_t), intent(in) :: regions
    integer, intent(in) :: i

    first_vertex_of = regions%first_vertex(regions%first_loop(i))
  end function first_vertex_of

  !> Last vertex of region `i`, its holes included.
  pure integer function last_vertex_of(regions, i)
    type(regions_t), intent(in) :: regions
    integer, intent(in) :: i

    last_vertex_of = regions%first_vertex(regions%first_loop(i + 1)) - 1
  end function last_vertex_of

end module scree_regions
