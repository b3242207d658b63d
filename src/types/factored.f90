!> The symmetric matrix whose factor solutions go on from.
module scree_factored
  use scree_kinds, only: dp
  implicit none
  private
  public :: factored_t, is_of, move_factored, number_of, same_columns

  !> Its lower triangle in compressed columns, counted from 0: each begins with the diagonal. Not allocated: there is none.
  type :: factored_t
    integer, allocatable :: unknown(:) !! (n) of the model, of each row
    integer, allocatable :: first(:)   !! (n+1) column j owns entries first(j):first(j+1)-1
    integer, allocatable :: row(:)     !! (n_entries)
    real(dp), allocatable :: value(:)  !! (n_entries)
    integer :: spent = 0               !! iterations of the solutions since it was factorised, but for two of each
  end type factored_t

contains

  !> Whether a matrix is of these unknowns.
  pure logical function is_of(factored, unknown)
    type(factored_t), intent(in) :: factored
    integer, intent(in) :: unknown(:)

    is_of = allocated(factored%unknown)
    if (is_of) is_of = size(factored%unknown) == size(unknown)
    if (is_of) is_of = all(factored%unknown == unknown)
  end function is_of

  !> Whether two matrices in compressed columns have the same pattern.
  pure logical function same_columns(first, row, other_first, other_row)
    integer, intent(in) :: first(:), row(:), other_first(:), other_row(:) !! (n+1), (n_entries) of each

    same_columns = size(first) == size(other_first) .and. size(row) == size(other_row)
    if (same_columns) same_columns = all(first == other_first)
    if (same_columns) same_columns = all(row == other_row)
  end function same_columns

  !> Number of the matrix of some unknowns in a list; 0 where there is none.
  pure integer function number_of(list, unknown, likely)
    type(factored_t), intent(in) :: list(:)
    integer, intent(in) :: unknown(:)
    integer, intent(in) :: likely !! number that it may well have

    number_of = likely
    if (likely <= size(list)) then
      if (is_of(list(likely), unknown)) return
    end if
    do number_of = 1, size(list)
      if (is_of(list(number_of), unknown)) return
    end do
    number_of = 0
  end function number_of

  !> Moves a matrix; its place is left empty.
  pure subroutine move_factored(from, to)
    type(factored_t), intent(inout) :: from
    type(factored_t), intent(out) :: to

    call move_alloc(from%unknown, to%unknown)
    call move_alloc(from%first, to%first)
    call move_alloc(from%row, to%row)
    call move_alloc(from%value, to%value)
    to%spent = from%spent
  end subroutine move_factored

end module scree_factored
