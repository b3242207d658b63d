!> The effects of a scene in words, each with the reason for it.
module scree_list_effects
  use scree_block_input, only: blocks_t
  use scree_cover_input, only: cover_quality_t
  use scree_in_situ, only: in_situ_text
  use scree_kinds, only: dp
  use scree_make_effects, only: first_used
  use scree_model, only: effects_t
  use scree_scene, only: effect_t, model_nmm, rotation_linear, scene_t, scheme_bathe, scheme_central_difference, &
                         scheme_energy_decaying, scheme_energy_momentum, scheme_generalized_alpha, settings_t, strain_auto, &
                         strain_green, strain_rotation
  use scree_setting_table, only: index_of
  use scree_state, only: state_t
  use scree_system, only: absorber_end, edge_end, measured_point, roller_end, system_t
  use scree_text, only: number_text, real_text, short_text
  implicit none
  private
  public :: list_effects

contains

  !> Lists the effects of a scene that they were made from, in the order in which `check` prints them.
  subroutine list_effects(scene, blocks, system, state, quality, effects, list)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    type(cover_quality_t), intent(in) :: quality
    type(effects_t), intent(in) :: effects
    type(effect_t), allocatable, intent(out) :: list(:)

    allocate (list(0))
    call list_motion(scene, list)
    call list_covers(scene, system, quality, effects, list)
    call list_start(scene, system, state, effects, list)
    call list_damping(effects, list)
    call list_supports(system, effects, list)
    call list_edges(scene, system, effects, list)
    if (allocated(effects%bolt)) call add(list, 'bolts', bolts_text(scene, blocks))
    if (allocated(effects%contact)) call add(list, 'contact', contact_text(scene%settings, system%n_blocks))
    if (allocated(effects%sleep)) call add(list, 'sleep', 'weight and contact; step.sleep='//real_text(scene%settings%sleep))
    if (any(system%points%kind == measured_point)) &
      call add(list, 'measured points', number_text(count(system%points%kind == measured_point))//' in the geometry')
  end subroutine list_effects

  !> Adds an effect and its reason to a list.
  subroutine add(list, name, because)
    type(effect_t), allocatable, intent(inout) :: list(:)
    character(len=*), intent(in) :: name, because
    type(effect_t) :: this

    this%name = name
    this%because = trim(because) ! gfortran 12 gives a structure constructor the length before `trim`
    list = [list, this]
  end subroutine add

  !> Lists how blocks move and deform.
  subroutine list_motion(scene, list)
    type(scene_t), intent(in) :: scene
    type(effect_t), allocatable, intent(inout) :: list(:)

    call add(list, 'inertia', 'every scene; '//form_of_step(scene%settings))
    select case (scene%settings%strain)
    case (strain_green)
      call add(list, 'large deformation', "strain='green' in &method")
    case (strain_auto)
      call add(list, 'large deformation where needed', "strain='auto' in &method: where small strain is off by more than "// &
               real_text(scene%settings%accuracy)//' in a step')
    case (strain_rotation)
      call add(list, 'strain beside rotation', "strain='strain_rotation' in &method")
    case default
      call add(list, 'small strain', "strain='small' in &method or no word of strain")
    end select
  end subroutine list_motion

  !> Lists what covers the blocks, and how they move otherwise than by default.
  subroutine list_covers(scene, system, quality, effects, list)
    type(scene_t), intent(in) :: scene
    type(system_t), intent(in) :: system
    type(cover_quality_t), intent(in) :: quality
    type(effects_t), intent(in) :: effects
    type(effect_t), allocatable, intent(inout) :: list(:)

    associate (settings => scene%settings)
      if (settings%model == model_nmm) call add(list, 'manifold elements', "model='nmm' in &method")
      if (allocated(scene%mesh) .or. settings%cover_edge > 0) &
        call add(list, 'mathematical mesh', '&cover: '//number_text(system%n_elements)//' elements, '// &
                 number_text(system%n_covers)//' covers; smallest element '//real_text(rounded(quality%least_share))// &
                 ' of its triangle, '//number_text(quality%small)//' below '//real_text(settings%least_share))
      if (allocated(system%sampling)) &
        call add(list, 'covers of second order', 'order=1 in &cover; the elements are cut up into '// &
                 number_text(system%n_elements)//' cells')
      if (allocated(system%extension)) &
        call add(list, 'extended covers', number_text(quality%extended)//' covers without an element of '// &
                 real_text(settings%least_share)//' of its triangle follow others, with weights up to '// &
                 real_text(rounded(quality%farthest)))
      if (effects%rotation /= rotation_linear) &
        call add(list, 'finite rotation', "rotation='"//scene%words(index_of(scene%words, 'method.rotation'))%value//"' in &method")
      if (effects%mass_follows_area) &
        call add(list, 'mass that follows area', "mass='follows_area' in &method or preset='shi'")
      if (scene%carried < 1) &
        call add(list, 'static', 'a step begins with '//percent(scene%carried)//' of the velocity of the step before (k01)')
    end associate
  end subroutine list_covers

  !> Lists weight, the stress and the velocity that a run begins with, and the motion of the ground.
  subroutine list_start(scene, system, state, effects, list)
    type(scene_t), intent(in) :: scene
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    type(effects_t), intent(in) :: effects
    type(effect_t), allocatable, intent(inout) :: list(:)
    integer :: i

    associate (material => scene%block_material, settings => scene%settings)
      if (allocated(effects%gravity)) then
        call add(list, 'gravity', 'unit weight of block material '//number_text(first_used(system, abs(material%unit_weight) > 0)))
        if (settings%gravity_ramp > 0) &
          call add(list, 'growing gravity', 'ramp='//real_text(settings%gravity_ramp)//' in &gravity')
      end if
      i = first_used(system, [(any(abs([material(i)%stress, material(i)%stress_gradient]) > 0), i=1, size(material))])
      if (i > 0) call add(list, 'initial stress', 'stress of block material '//number_text(i))
      if (allocated(settings%k0)) call add(list, 'initial stress', in_situ_text(state%stress))
      i = first_used(system, [(any(abs(material(i)%velocity) > 0), i=1, size(material))])
      if (i > 0 .and. .not. scene%is_static()) &
        call add(list, 'initial velocity', 'velocity of block material '//number_text(i))
    end associate
    if (.not. allocated(effects%base_acceleration)) return
    associate (ground => scene%ground)
      call add(list, 'base acceleration', '&acceleration: '//number_text(size(ground%time))//' times from '// &
               real_text(ground%time(1))//' to '//real_text(ground%time(size(ground%time)))//', '// &
               trim(merge('the last one from there', 'none from there        ', ground%kept)))
    end associate
  end subroutine list_start

  !> Lists damping.
  subroutine list_damping(effects, list)
    type(effects_t), intent(in) :: effects
    type(effect_t), allocatable, intent(inout) :: list(:)

    if (allocated(effects%mass_damping)) &
      call add(list, 'mass damping', 'alpha '//real_text(effects%mass_damping%rate)//' of &damping')
    if (allocated(effects%stiffness_damping)) &
      call add(list, 'stiffness damping', 'beta '//real_text(effects%stiffness_damping%time)//' of &damping')
  end subroutine list_damping

  !> Lists fixed points, rollers and their motion.
  subroutine list_supports(system, effects, list)
    type(system_t), intent(in) :: system
    type(effects_t), intent(in) :: effects
    type(effect_t), allocatable, intent(inout) :: list(:)
    integer :: n_rollers

    if (.not. allocated(effects%fixed_point)) return
    associate (held => effects%fixed_point)
      n_rollers = count(system%points%kind(held%point) == roller_end)
      if (size(held%point) > n_rollers) &
        call add(list, 'fixed points', number_text(size(held%point) - n_rollers)//' in the geometry, '// &
                 merge('held by springs', 'held exactly   ', held%by_springs))
      if (n_rollers > 0) &
        call add(list, 'rollers', 'edges and points of &support, held at '//number_text(n_rollers)//' places, '// &
                 merge('held by springs', 'held exactly   ', held%by_springs))
      if (held%moves) &
        call add(list, 'moving supports', 'displacements of fixed points in the analysis deck, or moved in &support')
    end associate
  end subroutine list_supports

  !> Lists loads on points and edges, water and absorbing edges.
  subroutine list_edges(scene, system, effects, list)
    type(scene_t), intent(in) :: scene
    type(system_t), intent(in) :: system
    type(effects_t), intent(in) :: effects
    type(effect_t), allocatable, intent(inout) :: list(:)
    integer :: places_of_piece                        ! of an edge: its ends, with covers of second order its middle too

    places_of_piece = merge(3, 2, allocated(system%sampling))
    if (allocated(effects%point_load)) &
      call add(list, 'point loads', number_text(size(effects%point_load%point))//' load points with a force')
    if (size(scene%boundary_loads) > 0) &
      call add(list, 'boundary loads', number_text(size(scene%boundary_loads))//' lines in &boundary; with water '// &
               number_text(count(system%points%kind == edge_end)/places_of_piece)//' pieces of edges')
    if (allocated(scene%settings%water_table)) &
      call add(list, 'water', 'table in &water; with boundary loads '//number_text(count(system%points%kind == edge_end)/2)// &
               ' pieces of edges')
    if (any(system%points%kind == absorber_end)) &
      call add(list, 'absorbing edges', 'lines in &absorbing, '//number_text(count(system%points%kind == absorber_end)/2)// &
               ' pieces of edges; '//merge('a wave comes in ', 'no wave comes in', allocated(scene%wave%time)))
  end subroutine list_edges

  !> Bolts in words.
  pure function bolts_text(scene, blocks) result(text)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    character(len=:), allocatable :: text
    integer :: crossings, in_ground

    text = number_text(size(scene%bolts))//' in the decks'
    in_ground = count(blocks%end_point == 0)
    if (in_ground > 0) text = text//'; '//number_text(in_ground)//' ends in no block, which the ground holds'
    if (blocks%n_moved > 0) &
      text = text//'; '//number_text(blocks%n_moved)//' ends up to '//short_text(blocks%moved)// &
             ' outside the blocks, moved to the nearest one'
    crossings = count(blocks%joint_point(1, :) > 0)
    if (crossings > 0) text = text//'; grouted ones cross '//number_text(crossings)//' joints'
  end function bolts_text

  !> What touches, and the springs of contacts, in words.
  pure function contact_text(settings, n_blocks) result(text)
    type(settings_t), intent(in) :: settings
    integer, intent(in) :: n_blocks
    character(len=:), allocatable :: text

    text = 'a joint inside a block'
    if (n_blocks > 1) text = number_text(n_blocks)//' blocks'
    text = text//'; springs of '//real_text(settings%contact_stiffness)//' force/length across'
    if (allocated(settings%joint_kn)) &
      text = text//'; stiffness of its own for '//number_text(count(settings%joint_kn > 0))//' joint materials'
  end function contact_text

  !> Two digits of a number.
  pure real(dp) function rounded(x)
    real(dp), intent(in) :: x
    character(len=10) :: digits

    write (digits, '(es9.1e3)') x
    read (digits, *) rounded
  end function rounded

  !> A fraction as a percentage.
  pure function percent(share)
    real(dp), intent(in) :: share
    character(len=:), allocatable :: percent
    character(len=12) :: digits

    write (digits, '(f6.1)') 100*share
    percent = trim(adjustl(digits))//' %'
  end function percent

  !> The integrator in words.
  pure function form_of_step(settings) result(form)
    type(settings_t), intent(in) :: settings
    character(len=:), allocatable :: form

    form = 'the Newmark form of the step'
    if (settings%takes_small_steps()) form = 'small steps of rigid blocks, without strain, waves and stiffness of joints'
    select case (settings%scheme)
    case (scheme_energy_momentum)
      form = 'the energy-momentum form of the step'
    case (scheme_energy_decaying)
      form = 'the energy-decaying form of the step'
    case (scheme_central_difference)
      form = 'explicit central differences, in steps that no element is too stiff for'
    case (scheme_generalized_alpha)
      form = 'the generalized-alpha form of the step'
    case (scheme_bathe)
      form = 'the composite form of Bathe, two steps at a time'
    end select
  end function form_of_step

end module scree_list_effects
