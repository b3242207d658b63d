!> KLU (SuiteSparse): LU of an unsymmetric matrix column by column, for matrices whose factors take few operations an entry.
module scree_klu
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_int8_t, c_loc, c_null_ptr, c_ptr
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_factors, only: factors_t
  use scree_kinds, only: dp
  use scree_suitesparse_layout, only: klu_btf_at, klu_bytes, klu_growth_at
  implicit none
  private
  public :: analyse_by_klu, factorise_by_klu, forget_klu_pivots, klu_t, release_klu

  !> Workspace of the library (klu_common, as large as its header says), analysis, and the factors of the last matrix.
  type, extends(factors_t) :: klu_t
    private
    integer(c_int8_t), pointer :: common(:) => null()
    type(c_ptr) :: symbolic = c_null_ptr
    type(c_ptr) :: numeric = c_null_ptr
  contains
    procedure :: solve => solve_by_klu
  end type klu_t

  !> The head of klu_symbolic: what the factors are going to take.
  type, bind(c) :: c_symbolic_head_t
    real(c_double) :: symmetry, operations, entries_of_l, entries_of_u
  end type c_symbolic_head_t

  !> Growth of the entries, as its reciprocal, below which pivots of another matrix are taken no longer.
  real(dp), parameter :: least_growth = 1e-6_dp

  interface
    integer(c_int) function klu_defaults(common) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), value :: common
    end function klu_defaults

    type(c_ptr) function klu_analyze(n, Ap, Ai, common) bind(c)
      import :: c_int, c_ptr
      integer(c_int), value :: n
      integer(c_int), intent(in) :: Ap(*), Ai(*)
      type(c_ptr), value :: common
    end function klu_analyze

    type(c_ptr) function klu_factor(Ap, Ai, Ax, symbolic, common) bind(c)
      import :: c_double, c_int, c_ptr
      integer(c_int), intent(in) :: Ap(*), Ai(*)
      real(c_double), intent(in) :: Ax(*)
      type(c_ptr), value :: symbolic, common
    end function klu_factor

    integer(c_int) function klu_refactor(Ap, Ai, Ax, symbolic, numeric, common) bind(c)
      import :: c_double, c_int, c_ptr
      integer(c_int), intent(in) :: Ap(*), Ai(*)
      real(c_double), intent(in) :: Ax(*)
      type(c_ptr), value :: symbolic, numeric, common
    end function klu_refactor

    integer(c_int) function klu_rgrowth(Ap, Ai, Ax, symbolic, numeric, common) bind(c)
      import :: c_double, c_int, c_ptr
      integer(c_int), intent(in) :: Ap(*), Ai(*)
      real(c_double), intent(in) :: Ax(*)
      type(c_ptr), value :: symbolic, numeric, common
    end function klu_rgrowth

    integer(c_int) function klu_solve(symbolic, numeric, ldim, nrhs, b, common) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: symbolic, numeric, common
      integer(c_int), value :: ldim, nrhs
      real(c_double), intent(inout) :: b(*)
    end function klu_solve

    integer(c_int) function klu_free_symbolic(symbolic, common) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), intent(inout) :: symbolic
      type(c_ptr), value :: common
    end function klu_free_symbolic

    integer(c_int) function klu_free_numeric(numeric, common) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), intent(inout) :: numeric
      type(c_ptr), value :: common
    end function klu_free_numeric
  end interface

