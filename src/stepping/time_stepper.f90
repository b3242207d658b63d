!> One accepted step: large deformation outside (Zhang et al. 2019, Fig. 9).
module scree_time_stepper
  use scree_bolt, only: accept_bolts
  use scree_constraints, only: constraints_t, complete_unknowns
  use scree_contact_acceptance, only: accept_contacts, accept_no_contact
  use scree_contact_beginning, only: begin_again, begin_contacts, go_on_from
  use scree_contact_blame, only: blame_contact
  use scree_contact_detection, only: find_contacts
  use scree_contact_rules, only: goes_on_after_cut, settles_as_one, steps_decide_impacts
  use scree_body_search, only: draw_circles, list_all, move_circles, searches
  use scree_contact_search, only: predict_ways
  use scree_contact_try, only: contact_try_t, follow_motion
  use scree_contacts, only: blocks_of
  use scree_critical_step, only: find_largest_step
  use scree_effects, only: mean_share_of_weight, refresh_elements, work_of_ramp
  use scree_energy, only: close_books, loss_of_step
  use scree_equilibrium, only: balance_t, find_balance
  use scree_equations, only: constrain_equations, group_elements, has_no_pairs
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_bearings, only: any_closes, blow_of_step, blow_t, let_go
  use scree_impact, only: push_apart, rebound
  use scree_integrator, only: step_rule_for
  use scree_interruption, only: stop_signal
  use scree_islands, only: keep_factored, recall_factored
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_pair_effects, only: couples_pairs, list_coupled_pairs, list_pairs_of_bolts, order_contacts
  use scree_scene, only: scheme_central_difference
  use scree_settle, only: settle
  use scree_state, only: state_t
  use scree_step_prediction, only: predict
  use scree_step_checks, only: check_state, check_try
  use scree_step_constraints, only: constraints_of_step
  use scree_strain_choice, only: add_where_needed, choose_at_start, take_choice
  use scree_step_work, only: find_support_force, find_work
  use scree_step_try, only: begin_outcome, outcome_t, remedy_shorter, remedy_stiffer, remedy_wider, try_t
  use scree_text, only: rounded_text
  use scree_timers, only: begin_phase, phase_check, phase_restitution, phase_search, phase_update
  use scree_trouble, only: new_trouble, words_of
  use scree_update, only: update_state
  implicit none
  private
  public :: advance_by_solving, step_report_t

  !> Fraction of a step that did not settle (Zhang et al. 2019), and where Shi's rules choose the step.
  real(dp), parameter :: cut = 0.35_dp, shorter_cut = 0.3_dp
  !> And of one of a static run that chooses its steps: what bears the load is known to orders of magnitude alone.
  real(dp), parameter :: static_cut = 0.1_dp

  !> Systems that are solved in a try of a static step before it is tried with a shorter pseudo step, which takes 30 or so.
  integer, parameter :: enough_solves = 100

  !> What the search of a static step adds to ways and turns, over what is remembered: as much as that of the step before. A step
  !> that begins at rest goes as the square of its size under the same forces.
  real(dp), parameter :: kept = 2.0_dp

  !> What a step took, with what its tries came to.
  type, extends(outcome_t) :: step_report_t
    real(dp) :: dt = 0.0_dp              !! time
    integer :: refused = 0               !! steps made before it that were off by too much
    real(dp) :: travel = 0.0_dp          !! largest of a vertex, where a step may go only so far, length
    real(dp) :: work = 0.0_dp            !! of loads, ground and supports, force length per unit thickness
    real(dp) :: ramp = 0.0_dp            !! of what lets the weights grow, likewise
    real(dp) :: weight_share = 1.0_dp    !! of the weights that acted, on the mean
    type(blow_t) :: blow                 !! of what springs give back by chance
    type(balance_t), allocatable :: balance !! at its end, of a static step
    integer, allocatable :: reached(:)   !! blocks asleep that others may touch; allocated: they are to wake, no step was made
  end type step_report_t

