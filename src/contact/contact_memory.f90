!> What the contacts of a step take over from those of the step before (Shi's df06).
!>
!> Contacts are told by their pairs of a vertex and an edge. Where a contact before had one of the pairs of an entrance line, the
!> line goes on with its state, anchor, rest and bond.
module scree_contact_memory
  use scree_contact_pairs, only: entrances_t, has_same_entrances, list_entrances, place_of_pair
  use scree_contacts, only: contact_memory_t, contact_t, entrance_t, outlines_t, state_locked, state_open, state_sliding
  use scree_corner_meeting, only: encounter_t, line_t
  use scree_corners, only: along_edge, gap_at, survey_t, turn
  use scree_joint_stiffness, only: take_stiffness
  use scree_kinds, only: dp, pi
  implicit none
  private
  public :: acted_before, contact_as_shi, contact_over_edges, inherit, let_one_go_on, past_t, recall_contacts

  real(dp), parameter :: beyond = 1e-3_dp         !! of an edge, that a contact with it lasts past its end

  !> The contacts of the step before, to be looked up.
  type :: past_t
    type(contact_t), allocatable :: contact(:)
    type(entrances_t) :: entrances
  end type past_t

contains

  !> Makes the memory of contacts ready to be looked up.
  pure subroutine recall_contacts(outlines, memory, past)
    type(outlines_t), intent(in) :: outlines
    type(contact_memory_t), intent(in) :: memory
    type(past_t), intent(out) :: past

    past%contact = memory%contact
    call list_entrances(past%contact, size(outlines%start), past%entrances)
  end subroutine recall_contacts

  !> Number of the entrance of a pair of vertex and edge; 0 where there was none. Where several contacts had it, of one that was
  !> closed there.
  pure integer function entrance_before(past, vertex, edge)
    type(past_t), intent(in) :: past
    integer, intent(in) :: vertex, edge
    integer :: first, k

    entrance_before = 0
    first = place_of_pair(past%entrances, vertex, edge)
    if (first == 0) return
    associate (number => past%entrances%number)
      entrance_before = number(first)
      do k = first, past%entrances%first(vertex + 1) - 1
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
    integer, intent(in) :: number !! of the entrance: two for each contact

    is_closed = past%contact((number + 1)/2)%entrance(2 - modulo(number, 2))%state /= state_open
  end function is_closed

  !> Whether the entrance of a pair of vertex and edge was there and acted.
  pure logical function acted_before(past, vertex, edge)
    type(past_t), intent(in) :: past
    integer, intent(in) :: vertex, edge
    integer :: before

    before = entrance_before(past, vertex, edge)
    acted_before = .false.
    if (before > 0) acted_before = past%contact((before + 1)/2)%active == 2 - modulo(before, 2)
  end function acted_before

  !> The contact of an encounter, each of its lines at the pair that fits best. Without a vertex where an element would touch
  !> itself.
  pure subroutine contact_over_edges(outlines, survey, past, encounter, contact)
    type(outlines_t), intent(in) :: outlines
    type(survey_t), intent(in) :: survey
    type(past_t), intent(in) :: past
    type(encounter_t), intent(in) :: encounter
    type(contact_t), intent(out) :: contact
    integer :: k

    contact%n_entrances = encounter%n_lines
    contact%covered = encounter%covered
    do k = 1, contact%n_entrances
      call find_best_entrance(outlines, survey, past, encounter%line(k), contact%entrance(k))
      if (contact%entrance(k)%vertex == 0) return
    end do
    contact%active = entrance_ahead(survey, contact)
    call rest_inside(outlines%block, survey, past, contact)
  end subroutine contact_over_edges

  !> The pair of a line whose entrance was closed before, or else the one whose vertex lies best within its edge. It goes on as it
  !> was, or where it was not closed as another pair of the line that was.
  pure subroutine find_best_entrance(outlines, survey, past, line, best)
    type(outlines_t), intent(in) :: outlines
    type(survey_t), intent(in) :: survey
    type(past_t), intent(in) :: past
    type(line_t), intent(in) :: line
    type(entrance_t), intent(inout) :: best !! a new one
    real(dp) :: at, inside, most
    integer :: before, k, known
    logical :: goes_on, was_closed

    most = -huge(most)
    known = 0
    goes_on = .false.
    do k = 1, line%n
      if (outlines%element(line%vertex(k)) == outlines%element(line%edge(k))) cycle
      associate (length => survey%length(line%edge(k)))
        at = along_edge(survey, line%vertex(k), line%edge(k))
        inside = min(at, length - at)
        before = entrance_before(past, line%vertex(k), line%edge(k))
        was_closed = .false.
        if (before > 0) then
          was_closed = is_closed(past, before)
          if (inside >= -beyond*length) inside = merge(huge(inside), 0.5_dp*huge(inside), was_closed)
        end if
        if (known == 0 .or. (was_closed .and. (inside > most .or. .not. goes_on))) known = before ! its own, where it goes on
        if (inside <= most) cycle
        most = inside
        goes_on = was_closed
        best%vertex = line%vertex(k)
        best%edge = line%edge(k)
        best%anchor = at/length
      end associate
    end do
    if (best%vertex == 0) return
    best%joint = outlines%joint(best%edge)
    if (known > 0) call go_on(survey, past%contact((known + 1)/2)%entrance(2 - modulo(known, 2)), best)
    best%from = known
  end subroutine find_best_entrance

  !> Lets one contact alone go on from an entrance of the step before: that of the same pair, or else the first. Vertices at both
  !> ends of an edge so short that another vertex slides off it may each take its place; the others rest where they are.
  pure subroutine let_one_go_on(survey, past, contact)
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
          associate (was => past%contact((entrance%from + 1)/2)%entrance(2 - modulo(entrance%from, 2)))
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
        new%rest = min(0.0_dp, gap_at(survey, new%vertex, new%edge))
        entrance = new
      end associate
    end do
  end subroutine let_one_go_on

  !> Lets an entrance go on where another was: with the same slip, and its spring pressed by as much.
  pure subroutine go_on(survey, was, entrance)
    type(survey_t), intent(in) :: survey
    type(entrance_t), intent(in) :: was
    type(entrance_t), intent(inout) :: entrance
    real(dp) :: gap, slip

    call recall(was, entrance)
    gap = gap_at(survey, entrance%vertex, entrance%edge) - entrance%dilated
    if (entrance%state /= state_open) then
      slip = along_edge(survey, was%vertex, was%edge) - was%anchor*survey%length(was%edge)
      entrance%anchor = entrance%anchor - slip/survey%length(entrance%edge)
      if (entrance%vertex /= was%vertex .or. entrance%edge /= was%edge) &
        entrance%rest = min(0.0_dp, gap - min(0.0_dp, gap_at(survey, was%vertex, was%edge) - was%dilated - was%rest))
    end if
    if (entrance%bonded .and. entrance%state /= state_open) return
    if (gap >= entrance%rest) entrance%rest = min(0.0_dp, gap) ! what has come out stays out
  end subroutine go_on

  !> Hands on all that an entrance remembers, but for its place and its anchor.
  pure subroutine recall(was, entrance)
    type(entrance_t), intent(in) :: was
    type(entrance_t), intent(inout) :: entrance
    type(entrance_t) :: new

    new = entrance
    entrance = was
    entrance%vertex = new%vertex
    entrance%edge = new%edge
    entrance%joint = new%joint
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

  !> Lets the spring of a contact that is found inside rest there, so that it brings no energy. Where its vertex pressed on another
  !> body, from which it slides to this one, it is as stiff as the spring there, and pressed as much from the beginning: it takes
  !> over from that. A vertex that bore nothing, as the node of a mesh within a face, has nothing to hand on.
  pure subroutine rest_inside(block, survey, past, contact)
    integer, intent(in) :: block(:)            !! of the edges
    type(survey_t), intent(in) :: survey
    type(past_t), intent(in) :: past
    type(contact_t), intent(inout) :: contact
    real(dp) :: gap, pressed
    integer :: heir

    associate (entrance => contact%entrance(contact%active))
      if (entrance%state /= state_open .or. acted_before(past, entrance%vertex, entrance%edge)) return
      gap = gap_at(survey, entrance%vertex, entrance%edge)
      entrance%rest = min(0.0_dp, gap)
      if (gap >= 0) return
      call find_pressed_beside(block, survey, past, entrance, pressed, heir)
      if (heir == 0) return
      entrance%rest = min(0.0_dp, gap + pressed)
    end associate
    contact%inherits = pressed
    call take_stiffness(past%contact(heir)%entrance(past%contact(heir)%active), contact)
  end subroutine rest_inside

  !> Overlap and contact of the spring by which the vertex of an entrance pressed most on other bodies than that of its edge when
  !> the step before ended, across edges that face as its own does, within 45 degrees.
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
      do k = entrances%first(i), entrances%first(i + 1) - 1
        associate (was => past%contact((entrances%number(k) + 1)/2), other => entrances%edge(k))
          if (.not. is_closed(past, entrances%number(k)) .or. .not. was%pressed > pressed) cycle
          if (block(other) == block(entrance%edge)) cycle
          if (abs(turn(survey%corner(other)%from - survey%corner(entrance%edge)%from)) > pi/4) cycle
          pressed = was%pressed
          by = (entrances%number(k) + 1)/2
        end associate
      end do
    end associate
  end subroutine find_pressed_beside

  !> Lets a contact inherit the overlap and the stiffness of the spring of a contact before whose place it takes: one that had a
  !> pair of the encounter closed, and was not made of the same entrances. Overlap below 0: there is none; 0: it is found inside.
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
    type(line_t), intent(in) :: line
    type(contact_t), intent(inout) :: contact
    real(dp) :: overlap
    integer :: before, heir, k

    associate (active => contact%entrance(contact%active))
      overlap = merge(0.0_dp, -1.0_dp, active%state == state_open .and. gap_at(survey, active%vertex, active%edge) < 0)
    end associate
    heir = 0
    do k = 1, line%n
      before = entrance_before(past, line%vertex(k), line%edge(k))
      if (before == 0) cycle
      associate (was => past%contact((before + 1)/2))
        if (has_same_entrances(was, contact)) then
          overlap = -1.0_dp
          heir = 0
        else if (was%entrance(2 - modulo(before, 2))%state /= state_open .and. was%pressed >= overlap) then
          overlap = was%pressed
          heir = (before + 1)/2
        end if
      end associate
    end do
    if (overlap <= contact%inherits) return
    contact%inherits = overlap
    if (heir > 0) call take_stiffness(past%contact(heir)%entrance(past%contact(heir)%active), contact)
  end subroutine inherit_by_line

  !> The contact of an encounter as Shi's programs hand it on (df05, df06). Two corners have no friction: they slide at most.
  !> Without a vertex where an element would touch itself.
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

  !> The first pair of a line where its vertex lies within its edge, else the last, with what the pairs remember. Only the same
  !> pair, and locked, keeps its anchor (Shi: df05, df06).
  pure type(entrance_t) function first_entrance(outlines, survey, past, guard, line) result(first)
    type(outlines_t), intent(in) :: outlines
    type(survey_t), intent(in) :: survey
    type(past_t), intent(in) :: past
    real(dp), intent(in) :: guard   !! length^2
    type(line_t), intent(in) :: line
    real(dp) :: left
    integer :: before, k, known
    logical :: within

    known = 0
    within = .false.
    do k = 1, line%n
      if (outlines%element(line%vertex(k)) == outlines%element(line%edge(k))) cycle
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
    associate (was => past%contact((known + 1)/2)%entrance(2 - modulo(known, 2)))
      call recall(was, first)
      if (was%state == state_locked .and. was%vertex == first%vertex) then
        first%anchor = was%anchor
      else if (was%state /= state_open .and. past%contact((known + 1)/2)%n_entrances == 2) then
        first%state = state_locked
      end if
    end associate
  end function first_entrance

end module scree_contact_memory
