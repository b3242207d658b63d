!> Groups of elements that are settled together in a step, and the progress of their iteration.
module scree_iteration
  use scree_anderson, only: anderson_t
  use scree_contact_rules, only: iteration_rules_t
  use scree_element_term, only: term_t
  use scree_flickering, only: flickering_t
  use scree_kinds, only: dp
  implicit none
  private
  public :: element_group_t, iteration_t, linearisation_t

  !> Elements that are settled together, and the kind of their equations.
  type :: element_group_t
    integer :: number = 0                     !! among the groups of the equations
    integer, allocatable :: member(:)         !! elements
    logical :: linear = .true.                !! forces and gaps are linear in displacements: small strain alone, or explicit
    logical :: in_contact = .false.
    logical :: bolted = .false.
    logical :: smooth = .false.               !! the prediction includes their acceleration
    logical :: may_end_early = .false.        !! the iteration may end with a fraction of the error of the step
    logical :: may_stray = .false.            !! areas of iterates may leave their bounds, as only the next iterate depends on them
    logical :: nested = .false.               !! contacts settle anew for each linearisation of the deformation
    type(iteration_rules_t) :: open_close     !! how contacts are judged
  end type element_group_t

  !> The last linearisation of the equations of a group.
  type :: linearisation_t
    logical :: frozen = .false.               !! it is kept until contacts have settled for it
    logical :: symmetric = .true.             !! the operator is
    type(term_t), allocatable :: term(:)      !! (n_members) where it may be kept
    real(dp), allocatable :: at(:, :)         !! (n, n_members) displacement about which each was made
  end type linearisation_t

  !> Progress of the iteration of a group.
  type :: iteration_t
    integer :: number = 0                     !! of the iterate, counted anew when multipliers have changed
    type(linearisation_t) :: linearisation
    type(anderson_t) :: mixing                !! of corrections by the secant
    real(dp), allocatable :: reference(:, :)  !! (n, n_members) displacement from which changes are measured
    real(dp) :: first_change = 0.0_dp         !! of theta by the first correction, if the group may end early; else 0
    integer :: worst = 0                      !! element that the last correction changed most
    logical :: corrected = .false.            !! the step has had a correction
    logical :: likely_to_change = .false.     !! many contacts changed, or are likely to: the iteration is far from the solution
    logical :: judged = .true.                !! contacts have been judged at the present displacement
    logical :: keeps_states = .false.         !! contacts are not judged after the first correction, because bodies turn
    logical :: in_doubt = .false.             !! everything has settled except contacts that the last judgement changed
    integer :: fewest_changes = huge(1)       !! of states that one judgement has made so far
    integer :: stalled = 0                    !! judgements since then
    real(dp), allocatable :: best(:, :)       !! (n, n_members) displacement at that judgement
    integer :: fewest_tried = huge(1)         !! `fewest_changes` when a friction problem was last posed from `best`
    type(flickering_t) :: flickering          !! contacts whose states keep changing
    integer :: rounds = 0                     !! friction problems that were solved
    integer :: repeats = 0                    !! friction problems whose solution moved nothing, since multipliers have changed
    integer :: by_secant = 0                  !! friction problems posed with the secant operator
    logical :: after_problem = .false.        !! a friction problem of the step has been solved: the solution is near
    real(dp), allocatable :: start_of_round(:, :) !! (n, n_members) displacement that the iteration, or its last round, began with
  end type iteration_t

end module scree_iteration
