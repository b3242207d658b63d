!> The contacts in the iteration of one step: where they are, and their gaps and slips at a displacement.
module scree_contact_try
  use scree_contact_geometry, only: geometry_of, entrance_geometry_t
  use scree_contacts, only: contact_law_t, contact_t, state_open
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_shi_contact, only: add_edge, anchored_rows
  use scree_state, only: state_t
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: farthest_apart, gaps_and_slips, of_elements, place_contacts, contact_try_t

  integer, parameter :: n = 2*element_unknowns

  !> The contacts of a step, and what its iteration makes of them.
  type :: contact_try_t
    type(contact_law_t) :: law                           !! with the stiffness of this try
    type(contact_t), allocatable :: contact(:)
    integer, allocatable :: pair(:, :)                   !! (2, n_pairs) elements that the equations couple
    integer, allocatable :: inside(:, :)                 !! (2, n) vertices and the edges that they are inside of
    integer, allocatable :: nearby(:, :)                 !! (2, n) vertices and edges near enough to meet in the step
    real(dp), allocatable :: near(:)                     !! (n) how far a vertex may move in the step, length
    real(dp), allocatable :: local(:)                    !! (n) shorter edge at each vertex, length
    real(dp), allocatable :: turning(:)                  !! (n) how far the corner at each vertex may turn in the step, rad
    real(dp) :: margin = 0.0_dp                          !! of the way, beyond what velocity makes, length
    real(dp) :: swing = 0.0_dp                           !! of the turn, beyond what velocity makes, rad
    type(entrance_geometry_t), allocatable :: geometry(:, :) !! (2, n), gaps from where the springs rest
    real(dp), allocatable :: start_gap(:, :)             !! (2, n) at the beginning of the step, length
    real(dp), allocatable :: start_share(:, :)           !! (2, n) along the edge then
    logical, allocatable :: kept(:, :)                   !! (2, n) closed then: the anchor stays
    real(dp) :: dashpot = 0.0_dp                         !! viscosity over the size of the step, force/length
    logical :: bends = .false.                           !! the geometry follows the motion, else it is linear
    logical :: anchored = .false.                        !! slip is measured from the anchor, linear in displacements (Shi)
    real(dp), allocatable :: reference(:)                !! (n_unknowns) displacement that the geometry is of
    real(dp), allocatable :: rigidity(:)                 !! (n_elements) in an impact: against deforming, force/length
    real(dp), allocatable :: stress(:, :)                !! (3, n_elements) in an impact: of rigid ones, force/length^2
    real(dp), allocatable :: moved(:)                    !! (n_unknowns) displacement to the impact; 0 with small strain
    real(dp) :: weight = 1.0_dp                          !! of it in the configuration where forces act
    integer :: count(3) = 0                              !! contacts open, sliding, locked
    integer :: changes = 0                               !! of states, in the last judgement
  end type contact_try_t

contains

  !> Geometry of all contacts at a displacement.
  pure subroutine place_contacts(model, cache, state, weight, d, try)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(cache_t), intent(in) :: cache
    real(dp), intent(in) :: weight                !! of `d` in the configuration where the forces act
    real(dp), intent(in) :: d(:)                  !! (n_unknowns)
    type(contact_try_t), intent(inout) :: try
    integer :: i, k

    do i = 1, size(try%contact)
      do k = 1, try%contact(i)%n_entrances
        associate (entrance => try%contact(i)%entrance(k))
          try%geometry(k, i) = geometry_of(model, cache, state, try%pair(:, entrance%pair), entrance, try%bends, &
                                             weight, d)
          try%geometry(k, i)%gap = try%geometry(k, i)%gap - entrance%rest
          if (try%anchored) call add_edge(model, cache, state, try%pair(:, entrance%pair), entrance, try%geometry(k, i))
        end associate
      end do
    end do
    try%reference = d
  end subroutine place_contacts

  !> Gaps and slips of the lines of a contact at `d`.
  pure function gaps_and_slips(model, try, i, d) result(both)
    type(model_t), intent(in) :: model
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: i
    real(dp), intent(in) :: d(:)
    real(dp) :: both(2, 2) !! of the lines
    integer :: k

    both = 0.0_dp
    do k = 1, try%contact(i)%n_entrances
      both(:, k) = gap_and_slip(model, try, i, k, d)
    end do
  end function gaps_and_slips

  !> Values of the unknowns of two elements.
  pure function of_elements(model, pair, d)
    type(model_t), intent(in) :: model
    integer, intent(in) :: pair(2)
    real(dp), intent(in) :: d(:) !! (n_unknowns)
    real(dp) :: of_elements(n)

    of_elements(:n/2) = d(model%elements%unknown(:, pair(1)))
    of_elements(n/2 + 1:) = d(model%elements%unknown(:, pair(2)))
  end function of_elements

  !> Gap of a line and slip from its anchor at `d`, linear about the reference.
  pure function gap_and_slip(model, try, i, k, d) result(both)
    type(model_t), intent(in) :: model
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: i, k
    real(dp), intent(in) :: d(:)
    real(dp) :: both(2), change(n), rows(n, 2)

    associate (entrance => try%contact(i)%entrance(k), geometry => try%geometry(k, i))
      change = of_elements(model, try%pair(:, entrance%pair), d) - of_elements(model, try%pair(:, entrance%pair), try%reference)
      both = [geometry%gap + dot_product(geometry%normal_end, change), geometry%slid + dot_product(geometry%shear_end, change) &
              + (try%start_share(k, i) - entrance%anchor)*geometry%edge_length]
      if (.not. try%anchored) return
      rows = anchored_rows(geometry, entrance%anchor)
      both(2) = geometry%along + dot_product(rows(:, 2), change) - entrance%anchor*geometry%edge_length
    end associate
  end function gap_and_slip

  !> Largest gap and overlap of a closed contact at `d`.
  pure function farthest_apart(model, try, d) result(farthest)
    type(model_t), intent(in) :: model
    type(contact_try_t), intent(in) :: try
    real(dp), intent(in) :: d(:)              !! (n_unknowns)
    real(dp) :: both(2), farthest(2)
    integer :: i

    farthest = 0.0_dp
    do i = 1, size(try%contact)
      associate (contact => try%contact(i))
        if (contact%entrance(contact%active)%state == state_open) cycle
        both = gap_and_slip(model, try, i, contact%active, d)
        farthest = max(farthest, [both(1), -both(1)])
      end associate
    end do
  end function farthest_apart

end module scree_contact_try
