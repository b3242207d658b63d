!> The polygons of frames: which vertices an element has, its block and its material, the joints along its edges.
module scree_frame_layout
  use scree_kinds, only: dp
  implicit none
  private

  public :: layout_parts, layout_rows, layout_t, part_block, part_corners, part_parent, part_types, units_of_part, words_of_part

  integer, parameter :: vtk_polygon = 7

  !> Polygons of the frames: element i has the vertices corner(first(i):first(i+1)-1), counter-clockwise.
  type :: layout_t
    integer :: n_vertices = 0
    integer, allocatable :: first(:)        !! (n_elements+1)
    integer, allocatable :: corner(:)       !! one with holes comes to some vertices twice
    integer, allocatable :: block(:)        !! (n_elements)
    integer, allocatable :: material(:)     !! (n_elements)
    integer, allocatable :: parent(:)       !! (n_elements) element of the layout before that each is part of, where layouts change
    integer, allocatable :: joint(:)        !! (n_corners) joint material of the edge from each to the next, 0: a line of the mesh
    logical :: changes = .false.            !! cracks may grow, so that frames have other polygons
    integer :: expected_frames = 1
    integer :: expected_steps = 1
  end type layout_t

  !> Datasets of a layout. Where layouts change, each is a series with rows for each layout.
  character(len=*), parameter :: layout_parts(10) = [character(len=31) :: '/VTKHDF/NumberOfPoints', '/VTKHDF/NumberOfCells', &
    '/VTKHDF/NumberOfConnectivityIds', '/VTKHDF/Connectivity', '/VTKHDF/Offsets', '/VTKHDF/Types', '/VTKHDF/CellData/block', &
    '/VTKHDF/CellData/material', '/elements/joint', '/elements/parent']
  integer, parameter :: part_corners = 4, part_types = 6, part_block = 7, part_joint = 9, part_parent = 10

contains

  !> The rows of a part of a layout.
  pure function layout_rows(layout, part) result(rows)
    type(layout_t), intent(in) :: layout
    integer, intent(in) :: part              !! of `layout_parts`
    real(dp), allocatable :: rows(:)
    integer :: i

    select case (part)
    case (1)
      rows = [real(layout%n_vertices, dp)]
    case (2)
      rows = [real(size(layout%block), dp)]
    case (3)
      rows = [real(size(layout%corner), dp)]
    case (part_corners)
      rows = real(layout%corner - 1, dp)
    case (5)
      rows = real(layout%first - 1, dp)
    case (part_types)
      rows = [(real(vtk_polygon, dp), i=1, size(layout%block))]
    case (part_block)
      rows = real(layout%block, dp)
    case (8)
      rows = real(layout%material, dp)
    case (part_joint)
      rows = real(layout%joint, dp)
    case default
      rows = real(layout%parent, dp)
    end select
  end function layout_rows

  !> Unit of a part of a layout.
  pure function units_of_part(part) result(units)
    integer, intent(in) :: part              !! of `layout_parts`
    character(len=:), allocatable :: units

    units = ''
    if (part == part_joint .or. part == part_parent) units = '1'
  end function units_of_part

  !> Description of a part of a layout, where VTK does not give it.
  pure function words_of_part(part) result(words)
    integer, intent(in) :: part              !! of `layout_parts`
    character(len=:), allocatable :: words

    words = ''
    if (part == part_joint) words = 'joint material of the edge from each vertex to the next, 0: a line of the mesh'
    if (part == part_parent) words = 'element of the layout before that each is part of, from 1'
  end function words_of_part

end module scree_frame_layout
