!> Damping in proportion to the stiffness and to the rate of strain, beside damping in proportion to mass (Rayleigh damping).
!>
!> The rock bears the viscous stress beta D de/dt beside the elastic stress. With the velocity v = c d + v0 at the time of the
!> balance it is beta c D e(d) + beta D B0 v0. So an element is damped by a larger weight of the strain e(d) of the step, and by a
!> larger stress at its beginning, in whatever strain its step has. A block that turns without strain is not damped.
module scree_stiffness_damping
  use scree_element_term, only: step_rule_t
  use scree_green_strain, only: green_strain
  use scree_integrator, only: velocity_at_balance
  use scree_interpolation, only: kinematics_t
  use scree_kinds, only: dp
  use scree_stiffness, only: small_strain, small_strain_operator
  use scree_strain_rotation, only: strain_beside_rotation
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: add_viscous_stress, stiffness_damping_t, strain_loss, viscous_force

  integer, parameter :: n = element_unknowns

  !> Called for by a time above zero.
  type :: stiffness_damping_t
    real(dp) :: time = 0.0_dp !! beta of the stress beta D de/dt, time
  end type stiffness_damping_t

contains

  !> Adds the viscous stress of a step to the stress at its beginning and to the weight of its strain.
  pure subroutine add_viscous_stress(self, element, D, velocity, acceleration, stress, rule)
    type(stiffness_damping_t), intent(in) :: self
    type(kinematics_t), intent(in) :: element
    real(dp), intent(in) :: D(3, 3)                      !! elasticity, force/length^2
    real(dp), intent(in) :: velocity(n), acceleration(n) !! at the beginning of the step
    real(dp), intent(inout) :: stress(3)                 !! that balances there, force/length^2
    type(step_rule_t), intent(inout) :: rule             !! whose elastic forces are those of its end, in part or whole
    real(dp) :: c, carried(n)

    call velocity_at_balance(rule, velocity, acceleration, c, carried)
    stress = stress + self%time*matmul(D, matmul(small_strain_operator(element), carried))
    rule%stress_weight = rule%stress_weight + self%time*c/rule%end_weight
  end subroutine add_viscous_stress

  !> Force of the viscous stress of a velocity on the unknowns of an element.
  pure function viscous_force(self, element, D, velocity) result(force)
    type(stiffness_damping_t), intent(in) :: self
    type(kinematics_t), intent(in) :: element
    real(dp), intent(in) :: D(3, 3)    !! elasticity, force/length^2
    real(dp), intent(in) :: velocity(n)
    real(dp) :: force(n), B(3, n)

    B = small_strain_operator(element)
    force = -self%time*element%area*matmul(matmul(D, matmul(B, velocity)), B)
  end function viscous_force

  !> Energy that a step loses, beta A e^T D e/dt with its strain e, force per unit thickness times length: never below zero.
  pure real(dp) function strain_loss(self, element, D, green, decomposed, unknown, dt) result(loss)
    type(stiffness_damping_t), intent(in) :: self
    type(kinematics_t), intent(in) :: element
    real(dp), intent(in) :: D(3, 3)    !! elasticity, force/length^2
    logical, intent(in) :: green       !! the step took Green strain, or what stands in for it
    logical, intent(in) :: decomposed  !! the strain beside a rotation stands in for it
    real(dp), intent(in) :: unknown(n) !! of the step
    real(dp), intent(in) :: dt         !! time
    real(dp) :: strain(3), theta(4)

    theta = matmul(element%gradient, unknown)
    if (.not. green) then
      strain = small_strain(theta)
    else if (decomposed) then
      strain = strain_beside_rotation(theta)
    else
      strain = green_strain(theta)
    end if
    loss = self%time*element%area*dot_product(strain, matmul(D, strain))/dt
  end function strain_loss

end module scree_stiffness_damping
