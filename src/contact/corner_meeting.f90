!> How two corners that are near each other can meet: which vertex by which edge (Shi's df05).
!>
!> A convex corner enters another convex corner only by crossing two entrance lines. These are the sides of the region that is
!> closed to the relative position of the two vertices: the sum of one corner and the reflected other corner. If the region is a
!> half plane, edges are parallel, and there is one line. A convex corner in a hollow corner can meet either edge of it.
module scree_corner_meeting
  use scree_contacts, only: parallel
  use scree_corners, only: corner_t, edges_lead_away, turn
  use scree_kinds, only: dp, pi
  implicit none
  private
  public :: add_edge, add_line, angle_between, encounter_of_edge, encounter_t, encounters_t, entrance_pairs_t, &
            is_hollow, line_of, meet_by_entrances, width_of

  !> Corners that turn by more than this in a step have the entrance lines of both ends of the step, rad.
  real(dp), parameter :: turned = 1e-3_dp
  !> A corner that is hollow by less than this counts as straight, rad.
  real(dp), parameter :: flat = 1e-3_dp
  !> The same of two corners that shared one contact because they lay flat on each other, or that a bond held, rad.
  real(dp), parameter :: most_bent = 0.5_dp

  !> The pairs of a vertex and an edge that may stand for an entrance line; the pair that fits best is taken (`pair_fit`).
  type :: entrance_pairs_t
    integer :: n = 0
    integer :: vertex(4) = 0
    integer :: edge(4) = 0
    logical :: aside(4) = .false. !! the other vertex bounds the region, as its edge is not quite parallel and reaches farther out
  end type entrance_pairs_t

  !> A possible contact of two corners, with one entrance line or two.
  type :: encounter_t
    integer :: n_lines = 1
    type(entrance_pairs_t) :: line(2)
    logical :: stands_for_both = .false. !! it is the one contact of both corners, because they lie flat on each other
    integer :: covered_line = 0 !! entrance line that a third block covers, so that it cannot be crossed; 0: none
  end type encounter_t

  !> The possible contacts of two corners.
  type :: encounters_t
    integer :: n = 0
    type(encounter_t) :: encounter(3)
    logical :: flat = .false.      !! their edges lie on each other: the region closed to them is a half plane
    logical :: beside(2) = .false. !! the first corner may meet the sides of the second; the second those of the first
  end type encounters_t

contains

  !> The possible contacts of corners a and b by their entrance lines; `tilt` is how far they may turn towards each other in the
  !> step. A hollow corner may be met at either edge. Nodes of two meshes keep their one contact as the joint between them bends.
  pure function meet_by_entrances(a, b, tilt, stood) result(meeting)
    type(corner_t), intent(in) :: a, b
    real(dp), intent(in) :: tilt !! rad
    logical, intent(in) :: stood !! one contact stood for both, or a bond held them; this goes on, however far the joint bends
    type(encounters_t) :: meeting
    real(dp) :: between
    logical :: bends !! the joint between them, at which they lie flat on each other

    between = angle_between(a, b)
    bends = stood .and. (is_hollow(a) .or. is_hollow(b)) .and. fits_on(a, b, between, tilt)
    if (max(a%angle, b%angle) <= pi + merge(most_bent, flat, bends)) then
      meeting = meet_convex(a, b, between, tilt, bends)
    else if (is_hollow(b) .and. a%angle <= pi + parallel) then
      meeting = meet_hollow(a, b, abs(between), tilt)
    else
      meeting = meet_hollow(b, a, abs(between), tilt)
      meeting%beside = meeting%beside(2:1:-1)
    end if
  end function meet_by_entrances

  !> Angle by which corner b is turned from where it would face corner a.
  pure real(dp) function angle_between(a, b)
    type(corner_t), intent(in) :: a, b

    angle_between = turn(a%from + a%angle/2 + pi - b%from - b%angle/2)
  end function angle_between

  !> Angle that two corners take up together, with what they are turned by: that of a half plane where edges lie on each other.
  pure real(dp) function width_of(a, b, between)
    type(corner_t), intent(in) :: a, b
    real(dp), intent(in) :: between !! rad

    width_of = abs(between) + (a%angle + b%angle)/2
  end function width_of

  !> Whether a corner is hollow, more than a straight face is.
  pure logical function is_hollow(corner)
    type(corner_t), intent(in) :: corner

    is_hollow = corner%angle > pi + flat
  end function is_hollow

  !> Whether edges of corners a and b lie on each other, or may in the step.
  pure logical function fits_on(a, b, between, tilt)
    type(corner_t), intent(in) :: a, b
    real(dp), intent(in) :: between, tilt !! rad
    real(dp) :: width

    width = width_of(a, b, between)
    fits_on = width >= pi - parallel .and. width <= pi + tilt
  end function fits_on

  !> How two convex corners meet. Those that cannot meet tip to tip may meet each other's sides.
  !>
  !> Of two nearly parallel edges the one that reaches farther out bounds the region that is closed to a tip; the line of the other
  !> lies in it, and its vertex is aside. Where turning in the step may change which one that is, each has an encounter: the tip is
  !> in the region if it is behind the lines of any of them.
  pure function meet_convex(a, b, between, tilt, bends) result(meeting)
    type(corner_t), intent(in) :: a, b
    real(dp), intent(in) :: between, tilt !! rad
    logical, intent(in) :: bends !! the joint at which they lie flat on each other
    type(encounters_t) :: meeting
    logical :: upon(2, 2)   ! (vertex, side) which vertices have the entrance line on either side, nearly parallel ones both
    logical :: bounds(2, 2) ! likewise, those by whose edge the region ends, as far as they turn in the step
    real(dp) :: turning, width
    integer :: k

    width = width_of(a, b, between)
    if (width > pi + tilt) then
      meeting%beside = .true.
      return
    end if
    turning = tilt - parallel
    bounds = on_lines(a, b, between, merge(most_bent, turned + turning, bends))
    if (width >= pi - parallel) then
      upon = on_lines(a, b, between, merge(most_bent, parallel, bends))
      meeting%n = 1
      meeting%flat = .true.
      meeting%encounter(1)%stands_for_both = .true.
      meeting%encounter(1)%line(1) = line_of([a%vertex, b%vertex, a%vertex, b%vertex], [b%vertex, a%vertex, b%before, a%before], &
                                             reshape(upon, [4]), reshape(bounds, [4]))
    else
      call add_tips(a, b, on_lines(a, b, between, parallel), bounds, meeting)
      if (turning > turned) then
        do k = -1, 1, 2
          upon = on_lines(a, b, between + k*turning, 0.0_dp)
          call add_tips(a, b, upon, upon, meeting)
        end do
      end if
    end if
  end function meet_convex

  !> Which vertices have the entrance line on either side, if corner b is turned by `between` from the direction in which it faces
  !> corner a. The result has the indices (vertex of a or b, line of the edges that begin there or end there).
  pure function on_lines(a, b, between, same) result(upon)
    type(corner_t), intent(in) :: a, b
    real(dp), intent(in) :: between !! rad
    real(dp), intent(in) :: same    !! angle up to which edges are parallel, and either vertex has the line, rad
    logical :: upon(2, 2)
    real(dp) :: half

    half = (a%angle - b%angle)/2
    upon(:, 1) = [between >= half - same, between <= half + same]
    upon(:, 2) = [between <= -half + same, between >= -half - same]
  end function on_lines

  !> Adds an encounter of two corners tip to tip, with two entrance lines.
  pure subroutine add_tips(a, b, upon, bounds, meeting)
    type(corner_t), intent(in) :: a, b
    logical, intent(in) :: upon(2, 2), bounds(2, 2) !! (vertex of a or b, line), see meet_convex
    type(encounters_t), intent(inout) :: meeting

    meeting%n = meeting%n + 1
    associate (encounter => meeting%encounter(meeting%n))
      encounter%n_lines = 2
      encounter%line(1) = line_of([a%vertex, b%vertex], [b%vertex, a%vertex], upon(:, 1), bounds(:, 1))
      encounter%line(2) = line_of([a%vertex, b%vertex], [b%before, a%before], upon(:, 2), bounds(:, 2))
    end associate
  end subroutine add_tips

  !> How corner a meets the hollow corner b: at either edge, or beside it.
  pure function meet_hollow(a, b, between, tilt) result(meeting)
    type(corner_t), intent(in) :: a, b
    real(dp), intent(in) :: between, tilt !! rad
    type(encounters_t) :: meeting

    if (between + a%angle/2 > pi - b%angle/2 + tilt) then
      meeting%beside(1) = .true.
    else
      call add_edge(a%vertex, b%vertex, meeting)
      call add_edge(a%vertex, b%before, meeting)
    end if
  end function meet_hollow

  !> A contact of a vertex at an edge, or at one of some in a line.
  pure function encounter_of_edge(vertex, edge) result(encounter)
    integer, intent(in) :: vertex, edge(:)
    type(encounter_t) :: encounter

    encounter%line(1) = line_of(spread(vertex, 1, size(edge)), edge, spread(.true., 1, size(edge)))
  end function encounter_of_edge

  !> Adds a contact of a vertex at an edge.
  pure subroutine add_edge(vertex, edge, meeting)
    integer, intent(in) :: vertex, edge
    type(encounters_t), intent(inout) :: meeting

    call add_line([vertex], [edge], meeting)
  end subroutine add_edge

  !> Adds a contact with one entrance line.
  pure subroutine add_line(vertex, edge, meeting)
    integer, intent(in) :: vertex(:), edge(:)
    type(encounters_t), intent(inout) :: meeting

    meeting%n = meeting%n + 1
    meeting%encounter(meeting%n)%line(1) = line_of(vertex, edge, spread(.true., 1, size(vertex)))
  end subroutine add_line

  !> An entrance line of some of the pairs.
  pure function line_of(vertex, edge, of_it, bounds) result(line)
    integer, intent(in) :: vertex(:), edge(:)
    logical, intent(in) :: of_it(:)
    logical, intent(in), optional :: bounds(:)
    type(entrance_pairs_t) :: line
    integer :: k

    do k = 1, size(vertex)
      if (.not. of_it(k)) cycle
      line%n = line%n + 1
      line%vertex(line%n) = vertex(k)
      line%edge(line%n) = edge(k)
      if (present(bounds)) line%aside(line%n) = .not. bounds(k)
    end do
  end function line_of

end module scree_corner_meeting
