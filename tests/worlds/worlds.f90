!> Worlds for unit tests, in a line. They are made as a run makes them: decks are written, read and set up.
module worlds
  use, intrinsic :: iso_fortran_env, only: error_unit
  use scree_accurate_step, only: advance_estimated
  use scree_block_input, only: blocks_t
  use scree_effects, only: refresh_elements
  use scree_errors, only: error_t
  use scree_islands, only: release_equations
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_random_numbers, only: next_uniform, random_t
  use scree_read_scene, only: read_scene
  use scree_scene, only: block_material_t, effect_t, joint_material_t, scene_t
  use scree_set_up, only: set_up
  use scree_shi_control, only: first_size, following_size
  use scree_sleep, only: advance_awake
  use scree_start, only: begin_run
  use scree_state, only: state_t
  use scree_step_control, only: after_step, next_size
  use scree_text, only: append, text_t
  use scree_step, only: advance
  use scree_time_stepper, only: step_report_t
  implicit none
  private
  public :: box, cracked_plate, default_rock, end_world, jointed_rock, model_of_polygons, read_world, take_step, world_t

  !> The material of blocks where a test names none: E 1e4, nu 0.2, density 2, no weight.
  type(block_material_t), parameter :: default_rock = block_material_t(density=2.0_dp, young=1e4_dp, poisson=0.2_dp)

  !> A run at its beginning: what `advance` takes, and what it was made of.
  type :: world_t
    type(scene_t) :: scene
    type(blocks_t) :: blocks
    type(model_t) :: model
    type(model_t), allocatable :: awake !! in which what sleeps cannot move
    type(state_t) :: state
    type(cache_t) :: cache
  end type world_t

