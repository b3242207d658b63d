!> The effects between two elements, of one body or two: which are present, which pairs they couple, what they add to the equations.
!> What bolts store and the work of what pulls them are asked of `scree_effects`.
!>
!> An effect names the pairs of elements that it acts between, and adds a term to each; the loop, the scatter and the pattern of the
!> equations are the same for all.
module scree_pair_effects
  use scree_bolt, only: add_bolt_between
  use scree_contact_forces, only: add_contacts_of_pair, closed_contacts, closed_contacts_t
  use scree_contact_geometry, only: frame_of_edge
  use scree_contact_pairs, only: number_pairs, pairs_of_contacts
  use scree_contact_try, only: contact_try_t
  use scree_contacts, only: state_open
  use scree_element_term, only: add_force, clear_pair_term, pair_term_t, step_rule_t, term_t
  use scree_equations, only: add_pair, equations_t, pairs_of_group
  use scree_interpolation, only: displacement_matrix
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_pairs, only: list_pairs, number_of_pair
  use scree_sorting, only: sort_into
  use scree_state, only: state_t
  use scree_system, only: element_unknowns, values_of
  implicit none
  private
  public :: add_bolts, add_forces_of_bolts, add_forces_of_contacts, add_pair_effects, couples_pairs, is_bolted, &
            list_coupled_pairs, list_pairs_of_bolts, order_contacts

