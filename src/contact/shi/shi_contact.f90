!> Contact by Shi's own rules: gap and slip from an anchor, tolerances to close and to open, friction that lags (df18, df22).
module scree_shi_contact
  use scree_bond_rules, only: bond
  use scree_contact_geometry, only: frame_of_edge, entrance_geometry_t
  use scree_contact_quantities, only: contact_force_t, gap_and_slip_t
  use scree_contacts, only: contact_law_t, contact_t, entrance_t, shi_law_t, state_locked, state_open, state_sliding
  use scree_interpolation, only: displacement_matrix
  use scree_kinds, only: dp, pi
  use scree_model, only: cache_t, model_t
  use scree_state, only: state_t
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: adapted_stiffness, add_edge, anchor_where_closed, anchored_rows, close_touching, judge_shi, slide_shi

  integer, parameter :: n = element_unknowns

  !> Friction up to which a slider that turns back does not lock (Shi: 0.9 degrees).
  real(dp), parameter :: smooth = tan(0.9_dp*pi/180)
  !> Softening of the stiffness after a step, at most.
  real(dp), parameter :: softening = 3.0_dp

contains

  !> Makes the geometry of an entrance Shi's, at the beginning of the step: its gap is the area between vertex and edge over the
  !> length that the edge has then (df18, df22).
  pure subroutine add_edge(model, cache, state, pair, entrance, geometry, edge)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state               !! at the beginning of the step
    type(cache_t), intent(in) :: cache
    integer, intent(in) :: pair(2)                   !! elements in the order of the unknowns
    type(entrance_t), intent(in) :: entrance
    type(entrance_geometry_t), intent(inout) :: geometry
    !> What slip from an anchor needs: the end of the edge from its start, along and across; and the position of the edge's body
    !> that the vertex is at from the foot, along.
    real(dp), intent(out) :: edge(3, 2*n)
    real(dp) :: stretch(2, n), t(2), normal(2), length
    integer :: at

    associate (x1 => state%vertex(:, model%outlines%start(entrance%vertex)), &
               x2 => state%vertex(:, model%outlines%start(entrance%edge)), &
               x3 => state%vertex(:, model%outlines%finish(entrance%edge)), &
               kinematics => cache%element(model%outlines%element(entrance%edge))%kinematics)
      call frame_of_edge(x2, x3, t, normal, length)
      stretch = displacement_matrix(kinematics, x3) - displacement_matrix(kinematics, x2)
      at = merge(0, n, model%outlines%element(entrance%edge) == pair(1))
      edge = 0.0_dp
      edge(1, at + 1:at + n) = matmul(t, stretch)
      edge(2, at + 1:at + n) = matmul(normal, stretch)
      edge(3, at + 1:at + n) = matmul(t, displacement_matrix(kinematics, x1) &
                                      - displacement_matrix(kinematics, x1 - geometry%gap*normal))
    end associate
    geometry%normal = geometry%normal + geometry%gap/length*edge(1, :)
  end subroutine add_edge

  !> Rows of Shi's friction and slip, from an anchor (df18).
  !>
  !> Friction acts at the vertex and at the anchor, which moves with the edge. With x0 the anchor, the slip times the length
  !> of the edge at the beginning of the step is (x1 - x0).(x3 - x2), linear in displacements.
  pure function anchored_rows(geometry, edge, anchor) result(rows)
    type(entrance_geometry_t), intent(in) :: geometry
    real(dp), intent(in) :: edge(3, 2*n) !! as of `add_edge`
    real(dp), intent(in) :: anchor !! fraction of the edge
    real(dp) :: rows(2*n, 2), slip

    slip = geometry%along/geometry%edge_length - anchor
    rows(:, 1) = geometry%shear + edge(3, :) + slip*edge(1, :)
    rows(:, 2) = rows(:, 1) + slip*edge(1, :) + geometry%gap/geometry%edge_length*edge(2, :)
  end function anchored_rows

  !> Anchor of an open entrance, as a fraction of the edge: where the vertex meets the line in the step, or where it begins the step
  !> if it is inside then (Shi: df22). It is not linear in the displacement.
  pure real(dp) function anchor_where_closed(geometry, stretch, moved) result(anchor)
    type(entrance_geometry_t), intent(in) :: geometry !! at the beginning of the step
    real(dp), intent(in) :: stretch(3, 2*n)       !! of the edge, as of `add_edge`
    real(dp), intent(in) :: moved(2*n)            !! unknowns of both elements
    real(dp) :: apart(2), edge(2), rows(2*n, 2), part

    rows = anchored_rows(geometry, stretch, 0.0_dp)
    edge = matmul(stretch(:2, :), moved)
    apart = [dot_product(rows(:, 1), moved), dot_product(geometry%normal, moved) &
                                             + (geometry%along*edge(2) - geometry%gap*edge(1))/geometry%edge_length]
    part = max(geometry%gap, 0.0_dp)/max(geometry%gap, -dot_product(geometry%normal, moved), tiny(part))
    apart = [geometry%along, geometry%gap] + part*apart ! along the edge and across, of the vertex from its start
    edge = [geometry%edge_length, 0.0_dp] + part*edge
    anchor = dot_product(apart, edge)/dot_product(edge, edge)
  end function anchor_where_closed

  !> Closes a contact that begins the run with a gap up to `touching`, on the entrance with the larger gap. Two corners have no
  !> friction, and slide.
  pure subroutine close_touching(touching, gap, anchored, contact)
    real(dp), intent(in) :: touching !! length
    real(dp), intent(in) :: gap(2)   !! of its entrances, length
    logical, intent(in) :: anchored  !! slip is measured from the anchor
    type(contact_t), intent(inout) :: contact
    integer :: k

    k = maxloc(gap(:contact%n_entrances), 1)
    if (gap(k) > touching) return
    contact%active = k
    contact%entrance(k)%state = merge(state_sliding, state_locked, anchored .and. contact%n_entrances == 2)
  end subroutine close_touching

  !> Judges a contact (df22): the entrance with the larger gap acts. A contact that turns from one entrance to the other stays as it
  !> was.
  !>
  !> A change between sliding and locked asks for no other solution, and counts as none.
  pure subroutine judge_shi(law, now, force, contact, changes)
    type(contact_law_t), intent(in) :: law
    type(gap_and_slip_t), intent(in) :: now(2)
    type(contact_force_t), intent(in) :: force
    type(contact_t), intent(inout) :: contact
    integer, intent(inout) :: changes      !! of states, counted on
    real(dp) :: pressing
    integer :: k, state

    k = 1
    if (contact%n_entrances == 2) then
      k = maxloc(now%gap, 1)
      if (abs(force%across(2) - force%across(1)) <= 0) k = contact%active
    end if
    pressing = force%across(k)
    if (k /= contact%active) then
      associate (left => contact%entrance(contact%active))
        contact%entrance(k)%state = left%state
        if (left%state /= state_open) pressing = force%across(contact%active)
        left%state = state_open
      end associate
      contact%active = k
    end if
    associate (entrance => contact%entrance(k))
      state = state_open
      if (is_closed(law, entrance, pressing)) &
        call judge_lagging_friction(law, contact%n_entrances == 1, now(k)%slip, pressing, entrance, state)
      if (state /= entrance%state .and. min(state, entrance%state) == state_open .and. abs(pressing) > 0) changes = changes + 1
      entrance%state = state
    end associate
  end subroutine judge_shi

  !> Whether an entrance that presses, or is pulled, with a force is closed: it takes an overlap to close, and a gap to open.
  pure logical function is_closed(law, entrance, across)
    type(contact_law_t), intent(in) :: law
    type(entrance_t), intent(in) :: entrance
    real(dp), intent(in) :: across !! force

    if (entrance%state == state_open) then
      is_closed = across >= law%normal_stiffness*law%shi%closing
    else
      is_closed = across >= -law%normal_stiffness*law%shi%opening - bond(entrance, law%joint(entrance%joint)%strength)
    end if
  end function is_closed

  !> Whether a closed entrance slides or is locked, which way it slides, and with what friction in the next solution (df22).
  !>
  !> What closes compares gap and slip, is not bonded, and has no friction yet. What slides locks by turning back alone.
  pure subroutine judge_lagging_friction(law, rough, slip, pressing, entrance, state)
    type(contact_law_t), intent(in) :: law
    logical, intent(in) :: rough            !! there is friction and cohesion; two corners have none
    real(dp), intent(in) :: slip, pressing  !! length, force
    type(entrance_t), intent(inout) :: entrance
    integer, intent(out) :: state
    real(dp) :: cohesion, friction, limit, shear

    friction = 0.0_dp
    cohesion = 0.0_dp
    if (rough) then
      friction = law%joint(entrance%joint)%friction
      cohesion = bond(entrance, law%joint(entrance%joint)%cohesion)
    end if
    shear = entrance%multiplier(2) - law%shear_stiffness*slip
    limit = friction*max(0.0_dp, pressing)
    entrance%lagged_friction = limit + cohesion
    select case (entrance%state)
    case (state_open)
      shear = -law%normal_stiffness*slip
      entrance%lagged_friction = 0.0_dp
      state = merge(state_locked, state_sliding, abs(shear) < limit)
    case (state_sliding)
      state = merge(state_locked, state_sliding, &
                    friction > smooth .and. entrance%direction*shear > law%shear_stiffness*law%shi%backlash)
    case default
      state = merge(state_locked, state_sliding, abs(shear) <= limit + cohesion)
    end select
    if (state == state_sliding) entrance%direction = sign(1.0_dp, -shear)
  end subroutine judge_lagging_friction

  !> What an entrance remembers of sliding: its anchor follows, and its bond is lost, whatever else holds.
  pure subroutine slide_shi(law, shear, edge_length, entrance, slip, work)
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: shear        !! force
    real(dp), intent(in) :: edge_length  !! length
    type(entrance_t), intent(inout) :: entrance
    real(dp), intent(inout) :: slip      !! of the step, then 0, length
    real(dp), intent(out) :: work        !! lost in friction, force length

    work = abs(shear*slip)
    entrance%anchor = entrance%anchor + slip/edge_length
    slip = 0.0_dp
    entrance%lagged_friction = entrance%lagged_friction - bond(entrance, law%joint(entrance%joint)%cohesion)
    entrance%memory%bonded = .false.
  end subroutine slide_shi

  !> Contact stiffness after a step ("spri" of df): gaps and overlaps of closed contacts would be those allowed, but the new
  !> stiffness is at least a third of the old one. It lets blocks slide that should rest on friction.
  pure function adapted_stiffness(law, gap, overlap, stiffness) result(adapted)
    type(shi_law_t), intent(in) :: law
    real(dp), intent(in) :: gap, overlap    !! largest of a closed contact, length
    real(dp), intent(in) :: stiffness(2)    !! across a contact and along it, force/length per unit thickness
    real(dp) :: adapted(2)

    adapted = max(gap/law%allowed_gap, overlap/law%allowed_penetration, 1/softening)*stiffness
  end function adapted_stiffness

end module scree_shi_contact
