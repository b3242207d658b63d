!> Solves friction problems as a step does, for tools/bench problems.
!>
!> Standard input: friction problems one after the other, each as `read_problem` has it, numbers of 4 and 8 bytes as this machine
!> has them. Standard output, a line for each: 1 or 0 where it was solved or not, what is left over the largest force, matrices
!> factorised, pieces of paths, seconds of the processor.
program bench_problems
  use, intrinsic :: iso_fortran_env, only: iostat_end, output_unit
  use scree_blas, only: keep_memory, keep_to_one_thread
  use scree_friction_problem, only: forces_left, friction_problem_t, place_springs
  use scree_friction_solver, only: friction_work_t, solve_friction
  use scree_kinds, only: dp
  use scree_sparse_matrix, only: add_element, build_pattern
  use scree_timers, only: timers_t
  implicit none

  real(dp), parameter :: tolerance = 1e-8_dp !! of the largest force, that of a step
  type(friction_problem_t) :: problem
  type(friction_work_t) :: work
  type(timers_t) :: timers
  real(dp), allocatable :: x(:)
  integer, allocatable :: state(:)
  real(dp) :: begun, ended, left
  integer :: head(7), status, unit
  logical :: found

  call keep_to_one_thread()
  call keep_memory()
  open (newunit=unit, file='/dev/stdin', access='stream', form='unformatted', action='read', status='old')
  do
    read (unit, iostat=status) head
    if (status == iostat_end) exit
    call read_problem(problem)
    if (allocated(state)) deallocate (state)
    allocate (state(size(problem%spring)))
    call cpu_time(begun)
    call solve_friction(problem, head(5) == 1, tolerance, timers, x, state, found, work)
    call cpu_time(ended)
    call forces_left(problem, x, state, left)
    write (output_unit, '(i0, es10.2, 2(1x, i0), es12.4)') merge(1, 0, found), left, work%factors, work%pieces, ended - begun
  end do

contains

  !> Reads a problem: numbers of unknowns, entries of A, springs, places in a row; whether zero is near its solution, A is
  !> symmetric, the springs are (all of that the head); row and column of the entries from 1, their values; f; span; the seven
  !> numbers of each spring; unknowns of its row, n, t, n', t'.
  subroutine read_problem(problem)
    type(friction_problem_t), intent(out) :: problem
    integer :: at(2, head(2)), rows(max(2, head(4)), head(2) + head(3)), i
    real(dp) :: value(head(2)), law(7, head(3)), entry(2, 2)

    call place_springs(problem, head(3), head(4))
    allocate (problem%force(head(1)), problem%span(head(1)))
    read (unit) at, value, problem%force, problem%span, law, problem%row
    read (unit) problem%normal, problem%shear, problem%normal_change, problem%shear_change
    rows = 0
    do i = 1, head(3)
      associate (spring => problem%spring(i))
        spring%slot = head(2) + i
        spring%pressing = law(1, i)
        spring%stiffness = law(2, i)
        spring%shear = law(3, i)
        spring%shear_stiffness = law(4, i)
        spring%friction = law(5, i)
        spring%cohesion = law(6, i)
        spring%bonded = law(7, i) > 0
      end associate
      problem%length(i) = count(problem%row(:, i) > 0)
    end do
    rows(:head(4), head(2) + 1:) = problem%row
    where (problem%row == 0) problem%row = 1
    do i = 1, head(2)
      rows(1, i) = at(1, i)
      if (at(2, i) /= at(1, i)) rows(2, i) = at(2, i)
    end do
    call build_pattern(head(1), rows, problem%matrix)
    entry = 0.0_dp
    do i = 1, head(2) ! an entry is an element with its transpose zero
      if (at(2, i) == at(1, i)) then
        call add_element(problem%matrix, i, reshape([value(i)], [1, 1]), .true.)
      else
        entry(1, 2) = value(i)
        call add_element(problem%matrix, i, entry, head(6) == 1)
      end if
    end do
    problem%symmetric = head(7) == 1
  end subroutine read_problem

end program bench_problems
