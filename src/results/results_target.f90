!> Who may write a results file: what a name may take the place of, and whose turn it is to make the file.
module scree_results_target
  use hdf5, only: h5aexists_by_name_f, h5fclose_f, h5fcreate_f, h5fis_hdf5_f, h5fopen_f, h5pclose_f, h5pcreate_f, &
                  h5pset_fclose_degree_f, h5pset_libver_bounds_f, h5f_acc_rdonly_f, h5f_acc_trunc_f, &
                  h5f_close_strong_f, h5f_libver_v110_f, h5f_libver_v18_f, h5p_file_access_f, &
                  h5p_file_create_f, hid_t
  use, intrinsic :: iso_c_binding, only: c_ptr
  use scree_classic_output, only: classic_path, may_replace_classic
  use scree_errors, only: error_t, fail, status_bad_input, status_run_failed
  use scree_file_lock, only: is_locked, lock_file, may_write
  use scree_files, only: expect_regular, holds_something, move_file, refuse_to_replace, remove_file
  use scree_hdf5_reading, only: begin_hdf5
  use scree_hdf5_writing, only: check_status, descriptor_of, keep_within_pages
  use scree_turns, only: give_turn, take_turn
  use scree_xdmf, only: may_replace_xdmf, xdmf_path
  implicit none
  private
  public :: check_targets, create_file, is_in_place, take_place_of

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
    call check_target(path, error)
    call give_turn(turn)
    if (with_xdmf) call check_beside(xdmf_path(path), 'the XDMF side-car', may_replace_xdmf, 'an XDMF side-car of scree')
    if (with_classic) call check_beside(classic_path(path), 'the replay', may_replace_classic, 'a replay of scree')

  contains

    !> Error where a file beside the results is no regular one, or holds what is none of its kind.
    subroutine check_beside(path, purpose, may_replace, kind)
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: purpose      !! what the file is for, with an article
      procedure(may_replace_xdmf) :: may_replace   !! whether one of its kind may take the place of a file
      character(len=*), intent(in) :: kind         !! with an article

      if (allocated(error)) return
      call expect_regular(path, purpose, error)
      if (allocated(error)) return
      if (.not. may_replace(path)) call refuse_to_replace(path, kind, error)
    end subroutine check_beside

  end subroutine check_targets

  !> Error where results may not take the place of what a name leads to.
  subroutine check_target(path, error)
    character(len=*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    integer(hid_t) :: file
    integer :: status
    logical :: is_hdf5

    call expect_regular(path, 'the results', error)
    if (.not. allocated(error)) call refuse_if_written(path, path, error)
    if (allocated(error)) return
    if (.not. holds_something(path)) return
    if (.not. may_write(path)) then
      call fail(error, status_bad_input, path//': expected a file that can be written for the results, found a protected one')
    else if (.not. may_replace(path)) then
      call h5fis_hdf5_f(path, is_hdf5, status)
      if (status >= 0 .and. is_hdf5) call h5fopen_f(path, H5F_ACC_RDONLY_F, file, status)
      if (is_hdf5 .and. status < 0) then
        call fail(error, status_bad_input, path//': expected a new file or a results file to write over, found an HDF5 file '// &
                  'that is cut short or damaged; remove it, or write to another file (-o)')
      else
        call refuse_to_replace(path, 'a results file of scree', error)
      end if
    end if
  end subroutine check_target

  !> Error where another run writes a file, which is to be that of a path, or to become it.
  subroutine refuse_if_written(name, path, error)
    character(len=*), intent(in) :: name, path
    type(error_t), allocatable, intent(out) :: error

    if (is_locked(name)) &
      call fail(error, status_bad_input, path//': expected a results file that no run is writing, found one that another run '// &
                'writes; wait until that ends, stop it, or write to another file (-o)')
  end subroutine refuse_if_written

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

  !> Creates an empty file, whose heads and indices lie within pages, and locks it. Programs that begin at once do that one after
  !> the other. A file of a killed run is removed, not emptied. A run that still writes to it, on a file system without locks, finds
  !> at its next frame that its file is gone.
  subroutine create_file(name, path, file, unit, error)
    character(len=*), intent(in) :: name     !! of the file
    character(len=*), intent(in) :: path     !! of the results that it is to become
    integer(hid_t), intent(inout) :: file    !! -1 where it cannot be written
    integer, intent(out) :: unit             !! by which `is_in_place` knows it
    type(error_t), allocatable, intent(out) :: error
    integer(hid_t) :: access, creation
    integer :: status
    type(c_ptr) :: turn

    unit = -1
    call take_turn(name, turn)
    call refuse_if_written(name, path, error)
    if (allocated(error)) then
      call give_turn(turn)
      return
    end if
    call remove_file(name)
    call h5pcreate_f(H5P_FILE_ACCESS_F, access, status)
    call h5pset_fclose_degree_f(access, H5F_CLOSE_STRONG_F, status)
    call h5pset_libver_bounds_f(access, H5F_LIBVER_V18_F, H5F_LIBVER_V110_F, status)
    call h5pcreate_f(H5P_FILE_CREATE_F, creation, status)
    call keep_within_pages(creation, error)
    if (.not. allocated(error)) then
      call h5fcreate_f(name, H5F_ACC_TRUNC_F, file, status, creation, access)
      if (status < 0) then
        call check_status(status, path//': expected a file that can be written for the results, found', error)
        error%status = status_bad_input
        file = -1
      else
        call hold(name, path, file, unit, error)
      end if
    end if
    call h5pclose_f(creation, status)
    call h5pclose_f(access, status)
    call give_turn(turn)
  end subroutine create_file

  !> Locks a file that was made, and lets the compiler's library know it, by device and number. Errors: another run has locked it.
  subroutine hold(name, path, file, unit, error)
    character(len=*), intent(in) :: name, path
    integer(hid_t), intent(in) :: file
    integer, intent(out) :: unit
    type(error_t), allocatable, intent(out) :: error
    integer :: status

    open (newunit=unit, file=name, access='stream', form='unformatted', action='read', status='old', iostat=status)
    if (status /= 0) then
      call fail(error, status_bad_input, path//': expected a place where files can be read again, found another')
      unit = -1
    else if (.not. lock_file(descriptor_of(file))) then
      call fail(error, status_bad_input, path//': expected a file that no run is writing, found one that another run writes')
    end if
  end subroutine hold

  !> Whether a name still leads to the file that was made by it, or that took its place.
  logical function is_in_place(path, unit)
    character(len=*), intent(in) :: path
    integer, intent(in) :: unit
    integer :: number

    inquire (file=path, number=number)
    is_in_place = number == unit .and. unit /= -1
  end function is_in_place

  !> Gives a file that was made by one name another, at once, that of a file which is there where that is so.
  !> Errors: what is there now is not to be replaced, as by `check_targets`; it cannot be.
  subroutine take_place_of(from, to, error)
    character(len=*), intent(in) :: from, to
    type(error_t), allocatable, intent(out) :: error
    type(c_ptr) :: turn

    call take_turn(to, turn)
    call check_target(to, error)
    if (.not. allocated(error)) then
      if (.not. move_file(from, to)) &
        call fail(error, status_run_failed, to//': cannot take the place of this file')
    end if
    call give_turn(turn)
  end subroutine take_place_of

end module scree_results_target
