!> Named groups as text, `&name key=value, ... /`, item by item: a group begins, a name has a value, a group ends.
module scree_named_groups
  use scree_deck_text, only: deck_t, in_quotes, word_is_real
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_scene, only: word_t
  use scree_setting_table, only: known_groups, setting_t
  use scree_text, only: number_text
  implicit none
  private
  public :: forget_groups, given_word, groups_t, next_known_item, refuse_second, start_groups

  !> State of the reading.
  integer, parameter, public :: group_begins = 1, name_has_value = 2, group_ends = 3, groups_end = 4

  !> The reading, and the item that it has come to.
  type :: groups_t
    integer :: item = 0
    character(len=:), allocatable :: group !! its name
    character(len=:), allocatable :: word  !! where a group begins: as it stands in the deck
    integer :: group_line = 0
    character(len=:), allocatable :: name  !! where a name has a value
    character(len=:), allocatable :: value !! a text, or numbers with single blanks between them
    integer :: line = 0                    !! of the item
    integer, private :: at = 0
    integer, private :: at_line = 0
    character(len=:), allocatable, private :: begun !! names of the groups that may not begin again, each between blanks
  end type groups_t

  character(len=1), parameter :: lf = achar(10), tab = achar(9)
  character(len=*), parameter :: name_letters = 'abcdefghijklmnopqrstuvwxyz_0123456789'

