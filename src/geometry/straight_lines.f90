!> The lines of a cut that no node may bend: the boundary of the rock, and lines on which something is held or loaded.
module scree_straight_lines
  use scree_cell_grid, only: cell_grid_t, cells_of_box, number_of_cell, place_segments, set_up_grid
  use scree_kinds, only: dp
  implicit none
  private
  public :: drop_perpendicular, list_straight_lines, nearest_straight_line, straight_lines_t

  !> Straight lines, listed by cell.
  type :: straight_lines_t
    real(dp), allocatable :: ends(:, :, :)  !! (xy, end, n), length
    type(cell_grid_t) :: grid
  end type straight_lines_t

contains

  !> Lists the straight lines among all lines, so that the line within a distance of a position is found at once.
  pure subroutine list_straight_lines(ends, straight, within, lines)
    real(dp), intent(in) :: ends(:, :, :)   !! (xy, end, n_lines), length
    logical, intent(in) :: straight(:)      !! (n_lines)
    real(dp), intent(in) :: within          !! the largest distance that will be asked for, length
    type(straight_lines_t), intent(out) :: lines
    integer :: i, n

    n = count(straight)
    lines%ends = ends(:, :, pack([(i, i=1, size(straight))], straight))
    if (n == 0) return
    call set_up_grid(lines%grid, reshape(lines%ends, [2, 2*n]), n)
    call place_segments(lines%grid, reshape(lines%ends, [2, 2*n]), reshape([(i, i=1, 2*n)], [2, n]), 2*within)
  end subroutine list_straight_lines

  !> The straight line that is nearest to a position, of those whose foot lies between their ends, and the foot. 0 where none is
  !> within the distance.
  pure subroutine nearest_straight_line(lines, position, within, line, foot)
    type(straight_lines_t), intent(in) :: lines
    real(dp), intent(in) :: position(2)     !! length
    real(dp), intent(in) :: within          !! length
    integer, intent(out) :: line
    real(dp), intent(out) :: foot(2)        !! length
    real(dp) :: distance, nearest, own(2)
    integer :: at, cell, i, range(2, 2)

    line = 0
    foot = position
    if (size(lines%ends, 3) == 0) return
    nearest = within
    range = cells_of_box(lines%grid, position, position)
    cell = number_of_cell(lines%grid, range(1, 1), range(2, 1))
    do at = lines%grid%first(cell), lines%grid%first(cell + 1) - 1
      i = lines%grid%item(at)
      call drop_perpendicular(lines%ends(:, 1, i), lines%ends(:, 2, i), position, own, distance)
      if (distance > nearest) cycle
      nearest = distance
      line = i
      foot = own
    end do
  end subroutine nearest_straight_line

  !> Foot of the perpendicular from a position to a segment, and its length; huge where the foot is not between the ends.
  !>
  !> On a segment along an axis the foot has the coordinate of the segment, without rounding.
  pure subroutine drop_perpendicular(a, b, position, foot, distance)
    real(dp), intent(in) :: a(2), b(2), position(2)
    real(dp), intent(out) :: foot(2), distance
    real(dp) :: share

    foot = a
    distance = huge(distance)
    if (.not. sum((b - a)**2) > 0) return ! both ends of a short line have become one
    share = dot_product(position - a, b - a)/dot_product(b - a, b - a)
    foot = a + share*(b - a)
    if (share > 0 .and. share < 1) distance = norm2(position - foot)
  end subroutine drop_perpendicular

end module scree_straight_lines
