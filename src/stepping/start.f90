!> The beginning of a run: velocities that the fixed points allow, and where asked the acceleration and stress to them.
!>
!> A scheme that does not dissipate (beta 1/2) keeps what its start excites. Consistent with the velocities are the
!> acceleration and the stress of a motion whose strain does not accelerate,
!>
!>     M a + A B0^T sigma = f,      B0 a = -q,    q = A(theta') theta',   theta' = G v,
!>
!> q the strain rate that a turning body has without deforming; sigma, its Lagrange multiplier, is what the inertia
!> of the turning asks for: in a triangle about a fixed corner the virial rho w^2/A int x x^T dA.
module scree_start
  use scree_constraints, only: constraints_t
  use scree_effects, only: add_element_effects, effects_t, element_cache_t
  use scree_element_term, only: add_force, step_rule_t, term_t
  use scree_equations, only: add_equations, begin_equations, constrain_equations, equations_t, members, solve_equations, &
                             weakest_element
  use scree_errors, only: error_t
  use scree_kinds, only: dp
  use scree_scene, only: settings_t, start_acceleration, start_consistent
  use scree_stiffness, only: small_strain_operator
  use scree_system, only: state_t, system_t
  use scree_time_stepper, only: constraints_of_step
  use scree_trouble, only: new_trouble, words_of
  implicit none
  private
  public :: begin_motion

  !> Stiffness against inertia in the penalty that keeps the strain from accelerating; its inverse is the error
  !> that a round of multipliers leaves of the one before.
  real(dp), parameter :: stiffer = 1e5_dp
  integer, parameter :: most_rounds = 30
  !> Multipliers that change by less have settled: as many digits as the penalty leaves.
  real(dp), parameter :: settled = 1e-10_dp

contains

  !> Projects the velocities onto what exact fixed points allow (least kinetic energy of the change), then finds
  !> acceleration and stress as `settings%start` asks.
  !>
  !> Errors: fixed points that contradict each other; an element without mass that must accelerate.
  subroutine begin_motion(system, effects, settings, share, equations, state, error)
    type(system_t), intent(in) :: system
    type(effects_t), intent(in) :: effects
    type(settings_t), intent(in) :: settings
    type(element_cache_t), intent(in) :: share(:) !! (n_elements)
    type(equations_t), intent(inout) :: equations
    type(state_t), intent(inout) :: state
    type(error_t), allocatable, intent(out) :: error
    type(constraints_t) :: constraints
    type(term_t) :: terms(system%n_elements)
    integer :: e

    call constraints_of_step(system, effects, share, state, state%time, constraints, error)
    if (allocated(error)) return
    call constrain_equations(equations, constraints)
    if (constraints%n_rows > 0 .and. any(abs(state%velocity) > 0.0_dp)) then
      do e = 1, system%n_elements
        terms(e)%matrix = share(e)%mass_matrix
        call add_force(terms(e), matmul(terms(e)%matrix, state%velocity(system%elements%unknown(:, e))))
      end do
      call solve_for(system, equations, share, terms, state%velocity, error)
      if (allocated(error)) return
    end if
    if (any(settings%start == [start_acceleration, start_consistent])) &
      call accelerate(system, effects, settings%start == start_consistent, share, equations, state, error)
  end subroutine begin_motion

  !> Acceleration, and the stress to it, by the method of multipliers.
  subroutine accelerate(system, effects, stressed, share, equations, state, error)
    type(system_t), intent(in) :: system
    type(effects_t), intent(in) :: effects
    logical, intent(in) :: stressed               !! the state takes the stress too
    type(element_cache_t), intent(in) :: share(:) !! (n_elements)
    type(equations_t), intent(inout) :: equations
    type(state_t), intent(inout) :: state
    type(error_t), allocatable, intent(out) :: error
    type(term_t) :: terms(system%n_elements), forces(system%n_elements)
    type(state_t) :: at_rest
    type(step_rule_t) :: rule
    real(dp), dimension(3, system%n_elements) :: stress, change
    real(dp) :: B(3, size(share(1)%kinematics%gradient, 2)), D(3, 3), penalty
    integer :: e, round

    at_rest = state
    at_rest%velocity = 0.0_dp
    at_rest%acceleration = 0.0_dp
    rule%dt = 1.0_dp ! of no consequence: nothing moves
    rule%load_from = state%time
    rule%load_to = state%time
    rule%end_time = state%time
    penalty = 0.0_dp
    do e = 1, system%n_elements
      call add_element_effects(effects, system, at_rest, e, share(e), 0*state%velocity(system%elements%unknown(:, e)), &
                               rule, forces(e))
      if (allocated(effects%mass_damping)) &
        call add_force(forces(e), -effects%mass_damping%rate*matmul(share(e)%mass_matrix, &
                                                                    state%velocity(system%elements%unknown(:, e))))
      penalty = max(penalty, stiffer*share(e)%mass/share(e)%elasticity(1, 1)) ! rho l^2 / E, time^2
    end do

    stress = 0.0_dp
    do round = 1, most_rounds
      do e = 1, system%n_elements
        associate (element => share(e)%kinematics)
          B = small_strain_operator(element)
          D = penalty*share(e)%elasticity
          terms(e) = term_t()
          terms(e)%matrix = share(e)%mass_matrix + element%area*matmul(transpose(B), matmul(D, B))
          call add_force(terms(e), forces(e)%force)
          call add_force(terms(e), -element%area*matmul(stress(:, e) + matmul(D, turning(system, state, share, e)), B))
        end associate
      end do
      call solve_for(system, equations, share, terms, state%acceleration, error)
      if (allocated(error)) return
      do e = 1, system%n_elements
        associate (acceleration => state%acceleration(system%elements%unknown(:, e)))
          change(:, e) = penalty*matmul(share(e)%elasticity, turning(system, state, share, e) &
                                        + matmul(small_strain_operator(share(e)%kinematics), acceleration))
        end associate
      end do
      stress = stress + change
      if (maxval(abs(change)) <= settled*maxval(abs(stress))) exit
    end do
    if (stressed) state%stress = state%stress + stress
  end subroutine accelerate

  !> Second rate of Green strain of element `e` that moves without acceleration, A(theta') theta'.
  pure function turning(system, state, share, e) result(q)
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    type(element_cache_t), intent(in) :: share(:)
    integer, intent(in) :: e
    real(dp) :: q(3), rate(4)

    rate = matmul(share(e)%kinematics%gradient, state%velocity(system%elements%unknown(:, e)))
    q = [sum(rate(1:2)**2), sum(rate(3:4)**2), 2*dot_product(rate(1:2), rate(3:4))]
  end function turning

  !> Solves the equations of all groups for x.
  subroutine solve_for(system, equations, share, terms, x, error)
    type(system_t), intent(in) :: system
    type(equations_t), intent(inout) :: equations
    type(element_cache_t), intent(in) :: share(:) !! (n_elements)
    type(term_t), intent(in) :: terms(:)          !! (n_elements)
    real(dp), intent(out) :: x(:)                 !! (n_unknowns)
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: list(:)
    integer :: e, group, k

    x = 0.0_dp
    do group = 1, equations%n_groups
      call begin_equations(equations, group)
      list = members(equations, group)
      do k = 1, size(list)
        call add_equations(equations, group, k, share(list(k))%kinematics%span, terms(list(k)))
      end do
      call solve_equations(equations, group, .true., x, error)
      if (.not. allocated(error)) cycle
      e = weakest_element(equations, group)
      error%message = 'the start: '//words_of(new_trouble(error%message, 'another integrator.start, and check density and '// &
        'fixed points there', e, share(max(1, e))%kinematics%centroid), system)
      return
    end do
  end subroutine solve_for

end module scree_start
