!> Rock bolts: axial springs between two points of bodies, or of a body and the ground (Shi 1988, bolting connections).
!>
!> A fully grouted bolt has springs along and across it where it crosses a joint (`scree_grouted_bolt`). Each crossing is a bolt of
!> its own here.
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
!> with w and omega of the strain (`step_rule_t`). Where the bolt yields in the step, N is that up to yield, and N1 = its strength
!> for the rest (`weigh`). Newmark's w = omega = 1 is the force at the end. The energy-momentum form has w = omega = 1/2. Then (a0 +
!> a1).(a1 - a0) = l1^2 - l0^2 makes the work exactly the change of k (l - r)^2/2, less N1 times the yield. F is along the axis
!> half-way, so it has no torque. w > 1/2 dissipates (w - 1/2) k (l1 - l0)^2 more. With n1 = a1/l1,
!>
!>     dF/da1 = w k (a/l) n1^T + omega N/l (I - (a/l) n1^T),
!>
!> which is symmetric where omega = 1; a secant takes a/l for n1.
!>
!> Generalized-alpha shares F, as the other elastic forces, between the beginning and the end of the step. Explicit steps take that
!> of the end, as of contacts, whose stiffness sets them no bound.
module scree_bolt
  use scree_element_term, only: add_force, add_pair_force, leave_symmetry, pair_term_t, step_rule_t, term_t
  use scree_grouted_bolt, only: has_symmetric_change, hold_together, openings, weigh, within_strength
  use scree_interpolation, only: displacement_matrix, kinematics_t
  use scree_kinds, only: dp
  use scree_state, only: bolt_broken, bolt_elastic, bolt_memory_t, bolt_yielded
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: accept_bolts, add_bolt_between, add_bolts_of_element, axis_of, begin_bolt, begin_bolts, bolt_energy, bolt_t, &
            ends_of, forces_of, is_grouted, lengths_of, work_between

  integer, parameter :: n = element_unknowns

  !> Called for when the scene has bolts.
  type :: bolt_t
    integer, allocatable :: point(:, :)      !! (2, n_bolts) points of the system at the ends, 0: in the ground
    integer, allocatable :: element(:, :)    !! (2, n_bolts) elements that carry them, 0: the ground does
    real(dp), allocatable :: ground(:, :, :) !! (xy, end, n_bolts) where an end in the ground is, length
    real(dp), allocatable :: stiffness(:, :) !! (2, n_bolts) along and across, 0: not grouted; force/length per unit thickness
    real(dp), allocatable :: strength(:, :)  !! (2, n_bolts) huge where it has none, force per unit thickness
    integer, allocatable :: crossing(:, :)   !! (2, n_bolts) points at the joint in either body, of grouted ones; else 0
    real(dp), allocatable :: piece(:, :)     !! (2, n_bolts) from there to the ends at the start, length
    integer, allocatable :: number(:)        !! (n_bolts) in the decks
    logical :: breaks = .false.              !! at its strength, else it yields
    logical, allocatable :: carries(:)       !! (n_elements) an end of any
    integer, allocatable :: first(:)         !! (n_elements+1) only element e carries alone(first(e):first(e+1)-1)
    integer, allocatable :: alone(:)
    integer, allocatable :: pair(:, :)       !! (2, n_pairs) elements that bolts join, in order, each once
    integer, allocatable :: first_of(:)      !! (n_pairs+1) the k-th pair has joining(first_of(k):first_of(k+1)-1)
    integer, allocatable :: joining(:)
  end type bolt_t

