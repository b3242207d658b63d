!> Facts of a model that an engineer checks before it runs: weights, stiffness, sizes, supports.
!>
!> Facts are data: `model_warnings` judges them, `check_scene` prints them. A further one is a component of `facts_t`, a line there
!> and, where it may be a mistake, a warning.
module scree_model_facts
  use scree_block_input, only: block_moments, blocks_t
  use scree_constraints, only: constraints_t
  use scree_contact_geometry, only: frame_of_edge
  use scree_contacts, only: blocks_of, contact_t, parallel
  use scree_edge_load, only: load_on_piece
  use scree_effects, only: refresh_elements
  use scree_errors, only: error_t
  use scree_initial_contacts, only: free_lengths, initial_contacts, reached_from
  use scree_kinds, only: dp, pi
  use scree_meeting_joints, only: meeting_joints, meeting_joints_t
  use scree_model, only: cache_t, model_t
  use scree_own_weight, only: column_t, worst_column
  use scree_loaded_edges, only: gaps_of_lines
  use scree_regions, only: first_vertex_of, last_vertex_of, loops_of, region_count
  use scree_scene, only: model_dda, scene_t
  use scree_simplex_integration, only: moments_t
  use scree_state, only: state_t
  use scree_step_constraints, only: constraints_of_step
  use scree_stressed_joints, only: entrance_on_face, force_of_stress, shear_strength
  use scree_system, only: fixed_point, roller_end
  use scree_text, only: number_text, text_t
  use scree_time_table, only: ramp_at
  implicit none
  private
  public :: block_fact_t, facts_of, facts_t, hold_t, list_text, side_t

  !> The sides of a model, by the direction that a free edge faces most.
  integer, parameter, public :: n_sides = 4
  character(len=*), parameter, public :: side_name(n_sides) = [character(len=6) :: 'left', 'right', 'bottom', 'top']

  real(dp), parameter :: thin = 1e-2_dp        !! four times the area over the square of the outline: width over length of a strip
  real(dp), parameter :: noticeable = 1e-2_dp  !! of the largest stress: a traction that pushes a free edge
  real(dp), parameter :: rounding = 1e-12_dp   !! of the model: a length that is left of an edge which another covers
  real(dp), parameter :: beside = 0.01_dp      !! of the model: a fixed point that lies on a side
  real(dp), parameter :: on_line = 1e-9_dp     !! of the model: a point that lies on the line of an edge, to round-off
  integer, parameter :: holds_whole = 3        !! fixed points that leave a DDA block no strain

  !> A block: its number, area and position.
  type :: block_fact_t
    integer :: number = 0
    real(dp) :: area = 0.0_dp     !! length^2
    real(dp) :: position(2) = 0.0_dp !! of the centroid, length
  end type block_fact_t

  !> Free edges that face a side of the model, and what the initial stress pushes them with.
  type :: side_t
    real(dp) :: force = 0.0_dp    !! that neither loads nor supports bear, over all of them; per unit thickness
    integer :: block = 0          !! with the largest part of it
    real(dp) :: most = 0.0_dp     !! that part
  end type side_t

  !> A single point that holds a block.
  type :: hold_t
    integer :: block = 0
    integer :: line = 0           !! number of the fixed line that made the point; 0: none that is asked about
    logical :: crosses = .false.  !! that line crosses an edge of the block
    real(dp) :: position(2) = 0.0_dp !! length
  end type hold_t

  !> Contacts of joints that do not bear the shear of the stress before the run.
  type :: slip_t
    integer :: number = 0
    real(dp) :: borne = 1.0_dp    !! part of the shear that the weakest of them bears
    integer :: block = 0          !! of its vertex
    real(dp) :: position(2) = 0.0_dp !! length
  end type slip_t

  !> All facts.
  type :: facts_t
    integer :: n_blocks = 0, n_elements = 0
    integer :: n_unknowns = 0                   !! that are solved
    integer, allocatable :: block_material(:)   !! that blocks are made of
    integer, allocatable :: joint_material(:)   !! of edges that may touch
    type(meeting_joints_t), allocatable :: meeting(:) !! places where pieces of different joint materials meet
    logical :: has_weight = .false.
    type(block_fact_t) :: smallest, largest
    real(dp) :: shortest_edge = huge(1.0_dp)    !! length
    integer, allocatable :: sliver(:)           !! numbers of blocks that are thin, or sharper than contacts tell from a line
    integer, allocatable :: fixed_points(:)     !! (n_blocks) in each
    logical, allocatable :: held(:)             !! (n_blocks) by a fixed point, a bolt to the ground, or a support against a fall
    type(hold_t), allocatable :: hinge(:)       !! blocks that one fixed point alone holds, and that touch others or are static
    type(hold_t), allocatable :: short_line(:)  !! fixed lines with two ends that make one fixed point
    integer, allocatable :: idle_bolt(:)        !! numbers in the decks of bolts with both ends in one block
    type(text_t), allocatable :: gap(:)         !! lines that hold, load or absorb, along which edges are missing
    integer, allocatable :: unheld(:)           !! numbers of blocks that touch nothing that leads to one that is held
    type(column_t) :: column                    !! compressed most by own weight
    real(dp) :: face_stiffness = 0.0_dp         !! of the softest joint as wide as that block, or two contacts, force/length
    real(dp) :: modulus = 1.0_dp                !! of a mass of such blocks, over that of its rock
    real(dp) :: penetration = 0.0_dp            !! that such a joint takes to bear that column, length
    type(slip_t) :: slip
    type(side_t) :: side(n_sides)               !! in the order of their names
    real(dp) :: fall = 0.0_dp                   !! in a step, from rest, length
  end type facts_t

