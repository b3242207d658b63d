!> Who may write a results file: what a name may take the place of, and whose turn it is to make the file.
module scree_results_target
  use hdf5, only: h5aexists_by_name_f, h5fclose_f, h5fcreate_f, h5fflush_f, h5fis_hdf5_f, h5fopen_f, h5pclose_f, h5pcreate_f, &
                  h5pset_fclose_degree_f, h5pset_libver_bounds_f, h5f_acc_rdonly_f, h5f_acc_rdwr_f, h5f_acc_trunc_f, &
                  h5f_close_strong_f, h5f_libver_v110_f, h5f_libver_v18_f, h5f_scope_local_f, h5p_file_access_f, &
                  h5p_file_create_f, hid_t
  use, intrinsic :: iso_c_binding, only: c_ptr
  use scree_classic_output, only: classic_path, may_replace_classic
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_files, only: expect_regular, holds_something, refuse_to_replace
  use scree_hdf5_reading, only: begin_hdf5
  use scree_hdf5_writing, only: check_status, keep_within_pages
  use scree_turns, only: give_turn, take_turn
  use scree_xdmf, only: may_replace_xdmf, xdmf_path
  implicit none
  private
  public :: check_targets, create_file

contains

  !> Error where what would be written over is no regular file, or none that a run or a model was written to, or the names are one.
  subroutine check_targets(path, with_xdmf, with_classic, error)
    character(len=*), intent(in) :: path
    logical, intent(in) :: with_xdmf, with_classic
    type(error_t), allocatable, intent(out) :: error
    type(c_ptr) :: turn

    if ((with_xdmf .and. xdmf_path(path) == path) .or. (with_classic .and. classic_path(path) == path)) then
      call fail(error, status_bad_input, path//': expected another name for the results, found that of a file beside them')
      return
    end if
    call take_turn(path, turn)
    call expect_regular(path, 'the results', error)
    if (.not. allocated(error)) call refuse_if_locked(path, error)
    if (.not. allocated(error)) then
      if (.not. may_replace(path)) call refuse_to_replace(path, 'a results file of scree', error)
    end if
    call give_turn(turn)
    if (with_xdmf .and. .not. allocated(error)) call expect_regular(xdmf_path(path), 'the XDMF side-car', error)
    if (with_xdmf .and. .not. allocated(error)) then
      if (.not. may_replace_xdmf(xdmf_path(path))) call refuse_to_replace(xdmf_path(path), 'an XDMF side-car of scree', error)
    end if
    if (with_classic .and. .not. allocated(error)) call expect_regular(classic_path(path), 'the replay', error)
    if (with_classic .and. .not. allocated(error)) then
      if (.not. may_replace_classic(classic_path(path))) call refuse_to_replace(classic_path(path), 'a replay of scree', error)
    end if
  end subroutine check_targets

  !> Error that a file of HDF5 cannot be opened to be written: another program has it open, reading or writing, or it is damaged.
  subroutine refuse_if_locked(path, error)
    character(len=*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    integer(hid_t) :: file
    integer :: status
    logical :: is_hdf5

    call begin_hdf5()
    call h5fis_hdf5_f(path, is_hdf5, status)
    if (status < 0 .or. .not. is_hdf5) return
    call h5fopen_f(path, H5F_ACC_RDWR_F, file, status)
    if (status < 0) then
      call fail(error, status_bad_input, path//': expected a new file or a results file to write over, found one that another '// &
                'program has open, or that is damaged or protected')
    else
      call h5fclose_f(file, status)
    end if
  end subroutine refuse_if_locked

  !> Whether results may take the place of a file: it holds nothing, or a status of scree's in HDF5.
  logical function may_replace(path)
    character(len=*), intent(in) :: path
    integer(hid_t) :: file
    integer :: status

    may_replace = .not. holds_something(path)
    if (may_replace) return
    call begin_hdf5()
    call h5fopen_f(path, H5F_ACC_RDONLY_F, file, status)
    if (status < 0) return
    call h5aexists_by_name_f(file, '/scene', 'status', may_replace, status)
    call h5fclose_f(file, status)
  end function may_replace

  !> Creates an empty file, whose heads and indices lie within pages. To empty one that is there takes its bytes from whoever writes
  !> it, before HDF5 asks whether it is locked; so programs that begin at once do that one after the other, and what one has made
  !> is on the disk, where others know it for a file of HDF5, before their turn comes.
  subroutine create_file(path, file, error)
    character(len=*), intent(in) :: path
    integer(hid_t), intent(inout) :: file    !! -1 where it cannot be written
    type(error_t), allocatable, intent(out) :: error
    integer(hid_t) :: access, creation
    integer :: status
    type(c_ptr) :: turn

    call take_turn(path, turn)
    call refuse_if_locked(path, error)
    if (allocated(error)) then
      call give_turn(turn)
      return
    end if
    call h5pcreate_f(H5P_FILE_ACCESS_F, access, status)
    call h5pset_fclose_degree_f(access, H5F_CLOSE_STRONG_F, status)
    call h5pset_libver_bounds_f(access, H5F_LIBVER_V18_F, H5F_LIBVER_V110_F, status)
    call h5pcreate_f(H5P_FILE_CREATE_F, creation, status)
    call keep_within_pages(creation, error)
    if (.not. allocated(error)) then
      call h5fcreate_f(path, H5F_ACC_TRUNC_F, file, status, creation, access)
      if (status < 0) then
        call check_status(status, path//': expected a file that can be written for the results, found', error)
        error%status = status_bad_input
        file = -1
      else
        call h5fflush_f(file, H5F_SCOPE_LOCAL_F, status)
        call check_status(status, path//': cannot write the results', error)
      end if
    end if
    call h5pclose_f(creation, status)
    call h5pclose_f(access, status)
    call give_turn(turn)
  end subroutine create_file

end module scree_results_target
