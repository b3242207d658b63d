!> Elastic forces of an element with small strain in the step (Shi's df13 and df14).
module scree_stiffness
  use scree_element_term, only: add_force, step_rule_t, term_t
  use scree_interpolation, only: kinematics_t
  use scree_kinds, only: dp
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: add_small_strain, small_strain, small_strain_operator

contains

  !> Strain B0 theta: xx, yy and engineering shear.
  pure function small_strain(theta) result(strain)
    real(dp), intent(in) :: theta(4) !! u_X, v_X, u_Y, v_Y
    real(dp) :: strain(3)

    strain = [theta(1), theta(4), theta(2) + theta(3)]
  end function small_strain

  !> B0 G of an element: strain per unknown.
  pure function small_strain_operator(element) result(B)
    type(kinematics_t), intent(in) :: element
    real(dp) :: B(3, element_unknowns)

    B(1, :) = element%gradient(1, :)
    B(2, :) = element%gradient(4, :)
    B(3, :) = element%gradient(2, :) + element%gradient(3, :)
  end function small_strain_operator

  !> Adds A G^T B0^T D B0 G to the matrix and the forces of the stress sigma0 + D B0 G d.
  pure subroutine add_small_strain(element, D, stress, unknown, rule, term)
    type(kinematics_t), intent(in) :: element
    real(dp), intent(in) :: D(3, 3)     !! elasticity, force/length^2
    real(dp), intent(in) :: stress(3)   !! at the beginning of the step, force/length^2
    real(dp), intent(in) :: unknown(element_unknowns) !! of the step so far
    type(step_rule_t), intent(in) :: rule
    type(term_t), intent(inout) :: term
    real(dp) :: B(3, element_unknowns), DB(3, element_unknowns), theta(4)

    B = small_strain_operator(element)
    DB = element%area*rule%stress_weight*rule%end_weight*matmul(D, B)
    theta = matmul(element%gradient, unknown)
    term%matrix = term%matrix + matmul(transpose(B), DB)
    call add_force(term, -element%area*matmul(stress, B) - matmul(small_strain(theta), DB), &
                   element%area*matmul(abs(stress), abs(B)) + matmul(small_strain(abs(theta)), abs(DB)))
  end subroutine add_small_strain

end module scree_stiffness
