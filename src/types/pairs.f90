!> Pairs of elements that the equations couple: effects between two bodies act between the elements of a pair.
module scree_pairs
  use scree_kinds, only: dp
  use scree_sorting, only: columns, order_of_pairs
  implicit none
  private
  public :: list_pairs, number_of_pair, numbers_of_pairs, pair_of, pairs_without, sorted_pairs

  !> Pairs over those that are needed, up to which those that no longer are stay.
  real(dp), parameter :: idle = 1.5_dp

contains

  !> The pair of two elements, the smaller number first.
  pure function pair_of(a, b) result(pair)
    integer, intent(in) :: a, b
    integer :: pair(2)

    pair = [min(a, b), max(a, b)]
  end function pair_of

  !> Pairs of a step in order, each once, and the numbers that those needed have there. Those of the step before stay while they are
  !> no great part, so that the equations keep their pattern.
  pure subroutine list_pairs(needed, before, pairs, number)
    integer, intent(in) :: needed(:, :)   !! (2, n)
    integer, intent(in) :: before(:, :)   !! (2, n) in order
    integer, allocatable, intent(out) :: pairs(:, :) !! (2, n_pairs)
    integer, allocatable, intent(out) :: number(:)   !! (n)
    integer, allocatable :: fewest(:, :)
    logical :: is_needed(size(before, 2))

    number = numbers_of_pairs(before, needed)
    if (all(number > 0)) then
      is_needed = .false.
      is_needed(number) = .true.
      pairs = before
      if (size(pairs, 2) <= idle*count(is_needed)) return
      pairs = columns(before, is_needed)
    else
      fewest = sorted_pairs(needed)
      pairs = sorted_pairs(reshape([fewest, before], [2, size(fewest, 2) + size(before, 2)]))
      if (size(pairs, 2) > idle*size(fewest, 2)) pairs = fewest
    end if
    number = numbers_of_pairs(pairs, needed)
  end subroutine list_pairs

  !> Positions of pairs in an ordered list; 0 for a pair that is not in it.
  pure function numbers_of_pairs(pairs, list) result(number)
    integer, intent(in) :: pairs(:, :), list(:, :) !! (2, n)
    integer :: number(size(list, 2))
    integer :: i, k

    number = 0
    if (size(pairs, 2) == 0) return
    k = 1
    do i = 1, size(number)
      if (any(pairs(:, k) /= list(:, i))) k = number_of_pair(pairs, list(:, i)) ! contacts of the same two lie together
      if (all(pairs(:, k) == list(:, i))) number(i) = k
    end do
  end function numbers_of_pairs

  !> Pairs that others, which are in order, do not hold.
  pure function pairs_without(pairs, others) result(rest)
    integer, intent(in) :: pairs(:, :), others(:, :) !! (2, n)
    integer, allocatable :: rest(:, :)
    integer :: i

    rest = pairs(:, pack([(i, i=1, size(pairs, 2))], numbers_of_pairs(others, pairs) == 0))
  end function pairs_without

  !> Pairs in order, each once.
  pure function sorted_pairs(pair) result(sorted)
    integer, intent(in) :: pair(:, :)
    integer, allocatable :: sorted(:, :)
    integer :: order(size(pair, 2)), i
    logical :: new(size(pair, 2))

    order = order_of_pairs(pair(1, :), pair(2, :))
    new = .true.
    do i = 2, size(order)
      new(i) = any(pair(:, order(i)) /= pair(:, order(i - 1)))
    end do
    sorted = pair(:, pack(order, new))
  end function sorted_pairs

  !> Position of a pair in a list of `list_pairs` that contains it.
  pure integer function number_of_pair(pairs, pair) result(low)
    integer, intent(in) :: pairs(:, :), pair(2)
    integer :: high, middle

    low = 1
    high = size(pairs, 2)
    do while (low < high)
      middle = (low + high)/2
      if (pairs(1, middle) < pair(1) .or. (pairs(1, middle) == pair(1) .and. pairs(2, middle) < pair(2))) then
        low = middle + 1
      else
        high = middle
      end if
    end do
  end function number_of_pair

end module scree_pairs
