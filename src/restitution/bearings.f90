!> Contacts that take part in an impact: which bear, which close, and what of their forces is the impact's.
module scree_bearings
  use scree_contact_quantities, only: contact_force_t, gap_and_slip_t
  use scree_contact_rules, only: gap_and_slip, gaps_and_slips, press
  use scree_contact_try, only: contact_try_t, elements_of, of_elements, row_across
  use scree_contacts, only: blocks_of, entrance_t, state_locked, state_open
  use scree_element_term, only: step_rule_t
  use scree_impulse_problem, only: impulse_problem_t, impulses_t, resistance_of, takes_no_part, velocity_at
  use scree_impulses, only: solve_compression
  use scree_joint_rules, only: friction_of
  use scree_kinds, only: dp, pi
  use scree_model, only: cache_t, model_t
  use scree_pairs, only: number_of_pair, pair_of, sorted_pairs
  use scree_rigid_bodies, only: add_motion, find_bodies, held_bodies, modes_of, motion_of, rigid_bodies_t
  use scree_sets, only: root_of, unite
  use scree_sorting, only: sort_into
  use scree_state, only: state_t
  use scree_strikes_in_turn, only: bears, course_t, is_open, strike_in_turn, strikers_t, strikes, together
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: across_contact, any_closes, bearing_t, blow_t, blow_of_step, bonded_bodies, deformation_of, find_approaches, &
            find_impulses, let_go, find_strokes, force_of, list_bearings, strikers_of, set_least, set_up_problem, &
            taking_part

  !> A contact that bears at the beginning of the step or at its end.
  type :: bearing_t
    integer :: contact = 0                   !! of the try
    integer :: vertex = 0
    integer :: block(2) = 0                  !! that stand for the bodies of vertex and edge
    integer :: island = 0                    !! of contacts with bodies in common that are free to move; 0: no impact there
    real(dp) :: force(2) = 0.0_dp            !! across and along, at the end
    real(dp) :: before(2) = 0.0_dp           !! at the beginning
    logical :: closes = .false.              !! in this step, of bodies that come together
    logical :: strikes = .false.             !! closes faster than its spring rings under what the bodies bear
    logical :: driven = .false.              !! closes, though its bodies do not come together when the step begins
    logical :: follows = .false.             !! closes only because impacts of the step drive its bodies
    logical :: reached = .false.             !! by the impact, or it closes
    real(dp) :: energy = 0.0_dp              !! of the approach, of the masses as the contact feels them; force length
    real(dp) :: swing = huge(1.0_dp)         !! of these masses on its spring, time
    real(dp) :: rebound = huge(1.0_dp)       !! of all that energy against what the bodies bear, length
    real(dp) :: depth = 0.0_dp               !! to which the approach presses its spring, length
    real(dp) :: struck = 0.0_dp              !! impulse between its two bodies, were they rigid and met when it began; force time
    real(dp) :: met_at = 1.0_dp              !! time at which it closes, over the step
    real(dp) :: moment = 0.0_dp              !! distance of the approach in a moment, length: a smaller gap counts as closed
    real(dp) :: impulse(2) = 0.0_dp          !! gamma dt Q, force time
    real(dp) :: stopped(2) = 0.0_dp          !! impulse of what closes, where it would go in, force time
    real(dp) :: borne(2) = 0.0_dp            !! impulse until its bodies met others, of what opens; force time
    real(dp) :: kept = 0.0_dp                !! force across that loads press with, of what closes
  end type bearing_t

  !> What strikes in a step.
  type :: blow_t
    real(dp) :: energy = 0.0_dp              !! force length per unit thickness
    real(dp) :: swing = huge(1.0_dp)         !! shortest of a spring that it strikes, time
  end type blow_t

  !> Steps in a swing of a spring that leave to chance what it gives back.
  real(dp), parameter, public :: steps_in_swing = 10.0_dp
  !> An approach below this ratio to the velocities that cancel in it is round-off.
  real(dp), parameter :: round_off = 64*epsilon(1.0_dp)
  !> Bonds in one place are no farther from each other than this ratio of the shorter bond's length.
  real(dp), parameter :: of_a_bond = 1e-2_dp

  integer, parameter :: n = element_unknowns

