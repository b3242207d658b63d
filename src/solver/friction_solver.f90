!> Solution of a friction problem by what settles it where Newton's iteration runs in circles.
!>
!> The interior iteration is quick, but may end at a fold. The path follows folds, one spring at a time, and is short from near the
!> solution. It is tried from where the interior iteration has come close. If the path is too long, the interior iteration goes on
!> to its end, and then begins again with limits of shear that follow the pressing forces, and from other starts. If none of these
!> finds a solution, springs are brought together from apart. First these are the springs about the ones at which the path turned
!> back, and then all springs. The last method is sure to find a solution if one must exist.
module scree_friction_solver
  use scree_errors, only: error_t
  use scree_friction_interior, only: begin_inside, few_unknowns, go_inside, inside_t
  use scree_friction_path, only: bring_together, follow_path
  use scree_friction_problem, only: acts_on, closed_forces, forces_left, friction_problem_t, of_springs, unknowns_about
  use scree_kinds, only: dp
  use scree_linear_solver, only: factorise_beside, linear_solver_t, release_solver
  use scree_timers, only: timers_t
  implicit none
  private
  public :: friction_work_t, solve_friction

  !> Methods that a solution may use: all of them; the path from zero, if zero is near, and one interior iteration; only that path.
  integer, parameter, public :: effort_all = 0, effort_quick = 1, effort_path = 2

  !> What a solution took.
  type :: friction_work_t
    integer :: factors = 0 !! of matrices
    integer :: pieces = 0  !! of paths
  end type friction_work_t

  !> Settings of an interior iteration. If the iteration has a fold with some settings, it may have none with others.
  type :: way_t
    real(dp) :: at_first              !! first force of the iteration over the largest force
    logical :: limits_follow          !! limits of shear follow what presses
    real(dp) :: leaves(3)             !! residuals over the largest force at which the path is tried
    integer :: most_left(3)           !! pieces of each path; if they do not suffice, the iteration goes on
  end type way_t

  !> Ways that are tried, one after the other. That whose limits follow is slow where little is left.
  real(dp), parameter :: to_the_end(3) = [1e-4_dp, 1e-6_dp, 0.0_dp]
  integer, parameter :: fewer(3) = [40, 150, 0]
  type(way_t), parameter :: ways(*) = &
    [way_t(0.3_dp, .false., to_the_end, fewer), way_t(0.3_dp, .true., [1e-2_dp, 1e-3_dp, 1e-5_dp], [300, 300, 300]), &
     way_t(0.03_dp, .false., to_the_end, fewer), way_t(3e-3_dp, .false., to_the_end, fewer), &
     way_t(3e-4_dp, .false., to_the_end, fewer)]
  !> Near the solution the first way begins with no more than so many times what is left there.
  real(dp), parameter :: times_left = 100.0_dp
  !> Gap over the largest overlap up to which springs are taken at first, and near the solution, where bodies go farther than they
  !> overlap; and times that some are taken in: the last time all.
  real(dp), parameter :: reach = 1.0_dp, reach_near = 8.0_dp
  integer, parameter :: most_additions = 5
  !> Pieces that a path from near the solution may cross, and one from where rounding left that from apart.
  integer, parameter :: most_near = 300, most_pieces = 600
  !> Times that springs at which the path turned back, or more about them, are taken apart.
  integer, parameter :: most_loosened = 8
  !> Pieces of the path from apart for each spring, where there must be a solution and where there may be none. Those that came to
  !> one took 1 to 3, and up to 21.
  integer, parameter :: most_together = 30, few_together = 4
  !> Pieces of it, and of those times unknowns: they take seconds, and a step in two parts is cheaper.
  integer, parameter :: most_in_all = 20000, most_by_unknowns = 80000000

