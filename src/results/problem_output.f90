!> Friction problems in a results file, one group each, for whoever works on solvers of them (tools/bench problems).
module scree_problem_output
  use scree_errors, only: error_t
  use scree_friction_problem, only: friction_problem_t, posed_problem_t, spring_t
  use scree_kinds, only: dp
  use scree_results_file, only: results_t, store_rows
  use scree_sparse_matrix, only: sparse_matrix_t
  use scree_text, only: number_text
  implicit none
  private
  public :: store_problem

contains

  !> Writes a problem as group /problems/NUMBER (doc/results.md). Errors: the file cannot be written.
  subroutine store_problem(results, number, step, posed, error)
    type(results_t), intent(in) :: results
    integer, intent(in) :: number
    integer, intent(in) :: step              !! that posed it
    type(posed_problem_t), intent(in) :: posed
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: group
    real(dp) :: is(4)

    group = '/problems/'//number_text(number)
    associate (problem => posed%problem)
      is = merge(1.0_dp, 0.0_dp, [posed%near, posed%found, problem%matrix%symmetric, problem%symmetric])
      call store_rows(results, group//'/step', [integer ::], .true., '1', 'that posed it', [real(step, dp)], error)
      if (allocated(error)) return
      call store_rows(results, group//'/is', [integer ::], .true., '1', '1 where zero is near its solution; it was solved; its '// &
                      'matrix is symmetric; its springs are', is, error)
      if (allocated(error)) return
      call store_matrix(results, group//'/matrix', problem%matrix, error)
      if (allocated(error)) return
      call store_rows(results, group//'/force', [integer ::], .false., '', 'f', problem%force, error)
      if (allocated(error)) return
      call store_rows(results, group//'/span', [integer ::], .false., 'length', 'displacement that a unit of each unknown makes', &
                      problem%span, error)
      if (allocated(error)) return
      call store_springs(results, group//'/springs', problem, error)
    end associate
  end subroutine store_problem

  !> The entries of a matrix that are not zero.
  subroutine store_matrix(results, group, matrix, error)
    type(results_t), intent(in) :: results
    character(len=*), intent(in) :: group
    type(sparse_matrix_t), intent(in) :: matrix
    type(error_t), allocatable, intent(out) :: error
    integer :: at(2, size(matrix%row)), j, k
    integer, allocatable :: kept(:)

    do j = 1, matrix%n
      do k = matrix%first(j) + 1, matrix%first(j + 1)
        at(:, k) = [matrix%row(k) + 1, j]
      end do
    end do
    kept = pack([(k, k=1, size(matrix%row))], abs(matrix%value) > 0)
    call store_rows(results, group//'/at', [2], .true., '1', 'row and column, from 1, of the entries that are not zero', &
                    [real(at(:, kept), dp)], error)
    if (allocated(error)) return
    call store_rows(results, group//'/value', [integer ::], .false., '', 'of A', matrix%value(kept), error)
  end subroutine store_matrix

  !> Springs and their rows.
  subroutine store_springs(results, group, problem, error)
    type(results_t), intent(in) :: results
    character(len=*), intent(in) :: group
    type(friction_problem_t), intent(in) :: problem
    type(error_t), allocatable, intent(out) :: error
    integer :: row(size(problem%row, 1), size(problem%row, 2)), i, w

    row = 0
    do i = 1, size(row, 2)
      row(:problem%length(i), i) = problem%row(:problem%length(i), i)
    end do
    w = size(row, 1)
    call store_rows(results, group//'/law', [7], .false., '', 'N0, p, T0, k, mu, c of scree_friction_problem, 1 where bonded', &
                    [numbers_of(problem%spring)], error)
    if (allocated(error)) return
    call store_rows(results, group//'/row', [w], .true., '1', 'unknowns of each spring, from 1, then zeros', [real(row, dp)], error)
    if (allocated(error)) return
    call store_rows(results, group//'/force', [w, 2], .false., '', 'n, then t', rows_of(problem%normal, problem%shear), error)
    if (allocated(error) .or. problem%symmetric) return
    call store_rows(results, group//'/change', [w, 2], .false., '', 'n'' and t'', where they are others', &
                    rows_of(problem%normal_change, problem%shear_change), error)
  end subroutine store_springs

  !> The law of each spring as numbers.
  pure function numbers_of(spring) result(number)
    type(spring_t), intent(in) :: spring(:)
    real(dp) :: number(7, size(spring))
    integer :: i

    do i = 1, size(spring)
      associate (own => spring(i))
        number(:, i) = [own%pressing, own%stiffness, own%shear, own%shear_stiffness, own%friction, own%cohesion, &
                        merge(1.0_dp, 0.0_dp, own%bonded)]
      end associate
    end do
  end function numbers_of

  !> Rows across and along, spring after spring.
  pure function rows_of(across, along) result(list)
    real(dp), intent(in) :: across(:, :), along(:, :) !! (w, m)
    real(dp) :: list(2*size(across))
    integer :: i, w

    w = size(across, 1)
    do i = 1, size(across, 2)
      list(2*w*(i - 1) + 1:2*w*i) = [across(:, i), along(:, i)]
    end do
  end function rows_of

end module scree_problem_output
