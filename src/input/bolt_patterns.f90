!> Patterns of bolts: rows along lines (&bolt_row) and rings around circles (&bolt_ring), as the bolts that they stand for.
module scree_bolt_patterns
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_kinds, only: dp, pi
  use scree_scene, only: scene_t
  use scree_setting_table, only: given_at
  use scree_text, only: number_text, real_text
  implicit none
  private
  public :: bolts_of_rings, bolts_of_rows, one_for_each

  real(dp), parameter :: turn = 360.0_dp     !! a full circle, degrees
  !> Fraction of a spacing by which the last bolt may lie beyond the end of its row: the rounding of a deck.
  real(dp), parameter :: rounding = 1e-9_dp
  integer, parameter :: most_bolts = 100000  !! of one pattern: more is a mistake of units

contains

  !> Ends of the bolts of the rows: heads along each line from its first end on, all pointing one way.
  !>
  !> Errors: lists of different lengths, a line without length, a number of bolts that is none.
  subroutine bolts_of_rows(scene, ends, row, error)
    type(scene_t), intent(in) :: scene
    real(dp), allocatable, intent(out) :: ends(:, :, :) !! (xy, end, n) length
    integer, allocatable, intent(out) :: row(:)         !! (n) of which each bolt is
    type(error_t), allocatable, intent(out) :: error
    real(dp), allocatable :: direction(:), length(:)
    real(dp) :: along(2), span, way(2)
    integer, allocatable :: count_of(:)
    real(dp), allocatable :: step(:)
    integer :: i, k, n

    allocate (ends(2, 2, 0), row(0))
    associate (s => scene%settings)
      if (.not. allocated(s%row_lines)) return
      if (.not. (allocated(s%row_spacing) .or. allocated(s%row_number))) return ! `setting_rules` refuses that
      call expect(scene, 'bolt_row.length', 'bolt_row.line', s%row_length, error)
      if (allocated(error)) return
      n = size(s%row_lines)/4
      if (n == 0 .or. size(s%row_lines) /= 4*n) then
        call fail(error, status_bad_input, given_at(scene%words, 'bolt_row.line')// &
                  ': expected four numbers x1 y1 x2 y2 for each row in bolt_row.line, found '//number_text(size(s%row_lines)))
        return
      end if
      call one_for_each(scene, 'bolt_row.length', s%row_length, n, 'row of bolt_row.line', length, error)
      if (.not. allocated(error)) &
        call one_for_each(scene, 'bolt_row.direction', s%row_direction, n, 'row of bolt_row.line', direction, error)
      if (.not. allocated(error)) call find_places(scene, 'bolt_row', 'row of bolt_row.line', s%row_spacing, s%row_number, &
        [(norm2(s%row_lines(4*i - 1:4*i) - s%row_lines(4*i - 3:4*i - 2)), i=1, n)], spread(.false., 1, n), count_of, step, error)
      if (allocated(error)) return
      do i = 1, n
        associate (line => s%row_lines(4*i - 3:4*i))
          span = norm2(line(3:4) - line(1:2))
          if (.not. span > 0) then
            call fail(error, status_bad_input, given_at(scene%words, 'bolt_row.line')//': expected two ends of row '// &
                      number_text(i)//' in bolt_row.line, found one place')
            return
          end if
          along = (line(3:4) - line(1:2))/span
          way = [-along(2), along(1)]
          if (allocated(s%row_direction)) way = [cos(direction(i)*(pi/180)), sin(direction(i)*(pi/180))]
          do k = 1, count_of(i)
            associate (head => line(1:2) + (k - 1)*step(i)*along)
              ends = reshape([ends, head, head + length(i)*way], [2, 2, size(row) + 1])
            end associate
            row = [row, i]
          end do
        end associate
      end do
    end associate
  end subroutine bolts_of_rows

  !> Ends of the bolts of the rings: heads on each circle from the first angle on, all pointing away from the centre.
  !>
  !> Errors: lists of different lengths, angles that span no arc, a number of bolts that is none.
  subroutine bolts_of_rings(scene, ends, ring, error)
    type(scene_t), intent(in) :: scene
    real(dp), allocatable, intent(out) :: ends(:, :, :) !! (xy, end, n) length
    integer, allocatable, intent(out) :: ring(:)        !! (n) of which each bolt is
    type(error_t), allocatable, intent(out) :: error
    character(len=*), parameter :: each = 'ring of bolt_ring.centre'
    real(dp), allocatable :: first(:), last(:), length(:), radius(:), step(:)
    real(dp) :: angle
    integer, allocatable :: count_of(:)
    integer :: i, k, n

    allocate (ends(2, 2, 0), ring(0))
    associate (s => scene%settings)
      if (.not. allocated(s%ring_centres)) return
      if (.not. (allocated(s%ring_spacing) .or. allocated(s%ring_number))) return ! likewise
      call expect(scene, 'bolt_ring.radius', 'bolt_ring.centre', s%ring_radius, error)
      if (.not. allocated(error)) call expect(scene, 'bolt_ring.length', 'bolt_ring.centre', s%ring_length, error)
      if (allocated(error)) return
      n = size(s%ring_centres)/2
      if (n == 0 .or. size(s%ring_centres) /= 2*n) then
        call fail(error, status_bad_input, given_at(scene%words, 'bolt_ring.centre')// &
                  ': expected two numbers x y for each ring in bolt_ring.centre, found '//number_text(size(s%ring_centres)))
        return
      end if
      call one_for_each(scene, 'bolt_ring.radius', s%ring_radius, n, each, radius, error)
      if (.not. allocated(error)) call one_for_each(scene, 'bolt_ring.length', s%ring_length, n, each, length, error)
      if (.not. allocated(error)) call one_for_each(scene, 'bolt_ring.from', s%ring_from, n, each, first, error)
      if (.not. allocated(error)) call one_for_each(scene, 'bolt_ring.to', s%ring_to, n, each, last, error)
      if (allocated(error)) return
      if (.not. allocated(s%ring_to)) last = first + turn
      i = findloc(last > first .and. last - first <= turn, .false., 1)
      if (i > 0) then
        call fail(error, status_bad_input, given_at(scene%words, 'bolt_ring.to')// &
                  ': expected bolt_ring.to above bolt_ring.from by at most 360 in ring '//number_text(i)//', found '// &
                  real_text(first(i))//' and '//real_text(last(i)))
        return
      end if
      call find_places(scene, 'bolt_ring', each, s%ring_spacing, s%ring_number, (last - first)*(pi/180)*radius, &
                       .not. last - first < turn, count_of, step, error)
      if (allocated(error)) return
      do i = 1, n
        associate (centre => s%ring_centres(2*i - 1:2*i))
          do k = 1, count_of(i)
            angle = first(i)*(pi/180) + (k - 1)*step(i)/radius(i)
            ends = reshape([ends, centre + radius(i)*[cos(angle), sin(angle)], &
                            centre + (radius(i) + length(i))*[cos(angle), sin(angle)]], [2, 2, size(ring) + 1])
            ring = [ring, i]
          end do
        end associate
      end do
    end associate
  end subroutine bolts_of_rings

  !> How many bolts each pattern has, and their distance: as many as fit at a spacing, or so many from end to end. Around a full
  !> circle the last bolt is a distance from the first.
  subroutine find_places(scene, group, each, spacing, number, span, closed, count_of, step, error)
    type(scene_t), intent(in) :: scene
    character(len=*), intent(in) :: group, each
    real(dp), allocatable, intent(in) :: spacing(:), number(:) !! one of both is there
    real(dp), intent(in) :: span(:)                     !! (n) from the first place to the end, length
    logical, intent(in) :: closed(:)                    !! (n) a full circle
    integer, allocatable, intent(out) :: count_of(:)    !! (n)
    real(dp), allocatable, intent(out) :: step(:)       !! (n) length
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: name
    real(dp), allocatable :: given(:), found(:)
    integer :: i

    name = group//'.spacing'
    if (allocated(number)) name = group//'.number'
    if (allocated(number)) then
      call one_for_each(scene, name, number, size(span), each, given, error)
    else
      call one_for_each(scene, name, spacing, size(span), each, given, error)
    end if
    if (allocated(error)) return
    found = given
    step = given
    if (allocated(number)) then
      step = span/max(1.0_dp, merge(given, given - 1, closed))
    else
      found = merge(aint(span/given*(1 + rounding)), aint(span/given*(1 + rounding)) + 1, closed)
      found = max(1.0_dp, found)
    end if
    i = findloc(abs(found - anint(found)) > 0 .or. found > most_bolts, .true., 1)
    if (i > 0) then
      call fail(error, status_bad_input, given_at(scene%words, name)//': expected '//name//' that makes a whole number of '// &
                'bolts, at most '//number_text(most_bolts)//', found '//real_text(given(i)))
      return
    end if
    count_of = nint(found)
  end subroutine find_places

  !> Error where a list that a pattern needs is not there.
  subroutine expect(scene, name, place, given, error)
    type(scene_t), intent(in) :: scene
    character(len=*), intent(in) :: name, place         !! of the setting that is needed, and of that which has the places
    real(dp), allocatable, intent(in) :: given(:)
    type(error_t), allocatable, intent(out) :: error

    if (.not. allocated(given)) &
      call fail(error, status_bad_input, given_at(scene%words, place)//': expected '//name//' with '//place//', found none')
  end subroutine expect

  !> A number for each of some things, from a list of one for each, or of one for all; 0 without a list. Errors: another length.
  subroutine one_for_each(scene, name, given, n, each, values, error)
    type(scene_t), intent(in) :: scene
    character(len=*), intent(in) :: name                !! of the setting
    real(dp), allocatable, intent(in) :: given(:)
    integer, intent(in) :: n
    character(len=*), intent(in) :: each                !! what there is a number for
    real(dp), allocatable, intent(out) :: values(:)     !! (n)
    type(error_t), allocatable, intent(out) :: error

    allocate (values(n), source=0.0_dp)
    if (.not. allocated(given)) return
    if (size(given) == 1) then
      values = given(1)
    else if (size(given) == n) then
      values = given
    else
      call fail(error, status_bad_input, given_at(scene%words, name)//': expected '//name//' with one number or '// &
                number_text(n)//', one for each '//each//', found '//number_text(size(given)))
    end if
  end subroutine one_for_each

end module scree_bolt_patterns
