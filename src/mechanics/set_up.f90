!> From a scene and its blocks to the system, the state at time 0 and the effects that the scene calls for.
module scree_set_up
  use scree_block_input, only: blocks_t
  use scree_cover_input, only: cover_blocks
  use scree_effects, only: effects_t
  use scree_interpolation, only: kinematics_of, kinematics_t, rigid_velocity
  use scree_kinds, only: dp
  use scree_material, only: elasticity
  use scree_scene, only: effect_t, fixed_exact, mass_follows_area, model_nmm, scene_t, scheme_energy_momentum, &
                         strain_green, time_table_t, transport_rates
  use scree_system, only: fixed_point, load_point, measured_point, state_t, system_t
  use scree_text, only: number_text
  implicit none
  private
  public :: set_up

contains

  !> Makes system, state and effects, and the list of effects with the reason for each.
  subroutine set_up(scene, blocks, system, state, effects, list)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(system_t), intent(out) :: system
    type(state_t), intent(out) :: state
    type(effects_t), intent(out) :: effects
    type(effect_t), allocatable, intent(out) :: list(:)

    call make_system(scene, blocks, system, state)
    call make_effects(scene, system, state, effects, list)
  end subroutine set_up

  !> Bodies and their state at rest, in coordinates about the middle of the scene.
  pure subroutine make_system(scene, blocks, system, state)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(system_t), intent(out) :: system
    type(state_t), intent(out) :: state
    type(kinematics_t) :: element
    real(dp) :: middle(2)
    integer :: e

    system%model = scene%settings%model
    middle = 0.5_dp*(minval(blocks%vertex, 2) + maxval(blocks%vertex, 2))
    system%origin = blocks%origin + middle
    state%vertex = blocks%vertex - spread(middle, 2, size(blocks%vertex, 2))
    state%point = blocks%point - spread(middle, 2, size(blocks%point, 2))
    call cover_blocks(system%model, blocks%shape, state%vertex, blocks%material, system%elements, state%cover)
    system%n_blocks = size(blocks%material)
    system%n_elements = size(system%elements%block)
    system%n_covers = maxval(system%elements%cover)
    system%n_unknowns = maxval(system%elements%unknown)
    system%points%kind = blocks%point_kind
    system%points%element = blocks%point_block ! a block is an element

    allocate (system%elements%mass(system%n_elements))
    allocate (state%stress(3, system%n_elements), state%deformation(4, system%n_elements))
    allocate (state%velocity(system%n_unknowns), state%acceleration(system%n_unknowns), source=0.0_dp)
    allocate (state%rotation(system%n_blocks), source=0.0_dp)
    do e = 1, system%n_elements
      element = kinematics_of(system, state, e)
      associate (material => scene%block_material(system%elements%material(e)))
        system%elements%mass(e) = material%density*element%area
        state%stress(:, e) = material%stress + (element%centroid(2) + system%origin(2))*material%stress_gradient
        state%deformation(:, e) = [1.0_dp, 0.0_dp, 0.0_dp, 1.0_dp]
        state%velocity(system%elements%unknown(:, e)) = rigid_velocity(system, state, e, element%centroid, material%velocity)
      end associate
    end do
  end subroutine make_system

  !> The effects, decided once. Only materials that a block is made of count.
  subroutine make_effects(scene, system, state, effects, list)
    type(scene_t), intent(in) :: scene
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    type(effects_t), intent(out) :: effects
    type(effect_t), allocatable, intent(out) :: list(:)
    type(kinematics_t) :: element
    integer :: e, i, n

    allocate (list(0))
    associate (settings => scene%settings, material => scene%block_material, used => system%elements%material)
      effects%transport = settings%transport
      effects%carried = scene%carried
      n = size(material)
      allocate (effects%elasticity(3, 3, n))
      do i = 1, n
        effects%elasticity(:, :, i) = elasticity(material(i), settings%plane)
      end do
      if (settings%scheme == scheme_energy_momentum) then
        call name('inertia', 'every scene; the energy-momentum form of the step')
      else
        call name('inertia', 'every scene; the Newmark form of the step')
      end if
      effects%large_deformation = settings%strain == strain_green
      if (effects%large_deformation) then
        call name('large deformation', "strain='green' in &method")
      else
        call name('small strain', "strain='small' in &method or no word of strain")
      end if
      if (settings%model == model_nmm) call name('manifold elements', "model='nmm' in &method")
      effects%mass_follows_area = settings%mass == mass_follows_area
      if (effects%mass_follows_area) call name('mass that follows area', "mass='follows_area' in &method or preset='shi'")
      if (scene%carried < 1) call name('static', 'the deck hands on '//percent(scene%carried)//' of the velocity (k01)')

      do i = 1, n
        if (all(used /= i) .or. .not. abs(material(i)%unit_weight) > 0) cycle
        call name('gravity', 'unit weight of block material '//number_text(i))
        allocate (effects%gravity)
        allocate (effects%gravity%weight(system%n_elements))
        do e = 1, system%n_elements
          element = kinematics_of(system, state, e)
          effects%gravity%weight(e) = material(used(e))%unit_weight*element%area
        end do
        exit
      end do
      do i = 1, n
        if (all(used /= i)) cycle
        if (any(abs([material(i)%stress, material(i)%stress_gradient]) > 0)) then
          call name('initial stress', 'stress of block material '//number_text(i))
          exit
        end if
      end do
      do i = 1, n
        if (all(used /= i)) cycle
        if (any(abs(material(i)%velocity) > 0)) then
          call name('initial velocity', 'velocity of block material '//number_text(i))
          exit
        end if
      end do
    end associate
    call hold_points()
    call load_points()
    if (any(system%points%kind == measured_point)) &
      call name('measured points', number_text(count(system%points%kind == measured_point))//' in the geometry')

  contains

    !> Adds to the list.
    subroutine name(effect, because)
      character(len=*), intent(in) :: effect, because

      list = [list, effect_t(effect, trim(because))]
    end subroutine name

    !> Fixed points.
    subroutine hold_points()
      integer, allocatable :: of_kind(:)
      integer :: i

      of_kind = pack([(i, i=1, size(system%points%kind))], system%points%kind == fixed_point)
      if (size(of_kind) == 0) return
      allocate (effects%fixed_point)
      associate (held => effects%fixed_point)
        held%by_springs = scene%settings%fixed /= fixed_exact
        held%stiffness = scene%settings%fixed_stiffness
        call name('fixed points', number_text(size(of_kind))//' in the geometry, '// &
                  merge('held by springs   ', 'eliminated exactly', held%by_springs))
        call by_element(system, of_kind, scene%fixed_table, held%first, held%point, held%table)
        held%home = state%point(:, held%point)
        do i = 1, size(held%table)
          if (.not. allocated(held%table(i)%time)) cycle
          call name('moving supports', 'displacements of fixed points in the analysis deck')
          exit
        end do
      end associate
    end subroutine hold_points

    !> Load points that have a force at some time.
    subroutine load_points()
      integer, allocatable :: of_kind(:)
      type(time_table_t), allocatable :: table(:)
      integer :: i

      of_kind = pack([(i, i=1, size(system%points%kind))], system%points%kind == load_point)
      allocate (table(0))
      if (.not. allocated(scene%load_table)) return
      do i = 1, size(of_kind)
        if (allocated(scene%load_table(i)%time)) then
          if (any(abs(scene%load_table(i)%value) > 0)) then
            table = [table, scene%load_table(i)]
            cycle
          end if
        end if
        of_kind(i) = 0
      end do
      of_kind = pack(of_kind, of_kind > 0)
      if (size(of_kind) == 0) return
      call name('point loads', number_text(size(of_kind))//' load points with a force')
      allocate (effects%point_load)
      call by_element(system, of_kind, table, effects%point_load%first, effects%point_load%point, effects%point_load%table)
    end subroutine load_points

  end subroutine make_effects

  !> Sorts points and their tables by the element that carries them.
  pure subroutine by_element(system, points, tables, first, point, table)
    type(system_t), intent(in) :: system
    integer, intent(in) :: points(:)                  !! numbers of points in the system
    type(time_table_t), intent(in) :: tables(:)       !! one each
    integer, allocatable, intent(out) :: first(:)     !! (n_elements+1)
    integer, allocatable, intent(out) :: point(:)
    type(time_table_t), allocatable, intent(out) :: table(:)
    integer :: e, i, at

    allocate (first(system%n_elements + 1), source=0)
    do i = 1, size(points)
      e = system%points%element(points(i))
      first(e + 1) = first(e + 1) + 1
    end do
    first(1) = 1
    do e = 1, system%n_elements
      first(e + 1) = first(e + 1) + first(e)
    end do
    allocate (point(size(points)), table(size(points)))
    do i = size(points), 1, -1
      e = system%points%element(points(i))
      at = first(e + 1) - 1
      first(e + 1) = at
      point(at) = points(i)
      table(at) = tables(i)
    end do
    first = [first(2:), size(points) + 1]
  end subroutine by_element

  !> A share as a percentage.
  pure function percent(share)
    real(dp), intent(in) :: share
    character(len=:), allocatable :: percent
    character(len=12) :: digits

    write (digits, '(f6.1)') 100*share
    percent = trim(adjustl(digits))//' %'
  end function percent

end module scree_set_up
