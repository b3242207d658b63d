!> The effects of a scene: what each adds to the equations of an element, what it does and takes in a step, and what it stores.
!>
!> Which are present is asked here; in `scree_disturbance` of what changes where bodies sleep, in `scree_pair_effects` of what acts
!> between two elements.
module scree_effects
  use scree_absorbing_edge, only: absorbed_energy, absorb_velocity, add_absorbing_edges, size_of_static_forces, size_of_wave, &
                                  work_on_absorbing_edges
  use scree_base_acceleration, only: add_base_acceleration, force_of_base, work_of_base
  use scree_bolt, only: add_bolts_of_element, bolt_energy, work_between
  use scree_crack_hold, only: add_hold
  use scree_edge_load, only: add_edge_loads, size_of_edge_loads, work_of_edge_loads
  use scree_element_term, only: add_force, step_rule_t, term_t
  use scree_fixed_point, only: add_fixed_springs, spring_energy, work_of_springs
  use scree_gravity, only: add_gravity, gravity_energy
  use scree_green_strain, only: add_green_strain
  use scree_inertia, only: add_inertia, mass_matrix
  use scree_interpolation, only: kinematics_of
  use scree_kinds, only: dp
  use scree_mass_damping, only: add_mass_damping, damped_energy
  use scree_material, only: push_elasticity_forward
  use scree_model, only: cache_t, element_cache_t, model_t
  use scree_point_load, only: add_point_loads, size_of_point_loads, work_of_point_loads
  use scree_state, only: state_t
  use scree_stiffness, only: add_small_strain
  use scree_stiffness_damping, only: add_viscous_stress, strain_loss, viscous_force
  use scree_strain_rotation, only: add_strain_rotation
  use scree_system, only: element_unknowns, values_of
  use scree_time_table, only: last_change, mean_of_ramp, mean_over, ramp_at
  implicit none
  private
  public :: add_drag, add_element_effects, energy_of_bolts, energy_of_fixed_springs, energy_of_weight, has_fixed_point, &
            is_held_without_contact, load_on_element, loss_by_damping, mean_share_of_weight, power_of_weight, refresh_elements, &
            share_of_weight, steady_from, supported_blocks, supports_move, supports_move_exactly, weights_of_blocks, &
            work_of_bolts_between, work_of_loads, work_of_ramp, work_of_supports

  integer, parameter :: n = element_unknowns

