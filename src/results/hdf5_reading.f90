!> The few HDF5 calls that reading a results file needs. A file that is not as expected gives nothing, or less than was asked for.
module scree_hdf5_reading
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_loc, c_null_char, c_ptr
  use hdf5
  use scree_kinds, only: dp
  implicit none
  private
  public :: begin_hdf5, close_for_reading, count_rows, open_for_reading, read_attribute, read_count, read_rows, read_words

contains

  !> Makes the library ready, with errors as statuses alone, and without its locks: some file systems have none, and whoever
  !> reads would be kept out while a run goes on. The lock of a run is `scree_file_lock`.
  subroutine begin_hdf5()
    integer :: status
    interface
      !> POSIX: gives a variable of the environment a value.
      integer(c_int) function c_setenv(name, value, anew) bind(c, name='setenv')
        import :: c_char, c_int
        character(kind=c_char), intent(in) :: name(*), value(*)
        integer(c_int), value :: anew
      end function c_setenv
    end interface

    status = c_setenv('HDF5_USE_FILE_LOCKING'//c_null_char, 'FALSE'//c_null_char, 1_c_int)
    call h5dont_atexit_f(status) ! first: after a failed write the library's own handler would try again, and crash
    call h5open_f(status)
    call h5eset_auto_f(0, status)
  end subroutine begin_hdf5

  !> Opens a file; below 0 where it is no HDF5 file.
  subroutine open_for_reading(path, file)
    character(len=*), intent(in) :: path
    integer(hid_t), intent(out) :: file
    integer :: status

    call begin_hdf5()
    call h5fopen_f(path, H5F_ACC_RDONLY_F, file, status)
    if (status < 0) file = -1
  end subroutine open_for_reading

  !> Closes a file that is open.
  subroutine close_for_reading(file)
    integer(hid_t), intent(inout) :: file
    integer :: status

    if (file >= 0) call h5fclose_f(file, status)
    file = -1
  end subroutine close_for_reading

  !> A text attribute of an object, '' where there is none.
  function read_attribute(file, object, name) result(text)
    integer(hid_t), intent(in) :: file
    character(len=*), intent(in) :: object, name
    character(len=:), allocatable :: text
    character(kind=c_char), allocatable, target :: letter(:)
    integer(hid_t) :: attribute, string
    integer(size_t) :: letters
    type(c_ptr) :: buffer
    integer :: status
    logical :: there

    text = ''
    call h5aexists_by_name_f(file, object, name, there, status)
    if (status < 0 .or. .not. there) return
    call h5aopen_by_name_f(file, object, name, attribute, status)
    call h5aget_type_f(attribute, string, status)
    call h5tget_size_f(string, letters, status)
    allocate (letter(letters))
    buffer = c_loc(letter)
    call h5aread_f(attribute, string, buffer, status)
    text = text_of(letter)
    text = trim(text(:index(text//c_null_char, c_null_char) - 1))
    call h5tclose_f(string, status)
    call h5aclose_f(attribute, status)
  end function read_attribute

  !> A whole number that is an attribute, 0 where there is none.
  integer function read_count(file, object, name) result(number)
    integer(hid_t), intent(in) :: file
    character(len=*), intent(in) :: object, name
    integer, target :: found
    integer(hid_t) :: attribute
    type(c_ptr) :: buffer
    integer :: status
    logical :: there

    number = 0
    call h5aexists_by_name_f(file, object, name, there, status)
    if (status < 0 .or. .not. there) return
    call h5aopen_by_name_f(file, object, name, attribute, status)
    buffer = c_loc(found)
    call h5aread_f(attribute, H5T_NATIVE_INTEGER, buffer, status)
    if (status >= 0) number = found
    call h5aclose_f(attribute, status)
  end function read_count

  !> Letters as one text.
  pure function text_of(letter) result(text)
    character(kind=c_char), intent(in) :: letter(:)
    character(len=size(letter)) :: text
    integer :: i

    do i = 1, size(letter)
      text(i:i) = letter(i)
    end do
  end function text_of

  !> A column of texts, none where there is no such dataset.
  function read_words(file, path) result(words)
    integer(hid_t), intent(in) :: file
    character(len=*), intent(in) :: path
    character(len=:), allocatable :: words(:)
    character(kind=c_char), allocatable, target :: letter(:, :)
    integer(hid_t) :: dataset, space, string
    integer(hsize_t) :: dims(1), most(1)
    integer(size_t) :: letters
    integer :: i, status
    type(c_ptr) :: buffer

    allocate (character(len=1) :: words(0))
    call h5dopen_f(file, path, dataset, status)
    if (status < 0) return
    call h5dget_type_f(dataset, string, status)
    call h5tget_size_f(string, letters, status)
    call h5dget_space_f(dataset, space, status)
    call h5sget_simple_extent_dims_f(space, dims, most, status)
    if (status == 1 .and. dims(1) > 0) then
      allocate (letter(letters, dims(1)))
      buffer = c_loc(letter)
      call h5dread_f(dataset, string, buffer, status)
      if (status >= 0) then
        deallocate (words)
        allocate (character(len=int(letters)) :: words(dims(1)))
        do i = 1, size(words)
          words(i) = text_of(letter(:, i))
        end do
      end if
    end if
    call h5sclose_f(space, status)
    call h5tclose_f(string, status)
    call h5dclose_f(dataset, status)
  end function read_words

  !> Rows of a dataset, 0 where there is none; and the numbers of a row.
  subroutine count_rows(file, path, rows, width)
    integer(hid_t), intent(in) :: file
    character(len=*), intent(in) :: path
    integer(hsize_t), intent(out) :: rows
    integer, intent(out) :: width
    integer(hid_t) :: dataset, space
    integer(hsize_t) :: dims(3), most(3)
    integer :: n, status

    rows = 0
    width = 1
    call h5dopen_f(file, path, dataset, status)
    if (status < 0) return
    call h5dget_space_f(dataset, space, status)
    call h5sget_simple_extent_ndims_f(space, n, status)
    if (n >= 1 .and. n <= 3) then
      call h5sget_simple_extent_dims_f(space, dims, most, status)
      rows = dims(n)
      width = int(product(dims(:n - 1)))
    end if
    call h5sclose_f(space, status)
    call h5dclose_f(dataset, status)
  end subroutine count_rows

  !> Rows of a dataset, one after the other; whole numbers as reals. None where it has not so many.
  function read_rows(file, path, first, n) result(values)
    integer(hid_t), intent(in) :: file
    character(len=*), intent(in) :: path
    integer(hsize_t), intent(in) :: first     !! from 0
    integer(hsize_t), intent(in) :: n         !! rows
    real(dp), allocatable :: values(:)
    real(dp), allocatable, target :: found(:)
    type(c_ptr) :: buffer
    integer(hid_t) :: dataset, memory, space
    integer(hsize_t) :: dims(3), from(3), most(3), rows
    integer :: rank, status, width

    allocate (values(0))
    call count_rows(file, path, rows, width)
    if (n <= 0 .or. first < 0 .or. first + n > rows) return
    call h5dopen_f(file, path, dataset, status)
    call h5dget_space_f(dataset, space, status)
    call h5sget_simple_extent_ndims_f(space, rank, status)
    call h5sget_simple_extent_dims_f(space, dims, most, status)
    from = 0
    from(rank) = first
    dims(rank) = n
    call h5sselect_hyperslab_f(space, H5S_SELECT_SET_F, from(:rank), dims(:rank), status)
    call h5screate_simple_f(1, [n*width], memory, status)
    allocate (found(n*width))
    buffer = c_loc(found)
    call h5dread_f(dataset, H5T_NATIVE_DOUBLE, buffer, status, memory, space)
    if (status >= 0) call move_alloc(found, values)
    call h5sclose_f(memory, status)
    call h5sclose_f(space, status)
    call h5dclose_f(dataset, status)
  end function read_rows

end module scree_hdf5_reading
