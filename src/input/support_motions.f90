!> Motions of the lines of supports: by a velocity, or by a table of displacement.
module scree_support_motions
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_kinds, only: dp
  use scree_motion_record, only: take_record
  use scree_scene, only: scene_t, time_table_t
  use scree_setting_table, only: given_at
  use scree_text, only: number_text
  implicit none
  private
  public :: directions_of, take_support_motions

  !> A time after the end of all runs. It is a power of 2, so that a velocity times it is exact, and so is a time over it: the
  !> displacement at each time is the velocity times the time, rounded once.
  real(dp), parameter :: never = 2.0_dp**80
  !> Sine of the angle between two displacements of a table below which they have one direction: the rounding of a deck.
  real(dp), parameter :: one_way = 1e-9_dp

contains

  !> Takes the motion of each line of `support.moved`, its displacement from where the stage begins.
  !>
  !> Errors: numbers that are no velocities or no table; a line that does not move.
  subroutine take_support_motions(scene, error)
    type(scene_t), intent(inout) :: scene
    type(error_t), allocatable, intent(out) :: error
    type(time_table_t) :: table
    integer :: i, n

    if (allocated(scene%motions)) deallocate (scene%motions)
    associate (s => scene%settings)
      if (.not. allocated(s%support_moved)) return
      n = size(s%support_moved)/4
      allocate (scene%motions(n))
      if (.not. allocated(s%support_velocity)) then
        call take_record(s%support_table, 'support.table', 't ux uy', given_at(scene%words, 'support.table'), table, error)
        if (allocated(error)) return
        scene%motions = table
        if (size(directions_of(table)) == 0) call does_not_move('support.table')
      else if (size(s%support_velocity) /= 2 .and. size(s%support_velocity) /= 2*n) then
        call fail(error, status_bad_input, given_at(scene%words, 'support.velocity')//': expected vx vy of all lines of '// &
                  'support.moved, or of each of the '//number_text(n)//', found '//number_text(size(s%support_velocity))// &
                  ' numbers')
      else
        do i = 1, n
          associate (last => min(2*i, size(s%support_velocity)))
            scene%motions(i) = time_table_t([0.0_dp, never], reshape([0.0_dp, 0.0_dp, never*s%support_velocity(last - 1:last)], &
                                                                     [2, 2]))
          end associate
          if (size(directions_of(scene%motions(i))) == 0 .and. .not. allocated(error)) call does_not_move('support.velocity')
        end do
      end if
    end associate

  contains

    !> Error at a motion that is none.
    subroutine does_not_move(name)
      character(len=*), intent(in) :: name

      call fail(error, status_bad_input, given_at(scene%words, name)//': expected lines of support.moved that move in '//name// &
                ', found one that does not; support.both, x, y and normal hold lines at rest')
    end subroutine does_not_move

  end subroutine take_support_motions

  !> The direction of a motion along one line, or both axes where it has several directions. The larger component of a direction is
  !> above 0, so that a support that turns back holds the same direction.
  pure function directions_of(motion) result(direction)
    type(time_table_t), intent(in) :: motion   !! displacements, length
    real(dp), allocatable :: direction(:, :)   !! (2, 0 to 2) unit vectors
    real(dp) :: way(2, size(motion%time)), longest(2)

    way = motion%value - spread(motion%value(:, 1), 2, size(way, 2))
    longest = way(:, maxloc(norm2(way, 1), 1))
    if (.not. norm2(longest) > 0) then
      allocate (direction(2, 0))
    else if (any(abs(longest(1)*way(2, :) - longest(2)*way(1, :)) > one_way*norm2(longest)**2)) then
      direction = reshape([1.0_dp, 0.0_dp, 0.0_dp, 1.0_dp], [2, 2])
    else
      longest = longest/norm2(longest)
      direction = reshape(sign(1.0_dp, longest(maxloc(abs(longest), 1)))*longest, [2, 1])
    end if
  end function directions_of

end module scree_support_motions
