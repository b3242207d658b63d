!> Rock bolts: axial springs between two points of bodies, or of a body and the ground (Shi 1988, bolting connections).
!>
!> With a the vector from the first end to the second, l its length and r the length without force, the tension is
!>
!>     N(l) = k (l - r),   at most the strength,
!>
!> and pushes where l < r. A bolt that reaches its strength yields, r growing with it, or breaks and is gone. A step takes a from a0
!> to a1 and balances the force on the first end (on the second is its opposite)
!>
!>     F = N a / l,   N = N0 + w (N1 - N0),   a = a0 + omega (a1 - a0),   l = l0 + omega (l1 - l0),
!>
!> w and omega those of the strain (`step_rule_t`). Newmark's w = omega = 1 is the force at the end. The energy-momentum form has
!> w = omega = 1/2, and (a0 + a1).(a1 - a0) = l1^2 - l0^2 makes its work exactly the change of k (l - r)^2/2, less N times what it
!> yields; F is along the axis half-way, so that it has no torque. w > 1/2 takes (w - 1/2) k (l1 - l0)^2 more. With n1 = a1/l1,
!>
!>     dF/da1 = w k (a/l) n1^T + omega N/l (I - (a/l) n1^T),
!>
!> which is symmetric where omega = 1; a secant takes a/l for n1.
!>
!> As the springs of contacts and of fixed points, bolts balance at the end of the step whatever share of it elastic forces take.
module scree_bolt
  use scree_element_term, only: add_force, add_pair_force, leave_symmetry, pair_term_t, step_rule_t, term_t
  use scree_interpolation, only: displacement_matrix, kinematics_t
  use scree_kinds, only: dp
  use scree_state, only: bolt_broken, bolt_elastic, bolt_memory_t, bolt_yielded
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: accept_bolts, add_bolt_between, add_bolts_of_element, begin_bolts, bolt_energy, bolt_t, ends_of, &
            length_of, tension_of, work_between

  integer, parameter :: n = element_unknowns
  !> Weights that differ by less are the same.
  real(dp), parameter :: same = 1e-12_dp

  !> Called for when the scene has bolts.
  type :: bolt_t
    integer, allocatable :: point(:, :)      !! (2, n_bolts) points of the system at the ends, 0: in the ground
    integer, allocatable :: element(:, :)    !! (2, n_bolts) elements that carry them, 0: the ground does
    real(dp), allocatable :: ground(:, :, :) !! (xy, end, n_bolts) where an end in the ground is, length
    real(dp), allocatable :: stiffness(:)    !! (n_bolts) force/length per unit thickness
    real(dp), allocatable :: strength(:)     !! (n_bolts) huge where it has none, force per unit thickness
    logical :: breaks = .false.              !! at its strength, else it yields
    logical, allocatable :: carries(:)       !! (n_elements) an end of any
    integer, allocatable :: first(:)         !! (n_elements+1) only element e carries alone(first(e):first(e+1)-1)
    integer, allocatable :: alone(:)
    integer, allocatable :: pair(:, :)       !! (2, n_pairs) elements that bolts join, in order, each once
    integer, allocatable :: first_of(:)      !! (n_pairs+1) the k-th pair has joining(first_of(k):first_of(k+1)-1)
    integer, allocatable :: joining(:)
  end type bolt_t

