!> Which contact is to blame where contacts do not settle.
module scree_contact_blame
  use scree_contact_quantities, only: gap_and_slip_t
  use scree_contact_rules, only: gaps_and_slips
  use scree_contact_try, only: states_of
  use scree_contacts, only: contact_t
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_state, only: state_t
  use scree_step_try, only: cut_by_contacts, reject, try_t
  use scree_text, only: number_text
  use scree_trouble, only: trouble_t
  implicit none
  private
  public :: blame_contact, reject_contacts

contains

  !> Rejects a try whose contacts did not settle: of those that the last judgement changed the one that presses most is to blame.
  subroutine reject_contacts(model, state, before, try)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: before(:, :) !! (2, n_contacts) states of their entrances before the last judgement
    type(try_t), intent(inout) :: try
    integer :: now(2, size(before, 2)), i, number, worst
    type(gap_and_slip_t) :: apart(2)
    real(dp) :: deepest, gap

    now = states_of(try%contacts)
    deepest = -huge(deepest)
    worst = 0
    do i = 1, size(now, 2)
      if (all(now(:, i) == before(:, i))) cycle
      number = try%contacts%first + i - 1
      apart = gaps_and_slips(model, try%contacts, number, try%d)
      gap = maxval(apart(:try%contacts%contact(number)%n_entrances)%gap)
      if (-gap <= deepest) cycle
      deepest = -gap
      worst = number
    end do
    call reject(try%outcome, cut_by_contacts, 'contacts did not settle in '//number_text(try%outcome%iterations)// &
                ' open-close iterations, '//number_text(try%contacts%changes)//' still change', &
                'another contact.stiffness, contact.viscosity, or a smaller step.least', 0)
    if (worst > 0) call blame_contact(model, state, try%contacts%contact(worst), try%outcome%trouble)
  end subroutine reject_contacts

  !> Tells the place of a trouble by a contact.
  pure subroutine blame_contact(model, state, contact, trouble)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(contact_t), intent(in) :: contact
    type(trouble_t), intent(inout) :: trouble

    associate (entrance => contact%entrance(contact%active), outlines => model%outlines)
      trouble%element = outlines%of_vertex(entrance%vertex)
      trouble%against = outlines%element(entrance%edge)
      trouble%position = state%vertex(:, outlines%start(entrance%vertex))
    end associate
  end subroutine blame_contact

end module scree_contact_blame
