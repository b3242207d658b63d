!> Impacts of bodies that come together in a step.
!>
!> The energy that springs give back after an impact depends on the phase of the impact in the step. If contacts of approaching
!> bodies closed in a step, the step is therefore repeated without the impact in the springs. The impact acts in two parts:
!>
!> - Where the bodies go. Q are the forces of the impact in the step: the forces of contacts that closed, and the forces that the
!>   impact added to contacts that pressed before. The impulse gamma dt Q acts on the rigid motion of the bodies when the repeated
!>   step begins (`push_apart`). Contacts keep their force from loads and from before the step. Bodies are moved out by the depth to
!>   which Q pressed springs and bodies. Otherwise they end at the same places, deformed by their loads alone. A contact that closed
!>   has a force only where bodies would penetrate further.
!> - How fast they leave. Without that impulse, and without what stopped them from going deeper, their motion q- at the end is the
!>   one before the impact, and impulses bring it to the one after (`rebound`). Stress stays.
!>
!> The energy that may come back is what these impulses take, less D, the work of the loads over the way that Q barred,
!>
!>     D = -p.M (v- - v0)
!>
!> with p the rates that the impulse adds, v0 and v- those when the step began and before the impact, however far bodies turn in it.
!> So a step with an impact makes no energy where the step itself makes none (doc/theory/impacts.md, eq-share-given-back).
module scree_impact
  use scree_base_acceleration, only: force_of_base
  use scree_bearings, only: across_contact, bearing_t, bonded_bodies, deformation_of, find_approaches, find_impulses, &
                            find_strokes, force_of, list_bearings, strikers_of, set_least, set_up_problem, taking_part
  use scree_contact_quantities, only: gap_and_slip_t
  use scree_contact_rules, only: gap_and_slip, rows_along
  use scree_contact_try, only: contact_try_t, elements_of, row_across, take_all
  use scree_contacts, only: contact_law_t, state_locked, state_open, state_sliding
  use scree_effects, only: mean_share_of_weight
  use scree_element_term, only: step_rule_t
  use scree_impact_islands, only: find_islands
  use scree_impulse_problem, only: apply, impulse_problem_t, impulses_t, velocity_at
  use scree_impulses, only: solve_compression
  use scree_integrator, only: end_rates
  use scree_joint_rules, only: friction_of
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_rigid_bodies, only: add_motion, find_bodies, held_bodies, modes_of, motion_of, motion_of_holders, rigid_bodies_t, &
                                take_deformation
  use scree_state, only: state_t
  use scree_strikes_in_turn, only: course_t, strike_in_turn, strikers_t
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: impact_t, push_apart, rebound

  !> An impact in a step.
  type :: impact_t
    type(bearing_t), allocatable :: bearing(:) !! none without an impact
    integer, allocatable :: part_of(:)       !! (n_blocks) of `bonded_bodies` before it
    logical, allocatable :: among(:)         !! (n_elements) of bodies that it reaches
    real(dp), allocatable :: push(:)         !! (n_unknowns) added to the velocity when the step begins
    real(dp), allocatable :: change(:)       !! (n_unknowns) added to the velocity at its end
    integer :: unsolved = 0                  !! a contact of the try whose impulses were not found; 0: none
    integer :: cut_short = 0                 !! a contact of the try whose last impacts were made as one; 0: none
    real(dp) :: friction = 0.0_dp            !! work that it took, force length per unit thickness
    real(dp) :: work = 0.0_dp                !! of what moves supports, that their bodies go on as they did, likewise
  end type impact_t

  !> An impact deforms bodies by at most so many times the depth to which it presses springs; what is more, loads have done.
  real(dp), parameter :: by_bodies = 4.0_dp

  !> Share by which a contact that loads make close as fast may differ from that by rounding.
  real(dp), parameter :: no_faster = 1e-9_dp

  integer, parameter :: n = element_unknowns

