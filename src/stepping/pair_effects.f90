!> The effects between two elements, of one body or two. This file is the only one that asks which are present.
!>
!> An effect names the pairs of elements that it acts between, and adds a term to each; the loop, the scatter and the pattern of the
!> equations are the same for all.
module scree_pair_effects
  use scree_contact_forces, only: add_contacts_of_pair, closed_contacts, closed_contacts_t
  use scree_contact_pairs, only: number_pairs, pairs_of_contacts
  use scree_contact_try, only: contact_try_t
  use scree_element_term, only: clear_pair_term, pair_term_t
  use scree_equations, only: add_pair, equations_t
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_pairs, only: list_pairs
  use scree_state, only: state_t
  implicit none
  private
  public :: add_pair_effects, couples_pairs, list_coupled_pairs

contains

  !> Whether a scene calls for an effect between two elements.
  pure logical function couples_pairs(model)
    type(model_t), intent(in) :: model

    couples_pairs = allocated(model%effects%contact)
  end function couples_pairs

  !> Lists the pairs of elements that something acts between in a step. Contacts are told the number of theirs.
  pure subroutine list_coupled_pairs(model, state, contacts)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(contact_try_t), intent(inout) :: contacts !! as they are found
    integer, allocatable :: needed(:, :)

    needed = reshape([integer ::], [2, 0])
    if (allocated(model%effects%contact)) needed = pairs_of_contacts(model%outlines%element, contacts%contact)
    contacts%pair = list_pairs(needed, state%pair)
    if (allocated(model%effects%contact)) call number_pairs(model%outlines%element, contacts%pair, contacts%contact)
  end subroutine list_coupled_pairs

  !> Adds every present effect between two elements to the equations.
  subroutine add_pair_effects(model, contacts, symmetric, d, equations)
    type(model_t), intent(in) :: model
    type(contact_try_t), intent(in) :: contacts
    logical, intent(in) :: symmetric            !! the operator is to be, but for friction
    real(dp), intent(in) :: d(:)                !! (n_unknowns) of the step so far
    type(equations_t), intent(inout) :: equations
    type(closed_contacts_t) :: closed
    type(pair_term_t) :: term
    integer :: p

    if (.not. couples_pairs(model)) return
    closed = closed_contacts(contacts)
    do p = 1, size(contacts%pair, 2)
      associate (of_pair => closed%contact(closed%first(p):closed%first(p + 1) - 1))
        if (size(of_pair) == 0) cycle
        call clear_pair_term(term)
        call add_contacts_of_pair(model, contacts, p, of_pair, d, symmetric, term)
        call add_pair(equations, p, term)
      end associate
    end do
  end subroutine add_pair_effects

end module scree_pair_effects
