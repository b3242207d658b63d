!> From a scene and its blocks to the model and its state at time 0.
module scree_set_up
  use scree_absorbing_edge, only: absorbing_edge_t
  use scree_begin_contacts, only: begin_contacts
  use scree_begin_elements, only: begin_elements, middle_of
  use scree_block_finder, only: block_at, block_finder_t, set_up_finder
  use scree_block_input, only: block_area, block_size, block_source, blocks_t
  use scree_bolt, only: begin_bolts
  use scree_cover_input, only: cover_blocks, cover_quality_t, cover_with_mesh, covered_t
  use scree_edge_load, only: edge_load_t
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_fixed_bodies, only: leave_out_fixed
  use scree_kinds, only: dp, pi
  use scree_list_effects, only: list_effects
  use scree_loaded_edges, only: absorb_on_edges, load_carriers, load_edges
  use scree_make_effects, only: make_effects
  use scree_mathematical_mesh, only: regular_mesh, shortest_edge
  use scree_measured_tips, only: measure_tips
  use scree_mesh, only: mesh_t
  use scree_model, only: model_t
  use scree_rollers, only: hold_edges, roller_t
  use scree_scene, only: effect_t, model_dda, scene_t
  use scree_setting_table, only: given_at
  use scree_state, only: bolt_absent, state_t
  use scree_system, only: system_t
  use scree_text, only: number_text, place_text, real_text, short_text
  implicit none
  private
  public :: set_up

  real(dp), parameter :: most_triangles = 5e7_dp !! more would not fit the memory
  real(dp), parameter :: least_block = 1e-9_dp   !! of the extent: size of a block that still has seven digits
  real(dp), parameter :: lost_area = 1e-3_dp     !! of a block, by the rounding of coordinates about the middle of the model
  real(dp), parameter :: beside = 1e-4_dp        !! of the extent: a point so far outside still belongs to an element
  real(dp), parameter :: disc_edges = 2*(1 - 1e-9_dp) !! edges of the mesh in the half disc over which stress at a tip is averaged
  !> Times that a wave crosses the model in the pseudo step of a static step that failed. So long is enough for the elastic bodies
  !> to balance, and what bears no load moves by no more than forces let it in that time.
  real(dp), parameter :: crossings = 10.0_dp

