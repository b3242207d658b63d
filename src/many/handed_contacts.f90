!> Contacts that a state hands on, and what pairs of pieces remember of them: the same list for all integrators.
!>
!> A contact that steps of another integrator leave goes to the point of its pair that is nearest, with its force; its bond stays.
!> The contacts that small steps leave are found by their vertices, to the bit.
module scree_handed_contacts
  use scree_bodies, only: bodies_t, pair_memory_t, point_memory_t
  use scree_contact_rows, only: bond_reach, edge_below
  use scree_contacts, only: contact_law_t, contact_memory_t, contact_t, count_states, outlines_t, state_locked, state_open, &
                            state_sliding
  use scree_entrance_block, only: find_leading_line, meet, meeting_t
  use scree_kinds, only: dp
  use scree_near_pieces, only: place_of_pair
  implicit none
  private
  public :: bond_faces, give_contacts, take_contacts

  real(dp), parameter :: flush = 1e-6_dp     !! of a body: gap of faces that are bonded as a run begins, the rounding of a file

contains

  !> Gives the pairs near each other what the contacts of a state remember.
  subroutine take_contacts(contacts, h, bodies)
    type(contact_t), intent(in) :: contacts(:)
    real(dp), intent(in) :: h                !! size of the small steps that follow, time
    type(bodies_t), intent(inout) :: bodies
    integer :: i, p, slot, vertex

    do p = 1, bodies%near%n
      if (bodies%near%memory(p)%touches) bodies%near%memory(p) = pair_memory_t()
    end do
    do i = 1, size(contacts)
      associate (contact => contacts(i), entrance => contacts(i)%entrance(contacts(i)%active))
        if (entrance%state == state_open) cycle
        call find_pair(bodies, entrance%vertex, entrance%edge, contact%end, p)
        if (p == 0) cycle
        slot = contact%end
        vertex = entrance%vertex
        if (slot == 0) call find_nearest(bodies, p, entrance%vertex, slot, vertex)
        associate (memory => bodies%near%memory(p), point => bodies%near%memory(p)%point(slot))
          memory%touches = .true.
          memory%strained = max(memory%strained, contact%strained)
          point%vertex = vertex
          point%edge = bodies%begins_with(entrance%edge)
          point%push = point%push + contact%force(1)*h
          point%rub = point%rub + contact%force(2)*h
          point%joint = entrance%joint
          point%held = entrance%held
          point%slid = entrance%memory%wear
          if (entrance%memory%bonded) point%bond = point%bond + entrance%memory%length
          point%normal = normal_of(bodies, p, entrance%edge)
        end associate
      end associate
    end do
  end subroutine take_contacts

  !> The pair of pieces of a vertex and an edge; 0: there is none. Of several pieces that have the vertex it is one whose pair
  !> has no point at this end yet.
  subroutine find_pair(bodies, vertex, edge, end, p)
    type(bodies_t), intent(in) :: bodies
    integer, intent(in) :: vertex, edge      !! of the outlines
    integer, intent(in) :: end               !! 0: any
    integer, intent(out) :: p
    integer :: k

    p = 0
    if (bodies%piece_of(edge) == 0) return
    do k = bodies%first_corner(vertex), bodies%first_corner(vertex + 1) - 1
      p = place_of_pair(bodies%near, bodies%piece_of(edge), bodies%piece_at(bodies%corners_at(k)))
      if (p == 0) cycle
      if (end == 0) return
      if (bodies%near%memory(p)%point(end)%vertex == 0) return
      p = 0
    end do
  end subroutine find_pair

  !> Outward normal of an edge of the outlines, from the first piece of a pair to the second.
  pure function normal_of(bodies, p, edge) result(normal)
    type(bodies_t), intent(in) :: bodies
    integer, intent(in) :: p, edge
    real(dp) :: normal(2)
    integer :: k

    normal = 0.0_dp
    associate (begins => bodies%begins_with(edge), own => bodies%piece_of(edge))
      do k = bodies%first(own), bodies%first(own + 1) - 1
        if (bodies%edge(k) == begins) normal = merge(1, -1, own == bodies%near%piece(1, p))*bodies%normal(:, k)
      end do
    end associate
  end function normal_of

  !> The point at which a pair meets that is nearest to a vertex: its end, and its own vertex.
  subroutine find_nearest(bodies, p, vertex, slot, own_vertex)
    type(bodies_t), intent(inout) :: bodies
    integer, intent(in) :: p, vertex
    integer, intent(out) :: slot, own_vertex
    type(meeting_t) :: meeting
    real(dp) :: x(2)
    integer :: i

    slot = 1
    own_vertex = vertex
    call meet_near(bodies, p, bond_reach*bodies%size(bodies%body(bodies%near%piece(2, p))), meeting)
    if (meeting%n == 0) return
    x = bodies%at(:, bodies%corners_at(bodies%first_corner(vertex)))
    i = 1
    if (meeting%n == 2) i = merge(2, 1, norm2(meeting%position(:, 2) - x) < norm2(meeting%position(:, 1) - x))
    slot = meeting%slot(i)
    own_vertex = bodies%edge(meeting%vertex(i))
  end subroutine find_nearest

  !> Where a pair meets whose gap is below `far`; nowhere else. Vertices and edges are corners of the bodies.
  subroutine meet_near(bodies, p, far, meeting)
    type(bodies_t), intent(inout) :: bodies
    integer, intent(in) :: p
    real(dp), intent(in) :: far              !! length
    type(meeting_t), intent(out) :: meeting
    real(dp) :: gap

    associate (a => bodies%near%piece(1, p), b => bodies%near%piece(2, p))
      associate (from_a => bodies%first(a), from_b => bodies%first(b), n_a => bodies%first(a + 1) - bodies%first(a), &
                 n_b => bodies%first(b + 1) - bodies%first(b))
        call find_leading_line(n_a, bodies%at(1, from_a), bodies%normal(1, from_a), bodies%face(from_a), &
                               n_b, bodies%at(1, from_b), bodies%normal(1, from_b), bodies%face(from_b), &
                               far, bodies%near%edge(p), bodies%near%vertex(p), gap)
        if (gap >= far) return
        call meet(n_a, bodies%at(1, from_a), bodies%normal(1, from_a), bodies%face(from_a), &
                  n_b, bodies%at(1, from_b), bodies%normal(1, from_b), bodies%face(from_b), &
                  far, bodies%near%edge(p), bodies%near%vertex(p), meeting)
        where (meeting%vertex > n_a)
          meeting%vertex = from_b - 1 + meeting%vertex - n_a
        else where
          meeting%vertex = from_a - 1 + meeting%vertex
        end where
        where (meeting%edge > n_a)
          meeting%edge = from_b - 1 + meeting%edge - n_a
        else where
          meeting%edge = from_a - 1 + meeting%edge
        end where
      end associate
    end associate
  end subroutine meet_near

  !> Bonds the faces that lie on each other as a run begins and whose joint has cohesion or tensile strength: each of the two points
  !> holds half of what they have in common.
  subroutine bond_faces(law, outlines, bodies)
    type(contact_law_t), intent(in) :: law
    type(outlines_t), intent(in) :: outlines
    type(bodies_t), intent(inout) :: bodies
    type(meeting_t) :: meeting
    integer :: edge, i, p

    if (.not. any(law%joint%cohesion > 0 .or. law%joint%strength > 0)) return
    do p = 1, bodies%near%n
      call meet_near(bodies, p, flush*bodies%size(bodies%body(bodies%near%piece(2, p))), meeting)
      if (meeting%n < 2) cycle
      associate (memory => bodies%near%memory(p))
        do i = 1, 2
          edge = edge_below(bodies, outlines, meeting%edge(i), 0.5_dp*(meeting%position(:, 1) + meeting%position(:, 2)))
          if (.not. (law%joint(outlines%joint(edge))%cohesion > 0 .or. law%joint(outlines%joint(edge))%strength > 0)) cycle
          memory%touches = .true.
          memory%point(meeting%slot(i)) = &
            point_memory_t(vertex=bodies%edge(meeting%vertex(i)), edge=bodies%edge(meeting%edge(i)), joint=outlines%joint(edge), &
                           bond=0.5_dp*norm2(meeting%position(:, 2) - meeting%position(:, 1)), normal=meeting%normal(:, i))
        end do
      end associate
    end do
  end subroutine bond_faces

  !> Writes what pairs that touch remember as contacts, with the forces of the last step, and counts them.
  subroutine give_contacts(bodies, law, outlines, position, h, memory)
    type(bodies_t), intent(in) :: bodies
    type(contact_law_t), intent(in) :: law
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)   !! (2, n_vertices) of the elements, length
    real(dp), intent(in) :: h                !! size of the last small step, time
    type(contact_memory_t), intent(inout) :: memory
    integer :: k, n, p, slot

    n = 0
    do p = 1, bodies%near%n
      n = n + count(bodies%near%memory(p)%touches .and. bodies%near%memory(p)%point%vertex > 0)
    end do
    if (size(memory%contact) /= n) then
      deallocate (memory%contact)
      allocate (memory%contact(n))
    end if
    k = 0
    do p = 1, bodies%near%n
      associate (own => bodies%near%memory(p))
        if (.not. own%touches) cycle
        do slot = 1, 2
          if (own%point(slot)%vertex == 0) cycle
          k = k + 1
          memory%contact(k) = contact_of(own%point(slot), slot, own%strained)
        end do
      end associate
    end do
    memory%count = count_states(memory%contact)
    memory%penetration = max(0.0_dp, maxval(memory%contact%overlap))
    memory%pressed = memory%penetration

  contains

    !> A point as a contact.
    type(contact_t) function contact_of(own, slot, strained) result(contact)
      type(point_memory_t), intent(in) :: own
      integer, intent(in) :: slot, strained
      real(dp) :: along(2)

      contact%end = slot
      contact%strained = strained
      contact%force = [own%push, own%rub]/h
      contact%overlap = max(0.0_dp, -own%gap)
      contact%pressed = contact%overlap
      associate (entrance => contact%entrance(1))
        entrance%vertex = own%vertex
        entrance%joint = own%joint
        entrance%state = merge(state_sliding, state_locked, own%slides)
        if (own%slides) entrance%direction = sign(1.0_dp, -own%rub)
        entrance%stiffness = [law%normal_stiffness, law%shear_stiffness]
        entrance%rest = own%gap + own%push/h/law%normal_stiffness
        entrance%memory%pressing = contact%force(1)
        entrance%memory%length = own%bond
        entrance%memory%bonded = own%bond > 0
        entrance%held = own%held
        entrance%memory%slid = own%slid
        entrance%memory%wear = own%slid
        associate (x => position(:, outlines%start(own%vertex)))
          entrance%edge = edge_under(own%edge, x)
          associate (begins => position(:, outlines%start(entrance%edge)), ends => position(:, outlines%finish(entrance%edge)))
            along = (ends - begins)/sum((ends - begins)**2)
            entrance%anchor = dot_product(along, x - begins)
          end associate
        end associate
      end associate
    end function contact_of

    !> The edge of the outlines below a position, among those of a side.
    integer function edge_under(first_edge, x) result(edge)
      integer, intent(in) :: first_edge
      real(dp), intent(in) :: x(2)           !! length

      edge = first_edge
      do while (bodies%begins_with(outlines%next(edge)) == first_edge .and. outlines%next(edge) /= first_edge)
        associate (begins => position(:, outlines%start(edge)), ends => position(:, outlines%finish(edge)))
          if (dot_product(ends - begins, x - ends) <= 0) return
        end associate
        edge = outlines%next(edge)
      end do
    end function edge_under

  end subroutine give_contacts

end module scree_handed_contacts