contains

  !> Whether a scene calls for an effect between two elements.
  pure logical function couples_pairs(model)
    type(model_t), intent(in) :: model

    couples_pairs = allocated(model%effects%contact)
    if (allocated(model%effects%bolt)) couples_pairs = couples_pairs .or. size(model%effects%bolt%pair, 2) > 0
  end function couples_pairs

  !> Whether any of some elements carries a bolt.
  pure logical function is_bolted(model, element)
    type(model_t), intent(in) :: model
    integer, intent(in) :: element(:)

    is_bolted = .false.
    if (allocated(model%effects%bolt)) is_bolted = any(model%effects%bolt%carries(element))
  end function is_bolted

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
    integer, allocatable :: bolted(:, :), number(:)

    call list_pairs_of_bolts(model, bolted)
    if (allocated(model%effects%contact)) then
      call list_pairs(all_of(bolted, pairs_of_contacts(model%outlines, contacts%contact)), state%pair, contacts%pair, &
                      number)
      call number_pairs(number(size(bolted, 2) + 1:), contacts%contact)
    else
      call list_pairs(bolted, state%pair, contacts%pair, number)
    end if
  end subroutine list_coupled_pairs

  !> Pairs of two lists.
  pure function all_of(a, b)
    integer, intent(in) :: a(:, :), b(:, :)      !! (2, n)
    integer :: all_of(2, size(a, 2) + size(b, 2))

    all_of(:, :size(a, 2)) = a
    all_of(:, size(a, 2) + 1:) = b
  end function all_of

  !> Lists the pairs of elements that bolts join, one of which can move at least, in order.
  pure subroutine list_pairs_of_bolts(model, pairs)
    type(model_t), intent(in) :: model
    integer, allocatable, intent(out) :: pairs(:, :) !! (2, n)
    logical, allocatable :: can_move(:)
    integer :: i

    allocate (pairs(2, 0))
    if (.not. allocated(model%effects%bolt)) return
    allocate (can_move(model%n_elements), source=.false.)
    can_move(model%elements%free) = .true.
    associate (all_pairs => model%effects%bolt%pair)
      pairs = all_pairs(:, pack([(i, i=1, size(all_pairs, 2))], can_move(all_pairs(1, :)) .or. can_move(all_pairs(2, :))))
    end associate
  end subroutine list_pairs_of_bolts

  !> Adds the bolts between two elements of an island to its equations.
  subroutine add_bolts(model, state, group, rule, d, cache)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state          !! at the beginning of the step
    integer, intent(in) :: group                !! of the island
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: d(:)                !! (n_unknowns) of the step so far
    type(cache_t), intent(inout) :: cache       !! to whose equations they are added
    type(pair_term_t) :: term
    integer, allocatable :: number(:)
    integer :: k, of_bolts, pair(2)

    number = pairs_of_group(cache%equations, group)
    associate (bolt => model%effects%bolt)
      if (size(bolt%pair, 2) == 0) return
      do k = 1, size(number)
        pair = cache%equations%paired(:, number(k))
        of_bolts = number_of_pair(bolt%pair, pair)
        if (any(bolt%pair(:, of_bolts) /= pair)) cycle
        term = term_of_bolts(model, cache, state, of_bolts, rule, d)
        call add_pair(cache%equations, group, k, term)
      end do
    end associate
  end subroutine add_bolts

  !> Term of the bolts of a pair of elements.
  pure type(pair_term_t) function term_of_bolts(model, cache, state, k, rule, d) result(term)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state          !! at the beginning of the step
    integer, intent(in) :: k                    !! of the pairs that bolts join
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: d(:)                !! (n_unknowns) of the step so far
    integer :: m

    call clear_pair_term(term)
    associate (bolt => model%effects%bolt, pair => model%effects%bolt%pair(:, k))
      do m = bolt%first_of(k), bolt%first_of(k + 1) - 1
        call add_bolt_between(bolt, state%bolts, bolt%joining(m), pair, state%point, rule, cache%element(pair)%kinematics, &
                              [values_of(model%elements, pair(1), d), values_of(model%elements, pair(2), d)], term)
      end do
    end associate
  end function term_of_bolts

  !> Adds the forces of bolts between two elements to those of the elements, where nothing has moved yet.
  pure subroutine add_forces_of_bolts(model, cache, state, rule, terms)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(step_rule_t), intent(in) :: rule
    type(term_t), intent(inout) :: terms(:)     !! (n_elements)
    type(pair_term_t) :: term
    integer :: k, side

    if (.not. allocated(model%effects%bolt)) return
    do k = 1, size(model%effects%bolt%pair, 2)
      term = term_of_bolts(model, cache, state, k, rule, 0*state%velocity)
      do side = 1, 2
        call add_force(terms(model%effects%bolt%pair(side, k)), &
                       term%force((side - 1)*element_unknowns + 1:side*element_unknowns))
      end do
    end do
  end subroutine add_forces_of_bolts

  !> Adds what contacts press and rub with at a state to the terms of elements, as a step does in which nothing moves. Normal
  !> forces act at the vertex and at its foot on the edge. Shear forces act where the vertex is.
  pure subroutine add_forces_of_contacts(model, cache, state, terms)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(term_t), intent(inout) :: terms(:)     !! (n_elements)
    real(dp) :: t(2), normal(2), foot(2), length
    integer :: i

    if (.not. allocated(state%contacts%contact)) return
    associate (outlines => model%outlines)
      do i = 1, size(state%contacts%contact)
        associate (contact => state%contacts%contact(i), &
                   own => state%contacts%contact(i)%entrance(state%contacts%contact(i)%active))
          if (own%state == state_open) cycle
          associate (at => state%vertex(:, outlines%start(own%vertex)), from => state%vertex(:, outlines%start(own%edge)), &
                     press => contact%force(1), rub => contact%force(2), body => outlines%of_vertex(own%vertex), &
                     edge_body => outlines%element(own%edge))
            call frame_of_edge(from, state%vertex(:, outlines%finish(own%edge)), t, normal, length)
            foot = from + dot_product(at - from, t)*t
            associate (element => cache%element(edge_body)%kinematics)
              call add_force(terms(body), matmul(press*normal + rub*t, displacement_matrix(cache%element(body)%kinematics, at)))
              call add_force(terms(edge_body), -matmul(press*normal, displacement_matrix(element, foot)))
              call add_force(terms(edge_body), -matmul(rub*t, displacement_matrix(element, at)))
            end associate
          end associate
        end associate
      end do
    end associate
  end subroutine add_forces_of_contacts

  !> Adds the effects between two elements of an island that are judged, as they were measured last, to its equations.
  subroutine add_pair_effects(model, contacts, group, symmetric, curved, equations)
    type(model_t), intent(in) :: model
    type(contact_try_t), intent(in) :: contacts !! of which those of the island are settled
    integer, intent(in) :: group                !! of the island
    logical, intent(in) :: symmetric            !! the operator is to be, but for friction
    logical, intent(in) :: curved               !! it has what contacts change by as edges turn
    type(equations_t), intent(inout) :: equations
    type(closed_contacts_t) :: closed
    type(pair_term_t) :: term
    integer, allocatable :: pair(:)
    integer :: k

    if (.not. allocated(model%effects%contact)) return
    pair = pairs_of_group(equations, group)
    closed = closed_contacts(contacts, size(pair), equations%place_of)
    do k = 1, size(pair)
      associate (of_pair => closed%contact(closed%first(k):closed%first(k + 1) - 1))
        if (size(of_pair) == 0) cycle
        call clear_pair_term(term)
        call add_contacts_of_pair(contacts, pair(k), of_pair, symmetric, curved, term)
        call add_pair(equations, group, k, term)
      end associate
    end do
  end subroutine add_pair_effects

end module scree_pair_effects
