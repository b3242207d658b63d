!> Elements that are settled together in a step: what kind of equations they have, how far they are, and whether they are there.
module scree_settle_group
  use scree_anderson, only: anderson_t
  use scree_contact_rules, only: iteration_rules_t
  use scree_contact_try, only: contact_try_t
  use scree_effects, only: add_element_effects, has_fixed_point
  use scree_element_term, only: step_rule_t, term_t
  use scree_equations, only: add_equations, begin_equations, out_of_balance, share_out_of_balance
  use scree_flickering, only: flickering_t
  use scree_integrator, only: turns_acceleration
  use scree_interpolation, only: kinematics_t
  use scree_iteration_end, only: leaves_little, leaves_nothing
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_pair_effects, only: add_bolts, is_bolted
  use scree_scene, only: iterate_hybrid, iterate_newton, test_residual
  use scree_state, only: state_t
  use scree_step_prediction, only: turns_unstrained
  use scree_system, only: values_of
  implicit none
  private
  public :: add_elements, balances, begin_round, begins_far, change_of, choose_operator, count_stalled, find_change, group_t, &
            is_balanced, is_settled, linear_tolerance, settles_by_residual, tell_kind, values_of_members

  !> The hybrid method turns from secant to tangent when theta changes by less in an iteration.
  real(dp), parameter, public :: near_solution = 0.05_dp
  !> A residual below this share of what cancelled in it is round-off, whatever the tolerance.
  real(dp), parameter :: round_off = 50*epsilon(1.0_dp)
  !> Largest force out of balance over the largest that balances, above which a step is taken to begin far from its solution.
  real(dp), parameter :: far_share = 1e-3_dp
  !> Forces that judgement leaves out of balance on an element, over all that balance on it: less is none.
  real(dp), parameter, public :: accepted_share = 1e-8_dp

  !> Elements that are settled together, and how far they are.
  type :: group_t
    integer :: number = 0                     !! among the groups of the equations
    integer, allocatable :: member(:)         !! elements
    type(step_rule_t) :: rule
    logical :: linear = .true.                !! forces and gaps are linear in displacements: small strain alone, or explicit
    logical :: in_contact = .false.
    logical :: bolted = .false.
    logical :: smooth = .false.               !! they begin with their acceleration
    logical :: may_leave = .false.            !! a share of what the step is off by
    real(dp) :: first = 0.0_dp                !! of those that may, what the first correction changed theta by; 0: no longer
    logical :: strays = .false.               !! iterates may leave what areas may change by, as nothing hangs on them but the next
    type(iteration_rules_t) :: open_close     !! how contacts are judged
    logical :: nested = .false.               !! contacts settle for each operator of the deformation
    logical :: symmetric = .true.             !! the elements' operator is
    logical :: frozen = .false.               !! they have not yet: the operator stays
    type(term_t), allocatable :: term(:)      !! of the members at the last linearisation, where it may stay
    real(dp), allocatable :: linear_at(:, :)  !! (n, n_members) displacement then
    real(dp), allocatable :: began_at(:, :)   !! (n, n_members) and that from which changes are measured
    type(flickering_t) :: flickering          !! contacts that go on changing
    logical :: keeps_states = .false.         !! contacts are not judged after the first correction, as bodies turn
    integer :: fewest = huge(1), stalled = 0  !! changes of states, and iterations since that got fewer
    real(dp), allocatable :: best(:, :)       !! (n, n_members) displacement at which these were judged
    integer :: tried = huge(1)                !! fewest changes from which a path was followed
    real(dp), allocatable :: sound(:, :)      !! (n, n_members) displacement that the iteration, or its last round, began with
    logical :: near = .false.                 !! to the solution: a friction problem ended there
    integer :: rounds = 0                     !! friction problems that were solved
    integer :: repeats = 0                    !! of these, that moved nothing
    logical :: far = .false.                  !! from the solution: contacts changed, or are likely to
    type(anderson_t) :: mixing                !! of corrections by the secant
    logical :: in_doubt = .false.             !! all has settled but for contacts that the judgement changed
  end type group_t

