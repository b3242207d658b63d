!> Nodes of the mathematical mesh at the tips of drawn cracks.
!>
!> Around a crack that ends in a node, linear triangles are too stiff. Far from the tip, their field is that of a crack that ends
!> about 0.3 sides of a triangle before the node. Where cracks grow, a drawn crack therefore goes on to a node that stands so far
!> beyond its end.
module scree_tip_seats
  use scree_block_input, only: blocks_t
  use scree_crack_tip, only: short_of_end
  use scree_kinds, only: dp
  use scree_mesh, only: mesh_t
  use scree_polygon, only: twice_area
  use scree_regions, only: first_vertex_of, loops_of, vertices_after
  use scree_scene, only: scene_t
  implicit none
  private
  public :: put_nodes, seat_tips, side_at

  real(dp), parameter :: clear_sides = 1.0_dp    !! of a triangle, between the node and what the crack runs toward
  real(dp), parameter :: least_share = 0.25_dp   !! of its area that a triangle keeps; one of equal sides keeps a third
  real(dp), parameter :: same = 1e-9_dp          !! of the size of the model: places that are nearer to each other are one

contains

  !> Lets drawn cracks go on to where nodes will be, and notes these places. A crack that is about to meet a face stays as drawn.
  subroutine seat_tips(scene, blocks)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(inout) :: blocks
    real(dp), allocatable :: faces(:, :, :)
    real(dp) :: along(2), end(2), side
    integer :: i, k

    if (.not. (allocated(scene%mesh) .or. scene%settings%cover_edge > 0)) return
    allocate (blocks%seat(2, 0))
    faces = faces_of(blocks)
    do i = 1, size(blocks%crack, 3)
      do k = 1, 2
        end = blocks%crack(:, k, i)
        if (count(norm2(blocks%crack(:, 1, :) - spread(end, 2, size(blocks%crack, 3)), 1) <= same*scene%extent) &
            + count(norm2(blocks%crack(:, 2, :) - spread(end, 2, size(blocks%crack, 3)), 1) <= same*scene%extent) > 1) cycle
        along = end - blocks%crack(:, 3 - k, i)
        along = along/norm2(along)
        side = side_at(scene, end + blocks%origin)
        if (way_to(faces, size(blocks%vertex, 2) + i, end - same*scene%extent*along, along) &
            < (short_of_end + clear_sides)*side) cycle ! also on an outline
        blocks%crack(:, k, i) = end + short_of_end*side*along
        blocks%seat = reshape([blocks%seat, blocks%crack(:, k, i)], [2, size(blocks%seat, 2) + 1])
      end do
    end do
  end subroutine seat_tips

  !> Moves the nearest nodes of a mesh to places. A node on the outline of the mesh stays, and one whose triangles would be slivers.
  pure subroutine put_nodes(seat, mesh)
    real(dp), intent(in) :: seat(:, :)       !! (2, n), length
    type(mesh_t), intent(inout) :: mesh
    real(dp), allocatable :: after(:), before(:)
    real(dp) :: was(2)
    integer, allocatable :: star(:)
    integer :: i, node, t

    do i = 1, size(seat, 2)
      node = minloc(norm2(mesh%node - spread(seat(:, i), 2, size(mesh%node, 2)), 1), 1)
      star = pack([(t, t=1, size(mesh%triangle, 2))], any(mesh%triangle == node, 1))
      before = areas_of(star)
      was = mesh%node(:, node)
      mesh%node(:, node) = seat(:, i)
      after = areas_of(star)
      if (any(after < least_share*before) .or. abs(sum(after) - sum(before)) > same*sum(before)) mesh%node(:, node) = was
    end do

  contains

    !> Twice the areas of triangles, length^2.
    pure function areas_of(list)
      integer, intent(in) :: list(:)
      real(dp) :: areas_of(size(list))
      integer :: k

      areas_of = [(twice_area(mesh%node(:, mesh%triangle(:3, list(k)))), k=1, size(list))]
    end function areas_of

  end subroutine put_nodes

  !> The edges of all blocks and the pieces of all cracks: (xy, end, n), length.
  pure function faces_of(blocks) result(faces)
    type(blocks_t), intent(in) :: blocks
    real(dp), allocatable :: faces(:, :, :)
    integer, allocatable :: next(:)          ! vertex after each of a block, from its first
    integer :: b, before, i

    allocate (faces(2, 2, size(blocks%vertex, 2) + size(blocks%crack, 3)))
    do b = 1, size(blocks%material)
      before = first_vertex_of(blocks%shape, b) - 1
      next = vertices_after(loops_of(blocks%shape, b))
      do i = 1, size(next)
        faces(:, :, before + i) = blocks%vertex(:, before + [i, next(i)])
      end do
    end do
    faces(:, :, size(blocks%vertex, 2) + 1:) = blocks%crack
  end function faces_of

  !> Way from a place in a direction to the nearest face, length; huge where there is none.
  pure real(dp) function way_to(faces, own, from, along)
    real(dp), intent(in) :: faces(:, :, :)   !! (xy, end, n) length
    integer, intent(in) :: own               !! that does not count
    real(dp), intent(in) :: from(2)          !! length
    real(dp), intent(in) :: along(2)         !! of length 1
    real(dp) :: a(2), across, b(2), share, way
    integer :: i

    way_to = huge(way_to)
    do i = 1, size(faces, 3)
      a = faces(:, 1, i) - from
      b = faces(:, 2, i) - faces(:, 1, i)
      across = along(1)*b(2) - along(2)*b(1)
      if (i == own .or. .not. abs(across) > 0) cycle
      way = (a(1)*b(2) - a(2)*b(1))/across
      share = (a(1)*along(2) - a(2)*along(1))/across
      if (way >= 0 .and. share >= 0 .and. share <= 1) way_to = min(way_to, way)
    end do
  end function way_to

  !> Side of the triangles of the mesh at a place, length: of a file, the mean side of the triangle whose middle is nearest.
  pure real(dp) function side_at(scene, place) result(side)
    type(scene_t), intent(in) :: scene
    real(dp), intent(in) :: place(2)         !! length
    real(dp) :: distance, nearest
    integer :: t

    side = scene%settings%cover_edge
    if (.not. allocated(scene%mesh)) return
    nearest = huge(nearest)
    do t = 1, size(scene%mesh%triangle, 2)
      associate (x => scene%mesh%node(:, scene%mesh%triangle(:3, t)))
        distance = norm2(sum(x, 2)/3 - place)
        if (distance < nearest) side = sum(norm2(x - x(:, [2, 3, 1]), 1))/3
        nearest = min(nearest, distance)
      end associate
    end do
  end function side_at

end module scree_tip_seats
