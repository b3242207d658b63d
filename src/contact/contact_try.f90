!> The contacts in the iteration of one step.
module scree_contact_try
  use scree_anderson, only: anderson_t
  use scree_contact_geometry, only: acting_rows_t, entrance_geometry_t
  use scree_contact_quantities, only: entrance_start_t, gap_and_slip_t
  use scree_contacts, only: contact_law_t, contact_t, count_states, state_open
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_system, only: element_unknowns, values_of
  implicit none
  private
  public :: contact_try_t, edges_stay, elements_of, follow_motion, of_elements, row_across, states_of, take_all, take_island

  integer, parameter :: n = 2*element_unknowns
  !> Times that the damage of bonds may follow in a step how far they open; in the second half it only grows.
  integer, parameter, public :: most_softenings = 30

  !> The contacts of a step, and the data of its iteration.
  type :: contact_try_t
    logical :: looked = .false.                          !! for contacts: it has the law
    type(contact_law_t) :: law                           !! with the stiffness of this try
    type(contact_t), allocatable :: contact(:)           !! in the order of their islands
    integer, allocatable :: of_island(:)                 !! (n_islands+1) island i has contact(of_island(i):of_island(i+1)-1)
    integer :: first = 1, last = 0                       !! contacts that are settled together now
    integer, allocatable :: pair(:, :)                   !! (2, n_pairs) elements that the equations couple
    integer, allocatable :: inside(:, :)                 !! (2, n) vertices, each with the edge that it is inside of
    integer, allocatable :: nearby(:, :)                 !! (2, n) vertices and edges near enough to meet in the step
    real(dp), allocatable :: extra_reach(:)              !! (n_blocks) displacement beyond the velocity that is looked at, length
    real(dp), allocatable :: extra_turn(:)               !! (n_blocks) turn beyond the velocity that is looked at, rad
    real(dp), allocatable :: pressed(:)                  !! (n_blocks) largest overlap of a spring in the step before, length
    real(dp), allocatable :: jumped(:)                  !! (n_unknowns) displacement of a try before that jumped
    logical :: goes_on = .false.                         !! from the displacement of a try before, which settled
    logical :: linear = .true.                           !! gaps and slips are, in displacements; else some follow the motion
    real(dp) :: weight = 1.0_dp                          !! of the displacement in the configuration where forces act
    real(dp) :: left = huge(1.0_dp)                      !! largest gap or overlap above the bound of multipliers, length
    real(dp) :: dashpot = 0.0_dp                         !! viscosity over the size of the step, force/length
    type(entrance_start_t), allocatable :: start(:, :)   !! (2, n)
    type(entrance_geometry_t), allocatable :: geometry(:, :) !! (2, n), gaps from where the springs rest
    type(acting_rows_t), allocatable :: acting(:, :)     !! (2, n) likewise, where any may follow the motion
    real(dp), allocatable :: edge(:, :, :, :)            !! (3, n, 2, n) of these, where slip is measured from the anchor (Shi)
    type(gap_and_slip_t), allocatable :: now(:, :)       !! (2, n) as they were measured last, from anchors as they are
    real(dp) :: rounding = 0.0_dp                        !! that places have, length
    real(dp), allocatable :: block_weight(:)             !! (n_blocks) in the step, force per unit thickness
    real(dp), allocatable :: largest(:)                  !! (n_blocks) force: weight, and across the contacts judged last
    real(dp), allocatable :: force_tolerance(:)          !! (n) force that changes no state, where contacts were judged last
    logical :: all_clear = .false.                       !! bodies that no other is near went no farther than is looked at there
    logical :: pulls_fall = .true.                       !! of bonds that soften, as they open; else they are constant
    integer :: softenings = 0                            !! times that the damage of bonds has followed in the step
    type(anderson_t) :: damages                          !! what that iteration remembers of the damage
    logical :: lines_stay = .false.                      !! entrances that act, and anchors, as they are
    integer :: count(3) = 0                              !! contacts open, sliding, locked
    integer :: changes = 0                               !! of states, in the last judgement
  contains
    procedure :: softens_on
  end type contact_try_t

