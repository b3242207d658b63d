!> Why a call of C failed: the number of the error, and the system's words for it.
module scree_c_errors
  use, intrinsic :: iso_c_binding, only: c_char, c_f_pointer, c_int, c_null_char, c_ptr
  implicit none
  private
  public :: last_error, words_of_error

  integer, parameter :: most_letters = 200 !! of the system's words

  interface
    !> C: where the number of the last error stands (glibc, musl).
    type(c_ptr) function c_errno() bind(c, name='__errno_location')
      import :: c_ptr
    end function c_errno

    !> C: the system's words for an error.
    type(c_ptr) function c_strerror(number) bind(c, name='strerror')
      import :: c_int, c_ptr
      integer(c_int), value :: number
    end function c_strerror
  end interface

contains

  !> Number of the error that the last call of C ended with.
  integer(c_int) function last_error()
    integer(c_int), pointer :: number

    call c_f_pointer(c_errno(), number)
    last_error = number
  end function last_error

  !> The system's words for the error of a number.
  function words_of_error(number) result(words)
    integer(c_int), intent(in) :: number
    character(len=:), allocatable :: words
    character(kind=c_char), pointer :: letter(:)
    integer :: i

    call c_f_pointer(c_strerror(number), letter, [most_letters])
    words = ''
    do i = 1, most_letters
      if (letter(i) == c_null_char) exit
      words = words//letter(i)
    end do
  end function words_of_error

end module scree_c_errors
