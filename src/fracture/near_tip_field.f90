!> Fields at the tip of a crack: Williams' singular terms in complex form.
!>
!> The crack ends at the origin and its faces are free. With z = x + i y and conj for the conjugate, Muskhelishvili's potentials are
!>
!>     Phi(z) = c/z^(1/2),   Omega(z) = c/z^(1/2),   K_I - i K_II = 2 (2 pi)^(1/2) c,
!>     s_xx + s_yy = 4 Re Phi,   s_yy - i s_xy = Phi + Omega(conj z) + (z - conj z) conj Phi',
!>     2 mu (u + i v)_x = kappa Phi - Omega(conj z) - (z - conj z) conj Phi',
!>     2 mu (u + i v)_y = i [kappa Phi + Omega(conj z) - 2 conj Phi + (z - conj z) conj Phi']
!>
!> (Williams 1957; Muskhelishvili 1953). All of them are functions of w = z^(1/2), which tells the two faces apart.
module scree_near_tip_field
  use scree_kinds, only: dp, pi
  implicit none
  private
  public :: near_tip_field_t, singular_field

  !> One mode with K = 1, in the axes of the tip.
  type :: near_tip_field_t
    real(dp) :: stress(3) = 0.0_dp     !! xx, yy, xy, length^(-1/2)
    real(dp) :: strain(3) = 0.0_dp     !! xx, yy and engineering shear, length^(-1/2)/stiffness
    real(dp) :: slope(2) = 0.0_dp      !! u_x and v_x, length^(-1/2)/stiffness
  end type near_tip_field_t

contains

  !> The singular field of mode I or II.
  pure type(near_tip_field_t) function singular_field(mode, root, shear, kappa) result(field)
    integer, intent(in) :: mode        !! 1 opening, 2 shear
    complex(dp), intent(in) :: root    !! w = r^(1/2) exp(i theta/2), not 0, length^(1/2)
    real(dp), intent(in) :: shear      !! mu, force/length^2
    real(dp), intent(in) :: kappa      !! 3 - 4 nu in plane strain, (3 - nu)/(1 + nu) in plane stress
    complex(dp) :: c, phi, bent, omega, along, across
    complex(dp), parameter :: i = (0.0_dp, 1.0_dp)

    c = 1/(2*sqrt(2*pi))
    if (mode == 2) c = -i*c
    phi = c/root
    omega = c/conjg(root)
    bent = 2*i*aimag(root**2)*conjg(-c/(2*root**3)) ! (z - conj z) conj Phi'
    field%stress(2) = real(phi + omega + bent)
    field%stress(3) = -aimag(phi + omega + bent)
    field%stress(1) = 4*real(phi) - field%stress(2)
    along = (kappa*phi - omega - bent)/(2*shear)
    across = i*(kappa*phi + omega - 2*conjg(phi) + bent)/(2*shear)
    field%slope = [real(along), aimag(along)]
    field%strain = [real(along), aimag(across), aimag(along) + real(across)]
  end function singular_field

end module scree_near_tip_field
