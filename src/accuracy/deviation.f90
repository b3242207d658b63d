!> How far a run is off: an estimate of the error that each step makes, and of what has become of those before it.
!>
!> Blocks are treated as rigid: x, y and the rotation times its radius of gyration make a vector q, whose length is the root mean
!> square over the block. Let v0, v1 be the velocities at both ends of a step, and j the rate of change of the mean acceleration
!> from the step before to this one. A step that moves by d is off by
!>
!>     place      d - [dt (v0 + v1)/2 - dt^3 j/12]      what the motion at its ends says, to the fourth order (Hermite)
!>     motion     (beta - 1/2) dt^2 (j - w^3)           where forces balance at beta dt, not in the middle (Newmark), w^3 of the
!>                                                      spin w where strain is Green's: what points feel as they go round
!>     growth     u_X v_Y - u_Y v_X                     area that small strain makes of a turn (Zhang et al. 2019, Eq. 14)
!>
!> like the error of Zienkiewicz and Xie 1991, with velocities in place of accelerations at both ends. So it holds for every scheme,
!> and sees how a body turns. An error goes on. For a free block e' = u, u' = 0. For a block that is supported, or touches, it goes
!> on along its path by e' = u, u' = k e, with k = da/ds, the change of its acceleration along the path s
!> (doc/theory/error-estimate.md, eq-error-growth).
!>
!> A step in which contacts of a block open or close has no order. With restitution a blow makes an error by its instant within the
!> step (`take_blow`). Without it that error is bounded, apart from the rest.
module scree_deviation
  use scree_block_motion, only: block_motions_t, motions_of, strike_t, strikes_of
  use scree_integrator, only: held_weight
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_pairs, only: pairs_without
  use scree_scene, only: rotation_linear, scheme_newmark, settings_t
  use scree_state, only: deviation_t, state_t
  implicit none
  private
  public :: begin_deviation, error_of_blocks, estimate_step, order_of, remembered_time, share_off, step_error_t, way_of_run

  !> Fraction of the run over which the errors of steps and the acceleration along the path are averaged, so that ringing drops out.
  !> Where steps are longer, the past keeps a least weight in each step.
  real(dp), parameter :: remembered_time = 0.01_dp, least_memory = 0.8_dp
  !> A supported block only shakes on the spot where the square of its mean velocity is below this fraction of its mean square.
  real(dp), parameter :: on_the_spot = 0.25_dp
  !> Fraction of the squared displacement that the centre of a block must have, for a lead of the block to be known.
  real(dp), parameter :: least_of_centre = 0.1_dp
  !> Least displacement that errors are compared with, over the root of the area of the blocks.
  real(dp), parameter :: least_way = 0.1_dp
  !> An error grows by e to this at most in the time that is left, where forces drive it.
  real(dp), parameter :: farthest = 3.0_dp

  !> Where in the run a step is.
  type :: span_t
    logical :: first = .false.              !! of the run
    real(dp) :: last = 0.0_dp, dt = 0.0_dp  !! size of the step before, and of the step, time
    real(dp) :: time = 0.0_dp, left = 0.0_dp !! at its end: time, and what is left of the run
    real(dp) :: memory = 0.0_dp             !! over which means are taken, time
    real(dp) :: remembered = 0.0_dp         !! fraction of sums that stays in the step
  end type span_t

  !> What is wrong with a step of one block.
  type :: defect_t
    logical :: changed = .false.            !! contacts of the block opened or closed
    logical :: known = .false.              !! none did, nor in the step before
    real(dp) :: apart = 0.0_dp              !! of the mean accelerations of this and the step before, time
    real(dp) :: velocity(3) = 0.0_dp, acceleration(3) = 0.0_dp !! means over the step: length/time, length/time^2
    real(dp) :: ahead(3) = 0.0_dp           !! of the way that the velocity makes, length
    real(dp) :: place(3) = 0.0_dp           !! error of the way, length
    real(dp) :: motion(3) = 0.0_dp          !! of the velocity at the end, length/time
    logical :: struck = .false.             !! the step has a blow
    real(dp) :: taken(3) = 0.0_dp           !! velocity that a change of the size of steps dissipates, length/time
  end type defect_t

  !> What a step makes of the error of the run.
  type :: step_error_t
    real(dp), allocatable :: at_end(:)      !! (n_blocks) what it will have come to at the end of the run, length
    real(dp), allocatable :: growth(:)      !! (n_blocks) area over the area
    real(dp), allocatable :: total(:)       !! (n_blocks) what all steps so far will have come to, length
    real(dp), allocatable :: blow(:)        !! (n_blocks) what one in flight will have come to, as it acts at the end, length
    real(dp), allocatable :: struck_at(:)   !! (n_blocks) fraction of the step that was before it
    real(dp), allocatable :: impact(:)      !! (n_blocks) what it may turn by as nobody knows when in the step it was struck, length
    real(dp), allocatable :: impacts(:)     !! (n_blocks) that of all impacts before, length
    logical, allocatable :: known(:)        !! (n_blocks) there is an estimate of `at_end`
  end type step_error_t

