!> A fully grouted bolt where it crosses a joint: a spring along it and one across it, between the two bodies on both sides (local
!> reinforcement: Lorig, 26th US Symposium on Rock Mechanics, 1985).
!>
!> Grout holds the bolt along its whole length, so its springs are short and at the joint. Let d lead from the place of the crossing
!> in the first body to that in the second. Let q be the mean of the unit vectors that lay along the bolt in either body at the
!> start and have moved with them. Then
!>
!>     opening a = q.d,   slip s = q x d,   N = ka (a - a0) up to the strength along,   V = ks (s - s0) up to the strength across.
!>
!> A rotation of the whole scene turns q and d alike, so opening and slip are those of the bodies against each other. Both are of
!> second degree in y = (d, q), which is linear in the unknowns. With r their rows half-way of a step that changes y by D,
!> a1 - a0 = r.D exactly. So the force N r_a + V r_s, with the rows where the integrator balances, has the weights of bolts between
!> two points (`scree_bolt`). With rows in the middle its work is exactly the change of N^2/2ka + V^2/2ks, plus the yield. With rows
!> at the end it is the gradient of that energy. Forces and moments on the two bodies are opposite.
module scree_grouted_bolt
  use scree_element_term, only: step_rule_t
  use scree_kinds, only: dp
  implicit none
  private
  public :: has_symmetric_change, hold_together, openings, weigh, within_strength

  !> Weights that differ by less are the same.
  real(dp), parameter :: same = 1e-12_dp

contains

  !> Opening along a bolt and slip across it.
  pure function openings(y)
    real(dp), intent(in) :: y(4)   !! d, length, and q
    real(dp) :: openings(2)        !! length

    openings = [y(3)*y(1) + y(4)*y(2), y(3)*y(2) - y(4)*y(1)]
  end function openings

  !> Derivatives of opening and slip with respect to y.
  pure function rows_of(y)
    real(dp), intent(in) :: y(4)
    real(dp) :: rows_of(4, 2)

    rows_of(:, 1) = [y(3), y(4), y(1), y(2)]
    rows_of(:, 2) = [-y(4), y(3), y(2), -y(1)]
  end function rows_of

  !> Forces along and across, up to the strengths: along where it pulls, across to both sides.
  pure function within_strength(force, strength)
    real(dp), intent(in) :: force(2), strength(2)
    real(dp) :: within_strength(2)

    within_strength = [min(force(1), strength(1)), sign(min(abs(force(2)), strength(2)), force(2))]
  end function within_strength

  !> Force of a spring in a step, and the fraction of its stiffness with which it follows.
  !>
  !> The force goes from `start` to `reach`, or to `held` where the spring yields. It is weighted over the part of the step in which
  !> the spring is elastic, and is the force of the end for the rest. With weight 1/2 it is the mean over the step, whose work is
  !> the change of the energy plus `held` times the yield.
  elemental subroutine weigh(weight, start, reach, held, force, follows)
    real(dp), intent(in) :: weight           !! of the end of the step
    real(dp), intent(in) :: start, reach, held !! forces
    real(dp), intent(out) :: force, follows
    real(dp) :: share

    if (abs(reach) <= abs(held)) then
      force = start + weight*(held - start)
      follows = weight
    else
      share = (held - start)/(reach - start)
      force = held - (1 - weight)*share*(held - start)
      follows = (1 - weight)*share**2
    end if
  end subroutine weigh

  !> Whether what the force of a bolt changes by is symmetric with the weights of a step: a secant is, too.
  pure logical function has_symmetric_change(rule)
    type(step_rule_t), intent(in) :: rule

    has_symmetric_change = abs(rule%operator_weight - 1) < same .or. .not. rule%tangent
  end function has_symmetric_change

  !> Force against y of a crossing in a step, and what it changes by with y.
  pure subroutine hold_together(stiffness, strength, start, y, way, rule, force, change, symmetric)
    real(dp), intent(in) :: stiffness(2)     !! along and across, force/length per unit thickness
    real(dp), intent(in) :: strength(2)      !! force per unit thickness
    real(dp), intent(in) :: start(2)         !! forces when the step begins
    real(dp), intent(in) :: y(4)             !! then
    real(dp), intent(in) :: way(4)           !! that y went in the step so far
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(out) :: force(4), change(4, 4)
    logical, intent(out) :: symmetric        !! the change is
    real(dp) :: end_row(4, 2), follows(2), now(2), row(4, 2), unit(4), weighed(2)
    integer :: j, k

    now = start + stiffness*matmul(way, rows_of(y + 0.5_dp*way))
    call weigh(rule%stress_weight, start, now, within_strength(now, strength), weighed, follows)
    row = rows_of(y + rule%operator_weight*way)
    symmetric = has_symmetric_change(rule)
    end_row = merge(row, rows_of(y + way), symmetric)
    force = matmul(row, weighed)
    do k = 1, 4
      unit = 0.0_dp
      unit(k) = 1.0_dp
      change(:, k) = rule%operator_weight*matmul(rows_of(unit), weighed) ! rows are linear in y
      do j = 1, 2
        change(:, k) = change(:, k) + follows(j)*stiffness(j)*row(:, j)*end_row(k, j)
      end do
    end do
    if (rule%end_weight > 0 .and. rule%end_weight < 1) then
      force = rule%end_weight*force + (1 - rule%end_weight)*matmul(rows_of(y), start)
      change = rule%end_weight*change
    end if
  end subroutine hold_together

end module scree_grouted_bolt
