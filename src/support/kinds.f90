!> Real and integer kinds of the whole program, and the number pi.
module scree_kinds
  use, intrinsic :: iso_fortran_env, only: int64, real64
  implicit none
  private
  public :: dp, i8, pi

  integer, parameter :: dp = real64 !! every real of the program
  integer, parameter :: i8 = int64  !! counts that may pass 2e9

  real(dp), parameter :: pi = acos(-1.0_dp)

end module scree_kinds
