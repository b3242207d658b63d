!> Forces of contacts in their states, and what they add to the equations (Shi: df18).
!>
!> A closed contact is a spring p across its line and, locked, a spring k along it that holds the vertex at its anchor:
!>
!>     N = h - p g                   pressing where positive
!>     T = h' - k s                  s: slip from the anchor, a share of the edge
!>     T = -+(N tan phi + c l)       sliding
!>
!> - The forces h and h' are zero but with multipliers (augmented Lagrangian).
!> - With viscosity c, N = h - p g - c (change of the overlap in the step)/dt.
!> - A conserving contact presses with what does the work that the energy of its spring changes by in the step.
!> - A contact slides with the normal force of the same solution; where the law lags, with that of the one before.
module scree_contact_forces
  use scree_conserving_contact, only: mean_depths
  use scree_contacts, only: entrance_t, outlines_t, state_locked, state_open, state_sliding
  use scree_element_term, only: add_change, add_pair_force, pair_term_t
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_shi_contact, only: anchored_rows
  use scree_system, only: element_unknowns
  use scree_contact_try, only: gaps_and_slips, contact_try_t
  implicit none
  private
  public :: add_contacts_of_pair, bond, closed_contacts, closed_contacts_t, forces, pushes

  integer, parameter :: n = 2*element_unknowns

  !> Closed contacts by the pairs of elements that they act between, in their order.
  type :: closed_contacts_t
    integer, allocatable :: first(:)   !! (n_pairs+1) pair p has contact(first(p):first(p+1)-1)
    integer, allocatable :: contact(:)
  end type closed_contacts_t

