!> The open-close iteration: which contacts are open, sliding or locked (Shi's df22).
!>
!> Every iteration solves for the states of the one before and then judges all states anew (a semi-smooth Newton iteration), each
!> contact by the rules of the scene (`contact_rules`). Only `accept_contacts` keeps what an iteration has found. If contacts have
!> multipliers, `hold_contacts` lets them follow the forces of the springs until no overlap above a bound is left. Changes that make
!> forces jump wait until all states have settled: `return_anchors`, `break_bonds`, `follow_stress`.
module scree_open_close
  use scree_anderson, only: mix_step
  use scree_bond_rules, only: bond, damage_after, softens_in_tension
  use scree_contact_quantities, only: contact_force_t, entrance_start_t, gap_and_slip_t
  use scree_contact_rules, only: anchor_what_closes, decides_outside, force_to_hold, forgives_faint_forces, gaps_and_slips, &
                                 judge, measure_again, measure_contact, measure_contacts, press, press_across, pressing_of, &
                                 put_anchors
  use scree_contact_try, only: contact_try_t, elements_of, most_softenings, row_across
  use scree_contacts, only: blocks_of, contact_law_t, count_states, entrance_t, state_locked, state_open, state_sliding
  use scree_coulomb_contact, only: act_on
  use scree_joint_rules, only: friction_of, joints_follow_stress, joints_soften
  use scree_joint_stiffness, only: is_hard
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: break_bonds, follow_stress, hold_contacts, judge_contacts, judge_prediction, keep_lines, meet_at_prediction, &
            return_anchors

  !> A force changes no state if it is below this ratio to the largest force on a body: its weight or the force of a contact. Of the
  !> two bodies of a contact, the one with the smaller force decides.
  real(dp), parameter :: relative_tolerance = 1e-8_dp
  !> A force caused by rounding of coordinates changes no state either. This tolerance is capped at this ratio to the same force,
  !> because small bodies would otherwise never change state.
  real(dp), parameter :: rounding_cap = 1e-3_dp
  !> Ratio of the overlaps before and after an update of multipliers above which springs become harder, and the factor of stiffness.
  real(dp), parameter :: shrinking = 0.75_dp, harder = 10.0_dp
  !> Bonds break together if they exceed their strength by more than this ratio to the worst excess. The ratio is about a half, and
  !> no ratio of small numbers, because the loads of equal blocks often have such ratios.
  real(dp), parameter :: of_the_worst = 0.53_dp
  !> Change of the damage of a bond below which it counts as the same.
  real(dp), parameter :: same_damage = 1e-6_dp
  !> Rounds of the damage of bonds from which the next one is extrapolated.
  integer, parameter :: rounds_mixed = 5
  !> Relative change of friction below which it counts as the same.
  real(dp), parameter :: same_friction = 1e-6_dp
  !> A change of a gap below this ratio to the terms that cancel in it is round-off.
  real(dp), parameter :: round_off = 8*epsilon(1.0_dp)

contains

  !> Judges the contacts that are settled together at `d`; `try%changes` counts states that change by more than a negligible force.
  pure subroutine judge_contacts(model, d, try)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    type(contact_try_t), intent(inout) :: try
    type(contact_force_t) :: force(try%first:try%last)
    real(dp) :: before(2)
    integer :: i

    call press_all(model, d, try, force)
    try%changes = 0
    do i = try%first, try%last
      before = try%contact(i)%entrance%anchor
      call judge(i, force(i), try)
      call measure_again(model, d, i, before, try)
    end do
    try%count = count_states(try%contact(try%first:try%last))
  end subroutine judge_contacts

  !> Judges the contacts of a prediction, which only closes contacts. Closed contacts keep their state, and closing contacts are
  !> locked, if their joint has any shear strength.
  pure subroutine judge_prediction(model, d, try)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    type(contact_try_t), intent(inout) :: try
    type(contact_force_t) :: force(try%first:try%last)
    real(dp) :: before(2)
    integer :: i

    call press_all(model, d, try, force)
    try%changes = 0
    do i = try%first, try%last
      associate (contact => try%contact(i))
        if (contact%entrance(contact%active)%state /= state_open) cycle
        before = contact%entrance%anchor
        call judge(i, force(i), try)
        call measure_again(model, d, i, before, try)
        associate (entrance => contact%entrance(contact%active))
          if (entrance%state /= state_open) entrance%state = merge(state_locked, state_sliding, can_lock(try%law, entrance))
        end associate
      end associate
    end do
    try%count = count_states(try%contact(try%first:try%last))
  end subroutine judge_prediction

  !> Puts the anchors of open contacts where a prediction takes their vertices over the edge, and keeps them there in the step. A
  !> contact that closes later is then held where it first met the edge, whichever iterate closes it.
  pure subroutine meet_at_prediction(model, d, try)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    type(contact_try_t), intent(inout) :: try
    type(gap_and_slip_t) :: now(2)
    real(dp) :: before(2)
    integer :: i

    call measure_contacts(model, d, try)
    if (.not. decides_outside(try%law)) return
    do i = try%first, try%last
      associate (k => try%contact(i)%active)
        if (try%contact(i)%entrance(k)%state /= state_open .or. try%start(k, i)%anchored .or. .not. try%now(k, i)%gap < 0) cycle
        before = try%contact(i)%entrance%anchor
        now = try%now(:, i)
        call anchor_what_closes(try, i, now)
        try%now(:, i) = now
        try%start(k, i)%anchored = .true.
        call measure_again(model, d, i, before, try)
      end associate
    end do
  end subroutine meet_at_prediction

  !> Measures the contacts at `d`: their forces across, and the largest force that is negligible for each contact.
  pure subroutine press_all(model, d, try, force)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    type(contact_try_t), intent(inout) :: try
    type(contact_force_t), intent(out) :: force(try%first:)
    integer :: body(2, try%first:try%last), i

    do i = try%first, try%last
      body(:, i) = blocks_of(model%outlines, try%contact(i)%entrance(1))
      try%largest(body(:, i)) = try%block_weight(body(:, i))
    end do
    do i = try%first, try%last
      call put_anchors(model, d, i, try)
      call measure_contact(model, d, i, try)
      call press_across(try, i, try%now(:, i), force(i))
      associate (largest => try%largest)
        largest(body(:, i)) = max(largest(body(:, i)), pressing_of(try%law, try%contact(i)%n_entrances, force(i)))
      end associate
    end do
    try%force_tolerance(try%first:try%last) = 0.0_dp
    if (.not. forgives_faint_forces(try%law)) return
    do i = try%first, try%last
      associate (stiffness => try%contact(i)%entrance(1)%stiffness(1), least => minval(try%largest(body(:, i))))
        try%force_tolerance(i) = relative_tolerance*max(least, stiffness*try%rounding) + stiffness*rounding_of(model, d, try, i) &
                       + min(stiffness*try%rounding, rounding_cap*least)
      end associate
    end do
  end subroutine press_all

  !> Error that rounding leaves in the change of a gap in the step, length.
  pure real(dp) function rounding_of(model, d, try, i)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: i
    real(dp) :: cancelled, normal(2*element_unknowns)
    integer :: j, side

    normal = row_across(try, i, 1)
    cancelled = 0.0_dp
    associate (pair => elements_of(try, i, 1))
      do side = 1, 2
        do j = 1, element_unknowns
          cancelled = cancelled + abs(normal((side - 1)*element_unknowns + j)*d(model%elements%unknown(j, pair(side))))
        end do
      end do
    end associate
    rounding_of = round_off*cancelled
  end function rounding_of

  !> Whether a joint has any shear strength.
  pure logical function can_lock(law, entrance)
    type(contact_law_t), intent(in) :: law
    type(entrance_t), intent(in) :: entrance

    can_lock = friction_of(law, entrance) > 0 .or. bond(entrance, law%joint(entrance%joint)%cohesion) > 0
  end function can_lock

  !> Lets multipliers take the forces of closed contacts over, where more than the bound is left of an overlap, a gap or a slip that
  !> there would not be between hard bodies.
  !>
  !> Where what is left does not shrink fast enough, as blocks have more inertia in a short step than soft springs can move, the
  !> springs become harder for the rest of the step (Bertsekas 1982, 2.2).
  pure subroutine hold_contacts(model, d, try, enough)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    type(contact_try_t), intent(inout) :: try
    logical, intent(out) :: enough            !! none is left
    type(contact_force_t) :: force
    type(gap_and_slip_t) :: now(2)
    real(dp) :: apart, held(2, try%first:try%last), left
    integer :: i

    enough = .true.
    left = 0.0_dp
    if (try%law%penetration >= huge(try%law%penetration)) return
    do i = try%first, try%last
      associate (k => try%contact(i)%active, entrance => try%contact(i)%entrance(try%contact(i)%active))
        if (entrance%state == state_open .or. .not. is_held(try, i)) cycle
        now = gaps_and_slips(model, try, i, d)
        call press(try, i, now, force)
        held(:, i) = force_to_hold(try, i, now, force)
        apart = max(abs(now(k)%gap), slip_not_hard(entrance, try%start(k, i), now(k), force%along))
        if (apart > try%law%penetration .and. &
            maxval(abs(held(:, i) - entrance%multiplier)) > max(relative_tolerance*abs(held(1, i)), &
                try%force_tolerance(i)/try%start(k, i)%hardening)) then
          enough = .false.
          left = max(left, apart)
        end if
      end associate
    end do
    if (enough) return
    do i = try%first, try%last
      associate (entrance => try%contact(i)%entrance(try%contact(i)%active))
        if (entrance%state /= state_open .and. is_held(try, i)) entrance%multiplier = held(:, i)
      end associate
    end do
    if (left > shrinking*try%left) call harden(try)
    try%left = left
  end subroutine hold_contacts

  !> Whether multipliers hold contact i.
  pure logical function is_held(try, i)
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: i

    is_held = is_hard(try%law, try%contact(i)%entrance(1))
  end function is_held

  !> Slip of a closed contact that would not exist between hard bodies. For a locked contact it is the slip from the anchor. For a
  !> sliding contact that was closed, it is the movement in the step in the direction of its friction, which would do work.
  pure real(dp) function slip_not_hard(entrance, start, now, shear) result(slip)
    type(entrance_t), intent(in) :: entrance
    type(entrance_start_t), intent(in) :: start
    type(gap_and_slip_t), intent(in) :: now
    real(dp), intent(in) :: shear !! force
    real(dp) :: moved

    slip = abs(now%slip)
    if (entrance%state /= state_sliding) return
    slip = 0.0_dp
    moved = way_along(entrance, start, now)
    if (start%closed .and. shear*moved > 0) slip = abs(moved)
  end function slip_not_hard

  !> How far a vertex went in the step along the edge of its entrance, length.
  pure real(dp) function way_along(entrance, start, now)
    type(entrance_t), intent(in) :: entrance
    type(entrance_start_t), intent(in) :: start
    type(gap_and_slip_t), intent(in) :: now

    way_along = now%slip + (entrance%anchor - start%share)*now%edge_length
  end function way_along

  !> Makes the springs harder for the rest of the step.
  pure subroutine harden(try)
    type(contact_try_t), intent(inout) :: try
    integer :: i, k

    do i = try%first, try%last
      if (.not. is_held(try, i)) cycle
      do k = 1, 2
        try%start(k, i)%hardening = harder*try%start(k, i)%hardening
        try%contact(i)%entrance(k)%stiffness = harder*try%contact(i)%entrance(k)%stiffness
      end do
    end do
  end subroutine harden

  !> Lets entrances and anchors stay as they are from here on. A line that its vertex was behind when the step began, without a
  !> force, does not: the overlap would bring energy. There the other entrance acts, if no third block covers it.
  pure subroutine keep_lines(try)
    type(contact_try_t), intent(inout) :: try
    integer :: i, ignored

    try%lines_stay = .true.
    ignored = 0
    do i = try%first, try%last
      associate (contact => try%contact(i), start => try%start(:, i))
        if (contact%n_entrances == 1 .or. start(contact%active)%closed .or. contact%covered_line == 3 - contact%active) cycle
        if (start(contact%active)%gap < 0 .and. start(3 - contact%active)%gap > start(contact%active)%gap) &
          call act_on(3 - contact%active, contact, ignored)
      end associate
    end do
  end subroutine keep_lines

  !> Moves the anchors of contacts that closed in the step, but whose vertices do not reach them, to where the vertices were when
  !> the step began. Otherwise shear, unless it is negligible, would pull the vertices on along their path and do work.
  pure subroutine return_anchors(model, d, try, enough)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    type(contact_try_t), intent(inout) :: try
    logical, intent(out) :: enough            !! none had to move
    type(contact_force_t) :: force
    type(gap_and_slip_t) :: now(2)
    integer :: i

    enough = .true.
    if (.not. decides_outside(try%law)) return
    do i = try%first, try%last
      associate (k => try%contact(i)%active, entrance => try%contact(i)%entrance(try%contact(i)%active), &
                 start => try%start(try%contact(i)%active, i))
        if (entrance%state == state_open .or. entrance%memory%bonded .or. start%closed .or. .not. start%gap > 0) cycle
        now = gaps_and_slips(model, try, i, d)
        call press(try, i, now, force)
        if (abs(force%along) <= try%force_tolerance(i)) cycle
        if (.not. force%along*way_along(entrance, start, now(k)) > 0 .or. .not. abs(entrance%anchor - start%share) > 0) cycle
        entrance%anchor = start%share
        call measure_contact(model, d, i, try)
        entrance%multiplier(2) = 0.0_dp
        start%anchored = .true.
        enough = .false.
      end associate
    end do
  end subroutine return_anchors

  !> Breaks bonds that are pulled beyond their strength when the step has settled with them, if their excess is above `of_the_worst`
  !> times the largest excess. The released load may unload other bonds, so these are judged in the next round. Where none breaks,
  !> bonds that soften follow.
  subroutine break_bonds(model, d, try, enough)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    type(contact_try_t), intent(inout) :: try
    logical, intent(out) :: enough            !! none had to break
    type(contact_force_t) :: force
    real(dp) :: beyond(try%first:try%last), worst ! force
    integer :: i

    enough = .true.
    if (.not. decides_outside(try%law)) return
    beyond = 0.0_dp
    do i = try%first, try%last
      associate (k => try%contact(i)%active, entrance => try%contact(i)%entrance(try%contact(i)%active))
        if (.not. entrance%memory%bonded .or. entrance%state == state_open .or. softens_in_tension(try%law, entrance)) cycle
        call press_across(try, i, gaps_and_slips(model, try, i, d), force)
        beyond(i) = -force%across(k) - bond(entrance, try%law%joint(entrance%joint)%strength) - try%force_tolerance(i)
      end associate
    end do
    enough = .not. any(beyond > 0)
    if (enough) then
      call soften_bonds(model, d, try, enough)
      return
    end if
    worst = maxval(beyond)
    do i = try%first, try%last
      if (.not. beyond(i) > of_the_worst*worst) cycle
      associate (contact => try%contact(i))
        contact%entrance(contact%active)%state = state_open
        contact%entrance(contact%active)%multiplier = 0.0_dp
        contact%entrance%memory%bonded = .false.
      end associate
    end do
    try%count = count_states(try%contact(try%first:try%last))
  end subroutine break_bonds

  !> Lets the damage of bonds that soften follow the gaps and slips at which the step has settled. A bond that is pulled apart
  !> opens.
  !>
  !> A bond that has lost strength gives way, which damages it and its neighbours again. Where the bodies are hardly stiffer than
  !> the bonds fall, that series converges slowly, and Anderson's extrapolation sums it up. In the second half of the rounds the
  !> damage only grows, which ends.
  subroutine soften_bonds(model, d, try, enough)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    type(contact_try_t), intent(inout) :: try
    logical, intent(out) :: enough            !! the damage stays
    type(contact_force_t) :: force
    type(gap_and_slip_t) :: now(2)
    real(dp), dimension(try%last - try%first + 1) :: before, least, step
    integer :: i, j

    enough = .true.
    if (.not. joints_soften(try%law)) return
    before = 0.0_dp
    least = 0.0_dp
    step = 0.0_dp
    do i = try%first, try%last
      associate (contact => try%contact(i), k => try%contact(i)%active, &
                 entrance => try%contact(i)%entrance(try%contact(i)%active))
        if (.not. entrance%memory%bonded .or. entrance%state == state_open) cycle
        j = i - try%first + 1
        before(j) = entrance%memory%damage
        least(j) = try%start(k, i)%damage
        now = gaps_and_slips(model, try, i, d)
        call press(try, i, now, force)
        step(j) = damage_after(try%law, try%start(k, i), now(k), force%along, entrance) - before(j)
        if (before(j) + step(j) >= 1 .and. now(k)%gap > 0) then
          enough = .false.
          entrance%state = state_open
          contact%entrance%memory%bonded = .false.
        end if
      end associate
    end do
    if (any(abs(step) > same_damage)) enough = .false.
    if (.not. enough) then
      try%softenings = try%softenings + 1
      if (2*try%softenings > most_softenings) then
        step = max(0.0_dp, step)
      else
        call mix_step(try%damages, rounds_mixed, 1.0_dp, spread(1.0_dp, 1, size(step)), before, step)
      end if
    end if
    do i = try%first, try%last
      associate (entrance => try%contact(i)%entrance(try%contact(i)%active))
        j = i - try%first + 1
        if (abs(step(j)) > 0) entrance%memory%damage = min(1.0_dp, max(least(j), before(j) + step(j)))
      end associate
    end do
    try%count = count_states(try%contact(try%first:try%last))
  end subroutine soften_bonds

  !> Updates the friction of joints whose friction depends on the contact stress, with the stress at `d`. This is done in static
  !> steps, of which one may bring a whole load; in motion the stress is that of the step before.
  pure subroutine follow_stress(model, d, share, try, enough)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    real(dp), intent(in) :: share             !! part of the change of stress that is taken
    type(contact_try_t), intent(inout) :: try
    logical, intent(out) :: enough            !! it is the same friction
    type(contact_force_t) :: force
    real(dp) :: before
    integer :: i

    enough = .true.
    if (.not. model%effects%is_static() .or. .not. (decides_outside(try%law) .and. joints_follow_stress(try%law))) return
    do i = try%first, try%last
      associate (entrance => try%contact(i)%entrance(try%contact(i)%active))
        if (entrance%state == state_open) cycle
        before = friction_of(try%law, entrance)
        call press_across(try, i, gaps_and_slips(model, try, i, d), force)
        entrance%memory%pressing = entrance%memory%pressing + share*(max(0.0_dp, sum(force%across)) - entrance%memory%pressing)
        if (abs(friction_of(try%law, entrance) - before) > same_friction*before) enough = .false.
      end associate
    end do
  end subroutine follow_stress

end module scree_open_close
