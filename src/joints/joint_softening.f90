!> Bonds that soften: they lose their strength over a displacement, and take energy from the motion as they do.
!>
!> A bond that stands for a length l of joint has the damage d, from 0 where it is intact to 1 where it is broken. It bears at most
!> the pull (1 - d) T l, and in shear (1 - d) c l beside friction. Under a pull the spring p of the contact and the crack in the
!> bond open one after the other:
!>
!>     g = t/p + w,    t = K g,    1/K = 1/p + d wc/((1 - d) T l),    wc = 2 G/T
!>
!> g is the gap, t the pull, w the opening of the crack, and G the fracture energy. A bond that is let back closes along the line to
!> the origin. The damage is the largest value so far of ((w/wc)^2 + (s/sc)^2)^(1/2), with the slip s and sc = 2 G_II/c. A bond that
!> is pulled without shear has lost the energy G l d. A bond that shears without a pull has lost G_II l d (2 - d), because its slip
!> stays.
!>
!> A spring follows the pull as lines: one to (1 - d) T l, with the damage d at the beginning of the step, and one that falls from
!> there to 0 at the gap wc (`pulled_line`). Newton's iteration ends on the right line where the bodies are stiffer than the line
!> falls. Where they are not it runs in circles. The pull is then constant beyond (1 - d) T l, the damage follows the gap at which
!> the step has settled (`damage_at`), and the step settles again, until the damage stays or the bond is broken.
!>
!> Equations eq-softening and eq-damage of doc/theory/contact-laws.md. The linear law is that of Hillerborg, Modeer & Petersson,
!> Cem. Concr. Res. 6, 1976.
module scree_joint_softening
  use scree_contact_quantities, only: bend_t
  use scree_joint_law, only: joint_memory_t, joint_t
  use scree_kinds, only: dp
  implicit none
  private
  public :: damage_at, lost_in_opening, lost_in_shear, pulled_energy, pulled_line, softens

  !> Slope of the line beyond the largest pull over the slope by which the pull falls. The line touches the constant pull where the
  !> iteration ends, so that the slope has no effect there. It keeps the springs of friction problems stiffer than 0.
  real(dp), parameter :: flat = 1e-3_dp

