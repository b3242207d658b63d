!> Tips of cracks whose stress intensity a scene asks for.
module scree_measured_tips
  use scree_block_input, only: blocks_t
  use scree_crack_tip, only: crack_tip_t
  use scree_crack_tips, only: find_tips
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_scene, only: line_t, scene_t
  use scree_setting_table, only: given_at
  use scree_text, only: number_text, place_text, short_text
  use scree_tip_disc, only: lay_discs, radius_of_disc
  implicit none
  private
  public :: measure_tips

  real(dp), parameter :: least_along = 4.0_dp  !! triangles along a crack, from its tip to where it ends or branches
  real(dp), parameter :: least_radius = 1.5_dp !! of a disc, over the side of a triangle

contains

  !> Finds the tips of a model and lays their discs. Errors: no crack, one that the mesh does not resolve.
  subroutine measure_tips(scene, blocks, model, cover, error)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(model_t), intent(inout) :: model
    real(dp), intent(in) :: cover(:, :)          !! (2, n_covers) nodes of the covers at the start, length
    type(error_t), allocatable, intent(out) :: error
    type(crack_tip_t), allocatable :: tips(:)
    real(dp) :: gradient(3, size(scene%block_material))
    integer :: i

    call find_tips(blocks, model, model%start, cover, tips)
    if (size(tips) == 0) then
      call fail(error, status_bad_input, given_at(scene%words, 'output.cracks')// &
                ': expected a joint that ends inside a block with output.cracks, found none')
      return
    end if
    do i = 1, size(tips)
      call check_tip(scene, model, tips(i), error)
      if (allocated(error)) return
    end do
    do i = 1, size(scene%block_material)
      gradient(:, i) = scene%block_material(i)%stress_gradient
    end do
    call lay_discs(model, gradient, tips)
    call move_alloc(tips, model%tip)
  end subroutine measure_tips

  !> Error where the mesh is too coarse for a tip.
  subroutine check_tip(scene, model, tip, error)
    type(scene_t), intent(in) :: scene
    type(model_t), intent(in) :: model
    type(crack_tip_t), intent(in) :: tip
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: found
    real(dp) :: along

    along = norm2(tip%path(:, size(tip%path, 2)) - tip%place)/tip%edge
    if (along < least_along) then
      found = short_text(along)//' along it'
    else if (radius_of_disc(tip) < least_radius*tip%edge) then
      found = short_text(tip%to_tip/tip%edge)//' from the next tip'
    else
      return
    end if
    call fail(error, status_bad_input, source_of(scene, model, tip)//': expected triangles that resolve the crack with output.'// &
              'cracks, at least '//number_text(nint(least_along))//' along it and 2 from tip to tip, found '//found// &
              ' at its tip at '//place_text(tip%place + model%origin, model%extent, digits=4)//' (edge '//short_text(tip%edge)//')')
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
