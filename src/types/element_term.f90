!> Terms that the effects add to one element, or to a pair of elements, in one iteration.
module scree_element_term
  use scree_kinds, only: dp
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: add_change, add_force, add_friction_change, add_pair_force, clear_pair_term, leave_symmetry, pair_term_t, step_rule_t, &
            term_t

  integer, parameter :: n = element_unknowns

  !> Matrix and forces of one element, summed over its effects.
  type :: term_t
    logical :: symmetric = .true.     !! the matrix is, but for round-off; what adds one that is not says so
    real(dp) :: matrix(n, n) = 0.0_dp !! operator of this iteration, force/length per unit thickness
    real(dp) :: force(n) = 0.0_dp     !! out of balance: loads less inertia less internal forces
    real(dp) :: scale(n) = 0.0_dp     !! sum of the magnitudes of the forces that balance
    real(dp) :: noise(n) = 0.0_dp     !! magnitude of what cancelled in them: round-off is its epsilon
  end type term_t

  !> Matrix and forces between two elements, summed over the effects between them: the unknowns of the first, then of the second.
  type :: pair_term_t
    logical :: symmetric = .true.         !! the matrix is, but for round-off; what adds one that is not says so (`leave_symmetry`)
    real(dp) :: matrix(2*n, 2*n) = 0.0_dp !! operator of this iteration, force/length per unit thickness
    real(dp) :: friction(2*n, 2*n)        !! of it, what friction changes by with the forces across; where it is not symmetric
    real(dp) :: force(2*n) = 0.0_dp       !! out of balance
    real(dp) :: scale(2*n) = 0.0_dp       !! sum of the magnitudes of the forces
  end type pair_term_t

  !> The integrator in one step: its weights (doc/theory/integrators.md, eq-newmark).
  type :: step_rule_t
    real(dp) :: dt = 0.0_dp               !! time
    real(dp) :: velocity_weight = 1.0_dp  !! beta of Zhang et al. 2019
    real(dp) :: displacement_weight = 0.5_dp !! gamma of Zhang et al. 2019
    real(dp) :: carried_weight = 0.0_dp   !! of the old acceleration in the displacement; 1/2 - gamma where steps are equal
    real(dp) :: handed_weight = 1.0_dp    !! of the new acceleration in that which is handed on; the rest is the old one
    real(dp) :: stress_weight = 1.0_dp    !! fraction of the step's stress increment in the balance
    real(dp) :: operator_weight = 1.0_dp  !! omega in B0 + omega A(theta): 1 end of step, 1/2 energy-momentum
    real(dp) :: inertia_weight = 1.0_dp   !! fraction of the end in the inertia that balances; the rest is that of the beginning
    real(dp) :: end_weight = 1.0_dp       !! likewise in the elastic forces
    real(dp) :: lag = 0.5_dp              !! of what balances, loads and damping, behind the end of the step; over its size
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

  !> Adds one force between two elements to the balance.
  pure subroutine add_pair_force(term, force)
    type(pair_term_t), intent(inout) :: term
    real(dp), intent(in) :: force(2*n)

    term%force = term%force + force
    term%scale = term%scale + abs(force)
  end subroutine add_pair_force

  !> Adds the change of friction along `row` with the unknowns of both elements, by the normal forces on which it depends.
  pure subroutine add_friction_change(term, row, change)
    type(pair_term_t), intent(inout) :: term
    real(dp), intent(in) :: row(2*n), change(2*n)
    integer :: j

    call leave_symmetry(term)
    call add_change(term, row, change)
    do j = 1, 2*n
      term%friction(:, j) = term%friction(:, j) - change(j)*row
    end do
  end subroutine add_friction_change

  !> Clears the sums of a pair.
  pure subroutine clear_pair_term(term)
    type(pair_term_t), intent(inout) :: term

    term%symmetric = .true.
    term%matrix = 0.0_dp
    term%force = 0.0_dp
    term%scale = 0.0_dp
  end subroutine clear_pair_term

  !> Says that the matrix of a pair is not symmetric.
  pure subroutine leave_symmetry(term)
    type(pair_term_t), intent(inout) :: term

    if (term%symmetric) term%friction = 0.0_dp
    term%symmetric = .false.
  end subroutine leave_symmetry

  !> Adds the change of a force along `row` with the unknowns of both elements: `change` for a unit along the row.
  pure subroutine add_change(term, row, change)
    type(pair_term_t), intent(inout) :: term
    real(dp), intent(in) :: row(2*n), change(2*n)
    integer :: j

    do j = 1, 2*n
      term%matrix(:, j) = term%matrix(:, j) - change(j)*row
    end do
  end subroutine add_change

end module scree_element_term
