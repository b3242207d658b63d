!> Linear isotropic elasticity in the plane.
module scree_material
  use scree_kinds, only: dp
  use scree_scene, only: block_material_t, plane_strain
  implicit none
  private
  public :: elasticity, push_elasticity_forward, push_stress_forward

contains

  !> Elasticity matrix for (xx, yy, xy) and engineering shear, force/length^2.
  pure function elasticity(material, plane) result(D)
    type(block_material_t), intent(in) :: material
    integer, intent(in) :: plane !! `plane_stress` or `plane_strain`
    real(dp) :: D(3, 3), E, nu

    E = material%young
    nu = material%poisson
    if (plane == plane_strain) then ! the plane stress law with these two constants
      E = E/(1 - nu**2)
      nu = nu/(1 - nu)
    end if
    D = 0.0_dp
    D(1, 1:2) = [1.0_dp, nu]
    D(2, 1:2) = [nu, 1.0_dp]
    D(3, 3) = (1 - nu)/2
    D = E/(1 - nu**2)*D
  end function elasticity

  !> Matrix that takes (xx, yy, xy) of S to that of F S F^T.
  pure function stress_transform(F) result(P)
    real(dp), intent(in) :: F(4) !! xx, yx, xy, yy
    real(dp) :: P(3, 3)

    P(1, :) = [F(1)**2, F(3)**2, 2*F(1)*F(3)]
    P(2, :) = [F(2)**2, F(4)**2, 2*F(2)*F(4)]
    P(3, :) = [F(1)*F(2), F(3)*F(4), F(1)*F(4) + F(2)*F(3)]
  end function stress_transform

  !> Cauchy stress F S F^T / det F (Zhang et al. 2019, Eq. 46).
  pure function push_stress_forward(F, S) result(sigma)
    real(dp), intent(in) :: F(4) !! xx, yx, xy, yy
    real(dp), intent(in) :: S(3) !! second Piola-Kirchhoff stress, force/length^2
    real(dp) :: sigma(3)

    sigma = matmul(stress_transform(F), S)/(F(1)*F(4) - F(2)*F(3))
  end function push_stress_forward

  !> Elasticity of the deformed configuration: P D P^T / det F with P the transform of stress.
  !>
  !> With it the updated Lagrangian steps are the total Lagrangian solution, whatever their number.
  !> An isotropic D is not changed by a rotation.
  pure function push_elasticity_forward(F, D0) result(D)
    real(dp), intent(in) :: F(4)     !! since the start: xx, yx, xy, yy
    real(dp), intent(in) :: D0(3, 3) !! force/length^2
    real(dp) :: D(3, 3), P(3, 3)

    P = stress_transform(F)
    D = matmul(P, matmul(D0, transpose(P)))/(F(1)*F(4) - F(2)*F(3))
  end function push_elasticity_forward

end module scree_material
