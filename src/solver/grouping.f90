!> Which elements are solved together.
module scree_grouping
  use scree_sets, only: root_of, unite
  use scree_system, only: elements_t
  implicit none
  private
  public :: find_groups

contains

  !> Numbers the groups of the elements that can move. Groups of a single element come first; such an element shares no unknown and
  !> is in no pair. The islands follow, in the order of their first elements. An island joins elements that are linked or that form
  !> a pair.
  pure subroutine find_groups(elements, pair, one_island, group_of, n_alone, n_groups)
    type(elements_t), intent(in) :: elements
    integer, intent(in) :: pair(:, :)         !! (2, n_pairs) elements that something acts between
    logical, intent(in) :: one_island         !! there is one at most
    integer, intent(out) :: group_of(:)       !! (n_elements) 0: it cannot move
    integer, intent(out) :: n_alone, n_groups !! groups of one alone, and all
    integer :: root(size(group_of))           !! first element of the island
    logical :: can_move(size(group_of)), in_island(size(group_of))
    integer :: e, i, k

    root = elements%linked
    can_move = .false.
    can_move(elements%free) = .true.
    in_island = .false.
    do i = 1, size(pair, 2)
      in_island(pair(:, i)) = .true.
      if (all(can_move(pair(:, i)))) call unite(root, pair(1, i), pair(2, i))
    end do
    do k = 1, size(elements%free)
      e = elements%free(k)
      root(e) = root_of(root, e)
      if (root(e) /= e) in_island([e, root(e)]) = .true.
    end do
    in_island = in_island .and. can_move
    if (one_island) then
      e = findloc(in_island, .true., 1)
      where (in_island) root = e
    end if

    group_of = 0
    n_groups = 0
    do k = 1, size(elements%free)
      e = elements%free(k)
      if (in_island(e)) cycle
      n_groups = n_groups + 1
      group_of(e) = n_groups
    end do
    n_alone = n_groups
    do k = 1, size(elements%free)
      e = elements%free(k)
      if (.not. in_island(e)) cycle
      if (group_of(root(e)) == 0) then
        n_groups = n_groups + 1
        group_of(root(e)) = n_groups
      end if
      group_of(e) = group_of(root(e))
    end do
  end subroutine find_groups

end module scree_grouping
