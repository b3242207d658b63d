!> Contacts of small steps: where pieces that overlap meet, as rows in an order of colours, and what the points hand on.
!>
!> A row is a vertex of one body at an edge of another, pushing across the edge and rubbing along it. There is no margin: pieces
!> that are apart have no rows, as rows for what is near but apart would keep corners of flush blocks from passing each other.
!> Rows of one colour have no body in common that moves, so they may be worked on at once; colours follow from the order of
!> the pairs.
module scree_contact_rows
  use scree_bodies, only: bodies_t, pair_memory_t
  use scree_contacts, only: contact_law_t, entrance_t, outlines_t
  use scree_entrance_block, only: find_leading_line, meet, meeting_t
  use scree_joint_rules, only: friction_of, joints_follow_stress, joints_wear, weaker_joint
  use scree_kinds, only: dp, i8
  implicit none
  private
  public :: bond_reach, edge_below, keep_impulses, last_colour, look_for_contacts, make_rows, row_t, rows_t

  !> Gap of bonded faces at which their bond is lost, over the size of a body.
  real(dp), parameter :: bond_reach = 0.01_dp
  !> Steps in a row in which all points of a bond are at their limits before it is lost: a single sweep settles over some steps.
  integer, parameter :: steps_to_part = 4
  real(dp), parameter :: at_limit = 1 - 1e-9_dp  !! fraction of a limit from which on it is reached
  real(dp), parameter :: like = 0.9_dp           !! cosine of the angle between normals of a point that is said to go on
  integer, parameter :: last_colour = 63         !! whose rows may have bodies in common

  !> The one or two points at which a pair of pieces meets.
  type :: row_t
    integer :: pair = 0
    integer :: a = 0, b = 0              !! bodies
    integer :: n = 0                     !! points
    integer :: slot(2) = 0               !! of the memory of the pair
    logical :: bonded = .false.
    real(dp) :: arm_a(2, 2) = 0.0_dp     !! (xy, point) from the centroid, length
    real(dp) :: arm_b(2, 2) = 0.0_dp
    real(dp) :: normal(2, 2) = 0.0_dp    !! from a to b
    real(dp) :: gap(2) = 0.0_dp          !! length
    real(dp) :: mass_across(2) = 0.0_dp  !! that a point sees, mass/length
    real(dp) :: mass_along(2) = 0.0_dp
    real(dp) :: push(2) = 0.0_dp         !! impulses, force time per unit thickness
    real(dp) :: rub(2) = 0.0_dp
    real(dp) :: held(2) = 0.0_dp         !! slip that friction holds, length
    real(dp) :: friction(2) = 0.0_dp     !! tangent of the friction angle
    real(dp) :: restitution(2) = 0.0_dp  !! of an impact
    real(dp) :: cohesion(2) = 0.0_dp     !! impulses that the bond bears
    real(dp) :: strength(2) = 0.0_dp
    real(dp) :: came(2) = 0.0_dp         !! speed at which the sides of a new point came together, below 0; length/time
    real(dp) :: slid(2) = 0.0_dp         !! in this step, length
  end type row_t

  !> Rows in the order of their colours.
  type :: rows_t
    integer :: n = 0
    integer :: n_colours = 0
    integer :: first(0:last_colour + 1) = 1 !! colour c has the rows first(c):first(c+1)-1
    type(row_t), allocatable :: row(:)
    integer, allocatable :: place(:)     !! (pairs) of the row of a pair
    integer, allocatable :: colour(:)
    integer(i8), allocatable :: taken(:) !! (bodies) colours that each has, as bits
  end type rows_t

