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
  use scree_equations, only: add_link_equations, equations_t
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_shi_contact, only: anchored_rows
  use scree_system, only: element_unknowns
  use scree_contact_try, only: gaps_and_slips, contact_try_t
  implicit none
  private
  public :: add_contacts, bond, forces, pushes, slides_with_friction

  integer, parameter :: n = 2*element_unknowns

contains

  !> Adds the springs of all closed contacts at `d`.
  subroutine add_contacts(model, d, symmetric, try, equations)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: d(:)          !! (n_unknowns)
    logical, intent(in) :: symmetric      !! operator of the iteration, where the geometry bends
    type(contact_try_t), intent(in) :: try
    type(equations_t), intent(inout) :: equations
    real(dp) :: matrix(n, n, size(try%pair, 2)), force(n, size(try%pair, 2)), scale(n, size(try%pair, 2))
    real(dp) :: of(4, 3), change(n), shear(n), shear_end(n), rows(n, 2)
    integer :: i, k, m

    matrix = 0.0_dp
    force = 0.0_dp
    scale = 0.0_dp
    do i = 1, size(try%contact)
      associate (contact => try%contact(i), geometry => try%geometry(:, i), active => try%contact(i)%active)
        if (contact%entrance(active)%state == state_open) cycle
        of = forces(model%outlines, try, i, gaps_and_slips(model, try, i, d))
        if (try%anchored) then ! friction acts at the anchor (Shi: df18)
          rows = anchored_rows(geometry(active), contact%entrance(active)%anchor)
          shear = rows(:, merge(2, 1, contact%entrance(active)%state == state_locked))
          shear_end = shear
        else
          shear = geometry(active)%shear
          shear_end = merge(shear, geometry(active)%shear_end, symmetric)
        end if
        do k = 1, contact%n_entrances
          associate (pair => contact%entrance(k)%pair)
            do m = 1, contact%n_entrances
              if (contact%entrance(m)%pair /= pair) cycle ! what lines of other elements change by with each other is left out
              change = merge(geometry(m)%normal, geometry(m)%normal_end, symmetric)
              if (abs(of(1 + m, k)) > 0) call add_change(pair, geometry(k)%normal, of(1 + m, k)*change)
              if (k == active .and. abs(of(1 + m, 3)) > 0) call add_change(pair, shear, of(1 + m, 3)*change)
            end do
            call add_force_across(pair, of(1, k)*geometry(k)%normal)
          end associate
        end do
        associate (pair => contact%entrance(active)%pair)
          if (abs(of(4, 3)) > 0) call add_change(pair, shear, of(4, 3)*shear_end)
          call add_force_across(pair, of(1, 3)*shear)
        end associate
      end associate
    end do
    call add_link_equations(equations, matrix, force, scale)

  contains

    !> Adds a force on the elements of a pair.
    subroutine add_force_across(pair, of_pair)
      integer, intent(in) :: pair
      real(dp), intent(in) :: of_pair(n)

      force(:, pair) = force(:, pair) + of_pair
      scale(:, pair) = scale(:, pair) + abs(of_pair)
    end subroutine add_force_across

    !> Adds what a force along `row` changes by with the unknowns.
    subroutine add_change(pair, row, change)
      integer, intent(in) :: pair
      real(dp), intent(in) :: row(n), change(n)
      integer :: j

      do j = 1, n
        matrix(:, j, pair) = matrix(:, j, pair) - change(j)*row
      end do
    end subroutine add_change

  end subroutine add_contacts

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

  !> Whether a contact slides with a force that follows the normal one: the equations are then not symmetric.
  pure logical function slides_with_friction(outlines, try)
    type(outlines_t), intent(in) :: outlines
    type(contact_try_t), intent(in) :: try
    integer :: i

    slides_with_friction = .false.
    if (try%law%lags) return
    do i = 1, size(try%contact)
      associate (entrance => try%contact(i)%entrance(try%contact(i)%active))
        slides_with_friction = slides_with_friction .or. &
          (entrance%state == state_sliding .and. try%law%friction(outlines%joint(entrance%edge)) > 0)
      end associate
    end do
  end function slides_with_friction

end module scree_contact_forces