contains

  !> What bolts remember at the start: the length without force that a pretension leaves them.
  pure function begin_bolts(self, position, pretension) result(memory)
    type(bolt_t), intent(in) :: self
    real(dp), intent(in) :: position(:, :)   !! (2, n_points) of the system, length
    real(dp), intent(in) :: pretension(:)    !! (n_bolts) force per unit thickness
    type(bolt_memory_t) :: memory
    integer :: i

    memory%rest = [(length_of(self, i, position) - pretension(i)/self%stiffness(i), i=1, size(pretension))]
    allocate (memory%state(size(pretension)), source=bolt_elastic)
  end function begin_bolts

  !> The ends of bolt `i`, (xy, end), length.
  pure function ends_of(self, i, position) result(ends)
    type(bolt_t), intent(in) :: self
    integer, intent(in) :: i
    real(dp), intent(in) :: position(:, :)   !! (2, n_points), length
    real(dp) :: ends(2, 2)
    integer :: k

    ends = self%ground(:, :, i)
    do k = 1, 2
      if (self%point(k, i) > 0) ends(:, k) = position(:, self%point(k, i))
    end do
  end function ends_of

  !> From the first end of bolt `i` to its second.
  pure function axis_of(self, i, position) result(axis)
    type(bolt_t), intent(in) :: self
    integer, intent(in) :: i
    real(dp), intent(in) :: position(:, :)   !! (2, n_points), length
    real(dp) :: axis(2), ends(2, 2)

    ends = ends_of(self, i, position)
    axis = ends(:, 2) - ends(:, 1)
  end function axis_of

  !> Length of bolt `i`.
  pure real(dp) function length_of(self, i, position)
    type(bolt_t), intent(in) :: self
    integer, intent(in) :: i
    real(dp), intent(in) :: position(:, :)   !! (2, n_points), length

    length_of = norm2(axis_of(self, i, position))
  end function length_of

  !> Tension of bolt `i`, force per unit thickness; below 0 it pushes.
  pure real(dp) function tension_of(self, memory, i, position) result(tension)
    type(bolt_t), intent(in) :: self
    type(bolt_memory_t), intent(in) :: memory
    integer, intent(in) :: i
    real(dp), intent(in) :: position(:, :)   !! (2, n_points), length

    tension = 0.0_dp
    if (memory%state(i) >= bolt_broken) return
    tension = min(self%stiffness(i)*(length_of(self, i, position) - memory%rest(i)), self%strength(i))
  end function tension_of

  !> Force of bolt `i` on its first end in a step that takes its second away from the first by `way`, and what it changes by with
  !> that.
  pure subroutine pull(self, memory, i, position, way, rule, force, change, symmetric)
    type(bolt_t), intent(in) :: self
    type(bolt_memory_t), intent(in) :: memory
    integer, intent(in) :: i
    real(dp), intent(in) :: position(:, :)   !! (2, n_points) at the beginning of the step, length
    real(dp), intent(in) :: way(2)           !! of the step so far, length
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(out) :: force(2)
    real(dp), intent(out) :: change(2, 2)    !! force/length per unit thickness
    logical, intent(out) :: symmetric        !! the change is
    real(dp), dimension(2) :: after, axis, before, direction, end_direction
    real(dp) :: length(2), middle, tension(2), weighed
    integer :: k

    associate (omega => rule%operator_weight, w => rule%stress_weight, stiffness => self%stiffness(i))
      before = axis_of(self, i, position)
      after = before + way
      length = max([norm2(before), norm2(after)], epsilon(1.0_dp)*memory%rest(i))
      tension(1) = tension_of(self, memory, i, position)
      tension(2) = tension(1) + stiffness*dot_product(way, before + after)/sum(length) ! no difference of lengths, which round off
      tension(2) = min(tension(2), self%strength(i))
      axis = before + omega*way
      middle = length(1) + omega*(length(2) - length(1))
      direction = axis/middle
      weighed = tension(1) + w*(tension(2) - tension(1))
      force = weighed*direction
      symmetric = abs(omega - 1) < same .or. .not. rule%tangent
      end_direction = merge(direction, after/length(2), symmetric)
      change = 0.0_dp
      do k = 1, 2
        change(k, k) = omega*weighed/middle
        change(:, k) = change(:, k) - omega*weighed/middle*direction*end_direction(k)
        if (tension(2) < self%strength(i)) change(:, k) = change(:, k) + w*stiffness*direction*end_direction(k)
      end do
    end associate
  end subroutine pull

  !> Adds the bolts that element `e` alone carries: in the ground with their other end, or with both in it.
  pure subroutine add_bolts_of_element(self, memory, e, position, rule, element, unknown, term)
    type(bolt_t), intent(in) :: self
    type(bolt_memory_t), intent(in) :: memory
    integer, intent(in) :: e
    real(dp), intent(in) :: position(:, :)   !! (2, n_points) at the beginning of the step, length
    type(step_rule_t), intent(in) :: rule
    type(kinematics_t), intent(in) :: element
    real(dp), intent(in) :: unknown(n)       !! of the step so far
    type(term_t), intent(inout) :: term
    real(dp) :: change(2, 2), force(2), row(2, n)
    integer :: i, k, m
    logical :: symmetric

    do m = self%first(e), self%first(e + 1) - 1
      i = self%alone(m)
      if (memory%state(i) >= bolt_broken) cycle
      row = 0.0_dp
      do k = 1, 2
        if (self%element(k, i) == e) row = row + (2*k - 3)*displacement_matrix(element, position(:, self%point(k, i)))
      end do
      call pull(self, memory, i, position, matmul(row, unknown), rule, force, change, symmetric)
      term%symmetric = term%symmetric .and. symmetric
      term%matrix = term%matrix + matmul(transpose(row), matmul(change, row))
      call add_force(term, -matmul(force, row), matmul(abs(force) + matmul(abs(change), matmul(abs(row), abs(unknown))), abs(row)))
    end do
  end subroutine add_bolts_of_element

  !> Displacement of the second end of bolt `i` less that of the first, per unknown of its pair of elements, 2 x 2 n.
  pure function rows_between(self, i, pair, position, elements) result(row)
    type(bolt_t), intent(in) :: self
    integer, intent(in) :: i, pair(2)
    real(dp), intent(in) :: position(:, :)   !! (2, n_points) at the beginning of the step, length
    type(kinematics_t), intent(in) :: elements(2) !! of the pair
    real(dp) :: row(2, 2*n)
    integer :: k, side

    do k = 1, 2
      side = findloc(pair, self%element(k, i), 1)
      row(:, n*(side - 1) + 1:n*side) = (2*k - 3)*displacement_matrix(elements(side), position(:, self%point(k, i)))
    end do
  end function rows_between

  !> Adds bolt `i`, which joins the elements of a pair.
  pure subroutine add_bolt_between(self, memory, i, pair, position, rule, elements, unknown, term)
    type(bolt_t), intent(in) :: self
    type(bolt_memory_t), intent(in) :: memory
    integer, intent(in) :: i, pair(2)
    real(dp), intent(in) :: position(:, :)   !! (2, n_points) at the beginning of the step, length
    type(step_rule_t), intent(in) :: rule
    type(kinematics_t), intent(in) :: elements(2) !! of the pair
    real(dp), intent(in) :: unknown(2*n)     !! of the pair, of the step so far
    type(pair_term_t), intent(inout) :: term
    real(dp) :: change(2, 2), force(2), row(2, 2*n)
    logical :: symmetric

    if (memory%state(i) >= bolt_broken) return
    row = rows_between(self, i, pair, position, elements)
    call pull(self, memory, i, position, matmul(row, unknown), rule, force, change, symmetric)
    if (.not. symmetric) call leave_symmetry(term)
    term%matrix = term%matrix + matmul(transpose(row), matmul(change, row))
    call add_pair_force(term, -matmul(force, row))
  end subroutine add_bolt_between

  !> Work in a step of what pulls the ends of bolt `i` apart, which joins the elements of a pair.
  pure real(dp) function work_between(self, memory, i, pair, position, rule, elements, unknown) result(work)
    type(bolt_t), intent(in) :: self
    type(bolt_memory_t), intent(in) :: memory
    integer, intent(in) :: i, pair(2)
    real(dp), intent(in) :: position(:, :)   !! (2, n_points) at the beginning of the step, length
    type(step_rule_t), intent(in) :: rule
    type(kinematics_t), intent(in) :: elements(2) !! of the pair
    real(dp), intent(in) :: unknown(2*n)     !! of the pair, of the step
    real(dp) :: change(2, 2), force(2), way(2)
    logical :: symmetric

    work = 0.0_dp
    if (memory%state(i) >= bolt_broken) return
    way = matmul(rows_between(self, i, pair, position, elements), unknown)
    call pull(self, memory, i, position, way, rule, force, change, symmetric)
    work = dot_product(force, way)
  end function work_between

  !> Energy of all bolts, force per unit thickness times length.
  pure real(dp) function bolt_energy(self, memory, position) result(energy)
    type(bolt_t), intent(in) :: self
    type(bolt_memory_t), intent(in) :: memory
    real(dp), intent(in) :: position(:, :)   !! (2, n_points), length
    integer :: i

    energy = 0.0_dp
    do i = 1, size(memory%rest)
      energy = energy + 0.5_dp*tension_of(self, memory, i, position)**2/self%stiffness(i)
    end do
  end function bolt_energy

  !> Lets the bolts that reached their strength in an accepted step yield or break, and adds up the energy that this takes: the mean
  !> of the tensions times what they grew by, and what a bolt that breaks had.
  pure subroutine accept_bolts(self, before, position, memory, lost)
    type(bolt_t), intent(in) :: self
    real(dp), intent(in) :: before(:, :)     !! (2, n_points) at the beginning of the step, length
    real(dp), intent(in) :: position(:, :)   !! (2, n_points) at its end
    type(bolt_memory_t), intent(inout) :: memory
    real(dp), intent(inout) :: lost          !! force per unit thickness times length
    real(dp) :: growth
    integer :: i

    do i = 1, size(memory%rest)
      if (memory%state(i) >= bolt_broken) cycle
      if (.not. self%stiffness(i)*(length_of(self, i, position) - memory%rest(i)) > self%strength(i)) cycle
      growth = length_of(self, i, position) - memory%rest(i) - self%strength(i)/self%stiffness(i)
      lost = lost + 0.5_dp*(tension_of(self, memory, i, before) + self%strength(i))*growth
      if (self%breaks) then
        lost = lost + 0.5_dp*self%strength(i)**2/self%stiffness(i)
        memory%state(i) = bolt_broken
      else
        memory%rest(i) = memory%rest(i) + growth
        memory%state(i) = bolt_yielded
      end if
    end do
  end subroutine accept_bolts

end module scree_bolt
