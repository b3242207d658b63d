!> Points that blocks carry, as they are found.
module scree_carried_points
  use scree_block_finder, only: distance_outside
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_kinds, only: dp
  use scree_regions, only: first_vertex_of, last_vertex_of, regions_t
  use scree_text, only: number_text, real_text
  implicit none
  private
  public :: add_point, check_inside, found_points_t, region_size

  !> Points this fraction of the scale outside all blocks belong to the nearest (Shi: of a vertex); points whose block is given,
  !> this fraction of its size outside, to that.
  real(dp), parameter, public :: near_blocks = 1e-5_dp

  !> Points as they are found.
  type :: found_points_t
    integer :: n = 0
    integer, allocatable :: kind(:), block(:)
    real(dp), allocatable :: position(:, :)
  end type found_points_t

contains

  !> Adds one point.
  pure subroutine add_point(points, kind, position, block)
    type(found_points_t), intent(inout) :: points
    integer, intent(in) :: kind, block
    real(dp), intent(in) :: position(2)

    if (points%n == size(points%kind)) then
      points%kind = [points%kind, points%kind]
      points%block = [points%block, points%block]
      points%position = reshape([points%position, points%position], [2, 2*points%n])
    end if
    points%n = points%n + 1
    points%kind(points%n) = kind
    points%block(points%n) = block
    points%position(:, points%n) = position
  end subroutine add_point

  !> Error where a place is not in a block, nor beside it.
  subroutine check_inside(shape, vertex, b, position, what, source, error)
    type(regions_t), intent(in) :: shape
    real(dp), intent(in) :: vertex(:, :)    !! (2, n_vertices), length
    integer, intent(in) :: b
    real(dp), intent(in) :: position(2)     !! length
    character(len=*), intent(in) :: what, source
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: distance

    distance = distance_outside(shape, vertex, b, position)
    if (distance > near_blocks*region_size(shape, vertex, b)) &
      call fail(error, status_bad_input, source//': expected '//what//' in its block '//number_text(b)//' or within '// &
                real_text(near_blocks)//' of its size, found one '//real_text(distance)//' outside')
  end subroutine check_inside

  !> Larger side of the box around a region, length.
  pure real(dp) function region_size(shape, vertex, b)
    type(regions_t), intent(in) :: shape
    real(dp), intent(in) :: vertex(:, :)    !! (2, n_vertices), length
    integer, intent(in) :: b

    associate (own => vertex(:, first_vertex_of(shape, b):last_vertex_of(shape, b)))
      region_size = maxval(maxval(own, 2) - minval(own, 2))
    end associate
  end function region_size

end module scree_carried_points
