!> What the effects add to one element in one iteration.
module scree_element_term
  use scree_kinds, only: dp
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: add_force, step_rule_t, term_t

  integer, parameter :: n = element_unknowns

  !> Matrix and forces of one element, summed over its effects.
  type :: term_t
    real(dp) :: matrix(n, n) = 0.0_dp !! operator of this iteration, force/length per unit thickness
    real(dp) :: force(n) = 0.0_dp     !! out of balance: loads less inertia less internal forces
    real(dp) :: scale(n) = 0.0_dp     !! sum of the magnitudes of the forces that balance
    real(dp) :: noise(n) = 0.0_dp     !! magnitude of what cancelled in them: round-off is its epsilon
  end type term_t

  !> The integrator in one step: four weights (doc/theory.md, section 3).
  type :: step_rule_t
    real(dp) :: dt = 0.0_dp               !! time
    real(dp) :: velocity_weight = 1.0_dp  !! beta of Zhang et al. 2019
    real(dp) :: displacement_weight = 0.5_dp !! gamma of Zhang et al. 2019
    real(dp) :: stress_weight = 1.0_dp    !! share of the step's stress increment in the balance
    real(dp) :: operator_weight = 1.0_dp  !! omega in B0 + omega A(theta): 1 end of step, 1/2 energy-momentum
    real(dp) :: load_from = 0.0_dp        !! the balance takes loads and the ground with their means from here
    real(dp) :: load_to = 0.0_dp          !! to here
    real(dp) :: end_time = 0.0_dp         !! of the step
    logical :: tangent = .false.          !! operator of the iteration: tangent, else secant
  end type step_rule_t

contains

  !> Adds one force to the balance.
  pure subroutine add_force(term, force, noise)
    type(term_t), intent(inout) :: term
    real(dp), intent(in) :: force(n)
    real(dp), intent(in), optional :: noise(n) !! magnitude of what cancelled in it; |force| where absent

    term%force = term%force + force
    term%scale = term%scale + abs(force)
    if (present(noise)) then
      term%noise = term%noise + noise
    else
      term%noise = term%noise + abs(force)
    end if
  end subroutine add_force

end module scree_element_term
