!> The named groups that a geometry may end in: those that say where something is. The analysis deck and the command line win over
!> them, name by name.
module scree_groups_of_places
  use scree_deck_groups, only: read_groups
  use scree_deck_text, only: deck_t
  use scree_errors, only: error_t
  use scree_scene, only: word_t
  use scree_setting_table, only: deck_part_t
  implicit none
  private
  public :: groups_text, take_groups

  character(len=*), parameter :: groups(*) = [character(len=9) :: 'blocks', 'bolts', 'bolt_row', 'bolt_ring', &
                                                                  'support', 'boundary', 'water']

contains

  !> Takes the groups of a geometry where nothing else gives the same name. Errors: as of `read_groups`, a group of another kind.
  subroutine take_groups(deck, words, error)
    type(deck_t), intent(in) :: deck
    type(word_t), allocatable, intent(inout) :: words(:) !! in the order of the table of settings; not allocated: none yet
    type(error_t), allocatable, intent(out) :: error
    type(deck_part_t), allocatable :: of_geometry(:)
    integer :: i

    call read_groups(deck, of_geometry, error, only=groups)
    if (allocated(error)) return
    if (.not. allocated(words)) then
      call move_alloc(of_geometry(1)%words, words)
      return
    end if
    do i = 1, size(words)
      if (.not. allocated(words(i)%value)) words(i) = of_geometry(1)%words(i)
    end do
  end subroutine take_groups

  !> The groups as a geometry ends in them, a line each; '' where no name of them has a value. What `&blocks` asks of the cutter
  !> is left out of a block file.
  pure function groups_text(words, cut) result(text)
    type(word_t), intent(in) :: words(:) !! in the order of the table of settings
    logical, intent(in) :: cut           !! for a block file
    character(len=:), allocatable :: text
    character(len=:), allocatable :: group, quote
    integer :: dot, i, k

    text = ''
    do k = merge(2, 1, cut), size(groups)
      group = ''
      do i = 1, size(words)
        if (.not. allocated(words(i)%value)) cycle
        dot = index(words(i)%name, '.')
        if (words(i)%name(:dot - 1) /= groups(k)) cycle
        quote = trim(merge("'", ' ', verify(words(i)%value(1:1), '0123456789+-.') > 0))
        group = group//' '//words(i)%name(dot + 1:)//'='//quote//words(i)%value//quote
      end do
      if (len(group) > 0) text = text//new_line('a')//'&'//trim(groups(k))//group//' /'
    end do
    text = text(2:)
  end function groups_text

end module scree_groups_of_places
