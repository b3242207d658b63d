!> A grid of cells that finds neighbours: each cell lists the segments or boxes that touch it.
!>
!> Half of the columns have one width. The other half hold equal numbers of the places for which the grid is made. Rows are made in
!> the same way. So places that crowd in a corner are told apart, at the price of a bisection.
module scree_cell_grid
  use scree_kinds, only: dp
  use scree_pairs, only: add_pair, list_others, pairs_t
  use scree_sorting, only: sort_by
  implicit none
  private
  public :: cell_grid_t, cells_of_box, left_of_column, number_of_cell, place_boxes, place_segments, set_up_grid

  integer, parameter :: sample_share = 16 !! places a column or row, at most, that settle where these are

  !> Columns or rows.
  type :: axis_t
    real(dp), allocatable :: start(:)   !! where they begin, but for the first, ascending, length
    real(dp) :: low = 0.0_dp, width = 1.0_dp
    integer, allocatable :: below(:)    !! (n+1) starts below low + (i-1) width: where the search for one begins
  end type axis_t

  !> The cells, and the items of each.
  type :: cell_grid_t
    type(axis_t) :: x, y
    integer :: n(2) = 0                 !! columns and rows
    integer, allocatable :: first(:)    !! (n_cells+1) cell c owns item(first(c):first(c+1)-1)
    integer, allocatable :: item(:)
  end type cell_grid_t