contains

  !> The facts of a model as it is set up.
  subroutine facts_of(scene, blocks, model, state, facts)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(facts_t), intent(out) :: facts
    type(contact_t), allocatable :: contact(:)
    integer, allocatable :: candidate(:, :)
    integer :: b, i

    facts%n_blocks = model%n_blocks
    facts%n_elements = model%n_elements
    facts%n_unknowns = solved_unknowns(model, state)
    facts%block_material = pack([(i, i=1, size(scene%block_material))], &
                                [(any(blocks%material == i), i=1, size(scene%block_material))])
    facts%joint_material = pack([(i, i=1, size(scene%joint_material))], &
                                [(any(model%elements%shape%joint == i), i=1, size(scene%joint_material))])
    allocate (facts%fixed_points(model%n_blocks), source=0)
    do i = 1, size(blocks%point_kind)
      if (blocks%point_kind(i) /= fixed_point) cycle
      facts%fixed_points(blocks%point_block(i)) = facts%fixed_points(blocks%point_block(i)) + 1
    end do
    facts%held = facts%fixed_points > 0 .or. are_supported(model)
    facts%short_line = short_lines(scene, blocks)
    facts%gap = gaps_of_lines(scene, model%system_t, state)
    allocate (facts%idle_bolt(0))
    do i = 1, size(blocks%bolt)
      if (blocks%bolt(i)%block(1) == blocks%bolt(i)%block(2)) facts%idle_bolt = [facts%idle_bolt, blocks%bolt_of(i)]
      associate (joins => blocks%bolt(i)%block)
        if (any(joins == 0)) facts%held(maxval(joins)) = .true.
      end associate
    end do
    call measure_blocks(blocks, facts)
    call initial_contacts(model, state, contact, candidate)
    facts%meeting = meeting_joints(model, state, contact)
    facts%hinge = hinges(scene, blocks, model, contact)
    facts%unheld = pack([(b, b=1, model%n_blocks)], .not. reached_from(model, contact, facts%held))
    associate (rock => scene%block_material(facts%block_material))
      facts%has_weight = any(abs(rock%unit_weight) > 0)
      if (all(rock%density > 0)) facts%fall = 0.5_dp*scene%settings%step_size**2*maxval(abs(rock%unit_weight)/rock%density)
    end associate
    facts%column = worst_column(blocks, scene%block_material, &
                                model%model == model_dda .and. facts%fixed_points >= holds_whole)
    if (allocated(model%outlines%stress)) facts%slip = slips_of_joints(model, state, contact)
    if (allocated(model%effects%contact)) call soften(scene, model, facts)
    call push_free_sides(scene, model, state, free_lengths(model, state, candidate), facts%side)
  end subroutine facts_of

  !> Contacts of joints that do not bear the shear of the stress before the run.
  pure type(slip_t) function slips_of_joints(model, state, contact) result(slip)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(contact_t), intent(in) :: contact(:)
    real(dp) :: borne, force(2)
    integer :: i, k

    associate (outlines => model%outlines, x => state%vertex)
      do i = 1, size(contact)
        k = entrance_on_face(outlines, x, contact(i))
        if (k == 0) cycle
        force = force_of_stress(outlines, x, contact(i), k)
        if (.not. force(1) > 0) cycle
        borne = shear_strength(outlines, x, model%effects%contact, contact(i), k, force(1))
        if (borne >= abs(force(2))) cycle
        slip%number = slip%number + 1
        borne = borne/abs(force(2))
        if (borne >= slip%borne) cycle
        associate (vertex => contact(i)%entrance(k)%vertex)
          slip = slip_t(slip%number, borne, outlines%block(vertex), x(:, outlines%start(vertex)) + model%origin)
        end associate
      end do
    end associate
  end function slips_of_joints

  !> Whether lines of &support hold each block against a fall: in a direction that is not level.
  pure function are_supported(model) result(supported)
    type(model_t), intent(in) :: model
    logical :: supported(model%n_blocks)
    integer :: i

    supported = .false.
    if (.not. any(model%points%kind == roller_end)) return
    associate (held => model%effects%fixed_point)
      do i = 1, size(held%point)
        if (abs(held%direction(2, i)) > parallel) &
          supported(model%elements%block(model%points%element(held%point(i)))) = .true.
      end do
    end associate
  end function are_supported

  !> Fixed lines with two ends that make one fixed point: lines that cross one edge of a block, or none.
  pure function short_lines(scene, blocks) result(short)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(hold_t), allocatable :: short(:)
    integer :: i, point

    allocate (short(0))
    point = 0
    do i = 1, size(blocks%points_of_line)
      point = point + blocks%points_of_line(i)
      associate (ends => scene%fixed_lines(i)%ends, place => blocks%point(:, max(1, point)) + blocks%origin)
        if (blocks%points_of_line(i) /= 1 .or. .not. norm2(ends(:, 2) - ends(:, 1)) > 0) cycle
        short = [short, hold_t(blocks%point_block(point), i, norm2(place - ends(:, 1)) > 0, place)]
      end associate
    end do
  end function short_lines

  !> Blocks that are held at one place alone, by fixed points: no support and no bolt to the ground holds them, too. A block that
  !> swings in a dynamic run and touches no other one is a pendulum, as it is asked for.
  pure function hinges(scene, blocks, model, contact) result(hinge)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(model_t), intent(in) :: model
    type(contact_t), intent(in) :: contact(:)
    type(hold_t), allocatable :: hinge(:)
    logical, dimension(model%n_blocks) :: is_hinge, touches
    integer :: first(model%n_blocks) ! fixed point of each block, 0: it has none
    integer :: b, i

    allocate (hinge(0))
    first = 0
    is_hinge = .true.
    do i = 1, size(model%points%kind)
      b = model%elements%block(model%points%element(i))
      if (model%points%kind(i) == roller_end) is_hinge(b) = .false.
      if (model%points%kind(i) /= fixed_point) cycle
      if (first(b) == 0) first(b) = i
      if (norm2(blocks%point(:, i) - blocks%point(:, first(b))) > 0) is_hinge(b) = .false.
    end do
    do i = 1, size(blocks%bolt)
      if (any(blocks%bolt(i)%block == 0)) is_hinge(maxval(blocks%bolt(i)%block)) = .false.
    end do
    touches = scene%is_static()
    do i = 1, size(contact)
      associate (block => blocks_of(model%outlines, contact(i)%entrance(contact(i)%active)))
        if (block(1) /= block(2)) touches(block) = .true.
      end associate
    end do
    do b = 1, model%n_blocks
      if (first(b) > 0 .and. is_hinge(b) .and. touches(b)) &
        hinge = [hinge, hold_t(block=b, position=blocks%point(:, first(b)) + blocks%origin)]
    end do
  end function hinges

  !> Unknowns that neither fixed points nor other unknowns determine.
  pure integer function solved_unknowns(model, state)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(cache_t) :: cache
    type(constraints_t) :: constraints
    type(error_t), allocatable :: error

    call refresh_elements(model, state, cache)
    call constraints_of_step(model, cache, state, state%time, constraints, error)
    solved_unknowns = count(constraints%row_of == 0)
  end function solved_unknowns

  !> How much softer joints make a mass of blocks, and how far they close under its weight.
  !>
  !> A block of width w and a joint of stiffness K = kn w, or two contacts a face, are springs in series: E_mass/E = K/(E + K). With
  !> the stiffness of contacts the ratio is the same for all widths. Under the stress s a joint with the largest closure c closes by
  !> s/(kn + s/c) (Bandis 1983). Contacts with multipliers do not deform, and overlap by the tolerance of these.
  pure subroutine soften(scene, model, facts)
    type(scene_t), intent(in) :: scene
    type(model_t), intent(in) :: model
    type(facts_t), intent(inout) :: facts
    real(dp) :: closure(size(facts%joint_material)), kn(size(facts%joint_material)), width, young
    logical :: hard

    width = sqrt(facts%largest%area)
    if (facts%column%width > 0) width = facts%column%width
    kn = 0.0_dp
    associate (law => model%effects%contact)
      if (allocated(scene%settings%joint_kn)) kn = scene%settings%joint_kn(facts%joint_material)
      closure = law%joint(facts%joint_material)%closure%most
      where (kn > 0 .and. closure > 0) kn = kn + facts%column%stress/closure
      hard = law%penetration < huge(law%penetration)
      facts%face_stiffness = minval(merge(kn*width, merge(huge(width), 2*law%normal_stiffness, hard), kn > 0))
      young = maxval(scene%block_material(facts%block_material)%young)
      facts%modulus = 1/(young/facts%face_stiffness + 1)
      facts%penetration = facts%column%stress*facts%column%width/facts%face_stiffness
      if (hard .and. facts%column%width > 0) facts%penetration = max(facts%penetration, law%penetration)
    end associate
  end subroutine soften

  !> Smallest and largest block, shortest edge, slivers.
  pure subroutine measure_blocks(blocks, facts)
    type(blocks_t), intent(in) :: blocks
    type(facts_t), intent(inout) :: facts
    type(moments_t) :: moments
    logical :: is_sliver(region_count(blocks%shape))
    integer, allocatable :: loop(:)
    integer :: b, before, first, k, l, next
    real(dp) :: outline, own, sharpest

    do b = 1, size(is_sliver)
      moments = block_moments(blocks, b)
      if (b == 1 .or. moments%area < facts%smallest%area) &
        facts%smallest = block_fact_t(b, moments%area, moments%centroid + blocks%origin)
      if (b == 1 .or. moments%area > facts%largest%area) &
        facts%largest = block_fact_t(b, moments%area, moments%centroid + blocks%origin)
      loop = loops_of(blocks%shape, b)
      first = first_vertex_of(blocks%shape, b) - 1
      outline = 0.0_dp
      sharpest = huge(sharpest)
      do l = 1, size(loop) - 1
        do k = loop(l), loop(l + 1) - 1
          next = merge(loop(l), k + 1, k + 1 == loop(l + 1))
          before = merge(loop(l + 1) - 1, k - 1, k == loop(l))
          associate (x => blocks%vertex(:, first + k), x_next => blocks%vertex(:, first + next), &
                     x_before => blocks%vertex(:, first + before))
            own = norm2(x_next - x)
            facts%shortest_edge = min(facts%shortest_edge, own)
            outline = outline + own
            sharpest = min(sharpest, angle_between(x_next - x, x_before - x))
          end associate
        end do
      end do
      is_sliver(b) = 4*moments%area < thin*outline**2 .or. sharpest < parallel
    end do
    facts%sliver = pack([(b, b=1, size(is_sliver))], is_sliver .and. facts%fixed_points < holds_whole)
  end subroutine measure_blocks

  !> Angle from one vector counter-clockwise to another, of a convex corner seen from inside; rad up to a whole turn.
  pure real(dp) function angle_between(a, b) result(angle)
    real(dp), intent(in) :: a(2), b(2)

    angle = modulo(atan2(a(1)*b(2) - a(2)*b(1), dot_product(a, b)), 2*pi)
  end function angle_between

  !> Force with which the initial stress pushes free edges, less loads and supports on them when the run begins.
  !>
  !> An element with a fixed point, or one that shares unknowns with it, bears its own stress. So does the straight side of a block
  !> with two fixed points on it, of whichever elements the side is made.
  pure subroutine push_free_sides(scene, model, state, free, side)
    type(scene_t), intent(in) :: scene
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(dp), intent(in) :: free(:)               !! (n_vertices) of the edge that begins at each vertex, length
    type(side_t), intent(out) :: side(n_sides)
    real(dp) :: along(2), force(2), largest, length, middle(2), normal(2), of_block(n_sides, model%n_blocks), stress(3)
    logical :: held(model%n_unknowns)
    integer :: e, faces, k, l, next

    largest = largest_stress(scene, model, state)
    if (.not. largest > 0) return
    held = .false.
    do k = 1, size(model%points%kind)
      if (model%points%kind(k) == fixed_point) held(model%elements%unknown(:, model%points%element(k))) = .true.
    end do
    of_block = 0.0_dp
    do e = 1, model%n_elements
      if (any(held(model%elements%unknown(:, e)))) cycle
      associate (shape => model%elements%shape, rock => scene%block_material(model%elements%material(e)))
        do l = shape%first_loop(e), shape%first_loop(e + 1) - 1
          do k = shape%first_vertex(l), shape%first_vertex(l + 1) - 1
            if (.not. free(k) > rounding*scene%extent) cycle
            next = merge(shape%first_vertex(l), k + 1, k + 1 == shape%first_vertex(l + 1))
            call frame_of_edge(state%vertex(:, k), state%vertex(:, next), along, normal, length)
            middle = 0.5_dp*(state%vertex(:, k) + state%vertex(:, next)) + model%origin
            stress = rock%stress + middle(2)*rock%stress_gradient
            force = free(k)*[stress(1)*normal(1) + stress(3)*normal(2), stress(3)*normal(1) + stress(2)*normal(2)]
            if (norm2(force) <= noticeable*largest*free(k) .or. holds_side(e, state%vertex(:, k), normal)) cycle
            force = force - load_on_edge(e, state%vertex(:, k), along, normal, length)
            force = beyond_supports(e, state%vertex(:, k), normal, force)
            if (norm2(force) <= noticeable*largest*free(k)) cycle
            faces = merge(merge(2, 1, normal(1) > 0), merge(4, 3, normal(2) > 0), abs(normal(1)) > abs(normal(2)))
            of_block(faces, model%elements%block(e)) = of_block(faces, model%elements%block(e)) + norm2(force)
          end do
        end do
      end associate
    end do
    do faces = 1, n_sides
      side(faces)%force = sum(of_block(faces, :))
      side(faces)%block = maxloc(of_block(faces, :), 1)
      side(faces)%most = maxval(of_block(faces, :))
    end do

  contains

    !> Whether two fixed points of the block of element e lie on the line of an edge.
    pure logical function holds_side(e, position, normal)
      integer, intent(in) :: e
      real(dp), intent(in) :: position(2), normal(2)  !! length, 1
      integer :: found, i

      found = 0
      do i = 1, size(model%points%kind)
        if (model%points%kind(i) /= fixed_point) cycle
        if (model%elements%block(model%points%element(i)) /= model%elements%block(e)) cycle
        if (abs(dot_product(normal, state%point(:, i) - position)) <= beside*scene%extent) found = found + 1
      end do
      holds_side = found > 1
    end function holds_side

    !> Loads that act on an edge of element e when the run begins, per unit thickness.
    pure function load_on_edge(e, position, along, normal, length) result(load)
      integer, intent(in) :: e
      real(dp), intent(in) :: position(2), along(2), normal(2), length !! where it begins, its frame
      real(dp) :: load(2), middle(2)
      integer :: i

      load = 0.0_dp
      if (.not. allocated(model%effects%edge_load)) return
      associate (loads => model%effects%edge_load)
        do i = loads%first(e), loads%first(e + 1) - 1
          middle = 0.5_dp*sum(state%point(:, loads%point(:, i)), 2) - position
          if (abs(dot_product(normal, middle)) > on_line*scene%extent .or. &
              abs(dot_product(along, middle) - 0.5_dp*length) > 0.5_dp*length) cycle
          load = load + ramp_at(loads%ramp, state%time)*load_on_piece(loads, i, state%point)
        end do
      end associate
    end function load_on_edge

    !> Part of a force on an edge of element e that the supports on its line do not carry.
    pure function beyond_supports(e, position, normal, force) result(left)
      integer, intent(in) :: e
      real(dp), intent(in) :: position(2), normal(2)  !! length, 1
      real(dp), intent(in) :: force(2)
      real(dp) :: left(2), first(2)
      integer :: i

      left = force
      if (.not. any(model%points%kind == roller_end)) return
      first = 0.0_dp
      associate (held => model%effects%fixed_point)
        do i = held%first(e), held%first(e + 1) - 1
          associate (direction => held%direction(:, i))
            if (.not. norm2(direction) > 0) cycle ! a fixed point
            if (abs(dot_product(normal, state%point(:, held%point(i)) - position)) > on_line*scene%extent) cycle
            if (abs(first(1)*direction(2) - first(2)*direction(1)) > parallel) left = 0.0_dp ! two directions hold all
            first = direction
            left = left - dot_product(direction, left)*direction
          end associate
        end do
      end associate
    end function beyond_supports

  end subroutine push_free_sides

  !> Largest component of the initial stress at a vertex, force/length^2.
  pure real(dp) function largest_stress(scene, model, state) result(largest)
    type(scene_t), intent(in) :: scene
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer :: e, k

    largest = 0.0_dp
    do e = 1, model%n_elements
      associate (rock => scene%block_material(model%elements%material(e)))
        do k = first_vertex_of(model%elements%shape, e), last_vertex_of(model%elements%shape, e)
          largest = max(largest, maxval(abs(rock%stress + (state%vertex(2, k) + model%origin(2))*rock%stress_gradient)))
        end do
      end associate
    end do
  end function largest_stress

  !> Blocks by number, the first of many; 'none'.
  pure function list_text(block)
    integer, intent(in) :: block(:)
    character(len=:), allocatable :: list_text
    integer, parameter :: most = 10
    integer :: i

    if (size(block) == 0) then
      list_text = 'none'
      return
    end if
    list_text = trim(merge('block ', 'blocks', size(block) == 1))
    do i = 1, min(size(block), most)
      list_text = list_text//' '//number_text(block(i))
    end do
    if (size(block) > most) list_text = number_text(size(block))//' '//list_text//' ...'
  end function list_text

end module scree_model_facts
