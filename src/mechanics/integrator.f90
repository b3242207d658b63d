!> The integrators: the weights of a step, and the velocity and acceleration at its end.
!>
!> Newmark in the letters of Zhang et al. 2019 (their beta weighs the velocity, their gamma the displacement):
!>
!>     d  = v0 dt + [(1/2 - gamma) a0 + gamma a1] dt^2
!>     v1 = v0 + [(1 - beta) a0 + beta a1] dt          balance M a1 + internal forces = loads, at the end of the step.
!>
!> beta 1, gamma 1/2 is Shi's step. The energy-momentum form has its kinematics, so v1 = 2 d/dt - v0 and M a1 is M (v1 - v0)/dt. It
!> balances inertia with the mid-step operator B0 + A/2 and the stress sigma0 + (1/2 + chi) D E. So the torque about the mid-step
!> configuration vanishes, and energy changes by -chi E.D.E (doc/theory/integrators.md, eq-energy-momentum-loss). The
!> energy-decaying form is the same with gamma 1/2 + chi^2/4, which damps vibrations that the step does not resolve. There the
!> acceleration of the step before turns with its block (`scree_turning`).
!>
!> The velocity feels the loads of a step about its end less (beta - 1/2) dt, its lag: they act with their mean over dt there. A
!> static step begins at rest whatever was before, and Shi's takes no mean: they feel the loads of their end.
!>
!> Generalized-alpha (Chung & Hulbert, J. Appl. Mech. 60, 1993) has Newmark's kinematics and balances between beginning and end,
!>
!>     M [(1 - alpha_m) a1 + alpha_m a0] + (1 - alpha_f) f(d) + alpha_f f(0) = loads at the end less alpha_f dt
!>     alpha_m = (2 rho - 1)/(rho + 1),   alpha_f = rho/(rho + 1),   beta = 1/2 - alpha_m + alpha_f,   gamma = (beta + 1/2)^2/4,
!>
!> f the elastic forces, rho the spectral radius at infinite frequency. Contacts press with the force of the end of the step.
!>
!> Central differences balance at the beginning: M a1 + f(0) = loads there, d = dt v(1/2), v(1/2) = v(-1/2) + (dt0 + dt)/2 a1, dt0
!> the step before. With v0 = v(-1/2) + dt0/2 a0, which is of second order for the velocity where the step begins, these are
!> Newmark's with beta 3/2 and gamma 1 (in equal steps). Contacts are those of the end (Carpenter, Taylor & Katona 1991).
!>
!> Bathe's composite (Bathe & Baig 2005, Bathe 2007) takes pairs of steps of the sizes h and dt. The first is the trapezoidal rule.
!> The second is the backward formula of second order through the three ends. The rate of x there is c1 x0 + c2 x1 + c3 x2, with
!> c1 = dt/(h (h + dt)), c3 = (h + 2 dt)/(dt (h + dt)) and c2 = -c1 - c3. In the first step d = h (v0 + v1)/2. So the second is
!> Newmark's step with beta 1/(c3 dt) = (h + dt)/(h + 2 dt) and gamma beta^2, which are 2/3 and 4/9 for equal steps. It begins with
!> the mean acceleration of the first, (v1 - v0)/h, which the first step passes on.
module scree_integrator
  use scree_element_term, only: step_rule_t
  use scree_kinds, only: dp
  use scree_scene, only: scheme_bathe, scheme_central_difference, scheme_energy_decaying, scheme_generalized_alpha, &
                         scheme_newmark, settings_t, start_dissipative, transport_field
  implicit none
  private
  public :: end_rates, held_weight, holds_power, rule_at_rest, step_rule_for, turns_acceleration, velocity_at_balance

