!> Fixed points: eliminated exactly, or held by springs (Shi's df12).
module scree_fixed_point
  use scree_element_term, only: add_force, term_t
  use scree_interpolation, only: displacement_matrix, kinematics_t
  use scree_kinds, only: dp
  use scree_point_load, only: value_at
  use scree_scene, only: time_table_t
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: add_fixed_springs, fixed_spring_t, prescribed_displacement, spring_energy

  !> Called for when points are fixed by springs.
  type :: fixed_spring_t
    integer, allocatable :: first(:)    !! (n_elements+1) element e carries springs first(e):first(e+1)-1
    integer, allocatable :: point(:)    !! (n_springs) point of the system
    real(dp), allocatable :: home(:, :) !! (2, n_springs) where it is held at the start, length
    type(time_table_t), allocatable :: table(:) !! (n_springs) displacement of the home; without times: none
    real(dp) :: stiffness = 0.0_dp      !! force/length per unit thickness
  end type fixed_spring_t

contains

  !> Adds p T^T T and the forces p T^T (home - x - T d) of every spring on element `e`.
  pure subroutine add_fixed_springs(self, e, place, time, element, unknown, term)
    type(fixed_spring_t), intent(in) :: self
    integer, intent(in) :: e
    real(dp), intent(in) :: place(:, :) !! (2, n_points) at the beginning of the step, length
    real(dp), intent(in) :: time        !! at the end of the step
    type(kinematics_t), intent(in) :: element
    real(dp), intent(in) :: unknown(element_unknowns) !! of the step so far
    type(term_t), intent(inout) :: term
    real(dp) :: T(2, element_unknowns), pull(2)
    integer :: i

    do i = self%first(e), self%first(e + 1) - 1
      T = displacement_matrix(element, place(:, self%point(i)))
      pull = self%home(:, i) + prescribed_displacement(self%table(i), time) - place(:, self%point(i)) - matmul(T, unknown)
      term%matrix = term%matrix + self%stiffness*matmul(transpose(T), T)
      call add_force(term, self%stiffness*matmul(pull, T), self%stiffness*matmul(matmul(abs(T), abs(unknown)), abs(T)))
    end do
  end subroutine add_fixed_springs

  !> Energy of all springs, force per unit thickness times length.
  pure real(dp) function spring_energy(self, place, time)
    type(fixed_spring_t), intent(in) :: self
    real(dp), intent(in) :: place(:, :) !! (2, n_points), length
    real(dp), intent(in) :: time
    integer :: i

    spring_energy = 0.0_dp
    do i = 1, size(self%point)
      spring_energy = spring_energy + 0.5_dp*self%stiffness &
                      *sum((self%home(:, i) + prescribed_displacement(self%table(i), time) - place(:, self%point(i)))**2)
    end do
  end function spring_energy

  !> Displacement since the start that a table prescribes; none without times.
  pure function prescribed_displacement(table, time) result(displacement)
    type(time_table_t), intent(in) :: table
    real(dp), intent(in) :: time
    real(dp) :: displacement(2)

    displacement = 0.0_dp
    if (allocated(table%time)) displacement = value_at(table, time) - value_at(table, 0.0_dp)
  end function prescribed_displacement

end module scree_fixed_point