contains

  !> Solves a friction problem to a residual below `tolerance` times the largest force.
  !>
  !> Springs that are far open are left out, which keeps the factors small. Springs left out that would press in the solution are
  !> added, and the problem is solved again from there. If the solution is near, as for a problem that differs in few springs, the
  !> path is short and is tried first.
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
  recursive subroutine solve_springs(problem, near, tolerance, effort, timers, x, state, found, work)
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
    logical :: turned(size(state))             ! springs at which the last path turned back
    real(dp) :: nearest(size(x)), least        ! where the interior left least, and that
    type(way_t) :: way
    integer :: k

    found = .false.
    nearest = x
    least = huge(least)
    way = ways(1)
    if (near) then
      call forces_left(problem, x, state, way%at_first)
      way%at_first = min(ways(1)%at_first, times_left*max(tolerance, way%at_first))
      call go_along(most_near, .false.)
    end if
    do k = 1, merge(size(ways), 1, effort == effort_all)
      if (found .or. effort == effort_path) exit
      if (k > 1) way = ways(k)
      if (way%limits_follow .and. size(x) <= few_unknowns) cycle ! the others get there in fewer matrices
      call go_through(way)
    end do
    if (effort == effort_all) then
      if (.not. found) call loosen_folds()
      if (.not. found) then
        sure = must_be_solved()
        call come_together(refined=.false.)
        if (sure .and. .not. found) call come_together(refined=.true.)
      end if
    end if
    call release_solver(solver)

  contains

    !> Goes through the interior, and from near its end along the path.
    subroutine go_through(way)
      type(way_t), intent(in) :: way
      real(dp) :: left
      integer :: k

      call begin_inside(problem, way%at_first, way%limits_follow, 0.0_dp*problem%force, inside)
      do k = 1, size(way%leaves)
        call go_inside(problem, max(tolerance, way%leaves(k)), solver, timers, inside, state, found)
        x = inside%x
        if (way%leaves(k) <= tolerance .or. .not. found) exit
        call go_along(way%most_left(k), .false.)
        if (found) exit
      end do
      work%factors = work%factors + inside%factors
      if (found) return
      call forces_left(problem, inside%x, state, left)
      if (left < least) nearest = inside%x
      least = min(least, left)
    end subroutine go_through

    !> Takes apart the springs at which the path from where the interior left least turns back, and those of their bodies, settles
    !> the others, and brings these together. Where the others turn back elsewhere, those are taken apart, too; else more about.
    subroutine loosen_folds()
      logical :: about(size(state)), folds(size(state)), is_apart(size(state)), settled
      integer :: i, reach

      x = nearest
      call go_along(most_pieces, .true.)
      if (found) return
      about = turned
      reach = 0
      do i = 1, most_loosened
        is_apart = acts_on(problem, unknowns_about(problem, about, reach)) .and. .not. problem%spring%bonded
        if (.not. any(is_apart) .or. all(is_apart)) return
        call settle_others(is_apart, settled, folds)
        if (settled) then
          call come_from_apart(is_apart, most_together*count(is_apart), refined=.false.)
          if (found) return
        end if
        if (settled .or. all(about .or. .not. folds)) reach = reach + 1
        about = about .or. folds
      end do
    end subroutine loosen_folds

    !> Settles springs but those that are apart, from where the interior left least, and tells at which the path turned back.
    subroutine settle_others(is_apart, settled, folds)
      logical, intent(in) :: is_apart(:)       !! (m)
      logical, intent(out) :: settled, folds(:) !! (m)
      type(friction_problem_t) :: few
      type(linear_solver_t) :: own
      integer :: factors, i, pieces
      integer, allocatable :: others(:), their_state(:)
      logical, allocatable :: theirs(:)

      others = pack([(i, i=1, size(state))], .not. is_apart)
      allocate (their_state(size(others)), theirs(size(others)))
      few = of_springs(problem, others)
      x = nearest
      call follow_path(few, most_pieces, .true., own, timers, x, their_state, settled, factors, pieces, theirs)
      call release_solver(own)
      work%factors = work%factors + factors
      work%pieces = work%pieces + pieces
      folds = unpack(theirs, .not. is_apart, .false.)
      if (.not. settled) &
        call solve_springs(few, .false., tolerance, effort_quick, timers, x, their_state, settled, work)
    end subroutine settle_others

    !> Follows the path from where x is.
    subroutine go_along(most, patient)
      integer, intent(in) :: most    !! pieces
      logical, intent(in) :: patient !! it may wander
      integer :: factors, pieces

      call follow_path(problem, most, patient, solver, timers, x, state, found, factors, pieces, turned)
      call judge_path(factors, pieces)
    end subroutine go_along

    !> Whether the problem must have a solution.
    logical function must_be_solved() result(must)
      type(error_t), allocatable :: error

      must = problem%symmetric .and. problem%matrix%symmetric
      if (must) call factorise_beside(solver, problem%matrix, timers, must, error)
    end function must_be_solved

    !> Follows the path of all springs from apart, and from its end, where rounding has come in, the one from there.
    subroutine come_together(refined)
      logical, intent(in) :: refined !! the directions are
      integer :: most
      logical :: ended

      x = 0.0_dp
      most = min(most_in_all, most_by_unknowns/size(x), merge(most_together, few_together, sure)*size(state))
      call come_from_apart(spread(.true., 1, size(state)), most, refined, ended)
      if (ended .and. .not. found) call go_along(most_pieces, .true.)
    end subroutine come_together

    !> Follows the path of some springs from apart.
    subroutine come_from_apart(is_apart, most, refined, ended)
      logical, intent(in) :: is_apart(:)       !! (m)
      integer, intent(in) :: most              !! pieces
      logical, intent(in) :: refined           !! the directions are
      logical, intent(out), optional :: ended  !! it came to its end, if not to the solution
      integer :: factors, pieces

      call bring_together(problem, is_apart, most, refined, solver, timers, x, state, found, factors, pieces)
      if (present(ended)) ended = found
      call judge_path(factors, pieces)
    end subroutine come_from_apart

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
