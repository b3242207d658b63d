!> From a scene and its blocks to the model and its state at time 0.
module scree_set_up
  use scree_body_overlap, only: find_overlaps
  use scree_block_finder, only: block_at, block_finder_t, set_up_finder
  use scree_block_input, only: block_area, block_moments, block_size, block_source, blocks_t
  use scree_contact_rules, only: rests_inside
  use scree_contacts, only: outlines_t, overlap_t, shi_law_t
  use scree_cover_input, only: cover_blocks, cover_quality_t, cover_with_mesh, covered_t
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_interpolation, only: kinematics_of, kinematics_t, rigid_velocity
  use scree_kinds, only: dp
  use scree_outlines, only: make_outlines
  use scree_material, only: elasticity
  use scree_mathematical_mesh, only: regular_mesh, shortest_edge
  use scree_mesh, only: mesh_t
  use scree_model, only: effects_t, model_t
  use scree_scene, only: contact_none, effect_t, fixed_exact, mass_follows_area, model_dda, model_nmm, scene_t, &
                         scheme_energy_momentum, strain_green, time_table_t, transport_rates
  use scree_setting_table, only: from_of, given_at
  use scree_simplex_integration, only: moments_t
  use scree_state, only: state_t
  use scree_system, only: fixed_point, load_point, measured_point, system_t
  use scree_text, only: number_text, real_text
  implicit none
  private
  public :: set_up

  real(dp), parameter :: most_triangles = 5e7_dp !! more would not fit the memory
  real(dp), parameter :: allowed_penetration = 2e-4_dp  !! of the extent, where the stiffness of contacts adapts (Shi: g3 w0)
  !> Of the extent, where contacts follow Shi's rules: overlap that closes, and gap that opens (Shi: s0, 2e-4 w0; f0, 2e-7 w0).
  real(dp), parameter :: closing_share = 1e-4_dp, opening_share = 1e-7_dp
  real(dp), parameter :: shortest_return = 5e-8_dp !! of the extent: slip back at which sliding that lags ends (Shi: 1e-7 w0)
  !> Where contacts are found as Shi's programs do, of the extent: gap over the displacement ratio, and the least; overlap over
  !> that gap; and what is added to the square of an edge (Shi: d0 = 2.5 g2 w0, d9 = 0.3 d0, 3 g3 w0, 1e-9 w0).
  real(dp), parameter :: search_share = 1.25_dp, search_least = 6e-4_dp, search_inside = 0.3_dp, search_guard = 5e-10_dp
  real(dp), parameter :: least_block = 1e-9_dp   !! of the extent: size of a block that still has seven digits
  real(dp), parameter :: lost_area = 1e-3_dp     !! of a block, by the rounding of coordinates about the middle of the model
  real(dp), parameter :: beside = 1e-4_dp        !! of the extent: a point so far outside still belongs to an element

