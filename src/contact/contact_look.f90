!> Data of the detection of contacts in one step: the present outlines, the contacts of the step before, and the reach of contacts
!> around each vertex.
module scree_contact_look
  use scree_body_search, only: beyond_way, list_all, reach_of
  use scree_contact_rules, only: corners_turn, deepest_search, looks_as_far_as_it_moves
  use scree_contact_search, only: find_nearby, most_turning
  use scree_contact_try, only: contact_try_t
  use scree_contacts, only: contact_memory_t, contact_search_t, contact_t, outlines_t, state_open
  use scree_corners, only: find_corners, gap_at, survey_edges, survey_t
  use scree_joint_rules, only: joints_dilate
  use scree_kinds, only: dp
  use scree_past_contacts, only: past_t, pressed_of_blocks, recall_contacts
  implicit none
  private
  public :: begin_look, look_t

  real(dp), parameter :: beyond_depth = 1.2_dp    !! ratio of the reach to the depth or gap of a contact that exists

  !> The detection of contacts in one step.
  type :: look_t
    type(survey_t), allocatable :: survey         !! edges, corners and reaches
    type(past_t) :: past                          !! contacts of the step before
    logical :: may_rest                           !! a vertex behind an edge by which it did not enter has no contact there
    real(dp) :: depth                             !! largest penetration at which a vertex over an edge is looked at, length
    real(dp), allocatable :: pressed(:)           !! (n_blocks) largest penetration of a spring of each block, length
    integer, allocatable :: nearby(:, :)          !! (2, n) vertices and edges near each other
    integer :: n_sorted = 0                       !! pairs of `nearby` that are in the order of their edges
    type(contact_t), allocatable :: found(:)      !! contacts found so far are found(:n_found)
    integer :: n_found = 0
  end type look_t

