!> The contacts as a step finds them (Shi's df07).
module scree_contact_beginning
  use scree_contact_geometry, only: frame_of_edge
  use scree_contact_rules, only: begin_contact, place
  use scree_contact_try, only: contact_try_t
  use scree_contacts, only: entrance_t, outlines_t, parallel
  use scree_element_term, only: step_rule_t
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_state, only: state_t
  implicit none
  private
  public :: begin_again, begin_contacts

contains

  !> Places the contacts of a step at its beginning. Those of the first step are bonded where their joint has cohesion or strength.
  pure subroutine begin_contacts(model, cache, state, rule, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(step_rule_t), intent(in) :: rule
    type(contact_try_t), intent(inout) :: try     !! with the contacts that were found
    real(dp) :: at_rest(model%n_unknowns)
    integer :: i

    try%linear = .not. model%effects%large_deformation
    try%weight = rule%operator_weight
    try%dashpot = try%law%viscosity/rule%dt
    try%count = 0
    try%changes = 0
    if (state%step == 0) call bond_contacts(model%outlines, state%vertex, try)
    if (allocated(try%geometry)) deallocate (try%geometry, try%start)
    allocate (try%geometry(2, size(try%contact)), try%start(2, size(try%contact)))
    at_rest = 0.0_dp
    call place(model, cache, state, at_rest, try)
    do i = 1, size(try%contact)
      call begin_contact(state%step == 0, i, try)
    end do
  end subroutine begin_contacts

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

  !> Bonds the contacts of joints with cohesion or strength.
  pure subroutine bond_contacts(outlines, position, try)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :) !! (2, n_vertices), length
    type(contact_try_t), intent(inout) :: try
    integer :: i, k

    do i = 1, size(try%contact)
      do k = 1, try%contact(i)%n_entrances
        associate (entrance => try%contact(i)%entrance(k), joint => outlines%joint(try%contact(i)%entrance(k)%edge))
          if (try%law%cohesion(joint) > 0 .or. try%law%strength(joint) > 0) &
            entrance%length = length_of_contact(outlines, position, entrance)
          entrance%bonded = entrance%length > 0
        end associate
      end do
    end do
  end subroutine bond_contacts

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

end module scree_contact_beginning
