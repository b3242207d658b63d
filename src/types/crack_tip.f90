!> Tips of cracks: the places in blocks where joints end.
module scree_crack_tip
  use scree_kinds, only: dp
  implicit none
  private
  public :: crack_start_t, crack_tip_t, tip_disc_t

  !> Sides of a triangle from where the faces of a crack end back to the tip of its field. Around an end linear triangles are too
  !> stiff, and far from it their field is that of a shorter crack. In mode I of 16 meshes with the end in a node the way is 0.27
  !> to 0.37. Of 60 ends on sides of triangles it is 0.20 to 0.95, 0.35 in the mean.
  real(dp), parameter, public :: short_of_end = 0.3_dp

  !> Disc around a tip over which its stress intensity is an integral (`scree_stress_intensity`).
  !>
  !> Stress, displacement gradient and body force are constant in an element. So the integral is a sum over the elements of the
  !> disc, with weights that follow from the start alone. They are in the axes of the tip: 1 along its direction, 2 turned left.
  type :: tip_disc_t
    real(dp) :: place(2) = 0.0_dp                 !! of the tip that the field has far from it, on the crack, length
    real(dp) :: direction(2) = 0.0_dp             !! of the crack there, outward, of length 1
    real(dp), allocatable :: path(:, :)           !! (2, n) the crack from there back to where it ends or branches, length
    real(dp) :: radius = 0.0_dp                   !! length
    integer, allocatable :: element(:)            !! (n) elements in the disc
    real(dp), allocatable :: area(:)              !! (n) at the start, length^2
    real(dp), allocatable :: of_stress(:, :, :)   !! (3, modes, n) of s_11, s_22, s_12, length^(1/2)/stiffness
    real(dp), allocatable :: of_gradient(:, :, :) !! (2, modes, n) of u_1,1 and u_2,1, length^(1/2)
    real(dp), allocatable :: of_force(:, :, :)    !! (2, modes, n) of the body force, length^(3/2)/stiffness
    real(dp) :: of_start(2) = 0.0_dp              !! (modes) what the gradient of the initial stress adds
    real(dp) :: modulus = 0.0_dp                  !! E/(1 - nu^2) in plane strain, E in plane stress, force/length^2
    real(dp) :: shear = 0.0_dp                    !! shear modulus, force/length^2
    real(dp) :: kappa = 0.0_dp                    !! 3 - 4 nu in plane strain, (3 - nu)/(1 + nu) in plane stress
  end type tip_disc_t

  !> A tip, in the configuration of the start and the coordinates of the model.
  type :: crack_tip_t
    real(dp) :: place(2) = 0.0_dp         !! where the faces of the crack end, on a side of a triangle of the mesh, length
    real(dp) :: end(2) = 0.0_dp           !! where the line of the crack ends: there, or in the triangle beyond, length
    real(dp) :: direction(2) = 0.0_dp     !! of the last piece of the crack, outward, of length 1
    integer :: number = 0                 !! of the tip among those that the decks draw, from which it has grown
    integer :: crack = 0                  !! number of the crack: pieces that meet have the same
    integer :: joint = 0                  !! joint material of the last piece
    integer :: block = 0
    integer :: element = 0                !! element that holds the end of the line
    real(dp) :: length = 0.0_dp           !! of all pieces of the crack
    real(dp) :: edge = 0.0_dp             !! longest side of the triangle of the mesh at the tip
    real(dp) :: to_tip = 0.0_dp           !! distance to the nearest other tip of the block; huge: there is none
    real(dp) :: to_face = 0.0_dp          !! distance to the nearest outline of a block, or piece that is not of the path
    real(dp), allocatable :: path(:, :)   !! (2, n) the crack from the tip back to where it ends or branches
    type(tip_disc_t) :: disc
  end type crack_tip_t

  !> A place of an outline where a crack may begin, in the configuration of the start and the coordinates of the model.
  type :: crack_start_t
    real(dp) :: place(2) = 0.0_dp         !! length
    real(dp) :: inward(2) = 0.0_dp        !! along the bisector of the corner, or normal to the edge, of length 1
    real(dp) :: swing = 0.0_dp            !! largest angle of a crack from that direction, rad
    integer :: element = 0                !! one that has a vertex there
    integer :: block = 0
    real(dp) :: edge = 0.0_dp             !! longest side of the triangle of that element
  end type crack_start_t

end module scree_crack_tip
