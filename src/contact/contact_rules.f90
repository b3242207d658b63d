!> Whose rules contacts follow. Only this file asks for `contact.rules`, except for defaults of settings.
!>
!> There are three schools of contact: `coulomb_contact`, `conserving_contact` and the folder `shi`. Each school has five verbs:
!>
!> - `pair`      what is near and what contacts remember  -> a contact of the step.
!> - `place`     displacement                             -> gap and slip, and the rows of their changes.
!> - `press`     gap and slip                             -> force, and its change with gap and slip.
!> - `judge`     gap, slip and force                      -> state.
!> - `remember`  the accepted step                        -> anchor, bond, friction work, overlap.
!> All else that a step has to know of the rules is a question with a name (`iteration_rules`, `looks_as_far_as_it_moves`, ...).
module scree_contact_rules
  use scree_conserving_contact, only: deepest_gap, inherit_overlap, judge_conserving, press_conserving, spring_of_conserving
  use scree_contact_geometry, only: find_geometry
  use scree_contact_memory, only: contact_over_edges, inherit
  use scree_contact_quantities, only: contact_force_t, dilates_not, entrance_start_t, gap_and_slip_t, gap_before
  use scree_contact_try, only: contact_try_t, elements_of, of_elements
  use scree_contacts, only: contact_law_t, contact_t, entrance_t, outlines_t, rules_conserving, rules_shi, state_locked, &
                            state_open, state_sliding
  use scree_corner_meeting, only: encounter_t, encounters_t, meet_by_entrances
  use scree_corners, only: survey_t, tilt
  use scree_coulomb_contact, only: add_friction, anchor_where_crossed, judge_coulomb, press_springs, slide_coulomb
  use scree_joint_closure, only: bend_springs
  use scree_joint_dilation, only: feel_opening, feel_opening_change
  use scree_joint_rules, only: begin_joints, friction_of, joints_bend, judge_bend, judge_dilating, remember_dilating
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_past_contacts, only: past_t
  use scree_shi_contact, only: adapted_stiffness, add_edge, anchor_where_closed, anchored_rows, close_touching, judge_shi, slide_shi
  use scree_shi_meeting, only: meet_as_shi
  use scree_shi_memory, only: contact_as_shi
  use scree_state, only: state_t
  use scree_system, only: element_unknowns
  implicit none
  private
  ! pair
  public :: corners_turn, deepest_search, looks_as_far_as_it_moves, looks_at_all, meet, pair, rests_inside, set_reach
  ! place
  public :: begin_contact, bonds_by_length, gap_and_slip, gaps_and_slips, has_bonds, keeps_stiffness, measure_again, &
            measure_contact, measure_contacts, place, put_anchors
  ! press
  public :: force_to_hold, press, press_across, pressing_of, rows_along, rubs, spring_of
  ! judge
  public :: acts_by_another, anchor_what_closes, decides_outside, forgives_faint_forces, goes_on_after_cut, iteration_rules, &
            iteration_rules_t, judge, judges_anew, may_make_energy, only_presses, settles_as_one, steps_decide_impacts
  ! remember
  public :: remember_overlap, remember_slide, stiffness_adapts, stiffness_after

  integer, parameter :: n = 2*element_unknowns

  !> How the open-close iteration goes.
  type :: iteration_rules_t
    logical :: judges_prediction = .true.      !! contacts of the first step are judged once before its first solution
    logical :: repeats_first_of_run = .false.  !! the first solution of a run is followed by another, settled or not
    logical :: counts_progress = .true.        !! iterations that leave fewer states changing are not counted as stalled
    integer :: most_stalled = 3                !! iterations, before it is given up
    logical :: settles_always = .true.         !! as a friction problem, and by the balance of forces; else the step is cut
    logical :: linear_springs = .true.         !! as long as states stay: friction problems may follow each other at once
  end type iteration_rules_t

  !> Contacts that two corners may have, tip to tip: they stand one after the other.
  integer, parameter :: most_tips = 3
  !> Iterations without fewer changes that are allowed if springs are curves: those of Newton's method on them.
  integer, parameter :: most_bending = 8
  !> Solutions that Shi's programs make before they cut the step.
  integer, parameter :: most_solutions = 8

