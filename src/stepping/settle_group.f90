!> Elements that are settled together in a step: what kind of equations they have and add to, and whether they are there.
module scree_settle_group
  use scree_effects, only: add_element_effects, has_fixed_point
  use scree_element_term, only: step_rule_t, term_t
  use scree_equations, only: add_equations, begin_equations, out_of_balance, share_out_of_balance
  use scree_integrator, only: turns_acceleration
  use scree_interpolation, only: kinematics_t
  use scree_iteration, only: element_group_t, iteration_t
  use scree_iteration_end, only: leaves_little, leaves_nothing
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_pair_effects, only: add_bolts, is_bolted
  use scree_scene, only: iterate_hybrid, iterate_newton, test_residual
  use scree_state, only: state_t
  use scree_step_prediction, only: turns_unstrained
  use scree_step_try, only: try_t
  use scree_system, only: values_of
  implicit none
  private
  public :: add_elements, balances, begin_round, begins_far, change_of, choose_operator, count_stalled, find_change, is_balanced, &
            is_settled, linear_tolerance, settles_by_residual, tell_kind, values_of_members

  !> The hybrid method turns from secant to tangent when theta changes by less in an iteration.
  real(dp), parameter :: near_solution = 0.05_dp
  !> A residual below this fraction of what cancelled in it is round-off, whatever the tolerance.
  real(dp), parameter :: round_off = 50*epsilon(1.0_dp)
  !> Largest force out of balance over the largest that balances, above which a step is taken to begin far from its solution.
  real(dp), parameter :: far_share = 1e-3_dp
  !> Forces that judgement leaves out of balance on an element, over all that balance on it: less is none.
  real(dp), parameter, public :: accepted_share = 1e-8_dp