contains

  !> Makes model and first state, and the list of effects with the reason for each.
  !>
  !> Errors: a mathematical mesh that does not hold the blocks, a block that is lost in the size of the model, an outline that
  !> does not close.
  subroutine set_up(scene, blocks, model, state, list, error)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(model_t), intent(out) :: model
    type(state_t), intent(out) :: state
    type(effect_t), allocatable, intent(out) :: list(:)
    type(error_t), allocatable, intent(out) :: error
    type(cover_quality_t) :: quality
    logical :: cracked

    model%settings = scene%settings
    call make_system(scene, blocks, model%system_t, state, quality, error)
    if (allocated(error)) return
    model%start = state%vertex
    model%start_point = state%point
    cracked = .false.
    if (allocated(blocks%crack_joint)) cracked = size(blocks%crack_joint) > 0
    call make_effects(scene, model%system_t, state, quality, cracked, model%effects, list)
    if (.not. allocated(model%effects%contact)) return
    call make_outlines(model%elements%shape, state%vertex, model%elements%block, model%outlines, error)
    if (allocated(error)) then
      associate (o => model%outlines, i => findloc(model%outlines%next, 0, 1))
        call fail(error, status_bad_input, block_source(scene, blocks, o%block(i))//': expected an outline of block '// &
                  number_text(o%block(i))//' that closes, found it open at '// &
                  real_text(state%vertex(1, o%finish(i)) + model%origin(1))//' '// &
                  real_text(state%vertex(2, o%finish(i)) + model%origin(2)))
      end associate
      return
    end if
    allocate (state%contacts%contact(0))
    state%contacts%stiffness = [model%effects%contact%normal_stiffness, model%effects%contact%shear_stiffness]
    if (model%n_elements == model%n_blocks) then
      call find_overlaps(model%outlines, state%vertex, model%overlaps, state%contacts%inside)
    else
      call find_overlaps_under_mesh(blocks, model%overlaps, error)
      if (allocated(error)) return
      allocate (state%contacts%inside(2, 0))
    end if
    if (.not. rests_inside(model%effects%contact)) state%contacts%inside = reshape([integer ::], [2, 0])
    model%outlines%inside = state%contacts%inside
    if (scene%settings%chooses_step) model%effects%contact%leap = 1e30_dp ! its travel has a limit of its own
  end subroutine set_up

  !> Overlaps of blocks that a mathematical mesh has cut: its elements lie in one block each.
  subroutine find_overlaps_under_mesh(blocks, overlaps, error)
    type(blocks_t), intent(in) :: blocks
    type(overlap_t), allocatable, intent(out) :: overlaps(:)
    type(error_t), allocatable, intent(out) :: error
    type(outlines_t) :: outlines
    real(dp) :: vertex(2, size(blocks%vertex, 2))
    integer, allocatable :: inside(:, :)
    integer :: b

    vertex = blocks%vertex - spread(0.5_dp*(minval(blocks%vertex, 2) + maxval(blocks%vertex, 2)), 2, size(vertex, 2))
    call make_outlines(blocks%shape, vertex, [(b, b=1, size(blocks%material))], outlines, error)
    if (.not. allocated(error)) call find_overlaps(outlines, vertex, overlaps, inside)
  end subroutine find_overlaps_under_mesh

  !> Numbers of Shi's rules of contact: shares of the model, half of whose size he calls w0. The search has its own distances where
  !> the scene has a displacement ratio (g2).
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
      if (scene%carried > 0) then
        law%touching = law%closing
        if (law%search_gap > 0) law%touching = law%touching*2*law%search_gap/extent
      end if
      if (settings%adapts_stiffness) law%allowed_gap = scene%displacement_ratio*extent
      law%allowed_penetration = allowed_penetration*extent
    end associate
  end function shi_law_of

  !> Bodies and their state at rest, in coordinates about the middle of the scene.
  subroutine make_system(scene, blocks, system, state, quality, error)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(system_t), intent(out) :: system
    type(state_t), intent(out) :: state
    type(cover_quality_t), intent(out) :: quality
    type(error_t), allocatable, intent(out) :: error
    type(kinematics_t) :: element
    type(moments_t) :: moments
    real(dp) :: centroid(2, size(blocks%material)), middle(2)
    integer :: b, e

    system%model = scene%settings%model
    middle = 0.5_dp*(minval(blocks%vertex, 2) + maxval(blocks%vertex, 2))
    system%origin = blocks%origin + middle
    state%vertex = blocks%vertex - spread(middle, 2, size(blocks%vertex, 2))
    state%point = blocks%point - spread(middle, 2, size(blocks%point, 2))
    do b = 1, size(blocks%material)
      if (block_size(blocks, b) < least_block*scene%extent .or. abs(block_area(blocks, state%vertex, b) &
          - block_area(blocks, blocks%vertex, b)) > lost_area*block_area(blocks, blocks%vertex, b)) then
        call fail(error, status_bad_input, block_source(scene, blocks, b)//': expected blocks larger than '// &
                  real_text(least_block)//' of the model of '//real_text(scene%extent)//' and no thinner than its rounding, '// &
                  'found block '//number_text(b)//' of size '//real_text(block_size(blocks, b)))
        return
      end if
      moments = block_moments(blocks, b)
      centroid(:, b) = moments%centroid - middle
    end do
    if (allocated(scene%mesh) .or. scene%settings%cover_edge > 0) then
      call lay_mesh(scene, blocks, middle, system, state, quality, error)
      if (allocated(error)) return
    else
      call cover_blocks(system%model == model_dda, blocks%shape, state%vertex, blocks%material, system%elements, state%cover)
    end if
    system%n_blocks = size(blocks%material)
    system%n_elements = size(system%elements%block)
    system%n_covers = maxval(system%elements%cover)
    system%n_unknowns = maxval(system%elements%unknown)
    system%points%kind = blocks%point_kind
    system%points%element = elements_of_points(system, state, blocks%point_block)
    if (any(system%points%element == 0)) then
      call fail(error, status_bad_input, scene%geometry_name//': expected points in their blocks, found point '// &
                number_text(findloc(system%points%element, 0, 1))//' outside')
      return
    end if

    allocate (system%elements%mass(system%n_elements))
    allocate (state%stress(3, system%n_elements), state%deformation(4, system%n_elements))
    allocate (state%velocity(system%n_unknowns), state%acceleration(system%n_unknowns), source=0.0_dp)
    allocate (state%rotation(system%n_blocks), source=0.0_dp)
    allocate (state%pair(2, 0))
    do e = 1, system%n_elements
      element = kinematics_of(system, state, e)
      associate (material => scene%block_material(system%elements%material(e)))
        system%elements%mass(e) = material%density*element%area
        state%stress(:, e) = material%stress + (element%centroid(2) + system%origin(2))*material%stress_gradient
        state%deformation(:, e) = [1.0_dp, 0.0_dp, 0.0_dp, 1.0_dp]
        state%velocity(system%elements%unknown(:, e)) = rigid_velocity(system, state, e, &
          centroid(:, system%elements%block(e)), material%velocity)
      end associate
    end do
  end subroutine make_system

  !> Lays a mathematical mesh over the blocks, whose vertices the state holds; then it holds those of the elements.
  subroutine lay_mesh(scene, blocks, middle, system, state, quality, error)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    real(dp), intent(in) :: middle(2)  !! position of the blocks that coordinates of the system count from, length
    type(system_t), intent(inout) :: system
    type(state_t), intent(inout) :: state
    type(cover_quality_t), intent(out) :: quality
    type(error_t), allocatable, intent(out) :: error
    type(blocks_t) :: moved            !! the same about the middle of the scene
    type(covered_t) :: covered
    type(mesh_t) :: mesh
    character(len=:), allocatable :: from
    real(dp) :: low(2), high(2)
    integer :: i

    low = minval(state%vertex, 2)
    high = maxval(state%vertex, 2)
    associate (s => scene%settings)
      if (allocated(scene%mesh)) then
        from = from_of(scene%words, 'cover.mesh')
        mesh = scene%mesh
        mesh%node = mesh%node - spread(system%origin, 2, size(mesh%node, 2))
      else
        from = given_at(scene%words, 'cover.edge')
        if (s%cover_edge > maxval(high - low)) then
          call fail(error, status_bad_input, from//': expected an edge up to the size of the model, '// &
                    real_text(maxval(high - low))//', found '//real_text(s%cover_edge))
          return
        else if (product((high - low)/s%cover_edge + 1) > most_triangles) then
          call fail(error, status_bad_input, from//': expected an edge that makes at most 50 million triangles, found '// &
                    real_text(s%cover_edge))
          return
        end if
        call regular_mesh(s%cover_edge, s%cover_origin - system%origin, s%cover_angle*(acos(-1.0_dp)/180), low, high, mesh)
      end if
      moved = blocks
      moved%vertex = state%vertex
      do i = 1, 2
        moved%crack(:, i, :) = blocks%crack(:, i, :) - spread(middle, 2, size(blocks%crack, 3))
      end do
      call cover_with_mesh(moved, mesh, s%least_share, covered, error)
    end associate
    if (allocated(error)) return
    quality = covered%quality
    if (quality%uncovered > 0) then
      call fail(error, status_bad_input, from//': expected a mesh that holds every block, found one that leaves '// &
                number_text(quality%uncovered)//' parts of blocks out')
    else if (shortest_edge(mesh) > norm2(high - low)) then ! of a file
      call fail(error, status_bad_input, from//': expected a mesh with edges up to the diagonal of the model, '// &
                real_text(norm2(high - low))//', found none below '//real_text(shortest_edge(mesh)))
    end if
    if (allocated(error)) return
    system%elements = covered%elements
    call move_alloc(covered%vertex, state%vertex)
    call move_alloc(covered%cover, state%cover)
    call move_alloc(covered%extension, system%extension)
  end subroutine lay_mesh

  !> Elements that carry points: of the block of each the one that holds it.
  function elements_of_points(system, state, block) result(element)
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    integer, intent(in) :: block(:)     !! (n_points)
    integer :: element(size(block)), i
    type(block_finder_t) :: finder

    if (system%n_elements == system%n_blocks) then
      element = block
      return
    end if
    if (size(block) == 0) return
    call set_up_finder(finder, system%elements%shape, state%vertex, &
                       beside*maxval(maxval(state%vertex, 2) - minval(state%vertex, 2)))
    do i = 1, size(block)
      element(i) = block_at(finder, system%elements%shape, state%vertex, state%point(:, i), system%elements%block, block(i))
    end do
  end function elements_of_points

  !> The effects, decided once. Only materials that a block is made of count.
  subroutine make_effects(scene, system, state, quality, cracked, effects, list)
    type(scene_t), intent(in) :: scene
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    type(cover_quality_t), intent(in) :: quality
    logical, intent(in) :: cracked                    !! a joint ends inside a block
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
      if (allocated(scene%mesh) .or. settings%cover_edge > 0) &
        call name('mathematical mesh', '&cover: '//number_text(system%n_elements)//' elements, '// &
                  number_text(system%n_covers)//' covers; smallest element '//real_text(rounded(quality%least_share))// &
                  ' of its triangle, '//number_text(quality%small)//' below '//real_text(settings%least_share))
      if (allocated(system%extension)) &
        call name('extended covers', number_text(quality%extended)//' covers without an element of '// &
                  real_text(settings%least_share)//' of its triangle follow others, with weights up to '// &
                  real_text(rounded(quality%farthest)))
      effects%turns_exactly = settings%turns_exactly
      if (effects%turns_exactly) call name('rotation by cos and sin', "rotation='exact' in &method")
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
    call move_ground()
    if (scene%settings%mass_damping > 0) then
      call name('mass damping', 'mass='//real_text(scene%settings%mass_damping)//' in &damping')
      allocate (effects%mass_damping)
      effects%mass_damping%rate = scene%settings%mass_damping
    end if
    call hold_points()
    call load_points()
    call let_touch()
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

    !> A ground that accelerates at some time.
    subroutine move_ground()
      if (.not. allocated(scene%ground%time)) return
      if (.not. any(abs(scene%ground%value) > 0)) return
      call name('base acceleration', '&acceleration: '//number_text(size(scene%ground%time))//' times from '// &
                real_text(scene%ground%time(1))//' to '//real_text(scene%ground%time(size(scene%ground%time))))
      allocate (effects%base_acceleration)
      effects%base_acceleration%record = scene%ground
    end subroutine move_ground

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

    !> Contact, where there is more than one block, or a joint in one under a mesh that may close.
    subroutine let_touch()
      real(dp), parameter :: degree = acos(-1.0_dp)/180

      associate (s => scene%settings, joint => scene%joint_material)
        if (s%contact == contact_none) return
        if (system%n_blocks > 1) then
          call name('contact', number_text(system%n_blocks)//' blocks; springs of '//real_text(s%contact_stiffness)// &
                    ' force/length across')
        else if (cracked .and. system%n_elements > 1) then
          call name('contact', 'a joint inside a block; springs of '//real_text(s%contact_stiffness)//' force/length across')
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
        effects%contact%friction = [tan(joint%friction_angle*degree), (0.0_dp, e=1, 1)]
        effects%contact%cohesion = [joint%cohesion, (0.0_dp, e=1, 1)]
        effects%contact%strength = [joint%tensile_strength, (0.0_dp, e=1, 1)]
      end associate
    end subroutine let_touch

    !> Load points that have a force at some time.
    subroutine load_points()
      integer, allocatable :: acting(:), of_kind(:)
      integer :: i

      if (.not. allocated(scene%load_table)) return
      acting = pack([(i, i=1, size(scene%load_table))], [(has_force(scene%load_table(i)), i=1, size(scene%load_table))])
      if (size(acting) == 0) return
      of_kind = pack([(i, i=1, size(system%points%kind))], system%points%kind == load_point)
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

  !> Two digits of a number.
  pure real(dp) function rounded(x)
    real(dp), intent(in) :: x
    character(len=10) :: digits

    write (digits, '(es9.1e3)') x
    read (digits, *) rounded
  end function rounded

  !> A share as a percentage.
  pure function percent(share)
    real(dp), intent(in) :: share
    character(len=:), allocatable :: percent
    character(len=12) :: digits

    write (digits, '(f6.1)') 100*share
    percent = trim(adjustl(digits))//' %'
  end function percent

end module scree_set_up
