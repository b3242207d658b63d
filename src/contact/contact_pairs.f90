!> Contacts by their pairs of a vertex and an edge, and the pairs of elements that they link.
module scree_contact_pairs
  use scree_contacts, only: contact_t, contacts_t, entrance_t, outlines_t
  use scree_kinds, only: dp
  use scree_sorting, only: sort_by
  implicit none
  private
  public :: drop_repeats, entrance_of_pair, list_entrances, put_links

contains

  !> Lines of contacts by the pairs of vertex and edge, sorted.
  pure subroutine list_entrances(contact, n, number, key)
    type(contact_t), intent(in) :: contact(:)
    integer, intent(in) :: n                          !! vertices of the outlines
    integer, allocatable, intent(out) :: number(:)    !! 2 k - 1 and 2 k are the lines of contact k
    real(dp), allocatable, intent(out) :: key(:)
    integer :: i, k, m

    allocate (number(sum(contact%n_entrances)), key(sum(contact%n_entrances)))
    m = 0
    do i = 1, size(contact)
      do k = 1, contact(i)%n_entrances
        m = m + 1
        number(m) = 2*i - 2 + k
        key(m) = pair_key(contact(i)%entrance(k)%vertex, contact(i)%entrance(k)%edge, n)
      end do
    end do
    call sort_by(key, number)
  end subroutine list_entrances

  !> Number of the line of a pair in a list that `list_lines` made; 0 where there is none.
  pure integer function entrance_of_pair(number, key, vertex, edge, n)
    integer, intent(in) :: number(:)
    real(dp), intent(in) :: key(:)
    integer, intent(in) :: vertex, edge
    integer, intent(in) :: n                          !! vertices of the outlines
    integer :: high, low, middle
    real(dp) :: wanted

    entrance_of_pair = 0
    if (size(number) == 0) return
    wanted = pair_key(vertex, edge, n)
    low = 1
    high = size(number)
    do while (low < high)
      middle = (low + high)/2
      if (key(middle) < wanted) then
        low = middle + 1
      else
        high = middle
      end if
    end do
    if (.not. abs(key(low) - wanted) > 0.5_dp) entrance_of_pair = number(low)
  end function entrance_of_pair

  !> Drops contacts of one line that another contact has too, as of an edge so short that both its ends are near.
  pure subroutine drop_repeats(n, contact, n_contacts)
    integer, intent(in) :: n                          !! vertices of the outlines
    type(contact_t), intent(inout) :: contact(:)
    integer, intent(inout) :: n_contacts
    integer, allocatable :: number(:)
    real(dp), allocatable :: key(:)
    logical :: keep(n_contacts)
    integer :: k

    call list_entrances(contact(:n_contacts), n, number, key)
    keep = .true.
    do k = 2, size(key)
      if (key(k) > key(k - 1) + 0.5_dp) cycle
      associate (a => (number(k - 1) + 1)/2, b => (number(k) + 1)/2)
        if (contact(b)%n_entrances == 1) then
          keep(b) = .false.
        else if (contact(a)%n_entrances == 1) then
          keep(a) = .false.
        end if
      end associate
    end do
    n_contacts = count(keep)
    contact(:n_contacts) = pack(contact(:size(keep)), keep)
  end subroutine drop_repeats

  !> One number for a vertex and an edge, exact up to 9e7 of them.
  pure real(dp) function pair_key(vertex, edge, n)
    integer, intent(in) :: vertex, edge, n

    pair_key = real(vertex, dp)*n + edge
  end function pair_key

  !> Pairs of elements of contacts; those of earlier contacts of the same search stay, so that the equations keep their form.
  pure subroutine put_links(outlines, found, contacts)
    type(outlines_t), intent(in) :: outlines
    type(contact_t), intent(inout) :: found(:)
    type(contacts_t), intent(inout) :: contacts
    real(dp) :: key(2*size(found) + size(contacts%link, 2))
    integer :: pair(2, size(key)), order(size(key)), i, k, n, n_elements

    do i = 1, size(found)
      if (found(i)%n_entrances == 1) found(i)%entrance(2) = found(i)%entrance(1)
      do k = 1, 2
        pair(:, 2*i - 2 + k) = pair_of(found(i)%entrance(k))
      end do
    end do
    pair(:, 2*size(found) + 1:) = contacts%link
    n_elements = maxval(outlines%element)
    do i = 1, size(key)
      order(i) = i
      key(i) = pair_key(pair(1, i), pair(2, i), n_elements)
    end do
    call sort_by(key, order)
    n = 0
    deallocate (contacts%link)
    allocate (contacts%link(2, size(key)))
    do i = 1, size(key)
      if (n == 0 .or. key(i) > key(max(1, i - 1)) + 0.5_dp) n = n + 1
      contacts%link(:, n) = pair(:, order(i))
      if (order(i) <= 2*size(found)) found((order(i) + 1)/2)%entrance(2 - modulo(order(i), 2))%link = n
    end do
    contacts%link = contacts%link(:, :n)

  contains

    !> The elements of a line.
    pure function pair_of(entrance) result(pair)
      type(entrance_t), intent(in) :: entrance
      integer :: pair(2), a, b

      a = outlines%element(entrance%vertex)
      b = outlines%element(entrance%edge)
      pair = [min(a, b), max(a, b)]
    end function pair_of

  end subroutine put_links

end module scree_contact_pairs
