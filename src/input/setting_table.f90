!> Table of the names of named groups, and the values that a deck gives to them.
!>
!> A word is the text that a name has, with where it comes from; errors, `explain` and the results print it as it stands.
module scree_setting_table
  use scree_deck_text, only: beyond_arithmetic, comma_remark, in_quotes, word_is_real, word_is_whole
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_kinds, only: dp
  use scree_old_settings, only: name_now
  use scree_scene, only: word_t
  use scree_text, only: real_of, real_text
  implicit none
  private
  public :: blank_words, deck_part_t, choice_at, choice_number, choices_text, from_of, full_name, given_at, index_of, is_given_by, &
            known_groups, put_word, setting_t

  integer, parameter, public :: kind_text = 1, kind_choice = 2, kind_real = 3, kind_whole = 4, kind_reals = 5
  real(dp), parameter :: boundless = huge(1.0_dp)

  !> Description of one name.
  type :: setting_t
    character(len=16) :: group
    character(len=20) :: name
    character(len=110) :: meaning
    character(len=24) :: dimension = ''  !! of a number
    real(dp) :: least = -boundless       !! range of a number
    real(dp) :: most = boundless
    logical :: open = .false.            !! `least` itself is not allowed
    character(len=100) :: choices = ''    !! of a choice, each between bars
    character(len=140) :: default = ''    !! in words, where it is not one value; a table that is listed has words in each row
    logical :: needed = .false.          !! its group has to give it
    integer :: kind = 0                  !! set where the table is listed
  end type setting_t

  !> Values in a part of a deck: before its first &stage, or from one &stage to the next.
  type :: deck_part_t
    type(word_t), allocatable :: words(:) !! in the order of the table
  end type deck_part_t

  !> Value with which a stage removes the value of a name that is no choice.
  character(len=*), parameter, public :: taken_away = 'none'

