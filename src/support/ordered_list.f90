!> A list whose order only its user can tell, by comparing things that change while the list is used.
!>
!> The items are numbers from 1. The list is a splay tree (Sleator and Tarjan 1985, "Self-adjusting binary search trees",
!> section 2), so n calls, and n searches that end with `bring_up`, take a time of order n log n.
module scree_ordered_list
  implicit none
  private
  public :: bring_up, find_before, insert_after, ordered_list_t, remove_item, replace_item, set_up_list

  !> A search begins at `root`. The items of the subtree lower(i) come before item i, those of upper(i) come after item i.
  type :: ordered_list_t
    integer :: root = 0                          !! 0: the list is empty
    integer, allocatable :: lower(:), upper(:)   !! (n) root of the subtree, 0: there is none
    integer, allocatable :: parent(:)            !! (n) 0: there is none
  end type ordered_list_t

contains

  !> Makes a list without items, with room for the items 1 to n.
  pure subroutine set_up_list(list, n)
    type(ordered_list_t), intent(out) :: list
    integer, intent(in) :: n

    allocate (list%lower(n), list%upper(n), list%parent(n), source=0)
  end subroutine set_up_list

  !> Puts an item directly after another one, or before all items.
  pure subroutine insert_after(list, item, other)
    type(ordered_list_t), intent(inout) :: list
    integer, intent(in) :: item
    integer, intent(in) :: other   !! 0: the item comes first
    integer :: later

    later = list%root
    if (other > 0) then
      call bring_up(list, other)
      later = list%upper(other)
      list%upper(other) = 0
    end if
    call set_children(list, item, other, later)
    call set_root(list, item)
  end subroutine insert_after

  !> Takes an item out of the list.
  pure subroutine remove_item(list, item)
    type(ordered_list_t), intent(inout) :: list
    integer, intent(in) :: item
    integer :: before

    call find_before(list, item, before)
    if (before > 0) then ! `before` is the last of the items below `item`, so nothing is above it there
      call set_children(list, before, list%lower(before), list%upper(item))
      call set_root(list, before)
    else
      call set_root(list, list%upper(item))
    end if
  end subroutine remove_item

  !> Puts a new item where another one was; the other one leaves the list.
  pure subroutine replace_item(list, item, new)
    type(ordered_list_t), intent(inout) :: list
    integer, intent(in) :: item, new

    call bring_up(list, item)
    call set_children(list, new, list%lower(item), list%upper(item))
    call set_root(list, new)
  end subroutine replace_item

  !> Finds the item directly before another one; the other one becomes the root, and the item before it is right below.
  pure subroutine find_before(list, item, before)
    type(ordered_list_t), intent(inout) :: list
    integer, intent(in) :: item
    integer, intent(out) :: before   !! 0: `item` is the first
    integer :: later

    call bring_up(list, item)
    before = list%lower(item)
    if (before == 0) return
    do
      later = list%upper(before)
      if (later == 0) exit
      before = later
    end do
    call bring_up(list, before, item)
  end subroutine find_before

  !> Makes an item the root by rotations that halve the depth of the items on its way, or the child of an item above it.
  pure subroutine bring_up(list, item, below)
    type(ordered_list_t), intent(inout) :: list
    integer, intent(in) :: item
    integer, intent(in), optional :: below   !! becomes the parent of `item`; absent: `item` becomes the root
    integer :: over, top

    top = 0
    if (present(below)) top = below
    do while (list%parent(item) /= top)
      over = list%parent(item)
      if (list%parent(over) /= top) then
        if ((list%lower(over) == item) .eqv. (list%lower(list%parent(over)) == over)) then
          call rotate_up(list, over)
        else
          call rotate_up(list, item)
        end if
      end if
      call rotate_up(list, item)
    end do
    if (top == 0) list%root = item
  end subroutine bring_up

  !> Makes an item the parent of its parent, in the same order.
  pure subroutine rotate_up(list, item)
    type(ordered_list_t), intent(inout) :: list
    integer, intent(in) :: item
    integer :: over, top

    over = list%parent(item)
    top = list%parent(over)
    if (list%lower(over) == item) then
      call set_children(list, over, list%upper(item), list%upper(over))
      call set_children(list, item, list%lower(item), over)
    else
      call set_children(list, over, list%lower(over), list%lower(item))
      call set_children(list, item, over, list%upper(item))
    end if
    list%parent(item) = top
    if (top == 0) return
    if (list%lower(top) == over) then
      list%lower(top) = item
    else
      list%upper(top) = item
    end if
  end subroutine rotate_up

  !> Gives an item its subtrees.
  pure subroutine set_children(list, item, lower, upper)
    type(ordered_list_t), intent(inout) :: list
    integer, intent(in) :: item
    integer, value :: lower, upper   !! 0: there is none

    list%lower(item) = lower
    list%upper(item) = upper
    if (lower > 0) list%parent(lower) = item
    if (upper > 0) list%parent(upper) = item
  end subroutine set_children

  !> Makes an item the root.
  pure subroutine set_root(list, item)
    type(ordered_list_t), intent(inout) :: list
    integer, value :: item   !! 0: the list becomes empty

    list%root = item
    if (item > 0) list%parent(item) = 0
  end subroutine set_root

end module scree_ordered_list
