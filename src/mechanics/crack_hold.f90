!> Forces with which the two sides of new faces of cracks still hold each other.
!>
!> A cut leaves places, motion and stress as they are. The sides of the new faces exerted forces f on each other until then. They go
!> on to hold each other with s f, from s = 1, so the next step begins in balance. The factor s falls to 0 while the tip passes the
!> triangle (gradual release of a node: Malluck & King 1980). A static step lets all go at once. While the faces open by dw, growth
!> takes the energy -s f dw, in a step with the mean of s. From 1 to 0 in one step this is the crack closure integral f w/2 (Irwin
!> 1957; Rybicki & Kanninen 1977), exact where displacements are linear in forces.
!>
!> The forces are those on covers: f of a copy of a cover that a cut has made is the mean force of all copies less its own. Where
!> supports hold some of the copies, the sum of all is their reaction, and they share it alone.
module scree_crack_hold
  use scree_element_term, only: add_force, step_rule_t, term_t
  use scree_hold, only: hold_t
  use scree_interpolation, only: turned_vector
  use scree_kinds, only: dp
  use scree_system, only: element_unknowns, elements_t, values_of
  implicit none
  private
  public :: accept_hold, add_hold

  integer, parameter :: n_covers = element_unknowns/2 !! of an element

contains

  !> Adds the forces that hold an element.
  pure subroutine add_hold(hold, cover, rule, term)
    type(hold_t), intent(in) :: hold
    integer, intent(in) :: cover(:)            !! (n_covers) of the element
    type(step_rule_t), intent(in) :: rule
    type(term_t), intent(inout) :: term
    real(dp) :: force(2, n_covers), end_share
    integer :: i

    force = 0.0_dp
    end_share = rule%end_weight*rule%stress_weight ! the balance takes them where it takes the stress
    do i = 1, n_covers
      associate (p => hold%piece(cover(i)))
        if (p > 0) force(:, i) = (end_share*hold%next(p) + (1 - end_share)*hold%share(p))*hold%force(:, cover(i))
      end associate
    end do
    call add_force(term, reshape(force, [element_unknowns]))
  end subroutine add_hold

  !> Adds the energy that growth takes in a step, turns the forces with their blocks, and goes on to the next step.
  pure subroutine accept_hold(elements, d, angle, hold, fracture)
    type(elements_t), intent(in) :: elements
    real(dp), intent(in) :: d(:)               !! (n_unknowns) of the step
    real(dp), intent(in) :: angle(:)           !! (n_blocks) by which blocks have turned in it, rad
    type(hold_t), allocatable, intent(inout) :: hold !! not allocated any more: all is released
    real(dp), intent(inout) :: fracture        !! energy taken so far, force length per unit thickness
    real(dp) :: own(2, n_covers), turn(size(hold%piece))
    integer :: e, i, k

    turn = 0.0_dp
    do k = 1, size(elements%free)
      e = elements%free(k)
      if (all(hold%piece(elements%cover(:, e)) == 0)) cycle
      own = reshape(values_of(elements, e, d), [2, n_covers])
      do i = 1, n_covers
        associate (c => elements%cover(i, e), p => hold%piece(elements%cover(i, e)))
          if (p == 0) cycle
          fracture = fracture - 0.5_dp*(hold%share(p) + hold%next(p))*dot_product(hold%force(:, c), own(:, i))
          turn(c) = angle(elements%block(e))
        end associate
      end do
    end do
    do i = 1, size(turn)
      if (hold%piece(i) > 0) hold%force(:, i) = turned_vector(turn(i), [0.0_dp, 0.0_dp], hold%force(:, i))
    end do
    hold%share = hold%next
    if (.not. any(hold%share > 0)) deallocate (hold)
  end subroutine accept_hold

end module scree_crack_hold
