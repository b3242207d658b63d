!> The memory of contacts after an accepted step, and the largest gap and overlap of closed contacts.
module scree_contact_acceptance
  use scree_bond_rules, only: part_losses
  use scree_contact_quantities, only: contact_force_t, entrance_start_t, gap_and_slip_t
  use scree_contact_rules, only: force_to_hold, gap_and_slip, gaps_and_slips, press, remember_overlap, remember_slide, &
                                 stiffness_after
  use scree_contact_try, only: contact_try_t
  use scree_contacts, only: blocks_of, contact_law_t, contact_memory_t, contact_t, outlines_t, state_locked, state_open, &
                            state_sliding
  use scree_joint_rules, only: energy_beside_spring, joints_soften
  use scree_joint_stiffness, only: is_hard
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_pairs, only: numbers_of_pairs, pair_of, sorted_pairs
  implicit none
  private
  public :: accept_contacts, accept_no_contact, farthest_apart

  !> A closed contact at the end of a step.
  type :: closed_t
    real(dp) :: gap = 0.0_dp    !! from where its spring rests, length
    real(dp) :: energy = 0.0_dp !! of its springs, force length per unit thickness
    real(dp) :: work = 0.0_dp   !! lost in friction in the step, likewise
  end type closed_t

contains

  !> Resets the contact totals after a step without contact, and halves the extra search distance and angle.
  pure subroutine accept_no_contact(try, memory)
    type(contact_try_t), intent(in) :: try
    type(contact_memory_t), intent(inout) :: memory

    memory%count = 0
    memory%gap = 0.0_dp
    memory%penetration = 0.0_dp
    memory%pressed = 0.0_dp
    memory%extra_reach = 0.5_dp*try%extra_reach
    memory%extra_turn = 0.5_dp*try%extra_turn
  end subroutine accept_no_contact

  !> Hands on states, anchors, bonds and overlaps of an accepted step, and books the energy of springs, friction and fracture. The
  !> entrance of a corner that does not act is open, though its step began with the line closed, as another contact of it acted: by
  !> now the corner may be far behind it.
  pure subroutine accept_contacts(model, d, try, memory, energy, friction, fracture)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: d(:)              !! (n_unknowns) of the step
    type(contact_try_t), intent(in) :: try
    type(contact_memory_t), intent(inout) :: memory
    real(dp), intent(out) :: energy           !! of the springs at the end, force length per unit thickness
    real(dp), intent(out) :: friction         !! work lost in sliding in the step, likewise
    real(dp), intent(out) :: fracture         !! energy lost in bonds that soften in the step, likewise
    type(gap_and_slip_t) :: now(2)
    type(closed_t) :: closed
    type(contact_force_t) :: force
    real(dp) :: lost                            !! in fracture, by a contact
    logical :: bonded(size(try%contact)) !! a locked bond holds its two blocks together
    logical :: pulled                           !! open by a dashpot
    integer :: i

    call accept_no_contact(try, memory)
    memory%contact = try%contact
    call soften(try%start%hardening, memory%contact)
    memory%inside = try%inside
    memory%count = try%count
    energy = 0.0_dp
    friction = 0.0_dp
    fracture = 0.0_dp
    bonded = hold_together(model%outlines, memory%contact)
    do i = 1, size(memory%contact)
      associate (contact => memory%contact(i), entrance => memory%contact(i)%entrance(memory%contact(i)%active))
        contact%force = 0.0_dp
        contact%entrance%memory%pressing = 0.0_dp
        contact%pressed = 0.0_dp
        contact%overlap = 0.0_dp
        contact%energy = 0.0_dp
        closed = closed_t()
        if (contact%n_entrances == 2) contact%entrance(3 - contact%active)%state = state_open
        now = gaps_and_slips(model, try, i, d)
        if (entrance%state == state_open) then
          entrance%memory%bonded = .false.
          entrance%multiplier = 0.0_dp
          pulled = pulled_open(try, contact, now)
          if (entrance%rest < 0 .or. pulled) contact%overlap = overlap_of(contact, now)
          if (pulled) then
            contact%energy = 0.5_dp*entrance%stiffness(1)*now(contact%active)%gap**2 &
                             + energy_beside_spring(try%law, entrance, -now(contact%active)%gap)
            energy = energy + contact%energy
          end if
        else
          call press(try, i, now, force)
          call accept_closed(try%law, force, force_to_hold(try, i, now, force), now, bonded(i), contact, closed)
          memory%gap = max(memory%gap, closed%gap)
          contact%overlap = max(0.0_dp, -(entrance%rest + entrance%memory%dilated + closed%gap))
          memory%pressed = max(memory%pressed, -closed%gap)
          contact%energy = closed%energy
          energy = energy + closed%energy
        end if
        contact%slipped = entrance%memory%slid - try%contact(i)%entrance(contact%active)%memory%slid
        if (joints_soften(try%law)) then
          call part_losses(try%law, try%start(contact%active, i), contact%slipped, abs(contact%force(2)), entrance, &
                           closed%work, lost)
          fracture = fracture + lost
          entrance%memory%bonded = entrance%memory%bonded .and. entrance%memory%damage < 1
          if (try%contact(i)%entrance(contact%active)%memory%bonded .and. .not. entrance%memory%bonded .and. closed%gap > 0) then
            entrance%state = state_open ! a bond that broke in shear pulls no more
            energy = energy - contact%energy
            contact%energy = 0.0_dp
          end if
        end if
        call count_broken(try%start(:, i), contact, memory%broken)
        friction = friction + closed%work
        memory%penetration = max(memory%penetration, contact%overlap)
      end associate
    end do
    memory%stiffness = stiffness_after(try%law, memory%gap, memory%penetration)
  end subroutine accept_contacts

  !> Counts a bond that broke in the step: in tension where its contact has opened, else in shear.
  pure subroutine count_broken(start, contact, broken)
    type(entrance_start_t), intent(in) :: start(:)
    type(contact_t), intent(in) :: contact
    integer, intent(inout) :: broken(:)         !! in tension, in shear
    integer :: mode

    associate (n => contact%n_entrances)
      if (.not. any(start(:n)%bonded) .or. any(contact%entrance(:n)%memory%bonded)) return
      mode = merge(1, 2, contact%entrance(contact%active)%state == state_open)
    end associate
    broken(mode) = broken(mode) + 1
  end subroutine count_broken

  !> Of each contact whether a bond that is locked, this one or another, holds its two blocks together.
  pure function hold_together(outlines, contact) result(bonded)
    type(outlines_t), intent(in) :: outlines
    type(contact_t), intent(in) :: contact(:)
    logical :: bonded(size(contact)), is_locked(size(contact))
    integer :: blocks(2, size(contact)), i

    do i = 1, size(contact)
      associate (entrance => contact(i)%entrance(contact(i)%active))
        is_locked(i) = entrance%memory%bonded .and. entrance%state == state_locked
      end associate
    end do
    bonded = .false.
    if (.not. any(is_locked)) return
    do i = 1, size(contact)
      blocks(:, i) = blocks_of(outlines, contact(i)%entrance(contact(i)%active))
      blocks(:, i) = pair_of(blocks(1, i), blocks(2, i))
    end do
    bonded = numbers_of_pairs(sorted_pairs(blocks(:, pack([(i, i=1, size(contact))], is_locked))), blocks) > 0
  end function hold_together

  !> Overlap at a contact that is open: across all of its lines.
  pure real(dp) function overlap_of(contact, now) result(overlap)
    type(contact_t), intent(in) :: contact
    type(gap_and_slip_t), intent(in) :: now(:)

    associate (n => contact%n_entrances)
      overlap = max(0.0_dp, -maxval(contact%entrance(:n)%rest + contact%entrance(:n)%memory%dilated + now(:n)%gap))
    end associate
  end function overlap_of

  !> Whether a dashpot has opened a contact whose vertex is still behind the edge. The dashpot pulls with the force with which the
  !> spring presses. The spring still has its energy, and presses again when the body comes back.
  pure logical function pulled_open(try, contact, now)
    type(contact_try_t), intent(in) :: try
    type(contact_t), intent(in) :: contact
    type(gap_and_slip_t), intent(in) :: now(2)

    pulled_open = try%dashpot > 0 .and. all(now(:contact%n_entrances)%gap < 0)
  end function pulled_open

  !> Gives springs that became harder in the step their own stiffness back.
  pure subroutine soften(hardening, contact)
    real(dp), intent(in) :: hardening(:, :) !! (2, n)
    type(contact_t), intent(inout) :: contact(:)
    integer :: i, k

    do i = 1, size(contact)
      do k = 1, 2
        if (hardening(k, i) > 1) contact(i)%entrance(k)%stiffness = contact(i)%entrance(k)%stiffness/hardening(k, i)
      end do
    end do
  end subroutine soften

  !> Stores a closed contact: its force, its overlap, and its sliding. The springs with their multipliers make this force at the
  !> present place. A sliding contact is stored by its multiplier alone, because its spring along has no elastic slip.
  pure subroutine accept_closed(law, force, taken_over, now, holds, contact, closed)
    type(contact_law_t), intent(in) :: law
    type(contact_force_t), intent(in) :: force
    real(dp), intent(in) :: taken_over(2)   !! part of the force that multipliers take over, if there are any
    type(gap_and_slip_t), intent(in) :: now(2)
    logical, intent(in) :: holds            !! a bond between its two blocks is locked
    type(contact_t), intent(inout) :: contact
    type(closed_t), intent(out) :: closed
    real(dp) :: beside, slip, strained

    associate (k => contact%active)
      contact%force = [sum(force%across), force%along]
      contact%entrance(k)%memory%pressing = max(0.0_dp, contact%force(1))
      beside = energy_beside_spring(law, contact%entrance(k), -now(k)%gap) ! with the bond that a slip may break
      slip = now(k)%slip
      if (is_hard(law, contact%entrance(k))) contact%entrance(k)%multiplier = taken_over
      if (contact%entrance(k)%state == state_sliding) &
        call remember_slide(law, force, now(k), holds, contact%entrance(k), slip, closed%work)
      call remember_overlap(law, contact, now, closed%gap, strained)
      if (is_hard(law, contact%entrance(k))) &
        contact%entrance(k)%multiplier = taken_over + contact%entrance(k)%stiffness*[strained, slip]
    end associate
    contact%pressed = max(0.0_dp, -closed%gap)
    closed%energy = 0.5_dp*dot_product(contact%entrance(contact%active)%stiffness, [strained, slip]**2) + beside
  end subroutine accept_closed

  !> Largest gap and overlap of a closed contact at `d`, length.
  pure function farthest_apart(model, try, d) result(farthest)
    type(model_t), intent(in) :: model
    type(contact_try_t), intent(in) :: try
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    real(dp) :: farthest(2)
    type(gap_and_slip_t) :: now
    integer :: i

    farthest = 0.0_dp
    do i = 1, size(try%contact)
      associate (contact => try%contact(i))
        if (contact%entrance(contact%active)%state == state_open) cycle
        now = gap_and_slip(model, try, i, contact%active, d)
        farthest = max(farthest, [now%gap, -now%gap])
      end associate
    end do
  end function farthest_apart

end module scree_contact_acceptance
