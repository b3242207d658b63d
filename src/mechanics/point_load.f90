!> Forces on load points that move with their element (Shi's df15).
module scree_point_load
  use scree_element_term, only: add_force, term_t
  use scree_interpolation, only: displacement_matrix, kinematics_t
  use scree_kinds, only: dp
  use scree_scene, only: time_table_t
  implicit none
  private
  public :: add_point_loads, point_load_t, value_at

  !> Called for when a load point has a force.
  type :: point_load_t
    integer, allocatable :: first(:)             !! (n_elements+1) element e carries loads first(e):first(e+1)-1
    integer, allocatable :: point(:)             !! (n_loads) point of the system
    type(time_table_t), allocatable :: table(:)  !! (n_loads) force per unit thickness
  end type point_load_t

contains

  !> Adds T(x)^T f(t) of every load on element `e`.
  pure subroutine add_point_loads(self, e, place, time, element, term)
    type(point_load_t), intent(in) :: self
    integer, intent(in) :: e
    real(dp), intent(in) :: place(:, :) !! (2, n_points) of the system, length
    real(dp), intent(in) :: time        !! at which the balance takes the loads
    type(kinematics_t), intent(in) :: element
    type(term_t), intent(inout) :: term
    integer :: i

    do i = self%first(e), self%first(e + 1) - 1
      call add_force(term, matmul(value_at(self%table(i), time), displacement_matrix(element, place(:, self%point(i)))))
    end do
  end subroutine add_point_loads

  !> Value of a table: linear between its times, constant before the first and after the last (Shi's df09).
  pure function value_at(table, time) result(value)
    type(time_table_t), intent(in) :: table
    real(dp), intent(in) :: time
    real(dp) :: value(2)
    integer :: i, n

    n = size(table%time)
    if (time <= table%time(1)) then
      value = table%value(:, 1)
    else if (time >= table%time(n)) then
      value = table%value(:, n)
    else
      i = count(table%time <= time)
      value = table%value(:, i) + (time - table%time(i))/(table%time(i + 1) - table%time(i)) &
              *(table%value(:, i + 1) - table%value(:, i))
    end if
  end function value_at

end module scree_point_load
