!> What settles together in a step, and how its iteration gets on.
module scree_iteration
  use scree_anderson, only: anderson_t
  use scree_contact_rules, only: iteration_rules_t
  use scree_element_term, only: term_t
  use scree_flickering, only: flickering_t
  use scree_kinds, only: dp
  implicit none
  private
  public :: group_t, iteration_t, linearisation_t

  !> Elements that are settled together: what kind of equations they have.
  type :: group_t
    integer :: number = 0                     !! among the groups of the equations
    integer, allocatable :: member(:)         !! elements
    logical :: linear = .true.                !! forces and gaps are linear in displacements: small strain alone, or explicit
    logical :: in_contact = .false.
    logical :: bolted = .false.
    logical :: smooth = .false.               !! they begin with their acceleration
    logical :: may_end_early = .false.        !! their end may leave a fraction of what the step is off by
    logical :: may_stray = .false.            !! iterates may leave what areas may change by, as nothing hangs on them but the next
    logical :: nested = .false.               !! contacts settle for each operator of the deformation
    type(iteration_rules_t) :: open_close     !! how contacts are judged
  end type group_t

  !> The equations of a group's elements as they were linearised last.
  type :: linearisation_t
    logical :: frozen = .false.               !! it stays, as contacts have not yet settled for it
    logical :: symmetric = .true.             !! the operator is
    type(term_t), allocatable :: term(:)      !! (n_members) where it may stay
    real(dp), allocatable :: at(:, :)         !! (n, n_members) displacements of these, likewise
  end type linearisation_t

  !> How the iteration of a group gets on.
  type :: iteration_t
    integer :: number = 0                     !! of the iterate, since contacts were held last
    type(linearisation_t) :: linearisation
    type(anderson_t) :: mixing                !! of corrections by the secant
    real(dp), allocatable :: reference(:, :)  !! (n, n_members) displacement from which changes are measured
    real(dp) :: first_change = 0.0_dp         !! of theta by the first correction, of those that may end early; 0: no longer
    integer :: worst = 0                      !! element that the last correction changed most
    logical :: far = .false.                  !! from the solution: contacts changed, or are likely to
    logical :: judged = .true.                !! contacts were, where the displacement is
    logical :: keeps_states = .false.         !! contacts are not judged after the first correction, as bodies turn
    logical :: in_doubt = .false.             !! all has settled but for contacts that the judgement changed
    integer :: fewest_changes = huge(1)       !! of states, in a judgement
    integer :: stalled = 0                    !! judgements since, that did not change fewer
    real(dp), allocatable :: best(:, :)       !! (n, n_members) displacement at which that was judged
    integer :: followed = huge(1)             !! fewest changes from which a path was followed
    type(flickering_t) :: flickering          !! contacts that go on changing
    integer :: rounds = 0                     !! friction problems that were solved
    integer :: repeats = 0                    !! of these, that moved nothing
    integer :: by_secant = 0                  !! friction problems that the secant posed
    logical :: near = .false.                 !! to the solution: a friction problem ended there
    real(dp), allocatable :: sound(:, :)      !! (n, n_members) displacement that the iteration, or its last round, began with
  end type iteration_t

end module scree_iteration