contains

  !> Fills the cache of every element anew for a state; of those that cannot move once.
  pure subroutine refresh_elements(model, state, cache)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(cache_t), intent(inout) :: cache
    integer :: e, k

    if (.not. allocated(cache%element)) then
      allocate (cache%element(model%n_elements))
      do e = 1, model%n_elements
        call refresh(model, state, e, cache%element(e))
      end do
    else
      do k = 1, size(model%elements%free)
        e = model%elements%free(k)
        call refresh(model, state, e, cache%element(e))
      end do
    end if
  end subroutine refresh_elements

  !> Data of an element that stay the same through the iterations of a step.
  pure subroutine refresh(model, state, e, own)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: e
    type(element_cache_t), intent(inout) :: own

    associate (F => state%deformation(:, e), D => model%effects%elasticity(:, :, model%elements%material(e)))
      own%kinematics = kinematics_of(model%system_t, state, e)
      own%green = state%green(e)
      if (model%effects%mass_follows_area) own%mass_ratio = F(1)*F(4) - F(2)*F(3)
      own%mass = own%mass_ratio*model%elements%mass(e)
      own%mass_matrix = mass_matrix(own%kinematics, own%mass)
      own%stress = state%stress(:, e)
      own%elasticity = D
      if (model%effects%large_deformation) own%elasticity = push_elasticity_forward(F, D)
    end associate
  end subroutine refresh

  !> Adds every present effect to element `e`.
  pure subroutine add_element_effects(model, own, state, e, unknown, rule, term)
    type(model_t), intent(in) :: model
    type(element_cache_t), intent(in) :: own   !! of the element
    type(state_t), intent(in) :: state         !! at the beginning of the step
    integer, intent(in) :: e
    real(dp), intent(in) :: unknown(n)         !! of the step so far
    type(step_rule_t), intent(in) :: rule
    type(term_t), intent(out) :: term
    type(step_rule_t) :: of_stress             ! the rule, with the viscous stress in its weight
    real(dp), dimension(n) :: velocity, acceleration
    real(dp) :: stress(3)

    velocity = values_of(model%elements, e, state%velocity)
    acceleration = values_of(model%elements, e, state%acceleration)
    associate (effects => model%effects, element => own%kinematics)
      call add_inertia(own%mass_matrix, velocity, acceleration, unknown, rule, term)
      stress = own%stress
      of_stress = rule
      if (allocated(effects%stiffness_damping)) &
        call add_viscous_stress(effects%stiffness_damping, element, own%elasticity, velocity, acceleration, stress, of_stress)
      if (own%green .and. effects%strain_rotation) then
        call add_strain_rotation(element, own%elasticity, stress, unknown, of_stress, term)
      else if (own%green) then
        call add_green_strain(element, own%elasticity, stress, unknown, of_stress, term)
      else
        call add_small_strain(element, own%elasticity, stress, unknown, of_stress, term)
      end if
      if (allocated(effects%gravity)) &
        call add_gravity(own%mass_ratio*effects%gravity%weight(e) &
                         *mean_of_ramp(effects%gravity%ramp, rule%load_from, rule%load_to), element, term)
      if (allocated(effects%base_acceleration)) &
        call add_base_acceleration(effects%base_acceleration, own%mass, rule, element, term)
      if (allocated(effects%mass_damping)) &
        call add_mass_damping(effects%mass_damping, own%mass_matrix, velocity, acceleration, unknown, rule, term)
      if (allocated(effects%point_load)) &
        call add_point_loads(effects%point_load, e, state%point, rule, element, term)
      if (allocated(effects%edge_load)) &
        call add_edge_loads(effects%edge_load, e, state%point, velocity, rule, element, term)
      if (allocated(effects%absorbing_edge)) &
        call add_absorbing_edges(effects%absorbing_edge, e, state%point, velocity, acceleration, unknown, rule, element, term)
      if (allocated(effects%fixed_point)) then
        if (effects%fixed_point%by_springs) &
          call add_fixed_springs(effects%fixed_point, e, state%point, rule%end_time, element, unknown, term)
      end if
      if (allocated(state%hold)) call add_hold(state%hold, model%elements%cover(:, e), rule, term)
      if (allocated(effects%bolt)) &
        call add_bolts_of_element(effects%bolt, state%bolts, e, state%point, rule, element, unknown, term)
    end associate
  end subroutine add_element_effects

  !> Adds the forces on one element that its velocity alone makes.
  pure subroutine add_drag(model, own, state, e, velocity, term)
    type(model_t), intent(in) :: model
    type(element_cache_t), intent(in) :: own   !! of the element
    type(state_t), intent(in) :: state
    integer, intent(in) :: e
    real(dp), intent(in) :: velocity(n)        !! rates of its unknowns
    type(term_t), intent(inout) :: term

    if (allocated(model%effects%mass_damping)) &
      call add_force(term, -model%effects%mass_damping%rate*matmul(own%mass_matrix, velocity))
    if (allocated(model%effects%stiffness_damping)) &
      call add_force(term, viscous_force(model%effects%stiffness_damping, own%kinematics, own%elasticity, velocity))
    if (allocated(model%effects%absorbing_edge)) &
      call absorb_velocity(model%effects%absorbing_edge, e, state%point, velocity, own%kinematics, term)
  end subroutine add_drag

  !> Whether anything but contact may hold a body that can move against its weight.
  pure logical function is_held_without_contact(model) result(held)
    type(model_t), intent(in) :: model

    associate (effects => model%effects, free => model%elements%free)
      held = allocated(effects%bolt) .or. allocated(effects%point_load) .or. allocated(effects%edge_load) &
             .or. allocated(effects%absorbing_edge) .or. allocated(effects%base_acceleration)
      if (.not. held) held = has_fixed_point(model, free)
    end associate
  end function is_held_without_contact

  !> Whether any of some elements has a point that is fixed, to the ground or by a spring.
  pure logical function has_fixed_point(model, member)
    type(model_t), intent(in) :: model
    integer, intent(in) :: member(:)           !! elements

    has_fixed_point = .false.
    if (.not. allocated(model%effects%fixed_point)) return
    associate (first => model%effects%fixed_point%first)
      has_fixed_point = any(first(member + 1) > first(member))
    end associate
  end function has_fixed_point

  !> Which blocks have points that are fixed, or ends of lines of &support.
  pure function supported_blocks(model) result(supported)
    type(model_t), intent(in) :: model
    logical :: supported(model%n_blocks)
    integer :: i

    supported = .false.
    if (.not. allocated(model%effects%fixed_point)) return
    associate (point => model%effects%fixed_point%point)
      do i = 1, size(point)
        supported(model%elements%block(model%points%element(point(i)))) = .true.
      end do
    end associate
  end function supported_blocks

  !> Magnitudes of the weight, the loads, the inertia force of the ground and that of a wave that act on one element in a step,
  !> summed; force per unit thickness.
  pure real(dp) function load_on_element(model, own, state, e, rule) result(load)
    type(model_t), intent(in) :: model
    type(element_cache_t), intent(in) :: own   !! of the element
    type(state_t), intent(in) :: state         !! at the beginning of the step
    integer, intent(in) :: e
    type(step_rule_t), intent(in) :: rule

    load = 0.0_dp
    associate (effects => model%effects)
      if (allocated(effects%gravity)) load = load + abs(own%mass_ratio*effects%gravity%weight(e))
      if (allocated(effects%base_acceleration)) load = load + norm2(force_of_base(effects%base_acceleration, own%mass, rule))
      if (allocated(effects%point_load)) load = load + size_of_point_loads(effects%point_load, e, rule)
      if (allocated(effects%edge_load)) load = load + size_of_edge_loads(effects%edge_load, e, state%point)
      if (allocated(effects%absorbing_edge)) &
        load = load + size_of_static_forces(effects%absorbing_edge, e) &
               + size_of_wave(effects%absorbing_edge, e, state%point, &
                              mean_over(effects%absorbing_edge%wave, rule%load_from, rule%load_to))
    end associate
  end function load_on_element

  !> Work in a step on one element: of the loads on points and edges, of the inertia force of the ground, and on absorbing edges.
  pure real(dp) function work_of_loads(model, own, state, e, unknown, rule) result(work)
    type(model_t), intent(in) :: model
    type(element_cache_t), intent(in) :: own   !! of the element
    type(state_t), intent(in) :: state         !! at the beginning of the step
    integer, intent(in) :: e
    real(dp), intent(in) :: unknown(n)         !! of the step
    type(step_rule_t), intent(in) :: rule

    work = 0.0_dp
    associate (effects => model%effects)
      if (allocated(effects%base_acceleration)) &
        work = work + work_of_base(effects%base_acceleration, own%mass, rule, own%kinematics, unknown)
      if (allocated(effects%point_load)) &
        work = work + work_of_point_loads(effects%point_load, e, state%point, rule, own%kinematics, unknown)
      if (allocated(effects%edge_load)) &
        work = work + work_of_edge_loads(effects%edge_load, e, state%point, values_of(model%elements, e, state%velocity), rule, &
                                         own%kinematics, unknown)
      if (allocated(effects%absorbing_edge)) &
        work = work + work_on_absorbing_edges(effects%absorbing_edge, e, state%point, rule, own%kinematics, unknown)
    end associate
  end function work_of_loads

  !> Time from which loads, the ground and supports stay as they are.
  pure real(dp) function steady_from(model) result(time)
    type(model_t), intent(in) :: model

    time = -huge(time)
    associate (effects => model%effects)
      if (allocated(effects%base_acceleration)) time = max(time, last_change([effects%base_acceleration%record]))
      if (allocated(effects%point_load)) time = max(time, last_change(effects%point_load%table))
      if (allocated(effects%gravity)) time = max(time, effects%gravity%ramp)
      if (allocated(effects%edge_load)) time = max(time, effects%edge_load%ramp)
      if (allocated(effects%absorbing_edge)) time = max(time, last_change([effects%absorbing_edge%wave]))
      if (allocated(effects%fixed_point)) time = max(time, last_change(effects%fixed_point%table))
    end associate
  end function steady_from

  !> Whether any support moves in the run.
  pure logical function supports_move(model)
    type(model_t), intent(in) :: model

    supports_move = .false.
    if (allocated(model%effects%fixed_point)) supports_move = model%effects%fixed_point%moves
  end function supports_move

  !> Whether supports move exactly: their work is that of all other forces.
  pure logical function supports_move_exactly(model)
    type(model_t), intent(in) :: model

    supports_move_exactly = supports_move(model)
    if (supports_move_exactly) supports_move_exactly = .not. model%effects%fixed_point%by_springs
  end function supports_move_exactly

  !> Work that moving supports, of which there are some, do on one element in a step.
  !>
  !> An exact support has no force of its own; what the other forces lack at the solution is its reaction.
  pure real(dp) function work_of_supports(model, own, state, e, unknown, rule) result(work)
    type(model_t), intent(in) :: model
    type(element_cache_t), intent(in) :: own   !! of the element
    type(state_t), intent(in) :: state         !! at the beginning of the step
    integer, intent(in) :: e
    real(dp), intent(in) :: unknown(n)         !! of the step
    type(step_rule_t), intent(in) :: rule
    type(term_t) :: term

    if (model%effects%fixed_point%by_springs) then
      work = work_of_springs(model%effects%fixed_point, e, state%point, state%time, rule%dt, own%kinematics, unknown)
    else
      call add_element_effects(model, own, state, e, unknown, rule, term)
      work = -dot_product(term%force, unknown)
    end if
  end function work_of_supports

  !> Work in a step of what pulls bolts apart that join two elements, where supports are exact. Forces out of balance on the
  !> elements alone are those of the supports and of these.
  pure real(dp) function work_of_bolts_between(model, cache, state, d, rule) result(work)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state         !! at the beginning of the step
    real(dp), intent(in) :: d(:)               !! (n_unknowns) of the step
    type(step_rule_t), intent(in) :: rule
    integer :: k, m

    work = 0.0_dp
    if (.not. allocated(model%effects%bolt)) return
    associate (bolt => model%effects%bolt)
      do k = 1, size(bolt%pair, 2)
        associate (pair => bolt%pair(:, k))
          do m = bolt%first_of(k), bolt%first_of(k + 1) - 1
            work = work + work_between(bolt, state%bolts, bolt%joining(m), pair, state%point, rule, &
                                       cache%element(pair)%kinematics, &
                                       [values_of(model%elements, pair(1), d), values_of(model%elements, pair(2), d)])
          end do
        end associate
      end do
    end associate
  end function work_of_bolts_between

  !> Energy that damping and absorbing edges take from one element in a step.
  pure real(dp) function loss_by_damping(model, own, state, e, unknown, rule) result(loss)
    type(model_t), intent(in) :: model
    type(element_cache_t), intent(in) :: own   !! of the element
    type(state_t), intent(in) :: state         !! at the beginning of the step
    integer, intent(in) :: e
    real(dp), intent(in) :: unknown(n)         !! of the step
    type(step_rule_t), intent(in) :: rule

    loss = 0.0_dp
    if (allocated(model%effects%mass_damping)) &
      loss = damped_energy(model%effects%mass_damping, own%mass_matrix, unknown, rule%dt)
    if (allocated(model%effects%stiffness_damping)) &
      loss = loss + strain_loss(model%effects%stiffness_damping, own%kinematics, own%elasticity, own%green, &
                                model%effects%strain_rotation, unknown, rule%dt)
    if (allocated(model%effects%absorbing_edge)) &
      loss = loss + absorbed_energy(model%effects%absorbing_edge, e, state%point, rule%dt, own%kinematics, unknown)
  end function loss_by_damping

  !> Fraction of the weight that acts at a time.
  pure real(dp) function share_of_weight(model, time) result(share)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: time

    share = 1.0_dp
    if (allocated(model%effects%gravity)) share = ramp_at(model%effects%gravity%ramp, time)
  end function share_of_weight

  !> Fraction of the weights that acts in a step, on the mean: their ramp.
  pure real(dp) function mean_share_of_weight(model, rule) result(share)
    type(model_t), intent(in) :: model
    type(step_rule_t), intent(in) :: rule

    share = 1.0_dp
    if (allocated(model%effects%gravity)) &
      share = mean_of_ramp(model%effects%gravity%ramp, rule%load_from, rule%load_to)
  end function mean_share_of_weight

  !> Work in a step of what lets the weights grow: what their energy f S grows by beside what they do. With S the energy of all of
  !> the weight, f its share, of which the balance takes the mean,
  !>
  !>     f1 S1 - f0 S0 - f (S1 - S0) = (f1 - f0) S0 + (f1 - f) (S1 - S0).
  pure real(dp) function work_of_ramp(model, cache, d, rule) result(work)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache         !! at the beginning of the step
    real(dp), intent(in) :: d(:)               !! (n_unknowns) of the step
    type(step_rule_t), intent(in) :: rule
    real(dp) :: before, rise, share(2)
    integer :: e, k

    work = 0.0_dp
    if (.not. allocated(model%effects%gravity)) return
    associate (ramp => model%effects%gravity%ramp, begins => rule%end_time - rule%dt)
      share = [ramp_at(ramp, begins), ramp_at(ramp, rule%end_time)]
      if (.not. share(2) > share(1)) return
      before = cache%fixed%gravity
      rise = 0.0_dp
      do k = 1, size(model%elements%free)
        e = model%elements%free(k)
        before = before + energy_of_weight(model, cache%element(e), e)
        rise = rise + power_of_weight(model, cache%element(e), e, values_of(model%elements, e, d))
      end do
      work = (share(2) - share(1))*before + (share(2) - mean_share_of_weight(model, rule))*rise
    end associate
  end function work_of_ramp

  !> Energy of all the weight of one element, above y = 0.
  pure real(dp) function energy_of_weight(model, own, e) result(energy)
    type(model_t), intent(in) :: model
    type(element_cache_t), intent(in) :: own   !! of the element
    integer, intent(in) :: e

    energy = 0.0_dp
    if (.not. allocated(model%effects%gravity)) return
    associate (weight => model%effects%gravity%weight(e))
      energy = own%mass_ratio*(gravity_energy(weight, own%kinematics) + weight*model%origin(2))
    end associate
  end function energy_of_weight

  !> Rate of the energy of all the weight of one element, force per unit thickness times length over time.
  pure real(dp) function power_of_weight(model, own, e, velocity) result(power)
    type(model_t), intent(in) :: model
    type(element_cache_t), intent(in) :: own   !! of the element
    integer, intent(in) :: e
    real(dp), intent(in) :: velocity(n)        !! rates of its unknowns

    power = 0.0_dp
    if (.not. allocated(model%effects%gravity)) return
    power = own%mass_ratio*model%effects%gravity%weight(e)*dot_product(own%kinematics%at_centroid(2, :), velocity)
  end function power_of_weight

  !> Energy of the springs that hold fixed points.
  pure real(dp) function energy_of_fixed_springs(model, state) result(energy)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state

    energy = 0.0_dp
    if (.not. allocated(model%effects%fixed_point)) return
    if (model%effects%fixed_point%by_springs) energy = spring_energy(model%effects%fixed_point, state%point, state%time)
  end function energy_of_fixed_springs

  !> Energy of the bolts.
  pure real(dp) function energy_of_bolts(model, state) result(energy)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state

    energy = 0.0_dp
    if (allocated(model%effects%bolt)) energy = bolt_energy(model%effects%bolt, state%bolts, state%point)
  end function energy_of_bolts

  !> Weights of the blocks in a step, with the inertia that a ground which accelerates gives them, force per unit thickness; none
  !> where nothing has weight.
  pure function weights_of_blocks(model, rule) result(weights)
    type(model_t), intent(in) :: model
    type(step_rule_t), intent(in) :: rule
    real(dp) :: weights(model%n_blocks)
    real(dp) :: force(2, model%n_blocks), per_mass(2)
    integer :: e

    force = 0.0_dp
    if (allocated(model%effects%gravity)) then
      do e = 1, model%n_elements
        associate (own => force(2, model%elements%block(e)))
          own = own - model%effects%gravity%weight(e)
        end associate
      end do
      force = mean_share_of_weight(model, rule)*force
    end if
    if (allocated(model%effects%base_acceleration)) then
      per_mass = force_of_base(model%effects%base_acceleration, 1.0_dp, rule)
      do e = 1, model%n_elements
        associate (own => force(:, model%elements%block(e)))
          own = own + model%elements%mass(e)*per_mass
        end associate
      end do
    end if
    weights = hypot(force(1, :), force(2, :))
  end function weights_of_blocks

end module scree_effects
