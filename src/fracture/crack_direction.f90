!> Direction in which a crack grows, and the stress intensity that decides whether it does: the maximum circumferential stress.
!>
!> At the angle t from the direction of the crack, the circumferential stress at its tip is K(t)/(2 pi r)^(1/2) with
!>
!>     K(t) = cos^2(t/2) [K_I cos(t/2) - 3 K_II sin(t/2)].
!>
!> The crack grows where K(t) is largest, in mode I, and grows if K(t) has reached the toughness (Erdogan and Sih 1963).
module scree_crack_direction
  use scree_kinds, only: dp
  implicit none
  private
  public :: growth_angle, hoop_intensity

contains

  !> Angle of the largest circumferential stress from the direction of the crack, counter-clockwise, rad.
  !>
  !> tan(t/2) is a root of 2 K_II tan^2(t/2) - K_I tan(t/2) - K_II = 0: that of the maximum, in a form that keeps its digits. A tip
  !> whose faces are pressed together has K_I = 0. Without K_I and K_II the angle is 0.
  pure real(dp) function growth_angle(K) result(angle)
    real(dp), intent(in) :: K(2)   !! K_I and K_II, force/length^(3/2)
    real(dp) :: opening

    opening = max(K(1), 0.0_dp)
    angle = 0.0_dp
    if (abs(K(2)) > 0) angle = -2*atan2(2*K(2), opening + sqrt(opening**2 + 8*K(2)**2))
  end function growth_angle

  !> Intensity of the circumferential stress at an angle from the direction of the crack, force/length^(3/2).
  pure real(dp) function hoop_intensity(K, angle) result(intensity)
    real(dp), intent(in) :: K(2)   !! K_I and K_II, force/length^(3/2)
    real(dp), intent(in) :: angle  !! rad

    intensity = cos(angle/2)**2*(max(K(1), 0.0_dp)*cos(angle/2) - 3*K(2)*sin(angle/2))
  end function hoop_intensity

end module scree_crack_direction
