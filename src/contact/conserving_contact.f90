!> Contact that gives back in a step all that it takes: the mean of a spring's force over the way from the gaps at the beginning
!> of the step to those at its end, each line of two for the part of the way on which its gap is the larger (doc/theory.md).
module scree_conserving_contact
  use scree_kinds, only: dp
  implicit none
  private
  public :: mean_depths

contains

  !> Mean overlap of each line over a straight way of the gaps, while its gap is the larger, and its changes with the gaps at the
  !> end: (mean, d/dg1, d/dg2).
  pure function mean_depths(n_entrances, start_gap, gap) result(mean)
    integer, intent(in) :: n_entrances
    real(dp), intent(in) :: start_gap(2), gap(2) !! length
    real(dp) :: mean(3, 2)
    real(dp) :: ahead(2), turn, depth
    integer :: k

    mean = 0.0_dp
    turn = 0.0_dp ! share of the way on which the line that is ahead at the end is not
    k = 1
    if (n_entrances == 2) then
      if (gap(2) > gap(1)) k = 2
      ahead = [start_gap(k) - start_gap(3 - k), gap(k) - gap(3 - k)]
      if (ahead(1) < 0) turn = ahead(1)/(ahead(1) - ahead(2))
    end if
    mean([1, 1 + k], k) = mean_depth(start_gap(k), gap(k), turn, 1.0_dp)
    if (.not. turn > 0) return
    mean([1, 4 - k], 3 - k) = mean_depth(start_gap(3 - k), gap(3 - k), 0.0_dp, turn)
    depth = -(start_gap(k) + turn*(gap(k) - start_gap(k)))
    if (depth <= 0) return
    depth = -depth*ahead(1)/(ahead(1) - ahead(2))**2 ! times what the turn changes by with the gaps
    mean(2:, k) = mean(2:, k) + merge(depth, -depth, [1, 2] == k)
    mean(2:, 3 - k) = mean(2:, 3 - k) - merge(depth, -depth, [1, 2] == k)
  end function mean_depths

  !> What a line adds to the mean overlap between two shares of a straight way of its gap, and its change with the gap at the end.
  pure function mean_depth(start_gap, gap, first, last) result(mean)
    real(dp), intent(in) :: start_gap, gap !! length
    real(dp), intent(in) :: first, last
    real(dp) :: mean(2)
    real(dp) :: from, to

    mean = 0.0_dp
    if (min(start_gap, gap) >= 0) return
    from = first
    to = last
    if (start_gap > 0) from = max(from, start_gap/(start_gap - gap))
    if (gap > 0) to = min(to, start_gap/(start_gap - gap))
    if (to <= from) return
    mean = -(to - from)*[start_gap + 0.5_dp*(from + to)*(gap - start_gap), 0.5_dp*(from + to)]
  end function mean_depth

end module scree_conserving_contact
