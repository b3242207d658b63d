!> Contacts that the iteration of a step cannot settle, settled as friction problems (doc/theory.md, section 4).
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
  use scree_iteration_end, only: check_areas
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_open_close, only: judge_contacts, keep_lines
  use scree_scene, only: problems_all, problems_none
  use scree_settle_group, only: accepted_share, add_elements, begin_round, choose_operator, count_stalled, find_change, &
                                group_t, values_of_members
  use scree_state, only: state_t
  use scree_step_try, only: outcome_t
  use scree_timers, only: begin_phase, phase_assemble, phase_friction, phase_judge
  implicit none
  private
  public :: judge_at, may_follow, settle_circles, settle_stalled

  !> Friction problems in a step, after which entrances and anchors stay; and at most.
  integer, parameter :: free_rounds = 3, most_rounds = 30
  !> Friction problems in a step that follow each other at once, where forces bend.
  integer, parameter :: prompt_rounds = 20
  !> Rounds of which half of the way is gone where forces bend: tangents may run in circles, which what lies between breaks. They do
  !> not come evenly, as circles do.
  integer, parameter :: half_rounds(*) = [5, 8, 10, 13, 15, 18, 20, 23, 25, 28]
  !> Contacts that a judgement changes, fewer than which the path from there to the solution is likely to be short.
  integer, parameter :: few_changes = 75
  !> Forces that a friction problem leaves out of balance, over the largest: a body may have forces of its own that are far smaller.
  !> One that moves nothing, and leaves too much on a body, is solved ten times as exactly the next time, so many times.
  real(dp), parameter :: problem_share = 0.1_dp*accepted_share
  integer, parameter :: most_repeats = 3

  !> What a friction problem of a group came to.
  type :: answer_t
    logical :: found = .false.
    real(dp), allocatable :: x(:)       !! correction of the island
    integer, allocatable :: state(:)    !! of its contacts, as springs of the problem
  end type answer_t

