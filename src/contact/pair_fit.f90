!> Choice of the pair of a vertex and an edge of an entrance line: the pair that fits best. It depends on the scene alone.
module scree_pair_fit
  use scree_contact_pairs, only: contact_of
  use scree_contacts, only: outlines_t
  use scree_corners, only: along_edge, gap_at, survey_t
  use scree_kinds, only: dp
  use scree_past_contacts, only: is_closed, past_t
  implicit none
  private
  public :: fit_of_pair, fit_t, fits_better

  !> Distance past the end of an edge, over its length, that rounding may give to a vertex that rests at the end.
  real(dp), parameter :: rest_at_end = 1e-12_dp
  !> Distance past the end of an edge up to which a pair lasts, over the length of the edges at the vertex.
  real(dp), parameter :: most_beyond = 5e-4_dp
  !> Two pairs whose measures differ by less than this ratio to an edge fit equally well: such a difference may be rounding.
  real(dp), parameter :: as_good = 1e-9_dp

  !> How well a pair of an entrance line fits. The rank is compared first, then each length, and last the block. The block decides
  !> between blocks that are equal in all these values; it does not decide between mirror images.
  type :: fit_t
    integer :: rank = 0        !! it is new, or goes on; 0: there is none
    real(dp) :: by(4) = 0.0_dp !! the larger one fits better, length
    integer :: block = 0       !! of the edge: that of the higher number
  end type fit_t

  integer, parameter :: is_new = 1, goes_on_open = 2 !! ranks
  integer, parameter, public :: goes_on_closed = 3   !! the highest that `fit_of_pair` gives

contains

  !> Measures how well a pair of a line fits. A new pair is measured by how far its vertex is within its edge and behind it, and by
  !> the lengths of this edge and of the edges at the vertex. Of pairs that continue contacts of their own, the pair with the longer
  !> edge fits better, because its vertex stays within that edge for longer.
  pure type(fit_t) function fit_of_pair(outlines, survey, past, before, vertex, edge, aside) result(fit)
    type(outlines_t), intent(in) :: outlines
    type(survey_t), intent(in) :: survey
    type(past_t), intent(in) :: past
    integer, intent(in) :: before       !! number of its entrance; 0: it is new
    integer, intent(in) :: vertex, edge
    logical, intent(in) :: aside        !! as of the line
    real(dp) :: at, inside, lowest, others

    fit%rank = is_new
    fit%block = outlines%block(edge)
    associate (length => survey%length(edge), local => survey%local(vertex))
      at = along_edge(survey, vertex, edge)
      inside = min(at, length - at)
      lowest = inside
      if (aside) lowest = min(inside, -most_beyond*local)
      others = survey%length(vertex) + survey%length(outlines%previous(vertex))
      fit%by = [lowest, -gap_at(survey, vertex, edge), length, others]
      if (before == 0) return
      if (lowest < -beyond(past%contact(contact_of(before))%overlap, length, local)) return
      fit%rank = merge(goes_on_closed, goes_on_open, is_closed(past, before))
      fit%by = [length, inside, -gap_at(survey, vertex, edge), others]
    end associate
  end function fit_of_pair

  !> Whether a pair of a line fits better than another. Differences by rounding decide nothing.
  pure logical function fits_better(a, b) result(better)
    type(fit_t), intent(in) :: a, b
    real(dp) :: rounding
    integer :: k

    better = a%rank > b%rank
    if (a%rank /= b%rank) return
    rounding = as_good*maxval([a%by, b%by])
    do k = 1, size(a%by)
      better = a%by(k) > b%by(k)
      if (abs(a%by(k) - b%by(k)) > rounding) return
    end do
    better = a%block > b%block
  end function fits_better

  !> Distance past the end of its edge up to which a pair lasts: the overlap of the two, or the rounding of a corner that rests
  !> there. It ends before the vertex counts as well over the next edge.
  pure real(dp) function beyond(overlap, length, local)
    real(dp), intent(in) :: overlap
    real(dp), intent(in) :: length !! of the edge
    real(dp), intent(in) :: local  !! shorter edge at the vertex, length

    beyond = min(max(overlap, rest_at_end*length), most_beyond*local)
  end function beyond

end module scree_pair_fit
