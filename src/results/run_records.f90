!> Records of a run beside its frames: /history and /measured_points by step, /bodies by frame.
module scree_run_records
  use scree_bolt, only: ends_of, forces_of, lengths_of
  use scree_contact_geometry, only: frame_of_edge
  use scree_contact_rules, only: has_bonds
  use scree_contacts, only: contact_t, state_open
  use scree_crack_records, only: declare_growth, declare_tips, growth_records_t, put_tips, tip_records_t
  use scree_departure_records, only: declare_departures, departure_records_t
  use scree_deviation, only: error_of_blocks, share_off
  use scree_effects, only: supports_move
  use scree_energy, only: dissipated_energy
  use scree_equilibrium, only: balance_t
  use scree_errors, only: error_t
  use scree_integrator, only: held_weight, holds_power
  use scree_joint_rules, only: joints_soften
  use scree_interpolation, only: displacement_matrix
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_results_file, only: declare_series, put_series, results_t
  use scree_regions, only: first_vertex_of, last_vertex_of
  use scree_state, only: state_t, step_of_run, time_of_run
  use scree_system, only: measured_point
  use scree_time_stepper, only: step_report_t
  implicit none
  private
  public :: declare_records, displacement_of_vertices, kinds_t, note_kinds, put_frame_records, put_step_records, records_t, &
            velocity_of_vertices

  !> Handles of the series; 0 where an effect is absent.
  type :: records_t
    integer :: time = 0, step_size = 0, area = 0, rotation = 0, momentum = 0
    integer :: stage = 0, staged = 0, body_present = 0
    integer :: kinetic = 0, strain = 0, gravity = 0, fixed_springs = 0, work = 0, damping = 0, held = 0, dissipated = 0
    integer :: iterations = 0, solves = 0, rejected = 0, green = 0, sleeping = 0, slept = 0, body_asleep = 0
    integer :: support_force = 0, bonds = 0
    integer :: error = 0, error_growth = 0, error_share = 0, error_step = 0, error_impact = 0, rough = 0, refused = 0
    integer :: body_error = 0
    integer :: unbalanced = 0, unbalanced_block = 0
    integer :: bolts = 0, yield = 0, bolt_ends = 0, bolt_force = 0, bolt_elongation = 0, bolt_state = 0
    integer :: bolt_shear = 0, bolt_slip = 0, bolt_number = 0
    integer :: contacts = 0, open_close = 0, judged = 0, judged_step = 0, overlap = 0, spring = 0, friction = 0
    integer :: touch_count = 0, touch_blocks = 0, touch_state = 0, touch_place = 0, touch_normal = 0, touch_force = 0
    integer :: touch_damage = 0, fracture = 0
    integer :: body_green = 0, body_area = 0, body_centroid = 0, body_rotation = 0, body_velocity = 0, body_stress = 0
    integer :: point_position = 0, point_displacement = 0, point_velocity = 0, point_stress = 0
    integer, allocatable :: measured(:)               !! points of the system
    type(tip_records_t) :: tips
    type(growth_records_t) :: growth
    type(departure_records_t) :: departures
  end type records_t

  !> Whether any stage of a run has an effect, so that its series exist in all stages.
  type :: kinds_t
    integer :: stages = 0
    integer :: parts = 0                              !! blocks that may break off
    logical :: gravity = .false., fixed_springs = .false., held = .false., damping = .false., error = .false., static = .false., &
               sleep = .false., removal = .false., departures = .false., softening = .false., growth = .false., &
               bonds = .false., moving = .false.
  end type kinds_t

  character(len=*), parameter :: energy_unit = 'force*length/length'