contains

  !> Weights of the step of size `dt` that begins at `time`.
  !>
  !> The excess of gamma over beta/2 weighs the change of a dt, the impulse of a step, so that it takes no energy to change the
  !> step and gives none.
  pure function step_rule_for(settings, step, time, before, dt) result(rule)
    type(settings_t), intent(in) :: settings
    integer, intent(in) :: step       !! steps done before it; the first may have to dissipate
    real(dp), intent(in) :: time
    real(dp), intent(in) :: before    !! size of the step before it, time
    real(dp), intent(in) :: dt        !! time
    type(step_rule_t) :: rule

    if (step == 0 .and. settings%start == start_dissipative) then
      if (settings%scheme /= scheme_newmark) rule%operator_weight = 0.5_dp
    else
      rule = weights_of(settings)
    end if
    rule%dt = dt
    rule%end_time = time + dt
    associate (beta => rule%velocity_weight, gamma => rule%displacement_weight)
      rule%carried_weight = 0.5_dp - gamma - (gamma - 0.5_dp*beta)*(before/dt - 1)
    end associate
    if (settings%loads_at_end) then
      rule%load_from = rule%end_time
      rule%load_to = rule%end_time
    else
      rule%load_from = time + (0.5_dp - rule%lag)*dt
      rule%load_to = rule%load_from + dt
    end if
    if (settings%scheme == scheme_central_difference) call kick(time, merge(before, 0.0_dp, step > 0), rule)
    if (settings%scheme == scheme_bathe .and. mod(step, 2) == 1) call look_back(before, rule)
  end function step_rule_for

  !> The rule of a step in which nothing moves, with the loads of a time.
  pure type(step_rule_t) function rule_at_rest(time, dt) result(rule)
    real(dp), intent(in) :: time
    real(dp), intent(in) :: dt        !! of no consequence, but above 0, time

    rule%dt = dt
    rule%end_time = time
    rule%load_from = time
    rule%load_to = time
  end function rule_at_rest

  !> Velocity at the time of the balance, (1 - 2 lag) v1 + 2 lag d/dt, as c d + `carried` of the unknowns d of a step.
  !>
  !> The lag is beta - 1/2. For beta 1 this is d/dt, for beta 1/2 the velocity at the end (doc/theory/integrators.md,
  !> eq-mass-damping).
  pure subroutine velocity_at_balance(rule, velocity, acceleration, c, carried)
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: velocity(:), acceleration(:) !! (n) at the beginning of the step
    real(dp), intent(out) :: c                           !! 1/time
    real(dp), intent(out) :: carried(:)                  !! (n)
    real(dp) :: at_end

    associate (beta => rule%velocity_weight, gamma => rule%displacement_weight, dt => rule%dt)
      at_end = 1 - 2*rule%lag
      c = (at_end*beta/gamma + 1 - at_end)/dt
      carried = at_end*((1 - beta/gamma)*velocity + (1 - beta - rule%carried_weight*beta/gamma)*dt*acceleration)
    end associate
  end subroutine velocity_at_balance

  !> Weights of a step of central differences: its acceleration acts over half the step before, if any, and half of its own.
  pure subroutine kick(time, before, rule)
    real(dp), intent(in) :: time
    real(dp), intent(in) :: before            !! size of the step before it, 0 for the first, time
    type(step_rule_t), intent(inout) :: rule

    rule%displacement_weight = 0.5_dp*(1 + before/rule%dt)
    rule%velocity_weight = 0.5_dp + rule%displacement_weight
    rule%carried_weight = 0.5_dp - rule%displacement_weight
    rule%load_from = time - 0.5_dp*before
    rule%load_to = time + 0.5_dp*rule%dt
  end subroutine kick

  !> Weights of the second of two steps of Bathe's composite. Those of the first are in `weights_of`, or a start's.
  pure subroutine look_back(before, rule)
    real(dp), intent(in) :: before            !! size of the first, time
    type(step_rule_t), intent(inout) :: rule

    rule%velocity_weight = (before + rule%dt)/(before + 2*rule%dt)
    rule%displacement_weight = rule%velocity_weight**2
    rule%carried_weight = 0.5_dp - rule%displacement_weight
    rule%handed_weight = 1.0_dp
  end subroutine look_back

  !> The weights of a scheme.
  pure type(step_rule_t) function weights_of(settings) result(rule)
    type(settings_t), intent(in) :: settings

    select case (settings%scheme)
    case (scheme_newmark)
      rule%velocity_weight = settings%beta
      rule%displacement_weight = settings%gamma
      rule%lag = settings%beta - 0.5_dp
    case (scheme_generalized_alpha)
      associate (rho => settings%rho)
        rule%inertia_weight = (2 - rho)/(1 + rho)
        rule%end_weight = 1/(1 + rho)
        rule%velocity_weight = 0.5_dp*(3 - rho)/(1 + rho)
        rule%displacement_weight = 1/(1 + rho)**2
        rule%lag = rho/(1 + rho)
      end associate
    case (scheme_central_difference)
      rule%end_weight = 0.0_dp
      rule%lag = 1.0_dp
    case (scheme_bathe)
      rule%velocity_weight = 0.5_dp
      rule%displacement_weight = 0.25_dp
      rule%handed_weight = 0.5_dp
      rule%lag = 0.0_dp
    case default
      rule%operator_weight = 0.5_dp
      rule%stress_weight = settings%beta ! 1/2 + chi
      if (settings%scheme == scheme_energy_decaying) rule%displacement_weight = 0.5_dp + (settings%beta - 0.5_dp)**2/4
    end select
  end function weights_of

  !> Excess of gamma over beta/2: that fraction of M (a dt)^2/2 is held by the integrator, and may come back
  !> (doc/theory/integrators.md, eq-held-energy). For generalized-alpha and Bathe's composite no such fraction is known. Central
  !> differences hold another energy.
  pure real(dp) function held_weight(settings)
    type(settings_t), intent(in) :: settings
    type(step_rule_t) :: rule

    held_weight = 0.0_dp
    if (any(settings%scheme == [scheme_central_difference, scheme_generalized_alpha, scheme_bathe])) return
    if (settings%takes_small_steps()) return
    rule = weights_of(settings)
    held_weight = rule%displacement_weight - 0.5_dp*rule%velocity_weight
  end function held_weight

  !> Whether the integrator holds what elastic forces and weight take up in half a step, as central differences and small steps do.
  pure logical function holds_power(settings)
    type(settings_t), intent(in) :: settings

    holds_power = settings%scheme == scheme_central_difference .or. settings%takes_small_steps()
  end function holds_power

  !> Whether the acceleration that a step hands on turns with its block, so that a body that spins stays in the step what it is.
  !> Shi's six rates, which are not a field, turn without this.
  pure logical function turns_acceleration(settings)
    type(settings_t), intent(in) :: settings

    turns_acceleration = settings%scheme == scheme_energy_decaying .and. settings%transport == transport_field
  end function turns_acceleration

  !> Rates that a step hands on, from its displacement.
  elemental subroutine end_rates(rule, displacement, velocity, acceleration)
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: displacement               !! any unknown
    real(dp), intent(inout) :: velocity, acceleration  !! of that unknown, at the beginning, then handed on
    real(dp) :: new

    associate (beta => rule%velocity_weight, gamma => rule%displacement_weight, dt => rule%dt)
      new = (displacement - velocity*dt)/(gamma*dt**2) - rule%carried_weight/gamma*acceleration
      velocity = velocity + ((1 - beta)*acceleration + beta*new)*dt
      acceleration = (1 - rule%handed_weight)*acceleration + rule%handed_weight*new
    end associate
  end subroutine end_rates

end module scree_integrator