contains

  !> Memory of bolts at the start.
  pure function begin_bolts(self, position, pretension) result(memory)
    type(bolt_t), intent(in) :: self
    real(dp), intent(in) :: position(:, :)   !! (2, n_points) of the system, length
    real(dp), intent(in) :: pretension(:)    !! (n_bolts) force per unit thickness
    type(bolt_memory_t) :: memory
    integer :: i

    associate (n => size(pretension))
      allocate (memory%rest(n), memory%across(n), memory%state(n))
    end associate
    do i = 1, size(pretension)
      call begin_bolt(self, i, position, pretension(i), memory)
    end do
  end function begin_bolts

  !> Memory of bolt `i` where it begins: its length without force, which follows from the pretension, and its slip.
  pure subroutine begin_bolt(self, i, position, pretension, memory)
    type(bolt_t), intent(in) :: self
    integer, intent(in) :: i
    real(dp), intent(in) :: position(:, :)   !! (2, n_points), length
    real(dp), intent(in) :: pretension       !! force per unit thickness
    type(bolt_memory_t), intent(inout) :: memory
    real(dp) :: lengths(2)

    lengths = lengths_of(self, i, position)
    memory%rest(i) = lengths(1) - pretension/self%stiffness(1, i)
    memory%across(i) = lengths(2)
    memory%state(i) = bolt_elastic
  end subroutine begin_bolt

  !> Whether bolt `i` is a crossing of a grouted one.
  pure logical function is_grouted(self, i)
    type(bolt_t), intent(in) :: self
    integer, intent(in) :: i

    is_grouted = self%stiffness(2, i) > 0
  end function is_grouted

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

  !> From the place of a crossing in the first body to that in the second, and the mean of the unit vectors along the bolt.
  pure function gap_and_axis(self, i, position) result(y)
    type(bolt_t), intent(in) :: self
    integer, intent(in) :: i
    real(dp), intent(in) :: position(:, :)   !! (2, n_points), length
    real(dp) :: y(4)

    associate (at => position(:, self%crossing(:, i)), ends => position(:, self%point(:, i)), piece => self%piece(:, i))
      y(1:2) = at(:, 2) - at(:, 1)
      y(3:4) = 0.5_dp*((at(:, 1) - ends(:, 1))/piece(1) + (ends(:, 2) - at(:, 2))/piece(2))
    end associate
  end function gap_and_axis

  !> Length of bolt `i`, and nothing across; opening along and slip across a crossing of a grouted one.
  pure function lengths_of(self, i, position) result(lengths)
    type(bolt_t), intent(in) :: self
    integer, intent(in) :: i
    real(dp), intent(in) :: position(:, :)   !! (2, n_points), length
    real(dp) :: lengths(2)

    if (is_grouted(self, i)) then
      lengths = openings(gap_and_axis(self, i, position))
    else
      lengths = [norm2(axis_of(self, i, position)), 0.0_dp]
    end if
  end function lengths_of

  !> Tension of bolt `i`, below 0 where it pushes, and force across it; per unit thickness.
  pure function forces_of(self, memory, i, position) result(force)
    type(bolt_t), intent(in) :: self
    type(bolt_memory_t), intent(in) :: memory
    integer, intent(in) :: i
    real(dp), intent(in) :: position(:, :)   !! (2, n_points), length
    real(dp) :: force(2)

    force = 0.0_dp
    if (memory%state(i) >= bolt_broken) return
    force = self%stiffness(:, i)*(lengths_of(self, i, position) - [memory%rest(i), memory%across(i)])
    force = within_strength(force, self%strength(:, i))
  end function forces_of

  !> Force of bolt `i` against the variables of its springs in a step, and its derivative with respect to these. The variables are
  !> the displacement of the second end against the first, or `gap_and_axis` at a crossing of a grouted bolt.
  pure subroutine pull(self, memory, i, position, way, rule, force, change, symmetric)
    type(bolt_t), intent(in) :: self
    type(bolt_memory_t), intent(in) :: memory
    integer, intent(in) :: i
    real(dp), intent(in) :: position(:, :)   !! (2, n_points) at the beginning of the step, length
    real(dp), intent(in) :: way(:)           !! (m) of the step so far, 2 or at a crossing of a grouted one 4
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(out) :: force(:)        !! (m)
    real(dp), intent(out) :: change(:, :)    !! (m, m)
    logical, intent(out) :: symmetric        !! the change is

    if (is_grouted(self, i)) then
      call hold_together(self%stiffness(:, i), self%strength(:, i), forces_of(self, memory, i, position), &
                         gap_and_axis(self, i, position), way, rule, force, change, symmetric)
    else
      call pull_ends(self, memory, i, position, way, rule, force, change, symmetric)
    end if
  end subroutine pull

  !> Force of bolt `i` on its first end in a step that takes its second away from the first by `way`, and what it changes by with
  !> that.
  pure subroutine pull_ends(self, memory, i, position, way, rule, force, change, symmetric)
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
    real(dp) :: follows, length(2), middle, reach, start(2), weighed
    integer :: k

    associate (omega => rule%operator_weight, w => rule%stress_weight, stiffness => self%stiffness(1, i), &
               strength => self%strength(1, i))
      before = axis_of(self, i, position)
      after = before + way
      length = max([norm2(before), norm2(after)], epsilon(1.0_dp)*memory%rest(i))
      start = forces_of(self, memory, i, position)
      reach = start(1) + stiffness*dot_product(way, before + after)/sum(length) ! no difference of lengths, which round off
      call weigh(w, start(1), reach, min(reach, strength), weighed, follows)
      axis = before + omega*way
      middle = length(1) + omega*(length(2) - length(1))
      direction = axis/middle
      force = weighed*direction
      symmetric = has_symmetric_change(rule)
      end_direction = merge(direction, after/length(2), symmetric)
      change = 0.0_dp
      do k = 1, 2
        change(k, k) = omega*weighed/middle
        change(:, k) = change(:, k) - omega*weighed/middle*direction*end_direction(k)
        change(:, k) = change(:, k) + follows*stiffness*direction*end_direction(k)
      end do
      if (rule%end_weight > 0 .and. rule%end_weight < 1) then
        force = rule%end_weight*force + (1 - rule%end_weight)*start(1)*before/length(1)
        change = rule%end_weight*change
      end if
    end associate
  end subroutine pull_ends

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

  !> Rows of bolt `i` per unknown of the pair of elements that it joins: of its second end from the first, or at a crossing of a
  !> grouted one of `gap_and_axis`.
  pure function rows_between(self, i, pair, position, elements) result(row)
    type(bolt_t), intent(in) :: self
    integer, intent(in) :: i, pair(2)
    real(dp), intent(in) :: position(:, :)   !! (2, n_points) at the beginning of the step, length
    type(kinematics_t), intent(in) :: elements(2) !! of the pair
    real(dp), allocatable :: row(:, :)       !! (m, 2 n)
    real(dp), dimension(2, n) :: at_end, at_joint
    integer :: k, side

    allocate (row(merge(4, 2, is_grouted(self, i)), 2*n))
    do k = 1, 2
      side = findloc(pair, self%element(k, i), 1)
      associate (own => row(:, n*(side - 1) + 1:n*side), towards => 2*k - 3)
        at_end = displacement_matrix(elements(side), position(:, self%point(k, i)))
        if (.not. is_grouted(self, i)) then
          own = towards*at_end
        else
          at_joint = displacement_matrix(elements(side), position(:, self%crossing(k, i)))
          own(1:2, :) = towards*at_joint
          own(3:4, :) = 0.5_dp*towards/self%piece(k, i)*(at_end - at_joint)
        end if
      end associate
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
    real(dp), allocatable :: change(:, :), force(:), row(:, :)
    logical :: symmetric

    if (memory%state(i) >= bolt_broken) return
    row = rows_between(self, i, pair, position, elements)
    allocate (force(size(row, 1)), change(size(row, 1), size(row, 1)))
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
    real(dp), allocatable :: change(:, :), force(:), row(:, :)
    logical :: symmetric

    work = 0.0_dp
    if (memory%state(i) >= bolt_broken) return
    row = rows_between(self, i, pair, position, elements)
    allocate (force(size(row, 1)), change(size(row, 1), size(row, 1)))
    call pull(self, memory, i, position, matmul(row, unknown), rule, force, change, symmetric)
    work = dot_product(force, matmul(row, unknown))
  end function work_between

  !> Energy of all bolts, force per unit thickness times length.
  pure real(dp) function bolt_energy(self, memory, position) result(energy)
    type(bolt_t), intent(in) :: self
    type(bolt_memory_t), intent(in) :: memory
    real(dp), intent(in) :: position(:, :)   !! (2, n_points), length
    integer :: i

    energy = 0.0_dp
    do i = 1, size(memory%rest)
      energy = energy + energy_at(self, i, forces_of(self, memory, i, position))
    end do
  end function bolt_energy

  !> Energy of bolt `i` at its forces.
  pure real(dp) function energy_at(self, i, force) result(energy)
    type(bolt_t), intent(in) :: self
    integer, intent(in) :: i
    real(dp), intent(in) :: force(2)         !! along and across, per unit thickness

    energy = 0.5_dp*force(1)**2/self%stiffness(1, i)
    if (is_grouted(self, i)) energy = energy + 0.5_dp*force(2)**2/self%stiffness(2, i)
  end function energy_at

  !> Lets the bolts that reached their strength in an accepted step yield or break, and adds up the dissipated energy: forces times
  !> the growth of the springs, and the energy of bolts that break.
  pure subroutine accept_bolts(self, position, memory, lost)
    type(bolt_t), intent(in) :: self
    real(dp), intent(in) :: position(:, :)   !! (2, n_points) at the end of the step, length
    type(bolt_memory_t), intent(inout) :: memory
    real(dp), intent(inout) :: lost          !! force per unit thickness times length
    real(dp), dimension(2) :: apart, force, growth
    integer :: i

    do i = 1, size(memory%rest)
      if (memory%state(i) >= bolt_broken) cycle
      apart = lengths_of(self, i, position) - [memory%rest(i), memory%across(i)]
      force = forces_of(self, memory, i, position)
      growth = 0.0_dp
      where (abs(self%stiffness(:, i)*apart) > abs(force)) growth = apart - force/self%stiffness(:, i)
      if (.not. any(abs(growth) > 0)) cycle
      lost = lost + dot_product(force, growth)
      if (self%breaks) then
        lost = lost + energy_at(self, i, force)
        memory%state(i) = bolt_broken
      else
        memory%rest(i) = memory%rest(i) + growth(1)
        memory%across(i) = memory%across(i) + growth(2)
        memory%state(i) = bolt_yielded
      end if
    end do
  end subroutine accept_bolts

end module scree_bolt
