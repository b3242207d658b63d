!> A table of settings is a procedure that calls each of its rows once. This module is the rows.
!>
!> A row is one call with all of a setting: the description of its name, the place of its value, and its default. So
!> a table lists itself, stores what a deck gives, and fills in defaults, each by one pass over the same calls:
!>
!>     call row%real(setting_t('step', 'size', 'largest step', 'time', 0.0_dp, open=.true., default='g1 of the deck'), &
!>                   settings%step_size, scene%step_size)
!>
!> A default is an expression of what stands before it in the deck and in the table, so there is no order to keep but that
!> of the rows. Whoever lists a table passes it a scene that is empty: the expressions have to bear that.
module scree_setting_rows
  use scree_kinds, only: dp
  use scree_scene, only: word_t
  use scree_setting_table, only: choice_at, choice_number, full_name, index_of, is_given_by, kind_choice, kind_real, kind_reals, &
                                 kind_text, kind_whole, setting_t
  use scree_text, only: number_text, real_of, real_text
  implicit none
  private
  public :: setting_rows_t

  !> Purpose of a pass over the rows.
  integer, parameter, public :: list_rows = 1, store_given = 2, fill_defaults = 3

  !> A pass over the rows of a table.
  type :: setting_rows_t
    integer :: purpose = list_rows
    type(setting_t), allocatable :: table(:) !! the rows so far, listed
    type(word_t), allocatable :: words(:)    !! as given, then with defaults; a row that is not among them is passed over
  contains
    procedure :: real => real_row
    procedure :: whole => whole_row
    procedure :: reals => reals_row
    procedure :: pair => pair_row
    procedure :: text => text_row
    procedure, private :: choice_row
    procedure, private :: either_row
    generic :: choice => choice_row, either_row
    procedure :: given
  end type setting_rows_t

