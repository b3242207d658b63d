!> The few HDF5 calls that the results need, each with its status checked.
module scree_hdf5_writing
  use, intrinsic :: iso_fortran_env, only: int8, int64
  use, intrinsic :: iso_c_binding, only: c_associated, c_bool, c_char, c_f_pointer, c_funloc, c_funptr, c_int, c_int64_t, c_loc, &
                                         c_null_char, c_ptr
  use hdf5
  use scree_c_errors, only: words_of_error
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_kinds, only: dp
  implicit none
  private
  public :: append_rows, bytes_to_append, check_status, create_rows, descriptor_of, fixed_rows, flush_file, grow_in_place, &
            hold_space, keep_within_pages, reserve_disk, rows_t, write_text, write_whole, write_words

  integer(hsize_t), parameter :: index_bytes = 8192 !! of a dataset: more than two nodes of its tree
  integer(c_int), parameter :: in_pages = 1         !! H5F_FSPACE_STRATEGY_PAGE
  !> Values that posix_fallocate returns where it is interrupted, and where a disk, a limit of file size or a quota has no room
  !> (Linux).
  integer(c_int), parameter :: interrupted = 4, no_room(3) = [28, 27, 122]

  !> A dataset of rows that grows.
  type :: rows_t
    integer(hid_t) :: id = -1
    integer, allocatable :: shape(:)          !! of a row, as Fortran counts: first index runs fastest
    integer(hsize_t) :: n_rows = 0
    integer(hsize_t) :: chunk_rows = 1, chunk_bytes = 0 !! of a chunk
    logical :: whole = .false.                !! whole numbers
    logical :: byte = .false.                 !! from 0 to 255
  end type rows_t

  !> One entry of HDF5's error stack (H5E_error2_t).
  type, bind(c) :: stack_entry_t
    integer(c_int64_t) :: class, major, minor
    integer(c_int) :: line
    type(c_ptr) :: function_name, file_name, description
  end type stack_entry_t

  !> Text of the deepest entry of the stack.
  type :: reason_t
    character(len=400) :: text = ''
  end type reason_t

  interface
    !> HDF5: calls back for each entry of the error stack.
    integer(c_int) function h5ewalk2(stack, direction, callback, data) bind(c, name='H5Ewalk2')
      import :: c_int, c_int64_t, c_funptr, c_ptr
      integer(c_int64_t), value :: stack
      integer(c_int), value :: direction
      type(c_funptr), value :: callback
      type(c_ptr), value :: data
    end function h5ewalk2

    !> HDF5: a pointer to the descriptor of an open file.
    integer(c_int) function h5fget_vfd_handle(file, access, handle) bind(c, name='H5Fget_vfd_handle')
      import :: c_int, c_int64_t, c_ptr
      integer(c_int64_t), value :: file, access
      type(c_ptr), intent(out) :: handle
    end function h5fget_vfd_handle

    !> HDF5: which versions of its format new objects of a file may have.
    integer(c_int) function h5fset_libver_bounds(file, low, high) bind(c, name='H5Fset_libver_bounds')
      import :: c_int, c_int64_t
      integer(c_int64_t), value :: file
      integer(c_int), value :: low, high
    end function h5fset_libver_bounds

    !> HDF5: how the space of a file is handed out; `threshold` is the smallest piece whose place is remembered once it is free.
    integer(c_int) function h5pset_file_space_strategy(creation, strategy, persists, threshold) &
      bind(c, name='H5Pset_file_space_strategy')
      import :: c_bool, c_int, c_int64_t
      integer(c_int64_t), value :: creation, threshold
      integer(c_int), value :: strategy
      logical(c_bool), value :: persists
    end function h5pset_file_space_strategy

    !> POSIX: takes blocks of the disk for a part of a file.
    integer(c_int) function posix_fallocate(descriptor, offset, length) bind(c)
      import :: c_int, c_int64_t
      integer(c_int), value :: descriptor
      integer(c_int64_t), value :: offset, length
    end function posix_fallocate
  end interface

