!> Factors of a matrix, with which GMRES solves the system of one near it.
module scree_factors
  use scree_errors, only: error_t
  use scree_kinds, only: dp
  implicit none
  private
  public :: factors_t

  !> Factors of a matrix S, of whatever library.
  type, abstract :: factors_t
  contains
    procedure(solve_with_factors), deferred :: solve !! S x = b
  end type factors_t

  abstract interface
    !> Solves S x = b. Errors: no memory.
    subroutine solve_with_factors(self, b, x, error)
      import :: dp, error_t, factors_t
      class(factors_t), intent(inout) :: self
      real(dp), intent(in), target, contiguous :: b(:) !! (n)
      real(dp), intent(out) :: x(:)      !! (n)
      type(error_t), allocatable, intent(out) :: error
    end subroutine solve_with_factors
  end interface

end module scree_factors
