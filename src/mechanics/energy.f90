!> The books of energy and momentum, per unit thickness.
module scree_energy
  use scree_base_acceleration, only: work_of_base
  use scree_effects, only: add_element_effects
  use scree_fixed_point, only: moved_supports, spring_energy, work_of_springs
  use scree_gravity, only: gravity_energy
  use scree_inertia, only: kinetic_energy, momentum
  use scree_kinds, only: dp
  use scree_mass_damping, only: damped_energy
  use scree_model, only: cache_t, model_t
  use scree_point_load, only: work_of_point_loads
  use scree_element_term, only: step_rule_t, term_t
  use scree_state, only: state_t
  implicit none
  private
  public :: close_books, loss_by_damping, work_of_step

contains

  !> Puts the energies and the momentum of a state into its books; what came and went since the start is in them.
  pure subroutine close_books(model, cache, state)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(inout) :: state
    real(dp) :: p(3)
    integer :: e

    associate (books => state%books, effects => model%effects)
      books%kinetic = 0.0_dp
      books%strain = 0.0_dp
      books%gravity = 0.0_dp
      books%fixed_springs = 0.0_dp
      books%momentum = 0.0_dp
      do e = 1, model%n_elements
        associate (velocity => state%velocity(model%elements%unknown(:, e)), own => cache%element(e))
          books%kinetic = books%kinetic + kinetic_energy(own%mass_matrix, velocity)
          books%strain = books%strain + own%kinematics%area*strain_energy(own%elasticity, state%stress(:, e))
          if (allocated(effects%gravity)) books%gravity = books%gravity &
            + own%mass_ratio*(gravity_energy(effects%gravity%weight(e), own%kinematics) &
                              + effects%gravity%weight(e)*model%origin(2))
          p = momentum(own%kinematics, own%mass, velocity)
          p(3) = p(3) + model%origin(1)*p(2) - model%origin(2)*p(1)
          books%momentum = books%momentum + p
        end associate
      end do
      if (allocated(effects%fixed_point)) then
        if (effects%fixed_point%by_springs) &
          books%fixed_springs = spring_energy(effects%fixed_point, state%point, state%time)
      end if
    end associate
  end subroutine close_books

  !> Energy of a stress in a unit of area, sigma D^-1 sigma / 2.
  pure real(dp) function strain_energy(D, stress)
    real(dp), intent(in) :: D(3, 3)   !! symmetric, force/length^2
    real(dp), intent(in) :: stress(3) !! force/length^2
    real(dp) :: cofactor(3, 3)

    cofactor(:, 1) = cross(D(:, 2), D(:, 3))
    cofactor(:, 2) = cross(D(:, 3), D(:, 1))
    cofactor(:, 3) = cross(D(:, 1), D(:, 2))
    strain_energy = 0.5_dp*dot_product(stress, matmul(cofactor, stress))/dot_product(D(:, 1), cofactor(:, 1))

  contains

    pure function cross(a, b)
      real(dp), intent(in) :: a(3), b(3)
      real(dp) :: cross(3)

      cross = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
    end function cross

  end function strain_energy

  !> Work of loads, the ground and moving supports in a step.
  pure real(dp) function work_of_step(model, cache, state, rule, d)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state            !! at the beginning of the step
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: d(:)                  !! (n_unknowns) of the step

    work_of_step = work_of_loads(model, cache, state, rule, d) + work_of_supports(model, cache, state, rule, d)
  end function work_of_step

  !> Work of the point loads and of the inertia force of the ground in a step.
  pure real(dp) function work_of_loads(model, cache, state, rule, d)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state            !! at the beginning of the step
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: d(:)                  !! (n_unknowns) of the step
    integer :: e

    work_of_loads = 0.0_dp
    do e = 1, model%n_elements
      associate (unknown => d(model%elements%unknown(:, e)), element => cache%element(e)%kinematics)
        if (allocated(model%effects%base_acceleration)) &
          work_of_loads = work_of_loads + work_of_base(model%effects%base_acceleration, cache%element(e)%mass, rule, element, &
              unknown)
        if (allocated(model%effects%point_load)) &
          work_of_loads = work_of_loads + work_of_point_loads(model%effects%point_load, e, state%point, rule, element, unknown)
      end associate
    end do
  end function work_of_loads

  !> Energy that mass damping takes in a step.
  pure real(dp) function loss_by_damping(model, cache, rule, d)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: d(:)                  !! (n_unknowns) of the step
    integer :: e

    loss_by_damping = 0.0_dp
    if (.not. allocated(model%effects%mass_damping)) return
    do e = 1, model%n_elements
      loss_by_damping = loss_by_damping + damped_energy(model%effects%mass_damping, cache%element(e)%mass_matrix, &
                                                        d(model%elements%unknown(:, e)), rule%dt)
    end do
  end function loss_by_damping

  !> Work that moving supports do in a step.
  !>
  !> An exact support has no force of its own; what the other forces lack at the solution is its reaction.
  pure real(dp) function work_of_supports(model, cache, state, rule, d)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state            !! at the beginning of the step
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: d(:)                  !! (n_unknowns) of the step
    type(term_t) :: term
    integer :: e

    work_of_supports = 0.0_dp
    if (.not. allocated(model%effects%fixed_point)) return
    if (.not. moved_supports(model%effects%fixed_point)) return
    do e = 1, model%n_elements
      associate (unknown => d(model%elements%unknown(:, e)))
        if (model%effects%fixed_point%by_springs) then
          work_of_supports = work_of_supports + work_of_springs(model%effects%fixed_point, e, state%point, state%time, rule%dt, &
                                                                cache%element(e)%kinematics, unknown)
        else
          call add_element_effects(model, cache%element(e), state, e, unknown, rule, term)
          work_of_supports = work_of_supports - dot_product(term%force, unknown)
        end if
      end associate
    end do
  end function work_of_supports

end module scree_energy
