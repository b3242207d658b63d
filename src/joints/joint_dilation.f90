!> Joints that dilate: their faces part as they slide over each other's roughness.
!>
!> Let S be the signed distance that a contact has slid since it was found, without the elastic part of its spring, and M the
!> largest |S| so far. The spring across rests farther out by delta, and presses with N = -p (g - delta):
!>
!>     d delta = tan(psi) dM    while M is below the slip at which dilation ends
!>
!> A joint that slides back stays apart, and opens again only beyond its largest slip (Goodman, Methods of Geological Engineering,
!> 1976, for psi; the end is that of UDEC, Itasca). The strength stays N tan(phi) + c with phi the whole angle. So a part
!> N tan(psi) ds of the work of friction lifts, and no energy is made if psi is not above phi.
!>
!> A step solves all of this together. Let s be the slip from the anchor and a = +-s - (N tan(phi) + c)/k the sliding in the step.
!> The contact may slide by M - +-S before it dilates, and
!>
!>     g_felt = g - tan(psi) (a - (M - +-S)),   N = A - B g_felt,   B = p + c/dt
!>
!> which is linear in g and s; it is one of three pieces, and the open-close iteration judges which.
!>
!> The formulas are in doc/theory/contact-laws.md, eq-dilation and eq-felt-gap.
module scree_joint_dilation
  use scree_contact_quantities, only: contact_force_t, dilates, dilates_not, entrance_start_t, gap_and_slip_t, gap_before, &
                                      has_dilated, opening_t
  use scree_contacts, only: contact_t, entrance_t, state_locked, state_sliding
  use scree_joint_law, only: dilation_t, joint_memory_t
  use scree_kinds, only: dp
  implicit none
  private
  public :: begin_opening, dilating_t, feel_opening, feel_opening_change, judge_opening, remember_opening, tangent_after

  !> How an entrance dilates in a step, and what holds back the slip by which it does.
  type :: dilating_t
    real(dp) :: tangent = 0.0_dp  !! of the dilation angle; 0: it does not dilate, or not any more
    real(dp) :: slip = 0.0_dp     !! at which dilation ends, length
    real(dp) :: friction = 0.0_dp !! tangent of the friction angle
    real(dp) :: bond = 0.0_dp     !! force of its cohesion
    real(dp) :: dashpot = 0.0_dp  !! viscosity over the size of the step, force/length
  end type dilating_t

