!> CHOLMOD (SuiteSparse): Cholesky factorisation of a symmetric positive definite matrix.
module scree_cholmod
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_loc, c_null_ptr, c_ptr, c_size_t
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_factors, only: factors_t
  use scree_kinds, only: dp
  implicit none
  private
  public :: cholmod_t, factorise_by_cholmod, release_cholmod

  !> Workspace of the library (cholmod_common) and the factor, whose analysis is kept.
  type, extends(factors_t) :: cholmod_t
    type(c_ptr) :: common = c_null_ptr
    type(c_ptr) :: factor = c_null_ptr
    type(c_ptr) :: solution = c_null_ptr, permuted = c_null_ptr, work = c_null_ptr !! kept between solutions
  contains
    procedure :: solve => solve_by_cholmod
  end type cholmod_t

  !> cholmod_sparse
  type, bind(c) :: c_sparse_t
    integer(c_size_t) :: nrow, ncol, nzmax
    type(c_ptr) :: p, i, nz, x, z
    integer(c_int) :: stype, itype, xtype, dtype, sorted, packed
  end type c_sparse_t

  !> cholmod_dense
  type, bind(c) :: c_dense_t
    integer(c_size_t) :: nrow, ncol, nzmax, d
    type(c_ptr) :: x, z
    integer(c_int) :: xtype, dtype
  end type c_dense_t

  !> The head of cholmod_factor: where the factorisation stopped, n where it did not.
  type, bind(c) :: c_factor_head_t
    integer(c_size_t) :: n, minor
  end type c_factor_head_t

  integer(c_int), parameter :: lower_triangle = -1, real_numbers = 1, system_A = 0

  interface
    !> suitesparse.c: a workspace for L L^T that prints nothing.
    type(c_ptr) function scree_cholmod_open() bind(c)
      import :: c_ptr
    end function scree_cholmod_open

    !> suitesparse.c: ends the library and gives the workspace back.
    subroutine scree_cholmod_close(common) bind(c)
      import :: c_ptr
      type(c_ptr), value :: common
    end subroutine scree_cholmod_close

    type(c_ptr) function cholmod_analyze(A, common) bind(c)
      import :: c_ptr, c_sparse_t
      type(c_sparse_t), intent(in) :: A
      type(c_ptr), value :: common
    end function cholmod_analyze

    integer(c_int) function cholmod_factorize(A, L, common) bind(c)
      import :: c_int, c_ptr, c_sparse_t
      type(c_sparse_t), intent(in) :: A
      type(c_ptr), value :: L, common
    end function cholmod_factorize

    integer(c_int) function cholmod_solve2(system, L, b, b_set, x, x_set, y, e, common) bind(c)
      import :: c_dense_t, c_int, c_ptr
      integer(c_int), value :: system
      type(c_ptr), value :: L, b_set, x_set, common
      type(c_dense_t), intent(in) :: b
      type(c_ptr), intent(inout) :: x, y, e
    end function cholmod_solve2

    integer(c_int) function cholmod_free_factor(L, common) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), intent(inout) :: L
      type(c_ptr), value :: common
    end function cholmod_free_factor

    integer(c_int) function cholmod_free_dense(x, common) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), intent(inout) :: x
      type(c_ptr), value :: common
    end function cholmod_free_dense
  end interface

contains

  !> Factorises the symmetric matrix with these values, in compressed columns, by its lower triangle; `definite` is false where it
  !> is not positive definite.
  !>
  !> The analysis is made once, and is of the pattern alone. Errors: no memory for it.
  subroutine factorise_by_cholmod(self, first, row, value, definite, error)
    type(cholmod_t), intent(inout) :: self
    integer(c_int), intent(in), target, contiguous :: first(:), row(:) !! (n+1), (n_entries), from 0
    real(c_double), intent(in), target, contiguous :: value(:)         !! (n_entries)
    logical, intent(out) :: definite
    type(error_t), allocatable, intent(out) :: error
    type(c_sparse_t) :: A
    type(c_factor_head_t), pointer :: head
    integer(c_int) :: ok

    definite = .false.
    if (.not. c_associated(self%common)) self%common = scree_cholmod_open()
    associate (n => size(first, kind=c_size_t) - 1)
      A = c_sparse_t(n, n, size(row, kind=c_size_t), c_loc(first), c_loc(row), c_null_ptr, c_loc(value), c_null_ptr, &
                     lower_triangle, 0_c_int, real_numbers, 0_c_int, 1_c_int, 1_c_int)
    end associate
    if (.not. c_associated(self%factor)) self%factor = cholmod_analyze(A, self%common)
    if (.not. c_associated(self%factor)) then
      call fail(error, status_run_failed, 'the matrix of the blocks is too large for CHOLMOD')
      return
    end if
    ok = cholmod_factorize(A, self%factor, self%common)
    call c_f_pointer(self%factor, head)
    definite = ok /= 0 .and. head%minor == head%n
  end subroutine factorise_by_cholmod

  !> Solves A x = b with the factor of the last matrix. Errors: no memory.
  subroutine solve_by_cholmod(self, b, x, error)
    class(cholmod_t), intent(inout) :: self
    real(dp), intent(in), target, contiguous :: b(:)
    real(dp), intent(out) :: x(:)
    type(error_t), allocatable, intent(out) :: error
    type(c_dense_t) :: rhs
    type(c_dense_t), pointer :: solution
    real(c_double), pointer :: values(:)
    integer(c_int) :: ok

    associate (n => size(b, kind=c_size_t))
      rhs = c_dense_t(n, 1_c_size_t, n, n, c_loc(b), c_null_ptr, real_numbers, 0_c_int)
    end associate
    ok = cholmod_solve2(system_A, self%factor, rhs, c_null_ptr, self%solution, c_null_ptr, self%permuted, self%work, &
                        self%common)
    if (ok == 0) then
      call fail(error, status_run_failed, 'CHOLMOD has no memory for the solution')
      return
    end if
    call c_f_pointer(self%solution, solution)
    call c_f_pointer(solution%x, values, [size(x)])
    x = values
  end subroutine solve_by_cholmod

  !> Gives the memory back; the next solution starts and analyses anew.
  subroutine release_cholmod(self)
    type(cholmod_t), intent(inout) :: self
    integer(c_int) :: ignored

    if (.not. c_associated(self%common)) return
    ignored = cholmod_free_factor(self%factor, self%common)
    ignored = cholmod_free_dense(self%solution, self%common)
    ignored = cholmod_free_dense(self%permuted, self%common)
    ignored = cholmod_free_dense(self%work, self%common)
    call scree_cholmod_close(self%common)
    self%factor = c_null_ptr
    self%common = c_null_ptr
  end subroutine release_cholmod

end module scree_cholmod
