!> Mean stress over the half disc before a place, and its tension: the measure of cracks that grow or begin by strength.
!>
!> The half disc has a stated radius, so its mean does not depend on the mesh as the stress at a tip does. A crack of no length has
!> the same half disc at an outline, before a place of that. So one measure holds for both.
module scree_mean_tension
  use scree_block_finder, only: block_at, block_finder_t
  use scree_kinds, only: dp, pi
  use scree_model, only: model_t
  use scree_state, only: state_t
  implicit none
  private
  public :: find_tension, largest_principal, mean_stress_before

  integer, parameter :: n_rings = 12, n_rays = 24 !! of the points over which stress is averaged

contains

  !> Mean stress over the half disc before a place, in the axes of the start: xx, yy, xy, force/length^2. What of the disc is not
  !> in the block does not count; without any of it the stress is 0.
  !>
  !> The half disc has points at equal areas, on rings and rays. The stress of an element is turned back by its rotation.
  function mean_stress_before(place, direction, block, radius, finder, model, state) result(stress)
    real(dp), intent(in) :: place(2)       !! at the start, in coordinates of the model, length
    real(dp), intent(in) :: direction(2)   !! to the middle of the arc, of length 1
    integer, intent(in) :: block
    real(dp), intent(in) :: radius         !! length
    type(block_finder_t), intent(in) :: finder !! of the elements at the start
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(dp) :: stress(3)
    real(dp) :: angle, r
    integer :: e, i, k, n

    stress = 0.0_dp
    n = 0
    do i = 1, n_rings
      r = radius*sqrt((i - 0.5_dp)/n_rings)
      do k = 1, n_rays
        angle = pi*((k - 0.5_dp)/n_rays - 0.5_dp)
        e = block_at(finder, model%elements%shape, model%start, &
                     place + r*(cos(angle)*direction + sin(angle)*[-direction(2), direction(1)]), &
                     model%elements%block, block)
        if (e == 0) cycle
        n = n + 1
        stress = stress + turned_back(state%stress(:, e), state%deformation(:, e))
      end do
    end do
    if (n > 0) stress = stress/n
  end function mean_stress_before

  !> A stress in the axes of the start: those of an element have turned by the rotation of its deformation gradient.
  pure function turned_back(stress, deformation) result(own)
    real(dp), intent(in) :: stress(3)      !! xx, yy, xy, force/length^2
    real(dp), intent(in) :: deformation(4) !! F: xx, yx, xy, yy
    real(dp) :: own(3)
    real(dp) :: c, s, middle, double(2)

    c = deformation(1) + deformation(4)
    s = deformation(2) - deformation(3)
    double = [c*c - s*s, 2*c*s]/(c*c + s*s) ! cosine and sine of twice the rotation
    middle = (stress(1) + stress(2))/2
    own(1) = middle + (stress(1) - stress(2))/2*double(1) + stress(3)*double(2)
    own(2) = 2*middle - own(1)
    own(3) = stress(3)*double(1) - (stress(1) - stress(2))/2*double(2)
  end function turned_back

  !> The largest principal stress, and the direction of the crack that it opens: across it, onwards.
  pure subroutine find_tension(stress, onwards, tension, direction)
    real(dp), intent(in) :: stress(3)      !! xx, yy, xy, force/length^2
    real(dp), intent(in) :: onwards(2)     !! direction that the crack does not turn back from
    real(dp), intent(out) :: tension       !! force/length^2
    real(dp), intent(out) :: direction(2)  !! of length 1
    real(dp) :: angle

    tension = largest_principal(stress)
    angle = 0.5_dp*atan2(2*stress(3), stress(1) - stress(2))
    direction = [-sin(angle), cos(angle)]
    if (dot_product(direction, onwards) < 0) direction = -direction
  end subroutine find_tension

  !> Largest principal stress, force/length^2.
  pure real(dp) function largest_principal(stress) result(tension)
    real(dp), intent(in) :: stress(3)      !! xx, yy, xy, force/length^2

    tension = (stress(1) + stress(2))/2 + sqrt(((stress(1) - stress(2))/2)**2 + stress(3)**2)
  end function largest_principal

end module scree_mean_tension
