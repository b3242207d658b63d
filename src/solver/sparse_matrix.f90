!> A square sparse matrix in compressed columns, assembled from dense element matrices.
!>
!> Both triangles are stored, sorted: LU takes them as they are, CHOLMOD reads the lower one. What is added says whether it is
!> symmetric, and so the matrix knows whether it is; where it is not, it knows the symmetric matrix beside it that a factor is made
!> of.
module scree_sparse_matrix
  use, intrinsic :: iso_c_binding, only: c_double, c_int
  use scree_factored, only: factored_t
  use scree_kinds, only: dp
  implicit none
  private
  public :: add_element, build_pattern, clear_matrix, copy_values, diagonal, multiply, on_fewer_places, on_fewer_rows, &
            products, root_of_diagonal, root_of_entry, sparse_matrix_t, symmetric_diagonal, symmetric_matrix, times

  !> The matrix, and where each entry of each element goes. Columns and rows count from 0, as the C libraries want.
  type :: sparse_matrix_t
    integer :: n = 0
    logical :: symmetric = .true.              !! all that was added since it was cleared is
    integer(c_int), allocatable :: first(:)    !! (n+1) column j owns entries first(j):first(j+1)-1, from 0
    integer(c_int), allocatable :: row(:)      !! (n_entries) from 0
    real(c_double), allocatable :: value(:)    !! (n_entries)
    real(c_double), allocatable :: skewed(:)   !! (n_entries) of these, without which the matrix is symmetric; where it is not
    integer, allocatable :: on_diagonal(:)     !! (n) entry (from 1) of each row on the diagonal
    integer, allocatable :: alike(:)           !! (n) columns from each one on that have the same rows
    integer, allocatable :: place_first(:)     !! (n_elements+1) element e owns place(place_first(e):place_first(e+1)-1)
    integer, allocatable :: place(:)           !! entry (from 1) of each entry of the element matrices, by columns
  end type sparse_matrix_t

