!> The iteration of a step: corrections d <- d + K^-1 (forces out of balance) until the deformation settles.
!>
!> K is the secant operator of Zhang et al. 2019 or the tangent. Written as a correction, the secant has the iterates
!> of the paper (K_s d = f) without its round-off floor of eps E dt^2 / (rho l^2). With small strain the
!> forces are linear in d, and the residual of a correction says whether it is the solution.
!>
!> What shares and touches nothing is settled alone. The elements of an island are settled together: deformation outside, and inside
!> it the open-close iteration (Shi's df18 to df22), at fixed operators where it is nested, else both in one.
module scree_settle
  use scree_contact_blame, only: reject_contacts, states_of
  use scree_contact_problem, only: pose_problem, take_states
  use scree_contact_rules, only: iteration_rules, measure_contacts, place
  use scree_contact_try, only: contact_try_t, take_all, take_island
  use scree_correction_mixing, only: mix
  use scree_effects, only: add_element_effects
  use scree_element_term, only: step_rule_t, term_t
  use scree_equations, only: add_equations, begin_equations, is_island, keep_posed, move_island, solve_equations, &
                             weakest_element, wholly_held
  use scree_errors, only: error_t
  use scree_flickering, only: may_part, note_changes, note_part
  use scree_friction_part, only: solve_about
  use scree_friction_problem, only: friction_problem_t, keep_rows_of_forces
  use scree_friction_solver, only: effort_all, effort_path, effort_quick, friction_work_t, solve_friction
  use scree_iteration_end, only: check_area, check_areas, reject_unsettled
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_open_close, only: hold_contacts, judge_contacts, judge_prediction, keep_lines, meet_at_prediction, &
                              return_anchors
  use scree_pair_effects, only: add_bolts, add_pair_effects
  use scree_scene, only: iterate_hybrid, problems_all, problems_none
  use scree_settle_group, only: accepted_share, balances, begins_far, change_of, choose_operator, count_stalled, find_change, &
                                group_t, is_balanced, is_settled, linear_tolerance, near_solution, settles_by_residual, &
                                tell_kind, values_of_members
  use scree_state, only: state_t
  use scree_step_try, only: cut_by_contacts, cut_by_equations, outcome_t, reject
  use scree_system, only: values_of
  use scree_text, only: number_text
  use scree_timers, only: begin_phase, phase_alone, phase_assemble, phase_friction, phase_judge, phase_solve
  implicit none
  private
  public :: settle

  !> Friction problems in a step, after which entrances and anchors stay; and at most.
  integer, parameter :: free_rounds = 3, most_rounds = 30
  !> Friction problems in a step that follow each other at once, where forces bend.
  integer, parameter :: prompt_rounds = 20
  !> Rounds of which half of the way is gone where forces bend: tangents may run in circles, which what lies between breaks. They do
  !> not come evenly, as circles do.
  integer, parameter :: half_rounds(*) = [5, 8, 10, 13, 15, 18, 20, 23, 25, 28]
  !> Contacts that a judgement changes, from which on another one hardly ever changes none.
  integer, parameter :: many_changes = 20
  !> Contacts that a judgement changes, fewer than which the path from there to the solution is likely to be short.
  integer, parameter :: few_changes = 75
  !> Times that contacts may hold in a step what has settled.
  integer, parameter :: most_holds = 100
  !> Forces that a friction problem leaves out of balance, over the largest: a body may have forces of its own that are far smaller.
  !> One that moves nothing, and leaves too much on a body, is solved ten times as exactly the next time, so many times.
  real(dp), parameter :: problem_share = 0.1_dp*accepted_share
  integer, parameter :: most_repeats = 3

contains

  !> Settles every group of elements, or those with some of them. Where one does not, the try says which, where and why.
  subroutine settle(model, cache, state, step_rule, contacts, d, outcome, among, smooth)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state             !! at the beginning of the step
    type(step_rule_t), intent(in) :: step_rule
    type(contact_try_t), intent(inout) :: contacts !! as the step finds them, then in their states
    real(dp), intent(inout) :: d(:)                !! (n_unknowns) prediction, then solution
    type(outcome_t), intent(inout) :: outcome
    logical, intent(in), optional :: among(:)      !! (n_elements) groups without any of these stay as they are
    logical, intent(in), optional :: smooth(:)     !! (n_elements) they begin with their acceleration; none where absent
    type(group_t) :: group
    logical :: touching
    integer :: i

    touching = .false.
    if (allocated(model%effects%contact)) touching = size(contacts%contact) > 0
    if (cache%equations%n_alone > 0) call begin_phase(cache%timers, phase_alone)
    do i = 1, cache%equations%n_groups
      group = group_t(number=i)
      associate (equations => cache%equations)
        group%member = equations%member(equations%first(i):equations%first(i + 1) - 1)
      end associate
      if (present(among)) then
        if (.not. any(among(group%member))) cycle
      end if
      group%rule = step_rule
      if (touching) call take_island(contacts, i - cache%equations%n_alone, group%in_contact)
      call tell_kind(model, cache, d, smooth, group)
      if (wholly_held(cache%equations, i) .and. .not. group%in_contact) then
        call check_areas(model, cache, group%member, d, outcome)
      else if (.not. is_island(cache%equations, i)) then
        call settle_alone(model, cache, state, group, d, outcome)
      else
        if (group%in_contact) then
          call begin_phase(cache%timers, phase_judge)
          call begin_open_close(model, cache, state, group, contacts, d)
        end if
        call settle_together(model, cache, state, group, contacts, d, outcome)
      end if
      if (outcome%settled .and. group%strays) call check_areas(model, cache, group%member, d, outcome)
      if (.not. outcome%settled) exit
    end do
    contacts%goes_on = .false.
    if (touching) call take_all(contacts)
  end subroutine settle

  !> Settles an element that shares and touches nothing.
  subroutine settle_alone(model, cache, state, group, d, outcome)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(group_t), intent(inout) :: group         !! the element alone
    real(dp), intent(inout) :: d(:)               !! (n_unknowns)
    type(outcome_t), intent(inout) :: outcome
    type(term_t) :: term
    real(dp) :: change, residual
    integer :: e, i

    e = group%member(1)
    do i = 1, model%settings%most_iterations
      call begin_equations(cache%equations, group%number)
      call add_element_effects(model, cache%element(e), state, e, values_of(model%elements, e, d), group%rule, term)
      call add_equations(cache%equations, group%number, 1, cache%element(e)%kinematics%span, term)
      if (settles_by_residual(model, group)) then
        outcome%settled = is_balanced(model, cache, group%number)
        if (outcome%settled) return
      end if
      call correct(model, cache, group, d, residual, outcome)
      outcome%iterations = max(outcome%iterations, i)
      if (allocated(outcome%trouble%what)) return
      call check_area(model, cache, e, d, outcome, group%strays)
      if (allocated(outcome%trouble%what)) return
      associate (ids => model%elements%unknown(:, e))
        change = change_of(cache%element(e)%kinematics, cache%equations%correction(ids), group%bolted)
      end associate
      if (i == 1 .and. group%may_leave) group%first = change
      outcome%settled = is_settled(model, cache, group, change, residual)
      if (outcome%settled) return
      if (model%settings%iterate == iterate_hybrid) group%rule%tangent = change < near_solution
    end do
    call reject_unsettled(cache, e, outcome)
  end subroutine settle_alone

  !> Settles elements that share unknowns or touch. Where contacts hold what has settled by multipliers, or by anchors that move, it
  !> settles anew.
  subroutine settle_together(model, cache, state, group, contacts, d, outcome)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(group_t), intent(inout) :: group
    type(contact_try_t), intent(inout) :: contacts
    real(dp), intent(inout) :: d(:)               !! (n_unknowns)
    type(outcome_t), intent(inout) :: outcome
    logical :: held
    integer :: i

    do i = 1, most_holds
      call iterate(model, cache, state, group, contacts, d, outcome)
      if (.not. (outcome%settled .and. group%in_contact)) return
      call begin_phase(cache%timers, phase_judge)
      call hold(model, group, d, contacts, held)
      if (held) return
    end do
    call reject(outcome, cut_by_contacts, 'the multipliers of contacts did not settle in '//number_text(most_holds)//' rounds', &
                'a larger contact.overlap, or another contact.stiffness', 0)
  end subroutine settle_together

  !> Iterates until the deformation and the states of contacts have settled.
  subroutine iterate(model, cache, state, group, contacts, d, outcome)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(group_t), intent(inout) :: group
    type(contact_try_t), intent(inout) :: contacts
    real(dp), intent(inout) :: d(:)               !! (n_unknowns)
    type(outcome_t), intent(inout) :: outcome
    real(dp) :: change, residual
    integer :: i, worst

    outcome%settled = .false.
    worst = group%member(1)
    do i = 1, merge(4, 1, group%in_contact)*model%settings%most_iterations
      call begin_phase(cache%timers, phase_assemble)
      call assemble(model, cache, state, group, contacts, d)
      outcome%settled = balances(model, cache, group, contacts, i)
      if (outcome%settled) return
      outcome%iterations = max(outcome%iterations, i)
      if (i == 1) group%far = begins_far(cache, group)
      call begin_phase(cache%timers, phase_solve)
      call correct(model, cache, group, d, residual, outcome)
      if (allocated(outcome%trouble%what)) return
      call begin_phase(cache%timers, phase_judge)
      call check_areas(model, cache, group%member, d, outcome, group%strays)
      if (allocated(outcome%trouble%what)) then
        call settle_stalled(model, cache, state, group, contacts, d, outcome)
        if (allocated(outcome%trouble%what)) return
        cycle
      end if
      call find_change(model, cache, group, d, change, worst)
      if (i == 1 .and. group%may_leave) group%first = change
      outcome%settled = is_settled(model, cache, group, change, residual) &
                        .and. .not. (group%open_close%repeats_first_of_run .and. state%step == 0 .and. i == 1)
      if (group%in_contact) call judge(model, cache, state, group, contacts, d, outcome)
      if (outcome%settled .or. allocated(outcome%trouble%what)) return
      call choose_operator(model, change, group)
    end do
    call reject_unsettled(cache, worst, outcome)
  end subroutine iterate

  !> Contacts at the prediction, and what their iteration begins with.
  !>
  !> Of the first step the prediction tells what closes. Later ones begin with contacts as the last step left them: most stay so.
  !> Where bodies turn, the first correction brings bodies along that move together, and leaves gaps between them that are of the
  !> second order and mean nothing; contacts are judged from the second on.
  subroutine begin_open_close(model, cache, state, group, contacts, d)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(group_t), intent(inout) :: group
    type(contact_try_t), intent(inout) :: contacts
    real(dp), intent(in) :: d(:)

    group%nested = model%settings%nested .and. .not. group%linear
    if (group%nested) allocate (group%term(size(group%member)))
    if (.not. group%linear) call place(model, cache, state, d, contacts)
    group%open_close = iteration_rules(contacts%law)
    group%open_close%poses_at_once = group%open_close%poses_at_once .and. .not. group%linear
    group%sound = values_of_members(model, group, d)
    if (contacts%goes_on) then
      call judge_contacts(model, d, contacts)
      group%near = .not. group%linear
    else if (group%open_close%judges_prediction .and. state%step == 0) then
      call judge_prediction(model, d, contacts)
    else
      call meet_at_prediction(model, d, contacts)
      group%keeps_states = group%open_close%settles_always .and. .not. (group%linear .or. group%nested)
    end if
  end subroutine begin_open_close

  !> Sums up the equations at `d`, where contacts were measured; of the last linearisation, where contacts settle for that first.
  !>
  !> The operator of contacts keeps the symmetry of a secant. Not where the secant stays: the forces are then linear, and contacts
  !> need their exact changes to settle.
  subroutine assemble(model, cache, state, group, contacts, d)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(group_t), intent(inout) :: group
    type(contact_try_t), intent(in) :: contacts
    real(dp), intent(in) :: d(:)
    logical :: curved

    call add_elements(model, cache, state, group, d)
    if (.not. group%in_contact) return
    curved = model%settings%balance > 0 .or. (group%near .and. group%rule%tangent .and. group%open_close%poses_at_once)
    if (.not. group%frozen) group%linear_at = values_of_members(model, group, d)
    curved = curved .and. .not. (group%frozen .or. group%linear)
    call add_pair_effects(model, contacts, group%number, group%symmetric .and. (group%rule%tangent .or. .not. group%frozen) &
                          .and. .not. model%settings%balance > 0, curved, cache%equations)
  end subroutine assemble

  !> Begins the equations with what the elements add, and the bolts between them.
  subroutine add_elements(model, cache, state, group, d)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(group_t), intent(inout) :: group
    real(dp), intent(in) :: d(:)
    type(term_t) :: term
    integer :: k

    call begin_equations(cache%equations, group%number)
    if (.not. group%frozen) group%symmetric = .true.
    do k = 1, size(group%member)
      associate (e => group%member(k))
        if (group%frozen) then
          term = group%term(k)
          term%force = term%force - matmul(term%matrix, values_of(model%elements, e, d) - group%linear_at(:, k))
        else
          call add_element_effects(model, cache%element(e), state, e, values_of(model%elements, e, d), group%rule, term)
          group%symmetric = group%symmetric .and. term%symmetric
          if (group%nested) group%term(k) = term
        end if
        call add_equations(cache%equations, group%number, k, cache%element(e)%kinematics%span, term)
      end associate
    end do
    if (group%bolted) call add_bolts(model, cache, state, group%number, group%rule, d, cache%equations)
  end subroutine add_elements

  !> Solves for a correction and adds it to `d`, of the secant the share that is asked for, mixed with those before.
  !>
  !> Among contacts it is as exact as these are judged, and rough where another one follows. Without them it is exact to round-off:
  !> what steps leave adds up in a body that turns for ever.
  subroutine correct(model, cache, group, d, residual, outcome)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(group_t), intent(inout) :: group
    real(dp), intent(inout) :: d(:)
    real(dp), intent(out) :: residual             !! of the correction
    type(outcome_t), intent(inout) :: outcome
    type(error_t), allocatable :: error
    integer :: e

    call solve_equations(cache%equations, cache%timers, group%number, linear_tolerance(model), .not. model%settings%shi, &
                         group%in_contact, group%far, d, residual, error)
    outcome%solves = outcome%solves + 1
    if (.not. allocated(error)) then
      if ((model%settings%relaxation < 1 .or. model%settings%anderson > 0) &
          .and. .not. (group%linear .or. group%in_contact .or. group%rule%tangent)) &
        call mix(model, cache, group%member, group%mixing, d)
      return
    end if
    e = weakest_element(cache%equations, group%number)
    call reject(outcome, cut_by_equations, error%message, 'a smaller step.size, and check density, E and fixed points there', e, &
                cache%element(max(1, e))%kinematics%centroid)
  end subroutine correct

  !> Judges the contacts after a correction, and rejects the try where they go round in circles. Those that keep their states wait
  !> for the next one, unless this one settles all.
  !>
  !> Where forces bend, a correction from the solution of a friction problem that changes any contact is no use: the iteration, once
  !> it has run in circles, does so again. The next problem follows at once, from where the last one ended. Where nothing changes
  !> anchors return before the deformation has settled, which would else settle once more for them.
  subroutine judge(model, cache, state, group, contacts, d, outcome)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(group_t), intent(inout) :: group
    type(contact_try_t), intent(inout) :: contacts
    real(dp), intent(inout) :: d(:)
    type(outcome_t), intent(inout) :: outcome
    integer :: before(2, contacts%last - contacts%first + 1) !! states of their entrances before the judgement
    logical :: enough, prompt, waits

    waits = group%keeps_states .and. .not. outcome%settled
    group%keeps_states = .false.
    if (waits) then
      call place(model, cache, state, d, contacts)
      call measure_contacts(model, d, contacts)
      return
    end if
    prompt = group%near .and. group%rounds < prompt_rounds .and. group%open_close%poses_at_once
    before = states_of(contacts)
    if (group%nested) call judge_contacts(model, d, contacts)
    group%frozen = group%nested .and. contacts%changes > 0
    if (.not. group%frozen) call judge_at(model, cache, state, group, d, contacts)
    outcome%judged = reshape([outcome%judged, contacts%count, contacts%changes], [4, size(outcome%judged, 2) + 1])
    group%far = contacts%changes > many_changes .and. group%open_close%settles_always
    group%in_doubt = outcome%settled .and. contacts%changes > 0 .and. group%open_close%settles_always
    if (contacts%changes == 0) then
      if (.not. outcome%settled) call return_anchors(model, d, contacts, enough)
      return
    end if
    outcome%settled = .false.
    call settle_circles(model, cache, state, group, before, prompt, contacts, d, outcome)
  end subroutine judge

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
    type(contact_try_t) :: contacts_before
    real(dp), allocatable :: d_before(:), x(:)
    integer :: spring(contacts%last - contacts%first + 1)
    logical :: found

    if (.not. group%open_close%settles_always) return
    group%tried = group%fewest
    call begin_phase(cache%timers, phase_judge)
    d_before = d
    contacts_before = contacts
    call go_back(model, cache, state, group, group%best, contacts, d)
    call solve_as_problem(model, cache, state, group, .false., contacts, d, outcome, x, spring, found, effort_path)
    if (found) call take_solution(model, cache, state, group, x, spring, contacts, d, outcome)
    if (group%near) then
      call settle_rounds(model, cache, state, group, contacts, d, outcome)
      return
    end if
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
    real(dp), allocatable :: x(:)
    integer :: effort, spring(contacts%last - contacts%first + 1)
    logical :: found

    if (.not. (group%in_contact .and. group%open_close%settles_always .and. group%rounds < most_rounds)) return
    call begin_phase(cache%timers, phase_judge)
    call go_back(model, cache, state, group, group%sound, contacts, d)
    effort = merge(effort_quick, effort_all, group%open_close%poses_at_once)
    call solve_as_problem(model, cache, state, group, .false., contacts, d, outcome, x, spring, found, effort)
    if (.not. (found .or. group%linear)) &
      call solve_as_problem(model, cache, state, group, .true., contacts, d, outcome, x, spring, found, effort_all)
    if (.not. found) return
    call take_solution(model, cache, state, group, x, spring, contacts, d, outcome)
    if (.not. allocated(outcome%trouble%what)) call settle_rounds(model, cache, state, group, contacts, d, outcome)
  end subroutine settle_stalled

  !> Lets friction problems follow each other at once where forces bend, as long as where one ends other contacts are judged to act.
  subroutine settle_rounds(model, cache, state, group, contacts, d, outcome)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(group_t), intent(inout) :: group
    type(contact_try_t), intent(inout) :: contacts
    real(dp), intent(inout) :: d(:)
    type(outcome_t), intent(inout) :: outcome
    real(dp), allocatable :: x(:)
    integer :: spring(contacts%last - contacts%first + 1)
    logical :: found

    do while (contacts%changes > 0 .and. group%open_close%poses_at_once .and. group%rounds < prompt_rounds)
      call solve_as_problem(model, cache, state, group, .false., contacts, d, outcome, x, spring, found, effort_path)
      if (.not. found) exit
      call take_solution(model, cache, state, group, x, spring, contacts, d, outcome)
      if (allocated(outcome%trouble%what)) exit
    end do
  end subroutine settle_rounds

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

  !> Takes the solution of a friction problem that was posed at `d`, from which the iteration goes on. Where an area runs away with
  !> it the outcome has a trouble.
  subroutine take_solution(model, cache, state, group, x, spring, contacts, d, outcome)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(group_t), intent(inout) :: group
    real(dp), intent(inout) :: x(:)               !! correction of the island
    integer, intent(in) :: spring(:)              !! states of its contacts
    type(contact_try_t), intent(inout) :: contacts
    real(dp), intent(inout) :: d(:)
    type(outcome_t), intent(inout) :: outcome
    real(dp) :: change
    integer :: worst

    group%linear_at = values_of_members(model, group, d)
    call take_states(spring, contacts)
    if (any(half_rounds == group%rounds) .and. .not. group%linear) x = 0.5_dp*x
    call move_island(cache%equations, group%number, x, d)
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
    group%stalled = 0
    group%far = .false.
    group%fewest = huge(1)
    call judge_at(model, cache, state, group, d, contacts)
    group%in_doubt = group%linear .or. change < model%settings%tolerance
    if (change < model%settings%tolerance) group%repeats = min(group%repeats + 1, most_repeats)
    outcome%settled = .false.
  end subroutine take_solution

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
    real(dp), allocatable :: x(:)
    integer :: spring(contacts%last - contacts%first + 1)

    call solve_as_problem(model, cache, state, group, .false., contacts, d, outcome, x, spring, done, effort_quick, &
                          group%flickering%contact)
    if (.not. (done .or. group%linear)) &
      call solve_as_problem(model, cache, state, group, .true., contacts, d, outcome, x, spring, done, effort_quick, &
                            group%flickering%contact)
    call note_part(done, group%flickering)
    if (.not. done) return
    call take_states(spring, contacts)
    call move_island(cache%equations, group%number, x, d)
    group%stalled = 0
    group%fewest = huge(1)
    call judge_at(model, cache, state, group, d, contacts)
  end subroutine settle_part

  !> Poses the contacts at `d` as a friction problem, and solves it; or its part about some contacts, where that is small.
  !>
  !> Stress turns with what it is in, so that with Green strain elements under pressure may have a tangent that is not definite, and
  !> contacts rows of forces that are not those of their changes: there may be no solution. With the secant, which does not have
  !> stress turn, and with the rows of forces alone there is one (doc/theory.md), from where the iteration goes on.
  subroutine solve_as_problem(model, cache, state, group, by_secant, contacts, d, outcome, x, spring, found, effort, about)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(group_t), intent(in) :: group
    logical, intent(in) :: by_secant               !! and by the rows of forces
    type(contact_try_t), intent(inout) :: contacts
    real(dp), intent(in) :: d(:)
    type(outcome_t), intent(inout) :: outcome
    real(dp), allocatable, intent(out) :: x(:)     !! correction of the island
    integer, intent(out) :: spring(:)              !! states of its contacts
    logical, intent(out) :: found
    integer, intent(in) :: effort                  !! that it may take
    logical, intent(in), optional :: about(:)      !! contacts of the island, of which a part is solved
    type(group_t) :: posed
    type(friction_problem_t) :: problem, whole
    type(friction_work_t) :: work
    logical :: near

    call begin_phase(cache%timers, phase_assemble)
    posed = group
    posed%rule%tangent = group%rule%tangent .and. .not. by_secant
    call add_elements(model, cache, state, posed, d)
    call pose_problem(model, contacts, group%number, d, cache%equations, problem)
    if (by_secant) call keep_rows_of_forces(problem)
    near = group%near .or. effort == effort_path
    if (present(about)) then
      near = near .or. group%flickering%parts > 0
      whole = problem
      call solve_about(whole, about, group%flickering%reach, near, accepted_share, cache%timers, problem, x, spring, found, work)
    else
      call begin_phase(cache%timers, phase_friction)
      call solve_friction(problem, near, problem_share*0.1_dp**group%repeats, cache%timers, x, spring, found, work, effort)
    end if
    if (.not. allocated(problem%force)) return
    outcome%solves = outcome%solves + work%factors
    if (model%settings%problems == problems_all &
        .or. (model%settings%problems /= problems_none .and. .not. (found .or. effort == effort_path))) &
      call keep_posed(cache%equations, problem, near, found)
  end subroutine solve_as_problem

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

  !> Lets contacts hold what has settled, by multipliers and where they closed; it is `held` where none changes by that.
  subroutine hold(model, group, d, contacts, held)
    type(model_t), intent(in) :: model
    type(group_t), intent(inout) :: group
    real(dp), intent(in) :: d(:)
    type(contact_try_t), intent(inout) :: contacts
    logical, intent(out) :: held

    call hold_contacts(model, d, contacts, held)
    if (held) call return_anchors(model, d, contacts, held)
    group%stalled = 0
    group%rounds = 0
    group%repeats = 0
    group%in_doubt = .false.
  end subroutine hold

end module scree_settle
