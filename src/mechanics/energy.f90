!> The books of energy and momentum, per unit thickness.
module scree_energy
  use scree_base_acceleration, only: work_of_base
  use scree_effects, only: add_element_effects, effects_t, element_cache_t
  use scree_fixed_point, only: moved_supports, spring_energy, work_of_springs
  use scree_gravity, only: gravity_energy
  use scree_inertia, only: kinetic_energy, momentum
  use scree_kinds, only: dp
  use scree_mass_damping, only: damped_energy
  use scree_point_load, only: work_of_point_loads
  use scree_element_term, only: step_rule_t, term_t
  use scree_system, only: state_t, system_t
  implicit none
  private
  public :: books_t, close_books, loss_by_damping, work_of_loads, work_of_supports

  !> Energy at one time, and momentum about the origin of the decks.
  type :: books_t
    real(dp) :: kinetic = 0.0_dp       !! force length per unit thickness, as all energies
    real(dp) :: strain = 0.0_dp        !! of the present stress
    real(dp) :: gravity = 0.0_dp       !! weight times height above y = 0
    real(dp) :: fixed_springs = 0.0_dp !! of springs that hold fixed points
    real(dp) :: momentum(3) = 0.0_dp   !! x, y: mass/time; angular: mass length/time
  end type books_t

contains

  !> Sums energy and momentum over the elements as they stand.
  pure function close_books(system, effects, share, state) result(books)
    type(system_t), intent(in) :: system
    type(effects_t), intent(in) :: effects
    type(element_cache_t), intent(in) :: share(:) !! (n_elements) of `state`
    type(state_t), intent(in) :: state
    type(books_t) :: books
    real(dp) :: p(3)
    integer :: e

    do e = 1, system%n_elements
      associate (velocity => state%velocity(system%elements%unknown(:, e)), element => share(e)%kinematics)
        books%kinetic = books%kinetic + kinetic_energy(share(e)%mass_matrix, velocity)
        books%strain = books%strain + element%area*strain_energy(share(e)%elasticity, state%stress(:, e))
        if (allocated(effects%gravity)) books%gravity = books%gravity &
          + share(e)%mass_ratio*(gravity_energy(effects%gravity%weight(e), element) &
                                 + effects%gravity%weight(e)*system%origin(2))
        p = momentum(element, share(e)%mass, velocity)
        p(3) = p(3) + system%origin(1)*p(2) - system%origin(2)*p(1)
        books%momentum = books%momentum + p
      end associate
    end do
    if (allocated(effects%fixed_point)) then
      if (effects%fixed_point%by_springs) &
        books%fixed_springs = spring_energy(effects%fixed_point, state%point, state%time)
    end if
  end function close_books

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

  !> Work of the point loads and of the inertia force of the ground in a step.
  pure real(dp) function work_of_loads(system, effects, share, state, rule, d)
    type(system_t), intent(in) :: system
    type(effects_t), intent(in) :: effects
    type(element_cache_t), intent(in) :: share(:) !! (n_elements)
    type(state_t), intent(in) :: state            !! at the beginning of the step
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: d(:)                  !! (n_unknowns) of the step
    integer :: e

    work_of_loads = 0.0_dp
    do e = 1, system%n_elements
      associate (unknown => d(system%elements%unknown(:, e)), element => share(e)%kinematics)
        if (allocated(effects%base_acceleration)) &
          work_of_loads = work_of_loads + work_of_base(effects%base_acceleration, share(e)%mass, rule, element, unknown)
        if (allocated(effects%point_load)) &
          work_of_loads = work_of_loads + work_of_point_loads(effects%point_load, e, state%point, rule, element, unknown)
      end associate
    end do
  end function work_of_loads

  !> Energy that mass damping takes in a step.
  pure real(dp) function loss_by_damping(system, effects, share, rule, d)
    type(system_t), intent(in) :: system
    type(effects_t), intent(in) :: effects
    type(element_cache_t), intent(in) :: share(:) !! (n_elements)
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: d(:)                  !! (n_unknowns) of the step
    integer :: e

    loss_by_damping = 0.0_dp
    if (.not. allocated(effects%mass_damping)) return
    do e = 1, system%n_elements
      loss_by_damping = loss_by_damping + damped_energy(effects%mass_damping, share(e)%mass_matrix, &
                                                        d(system%elements%unknown(:, e)), rule%dt)
    end do
  end function loss_by_damping

  !> Work that moving supports do in a step.
  !>
  !> An exact support has no force of its own; what the other forces lack at the solution is its reaction.
  pure real(dp) function work_of_supports(system, effects, share, state, rule, d)
    type(system_t), intent(in) :: system
    type(effects_t), intent(in) :: effects
    type(element_cache_t), intent(in) :: share(:) !! (n_elements)
    type(state_t), intent(in) :: state            !! at the beginning of the step
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: d(:)                  !! (n_unknowns) of the step
    type(term_t) :: term
    integer :: e

    work_of_supports = 0.0_dp
    if (.not. allocated(effects%fixed_point)) return
    if (.not. moved_supports(effects%fixed_point)) return
    do e = 1, system%n_elements
      associate (unknown => d(system%elements%unknown(:, e)))
        if (effects%fixed_point%by_springs) then
          work_of_supports = work_of_supports + work_of_springs(effects%fixed_point, e, state%point, state%time, rule%dt, &
                                                                share(e)%kinematics, unknown)
        else
          call add_element_effects(effects, system, state, e, share(e), unknown, rule, term)
          work_of_supports = work_of_supports - dot_product(term%force, unknown)
        end if
      end associate
    end do
  end function work_of_supports

end module scree_energy