contains

  !> How the open-close iteration goes by the rules.
  pure type(iteration_rules_t) function iteration_rules(law)
    type(contact_law_t), intent(in) :: law

    select case (law%rules)
    case (rules_shi)
      iteration_rules = iteration_rules_t(judges_prediction=.false., repeats_first_of_run=.true., counts_progress=.false., &
                                          most_stalled=most_solutions - 1, settles_always=.false., linear_springs=.false.)
    case default
      iteration_rules = iteration_rules_t()
      if (joints_bend(law)) iteration_rules%most_stalled = most_bending
      iteration_rules%linear_springs = .not. (law%rules == rules_conserving .or. joints_bend(law))
    end select
  end function iteration_rules

  !> Whether a step first judges the states anew where it begins. Otherwise it begins with the states at the end of the step before.
  pure logical function judges_anew(law)
    type(contact_law_t), intent(in) :: law

    judges_anew = law%rules /= rules_shi
  end function judges_anew

  !> Whether all contacts are iterated as often as those that settle last. Otherwise each island is iterated on its own.
  pure logical function settles_as_one(law)
    type(contact_law_t), intent(in) :: law

    settles_as_one = law%rules == rules_shi
  end function settles_as_one

  !> Whether the phase of a step decides the energy that springs give back after an impact. It does not if contacts conserve energy.
  !> It is false by Shi's rules, too, so that runs agree with his programs.
  pure logical function steps_decide_impacts(law)
    type(contact_law_t), intent(in) :: law

    steps_decide_impacts = all(law%rules /= [rules_conserving, rules_shi])
  end function steps_decide_impacts

  !> Whether the search sees as far as vertices move in the step, and a step may outrun it; else it sees to a set gap.
  pure logical function looks_as_far_as_it_moves(law)
    type(contact_law_t), intent(in) :: law

    looks_as_far_as_it_moves = .not. (law%rules == rules_shi .and. law%shi%search_gap > 0)
  end function looks_as_far_as_it_moves

  !> Whether each step looks at all vertices, wherever they are.
  pure logical function looks_at_all(law)
    type(contact_law_t), intent(in) :: law

    looks_at_all = law%rules == rules_shi
  end function looks_at_all

  !> Sets how far the search looks about each vertex, where that is not as far as it moves.
  elemental subroutine set_reach(law, near)
    type(contact_law_t), intent(in) :: law
    real(dp), intent(inout) :: near !! length

    if (.not. looks_as_far_as_it_moves(law)) near = 0.5_dp*law%shi%search_gap
  end subroutine set_reach

  !> Overlap up to which a vertex over an edge is found, length.
  pure real(dp) function deepest_search(law)
    type(contact_law_t), intent(in) :: law

    deepest_search = huge(1.0_dp)
    if (.not. looks_as_far_as_it_moves(law)) deepest_search = law%shi%search_depth
  end function deepest_search

  !> Whether corners that turn in the step may meet corners that they do not face when it begins.
  pure logical function corners_turn(law)
    type(contact_law_t), intent(in) :: law

    corners_turn = law%rules /= rules_shi
  end function corners_turn

  !> Whether a contact that is found inside rests there without a force. Otherwise springs press overlaps apart when a run begins.
  pure logical function rests_inside(law)
    type(contact_law_t), intent(in) :: law

    rests_inside = law%rules /= rules_shi
  end function rests_inside

  !> How the corners at vertices i and j can meet.
  pure type(encounters_t) function meet(law, survey, i, j, stood)
    type(contact_law_t), intent(in) :: law
    type(survey_t), intent(in) :: survey
    integer, intent(in) :: i, j
    logical, intent(in) :: stood !! one contact stood for both, or a bond held them

    select case (law%rules)
    case (rules_shi)
      meet = meet_as_shi(survey%corner(i), survey%corner(j))
    case default
      meet = meet_by_entrances(survey%corner(i), survey%corner(j), tilt(survey, i, j), stood)
    end select
  end function meet

  !> The contact of an encounter, with the memory of earlier contacts. If an entrance has no vertex, there is no contact.
  pure subroutine pair(law, outlines, survey, past, encounter, contact)
    type(contact_law_t), intent(in) :: law
    type(outlines_t), intent(in) :: outlines
    type(survey_t), intent(in) :: survey
    type(past_t), intent(in) :: past
    type(encounter_t), intent(in) :: encounter
    type(contact_t), intent(out) :: contact

    select case (law%rules)
    case (rules_shi)
      call contact_as_shi(outlines, survey, past, law%shi%guard, encounter, contact)
    case (rules_conserving)
      call contact_over_edges(law, outlines, survey, past, encounter, contact)
      if (all(contact%entrance(:contact%n_entrances)%vertex > 0)) &
        call inherit(survey, past, encounter, contact)
    case default
      call contact_over_edges(law, outlines, survey, past, encounter, contact)
    end select
  end subroutine pair

  !> Whether slip is measured from the anchor, and is linear in the displacements of the step (Shi, with small strain).
  pure logical function is_anchored(try)
    type(contact_try_t), intent(in) :: try

    is_anchored = try%law%rules == rules_shi .and. try%linear
  end function is_anchored

  !> Places the entrances of the contacts that are settled together at a displacement.
  pure subroutine place(model, cache, state, d, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    real(dp), intent(in) :: d(:)                  !! (n_unknowns)
    type(contact_try_t), intent(inout) :: try
    integer :: i, k
    logical :: anchored

    anchored = is_anchored(try)
    if (anchored .and. .not. allocated(try%edge)) allocate (try%edge(3, n, 2, size(try%contact)))
    do i = try%first, try%last
      do k = 1, try%contact(i)%n_entrances
        associate (entrance => try%contact(i)%entrance(k), geometry => try%geometry(k, i), &
                   pair => elements_of(try, i, k))
          if (.not. allocated(try%acting)) then
            call find_geometry(model, cache, state, pair, entrance, d, geometry)
          else if (any(cache%element(pair)%green)) then
            call find_geometry(model, cache, state, pair, entrance, d, geometry, try%acting(k, i), try%weight)
          else
            call find_geometry(model, cache, state, pair, entrance, d, geometry, try%acting(k, i))
          end if
          geometry%gap = geometry%gap - entrance%rest - entrance%memory%dilated
          if (anchored) then
            call add_edge(model, cache, state, pair, entrance, geometry, try%edge(:, :, k, i))
            if (allocated(try%acting)) try%acting(k, i)%normal = geometry%normal
          end if
        end associate
      end do
    end do
  end subroutine place

  !> Begins a contact that is placed at the start of the step: with the overlap that it inherits, and closed where it touches when a
  !> run begins.
  pure subroutine begin_contact(first_of_run, i, try)
    logical, intent(in) :: first_of_run
    integer, intent(in) :: i
    type(contact_try_t), intent(inout) :: try
    real(dp) :: gap(2)
    integer :: k

    associate (contact => try%contact(i), geometry => try%geometry(:, i), start => try%start(:, i))
      gap = 0.0_dp
      gap(:contact%n_entrances) = geometry(:contact%n_entrances)%gap
      select case (try%law%rules)
      case (rules_shi)
        if (first_of_run) call close_touching(try%law%shi%touching, gap, is_anchored(try), contact)
      case (rules_conserving)
        call inherit_overlap(contact, gap)
        call open_slipped_off(gap, contact)
      case default
        call open_slipped_off(gap, contact)
      end select
      do k = 1, contact%n_entrances
        geometry(k)%gap = gap(k)
        start(k)%gap = gap(k)
        start(k)%share = geometry(k)%along/geometry(k)%edge_length
        start(k)%closed = contact%entrance(k)%state /= state_open
        start(k)%multiplier = contact%entrance(k)%multiplier
        start(k)%bonded = contact%entrance(k)%memory%bonded
      end do
      call begin_joints(try%law, try%dashpot, contact, start)
    end associate
  end subroutine begin_contact

  !> Opens a corner of two entrances that has slipped off the line of the entrance that does not act.
  pure subroutine open_slipped_off(gap, contact)
    real(dp), intent(in) :: gap(2) !! length
    type(contact_t), intent(inout) :: contact

    if (contact%n_entrances == 2 .and. gap(3 - contact%active) > 0) contact%entrance(contact%active)%state = state_open
  end subroutine open_slipped_off

  !> Puts the anchors of a contact's open entrances where the displacement takes their vertices over the edge (Shi: df22).
  pure subroutine put_anchors(model, d, i, try)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    integer, intent(in) :: i
    type(contact_try_t), intent(inout) :: try
    integer :: k

    if (.not. is_anchored(try)) return
    do k = 1, try%contact(i)%n_entrances
      associate (entrance => try%contact(i)%entrance(k))
        if (entrance%state == state_open) &
          entrance%anchor = anchor_where_closed(try%geometry(k, i), try%edge(:, :, k, i), &
                                                of_elements(model, elements_of(try, i, k), d))
      end associate
    end do
  end subroutine put_anchors

  !> Gaps and slips of the entrances of contact i at `d`.
  pure function gaps_and_slips(model, try, i, d) result(now)
    type(model_t), intent(in) :: model
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: i
    real(dp), intent(in) :: d(:)
    type(gap_and_slip_t) :: now(2)
    integer :: k

    do k = 1, try%contact(i)%n_entrances
      now(k) = gap_and_slip(model, try, i, k, d)
    end do
  end function gaps_and_slips

  !> Measures the contacts that are settled together at `d`.
  pure subroutine measure_contacts(model, d, try)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    type(contact_try_t), intent(inout) :: try
    integer :: i

    do i = try%first, try%last
      call measure_contact(model, d, i, try)
    end do
  end subroutine measure_contacts

  !> Measures contact i at `d`.
  pure subroutine measure_contact(model, d, i, try)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    integer, intent(in) :: i
    type(contact_try_t), intent(inout) :: try
    integer :: k

    do k = 1, try%contact(i)%n_entrances
      try%now(k, i) = gap_and_slip(model, try, i, k, d)
    end do
  end subroutine measure_contact

  !> Measures contact i again at the same `d`, where that may have changed: its anchors were others, or it dilates by other pieces.
  pure subroutine measure_again(model, d, i, before, try)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    integer, intent(in) :: i
    real(dp), intent(in) :: before(2)         !! anchors that it was measured from
    type(contact_try_t), intent(inout) :: try

    if (any(abs(try%contact(i)%entrance%anchor - before) > 0) .or. abs(try%now(1, i)%opened) + abs(try%now(2, i)%opened) > 0 &
        .or. try%start(try%contact(i)%active, i)%opening%piece /= dilates_not) call measure_contact(model, d, i, try)
  end subroutine measure_again

  !> Gap of entrance k and slip from its anchor at `d`, linear about the reference.
  pure type(gap_and_slip_t) function gap_and_slip(model, try, i, k, d) result(now)
    type(model_t), intent(in) :: model
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: i, k
    real(dp), intent(in) :: d(:)
    real(dp) :: change(n), gone, rows(n, 2), slipped
    integer :: at, j, side

    associate (entrance => try%contact(i)%entrance(k), geometry => try%geometry(k, i), unknown => model%elements%unknown)
      gone = 0.0_dp
      slipped = 0.0_dp
      do side = 1, 2
        associate (e => try%pair(side, entrance%pair))
          do j = 1, n/2
            at = (side - 1)*n/2 + j
            change(at) = d(unknown(j, e))
            if (allocated(try%acting)) change(at) = change(at) - try%acting(k, i)%at(at)
            gone = gone + geometry%normal(at)*change(at)
            slipped = slipped + geometry%shear(at)*change(at)
          end do
        end associate
      end do
      now%edge_length = geometry%edge_length
      now%gap = geometry%gap + gone
      if (is_anchored(try)) then
        rows = anchored_rows(geometry, try%edge(:, :, k, i), entrance%anchor)
        now%slip = geometry%along + dot_product(rows(:, 2), change) - entrance%anchor*geometry%edge_length
      else
        now%slip = geometry%slid + slipped + (try%start(k, i)%share - entrance%anchor)*geometry%edge_length
      end if
      if (try%start(k, i)%opening%piece /= dilates_not) call feel_opening(try%start(k, i)%opening, now)
    end associate
  end function gap_and_slip

  !> Forces across the entrances of contact i, as if it were closed.
  pure subroutine press_across(try, i, now, force)
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: i
    type(gap_and_slip_t), intent(in) :: now(2)
    type(contact_force_t), intent(out) :: force

    select case (try%law%rules)
    case (rules_conserving)
      call press_conserving(try%contact(i)%entrance(1)%stiffness(1), try%contact(i)%n_entrances, try%start(:, i), now, force)
    case default
      call press_springs(try%contact(i)%entrance(1)%stiffness(1), try%dashpot, try%contact(i), try%start(:, i), now, force)
    end select
    associate (start => try%start(:, i), active => try%contact(i)%active)
      if (any(abs(start%bend%stiffer) > 0)) call bend_springs(start, now, force)
      if (start(active)%opening%piece /= dilates_not) call feel_opening_change(start(active)%opening, active, force)
    end associate
  end subroutine press_across

  !> The active entrance of contact i as a spring that only presses: its force and its stiffness.
  pure subroutine spring_of(try, i, now, pressing, yielding)
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: i
    type(gap_and_slip_t), intent(in) :: now(2)
    real(dp), intent(out) :: pressing !! force
    real(dp), intent(out) :: yielding !! force/length
    type(contact_force_t) :: force

    associate (k => try%contact(i)%active)
      select case (try%law%rules)
      case (rules_conserving)
        call spring_of_conserving(try%contact(i)%entrance(k)%stiffness(1), try%contact(i)%n_entrances, k, try%start(:, i), now, &
                                  pressing, yielding)
      case default
        call press_across(try, i, now, force)
        pressing = force%across(k)
        yielding = -force%across_by_gap(k, k)
      end select
    end associate
  end subroutine spring_of

  !> Force of contact i, which is closed. The entrance that does not act presses only where both conserve energy together.
  pure subroutine press(try, i, now, force)
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: i
    type(gap_and_slip_t), intent(in) :: now(2)
    type(contact_force_t), intent(out) :: force

    call press_across(try, i, now, force)
    associate (law => try%law, active => try%contact(i)%active, entrance => try%contact(i)%entrance(try%contact(i)%active))
      if (law%rules /= rules_conserving) then
        force%across(3 - active) = 0.0_dp
        force%across_by_gap(:, 3 - active) = 0.0_dp
      end if
      if (entrance%state == state_locked) then
        force%along = entrance%multiplier(2) - entrance%stiffness(2)*now(active)%slip
        force%along_by_slip = -entrance%stiffness(2)
        return
      end if
      select case (law%rules)
      case (rules_shi)
        force%along = -entrance%direction*entrance%lagged_friction
      case default
        call add_friction(law, entrance, force)
      end select
    end associate
  end subroutine press

  !> Forces of contact i, which is closed, across and along, that multipliers take over: not that of a dashpot, which is no part of
  !> the overlap's.
  pure function force_to_hold(try, i, now, force) result(held)
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: i
    type(gap_and_slip_t), intent(in) :: now(2)
    type(contact_force_t), intent(in) :: force
    real(dp) :: held(2)

    associate (k => try%contact(i)%active)
      held = [force%across(k) + try%dashpot*(now(k)%gap - gap_before(try%start(k, i), try%contact(i)%entrance(k))), force%along]
    end associate
  end function force_to_hold

  !> Rows of the friction force of entrance k of contact i, and rows of the change of its slip.
  pure subroutine rows_along(try, i, k, row, change)
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: i, k
    real(dp), intent(out) :: row(n)
    real(dp), intent(out), optional :: change(n)
    real(dp) :: rows(n, 2)

    if (is_anchored(try)) then ! friction acts at the anchor (Shi: df18)
      rows = anchored_rows(try%geometry(k, i), try%edge(:, :, k, i), try%contact(i)%entrance(k)%anchor)
      row = rows(:, merge(2, 1, try%contact(i)%entrance(k)%state == state_locked))
      if (present(change)) change = row
    else
      row = try%geometry(k, i)%shear
      if (present(change)) change = row
      if (allocated(try%acting)) row = try%acting(k, i)%shear
    end if
  end subroutine rows_along

  !> Whether an entrance slides with a force proportional to the force across. Its part of the matrix is then not symmetric.
  pure logical function rubs(law, entrance)
    type(contact_law_t), intent(in) :: law
    type(entrance_t), intent(in) :: entrance

    select case (law%rules)
    case (rules_shi)
      rubs = .false.
    case default
      rubs = entrance%state == state_sliding .and. friction_of(law, entrance) > 0
    end select
  end function rubs

  !> Smallest pressing force of a contact, which is compared with negligible forces.
  pure real(dp) function pressing_of(law, n_entrances, force) result(pressing)
    type(contact_law_t), intent(in) :: law
    integer, intent(in) :: n_entrances
    type(contact_force_t), intent(in) :: force

    pressing = max(minval(force%across(:n_entrances)), 0.0_dp)
    select case (law%rules)
    case (rules_conserving)
      pressing = max(pressing, sum(force%across))
    end select
  end function pressing_of

  !> Whether a negligible force changes no state.
  pure logical function forgives_faint_forces(law)
    type(contact_law_t), intent(in) :: law

    forgives_faint_forces = law%rules /= rules_shi
  end function forgives_faint_forces

  !> Judges contact i, as it was measured: which entrance acts, and its state.
  pure subroutine judge(i, force, try)
    integer, intent(in) :: i
    type(contact_force_t), intent(inout) :: force !! as of `press_across`, then on the lines that it is judged by
    type(contact_try_t), intent(inout) :: try
    integer :: changes
    logical :: was_open

    changes = try%changes
    was_open = try%contact(i)%entrance(try%contact(i)%active)%state == state_open
    associate (law => try%law, start => try%start(:, i), now => try%now(:, i), tolerance => try%force_tolerance(i), &
        contact => try%contact(i))
      select case (law%rules)
      case (rules_shi)
        call judge_shi(law, now, force, contact, try%changes)
        if (was_open .and. .not. is_anchored(try)) call anchor_what_closed(start, now, contact)
      case (rules_conserving)
        call judge_conserving(law, try%lines_stay, start, now, force, tolerance, contact, try%changes)
      case default
        call judge_bend(law, try%pulls_fall, now, tolerance, contact, start, force, try%changes)
        call judge_coulomb(law, try%lines_stay, start, now, force, tolerance, contact, try%changes)
        call judge_dilating(law, try%dashpot, now, tolerance, contact, start, try%changes)
        if (acts_by_another(try, i)) then
          contact%entrance(contact%active)%state = state_open
          try%changes = changes + merge(0, 1, was_open)
        end if
      end select
    end associate
  end subroutine judge

  !> Whether contact i of two corners acts by an earlier contact of these corners, with the same vertex and edge, that closes
  !> whenever this one does. Turning corners may meet by up to three pairs of lines, of which some are the same. Only one contact
  !> presses there, because the spring would otherwise be two or three times as stiff.
  pure logical function acts_by_another(try, i)
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: i
    integer :: k

    acts_by_another = .false.
    if (try%contact(i)%n_entrances == 1 .or. any(try%law%rules == [rules_conserving, rules_shi])) return
    do k = max(try%first, i - most_tips + 1), i - 1
      associate (other => try%contact(k)%entrance(try%contact(k)%active), own => try%contact(i)%entrance(try%contact(i)%active))
        acts_by_another = try%contact(k)%n_entrances == 2 .and. other%vertex == own%vertex .and. other%edge == own%edge .and. &
                          other%rest + other%memory%dilated >= own%rest + own%memory%dilated
      end associate
      if (acts_by_another) return
    end do
  end function acts_by_another

  !> Puts the anchor of a contact that was open, and is closed now.
  pure subroutine anchor_what_closed(start, now, contact)
    type(entrance_start_t), intent(in) :: start(2)
    type(gap_and_slip_t), intent(in) :: now(2)
    type(contact_t), intent(inout) :: contact
    real(dp) :: slip

    associate (k => contact%active)
      if (contact%entrance(k)%state == state_open) return
      slip = now(k)%slip
      call anchor_where_crossed(start(k), now(k), contact%entrance(k), slip)
    end associate
  end subroutine anchor_what_closed

  !> Puts the anchor of an open contact where it would close on the path to these gaps and slips, and measures slip from there.
  pure subroutine anchor_what_closes(try, i, now)
    type(contact_try_t), intent(inout) :: try
    integer, intent(in) :: i
    type(gap_and_slip_t), intent(inout) :: now(2)
    real(dp) :: slip

    associate (k => try%contact(i)%active)
      if (try%contact(i)%entrance(k)%state /= state_open .or. try%lines_stay) return
      slip = now(k)%slip
      call anchor_where_crossed(try%start(k, i), now(k), try%contact(i)%entrance(k), slip)
      now(k)%slip = slip
    end associate
  end subroutine anchor_what_closes

  !> Whether anchors of closed contacts, and bonds to break, are decided after a step has settled. Otherwise each judgement decides.
  pure logical function decides_outside(law)
    type(contact_law_t), intent(in) :: law

    decides_outside = law%rules /= rules_shi
  end function decides_outside

  !> Whether there are bonds whose stiffness is proportional to their length, so that all pull with the same stress. Bonds by Shi's
  !> rules have the stiffness of any contact.
  pure logical function bonds_by_length(law)
    type(contact_law_t), intent(in) :: law

    select case (law%rules)
    case (rules_shi)
      bonds_by_length = .false.
    case default
      bonds_by_length = any(has_bonds(law))
    end select
  end function bonds_by_length

  !> Whether the contacts of each joint are bonded at the start: where it has cohesion, or strength under rules that can pull.
  pure function has_bonds(law)
    type(contact_law_t), intent(in) :: law
    logical :: has_bonds(size(law%joint)) !! (n_joints)

    has_bonds = law%joint%cohesion > 0 .or. (law%joint%strength > 0 .and. .not. only_presses(law%rules))
  end function has_bonds

  !> Whether a contact keeps the stiffness with which it closed, or that it inherits: a loaded spring whose stiffness changes would
  !> make energy. Shi's changes from step to step.
  pure logical function keeps_stiffness(law, contact)
    type(contact_law_t), intent(in) :: law
    type(contact_t), intent(in) :: contact

    keeps_stiffness = contact%entrance(contact%active)%state /= state_open .or. contact%inherits > 0
    if (stiffness_adapts(law)) keeps_stiffness = .false.
  end function keeps_stiffness

  !> Whether a step that is tried again begins with the contacts in the states that the try before left (Shi), else as the step
  !> found them.
  pure logical function goes_on_after_cut(law)
    type(contact_law_t), intent(in) :: law

    goes_on_after_cut = .not. looks_as_far_as_it_moves(law)
  end function goes_on_after_cut

  !> Updates the memory of an entrance after sliding in an accepted step: anchor, bond, and the elastic slip of its spring.
  pure subroutine remember_slide(law, force, now, holds, entrance, slip, work)
    type(contact_law_t), intent(in) :: law
    type(contact_force_t), intent(in) :: force
    type(gap_and_slip_t), intent(in) :: now
    logical, intent(in) :: holds         !! another bond between the two blocks is locked
    type(entrance_t), intent(inout) :: entrance
    real(dp), intent(out) :: slip        !! that the spring keeps, length
    real(dp), intent(out) :: work        !! lost in friction, force length

    slip = now%slip
    select case (law%rules)
    case (rules_shi)
      call slide_shi(law, force%along, now%edge_length, entrance, slip, work)
    case default
      call slide_coulomb(law, force%along, now%edge_length, holds, entrance, slip, work)
      call remember_dilating(law, now%slip - slip, now%opened, sum(force%across), entrance%memory, work)
    end select
  end subroutine remember_slide

  !> Gap of a closed contact whose spring presses, and the part of the gap that gives the spring its energy.
  pure subroutine remember_overlap(law, contact, now, gap, strained)
    type(contact_law_t), intent(in) :: law
    type(contact_t), intent(in) :: contact
    type(gap_and_slip_t), intent(in) :: now(2)
    real(dp), intent(out) :: gap, strained !! length

    select case (law%rules)
    case (rules_conserving)
      gap = deepest_gap(contact%n_entrances, now)
      strained = min(gap, 0.0_dp)
    case default
      gap = now(contact%active)%gap
      strained = gap
    end select
  end subroutine remember_overlap

  !> Whether contacts can make energy in a dynamic run of small strain, the more the stiffer their springs.
  pure logical function may_make_energy(rules)
    integer, intent(in) :: rules

    may_make_energy = rules == rules_shi
  end function may_make_energy

  !> Whether contacts only press, whatever tensile strength their joints have.
  pure logical function only_presses(rules)
    integer, intent(in) :: rules

    only_presses = rules == rules_conserving
  end function only_presses

  !> Whether the stiffness follows gaps and overlaps from step to step (Shi: spri).
  pure logical function stiffness_adapts(law)
    type(contact_law_t), intent(in) :: law

    stiffness_adapts = law%rules == rules_shi .and. law%shi%allowed_gap > 0
  end function stiffness_adapts

  !> Stiffness across and along after a step with this largest gap and overlap of a closed contact.
  pure function stiffness_after(law, gap, overlap) result(stiffness)
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: gap, overlap !! length
    real(dp) :: stiffness(2)             !! force/length per unit thickness

    stiffness = [law%normal_stiffness, law%shear_stiffness]
    if (stiffness_adapts(law)) stiffness = adapted_stiffness(law%shi, gap, overlap, stiffness)
  end function stiffness_after

end module scree_contact_rules
