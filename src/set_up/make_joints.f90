!> The laws of the joints of a scene, from its settings.
module scree_make_joints
  use scree_joint_law, only: joint_t
  use scree_kinds, only: dp, pi
  use scree_scene, only: joint_material_t, settings_t
  implicit none
  private
  public :: joints_of

contains

  !> The law of each joint material, and after them that of an edge without one, which has no strength.
  pure function joints_of(s, material) result(joint)
    type(settings_t), intent(in) :: s
    type(joint_material_t), intent(in) :: material(:)
    type(joint_t) :: joint(size(material) + 1)
    integer :: i

    do i = 1, size(material)
      joint(i) = joint_of(s, i, material(i))
    end do
  end function joints_of

  !> The law of joint material i. One by one: the tangents of several angles at a time may differ from these in the last bit.
  pure type(joint_t) function joint_of(s, i, material) result(joint)
    type(settings_t), intent(in) :: s
    integer, intent(in) :: i
    type(joint_material_t), intent(in) :: material
    real(dp), parameter :: degree = pi/180

    joint%friction = tan(material%friction_angle*degree)
    joint%cohesion = material%cohesion
    joint%strength = material%tensile_strength
    joint%restitution = s%restitution
    if (allocated(s%joint_restitution)) joint%restitution = s%joint_restitution(i)
    if (allocated(s%joint_kn)) then
      joint%stiffness%normal = s%joint_kn(i)
      joint%stiffness%shear = s%joint_kn(i)/s%shear_ratio
      if (allocated(s%joint_ks)) joint%stiffness%shear = s%joint_ks(i)
    end if
    if (allocated(s%joint_closure)) joint%closure%most = s%joint_closure(i)
    if (allocated(s%joint_energy)) then
      if (s%joint_energy(i) > 0) joint%softening%opening = 2*s%joint_energy(i)/joint%strength
    end if
    if (allocated(s%joint_shear_energy)) then
      if (s%joint_shear_energy(i) > 0) joint%softening%slip = 2*s%joint_shear_energy(i)/joint%cohesion
    end if
    if (allocated(s%dilation)) then
      joint%dilation%tangent = tan(s%dilation(i)*degree)
      joint%dilation%slip = s%dilation_slip(i)
    end if
    if (allocated(s%worn_angle)) then
      joint%wear%friction = tan(s%worn_angle(i)*degree)
      joint%wear%slip = s%worn_slip(i)
    end if
    if (allocated(s%jrc)) joint%roughness%jrc = s%jrc(i)*degree
    if (allocated(s%jcs)) joint%roughness%jcs = s%jcs(i)
    if (allocated(s%worn_cohesion)) joint%roughness%cohesion = s%worn_cohesion(i)
  end function joint_of

end module scree_make_joints
