!> The named groups of a deck, and the stages that they belong to.
module scree_deck_groups
  use scree_deck_text, only: deck_t
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_named_groups, only: forget_groups, given_word, group_begins, groups_end, groups_t, name_has_value, next_known_item, &
                                refuse_second, start_groups
  use scree_scene, only: word_t
  use scree_setting_table, only: blank_words, deck_part_t, put_word, setting_t
  use scree_settings, only: settings_table
  implicit none
  private
  public :: read_groups

contains

  !> Reads the groups of a deck, in parts: before its first &stage, and from each &stage to the next.
  !>
  !> Errors: an unknown group or name, twice the same in a part, a value of the wrong kind or range, one that no stage may change.
  subroutine read_groups(deck, parts, error, only)
    type(deck_t), intent(in) :: deck
    type(deck_part_t), allocatable, intent(out) :: parts(:)
    type(error_t), allocatable, intent(out) :: error
    character(len=*), intent(in), optional :: only(:)  !! groups that this deck may have; all where absent
    type(word_t), allocatable :: blank(:)
    type(setting_t), allocatable :: table(:)
    type(groups_t) :: groups
    type(word_t) :: given
    integer :: i
    logical :: later

    table = settings_table()
    blank = blank_words(table)
    if (present(only)) table = pack(table, [(any(only == table(i)%group), i=1, size(table))])
    parts = [deck_part_t(blank)]
    call start_groups(deck, groups)
    do
      call next_known_item(deck, table, groups, error)
      if (allocated(error)) return
      select case (groups%item)
      case (groups_end)
        return
      case (group_begins)
        if (groups%group == 'stage') then
          parts = [parts, deck_part_t(blank)]
          call forget_groups(groups)
        end if
        call refuse_second(deck, groups, 'each group once, or once in each stage', 'a second &'//groups%group, error)
        if (allocated(error)) return
      case (name_has_value)
        given = given_word(deck, groups)
        later = size(parts) > 1
        call put_word(table, given%from//': ', given, parts(size(parts))%words, error, later)
        if (allocated(error)) return
        if (later .and. holds_for_the_run(given%name)) then
          call fail(error, status_bad_input, given%from//': expected '//given%name//' before the first &stage, as no stage '// &
                    'changes it, found it in a later one')
          return
        end if
      end select
    end do
  end subroutine read_groups

  !> Whether a setting is the same in all stages, because it determines the blocks or the form of the state.
  pure logical function holds_for_the_run(name)
    character(len=*), intent(in) :: name   !! group.name
    character(len=12) :: group

    group = name(:index(name, '.') - 1)
    holds_for_the_run = any(group == [character(len=12) :: 'deck', 'units', 'method', 'cover', 'blocks', 'fixed_points', &
                                                         'in_situ', 'excavation']) .or. &
                        any(name == [character(len=17) :: 'contact.method', 'contact.rules', 'contact.adapt', 'contact.initial', &
                                     'bolts.limit', 'output.checkpoint', 'output.cracks'])
  end function holds_for_the_run

end module scree_deck_groups