contains

  !> Orders a pattern, and tells how many operations an entry of the factors is going to take. Errors: no memory.
  subroutine analyse_by_klu(self, first, row, operations, error)
    type(klu_t), intent(inout) :: self
    integer(c_int), intent(in) :: first(:), row(:) !! (n+1), (n_entries), from 0
    real(dp), intent(out) :: operations            !! an entry of the lower factor
    type(error_t), allocatable, intent(out) :: error
    type(c_symbolic_head_t), pointer :: head

    operations = 0.0_dp
    call release_klu(self)
    call start(self)
    self%symbolic = klu_analyze(size(first, kind=c_int) - 1_c_int, first, row, c_loc(self%common))
    if (.not. c_associated(self%symbolic)) then
      call fail(error, status_run_failed, 'the matrix of the blocks is too large for KLU')
      return
    end if
    call c_f_pointer(self%symbolic, head)
    operations = head%operations/head%entries_of_l
  end subroutine analyse_by_klu

  !> Factorises a matrix of the pattern that was analysed: by the pivots of the one before, as long as entries grow little by that.
  !>
  !> Errors: a singular matrix, no memory.
  subroutine factorise_by_klu(self, first, row, value, error)
    type(klu_t), intent(inout) :: self
    integer(c_int), intent(in) :: first(:), row(:) !! (n+1), (n_entries), from 0
    real(c_double), intent(in) :: value(:)         !! (n_entries)
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: growth

    if (c_associated(self%numeric)) then
      if (klu_refactor(first, row, value, self%symbolic, self%numeric, c_loc(self%common)) /= 0) then
        call measure_growth(growth)
        if (growth > least_growth) return
      end if
      call forget_klu_pivots(self)
    end if
    self%numeric = klu_factor(first, row, value, self%symbolic, c_loc(self%common))
    if (.not. c_associated(self%numeric)) &
      call fail(error, status_run_failed, 'the matrix of the blocks is singular or too large for KLU')

  contains

    !> By how much the entries of the factors are larger than those of the matrix, as its reciprocal.
    subroutine measure_growth(growth)
      real(dp), intent(out) :: growth
      real(c_double), pointer :: measured

      growth = 0.0_dp
      if (klu_rgrowth(first, row, value, self%symbolic, self%numeric, c_loc(self%common)) == 0) return
      call c_f_pointer(c_loc(self%common(klu_growth_at + 1)), measured)
      growth = measured
    end subroutine measure_growth

  end subroutine factorise_by_klu

  !> Solves A x = b with the factors of the last matrix. Errors: the library refuses.
  subroutine solve_by_klu(self, b, x, error)
    class(klu_t), intent(inout) :: self
    real(dp), intent(in), target, contiguous :: b(:)
    real(dp), intent(out) :: x(:)
    type(error_t), allocatable, intent(out) :: error

    x = b
    if (klu_solve(self%symbolic, self%numeric, size(x, kind=c_int), 1_c_int, x, c_loc(self%common)) == 0) &
      call fail(error, status_run_failed, 'KLU has no solution')
  end subroutine solve_by_klu

  !> Starts the library once; blocks of a triangular form are not looked for, as there are none.
  subroutine start(self)
    type(klu_t), intent(inout) :: self
    integer(c_int), pointer :: btf
    integer(c_int) :: ok

    if (associated(self%common)) return
    allocate (self%common(klu_bytes))
    ok = klu_defaults(c_loc(self%common))
    call c_f_pointer(c_loc(self%common(klu_btf_at + 1)), btf)
    btf = 0
  end subroutine start

  !> Lets the next matrix have pivots of its own.
  subroutine forget_klu_pivots(self)
    type(klu_t), intent(inout) :: self
    integer(c_int) :: ignored

    if (c_associated(self%numeric)) ignored = klu_free_numeric(self%numeric, c_loc(self%common))
    self%numeric = c_null_ptr
  end subroutine forget_klu_pivots

  !> Gives the memory back.
  subroutine release_klu(self)
    type(klu_t), intent(inout) :: self
    integer(c_int) :: ignored

    if (.not. associated(self%common)) return
    call forget_klu_pivots(self)
    if (c_associated(self%symbolic)) ignored = klu_free_symbolic(self%symbolic, c_loc(self%common))
    self%symbolic = c_null_ptr
    deallocate (self%common)
  end subroutine release_klu

end module scree_klu
