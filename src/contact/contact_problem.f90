!> The contacts of a step as springs of a friction problem, and back: their lines, anchors and bonds stay.
module scree_contact_problem
  use scree_bond_rules, only: bond
  use scree_contact_quantities, only: gap_and_slip_t
  use scree_contact_rules, only: acts_by_another, anchor_what_closes, gaps_and_slips, rows_along, spring_of
  use scree_contact_try, only: contact_try_t, row_across
  use scree_contacts, only: state_locked, state_open, state_sliding
  use scree_equations, only: equations_t, island_problem, place_row
  use scree_friction_problem, only: friction_problem_t, spring_back, spring_forth, spring_locked, spring_open, &
                                    spring_pulled
  use scree_joint_rules, only: friction_of
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: pose_problem, take_states

  integer, parameter :: n = 2*element_unknowns

contains

  !> Poses the problem of an island at `d`, for a correction of it, with the entrances that act. The equations hold what
  !> the elements add.
  !>
  !> Contacts that are open get the anchors that they would close at.
  subroutine pose_problem(model, try, group, d, equations, problem)
    type(model_t), intent(in) :: model
    type(contact_try_t), intent(inout) :: try !! of which the contacts of the island are settled
    integer, intent(in) :: group              !! of the island
    real(dp), intent(in) :: d(:)             !! (n_unknowns)
    type(equations_t), intent(in) :: equations
    type(friction_problem_t), intent(out) :: problem
    type(gap_and_slip_t) :: now(2)
    real(dp) :: row(n, 4)
    integer :: i

    call island_problem(equations, group, try%last - try%first + 1, problem)
    do i = try%first, try%last
      now = gaps_and_slips(model, try, i, d)
      call anchor_what_closes(try, i, now)
      associate (k => try%contact(i)%active, entrance => try%contact(i)%entrance(try%contact(i)%active), &
                 spring => problem%spring(i - try%first + 1))
        call spring_of(try, i, now, spring%pressing, spring%stiffness)
        spring%shear = entrance%multiplier(2) - entrance%stiffness(2)*now(k)%slip
        spring%shear_stiffness = entrance%stiffness(2)
        spring%friction = friction_of(try%law, entrance)
        spring%bonded = entrance%memory%bonded .and. entrance%state /= state_open
        if (spring%bonded) spring%cohesion = bond(entrance, try%law%joint(entrance%joint)%cohesion)
        row(:, 1) = row_across(try, i, k)
        call rows_along(try, i, k, row(:, 2), row(:, 4))
        row(:, 3) = try%geometry(k, i)%normal
        associate (opening => try%start(k, i)%opening)
          if (abs(opening%by_slip) > 0) row(:, 3) = row(:, 3) - opening%by_slip*row(:, 4)
        end associate
        if (acts_by_another(try, i)) then ! it stays open
          row = 0.0_dp
          spring%pressing = -spring%stiffness*now(k)%edge_length
        end if
        call place_row(equations, group, equations%place_of(entrance%pair), i - try%first + 1, row, problem)
      end associate
    end do
    problem%symmetric = all(abs(problem%normal - problem%normal_change) <= 0) .and. &
                        all(abs(problem%shear - problem%shear_change) <= 0)
  end subroutine pose_problem

  !> Gives the contacts that are settled the states of the problem's springs; those that are elsewhere keep their own.
  pure subroutine take_states(state, try)
    integer, intent(in) :: state(:)
    type(contact_try_t), intent(inout) :: try
    integer :: i

    do i = try%first, try%last
      associate (entrance => try%contact(i)%entrance(try%contact(i)%active))
        select case (state(i - try%first + 1))
        case (spring_open)
          entrance%state = state_open
        case (spring_locked)
          entrance%state = state_locked
        case (spring_forth)
          entrance%state = state_sliding
          entrance%direction = 1.0_dp
        case (spring_back)
          entrance%state = state_sliding
          entrance%direction = -1.0_dp
        case (spring_pulled)
          entrance%state = state_sliding
          entrance%direction = 0.0_dp
        end select
      end associate
    end do
  end subroutine take_states

end module scree_contact_problem