contains

  !> Error where a call failed, with the system's own words for it.
  subroutine check_status(status, what, error)
    integer, intent(in) :: status
    character(len=*), intent(in) :: what !! could not be done
    type(error_t), allocatable, intent(out) :: error
    type(reason_t), target :: reason
    integer(c_int) :: walked
    integer :: from, to

    if (status >= 0) return
    walked = h5ewalk2(0_c_int64_t, 0_c_int, c_funloc(keep_reason), c_loc(reason))
    from = index(reason%text, "error message = '")
    if (from > 0 .and. walked >= 0) then
      from = from + len("error message = '")
      to = from + index(reason%text(from:), "'") - 2
      reason%text = reason%text(from:to)
    end if
    if (len_trim(reason%text) > 0) then
      call fail(error, status_run_failed, what//': '//trim(reason%text))
    else
      call fail(error, status_run_failed, what)
    end if
  end subroutine check_status

  !> Keeps the first description, which is the deepest.
  integer(c_int) function keep_reason(n, entry, data) bind(c)
    integer(c_int), value :: n
    type(c_ptr), value :: entry, data
    type(stack_entry_t), pointer :: known
    type(reason_t), pointer :: reason

    call c_f_pointer(data, reason)
    keep_reason = 0
    if (n > 0) return
    call c_f_pointer(entry, known)
    if (c_associated(known%description)) call copy_text(known%description, reason%text)
  end function keep_reason

  !> Copies a text of C.
  subroutine copy_text(from, text)
    type(c_ptr), intent(in) :: from
    character(len=*), intent(inout) :: text
    character(kind=c_char), pointer :: letter(:)
    integer :: i

    text = ''
    call c_f_pointer(from, letter, [len(text)])
    do i = 1, len(text)
      if (letter(i) == c_null_char) exit
      text(i:i) = letter(i)
    end do
  end subroutine copy_text

  !> Lets datasets that are made from now on grow in place (HDF5 1.10's extensible arrays).
  !>
  !> The older index of a dataset is a tree whose nodes are split as it grows. A run that is killed between the two halves would
  !> lose rows that were counted. The file keeps the head of HDF5 1.8, because a newer head is marked while a program writes, and a
  !> file that a killed run has marked does not open. Errors: HDF5 refuses.
  subroutine grow_in_place(file, error)
    integer(hid_t), intent(in) :: file
    type(error_t), allocatable, intent(out) :: error

    call check_status(int(h5fset_libver_bounds(int(file, c_int64_t), int(H5F_LIBVER_V110_F, c_int), &
                                               int(H5F_LIBVER_V110_F, c_int))), 'cannot write the results', error)
  end subroutine grow_in_place

  !> Places the metadata of a file that is created within pages of 4096 bytes.
  !>
  !> A system writes page by page. A run that is killed in a write across two pages would leave metadata that is half new, with a
  !> wrong checksum, and all rows of its dataset would be lost. Errors: HDF5 refuses.
  subroutine keep_within_pages(creation, error)
    integer(hid_t), intent(in) :: creation !! properties of the file
    type(error_t), allocatable, intent(out) :: error

    call check_status(int(h5pset_file_space_strategy(int(creation, c_int64_t), in_pages, .false._c_bool, 1_c_int64_t)), &
                      'cannot write the results', error)
  end subroutine keep_within_pages

  !> Creates a dataset of rows that grows, with its whole index.
  !>
  !> HDF5 would write the index in pieces with the first rows. A run that is killed between two pieces would leave a dataset that
  !> cannot be read.
  subroutine create_rows(file, path, shape, whole, units, description, chunk_rows, rows, error, byte)
    integer(hid_t), intent(in) :: file
    character(len=*), intent(in) :: path, units, description
    integer, intent(in) :: shape(:)      !! of a row
    logical, intent(in) :: whole
    integer, intent(in) :: chunk_rows
    type(rows_t), intent(out) :: rows
    type(error_t), allocatable, intent(out) :: error
    logical, intent(in), optional :: byte !! whole numbers in one byte
    integer(hsize_t), dimension(size(shape) + 1) :: dims, most, chunk
    integer(hid_t) :: file_type, links, properties, space
    integer :: status, n

    n = size(shape) + 1
    rows%shape = shape
    rows%whole = whole
    if (present(byte)) rows%byte = byte
    file_type = H5T_IEEE_F64LE
    if (whole) file_type = H5T_STD_I64LE
    if (rows%byte) file_type = H5T_STD_U8LE
    dims(:n - 1) = int(shape, hsize_t)
    most(:n - 1) = dims(:n - 1)
    chunk(:n - 1) = max(1_hsize_t, dims(:n - 1))
    dims(n) = 0
    most(n) = H5S_UNLIMITED_F
    chunk(n) = max(1, chunk_rows)
    call h5screate_simple_f(n, dims, space, status, most)
    call h5pcreate_f(H5P_DATASET_CREATE_F, properties, status)
    call h5pset_chunk_f(properties, n, chunk, status)
    call h5pset_alloc_time_f(properties, H5D_ALLOC_TIME_EARLY_F, status) ! as rows are appended, not at the flush
    call h5pset_fill_time_f(properties, H5D_FILL_TIME_NEVER_F, status)
    rows%chunk_rows = chunk(n)
    rows%chunk_bytes = 8*product(chunk)
    call h5pcreate_f(H5P_LINK_CREATE_F, links, status)
    call h5pset_create_inter_group_f(links, 1, status)
    call h5dcreate_f(file, path, file_type, space, rows%id, status, properties, links)
    if (status >= 0) call h5dset_extent_f(rows%id, [dims(:n - 1), 1_hsize_t], status)
    if (status >= 0) call h5dset_extent_f(rows%id, dims, status)
    call check_status(status, 'cannot make '//path, error)
    if (allocated(error)) return
    if (len(units) > 0) call write_text(rows%id, 'units', units, error)
    if (allocated(error)) return
    if (len(description) > 0) call write_text(rows%id, 'description', description, error)
    call h5pclose_f(links, status)
    call h5pclose_f(properties, status)
    call h5sclose_f(space, status)
  end subroutine create_rows

  !> Appends rows, in memory as they are in the file: to convert any, HDF5 takes and clears a megabyte each time.
  subroutine append_rows(rows, values, error)
    type(rows_t), intent(inout) :: rows
    real(dp), intent(in), target, contiguous :: values(:) !! whole rows, one after the other
    type(error_t), allocatable, intent(out) :: error
    integer(int64), allocatable, target :: numbers(:)
    integer(int8), allocatable, target :: bytes(:)
    integer(hsize_t), dimension(size(rows%shape) + 1) :: dims, from, number
    integer(hid_t) :: memory, space
    integer :: n, status

    n = size(rows%shape) + 1
    if (size(values) == 0) return
    number(:n - 1) = int(rows%shape, hsize_t)
    number(n) = size(values)/max(1, product(rows%shape))
    from = 0
    from(n) = rows%n_rows
    dims(:n - 1) = number(:n - 1)
    dims(n) = rows%n_rows + number(n)
    call h5dset_extent_f(rows%id, dims, status)
    if (status >= 0) then
      call h5dget_space_f(rows%id, space, status)
      call h5sselect_hyperslab_f(space, H5S_SELECT_SET_F, from, number, status)
      call h5screate_simple_f(n, number, memory, status)
      if (rows%byte) then
        bytes = int(merge(values - 256, values, values > 127), int8) ! of the same bits without a sign
        call h5dwrite_f(rows%id, H5T_STD_U8LE, c_loc(bytes), status, memory, space)
      else if (rows%whole) then
        numbers = nint(values, int64)
        call h5dwrite_f(rows%id, h5kind_to_type(int64, H5_INTEGER_KIND), c_loc(numbers), status, memory, space)
      else
        call h5dwrite_f(rows%id, H5T_NATIVE_DOUBLE, c_loc(values), status, memory, space)
      end if
    end if
    call check_status(status, 'cannot write', error)
    if (allocated(error)) return
    call h5sclose_f(memory, status)
    call h5sclose_f(space, status)
    rows%n_rows = dims(n)
  end subroutine append_rows

  !> Reserves space at the end of the file with a dataset without a name; closing it gives the space back.
  !>
  !> A flush writes the index of new rows before the head of the file. A run that is killed between the two would leave an index
  !> beyond the end that the head gives. A flush of a file that has become shorter cuts it before it writes the head. So some space
  !> is always reserved while the file is flushed, and returned only while rows are appended.
  subroutine hold_space(file, bytes, dataset, error)
    integer(hid_t), intent(in) :: file
    integer(hsize_t), intent(in) :: bytes
    integer(hid_t), intent(out) :: dataset
    type(error_t), allocatable, intent(out) :: error
    integer(hid_t) :: properties, space
    integer :: status

    call h5screate_simple_f(1, [bytes], space, status)
    call h5pcreate_f(H5P_DATASET_CREATE_F, properties, status)
    call h5pset_alloc_time_f(properties, H5D_ALLOC_TIME_EARLY_F, status)
    call h5pset_fill_time_f(properties, H5D_FILL_TIME_NEVER_F, status)
    call h5dcreate_anon_f(file, H5T_STD_U8LE, space, dataset, status, properties)
    call check_status(status, 'cannot write', error)
    if (allocated(error)) return
    call h5pclose_f(properties, status)
    call h5sclose_f(space, status)
  end subroutine hold_space

  !> Allocates disk blocks for all of a file, so that writing to its space cannot find the disk full.
  !>
  !> Where the file system cannot, nothing is taken. Errors: no room.
  subroutine reserve_disk(file, reserved, error)
    integer(hid_t), intent(in) :: file
    integer(hsize_t), intent(inout) :: reserved !! bytes of the file that have blocks
    type(error_t), allocatable, intent(out) :: error
    integer(c_int) :: code, descriptor
    integer(hsize_t) :: length
    integer :: status

    call h5fget_filesize_f(file, length, status)
    if (length <= reserved) return
    descriptor = descriptor_of(file)
    if (descriptor < 0) return
    do
      code = posix_fallocate(descriptor, int(reserved, c_int64_t), int(length - reserved, c_int64_t))
      if (code /= interrupted) exit
    end do
    if (any(code == no_room)) then
      call fail(error, status_run_failed, 'cannot write: '//words_of_error(code))
    else
      reserved = length
    end if
  end subroutine reserve_disk

  !> The system's descriptor of an open file; below 0 where it has none.
  integer(c_int) function descriptor_of(file) result(descriptor)
    integer(hid_t), intent(in) :: file
    integer(c_int), pointer :: found
    type(c_ptr) :: handle

    descriptor = -1
    if (h5fget_vfd_handle(int(file, c_int64_t), int(H5P_DEFAULT_F, c_int64_t), handle) < 0) return
    call c_f_pointer(handle, found)
    descriptor = found
  end function descriptor_of

  !> Hands everything to the system.
  subroutine flush_file(file, error)
    integer(hid_t), intent(in) :: file
    type(error_t), allocatable, intent(out) :: error
    integer :: status

    call h5fflush_f(file, H5F_SCOPE_GLOBAL_F, status)
    call check_status(status, 'cannot write', error)
  end subroutine flush_file

  !> Space that more rows of a dataset may take at the end of the file: chunks and what indexes them.
  elemental integer(hsize_t) function bytes_to_append(rows, n) result(bytes)
    type(rows_t), intent(in) :: rows
    integer(hsize_t), intent(in) :: n !! rows more

    bytes = index_bytes + (chunks(rows%n_rows + n) - chunks(rows%n_rows))*rows%chunk_bytes

  contains

    !> Chunks that a number of rows takes.
    pure integer(hsize_t) function chunks(n)
      integer(hsize_t), intent(in) :: n

      chunks = (n + rows%chunk_rows - 1)/rows%chunk_rows
    end function chunks

  end function bytes_to_append

  !> Makes a dataset of rows, fills and closes it.
  subroutine fixed_rows(file, path, shape, whole, units, description, values, error, byte)
    integer(hid_t), intent(in) :: file
    character(len=*), intent(in) :: path, units, description
    integer, intent(in) :: shape(:)
    logical, intent(in) :: whole
    real(dp), intent(in) :: values(:)
    type(error_t), allocatable, intent(out) :: error
    logical, intent(in), optional :: byte
    type(rows_t) :: rows
    integer :: status

    call create_rows(file, path, shape, whole, units, description, max(1, size(values)/max(1, product(shape))), rows, &
                     error, byte)
    if (allocated(error)) return
    call append_rows(rows, values, error)
    if (allocated(error)) return
    call h5dclose_f(rows%id, status)
  end subroutine fixed_rows

  !> Writes a text attribute of an object; one that is there is written over in place, cut to its room.
  subroutine write_text(object, name, text, error, room)
    integer(hid_t), intent(in) :: object
    character(len=*), intent(in) :: name, text
    type(error_t), allocatable, intent(out) :: error
    integer, intent(in), optional :: room !! letters for later texts; as many as `text` has where absent
    character(len=:), allocatable, target :: buffer
    integer(hid_t) :: attribute, space, string
    integer(size_t) :: letters
    integer :: status
    logical :: there

    call h5aexists_f(object, name, there, status)
    if (there) then
      call h5aopen_f(object, name, attribute, status)
      call h5aget_type_f(attribute, string, status)
      call h5tget_size_f(string, letters, status)
      buffer = text//repeat(c_null_char, int(letters))
      call h5awrite_f(attribute, string, c_loc(buffer), status)
      call check_status(status, 'cannot write '//name, error)
      call h5aclose_f(attribute, status)
      return
    end if
    buffer = text
    if (len(text) == 0) buffer = ' '
    if (present(room)) buffer = text//repeat(c_null_char, max(0, room - len(text)))
    call h5tcopy_f(H5T_C_S1, string, status)
    call h5tset_size_f(string, int(len(buffer), size_t), status)
    call h5tset_strpad_f(string, H5T_STR_NULLPAD_F, status)
    call h5screate_f(H5S_SCALAR_F, space, status)
    call h5acreate_f(object, name, string, space, attribute, status)
    if (status >= 0) call h5awrite_f(attribute, string, c_loc(buffer), status)
    call check_status(status, 'cannot write '//name, error)
    if (allocated(error)) return
    call h5aclose_f(attribute, status)
    call h5sclose_f(space, status)
    call h5tclose_f(string, status)
  end subroutine write_text

  !> Writes a whole-number attribute, a scalar where one number is given, else an array. One that is there is written over.
  subroutine write_whole(object, name, values, error)
    integer(hid_t), intent(in) :: object
    character(len=*), intent(in) :: name
    integer, intent(in) :: values(:)
    type(error_t), allocatable, intent(out) :: error
    integer, target :: buffer(size(values))
    integer(hid_t) :: attribute, space
    integer :: status
    logical :: there

    buffer = values
    call h5aexists_f(object, name, there, status)
    if (there) then
      call h5aopen_f(object, name, attribute, status)
    else
      if (size(values) == 1) then
        call h5screate_f(H5S_SCALAR_F, space, status)
      else
        call h5screate_simple_f(1, [size(values, kind=hsize_t)], space, status)
      end if
      call h5acreate_f(object, name, H5T_STD_I64LE, space, attribute, status)
      call h5sclose_f(space, status)
    end if
    call h5awrite_f(attribute, H5T_NATIVE_INTEGER, c_loc(buffer), status)
    call check_status(status, 'cannot write '//name, error)
    if (allocated(error)) return
    call h5aclose_f(attribute, status)
  end subroutine write_whole

  !> Writes a column of texts as one dataset.
  subroutine write_words(file, path, words, error)
    integer(hid_t), intent(in) :: file
    character(len=*), intent(in) :: path
    character(len=*), intent(in) :: words(:)
    type(error_t), allocatable, intent(out) :: error
    character(len=len(words)), target :: buffer(max(1, size(words)))
    integer(hid_t) :: dataset, links, space, string
    integer :: status

    buffer(:size(words)) = words
    call h5tcopy_f(H5T_C_S1, string, status)
    call h5tset_size_f(string, int(max(1, len(words)), size_t), status)
    call h5tset_strpad_f(string, H5T_STR_SPACEPAD_F, status)
    call h5screate_simple_f(1, [size(words, kind=hsize_t)], space, status)
    call h5pcreate_f(H5P_LINK_CREATE_F, links, status)
    call h5pset_create_inter_group_f(links, 1, status)
    call h5dcreate_f(file, path, string, space, dataset, status, lcpl_id=links)
    if (status >= 0 .and. size(words) > 0) call h5dwrite_f(dataset, string, c_loc(buffer), status)
    call check_status(status, 'cannot write '//path, error)
    if (allocated(error)) return
    call h5dclose_f(dataset, status)
    call h5pclose_f(links, status)
    call h5sclose_f(space, status)
    call h5tclose_f(string, status)
  end subroutine write_words

end module scree_hdf5_writing
