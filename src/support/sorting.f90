!> Sorting.
module scree_sorting
  use scree_kinds, only: dp
  implicit none
  private
  public :: sort_by

contains

  !> Sorts numbers ascending and takes a list with them; equal ones stay in their order (merge sort).
  pure recursive subroutine sort_by(x, list)
    real(dp), intent(inout) :: x(:)
    integer, intent(inout) :: list(:)  !! of the same size
    real(dp) :: sorted_x(size(x))
    integer :: sorted(size(x)), from, k, left, middle, right

    if (size(x) < 2) return
    middle = size(x)/2
    call sort_by(x(:middle), list(:middle))
    call sort_by(x(middle + 1:), list(middle + 1:))
    left = 1
    right = middle + 1
    do k = 1, size(x)
      from = left
      if (left > middle) then
        from = right
      else if (right <= size(x)) then
        if (x(right) < x(left)) from = right
      end if
      sorted_x(k) = x(from)
      sorted(k) = list(from)
      if (from <= middle) then
        left = left + 1
      else
        right = right + 1
      end if
    end do
    x = sorted_x
    list = sorted
  end subroutine sort_by

end module scree_sorting
