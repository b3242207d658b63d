!> Series of rows: a dataset that grows, and the rows that wait in memory to be written to it.
module scree_row_series
  use hdf5, only: hsize_t
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_hdf5_writing, only: append_rows, bytes_to_append, rows_t
  use scree_kinds, only: dp, i8
  implicit none
  private
  public :: add_row, bytes_to_write, more_series, rows_with_waiting, series_t, write_waiting

  !> A series and its rows that wait.
  type :: series_t
    type(rows_t) :: rows
    character(len=:), allocatable :: path
    integer :: width = 1
    integer :: n = 0                        !! numbers that wait
    real(dp), allocatable :: waiting(:)
  end type series_t

contains

  !> Twice the room for series.
  pure subroutine more_series(series)
    type(series_t), allocatable, intent(inout) :: series(:)
    type(series_t), allocatable :: longer(:)

    allocate (longer(2*size(series)))
    longer(:size(series)) = series
    call move_alloc(longer, series)
  end subroutine more_series

  !> Adds a row, or rows; they wait in memory. Errors: a number that is not finite.
  subroutine add_row(series, values, error)
    type(series_t), intent(inout) :: series
    real(dp), intent(in) :: values(:)
    type(error_t), allocatable, intent(out) :: error
    real(dp), allocatable :: longer(:)

    if (.not. all(ieee_is_finite(values))) then
      call fail(error, status_run_failed, 'a number of '//series%path//' is not finite')
      return
    end if
    if (series%n + size(values) > size(series%waiting)) then
      allocate (longer(max(2*size(series%waiting), series%n + size(values))))
      longer(:series%n) = series%waiting(:series%n)
      call move_alloc(longer, series%waiting)
    end if
    series%waiting(series%n + 1:series%n + size(values)) = values
    series%n = series%n + size(values)
  end subroutine add_row

  !> Rows, with those that wait.
  pure integer(i8) function rows_with_waiting(series) result(n)
    type(series_t), intent(in) :: series

    n = int(series%rows%n_rows, i8) + series%n/max(1, series%width)
  end function rows_with_waiting

  !> Space that the rows that wait may take in the file.
  elemental integer(hsize_t) function bytes_to_write(series) result(bytes)
    type(series_t), intent(in) :: series

    bytes = bytes_to_append(series%rows, int(series%n/max(1, series%width), hsize_t))
  end function bytes_to_write

  !> Writes the rows that wait. Errors: a failed write.
  subroutine write_waiting(series, error)
    type(series_t), intent(inout) :: series
    type(error_t), allocatable, intent(out) :: error

    call append_rows(series%rows, series%waiting(:series%n), error)
    if (.not. allocated(error)) series%n = 0
  end subroutine write_waiting

end module scree_row_series
