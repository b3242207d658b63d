!> Contact by Coulomb's rules: springs across and along, friction of the same solution (Shi's df22, with states of one solution).
!>
!> A closed contact has a spring p across the line of its entrance and, locked, a spring k along it that holds the vertex at its
!> anchor:
!>
!>     N = h - p g - c (g - g0)/dt   pressing where positive; closed where N > 0, or above the strength of its bond
!>     T = h' - k s                  s: slip from the anchor
!>     |T| <= N tan phi + c l        else it slides: T = -+(N tan phi + c l), and the anchor follows
!>
!> The forces h and h' are zero but with multipliers (augmented Lagrangian); g0 is the gap when the step begins, 0 where that is
!> positive and no bond holds the contact.
module scree_coulomb_contact
  use scree_bond_rules, only: bond, softens_in_shear
  use scree_contact_quantities, only: contact_force_t, entrance_start_t, gap_and_slip_t, gap_before
  use scree_contacts, only: contact_law_t, contact_t, entrance_t, state_locked, state_open, state_sliding
  use scree_joint_rules, only: friction_of
  use scree_kinds, only: dp
  implicit none
  private
  public :: act_on, add_friction, anchor_where_crossed, judge_closed, judge_coulomb, press_springs, set_state, slide_coulomb

  !> Two lines are crossed at once if the times over the step, or the distances across, differ by less than this ratio.
  real(dp), parameter :: at_once = 1e-6_dp