contains

  !> Takes `state` to the end of one step of size `dt`, or a smaller one where that does not settle.
  !>
  !> A rejected try has changed nothing. Where a signal asks to stop after one, or in a friction problem, the state stays as it was.
  !> Errors: the step falls below its least size; fixed points contradict each other; a block is lost.
  subroutine advance_by_solving(model, dt, cache, state, report, error)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: dt                !! size to try, time
    type(cache_t), intent(inout) :: cache     !! of `state`, at the beginning and at the end
    type(state_t), intent(inout) :: state
    type(step_report_t), intent(out) :: report
    type(error_t), allocatable, intent(out) :: error
    type(try_t) :: try
    real(dp) :: work, supports

    call begin_step(model, cache, state, dt, try)
    tries: do
      call begin_outcome(try%outcome)
      call begin_try(model, cache, state, try, error)
      if (allocated(error)) return
      if (allocated(state%sleep) .and. size(try%contacts%contact) > 0) call find_sleepers(model, state, try, report%reached)
      if (allocated(report%reached)) return
      call settle_try(model, cache, state, try)
      if (try%outcome%settled) call check_try(model, cache, state, try)
      if (try%outcome%settled) call make_impact(model, cache, state, try)
      if (try%outcome%left) return
      if (try%outcome%settled) exit tries
      call mend(model, state, try, error)
      if (allocated(error)) return
      if (try%outcome%rejected > 0 .and. stop_signal() > 0) return
    end do tries
    call begin_phase(cache%timers, phase_update)
    call find_work(model, cache, state, try, work, supports)
    call find_support_force(model, try%dt, supports, state)
    report = step_report_t(outcome_t=try%outcome, dt=try%dt, travel=try%travel, work=work, &
                           ramp=work_of_ramp(model, cache, try%d, try%rule), &
                           weight_share=mean_share_of_weight(model, try%rule), blow=blow_of_try(model, cache, state, try))
    call accept(model, try, report%work + report%ramp, cache, state)
    call check_state(model, state, error)
    if (allocated(error) .or. .not. model%effects%is_static()) return
    allocate (report%balance)
    call find_balance(model, cache, try, state, report%balance, error)
  end subroutine advance_by_solving

  !> What the tries of a step begin with.
  subroutine begin_step(model, cache, state, dt, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    real(dp), intent(in) :: dt
    type(try_t), intent(out) :: try
    real(dp) :: largest
    integer :: e

    try%dt = dt
    try%pseudo = state%pace%pseudo
    if (model%settings%scheme == scheme_central_difference) then
      call find_largest_step(model, cache, largest, e)
      try%bound = min(largest, state%pace%bound) ! as it was, else steps would alternate with the stress that rings, and feed it
      try%dt = dt/(aint(dt/try%bound) + 1) ! evenly, as each change of an explicit step changes what rings in it
    end if
    if (allocated(model%effects%accuracy)) then
      call begin_phase(cache%timers, phase_check)
      call choose_at_start(model, cache, state, dt, try%green)
      call take_choice(model, try%green, cache)
    end if
    allocate (try%contacts%contact(0))
    allocate (try%contacts%pair(2, 0))
    if (.not. allocated(model%effects%contact)) return
    try%contacts%extra_reach = state%contacts%extra_reach
    try%contacts%extra_turn = state%contacts%extra_turn
    if (.not. (allocated(state%settling) .and. state%pace%last > 0)) return
    call look_farther(kept*(dt/state%pace%last)**2, try)
  end subroutine begin_step

  !> Lets a try look for contacts so many times as far beyond what velocities make.
  subroutine look_farther(times, try)
    real(dp), intent(in) :: times
    type(try_t), intent(inout) :: try

    try%contacts%extra_reach = times*try%contacts%extra_reach
    try%contacts%extra_turn = times*try%contacts%extra_turn
  end subroutine look_farther

  !> Weights of the step, who may touch, constraints and prediction.
  subroutine begin_try(model, cache, state, try, error)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(inout) :: try
    type(error_t), allocatable, intent(out) :: error
    type(constraints_t) :: constraints

    call begin_phase(cache%timers, phase_search)
    try%rule = step_rule_for(model%settings, state%step, state%time, state%pace%last, try%dt)
    if (try%pseudo < try%dt) try%rule%inertia_weight = try%rule%inertia_weight*(try%dt/try%pseudo)**2
    try%most_solves = huge(1)
    if (model%pseudo_step < min(try%pseudo, try%dt)) try%most_solves = try%outcome%solves + enough_solves
    try%remedy = remedy_shorter
    try%shorter = merge(shorter_cut, cut, model%settings%chooses_step)
    if (allocated(state%settling)) try%shorter = static_cut
    if (try%outcome%rejected > 0 .and. goes_on_after_cut(try%contacts%law)) then
      call begin_again(try%rule, try%contacts)
    else
      call begin_pairs(model, cache, state, try)
    end if
    call constraints_of_step(model, cache, state, state%time + try%dt, constraints, error)
    if (allocated(error)) return
    call constrain_equations(cache%equations, constraints)
    call recall_factored(cache%equations, state%factored)
    call predict(model, cache, state, try%rule, try%contacts%pair, try%predicted, try%smooth)
    call complete_unknowns(constraints, try%predicted, homogeneous=.false.)
    if (.not. try%contacts%goes_on) try%d = try%predicted
  end subroutine begin_try

  !> Contacts of a try, and all pairs of elements that something acts between.
  subroutine begin_pairs(model, cache, state, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(inout) :: try
    type(contact_try_t) :: before !! contacts of the try before
    logical :: one_island, touching

    if (.not. couples_pairs(model)) return
    touching = .false.
    one_island = .false.
    if (allocated(model%effects%contact)) then
      touching = may_touch(model, cache, state, try)
      one_island = settles_as_one(model%effects%contact)
    end if
    if (touching) then
      if (try%contacts%goes_on) before = try%contacts
      call look_for_contacts(model, cache, state, try)
      call list_coupled_pairs(model, state, try%contacts)
    else
      if (.not. allocated(model%effects%bolt) .and. has_no_pairs(cache%equations)) return
      call list_pairs_of_bolts(model, try%contacts%pair)
    end if
    call group_elements(model%elements, try%contacts%pair, one_island, cache%equations)
    if (.not. touching) return
    call order_contacts(cache%equations, try%contacts)
    call begin_contacts(model, cache, state, try%rule, try%contacts)
    if (try%contacts%goes_on) call go_on_from(before, size(model%outlines%start), try%contacts)
  end subroutine begin_pairs

  !> Whether any bodies are near each other in a try, or have been in the step before.
  logical function may_touch(model, cache, state, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(in) :: try
    logical :: drawn

    may_touch = .true.
    if (.not. searches(model)) return
    call draw_circles(model, state, try%dt, try%contacts%extra_reach, cache%search%bodies, drawn, try%contacts%jumped)
    if (drawn .and. allocated(cache%search%found_at)) deallocate (cache%search%found_at)
    may_touch = size(cache%search%bodies%vertex) > 0 .or. size(state%contacts%contact) > 0
  end function may_touch

  !> Finds the contacts of a try.
  subroutine look_for_contacts(model, cache, state, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(inout) :: try
    real(dp) :: predicted(2, size(model%outlines%start))

    if (.not. try%contacts%looked) then
      try%contacts%looked = .true.
      try%contacts%law = model%effects%contact
      try%contacts%law%normal_stiffness = state%contacts%stiffness(1)
      try%contacts%law%shear_stiffness = state%contacts%stiffness(2)
    end if
    if (.not. allocated(cache%search%bodies%vertex)) call list_all(model%outlines, cache%search%bodies)
    call predict_ways(model, cache, state, try%dt, try%contacts, cache%search%bodies%farther, predicted)
    call find_contacts(model%outlines, state%vertex, predicted, model%n_elements > model%n_blocks, state%contacts, cache%search, &
                       try%contacts)
  end subroutine look_for_contacts

  !> Lists the blocks that sleep and that contacts of a try reach; not allocated where there are none.
  pure subroutine find_sleepers(model, state, try, reached)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(try_t), intent(in) :: try
    integer, allocatable, intent(out) :: reached(:)
    integer :: blocks(2*size(try%contacts%contact)), i

    do i = 1, size(try%contacts%contact)
      blocks(2*i - 1:2*i) = blocks_of(model%outlines, try%contacts%contact(i)%entrance(1))
    end do
    if (any(state%sleep%island(blocks) > 0)) reached = pack(blocks, state%sleep%island(blocks) > 0)
  end subroutine find_sleepers

  !> Settles a try, and what small strain turns out not to be enough for once more.
  subroutine settle_try(model, cache, state, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(inout) :: try
    logical, allocatable :: among(:) !! (n_elements) groups with some of these are settled; not allocated: all
    logical :: found

    if (allocated(try%impact%among)) among = try%impact%among
    do
      call settle(model, cache, state, try, among)
      call begin_phase(cache%timers, phase_check)
      if (.not. (try%outcome%settled .and. allocated(try%green))) return
      call add_where_needed(model, cache, try%contacts%pair, try%d, try%green, found)
      if (.not. found) return
      among = spread(.false., 1, model%n_elements)
      associate (free => model%elements%free)
        among(free) = try%green .and. .not. cache%element(free)%green
      end associate
      call take_choice(model, try%green, cache)
      call follow_motion(try%contacts)
    end do
  end subroutine settle_try

  !> Whether impacts of a try that settled are not left to springs, and any contact is closed.
  pure logical function has_restitution(model, contacts)
    type(model_t), intent(in) :: model
    type(contact_try_t), intent(in) :: contacts

    has_restitution = .false.
    if (.not. allocated(model%effects%contact)) return
    has_restitution = model%effects%contact%restitution >= 0 .and. any(contacts%count(2:) > 0)
  end function has_restitution

  !> What strikes in an accepted try and springs give back of by chance: nothing with restitution.
  pure type(blow_t) function blow_of_try(model, cache, state, try) result(blow)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(in) :: try

    if (.not. allocated(model%effects%contact) .or. model%effects%is_static()) return
    if (model%effects%contact%restitution >= 0 .or. .not. steps_decide_impacts(try%contacts%law)) return
    blow = blow_of_step(model, cache, state, try%rule, try%d, try%contacts)
  end function blow_of_try

  !> Makes the step once more where bodies came together in it, with their impact. Where that outruns the search the try has not
  !> settled, and asks for a wider one.
  subroutine make_impact(model, cache, state, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(inout) :: try
    type(try_t) :: again
    type(state_t) :: pushed
    logical :: possible

    if (.not. has_restitution(model, try%contacts)) return
    call let_go(model, state, try%rule, try%contacts)
    if (.not. any_closes(try%contacts)) return
    call begin_phase(cache%timers, phase_restitution)
    again = try
    again%smooth = .false.
    call push_apart(model, cache, state, try%rule, try%d, again%contacts, again%impact)
    if (size(again%impact%bearing) == 0) then
      call tell_of_impact(model, state, again, try)
      return
    end if
    pushed = state
    pushed%velocity = pushed%velocity + again%impact%push
    call settle_try(model, cache, pushed, again)
    if (again%outcome%settled) call check_try(model, cache, pushed, again)
    call begin_phase(cache%timers, phase_restitution)
    possible = again%outcome%settled
    try%outcome%settled = possible .or. again%remedy /= remedy_wider
    if (.not. try%outcome%settled) then
      try%remedy = remedy_wider
      try%contacts%extra_reach = again%contacts%extra_reach
      try%contacts%extra_turn = again%contacts%extra_turn
      if (allocated(again%contacts%jumped)) try%contacts%jumped = again%contacts%jumped
    else if (.not. possible) then
      try%outcome%impact = again%outcome%trouble
    end if
    if (possible) &
      call rebound(model, cache, state, try%rule, again%d, again%contacts, again%impact, possible)
    if (possible) then
      try = again
    else
      try%outcome%left = again%outcome%left
      try%outcome%solves = again%outcome%solves
      try%outcome%judged = again%outcome%judged
      if (allocated(try%green)) call take_choice(model, try%green, cache)
    end if
    call tell_of_impact(model, state, again, try)
  end subroutine make_impact

  !> Tells of an impact whose impulses were not found, which is left to springs, and of impacts that were made as one.
  subroutine tell_of_impact(model, state, again, try)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(try_t), intent(in) :: again             !! the try with the impact
    type(try_t), intent(inout) :: try

    if (again%impact%cut_short > 0) then
      try%outcome%as_one = new_trouble('so many impacts follow each other in a step that the last are made as one', &
                                       'a smaller step.size')
      call blame_contact(model, state, again%contacts%contact(again%impact%cut_short), try%outcome%as_one)
    end if
    if (again%impact%unsolved == 0) return
    try%outcome%impact = new_trouble('bodies jam, and impulses that part them were not found', &
                                     'a smaller step.size, or less friction')
    call blame_contact(model, state, again%contacts%contact(again%impact%unsolved), try%outcome%impact)
  end subroutine tell_of_impact

  !> Makes the next try shorter, where that is what the rejected one asks for; of a static step first its pseudo step.
  !>
  !> Errors: the step falls below its least size.
  subroutine mend(model, state, try, error)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(try_t), intent(inout) :: try
    type(error_t), allocatable, intent(out) :: error

    if (try%remedy == remedy_wider) return ! nothing that the step did was wrong
    try%outcome%rejected = try%outcome%rejected + 1
    try%outcome%cut = try%outcome%trouble
    try%outcome%cuts(try%outcome%reason) = try%outcome%cuts(try%outcome%reason) + 1
    if (try%remedy == remedy_stiffer) return
    if (try%most_solves < huge(1)) then
      try%pseudo = model%pseudo_step
    else
      try%dt = try%shorter*try%dt
    end if
    if (allocated(state%settling)) call look_farther(try%shorter**2, try)
    try%contacts%goes_on = .false.
    if (allocated(try%contacts%jumped)) deallocate (try%contacts%jumped)
    if (try%dt < model%settings%least_step) &
      call fail(error, status_run_failed, words_of(try%outcome%trouble, model, 'the step size fell below step.least, '// &
                                                   rounded_text(model%settings%least_step)))
  end subroutine mend

  !> Moves the state to the end of the step, and books its energy.
  subroutine accept(model, try, work, cache, state)
    type(model_t), intent(in) :: model
    type(try_t), intent(inout) :: try
    real(dp), intent(in) :: work            !! of loads, ground and supports in the step, force length per unit thickness
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(inout) :: state
    real(dp) :: fracture, friction

    state%pace%bound = try%bound
    state%pace%pseudo = try%pseudo
    state%books%work = state%books%work + work
    state%books%damping = state%books%damping + loss_of_step(model, cache, state, try%rule, try%d)
    if (allocated(model%effects%contact)) then
      if (try%contacts%looked) then
        call accept_contacts(model, try%d, try%contacts, state%contacts, state%books%contact_springs, friction, &
                             fracture)
        state%books%fracture = state%books%fracture + fracture
        state%books%friction = state%books%friction + friction + try%impact%friction
      else
        call accept_no_contact(try%contacts, state%contacts)
      end if
      if (searches(model)) &
        call move_circles(model, try%dt, try%contacts%extra_reach, try%d, &
                          try%contacts%all_clear .and. .not. allocated(try%impact%push), cache%search%bodies)
    end if
    if (size(try%contacts%pair) > 0 .or. size(state%pair) > 0) state%pair = try%contacts%pair
    if (allocated(try%green)) state%green(model%elements%free) = try%green
    call keep_factored(cache%equations, state%factored)
    call update_state(model, cache, try%rule, try%d, try%impact, state)
    if (allocated(state%bolts)) call accept_bolts(model%effects%bolt, state%point, state%bolts, state%books%yield)
    call refresh_elements(model, state, cache)
    call close_books(model, cache, state)
  end subroutine accept

end module scree_time_stepper
