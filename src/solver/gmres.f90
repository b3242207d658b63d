!> Iterative solution of a sparse system with the factors of a matrix near its own: flexible GMRES (Saad and Schultz 1986,
!> Saad 1993).
!>
!> With S near A the Krylov space of A S^-1 has few dimensions: one for A = S, and about one more for each row by which they
!> differ. What is left of the forces is measured with each component over the root of its entry on the diagonal, so that no unit
!> of an unknown shows.
module scree_gmres
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use scree_errors, only: error_t
  use scree_factors, only: factors_t
  use scree_kinds, only: dp
  use scree_sparse_matrix, only: multiply, sparse_matrix_t
  implicit none
  private
  public :: gmres_t, solve_by_gmres

  integer, parameter :: patient = 10          !! iterations before their rate is judged
  real(dp), parameter :: hopeful = 2.0_dp     !! times as many as allowed are foreseen where it gives up: the last are fast

  !> Memory of the iteration, kept between solutions.
  type :: gmres_t
    private
    real(dp), allocatable :: basis(:, :)     !! (n, most + 1) orthonormal: of the space of what is left, over the root
    real(dp), allocatable :: direction(:, :) !! (n, most) S^-1 of the basis
  end type gmres_t

contains

  !> Continues from x = S^-1 b towards the solution of A x = b. Stops when the norm of the residual, each component over `root`, is
  !> below `goal`, or when `most` iterations do not seem to suffice.
  !>
  !> Errors: no memory.
  subroutine solve_by_gmres(self, matrix, factors, b, root, goal, most, x, Ax, left_over, n_iterations, error)
    type(gmres_t), intent(inout) :: self
    type(sparse_matrix_t), intent(in) :: matrix
    class(factors_t), intent(inout) :: factors !! of S
    real(dp), intent(in) :: b(:)               !! (n)
    real(dp), intent(in) :: root(:)            !! (n) of the diagonal
    real(dp), intent(in) :: goal
    integer, intent(in) :: most                !! iterations
    real(dp), intent(inout) :: x(:)            !! (n) S^-1 b, then the approximation with the least left
    real(dp), intent(in) :: Ax(:)              !! (n) of the first x
    real(dp), intent(out) :: left_over         !! norm of what is left
    integer, intent(out) :: n_iterations
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: R(most, most), left(most + 1), cosine(most), sine(most), column(most + 1), image(size(b)), norm, y(most)
    integer :: i, k

    call reserve(self, size(b), most)
    n_iterations = 0
    norm = norm2(b/root)
    left_over = norm
    if (.not. (norm > 0 .and. ieee_is_finite(norm))) return
    left = 0.0_dp
    left(1) = norm
    associate (basis => self%basis, direction => self%direction)
      basis(:, 1) = b/(root*norm)
      do k = 1, most
        if (k == 1) then
          direction(:, 1) = x/norm
          image = Ax/(root*norm)
        else
          image = root*basis(:, k)
          call factors%solve(image, direction(:, k), error)
          if (allocated(error)) return
          call multiply(matrix, direction(:, k), image)
          image = image/root
        end if
        do i = 1, k
          column(i) = dot_product(image, basis(:, i))
          image = image - column(i)*basis(:, i)
        end do
        column(k + 1) = norm2(image)
        norm = column(k + 1)
        do i = 1, k - 1
          column(i:i + 1) = [cosine(i)*column(i) + sine(i)*column(i + 1), cosine(i)*column(i + 1) - sine(i)*column(i)]
        end do
        R(:k, k) = column(:k)
        R(k, k) = hypot(column(k), norm)
        if (.not. (R(k, k) > 0 .and. ieee_is_finite(R(k, k)))) exit
        cosine(k) = column(k)/R(k, k)
        sine(k) = norm/R(k, k)
        left(k:k + 1) = [cosine(k)*left(k), -sine(k)*left(k)]
        n_iterations = k
        left_over = abs(left(k + 1))
        if (abs(left(k + 1)) <= goal .or. k == most .or. .not. norm > 0) exit
        if (seems_endless(abs(left(k + 1)), abs(left(1)), goal, k, most)) exit
        basis(:, k + 1) = image/norm
      end do
      x = 0.0_dp
      do k = n_iterations, 1, -1
        y(k) = (left(k) - dot_product(R(k, k + 1:n_iterations), y(k + 1:n_iterations)))/R(k, k)
        x = x + y(k)*direction(:, k)
      end do
    end associate
  end subroutine solve_by_gmres

  !> Whether the iteration, that took a norm from `first` to `now` in k steps, would at this rate take far more than `most` to the
  !> goal.
  pure logical function seems_endless(now, first, goal, k, most)
    real(dp), intent(in) :: now, first, goal
    integer, intent(in) :: k, most

    seems_endless = .false.
    if (k >= patient) seems_endless = k*log(first/goal) > hopeful*most*log(first/now)
  end function seems_endless

  !> Memory for as many iterations.
  pure subroutine reserve(self, n, most)
    type(gmres_t), intent(inout) :: self
    integer, intent(in) :: n, most

    if (allocated(self%direction)) then
      if (size(self%direction, 1) == n .and. size(self%direction, 2) >= most) return
      deallocate (self%basis, self%direction)
    end if
    allocate (self%basis(n, most + 1), self%direction(n, most))
  end subroutine reserve

end module scree_gmres
