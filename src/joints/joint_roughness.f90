!> Joints whose strength follows the stress s across them: rough ones, and those with cohesion that is not that of a bond.
!>
!>     tau = s tan(phi + JRC log10(JCS/s)) + c      (Barton & Choubey, Rock Mechanics 10, 1977; JRC in degrees)
!>
!> A step has the slope of tau from the origin as its friction, at the stress that a contact bore when the step began. In a static
!> step that is the stress at which the step had settled before.
!>
!> The curve is in doc/theory/contact-laws.md, eq-roughness.
module scree_joint_roughness
  use scree_joint_law, only: joint_memory_t, roughness_t
  use scree_kinds, only: dp, pi
  implicit none
  private
  public :: follows_stress, rough_friction

  !> Steepest friction of a joint under little stress, rad (Barton 1973).
  real(dp), parameter :: steepest = 70*pi/180

contains

  !> Whether the strength of a joint follows the stress across it.
  elemental logical function follows_stress(roughness)
    type(roughness_t), intent(in) :: roughness

    follows_stress = roughness%jrc > 0 .or. roughness%cohesion > 0
  end function follows_stress

  !> Friction of an entrance by the stress that it bore: the slope of tau/s, and no more than that of 70 degrees. An entrance that
  !> bore nothing has tan(phi), so that no contact rests on a stress that it does not have. A bond has no cohesion of this kind.
  pure real(dp) function rough_friction(roughness, unworn, friction, memory) result(slope)
    type(roughness_t), intent(in) :: roughness
    real(dp), intent(in) :: unworn   !! part of the roughness that is left
    real(dp), intent(in) :: friction !! tangent of phi, the friction angle without roughness
    type(joint_memory_t), intent(in) :: memory
    real(dp) :: angle, cohesion, jrc, stress

    slope = friction
    jrc = roughness%jrc*unworn
    cohesion = merge(0.0_dp, roughness%cohesion, memory%bonded)
    if (.not. (jrc > 0 .or. cohesion > 0) .or. friction >= tan(steepest)) return
    if (.not. (memory%pressing > 0 .and. memory%length > 0)) return
    stress = memory%pressing/memory%length
    angle = atan(friction)
    if (jrc > 0) angle = angle + jrc*max(0.0_dp, log10(roughness%jcs) - log10(stress))
    slope = tan(steepest)
    if (angle < steepest) slope = min(slope, tan(angle) + cohesion/stress)
  end function rough_friction

end module scree_joint_roughness
