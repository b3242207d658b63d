!> The rectangle of the scene, whose blocks are removed when they leave it (&scene).
module scree_scene_rectangle
  use scree_block_input, only: blocks_t
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_kinds, only: dp
  use scree_regions, only: first_vertex_of, last_vertex_of
  use scree_scene, only: scene_t
  use scree_setting_table, only: given_at
  use scree_text, only: number_text, pair_text
  implicit none
  private
  public :: check_rectangle

contains

  !> Errors: other than four numbers, corners in another order, a block outside of the rectangle when the run begins.
  subroutine check_rectangle(scene, blocks, error)
    type(scene_t), intent(in) :: scene             !! of a stage
    type(blocks_t), intent(in) :: blocks
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: where
    real(dp) :: corner(2, 2)
    integer :: b

    if (.not. allocated(scene%settings%scene_rectangle)) return
    where = given_at(scene%words, 'scene.rectangle')
    associate (given => scene%settings%scene_rectangle)
      if (size(given) /= 4) then
        call fail(error, status_bad_input, where//': expected four numbers x1 y1 x2 y2 in scene.rectangle, found '// &
                  number_text(size(given)))
        return
      end if
      corner = reshape(given, [2, 2])
    end associate
    if (.not. all(corner(:, 1) < corner(:, 2))) then
      call fail(error, status_bad_input, where//': expected the lower left and then the upper right corner in '// &
                'scene.rectangle, found '//pair_text(corner(:, 1))//' and '//pair_text(corner(:, 2)))
      return
    end if
    if (allocated(scene%settings%stage_name)) return ! by a later stage blocks have moved
    corner = corner - spread(blocks%origin, 2, 2)
    do b = 1, size(blocks%material)
      associate (outline => blocks%vertex(:, first_vertex_of(blocks%shape, b):last_vertex_of(blocks%shape, b)))
        if (all(maxval(outline, 2) >= corner(:, 1) .and. minval(outline, 2) <= corner(:, 2))) cycle
        call fail(error, status_bad_input, where//': expected each block in the rectangle of scene.rectangle when the run '// &
                  'begins, at least in part, found block '//number_text(b)//' outside')
        return
      end associate
    end do
  end subroutine check_rectangle

end module scree_scene_rectangle
