!> The effects that a scene calls for.
module scree_make_effects
  use scree_block_input, only: blocks_t
  use scree_bolt, only: bolt_t
  use scree_contact_rules, only: looks_at_all
  use scree_contacts, only: contact_law_t, shi_law_t
  use scree_interpolation, only: kinematics_of, kinematics_t
  use scree_joint_rules, only: laws_in_use
  use scree_kinds, only: dp
  use scree_make_joints, only: joints_of
  use scree_material, only: elasticity
  use scree_model, only: effects_t
  use scree_pairs, only: list_pairs, pair_of
  use scree_rollers, only: roller_t
  use scree_scene, only: contact_none, fixed_exact, mass_follows_area, scene_t, strain_auto, strain_green, strain_rotation, &
                         time_table_t
  use scree_sorting, only: columns, sort_into
  use scree_state, only: state_t
  use scree_system, only: fixed_point, load_point, roller_end, system_t
  implicit none
  private
  public :: first_used, make_effects

  real(dp), parameter :: allowed_penetration = 2e-4_dp  !! of the extent, where the stiffness of contacts adapts (Shi: g3 w0)
  !> Of the extent, where contacts follow Shi's rules: overlap that closes, and gap that opens (Shi: s0, 2e-4 w0; f0, 2e-7 w0).
  real(dp), parameter :: closing_share = 1e-4_dp, opening_share = 1e-7_dp
  real(dp), parameter :: shortest_return = 5e-8_dp !! of the extent: slip back at which sliding that lags ends (Shi: 1e-7 w0)
  !> Search for contacts as in Shi's programs, relative to the extent: gap over the displacement ratio, and the least gap; overlap
  !> over that gap; number added to the square of an edge. (Shi: d0 = 2.5 g2 w0, d9 = 0.3 d0, 3 g3 w0, 1e-9 w0)
  real(dp), parameter :: search_share = 1.25_dp, search_least = 6e-4_dp, search_inside = 0.3_dp, search_guard = 5e-10_dp