contains

  !> Whether the damage of bonds has followed too often in the step.
  pure logical function softens_on(self)
    class(contact_try_t), intent(in) :: self

    softens_on = self%softenings > most_softenings
  end function softens_on

  !> Takes the contacts of an island, which settle together, each island anew.
  pure subroutine take_island(try, island, any_contact)
    type(contact_try_t), intent(inout) :: try
    integer, intent(in) :: island         !! none below 1
    logical, intent(out) :: any_contact   !! it has some

    any_contact = .false.
    if (island < 1) return
    try%first = try%of_island(island)
    try%last = try%of_island(island + 1) - 1
    try%left = huge(try%left)
    try%lines_stay = .false.
    try%pulls_fall = .true.
    try%softenings = 0
    try%damages = anderson_t()
    try%changes = 0
    any_contact = try%last >= try%first
  end subroutine take_island

  !> Takes all contacts, when their islands have settled.
  pure subroutine take_all(try)
    type(contact_try_t), intent(inout) :: try

    try%first = 1
    try%last = size(try%contact)
    try%count = count_states(try%contact)
  end subroutine take_all

  !> States of the entrances of the contacts that are settled together.
  pure function states_of(try) result(states)
    type(contact_try_t), intent(in) :: try
    integer :: states(2, try%last - try%first + 1)

    states(1, :) = try%contact(try%first:try%last)%entrance(1)%state
    states(2, :) = try%contact(try%first:try%last)%entrance(2)%state
  end function states_of

  !> Whether the edges of the closed contacts that are settled together cannot move: their gaps and slips are linear then.
  pure logical function edges_stay(model, try)
    type(model_t), intent(in) :: model
    type(contact_try_t), intent(in) :: try
    integer :: i

    edges_stay = .true.
    do i = try%first, try%last
      associate (contact => try%contact(i))
        if (contact%entrance(contact%active)%state == state_open) cycle
        edges_stay = edges_stay .and. all(model%outlines%fixed(contact%entrance(:contact%n_entrances)%edge))
      end associate
    end do
  end function edges_stay

  !> Lets contacts follow the motion from here on, each as it is placed the next time.
  pure subroutine follow_motion(try)
    type(contact_try_t), intent(inout) :: try
    integer :: i, k

    try%linear = .false.
    if (allocated(try%acting) .or. .not. allocated(try%geometry)) return
    allocate (try%acting(2, size(try%contact)))
    do i = 1, size(try%contact)
      do k = 1, try%contact(i)%n_entrances
        try%acting(k, i) = acting_rows_t(0.0_dp, try%geometry(k, i)%normal, try%geometry(k, i)%shear, 0.0_dp)
      end do
    end do
  end subroutine follow_motion

  !> Row of the force across entrance k of contact i, where it acts.
  pure function row_across(try, i, k) result(row)
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: i, k
    real(dp) :: row(n)

    if (allocated(try%acting)) then
      row = try%acting(k, i)%normal
    else
      row = try%geometry(k, i)%normal
    end if
  end function row_across

  !> Elements of entrance k of contact i, in the order of the unknowns.
  pure function elements_of(try, i, k) result(pair)
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: i, k
    integer :: pair(2)

    pair = try%pair(:, try%contact(i)%entrance(k)%pair)
  end function elements_of

  !> Values of the unknowns of two elements.
  pure function of_elements(model, pair, d)
    type(model_t), intent(in) :: model
    integer, intent(in) :: pair(2)
    real(dp), intent(in) :: d(:) !! (n_unknowns)
    real(dp) :: of_elements(n)

    of_elements(:n/2) = values_of(model%elements, pair(1), d)
    of_elements(n/2 + 1:) = values_of(model%elements, pair(2), d)
  end function of_elements

end module scree_contact_try
