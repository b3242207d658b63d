!> Small steps: many rigid blocks, contact found anew in each step, one sweep of sequential impulses.
!>
!> A step of the run is made of small ones of one size h. Velocities belong to the middle of a small step (Stoermer, Verlet). Loads
!> change them, then a sweep changes them by impulses. The bodies move by them, and a second sweep takes out what the first one gave
!> to push overlaps out (`scree_sweeps`). Contact has no margin (`scree_contact_rows`). Every step of the run begins from the state
!> alone: what it keeps of the bodies decides no bit.
!>
!> M. Macklin et al., *Small steps in physics simulation* (SCA 2019); G.-H. Shi, *Contact theory* (2015).
module scree_small_steps
  use scree_bodies, only: bodies_t
  use scree_body_loads, only: body_loads_t, find_loads
  use scree_bolt, only: accept_bolts, is_grouted
  use scree_contact_rows, only: keep_impulses, look_for_contacts, make_rows, row_point_t, rows_t
  use scree_effects, only: refresh_elements
  use scree_energy, only: close_books
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_handed_contacts, only: bond_faces, give_contacts, take_contacts
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_near_pieces, only: find_near, grow_skin, is_worn
  use scree_many_bodies, only: cut_bodies, place_corners, put_bodies_back, take_bodies
  use scree_state, only: bolt_memory_t, state_t
  use scree_step_choice, only: fastest_vertex, largest_weight, number_of_steps
  use scree_sweeps, only: advance_rows, bounce, start_warm, sweep
  use scree_text, only: number_text
  use scree_ties, only: count_ties, find_ties, move_points, start_ties_warm, sweep_ties, tie_t, turn_arms, work_of_ties
  use scree_timers, only: begin_phase, phase_alone, phase_search, phase_update
  implicit none
  private
  public :: advance_by_small_steps, small_outcome_t

  !> Small steps of a stage that settle their rows by many sweeps: a single one takes some steps to find the forces of what rests.
  integer, parameter :: first_steps = 10, first_sweeps = 30
  integer, parameter :: worth_threads = 3000 !! bodies that move, below which threads wait for each other longer than they work
  real(dp), parameter :: slow = 10.0_dp      !! speeds that weight makes in a step, below which nothing bounces

  !> What a step of the run came to.
  type :: small_outcome_t
    integer :: steps = 0                     !! small ones
    integer :: sweeps = 0
    real(dp) :: work = 0.0_dp                !! of loads, the ground and ties, force length per unit thickness
    integer, allocatable :: reached(:)       !! blocks asleep that others touch; allocated: the state is as it was
  end type small_outcome_t

  !> The small steps of one step of the run.
  type :: march_t
    integer :: threads = 1
    real(dp) :: h = 0.0_dp                   !! their size, time
    real(dp) :: time = 0.0_dp                !! of the stage, now
    real(dp) :: kick = 0.0_dp                !! over which loads change velocities in this one, time
    type(body_loads_t) :: loads
    type(rows_t) :: rows
    type(tie_t), allocatable :: ties(:)
    type(bolt_memory_t), allocatable :: bolts !! now
    real(dp), allocatable :: point(:, :)     !! (2, n_points) places now, length
    real(dp) :: yield = 0.0_dp               !! energy that bolts took, force length per unit thickness
    real(dp) :: friction = 0.0_dp, damping = 0.0_dp !! energy that they took, force length per unit thickness
    real(dp), allocatable :: before(:, :)    !! (3, n_bodies) velocities and spin before the small step
    type(small_outcome_t) :: outcome
  end type march_t

