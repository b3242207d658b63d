!> The rows of a deck, and the line of it that alone explains a wrong count of numbers.
!>
!> Line ends mean nothing to a reader of numbers, so a number too many or too few shifts all that follow it. But a person writes
!> the numbers of one thing in lines of their own, and a line that does not end where a row ends shows the place of the mistake.
module scree_deck_rows
  use scree_deck_text, only: comma_remark, count_numbers, deck_t, expect_at, first_of_line, has_comma, word_at
  use scree_errors, only: error_t
  use scree_text, only: number_text
  implicit none
  private
  public :: add_row, begin_rows, blame_line, deck_rows_t, fits_lines

  integer, parameter :: longest_name = 8, longest_thing = 40

  !> The numbers that a deck should have, in their order, and where its lines may end.
  type :: deck_rows_t
    integer :: n = 0                                      !! numbers so far
    character(len=longest_name), allocatable :: name(:)   !! (expected) of each number
    character(len=longest_thing), allocatable :: thing(:) !! (expected) that has it, '' for the head of the deck
    logical, allocatable :: ends(:)                       !! (0:expected) whether a line may end behind each number
    integer :: head = 0                                   !! numbers of the head, behind which a line ends
  end type deck_rows_t

contains

  !> Begins the rows of a deck that should have `expected` numbers.
  pure subroutine begin_rows(expected, rows)
    integer, intent(in) :: expected
    type(deck_rows_t), intent(out) :: rows

    allocate (rows%name(expected), rows%thing(expected), rows%ends(0:expected))
    rows%ends = .false.
    rows%ends(0) = .true.
  end subroutine begin_rows

  !> Adds a row. Its numbers stand in one line, or in several where the row is loose.
  pure subroutine add_row(names, thing, rows, is_loose)
    character(len=*), intent(in) :: names(:)      !! of its numbers
    character(len=*), intent(in) :: thing         !! that has them, as 'block material 2'; '' for the head of the deck
    type(deck_rows_t), intent(inout) :: rows
    logical, intent(in), optional :: is_loose
    integer :: last

    last = rows%n + size(names)
    rows%name(rows%n + 1:last) = names
    rows%thing(rows%n + 1:last) = thing
    if (present(is_loose)) rows%ends(rows%n + 1:last) = is_loose
    rows%ends(last) = .true.
    rows%n = last
    if (len(thing) == 0) rows%head = last
  end subroutine add_row

  !> Whether all lines of a deck end where rows do, and one of them where the head does.
  pure logical function fits_lines(deck, rows)
    type(deck_t), intent(in) :: deck
    type(deck_rows_t), intent(in) :: rows
    integer, allocatable :: last(:)

    last = ends_of_lines(deck)
    fits_lines = all(may_end(rows, last)) .and. any(last == rows%head)
  end function fits_lines

  !> Error at the line without which, or with more numbers in which, the others end where rows do; none where no line alone does.
  !>
  !> Of several such lines the one with a comma between two digits is taken, else the last.
  pure subroutine blame_line(deck, rows, remark, error)
    type(deck_t), intent(in) :: deck
    type(deck_rows_t), intent(in) :: rows
    character(len=*), intent(in) :: remark                 !! behind what was found
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: last(:)
    integer :: first, k, surplus, wrong
    logical :: fits_after

    last = ends_of_lines(deck)
    surplus = count_numbers(deck) - rows%n
    wrong = 0
    fits_after = .true.
    do k = size(last), 1, -1
      first = 1
      if (k > 1) first = last(k - 1) + 1
      fits_after = fits_after .and. may_end(rows, last(k) - surplus)
      if (.not. fits_after) exit
      if (.not. all(may_end(rows, last(:k - 1)))) cycle
      if (.not. is_of_one_thing(rows, first, last(k) - max(surplus, 0))) cycle
      if (wrong == 0 .or. (surplus > 0 .and. has_comma(deck, first, last(k)))) wrong = k
      if (surplus <= 0 .or. has_comma(deck, first, last(k))) exit
    end do
    if (wrong == 0) return
    first = 1
    if (wrong > 1) first = last(wrong - 1) + 1
    if (surplus > 0) then
      call too_many(deck, rows, first, last(wrong), surplus, remark, error)
    else
      call too_few(deck, rows, last(wrong), remark, error)
    end if
  end subroutine blame_line

  !> Error at a line that has more numbers than its row, or that is no row at all.
  pure subroutine too_many(deck, rows, first, last, surplus, remark, error)
    type(deck_t), intent(in) :: deck
    type(deck_rows_t), intent(in) :: rows
    integer, intent(in) :: first, last  !! numbers of the line
    integer, intent(in) :: surplus      !! of them
    character(len=*), intent(in) :: remark
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: expected, found
    integer :: wanted

    wanted = last - first + 1 - surplus
    if (first > rows%n) then
      expected = 'the end of the numbers'
    else if (wanted > 0) then
      expected = number_text(wanted)//' numbers in this line ('//names_of(rows, first, first + wanted - 1)//')'
    else
      expected = 'the row '//row_of(rows, first)
    end if
    found = number_text(last - first + 1)
    if (has_comma(deck, first, last)) found = found//comma_remark
    call expect_at(deck, last, expected, found//remark, error)
  end subroutine too_many

  !> Error at a line that ends within a row, or behind which a row is missing.
  pure subroutine too_few(deck, rows, last, remark, error)
    type(deck_t), intent(in) :: deck
    type(deck_rows_t), intent(in) :: rows
    integer, intent(in) :: last         !! number of the line
    character(len=*), intent(in) :: remark
    type(error_t), allocatable, intent(out) :: error

    if (last == count_numbers(deck)) then
      call expect_at(deck, last, missing(last + 1), 'the end of the numbers'//remark, error)
    else if (rows%ends(last) .and. last >= rows%head) then
      call expect_at(deck, last + 1, 'the row '//row_of(rows, last + 1), word_at(deck, last + 1)//remark, error)
    else
      call expect_at(deck, last, missing(last + 1), 'the end of the line'//remark, error)
    end if

  contains

    !> A number that is missing, in words.
    pure function missing(k)
      integer, intent(in) :: k
      character(len=:), allocatable :: missing
      integer :: first

      first = k
      do while (first > 1)
        if (rows%thing(first - 1) /= rows%thing(k)) exit
        if (rows%ends(first - 1) .and. first - 1 >= rows%head) exit
        first = first - 1
      end do
      missing = trim(rows%name(k))//', number '//number_text(k - first + 1)//' of the row '//row_of(rows, first)
    end function missing

  end subroutine too_few

  !> The row that begins with a number, in words.
  pure function row_of(rows, first) result(row)
    type(deck_rows_t), intent(in) :: rows
    integer, intent(in) :: first
    character(len=:), allocatable :: row
    integer :: last

    last = first
    if (first <= rows%head) last = rows%head
    do while (.not. rows%ends(last))
      last = last + 1
    end do
    row = names_of(rows, first, last)
  end function row_of

  !> A thing, and the names of its numbers.
  pure function names_of(rows, first, last) result(names)
    type(deck_rows_t), intent(in) :: rows
    integer, intent(in) :: first, last
    character(len=:), allocatable :: names
    integer :: k

    names = ''
    do k = first, last
      names = names//' '//trim(rows%name(k))
    end do
    if (len_trim(rows%thing(first)) > 0) names = names//' of '//trim(rows%thing(first))
    names = names(2:)
  end function names_of

  !> Whether numbers belong to one thing; none do.
  pure logical function is_of_one_thing(rows, first, last)
    type(deck_rows_t), intent(in) :: rows
    integer, intent(in) :: first, last

    is_of_one_thing = last < first
    if (is_of_one_thing .or. last > rows%n) return
    is_of_one_thing = all(rows%thing(first:last) == rows%thing(first))
  end function is_of_one_thing

  !> Whether a line may end behind a number.
  elemental logical function may_end(rows, last)
    type(deck_rows_t), intent(in) :: rows
    integer, intent(in) :: last

    may_end = .false.
    if (last >= 0 .and. last <= rows%n) may_end = rows%ends(last)
  end function may_end

  !> The last number of each line that has some.
  pure function ends_of_lines(deck) result(last)
    type(deck_t), intent(in) :: deck
    integer, allocatable :: last(:)
    integer :: k

    last = [pack([(k - 1, k=2, count_numbers(deck))], [(first_of_line(deck, k), k=2, count_numbers(deck))]), count_numbers(deck)]
  end function ends_of_lines

end module scree_deck_rows
