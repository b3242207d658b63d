!> Gap and slip of a vertex at the line of an edge, and how they change with the unknowns.
!>
!> Vertex y1, edge from y2 to y3, t along it, n out of the body of the edge, L its length:
!>
!>     gap    g = n.(y1 - y2)         open where positive
!>     along  a = t.(y1 - y2)         share of the edge  w = a/L
!>     dg = n.D,   D = d1 - (1-w) d2 - w d3       exact
!>     ds = t.(d1 - d(X1))                        X1: the point of the edge's body that the vertex is at
!>
!> The normal forces of a contact act on one line, at the vertex and at its foot on the edge. The shear forces act at the vertex and
!> at the point of the edge's body that the vertex is at. Neither pair of forces has a torque.
!>
!> With e the turn of the edge towards n, n.(d3 - d2)/L, the rows turn as the edge does: what N n and T t change by is
!>
!>     -N (e x ds + ds x e) + T (dg x e + e x dg)      x: dyadic product, but for the overlap over the edge and strains of its body
!>
!> and half of that, with the rows of the middle, where the forces act in the middle of a step.
!>
!> Over a step that the integrator balances in its middle, the row of the gap is its mean derivative. Let e = y3 - y2 and
!> r = y1 - y2 be those of the middle, and L0, L1, c0 and c1 the lengths L and the products g L of both ends. The gap changes
!> by exactly
!>
!>     g1 - g0 = a [(De x e).r + (r x De).e] + b e.De,   a = (1/L0 + 1/L1)/2,   b = -(c0 + c1)/(L0 L1 (L0 + L1))
!>
!> however far the edge turns and stretches, and the forces have no torque about the middle.
!>
!> These rows are derived in doc/theory/contact-geometry.md, eq-mean-row and eq-turning-rows.
module scree_contact_geometry
  use scree_contacts, only: entrance_t
  use scree_interpolation, only: displacement_matrix
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_state, only: state_t
  use scree_system, only: element_unknowns, values_of
  implicit none
  private
  public :: acting_rows_t, entrance_geometry_t, find_geometry, frame_of_edge, gap_of

  integer, parameter :: n = element_unknowns

  !> An entrance about a displacement: g(d) = gap + normal.(d - at), and so slid; `at` is zero where there are no `acting_rows_t`.
  !> Without default values: a step places two for each contact, of which most have one.
  type :: entrance_geometry_t
    real(dp) :: gap          !! length
    real(dp) :: along        !! from the start of the edge to the foot of the vertex when the step began, length
    real(dp) :: slid         !! movement of that foot since then, relative to its former place on the edge, length
    real(dp) :: edge_length  !! length
    real(dp) :: normal(2*n)  !! change of the gap with the unknowns of both elements
    real(dp) :: shear(2*n)   !! change of slid
  end type entrance_geometry_t

  !> What an entrance that may follow the motion has beside: rows of the configuration where the forces act.
  type :: acting_rows_t
    real(dp) :: at(2*n)      !! the displacement that its geometry is about, of the unknowns of both elements
    real(dp) :: normal(2*n)  !! change of the gap
    real(dp) :: shear(2*n)   !! change of slid
    real(dp) :: turn(2*n)    !! turn to its normal of the edge where forces act on it, if it follows d, rad/length
  end type acting_rows_t

