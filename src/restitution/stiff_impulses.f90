!> Impulses that sweeps do not come to: those of stiff springs in place of hard contacts.
!>
!> The velocities y of the bodies are scaled so that their mass is one. Springs press with p times the approach of their contact, in
!> addition to the impulses so far, the multipliers. The spring forces are added to the multipliers, and the problem is solved again
!> with stiffer springs. Each round divides the remaining approach by 1 + p times the softest response of the bodies to unit
!> impulses. Three rounds suffice for a pile of 300 bodies, for which sweeps take 100 000. Springs with friction are a friction
!> problem. Its matrix is definite and its forces act along the rows of changes, so it has a solution, and the solver finds this
!> solution (doc/theory/impacts.md, eq-stiff-impulses).
module scree_stiff_impulses
  use scree_friction_problem, only: add_spring_force, closed_forces, friction_problem_t, keep_rows_of_forces, obey_law, &
                                    place_springs
  use scree_friction_solver, only: effort_all, effort_quick, friction_work_t, solve_friction
  use scree_impulse_problem, only: apply, impulse_problem_t, impulses_t, takes_no_part, velocity_at
  use scree_kinds, only: dp
  use scree_sparse_matrix, only: build_pattern
  use scree_timers, only: timers_t
  implicit none
  private
  public :: press_by_springs

  !> Velocity with which a spring responds to its own approach, over this approach: in the first round; at most, as rounding grows
  !> with it; and the factor from round to round. Springs that are stiff at once have longer paths.
  real(dp), parameter :: first_stiffness = 1e3_dp, most_stiffness = 1e8_dp, stiffer = 100.0_dp
  !> Residual of a solution over the largest impulse. Approach that may remain over the fastest approach, and the same if stiffer
  !> springs find no solution. Ratio of remaining approaches of two rounds, above which another round does not help. Number of
  !> rounds.
  real(dp), parameter :: tolerance = 1e-7_dp, enough = 1e-10_dp, good = 1e-6_dp, shrinking = 0.5_dp
  integer, parameter :: most_rounds = 10
  !> Number of contacts up to which a solution may use all methods of the friction solver.
  integer, parameter :: few_contacts = 200
  !> A velocity of a body is held if its remaining mobility is below this ratio to the initial mobility.
  real(dp), parameter :: narrow = 1e-10_dp

