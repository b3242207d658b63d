!> Pairs of elements that the equations couple: what acts between two bodies acts between the elements of a pair.
module scree_pairs
  use scree_kinds, only: dp
  use scree_sorting, only: order_of_pairs
  implicit none
  private
  public :: list_pairs, number_of_pair, pair_key, pair_of

  !> Pairs over those that are needed, up to which those that no longer are stay.
  real(dp), parameter :: idle = 1.5_dp

contains

  !> The pair of two elements, the smaller number first.
  pure function pair_of(a, b) result(pair)
    integer, intent(in) :: a, b
    integer :: pair(2)

    pair = [min(a, b), max(a, b)]
  end function pair_of

  !> Pairs of a step in order, each once. Those of the step before stay while they are no great part, so that the equations keep
  !> their pattern.
  pure function list_pairs(needed, before) result(pairs)
    integer, intent(in) :: needed(:, :)   !! (2, n)
    integer, intent(in) :: before(:, :)   !! (2, n) in order
    integer, allocatable :: pairs(:, :)   !! (2, n_pairs)
    integer, allocatable :: fewest(:, :)
    integer :: i
    logical :: known

    fewest = sorted_pairs(needed)
    known = .true.
    do i = 1, size(fewest, 2)
      known = known .and. holds(before, fewest(:, i))
    end do
    if (known) then
      pairs = before
    else
      pairs = sorted_pairs(reshape([fewest, before], [2, size(fewest, 2) + size(before, 2)]))
    end if
    if (size(pairs, 2) > idle*size(fewest, 2)) pairs = fewest
  end function list_pairs

  !> Whether pairs in order hold one.
  pure logical function holds(pairs, pair)
    integer, intent(in) :: pairs(:, :), pair(2)

    holds = .false.
    if (size(pairs, 2) > 0) holds = all(pairs(:, number_of_pair(pairs, pair)) == pair)
  end function holds

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

  !> Number of a pair among those that `list_pairs` made and that hold it.
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

  !> One number for two whole numbers, the second up to n; exact while their product is below 9e15.
  elemental real(dp) function pair_key(first, second, n)
    integer, intent(in) :: first, second, n

    pair_key = real(first, dp)*n + second
  end function pair_key

end module scree_pairs
