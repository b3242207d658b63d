!> Shi's geometry deck (the input of his dc), read and written: lines, and points on the blocks they enclose.
!>
!> Layout, number by number, in doc/decks.md. Source: Shi's dc as read by the public derivative ntdda.
module scree_geometry_deck
  use scree_bolt_records, only: bolt_text, read_bolts
  use scree_deck_options, only: begin_thing
  use scree_deck_rows, only: add_row, begin_rows, blame_line, deck_rows_t
  use scree_deck_text, only: count_numbers, deck_t, expect_end, next_count, next_index, next_real, next_reals
  use scree_errors, only: error_t, fail, status_bad_input, status_run_failed
  use scree_groups_of_places, only: groups_text
  use scree_kinds, only: dp
  use scree_scene, only: line_t, point_t, scene_t
  use scree_text, only: number_text, real_text
  use scree_text_file, only: close_text_file, open_text_file, put_line, text_file_t
  implicit none
  private
  public :: read_geometry_deck, write_geometry_deck

contains

  !> Reads a geometry deck into the scene. Errors: anything that does not follow the layout, with its line.
  subroutine read_geometry_deck(deck, scene, error)
    type(deck_t), intent(inout) :: deck
    type(scene_t), intent(inout) :: scene
    type(error_t), allocatable, intent(out) :: error
    integer :: n_bolts, n_fixed, n_holes, n_lines, n_loads, n_material, n_measured

    call begin_thing(deck%options, 'deck')
    call next_real(deck, 'the least distance of edge and node (e0)', scene%least_distance, error, &
                   least=0.0_dp, below=1.0_dp, name='e0')
    if (allocated(error)) return
    call next_count(deck, 'lines', 5, n_lines, error, least=1)
    if (allocated(error)) return
    call next_index(deck, 'the number of boundary lines', scene%n_boundary, error, most=n_lines)
    if (allocated(error)) return
    call next_count(deck, 'material lines', 5, n_material, error)
    if (allocated(error)) return
    call next_count(deck, 'bolts', 7, n_bolts, error)
    if (allocated(error)) return
    call next_count(deck, 'fixed lines', 4, n_fixed, error)
    if (allocated(error)) return
    call next_count(deck, 'load points', 2, n_loads, error)
    if (allocated(error)) return
    call next_count(deck, 'measured points', 2, n_measured, error)
    if (allocated(error)) return
    call next_count(deck, 'hole points', 2, n_holes, error)
    if (allocated(error)) return
    call check_rows(deck, [n_lines, n_material, n_bolts, n_fixed, n_loads, n_measured, n_holes], error)
    if (allocated(error)) return
    call read_lines(deck, 'line', .true., n_lines, scene%lines, error)
    if (allocated(error)) return
    call read_lines(deck, 'material_line', .true., n_material, scene%material_lines, error)
    if (allocated(error)) return
    call read_bolts(deck, n_bolts, -1, scene%bolts, error)
    if (allocated(error)) return
    call read_lines(deck, 'fixed_line', .false., n_fixed, scene%fixed_lines, error)
    if (allocated(error)) return
    call read_points(deck, 'load_point', n_loads, scene%load_points, error)
    if (allocated(error)) return
    call read_points(deck, 'measured_point', n_measured, scene%measured_points, error)
    if (allocated(error)) return
    call read_points(deck, 'hole_point', n_holes, scene%hole_points, error)
    if (allocated(error)) return
    call expect_end(deck, error)
  end subroutine read_geometry_deck

  !> Error at the line of a deck that alone explains a wrong count of numbers; none where the count is right, or where no line
  !> alone does.
  subroutine check_rows(deck, count, error)
    type(deck_t), intent(in) :: deck
    integer, intent(in) :: count(7)          !! lines, material lines, bolts, fixed lines, load, measured and hole points
    type(error_t), allocatable, intent(out) :: error
    character(len=8), parameter :: head(*) = [character(len=8) :: 'e0', 'n', 'nb', 'nm', 'nr', 'nf', 'nl', 'nq', 'nh']
    character(len=14), parameter :: thing(7) = [character(len=14) :: 'line', 'material line', 'bolt', 'fixed line', 'load point', &
                                                'measured point', 'hole point']
    character(len=8), parameter :: ends(4) = [character(len=8) :: 'x1', 'y1', 'x2', 'y2'], place(2) = [character(len=8) :: 'x', 'y']
    integer, parameter :: width(7) = [5, 5, 7, 4, 2, 2, 2]
    type(deck_rows_t) :: rows
    integer :: expected, i, k

    expected = size(head) + dot_product(count, width)
    if (count_numbers(deck) == expected) return
    call begin_rows(expected, rows)
    call add_row(head, '', rows, is_loose=.true.)
    do k = 1, size(count)
      do i = 1, count(k)
        call add_row(names_of(k), trim(thing(k))//' '//number_text(i), rows)
      end do
    end do
    call blame_line(deck, rows, '; the deck has '//number_text(count_numbers(deck))//' numbers, expected '// &
                    number_text(expected)//' by its counts', error)

  contains

    !> Names of the numbers of a thing.
    pure function names_of(k) result(names)
      integer, intent(in) :: k
      character(len=8), allocatable :: names(:)

      select case (k)
      case (1)
        names = [ends, [character(len=8) :: 'jm']]
      case (2)
        names = [ends, [character(len=8) :: 'bm']]
      case (3)
        names = [ends, [character(len=8) :: 'e0', 't0', 'f0']]
      case (4)
        names = ends
      case default
        names = place
      end select
    end function names_of

  end subroutine check_rows

  !> Reads x1 y1 x2 y2 and, where the lines have one, a material.
  subroutine read_lines(deck, kind, has_material, n, lines, error)
    type(deck_t), intent(inout) :: deck
    character(len=*), intent(in) :: kind !! as --set names it
    logical, intent(in) :: has_material
    integer, intent(in) :: n
    type(line_t), allocatable, intent(out) :: lines(:)
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: what
    real(dp) :: number(4)
    integer :: i

    allocate (lines(n))
    what = in_words(kind)
    do i = 1, n
      call begin_thing(deck%options, kind, i)
      call next_reals(deck, 'the ends x1 y1 x2 y2 of '//what//' '//number_text(i), number, error, &
                      names=['x1', 'y1', 'x2', 'y2'])
      if (allocated(error)) return
      lines(i)%ends = reshape(number, [2, 2])
      lines(i)%deck_line = deck%line(deck%at)
      if (.not. has_material) cycle
      call next_index(deck, 'the material of '//what//' '//number_text(i), lines(i)%material, error, least=1, &
                      name=merge('jm', 'bm', kind == 'line'))
      if (allocated(error)) return
    end do
  end subroutine read_lines

  !> Reads x y.
  subroutine read_points(deck, kind, n, points, error)
    type(deck_t), intent(inout) :: deck
    character(len=*), intent(in) :: kind !! as --set names it
    integer, intent(in) :: n
    type(point_t), allocatable, intent(out) :: points(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    allocate (points(n))
    do i = 1, n
      call begin_thing(deck%options, kind, i)
      call next_reals(deck, 'x y of '//in_words(kind)//' '//number_text(i), points(i)%position, error, names=['x', 'y'])
      if (allocated(error)) return
      points(i)%deck_line = deck%line(deck%at)
    end do
  end subroutine read_points

  !> A kind of thing, as --set names it, with a blank between its words.
  pure function in_words(kind)
    character(len=*), intent(in) :: kind
    character(len=len(kind)) :: in_words
    integer :: at

    in_words = kind
    at = index(kind, '_')
    if (at > 0) in_words(at:at) = ' '
  end function in_words

  !> Writes a geometry deck that reads back as the same scene, over a file of that name. Errors: it cannot be written.
  !>
  !> Numbers, so that other programs read it, then a remark and groups of places, where they have stopped reading.
  subroutine write_geometry_deck(name, scene, remark, error)
    character(len=*), intent(in) :: name
    type(scene_t), intent(in) :: scene
    character(len=*), intent(in) :: remark     !! one line
    type(error_t), allocatable, intent(out) :: error
    type(text_file_t) :: file
    integer :: i

    call open_text_file(name, file, error)
    if (allocated(error)) return
    call put_line(file, real_text(scene%least_distance))
    call put_line(file, number_text(size(scene%lines))//' '//number_text(scene%n_boundary))
    call put_line(file, number_text(size(scene%material_lines)))
    call put_line(file, number_text(size(scene%bolts)))
    call put_line(file, number_text(size(scene%fixed_lines)))
    call put_line(file, number_text(size(scene%load_points)))
    call put_line(file, number_text(size(scene%measured_points)))
    call put_line(file, number_text(size(scene%hole_points)))
    call put_lines(scene%lines, .true.)
    call put_lines(scene%material_lines, .true.)
    do i = 1, size(scene%bolts)
      call put_line(file, place_text(scene%bolts(i)%ends(:, 1))//' '//place_text(scene%bolts(i)%ends(:, 2))//' '// &
                    bolt_text(scene%bolts(i)))
    end do
    call put_lines(scene%fixed_lines, .false.)
    call put_points(scene%load_points)
    call put_points(scene%measured_points)
    call put_points(scene%hole_points)
    call put_line(file, '! '//remark)
    if (allocated(scene%words)) then
      if (len(groups_text(scene%words, cut=.false.)) > 0) call put_line(file, groups_text(scene%words, cut=.false.))
    end if
    call close_text_file(file, error)

  contains

    !> Writes x1 y1 x2 y2 and, where the lines have one, a material.
    subroutine put_lines(lines, has_material)
      type(line_t), intent(in) :: lines(:)
      logical, intent(in) :: has_material
      character(len=:), allocatable :: material
      integer :: i

      material = ''
      do i = 1, size(lines)
        if (has_material) material = ' '//number_text(lines(i)%material)
        call put_line(file, place_text(lines(i)%ends(:, 1))//' '//place_text(lines(i)%ends(:, 2))//material)
      end do
    end subroutine put_lines

    !> Writes x y.
    subroutine put_points(points)
      type(point_t), intent(in) :: points(:)
      integer :: i

      do i = 1, size(points)
        call put_line(file, place_text(points(i)%position))
      end do
    end subroutine put_points

  end subroutine write_geometry_deck

  !> Two coordinates.
  pure function place_text(position)
    real(dp), intent(in) :: position(2)
    character(len=:), allocatable :: place_text

    place_text = real_text(position(1))//' '//real_text(position(2))
  end function place_text

end module scree_geometry_deck