contains

  !> Tangent of the dilation angle after the farthest slip so far; 0 where the joint does not dilate any more.
  pure real(dp) function tangent_after(dilation, farthest) result(tangent)
    type(dilation_t), intent(in) :: dilation
    real(dp), intent(in) :: farthest         !! length

    tangent = merge(dilation%tangent, 0.0_dp, farthest < dilation%slip)
  end function tangent_after

  !> What an entrance dilates by in the step, on a piece of the law.
  pure type(opening_t) function opening_on(piece, dilating, start, entrance) result(opening)
    integer, intent(in) :: piece
    type(dilating_t), intent(in) :: dilating
    type(entrance_start_t), intent(in) :: start
    type(entrance_t), intent(in) :: entrance

    opening%piece = piece
    if (piece == dilates_not) return
    if (piece == has_dilated) then
      opening%behind = -dilating%tangent*(dilating%slip - entrance%memory%farthest)
      return
    end if
    associate (k => entrance%stiffness(2), tangent => dilating%tangent, friction => dilating%friction, dashpot => dilating%dashpot)
      opening%by_slip = tangent*entrance%direction
      opening%softer = 1 + tangent*friction/k*(entrance%stiffness(1) + start%bend%stiffer + dashpot)
      opening%behind = tangent*(entrance%memory%farthest - entrance%direction*entrance%memory%displaced &
                                + (dilating%bond + friction*(start%bend%behind + dashpot*gap_before(start, entrance)))/k)
    end associate
  end function opening_on

  !> Begins with a contact that slides on as it did.
  pure subroutine begin_opening(dilating, contact, start)
    type(dilating_t), intent(in) :: dilating !! of the entrance that acts
    type(contact_t), intent(in) :: contact
    type(entrance_start_t), intent(inout) :: start(2)

    associate (entrance => contact%entrance(contact%active), own => start(contact%active))
      if (entrance%state /= state_sliding .or. entrance%direction*entrance%memory%displaced < entrance%memory%farthest) return
      if (dilating%tangent > 0) own%opening = opening_on(dilates, dilating, own, entrance)
    end associate
  end subroutine begin_opening

  !> The gap as the spring across feels it.
  pure subroutine feel_opening(opening, now)
    type(opening_t), intent(in) :: opening
    type(gap_and_slip_t), intent(inout) :: now
    real(dp) :: felt

    felt = (now%gap - opening%by_slip*now%slip + opening%behind)/opening%softer
    now%opened = now%gap - felt
    now%gap = felt
  end subroutine feel_opening

  !> What forces across change by with gap and slip, where they follow what the entrance that acts feels.
  pure subroutine feel_opening_change(opening, active, force)
    type(opening_t), intent(in) :: opening
    integer, intent(in) :: active
    type(contact_force_t), intent(inout) :: force

    associate (by_gap => force%across_by_gap(active, active))
      by_gap = by_gap/opening%softer
      force%across_by_slip = -by_gap*opening%by_slip
    end associate
  end subroutine feel_opening_change

  !> Judges how the active entrance dilates, after its state has been judged. A change counts if the force changes by more than a
  !> negligible one.
  !>
  !> In one judgement a piece is replaced only by the next one. A joint that opens presses more and slides less, and a slide that
  !> nothing has held yet would jump to the end.
  pure subroutine judge_opening(dilating, now, tolerance, contact, start, changes)
    type(dilating_t), intent(in) :: dilating !! of the entrance that acts
    type(gap_and_slip_t), intent(in) :: now(2)
    real(dp), intent(in) :: tolerance        !! force that changes nothing
    type(contact_t), intent(in) :: contact
    type(entrance_start_t), intent(inout) :: start(2)
    integer, intent(inout) :: changes
    type(gap_and_slip_t) :: felt
    integer :: piece

    start(3 - contact%active)%opening = opening_t()
    associate (entrance => contact%entrance(contact%active), own => start(contact%active), here => now(contact%active))
      if (.not. dilating%tangent > 0) return
      piece = piece_at(dilating, own, here, entrance)
      if (entrance%state == state_locked .or. entrance%state == state_sliding) &
        piece = max(own%opening%piece - 1, min(own%opening%piece + 1, piece))
      own%opening = opening_on(piece, dilating, own, entrance)
      felt = here
      felt%gap = here%gap + here%opened
      call feel_opening(own%opening, felt)
      if (abs(felt%gap - here%gap)*(entrance%stiffness(1) + own%bend%stiffer + dilating%dashpot) > tolerance) changes = changes + 1
    end associate
  end subroutine judge_opening

  !> Piece of the law that an entrance is on, by what it slides in the step.
  pure integer function piece_at(dilating, start, now, entrance) result(piece)
    type(dilating_t), intent(in) :: dilating
    type(entrance_start_t), intent(in) :: start
    type(gap_and_slip_t), intent(in) :: now
    type(entrance_t), intent(in) :: entrance
    real(dp) :: limit, pressing, reached

    piece = dilates_not
    pressing = start%bend%behind + dilating%dashpot*gap_before(start, entrance) &
               - (entrance%stiffness(1) + start%bend%stiffer + dilating%dashpot)*now%gap
    if (entrance%state /= state_sliding .or. .not. pressing > 0) return
    limit = dilating%friction*pressing + dilating%bond
    reached = entrance%direction*(entrance%memory%displaced + now%slip) - limit/entrance%stiffness(2)
    if (reached > entrance%memory%farthest) piece = dilates
    if (reached > dilating%slip) piece = has_dilated
  end function piece_at

  !> What an entrance remembers of sliding in an accepted step; what lifted is no loss of friction.
  pure subroutine remember_opening(slid, opened, pressing, memory, work)
    real(dp), intent(in) :: slid             !! in the step, with its sign, length
    real(dp), intent(in) :: opened           !! in the step, length
    real(dp), intent(in) :: pressing         !! force
    type(joint_memory_t), intent(inout) :: memory
    real(dp), intent(inout) :: work          !! lost in friction, force length

    memory%displaced = memory%displaced + slid
    memory%farthest = max(memory%farthest, abs(memory%displaced))
    memory%dilated = memory%dilated + opened
    work = work - pressing*opened
  end subroutine remember_opening

end module scree_joint_dilation
