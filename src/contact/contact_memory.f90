!> What the contacts of a step take over from those of the step before (Shi's df06).
!>
!> Contacts are told by their pairs of a vertex and an edge. Where a contact before had one of the pairs of an entrance line, the
!> line goes on with its state, anchor, rest and bond.
module scree_contact_memory
  use scree_contact_faces, only: faces_of, faces_of_entrance, is_between_same_blocks, is_between_same_faces, joint_of
  use scree_contact_pairs, only: contact_of, entrance_of, has_same_entrances, place_of_pair
  use scree_contacts, only: contact_law_t, contact_t, entrance_t, outlines_t, state_locked, state_open, state_sliding
  use scree_corner_meeting, only: encounter_t, entrance_pairs_t
  use scree_corners, only: along_edge, gap_at, survey_t, turn, way_at
  use scree_joint_stiffness, only: take_stiffness
  use scree_kinds, only: dp, pi
  use scree_pair_fit, only: fit_of_pair, fit_t, fits_better, goes_on_closed
  use scree_past_contacts, only: acted_before, entrance_before, has_slid, is_closed, moves_along, past_t
  implicit none
  private
  public :: contact_over_edges, entrance_ahead, inherit, let_one_go_on, recall, wear_as_beside

  real(dp), parameter :: in_line = 2e-2_dp        !! angle up to which faces that slide and press tilt, rad
  real(dp), parameter :: landing = 0.3_dp         !! of its way along: what goes farther across lands, or turns, and does not slide
  real(dp), parameter :: deeper = 2.0_dp          !! times that of others, that a joint overlaps by at the end of a tilted face

contains

  !> The contact of an encounter, each of its lines at the pair that fits best. Without a vertex where an element would touch
  !> itself.
  pure subroutine contact_over_edges(law, outlines, survey, past, encounter, contact)
    type(contact_law_t), intent(in) :: law
    type(outlines_t), intent(in) :: outlines
    type(survey_t), intent(in) :: survey
    type(past_t), intent(in) :: past
    type(encounter_t), intent(in) :: encounter
    type(contact_t), intent(out) :: contact
    integer :: k

    contact%n_entrances = encounter%n_lines
    contact%covered_line = encounter%covered_line
    contact%stands_for_both = encounter%stands_for_both
    do k = 1, contact%n_entrances
      call find_best_entrance(law, outlines, survey, past, encounter%line(k), contact%entrance(k))
      if (contact%entrance(k)%vertex == 0) return
    end do
    contact%active = entrance_ahead(survey, contact)
    call rest_inside(outlines, survey, past, contact)
  end subroutine contact_over_edges

  !> Finds the best pair of a line. First comes a pair whose entrance was closed before and whose vertex is still within its edge,
  !> or hardly past its end. Otherwise it is the pair whose vertex lies best within its edge; a pair that is aside is taken only if
  !> the others are past their ends. The best pair continues its own entrance. If this entrance was not closed, it continues the
  !> entrance of another pair of the line that was. The order of the pairs in the line does not matter.
  pure subroutine find_best_entrance(law, outlines, survey, past, line, best)
    type(contact_law_t), intent(in) :: law
    type(outlines_t), intent(in) :: outlines
    type(survey_t), intent(in) :: survey
    type(past_t), intent(in) :: past
    type(entrance_pairs_t), intent(in) :: line
    type(entrance_t), intent(inout) :: best !! a new one
    type(fit_t) :: fit, fit_of_best, fit_of_known
    integer :: before, k, known

    known = 0
    do k = 1, line%n
      associate (vertex => line%vertex(k), edge => line%edge(k))
        if (outlines%of_vertex(vertex) == outlines%element(edge)) cycle
        before = entrance_before(past, vertex, edge)
        fit = fit_of_pair(outlines, survey, past, before, vertex, edge, line%aside(k))
        if (fits_better(fit, fit_of_best)) then
          fit_of_best = fit
          best%vertex = vertex
          best%edge = edge
          best%anchor = along_edge(survey, vertex, edge)/survey%length(edge)
        end if
      end associate
      if (before == 0) cycle
      if (is_closed(past, before)) fit%rank = fit%rank + goes_on_closed ! wherever along its edge it is
      if (.not. fits_better(fit, fit_of_known)) cycle
      fit_of_known = fit
      known = before
    end do
    if (best%vertex == 0) return
    best%joint = joint_of(law, outlines, survey, best)
    if (known > 0) call go_on(outlines, survey, past%contact(contact_of(known))%entrance(entrance_of(known)), best)
    best%from = known
  end subroutine find_best_entrance

  !> Lets one contact alone go on from an entrance of the step before: that of the same pair, or else the first. Vertices at both
  !> ends of an edge so short that another vertex slides off it may each take its place; the others begin anew.
  pure subroutine let_one_go_on(outlines, survey, past, contact)
    type(outlines_t), intent(in) :: outlines
    type(survey_t), intent(in) :: survey
    type(past_t), intent(in) :: past
    type(contact_t), intent(inout) :: contact(:)
    type(entrance_t) :: new
    integer :: heir(2*size(past%contact)) ! contact that goes on from each entrance
    integer :: i, k

    heir = 0
    do i = 1, size(contact)
      do k = 1, contact(i)%n_entrances
        associate (entrance => contact(i)%entrance(k))
          if (entrance%from == 0) cycle
          associate (was => past%contact(contact_of(entrance%from))%entrance(entrance_of(entrance%from)))
            if (heir(entrance%from) == 0 .or. (entrance%vertex == was%vertex .and. entrance%edge == was%edge)) &
              heir(entrance%from) = i
          end associate
        end associate
      end do
    end do
    do i = 1, size(contact)
      if (contact(i)%n_entrances > 1) cycle
      associate (entrance => contact(i)%entrance(1))
        if (entrance%from == 0 .or. entrance%state == state_open) cycle
        if (heir(entrance%from) == i) cycle
        new%vertex = entrance%vertex
        new%edge = entrance%edge
        new%joint = entrance%joint
        new%anchor = along_edge(survey, new%vertex, new%edge)/survey%length(new%edge)
        call begin_between(outlines, survey, past, new)
        entrance = new
        contact(i)%inherits = -1.0_dp
      end associate
    end do
  end subroutine let_one_go_on

  !> Lets an entrance continue an earlier one, with the same slip and the same compression of its spring. If a joint with a
  !> stiffness of its own has slid, its spring is instead compressed by the overlap of the faces at the new place.
  pure subroutine go_on(outlines, survey, was, entrance)
    type(outlines_t), intent(in) :: outlines
    type(survey_t), intent(in) :: survey
    type(entrance_t), intent(in) :: was
    type(entrance_t), intent(inout) :: entrance
    real(dp) :: gap, overlap, slip

    call recall(was, entrance)
    gap = gap_at(survey, entrance%vertex, entrance%edge) - entrance%memory%dilated
    if (entrance%state /= state_open) then
      slip = slip_of(survey, was)
      entrance%anchor = entrance%anchor - slip/survey%length(entrance%edge)
      overlap = max(0.0_dp, was%rest + was%memory%dilated - gap_at(survey, was%vertex, was%edge))
      if (entrance%vertex /= was%vertex .or. entrance%edge /= was%edge) then
        if (.not. (was%has_joint_stiffness .and. has_slid(was, overlap) .and. entrance%rest - gap <= deeper*overlap .and. &
                   size(faces_of_entrance(outlines, survey, in_line, entrance)) > 0)) &
          entrance%rest = min(max(0.0_dp, was%rest), gap + overlap)
      end if
    end if
    if (entrance%memory%bonded .and. entrance%state /= state_open) return
    if (gap >= entrance%rest) entrance%rest = min(0.0_dp, gap) ! what has come out stays out
  end subroutine go_on

  !> Slip of an entrance from its anchor, length.
  pure real(dp) function slip_of(survey, entrance)
    type(survey_t), intent(in) :: survey
    type(entrance_t), intent(in) :: entrance

    slip_of = along_edge(survey, entrance%vertex, entrance%edge) - entrance%anchor*survey%length(entrance%edge)
  end function slip_of

  !> Hands on all that an entrance remembers, but for its place and its anchor. A bond keeps its joint material.
  pure subroutine recall(was, entrance)
    type(entrance_t), intent(in) :: was
    type(entrance_t), intent(inout) :: entrance
    type(entrance_t) :: new

    new = entrance
    entrance = was
    entrance%vertex = new%vertex
    entrance%edge = new%edge
    if (.not. was%memory%bonded) entrance%joint = new%joint
    entrance%pair = new%pair
    entrance%anchor = new%anchor
  end subroutine recall

  !> The entrance that a contact begins with: the one that is closed, or else the one with the larger gap.
  pure integer function entrance_ahead(survey, contact) result(k)
    type(survey_t), intent(in) :: survey
    type(contact_t), intent(in) :: contact

    k = 1
    if (contact%n_entrances == 1) return
    associate (a => contact%entrance(1), b => contact%entrance(2))
      if (a%state /= state_open .neqv. b%state /= state_open) then
        if (a%state == state_open) k = 2
      else if (gap_at(survey, a%vertex, a%edge) < gap_at(survey, b%vertex, b%edge)) then
        k = 2
      end if
    end associate
  end function entrance_ahead

  !> A contact that is found inside starts without a force: its spring rests at the present gap, so it brings no energy. The same
  !> holds for the other line of a corner if a third block covers the first line. Exception: a vertex that slides in between faces
  !> that already carry a contact starts with the compression of that contact, because other contacts leave these faces at their
  !> other end. If the vertex pressed on another body, from which it slides to this one, the contact takes over the stiffness and
  !> the compression of that spring.
  pure subroutine rest_inside(outlines, survey, past, contact)
    type(outlines_t), intent(in) :: outlines
    type(survey_t), intent(in) :: survey
    type(past_t), intent(in) :: past
    type(contact_t), intent(inout) :: contact
    real(dp) :: gap, pressed
    integer :: heir

    associate (entrance => contact%entrance(contact%active))
      if (entrance%state /= state_open) return
      gap = gap_at(survey, entrance%vertex, entrance%edge)
      if (contact%covered_line == contact%active .and. gap < 0) then
        associate (other => contact%entrance(3 - contact%active))
          other%rest = min(0.0_dp, gap_at(survey, other%vertex, other%edge))
        end associate
      end if
      if (acted_before(past, entrance%vertex, entrance%edge)) return
      entrance%rest = min(0.0_dp, gap)
      if (contact%n_entrances == 1) call begin_between(outlines, survey, past, entrance)
      if (entrance%rest >= 0 .or. entrance%rest > gap) return
      call find_pressed_beside(outlines%block, survey, past, entrance, pressed, heir)
      if (heir == 0) return
      entrance%rest = min(0.0_dp, gap + pressed)
    end associate
    contact%inherits = pressed
    call take_stiffness(past%contact(heir)%entrance(past%contact(heir)%active), contact)
  end subroutine rest_inside

  !> Lets the springs of a contact of one new entrance rest at its place: across at a gap of 0, or at the present gap if the vertex
  !> is inside. Exception: a vertex that moves along between faces that already carry a contact starts with the strain of that
  !> contact. A corner of two entrances is not between faces.
  pure subroutine begin_between(outlines, survey, past, entrance)
    type(outlines_t), intent(in) :: outlines
    type(survey_t), intent(in) :: survey
    type(past_t), intent(in) :: past
    type(entrance_t), intent(inout) :: entrance !! its anchor where its vertex is
    real(dp) :: pressed, slip, way(2)

    entrance%rest = min(0.0_dp, gap_at(survey, entrance%vertex, entrance%edge))
    if (entrance%rest >= 0) return
    way = abs(way_at(survey, outlines%next(entrance%edge), entrance%vertex, entrance%edge))
    if (way(2) > landing*way(1)) return
    call find_strained_between(outlines, survey, past, entrance, pressed, slip)
    entrance%rest = min(0.0_dp, entrance%rest + pressed)
    entrance%anchor = entrance%anchor - slip/survey%length(entrance%edge)
  end subroutine begin_between

  !> Largest overlap, and slip from the anchor, of contacts that moved along one of the faces of an entrance at the end of the step
  !> before. Contacts between the same blocks count, and all contacts of joints with a stiffness of their own, with `deeper` times
  !> their overlap. Both results are 0 if these faces carry only one contact and that contact stays over its edge, as with tips that
  !> slid onto each other: no load is then handed over.
  pure subroutine find_strained_between(outlines, survey, past, entrance, pressed, slip)
    type(outlines_t), intent(in) :: outlines
    type(survey_t), intent(in) :: survey
    type(past_t), intent(in) :: past
    type(entrance_t), intent(in) :: entrance
    real(dp), intent(out) :: pressed, slip     !! length; 0: nothing moves along there
    integer, allocatable :: faces(:)
    real(dp) :: most
    integer :: k, m, n_strained
    logical :: stays                           ! the one that is strained over its edge, where it bears on

    pressed = 0.0_dp
    slip = 0.0_dp
    n_strained = 0
    stays = .false.
    faces = faces_of_entrance(outlines, survey, in_line, entrance)
    if (size(faces) == 0) return
    do k = 1, size(past%contact)
      associate (was => past%contact(k), other => past%contact(k)%entrance(past%contact(k)%active))
        if (.not. moves_along(was)) cycle
        if (.not. (other%has_joint_stiffness .or. is_between_same_blocks(outlines, entrance, other))) cycle
        associate (others => faces_of(outlines, survey, was))
          if (.not. any([(any(faces == others(m)), m=1, size(others))])) cycle
        end associate
        n_strained = n_strained + 1
        stays = .not. (other%has_joint_stiffness .or. is_past_its_ends(survey, other))
        most = merge(deeper*was%pressed, was%pressed, other%has_joint_stiffness)
        if (most <= pressed) cycle
        pressed = most
        slip = slip_of(survey, other)
      end associate
    end do
    if (n_strained /= 1 .or. .not. stays) return ! others leave the faces as this one comes
    pressed = 0.0_dp
    slip = 0.0_dp
  end subroutine find_strained_between

  !> Whether the vertex of an entrance is past an end of its edge.
  pure logical function is_past_its_ends(survey, entrance) result(past_it)
    type(survey_t), intent(in) :: survey
    type(entrance_t), intent(in) :: entrance
    real(dp) :: at

    at = along_edge(survey, entrance%vertex, entrance%edge)
    past_it = at < 0 .or. at > survey%length(entrance%edge)
  end function is_past_its_ends

  !> Gives an open contact the wear of the nearest closed contact between the same faces, if that is more. A contact that begins
  !> beside sliding contacts, as from node to node of a mesh, is as worn as these.
  pure subroutine wear_as_beside(outlines, survey, past, contact)
    type(outlines_t), intent(in) :: outlines
    type(survey_t), intent(in) :: survey
    type(past_t), intent(in) :: past
    type(contact_t), intent(inout) :: contact(:)
    integer, allocatable :: worn(:)            !! contacts of the step before
    real(dp) :: apart, closest, wear           ! length
    integer :: i, k, m

    worn = pack([(i, i=1, size(past%contact))], [(has_worn(past%contact(i)), i=1, size(past%contact))])
    if (size(worn) == 0) return
    do i = 1, size(contact)
      do k = 1, contact(i)%n_entrances
        associate (entrance => contact(i)%entrance(k))
          if (entrance%state /= state_open) cycle
          wear = 0.0_dp
          closest = huge(closest)
          do m = 1, size(worn)
            associate (other => past%contact(worn(m))%entrance(past%contact(worn(m))%active))
              if (.not. is_between_same_faces(outlines, survey, entrance, other)) cycle
              apart = norm2(survey%start(:, other%vertex) - survey%start(:, entrance%vertex))
              if (apart >= closest) cycle
              closest = apart
              wear = other%memory%wear
            end associate
          end do
          entrance%memory%wear = max(entrance%memory%wear, wear)
        end associate
      end do
    end do
  end subroutine wear_as_beside

  !> Whether a contact was closed when the step before ended, and its joint has worn.
  pure logical function has_worn(contact)
    type(contact_t), intent(in) :: contact

    associate (entrance => contact%entrance(contact%active))
      has_worn = entrance%state /= state_open .and. entrance%memory%wear > 0
    end associate
  end function has_worn

  !> Finds the contact by which the vertex of an entrance pressed most on another body than that of its edge, and the overlap. The
  !> contact was closed when the step before ended, and its edge faces as the edge of the entrance does, within 45 degrees.
  pure subroutine find_pressed_beside(block, survey, past, entrance, pressed, by)
    integer, intent(in) :: block(:)            !! of the edges
    type(survey_t), intent(in) :: survey
    type(past_t), intent(in) :: past
    type(entrance_t), intent(in) :: entrance
    real(dp), intent(out) :: pressed
    integer, intent(out) :: by             !! contact; 0: none pressed
    integer :: k

    pressed = 0.0_dp
    by = 0
    associate (i => entrance%vertex, entrances => past%entrances)
      do k = entrances%first(i), entrances%last(i)
        associate (was => past%contact(contact_of(entrances%number(k))), other => entrances%edge(k))
          if (.not. is_closed(past, entrances%number(k)) .or. .not. was%pressed > pressed) cycle
          if (block(other) == block(entrance%edge)) cycle
          if (abs(turn(survey%corner(other)%from - survey%corner(entrance%edge)%from)) > pi/4) cycle
          pressed = was%pressed
          by = contact_of(entrances%number(k))
        end associate
      end do
    end associate
  end subroutine find_pressed_beside

  !> Lets a contact take over the overlap and the stiffness of an earlier contact that it replaces. The earlier contact had a pair
  !> of the encounter closed, and had other entrances. An overlap below 0 means that there is none, and 0 that the contact is found
  !> inside.
  pure subroutine inherit(survey, past, encounter, contact)
    type(survey_t), intent(in) :: survey
    type(past_t), intent(in) :: past
    type(encounter_t), intent(in) :: encounter
    type(contact_t), intent(inout) :: contact
    integer :: k

    contact%inherits = -1.0_dp
    do k = 1, encounter%n_lines
      call inherit_by_line(survey, past, encounter%line(k), contact)
    end do
  end subroutine inherit

  !> Likewise of one line, where its overlap is the larger.
  pure subroutine inherit_by_line(survey, past, line, contact)
    type(survey_t), intent(in) :: survey
    type(past_t), intent(in) :: past
    type(entrance_pairs_t), intent(in) :: line
    type(contact_t), intent(inout) :: contact
    real(dp) :: gap, overlap
    integer :: before, heir, k

    associate (active => contact%entrance(contact%active))
      gap = gap_at(survey, active%vertex, active%edge)
      overlap = merge(0.0_dp, -1.0_dp, active%state == state_open .and. gap < 0 .and. gap >= active%rest)
    end associate
    heir = 0
    do k = 1, line%n
      before = entrance_before(past, line%vertex(k), line%edge(k))
      if (before == 0) cycle
      associate (was => past%contact(contact_of(before)))
        if (has_same_entrances(was, contact)) then
          overlap = -1.0_dp
          heir = 0
        else if (was%entrance(entrance_of(before))%state /= state_open .and. was%pressed >= overlap) then
          overlap = was%pressed
          heir = contact_of(before)
        end if
      end associate
    end do
    if (overlap <= contact%inherits) return
    contact%inherits = overlap
    if (heir > 0) call take_stiffness(past%contact(heir)%entrance(past%contact(heir)%active), contact)
  end subroutine inherit_by_line

end module scree_contact_memory
