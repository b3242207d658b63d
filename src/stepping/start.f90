!> The beginning of a run, or of a stage: velocities that supports have or allow, where asked acceleration and stress to them.
!>
!> A scheme that does not dissipate (beta 1/2) keeps what its start excites. Consistent with the velocities are the
!> acceleration and the stress of a motion whose strain does not accelerate,
!>
!>     M a + A B0^T sigma = f,      B0 a = -q,    q = A(theta') theta',   theta' = G v,
!>
!> where q is the strain rate of a turning body that does not deform. sigma is the Lagrange multiplier of this condition, the stress
!> that the inertia of turning needs. In a triangle that turns about a fixed corner it is the virial rho w^2/A int x x^T dA.
module scree_start
  use scree_accurate_size, only: first_share
  use scree_cache, only: rebuild_cache
  use scree_constraints, only: complete_unknowns, constraints_t
  use scree_critical_step, only: find_largest_step
  use scree_deviation, only: begin_deviation
  use scree_effects, only: add_drag, refresh_elements, supports_move_exactly
  use scree_element_term, only: add_force, term_t
  use scree_energy, only: close_books, stored_energy
  use scree_equilibrium, only: begin_settling
  use scree_equations, only: add_equations, begin_equations, constrain_equations, members, solve_equations, weakest_element
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_integrator, only: turns_acceleration
  use scree_islands, only: keep_factored
  use scree_kinds, only: dp
  use scree_linear_solver, only: exactness_t
  use scree_model, only: cache_t, model_t
  use scree_reactions, only: forces_at_rest
  use scree_scene, only: scheme_central_difference, start_acceleration, start_consistent
  use scree_state, only: state_t, step_of_run
  use scree_start_of_joints, only: stress_joints
  use scree_stiffness, only: small_strain_operator
  use scree_step_constraints, only: constraints_of_step
  use scree_text, only: rounded_text
  use scree_trouble, only: new_trouble, words_of
  use scree_turning, only: acceleration_of_spin
  implicit none
  private
  public :: begin_run

  !> Stiffness against inertia in the penalty that keeps the strain from accelerating; its inverse is the error
  !> that a round of multipliers leaves of the one before.
  real(dp), parameter :: stiffer = 1e5_dp
  integer, parameter :: most_rounds = 30
  !> Multipliers that change by less have settled: as many digits as the penalty leaves. So exact are solutions, too.
  real(dp), parameter :: settled = 1e-10_dp

contains

  !> Begins a run, or a stage of it, at a state: motion that the scene allows, the equations, the books, the step size.
  !>
  !> Errors: as of `begin_motion`; an explicit step that would be too small.
  subroutine begin_run(model, cache, state, error)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache         !! whatever it holds; then that of the state
    type(state_t), intent(inout) :: state         !! of a later stage, with the books of the one before
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: before                            !! energy

    before = stored_energy(state%books)
    state%books%sleeping_springs = 0.0_dp ! all are awake, and some may be gone or have another stiffness
    state%pace%size = model%settings%step_size
    if (model%settings%aim > 0) state%pace%size = max(model%settings%least_step, first_share*model%settings%step_size)
    state%pace%last = state%pace%size
    state%pace%pseudo = huge(1.0_dp)
    call rebuild_cache(model, state, cache)
    if (allocated(model%outlines%stress) .and. step_of_run(state) == 0) call stress_joints(model, cache, state)
    if (allocated(state%contacts%contact)) state%books%contact_springs = sum(state%contacts%contact%energy)
    call begin_motion(model, cache, state, error)
    if (allocated(error)) return
    call refresh_elements(model, state, cache)
    call keep_factored(cache%equations, state%factored)
    if (model%settings%scheme == scheme_central_difference) call check_step(model, cache, error)
    if (allocated(error)) return
    call close_books(model, cache, state)
    if (state%stage%number == 1) then
      state%books%at_start = stored_energy(state%books)
    else
      state%books%staged = state%books%staged + stored_energy(state%books) - before
    end if
    if (model%settings%balance > 0) call begin_settling(model, state)
    if (model%settings%estimates_error) call begin_deviation(model, cache, state)
  end subroutine begin_run

  !> Error where explicit steps would be below the least that the deck allows.
  subroutine check_step(model, cache, error)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: dt
    integer :: e

    call find_largest_step(model, cache, dt, e)
    if (.not. dt < model%settings%least_step) return
    call fail(error, status_run_failed, 'the start: '//words_of(new_trouble( &
      'an explicit step may have '//rounded_text(dt)//' at most, which is below step.least, '// &
      rounded_text(model%settings%least_step), 'a smaller step.least or another integrator.scheme, and check density and E there', &
      e, cache%element(e)%kinematics%centroid), model))
  end subroutine check_step

  !> Projects the velocities onto what exact fixed points allow, or tables move them by in the first step (least kinetic energy of
  !> the change), then finds acceleration and stress as `settings%start` asks.
  !>
  !> Errors: fixed points that contradict each other; an element without mass that must accelerate.
  subroutine begin_motion(model, cache, state, error)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(inout) :: state
    type(error_t), allocatable, intent(out) :: error
    type(constraints_t) :: constraints, rates
    type(term_t) :: terms(model%n_elements)
    real(dp) :: change(model%n_unknowns), velocity(model%n_unknowns)
    integer :: e

    call constraints_of_step(model, cache, state, state%time, constraints, error)
    if (allocated(error)) return
    call constrain_equations(cache%equations, constraints)
    velocity = 0.0_dp
    if (supports_move_exactly(model) .and. .not. model%effects%is_static()) then
      call constraints_of_step(model, cache, state, state%time + state%pace%size, rates, error)
      if (allocated(error)) return
      rates%given = (rates%given - constraints%given)/state%pace%size
      call complete_unknowns(rates, velocity, homogeneous=.false.)
    end if
    if (constraints%n_rows > 0 .and. any(abs(state%velocity - velocity) > 0)) then
      do e = 1, model%n_elements
        terms(e)%matrix = cache%element(e)%mass_matrix
        associate (ids => model%elements%unknown(:, e))
          call add_force(terms(e), matmul(terms(e)%matrix, state%velocity(ids) - velocity(ids)))
        end associate
      end do
      call solve_for(model, cache, terms, change, error)
      if (allocated(error)) return
      state%velocity = velocity + change
    end if
    if (any(model%settings%start == [start_acceleration, start_consistent])) then
      call accelerate(model, cache, model%settings%start == start_consistent, state, error)
    else if (turns_acceleration(model%settings)) then
      state%acceleration = acceleration_of_spin(model, cache, state)
    end if
    if (allocated(model%sampling)) call complete_unknowns(constraints, state%acceleration, homogeneous=.true.)
  end subroutine begin_motion

  !> Acceleration, and the stress to it, by the method of multipliers.
  subroutine accelerate(model, cache, stressed, state, error)
    type(model_t), intent(in) :: model
    logical, intent(in) :: stressed               !! the state takes the stress too
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(inout) :: state
    type(error_t), allocatable, intent(out) :: error
    type(term_t) :: terms(model%n_elements), forces(model%n_elements)
    real(dp), dimension(3, model%n_elements) :: stress, change
    real(dp) :: B(3, size(cache%element(1)%kinematics%gradient, 2)), D(3, 3), penalty
    integer :: e, round

    call forces_at_rest(model, cache, state, forces)
    penalty = 0.0_dp
    do e = 1, model%n_elements
      call add_drag(model, cache%element(e), state, e, state%velocity(model%elements%unknown(:, e)), forces(e))
      penalty = max(penalty, stiffer*cache%element(e)%mass/cache%element(e)%elasticity(1, 1)) ! rho l^2 / E, time^2
    end do

    stress = 0.0_dp
    do round = 1, most_rounds
      do e = 1, model%n_elements
        associate (element => cache%element(e)%kinematics)
          B = small_strain_operator(element)
          D = penalty*cache%element(e)%elasticity
          terms(e) = term_t()
          terms(e)%matrix = cache%element(e)%mass_matrix + element%area*matmul(transpose(B), matmul(D, B))
          call add_force(terms(e), forces(e)%force)
          call add_force(terms(e), -element%area*matmul(stress(:, e) + matmul(D, turning(model, cache, state, e)), B))
        end associate
      end do
      call solve_for(model, cache, terms, state%acceleration, error)
      if (allocated(error)) return
      do e = 1, model%n_elements
        associate (acceleration => state%acceleration(model%elements%unknown(:, e)))
          change(:, e) = penalty*matmul(cache%element(e)%elasticity, turning(model, cache, state, e) &
                                        + matmul(small_strain_operator(cache%element(e)%kinematics), acceleration))
        end associate
      end do
      stress = stress + change
      if (maxval(abs(change)) <= settled*maxval(abs(stress))) exit
    end do
    if (stressed) state%stress = state%stress + stress
  end subroutine accelerate

  !> Second rate of Green strain of element `e` that moves without acceleration, A(theta') theta'.
  pure function turning(model, cache, state, e) result(q)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(cache_t), intent(in) :: cache
    integer, intent(in) :: e
    real(dp) :: q(3), rate(4)

    rate = matmul(cache%element(e)%kinematics%gradient, state%velocity(model%elements%unknown(:, e)))
    q = [sum(rate(1:2)**2), sum(rate(3:4)**2), 2*dot_product(rate(1:2), rate(3:4))]
  end function turning

  !> Solves the equations of all groups for x.
  subroutine solve_for(model, cache, terms, x, error)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(term_t), intent(in) :: terms(:)          !! (n_elements)
    real(dp), intent(out) :: x(:)                 !! (n_unknowns)
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: list(:)
    real(dp) :: residual
    integer :: e, group, k

    x = 0.0_dp
    do group = 1, cache%equations%n_groups
      call begin_equations(cache%equations, group)
      list = members(cache%equations, group)
      do k = 1, size(list)
        call add_equations(cache%equations, group, k, cache%element(list(k))%kinematics%span, terms(list(k)))
      end do
      call solve_equations(cache%equations, cache%timers, group, exactness_t(settled), x, residual, error)
      if (.not. allocated(error)) cycle
      e = weakest_element(cache%equations, group)
      error%message = 'the start: '//words_of(new_trouble(error%message, 'another integrator.start, and check density and '// &
        'fixed points there', e, cache%element(max(1, e))%kinematics%centroid), model)
      return
    end do
  end subroutine solve_for

end module scree_start
