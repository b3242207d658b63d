!> Solution of a friction problem by what settles it where Newton's iteration runs in circles.
!>
!> The interior is quick, but may end at a fold of its way; the path goes round folds, one spring at a time, and is short from
!> there, and from near the solution. Where it is not, the way inside goes on to its end. Where neither gets through all springs are
!> brought together from apart, which is sure where there must be a solution.
module scree_friction_solver
  use scree_errors, only: error_t
  use scree_friction_interior, only: begin_inside, go_inside, inside_t
  use scree_friction_path, only: bring_together, follow_path
  use scree_friction_problem, only: closed_forces, forces_left, friction_problem_t, of_springs
  use scree_kinds, only: dp
  use scree_linear_solver, only: factorise_beside, linear_solver_t, release_solver
  use scree_timers, only: timers_t
  implicit none
  private
  public :: friction_work_t, solve_friction

  !> What a solution may take: all that there is; only the path from zero, where that is near, and the way inside; only that path.
  integer, parameter, public :: effort_all = 0, effort_quick = 1, effort_path = 2

  !> What a solution took.
  type :: friction_work_t
    integer :: factors = 0 !! of matrices
    integer :: pieces = 0  !! of paths
  end type friction_work_t

  !> What the interior begins with over the largest force.
  real(dp), parameter :: at_first = 0.3_dp
  !> Shares of the largest force that it leaves before the path is tried from there, and pieces that may cost no more than the rest
  !> of the way inside does, which goes on where they do not do.
  real(dp), parameter :: leaves(*) = [1e-4_dp, 1e-6_dp, 0.0_dp]
  integer, parameter :: most_left(size(leaves)) = [40, 150, 0]
  !> Gap over the largest overlap up to which springs are taken at first, and near the solution, where bodies go farther than they
  !> overlap; and times that some are taken in: the last time all.
  real(dp), parameter :: reach = 1.0_dp, reach_near = 8.0_dp
  integer, parameter :: most_additions = 5
  !> Pieces that a path from near the solution may cross, and one from where rounding left that from apart.
  integer, parameter :: most_near = 300, most_pieces = 600
  !> Pieces of the path from apart for each spring, where there must be a solution and where there may be none. Those that came to
  !> one took 1 to 3, and up to 21.
  integer, parameter :: most_together = 30, few_together = 4

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
    logical :: sure                            ! there is a solution

    found = .false.
    if (near) call go_along(most_near, .false.)
    if (.not. found .and. effort /= effort_path) call go_through()
    if (.not. found .and. effort == effort_all) then
      sure = must_be_solved()
      call come_together(refined=.false.)
      if (sure .and. .not. found) call come_together(refined=.true.)
    end if
    call release_solver(solver)

  contains

    !> Goes through the interior, and from near its end along the path.
    subroutine go_through()
      integer :: k

      call begin_inside(problem, at_first, 0.0_dp*problem%force, inside)
      do k = 1, size(leaves)
        call go_inside(problem, max(tolerance, leaves(k)), solver, timers, inside, state, found)
        x = inside%x
        if (leaves(k) <= tolerance .or. .not. found) exit
        call go_along(most_left(k), .false.)
        if (found) exit
      end do
      work%factors = work%factors + inside%factors
    end subroutine go_through

    !> Follows the path from where x is.
    subroutine go_along(most, patient)
      integer, intent(in) :: most    !! pieces
      logical, intent(in) :: patient !! it may wander
      integer :: factors, pieces

      call follow_path(problem, most, patient, solver, timers, x, state, found, factors, pieces)
      call judge_path(factors, pieces)
    end subroutine go_along

    !> Whether the problem must have a solution.
    logical function must_be_solved() result(must)
      type(error_t), allocatable :: error

      must = problem%symmetric .and. problem%matrix%symmetric
      if (must) call factorise_beside(solver, problem%matrix, timers, must, error)
    end function must_be_solved

    !> Follows the path from apart, and from its end, where rounding has come in, the one from there.
    subroutine come_together(refined)
      logical, intent(in) :: refined !! the directions are
      integer :: factors, most, pieces
      logical :: ended

      most = merge(most_together, few_together, sure)*size(state)
      call bring_together(problem, most, refined, solver, timers, x, state, ended, factors, pieces)
      found = ended
      call judge_path(factors, pieces)
      if (ended .and. .not. found) call go_along(most_pieces, .true.)
    end subroutine come_together

    !> Counts what a path took, and tells whether its end is a solution.
    subroutine judge_path(factors, pieces)
      integer, intent(in) :: factors, pieces
      real(dp) :: left

      work%factors = work%factors + factors
      work%pieces = work%pieces + pieces
      if (.not. found) return
      call forces_left(problem, x, state, left)
      found = left <= tolerance
    end subroutine judge_path

  end subroutine solve_springs

end module scree_friction_solver
