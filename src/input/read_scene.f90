!> Decks to a complete scene and its blocks.
module scree_read_scene
  use scree_analysis_deck, only: read_analysis_deck
  use scree_block_file, only: read_block_file
  use scree_block_input, only: blocks_t, make_blocks
  use scree_deck_files, only: beside_analysis, expect_file
  use scree_deck_groups, only: read_groups
  use scree_deck_options, only: check_all_taken, deck_options_t
  use scree_deck_text, only: deck_t, in_quotes, read_deck, word_is_whole
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_excavations, only: take_excavations
  use scree_geometry_deck, only: read_geometry_deck
  use scree_gmsh_file, only: read_gmsh_file
  use scree_groups_of_places, only: take_groups
  use scree_kinds, only: dp
  use scree_motions, only: take_motions
  use scree_scene, only: bolt_record_t, contact_none, scene_t, stage_t
  use scree_setting_rules, only: check_rules, drop_overridden
  use scree_setting_table, only: deck_part_t, from_of, given_at, index_of, is_given_by
  use scree_settings, only: fill_settings, set_word, store_settings
  use scree_stages, only: add_bolts_of_stage, begin_stage, check_names, end_of_stage_prefix, find_removed, named_lines, &
                          parts_to_stages
  use scree_system, only: fixed_point, load_point
  use scree_text, only: in_lower_case, number_text, real_of, text_t
  use scree_tip_seats, only: seat_tips
  implicit none
  private
  public :: read_geometry, read_scene

  !> An edge nearer to a line of a group than this fraction of the extent lies on the line, even where e0 is smaller. People type
  !> the coordinates of such lines with four digits.
  real(dp), parameter :: on_line = 1e-4_dp