contains

  !> Tells whether the forces of a group are linear, what its iterates may be, the operator that it begins with, and whether its end
  !> may leave a fraction of what the step is off by. Not so of what nothing holds, which keeps its momentum and energy.
  pure subroutine tell_kind(model, cache, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(try_t), intent(inout) :: try             !! with its prediction

    associate (group => try%group, settings => model%settings)
      if (allocated(try%smooth)) group%smooth = all(try%smooth(group%member))
      group%linear = .not. any(cache%element(group%member)%green)
      group%linear = group%linear .or. .not. (try%rule%end_weight > 0 .or. group%in_contact)
      group%bolted = is_bolted(model, group%member)
      group%linear = group%linear .and. .not. group%bolted ! its axis turns
      group%may_stray = model%effects%is_static() .and. .not. group%in_contact
      group%may_end_early = group%smooth .and. turns_acceleration(settings) &
                            .and. (has_fixed_point(model, group%member) .or. group%in_contact) .and. .not. group%bolted
      try%rule%tangent = settings%iterate == iterate_newton
      if (settings%iterate == iterate_hybrid) &
        try%rule%tangent = turns_unstrained(model, cache, group%member, try%d, try%rule, group%smooth)
    end associate
  end subroutine tell_kind

  !> Begins the equations with what the elements add, and the bolts between them; by the linearisation that stays, or another one.
  subroutine add_elements(model, cache, state, try, by_secant)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(inout) :: try
    logical, intent(in), optional :: by_secant    !! whatever the operator of the iteration is
    type(step_rule_t) :: rule
    type(term_t) :: term
    real(dp) :: unknown(size(model%elements%unknown, 1))
    logical :: beside !! the iteration: its linearisation stays what it is
    integer :: k

    beside = .false.
    if (present(by_secant)) beside = by_secant
    rule = try%rule
    rule%tangent = rule%tangent .and. .not. beside
    call begin_equations(cache%equations, try%group%number)
    associate (group => try%group, last => try%iteration%linearisation)
      if (.not. (last%frozen .or. beside)) last%symmetric = .true.
      do k = 1, size(group%member)
        associate (e => group%member(k))
          unknown = values_of(model%elements, e, try%d)
          if (last%frozen .and. .not. beside) then
            term = last%term(k)
            term%force = term%force - matmul(term%matrix, unknown - last%at(:, k))
          else
            call add_element_effects(model, cache%element(e), state, e, unknown, rule, term)
            if (.not. beside) last%symmetric = last%symmetric .and. term%symmetric
            if (group%nested .and. .not. beside) then
              last%term(k) = term
              last%at(:, k) = unknown
            end if
          end if
          call add_equations(cache%equations, group%number, k, cache%element(e)%kinematics%span, term)
        end associate
      end do
    end associate
    if (try%group%bolted) call add_bolts(model, state, try%group%number, rule, try%d, cache)
  end subroutine add_elements

  !> Displacements of the unknowns of a group's elements.
  pure function values_of_members(model, try) result(values)
    type(model_t), intent(in) :: model
    type(try_t), intent(in) :: try
    real(dp) :: values(size(model%elements%unknown, 1), size(try%group%member))
    integer :: k

    do k = 1, size(try%group%member)
      values(:, k) = values_of(model%elements, try%group%member(k), try%d)
    end do
  end function values_of_members

  !> The hybrid method takes the tangent after a small change of theta, else the secant.
  pure subroutine choose_operator(model, change, try)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: change
    type(try_t), intent(inout) :: try

    if (model%settings%iterate == iterate_hybrid .and. .not. try%iteration%linearisation%frozen) &
      try%rule%tangent = change < near_solution
  end subroutine choose_operator

  !> Begins to count anew how judgements get on, where the problem that contacts settle for is another.
  pure subroutine begin_round(iteration)
    type(iteration_t), intent(inout) :: iteration

    iteration%stalled = 0
    iteration%fewest_changes = huge(1)
  end subroutine begin_round

  !> Counts the judgements that do not change fewer states than all before them, and keeps where that did which changed fewest.
  pure subroutine count_stalled(model, try)
    type(model_t), intent(in) :: model
    type(try_t), intent(inout) :: try             !! whose contacts were judged where its displacement is

    associate (iteration => try%iteration)
      if (try%contacts%changes < iteration%fewest_changes .and. try%group%open_close%counts_progress) then
        iteration%fewest_changes = try%contacts%changes
        iteration%best = values_of_members(model, try)
      else
        iteration%stalled = iteration%stalled + 1
      end if
    end associate
  end subroutine count_stalled

  !> Whether so much is out of balance where an iteration begins that contacts are likely to change.
  pure logical function begins_far(cache, group)
    type(cache_t), intent(in) :: cache
    type(element_group_t), intent(in) :: group
    real(dp) :: balance(2)

    begins_far = .false.
    if (.not. (group%in_contact .and. group%linear .and. group%open_close%settles_always)) return
    balance = out_of_balance(cache%equations, group%number)
    begins_far = balance(1) > far_share
  end function begins_far

  !> Whether the balance of forces tells that an iteration has settled; with small strain the residual of the correction does.
  pure logical function settles_by_residual(model, group)
    type(model_t), intent(in) :: model
    type(element_group_t), intent(in) :: group

    settles_by_residual = model%settings%test == test_residual .and. .not. group%linear
  end function settles_by_residual

  !> Whether the forces of a group balance.
  pure logical function is_balanced(model, cache, number)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    integer, intent(in) :: number                 !! of the group
    real(dp) :: balance(2)

    balance = out_of_balance(cache%equations, number)
    is_balanced = balance(1) <= model%settings%tolerance .or. balance(2) <= round_off
  end function is_balanced

  !> Whether the balance of forces says that a group has settled: not where contacts changed as they were judged there.
  pure logical function balances(model, cache, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(try_t), intent(in) :: try

    balances = .false.
    if (try%iteration%in_doubt) balances = share_out_of_balance(cache%equations, try%group%number) <= accepted_share
    if (balances .or. .not. settles_by_residual(model, try%group)) return
    balances = is_balanced(model, cache, try%group%number)
    if (try%group%in_contact .and. try%iteration%judged) balances = balances .and. try%contacts%changes == 0
  end function balances

  !> Whether the deformation has settled, by its last change or what that leaves, or with small strain by the residual.
  pure logical function is_settled(model, cache, state, try, change, residual)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state !! at the beginning of the step
    type(try_t), intent(in) :: try   !! after the correction
    real(dp), intent(in) :: change   !! of theta, by the correction
    real(dp), intent(in) :: residual !! of the correction

    if (try%group%linear) then
      is_settled = residual <= linear_tolerance(model)
    else
      is_settled = change < model%settings%tolerance
      if (try%rule%tangent .and. .not. try%iteration%linearisation%frozen) then
        if (.not. model%effects%is_static() .and. .not. is_settled) is_settled = leaves_nothing(model, cache, try, change)
        if (try%iteration%first_change > 0 .and. .not. is_settled) is_settled = leaves_little(model, cache, state, try, change)
      end if
      is_settled = is_settled .and. model%settings%test /= test_residual .and. residual <= linear_tolerance(model)
    end if
  end function is_settled

  !> What corrections are solved to: as exactly as the iteration is to settle.
  pure real(dp) function linear_tolerance(model)
    type(model_t), intent(in) :: model

    linear_tolerance = max(model%settings%tolerance, round_off)
  end function linear_tolerance

  !> Largest component of theta that unknowns make; where forces follow positions, of the displacement over the size too.
  pure real(dp) function change_of(element, unknown, with_position) result(change)
    type(kinematics_t), intent(in) :: element
    real(dp), intent(in) :: unknown(:)       !! (n)
    logical, intent(in) :: with_position

    change = maxval(abs(matmul(element%gradient, unknown)))
    if (with_position) change = max(change, maxval(abs(matmul(element%at_centroid, unknown)))/element%size)
  end function change_of

  !> Largest change of a component of theta since the last linearisation or problem, and its element; where bodies touch or are
  !> bolted, of the position over the size too.
  pure subroutine find_change(model, cache, try, change, element)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(try_t), intent(in) :: try
    real(dp), intent(out) :: change
    integer, intent(out) :: element
    real(dp) :: moved(size(model%elements%unknown, 1)), own
    integer :: k

    change = 0.0_dp
    element = try%group%member(1)
    associate (group => try%group)
      do k = 1, size(group%member)
        associate (ids => model%elements%unknown(:, group%member(k)), kinematics => cache%element(group%member(k))%kinematics)
          moved = cache%equations%correction(ids)
          if (group%in_contact) moved = try%d(ids) - try%iteration%reference(:, k)
          own = change_of(kinematics, moved, group%in_contact .or. group%bolted)
          if (own <= change) cycle
          change = own
          element = group%member(k)
        end associate
      end do
    end associate
  end subroutine find_change

end module scree_settle_group
