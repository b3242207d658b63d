!> The deck of joint sets: named groups for a window, what is cut out of it, joint sets and points. doc/decks.md has them.
module scree_joints_deck
  use scree_deck_text, only: count_numbers, deck_t, in_quotes, read_deck
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_joint_sets, only: bounds_of, expected_traces, joint_set_t
  use scree_kinds, only: dp
  use scree_named_groups, only: group_begins, group_ends, groups_end, groups_t, name_has_value, next_item, start_groups, &
                                wrong_item
  use scree_rock_outline, only: close_slope, crosses_itself, has_rock_at, make_rock, outline_t, reaches_into_window, rock_t, &
                                slope_outline, tunnel_outline, window_outline
  use scree_scene, only: line_t, point_t, scene_t, word_t
  use scree_settings, only: kind_real, kind_reals, kind_whole, known_groups, place_in, put_word, setting_t
  use scree_text, only: number_text, real_text
  implicit none
  private
  public :: joints_t, read_joints_deck

  !> What a deck asks for.
  type :: joints_t
    type(rock_t) :: rock
    type(joint_set_t), allocatable :: sets(:)
    integer :: seed = 1
  end type joints_t

  character(len=*), parameter :: needed = 'needed'
  !> Largest coordinate; with this least window, products of lengths stay in range.
  real(dp), parameter :: farthest = 1e12_dp, least_window = 1e-9_dp
  real(dp), parameter :: least_share = 1e-5_dp     !! of a window in its distance from the origin, for its digits
  real(dp), parameter :: most_traces = 1e6_dp      !! of a set
  integer, parameter :: most_corners = 2000        !! of an outline

  type(setting_t), parameter :: table(*) = [ &
    setting_t('window', 'x', kind_reals, needed, 'of its corners; two are a rectangle', '', 'length', -farthest, farthest), &
    setting_t('window', 'y', kind_reals, needed, '', '', 'length', -farthest, farthest), &
    setting_t('window', 'material', kind_whole, '1', 'joint material of its sides', '', '1', 1.0_dp, 1e9_dp), &
    setting_t('tunnel', 'x', kind_reals, 'none', 'of its corners, either way round', '', 'length', -farthest, farthest), &
    setting_t('tunnel', 'y', kind_reals, 'none', '', '', 'length', -farthest, farthest), &
    setting_t('tunnel', 'centre', kind_reals, 'none', 'x y; of a round tunnel', '', 'length', -farthest, farthest), &
    setting_t('tunnel', 'radius', kind_real, 'none', 'of its corners', '', 'length', 0.0_dp, farthest, .true.), &
    setting_t('tunnel', 'sides', kind_whole, '24', 'of a round tunnel', '', '1', 3.0_dp, real(most_corners, dp)), &
    setting_t('tunnel', 'material', kind_whole, '1', 'joint material of its sides', '', '1', 1.0_dp, 1e9_dp), &
    setting_t('slope', 'x', kind_reals, needed, 'of its points', '', 'length', -farthest, farthest), &
    setting_t('slope', 'y', kind_reals, needed, '', '', 'length', -farthest, farthest), &
    setting_t('slope', 'material', kind_whole, '1', 'joint material of its lines', '', '1', 1.0_dp, 1e9_dp), &
    setting_t('joint_set', 'dip', kind_real, needed, 'from the x axis, counter-clockwise', '', 'degree', -360.0_dp, 360.0_dp), &
    setting_t('joint_set', 'spacing', kind_real, needed, 'of neighbouring lines', '', 'length', 0.0_dp, farthest, .true.), &
    setting_t('joint_set', 'length', kind_real, needed, 'of a trace', '', 'length', 0.0_dp, farthest, .true.), &
    setting_t('joint_set', 'bridge', kind_real, '0', 'of rock between traces', '', 'length', 0.0_dp, farthest), &
    setting_t('joint_set', 'randomness', kind_real, '0', 'of spacing, length and bridge', '', '1', 0.0_dp, 1.0_dp), &
    setting_t('joint_set', 'material', kind_whole, '1', 'joint material', '', '1', 1.0_dp, 1e9_dp), &
    setting_t('seed', 'value', kind_whole, '1', 'of the random numbers', '', '1', 0.0_dp, 1e9_dp), &
    setting_t('deck', 'e0', kind_real, '0.001', 'of the geometry deck', '', '1', 1e-6_dp, 0.1_dp), &
    setting_t('fixed', 'x', kind_reals, needed, 'of fixed points', '', 'length', -farthest, farthest), &
    setting_t('fixed', 'y', kind_reals, needed, '', '', 'length', -farthest, farthest), &
    setting_t('load', 'x', kind_reals, needed, 'of load points', '', 'length', -farthest, farthest), &
    setting_t('load', 'y', kind_reals, needed, '', '', 'length', -farthest, farthest), &
    setting_t('measured', 'x', kind_reals, needed, 'of measured points', '', 'length', -farthest, farthest), &
    setting_t('measured', 'y', kind_reals, needed, '', '', 'length', -farthest, farthest)]

  !> A group as it is read.
  type :: words_t
    character(len=:), allocatable :: group
    integer :: deck_line = 0
    type(word_t), allocatable :: word(:) !! in the order of the table
  end type words_t

