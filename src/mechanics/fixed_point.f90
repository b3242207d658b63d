!> Fixed points, held in both directions or, as rollers, in one: eliminated exactly, or held by springs (Shi's df12).
module scree_fixed_point
  use scree_constraints, only: add_constraint, constraints_t
  use scree_element_term, only: add_force, term_t
  use scree_errors, only: error_t
  use scree_interpolation, only: displacement_matrix, kinematics_t
  use scree_kinds, only: dp
  use scree_scene, only: time_table_t
  use scree_system, only: element_unknowns
  use scree_time_table, only: value_at
  implicit none
  private
  public :: add_fixed_springs, constrain_fixed_points, fixed_point_t, is_roller, spring_energy, spring_force, way_of_fastest, &
            work_of_springs

  !> Called for when the scene has fixed points.
  type :: fixed_point_t
    logical :: by_springs = .false.     !! else the equations lose the unknowns
    logical :: moves = .false.          !! a table moves one of them
    real(dp) :: stiffness = 0.0_dp      !! of a spring, force/length per unit thickness
    integer, allocatable :: first(:)    !! (n_elements+1) element e carries first(e):first(e+1)-1
    integer, allocatable :: point(:)    !! (n) point of the system
    real(dp), allocatable :: direction(:, :) !! (2, n) in which alone it is held, a roller's; 0: in both.
                                             !! Not allocated: there are no rollers
    real(dp), allocatable :: home(:, :) !! (2, n) where it is held at the start, length
    type(time_table_t), allocatable :: table(:) !! (n) displacement of the home; without times: none
  end type fixed_point_t

contains

  !> Adds p T^T T and the forces p T^T (home - x - T d) of every spring on element `e`.
  pure subroutine add_fixed_springs(self, e, position, time, element, unknown, term)
    type(fixed_point_t), intent(in) :: self
    integer, intent(in) :: e
    real(dp), intent(in) :: position(:, :) !! (2, n_points) at the beginning of the step, length
    real(dp), intent(in) :: time        !! at the end of the step
    type(kinematics_t), intent(in) :: element
    real(dp), intent(in) :: unknown(element_unknowns) !! of the step so far
    type(term_t), intent(inout) :: term
    real(dp) :: T(2, element_unknowns), pull(2)
    integer :: i

    do i = self%first(e), self%first(e + 1) - 1
      T = displacement_matrix(element, position(:, self%point(i)))
      if (is_roller(self, i)) T = along(self%direction(:, i), T)
      pull = way_home(self, i, position, time) - matmul(T, unknown)
      term%matrix = term%matrix + self%stiffness*matmul(transpose(T), T)
      call add_force(term, self%stiffness*matmul(pull, T), self%stiffness*matmul(matmul(abs(T), abs(unknown)), abs(T)))
    end do
  end subroutine add_fixed_springs

  !> Adds T(x) d = home - x of every fixed point on element `e`, so that it never drifts.
  !>
  !> Errors: points that prescribe what the block cannot do.
  pure subroutine constrain_fixed_points(self, e, position, time, extent, element, unknown_number, constraints, error)
    type(fixed_point_t), intent(in) :: self
    integer, intent(in) :: e
    real(dp), intent(in) :: position(:, :) !! (2, n_points) at the beginning of the step, length
    real(dp), intent(in) :: time        !! at the end of the step
    real(dp), intent(in) :: extent      !! of the model, length
    type(kinematics_t), intent(in) :: element
    integer, intent(in) :: unknown_number(element_unknowns)
    type(constraints_t), intent(inout) :: constraints
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: T(2, element_unknowns), way(2)
    integer :: axis, i

    do i = self%first(e), self%first(e + 1) - 1
      T = displacement_matrix(element, position(:, self%point(i)))
      way = way_home(self, i, position, time)
      if (is_roller(self, i)) then
        call add_constraint(constraints, unknown_number, matmul(self%direction(:, i), T), element%span, element%size, extent, &
                            dot_product(self%direction(:, i), way), error)
        if (allocated(error)) return
        cycle
      end if
      do axis = 1, 2
        call add_constraint(constraints, unknown_number, T(axis, :), element%span, element%size, extent, way(axis), error)
        if (allocated(error)) return
      end do
    end do
  end subroutine constrain_fixed_points

  !> Energy of all springs, force per unit thickness times length.
  pure real(dp) function spring_energy(self, position, time)
    type(fixed_point_t), intent(in) :: self
    real(dp), intent(in) :: position(:, :) !! (2, n_points), length
    real(dp), intent(in) :: time
    integer :: i

    spring_energy = 0.0_dp
    do i = 1, size(self%point)
      spring_energy = spring_energy + 0.5_dp*self%stiffness*sum(way_home(self, i, position, time)**2)
    end do
  end function spring_energy

  !> Force of the spring that holds fixed point `i`, per unit thickness.
  pure function spring_force(self, i, position, time) result(force)
    type(fixed_point_t), intent(in) :: self
    integer, intent(in) :: i
    real(dp), intent(in) :: position(:, :) !! (2, n_points), length
    real(dp), intent(in) :: time
    real(dp) :: force(2)

    force = self%stiffness*way_home(self, i, position, time)
  end function spring_force

  !> How far the fastest fixed point is moved between two times, length.
  pure real(dp) function way_of_fastest(self, from, to) result(way)
    type(fixed_point_t), intent(in) :: self
    real(dp), intent(in) :: from, to
    integer :: i

    way = 0.0_dp
    do i = 1, size(self%table)
      if (allocated(self%table(i)%time)) way = max(way, norm2(value_at(self%table(i), to) - value_at(self%table(i), from)))
    end do
  end function way_of_fastest

  !> From where fixed point `i` is to where it should be.
  pure function way_home(self, i, position, time) result(way)
    type(fixed_point_t), intent(in) :: self
    integer, intent(in) :: i
    real(dp), intent(in) :: position(:, :), time
    real(dp) :: way(2)

    way = self%home(:, i) - position(:, self%point(i))
    if (allocated(self%table(i)%time)) way = way + value_at(self%table(i), time) - value_at(self%table(i), 0.0_dp)
    if (is_roller(self, i)) way = dot_product(self%direction(:, i), way)*self%direction(:, i)
  end function way_home

  !> Whether fixed point `i` is held in one direction alone.
  pure logical function is_roller(self, i)
    type(fixed_point_t), intent(in) :: self
    integer, intent(in) :: i

    is_roller = .false.
    if (allocated(self%direction)) is_roller = any(abs(self%direction(:, i)) > 0)
  end function is_roller

  !> The part of displacements that is along a direction, of length 1.
  pure function along(direction, T)
    real(dp), intent(in) :: direction(2), T(2, element_unknowns)
    real(dp) :: along(2, element_unknowns), part(element_unknowns)

    part = matmul(direction, T)
    along(1, :) = direction(1)*part
    along(2, :) = direction(2)*part
  end function along

  !> Work in a step of the moving homes of the springs on element `e`, with the forces at its end.
  pure real(dp) function work_of_springs(self, e, position, time, dt, element, unknown) result(work)
    type(fixed_point_t), intent(in) :: self
    integer, intent(in) :: e
    real(dp), intent(in) :: position(:, :) !! (2, n_points) at the beginning of the step, length
    real(dp), intent(in) :: time, dt    !! beginning and size of the step
    type(kinematics_t), intent(in) :: element
    real(dp), intent(in) :: unknown(element_unknowns) !! of the step
    real(dp) :: before(2), after(2)
    integer :: i

    work = 0.0_dp
    do i = self%first(e), self%first(e + 1) - 1
      before = way_home(self, i, position, time)
      after = way_home(self, i, position, time + dt)
      work = work + self%stiffness*dot_product(after - before, &
        after - matmul(displacement_matrix(element, position(:, self%point(i))), unknown))
    end do
  end function work_of_springs

end module scree_fixed_point
