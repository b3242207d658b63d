!> Who may touch in a step (Shi's df04, df05, df06).
!>
!> A search in a grid lists vertices near edges, with room to move; it is repeated only when a vertex may leave its room
!> (`contact_look`). Of the pairs that it lists every step makes contacts, at distances that the motion of the step may close:
!>
!> - a vertex over an edge that its corner fits on (`edge_contacts`),
!> - two corners that are near each other (`corner_contacts`).
!>
!> A contact goes on where a contact of the step before had its vertex and edge (`contact_memory`). A vertex that lies behind an
!> edge is in contact with that edge only if it entered there.
module scree_contact_detection
  use scree_body_overlap, only: body_overlap_t, overlap_of_bodies, still_outside
  use scree_body_search, only: near_at_rest
  use scree_contact_faces, only: faces_of
  use scree_contact_look, only: begin_look, look_t
  use scree_contact_memory, only: let_one_go_on, wear_as_beside
  use scree_contact_pairs, only: contact_of, drop_repeats
  use scree_contact_try, only: contact_try_t
  use scree_contacts, only: contact_law_t, contact_memory_t, contact_search_t, contact_t, outlines_t, state_open
  use scree_corner_contacts, only: meet_corners
  use scree_corner_meeting, only: encounter_of_edge
  use scree_corners, only: along_edge, gap_at, is_straight, survey_t, way_at
  use scree_edge_contacts, only: add_contact, meet_edge
  use scree_joint_rules, only: joints_have_stiffness, joints_wear
  use scree_joint_stiffness, only: follow_slip
  use scree_kinds, only: dp
  use scree_past_contacts, only: moves_along, past_t
  implicit none
  private
  public :: find_contacts

contains

  !> Finds the contacts of a step that begins with the vertices at `position`. Contacts take over the memory of those before.
  subroutine find_contacts(outlines, position, predicted, self_contact, memory, search, try)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)       !! (2, n_vertices) of the elements, length
    real(dp), intent(in) :: predicted(:, :)      !! (2, n) displacement of the vertices of the outlines, by their velocity, length
    logical, intent(in) :: self_contact          !! a body may touch itself
    type(contact_memory_t), target, intent(in) :: memory
    type(contact_search_t), target, intent(inout) :: search !! gets where contacts were looked for
    type(contact_try_t), intent(inout) :: try !! with law, extra reach and extra turn; gets contacts
    type(look_t) :: look
    integer :: k, near(2)

    call begin_look(outlines, position, predicted, self_contact, memory, search, try, look)
    do k = 1, size(look%nearby, 2)
      near = look%nearby(:, k)
      call look_at(try%law, outlines, position, look, near(1), near(2))
    end do
    do k = 1, size(memory%inside, 2)
      associate (i => memory%inside(1, k), j => memory%inside(2, k))
        if (is_inside(outlines, position, look%survey, i, j)) &
          call add_contact(try%law, outlines, position, encounter_of_edge(i, edges_along(outlines, look%survey, i, j)), look)
      end associate
    end do
    call drop_repeats(size(outlines%start), look%found, look%n_found, search%found)
    try%contact = look%found(:look%n_found)
    call let_one_go_on(outlines, look%survey, look%past, try%contact)
    if (joints_have_stiffness(try%law)) call follow_faces(try%law, outlines, position, look%survey, look%past, try%contact)
    if (joints_wear(try%law)) call wear_as_beside(outlines, look%survey, look%past, try%contact)
    try%inside = pairs_inside(try%contact, look%survey%local)
    call move_alloc(look%nearby, try%nearby)
    call move_alloc(look%pressed, try%pressed)
    call move_alloc(look%survey, search%survey)
  end subroutine find_contacts

  !> Adds the contacts of vertex i near edge j. If the corner at i is near a corner at an end of the edge, these are the contacts of
  !> the two corners; otherwise it is the contact of the vertex over the edge.
  subroutine look_at(law, outlines, position, look, i, j)
    type(contact_law_t), intent(in) :: law
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)       !! (2, n_vertices) of the elements, length
    type(look_t), intent(inout) :: look
    integer, intent(in) :: i, j
    real(dp) :: to_finish, to_start              ! distance of the vertex from the ends of the edge, length
    logical :: near_start, near_finish

    associate (survey => look%survey, near => look%survey%reach_corner)
      to_start = norm2(survey%start(:, i) - survey%start(:, j))
      to_finish = norm2(survey%start(:, i) - survey%finish(:, j))
      near_start = to_start <= near(i) + near(j)
      near_finish = to_finish <= near(i) + near(outlines%next(j))
    end associate
    if (near_start) then
      if (i < j) call meet_corners(law, outlines, position, look, i, j)
    else if (.not. near_finish) then
      call meet_edge(law, outlines, position, look, i, j)
    end if
  end subroutine look_at

  !> Whether a vertex that rests behind an edge is still in its body, wherever along the edge.
  pure logical function is_inside(outlines, position, survey, i, j)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)       !! (2, n_vertices) of the elements, length
    type(survey_t), intent(in) :: survey
    integer, intent(in) :: i, j
    type(body_overlap_t) :: overlap

    is_inside = gap_at(survey, i, j) < -still_outside*min(survey%local(i), survey%length(j))
    if (.not. is_inside) return
    call overlap_of_bodies(outlines, position, outlines%block(i), outlines%block(j), overlap)
    is_inside = any(overlap%corner%vertex == i)
  end function is_inside

  !> The edge that vertex i is inside of, and where its foot is beyond an end of edge j the edge that goes on there in the same
  !> direction.
  pure function edges_along(outlines, survey, i, j) result(edge)
    type(outlines_t), intent(in) :: outlines
    type(survey_t), intent(in) :: survey
    integer, intent(in) :: i, j
    integer, allocatable :: edge(:)
    integer :: beside
    real(dp) :: at

    edge = [j]
    at = along_edge(survey, i, j)
    if (at >= 0 .and. at <= survey%length(j)) return
    beside = merge(outlines%previous(j), outlines%next(j), at < 0)
    if (is_straight(survey%corner(merge(j, beside, at < 0)))) edge = [beside, j]
  end function edges_along

  !> Lets contacts of joints with a stiffness of their own follow contacts that slide along the same faces.
  pure subroutine follow_faces(law, outlines, position, survey, past, contact)
    type(contact_law_t), intent(in) :: law
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)       !! (2, n_vertices) of the elements, length
    type(survey_t), intent(in) :: survey
    type(past_t), intent(in) :: past
    type(contact_t), intent(inout) :: contact(:)
    real(dp) :: most(2, size(outlines%start))    ! two largest overlaps by which each edge pressed on what slides, length
    logical :: is_borne                          ! others press on the faces of a contact, by half as much at least
    integer :: k

    most(:, survey%edge) = 0.0_dp
    do k = 1, size(past%contact)
      if (.not. moves_along(past%contact(k))) cycle
      associate (own => past%contact(k)%pressed, faces => faces_of(outlines, survey, past%contact(k)))
        most(2, faces) = max(most(2, faces), min(most(1, faces), own))
        most(1, faces) = max(most(1, faces), own)
      end associate
    end do
    do k = 1, size(contact)
      associate (vertex => contact(k)%entrance(1)%vertex, edge => contact(k)%entrance(1)%edge, from => contact(k)%entrance(1)%from)
        if (contact(k)%entrance(1)%state == state_open .or. from == 0) cycle
        associate (was => past%contact(contact_of(from)))
          if (.not. moves_along(was)) cycle
          associate (others => most(:, faces_of(outlines, survey, was)), &
                     way => way_at(survey, outlines%next(edge), vertex, edge))
            is_borne = any(merge(others(2, :), others(1, :), others(1, :) <= was%pressed) >= 0.5_dp*was%pressed)
            call follow_slip(outlines, position, law, max(abs(way(1)), was%slipped), is_borne, was, contact(k))
          end associate
        end associate
      end associate
    end do
  end subroutine follow_faces

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
