!> Numbers of the bolts of a group of a deck.
module scree_bolt_numbers
  use scree_kinds, only: dp
  implicit none
  private
  public :: bolt_numbers_t

  !> Lists of one number for each bolt, row or ring of a group, or of one for all.
  type :: bolt_numbers_t
    real(dp), allocatable :: stiffness(:)       !! force/length per unit thickness
    real(dp), allocatable :: strength(:)        !! 0: without limit, force per unit thickness
    real(dp), allocatable :: pretension(:)      !! force per unit thickness
    real(dp), allocatable :: shear_stiffness(:) !! 0: not grouted, force/length per unit thickness
    real(dp), allocatable :: shear_strength(:)  !! 0: without limit, force per unit thickness
  end type bolt_numbers_t

end module scree_bolt_numbers
