!> The deck of joint sets: named groups for a window, openings in it, joint sets and points. doc/joint-sets.md has them.
module scree_joints_deck
  use scree_deck_text, only: count_numbers, deck_t, in_quotes, read_deck
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_joint_sets, only: bounds_of, expected_traces, joint_set_t
  use scree_kinds, only: dp, pi
  use scree_named_groups, only: given_word, group_begins, group_ends, groups_end, groups_t, name_has_value, next_known_item, &
                                refuse_second, start_groups
  use scree_rock_outline, only: close_slope, crosses_itself, has_rock_at, make_rock, meets_rock, outline_t, &
                                reaches_into_window, rock_t, slope_outline, tunnel_outline, window_outline
  use scree_scene, only: line_t, point_t, scene_t, word_t
  use scree_setting_rows, only: fill_defaults, list_rows, setting_rows_t, store_given
  use scree_setting_table, only: blank_words, from_of, full_name, index_of, put_word, setting_t
  use scree_settings, only: settings_table
  use scree_text, only: number_text, real_text, text_t
  implicit none
  private
  public :: joints_t, read_joints_deck

  !> Contents of a deck.
  type :: joints_t
    type(rock_t) :: rock
    type(line_t), allocatable :: supports(:)   !! lines that hold edges
    type(joint_set_t), allocatable :: sets(:)
    integer :: seed = 1
    type(text_t), allocatable :: warning(:)    !! what of the outlines is likely a mistake
  end type joints_t

  !> Largest coordinate; with this least window, products of lengths stay in range.
  real(dp), parameter :: farthest = 1e12_dp, least_window = 1e-9_dp
  real(dp), parameter :: least_share = 1e-5_dp     !! of a window in its distance from the origin, for its digits
  real(dp), parameter :: rounding = 1e-9_dp        !! of a window: a point so near its side lies on it
  real(dp), parameter :: most_traces = 1e6_dp      !! of a set
  integer, parameter :: most_corners = 2000        !! of an outline
  real(dp), parameter :: default_least_distance = 0.001_dp !! e0

  !> A group of the deck. A component belongs to the names of one group or of several.
  type :: deck_group_t
    character(len=:), allocatable :: name
    integer :: deck_line = 0
    type(word_t), allocatable :: words(:)              !! of its names, in the order of the table
    real(dp), allocatable :: x(:), y(:)                !! of corners or points, length
    real(dp), allocatable :: centre(:)                 !! of a round tunnel, length
    real(dp) :: radius = 0.0_dp                        !! of its corners, length
    integer :: sides = 24
    integer :: material = 1                            !! joint material of an outline
    type(joint_set_t) :: set
    integer :: seed = 1
    real(dp) :: least_distance = default_least_distance !! e0 of the geometry deck
    real(dp) :: least_area = 0.0_dp                    !! of its blocks, length^2
    integer :: hold = 1                                !! of a support: a name of holds
  end type deck_group_t

  character(len=*), parameter :: holds(*) = [character(len=6) :: 'normal', 'x', 'y', 'both'] !! names of &support in an analysis

