!> The open-close iteration: which contacts are open, sliding or locked (Shi's df07, df22).
!>
!> Every iteration solves for the states of the one before and then judges all states anew (a semi-smooth Newton iteration). With N
!> and T the forces across and along its line (`contact_forces`), a contact is closed where N > 0, and
!>
!>     |T| <= N tan phi + c l        else it slides: T = -+(N tan phi + c l), and the anchor follows
!>
!> Nothing is kept but by `accept_contacts`. With multipliers `hold_contacts` lets h and h' follow N and T until no overlap above
!> a bound is left.
module scree_open_close
  use scree_contact_forces, only: bond, forces, pushes
  use scree_contact_geometry, only: frame_of_edge
  use scree_contacts, only: contact_law_t, contact_t, contacts_t, line_t, outlines_t, parallel, state_locked, state_open, &
                            state_sliding
  use scree_effects, only: element_share_t
  use scree_element_term, only: step_rule_t
  use scree_kinds, only: dp
  use scree_shi_contact, only: anchor_where_closed, judge_lagging_friction
  use scree_system, only: state_t, system_t
  use scree_touch, only: gaps_and_slips, of_elements, place_contacts, touch_t
  implicit none
  private
  public :: accept_contacts, begin_again, begin_contacts, hold_contacts, judge_contacts, return_anchors

  !> A force below this share of the largest contact force on the body that has the smaller changes no state.
  real(dp), parameter :: faint = 1e-8_dp
  !> A change of a gap below this share of what cancels in it is round-off.
  real(dp), parameter :: round_off = 8*epsilon(1.0_dp)

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
    integer :: i, m

    touch%contact = state%contacts%contact
    touch%link = state%contacts%link
    touch%bends = bends
    touch%anchored = law%lags .and. .not. bends
    touch%dashpot = law%viscosity/rule%dt
    m = size(touch%contact)
    if (state%step == 0) call bond_contacts(system%outlines, law, state%vertex, touch)
    allocate (touch%geometry(2, m), touch%kept(2, m))
    allocate (touch%reference(system%n_unknowns), source=0.0_dp)
    call place_contacts(system, state, share, rule%operator_weight, touch%reference, touch)
    if (law%conserving) call take_over(touch)
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

  !> Lets contacts that conserve energy begin with that of the contact whose place they take: the springs of their lines rest so
  !> that the larger of the overlaps' gaps is the same.
  pure subroutine take_over(touch)
    type(touch_t), intent(inout) :: touch
    real(dp) :: gap, shift
    integer :: i, k, largest

    do i = 1, size(touch%contact)
      associate (contact => touch%contact(i))
        if (contact%inherits < 0) cycle
        gap = min(-contact%inherits, 0.0_dp)
        largest = maxloc(touch%geometry(:contact%n_lines, i)%gap, 1)
        if (touch%geometry(largest, i)%gap >= 0 .and. gap >= 0) cycle
        do k = 1, contact%n_lines
          shift = touch%geometry(k, i)%gap - gap
          if (k /= largest) shift = max(shift, 0.0_dp)
          contact%line(k)%rest = contact%line(k)%rest + shift
          touch%geometry(k, i)%gap = touch%geometry(k, i)%gap - shift
        end do
        contact%inherits = -1.0_dp
      end associate
    end do
  end subroutine take_over

  !> Bonds the contacts of joints with cohesion or strength.
  pure subroutine bond_contacts(outlines, law, position, touch)
    type(outlines_t), intent(in) :: outlines
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: position(:, :) !! (2, n_vertices), length
    type(touch_t), intent(inout) :: touch
    integer :: i, k

    do i = 1, size(touch%contact)
      do k = 1, touch%contact(i)%n_lines
        associate (line => touch%contact(i)%line(k), joint => outlines%joint(touch%contact(i)%line(k)%edge))
          if (law%cohesion(joint) > 0 .or. law%strength(joint) > 0) line%length = length_of_contact(outlines, position, line)
          line%bonded = line%length > 0
        end associate
      end do
    end do
  end subroutine bond_contacts

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
  pure real(dp) function length_of_contact(outlines, position, line) result(length)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)     !! (2, n_vertices), length
    type(line_t), intent(in) :: line
    real(dp) :: t(2), normal(2), own(2), other, at, ends(2)
    integer :: edge, i

    call frame_of_edge(position(:, outlines%start(line%edge)), position(:, outlines%finish(line%edge)), t, normal, other)
    length = 0.0_dp
    do i = 1, 2
      edge = merge(line%vertex, outlines%previous(line%vertex), i == 1)
      own = position(:, outlines%finish(edge)) - position(:, outlines%start(edge))
      if (dot_product(own, t) > -cos(parallel)*norm2(own)) cycle
      at = dot_product(t, position(:, outlines%start(edge)) - position(:, outlines%start(line%edge)))
      ends = [at + dot_product(t, own), at]
      length = length + 0.5_dp*max(0.0_dp, min(other, ends(2)) - max(0.0_dp, ends(1)))
    end do
  end function length_of_contact

  !> Judges every contact at `d`; `touch%changes` counts states that change by more than a faint force.
  !>
  !> The first judgement, of a prediction, only closes: what was closed is taken to stay as it was.
  subroutine judge_contacts(system, law, d, first, touch)
    type(system_t), intent(in) :: system
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    logical, intent(in) :: first
    type(touch_t), intent(inout) :: touch
    real(dp) :: both(2, 2, size(touch%contact)), push(3, 2, size(touch%contact)), pressing
    real(dp) :: largest(size(system%outlines%first) - 1) !! force across a contact of each block
    integer :: i, state

    if (touch%anchored) call put_anchors(system, d, touch)
    largest = 0.0_dp
    do i = 1, size(touch%contact)
      both(:, :, i) = gaps_and_slips(system, touch, i, d)
      push(:, :, i) = pushes(law, touch, i, both(1, :, i))
      pressing = max(minval(push(1, :touch%contact(i)%n_lines, i)), merge(sum(push(1, :, i)), 0.0_dp, law%conserving))
      associate (body => bodies_of(touch%contact(i)))
        largest(body) = max(largest(body), pressing)
      end associate
    end do
    touch%changes = 0
    touch%count = 0
    do i = 1, size(touch%contact)
      if (.not. first .or. touch%contact(i)%line(touch%contact(i)%active)%state == state_open) &
        call judge_contact(i, both(:, :, i), push(1, :, i))
      state = touch%contact(i)%line(touch%contact(i)%active)%state
      touch%count(1 + state) = touch%count(1 + state) + 1
    end do

  contains

    !> Finds the line of a contact that acts, and its state.
    subroutine judge_contact(i, both, push)
      integer, intent(in) :: i
      real(dp), intent(in) :: both(2, 2) !! gap and slip of its lines
      real(dp), intent(in) :: push(2)    !! across them
      real(dp) :: doubt, pressing
      integer :: k, new

      doubt = 0.0_dp
      if (.not. law%lags) doubt = faint*minval(largest(bodies_of(touch%contact(i)))) + law%normal_stiffness*rounding_of(i)
      associate (contact => touch%contact(i))
        k = 1
        if (contact%n_lines == 2) k = acting_line(i, both(1, :), push, doubt)
        pressing = merge(sum(push), push(k), law%conserving)
        if (k /= contact%active) then
          associate (left => contact%line(contact%active))
            if (law%lags) then ! it stays closed, on the other line, unless the one that it leaves is open (Shi)
              contact%line(k)%state = left%state
              if (left%state /= state_open) pressing = push(contact%active)
            else if (left%state /= state_open) then
              touch%changes = touch%changes + 1
            end if
            left%state = state_open
          end associate
          contact%active = k
        end if
        associate (line => contact%line(k))
          call judge_line(i, k, both(:, k), pressing, doubt, line, new)
          if (first .and. new /= state_open) new = merge(state_locked, state_sliding, can_lock(line))
          if (new /= line%state) then
            if (min(new, line%state) == state_open) then
              if (abs(pressing) > doubt) touch%changes = touch%changes + 1
            else if (.not. law%lags) then
              touch%changes = touch%changes + 1
            end if
          end if
          line%state = new
        end associate
      end associate
    end subroutine judge_contact

    !> What rounding leaves of the change of a gap in the step, length.
    pure real(dp) function rounding_of(i)
      integer, intent(in) :: i

      associate (line => touch%contact(i)%line(1))
        rounding_of = round_off*sum(abs(touch%geometry(1, i)%normal*of_elements(system, touch%link(:, line%link), d)))
      end associate
    end function rounding_of

    !> Blocks of a contact.
    pure function bodies_of(contact) result(body)
      type(contact_t), intent(in) :: contact
      integer :: body(2)

      body = system%outlines%block([contact%line(1)%vertex, contact%line(1)%edge])
    end function bodies_of

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
    pure subroutine judge_line(i, k, both, pressing, doubt, line, state)
      integer, intent(in) :: i, k
      real(dp), intent(in) :: both(2), pressing, doubt
      type(line_t), intent(inout) :: line
      integer, intent(out) :: state
      real(dp) :: along, slip
      integer :: joint

      state = state_open
      if (.not. is_closed(line, pressing)) return
      slip = both(2)
      associate (start_gap => touch%start_gap(k, i), start => touch%start_share(k, i), length => touch%geometry(k, i)%edge_length)
        if (line%state == state_open .and. start_gap > 0 .and. .not. (touch%kept(k, i) .or. line%bonded .or. touch%anchored)) then
          along = slip + line%anchor*length
          line%anchor = start + min(1.0_dp, start_gap/max(start_gap - both(1), tiny(start_gap)))*(along/length - start)
          slip = along - line%anchor*length
        end if
      end associate
      joint = system%outlines%joint(line%edge)
      if (.not. law%lags) then
        call judge_friction(law%friction(joint), slip, pressing, doubt, line, state)
      else if (touch%contact(i)%n_lines == 1) then
        call judge_lagging_friction(law, law%friction(joint), bond(line, law%cohesion(joint)), both(2), pressing, line, state)
      else ! two corners have none (Shi)
        call judge_lagging_friction(law, 0.0_dp, 0.0_dp, both(2), pressing, line, state)
      end if
    end subroutine judge_line

    !> Whether a line that presses, or is pulled, with a force is closed.
    pure logical function is_closed(line, pressing)
      type(line_t), intent(in) :: line
      real(dp), intent(in) :: pressing

      if (law%conserving) then
        is_closed = pressing > 0
      else if (line%state == state_open) then
        is_closed = pressing >= law%normal_stiffness*law%closing
      else
        is_closed = pressing >= -law%normal_stiffness*law%opening - bond(line, law%strength(system%outlines%joint(line%edge)))
      end if
    end function is_closed

    !> Whether a closed line slides or is locked, and which way it slides, by the normal force of the same solution.
    pure subroutine judge_friction(friction, slip, pressing, doubt, line, state)
      real(dp), intent(in) :: friction, slip, pressing, doubt
      type(line_t), intent(inout) :: line
      integer, intent(out) :: state
      real(dp) :: limit, shear

      shear = line%held(2) - law%shear_stiffness*slip
      limit = max(0.0_dp, friction*pressing + bond(line, law%cohesion(system%outlines%joint(line%edge))))
      if (line%state == state_sliding .and. limit > 0 .and. line%direction*shear > law%shear_stiffness*law%backlash) then
        state = state_locked ! it turned back; whether it slides there the next iteration tells
      else if (line%state /= state_open .and. abs(abs(shear) - limit) <= doubt) then
        state = line%state
      else
        state = merge(state_locked, state_sliding, abs(shear) < limit)
      end if
      if (state == state_sliding) line%direction = sign(1.0_dp, -shear)
    end subroutine judge_friction

    !> Whether a joint has any shear strength.
    pure logical function can_lock(line)
      type(line_t), intent(in) :: line

      associate (joint => system%outlines%joint(line%edge))
        can_lock = law%friction(joint) > 0 .or. bond(line, law%cohesion(joint)) > 0
      end associate
    end function can_lock

  end subroutine judge_contacts

  !> Puts the anchors of open contacts where their vertex meets the edge (Shi: df22).
  pure subroutine put_anchors(system, d, touch)
    type(system_t), intent(in) :: system
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    type(touch_t), intent(inout) :: touch
    integer :: i, k

    do i = 1, size(touch%contact)
      do k = 1, touch%contact(i)%n_lines
        associate (line => touch%contact(i)%line(k))
          if (line%state == state_open) &
            line%anchor = anchor_where_closed(touch%geometry(k, i), of_elements(system, touch%link(:, line%link), d))
        end associate
      end do
    end do
  end subroutine put_anchors

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
        of = forces(system%outlines, law, touch, i, both)
        pair = of(1, [k, 3])
        pair(1) = pair(1) + touch%dashpot*(both(1, k) - min(touch%start_gap(k, i), 0.0_dp)) ! it is no part of the overlap's force
        enough = enough .and. (abs(both(1, k)) <= law%overlap .or. maxval(abs(pair - line%held)) <= faint*abs(pair(1)))
        line%held = pair
      end associate
    end do
  end subroutine hold_contacts

  !> Moves anchors back to where their vertices were when the step began, where these closed in the step and do not get to them:
  !> shear would pull them on along their way and do work.
  pure subroutine return_anchors(system, law, d, touch, enough)
    type(system_t), intent(in) :: system
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    type(touch_t), intent(inout) :: touch
    logical, intent(out) :: enough            !! none had to move
    real(dp) :: both(2, 2), of(4, 3), way
    integer :: i

    enough = .true.
    if (law%lags) return
    do i = 1, size(touch%contact)
      associate (k => touch%contact(i)%active, line => touch%contact(i)%line(touch%contact(i)%active))
        if (line%state == state_open .or. line%bonded .or. touch%kept(k, i) .or. .not. touch%start_gap(k, i) > 0) cycle
        both = gaps_and_slips(system, touch, i, d)
        of = forces(system%outlines, law, touch, i, both)
        way = both(2, k) + (line%anchor - touch%start_share(k, i))*touch%geometry(k, i)%edge_length
        if (.not. of(1, 3)*way > 0 .or. .not. abs(line%anchor - touch%start_share(k, i)) > 0) cycle
        line%anchor = touch%start_share(k, i)
        line%held(2) = 0.0_dp
        enough = .false.
      end associate
    end do
  end subroutine return_anchors

  !> What the contacts of an accepted step remember: states, anchors, bonds, overlap, energy, friction.
  pure subroutine accept_contacts(system, law, d, touch, contacts)
    type(system_t), intent(in) :: system
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: d(:)              !! (n_unknowns) of the step
    type(touch_t), intent(in) :: touch
    type(contacts_t), intent(inout) :: contacts
    real(dp) :: both(2, 2), of(4, 3), gap, slip
    logical :: held_together(size(touch%link, 2)) !! by a bond that is locked
    integer :: i

    contacts%contact = touch%contact
    contacts%count = touch%count
    contacts%margin = 0.5_dp*contacts%margin
    contacts%swing = 0.5_dp*contacts%swing
    contacts%gap = 0.0_dp
    contacts%overlap = 0.0_dp
    contacts%pressed = 0.0_dp
    contacts%contact%pressed = 0.0_dp
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
        both = gaps_and_slips(system, touch, i, d)
        if (line%state == state_open) then
          line%bonded = .false.
          line%held = 0.0_dp
          if (line%rest < 0) contacts%overlap = max(contacts%overlap, -(line%rest + both(1, k)))
          cycle
        end if
        of = forces(system%outlines, law, touch, i, both)
        contacts%contact(i)%force = [sum(of(1, :2)), of(1, 3)]
        slip = both(2, k)
        if (line%state == state_sliding) call let_slide(of(1, 3), touch%geometry(k, i)%edge_length, line, slip, contacts%friction)
        gap = both(1, k)
        if (law%conserving) gap = maxval(both(1, :contacts%contact(i)%n_lines))
        contacts%gap = max(contacts%gap, gap)
        contacts%overlap = max(contacts%overlap, -(line%rest + gap))
        contacts%contact(i)%pressed = max(0.0_dp, -gap)
        contacts%pressed = max(contacts%pressed, -gap)
        if (law%conserving) gap = min(gap, 0.0_dp)
        contacts%energy = contacts%energy + 0.5_dp*(law%normal_stiffness*gap**2 + law%shear_stiffness*slip**2)
      end associate
    end do

  contains

    !> Lets the anchor of a line that slid follow, and its bond break. A joint gives way as a whole, and a bond without shear
    !> strength has none to lose; for Shi, a bond breaks whatever else holds.
    pure subroutine let_slide(shear, edge_length, line, slip, friction)
      real(dp), intent(in) :: shear       !! force
      real(dp), intent(in) :: edge_length
      type(line_t), intent(inout) :: line
      real(dp), intent(inout) :: slip     !! of the step, then what the spring keeps of it, length
      real(dp), intent(inout) :: friction !! work lost
      real(dp) :: kept

      kept = merge(0.0_dp, (line%held(2) - shear)/law%shear_stiffness, law%lags)
      friction = friction + abs(shear*(slip - kept))
      line%anchor = line%anchor + (slip - kept)/edge_length
      slip = kept
      if (law%lags) then
        line%drag = line%drag - bond(line, law%cohesion(system%outlines%joint(line%edge)))
        line%bonded = .false.
      else
        line%bonded = line%bonded .and. (held_together(line%link) .or. .not. abs(shear) > 0)
      end if
    end subroutine let_slide

  end subroutine accept_contacts

end module scree_open_close
