!> Which contact is to blame where contacts do not settle.
module scree_contact_blame
  use scree_contact_quantities, only: gap_and_slip_t
  use scree_contact_rules, only: gaps_and_slips
  use scree_contact_try, only: contact_try_t, states_of
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_state, only: state_t
  use scree_step_try, only: cut_by_contacts, outcome_t, reject
  use scree_text, only: number_text
  implicit none
  private
  public :: reject_contacts

contains

  !> Rejects a try whose contacts did not settle: of those that the last judgement changed the one that presses most is to blame.
  subroutine reject_contacts(model, state, contacts, before, d, outcome)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(contact_try_t), intent(in) :: contacts
    integer, intent(in) :: before(:, :) !! (2, n_contacts) states of their entrances before the last judgement
    real(dp), intent(in) :: d(:)
    type(outcome_t), intent(inout) :: outcome
    integer :: now(2, size(before, 2)), i, number, worst
    type(gap_and_slip_t) :: apart(2)
    real(dp) :: deepest, gap

    now = states_of(contacts)
    deepest = -huge(deepest)
    worst = 0
    do i = 1, size(now, 2)
      if (all(now(:, i) == before(:, i))) cycle
      number = contacts%first + i - 1
      apart = gaps_and_slips(model, contacts, number, d)
      gap = maxval(apart(:contacts%contact(number)%n_entrances)%gap)
      if (-gap <= deepest) cycle
      deepest = -gap
      worst = number
    end do
    call reject(outcome, cut_by_contacts, 'contacts did not settle in '//number_text(outcome%iterations)// &
                ' open-close iterations, '//number_text(contacts%changes)//' still change', &
                'another contact.stiffness, contact.viscosity, or a smaller step.least', 0)
    if (worst == 0) return
    associate (entrance => contacts%contact(worst)%entrance(contacts%contact(worst)%active), outlines => model%outlines)
      outcome%trouble%element = outlines%element(entrance%vertex)
      outcome%trouble%against = outlines%element(entrance%edge)
      outcome%trouble%position = state%vertex(:, outlines%start(entrance%vertex))
    end associate
  end subroutine reject_contacts

end module scree_contact_blame
