!> Contact that gives back in a step all that it takes.
!>
!> A contact presses with the mean force of a spring along the straight path of the gaps in the step. Of two entrances, each presses
!> on the part of the path on which its gap is the larger (doc/theory/contact-laws.md, eq-conserving). The contact slides by
!> Coulomb's rules.
module scree_conserving_contact
  use scree_contact_quantities, only: contact_force_t, entrance_start_t, gap_and_slip_t
  use scree_contacts, only: contact_law_t, contact_t, state_open
  use scree_coulomb_contact, only: act_on, judge_closed, set_state
  use scree_kinds, only: dp
  implicit none
  private
  public :: deepest_gap, inherit_overlap, judge_conserving, press_conserving, spring_of_conserving

  !> The stiffness of a mean force is up to half that of the spring. Below this ratio it hardly resembles a spring.
  real(dp), parameter :: like_a_spring = 0.1_dp

contains

  !> Forces across the entrances of a contact: the stiffness times the mean overlap along a straight path of the gaps. Each entrance
  !> counts while its gap is the larger.
  pure subroutine press_conserving(stiffness, n_entrances, start, now, force)
    real(dp), intent(in) :: stiffness              !! force/length
    integer, intent(in) :: n_entrances
    type(entrance_start_t), intent(in) :: start(2)
    type(gap_and_slip_t), intent(in) :: now(2)
    type(contact_force_t), intent(out) :: force
    real(dp) :: ahead(2), turn, depth
    integer :: k

    turn = 0.0_dp ! share of the way on which the entrance that is ahead at the end is not
    ahead = 0.0_dp
    k = 1
    if (n_entrances == 2) then
      if (now(2)%gap > now(1)%gap) k = 2
      ahead = [start(k)%gap - start(3 - k)%gap, now(k)%gap - now(3 - k)%gap]
      if (ahead(1) < 0) turn = ahead(1)/(ahead(1) - ahead(2))
    end if
    call mean_depth(start(k)%gap, now(k)%gap, turn, 1.0_dp, force%across(k), force%across_by_gap(k, k))
    if (turn > 0) then
      call mean_depth(start(3 - k)%gap, now(3 - k)%gap, 0.0_dp, turn, force%across(3 - k), force%across_by_gap(3 - k, 3 - k))
      depth = -(start(k)%gap + turn*(now(k)%gap - start(k)%gap))
      if (depth > 0) then
        depth = -depth*ahead(1)/(ahead(1) - ahead(2))**2 ! times what the turn changes by with the gaps
        force%across_by_gap(:, k) = force%across_by_gap(:, k) + merge(depth, -depth, [1, 2] == k)
        force%across_by_gap(:, 3 - k) = force%across_by_gap(:, 3 - k) - merge(depth, -depth, [1, 2] == k)
      end if
    end if
    force%across = stiffness*force%across
    force%across_by_gap = stiffness*force%across_by_gap
  end subroutine press_conserving

  !> Force and stiffness of entrance k as those of a spring that only presses. They are those at these gaps if the stiffness there
  !> resembles that of a spring, and otherwise those of a gap that was crossed when the step began.
  pure subroutine spring_of_conserving(stiffness, n_entrances, k, start, now, pressing, yielding)
    real(dp), intent(in) :: stiffness              !! force/length
    integer, intent(in) :: n_entrances, k
    type(entrance_start_t), intent(in) :: start(2)
    type(gap_and_slip_t), intent(in) :: now(2)
    real(dp), intent(out) :: pressing              !! force
    real(dp), intent(out) :: yielding              !! force/length
    type(contact_force_t) :: force

    call press_conserving(stiffness, n_entrances, start, now, force)
    pressing = sum(force%across)
    yielding = -force%across_by_gap(k, k)
    if (yielding > like_a_spring*stiffness) return
    pressing = -0.5_dp*stiffness*(now(k)%gap + min(start(k)%gap, 0.0_dp))
    yielding = 0.5_dp*stiffness
  end subroutine spring_of_conserving

  !> Part of the mean overlap that an entrance adds between two fractions of a straight path of its gap, and its derivative with
  !> respect to the gap at the end.
  pure subroutine mean_depth(start_gap, gap, first, last, mean, change)
    real(dp), intent(in) :: start_gap, gap !! length
    real(dp), intent(in) :: first, last
    real(dp), intent(out) :: mean, change
    real(dp) :: from, to

    mean = 0.0_dp
    change = 0.0_dp
    if (min(start_gap, gap) >= 0) return
    from = first
    to = last
    if (start_gap > 0) from = max(from, start_gap/(start_gap - gap))
    if (gap > 0) to = min(to, start_gap/(start_gap - gap))
    if (to <= from) return
    mean = -(to - from)*(start_gap + 0.5_dp*(from + to)*(gap - start_gap))
    change = -(to - from)*(0.5_dp*(from + to))
  end subroutine mean_depth

  !> Lets a contact begin with the energy of the one whose place it takes: the springs of its entrances rest so that the larger of
  !> the overlaps' gaps is the same.
  pure subroutine inherit_overlap(contact, gap)
    type(contact_t), intent(inout) :: contact
    real(dp), intent(inout) :: gap(2) !! of its entrances from where their springs rest, length
    real(dp) :: inherited, shift
    integer :: k, largest

    if (contact%inherits < 0) return
    inherited = min(-contact%inherits, 0.0_dp)
    largest = maxloc(gap(:contact%n_entrances), 1)
    if (gap(largest) >= 0 .and. inherited >= 0) return
    do k = 1, contact%n_entrances
      shift = gap(k) - inherited
      if (k /= largest) shift = max(shift, 0.0_dp)
      contact%entrance(k)%rest = contact%entrance(k)%rest + shift
      gap(k) = gap(k) - shift
    end do
    contact%inherits = -1.0_dp
  end subroutine inherit_overlap

  !> Judges a contact: it is closed while its entrances press together, on the one that presses more.
  pure subroutine judge_conserving(law, lines_stay, start, now, force, tolerance, contact, changes)
    type(contact_law_t), intent(in) :: law
    logical, intent(in) :: lines_stay      !! the entrance that acts, and its anchor
    type(entrance_start_t), intent(in) :: start(2)
    type(gap_and_slip_t), intent(in) :: now(2)
    type(contact_force_t), intent(in) :: force
    real(dp), intent(in) :: tolerance      !! force that changes no state
    type(contact_t), intent(inout) :: contact
    integer, intent(inout) :: changes      !! of states, counted on
    real(dp) :: pressing
    integer :: k, state

    k = 1
    if (contact%n_entrances == 2) then
      k = maxloc(force%across, 1)
      if (abs(force%across(2) - force%across(1)) <= tolerance .or. lines_stay) k = contact%active
    end if
    pressing = sum(force%across)
    call act_on(k, contact, changes)
    state = state_open
    if (pressing > 0) call judge_closed(law, lines_stay, start(k), now(k), pressing, tolerance, contact%entrance(k), state)
    call set_state(state, abs(pressing) > tolerance, contact%entrance(k), changes)
  end subroutine judge_conserving

  !> Gap whose spring holds the energy of a closed contact: the larger of its entrances', while they overlap.
  pure real(dp) function deepest_gap(n_entrances, now)
    integer, intent(in) :: n_entrances
    type(gap_and_slip_t), intent(in) :: now(2)

    deepest_gap = maxval(now(:n_entrances)%gap)
  end function deepest_gap

end module scree_conserving_contact
