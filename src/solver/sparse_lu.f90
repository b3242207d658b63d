!> LU of an unsymmetric sparse matrix: of its entries that are not zero, by the library that is the quicker one.
!>
!> A pattern has room for all contacts that may close, of which most are open where bodies fall apart: without their zeros the
!> factors have a third to a half of the entries. KLU, which goes column by column, is the quicker one where an entry of the factors
!> takes few operations; UMFPACK, with its dense blocks, where it takes many (the rule of CHOLMOD, Chen et al. 2008).
module scree_sparse_lu
  use, intrinsic :: iso_c_binding, only: c_double, c_int
  use scree_errors, only: error_t
  use scree_factored, only: same_columns
  use scree_factors, only: factors_t
  use scree_kinds, only: dp
  use scree_klu, only: analyse_by_klu, factorise_by_klu, forget_klu_pivots, klu_t, release_klu
  use scree_sparse_matrix, only: sparse_matrix_t
  use scree_umfpack, only: factorise_by_umfpack, release_umfpack, umfpack_t
  implicit none
  private
  public :: factorise_by_lu, forget_pivots, release_lu, sparse_lu_t

  !> Operations an entry of the lower factor, from which UMFPACK is the quicker one (columns and slopes of 100 to 697 blocks).
  real(dp), parameter :: many_operations = 100.0_dp

  !> The pattern that was analysed, and the factors of the last matrix.
  type, extends(factors_t) :: sparse_lu_t
    private
    integer(c_int), allocatable :: first(:), row(:) !! (n+1), (n_entries), from 0
    logical :: by_klu = .true.                      !! else by UMFPACK
    type(klu_t) :: klu
    type(umfpack_t) :: umfpack
  contains
    procedure :: solve => solve_by_lu
  end type sparse_lu_t

contains

  !> Factorises a matrix. Errors: it is singular, no memory.
  subroutine factorise_by_lu(self, matrix, error)
    type(sparse_lu_t), intent(inout) :: self
    type(sparse_matrix_t), intent(in) :: matrix
    type(error_t), allocatable, intent(out) :: error
    integer(c_int) :: first(matrix%n + 1), row(size(matrix%row))
    real(c_double) :: value(size(matrix%row))
    real(dp) :: operations
    integer :: j, k, m
    logical :: known

    m = 0
    first(1) = 0
    do j = 1, matrix%n
      do k = matrix%first(j) + 1, matrix%first(j + 1)
        if (.not. abs(matrix%value(k)) > 0) cycle
        m = m + 1
        row(m) = matrix%row(k)
        value(m) = matrix%value(k)
      end do
      first(j + 1) = m
    end do
    known = allocated(self%row)
    if (known) known = same_columns(self%first, self%row, first, row(:m))
    if (.not. known) then
      call release_lu(self)
      self%first = first
      self%row = row(:m)
      call analyse_by_klu(self%klu, self%first, self%row, operations, error)
      self%by_klu = operations < many_operations
    end if
    if (.not. allocated(error)) then
      if (self%by_klu) then
        call factorise_by_klu(self%klu, self%first, self%row, value(:m), error)
      else
        call factorise_by_umfpack(self%umfpack, self%first, self%row, value(:m), error)
      end if
    end if
    if (allocated(error)) call release_lu(self)
  end subroutine factorise_by_lu

  !> Solves A x = b with the factors of the last matrix. Errors: no memory.
  subroutine solve_by_lu(self, b, x, error)
    class(sparse_lu_t), intent(inout) :: self
    real(dp), intent(in), target, contiguous :: b(:)
    real(dp), intent(out) :: x(:)
    type(error_t), allocatable, intent(out) :: error

    if (self%by_klu) then
      call self%klu%solve(b, x, error)
    else
      call self%umfpack%solve(b, x, error)
    end if
  end subroutine solve_by_lu

  !> Lets the next matrix have pivots of its own: no earlier one shows in its solutions.
  subroutine forget_pivots(self)
    type(sparse_lu_t), intent(inout) :: self

    call forget_klu_pivots(self%klu)
  end subroutine forget_pivots

  !> Gives the memory back; the next matrix is analysed anew.
  subroutine release_lu(self)
    type(sparse_lu_t), intent(inout) :: self

    call release_klu(self%klu)
    call release_umfpack(self%umfpack)
    if (allocated(self%first)) deallocate (self%first, self%row)
  end subroutine release_lu

end module scree_sparse_lu
