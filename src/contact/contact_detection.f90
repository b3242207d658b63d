!> Who may touch in a step (Shi's df04, df05, df06).
!>
!> A search in a grid lists vertices near edges, with room to move; it is repeated only when a vertex may leave its room.
!> Of what it lists, every step makes contacts, at distances that the motion of the step may close:
!>
!> - a vertex over an edge that its corner fits on,
!> - two vertices of convex corners: the one cannot enter the other but across both of two entrance lines. The region that
!>   is closed to the relative position of the vertices is the sum of the one corner and the other one turned round; the
!>   entrance lines are its sides. Where that is a half plane, edges are parallel and one line is enough.
!> - a convex corner in a concave one: a contact with either edge.
!>
!> A contact is the same as one of the step before where vertex and edge are.
module scree_contact_detection
  use scree_body_overlap, only: body_overlap_t, entered_by, overlap_of_bodies, still_outside
  use scree_contact_geometry, only: gap_of
  use scree_contact_pairs, only: drop_repeats, entrance_of_pair, list_entrances, put_pairs
  use scree_contact_search, only: edge_lengths, find_nearby, most_turning
  use scree_contact_try, only: contact_try_t
  use scree_contacts, only: contact_memory_t, contact_search_t, contact_t, entrance_t, outlines_t, parallel, state_locked, &
      state_open, state_sliding
  use scree_kinds, only: dp
  implicit none
  private
  public :: find_contacts

  real(dp), parameter :: pi = acos(-1.0_dp)
  real(dp), parameter :: nearly = 0.3_dp*parallel !! edges that differ by less: those at the more upright corner act (Shi: 0.3 h1)
  real(dp), parameter :: no_corner = 1e-9_dp      !! an angle below is that of the end of a crack, a whole turn
  real(dp), parameter :: flat = 1e-3_dp           !! a corner that is concave by less is none
  real(dp), parameter :: deepest = 0.05_dp        !! of the edges about, beyond whose ends their line is looked at for overlaps
  real(dp), parameter :: at_rest = 1e-3_dp          !! of the edges about, that is near at rest
  real(dp), parameter :: beyond = 1e-3_dp         !! of an edge, that a contact with it lasts past its end

  !> Corner at a vertex, seen from inside: from its edge counter-clockwise to the one before.
  type :: corner_t
    real(dp) :: from = 0.0_dp   !! direction of its edge, rad
    real(dp) :: angle = 0.0_dp  !! rad, up to a whole turn
  end type corner_t

contains

  !> Contacts of a step that begins with the vertices at `position`, with what those before remember.
  subroutine find_contacts(outlines, position, predicted, self_contact, memory, search, try)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)       !! (2, n_vertices) of the elements, length
    real(dp), intent(in) :: predicted(:, :)      !! (2, n) displacement of the vertices of the outlines, by their velocity, length
    logical, intent(in) :: self_contact          !! a body may touch itself
    type(contact_memory_t), intent(in) :: memory
    type(contact_search_t), intent(inout) :: search
    type(contact_try_t), intent(inout) :: try    !! with law, margin and swing; gets contacts, pairs, and where they were looked for
    type(contact_t), allocatable :: found(:)
    real(dp) :: local(size(outlines%start)), near(size(outlines%start)), size_of_edge(size(outlines%start))
    real(dp) :: turning(size(outlines%start)) !! of the edges, then of the corners in the step, rad
    real(dp) :: pressed(size(outlines%first) - 1) !! largest overlap of the springs of each block after the last step, length
    type(corner_t) :: corner(size(outlines%start))
    integer, allocatable :: nearby(:, :), old(:)
    real(dp), allocatable :: key(:)
    integer :: i, j, k, n_found
    real(dp) :: distance_start, distance_finish

    size_of_edge = edge_lengths(outlines, position)
    local = min(size_of_edge, size_of_edge(outlines%previous))
    turning = min(most_turning, 1.2_dp*norm2(predicted(:, outlines%next) - predicted, 1)/size_of_edge + try%swing)
    turning = max(turning, turning(outlines%previous))
    if (try%law%by_name) turning = 0.0_dp
    call find_nearby(outlines, position, reach_of(local), self_contact, search, nearby)
    nearby = reshape([nearby, memory%inside], [2, size(nearby, 2) + size(memory%inside, 2)])
    do k = 1, size(nearby, 2) ! a large block takes the measure of a small one beside it
      i = nearby(1, k)
      j = nearby(2, k)
      local([j, outlines%next(j)]) = min(local([j, outlines%next(j)]), local(i))
      local(i) = min(local(i), size_of_edge(j))
    end do
    near = reach_of(local)
    call list_entrances(memory%contact, size(outlines%start), old, key)
    pressed = 0.0_dp
    do k = 1, size(memory%contact)
      associate (contact => memory%contact(k), entrance => memory%contact(k)%entrance(memory%contact(k)%active))
        pressed(outlines%block(entrance%vertex)) = max(pressed(outlines%block(entrance%vertex)), contact%pressed)
        pressed(outlines%block(entrance%edge)) = max(pressed(outlines%block(entrance%edge)), contact%pressed)
      end associate
    end do
    do i = 1, size(outlines%start)
      corner(i) = corner_of(i)
    end do

    allocate (found(size(nearby, 2) + 8))
    n_found = 0
    do k = 1, size(nearby, 2)
      i = nearby(1, k)
      j = nearby(2, k)
      associate (x1 => position(:, outlines%start(i)), x2 => position(:, outlines%start(j)), x3 => position(:, outlines%finish(j)))
        distance_start = norm2(x1 - x2)
        distance_finish = norm2(x1 - x3)
        if (distance_start <= near(i) + near(j)) then
          if (i < j) call meet_corners(i, j)
          cycle
        end if
        if (distance_finish <= near(i) + near(outlines%next(j))) cycle
      end associate
      call meet_edge(i, j)
    end do
    do k = 1, size(memory%inside, 2)
      if (is_inside(memory%inside(1, k), memory%inside(2, k))) call add(memory%inside(1:1, k), memory%inside(2:2, k))
    end do
    call drop_repeats(size(outlines%start), found, n_found)
    call put_pairs(outlines, memory%pair, found(:n_found), try%pair)
    try%contact = found(:n_found)
    try%inside = pairs_inside(found(:n_found))
    try%near = near
    try%local = local
    try%turning = turning
    try%nearby = nearby

  contains

    !> How far vertices may move in the step, with the length of the edges about them.
    !>
    !> Beyond the end of an edge its line is crossed as far as the overlap over the sine of the corner goes; a contact that is
    !> found or lost there would bring or take the energy of its spring. Corners that turn by less than `parallel` may.
    pure function reach_of(local) result(near)
      real(dp), intent(in) :: local(:)
      real(dp) :: near(size(local))

      near = 1.2_dp*norm2(predicted, 1) + min(try%margin, try%law%leap*local) + at_rest*local &
             + min(memory%pressed/sin(parallel), deepest*local)
      if (try%law%outside > 0) near = 0.5_dp*try%law%outside
    end function reach_of

    !> Corner at vertex i.
    pure type(corner_t) function corner_of(i)
      integer, intent(in) :: i
      integer :: before

      before = outlines%previous(i)
      associate (own => position(:, outlines%finish(i)) - position(:, outlines%start(i)), &
                 back => position(:, outlines%start(before)) - position(:, outlines%finish(before)))
        corner_of%from = atan2(own(2), own(1))
        corner_of%angle = modulo(atan2(back(2), back(1)) - corner_of%from, 2*pi)
      end associate
      if (corner_of%angle < no_corner) corner_of%angle = 2*pi
    end function corner_of

    !> Whether the corner at vertex i fits on edge j: both its edges lead away from it.
    pure logical function fits(i, j)
      integer, intent(in) :: i, j
      real(dp) :: lowest

      ! against the outer normal of the edge, at corner(j)%from - pi/2
      lowest = turn(corner(i)%from + corner(i)%angle/2 - corner(j)%from + pi/2)
      fits = abs(lowest) + corner(i)%angle/2 <= pi/2 + tilt(i, j)
    end function fits

    !> Angle by which two corners may be out of place and yet meet in the step.
    pure real(dp) function tilt(i, j)
      integer, intent(in) :: i, j

      tilt = parallel + turning(i) + turning(j)
    end function tilt

    !> Place of vertex i along edge j, from its beginning.
    pure real(dp) function along(i, j)
      integer, intent(in) :: i, j

      associate (x1 => position(:, outlines%start(i)), x2 => position(:, outlines%start(j)), x3 => position(:, outlines%finish(j)))
        along = dot_product(x1 - x2, x3 - x2)/size_of_edge(j)
      end associate
    end function along

    !> Gap of vertex i at the line of edge j.
    pure real(dp) function gap_at(i, j)
      integer, intent(in) :: i, j

      gap_at = gap_of(position(:, outlines%start(i)), position(:, outlines%start(j)), position(:, outlines%finish(j)))
    end function gap_at

    !> Contact of vertex i over edge j.
    subroutine meet_edge(i, j)
      integer, intent(in) :: i, j
      real(dp) :: at, gap

      at = along(i, j)
      if (at < 0 .or. at > size_of_edge(j)) return
      gap = gap_at(i, j)
      if (gap > near(i) + max(near(j), near(outlines%next(j)))) return
      if (try%law%outside > 0 .and. gap < -try%law%deepest) return
      if (fits(i, j)) call add([i], [j])
    end subroutine meet_edge

    !> Contacts of two corners that are near each other.
    subroutine meet_corners(i, j)
      integer, intent(in) :: i, j
      real(dp) :: between

      between = turn(corner(i)%from + corner(i)%angle/2 + pi - corner(j)%from - corner(j)%angle/2)
      if (try%law%by_name) then
        call meet_by_name(i, j, between)
      else if (max(corner(i)%angle, corner(j)%angle) <= pi + flat) then
        call meet_convex(i, j, between)
      else if (corner(j)%angle > pi + flat .and. corner(i)%angle <= pi + parallel) then
        call meet_hollow(i, j, abs(between), tilt(i, j))
      else
        call meet_hollow(j, i, abs(between), tilt(i, j))
      end if
    end subroutine meet_corners

    !> Contacts of two convex corners, one turned from the other by the angle between them.
    subroutine meet_convex(i, j, between)
      integer, intent(in) :: i, j
      real(dp), intent(in) :: between !! rad
      logical :: low(2), high(2)      !! which vertices have the entrance line on either side
      real(dp) :: width

      associate (a => corner(i)%angle, b => corner(j)%angle, before_i => outlines%previous(i), before_j => outlines%previous(j))
        width = abs(between) + (a + b)/2
        low = [-b/2 <= between - a/2 + parallel, between - a/2 <= -b/2 + parallel]
        high = [b/2 >= between + a/2 - parallel, between + a/2 >= b/2 - parallel]
        if (width > pi + tilt(i, j)) then ! they cannot meet tip to tip, but beside it
          call meet_sides(i, j)
          call meet_sides(j, i)
        else if (width >= pi - parallel) then
          call add(pack([i, j, i, j], [low, high]), pack([j, i, before_j, before_i], [low, high]))
        else
          call add(pack([i, j], low), pack([j, i], low), pack([i, j], high), pack([before_j, before_i], high))
        end if
      end associate
    end subroutine meet_convex

    !> Contacts of the corner at vertex i with either edge of a concave one at vertex j.
    subroutine meet_hollow(i, j, between, tilt)
      integer, intent(in) :: i, j
      real(dp), intent(in) :: between, tilt !! rad

      if (between + corner(i)%angle/2 > pi - corner(j)%angle/2 + tilt) then
        call meet_sides(i, j)
      else
        call add([i], [j])
        call add([i], [outlines%previous(j)])
      end if
    end subroutine meet_hollow

    !> Contacts of vertex i over the edges at vertex j, of which the corner there says nothing.
    subroutine meet_sides(i, j)
      integer, intent(in) :: i, j

      associate (x1 => position(:, outlines%start(i)), after => outlines%next(j), before => outlines%previous(j))
        if (norm2(x1 - position(:, outlines%start(after))) > near(i) + near(after)) call meet_edge(i, j)
        if (norm2(x1 - position(:, outlines%start(before))) > near(i) + near(before)) call meet_edge(i, before)
      end associate
    end subroutine meet_sides

    !> Contacts of two corners by Shi's rules (df04, df05): the convex one with either edge of a concave one, as far as it fits
    !> on them; of parallel edges one or both; else the upright corner chooses between edges that are nearly parallel.
    subroutine meet_by_name(i, j, between)
      integer, intent(in) :: i, j
      real(dp), intent(in) :: between !! rad
      integer :: low(2), high(2), vertex, hollow
      real(dp) :: upright, width

      associate (a => corner(i)%angle, b => corner(j)%angle, before_i => outlines%previous(i), before_j => outlines%previous(j))
        width = abs(between) + (a + b)/2
        if (max(a, b) > pi + flat) then
          vertex = merge(i, j, a <= pi + flat)
          hollow = merge(j, i, a <= pi + flat)
          if (fits(vertex, hollow)) call add([vertex], [hollow])
          if (fits(vertex, outlines%previous(hollow))) call add([vertex], [outlines%previous(hollow)])
        else if (width > pi + tilt(i, j)) then
          return
        else if (width >= pi - parallel) then
          if ((a + b)/2 - between >= pi - parallel) call add([i, j], [before_j, i])
          if ((a + b)/2 + between >= pi - parallel) call add([j, i], [before_i, j])
        else
          upright = abs(sin(corner(j)%from + b/2)) - abs(sin(corner(i)%from + a/2))
          low = merge([i, j], [j, i], between - a/2 + b/2 >= merge(-nearly, nearly, upright >= 0))
          high = merge([j, before_i], [i, before_j], between + a/2 - b/2 >= merge(-nearly, nearly, upright <= 0))
          call add(low(:1), low(2:), high(:1), high(2:))
        end if
      end associate
    end subroutine meet_by_name

    !> Adds a contact with one line or two, each the best of some pairs of a vertex and an edge on that line.
    subroutine add(vertex, edge, other_vertex, other_edge)
      integer, intent(in) :: vertex(:), edge(:)
      integer, intent(in), optional :: other_vertex(:), other_edge(:)
      type(contact_t) :: new

      if (present(other_vertex)) new%n_entrances = 2
      if (try%law%by_name) then
        new%entrance(1) = named(vertex, edge)
        if (new%n_entrances == 2) new%entrance(2) = named(other_vertex, other_edge)
        if (new%n_entrances == 2) new%entrance%state = min(new%entrance%state, state_sliding)
      else
        new%entrance(1) = best(vertex, edge)
        if (new%n_entrances == 2) new%entrance(2) = best(other_vertex, other_edge)
      end if
      if (any(new%entrance(:new%n_entrances)%vertex == 0)) return ! within one element, which cannot touch itself
      if (new%n_entrances == 2) then
        if (new%entrance(1)%state /= state_open .neqv. new%entrance(2)%state /= state_open) then
          new%active = merge(1, 2, new%entrance(1)%state /= state_open)
        else
          new%active = merge(1, 2, gap_at(new%entrance(1)%vertex, new%entrance(1)%edge) >= gap_at(new%entrance(2)%vertex, &
              new%entrance(2)%edge))
        end if
      end if
      if (.not. (try%law%outside > 0 .or. entered(new%entrance(new%active)))) return
      if (.not. try%law%by_name) then
        call rest_inside(new%entrance(new%active))
        new%inherits = overlap_inherited(new, vertex, edge)
        if (present(other_vertex)) new%inherits = max(new%inherits, overlap_inherited(new, other_vertex, other_edge))
      end if
      if (n_found == size(found)) found = [found, found]
      n_found = n_found + 1
      found(n_found) = new
    end subroutine add

    !> Whether a vertex that rests behind an edge is still in its body, wherever along the edge.
    pure logical function is_inside(i, j)
      integer, intent(in) :: i, j
      type(body_overlap_t) :: overlap

      is_inside = gap_at(i, j) < -still_outside*min(local(i), size_of_edge(j))
      if (.not. is_inside) return
      call overlap_of_bodies(outlines, position, outlines%block(i), outlines%block(j), overlap)
      is_inside = any(overlap%corner%vertex == i)
    end function is_inside

    !> Whether the vertex of a line entered there, where it is behind it. It did where the line acted before; else the bodies
    !> tell. Its own body a vertex is in anyway.
    pure logical function entered(entrance)
      type(entrance_t), intent(in) :: entrance
      type(body_overlap_t) :: overlap
      integer :: before

      associate (i => entrance%vertex, j => entrance%edge)
        entered = gap_at(i, j) >= -still_outside*min(local(i), size_of_edge(j))
        if (entered) return
        before = entrance_before(i, j)
        if (before > 0) entered = memory%contact((before + 1)/2)%active == 2 - modulo(before, 2)
        if (entered .or. outlines%block(i) == outlines%block(j)) return
        call overlap_of_bodies(outlines, position, outlines%block(i), outlines%block(j), overlap)
        entered = entered_by(outlines, position, overlap, i, j)
      end associate
    end function entered

    !> Lets the spring of a line that is found inside rest there, so that it brings no energy; but as others of its blocks are
    !> pressed, it is from the beginning.
    pure subroutine rest_inside(entrance)
      type(entrance_t), intent(inout) :: entrance

      if (entrance%state /= state_open .or. entrance_before(entrance%vertex, entrance%edge) > 0) return
      entrance%rest = min(0.0_dp, gap_at(entrance%vertex, entrance%edge) &
                              + max(pressed(outlines%block(entrance%vertex)), pressed(outlines%block(entrance%edge))))
    end subroutine rest_inside

    !> Overlap of the spring of a contact before that had one of some pairs closed and was not made of the same pairs; below 0
    !> where there is none, 0 where the contact is found inside.
    pure real(dp) function overlap_inherited(new, vertex, edge) result(overlap)
      type(contact_t), intent(in) :: new
      integer, intent(in) :: vertex(:), edge(:)
      integer :: before, k

      overlap = merge(0.0_dp, -1.0_dp, new%entrance(new%active)%state == state_open &
                      .and. gap_at(new%entrance(new%active)%vertex, new%entrance(new%active)%edge) < 0)
      do k = 1, size(vertex)
        before = entrance_before(vertex(k), edge(k))
        if (before == 0) cycle
        associate (was => memory%contact((before + 1)/2))
          if (was%n_entrances == new%n_entrances .and. all(was%entrance(:was%n_entrances)%vertex == &
              new%entrance(:was%n_entrances)%vertex &
                                                   .and. was%entrance(:was%n_entrances)%edge == &
                                                       new%entrance(:was%n_entrances)%edge)) then
            overlap = -1.0_dp
          else if (was%entrance(2 - modulo(before, 2))%state /= state_open) then
            overlap = max(overlap, was%pressed)
          end if
        end associate
      end do
    end function overlap_inherited

    !> The pair of a contact before, best one that was closed, or else the one whose vertex lies best within its edge, with what
    !> the pairs remember.
    pure type(entrance_t) function best(vertex, edge)
      integer, intent(in) :: vertex(:), edge(:)
      real(dp) :: at, gap, inside, most, slip
      integer :: before, k, known

      most = -huge(most)
      known = 0
      slip = 0.0_dp
      do k = 1, size(vertex)
        if (outlines%element(vertex(k)) == outlines%element(edge(k))) cycle
        associate (length => size_of_edge(edge(k)))
          at = along(vertex(k), edge(k))
          inside = min(at, length - at)
          before = entrance_before(vertex(k), edge(k))
          if (before > 0) then
            associate (was => memory%contact((before + 1)/2)%entrance(2 - modulo(before, 2)))
              if (known == 0 .or. was%state /= state_open) then
                known = before
                slip = at - was%anchor*length
              end if
              if (inside >= -beyond*length) inside = merge(huge(inside), 0.5_dp*huge(inside), was%state /= state_open)
            end associate
          end if
          if (inside <= most) cycle
          most = inside
          best%vertex = vertex(k)
          best%edge = edge(k)
          best%anchor = at/length
        end associate
      end do
      if (known == 0) return
      associate (was => memory%contact((known + 1)/2)%entrance(2 - modulo(known, 2)))
        call recall(was, best)
        gap = gap_at(best%vertex, best%edge)
        if (best%state /= state_open) then
          best%anchor = best%anchor - slip/size_of_edge(best%edge)
          if (best%vertex /= was%vertex .or. best%edge /= was%edge) & ! the spring is pressed by as much as it was
            best%rest = min(0.0_dp, gap - min(0.0_dp, gap_at(was%vertex, was%edge) - was%rest))
        end if
        if (gap >= best%rest) best%rest = min(0.0_dp, gap) ! what has come out stays out
      end associate
    end function best

    !> The first pair where its vertex lies within its edge, else the last, with what the pairs remember; only the same pair, and
    !> locked, keeps its anchor (Shi: df05, df06).
    pure type(entrance_t) function named(vertex, edge)
      integer, intent(in) :: vertex(:), edge(:)
      real(dp) :: past
      integer :: before, k, known
      logical :: within

      known = 0
      within = .false.
      do k = 1, size(vertex)
        if (outlines%element(vertex(k)) == outlines%element(edge(k))) cycle
        before = entrance_before(vertex(k), edge(k))
        if (before > 0) known = before
        if (within) cycle
        named%vertex = vertex(k)
        named%edge = edge(k)
        associate (x1 => position(:, outlines%start(vertex(k))), x2 => position(:, outlines%start(edge(k))), &
                   x3 => position(:, outlines%finish(edge(k))))
          within = k == 1 .and. dot_product(x2 - x1, x3 - x1) <= 0
        end associate
      end do
      if (named%vertex == 0) return
      associate (length => size_of_edge(named%edge))
        past = length - along(named%vertex, named%edge)
        named%anchor = 1 - past*length/(length**2 + try%law%guard)
      end associate
      if (known == 0) return
      associate (was => memory%contact((known + 1)/2)%entrance(2 - modulo(known, 2)))
        call recall(was, named)
        if (was%state == state_locked .and. was%vertex == named%vertex) then
          named%anchor = was%anchor
        else if (was%state /= state_open .and. memory%contact((known + 1)/2)%n_entrances == 2) then
          named%state = state_locked
        end if
      end associate
    end function named

    !> Hands on what a line remembers but for its anchor.
    pure subroutine recall(was, entrance)
      type(entrance_t), intent(in) :: was
      type(entrance_t), intent(inout) :: entrance

      entrance%state = was%state
      entrance%rest = was%rest
      entrance%direction = was%direction
      entrance%multiplier = was%multiplier
      entrance%length = was%length
      entrance%bonded = was%bonded
      entrance%lagged_friction = was%lagged_friction
    end subroutine recall

    !> Number of the line of a pair in the contacts before, 2 k - 1 and 2 k those of contact k; 0 where there is none.
    pure integer function entrance_before(vertex, edge)
      integer, intent(in) :: vertex, edge

      entrance_before = entrance_of_pair(old, key, vertex, edge, size(outlines%start))
    end function entrance_before

  end subroutine find_contacts

  !> Pairs of a vertex and the edge that it is inside of and rests there.
  pure function pairs_inside(contact) result(pair)
    type(contact_t), intent(in) :: contact(:)
    integer, allocatable :: pair(:, :)
    integer :: i, k, m, n

    n = 0
    do i = 1, size(contact)
      n = n + count(contact(i)%entrance(:contact(i)%n_entrances)%rest < 0)
    end do
    allocate (pair(2, n))
    m = 0
    do i = 1, size(contact)
      do k = 1, contact(i)%n_entrances
        if (.not. contact(i)%entrance(k)%rest < 0) cycle
        m = m + 1
        pair(:, m) = [contact(i)%entrance(k)%vertex, contact(i)%entrance(k)%edge]
      end do
    end do
  end function pairs_inside

  !> An angle between -pi and pi.
  pure real(dp) function turn(angle)
    real(dp), intent(in) :: angle

    turn = modulo(angle + pi, 2*pi) - pi
  end function turn

end module scree_contact_detection
