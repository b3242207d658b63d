!> Blocks to elements and covers.
!>
!> Each block is one element: of the DDA with its own cover, of the NMM with the three covers of one mathematical
!> triangle. That is the block itself where it is a triangle, else the equilateral triangle around the circle
!> that holds the block: the field is affine and its integrals exact, so the choice does not matter.
module scree_cover_input
  use scree_kinds, only: dp
  use scree_regions, only: first_vertex_of, last_vertex_of, regions_t
  use scree_scene, only: model_dda
  use scree_system, only: element_unknowns, elements_t
  implicit none
  private
  public :: cover_blocks

contains

  !> Elements and covers of blocks.
  pure subroutine cover_blocks(model, shape, vertex, material, elements, cover)
    integer, intent(in) :: model                       !! `model_dda` or `model_nmm`
    type(regions_t), intent(in) :: shape               !! of the blocks
    real(dp), intent(in) :: vertex(:, :)               !! (2, n_vertices), length
    integer, intent(in) :: material(:)                 !! (n_blocks)
    type(elements_t), intent(out) :: elements
    real(dp), allocatable, intent(out) :: cover(:, :)  !! (2, n_covers) nodes of the mathematical mesh, none for DDA
    integer :: b, i, n, per_block

    n = size(material)
    per_block = merge(1, 3, model == model_dda)
    elements%shape = shape
    elements%block = [(b, b=1, n)]
    elements%material = material
    elements%cover = reshape([(i, i=1, per_block*n)], [per_block, n])
    elements%unknown = reshape([(i, i=1, element_unknowns*n)], [element_unknowns, n])
    allocate (elements%alone(n), source=.true.)
    if (model == model_dda) then
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
      return
    end if
    centre = 0.5_dp*(minval(polygon, 2) + maxval(polygon, 2))
    radius = sqrt(maxval(sum((polygon - spread(centre, 2, size(polygon, 2)))**2, 1)))
    node = 2*radius*reshape([0.0_dp, 1.0_dp, -half_root_three, -0.5_dp, half_root_three, -0.5_dp], [2, 3]) &
           + spread(centre, 2, 3)
  end function mathematical_triangle

end module scree_cover_input
