!> Elastic forces of an element with Green strain in an updated Lagrangian step (Zhang et al. 2019, section 3).
!>
!> Everything follows from the displacement gradient theta = G d of the step:
!>
!>     strain          E    = (B0 + A(theta)/2) theta
!>     operator        B    = B0 + omega A(theta)          omega 1: variation of E; 1/2: energy-momentum form
!>     stress          S    = sigma0 + w D E               w: fraction of the increment in the balance
!>     forces          area G^T B^T S
!>     secant          area G^T B^T w D (B0 + A/2) G       symmetric for omega 1/2
!>     tangent         area G^T [B^T w D (B0 + A) + omega S2] G    symmetric for omega 1 and w 1
!>
!> Where the balance takes a fraction of the forces at the end alone, the rest are those of the beginning, area G^T B0^T sigma0.
!>
!> with A(theta) = [u_X v_X 0 0; 0 0 u_Y v_Y; u_Y v_Y u_X v_X] (the paper prints its third row wrongly)
!> and S2 = [Sxx I, Sxy I; Sxy I, Syy I].
!>
!> The derivation is in doc/theory/kinematics.md, eq-green-strain and eq-operators.
module scree_green_strain
  use scree_element_term, only: add_force, step_rule_t, term_t
  use scree_interpolation, only: kinematics_t
  use scree_kinds, only: dp
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: add_green_strain, error_of_small_strain, green_strain, largest_stretch, least_stretch, least_stable_stretch, &
            strain_operator

  integer, parameter :: n = element_unknowns

  !> Stretch at which the linear law in Green strain loses its stiffness in compression: d(lambda (lambda^2 - 1))/d lambda = 0.
  real(dp), parameter :: least_stable_stretch = 1/sqrt(3.0_dp)
  !> Weights that differ by less are the same.
  real(dp), parameter :: same = 1e-12_dp

