!> Damping in proportion to mass and velocity.
module scree_mass_damping
  use scree_element_term, only: add_force, step_rule_t, term_t
  use scree_integrator, only: velocity_at_balance
  use scree_kinds, only: dp
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: add_mass_damping, damped_energy, mass_damping_t

  integer, parameter :: n = element_unknowns

  !> Called for by a rate above zero.
  type :: mass_damping_t
    real(dp) :: rate = 0.0_dp !! alpha of the force -alpha M v, 1/time
  end type mass_damping_t

contains

  !> Adds -alpha M v, with the velocity at the time of the balance.
  pure subroutine add_mass_damping(self, M, velocity, acceleration, unknown, rule, term)
    type(mass_damping_t), intent(in) :: self
    real(dp), intent(in) :: M(n, n)                      !! consistent, mass/length
    real(dp), intent(in) :: velocity(n), acceleration(n) !! at the beginning of the step
    real(dp), intent(in) :: unknown(n)                   !! of the step so far
    type(step_rule_t), intent(in) :: rule
    type(term_t), intent(inout) :: term
    real(dp) :: c, carried(n)

    call velocity_at_balance(rule, velocity, acceleration, c, carried)
    term%matrix = term%matrix + self%rate*c*M
    call add_force(term, -self%rate*matmul(M, carried))
    call add_force(term, -self%rate*c*matmul(M, unknown))
  end subroutine add_mass_damping

  !> Energy that a step loses, alpha d^T M d / dt, force per unit thickness times length: never below zero.
  pure real(dp) function damped_energy(self, M, unknown, dt)
    type(mass_damping_t), intent(in) :: self
    real(dp), intent(in) :: M(n, n)    !! consistent, mass/length
    real(dp), intent(in) :: unknown(n) !! of the step
    real(dp), intent(in) :: dt         !! time

    damped_energy = self%rate*dot_product(unknown, matmul(M, unknown))/dt
  end function damped_energy

end module scree_mass_damping
