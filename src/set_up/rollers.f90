!> The points that &support holds in one direction each: ends of pieces of edges on its lines, and points of its own.
module scree_rollers
  use scree_block_finder, only: block_at, block_finder_t, set_up_finder
  use scree_edges_on_lines, only: add_point, piece_t
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_kinds, only: dp
  use scree_loaded_edges, only: find_pieces
  use scree_scene, only: scene_t, time_table_t
  use scree_setting_table, only: given_at, index_of
  use scree_state, only: state_t
  use scree_support_motions, only: directions_of
  use scree_system, only: roller_end, system_t
  use scree_text, only: number_text, place_text
  implicit none
  private
  public :: hold_edges, roller_t

  !> How a point of the system is held.
  type :: roller_t
    real(dp) :: direction(2) = 0.0_dp !! in which it is held alone; 0: it is no roller
    type(time_table_t) :: table       !! of its displacement; without times: it is held where it is
  end type roller_t

  real(dp), parameter :: x_axis(2) = [1.0_dp, 0.0_dp], y_axis(2) = [0.0_dp, 1.0_dp], of_line(2) = 0.0_dp

contains

  !> Finds the pieces that the lines of &support hold; their ends become points of the system. As displacements are linear along an
  !> edge, what is held at its ends is held all along it; of displacements of second order, what is held in its middle too.
  !>
  !> Errors: a line on which no edge lies, a point in no block.
  subroutine hold_edges(scene, system, state, roller, error)
    type(scene_t), intent(in) :: scene
    type(system_t), intent(inout) :: system
    type(state_t), intent(inout) :: state
    type(roller_t), allocatable, intent(out) :: roller(:) !! (n_points)
    type(error_t), allocatable, intent(out) :: error
    type(block_finder_t) :: finder
    real(dp), allocatable :: way(:, :)
    integer :: i, k

    allocate (roller(size(system%points%kind)))
    associate (s => scene%settings)
      call hold_lines('support.normal', s%support_normal, of_line)
      call hold_lines('support.x', s%support_x, x_axis)
      call hold_lines('support.y', s%support_y, y_axis)
      call hold_lines('support.both', s%support_both, x_axis)
      call hold_lines('support.both', s%support_both, y_axis)
      if (allocated(scene%motions)) then
        do i = 1, size(scene%motions)
          way = directions_of(scene%motions(i))
          do k = 1, size(way, 2)
            if (.not. allocated(error)) call hold_line('support.moved', i, reshape(s%support_moved(4*i - 3:4*i), [2, 2]), &
                                                       roller_t(way(:, k), left_of(scene%motions(i))))
          end do
        end do
      end if
      call hold_points('support.points', s%support_points, reshape([x_axis, y_axis], [2, 2]))
      call hold_points('support.points_x', s%support_points_x, reshape(x_axis, [2, 1]))
      call hold_points('support.points_y', s%support_points_y, reshape(y_axis, [2, 1]))
    end associate

  contains

    !> What is left of a motion: a table that stands on from the stage before has come to its end.
    pure type(time_table_t) function left_of(motion) result(left)
      type(time_table_t), intent(in) :: motion

      if (.not. scene%words(index_of(scene%words, 'support.table'))%stands_on) left = motion
    end function left_of

    !> Holds what lies on some lines in a direction; where that is 0, across them.
    subroutine hold_lines(name, lines, along)
      character(len=*), intent(in) :: name
      real(dp), allocatable, intent(in) :: lines(:)
      real(dp), intent(in) :: along(2)
      real(dp) :: line(2, 2), held(2)
      integer :: i

      if (.not. allocated(lines)) return
      do i = 1, size(lines)/4
        if (allocated(error)) return
        line = reshape(lines(4*i - 3:4*i), [2, 2])
        held = along
        if (.not. norm2(along) > 0) held = [line(2, 1) - line(2, 2), line(1, 2) - line(1, 1)]/norm2(line(:, 2) - line(:, 1))
        call hold_line(name, i, line, roller_t(held))
      end do
    end subroutine hold_lines

    !> Holds what lies on a line.
    subroutine hold_line(name, i, line, as)
      character(len=*), intent(in) :: name
      integer, intent(in) :: i                  !! of the line in the setting
      real(dp), intent(in) :: line(2, 2)        !! (xy, end), length
      type(roller_t), intent(in) :: as
      type(piece_t), allocatable :: piece(:)
      real(dp) :: at(2, 3)
      integer :: k, m

      call find_pieces(scene, system, state, name, i, line, piece, error)
      if (allocated(error)) return
      do m = 1, size(piece)
        at = reshape([piece(m)%ends, 0.5_dp*(piece(m)%ends(:, 1) + piece(m)%ends(:, 2))], [2, 3])
        do k = 1, merge(3, 2, scene%settings%second_order)
          call add_point(roller_end, piece(m)%element, at(:, k), system, state)
          roller = [roller, as]
        end do
      end do
    end subroutine hold_line

    !> Holds some points in one or two directions. Those of blocks that a stage has removed hold nothing.
    subroutine hold_points(name, points, along)
      character(len=*), intent(in) :: name
      real(dp), allocatable, intent(in) :: points(:)
      real(dp), intent(in) :: along(:, :)
      real(dp) :: place(2)
      integer :: e, i, k

      if (.not. allocated(points) .or. allocated(error)) return
      if (.not. allocated(finder%grid%first)) call set_up_finder(finder, system%elements%shape, state%vertex, scene%nearest)
      do i = 1, size(points)/2
        place = points(2*i - 1:2*i) - system%origin
        e = block_at(finder, system%elements%shape, state%vertex, place)
        if (e == 0) then
          call fail(error, status_bad_input, given_at(scene%words, name)//': expected points of blocks in '//name// &
                    ', found no block at point '//number_text(i)//', '//place_text(place + system%origin, system%extent))
          return
        end if
        if (.not. system%present(system%elements%block(e))) cycle
        do k = 1, size(along, 2)
          call add_point(roller_end, e, place, system, state)
          roller = [roller, roller_t(along(:, k))]
        end do
      end do
    end subroutine hold_points

  end subroutine hold_edges

end module scree_rollers
