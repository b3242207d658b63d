!> The contacts as a step finds them (Shi's df07).
module scree_contact_beginning
  use scree_contact_lists, only: entrances_t
  use scree_contact_pairs, only: contact_of, has_same_entrances, list_entrances
  use scree_contact_rules, only: begin_contact, bonds_by_length, decides_outside, has_bonds, keeps_stiffness, place
  use scree_contact_try, only: contact_try_t
  use scree_contacts, only: entrance_t, outlines_t, state_locked
  use scree_effects, only: weights_of_blocks
  use scree_element_term, only: step_rule_t
  use scree_joint_rules, only: joints_follow_stress
  use scree_joint_stiffness, only: bonded_entrance, keep_stiffness, mean_of_bonds, measure_bond, measure_contact, stiffen_contact
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_regions, only: first_vertex_of, last_vertex_of
  use scree_state, only: state_t, step_of_run
  implicit none
  private
  public :: begin_again, begin_contacts, go_on_from

  !> Rounding of a gap over the largest coordinate: of three places, in the step and in the one before.
  real(dp), parameter :: round_off = 8*epsilon(1.0_dp)
  !> Gap that rounded numbers of a file leave between touching bodies, over the length that a contact stands for.
  real(dp), parameter :: of_a_file = 1e-4_dp

contains

  !> Places the contacts of a step at its beginning. Those of the first step are bonded where their joint has cohesion or strength.
  pure subroutine begin_contacts(model, cache, state, rule, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(step_rule_t), intent(in) :: rule
    type(contact_try_t), intent(inout) :: try     !! with the contacts that were found
    real(dp) :: at_rest(model%n_unknowns)
    real(dp), allocatable :: bonds(:)             ! length that those about each stand for on the mean
    logical :: first_of_run, measures
    integer :: i

    try%linear = .not. any(cache%element%green)
    try%weight = rule%operator_weight
    try%dashpot = try%law%viscosity/rule%dt
    try%first = 1
    try%last = size(try%contact)
    try%count = 0
    try%changes = 0
    first_of_run = step_of_run(state) == 0
    if (allocated(try%geometry)) deallocate (try%geometry, try%start, try%now)
    if (allocated(try%edge)) deallocate (try%edge)
    if (allocated(try%acting)) deallocate (try%acting)
    allocate (try%geometry(2, size(try%contact)), try%start(2, size(try%contact)), try%now(2, size(try%contact)))
    if (.not. try%linear .or. allocated(model%effects%bolt)) allocate (try%acting(2, size(try%contact)))
    if (.not. allocated(try%largest)) allocate (try%largest(model%n_blocks))
    try%block_weight = weights_of_blocks(model, rule)
    try%force_tolerance = [(0.0_dp, i=1, size(try%contact))]
    try%rounding = round_off*largest_coordinate(model, cache, state)
    at_rest = 0.0_dp
    call place(model, cache, state, at_rest, try)
    if (first_of_run) call bond_contacts(model%outlines, state%vertex, try)
    bonds = [(0.0_dp, i=1, size(try%contact))]
    if (first_of_run .and. bonds_by_length(try%law)) bonds = mean_of_bonds(model%outlines, try%law, try%contact)
    measures = joints_follow_stress(try%law)
    do i = 1, size(try%contact)
      if (keeps_stiffness(try%law, try%contact(i))) then
        call keep_stiffness(try%contact(i))
      else
        call stiffen_contact(model%outlines, state%vertex, try%law, first_of_run, bonds(i), try%contact(i))
      end if
      if (measures) call measure_contact(model%outlines, state%vertex, try%law, try%contact(i))
      call begin_contact(first_of_run, i, try)
    end do
    if (first_of_run .and. decides_outside(try%law)) call close_bonds(try)
  end subroutine begin_contacts

  !> Largest coordinate of a vertex, of which those of elements that cannot move are known, length.
  pure real(dp) function largest_coordinate(model, cache, state) result(largest)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    integer :: k

    largest = cache%fixed_extent
    associate (shape => model%elements%shape, free => model%elements%free)
      do k = 1, size(free)
        largest = max(largest, maxval(abs(state%vertex(:, first_vertex_of(shape, free(k)):last_vertex_of(shape, free(k))))))
      end do
    end associate
  end function largest_coordinate

  !> The contacts of a step that is tried again, as Shi's programs leave them: in the states of the last judgement.
  pure subroutine begin_again(rule, try)
    type(step_rule_t), intent(in) :: rule
    type(contact_try_t), intent(inout) :: try
    integer :: i, k

    try%dashpot = try%law%viscosity/rule%dt
    do i = 1, size(try%contact)
      do k = 1, 2
        try%contact(i)%entrance(k)%lagged_friction = 0.0_dp
        try%contact(i)%entrance(k)%stiffness = [try%law%normal_stiffness, try%law%shear_stiffness]
      end do
    end do
  end subroutine begin_again

  !> Lets the contacts of a step that is made anew with a wider search go on as the try before left them, each that was there.
  pure subroutine go_on_from(before, n, try)
    type(contact_try_t), intent(in) :: before
    integer, intent(in) :: n                      !! vertices of the outlines
    type(contact_try_t), intent(inout) :: try
    type(entrances_t) :: entrances
    integer :: i, j, place

    call list_entrances(before%contact, n, entrances)
    do i = 1, size(try%contact)
      associate (contact => try%contact(i), vertex => try%contact(i)%entrance(1)%vertex)
        do place = entrances%first(vertex), entrances%last(vertex)
          j = contact_of(entrances%number(place))
          associate (was => before%contact(j))
            if (.not. has_same_entrances(was, contact)) cycle
            if ((was%stands_for_both .neqv. contact%stands_for_both) .or. was%covered_line /= contact%covered_line) cycle
            contact%active = was%active
            contact%entrance = going_on(was%entrance, contact%entrance%pair)
            try%start(:, i) = before%start(:, j)
          end associate
        end do
      end associate
    end do
  end subroutine go_on_from

  !> An entrance as it was, of a pair that has another number now.
  elemental type(entrance_t) function going_on(was, pair) result(entrance)
    type(entrance_t), intent(in) :: was
    integer, intent(in) :: pair

    entrance = was
    entrance%pair = pair
  end function going_on

  !> Closes bonds. Their springs rest at the rounded positions of a file, so no displacement of an iteration opens them.
  pure subroutine close_bonds(try)
    type(contact_try_t), intent(inout) :: try
    integer :: i, k

    do i = 1, size(try%contact)
      k = bonded_entrance(try%contact(i))
      if (k == 0) cycle
      associate (contact => try%contact(i), entrance => try%contact(i)%entrance(k), start => try%start(k, i), &
                 geometry => try%geometry(k, i))
        contact%active = k
        entrance%state = state_locked
        entrance%rest = entrance%rest + max(0.0_dp, start%gap)
        geometry%gap = min(0.0_dp, geometry%gap)
        start%gap = geometry%gap
      end associate
    end do
  end subroutine close_bonds

  !> Bonds the contacts of joints that have bonds, where they have no gap, but for the rounding of a file.
  pure subroutine bond_contacts(outlines, position, try)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :) !! (2, n_vertices), length
    type(contact_try_t), intent(inout) :: try
    logical :: bonds(size(try%law%joint)) ! contacts of each joint
    integer :: i, k

    bonds = has_bonds(try%law)
    if (.not. any(bonds)) return
    do i = 1, size(try%contact)
      do k = 1, try%contact(i)%n_entrances
        associate (entrance => try%contact(i)%entrance(k))
          call measure_bond(outlines, position, try%law, bonds, try%contact(i)%stands_for_both, entrance)
          if (decides_outside(try%law) .and. try%geometry(k, i)%gap > max(try%rounding, of_a_file*entrance%memory%length)) &
            entrance%memory%bonded = .false.
        end associate
      end do
    end do
  end subroutine bond_contacts

end module scree_contact_beginning
