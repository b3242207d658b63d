!> Parts of the law of a joint. The folder `laws` of contact says how each part acts.
module scree_joint_law
  use scree_kinds, only: dp
  implicit none
  private
  public :: closure_t, dilation_t, joint_memory_t, joint_stiffness_t, joint_t, laws_in_use_t, roughness_t, softening_t, &
            wear_t

  !> Stiffness of a joint of its own.
  type :: joint_stiffness_t
    real(dp) :: normal = 0.0_dp   !! 0: the joint has the stiffness of contact, force/length^3
    real(dp) :: shear = 0.0_dp    !! force/length^3
  end type joint_stiffness_t

  !> A joint that stiffens as it closes.
  type :: closure_t
    real(dp) :: most = 0.0_dp     !! largest closure; 0: the joint does not stiffen, length
  end type closure_t

  !> A joint whose faces part as they slide.
  type :: dilation_t
    real(dp) :: tangent = 0.0_dp  !! of the dilation angle; 0: the joint does not dilate
    real(dp) :: slip = 0.0_dp     !! at which dilation ends, length
  end type dilation_t

  !> A joint whose friction falls as its faces slide.
  type :: wear_t
    real(dp) :: friction = 0.0_dp !! tangent of the residual friction angle
    real(dp) :: slip = 0.0_dp     !! at which that is reached; 0: the joint does not wear, length
  end type wear_t

  !> A joint whose strength follows the stress across it.
  type :: roughness_t
    real(dp) :: jrc = 0.0_dp      !! joint roughness coefficient, rad for each decade of the stress
    real(dp) :: jcs = 0.0_dp      !! joint wall compressive strength, force/length^2
    real(dp) :: cohesion = 0.0_dp !! that a broken bond leaves, force/length^2
  end type roughness_t

  !> Bonds of a joint that lose their strength over a displacement.
  type :: softening_t
    real(dp) :: opening = 0.0_dp  !! at which a bond has no tensile strength left; 0: it breaks at once, length
    real(dp) :: slip = 0.0_dp     !! at which it has no cohesion left; 0: it breaks at once, length
  end type softening_t

  !> The law of a joint material. A part whose numbers are 0 has no effect.
  type :: joint_t
    real(dp) :: friction = 0.0_dp !! tangent of the friction angle
    real(dp) :: cohesion = 0.0_dp !! of a bond, force/length^2
    real(dp) :: strength = 0.0_dp !! of a bond in tension, force/length^2
    real(dp) :: restitution = -1.0_dp !! of impacts with small steps; below 0: none
    type(joint_stiffness_t) :: stiffness
    type(closure_t) :: closure
    type(dilation_t) :: dilation
    type(wear_t) :: wear
    type(roughness_t) :: roughness
    type(softening_t) :: softening
  end type joint_t

  !> Memory of the laws of a joint at an entrance.
  type :: joint_memory_t
    logical :: bonded = .false.     !! cohesion and tensile strength are not lost
    real(dp) :: damage = 0.0_dp     !! part of its strength that the bond has lost
    real(dp) :: length = 0.0_dp     !! of the joint that the contact stands for, where its strength asks for it
    real(dp) :: pressing = 0.0_dp   !! force across at the end of the last step
    real(dp) :: slid = 0.0_dp       !! way that the contact has slid since it was found, length
    real(dp) :: wear = 0.0_dp       !! way that its faces have slid on each other, by which the joint wears, length
    real(dp) :: displaced = 0.0_dp  !! slip since the contact was found, with its sign, where joints dilate, length
    real(dp) :: farthest = 0.0_dp   !! largest size of that slip so far, length
    real(dp) :: dilated = 0.0_dp    !! gap by which its faces have parted in sliding, length
  end type joint_memory_t

  !> Which parts any joint of a scene has; `joint_rules` alone asks.
  type :: laws_in_use_t
    logical :: stiffness = .false.
    logical :: closure = .false.
    logical :: dilation = .false.
    logical :: wear = .false.
    logical :: roughness = .false.
    logical :: softening = .false.
  end type laws_in_use_t

end module scree_joint_law