contains

  !> About as many cells as asked for, over places that are not all one.
  pure subroutine set_up_grid(grid, position, n_cells)
    type(cell_grid_t), intent(out) :: grid
    real(dp), intent(in) :: position(:, :)      !! (2, n), length
    integer, intent(in) :: n_cells
    real(dp) :: edge, extent(2)

    extent = maxval(position, 2) - minval(position, 2)
    extent = max(extent, 1e-3_dp*maxval(extent), tiny(1.0_dp))
    edge = sqrt(extent(1)*(extent(2)/max(1, n_cells)))
    grid%x = axis_of(position(1, :), int(extent(1)/edge) + 1)
    grid%y = axis_of(position(2, :), int(extent(2)/edge) + 1)
    grid%n = [size(grid%x%start), size(grid%y%start)] + 1
  end subroutine set_up_grid

  !> An axis of n intervals; fewer where places coincide.
  pure function axis_of(x, n) result(axis)
    real(dp), intent(in) :: x(:)    !! places
    integer, intent(in) :: n
    type(axis_t) :: axis
    real(dp), allocatable :: sample(:), start(:)
    real(dp) :: high
    integer, allocatable :: none(:)
    integer :: i, k

    axis%low = minval(x)
    high = maxval(x)
    axis%width = max((high - axis%low)/n, tiny(1.0_dp))
    sample = x(1:size(x):(size(x) + sample_share*n - 1)/(sample_share*n))
    allocate (none(max(n, size(sample))), source=0)
    call sort_by(sample, none(:size(sample)))
    start = [(axis%low + (high - axis%low)*i/(n - n/2), i=1, n - n/2 - 1), &
             (sample(1 + int(real(i, dp)*(size(sample) - 1)/(n/2 + 1))), i=1, n/2)]
    call sort_by(start, none(:size(start)))
    axis%start = pack(start, start > eoshift(start, -1, axis%low))
    allocate (axis%below(n + 1))
    k = 0
    do i = 1, n
      do while (k < size(axis%start))
        if (bucket_of(axis, axis%start(k + 1)) >= i) exit
        k = k + 1
      end do
      axis%below(i) = k
    end do
    axis%below(n + 1) = size(axis%start)
  end function axis_of

  !> Number of the equal part of an axis that a position lies in.
  pure integer function bucket_of(axis, x)
    type(axis_t), intent(in) :: axis
    real(dp), intent(in) :: x

    bucket_of = size(axis%below) - 1
    if (x - axis%low < (bucket_of - 1)*axis%width) & ! the width may be tiny
      bucket_of = 1 + int(max(0.0_dp, x - axis%low)/axis%width)
  end function bucket_of

  !> Columns and rows of the cells that a box touches: first and last column, first and last row, from 0.
  pure function cells_of_box(grid, low, high) result(range)
    type(cell_grid_t), intent(in) :: grid
    real(dp), intent(in) :: low(2), high(2) !! length
    integer :: range(2, 2)

    range(1, :) = [interval_of(grid%x, low(1)), interval_of(grid%x, high(1))]
    range(2, :) = [interval_of(grid%y, low(2)), interval_of(grid%y, high(2))]
  end function cells_of_box

  !> Number of the interval of a position, from 0: how many begin at it or before.
  pure integer function interval_of(axis, x)
    type(axis_t), intent(in) :: axis
    real(dp), intent(in) :: x
    integer :: bucket, high, middle

    bucket = bucket_of(axis, x)
    interval_of = axis%below(bucket)
    high = size(axis%start)
    if (bucket < size(axis%below) - 1) high = axis%below(bucket + 1)
    do while (interval_of < high)
      middle = (interval_of + high + 1)/2
      if (axis%start(middle) <= x) then
        interval_of = middle
      else
        high = middle - 1
      end if
    end do
  end function interval_of

  !> Where a column, counted from 0, begins; the first begins nowhere.
  pure real(dp) function left_of_column(grid, column)
    type(cell_grid_t), intent(in) :: grid
    integer, intent(in) :: column

    left_of_column = -huge(left_of_column)
    if (column > 0) left_of_column = grid%x%start(column)
  end function left_of_column

  !> Number of a cell from 1.
  pure integer function number_of_cell(grid, column, row)
    type(cell_grid_t), intent(in) :: grid
    integer, intent(in) :: column, row

    number_of_cell = 1 + column + row*grid%n(1)
  end function number_of_cell

  !> Lists every segment in all cells that it comes within `margin` of.
  pure subroutine place_segments(grid, position, ends, margin)
    type(cell_grid_t), intent(inout) :: grid
    real(dp), intent(in) :: position(:, :)   !! (2, n_nodes), length
    integer, intent(in) :: ends(:, :)     !! (2, n) nodes of the segments
    real(dp), intent(in) :: margin        !! length
    type(pairs_t) :: places
    real(dp) :: low(2), high(2)
    integer :: column, i, range(2, 2), row, rows(2)

    do i = 1, size(ends, 2)
      associate (a => position(:, ends(1, i)), b => position(:, ends(2, i)))
        low = min(a, b) - margin
        high = max(a, b) + margin
        range = cells_of_box(grid, low, high)
        do column = range(1, 1), range(1, 2)
          rows = range(2, :)
          if (rows(2) > rows(1) .and. range(1, 2) > range(1, 1)) rows = rows_in_column(grid, a, b, column, margin, rows)
          do row = rows(1), rows(2)
            call add_pair(places, number_of_cell(grid, column, row), i)
          end do
        end do
      end associate
    end do
    call list_by_cell(places, grid)
  end subroutine place_segments

  !> Lists every box in all cells that it touches.
  pure subroutine place_boxes(grid, low, high)
    type(cell_grid_t), intent(inout) :: grid
    real(dp), intent(in) :: low(:, :), high(:, :) !! (2, n) corners, length
    type(pairs_t) :: places
    integer :: column, i, range(2, 2), row

    do i = 1, size(low, 2)
      range = cells_of_box(grid, low(:, i), high(:, i))
      do row = range(2, 1), range(2, 2)
        do column = range(1, 1), range(1, 2)
          call add_pair(places, number_of_cell(grid, column, row), i)
        end do
      end do
    end do
    call list_by_cell(places, grid)
  end subroutine place_boxes

  !> Lists the items of each cell, in the order in which they were noted.
  pure subroutine list_by_cell(places, grid)
    type(pairs_t), intent(in) :: places        !! cells, and an item that is in each
    type(cell_grid_t), intent(inout) :: grid

    allocate (grid%first(grid%n(1)*grid%n(2) + 1), grid%item(places%n))
    call list_others(places, grid%first, grid%item)
  end subroutine list_by_cell

  !> Rows of a column that the segment a b passes through, with a margin.
  pure function rows_in_column(grid, a, b, column, margin, all_rows) result(rows)
    type(cell_grid_t), intent(in) :: grid
    real(dp), intent(in) :: a(2), b(2), margin
    integer, intent(in) :: column, all_rows(2)
    integer :: rows(2)
    real(dp) :: slope, left, right, ya, yb

    rows = all_rows
    if (abs(b(1) - a(1)) <= margin) return ! upright: its slope may be infinite
    left = left_of_column(grid, column) - margin
    right = huge(right)
    if (column < grid%n(1) - 1) right = left_of_column(grid, column + 1) + margin
    slope = (b(2) - a(2))/(b(1) - a(1))
    ya = a(2) + (max(min(a(1), b(1)), min(left, max(a(1), b(1)))) - a(1))*slope
    yb = a(2) + (max(min(a(1), b(1)), min(right, max(a(1), b(1)))) - a(1))*slope
    rows(1) = max(all_rows(1), interval_of(grid%y, min(ya, yb) - margin))
    rows(2) = min(all_rows(2), interval_of(grid%y, max(ya, yb) + margin))
  end function rows_in_column

end module scree_cell_grid