contains

  !> Tells whether the forces of a group are linear, what its iterates may be, the operator that it begins with, and whether its end
  !> may leave a share of what the step is off by. Not so of what nothing holds, which keeps its momentum and energy.
  pure subroutine tell_kind(model, cache, d, smooth, group)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    real(dp), intent(in) :: d(:)                  !! (n_unknowns) prediction
    logical, intent(in), optional :: smooth(:)    !! (n_elements) they begin with their acceleration; none where absent
    type(group_t), intent(inout) :: group

    if (present(smooth)) group%smooth = all(smooth(group%member))
    group%linear = .not. any(cache%element(group%member)%green)
    group%linear = group%linear .or. .not. (group%rule%end_weight > 0 .or. group%in_contact)
    group%bolted = is_bolted(model, group%member)
    group%linear = group%linear .and. .not. group%bolted ! its axis turns
    group%strays = .not. (model%effects%carried > 0 .or. group%in_contact)
    group%may_leave = group%smooth .and. turns_acceleration(model%settings) &
                      .and. (has_fixed_point(model, group%member) .or. group%in_contact) .and. .not. group%bolted
    group%rule%tangent = model%settings%iterate == iterate_newton
    if (model%settings%iterate == iterate_hybrid) &
      group%rule%tangent = turns_unstrained(model, cache, group%member, d, group%rule, group%smooth)
  end subroutine tell_kind

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
    if (group%bolted) call add_bolts(model, state, group%number, group%rule, d, cache)
  end subroutine add_elements

  !> Displacements of the unknowns of a group's elements.
  pure function values_of_members(model, group, d) result(values)
    type(model_t), intent(in) :: model
    type(group_t), intent(in) :: group
    real(dp), intent(in) :: d(:)                  !! (n_unknowns)
    real(dp) :: values(size(model%elements%unknown, 1), size(group%member))
    integer :: k

    do k = 1, size(group%member)
      values(:, k) = values_of(model%elements, group%member(k), d)
    end do
  end function values_of_members

  !> The hybrid method takes the tangent after a small change of theta, else the secant.
  pure subroutine choose_operator(model, change, group)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: change
    type(group_t), intent(inout) :: group

    if (model%settings%iterate == iterate_hybrid .and. .not. group%frozen) group%rule%tangent = change < near_solution
  end subroutine choose_operator

  !> Begins to count anew how judgements get on, where the problem that contacts settle for is another.
  pure subroutine begin_round(group)
    type(group_t), intent(inout) :: group

    group%stalled = 0
    group%fewest = huge(1)
  end subroutine begin_round

  !> Counts the judgements that do not change fewer states than all before them, and keeps where that did which changed fewest.
  pure subroutine count_stalled(model, d, changes, group)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: d(:)   !! (n_unknowns)
    integer, intent(in) :: changes !! of states, in the judgement at `d`
    type(group_t), intent(inout) :: group

    if (changes < group%fewest .and. group%open_close%counts_progress) then
      group%fewest = changes
      group%best = values_of_members(model, group, d)
    else
      group%stalled = group%stalled + 1
    end if
  end subroutine count_stalled

  !> Whether so much is out of balance where an iteration begins that contacts are likely to change.
  pure logical function begins_far(cache, group)
    type(cache_t), intent(in) :: cache
    type(group_t), intent(in) :: group
    real(dp) :: balance(2)

    begins_far = .false.
    if (.not. (group%in_contact .and. group%linear .and. group%open_close%settles_always)) return
    balance = out_of_balance(cache%equations, group%number)
    begins_far = balance(1) > far_share
  end function begins_far

  !> Whether the balance of forces tells that an iteration has settled; with small strain the residual of the correction does.
  pure logical function settles_by_residual(model, group)
    type(model_t), intent(in) :: model
    type(group_t), intent(in) :: group

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

  !> Whether the balance of forces at `d` says that the group has settled.
  pure logical function balances(model, cache, group, changed)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(group_t), intent(in) :: group
    logical, intent(in) :: changed                !! contacts changed where they were judged at `d`

    balances = .false.
    if (group%in_doubt) balances = share_out_of_balance(cache%equations, group%number) <= accepted_share
    if (balances .or. .not. settles_by_residual(model, group)) return
    balances = is_balanced(model, cache, group%number) .and. .not. changed
  end function balances

  !> Whether the deformation has settled, by its last change or what that leaves, or with small strain by the residual.
  pure logical function is_settled(model, cache, group, d, change, residual)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(group_t), intent(in) :: group
    real(dp), intent(in) :: d(:)     !! (n_unknowns) after the correction
    real(dp), intent(in) :: change   !! of theta, by the correction
    real(dp), intent(in) :: residual !! of the correction

    if (group%linear) then
      is_settled = residual <= linear_tolerance(model)
    else
      is_settled = change < model%settings%tolerance
      if (group%rule%tangent .and. model%effects%carried > 0 .and. .not. (is_settled .or. group%frozen)) &
        is_settled = leaves_nothing(model%settings%tolerance, cache, group%member, group%rule, change, &
                                    group%in_contact .or. group%bolted)
      if (group%rule%tangent .and. group%first > 0 .and. .not. (is_settled .or. group%frozen)) &
        is_settled = leaves_little(model, cache, group%member, group%rule, d, change, group%first, &
                                   group%in_contact)
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
    if (with_position) change = max(change, maxval(abs(matmul(element%at_centroid, unknown)))/sqrt(element%area))
  end function change_of

  !> Largest change of a component of theta since the last linearisation or problem, and its element; where bodies touch or are
  !> bolted, of the position over the size too.
  pure subroutine find_change(model, cache, group, d, change, element)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(group_t), intent(in) :: group
    real(dp), intent(in) :: d(:)
    real(dp), intent(out) :: change
    integer, intent(out) :: element
    real(dp) :: moved(size(model%elements%unknown, 1)), own
    integer :: k

    change = 0.0_dp
    element = group%member(1)
    do k = 1, size(group%member)
      associate (ids => model%elements%unknown(:, group%member(k)), kinematics => cache%element(group%member(k))%kinematics)
        moved = cache%equations%correction(ids)
        if (group%in_contact) moved = d(ids) - group%began_at(:, k)
        own = change_of(kinematics, moved, group%in_contact .or. group%bolted)
        if (own <= change) cycle
        change = own
        element = group%member(k)
      end associate
    end do
  end subroutine find_change

end module scree_settle_group