contains

  !> Green strain of a displacement gradient: xx, yy and engineering shear.
  pure function green_strain(theta) result(strain)
    real(dp), intent(in) :: theta(4) !! u_X, v_X, u_Y, v_Y
    real(dp) :: strain(3)

    strain = [theta(1) + 0.5_dp*(theta(1)**2 + theta(2)**2), &
              theta(4) + 0.5_dp*(theta(3)**2 + theta(4)**2), &
              theta(2) + theta(3) + theta(1)*theta(3) + theta(2)*theta(4)]
  end function green_strain

  !> Strain that small strain neglects in a step: the larger of two numbers.
  !>
  !> The first is the largest of A(theta) theta / 2 in any direction, which is alpha^2/2 for a rotation by alpha (Zhang et al. 2019,
  !> Eq. 14). The second is the change of the present stress, as a strain, as it turns and stretches.
  pure real(dp) function error_of_small_strain(theta, strained) result(error)
    real(dp), intent(in) :: theta(4)    !! u_X, v_X, u_Y, v_Y
    real(dp), intent(in) :: strained(3) !! stress over stiffness

    error = largest_stretch(theta)*(0.5_dp*largest_stretch(theta) + abs(0.5_dp*(strained(1) + strained(2))) &
                                    + hypot(0.5_dp*(strained(1) - strained(2)), strained(3)))
  end function error_of_small_strain

  !> B0 + omega A(theta), 3 x 4.
  pure function strain_operator(theta, omega) result(B)
    real(dp), intent(in) :: theta(4), omega
    real(dp) :: B(3, 4), a(4)

    a = omega*theta
    B(1, :) = [1 + a(1), a(2), 0.0_dp, 0.0_dp]
    B(2, :) = [0.0_dp, 0.0_dp, a(3), 1 + a(4)]
    B(3, :) = [a(3), 1 + a(4), 1 + a(1), a(2)]
  end function strain_operator

  !> Adds the secant or tangent matrix and the forces of the current iterate.
  pure subroutine add_green_strain(element, D, stress, unknown, rule, term)
    type(kinematics_t), intent(in) :: element
    real(dp), intent(in) :: D(3, 3)     !! elasticity of the configuration at the beginning of the step, force/length^2
    real(dp), intent(in) :: stress(3)   !! Cauchy stress at the beginning of the step, force/length^2
    real(dp), intent(in) :: unknown(n) !! of the step so far
    type(step_rule_t), intent(in) :: rule
    type(term_t), intent(inout) :: term
    real(dp) :: theta(4), B(3, 4), S(3), strain(3), M(4, 4), omega, wD(3, 3), share, force(4)
    real(dp) :: changes(3, 4), Dchanges(3, 4), MG(4, n), GMG(n, n), own(n), magnitude(3), noise(4), cancelled(n)
    integer :: k

    if (.not. rule%end_weight > 0) then
      B = strain_operator([0.0_dp, 0.0_dp, 0.0_dp, 0.0_dp], 0.0_dp)
      call add_force(term, -element%area*matmul(matmul(stress, B), element%gradient), &
                     element%area*matmul(matmul(abs(stress), abs(B)), abs(element%gradient)))
      return
    end if
    omega = rule%operator_weight
    theta = matmul(element%gradient, unknown)
    B = strain_operator(theta, omega)
    wD = rule%stress_weight*D
    strain = green_strain(theta)
    S = matmul(wD, strain)
    S = stress + S
    share = merge(1.0_dp, 0.5_dp, rule%tangent)
    changes = strain_operator(theta, share)
    Dchanges = matmul(wD, changes)
    M = matmul(transpose(B), Dchanges)
    if (rule%tangent) then
      do k = 1, 2
        M(k, k) = M(k, k) + omega*S(1)
        M(k + 2, k + 2) = M(k + 2, k + 2) + omega*S(2)
        M(k, k + 2) = M(k, k + 2) + omega*S(3)
        M(k + 2, k) = M(k + 2, k) + omega*S(3)
      end do
    end if
    term%symmetric = term%symmetric .and. has_symmetric_operator(rule)
    force = matmul(S, B)
    if (rule%end_weight < 1) then
      M = rule%end_weight*M
      force = rule%end_weight*force + (1 - rule%end_weight)*matmul(stress, strain_operator(theta, 0.0_dp))
    end if
    strain = green_strain(abs(theta))
    wD = abs(wD)
    magnitude = matmul(wD, strain)
    magnitude = abs(stress) + magnitude
    B = abs(B)
    noise = matmul(magnitude, B)
    associate (G => element%gradient)
      MG = matmul(M, G)
      GMG = matmul(transpose(G), MG)
      term%matrix = term%matrix + element%area*GMG
      own = matmul(force, G)
      cancelled = matmul(noise, abs(G))
    end associate
    call add_force(term, -element%area*own, element%area*cancelled)
  end subroutine add_green_strain

  !> Whether secant or tangent are symmetric with the weights of a step.
  pure logical function has_symmetric_operator(rule)
    type(step_rule_t), intent(in) :: rule

    if (rule%tangent) then
      has_symmetric_operator = abs(rule%operator_weight - 1) < same .and. abs(rule%stress_weight - 1) < same
    else
      has_symmetric_operator = abs(rule%operator_weight - 0.5_dp) < same
    end if
  end function has_symmetric_operator

  !> Largest singular value of a gradient, as of a displacement: of whatever direction, and the same whichever way the axes lie.
  pure real(dp) function largest_stretch(theta)
    real(dp), intent(in) :: theta(4)    !! u_X, v_X, u_Y, v_Y

    largest_stretch = 0.5_dp*(hypot(theta(1) + theta(4), theta(2) - theta(3)) + hypot(theta(1) - theta(4), theta(2) + theta(3)))
  end function largest_stretch

  !> Smallest principal stretch of a deformation gradient.
  pure real(dp) function least_stretch(F)
    real(dp), intent(in) :: F(4) !! xx, yx, xy, yy
    real(dp) :: sum, difference

    ! singular values of a 2 x 2 matrix: half sum and half difference of two lengths
    sum = hypot(F(1) + F(4), F(2) - F(3))
    difference = hypot(F(1) - F(4), F(2) + F(3))
    least_stretch = 0.5_dp*(sum - difference)
  end function least_stretch

end module scree_green_strain
