!> The iteration of a step: corrections d <- d + K^-1 (forces out of balance) until the deformation settles.
!>
!> K is the secant operator of Zhang et al. 2019 or the tangent. Written as a correction, the secant has the iterates
!> of the paper (K_s d = f) without its round-off floor of eps E dt^2 / (rho l^2). With small strain the
!> forces are linear in d, and the residual of a correction says whether it is the solution.
!>
!> What shares and touches nothing is settled alone. The elements of an island are settled together: deformation outside, and inside
!> it the open-close iteration (Shi's df18 to df22), at fixed operators where it is nested, else both in one.
module scree_settle
  use scree_contact_rules, only: iteration_rules, measure_contacts, place
  use scree_contact_try, only: edges_stay, states_of, take_all, take_island
  use scree_correction_mixing, only: mix
  use scree_effects, only: add_element_effects
  use scree_element_term, only: term_t
  use scree_equations, only: add_equations, begin_equations, is_island, solve_equations, weakest_element, wholly_held
  use scree_errors, only: error_t
  use scree_iteration, only: element_group_t, iteration_t
  use scree_iteration_end, only: check_areas, reject_unsettled
  use scree_kinds, only: dp
  use scree_linear_solver, only: exactness_t
  use scree_model, only: cache_t, model_t
  use scree_open_close, only: break_bonds, follow_stress, hold_contacts, judge_contacts, judge_prediction, meet_at_prediction, &
                              return_anchors
  use scree_pair_effects, only: add_pair_effects
  use scree_settle_group, only: add_elements, balances, begin_round, begins_far, change_of, choose_operator, find_change, &
                                is_balanced, is_settled, linear_tolerance, settles_by_residual, tell_kind, values_of_members
  use scree_settle_problems, only: judge_at, settle_circles, settle_stalled
  use scree_state, only: state_t, step_of_run
  use scree_step_try, only: cut_by_contacts, cut_by_equations, reject, try_t
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
  !> Times that friction may follow in a step what contacts bear; the last ones go half of the way, as stiff arches may go round.
  integer, parameter :: most_follows = 30

contains

  !> Settles every group of elements, or those with some of them. Where one does not, the outcome of the try says which, where and
  !> why.
  subroutine settle(model, cache, state, try, among)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state             !! at the beginning of the step
    type(try_t), intent(inout) :: try              !! with a prediction, then with the solution
    logical, intent(in), optional :: among(:)      !! (n_elements) groups without any of these stay as they are
    logical :: touching
    integer :: i

    touching = .false.
    if (allocated(model%effects%contact)) touching = size(try%contacts%contact) > 0
    if (cache%equations%n_alone > 0) call begin_phase(cache%timers, phase_alone)
    do i = 1, cache%equations%n_groups
      try%group = element_group_t(number=i)
      associate (equations => cache%equations)
        try%group%member = equations%member(equations%first(i):equations%first(i + 1) - 1)
      end associate
      if (present(among)) then
        if (.not. any(among(try%group%member))) cycle
      end if
      try%iteration = iteration_t()
      if (touching) call take_island(try%contacts, i - cache%equations%n_alone, try%group%in_contact)
      call tell_kind(model, cache, try)
      if (wholly_held(cache%equations, i) .and. .not. try%group%in_contact) then
        call check_areas(model, cache, try, of_iterate=.false.)
      else if (.not. is_island(cache%equations, i)) then
        call settle_alone(model, cache, state, try)
      else
        if (try%group%in_contact) then
          call begin_phase(cache%timers, phase_judge)
          call begin_open_close(model, cache, state, try)
        end if
        call settle_together(model, cache, state, try)
      end if
      if (try%outcome%settled .and. try%group%may_stray) call check_areas(model, cache, try, of_iterate=.false.)
      if (.not. try%outcome%settled) exit
    end do
    try%contacts%goes_on = .false.
    if (touching) call take_all(try%contacts)
  end subroutine settle

  !> Settles an element that shares and touches nothing.
  subroutine settle_alone(model, cache, state, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(inout) :: try             !! of whose group the element is all
    type(term_t) :: term
    real(dp) :: change, residual
    integer :: e, i

    e = try%group%member(1)
    do i = 1, model%settings%most_iterations
      call begin_equations(cache%equations, try%group%number)
      call add_element_effects(model, cache%element(e), state, e, values_of(model%elements, e, try%d), try%rule, term)
      call add_equations(cache%equations, try%group%number, 1, cache%element(e)%kinematics%span, term)
      if (settles_by_residual(model, try%group)) then
        try%outcome%settled = is_balanced(model, cache, try%group%number)
        if (try%outcome%settled) return
      end if
      call correct(model, cache, try, residual)
      try%outcome%iterations = max(try%outcome%iterations, i)
      if (allocated(try%outcome%trouble%what)) return
      call check_areas(model, cache, try, of_iterate=.true.)
      if (allocated(try%outcome%trouble%what)) return
      associate (ids => model%elements%unknown(:, e))
        change = change_of(cache%element(e)%kinematics, cache%equations%correction(ids), try%group%bolted)
      end associate
      if (i == 1 .and. try%group%may_end_early) try%iteration%first_change = change
      try%outcome%settled = is_settled(model, cache, state, try, change, residual)
      if (try%outcome%settled) return
      call choose_operator(model, change, try)
    end do
    call reject_unsettled(cache, e, try%outcome)
  end subroutine settle_alone

  !> Settles elements that share unknowns or touch.
  !>
  !> A settled group settles anew where multipliers grow or anchors move. It settles anew without bonds that are too weak, at least
  !> one in a round, so these rounds end. It settles anew with the damage of bonds that soften, so many times at most. It settles
  !> anew with the friction of the present stress of static contacts; if the rounds end before that friction stays, it is that of
  !> the last round.
  subroutine settle_together(model, cache, state, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(inout) :: try
    logical :: held
    integer :: follows, rounds

    rounds = 0
    follows = 0
    do while (rounds < most_holds)
      call iterate(model, cache, state, try)
      if (.not. (try%outcome%settled .and. try%group%in_contact)) return
      call begin_phase(cache%timers, phase_judge)
      call hold(model, try, held)
      if (held) then
        call break_bonds(model, try%d, try%contacts, held)
        if (try%contacts%softens_on()) exit
        if (held .and. follows < most_follows) then
          follows = follows + 1
          call follow_stress(model, try%d, merge(1.0_dp, 0.5_dp, 3*follows < most_follows), try%contacts, held)
        end if
        if (held) return
      else
        rounds = rounds + 1
      end if
    end do
    if (try%contacts%softens_on()) then
      call reject(try%outcome, cut_by_contacts, 'the damage of bonds did not settle', &
                  'a smaller step.size, or a finer mesh along the joint', 0)
      return
    end if
    call reject(try%outcome, cut_by_contacts, 'the multipliers of contacts did not settle in '//number_text(most_holds)// &
                ' rounds', 'a larger contact.overlap, or another contact.stiffness', 0)
  end subroutine settle_together

  !> Iterates until the deformation and the states of contacts have settled. Forces that balance are no end before contacts are
  !> judged there: what flies balances, too, until it is told what it flies into.
  subroutine iterate(model, cache, state, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(inout) :: try
    integer :: i

    associate (outcome => try%outcome, iteration => try%iteration)
      outcome%settled = .false.
      iteration%judged = .not. try%group%in_contact
      iteration%worst = try%group%member(1)
      do i = 1, merge(4, 1, try%group%in_contact)*model%settings%most_iterations
        iteration%number = i
        call begin_phase(cache%timers, phase_assemble)
        call assemble(model, cache, state, try)
        outcome%settled = balances(model, cache, try)
        if (outcome%settled .and. iteration%judged) return
        if (outcome%settled) then
          call begin_phase(cache%timers, phase_judge)
          call judge(model, cache, state, try)
        else
          outcome%iterations = max(outcome%iterations, i)
          call improve(model, cache, state, try)
        end if
        if (outcome%settled .or. allocated(outcome%trouble%what)) return
      end do
      call reject_unsettled(cache, iteration%worst, outcome)
    end associate
  end subroutine iterate

  !> One correction, and the state after it.
  subroutine improve(model, cache, state, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(inout) :: try
    real(dp) :: change, residual
    logical :: first
    integer :: worst

    first = try%iteration%number == 1
    try%iteration%worst = try%group%member(1)
    if (.not. try%iteration%corrected) try%iteration%likely_to_change = begins_far(cache, try%group)
    try%iteration%corrected = .true.
    call begin_phase(cache%timers, phase_solve)
    call correct(model, cache, try, residual)
    if (allocated(try%outcome%trouble%what)) return
    call begin_phase(cache%timers, phase_judge)
    call check_areas(model, cache, try, of_iterate=.true.)
    if (allocated(try%outcome%trouble%what)) then
      call settle_stalled(model, cache, state, try)
      try%outcome%settled = .false.
      return
    end if
    call find_change(model, cache, try, change, worst)
    try%iteration%worst = worst
    if (first .and. try%group%may_end_early) try%iteration%first_change = change
    try%outcome%settled = is_settled(model, cache, state, try, change, residual) &
                          .and. .not. (try%group%open_close%repeats_first_of_run .and. step_of_run(state) == 0 .and. first)
    if (try%group%in_contact) call judge(model, cache, state, try)
    if (.not. try%outcome%settled) call choose_operator(model, change, try)
  end subroutine improve

  !> Contacts at the prediction, and what their iteration begins with.
  !>
  !> Of the first step the prediction tells what closes. Later ones begin with contacts as the last step left them: most stay so.
  !> Where bodies turn, the first correction brings bodies along that move together, and leaves gaps between them that are of the
  !> second order and mean nothing; contacts are judged from the second on.
  subroutine begin_open_close(model, cache, state, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(inout) :: try

    associate (group => try%group, iteration => try%iteration)
      group%nested = model%settings%nested .and. .not. group%linear
      iteration%start_of_round = values_of_members(model, try)
      if (group%nested) then
        allocate (iteration%linearisation%term(size(group%member)))
        iteration%linearisation%at = iteration%start_of_round
      end if
      if (try%contacts%goes_on) then ! what only this try found closes where it would without a try before
        if (.not. group%linear) call place(model, cache, state, try%predicted, try%contacts)
        call meet_at_prediction(model, try%predicted, try%contacts)
      end if
      if (.not. group%linear) call place(model, cache, state, try%d, try%contacts)
      group%open_close = iteration_rules(try%contacts%law)
      group%open_close%linear_springs = group%open_close%linear_springs .and. .not. group%linear
      group%may_end_early = group%may_end_early .and. group%open_close%linear_springs .and. edges_stay(model, try%contacts)
      if (try%contacts%goes_on) then
        call judge_contacts(model, try%d, try%contacts)
        iteration%after_problem = .not. group%linear
      else if (group%open_close%judges_prediction .and. step_of_run(state) == 0) then
        call judge_prediction(model, try%d, try%contacts)
      else
        call meet_at_prediction(model, try%d, try%contacts)
        iteration%keeps_states = group%open_close%settles_always .and. .not. (group%linear .or. group%nested)
      end if
    end associate
  end subroutine begin_open_close

  !> Sums up the equations where the try is and contacts were measured; of the last linearisation, where contacts settle for that
  !> first.
  !>
  !> The operator of contacts keeps the symmetry of a secant. Not where the secant stays: the forces are then linear, and contacts
  !> need their exact changes to settle.
  subroutine assemble(model, cache, state, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(inout) :: try
    logical :: curved, symmetric

    call add_elements(model, cache, state, try)
    if (.not. try%group%in_contact) return
    associate (group => try%group, last => try%iteration%linearisation, tangent => try%rule%tangent)
      if (.not. last%frozen) try%iteration%reference = values_of_members(model, try)
      curved = model%settings%balance > 0 .or. (try%iteration%after_problem .and. tangent .and. group%open_close%linear_springs)
      curved = curved .and. .not. (last%frozen .or. group%linear)
      symmetric = last%symmetric .and. (tangent .or. .not. last%frozen) .and. .not. model%settings%balance > 0
      call add_pair_effects(model, try%contacts, group%number, symmetric, curved, cache%equations)
    end associate
  end subroutine assemble

  !> Solves for a correction and adds it to the displacement, of the secant the fraction that is asked for, mixed with those before.
  !>
  !> Among contacts it is as exact as these are judged, and rough where another one follows. Without them it is exact to round-off:
  !> what steps leave adds up in a body that turns for ever.
  subroutine correct(model, cache, try, residual)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(try_t), intent(inout) :: try
    real(dp), intent(out) :: residual             !! of the correction
    type(error_t), allocatable :: error
    integer :: e

    associate (group => try%group)
      call solve_equations(cache%equations, cache%timers, group%number, &
                           exactness_t(linear_tolerance(model), keeps_factor=.not. model%settings%shi, &
                                       by_balance=group%in_contact, roughly=try%iteration%likely_to_change), try%d, residual, error)
      try%outcome%solves = try%outcome%solves + 1
      if (.not. allocated(error)) then
        if ((model%settings%relaxation < 1 .or. model%settings%anderson > 0) &
            .and. .not. (group%linear .or. group%in_contact .or. try%rule%tangent)) &
          call mix(model, cache, group%member, try%iteration%mixing, try%d)
        return
      end if
      e = weakest_element(cache%equations, group%number)
    end associate
    call reject(try%outcome, cut_by_equations, error%message, 'a smaller step.size, and check density, E and fixed points there', &
                e, cache%element(max(1, e))%kinematics%centroid)
  end subroutine correct

  !> Judges the contacts after a correction, and rejects the try where they go round in circles. Those that keep their states wait
  !> for the next one, unless this one settles all.
  !>
  !> Where forces bend, a correction from the solution of a friction problem that changes any contact is no use: the iteration, once
  !> it has run in circles, does so again. The next problem follows at once, from where the last one ended. Where nothing changes
  !> anchors return before the deformation has settled, which would else settle once more for them.
  subroutine judge(model, cache, state, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(inout) :: try
    integer :: before(2, try%contacts%last - try%contacts%first + 1) !! states of their entrances before the judgement
    logical :: enough, waits

    associate (iteration => try%iteration, contacts => try%contacts, outcome => try%outcome, rules => try%group%open_close)
      waits = iteration%keeps_states .and. .not. outcome%settled
      iteration%keeps_states = .false.
      iteration%judged = .not. waits
      if (waits) then
        call place(model, cache, state, try%d, contacts)
        call measure_contacts(model, try%d, contacts)
        return
      end if
      before = states_of(contacts)
      if (try%group%nested) call judge_contacts(model, try%d, contacts)
      iteration%linearisation%frozen = try%group%nested .and. contacts%changes > 0
      if (.not. iteration%linearisation%frozen) call judge_at(model, cache, state, try)
      outcome%judged = reshape([outcome%judged, contacts%count, contacts%changes], [4, size(outcome%judged, 2) + 1])
      iteration%likely_to_change = contacts%changes > many_changes .and. rules%settles_always
      iteration%in_doubt = outcome%settled .and. contacts%changes > 0 .and. rules%settles_always
      if (wholly_held(cache%equations, try%group%number)) iteration%in_doubt = .false. ! supports balance any state
      if (contacts%changes == 0) then
        if (.not. outcome%settled) call return_anchors(model, try%d, contacts, enough)
        return
      end if
      outcome%settled = .false.
      iteration%first_change = 0.0_dp
    end associate
    call settle_circles(model, cache, state, before, try)
  end subroutine judge

  !> Lets contacts hold what has settled, by multipliers and where they closed; it is `held` where none changes by that.
  subroutine hold(model, try, held)
    type(model_t), intent(in) :: model
    type(try_t), intent(inout) :: try
    logical, intent(out) :: held

    call hold_contacts(model, try%d, try%contacts, held)
    if (held) call return_anchors(model, try%d, try%contacts, held)
    associate (iteration => try%iteration)
      call begin_round(iteration)
      iteration%rounds = 0
      iteration%fewest_tried = huge(1)
      iteration%by_secant = 0
      iteration%repeats = 0
      iteration%in_doubt = .false.
    end associate
  end subroutine hold

end module scree_settle