contains

  !> Forces across the entrances of a contact by spring, multiplier and dashpot, each as if it were the one that acts.
  pure subroutine press_springs(stiffness, dashpot, contact, start, now, force)
    real(dp), intent(in) :: stiffness           !! force/length
    real(dp), intent(in) :: dashpot             !! viscosity over the size of the step, force/length
    type(contact_t), intent(in) :: contact
    type(entrance_start_t), intent(in) :: start(2)
    type(gap_and_slip_t), intent(in) :: now(2)
    type(contact_force_t), intent(out) :: force
    integer :: k

    do k = 1, contact%n_entrances
      force%across(k) = contact%entrance(k)%multiplier(1) - stiffness*now(k)%gap
      force%across_by_gap(k, k) = -stiffness - dashpot
    end do
    if (.not. dashpot > 0) return
    do k = 1, contact%n_entrances
      force%across(k) = force%across(k) - dashpot*(now(k)%gap - gap_before(start(k), contact%entrance(k)))
    end do
  end subroutine press_springs

  !> Adds the friction of a sliding contact that presses with the forces of the same solution. A bond that is pulled by more than it
  !> rubs by has none: its direction is 0.
  pure subroutine add_friction(law, entrance, force)
    type(contact_law_t), intent(in) :: law
    type(entrance_t), intent(in) :: entrance       !! that acts
    type(contact_force_t), intent(inout) :: force  !! with those across the entrances that press
    real(dp) :: friction

    friction = friction_of(law, entrance)
    force%along = friction*(force%across(1) + force%across(2)) + bond(entrance, law%joint(entrance%joint)%cohesion)
    force%along_by_gap = friction*(force%across_by_gap(:, 1) + force%across_by_gap(:, 2))
    force%along = -entrance%direction*force%along
    force%along_by_gap = -entrance%direction*force%along_by_gap
    force%along_by_slip = -entrance%direction*friction*force%across_by_slip
  end subroutine add_friction

  !> Judges a contact: which entrance acts, and in which state it is.
  pure subroutine judge_coulomb(law, lines_stay, start, now, force, tolerance, contact, changes)
    type(contact_law_t), intent(in) :: law
    logical, intent(in) :: lines_stay      !! the entrance that acts, and its anchor
    type(entrance_start_t), intent(in) :: start(2)
    type(gap_and_slip_t), intent(in) :: now(2)
    type(contact_force_t), intent(in) :: force
    real(dp), intent(in) :: tolerance      !! force that changes no state
    type(contact_t), intent(inout) :: contact
    integer, intent(inout) :: changes      !! of states, counted on
    real(dp) :: direction
    integer :: k, state

    k = 1
    if (contact%n_entrances == 2) k = entrance_that_acts(contact, start, now, force%across, tolerance)
    if (lines_stay) k = contact%active
    call act_on(k, contact, changes)
    state = state_open
    associate (entrance => contact%entrance(k))
      direction = entrance%direction
      if (is_closed(entrance, force%across(k), tolerance)) &
        call judge_closed(law, lines_stay, start(k), now(k), force%across(k), tolerance, entrance, state)
      if (entrance%state == state_sliding .and. state == state_sliding .and. &
          (abs(direction) > 0 .neqv. abs(entrance%direction) > 0)) changes = changes + 1
      call set_state(state, abs(force%across(k)) > tolerance, entrance, changes)
    end associate
  end subroutine judge_coulomb

  !> Which of the two entrances of a corner acts. In general it is the one that is crossed least. If both are crossed, it is the one
  !> that was crossed last, or the one that no third block covers. A bonded entrance always acts.
  !>
  !> An entrance that pressed when the step began goes on to press, as if its edge did not end: a corner that slips off in the step
  !> is held to the end of the step. If it were released where it leaves the other line, its force would jump, and some steps would
  !> have no solution.
  pure integer function entrance_that_acts(contact, start, now, across, tolerance) result(k)
    type(contact_t), intent(in) :: contact
    type(entrance_start_t), intent(in) :: start(2)
    type(gap_and_slip_t), intent(in) :: now(2)
    real(dp), intent(in) :: across(2), tolerance !! force

    k = 1
    associate (active => contact%active)
      if (start(active)%closed .and. across(active) > 0) then
        k = active
      else if (minval(across) < 0) then
        if (across(2) < across(1)) k = 2
      else if (contact%covered_line > 0) then
        k = 3 - contact%covered_line
      else
        k = crossed_last(merge(0.0_dp, [start(1)%gap, start(2)%gap], start%closed), [now(1)%gap, now(2)%gap])
      end if
      if (abs(across(2) - across(1)) <= tolerance) k = active
      if (contact%entrance(active)%memory%bonded .and. contact%entrance(active)%state /= state_open) k = active
    end associate
  end function entrance_that_acts

  !> Which of two lines, both crossed at the end of the step, was crossed last: there the vertices entered. Of two that are crossed
  !> at once, as by corners that touch tip to tip, that which is crossed less.
  pure integer function crossed_last(from, to)
    real(dp), intent(in) :: from(2), to(2) !! gaps at the beginning and at the end of the step, length
    real(dp) :: met(2)                     !! time over the step at which each was crossed; 0: before

    met = max(from, 0.0_dp)/(max(from, 0.0_dp) + abs(to) + tiny(to))
    if (abs(met(2) - met(1)) > at_once) then
      crossed_last = maxloc(met, 1)
    else if (maxval(met) <= at_once .and. abs(from(2) - from(1)) > at_once*maxval(abs(to))) then
      crossed_last = maxloc(from, 1)
    else
      crossed_last = maxloc(to, 1)
    end if
  end function crossed_last

  !> Lets entrance k of a contact act. The one that it leaves opens, which is a change where it was closed.
  pure subroutine act_on(k, contact, changes)
    integer, intent(in) :: k
    type(contact_t), intent(inout) :: contact
    integer, intent(inout) :: changes

    if (k == contact%active) return
    if (contact%entrance(contact%active)%state /= state_open) changes = changes + 1
    contact%entrance(contact%active)%state = state_open
    contact%active = k
  end subroutine act_on

  !> Whether an entrance with this pressing force, or pull below 0, is closed. A negligible pull does not open a closed entrance.
  !> Blocks that fall together have no other forces between them, and each change would cause larger ones. No pull opens a bond,
  !> which breaks only after the step has settled.
  pure logical function is_closed(entrance, across, tolerance)
    type(entrance_t), intent(in) :: entrance
    real(dp), intent(in) :: across, tolerance !! force

    if (entrance%state == state_open) then
      is_closed = across >= 0
    else
      is_closed = entrance%memory%bonded .or. across >= -tolerance
    end if
  end function is_closed

  !> Judges the friction of an entrance that is closed. One that was open when the step began first gets an anchor.
  pure subroutine judge_closed(law, anchor_stays, start, now, pressing, tolerance, entrance, state)
    type(contact_law_t), intent(in) :: law
    logical, intent(in) :: anchor_stays
    type(entrance_start_t), intent(in) :: start
    type(gap_and_slip_t), intent(in) :: now
    real(dp), intent(in) :: pressing, tolerance !! force
    type(entrance_t), intent(inout) :: entrance
    integer, intent(out) :: state
    real(dp) :: slip

    slip = now%slip
    if (entrance%state == state_open .and. .not. anchor_stays) call anchor_where_crossed(start, now, entrance, slip)
    call judge_friction(law, slip, pressing, tolerance, entrance, state)
  end subroutine judge_closed

  !> Puts the anchor of an entrance that closes where its vertex first crossed the line in the step; one that was closed when the
  !> step began, or is bonded, keeps its own.
  !>
  !> One that has its place stays there: where the prediction met the edge, or back where the step began. An anchor that moved on
  !> with every iteration would hold back what it follows, and the iteration would creep.
  pure subroutine anchor_where_crossed(start, now, entrance, slip)
    type(entrance_start_t), intent(in) :: start
    type(gap_and_slip_t), intent(in) :: now
    type(entrance_t), intent(inout) :: entrance
    real(dp), intent(inout) :: slip !! from the anchor, length
    real(dp) :: along
    real(dp) :: share               ! of its way, after which it crosses; of one that parts, of what began nearly there the first

    if (.not. start%gap > 0 .or. start%closed .or. start%anchored .or. entrance%memory%bonded) return
    along = slip + entrance%anchor*now%edge_length
    share = start%gap/max(start%gap - now%gap, start%gap, now%gap)
    entrance%anchor = start%share + share*(along/now%edge_length - start%share)
    slip = along - entrance%anchor*now%edge_length
  end subroutine anchor_where_crossed

  !> Whether a closed entrance slides or is locked, and in which direction it slides, judged with the normal force of the same
  !> solution. A bond slides without a direction if a pull takes all of its shear strength.
  pure subroutine judge_friction(law, slip, pressing, tolerance, entrance, state)
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: slip            !! length
    real(dp), intent(in) :: pressing, tolerance !! force
    type(entrance_t), intent(inout) :: entrance
    integer, intent(out) :: state
    real(dp) :: limit, rubs_by, shear
    logical :: pulled

    shear = entrance%multiplier(2) - entrance%stiffness(2)*slip
    rubs_by = friction_of(law, entrance)*pressing + bond(entrance, law%joint(entrance%joint)%cohesion)
    limit = max(0.0_dp, rubs_by)
    pulled = entrance%memory%bonded .and. rubs_by < 0
    if (entrance%state == state_sliding .and. abs(rubs_by) <= tolerance) pulled = .not. abs(entrance%direction) > 0
    if (entrance%state == state_sliding .and. limit > tolerance .and. entrance%direction*shear > 0) then
      state = state_locked ! it turned back; whether it slides there the next iteration tells
    else if (entrance%state /= state_open .and. abs(abs(shear) - limit) <= tolerance) then
      state = entrance%state
    else
      state = merge(state_locked, state_sliding, abs(shear) < limit)
    end if
    if (state == state_sliding) entrance%direction = merge(0.0_dp, sign(1.0_dp, -shear), pulled)
  end subroutine judge_friction

  !> Gives an entrance its state. A change counts if the entrance closes or opens with more than a negligible force, or if it
  !> changes between sliding and locked.
  pure subroutine set_state(state, felt, entrance, changes)
    integer, intent(in) :: state
    logical, intent(in) :: felt         !! the force is more than negligible
    type(entrance_t), intent(inout) :: entrance
    integer, intent(inout) :: changes

    if (state /= entrance%state .and. (felt .or. min(state, entrance%state) /= state_open)) changes = changes + 1
    entrance%state = state
  end subroutine set_state

  !> What an entrance remembers of sliding: its anchor follows, but for what its spring keeps, and a bond that yields breaks unless
  !> its joint holds elsewhere or the bond softens. A bond without shear strength has none to lose.
  pure subroutine slide_coulomb(law, shear, edge_length, holds, entrance, slip, work)
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: shear        !! force
    real(dp), intent(in) :: edge_length  !! length
    logical, intent(in) :: holds         !! another bond between the two blocks is locked
    type(entrance_t), intent(inout) :: entrance
    real(dp), intent(inout) :: slip      !! of the step, then what the spring keeps of it, length
    real(dp), intent(out) :: work        !! lost in friction, force length
    real(dp) :: kept

    kept = (entrance%multiplier(2) - shear)/entrance%stiffness(2)
    work = abs(shear*(slip - kept))
    entrance%anchor = entrance%anchor + (slip - kept)/edge_length
    entrance%memory%slid = entrance%memory%slid + abs(slip - kept)
    entrance%memory%wear = entrance%memory%wear + abs(slip - kept)
    slip = kept
    entrance%memory%bonded = entrance%memory%bonded .and. (holds .or. .not. abs(shear) > 0 .or. softens_in_shear(law, entrance))
  end subroutine slide_coulomb

end module scree_coulomb_contact