contains

  !> Reads a scene from the names of its decks: STEM (STEM.ana, and STEM.geo where the deck names no geometry),
  !> ANALYSIS, or GEOMETRY ANALYSIS.
  !>
  !> Errors: `status_bad_input` with file, line, expected and found.
  subroutine read_scene(geometry, analysis, options, scene, blocks, error)
    character(len=*), intent(in) :: geometry     !! '': named by the analysis deck, or STEM.geo
    character(len=*), intent(in) :: analysis     !! deck or STEM
    type(text_t), intent(in) :: options(:)       !! GROUP.NAME=VALUE and THING.NAME=VALUE of the command line
    type(scene_t), intent(out) :: scene
    type(blocks_t), intent(out) :: blocks
    type(error_t), allocatable, intent(out) :: error
    type(deck_t) :: deck
    type(deck_part_t), allocatable :: parts(:)
    type(scene_t) :: read
    integer :: i, k

    scene%analysis_name = with_ending(analysis, '.ana')
    call read_deck(scene%analysis_name, deck, error)
    if (allocated(error)) return
    scene%analysis_text = deck%text
    scene%options = options
    call read_groups(deck, parts, error)
    if (allocated(error)) return
    do i = 1, size(options)
      call set_in_stage(options(i)%text, parts, deck%options, error)
      if (allocated(error)) return
    end do
    scene%words = parts(1)%words
    call drop_overridden(scene%words)
    call store_settings(scene)

    call name_geometry(geometry, scene, error)
    if (allocated(error)) return
    call read_geometry(scene, error, deck%options)
    if (allocated(error)) return
    parts(1)%words = scene%words
    call take_excavations(scene, parts, error)
    if (allocated(error)) return
    call parts_to_stages(parts)
    call check_names(parts, error)
    if (allocated(error)) return
    allocate (scene%later(size(parts) - 1))
    call take_places_of_stages(parts, scene, error)
    if (allocated(error)) return
    call make_blocks(scene, blocks, error)
    if (allocated(error)) return
    scene%extent = maxval(maxval(blocks%vertex, 2) - minval(blocks%vertex, 2))
    scene%nearest = max(blocks%nearest, on_line*scene%extent)
    allocate (scene%removed(size(blocks%material)), source=.false.)

    call read_analysis_deck(deck, count(blocks%point_kind == fixed_point), count(blocks%point_kind == load_point), scene, error)
    if (allocated(error)) return
    call check_all_taken(deck%options, error)
    if (allocated(error)) return
    read = scene
    call complete_stage(scene, blocks, error)
    if (allocated(error)) return
    call find_removed(scene, blocks, error)
    if (allocated(error)) return
    call check_numbers_count(deck%options, scene, error)
    if (allocated(error)) return
    call read_mesh(scene, error)
    do k = 2, size(parts)
      if (allocated(error)) return
      call begin_stage(parts(k)%words, read)
      call store_settings(read)
      if (is_given_by(read%words(index_of(read%words, 'stage.kind')))) &
        read%carried = merge(0.0_dp, merge(read%carried, 1.0_dp, read%carried > 0), read%settings%static)
      call find_removed(read, blocks, error)
      if (allocated(error)) return
      read%installed = scene%later(k - 1)%installed
      call complete_later(read, blocks, scene%later(k - 1), error)
    end do
    if (allocated(error)) return
    if (scene%settings%cracks_may_grow() .or. any([(scene%later(k)%settings%cracks_may_grow(), k=1, size(scene%later))])) &
      call seat_tips(scene, blocks)
  end subroutine read_scene

  !> Takes GROUP.NAME=VALUE of the command line for all stages, or stage(K).GROUP.NAME=VALUE for those from one on.
  !>
  !> Errors: as of `set_word`; a stage that does not exist; a setting of &stage.
  subroutine set_in_stage(option, parts, numbers, error)
    character(len=*), intent(in) :: option
    type(deck_part_t), intent(inout) :: parts(:)
    type(deck_options_t), intent(inout) :: numbers
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: which
    integer :: at, k

    k = 1
    at = end_of_stage_prefix(option)
    if (at > 0) then
      which = option(len('stage(') + 1:at - 2)
      k = 0
      if (word_is_whole(which)) k = nint(real_of(which))
      if (k < 1 .or. k > size(parts)) then
        call fail(error, status_bad_input, '--set '//option//': expected a stage from 1 to '//number_text(size(parts))// &
                  ', found '//in_quotes(which))
        return
      end if
    end if
    if (index(option(at + 1:), 'stage.') == 1) then
      call fail(error, status_bad_input, '--set '//option//': expected a setting of a stage, found what its &stage says')
    else
      call set_word(option(at + 1:), parts(k)%words, numbers, error)
    end if
  end subroutine set_in_stage

  !> Error where `--set` gives a number of the deck that a setting stands over: it would change nothing.
  subroutine check_numbers_count(numbers, scene, error)
    type(deck_options_t), intent(in) :: numbers
    type(scene_t), intent(in) :: scene
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: setting
    integer :: i

    if (.not. allocated(numbers%option)) return
    do i = 1, size(numbers%option)
      associate (number => numbers%option(i))
        setting = setting_over(number%thing, number%name, scene)
        if (given_at(scene%words, setting) == '') cycle
        call fail(error, status_bad_input, '--set '//number%text//': expected '//setting//', which '// &
                  given_at(scene%words, setting)//' gives over the numbers of the deck, found one of these')
        return
      end associate
    end do
  end subroutine check_numbers_count

  !> The setting that stands over a number of the analysis deck where it is given; '' where none may.
  pure function setting_over(thing, name, scene) result(setting)
    character(len=*), intent(in) :: thing    !! that has the number, joint(1)
    character(len=*), intent(in) :: name     !! of the number
    type(scene_t), intent(in) :: scene
    character(len=:), allocatable :: setting

    setting = ''
    select case (thing(:scan(thing//'(', '(') - 1)//'.'//name)
    case ('joint.phi', 'joint.friction_angle')
      setting = 'joints.phi'
    case ('joint.c', 'joint.cohesion')
      setting = 'joints.cohesion'
    case ('joint.t', 'joint.tensile_strength')
      setting = 'joints.tensile_strength'
    case ('material.e', 'material.young')
      setting = 'materials.young'
    case ('material.nu', 'material.poisson')
      setting = 'materials.poisson'
    case ('material.we', 'material.unit_weight')
      setting = 'materials.unit_weight'
    case ('deck.g1')
      setting = 'step.size'
    case ('deck.g0')
      setting = 'contact.stiffness'
    case ('deck.n5')
      setting = 'step.end_time'
      if (scene%settings%chooses_step .or. scene%settings%balance > 0) setting = 'step.count'
    end select
  end function setting_over

  !> Completes the scene of a later stage. Errors: as of `complete_stage`.
  subroutine complete_later(read, blocks, stage, error)
    type(scene_t), intent(in) :: read        !! without defaults
    type(blocks_t), intent(in) :: blocks
    type(stage_t), intent(out) :: stage
    type(error_t), allocatable, intent(out) :: error
    type(scene_t) :: own

    own = read
    call complete_stage(own, blocks, error)
    if (.not. allocated(error)) stage = own%stage_t
  end subroutine complete_later

  !> Fills in defaults and other consequences of the settings of a stage. Errors: settings that contradict each other or the
  !> geometry.
  subroutine complete_stage(scene, blocks, error)
    type(scene_t), intent(inout) :: scene
    type(blocks_t), intent(in) :: blocks
    type(error_t), allocatable, intent(out) :: error

    call fill_settings(scene, error)
    if (allocated(error)) return
    call check_rules(scene, error)
    if (allocated(error)) return
    call check_materials(scene, blocks, error)
    if (allocated(error)) return
    call take_materials(scene)
    call take_forces(scene, error)
    if (allocated(error)) return
    call take_boundary_loads(scene, error)
    if (allocated(error)) return
    call check_lines(scene, error)
    if (allocated(error)) return
    call check_tables(scene, error)
    if (allocated(error)) return
    call take_motions(scene, error)
  end subroutine complete_stage

  !> Takes what the cut of the lines needs to know of all stages: their bolts, and the lines that they name. Also tells which bolts
  !> each stage has. Errors: those of `add_bolts_of_stage`.
  subroutine take_places_of_stages(parts, scene, error)
    type(deck_part_t), intent(in) :: parts(:)
    type(scene_t), intent(inout) :: scene    !! with the bolts of the geometry
    type(error_t), allocatable, intent(out) :: error
    type(scene_t) :: own
    type(bolt_record_t), allocatable :: bolts(:)
    logical, allocatable :: before(:), installed(:)
    real(dp), allocatable :: more(:, :, :)
    integer :: k

    if (.not. allocated(scene%bolts)) allocate (scene%bolts(0))
    allocate (bolts(0))
    scene%named_lines = reshape([real(dp) ::], [2, 2, 0])
    own%bolts = scene%bolts
    do k = 1, size(parts)
      call begin_stage(parts(k)%words, own)
      call store_settings(own)
      more = named_lines(own%settings)
      scene%named_lines = reshape([scene%named_lines, more], [2, 2, size(scene%named_lines, 3) + size(more, 3)])
      before = [logical ::]
      if (k > 1) before = installed
      call add_bolts_of_stage(own, before, bolts, installed, error)
      if (allocated(error)) return
      if (k == 1) scene%installed = installed
      if (k > 1) scene%later(k - 1)%installed = installed
    end do
    call move_alloc(bolts, scene%bolts)
    call lengthen(scene%installed)
    do k = 1, size(scene%later)
      call lengthen(scene%later(k)%installed)
    end do

  contains

    !> Adds the bolts of later stages to a list that has none of them.
    subroutine lengthen(installed)
      logical, allocatable, intent(inout) :: installed(:)
      integer :: i

      installed = [installed, (.false., i=size(installed) + 1, size(scene%bolts))]
    end subroutine lengthen

  end subroutine take_places_of_stages

  !> Replaces numbers of materials of the deck by those of &materials and &joints.
  pure subroutine take_materials(scene)
    type(scene_t), intent(inout) :: scene

    associate (s => scene%settings)
      if (allocated(s%young)) scene%block_material%young = s%young
      if (allocated(s%poisson)) scene%block_material%poisson = s%poisson
      if (allocated(s%unit_weight)) scene%block_material%unit_weight = s%unit_weight
      if (allocated(s%joint_phi)) scene%joint_material%friction_angle = s%joint_phi
      if (allocated(s%joint_c)) scene%joint_material%cohesion = s%joint_c
      if (allocated(s%joint_t)) scene%joint_material%tensile_strength = s%joint_t
    end associate
  end subroutine take_materials

  !> Reads the mathematical mesh that &cover names.
  subroutine read_mesh(scene, error)
    type(scene_t), intent(inout) :: scene
    type(error_t), allocatable, intent(out) :: error

    if (.not. allocated(scene%settings%cover_mesh)) return
    call expect_file(scene, 'mesh', 'cover.mesh', scene%settings%cover_mesh, error)
    if (allocated(error)) return
    allocate (scene%mesh)
    call read_gmsh_file(beside_analysis(scene, scene%settings%cover_mesh), scene%mesh, error)
  end subroutine read_mesh

  !> The name itself where such a file is there or it has an ending, else with the ending.
  function with_ending(name, ending)
    character(len=*), intent(in) :: name, ending
    character(len=:), allocatable :: with_ending
    logical :: there

    with_ending = name
    if (index(name(index(name, '/', back=.true.) + 1:), '.', back=.true.) > 1) return
    inquire (file=name//ending, exist=there)
    if (there) with_ending = name//ending
  end function with_ending

  !> Finds the geometry: on the command line, named by the deck, or beside it with the same stem.
  subroutine name_geometry(geometry, scene, error)
    character(len=*), intent(in) :: geometry
    type(scene_t), intent(inout) :: scene
    type(error_t), allocatable, intent(out) :: error
    integer :: dot, slash
    logical :: there

    slash = index(scene%analysis_name, '/', back=.true.)
    if (len(geometry) > 0) then
      scene%geometry_name = geometry
    else if (allocated(scene%settings%geometry)) then
      scene%geometry_name = beside_analysis(scene, scene%settings%geometry)
      call expect_file(scene, 'geometry', 'deck.geometry', scene%settings%geometry, error)
    else
      dot = index(scene%analysis_name, '.', back=.true.)
      if (dot <= slash + 1) dot = len(scene%analysis_name) + 1
      scene%geometry_name = scene%analysis_name(:dot - 1)//'.geo'
      inquire (file=scene%geometry_name, exist=there)
      if (.not. there) call fail(error, status_bad_input, scene%analysis_name//':1: expected the name of a geometry '// &
                                 '(&deck geometry=''...'' / or a first argument) or '//scene%geometry_name//', found neither')
    end if
  end subroutine name_geometry

  !> Reads the geometry named in the scene, a block file where its name says so, and the groups of places that it ends in.
  !>
  !> Errors: `status_bad_input` with file, line, expected and found.
  subroutine read_geometry(scene, error, options)
    type(scene_t), intent(inout) :: scene
    type(error_t), allocatable, intent(out) :: error
    type(deck_options_t), intent(inout), optional :: options !! numbers of --set, over those of the deck
    type(deck_t) :: deck

    call read_deck(scene%geometry_name, deck, error)
    if (allocated(error)) return
    scene%geometry_text = deck%text
    if (present(options)) deck%options = options
    if (is_block_file(scene%geometry_name)) then
      call read_block_file(deck, scene, error)
    else
      call read_geometry_deck(deck, scene, error)
    end if
    if (present(options)) options = deck%options
    if (allocated(error)) return
    call take_groups(deck, scene%words, error)
    if (allocated(error)) return
    call drop_overridden(scene%words)
    call store_settings(scene)
    if (allocated(scene%bolts)) scene%bolts%ground_holds = scene%settings%ground_holds_bolts
    scene%named_lines = named_lines(scene%settings)
  end subroutine read_geometry

  !> Whether a name is that of a block file, in capitals or not.
  pure logical function is_block_file(name)
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: lower

    lower = in_lower_case(name)
    is_block_file = lower(max(1, len(lower) - 3):) == '.blk' .or. lower(max(1, len(lower) - 4):) == '.blck' .or. &
                    lower(index(lower, '/', back=.true.) + 1:) == 'block.in'
  end function is_block_file

  !> Error where the geometry uses a material that the analysis deck does not have.
  subroutine check_materials(scene, blocks, error)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(error_t), allocatable, intent(out) :: error
    integer :: i, line

    if (maxval(blocks%material) > size(scene%block_material)) then
      line = 1
      if (allocated(scene%blocks)) then
        line = scene%blocks%deck_line(maxloc(scene%blocks%material, 1))
      else
        do i = 1, size(scene%material_lines)
          if (scene%material_lines(i)%material > size(scene%block_material)) line = scene%material_lines(i)%deck_line
        end do
      end if
      call fail(error, status_bad_input, scene%geometry_name//':'//number_text(line)//': expected a block material up to '// &
                number_text(size(scene%block_material))//', found '//number_text(maxval(blocks%material)))
      return
    end if
    if (size(scene%joint_material) == 0 .and. .not. may_touch()) return
    if (allocated(scene%blocks)) then
      i = findloc(scene%blocks%joint > size(scene%joint_material), .true., 1)
      if (i > 0) call wrong(scene%blocks%joint_line(i), scene%blocks%joint(i))
    else
      i = findloc(scene%lines%material > size(scene%joint_material), .true., 1)
      if (i > 0) call wrong(scene%lines(i)%deck_line, scene%lines(i)%material)
    end if

  contains

    !> Whether anything in the scene may touch: blocks each other, or a block itself at a joint that ends in it.
    logical function may_touch()
      may_touch = scene%settings%contact /= contact_none .and. (size(blocks%material) > 1 .or. size(blocks%crack_joint) > 0)
    end function may_touch

    !> Error at a line of the geometry.
    subroutine wrong(line, joint)
      integer, intent(in) :: line, joint

      call fail(error, status_bad_input, scene%geometry_name//':'//number_text(line)//': expected a joint material up to '// &
                number_text(size(scene%joint_material))//', the number that the analysis deck has, found '//number_text(joint))
    end subroutine wrong

  end subroutine check_materials

  !> Constant forces of the load points from &loads.
  subroutine take_forces(scene, error)
    type(scene_t), intent(inout) :: scene
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: from
    integer :: i, n

    if (.not. allocated(scene%settings%load_force)) return
    from = from_of(scene%words, 'loads.force')
    associate (force => scene%settings%load_force)
      n = size(scene%load_table)
      if (size(force) /= 2*n) then
        call fail(error, status_bad_input, from//': expected '//number_text(2*n)// &
                  ' numbers for loads.force (two for each load point), found '//number_text(size(force)))
        return
      end if
      do i = 1, n
        if (allocated(scene%load_table(i)%time)) then
          call fail(error, status_bad_input, from//': expected loads.force only without tables of load points, found both')
          return
        end if
        scene%load_table(i)%time = [0.0_dp]
        scene%load_table(i)%value = reshape(force(2*i - 1:2*i), [2, 1])
      end do
    end associate
  end subroutine take_forces

  !> Loads on edges from &boundary. Errors: lists that do not go together, a line without length.
  subroutine take_boundary_loads(scene, error)
    type(scene_t), intent(inout) :: scene
    type(error_t), allocatable, intent(out) :: error
    integer :: i, n

    if (allocated(scene%boundary_loads)) deallocate (scene%boundary_loads)
    allocate (scene%boundary_loads(0))
    associate (s => scene%settings)
      if (.not. allocated(s%boundary_lines)) return
      n = size(s%boundary_lines)/4
      if (size(s%boundary_lines) /= 4*n) then
        call wrong('boundary.lines', 'four numbers x1 y1 x2 y2 for each line', number_text(size(s%boundary_lines)))
        return
      end if
      if (allocated(s%boundary_pressure)) then
        if (size(s%boundary_pressure) /= 2*n) &
          call wrong('boundary.pressure', number_text(2*n)//' numbers, p1 p2 for each line', number_text(size(s%boundary_pressure)))
      end if
      if (allocated(s%boundary_traction) .and. .not. allocated(error)) then
        if (size(s%boundary_traction) /= 4*n) call wrong('boundary.traction', number_text(4*n)// &
          ' numbers, tx1 ty1 tx2 ty2 for each line', number_text(size(s%boundary_traction)))
      end if
      if (allocated(error)) return
      deallocate (scene%boundary_loads)
      allocate (scene%boundary_loads(n))
      do i = 1, n
        associate (load => scene%boundary_loads(i))
          load%ends = reshape(s%boundary_lines(4*i - 3:4*i), [2, 2])
          if (.not. norm2(load%ends(:, 2) - load%ends(:, 1)) > 0) then
            call wrong('boundary.lines', 'two ends of line '//number_text(i), 'one place')
            return
          end if
          if (allocated(s%boundary_pressure)) load%pressure = s%boundary_pressure(2*i - 1:2*i)
          if (allocated(s%boundary_traction)) load%traction = reshape(s%boundary_traction(4*i - 3:4*i), [2, 2])
        end associate
      end do
    end associate

  contains

    !> Error at the place that a list came from.
    subroutine wrong(name, expected, found)
      character(len=*), intent(in) :: name, expected, found

      call fail(error, status_bad_input, given_at(scene%words, name)//': expected '//name//' with '//expected//', found '//found)
    end subroutine wrong

  end subroutine take_boundary_loads

  !> Error where the lines or the points of &support or &absorbing are none.
  subroutine check_lines(scene, error)
    type(scene_t), intent(in) :: scene
    type(error_t), allocatable, intent(out) :: error

    associate (s => scene%settings)
      call check('support.normal', s%support_normal)
      call check('support.x', s%support_x)
      call check('support.y', s%support_y)
      call check('support.both', s%support_both)
      call check('support.moved', s%support_moved)
      call check('absorbing.lines', s%absorbing_lines)
      call check('absorbing.base', s%absorbing_base)
      call check('absorbing.sides', s%absorbing_sides)
      call check_points('support.points', s%support_points)
      call check_points('support.points_x', s%support_points_x)
      call check_points('support.points_y', s%support_points_y)
    end associate

  contains

    !> Error where numbers are no lines.
    subroutine check(name, lines)
      character(len=*), intent(in) :: name
      real(dp), allocatable, intent(in) :: lines(:)
      integer :: i

      if (.not. allocated(lines) .or. allocated(error)) return
      if (modulo(size(lines), 4) /= 0) then
        call fail(error, status_bad_input, given_at(scene%words, name)//': expected four numbers x1 y1 x2 y2 for each line in '// &
                  name//', found '//number_text(size(lines)))
        return
      end if
      do i = 1, size(lines), 4
        if (norm2(lines(i + 2:i + 3) - lines(i:i + 1)) > 0) cycle
        call fail(error, status_bad_input, given_at(scene%words, name)//': expected two ends of line '//number_text(1 + i/4)// &
                  ' in '//name//', found one place')
        return
      end do
    end subroutine check

    !> Error where numbers are no points.
    subroutine check_points(name, points)
      character(len=*), intent(in) :: name
      real(dp), allocatable, intent(in) :: points(:)

      if (.not. allocated(points) .or. allocated(error)) return
      if (modulo(size(points), 2) /= 0) &
        call fail(error, status_bad_input, given_at(scene%words, name)//': expected two numbers x y for each point in '//name// &
                  ', found '//number_text(size(points)))
    end subroutine check_points

  end subroutine check_lines

  !> Error where the water table, or the ground surface of &in_situ, is none.
  subroutine check_tables(scene, error)
    type(scene_t), intent(in) :: scene
    type(error_t), allocatable, intent(out) :: error

    call check('water.table', scene%settings%water_table)
    if (.not. allocated(error)) call check('in_situ.surface', scene%settings%in_situ_surface)

  contains

    !> Error where numbers are no points one right of the other.
    subroutine check(name, table)
      character(len=*), intent(in) :: name
      real(dp), allocatable, intent(in) :: table(:)
      integer :: n

      if (.not. allocated(table)) return
      n = size(table)
      if (modulo(n, 2) /= 0) then
        call fail(error, status_bad_input, given_at(scene%words, name)//': expected two numbers x y for each point of '//name// &
                  ', found '//number_text(n))
      else if (.not. all(table(3::2) > table(1:n - 2:2))) then
        call fail(error, status_bad_input, given_at(scene%words, name)//': expected points of '//name// &
                  ' with x ascending, found others')
      end if
    end subroutine check

  end subroutine check_tables

end module scree_read_scene
