!> Forces and stiffness that the contacts between two elements add to the equations (Shi: df18).
module scree_contact_forces
  use scree_contact_geometry, only: acting_rows_t
  use scree_contact_quantities, only: contact_force_t
  use scree_contact_rules, only: gaps_and_slips, press, rows_along, rubs
  use scree_contact_try, only: contact_try_t, elements_of, of_elements, row_across
  use scree_contacts, only: state_open
  use scree_element_term, only: add_change, add_friction_change, add_pair_force, leave_symmetry, pair_term_t
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: add_contacts_of_pair, closed_contact_t, closed_contacts, closed_contacts_t, work_of_contacts

  integer, parameter :: n = 2*element_unknowns

  !> A closed contact as the equations take it: all in one place, as contacts do not lie in the order of their pairs. Rows have no
  !> default values, as most contacts have one entrance.
  type :: closed_contact_t
    integer :: number                    !! among the contacts
    integer :: n_entrances
    integer :: active                    !! entrance that acts
    integer :: pair(2)                   !! of each entrance
    logical :: rubs                      !! what it adds is not symmetric
    type(contact_force_t) :: force       !! as it was measured last
    real(dp) :: across(n, 2), along(n)   !! rows of the forces across each entrance, and along
  end type closed_contact_t

  !> Closed contacts by the pairs of elements of an island that they act between, in their order.
  type :: closed_contacts_t
    integer, allocatable :: first(:) !! (n+1) the k-th pair has contact(first(k):first(k+1)-1)
    type(closed_contact_t), allocatable :: contact(:)
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
              if (pass == 2) call take(try, i, closed%contact(last(place(pair))))
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

  !> Takes the data of the closed contact i that the equations need.
  pure subroutine take(try, i, own)
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: i
    type(closed_contact_t), intent(out) :: own
    integer :: k

    own%number = i
    associate (contact => try%contact(i))
      own%n_entrances = contact%n_entrances
      own%active = contact%active
      own%pair = contact%entrance%pair
      own%rubs = rubs(try%law, contact%entrance(contact%active))
      call press(try, i, try%now(:, i), own%force)
      do k = 1, contact%n_entrances
        own%across(:, k) = row_across(try, i, k)
      end do
      call rows_along(try, i, contact%active, own%along)
    end associate
  end subroutine take

  !> Adds the forces of the closed contacts of a pair of elements, and their derivatives.
  pure subroutine add_contacts_of_pair(try, pair, contacts, symmetric, curved, term)
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: pair
    type(closed_contact_t), intent(in) :: contacts(:) !! of the pair
    logical, intent(in) :: symmetric      !! the operator is to be, but for friction, where the geometry bends
    logical, intent(in) :: curved         !! it has what the forces change by as their edges turn
    type(pair_term_t), intent(inout) :: term
    real(dp) :: by_gap(n, 2), by_slip(n), row(n)
    integer :: i, k

    do i = 1, size(contacts)
      associate (own => contacts(i))
        if (symmetric) then
          call add_contact(try, own, own%across, own%along, pair, curved, term)
        else
          do k = 1, own%n_entrances
            by_gap(:, k) = try%geometry(k, own%number)%normal
          end do
          call rows_along(try, own%number, own%active, row, by_slip)
          call add_contact(try, own, by_gap, by_slip, pair, curved, term)
        end if
        if (own%pair(own%active) == pair .and. (own%rubs .or. .not. symmetric)) call leave_symmetry(term)
      end associate
    end do
  end subroutine add_contacts_of_pair

  !> Adds the forces of a closed contact to a pair of elements, and their derivatives.
  pure subroutine add_contact(try, own, by_gap, by_slip, pair, curved, term)
    type(contact_try_t), intent(in) :: try
    type(closed_contact_t), intent(in) :: own
    real(dp), intent(in) :: by_gap(n, 2), by_slip(n)  !! rows of gaps and slip
    integer, intent(in) :: pair
    logical, intent(in) :: curved
    type(pair_term_t), intent(inout) :: term
    integer :: k, m

    associate (force => own%force, active => own%active)
      do k = 1, own%n_entrances
        if (own%pair(k) /= pair) cycle
        do m = 1, own%n_entrances
          if (own%pair(m) /= pair) cycle ! what entrances of other elements change by with each other is left out
          if (abs(force%across_by_gap(m, k)) > 0) call add_change(term, own%across(:, k), force%across_by_gap(m, k)*by_gap(:, m))
          if (k == active .and. abs(force%along_by_gap(m)) > 0) &
            call add_friction_change(term, own%along, force%along_by_gap(m)*by_gap(:, m))
        end do
        call add_pair_force(term, force%across(k)*own%across(:, k))
        if (curved) &
          call add_turning(try%acting(k, own%number), force%across(k), merge(force%along, 0.0_dp, k == active), term)
      end do
      if (own%pair(active) == pair) call add_slip(force, own%across(:, active), own%along, by_slip, term)
    end associate
  end subroutine add_contact

  !> Adds the change of the forces of an entrance as its edge turns (`scree_contact_geometry`).
  pure subroutine add_turning(acting, across, along, term)
    type(acting_rows_t), intent(in) :: acting
    real(dp), intent(in) :: across, along !! force
    type(pair_term_t), intent(inout) :: term

    call add_change(term, acting%turn, -across*acting%shear)
    call add_change(term, acting%shear, -across*acting%turn)
    call add_change(term, acting%normal, along*acting%turn)
    call add_change(term, acting%turn, along*acting%normal)
  end subroutine add_turning

  !> Adds the force along a contact, and the change of the forces with its slip.
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

  !> Work of all contacts on the bodies that they act between in a step, force length per unit thickness.
  pure real(dp) function work_of_contacts(model, try, d) result(work)
    type(model_t), intent(in) :: model
    type(contact_try_t), intent(in) :: try
    real(dp), intent(in) :: d(:)              !! (n_unknowns) of the step
    type(contact_force_t) :: force
    real(dp) :: along(n)
    integer :: i, k

    work = 0.0_dp
    do i = 1, size(try%contact)
      associate (contact => try%contact(i), active => try%contact(i)%active)
        if (contact%entrance(active)%state == state_open) cycle
        call press(try, i, gaps_and_slips(model, try, i, d), force)
        call rows_along(try, i, active, along)
        do k = 1, contact%n_entrances
          associate (moved => of_elements(model, elements_of(try, i, k), d))
            work = work + force%across(k)*dot_product(row_across(try, i, k), moved)
            if (k == active) work = work + force%along*dot_product(along, moved)
          end associate
        end do
      end associate
    end do
  end function work_of_contacts

end module scree_contact_forces
