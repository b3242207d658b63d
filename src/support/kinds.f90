!> Real and integer kinds of the whole program.
module scree_kinds
  use, intrinsic :: iso_fortran_env, only: int64, real64
  implicit none
  private
  public :: dp, i8

  integer, parameter :: dp = real64 !! every real of the program
  integer, parameter :: i8 = int64  !! counts that may pass 2e9

end module scree_kinds