contains

  !> Words without a value, for all rows of a table or for those of a group.
  pure function blank_words(table, group) result(words)
    type(setting_t), intent(in) :: table(:)
    character(len=*), intent(in), optional :: group
    type(word_t), allocatable :: words(:) !! in the order of the table
    logical :: mine(size(table))
    integer :: i, n

    mine = .true.
    if (present(group)) mine = table%group == group
    allocate (words(count(mine)))
    n = 0
    do i = 1, size(table)
      if (.not. mine(i)) cycle
      n = n + 1
      words(n)%name = full_name(table(i))
    end do
  end function blank_words

  !> Gives a word its value. Errors: an unknown name or one of yesterday, one twice, a value of the wrong kind or range.
  subroutine put_word(table, where, given, words, error, later)
    type(setting_t), intent(in) :: table(:)
    character(len=*), intent(in) :: where       !! begins the text of an error
    type(word_t), intent(in) :: given           !! named group.name
    type(word_t), intent(inout) :: words(:)     !! all or some of those of the table
    type(error_t), allocatable, intent(out) :: error
    logical, intent(in), optional :: later      !! of a stage, which may take values away
    character(len=:), allocatable :: group, name
    integer :: i, row
    logical :: checks

    group = given%name(:index(given%name, '.') - 1)
    name = given%name(index(given%name, '.') + 1:)
    if (all(table%group /= group)) then
      call fail(error, status_bad_input, where//'expected one of the groups '//known_groups(table)//', found '//in_quotes(group))
      return
    end if
    row = findloc(table%group == group .and. table%name == name, .true., 1)
    if (row == 0 .and. len(name_now(given%name, given%value)) > 0) then
      call fail(error, status_bad_input, where//'expected a present name, found '//given%name//': '// &
                name_now(given%name, given%value))
      return
    end if
    if (row == 0) then
      call fail(error, status_bad_input, where//'expected one of the names '//known_names(table, group)// &
                ' in &'//group//', found '//in_quotes(name))
      return
    end if
    i = index_of(words, full_name(table(row)))
    if (allocated(words(i)%value)) then
      call fail(error, status_bad_input, where//'expected each name once, found a second '//name//' in &'//group)
      return
    end if
    checks = .true.
    if (present(later)) checks = .not. (later .and. given%value == taken_away .and. table(row)%kind /= kind_choice)
    if (checks) call check_value(where//'expected ', table(row), given%value, error)
    if (allocated(error)) return
    words(i)%value = given%value
    words(i)%from = given%from
  end subroutine put_word

  !> Error where a value does not fit its row of the table.
  subroutine check_value(expected, setting, value, error)
    character(len=*), intent(in) :: expected
    type(setting_t), intent(in) :: setting
    character(len=*), intent(in) :: value
    type(error_t), allocatable, intent(out) :: error

    select case (setting%kind)
    case (kind_text)
      if (len_trim(value) == 0) call wrong(expected, 'a name for '//full_name(setting), value, error)
    case (kind_choice)
      if (choice_number(setting%choices, value) == 0) &
        call wrong(expected, 'one of '//choices_text(setting%choices)//' for '//full_name(setting), value, error)
    case (kind_whole)
      if (word_is_whole(value)) then
        call check_range(expected, setting, real_of(value), value, error)
      else
        call wrong(expected, 'a whole number of at most nine digits for '//full_name(setting), value, error)
      end if
    case default
      call check_numbers(expected, setting, value, error)
    end select
  end subroutine check_value

  !> Error where a value is not one number, or several, as the table asks for.
  subroutine check_numbers(expected, setting, value, error)
    character(len=*), intent(in) :: expected
    type(setting_t), intent(in) :: setting
    character(len=*), intent(in) :: value
    type(error_t), allocatable, intent(out) :: error
    integer :: from, to

    from = 1
    do
      to = index(value(from:), ' ') + from - 2
      if (to < from) to = len(value)
      if (.not. word_is_real(value(from:to))) then
        call wrong(expected, 'a number for '//full_name(setting), value, error, &
                   comma_remark(:merge(len(comma_remark), 0, index(value, ',') > 0)))
      else if (setting%kind == kind_real .and. to < len(value)) then
        call wrong(expected, 'one number for '//full_name(setting), value, error, comma_remark)
      else
        call check_range(expected, setting, real_of(value(from:to)), value, error)
      end if
      if (allocated(error) .or. to == len(value)) return
      from = to + 2
    end do
  end subroutine check_numbers

  !> Error where a number of a value is out of its range.
  subroutine check_range(expected, setting, x, value, error)
    character(len=*), intent(in) :: expected
    type(setting_t), intent(in) :: setting
    real(dp), intent(in) :: x
    character(len=*), intent(in) :: value
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: range

    range = beyond_arithmetic(x, setting%least)
    if (len(range) == 0 .and. (x < setting%least .or. (setting%open .and. x <= setting%least) .or. x > setting%most)) &
      range = range_text(setting)
    if (len(range) > 0) call wrong(expected, full_name(setting)//' '//range, value, error)
  end subroutine check_range

  !> Error at a value.
  pure subroutine wrong(expected, what, value, error, remark)
    character(len=*), intent(in) :: expected, what, value
    type(error_t), allocatable, intent(out) :: error
    character(len=*), intent(in), optional :: remark

    call fail(error, status_bad_input, expected//what//', found '//in_quotes(value))
    if (present(remark)) error%message = error%message//remark
  end subroutine wrong

  !> A range in words.
  pure function range_text(setting)
    type(setting_t), intent(in) :: setting
    character(len=:), allocatable :: range_text

    if (setting%open) then
      range_text = 'above '//real_text(setting%least)
    else
      range_text = 'at least '//real_text(setting%least)
    end if
    if (setting%most < boundless) range_text = range_text//' and at most '//real_text(setting%most)
  end function range_text

  !> The groups of a table, in words.
  pure function known_groups(table)
    type(setting_t), intent(in) :: table(:)
    character(len=:), allocatable :: known_groups
    integer :: i

    known_groups = '&'//trim(table(1)%group)
    do i = 2, size(table)
      if (table(i)%group /= table(i - 1)%group) known_groups = known_groups//', &'//trim(table(i)%group)
    end do
  end function known_groups

  !> The names of a group of a table, in words.
  pure function known_names(table, group)
    type(setting_t), intent(in) :: table(:)
    character(len=*), intent(in) :: group
    character(len=:), allocatable :: known_names
    integer :: i

    known_names = ''
    do i = 1, size(table)
      if (table(i)%group == group) known_names = known_names//', '//trim(table(i)%name)
    end do
    known_names = known_names(3:)
  end function known_names

  !> '|a|b|' as 'a, b'.
  pure function choices_text(choices)
    character(len=*), intent(in) :: choices
    character(len=:), allocatable :: choices_text
    integer :: i

    choices_text = ''
    do i = 2, len_trim(choices) - 1
      if (choices(i:i) == '|') then
        choices_text = choices_text//', '
      else
        choices_text = choices_text//choices(i:i)
      end if
    end do
  end function choices_text

  !> Which of the choices '|a|b|' a word is, 0 where it is none.
  pure integer function choice_number(choices, word)
    character(len=*), intent(in) :: choices, word
    integer :: at, i

    choice_number = 0
    if (len(word) == 0 .or. index(word, '|') > 0) return
    at = index(choices, '|'//word//'|')
    choice_number = count([(choices(i:i) == '|', i=1, at)])
  end function choice_number

  !> The choice of a number.
  pure function choice_at(choices, number) result(word)
    character(len=*), intent(in) :: choices
    integer, intent(in) :: number
    character(len=:), allocatable :: word
    integer :: i

    word = trim(choices(2:))
    do i = 2, number
      word = word(index(word, '|') + 1:)
    end do
    word = word(:index(word, '|') - 1)
  end function choice_at

  !> group.name
  pure function full_name(setting)
    type(setting_t), intent(in) :: setting
    character(len=:), allocatable :: full_name

    full_name = trim(setting%group)//'.'//trim(setting%name)
  end function full_name

  !> Place of group.name among words, 0 where it is not there.
  pure integer function index_of(words, name)
    type(word_t), intent(in) :: words(:)
    character(len=*), intent(in) :: name
    integer :: i

    index_of = 0
    do i = 1, size(words)
      if (words(i)%name == name) index_of = i
    end do
  end function index_of

  !> Whether a deck or the command line gives a word its value.
  pure logical function is_given_by(word)
    type(word_t), intent(in) :: word

    is_given_by = .false.
    if (allocated(word%value)) is_given_by = word%from /= 'default'
  end function is_given_by

  !> Where group.name has its value from: a deck's name and line, --set, default; '' where it has none.
  pure function from_of(words, name) result(place)
    type(word_t), intent(in) :: words(:)
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: place
    integer :: i

    place = ''
    i = index_of(words, name)
    if (i == 0) return
    if (allocated(words(i)%value)) place = words(i)%from
  end function from_of

  !> Where group.name is given, for the text of an error: a deck's name and line, or --set and its name; '' where it is not.
  pure function given_at(words, name) result(place)
    type(word_t), intent(in) :: words(:)
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: place

    place = from_of(words, name)
    if (place == '--set') place = '--set '//name
    if (place == 'default') place = ''
  end function given_at

end module scree_setting_table
