!> Contacts by their pairs of a vertex and an edge, and the pairs of elements that they act between.
module scree_contact_pairs
  use scree_contacts, only: contact_t
  use scree_kinds, only: dp
  use scree_pairs, only: pair_key, pair_of
  use scree_sorting, only: order_of_pairs
  implicit none
  private
  public :: drop_repeats, has_same_entrances, list_entrances, number_pairs, pairs_of_contacts, place_of_pair

contains

  !> Entrances of contacts by their pairs of vertex and edge, sorted.
  pure subroutine list_entrances(contact, n, number, key)
    type(contact_t), intent(in) :: contact(:)
    integer, intent(in) :: n                          !! vertices of the outlines
    integer, allocatable, intent(out) :: number(:)    !! 2 k - 1 and 2 k are the entrances of contact k
    real(dp), allocatable, intent(out) :: key(:)
    integer, allocatable :: edge(:), order(:), vertex(:)
    integer :: i, k, m

    m = sum(contact%n_entrances)
    allocate (number(m), vertex(m), edge(m))
    m = 0
    do i = 1, size(contact)
      do k = 1, contact(i)%n_entrances
        m = m + 1
        number(m) = 2*i - 2 + k
        vertex(m) = contact(i)%entrance(k)%vertex
        edge(m) = contact(i)%entrance(k)%edge
      end do
    end do
    order = order_of_pairs(vertex, edge)
    number = number(order)
    key = pair_key(vertex(order), edge(order), n)
  end subroutine list_entrances

  !> First place of a pair in the keys that `list_entrances` made; 0 where there is none.
  pure integer function place_of_pair(key, vertex, edge, n)
    real(dp), intent(in) :: key(:)
    integer, intent(in) :: vertex, edge
    integer, intent(in) :: n                          !! vertices of the outlines
    integer :: high, low, middle
    real(dp) :: wanted

    place_of_pair = 0
    if (size(key) == 0) return
    wanted = pair_key(vertex, edge, n)
    low = 1
    high = size(key)
    do while (low < high)
      middle = (low + high)/2
      if (key(middle) < wanted) then
        low = middle + 1
      else
        high = middle
      end if
    end do
    if (.not. abs(key(low) - wanted) > 0.5_dp) place_of_pair = low
  end function place_of_pair

  !> Drops contacts of one entrance that another contact has too, as of an edge so short that both its ends are near, and those that
  !> another is the same as.
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
        else if (has_same_entrances(contact(a), contact(b))) then
          keep(max(a, b)) = .false.
        end if
      end associate
    end do
    n_contacts = count(keep)
    contact(:n_contacts) = pack(contact(:size(keep)), keep)
  end subroutine drop_repeats

  !> Whether two contacts are made of the same pairs of vertex and edge.
  pure logical function has_same_entrances(a, b) result(same)
    type(contact_t), intent(in) :: a, b
    integer :: k

    same = a%n_entrances == b%n_entrances
    if (.not. same) return
    do k = 1, a%n_entrances
      same = same .and. a%entrance(k)%vertex == b%entrance(k)%vertex .and. a%entrance(k)%edge == b%entrance(k)%edge
    end do
  end function has_same_entrances

  !> Pairs of elements that contacts act between.
  pure function pairs_of_contacts(element, contact) result(pair)
    integer, intent(in) :: element(:)          !! (n) that carries each vertex and edge of the outlines
    type(contact_t), intent(in) :: contact(:)
    integer :: pair(2, sum(contact%n_entrances))
    integer :: i, k, m

    m = 0
    do i = 1, size(contact)
      do k = 1, contact(i)%n_entrances
        m = m + 1
        pair(:, m) = pair_of(element(contact(i)%entrance(k)%vertex), element(contact(i)%entrance(k)%edge))
      end do
    end do
  end function pairs_of_contacts

  !> Gives every entrance the number of its pair of elements.
  pure subroutine number_pairs(number, contact)
    integer, intent(in) :: number(:)           !! of the pairs, as `pairs_of_contacts` lists them
    type(contact_t), intent(inout) :: contact(:)
    integer :: i, k, m

    m = 0
    do i = 1, size(contact)
      do k = 1, contact(i)%n_entrances
        m = m + 1
        contact(i)%entrance(k)%pair = number(m)
      end do
    end do
  end subroutine number_pairs

end module scree_contact_pairs
