!> The displacement of a block of small strain that turns: published cures of its false growth.
!>
!> A step of Shi's DDA finds the rotation r and the strains ex, ey, g of a block, and moves it by its linear field. Positions about
!> its centroid move by F = I + r J + e, with J = [0 -1; 1 0] and e = [ex g/2; g/2 ey]. An area then grows by the factor 1 + r^2.
!> The cures solve the same equations and move the block by another F:
!>
!>     exact           R(r) + e                   Shi's programs can (df25); R(r) = cos r I + sin r J
!>     adjusted        R(r) (I + e)               post-adjustment, Koo & Chern 1998: the rotation comes after the strain, and turns
!>                                                the stress as well
!>     second_order    (1 - r^2/2) I + r J + e    MacLaughlin & Sitar 1996: the next term of cos r; an area grows by 1 + r^4/4
!>     trigonometric   sqrt(1 - r^2) I + r J + e  Cheng & Zhang 2000: the unknown is sin r, and a block turns by asin r. So it does
!>                                                with the decomposition into strain and rotation (Fan, Zheng & Zhao 2017)
!>     exponential     exp(r J + e)               what a gradient of the velocity that stays makes of a block
!>
!> None of them changes the forces of a step, which are those of small strain at its beginning; Green strain does. The
!> titles are in doc/theory/references.md, the areas and angles in doc/theory/kinematics.md.
module scree_finite_rotation
  use scree_kinds, only: dp
  use scree_material, only: push_stress_forward
  use scree_scene, only: rotation_adjusted, rotation_exact, rotation_exponential, rotation_second_order, rotation_trigonometric
  use scree_stiffness, only: small_strain
  implicit none
  private
  public :: turn_finitely

  real(dp), parameter :: identity(4) = [1.0_dp, 0.0_dp, 0.0_dp, 1.0_dp] !! in columns, as all here

contains

  !> Term to add to the displacement gradient of a step, so that it becomes F - I, and the turned stress.
  pure subroutine turn_finitely(rotation, theta, more, stress)
    integer, intent(in) :: rotation          !! `rotation_exact` or another of the scene but the linear one
    real(dp), intent(in) :: theta(4)         !! u_X, v_X, u_Y, v_Y: r J + e
    real(dp), intent(out) :: more(4)         !! xx, yx, xy, yy
    real(dp), intent(inout) :: stress(3)     !! at the end of the step, force/length^2
    real(dp) :: e(3), r, R_of(4)

    r = 0.5_dp*(theta(2) - theta(3))
    more = 0.0_dp
    select case (rotation)
    case (rotation_exact)
      more = [cos(r) - 1, sin(r) - r, r - sin(r), cos(r) - 1]
    case (rotation_adjusted)
      R_of = [cos(r), sin(r), -sin(r), cos(r)]
      e = small_strain(theta)
      more = [R_of(1)*(1 + e(1)) + R_of(3)*0.5_dp*e(3), R_of(2)*(1 + e(1)) + R_of(4)*0.5_dp*e(3), &
              R_of(1)*0.5_dp*e(3) + R_of(3)*(1 + e(2)), R_of(2)*0.5_dp*e(3) + R_of(4)*(1 + e(2))] - identity - theta
      stress = push_stress_forward(R_of, stress)
    case (rotation_second_order)
      more = -0.5_dp*r**2*identity
    case (rotation_trigonometric) ! no block turns by more than a right angle in a step
      more = (sqrt(max(0.0_dp, 1 - r**2)) - 1)*identity
    case (rotation_exponential)
      more = exponential_of(theta) - identity - theta
    end select
  end subroutine turn_finitely

  !> exp A of a 2 x 2 matrix with the trace 2 m: e^m (c I + s (A - m I)), c and s of the root of -det(A - m I).
  pure function exponential_of(A) result(F)
    real(dp), intent(in) :: A(4) !! in columns
    real(dp) :: F(4), mean, N(4), square, root

    mean = 0.5_dp*(A(1) + A(4))
    N = A - mean*identity
    square = N(2)*N(3) - N(1)*N(4)
    root = sqrt(abs(square))
    if (root < sqrt(epsilon(root))) then
      F = exp(mean)*((1 + square/2)*identity + N)
    else if (square > 0) then
      F = exp(mean)*(cosh(root)*identity + sinh(root)/root*N)
    else
      F = exp(mean)*(cos(root)*identity + sin(root)/root*N)
    end if
  end function exponential_of

end module scree_finite_rotation
