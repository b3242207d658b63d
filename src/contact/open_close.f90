!> The open-close iteration: which contacts are open, sliding or locked, and what their springs add to the equations
!> (Shi's df07, df18, df22).
!>
!> A closed contact is a spring p across its line and, locked, a spring k along it that holds the vertex at its anchor:
!>
!>     N = h - p g                   pressing where positive
!>     T = h' - k s                  s: slip from the anchor, a share of the edge
!>     |T| <= N tan phi + c l        else the contact slides: T = -+(N tan phi + c l), and the anchor follows
!>
!> Every iteration solves for the states of the one before and then judges all states anew (a semi-smooth Newton iteration).
!> A contact slides with the normal force of the same solution. Nothing is kept but by `accept_contacts`. A law that lags is
!> Shi's: a contact slides with the friction of the iteration before, from where it was when the step began.
!>
!> - The forces h and h' are zero but with multipliers (augmented Lagrangian): they follow N and T until no overlap above a
!>   bound is left.
!> - With viscosity c, N = h - p g - c (change of the overlap in the step)/dt.
!> - A conserving contact presses with what does the work that the energy of its spring changes by in the step: the mean of
!>   the spring's force over the way from the gaps at the beginning to those at the end, each line of two for the part of the
!>   way on which its gap is the larger (doc/theory.md).
!> - With restitution the velocities at the end of a step are found for themselves: no closed contact approaches, and one
!>   that came with the velocity v leaves with e v (Moreau 1988).
module scree_open_close
  use scree_contact_geometry, only: add_edge, anchored_rows, frame_of_edge, geometry_of, line_geometry_t
  use scree_contacts, only: contact_law_t, contact_t, contacts_t, line_t, outlines_t, state_locked, state_open, state_sliding
  use scree_effects, only: element_share_t
  use scree_element_term, only: add_force, step_rule_t, term_t
  use scree_equations, only: add_link_equations, equations_t
  use scree_green_strain, only: strain_operator
  use scree_interpolation, only: displacement_matrix
  use scree_kinds, only: dp
  use scree_system, only: element_unknowns, state_t, system_t
  implicit none
  private
  public :: accept_contacts, add_contacts, begin_again, begin_contacts, farthest_apart, hold_contacts, judge_contacts, keep_firm, &
            outran, place_contacts, rebound_contacts, slides_with_friction, touch_t

  integer, parameter :: n = 2*element_unknowns

  !> A force below this share of the largest contact force changes no state.
  real(dp), parameter :: faint = 1e-8_dp
  !> A gap below this share of the edge is round-off.
  real(dp), parameter :: round_off = 2e-15_dp
  !> Stiffness against inertia of a body that takes an impact as a rigid one.
  real(dp), parameter :: rigid = 1e5_dp
  !> Stiffness against inertia of the contacts then.
  real(dp), parameter :: unyielding = 1e3_dp
  !> Share of the fastest approach, or its square of the velocities, that velocities after an impact may be wrong by.
  real(dp), parameter :: unmet = 1e-6_dp
  !> Edges whose directions differ by less are parallel, rad (Shi: h1).
  real(dp), parameter :: parallel = 3*acos(-1.0_dp)/180
  !> Friction up to which a slider that turns back does not lock, where it lags (Shi: 0.9 degrees).
  real(dp), parameter :: smooth = tan(0.9_dp*acos(-1.0_dp)/180)

  !> The contacts in the iteration of one step.
  type :: touch_t
    type(contact_t), allocatable :: contact(:)
    integer, allocatable :: link(:, :)                   !! (2, n_links) pairs of elements
    type(line_geometry_t), allocatable :: geometry(:, :) !! (2, n)
    real(dp), allocatable :: start_gap(:, :)             !! (2, n) at the beginning of the step, length
    real(dp), allocatable :: start_share(:, :)           !! (2, n) along the edge then
    logical, allocatable :: kept(:, :)                   !! (2, n) closed then: the anchor stays
    real(dp) :: dashpot = 0.0_dp                         !! viscosity over the size of the step, force/length
    logical :: bends = .false.                           !! the geometry follows the motion, else it is linear
    logical :: anchored = .false.                        !! slip is measured from the anchor, linear in displacements (Shi)
    real(dp), allocatable :: reference(:)                !! (n_unknowns) displacement that the geometry is of
    real(dp), allocatable :: firmness(:)                 !! (n_elements) in an impact: against deforming, force/length
    real(dp), allocatable :: moved(:)                    !! (n_unknowns) displacement to the impact; 0 with small strain
    real(dp) :: weight = 1.0_dp                          !! of it in the configuration where forces act
    integer :: count(3) = 0                              !! contacts open, sliding, locked
    integer :: changes = 0                               !! of states, in the last judgement
  end type touch_t

contains

  !> The contacts as the step finds them. Those of the first step are bonded where their joint has cohesion or strength.
  pure subroutine begin_contacts(system, law, state, share, bends, rule, touch)
    type(system_t), intent(in) :: system
    type(contact_law_t), intent(in) :: law
    type(state_t), intent(in) :: state
    type(element_share_t), intent(in) :: share(:) !! (n_elements)
    logical, intent(in) :: bends                  !! the geometry follows the motion
    type(step_rule_t), intent(in) :: rule
    type(touch_t), intent(out) :: touch
    integer :: i, k, m

    touch%contact = state%contacts%contact
    touch%link = state%contacts%link
    touch%bends = bends
    touch%anchored = law%lags .and. .not. bends
    touch%dashpot = law%viscosity/rule%dt
    m = size(touch%contact)
    if (state%step == 0) then
      do i = 1, m
        do k = 1, touch%contact(i)%n_lines
          associate (line => touch%contact(i)%line(k))
            associate (joint => system%outlines%joint(line%edge))
              if (law%cohesion(joint) > 0 .or. law%strength(joint) > 0) &
                line%length = length_of_contact(system%outlines, state%vertex, line)
            end associate
            line%bonded = line%length > 0
          end associate
        end do
      end do
    end if
    allocate (touch%geometry(2, m), touch%kept(2, m))
    allocate (touch%reference(system%n_unknowns), source=0.0_dp)
    call place_contacts(system, state, share, rule%operator_weight, touch%reference, touch)
    touch%start_gap = touch%geometry%gap
    touch%start_share = touch%geometry%along/touch%geometry%edge_length
    if (state%step == 0) call close_touching(law%touching, touch)
    do i = 1, m
      associate (contact => touch%contact(i))
        if (contact%n_lines == 2 .and. .not. law%lags) then
          if (touch%start_gap(3 - contact%active, i) > 0) contact%line(contact%active)%state = state_open ! it slipped off
        end if
        touch%kept(:, i) = contact%line%state /= state_open
      end associate
    end do

  end subroutine begin_contacts

  !> Closes contacts with a gap up to `touching`.
  pure subroutine close_touching(touching, touch)
    real(dp), intent(in) :: touching !! length
    type(touch_t), intent(inout) :: touch
    integer :: i, k

    do i = 1, size(touch%contact)
      k = maxloc(touch%start_gap(:touch%contact(i)%n_lines, i), 1)
      if (touch%start_gap(k, i) > touching) cycle
      touch%contact(i)%active = k
      touch%contact(i)%line(k)%state = merge(state_sliding, state_locked, touch%anchored .and. touch%contact(i)%n_lines == 2)
    end do
  end subroutine close_touching

  !> The contacts of a step that is tried again, as Shi's programs leave them: in the states of the last judgement.
  pure subroutine begin_again(law, rule, touch)
    type(contact_law_t), intent(in) :: law
    type(step_rule_t), intent(in) :: rule
    type(touch_t), intent(inout) :: touch
    integer :: k

    touch%dashpot = law%viscosity/rule%dt
    do k = 1, 2
      touch%contact%line(k)%drag = 0.0_dp
    end do
  end subroutine begin_again

  !> Length of the joint that a contact stands for: half of what its edge and each parallel one at the vertex have in common.
  pure real(dp) function length_of_contact(outlines, place, line) result(length)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: place(:, :)     !! (2, n_vertices), length
    type(line_t), intent(in) :: line
    real(dp) :: t(2), normal(2), own(2), other, at, ends(2)
    integer :: edge, i

    call frame_of_edge(place(:, outlines%start(line%edge)), place(:, outlines%finish(line%edge)), t, normal, other)
    length = 0.0_dp
    do i = 1, 2
      edge = merge(line%vertex, outlines%previous(line%vertex), i == 1)
      own = place(:, outlines%finish(edge)) - place(:, outlines%start(edge))
      if (dot_product(own, t) > -cos(parallel)*norm2(own)) cycle
      at = dot_product(t, place(:, outlines%start(edge)) - place(:, outlines%start(line%edge)))
      ends = [at + dot_product(t, own), at]
      length = length + 0.5_dp*max(0.0_dp, min(other, ends(2)) - max(0.0_dp, ends(1)))
    end do
  end function length_of_contact

  !> Geometry of all contacts at a displacement.
  pure subroutine place_contacts(system, state, share, weight, d, touch)
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    type(element_share_t), intent(in) :: share(:) !! (n_elements)
    real(dp), intent(in) :: weight                !! of `d` in the configuration where the forces act
    real(dp), intent(in) :: d(:)                  !! (n_unknowns)
    type(touch_t), intent(inout) :: touch
    integer :: i, k

    do i = 1, size(touch%contact)
      do k = 1, touch%contact(i)%n_lines
        associate (line => touch%contact(i)%line(k))
          touch%geometry(k, i) = geometry_of(system, state, share, system%outlines, touch%link(:, line%link), line, touch%bends, &
                                             weight, d)
          if (touch%anchored) call add_edge(system, state, share, system%outlines, touch%link(:, line%link), line, &
                                            touch%geometry(k, i))
        end associate
      end do
    end do
    touch%reference = d
  end subroutine place_contacts

  !> Gaps and slips of the lines of a contact at `d`.
  pure function gaps_and_slips(system, touch, i, d) result(both)
    type(system_t), intent(in) :: system
    type(touch_t), intent(in) :: touch
    integer, intent(in) :: i
    real(dp), intent(in) :: d(:)
    real(dp) :: both(2, 2) !! of the lines
    integer :: k

    both = 0.0_dp
    do k = 1, touch%contact(i)%n_lines
      both(:, k) = gap_and_slip(system, touch, i, k, d)
    end do
  end function gaps_and_slips

  !> Gap of a line and slip from its anchor at `d`, linear about the reference.
  pure function gap_and_slip(system, touch, i, k, d) result(both)
    type(system_t), intent(in) :: system
    type(touch_t), intent(in) :: touch
    integer, intent(in) :: i, k
    real(dp), intent(in) :: d(:)
    real(dp) :: both(2), change(n), rows(n, 2)

    associate (line => touch%contact(i)%line(k), geometry => touch%geometry(k, i))
      associate (link => touch%link(:, line%link))
        change(:n/2) = d(system%elements%unknown(:, link(1))) - touch%reference(system%elements%unknown(:, link(1)))
        change(n/2 + 1:) = d(system%elements%unknown(:, link(2))) - touch%reference(system%elements%unknown(:, link(2)))
      end associate
      both = [geometry%gap + dot_product(geometry%normal_end, change), &
              geometry%along + dot_product(geometry%shear_end, change) - line%anchor*geometry%edge_length]
      if (.not. touch%anchored) return
      rows = anchored_rows(geometry, line%anchor)
      both(2) = geometry%along + dot_product(rows(:, 2), change) - line%anchor*geometry%edge_length
    end associate
  end function gap_and_slip

  !> Place on the edge, as a share of it, where a vertex meets its line in the step, or is at its beginning where it is inside
  !> then (Shi: df22). No longer linear.
  pure real(dp) function anchor_where_closed(system, touch, i, k, d) result(anchor)
    type(system_t), intent(in) :: system
    type(touch_t), intent(in) :: touch
    integer, intent(in) :: i, k
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    real(dp) :: moved(n), apart(2), edge(2), rows(n, 2), part

    associate (geometry => touch%geometry(k, i), link => touch%link(:, touch%contact(i)%line(k)%link))
      moved = [d(system%elements%unknown(:, link(1))), d(system%elements%unknown(:, link(2)))]
      rows = anchored_rows(geometry, 0.0_dp)
      edge = matmul(geometry%edge(:2, :), moved)
      apart = [dot_product(rows(:, 1), moved), dot_product(geometry%normal, moved) &
                                               + (geometry%along*edge(2) - geometry%gap*edge(1))/geometry%edge_length]
      part = max(geometry%gap, 0.0_dp)/max(geometry%gap, -dot_product(geometry%normal, moved), tiny(part))
      apart = [geometry%along, geometry%gap] + part*apart ! along the edge and across, of the vertex from its start
      edge = [geometry%edge_length, 0.0_dp] + part*edge
      anchor = dot_product(apart, edge)/dot_product(edge, edge)
    end associate
  end function anchor_where_closed

  !> Judges every contact at `d`; `touch%changes` counts states that change by more than a faint force.
  !>
  !> The first judgement, of a prediction, only closes: what was closed is taken to stay as it was.
  pure subroutine judge_contacts(system, law, d, first, touch)
    type(system_t), intent(in) :: system
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    logical, intent(in) :: first
    type(touch_t), intent(inout) :: touch
    real(dp) :: both(2, 2, size(touch%contact)), push(3, 2, size(touch%contact)), pressing, doubt, largest
    integer :: i, k, new

    largest = 0.0_dp
    do i = 1, size(touch%contact)
      associate (contact => touch%contact(i))
        if (touch%anchored) then
          do k = 1, contact%n_lines
            if (contact%line(k)%state == state_open) contact%line(k)%anchor = anchor_where_closed(system, touch, i, k, d)
          end do
        end if
        both(:, :, i) = gaps_and_slips(system, touch, i, d)
        push(:, :, i) = pushes(law, touch%dashpot, contact, touch%start_gap(:, i), both(1, :, i))
        largest = max(largest, minval(push(1, :contact%n_lines, i)), merge(sum(push(1, :, i)), 0.0_dp, law%conserving))
      end associate
    end do
    touch%changes = 0
    touch%count = 0
    do i = 1, size(touch%contact)
      associate (contact => touch%contact(i))
        if (.not. first .or. contact%line(contact%active)%state == state_open) then
          doubt = faint*largest + round_off*touch%geometry(1, i)%edge_length*law%normal_stiffness
          if (law%lags) doubt = 0.0_dp
          k = 1
          if (contact%n_lines == 2) k = acting_line(i, both(1, :, i), push(1, :, i), doubt)
          pressing = merge(sum(push(1, :, i)), push(1, k, i), law%conserving)
          if (k /= contact%active) then
            associate (left => contact%line(contact%active))
              if (law%lags) then ! it stays closed, on the other line, unless the one that it leaves is open (Shi)
                contact%line(k)%state = left%state
                if (left%state /= state_open) pressing = push(1, contact%active, i)
              else if (left%state /= state_open) then
                touch%changes = touch%changes + 1
              end if
              left%state = state_open
            end associate
            contact%active = k
          end if
          associate (line => contact%line(k))
            call judge(i, k, both(:, k, i), pressing, doubt, line, new)
            if (first .and. new /= state_open) new = merge(state_locked, state_sliding, can_lock(line))
            if (min(new, line%state) == state_open) then
              if (new /= line%state .and. abs(pressing) > doubt) touch%changes = touch%changes + 1
            else if (new /= line%state .and. .not. law%lags) then
              touch%changes = touch%changes + 1
            end if
            line%state = new
          end associate
        end if
        associate (state => contact%line(contact%active)%state)
          touch%count(1 + state) = touch%count(1 + state) + 1
        end associate
      end associate
    end do

  contains

    !> Which of the two lines of a corner acts: the one that is crossed least, or was crossed last.
    !>
    !> What pressed when the step began presses on, as if its edge did not end: a corner that slips off in the step is held to
    !> its end. That it were let go where it leaves the other line would make its force jump, and leave some steps no solution.
    pure integer function acting_line(i, gap, push, doubt) result(k)
      integer, intent(in) :: i
      real(dp), intent(in) :: gap(2), push(2), doubt

      associate (active => touch%contact(i)%active)
        k = 1
        if (law%conserving) then
          k = maxloc(push, 1)
        else if (law%lags) then
          k = maxloc(gap, 1)
        else if (touch%kept(active, i) .and. push(active) > 0) then
          k = active
        else if (minval(push) < 0) then
          if (push(2) < push(1)) k = 2
        else
          k = crossed_last(merge(0.0_dp, touch%start_gap(:, i), touch%kept(:, i)), gap)
        end if
        if (abs(push(2) - push(1)) <= doubt) k = active
      end associate
    end function acting_line

    !> Which of two lines, both crossed at the end of the step, was crossed last: the vertices entered there.
    pure integer function crossed_last(from, to)
      real(dp), intent(in) :: from(2), to(2) !! gaps at the beginning and at the end of the step, length

      if (maxval(from) > 0) then
        crossed_last = maxloc(max(from, 0.0_dp)/(max(from, 0.0_dp) + abs(to) + tiny(to)), 1)
      else
        crossed_last = maxloc(from, 1)
      end if
    end function crossed_last

    !> New state of a line. One that was open at the beginning of the step gets its anchor where it first closes: an anchor
    !> that moved on with every iteration would hold back what it follows, and the iteration creep.
    pure subroutine judge(i, k, both, pressing, doubt, line, state)
      integer, intent(in) :: i, k
      real(dp), intent(in) :: both(2), pressing, doubt
      type(line_t), intent(inout) :: line
      integer, intent(out) :: state
      real(dp) :: along, limit, shear
      logical :: closed, turns

      if (law%conserving) then
        closed = pressing > 0
      else if (line%state == state_open) then
        closed = pressing >= law%normal_stiffness*law%closing
      else
        closed = pressing >= -law%normal_stiffness*law%opening - bond(line, law%strength)
      end if
      state = state_open
      if (.not. closed) return
      associate (start_gap => touch%start_gap(k, i), start => touch%start_share(k, i), length => touch%geometry(k, i)%edge_length)
        shear = line%held(2) - law%shear_stiffness*both(2)
        if (line%state == state_open .and. start_gap > 0 .and. .not. (touch%kept(k, i) .or. line%bonded .or. touch%anchored)) then
          along = both(2) + line%anchor*length
          line%anchor = start + min(1.0_dp, start_gap/max(start_gap - both(1), tiny(start_gap)))*(along/length - start)
          shear = line%held(2) - law%shear_stiffness*(along - line%anchor*length)
        end if
      end associate
      limit = max(0.0_dp, law%friction(system%outlines%joint(line%edge))*pressing + bond(line, law%cohesion))
      turns = limit > 0
      if (law%lags) then ! two corners have no friction; what closes compares gap and slip, and is not bonded (Shi: df22)
        associate (friction => merge(law%friction(system%outlines%joint(line%edge)), 0.0_dp, touch%contact(i)%n_lines == 1))
          turns = friction > smooth
          limit = friction*max(0.0_dp, pressing)
        end associate
        if (line%state == state_open) then
          shear = -law%normal_stiffness*both(2)
        else if (touch%contact(i)%n_lines == 1) then
          limit = limit + bond(line, law%cohesion)
        end if
      end if
      if (line%state == state_sliding .and. turns .and. line%direction*shear > law%shear_stiffness*law%backlash) then
        state = state_locked ! it turned back; whether it slides there the next iteration tells
      else if (line%state == state_sliding .and. law%lags) then
        state = state_sliding
      else if (line%state /= state_open .and. abs(abs(shear) - limit) <= doubt) then
        state = line%state
      else
        state = merge(state_locked, state_sliding, abs(shear) < limit)
      end if
      if (state == state_sliding) line%direction = sign(1.0_dp, -shear)
      line%drag = merge(0.0_dp, limit, line%state == state_open)
    end subroutine judge

    !> Whether a joint has any shear strength.
    pure logical function can_lock(line)
      type(line_t), intent(in) :: line

      can_lock = law%friction(system%outlines%joint(line%edge)) > 0 .or. bond(line, law%cohesion) > 0
    end function can_lock

    !> Force of a bond: a strength of the joint times the length of the contact.
    pure real(dp) function bond(line, strength)
      type(line_t), intent(in) :: line
      real(dp), intent(in) :: strength(:)

      bond = 0.0_dp
      if (line%bonded) bond = strength(system%outlines%joint(line%edge))*line%length
    end function bond

  end subroutine judge_contacts

  !> Force across each line of a contact, and its changes with the gaps of both lines: (force, d/dg1, d/dg2).
  !>
  !> By spring, multiplier and dashpot, as if the line were closed and the one that acts; or what both share of a contact that
  !> conserves energy.
  pure function pushes(law, dashpot, contact, start_gap, gap) result(push)
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: dashpot              !! force/length
    type(contact_t), intent(in) :: contact
    real(dp), intent(in) :: start_gap(2), gap(2) !! of the lines, length
    real(dp) :: push(3, 2)
    integer :: k

    push = 0.0_dp
    if (law%conserving) then
      push = law%normal_stiffness*mean_depths(contact%n_lines, start_gap, gap)
    else
      do k = 1, contact%n_lines
        push(1, k) = contact%line(k)%held(1) - law%normal_stiffness*gap(k) - dashpot*(gap(k) - min(start_gap(k), 0.0_dp))
        push(1 + k, k) = -law%normal_stiffness - dashpot
      end do
    end if
  end function pushes

  !> Mean overlap of each line over a straight way of the gaps, while its gap is the larger, and its changes with the gaps at the
  !> end: (mean, d/dg1, d/dg2).
  pure function mean_depths(n_lines, start_gap, gap) result(mean)
    integer, intent(in) :: n_lines
    real(dp), intent(in) :: start_gap(2), gap(2) !! length
    real(dp) :: mean(3, 2)
    real(dp) :: ahead(2), turn, depth
    integer :: k

    mean = 0.0_dp
    turn = 0.0_dp ! share of the way on which the line that is ahead at the end is not
    k = 1
    if (n_lines == 2) then
      if (gap(2) > gap(1)) k = 2
      ahead = [start_gap(k) - start_gap(3 - k), gap(k) - gap(3 - k)]
      if (ahead(1) < 0) turn = ahead(1)/(ahead(1) - ahead(2))
    end if
    mean([1, 1 + k], k) = mean_depth(start_gap(k), gap(k), turn, 1.0_dp)
    if (.not. turn > 0) return
    mean([1, 4 - k], 3 - k) = mean_depth(start_gap(3 - k), gap(3 - k), 0.0_dp, turn)
    depth = -(start_gap(k) + turn*(gap(k) - start_gap(k)))
    if (depth <= 0) return
    depth = -depth*ahead(1)/(ahead(1) - ahead(2))**2 ! times what the turn changes by with the gaps
    mean(2:, k) = mean(2:, k) + merge(depth, -depth, [1, 2] == k)
    mean(2:, 3 - k) = mean(2:, 3 - k) - merge(depth, -depth, [1, 2] == k)
  end function mean_depths

  !> What a line adds to the mean overlap between two shares of a straight way of its gap, and its change with the gap at the end.
  pure function mean_depth(start_gap, gap, first, last) result(mean)
    real(dp), intent(in) :: start_gap, gap !! length
    real(dp), intent(in) :: first, last
    real(dp) :: mean(2)
    real(dp) :: from, to

    mean = 0.0_dp
    if (min(start_gap, gap) >= 0) return
    from = first
    to = last
    if (start_gap > 0) from = max(from, start_gap/(start_gap - gap))
    if (gap > 0) to = min(to, start_gap/(start_gap - gap))
    if (to <= from) return
    mean = -(to - from)*[start_gap + 0.5_dp*(from + to)*(gap - start_gap), 0.5_dp*(from + to)]
  end function mean_depth

  !> Whether a contact slides with a force that follows the normal one: the equations are then not symmetric.
  pure logical function slides_with_friction(outlines, law, touch)
    type(outlines_t), intent(in) :: outlines
    type(contact_law_t), intent(in) :: law
    type(touch_t), intent(in) :: touch
    integer :: i

    slides_with_friction = .false.
    if (law%lags) return
    do i = 1, size(touch%contact)
      associate (line => touch%contact(i)%line(touch%contact(i)%active))
        slides_with_friction = slides_with_friction .or. &
          (line%state == state_sliding .and. law%friction(outlines%joint(line%edge)) > 0)
      end associate
    end do
  end function slides_with_friction

  !> Forces of a closed contact: across its first line, across its second, along the one that acts; each with its changes with
  !> the gaps and the slip of that one: (force, d/dg1, d/dg2, d/ds).
  pure function forces(outlines, law, dashpot, contact, start_gap, both) result(force)
    type(outlines_t), intent(in) :: outlines
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: dashpot
    type(contact_t), intent(in) :: contact
    real(dp), intent(in) :: start_gap(2), both(2, 2) !! of the lines
    real(dp) :: force(4, 3)

    force = 0.0_dp
    force(:3, :2) = pushes(law, dashpot, contact, start_gap, both(1, :))
    if (.not. law%conserving) force(:, 3 - contact%active) = 0.0_dp
    associate (line => contact%line(contact%active), slip => both(2, contact%active))
      if (line%state == state_locked) then
        force(:, 3) = [line%held(2) - law%shear_stiffness*slip, 0.0_dp, 0.0_dp, -law%shear_stiffness]
      else if (law%lags) then
        force(1, 3) = -line%direction*line%drag
      else
        associate (joint => outlines%joint(line%edge))
          force(:, 3) = law%friction(joint)*(force(:, 1) + force(:, 2))
          if (line%bonded) force(1, 3) = force(1, 3) + law%cohesion(joint)*line%length
          force(:, 3) = -line%direction*force(:, 3)
          if (line%bonded .and. line%direction*force(1, 3) > 0) force(:, 3) = 0.0_dp ! a bond that is pulled has no friction
        end associate
      end if
    end associate
  end function forces

  !> Adds the springs of all closed contacts at `d`.
  subroutine add_contacts(system, law, d, symmetric, touch, equations)
    type(system_t), intent(in) :: system
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: d(:)          !! (n_unknowns)
    logical, intent(in) :: symmetric      !! operator of the iteration, where the geometry bends
    type(touch_t), intent(in) :: touch
    type(equations_t), intent(inout) :: equations
    real(dp) :: matrix(n, n, size(touch%link, 2)), force(n, size(touch%link, 2)), scale(n, size(touch%link, 2))
    real(dp) :: of(4, 3), change(n), shear(n), shear_end(n), rows(n, 2)
    integer :: i, k, m

    matrix = 0.0_dp
    force = 0.0_dp
    scale = 0.0_dp
    do i = 1, size(touch%contact)
      associate (contact => touch%contact(i), geometry => touch%geometry(:, i), active => touch%contact(i)%active)
        if (contact%line(active)%state == state_open) cycle
        of = forces(system%outlines, law, touch%dashpot, contact, touch%start_gap(:, i), gaps_and_slips(system, touch, i, d))
        shear = geometry(active)%shear
        shear_end = merge(shear, geometry(active)%shear_end, symmetric)
        if (touch%anchored) then
          rows = anchored_rows(geometry(active), contact%line(active)%anchor)
          shear = rows(:, merge(2, 1, contact%line(active)%state == state_locked))
          shear_end = shear
        end if
        do k = 1, contact%n_lines
          associate (link => contact%line(k)%link)
            do m = 1, contact%n_lines
              if (contact%line(m)%link /= link) cycle ! what lines of other elements change by with each other is left out
              change = merge(geometry(m)%normal, geometry(m)%normal_end, symmetric)
              if (abs(of(1 + m, k)) > 0) call add_change(link, geometry(k)%normal, of(1 + m, k)*change)
              if (k == active .and. abs(of(1 + m, 3)) > 0) call add_change(link, shear, of(1 + m, 3)*change)
            end do
            call add_force_across(link, of(1, k)*geometry(k)%normal)
          end associate
        end do
        associate (link => contact%line(active)%link)
          if (abs(of(4, 3)) > 0) call add_change(link, shear, of(4, 3)*shear_end)
          call add_force_across(link, of(1, 3)*shear)
        end associate
      end associate
    end do
    call add_link_equations(equations, matrix, force, scale)

  contains

    !> Adds a force on the elements of a link.
    subroutine add_force_across(link, of_link)
      integer, intent(in) :: link
      real(dp), intent(in) :: of_link(n)

      force(:, link) = force(:, link) + of_link
      scale(:, link) = scale(:, link) + abs(of_link)
    end subroutine add_force_across

    !> Adds what a force along `row` changes by with the unknowns.
    subroutine add_change(link, row, change)
      integer, intent(in) :: link
      real(dp), intent(in) :: row(n), change(n)
      integer :: j

      do j = 1, n
        matrix(:, j, link) = matrix(:, j, link) - change(j)*row
      end do
    end subroutine add_change

  end subroutine add_contacts

  !> Lets multipliers take the forces of closed contacts over, where an overlap or a gap above the bound is left.
  pure subroutine hold_contacts(system, law, d, touch, enough)
    type(system_t), intent(in) :: system
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    type(touch_t), intent(inout) :: touch
    logical, intent(out) :: enough            !! none is left
    real(dp) :: both(2, 2), of(4, 3), pair(2)
    integer :: i

    enough = .true.
    if (law%overlap >= huge(law%overlap)) return
    do i = 1, size(touch%contact)
      associate (k => touch%contact(i)%active, line => touch%contact(i)%line(touch%contact(i)%active))
        if (line%state == state_open) cycle
        both = gaps_and_slips(system, touch, i, d)
        of = forces(system%outlines, law, touch%dashpot, touch%contact(i), touch%start_gap(:, i), both)
        pair = of(1, [k, 3])
        pair(1) = pair(1) + touch%dashpot*(both(1, k) - min(touch%start_gap(k, i), 0.0_dp)) ! it is no part of the overlap's force
        enough = enough .and. (abs(both(1, k)) <= law%overlap .or. maxval(abs(pair - line%held)) <= faint*abs(pair(1)))
        line%held = pair
      end associate
    end do
  end subroutine hold_contacts

  !> The contacts for the velocities at the end of the step: with what displacement `still` they would be at rest, how
  !> fast each one approached, and how much displacement a unit of velocity is.
  !>
  !> An impact counts at the end of the step that is nearer in time: what meets in its second half takes part in the next.
  !> What touched at the beginning takes part too, whether it opens or not: it bears until the impact that lifts it.
  !> Multipliers are to leave an error of the velocities below the share `unmet` of the fastest approach, of what meets or
  !> would without the forces of the step: at rest nothing else is a measure.
  !> The coefficient of restitution is a notion of rigid bodies: one of a single element takes an impact as such.
  pure subroutine rebound_contacts(system, share, d, weight, still, velocity, way, touch, law, rebound)
    type(system_t), intent(in) :: system
    type(element_share_t), intent(in) :: share(:) !! (n_elements)
    real(dp), intent(in) :: d(:)              !! (n_unknowns) of the step
    real(dp), intent(in) :: weight            !! of `d` in the configuration where the forces act
    real(dp), intent(in) :: still(:)          !! (n_unknowns) displacement after which nothing moves
    real(dp), intent(in) :: velocity(:)       !! (n_unknowns) at the beginning of the step
    real(dp), intent(in) :: way               !! time
    type(touch_t), intent(in) :: touch
    type(contact_law_t), intent(inout) :: law
    type(touch_t), intent(out) :: rebound
    real(dp) :: approach, fastest, v(n), both(2, 2), push(3, 2)
    integer :: i, k

    rebound%contact = touch%contact
    rebound%link = touch%link
    rebound%geometry = touch%geometry
    rebound%start_share = touch%start_share
    rebound%start_gap = 0*touch%start_gap
    allocate (rebound%kept(2, size(touch%contact)), source=.true.)
    rebound%reference = still
    rebound%moved = merge(d, 0.0_dp, touch%bends)
    rebound%weight = weight
    fastest = 0.0_dp
    do i = 1, size(touch%contact)
      k = line_in_impact(i)
      associate (contact => rebound%contact(i), geometry => rebound%geometry(1, i))
        contact%line(1) = contact%line(max(k, 1))
        contact%n_lines = 1
        contact%active = 1
        contact%line(1)%anchor = 0.0_dp
        contact%line(1)%held = 0.0_dp
        geometry = touch%geometry(max(k, 1), i)
        geometry%along = 0.0_dp
        if (k == 0) then
          contact%line(1)%state = state_open
          geometry%gap = huge(1.0_dp)
        else
          v = rates_at(i, k)
          approach = dot_product(geometry%normal, v)
          fastest = max(fastest, unmet*sum(abs(geometry%shear*v)), unmet*sum(abs(geometry%normal*v)), -approach)
          geometry%gap = law%restitution*way*min(approach, 0.0_dp)
          both = gaps_and_slips(system, touch, i, d)
          push = pushes(law, touch%dashpot, touch%contact(i), touch%start_gap(:, i), both(1, :))
          fastest = max(fastest, way*push(1, k)*sum(1/share(touch%link(:, contact%line(1)%link))%mass))
        end if
      end associate
    end do
    allocate (rebound%firmness(size(share)))
    do i = 1, size(share)
      rebound%firmness(i) = merge(rigid*share(i)%mass/way**2, 0.0_dp, system%elements%alone(i))
    end do
    law%conserving = .false.
    law%lags = .false.
    law%closing = 0.0_dp
    law%opening = 0.0_dp
    law%normal_stiffness = unyielding*maxval(share%mass)/way**2
    law%shear_stiffness = law%normal_stiffness
    law%overlap = unmet*way*fastest
    if (law%overlap <= 0) law%overlap = huge(law%overlap)

  contains

    !> The line of a contact that takes part, 0 where none does.
    pure integer function line_in_impact(i) result(k)
      integer, intent(in) :: i
      real(dp) :: approach
      logical :: late

      associate (contact => touch%contact(i))
        k = contact%active
        approach = dot_product(touch%geometry(k, i)%normal, rates_at(i, k))
        late = .not. touch%kept(k, i) .and. approach < 0 .and. touch%start_gap(k, i) > -way*approach
        if (contact%line(k)%state == state_open .or. late) k = findloc(touch%kept(:contact%n_lines, i), .true., 1)
      end associate
    end function line_in_impact

    !> Velocities of the elements of a line at the beginning of the step.
    pure function rates_at(i, k) result(rates)
      integer, intent(in) :: i, k
      real(dp) :: rates(n)

      associate (link => touch%link(:, touch%contact(i)%line(k)%link))
        rates = [velocity(system%elements%unknown(:, link(1))), velocity(system%elements%unknown(:, link(2)))]
      end associate
    end function rates_at

  end subroutine rebound_contacts

  !> Adds what keeps an element from deforming in an impact.
  !>
  !> What is resisted is the strain rate of the displaced element, F^T L F, which is zero for any rigid motion of it; the
  !> forces have no torque about the places where those of the contacts act.
  pure subroutine keep_firm(system, touch, e, share, d, term)
    type(system_t), intent(in) :: system
    type(touch_t), intent(in) :: touch
    integer, intent(in) :: e
    type(element_share_t), intent(in) :: share
    real(dp), intent(in) :: d(:)                  !! (n_unknowns)
    type(term_t), intent(inout) :: term
    real(dp) :: theta(4), matrix(element_unknowns, element_unknowns)

    associate (ids => system%elements%unknown(:, e), G => share%kinematics%gradient)
      theta = matmul(G, touch%moved(ids))
      matrix = touch%firmness(e)*share%kinematics%area*matmul(transpose(matmul(strain_operator(theta, touch%weight), G)), &
                                                              matmul(strain_operator(theta, 1.0_dp), G))
      call add_force(term, -matmul(matrix, d(ids) - touch%reference(ids)))
    end associate
    term%matrix = term%matrix + matrix
  end subroutine keep_firm

  !> How far a vertex went beyond what the search for contacts looked at, 0 where none did; and beyond what its velocity makes,
  !> over the shorter edge at it.
  pure function outran(system, state, share, d) result(farthest)
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state               !! at the beginning of the step
    type(element_share_t), intent(in) :: share(:)    !! (n_elements)
    real(dp), intent(in) :: d(:)                     !! (n_unknowns)
    real(dp) :: farthest(2), beyond
    integer :: i

    farthest = 0.0_dp
    associate (outlines => system%outlines)
      do i = 1, size(outlines%start)
        beyond = norm2(matmul(displacement_matrix(share(outlines%element(i))%kinematics, state%vertex(:, outlines%start(i))), &
                              d(system%elements%unknown(:, outlines%element(i))))) - state%contacts%near(i)
        farthest(1) = max(farthest(1), beyond)
        if (beyond > 0) farthest(2) = max(farthest(2), beyond/state%contacts%local(i) &
                                          + min(state%contacts%margin/state%contacts%local(i), state%contacts%leap))
      end do
    end associate
  end function outran

  !> Largest gap and overlap of a closed contact at `d`.
  pure function farthest_apart(system, touch, d) result(farthest)
    type(system_t), intent(in) :: system
    type(touch_t), intent(in) :: touch
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    real(dp) :: both(2), farthest(2)
    integer :: i

    farthest = 0.0_dp
    do i = 1, size(touch%contact)
      associate (contact => touch%contact(i))
        if (contact%line(contact%active)%state == state_open) cycle
        both = gap_and_slip(system, touch, i, contact%active, d)
        farthest = max(farthest, [both(1), -both(1)])
      end associate
    end do
  end function farthest_apart

  !> What the contacts of an accepted step remember: states, anchors, bonds, overlap, energy, friction.
  pure subroutine accept_contacts(system, law, d, touch, contacts)
    type(system_t), intent(in) :: system
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: d(:)              !! (n_unknowns) of the step
    type(touch_t), intent(in) :: touch
    type(contacts_t), intent(inout) :: contacts
    real(dp) :: both(2, 2), of(4, 3), gap, slip
    logical :: held_together(size(touch%link, 2))
    integer :: i

    contacts%contact = touch%contact
    contacts%count = touch%count
    contacts%margin = 0.5_dp*contacts%margin
    contacts%gap = 0.0_dp
    contacts%overlap = 0.0_dp
    contacts%energy = 0.0_dp
    held_together = .false.
    do i = 1, size(contacts%contact)
      associate (line => contacts%contact(i)%line(contacts%contact(i)%active))
        if (line%bonded .and. line%state == state_locked) held_together(line%link) = .true.
      end associate
    end do
    do i = 1, size(contacts%contact)
      associate (k => contacts%contact(i)%active, line => contacts%contact(i)%line(contacts%contact(i)%active))
        contacts%contact(i)%force = 0.0_dp
        if (line%state == state_open) then
          line%bonded = .false.
          line%held = 0.0_dp
          cycle
        end if
        both = gaps_and_slips(system, touch, i, d)
        of = forces(system%outlines, law, touch%dashpot, touch%contact(i), touch%start_gap(:, i), both)
        contacts%contact(i)%force = [sum(of(1, :2)), of(1, 3)]
        slip = both(2, k)
        if (line%state == state_sliding) then
          slip = merge(0.0_dp, (line%held(2) - of(1, 3))/law%shear_stiffness, law%lags)
          contacts%friction = contacts%friction + abs(of(1, 3)*(both(2, k) - slip))
          line%anchor = line%anchor + (both(2, k) - slip)/touch%geometry(k, i)%edge_length
          ! a joint gives way as a whole, and a bond without shear strength has none to lose
          if (law%lags .and. line%bonded) then ! whatever else holds (Shi)
            line%drag = line%drag - law%cohesion(system%outlines%joint(line%edge))*line%length
            line%bonded = .false.
          end if
          line%bonded = line%bonded .and. (held_together(line%link) .or. .not. abs(of(1, 3)) > 0)
        end if
        gap = both(1, k)
        if (law%conserving) gap = maxval(both(1, :contacts%contact(i)%n_lines))
        contacts%gap = max(contacts%gap, gap)
        contacts%overlap = max(contacts%overlap, -gap)
        if (law%conserving) gap = min(gap, 0.0_dp)
        contacts%energy = contacts%energy + 0.5_dp*(law%normal_stiffness*gap**2 + law%shear_stiffness*slip**2)
      end associate
    end do
  end subroutine accept_contacts

end module scree_open_close
