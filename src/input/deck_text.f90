!> A deck as text: its numbers one after the other, then its named groups; each with the line it stands in.
!>
!> Numbers are separated by blanks, commas and line ends; line ends mean nothing more, as in Shi's programs. Text from
!> `!` or `#` to the end of a line is a comment. The groups begin at the first word that begins with `&`.
!>
!> Numbers have a range, so that nothing that is made of them overflows: squares of forces and fourth powers of lengths are
!> the largest.
module scree_deck_text
  use scree_deck_options, only: deck_options_t, find_option
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_file_bytes, only: read_bytes
  use scree_files, only: is_directory
  use scree_kinds, only: dp, i8
  use scree_text, only: number_text, real_of, real_text
  implicit none
  private
  public :: beyond_arithmetic, count_numbers, deck_t, expect, expect_at, expect_end, find_words, first_of_line, has_comma, &
            in_quotes, next_count, next_index, next_real, next_reals, next_word, numbers_left, read_deck, read_text, word_after, &
            word_at, word_is_real, word_is_whole

  real(dp), parameter :: largest_number = 1e20_dp   !! magnitude, of every real number
  real(dp), parameter :: smallest_number = 1e-20_dp !! of one that may not be negative, unless it is 0

  !> Hint beside the error of a deck with decimal commas, which make two numbers of one.
  character(len=*), parameter, public :: comma_remark = ' (a comma parts two numbers; the decimal sign is a point)'

  !> Words that are numbers, in their order, and where the groups begin.
  type :: deck_t
    character(len=:), allocatable :: name  !! of the file
    character(len=:), allocatable :: text  !! all of it, line ends as LF
    integer :: n_words = 0                 !! words before the groups
    integer, allocatable :: first(:)       !! (n_words) position in the text
    integer, allocatable :: last(:)        !! (n_words)
    integer, allocatable :: line(:)        !! (n_words) line in the file
    integer :: at = 0                      !! words read
    integer :: groups_from = 0             !! position of the first `&`, past the end where there is none
    integer :: groups_line = 0             !! and its line
    integer :: n_lines = 0                 !! of the file
    integer :: first_comma = 0             !! position of the first comma between two digits, before the groups; 0: none
    type(deck_options_t) :: options        !! numbers of the command line, over those of the text
    integer :: option = 0                  !! the one that the number read last came from; 0: the text
  end type deck_t

  character(len=1), parameter :: lf = achar(10), cr = achar(13), tab = achar(9)
  character(len=*), parameter :: digits = '0123456789'
  character(len=*), parameter :: utf8_mark = char(239)//char(187)//char(191) !! byte order marks
  character(len=*), parameter :: utf16_marks(2) = [char(255)//char(254), char(254)//char(255)]
  character(len=*), parameter :: hdf5_mark = char(137)//'HDF'
  integer, parameter :: longest_file = 1000000000 !! bytes

contains

  !> Reads a file and finds its words. Errors: it cannot be read, or is not text.
  subroutine read_deck(name, deck, error, kind)
    character(len=*), intent(in) :: name
    type(deck_t), intent(out) :: deck
    type(error_t), allocatable, intent(out) :: error
    character(len=*), intent(in), optional :: kind !! of file; deck where absent

    deck%name = name
    call read_text(name, deck%text, error, kind)
    if (allocated(error)) return
    call find_words(deck)
    if (deck%n_words == 0) return
    if (deck%text(deck%first(1):deck%first(1)) /= '<') return
    if (index(deck%text, '</DDA>') > 0 .or. index(deck%text, ':DDA>') > 0) then ! the end of its root, with a namespace or without
      call fail(error, status_bad_input, name//':'//number_text(deck%line(1))//': expected plain text, found DDAML, '// &
                'the XML of ntdda: tools/ddaml2deck writes such files as decks')
    else
      call fail(error, status_bad_input, name//':'//number_text(deck%line(1))//': expected plain text, found XML or HTML: '// &
                in_quotes(deck%text(deck%first(1):deck%last(1))))
    end if
  end subroutine read_deck

  !> The whole of a text file, with line ends as LF. Errors: it cannot be read, or holds bytes that are no text.
  subroutine read_text(name, text, error, kind)
    character(len=*), intent(in) :: name
    character(len=:), allocatable, intent(out) :: text
    type(error_t), allocatable, intent(out) :: error
    character(len=*), intent(in), optional :: kind !! of file, deck where absent
    character(len=:), allocatable :: expected, raw
    integer :: begin, i, line, n
    logical :: there

    expected = name//': expected a deck'
    if (present(kind)) expected = name//': expected a '//kind
    if (is_directory(name)) then
      call fail(error, status_bad_input, expected//', found a directory')
      return
    end if
    inquire (file=name, exist=there)
    if (.not. there) then
      call fail(error, status_bad_input, expected//', found no such file')
      return
    end if
    call read_bytes(name, longest_file, raw, there)
    if (.not. there) then
      call fail(error, status_bad_input, expected//' that can be read, found one that the system does not give')
      return
    else if (len(raw) > longest_file) then
      call fail(error, status_bad_input, expected//' of at most 1e9 bytes, found more')
      return
    end if
    begin = 1
    if (index(raw, utf8_mark) == 1) begin = 1 + len(utf8_mark)
    if (any(index(raw(:min(2, len(raw))), utf16_marks) == 1)) then
      call fail(error, status_bad_input, name//':1: expected text in UTF-8 or ASCII, found UTF-16')
      return
    else if (index(raw, hdf5_mark) == 1) then
      call fail(error, status_bad_input, expected//', found a file of HDF5, as results are')
      return
    end if

    allocate (character(len=len(raw)) :: text)
    n = 0
    line = 1
    do i = begin, len(raw)
      if (raw(i:i) == cr) then
        if (i < len(raw)) then
          if (raw(i + 1:i + 1) == lf) cycle
        end if
        n = n + 1
        text(n:n) = lf
      else if (iachar(raw(i:i)) < 32 .and. raw(i:i) /= lf .and. raw(i:i) /= tab .or. iachar(raw(i:i)) == 127) then
        call fail(error, status_bad_input, name//':'//number_text(line)//': expected text, found the byte '// &
                  number_text(iachar(raw(i:i))))
        return
      else
        n = n + 1
        text(n:n) = raw(i:i)
      end if
      if (text(n:n) == lf) line = line + 1
    end do
    text = text(:n)
  end subroutine read_text

  !> Finds the words before the groups.
  pure subroutine find_words(deck)
    type(deck_t), intent(inout) :: deck
    integer :: i, pass
    logical :: in_word, in_comment
    character(len=1) :: c

    do pass = 1, 2 ! count, then keep
      if (pass == 2) allocate (deck%first(deck%n_words), deck%last(deck%n_words), deck%line(deck%n_words))
      deck%n_words = 0
      deck%n_lines = 1
      deck%groups_from = len(deck%text) + 1
      in_word = .false.
      in_comment = .false.
      do i = 1, len(deck%text)
        c = deck%text(i:i)
        if (c == lf) then
          in_comment = .false.
          in_word = .false.
          deck%n_lines = deck%n_lines + 1
        else if (in_comment) then
          cycle
        else if (c == '!' .or. c == '#') then
          in_comment = .true.
          in_word = .false.
        else if (is_gap(c)) then
          if (in_word .and. c == ',' .and. deck%first_comma == 0 .and. i < len(deck%text)) then
            if (verify(deck%text(i - 1:i - 1)//deck%text(i + 1:i + 1), digits) == 0) deck%first_comma = i
          end if
          in_word = .false.
        else if (.not. in_word) then
          if (c == '&') then
            deck%groups_from = i
            deck%groups_line = deck%n_lines
            exit
          end if
          in_word = .true.
          deck%n_words = deck%n_words + 1
          if (pass == 2) then
            deck%first(deck%n_words) = i
            deck%line(deck%n_words) = deck%n_lines
          end if
        end if
        if (in_word .and. pass == 2) deck%last(deck%n_words) = i
      end do
    end do
    do i = deck%groups_from, len(deck%text)
      if (deck%text(i:i) == lf) deck%n_lines = deck%n_lines + 1
    end do
  end subroutine find_words

  !> Whether a character separates words.
  pure logical function is_gap(c)
    character(len=1), intent(in) :: c

    is_gap = c == ' ' .or. c == tab .or. c == ','
  end function is_gap

  !> Words before the groups.
  pure integer function count_numbers(deck)
    type(deck_t), intent(in) :: deck

    count_numbers = deck%n_words
  end function count_numbers

  !> Words not yet read.
  pure integer function numbers_left(deck)
    type(deck_t), intent(in) :: deck

    numbers_left = deck%n_words - deck%at
  end function numbers_left

  !> Next word as it is. Errors: the words have ended.
  subroutine next_word(deck, what, word, error)
    type(deck_t), intent(inout) :: deck
    character(len=*), intent(in) :: what   !! it is, for the error
    character(len=:), allocatable, intent(out) :: word
    type(error_t), allocatable, intent(out) :: error

    call take_word(deck, what, word, error)
  end subroutine next_word

  !> Next word, or the word of the command line in its place.
  subroutine take_word(deck, what, word, error, name)
    type(deck_t), intent(inout) :: deck
    character(len=*), intent(in) :: what
    character(len=:), allocatable, intent(out) :: word
    type(error_t), allocatable, intent(out) :: error
    character(len=*), intent(in), optional :: name !! that the command line may give it by

    call need_word(deck, what, error)
    if (allocated(error)) return
    deck%at = deck%at + 1
    deck%option = 0
    if (present(name)) call find_option(deck%options, name, deck%option)
    if (deck%option > 0) then
      word = deck%options%option(deck%option)%value
    else
      word = deck%text(deck%first(deck%at):deck%last(deck%at))
    end if
  end subroutine take_word

  !> Next number as a real.
  !>
  !> Errors: the numbers have ended, this is none, it is outside [least, most], or not above or below, or beyond the
  !> arithmetic.
  subroutine next_real(deck, what, value, error, least, above, most, below, name)
    type(deck_t), intent(inout) :: deck
    character(len=*), intent(in) :: what   !! it is, for the error
    real(dp), intent(out) :: value
    type(error_t), allocatable, intent(out) :: error
    real(dp), intent(in), optional :: least, above, most, below
    character(len=*), intent(in), optional :: name !! of it in its thing, as ma|density, for --set
    character(len=:), allocatable :: range, word
    real(dp) :: lower

    value = 0.0_dp
    call take_word(deck, what, word, error, name)
    if (allocated(error)) return
    if (.not. word_is_real(word)) then
      call expect(deck, 'a number for '//what, in_quotes(word), error)
      return
    end if
    value = real_of(word)
    lower = -largest_number
    if (present(least)) lower = least
    if (present(above)) lower = above
    range = beyond_arithmetic(value, lower)
    if (present(least)) then
      if (value < least) range = 'at least '//real_text(least)
    end if
    if (present(above)) then
      if (value <= above) range = 'above '//real_text(above)
    end if
    if (len(range) == 0 .and. present(most)) then
      if (value > most) range = 'at most '//real_text(most)
    end if
    if (len(range) == 0 .and. present(below)) then
      if (value >= below) range = 'below '//real_text(below)
    end if
    if (len(range) > 0) call expect(deck, what//' '//range, in_quotes(word), error)
  end subroutine next_real

  !> Requirement that a number breaks, in words, because arithmetic would fail; '' where it breaks none.
  pure function beyond_arithmetic(value, lower) result(range)
    real(dp), intent(in) :: value
    real(dp), intent(in) :: lower !! bound of it; from 0 up, a number that is not 0 may be divided by
    character(len=:), allocatable :: range

    range = ''
    if (lower >= 0 .and. value > 0 .and. value < smallest_number) &
      range = 'at least '//real_text(smallest_number)//' where it is not 0'
    if (abs(value) > largest_number) range = 'of magnitude up to '//real_text(largest_number)
  end function beyond_arithmetic

  !> Next numbers as reals.
  subroutine next_reals(deck, what, value, error, names)
    type(deck_t), intent(inout) :: deck
    character(len=*), intent(in) :: what
    real(dp), intent(out) :: value(:)
    type(error_t), allocatable, intent(out) :: error
    character(len=*), intent(in), optional :: names(:) !! of each in their thing, for --set
    integer :: i

    do i = 1, size(value)
      if (present(names)) then
        call next_real(deck, what, value(i), error, name=trim(names(i)))
      else
        call next_real(deck, what, value(i), error)
      end if
      if (allocated(error)) return
    end do
  end subroutine next_reals

  !> Next number as a count of things that follow, each `each` numbers: refused where the deck cannot hold them.
  subroutine next_count(deck, what, each, value, error, least)
    type(deck_t), intent(inout) :: deck
    character(len=*), intent(in) :: what
    integer, intent(in) :: each
    integer, intent(out) :: value
    type(error_t), allocatable, intent(out) :: error
    integer, intent(in), optional :: least !! 0 where absent

    call next_index(deck, what, value, error, least)
    if (allocated(error)) return
    if (int(value, i8)*each > numbers_left(deck)) &
      call expect(deck, 'at most '//number_text(numbers_left(deck))//' numbers for '//what// &
                  ', as the deck holds no more', &
                  number_text(value)//' times '//number_text(each), error)
  end subroutine next_count

  !> Next number as a whole number.
  subroutine next_index(deck, what, value, error, least, most, name)
    type(deck_t), intent(inout) :: deck
    character(len=*), intent(in) :: what
    integer, intent(out) :: value
    type(error_t), allocatable, intent(out) :: error
    integer, intent(in), optional :: least !! 0 where absent
    integer, intent(in), optional :: most
    character(len=*), intent(in), optional :: name !! of it in its thing, for --set
    character(len=:), allocatable :: word
    integer :: lowest

    value = 0
    call take_word(deck, what, word, error, name)
    if (allocated(error)) return
    lowest = 0
    if (present(least)) lowest = least
    if (.not. word_is_whole(word)) then
      call expect(deck, 'a whole number of at most nine digits for '//what, in_quotes(word), error)
      return
    end if
    read (word, *) value
    if (value < lowest) then
      call expect(deck, what//' at least '//number_text(lowest), in_quotes(word), error)
    else if (present(most)) then
      if (value > most) call expect(deck, what//' at most '//number_text(most), in_quotes(word), error)
    end if
  end subroutine next_index

  !> Error where the numbers have ended.
  subroutine need_word(deck, what, error)
    type(deck_t), intent(in) :: deck
    character(len=*), intent(in) :: what
    type(error_t), allocatable, intent(out) :: error

    if (deck%at < deck%n_words) return
    call fail(error, status_bad_input, deck%name//':'// &
              number_text(merge(deck%groups_line, deck%n_lines, deck%groups_line > 0))//': expected '//what// &
              ', found the end of the numbers'//remark_on_commas(deck, len(deck%text)))
  end subroutine need_word

  !> Error at the word read last: file, line, expected, found; or the option that gave it in place of the line.
  pure subroutine expect(deck, expected, found, error)
    type(deck_t), intent(in) :: deck
    character(len=*), intent(in) :: expected, found
    type(error_t), allocatable, intent(out) :: error

    if (deck%option > 0) then
      call fail(error, status_bad_input, '--set '//deck%options%option(deck%option)%text//': expected '//expected// &
                ', found '//found//comma_remark(:merge(len(comma_remark), 0, index(found, ',') > 0)))
    else
      call fail(error, status_bad_input, deck%name//':'//number_text(deck%line(max(deck%at, 1)))//': expected '//expected// &
                ', found '//found//remark_on_commas(deck, deck%last(max(deck%at, 1))))
    end if
  end subroutine expect

  !> Error at one of the words, wherever the reader is.
  pure subroutine expect_at(deck, number, expected, found, error)
    type(deck_t), intent(in) :: deck
    integer, intent(in) :: number          !! of the word, from 1
    character(len=*), intent(in) :: expected, found
    type(error_t), allocatable, intent(out) :: error

    call fail(error, status_bad_input, deck%name//':'//number_text(deck%line(number))//': expected '//expected// &
              ', found '//found)
  end subroutine expect_at

  !> The word that many after the one read last as it is, '' past the end.
  pure function word_after(deck, number) result(word)
    type(deck_t), intent(in) :: deck
    integer, intent(in) :: number          !! from 1
    character(len=:), allocatable :: word

    word = ''
    if (number <= numbers_left(deck)) word = deck%text(deck%first(deck%at + number):deck%last(deck%at + number))
  end function word_after

  !> A word in quotes.
  pure function word_at(deck, number)
    type(deck_t), intent(in) :: deck
    integer, intent(in) :: number          !! of the word, from 1
    character(len=:), allocatable :: word_at

    word_at = in_quotes(deck%text(deck%first(number):deck%last(number)))
  end function word_at

  !> Whether a word is the first one of its line.
  elemental logical function first_of_line(deck, number)
    type(deck_t), intent(in) :: deck
    integer, intent(in) :: number          !! of the word, from 1

    first_of_line = number == 1
    if (.not. first_of_line) first_of_line = deck%line(number) /= deck%line(number - 1)
  end function first_of_line

  !> Whether a comma between two digits parts words of a range.
  pure logical function has_comma(deck, first, last)
    type(deck_t), intent(in) :: deck
    integer, intent(in) :: first, last     !! words, from 1
    integer :: k

    has_comma = .false.
    do k = first + 1, last
      if (deck%first(k) /= deck%last(k - 1) + 2) cycle
      if (deck%text(deck%last(k - 1) + 1:deck%last(k - 1) + 1) /= ',') cycle
      has_comma = verify(deck%text(deck%last(k - 1):deck%last(k - 1))//deck%text(deck%first(k):deck%first(k)), digits) == 0
      if (has_comma) return
    end do
  end function has_comma

  !> The remark on decimal commas where there may have been one before a position.
  pure function remark_on_commas(deck, position) result(remark)
    type(deck_t), intent(in) :: deck
    integer, intent(in) :: position
    character(len=:), allocatable :: remark

    remark = ''
    if (deck%first_comma > 0 .and. deck%first_comma <= position + 1) &
      remark = comma_remark
  end function remark_on_commas

  !> Error where numbers are left over.
  pure subroutine expect_end(deck, error)
    type(deck_t), intent(inout) :: deck
    type(error_t), allocatable, intent(out) :: error

    if (deck%at == deck%n_words) return
    deck%at = deck%at + 1
    deck%option = 0
    call expect(deck, 'the end of the numbers', in_quotes(deck%text(deck%first(deck%at):deck%last(deck%at))), error)
  end subroutine expect_end

  !> Whether a word is a number, however large: digits, point, exponent with e or d.
  pure logical function word_is_real(word)
    character(len=*), intent(in) :: word
    integer :: i, mantissa_end, point

    word_is_real = .false.
    if (len(word) == 0) return
    i = 1
    if (scan(word(1:1), '+-') > 0) i = 2
    mantissa_end = scan(word, 'eEdD') - 1
    if (mantissa_end < 0) then
      mantissa_end = len(word)
    else
      if (.not. word_is_whole(word(mantissa_end + 2:))) return
    end if
    if (verify(word(i:mantissa_end), digits//'.') > 0) return
    point = index(word(i:mantissa_end), '.')
    if (point /= index(word(i:mantissa_end), '.', back=.true.)) return
    word_is_real = mantissa_end - i + 1 > merge(1, 0, point > 0)
  end function word_is_real

  !> Whether a word is a whole number of at most nine digits.
  pure logical function word_is_whole(word)
    character(len=*), intent(in) :: word
    integer :: i

    i = 1
    if (len(word) > 0) then
      if (scan(word(1:1), '+-') > 0) i = 2
    end if
    word_is_whole = len(word) >= i .and. len(word) < i + 9 .and. verify(word(i:), digits) == 0
  end function word_is_whole

  !> A word in quotes, shortened.
  pure function in_quotes(word)
    character(len=*), intent(in) :: word
    character(len=:), allocatable :: in_quotes
    integer, parameter :: most = 40

    if (len(word) > most) then
      in_quotes = "'"//word(:most)//"...'"
    else
      in_quotes = "'"//word//"'"
    end if
  end function in_quotes

end module scree_deck_text
