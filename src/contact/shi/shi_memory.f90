!> What contacts take over from the step before by Shi's rules (Shi: df05, df06).
module scree_shi_memory
  use scree_contact_memory, only: entrance_ahead, recall
  use scree_contact_pairs, only: contact_of, entrance_of, place_of_pair
  use scree_contacts, only: contact_t, entrance_t, outlines_t, state_locked, state_open, state_sliding
  use scree_corner_meeting, only: encounter_t, entrance_pairs_t
  use scree_corners, only: along_edge, survey_t
  use scree_kinds, only: dp
  use scree_past_contacts, only: past_t
  implicit none
  private
  public :: contact_as_shi

contains

  !> The contact of an encounter as Shi's programs hand it on (df05, df06). Two corners have no friction, so they slide at most. The
  !> contact has no vertex where an element would touch itself.
  pure subroutine contact_as_shi(outlines, survey, past, guard, encounter, contact)
    type(outlines_t), intent(in) :: outlines
    type(survey_t), intent(in) :: survey
    type(past_t), intent(in) :: past
    real(dp), intent(in) :: guard   !! added to the square of an edge on which an anchor is placed, length^2
    type(encounter_t), intent(in) :: encounter
    type(contact_t), intent(out) :: contact
    integer :: k

    contact%n_entrances = encounter%n_lines
    do k = 1, contact%n_entrances
      contact%entrance(k) = first_entrance(outlines, survey, past, guard, encounter%line(k))
      if (contact%entrance(k)%vertex == 0) return
    end do
    if (contact%n_entrances == 2) contact%entrance%state = min(contact%entrance%state, state_sliding)
    contact%active = entrance_ahead(survey, contact)
  end subroutine contact_as_shi

  !> The first pair of a line if its vertex lies within its edge, else the last pair, with the memory of the pairs. Only a pair that
  !> stays the same and is locked keeps its anchor (Shi: df05, df06).
  pure type(entrance_t) function first_entrance(outlines, survey, past, guard, line) result(first)
    type(outlines_t), intent(in) :: outlines
    type(survey_t), intent(in) :: survey
    type(past_t), intent(in) :: past
    real(dp), intent(in) :: guard   !! length^2
    type(entrance_pairs_t), intent(in) :: line
    real(dp) :: left
    integer :: before, k, known
    logical :: within

    known = 0
    within = .false.
    do k = 1, line%n
      if (outlines%of_vertex(line%vertex(k)) == outlines%element(line%edge(k))) cycle
      before = place_of_pair(past%entrances, line%vertex(k), line%edge(k))
      if (before > 0) known = past%entrances%number(before)
      if (within) cycle
      first%vertex = line%vertex(k)
      first%edge = line%edge(k)
      associate (x1 => survey%start(:, line%vertex(k)), x2 => survey%start(:, line%edge(k)), x3 => survey%finish(:, line%edge(k)))
        within = k == 1 .and. dot_product(x2 - x1, x3 - x1) <= 0
      end associate
    end do
    if (first%vertex == 0) return
    first%joint = outlines%joint(first%edge)
    associate (length => survey%length(first%edge))
      left = length - along_edge(survey, first%vertex, first%edge)
      first%anchor = 1 - left*length/(length**2 + guard)
    end associate
    if (known == 0) return
    associate (was => past%contact(contact_of(known))%entrance(entrance_of(known)))
      call recall(was, first)
      if (was%state == state_locked .and. was%vertex == first%vertex) then
        first%anchor = was%anchor
      else if (was%state /= state_open .and. past%contact(contact_of(known))%n_entrances == 2) then
        first%state = state_locked
      end if
    end associate
  end function first_entrance

end module scree_shi_memory