contains

  !> Whether the bonds of a joint soften, in tension or in shear.
  elemental logical function softens(joint)
    type(joint_t), intent(in) :: joint

    softens = joint%softening%opening > 0 .or. joint%softening%slip > 0
  end function softens

  !> Largest pull that a bond bears, and the opening of its crack there.
  pure subroutine largest_pull(joint, memory, pull, opening)
    type(joint_t), intent(in) :: joint
    type(joint_memory_t), intent(in) :: memory
    real(dp), intent(out) :: pull    !! force
    real(dp), intent(out) :: opening !! length

    pull = (1 - memory%damage)*joint%strength*memory%length
    opening = memory%damage*joint%softening%opening
  end subroutine largest_pull

  !> The line that the pull of a bond follows at a gap above 0, as the additional force beside the spring p.
  pure type(bend_t) function pulled_line(joint, memory, falls, p, gap) result(line)
    type(joint_t), intent(in) :: joint
    type(joint_memory_t), intent(in) :: memory
    logical, intent(in) :: falls     !! beyond the largest pull; else the pull is constant there
    real(dp), intent(in) :: p        !! force/length
    real(dp), intent(in) :: gap      !! length
    real(dp) :: at, opening, pull, slope

    call largest_pull(joint, memory, pull, opening)
    at = pull/p + opening
    if (.not. gap > at) then
      if (opening > 0) line%stiffer = pull/at - p
      return
    end if
    slope = 0.0_dp
    if (.not. falls) then
      slope = flat*joint%strength*memory%length/joint%softening%opening
      line%behind = slope*gap - pull
    else if (gap < joint%softening%opening) then
      slope = -pull/(joint%softening%opening - at)
      line%behind = slope*joint%softening%opening
    end if
    line%stiffer = slope - p
  end function pulled_line

  !> Energy that a pulled bond stores beside that of the spring p, which is below 0, force length per unit thickness.
  pure real(dp) function pulled_energy(joint, memory, p, gap) result(energy)
    type(joint_t), intent(in) :: joint
    type(joint_memory_t), intent(in) :: memory
    real(dp), intent(in) :: p        !! force/length
    real(dp), intent(in) :: gap      !! length
    real(dp) :: opening, pull

    call largest_pull(joint, memory, pull, opening)
    energy = 0.0_dp
    if (opening > 0) energy = 0.5_dp*(pull/(pull/p + opening) - p)*gap**2
  end function pulled_energy

  !> Damage of a bond that has come to a gap and a slip, which is at least the damage that it began with.
  !>
  !> The opening of the crack is the gap less what the spring gives, w = g - (1 - d) T l/p, so that d is the root of a quadratic
  !> equation. A bond whose spring stores as much as the fracture energy breaks at once.
  pure real(dp) function damage_at(joint, memory, p, gap, slip, least) result(damage)
    type(joint_t), intent(in) :: joint
    type(joint_memory_t), intent(in) :: memory
    real(dp), intent(in) :: p        !! force/length
    real(dp), intent(in) :: gap      !! length
    real(dp), intent(in) :: slip     !! that the bond has sheared by since it was made, length
    real(dp), intent(in) :: least    !! damage that it began with
    real(dp) :: apart, given, sheared

    sheared = 0.0_dp
    if (joint%softening%slip > 0) sheared = slip/joint%softening%slip
    damage = max(least, sheared)
    if (joint%softening%opening > 0) then
      given = joint%strength*memory%length/p/joint%softening%opening
      apart = gap/joint%softening%opening - given
      if (given >= 1) then
        if (apart > 0) damage = 1.0_dp
      else if (apart + given*sheared > 0) then
        damage = max(damage, (apart*given + sqrt(apart**2 + (1 - given**2)*sheared**2))/(1 - given**2))
      end if
    end if
    damage = min(damage, 1.0_dp)
  end function damage_at

  !> Energy that a bond lost as its crack opened in a step, force length per unit thickness. It is exact where the bond is only
  !> pulled, and of second order in the step where it shears too.
  pure real(dp) function lost_in_opening(joint, memory, before, slip) result(energy)
    type(joint_t), intent(in) :: joint
    type(joint_memory_t), intent(in) :: memory !! at the end of the step
    real(dp), intent(in) :: before   !! damage at its beginning
    real(dp), intent(in) :: slip     !! in the step, length
    real(dp) :: sheared              ! part of the damage that is of shear

    energy = 0.0_dp
    if (.not. memory%damage > before) return
    sheared = 0.0_dp
    if (joint%softening%slip > 0) &
      sheared = min(1.0_dp, (memory%slid - 0.5_dp*slip)/joint%softening%slip/(0.5_dp*(before + memory%damage)))
    energy = 0.5_dp*joint%softening%opening*joint%strength*memory%length*(1 - sheared**2)*(memory%damage - before)
  end function lost_in_opening

  !> Energy that the cohesion of a bond lost as the bond slipped in a step, without friction, force length per unit thickness.
  pure real(dp) function lost_in_shear(joint, memory, before, slip) result(energy)
    type(joint_t), intent(in) :: joint
    type(joint_memory_t), intent(in) :: memory !! at the end of the step
    real(dp), intent(in) :: before   !! damage at its beginning
    real(dp), intent(in) :: slip     !! in the step, length

    associate (most => joint%softening%slip)
      energy = (1 - 0.5_dp*(before + memory%damage))*joint%cohesion*memory%length* &
               (min(memory%slid, most) - min(memory%slid - slip, most))
    end associate
  end function lost_in_shear

end module scree_joint_softening
