!> Who may touch in a step (Shi's df04, df05, df06).
!>
!> A search in a grid lists vertices near edges, with room to move; it is repeated only when a vertex may leave its room. Of what it
!> lists every step makes contacts, at distances that the motion of the step may close:
!>
!> - a vertex over an edge that its corner fits on,
!> - two corners that are near each other (`corner_meeting`).
!>
!> A contact goes on where one of the step before had its vertex and edge (`contact_memory`). A vertex that lies behind an edge is
!> in contact with it only if it entered there.
module scree_contact_detection
  use scree_body_overlap, only: body_overlap_t, entered_by, overlap_of_bodies, still_outside
  use scree_body_search, only: beyond_way, list_all, reach_of
  use scree_contact_faces, only: faces_of
  use scree_contact_geometry, only: gap_of
  use scree_contact_memory, only: let_one_go_on, wear_as_beside
  use scree_contact_pairs, only: contact_of, drop_repeats
  use scree_contact_rules, only: corners_turn, deepest_search, looks_as_far_as_it_moves, meet, pair
  use scree_contact_search, only: find_nearby, most_turning
  use scree_contact_try, only: contact_try_t
  use scree_contacts, only: contact_memory_t, contact_search_t, contact_t, entrance_t, outlines_t, parallel, state_open
  use scree_corner_meeting, only: encounter_of_edge, encounter_t, is_hollow, line_t, meeting_t
  use scree_corners, only: along_edge, edges_lead_away, find_corners, gap_at, survey_edges, survey_t, tilt, turn, way_at
  use scree_joint_rules, only: joints_dilate, joints_give_way, joints_wear
  use scree_joint_stiffness, only: at_end, follow_slip
  use scree_kinds, only: dp, pi
  use scree_past_contacts, only: acted_before, closed_between, moves_along, past_t, pressed_before, recall_contacts, &
                                 pressed_of_blocks, stood_for_both, were_bonded
  implicit none
  private
  public :: find_contacts

  real(dp), parameter :: near_at_rest = 1e-3_dp   !! of the edges about, up to which contacts are looked for
  real(dp), parameter :: beyond_depth = 1.2_dp    !! times the depth or gap of a contact that there is
  real(dp), parameter :: flush = 1e-4_dp          !! of the edges about, up to which corners of blocks side by side are one
  real(dp), parameter :: tips_flush = 5e-5_dp     !! likewise, up to which tips across from each other bear nothing
  real(dp), parameter :: most_flush = 1e-2_dp     !! likewise, of blocks that springs let sink
  real(dp), parameter :: on_it = 1e-9_dp          !! likewise, up to which a corner over a line lies on it
  real(dp), parameter :: turns = 3e-2_dp          !! angle in a step, by more than which one line does not keep two corners out, rad
  integer, parameter :: both_lines = 3            !! of a contact, that something lies flush with
  integer, parameter :: beside_it = 4             !! what lies flush with one of them has the vertex over it still

contains

  !> Contacts of a step that begins with the vertices at `position`, with what those before remember.
  subroutine find_contacts(outlines, position, predicted, self_contact, memory, search, try)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)       !! (2, n_vertices) of the elements, length
    real(dp), intent(in) :: predicted(:, :)      !! (2, n) displacement of the vertices of the outlines, by their velocity, length
    logical, intent(in) :: self_contact          !! a body may touch itself
    type(contact_memory_t), intent(in) :: memory
    type(contact_search_t), intent(inout) :: search
    type(contact_try_t), intent(inout) :: try    !! with law, margin and swing; gets contacts, and where they were looked for
    type(survey_t) :: survey
    type(past_t) :: past
    type(contact_t), allocatable :: found(:)
    logical :: may_rest                          !! a vertex behind an edge that it did not enter by is no contact
    real(dp) :: depth                            !! overlap up to which a vertex over an edge is looked at, length
    real(dp), allocatable :: pressed(:)          !! (n_blocks) largest overlap of a spring of each, length
    integer :: k, n_found
    integer :: n_sorted                          !! pairs nearby in the order of their edges, before those inside

    if (.not. allocated(search%bodies%vertex)) call list_all(outlines, search%bodies)
    call survey_edges(outlines, position, search%bodies%farther, search%bodies%about, survey)
    survey%way = predicted
    call find_corners(outlines%previous, search%bodies%about, survey)
    call look_around()
    call recall_contacts(outlines, memory, past)
    pressed = pressed_of_blocks(outlines, past)
    may_rest = looks_as_far_as_it_moves(try%law)
    depth = deepest_search(try%law)
    allocate (found(size(memory%contact) + 8))
    n_found = 0
    do k = 1, size(try%nearby, 2)
      call look_at(try%nearby(1, k), try%nearby(2, k))
    end do
    do k = 1, size(memory%inside, 2)
      if (is_inside(memory%inside(1, k), memory%inside(2, k))) &
        call add(encounter_of_edge(memory%inside(1, k), edges_along(memory%inside(1, k), memory%inside(2, k))))
    end do
    call drop_repeats(size(outlines%start), found, n_found)
    call let_one_go_on(outlines, survey, past, found(:n_found))
    if (joints_give_way(try%law)) call follow_faces()
    if (joints_wear(try%law)) call wear_as_beside(outlines, survey, past, found(:n_found))
    try%contact = found(:n_found)
    try%inside = pairs_inside(found(:n_found), survey%local)
    call move_alloc(survey%near, try%near)
    call move_alloc(survey%local_side, try%local_side)
    call move_alloc(survey%turning, try%turning)

  contains

    !> Lists which vertices are near which edges, by how far these may move and turn in the step.
    subroutine look_around()
      associate (about => search%bodies%about)
        survey%turning(about) = 0.0_dp
        if (corners_turn(try%law)) &
          survey%turning(about) = max(turning_of(about), turning_of(outlines%previous(about)))
      end associate
      call look_as_far()
      call find_nearby(outlines, position, survey%near, survey%local, self_contact, search, try%nearby, n_sorted)
      try%nearby = reshape([try%nearby, memory%inside], [2, size(try%nearby, 2) + size(memory%inside, 2)])
      call measure_beside(survey%length, survey%local)
      call measure_beside(survey%side, survey%local_side)
      call look_as_far()
    end subroutine look_around

    !> Lets vertices and edges that are near each other take the least length about both: a large block the measure of a small one
    !> beside it, of which no other block knows.
    pure subroutine measure_beside(length, local)
      real(dp), intent(in) :: length(:)       !! (n) of edges or of their sides
      real(dp), intent(inout) :: local(:)     !! (n) least of them at each vertex, length
      real(dp) :: own(size(local))
      integer :: k

      own = local
      do k = 1, size(try%nearby, 2)
        associate (i => try%nearby(1, k), j => try%nearby(2, k))
          local([j, outlines%next(j)]) = min(local([j, outlines%next(j)]), own(i))
          local(i) = min(local(i), length(j))
        end associate
      end do
    end subroutine measure_beside

    !> How far edges may turn in the step.
    pure function turning_of(edge) result(turning)
      integer, intent(in) :: edge(:)
      real(dp) :: turning(size(edge))

      turning = min(most_turning, 1.2_dp*norm2(predicted(:, outlines%next(edge)) - predicted(:, edge), 1)/survey%length(edge) &
                                  + try%swing)
    end function turning_of

    !> Sets how far contacts are looked for. Where a mesh has vertices within a side, corners meet these no farther than its edges
    !> tell: over more of them they would be near all the vertices of a side, and over none of its edges.
    subroutine look_as_far()

      associate (about => search%bodies%about)
        survey%near(about) = reach(try%margin, norm2(predicted(:, about), 1), survey%local_side(about))
        survey%meets(about) = reach(try%margin, norm2(predicted(:, about), 1), &
                                    merge(survey%local_side(about), survey%local(about), outlines%begins_side(about)))
        survey%still(about) = reach(0.0_dp, spread(0.0_dp, 1, size(about)), survey%local_side(about))
      end associate
      call look_over_depth()
      if (joints_dilate(try%law)) call look_over_dilation()
    end subroutine look_as_far

    !> How far contacts of the vertices that are about are looked for.
    pure function reach(margin, way, side)
      real(dp), intent(in) :: margin, way(:) !! length
      real(dp), intent(in) :: side(:)        !! up to a share of which they may leap, length
      real(dp) :: reach(size(way))           !! length

      reach = reach_of(try%law, margin, memory%pressed, way, survey%local(search%bodies%about), side)
    end function reach

    !> Looks farther from vertices of closed contacts: over the depth to which springs of soft joints let them between short edges,
    !> and over the gap to which they pull bonds.
    subroutine look_over_depth()
      real(dp) :: gap
      integer :: k

      do k = 1, size(memory%contact)
        associate (entrance => memory%contact(k)%entrance(memory%contact(k)%active))
          if (entrance%state == state_open) cycle
          gap = gap_at(survey, entrance%vertex, entrance%edge)
          survey%near(entrance%vertex) = max(survey%near(entrance%vertex), beyond_depth*abs(gap))
          survey%meets(entrance%vertex) = max(survey%meets(entrance%vertex), beyond_depth*abs(gap))
          survey%still(entrance%vertex) = max(survey%still(entrance%vertex), beyond_depth*abs(gap))
        end associate
      end do
    end subroutine look_over_depth

    !> Looks farther from vertices whose joints have dilated: their contacts last until they are apart by as much once more.
    subroutine look_over_dilation()
      real(dp) :: dilated(size(survey%near))
      integer :: i, k

      dilated = 0.0_dp
      do k = 1, size(memory%contact)
        do i = 1, memory%contact(k)%n_entrances
          associate (entrance => memory%contact(k)%entrance(i))
            dilated(entrance%vertex) = max(dilated(entrance%vertex), 2*entrance%dilated)
          end associate
        end do
      end do
      associate (about => search%bodies%about)
        survey%near(about) = survey%near(about) + dilated(about)
        survey%meets(about) = survey%meets(about) + dilated(about)
        survey%still(about) = survey%still(about) + dilated(about)
      end associate
    end subroutine look_over_dilation

    !> Contacts of vertex i near edge j: at one of its ends with the corner there, else over it.
    subroutine look_at(i, j)
      integer, intent(in) :: i, j

      associate (x => survey%start(:, i), near => survey%meets)
        if (norm2(x - survey%start(:, j)) <= near(i) + near(j)) then
          if (i < j) call meet_corners(i, j)
        else if (norm2(x - survey%finish(:, j)) > near(i) + near(outlines%next(j))) then
          call meet_edge(i, j)
        end if
      end associate
    end subroutine look_at

    !> Contact of vertex i over edge j.
    subroutine meet_edge(i, j)
      integer, intent(in) :: i, j
      real(dp) :: at, gap

      at = along_edge(survey, i, j)
      if (at < 0 .or. at > survey%length(j)) return
      gap = gap_at(survey, i, j)
      if (gap > survey%near(i) + max(survey%near(j), survey%near(outlines%next(j)))) return
      if (gap < -depth) return
      if (.not. edges_lead_away(survey%corner(i), survey%corner(j)%from, tilt(survey, i, j))) return
      call add(encounter_of_edge(i, [j]))
    end subroutine meet_edge

    !> Contacts of two corners that are near each other.
    subroutine meet_corners(i, j)
      integer, intent(in) :: i, j
      type(meeting_t) :: meeting
      integer :: had, k
      logical :: stood

      stood = is_hollow(survey%corner(i)) .or. is_hollow(survey%corner(j))
      if (stood) then
        associate (closed => closed_between(outlines, past, i, j))
          stood = stood_for_both(past, closed) .or. were_bonded(past, closed)
        end associate
      end if
      meeting = meet(try%law, survey, i, j, stood)
      if (meeting%encounter(1)%n_lines == 2) then
        call meet_tips(i, j, meeting)
        return
      end if
      if (meeting%flat .and. .not. (pass_as_one(i, j) .or. stay_together(i, j))) then
        had = n_found
        call meet_face(i, j)
        call meet_face(j, i)
        associate (line => meeting%encounter(1)%line(1))
          if (n_found > had .or. .not. (are_opposite(line) .or. slid_off(line))) return
        end associate
      end if
      do k = 1, meeting%n
        call add(meeting%encounter(k))
      end do
      if (meeting%beside(1)) call meet_sides(i, j)
      if (meeting%beside(2)) call meet_sides(j, i)
    end subroutine meet_corners

    !> Whether the corners of a line lie opposite each other, each past the end of the edges at the other by no more than the tilt
    !> of the two, which takes them for parallel, makes of the gap between them: neither is over an edge of the other.
    pure logical function are_opposite(line) result(opposite)
      type(line_t), intent(in) :: line
      real(dp) :: past_end(line%n)
      integer :: k

      past_end = [(way_past_end(line, k), k=1, line%n)]
      opposite = all(past_end > 0) .and. &
                 any([(past_end(k) <= parallel*abs(gap_at(survey, line%vertex(k), line%edge(k))), k=1, line%n)])
    end function are_opposite

    !> Whether a corner of a line was over an edge of the other and pressed, and is past the end of that there.
    pure logical function slid_off(line)
      type(line_t), intent(in) :: line
      integer :: k

      slid_off = any([(way_past_end(line, k) > 0 .and. pressed_before(past, line%vertex(k), line%edge(k)), k=1, line%n)])
    end function slid_off

    !> How far the foot of the vertex of pair k of a line is past the end of its edge at the other corner, length.
    pure real(dp) function way_past_end(line, k) result(way)
      type(line_t), intent(in) :: line
      integer, intent(in) :: k

      associate (vertex => line%vertex(k), edge => line%edge(k))
        way = along_edge(survey, vertex, edge) - survey%length(edge)
        if (any(line%vertex(:line%n) == edge)) way = -along_edge(survey, vertex, edge) ! it begins at that corner
      end associate
    end function way_past_end

    !> Whether two corners that lie flat on each other may pass each other in the step, by how they move towards each other: however
    !> fast both go together, and however far beyond that contacts are looked for. Vertices within a face may only as they slide, as
    !> its line goes on beyond them, or are at one place.
    pure logical function may_pass(i, j)
      integer, intent(in) :: i, j
      real(dp) :: shortest, way

      way = beyond_way*norm2(predicted(:, j) - predicted(:, i))
      if (is_straight(i) .and. is_straight(j)) then
        shortest = minval(survey%length([i, outlines%previous(i), j, outlines%previous(j)]))
        may_pass = abs(along_edge(survey, i, j)) <= at_end*shortest + way
      else
        may_pass = norm2(survey%start(:, j) - survey%start(:, i)) <= survey%still(i) + survey%still(j) + way
      end if
    end function may_pass

    !> Whether two corners that lie flat on each other may pass each other across one line. It does not keep both out where they
    !> turn in the step, and one is well over an edge at the other.
    pure logical function pass_as_one(i, j)
      integer, intent(in) :: i, j

      pass_as_one = may_pass(i, j)
      if (.not. pass_as_one .or. tilt(survey, i, j) - parallel <= turns) return
      pass_as_one = .not. (is_well_over(i, j) .or. is_well_over(i, outlines%previous(j)) .or. &
                           is_well_over(j, i) .or. is_well_over(j, outlines%previous(i)))
    end function pass_as_one

    !> Whether two corners that lie flat on each other go on with the one contact that stood for both, as the springs along their
    !> joint give way.
    pure logical function stay_together(i, j)
      integer, intent(in) :: i, j

      stay_together = .false.
      if (abs(along_edge(survey, i, j)) <= 0.5_dp*min(survey%local(i), survey%local(j))) &
        stay_together = stood_for_both(past, closed_between(outlines, past, i, j))
    end function stay_together

    !> Whether the edges at a vertex are parallel.
    pure logical function is_straight(i)
      integer, intent(in) :: i

      is_straight = abs(survey%corner(i)%angle - pi) <= parallel
    end function is_straight

    !> Contacts of vertex i over the edges at vertex j, where it may not pass another end of theirs either.
    subroutine meet_face(i, j)
      integer, intent(in) :: i, j

      if (.not. pass_as_one(i, outlines%next(j))) call meet_edge(i, j)
      if (.not. pass_as_one(i, outlines%previous(j))) call meet_edge(i, outlines%previous(j))
    end subroutine meet_face

    !> Contacts of two corners tip to tip, of which each may get over both edges of the other.
    subroutine meet_tips(i, j, meeting)
      integer, intent(in) :: i, j
      type(meeting_t), intent(inout) :: meeting
      integer :: before, had, k, line

      before = n_found
      do k = 1, meeting%n
        line = 0
        if (may_rest) line = covered_line(i, j, meeting%encounter(k))
        if (line < both_lines) meeting%encounter(k)%covered = line
        had = n_found
        call add(meeting%encounter(k))
        if (line < both_lines .or. n_found == had) cycle
        if (any(found(n_found)%entrance%state /= state_open)) cycle
        if (line == beside_it) n_found = had ! what lies flush bears, and the tips nothing
        if (line == both_lines) call let_give(give_of_tips(i, j), found(n_found))
      end do
      if (n_found > before + 1) call let_one_bear(i, j, before)
      if (.not. corners_turn(try%law)) return
      call meet_where_turned(i, j)
      call meet_where_turned(j, i)
    end subroutine meet_tips

    !> Lets a contact of two tips between which others lie flush bear nothing up to where springs let these sink, or where it is.
    subroutine let_give(give, contact)
      real(dp), intent(in) :: give
      type(contact_t), intent(inout) :: contact

      associate (ahead => contact%entrance(contact%active))
        contact%entrance%rest = -give
        ahead%rest = min(ahead%rest, gap_at(survey, ahead%vertex, ahead%edge))
      end associate
    end subroutine let_give

    !> Lets one of the contacts of two tips, those after the first so many, bear what they bear: one that is closed, or else the
    !> first. It comes before the others, which are open. Those that would begin across both of their lines rest where they are, if
    !> the tips turn far in the step and are hardly across; else they are left out.
    subroutine let_one_bear(i, j, before)
      integer, intent(in) :: i, j, before
      real(dp) :: gap(2), least
      integer :: bears, k, m, n

      least = 0.0_dp
      if (tilt(survey, i, j) - parallel > turns) least = -flush*min(survey%local(i), survey%local(j))
      bears = before + 1
      do k = n_found, before + 1, -1
        if (found(k)%entrance(found(k)%active)%state /= state_open) bears = k
      end do
      found([before + 1, bears]) = found([bears, before + 1])
      n = before
      do k = before + 1, n_found
        associate (contact => found(k))
          if (k > before + 1) then
            gap = [(gap_at(survey, contact%entrance(m)%vertex, contact%entrance(m)%edge), m=1, 2)]
            if (all(gap < least)) cycle
            contact%entrance%state = state_open
            contact%active = maxloc(gap, 1)
            contact%entrance%rest = min(contact%entrance%rest, maxval(gap))
          end if
          n = n + 1
          found(n) = contact
        end associate
      end do
      n_found = n
    end subroutine let_one_bear

    !> Contacts of vertex i over the edges at vertex j, where the two are near each other only as they move. An entrance line takes
    !> one of two edges that face each other as they lie when the step begins; in a step in which they turn both may be met. Not one
    !> that a third block lies flush with, into which springs let a corner sink that slides on it.
    subroutine meet_where_turned(i, j)
      integer, intent(in) :: i, j
      logical :: meets(2) !! the edge that begins at j, and that which ends there

      meets = [is_well_over(i, j), is_well_over(i, outlines%previous(j))]
      if (.not. any(meets)) return
      if (may_rest) meets = meets .and. .not. covered_edges(i, j)
      if (meets(1)) call meet_edge(i, j)
      if (meets(2)) call meet_edge(i, outlines%previous(j))
    end subroutine meet_where_turned

    !> Whether the foot of vertex i on edge j is farther from the ends of the edge than corners at rest are near each other.
    pure logical function is_well_over(i, j)
      integer, intent(in) :: i, j
      real(dp) :: at

      at = along_edge(survey, i, j)
      is_well_over = min(at, survey%length(j) - at) > near_at_rest*survey%local(i)
    end function is_well_over

    !> The entrance line of edges that a third block lies flush with, where a corner is behind the other line already: by its
    !> overlap with that block, on which it slides. It would be caught by a side that nothing can get at. 0 where there is none.
    !>
    !> Over the joint itself that block lies flush with both lines, and the corner may be on the other one; then it is the line that
    !> it is about to cross, and farther than the other one; both where it goes no farther than springs give, as where blocks rest.
    pure integer function covered_line(i, j, encounter) result(line)
      integer, intent(in) :: i, j
      type(encounter_t), intent(in) :: encounter
      logical :: covered(2) !! edges that begin at the corners, edges that end there
      logical :: own(2)     !! those of them that are at corner j
      real(dp) :: ahead(2), gap(2), on_line
      logical :: on_cover   !! the vertex of one is still over the block that covers the other's edge, where it presses
      integer :: k

      line = 0
      own = covered_edges(i, j)
      covered = own .or. covered_edges(j, i)
      if (.not. any(covered)) return
      gap = [(gap_at(survey, encounter%line(k)%vertex(1), encounter%line(k)%edge(1)), k=1, 2)]
      if (all(covered)) then
        on_line = on_it*min(survey%local(i), survey%local(j))
        ahead = [(gap_ahead(encounter%line(k)%vertex(1), encounter%line(k)%edge(1)), k=1, 2)]
        if (maxval(abs(ahead - gap)) <= give_of(i, j)) line = both_lines
        do k = 1, 2
          if (gap(3 - k) < on_line .and. gap(k) > -on_line .and. ahead(k) < min(0.0_dp, ahead(3 - k)) - on_line) line = k
        end do
      else
        line = merge(1, 2, covered(1))
        on_cover = stands_before(merge(i, j, own(line)), merge(j, i, own(line)), encounter%line(line), line)
        if (on_cover .and. gap(3 - line) < 0 .and. encounter%line(3 - line)%n == 1) line = beside_it ! not flat on the row
      end if
    end function covered_line

    !> Whether vertex i has not got to the edge that begins at corner j (1) or ends there (2), while an entrance line of these
    !> corners that is not that edge's is the side of the region before it.
    pure logical function stands_before(i, j, entrance_line, side)
      integer, intent(in) :: i, j, side
      type(line_t), intent(in) :: entrance_line
      integer :: edge

      edge = merge(j, outlines%previous(j), side == 1)
      stands_before = gap_at(survey, i, edge) > 0 .and. all(entrance_line%edge(:entrance_line%n) /= edge)
    end function stands_before

    !> Gap of vertex i over the line of edge j where their velocities take them in the step.
    pure real(dp) function gap_ahead(i, j)
      integer, intent(in) :: i, j

      associate (next => outlines%next(j))
        gap_ahead = gap_of(survey%start(:, i) + predicted(:, i), survey%start(:, j) + predicted(:, j), &
                           survey%finish(:, j) + predicted(:, next))
      end associate
    end function gap_ahead

    !> Whether a third block lies flush with the edge that begins at corner j, and with that which ends there, by a corner near i.
    pure function covered_edges(i, j) result(covered)
      integer, intent(in) :: i, j
      logical :: covered(2)
      integer :: k

      covered = .false.
      do k = first_at_edge(i), n_sorted
        if (try%nearby(2, k) /= i) return
        associate (c => try%nearby(1, k), block => outlines%block, local => survey%local)
          if (any(block(c) == block([i, j]))) cycle
          if (norm2(survey%start(:, c) - survey%start(:, j)) > give_of(c, j)) cycle
          if (norm2(predicted(:, c) - predicted(:, j)) > near_at_rest*min(local(c), local(j))) cycle ! it slides by
          associate (own => survey%corner(j), cover => survey%corner(c))
            covered(1) = covered(1) .or. abs(turn(cover%from + cover%angle - own%from)) < parallel
            covered(2) = covered(2) .or. abs(turn(own%from + own%angle - cover%from)) < parallel
          end associate
        end associate
      end do
    end function covered_edges

    !> How far the corners of blocks that lie flush may be apart, as springs let them sink.
    pure real(dp) function give_of(i, j)
      integer, intent(in) :: i, j

      give_of = give_by(flush, i, j)
    end function give_of

    !> How far two tips between which others lie flush may be in each other and bear nothing. How far springs sink under a load that
    !> comes at once is not known while none of their blocks is pressed.
    pure real(dp) function give_of_tips(i, j)
      integer, intent(in) :: i, j

      give_of_tips = give_by(merge(tips_flush, flush, any(pressed(outlines%block([i, j])) > 0)), i, j)
    end function give_of_tips

    !> How far corners i and j give way to each other: a share of the edges about, and twice what springs let one of their blocks.
    pure real(dp) function give_by(share, i, j)
      real(dp), intent(in) :: share
      integer, intent(in) :: i, j

      associate (local => min(survey%local(i), survey%local(j)))
        give_by = min(most_flush*local, share*local + 2*maxval(pressed(outlines%block([i, j]))))
      end associate
    end function give_by

    !> First pair nearby with edge i, by bisection.
    pure integer function first_at_edge(i) result(low)
      integer, intent(in) :: i
      integer :: high, middle

      low = 1
      high = n_sorted + 1
      do while (low < high)
        middle = (low + high)/2
        if (try%nearby(2, middle) < i) then
          low = middle + 1
        else
          high = middle
        end if
      end do
    end function first_at_edge

    !> Contacts of vertex i over the edges at vertex j, of which the corner there says nothing.
    subroutine meet_sides(i, j)
      integer, intent(in) :: i, j

      associate (x => survey%start(:, i), near => survey%near, after => outlines%next(j), before => outlines%previous(j))
        if (norm2(x - survey%start(:, after)) > near(i) + near(after)) call meet_edge(i, j)
        if (norm2(x - survey%start(:, before)) > near(i) + near(before)) call meet_edge(i, before)
      end associate
    end subroutine meet_sides

    !> Adds the contact of an encounter, if there is one.
    subroutine add(encounter)
      type(encounter_t), intent(in) :: encounter

      if (n_found == size(found)) found = [found, found]
      associate (contact => found(n_found + 1))
        call pair(try%law, outlines, survey, past, encounter, contact)
        if (any(contact%entrance(:contact%n_entrances)%vertex == 0)) return ! within one element, which cannot touch itself
        if (may_rest) then
          if (.not. has_entered(outlines, position, survey, past, contact%entrance(contact%active))) then
            if (contact%n_entrances == 1) return ! past one line of two, and not the other, a corner is outside and may enter there
            if (.not. has_entered(outlines, position, survey, past, contact%entrance(3 - contact%active))) return
            contact%active = 3 - contact%active
          end if
        end if
      end associate
      n_found = n_found + 1
    end subroutine add

    !> Whether a vertex that rests behind an edge is still in its body, wherever along the edge.
    pure logical function is_inside(i, j)
      integer, intent(in) :: i, j
      type(body_overlap_t) :: overlap

      is_inside = gap_at(survey, i, j) < -still_outside*min(survey%local(i), survey%length(j))
      if (.not. is_inside) return
      call overlap_of_bodies(outlines, position, outlines%block(i), outlines%block(j), overlap)
      is_inside = any(overlap%corner%vertex == i)
    end function is_inside

    !> Lets contacts of joints with a stiffness of their own follow what slides.
    subroutine follow_faces()
      real(dp) :: most(2, size(outlines%start))    ! two largest overlaps by which each edge pressed on what slides, length
      logical :: is_borne                          ! others press on the faces of a contact, by half as much at least
      integer :: k

      most = 0.0_dp
      do k = 1, size(past%contact)
        if (.not. moves_along(past%contact(k))) cycle
        associate (own => past%contact(k)%pressed, faces => faces_of(outlines, survey, past%contact(k)))
          most(2, faces) = max(most(2, faces), min(most(1, faces), own))
          most(1, faces) = max(most(1, faces), own)
        end associate
      end do
      do k = 1, n_found
        associate (vertex => found(k)%entrance(1)%vertex, edge => found(k)%entrance(1)%edge, from => found(k)%entrance(1)%from)
          if (found(k)%entrance(1)%state == state_open .or. from == 0) cycle
          associate (was => past%contact(contact_of(from)))
            if (.not. moves_along(was)) cycle
            associate (others => most(:, faces_of(outlines, survey, was)), &
                       way => way_at(survey, outlines%next(edge), vertex, edge))
              is_borne = any(merge(others(2, :), others(1, :), others(1, :) <= was%pressed) >= 0.5_dp*was%pressed)
              call follow_slip(outlines, position, try%law, max(abs(way(1)), was%slipped), is_borne, was, found(k))
            end associate
          end associate
        end associate
      end do
    end subroutine follow_faces

    !> The edge that vertex i is inside of, and where its foot is beyond an end of edge j that which goes on there in its direction.
    pure function edges_along(i, j) result(edge)
      integer, intent(in) :: i, j
      integer, allocatable :: edge(:)
      integer :: beside
      real(dp) :: at

      edge = [j]
      at = along_edge(survey, i, j)
      if (at >= 0 .and. at <= survey%length(j)) return
      beside = merge(outlines%previous(j), outlines%next(j), at < 0)
      if (is_straight(merge(j, beside, at < 0))) edge = [beside, j]
    end function edges_along

  end subroutine find_contacts

  !> Whether the vertex of an entrance entered there, if it is behind the line. It did where the entrance acted before, or goes on
  !> from one of its line that was closed, as where a corner slides off an edge that another begins to slide on; else the bodies
  !> tell. Its own body it is in anyway, and does not enter.
  pure logical function has_entered(outlines, position, survey, past, entrance) result(entered)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)       !! (2, n_vertices) of the elements, length
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

  !> Vertices that rest so deep behind an edge that a search may not see them at rest, each with that edge.
  pure function pairs_inside(contact, local) result(pair)
    type(contact_t), intent(in) :: contact(:)
    real(dp), intent(in) :: local(:)    !! (n) shorter edge at each vertex, length
    integer, allocatable :: pair(:, :)
    logical :: rests(2, size(contact))
    integer :: i, k, m

    rests = .false.
    do i = 1, size(contact)
      do k = 1, contact(i)%n_entrances
        associate (entrance => contact(i)%entrance(k))
          rests(k, i) = entrance%rest < -0.5_dp*near_at_rest*local(entrance%vertex)
        end associate
      end do
    end do
    allocate (pair(2, count(rests)))
    m = 0
    do i = 1, size(contact)
      do k = 1, 2
        if (.not. rests(k, i)) cycle
        m = m + 1
        pair(:, m) = [contact(i)%entrance(k)%vertex, contact(i)%entrance(k)%edge]
      end do
    end do
  end function pairs_inside

end module scree_contact_detection
