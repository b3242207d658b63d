!> Weight of the elements (Shi's df16).
module scree_gravity
  use scree_element_term, only: add_force, term_t
  use scree_interpolation, only: kinematics_t
  use scree_kinds, only: dp
  implicit none
  private
  public :: add_gravity, gravity_energy, gravity_t

  !> Called for when a block material has weight. Each material's own unit weight acts, downwards.
  type :: gravity_t
    real(dp), allocatable :: weight(:) !! (n_elements) at the start, when its ramp is over, force per unit thickness
    real(dp) :: ramp = 0.0_dp          !! in which it grows from 0 as the run begins, time
  end type gravity_t

contains

  !> Adds T(c)^T (0, -W): the weight of a linear field acts at the centroid.
  pure subroutine add_gravity(weight, element, term)
    real(dp), intent(in) :: weight !! force per unit thickness
    type(kinematics_t), intent(in) :: element
    type(term_t), intent(inout) :: term

    call add_force(term, -weight*element%at_centroid(2, :))
  end subroutine add_gravity

  !> Potential energy W y, force per unit thickness times length.
  pure real(dp) function gravity_energy(weight, element)
    real(dp), intent(in) :: weight
    type(kinematics_t), intent(in) :: element

    gravity_energy = weight*element%centroid(2)
  end function gravity_energy

end module scree_gravity
