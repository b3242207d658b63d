!> Lists of pairs of numbers, and the numbers that go with each.
module scree_pairs
  implicit none
  private
  public :: add_pair, list_others, pairs_t

  !> Pairs, in the order in which they were added.
  type :: pairs_t
    integer, allocatable :: one(:), other(:) !! (1:n), with room for more
    integer :: n = 0
  end type pairs_t

contains

  !> Adds a pair to a list.
  pure subroutine add_pair(pairs, one, other)
    type(pairs_t), intent(inout) :: pairs
    integer, intent(in) :: one, other
    integer, allocatable :: longer(:)

    if (.not. allocated(pairs%one)) allocate (pairs%one(1024), pairs%other(1024))
    if (pairs%n == size(pairs%one)) then
      allocate (longer(2*pairs%n))
      longer(:pairs%n) = pairs%one
      pairs%one = longer
      longer(:pairs%n) = pairs%other
      call move_alloc(longer, pairs%other)
    end if
    pairs%n = pairs%n + 1
    pairs%one(pairs%n) = one
    pairs%other(pairs%n) = other
  end subroutine add_pair

  !> Lists the others of each one, in the order in which the pairs were added.
  pure subroutine list_others(pairs, first, other)
    type(pairs_t), intent(in) :: pairs
    integer, intent(out) :: first(:)         !! (n_ones+1) those of one k are other(first(k):first(k+1)-1)
    integer, intent(out) :: other(:)         !! (n_pairs)
    integer :: i

    first = 0
    do i = 1, pairs%n
      first(pairs%one(i) + 1) = first(pairs%one(i) + 1) + 1
    end do
    first(1) = 1
    do i = 2, size(first)
      first(i) = first(i) + first(i - 1)
    end do
    do i = 1, pairs%n
      associate (at => first(pairs%one(i)))
        other(at) = pairs%other(i)
        at = at + 1
      end associate
    end do
    first(2:) = first(:size(first) - 1) ! listing moved every start to its end
    first(1) = 1
  end subroutine list_others

end module scree_pairs
