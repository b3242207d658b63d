!> Files that settings name.
module scree_deck_files
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_scene, only: scene_t
  use scree_setting_table, only: given_at
  implicit none
  private
  public :: beside_analysis, expect_file

contains

  !> Error at the place of a setting that names a file which is not there.
  subroutine expect_file(scene, kind, name, path, error)
    type(scene_t), intent(in) :: scene
    character(len=*), intent(in) :: kind   !! of file
    character(len=*), intent(in) :: name   !! of the setting
    character(len=*), intent(in) :: path   !! as the setting gives it
    type(error_t), allocatable, intent(out) :: error
    logical :: there

    inquire (file=beside_analysis(scene, path), exist=there)
    if (.not. there) call fail(error, status_bad_input, given_at(scene%words, name)//': expected a file for '//name// &
                               ', found that the '//kind//' file '//beside_analysis(scene, path)//' does not exist')
  end subroutine expect_file

  !> A path as the analysis deck means it: from its folder.
  function beside_analysis(scene, path)
    type(scene_t), intent(in) :: scene
    character(len=*), intent(in) :: path
    character(len=:), allocatable :: beside_analysis

    beside_analysis = path
    if (path(1:1) /= '/') beside_analysis = scene%analysis_name(:index(scene%analysis_name, '/', back=.true.))//path
  end function beside_analysis

end module scree_deck_files