contains

  !> A setting that is a number.
  subroutine real_row(row, setting, value, default, when)
    class(setting_rows_t), intent(inout) :: row
    type(setting_t), intent(in) :: setting
    real(dp), intent(inout) :: value           !! stays as it is where nothing is given and there is no default
    real(dp), intent(in), optional :: default
    logical, intent(in), optional :: when      !! only then there is a default
    character(len=:), allocatable :: text
    logical :: fills

    text = ''
    if (present(default)) text = real_text(default)
    call visit(row, setting, kind_real, when, text, fills)
    if (fills) value = default
    if (allocated(text)) value = real_of(text)
  end subroutine real_row

  !> A setting that is a whole number.
  subroutine whole_row(row, setting, value, default, when)
    class(setting_rows_t), intent(inout) :: row
    type(setting_t), intent(in) :: setting
    integer, intent(inout) :: value
    integer, intent(in), optional :: default
    logical, intent(in), optional :: when
    character(len=:), allocatable :: text
    logical :: fills

    text = ''
    if (present(default)) text = number_text(default)
    call visit(row, setting, kind_whole, when, text, fills)
    if (fills) value = default
    if (allocated(text)) value = nint(real_of(text))
  end subroutine whole_row

  !> A setting that is a list of numbers.
  subroutine reals_row(row, setting, values)
    class(setting_rows_t), intent(inout) :: row
    type(setting_t), intent(in) :: setting
    real(dp), allocatable, intent(inout) :: values(:)
    character(len=:), allocatable :: text
    logical :: fills

    text = ''
    call visit(row, setting, kind_reals, .false., text, fills)
    if (allocated(text)) values = numbers_of(text)
  end subroutine reals_row

  !> A setting that is two numbers. Other than two are not stored: who reads the table refuses them where it matters.
  subroutine pair_row(row, setting, values, default, when)
    class(setting_rows_t), intent(inout) :: row
    type(setting_t), intent(in) :: setting
    real(dp), intent(inout) :: values(2)
    real(dp), intent(in) :: default(2)
    logical, intent(in), optional :: when
    real(dp), allocatable :: numbers(:)
    character(len=:), allocatable :: text
    logical :: fills

    text = real_text(default(1))//' '//real_text(default(2))
    call visit(row, setting, kind_reals, when, text, fills)
    if (fills) values = default
    if (.not. allocated(text)) return
    numbers = numbers_of(text)
    if (size(numbers) == 2) values = numbers
  end subroutine pair_row

  !> A setting that is a text.
  subroutine text_row(row, setting, value)
    class(setting_rows_t), intent(inout) :: row
    type(setting_t), intent(in) :: setting
    character(len=:), allocatable, intent(inout) :: value
    character(len=:), allocatable :: text
    logical :: fills

    text = ''
    call visit(row, setting, kind_text, .false., text, fills)
    if (allocated(text)) value = text
  end subroutine text_row

  !> A setting with choices: its value is the number of a choice, in their order.
  subroutine choice_row(row, setting, value, default, when)
    class(setting_rows_t), intent(inout) :: row
    type(setting_t), intent(in) :: setting
    integer, intent(inout) :: value
    integer, intent(in) :: default
    logical, intent(in), optional :: when
    character(len=:), allocatable :: text
    logical :: fills

    text = choice_at(setting%choices, default)
    call visit(row, setting, kind_choice, when, text, fills)
    if (fills) value = default
    if (allocated(text)) value = choice_number(setting%choices, text)
  end subroutine choice_row

  !> A setting that is one of two choices: whether it is the second.
  subroutine either_row(row, setting, value, default, when)
    class(setting_rows_t), intent(inout) :: row
    type(setting_t), intent(in) :: setting
    logical, intent(inout) :: value
    logical, intent(in) :: default
    logical, intent(in), optional :: when
    integer :: choice

    choice = merge(2, 1, value)
    call choice_row(row, setting, choice, merge(2, 1, default), when)
    value = choice == 2
  end subroutine either_row

  !> Does with a row what the pass is for. A table lists itself; a word that is given is to be stored; a word without
  !> a value takes the default, where there is one.
  subroutine visit(row, setting, kind, when, text, fills)
    class(setting_rows_t), intent(inout) :: row
    type(setting_t), intent(in) :: setting
    integer, intent(in) :: kind
    logical, intent(in), optional :: when                      !! only then there is a default
    character(len=:), allocatable, intent(inout) :: text       !! in: the default, '' for none; out: what is to be stored, if any
    logical, intent(out) :: fills                              !! the default is to be stored
    character(len=:), allocatable :: default
    integer :: i

    call move_alloc(text, default)
    fills = .false.
    if (row%purpose == list_rows) then
      call list(row, setting, kind, default)
      return
    end if
    i = index_of(row%words, full_name(setting))
    if (i == 0) return
    associate (word => row%words(i))
      if (allocated(word%value)) then
        if (row%purpose == store_given) text = word%value
      else if (row%purpose == fill_defaults) then
        fills = len(default) > 0
        if (present(when)) fills = fills .and. when
        if (fills) word%value = default
        if (fills) word%from = 'default'
      end if
    end associate
  end subroutine visit

  !> Adds a row to the list, its default in words.
  subroutine list(row, setting, kind, default)
    class(setting_rows_t), intent(inout) :: row
    type(setting_t), intent(in) :: setting
    integer, intent(in) :: kind
    character(len=*), intent(in) :: default
    type(setting_t) :: listed

    listed = setting
    listed%kind = kind
    if (len_trim(listed%default) == 0) listed%default = default
    if (len_trim(listed%default) == 0) listed%default = 'none'
    if (.not. allocated(row%table)) allocate (row%table(0))
    row%table = [row%table, listed]
  end subroutine list

  !> Whether group.name has its value from the deck or the command line, not by default.
  pure logical function given(row, name)
    class(setting_rows_t), intent(in) :: row
    character(len=*), intent(in) :: name
    integer :: i

    given = .false.
    if (.not. allocated(row%words)) return
    i = index_of(row%words, name)
    if (i > 0) given = is_given_by(row%words(i))
  end function given

  !> Numbers of a text with single blanks between them.
  pure function numbers_of(text) result(numbers)
    character(len=*), intent(in) :: text
    real(dp), allocatable :: numbers(:)
    integer :: from, i, k

    allocate (numbers(1 + count([(text(i:i) == ' ', i=1, len(text))])))
    from = 1
    do k = 1, size(numbers)
      i = index(text(from:), ' ') + from - 2
      if (i < from) i = len(text)
      numbers(k) = real_of(text(from:i))
      from = i + 2
    end do
  end function numbers_of

end module scree_setting_rows
