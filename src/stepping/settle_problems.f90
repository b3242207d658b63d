!> Contacts that the iteration of a step cannot settle, settled as friction problems (doc/theory/open-close.md,
!> eq-friction-problem).
!>
!> A problem has the lines, anchors and bonds that contacts have where it is posed. Where forces bend, or lines change, what it ends
!> in is judged, and another one follows: a round.
module scree_settle_problems
  use scree_contact_blame, only: reject_contacts
  use scree_contact_problem, only: pose_problem, take_states
  use scree_contact_rules, only: place
  use scree_contact_try, only: contact_try_t
  use scree_equations, only: move_island
  use scree_flickering, only: may_part, note_changes, note_part
  use scree_friction_part, only: solve_about
  use scree_friction_problem, only: friction_problem_t, keep_rows_of_forces, posed_problem_t
  use scree_friction_solver, only: effort_all, effort_path, effort_quick, friction_work_t, solve_friction
  use scree_iteration, only: element_group_t
  use scree_iteration_end, only: check_areas
  use scree_interruption, only: stop_signal
  use scree_joint_rules, only: joints_soften
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_open_close, only: judge_contacts, keep_lines
  use scree_scene, only: problems_all, problems_none
  use scree_settle_group, only: accepted_share, add_elements, begin_round, choose_operator, count_stalled, find_change, &
                                values_of_members
  use scree_state, only: state_t
  use scree_step_try, only: try_t
  use scree_timers, only: begin_phase, phase_assemble, phase_friction, phase_judge
  implicit none
  private
  public :: judge_at, settle_circles, settle_stalled

  !> Friction problems in a step, after which entrances and anchors stay; and at most.
  integer, parameter :: free_rounds = 3, most_rounds = 60
  !> Friction problems in a step that follow each other at once, where forces bend.
  integer, parameter :: prompt_rounds = 40
  !> Friction problems in a step that the secant poses: those that led anywhere took 12 at most, others 50.
  integer, parameter :: most_by_secant = 15
  !> Rounds that take half of a correction where forces are nonlinear: from the first of these on, those whose remainder by five is
  !> one of the others. Tangents may run in circles, which a half step breaks. The rounds are not evenly spaced, as circles are.
  integer, parameter :: first_half = 5, half_of_five(2) = [0, 3]
  !> Times that the way to the answer of a problem is halved where an area runs away with it.
  integer, parameter :: most_halvings = 5
  !> Contacts that a judgement changes, fewer than which the path from there to the solution is likely to be short.
  integer, parameter :: few_changes = 75
  !> Forces that a friction problem leaves out of balance, over the largest: a body may have forces of its own that are far smaller.
  !> One that moves nothing, and leaves too much on a body, is solved ten times as exactly the next time, so many times.
  real(dp), parameter :: problem_share = 0.1_dp*accepted_share
  integer, parameter :: most_repeats = 3

  !> How a friction problem is posed and solved.
  type :: attempt_t
    integer :: effort = effort_all      !! that it may take
    logical :: by_secant = .false.      !! and by the rows of forces; else by the operator of the iteration
    logical :: of_part = .false.        !! of the contacts that go on changing; else of all
  end type attempt_t

  !> What a friction problem of a group came to.
  type :: answer_t
    logical :: found = .false.
    real(dp), allocatable :: x(:)       !! correction of the island
    integer, allocatable :: state(:)    !! of its contacts, as springs of the problem
  end type answer_t

