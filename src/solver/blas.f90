!> Settings of the linked BLAS. OpenBLAS is limited to one thread and asked for its kernel; any other BLAS is left alone. OpenMP in
!> CHOLMOD is limited to one thread, too, and the C library keeps freed memory for the next factors.
!>
!> OpenBLAS chooses a kernel for the processor on which it runs, and each kernel sums in an order of its own. Results agree to the
!> bit if kernel and program are the same, and to round-off otherwise. The routines of OpenBLAS are looked up when the program runs,
!> so scree links with any BLAS and LAPACK.
module scree_blas
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_pointer, c_f_procpointer, c_funptr, c_int, c_null_char, &
                                         c_null_ptr, c_ptr
  use scree_text, only: number_text
  implicit none
  private
  public :: blas_file, blas_name, keep_memory, keep_to_one_thread

  integer, parameter :: longest = 4096 !! letters of a text of the C library: PATH_MAX of Linux

  !> Where an address is (Dl_info).
  type, bind(c) :: place_t
    type(c_ptr) :: file, base, symbol, symbol_at
  end type place_t

  !> Of the GNU C library: M_TRIM_THRESHOLD and M_MMAP_THRESHOLD, and bytes: what is free at the end that is kept, and what is taken
  !> from there, the most that it takes from there.
  integer(c_int), parameter :: free_at_end = -1, taken_apart = -3, kept_bytes = 2**28, apart_bytes = 2**25

  interface
    !> POSIX: address of a symbol; a null handle asks all that is loaded (RTLD_DEFAULT of Linux).
    function dlsym(handle, symbol) bind(c)
      import :: c_char, c_funptr, c_ptr
      type(c_ptr), value :: handle
      character(kind=c_char), intent(in) :: symbol(*)
      type(c_funptr) :: dlsym
    end function dlsym

    !> GNU and BSD: the file that an address was loaded from; 0 where there is none.
    integer(c_int) function dladdr(address, place) bind(c)
      import :: c_funptr, c_int, place_t
      type(c_funptr), value :: address
      type(place_t), intent(out) :: place
    end function dladdr

    !> POSIX: the path of a file without symbolic links, written to `resolved`, whose address is the result; null where it fails.
    function realpath(path, resolved) bind(c)
      import :: c_char, c_ptr, longest
      type(c_ptr), value :: path
      character(kind=c_char), intent(inout) :: resolved(longest)
      type(c_ptr) :: realpath
    end function realpath

    !> LAPACK: its version.
    subroutine ilaver(major, minor, patch)
      integer, intent(out) :: major, minor, patch
    end subroutine ilaver
  end interface

  abstract interface
    subroutine set_number(n) bind(c)
      import :: c_int
      integer(c_int), value :: n
    end subroutine set_number

    integer(c_int) function set_option(option, value) bind(c)
      import :: c_int
      integer(c_int), value :: option, value
    end function set_option

    function give_text() bind(c)
      import :: c_ptr
      type(c_ptr) :: give_text
    end function give_text
  end interface

contains

  !> Keeps the libraries to one thread.
  !>
  !> The blocks of these matrices are too small for two threads to gain by, and with one sums have the same order in every run.
  !> CHOLMOD opens regions of four threads whatever their number is set to, and these wait for each other longer than they work:
  !> half of the time of a factor of 10 000 unknowns. Regions that may not be active have one.
  subroutine keep_to_one_thread()
    call set_where_loaded('openblas_set_num_threads', 1_c_int)
    call set_where_loaded('omp_set_max_active_levels', 0_c_int)
  end subroutine keep_to_one_thread

  !> Keeps memory that was given back, where the C library can be asked to.
  !>
  !> UMFPACK takes some 100 kB to some MB for a factor and gives them back. The library has the system map them anew each time,
  !> and every page of them is cleared: up to a fifth of the time of friction problems. Either setting alone leaves half of that.
  subroutine keep_memory()
    procedure(set_option), pointer :: set
    type(c_funptr) :: address
    integer(c_int) :: done(2)

    address = dlsym(c_null_ptr, 'mallopt'//c_null_char)
    if (.not. c_associated(address)) return
    call c_f_procpointer(address, set)
    done = [set(free_at_end, kept_bytes), set(taken_apart, apart_bytes)] ! what the library refuses stays as it was
  end subroutine keep_memory

  !> Calls a routine with a number, where the program has it.
  subroutine set_where_loaded(routine, number)
    character(len=*), intent(in) :: routine
    integer(c_int), intent(in) :: number
    procedure(set_number), pointer :: set
    type(c_funptr) :: address

    address = dlsym(c_null_ptr, routine//c_null_char)
    if (.not. c_associated(address)) return
    call c_f_procpointer(address, set)
    call set(number)
  end subroutine set_where_loaded

  !> Name, version and kernel of the BLAS, as 'OpenBLAS 0.3.21, kernel Haswell'. Other libraries do not tell these, but the version
  !> of LAPACK that comes with it, as 'not OpenBLAS, LAPACK 3.11.0'.
  function blas_name() result(name)
    character(len=:), allocatable :: name
    integer :: second, major, minor, patch

    name = told_by('openblas_get_config') ! OpenBLAS 0.3.21, and then how it was built
    second = index(name, ' ') + 1
    if (second > 1) then
      second = second + scan(name(second:)//' ', ' ')
      name = name(:min(second - 2, len(name)))//', kernel '//told_by('openblas_get_corename')
    else
      call ilaver(major, minor, patch)
      name = 'not OpenBLAS, LAPACK '//number_text(major)//'.'//number_text(minor)//'.'//number_text(patch)
    end if
  end function blas_name

  !> The file that the product of matrices is called from, behind symbolic links: on Debian libblas.so.3 leads to any BLAS.
  function blas_file() result(name)
    character(len=:), allocatable :: name
    character(kind=c_char) :: resolved(longest)
    type(c_funptr) :: address
    type(place_t) :: place

    name = 'unknown'
    address = dlsym(c_null_ptr, 'dgemm_'//c_null_char)
    if (.not. c_associated(address)) return
    if (dladdr(address, place) == 0) return
    name = text_at(realpath(place%file, resolved))
    if (name == '') name = text_at(place%file)
  end function blas_file

  !> What a routine without arguments says; '' where the program has no such routine.
  function told_by(routine) result(text)
    character(len=*), intent(in) :: routine
    character(len=:), allocatable :: text
    procedure(give_text), pointer :: give
    type(c_funptr) :: address

    text = ''
    address = dlsym(c_null_ptr, routine//c_null_char)
    if (.not. c_associated(address)) return
    call c_f_procpointer(address, give)
    text = text_at(give())
  end function told_by

  !> The text of the C library at an address; '' at a null one.
  function text_at(address) result(text)
    type(c_ptr), intent(in) :: address
    character(len=:), allocatable :: text
    character(kind=c_char), pointer :: letter(:)
    integer :: i

    text = ''
    if (.not. c_associated(address)) return
    call c_f_pointer(address, letter, [longest])
    do i = 1, longest
      if (letter(i) == c_null_char) exit
      text = text//letter(i)
    end do
  end function text_at

end module scree_blas
