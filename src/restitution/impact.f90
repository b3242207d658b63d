!> Impacts with restitution: the velocities at the end of a step are found for themselves. No closed contact approaches, and one
!> that came with the velocity v leaves with e v (Moreau 1988).
module scree_impact
  use scree_contact_quantities, only: contact_force_t
  use scree_contact_rules, only: gaps_and_slips, press_across
  use scree_contact_try, only: contact_try_t, of_elements
  use scree_contacts, only: rules_coulomb, state_open
  use scree_element_term, only: add_force, step_rule_t, term_t
  use scree_green_strain, only: green_strain, strain_operator
  use scree_integrator, only: still_displacement
  use scree_kinds, only: dp
  use scree_model, only: cache_t, element_cache_t, model_t
  use scree_state, only: state_t
  use scree_stiffness, only: small_strain
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: element_in_impact, keep_rigid, rebound_contacts

  integer, parameter :: n = 2*element_unknowns

  !> Stiffness against inertia of a body that takes an impact as a rigid one.
  real(dp), parameter :: rigid = 1e5_dp
  !> Stiffness against inertia of the contacts then.
  real(dp), parameter :: unyielding = 1e3_dp
  !> Share of the fastest approach, or its square of the velocities, that velocities after an impact may be wrong by.
  real(dp), parameter :: unmet = 1e-6_dp