contains

  !> Makes the pattern of element matrices on given rows; values are zero.
  pure subroutine build_pattern(n, rows, matrix)
    integer, intent(in) :: n
    integer, intent(in) :: rows(:, :) !! (n_most, n_elements) rows of each element from 1, then zeros where it has fewer
    type(sparse_matrix_t), intent(out) :: matrix
    integer :: m(size(rows, 2)) ! rows of each element
    integer :: e, i, j

    matrix%n = n
    m = count(rows > 0, 1)
    call fill_columns(rows, m, matrix)
    allocate (matrix%value(size(matrix%row)), source=0.0_dp)
    matrix%on_diagonal = [(entry_at(matrix, j, j), j=1, n)]
    call count_alike(matrix)

    allocate (matrix%place_first(size(m) + 1))
    matrix%place_first(1) = 1
    do e = 1, size(m)
      matrix%place_first(e + 1) = matrix%place_first(e) + m(e)**2
    end do
    allocate (matrix%place(matrix%place_first(size(m) + 1) - 1))
    do e = 1, size(m)
      do j = 1, m(e)
        do i = 1, m(e)
          matrix%place(matrix%place_first(e) + (j - 1)*m(e) + i - 1) = entry_at(matrix, rows(i, e), rows(j, e))
        end do
      end do
    end do
  end subroutine build_pattern

  !> Fills the columns of a pattern: those of a row are all rows of the elements that have it.
  pure subroutine fill_columns(rows, m, matrix)
    integer, intent(in) :: rows(:, :), m(:) !! of the elements, and their numbers
    type(sparse_matrix_t), intent(inout) :: matrix
    integer, allocatable :: first_of_row(:), of_row(:) ! elements by row
    integer :: mark(matrix%n), list(matrix%n)
    integer :: i, j, k, n_list, n_entries, pass

    call list_by_row(matrix%n, rows, m, first_of_row, of_row)
    allocate (matrix%first(matrix%n + 1))
    do pass = 1, 2 ! count, then keep
      mark = 0
      n_entries = 0
      do j = 1, matrix%n
        matrix%first(j) = n_entries
        n_list = 0
        do i = first_of_row(j), first_of_row(j + 1) - 1
          do k = 1, m(of_row(i))
            if (mark(rows(k, of_row(i))) == j) cycle
            mark(rows(k, of_row(i))) = j
            n_list = n_list + 1
            list(n_list) = rows(k, of_row(i))
          end do
        end do
        if (pass == 2) then
          call sort(list(:n_list))
          matrix%row(n_entries + 1:n_entries + n_list) = list(:n_list) - 1
        end if
        n_entries = n_entries + n_list
      end do
      matrix%first(matrix%n + 1) = n_entries
      if (pass == 1) allocate (matrix%row(n_entries))
    end do
  end subroutine fill_columns

  !> Lists the elements by row: row i has `of_row(first_of_row(i):first_of_row(i+1)-1)`.
  pure subroutine list_by_row(n, rows, m, first_of_row, of_row)
    integer, intent(in) :: n, rows(:, :), m(:)
    integer, allocatable, intent(out) :: first_of_row(:), of_row(:)
    integer :: filled(n), e, i, k

    allocate (first_of_row(n + 1), source=0)
    do e = 1, size(m)
      do k = 1, m(e)
        first_of_row(rows(k, e) + 1) = first_of_row(rows(k, e) + 1) + 1
      end do
    end do
    first_of_row(1) = 1
    do i = 1, n
      first_of_row(i + 1) = first_of_row(i + 1) + first_of_row(i)
    end do
    allocate (of_row(first_of_row(n + 1) - 1))
    filled = first_of_row(:n)
    do e = 1, size(m)
      do k = 1, m(e)
        of_row(filled(rows(k, e))) = e
        filled(rows(k, e)) = filled(rows(k, e)) + 1
      end do
    end do
  end subroutine list_by_row

  !> Counts the columns that have the same rows: those of one element do, or nearly.
  pure subroutine count_alike(matrix)
    type(sparse_matrix_t), intent(inout) :: matrix
    integer :: j

    allocate (matrix%alike(matrix%n), source=1)
    associate (first => matrix%first, row => matrix%row)
      do j = matrix%n - 1, 1, -1
        if (first(j + 2) - first(j + 1) /= first(j + 1) - first(j)) cycle
        if (all(row(first(j) + 1:first(j + 1)) == row(first(j + 1) + 1:first(j + 2)))) matrix%alike(j) = matrix%alike(j + 1) + 1
      end do
    end associate
  end subroutine count_alike

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

  !> A matrix on fewer places: those of what is not zero, and of some of its elements. The others have none.
  pure type(sparse_matrix_t) function on_fewer_places(matrix, is_kept) result(small)
    type(sparse_matrix_t), intent(in) :: matrix
    logical, intent(in) :: is_kept(:)  !! elements
    logical :: keep(size(matrix%row))
    integer :: at(size(matrix%row)), e, j, k, m

    keep = abs(matrix%value) > 0
    if (.not. matrix%symmetric) keep = keep .or. abs(matrix%skewed) > 0
    keep(matrix%on_diagonal) = .true.
    do j = 1, matrix%n ! the pattern is to be symmetric
      do k = matrix%first(j) + 1, matrix%first(j + 1)
        if (keep(k)) keep(entry_at(matrix, j, matrix%row(k) + 1)) = .true.
      end do
    end do
    do e = 1, size(is_kept)
      if (is_kept(e)) keep(matrix%place(matrix%place_first(e):matrix%place_first(e + 1) - 1)) = .true.
    end do

    small%n = matrix%n
    small%symmetric = matrix%symmetric
    allocate (small%first(matrix%n + 1), small%place_first(size(is_kept) + 1))
    m = 0
    do j = 1, matrix%n
      small%first(j) = m
      do k = matrix%first(j) + 1, matrix%first(j + 1)
        if (keep(k)) m = m + 1
        at(k) = m
      end do
    end do
    small%first(matrix%n + 1) = m
    small%row = pack(matrix%row, keep)
    small%value = pack(matrix%value, keep)
    if (.not. matrix%symmetric) small%skewed = pack(matrix%skewed, keep)
    small%on_diagonal = at(matrix%on_diagonal)
    call count_alike(small)
    allocate (small%place(sum(matrix%place_first(2:) - matrix%place_first(:size(is_kept)), is_kept)))
    small%place_first(1) = 1
    do e = 1, size(is_kept)
      associate (place => matrix%place(matrix%place_first(e):matrix%place_first(e + 1) - 1))
        m = small%place_first(e)
        if (is_kept(e)) small%place(m:m + size(place) - 1) = at(place)
        small%place_first(e + 1) = m + merge(size(place), 0, is_kept(e))
      end associate
    end do
  end function on_fewer_places

  !> The part of a matrix that some of its rows and columns have, and of each element the places there.
  pure type(sparse_matrix_t) function on_fewer_rows(matrix, is_kept) result(part)
    type(sparse_matrix_t), intent(in) :: matrix
    logical, intent(in) :: is_kept(:)  !! (n) rows
    integer :: number(matrix%n), at(size(matrix%row)), e, j, k, m

    part%n = count(is_kept)
    part%symmetric = matrix%symmetric
    m = 0
    do j = 1, matrix%n
      if (is_kept(j)) m = m + 1
      number(j) = m
    end do
    allocate (part%first(part%n + 1))
    m = 0
    at = 0
    do j = 1, matrix%n
      if (.not. is_kept(j)) cycle
      part%first(number(j)) = m
      do k = matrix%first(j) + 1, matrix%first(j + 1)
        if (.not. is_kept(matrix%row(k) + 1)) cycle
        m = m + 1
        at(k) = m
      end do
    end do
    part%first(part%n + 1) = m
    part%row = number(pack(matrix%row, at > 0) + 1) - 1
    part%value = pack(matrix%value, at > 0)
    if (.not. matrix%symmetric) part%skewed = pack(matrix%skewed, at > 0)
    part%on_diagonal = pack(at(matrix%on_diagonal), is_kept)
    call count_alike(part)
    part%place = pack(at(matrix%place), at(matrix%place) > 0)
    allocate (part%place_first(size(matrix%place_first)))
    m = 1
    do e = 1, size(matrix%place_first) - 1
      part%place_first(e) = m
      m = m + count(at(matrix%place(matrix%place_first(e):matrix%place_first(e + 1) - 1)) > 0)
    end do
    part%place_first(size(part%place_first)) = m
  end function on_fewer_rows

  !> Sets all values to zero.
  pure subroutine clear_matrix(matrix)
    type(sparse_matrix_t), intent(inout) :: matrix

    matrix%value = 0.0_dp
    matrix%symmetric = .true.
  end subroutine clear_matrix

  !> Gives a matrix the values of another of the same pattern.
  pure subroutine copy_values(from, to)
    type(sparse_matrix_t), intent(in) :: from
    type(sparse_matrix_t), intent(inout) :: to

    to%value = from%value
    to%symmetric = from%symmetric
    if (.not. from%symmetric) to%skewed = from%skewed
  end subroutine copy_values

  !> Adds the dense matrix of element `e`. Where it is not symmetric, the symmetric matrix beside it has its symmetric part, without
  !> that of a part of it that is kept apart.
  !>
  !> Friction is such a part: it follows the force across a contact. With half of it on either side of the diagonal a matrix is
  !> seldom definite, and solutions take two to four times as many iterations from it.
  pure subroutine add_element(matrix, e, dense, symmetric, apart)
    type(sparse_matrix_t), intent(inout) :: matrix
    integer, intent(in) :: e
    real(dp), intent(in), contiguous :: dense(:, :)           !! (m, m) of the element's rows; rows below are no part of it
    logical, intent(in) :: symmetric                          !! but for round-off
    real(dp), intent(in), contiguous, optional :: apart(:, :) !! as large

    if (size(dense) == 0) return
    if (symmetric) then
      call scatter(size(dense, 1), size(dense, 2), matrix%place(matrix%place_first(e):), dense, matrix%value)
      return
    end if
    if (.not. allocated(matrix%skewed)) allocate (matrix%skewed(size(matrix%value)))
    if (matrix%symmetric) matrix%skewed = 0.0_dp
    matrix%symmetric = .false.
    call scatter_skewed(size(dense, 1), size(dense, 2), matrix%place(matrix%place_first(e):), dense, matrix%value, matrix%skewed, &
                        apart)
  end subroutine add_element

  !> Adds the entries of a dense matrix to values, each at its place.
  pure subroutine scatter(n_rows, m, place, dense, value)
    integer, intent(in) :: n_rows, m, place(m, m)
    real(dp), intent(in) :: dense(n_rows, m)
    real(dp), intent(inout) :: value(*)
    integer :: i, j

    do j = 1, m
      do i = 1, m
        value(place(i, j)) = value(place(i, j)) + dense(i, j)
      end do
    end do
  end subroutine scatter

  !> Adds a matrix that is not symmetric to values, and what it is not symmetric by to `skewed`, entries of a pair at once.
  pure subroutine scatter_skewed(n_rows, m, place, dense, value, skewed, apart)
    integer, intent(in) :: n_rows, m, place(m, m)
    real(dp), intent(in) :: dense(n_rows, m)
    real(dp), intent(inout) :: value(*), skewed(*)
    real(dp), intent(in), optional :: apart(n_rows, m)
    real(dp) :: half, mean
    integer :: i, j

    mean = 0.0_dp
    do j = 1, m
      do i = 1, j
        if (present(apart)) mean = 0.5_dp*(apart(i, j) + apart(j, i))
        half = 0.5_dp*(dense(i, j) - dense(j, i))
        associate (upper => place(i, j), lower => place(j, i))
          value(upper) = value(upper) + dense(i, j)
          skewed(upper) = skewed(upper) + half + mean
          if (i == j) cycle
          value(lower) = value(lower) + dense(j, i)
          skewed(lower) = skewed(lower) - half + mean
        end associate
      end do
    end do
  end subroutine scatter_skewed

  !> The lower triangle of the symmetric matrix beside one, which is that itself where it is symmetric.
  pure function symmetric_matrix(matrix) result(lower)
    type(sparse_matrix_t), intent(in) :: matrix
    type(factored_t) :: lower
    integer :: j, k, m

    m = (size(matrix%row) + matrix%n)/2 ! the pattern is symmetric, with a diagonal
    allocate (lower%first(matrix%n + 1), lower%row(m), lower%value(m))
    m = 0
    do j = 1, matrix%n
      lower%first(j) = m
      do k = matrix%on_diagonal(j), matrix%first(j + 1)
        m = m + 1
        lower%row(m) = matrix%row(k)
        lower%value(m) = matrix%value(k)
        if (.not. matrix%symmetric) lower%value(m) = lower%value(m) - matrix%skewed(k)
      end do
    end do
    lower%first(matrix%n + 1) = m
  end function symmetric_matrix

  !> The diagonal.
  pure function diagonal(matrix)
    type(sparse_matrix_t), intent(in) :: matrix
    real(dp) :: diagonal(matrix%n)

    diagonal = matrix%value(matrix%on_diagonal)
  end function diagonal

  !> The diagonal of the symmetric matrix beside one.
  pure function symmetric_diagonal(matrix) result(entry)
    type(sparse_matrix_t), intent(in) :: matrix
    real(dp) :: entry(matrix%n)

    entry = diagonal(matrix)
    if (.not. matrix%symmetric) entry = entry - matrix%skewed(matrix%on_diagonal)
  end function symmetric_diagonal

  !> Root of the diagonal's magnitude, which the components of A x are measured by.
  pure function root_of_diagonal(matrix) result(root)
    type(sparse_matrix_t), intent(in) :: matrix
    real(dp) :: root(matrix%n)
    integer :: j

    root = diagonal(matrix)
    do j = 1, matrix%n
      root(j) = root_of_entry(root(j), matrix%value(matrix%first(j) + 1:matrix%first(j + 1)))
    end do
  end function root_of_diagonal

  !> Root of an entry of the diagonal; where that is zero, of the largest entry of its column; where all are, 1.
  pure real(dp) function root_of_entry(entry, column)
    real(dp), intent(in) :: entry, column(:)

    root_of_entry = abs(entry)
    if (.not. root_of_entry > 0) root_of_entry = maxval(abs(column))
    if (.not. root_of_entry > 0) root_of_entry = 1.0_dp
    root_of_entry = sqrt(root_of_entry)
  end function root_of_entry

  !> y = A x. Columns that have the same rows are taken together, and each row adds them up in their order: the sums are those of
  !> one column after the other.
  pure subroutine multiply(matrix, x, y)
    type(sparse_matrix_t), intent(in) :: matrix
    real(dp), intent(in), contiguous :: x(:)
    real(dp), intent(out), contiguous :: y(:)
    integer :: j, n_rows

    y = 0.0_dp
    j = 1
    do while (j <= matrix%n)
      n_rows = matrix%first(j + 1) - matrix%first(j)
      associate (row => matrix%row(matrix%first(j) + 1:), value => matrix%value(matrix%first(j) + 1:))
        select case (matrix%alike(j)) ! the compiler unrolls these
        case (6:)
          call add_columns(n_rows, 6, row, value, x(j:), y)
          j = j + 6
        case (2:5)
          call add_columns(n_rows, 2, row, value, x(j:), y)
          j = j + 2
        case default
          call add_columns(n_rows, 1, row, value, x(j:), y)
          j = j + 1
        end select
      end associate
    end do
  end subroutine multiply

  !> Adds columns that have the same rows, each times its component of x.
  pure subroutine add_columns(n_rows, n_columns, row, value, x, y)
    integer, intent(in) :: n_rows, n_columns
    integer(c_int), intent(in) :: row(n_rows)                !! from 0
    real(c_double), intent(in) :: value(n_rows, n_columns)
    real(dp), intent(in) :: x(n_columns)
    real(dp), intent(inout) :: y(0:*)
    real(dp) :: sum
    integer :: j, k

    do k = 1, n_rows
      sum = y(row(k))
      do j = 1, n_columns
        sum = sum + value(k, j)*x(j)
      end do
      y(row(k)) = sum
    end do
  end subroutine add_columns

  !> A x.
  pure function times(matrix, x) result(y)
    type(sparse_matrix_t), intent(in) :: matrix
    real(dp), intent(in) :: x(:)
    real(dp) :: y(size(x))

    call multiply(matrix, x, y)
  end function times

  !> A x and |A| |x|.
  pure function products(matrix, x) result(y)
    type(sparse_matrix_t), intent(in) :: matrix
    real(dp), intent(in) :: x(:)
    real(dp) :: y(2, size(x))
    real(dp) :: part
    integer :: j, k

    y = 0.0_dp
    do j = 1, matrix%n
      do k = matrix%first(j) + 1, matrix%first(j + 1)
        part = matrix%value(k)*x(j)
        y(:, matrix%row(k) + 1) = y(:, matrix%row(k) + 1) + [part, abs(part)]
      end do
    end do
  end function products

end module scree_sparse_matrix