contains

  !> Lists the closed contacts of each pair of elements.
  pure function closed_contacts(try) result(closed)
    type(contact_try_t), intent(in) :: try
    type(closed_contacts_t) :: closed
    integer :: i, k, last(size(try%pair, 2) + 1), pass

    allocate (closed%first(size(last)))
    last = 0
    do pass = 1, 2 ! count, then keep
      do i = 1, size(try%contact)
        associate (contact => try%contact(i))
          if (contact%entrance(contact%active)%state == state_open) cycle
          do k = 1, contact%n_entrances
            associate (pair => contact%entrance(k)%pair)
              if (k == 2 .and. pair == contact%entrance(1)%pair) cycle
              last(pair) = last(pair) + 1
              if (pass == 2) closed%contact(last(pair)) = i
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

  !> Adds the springs of closed contacts of a pair of elements at `d`.
  pure subroutine add_contacts_of_pair(model, try, pair, contacts, d, symmetric, term)
    type(model_t), intent(in) :: model
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: pair
    integer, intent(in) :: contacts(:)    !! closed, of the pair
    real(dp), intent(in) :: d(:)          !! (n_unknowns)
    logical, intent(in) :: symmetric      !! the operator is to be, but for friction, where the geometry bends
    type(pair_term_t), intent(inout) :: term
    real(dp) :: of(4, 3), shear(n), shear_end(n)
    integer :: i, k, m

    do i = 1, size(contacts)
      associate (contact => try%contact(contacts(i)), geometry => try%geometry(:, contacts(i)), &
                 active => try%contact(contacts(i))%active)
        of = forces(model%outlines, try, contacts(i), gaps_and_slips(model, try, contacts(i), d))
        call shear_rows(try, contacts(i), symmetric, shear, shear_end)
        do k = 1, contact%n_entrances
          if (contact%entrance(k)%pair /= pair) cycle
          do m = 1, contact%n_entrances
            if (contact%entrance(m)%pair /= pair) cycle ! what lines of other elements change by with each other is left out
            associate (change => merge(geometry(m)%normal, geometry(m)%normal_end, symmetric))
              if (abs(of(1 + m, k)) > 0) call add_change(term, geometry(k)%normal, of(1 + m, k)*change)
              if (k == active .and. abs(of(1 + m, 3)) > 0) call add_change(term, shear, of(1 + m, 3)*change)
            end associate
          end do
          call add_pair_force(term, of(1, k)*geometry(k)%normal)
        end do
        if (contact%entrance(active)%pair /= pair) cycle
        if (abs(of(4, 3)) > 0) call add_change(term, shear, of(4, 3)*shear_end)
        call add_pair_force(term, of(1, 3)*shear)
        term%symmetric = term%symmetric .and. symmetric .and. .not. rubs(model%outlines, try, contact%entrance(active))
      end associate
    end do
  end subroutine add_contacts_of_pair

  !> Rows of the force along a contact, and of what it changes by.
  pure subroutine shear_rows(try, i, symmetric, shear, shear_end)
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: i             !! contact
    logical, intent(in) :: symmetric
    real(dp), intent(out) :: shear(n), shear_end(n)
    real(dp) :: rows(n, 2)

    associate (contact => try%contact(i), active => try%contact(i)%active)
      if (try%anchored) then ! friction acts at the anchor (Shi: df18)
        rows = anchored_rows(try%geometry(active, i), contact%entrance(active)%anchor)
        shear = rows(:, merge(2, 1, contact%entrance(active)%state == state_locked))
        shear_end = shear
      else
        shear = try%geometry(active, i)%shear
        shear_end = merge(shear, try%geometry(active, i)%shear_end, symmetric)
      end if
    end associate
  end subroutine shear_rows

  !> Forces of a closed contact: across its first line, across its second, along the one that acts; each with its changes with
  !> the gaps and the slip of that one: (force, d/dg1, d/dg2, d/ds).
  pure function forces(outlines, try, i, both) result(force)
    type(outlines_t), intent(in) :: outlines
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: i             !! contact
    real(dp), intent(in) :: both(2, 2)   !! gap and slip of its lines
    real(dp) :: force(4, 3)

    force = 0.0_dp
    force(:3, :2) = pushes(try, i, both(1, :))
    if (.not. try%law%conserving) force(:, 3 - try%contact(i)%active) = 0.0_dp
    associate (entrance => try%contact(i)%entrance(try%contact(i)%active), slip => both(2, try%contact(i)%active))
      if (entrance%state == state_locked) then
        force(:, 3) = [entrance%multiplier(2) - try%law%shear_stiffness*slip, 0.0_dp, 0.0_dp, -try%law%shear_stiffness]
      else if (try%law%lags) then
        force(1, 3) = -entrance%direction*entrance%lagged_friction
      else
        associate (joint => outlines%joint(entrance%edge))
          force(:, 3) = try%law%friction(joint)*(force(:, 1) + force(:, 2))
          force(1, 3) = force(1, 3) + bond(entrance, try%law%cohesion(joint))
          force(:, 3) = -entrance%direction*force(:, 3)
          if (entrance%bonded .and. entrance%direction*force(1, 3) > 0) force(:, 3) = 0.0_dp ! a bond that is pulled has no friction
        end associate
      end if
    end associate
  end function forces

  !> Force across each line of a contact, and its changes with the gaps of both lines: (force, d/dg1, d/dg2).
  !>
  !> By spring, multiplier and dashpot, as if the line were closed and the one that acts; or what both share of a contact that
  !> conserves energy.
  pure function pushes(try, i, gap) result(push)
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: i             !! contact
    real(dp), intent(in) :: gap(2)       !! of its lines, length
    real(dp) :: push(3, 2)
    integer :: k

    push = 0.0_dp
    associate (contact => try%contact(i), dashpot => try%dashpot, start_gap => try%start_gap(:, i))
      if (try%law%conserving) then
        push = try%law%normal_stiffness*mean_depths(contact%n_entrances, start_gap, gap)
      else
        do k = 1, contact%n_entrances
          push(1, k) = contact%entrance(k)%multiplier(1) - try%law%normal_stiffness*gap(k) - dashpot*(gap(k) &
              - min(start_gap(k), 0.0_dp))
          push(1 + k, k) = -try%law%normal_stiffness - dashpot
        end do
      end if
    end associate
  end function pushes

  !> Force of a bond: a strength of the joint times the length of the contact.
  pure real(dp) function bond(entrance, strength)
    type(entrance_t), intent(in) :: entrance
    real(dp), intent(in) :: strength !! force/length^2

    bond = 0.0_dp
    if (entrance%bonded) bond = strength*entrance%length
  end function bond

  !> Whether a line slides with a force that follows the normal one: what it adds is then not symmetric.
  pure logical function rubs(outlines, try, entrance)
    type(outlines_t), intent(in) :: outlines
    type(contact_try_t), intent(in) :: try
    type(entrance_t), intent(in) :: entrance

    rubs = .false.
    if (try%law%lags .or. entrance%state /= state_sliding) return
    rubs = try%law%friction(outlines%joint(entrance%edge)) > 0
  end function rubs

end module scree_contact_forces
