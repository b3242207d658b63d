!> Solution of A x = b. This file is the only one that knows how: another strategy is written here.
!>
!> - A small matrix, of one element, goes to LAPACK.
!> - A sparse matrix goes to CHOLMOD where it is symmetric and turns out to be positive definite, else to UMFPACK.
!>
!> A caller says how exact the solution has to be, and is told how exact it is. The residual is the largest component of b - A x
!> over the largest magnitude of what cancels in one, each over the root of its entry on the diagonal:
!>
!>     max_i |b - A x|_i / sqrt(a_ii)  /  max_i (|A| |x| + |b|)_i / sqrt(a_ii)
!>
!> So it does not depend on the units of the unknowns: the squares are energies, of what each component would move by itself. It is
!> the backward error (Rigal and Gaches 1967) of the system scaled to a unit diagonal, of which a direct solution leaves some
!> round-off (Demmel 1989). One that is not exact enough is refined with the same factors.
module scree_linear_solver
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use scree_cholmod, only: cholmod_t, factorise_by_cholmod, release_cholmod, solve_by_cholmod
  use scree_dense_solver, only: largest_dense, solve_dense
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_kinds, only: dp
  use scree_sparse_matrix, only: products, root_of_diagonal, root_of_entry, sparse_matrix_t
  use scree_text, only: rounded_text
  use scree_umfpack, only: factorise_by_umfpack, release_umfpack, solve_by_umfpack, umfpack_t
  implicit none
  private
  public :: linear_solver_t, release_solver, small_matrix_t, solve

  integer, parameter :: most_refinements = 2

  !> What is kept between solutions with matrices of one pattern: analyses, and memory of factors. No solution depends on those
  !> before it.
  type :: linear_solver_t
    private
    type(cholmod_t) :: cholmod
    type(umfpack_t) :: umfpack
    logical :: definite = .false. !! the last matrix was: CHOLMOD has its factor
  end type linear_solver_t

  !> The matrix of one element, on its free unknowns.
  type :: small_matrix_t
    integer :: n = 0
    logical :: symmetric = .true.  !! but for round-off
    real(dp) :: value(largest_dense, largest_dense) = 0.0_dp !! (n, n) of it
  end type small_matrix_t

  !> Solves A x = b to a tolerance.
  interface solve
    module procedure solve_sparse, solve_small
  end interface solve

