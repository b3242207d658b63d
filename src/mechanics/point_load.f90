!> Forces on load points that move with their element (Shi's df15).
module scree_point_load
  use scree_element_term, only: add_force, step_rule_t, term_t
  use scree_interpolation, only: displacement_matrix, kinematics_t
  use scree_kinds, only: dp
  use scree_scene, only: time_table_t
  use scree_system, only: element_unknowns
  use scree_time_table, only: mean_over
  implicit none
  private
  public :: add_point_loads, point_load_t, size_of_point_loads, work_of_point_loads

  !> Called for when a load point has a force.
  type :: point_load_t
    integer, allocatable :: first(:)             !! (n_elements+1) element e carries loads first(e):first(e+1)-1
    integer, allocatable :: point(:)             !! (n_loads) point of the system
    type(time_table_t), allocatable :: table(:)  !! (n_loads) force per unit thickness
  end type point_load_t

contains

  !> Adds T(x)^T f of every load on element `e`, f the mean of its table.
  pure subroutine add_point_loads(self, e, position, rule, element, term)
    type(point_load_t), intent(in) :: self
    integer, intent(in) :: e
    real(dp), intent(in) :: position(:, :) !! (2, n_points) of the system, length
    type(step_rule_t), intent(in) :: rule
    type(kinematics_t), intent(in) :: element
    type(term_t), intent(inout) :: term
    integer :: i

    do i = self%first(e), self%first(e + 1) - 1
      call add_force(term, matmul(mean_over(self%table(i), rule%load_from, rule%load_to), &
                                  displacement_matrix(element, position(:, self%point(i)))))
    end do
  end subroutine add_point_loads

  !> Magnitudes of the loads on element `e`, summed, force per unit thickness.
  pure real(dp) function size_of_point_loads(self, e, rule) result(load)
    type(point_load_t), intent(in) :: self
    integer, intent(in) :: e
    type(step_rule_t), intent(in) :: rule
    integer :: i

    load = 0.0_dp
    do i = self%first(e), self%first(e + 1) - 1
      load = load + norm2(mean_over(self%table(i), rule%load_from, rule%load_to))
    end do
  end function size_of_point_loads

  !> Work of the loads on element `e` in a step, force per unit thickness times length.
  pure real(dp) function work_of_point_loads(self, e, position, rule, element, unknown) result(work)
    type(point_load_t), intent(in) :: self
    integer, intent(in) :: e
    real(dp), intent(in) :: position(:, :) !! (2, n_points) at the beginning of the step, length
    type(step_rule_t), intent(in) :: rule
    type(kinematics_t), intent(in) :: element
    real(dp), intent(in) :: unknown(element_unknowns) !! of the step
    integer :: i

    work = 0.0_dp
    do i = self%first(e), self%first(e + 1) - 1
      work = work + dot_product(mean_over(self%table(i), rule%end_time - rule%dt, rule%end_time), &
                                matmul(displacement_matrix(element, position(:, self%point(i))), unknown))
    end do
  end function work_of_point_loads

end module scree_point_load
