!> Blocks that overlap when a run begins: said, and refused where they do by more than the deck allows.
!>
!> Contacts that are found inside rest there (`contact_memory`): an overlap that is allowed stays without force until the
!> blocks part, and no block gains energy from it.
module scree_initial_overlaps
  use scree_block_input, only: block_source, blocks_t
  use scree_contacts, only: overlap_t
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_kinds, only: dp
  use scree_scene, only: scene_t
  use scree_system, only: system_t
  use scree_text, only: number_text, place_text, real_text, short_text, text_t
  implicit none
  private
  public :: overlap_texts, overlap_warning, refuse_overlaps

contains

  !> Error where blocks overlap deeper than `contact.initial`, or cross so that no vertex of either is in the other; or at all
  !> under a mathematical mesh, which cuts every block by the outlines of all.
  subroutine refuse_overlaps(scene, blocks, system, error)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    class(system_t), intent(in) :: system
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: expected
    real(dp) :: most
    integer :: deepest, n

    if (.not. allocated(system%overlaps)) return
    most = scene%settings%initial_overlap
    expected = 'blocks that overlap by at most '//real_text(most)//' of the smaller (contact.initial)'
    if (system%n_elements > system%n_blocks) then
      most = 0.0_dp
      expected = 'blocks that do not overlap under a mathematical mesh'
    end if
    associate (too_deep => system%overlaps%share > most .or. system%overlaps%crossing)
      n = count(too_deep)
      if (n == 0) return
      deepest = maxloc(merge(1.0_dp, system%overlaps%share, system%overlaps%crossing), 1, too_deep)
    end associate
    associate (overlap => system%overlaps(deepest))
      call fail(error, status_bad_input, block_source(scene, blocks, overlap%body(2))//': expected '//expected//', found '// &
                overlap_text(system, overlap)//others(n - 1))
    end associate
  end subroutine refuse_overlaps

  !> All overlaps in words.
  pure function overlap_texts(system) result(text)
    class(system_t), intent(in) :: system
    type(text_t), allocatable :: text(:)
    integer :: i, n

    n = 0
    if (allocated(system%overlaps)) n = size(system%overlaps)
    allocate (text(n))
    do i = 1, n
      text(i)%text = overlap_text(system, system%overlaps(i))
    end do
  end function overlap_texts

  !> The warning: one line or none.
  pure function overlap_warning(system) result(warning)
    class(system_t), intent(in) :: system
    type(text_t), allocatable :: warning(:)
    integer :: n

    n = 0
    if (allocated(system%overlaps)) n = size(system%overlaps)
    allocate (warning(min(n, 1)))
    if (n == 0) return
    warning(1)%text = 'blocks overlap at the start, without force until they part, in '//number_text(n)// &
                      ' places; the deepest: '//overlap_text(system, system%overlaps(maxloc(system%overlaps%depth, 1)))
  end function overlap_warning

  !> An overlap in words.
  pure function overlap_text(system, overlap) result(text)
    class(system_t), intent(in) :: system
    type(overlap_t), intent(in) :: overlap
    character(len=:), allocatable :: text

    text = 'blocks '//number_text(overlap%body(1))//' and '//number_text(overlap%body(2))
    if (overlap%crossing) then
      text = text//' that cross'
    else
      text = text//' by '//short_text(overlap%depth)//', '//short_text(overlap%share)//' of the smaller,'
    end if
    text = text//' at '//place_text(overlap%position + system%origin, system%extent)
  end function overlap_text

  !> How many more there are.
  pure function others(n)
    integer, intent(in) :: n
    character(len=:), allocatable :: others

    others = ''
    if (n > 0) others = ', and '//number_text(n)//' more (scree check lists them)'
  end function others

end module scree_initial_overlaps