contains

  !> Solves A x = b to a residual below `tolerance`.
  !>
  !> The pattern of A is that of the last solution, or `release_solver` was called. Errors: a singular matrix, no memory, a residual
  !> that refinement does not take below the tolerance.
  subroutine solve_sparse(solver, matrix, b, tolerance, x, residual, error)
    type(linear_solver_t), intent(inout) :: solver
    type(sparse_matrix_t), intent(in) :: matrix
    real(dp), intent(in) :: b(:)         !! (n)
    real(dp), intent(in) :: tolerance
    real(dp), intent(out) :: x(:)        !! (n)
    real(dp), intent(out) :: residual
    type(error_t), allocatable, intent(out) :: error
    real(dp), dimension(size(b)) :: change, rest, root
    real(dp) :: product(2, size(b))
    integer :: i

    residual = huge(residual)
    root = root_of_diagonal(matrix)
    call factorise(solver, matrix, error)
    if (allocated(error)) return
    call apply(solver, matrix, b, x, error)
    do i = 0, most_refinements
      if (allocated(error)) return
      product = products(matrix, x)
      rest = b - product(1, :)
      residual = residual_of(rest, abs(b) + product(2, :), root)
      if (residual <= tolerance .or. i == most_refinements) exit
      call apply(solver, matrix, rest, change, error)
      x = x + change
    end do
    call check_residual(residual, tolerance, error)
  end subroutine solve_sparse

  !> Factorises a sparse matrix.
  subroutine factorise(solver, matrix, error)
    type(linear_solver_t), intent(inout) :: solver
    type(sparse_matrix_t), intent(in) :: matrix
    type(error_t), allocatable, intent(out) :: error

    solver%definite = .false.
    if (matrix%symmetric) call factorise_by_cholmod(solver%cholmod, matrix, solver%definite, error)
    if (solver%definite .or. allocated(error)) return
    call factorise_by_umfpack(solver%umfpack, matrix, error)
  end subroutine factorise

  !> Solves with the factors of the matrix.
  subroutine apply(solver, matrix, b, x, error)
    type(linear_solver_t), intent(in) :: solver
    type(sparse_matrix_t), intent(in) :: matrix
    real(dp), intent(in) :: b(:)
    real(dp), intent(out) :: x(:)
    type(error_t), allocatable, intent(out) :: error

    if (solver%definite) then
      call solve_by_cholmod(solver%cholmod, b, x, error)
    else
      call solve_by_umfpack(solver%umfpack, matrix, b, x, error)
    end if
  end subroutine apply

  !> Solves A x = b to a residual below `tolerance`, for one element.
  !>
  !> Errors: a singular matrix, a residual that refinement does not take below the tolerance.
  subroutine solve_small(matrix, b, tolerance, x, residual, error)
    type(small_matrix_t), intent(in) :: matrix
    real(dp), intent(in) :: b(:)         !! (n)
    real(dp), intent(in) :: tolerance
    real(dp), intent(out) :: x(:)        !! (n)
    real(dp), intent(out) :: residual
    type(error_t), allocatable, intent(out) :: error
    real(dp), dimension(size(b)) :: change, magnitude, rest, root
    real(dp) :: part
    integer :: i, j, k

    residual = huge(residual)
    associate (A => matrix%value, n => matrix%n)
      do j = 1, n
        root(j) = root_of_entry(A(j, j), A(:n, j))
      end do
      call solve_dense(A(:n, :n), b, matrix%symmetric, x, error)
      do i = 0, most_refinements
        if (allocated(error)) return
        rest = b
        magnitude = abs(b)
        do j = 1, n
          do k = 1, n
            part = A(k, j)*x(j)
            rest(k) = rest(k) - part
            magnitude(k) = magnitude(k) + abs(part)
          end do
        end do
        residual = residual_of(rest, magnitude, root)
        if (residual <= tolerance .or. i == most_refinements) exit
        call solve_dense(A(:n, :n), rest, matrix%symmetric, change, error)
        x = x + change
      end do
    end associate
    call check_residual(residual, tolerance, error)
  end subroutine solve_small

  !> The residual; huge where a component is no number.
  pure real(dp) function residual_of(rest, magnitude, root)
    real(dp), intent(in) :: rest(:)      !! b - A x
    real(dp), intent(in) :: magnitude(:) !! |A| |x| + |b|
    real(dp), intent(in) :: root(:)      !! of the diagonal
    real(dp) :: largest, left
    integer :: i

    left = 0.0_dp
    largest = tiny(largest)
    residual_of = huge(residual_of)
    do i = 1, size(rest)
      if (ieee_is_nan(rest(i))) return
      left = max(left, abs(rest(i))/root(i))
      largest = max(largest, magnitude(i)/root(i))
    end do
    residual_of = left/largest
  end function residual_of

  !> Errors: a residual above the tolerance.
  subroutine check_residual(residual, tolerance, error)
    real(dp), intent(in) :: residual, tolerance
    type(error_t), allocatable, intent(out) :: error

    if (residual > tolerance) call fail(error, status_run_failed, 'the matrix of the blocks is singular to round-off (its '// &
                                        'solution leaves a share of '//rounded_text(residual)//' of the forces out of balance)')
  end subroutine check_residual

  !> Gives the memory back; the next solution analyses its matrix anew.
  subroutine release_solver(solver)
    type(linear_solver_t), intent(inout) :: solver

    call release_cholmod(solver%cholmod)
    call release_umfpack(solver%umfpack)
  end subroutine release_solver

end module scree_linear_solver
