!> What moves by tables and records in a scene: the ground, a wave that comes in, supports.
module scree_motions
  use scree_deck_files, only: beside_analysis, expect_file
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_kinds, only: dp
  use scree_motion_record, only: is_peer_file, read_peer_files, read_record_file, take_record
  use scree_scene, only: scene_t, time_table_t
  use scree_setting_table, only: from_of
  use scree_support_motions, only: take_support_motions
  implicit none
  private
  public :: take_motions

contains

  !> Acceleration of the ground from &acceleration, the wave of &absorbing, and the motions of &support.
  subroutine take_motions(scene, error)
    type(scene_t), intent(inout) :: scene
    type(error_t), allocatable, intent(out) :: error

    associate (s => scene%settings)
      if (allocated(s%ground_vertical) .and. allocated(s%ground_file)) call check_vertical(s%ground_file)
      if (allocated(error)) return
      call take('acceleration', 't ax ay', s%ground_table, s%ground_file, s%ground_scale, scene%ground)
      if (.not. allocated(error)) call take('absorbing', 't vx vy', s%wave_table, s%wave_file, s%wave_scale, scene%wave)
    end associate
    if (.not. allocated(error)) call take_support_motions(scene, error)

  contains

    !> Error where a vertical component stands beside a file that has two of them.
    subroutine check_vertical(file)
      character(len=*), intent(in) :: file

      if (.not. is_peer_file(file)) &
        call fail(error, status_bad_input, from_of(scene%words, 'acceleration.vertical')// &
                  ': expected acceleration.vertical beside a PEER record (.at2) in acceleration.file, found one beside '//file)
    end subroutine check_vertical

    !> Reads one record, from its table or its file. It is zero outside of its times.
    !>
    !> In a static stage the last acceleration of the ground stays, because it is the load of the equilibrium.
    subroutine take(group, numbers, table, file, scale, record)
      character(len=*), intent(in) :: group, numbers
      real(dp), allocatable, intent(in) :: table(:)
      character(len=:), allocatable, intent(in) :: file
      real(dp), intent(in) :: scale
      type(time_table_t), intent(inout) :: record

      if (allocated(table)) then
        call take_record(table, group//'.table', numbers, from_of(scene%words, group//'.table'), record, error)
      else if (.not. allocated(file)) then
        return
      else
        call expect_file(scene, 'record', group//'.file', file, error)
        if (allocated(error)) return
        if (is_peer_file(file) .and. group == 'acceleration') then
          call take_peer_record(scene, error)
        else
          call read_record_file(beside_analysis(scene, file), numbers, record, error)
        end if
      end if
      if (allocated(error)) return
      record%value = scale*record%value
      record%kept = group == 'acceleration' .and. scene%is_static()
    end subroutine take

  end subroutine take_motions

  !> The record of PEER of &acceleration. Errors: as of `read_peer_files`; no scale, which is g in units of the deck.
  subroutine take_peer_record(scene, error)
    type(scene_t), intent(inout) :: scene
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: vertical

    vertical = ''
    if (allocated(scene%settings%ground_vertical)) then
      vertical = beside_analysis(scene, scene%settings%ground_vertical)
      call expect_file(scene, 'record', 'acceleration.vertical', scene%settings%ground_vertical, error)
      if (allocated(error)) return
    end if
    if (from_of(scene%words, 'acceleration.scale') == 'default') then
      call fail(error, status_bad_input, from_of(scene%words, 'acceleration.file')// &
                ': expected acceleration.scale, which is g in units of the deck, with a PEER record, found none')
      return
    end if
    call read_peer_files(beside_analysis(scene, scene%settings%ground_file), vertical, scene%ground, error)
  end subroutine take_peer_record

end module scree_motions