contains

  !> Begins the estimate of a run, with nothing off, or goes on with it in a later stage, whose first step has none before it.
  pure subroutine begin_deviation(model, cache, state)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(inout) :: state
    type(block_motions_t) :: motion

    if (allocated(state%deviation)) then
      state%deviation%smooth = .false.
      return
    end if
    motion = motions_of(model, cache, state)
    allocate (state%deviation)
    associate (deviation => state%deviation, n => model%n_blocks)
      deviation%from = motion%centre
      allocate (deviation%place(3, n), deviation%motion(3, n), deviation%growth(n), deviation%impact(n), deviation%late(n), &
                deviation%acceleration(3, n), deviation%path_gain(n), deviation%path_square(n), deviation%mean_velocity(3, n), &
                deviation%mean_acceleration(3, n), deviation%mean_square(n), deviation%added(3, n), deviation%added_size(n), &
                deviation%added_over(n), source=0.0_dp)
      allocate (deviation%smooth(n), source=.false.)
    end associate
  end subroutine begin_deviation

  !> Takes in the errors of a step, and says what they will come to.
  pure subroutine estimate_step(model, before, after, began, state, step)
    type(model_t), intent(in) :: model
    type(block_motions_t), intent(in) :: before, after   !! at both ends of the step
    type(state_t), intent(in) :: began            !! at its beginning
    type(state_t), intent(inout) :: state         !! at its end, with the deviation of its beginning
    type(step_error_t), intent(out) :: step
    real(dp) :: growth(model%n_blocks)
    type(span_t) :: span
    type(strike_t) :: strike(model%n_blocks)
    logical :: changed(model%n_blocks)
    integer :: b, k

    span%first = began%step == 0
    span%last = began%pace%last
    span%dt = state%pace%last
    span%time = state%time
    span%left = max(0.0_dp, model%settings%end_time - state%time)
    span%memory = remembered_time*model%settings%end_time
    span%remembered = max(least_memory, exp(-span%dt/span%memory))
    step%impacts = state%deviation%impact
    allocate (step%at_end(model%n_blocks), step%total(model%n_blocks), step%impact(model%n_blocks), step%blow(model%n_blocks), &
              step%struck_at(model%n_blocks), source=0.0_dp)
    allocate (step%known(model%n_blocks), source=.false.)
    changed = .false.
    if (allocated(model%effects%contact)) then
      call mark(pairs_without(after%touching, before%touching), changed)
      call mark(pairs_without(before%touching, after%touching), changed)
    end if
    growth = false_growth(model, began, state)
    step%growth = abs(growth)
    state%deviation%growth = state%deviation%growth + growth
    if (allocated(model%effects%contact)) then
      if (model%effects%contact%restitution >= 0) strike = strikes_of(model, before, after, began, span%dt, state%deviation)
    end if
    do k = 1, size(model%free_block)
      b = model%free_block(k)
      if (is_asleep(state, b)) then
        step%total(b) = norm2(state%deviation%place(:, b))
        cycle
      end if
      call estimate_block(model, before, after, b, changed(b), strike(b), span, state%deviation, step)
      state%deviation%way = max(state%deviation%way, displacement(after, state%deviation, b))
    end do
    associate (deviation => state%deviation)
      deviation%lost = deviation%lost .or. any(error_of_blocks(deviation) > max(deviation%way, after%gyration))
    end associate
    state%deviation%rough = count(changed(model%free_block))
    state%deviation%step = maxval(step%at_end)

  contains

    !> Marks the blocks of contacts that opened or closed.
    pure subroutine mark(touching, changed)
      integer, intent(in) :: touching(:, :)     !! (2, n) vertex and edge
      logical, intent(inout) :: changed(:)      !! (n_blocks)
      integer :: i

      do i = 1, size(touching, 2)
        changed(model%outlines%block(touching(:, i))) = .true.
      end do
    end subroutine mark

  end subroutine estimate_step

  !> Whether a block sleeps: what it is off by stays.
  pure logical function is_asleep(state, b)
    type(state_t), intent(in) :: state
    integer, intent(in) :: b

    is_asleep = .false.
    if (allocated(state%sleep)) is_asleep = state%sleep%island(b) > 0
  end function is_asleep

  !> Takes in the error of a step of one block.
  pure subroutine estimate_block(model, before, after, b, changed, strike, span, deviation, step)
    type(model_t), intent(in) :: model
    type(block_motions_t), intent(in) :: before, after
    integer, intent(in) :: b
    logical, intent(in) :: changed                !! some of its contacts opened or closed
    type(strike_t), intent(in) :: strike          !! none without restitution
    type(span_t), intent(in) :: span
    type(deviation_t), intent(inout) :: deviation
    type(step_error_t), intent(inout) :: step
    type(defect_t) :: defect
    real(dp) :: k

    defect = defect_of(model, before, after, b, changed, span, deviation)
    step%known(b) = defect%known
    if (strike%speed > 0) then
      call take_blow(model, before, after, b, strike, span, deviation, defect, step)
    else
      deviation%motion(:, b) = deviation%motion(:, b) - deviation%late(b)*defect%acceleration
      deviation%late(b) = 0.0_dp
    end if
    if (changed .and. .not. span%first .and. .not. step%blow(b) > 0) then
      step%impact(b) = span%dt*abs(after%velocity(3, b) - before%velocity(3, b))
      deviation%impact(b) = deviation%impact(b) + step%impact(b)
    end if
    k = 0.0_dp
    if (after%held(b) .and. .not. defect%struck) then
      call follow_way(model%settings, after%gyration(b), b, span, defect, deviation, k)
    else
      deviation%path_gain(b) = 0.0_dp
      deviation%path_square(b) = 0.0_dp
    end if
    call carry_on(model%settings, k, b, span, defect, deviation, step)
  end subroutine estimate_block

  !> Error of a step in which a block is struck, and the effect of the blow on earlier errors.
  !>
  !> The scheme applies the blow at the end of the step, by impulses at the place of the body there. It happens T earlier. Let a be
  !> the acceleration before the blow, b that after it, and V the change of velocity by the blow, at the arm r. Let w be the speed
  !> of approach, w' its gain, e the restitution and s the spin at the end. A block in flight is off by
  !>
  !>     place      E = d - [(dt - T) (v0 + a (dt - T)/2) + T (v1 - U - a T/2)]
  !>     motion     U = T w'/w V/(1 + e) + T s^2 (r.V) (V/V^2 - v1/v1^2) + T (a - b)
  !>
  !> because it strikes faster by w' T, and because the arm has turned by s T. The term with b is known when the next step has been
  !> made. A block that was ahead by h towards the edge, and faster by u, is struck h/w earlier. This changes its place by V h/w and
  !> its motion by V u/w - h/w (w'/w V + a - b). A block that others hold, such as on a track with kinks, gains the constrained
  !> parts of a and b. Of U only the part along v1 remains.
  pure subroutine take_blow(model, before, after, b, strike, span, deviation, defect, step)
    type(model_t), intent(in) :: model
    type(block_motions_t), intent(in) :: before, after
    integer, intent(in) :: b
    type(strike_t), intent(in) :: strike
    type(span_t), intent(in) :: span
    type(deviation_t), intent(inout) :: deviation
    type(defect_t), intent(inout) :: defect
    type(step_error_t), intent(inout) :: step
    real(dp), dimension(3) :: added, aside, by_late, carried, end_velocity, moved
    real(dp) :: at, earlier, faster, harder, late, turned

    at = strike%at/strike%speed
    late = span%dt - at
    end_velocity = end_velocity_of(model, after, b)
    associate (e => deviation%place(:, b), u => deviation%motion(:, b), a => deviation%acceleration(:, b))
      added = end_velocity - before%velocity(:, b) - a*span%dt
      defect%acceleration = a
      defect%struck = .true.
      turned = late*(end_velocity(3)/before%gyration(b))**2*dot_product(strike%arm, added(:2))/strike%speed
      by_late = -turned*end_velocity/max(tiny(late), sum(end_velocity**2))
      if (before%held(b)) then
        u = u + by_late
        return
      end if
      faster = within(strike%faster/strike%speed, 1.0_dp) ! errors that are not small do not multiply from blow to blow
      earlier = within(strike%ahead/strike%speed + at*faster, span%time)
      harder = strike%gain/strike%speed
      by_late = by_late + late*harder*added/(1 + model%effects%contact%restitution) &
                + turned*added/max(tiny(late), sum(added**2))
      moved = way_of(before, after, b)
      aside = moved - at*(before%velocity(:, b) + 0.5_dp*at*a) - late*(end_velocity - by_late - 0.5_dp*late*a)
      carried = e + at*u + added*earlier + aside
      u = u + added*faster
      carried = carried + late*u
      u = u + by_late + (late - earlier)*a - earlier*harder*added
      defect%place = carried - e - span%dt*u
      deviation%late(b) = deviation%late(b) + late - earlier
      step%blow(b) = norm2(aside + span%left*by_late)
      step%struck_at(b) = at/span%dt
    end associate
  end subroutine take_blow

  !> Velocity of a block at the end of a step, of which a fraction is handed on.
  pure function end_velocity_of(model, after, b) result(velocity)
    type(model_t), intent(in) :: model
    type(block_motions_t), intent(in) :: after
    integer, intent(in) :: b
    real(dp) :: velocity(3)                       !! x, y and the rotation times the radius of gyration, length/time

    velocity = after%velocity(:, b)/model%effects%carried
  end function end_velocity_of

  !> Way of a block in a step.
  pure function way_of(before, after, b) result(way)
    type(block_motions_t), intent(in) :: before, after
    integer, intent(in) :: b
    real(dp) :: way(3)                            !! x, y and the rotation times the radius of gyration, length

    way(1:2) = after%centre(:, b) - before%centre(:, b)
    way(3) = before%gyration(b)*(after%rotation(b) - before%rotation(b))
  end function way_of

  !> A number, or the bound of its size that it is beyond.
  pure real(dp) function within(number, bound)
    real(dp), intent(in) :: number, bound

    within = max(-bound, min(bound, number))
  end function within

  !> What is wrong with a step of one block, as far as the motion at its ends tells; remembers its acceleration.
  pure function defect_of(model, before, after, b, changed, span, deviation) result(defect)
    type(model_t), intent(in) :: model
    type(block_motions_t), intent(in) :: before, after
    integer, intent(in) :: b
    logical, intent(in) :: changed
    type(span_t), intent(in) :: span
    type(deviation_t), intent(in) :: deviation
    type(defect_t) :: defect
    real(dp) :: moved(3), end_velocity(3), jerk(3)

    associate (beta => model%settings%beta, dt => span%dt)
      end_velocity = end_velocity_of(model, after, b)
      moved = way_of(before, after, b)
      defect%acceleration = (end_velocity - before%velocity(:, b))/dt
      defect%velocity = 0.5_dp*(before%velocity(:, b) + end_velocity)
      defect%ahead = moved - dt*defect%velocity
      defect%apart = 0.5_dp*(dt + span%last)
      if (model%settings%scheme == scheme_newmark) defect%apart = beta*dt + (1 - beta)*span%last
      defect%known = deviation%smooth(b) .and. .not. changed
      if (defect%known) then
        jerk = (defect%acceleration - deviation%acceleration(:, b))/defect%apart
        defect%place = defect%ahead + dt**3/12*jerk
        if (model%settings%scheme == scheme_newmark) then
          if (model%effects%large_deformation) jerk(3) = jerk(3) - defect%velocity(3)**3/max(tiny(dt), before%gyration(b)**2)
          defect%motion = (beta - 0.5_dp)*dt**2*jerk
        end if
      else if (span%first) then
        defect%place = defect%ahead ! loads are there at once, and stay
      end if
      defect%changed = changed
    end associate
  end function defect_of

  !> Takes the error of a block that is held, and what a step adds, along the way that it goes, and tells how that speeds it up: k
  !> in u' = k e.
  pure subroutine follow_way(settings, gyration, b, span, defect, deviation, k)
    type(settings_t), intent(in) :: settings
    real(dp), intent(in) :: gyration              !! length
    integer, intent(in) :: b
    type(span_t), intent(in) :: span
    type(defect_t), intent(inout) :: defect
    type(deviation_t), intent(inout) :: deviation
    real(dp), intent(out) :: k                    !! 1/time^2
    real(dp) :: across(3), along(3), before(3), per_speed, pull, share, speed

    k = 0.0_dp
    before = deviation%mean_acceleration(:, b)
    share = exp(-span%dt/span%memory)
    if (span%first) share = 0.0_dp
    associate (v => deviation%mean_velocity(:, b), a => deviation%mean_acceleration(:, b), square => deviation%mean_square(b), &
               gain => deviation%path_gain(b), path_square => deviation%path_square(b), dt => span%dt)
      if (span%first .or. defect%known) then
        v = share*v + (1 - share)*defect%velocity
        a = share*a + (1 - share)*defect%acceleration
        square = share*square + (1 - share)*dot_product(defect%velocity, defect%velocity)
      end if
      speed = norm2(v)
      if (.not. speed > 0) return
      along = v/speed
      pull = dot_product(along, a)
      across = a - pull*along
      if (defect%known) then
        gain = span%remembered*gain + dt*(speed*dot_product(along, a - before)/defect%apart + sum(across**2))
        path_square = span%remembered*path_square + dt*speed**2
      end if
      if (path_square > 0) k = min(gain/path_square, norm2(defect%acceleration)/max(tiny(speed), gyration))
      deviation%place(:, b) = along*dot_product(along, deviation%place(:, b))
      deviation%motion(:, b) = along*dot_product(along, deviation%motion(:, b))
      defect%place = along*dot_product(along, defect%place)
      defect%motion = along*dot_product(along, defect%motion)
      if (speed**2 < on_the_spot*square) then
        defect%place = 0.0_dp
        defect%motion = 0.0_dp
      else if (settings%scheme /= scheme_newmark) then
        per_speed = speed/(speed**2 + (pull*dt)**2)
        if (defect%known) defect%motion = (defect%place - along*lead(defect%ahead, along))*pull*per_speed
        defect%taken = along*0.5_dp*held_weight(settings)*sum(a**2)*(dt - span%last)**2*per_speed
      end if
    end associate
  end subroutine follow_way

  !> How far along its way the scheme puts a block before what its velocity makes, which is no lag in time: it holds the energy of
  !> that. Of the rotation it cannot be told from the turn of a step, so it is taken from the way of the centre.
  pure real(dp) function lead(ahead, along)
    real(dp), intent(in) :: ahead(3), along(3)

    lead = 0.0_dp
    if (sum(along(:2)**2) > least_of_centre) lead = dot_product(ahead(:2), along(:2))/sum(along(:2)**2)
  end function lead

  !> Carries the error of a block to the end of a step, with what the step adds, and tells what that will come to.
  pure subroutine carry_on(settings, k, b, span, defect, deviation, step)
    type(settings_t), intent(in) :: settings
    real(dp), intent(in) :: k                     !! 1/time^2
    integer, intent(in) :: b
    type(span_t), intent(in) :: span
    type(defect_t), intent(in) :: defect
    type(deviation_t), intent(inout) :: deviation
    type(step_error_t), intent(inout) :: step
    real(dp) :: added(3), one_way, power, share, weight(2)

    weight = becomes(k, span%dt, span%left)
    power = span%dt**order_of(settings)
    share = 1.0_dp
    associate (e => deviation%place(:, b), u => deviation%motion(:, b), sum_added => deviation%added(:, b), &
               sum_size => deviation%added_size(b), added_over => deviation%added_over(b), dt => span%dt)
      added = weight(1)*defect%place + weight(2)*defect%motion
      if (span%first .or. defect%known) then
        sum_added = span%remembered*sum_added + added
        sum_size = span%remembered*sum_size + norm2(added)
        added_over = span%remembered*added_over + power*dt
      end if
      one_way = max(0.0_dp, 2*norm2(sum_added) - sum_size) ! what goes back and forth adds up to nothing
      if (norm2(sum_added) > 0) share = one_way/norm2(sum_added)
      if (defect%struck) share = 1.0_dp
      if (added_over > 0) & ! before the run nothing was added
        step%at_end(b) = dt*power*one_way/(added_over + power*span%memory*exp(-span%time/span%memory))
      u = u + k*dt*e + share*defect%motion - defect%taken
      if (k*max(dt, span%memory)**2 < -1) u = 0.0_dp ! springs hold it: it rings within what means are taken over
      e = e + dt*u + share*defect%place
      step%total(b) = norm2(weight(1)*e + weight(2)*u)
      if (k < 0) step%total(b) = hypot(norm2(e), weight(2)*norm2(u))
    end associate
    deviation%acceleration(:, b) = defect%acceleration
    deviation%smooth(b) = .not. defect%changed
  end subroutine carry_on

  !> Order of a scheme: the power of the size of steps that what they add in a time goes with.
  pure integer function order_of(settings) result(order)
    type(settings_t), intent(in) :: settings

    order = 2
    if (settings%scheme == scheme_newmark .and. settings%beta > 0.5_dp) order = 1
  end function order_of

  !> What a unit of place and one of motion become at most in the time that is left, by u' = k e: 1, time.
  pure function becomes(k, dt, left) result(weight)
    real(dp), intent(in) :: k             !! 1/time^2
    real(dp), intent(in) :: dt, left      !! time
    real(dp) :: weight(2), x

    weight = [1.0_dp, left]
    if (k*dt**2 < -1) then
      weight(2) = min(left, dt)
    else if (k < 0) then
      weight(2) = min(left, 1/sqrt(-k))
    else if (k > 0) then
      x = min(farthest, sqrt(k)*left)
      weight = [cosh(x), sinh(x)/sqrt(k)]
      if (.not. left > 0) weight(2) = 0.0_dp
    end if
  end function becomes

  !> Area that small strain makes of the turns of a step, over the area, of each block.
  pure function false_growth(model, began, state) result(growth)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: began, state     !! at both ends of the step
    real(dp) :: growth(model%n_blocks)
    real(dp) :: area(model%n_blocks), theta(4), det
    integer :: e, k

    growth = 0.0_dp
    area = 0.0_dp
    if (model%effects%rotation /= rotation_linear .or. model%effects%large_deformation) return
    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      associate (b => model%elements%block(e), F0 => began%deformation(:, e), F1 => state%deformation(:, e))
        det = F0(1)*F0(4) - F0(2)*F0(3)
        area(b) = area(b) + model%elements%mass(e)
        theta = [F1(1)*F0(4) - F1(3)*F0(2), F1(2)*F0(4) - F1(4)*F0(2), F1(3)*F0(1) - F1(1)*F0(3), F1(4)*F0(1) - F1(2)*F0(3)]/det &
                - [1.0_dp, 0.0_dp, 0.0_dp, 1.0_dp]
        growth(b) = growth(b) + model%elements%mass(e)*(theta(1)*theta(4) - theta(2)*theta(3))
      end associate
    end do
    where (area > 0) growth = growth/area
  end function false_growth

  !> Displacement of a block since the start, the root mean square over it as of a rigid one.
  pure real(dp) function displacement(motion, deviation, b)
    type(block_motions_t), intent(in) :: motion
    type(deviation_t), intent(in) :: deviation
    integer, intent(in) :: b

    displacement = norm2([motion%centre(:, b) - deviation%from(:, b), 2*motion%gyration(b)*sin(0.5_dp*motion%rotation(b))])
  end function displacement

  !> What errors are compared with: the largest displacement of a block so far, at least a tenth of the root of the area of all that
  !> can move; length.
  pure real(dp) function scale_of(model, cache, deviation) result(scale)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(deviation_t), intent(in) :: deviation
    real(dp) :: area
    integer :: k

    area = 0.0_dp
    do k = 1, size(model%elements%free)
      area = area + cache%element(model%elements%free(k))%kinematics%area
    end do
    scale = max(deviation%way, least_way*sqrt(area))
  end function scale_of

  !> Largest displacement that a run has come to, or comes to if it goes on for half as long as it has been, and no longer than it
  !> is to; length.
  pure real(dp) function way_of_run(model, cache, state, motion) result(way)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(block_motions_t), intent(in) :: motion

    way = scale_of(model, cache, state%deviation) + 0.5_dp*min(state%time, max(0.0_dp, model%settings%end_time - state%time)) &
          *maxval(norm2(motion%velocity, 1))
  end function way_of_run

  !> Estimated error of the run over the displacement of the scene: the larger of growth and of the error of places. It is at least
  !> 1 where a block was off by more than the displacement before, because nobody knows what it met then.
  pure real(dp) function share_off(model, cache, deviation) result(share)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(deviation_t), intent(in) :: deviation

    share = max(maxval(error_of_blocks(deviation))/scale_of(model, cache, deviation), maxval(abs(deviation%growth)))
    if (deviation%lost) share = max(share, 1.0_dp)
  end function share_off

  !> Estimated error of the place of each block, length.
  pure function error_of_blocks(deviation) result(error)
    type(deviation_t), intent(in) :: deviation
    real(dp) :: error(size(deviation%growth))

    error = norm2(deviation%place, 1)
  end function error_of_blocks

end module scree_deviation
