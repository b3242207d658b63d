!> The quantities that the rules of contact speak of.
module scree_contact_quantities
  use scree_contacts, only: entrance_t
  use scree_kinds, only: dp
  implicit none
  private
  public :: bend_t, contact_force_t, entrance_start_t, gap_and_slip_t, gap_before, opening_t

  !> Pieces of the law of a joint that dilates: it does not, or it does, or it has done all it does in the step.
  integer, parameter, public :: dilates_not = 0, dilates = 1, has_dilated = 2

  !> Where a vertex is from the line of an edge.
  type :: gap_and_slip_t
    real(dp) :: gap = 0.0_dp         !! from where the spring across rests, length
    real(dp) :: slip = 0.0_dp        !! from the anchor along the edge, length
    real(dp) :: edge_length = 1.0_dp !! length
    real(dp) :: opened = 0.0_dp      !! by which the joint has dilated in the step: its spring rests so much farther out, length
  end type gap_and_slip_t

  !> Dilation of a joint in a step, as felt by its spring: a gap g and a slip s count as a gap of (g - by_slip s + behind)/softer.
  type :: opening_t
    integer :: piece = dilates_not
    real(dp) :: by_slip = 0.0_dp
    real(dp) :: behind = 0.0_dp      !! length
    real(dp) :: softer = 1.0_dp      !! as what presses holds back the slip that opens
  end type opening_t

  !> Additional force of a joint that stiffens or softens, beside that of a linear spring across, as a line: a force `behind` and
  !> `stiffer` times the overlap.
  type :: bend_t
    real(dp) :: closed = 0.0_dp      !! where it touches the curve, length
    real(dp) :: behind = 0.0_dp      !! force
    real(dp) :: stiffer = 0.0_dp     !! force/length
  end type bend_t

  !> An entrance at the beginning of the step.
  type :: entrance_start_t
    real(dp) :: gap = 0.0_dp     !! length
    real(dp) :: share = 0.0_dp   !! of the edge, at the foot of the vertex
    logical :: closed = .false.
    logical :: anchored = .false. !! in this step the anchor has its place: where it met the edge, or back at that share
    real(dp) :: multiplier(2) = 0.0_dp !! forces across and along that the springs need not make up
    real(dp) :: hardening = 1.0_dp !! of the springs in this step, so that multipliers follow faster
    type(opening_t) :: opening     !! that the iteration has come to
    type(bend_t) :: bend           !! likewise
    logical :: bonded = .false.
    real(dp) :: damage = 0.0_dp    !! of its bond
  end type entrance_start_t

  !> The force of a contact per unit thickness, and its derivatives by the gaps of both entrances and by the slip of the active
  !> entrance.
  type :: contact_force_t
    real(dp) :: across(2) = 0.0_dp           !! each entrance, pressing where positive
    real(dp) :: along = 0.0_dp               !! the entrance that acts
    real(dp) :: across_by_gap(2, 2) = 0.0_dp !! (gap of either, entrance) force/length
    real(dp) :: across_by_slip = 0.0_dp      !! the entrance that acts, force/length
    real(dp) :: along_by_gap(2) = 0.0_dp     !! force/length
    real(dp) :: along_by_slip = 0.0_dp       !! force/length
  end type contact_force_t

contains

  !> Gap of the dashpot of an entrance when the step began. Only a bonded entrance has a gap above 0, because it may be stretched.
  pure real(dp) function gap_before(start, entrance)
    type(entrance_start_t), intent(in) :: start
    type(entrance_t), intent(in) :: entrance

    gap_before = start%gap
    if (.not. entrance%memory%bonded) gap_before = min(start%gap, 0.0_dp)
  end function gap_before

end module scree_contact_quantities
