!> Contacts by their pairs of a vertex and an edge, and the pairs of elements that they act between.
module scree_contact_pairs
  use scree_contact_lists, only: entrances_t
  use scree_contacts, only: contact_t, outlines_t, state_open
  use scree_pairs, only: pair_of
  implicit none
  private
  public :: contact_of, drop_repeats, entrance_of, entrances_t, has_same_entrances, list_entrances, number_pairs, &
            pairs_of_contacts, place_of_pair

contains

  !> Lists the entrances of contacts by vertex and edge; those of the same stay in their order.
  pure subroutine list_entrances(contact, n, entrances)
    type(contact_t), intent(in) :: contact(:)
    integer, intent(in) :: n                          !! vertices of the outlines
    type(entrances_t), intent(inout) :: entrances     !! new, or of an earlier list
    integer :: listed(2*size(contact)) ! vertices
    integer :: i, k, n_entrances, n_listed

    if (allocated(entrances%vertex)) then
      entrances%last(entrances%vertex) = 0
      deallocate (entrances%edge, entrances%number)
    else
      allocate (entrances%first(n), source=1)
      allocate (entrances%last(n), source=0)
    end if
    n_listed = 0
    do i = 1, size(contact)
      do k = 1, contact(i)%n_entrances
        associate (vertex => contact(i)%entrance(k)%vertex)
          if (entrances%last(vertex) == 0) then
            n_listed = n_listed + 1
            listed(n_listed) = vertex
          end if
          entrances%last(vertex) = entrances%last(vertex) + 1 ! their number
        end associate
      end do
    end do
    entrances%vertex = listed(:n_listed)
    n_entrances = 0
    do i = 1, n_listed
      associate (vertex => listed(i))
        entrances%first(vertex) = n_entrances + 1
        n_entrances = n_entrances + entrances%last(vertex)
        entrances%last(vertex) = entrances%first(vertex) - 1
      end associate
    end do
    allocate (entrances%edge(n_entrances), entrances%number(n_entrances))
    do i = 1, size(contact)
      do k = 1, contact(i)%n_entrances
        associate (entrance => contact(i)%entrance(k))
          call put_in(entrance%edge, 2*i - 2 + k, entrances%first(entrance%vertex), entrances%last(entrance%vertex), &
                      entrances%edge, entrances%number)
        end associate
      end do
    end do
  end subroutine list_entrances

  !> Contact of the entrance of a number: 2 k - 1 and 2 k are those of contact k.
  elemental integer function contact_of(number)
    integer, intent(in) :: number

    contact_of = (number + 1)/2
  end function contact_of

  !> Which of the entrances of its contact has a number, 1 or 2.
  elemental integer function entrance_of(number)
    integer, intent(in) :: number

    entrance_of = 2 - modulo(number, 2)
  end function entrance_of

  !> Puts an entrance in its place among those of its vertex, which are from `first` to `last`.
  pure subroutine put_in(edge, number, first, last, edges, numbers)
    integer, intent(in) :: edge, number, first
    integer, intent(inout) :: last
    integer, intent(inout) :: edges(:), numbers(:) !! of the entrances
    integer :: at

    last = last + 1
    do at = last, first + 1, -1
      if (edges(at - 1) <= edge) exit
      edges(at) = edges(at - 1)
      numbers(at) = numbers(at - 1)
    end do
    edges(at) = edge
    numbers(at) = number
  end subroutine put_in

  !> First place of a pair among entrances; 0 where there is none.
  pure integer function place_of_pair(entrances, vertex, edge) result(place)
    type(entrances_t), intent(in) :: entrances
    integer, intent(in) :: vertex, edge

    do place = entrances%first(vertex), entrances%last(vertex)
      if (entrances%edge(place) == edge) return
    end do
    place = 0
  end function place_of_pair

  !> Drops contacts of one entrance that another contact has, too, as at an edge so short that both its ends are near, and contacts
  !> that are the same as another one. Of two contacts of one entrance, the one that continues the step before stays.
  pure subroutine drop_repeats(n, contact, n_contacts, entrances)
    integer, intent(in) :: n                          !! vertices of the outlines
    type(contact_t), intent(inout) :: contact(:)
    integer, intent(inout) :: n_contacts
    type(entrances_t), intent(inout) :: entrances     !! new, or of an earlier list; gets those of all contacts that were given
    logical :: keep(n_contacts)
    integer :: i, k, m

    call list_entrances(contact(:n_contacts), n, entrances)
    keep = .true.
    do i = 1, size(entrances%vertex)
      do k = entrances%first(entrances%vertex(i)) + 1, entrances%last(entrances%vertex(i))
        do m = k - 1, entrances%first(entrances%vertex(i)), -1
          if (entrances%edge(m) < entrances%edge(k)) exit
          associate (a => contact_of(entrances%number(m)), b => contact_of(entrances%number(k)))
            if (contact(b)%n_entrances == 1 .and. .not. goes_on_alone(contact(b), contact(a))) then
              keep(b) = .false.
            else if (contact(a)%n_entrances == 1) then
              keep(a) = .false.
            else if (has_same_entrances(contact(a), contact(b))) then
              keep(max(a, b)) = .false.
            end if
          end associate
        end do
      end do
    end do
    if (all(keep)) return
    n_contacts = count(keep)
    contact(:n_contacts) = pack(contact(:size(keep)), keep)
  end subroutine drop_repeats

  !> Whether a contact goes on closed from the step before, and another one of its pair, of one entrance too, does not.
  pure logical function goes_on_alone(contact, other)
    type(contact_t), intent(in) :: contact, other

    goes_on_alone = other%n_entrances == 1 .and. contact%entrance(1)%state /= state_open .and. other%entrance(1)%state == state_open
  end function goes_on_alone

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
  pure function pairs_of_contacts(outlines, contact) result(pair)
    type(outlines_t), intent(in) :: outlines
    type(contact_t), intent(in) :: contact(:)
    integer :: pair(2, sum(contact%n_entrances))
    integer :: i, k, m

    m = 0
    do i = 1, size(contact)
      do k = 1, contact(i)%n_entrances
        m = m + 1
        pair(:, m) = pair_of(outlines%of_vertex(contact(i)%entrance(k)%vertex), outlines%element(contact(i)%entrance(k)%edge))
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
