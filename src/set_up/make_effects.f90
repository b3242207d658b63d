!> The effects that a scene calls for, each with the reason.
module scree_make_effects
  use scree_block_input, only: blocks_t
  use scree_bolt, only: bolt_t
  use scree_contact_rules, only: looks_at_all
  use scree_contacts, only: contact_law_t, shi_law_t
  use scree_cover_input, only: cover_quality_t
  use scree_in_situ, only: in_situ_text
  use scree_interpolation, only: kinematics_of, kinematics_t
  use scree_joint_rules, only: laws_in_use
  use scree_kinds, only: dp
  use scree_make_joints, only: joints_of
  use scree_material, only: elasticity
  use scree_model, only: effects_t
  use scree_pairs, only: list_pairs, pair_of
  use scree_rollers, only: roller_t
  use scree_scene, only: contact_none, effect_t, fixed_exact, mass_follows_area, model_nmm, rotation_linear, scene_t, &
                         scheme_bathe, scheme_central_difference, scheme_energy_decaying, scheme_energy_momentum, &
                         scheme_generalized_alpha, settings_t, strain_auto, strain_green, strain_rotation, time_table_t
  use scree_setting_table, only: index_of
  use scree_sorting, only: columns, sort_into
  use scree_state, only: state_t
  use scree_system, only: absorber_end, edge_end, fixed_point, load_point, measured_point, roller_end, system_t
  use scree_text, only: number_text, real_text, short_text
  implicit none
  private
  public :: make_effects

  real(dp), parameter :: allowed_penetration = 2e-4_dp  !! of the extent, where the stiffness of contacts adapts (Shi: g3 w0)
  !> Of the extent, where contacts follow Shi's rules: overlap that closes, and gap that opens (Shi: s0, 2e-4 w0; f0, 2e-7 w0).
  real(dp), parameter :: closing_share = 1e-4_dp, opening_share = 1e-7_dp
  real(dp), parameter :: shortest_return = 5e-8_dp !! of the extent: slip back at which sliding that lags ends (Shi: 1e-7 w0)
  !> Search for contacts as in Shi's programs, relative to the extent: gap over the displacement ratio, and the least gap; overlap
  !> over that gap; number added to the square of an edge. (Shi: d0 = 2.5 g2 w0, d9 = 0.3 d0, 3 g3 w0, 1e-9 w0)
  real(dp), parameter :: search_share = 1.25_dp, search_least = 6e-4_dp, search_inside = 0.3_dp, search_guard = 5e-10_dp