contains

  !> Notes what the model of a stage has.
  pure subroutine note_kinds(model, kinds)
    type(model_t), intent(in) :: model
    type(kinds_t), intent(inout) :: kinds

    associate (effects => model%effects, s => model%settings)
      kinds%stages = kinds%stages + 1
      kinds%parts = max(kinds%parts, s%crack_parts)
      kinds%gravity = kinds%gravity .or. allocated(effects%gravity)
      if (allocated(effects%fixed_point)) kinds%fixed_springs = kinds%fixed_springs .or. effects%fixed_point%by_springs
      kinds%moving = kinds%moving .or. (supports_move(model) .and. .not. s%takes_small_steps())
      kinds%held = kinds%held .or. abs(held_weight(s)) > 0 .or. holds_power(s)
      kinds%damping = kinds%damping .or. allocated(effects%mass_damping) .or. allocated(effects%stiffness_damping) &
                      .or. allocated(effects%absorbing_edge)
      kinds%error = kinds%error .or. s%estimates_error
      kinds%static = kinds%static .or. effects%is_static()
      kinds%sleep = kinds%sleep .or. allocated(effects%sleep)
      if (allocated(effects%contact)) then
        kinds%softening = kinds%softening .or. joints_soften(effects%contact)
        kinds%bonds = kinds%bonds .or. any(has_bonds(effects%contact))
      end if
      kinds%growth = kinds%growth .or. s%cracks_may_grow()
      kinds%departures = kinds%departures .or. allocated(s%scene_rectangle)
      kinds%removal = kinds%removal .or. kinds%departures .or. .not. all(model%present)
    end associate
  end subroutine note_kinds

  !> Declares the series that the scene calls for.
  subroutine declare_records(results, model, kinds, records, error)
    type(results_t), intent(inout) :: results
    type(model_t), intent(in) :: model
    type(kinds_t), intent(in) :: kinds           !! of all stages
    type(records_t), intent(out) :: records
    type(error_t), allocatable, intent(out) :: error
    integer :: n, i

    n = model%n_blocks + kinds%parts
    records%measured = pack([(i, i=1, size(model%points%kind))], model%points%kind == measured_point)
    call declare_history(results, model, kinds, n, records, error)
    call declare_parts(results, model, kinds, n, records, error)
  end subroutine declare_records

  !> Declares the series of the whole scene, with a row each step.
  subroutine declare_history(results, model, kinds, n, records, error)
    type(results_t), intent(inout) :: results
    type(model_t), intent(in) :: model
    type(kinds_t), intent(in) :: kinds           !! of all stages
    integer, intent(in) :: n                     !! blocks, with those that may break off
    type(records_t), intent(inout) :: records
    type(error_t), allocatable, intent(inout) :: error

    call declare_motion()
    call declare_energies()
    call declare_costs()
    if (kinds%error) call declare_errors()
    call declare_rest()
    if (model%settings%measures_tips) call declare_tips(results, records%tips, error)
    if (allocated(model%effects%contact)) call declare_open_close()

  contains

    !> Declares time and size of a step, and how all moves.
    subroutine declare_motion()
      call a_step('time', [integer ::], 'time', 'end of the step', records%time)
      call a_step('step_size', [integer ::], 'time', 'size of the step', records%step_size)
      call a_step('area', [integer ::], 'length^2', 'area of all blocks that are present', records%area)
      call a_step('rotation', [n], 'rad', 'rotation of each block since the start', records%rotation)
      call a_step('momentum', [3], 'mass*length/time (x, y), mass*length^2/time (about the origin), per unit thickness', &
                  'momentum and angular momentum of all blocks', records%momentum)
    end subroutine declare_motion

    !> Declares the energy that there is, and where it went.
    subroutine declare_energies()
      call a_step('energy/kinetic', [integer ::], energy_unit, 'kinetic energy', records%kinetic)
      call a_step('energy/strain', [integer ::], energy_unit, 'energy of the stress', records%strain)
      if (kinds%gravity) &
        call a_step('energy/gravity', [integer ::], energy_unit, 'weight times height above y = 0', records%gravity)
      if (kinds%fixed_springs) &
        call a_step('energy/fixed_springs', [integer ::], energy_unit, 'energy of the springs of fixed points', &
                    records%fixed_springs)
      call a_step('energy/work', [integer ::], energy_unit, &
                  'work of loads, the moving ground and moving supports since the start', records%work)
      if (kinds%moving) call a_step('support_force', [integer ::], 'force/length', &
                                    'work of moving supports in the step over the way of the fastest', &
                                    records%support_force)
      if (kinds%stages > 1) &
        call a_step('stage', [integer ::], '1', 'stage that the step is of, from 1', records%stage, .true.)
      if (kinds%stages > 1 .or. kinds%departures) &
        call a_step('energy/stages', [integer ::], energy_unit, &
                    'energy that changes of stages and blocks that left added; below 0: removed', records%staged)
      if (kinds%held) &
        call a_step('energy/held', [integer ::], energy_unit, 'energy that the integrator holds between steps', records%held)
      if (kinds%damping) &
        call a_step('energy/damping', [integer ::], energy_unit, &
                    'energy lost to damping of mass and stiffness and to absorbing edges since the start', records%damping)
      call a_step('energy/dissipated', [integer ::], energy_unit, &
                  'energy at the start and work since, less the energy now', records%dissipated)
    end subroutine declare_energies

    !> Declares what a step took.
    subroutine declare_costs()
      call a_step('deformation_iterations', [integer ::], '1', 'iterations of the step', records%iterations, .true.)
      call a_step('solves', [integer ::], '1', 'systems of equations solved in the step', records%solves, .true.)
      call a_step('rejected', [integer ::], '1', 'how often the step was tried again with a smaller size', records%rejected, .true.)
      if (allocated(model%effects%accuracy)) &
        call a_step('green_elements', [integer ::], '1', 'elements with Green strain in the step', records%green, .true.)
    end subroutine declare_costs

    !> Declares how far the run is estimated to be off, of a step.
    subroutine declare_errors()
      call a_step('error/displacement', [integer ::], 'length', 'largest estimated error of the place of a block', records%error)
      call a_step('error/growth', [integer ::], '1', 'largest area that small strain has added to a block, over its area', &
                  records%error_growth)
      call a_step('error/share', [integer ::], '1', 'the larger of the growth and the error of the place over the displacement', &
                  records%error_share)
      call a_step('error/step', [integer ::], 'length', 'largest error that the step adds to a place at the end', &
                  records%error_step)
      call a_step('error/impacts', [integer ::], 'length', 'largest error of a place by the unknown instants of impacts', &
                  records%error_impact)
      call a_step('error/rough', [integer ::], '1', 'blocks whose contacts opened or closed in the step', records%rough, .true.)
      call a_step('error/refused', [integer ::], '1', 'steps made again because their error was too large', records%refused, .true.)
    end subroutine declare_errors

    !> Declares how near a static run is to equilibrium, and what sleeps.
    subroutine declare_rest()
      if (kinds%static) then
        call a_step('unbalanced', [integer ::], '1', 'largest force out of balance of a block over the forces on it', &
                    records%unbalanced)
        call a_step('unbalanced_block', [integer ::], '1', 'that block, from 1', records%unbalanced_block, .true.)
      end if
      if (kinds%sleep) then
        call a_step('asleep', [integer ::], '1', 'bodies that sleep', records%sleeping, .true.)
        call a_step('energy/asleep', [integer ::], energy_unit, 'energy of bodies when they fell asleep', records%slept)
      end if
    end subroutine declare_rest

    !> Declares how many contacts a step has, how they settled, and their energy.
    subroutine declare_open_close()
      call a_step('contacts', [3], '1', 'contacts open, sliding, locked', records%contacts, .true.)
      call a_step('open_close_iterations', [integer ::], '1', 'state updates of contacts of an island', records%open_close, .true.)
      if (kinds%bonds) call a_step('bonds', [3], '1', 'bonds that hold, and that broke in tension and in shear since the start', &
                                   records%bonds, .true.)
      call declare_series(results, '/open_close/step', [integer ::], '1', 'step of each state update, from 1', &
                          records%judged_step, error, .true.)
      call declare_series(results, '/open_close/contacts', [4], '1', 'contacts open, sliding, locked, and changing', &
                          records%judged, error, .true.)
      call a_step('overlap', [integer ::], 'length', 'deepest overlap of a contact', records%overlap)
      call a_step('energy/contact', [integer ::], energy_unit, 'energy of the springs of contacts', records%spring)
      call a_step('energy/friction', [integer ::], energy_unit, 'work lost in sliding since the start', records%friction)
      if (kinds%softening .or. kinds%growth) &
        call a_step('energy/fracture', [integer ::], energy_unit, 'energy lost in bonds and new faces', records%fracture)
    end subroutine declare_open_close

    !> Declares a series with a row each step.
    subroutine a_step(name, shape, units, description, handle, whole)
      character(len=*), intent(in) :: name, units, description
      integer, intent(in) :: shape(:)
      integer, intent(out) :: handle
      logical, intent(in), optional :: whole

      call declare_series(results, '/history/'//name, shape, units, description, handle, error, whole)
    end subroutine a_step

  end subroutine declare_history

  !> Declares the series of blocks, contacts, bolts and measured points.
  subroutine declare_parts(results, model, kinds, n, records, error)
    type(results_t), intent(inout) :: results
    type(model_t), intent(in) :: model
    type(kinds_t), intent(in) :: kinds           !! of all stages
    integer, intent(in) :: n                     !! blocks, with those that may break off
    type(records_t), intent(inout) :: records
    type(error_t), allocatable, intent(inout) :: error

    call declare_bodies()
    if (allocated(model%effects%contact)) call declare_contacts()
    if (allocated(model%effects%bolt)) call declare_bolts(size(model%effects%bolt%stiffness, 2))
    if (size(records%measured) > 0) call declare_points(size(records%measured))
    if (kinds%departures) call declare_departures(results, records%departures, error)
    if (kinds%growth) call declare_growth(results, records%growth, error)

  contains

    !> Declares what a frame has of each block.
    subroutine declare_bodies()
      call a_frame('area', [n], 'length^2', 'area', records%body_area)
      call a_frame('centroid', [2, n], 'length', 'centroid', records%body_centroid)
      call a_frame('rotation', [n], 'rad', 'rotation since the start', records%body_rotation)
      call a_frame('velocity', [2, n], 'length/time', 'velocity of the centroid', records%body_velocity)
      call a_frame('stress', [3, n], 'force/length^2', 'mean Cauchy stress xx, yy, xy', records%body_stress)
      if (allocated(model%effects%accuracy)) &
        call a_frame('green_share', [n], '1', 'fraction of its area with Green strain in the last step', records%body_green)
      if (kinds%error) &
        call a_frame('error', [n], 'length', 'estimated error of the place, root mean square over the block', records%body_error)
      if (kinds%sleep) call a_frame('asleep', [n], '1', 'first body of the island that it sleeps with, from 1; 0: it is awake', &
                               records%body_asleep)
      if (kinds%removal .or. kinds%parts > 0) &
        call a_frame('present', [n], '1', '1, or 0 where it has not broken off yet or a stage has removed it', records%body_present)
    end subroutine declare_bodies

    !> Declares the closed contacts of a frame, a row each.
    subroutine declare_contacts()
      call a_series('/contacts/count', [integer ::], '1', 'closed contacts of each frame', records%touch_count, .true.)
      call a_series('/contacts/blocks', [2], '1', 'blocks of the vertex and of the edge, from 1', records%touch_blocks, .true.)
      call a_series('/contacts/state', [integer ::], '1', '1 sliding, 2 locked', records%touch_state, .true.)
      call a_series('/contacts/place', [2], 'length', 'place of the vertex', records%touch_place, .false.)
      call a_series('/contacts/normal', [2], '1', 'outer normal of the edge', records%touch_normal, .false.)
      call a_series('/contacts/force', [2], 'force', 'on the block of the vertex, along the normal and the normal turned left', &
                    records%touch_force, .false.)
      if (kinds%softening) call a_series('/contacts/damage', [integer ::], '1', 'of a bond, or -1', records%touch_damage, .false.)
    end subroutine declare_contacts

    !> Declares the energy of bolts of a step, and the bolts of a frame.
    subroutine declare_bolts(m)
      integer, intent(in) :: m                   !! of them

      call a_series('/history/energy/bolts', [integer ::], energy_unit, 'energy of the bolts', records%bolts)
      call a_series('/history/energy/yield', [integer ::], energy_unit, &
                    'energy lost in bolts that yielded or broke since the start', records%yield)
      call a_series('/bolts/ends', [4, m], 'length', 'x1 y1 x2 y2 of the ends', records%bolt_ends, per_frame=.true.)
      call a_series('/bolts/force', [m], 'force', 'tension; below 0 it pushes', records%bolt_force, per_frame=.true.)
      call a_series('/bolts/elongation', [m], 'length', 'growth of its length since the start', records%bolt_elongation, &
                    per_frame=.true.)
      call a_series('/bolts/state', [m], '1', '0 elastic, 1 has yielded, 2 broken, 3 not in this stage', records%bolt_state, &
                    .true., per_frame=.true.)
      if (any(model%effects%bolt%stiffness(2, :) > 0)) then
        call a_series('/bolts/shear', [m], 'force', 'force across a grouted bolt where it crosses a joint', records%bolt_shear, &
                      per_frame=.true.)
        call a_series('/bolts/slip', [m], 'length', 'slip across it there since the start', records%bolt_slip, per_frame=.true.)
        call a_series('/bolts/number', [m], '1', 'bolt of the decks, from 1', records%bolt_number, .true., per_frame=.true.)
      end if
    end subroutine declare_bolts

    !> Declares what a step has of the measured points.
    subroutine declare_points(m)
      integer, intent(in) :: m                   !! of them

      call a_series('/measured_points/position', [2, m], 'length', 'place', records%point_position)
      call a_series('/measured_points/displacement', [2, m], 'length', 'displacement since the start', records%point_displacement)
      call a_series('/measured_points/velocity', [2, m], 'length/time', 'velocity', records%point_velocity)
      call a_series('/measured_points/stress', [3, m], 'force/length^2', 'Cauchy stress xx, yy, xy', records%point_stress)
    end subroutine declare_points

    !> Declares a series of any kind of row.
    subroutine a_series(path, shape, units, description, handle, whole, per_frame)
      character(len=*), intent(in) :: path, units, description
      integer, intent(in) :: shape(:)
      integer, intent(out) :: handle
      logical, intent(in), optional :: whole, per_frame

      call declare_series(results, path, shape, units, description, handle, error, whole, per_frame)
    end subroutine a_series

    !> Declares a series of the blocks with a row each frame.
    subroutine a_frame(name, shape, units, description, handle)
      character(len=*), intent(in) :: name, units, description
      integer, intent(in) :: shape(:)
      integer, intent(out) :: handle

      call declare_series(results, '/bodies/'//name, shape, units, description, handle, error, per_frame=.true.)
    end subroutine a_frame

  end subroutine declare_parts

  !> Displacement of all vertices of the elements, since the start or since a stage that counts it anew, length.
  pure function displacement_of_vertices(model, state) result(displacement)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(dp) :: displacement(2, size(state%vertex, 2))

    if (allocated(state%reference)) then
      displacement = state%vertex - state%reference%vertex
    else
      displacement = state%vertex - model%start
    end if
  end function displacement_of_vertices

  !> Likewise of a point.
  pure function displacement_of_point(model, state, i) result(displacement)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: i
    real(dp) :: displacement(2)

    if (allocated(state%reference)) then
      displacement = state%point(:, i) - state%reference%point(:, i)
    else
      displacement = state%point(:, i) - model%start_point(:, i)
    end if
  end function displacement_of_point

  !> Velocity of all vertices of the elements, length/time.
  pure function velocity_of_vertices(model, cache, state) result(velocity)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    real(dp) :: velocity(2, size(state%vertex, 2))
    integer :: e, k

    do e = 1, model%n_elements
      do k = first_vertex_of(model%elements%shape, e), last_vertex_of(model%elements%shape, e)
        velocity(:, k) = matmul(displacement_matrix(cache%element(e)%kinematics, state%vertex(:, k)), &
                                state%velocity(model%elements%unknown(:, e)))
      end do
    end do
  end function velocity_of_vertices

  !> The row of a series, filled up with zeros for blocks that may break off and have not yet.
  pure function filled(results, handle, values) result(row)
    type(results_t), intent(in) :: results
    integer, intent(in) :: handle
    real(dp), intent(in) :: values(:)
    real(dp) :: row(max(size(values), results%series(handle)%width))

    row = 0.0_dp
    row(:size(values)) = values
  end function filled

  !> A row of each series of the steps.
  subroutine put_step_records(results, records, model, cache, state, report, error)
    type(results_t), intent(inout) :: results
    type(records_t), intent(inout) :: records
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(step_report_t), intent(in) :: report
    type(error_t), allocatable, intent(out) :: error
    integer :: asleep(3), e, i             ! contacts of what sleeps
    type(balance_t) :: balance             ! nothing in a dynamic stage
    real(dp) :: overlap

    call put(records%time, [time_of_run(state)])
    call put(records%stage, [real(state%stage%number, dp)])
    call put(records%staged, [state%books%staged])
    call put(records%step_size, [report%dt])
    call put(records%area, [sum(cache%element%kinematics%area, model%present(model%elements%block))])
    call put(records%rotation, filled(results, records%rotation, state%rotation))
    call put(records%momentum, state%books%momentum)
    call put(records%kinetic, [state%books%kinetic])
    call put(records%strain, [state%books%strain])
    call put(records%gravity, [state%books%gravity])
    call put(records%fixed_springs, [state%books%fixed_springs])
    call put(records%work, [state%books%work])
    call put(records%held, [state%books%integrator])
    call put(records%support_force, [state%pace%support_force])
    call put(records%bonds, real([bonds_that_hold(state), state%contacts%broken], dp))
    call put(records%damping, [state%books%damping])
    call put(records%dissipated, [dissipated_energy(state%books)])
    call put(records%iterations, [real(report%iterations, dp)])
    call put(records%solves, [real(report%solves, dp)])
    call put(records%rejected, [real(report%rejected, dp)])
    call put(records%green, [real(count(state%green), dp)])
    call put_errors()
    if (model%settings%measures_tips) call put_tips(results, records%tips, model, cache, state, error)
    if (records%unbalanced > 0) then
      if (allocated(report%balance)) balance = report%balance
      call put(records%unbalanced, [balance%share])
      call put(records%unbalanced_block, [real(balance%block, dp)])
    end if
    asleep = 0
    overlap = state%contacts%penetration
    if (allocated(state%sleep)) then
      call put(records%sleeping, [real(count(state%sleep%island > 0), dp)])
      asleep = state%sleep%count
      overlap = max(overlap, state%sleep%penetration)
    else
      call put(records%sleeping, [0.0_dp])
    end if
    call put(records%slept, [state%books%asleep])
    call put(records%contacts, real(state%contacts%count + asleep, dp))
    call put(records%open_close, [real(size(report%judged, 2), dp)])
    do i = 1, size(report%judged, 2)
      call put(records%judged_step, [real(step_of_run(state), dp)])
      call put(records%judged, real(report%judged(:, i), dp))
    end do
    call put(records%overlap, [overlap])
    call put(records%spring, [state%books%contact_springs + state%books%sleeping_springs])
    call put(records%friction, [state%books%friction])
    if (records%fracture > 0) call put(records%fracture, [state%books%fracture])
    if (records%bolts > 0) call put(records%bolts, [state%books%bolts])
    if (records%yield > 0) call put(records%yield, [state%books%yield])
    do i = 1, size(records%measured)
      associate (point => state%point(:, records%measured(i)))
        e = model%points%element(records%measured(i))
        call put(records%point_position, point + model%origin)
        call put(records%point_displacement, displacement_of_point(model, state, records%measured(i)))
        call put(records%point_velocity, matmul(displacement_matrix(cache%element(e)%kinematics, point), &
                                                state%velocity(model%elements%unknown(:, e))))
        call put(records%point_stress, state%stress(:, e))
      end associate
    end do

  contains

    !> Adds a row to a series, if there is one.
    subroutine put(handle, values)
      integer, intent(in) :: handle
      real(dp), intent(in) :: values(:)

      if (handle > 0 .and. .not. allocated(error)) call put_series(results, handle, values, error)
    end subroutine put

    !> A row of how far the run is off; zeros in a stage that does not estimate it.
    subroutine put_errors()
      real(dp) :: numbers(6)

      if (records%error == 0) return
      numbers = 0.0_dp
      if (allocated(state%deviation)) then
        associate (own => state%deviation)
          numbers = [maxval(error_of_blocks(own)), maxval(abs(own%growth)), share_off(model, cache, own), &
                     own%step, maxval(own%impact), real(own%rough, dp)]
        end associate
      end if
      call put(records%error, numbers(1:1))
      call put(records%error_growth, numbers(2:2))
      call put(records%error_share, numbers(3:3))
      call put(records%error_step, numbers(4:4))
      call put(records%error_impact, numbers(5:5))
      call put(records%rough, numbers(6:6))
      call put(records%refused, [real(report%refused, dp)])
    end subroutine put_errors

  end subroutine put_step_records

  !> How many contacts have a bond, those of what sleeps too.
  pure integer function bonds_that_hold(state) result(n)
    type(state_t), intent(in) :: state

    n = 0
    if (allocated(state%contacts%contact)) n = count_bonded(state%contacts%contact)
    if (allocated(state%sleep)) n = n + count_bonded(state%sleep%contact)

  contains

    pure integer function count_bonded(contact)
      type(contact_t), intent(in) :: contact(:)

      count_bonded = count(contact%entrance(1)%memory%bonded .or. contact%entrance(2)%memory%bonded)
    end function count_bonded

  end function bonds_that_hold

  !> A row of each series of the frames.
  subroutine put_frame_records(results, records, model, cache, state, error)
    type(results_t), intent(inout) :: results
    type(records_t), intent(in) :: records
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: area(model%n_blocks), green(model%n_blocks), sums(7, model%n_blocks)
    integer :: b, e

    area = 0.0_dp
    green = 0.0_dp
    sums = 0.0_dp
    do e = 1, model%n_elements
      associate (element => cache%element(e)%kinematics)
        b = model%elements%block(e)
        area(b) = area(b) + element%area
        if (state%green(e)) green(b) = green(b) + element%area
        sums(:, b) = sums(:, b) + element%area*[element%centroid + model%origin, &
          matmul(element%at_centroid, state%velocity(model%elements%unknown(:, e))), state%stress(:, e)]
      end associate
    end do
    do b = 1, model%n_blocks
      sums(:, b) = sums(:, b)/area(b)
    end do
    call put(records%body_area, area)
    call put(records%body_centroid, reshape(sums(1:2, :), [size(sums(1:2, :))]))
    call put(records%body_rotation, state%rotation)
    call put(records%body_velocity, reshape(sums(3:4, :), [size(sums(3:4, :))]))
    call put(records%body_stress, reshape(sums(5:7, :), [size(sums(5:7, :))]))
    if (records%body_green > 0) call put(records%body_green, green/area)
    if (records%body_error > 0) call put_if(allocated(state%deviation), records%body_error)
    if (records%body_asleep > 0) call put_if(allocated(state%sleep), records%body_asleep)
    if (records%body_present > 0) call put(records%body_present, merge(1.0_dp, 0.0_dp, model%present))
    if (records%touch_count > 0) call put_contacts()
    if (records%bolt_force > 0) call put_bolts()

  contains

    !> Adds a row to a series.
    subroutine put(handle, values)
      integer, intent(in) :: handle
      real(dp), intent(in) :: values(:)

      if (.not. allocated(error)) call put_series(results, handle, filled(results, handle, values), error)
    end subroutine put

    !> A row of the errors of blocks, or of what sleeps; zeros in a stage that has none.
    subroutine put_if(there, handle)
      logical, intent(in) :: there
      integer, intent(in) :: handle
      real(dp) :: values(model%n_blocks)

      values = 0.0_dp
      if (there .and. handle == records%body_error) values = error_of_blocks(state%deviation)
      if (there .and. handle == records%body_asleep) values = real(state%sleep%island, dp)
      call put(handle, values)
    end subroutine put_if

    !> A row of the bolts.
    subroutine put_bolts()
      real(dp), dimension(2, size(state%bolts%state)) :: apart, force
      integer :: i

      associate (bolt => model%effects%bolt, n => size(state%bolts%state))
        do i = 1, n
          force(:, i) = forces_of(bolt, state%bolts, i, state%point)
          apart(:, i) = lengths_of(bolt, i, state%point) - lengths_of(bolt, i, model%start_point)
        end do
        call put(records%bolt_ends, [(ends_of(bolt, i, state%point) + spread(model%origin, 2, 2), i=1, n)])
        call put(records%bolt_force, force(1, :))
        call put(records%bolt_elongation, apart(1, :))
        call put(records%bolt_state, real(state%bolts%state, dp))
        if (records%bolt_shear > 0) then
          call put(records%bolt_shear, force(2, :))
          call put(records%bolt_slip, apart(2, :))
          call put(records%bolt_number, real(bolt%number, dp))
        end if
      end associate
    end subroutine put_bolts

    !> A row of each closed contact.
    subroutine put_contacts()
      integer :: i, n

      n = 0
      do i = 1, size(state%contacts%contact)
        call put_contact(state%contacts%contact(i), n)
      end do
      if (allocated(state%sleep)) then
        do i = 1, size(state%sleep%contact)
          call put_contact(state%sleep%contact(i), n)
        end do
      end if
      call put(records%touch_count, [real(n, dp)])
    end subroutine put_contacts

    !> The row of a contact, if it is closed.
    subroutine put_contact(contact, n)
      type(contact_t), intent(in) :: contact
      integer, intent(inout) :: n                !! rows
      real(dp) :: t(2), normal(2), length

      associate (outlines => model%outlines, entrance => contact%entrance(contact%active))
        if (entrance%state == state_open) return
        n = n + 1
        call frame_of_edge(state%vertex(:, outlines%start(entrance%edge)), state%vertex(:, outlines%finish(entrance%edge)), &
                           t, normal, length)
        call put(records%touch_blocks, real([outlines%block(entrance%vertex), outlines%block(entrance%edge)], dp))
        call put(records%touch_state, [real(entrance%state, dp)])
        call put(records%touch_place, state%vertex(:, outlines%start(entrance%vertex)) + model%origin)
        call put(records%touch_normal, normal)
        call put(records%touch_force, contact%force)
        if (records%touch_damage > 0) &
          call put(records%touch_damage, [merge(entrance%memory%damage, -1.0_dp, &
                                                entrance%memory%bonded .or. entrance%memory%damage >= 1)])
      end associate
    end subroutine put_contact

  end subroutine put_frame_records

end module scree_run_records
