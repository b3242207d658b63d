!> Sorting by numbers and into boxes, and selecting columns of a list.
module scree_sorting
  use scree_kinds, only: dp
  implicit none
  private
  public :: columns, order_of_pairs, order_of_places, sort_by, sort_into

  integer, parameter :: sparse = 8 !! times as many numbers as items, beyond which counting them takes longer than comparing items

contains

  !> Sorts numbers ascending and takes a list with them; equal ones stay in their order (merge sort).
  pure subroutine sort_by(x, list)
    real(dp), intent(inout), contiguous :: x(:)
    integer, intent(inout), contiguous :: list(:)  !! of the same size
    real(dp) :: lower_x(size(x)/2)
    integer :: lower(size(x)/2)

    call sort_part(x, list, lower_x, lower)
  end subroutine sort_by

  !> Sorts a part: its halves, and merges them where they are not in order.
  pure recursive subroutine sort_part(x, list, lower_x, lower)
    real(dp), intent(inout), contiguous :: x(:)
    integer, intent(inout), contiguous :: list(:)
    real(dp), intent(inout) :: lower_x(:) !! room for the lower half
    integer, intent(inout) :: lower(:)
    integer :: k, left, middle, right

    if (size(x) < 2) return
    middle = size(x)/2
    call sort_part(x(:middle), list(:middle), lower_x, lower)
    call sort_part(x(middle + 1:), list(middle + 1:), lower_x, lower)
    if (.not. x(middle + 1) < x(middle)) return
    lower_x(:middle) = x(:middle)
    lower(:middle) = list(:middle)
    left = 1
    right = middle + 1
    do k = 1, size(x)
      if (left > middle) return ! what is left of the upper half is in place
      if (right <= size(x)) then
        if (x(right) < lower_x(left)) then
          x(k) = x(right)
          list(k) = list(right)
          right = right + 1
          cycle
        end if
      end if
      x(k) = lower_x(left)
      list(k) = lower(left)
      left = left + 1
    end do
  end subroutine sort_part

  !> Order of pairs of whole numbers from 1, ascending by the first and then by the second; equal ones stay in their order.
  !>
  !> They are counted by the second, then by the first, as a radix sort does: the time grows with their number.
  pure function order_of_pairs(first, second) result(order)
    integer, intent(in) :: first(:), second(:) !! (n)
    integer, allocatable :: order(:)
    integer :: i

    order = [(i, i=1, size(first))]
    call sort_by_number(second, order)
    call sort_by_number(first, order)
  end function order_of_pairs

  !> Sorts a list of items by their numbers, which are counted, unless most of them were none; equal ones stay in their order.
  pure subroutine sort_by_number(number, list)
    integer, intent(in) :: number(:)    !! from 1, of each item
    integer, intent(inout) :: list(:)
    integer, allocatable :: first(:), place(:)
    real(dp), allocatable :: key(:)

    if (size(list) == 0) return
    if (maxval(number) > sparse*size(number)) then
      key = real(number(list), dp)
      call sort_by(key, list)
      return
    end if
    call sort_into(number(list), maxval(number), first, place)
    list = list(place)
  end subroutine sort_by_number

  !> Order of places ascending by x, and by y where x is the same; places that coincide stay in their order.
  pure function order_of_places(position) result(order)
    real(dp), intent(in) :: position(:, :) !! (2, n)
    integer :: order(size(position, 2))
    real(dp) :: x(size(order)), y(size(order))
    integer :: from, k, to

    order = [(k, k=1, size(order))]
    x = position(1, :)
    call sort_by(x, order)
    y = position(2, order)
    from = 1
    do while (from <= size(order)) ! the places with one x are from:to
      to = from
      do while (to < size(order))
        if (x(to + 1) > x(from)) exit
        to = to + 1
      end do
      call sort_by(y(from:to), order(from:to))
      from = to + 1
    end do
  end function order_of_places

  !> Sorts things into boxes: box b has thing(first(b):first(b+1)-1), in their order.
  pure subroutine sort_into(box, n_boxes, first, thing)
    integer, intent(in) :: box(:)             !! of each thing, 0: none
    integer, intent(in) :: n_boxes
    integer, allocatable, intent(out) :: first(:), thing(:)
    integer :: filled(n_boxes), i

    allocate (first(n_boxes + 1), source=0)
    do i = 1, size(box)
      if (box(i) > 0) first(box(i) + 1) = first(box(i) + 1) + 1
    end do
    first(1) = 1
    do i = 1, n_boxes
      first(i + 1) = first(i) + first(i + 1)
    end do
    filled = first(:n_boxes)
    allocate (thing(first(n_boxes + 1) - 1))
    do i = 1, size(box)
      if (box(i) == 0) cycle
      thing(filled(box(i))) = i
      filled(box(i)) = filled(box(i)) + 1
    end do
  end subroutine sort_into

  !> Some columns of a list of pairs, in their order.
  pure function columns(list, which)
    integer, intent(in) :: list(:, :)   !! (2, n)
    logical, intent(in) :: which(:)     !! (n)
    integer :: columns(2, count(which))

    columns = reshape(pack(list, spread(which, 1, 2)), [2, count(which)])
  end function columns

end module scree_sorting