contains

  !> The effects, decided once. Only materials that a block is made of count.
  subroutine make_effects(scene, blocks, system, state, quality, roller, effects, list)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    type(cover_quality_t), intent(in) :: quality
    type(roller_t), intent(in) :: roller(:)           !! (n_points)
    type(effects_t), intent(out) :: effects
    type(effect_t), allocatable, intent(out) :: list(:)
    integer :: places_of_piece                        ! of an edge: its ends, with covers of second order its middle too

    allocate (list(0))
    places_of_piece = merge(3, 2, allocated(system%sampling))
    call move_blocks()
    call cover_blocks()
    call weigh_blocks()
    call begin_stressed()
    call move_ground()
    call damp(scene%settings%rayleigh(), effects)
    if (allocated(effects%mass_damping)) &
      call name('mass damping', 'alpha '//real_text(effects%mass_damping%rate)//' of &damping')
    if (allocated(effects%stiffness_damping)) &
      call name('stiffness damping', 'beta '//real_text(effects%stiffness_damping%time)//' of &damping')
    call hold_points()
    call load_points()
    if (size(scene%boundary_loads) > 0) &
      call name('boundary loads', number_text(size(scene%boundary_loads))//' lines in &boundary; with water '// &
                number_text(count(system%points%kind == edge_end)/places_of_piece)//' pieces of edges')
    if (allocated(scene%settings%water_table)) &
      call name('water', 'table in &water; with boundary loads '//number_text(count(system%points%kind == edge_end)/2)// &
                ' pieces of edges')
    if (any(system%points%kind == absorber_end)) &
      call name('absorbing edges', 'lines in &absorbing, '//number_text(count(system%points%kind == absorber_end)/2)// &
                ' pieces of edges; '//merge('a wave comes in ', 'no wave comes in', allocated(scene%wave%time)))
    call bolt_blocks()
    call let_touch()
    call let_sleep()
    if (any(system%points%kind == measured_point)) &
      call name('measured points', number_text(count(system%points%kind == measured_point))//' in the geometry')

  contains

    !> Adds to the list.
    subroutine name(effect, because)
      character(len=*), intent(in) :: effect, because
      type(effect_t) :: this

      this%name = effect
      this%because = trim(because) ! gfortran 12 gives a structure constructor the length before `trim`
      list = [list, this]
    end subroutine name

    !> How blocks move and deform.
    subroutine move_blocks()
      integer :: i

      associate (settings => scene%settings)
        effects%transport = settings%transport
        effects%carried = scene%carried
        allocate (effects%elasticity(3, 3, size(scene%block_material)))
        do i = 1, size(scene%block_material)
          effects%elasticity(:, :, i) = elasticity(scene%block_material(i), settings%plane)
        end do
        call name('inertia', 'every scene; '//form_of_step(settings))
        effects%large_deformation = any(settings%strain == [strain_green, strain_auto])
        effects%strain_rotation = settings%strain == strain_rotation
        select case (settings%strain)
        case (strain_green)
          call name('large deformation', "strain='green' in &method")
        case (strain_auto)
          call name('large deformation where needed', "strain='auto' in &method: where small strain is off by more than "// &
                    real_text(settings%accuracy)//' in a step')
          effects%accuracy = settings%accuracy
        case (strain_rotation)
          call name('strain beside rotation', "strain='strain_rotation' in &method")
        case default
          call name('small strain', "strain='small' in &method or no word of strain")
        end select
        effects%rotation = settings%rotation
        effects%mass_follows_area = settings%mass == mass_follows_area
      end associate
    end subroutine move_blocks

    !> What covers the blocks, and how they move otherwise than scree would have it.
    subroutine cover_blocks()
      associate (settings => scene%settings)
        if (settings%model == model_nmm) call name('manifold elements', "model='nmm' in &method")
        if (allocated(scene%mesh) .or. settings%cover_edge > 0) &
          call name('mathematical mesh', '&cover: '//number_text(system%n_elements)//' elements, '// &
                    number_text(system%n_covers)//' covers; smallest element '//real_text(rounded(quality%least_share))// &
                    ' of its triangle, '//number_text(quality%small)//' below '//real_text(settings%least_share))
        if (allocated(system%sampling)) &
          call name('covers of second order', 'order=1 in &cover; the elements are cut up into '//number_text(system%n_elements)// &
                    ' cells')
        if (allocated(system%extension)) &
          call name('extended covers', number_text(quality%extended)//' covers without an element of '// &
                    real_text(settings%least_share)//' of its triangle follow others, with weights up to '// &
                    real_text(rounded(quality%farthest)))
        if (effects%rotation /= rotation_linear) &
          call name('finite rotation', "rotation='"//scene%words(index_of(scene%words, 'method.rotation'))%value//"' in &method")
        if (effects%mass_follows_area) call name('mass that follows area', "mass='follows_area' in &method or preset='shi'")
        if (scene%carried < 1) &
          call name('static', 'a step begins with '//percent(scene%carried)//' of the velocity of the step before (k01)')
      end associate
    end subroutine cover_blocks

    !> Gravity, where a material has a weight.
    subroutine weigh_blocks()
      type(kinematics_t) :: element
      integer :: e, i

      associate (material => scene%block_material, used => system%elements%material)
        i = first_used(abs(material%unit_weight) > 0)
        if (i == 0) return
        call name('gravity', 'unit weight of block material '//number_text(i))
        if (scene%settings%gravity_ramp > 0) &
          call name('growing gravity', 'ramp='//real_text(scene%settings%gravity_ramp)//' in &gravity')
        allocate (effects%gravity)
        effects%gravity%ramp = scene%settings%gravity_ramp
        allocate (effects%gravity%weight(system%n_elements), source=0.0_dp)
        do e = 1, system%n_elements
          element = kinematics_of(system, state, e)
          if (system%present(system%elements%block(e))) &
            effects%gravity%weight(e) = material(used(e))%unit_weight*element%area
        end do
      end associate
    end subroutine weigh_blocks

    !> Stress and velocity that a run begins with.
    subroutine begin_stressed()
      integer :: i

      associate (material => scene%block_material)
        i = first_used([(any(abs([material(i)%stress, material(i)%stress_gradient]) > 0), i=1, size(material))])
        if (i > 0) call name('initial stress', 'stress of block material '//number_text(i))
        if (allocated(scene%settings%k0)) call name('initial stress', in_situ_text(state%stress))
        i = first_used([(any(abs(material(i)%velocity) > 0), i=1, size(material))])
        if (i > 0 .and. .not. scene%is_static()) call name('initial velocity', 'velocity of block material '//number_text(i))
      end associate
    end subroutine begin_stressed

    !> First of the materials that something holds of and that a block is made of, 0 where there is none.
    pure integer function first_used(holds)
      logical, intent(in) :: holds(:) !! (n_materials)
      integer :: i

      first_used = findloc([(holds(i) .and. any(system%elements%material == i), i=1, size(holds))], .true., 1)
    end function first_used

    !> A ground that accelerates at some time.
    subroutine move_ground()
      if (.not. allocated(scene%ground%time)) return
      if (.not. any(abs(scene%ground%value) > 0)) return
      call name('base acceleration', '&acceleration: '//number_text(size(scene%ground%time))//' times from '// &
                real_text(scene%ground%time(1))//' to '//real_text(scene%ground%time(size(scene%ground%time)))//', '// &
                trim(merge('the last one from there', 'none from there        ', scene%ground%kept)))
      allocate (effects%base_acceleration)
      effects%base_acceleration%record = scene%ground
    end subroutine move_ground

    !> Fixed points of what is there.
    subroutine hold_points()
      type(time_table_t), allocatable :: table(:)
      integer, allocatable :: of_kind(:), rollers(:), there(:)
      integer :: i

      of_kind = pack([(i, i=1, size(system%points%kind))], system%points%kind == fixed_point)
      there = pack([(i, i=1, size(of_kind))], are_there(of_kind))
      of_kind = of_kind(there)
      rollers = pack([(i, i=1, size(system%points%kind))], system%points%kind == roller_end)
      if (size(of_kind) + size(rollers) == 0) return
      allocate (table(size(of_kind) + size(rollers)))
      table(:size(of_kind)) = scene%fixed_table(there)
      table(size(of_kind) + 1:) = roller(rollers)%table
      allocate (effects%fixed_point)
      associate (held => effects%fixed_point)
        held%by_springs = scene%settings%fixed /= fixed_exact
        held%stiffness = scene%settings%fixed_stiffness
        if (size(of_kind) > 0) call name('fixed points', number_text(size(of_kind))//' in the geometry, '// &
                                         merge('held by springs', 'held exactly   ', held%by_springs))
        if (size(rollers) > 0) call name('rollers', 'edges and points of &support, held at '//number_text(size(rollers))// &
                                         ' places, '//merge('held by springs', 'held exactly   ', held%by_springs))
        call by_element(system, [of_kind, rollers], table, held%first, held%point, held%table)
        if (size(rollers) > 0) held%direction = directions_of(roller(held%point))
        held%home = state%point(:, held%point)
        held%moves = any([(allocated(held%table(i)%time), i=1, size(held%table))])
        if (held%moves) call name('moving supports', 'displacements of fixed points in the analysis deck, or moved in &support')
      end associate
    end subroutine hold_points

    !> Bolts of the geometry and of &bolts.
    subroutine bolt_blocks()
      character(len=:), allocatable :: because
      integer :: crossings, in_ground

      if (size(blocks%bolt) == 0) return
      because = number_text(size(scene%bolts))//' in the decks'
      in_ground = count(blocks%end_point == 0)
      if (in_ground > 0) because = because//'; '//number_text(in_ground)//' ends in no block, which the ground holds'
      if (blocks%n_moved > 0) &
        because = because//'; '//number_text(blocks%n_moved)//' ends up to '//short_text(blocks%moved)// &
                  ' outside the blocks, moved to the nearest one'
      crossings = count(blocks%joint_point(1, :) > 0)
      if (crossings > 0) because = because//'; grouted ones cross '//number_text(crossings)//' joints'
      call name('bolts', because)
      allocate (effects%bolt)
      effects%bolt = bolts_of(blocks, system, scene%settings%bolts_break)
    end subroutine bolt_blocks

    !> Contact, where there is more than one block, or a joint in one under a mesh that may close.
    subroutine let_touch()

      associate (s => scene%settings, joint => scene%joint_material)
        if (s%contact == contact_none) return
        if (system%n_blocks > 1) then
          call name('contact', number_text(system%n_blocks)//' blocks; springs of '//springs_text(s))
        else if (size(blocks%crack_joint) > 0 .and. system%n_elements > 1) then ! a joint ends inside a block
          call name('contact', 'a joint inside a block; springs of '//springs_text(s))
        else
          return
        end if
        allocate (effects%contact)
        effects%contact%normal_stiffness = s%contact_stiffness
        effects%contact%shear_stiffness = s%contact_stiffness/s%shear_ratio
        effects%contact%penetration = s%overlap
        effects%contact%restitution = s%restitution
        effects%contact%viscosity = s%viscosity
        effects%contact%rules = s%rules
        effects%contact%shi = shi_law_of(scene)
        effects%contact%joint = joints_of(s, joint)
        effects%contact%uses = laws_in_use(effects%contact%joint)
        effects%contact%most_dilated = 2*maxval(effects%contact%joint%dilation%tangent*effects%contact%joint%dilation%slip)
        if (allocated(effects%gravity)) effects%contact%settling = settling_of_scene(effects%contact)
      end associate
    end subroutine let_touch

    !> Settlement of a column of rock as high as the scene under its own weight, length.
    !>
    !> It is the unit weight times the height squared over twice the modulus of a mass of blocks, 1/(1/E + 1/(s b)). Here s is the
    !> normal stiffness of a joint and b the mean size of a block. A joint without its own stiffness is two springs on a face.
    !>
    !> A weight that acts at once makes speeds of up to g H/c, because a point is free until the wave from the foot arrives, with
    !> the speed c = (E/rho)^1/2. A block with that speed rises by g H^2/(2 c^2), which is this settlement.
    pure real(dp) function settling_of_scene(law) result(settling)
      type(contact_law_t), intent(in) :: law
      type(kinematics_t) :: element
      real(dp) :: area, height, size_of_block, soft
      integer :: e

      area = 0.0_dp
      do e = 1, system%n_elements
        element = kinematics_of(system, state, e)
        area = area + element%area
      end do
      size_of_block = sqrt(area/system%n_blocks)
      height = maxval(state%vertex(2, :)) - minval(state%vertex(2, :))
      soft = size_of_block/(2*law%normal_stiffness)
      associate (kn => law%joint%stiffness%normal)
        if (any(kn > 0)) soft = max(soft, 1/minval(kn, mask=kn > 0))
      end associate
      associate (rock => scene%block_material(system%elements%material))
        settling = maxval(rock%unit_weight*(1/rock%young + soft/size_of_block))*height**2/2
      end associate
    end function settling_of_scene

    !> Islands at rest need no computing where a touch or a load can wake them, and a weight tells what little is.
    subroutine let_sleep()
      associate (s => scene%settings)
        if (s%sleep <= 0 .or. scene%is_static() .or. s%chooses_step .or. s%cracks_may_grow()) return
        if (.not. (allocated(effects%gravity) .and. allocated(effects%contact))) return
        if (looks_at_all(effects%contact)) return
        effects%sleep = s%sleep
        call name('sleep', 'weight and contact; step.sleep='//real_text(s%sleep))
      end associate
    end subroutine let_sleep

    !> The springs of contacts in words.
    function springs_text(s) result(text)
      type(settings_t), intent(in) :: s
      character(len=:), allocatable :: text

      text = real_text(s%contact_stiffness)//' force/length across'
      if (allocated(s%joint_kn)) text = text//'; stiffness of its own for '//number_text(count(s%joint_kn > 0))// &
                                        ' joint materials'
    end function springs_text

    !> Which points are of blocks that no stage has removed.
    pure function are_there(point) result(there)
      integer, intent(in) :: point(:)
      logical :: there(size(point))

      there = system%present(system%elements%block(system%points%element(point)))
    end function are_there

    !> Load points of what is there that have a force at some time.
    subroutine load_points()
      integer, allocatable :: acting(:), of_kind(:)
      integer :: i

      if (.not. allocated(scene%load_table)) return
      acting = pack([(i, i=1, size(scene%load_table))], [(has_force(scene%load_table(i)), i=1, size(scene%load_table))])
      of_kind = pack([(i, i=1, size(system%points%kind))], system%points%kind == load_point)
      acting = pack(acting, are_there(of_kind(acting)))
      if (size(acting) == 0) return
      call name('point loads', number_text(size(acting))//' load points with a force')
      allocate (effects%point_load)
      call by_element(system, of_kind(acting), scene%load_table(acting), effects%point_load%first, effects%point_load%point, &
                      effects%point_load%table)
    end subroutine load_points

    !> Whether a table has a force at some time.
    pure logical function has_force(table)
      type(time_table_t), intent(in) :: table

      has_force = allocated(table%time)
      if (has_force) has_force = any(abs(table%value) > 0)
    end function has_force

  end subroutine make_effects

  !> Directions in which points are held alone, (2, n); 0: not so.
  pure function directions_of(roller) result(direction)
    type(roller_t), intent(in) :: roller(:)
    real(dp) :: direction(2, size(roller))
    integer :: i

    direction = reshape([(roller(i)%direction, i=1, size(roller))], shape(direction))
  end function directions_of

  !> Damping in proportion to mass and to stiffness.
  pure subroutine damp(rates, effects)
    real(dp), intent(in) :: rates(2)              !! alpha, 1/time, and beta, time
    type(effects_t), intent(inout) :: effects

    if (rates(1) > 0) then
      allocate (effects%mass_damping)
      effects%mass_damping%rate = rates(1)
    end if
    if (.not. rates(2) > 0) return
    allocate (effects%stiffness_damping)
    effects%stiffness_damping%time = rates(2)
  end subroutine damp

  !> Bolts with the elements that carry their ends.
  pure type(bolt_t) function bolts_of(blocks, system, break) result(bolts)
    type(blocks_t), intent(in) :: blocks
    type(system_t), intent(in) :: system
    logical, intent(in) :: break             !! at their strength
    integer :: i, k, pair(2, size(blocks%bolt))
    integer, dimension(size(blocks%bolt)) :: alone_in, place
    integer, allocatable :: number(:)
    logical :: joins(size(blocks%bolt))

    associate (n => size(blocks%bolt))
      bolts%point = blocks%end_point
      bolts%crossing = blocks%joint_point
      allocate (bolts%piece(2, n), source=0.0_dp)
      allocate (bolts%element(2, n), source=0)
      allocate (bolts%ground(2, 2, n), source=0.0_dp)
      allocate (bolts%carries(system%n_elements), source=.false.)
      do i = 1, n
        bolts%ground(:, :, i) = blocks%bolt(i)%ends - spread(system%origin, 2, 2)
        do k = 1, 2
          if (bolts%point(k, i) > 0) bolts%element(k, i) = system%points%element(bolts%point(k, i))
          if (bolts%crossing(k, i) > 0) &
            bolts%piece(k, i) = norm2(blocks%point(:, bolts%point(k, i)) - blocks%point(:, bolts%crossing(k, i)))
          if (bolts%element(k, i) > 0) bolts%carries(bolts%element(k, i)) = .true.
        end do
        pair(:, i) = pair_of(bolts%element(1, i), bolts%element(2, i))
      end do
      bolts%stiffness = transpose(reshape([blocks%bolt%stiffness, blocks%bolt%shear_stiffness], [n, 2]))
      bolts%strength = transpose(reshape([blocks%bolt%strength, blocks%bolt%shear_strength], [n, 2]))
      where (.not. bolts%strength > 0) bolts%strength = huge(1.0_dp)
      bolts%number = blocks%bolt_of
      bolts%breaks = break
      joins = pair(1, :) > 0 .and. pair(1, :) < pair(2, :)
      call list_pairs(columns(pair, joins), reshape([integer ::], [2, 0]), bolts%pair, number)
      alone_in = merge(0, pair(2, :), joins)
      call sort_into(alone_in, system%n_elements, bolts%first, bolts%alone)
      place = unpack(number, joins, 0)
      call sort_into(place, size(bolts%pair, 2), bolts%first_of, bolts%joining)
    end associate
  end function bolts_of

  !> Sorts points and their tables by the element that carries them.
  pure subroutine by_element(system, points, tables, first, point, table)
    type(system_t), intent(in) :: system
    integer, intent(in) :: points(:)                  !! numbers of points in the system
    type(time_table_t), intent(in) :: tables(:)       !! one each
    integer, allocatable, intent(out) :: first(:)     !! (n_elements+1)
    integer, allocatable, intent(out) :: point(:)
    type(time_table_t), allocatable, intent(out) :: table(:)
    integer, allocatable :: place(:)

    call sort_into(system%points%element(points), system%n_elements, first, place)
    point = points(place)
    table = tables(place)
  end subroutine by_element

  !> Numbers of Shi's rules of contact, relative to the model, half of whose size he calls w0. The search has its own distances
  !> where the scene has a displacement ratio (g2).
  pure type(shi_law_t) function shi_law_of(scene) result(law)
    type(scene_t), intent(in) :: scene

    associate (settings => scene%settings, extent => scene%extent)
      law%closing = closing_share*extent
      law%opening = opening_share*extent
      law%backlash = shortest_return*extent
      law%guard = search_guard*extent
      if (scene%displacement_ratio > 0) then
        law%search_gap = max(search_share*scene%displacement_ratio, search_least)*extent
        law%search_depth = max(search_inside*law%search_gap, search_least*extent)
      end if
      if (.not. scene%is_static()) then
        law%touching = law%closing
        if (law%search_gap > 0) law%touching = law%touching*2*law%search_gap/extent
      end if
      if (settings%adapts_stiffness) law%allowed_gap = scene%displacement_ratio*extent
      law%allowed_penetration = allowed_penetration*extent
    end associate
  end function shi_law_of

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

end module scree_make_effects
