!> Polygons that the geometry is cut along and stages excavate (&excavation): lines of the geometry, and polygons of
!> `stage.remove_inside`.
module scree_excavations
  use scree_bolt_patterns, only: one_for_each
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_kinds, only: dp
  use scree_scene, only: line_t, scene_t
  use scree_setting_table, only: deck_part_t, given_at, index_of
  use scree_stages, only: part_polygons
  use scree_text, only: number_text, real_text
  implicit none
  private
  public :: take_excavations

contains

  !> Adds the sides of the polygons to the lines of the geometry, and the polygons to those that the stages remove.
  !>
  !> Errors: finished blocks, which nothing cuts; corners that make no polygons; stages that are not there, or not one for each.
  subroutine take_excavations(scene, parts, error)
    type(scene_t), intent(inout) :: scene
    type(deck_part_t), intent(inout) :: parts(:)
    type(error_t), allocatable, intent(out) :: error
    real(dp), allocatable :: corner(:, :), joint(:)
    integer, allocatable :: first(:)
    integer :: begin, i, k, next, stage

    associate (s => scene%settings)
      if (.not. (allocated(s%excavated) .and. allocated(s%excavating_stages))) return
      if (allocated(scene%blocks)) then
        call fail(error, status_bad_input, given_at(scene%words, 'excavation.outline')//': expected a geometry deck of lines '// &
                  'with excavation.outline, which cuts them, found finished blocks, which '// &
                  'stage.remove_inside removes')
        return
      end if
      call part_polygons(s%excavated, corner, first)
      if (.not. allocated(first)) then
        call fail(error, status_bad_input, given_at(scene%words, 'excavation.outline')//': expected x y of corners of '// &
                  'polygons, three or more of each and its first again, in excavation.outline, found others')
        return
      end if
      call one_for_each(scene, 'excavation.joint', s%excavated_joint, size(first) - 1, 'polygon of excavation.outline', joint, &
                        error)
      if (allocated(error)) return
      if (.not. allocated(s%excavated_joint)) joint = 1.0_dp
      begin = 1
      do i = 1, size(first) - 1
        call find_stage(begin, i, stage)
        if (allocated(error)) return
        do k = first(i), first(i + 1) - 1
          next = merge(first(i), k + 1, k == first(i + 1) - 1)
          scene%lines = [scene%lines, line_t(reshape([corner(:, k), corner(:, next)], [2, 2]), nint(joint(i)), 1)]
        end do
        call remove_inside(corner(:, first(i):first(i + 1) - 1), parts(stage))
      end do
      if (begin <= len(s%excavating_stages)) call wrong_stages(number_text(size(first) - 1)//' stages, one for each polygon')
    end associate

  contains

    !> The stage of the next name between commas.
    subroutine find_stage(begin, i, stage)
      integer, intent(inout) :: begin
      integer, intent(in) :: i
      integer, intent(out) :: stage
      character(len=:), allocatable :: name
      integer :: length

      stage = 0
      associate (list => scene%settings%excavating_stages)
        if (begin > len(list)) then
          call wrong_stages('a stage for each of the '//number_text(size(first) - 1)//' polygons of excavation.outline')
          return
        end if
        length = scan(list(begin:)//',', ',') - 1
        name = trim(adjustl(list(begin:begin + length - 1)))
        begin = begin + length + 1
        do stage = size(parts), 2, -1
          if (name_of(stage) == name) return
        end do
        call fail(error, status_bad_input, given_at(scene%words, 'excavation.stage')//': expected the name of a later stage '// &
                  'for polygon '//number_text(i)//' in excavation.stage, found '''//name//'''')
      end associate
    end subroutine find_stage

    !> The name of a stage.
    function name_of(stage) result(name)
      integer, intent(in) :: stage
      character(len=:), allocatable :: name

      name = 'stage '//number_text(stage)
      associate (word => parts(stage)%words(index_of(parts(stage)%words, 'stage.name')))
        if (allocated(word%value)) name = word%value
      end associate
    end function name_of

    !> Error in the list of stages.
    subroutine wrong_stages(expected)
      character(len=*), intent(in) :: expected

      call fail(error, status_bad_input, given_at(scene%words, 'excavation.stage')//': expected '//expected// &
                ', found '''//scene%settings%excavating_stages//'''')
    end subroutine wrong_stages

    !> Adds a polygon to those that a stage removes.
    subroutine remove_inside(corner, part)
      real(dp), intent(in) :: corner(:, :)
      type(deck_part_t), intent(inout) :: part
      character(len=:), allocatable :: text
      integer :: k

      text = ''
      do k = 1, size(corner, 2) + 1
        text = text//' '//real_text(corner(1, 1 + modulo(k - 1, size(corner, 2))))//' '// &
               real_text(corner(2, 1 + modulo(k - 1, size(corner, 2))))
      end do
      associate (word => part%words(index_of(part%words, 'stage.remove_inside')))
        if (allocated(word%value)) then
          word%value = word%value//text
        else
          word%value = text(2:)
          word%from = given_at(scene%words, 'excavation.outline')
        end if
      end associate
    end subroutine remove_inside

  end subroutine take_excavations

end module scree_excavations
