!> Rigid bodies in flat arrays, cut into convex pieces, and which pieces are near each other: what small steps work on.
!>
!> All of it follows from model and state when a step of the run begins. The pieces and the list of near ones are kept, as they are
!> expensive to find. No bit of a run follows from whether they were.
module scree_bodies
  use scree_kinds, only: dp
  implicit none
  private
  public :: bodies_t, near_t, pair_memory_t, point_memory_t

  !> What a point at which a pair of pieces meets remembers.
  type :: point_memory_t
    integer :: vertex = 0                !! of the outlines, that the point is at; 0: there is no point
    integer :: edge = 0                  !! of the outlines, that it is on
    integer :: joint = 1                 !! joint material
    logical :: slides = .false.          !! friction was at its limit in the step
    real(dp) :: push = 0.0_dp            !! impulse of the last step across the edge, force time per unit thickness
    real(dp) :: rub = 0.0_dp             !! along it
    real(dp) :: held = 0.0_dp            !! slip that friction holds, length
    real(dp) :: bond = 0.0_dp            !! length of joint that holds together, 0: none, length
    real(dp) :: slid = 0.0_dp            !! way that it has slid, length
    real(dp) :: gap = 0.0_dp             !! at the end of the step; below 0: overlap, length
    real(dp) :: normal(2) = 0.0_dp       !! from the first piece to the second
  end type point_memory_t

  !> What a pair of pieces remembers.
  type :: pair_memory_t
    logical :: touches = .false.
    integer :: strained = 0              !! steps in a row in which its bonds were at their limits
    type(point_memory_t) :: point(2)     !! at the two ends of what the pieces have in common
  end type pair_memory_t

  !> Pairs of pieces near each other, in the order of their first and then of their second piece.
  type :: near_t
    integer :: n = 0
    integer, allocatable :: piece(:, :)  !! (2, n)
    integer, allocatable :: edge(:)      !! (n) where to look first for the line that separates or leads; 0: anywhere
    integer, allocatable :: vertex(:)    !! (n)
    type(pair_memory_t), allocatable :: memory(:) !! (n)
    real(dp), allocatable :: apart_until(:) !! (n) value of `moved` until which a pair that was apart cannot touch, length
    real(dp) :: skin = 0.0_dp            !! up to which pieces are near, length
    real(dp) :: moved = 0.0_dp           !! way that any of them may have gone since, length
  end type near_t

  !> The bodies, one a block.
  type :: bodies_t
    integer :: n = 0
    logical, allocatable :: moves(:)            !! (n)
    real(dp), allocatable :: place(:, :)        !! (2, n) of the centroid, length
    real(dp), allocatable :: velocity(:, :)     !! (2, n) length/time
    real(dp), allocatable :: angle(:)           !! (n) since the step of the run began, rad
    real(dp), allocatable :: spin(:)            !! (n) rad/time
    real(dp), allocatable :: inverse_mass(:)    !! (n) 0: it cannot move, length/mass
    real(dp), allocatable :: inverse_inertia(:) !! (n) likewise, 1/(mass length)
    real(dp), allocatable :: size(:)            !! (n) root of the area, length
    real(dp), allocatable :: radius(:)          !! (n) of the circle about the centroid that holds it, length
    integer :: n_pieces = 0
    integer, allocatable :: body(:)             !! (n_pieces)
    integer, allocatable :: first(:)            !! (n_pieces+1) piece p has the corners first(p):first(p+1)-1, counterclockwise
    integer, allocatable :: corner(:)           !! (n_corners) vertex of the elements
    integer, allocatable :: edge(:)             !! (n_corners) edge of the outlines that begins there
    logical, allocatable :: face(:)             !! (n_corners) the edge of the piece that begins there is one of its body
    real(dp), allocatable :: length(:)          !! (n_edges) of the edges of the outlines, length
    integer, allocatable :: piece_of(:)         !! (n_edges) piece that has the edge of the outlines, 0: none has
    integer, allocatable :: begins_with(:)      !! (n_edges) first of the edges of the outlines that its edge of the piece spans
    integer, allocatable :: first_corner(:)     !! (n_edges+1) vertex v of the outlines is at corners corners_at(first_corner(v):
    integer, allocatable :: corners_at(:)       !! first_corner(v+1)-1), one a piece
    integer, allocatable :: piece_at(:)         !! (n_corners) piece of the corner
    real(dp), allocatable :: arm(:, :)          !! (2, n_corners) from the centroid, as the step of the run began, length
    real(dp), allocatable :: own_normal(:, :)   !! (2, n_corners) of the edge, outward, then
    real(dp), allocatable :: at(:, :)           !! (2, n_corners) where the corner is now, length
    real(dp), allocatable :: normal(:, :)       !! (2, n_corners) now
    type(near_t) :: near
  end type bodies_t

end module scree_bodies
