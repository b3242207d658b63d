!> The effects between two elements, of one body or two. This file is the only one that asks which are present.
!>
!> An effect names the pairs of elements that it acts between, and adds a term to each; the loop, the scatter and the pattern of the
!> equations are the same for all.
module scree_pair_effects
  use scree_contact_forces, only: add_contacts_of_pair, closed_contacts, closed_contacts_t
  use scree_contact_pairs, only: number_pairs, pairs_of_contacts
  use scree_contact_try, only: contact_try_t
  use scree_element_term, only: clear_pair_term, pair_term_t
  use scree_equations, only: add_pair, equations_t, pairs_of_group
  use scree_grouping, only: sort_into
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_pairs, only: list_pairs
  use scree_state, only: state_t
  implicit none
  private
  public :: add_pair_effects, couples_pairs, list_coupled_pairs, order_contacts

contains

  !> Whether a scene calls for an effect between two elements.
  pure logical function couples_pairs(model)
    type(model_t), intent(in) :: model

    couples_pairs = allocated(model%effects%contact)
  end function couples_pairs

  !> Puts the contacts in the order of the islands of their pairs.
  pure subroutine order_contacts(equations, contacts)
    type(equations_t), intent(in) :: equations
    type(contact_try_t), intent(inout) :: contacts
    integer, allocatable :: order(:)
    integer :: i

    call sort_into([(equations%island_of(contacts%contact(i)%entrance(1)%pair), i=1, size(contacts%contact))], &
                   size(equations%at), contacts%of_island, order)
    if (all(order == [(i, i=1, size(order))])) return
    contacts%contact = contacts%contact(order)
  end subroutine order_contacts

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

  !> Adds every present effect between two elements of an island to its equations.
  subroutine add_pair_effects(model, contacts, group, symmetric, d, equations)
    type(model_t), intent(in) :: model
    type(contact_try_t), intent(in) :: contacts !! of which those of the island are settled
    integer, intent(in) :: group                !! of the island
    logical, intent(in) :: symmetric            !! the operator is to be, but for friction
    real(dp), intent(in) :: d(:)                !! (n_unknowns) of the step so far
    type(equations_t), intent(inout) :: equations
    type(closed_contacts_t) :: closed
    type(pair_term_t) :: term
    integer, allocatable :: pair(:)
    integer :: k

    if (.not. couples_pairs(model)) return
    pair = pairs_of_group(equations, group)
    closed = closed_contacts(contacts, size(pair), equations%place_of)
    do k = 1, size(pair)
      associate (of_pair => closed%contact(closed%first(k):closed%first(k + 1) - 1))
        if (size(of_pair) == 0) cycle
        call clear_pair_term(term)
        call add_contacts_of_pair(model, contacts, pair(k), of_pair, d, symmetric, term)
        call add_pair(equations, group, k, term)
      end associate
    end do
  end subroutine add_pair_effects

end module scree_pair_effects
