!> What the contacts between two elements add to the equations (Shi: df18).
module scree_contact_forces
  use scree_contact_geometry, only: entrance_geometry_t
  use scree_contact_quantities, only: contact_force_t
  use scree_contact_rules, only: press, rows_along, rubs
  use scree_contact_try, only: contact_try_t
  use scree_contacts, only: state_open
  use scree_element_term, only: add_change, add_friction_change, add_pair_force, leave_symmetry, pair_term_t
  use scree_kinds, only: dp
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: add_contacts_of_pair, closed_contacts, closed_contacts_t

  integer, parameter :: n = 2*element_unknowns

  !> Closed contacts by the pairs of elements of an island that they act between, in their order.
  type :: closed_contacts_t
    integer, allocatable :: first(:)   !! (n+1) the k-th pair has contact(first(k):first(k+1)-1)
    integer, allocatable :: contact(:)
  end type closed_contacts_t

contains

  !> Lists the closed contacts of each pair of the island that is settled.
  pure function closed_contacts(try, n, place) result(closed)
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: n           !! pairs that the island has
    integer, intent(in) :: place(:)    !! (n_pairs) of each pair in its island
    type(closed_contacts_t) :: closed
    integer :: i, k, last(n + 1), pass

    allocate (closed%first(size(last)))
    last = 0
    do pass = 1, 2 ! count, then keep
      do i = try%first, try%last
        associate (contact => try%contact(i))
          if (contact%entrance(contact%active)%state == state_open) cycle
          do k = 1, contact%n_entrances
            associate (pair => contact%entrance(k)%pair)
              if (k == 2 .and. pair == contact%entrance(1)%pair) cycle
              last(place(pair)) = last(place(pair)) + 1
              if (pass == 2) closed%contact(last(place(pair))) = i
            end associate
          end do
        end associate
      end do
      if (pass == 2) exit
      closed%first(1) = 1
      do i = 1, size(last) - 1
        closed%first(i + 1) = closed%first(i) + last(i)
      end do
      last = closed%first - 1
      allocate (closed%contact(closed%first(size(last)) - 1))
    end do
  end function closed_contacts

  !> Adds the forces of the closed contacts of a pair of elements, as they were measured last, and what they change by.
  pure subroutine add_contacts_of_pair(try, pair, contacts, symmetric, curved, term)
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: pair
    integer, intent(in) :: contacts(:)    !! closed, of the pair
    logical, intent(in) :: symmetric      !! the operator is to be, but for friction, where the geometry bends
    logical, intent(in) :: curved         !! it has what the forces change by as their edges turn
    type(pair_term_t), intent(inout) :: term
    type(contact_force_t) :: force
    real(dp) :: change(n), row(n), row_change(n)
    integer :: i, k, m

    do i = 1, size(contacts)
      associate (contact => try%contact(contacts(i)), geometry => try%geometry(:, contacts(i)), &
                 active => try%contact(contacts(i))%active)
        force = press(try, contacts(i), try%now(:, contacts(i)))
        call rows_along(try, contacts(i), row, row_change)
        if (symmetric) row_change = row
        do k = 1, contact%n_entrances
          if (contact%entrance(k)%pair /= pair) cycle
          do m = 1, contact%n_entrances
            if (contact%entrance(m)%pair /= pair) cycle ! what entrances of other elements change by with each other is left out
            change = merge(geometry(m)%normal, geometry(m)%normal_end, symmetric)
            if (abs(force%across_by_gap(m, k)) > 0) call add_change(term, geometry(k)%normal, force%across_by_gap(m, k)*change)
            if (k == active .and. abs(force%along_by_gap(m)) > 0) &
              call add_friction_change(term, row, force%along_by_gap(m)*change)
          end do
          call add_pair_force(term, force%across(k)*geometry(k)%normal)
          if (curved) call add_turning(geometry(k), force%across(k), merge(force%along, 0.0_dp, k == active), term)
        end do
        if (contact%entrance(active)%pair /= pair) cycle
        call add_slip(force, geometry(active)%normal, row, row_change, term)
        if (.not. symmetric .or. rubs(try%law, contact%entrance(active))) call leave_symmetry(term)
      end associate
    end do
  end subroutine add_contacts_of_pair

  !> Adds what the forces of an entrance change by as its edge turns (`scree_contact_geometry`).
  pure subroutine add_turning(geometry, across, along, term)
    type(entrance_geometry_t), intent(in) :: geometry
    real(dp), intent(in) :: across, along !! force
    type(pair_term_t), intent(inout) :: term

    call add_change(term, geometry%turn, -across*geometry%shear)
    call add_change(term, geometry%shear, -across*geometry%turn)
    call add_change(term, geometry%normal, along*geometry%turn)
    call add_change(term, geometry%turn, along*geometry%normal)
  end subroutine add_turning

  !> Adds the force along a contact, and what the forces change by with its slip.
  pure subroutine add_slip(force, normal, row, row_change, term)
    type(contact_force_t), intent(in) :: force
    real(dp), intent(in) :: normal(n), row(n) !! of the forces across and along
    real(dp), intent(in) :: row_change(n)     !! of the slip
    type(pair_term_t), intent(inout) :: term

    if (abs(force%along_by_slip) > 0) call add_change(term, row, force%along_by_slip*row_change)
    call add_pair_force(term, force%along*row)
    if (.not. abs(force%across_by_slip) > 0) return
    call add_friction_change(term, normal, force%across_by_slip*row_change)
    call leave_symmetry(term)
  end subroutine add_slip

end module scree_contact_forces
