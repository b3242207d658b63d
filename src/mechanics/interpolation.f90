!> T and G of an element: the only place that knows a DDA block from a manifold element.
!>
!> In both, the displacement of a step is linear in place and in the unknowns,
!>
!>     u(x) = T(x) d,   theta = (u_X, v_X, u_Y, v_Y) = G d,   T(x) = T(c) + [X I, Y I] G,   X = x - c,
!>
!> with c the centroid. A block of the DDA has d = (u0, v0, r0, ex, ey, gxy) about its centroid (Shi 1988). An element of the NMM
!> has three covers with constant displacement and linear weights, d = (u1, v1, u2, v2, u3, v3) (Shi 1991). The two pass on
!> velocities differently from step to step, which is here too.
!>
!> A cell of an element of second order moves as a block of the DDA does, about its point. Its unknowns follow the six covers of the
!> element, which determine displacement and gradient at that point.
module scree_interpolation
  use scree_kinds, only: dp
  use scree_regions, only: first_vertex_of, last_vertex_of
  use scree_scene, only: model_dda, rotation_exact, transport_rates
  use scree_simplex_integration, only: moments_t, polygon_moments
  use scree_state, only: state_t
  use scree_system, only: element_unknowns, sampling_t, system_t
  implicit none
  private
  public :: carried_rates, displacement_matrix, follow_covers, followed_covers, kept_distance, kinematics_t, kinematics_of, &
            most_moved, rigid_modes, rigid_velocity, turn, turned_rates, turned_vector

  integer, parameter :: n = element_unknowns

  !> Of its triangle: the size of an element that is less is that of so much, as its nodes go by rounding of what they are.
  real(dp), parameter :: least_share = 1e-2_dp

  !> Distance of the point that a block turns about from its middle, over its size, up to which it is near.
  real(dp), parameter :: near = 2.0_dp

  !> One element in the configuration at the beginning of a step.
  type :: kinematics_t
    real(dp) :: area = 0.0_dp              !! length^2
    real(dp) :: size = 1.0_dp              !! root of the area, at least of a fraction of that of the mathematical triangle, length
    real(dp) :: centroid(2) = 0.0_dp       !! length
    real(dp) :: second(3) = 0.0_dp         !! integrals of X^2, Y^2, X Y about the centroid, length^4
    real(dp) :: at_centroid(2, n) = 0.0_dp !! T at the centroid
    real(dp) :: gradient(4, n) = 0.0_dp    !! G
    real(dp) :: span(n) = 1.0_dp           !! displacement that a unit of each unknown makes: 1, or the size of the block
  end type kinematics_t

