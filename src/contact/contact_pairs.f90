!> Contacts by their pairs of a vertex and an edge, and the pairs of elements that they couple.
module scree_contact_pairs
  use scree_contacts, only: contact_t, entrance_t, outlines_t
  use scree_kinds, only: dp
  use scree_sorting, only: sort_by
  implicit none
  private
  public :: drop_repeats, entrance_of_pair, list_entrances, put_pairs

  !> Pairs over those that contacts need, up to which those that they no longer do are kept.
  real(dp), parameter :: idle = 1.5_dp

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

  !> Pairs of elements of contacts; those of the step before stay while they are no great part, so that the equations keep their
  !> form.
  pure subroutine put_pairs(outlines, before, found, pairs)
    type(outlines_t), intent(in) :: outlines
    integer, intent(in) :: before(:, :)               !! (2, n) of the step before
    type(contact_t), intent(inout) :: found(:)        !! whose entrances get the numbers of their pairs
    integer, allocatable, intent(out) :: pairs(:, :)  !! (2, n_pairs), sorted
    integer :: i, k, pair(2, 2*size(found))

    do i = 1, size(found)
      if (found(i)%n_entrances == 1) found(i)%entrance(2) = found(i)%entrance(1)
      do k = 1, 2
        pair(:, 2*i - 2 + k) = pair_of(found(i)%entrance(k))
      end do
    end do
    pairs = sorted_pairs(reshape([pair, before], [2, size(pair, 2) + size(before, 2)]))
    if (size(pairs, 2) > idle*size(sorted_pairs(pair), 2)) pairs = sorted_pairs(pair)
    do i = 1, size(found)
      do k = 1, 2
        found(i)%entrance(k)%pair = number_of_pair(pairs, pair(:, 2*i - 2 + k))
      end do
    end do

  contains

    !> The elements of a line.
    pure function pair_of(entrance) result(pair)
      type(entrance_t), intent(in) :: entrance
      integer :: pair(2), a, b

      a = outlines%element(entrance%vertex)
      b = outlines%element(entrance%edge)
      pair = [min(a, b), max(a, b)]
    end function pair_of

  end subroutine put_pairs

  !> Pairs in order, each once.
  pure function sorted_pairs(pair) result(sorted)
    integer, intent(in) :: pair(:, :)
    integer, allocatable :: sorted(:, :)
    real(dp) :: key(size(pair, 2))
    integer :: order(size(pair, 2)), i, n_elements
    logical :: new(size(pair, 2))

    order = [(i, i=1, size(order))]
    n_elements = maxval(pair)
    key = [(pair_key(pair(1, i), pair(2, i), n_elements), i=1, size(order))]
    call sort_by(key, order)
    new = .true.
    new(2:) = key(2:) > key(:size(key) - 1) + 0.5_dp
    sorted = pair(:, pack(order, new))
  end function sorted_pairs

  !> Number of a pair among sorted ones that hold it.
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

end module scree_contact_pairs