contains

  !> Makes a world of polygons, ready for `advance`. A deck that is refused stops the test with its words, or is handed back.
  subroutine model_of_polygons(corner, counts, world, groups, rock, joint, dt, fixed, load, carried, error)
    real(dp), intent(in) :: corner(:)                          !! x, y of the corners, counter-clockwise, polygon after polygon
    integer, intent(in) :: counts(:)                           !! corners of each polygon
    type(world_t), intent(out) :: world
    character(len=*), intent(in), optional :: groups           !! named groups, as "&method strain='green' /"
    type(block_material_t), intent(in), optional :: rock(:)    !! of each polygon; those beyond the last have the last
    type(joint_material_t), intent(in), optional :: joint      !! of all edges; without friction where none is said
    real(dp), intent(in), optional :: dt                       !! step size, 0.01 where none is said
    real(dp), intent(in), optional :: fixed(:, :)              !! (2, n) fixed points
    real(dp), intent(in), optional :: load(:, :)               !! (2, n) load points; "&loads force=... /" gives their forces
    real(dp), intent(in), optional :: carried                  !! share of the velocity that a step hands on: 1, or 0 for statics
    type(error_t), allocatable, intent(out), optional :: error

    call write_blocks(stem()//'.blk', corner, counts, fixed, load, rock)
    call write_analysis(stem()//'.ana', groups, rock, joint, dt, carried)
    call read_world(stem()//'.blk', stem()//'.ana', world, error=error)
    call remove(stem()//'.blk')
    call remove(stem()//'.ana')
  end subroutine model_of_polygons

  !> Makes the world of two decks, ready for `advance`. Decks that are refused stop the test with their words, or are handed back.
  subroutine read_world(geometry, analysis, world, options, error)
    character(len=*), intent(in) :: geometry
    character(len=*), intent(in) :: analysis
    type(world_t), intent(out) :: world
    character(len=*), intent(in), optional :: options(:)       !! "group.name=value" that win over the deck
    type(error_t), allocatable, intent(out), optional :: error
    type(text_t), allocatable :: option(:)
    type(effect_t), allocatable :: list(:)
    type(error_t), allocatable :: refusal
    integer :: i

    allocate (option(0))
    if (present(options)) then
      do i = 1, size(options)
        if (len_trim(options(i)) > 0) call append(option, trim(options(i)))
      end do
    end if
    call read_scene(geometry, analysis, option, world%scene, world%blocks, refusal)
    if (.not. allocated(refusal)) call set_up(world%scene, world%blocks, world%model, world%state, list, refusal)
    if (.not. allocated(refusal)) then
      call refresh_elements(world%model, world%state, world%cache)
      call begin_run(world%model, world%cache, world%state, refusal)
      if (world%scene%settings%chooses_step) world%state%pace%size = first_size(world%scene, world%model, world%state)
    end if
    if (.not. allocated(refusal)) return
    if (present(error)) then
      call move_alloc(refusal, error)
    else
      write (error_unit, '(a)') refusal%message
      error stop 1
    end if
  end subroutine read_world

  !> Makes a plate, from -1 to 1 in x and y, that joints cut; no friction, no support.
  subroutine cracked_plate(ends, world, groups, rock, joint, carried, error)
    real(dp), intent(in) :: ends(:, :)                         !! (4, n) x1 y1 x2 y2 of each joint
    type(world_t), intent(out) :: world
    character(len=*), intent(in) :: groups                     !! named groups, with a mesh
    type(block_material_t), intent(in), optional :: rock
    type(joint_material_t), intent(in), optional :: joint
    real(dp), intent(in), optional :: carried                  !! share of the velocity that a step hands on: 1, or 0 for statics
    type(error_t), allocatable, intent(out), optional :: error
    type(block_material_t) :: own
    integer :: i, unit

    own = default_rock
    if (present(rock)) own = rock
    open (newunit=unit, file=stem()//'.geo', action='write', status='replace')
    write (unit, '(a)') '1e-6'
    write (unit, '(i0)') size(ends, 2) + 4, 4, 0, 0, 0, 0, 0, 0
    write (unit, '(a)') '-1 -1 1 -1 1', '1 -1 1 1 1', '1 1 -1 1 1', '-1 1 -1 -1 1'
    write (unit, '(4(1x,es24.16e3),a)') (ends(:, i), ' 1', i=1, size(ends, 2))
    close (unit)
    call write_analysis(stem()//'.ana', groups, [own], joint, carried=carried)
    call read_world(stem()//'.geo', stem()//'.ana', world, error=error)
    call remove(stem()//'.geo')
    call remove(stem()//'.ana')
  end subroutine cracked_plate

  !> Makes a rock, 10 by 10, that random joints cut, on a fixed line near its foot; kg, m, s, N.
  subroutine jointed_rock(n_joints, seed, world, groups)
    integer, intent(in) :: n_joints, seed
    type(world_t), intent(out) :: world
    character(len=*), intent(in), optional :: groups
    type(random_t) :: random
    type(block_material_t), parameter :: granite = block_material_t(density=2500.0_dp, unit_weight=25000.0_dp, young=1e9_dp, &
                                                                    poisson=0.25_dp)
    real(dp), parameter :: side = 10.0_dp
    real(dp) :: u(5), angle, half(2)
    integer :: i, k, unit

    random%state = seed
    open (newunit=unit, file=stem()//'.geo', action='write', status='replace')
    write (unit, '(a)') '0.002'
    write (unit, '(i0)') n_joints + 4, 4, 0, 0, 1, 0, 0, 0
    write (unit, '(4(1x,es24.16e3),a)') 0.0_dp, 0.0_dp, side, 0.0_dp, ' 1', side, 0.0_dp, side, side, ' 1', &
      side, side, 0.0_dp, side, ' 1', 0.0_dp, side, 0.0_dp, 0.0_dp, ' 1'
    do i = 1, n_joints
      do k = 1, 5
        call next_uniform(random, u(k))
      end do
      angle = merge(0.3_dp, 1.8_dp, u(1) < 0.5_dp) + 0.5_dp*(u(2) - 0.5_dp)
      half = (1.5_dp + 3*u(3))*[cos(angle), sin(angle)]
      write (unit, '(4(1x,es24.16e3),a)') side*u(4:5) - half, side*u(4:5) + half, ' 1'
    end do
    write (unit, '(4(1x,es24.16e3))') [-0.01_dp, 0.03_dp, side + 0.01_dp, 0.03_dp]
    close (unit)
    call write_analysis(stem()//'.ana', groups, [granite], joint_material_t(friction_angle=30.0_dp), 0.005_dp)
    call read_world(stem()//'.geo', stem()//'.ana', world)
    call remove(stem()//'.geo')
    call remove(stem()//'.ana')
  end subroutine jointed_rock

  !> Takes a step as a run does.
  subroutine take_step(world, error)
    type(world_t), intent(inout) :: world
    type(error_t), allocatable, intent(out) :: error
    type(step_report_t) :: report

    associate (settings => world%scene%settings, state => world%state)
      if (allocated(state%deviation)) then
        call advance_estimated(world%model, world%awake, world%cache, state, report, error)
      else if (allocated(state%sleep)) then
        call advance_awake(world%model, next_size(settings, state), world%awake, world%cache, state, report, error)
      else
        call advance(world%model, next_size(settings, state), world%cache, state, report, error)
      end if
      if (allocated(error)) return
      call after_step(settings, report%dt, report%rejected, state)
      if (settings%chooses_step) &
        state%pace%size = following_size(world%scene, world%model, state%contacts, report%dt, report%travel)
    end associate
  end subroutine take_step

  !> Gives back what the equations of a world hold outside of Fortran.
  subroutine end_world(world)
    type(world_t), intent(inout) :: world

    call release_equations(world%cache%equations)
  end subroutine end_world

  !> Corners of a box.
  pure function box(x, y, width, height) result(corner)
    real(dp), intent(in) :: x, y          !! lower left corner
    real(dp), intent(in) :: width, height
    real(dp) :: corner(8)

    corner = [x, y, x + width, y, x + width, y + height, x, y + height]
  end function box

  !> Writes a block file, every number so that it reads back as it was.
  subroutine write_blocks(path, corner, counts, fixed, load, rock)
    character(len=*), intent(in) :: path
    real(dp), intent(in) :: corner(:)
    integer, intent(in) :: counts(:)
    real(dp), intent(in), optional :: fixed(:, :), load(:, :)
    type(block_material_t), intent(in), optional :: rock(:)
    integer :: b, i, n_materials, unit

    n_materials = 1
    if (present(rock)) n_materials = size(rock)
    open (newunit=unit, file=path, action='write', status='replace')
    write (unit, '(i0,1x,i0,1x,i0)') size(counts), 0, sum(counts), count_of(fixed), count_of(load), 0
    do b = 1, size(counts)
      write (unit, '(i0,2(1x,i0))') min(b, n_materials), sum(counts(:b - 1)) + 1, sum(counts(:b))
    end do
    write (unit, '(i0,1x,es24.16e3,1x,es24.16e3)') (1, corner(2*i - 1), corner(2*i), i=1, sum(counts))
    do i = 1, count_of(fixed)
      write (unit, '(2(es24.16e3,1x),i0)') fixed(:, i), 0
    end do
    do i = 1, count_of(load)
      write (unit, '(2(es24.16e3,1x),i0)') load(:, i), 0
    end do
    close (unit)
  end subroutine write_blocks

  !> Writes an analysis deck in the short order.
  subroutine write_analysis(path, groups, rock, joint, dt, carried)
    character(len=*), intent(in) :: path
    character(len=*), intent(in), optional :: groups
    type(block_material_t), intent(in), optional :: rock(:)
    type(joint_material_t), intent(in), optional :: joint
    real(dp), intent(in), optional :: dt, carried
    type(block_material_t), allocatable :: material(:)
    type(joint_material_t) :: surface
    real(dp) :: share, step
    integer :: i, unit

    material = [default_rock]
    if (present(rock)) material = rock
    if (present(joint)) surface = joint
    step = 0.01_dp
    if (present(dt)) step = dt
    share = 1.0_dp
    if (present(carried)) share = carried
    open (newunit=unit, file=path, action='write', status='replace')
    write (unit, '(es24.16e3)') share
    write (unit, '(i0)') 1000, size(material), 1
    write (unit, '(es24.16e3)') 0.05_dp, step
    do i = 1, size(material)
      associate (a => material(i))
        write (unit, '(4(1x,es24.16e3))') a%density, a%unit_weight, a%young, a%poisson
        write (unit, '(3(1x,es24.16e3))') a%stress, a%stress_gradient, a%velocity
      end associate
    end do
    write (unit, '(3(1x,es24.16e3))') surface%friction_angle, surface%cohesion, surface%tensile_strength
    if (present(groups)) write (unit, '(a)') groups
    close (unit)
  end subroutine write_analysis

  !> Decks of a test stand beside its program, under its name.
  function stem()
    character(len=:), allocatable :: stem
    integer :: length

    call get_command_argument(0, length=length)
    allocate (character(len=length) :: stem)
    call get_command_argument(0, stem)
    stem = stem//'.world'
  end function stem

  !> How many points there are.
  pure integer function count_of(point)
    real(dp), intent(in), optional :: point(:, :)

    count_of = 0
    if (present(point)) count_of = size(point, 2)
  end function count_of

  !> Removes a file.
  subroutine remove(path)
    character(len=*), intent(in) :: path
    integer :: unit

    open (newunit=unit, file=path, status='old')
    close (unit, status='delete')
  end subroutine remove

end module worlds
