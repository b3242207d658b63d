!> The largest step with which explicit central differences are stable: 2/w, w the highest frequency of any element.
!>
!> The mass and stiffness of a body are sums over its elements. So its frequencies lie below the highest frequency of an element
!> alone (Fried 1972; Hughes, The Finite Element Method, 1987, section 9.1). Exact supports lower them. Contacts and the springs of
!> fixed points are balanced at the end of a step and set no bound.
!>
!> An element has a linear field. Its strain rates e = B v have the inverse mass B M^-1 B^T = N/rho, where N follows from the
!> inverse of its second moments. w^2 is the largest eigenvalue of area/rho D N. For a bar of the length l it is 12 E/(rho l^2).
!> (doc/theory/integrators.md, eq-critical-step)
module scree_critical_step
  use scree_interpolation, only: kinematics_t
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  implicit none
  private
  public :: critical_step, find_largest_step

  !> Fraction of the critical step that explicit steps take. At 0.87 a vibration has a period of three steps, and its nonlinear
  !> terms drive it. With a stress of 1e-4 E and small strain the energy doubled in a thousand steps at 0.9, and stayed at 0.8.
  real(dp), parameter :: safe_share = 0.8_dp

contains

  !> Critical step of an element as it stands, time; 0 where it has no mass.
  pure real(dp) function critical_step(element, elasticity, mass)
    type(kinematics_t), intent(in) :: element
    real(dp), intent(in) :: elasticity(3, 3) !! force/length^2
    real(dp), intent(in) :: mass             !! mass/length
    real(dp) :: inverse(3), N(3, 3)

    associate (S => element%second)
      inverse = [S(2), S(1), -S(3)]/(S(1)*S(2) - S(3)**2)
    end associate
    N(1, :) = [inverse(1), 0.0_dp, inverse(3)]
    N(2, :) = [0.0_dp, inverse(2), inverse(3)]
    N(3, :) = [inverse(3), inverse(3), inverse(1) + inverse(2)]
    critical_step = 2*sqrt(mass/largest_eigenvalue(matmul(elasticity, N)))/element%area
  end function critical_step

  !> Finds the step that explicit central differences may take, and the element that sets it.
  pure subroutine find_largest_step(model, cache, dt, element)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    real(dp), intent(out) :: dt     !! time; huge where nothing can move
    integer, intent(out) :: element !! 0 where nothing can move
    real(dp) :: own
    integer :: k

    dt = huge(dt)
    element = 0
    do k = 1, size(model%elements%free)
      associate (this => cache%element(model%elements%free(k)))
        own = safe_share*critical_step(this%kinematics, this%elasticity, this%mass)
      end associate
      if (own >= dt) cycle
      dt = own
      element = model%elements%free(k)
    end do
  end subroutine find_largest_step

  !> Largest eigenvalue of a matrix whose eigenvalues are real, by the root of its characteristic polynomial.
  pure real(dp) function largest_eigenvalue(A)
    real(dp), intent(in) :: A(3, 3)
    real(dp) :: mean, spread, K(3, 3), det
    integer :: i

    mean = (A(1, 1) + A(2, 2) + A(3, 3))/3
    K = A
    do i = 1, 3
      K(i, i) = K(i, i) - mean
    end do
    spread = sqrt(max(0.0_dp, sum(K*transpose(K))/6))
    largest_eigenvalue = mean
    if (.not. spread > 0) return
    K = K/spread
    det = K(1, 1)*(K(2, 2)*K(3, 3) - K(2, 3)*K(3, 2)) - K(1, 2)*(K(2, 1)*K(3, 3) - K(2, 3)*K(3, 1)) &
          + K(1, 3)*(K(2, 1)*K(3, 2) - K(2, 2)*K(3, 1))
    largest_eigenvalue = mean + 2*spread*cos(acos(max(-1.0_dp, min(1.0_dp, det/2)))/3)
  end function largest_eigenvalue

end module scree_critical_step
