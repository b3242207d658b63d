!> Consistent inertia of the elements (Shi's df11).
module scree_inertia
  use scree_element_term, only: add_force, step_rule_t, term_t
  use scree_interpolation, only: kinematics_t
  use scree_kinds, only: dp
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: add_inertia, kinetic_energy, mass_matrix, momentum

  integer, parameter :: n = element_unknowns

contains

  !> Integral of rho T^T T over an element: m T(c)^T T(c) + rho G^T [Sxx I, Sxy I; Sxy I, Syy I] G, exact.
  pure function mass_matrix(element, mass) result(M)
    type(kinematics_t), intent(in) :: element
    real(dp), intent(in) :: mass !! mass/length
    real(dp) :: M(n, n), SG(4, n)

    if (.not. mass > 0) then ! what has none may have no area either
      M = 0.0_dp
      return
    end if
    associate (G => element%gradient, S => element%second, T => element%at_centroid)
      SG(1:2, :) = S(1)*G(1:2, :) + S(3)*G(3:4, :)
      SG(3:4, :) = S(3)*G(1:2, :) + S(2)*G(3:4, :)
      M = mass*(matmul(transpose(T), T) + matmul(transpose(G), SG)/element%area)
    end associate
  end function mass_matrix

  !> Adds M / (gamma dt^2) to the matrix, and the forces of the acceleration of the step.
  !>
  !> The acceleration is a = (d - v dt) / (gamma dt^2) - (1/2 - gamma)/gamma a0 (Zhang et al. 2019, Eq. 5; Shi: 2 M/dt^2, 2 M v/dt).
  !> Where the balance takes a fraction of it, the rest is that of a0.
  pure subroutine add_inertia(M, velocity, acceleration, unknown, rule, term)
    real(dp), intent(in) :: M(n, n)
    real(dp), intent(in) :: velocity(n), acceleration(n) !! at the beginning of the step
    real(dp), intent(in) :: unknown(n)                   !! of the step so far
    type(step_rule_t), intent(in) :: rule
    type(term_t), intent(inout) :: term
    real(dp) :: c, carried(n)

    associate (gamma => rule%displacement_weight)
      c = rule%inertia_weight/(gamma*rule%dt**2)
      carried = c*rule%dt*velocity + (rule%inertia_weight*rule%carried_weight/gamma - (1 - rule%inertia_weight))*acceleration
    end associate
    term%matrix = term%matrix + c*M
    call add_force(term, times(M, carried))
    call add_force(term, -c*times(M, unknown))
  end subroutine add_inertia

  !> M x, without the call of a library that a product of this size costs most of.
  pure function times(M, x) result(y)
    real(dp), intent(in) :: M(n, n)
    real(dp), intent(in) :: x(n)
    real(dp) :: y(n)
    integer :: j

    y = 0.0_dp
    do j = 1, n
      y = y + M(:, j)*x(j)
    end do
  end function times

  !> v^T M v / 2, force per unit thickness.
  pure real(dp) function kinetic_energy(M, velocity)
    real(dp), intent(in) :: M(n, n)
    real(dp), intent(in) :: velocity(n)

    kinetic_energy = 0.5_dp*dot_product(velocity, times(M, velocity))
  end function kinetic_energy

  !> Linear momentum, and angular momentum about the origin: x, y, mass/time; mass length/time.
  pure function momentum(element, mass, velocity) result(p)
    type(kinematics_t), intent(in) :: element
    real(dp), intent(in) :: mass
    real(dp), intent(in) :: velocity(n)
    real(dp) :: p(3), L(4)

    if (.not. mass > 0) then ! likewise
      p = 0.0_dp
      return
    end if
    p(1:2) = mass*matmul(element%at_centroid, velocity)
    L = matmul(element%gradient, velocity)
    associate (S => element%second, c => element%centroid)
      p(3) = c(1)*p(2) - c(2)*p(1) &
             + mass/element%area*(S(1)*L(2) + S(3)*L(4) - S(3)*L(1) - S(2)*L(3))
    end associate
  end function momentum

end module scree_inertia
