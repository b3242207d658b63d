!> A square sparse matrix in compressed columns, assembled from dense element matrices.
!>
!> Both triangles are stored, sorted: UMFPACK takes them as they are, CHOLMOD reads the lower one.
module scree_sparse_matrix
  use, intrinsic :: iso_c_binding, only: c_double, c_int
  use scree_kinds, only: dp
  implicit none
  private
  public :: add_element, build_pattern, clear_matrix, diagonal, sparse_matrix_t, times

  !> The matrix, and where each entry of each element goes. Columns and rows count from 0, as the C libraries want.
  type :: sparse_matrix_t
    integer :: n = 0
    integer(c_int), allocatable :: first(:)    !! (n+1) column j owns entries first(j):first(j+1)-1, from 0
    integer(c_int), allocatable :: row(:)      !! (n_entries) from 0
    real(c_double), allocatable :: value(:)    !! (n_entries)
    integer, allocatable :: place_first(:)     !! (n_elements+1) element e owns place(place_first(e):place_first(e+1)-1)
    integer, allocatable :: place(:)           !! entry (from 1) of each entry of the element matrices, by columns
  end type sparse_matrix_t

contains

  !> Pattern of element matrices on given rows; values are zero.
  pure subroutine build_pattern(n, rows, matrix)
    integer, intent(in) :: n
    integer, intent(in) :: rows(:, :) !! (n_most, n_elements) rows of each element from 1, then zeros where it has fewer
    type(sparse_matrix_t), intent(out) :: matrix
    integer, allocatable :: of_row(:)                  ! elements by row
    integer :: first_of_row(n + 1), filled(n), mark(n), list(n)
    integer :: e, i, j, k, m, n_entries, pass

    matrix%n = n
    first_of_row = 0
    do e = 1, size(rows, 2)
      do k = 1, count(rows(:, e) > 0)
        first_of_row(rows(k, e) + 1) = first_of_row(rows(k, e) + 1) + 1
      end do
    end do
    first_of_row(1) = 1
    do i = 1, n
      first_of_row(i + 1) = first_of_row(i + 1) + first_of_row(i)
    end do
    allocate (of_row(first_of_row(n + 1) - 1))
    filled = first_of_row(:n)
    do e = 1, size(rows, 2)
      do k = 1, count(rows(:, e) > 0)
        of_row(filled(rows(k, e))) = e
        filled(rows(k, e)) = filled(rows(k, e)) + 1
      end do
    end do

    allocate (matrix%first(n + 1))
    do pass = 1, 2 ! count, then keep
      mark = 0
      n_entries = 0
      do j = 1, n
        matrix%first(j) = n_entries
        m = 0
        do i = first_of_row(j), first_of_row(j + 1) - 1
          do k = 1, count(rows(:, of_row(i)) > 0)
            if (mark(rows(k, of_row(i))) == j) cycle
            mark(rows(k, of_row(i))) = j
            m = m + 1
            list(m) = rows(k, of_row(i))
          end do
        end do
        if (pass == 2) then
          call sort(list(:m))
          matrix%row(n_entries + 1:n_entries + m) = list(:m) - 1
        end if
        n_entries = n_entries + m
      end do
      matrix%first(n + 1) = n_entries
      if (pass == 1) allocate (matrix%row(n_entries))
    end do
    allocate (matrix%value(n_entries), source=0.0_dp)

    allocate (matrix%place_first(size(rows, 2) + 1))
    matrix%place_first(1) = 1
    do e = 1, size(rows, 2)
      matrix%place_first(e + 1) = matrix%place_first(e) + count(rows(:, e) > 0)**2
    end do
    allocate (matrix%place(matrix%place_first(size(rows, 2) + 1) - 1))
    do e = 1, size(rows, 2)
      m = count(rows(:, e) > 0)
      do j = 1, m
        do i = 1, m
          matrix%place(matrix%place_first(e) + (j - 1)*m + i - 1) = entry_at(matrix, rows(i, e), rows(j, e))
        end do
      end do
    end do
  end subroutine build_pattern

  !> Entry (from 1) at a row and column (from 1) of the pattern, by bisection.
  pure integer function entry_at(matrix, row, column)
    type(sparse_matrix_t), intent(in) :: matrix
    integer, intent(in) :: row, column
    integer :: high, middle

    entry_at = matrix%first(column) + 1
    high = matrix%first(column + 1)
    do while (entry_at < high)
      middle = (entry_at + high)/2
      if (matrix%row(middle) < row - 1) then
        entry_at = middle + 1
      else
        high = middle
      end if
    end do
  end function entry_at

  !> Sorts a short list by insertion.
  pure subroutine sort(list)
    integer, intent(inout) :: list(:)
    integer :: held, i, k

    do i = 2, size(list)
      held = list(i)
      k = i - 1
      do while (k >= 1)
        if (list(k) <= held) exit
        list(k + 1) = list(k)
        k = k - 1
      end do
      list(k + 1) = held
    end do
  end subroutine sort

  !> Sets all values to zero.
  pure subroutine clear_matrix(matrix)
    type(sparse_matrix_t), intent(inout) :: matrix

    matrix%value = 0.0_dp
  end subroutine clear_matrix

  !> Adds the dense matrix of element `e`.
  pure subroutine add_element(matrix, e, dense)
    type(sparse_matrix_t), intent(inout) :: matrix
    integer, intent(in) :: e
    real(dp), intent(in) :: dense(:, :) !! (m, m) of the element's rows
    integer :: at, i, j

    at = matrix%place_first(e)
    do j = 1, size(dense, 2)
      do i = 1, size(dense, 1)
        associate (value => matrix%value(matrix%place(at)))
          value = value + dense(i, j)
        end associate
        at = at + 1
      end do
    end do
  end subroutine add_element

  !> The diagonal.
  pure function diagonal(matrix)
    type(sparse_matrix_t), intent(in) :: matrix
    real(dp) :: diagonal(matrix%n)
    integer :: j

    do j = 1, matrix%n
      diagonal(j) = matrix%value(entry_at(matrix, j, j))
    end do
  end function diagonal

  !> A x.
  pure function times(matrix, x) result(y)
    type(sparse_matrix_t), intent(in) :: matrix
    real(dp), intent(in) :: x(:)
    real(dp) :: y(size(x))
    integer :: j, k

    y = 0.0_dp
    do j = 1, matrix%n
      do k = matrix%first(j) + 1, matrix%first(j + 1)
        y(matrix%row(k) + 1) = y(matrix%row(k) + 1) + matrix%value(k)*x(j)
      end do
    end do
  end function times

end module scree_sparse_matrix
