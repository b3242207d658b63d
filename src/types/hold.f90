!> What holds new faces of cracks together.
module scree_hold
  use scree_kinds, only: dp
  implicit none
  private
  public :: hold_t

  !> Forces with which the sides of new faces of cracks still hold each other (`scree_crack_hold`).
  type :: hold_t
    real(dp), allocatable :: force(:, :)       !! (2, n_covers) at the cut, on a cover by each of its elements, per unit thickness
    integer, allocatable :: piece(:)           !! (n_covers) piece of the cracks, of those below, that cut the cover; 0: none
    integer, allocatable :: tip(:)             !! (n) number of the tip that has grown by each piece
    real(dp), allocatable :: duration(:)       !! (n) in which Rayleigh waves pass the piece, time; 0: a step releases all
    real(dp), allocatable :: share(:)          !! (n) of the forces that was left at the end of the last step
    real(dp), allocatable :: next(:)           !! (n) and that is left at the end of the next
  end type hold_t

end module scree_hold