contains

  !> Impacts of a step that does not resolve the vibration of the struck springs. The phase of the step then decides how much energy
  !> these springs give back (doc/theory/impacts.md, eq-swing). If a body strikes with two corners at once, each contact counts the
  !> energy that it would have alone. Bodies that would rise by no more than the rock settles under its weight (`settling`) vibrate
  !> because their weight acts at once; they are not counted.
  pure type(blow_t) function blow_of_step(model, cache, state, rule, d, try) result(blow)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state           !! at the beginning of the step
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: d(:)                 !! (n_unknowns) of the step
    type(contact_try_t), intent(in) :: try       !! as the step has left it
    type(bearing_t), allocatable :: bearing(:)
    integer :: part_of(model%n_blocks)

    if (.not. any_closes(try)) return
    part_of = bonded_bodies(model, state, try)
    call list_bearings(model, part_of, d, try, bearing)
    call find_approaches(model, cache, state, part_of, rule, d, try, bearing)
    associate (by_chance => bearing%strikes .and. bearing%swing < steps_in_swing*rule%dt .and. &
                            bearing%rebound > try%law%settling)
      if (.not. any(by_chance)) return
      blow = blow_t(sum(bearing%energy, mask=by_chance), minval(bearing%swing, mask=by_chance))
    end associate
  end function blow_of_step

  !> Whether a contact that presses was open when the step began.
  pure logical function any_closes(try)
    type(contact_try_t), intent(in) :: try
    integer :: i

    any_closes = .true.
    do i = 1, size(try%contact)
      if (has_closed(try, i)) return
    end do
    any_closes = .false.
  end function any_closes

  !> Whether contact i presses, and was open when the step began.
  pure logical function has_closed(try, i)
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: i

    associate (contact => try%contact(i))
      has_closed = contact%entrance(contact%active)%state /= state_open .and. .not. held_from_start(try, i)
    end associate
  end function has_closed

  !> Whether contact i was closed when the step began, or is a bond that the step leaves whole, which held from the first.
  pure logical function held_from_start(try, i)
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: i

    associate (contact => try%contact(i))
      held_from_start = any(try%start(:contact%n_entrances, i)%closed) .or. holds(contact%entrance(contact%active))
    end associate
  end function held_from_start

  !> Marks contacts as open at the start of the step if they were closed without a force and their bodies parted. An impact in the
  !> step before leaves contacts in this state, and they may strike again in this step.
  !>
  !> Rows of blocks and elements are weights up to 1 or lengths within the model. This bounds how far bodies part, so that contacts
  !> that bear more than the bound allows cost no look at their rows.
  pure subroutine let_go(model, state, rule, try)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state           !! at the beginning of the step
    type(step_rule_t), intent(in) :: rule
    type(contact_try_t), intent(inout) :: try    !! as the step has left it
    real(dp) :: farthest                         ! that bodies can part in the step, length
    real(dp) :: overlap                          ! that a contact bears when the step begins, length
    real(dp) :: way, ways(2*n)                   ! that they part by in the step, of each unknown; length
    integer :: i, k

    farthest = 2*n*rule%dt*max(1.0_dp, model%extent)*maxval(abs(state%velocity))
    do i = 1, size(try%contact)
      do k = 1, try%contact(i)%n_entrances
        associate (start => try%start(k, i), entrance => try%contact(i)%entrance(k))
          if (.not. start%closed .or. entrance%memory%bonded) cycle
          overlap = start%multiplier(1)*start%hardening/entrance%stiffness(1) - start%gap
          if (overlap >= together*farthest) cycle
          ways = rule%dt*row_across(try, i, k)*of_elements(model, elements_of(try, i, k), state%velocity)
          way = sum(ways)
          if (way > together*sum(abs(ways)) .and. overlap < together*way) start%closed = .false.
        end associate
      end do
    end do
  end subroutine let_go

  !> Of each block the first of those that bonds hold it together with, which stands for their body. Two blocks that bonds hold in
  !> one place alone turn about that, and are bodies of their own.
  pure function bonded_bodies(model, state, try) result(part_of)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state           !! at the beginning of the step
    type(contact_try_t), intent(in) :: try
    integer :: part_of(model%n_blocks)
    integer, dimension(size(try%contact)) :: lower, upper
    integer, allocatable :: bond(:), first(:)
    integer :: b, i, k

    part_of = [(i, i=1, model%n_blocks)]
    lower = 0
    do i = 1, size(try%contact)
      associate (entrance => try%contact(i)%entrance(try%contact(i)%active))
        if (.not. holds(entrance)) cycle
        lower(i) = minval(blocks_of(model%outlines, entrance))
        upper(i) = maxval(blocks_of(model%outlines, entrance))
      end associate
    end do
    call sort_into(lower, model%n_blocks, first, bond)
    do b = 1, model%n_blocks
      do i = first(b), first(b + 1) - 1
        do k = first(b), i - 1
          if (upper(bond(k)) == upper(bond(i)) .and. are_apart(model, state, try, bond(k), bond(i))) &
            call unite(part_of, b, upper(bond(i)))
        end do
      end do
    end do
    part_of = [(root_of(part_of, i), i=1, model%n_blocks)]
  end function bonded_bodies

  !> Whether two bonds are in different places.
  pure logical function are_apart(model, state, try, i, j)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: i, j                  !! contacts

    associate (a => try%contact(i)%entrance(try%contact(i)%active), b => try%contact(j)%entrance(try%contact(j)%active), &
               start => model%outlines%start)
      are_apart = norm2(state%vertex(:, start(a%vertex)) - state%vertex(:, start(b%vertex))) &
                  > of_a_bond*min(a%memory%length, b%memory%length)
    end associate
  end function are_apart

  !> Lists the contacts between bodies that bear at the beginning of the step or at its end, with their forces then, and all of
  !> bodies with a contact that has closed.
  pure subroutine list_bearings(model, part_of, d, try, bearing)
    type(model_t), intent(in) :: model
    integer, intent(in) :: part_of(:)            !! (n_blocks) of `bonded_bodies`
    real(dp), intent(in) :: d(:)                 !! (n_unknowns)
    type(contact_try_t), intent(in) :: try
    type(bearing_t), allocatable, intent(out) :: bearing(:)
    type(bearing_t) :: all_of_them(size(try%contact))
    logical :: met(model%n_blocks)
    integer :: body(2), i, k

    met = .false.
    do i = 1, size(try%contact)
      if (has_closed(try, i)) met(part_of(blocks_of(model%outlines, try%contact(i)%entrance(1)))) = .true.
    end do
    k = 0
    do i = 1, size(try%contact)
      associate (contact => try%contact(i), law => try%law, entrance => try%contact(i)%entrance(try%contact(i)%active), &
                 start => try%start(try%contact(i)%active, i))
        body = part_of(blocks_of(model%outlines, entrance))
        if (body(1) == body(2)) cycle
        if (entrance%state == state_open .and. .not. start%closed .and. .not. any(met(body))) cycle
        k = k + 1
        associate (own => all_of_them(k))
          own%contact = i
          own%vertex = entrance%vertex
          own%block = body
          own%force = force_of(model, try, i, d)
          if (start%closed) then
            own%before(1) = max(0.0_dp, start%multiplier(1) - entrance%stiffness(1)/start%hardening*start%gap)
            own%before(2) = start%multiplier(2) - entrance%stiffness(2)/start%hardening &
                            *(start%share - entrance%anchor)*try%geometry(contact%active, i)%edge_length
            own%before(2) = sign(min(abs(own%before(2)), friction_of(law, entrance)*own%before(1)), own%before(2))
          end if
        end associate
      end associate
    end do
    bearing = all_of_them(:k)
  end subroutine list_bearings

  !> Whether a bond holds: one that yields or has failed in the step slides, or is open.
  pure logical function holds(entrance)
    type(entrance_t), intent(in) :: entrance

    holds = entrance%memory%bonded .and. entrance%state == state_locked
  end function holds

  !> Forces of contact i across and along, none where it is open.
  pure function force_of(model, try, i, d) result(force)
    type(model_t), intent(in) :: model
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: i
    real(dp), intent(in) :: d(:)
    real(dp) :: force(2)
    type(contact_force_t) :: all_of_it

    force = 0.0_dp
    if (try%contact(i)%entrance(try%contact(i)%active)%state == state_open) return
    call press(try, i, gaps_and_slips(model, try, i, d), all_of_it)
    force = [sum(all_of_it%across), all_of_it%along]
  end function force_of

  !> Finds which contacts close, and when in the step. Their bodies come together when the step begins, or are driven together
  !> within the step. A contact closes if it presses at the end, or would press if the bodies did not deform, or closes within the
  !> next moment.
  pure subroutine find_approaches(model, cache, state, part_of, rule, d, try, bearing)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    integer, intent(in) :: part_of(:)            !! (n_blocks) of `bonded_bodies`
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: d(:)                 !! (n_unknowns)
    type(contact_try_t), intent(in) :: try
    type(bearing_t), allocatable, intent(inout) :: bearing(:)
    type(rigid_bodies_t) :: bodies
    type(impulse_problem_t) :: problem
    type(gap_and_slip_t) :: now
    logical :: stays(size(bearing))
    real(dp), allocatable :: motion(:, :)
    integer, allocatable :: open(:)
    real(dp) :: approach, borne(model%n_blocks), cancels, deformed, deformation(size(d)), fastest, resistance(2)
    integer :: i, k

    stays = [(held_from_start(try, bearing(i)%contact), i=1, size(bearing))]
    open = pack([(i, i=1, size(bearing))], .not. stays)
    call set_up_problem(model, cache, state, part_of, d, try, bearing(open), bodies, problem)
    borne = 0.0_dp
    do i = 1, model%n_blocks
      borne(part_of(i)) = borne(part_of(i)) + try%block_weight(i)
    end do
    do i = 1, size(bearing)
      borne(bearing(i)%block) = max(borne(bearing(i)%block), bearing(i)%before(1))
    end do
    where (held_bodies(model, state, part_of)) borne = huge(borne) ! what it bears is no load of a body that moves
    motion = motion_of(model, cache, state, bodies, state%velocity)
    fastest = maxval(abs(motion(:2, :)))
    deformation = deformation_of(model, cache, state, part_of, d, bearing(open))
    do k = 1, size(open)
      associate (own => bearing(open(k)), active => try%contact(bearing(open(k))%contact)%active, &
                 stiffness => try%contact(bearing(open(k))%contact)%entrance(1)%stiffness)
        associate (row => problem%row(:, :, 1, k), moves => motion(:, problem%body(:, k)))
          approach = -sum(row*moves)
          cancels = sum(norm2(row(:2, :), 1)*norm2(moves(:2, :), 1) + abs(row(3, :)*moves(3, :))) ! also of what slides by
        end associate
        now = gap_and_slip(model, try, own%contact, active, d)
        deformed = across_contact(model, try, own%contact, deformation)
        if (.not. approach > round_off*cancels) then ! others may drive its bodies together within the step
          approach = (try%start(active, own%contact)%gap - (now%gap - deformed))/rule%dt
          if (.not. approach > together*fastest) approach = 0.0_dp
          own%driven = .true.
        end if
        own%moment = together*approach*rule%dt
        own%closes = (own%force(1) > 0 .or. now%gap < deformed + own%moment) .and. approach > 0
        own%reached = own%closes
        resistance = resistance_of(problem, k)
        if (resistance(1) > 0) then ! of two that are held there is nothing to swing
          own%energy = 0.5_dp*approach**2/resistance(1)
          own%swing = 2*pi/sqrt(resistance(1)*stiffness(1))
          own%depth = approach/sqrt(resistance(1)*stiffness(1))
          if (minval(borne(own%block)) > 0) own%rebound = own%energy/minval(borne(own%block))
        end if
        own%strikes = own%closes .and. approach > minval(borne(own%block))*sqrt(resistance(1)/stiffness(1))
        if (own%closes) own%met_at = min(1.0_dp, max(0.0_dp, try%start(active, own%contact)%gap)/(approach*rule%dt))
        stays(open(k)) = own%closes .or. own%force(1) > 0
      end associate
    end do
    bearing = pack(bearing, stays)
  end subroutine find_approaches

  !> Displacements of a step (n_unknowns) less those that the bodies of contacts make as rigid ones, however far they turn in it.
  pure function deformation_of(model, cache, state, part_of, d, bearing) result(deformation)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    integer, intent(in) :: part_of(:)            !! (n_blocks) of `bonded_bodies`
    real(dp), intent(in) :: d(:)                 !! (n_unknowns)
    type(bearing_t), intent(in) :: bearing(:)
    real(dp) :: deformation(size(d))
    type(rigid_bodies_t) :: bodies

    ! Half of the displacements of a turn by a is cos a/2 of the turn by a/2, and its tangent there is the secant of the whole.
    call find_bodies(model, cache, state, 0.5_dp*moved_by(model, cache, d), taking_part(part_of, bearing), bodies)
    deformation = 0.0_dp
    call add_motion(model, cache, state, bodies, motion_of(model, cache, state, bodies, d), deformation)
    deformation = d - deformation
  end function deformation_of

  !> Displacements across the entrance of contact i that acts.
  pure real(dp) function across_contact(model, try, i, d) result(across)
    type(model_t), intent(in) :: model
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: i
    real(dp), intent(in) :: d(:)                 !! (n_unknowns)

    associate (active => try%contact(i)%active)
      across = dot_product(row_across(try, i, active), of_elements(model, elements_of(try, i, active), d))
    end associate
  end function across_contact

  !> Displacements that take the bodies to where contacts act (n_unknowns): those of a step with Green strain.
  pure function moved_by(model, cache, d) result(moved)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    real(dp), intent(in) :: d(:)                 !! (n_unknowns)
    real(dp) :: moved(size(d))
    integer :: e

    moved = 0.0_dp
    do e = 1, model%n_elements
      if (cache%element(e)%green) moved(model%elements%unknown(:, e)) = d(model%elements%unknown(:, e))
    end do
  end function moved_by

  !> Of the blocks of bodies with contacts the one that stands for the body, 0 for all others (n_blocks).
  pure function taking_part(part_of, bearing) result(part)
    integer, intent(in) :: part_of(:)            !! (n_blocks) of `bonded_bodies`
    type(bearing_t), intent(in) :: bearing(:)
    integer :: part(size(part_of))
    logical :: touches(size(part_of))
    integer :: i

    touches = .false.
    do i = 1, size(bearing)
      touches(bearing(i)%block) = .true.
    end do
    part = merge(part_of, 0, touches(part_of))
  end function taking_part

  !> Finds the impulses with which impacts strike contacts. These impulses end the approach of closing contacts, while contacts that
  !> press come no closer than they do without the impact. `struck` is the sum over all contacts of the same two bodies, because the
  !> parts of the single contacts are undetermined. Forces from loads or vibration in the step do not count.
  !>
  !> The far side of a struck body moves towards the impact at first, so its contacts are open at the end of a short step. Contacts
  !> that the impulses would close if the bodies were rigid are added.
  subroutine find_strokes(model, cache, state, part_of, rule, d, try, bearing)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    integer, intent(in) :: part_of(:)            !! (n_blocks) of `bonded_bodies`
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: d(:)                 !! (n_unknowns)
    type(contact_try_t), intent(in) :: try
    type(bearing_t), allocatable, intent(inout) :: bearing(:)
    type(rigid_bodies_t) :: bodies
    type(impulse_problem_t) :: problem
    type(impulses_t) :: impulses
    real(dp), allocatable :: motion(:, :), struck(:)
    integer, allocatable :: between(:, :), number(:), pairs(:, :) ! bodies of a contact; of these among the pairs
    logical, allocatable :: idle(:), were_idle(:)
    integer :: i

    idle = [(.false., i=1, size(bearing))]
    bearing = [bearing, open_contacts(model, part_of, try, bearing)]
    idle = [idle, (.true., i=size(idle) + 1, size(bearing))]
    call set_up_problem(model, cache, state, part_of, d, try, bearing, bodies, problem)
    motion = motion_of(model, cache, state, bodies, state%velocity)
    do
      call set_least(bearing, motion, problem)
      where (idle) problem%least = takes_no_part
      call solve_compression(problem, motion, impulses)
      were_idle = idle
      call close_driven(rule, try, problem, motion, impulses, bearing, idle)
      if (all(idle .eqv. were_idle)) exit
    end do
    if (try%law%restitution > 0) call close_in_turn(rule, try, problem, motion, bearing, idle)
    allocate (between(2, size(bearing)), number(size(bearing)))
    do i = 1, size(bearing)
      between(:, i) = pair_of(bearing(i)%block(1), bearing(i)%block(2))
    end do
    pairs = sorted_pairs(between)
    allocate (struck(size(pairs, 2)), source=0.0_dp)
    do i = 1, size(bearing)
      number(i) = number_of_pair(pairs, between(:, i))
      struck(number(i)) = struck(number(i)) + impulses%P(1, i)
    end do
    do i = 1, size(bearing)
      associate (own => bearing(i), velocity => velocity_at(problem, motion, i))
        own%struck = struck(number(i))
        if (own%closes) own%depth = max(own%depth, sqrt(own%struck*max(0.0_dp, -velocity(1)) &
                                                        /try%contact(own%contact)%entrance(1)%stiffness(1)))
      end associate
    end do
    bearing = pack(bearing, .not. idle)
  end subroutine find_strokes

  !> Contacts between bodies that are not among those that bear or close.
  pure function open_contacts(model, part_of, try, others) result(bearing)
    type(model_t), intent(in) :: model
    integer, intent(in) :: part_of(:)            !! (n_blocks) of `bonded_bodies`
    type(contact_try_t), intent(in) :: try
    type(bearing_t), intent(in) :: others(:)
    type(bearing_t), allocatable :: bearing(:)
    type(bearing_t) :: all_of_them(size(try%contact))
    logical :: listed(size(try%contact))
    integer :: body(2), i, k

    listed = .false.
    listed(others%contact) = .true.
    k = 0
    do i = 1, size(try%contact)
      associate (entrance => try%contact(i)%entrance(try%contact(i)%active))
        body = part_of(blocks_of(model%outlines, entrance))
        if (listed(i) .or. body(1) == body(2)) cycle
        k = k + 1
        all_of_them(k) = bearing_t(contact=i, vertex=entrance%vertex, block=body)
      end associate
    end do
    bearing = all_of_them(:k)
  end function open_contacts

  !> Closes open contacts whose bodies an impact drives together within the step, were they rigid.
  pure subroutine close_driven(rule, try, problem, before, impulses, bearing, idle)
    type(step_rule_t), intent(in) :: rule
    type(contact_try_t), intent(in) :: try
    type(impulse_problem_t), intent(in) :: problem
    real(dp), intent(in) :: before(:, :)         !! (3, n_bodies) motion when the step begins
    type(impulses_t), intent(in) :: impulses     !! of what closes already
    type(bearing_t), intent(inout) :: bearing(:)
    logical, intent(inout) :: idle(:)            !! of these: open, and have no part
    real(dp) :: approach, at(size(before, 2)), fastest, first, gap, velocity(2)
    integer :: i

    at = moments_of_impact(problem, impulses, bearing)
    fastest = maxval(abs(before(:2, :)))
    do i = 1, size(bearing)
      if (.not. idle(i)) cycle
      associate (own => bearing(i), start => try%start(try%contact(bearing(i)%contact)%active, bearing(i)%contact))
        first = minval(at(problem%body(:, i)))
        velocity = velocity_at(problem, before, i)
        gap = max(0.0_dp, start%gap + first*rule%dt*velocity(1)) ! when they are struck
        velocity = velocity_at(problem, impulses%motion, i)
        approach = -velocity(1)
        if (.not. (approach > together*fastest .and. gap < (1 - first)*approach*rule%dt)) cycle
        idle(i) = .false.
        call drive_together(rule, first + gap/(approach*rule%dt), approach, own)
      end associate
    end do
  end subroutine close_driven

  !> Lets an open contact close because impacts drive its bodies together.
  pure subroutine drive_together(rule, at, approach, own)
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: at                   !! time over the step
    real(dp), intent(in) :: approach             !! length/time
    type(bearing_t), intent(inout) :: own

    own%closes = .true.
    own%driven = .true.
    own%follows = .true.
    own%reached = .true.
    own%met_at = at
    own%moment = together*approach*rule%dt
  end subroutine drive_together

  !> Closes open contacts whose bodies come together in the step because impacts with a restitution follow each other.
  subroutine close_in_turn(rule, try, problem, before, bearing, idle)
    type(step_rule_t), intent(in) :: rule
    type(contact_try_t), intent(in) :: try
    type(impulse_problem_t), intent(inout) :: problem
    real(dp), intent(in) :: before(:, :)         !! (3, n_bodies) motion when the step begins
    type(bearing_t), intent(inout) :: bearing(:)
    logical, intent(inout) :: idle(:)            !! of these: open, and have no part
    type(strikers_t) :: strikers
    type(impulses_t) :: impulses
    type(course_t) :: course
    integer :: i

    call set_least(bearing, before, problem)
    strikers = strikers_of(rule, try, bearing, idle)
    impulses%motion = before
    call strike_in_turn(problem, strikers, try%law%restitution, 0.0_dp, impulses, course)
    do i = 1, size(bearing)
      if (.not. (idle(i) .and. course%first_at(i) <= 1)) cycle
      idle(i) = .false.
      call drive_together(rule, course%first_at(i), course%approach(i), bearing(i))
    end do
  end subroutine close_in_turn

  !> What contacts are to the impacts of a step that follow each other.
  pure type(strikers_t) function strikers_of(rule, try, bearing, idle) result(strikers)
    type(step_rule_t), intent(in) :: rule
    type(contact_try_t), intent(in) :: try
    type(bearing_t), intent(in) :: bearing(:)
    logical, intent(in) :: idle(:)               !! open, and close in no impact so far
    integer :: i

    strikers%dt = rule%dt
    strikers%at = bearing%met_at
    strikers%kind = merge(strikes, bears, bearing%closes)
    where (idle .or. bearing%follows) strikers%kind = is_open
    strikers%driven = bearing%driven
    strikers%closes = bearing%closes
    allocate (strikers%meets(size(bearing)), source=.false.)
    allocate (strikers%gap(size(bearing)))
    do i = 1, size(bearing)
      strikers%gap(i) = max(0.0_dp, try%start(try%contact(bearing(i)%contact)%active, bearing(i)%contact)%gap)
    end do
  end function strikers_of

  !> Times over the step at which bodies are struck first, by closing contacts or through contacts that bear; 1 if a body is not
  !> struck.
  pure function moments_of_impact(problem, impulses, bearing) result(at)
    type(impulse_problem_t), intent(in) :: problem
    type(impulses_t), intent(in) :: impulses
    type(bearing_t), intent(in) :: bearing(:)
    real(dp) :: at(size(problem%mobility, 3))
    real(dp) :: first
    logical :: moves(size(at)), spreads
    integer :: i

    moves = [(any(abs(problem%mobility(:, :, i)) > 0), i=1, size(at))]
    at = 1.0_dp
    do i = 1, size(bearing)
      associate (body => problem%body(:, i))
        if (bearing(i)%closes) at(body) = merge(min(at(body), bearing(i)%met_at), 1.0_dp, moves(body))
      end associate
    end do
    spreads = .true.
    do while (spreads)
      spreads = .false.
      do i = 1, size(bearing)
        if (bearing(i)%closes .or. .not. impulses%P(1, i) > 0) cycle
        associate (body => problem%body(:, i))
          first = minval(at(body))
          if (.not. any(moves(body) .and. at(body) > first)) cycle
          at(body) = merge(first, 1.0_dp, moves(body))
          spreads = .true.
        end associate
      end do
    end do
  end function moments_of_impact

  !> Sets the least velocity across that compression leaves: none of approach where contacts close, elsewhere what there was.
  pure subroutine set_least(bearing, motion, problem)
    type(bearing_t), intent(in) :: bearing(:)
    real(dp), intent(in) :: motion(:, :)         !! (3, n_bodies)
    type(impulse_problem_t), intent(inout) :: problem
    real(dp) :: velocity(2)
    integer :: i

    do i = 1, size(bearing)
      velocity = velocity_at(problem, motion, i)
      problem%least(i) = min(0.0_dp, velocity(1))
      if (bearing(i)%closes) problem%least(i) = 0.0_dp
    end do
  end subroutine set_least

  !> Finds the impulses that are the impact's in the step: of what closes all, of what it reaches what comes on top. What opened
  !> bore until its bodies met others.
  pure subroutine find_impulses(rule, bearing)
    type(step_rule_t), intent(in) :: rule
    type(bearing_t), intent(inout) :: bearing(:)
    integer :: i

    do i = 1, size(bearing)
      associate (own => bearing(i))
        if (own%closes) then
          own%impulse = own%force
        else if (own%reached .and. own%force(1) > own%before(1)) then
          own%impulse = own%force - own%before
        else if (.not. own%force(1) > 0) then
          own%met_at = share_until_met(bearing, own)
          own%borne = rule%velocity_weight*rule%dt*own%met_at*own%before
        end if
        own%impulse = rule%displacement_weight*rule%dt*own%impulse
      end associate
    end do
  end subroutine find_impulses

  !> Time over the step at which a contact that opens is lifted: when a contact of its vertex closes, or else the first contact of
  !> its bodies. 0 if no such contact closes.
  pure real(dp) function share_until_met(bearing, own) result(share)
    type(bearing_t), intent(in) :: bearing(:)
    type(bearing_t), intent(in) :: own
    logical, dimension(size(bearing)) :: nearby, same_vertex
    integer :: k

    nearby = [(bearing(k)%closes .and. bearing(k)%island == own%island .and. &
               any(own%block(1) == bearing(k)%block .or. own%block(2) == bearing(k)%block), k=1, size(bearing))]
    same_vertex = nearby .and. bearing%vertex == own%vertex
    if (any(same_vertex)) nearby = same_vertex
    share = 0.0_dp
    if (any(nearby)) share = minval(bearing%met_at, mask=nearby)
  end function share_until_met

  !> Bodies of contacts, and how these see their motion: with the rows of the end of the step, along which impulses have no torque.
  pure subroutine set_up_problem(model, cache, state, part_of, d, try, bearing, bodies, problem)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    integer, intent(in) :: part_of(:)            !! (n_blocks) of `bonded_bodies`
    real(dp), intent(in) :: d(:)                 !! (n_unknowns)
    type(contact_try_t), intent(in) :: try
    type(bearing_t), intent(in) :: bearing(:)
    type(rigid_bodies_t), intent(out) :: bodies
    type(impulse_problem_t), intent(out) :: problem
    real(dp) :: modes(n, 3)
    integer :: i, side

    call find_bodies(model, cache, state, moved_by(model, cache, d), taking_part(part_of, bearing), bodies)
    allocate (problem%body(2, size(bearing)), problem%row(3, 2, 2, size(bearing)), &
              problem%answer(3, 2, 2, size(bearing)), problem%friction(size(bearing)), &
              problem%least(size(bearing)))
    problem%mobility = bodies%mobility
    problem%least = 0.0_dp
    do i = 1, size(bearing)
      associate (contact => try%contact(bearing(i)%contact), &
                 pair => elements_of(try, bearing(i)%contact, try%contact(bearing(i)%contact)%active), &
                 geometry => try%geometry(try%contact(bearing(i)%contact)%active, bearing(i)%contact))
        problem%friction(i) = friction_of(try%law, contact%entrance(contact%active))
        do side = 1, 2
          problem%body(side, i) = bodies%number(model%elements%block(pair(side)))
          modes = modes_of(model, cache, state, bodies, pair(side))
          problem%row(:, side, 1, i) = matmul(geometry%normal((side - 1)*n + 1:side*n), modes)
          problem%row(:, side, 2, i) = matmul(geometry%shear((side - 1)*n + 1:side*n), modes)
          problem%answer(:, side, :, i) = matmul(bodies%mobility(:, :, problem%body(side, i)), problem%row(:, side, :, i))
        end do
      end associate
    end do
  end subroutine set_up_problem

end module scree_bearings
