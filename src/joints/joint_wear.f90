!> Joints that wear: their friction falls in a line with the way that their faces have slid on each other, from the peak to the
!> residual one (slip weakening: Palmer & Rice, Proc. R. Soc. A 332, 1973).
!> It is in doc/theory/contact-laws.md, eq-wear.
module scree_joint_wear
  use scree_joint_law, only: wear_t
  use scree_kinds, only: dp
  implicit none
  private
  public :: unworn, worn_friction

contains

  !> Tangent of the friction angle after a way.
  pure real(dp) function worn_friction(wear, peak, way) result(friction)
    type(wear_t), intent(in) :: wear
    real(dp), intent(in) :: peak !! tangent of the friction angle before any wear
    real(dp), intent(in) :: way  !! that the faces have slid on each other, length

    friction = peak
    if (wear%slip > 0) friction = friction + (wear%friction - friction)*min(1.0_dp, way/wear%slip)
  end function worn_friction

  !> Fraction of its roughness that the joint still has after a sliding distance.
  pure real(dp) function unworn(wear, way)
    type(wear_t), intent(in) :: wear
    real(dp), intent(in) :: way  !! length

    unworn = 1.0_dp
    if (wear%slip > 0) unworn = 1 - min(1.0_dp, way/wear%slip)
  end function unworn

end module scree_joint_wear
