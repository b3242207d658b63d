!> Which laws the joints of a scene have. Only this file asks; each law is a module of its own, which knows of no other one:
!> `joint_stiffness`, `joint_closure`, `joint_dilation`, `joint_wear`, `joint_roughness` and `joint_softening`.
module scree_joint_rules
  use scree_bond_rules, only: bond, softens_in_tension
  use scree_contact_quantities, only: bend_t, contact_force_t, entrance_start_t, gap_and_slip_t
  use scree_contacts, only: contact_law_t, contact_t, entrance_t
  use scree_joint_closure, only: closing_energy, starting_bend, touching
  use scree_joint_dilation, only: begin_opening, dilating_t, judge_opening, remember_opening, tangent_after
  use scree_joint_law, only: joint_memory_t, joint_t, laws_in_use_t
  use scree_joint_roughness, only: follows_stress, rough_friction
  use scree_joint_softening, only: pulled_energy, pulled_line, softens
  use scree_joint_wear, only: unworn, worn_friction
  use scree_kinds, only: dp
  implicit none
  private
  public :: begin_joints, energy_beside_spring, friction_of, joints_bend, joints_dilate, joints_follow_stress, &
      joints_have_stiffness, &
            joints_soften, joints_wear, judge_bend, judge_dilating, laws_in_use, overlap_under, remember_dilating, weaker_joint

