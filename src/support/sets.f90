!> Sets of numbers that become one (union and find): each number has a root, the lowest of its set, or is on the way to it.
module scree_sets
  implicit none
  private
  public :: root_of, unite

contains

  !> The lowest number of the set of `i`.
  pure integer function root_of(root, i)
    integer, intent(in) :: root(:)   !! of each number, itself to begin with
    integer, intent(in) :: i

    root_of = i
    do while (root(root_of) /= root_of)
      root_of = root(root_of)
    end do
  end function root_of

  !> Makes two sets one, whose root is the lower.
  pure subroutine unite(root, i, j)
    integer, intent(inout) :: root(:)
    integer, intent(in) :: i, j
    integer :: a, b, next

    a = root_of(root, i)
    b = root_of(root, j)
    root(max(a, b)) = min(a, b)
    b = min(a, b)
    a = i
    do while (root(a) /= b) ! shorter ways from now on
      next = root(a)
      root(a) = b
      a = next
    end do
    a = j
    do while (root(a) /= b)
      next = root(a)
      root(a) = b
      a = next
    end do
  end subroutine unite

end module scree_sets