contains

  !> Takes `state` to the end of a step of the run.
  !>
  !> Errors: an outline that crosses itself.
  subroutine advance_by_small_steps(model, dt, cache, state, outcome, error)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: dt                    !! time
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(inout) :: state
    type(small_outcome_t), intent(out) :: outcome
    type(error_t), allocatable, intent(out) :: error
    type(march_t) :: march
    logical :: sleeps
    integer :: i

    sleeps = .false.
    if (allocated(state%sleep)) sleeps = any(state%sleep%island > 0)
    call begin_phase(cache%timers, phase_search)
    call begin_march(model, dt, cache, state, march, error)
    if (allocated(error)) return
    associate (bodies => cache%bodies)
      do i = 1, march%outcome%steps
        march%kick = 0.5_dp*(march%h + merge(state%pace%small, march%h, i == 1))
        call make_small_step(model, cache, state, i, bodies, march)
        march%time = state%time + i*march%h
        if (sleeps) call find_sleepers(state, march%rows, march%outcome%reached)
        if (allocated(march%outcome%reached)) exit
        if (.not. allocated(model%effects%contact) .or. i == march%outcome%steps) cycle
        if (is_worn(bodies%near)) call search_again(march%h, bodies)
      end do
      outcome = march%outcome
      if (allocated(outcome%reached)) return
      call begin_phase(cache%timers, phase_update)
      call put_bodies_back(model, cache, bodies, state)
      if (allocated(model%effects%contact)) &
        call give_contacts(bodies, model%effects%contact, model%outlines, state%vertex, march%h, state%contacts)
    end associate
    call end_march(model, dt, cache, march, state)
  end subroutine advance_by_small_steps

  !> Takes the bodies from the state, finds who is near whom and what they remember, and chooses the size of the small steps.
  subroutine begin_march(model, dt, cache, state, march, error)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: dt                    !! time
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(march_t), intent(inout) :: march
    type(error_t), allocatable, intent(out) :: error
    logical :: moved(model%n_blocks)              ! whether the bodies did when the list of near ones was made

    if (.not. allocated(cache%bodies)) then
      call refuse_grout(model, error)
      if (allocated(error)) return
      allocate (cache%bodies)
      call cut_bodies(model, state%vertex, cache%bodies, error)
      if (allocated(error)) return
    end if
    associate (bodies => cache%bodies)
      moved = bodies%moves
      call take_bodies(model, cache, state, bodies)
      march%outcome%steps = number_of_steps(model, bodies, dt)
      march%h = dt/march%outcome%steps
      if (count(bodies%moves) >= worth_threads) march%threads = model%settings%threads
      march%time = state%time
      allocate (march%before(3, bodies%n), source=0.0_dp)
      allocate (march%ties(count_ties(model, bodies)))
      march%point = state%point
      if (allocated(state%bolts)) march%bolts = state%bolts
      if (allocated(state%tied)) then
        if (size(state%tied) == size(march%ties)) march%ties%impulse = march%h*state%tied
      end if
      if (.not. allocated(model%effects%contact)) return
      if (any(bodies%moves .neqv. moved) .or. is_worn(bodies%near)) call search_again(march%h, bodies)
      bodies%near%apart_until = 0.0_dp
      call take_contacts(state%contacts%contact, march%h, bodies)
      if (state%stage%number == 1 .and. state%step == 0) call bond_faces(model%effects%contact, model%outlines, bodies)
    end associate
  end subroutine begin_march

  !> Error where the scene has grouted bolts that cross joints.
  subroutine refuse_grout(model, error)
    type(model_t), intent(in) :: model
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    if (.not. allocated(model%effects%bolt)) return
    do i = 1, size(model%effects%bolt%stiffness, 2)
      if (.not. is_grouted(model%effects%bolt, i)) cycle
      call fail(error, status_bad_input, 'expected integrator.scheme=''small_steps'' only without bolts.shear_stiffness, found '// &
                'bolt '//number_text(i)//' that is grouted')
      return
    end do
  end subroutine refuse_grout

  !> Finds anew who is near whom.
  subroutine search_again(h, bodies)
    real(dp), intent(in) :: h                     !! time
    type(bodies_t), intent(inout) :: bodies

    call place_corners(bodies, all_of_them=.false.)
    call grow_skin(bodies, fastest_vertex(bodies)*h)
    call find_near(bodies)
    bodies%near%moved = 0.0_dp
  end subroutine search_again

  !> One small step.
  subroutine make_small_step(model, cache, state, i, bodies, march)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state            !! when the step of the run began
    integer, intent(in) :: i                      !! small step of that
    type(bodies_t), intent(inout) :: bodies
    type(march_t), intent(inout) :: march
    real(dp) :: least_speed                       ! of what bounces, length/time
    integer :: k, sweeps
    logical :: bounces, touches

    sweeps = merge(first_sweeps, 1, march%time < (first_steps - 0.5_dp)*march%h)
    touches = allocated(model%effects%contact)
    bounces = .false.
    if (touches) bounces = any(model%effects%contact%joint%restitution > 0)
    least_speed = 0.0_dp
    if (bounces) least_speed = slow*march%h*largest_weight(model, bodies)
    !$omp parallel num_threads(march%threads) if(march%threads > 1) private(k)
    if (i > 1) call place_corners(bodies, all_of_them=.false.)
    if (touches) then
      call look_for_contacts(bodies)
      call make_rows(bodies, model%effects%contact, model%outlines, march%h, march%rows)
    end if
    !$omp single
    if (bounces) bounces = march%rows%any_bounces(least_speed)
    if (bounces) sweeps = max(sweeps, first_sweeps) ! else a block that strikes flat turns until it bounces
    call find_ties(model, bodies, march%point, march%bolts, march%time, march%h, march%ties)
    call kick(model, cache, state, bodies, march)
    call start_ties_warm(march%ties, bodies)
    !$omp end single
    call start_warm(march%rows, bodies)
    do k = 1, sweeps
      !$omp single
      call sweep_ties(.true., march%h, march%ties, bodies)
      !$omp end single
      call sweep(.true., march%h, march%rows, bodies)
    end do
    call drift(march%h, bodies)
    call advance_rows(march%h, bodies, march%rows)
    !$omp single
    bodies%near%moved = bodies%near%moved + march%h*fastest_vertex(bodies)
    call turn_arms(march%h, bodies, march%ties)
    call sweep_ties(.false., march%h, march%ties, bodies)
    !$omp end single
    call sweep(.false., march%h, march%rows, bodies)
    !$omp single
    if (bounces) call bounce(least_speed, march%rows, bodies)
    !$omp end single
    if (touches) call keep_impulses(march%rows, bodies)
    !$omp end parallel
    march%outcome%sweeps = march%outcome%sweeps + sweeps + 1
    if (size(march%ties) > 0) call move_points(model, cache, state, bodies, march%point)
    if (allocated(march%bolts)) call accept_bolts(model%effects%bolt, march%point, march%bolts, march%yield)
    call book(bodies, march)
  end subroutine make_small_step

  !> Changes velocities by the loads, and damps them.
  subroutine kick(model, cache, state, bodies, march)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(bodies_t), intent(inout) :: bodies
    type(march_t), intent(inout) :: march
    real(dp) :: left
    integer :: b

    call find_loads(model, cache, state, bodies, max(0.0_dp, march%time - march%kick + 0.5_dp*march%h), &
                    march%time + 0.5_dp*march%h, march%loads)
    left = 1.0_dp
    if (allocated(model%effects%mass_damping)) left = exp(-model%effects%mass_damping%rate*march%kick)
    do b = 1, bodies%n
      if (.not. bodies%moves(b)) cycle
      march%before(1:2, b) = bodies%velocity(:, b)
      march%before(3, b) = bodies%spin(b)
      associate (push => march%kick*bodies%inverse_mass(b))
        bodies%velocity(1, b) = bodies%velocity(1, b) + push*(march%loads%weight(1, b) + march%loads%load(1, b))
        bodies%velocity(2, b) = bodies%velocity(2, b) + push*(march%loads%weight(2, b) + march%loads%load(2, b))
      end associate
      bodies%spin(b) = bodies%spin(b) + march%kick*bodies%inverse_inertia(b)*march%loads%load(3, b)
      if (.not. left < 1) cycle
      march%damping = march%damping + 0.5_dp*(1 - left**2)*(sum(bodies%velocity(:, b)**2)/bodies%inverse_mass(b) &
                                                            + bodies%spin(b)**2/bodies%inverse_inertia(b))
      bodies%velocity(:, b) = left*bodies%velocity(:, b)
      bodies%spin(b) = left*bodies%spin(b)
    end do
  end subroutine kick

  !> Moves the bodies.
  subroutine drift(h, bodies)
    real(dp), intent(in) :: h                     !! time
    type(bodies_t), intent(inout) :: bodies
    integer :: b

    !$omp do schedule(static)
    do b = 1, bodies%n
      if (.not. bodies%moves(b)) cycle
      bodies%place(:, b) = bodies%place(:, b) + h*bodies%velocity(:, b)
      bodies%angle(b) = bodies%angle(b) + h*bodies%spin(b)
    end do
    !$omp end do
  end subroutine drift

  !> Adds the work of the loads in a small step, and what sliding took.
  subroutine book(bodies, march)
    type(bodies_t), intent(in) :: bodies
    type(march_t), intent(inout) :: march
    integer :: b, i, k

    do b = 1, bodies%n
      if (bodies%moves(b)) march%outcome%work = march%outcome%work + 0.5_dp*march%kick* &
        (dot_product(march%loads%load(1:2, b), march%before(1:2, b) + bodies%velocity(:, b)) &
         + march%loads%load(3, b)*(march%before(3, b) + bodies%spin(b)))
    end do
    march%outcome%work = march%outcome%work + work_of_ties(march%ties)
    do i = 1, march%rows%n
      do k = 1, march%rows%row(i)%n
        associate (point => march%rows%row(i)%point(k))
          march%friction = march%friction + abs(point%rub)*point%slid/march%h
        end associate
      end do
    end do
  end subroutine book

  !> Blocks asleep that others touch.
  subroutine find_sleepers(state, rows, reached)
    type(state_t), intent(in) :: state
    type(rows_t), intent(in) :: rows
    integer, allocatable, intent(out) :: reached(:)
    integer :: blocks(2), i, side

    do i = 1, rows%n
      blocks = [rows%row(i)%a, rows%row(i)%b]
      do side = 1, 2
        if (state%sleep%island(blocks(side)) == 0) cycle
        if (.not. allocated(reached)) allocate (reached(0))
        reached = [reached, blocks(side)]
      end do
    end do
  end subroutine find_sleepers

  !> Ends a step of the run: acceleration and stress of the last small step, time, books.
  subroutine end_march(model, dt, cache, march, state)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: dt                    !! time
    type(cache_t), intent(inout) :: cache
    type(march_t), intent(in) :: march
    type(state_t), intent(inout) :: state
    integer :: b, e, k

    associate (bodies => cache%bodies)
      do k = 1, size(model%elements%free)
        e = model%elements%free(k)
        b = model%elements%block(e)
        state%acceleration(model%elements%unknown(:, e)) = &
          [([bodies%velocity(:, b), bodies%spin(b)] - march%before(:, b))/march%h, 0.0_dp, 0.0_dp, 0.0_dp]
        state%stress(:, e) = 0.0_dp
      end do
      call add_stresses(model, cache, march, state%stress)
    end associate
    state%time = state%time + dt
    state%step = state%step + 1
    state%pace%last = dt
    state%pace%small = march%h
    if (size(march%ties) > 0) state%tied = march%ties%impulse/march%h
    if (allocated(state%bolts)) state%bolts = march%bolts
    state%books%yield = state%books%yield + march%yield
    state%books%work = state%books%work + march%outcome%work
    state%books%damping = state%books%damping + march%damping
    state%books%friction = state%books%friction + march%friction
    state%books%contact_springs = 0.0_dp
    call refresh_elements(model, state, cache)
    call close_books(model, cache, state)
  end subroutine end_march

  !> Adds the mean stress of the blocks that forces at contacts make: of a body in balance it is their moment over the area,
  !> the sum of f_i x_j.
  subroutine add_stresses(model, cache, march, stress)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(march_t), intent(in) :: march
    real(dp), intent(inout) :: stress(:, :)       !! (3, n_elements) force/length^2
    real(dp) :: of_body(3, cache%bodies%n)
    integer :: e, i, k

    of_body = 0.0_dp
    do i = 1, march%rows%n
      associate (row => march%rows%row(i))
        do k = 1, row%n
          associate (point => row%point(k))
            of_body(:, row%a) = of_body(:, row%a) - moment(point, point%arm_a)
            of_body(:, row%b) = of_body(:, row%b) + moment(point, point%arm_b)
          end associate
        end do
      end associate
    end do
    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      stress(:, e) = stress(:, e) + of_body(:, model%elements%block(e))/cache%element(e)%kinematics%area
    end do

  contains

    !> Symmetric part of the force at a point times an arm: xx, yy, xy.
    pure function moment(point, arm)
      type(row_point_t), intent(in) :: point
      real(dp), intent(in) :: arm(2)               !! (across, along)
      real(dp) :: moment(3), force(2), x(2)

      associate (n => point%normal)
        force = (point%push*n + point%rub*[-n(2), n(1)])/march%h
        x = arm(1)*n + arm(2)*[-n(2), n(1)]
      end associate
      moment = [force(1)*x(1), force(2)*x(2), 0.5_dp*(force(1)*x(2) + force(2)*x(1))]
    end function moment

  end subroutine add_stresses

end module scree_small_steps
