!> Stages of a run: values after a &stage replace those before, from there on.
module scree_stages
  use scree_block_input, only: blocks_t
  use scree_bolt_records, only: take_bolts
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_kinds, only: dp
  use scree_polygon, only: holds, inner_place
  use scree_regions, only: first_vertex_of, last_vertex_of, loops_of
  use scree_rock_outline, only: crosses_itself
  use scree_scene_rectangle, only: check_rectangle
  use scree_scene, only: bolt_record_t, kind_of, scene_t, settings_t, word_t
  use scree_setting_rules, only: drop_idle, drop_overridden
  use scree_setting_table, only: deck_part_t, given_at, index_of, is_given_by, kind_choice, setting_t, taken_away
  use scree_settings, only: settings_table
  use scree_text, only: append, number_text, real_text, text_t
  implicit none
  private
  public :: add_bolts_of_stage, begin_stage, check_names, end_of_stage_prefix, find_removed, lines_of_stages, named_lines, &
            part_polygons, parts_to_stages

contains

  !> Makes the values of each stage from the values of each part of a deck.
  !>
  !> A name that is given stands until a later stage gives it another value, or 'none'; what the command line gives stands in all.
  !> Ramps, the acceleration of the ground, a wave that comes in and what &stage says are of their stage alone. A stage that says
  !> its kind takes nothing of &step over.
  subroutine parts_to_stages(parts)
    type(deck_part_t), intent(inout) :: parts(:)
    type(setting_t), allocatable :: table(:)
    logical, allocatable :: taken_over(:)
    logical :: says_kind
    integer :: i, k

    table = settings_table()
    allocate (taken_over(size(table)))
    do k = 1, size(parts)
      taken_over = .false.
      if (k > 1) call take_over()
      do i = 1, size(table)
        associate (word => parts(k)%words(i))
          if (.not. allocated(word%value)) cycle
          if (word%value == taken_away .and. table(i)%kind /= kind_choice .and. table(i)%group /= 'stage') deallocate (word%value)
        end associate
      end do
      call drop_idle(taken_over, parts(k)%words)
      call drop_overridden(parts(k)%words)
    end do

  contains

    !> Takes over the values of the stage before that stay.
    subroutine take_over()
      says_kind = is_given_by(parts(k)%words(index_of(parts(k)%words, 'stage.kind')))
      do i = 1, size(table)
        associate (own => parts(k)%words(i), before => parts(k - 1)%words(i))
          if (.not. stands_on(table(i), before, says_kind)) cycle
          taken_over(i) = .not. allocated(own%value)
          if (.not. taken_over(i)) taken_over(i) = before%from == '--set' .and. own%from /= '--set'
          if (taken_over(i)) own = before
          own%stands_on = taken_over(i)
        end associate
      end do
      associate (name => parts(k)%words(index_of(parts(k)%words, 'stage.name')))
        if (.not. allocated(name%value)) then
          name%value = 'stage '//number_text(k)
          name%from = 'default'
        end if
      end associate
    end subroutine take_over

  end subroutine parts_to_stages

  !> Error where two stages have one name, by which tools ask for them.
  subroutine check_names(parts, error)
    type(deck_part_t), intent(in) :: parts(:)
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: place
    integer :: j, k

    do k = 2, size(parts)
      do j = 1, k - 1
        if (name_of(j) /= name_of(k)) cycle
        place = given_at(parts(k)%words, 'stage.name')
        if (len(place) == 0) place = given_at(parts(j)%words, 'stage.name')
        call fail(error, status_bad_input, place//': expected another name of a stage than that of stage '//number_text(j)// &
                  ', found '''//name_of(k)//''' for stage '//number_text(k)//' too')
        return
      end do
    end do

  contains

    !> The name of a stage; the first has none but its number.
    pure function name_of(k) result(name)
      integer, intent(in) :: k
      character(len=:), allocatable :: name

      name = 'stage 1'
      if (k > 1) name = parts(k)%words(index_of(parts(k)%words, 'stage.name'))%value
    end function name_of

  end subroutine check_names

  !> Where stage(K). ends in stage(K).GROUP.NAME=VALUE of the command line; 0 where an option is of all stages.
  pure integer function end_of_stage_prefix(option) result(at)
    character(len=*), intent(in) :: option

    at = 0
    if (index(option, 'stage(') == 1) at = index(option, ').') + 1
  end function end_of_stage_prefix

  !> Whether a value of the stage before stands on.
  pure logical function stands_on(row, before, says_kind)
    type(setting_t), intent(in) :: row
    type(word_t), intent(in) :: before
    logical, intent(in) :: says_kind             !! the stage gives its kind

    stands_on = allocated(before%value)
    if (.not. stands_on) return
    if (row%group == 'stage' .or. row%group == 'acceleration' .or. row%name == 'ramp') stands_on = .false.
    if (row%group == 'absorbing' .and. .not. any(row%name == [character(len=5) :: 'lines', 'base', 'sides'])) stands_on = .false.
    if (row%group == 'step' .and. says_kind) stands_on = before%from == '--set'
  end function stands_on

  !> Makes the scene of a later stage of that of the one before, whose settings have no defaults yet.
  subroutine begin_stage(words, scene)
    type(word_t), intent(in) :: words(:)
    type(scene_t), intent(inout) :: scene
    type(scene_t) :: blank

    scene%words = words
    scene%settings = blank%settings
  end subroutine begin_stage

  !> Adds the bolts of a stage to those of the run, and lists which of these it has. One that an earlier stage has too, with the
  !> same ends and numbers, is the same bolt. With `bolts.earlier='kept'` those of the stage before stay.
  !>
  !> Errors: as of `take_bolts`.
  subroutine add_bolts_of_stage(scene, before, bolts, installed, error)
    type(scene_t), intent(in) :: scene           !! of the stage, with the bolts of the geometry
    logical, intent(in) :: before(:)             !! which bolts the stage before has, of those so far
    type(bolt_record_t), allocatable, intent(inout) :: bolts(:)
    logical, allocatable, intent(out) :: installed(:) !! of those so far
    type(error_t), allocatable, intent(out) :: error
    type(scene_t) :: own
    logical, allocatable :: longer(:)
    integer :: i, k

    own = scene
    call take_bolts(own, error)
    if (allocated(error)) return
    allocate (installed(size(bolts)), source=.false.)
    do i = 1, size(own%bolts)
      do k = 1, size(bolts)
        if (.not. installed(k) .and. are_same(own%bolts(i), bolts(k))) exit
      end do
      if (k > size(bolts)) then
        bolts = [bolts, own%bolts(i)]
        longer = [installed, .false.]
        call move_alloc(longer, installed)
      end if
      installed(k) = .true.
    end do
    if (own%settings%keeps_bolts) installed(:size(before)) = installed(:size(before)) .or. before
  end subroutine add_bolts_of_stage

  !> Whether two records describe one bolt.
  pure logical function are_same(a, b)
    type(bolt_record_t), intent(in) :: a, b

    are_same = all(a%block == b%block) .and. .not. &
               any(abs([a%ends - b%ends, reshape([a%stiffness - b%stiffness, a%strength - b%strength, &
                                                  a%pretension - b%pretension, a%shear_stiffness - b%shear_stiffness, &
                                                  a%shear_strength - b%shear_strength, 0.0_dp], [2, 3])]) > 0)
  end function are_same

  !> Removes the blocks that a stage removes, and checks the rectangle that others may leave.
  !>
  !> Errors: as of `check_rectangle`; numbers that are none of blocks or block materials, corners that make no polygons or such
  !> without a block in them, a stage without a block.
  subroutine find_removed(scene, blocks, error)
    type(scene_t), intent(inout) :: scene        !! with what was removed before
    type(blocks_t), intent(in) :: blocks
    type(error_t), allocatable, intent(out) :: error
    logical :: inside(size(blocks%material))
    integer :: i

    call check_rectangle(scene, blocks, error)
    if (allocated(error)) return
    associate (s => scene%settings, material => blocks%material)
      call check('stage.remove_blocks', s%removed_blocks, size(material), 'blocks')
      if (.not. allocated(error)) &
        call check('stage.remove_materials', s%removed_materials, size(scene%block_material), 'block materials')
      if (allocated(error)) return
      if (allocated(s%removed_blocks)) scene%removed(nint(s%removed_blocks)) = .true.
      if (allocated(s%removed_materials)) then
        do i = 1, size(s%removed_materials)
          scene%removed = scene%removed .or. material == nint(s%removed_materials(i))
        end do
      end if
      if (allocated(s%removed_inside)) then
        call find_inside(blocks, s%removed_inside, given_at(scene%words, 'stage.remove_inside'), inside, error)
        if (allocated(error)) return
        scene%removed = scene%removed .or. inside
      end if
      if (all(scene%removed)) call fail(error, status_bad_input, removal_at()//': expected a stage that leaves a block, found none')
    end associate

  contains

    !> Error where a number is out of range.
    subroutine check(name, numbers, n, of)
      character(len=*), intent(in) :: name, of
      real(dp), allocatable, intent(in) :: numbers(:)
      integer, intent(in) :: n
      integer :: k

      if (.not. allocated(numbers)) return
      do k = 1, size(numbers)
        if (numbers(k) <= n .and. .not. abs(numbers(k) - anint(numbers(k))) > 0) cycle
        call fail(error, status_bad_input, given_at(scene%words, name)//': expected numbers of '//of//' from 1 to '// &
                  number_text(n)//' in '//name//', found '//real_text(numbers(k)))
        return
      end do
    end subroutine check

    !> Where the deck removes blocks.
    function removal_at() result(place)
      character(len=:), allocatable :: place

      place = given_at(scene%words, 'stage.remove_blocks')
      if (len(place) == 0) place = given_at(scene%words, 'stage.remove_materials')
      if (len(place) == 0) place = given_at(scene%words, 'stage.remove_inside')
    end function removal_at

  end subroutine find_removed

  !> Which blocks lie in polygons: a place well inside each does. A polygon in another is a hole of it.
  !>
  !> Errors: corners that make no polygons; no block in them.
  subroutine find_inside(blocks, numbers, place, inside, error)
    type(blocks_t), intent(in) :: blocks
    real(dp), intent(in) :: numbers(:)           !! x y of the corners, length; each polygon ends with its first corner again
    character(len=*), intent(in) :: place        !! that the deck gives them at
    logical, intent(out) :: inside(:)            !! (n_blocks)
    type(error_t), allocatable, intent(out) :: error
    real(dp), allocatable :: corner(:, :)
    integer, allocatable :: first(:)
    integer :: b, i

    call part_polygons(numbers, corner, first)
    inside = .false.
    if (allocated(first)) then
      do i = 1, size(first) - 1
        if (crosses_itself(corner(:, first(i):first(i + 1) - 1))) deallocate (first)
        if (.not. allocated(first)) exit
      end do
    end if
    if (.not. allocated(first)) then
      call fail(error, status_bad_input, place//': expected x y of corners of polygons, three or more of each and its first '// &
                'again, whose sides do not cross, in stage.remove_inside, found others')
      return
    end if
    do i = 1, 2
      corner(i, :) = corner(i, :) - blocks%origin(i)
    end do
    do b = 1, size(inside)
      associate (outline => blocks%vertex(:, first_vertex_of(blocks%shape, b):last_vertex_of(blocks%shape, b)))
        inside(b) = holds(corner, inner_place(outline, loops_of(blocks%shape, b)), first)
      end associate
    end do
    if (.not. any(inside)) &
      call fail(error, status_bad_input, place//': expected blocks in the polygons of stage.remove_inside, found none')
  end subroutine find_inside

  !> The lines on which settings hold, load or absorb, and the sides of the polygons whose blocks they remove.
  pure function named_lines(settings) result(ends)
    type(settings_t), intent(in) :: settings
    real(dp), allocatable :: ends(:, :, :)       !! (xy, end, n), length
    real(dp), allocatable :: corner(:, :), side(:)
    integer, allocatable :: first(:)
    integer :: i, k

    allocate (ends(2, 2, 0))
    call add(settings%support_normal)
    call add(settings%support_x)
    call add(settings%support_y)
    call add(settings%support_both)
    call add(settings%support_moved)
    call add(settings%boundary_lines)
    call add(settings%absorbing_lines)
    call add(settings%absorbing_base)
    call add(settings%absorbing_sides)
    if (.not. allocated(settings%removed_inside)) return
    call part_polygons(settings%removed_inside, corner, first)
    if (.not. allocated(first)) return ! an error that `find_inside` tells
    do i = 1, size(first) - 1
      do k = first(i), first(i + 1) - 1
        side = [corner(:, k), corner(:, merge(first(i), k + 1, k == first(i + 1) - 1))]
        call add(side)
      end do
    end do

  contains

    !> Adds lines that are given as x1 y1 x2 y2 each.
    pure subroutine add(numbers)
      real(dp), intent(in), allocatable :: numbers(:)

      if (allocated(numbers)) ends = reshape([ends, numbers(:4*(size(numbers)/4))], [2, 2, size(ends, 3) + size(numbers)/4])
    end subroutine add

  end function named_lines

  !> Parts corners to polygons, each of which ends with its first corner again, which is left out.
  pure subroutine part_polygons(numbers, corner, first)
    real(dp), intent(in) :: numbers(:)                !! x y of the corners
    real(dp), allocatable, intent(out) :: corner(:, :) !! (2, n)
    integer, allocatable, intent(out) :: first(:)     !! (n_polygons+1) where each begins; not allocated where one is not closed
    integer, parameter :: fewest = 3
    real(dp) :: given(2, size(numbers)/2)
    integer :: begin, k

    given = reshape(numbers(:2*size(given, 2)), shape(given))
    allocate (corner(2, 0))
    first = [1]
    begin = 1
    do k = 1, size(given, 2)
      if (k - begin < fewest .or. any(abs(given(:, k) - given(:, begin)) > 0)) cycle
      corner = reshape([corner, given(:, begin:k - 1)], [2, size(corner, 2) + k - begin])
      first = [first, size(corner, 2) + 1]
      begin = k + 1
    end do
    if (begin <= size(given, 2) .or. size(first) == 1 .or. mod(size(numbers), 2) > 0) deallocate (first)
  end subroutine part_polygons

  !> The stages after the first in words, a line each: removed blocks and changed settings.
  function lines_of_stages(scene) result(line)
    type(scene_t), intent(in) :: scene
    type(text_t), allocatable :: line(:)
    character(len=:), allocatable :: text
    logical :: removed(size(scene%removed))
    integer :: k, n

    allocate (line(0))
    removed = scene%removed
    do k = 1, size(scene%later)
      associate (stage => scene%later(k))
        text = 'stage '//number_text(k + 1)
        if (stage%settings%stage_name /= text) text = text//' ('//stage%settings%stage_name//')'
        text = text//': '//kind_of(stage)
        n = count(stage%removed .and. .not. removed)
        if (n > 0) text = text//'; removes '//number_text(n)//' of '//number_text(count(.not. removed))//' blocks'
        removed = stage%removed
        if (k == 1) text = text//changes(scene%words, stage%words)
        if (k > 1) text = text//changes(scene%later(max(1, k - 1))%words, stage%words)
      end associate
      call append(line, text)
    end do

  contains

    !> Settings that are given and differ from those before, but those of &stage.
    function changes(before, now) result(words)
      type(word_t), intent(in) :: before(:), now(:)
      character(len=:), allocatable :: words
      integer :: i

      words = ''
      do i = 1, size(now)
        if (index(now(i)%name, 'stage.') == 1) cycle
        if (is_given_by(now(i))) then
          if (is_given_by(before(i))) then
            if (before(i)%value == now(i)%value) cycle
          end if
          words = words//'; '//now(i)%name//' = '//now(i)%value
        else if (is_given_by(before(i)) .and. .not. allocated(now(i)%value)) then
          words = words//'; no '//now(i)%name
        end if
      end do
    end function changes

  end function lines_of_stages

end module scree_stages