contains

  !> The effects, decided once. Only materials that a block is made of count.
  subroutine make_effects(scene, blocks, system, state, roller, effects)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    type(roller_t), intent(in) :: roller(:)           !! (n_points)
    type(effects_t), intent(out) :: effects

    call move_blocks(scene, effects)
    call weigh_blocks(scene, system, state, effects)
    call move_ground(scene%ground, effects)
    call damp(scene%settings%rayleigh(), effects)
    call hold_points(scene, system, state, roller, effects)
    call load_points(scene, system, effects)
    if (size(blocks%bolt) > 0) effects%bolt = bolts_of(blocks, system, scene%settings%bolts_break)
    call let_touch(scene, blocks, system, state, effects)
    call let_sleep(scene, effects)
  end subroutine make_effects

  !> How blocks move and deform.
  pure subroutine move_blocks(scene, effects)
    type(scene_t), intent(in) :: scene
    type(effects_t), intent(inout) :: effects
    integer :: i

    associate (settings => scene%settings)
      effects%transport = settings%transport
      effects%carried = scene%carried
      allocate (effects%elasticity(3, 3, size(scene%block_material)))
      do i = 1, size(scene%block_material)
        effects%elasticity(:, :, i) = elasticity(scene%block_material(i), settings%plane)
      end do
      effects%large_deformation = any(settings%strain == [strain_green, strain_auto])
      effects%strain_rotation = settings%strain == strain_rotation
      if (settings%strain == strain_auto) effects%accuracy = settings%accuracy
      effects%rotation = settings%rotation
      effects%mass_follows_area = settings%mass == mass_follows_area
    end associate
  end subroutine move_blocks

  !> Gravity, where a material has a weight.
  pure subroutine weigh_blocks(scene, system, state, effects)
    type(scene_t), intent(in) :: scene
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    type(effects_t), intent(inout) :: effects
    type(kinematics_t) :: element
    integer :: e

    associate (material => scene%block_material, used => system%elements%material)
      if (first_used(system, abs(material%unit_weight) > 0) == 0) return
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

  !> A ground that accelerates at some time.
  pure subroutine move_ground(record, effects)
    type(time_table_t), intent(in) :: record          !! acceleration of the ground, length/time^2
    type(effects_t), intent(inout) :: effects

    if (.not. allocated(record%time)) return
    if (.not. any(abs(record%value) > 0)) return
    allocate (effects%base_acceleration)
    effects%base_acceleration%record = record
  end subroutine move_ground

  !> Fixed points and rollers of what is there.
  subroutine hold_points(scene, system, state, roller, effects)
    type(scene_t), intent(in) :: scene
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    type(roller_t), intent(in) :: roller(:)           !! (n_points)
    type(effects_t), intent(inout) :: effects
    type(time_table_t), allocatable :: table(:)
    integer, allocatable :: of_kind(:), rollers(:), there(:)
    integer :: i

    of_kind = pack([(i, i=1, size(system%points%kind))], system%points%kind == fixed_point)
    there = pack([(i, i=1, size(of_kind))], are_there(system, of_kind))
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
      call by_element(system, [of_kind, rollers], table, held%first, held%point, held%table)
      if (size(rollers) > 0) held%direction = directions_of(roller(held%point))
      held%home = state%point(:, held%point)
      held%moves = any([(allocated(held%table(i)%time), i=1, size(held%table))])
    end associate
  end subroutine hold_points

  !> Load points of what is there that have a force at some time.
  subroutine load_points(scene, system, effects)
    type(scene_t), intent(in) :: scene
    type(system_t), intent(in) :: system
    type(effects_t), intent(inout) :: effects
    integer, allocatable :: acting(:), of_kind(:)
    integer :: i

    if (.not. allocated(scene%load_table)) return
    acting = pack([(i, i=1, size(scene%load_table))], [(has_force(scene%load_table(i)), i=1, size(scene%load_table))])
    of_kind = pack([(i, i=1, size(system%points%kind))], system%points%kind == load_point)
    acting = pack(acting, are_there(system, of_kind(acting)))
    if (size(acting) == 0) return
    allocate (effects%point_load)
    call by_element(system, of_kind(acting), scene%load_table(acting), effects%point_load%first, effects%point_load%point, &
                    effects%point_load%table)
  end subroutine load_points

  !> Contact, where there is more than one block, or a crack under a mesh, which may close, or where one may begin.
  pure subroutine let_touch(scene, blocks, system, state, effects)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    type(effects_t), intent(inout) :: effects

    associate (s => scene%settings, joint => scene%joint_material)
      if (s%contact == contact_none) return
      if (system%n_blocks == 1 .and. (size(blocks%crack_joint) == 0 .or. system%n_elements == 1) &
          .and. s%crack_begin_joint == 0) return
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
      if (allocated(effects%gravity)) effects%contact%settling = settling_of_scene(scene, system, state, effects%contact)
    end associate
  end subroutine let_touch

  !> Settlement of a column of rock as high as the scene under its own weight, length.
  !>
  !> It is the unit weight times the height squared over twice the modulus of a mass of blocks, 1/(1/E + 1/(s b)). Here s is the
  !> normal stiffness of a joint and b the mean size of a block. A joint without its own stiffness is two springs on a face.
  !>
  !> A weight that acts at once makes speeds of up to g H/c, because a point is free until the wave from the foot arrives, with
  !> the speed c = (E/rho)^1/2. A block with that speed rises by g H^2/(2 c^2), which is this settlement.
  pure real(dp) function settling_of_scene(scene, system, state, law) result(settling)
    type(scene_t), intent(in) :: scene
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
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
  pure subroutine let_sleep(scene, effects)
    type(scene_t), intent(in) :: scene
    type(effects_t), intent(inout) :: effects

    associate (s => scene%settings)
      if (s%sleep <= 0 .or. scene%is_static() .or. s%chooses_step .or. s%cracks_may_grow()) return
      if (.not. (allocated(effects%gravity) .and. allocated(effects%contact))) return
      if (looks_at_all(effects%contact)) return
      effects%sleep = s%sleep
    end associate
  end subroutine let_sleep

  !> First of the materials that something holds of and that a block is made of, 0 where there is none.
  pure integer function first_used(system, holds)
    type(system_t), intent(in) :: system
    logical, intent(in) :: holds(:) !! (n_materials)
    integer :: i

    first_used = findloc([(holds(i) .and. any(system%elements%material == i), i=1, size(holds))], .true., 1)
  end function first_used

  !> Which points are of blocks that no stage has removed.
  pure function are_there(system, point) result(there)
    type(system_t), intent(in) :: system
    integer, intent(in) :: point(:)
    logical :: there(size(point))

    there = system%present(system%elements%block(system%points%element(point)))
  end function are_there

  !> Whether a table has a force at some time.
  pure logical function has_force(table)
    type(time_table_t), intent(in) :: table

    has_force = allocated(table%time)
    if (has_force) has_force = any(abs(table%value) > 0)
  end function has_force

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

end module scree_make_effects
