!> Which contacts change from judgement to judgement of a step, where others have come to their states.
!>
!> In a healthy iteration each state update changes about a hundredth as many contacts as the one before. Where more change, a few
!> bodies with small forces change their contacts for ever, such as the upper courses of a wall that a wave throws up. All other
!> bodies would solve their equations with them. So these bodies are settled among themselves.
module scree_flickering
  use scree_contact_try, only: contact_try_t, states_of
  use scree_kinds, only: dp
  implicit none
  private
  public :: flickering_t, may_part, note_changes, note_part

  !> Changes that a judgement leaves over those of the one before, from which on they are taken to go on.
  real(dp), parameter :: slow = 0.1_dp
  !> Changes that Newton's iteration is left to deal with.
  integer, parameter :: few = 20
  !> Times in a step that a part is settled, from where on the whole is.
  integer, parameter :: most_parts = 8

  !> Elements of a group below which the whole is settled as fast as a part.
  integer, parameter :: fewest_elements = 300

  !> What has changed so far.
  type :: flickering_t
    logical, allocatable :: contact(:)    !! (n) of those settled together, that changed after the first judgement of the step
    integer :: judgements = 0
    integer :: changes = 0                !! in the last one; 0 since a part was settled
    integer :: parts = 0                  !! that were settled
    integer :: reach = 1                  !! of the next, in elements about those whose contacts change
  end type flickering_t

contains

  !> Notes which contacts a judgement has changed, and tells whether they go on changing.
  pure subroutine note_changes(before, contacts, flickering, goes_on)
    integer, intent(in) :: before(:, :)   !! (2, n) states of their entrances before the judgement
    type(contact_try_t), intent(in) :: contacts
    type(flickering_t), intent(inout) :: flickering
    logical, intent(out) :: goes_on
    logical :: changed(size(before, 2))

    flickering%judgements = flickering%judgements + 1
    goes_on = .false.
    if (flickering%judgements > 1) then
      changed = any(states_of(contacts) /= before, 1)
      if (.not. allocated(flickering%contact)) allocate (flickering%contact(size(changed)), source=.false.)
      flickering%contact = flickering%contact .or. changed
      goes_on = contacts%changes > max(few, int(slow*flickering%changes))
    end if
    flickering%changes = contacts%changes
  end subroutine note_changes

  !> Whether what goes on changing in a group may be settled among itself.
  pure logical function may_part(flickering, n_elements)
    type(flickering_t), intent(in) :: flickering
    integer, intent(in) :: n_elements     !! of the group

    may_part = flickering%parts < most_parts .and. allocated(flickering%contact) .and. n_elements >= fewest_elements
  end function may_part

  !> Notes that a part was settled, or that there is none that can be. One that a few changes run in circles about is to reach
  !> farther.
  pure subroutine note_part(settled, flickering)
    logical, intent(in) :: settled
    type(flickering_t), intent(inout) :: flickering

    if (flickering%changes <= few) flickering%reach = flickering%reach + 1
    flickering%changes = 0
    flickering%parts = merge(flickering%parts + 1, most_parts, settled)
  end subroutine note_part

end module scree_flickering
