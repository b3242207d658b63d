!> Bonds of entrances: what they bear, whether they soften, and the damage and the energy that they have lost.
module scree_bond_rules
  use scree_contact_quantities, only: entrance_start_t, gap_and_slip_t
  use scree_contacts, only: contact_law_t, entrance_t, state_sliding
  use scree_joint_softening, only: damage_at, lost_in_opening, lost_in_shear
  use scree_kinds, only: dp
  implicit none
  private
  public :: bond, damage_after, part_losses, softens_in_shear, softens_in_tension

contains

  !> Force of a bond: the strength of the joint that damage leaves, times the length that the contact stands for.
  pure real(dp) function bond(entrance, strength)
    type(entrance_t), intent(in) :: entrance
    real(dp), intent(in) :: strength !! force/length^2

    bond = 0.0_dp
    if (entrance%memory%bonded) bond = (1 - entrance%memory%damage)*strength*entrance%memory%length
  end function bond

  !> Whether an entrance is bonded, and its bond softens in tension.
  pure logical function softens_in_tension(law, entrance)
    type(contact_law_t), intent(in) :: law
    type(entrance_t), intent(in) :: entrance

    softens_in_tension = entrance%memory%bonded .and. law%joint(entrance%joint)%softening%opening > 0
  end function softens_in_tension

  !> Whether an entrance is bonded, and its bond softens in shear.
  pure logical function softens_in_shear(law, entrance)
    type(contact_law_t), intent(in) :: law
    type(entrance_t), intent(in) :: entrance

    softens_in_shear = entrance%memory%bonded .and. law%joint(entrance%joint)%softening%slip > 0
  end function softens_in_shear

  !> Damage that the bond of an entrance has where the step has come to.
  pure real(dp) function damage_after(law, start, now, shear, entrance) result(damage)
    type(contact_law_t), intent(in) :: law
    type(entrance_start_t), intent(in) :: start
    type(gap_and_slip_t), intent(in) :: now
    real(dp), intent(in) :: shear            !! force along
    type(entrance_t), intent(in) :: entrance
    real(dp) :: slip

    slip = entrance%memory%slid
    if (entrance%state == state_sliding) &
      slip = slip + abs(now%slip - (entrance%multiplier(2) - shear)/entrance%stiffness(2))
    damage = damage_at(law%joint(entrance%joint), entrance%memory, entrance%stiffness(1), now%gap, slip, start%damage)
  end function damage_after

  !> Parts the work that a bond lost in the step into friction and fracture, force length per unit thickness. A bond
  !> that slips loses to fracture what its cohesion bears of the shear force: all of it where the bond is pulled.
  pure subroutine part_losses(law, start, slip, shear, entrance, friction, fracture)
    type(contact_law_t), intent(in) :: law
    type(entrance_start_t), intent(in) :: start
    real(dp), intent(in) :: slip             !! in the step, length
    real(dp), intent(in) :: shear            !! size of the force along
    type(entrance_t), intent(in) :: entrance !! at the end of the step
    real(dp), intent(inout) :: friction      !! in: work of the force along
    real(dp), intent(out) :: fracture
    real(dp) :: cohesion

    associate (joint => law%joint(entrance%joint), memory => entrance%memory)
      fracture = lost_in_opening(joint, memory, start%damage, slip)
      if (.not. (softens_in_shear(law, entrance) .and. abs(entrance%direction) > 0)) return
      cohesion = bond(entrance, joint%cohesion)
      fracture = fracture + min(1.0_dp, shear/max(cohesion, tiny(cohesion)))*lost_in_shear(joint, memory, start%damage, slip)
      if (shear > 0) friction = friction*max(0.0_dp, 1 - cohesion/shear)
    end associate
  end subroutine part_losses

end module scree_bond_rules
