!> Part of a friction problem: the unknowns about some of its springs, while all others stay where they are.
!>
!> The part has a solution where the whole has one by the theorem (doc/theory/open-close.md, eq-existence): its matrix is a
!> principal one of a matrix that is definite.
module scree_friction_part
  use scree_friction_problem, only: acts_on, friction_problem_t, place_springs, spring_elsewhere, unknowns_about
  use scree_friction_solver, only: effort_quick, friction_work_t, solve_friction
  use scree_kinds, only: dp
  use scree_sparse_matrix, only: on_fewer_rows
  use scree_timers, only: begin_phase, phase_friction, timers_t
  implicit none
  private
  public :: solve_about

  !> Largest fraction of the unknowns that are solved for apart from the others.
  real(dp), parameter :: largest_part = 0.25_dp

contains

  !> Solves the part of a problem about some of its springs, if this part is small and its solution is found at once. The residual
  !> is below `tolerance` times the largest force.
  subroutine solve_about(problem, about, reach, near, tolerance, timers, part, x, state, found, work)
    type(friction_problem_t), intent(in) :: problem
    logical, intent(in) :: about(:)              !! (m) springs
    integer, intent(in) :: reach                 !! of the part, in unknowns that the matrix couples
    logical, intent(in) :: near                  !! zero is near the solution
    real(dp), intent(in) :: tolerance
    type(timers_t), intent(inout) :: timers
    type(friction_problem_t), intent(out) :: part !! that was solved; nothing where it is not small
    real(dp), allocatable, intent(out) :: x(:)   !! (n) zero elsewhere; means nothing where no solution was found
    integer, intent(out) :: state(:)             !! (m) of the springs
    logical, intent(out) :: found
    type(friction_work_t), intent(out) :: work
    logical :: is_part(size(problem%force))
    integer, allocatable :: list(:), own_state(:)
    real(dp), allocatable :: own(:)

    is_part = unknowns_about(problem, about, reach)
    state = spring_elsewhere
    found = count(is_part) <= largest_part*size(is_part)
    if (.not. found) return
    call begin_phase(timers, phase_friction)
    call part_of(problem, is_part, list, part)
    allocate (own_state(size(list)))
    call solve_friction(part, near, tolerance, timers, own, own_state, found, work, effort_quick)
    state(list) = own_state
    allocate (x(size(is_part)), source=0.0_dp)
    x = unpack(own, is_part, x)
  end subroutine solve_about

  !> The problem of some of the unknowns, with the springs that act on them.
  pure subroutine part_of(problem, is_part, list, part)
    type(friction_problem_t), intent(in) :: problem
    logical, intent(in) :: is_part(:)            !! (n) unknowns
    integer, allocatable, intent(out) :: list(:) !! springs of the part, by their numbers in the problem
    type(friction_problem_t), intent(out) :: part
    integer :: number(size(is_part)), i, k, w

    w = 0
    do i = 1, size(is_part)
      if (is_part(i)) w = w + 1
      number(i) = w
    end do
    list = pack([(i, i=1, size(problem%spring))], acts_on(problem, is_part))
    part%matrix = on_fewer_rows(problem%matrix, is_part)
    part%symmetric = problem%symmetric
    part%force = pack(problem%force, is_part)
    part%span = pack(problem%span, is_part)
    call place_springs(part, size(list), size(problem%row, 1))
    part%spring = problem%spring(list)
    do i = 1, size(list)
      w = 0
      do k = 1, problem%length(list(i))
        if (.not. is_part(problem%row(k, list(i)))) cycle
        w = w + 1
        part%row(w, i) = number(problem%row(k, list(i)))
        part%normal(w, i) = problem%normal(k, list(i))
        part%shear(w, i) = problem%shear(k, list(i))
        part%normal_change(w, i) = problem%normal_change(k, list(i))
        part%shear_change(w, i) = problem%shear_change(k, list(i))
      end do
      part%length(i) = w
    end do
  end subroutine part_of

end module scree_friction_part
