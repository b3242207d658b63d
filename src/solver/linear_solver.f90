!> Solution of A x = b. This file is the only one that knows how: another strategy is written here. Small dense systems within a
!> friction problem are solved there (`scree_friction_path`).
!>
!> - A small matrix, of one element or an island of two, goes to LAPACK.
!> - A sparse matrix is solved by GMRES, preconditioned with the CHOLMOD factor of the symmetric matrix beside it, or of an earlier
!>   such matrix. A factor costs as much as 10 solutions with it, and contacts change few rows from one matrix to the next.
!> - Otherwise the matrix is factorised itself: by CHOLMOD if it is symmetric and turns out to be positive definite, else as LU.
!>   GMRES continues with this LU for similar matrices of the same step.
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
  use scree_cholmod, only: cholmod_t, factorise_by_cholmod, release_cholmod
  use scree_dense_solver, only: largest_dense, solve_dense
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_factored, only: factored_t, is_of, move_factored, same_columns
  use scree_factors, only: factors_t
  use scree_gmres, only: gmres_t, solve_by_gmres
  use scree_kinds, only: dp
  use scree_sparse_matrix, only: multiply, products, root_of_diagonal, root_of_entry, sparse_matrix_t, symmetric_diagonal, &
                                 symmetric_matrix
  use scree_sparse_lu, only: factorise_by_lu, forget_pivots, release_lu, sparse_lu_t
  use scree_text, only: rounded_text
  use scree_timers, only: begin_phase, end_phase, phase_factor, timers_t
  implicit none
  private
  public :: add_work, approach, dense_matrix, exactness_t, factorise, factorise_beside, keep_matrix, largest_dense, &
            linear_solver_t, recall_matrix, release_solver, small_matrix_t, solve, solve_with_factors, solve_with_kept_factor, &
            solver_work_t

  integer, parameter :: most_refinements = 2
  !> Iterations of GMRES with the factor of a matrix before, and with a new one, which takes 4 to 13. A factor costs as much as 10
  !> whatever the size (walls of 106 to 1621 blocks), a row that has changed up to a sixth of one.
  integer, parameter :: most_with_old = 25, most_with_new = 40, most_with_own = 10
  integer, parameter :: most_spent = 30       !! iterations with a factor, but for two of each solution, after which it is old
  integer, parameter :: most_changed = 60     !! rows that have changed, after which it is, too
  real(dp), parameter :: changed = 1e-2_dp    !! change over the diagonal from which a row counts as changed
  !> Norm of the residual at which an iteration stops, over the norm of the balancing forces; for a rough solution, over the norm of
  !> b.
  real(dp), parameter :: least_left = 3e-13_dp, roughly_left = 1e-2_dp
  real(dp), parameter :: near_goal = 10.0_dp !! accepted residual over the residual at which an iteration stops

  !> What solutions took so far.
  type :: solver_work_t
    integer :: symmetric_factors = 0 !! by CHOLMOD
    integer :: other_factors = 0     !! by KLU or UMFPACK
    integer :: iterations = 0        !! of GMRES
  end type solver_work_t

  !> What is kept between solutions with matrices of the same rows: analyses, memory, and a factor to go on from.
  type :: linear_solver_t
    private
    type(cholmod_t) :: cholmod
    type(sparse_lu_t) :: lu
    type(gmres_t) :: gmres
    logical :: definite = .false.   !! the last matrix was: CHOLMOD has its factor
    type(factored_t) :: kept        !! has the pattern of CHOLMOD's analysis, and values where there is a matrix to go on from
    logical :: factorised = .false. !! CHOLMOD has the factor of what is kept
    logical :: newly_kept = .false. !! since the last was handed on
    logical :: goes_on = .false.    !! LU has the factors of a matrix since then, from which solutions go on
    type(solver_work_t), public :: work
  end type linear_solver_t

  !> How exact a solution is to be.
  type :: exactness_t
    real(dp) :: tolerance            !! of the residual
    logical :: keeps_factor = .false. !! that of a matrix before may do
    logical :: by_balance = .false.  !! where it does, what is left is measured by what balances, else by what does not
    logical :: roughly = .false.     !! where it does, so exactly: another correction follows, whatever this one is
  end type exactness_t

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

  !> Adds work to what was done before.
  pure subroutine add_work(work, sum)
    type(solver_work_t), intent(in) :: work
    type(solver_work_t), intent(inout) :: sum

    sum%symmetric_factors = sum%symmetric_factors + work%symmetric_factors
    sum%other_factors = sum%other_factors + work%other_factors
    sum%iterations = sum%iterations + work%iterations
  end subroutine add_work

  !> Solves A x = b to a residual below `tolerance`, with factors of A.
  !>
  !> Errors: a singular matrix, no memory, a residual that refinement does not take below the tolerance.
  subroutine solve_sparse(solver, matrix, b, tolerance, timers, x, residual, error)
    type(linear_solver_t), intent(inout) :: solver
    type(sparse_matrix_t), intent(in) :: matrix
    real(dp), intent(in) :: b(:)         !! (n)
    real(dp), intent(in) :: tolerance
    type(timers_t), intent(inout) :: timers
    real(dp), intent(out) :: x(:)        !! (n)
    real(dp), intent(out) :: residual
    type(error_t), allocatable, intent(out) :: error

    residual = huge(residual)
    call factorise(solver, matrix, timers, error)
    if (allocated(error)) return
    call refine(solver, matrix, b, tolerance, x, residual, error)
  end subroutine solve_sparse

  !> Solves A x = b to a residual below a tolerance, with the factor of an earlier matrix where that does.
  !>
  !> What may be left is measured by what balances in b, as b itself is next to nothing where a correction is the last of many.
  !> Which matrix that is shows in the last bits of x (`keep_matrix`, `recall_matrix`). Where GMRES takes too many iterations from
  !> there, the symmetric matrix beside A is factorised; where that is not definite or does not do either, A itself. A rough
  !> solution leaves up to 1e-2 of the norm of b, which it tells as its residual. Errors as of `solve_sparse`.
  subroutine solve_with_kept_factor(solver, matrix, b, scale, exactness, timers, x, residual, error)
    type(linear_solver_t), intent(inout) :: solver
    type(sparse_matrix_t), intent(in) :: matrix
    real(dp), intent(in) :: b(:)         !! (n)
    real(dp), intent(in) :: scale(:)     !! (n) magnitudes of what balances in b
    type(exactness_t), intent(in) :: exactness
    type(timers_t), intent(inout) :: timers
    real(dp), intent(out) :: x(:)        !! (n)
    real(dp), intent(out) :: residual
    type(error_t), allocatable, intent(out) :: error
    logical :: definite, done

    if (solver%goes_on .and. .not. matrix%symmetric) then
      call iterate(solver, matrix, b, scale, exactness, most_with_own, x, residual, done, error)
      if (allocated(error) .or. done) return
      call solve_by_itself()
      return
    end if
    solver%goes_on = .false.
    if (may_do(solver%kept, matrix)) then
      if (.not. solver%factorised) call factorise_kept(solver, timers, definite, error)
      if (allocated(error)) return
      call iterate(solver, matrix, b, scale, exactness, most_with_old, x, residual, done, error)
      if (allocated(error) .or. done) return
    end if
    call factorise_beside(solver, matrix, timers, definite, error)
    if (allocated(error)) return
    if (definite .and. .not. matrix%symmetric) then
      call iterate(solver, matrix, b, scale, exactness, most_with_new, x, residual, done, error)
      if (allocated(error) .or. done) return
    end if
    if (definite .and. matrix%symmetric) then
      solver%definite = .true.
      call refine(solver, matrix, b, exactness%tolerance, x, residual, error)
    else
      call solve_by_itself()
    end if

  contains

    !> Solves with factors of the matrix itself, from which later solutions go on.
    subroutine solve_by_itself()

      call factorise_itself(solver, matrix, timers, error)
      if (.not. allocated(error)) call refine(solver, matrix, b, exactness%tolerance, x, residual, error)
      solver%goes_on = .not. allocated(error)
    end subroutine solve_by_itself

  end subroutine solve_with_kept_factor

  !> Solves by GMRES with the factor that is kept, where it gets there.
  !>
  !> It goes on until what is left is next to nothing beside what balances in b. The residual alone would not do: the factor of
  !> another matrix gives soft modes displacements so large that, beside what cancels in these, all of b looks like round-off.
  subroutine iterate(solver, matrix, b, scale, exactness, most, x, residual, done, error)
    type(linear_solver_t), intent(inout) :: solver
    type(sparse_matrix_t), intent(in) :: matrix
    real(dp), intent(in) :: b(:)         !! (n)
    real(dp), intent(in) :: scale(:)     !! (n) magnitudes of what balances in b
    type(exactness_t), intent(in) :: exactness !! its tolerance also bounds the residual over the norm of `scale`
    integer, intent(in) :: most          !! iterations
    real(dp), intent(out) :: x(:)        !! (n)
    real(dp), intent(out) :: residual
    logical, intent(out) :: done
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: root(size(b)), product(2, size(b)), goal, norm, share, whole

    residual = huge(residual)
    done = .false.
    root = root_of_diagonal(matrix)
    norm = norm2(b/root)
    whole = max(norm, norm2(scale/root))
    goal = least_left*whole/max(norm, least_left*whole, tiny(norm))
    if (exactness%roughly) goal = max(goal, roughly_left)
    call approach(solver, matrix, b, goal, most, x, share, error)
    if (allocated(error)) return
    done = exactness%roughly .and. share <= goal
    if (done) residual = share
    if (exactness%roughly .or. share > near_goal*goal) return
    product = products(matrix, x)
    if (norm2((b - product(1, :))/root) > exactness%tolerance*whole) return
    residual = residual_of(b - product(1, :), max(abs(b), scale) + product(2, :), root)
    done = residual <= exactness%tolerance
  end subroutine iterate

  !> Approaches the solution of A x = b by GMRES. The preconditioner is the kept factor of a symmetric matrix near A, or the LU of a
  !> matrix like A if solutions go on from that LU. Stops when the norm of the residual is at most `goal` times the norm of b, each
  !> component over the root of its entry on the diagonal. Errors: no memory.
  subroutine approach(solver, matrix, b, goal, most, x, share, error)
    type(linear_solver_t), intent(inout) :: solver
    type(sparse_matrix_t), intent(in) :: matrix
    real(dp), intent(in) :: b(:)         !! (n)
    real(dp), intent(in) :: goal         !! share
    integer, intent(in) :: most          !! iterations
    real(dp), intent(out) :: x(:)        !! (n)
    real(dp), intent(out) :: share       !! that is left
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: root(size(b)), Ax(size(b)), norm
    integer :: n_iterations

    root = root_of_diagonal(matrix)
    norm = norm2(b/root)
    n_iterations = 0
    if (solver%goes_on) then
      call approach_by(solver%lu)
    else
      call approach_by(solver%cholmod)
      solver%kept%spent = solver%kept%spent + max(0, n_iterations - 2)
    end if
    if (allocated(error)) return
    solver%work%iterations = solver%work%iterations + n_iterations
    share = share/max(norm, tiny(norm))

  contains

    !> Approaches the solution with these factors.
    subroutine approach_by(factors)
      class(factors_t), intent(inout) :: factors

      call factors%solve(b, x, error)
      if (allocated(error)) return
      call multiply(matrix, x, Ax)
      share = norm2((b - Ax)/root)
      if (.not. share <= goal*norm) &
        call solve_by_gmres(solver%gmres, matrix, factors, b, root, goal*norm, most, x, Ax, share, n_iterations, error)
    end subroutine approach_by

  end subroutine approach

  !> Solves with the factors of the matrix, and refines the solution with them until its residual is below the tolerance.
  subroutine refine(solver, matrix, b, tolerance, x, residual, error)
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
    call solve_with_factors(solver, b, x, error)
    do i = 0, most_refinements
      if (allocated(error)) return
      product = products(matrix, x)
      rest = b - product(1, :)
      residual = residual_of(rest, abs(b) + product(2, :), root)
      if (residual <= tolerance .or. i == most_refinements) exit
      call solve_with_factors(solver, rest, change, error)
      x = x + change
    end do
    call check_residual(residual, tolerance, error)
  end subroutine refine

  !> Factorises a sparse matrix. Errors: it is singular, no memory.
  subroutine factorise(solver, matrix, timers, error)
    type(linear_solver_t), intent(inout) :: solver
    type(sparse_matrix_t), intent(in) :: matrix
    type(timers_t), intent(inout) :: timers
    type(error_t), allocatable, intent(out) :: error
    logical :: definite

    definite = .false.
    if (matrix%symmetric) call factorise_beside(solver, matrix, timers, definite, error)
    solver%definite = definite
    if (definite .or. allocated(error)) return
    call factorise_itself(solver, matrix, timers, error)
  end subroutine factorise

  !> Factorises the symmetric matrix beside one, and keeps it where it is definite.
  subroutine factorise_beside(solver, matrix, timers, definite, error)
    type(linear_solver_t), intent(inout) :: solver
    type(sparse_matrix_t), intent(in) :: matrix
    type(timers_t), intent(inout) :: timers
    logical, intent(out) :: definite
    type(error_t), allocatable, intent(out) :: error
    type(factored_t) :: symmetric

    symmetric = symmetric_matrix(matrix)
    if (.not. same_pattern(solver%kept, symmetric)) call release_cholmod(solver%cholmod)
    call move_factored(symmetric, solver%kept)
    solver%newly_kept = .true.
    call factorise_kept(solver, timers, definite, error)
  end subroutine factorise_beside

  !> Factorises the matrix that is kept. One that is not definite is kept no longer.
  subroutine factorise_kept(solver, timers, definite, error)
    type(linear_solver_t), intent(inout) :: solver
    type(timers_t), intent(inout) :: timers
    logical, intent(out) :: definite
    type(error_t), allocatable, intent(out) :: error

    call begin_phase(timers, phase_factor)
    associate (kept => solver%kept)
      call factorise_by_cholmod(solver%cholmod, kept%first, kept%row, kept%value, definite, error)
      solver%work%symmetric_factors = solver%work%symmetric_factors + 1
      solver%factorised = definite
      if (.not. definite) deallocate (kept%value)
    end associate
    call end_phase(timers)
  end subroutine factorise_kept

  !> Factorises a matrix that is not symmetric, or not definite.
  subroutine factorise_itself(solver, matrix, timers, error)
    type(linear_solver_t), intent(inout) :: solver
    type(sparse_matrix_t), intent(in) :: matrix
    type(timers_t), intent(inout) :: timers
    type(error_t), allocatable, intent(out) :: error

    solver%definite = .false.
    solver%work%other_factors = solver%work%other_factors + 1
    call begin_phase(timers, phase_factor)
    call factorise_by_lu(solver%lu, matrix, error)
    call end_phase(timers)
  end subroutine factorise_itself

  !> Whether two matrices have the same pattern.
  pure logical function same_pattern(a, b)
    type(factored_t), intent(in) :: a, b

    same_pattern = allocated(a%row)
    if (same_pattern) same_pattern = same_columns(a%first, a%row, b%first, b%row)
  end function same_pattern

  !> Whether to go on from the factor that is kept: it has not cost more than a new one would, and few rows of the symmetric matrix
  !> beside have changed. What friction adds is not in the factor, nor would it be in a new one.
  pure logical function may_do(kept, matrix)
    type(factored_t), intent(in) :: kept
    type(sparse_matrix_t), intent(in) :: matrix
    real(dp) :: now(matrix%n)

    may_do = allocated(kept%value)
    if (.not. may_do) return
    may_do = kept%spent <= most_spent
    if (.not. may_do) return
    now = symmetric_diagonal(matrix)
    may_do = count(abs(now - kept%value(kept%first(:matrix%n) + 1)) > changed*now) <= most_changed
  end function may_do

  !> Solves with the factors of the matrix that was factorised last. Errors: no memory.
  subroutine solve_with_factors(solver, b, x, error)
    type(linear_solver_t), intent(inout) :: solver
    real(dp), intent(in), contiguous :: b(:) !! (n)
    real(dp), intent(out) :: x(:)        !! (n)
    type(error_t), allocatable, intent(out) :: error

    if (solver%definite) then
      call solver%cholmod%solve(b, x, error)
    else
      call solver%lu%solve(b, x, error)
    end if
  end subroutine solve_with_factors

  !> Hands on the matrix whose factor is kept, where it is another than was handed on before; one without values where none is kept.
  pure subroutine keep_matrix(solver, unknown, factored)
    type(linear_solver_t), intent(inout) :: solver
    integer, intent(in) :: unknown(:)    !! (n) of each row
    type(factored_t), intent(inout) :: factored

    if (.not. (allocated(solver%kept%value) .and. allocated(factored%unknown))) then
      factored = factored_t()
      factored%unknown = unknown
    end if
    if (solver%newly_kept .and. allocated(solver%kept%value)) then
      factored = solver%kept
      factored%unknown = unknown
    end if
    factored%spent = solver%kept%spent
    solver%newly_kept = .false.
  end subroutine keep_matrix

  !> Goes on from the matrix that was handed on, where it is of these unknowns: what a try that is rejected has factorised is
  !> forgotten. Its factor is made when a solution needs it, where none is kept.
  subroutine recall_matrix(solver, unknown, factored)
    type(linear_solver_t), intent(inout) :: solver
    integer, intent(in) :: unknown(:)    !! (n) of each row
    type(factored_t), intent(in) :: factored

    solver%goes_on = .false.
    call forget_pivots(solver%lu)
    if (.not. solver%newly_kept .and. allocated(solver%kept%value)) then
      solver%kept%spent = factored%spent
      return
    end if
    solver%newly_kept = .false.
    if (allocated(solver%kept%value)) deallocate (solver%kept%value)
    if (.not. allocated(factored%value)) return
    if (.not. is_of(factored, unknown)) return
    if (.not. same_pattern(solver%kept, factored)) call release_cholmod(solver%cholmod)
    solver%kept = factored
    solver%factorised = .false.
  end subroutine recall_matrix

  !> A small matrix that was assembled as a sparse one.
  pure type(small_matrix_t) function dense_matrix(matrix) result(small)
    type(sparse_matrix_t), intent(in) :: matrix
    integer :: j, k

    small%n = matrix%n
    small%symmetric = matrix%symmetric
    do j = 1, matrix%n
      do k = matrix%first(j) + 1, matrix%first(j + 1)
        small%value(matrix%row(k) + 1, j) = matrix%value(k)
      end do
    end do
  end function dense_matrix

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
    real(dp), dimension(largest_dense) :: change, magnitude, rest, root
    real(dp) :: part
    integer :: i, j, k, n

    residual = huge(residual)
    n = matrix%n
    associate (A => matrix%value)
      do j = 1, n
        root(j) = root_of_entry(A(j, j), A(:n, j))
      end do
      call solve_dense(A(:n, :n), b, matrix%symmetric, x, error)
      do i = 0, most_refinements
        if (allocated(error)) return
        rest(:n) = b
        magnitude(:n) = abs(b)
        do j = 1, n
          do k = 1, n
            part = A(k, j)*x(j)
            rest(k) = rest(k) - part
            magnitude(k) = magnitude(k) + abs(part)
          end do
        end do
        residual = residual_of(rest(:n), magnitude(:n), root(:n))
        if (residual <= tolerance .or. i == most_refinements) exit
        call solve_dense(A(:n, :n), rest(:n), matrix%symmetric, change(:n), error)
        x = x + change(:n)
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

  !> Gives the memory back, and keeps nothing; the next solution analyses its matrix anew.
  subroutine release_solver(solver)
    type(linear_solver_t), intent(inout) :: solver

    call release_cholmod(solver%cholmod)
    call release_lu(solver%lu)
    solver%kept = factored_t()
    solver%factorised = .false.
    solver%newly_kept = .false.
    solver%goes_on = .false.
  end subroutine release_solver

end module scree_linear_solver
