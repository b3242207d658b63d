!> Small dense systems by LAPACK: what a free block needs.
module scree_dense_solver
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_kinds, only: dp
  implicit none
  private
  public :: dgesv, solve_dense

  integer, parameter, public :: largest_dense = 12 !! unknowns, so that the work space is on the stack

  interface
    !> LAPACK: Cholesky factorisation and solution.
    subroutine dposv(uplo, n, nrhs, a, lda, b, ldb, info)
      import :: dp
      character(len=1), intent(in) :: uplo
      integer, intent(in) :: n, nrhs, lda, ldb
      real(dp), intent(inout) :: a(lda, *), b(ldb, *)
      integer, intent(out) :: info
    end subroutine dposv

    !> LAPACK: LU factorisation with partial pivoting and solution.
    subroutine dgesv(n, nrhs, a, lda, ipiv, b, ldb, info)
      import :: dp
      integer, intent(in) :: n, nrhs, lda, ldb
      real(dp), intent(inout) :: a(lda, *), b(ldb, *)
      integer, intent(out) :: ipiv(*), info
    end subroutine dgesv
  end interface

contains

  !> Solves K x = f for up to 12 unknowns.
  !>
  !> A symmetric matrix is scaled to a unit diagonal and tried by Cholesky; one that is not positive definite, as a
  !> tangent in compression may be, goes to LU as the unsymmetric do. Errors: the matrix is singular.
  subroutine solve_dense(K, f, symmetric, x, error)
    real(dp), intent(in) :: K(:, :)  !! (n, n)
    real(dp), intent(in) :: f(:)     !! (n)
    logical, intent(in) :: symmetric
    real(dp), intent(out) :: x(:)    !! (n)
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: A(largest_dense, largest_dense), b(largest_dense, 1), scale(largest_dense)
    integer :: pivot(largest_dense), i, info, n

    n = size(f)
    if (n == 0) return
    if (symmetric .and. all([(K(i, i) > 0.0_dp, i=1, n)])) then
      do i = 1, n
        scale(i) = 1/sqrt(K(i, i))
      end do
      do i = 1, n
        A(:n, i) = scale(i)*scale(:n)*K(:, i)
      end do
      b(:n, 1) = scale(:n)*f
      call dposv('L', n, 1, A, largest_dense, b, largest_dense, info)
      if (info == 0) then
        x = scale(:n)*b(:n, 1)
        return
      end if
    end if
    A(:n, :n) = K
    b(:n, 1) = f
    call dgesv(n, 1, A, largest_dense, pivot, b, largest_dense, info)
    if (info /= 0) then
      call fail(error, status_run_failed, 'a block has no stiffness or mass against some motion (its matrix is singular)')
      return
    end if
    x = b(:n, 1)
  end subroutine solve_dense

end module scree_dense_solver
