!> Contacts of small steps: where pieces that overlap meet, as rows in an order of colours, and what the points hand on.
!>
!> A row is a vertex of one body at an edge of another, pushing across the edge and rubbing along it. There is no margin: pieces
!> that are apart have no rows, as rows for what is near but apart would keep corners of flush blocks from passing each other.
!> Rows of one colour have no body in common that moves, so they may be worked on at once; colours follow from the order of
!> the pairs.
module scree_contact_rows
  use scree_bodies, only: bodies_t, pair_memory_t, point_memory_t
  use scree_contacts, only: contact_law_t, entrance_t, outlines_t
  use scree_entrance_block, only: find_leading_line, meet, meeting_t
  use scree_joint_rules, only: friction_of, joints_follow_stress, joints_wear, weaker_joint
  use scree_kinds, only: dp, i8
  implicit none
  private
  public :: bond_reach, edge_below, in_frame, keep_impulses, last_colour, look_for_contacts, make_rows, parting_speed, &
            row_point_t, row_t, rows_t

  !> Gap of bonded faces at which their bond is lost, over the size of a body.
  real(dp), parameter :: bond_reach = 0.01_dp
  !> Steps in a row in which all points of a bond are at their limits before it is lost: a single sweep settles over some steps.
  integer, parameter :: steps_to_part = 4
  real(dp), parameter :: at_limit = 1 - 1e-9_dp  !! fraction of a limit from which on it is reached
  real(dp), parameter :: like = 0.9_dp           !! cosine of the angle between normals of a point that is said to go on
  integer, parameter :: last_colour = 63         !! whose rows may have bodies in common

  !> A point at which two bodies meet. Arms have components along its normal and along its edge.
  type :: row_point_t
    integer :: slot = 0                  !! of the memory of the pair
    real(dp) :: normal(2) = 0.0_dp       !! from a to b; a quarter turn on from it lies the direction along the edge
    real(dp) :: arm_a(2) = 0.0_dp        !! (across, along) from the centroid, length
    real(dp) :: arm_b(2) = 0.0_dp
    real(dp) :: gap = 0.0_dp             !! length
    real(dp) :: mass_across = 0.0_dp     !! that the point sees, mass/length
    real(dp) :: mass_along = 0.0_dp
    real(dp) :: push = 0.0_dp            !! impulses, force time per unit thickness
    real(dp) :: rub = 0.0_dp
    real(dp) :: held = 0.0_dp            !! slip that friction holds, length
    real(dp) :: friction = 0.0_dp        !! tangent of the friction angle
    real(dp) :: restitution = 0.0_dp     !! of an impact
    real(dp) :: cohesion = 0.0_dp        !! impulses that the bond bears
    real(dp) :: strength = 0.0_dp
    real(dp) :: came = 0.0_dp            !! speed at which the sides of a new point came together, below 0; length/time
    real(dp) :: slid = 0.0_dp            !! in this step, length
  end type row_point_t

  !> The one or two points at which a pair of pieces meets.
  type :: row_t
    integer :: pair = 0
    integer :: a = 0, b = 0              !! bodies
    integer :: n = 0                     !! points
    logical :: bonded = .false.
    type(row_point_t) :: point(2)
  end type row_t

  !> Rows in the order of their colours.
  type :: rows_t
    integer :: n = 0
    integer :: n_colours = 0
    integer :: first(0:last_colour + 1) = 1 !! colour c has the rows first(c):first(c+1)-1
    type(row_t), allocatable :: row(:)
    integer, allocatable :: pair(:)      !! (n) pairs that touch, in the order of the pairs
    integer, allocatable :: colour(:)    !! (n) of these
    integer, allocatable :: place(:)     !! (n) of their rows
    integer(i8), allocatable :: taken(:) !! (bodies) colours that each has, as bits
  contains
    procedure :: any_bounces
  end type rows_t

