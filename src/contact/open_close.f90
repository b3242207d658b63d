!> The open-close iteration: which contacts are open, sliding or locked, and what their springs add to the equations
!> (Shi's df07, df18, df22).
!>
!> A closed contact is a spring p across its line and, locked, a spring along it that holds the vertex at its anchor:
!>
!>     N = -p g                      pressing where positive
!>     T = -k s,   s = a - w0 L      from the anchor, the share w0 of the edge
!>     |T| <= N tan phi + c l        else the contact slides: T = -+(N tan phi + c l), and the anchor follows
!>
!> Every iteration solves for the states of the one before, sliding with the normal force of the same solution, and then
!> judges all states anew (a semi-smooth Newton iteration). Nothing of this is kept but by `accept_contacts`.
module scree_open_close
  use scree_contact_geometry, only: geometry_of, line_geometry_t
  use scree_contacts, only: contact_law_t, contact_t, contacts_t, line_t, outlines_t, state_locked, state_open, state_sliding
  use scree_effects, only: element_share_t
  use scree_equations, only: add_link_equations, equations_t
  use scree_kinds, only: dp
  use scree_system, only: element_unknowns, state_t, system_t
  implicit none
  private
  public :: accept_contacts, add_contacts, begin_contacts, judge_contacts, place_contacts, slides_with_friction, touch_t

  integer, parameter :: n = 2*element_unknowns

  !> A force below this share of the largest contact force changes no state.
  real(dp), parameter :: faint = 1e-8_dp
  !> A gap below this share of the edge is round-off.
  real(dp), parameter :: round_off = 1e-13_dp

  !> The contacts in the iteration of one step.
  type :: touch_t
    type(contact_t), allocatable :: contact(:)
    integer, allocatable :: link(:, :)                   !! (2, n_links) pairs of elements
    type(line_geometry_t), allocatable :: geometry(:, :) !! (2, n)
    real(dp), allocatable :: start_gap(:, :)             !! (2, n) at the beginning of the step, length
    real(dp), allocatable :: start_share(:, :)           !! (2, n) along the edge then
    real(dp), allocatable :: reference(:)                !! (n_unknowns) displacement that the geometry is of
    integer :: count(3) = 0                              !! contacts open, sliding, locked
    integer :: changes = 0                               !! of states, in the last judgement
  end type touch_t

contains

  !> The contacts as the step finds them.
  pure subroutine begin_contacts(system, state, share, large, weight, touch)
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    type(element_share_t), intent(in) :: share(:) !! (n_elements)
    logical, intent(in) :: large
    real(dp), intent(in) :: weight
    type(touch_t), intent(out) :: touch
    integer :: k, m

    touch%contact = state%contacts%contact
    touch%link = state%contacts%link
    m = size(touch%contact)
    allocate (touch%geometry(2, m))
    allocate (touch%reference(system%n_unknowns), source=0.0_dp)
    call place_contacts(system, state, share, large, weight, touch%reference, touch)
    touch%start_gap = touch%geometry%gap
    do k = 1, 2
      where (touch%contact%line(k)%state /= state_open) touch%start_gap(k, :) = 0.0_dp ! it keeps its anchor
    end do
    touch%start_share = touch%geometry%along/touch%geometry%edge_length
  end subroutine begin_contacts

  !> Geometry of all contacts at a displacement.
  pure subroutine place_contacts(system, state, share, large, weight, d, touch)
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    type(element_share_t), intent(in) :: share(:) !! (n_elements)
    logical, intent(in) :: large                  !! geometry of the place where `d` leads, else linear
    real(dp), intent(in) :: weight                !! of `d` in the configuration where the forces act
    real(dp), intent(in) :: d(:)                  !! (n_unknowns)
    type(touch_t), intent(inout) :: touch
    integer :: i, k

    do i = 1, size(touch%contact)
      do k = 1, touch%contact(i)%n_lines
        associate (line => touch%contact(i)%line(k))
          touch%geometry(k, i) = geometry_of(system, state, share, system%outlines, touch%link(:, line%link), line, large, &
                                             weight, d)
        end associate
      end do
    end do
    touch%reference = d
  end subroutine place_contacts

  !> Gap and place along the edge of a line at `d`, linear about the reference.
  pure function gap_and_along(system, touch, i, k, d) result(both)
    type(system_t), intent(in) :: system
    type(touch_t), intent(in) :: touch
    integer, intent(in) :: i, k
    real(dp), intent(in) :: d(:)
    real(dp) :: both(2), change(n)

    associate (link => touch%link(:, touch%contact(i)%line(k)%link), geometry => touch%geometry(k, i))
      change(:n/2) = d(system%elements%unknown(:, link(1))) - touch%reference(system%elements%unknown(:, link(1)))
      change(n/2 + 1:) = d(system%elements%unknown(:, link(2))) - touch%reference(system%elements%unknown(:, link(2)))
      both = [geometry%gap + dot_product(geometry%normal_end, change), geometry%along + dot_product(geometry%shear_end, change)]
    end associate
  end function gap_and_along

  !> Judges every contact at `d`; `touch%changes` counts states that change by more than a faint force.
  !>
  !> The first judgement, of a prediction, only closes: what was closed is taken to stay as it was. A cautious one lets
  !> contacts open or lock again only where none closes or begins to slide, so that no two take turns for ever.
  pure subroutine judge_contacts(system, law, d, first, cautious, touch)
    type(system_t), intent(in) :: system
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    logical, intent(in) :: first, cautious
    type(touch_t), intent(inout) :: touch
    real(dp) :: place(2, 2, size(touch%contact)), deepest, doubt
    integer :: i, k, new(size(touch%contact))
    logical :: forward

    deepest = 0.0_dp
    do i = 1, size(touch%contact)
      do k = 1, touch%contact(i)%n_lines
        place(:, k, i) = gap_and_along(system, touch, i, k, d)
      end do
      deepest = max(deepest, -maxval(place(1, :touch%contact(i)%n_lines, i)))
    end do
    touch%changes = 0
    forward = .false.
    do i = 1, size(touch%contact)
      associate (contact => touch%contact(i))
        new(i) = contact%line(contact%active)%state
        if (first .and. new(i) /= state_open) cycle
        doubt = faint*deepest + round_off*touch%geometry(1, i)%edge_length
        k = 1
        if (contact%n_lines == 2) then
          if (place(1, 2, i) > place(1, 1, i)) k = 2
          if (contact%active /= k .and. abs(place(1, 2, i) - place(1, 1, i)) <= doubt) k = contact%active
        end if
        if (k /= contact%active) then
          if (contact%line(contact%active)%state /= state_open) touch%changes = touch%changes + 1
          contact%line(contact%active)%state = state_open
          contact%active = k
        end if
        associate (line => contact%line(k))
          call judge(place(1, k, i), place(2, k, i), touch%geometry(k, i)%edge_length, touch%start_gap(k, i), &
                     touch%start_share(k, i), doubt, line, new(i))
          if (first .and. new(i) /= state_open) new(i) = state_locked
          if (new(i) == line%state) cycle
          forward = forward .or. line%state == state_open .or. new(i) == state_sliding
          if (merge(abs(place(1, k, i)), huge(doubt), min(new(i), line%state) == state_open) > doubt) &
            touch%changes = touch%changes + 1
        end associate
      end associate
    end do
    touch%count = 0
    do i = 1, size(touch%contact)
      associate (line => touch%contact(i)%line(touch%contact(i)%active))
        if (.not. (cautious .and. forward) .or. line%state == state_open .or. new(i) == state_sliding) line%state = new(i)
        touch%count(1 + line%state) = touch%count(1 + line%state) + 1
      end associate
    end do

  contains

    !> New state of a line. A line that was open at the beginning of the step gets its anchor where it closes.
    pure subroutine judge(gap, along, length, start_gap, start_share, doubt, line, state)
      real(dp), intent(in) :: gap, along, length, start_gap, start_share, doubt
      type(line_t), intent(inout) :: line
      integer, intent(out) :: state
      real(dp) :: limit, slip, strength

      strength = 0.0_dp
      if (line%bonded) strength = law%strength(system%outlines%joint(line%edge))*line%length/law%normal_stiffness
      if (gap > strength) then
        state = state_open
        return
      end if
      if (start_gap > 0 .and. .not. line%bonded) line%anchor = start_share + min(1.0_dp, start_gap/(start_gap - gap)) &
                                                               *(along/length - start_share)
      limit = max(0.0_dp, friction_limit(system%outlines, law, line, gap))
      slip = along - line%anchor*length
      associate (excess => law%shear_stiffness*abs(slip) - limit, sure => law%normal_stiffness*doubt)
        if (line%state == state_sliding .and. law%friction(system%outlines%joint(line%edge)) > 0 &
            .and. line%direction*slip < 0) then
          state = state_locked ! it turned back; whether it slides there the next iteration tells
        else if (line%state /= state_open .and. abs(excess) <= sure) then
          state = line%state
        else
          state = merge(state_locked, state_sliding, excess < 0)
        end if
      end associate
      if (state == state_sliding) line%direction = sign(1.0_dp, slip)
    end subroutine judge

  end subroutine judge_contacts

  !> Largest shear force that a closed contact carries, linear in the gap.
  pure real(dp) function friction_limit(outlines, law, line, gap) result(limit)
    type(outlines_t), intent(in) :: outlines
    type(contact_law_t), intent(in) :: law
    type(line_t), intent(in) :: line
    real(dp), intent(in) :: gap       !! length

    associate (joint => outlines%joint(line%edge))
      limit = -law%friction(joint)*law%normal_stiffness*gap
      if (line%bonded) limit = limit + law%cohesion(joint)*line%length
    end associate
  end function friction_limit

  !> Whether a contact slides with a force that follows the normal one: the equations are then not symmetric.
  pure logical function slides_with_friction(outlines, law, touch)
    type(outlines_t), intent(in) :: outlines
    type(contact_law_t), intent(in) :: law
    type(touch_t), intent(in) :: touch
    integer :: i

    slides_with_friction = .false.
    do i = 1, size(touch%contact)
      associate (line => touch%contact(i)%line(touch%contact(i)%active))
        slides_with_friction = slides_with_friction .or. &
          (line%state == state_sliding .and. law%friction(outlines%joint(line%edge)) > 0)
      end associate
    end do
  end function slides_with_friction

  !> Adds the springs of all closed contacts at `d`.
  subroutine add_contacts(system, law, d, symmetric, touch, equations)
    type(system_t), intent(in) :: system
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: d(:)          !! (n_unknowns)
    logical, intent(in) :: symmetric      !! operator of the iteration, where the geometry is not linear
    type(touch_t), intent(in) :: touch
    type(equations_t), intent(inout) :: equations
    real(dp) :: matrix(n, n, size(touch%link, 2)), force(n, size(touch%link, 2)), scale(n, size(touch%link, 2))
    real(dp) :: both(2), normal_force, shear_force, limit, slip, change(n)
    integer :: i

    matrix = 0.0_dp
    force = 0.0_dp
    scale = 0.0_dp
    do i = 1, size(touch%contact)
      associate (k => touch%contact(i)%active, line => touch%contact(i)%line(touch%contact(i)%active))
        if (line%state == state_open) cycle
        associate (geometry => touch%geometry(k, i), p => law%normal_stiffness)
          both = gap_and_along(system, touch, i, k, d)
          normal_force = -p*both(1)
          change = merge(geometry%normal, geometry%normal_end, symmetric)
          call add(line%link, p, geometry%normal, change, normal_force)
          slip = both(2) - line%anchor*geometry%edge_length
          if (line%state == state_locked) then
            shear_force = -law%shear_stiffness*slip
            call add(line%link, law%shear_stiffness, geometry%shear, merge(geometry%shear, geometry%shear_end, symmetric), &
                     shear_force)
          else
            limit = friction_limit(system%outlines, law, line, both(1))
            shear_force = -line%direction*limit
            call add(line%link, -line%direction*law%friction(system%outlines%joint(line%edge))*p, geometry%shear, change, &
                     shear_force)
          end if
        end associate
      end associate
    end do
    call add_link_equations(equations, matrix, force, scale)

  contains

    !> Adds a force along a row, and the matrix of its change with another.
    subroutine add(link, stiffness, row, changes_with, strength)
      integer, intent(in) :: link
      real(dp), intent(in) :: stiffness, row(n), changes_with(n), strength
      integer :: j

      do j = 1, n
        matrix(:, j, link) = matrix(:, j, link) + (stiffness*changes_with(j))*row
      end do
      force(:, link) = force(:, link) + strength*row
      scale(:, link) = scale(:, link) + abs(strength*row)
    end subroutine add

  end subroutine add_contacts

  !> What the contacts of an accepted step remember: states, anchors, lost bonds, overlap, friction.
  pure subroutine accept_contacts(system, law, d, touch, contacts)
    type(system_t), intent(in) :: system
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: d(:)              !! (n_unknowns) of the step
    type(touch_t), intent(in) :: touch
    type(contacts_t), intent(inout) :: contacts
    real(dp) :: both(2), limit, slip, stretch
    integer :: i

    contacts%contact = touch%contact
    contacts%count = touch%count
    contacts%overlap = 0.0_dp
    contacts%energy = 0.0_dp
    do i = 1, size(contacts%contact)
      associate (k => contacts%contact(i)%active, line => contacts%contact(i)%line(contacts%contact(i)%active))
        if (line%state == state_open) then
          line%bonded = .false.
          cycle
        end if
        both = gap_and_along(system, touch, i, k, d)
        associate (length => touch%geometry(k, i)%edge_length)
          slip = both(2) - line%anchor*length
          limit = friction_limit(system%outlines, law, line, both(1))
          if (line%state == state_sliding) then
            stretch = line%direction*limit/law%shear_stiffness
            contacts%friction = contacts%friction + limit*abs(slip - stretch)
            slip = stretch
            line%anchor = (both(2) - slip)/length
            line%bonded = .false.
          end if
        end associate
        contacts%overlap = max(contacts%overlap, -both(1))
        contacts%energy = contacts%energy + 0.5_dp*(law%normal_stiffness*both(1)**2 + law%shear_stiffness*slip**2)
      end associate
    end do
  end subroutine accept_contacts

end module scree_open_close
