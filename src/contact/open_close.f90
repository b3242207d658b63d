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
  use scree_contacts, only: contact_memory_t, contact_t, entrance_t, outlines_t, parallel, state_locked, state_open, &
                            state_sliding
  use scree_element_term, only: step_rule_t
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_shi_contact, only: anchor_where_closed, judge_lagging_friction
  use scree_state, only: state_t
  use scree_contact_try, only: gaps_and_slips, of_elements, place_contacts, contact_try_t
  implicit none
  private
  public :: accept_contacts, begin_again, begin_contacts, hold_contacts, judge_contacts, return_anchors

  !> A force below this share of the largest contact force on the body that has the smaller changes no state.
  real(dp), parameter :: faint = 1e-8_dp
  !> A change of a gap below this share of what cancels in it is round-off.
  real(dp), parameter :: round_off = 8*epsilon(1.0_dp)

contains

  !> The contacts as the step finds them. Those of the first step are bonded where their joint has cohesion or strength.
  pure subroutine begin_contacts(model, cache, state, rule, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(step_rule_t), intent(in) :: rule
    type(contact_try_t), intent(inout) :: try     !! with the contacts that were found
    integer :: i, m

    try%bends = model%effects%large_deformation
    try%anchored = try%law%lags .and. .not. try%bends
    try%dashpot = try%law%viscosity/rule%dt
    m = size(try%contact)
    if (state%step == 0) call bond_contacts(model%outlines, state%vertex, try)
    if (allocated(try%geometry)) deallocate (try%geometry, try%kept)
    allocate (try%geometry(2, m), try%kept(2, m))
    try%reference = [(0.0_dp, i=1, model%n_unknowns)]
    call place_contacts(model, cache, state, rule%operator_weight, try%reference, try)
    if (try%law%conserving) call take_over(try)
    try%start_gap = try%geometry%gap
    try%start_share = try%geometry%along/try%geometry%edge_length
    if (state%step == 0) call close_touching(try%law%touching, try)
    do i = 1, m
      associate (contact => try%contact(i))
        if (contact%n_entrances == 2 .and. .not. try%law%lags) then
          if (try%start_gap(3 - contact%active, i) > 0) contact%entrance(contact%active)%state = state_open ! it slipped off
        end if
        try%kept(:, i) = contact%entrance%state /= state_open
      end associate
    end do
  end subroutine begin_contacts

  !> Lets contacts that conserve energy begin with that of the contact whose place they take: the springs of their lines rest so
  !> that the larger of the overlaps' gaps is the same.
  pure subroutine take_over(try)
    type(contact_try_t), intent(inout) :: try
    real(dp) :: gap, shift
    integer :: i, k, largest

    do i = 1, size(try%contact)
      associate (contact => try%contact(i))
        if (contact%inherits < 0) cycle
        gap = min(-contact%inherits, 0.0_dp)
        largest = maxloc(try%geometry(:contact%n_entrances, i)%gap, 1)
        if (try%geometry(largest, i)%gap >= 0 .and. gap >= 0) cycle
        do k = 1, contact%n_entrances
          shift = try%geometry(k, i)%gap - gap
          if (k /= largest) shift = max(shift, 0.0_dp)
          contact%entrance(k)%rest = contact%entrance(k)%rest + shift
          try%geometry(k, i)%gap = try%geometry(k, i)%gap - shift
        end do
        contact%inherits = -1.0_dp
      end associate
    end do
  end subroutine take_over

  !> Bonds the contacts of joints with cohesion or strength.
  pure subroutine bond_contacts(outlines, position, try)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :) !! (2, n_vertices), length
    type(contact_try_t), intent(inout) :: try
    integer :: i, k

    do i = 1, size(try%contact)
      do k = 1, try%contact(i)%n_entrances
        associate (entrance => try%contact(i)%entrance(k), joint => outlines%joint(try%contact(i)%entrance(k)%edge))
          if (try%law%cohesion(joint) > 0 .or. try%law%strength(joint) > 0) entrance%length = length_of_contact(outlines, &
              position, &
              entrance)
          entrance%bonded = entrance%length > 0
        end associate
      end do
    end do
  end subroutine bond_contacts

  !> Closes contacts with a gap up to `touching`.
  pure subroutine close_touching(touching, try)
    real(dp), intent(in) :: touching !! length
    type(contact_try_t), intent(inout) :: try
    integer :: i, k

    do i = 1, size(try%contact)
      k = maxloc(try%start_gap(:try%contact(i)%n_entrances, i), 1)
      if (try%start_gap(k, i) > touching) cycle
      try%contact(i)%active = k
      try%contact(i)%entrance(k)%state = merge(state_sliding, state_locked, try%anchored .and. try%contact(i)%n_entrances == 2)
    end do
  end subroutine close_touching

  !> The contacts of a step that is tried again, as Shi's programs leave them: in the states of the last judgement.
  pure subroutine begin_again(rule, try)
    type(step_rule_t), intent(in) :: rule
    type(contact_try_t), intent(inout) :: try
    integer :: k

    try%dashpot = try%law%viscosity/rule%dt
    do k = 1, 2
      try%contact%entrance(k)%lagged_friction = 0.0_dp
    end do
  end subroutine begin_again

  !> Length of the joint that a contact stands for: half of what its edge and each parallel one at the vertex have in common.
  pure real(dp) function length_of_contact(outlines, position, entrance) result(length)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)     !! (2, n_vertices), length
    type(entrance_t), intent(in) :: entrance
    real(dp) :: t(2), normal(2), own(2), other, at, ends(2)
    integer :: edge, i

    call frame_of_edge(position(:, outlines%start(entrance%edge)), position(:, outlines%finish(entrance%edge)), t, normal, other)
    length = 0.0_dp
    do i = 1, 2
      edge = merge(entrance%vertex, outlines%previous(entrance%vertex), i == 1)
      own = position(:, outlines%finish(edge)) - position(:, outlines%start(edge))
      if (dot_product(own, t) > -cos(parallel)*norm2(own)) cycle
      at = dot_product(t, position(:, outlines%start(edge)) - position(:, outlines%start(entrance%edge)))
      ends = [at + dot_product(t, own), at]
      length = length + 0.5_dp*max(0.0_dp, min(other, ends(2)) - max(0.0_dp, ends(1)))
    end do
  end function length_of_contact

  !> Judges every contact at `d`; `touch%changes` counts states that change by more than a faint force.
  !>
  !> The first judgement, of a prediction, only closes: what was closed is taken to stay as it was.
  subroutine judge_contacts(model, d, first, try)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    logical, intent(in) :: first
    type(contact_try_t), intent(inout) :: try
    real(dp) :: both(2, 2, size(try%contact)), push(3, 2, size(try%contact)), pressing
    real(dp) :: largest(size(model%outlines%first) - 1) !! force across a contact of each block
    integer :: i, state

    if (try%anchored) call put_anchors(model, d, try)
    largest = 0.0_dp
    do i = 1, size(try%contact)
      both(:, :, i) = gaps_and_slips(model, try, i, d)
      push(:, :, i) = pushes(try, i, both(1, :, i))
      pressing = max(minval(push(1, :try%contact(i)%n_entrances, i)), merge(sum(push(1, :, i)), 0.0_dp, try%law%conserving))
      associate (body => bodies_of(try%contact(i)))
        largest(body) = max(largest(body), pressing)
      end associate
    end do
    try%changes = 0
    try%count = 0
    do i = 1, size(try%contact)
      if (.not. first .or. try%contact(i)%entrance(try%contact(i)%active)%state == state_open) &
        call judge_contact(i, both(:, :, i), push(1, :, i))
      state = try%contact(i)%entrance(try%contact(i)%active)%state
      try%count(1 + state) = try%count(1 + state) + 1
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
      if (.not. try%law%lags) doubt = faint*minval(largest(bodies_of(try%contact(i)))) + try%law%normal_stiffness*rounding_of(i)
      associate (contact => try%contact(i))
        k = 1
        if (contact%n_entrances == 2) k = acting_entrance(i, both(1, :), push, doubt)
        pressing = merge(sum(push), push(k), try%law%conserving)
        if (k /= contact%active) then
          associate (left => contact%entrance(contact%active))
            if (try%law%lags) then ! it stays closed, on the other line, unless the one that it leaves is open (Shi)
              contact%entrance(k)%state = left%state
              if (left%state /= state_open) pressing = push(contact%active)
            else if (left%state /= state_open) then
              try%changes = try%changes + 1
            end if
            left%state = state_open
          end associate
          contact%active = k
        end if
        associate (entrance => contact%entrance(k))
          call judge_entrance(i, k, both(:, k), pressing, doubt, entrance, new)
          if (first .and. new /= state_open) new = merge(state_locked, state_sliding, can_lock(entrance))
          if (new /= entrance%state) then
            if (min(new, entrance%state) == state_open) then
              if (abs(pressing) > doubt) try%changes = try%changes + 1
            else if (.not. try%law%lags) then
              try%changes = try%changes + 1
            end if
          end if
          entrance%state = new
        end associate
      end associate
    end subroutine judge_contact

    !> What rounding leaves of the change of a gap in the step, length.
    pure real(dp) function rounding_of(i)
      integer, intent(in) :: i

      associate (entrance => try%contact(i)%entrance(1))
        rounding_of = round_off*sum(abs(try%geometry(1, i)%normal*of_elements(model, try%pair(:, entrance%pair), d)))
      end associate
    end function rounding_of

    !> Blocks of a contact.
    pure function bodies_of(contact) result(body)
      type(contact_t), intent(in) :: contact
      integer :: body(2)

      body = model%outlines%block([contact%entrance(1)%vertex, contact%entrance(1)%edge])
    end function bodies_of

    !> Which of the two lines of a corner acts: the one that is crossed least, or was crossed last.
    !>
    !> What pressed when the step began presses on, as if its edge did not end: a corner that slips off in the step is held to
    !> its end. That it were let go where it leaves the other line would make its force jump, and leave some steps no solution.
    pure integer function acting_entrance(i, gap, push, doubt) result(k)
      integer, intent(in) :: i
      real(dp), intent(in) :: gap(2), push(2), doubt

      associate (active => try%contact(i)%active)
        k = 1
        if (try%law%conserving) then
          k = maxloc(push, 1)
        else if (try%law%lags) then
          k = maxloc(gap, 1)
        else if (try%kept(active, i) .and. push(active) > 0) then
          k = active
        else if (minval(push) < 0) then
          if (push(2) < push(1)) k = 2
        else
          k = crossed_last(merge(0.0_dp, try%start_gap(:, i), try%kept(:, i)), gap)
        end if
        if (abs(push(2) - push(1)) <= doubt) k = active
      end associate
    end function acting_entrance

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
    pure subroutine judge_entrance(i, k, both, pressing, doubt, entrance, state)
      integer, intent(in) :: i, k
      real(dp), intent(in) :: both(2), pressing, doubt
      type(entrance_t), intent(inout) :: entrance
      integer, intent(out) :: state
      real(dp) :: along, slip
      integer :: joint

      state = state_open
      if (.not. is_closed(entrance, pressing)) return
      slip = both(2)
      associate (start_gap => try%start_gap(k, i), start => try%start_share(k, i), length => try%geometry(k, i)%edge_length)
        if (entrance%state == state_open .and. start_gap > 0 .and. .not. (try%kept(k, i) .or. entrance%bonded &
            .or. try%anchored)) then
          along = slip + entrance%anchor*length
          entrance%anchor = start + min(1.0_dp, start_gap/max(start_gap - both(1), tiny(start_gap)))*(along/length - start)
          slip = along - entrance%anchor*length
        end if
      end associate
      joint = model%outlines%joint(entrance%edge)
      if (.not. try%law%lags) then
        call judge_friction(try%law%friction(joint), slip, pressing, doubt, entrance, state)
      else if (try%contact(i)%n_entrances == 1) then
        call judge_lagging_friction(try%law, try%law%friction(joint), bond(entrance, try%law%cohesion(joint)), both(2), &
            pressing, entrance, &
            state)
      else ! two corners have none (Shi)
        call judge_lagging_friction(try%law, 0.0_dp, 0.0_dp, both(2), pressing, entrance, state)
      end if
    end subroutine judge_entrance

    !> Whether a line that presses, or is pulled, with a force is closed.
    pure logical function is_closed(entrance, pressing)
      type(entrance_t), intent(in) :: entrance
      real(dp), intent(in) :: pressing

      if (try%law%conserving) then
        is_closed = pressing > 0
      else if (entrance%state == state_open) then
        is_closed = pressing >= try%law%normal_stiffness*try%law%closing
      else
        is_closed = pressing >= -try%law%normal_stiffness*try%law%opening - bond(entrance, &
            try%law%strength(model%outlines%joint(entrance%edge)))
      end if
    end function is_closed

    !> Whether a closed line slides or is locked, and which way it slides, by the normal force of the same solution.
    pure subroutine judge_friction(friction, slip, pressing, doubt, entrance, state)
      real(dp), intent(in) :: friction, slip, pressing, doubt
      type(entrance_t), intent(inout) :: entrance
      integer, intent(out) :: state
      real(dp) :: limit, shear

      shear = entrance%multiplier(2) - try%law%shear_stiffness*slip
      limit = max(0.0_dp, friction*pressing + bond(entrance, try%law%cohesion(model%outlines%joint(entrance%edge))))
      if (entrance%state == state_sliding .and. limit > 0 &
          .and. entrance%direction*shear > try%law%shear_stiffness*try%law%backlash) then
        state = state_locked ! it turned back; whether it slides there the next iteration tells
      else if (entrance%state /= state_open .and. abs(abs(shear) - limit) <= doubt) then
        state = entrance%state
      else
        state = merge(state_locked, state_sliding, abs(shear) < limit)
      end if
      if (state == state_sliding) entrance%direction = sign(1.0_dp, -shear)
    end subroutine judge_friction

    !> Whether a joint has any shear strength.
    pure logical function can_lock(entrance)
      type(entrance_t), intent(in) :: entrance

      associate (joint => model%outlines%joint(entrance%edge))
        can_lock = try%law%friction(joint) > 0 .or. bond(entrance, try%law%cohesion(joint)) > 0
      end associate
    end function can_lock

  end subroutine judge_contacts

  !> Puts the anchors of open contacts where their vertex meets the edge (Shi: df22).
  pure subroutine put_anchors(model, d, try)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    type(contact_try_t), intent(inout) :: try
    integer :: i, k

    do i = 1, size(try%contact)
      do k = 1, try%contact(i)%n_entrances
        associate (entrance => try%contact(i)%entrance(k))
          if (entrance%state == state_open) &
            entrance%anchor = anchor_where_closed(try%geometry(k, i), of_elements(model, try%pair(:, entrance%pair), d))
        end associate
      end do
    end do
  end subroutine put_anchors

  !> Lets multipliers take the forces of closed contacts over, where an overlap or a gap above the bound is left.
  pure subroutine hold_contacts(model, d, try, enough)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    type(contact_try_t), intent(inout) :: try
    logical, intent(out) :: enough            !! none is left
    real(dp) :: both(2, 2), of(4, 3), pair(2)
    integer :: i

    enough = .true.
    if (try%law%penetration >= huge(try%law%penetration)) return
    do i = 1, size(try%contact)
      associate (k => try%contact(i)%active, entrance => try%contact(i)%entrance(try%contact(i)%active))
        if (entrance%state == state_open) cycle
        both = gaps_and_slips(model, try, i, d)
        of = forces(model%outlines, try, i, both)
        pair = of(1, [k, 3])
        pair(1) = pair(1) + try%dashpot*(both(1, k) - min(try%start_gap(k, i), 0.0_dp)) ! it is no part of the overlap's force
        enough = enough .and. (abs(both(1, k)) <= try%law%penetration .or. maxval(abs(pair - entrance%multiplier)) <= &
            faint*abs(pair(1)))
        entrance%multiplier = pair
      end associate
    end do
  end subroutine hold_contacts

  !> Moves anchors back to where their vertices were when the step began, where these closed in the step and do not get to them:
  !> shear would pull them on along their way and do work.
  pure subroutine return_anchors(model, d, try, enough)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    type(contact_try_t), intent(inout) :: try
    logical, intent(out) :: enough            !! none had to move
    real(dp) :: both(2, 2), of(4, 3), way
    integer :: i

    enough = .true.
    if (try%law%lags) return
    do i = 1, size(try%contact)
      associate (k => try%contact(i)%active, entrance => try%contact(i)%entrance(try%contact(i)%active))
        if (entrance%state == state_open .or. entrance%bonded .or. try%kept(k, i) .or. .not. try%start_gap(k, i) > 0) cycle
        both = gaps_and_slips(model, try, i, d)
        of = forces(model%outlines, try, i, both)
        way = both(2, k) + (entrance%anchor - try%start_share(k, i))*try%geometry(k, i)%edge_length
        if (.not. of(1, 3)*way > 0 .or. .not. abs(entrance%anchor - try%start_share(k, i)) > 0) cycle
        entrance%anchor = try%start_share(k, i)
        entrance%multiplier(2) = 0.0_dp
        enough = .false.
      end associate
    end do
  end subroutine return_anchors

  !> What the contacts of an accepted step remember: states, anchors, bonds, overlap, energy, friction.
  pure subroutine accept_contacts(model, d, try, contacts, energy, friction)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: d(:)              !! (n_unknowns) of the step
    type(contact_try_t), intent(in) :: try
    type(contact_memory_t), intent(inout) :: contacts
    real(dp), intent(out) :: energy           !! of the springs at the end, force length per unit thickness
    real(dp), intent(out) :: friction         !! work lost in sliding in the step, likewise
    real(dp) :: both(2, 2), of(4, 3), gap, slip
    logical :: held_together(size(try%pair, 2)) !! by a bond that is locked
    integer :: i

    contacts%contact = try%contact
    contacts%pair = try%pair
    contacts%inside = try%inside
    contacts%stiffness = [try%law%normal_stiffness, try%law%shear_stiffness]
    contacts%count = try%count
    contacts%margin = 0.5_dp*try%margin
    contacts%swing = 0.5_dp*try%swing
    contacts%gap = 0.0_dp
    contacts%penetration = 0.0_dp
    contacts%pressed = 0.0_dp
    contacts%contact%pressed = 0.0_dp
    energy = 0.0_dp
    friction = 0.0_dp
    held_together = .false.
    do i = 1, size(contacts%contact)
      associate (entrance => contacts%contact(i)%entrance(contacts%contact(i)%active))
        if (entrance%bonded .and. entrance%state == state_locked) held_together(entrance%pair) = .true.
      end associate
    end do
    do i = 1, size(contacts%contact)
      associate (k => contacts%contact(i)%active, entrance => contacts%contact(i)%entrance(contacts%contact(i)%active))
        contacts%contact(i)%force = 0.0_dp
        both = gaps_and_slips(model, try, i, d)
        if (entrance%state == state_open) then
          entrance%bonded = .false.
          entrance%multiplier = 0.0_dp
          if (entrance%rest < 0) contacts%penetration = max(contacts%penetration, -(entrance%rest + both(1, k)))
          cycle
        end if
        of = forces(model%outlines, try, i, both)
        contacts%contact(i)%force = [sum(of(1, :2)), of(1, 3)]
        slip = both(2, k)
        if (entrance%state == state_sliding) call let_slide(of(1, 3), try%geometry(k, i)%edge_length, entrance, slip, &
            friction)
        gap = both(1, k)
        if (try%law%conserving) gap = maxval(both(1, :contacts%contact(i)%n_entrances))
        contacts%gap = max(contacts%gap, gap)
        contacts%penetration = max(contacts%penetration, -(entrance%rest + gap))
        contacts%contact(i)%pressed = max(0.0_dp, -gap)
        contacts%pressed = max(contacts%pressed, -gap)
        if (try%law%conserving) gap = min(gap, 0.0_dp)
        energy = energy + 0.5_dp*(try%law%normal_stiffness*gap**2 + try%law%shear_stiffness*slip**2)
      end associate
    end do

  contains

    !> Lets the anchor of a line that slid follow, and its bond break. A joint gives way as a whole, and a bond without shear
    !> strength has none to lose; for Shi, a bond breaks whatever else holds.
    pure subroutine let_slide(shear, edge_length, entrance, slip, friction)
      real(dp), intent(in) :: shear       !! force
      real(dp), intent(in) :: edge_length
      type(entrance_t), intent(inout) :: entrance
      real(dp), intent(inout) :: slip     !! of the step, then what the spring keeps of it, length
      real(dp), intent(inout) :: friction !! work lost
      real(dp) :: kept

      kept = merge(0.0_dp, (entrance%multiplier(2) - shear)/try%law%shear_stiffness, try%law%lags)
      friction = friction + abs(shear*(slip - kept))
      entrance%anchor = entrance%anchor + (slip - kept)/edge_length
      slip = kept
      if (try%law%lags) then
        entrance%lagged_friction = entrance%lagged_friction - bond(entrance, try%law%cohesion(model%outlines%joint(entrance%edge)))
        entrance%bonded = .false.
      else
        entrance%bonded = entrance%bonded .and. (held_together(entrance%pair) .or. .not. abs(shear) > 0)
      end if
    end subroutine let_slide

  end subroutine accept_contacts

end module scree_open_close
