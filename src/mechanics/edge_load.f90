!> Pressure and traction on pieces of edges, linear along them.
!>
!> A piece from A to B belongs to one element, whose displacement is linear along it. A load q on it does the work of the forces
!>
!>     f_A = (2 q_A + q_B)/6,   f_B = (q_A + 2 q_B)/6
!>
!> at its ends. A traction t keeps its direction: q = l t with the length l at the start. A pressure p follows the edge:
!> q = -p (y_B - y_A, x_A - x_B), against the outer normal times the present length. The edge is taken where the velocities bring it
!> in half a step. This is of second order and keeps the equations symmetric and linear.
module scree_edge_load
  use scree_element_term, only: add_force, step_rule_t, term_t
  use scree_interpolation, only: displacement_matrix, kinematics_t
  use scree_kinds, only: dp
  use scree_system, only: element_unknowns
  use scree_time_table, only: mean_of_ramp
  implicit none
  private
  public :: add_edge_loads, edge_load_t, load_at_ends, load_on_piece, size_of_edge_loads, work_of_edge_loads

  integer, parameter :: n = element_unknowns

  !> Called for when lines of the deck load edges.
  type :: edge_load_t
    integer, allocatable :: first(:)          !! (n_elements+1) element e has the pieces first(e):first(e+1)-1
    integer, allocatable :: point(:, :)       !! (2, n) points of the system at the ends, counter-clockwise around the element
    real(dp), allocatable :: pressure(:, :)   !! (2, n) at the ends, force/length^2
    real(dp), allocatable :: traction(:, :, :) !! (xy, 2, n) at the ends times the length at the start, force/length
    real(dp) :: ramp = 0.0_dp                 !! in which they grow from 0 as the run begins, time
  end type edge_load_t

contains

  !> Adds the loads on the edges of element `e`, with the mean of their ramp.
  pure subroutine add_edge_loads(self, e, position, velocity, rule, element, term)
    type(edge_load_t), intent(in) :: self
    integer, intent(in) :: e
    real(dp), intent(in) :: position(:, :)    !! (2, n_points) at the beginning of the step, length
    real(dp), intent(in) :: velocity(n)       !! rates of the unknowns of the element then
    type(step_rule_t), intent(in) :: rule
    type(kinematics_t), intent(in) :: element
    type(term_t), intent(inout) :: term

    if (self%first(e + 1) == self%first(e)) return
    call add_force(term, mean_of_ramp(self%ramp, rule%load_from, rule%load_to) &
                   *full_load(self, e, position, velocity, rule, element))
  end subroutine add_edge_loads

  !> Magnitudes of the loads on the edges of element `e`, when their ramp is over, summed; force per unit thickness.
  pure real(dp) function size_of_edge_loads(self, e, position) result(load)
    type(edge_load_t), intent(in) :: self
    integer, intent(in) :: e
    real(dp), intent(in) :: position(:, :)    !! (2, n_points) at the beginning of the step, length
    real(dp) :: along(2), q(2, 2)
    integer :: i

    load = 0.0_dp
    do i = self%first(e), self%first(e + 1) - 1
      along = position(:, self%point(2, i)) - position(:, self%point(1, i))
      q = load_at_ends(self, i, along)
      load = load + 0.5_dp*(norm2(q(:, 1)) + norm2(q(:, 2)))
    end do
  end function size_of_edge_loads

  !> Work of the loads on the edges of element `e` in a step, force per unit thickness times length.
  pure real(dp) function work_of_edge_loads(self, e, position, velocity, rule, element, unknown) result(work)
    type(edge_load_t), intent(in) :: self
    integer, intent(in) :: e
    real(dp), intent(in) :: position(:, :)    !! (2, n_points) at the beginning of the step, length
    real(dp), intent(in) :: velocity(n)       !! rates of the unknowns of the element then
    type(step_rule_t), intent(in) :: rule
    type(kinematics_t), intent(in) :: element
    real(dp), intent(in) :: unknown(n)        !! of the step

    work = 0.0_dp
    if (self%first(e + 1) == self%first(e)) return
    work = mean_of_ramp(self%ramp, rule%end_time - rule%dt, rule%end_time) &
           *dot_product(full_load(self, e, position, velocity, rule, element), unknown)
  end function work_of_edge_loads

  !> Force on the unknowns of element `e` when the ramp is over.
  pure function full_load(self, e, position, velocity, rule, element) result(force)
    type(edge_load_t), intent(in) :: self
    integer, intent(in) :: e
    real(dp), intent(in) :: position(:, :), velocity(n)
    type(step_rule_t), intent(in) :: rule
    type(kinematics_t), intent(in) :: element
    real(dp) :: force(n), along(2), T(2, n, 2), q(2, 2)
    integer :: i, k

    force = 0.0_dp
    do i = self%first(e), self%first(e + 1) - 1
      do k = 1, 2
        T(:, :, k) = displacement_matrix(element, position(:, self%point(k, i)))
      end do
      along = position(:, self%point(2, i)) - position(:, self%point(1, i)) &
              + 0.5_dp*rule%dt*matmul(T(:, :, 2) - T(:, :, 1), velocity)
      q = load_at_ends(self, i, along)
      force = force + matmul((2*q(:, 1) + q(:, 2))/6, T(:, :, 1)) + matmul((q(:, 1) + 2*q(:, 2))/6, T(:, :, 2))
    end do
  end function full_load

  !> Force on a piece when the ramp is over, per unit thickness.
  pure function load_on_piece(self, i, position) result(force)
    type(edge_load_t), intent(in) :: self
    integer, intent(in) :: i                  !! piece
    real(dp), intent(in) :: position(:, :)    !! (2, n_points) length
    real(dp) :: force(2)

    force = 0.5_dp*sum(load_at_ends(self, i, position(:, self%point(2, i)) - position(:, self%point(1, i))), 2)
  end function load_on_piece

  !> Load at both ends of a piece, times its length.
  pure function load_at_ends(self, i, along) result(q)
    type(edge_load_t), intent(in) :: self
    integer, intent(in) :: i                  !! piece
    real(dp), intent(in) :: along(2)          !! from its first end to its second, length
    real(dp) :: q(2, 2)                       !! (xy, 2) force per unit thickness
    integer :: k

    do k = 1, 2
      q(:, k) = self%traction(:, k, i) - self%pressure(k, i)*[along(2), -along(1)]
    end do
  end function load_at_ends

end module scree_edge_load
