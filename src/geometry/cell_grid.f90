!> A grid of square cells that finds what is near: each cell lists the segments or boxes that touch it.
module scree_cell_grid
  use scree_kinds, only: dp
  implicit none
  private
  public :: cell_grid_t, cells_of_box, number_of_cell, place_boxes, place_segments, set_up_grid

  !> The cells, and the items of each.
  type :: cell_grid_t
    real(dp) :: low(2) = 0.0_dp         !! lower left corner, length
    real(dp) :: edge = 1.0_dp           !! of a cell, length
    integer :: n(2) = 0                 !! cells along x and y
    integer, allocatable :: first(:)    !! (n_cells+1) cell c owns item(first(c):first(c+1)-1)
    integer, allocatable :: item(:)
  end type cell_grid_t

contains

  !> Cells over a box, about as many as asked for; no more than 4096 along a side that is much longer than the other.
  pure subroutine set_up_grid(grid, low, high, n_cells)
    type(cell_grid_t), intent(out) :: grid
    real(dp), intent(in) :: low(2), high(2)  !! length
    integer, intent(in) :: n_cells
    real(dp) :: extent(2)

    extent = max(high - low, 1e-3_dp*maxval(high - low))
    grid%edge = max(sqrt(extent(1)*extent(2)/max(1, n_cells)), tiny(1.0_dp))
    grid%low = low
    grid%n = int(extent/grid%edge) + 1
  end subroutine set_up_grid

  !> Columns and rows of the cells that a box touches: first and last column, first and last row, from 0.
  pure function cells_of_box(grid, low, high) result(range)
    type(cell_grid_t), intent(in) :: grid
    real(dp), intent(in) :: low(2), high(2) !! length
    integer :: range(2, 2)

    range(:, 1) = column_and_row(grid, low)
    range(:, 2) = column_and_row(grid, high)
  end function cells_of_box

  !> Column and row of the cell of a place, from 0; the nearest cell for a place outside.
  pure function column_and_row(grid, place) result(cell)
    type(cell_grid_t), intent(in) :: grid
    real(dp), intent(in) :: place(2)
    integer :: cell(2)

    cell = int(max(0.0_dp, min((place - grid%low)/grid%edge, real(grid%n - 1, dp))))
  end function column_and_row

  !> Number of a cell from 1.
  pure integer function number_of_cell(grid, column, row)
    type(cell_grid_t), intent(in) :: grid
    integer, intent(in) :: column, row

    number_of_cell = 1 + column + row*grid%n(1)
  end function number_of_cell

  !> Lists every segment in all cells that it comes within `margin` of.
  pure subroutine place_segments(grid, place, ends, margin)
    type(cell_grid_t), intent(inout) :: grid
    real(dp), intent(in) :: place(:, :)   !! (2, n_nodes), length
    integer, intent(in) :: ends(:, :)     !! (2, n) nodes of the segments
    real(dp), intent(in) :: margin        !! length
    integer :: c, column, i, pass, range(2, 2), row, rows(2)

    allocate (grid%first(grid%n(1)*grid%n(2) + 1), source=0)
    do pass = 1, 2 ! count, then list
      do i = 1, size(ends, 2)
        associate (a => place(:, ends(1, i)), b => place(:, ends(2, i)))
          range = cells_of_box(grid, min(a, b) - margin, max(a, b) + margin)
          do column = range(1, 1), range(1, 2)
            rows = range(2, :)
            if (rows(2) > rows(1) .and. range(1, 2) > range(1, 1)) rows = rows_in_column(grid, a, b, column, margin, rows)
            do row = rows(1), rows(2)
              c = number_of_cell(grid, column, row)
              if (pass == 2) grid%item(grid%first(c)) = i
              grid%first(c) = grid%first(c) + 1
            end do
          end do
        end associate
      end do
      if (pass == 1) then
        call counts_to_starts(grid%first)
        allocate (grid%item(grid%first(size(grid%first)) - 1))
      end if
    end do
    grid%first(2:) = grid%first(:size(grid%first) - 1) ! listing moved every start to its end
    grid%first(1) = 1
  end subroutine place_segments

  !> Lists every box in all cells that it touches.
  pure subroutine place_boxes(grid, low, high)
    type(cell_grid_t), intent(inout) :: grid
    real(dp), intent(in) :: low(:, :), high(:, :) !! (2, n) corners, length
    integer :: c, column, i, pass, range(2, 2), row

    allocate (grid%first(grid%n(1)*grid%n(2) + 1), source=0)
    do pass = 1, 2 ! count, then list
      do i = 1, size(low, 2)
        range = cells_of_box(grid, low(:, i), high(:, i))
        do row = range(2, 1), range(2, 2)
          do column = range(1, 1), range(1, 2)
            c = number_of_cell(grid, column, row)
            if (pass == 2) grid%item(grid%first(c)) = i
            grid%first(c) = grid%first(c) + 1
          end do
        end do
      end do
      if (pass == 1) then
        call counts_to_starts(grid%first)
        allocate (grid%item(grid%first(size(grid%first)) - 1))
      end if
    end do
    grid%first(2:) = grid%first(:size(grid%first) - 1)
    grid%first(1) = 1
  end subroutine place_boxes

  !> Starts of lists from their lengths; the last entry becomes one past the end.
  pure subroutine counts_to_starts(first)
    integer, intent(inout) :: first(:)
    integer :: count, i, start

    start = 1
    do i = 1, size(first)
      count = first(i)
      first(i) = start
      start = start + count
    end do
  end subroutine counts_to_starts

  !> Rows of a column that the segment a b passes through, with a margin.
  pure function rows_in_column(grid, a, b, column, margin, all_rows) result(rows)
    type(cell_grid_t), intent(in) :: grid
    real(dp), intent(in) :: a(2), b(2), margin
    integer, intent(in) :: column, all_rows(2)
    integer :: rows(2), cell(2)
    real(dp) :: x(2), y(2), pad

    pad = margin + 1e-9_dp*grid%edge
    rows = all_rows
    if (abs(b(1) - a(1)) <= pad) return ! upright: its slope may be infinite
    x = grid%low(1) + grid%edge*[column, column + 1] + [-pad, pad]
    if (column == 0) x(1) = min(x(1), a(1), b(1))
    if (column == grid%n(1) - 1) x(2) = max(x(2), a(1), b(1))
    x = max(min(a(1), b(1)), min(x, max(a(1), b(1))))
    y = a(2) + (x - a(1))*((b(2) - a(2))/(b(1) - a(1)))
    cell = column_and_row(grid, [grid%low(1), minval(y) - pad])
    rows(1) = max(all_rows(1), cell(2))
    cell = column_and_row(grid, [grid%low(1), maxval(y) + pad])
    rows(2) = min(all_rows(2), cell(2))
  end function rows_in_column

end module scree_cell_grid
