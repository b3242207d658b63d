!> Solution of a friction problem by what settles it where Newton's iteration runs in circles.
!>
!> The interior is quick, but may end at a fold of its way; the path goes round folds, one spring at a time, and is short from
!> there, and from near the solution. Where neither gets through, the interior is begun elsewhere and goes all of its way.
module scree_friction_solver
  use scree_friction_interior, only: solve_from_inside
  use scree_friction_path, only: follow_path
  use scree_friction_problem, only: forces_left, friction_problem_t
  use scree_kinds, only: dp
  use scree_timers, only: timers_t
  implicit none
  private
  public :: friction_work_t, solve_friction

  !> What a solution took.
  type :: friction_work_t
    integer :: factors = 0 !! of matrices
    integer :: pieces = 0  !! of paths
  end type friction_work_t

  !> What the interior begins with over the largest force, and the share of that which it is to leave, if not less than asked: at
  !> first so much that the path is shorter from there than the rest of the way inside.
  real(dp), parameter :: at_first(*) = [0.3_dp, 3.0_dp, 0.01_dp, 0.3_dp], &
                         to_leave(size(at_first)) = [1e-4_dp, 0.0_dp, 0.0_dp, 0.0_dp]
  !> Pieces that a path may cross, and one from near the solution.
  integer, parameter :: most_pieces = 600, most_near = 150

contains

  !> Solves a friction problem, to a share `tolerance` of the largest force.
  !>
  !> Near the solution, as of a problem that differs in few springs, the path is short and is tried first.
  subroutine solve_friction(problem, near, tolerance, timers, x, state, found, work, quick)
    type(friction_problem_t), intent(in) :: problem
    logical, intent(in) :: near                !! zero is near the solution
    real(dp), intent(in) :: tolerance
    type(timers_t), intent(inout) :: timers
    real(dp), allocatable, intent(out) :: x(:) !! (n); means nothing where none was found
    integer, intent(out) :: state(:)           !! (m) of the springs
    logical, intent(out) :: found
    type(friction_work_t), intent(out) :: work
    logical, intent(in), optional :: quick     !! only the first start inside is tried
    integer :: factors, i, n_starts

    if (near) then
      x = 0.0_dp*problem%force
      call go_along(most_near)
      if (found) return
    end if
    n_starts = size(at_first)
    if (present(quick)) n_starts = merge(1, n_starts, quick)
    do i = 1, n_starts
      x = 0.0_dp*problem%force
      call solve_from_inside(problem, at_first(i), max(tolerance, to_leave(i)), timers, x, state, found, factors)
      work%factors = work%factors + factors
      if (found .and. .not. to_leave(i) > tolerance) return
      call go_along(merge(most_near, most_pieces, found))
      if (found) return
    end do

  contains

    !> Follows the path from where x is.
    subroutine go_along(most)
      integer, intent(in) :: most !! pieces
      integer :: pieces
      real(dp) :: left

      call follow_path(problem, most, timers, x, state, found, factors, pieces)
      work%factors = work%factors + factors
      work%pieces = work%pieces + pieces
      if (.not. found) return
      call forces_left(problem, x, state, left)
      found = left <= tolerance
    end subroutine go_along

  end subroutine solve_friction

end module scree_friction_solver
