!> The integrators: four weights, and the velocity and acceleration at the end of a step.
!>
!> Newmark in the letters of Zhang et al. 2019 (their beta weighs the velocity, their gamma the displacement):
!>
!>     d  = v0 dt + [(1/2 - gamma) a0 + gamma a1] dt^2
!>     v1 = v0 + [(1 - beta) a0 + beta a1] dt          balance M a1 + internal forces = loads, at the end of the step.
!>
!> beta 1, gamma 1/2 is Shi's step. The energy-momentum form takes its kinematics, so that v1 = 2 d/dt - v0 and
!> M a1 is M (v1 - v0)/dt, but balances it with the mid-step operator B0 + A/2 and the stress sigma0 + (1/2 + chi) D E:
!> the torque about the mid-step configuration vanishes, and energy changes by -chi E.D.E (doc/theory.md).
!>
!> The velocity feels the loads of a step about its end less (beta - 1/2) dt: they act with their mean over dt there. A static
!> step begins at rest whatever was before, and Shi's takes no mean: they feel the loads of their end.
module scree_integrator
  use scree_element_term, only: step_rule_t
  use scree_kinds, only: dp
  use scree_scene, only: scheme_energy_momentum, settings_t, start_dissipative
  implicit none
  private
  public :: end_rates, step_rule_for, still_displacement

contains

  !> Weights of the step of size `dt` that begins at `time`.
  pure function step_rule_for(settings, step, time, dt) result(rule)
    type(settings_t), intent(in) :: settings
    integer, intent(in) :: step      !! steps done before it; the first may have to dissipate
    real(dp), intent(in) :: time, dt
    type(step_rule_t) :: rule
    logical :: dissipative

    dissipative = step == 0 .and. settings%start == start_dissipative
    rule%dt = dt
    rule%end_time = time + dt
    if (settings%scheme == scheme_energy_momentum) then
      rule%operator_weight = 0.5_dp
      rule%stress_weight = merge(1.0_dp, settings%beta, dissipative) ! 1/2 + chi
    else
      if (.not. dissipative) then
        rule%velocity_weight = settings%beta
        rule%displacement_weight = settings%gamma
      end if
    end if
    if (settings%loads_at_end) then
      rule%load_from = rule%end_time
      rule%load_to = rule%end_time
    else
      rule%load_from = time + (1 - rule%velocity_weight)*dt
      rule%load_to = rule%load_from + dt
    end if
  end function step_rule_for

  !> Rates at the end of a step from its displacement.
  elemental subroutine end_rates(rule, displacement, velocity, acceleration)
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: displacement               !! any unknown
    real(dp), intent(inout) :: velocity, acceleration  !! of that unknown, at the beginning, then at the end
    real(dp) :: new

    associate (beta => rule%velocity_weight, gamma => rule%displacement_weight, dt => rule%dt)
      new = (displacement - velocity*dt)/(gamma*dt**2) - (0.5_dp - gamma)/gamma*acceleration
      velocity = velocity + ((1 - beta)*acceleration + beta*new)*dt
      acceleration = new
    end associate
  end subroutine end_rates

  !> Displacement of a step that ends at rest.
  elemental real(dp) function still_displacement(rule, velocity, acceleration) result(displacement)
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: velocity, acceleration !! at the beginning
    real(dp) :: new

    associate (beta => rule%velocity_weight, gamma => rule%displacement_weight, dt => rule%dt)
      new = -(velocity/dt + (1 - beta)*acceleration)/beta
      displacement = velocity*dt + ((0.5_dp - gamma)*acceleration + gamma*new)*dt**2
    end associate
  end function still_displacement

end module scree_integrator