contains

  !> Reads a deck of joint sets: what to draw, and a scene with its e0 and its points, still without lines.
  !>
  !> Errors: an unknown group or name, a name that is missing, a value of the wrong kind or range, outlines that cross
  !> themselves or leave no rock, points outside it; all with their line.
  subroutine read_joints_deck(name, joints, scene, error)
    character(len=*), intent(in) :: name
    type(joints_t), intent(out) :: joints
    type(scene_t), intent(out) :: scene
    type(error_t), allocatable, intent(out) :: error
    type(deck_t) :: deck
    type(groups_t) :: groups
    type(words_t) :: words
    type(outline_t), allocatable :: outline(:)
    type(outline_t) :: window
    character(len=:), allocatable :: done, place

    allocate (joints%sets(0), scene%material_lines(0), scene%fixed_lines(0), scene%load_points(0), &
              scene%measured_points(0), scene%hole_points(0), outline(0))
    call read_deck(name, deck, error)
    if (allocated(error)) return
    if (count_numbers(deck) > 0) then
      call wrong(deck, deck%line(1), "'&' and the name of a group", in_quotes(deck%text(deck%first(1):deck%last(1))), error)
      return
    end if
    scene%least_distance = 0.001_dp
    done = ' '
    call start_groups(deck, groups)
    do
      call next_item(deck, groups, error)
      if (allocated(error)) return
      select case (groups%item)
      case (groups_end)
        exit
      case (group_begins)
        if (all(table%group /= groups%group)) then
          call wrong_item(deck, groups, 'one of the groups '//known_groups(table), in_quotes(groups%word), error)
        else if (index(done, ' '//groups%group//' ') > 0) then
          call wrong_item(deck, groups, '&'//groups%group//' once', 'a second', error)
        end if
        if (allocated(error)) return
        if (any(groups%group == [character(len=6) :: 'window', 'seed', 'deck'])) done = done//groups%group//' '
        if (allocated(words%word)) deallocate (words%word)
        allocate (words%word(size(table)))
        words%group = groups%group
        words%deck_line = groups%line
      case (name_has_value)
        place = place_of_line(deck, groups%line)
        call put_word(table, place//': ', groups%group, groups%name, groups%value, place, words%word, error)
        if (allocated(error)) return
      case (group_ends)
        call take_group(deck, words, joints, scene, window, outline, error)
        if (allocated(error)) return
      end select
    end do
    if (.not. allocated(window%corner)) then
      call wrong(deck, deck%n_lines, 'a &window', 'none', error)
      return
    end if
    call check_outlines(deck, window, outline, joints%rock, error)
    if (allocated(error)) return
    call check_sets(deck, joints, error)
    if (allocated(error)) return
    call check_points(deck, joints%rock, scene, error)
  end subroutine read_joints_deck

  !> Takes a group that is complete. Errors: names that are missing or do not go together.
  subroutine take_group(deck, words, joints, scene, window, outline, error)
    type(deck_t), intent(in) :: deck
    type(words_t), intent(in) :: words
    type(joints_t), intent(inout) :: joints
    type(scene_t), intent(inout) :: scene
    type(outline_t), intent(inout) :: window
    type(outline_t), allocatable, intent(inout) :: outline(:)
    type(error_t), allocatable, intent(out) :: error
    type(outline_t) :: this
    type(line_t) :: line
    real(dp), allocatable :: place(:, :)
    integer :: i

    do i = 1, size(table)
      if (table(i)%group /= words%group .or. table(i)%default /= needed .or. allocated(words%word(i)%value)) cycle
      call wrong(deck, words%deck_line, trim(table(i)%name)//' in &'//words%group, 'none', error)
      return
    end do
    select case (words%group)
    case ('seed')
      joints%seed = nint(number(words, 'value'))
    case ('deck')
      scene%least_distance = number(words, 'e0')
    case ('joint_set')
      joints%sets = [joints%sets, joint_set_t( &
                     number(words, 'dip'), number(words, 'spacing'), number(words, 'length'), number(words, 'bridge'), &
                     number(words, 'randomness'), nint(number(words, 'material')), words%deck_line)]
    case ('window')
      window%deck_line = words%deck_line
      window%material = nint(number(words, 'material'))
      call take_places(words, 2, window%corner, error)
      if (allocated(error)) return
      if (size(window%corner, 2) == 2) then
        place = window%corner
        window%corner = reshape([place(:, 1), place(1, 2), place(2, 1), place(:, 2), place(1, 1), place(2, 2)], [2, 4])
      end if
    case ('tunnel', 'slope')
      this%kind = merge(tunnel_outline, slope_outline, words%group == 'tunnel')
      this%deck_line = words%deck_line
      this%material = nint(number(words, 'material'))
      if (words%group == 'slope') then
        call take_places(words, 2, this%corner, error)
      else if (has(words, 'centre') .or. has(words, 'radius') .or. has(words, 'sides')) then
        call take_circle(deck, words, this%corner, error)
      else if (has(words, 'x') .and. has(words, 'y')) then
        call take_places(words, 3, this%corner, error)
      else
        call wrong(deck, words%deck_line, 'x and y, or centre and radius, in &tunnel', 'neither', error)
      end if
      if (allocated(error)) return
      outline = [outline, this]
    case default
      call take_places(words, 1, place, error)
      if (allocated(error)) return
      do i = 1, size(place, 2)
        select case (words%group)
        case ('fixed')
          line%ends = spread(place(:, i), 2, 2)
          line%deck_line = words%deck_line
          scene%fixed_lines = [scene%fixed_lines, line]
        case ('load')
          scene%load_points = [scene%load_points, point_t(place(:, i), words%deck_line, 0)]
        case ('measured')
          scene%measured_points = [scene%measured_points, point_t(place(:, i), words%deck_line, 0)]
        end select
      end do
    end select
  end subroutine take_group

  !> Places from x and y. A last one that repeats the first is left out where they are corners.
  subroutine take_places(words, least, place, error)
    type(words_t), intent(in) :: words
    integer, intent(in) :: least !! number
    real(dp), allocatable, intent(out) :: place(:, :) !! (2, n)
    type(error_t), allocatable, intent(out) :: error
    real(dp), allocatable :: x(:), y(:)
    integer :: n
    character(len=:), allocatable :: y_place

    x = numbers(words, 'x')
    y = numbers(words, 'y')
    n = size(x)
    y_place = words%word(place_in(table, words%group, 'y'))%from
    if (size(y) /= n) then
      call wrong_at(y_place, 'as many numbers for '//words%group//'.y as for '//words%group//'.x ('//number_text(n)//')', &
                    number_text(size(y)), error)
      return
    end if
    if (least > 1 .and. n > 3 .and. words%group /= 'slope') then
      if (.not. (abs(x(n) - x(1)) > 0.0_dp .or. abs(y(n) - y(1)) > 0.0_dp)) n = n - 1
    end if
    if (n < least .or. (least > 1 .and. n > most_corners)) then
      call wrong_at(y_place, 'from '//number_text(least)//' to '//number_text(most_corners)//' places in &'//words%group, &
                    number_text(n), error)
      return
    end if
    allocate (place(2, n))
    place(1, :) = x(:n)
    place(2, :) = y(:n)
  end subroutine take_places

  !> Corners of a round tunnel, counter-clockwise, the first to the right of its centre.
  subroutine take_circle(deck, words, corner, error)
    type(deck_t), intent(in) :: deck
    type(words_t), intent(in) :: words
    real(dp), allocatable, intent(out) :: corner(:, :)
    type(error_t), allocatable, intent(out) :: error
    real(dp), allocatable :: centre(:)
    real(dp), parameter :: full_turn = 2*acos(-1.0_dp)
    real(dp) :: angle
    integer :: k, n

    if (has(words, 'x') .or. has(words, 'y')) then
      call wrong(deck, words%deck_line, 'x and y, or centre and radius, in &tunnel', 'both', error)
    else if (.not. has(words, 'centre') .or. .not. has(words, 'radius')) then
      call wrong(deck, words%deck_line, 'centre and radius in &tunnel', 'one without the other', error)
    else
      centre = numbers(words, 'centre')
      if (size(centre) /= 2) call wrong_at(words%word(place_in(table, 'tunnel', 'centre'))%from, &
                                           'two numbers for tunnel.centre', number_text(size(centre)), error)
    end if
    if (allocated(error)) return
    n = nint(number(words, 'sides'))
    allocate (corner(2, n))
    do k = 1, n
      angle = full_turn*(k - 1)/n
      corner(:, k) = centre + number(words, 'radius')*[cos(angle), sin(angle)]
    end do
  end subroutine take_circle

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

  !> Error where a point is outside the rock.
  subroutine check_points(deck, rock, scene, error)
    type(deck_t), intent(in) :: deck
    type(rock_t), intent(in) :: rock
    type(scene_t), intent(in) :: scene
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    do i = 1, size(scene%fixed_lines)
      call check(scene%fixed_lines(i)%ends(:, 1), scene%fixed_lines(i)%deck_line, 'fixed')
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

      if (has_rock_at(rock, place)) return
      call wrong(deck, line, 'a '//what//' point in the rock', real_text(place(1))//' '//real_text(place(2))//' outside', error)
    end subroutine check

  end subroutine check_points

  !> Whether a name of a group has a value.
  pure logical function has(words, name)
    type(words_t), intent(in) :: words
    character(len=*), intent(in) :: name

    has = allocated(words%word(place_in(table, words%group, name))%value)
  end function has

  !> Value of a name, else its default.
  function number(words, name)
    type(words_t), intent(in) :: words
    character(len=*), intent(in) :: name
    real(dp) :: number
    character(len=:), allocatable :: value

    if (has(words, name)) then
      value = words%word(place_in(table, words%group, name))%value
    else
      value = trim(table(place_in(table, words%group, name))%default)
    end if
    read (value, *) number
  end function number

  !> Values of a name.
  function numbers(words, name)
    type(words_t), intent(in) :: words
    character(len=*), intent(in) :: name
    real(dp), allocatable :: numbers(:)
    character(len=:), allocatable :: value
    integer :: i, n

    value = words%word(place_in(table, words%group, name))%value
    n = 1
    do i = 1, len(value)
      if (value(i:i) == ' ') n = n + 1
    end do
    allocate (numbers(n))
    read (value, *) numbers
  end function numbers

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
