!> The books of energy and momentum, per unit thickness.
module scree_energy
  use scree_effects, only: energy_of_bolts, energy_of_fixed_springs, energy_of_weight, loss_by_damping, power_of_weight, &
      share_of_weight, supports_move, supports_move_exactly, work_of_bolts_between, work_of_loads, work_of_supports
  use scree_element_term, only: step_rule_t
  use scree_inertia, only: kinetic_energy, momentum
  use scree_integrator, only: held_weight, holds_power
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_state, only: books_t, state_t
  use scree_stiffness, only: small_strain_operator
  use scree_system, only: element_unknowns, values_of
  implicit none
  private
  public :: books_of_fixed, close_books, dissipated_energy, find_work_of_step, loss_of_step, stored_energy

contains

  !> Puts the energies and the momentum of a state into its books; what came and went since the start is in them.
  pure subroutine close_books(model, cache, state)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(inout) :: state
    real(dp) :: p(3)
    integer :: e, k

    associate (books => state%books, fixed => cache%fixed)
      books%kinetic = 0.0_dp
      books%strain = fixed%strain
      books%gravity = fixed%gravity
      books%integrator = 0.0_dp
      books%momentum = 0.0_dp
      do k = 1, size(model%elements%free)
        e = model%elements%free(k)
        associate (velocity => values_of(model%elements, e, state%velocity), own => cache%element(e), &
                   change => state%pace%last*values_of(model%elements, e, state%acceleration))
          books%kinetic = books%kinetic + kinetic_energy(own%mass_matrix, velocity)
          books%integrator = books%integrator + kinetic_energy(own%mass_matrix, change)
          call add_stored(model, cache, state, e, books)
          p = momentum(own%kinematics, own%mass, velocity)
          p(3) = p(3) + model%origin(1)*p(2) - model%origin(2)*p(1)
          books%momentum = books%momentum + p
        end associate
      end do
      if (model%settings%takes_small_steps()) books%strain = 0.0_dp
      books%integrator = held_weight(model%settings)*books%integrator
      if (holds_power(model%settings)) books%integrator = held_in_half_a_step(model, cache, state)
      books%gravity = share_of_weight(model, state%time)*books%gravity
      books%fixed_springs = energy_of_fixed_springs(model, state)
      books%bolts = energy_of_bolts(model, state)
    end associate
  end subroutine close_books

  !> What central differences hold where a step ends: kinetic energy of the velocity half a step ago in place of that of the end,
  !> less what elastic forces and weight have taken up since. With it energy is exact where stiffness and mass are constant
  !> (doc/theory/integrators.md, eq-held-energy).
  pure real(dp) function held_in_half_a_step(model, cache, state) result(held)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    real(dp) :: halfway(element_unknowns), half, share
    integer :: e, k

    held = 0.0_dp
    if (state%step == 0) return
    half = 0.5_dp*merge(state%pace%small, state%pace%last, model%settings%takes_small_steps())
    share = share_of_weight(model, state%time)
    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      associate (velocity => values_of(model%elements, e, state%velocity), own => cache%element(e))
        if (model%settings%takes_small_steps()) then ! the velocity is that of half a step ago
          held = held - half*share*power_of_weight(model, own, e, velocity)
          cycle
        end if
        halfway = velocity - half*values_of(model%elements, e, state%acceleration)
        held = held + kinetic_energy(own%mass_matrix, halfway) - kinetic_energy(own%mass_matrix, velocity) &
               - half*(own%kinematics%area*dot_product(state%stress(:, e), matmul(small_strain_operator(own%kinematics), halfway)) &
                       + share*power_of_weight(model, own, e, halfway))
      end associate
    end do
  end function held_in_half_a_step

  !> Energies of the elements that cannot move, which stay as they are.
  pure type(books_t) function books_of_fixed(model, cache, state) result(books)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    logical :: fixed(model%n_elements)
    integer :: e

    fixed = .true.
    fixed(model%elements%free) = .false.
    do e = 1, model%n_elements
      if (fixed(e)) call add_stored(model, cache, state, e, books)
    end do
  end function books_of_fixed

  !> Adds the energies of stress and weight of an element.
  pure subroutine add_stored(model, cache, state, e, books)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    integer, intent(in) :: e
    type(books_t), intent(inout) :: books

    associate (own => cache%element(e))
      books%strain = books%strain + own%kinematics%area*strain_energy(own%elasticity, state%stress(:, e))
      books%gravity = books%gravity + energy_of_weight(model, own, e)
    end associate
  end subroutine add_stored

  !> All energy that a state has.
  pure real(dp) function stored_energy(books) result(energy)
    type(books_t), intent(in) :: books

    energy = books%kinetic + books%strain + books%gravity + books%fixed_springs + books%contact_springs + books%sleeping_springs &
             + books%bolts + books%integrator
  end function stored_energy

  !> Energy dissipated since the run began: initial energy, changes by stages and work, less the present energy.
  pure real(dp) function dissipated_energy(books) result(energy)
    type(books_t), intent(in) :: books

    energy = books%at_start + books%staged + books%work - stored_energy(books)
  end function dissipated_energy

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

    !> Vector product.
    pure function cross(a, b)
      real(dp), intent(in) :: a(3), b(3)
      real(dp) :: cross(3)

      cross = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
    end function cross

  end function strain_energy

  !> Work of loads, the ground and moving supports in a step, force length per unit thickness.
  pure subroutine find_work_of_step(model, cache, state, rule, d, work, supports)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state            !! at the beginning of the step
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: d(:)                  !! (n_unknowns) of the step
    real(dp), intent(out) :: work                 !! of all
    real(dp), intent(out) :: supports             !! of moving supports alone
    logical :: moving
    integer :: e, k

    work = 0.0_dp
    supports = 0.0_dp
    moving = supports_move(model)
    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      associate (unknown => values_of(model%elements, e, d))
        work = work + work_of_loads(model, cache%element(e), state, e, unknown, rule)
        if (moving) supports = supports + work_of_supports(model, cache%element(e), state, e, unknown, rule)
      end associate
    end do
    if (supports_move_exactly(model)) supports = supports + work_of_bolts_between(model, cache, state, d, rule)
    work = work + supports
  end subroutine find_work_of_step

  !> Energy that damping takes in a step.
  pure real(dp) function loss_of_step(model, cache, state, rule, d) result(loss)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state            !! at the beginning of the step
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: d(:)                  !! (n_unknowns) of the step
    integer :: e, k

    loss = 0.0_dp
    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      loss = loss + loss_by_damping(model, cache%element(e), state, e, values_of(model%elements, e, d), rule)
    end do
  end function loss_of_step

end module scree_energy
