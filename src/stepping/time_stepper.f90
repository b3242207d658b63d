!> One accepted step: large deformation outside (Zhang et al. 2019, Fig. 9).
module scree_time_stepper
  use scree_constraints, only: add_followers, clear_constraints, complete_unknowns, constraints_t
  use scree_deformation_iteration, only: iteration_report_t, settle_deformation
  use scree_effects, only: effects_t, element_cache_t, cache_of_element
  use scree_element_term, only: step_rule_t
  use scree_contact_detection, only: find_contacts
  use scree_contact_search, only: at_outlines, outran
  use scree_contacts, only: contact_law_t
  use scree_energy, only: loss_by_damping, work_of_loads, work_of_supports
  use scree_equations, only: constrain_equations, equations_t, link_elements
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_fixed_point, only: constrain_fixed_points
  use scree_green_strain, only: green_strain
  use scree_impact, only: rebound_contacts
  use scree_integrator, only: step_rule_for, still_displacement
  use scree_interpolation, only: displacement_matrix
  use scree_interruption, only: stop_signal
  use scree_kinds, only: dp
  use scree_polygon, only: twice_area
  use scree_open_close, only: accept_contacts, begin_again, begin_contacts
  use scree_regions, only: first_vertex_of, last_vertex_of
  use scree_scene, only: settings_t
  use scree_shi_control, only: adapt_stiffness
  use scree_stiffness, only: small_strain
  use scree_system, only: state_t, system_t
  use scree_text, only: rounded_text
  use scree_contact_try, only: farthest_apart, contact_try_t
  use scree_trouble, only: new_trouble, words_of
  use scree_update, only: update_state
  implicit none
  private
  public :: advance, constraints_of_step, step_report_t

  real(dp), parameter :: cut = 0.35_dp !! of a step that did not settle (Zhang et al. 2019)
  !> Where the step is chosen: of one that did not settle, and how many times as far as it should a vertex may go (Shi).
  real(dp), parameter :: shorter_cut = 0.3_dp, leeway = 3.0_dp
  !> Where the stiffness of contacts adapts: overlap over that allowed for which it grows, by how much, and how often in a step.
  real(dp), parameter :: too_deep = 2.5_dp, stiffening = 10.0_dp
  integer, parameter :: most_stiffenings = 5
  real(dp), parameter :: least_size = 1e-12_dp !! of a block over its distance from the middle: four digits are left for its shape

  !> What a step took.
  type :: step_report_t
    real(dp) :: dt = 0.0_dp           !! time
    integer :: iterations = 0         !! of the accepted try
    integer :: solves = 0             !! of all tries
    integer, allocatable :: judged(:, :) !! (4, n) contacts open, sliding, locked, changing, at each judgement of all tries
    integer :: rejected = 0           !! tries
    real(dp) :: travel = 0.0_dp       !! largest of a vertex, where a step may go only so far, length
    real(dp) :: work = 0.0_dp         !! of loads, ground and supports, force length per unit thickness
    real(dp) :: damped = 0.0_dp       !! energy that mass damping took, likewise
  end type step_report_t

