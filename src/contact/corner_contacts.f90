!> Contacts of two corners that are near each other, by the sides of the region that is closed to their relative position.
module scree_corner_contacts
  use scree_body_search, only: beyond_way, near_at_rest
  use scree_contact_look, only: look_t
  use scree_contact_rules, only: corners_turn, meet
  use scree_contacts, only: contact_law_t, contact_t, outlines_t, state_open
  use scree_corner_meeting, only: encounter_t, encounters_t, entrance_pairs_t, is_hollow, line_of
  use scree_corners, only: along_edge, gap_at, is_straight, survey_t
  use scree_edge_contacts, only: add_contact, is_well_over, meet_edge, meet_edges_at
  use scree_flush_faces, only: cover_of, cover_t, covered_edges, give_of_tips
  use scree_joint_stiffness, only: at_end
  use scree_kinds, only: dp
  use scree_past_contacts, only: closed_between, stood_for_both, were_bonded
  implicit none
  private
  public :: meet_corners

contains

  !> Adds the contacts of the corners at vertices i and j.
  subroutine meet_corners(law, outlines, position, look, i, j)
    type(contact_law_t), intent(in) :: law
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)        !! (2, n_vertices) of the elements, length
    type(look_t), intent(inout) :: look
    integer, intent(in) :: i, j
    type(encounters_t) :: meeting
    integer :: had, k

    meeting = meet(law, look%survey, i, j, lay_flat(outlines, look, i, j))
    if (meeting%encounter(1)%n_lines == 2) then
      call meet_tips(law, outlines, position, look, i, j, meeting)
      return
    end if
    if (meeting%flat .and. .not. (may_pass(outlines, look, i, j) .or. stay_together(outlines, look, i, j))) then
      had = look%n_found
      call meet_face(law, outlines, position, look, i, j)
      call meet_face(law, outlines, position, look, j, i)
      if (look%n_found > had .or. .not. are_past_each_other(look, meeting%encounter(1)%line(1))) return
    end if
    do k = 1, meeting%n
      call add_contact(law, outlines, position, meeting%encounter(k), look)
    end do
    if (meeting%beside(1)) call meet_edges_at(law, outlines, position, look, i, j)
    if (meeting%beside(2)) call meet_edges_at(law, outlines, position, look, j, i)
  end subroutine meet_corners

  !> Whether one contact stood for both corners, of which one is hollow, or a bond held them, as the joint between them lay flat.
  pure logical function lay_flat(outlines, look, i, j)
    type(outlines_t), intent(in) :: outlines
    type(look_t), intent(in) :: look
    integer, intent(in) :: i, j

    lay_flat = is_hollow(look%survey%corner(i)) .or. is_hollow(look%survey%corner(j))
    if (.not. lay_flat) return
    associate (closed => closed_between(outlines, look%past, i, j))
      lay_flat = stood_for_both(look%past, closed) .or. were_bonded(look%past, closed)
    end associate
  end function lay_flat

  !> Whether neither corner of a line is over an edge of the other: the foot of each is past the end of the edges there. So are two
  !> parallel faces that have no common interval, but do by as little as their tilt makes of the gap between them.
  pure logical function are_past_each_other(look, line)
    type(look_t), intent(in) :: look
    type(entrance_pairs_t), intent(in) :: line
    real(dp) :: past_end
    integer :: k

    are_past_each_other = .true.
    do k = 1, line%n
      associate (vertex => line%vertex(k), edge => line%edge(k))
        past_end = along_edge(look%survey, vertex, edge) - look%survey%length(edge)
        if (any(line%vertex(:line%n) == edge)) past_end = -along_edge(look%survey, vertex, edge) ! the edge begins at that corner
      end associate
      are_past_each_other = are_past_each_other .and. past_end > 0
    end do
  end function are_past_each_other

  !> Whether two corners that lie flat on each other may pass each other in the step, by their relative velocity. Vertices within a
  !> straight side may pass each other only as the bodies slide, because the line of the side goes on beyond them, or where they are
  !> at one place.
  pure logical function may_pass(outlines, look, i, j)
    type(outlines_t), intent(in) :: outlines
    type(look_t), intent(in) :: look
    integer, intent(in) :: i, j
    real(dp) :: shortest, way

    associate (survey => look%survey, previous => outlines%previous)
      way = beyond_way*norm2(survey%way(:, j) - survey%way(:, i))
      if (is_straight(survey%corner(i)) .and. is_straight(survey%corner(j))) then
        shortest = minval(survey%length([i, previous(i), j, previous(j)]))
        may_pass = abs(along_edge(survey, i, j)) <= at_end*shortest + way
      else
        may_pass = norm2(survey%start(:, j) - survey%start(:, i)) <= survey%reach_at_rest(i) + survey%reach_at_rest(j) + way
      end if
    end associate
  end function may_pass

  !> Whether two corners that lie flat on each other keep the one contact that stood for both, as the springs along their joint give
  !> way.
  pure logical function stay_together(outlines, look, i, j)
    type(outlines_t), intent(in) :: outlines
    type(look_t), intent(in) :: look
    integer, intent(in) :: i, j

    stay_together = .false.
    if (abs(along_edge(look%survey, i, j)) <= 0.5_dp*min(look%survey%local(i), look%survey%local(j))) &
      stay_together = stood_for_both(look%past, closed_between(outlines, look%past, i, j))
  end function stay_together

  !> Adds the contacts of vertex i over the edges at vertex j, unless it may pass the other end of the edge in the step too.
  subroutine meet_face(law, outlines, position, look, i, j)
    type(contact_law_t), intent(in) :: law
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)        !! (2, n_vertices) of the elements, length
    type(look_t), intent(inout) :: look
    integer, intent(in) :: i, j

    if (.not. may_pass(outlines, look, i, outlines%next(j))) call meet_edge(law, outlines, position, look, i, j)
    if (.not. may_pass(outlines, look, i, outlines%previous(j))) &
      call meet_edge(law, outlines, position, look, i, outlines%previous(j))
  end subroutine meet_face

  !> Adds the contacts of two corners tip to tip, of which each may get over both edges of the other.
  subroutine meet_tips(law, outlines, position, look, i, j, meeting)
    type(contact_law_t), intent(in) :: law
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)        !! (2, n_vertices) of the elements, length
    type(look_t), intent(inout) :: look
    integer, intent(in) :: i, j
    type(encounters_t), intent(inout) :: meeting
    type(cover_t) :: cover
    integer :: had, k

    do k = 1, meeting%n
      if (look%may_rest) cover = cover_of(outlines, look, i, j, meeting%encounter(k))
      meeting%encounter(k)%covered_line = cover%line
      had = look%n_found
      call add_contact(law, outlines, position, meeting%encounter(k), look)
      if (look%n_found == had) cycle
      if (cover%line == 0 .and. .not. (cover%tips_give .or. cover%bears_beside)) &
        call add_other_ends(law, outlines, position, meeting%encounter(k), look)
      if (any(look%found(had + 1)%entrance%state /= state_open)) cycle
      if (cover%bears_beside) look%n_found = had
      if (cover%tips_give) call let_give(give_of_tips(outlines, look, i, j), look%survey, look%found(had + 1))
    end do
    if (.not. corners_turn(law)) return
    call meet_where_turned(law, outlines, position, look, i, j)
    call meet_where_turned(law, outlines, position, look, j, i)
  end subroutine meet_tips

  !> Adds the contacts at the other ends of intervals that open in the step. Where an entrance line has two parallel edges, faces
  !> slide onto each other as the corners pass, and bear at both ends of what they then have in common.
  subroutine add_other_ends(law, outlines, position, encounter, look)
    type(contact_law_t), intent(in) :: law
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)        !! (2, n_vertices) of the elements, length
    type(encounter_t), intent(in) :: encounter    !! with two lines
    type(look_t), intent(inout) :: look           !! of which the last contact found is the one of the encounter
    type(encounter_t) :: other
    integer :: chosen(2)                          ! vertices of the lines of that contact
    integer :: k, m

    chosen = look%found(look%n_found)%entrance%vertex
    do k = 1, 2
      associate (line => encounter%line(k))
        if (line%n /= 2) cycle
        if (.not. all([(ends_over(outlines, look, line%vertex(m), line%edge(m)), m=1, 2)])) cycle
        m = merge(2, 1, line%vertex(1) == chosen(k))
        other = encounter
        other%line(k) = line_of(line%vertex(m:m), line%edge(m:m), [.true.])
      end associate
      call add_contact(law, outlines, position, other, look)
    end do
  end subroutine add_other_ends

  !> Whether velocities take the foot of vertex i well within edge j in the step.
  pure logical function ends_over(outlines, look, i, j)
    type(outlines_t), intent(in) :: outlines
    type(look_t), intent(in) :: look
    integer, intent(in) :: i, j
    real(dp) :: along(2), at, from(2)

    associate (survey => look%survey, next => outlines%next(j))
      from = survey%start(:, j) + survey%way(:, j)
      along = survey%finish(:, j) + survey%way(:, next) - from
      at = dot_product(survey%start(:, i) + survey%way(:, i) - from, along)/norm2(along)
      ends_over = min(at, norm2(along) - at) > near_at_rest*survey%local(i)
    end associate
  end function ends_over

  !> Lets a contact of two tips, between which other blocks lie flush, bear nothing up to a penetration, or up to its present one.
  pure subroutine let_give(give, survey, contact)
    real(dp), intent(in) :: give                  !! length
    type(survey_t), intent(in) :: survey
    type(contact_t), intent(inout) :: contact

    associate (ahead => contact%entrance(contact%active))
      contact%entrance%rest = -give
      ahead%rest = min(ahead%rest, gap_at(survey, ahead%vertex, ahead%edge))
    end associate
  end subroutine let_give

  !> Adds the contacts of vertex i over the edges at vertex j, where the two are near each other only as they move. An entrance line
  !> takes one of two edges that face each other as they lie when the step begins; in a step in which they turn both may be met. An
  !> edge that a third block lies flush with is not met: springs let a corner that slides on that block sink in front of it.
  subroutine meet_where_turned(law, outlines, position, look, i, j)
    type(contact_law_t), intent(in) :: law
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)        !! (2, n_vertices) of the elements, length
    type(look_t), intent(inout) :: look
    integer, intent(in) :: i, j
    logical :: meets(2)                           ! the edge that begins at j, and the edge that ends there

    meets = [is_well_over(look%survey, i, j), is_well_over(look%survey, i, outlines%previous(j))]
    if (.not. any(meets)) return
    if (look%may_rest) meets = meets .and. .not. covered_edges(outlines, look, i, j)
    if (meets(1)) call meet_edge(law, outlines, position, look, i, j)
    if (meets(2)) call meet_edge(law, outlines, position, look, i, outlines%previous(j))
  end subroutine meet_where_turned

end module scree_corner_contacts