contains

  !> Finds the impacts of a step that has settled, and the push and the contact states with which the step is repeated.
  subroutine push_apart(model, cache, state, rule, d, try, impact)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state           !! at the beginning of the step
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: d(:)                 !! (n_unknowns) of the step
    type(contact_try_t), intent(inout) :: try    !! as the step has left it, then as it is to be made again
    type(impact_t), intent(out) :: impact
    type(bearing_t), allocatable :: bearing(:), own(:)
    integer :: i

    allocate (impact%bearing(0))
    impact%part_of = bonded_bodies(model, state, try)
    call list_bearings(model, impact%part_of, d, try, bearing)
    call find_approaches(model, cache, state, impact%part_of, rule, d, try, bearing)
    if (.not. any(bearing%closes)) return
    if (.not. any(bearing%strikes)) return
    call find_strokes(model, cache, state, impact%part_of, rule, d, try, bearing)
    call find_islands(held_bodies(model, state, impact%part_of), bearing)
    impact%bearing = pack(bearing, [(any(bearing%strikes .and. bearing%island == bearing(i)%island), i=1, size(bearing))] &
                          .and. bearing%island > 0)
    call find_impulses(rule, impact%bearing)
    allocate (impact%push(model%n_unknowns), impact%change(model%n_unknowns), source=0.0_dp)
    allocate (impact%among(model%n_elements), source=.false.)
    do i = 1, maxval(impact%bearing%island)
      own = pack(impact%bearing, impact%bearing%island == i)
      if (size(own) == 0) cycle
      call push_island(model, cache, state, rule, d, own, try, impact)
      impact%bearing = unpack(own, impact%bearing%island == i, impact%bearing)
    end do
    impact%bearing = pack(impact%bearing, impact%bearing%island > 0)
  end subroutine push_apart

  !> Pushes the bodies of an island when the step begins, and moves them out by the depth to which the impact pressed springs and
  !> bodies. At contacts without a force at the end of the step, this depth is the penetration of the bodies as rigid ones. Contacts
  !> that the impact reaches keep their force from before the step and from loads. If loads alone bring the bodies together there is
  !> no impact, and the springs act as usual.
  subroutine push_island(model, cache, state, rule, d, bearing, try, impact)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: d(:)                 !! (n_unknowns)
    type(bearing_t), intent(inout) :: bearing(:)
    type(contact_try_t), intent(inout) :: try
    type(impact_t), intent(inout) :: impact
    type(rigid_bodies_t) :: bodies
    type(impulse_problem_t) :: problem
    type(impulses_t) :: impulses
    real(dp), dimension(size(d)) :: velocity, acceleration
    real(dp), allocatable, dimension(:, :) :: before, by_loads, of_step, pushed
    type(strikers_t) :: strikers
    type(course_t) :: course
    real(dp) :: barred, e, loss(size(bearing))
    integer :: i

    call set_up_problem(model, cache, state, impact%part_of, d, try, bearing, bodies, problem)
    velocity = state%velocity
    acceleration = state%acceleration
    call end_rates(rule, d, velocity, acceleration)
    pushed = pushed_by(model, cache, state, try, bearing, bodies)
    of_step = motion_of(model, cache, state, bodies, velocity) - rule%velocity_weight/rule%displacement_weight*pushed
    before = of_step
    by_loads = of_step - motion_of(model, cache, state, bodies, state%velocity)
    call find_loss(rule, by_loads, problem, bearing, loss)
    call bear_until_met(problem, bearing, before)
    barred = barred_energy(problem, bearing, of_step + before, try)
    do i = 1, size(bearing)
      barred = barred - dot_product(bearing(i)%impulse, velocity_at(problem, by_loads, i))
    end do
    impulses%motion = before
    call set_least(bearing, before, problem)
    strikers = strikers_of(rule, try, bearing, [(.false., i=1, size(bearing))])
    call strike_in_turn(problem, strikers, 0.0_dp, barred, impulses, course)
    if (.not. impulses%settled) impact%unsolved = bearing(1)%contact
    if (.not. (impulses%settled .and. course%n_impacts > 0 .and. course%taken > barred)) then
      bearing%island = 0
      return
    end if
    e = restitution_of(model, bodies, rule, try%law, problem, bearing, of_step - by_loads, by_loads)
    call set_depths(model, rule, d, deformation_of(model, cache, state, impact%part_of, d, bearing), loss, bearing, try, problem)
    call solve_compression(problem, 0*pushed, impulses)
    pushed = pushed + impulses%motion
    bearing%impulse(1) = bearing%impulse(1) + impulses%P(1, :) ! what it pushes out belongs to it
    call go_on_in_turn(problem, strikers, e, barred, before, bearing, pushed)
    call add_motion(model, cache, state, bodies, pushed, impact%push)
    impact%among(bodies%element) = .true.
  end subroutine push_island

  !> Force that each contact loses because the step is repeated without the impact: its force at the end of the step, less its force
  !> before the step and the force by loads. Contacts that close keep the rest.
  subroutine find_loss(rule, by_loads, problem, bearing, loss)
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: by_loads(:, :)       !! (3, n_bodies) motion that loads make in the step
    type(impulse_problem_t), intent(inout) :: problem !! gets the least velocities across of this motion
    type(bearing_t), intent(inout) :: bearing(:)
    real(dp), intent(out) :: loss(:)             !! (n) force per unit thickness
    type(impulses_t) :: impulses
    integer :: i

    call set_least(bearing, by_loads, problem)
    call solve_compression(problem, by_loads, impulses)
    do i = 1, size(bearing)
      associate (own => bearing(i))
        loss(i) = max(0.0_dp, own%force(1) - merge(0.0_dp, own%before(1), own%closes) &
                              - impulses%P(1, i)/(rule%velocity_weight*rule%dt))
        if (own%closes) own%kept = own%force(1) - loss(i)
      end associate
    end do
  end subroutine find_loss

  !> Releases the springs that an impact pressed, and sets the velocities by which bodies move out of the depth that it pressed them
  !> to. At a contact without a force this depth is the penetration of the bodies as rigid ones.
  subroutine set_depths(model, rule, d, deformation, loss, bearing, try, problem)
    type(model_t), intent(in) :: model
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: d(:), deformation(:) !! (n_unknowns) of the step, and the part of it that deforms bodies
    real(dp), intent(in) :: loss(:)              !! (n) of `find_loss`
    type(bearing_t), intent(in) :: bearing(:)
    type(contact_try_t), intent(inout) :: try
    type(impulse_problem_t), intent(inout) :: problem
    type(gap_and_slip_t) :: now
    real(dp) :: deeper, deepest
    integer :: i

    deepest = by_bodies*maxval(bearing%depth, mask=bearing%closes)
    problem%least = 0.0_dp
    do i = 1, size(bearing)
      associate (own => bearing(i), deformed => across_contact(model, try, bearing(i)%contact, deformation))
        if (.not. own%force(1) > 0) then
          now = gap_and_slip(model, try, own%contact, try%contact(own%contact)%active, d)
          problem%least(i) = (deformed - now%gap)/rule%dt
        else if (own%reached) then
          call release(own%contact, own%force*loss(i)/own%force(1), try, deeper)
          problem%least(i) = (deeper + min(deepest, max(0.0_dp, deformed)))/rule%dt
        end if
      end associate
    end do
  end subroutine set_depths

  !> Replaces the push of an island where impacts with a restitution follow each other in the step: by the push that brings rigid
  !> bodies to where these impacts have them. One impact alone leaves its bodies together until the step ends.
  subroutine go_on_in_turn(problem, strikers, restitution, barred, before, bearing, pushed)
    type(impulse_problem_t), intent(inout) :: problem
    type(strikers_t), intent(in) :: strikers
    real(dp), intent(in) :: restitution
    real(dp), intent(in) :: barred               !! energy that may not come back, force length per unit thickness
    real(dp), intent(in) :: before(:, :)         !! (3, n_bodies) motion before the first impact
    type(bearing_t), intent(inout) :: bearing(:)
    real(dp), intent(inout) :: pushed(:, :)      !! (3, n_bodies)
    type(impulses_t) :: impulses
    type(course_t) :: course

    if (.not. restitution > 0) return
    impulses%motion = before
    call set_least(bearing, before, problem)
    call strike_in_turn(problem, strikers, restitution, barred, impulses, course)
    if (course%n_impacts < 2 .or. .not. impulses%settled) return
    pushed = course%pushed
    bearing%impulse(1) = bearing%impulse(1) + impulses%P(1, :)
  end subroutine go_on_in_turn

  !> Restitution of an impact: none where loads, or weight in flight, bring all of its bodies together.
  pure real(dp) function restitution_of(model, bodies, rule, law, problem, bearing, at_start, by_loads) result(restitution)
    type(model_t), intent(in) :: model
    type(rigid_bodies_t), intent(in) :: bodies
    type(step_rule_t), intent(in) :: rule
    type(contact_law_t), intent(in) :: law
    type(impulse_problem_t), intent(in) :: problem
    type(bearing_t), intent(in) :: bearing(:)
    real(dp), intent(in) :: at_start(:, :)       !! (3, n_bodies) motion when the step begins
    real(dp), intent(in) :: by_loads(:, :)       !! (3, n_bodies) that loads make in the step

    restitution = 0.0_dp
    if (comes_by_itself(problem, bearing, at_start, by_loads, velocity_by_weight(model, bodies, rule))) &
      restitution = law%restitution
  end function restitution_of

  !> Finds the velocities after the impacts of a step that was made with what they push. Where bodies that others drive take more
  !> than there is, it is no impact.
  subroutine rebound(model, cache, state, rule, d, try, impact, possible)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state           !! at the beginning of the step
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: d(:)                 !! (n_unknowns) of the step
    type(contact_try_t), intent(inout) :: try    !! of the step that was made with it
    type(impact_t), intent(inout) :: impact
    logical, intent(out) :: possible
    real(dp), dimension(size(d)) :: velocity, acceleration
    integer :: i

    velocity = state%velocity + impact%push
    acceleration = state%acceleration
    call end_rates(rule, d, velocity, acceleration)
    velocity = velocity - impact%push
    impact%change = -impact%push
    call add_driven(model, cache, state, impact%part_of, rule, d, try, impact%bearing)
    do i = 1, size(impact%bearing)
      associate (own => impact%bearing(i))
        if (own%closes) own%stopped = rule%velocity_weight*rule%dt*force_of(model, try, own%contact, d)
      end associate
    end do
    call close_contacts(model, d, impact, try)
    possible = .true.
    do i = 1, maxval(impact%bearing%island)
      if (any(impact%bearing%island == i)) call rebound_island(model, cache, state, rule, d, velocity, &
                                                         pack(impact%bearing, impact%bearing%island == i), try, impact, possible)
    end do
  end subroutine rebound

  !> Adds contacts to the impacts of a step that close only as these drive bodies against others, with all that those bear.
  pure subroutine add_driven(model, cache, state, part_of, rule, d, try, bearing)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    integer, intent(in) :: part_of(:)            !! (n_blocks) of `bonded_bodies`
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: d(:)                 !! (n_unknowns)
    type(contact_try_t), intent(in) :: try       !! of the step that was made with them
    type(bearing_t), allocatable, intent(inout) :: bearing(:)
    type(bearing_t), allocatable :: more(:)
    logical :: held(model%n_blocks), struck(model%n_blocks)
    integer :: i

    call list_bearings(model, part_of, d, try, more)
    more = pack(more, [(.not. any(bearing%contact == more(i)%contact), i=1, size(more))])
    call find_approaches(model, cache, state, part_of, rule, d, try, more)
    held = held_bodies(model, state, part_of)
    struck = taking_part(part_of, bearing) > 0 .and. .not. held
    more%closes = more%closes .and. [(any(struck(more(i)%block)), i=1, size(more))]
    more%reached = more%closes
    if (.not. any(more%closes)) return
    struck = (struck .or. taking_part(part_of, pack(more, more%closes)) > 0) .and. .not. held
    more = pack(more, [(any(struck(more(i)%block)), i=1, size(more))])
    bearing = [bearing, more]
    call find_islands(held, bearing)
  end subroutine add_driven

  !> Finds the velocities after the impacts of one island.
  subroutine rebound_island(model, cache, state, rule, d, velocity, bearing, try, impact, possible)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: d(:)                 !! (n_unknowns)
    real(dp), intent(in) :: velocity(:)          !! (n_unknowns) before the impact
    type(bearing_t), intent(in) :: bearing(:)
    type(contact_try_t), intent(in) :: try
    type(impact_t), intent(inout) :: impact
    logical, intent(inout) :: possible
    type(rigid_bodies_t) :: bodies
    type(impulse_problem_t) :: problem
    type(impulses_t) :: impulses
    type(strikers_t) :: strikers
    type(course_t) :: course
    real(dp), allocatable, dimension(:, :) :: at_start, before, of_step, turn, without
    real(dp) :: barred, e
    integer :: i

    call set_up_problem(model, cache, state, impact%part_of, d, try, bearing, bodies, problem)
    turn = turn_of_push(model, cache, state, bodies, impact%push)
    of_step = motion_of(model, cache, state, bodies, velocity) + turn
    without = of_step
    do i = 1, size(bearing)
      call apply(problem, i, -bearing(i)%stopped, without)
    end do
    at_start = motion_of(model, cache, state, bodies, state%velocity)
    e = restitution_of(model, bodies, rule, try%law, problem, bearing, at_start, without - at_start)
    before = without
    call bear_until_met(problem, bearing, before)
    barred = barred_energy(problem, bearing, without + before, try) &
             - work_on(model, cache, bodies, impact%push, velocity - state%velocity) + sum(bodies%mass*turn*(of_step - turn/2))
    do i = 1, size(bearing)
      barred = barred - dot_product(bearing(i)%stopped, velocity_at(problem, of_step + without, i))/2
    end do
    call set_least(bearing, before, problem)
    strikers = strikers_of(rule, try, bearing, [(.false., i=1, size(bearing))])
    strikers%meets = bearing%closes .and. presses(try, bearing)
    impulses%motion = before
    call strike_in_turn(problem, strikers, e, barred, impulses, course)
    possible = possible .and. course%taken > barred .and. impulses%settled
    if (.not. impulses%settled) impact%unsolved = bearing(1)%contact
    if (course%cut_short) impact%cut_short = bearing(1)%contact
    impact%work = impact%work + work_of_holders(problem, bearing, impulses, bodies, &
                                                motion_of_holders(model, cache, state, bodies, velocity))
    impact%friction = impact%friction + work_of_friction(problem, before, impulses, barred)
    call add_motion(model, cache, state, bodies, impulses%motion - (of_step - turn), impact%change)
    call take_deformation(model, cache, state, bodies, 1 - e, of_step - turn, velocity, impact%change)
  end subroutine rebound_island

  !> Whether contacts press.
  pure function presses(try, bearing)
    type(contact_try_t), intent(in) :: try
    type(bearing_t), intent(in) :: bearing(:)
    logical :: presses(size(bearing))
    integer :: i

    do i = 1, size(bearing)
      associate (contact => try%contact(bearing(i)%contact))
        presses(i) = contact%entrance(contact%active)%state /= state_open
      end associate
    end do
  end function presses

  !> Work of what holds bodies in an impact, with its own motion: it bears what impulses do not change the motion of bodies by. What
  !> stopped bodies in the step is not the impact's twice.
  pure real(dp) function work_of_holders(problem, bearing, impulses, bodies, holders) result(work)
    type(impulse_problem_t), intent(in) :: problem
    type(bearing_t), intent(in) :: bearing(:)
    type(impulses_t), intent(in) :: impulses     !! of both phases
    type(rigid_bodies_t), intent(in) :: bodies
    real(dp), intent(in) :: holders(:, :)        !! (3, n_bodies) motion
    real(dp) :: impulse(2), taken(3)
    integer :: i, side

    work = 0.0_dp
    do i = 1, size(bearing)
      impulse = impulses%P(:, i) + bearing(i)%borne - bearing(i)%stopped
      do side = 1, 2
        associate (b => problem%body(side, i))
          taken = matmul(problem%row(:, side, :, i), impulse) - bodies%mass(:, b)*matmul(problem%answer(:, side, :, i), impulse)
          work = work - dot_product(holders(:, b), taken)
        end associate
      end do
    end do
  end function work_of_holders

  !> Work of friction in an impact: the sum of all impulses along, times the mean of the velocities before and after. The work is at
  !> most the energy that all impulses take, less `barred`. It is at least zero, because impulses across may reverse a slip within
  !> the impact, which the mean does not show.
  pure real(dp) function work_of_friction(problem, before, impulses, barred) result(work)
    type(impulse_problem_t), intent(in) :: problem
    real(dp), intent(in) :: before(:, :)         !! (3, n_bodies) motion
    type(impulses_t), intent(in) :: impulses
    real(dp), intent(in) :: barred               !! of what the impulses take, that loads did, force length per unit thickness
    real(dp) :: taken(2)                         !! by impulses across and along
    integer :: i

    taken = 0.0_dp
    do i = 1, size(impulses%P, 2)
      taken = taken - 0.5_dp*impulses%P(:, i)*velocity_at(problem, before + impulses%motion, i)
    end do
    work = max(0.0_dp, min(taken(2), sum(taken) - barred))
  end function work_of_friction

  !> Turn of bodies that nothing holds which keeps their angular momentum: the push is added where the step begins and taken back
  !> where it has brought them, about which it has another one.
  pure function turn_of_push(model, cache, state, bodies, push) result(turn)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(rigid_bodies_t), intent(in) :: bodies   !! where the step has brought them
    real(dp), intent(in) :: push(:)              !! (n_unknowns)
    real(dp) :: turn(3, size(bodies%held))
    type(rigid_bodies_t) :: at_start

    turn = 0.0_dp
    if (any(bodies%supported)) return
    call find_bodies(model, cache, state, 0*push, bodies%part_of, at_start)
    turn(3, :) = (angular_momentum(bodies, motion_of(model, cache, state, bodies, push)) &
                  - angular_momentum(at_start, motion_of(model, cache, state, at_start, push)))/sum(bodies%mass(3, :))
  end function turn_of_push

  !> Angular momentum of bodies about the middle of the scene.
  pure real(dp) function angular_momentum(bodies, motion)
    type(rigid_bodies_t), intent(in) :: bodies
    real(dp), intent(in) :: motion(:, :)         !! (3, n_bodies)

    angular_momentum = sum(bodies%mass(1, :)*(bodies%centre(1, :)*motion(2, :) - bodies%centre(2, :)*motion(1, :)) &
                           + bodies%mass(3, :)*motion(3, :))
  end function angular_momentum

  !> Whether a contact closes faster than loads, or weight in flight, could have made it in this step. If none does bodies hop no
  !> farther than a step can tell, and what that is worth is not given back: else they would for ever, and not bear on each other.
  pure logical function comes_by_itself(problem, bearing, motion, by_loads, falling)
    type(impulse_problem_t), intent(in) :: problem
    type(bearing_t), intent(in) :: bearing(:)
    real(dp), intent(in) :: motion(:, :)         !! (3, n_bodies) when the step began
    real(dp), intent(in) :: by_loads(:, :)       !! (3, n_bodies) that loads made in the step
    real(dp), intent(in) :: falling(:, :)        !! (3, n_bodies) that weight makes in a step of bodies in flight
    real(dp) :: begun(2), added(2), in_flight(2)
    integer :: i

    comes_by_itself = .true.
    do i = 1, size(bearing)
      if (.not. bearing(i)%closes) cycle
      begun = velocity_at(problem, motion, i)
      added = velocity_at(problem, by_loads, i)
      in_flight = sum(problem%row(:, :, 1, i)*falling(:, problem%body(:, i)), 1) ! of either body
      if (-begun(1) > (1 + no_faster)*max(abs(added(1)), sum(abs(in_flight)))) return
    end do
    comes_by_itself = .false.
  end function comes_by_itself

  !> Motion that weight, and the acceleration of the ground, make in a step of bodies in flight, of those that are held in part by
  !> what that leaves of it.
  pure function velocity_by_weight(model, bodies, rule) result(motion)
    type(model_t), intent(in) :: model
    type(rigid_bodies_t), intent(in) :: bodies
    type(step_rule_t), intent(in) :: rule
    real(dp) :: motion(3, size(bodies%held))
    real(dp) :: force(2, size(bodies%held)), per_mass(2)
    integer :: b

    force = 0.0_dp
    if (allocated(model%effects%gravity)) then
      do b = 1, size(bodies%held)
        associate (element => bodies%element(bodies%first(b):bodies%first(b + 1) - 1))
          force(2, b) = -mean_share_of_weight(model, rule)*sum(model%effects%gravity%weight(element))
        end associate
      end do
    end if
    if (allocated(model%effects%base_acceleration)) then
      per_mass = force_of_base(model%effects%base_acceleration, 1.0_dp, rule)
      do b = 1, size(bodies%held)
        force(:, b) = force(:, b) + bodies%mass(1, b)*per_mass
      end do
    end if
    do b = 1, size(bodies%held)
      motion(:, b) = rule%dt*matmul(bodies%mobility(:, :2, b), force(:, b))
    end do
  end function velocity_by_weight

  !> Adds to the motion before an impact what contacts that opened bore until then.
  pure subroutine bear_until_met(problem, bearing, motion)
    type(impulse_problem_t), intent(in) :: problem
    type(bearing_t), intent(in) :: bearing(:)
    real(dp), intent(inout) :: motion(:, :)      !! (3, n_bodies)
    integer :: i

    do i = 1, size(bearing)
      call apply(problem, i, bearing(i)%borne, motion)
    end do
  end subroutine bear_until_met

  !> Work that changing the motion of bodies by one field of rates takes where it changes by another.
  pure real(dp) function work_on(model, cache, bodies, push, change)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(rigid_bodies_t), intent(in) :: bodies
    real(dp), intent(in) :: push(:), change(:)   !! (n_unknowns)
    integer :: k

    work_on = 0.0_dp
    do k = 1, size(bodies%element)
      associate (e => bodies%element(k))
        associate (ids => model%elements%unknown(:, e))
          work_on = work_on + dot_product(push(ids), matmul(cache%element(e)%mass_matrix, change(ids)))
        end associate
      end associate
    end do
  end function work_on

  !> Energy that compression takes and that may not come back: what contacts that opened bore, and what springs keep.
  pure real(dp) function barred_energy(problem, bearing, twice_mean, try) result(barred)
    type(impulse_problem_t), intent(in) :: problem
    type(bearing_t), intent(in) :: bearing(:)
    real(dp), intent(in) :: twice_mean(:, :)     !! (3, n_bodies) motion without and with what contacts that opened bore
    type(contact_try_t), intent(in) :: try
    integer :: i

    barred = 0.0_dp
    do i = 1, size(bearing)
      associate (stiffness => try%contact(bearing(i)%contact)%entrance(1)%stiffness(1))
        barred = barred + 0.5_dp*dot_product(bearing(i)%borne, velocity_at(problem, twice_mean, i)) &
                 + bearing(i)%kept**2/(2*stiffness)
      end associate
    end do
  end function barred_energy

  !> Motion that the forces of the impact make in the step, along the rows that they act on: of its middle.
  pure function pushed_by(model, cache, state, try, bearing, bodies) result(motion)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(contact_try_t), intent(in) :: try
    type(bearing_t), intent(in) :: bearing(:)
    type(rigid_bodies_t), intent(in) :: bodies
    real(dp) :: motion(3, size(bodies%held))
    real(dp) :: along(2*n), force(2*n)           !! on the unknowns of the pair: of a unit along, times time
    integer :: b, i, pair(2), side

    motion = 0.0_dp
    do i = 1, size(bearing)
      associate (active => try%contact(bearing(i)%contact)%active)
        pair = elements_of(try, bearing(i)%contact, active)
        call rows_along(try, bearing(i)%contact, active, along)
        force = bearing(i)%impulse(1)*row_across(try, bearing(i)%contact, active) + bearing(i)%impulse(2)*along
      end associate
      do side = 1, 2
        b = bodies%number(model%elements%block(pair(side)))
        motion(:, b) = motion(:, b) + matmul(bodies%mobility(:, :, b), matmul(force((side - 1)*n + 1:side*n), &
                                                                          modes_of(model, cache, state, bodies, pair(side))))
      end do
    end do
  end function pushed_by

  !> Lets contact i lose force at the end of the step as it is: multipliers first, then springs, across by a way that is not made.
  pure subroutine release(i, loss, try, way)
    integer, intent(in) :: i
    real(dp), intent(in) :: loss(2)              !! of force across and along
    type(contact_try_t), intent(inout) :: try
    real(dp), intent(out) :: way                 !! by which it is to be less deep, length
    real(dp) :: less(2)

    associate (k => try%contact(i)%active)
      associate (entrance => try%contact(i)%entrance(k), geometry => try%geometry(k, i))
        less = merge(sign(min(abs(loss), abs(entrance%multiplier)), loss), 0.0_dp, entrance%multiplier*loss > 0)
        entrance%multiplier = entrance%multiplier - less
        less = loss - less
        way = less(1)/entrance%stiffness(1)
        if (entrance%state == state_locked) &
          entrance%anchor = entrance%anchor - less(2)/(entrance%stiffness(2)*geometry%edge_length)
      end associate
    end associate
  end subroutine release

  !> Closes the contacts of the impact where the step has brought their bodies, with the force with which loads press them.
  pure subroutine close_contacts(model, d, impact, try)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: d(:)                 !! (n_unknowns)
    type(impact_t), intent(inout) :: impact
    type(contact_try_t), intent(inout) :: try
    type(gap_and_slip_t) :: now
    logical :: meets(size(impact%bearing))
    integer :: i

    meets = .true.
    do i = 1, size(impact%bearing)
      if (.not. impact%bearing(i)%closes) cycle
      associate (own => impact%bearing(i), contact => try%contact(impact%bearing(i)%contact), law => try%law)
        associate (entrance => contact%entrance(contact%active), geometry => try%geometry(contact%active, own%contact))
          now = gap_and_slip(model, try, own%contact, contact%active, d)
          meets(i) = now%gap < own%moment .or. (own%kept > 0 .and. .not. law%restitution > 0) ! plastic ones do not part
          entrance%state = state_open
          if (.not. meets(i)) cycle
          entrance%state = merge(state_locked, state_sliding, friction_of(law, entrance) > 0)
          entrance%multiplier = 0.0_dp
          entrance%rest = entrance%rest + now%gap + own%kept/entrance%stiffness(1)
          entrance%anchor = entrance%anchor + now%slip/now%edge_length
          geometry%gap = geometry%gap - now%gap - own%kept/entrance%stiffness(1)
        end associate
      end associate
    end do
    call take_all(try)
    impact%bearing = pack(impact%bearing, meets .or. impact%bearing%impulse(1) > 0)
  end subroutine close_contacts

end module scree_impact