contains

  !> The laws that any of the joints of a scene has.
  pure type(laws_in_use_t) function laws_in_use(joint)
    type(joint_t), intent(in) :: joint(:) !! (n_joints)

    laws_in_use%stiffness = any(joint%stiffness%normal > 0)
    laws_in_use%closure = any(joint%closure%most > 0)
    laws_in_use%dilation = any(joint%dilation%tangent > 0)
    laws_in_use%wear = any(joint%wear%slip > 0)
    laws_in_use%roughness = any(follows_stress(joint%roughness))
    laws_in_use%softening = any(softens(joint))
  end function laws_in_use

  !> Whether joints give way by a stiffness of their own.
  pure logical function joints_have_stiffness(law)
    type(contact_law_t), intent(in) :: law

    joints_have_stiffness = law%uses%stiffness
  end function joints_have_stiffness

  !> Whether springs across joints are curves: joints stiffen as they close, or soften as their bonds open.
  pure logical function joints_bend(law)
    type(contact_law_t), intent(in) :: law

    joints_bend = law%uses%closure .or. law%uses%softening
  end function joints_bend

  !> Whether bonds of joints soften.
  pure logical function joints_soften(law)
    type(contact_law_t), intent(in) :: law

    joints_soften = law%uses%softening
  end function joints_soften

  !> Whether the faces of joints part as they slide.
  pure logical function joints_dilate(law)
    type(contact_law_t), intent(in) :: law

    joints_dilate = law%uses%dilation
  end function joints_dilate

  !> Whether the friction of joints falls as they slide.
  pure logical function joints_wear(law)
    type(contact_law_t), intent(in) :: law

    joints_wear = law%uses%wear
  end function joints_wear

  !> Whether the friction of joints follows the stress across them, for which their contacts need a length.
  pure logical function joints_follow_stress(law)
    type(contact_law_t), intent(in) :: law

    joints_follow_stress = law%uses%roughness
  end function joints_follow_stress

  !> Tangent of the friction angle of an entrance, after the wear and under the stress with which the step began.
  pure real(dp) function friction_of(law, entrance) result(friction)
    type(contact_law_t), intent(in) :: law
    type(entrance_t), intent(in) :: entrance

    associate (joint => law%joint(entrance%joint), memory => entrance%memory)
      friction = joint%friction
      if (law%uses%wear) friction = worn_friction(joint%wear, friction, memory%wear)
      if (law%uses%roughness) friction = rough_friction(joint%roughness, unworn(joint%wear, memory%wear), friction, memory)
    end associate
  end function friction_of

  !> Begins a step: the springs of joints touch their curves, and joints that were dilating go on.
  pure subroutine begin_joints(law, dashpot, contact, start)
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: dashpot          !! viscosity over the size of the step, force/length
    type(contact_t), intent(in) :: contact
    type(entrance_start_t), intent(inout) :: start(2)
    integer :: k

    if (joints_bend(law)) then
      do k = 1, contact%n_entrances
        associate (closure => law%joint(contact%entrance(k)%joint)%closure, p => contact%entrance(k)%stiffness(1))
          if (closure%most > 0) start(k)%bend = starting_bend(closure, p, start(k)%gap)
          if (start(k)%gap > 0) start(k)%bend = line_at(law, contact%entrance(k), .true., start(k)%gap, start(k)%bend)
        end associate
        start(k)%damage = contact%entrance(k)%memory%damage
      end do
    end if
    if (law%uses%dilation) &
      call begin_opening(dilating_in_step(law, dashpot, contact%entrance(contact%active)), contact, start)
  end subroutine begin_joints

  !> The line that the spring across an entrance follows at a gap, after one that has led there.
  pure type(bend_t) function line_at(law, entrance, falls, gap, before) result(line)
    type(contact_law_t), intent(in) :: law
    type(entrance_t), intent(in) :: entrance
    logical, intent(in) :: falls             !! the pull of a bond that opens; else it is constant
    real(dp), intent(in) :: gap              !! length
    type(bend_t), intent(in) :: before

    associate (joint => law%joint(entrance%joint), p => entrance%stiffness(1))
      if (joint%closure%most > 0) line = touching(joint%closure, p, gap, before)
      if (gap > 0 .and. softens_in_tension(law, entrance)) line = pulled_line(joint, entrance%memory, falls, p, gap)
    end associate
  end function line_at

  !> Draws the line of the entrance that acts anew at the present gap, before the state of its contact is judged. A change counts if
  !> the force changes by more than a negligible one.
  pure subroutine judge_bend(law, falls, now, tolerance, contact, start, force, changes)
    type(contact_law_t), intent(in) :: law
    logical, intent(in) :: falls             !! the pull of a bond that opens; else it is constant
    type(gap_and_slip_t), intent(in) :: now(2)
    real(dp), intent(in) :: tolerance        !! force that changes nothing
    type(contact_t), intent(in) :: contact
    type(entrance_start_t), intent(inout) :: start(2)
    type(contact_force_t), intent(inout) :: force
    integer, intent(inout) :: changes        !! counted on
    type(bend_t) :: line
    real(dp) :: more

    if (.not. joints_bend(law)) return
    associate (k => contact%active)
      line = line_at(law, contact%entrance(k), falls, now(k)%gap, start(k)%bend)
      more = line%behind - start(k)%bend%behind - (line%stiffer - start(k)%bend%stiffer)*now(k)%gap
      if (abs(more) > tolerance) changes = changes + 1
      force%across(k) = force%across(k) + more
      force%across_by_gap(k, k) = force%across_by_gap(k, k) - (line%stiffer - start(k)%bend%stiffer)
      start(k)%bend = line
    end associate
  end subroutine judge_bend

  !> Judges how a joint dilates, after the state of its contact has been judged.
  pure subroutine judge_dilating(law, dashpot, now, tolerance, contact, start, changes)
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: dashpot          !! force/length
    type(gap_and_slip_t), intent(in) :: now(2)
    real(dp), intent(in) :: tolerance        !! force that changes nothing
    type(contact_t), intent(in) :: contact
    type(entrance_start_t), intent(inout) :: start(2)
    integer, intent(inout) :: changes        !! counted on

    if (.not. law%uses%dilation) return
    call judge_opening(dilating_in_step(law, dashpot, contact%entrance(contact%active)), now, tolerance, contact, start, changes)
  end subroutine judge_dilating

  !> How an entrance dilates in a step, and what holds back the slip by which it does.
  pure type(dilating_t) function dilating_in_step(law, dashpot, entrance) result(dilating)
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: dashpot          !! force/length
    type(entrance_t), intent(in) :: entrance

    associate (joint => law%joint(entrance%joint))
      dilating%tangent = tangent_after(joint%dilation, entrance%memory%farthest)
      if (.not. dilating%tangent > 0) return
      dilating%slip = joint%dilation%slip
      dilating%friction = friction_of(law, entrance)
      dilating%bond = bond(entrance, joint%cohesion)
      dilating%dashpot = dashpot
    end associate
  end function dilating_in_step

  !> What an entrance of a joint that dilates remembers of an accepted step.
  pure subroutine remember_dilating(law, slid, opened, pressing, memory, work)
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: slid             !! in the step, with its sign, length
    real(dp), intent(in) :: opened           !! in the step, length
    real(dp), intent(in) :: pressing         !! force
    type(joint_memory_t), intent(inout) :: memory
    real(dp), intent(inout) :: work          !! lost in friction, force length

    if (law%uses%dilation) call remember_opening(slid, opened, pressing, memory, work)
  end subroutine remember_dilating

  !> Overlap at which the spring across an entrance presses with a force, length.
  pure real(dp) function overlap_under(law, entrance, force) result(overlap)
    type(contact_law_t), intent(in) :: law
    type(entrance_t), intent(in) :: entrance
    real(dp), intent(in) :: force            !! above 0

    overlap = force/entrance%stiffness(1)
    associate (most => law%joint(entrance%joint)%closure%most)
      if (law%uses%closure .and. most > 0) overlap = overlap*most/(most + overlap)
    end associate
  end function overlap_under

  !> Energy that the spring across an entrance has beside that of a linear spring, force length per unit thickness.
  pure real(dp) function energy_beside_spring(law, entrance, overlap) result(energy)
    type(contact_law_t), intent(in) :: law
    type(entrance_t), intent(in) :: entrance
    real(dp), intent(in) :: overlap          !! length

    energy = 0.0_dp
    if (law%uses%closure) energy = closing_energy(law%joint(entrance%joint)%closure, entrance%stiffness(1), overlap)
    if (overlap < 0 .and. softens_in_tension(law, entrance)) &
      energy = pulled_energy(law%joint(entrance%joint), entrance%memory, entrance%stiffness(1), -overlap)
  end function energy_beside_spring

  !> The weaker one of two joint materials: that with the smaller friction, or of equal ones with the smaller cohesion, and so on
  !> through all that the law tells them apart by. The first one where it tells them apart by nothing.
  pure integer function weaker_joint(law, a, b) result(weaker)
    type(contact_law_t), intent(in) :: law
    integer, intent(in) :: a, b
    real(dp), allocatable :: of_a(:), of_b(:)
    integer :: k

    weaker = a
    if (a == b) return
    of_a = properties(law%joint(a))
    of_b = properties(law%joint(b))
    k = findloc(abs(of_a - of_b) > 0, .true., 1)
    if (k == 0) return
    if (of_b(k) < of_a(k)) weaker = b
  end function weaker_joint

  !> All that the law of a joint has: its strength, then its stiffness, each in its own units.
  pure function properties(joint) result(property)
    type(joint_t), intent(in) :: joint
    real(dp), allocatable :: property(:)

    associate (wear => joint%wear, roughness => joint%roughness, stiffness => joint%stiffness, dilation => joint%dilation)
      property = [joint%friction, joint%cohesion, joint%strength, wear%friction, wear%slip, &
                  roughness%jrc, roughness%jcs, roughness%cohesion, stiffness%normal, stiffness%shear, &
                  joint%closure%most, dilation%tangent, dilation%slip, joint%softening%opening, joint%softening%slip]
    end associate
  end function properties

end module scree_joint_rules
