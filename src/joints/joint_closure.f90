!> Joints that stiffen as they close.
!>
!> The stress across a joint that is closed by u, of at most V, is a hyperbola of u (Bandis, Lumsden & Barton, Int. J. Rock Mech.
!> Min. Sci. 20, 1983); a contact that stands for a length l of it presses with
!>
!>     N(u) = p u/(1 - u/V),    p = kn l,    its energy    p V^2 (-log(1 - u/V) - u/V),    its slope    K = p/(1 - u/V)^2
!>
!> A step uses the line N(u0) + K(u0) (u - u0). Each judgement of the contacts draws the line anew at the present u, until the
!> solution with a line is on the curve: Newton's iteration. While the joint opens, the line touches the curve at u itself. While
!> the joint closes, the line is below the curve and u may exceed V. It then touches where the curve has the force of the last line.
!>
!> The curve is in doc/theory/contact-laws.md, eq-closure.
module scree_joint_closure
  use scree_contact_quantities, only: bend_t, contact_force_t, entrance_start_t, gap_and_slip_t
  use scree_joint_law, only: closure_t
  use scree_kinds, only: dp
  implicit none
  private
  public :: bend_springs, closing_energy, starting_bend, touching

contains

  !> The line that touches the curve at a closure, as what the spring has beside p times the overlap.
  pure type(bend_t) function bend_at(closed, p, most) result(bend)
    real(dp), intent(in) :: closed !! length
    real(dp), intent(in) :: p      !! force/length
    real(dp), intent(in) :: most   !! largest closure, length
    real(dp) :: left

    left = 1 - closed/most
    bend%closed = closed
    bend%behind = -p*closed**2/(most*left**2)
    bend%stiffer = p*closed/most*(1 + left)/left**2
  end function bend_at

  !> The line at the overlap at the beginning of the step. If a later stage has a smaller largest closure, the overlap may exceed
  !> it. The line is then drawn where the curve has the force of a linear spring.
  pure type(bend_t) function starting_bend(closure, p, gap) result(bend)
    type(closure_t), intent(in) :: closure
    real(dp), intent(in) :: p      !! force/length
    real(dp), intent(in) :: gap    !! length

    if (-gap < closure%most) bend%closed = max(0.0_dp, -gap)
    bend = touching(closure, p, gap, bend)
  end function starting_bend

  !> The line for a gap, after one that has led there.
  pure type(bend_t) function touching(closure, p, gap, bend) result(next)
    type(closure_t), intent(in) :: closure
    real(dp), intent(in) :: p              !! force/length
    real(dp), intent(in) :: gap            !! length
    type(bend_t), intent(in) :: bend
    real(dp) :: closed, force

    closed = max(0.0_dp, -gap)
    if (closed > bend%closed) then
      force = bend%behind + (p + bend%stiffer)*closed
      closed = force*closure%most/(p*closure%most + force)
    end if
    next = bend_at(closed, p, closure%most)
  end function touching

  !> Adds to the forces of linear springs what those of joints that stiffen have beside.
  pure subroutine bend_springs(start, now, force)
    type(entrance_start_t), intent(in) :: start(2)
    type(gap_and_slip_t), intent(in) :: now(2)
    type(contact_force_t), intent(inout) :: force
    integer :: k

    do k = 1, 2
      force%across(k) = force%across(k) + start(k)%bend%behind - start(k)%bend%stiffer*now(k)%gap
      force%across_by_gap(k, k) = force%across_by_gap(k, k) - start(k)%bend%stiffer
    end do
  end subroutine bend_springs

  !> Energy that the spring across has beside that of a linear one at an overlap, force length per unit thickness.
  pure real(dp) function closing_energy(closure, p, overlap) result(energy)
    type(closure_t), intent(in) :: closure
    real(dp), intent(in) :: p                 !! force/length
    real(dp), intent(in) :: overlap           !! length
    real(dp) :: closed
    real(dp), parameter :: small = 1e-3_dp    !! closure over the largest, below which the logarithm loses more than a series

    energy = 0.0_dp
    if (.not. (closure%most > 0 .and. overlap > 0)) return
    closed = min(overlap/closure%most, 1 - epsilon(closed))
    if (closed < small) then
      energy = closed**3*(1.0_dp/3 + closed*(0.25_dp + closed*(0.2_dp + closed/6)))
    else
      energy = -log(1 - closed) - closed - 0.5_dp*closed**2
    end if
    energy = energy*p*closure%most**2
  end function closing_energy

end module scree_joint_closure
