!> A text file that is written line by line and is there whole or not at all: it waits as FILE.part until it is closed, and takes
!> the place of what was there only then. Devices and pipes are written directly.
module scree_text_file
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_int, c_null_char, c_null_ptr, c_ptr, c_size_t
  use, intrinsic :: iso_fortran_env, only: int64
  use scree_c_errors, only: last_error, words_of_error
  use scree_errors, only: error_t, fail, status_bad_input, status_run_failed
  use scree_files, only: holds_something, move_file, remove_file, set_length, without_links
  use scree_interruption, only: ignore_size_limit
  implicit none
  private
  public :: close_text_file, open_text_file, put_line, text_file_t

  !> The open file.
  type :: text_file_t
    character(len=:), allocatable :: path   !! as it was asked for
    character(len=:), allocatable :: place  !! where that is
    character(len=:), allocatable :: name   !! that it has now
    type(c_ptr), private :: file = c_null_ptr
    character(len=:), allocatable :: reason !! why it could not be written; empty: it could
  end type text_file_t

  interface
    type(c_ptr) function c_fopen(path, mode) bind(c, name='fopen')
      import :: c_char, c_ptr
      character(kind=c_char), intent(in) :: path(*), mode(*)
    end function c_fopen

    integer(c_size_t) function c_fwrite(bytes, size, count, file) bind(c, name='fwrite')
      import :: c_char, c_ptr, c_size_t
      character(kind=c_char), intent(in) :: bytes(*)
      integer(c_size_t), value :: size, count
      type(c_ptr), value :: file
    end function c_fwrite

    integer(c_int) function c_fclose(file) bind(c, name='fclose')
      import :: c_int, c_ptr
      type(c_ptr), value :: file
    end function c_fclose
  end interface

contains

  !> Opens a file to be written. Errors: it cannot be.
  subroutine open_text_file(path, file, error)
    character(len=*), intent(in) :: path
    type(text_file_t), intent(out) :: file
    type(error_t), allocatable, intent(out) :: error
    logical :: there

    call ignore_size_limit()
    file%path = path
    file%place = without_links(path)
    file%reason = ''
    file%name = file%place//'.part'
    inquire (file=path, exist=there)
    if (there) there = .not. holds_something(path)
    if (there) there = .not. set_length(path, 0_int64) ! nothing but a regular file can be cut to nothing
    if (there) file%name = path
    file%file = c_fopen(file%name//c_null_char, 'wb'//c_null_char)
    if (.not. c_associated(file%file)) &
      call fail(error, status_bad_input, path//': expected a file that can be written, found: '//words_of_error(last_error()))
  end subroutine open_text_file

  !> Writes a line, or several; nothing after a failure.
  subroutine put_line(file, line)
    type(text_file_t), intent(inout) :: file
    character(len=*), intent(in) :: line

    if (len(file%reason) > 0) return
    if (c_fwrite(line, 1_c_size_t, len(line, c_size_t), file%file) < len(line) .or. &
        c_fwrite(new_line('a'), 1_c_size_t, 1_c_size_t, file%file) < 1) file%reason = words_of_error(last_error())
  end subroutine put_line

  !> Closes the file and gives it its place. Errors: it could not be written; then the earlier file stays.
  subroutine close_text_file(file, error)
    type(text_file_t), intent(inout) :: file
    type(error_t), allocatable, intent(out) :: error

    if (c_fclose(file%file) /= 0 .and. len(file%reason) == 0) file%reason = words_of_error(last_error())
    if (len(file%reason) == 0 .and. file%name /= file%path) then
      if (.not. move_file(file%name, file%place)) file%reason = words_of_error(last_error())
    end if
    if (len(file%reason) == 0) return
    if (file%name /= file%path) call remove_file(file%name)
    call fail(error, status_run_failed, file%path//': cannot write: '//file%reason)
  end subroutine close_text_file

end module scree_text_file