contains

  !> Looks which pairs overlap, or are bonded and still near. A pair that is apart forgets.
  subroutine look_for_contacts(bodies)
    type(bodies_t), intent(inout) :: bodies
    real(dp) :: far, gap
    integer :: a, b, from_a, from_b, p

    !$omp do schedule(static)
    do p = 1, bodies%near%n
      a = bodies%near%piece(1, p)
      b = bodies%near%piece(2, p)
      from_a = bodies%first(a)
      from_b = bodies%first(b)
      far = 0.0_dp
      if (any(bodies%near%memory(p)%bond > 0)) far = bond_reach*bodies%size(bodies%body(b))
      call find_leading_line(bodies%first(a + 1) - from_a, bodies%at(1, from_a), bodies%normal(1, from_a), bodies%face(from_a), &
                             bodies%first(b + 1) - from_b, bodies%at(1, from_b), bodies%normal(1, from_b), bodies%face(from_b), &
                             far, bodies%near%edge(p), bodies%near%vertex(p), gap)
      if (gap < far) then
        bodies%near%memory(p)%touches = .true.
      else if (bodies%near%memory(p)%touches) then
        bodies%near%memory(p) = pair_memory_t()
      end if
    end do
    !$omp end do
  end subroutine look_for_contacts

  !> Colours the pairs that touch in their order, and gives each a place among the rows.
  subroutine colour_pairs(bodies, rows)
    type(bodies_t), intent(in) :: bodies
    type(rows_t), intent(inout) :: rows
    integer :: a, b, c, filled(0:last_colour), number(0:last_colour), p
    integer(i8) :: own

    if (.not. allocated(rows%taken)) allocate (rows%taken(bodies%n))
    if (.not. allocated(rows%place)) allocate (rows%place(0), rows%colour(0))
    if (size(rows%place) < bodies%near%n) then
      deallocate (rows%place, rows%colour)
      allocate (rows%place(size(bodies%near%edge)), rows%colour(size(bodies%near%edge)))
    end if
    rows%taken = 0_i8
    number = 0
    do p = 1, bodies%near%n
      if (.not. bodies%near%memory(p)%touches) cycle
      a = bodies%body(bodies%near%piece(1, p))
      b = bodies%body(bodies%near%piece(2, p))
      own = 0_i8
      if (bodies%moves(a)) own = rows%taken(a)
      if (bodies%moves(b)) own = ior(own, rows%taken(b))
      c = min(last_colour, trailz(not(own)))
      rows%colour(p) = c
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
    do p = 1, bodies%near%n
      if (.not. bodies%near%memory(p)%touches) cycle
      rows%place(p) = filled(rows%colour(p))
      filled(rows%colour(p)) = filled(rows%colour(p)) + 1
    end do
    rows%n = rows%first(last_colour + 1) - 1
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
    integer :: p

    !$omp single
    call colour_pairs(bodies, rows)
    !$omp end single
    !$omp do schedule(static)
    do p = 1, bodies%near%n
      if (bodies%near%memory(p)%touches) call make_row(bodies, law, outlines, h, p, rows%row(rows%place(p)))
    end do
    !$omp end do
  end subroutine make_rows

  !> Makes the row of a pair.
  subroutine make_row(bodies, law, outlines, h, p, row)
    type(bodies_t), intent(inout) :: bodies
    type(contact_law_t), intent(in) :: law
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: h            !! time
    integer, intent(in) :: p             !! pair
    type(row_t), intent(inout) :: row
    type(meeting_t) :: meeting
    type(pair_memory_t) :: before
    real(dp) :: far, t(2)
    integer :: a, b, from_a, from_b, i, slot

    a = bodies%near%piece(1, p)
    b = bodies%near%piece(2, p)
    from_a = bodies%first(a)
    from_b = bodies%first(b)
    row%pair = p
    row%a = bodies%body(a)
    row%b = bodies%body(b)
    before = bodies%near%memory(p)
    row%bonded = any(before%bond > 0)
    far = 0.0_dp
    if (row%bonded) far = bond_reach*bodies%size(row%b)
    call meet(bodies%first(a + 1) - from_a, bodies%at(1, from_a), bodies%normal(1, from_a), bodies%face(from_a), &
              bodies%first(b + 1) - from_b, bodies%at(1, from_b), bodies%normal(1, from_b), bodies%face(from_b), &
              far, bodies%near%edge(p), bodies%near%vertex(p), meeting)
    row%n = meeting%n
    bodies%near%memory(p)%vertex = 0
    associate (memory => bodies%near%memory(p), ima => bodies%inverse_mass(row%a), imb => bodies%inverse_mass(row%b), &
               iia => bodies%inverse_inertia(row%a), iib => bodies%inverse_inertia(row%b))
      do i = 1, meeting%n
        slot = meeting%slot(i)
        row%slot(i) = slot
        row%normal(:, i) = meeting%normal(:, i)
        row%gap(i) = meeting%gap(i)
        row%arm_a(:, i) = meeting%position(:, i) - bodies%place(:, row%a)
        row%arm_b(:, i) = meeting%position(:, i) - bodies%place(:, row%b)
        t = [-row%normal(2, i), row%normal(1, i)]
        row%mass_across(i) = 1/(ima + imb + iia*cross(row%arm_a(:, i), row%normal(:, i))**2 &
                                + iib*cross(row%arm_b(:, i), row%normal(:, i))**2)
        row%mass_along(i) = 1/(ima + imb + iia*cross(row%arm_a(:, i), t)**2 + iib*cross(row%arm_b(:, i), t)**2)
        memory%vertex(slot) = bodies%edge(corner(meeting%vertex(i)))
        memory%normal(:, slot) = row%normal(:, i)
        call take_memory(i, slot)
        if (memory%edge(slot) /= bodies%edge(corner(meeting%edge(i))) .or. memory%vertex(slot) /= before%vertex(slot)) then
          memory%edge(slot) = bodies%edge(corner(meeting%edge(i)))
          if (size(law%joint) > 1) memory%joint(slot) = joint_at(i, slot)
        end if
        row%slid(i) = 0.0_dp
        row%friction(i) = friction_at(slot)
        row%restitution(i) = max(0.0_dp, law%joint(memory%joint(slot))%restitution)
        row%cohesion(i) = law%joint(memory%joint(slot))%cohesion*memory%bond(slot)*h
        row%strength(i) = law%joint(memory%joint(slot))%strength*memory%bond(slot)*h
      end do
    end associate

  contains

    !> Corner that a number of the meeting stands for.
    pure integer function corner(number)
      integer, intent(in) :: number

      corner = from_a - 1 + number
      if (corner >= bodies%first(a + 1)) corner = from_b - 1 + number - (bodies%first(a + 1) - from_a)
    end function corner

    !> Gives a point what its vertex remembers, or what the point at the same end does where that vertex is gone.
    subroutine take_memory(i, slot)
      integer, intent(in) :: i, slot
      integer :: from

      associate (memory => bodies%near%memory(p), own => bodies%near%memory(p)%vertex(slot))
        from = 0
        if (before%vertex(slot) == own) then
          from = slot
        else if (before%vertex(3 - slot) == own) then
          from = 3 - slot
        else if (before%vertex(slot) /= 0 .and. dot_product(before%normal(:, slot), row%normal(:, i)) > like) then
          from = slot
          if (meeting%n > 1) then
            if (before%vertex(slot) == bodies%edge(corner(meeting%vertex(3 - i)))) from = 0
          end if
        end if
        row%push(i) = 0.0_dp
        row%rub(i) = 0.0_dp
        row%held(i) = 0.0_dp
        row%came(i) = 0.0_dp
        memory%slid(slot) = 0.0_dp
        memory%bond(slot) = 0.0_dp
        if (from == 0) then
          row%came(i) = approach(i)
          return
        end if
        row%push(i) = before%push(from)
        row%rub(i) = before%rub(from)
        row%held(i) = before%held(from)
        memory%slid(slot) = before%slid(from)
        memory%bond(slot) = before%bond(from)
        memory%joint(slot) = before%joint(from)
      end associate
    end subroutine take_memory

    !> Speed at which the sides of a point part.
    pure real(dp) function approach(i)
      integer, intent(in) :: i

      associate (va => bodies%velocity(:, row%a), vb => bodies%velocity(:, row%b), wa => bodies%spin(row%a), &
                 wb => bodies%spin(row%b))
        approach = dot_product(row%normal(:, i), vb + wb*[-row%arm_b(2, i), row%arm_b(1, i)] &
                               - va - wa*[-row%arm_a(2, i), row%arm_a(1, i)])
      end associate
    end function approach

    !> Tangent of the friction angle of a point.
    pure real(dp) function friction_at(slot)
      integer, intent(in) :: slot
      type(entrance_t) :: entrance

      associate (memory => bodies%near%memory(p))
        if (.not. (joints_wear(law) .or. joints_follow_stress(law))) then
          friction_at = law%joint(memory%joint(slot))%friction
          return
        end if
        entrance%joint = memory%joint(slot)
        entrance%memory%wear = memory%slid(slot)
        entrance%memory%length = memory%bond(slot)
        entrance%memory%bonded = memory%bond(slot) > 0
        entrance%memory%pressing = memory%push(slot)/h
        friction_at = friction_of(law, entrance)
      end associate
    end function friction_at

    !> Joint material of a point: the weaker one of those of the edge at its foot and of the face that lies on that.
    pure integer function joint_at(i, slot)
      integer, intent(in) :: i, slot
      integer :: at_vertex, edge

      edge = edge_below(bodies, outlines, corner(meeting%edge(i)), meeting%position(:, i))
      at_vertex = bodies%near%memory(p)%vertex(slot)
      joint_at = weaker_joint(law, outlines%joint(edge), outlines%joint(at_vertex))
    end function joint_at

  end subroutine make_row

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
        memory%handed_on = .false.
        do k = 1, row%n
          memory%push(row%slot(k)) = row%push(k)
          memory%rub(row%slot(k)) = row%rub(k)
          memory%held(row%slot(k)) = row%held(k)
          memory%slid(row%slot(k)) = memory%slid(row%slot(k)) + row%slid(k)
          memory%slides(row%slot(k)) = row%slid(k) > 0
          memory%gap(row%slot(k)) = row%gap(k)
        end do
        if (row%bonded) then
          memory%strained = merge(memory%strained + 1, 0, is_strained(row))
          if (memory%strained >= steps_to_part) memory%bond = 0.0_dp
        end if
      end associate
    end do
    !$omp end do
  end subroutine keep_impulses

  !> Whether all points of a bond are at its limit in tension, or all at that along the faces. Where that
  !> is zero, as of a joint without cohesion that is pulled, they slide and it holds.
  pure logical function is_strained(row)
    type(row_t), intent(in) :: row

    real(dp) :: limit(row%n)

    associate (push => row%push(:row%n), rub => row%rub(:row%n))
      limit = row%friction(:row%n)*max(0.0_dp, push) + row%cohesion(:row%n)
      is_strained = all(push <= -at_limit*row%strength(:row%n)) .or. all(limit > 0 .and. abs(rub) >= at_limit*limit)
    end associate
  end function is_strained

  !> Of two vectors.
  pure real(dp) function cross(a, b)
    real(dp), intent(in) :: a(2), b(2)

    cross = a(1)*b(2) - a(2)*b(1)
  end function cross

end module scree_contact_rows