contains

  !> Goes on where a judgement has changed contacts: with constant pulls of bonds that soften, or with a friction problem, where the
  !> iteration runs in circles or would.
  subroutine settle_circles(model, cache, state, before, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    integer, intent(in) :: before(:, :)           !! (2, n_contacts) states of their entrances before the judgement
    type(try_t), intent(inout) :: try

    if (joints_soften(try%contacts%law) .and. try%contacts%pulls_fall) then
      call level_pulls(model, cache, state, try)
    else
      call settle_as_problem(model, cache, state, before, try)
    end if
  end subroutine settle_circles

  !> Settles contacts that a judgement has changed as a friction problem, where the iteration runs in circles or would.
  subroutine settle_as_problem(model, cache, state, before, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    integer, intent(in) :: before(:, :)           !! (2, n_contacts) states of their entrances before the judgement
    type(try_t), intent(inout) :: try
    logical :: apart, by_newton, done, prompt, stalls

    associate (group => try%group, iteration => try%iteration)
      prompt = may_follow(try) ! whatever has changed
      call note_changes(before, try%contacts, iteration%flickering, apart)
      call count_stalled(model, try)
      stalls = iteration%stalled > group%open_close%most_stalled
      by_newton = group%open_close%settles_always .and. (group%linear .or. .not. iteration%after_problem)
      apart = by_newton .and. (apart .or. stalls) .and. may_part(iteration%flickering, size(group%member))
      if (apart) call settle_part(model, cache, state, try, apart)
      if (apart) return
      if (by_newton .and. (stalls .or. iteration%stalled == 1) &
          .and. iteration%fewest_changes < min(iteration%fewest_tried, few_changes)) then
        call settle_near(model, cache, state, try, done)
        if (done) return
      end if
    end associate
    if (.not. (stalls .or. prompt)) return
    call reject_contacts(model, state, before, try)
    call settle_stalled(model, cache, state, try)
  end subroutine settle_as_problem

  !> Lets the pull of bonds that soften be constant where the iteration runs in circles, and begins it anew. A friction problem has
  !> no springs that pull less as they open.
  subroutine level_pulls(model, cache, state, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(inout) :: try

    call count_stalled(model, try)
    if (try%iteration%stalled <= try%group%open_close%most_stalled) return
    try%contacts%pulls_fall = .false.
    call begin_round(try%iteration)
    call judge_at(model, cache, state, try)
  end subroutine level_pulls

  !> Settles contacts as a friction problem from where a judgement changed fewest of them: along the path alone, which is short
  !> where that was near the solution. Where it does not get there all stays as it was.
  subroutine settle_near(model, cache, state, try, done)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(inout) :: try             !! near the solution where that was found
    logical, intent(out) :: done                  !! it was found
    type(answer_t) :: answer
    type(contact_try_t) :: contacts_before
    integer :: rounds
    real(dp), allocatable :: d_before(:)

    rounds = try%iteration%rounds
    try%iteration%fewest_tried = try%iteration%fewest_changes
    call begin_phase(cache%timers, phase_judge)
    d_before = try%d
    contacts_before = try%contacts
    call put_members(model, try%group, try%iteration%best, try%d)
    call judge_at(model, cache, state, try)
    call solve_as_problem(model, cache, state, attempt_t(effort_path), try, answer)
    if (answer%found) call settle_rounds(model, cache, state, try, answer)
    done = try%iteration%rounds > rounds
    if (done) return
    if (allocated(try%outcome%trouble%what)) deallocate (try%outcome%trouble%what)
    try%d = d_before
    try%contacts = contacts_before
  end subroutine settle_near

  !> Settles contacts that run in circles as a friction problem, at the entrances, anchors and bonds that they have where the last
  !> such round ended or the step began. Where it may not, or that fails, the trouble of the outcome stays.
  subroutine settle_stalled(model, cache, state, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(inout) :: try
    type(answer_t) :: answer
    integer :: effort

    associate (rules => try%group%open_close)
      if (.not. (try%group%in_contact .and. rules%settles_always .and. try%iteration%rounds < most_rounds)) return
      if (try%outcome%solves > try%most_solves) return
      effort = merge(effort_quick, effort_all, rules%linear_springs)
    end associate
    call begin_phase(cache%timers, phase_judge)
    call put_members(model, try%group, try%iteration%start_of_round, try%d)
    try%contacts%pulls_fall = .false.
    call judge_at(model, cache, state, try)
    call solve_as_problem(model, cache, state, attempt_t(effort), try, answer)
    if (.not. (answer%found .or. try%group%linear) .and. try%iteration%by_secant < most_by_secant) then
      call solve_as_problem(model, cache, state, attempt_t(effort_all, by_secant=.true.), try, answer)
      try%iteration%by_secant = try%iteration%by_secant + 1
    end if
    if (answer%found) call settle_rounds(model, cache, state, try, answer)
  end subroutine settle_stalled

  !> Takes the answer to a friction problem, and to those that follow it at once where forces bend, as long as where one ends other
  !> contacts are judged to act.
  subroutine settle_rounds(model, cache, state, try, answer)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(inout) :: try
    type(answer_t), intent(inout) :: answer

    do
      call take_answer(model, cache, state, try, answer)
      if (allocated(try%outcome%trouble%what)) return
      if (.not. (try%contacts%changes > 0 .and. may_follow(try))) return
      call solve_as_problem(model, cache, state, attempt_t(effort_path), try, answer)
      if (.not. answer%found) return
    end do
  end subroutine settle_rounds

  !> Whether another friction problem may follow at once where one of the step ended: where forces bend and they are not too many.
  pure logical function may_follow(try)
    type(try_t), intent(in) :: try

    may_follow = try%iteration%after_problem .and. try%group%open_close%linear_springs .and. try%iteration%rounds < prompt_rounds
  end function may_follow

  !> Takes the answer to a friction problem that was posed where the try is, from which the iteration goes on, or as much of the way
  !> there as areas allow. Where one runs away even so the outcome has a trouble.
  subroutine take_answer(model, cache, state, try, answer)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(inout) :: try
    type(answer_t), intent(inout) :: answer
    real(dp) :: change
    integer :: i, worst

    try%iteration%reference = values_of_members(model, try)
    call take_states(answer%state, try%contacts)
    if (goes_half(try%iteration%rounds) .and. .not. try%group%linear) answer%x = 0.5_dp*answer%x
    call move_island(cache%equations, try%group%number, answer%x, try%d)
    do i = 0, most_halvings
      try%outcome%settled = .true.
      if (allocated(try%outcome%trouble%what)) deallocate (try%outcome%trouble%what) ! of the circles that led here
      call check_areas(model, cache, try, of_iterate=.false.)
      if (try%outcome%settled .or. try%group%linear) exit
      answer%x = 0.5_dp*answer%x
      call move_island(cache%equations, try%group%number, -answer%x, try%d)
    end do
    if (.not. try%outcome%settled) return
    call find_change(model, cache, try, change, worst)
    if (try%group%open_close%linear_springs) call choose_operator(model, change, try)
    associate (iteration => try%iteration)
      iteration%start_of_round = values_of_members(model, try)
      iteration%after_problem = .true.
      iteration%likely_to_change = .false.
      iteration%rounds = iteration%rounds + 1
      if (iteration%rounds == free_rounds) call keep_lines(try%contacts)
      call begin_round(iteration)
      iteration%in_doubt = try%group%linear .or. change < model%settings%tolerance
      if (change < model%settings%tolerance) iteration%repeats = min(iteration%repeats + 1, most_repeats)
    end associate
    call judge_at(model, cache, state, try)
    try%outcome%settled = .false.
  end subroutine take_answer

  !> Whether of the answer that follows so many rounds half of the way is gone.
  pure logical function goes_half(rounds)
    integer, intent(in) :: rounds

    goes_half = rounds >= first_half .and. any(half_of_five == modulo(rounds, 5))
  end function goes_half

  !> Settles the contacts that go on changing as the friction problem of what is about them, where that is few.
  subroutine settle_part(model, cache, state, try, done)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(inout) :: try
    logical, intent(out) :: done
    type(answer_t) :: answer

    call solve_as_problem(model, cache, state, attempt_t(effort_quick, of_part=.true.), try, answer)
    if (.not. (answer%found .or. try%group%linear)) &
      call solve_as_problem(model, cache, state, attempt_t(effort_quick, by_secant=.true., of_part=.true.), try, answer)
    done = answer%found
    call note_part(done, try%iteration%flickering)
    if (.not. done) return
    call take_states(answer%state, try%contacts)
    call move_island(cache%equations, try%group%number, answer%x, try%d)
    call begin_round(try%iteration)
    call judge_at(model, cache, state, try)
  end subroutine settle_part

  !> Poses the contacts where the try is as a friction problem, and solves it; or its part about the contacts that go on changing,
  !> where that is small.
  !>
  !> With Green strain stress turns with its element, so elements under pressure may have a tangent that is not definite. The rows
  !> of forces of contacts may differ from those of their changes. Then there may be no solution. The secant leaves out the turn of
  !> stress. With it, and with the rows of forces alone, there is a solution (doc/theory/open-close.md, eq-existence), from which
  !> the iteration goes on.
  subroutine solve_as_problem(model, cache, state, attempt, try, answer)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(attempt_t), intent(in) :: attempt
    type(try_t), intent(inout) :: try
    type(answer_t), intent(out) :: answer
    type(friction_problem_t) :: problem, whole
    type(friction_work_t) :: work
    logical :: near

    call begin_phase(cache%timers, phase_assemble)
    call add_elements(model, cache, state, try, attempt%by_secant)
    call pose_problem(model, try%contacts, try%group%number, try%d, cache%equations, problem)
    if (attempt%by_secant) call keep_rows_of_forces(problem)
    near = try%iteration%after_problem .or. attempt%effort == effort_path
    allocate (answer%state(size(problem%spring)))
    if (attempt%of_part) then
      associate (flickering => try%iteration%flickering)
        near = near .or. flickering%parts > 0
        whole = problem
        call solve_about(whole, flickering%contact, flickering%reach, near, accepted_share, cache%timers, problem, answer%x, &
                         answer%state, answer%found, work)
      end associate
    else
      call begin_phase(cache%timers, phase_friction)
      call solve_friction(problem, near, problem_share*0.1_dp**try%iteration%repeats, cache%timers, answer%x, answer%state, &
                          answer%found, work, attempt%effort)
    end if
    if (.not. allocated(problem%force)) return
    try%outcome%solves = try%outcome%solves + work%factors
    if (.not. answer%found .and. stop_signal() > 0) try%outcome%left = .true.
    if (is_kept(model%settings%problems, answer%found .or. attempt%effort == effort_path)) &
      call keep_posed(problem, near, answer%found, cache)
  end subroutine solve_as_problem

  !> Whether a friction problem is to be written: those that were not solved, but by a path alone, or all.
  pure logical function is_kept(problems, done)
    integer, intent(in) :: problems
    logical, intent(in) :: done

    is_kept = problems == problems_all .or. (problems /= problems_none .and. .not. done)
  end function is_kept

  !> Keeps a friction problem that is to be written.
  pure subroutine keep_posed(problem, near, found, cache)
    type(friction_problem_t), intent(in) :: problem
    logical, intent(in) :: near, found       !! zero is near the solution; there is one
    type(cache_t), intent(inout) :: cache

    if (.not. allocated(cache%posed)) allocate (cache%posed(0))
    cache%posed = [cache%posed, posed_problem_t(problem, near, found)]
  end subroutine keep_posed

  !> Takes the members of a group to their displacements.
  pure subroutine put_members(model, group, values, d)
    type(model_t), intent(in) :: model
    type(element_group_t), intent(in) :: group
    real(dp), intent(in) :: values(:, :)          !! (n, n_members)
    real(dp), intent(inout) :: d(:)               !! (n_unknowns)
    integer :: k

    do k = 1, size(group%member)
      d(model%elements%unknown(:, group%member(k))) = values(:, k)
    end do
  end subroutine put_members

  !> Judges the contacts where the try is, placed there where they may be.
  subroutine judge_at(model, cache, state, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(inout) :: try

    if (.not. (try%group%linear .or. try%iteration%linearisation%frozen)) call place(model, cache, state, try%d, try%contacts)
    call judge_contacts(model, try%d, try%contacts)
  end subroutine judge_at

end module scree_settle_problems
