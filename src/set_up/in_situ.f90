!> Initial stress from the weight of the ground above each place, and the ratio of horizontal to vertical stress (&in_situ).
!>
!> The vertical stress at a place is that on the ground surface and the weight of the rock between. Under a level surface and over
!> level layers this is in equilibrium with the weight (Jaky 1944 and others for the ratio K0). Its horizontal stress is K0 times
!> the vertical one; there is no shear.
module scree_in_situ
  use scree_block_input, only: blocks_t
  use scree_contacts, only: outlines_t
  use scree_edges_on_lines, only: depth_at
  use scree_kinds, only: dp
  use scree_regions, only: first_vertex_of, last_vertex_of, loops_of, vertices_after
  use scree_scene, only: scene_t
  use scree_sorting, only: sort_by
  use scree_system, only: system_t
  use scree_text, only: short_text
  implicit none
  private
  public :: in_situ_stress, in_situ_text, stress_edges

  real(dp), parameter :: inwards = 1e-9_dp !! of the way to the middle of an element: what is a place within it

contains

  !> Stress xx, yy, xy at a place, tension positive, force/length^2.
  !>
  !> Above the blocks the ground has the weight of the highest block, unless the deck gives one weight for all of it.
  pure function in_situ_stress(scene, blocks, place, material) result(stress)
    type(scene_t), intent(in) :: scene        !! with &in_situ
    type(blocks_t), intent(in) :: blocks
    real(dp), intent(in) :: place(2)          !! in coordinates of the deck, length
    integer, intent(in) :: material           !! block material there
    real(dp) :: stress(3)
    real(dp) :: vertical

    associate (s => scene%settings)
      associate (surface => reshape(s%in_situ_surface, [2, size(s%in_situ_surface)/2]))
        if (s%in_situ_gradient > 0 .or. .not. has_layers(scene, blocks)) then
          vertical = depth_at(surface, place)*merge(s%in_situ_gradient, scene%block_material(material)%unit_weight, &
                                                    s%in_situ_gradient > 0)
        else
          vertical = weight_above(scene, blocks, place - blocks%origin, depth_at(surface, place), material)
        end if
      end associate
      vertical = s%in_situ_pressure + vertical
      stress = -vertical*[s%k0(min(material, size(s%k0))), 1.0_dp, 0.0_dp]
    end associate
  end function in_situ_stress

  !> Notes the stress before the run at both ends of each edge of the outlines, which joints begin with.
  pure subroutine stress_edges(scene, blocks, system, position, outlines)
    type(scene_t), intent(in) :: scene        !! with &in_situ
    type(blocks_t), intent(in) :: blocks
    type(system_t), intent(in) :: system
    real(dp), intent(in) :: position(:, :)    !! (2, n_vertices) at the start, length
    type(outlines_t), intent(inout) :: outlines
    real(dp) :: place(2)
    integer :: i, k

    allocate (outlines%stress(3, 2, size(outlines%start)))
    do i = 1, size(outlines%start)
      associate (e => outlines%element(i), ends => [outlines%start(i), outlines%finish(i)])
        associate (x => position(1, first_vertex_of(system%elements%shape, e):last_vertex_of(system%elements%shape, e)))
          do k = 1, 2
            place = position(:, ends(k))
            place(1) = place(1) + inwards*(sum(x)/size(x) - place(1)) ! so that the rock above it is known
            outlines%stress(:, k, i) = in_situ_stress(scene, blocks, place + system%origin, system%elements%material(e))
          end do
        end associate
      end associate
    end do
  end subroutine stress_edges

  !> The stress of a model in words.
  function in_situ_text(stress) result(text)
    real(dp), intent(in) :: stress(:, :)      !! (3, n_elements) xx, yy, xy, force/length^2
    character(len=:), allocatable :: text

    text = '&in_situ; vertical from '//short_text(maxval(stress(2, :)))//' to '//short_text(minval(stress(2, :)))// &
           ', horizontal from '//short_text(maxval(stress(1, :)))//' to '//short_text(minval(stress(1, :)))
  end function in_situ_text

  !> Whether blocks differ in their unit weight.
  pure logical function has_layers(scene, blocks)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks

    associate (weight => scene%block_material(blocks%material)%unit_weight)
      has_layers = maxval(weight) > minval(weight)
    end associate
  end function has_layers

  !> Weight of the ground above a place, by the blocks that a line upwards crosses, force/length^2.
  pure real(dp) function weight_above(scene, blocks, place, depth, material) result(weight)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    real(dp), intent(in) :: place(2), depth   !! length
    integer, intent(in) :: material           !! of the block at the place
    real(dp), allocatable :: height(:)
    real(dp) :: covered, highest, of_highest, thick
    integer :: b, i, order(size(blocks%vertex, 2))

    weight = 0.0_dp
    covered = 0.0_dp
    highest = place(2)
    of_highest = scene%block_material(material)%unit_weight
    do b = 1, size(blocks%material)
      call heights_of(blocks, b, place(1), height)
      if (size(height) == 0) cycle
      if (maxval(height) <= place(2)) cycle
      order(:size(height)) = [(i, i=1, size(height))]
      call sort_by(height, order(:size(height)))
      height = max(height, place(2))
      thick = sum(height(2::2)) - sum(height(1::2))
      associate (own => scene%block_material(blocks%material(b))%unit_weight)
        weight = weight + own*thick
        if (height(size(height)) > highest) of_highest = own
      end associate
      covered = covered + thick
      highest = max(highest, height(size(height)))
    end do
    weight = weight + of_highest*(depth - covered)
  end function weight_above

  !> Heights at which an upright line crosses the outline of a block; an edge counts with its left end, not its right one, so that
  !> they come in pairs.
  pure subroutine heights_of(blocks, b, x, height)
    type(blocks_t), intent(in) :: blocks
    integer, intent(in) :: b
    real(dp), intent(in) :: x                 !! length
    real(dp), allocatable, intent(out) :: height(:)
    integer, allocatable :: next(:)           ! vertex after each of the block, from its first
    integer :: first, k

    allocate (height(0))
    first = first_vertex_of(blocks%shape, b)
    next = vertices_after(loops_of(blocks%shape, b)) + first - 1
    do k = 1, size(next)
      associate (p => blocks%vertex(:, first + k - 1), q => blocks%vertex(:, next(k)))
        if (p(1) <= x .neqv. q(1) <= x) height = [height, p(2) + (x - p(1))/(q(1) - p(1))*(q(2) - p(2))]
      end associate
    end do
  end subroutine heights_of

end module scree_in_situ
