!> Inertia force of the elements in the frame of a ground that accelerates.
module scree_base_acceleration
  use scree_element_term, only: add_force, step_rule_t, term_t
  use scree_interpolation, only: kinematics_t
  use scree_kinds, only: dp
  use scree_scene, only: time_table_t
  use scree_system, only: element_unknowns
  use scree_time_table, only: mean_over
  implicit none
  private
  public :: add_base_acceleration, base_acceleration_t, force_of_base, work_of_base

  !> Called for when the ground accelerates at some time.
  type :: base_acceleration_t
    type(time_table_t) :: record !! acceleration of the ground, length/time^2
  end type base_acceleration_t

contains

  !> Adds -m T(c)^T a: the integral of rho T^T over a linear field is m T(c)^T, as that of X about the centroid is 0.
  pure subroutine add_base_acceleration(self, mass, rule, element, term)
    type(base_acceleration_t), intent(in) :: self
    real(dp), intent(in) :: mass !! mass/length
    type(step_rule_t), intent(in) :: rule
    type(kinematics_t), intent(in) :: element
    type(term_t), intent(inout) :: term

    call add_force(term, matmul(force_of_base(self, mass, rule), element%at_centroid))
  end subroutine add_base_acceleration

  !> Inertia force -m a of one element in a step, per unit thickness.
  pure function force_of_base(self, mass, rule) result(force)
    type(base_acceleration_t), intent(in) :: self
    real(dp), intent(in) :: mass !! mass/length
    type(step_rule_t), intent(in) :: rule
    real(dp) :: force(2)

    force = -mass*mean_over(self%record, rule%load_from, rule%load_to)
  end function force_of_base

  !> Work of the inertia force of one element in a step, force per unit thickness times length.
  pure real(dp) function work_of_base(self, mass, rule, element, unknown)
    type(base_acceleration_t), intent(in) :: self
    real(dp), intent(in) :: mass                      !! mass/length
    type(step_rule_t), intent(in) :: rule
    type(kinematics_t), intent(in) :: element
    real(dp), intent(in) :: unknown(element_unknowns) !! of the step

    work_of_base = -mass*dot_product(mean_over(self%record, rule%end_time - rule%dt, rule%end_time), &
                                     matmul(element%at_centroid, unknown))
  end function work_of_base

end module scree_base_acceleration
