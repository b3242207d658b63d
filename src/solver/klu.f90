!> KLU (SuiteSparse): LU of an unsymmetric matrix column by column, for matrices whose factors take few operations an entry.
module scree_klu
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_null_ptr, c_ptr
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_factors, only: factors_t
  use scree_kinds, only: dp
  implicit none
  private
  public :: analyse_by_klu, factorise_by_klu, forget_klu_pivots, klu_t, release_klu

  !> Workspace of the library (klu_common), analysis, and the factors of the last matrix.
  type, extends(factors_t) :: klu_t
    private
    type(c_ptr) :: common = c_null_ptr
    type(c_ptr) :: symbolic = c_null_ptr
    type(c_ptr) :: numeric = c_null_ptr
    real(dp) :: least_pivot = 0.0_dp !! over the largest, of the matrix that chose the pivots
  contains
    procedure :: solve => solve_by_klu
  end type klu_t

  !> The head of klu_symbolic: what the factors are going to take.
  type, bind(c) :: c_symbolic_head_t
    real(c_double) :: symmetry, operations, entries_of_l, entries_of_u
  end type c_symbolic_head_t

  !> Smallest pivot over the largest, over the same of the matrix that chose the pivots, below which another matrix chooses its own.
  !> Entries of the factors grow by the reciprocal of a small pivot, so that 10 of 16 digits stay.
  real(dp), parameter :: least_of_first = 1e-6_dp

  interface
    !> suitesparse.c: a workspace that does not look for a triangular form.
    type(c_ptr) function scree_klu_open() bind(c)
      import :: c_ptr
    end function scree_klu_open

    !> suitesparse.c: gives the workspace back.
    subroutine scree_klu_close(common) bind(c)
      import :: c_ptr
      type(c_ptr), value :: common
    end subroutine scree_klu_close

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

    !> suitesparse.c: the smallest pivot over the largest; 0: not known.
    real(c_double) function scree_klu_least_pivot(symbolic, numeric, common) bind(c)
      import :: c_double, c_ptr
      type(c_ptr), value :: symbolic, numeric, common
    end function scree_klu_least_pivot

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
    if (.not. c_associated(self%common)) self%common = scree_klu_open()
    self%symbolic = klu_analyze(size(first, kind=c_int) - 1_c_int, first, row, self%common)
    if (.not. c_associated(self%symbolic)) then
      call fail(error, status_run_failed, 'the matrix of the blocks is too large for KLU')
      return
    end if
    call c_f_pointer(self%symbolic, head)
    operations = head%operations/head%entries_of_l
  end subroutine analyse_by_klu

  !> Factorises a matrix of the pattern that was analysed: with the pivots of an earlier one, as long as none of them becomes small.
  !>
  !> Errors: a singular matrix, no memory.
  subroutine factorise_by_klu(self, first, row, value, error)
    type(klu_t), intent(inout) :: self
    integer(c_int), intent(in) :: first(:), row(:) !! (n+1), (n_entries), from 0
    real(c_double), intent(in) :: value(:)         !! (n_entries)
    type(error_t), allocatable, intent(out) :: error

    if (c_associated(self%numeric)) then
      if (klu_refactor(first, row, value, self%symbolic, self%numeric, self%common) /= 0) then
        if (scree_klu_least_pivot(self%symbolic, self%numeric, self%common) > least_of_first*self%least_pivot) return
      end if
      call forget_klu_pivots(self)
    end if
    self%numeric = klu_factor(first, row, value, self%symbolic, self%common)
    if (.not. c_associated(self%numeric)) then
      call fail(error, status_run_failed, 'the matrix of the blocks is singular or too large for KLU')
      return
    end if
    self%least_pivot = scree_klu_least_pivot(self%symbolic, self%numeric, self%common)
  end subroutine factorise_by_klu

  !> Solves A x = b with the factors of the last matrix. Errors: the library refuses.
  subroutine solve_by_klu(self, b, x, error)
    class(klu_t), intent(inout) :: self
    real(dp), intent(in), target, contiguous :: b(:)
    real(dp), intent(out) :: x(:)
    type(error_t), allocatable, intent(out) :: error

    x = b
    if (klu_solve(self%symbolic, self%numeric, size(x, kind=c_int), 1_c_int, x, self%common) == 0) &
      call fail(error, status_run_failed, 'KLU has no solution')
  end subroutine solve_by_klu

  !> Lets the next matrix have pivots of its own.
  subroutine forget_klu_pivots(self)
    type(klu_t), intent(inout) :: self
    integer(c_int) :: ignored

    if (c_associated(self%numeric)) ignored = klu_free_numeric(self%numeric, self%common)
    self%numeric = c_null_ptr
  end subroutine forget_klu_pivots

  !> Gives the memory back.
  subroutine release_klu(self)
    type(klu_t), intent(inout) :: self
    integer(c_int) :: ignored

    if (.not. c_associated(self%common)) return
    call forget_klu_pivots(self)
    if (c_associated(self%symbolic)) ignored = klu_free_symbolic(self%symbolic, self%common)
    self%symbolic = c_null_ptr
    call scree_klu_close(self%common)
    self%common = c_null_ptr
  end subroutine release_klu

end module scree_klu