contains

  !> Takes `state` to the end of one step of size `dt`, or a smaller one where that does not settle.
  !>
  !> A rejected try has changed nothing but its own unknowns and, as in Shi's programs, the states that the next one begins with.
  !> Where a signal asks to stop after a rejected try, the state stays as it was. Errors: the step falls below its least size;
  !> fixed points contradict each other.
  subroutine advance(system, effects, settings, dt, equations, share, state, report, error)
    type(system_t), intent(in) :: system
    type(effects_t), intent(inout) :: effects        !! the stiffness of contacts may adapt
    type(settings_t), intent(in) :: settings
    real(dp), intent(in) :: dt                       !! size to try, time
    type(equations_t), intent(inout) :: equations
    type(element_cache_t), intent(inout) :: share(:) !! (n_elements) of `state`, at the beginning and at the end
    type(state_t), intent(inout) :: state
    type(step_report_t), intent(out) :: report
    type(error_t), allocatable, intent(out) :: error
    type(iteration_report_t) :: try
    type(constraints_t) :: constraints
    type(step_rule_t) :: rule
    type(contact_try_t) :: contact_try
    real(dp) :: beyond(3), d(system%n_unknowns), d_motion(system%n_unknowns), shorter
    integer :: b, e, stiffened
    logical :: again !! with the contacts as the try before left them

    report%dt = dt
    allocate (report%judged(4, 0))
    stiffened = 0
    do
      rule = step_rule_for(settings, state%step, state%time, report%dt)
      again = .false.
      if (allocated(effects%contact)) again = effects%contact%lags .and. state%contacts%outside > 0 .and. report%rejected > 0
      if (allocated(effects%contact) .and. .not. again) call detect(system, share, report%dt, equations, state)
      call constraints_of_step(system, effects, share, state, state%time + report%dt, constraints, error)
      if (allocated(error)) return
      call constrain_equations(equations, constraints)
      d = report%dt*state%velocity
      call complete_unknowns(constraints, d, homogeneous=.false.)
      try = iteration_report_t()
      if (again) then
        call begin_again(effects%contact, rule, contact_try)
      else if (allocated(effects%contact)) then
        call begin_contacts(system, effects%contact, state, share, effects%large_deformation, rule, contact_try)
      end if
      call settle_deformation(system, effects, settings, state, share, rule, equations, d, contact_try, try)
      if (try%settled .and. allocated(effects%contact) .and. .not. state%contacts%outside > 0) then
        beyond = outran(system, state, share, d)
        if (beyond(3) > 1) then
          try%settled = .false.
          call blame_fastest('a vertex leapt over what is near it, or turned too far', 'a smaller step.least')
        else if (maxval(beyond(:2)) > 0) then
          state%contacts%margin = state%contacts%margin + 2*beyond(1)
          state%contacts%swing = state%contacts%swing + 2*beyond(2)
          call count_work()
          cycle
        end if
      end if
      shorter = merge(shorter_cut, cut, settings%chooses_step)
      if (try%settled .and. settings%most_travel < huge(1.0_dp)) call keep_near()
      if (try%settled .and. allocated(effects%contact)) call keep_apart()
      d_motion = d
      if (try%settled .and. allocated(effects%contact)) call rebound()
      call count_work()
      if (try%settled) exit
      report%rejected = report%rejected + 1
      report%dt = shorter*report%dt
      if (report%dt < settings%least_step) then
        call fail(error, status_run_failed, words_of(try%trouble, system, 'the step size fell below step.least, '// &
                                                     rounded_text(settings%least_step)))
        return
      end if
      if (stop_signal() > 0) return
    end do
    report%iterations = try%iterations
    report%work = work_of_loads(system, effects, share, state, rule, d) &
                  + work_of_supports(system, effects, share, state, rule, d)
    report%damped = loss_by_damping(system, effects, share, rule, d)
    if (allocated(effects%contact)) then
      call accept_contacts(system, effects%contact, d, contact_try, state%contacts)
      if (effects%contact%adapts) call adapt_stiffness([state%contacts%gap, state%contacts%penetration], effects%contact)
    end if
    call update_state(system, effects, share, rule, d, d_motion, state)
    b = lost_block(system, state)
    if (b > 0) then
      call fail(error, status_run_failed, words_of(new_trouble( &
        'it is lost: crushed to nothing, or so far away that 16 digits do not tell its shape', &
        element=findloc(system%elements%block, b, 1), advice='a smaller step.size, and check density, E and loads', &
        position=state%vertex(:, first_vertex_of(system%elements%shape, findloc(system%elements%block, b, 1)))), system))
      return
    end if
    do e = 1, system%n_elements
      share(e) = cache_of_element(effects, system, state, e)
    end do

  contains

    !> Adds what a try took.
    subroutine count_work()
      report%solves = report%solves + try%solves
      if (allocated(try%judged)) report%judged = reshape([report%judged, try%judged], [4, size(report%judged, 2) &
                                                                                          + size(try%judged, 2)])
    end subroutine count_work

    !> Rejects a try in which a vertex goes too far.
    subroutine keep_near()
      real(dp) :: ratio
      integer :: e

      report%travel = farthest(system, share, state, d, e)
      ratio = report%travel/settings%most_travel
      if (ratio <= merge(leeway, 1.0_dp, settings%chooses_step)) return
      try%settled = .false.
      call blame_fastest('a vertex went farther than step.travel lets it', 'a larger step.travel or a smaller step.least')
      if (settings%chooses_step) shorter = 1/sqrt(ratio)
    end subroutine keep_near

    !> Says that the element with the vertex that goes farthest has outrun what a step may do.
    subroutine blame_fastest(what, advice)
      character(len=*), intent(in) :: what, advice

      try%trouble = new_trouble(what, advice=advice)
      report%travel = farthest(system, share, state, d, try%trouble%element)
      try%trouble%position = share(try%trouble%element)%kinematics%centroid
    end subroutine blame_fastest

    !> Rejects a try with contacts that overlap too much, and makes their springs stiffer, where these adapt.
    subroutine keep_apart()
      real(dp) :: apart(2)

      if (.not. effects%contact%adapts .or. stiffened == most_stiffenings) return
      apart = farthest_apart(system, contact_try, d)
      if (apart(2) <= too_deep*effects%contact%allowed_penetration) return
      call adapt_stiffness(apart, effects%contact)
      effects%contact%normal_stiffness = stiffening*effects%contact%normal_stiffness
      effects%contact%shear_stiffness = stiffening*effects%contact%shear_stiffness
      stiffened = stiffened + 1
      shorter = 1.0_dp
      try%settled = .false.
      try%trouble = new_trouble('contacts overlapped too much', advice='a larger contact.stiffness')
    end subroutine keep_apart

    !> Finds the displacement whose velocities the contacts give back, where the scene asks for restitution.
    !>
    !> An element that takes an impact as a rigid body keeps the stress that the step gave it. What the step began with is put
    !> back.
    subroutine rebound()
      type(contact_try_t) :: impact
      type(contact_law_t) :: law
      real(dp) :: stress(3, size(share)), elasticity(3, 3, size(share)), theta(4)
      integer :: e

      if (effects%contact%restitution < 0 .or. all(contact_try%count(2:) == 0)) return
      law = effects%contact
      stress = state%stress
      do e = 1, system%n_elements
        elasticity(:, :, e) = share(e)%elasticity
        if (.not. system%elements%alone(e)) cycle
        theta = matmul(share(e)%kinematics%gradient, d(system%elements%unknown(:, e)))
        state%stress(:, e) = stress(:, e) + rule%stress_weight*matmul(elasticity(:, :, e), &
          merge(green_strain(theta), small_strain(theta), effects%large_deformation))
        share(e)%elasticity = 0.0_dp
      end do
      call rebound_contacts(system, share, d, rule%operator_weight, &
                            still_displacement(rule, state%velocity, state%acceleration), state%velocity, &
                            rule%displacement_weight*rule%dt/rule%velocity_weight, contact_try, effects%contact, impact)
      call settle_deformation(system, effects, settings, state, share, rule, equations, d_motion, impact, try)
      effects%contact = law
      state%stress = stress
      do e = 1, system%n_elements
        share(e)%elasticity = elasticity(:, :, e)
      end do
    end subroutine rebound

  end subroutine advance

  !> First block that is lost: without area, its elements taken together, or farther away than its digits reach; 0: none.
  pure integer function lost_block(system, state) result(b)
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    real(dp) :: area(system%n_blocks), high(2, system%n_blocks), low(2, system%n_blocks)
    integer :: e, loop

    area = 0.0_dp
    low = huge(low)
    high = -huge(high)
    associate (shape => system%elements%shape, block => system%elements%block)
      do e = 1, system%n_elements
        do loop = shape%first_loop(e), shape%first_loop(e + 1) - 1
          associate (vertex => state%vertex(:, shape%first_vertex(loop):shape%first_vertex(loop + 1) - 1))
            area(block(e)) = area(block(e)) + twice_area(vertex)
            low(:, block(e)) = min(low(:, block(e)), minval(vertex, 2))
            high(:, block(e)) = max(high(:, block(e)), maxval(vertex, 2))
          end associate
        end do
      end do
    end associate
    b = findloc(area > 0 .and. maxval(high - low, 1) > least_size*maxval(max(abs(low), abs(high)), 1), .false., 1)
  end function lost_block

  !> Farthest that a vertex goes, and its element.
  real(dp) function farthest(system, share, state, d, element)
    type(system_t), intent(in) :: system
    type(element_cache_t), intent(in) :: share(:)    !! (n_elements)
    type(state_t), intent(in) :: state               !! at the beginning of the step
    real(dp), intent(in) :: d(:)                     !! (n_unknowns)
    integer, intent(out) :: element
    real(dp) :: way
    integer :: e, i

    farthest = 0.0_dp
    element = 1
    do e = 1, system%n_elements
      do i = first_vertex_of(system%elements%shape, e), last_vertex_of(system%elements%shape, e)
        way = norm2(matmul(displacement_matrix(share(e)%kinematics, state%vertex(:, i)), d(system%elements%unknown(:, e))))
        if (way <= farthest) cycle
        farthest = way
        element = e
      end do
    end do
  end function farthest

  !> Finds the contacts of a step, and groups the equations by them.
  subroutine detect(system, share, dt, equations, state)
    type(system_t), intent(in) :: system
    type(element_cache_t), intent(in) :: share(:)
    real(dp), intent(in) :: dt
    type(equations_t), intent(inout) :: equations
    type(state_t), intent(inout) :: state

    call find_contacts(system%outlines, state%vertex, at_outlines(system, state, share, state%velocity), dt, &
                       system%n_elements > system%n_blocks, state%contacts)
    call link_elements(system%elements, state%contacts%link, equations)
  end subroutine detect

  !> Covers that follow others, and exact fixed points, as constraints on the unknowns of a step that ends at `time`.
  pure subroutine constraints_of_step(system, effects, share, state, time, constraints, error)
    type(system_t), intent(in) :: system
    type(effects_t), intent(in) :: effects
    type(element_cache_t), intent(in) :: share(:)
    type(state_t), intent(in) :: state
    real(dp), intent(in) :: time
    type(constraints_t), intent(out) :: constraints
    type(error_t), allocatable, intent(out) :: error
    integer :: e

    call clear_constraints(constraints, system%n_unknowns)
    if (allocated(system%extension)) then
      associate (x => system%extension)
        call add_followers(constraints, [2*x%cover - 1, 2*x%cover], reshape([2*x%master - 1, 2*x%master], [3, 2*size(x%cover)]), &
                           reshape([x%weight, x%weight], [3, 2*size(x%cover)]))
      end associate
    end if
    if (.not. allocated(effects%fixed_point)) return
    if (effects%fixed_point%by_springs) return
    do e = 1, system%n_elements
      call constrain_fixed_points(effects%fixed_point, e, state%point, time, share(e)%kinematics, &
                                  system%elements%unknown(:, e), constraints, error)
      if (.not. allocated(error)) cycle
      error%message = words_of(new_trouble(error%message, element=e, position=share(e)%kinematics%centroid, &
                                         advice='one table of displacement for fixed points of one block'), system)
      return
    end do
  end subroutine constraints_of_step

end module scree_time_stepper
