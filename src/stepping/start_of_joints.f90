!> Joints that bear the stress before the run when it begins.
module scree_start_of_joints
  use scree_contact_acceptance, only: accept_contacts
  use scree_contact_beginning, only: begin_contacts
  use scree_contact_detection, only: find_contacts
  use scree_contact_rules, only: place
  use scree_contact_try, only: contact_try_t
  use scree_contacts, only: contact_search_t, count_states
  use scree_integrator, only: rule_at_rest
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_pair_effects, only: list_coupled_pairs
  use scree_state, only: state_t
  use scree_stressed_joints, only: begin_stressed
  implicit none
  private
  public :: stress_joints

contains

  !> Gives the state the contacts between faces that lie on each other, with the forces of the stress before the run.
  subroutine stress_joints(model, cache, state)
    type(model_t), intent(in) :: model             !! whose outlines have that stress
    type(cache_t), intent(in) :: cache             !! of the state
    type(state_t), intent(inout) :: state          !! in which a run begins, without contacts
    type(contact_try_t) :: try
    real(dp) :: d(model%n_unknowns), friction, fracture
    integer :: i

    d = 0.0_dp
    call look_at_rest(model, cache, state, try)
    call accept_contacts(model, d, try, state%contacts, state%books%contact_springs, friction, fracture)
    call look_at_rest(model, cache, state, try) ! bonds decide which corners have a contact in common
    do i = 1, size(try%contact)
      call begin_stressed(model%outlines, state%vertex, try%law, try%contact(i))
    end do
    call place(model, cache, state, d, try)
    try%count = count_states(try%contact)
    call accept_contacts(model, d, try, state%contacts, state%books%contact_springs, friction, fracture)
  end subroutine stress_joints

  !> Finds the contacts of a state at rest, as its first step does.
  subroutine look_at_rest(model, cache, state, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache             !! of the state
    type(state_t), intent(in) :: state
    type(contact_try_t), intent(out) :: try
    type(contact_search_t) :: search
    real(dp) :: at_rest(2, size(model%outlines%start))

    try%law = model%effects%contact
    at_rest = 0.0_dp
    call find_contacts(model%outlines, state%vertex, at_rest, model%n_elements > model%n_blocks, state%contacts, search, try)
    call list_coupled_pairs(model, state, try)
    call begin_contacts(model, cache, state, rule_at_rest(state%time, 1.0_dp), try)
    try%count = count_states(try%contact)
  end subroutine look_at_rest

end module scree_start_of_joints
