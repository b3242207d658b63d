!> The BLAS that is linked: OpenBLAS is kept to one thread and asked for its kernel; any other is left alone.
!>
!> OpenBLAS chooses a kernel for the processor that it runs on, and each sums in an order of its own: results agree to the bit
!> where kernel and program are the same, and to round-off elsewhere. Its routines are looked for when the program runs, so that
!> scree links with any BLAS and LAPACK.
module scree_blas
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_pointer, c_f_procpointer, c_funptr, c_int, c_null_char, &
                                         c_null_ptr, c_ptr
  implicit none
  private
  public :: blas_kernel, keep_blas_to_one_thread

  integer, parameter :: longest = 64 !! letters of a kernel's name

  interface
    !> POSIX: address of a symbol; a null handle asks all that is loaded (RTLD_DEFAULT of Linux).
    function dlsym(handle, symbol) bind(c)
      import :: c_char, c_funptr, c_ptr
      type(c_ptr), value :: handle
      character(kind=c_char), intent(in) :: symbol(*)
      type(c_funptr) :: dlsym
    end function dlsym
  end interface

  abstract interface
    subroutine set_number(n) bind(c)
      import :: c_int
      integer(c_int), value :: n
    end subroutine set_number

    function give_text() bind(c)
      import :: c_ptr
      type(c_ptr) :: give_text
    end function give_text
  end interface

contains

  !> The blocks of these matrices are too small for two threads to gain by, and with one sums have the same order in every run.
  subroutine keep_blas_to_one_thread()
    procedure(set_number), pointer :: set_threads
    type(c_funptr) :: address

    address = dlsym(c_null_ptr, 'openblas_set_num_threads'//c_null_char)
    if (.not. c_associated(address)) return
    call c_f_procpointer(address, set_threads)
    call set_threads(1_c_int)
  end subroutine keep_blas_to_one_thread

  !> The library and the kernel that it chose for this processor; where it is not OpenBLAS, that.
  function blas_kernel() result(name)
    character(len=:), allocatable :: name
    procedure(give_text), pointer :: core
    character(kind=c_char), pointer :: letter(:)
    type(c_funptr) :: address
    integer :: i

    name = 'not OpenBLAS'
    address = dlsym(c_null_ptr, 'openblas_get_corename'//c_null_char)
    if (.not. c_associated(address)) return
    call c_f_procpointer(address, core)
    call c_f_pointer(core(), letter, [longest])
    name = 'OpenBLAS '
    do i = 1, longest
      if (letter(i) == c_null_char) exit
      name = name//letter(i)
    end do
  end function blas_kernel

end module scree_blas
