!> Shi's own rules of one contact: gap and slip from an anchor, where the anchor is, and friction that lags (df18, df22).
module scree_shi_contact
  use scree_contact_geometry, only: frame_of_edge, entrance_geometry_t
  use scree_contacts, only: contact_law_t, entrance_t, state_locked, state_open, state_sliding
  use scree_interpolation, only: displacement_matrix
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_state, only: state_t
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: add_edge, anchor_where_closed, anchored_rows, judge_lagging_friction

  integer, parameter :: n = element_unknowns

  !> Friction up to which a slider that turns back does not lock (Shi: 0.9 degrees).
  real(dp), parameter :: smooth = tan(0.9_dp*acos(-1.0_dp)/180)

contains

  !> Makes the geometry of a line at the beginning of the step Shi's: adds what slip from an anchor needs, and the gap is the
  !> area between vertex and edge over the length that the edge has then (df18, df22).
  pure subroutine add_edge(model, cache, state, pair, entrance, geometry)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state               !! at the beginning of the step
    type(cache_t), intent(in) :: cache
    integer, intent(in) :: pair(2)                   !! elements in the order of the unknowns
    type(entrance_t), intent(in) :: entrance
    type(entrance_geometry_t), intent(inout) :: geometry
    real(dp) :: stretch(2, n), t(2), normal(2), length
    integer :: at

    associate (x1 => state%vertex(:, model%outlines%start(entrance%vertex)), x2 => state%vertex(:, &
        model%outlines%start(entrance%edge)), &
               x3 => state%vertex(:, model%outlines%finish(entrance%edge)), &
                   kinematics => cache%element(model%outlines%element(entrance%edge))%kinematics)
      call frame_of_edge(x2, x3, t, normal, length)
      stretch = displacement_matrix(kinematics, x3) - displacement_matrix(kinematics, x2)
      at = merge(0, n, model%outlines%element(entrance%edge) == pair(1))
      allocate (geometry%edge(3, 2*n), source=0.0_dp)
      geometry%edge(1, at + 1:at + n) = matmul(t, stretch)
      geometry%edge(2, at + 1:at + n) = matmul(normal, stretch)
      geometry%edge(3, at + 1:at + n) = matmul(t, displacement_matrix(kinematics, x1) &
                                                  - displacement_matrix(kinematics, x1 - geometry%gap*normal))
    end associate
    geometry%normal = geometry%normal + geometry%gap/length*geometry%edge(1, :)
    geometry%normal_end = geometry%normal
  end subroutine add_edge

  !> Rows of Shi's friction and slip, from an anchor (df18).
  !>
  !> Friction acts at the vertex and at the anchor, which moves with the edge. With x0 the anchor, the slip times the length
  !> of the edge at the beginning of the step is (x1 - x0).(x3 - x2), linear in displacements.
  pure function anchored_rows(geometry, anchor) result(rows)
    type(entrance_geometry_t), intent(in) :: geometry
    real(dp), intent(in) :: anchor !! share of the edge
    real(dp) :: rows(2*n, 2), slip

    slip = geometry%along/geometry%edge_length - anchor
    rows(:, 1) = geometry%shear + geometry%edge(3, :) + slip*geometry%edge(1, :)
    rows(:, 2) = rows(:, 1) + slip*geometry%edge(1, :) + geometry%gap/geometry%edge_length*geometry%edge(2, :)
  end function anchored_rows

  !> Place on the edge, as a share of it, where a vertex meets its line in the step, or is at its beginning where it is inside
  !> then (Shi: df22). No longer linear.
  pure real(dp) function anchor_where_closed(geometry, moved) result(anchor)
    type(entrance_geometry_t), intent(in) :: geometry !! at the beginning of the step
    real(dp), intent(in) :: moved(2*n)            !! unknowns of both elements
    real(dp) :: apart(2), edge(2), rows(2*n, 2), part

    rows = anchored_rows(geometry, 0.0_dp)
    edge = matmul(geometry%edge(:2, :), moved)
    apart = [dot_product(rows(:, 1), moved), dot_product(geometry%normal, moved) &
                                             + (geometry%along*edge(2) - geometry%gap*edge(1))/geometry%edge_length]
    part = max(geometry%gap, 0.0_dp)/max(geometry%gap, -dot_product(geometry%normal, moved), tiny(part))
    apart = [geometry%along, geometry%gap] + part*apart ! along the edge and across, of the vertex from its start
    edge = [geometry%edge_length, 0.0_dp] + part*edge
    anchor = dot_product(apart, edge)/dot_product(edge, edge)
  end function anchor_where_closed

  !> Whether a closed line slides or is locked, which way it slides, and with what friction in the next solution (Shi: df22).
  !>
  !> What closes compares gap and slip, is not bonded, and has no friction yet. What slides locks by turning back alone.
  pure subroutine judge_lagging_friction(law, friction, cohesion, slip, pressing, entrance, state)
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: friction        !! tangent of the friction angle
    real(dp), intent(in) :: cohesion        !! of the bond, force
    real(dp), intent(in) :: slip, pressing  !! length, force
    type(entrance_t), intent(inout) :: entrance
    integer, intent(out) :: state
    real(dp) :: limit, shear

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
                    friction > smooth .and. entrance%direction*shear > law%shear_stiffness*law%backlash)
    case default
      state = merge(state_locked, state_sliding, abs(shear) <= limit + cohesion)
    end select
    if (state == state_sliding) entrance%direction = sign(1.0_dp, -shear)
  end subroutine judge_lagging_friction

end module scree_shi_contact
