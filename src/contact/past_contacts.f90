!> The contacts of the step before, found by their pairs of a vertex and an edge.
module scree_past_contacts
  use scree_contact_lists, only: entrances_t
  use scree_contact_pairs, only: contact_of, entrance_of, list_entrances, place_of_pair
  use scree_contacts, only: blocks_of, contact_t, entrance_t, outlines_t, state_open
  use scree_kinds, only: dp
  implicit none
  private
  public :: acted_before, closed_between, entrance_before, has_slid, is_closed, moves_along, past_t, pressed_of_blocks, &
            recall_contacts, stood_for_both, were_bonded

  real(dp), parameter :: far = 10.0_dp !! times the overlap of a spring: what has slid as much slides on

  !> The contacts of the step before, to be looked up.
  type :: past_t
    type(contact_t), pointer, contiguous :: contact(:) => null()
    type(entrances_t), pointer :: entrances => null()
  end type past_t

contains

  !> Makes the contacts of the step before ready to be looked up, where they are.
  subroutine recall_contacts(outlines, contact, entrances, past)
    type(outlines_t), intent(in) :: outlines
    type(contact_t), target, contiguous, intent(in) :: contact(:)
    type(entrances_t), target, intent(inout) :: entrances !! new, or of an earlier list; gets those of the contacts
    type(past_t), intent(out) :: past

    call list_entrances(contact, size(outlines%start), entrances)
    past%contact => contact
    past%entrances => entrances
  end subroutine recall_contacts

  !> Whether a contact has slid more than `far` times the overlap of its spring. A contact that just landed slips less.
  pure logical function slides(contact)
    type(contact_t), intent(in) :: contact

    slides = has_slid(contact%entrance(contact%active), contact%pressed)
  end function slides

  !> Likewise of the entrance that acts.
  pure logical function has_slid(entrance, pressed)
    type(entrance_t), intent(in) :: entrance
    real(dp), intent(in) :: pressed !! overlap of its spring, length

    has_slid = entrance%state /= state_open .and. .not. entrance%memory%bonded .and. entrance%memory%slid > far*pressed
  end function has_slid

  !> Whether a contact has slid as far, or its joint, with a stiffness of its own, has an elastic slip as large.
  pure logical function moves_along(contact)
    type(contact_t), intent(in) :: contact

    moves_along = slides(contact)
    associate (entrance => contact%entrance(contact%active))
      if (entrance%has_joint_stiffness) moves_along = moves_along .or. abs(contact%force(2)) &
          > far*contact%pressed*entrance%stiffness(2)
    end associate
  end function moves_along

  !> Number of the entrance of a pair of vertex and edge; 0 if there was none. If several contacts had the pair, one that was closed
  !> there is taken.
  pure integer function entrance_before(past, vertex, edge)
    type(past_t), intent(in) :: past
    integer, intent(in) :: vertex, edge
    integer :: first, k

    entrance_before = 0
    first = place_of_pair(past%entrances, vertex, edge)
    if (first == 0) return
    associate (number => past%entrances%number)
      entrance_before = number(first)
      do k = first, past%entrances%last(vertex)
        if (past%entrances%edge(k) > edge) return
        if (.not. is_closed(past, number(k))) cycle
        entrance_before = number(k)
        return
      end do
    end associate
  end function entrance_before

  !> Whether an entrance of the step before was closed at its end.
  pure logical function is_closed(past, number)
    type(past_t), intent(in) :: past
    integer, intent(in) :: number !! of the entrance: two for each contact; 0: none

    is_closed = .false.
    if (number > 0) is_closed = past%contact(contact_of(number))%entrance(entrance_of(number))%state /= state_open
  end function is_closed

  !> Whether the entrance of a pair of vertex and edge was there and acted.
  pure logical function acted_before(past, vertex, edge)
    type(past_t), intent(in) :: past
    integer, intent(in) :: vertex, edge
    integer :: before

    before = entrance_before(past, vertex, edge)
    acted_before = .false.
    if (before > 0) acted_before = past%contact(contact_of(before))%active == entrance_of(before)
  end function acted_before

  !> Whether one contact stood for two vertices that lie flat on each other when the step before ended, and has not slid.
  pure logical function stood_for_both(past, closed)
    type(past_t), intent(in) :: past
    integer, intent(in) :: closed(:) !! of the two, as of `closed_between`
    integer :: k

    stood_for_both = any([(past%contact(contact_of(closed(k)))%stands_for_both &
        .and. .not. slides(past%contact(contact_of(closed(k)))), &
                           k=1, size(closed))])
  end function stood_for_both

  !> Whether a bond held two vertices to the edges at the other one when the step before ended.
  pure logical function were_bonded(past, closed)
    type(past_t), intent(in) :: past
    integer, intent(in) :: closed(:) !! of the two, as of `closed_between`
    integer :: k

    were_bonded = any([(past%contact(contact_of(closed(k)))%entrance(entrance_of(closed(k)))%memory%bonded, k=1, size(closed))])
  end function were_bonded

  !> Numbers of the entrances of two vertices, each at an edge of the other vertex, that were closed when the step before ended.
  pure function closed_between(outlines, past, i, j) result(closed)
    type(outlines_t), intent(in) :: outlines
    type(past_t), intent(in) :: past
    integer, intent(in) :: i, j     !! vertices
    integer, allocatable :: closed(:)
    integer :: before(4), k

    before = [entrance_before(past, i, j), entrance_before(past, i, outlines%previous(j)), &
              entrance_before(past, j, i), entrance_before(past, j, outlines%previous(i))]
    closed = pack(before, [(is_closed(past, before(k)), k=1, size(before))])
  end function closed_between

  !> Largest overlap of a spring of each block when the step before ended (n_blocks), length.
  pure function pressed_of_blocks(outlines, past) result(pressed)
    type(outlines_t), intent(in) :: outlines
    type(past_t), intent(in) :: past
    real(dp) :: pressed(size(outlines%first) - 1)
    integer :: block(2), k, m

    pressed = 0.0_dp
    do k = 1, size(past%contact)
      block = blocks_of(outlines, past%contact(k)%entrance(past%contact(k)%active))
      do m = 1, 2 ! one after the other: of what touches itself both are one
        pressed(block(m)) = max(pressed(block(m)), past%contact(k)%pressed)
      end do
    end do
  end function pressed_of_blocks

end module scree_past_contacts