contains

  !> Looks which pairs overlap, or are bonded and still near. A pair that is apart forgets, and is looked at again when the bodies
  !> may have come together.
  subroutine look_for_contacts(bodies)
    type(bodies_t), intent(inout) :: bodies

    call look_at_pairs(bodies%near%n, bodies%n_pieces, bodies%near%piece, bodies%body, bodies%size, bodies%first, bodies%at, &
                       bodies%normal, bodies%face, bodies%near%moved, bodies%near%edge, bodies%near%vertex, &
                       bodies%near%apart_until, bodies%near%memory)
  end subroutine look_for_contacts

  !> `look_for_contacts` in arrays as `bodies_t` and `near_t` have them, without their descriptors.
  subroutine look_at_pairs(n, n_pieces, piece, body, size_of, first, at, normal, face, moved, edge, vertex, apart_until, memory)
    integer, intent(in) :: n, n_pieces
    integer, intent(in) :: piece(2, n), body(n_pieces), first(n_pieces + 1)
    real(dp), intent(in) :: size_of(*), at(2, *), normal(2, *), moved
    logical, intent(in) :: face(*)
    integer, intent(inout) :: edge(n), vertex(n)
    real(dp), intent(inout) :: apart_until(n)
    type(pair_memory_t), intent(inout) :: memory(n)
    real(dp) :: far, gap
    integer :: from_a, from_b, n_a, n_b, p

    !$omp do schedule(static)
    do p = 1, n
      if (moved < apart_until(p)) cycle
      from_a = first(piece(1, p))
      from_b = first(piece(2, p))
      n_a = first(piece(1, p) + 1) - from_a
      n_b = first(piece(2, p) + 1) - from_b
      far = reach_of(memory(p), size_of(body(piece(2, p))))
      call find_leading_line(n_a, at(1, from_a), normal(1, from_a), face(from_a), n_b, at(1, from_b), normal(1, from_b), &
                             face(from_b), far, edge(p), vertex(p), gap)
      if (gap < far) then
        memory(p)%touches = .true.
      else
        apart_until(p) = moved + 0.5_dp*(gap - far)
        if (memory(p)%touches) memory(p) = pair_memory_t()
      end if
    end do
    !$omp end do
  end subroutine look_at_pairs

  !> Gap below which a pair has a row.
  pure real(dp) function reach_of(memory, size_of_b) result(reach)
    type(pair_memory_t), intent(in) :: memory
    real(dp), intent(in) :: size_of_b    !! length

    reach = 0.0_dp
    if (memory%point(1)%bond > 0 .or. memory%point(2)%bond > 0) reach = bond_reach*size_of_b
  end function reach_of

  !> Colours the pairs that touch in their order, and gives each a place among the rows.
  subroutine colour_pairs(bodies, rows)
    type(bodies_t), intent(in) :: bodies
    type(rows_t), intent(inout) :: rows
    integer :: a, b, c, filled(0:last_colour), i, number(0:last_colour), p
    integer(i8) :: own

    if (.not. allocated(rows%taken)) allocate (rows%taken(bodies%n), rows%pair(0))
    if (size(rows%pair) < bodies%near%n) then
      if (allocated(rows%place)) deallocate (rows%place, rows%colour)
      deallocate (rows%pair)
      associate (room => size(bodies%near%edge))
        allocate (rows%pair(room), rows%place(room), rows%colour(room))
      end associate
    end if
    rows%taken = 0_i8
    number = 0
    rows%n = 0
    do p = 1, bodies%near%n
      if (.not. bodies%near%memory(p)%touches) cycle
      a = bodies%body(bodies%near%piece(1, p))
      b = bodies%body(bodies%near%piece(2, p))
      own = 0_i8
      if (bodies%moves(a)) own = rows%taken(a)
      if (bodies%moves(b)) own = ior(own, rows%taken(b))
      c = min(last_colour, trailz(not(own)))
      rows%n = rows%n + 1
      rows%pair(rows%n) = p
      rows%colour(rows%n) = c
      number(c) = number(c) + 1
      if (c == last_colour) cycle
      rows%taken(a) = ibset(rows%taken(a), c)
      rows%taken(b) = ibset(rows%taken(b), c)
    end do
    rows%n_colours = 0
    rows%first(0) = 1
    do c = 0, last_colour
      rows%first(c + 1) = rows%first(c) + number(c)
      if (number(c) > 0) rows%n_colours = c + 1
    end do
    filled = rows%first(:last_colour)
    do i = 1, rows%n
      rows%place(i) = filled(rows%colour(i))
      filled(rows%colour(i)) = filled(rows%colour(i)) + 1
    end do
    if (.not. allocated(rows%row)) allocate (rows%row(0))
    if (size(rows%row) < rows%n) then
      deallocate (rows%row)
      allocate (rows%row(rows%n + rows%n/4 + 16))
    end if
  end subroutine colour_pairs

  !> Makes the rows of a step of size h from the pairs that touch.
  subroutine make_rows(bodies, law, outlines, h, rows)
    type(bodies_t), intent(inout) :: bodies
    type(contact_law_t), intent(in) :: law
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: h            !! time
    type(rows_t), intent(inout) :: rows
    logical :: changes                   ! friction does, with the way and the force of a point
    integer :: i

    changes = joints_wear(law) .or. joints_follow_stress(law)
    !$omp single
    call colour_pairs(bodies, rows)
    !$omp end single
    !$omp do schedule(static)
    do i = 1, rows%n
      call make_row(bodies, law, changes, outlines, h, rows%pair(i), rows%row(rows%place(i)))
    end do
    !$omp end do
  end subroutine make_rows

  !> Makes the row of a pair.
  subroutine make_row(bodies, law, friction_changes, outlines, h, p, row)
    type(bodies_t), intent(inout) :: bodies
    type(contact_law_t), intent(in) :: law
    logical, intent(in) :: friction_changes
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: h            !! time
    integer, intent(in) :: p             !! pair
    type(row_t), intent(inout) :: row
    type(meeting_t) :: meeting
    type(point_memory_t) :: before(2)
    real(dp) :: arm(2), far, iia, iib, masses
    integer :: a, b, edge(2), from, from_a, from_b, i, vertex(2)

    a = bodies%near%piece(1, p)
    b = bodies%near%piece(2, p)
    from_a = bodies%first(a)
    from_b = bodies%first(b)
    row%pair = p
    row%a = bodies%body(a)
    row%b = bodies%body(b)
    far = reach_of(bodies%near%memory(p), bodies%size(row%b))
    row%bonded = far > 0
    call meet(bodies%first(a + 1) - from_a, bodies%at(1, from_a), bodies%normal(1, from_a), bodies%face(from_a), &
              bodies%first(b + 1) - from_b, bodies%at(1, from_b), bodies%normal(1, from_b), bodies%face(from_b), &
              far, bodies%near%edge(p), bodies%near%vertex(p), meeting)
    row%n = meeting%n
    before = bodies%near%memory(p)%point
    bodies%near%memory(p)%point%vertex = 0
    bodies%near%memory(p)%point%bond = 0.0_dp
    masses = bodies%inverse_mass(row%a) + bodies%inverse_mass(row%b)
    iia = bodies%inverse_inertia(row%a)
    iib = bodies%inverse_inertia(row%b)
    do i = 1, meeting%n
      vertex(i) = bodies%edge(corner(meeting%vertex(i)))
      edge(i) = bodies%edge(corner(meeting%edge(i)))
    end do
    do i = 1, meeting%n
      associate (point => row%point(i), slot => meeting%slot(i), memory => bodies%near%memory(p)%point(meeting%slot(i)))
        point%slot = slot
        point%normal = meeting%normal(:, i)
        point%gap = meeting%gap(i)
        arm(1) = meeting%position(1, i) - bodies%place(1, row%a)
        arm(2) = meeting%position(2, i) - bodies%place(2, row%a)
        point%arm_a = in_frame(arm, point%normal)
        arm(1) = meeting%position(1, i) - bodies%place(1, row%b)
        arm(2) = meeting%position(2, i) - bodies%place(2, row%b)
        point%arm_b = in_frame(arm, point%normal)
        point%mass_across = 1/(masses + iia*point%arm_a(2)**2 + iib*point%arm_b(2)**2)
        point%mass_along = 1/(masses + iia*point%arm_a(1)**2 + iib*point%arm_b(1)**2)
        from = slot_before(i)
        point%came = 0.0_dp
        if (from > 0) then
          memory = before(from)
        else
          memory = point_memory_t()
          point%came = parting_speed(row%a, row%b, point, bodies)
        end if
        if (size(law%joint) > 1) then
          if (from /= slot .or. before(slot)%vertex /= vertex(i) .or. before(slot)%edge /= edge(i)) &
            memory%joint = joint_at(i)
        end if
        memory%vertex = vertex(i)
        memory%edge = edge(i)
        memory%normal = point%normal
        point%push = memory%push
        point%rub = memory%rub
        point%held = memory%held
        point%slid = 0.0_dp
        point%friction = law%joint(memory%joint)%friction
        if (friction_changes) point%friction = friction_at(memory)
        point%restitution = max(0.0_dp, law%joint(memory%joint)%restitution)
        point%cohesion = law%joint(memory%joint)%cohesion*memory%bond*h
        point%strength = law%joint(memory%joint)%strength*memory%bond*h
      end associate
    end do

  contains

    !> Corner that a number of the meeting stands for.
    pure integer function corner(number)
      integer, intent(in) :: number

      corner = from_a - 1 + number
      if (corner >= bodies%first(a + 1)) corner = from_b - 1 + number - (bodies%first(a + 1) - from_a)
    end function corner

    !> Which memory a point goes on from: that of its vertex, or that of the point at the same end where that vertex is gone.
    pure integer function slot_before(i) result(from)
      integer, intent(in) :: i

      associate (slot => meeting%slot(i))
        from = slot
        if (before(slot)%vertex == vertex(i)) return
        from = 3 - slot
        if (before(from)%vertex == vertex(i)) return
        from = 0
        if (before(slot)%vertex == 0) return
        if (dot_product(before(slot)%normal, row%point(i)%normal) <= like) return
        if (meeting%n > 1) then
          if (before(slot)%vertex == vertex(3 - i)) return
        end if
        from = slot
      end associate
    end function slot_before

    !> Tangent of the friction angle of a point.
    pure real(dp) function friction_at(memory)
      type(point_memory_t), intent(in) :: memory
      type(entrance_t) :: entrance

      entrance%joint = memory%joint
      entrance%memory%wear = memory%slid
      entrance%memory%length = memory%bond
      entrance%memory%bonded = memory%bond > 0
      entrance%memory%pressing = memory%push/h
      friction_at = friction_of(law, entrance)
    end function friction_at

    !> Joint material of a point: the weaker one of those of the edge at its foot and of the face that lies on that.
    pure integer function joint_at(i)
      integer, intent(in) :: i

      associate (below => edge_below(bodies, outlines, corner(meeting%edge(i)), meeting%position(:, i)))
        joint_at = weaker_joint(law, outlines%joint(below), outlines%joint(vertex(i)))
      end associate
    end function joint_at

  end subroutine make_row

  !> Components of a vector along a normal and a quarter turn on from it.
  pure function in_frame(vector, normal) result(components)
    real(dp), intent(in) :: vector(2), normal(2)
    real(dp) :: components(2)

    components(1) = normal(1)*vector(1) + normal(2)*vector(2)
    components(2) = normal(1)*vector(2) - normal(2)*vector(1)
  end function in_frame

  !> Speed at which the sides of a point part.
  pure real(dp) function parting_speed(a, b, point, bodies) result(speed)
    integer, intent(in) :: a, b          !! its bodies
    type(row_point_t), intent(in) :: point
    type(bodies_t), intent(in) :: bodies

    speed = dot_product(point%normal, bodies%velocity(:, b) - bodies%velocity(:, a)) &
            - bodies%spin(b)*point%arm_b(2) + bodies%spin(a)*point%arm_a(2)
  end function parting_speed

  !> Edge of the outlines below a position, among those that an edge of a piece spans.
  pure integer function edge_below(bodies, outlines, corner, position) result(edge)
    type(bodies_t), intent(in) :: bodies
    type(outlines_t), intent(in) :: outlines
    integer, intent(in) :: corner        !! where the edge of the piece begins
    real(dp), intent(in) :: position(2)  !! length
    real(dp) :: along(2), left
    integer :: beyond

    edge = bodies%edge(corner)
    along = [-bodies%normal(2, corner), bodies%normal(1, corner)]
    left = dot_product(along, position - bodies%at(:, corner))
    do
      left = left - bodies%length(edge)
      beyond = outlines%next(edge)
      if (left <= 0 .or. outlines%begins_side(beyond)) return
      edge = beyond
    end do
  end function edge_below

  !> Keeps impulses, slips and bonds of the points for the next step. Bonds are lost together where all have been at their limits
  !> for some steps.
  subroutine keep_impulses(rows, bodies)
    type(rows_t), intent(in) :: rows
    type(bodies_t), intent(inout) :: bodies
    integer :: i, k

    !$omp do schedule(static)
    do i = 1, rows%n
      associate (row => rows%row(i), memory => bodies%near%memory(rows%row(i)%pair))
        do k = 1, row%n
          associate (point => row%point(k), own => memory%point(row%point(k)%slot))
            own%push = point%push
            own%rub = point%rub
            own%held = point%held
            own%slid = own%slid + point%slid
            own%slides = point%slid > 0
            own%gap = point%gap
          end associate
        end do
        if (row%bonded) then
          memory%strained = merge(memory%strained + 1, 0, is_strained(row%point(:row%n)))
          if (memory%strained >= steps_to_part) memory%point%bond = 0.0_dp
        end if
      end associate
    end do
    !$omp end do
  end subroutine keep_impulses

  !> Whether any point that is new in the step comes together fast enough to bounce.
  pure logical function any_bounces(self, least_speed)
    class(rows_t), intent(in) :: self
    real(dp), intent(in) :: least_speed        !! slower ones do not bounce, length/time
    integer :: i

    any_bounces = .false.
    do i = 1, self%n
      associate (point => self%row(i)%point(:self%row(i)%n))
        any_bounces = any(point%restitution > 0 .and. point%came <= -least_speed)
      end associate
      if (any_bounces) return
    end do
  end function any_bounces

  !> Whether all points of a bond are at its limit in tension, or all at that along the faces. Where that
  !> is zero, as of a joint without cohesion that is pulled, they slide and it holds.
  pure logical function is_strained(point)
    type(row_point_t), intent(in) :: point(:)
    real(dp) :: limit(size(point))

    limit = point%friction*max(0.0_dp, point%push) + point%cohesion
    is_strained = all(point%push <= -at_limit*point%strength) .or. all(limit > 0 .and. abs(point%rub) >= at_limit*limit)
  end function is_strained

end module scree_contact_rows
