!> What a run was made by: the program, its compiler, and the libraries that it runs with.
module scree_made_by
  use, intrinsic :: iso_c_binding, only: c_int
  use, intrinsic :: iso_fortran_env, only: compiler_options, compiler_version
  use hdf5, only: h5get_libversion_f
  use scree_blas, only: blas_file, blas_name
  use scree_json, only: begin_object, end_object, json_t, put
  use scree_text, only: number_text, text_t
  implicit none
  private
  public :: fact_t, facts_of_program, json_of_facts, lines_of_facts, version

  character(len=*), parameter :: version = SCREE_VERSION !! of CMakeLists.txt

  !> A fact: its name in files and what it is called for a reader.
  type :: fact_t
    character(len=16) :: name
    character(len=16) :: title
    character(len=:), allocatable :: value
  end type fact_t

  interface
    !> SuiteSparse: its three numbers, and one number of them.
    integer(c_int) function SuiteSparse_version(part) bind(c, name='SuiteSparse_version')
      import :: c_int
      integer(c_int), intent(out) :: part(3)
    end function SuiteSparse_version
  end interface

contains

  !> The program, its compiler and libraries; the versions are those of the libraries that are loaded, not of their headers.
  function facts_of_program(threads) result(list)
    integer, intent(in) :: threads !! of small steps; 0: not yet known, the command line of a run says it
    type(fact_t) :: list(8)
    character(len=:), allocatable :: of_steps
    integer :: failed, part(3)
    integer(c_int) :: of_suitesparse(3), ignored

    call h5get_libversion_f(part(1), part(2), part(3), failed)
    ignored = SuiteSparse_version(of_suitesparse)
    of_steps = 'by run --threads'
    if (threads > 0) of_steps = number_text(threads)
    list(1) = fact('version', '', 'scree '//version)
    list(2) = fact('compiler', 'compiler', compiler_version())
    list(3) = fact('compiler_options', 'options', options_of_compiler())
    list(4) = fact('blas', 'BLAS', blas_name())
    list(5) = fact('blas_file', 'file of BLAS', blas_file())
    list(6) = fact('hdf5', 'HDF5', dotted(part))
    list(7) = fact('suitesparse', 'SuiteSparse', dotted(int(of_suitesparse)))
    list(8) = fact('threads', 'threads', 'linear algebra 1, small steps '//of_steps)
  end function facts_of_program

  !> A fact of its parts.
  pure function fact(name, title, value)
    character(len=*), intent(in) :: name, title, value
    type(fact_t) :: fact

    fact%name = name
    fact%title = title
    fact%value = value
  end function fact

  !> A fact a line.
  function lines_of_facts(list) result(line)
    type(fact_t), intent(in) :: list(:)
    type(text_t) :: line(size(list))
    integer :: i

    do i = 1, size(list)
      line(i)%text = list(i)%value
      if (list(i)%title /= '') line(i)%text = list(i)%title//list(i)%value
    end do
  end function lines_of_facts

  !> The facts as a JSON object of texts.
  function json_of_facts(list) result(text)
    type(fact_t), intent(in) :: list(:)
    character(len=:), allocatable :: text
    type(json_t) :: json
    integer :: i

    json%text = ''
    call begin_object(json, '')
    do i = 1, size(list)
      call put(json, trim(list(i)%name), list(i)%value)
    end do
    call end_object(json)
    text = json%text
  end function json_of_facts

  !> The words of the compiler that change instructions: optimisation, processor, arithmetic, checks.
  function options_of_compiler() result(kept)
    character(len=:), allocatable :: kept
    character(len=:), allocatable :: all
    integer :: first, last

    kept = ''
    all = compiler_options()//' '
    first = 1
    do while (first <= len(all))
      last = first + index(all(first:), ' ') - 2
      if (is_kept(all(first:last))) kept = kept//' '//all(first:last)
      first = last + 2
    end do
    kept = trim(adjustl(kept))

  contains

    pure logical function is_kept(word)
      character(len=*), intent(in) :: word

      is_kept = .false.
      if (len(word) > 1) is_kept = scan(word(2:2), 'Omf') == 1 .and. word(1:1) == '-' .and. index(word, '/') == 0
    end function is_kept

  end function options_of_compiler

  !> A version of three numbers.
  pure function dotted(part) result(text)
    integer, intent(in) :: part(3)
    character(len=:), allocatable :: text

    text = number_text(part(1))//'.'//number_text(part(2))//'.'//number_text(part(3))
  end function dotted

end module scree_made_by