contains

  !> Brings impulses to the laws of their contacts, and tells how fast these still approach: huge where there is no solution that
  !> they could be told by.
  subroutine press_by_springs(problem, floor, resistance, fastest, impulses, left)
    type(impulse_problem_t), intent(in) :: problem
    real(dp), intent(in) :: floor(:)             !! (n) least impulse across, force time
    real(dp), intent(in) :: resistance(:, :)     !! (2, n) velocity that a unit of impulse makes
    real(dp), intent(in) :: fastest              !! approach, length/time
    type(impulses_t), intent(inout) :: impulses
    real(dp), intent(out) :: left                !! of approaches, length/time
    type(friction_problem_t) :: springs
    type(friction_work_t) :: work
    type(timers_t) :: timers                     ! of its own: what it takes is the impact's
    real(dp), allocatable :: force(:, :), y(:)
    real(dp) :: before                           ! what was left by the round before, length/time
    real(dp) :: stiffness, highest
    logical :: solved
    integer, allocatable :: contact(:), state(:)
    integer :: effort, i, round

    contact = springs_of(problem, floor, resistance)
    left = huge(left)
    if (size(contact) == 0) return
    call place(problem, contact, springs)
    force = forces_so_far(problem, contact, floor, impulses%P, springs)
    allocate (state(size(contact)))
    effort = merge(effort_all, effort_quick, size(contact) <= few_contacts)
    stiffness = first_stiffness
    highest = most_stiffness
    do round = 1, most_rounds
      call set_springs(problem, contact, floor, resistance, impulses%motion, force, stiffness, springs)
      call solve_friction(springs, .true., tolerance, timers, y, state, solved, work, effort)
      if (.not. solved) then ! it is too stiff for that
        if (left <= good*fastest) exit
        highest = stiffness/stiffer
        stiffness = highest
        cycle
      end if
      before = left
      left = 0.0_dp
      do i = 1, size(contact)
        call take(i)
      end do
      if (left <= enough*fastest) exit
      if (left <= good*fastest .and. highest < most_stiffness) exit
      if (left > shrinking*before .and. .not. stiffness < highest) exit
      stiffness = min(highest, stiffer*stiffness)
    end do

  contains

    !> Takes the force of spring i over.
    subroutine take(i)
      integer, intent(in) :: i
      real(dp) :: own(2), change(2)

      call obey_law(springs%spring(i), closed_forces(springs, i, y), state(i), own)
      if (springs%spring(i)%bonded) own(1) = 0.0_dp
      change = own - force(:, i)
      force(:, i) = own
      associate (c => contact(i))
        impulses%P(:, c) = impulses%P(:, c) + change
        call apply(problem, c, change, impulses%motion)
        left = max(left, maxval(resistance(:, c)*abs(change))/stiffness)
      end associate
    end subroutine take

  end subroutine press_by_springs

  !> The contact of each spring: one for what may press, and another for the friction of what presses at least, where there is any.
  pure function springs_of(problem, floor, resistance) result(contact)
    type(impulse_problem_t), intent(in) :: problem
    real(dp), intent(in) :: floor(:)             !! (n) force time
    real(dp), intent(in) :: resistance(:, :)     !! (2, n)
    integer, allocatable :: contact(:)
    integer :: i

    contact = pack([(i, i=1, size(floor))], resistance(1, :) > 0 .and. problem%least > takes_no_part)
    contact = [contact, pack(contact, problem%friction(contact)*floor(contact) > 0)]
  end function springs_of

  !> Places the springs between the bodies that move.
  pure subroutine place(problem, contact, springs)
    type(impulse_problem_t), intent(in) :: problem
    integer, intent(in) :: contact(:)
    type(friction_problem_t), intent(out) :: springs
    real(dp) :: root(3, 3, size(problem%mobility, 3))
    integer :: before(size(problem%mobility, 3)) !! unknowns before those of a body
    logical :: meets(size(before)), presses(size(problem%friction)) !! bodies; contacts that have the first of their springs
    integer, allocatable :: rows(:, :)
    integer :: b, i, k, n, side

    meets = .false.
    do i = 1, size(contact)
      meets(problem%body(:, contact(i))) = .true.
    end do
    n = 0
    do b = 1, size(before)
      root(:, :, b) = root_of(problem%mobility(:, :, b))
      before(b) = n
      if (meets(b) .and. any(abs(root(:, :, b)) > 0)) n = n + 3
      if (n == before(b)) before(b) = -1
    end do
    call place_springs(springs, size(contact), 6)
    allocate (rows(6, size(contact)), source=0)
    springs%length = 0
    presses = .false.
    do i = 1, size(contact)
      associate (c => contact(i), w => springs%length(i), spring => springs%spring(i))
        spring%slot = i
        spring%bonded = presses(c)
        if (.not. presses(c)) spring%friction = problem%friction(c)
        presses(c) = .true.
        do side = 1, 2
          b = problem%body(side, c)
          if (before(b) < 0) cycle
          do k = 1, 3
            w = w + 1
            rows(w, i) = before(b) + k
            springs%row(w, i) = before(b) + k
            if (.not. spring%bonded) springs%normal(w, i) = dot_product(root(:, k, b), problem%row(:, side, 1, c))
            springs%shear(w, i) = dot_product(root(:, k, b), problem%row(:, side, 2, c))
          end do
        end do
      end associate
    end do
    call keep_rows_of_forces(springs)
    call build_pattern(n, rows, springs%matrix)
    springs%matrix%value(springs%matrix%on_diagonal) = 1.0_dp
    allocate (springs%force(n), springs%span(n), source=0.0_dp)
    do i = 1, size(contact)
      do k = 1, springs%length(i)
        associate (span => springs%span(springs%row(k, i)))
          span = max(span, abs(springs%normal(k, i)), abs(springs%shear(k, i)))
        end associate
      end do
    end do
    where (.not. springs%span > 0) springs%span = 1.0_dp
  end subroutine place

  !> A matrix B whose product with its transpose is a mobility.
  pure function root_of(mobility) result(B)
    real(dp), intent(in) :: mobility(3, 3)
    real(dp) :: B(3, 3), left(3, 3)
    integer :: j, k

    left = mobility
    B = 0.0_dp
    do k = 1, 3
      if (.not. left(k, k) > narrow*mobility(k, k)) cycle
      B(:, k) = left(:, k)/sqrt(left(k, k))
      do j = 1, 3
        left(:, j) = left(:, j) - B(:, k)*B(j, k)
      end do
    end do
  end function root_of

  !> Forces of the springs by the impulses so far: of shear what friction of the first has not goes to the second.
  pure function forces_so_far(problem, contact, floor, P, springs) result(force)
    type(impulse_problem_t), intent(in) :: problem
    integer, intent(in) :: contact(:)
    real(dp), intent(in) :: floor(:), P(:, :)    !! (n), (2, n)
    type(friction_problem_t), intent(in) :: springs
    real(dp) :: force(2, size(contact)), limit, shear(size(floor))
    integer :: i

    force = 0.0_dp
    do i = 1, size(contact)
      associate (c => contact(i))
        if (springs%spring(i)%bonded) then
          force(2, i) = P(2, c) - shear(c)
        else
          limit = problem%friction(c)*max(0.0_dp, P(1, c) - floor(c))
          force(:, i) = [P(1, c) - floor(c), max(-limit, min(limit, P(2, c)))]
          shear(c) = force(2, i)
        end if
      end associate
    end do
  end function forces_so_far

  !> Sets springs that have their forces so far, but for what contacts approach and slide by, in a motion.
  pure subroutine set_springs(problem, contact, floor, resistance, motion, force, stiffness, springs)
    type(impulse_problem_t), intent(in) :: problem
    integer, intent(in) :: contact(:)
    real(dp), intent(in) :: floor(:)             !! (n)
    real(dp), intent(in) :: resistance(:, :)     !! (2, n)
    real(dp), intent(in) :: motion(:, :)         !! (3, n_bodies)
    real(dp), intent(in) :: force(:, :)          !! (2, size(contact))
    real(dp), intent(in) :: stiffness            !! over what the bodies of each answer with
    type(friction_problem_t), intent(inout) :: springs
    real(dp) :: out_of_balance(size(springs%force)), velocity(2)
    integer :: i

    out_of_balance = 0.0_dp
    do i = 1, size(contact)
      velocity = velocity_at(problem, motion, contact(i))
      associate (spring => springs%spring(i), c => contact(i))
        spring%stiffness = stiffness/resistance(1, c)
        spring%shear_stiffness = stiffness/max(resistance(2, c), sqrt(tiny(1.0_dp)))
        spring%shear = force(2, i) - spring%shear_stiffness*velocity(2)
        if (spring%bonded) then
          spring%cohesion = problem%friction(c)*floor(c)
        else
          spring%pressing = force(1, i) - spring%stiffness*(velocity(1) - problem%least(c))
        end if
      end associate
      call add_spring_force(springs, i, -force(:, i), out_of_balance)
    end do
    springs%force = out_of_balance
  end subroutine set_springs

end module scree_stiff_impulses
