!> Room on the disk for what is written next to an open HDF5 file, taken before, so that a full disk is found before it is begun.
!>
!> While a file is flushed some space at its end is held (why: `hold_space`); it is given back only while rows are appended.
module scree_disk_room
  use hdf5, only: h5dclose_f, h5fget_filesize_f, hid_t, hsize_t
  use scree_errors, only: error_t
  use scree_hdf5_writing, only: flush_file, hold_space, reserve_disk
  implicit none
  private
  public :: disk_room_t, give_back, hold_again

  integer(hsize_t), parameter :: head_bytes = 8192 !! of a dataset that holds space

  !> The space that is held.
  type :: disk_room_t
    integer(hid_t) :: dataset = -1          !! that holds it; -1: none
    integer(hsize_t) :: bytes = 0           !! of it
    integer(hsize_t) :: reserved = 0        !! bytes of the file that have blocks of the disk
  end type disk_room_t

contains

  !> Gives the held space back for what is written next; takes more before where it would not do.
  !>
  !> Errors: the disk has not so much room. Nothing is written then.
  subroutine give_back(room, file, needed, error)
    type(disk_room_t), intent(inout) :: room
    integer(hid_t), intent(in) :: file
    integer(hsize_t), intent(in) :: needed !! bytes that are written next
    type(error_t), allocatable, intent(out) :: error
    integer :: status

    if (needed > room%bytes) then
      if (room%dataset >= 0) call h5dclose_f(room%dataset, status)
      call hold(room, file, 2*needed, needed, error)
      if (.not. allocated(error)) call flush_file(file, error)
      if (allocated(error)) return
    end if
    call h5dclose_f(room%dataset, status)
    room%dataset = -1
  end subroutine give_back

  !> Holds as much as before, or what the disk still has of it.
  subroutine hold_again(room, file, error)
    type(disk_room_t), intent(inout) :: room
    integer(hid_t), intent(in) :: file
    type(error_t), allocatable, intent(out) :: error
    integer(hsize_t) :: wanted

    wanted = room%bytes
    call hold(room, file, wanted, 0_hsize_t, error)
  end subroutine hold_again

  !> Holds space at the end of the file that has blocks of the disk: as much as is wanted, else as is needed, else what has been
  !> taken before. Errors: that is less than is needed.
  subroutine hold(room, file, wanted, needed, error)
    type(disk_room_t), intent(inout) :: room
    integer(hid_t), intent(in) :: file
    integer(hsize_t), intent(in) :: wanted, needed !! bytes
    type(error_t), allocatable, intent(out) :: error
    type(error_t), allocatable :: full
    integer(hsize_t) :: beyond, left

    call take(wanted)
    if (allocated(error) .or. .not. allocated(full)) return
    left = wanted - beyond - head_bytes
    if (left < needed) then
      call take(needed)
      if (allocated(error) .or. .not. allocated(full)) return
      call move_alloc(full, error)
    end if
    room%bytes = max(0_hsize_t, left)
    if (left > 0) call hold_space(file, left, room%dataset, full)

  contains

    !> Tries to hold space; `full` where the disk has no room for it.
    subroutine take(bytes)
      integer(hsize_t), intent(in) :: bytes
      integer(hsize_t) :: length
      integer :: status

      room%bytes = bytes
      call hold_space(file, bytes, room%dataset, error)
      if (allocated(error)) return
      call reserve_disk(file, room%reserved, full)
      if (.not. allocated(full)) return
      call h5fget_filesize_f(file, length, status)
      beyond = length - room%reserved
      call h5dclose_f(room%dataset, status)
      room%dataset = -1
    end subroutine take

  end subroutine hold

end module scree_disk_room
