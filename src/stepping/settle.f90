!> The iteration of a step: corrections d <- d + K^-1 (forces out of balance) until the deformation settles.
!>
!> K is the secant operator of Zhang et al. 2019 or the tangent. Written as a correction, the secant has the iterates
!> of the paper (K_s d = f) without its round-off floor of eps E dt^2 / (rho l^2). With small strain the
!> forces are linear in d, and the residual of a correction says whether it is the solution.
!>
!> What shares and touches nothing is settled alone. The elements of an island are settled together: deformation outside, and inside
!> it the open-close iteration (Shi's df18 to df22), at fixed operators where it is nested, else both in one.
module scree_settle
  use scree_contact_rules, only: forces_stay_linear, iteration_rules, measure_contacts, place
  use scree_contact_try, only: contact_try_t, states_of, take_all, take_island
  use scree_correction_mixing, only: mix
  use scree_effects, only: add_element_effects
  use scree_element_term, only: step_rule_t, term_t
  use scree_equations, only: add_equations, begin_equations, is_island, solve_equations, weakest_element, wholly_held
  use scree_errors, only: error_t
  use scree_iteration_end, only: check_area, check_areas, reject_unsettled
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_open_close, only: hold_contacts, judge_contacts, judge_prediction, meet_at_prediction, return_anchors
  use scree_pair_effects, only: add_pair_effects
  use scree_scene, only: iterate_hybrid
  use scree_settle_group, only: add_elements, balances, begin_round, begins_far, change_of, choose_operator, find_change, group_t, &
                                is_balanced, is_settled, linear_tolerance, near_solution, settles_by_residual, tell_kind, &
                                values_of_members
  use scree_settle_problems, only: judge_at, may_follow, settle_circles, settle_stalled
  use scree_state, only: state_t
  use scree_step_try, only: cut_by_contacts, cut_by_equations, outcome_t, reject
  use scree_system, only: values_of
  use scree_text, only: number_text
  use scree_timers, only: begin_phase, phase_alone, phase_assemble, phase_judge, phase_solve
  implicit none
  private
  public :: settle

  !> Contacts that a judgement changes, from which on another one hardly ever changes none.
  integer, parameter :: many_changes = 20
  !> Times that contacts may hold in a step what has settled.
  integer, parameter :: most_holds = 100

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
      outcome%settled = is_settled(model, cache, group, d, change, residual)
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

  !> Iterates until the deformation and the states of contacts have settled. Forces that balance are no end before contacts are
  !> judged there: what flies balances, too, until it is told what it flies into.
  subroutine iterate(model, cache, state, group, contacts, d, outcome)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(group_t), intent(inout) :: group
    type(contact_try_t), intent(inout) :: contacts
    real(dp), intent(inout) :: d(:)               !! (n_unknowns)
    type(outcome_t), intent(inout) :: outcome
    logical :: judged                             !! contacts, where `d` is
    integer :: i, worst

    outcome%settled = .false.
    judged = .not. group%in_contact
    worst = group%member(1)
    do i = 1, merge(4, 1, group%in_contact)*model%settings%most_iterations
      call begin_phase(cache%timers, phase_assemble)
      call assemble(model, cache, state, group, contacts, d)
      outcome%settled = balances(model, cache, group, group%in_contact .and. judged .and. contacts%changes > 0)
      if (outcome%settled .and. judged) return
      if (outcome%settled) then
        call begin_phase(cache%timers, phase_judge)
        call judge(model, cache, state, group, contacts, d, outcome, judged)
      else
        outcome%iterations = max(outcome%iterations, i)
        call improve(model, cache, state, group, i == 1, contacts, d, outcome, judged, worst)
      end if
      if (outcome%settled .or. allocated(outcome%trouble%what)) return
    end do
    call reject_unsettled(cache, worst, outcome)
  end subroutine iterate

  !> One correction, and what it comes to.
  subroutine improve(model, cache, state, group, first, contacts, d, outcome, judged, worst)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(group_t), intent(inout) :: group
    logical, intent(in) :: first                  !! of the iteration
    type(contact_try_t), intent(inout) :: contacts
    real(dp), intent(inout) :: d(:)               !! (n_unknowns)
    type(outcome_t), intent(inout) :: outcome
    logical, intent(inout) :: judged              !! contacts, where `d` is
    integer, intent(out) :: worst                 !! element that changed most
    real(dp) :: change, residual

    worst = group%member(1)
    if (first) group%far = begins_far(cache, group)
    call begin_phase(cache%timers, phase_solve)
    call correct(model, cache, group, d, residual, outcome)
    if (allocated(outcome%trouble%what)) return
    call begin_phase(cache%timers, phase_judge)
    call check_areas(model, cache, group%member, d, outcome, group%strays)
    if (allocated(outcome%trouble%what)) then
      call settle_stalled(model, cache, state, group, contacts, d, outcome)
      outcome%settled = .false.
      return
    end if
    call find_change(model, cache, group, d, change, worst)
    if (first .and. group%may_leave) group%first = change
    outcome%settled = is_settled(model, cache, group, d, change, residual) &
                      .and. .not. (group%open_close%repeats_first_of_run .and. state%step == 0 .and. first)
    if (group%in_contact) call judge(model, cache, state, group, contacts, d, outcome, judged)
    if (.not. outcome%settled) call choose_operator(model, change, group)
  end subroutine improve

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
    group%may_leave = group%may_leave .and. forces_stay_linear(model, contacts)
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
    if (.not. group%frozen) then
      group%began_at = values_of_members(model, group, d)
      if (group%nested) group%linear_at = group%began_at
    end if
    curved = curved .and. .not. (group%frozen .or. group%linear)
    call add_pair_effects(model, contacts, group%number, group%symmetric .and. (group%rule%tangent .or. .not. group%frozen) &
                          .and. .not. model%settings%balance > 0, curved, cache%equations)
  end subroutine assemble

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
  subroutine judge(model, cache, state, group, contacts, d, outcome, judged)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(group_t), intent(inout) :: group
    type(contact_try_t), intent(inout) :: contacts
    real(dp), intent(inout) :: d(:)
    type(outcome_t), intent(inout) :: outcome
    logical, intent(out) :: judged                !! they do not wait
    integer :: before(2, contacts%last - contacts%first + 1) !! states of their entrances before the judgement
    logical :: enough, prompt, waits

    waits = group%keeps_states .and. .not. outcome%settled
    group%keeps_states = .false.
    judged = .not. waits
    if (waits) then
      call place(model, cache, state, d, contacts)
      call measure_contacts(model, d, contacts)
      return
    end if
    prompt = group%near .and. may_follow(group)
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
    group%first = 0.0_dp
    call settle_circles(model, cache, state, group, before, prompt, contacts, d, outcome)
  end subroutine judge

  !> Lets contacts hold what has settled, by multipliers and where they closed; it is `held` where none changes by that.
  subroutine hold(model, group, d, contacts, held)
    type(model_t), intent(in) :: model
    type(group_t), intent(inout) :: group
    real(dp), intent(in) :: d(:)
    type(contact_try_t), intent(inout) :: contacts
    logical, intent(out) :: held

    call hold_contacts(model, d, contacts, held)
    if (held) call return_anchors(model, d, contacts, held)
    call begin_round(group)
    group%rounds = 0
    group%repeats = 0
    group%in_doubt = .false.
  end subroutine hold

end module scree_settle
