!> Tips of cracks, where a scene asks for their stress intensity or lets them grow.
module scree_measured_tips
  use scree_block_input, only: blocks_t
  use scree_crack_beginning, only: find_starts
  use scree_crack_tip, only: crack_start_t, crack_tip_t, short_of_end
  use scree_crack_tips, only: find_tips
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_scene, only: line_t, scene_t
  use scree_setting_table, only: given_at
  use scree_text, only: number_text, place_text, short_text
  use scree_tip_disc, only: is_measured, lay_discs
  use scree_tip_seats, only: side_at
  implicit none
  private
  public :: measure_tips

  real(dp), parameter :: least_along = 4.0_dp  !! triangles along a crack, from its tip to where it ends or branches

contains

  !> Finds the tips of a model, and lays their discs where stress intensity counts. Finds where cracks may begin, where the scene
  !> lets them. Errors: no crack that may grow and none that may begin, one that the mesh does not resolve. Cracks that have grown
  !> are not judged: a run goes on when one ends or comes near another.
  subroutine measure_tips(scene, blocks, model, cover, error)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(model_t), intent(inout) :: model
    real(dp), intent(in) :: cover(:, :)          !! (2, n_covers) nodes of the covers at the start, length
    type(error_t), allocatable, intent(out) :: error
    type(crack_start_t), allocatable :: starts(:)
    type(crack_tip_t), allocatable :: tips(:)
    character(len=:), allocatable :: asks
    real(dp), allocatable :: back(:)
    real(dp) :: gradient(3, size(scene%block_material))
    integer :: i

    call find_tips(blocks, model, model%start, cover, tips)
    if (scene%settings%crack_begin_joint > 0) then
      call find_starts(blocks, model, model%start, cover, starts)
      call move_alloc(starts, model%crack_start)
    end if
    asks = 'cracks.strength'
    if (allocated(scene%settings%crack_toughness)) asks = 'cracks.toughness'
    if (scene%settings%measures_tips) asks = 'output.cracks'
    if (blocks%n_grown == 0 .and. size(tips) == 0 .and. scene%settings%crack_begin_joint == 0) then
      call fail(error, status_bad_input, given_at(scene%words, asks)//': expected a joint that ends inside a block or '// &
                'cracks.begin_joint with '//asks//', found none')
      return
    end if
    if (asks /= 'cracks.strength') then
      if (blocks%n_grown == 0) call check_tips(scene, model, asks, tips, error)
      if (allocated(error)) return
      do i = 1, size(scene%block_material)
        gradient(:, i) = scene%block_material(i)%stress_gradient
      end do
      back = [(max(0.0_dp, short_of_end*side_at(scene, tips(i)%end + model%origin) - norm2(tips(i)%end - tips(i)%place)), &
               i=1, size(tips))]
      if (allocated(model%sampling)) back = 0.0_dp ! of second order, which are less stiff
      call lay_discs(model, back, gradient, tips)
    end if
    call move_alloc(tips, model%tip)
  end subroutine measure_tips

  !> Error where the mesh is too coarse for any tip.
  subroutine check_tips(scene, model, asks, tips, error)
    type(scene_t), intent(in) :: scene
    type(model_t), intent(in) :: model
    character(len=*), intent(in) :: asks         !! setting that asks for stress intensity
    type(crack_tip_t), intent(in) :: tips(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    do i = 1, size(tips)
      call check_tip(scene, model, asks, tips(i), error)
      if (allocated(error)) return
    end do
  end subroutine check_tips

  !> Error where the mesh is too coarse for a tip.
  subroutine check_tip(scene, model, asks, tip, error)
    type(scene_t), intent(in) :: scene
    type(model_t), intent(in) :: model
    character(len=*), intent(in) :: asks
    type(crack_tip_t), intent(in) :: tip
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: found
    real(dp) :: along, side

    side = side_at(scene, tip%end + model%origin)
    along = norm2(tip%path(:, size(tip%path, 2)) - tip%place)/side
    if (along < least_along) then
      found = short_text(along)//' along it'
    else if (.not. is_measured(tip)) then
      side = tip%edge ! which its disc follows
      found = short_text(tip%to_tip/side)//' from the next tip'
    else
      return
    end if
    call fail(error, status_bad_input, source_of(scene, model, tip)//': expected triangles that resolve the crack with '//asks// &
              ', at least '//number_text(nint(least_along))//' along it and 2 from tip to tip, found '//found// &
              ' at its tip at '//place_text(tip%place + model%origin, model%extent, digits=4)//' (edge '//short_text(side)//')')
  end subroutine check_tip

  !> Line of the geometry deck that a tip belongs to: the nearest one.
  pure function source_of(scene, model, tip) result(source)
    type(scene_t), intent(in) :: scene
    type(model_t), intent(in) :: model
    type(crack_tip_t), intent(in) :: tip
    character(len=:), allocatable :: source
    real(dp) :: distance, nearest
    integer :: i, line

    nearest = huge(nearest)
    line = 0
    do i = 1, size(scene%lines)
      distance = way_round(scene%lines(i), tip%place + model%origin)
      if (distance < nearest) line = i
      nearest = min(nearest, distance)
    end do
    source = scene%geometry_name
    if (line > 0) source = source//':'//number_text(scene%lines(line)%deck_line)
  end function source_of

  !> What the way from end to end of a line grows by over a place, length.
  pure real(dp) function way_round(line, place)
    type(line_t), intent(in) :: line
    real(dp), intent(in) :: place(2)             !! length

    way_round = norm2(line%ends(:, 1) - place) + norm2(line%ends(:, 2) - place) - norm2(line%ends(:, 2) - line%ends(:, 1))
  end function way_round

end module scree_measured_tips
