!> Anderson acceleration of a fixed point iteration (Anderson, J. ACM 12, 1965; Walker & Ni, SIAM J. Numer. Anal. 49, 2011).
!>
!> From x_j the iteration would take the step r_j. DX and DR are the differences between successive kept x and r. The step starts
!> from the point of their plane at which a linear r would be smallest,
!>
!>     x <- x + b r - (DX + b DR) g,   g = argmin |w (r - DR g)|,   b: the part of r that is taken, w: weights of the unknowns.
!>
!> For a linear r with as many differences as r has eigenvalues this is the solution: GMRES by another name.
module scree_anderson
  use scree_kinds, only: dp
  implicit none
  private
  public :: anderson_t, mix_step

  !> A column of DR is ignored if the other columns explain it to within this ratio to the largest column (`rcond` of LAPACK).
  real(dp), parameter :: told = 1e-8_dp

  !> What an iteration remembers.
  type :: anderson_t
    integer :: kept = 0                              !! differences
    real(dp), allocatable :: place(:), step(:)       !! (n) x and r of the last
    real(dp), allocatable :: places(:, :), steps(:, :) !! (n, depth) DX and DR, the last first
  end type anderson_t

  interface
    !> LAPACK: least squares by QR with column pivoting.
    subroutine dgelsy(m, n, nrhs, a, lda, b, ldb, jpvt, rcond, rank, work, lwork, info)
      import :: dp
      integer, intent(in) :: m, n, nrhs, lda, ldb, lwork
      integer, intent(inout) :: jpvt(*)
      real(dp), intent(inout) :: a(lda, *), b(ldb, *), work(*)
      real(dp), intent(in) :: rcond
      integer, intent(out) :: rank, info
    end subroutine dgelsy
  end interface

contains

  !> Mixes the step from a place with the last ones before it.
  subroutine mix_step(self, depth, share, weight, place, step)
    type(anderson_t), intent(inout) :: self
    integer, intent(in) :: depth             !! differences that are kept at most
    real(dp), intent(in) :: share            !! part of the step that is taken
    real(dp), intent(in) :: weight(:)        !! (n) of the unknowns
    real(dp), intent(in) :: place(:)         !! (n)
    real(dp), intent(inout) :: step(:)       !! (n) that the iteration would go, then goes
    real(dp), allocatable :: A(:, :), b(:, :), work(:)
    integer, allocatable :: pivot(:)
    integer :: info, k, n, rank

    n = size(step)
    if (.not. allocated(self%places)) then
      allocate (self%places(n, depth), self%steps(n, depth))
    else if (depth > 0) then
      self%kept = min(self%kept + 1, depth)
      self%places(:, 2:self%kept) = self%places(:, :self%kept - 1)
      self%steps(:, 2:self%kept) = self%steps(:, :self%kept - 1)
      self%places(:, 1) = place - self%place
      self%steps(:, 1) = step - self%step
    end if
    self%place = place
    self%step = step
    step = share*step
    k = min(self%kept, n)
    if (k == 0) return
    A = spread(weight, 2, k)*self%steps(:, :k)
    b = reshape(weight*self%step, [n, 1])
    allocate (pivot(k), source=0)
    allocate (work(64*(2*k + 2) + n))
    call dgelsy(n, k, 1, A, n, b, n, pivot, told, rank, work, size(work), info)
    if (info == 0) step = step - matmul(self%places(:, :k) + share*self%steps(:, :k), b(:k, 1))
  end subroutine mix_step

end module scree_anderson
