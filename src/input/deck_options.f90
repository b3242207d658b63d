!> Numbers of a deck that `--set` gives: THING.NAME=VALUE, such as joint(1).phi=30, in place of the numbers of the deck.
!>
!> The reader of a deck names what it reads: a thing, and then its numbers. A value of `--set` replaces the word of the deck there,
!> so it is checked as that word would be. A value that no reader asked for is an error at the end.
module scree_deck_options
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_text, only: in_lower_case, number_text
  implicit none
  private
  public :: add_option, begin_thing, check_all_taken, deck_options_t, find_option, is_of_deck

  !> Things that have numbers, by name; each but `deck` is followed by an index.
  character(len=*), parameter :: kinds(*) = [character(len=14) :: 'deck', 'material', 'joint', 'line', 'material_line', &
    'bolt', 'fixed_line', 'hole_point', 'fixed_point', 'load_point', 'measured_point']

  !> A number that `--set` gives.
  type :: deck_option_t
    character(len=:), allocatable :: text    !! THING.NAME=VALUE as given
    character(len=:), allocatable :: thing   !! joint(1)
    character(len=:), allocatable :: name    !! phi
    character(len=:), allocatable :: value
    character(len=:), allocatable :: offered !! names that the thing has, as the readers said them
    logical :: taken = .false.
  end type deck_option_t

  !> All values of `--set`, and which of them readers have used.
  type :: deck_options_t
    type(deck_option_t), allocatable :: option(:)   !! not allocated: none are given, and nothing is looked for
    character(len=:), allocatable :: thing     !! that is being read
    character(len=:), allocatable :: also      !! another name of it, or ''
    integer :: n(size(kinds)) = 0              !! things of each kind so far
  end type deck_options_t

contains

  !> Whether a name, of --set, is that of a number of a deck and not of a setting.
  pure logical function is_of_deck(name)
    character(len=*), intent(in) :: name
    integer :: n

    n = scan(name, '(.') - 1
    is_of_deck = any(kinds == name(:max(n, 0)))
  end function is_of_deck

  !> Adds THING.NAME=VALUE, as lower case but for the value; the later of two with one name wins.
  pure subroutine add_option(text, options)
    character(len=*), intent(in) :: text             !! with '.' before '=', and a value
    type(deck_options_t), intent(inout) :: options
    type(deck_option_t) :: option
    character(len=:), allocatable :: name
    integer :: dot, equal

    equal = index(text, '=')
    name = in_lower_case(text(:equal - 1))
    dot = index(name, '.')
    option%text = text
    option%thing = name(:dot - 1)
    option%name = name(dot + 1:)
    option%value = text(equal + 1:)
    option%offered = ''
    if (.not. allocated(options%option)) allocate (options%option(0))
    options%option = [options%option, option]
  end subroutine add_option

  !> Says that the following numbers belong to a thing.
  pure subroutine begin_thing(options, kind, number, also)
    type(deck_options_t), intent(inout) :: options
    character(len=*), intent(in) :: kind
    integer, intent(in), optional :: number          !! of the thing, from 1; absent where there is but one
    character(len=*), intent(in), optional :: also   !! another kind under which its numbers are found too
    integer :: k

    if (.not. allocated(options%option)) return
    k = findloc(kinds == kind, .true., 1)
    options%thing = kind
    options%also = ''
    if (present(number)) then
      options%n(k) = max(options%n(k), number)
      options%thing = kind//'('//number_text(number)//')'
      if (present(also)) options%also = also//'('//number_text(number)//')'
    end if
  end subroutine begin_thing

  !> The option that gives a number of the thing, 0 where none does.
  pure subroutine find_option(options, names, found)
    type(deck_options_t), intent(inout) :: options
    character(len=*), intent(in) :: names  !! of the number, with bars between them: ma|density
    integer, intent(out) :: found
    integer :: i

    found = 0
    if (.not. allocated(options%option)) return
    do i = 1, size(options%option)
      associate (option => options%option(i))
        if (option%thing /= options%thing .and. option%thing /= options%also) cycle
        option%offered = option%offered//', '//names
        if (index('|'//in_lower_case(names)//'|', '|'//option%name//'|') == 0) cycle
        option%taken = .true.
        found = i
      end associate
    end do
  end subroutine find_option

  !> Error where an option is of a thing or a name that the decks do not have.
  pure subroutine check_all_taken(options, error)
    type(deck_options_t), intent(in) :: options
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    if (.not. allocated(options%option)) return
    do i = 1, size(options%option)
      associate (option => options%option(i))
        if (option%taken) cycle
        if (len(option%offered) > 0) then
          call fail(error, status_bad_input, '--set '//option%text//': expected one of the numbers '//option%offered(3:)// &
                    ' of '//option%thing//', found '''//option%name//'''')
        else
          call fail(error, status_bad_input, '--set '//option%text//': expected one of '//things_of(options)// &
                    ', which the decks have, found '''//option%thing//'''')
        end if
        return
      end associate
    end do
  end subroutine check_all_taken

  !> The things that were read, in words.
  pure function things_of(options) result(things)
    type(deck_options_t), intent(in) :: options
    character(len=:), allocatable :: things
    integer :: k

    things = trim(kinds(1))
    do k = 2, size(kinds)
      if (options%n(k) > 0) things = things//', '//trim(kinds(k))//'(1'
      if (options%n(k) > 1) things = things//' to '//number_text(options%n(k))
      if (options%n(k) > 0) things = things//')'
    end do
  end function things_of

end module scree_deck_options