contains

  !> Begins before the first group.
  pure subroutine start_groups(deck, groups)
    type(deck_t), intent(in) :: deck
    type(groups_t), intent(out) :: groups

    groups%item = group_ends
    groups%group = ''
    groups%word = ''
    groups%name = ''
    groups%value = ''
    groups%begun = ' '
    groups%at = deck%groups_from
    groups%at_line = max(deck%groups_line, 1)
    groups%line = groups%at_line
  end subroutine start_groups

  !> Goes on to the next item of groups that a table knows. Errors: text that is none, a group that the table lacks.
  subroutine next_known_item(deck, table, groups, error)
    type(deck_t), intent(in) :: deck
    type(setting_t), intent(in) :: table(:)
    type(groups_t), intent(inout) :: groups
    type(error_t), allocatable, intent(out) :: error

    call next_item(deck, groups, error)
    if (allocated(error) .or. groups%item /= group_begins) return
    if (all(table%group /= groups%group)) &
      call wrong_item(deck, groups, 'one of the groups '//known_groups(table), in_quotes(groups%word), error)
  end subroutine next_known_item

  !> Error where the group that begins has begun before.
  subroutine refuse_second(deck, groups, expected, found, error)
    type(deck_t), intent(in) :: deck
    type(groups_t), intent(inout) :: groups
    character(len=*), intent(in) :: expected, found
    type(error_t), allocatable, intent(out) :: error

    if (index(groups%begun, ' '//groups%group//' ') > 0) then
      call wrong_item(deck, groups, expected, found, error)
    else
      groups%begun = groups%begun//groups%group//' '
    end if
  end subroutine refuse_second

  !> Forgets which groups have begun: a part of the deck begins that may have each once more.
  pure subroutine forget_groups(groups)
    type(groups_t), intent(inout) :: groups

    groups%begun = ' '
  end subroutine forget_groups

  !> The name that has a value, as group.name, and where it stands.
  pure function given_word(deck, groups) result(given)
    type(deck_t), intent(in) :: deck
    type(groups_t), intent(in) :: groups
    type(word_t) :: given

    given%name = groups%group//'.'//groups%name
    given%value = groups%value
    given%from = deck%name//':'//number_text(groups%line)
  end function given_word

  !> Goes on to the next item. Errors: text that is none.
  subroutine next_item(deck, groups, error)
    type(deck_t), intent(in) :: deck
    type(groups_t), intent(inout) :: groups
    type(error_t), allocatable, intent(out) :: error

    associate (text => deck%text, at => groups%at, line => groups%at_line)
      call skip_gaps(text, at, line)
      groups%line = line
      if (groups%item == group_ends) then
        if (at > len(text)) then
          groups%item = groups_end
          return
        end if
        if (text(at:at) /= '&') then
          call wrong_item(deck, groups, "'&' and the name of a group", in_quotes(rest_of_word(text, at)), error)
          return
        end if
        at = at + 1
        groups%item = group_begins
        groups%group = next_name(text, at)
        groups%word = '&'//groups%group//rest_of_word(text, at)
        groups%group_line = line
        return
      end if
      if (at > len(text)) then
        call wrong_item(deck, groups, '''/'' at the end of &'//groups%group//' of line '//number_text(groups%group_line), &
                        'the end of the deck', error)
        return
      end if
      if (text(at:at) == '/') then
        at = at + 1
        groups%item = group_ends
        return
      end if
      groups%item = name_has_value
      groups%name = next_name(text, at)
      if (len(groups%name) == 0) then
        call wrong_item(deck, groups, 'a name or ''/'' in &'//groups%group, in_quotes(rest_of_word(text, at)), error)
        return
      end if
      call skip_gaps(text, at, line)
      if (at > len(text)) then
        call wrong_item(deck, groups, '''='' after '//groups%name, 'the end of the deck', error)
        return
      end if
      if (text(at:at) /= '=') then
        call wrong_item(deck, groups, '''='' after '//groups%name, in_quotes(rest_of_word(text, at)), error)
        return
      end if
      at = at + 1
      call next_value(text, at, line, groups%value, error)
      if (allocated(error)) then
        groups%line = line
        error%message = here(deck, groups)//error%message
      end if
    end associate
  end subroutine next_item

  !> Error at the item.
  subroutine wrong_item(deck, groups, expected, found, error)
    type(deck_t), intent(in) :: deck
    type(groups_t), intent(in) :: groups
    character(len=*), intent(in) :: expected, found
    type(error_t), allocatable, intent(out) :: error

    call fail(error, status_bad_input, here(deck, groups)//'expected '//expected//', found '//found)
  end subroutine wrong_item

  !> File and line of the item.
  function here(deck, groups)
    type(deck_t), intent(in) :: deck
    type(groups_t), intent(in) :: groups
    character(len=:), allocatable :: here

    here = deck%name//':'//number_text(min(groups%line, deck%n_lines))//': '
  end function here

  !> Skips blanks, commas, line ends and comments.
  pure subroutine skip_gaps(text, at, line)
    character(len=*), intent(in) :: text
    integer, intent(inout) :: at, line
    logical :: comment

    comment = .false.
    do while (at <= len(text))
      if (text(at:at) == lf) then
        line = line + 1
        comment = .false.
      else if (scan(text(at:at), '!#') > 0) then
        comment = .true.
      else if (.not. comment .and. scan(text(at:at), ' ,'//tab) == 0) then
        return
      end if
      at = at + 1
    end do
  end subroutine skip_gaps

  !> Reads a name, in lower case.
  function next_name(text, at) result(name)
    character(len=*), intent(in) :: text
    integer, intent(inout) :: at
    character(len=:), allocatable :: name
    character(len=1) :: c

    name = ''
    do while (at <= len(text))
      c = text(at:at)
      if (c >= 'A' .and. c <= 'Z') c = achar(iachar(c) + 32)
      if (scan(c, name_letters) == 0) return
      name = name//c
      at = at + 1
    end do
  end function next_name

  !> Reads a quoted text, a bare word, or numbers up to the next name.
  subroutine next_value(text, at, line, value, error)
    character(len=*), intent(in) :: text
    integer, intent(inout) :: at, line
    character(len=:), allocatable, intent(out) :: value
    type(error_t), allocatable, intent(out) :: error
    integer :: close, before, before_line, n
    character(len=:), allocatable :: buffer, word

    value = ''
    call skip_gaps(text, at, line)
    if (at > len(text)) return
    if (scan(text(at:at), '''"') > 0) then
      close = scan(text(at + 1:), text(at:at)//lf)
      if (close > 0) then
        if (text(at + close:at + close) == lf) close = 0
      end if
      if (close == 0) then
        call fail(error, status_bad_input, 'expected a closing '//text(at:at)//' on the same line, found '// &
                  in_quotes(rest_of_word(text, at)))
        return
      end if
      value = text(at + 1:at + close - 1)
      at = at + close + 1
      return
    end if
    allocate (character(len=len(text) - at + 1) :: buffer) ! holds all words with a blank between them
    n = 0
    do ! one word, and as many numbers more as follow
      before = at
      before_line = line
      call skip_gaps(text, at, line)
      word = rest_of_word(text, at)
      if (len(word) == 0) exit
      if (n > 0 .and. .not. word_is_real(word)) then
        at = before
        line = before_line
        exit
      end if
      at = at + len(word)
      if (n > 0) then
        n = n + 1
        buffer(n:n) = ' '
      end if
      buffer(n + 1:n + len(word)) = word
      n = n + len(word)
      if (.not. word_is_real(word)) exit
    end do
    value = buffer(:n)
  end subroutine next_value

  !> Text up to the next gap, comment, '=' or '/'.
  pure function rest_of_word(text, at)
    character(len=*), intent(in) :: text
    integer, intent(in) :: at
    character(len=:), allocatable :: rest_of_word
    integer :: length

    rest_of_word = ''
    if (at > len(text)) return
    length = scan(text(at:), ' ,!#=/'//tab//lf) - 1
    if (length < 0) length = len(text) - at + 1
    rest_of_word = text(at:at + length - 1)
  end function rest_of_word

end module scree_named_groups
