!> UMFPACK (SuiteSparse): LU of an unsymmetric matrix of many unknowns, by dense blocks.
module scree_umfpack
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_int, c_loc, c_null_ptr, c_ptr
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_factors, only: factors_t
  use scree_kinds, only: dp
  implicit none
  private
  public :: factorise_by_umfpack, release_umfpack, umfpack_t

  !> Symbolic analysis, and the factors of the last matrix.
  type, extends(factors_t) :: umfpack_t
    private
    type(c_ptr) :: symbolic = c_null_ptr
    type(c_ptr) :: numeric = c_null_ptr
  contains
    procedure :: solve => solve_by_umfpack
  end type umfpack_t

  integer(c_int), parameter :: system_A = 0 !! UMFPACK_A: A x = b
  integer(c_int), parameter :: done = 0     !! UMFPACK_OK
  integer, parameter :: n_control = 20      !! UMFPACK_CONTROL
  integer, parameter :: strategy = 6        !! UMFPACK_STRATEGY, from 1
  integer, parameter :: refinements = 8     !! UMFPACK_IRSTEP, from 1: at most
  real(c_double), parameter :: symmetric_pattern = 3 !! UMFPACK_STRATEGY_SYMMETRIC

  interface
    subroutine umfpack_di_defaults(control) bind(c)
      import :: c_double
      real(c_double), intent(out) :: control(*)
    end subroutine umfpack_di_defaults

    integer(c_int) function umfpack_di_symbolic(n_row, n_col, Ap, Ai, Ax, symbolic, control, info) bind(c)
      import :: c_double, c_int, c_ptr
      integer(c_int), value :: n_row, n_col
      integer(c_int), intent(in) :: Ap(*), Ai(*)
      type(c_ptr), value :: Ax
      type(c_ptr), intent(out) :: symbolic
      real(c_double), intent(in) :: control(*)
      type(c_ptr), value :: info
    end function umfpack_di_symbolic

    integer(c_int) function umfpack_di_numeric(Ap, Ai, Ax, symbolic, numeric, control, info) bind(c)
      import :: c_double, c_int, c_ptr
      integer(c_int), intent(in) :: Ap(*), Ai(*)
      real(c_double), intent(in) :: Ax(*)
      type(c_ptr), value :: symbolic
      type(c_ptr), intent(out) :: numeric
      type(c_ptr), value :: control, info
    end function umfpack_di_numeric

    integer(c_int) function umfpack_di_solve(system, Ap, Ai, Ax, x, b, numeric, control, info) bind(c)
      import :: c_double, c_int, c_ptr
      integer(c_int), value :: system
      type(c_ptr), value :: Ap, Ai, Ax
      real(c_double), intent(in) :: b(*)
      real(c_double), intent(out) :: x(*)
      type(c_ptr), value :: numeric, control, info
    end function umfpack_di_solve

    subroutine umfpack_di_free_symbolic(symbolic) bind(c)
      import :: c_ptr
      type(c_ptr), intent(inout) :: symbolic
    end subroutine umfpack_di_free_symbolic

    subroutine umfpack_di_free_numeric(numeric) bind(c)
      import :: c_ptr
      type(c_ptr), intent(inout) :: numeric
    end subroutine umfpack_di_free_numeric
  end interface

contains

  !> Factorises A; a pattern is analysed once, until it is released.
  !>
  !> The analysis is one of the pattern alone: with the values, the first matrix of a pattern would show in the bits of later
  !> solutions. The pattern is symmetric, as that of sums of elements is; UMFPACK asks the values of the diagonal before it takes it
  !> for that, so it is told. Errors: a singular matrix, no memory.
  subroutine factorise_by_umfpack(self, first, row, value, error)
    type(umfpack_t), intent(inout) :: self
    integer(c_int), intent(in) :: first(:), row(:) !! (n+1), (n_entries), from 0
    real(c_double), intent(in) :: value(:)         !! (n_entries)
    type(error_t), allocatable, intent(out) :: error
    real(c_double) :: control(n_control)
    integer(c_int) :: n, status

    if (c_associated(self%numeric)) call umfpack_di_free_numeric(self%numeric)
    self%numeric = c_null_ptr
    n = size(first, kind=c_int) - 1_c_int
    status = done
    if (.not. c_associated(self%symbolic)) then
      call umfpack_di_defaults(control)
      control(strategy) = symmetric_pattern
      status = umfpack_di_symbolic(n, n, first, row, c_null_ptr, self%symbolic, control, c_null_ptr)
    end if
    if (status == done) &
      status = umfpack_di_numeric(first, row, value, self%symbolic, self%numeric, c_null_ptr, c_null_ptr)
    if (status /= done) call fail(error, status_run_failed, 'the matrix of the blocks is singular or too large for UMFPACK')
  end subroutine factorise_by_umfpack

  !> Solves A x = b with the factors of the last matrix, as they are. Errors: no memory.
  subroutine solve_by_umfpack(self, b, x, error)
    class(umfpack_t), intent(inout) :: self
    real(dp), intent(in), target, contiguous :: b(:)
    real(dp), intent(out) :: x(:)
    type(error_t), allocatable, intent(out) :: error
    real(c_double), target :: control(n_control)

    x = 0.0_dp
    call umfpack_di_defaults(control)
    control(refinements) = 0
    if (umfpack_di_solve(system_A, c_null_ptr, c_null_ptr, c_null_ptr, x, b, self%numeric, c_loc(control), c_null_ptr) /= done) &
      call fail(error, status_run_failed, 'UMFPACK has no memory for the solution')
  end subroutine solve_by_umfpack

  !> Gives the memory back; the next solution analyses anew.
  subroutine release_umfpack(self)
    type(umfpack_t), intent(inout) :: self

    if (c_associated(self%numeric)) call umfpack_di_free_numeric(self%numeric)
    if (c_associated(self%symbolic)) call umfpack_di_free_symbolic(self%symbolic)
    self%numeric = c_null_ptr
    self%symbolic = c_null_ptr
  end subroutine release_umfpack

end module scree_umfpack
