!> The symmetric matrix whose factor solutions go on from.
module scree_factored
  use scree_kinds, only: dp
  implicit none
  private
  public :: factored_t

  !> Its lower triangle in compressed columns, counted from 0: each begins with the diagonal. Not allocated: there is none.
  type :: factored_t
    integer, allocatable :: unknown(:) !! (n) of the model, of each row
    integer, allocatable :: first(:)   !! (n+1) column j owns entries first(j):first(j+1)-1
    integer, allocatable :: row(:)     !! (n_entries)
    real(dp), allocatable :: value(:)  !! (n_entries)
    integer :: spent = 0               !! iterations of the solutions since it was factorised, but for two of each
  end type factored_t

end module scree_factored