contains

  !> Direction of an edge from a to b, its outer normal and its length.
  pure subroutine frame_of_edge(a, b, t, normal, length)
    real(dp), intent(in) :: a(2), b(2)
    real(dp), intent(out) :: t(2), normal(2), length

    length = norm2(b - a)
    t = (b - a)/length
    normal = [t(2), -t(1)]
  end subroutine frame_of_edge

  !> Gap of a position at the line from a to b.
  pure real(dp) function gap_of(position, a, b)
    real(dp), intent(in) :: position(2), a(2), b(2) !! length

    gap_of = gap_at_edge(position, a, b, norm2(b - a))
  end function gap_of

  !> Likewise, where the distance from a to b is known.
  pure real(dp) function gap_at_edge(position, a, b, length) result(gap)
    real(dp), intent(in) :: position(2), a(2), b(2) !! length
    real(dp), intent(in) :: length

    gap = ((b(2) - a(2))*(position(1) - a(1)) - (b(1) - a(1))*(position(2) - a(2)))/length
  end function gap_at_edge

  !> Finds the geometry of an entrance at displacement `d` of the elements.
  !>
  !> With a weight, gap and slip are those of the positions to which `d` moves the vertices, and the forces act in the configuration
  !> at `weight` times `d`. Without a weight, everything is linear about the beginning of the step, as in Shi's program.
  pure subroutine find_geometry(model, cache, state, pair, entrance, d, geometry, acting, weight)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state               !! at the beginning of the step
    type(cache_t), intent(in) :: cache
    integer, intent(in) :: pair(2)                   !! elements in the order of the unknowns
    type(entrance_t), intent(in) :: entrance
    real(dp), intent(in) :: d(:)                     !! (n_unknowns)
    type(entrance_geometry_t), intent(out) :: geometry
    type(acting_rows_t), intent(out), optional :: acting !! where any entrance may follow the motion
    real(dp), intent(in), optional :: weight         !! where this one does
    real(dp), dimension(2, n) :: T1, T2, T3
    real(dp), dimension(n) :: d1, d2                 ! of the bodies of vertex and edge
    real(dp), dimension(2) :: x1, x2, x3, u1, u2, u3, t, normal, edge, length, moment
    real(dp) :: at(2*n)
    integer :: body, edge_body, own, other           ! the unknowns of these bodies are after these
    logical :: still                                 ! the edge cannot move

    body = model%outlines%of_vertex(entrance%vertex)
    edge_body = model%outlines%element(entrance%edge)
    still = model%outlines%fixed(entrance%edge)
    own = merge(0, n, body == pair(1))
    other = n - own
    d1 = values_of(model%elements, body, d)
    d2 = values_of(model%elements, edge_body, d)
    at(own + 1:own + n) = d1
    at(other + 1:other + n) = d2
    x1 = state%vertex(:, model%outlines%start(entrance%vertex))
    x2 = state%vertex(:, model%outlines%start(entrance%edge))
    x3 = state%vertex(:, model%outlines%finish(entrance%edge))
    T1 = displacement_matrix(cache%element(body)%kinematics, x1)
    u1 = 0.0_dp
    u2 = 0.0_dp
    u3 = 0.0_dp
    if (present(weight)) u1 = matmul(T1, d1)
    if (.not. still) then
      T2 = displacement_matrix(cache%element(edge_body)%kinematics, x2)
      T3 = displacement_matrix(cache%element(edge_body)%kinematics, x3)
      if (present(weight)) then
        u2 = matmul(T2, d2)
        u3 = matmul(T3, d2)
      end if
    end if
    call frame_of_edge(x2, x3, t, normal, geometry%edge_length)
    geometry%gap = gap_at_edge(x1, x2, x3, geometry%edge_length)
    geometry%along = dot_product(t, x1 - x2)
    if (still) call put_rows_at_rest(t, normal, geometry%normal, geometry%shear)
    if (present(weight)) then
      if (still) then
        acting = acting_rows_t(at, geometry%normal, geometry%shear, 0.0_dp)
      else
        call measure_product(1.0_dp, length(2), moment(2))
        call put_rows(1.0_dp, [length(2), length(2)], [moment(2), moment(2)], geometry%normal, geometry%shear)
        call measure_product(2*weight - 1, length(1), moment(1))
        call put_rows(weight, length, moment, acting%normal, acting%shear)
        edge = x3 - x2 + weight*(u3 - u2)
        acting%turn = 0.0_dp
        acting%turn(other + 1:other + n) = weight*(edge(2)*(T3(1, :) - T2(1, :)) - edge(1)*(T3(2, :) - T2(2, :)))/sum(edge**2)
        acting%at = at
      end if
      call move(t, geometry)
    else
      if (.not. still) then
        length = geometry%edge_length
        moment = length*geometry%gap
        call put_rows(0.0_dp, length, moment, geometry%normal, geometry%shear)
      end if
      geometry%gap = geometry%gap + dot_product(geometry%normal, at)
      geometry%slid = dot_product(geometry%shear, at)
      if (present(acting)) acting = acting_rows_t(at, geometry%normal, geometry%shear, 0.0_dp)
    end if

  contains

    !> Adds to gap, slip and length what they change by on the way to `d`.
    !>
    !> It is written with the turn of the edge, which is exactly zero for an edge at rest. The difference of two gaps, or of two
    !> positions along a long edge, would be rounded to the length of the edge, and the spring of a pebble on it to more than its
    !> weight.
    pure subroutine move(t, geometry)
      real(dp), intent(inout) :: t(2)                  !! direction of the edge
      type(entrance_geometry_t), intent(inout) :: geometry !! at the beginning of the step
      real(dp) :: turned(2), stretched, length

      associate (edge => x3 - x2, bent => u3 - u2, r => x1 - x2, moved => u1 - u2)
        length = norm2(edge + bent)
        stretched = dot_product(bent, 2*edge + bent)/(length + geometry%edge_length)
        turned = bent/length - stretched/(length*geometry%edge_length)*edge ! change of the direction
        t = t + turned
        geometry%gap = geometry%gap + (turned(2)*r(1) - turned(1)*r(2)) + (t(2)*moved(1) - t(1)*moved(2))
        geometry%slid = dot_product(turned, r) + dot_product(t, moved) - geometry%along/geometry%edge_length*stretched
        geometry%edge_length = length
      end associate
    end subroutine move

    !> Rows of the change of the gap between two configurations, and of slip in their middle. Each configuration is a fraction of
    !> `d`.
    pure subroutine put_rows(middle, length, moment, normal_row, shear_row)
      real(dp), intent(in) :: middle               !! fraction of `d`
      real(dp), intent(in) :: length(2), moment(2) !! of the edge in both, and its products with the gaps
      real(dp), intent(out) :: normal_row(2*n), shear_row(2*n)
      real(dp) :: edge(2), apart(2), on_vertex(2), on_edge(2), t(2), F(4), T_there(2, n)

      edge = x3 - x2 + middle*(u3 - u2)
      apart = x1 - x2 + middle*(u1 - u2)
      on_vertex = 0.5_dp*sum(1/length)*[edge(2), -edge(1)]
      on_edge = 0.5_dp*sum(1/length)*[-apart(2), apart(1)] - sum(moment)/(product(length)*sum(length))*edge
      t = edge/norm2(edge)
      F = [1.0_dp, 0.0_dp, 0.0_dp, 1.0_dp]
      if (present(weight)) F = F + middle*matmul(cache%element(edge_body)%kinematics%gradient, d2)
      T_there = displacement_matrix(cache%element(edge_body)%kinematics, x2 + [F(4)*apart(1) - F(3)*apart(2), &
                                                                       F(1)*apart(2) - F(2)*apart(1)]/(F(1)*F(4) - F(2)*F(3)))
      normal_row(own + 1:own + n) = matmul(on_vertex, T1)
      shear_row(own + 1:own + n) = matmul(t, T1)
      normal_row(other + 1:other + n) = matmul(on_edge, T3) - matmul(on_vertex + on_edge, T2)
      shear_row(other + 1:other + n) = -matmul(t, T_there)
    end subroutine put_rows

    !> Rows of an edge that cannot move, which are the same in all configurations: those of its body are of no use.
    pure subroutine put_rows_at_rest(t, normal, normal_row, shear_row)
      real(dp), intent(in) :: t(2), normal(2)      !! along the edge and out of its body
      real(dp), intent(out) :: normal_row(2*n), shear_row(2*n)

      normal_row(own + 1:own + n) = matmul(normal, T1)
      shear_row(own + 1:own + n) = matmul(t, T1)
      normal_row(other + 1:other + n) = 0.0_dp
      shear_row(other + 1:other + n) = 0.0_dp
    end subroutine put_rows_at_rest

    !> Length of the edge and its product with the gap, in the configuration that a part of `d` makes.
    pure subroutine measure_product(part, length, moment)
      real(dp), intent(in) :: part
      real(dp), intent(out) :: length, moment

      length = norm2(x3 - x2 + part*(u3 - u2))
      moment = length*gap_of(x1 + part*u1, x2 + part*u2, x3 + part*u3)
    end subroutine measure_product

  end subroutine find_geometry

end module scree_contact_geometry
