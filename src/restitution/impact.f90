!> Impacts with restitution: the velocities at the end of a step are found for themselves. No closed contact approaches, and one
!> that came with the velocity v leaves with e v (Moreau 1988).
module scree_impact
  use scree_contact_forces, only: pushes
  use scree_contacts, only: contact_law_t, state_open
  use scree_effects, only: element_cache_t
  use scree_element_term, only: add_force, term_t
  use scree_green_strain, only: strain_operator
  use scree_kinds, only: dp
  use scree_system, only: element_unknowns, system_t
  use scree_contact_try, only: gaps_and_slips, of_elements, contact_try_t
  implicit none
  private
  public :: keep_rigid, rebound_contacts

  integer, parameter :: n = 2*element_unknowns

  !> Stiffness against inertia of a body that takes an impact as a rigid one.
  real(dp), parameter :: rigid = 1e5_dp
  !> Stiffness against inertia of the contacts then.
  real(dp), parameter :: unyielding = 1e3_dp
  !> Share of the fastest approach, or its square of the velocities, that velocities after an impact may be wrong by.
  real(dp), parameter :: unmet = 1e-6_dp

contains

  !> The contacts for the velocities at the end of the step: with what displacement `still` they would be at rest, how
  !> fast each one approached, and how much displacement a unit of velocity is.
  !>
  !> An impact counts at the end of the step that is nearer in time: what meets in its second half takes part in the next.
  !> What touched at the beginning takes part too, whether it opens or not: it bears until the impact that lifts it.
  !> Multipliers are to leave an error of the velocities below the share `unmet` of the fastest approach, of what meets or
  !> would without the forces of the step: at rest nothing else is a measure.
  !> The coefficient of restitution is a notion of rigid bodies: one of a single element takes an impact as such.
  pure subroutine rebound_contacts(system, share, d, weight, still, velocity, way, try, law, rebound)
    type(system_t), intent(in) :: system
    type(element_cache_t), intent(in) :: share(:) !! (n_elements)
    real(dp), intent(in) :: d(:)              !! (n_unknowns) of the step
    real(dp), intent(in) :: weight            !! of `d` in the configuration where the forces act
    real(dp), intent(in) :: still(:)          !! (n_unknowns) displacement after which nothing moves
    real(dp), intent(in) :: velocity(:)       !! (n_unknowns) at the beginning of the step
    real(dp), intent(in) :: way               !! time
    type(contact_try_t), intent(in) :: try
    type(contact_law_t), intent(inout) :: law
    type(contact_try_t), intent(out) :: rebound
    real(dp) :: approach, fastest, v(n), both(2, 2), push(3, 2)
    integer :: i, k

    rebound%contact = try%contact
    rebound%link = try%link
    rebound%geometry = try%geometry
    rebound%start_share = 0*try%start_share
    rebound%start_gap = 0*try%start_gap
    allocate (rebound%kept(2, size(try%contact)), source=.true.)
    rebound%reference = still
    rebound%moved = merge(d, 0.0_dp, try%bends)
    rebound%weight = weight
    fastest = 0.0_dp
    do i = 1, size(try%contact)
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
        else
          v = of_elements(system, try%link(:, try%contact(i)%entrance(k)%link), velocity)
          approach = dot_product(geometry%normal, v)
          fastest = max(fastest, unmet*sum(abs(geometry%shear*v)), unmet*sum(abs(geometry%normal*v)), -approach)
          geometry%gap = law%restitution*way*min(approach, 0.0_dp)
          both = gaps_and_slips(system, try, i, d)
          push = pushes(law, try, i, both(1, :))
          fastest = max(fastest, way*push(1, k)*sum(1/share(try%link(:, contact%entrance(1)%link))%mass))
        end if
      end associate
    end do
    allocate (rebound%rigidity(size(share)))
    do i = 1, size(share)
      rebound%rigidity(i) = merge(rigid*share(i)%mass/way**2, 0.0_dp, system%elements%alone(i))
    end do
    law%conserving = .false.
    law%lags = .false.
    law%closing = 0.0_dp
    law%opening = 0.0_dp
    law%normal_stiffness = unyielding*maxval(share%mass)/way**2
    law%shear_stiffness = law%normal_stiffness
    law%penetration = unmet*way*fastest
    if (law%penetration <= 0) law%penetration = huge(law%penetration)

  contains

    !> The line of a contact that takes part, 0 where none does.
    pure integer function entrance_in_impact(i) result(k)
      integer, intent(in) :: i
      real(dp) :: approach
      logical :: late

      associate (contact => try%contact(i))
        k = contact%active
        approach = dot_product(try%geometry(k, i)%normal, of_elements(system, try%link(:, contact%entrance(k)%link), velocity))
        late = .not. try%kept(k, i) .and. approach < 0 .and. try%start_gap(k, i) > -way*approach
        if (contact%entrance(k)%state == state_open .or. late) k = findloc(try%kept(:contact%n_entrances, i), .true., 1)
      end associate
    end function entrance_in_impact

  end subroutine rebound_contacts

  !> Adds what keeps an element from deforming in an impact.
  !>
  !> What is resisted is the strain rate of the displaced element, F^T L F, which is zero for any rigid motion of it; the
  !> forces have no torque about the places where those of the contacts act.
  pure subroutine keep_rigid(system, try, e, share, d, term)
    type(system_t), intent(in) :: system
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: e
    type(element_cache_t), intent(in) :: share
    real(dp), intent(in) :: d(:)                  !! (n_unknowns)
    type(term_t), intent(inout) :: term
    real(dp) :: theta(4), matrix(element_unknowns, element_unknowns)

    associate (ids => system%elements%unknown(:, e), G => share%kinematics%gradient)
      theta = matmul(G, try%moved(ids))
      matrix = try%rigidity(e)*share%kinematics%area*matmul(transpose(matmul(strain_operator(theta, try%weight), G)), &
                                                              matmul(strain_operator(theta, 1.0_dp), G))
      call add_force(term, -matmul(matrix, d(ids) - try%reference(ids)))
    end associate
    term%matrix = term%matrix + matrix
  end subroutine keep_rigid

end module scree_impact
