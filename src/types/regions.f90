!> Many closed regions in flat arrays.
module scree_regions
  implicit none
  private
  public :: first_vertex_of, joint_between, keep_regions, last_vertex_of, loops_of, region_count, regions_t, take_regions, &
            vertices_after

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

  !> Number of regions.
  pure integer function region_count(regions)
    type(regions_t), intent(in) :: regions

    region_count = size(regions%first_loop) - 1
  end function region_count

  !> Starts of the loops of region `i` among its own vertices, and one past the end.
  pure function loops_of(regions, i) result(first)
    type(regions_t), intent(in) :: regions
    integer, intent(in) :: i
    integer, allocatable :: first(:)

    first = regions%first_vertex(regions%first_loop(i):regions%first_loop(i + 1)) - first_vertex_of(regions, i) + 1
  end function loops_of

  !> The vertex after each vertex, around its loop.
  pure function vertices_after(first) result(next)
    integer, intent(in) :: first(:)  !! (n_loops+1) loop k owns vertices first(k):first(k+1)-1
    integer :: next(first(size(first)) - 1)
    integer :: k, loop

    next = [(k + 1, k=1, size(next))]
    do loop = 1, size(first) - 1
      next(first(loop + 1) - 1) = first(loop)
    end do
  end function vertices_after

  !> Joint material of the edge between two vertices of region `i`, 0 for a seam.
  pure integer function joint_between(regions, i, from, to) result(joint)
    type(regions_t), intent(in) :: regions
    integer, intent(in) :: i, from, to
    integer :: loop, middle, upper

    loop = regions%first_loop(i)
    upper = regions%first_loop(i + 1)
    do while (upper - loop > 1) ! `from` is a vertex of the loops from `loop` to below `upper`
      middle = (loop + upper)/2
      if (from < regions%first_vertex(middle)) then
        upper = middle
      else
        loop = middle
      end if
    end do
    joint = 0
    if (to == from + 1 .and. to < regions%first_vertex(loop + 1)) joint = regions%joint(from)
    if (to == regions%first_vertex(loop) .and. from == regions%first_vertex(loop + 1) - 1) joint = regions%joint(from)
  end function joint_between

  !> Keeps some of the regions; `vertex` gets the numbers of the vertices that stay.
  pure subroutine keep_regions(regions, keep, vertex)
    type(regions_t), intent(inout) :: regions
    logical, intent(in) :: keep(:)                  !! (n)
    integer, allocatable, intent(out) :: vertex(:)
    integer :: i

    call take_regions(regions, pack([(i, i=1, size(keep))], keep), vertex)
  end subroutine keep_regions

  !> Takes the regions of a list, in its order; `vertex` gets the numbers that their vertices had.
  pure subroutine take_regions(regions, list, vertex)
    type(regions_t), intent(inout) :: regions
    integer, intent(in) :: list(:)                  !! (n_taken) each region at most once
    integer, allocatable, intent(out) :: vertex(:)
    type(regions_t) :: taken
    integer :: i, k, n_loops, n_vertices

    allocate (vertex(size(regions%joint)))
    allocate (taken%first_loop(size(list) + 1), taken%first_vertex(size(regions%first_vertex)))
    n_loops = 0
    n_vertices = 0
    do i = 1, size(list)
      taken%first_loop(i) = n_loops + 1
      do k = regions%first_loop(list(i)), regions%first_loop(list(i) + 1) - 1
        n_loops = n_loops + 1
        taken%first_vertex(n_loops) = regions%first_vertex(k) - first_vertex_of(regions, list(i)) + n_vertices + 1
      end do
      do k = first_vertex_of(regions, list(i)), last_vertex_of(regions, list(i))
        n_vertices = n_vertices + 1
        vertex(n_vertices) = k
      end do
    end do
    taken%first_loop(size(list) + 1) = n_loops + 1
    taken%first_vertex(n_loops + 1) = n_vertices + 1
    vertex = vertex(:n_vertices)
    taken%first_vertex = taken%first_vertex(:n_loops + 1)
    taken%joint = regions%joint(vertex)
    regions = taken
  end subroutine take_regions

end module scree_regions