contains

  !> Makes model and first state, and the list of effects with the reason for each; of a later stage, as if the run began with it.
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
    type(edge_load_t), allocatable :: load
    type(absorbing_edge_t), allocatable :: absorbing
    type(roller_t), allocatable :: roller(:) ! (n_points)

    model%settings = scene%settings
    call make_system(scene, blocks, model%system_t, state, quality, error)
    if (allocated(error)) return
    model%present = .not. scene%removed(blocks%drawn)
    call load_edges(scene, model%system_t, state, load, error)
    if (allocated(error)) return
    call hold_edges(scene, model%system_t, state, roller, error)
    if (allocated(error)) return
    call absorb_on_edges(scene, model%system_t, state, absorbing, error)
    if (allocated(error)) return
    call begin_elements(scene, blocks, model%system_t, state)
    if (allocated(load) .and. allocated(model%sampling)) call load_carriers(model%system_t, load)
    model%start = state%vertex
    model%start_point = state%point
    state%home = state%point
    state%static_force = 0*state%point
    call make_effects(scene, blocks, model%system_t, state, roller, model%effects)
    call list_effects(scene, blocks, model%system_t, state, quality, model%effects, list)
    call move_alloc(load, model%effects%edge_load)
    call move_alloc(absorbing, model%effects%absorbing_edge)
    if (allocated(model%effects%bolt)) then
      state%bolts = begin_bolts(model%effects%bolt, state%point, blocks%bolt%pretension)
      where (.not. has_bolts(scene, blocks, model)) state%bolts%state = bolt_absent
    end if
    if (allocated(model%sampling)) call check_second_order(scene, model, error)
    if (allocated(error)) return
    if (scene%settings%measures_tips .or. scene%settings%cracks_may_grow()) &
      call measure_tips(scene, blocks, model, state%cover, error)
    if (allocated(error)) return
    call leave_out_fixed(model, state)
    if (model%effects%is_static() .and. .not. (model%settings%balance > 0 .or. model%settings%chooses_step)) &
      model%pseudo_step = pseudo_step_of(scene, model)
    call check_sleep(scene, model, error)
    if (allocated(error) .or. .not. allocated(model%effects%contact)) return
    call begin_contacts(scene, blocks, model, state, error)
  end subroutine set_up

  !> The pseudo step by which a static step that failed is tried again with the same loads. It is `crossings` times the time of a
  !> compression wave through the model, in the slowest material that can move. It is huge where nothing that moves has mass.
  !>
  !> A static step begins at rest, so its size stands in M/(gamma dt^2) alone, beside the loads of its end. In a long step what has
  !> broken loose has next to no stiffness, and moves far. Inertia of a shorter one holds it, and lets go of it step by step, while
  !> loads go on as planned (pseudo-transient continuation: Kelley and Keyes, SIAM J. Numer. Anal. 35, 1998).
  pure real(dp) function pseudo_step_of(scene, model) result(pseudo)
    type(scene_t), intent(in) :: scene
    type(model_t), intent(in) :: model
    real(dp) :: slowness                    ! time/length
    integer :: k

    slowness = 0.0_dp
    do k = 1, size(model%elements%free)
      associate (m => model%elements%material(model%elements%free(k)))
        slowness = max(slowness, sqrt(scene%block_material(m)%density/model%effects%elasticity(1, 1, m)))
      end associate
    end do
    pseudo = huge(pseudo)
    if (slowness > 0) pseudo = crossings*model%extent*slowness
  end function pseudo_step_of

  !> Error if a deck lets blocks sleep and no block has weight, to which the criterion of sleep is relative.
  subroutine check_sleep(scene, model, error)
    type(scene_t), intent(in) :: scene
    type(model_t), intent(in) :: model
    type(error_t), allocatable, intent(out) :: error

    if (allocated(model%effects%gravity) .or. .not. model%settings%sleep > 0) return
    if (len(given_at(scene%words, 'step.sleep')) == 0) return
    call fail(error, status_bad_input, given_at(scene%words, 'step.sleep')//': expected blocks with weight with step.sleep, '// &
              'which is relative to it, found none')
  end subroutine check_sleep

  !> Error where a scene has what linear fields alone can do, and covers of second order.
  subroutine check_second_order(scene, model, error)
    type(scene_t), intent(in) :: scene
    type(model_t), intent(in) :: model
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: found

    found = ''
    if (allocated(model%effects%contact)) found = 'contact, which contact.method=none leaves out'
    if (allocated(model%effects%bolt)) found = 'bolts'
    if (allocated(scene%later)) then
      if (size(scene%later) > 0) found = 'stages'
    end if
    if (len(found) > 0) &
      call fail(error, status_bad_input, given_at(scene%words, 'cover.order')// &
                ': expected cover.order=1 without contact, bolts and stages, found '//found)
  end subroutine check_second_order

  !> Bolts of the run that a stage has, neither end of which is in a block that is gone.
  pure function has_bolts(scene, blocks, model)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(model_t), intent(in) :: model
    logical :: has_bolts(size(blocks%bolt_of))
    integer :: i, k

    has_bolts = scene%installed(blocks%bolt_of)
    do i = 1, size(has_bolts)
      do k = 1, 2
        associate (e => model%effects%bolt%element(k, i))
          if (e > 0) has_bolts(i) = has_bolts(i) .and. model%present(model%elements%block(e))
        end associate
      end do
    end do
  end function has_bolts

  !> Bodies and where they are, in coordinates about the middle of the scene.
  subroutine make_system(scene, blocks, system, state, quality, error)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(system_t), intent(out) :: system
    type(state_t), intent(out) :: state
    type(cover_quality_t), intent(out) :: quality
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: middle(2)
    integer :: b

    system%model = scene%settings%model
    middle = middle_of(blocks)
    system%origin = blocks%origin + middle
    system%extent = scene%extent
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
    system%points%kind = blocks%point_kind
    system%points%element = elements_of_points(system, state, blocks%point_block)
    do b = 1, size(blocks%bolt) ! what holds a grouted bolt at a joint takes its piece along
      if (all(blocks%joint_point(:, b) > 0)) &
        system%points%element(blocks%end_point(:, b)) = system%points%element(blocks%joint_point(:, b))
    end do
    if (any(system%points%element == 0)) then
      call fail(error, status_bad_input, scene%geometry_name//': expected points in their blocks, found point '// &
                number_text(findloc(system%points%element, 0, 1))//' outside')
      return
    end if
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
        from = given_at(scene%words, 'cover.mesh')
        mesh = scene%mesh
        mesh%node = mesh%node - spread(system%origin, 2, size(mesh%node, 2))
      else
        from = given_at(scene%words, 'cover.edge')
        if (s%cover_edge > maxval(high - low)) then
          call fail(error, status_bad_input, from//': expected an edge up to the size of the model, '// &
                    real_text(maxval(high - low))//', found '//real_text(s%cover_edge))
          return
        else if (product((high - low)/s%cover_edge + 1) > most_triangles) then
          call fail(error, status_bad_input, from//': expected an edge that makes at most '// &
                    number_text(nint(most_triangles/1e6_dp))//' million triangles, found '//real_text(s%cover_edge))
          return
        end if
        call regular_mesh(s%cover_edge, s%cover_origin - system%origin, s%cover_angle*(pi/180), low, high, mesh)
      end if
      moved = blocks
      moved%vertex = state%vertex
      if (allocated(blocks%seat)) moved%seat = blocks%seat - spread(middle, 2, size(blocks%seat, 2))
      do i = 1, 2
        moved%crack(:, i, :) = blocks%crack(:, i, :) - spread(middle, 2, size(blocks%crack, 3))
      end do
      call cover_with_mesh(moved, mesh, s%least_share, s%second_order, covered, error)
    end associate
    if (allocated(error)) return
    quality = covered%quality
    if (quality%uncovered > 0) then
      call fail(error, status_bad_input, from//': expected a mesh that holds every block, found one that leaves '// &
                number_text(quality%uncovered)//' parts of blocks out')
    else if (allocated(covered%torn)) then
      call fail(error, status_bad_input, from//': expected triangles of '''//scene%settings%cover_mesh//''' that fit '// &
                'together in a block, with one triangle on either side of each edge and both nodes in common, found others at '// &
                place_text(covered%torn + system%origin, system%extent, digits=6))
    else if (shortest_edge(mesh) > norm2(high - low)) then ! of a file
      call fail(error, status_bad_input, from//': expected a mesh with edges up to the diagonal of the model, '// &
                real_text(norm2(high - low))//', found none below '//real_text(shortest_edge(mesh)))
    end if
    if (allocated(error)) return
    call check_crack_length(scene, blocks, shortest_edge(mesh), error)
    if (allocated(error)) return
    system%elements = covered%elements
    call move_alloc(covered%vertex, state%vertex)
    call move_alloc(covered%cover, state%cover)
    call move_alloc(covered%extension, system%extension)
  end subroutine lay_mesh

  !> Error where the mean tension before a tip is over less than a mesh resolves, or over more than any block that it may break.
  subroutine check_crack_length(scene, blocks, edge, error)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    real(dp), intent(in) :: edge       !! of the mesh, length
    type(error_t), allocatable, intent(inout) :: error
    character(len=:), allocatable :: expected
    real(dp) :: largest
    integer :: b

    associate (s => scene%settings)
      if (.not. s%crack_length > 0) return
      largest = 0.0_dp
      do b = 1, size(blocks%material)
        if (s%crack_strength(blocks%material(b)) > 0) largest = max(largest, block_size(blocks, b))
      end do
      if (s%crack_length < disc_edges*edge) then
        expected = 'at least two edges of the mesh, '//short_text(disc_edges*edge)// &
                   ', as one stress of a triangle at a tip is no mean'
      else if (s%crack_length > largest .and. largest > 0 .and. blocks%n_grown == 0) then
        expected = 'at most the size of the largest block that may break, '//short_text(largest)
      else
        return
      end if
      call fail(error, status_bad_input, given_at(scene%words, 'cracks.length')//': expected cracks.length of '//expected// &
                ', found '//real_text(s%crack_length))
    end associate
  end subroutine check_crack_length

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

end module scree_set_up
