!> Contacts of a vertex over an edge, and the list of contacts that the detection has found.
module scree_edge_contacts
  use scree_body_overlap, only: body_overlap_t, entered_by, overlap_of_bodies, still_outside
  use scree_body_search, only: near_at_rest
  use scree_contact_look, only: look_t
  use scree_contact_rules, only: pair
  use scree_contacts, only: contact_law_t, entrance_t, outlines_t, state_open
  use scree_corner_meeting, only: encounter_of_edge, encounter_t
  use scree_corners, only: along_edge, edges_lead_away, gap_at, survey_t, tilt
  use scree_kinds, only: dp
  use scree_past_contacts, only: acted_before, past_t
  implicit none
  private
  public :: add_contact, is_well_over, meet_edge, meet_edges_at

contains

  !> Adds the contact of vertex i over edge j, if its foot is on the edge and its corner fits there.
  subroutine meet_edge(law, outlines, position, look, i, j)
    type(contact_law_t), intent(in) :: law
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)        !! (2, n_vertices) of the elements, length
    type(look_t), intent(inout) :: look
    integer, intent(in) :: i, j
    real(dp) :: at, gap

    associate (survey => look%survey)
      at = along_edge(survey, i, j)
      if (at < 0 .or. at > survey%length(j)) return
      gap = gap_at(survey, i, j)
      if (gap > survey%reach_edge(i) + max(survey%reach_edge(j), survey%reach_edge(outlines%next(j)))) return
      if (gap < -look%depth) return
      if (.not. edges_lead_away(survey%corner(i), survey%corner(j)%from, tilt(survey, i, j))) return
    end associate
    call add_contact(law, outlines, position, encounter_of_edge(i, [j]), look)
  end subroutine meet_edge

  !> Adds the contacts of vertex i over the edges at vertex j, at whose other ends it is near no corner.
  subroutine meet_edges_at(law, outlines, position, look, i, j)
    type(contact_law_t), intent(in) :: law
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)        !! (2, n_vertices) of the elements, length
    type(look_t), intent(inout) :: look
    integer, intent(in) :: i, j
    integer :: beyond(2), edge(2), k

    edge = [j, outlines%previous(j)]
    beyond = [outlines%next(j), outlines%previous(j)]
    do k = 1, 2
      if (norm2(look%survey%start(:, i) - look%survey%start(:, beyond(k))) > look%survey%reach_edge(i) &
          + look%survey%reach_edge(beyond(k))) &
        call meet_edge(law, outlines, position, look, i, edge(k))
    end do
  end subroutine meet_edges_at

  !> Whether the foot of vertex i on edge j is farther from the ends of the edge than corners at rest are near each other.
  pure logical function is_well_over(survey, i, j)
    type(survey_t), intent(in) :: survey
    integer, intent(in) :: i, j
    real(dp) :: at

    at = along_edge(survey, i, j)
    is_well_over = min(at, survey%length(j) - at) > near_at_rest*survey%local(i)
  end function is_well_over

  !> Adds the contact of an encounter. A contact within one element is left out, because the element cannot touch itself. A contact
  !> is also left out if its vertex lies behind an edge by which it did not enter. A corner that is past only one of two lines is
  !> outside and may enter there.
  subroutine add_contact(law, outlines, position, encounter, look)
    type(contact_law_t), intent(in) :: law
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)        !! (2, n_vertices) of the elements, length
    type(encounter_t), intent(in) :: encounter
    type(look_t), intent(inout) :: look

    if (look%n_found == size(look%found)) look%found = [look%found, look%found]
    associate (contact => look%found(look%n_found + 1))
      call pair(law, outlines, look%survey, look%past, encounter, contact)
      if (any(contact%entrance(:contact%n_entrances)%vertex == 0)) return
      if (look%may_rest) then
        if (.not. has_entered(outlines, position, look%survey, look%past, contact%entrance(contact%active))) then
          if (contact%n_entrances == 1) return
          if (.not. has_entered(outlines, position, look%survey, look%past, contact%entrance(3 - contact%active))) return
          contact%active = 3 - contact%active
        end if
      end if
    end associate
    look%n_found = look%n_found + 1
  end subroutine add_contact

  !> Whether the vertex of an entrance entered by that entrance, if it is behind the line. It did if the entrance acted before, or
  !> continues a closed entrance of its line, as where a corner slides off an edge onto the next one. Otherwise the overlap of the
  !> bodies decides. A vertex is always in its own body, and does not enter this body.
  pure logical function has_entered(outlines, position, survey, past, entrance) result(entered)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)        !! (2, n_vertices) of the elements, length
    type(survey_t), intent(in) :: survey
    type(past_t), intent(in) :: past
    type(entrance_t), intent(in) :: entrance
    type(body_overlap_t) :: overlap

    associate (i => entrance%vertex, j => entrance%edge)
      entered = gap_at(survey, i, j) >= -still_outside*min(survey%local(i), survey%length(j))
      if (entered) return
      entered = entrance%state /= state_open .or. acted_before(past, i, j)
      if (entered .or. outlines%block(i) == outlines%block(j)) return
      call overlap_of_bodies(outlines, position, outlines%block(i), outlines%block(j), overlap)
      entered = entered_by(outlines, position, overlap, i, j)
    end associate
  end function has_entered

end module scree_edge_contacts