contains

  !> Settles contacts that a judgement has changed as a friction problem, where the iteration runs in circles or would.
  subroutine settle_circles(model, cache, state, group, before, prompt, contacts, d, outcome)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(group_t), intent(inout) :: group
    integer, intent(in) :: before(:, :)           !! (2, n_contacts) states of their entrances before the judgement
    logical, intent(in) :: prompt                 !! whatever has changed
    type(contact_try_t), intent(inout) :: contacts
    real(dp), intent(inout) :: d(:)
    type(outcome_t), intent(inout) :: outcome
    logical :: apart, stalls

    call note_changes(before, contacts, group%flickering, apart)
    call count_stalled(model, d, contacts%changes, group)
    stalls = group%stalled > group%open_close%most_stalled
    apart = (apart .or. stalls) .and. may_part(group%flickering, size(group%member)) &
            .and. group%open_close%settles_always .and. (group%linear .or. .not. group%near)
    if (apart) call settle_part(model, cache, state, group, contacts, d, outcome, apart)
    if (apart) return
    if ((stalls .or. group%stalled == 1) .and. group%fewest < min(group%tried, few_changes) .and. .not. group%near) then
      call settle_near(model, cache, state, group, contacts, d, outcome)
      if (group%near) return
    end if
    if (.not. (stalls .or. prompt)) return
    call reject_contacts(model, state, contacts, before, d, outcome)
    call settle_stalled(model, cache, state, group, contacts, d, outcome)
  end subroutine settle_circles

  !> Settles contacts as a friction problem from where a judgement changed fewest of them: along the path alone, which is short
  !> where that was near the solution. Where it does not get there all stays as it was.
  subroutine settle_near(model, cache, state, group, contacts, d, outcome)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(group_t), intent(inout) :: group         !! near the solution where that was found
    type(contact_try_t), intent(inout) :: contacts
    real(dp), intent(inout) :: d(:)
    type(outcome_t), intent(inout) :: outcome
    type(answer_t) :: answer
    type(contact_try_t) :: contacts_before
    real(dp), allocatable :: d_before(:)

    if (.not. group%open_close%settles_always) return
    group%tried = group%fewest
    call begin_phase(cache%timers, phase_judge)
    d_before = d
    contacts_before = contacts
    call go_back(model, cache, state, group, group%best, contacts, d)
    call solve_as_problem(model, cache, state, group, effort_path, contacts, d, outcome, answer)
    if (answer%found) call settle_rounds(model, cache, state, group, answer, contacts, d, outcome)
    if (group%near) return
    if (allocated(outcome%trouble%what)) deallocate (outcome%trouble%what)
    d = d_before
    contacts = contacts_before
  end subroutine settle_near

  !> Settles contacts that run in circles as a friction problem, at the entrances, anchors and bonds that they have where the last
  !> such round ended or the step began. Where it may not, or that fails, the trouble of the outcome stays.
  subroutine settle_stalled(model, cache, state, group, contacts, d, outcome)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(group_t), intent(inout) :: group
    type(contact_try_t), intent(inout) :: contacts
    real(dp), intent(inout) :: d(:)
    type(outcome_t), intent(inout) :: outcome
    type(answer_t) :: answer
    integer :: effort

    if (.not. (group%in_contact .and. group%open_close%settles_always .and. group%rounds < most_rounds)) return
    call begin_phase(cache%timers, phase_judge)
    call go_back(model, cache, state, group, group%sound, contacts, d)
    effort = merge(effort_quick, effort_all, group%open_close%poses_at_once)
    call solve_as_problem(model, cache, state, group, effort, contacts, d, outcome, answer)
    if (.not. (answer%found .or. group%linear)) &
      call solve_as_problem(model, cache, state, group, effort_all, contacts, d, outcome, answer, by_secant=.true.)
    if (answer%found) call settle_rounds(model, cache, state, group, answer, contacts, d, outcome)
  end subroutine settle_stalled

  !> Takes the answer to a friction problem, and to those that follow it at once where forces bend, as long as where one ends other
  !> contacts are judged to act.
  subroutine settle_rounds(model, cache, state, group, answer, contacts, d, outcome)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(group_t), intent(inout) :: group
    type(answer_t), intent(inout) :: answer
    type(contact_try_t), intent(inout) :: contacts
    real(dp), intent(inout) :: d(:)
    type(outcome_t), intent(inout) :: outcome

    do
      call take_answer(model, cache, state, group, answer, contacts, d, outcome)
      if (allocated(outcome%trouble%what)) return
      if (.not. (contacts%changes > 0 .and. may_follow(group))) return
      call solve_as_problem(model, cache, state, group, effort_path, contacts, d, outcome, answer)
      if (.not. answer%found) return
    end do
  end subroutine settle_rounds

  !> Whether another friction problem may follow those of a step at once: where forces bend and they are not too many.
  pure logical function may_follow(group)
    type(group_t), intent(in) :: group

    may_follow = group%open_close%poses_at_once .and. group%rounds < prompt_rounds
  end function may_follow

  !> Takes the answer to a friction problem that was posed at `d`, from which the iteration goes on. Where an area runs away with
  !> it the outcome has a trouble.
  subroutine take_answer(model, cache, state, group, answer, contacts, d, outcome)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(group_t), intent(inout) :: group
    type(answer_t), intent(inout) :: answer
    type(contact_try_t), intent(inout) :: contacts
    real(dp), intent(inout) :: d(:)
    type(outcome_t), intent(inout) :: outcome
    real(dp) :: change
    integer :: worst

    group%began_at = values_of_members(model, group, d)
    call take_states(answer%state, contacts)
    if (any(half_rounds == group%rounds) .and. .not. group%linear) answer%x = 0.5_dp*answer%x
    call move_island(cache%equations, group%number, answer%x, d)
    outcome%settled = .true.
    call check_areas(model, cache, group%member, d, outcome)
    if (.not. outcome%settled) return
    if (allocated(outcome%trouble%what)) deallocate (outcome%trouble%what)
    call find_change(model, cache, group, d, change, worst)
    if (group%open_close%poses_at_once) call choose_operator(model, change, group)
    group%sound = values_of_members(model, group, d)
    group%near = .true.
    group%rounds = group%rounds + 1
    if (group%rounds == free_rounds) call keep_lines(contacts)
    call begin_round(group)
    group%far = .false.
    call judge_at(model, cache, state, group, d, contacts)
    group%in_doubt = group%linear .or. change < model%settings%tolerance
    if (change < model%settings%tolerance) group%repeats = min(group%repeats + 1, most_repeats)
    outcome%settled = .false.
  end subroutine take_answer

  !> Settles the contacts that go on changing as the friction problem of what is about them, where that is few.
  subroutine settle_part(model, cache, state, group, contacts, d, outcome, done)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(group_t), intent(inout) :: group
    type(contact_try_t), intent(inout) :: contacts
    real(dp), intent(inout) :: d(:)
    type(outcome_t), intent(inout) :: outcome
    logical, intent(out) :: done
    type(answer_t) :: answer

    call solve_as_problem(model, cache, state, group, effort_quick, contacts, d, outcome, answer, about=group%flickering%contact)
    if (.not. (answer%found .or. group%linear)) &
      call solve_as_problem(model, cache, state, group, effort_quick, contacts, d, outcome, answer, by_secant=.true., &
                            about=group%flickering%contact)
    done = answer%found
    call note_part(done, group%flickering)
    if (.not. done) return
    call take_states(answer%state, contacts)
    call move_island(cache%equations, group%number, answer%x, d)
    call begin_round(group)
    call judge_at(model, cache, state, group, d, contacts)
  end subroutine settle_part

  !> Poses the contacts at `d` as a friction problem, and solves it; or its part about some contacts, where that is small.
  !>
  !> Stress turns with what it is in, so that with Green strain elements under pressure may have a tangent that is not definite, and
  !> contacts rows of forces that are not those of their changes: there may be no solution. With the secant, which does not have
  !> stress turn, and with the rows of forces alone there is one (doc/theory.md), from where the iteration goes on.
  subroutine solve_as_problem(model, cache, state, group, effort, contacts, d, outcome, answer, by_secant, about)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(group_t), intent(in) :: group
    integer, intent(in) :: effort                  !! that it may take
    type(contact_try_t), intent(inout) :: contacts
    real(dp), intent(in) :: d(:)
    type(outcome_t), intent(inout) :: outcome
    type(answer_t), intent(out) :: answer
    logical, intent(in), optional :: by_secant     !! and by the rows of forces; else by the operator of the iteration
    logical, intent(in), optional :: about(:)      !! contacts of the island, of which a part is solved; else all
    type(group_t) :: posed
    type(friction_problem_t) :: problem, whole
    type(friction_work_t) :: work
    logical :: near, secant

    call begin_phase(cache%timers, phase_assemble)
    secant = .false.
    if (present(by_secant)) secant = by_secant
    posed = group
    posed%rule%tangent = group%rule%tangent .and. .not. secant
    call add_elements(model, cache, state, posed, d)
    call pose_problem(model, contacts, group%number, d, cache%equations, problem)
    if (secant) call keep_rows_of_forces(problem)
    near = group%near .or. effort == effort_path
    allocate (answer%state(size(problem%spring)))
    if (present(about)) then
      near = near .or. group%flickering%parts > 0
      whole = problem
      call solve_about(whole, about, group%flickering%reach, near, accepted_share, cache%timers, problem, answer%x, answer%state, &
                       answer%found, work)
    else
      call begin_phase(cache%timers, phase_friction)
      call solve_friction(problem, near, problem_share*0.1_dp**group%repeats, cache%timers, answer%x, answer%state, answer%found, &
                          work, effort)
    end if
    if (.not. allocated(problem%force)) return
    outcome%solves = outcome%solves + work%factors
    if (is_kept(model%settings%problems, answer%found .or. effort == effort_path)) &
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

  !> Goes to a displacement of the members, and judges the contacts there.
  subroutine go_back(model, cache, state, group, values, contacts, d)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(group_t), intent(in) :: group
    real(dp), intent(in) :: values(:, :)          !! (n, n_members)
    type(contact_try_t), intent(inout) :: contacts
    real(dp), intent(inout) :: d(:)
    integer :: k

    do k = 1, size(group%member)
      d(model%elements%unknown(:, group%member(k))) = values(:, k)
    end do
    call judge_at(model, cache, state, group, d, contacts)
  end subroutine go_back

  !> Judges the contacts at `d`, placed there where they may be.
  subroutine judge_at(model, cache, state, group, d, contacts)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(group_t), intent(in) :: group
    real(dp), intent(in) :: d(:)
    type(contact_try_t), intent(inout) :: contacts

    if (.not. (group%linear .or. group%frozen)) call place(model, cache, state, d, contacts)
    call judge_contacts(model, d, contacts)
  end subroutine judge_at

end module scree_settle_problems
