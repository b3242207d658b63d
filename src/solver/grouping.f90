!> Which elements are solved together.
module scree_grouping
  use scree_sets, only: root_of, unite
  use scree_system, only: elements_t
  implicit none
  private
  public :: find_groups, sort_into

contains

  !> Gives the elements that can move their groups: first those of one element that shares no unknown and is in no pair, then the
  !> islands, elements that are linked and pairs of what can move, in the order of their first elements.
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

end module scree_grouping