contains

  !> The contacts that the velocities at the end of the step obey. These velocities follow from a displacement of their own; in it
  !> every contact that takes part is to leave with a share of the velocity with which it came.
  !>
  !> An impact counts at the end of the step that is nearer in time: what meets in the second half of a step takes part in the next.
  !> What touched at the beginning takes part too, whether it opens or not, as it bears until the impact that lifts it.
  subroutine rebound_contacts(model, cache, state, rule, d, try, rebound)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state        !! at the beginning of the step
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: d(:)              !! (n_unknowns) of the step
    type(contact_try_t), intent(in) :: try
    type(contact_try_t), intent(out) :: rebound
    real(dp) :: time    !! displacement that a unit of velocity makes
    real(dp) :: fastest !! approach, length/time
    integer :: i

    time = rule%displacement_weight*rule%dt/rule%velocity_weight
    rebound%law = try%law
    rebound%contact = try%contact
    rebound%pair = try%pair
    rebound%geometry = try%geometry
    allocate (rebound%start(2, size(try%contact)))
    rebound%start%closed = .true.
    rebound%reference = still_displacement(rule, state%velocity, state%acceleration)
    rebound%moved = merge(0.0_dp, d, try%linear)
    rebound%weight = rule%operator_weight
    fastest = 0.0_dp
    do i = 1, size(try%contact)
      call enter_impact(i)
    end do
    call stiffen_elements(model, cache, state, rule, d, time, rebound)
    rebound%law%rules = rules_coulomb
    rebound%law%normal_stiffness = unyielding*maxval(cache%element%mass)/time**2
    rebound%law%shear_stiffness = rebound%law%normal_stiffness
    do i = 1, size(rebound%contact)
      rebound%contact(i)%entrance(1)%stiffness = rebound%law%normal_stiffness
    end do
    rebound%law%penetration = unmet*time*fastest
    if (rebound%law%penetration <= 0) rebound%law%penetration = huge(time)

  contains

    !> Lets contact i take part, with the gap that leaves it the velocity it is to have, or opens it.
    !>
    !> Multipliers are to leave an error of the velocities below the share `unmet` of the fastest approach, of what meets or would
    !> without the forces of the step: at rest there is no other measure.
    subroutine enter_impact(i)
      integer, intent(in) :: i
      type(contact_force_t) :: force
      real(dp) :: approach, v(n)
      integer :: k

      k = entrance_in_impact(i)
      associate (contact => rebound%contact(i), geometry => rebound%geometry(1, i))
        contact%entrance(1) = contact%entrance(max(k, 1))
        contact%n_entrances = 1
        contact%active = 1
        contact%entrance(1)%anchor = 0.0_dp
        contact%entrance(1)%multiplier = 0.0_dp
        geometry = try%geometry(max(k, 1), i)
        geometry%along = 0.0_dp
        geometry%slid = 0.0_dp
        if (k == 0) then
          contact%entrance(1)%state = state_open
          geometry%gap = sqrt(huge(1.0_dp)) ! its force is a number still
          return
        end if
        v = of_elements(model, try%pair(:, contact%entrance(1)%pair), state%velocity)
        approach = dot_product(geometry%normal, v)
        fastest = max(fastest, unmet*sum(abs(geometry%shear*v)), unmet*sum(abs(geometry%normal*v)), -approach)
        geometry%gap = try%law%restitution*time*min(approach, 0.0_dp)
        force = press_across(try, i, gaps_and_slips(model, try, i, d))
        fastest = max(fastest, time*force%across(k)*sum(1/cache%element(try%pair(:, contact%entrance(1)%pair))%mass))
      end associate
    end subroutine enter_impact

    !> The entrance of a contact that takes part, 0 where none does.
    pure integer function entrance_in_impact(i) result(k)
      integer, intent(in) :: i
      real(dp) :: approach
      logical :: late

      associate (contact => try%contact(i))
        k = contact%active
        approach = dot_product(try%geometry(k, i)%normal, of_elements(model, try%pair(:, contact%entrance(k)%pair), state%velocity))
        late = .not. try%start(k, i)%closed .and. approach < 0 .and. try%start(k, i)%gap > -time*approach
        if (contact%entrance(k)%state == state_open .or. late) k = findloc(try%start(:contact%n_entrances, i)%closed, .true., 1)
      end associate
    end function entrance_in_impact

  end subroutine rebound_contacts

  !> Makes elements that share no unknown rigid, as the coefficient of restitution is a notion of rigid bodies.
  pure subroutine stiffen_elements(model, cache, state, rule, d, time, rebound)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state        !! at the beginning of the step
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: d(:)              !! (n_unknowns) of the step
    real(dp), intent(in) :: time              !! displacement that a unit of velocity makes
    type(contact_try_t), intent(inout) :: rebound
    real(dp) :: theta(4)
    integer :: e

    allocate (rebound%rigidity(model%n_elements))
    allocate (rebound%stress(3, model%n_elements))
    do e = 1, model%n_elements
      rebound%rigidity(e) = merge(rigid*cache%element(e)%mass/time**2, 0.0_dp, model%elements%alone(e))
      theta = matmul(cache%element(e)%kinematics%gradient, d(model%elements%unknown(:, e)))
      rebound%stress(:, e) = state%stress(:, e) + rule%stress_weight*matmul(cache%element(e)%elasticity, &
        merge(green_strain(theta), small_strain(theta), model%effects%large_deformation))
    end do
  end subroutine stiffen_elements

  !> An element in an impact: one that shares no unknown keeps the stress that the step gave it.
  pure function element_in_impact(model, cache, try, e) result(own)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: e
    type(element_cache_t) :: own

    own = cache%element(e)
    if (.not. model%elements%alone(e)) return
    own%stress = try%stress(:, e)
    own%elasticity = 0.0_dp
  end function element_in_impact

  !> Adds what keeps an element from deforming in an impact.
  !>
  !> What is resisted is the strain rate of the displaced element, F^T L F, which is zero for any rigid motion of it; the
  !> forces have no torque about the places where those of the contacts act.
  pure subroutine keep_rigid(model, cache, try, e, d, term)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: e
    real(dp), intent(in) :: d(:)                  !! (n_unknowns)
    type(term_t), intent(inout) :: term
    real(dp) :: theta(4), matrix(element_unknowns, element_unknowns)

    associate (ids => model%elements%unknown(:, e), G => cache%element(e)%kinematics%gradient)
      theta = matmul(G, try%moved(ids))
      matrix = try%rigidity(e)*cache%element(e)%kinematics%area*matmul(transpose(matmul(strain_operator(theta, try%weight), G)), &
                                                              matmul(strain_operator(theta, 1.0_dp), G))
      call add_force(term, -matmul(matrix, d(ids) - try%reference(ids)))
    end associate
    term%matrix = term%matrix + matrix
    term%symmetric = term%symmetric .and. all(abs(theta) <= 0.0_dp)
  end subroutine keep_rigid

end module scree_impact