contains

  !> Interpolation and integrals of element `e` as it stands.
  pure function kinematics_of(system, state, e) result(element)
    class(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    integer, intent(in) :: e
    type(kinematics_t) :: element
    type(moments_t) :: moments
    integer :: first

    if (allocated(system%sampling)) then
      call interpolate_cell(system%sampling, e, state%cover(:, system%elements%cover(:, e)), element)
      return
    end if
    associate (shape => system%elements%shape)
      first = first_vertex_of(shape, e)
      moments = polygon_moments(state%vertex(:, first:last_vertex_of(shape, e)), &
                                shape%first_vertex(shape%first_loop(e):shape%first_loop(e + 1)) - first + 1)
    end associate
    element%area = moments%area
    element%centroid = moments%centroid
    element%second = moments%second
    if (system%model == model_dda) then
      call interpolate_block(element)
    else
      call interpolate_covers(state%cover(:, system%elements%cover(:, e)), element)
    end if
  end function kinematics_of

  !> First-order displacement of a block about its centroid (Shi: dspl).
  pure subroutine interpolate_block(element)
    type(kinematics_t), intent(inout) :: element

    element%at_centroid(1, 1) = 1.0_dp
    element%at_centroid(2, 2) = 1.0_dp
    element%gradient(1, 4) = 1.0_dp
    element%gradient(2, [3, 6]) = [1.0_dp, 0.5_dp]
    element%gradient(3, [3, 6]) = [-1.0_dp, 0.5_dp]
    element%gradient(4, 5) = 1.0_dp
    element%size = sqrt(element%area)
    element%span(3:) = element%size
  end subroutine interpolate_block

  !> A cell at its point, of which it has the mass and the area alone.
  pure subroutine interpolate_cell(sampling, e, node, element)
    type(sampling_t), intent(in) :: sampling
    integer, intent(in) :: e
    real(dp), intent(in) :: node(2, 6) !! where its covers are, length
    type(kinematics_t), intent(inout) :: element
    real(dp) :: F(2, 2)

    call interpolate_block(element)
    element%span = 1.0_dp ! of no consequence: its unknowns follow
    F = matmul(node, transpose(sampling%slope(:, :, e)))
    element%area = sampling%area(e)*(F(1, 1)*F(2, 2) - F(1, 2)*F(2, 1))
    element%size = sqrt(element%area)
    element%centroid = matmul(node, sampling%value(:, e))
  end subroutine interpolate_cell

  !> The covers of a cell that its unknowns follow, and how: coefficients of x and y of each of six.
  pure function followed_covers(system, state, e) result(coefficient)
    class(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    integer, intent(in) :: e
    real(dp) :: coefficient(12, n) !! of the x and y of its covers in turn, for each of its unknowns
    real(dp) :: F(2, 2), slope(2, 6)

    associate (of => system%sampling)
      F = matmul(state%cover(:, system%elements%cover(:, e)), transpose(of%slope(:, :, e)))
      slope(1, :) = F(2, 2)*of%slope(1, :, e) - F(2, 1)*of%slope(2, :, e) ! as it stands: F^-T of that of the start
      slope(2, :) = F(1, 1)*of%slope(2, :, e) - F(1, 2)*of%slope(1, :, e)
      slope = slope/(F(1, 1)*F(2, 2) - F(1, 2)*F(2, 1))
      coefficient = 0.0_dp
      coefficient(1::2, 1) = of%value(:, e)
      coefficient(2::2, 2) = of%value(:, e)
      coefficient(1::2, 3) = -0.5_dp*slope(2, :)
      coefficient(2::2, 3) = 0.5_dp*slope(1, :)
      coefficient(1::2, 4) = slope(1, :)
      coefficient(2::2, 5) = slope(2, :)
      coefficient(1::2, 6) = slope(2, :)
      coefficient(2::2, 6) = slope(1, :)
    end associate
  end function followed_covers

  !> Lets vertices and rates of cells follow their covers.
  pure subroutine follow_covers(system, state)
    class(system_t), intent(in) :: system
    type(state_t), intent(inout) :: state
    real(dp) :: coefficient(12, n)
    integer :: e, i, k, v, unknown(12)

    do k = 1, size(system%elements%free)
      e = system%elements%free(k)
      associate (cover => system%elements%cover(:, e), own => system%elements%unknown(:, e))
        coefficient = followed_covers(system, state, e)
        unknown = [(2*cover(i) - 1, 2*cover(i), i=1, 6)]
        state%velocity(own) = matmul(state%velocity(unknown), coefficient)
        state%acceleration(own) = matmul(state%acceleration(unknown), coefficient)
        do v = first_vertex_of(system%elements%shape, e), last_vertex_of(system%elements%shape, e)
          state%vertex(:, v) = matmul(state%cover(:, cover), system%sampling%at_vertex(:, v))
        end do
      end associate
    end do
  end subroutine follow_covers

  !> Three constant covers with the linear weights of the mathematical triangle.
  pure subroutine interpolate_covers(node, element)
    real(dp), intent(in) :: node(2, 3) !! of the mathematical triangle, counter-clockwise, length
    type(kinematics_t), intent(inout) :: element
    real(dp) :: a(2), b(2), twice_area, slope(2, 3), weight(3), x(2)
    integer :: k

    a = node(:, 2) - node(:, 1)
    b = node(:, 3) - node(:, 1)
    twice_area = a(1)*b(2) - a(2)*b(1)
    element%size = sqrt(max(element%area, least_share*0.5_dp*abs(twice_area)))
    slope(:, 2) = [b(2), -b(1)]/twice_area
    slope(:, 3) = [-a(2), a(1)]/twice_area
    slope(:, 1) = -slope(:, 2) - slope(:, 3)
    x = element%centroid - node(:, 1)
    weight(2:) = matmul(x, slope(:, 2:))
    weight(1) = 1.0_dp - weight(2) - weight(3)
    do k = 1, 3
      element%at_centroid(1, 2*k - 1) = weight(k)
      element%at_centroid(2, 2*k) = weight(k)
      element%gradient(1, 2*k - 1) = slope(1, k)
      element%gradient(2, 2*k) = slope(1, k)
      element%gradient(3, 2*k - 1) = slope(2, k)
      element%gradient(4, 2*k) = slope(2, k)
    end do
  end subroutine interpolate_covers

  !> T at a position: the displacement there per unknown, 2 x n.
  pure function displacement_matrix(element, position) result(T)
    type(kinematics_t), intent(in) :: element
    real(dp), intent(in) :: position(2) !! length
    real(dp) :: T(2, n)

    T = element%at_centroid + (position(1) - element%centroid(1))*element%gradient(1:2, :) &
        + (position(2) - element%centroid(2))*element%gradient(3:4, :)
  end function displacement_matrix

  !> A bound of how far any place of an element goes, none of which is farther than `arm` from its centroid.
  pure real(dp) function most_moved(model, rotation, unknown, arm) result(way)
    integer, intent(in) :: model        !! `model_dda` or `model_nmm` of the scene
    integer, intent(in) :: rotation     !! what moves a block that turns; by sine and cosine no place goes farther
    real(dp), intent(in) :: unknown(n)
    real(dp), intent(in) :: arm         !! length

    if (model == model_dda) then
      way = abs(unknown(3)) + max(abs(unknown(4)), abs(unknown(5))) + 0.5_dp*abs(unknown(6))
      if (rotation > rotation_exact) way = way*(1 + way)
      way = sqrt(unknown(1)**2 + unknown(2)**2) + arm*way
    else ! its places lie within the nodes of the covers
      way = sqrt(max(unknown(1)**2 + unknown(2)**2, unknown(3)**2 + unknown(4)**2, unknown(5)**2 + unknown(6)**2))
    end if
  end function most_moved

  !> A displacement with which a DDA block keeps its size. A block that turns about a point in it or near it keeps its distance from
  !> that point. The displacement of covers is returned unchanged.
  !>
  !> With complex numbers x moves to x + z (x - q). The acceleration changes within the step, which makes an error of z. The part of
  !> the error that strains is removed: x moves to q + (1 + z)/|1 + z| (x - q). Where q is far, the middle of the block takes its
  !> place.
  pure function kept_distance(model, element, unknown) result(d)
    integer, intent(in) :: model           !! `model_dda` or `model_nmm` of the scene
    type(kinematics_t), intent(in) :: element
    real(dp), intent(in) :: unknown(n)
    real(dp) :: d(n)
    complex(dp) :: moved, pivot, z

    d = unknown
    if (model /= model_dda) return
    z = cmplx(0.5_dp*(d(4) + d(5)), d(3), dp)
    moved = cmplx(d(1), d(2), dp)
    if (abs(moved) < near*sqrt(element%area)*abs(z)) then
      pivot = -moved/z                     ! from the centroid
      moved = pivot + (moved - pivot)/abs(1 + z)
    end if
    z = (1 + z)/abs(1 + z) - 1
    d(1:2) = [real(moved), aimag(moved)]
    d(4:5) = d(4:5) + (real(z) - 0.5_dp*(d(4) + d(5)))
    d(3) = aimag(z)
  end function kept_distance

  !> Rates of the unknowns of element `e` in a rigid motion.
  pure function rigid_velocity(system, state, e, about, velocity) result(rates)
    class(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    integer, intent(in) :: e
    real(dp), intent(in) :: about(2)    !! centre of the motion, the centroid of the block, length
    real(dp), intent(in) :: velocity(3) !! vx, vy of the centre, rotation rate
    real(dp) :: rates(n), arm(2)
    integer :: k

    if (system%model == model_dda) then
      rates = [velocity, 0.0_dp, 0.0_dp, 0.0_dp]
    else if (allocated(system%sampling)) then
      arm = matmul(state%cover(:, system%elements%cover(:, e)), system%sampling%value(:, e)) - about
      rates = [velocity(1:2) + velocity(3)*[-arm(2), arm(1)], velocity(3), 0.0_dp, 0.0_dp, 0.0_dp]
    else
      do k = 1, 3
        arm = state%cover(:, system%elements%cover(k, e)) - about
        rates(2*k - 1:2*k) = velocity(1:2) + velocity(3)*[-arm(2), arm(1)]
      end do
    end if
  end function rigid_velocity

  !> Rates of the unknowns of element `e`, where a displacement brings it, in unit motions: along x, along y, and turning about a
  !> place.
  pure function rigid_modes(system, state, e, element, displacement, about) result(modes)
    class(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    integer, intent(in) :: e
    type(kinematics_t), intent(in) :: element
    real(dp), intent(in) :: displacement(n) !! of the unknowns
    real(dp), intent(in) :: about(2)        !! length
    real(dp) :: modes(n, 3), arm(2), F(4)
    integer :: k

    modes = 0.0_dp
    if (system%model == model_dda) then
      F = [1.0_dp, 0.0_dp, 0.0_dp, 1.0_dp] + matmul(element%gradient, displacement)
      arm = element%centroid + displacement(1:2) - about
      modes(1, 1) = 1.0_dp
      modes(2, 2) = 1.0_dp
      modes(:, 3) = [-arm(2), arm(1), 0.5_dp*(F(1) + F(4)), -F(2), F(3), F(1) - F(4)]
    else
      do k = 1, 3
        arm = state%cover(:, system%elements%cover(k, e)) + displacement(2*k - 1:2*k) - about
        modes(2*k - 1, :) = [1.0_dp, 0.0_dp, -arm(2)]
        modes(2*k, :) = [0.0_dp, 1.0_dp, arm(1)]
      end do
    end if
  end function rigid_modes

  !> Rates of the unknowns (velocity or acceleration) of one element in the new configuration.
  !>
  !> The rates of covers are vectors at points and stay the same. Those of a DDA block are re-based on the moved centroid. Either
  !> the vector field stays, so its gradient becomes L F^-1. Or the six numbers stay, as in Shi's programs, where a turning block
  !> then never feels the centrifugal stress.
  pure function carried_rates(model, transport, F, rates) result(carried)
    integer, intent(in) :: model, transport
    real(dp), intent(in) :: F(4)           !! of the step: xx, yx, xy, yy
    real(dp), intent(in) :: rates(n)
    real(dp) :: carried(n), old(4), new(4), det

    carried = rates
    if (model /= model_dda .or. transport == transport_rates) return
    old = [rates(4), rates(3) + 0.5_dp*rates(6), -rates(3) + 0.5_dp*rates(6), rates(5)]
    det = F(1)*F(4) - F(2)*F(3)
    new(1:2) = (old(1:2)*F(4) - old(3:4)*F(2))/det
    new(3:4) = (old(3:4)*F(1) - old(1:2)*F(3))/det
    carried(3:) = [0.5_dp*(new(2) - new(3)), new(1), new(4), new(2) + new(3)]
  end function carried_rates

  !> Rates of the unknowns of one element whose field turns by an angle, without its vectors being moved: a becomes b + Q (a - b).
  pure function turned_rates(model, angle, base, rates) result(turned)
    integer, intent(in) :: model         !! `model_dda` or `model_nmm` of the scene
    real(dp), intent(in) :: angle        !! rad
    real(dp), intent(in) :: base(2)      !! b, the vector that stays
    real(dp), intent(in) :: rates(n)
    real(dp) :: turned(n), Q(2, 2), L(2, 2)
    integer :: k

    if (model == model_dda) then
      Q = turn(angle)
      L(:, 1) = [rates(4), rates(3) + 0.5_dp*rates(6)]
      L(:, 2) = [-rates(3) + 0.5_dp*rates(6), rates(5)]
      L = matmul(Q, L)
      turned = [base + matmul(Q, rates(1:2) - base), 0.5_dp*(L(2, 1) - L(1, 2)), L(1, 1), L(2, 2), L(2, 1) + L(1, 2)]
    else
      do k = 1, 3
        turned(2*k - 1:2*k) = turned_vector(angle, base, rates(2*k - 1:2*k))
      end do
    end if
  end function turned_rates

  !> A vector that turns by an angle about another: a becomes b + Q (a - b).
  pure function turned_vector(angle, base, vector) result(turned)
    real(dp), intent(in) :: angle              !! rad
    real(dp), intent(in) :: base(2), vector(2) !! b, a
    real(dp) :: turned(2)

    turned = base + matmul(turn(angle), vector - base)
  end function turned_vector

  !> Q of a turn.
  pure function turn(angle) result(Q)
    real(dp), intent(in) :: angle              !! rad
    real(dp) :: Q(2, 2)

    Q = reshape([cos(angle), sin(angle), -sin(angle), cos(angle)], [2, 2])
  end function turn

end module scree_interpolation
