!> Joint sets: from their deck to a geometry deck.
module scree_joints
  use scree_block_input, only: blocks_t, joined_text, make_blocks, scale_of_lines
  use scree_deck_text, only: read_text
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_files, only: expect_regular, holds_something, refuse_to_replace, same_file
  use scree_geometry_deck, only: write_geometry_deck
  use scree_joint_sets, only: draw_joints
  use scree_joints_deck, only: joints_t, read_joints_deck
  use scree_kinds, only: dp
  use scree_progress, only: check_told, progress_t, set_up_progress, tell, warn
  use scree_rock_outline, only: boundary_lines, hole_points, rock_t
  use scree_scene, only: line_t, scene_t
  use scree_text, only: number_text
  implicit none
  private
  public :: make_joints

  character(len=*), parameter :: remark = 'scree joints ' !! that the geometry ends with, and the deck

contains

  !> Reads a deck of joint sets, draws them and writes a geometry deck: the boundary first, then the joints set by set.
  !>
  !> Errors: bad input, with its line; a file that cannot be written.
  subroutine make_joints(deck_path, geometry_path, quiet, error)
    character(len=*), intent(in) :: deck_path, geometry_path
    logical, intent(in) :: quiet
    type(error_t), allocatable, intent(out) :: error
    type(joints_t) :: joints
    type(scene_t) :: scene
    type(blocks_t) :: blocks
    type(progress_t) :: progress
    type(line_t), allocatable :: boundary(:), traces(:)
    real(dp) :: shortest
    character(len=:), allocatable :: counts
    integer :: i

    if (same_file(geometry_path, deck_path)) then
      call fail(error, status_bad_input, geometry_path//': expected another file for the geometry, found the deck of joint sets')
      return
    end if
    call expect_regular(geometry_path, 'the geometry', error)
    if (allocated(error)) return
    if (.not. may_replace(geometry_path)) then
      call refuse_to_replace(geometry_path, 'a geometry of scree joints', error)
      return
    end if
    call read_joints_deck(deck_path, joints, scene, error)
    if (allocated(error)) return
    call boundary_lines(joints%rock, boundary)
    if (size(boundary) == 0) then
      call fail(error, status_bad_input, deck_path//':'//number_text(joints%rock%outline(1)%deck_line)// &
                ': expected rock left in the &window, found all of it cut out')
      return
    end if
    shortest = scene%least_distance*scale_of_lines(boundary) ! the cutter takes a shorter joint for a point
    call draw_joints(joints%rock, joints%sets, joints%seed, shortest, traces)
    scene%lines = [boundary, traces]
    scene%n_boundary = size(boundary)
    call hole_points(joints%rock, scene%hole_points)

    counts = number_text(size(boundary))//' boundary lines, '//number_text(size(traces))//' joints of '// &
             number_text(size(joints%sets))//' sets, seed '//number_text(joints%seed)
    if (scene%settings%least_block_area > 0) then
      scene%geometry_name = geometry_path
      call make_blocks(scene, blocks, error)
      if (allocated(error)) return
      counts = counts//'; '//joined_text(blocks, scene)
    end if
    call write_geometry_deck(geometry_path, scene, remark//deck_path//': '//counts, error)
    if (allocated(error)) return
    call set_up_progress(quiet, progress)
    do i = 1, size(joints%warning)
      call warn(progress, joints%warning(i)%text)
    end do
    call tell(progress, geometry_path//': '//counts)
    call check_told(progress, geometry_path, error)
  end subroutine make_joints

  !> Whether a geometry may take the place of a file: it holds nothing, or a geometry that was drawn here, which its remark says.
  logical function may_replace(path)
    character(len=*), intent(in) :: path
    character(len=:), allocatable :: text
    type(error_t), allocatable :: error

    may_replace = .not. holds_something(path)
    if (may_replace) return
    call read_text(path, text, error)
    if (.not. allocated(error)) may_replace = index(text, '! '//remark) > 0
  end function may_replace

end module scree_joints