contains

  !> Surveys the outlines and lists which vertices are near which edges.
  subroutine begin_look(outlines, position, predicted, self_contact, memory, search, try, look)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)        !! (2, n_vertices) of the elements, length
    real(dp), intent(in) :: predicted(:, :)       !! (2, n) displacement of the vertices of the outlines by their velocity, length
    logical, intent(in) :: self_contact           !! a body may touch itself
    type(contact_memory_t), target, intent(in) :: memory
    type(contact_search_t), target, intent(inout) :: search
    type(contact_try_t), intent(inout) :: try !! with its law, and its extra reach and turn, else it gets none
    type(look_t), intent(out) :: look
    integer :: k

    if (.not. allocated(search%bodies%vertex)) call list_all(outlines, search%bodies)
    if (.not. allocated(try%extra_reach)) allocate (try%extra_reach(size(outlines%first) - 1), source=0.0_dp)
    if (.not. allocated(try%extra_turn)) allocate (try%extra_turn(size(outlines%first) - 1), source=0.0_dp)
    call recall_contacts(outlines, memory%contact, search%past, look%past)
    look%pressed = pressed_of_blocks(outlines, look%past)
    call move_alloc(search%survey, look%survey)
    if (.not. allocated(look%survey)) allocate (look%survey)
    associate (about => search%bodies%about, farther => search%bodies%farther)
      call survey_edges(outlines, position, farther, about, look%survey)
      look%survey%way(:, farther) = predicted(:, farther)
      call find_corners(outlines%previous, about, look%survey)
      do k = 1, size(about)
        look%survey%turning(about(k)) = 0.0_dp
        if (corners_turn(try%law)) &
          look%survey%turning(about(k)) = max(turning_of(outlines, look%survey, try%extra_turn, about(k)), &
                                              turning_of(outlines, look%survey, try%extra_turn, outlines%previous(about(k))))
      end do
      call set_reaches(outlines, about, memory, try, look%pressed, look%survey)
      call find_nearby(outlines, position, look%survey%reach_edge, look%survey%local, self_contact, search, look%nearby, &
          look%n_sorted)
      look%nearby = reshape([look%nearby, memory%inside], [2, size(look%nearby, 2) + size(memory%inside, 2)])
      call measure_beside(outlines, about, look%nearby, look%survey%length, look%survey%local)
      call measure_beside(outlines, about, look%nearby, look%survey%side, look%survey%local_side)
      call set_reaches(outlines, about, memory, try, look%pressed, look%survey)
    end associate
    look%may_rest = looks_as_far_as_it_moves(try%law)
    look%depth = deepest_search(try%law)
    allocate (look%found(size(memory%contact) + 8))
  end subroutine begin_look

  !> Gives vertices and edges that are near each other the smallest length about both, so that a large block takes the measure of a
  !> small block beside it.
  pure subroutine measure_beside(outlines, about, nearby, length, local)
    type(outlines_t), intent(in) :: outlines
    integer, intent(in) :: about(:)               !! vertices that are looked at
    integer, intent(in) :: nearby(:, :)           !! (2, m) vertices and edges near each other
    real(dp), intent(in) :: length(:)             !! (n) of edges or of their sides, length
    real(dp), intent(inout) :: local(:)           !! (n) smallest of them at each vertex, length
    real(dp) :: own(size(local))
    integer :: k

    own(about) = local(about)
    do k = 1, size(nearby, 2)
      associate (i => nearby(1, k), j => nearby(2, k))
        local([j, outlines%next(j)]) = min(local([j, outlines%next(j)]), own(i))
        local(i) = min(local(i), length(j))
      end associate
    end do
  end subroutine measure_beside

  !> Angle by which an edge may turn in the step, rad.
  pure real(dp) function turning_of(outlines, survey, extra_turn, edge) result(turning)
    type(outlines_t), intent(in) :: outlines
    type(survey_t), intent(in) :: survey
    real(dp), intent(in) :: extra_turn(:)         !! (n_blocks) angle beyond what velocities make, rad
    integer, intent(in) :: edge

    associate (way => survey%way, next => outlines%next(edge), block => outlines%block(edge))
      turning = min(most_turning, beyond_way*norm2(way(:, next) - way(:, edge))/survey%length(edge) + extra_turn(block))
    end associate
  end function turning_of

  !> Sets how far contacts are looked for. Corners meet vertices within a straight side only as far as the edges of the mesh there
  !> allow. With a larger reach a corner would be near all the vertices of the side, and over none of its edges.
  pure subroutine set_reaches(outlines, about, memory, try, pressed, survey)
    type(outlines_t), intent(in) :: outlines
    integer, intent(in) :: about(:)               !! vertices that are looked at
    type(contact_memory_t), intent(in) :: memory
    type(contact_try_t), intent(in) :: try
    real(dp), intent(in) :: pressed(:)            !! (n_blocks) largest penetration of a spring of each block, length
    type(survey_t), intent(inout) :: survey
    real(dp) :: way                               ! by the velocity, length
    integer :: k

    do k = 1, size(about)
      associate (i => about(k), local => survey%local(about(k)), side => survey%local_side(about(k)), law => try%law, &
                 extra_reach => try%extra_reach(outlines%block(about(k))), own => pressed(outlines%block(about(k))))
        way = norm2(survey%way(:, i))
        survey%reach_edge(i) = reach_of(law, extra_reach, own, way, local, side)
        survey%reach_corner(i) = reach_of(law, extra_reach, own, way, local, merge(side, local, outlines%begins_side(i)))
        survey%reach_at_rest(i) = reach_of(law, 0.0_dp, own, 0.0_dp, local, side)
      end associate
    end do
    call reach_over_depth(memory%contact, survey)
    if (joints_dilate(try%law)) call reach_over_dilation(about, memory%contact, survey)
  end subroutine set_reaches

  !> Widens the reach at vertices of closed contacts: to the depth to which soft springs let them penetrate between short edges, and
  !> to the gap to which they pull bonds.
  pure subroutine reach_over_depth(contact, survey)
    type(contact_t), intent(in) :: contact(:)     !! of the step before
    type(survey_t), intent(inout) :: survey
    real(dp) :: least
    integer :: k

    do k = 1, size(contact)
      associate (entrance => contact(k)%entrance(contact(k)%active))
        if (entrance%state == state_open) cycle
        least = beyond_depth*abs(gap_at(survey, entrance%vertex, entrance%edge))
        survey%reach_edge(entrance%vertex) = max(survey%reach_edge(entrance%vertex), least)
        survey%reach_corner(entrance%vertex) = max(survey%reach_corner(entrance%vertex), least)
        survey%reach_at_rest(entrance%vertex) = max(survey%reach_at_rest(entrance%vertex), least)
      end associate
    end do
  end subroutine reach_over_depth

  !> Widens the reach at vertices whose joints have dilated: their contacts last until the faces are apart by as much once more.
  pure subroutine reach_over_dilation(about, contact, survey)
    integer, intent(in) :: about(:)               !! vertices that are looked at
    type(contact_t), intent(in) :: contact(:)     !! of the step before
    type(survey_t), intent(inout) :: survey
    real(dp) :: dilated(size(survey%reach_edge))
    integer :: i, k

    dilated(about) = 0.0_dp
    do k = 1, size(contact)
      do i = 1, contact(k)%n_entrances
        associate (entrance => contact(k)%entrance(i))
          dilated(entrance%vertex) = max(dilated(entrance%vertex), 2*entrance%memory%dilated)
        end associate
      end do
    end do
    survey%reach_edge(about) = survey%reach_edge(about) + dilated(about)
    survey%reach_corner(about) = survey%reach_corner(about) + dilated(about)
    survey%reach_at_rest(about) = survey%reach_at_rest(about) + dilated(about)
  end subroutine reach_over_dilation

end module scree_contact_look
