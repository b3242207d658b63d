!> Strain by the decomposition into strain and rotation, to compare with Green strain: Chen's theorem, as Fan, Zheng and others take
!> it into the DDA and the NMM (Fan, Zheng & Zhao 2017; Fan, Zheng & He 2016).
!>
!> I + theta is the sum of a symmetric strain e and a rotation by phi, whose skew part is all there is, r = (v_X - u_Y)/2 = sin phi:
!>
!>     e = B0 theta + (1 - cos phi) m,   m = (1, 1, 0),   de = (B0 + tan phi m w^T) dtheta,   w = (0, 1/2, -1/2, 0):
!>
!> what a rotation lets small strain grow by is taken off, and so is the work of that in the forces. A rotation alone has no strain,
!> a stretch 1 + a of a body that turns a/cos phi in place of a. Stress is that of e, turned by phi; stiffness does not change.
!> There is none where |r| > 1: no element turns by a right angle in a step.
module scree_strain_rotation
  use scree_element_term, only: add_force, step_rule_t, term_t
  use scree_green_strain, only: strain_operator
  use scree_interpolation, only: kinematics_t
  use scree_kinds, only: dp
  use scree_material, only: push_stress_forward
  use scree_stiffness, only: small_strain
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: add_strain_rotation, is_decomposed, strain_beside_rotation, turned_stress

  real(dp), parameter :: sine_of(4) = [0.0_dp, 0.5_dp, -0.5_dp, 0.0_dp] !! w
  !> Sine of the largest rotation of a step, 84 degrees; of an iterate that turns farther the strain is taken as at it.
  real(dp), parameter :: most = 0.995_dp

contains

  !> Whether a displacement gradient is strain and rotation.
  pure logical function is_decomposed(theta)
    real(dp), intent(in) :: theta(4) !! u_X, v_X, u_Y, v_Y

    is_decomposed = abs(dot_product(sine_of, theta)) < most
  end function is_decomposed

  !> Strain of a displacement gradient beside its rotation: xx, yy and engineering shear.
  pure function strain_beside_rotation(theta) result(strain)
    real(dp), intent(in) :: theta(4) !! u_X, v_X, u_Y, v_Y
    real(dp) :: strain(3), r

    r = sine_within(theta)
    strain = small_strain(theta) + r**2/(1 + sqrt(1 - r**2))*[1.0_dp, 1.0_dp, 0.0_dp]
  end function strain_beside_rotation

  !> Stress at the end of a step, force/length^2.
  pure function turned_stress(elasticity, theta, stress) result(turned)
    real(dp), intent(in) :: elasticity(3, 3) !! isotropic, force/length^2
    real(dp), intent(in) :: theta(4)         !! u_X, v_X, u_Y, v_Y
    real(dp), intent(in) :: stress(3)        !! at the beginning of the step, force/length^2
    real(dp) :: turned(3), c, r

    r = sine_within(theta)
    c = sqrt(1 - r**2)
    turned = push_stress_forward([c, r, -r, c], stress + matmul(elasticity, strain_beside_rotation(theta)))
  end function turned_stress

  !> Adds the secant or tangent matrix and the forces of the current iterate, area G^T (B0 + tan phi m w^T)^T S where the step ends.
  pure subroutine add_strain_rotation(element, D, stress, unknown, rule, term)
    type(kinematics_t), intent(in) :: element
    real(dp), intent(in) :: D(3, 3)     !! elasticity, force/length^2
    real(dp), intent(in) :: stress(3)   !! at the beginning of the step, force/length^2
    real(dp), intent(in) :: unknown(element_unknowns) !! of the step so far
    type(step_rule_t), intent(in) :: rule
    type(term_t), intent(inout) :: term
    real(dp) :: theta(4), B0(3, 4), B(3, 4), S(3), M(4, 4), c, r, force(4), wD(3, 3)
    integer :: k

    theta = matmul(element%gradient, unknown)
    r = sine_within(theta)
    c = sqrt(1 - r**2)
    B0 = strain_operator(theta, 0.0_dp)
    B = turning_operator(r/c)
    wD = rule%stress_weight*D
    S = stress + matmul(wD, strain_beside_rotation(theta))
    if (rule%tangent) then
      M = matmul(transpose(B), matmul(wD, B))
      do k = 1, 4
        M(:, k) = M(:, k) + (S(1) + S(2))/c**3*sine_of(k)*sine_of
      end do
    else
      M = matmul(transpose(B), matmul(wD, turning_operator(r/(1 + c))))
      term%symmetric = .false.
    end if
    force = matmul(S, B)
    if (rule%end_weight < 1) then
      M = rule%end_weight*M
      force = rule%end_weight*force + (1 - rule%end_weight)*matmul(stress, B0)
    end if
    associate (G => element%gradient)
      term%matrix = term%matrix + element%area*matmul(transpose(G), matmul(M, G))
      call add_force(term, -element%area*matmul(force, G), &
                     element%area*matmul(matmul(abs(stress) + matmul(abs(wD), matmul(abs(B), abs(theta))), abs(B)), abs(G)))
    end associate

  contains

    !> B0 + factor m w^T.
    pure function turning_operator(factor) result(operator)
      real(dp), intent(in) :: factor
      real(dp) :: operator(3, 4)

      operator = B0
      operator(1, :) = operator(1, :) + factor*sine_of
      operator(2, :) = operator(2, :) + factor*sine_of
    end function turning_operator

  end subroutine add_strain_rotation

  !> sin phi of a displacement gradient, at most that of the largest rotation.
  pure real(dp) function sine_within(theta)
    real(dp), intent(in) :: theta(4)

    sine_within = max(-most, min(most, dot_product(sine_of, theta)))
  end function sine_within

end module scree_strain_rotation