contains

  !> Reads a deck of joint sets: the sets to draw, and a scene with its e0 and its points, still without lines.
  !>
  !> Errors: an unknown group or name, a name that is missing, a value of the wrong kind or range, outlines that cross
  !> themselves or leave no rock, points outside it; all with their line.
  subroutine read_joints_deck(name, joints, scene, error)
    character(len=*), intent(in) :: name
    type(joints_t), intent(out) :: joints
    type(scene_t), intent(out) :: scene
    type(error_t), allocatable, intent(out) :: error
    type(deck_t) :: deck
    type(outline_t), allocatable :: outline(:)
    type(outline_t) :: window

    allocate (joints%sets(0), joints%supports(0), scene%material_lines(0), scene%fixed_lines(0), scene%bolts(0), &
              scene%load_points(0), scene%measured_points(0), scene%hole_points(0), outline(0))
    scene%words = blank_words(settings_table())
    call read_deck(name, deck, error)
    if (allocated(error)) return
    if (count_numbers(deck) > 0) then
      call wrong(deck, deck%line(1), "'&' and the name of a group", in_quotes(deck%text(deck%first(1):deck%last(1))), error)
      return
    end if
    scene%least_distance = default_least_distance
    call read_groups(deck, joints, scene, window, outline, error)
    if (allocated(error)) return
    if (.not. allocated(window%corner)) then
      call wrong(deck, deck%n_lines, 'a &window', 'none', error)
      return
    end if
    joints%warning = doubts_of_slopes(deck, window%corner, outline)
    call check_outlines(deck, window, outline, joints%rock, error)
    if (allocated(error)) return
    call check_sets(deck, joints, error)
    if (allocated(error)) return
    call check_points(deck, joints, scene, error)
  end subroutine read_joints_deck

  !> Reads the groups of a deck and takes each.
  subroutine read_groups(deck, joints, scene, window, outline, error)
    type(deck_t), intent(in) :: deck
    type(joints_t), intent(inout) :: joints
    type(scene_t), intent(inout) :: scene
    type(outline_t), intent(inout) :: window
    type(outline_t), allocatable, intent(inout) :: outline(:)
    type(error_t), allocatable, intent(out) :: error
    type(setting_t), allocatable :: table(:)
    type(groups_t) :: groups
    type(deck_group_t) :: group
    type(word_t) :: given

    table = joints_table()
    call start_groups(deck, groups)
    do
      call next_known_item(deck, table, groups, error)
      if (allocated(error)) return
      select case (groups%item)
      case (groups_end)
        return
      case (group_begins)
        if (any(groups%group == [character(len=6) :: 'window', 'seed', 'deck'])) &
          call refuse_second(deck, groups, '&'//groups%group//' once', 'a second', error)
        call begin_group(groups, table, group)
      case (name_has_value)
        given = given_word(deck, groups)
        call put_word(table, given%from//': ', given, group%words, error)
      case (group_ends)
        call complete_group(deck, table, group, error)
        if (.not. allocated(error)) call take_group(deck, group, joints, scene, window, outline, error)
      end select
      if (allocated(error)) return
    end do
  end subroutine read_groups

  !> Each name of each group once.
  subroutine visit_names(row, group)
    type(setting_rows_t), intent(inout) :: row
    type(deck_group_t), intent(inout) :: group

    call row%reals(setting_t('window', 'x', 'of its corners; two are a rectangle', 'length', -farthest, farthest, needed=.true.), &
                   group%x)
    call row%reals(setting_t('window', 'y', '', 'length', -farthest, farthest, needed=.true.), group%y)
    call row%whole(setting_t('window', 'material', 'joint material of its sides', '1', 1.0_dp, 1e9_dp), group%material, 1)
    call row%reals(setting_t('tunnel', 'x', 'of its corners, either way round', 'length', -farthest, farthest), group%x)
    call row%reals(setting_t('tunnel', 'y', '', 'length', -farthest, farthest), group%y)
    call row%reals(setting_t('tunnel', 'centre', 'x y; of a round tunnel', 'length', -farthest, farthest), group%centre)
    call row%real(setting_t('tunnel', 'radius', 'of its corners', 'length', 0.0_dp, farthest, .true.), group%radius)
    call row%whole(setting_t('tunnel', 'sides', 'of a round tunnel', '1', 3.0_dp, real(most_corners, dp)), group%sides, 24)
    call row%whole(setting_t('tunnel', 'material', 'joint material of its sides', '1', 1.0_dp, 1e9_dp), group%material, 1)
    call row%reals(setting_t('slope', 'x', 'of its points', 'length', -farthest, farthest, needed=.true.), group%x)
    call row%reals(setting_t('slope', 'y', '', 'length', -farthest, farthest, needed=.true.), group%y)
    call row%whole(setting_t('slope', 'material', 'joint material of its lines', '1', 1.0_dp, 1e9_dp), group%material, 1)
    call row%real(setting_t('joint_set', 'dip', 'from the x axis, counter-clockwise', 'degree', -360.0_dp, 360.0_dp, &
                            needed=.true.), group%set%dip)
    call row%real(setting_t('joint_set', 'spacing', 'of neighbouring lines', 'length', 0.0_dp, farthest, .true., needed=.true.), &
                  group%set%spacing)
    call row%real(setting_t('joint_set', 'length', 'of a trace', 'length', 0.0_dp, farthest, .true., needed=.true.), &
                  group%set%length)
    call row%real(setting_t('joint_set', 'bridge', 'of rock between traces', 'length', 0.0_dp, farthest), group%set%bridge, 0.0_dp)
    call row%real(setting_t('joint_set', 'randomness', 'of spacing, length and bridge', '1', 0.0_dp, 1.0_dp), &
                  group%set%randomness, 0.0_dp)
    call row%whole(setting_t('joint_set', 'material', 'joint material', '1', 1.0_dp, 1e9_dp), group%set%material, 1)
    call row%whole(setting_t('seed', 'value', 'of the random numbers', '1', 0.0_dp, 1e9_dp), group%seed, 1)
    call row%real(setting_t('deck', 'e0', 'of the geometry deck', '1', 1e-6_dp, 0.1_dp), group%least_distance, &
                  default_least_distance)
    call row%real(setting_t('deck', 'least_area', 'of a block: a smaller one joins its neighbour', 'length^2', 0.0_dp), &
                  group%least_area, 0.0_dp)
    call row%reals(setting_t('fixed_line', 'x', 'of points of a fixed line', 'length', -farthest, farthest, needed=.true.), group%x)
    call row%reals(setting_t('fixed_line', 'y', '', 'length', -farthest, farthest, needed=.true.), group%y)
    call row%reals(setting_t('support', 'x', 'of points of a line whose edges are held', 'length', -farthest, farthest, &
                             needed=.true.), group%x)
    call row%reals(setting_t('support', 'y', '', 'length', -farthest, farthest, needed=.true.), group%y)
    call row%choice(setting_t('support', 'hold', 'what it holds', choices='|normal|x|y|both|'), group%hold, 1)
    call row%reals(setting_t('fixed', 'x', 'of fixed points', 'length', -farthest, farthest, needed=.true.), group%x)
    call row%reals(setting_t('fixed', 'y', '', 'length', -farthest, farthest, needed=.true.), group%y)
    call row%reals(setting_t('load', 'x', 'of load points', 'length', -farthest, farthest, needed=.true.), group%x)
    call row%reals(setting_t('load', 'y', '', 'length', -farthest, farthest, needed=.true.), group%y)
    call row%reals(setting_t('measured', 'x', 'of measured points', 'length', -farthest, farthest, needed=.true.), group%x)
    call row%reals(setting_t('measured', 'y', '', 'length', -farthest, farthest, needed=.true.), group%y)
  end subroutine visit_names

  !> Table of all names of a deck of joint sets.
  function joints_table() result(table)
    type(setting_t), allocatable :: table(:)
    type(setting_rows_t) :: row
    type(deck_group_t) :: nothing

    row%purpose = list_rows
    call visit_names(row, nothing)
    call move_alloc(row%table, table)
  end function joints_table

  !> A group without values.
  subroutine begin_group(groups, table, group)
    type(groups_t), intent(in) :: groups
    type(setting_t), intent(in) :: table(:)
    type(deck_group_t), intent(out) :: group

    group%name = groups%group
    group%deck_line = groups%line
    group%words = blank_words(table, groups%group)
  end subroutine begin_group

  !> Puts the values of a group, given or by default, where they belong. Errors: a name that it lacks.
  subroutine complete_group(deck, table, group, error)
    type(deck_t), intent(in) :: deck
    type(setting_t), intent(in) :: table(:)
    type(deck_group_t), intent(inout) :: group
    type(error_t), allocatable, intent(out) :: error
    type(setting_rows_t) :: row
    integer :: i

    do i = 1, size(table)
      if (.not. table(i)%needed .or. table(i)%group /= group%name) cycle
      if (len(from_of(group%words, full_name(table(i)))) > 0) cycle
      call wrong(deck, group%deck_line, trim(table(i)%name)//' in &'//group%name, 'none', error)
      return
    end do
    row%words = group%words
    row%purpose = store_given
    call visit_names(row, group)
    row%purpose = fill_defaults
    call visit_names(row, group)
  end subroutine complete_group

  !> Takes a group that is complete. Errors: names that do not go together.
  subroutine take_group(deck, group, joints, scene, window, outline, error)
    type(deck_t), intent(in) :: deck
    type(deck_group_t), intent(in) :: group
    type(joints_t), intent(inout) :: joints
    type(scene_t), intent(inout) :: scene
    type(outline_t), intent(inout) :: window
    type(outline_t), allocatable, intent(inout) :: outline(:)
    type(error_t), allocatable, intent(out) :: error
    type(outline_t) :: this

    select case (group%name)
    case ('seed')
      joints%seed = group%seed
    case ('deck')
      scene%least_distance = group%least_distance
      scene%settings%least_block_area = group%least_area
      if (group%least_area > 0) call add_to_word(scene, 'blocks.least_area', real_text(group%least_area))
    case ('fixed_line', 'support')
      call take_lines(group, joints, scene, error)
    case ('joint_set')
      joints%sets = [joints%sets, group%set]
      joints%sets(size(joints%sets))%deck_line = group%deck_line
    case ('window')
      call take_window(group, window, error)
    case ('tunnel')
      call take_tunnel(deck, group, this, error)
      outline = [outline, this]
    case ('slope')
      this%kind = slope_outline
      this%deck_line = group%deck_line
      this%material = group%material
      call take_places(group, 2, this%corner, error)
      outline = [outline, this]
    case default
      call take_points(group, scene, error)
    end select
  end subroutine take_group

  !> The window. Two corners are a rectangle.
  subroutine take_window(group, window, error)
    type(deck_group_t), intent(in) :: group
    type(outline_t), intent(inout) :: window
    type(error_t), allocatable, intent(out) :: error

    window%deck_line = group%deck_line
    window%material = group%material
    call take_places(group, 2, window%corner, error)
    if (allocated(error)) return
    associate (x => group%x, y => group%y)
      if (size(window%corner, 2) == 2) window%corner = reshape([x(1), y(1), x(2), y(1), x(2), y(2), x(1), y(2)], [2, 4])
    end associate
  end subroutine take_window

  !> A tunnel, by its corners or round.
  subroutine take_tunnel(deck, group, tunnel, error)
    type(deck_t), intent(in) :: deck
    type(deck_group_t), intent(in) :: group
    type(outline_t), intent(inout) :: tunnel
    type(error_t), allocatable, intent(out) :: error
    logical :: round

    tunnel%kind = tunnel_outline
    tunnel%deck_line = group%deck_line
    tunnel%material = group%material
    round = allocated(group%centre) .or. group%radius > 0 .or. len(from_of(group%words, 'tunnel.sides')) > 0
    if (round) then
      call take_circle(deck, group, tunnel%corner, error)
    else if (allocated(group%x) .and. allocated(group%y)) then
      call take_places(group, 3, tunnel%corner, error)
    else
      call wrong(deck, group%deck_line, 'x and y, or centre and radius, in &tunnel', 'neither', error)
    end if
  end subroutine take_tunnel

  !> Lines from point to point: fixed lines, or lines of a support.
  subroutine take_lines(group, joints, scene, error)
    type(deck_group_t), intent(in) :: group
    type(joints_t), intent(inout) :: joints
    type(scene_t), intent(inout) :: scene
    type(error_t), allocatable, intent(out) :: error
    type(line_t) :: line
    real(dp), allocatable :: place(:, :)
    integer :: i, k

    call take_places(group, 2, place, error)
    if (allocated(error)) return
    line%deck_line = group%deck_line
    do i = 1, size(place, 2) - 1
      line%ends = place(:, i:i + 1)
      if (group%name == 'support') then
        joints%supports = [joints%supports, line]
        do k = i, i + 1
          call add_to_word(scene, 'support.'//trim(holds(group%hold)), real_text(place(1, k))//' '//real_text(place(2, k)))
        end do
      else
        scene%fixed_lines = [scene%fixed_lines, line]
      end if
    end do
  end subroutine take_lines

  !> Adds numbers to a setting that the geometry is to end with.
  subroutine add_to_word(scene, name, numbers)
    type(scene_t), intent(inout) :: scene
    character(len=*), intent(in) :: name, numbers

    associate (word => scene%words(index_of(scene%words, name)))
      if (allocated(word%value)) then
        word%value = word%value//' '//numbers
      else
        word%value = numbers
      end if
    end associate
  end subroutine add_to_word

  !> Points that are fixed, loaded or measured.
  subroutine take_points(group, scene, error)
    type(deck_group_t), intent(in) :: group
    type(scene_t), intent(inout) :: scene
    type(error_t), allocatable, intent(out) :: error
    type(line_t) :: line
    real(dp), allocatable :: place(:, :)
    integer :: i

    call take_places(group, 1, place, error)
    if (allocated(error)) return
    do i = 1, size(place, 2)
      select case (group%name)
      case ('fixed')
        line%ends = spread(place(:, i), 2, 2)
        line%deck_line = group%deck_line
        scene%fixed_lines = [scene%fixed_lines, line]
      case ('load')
        scene%load_points = [scene%load_points, point_t(place(:, i), group%deck_line, 0)]
      case ('measured')
        scene%measured_points = [scene%measured_points, point_t(place(:, i), group%deck_line, 0)]
      end select
    end do
  end subroutine take_points

  !> Places from x and y. A last one that repeats the first is left out where they are corners.
  subroutine take_places(group, least, place, error)
    type(deck_group_t), intent(in) :: group
    integer, intent(in) :: least !! number
    real(dp), allocatable, intent(out) :: place(:, :) !! (2, n)
    type(error_t), allocatable, intent(out) :: error
    integer :: n
    character(len=:), allocatable :: y_place

    n = size(group%x)
    y_place = from_of(group%words, group%name//'.y')
    associate (x => group%x, y => group%y)
      if (size(y) /= n) then
        call wrong_at(y_place, 'as many numbers for '//group%name//'.y as for '//group%name//'.x ('//number_text(n)//')', &
                      number_text(size(y)), error)
        return
      end if
      if (least > 1 .and. n > 3 .and. group%name /= 'slope' .and. group%name /= 'support' .and. &
          group%name /= 'fixed_line') then
        if (.not. (abs(x(n) - x(1)) > 0.0_dp .or. abs(y(n) - y(1)) > 0.0_dp)) n = n - 1
      end if
      if (n < least .or. (least > 1 .and. n > most_corners)) then
        call wrong_at(y_place, 'from '//number_text(least)//' to '//number_text(most_corners)//' places in &'//group%name, &
                      number_text(n), error)
        return
      end if
      allocate (place(2, n))
      place(1, :) = x(:n)
      place(2, :) = y(:n)
    end associate
  end subroutine take_places

  !> Corners of a round tunnel, counter-clockwise, the first to the right of its centre.
  subroutine take_circle(deck, group, corner, error)
    type(deck_t), intent(in) :: deck
    type(deck_group_t), intent(in) :: group
    real(dp), allocatable, intent(out) :: corner(:, :)
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: angle
    integer :: k

    if (allocated(group%x) .or. allocated(group%y)) then
      call wrong(deck, group%deck_line, 'x and y, or centre and radius, in &tunnel', 'both', error)
    else if (.not. allocated(group%centre) .or. .not. group%radius > 0) then
      call wrong(deck, group%deck_line, 'centre and radius in &tunnel', 'one without the other', error)
    else if (size(group%centre) /= 2) then
      call wrong_at(from_of(group%words, 'tunnel.centre'), 'two numbers for tunnel.centre', number_text(size(group%centre)), error)
    end if
    if (allocated(error)) return
    allocate (corner(2, group%sides))
    do k = 1, group%sides
      angle = 2*pi*(k - 1)/group%sides
      corner(:, k) = group%centre + group%radius*[cos(angle), sin(angle)]
    end do
  end subroutine take_circle

  !> Slopes with points outside the window, which cuts them off: one line for each.
  pure function doubts_of_slopes(deck, window, outline) result(doubt)
    type(deck_t), intent(in) :: deck
    real(dp), intent(in) :: window(:, :)              !! (2, n) corners
    type(outline_t), intent(in) :: outline(:)         !! slopes as they are given
    type(text_t), allocatable :: doubt(:)
    character(len=:), allocatable :: side
    real(dp) :: beside, low(2), high(2)
    integer :: i, k

    allocate (doubt(0))
    low = minval(window, 2)
    high = maxval(window, 2)
    beside = rounding*maxval(high - low)
    do i = 1, size(outline)
      if (outline(i)%kind /= slope_outline) cycle
      do k = 1, size(outline(i)%corner, 2)
        associate (point => outline(i)%corner(:, k))
          side = ''
          if (point(2) > high(2) + beside) then
            side = 'above its top, y = '//real_text(high(2))//', which is the ground there'
          else if (point(2) < low(2) - beside) then
            side = 'below its bottom, y = '//real_text(low(2))//': no rock is left there'
          else if (point(1) < low(1) - beside) then
            side = 'beyond its left side, x = '//real_text(low(1))//', where the slope is cut off'
          else if (point(1) > high(1) + beside) then
            side = 'beyond its right side, x = '//real_text(high(1))//', where the slope is cut off'
          end if
          if (len(side) == 0) cycle
          side = place_of_line(deck, outline(i)%deck_line)//': expected points of &slope in the window, found ('// &
                 real_text(point(1))//', '//real_text(point(2))//') '//side
          doubt = [doubt, text_t(side)]
        end associate
        exit
      end do
    end do
  end function doubts_of_slopes

  !> Makes the rock. Errors: outlines that cross themselves, have no area, miss the window, or leave nothing of it.
  subroutine check_outlines(deck, window, outline, rock, error)
    type(deck_t), intent(in) :: deck
    type(outline_t), intent(in) :: window
    type(outline_t), intent(inout) :: outline(:)
    type(rock_t), intent(out) :: rock
    type(error_t), allocatable, intent(out) :: error
    real(dp), allocatable :: closed(:, :)
    real(dp) :: size_(2)
    integer :: i

    size_ = maxval(window%corner, 2) - minval(window%corner, 2)
    if (minval(size_) < max(least_window, least_share*maxval(abs(window%corner)))) then
      call wrong(deck, window%deck_line, 'a &window at least 1e-9 and 1e-5 of its largest coordinate wide and high', &
                 real_text(size_(1))//' by '//real_text(size_(2)), error)
      return
    end if
    call check_polygon(window, 'window')
    if (allocated(error)) return
    do i = 1, size(outline)
      if (outline(i)%kind == slope_outline) then
        call close_slope(window%corner, outline(i)%corner, closed)
        if (.not. allocated(closed)) then
          call wrong(deck, outline(i)%deck_line, 'a &slope from the left of the window, or above it, to its right, or above it', &
                     'an end elsewhere', error)
          return
        end if
        call move_alloc(closed, outline(i)%corner)
        call check_polygon(outline(i), 'slope')
      else
        call check_polygon(outline(i), 'tunnel')
      end if
      if (allocated(error)) return
    end do
    call make_rock([window, outline], rock)
    do i = 2, size(rock%outline)
      if (reaches_into_window(rock, i)) cycle
      call wrong(deck, rock%outline(i)%deck_line, 'a &'//trim(merge('tunnel', 'slope ', rock%outline(i)%kind == tunnel_outline))// &
                 ' that takes something from the window', 'one outside it', error)
      return
    end do

  contains

    !> Error where an outline crosses itself or has no area.
    subroutine check_polygon(this, what)
      type(outline_t), intent(in) :: this
      character(len=*), intent(in) :: what

      if (crosses_itself(this%corner)) &
        call wrong(deck, this%deck_line, 'a &'//what//' whose sides meet at their corners alone', 'sides that cross or touch', &
                   error)
    end subroutine check_polygon

  end subroutine check_outlines

  !> Error where a set has too many traces in the window.
  subroutine check_sets(deck, joints, error)
    type(deck_t), intent(in) :: deck
    type(joints_t), intent(in) :: joints
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: low(2), high(2), n
    integer :: i

    do i = 1, size(joints%sets)
      call bounds_of(joints%rock%outline(window_outline)%corner, joints%sets(i)%dip, low, high)
      n = expected_traces(joints%sets(i), low, high)
      if (n <= most_traces) cycle
      call wrong(deck, joints%sets(i)%deck_line, 'a &joint_set of at most '//real_text(most_traces)//' traces in the window', &
                 'one of about '//real_text(anint(n)), error)
      return
    end do
  end subroutine check_sets

  !> Error where a point is outside the rock, or a line nowhere meets it.
  subroutine check_points(deck, joints, scene, error)
    type(deck_t), intent(in) :: deck
    type(joints_t), intent(in) :: joints
    type(scene_t), intent(in) :: scene
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    do i = 1, size(scene%fixed_lines)
      associate (line => scene%fixed_lines(i))
        if (all(abs(line%ends(:, 1) - line%ends(:, 2)) <= 0)) then
          call check(line%ends(:, 1), line%deck_line, 'fixed')
        else
          call check_line(line, 'fixed line')
        end if
      end associate
      if (allocated(error)) return
    end do
    do i = 1, size(joints%supports)
      call check_line(joints%supports(i), 'support')
      if (allocated(error)) return
    end do
    do i = 1, size(scene%load_points)
      call check(scene%load_points(i)%position, scene%load_points(i)%deck_line, 'load')
      if (allocated(error)) return
    end do
    do i = 1, size(scene%measured_points)
      call check(scene%measured_points(i)%position, scene%measured_points(i)%deck_line, 'measured')
      if (allocated(error)) return
    end do

  contains

    !> Error where a place is outside the rock.
    subroutine check(place, line, what)
      real(dp), intent(in) :: place(2)
      integer, intent(in) :: line
      character(len=*), intent(in) :: what

      if (has_rock_at(joints%rock, place)) return
      call wrong(deck, line, 'a '//what//' point in the rock', real_text(place(1))//' '//real_text(place(2))//' outside', error)
    end subroutine check

    !> Error where a line is outside the rock.
    subroutine check_line(line, what)
      type(line_t), intent(in) :: line
      character(len=*), intent(in) :: what

      if (meets_rock(joints%rock, line%ends)) return
      call wrong(deck, line%deck_line, 'a '//what//' that meets the rock', 'one outside', error)
    end subroutine check_line

  end subroutine check_points

  !> Error at a line.
  subroutine wrong(deck, line, expected, found, error)
    type(deck_t), intent(in) :: deck
    integer, intent(in) :: line
    character(len=*), intent(in) :: expected, found
    type(error_t), allocatable, intent(out) :: error

    call wrong_at(place_of_line(deck, line), expected, found, error)
  end subroutine wrong

  !> Error at a place.
  subroutine wrong_at(place, expected, found, error)
    character(len=*), intent(in) :: place, expected, found
    type(error_t), allocatable, intent(out) :: error

    call fail(error, status_bad_input, place//': expected '//expected//', found '//found)
  end subroutine wrong_at

  !> A line of a deck in words.
  pure function place_of_line(deck, line)
    type(deck_t), intent(in) :: deck
    integer, intent(in) :: line
    character(len=:), allocatable :: place_of_line

    place_of_line = deck%name//':'//number_text(line)
  end function place_of_line

end module scree_joints_deck
