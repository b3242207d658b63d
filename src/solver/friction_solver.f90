!> Solution of a friction problem by what settles it where Newton's iteration runs in circles.
!>
!> The interior is quick, but may end at a fold of its way; the path goes round folds, one spring at a time, and is short from
!> there, and from near the solution. Where it is not, the way inside goes on to its end; where neither gets through, the interior
!> is begun elsewhere.
module scree_friction_solver
  use scree_friction_interior, only: begin_inside, go_inside, inside_t
  use scree_friction_path, only: follow_path
  use scree_friction_problem, only: closed_forces, forces_left, friction_problem_t, of_springs
  use scree_kinds, only: dp
  use scree_linear_solver, only: linear_solver_t, release_solver
  use scree_timers, only: timers_t
  implicit none
  private
  public :: friction_work_t, solve_friction

  !> What a solution may take: all that there is; only the first start inside, and no path from its end; only the path from zero,
  !> where that is near.
  integer, parameter, public :: effort_all = 0, effort_quick = 1, effort_path = 2

  !> What a solution took.
  type :: friction_work_t
    integer :: factors = 0 !! of matrices
    integer :: pieces = 0  !! of paths
  end type friction_work_t

  !> What the interior begins with over the largest force.
  real(dp), parameter :: at_first(*) = [0.3_dp, 3.0_dp, 0.01_dp, 30.0_dp, 1.0_dp, 0.1_dp]
  !> How often it is begun, by effort.
  integer, parameter :: starts(effort_all:effort_path) = [size(at_first), 1, 0]
  !> Shares of the largest force that it leaves before the path is tried from there, and pieces that may cost no more than the rest
  !> of the way inside does, which goes on where they do not do.
  real(dp), parameter :: leaves(*) = [1e-4_dp, 1e-6_dp, 0.0_dp]
  integer, parameter :: most_left(size(leaves)) = [40, 150, 0]
  !> Gap over the largest overlap up to which springs are taken at first, and near the solution, where bodies go farther than they
  !> overlap; and times that some are taken in: the last time all.
  real(dp), parameter :: reach = 1.0_dp, reach_near = 8.0_dp
  integer, parameter :: most_additions = 5
  !> Pieces that a path may cross, and one from near the solution.
  integer, parameter :: most_pieces = 600, most_near = 300

contains

  !> Solves a friction problem, to a share `tolerance` of the largest force.
  !>
  !> Springs that are open by far are left out, and with them what fills the factors; those that would press in the solution are
  !> taken in, and it is solved again from there. Near the solution, as of a problem that differs in few springs, the path is short
  !> and is tried first.
  subroutine solve_friction(problem, near, tolerance, timers, x, state, found, work, effort)
    type(friction_problem_t), intent(in) :: problem
    logical, intent(in) :: near                !! zero is near the solution
    real(dp), intent(in) :: tolerance
    type(timers_t), intent(inout) :: timers
    real(dp), allocatable, intent(out) :: x(:) !! (n); means nothing where none was found
    integer, intent(out) :: state(:)           !! (m) of the springs
    logical, intent(out) :: found
    type(friction_work_t), intent(out) :: work
    integer, intent(in), optional :: effort    !! all where absent
    integer :: may
    logical :: kept(size(state)), press(size(state))
    real(dp) :: closed(2), farthest, left
    integer :: i, k

    may = effort_all
    if (present(effort)) may = effort
    x = 0.0_dp*problem%force
    associate (spring => problem%spring)
      farthest = merge(reach_near, reach, near)*max(0.0_dp, maxval(spring%pressing/spring%stiffness))
      kept = spring%bonded .or. spring%pressing >= -farthest*spring%stiffness
    end associate
    if (.not. any(kept)) kept = .true.
    do i = 1, most_additions
      if (i == most_additions .or. 5*count(kept) > 4*size(kept)) kept = .true.
      if (all(kept)) exit
      call solve_kept(near .or. i > 1)
      if (.not. found) then
        if (may /= effort_all) return
        kept = .true.
        x = 0.0_dp
        exit
      end if
      do k = 1, size(state)
        closed = closed_forces(problem, k, x)
        press(k) = closed(1) > 0 .and. .not. kept(k)
      end do
      if (.not. any(press)) exit
      kept = kept .or. press
    end do
    if (all(kept)) call solve_springs(problem, near, tolerance, may, timers, x, state, found, work)
    if (.not. found) return
    call forces_left(problem, x, state, left)
    found = left <= tolerance

  contains

    !> Solves the problem of what is kept, from where x is.
    subroutine solve_kept(from_here)
      logical, intent(in) :: from_here
      integer :: few_states(count(kept))

      call solve_springs(of_springs(problem, pack([(k, k=1, size(kept))], kept)), from_here, tolerance, may, timers, x, &
                         few_states, found, work)
    end subroutine solve_kept

  end subroutine solve_friction

  !> Solves a friction problem of springs all of which may press.
  subroutine solve_springs(problem, near, tolerance, effort, timers, x, state, found, work)
    type(friction_problem_t), intent(in) :: problem
    logical, intent(in) :: near                !! x is near the solution
    real(dp), intent(in) :: tolerance
    integer, intent(in) :: effort
    type(timers_t), intent(inout) :: timers
    real(dp), intent(inout) :: x(:)            !! (n); means nothing where none was found
    integer, intent(out) :: state(:)           !! (m) of the springs
    logical, intent(out) :: found
    type(friction_work_t), intent(inout) :: work !! is counted on
    type(inside_t) :: inside
    type(linear_solver_t) :: solver            ! all matrices have one pattern, and one analysis
    integer :: i, k

    found = .false.
    if (near) call go_along(most_near, .false.)
    do i = 1, starts(effort)
      if (found) exit
      call begin_inside(problem, at_first(i), 0.0_dp*problem%force, inside)
      do k = 1, size(leaves)
        call go_inside(problem, max(tolerance, leaves(k)), effort == effort_all, solver, timers, inside, state, found)
        x = inside%x
        if (leaves(k) <= tolerance .or. .not. found) exit
        call go_along(most_left(k), .false.)
        if (found) exit
      end do
      work%factors = work%factors + inside%factors
      if (effort == effort_all .and. .not. found) call go_along(most_pieces, .true.)
    end do
    call release_solver(solver)

  contains

    !> Follows the path from where x is.
    subroutine go_along(most, patient)
      integer, intent(in) :: most    !! pieces
      logical, intent(in) :: patient !! it may wander, as there is no other way
      integer :: factors, pieces
      real(dp) :: left

      call follow_path(problem, most, patient, solver, timers, x, state, found, factors, pieces)
      work%factors = work%factors + factors
      work%pieces = work%pieces + pieces
      if (.not. found) return
      call forces_left(problem, x, state, left)
      found = left <= tolerance
    end subroutine go_along

  end subroutine solve_springs

end module scree_friction_solver
