!> How two corners meet by Shi's rules: which vertex by which edge (Shi: df04, df05).
module scree_shi_meeting
  use scree_contacts, only: parallel
  use scree_corner_meeting, only: add_edge, add_line, angle_between, encounters_t, is_hollow, line_of, width_of
  use scree_corners, only: corner_t, edges_lead_away
  use scree_kinds, only: dp, pi
  implicit none
  private
  public :: meet_as_shi

  !> Where directions of edges differ by less, the edges at the more upright corner act (Shi: 0.3 h1); rad.
  real(dp), parameter :: nearly = 0.3_dp*parallel

contains

  !> How corners a and b meet by Shi's rules (df04, df05).
  !>
  !> A convex corner meets those edges of a hollow corner on which it fits. Where edges are parallel, it meets one edge or both.
  !> Elsewhere the more upright corner chooses between edges that are nearly parallel.
  pure function meet_as_shi(a, b) result(meeting)
    type(corner_t), intent(in) :: a, b
    type(encounters_t) :: meeting
    integer :: low(2), high(2)
    real(dp) :: between, upright, width

    between = angle_between(a, b)
    width = width_of(a, b, between)
    if (is_hollow(a) .or. is_hollow(b)) then
      if (.not. is_hollow(a)) then
        call meet_edges_that_fit(a, b, meeting)
      else
        call meet_edges_that_fit(b, a, meeting)
      end if
    else if (width > pi + parallel) then
      return
    else if (width >= pi - parallel) then
      if ((a%angle + b%angle)/2 - between >= pi - parallel) call add_line([a%vertex, b%vertex], [b%before, a%vertex], meeting)
      if ((a%angle + b%angle)/2 + between >= pi - parallel) call add_line([b%vertex, a%vertex], [a%before, b%vertex], meeting)
    else
      upright = abs(sin(b%from + b%angle/2)) - abs(sin(a%from + a%angle/2))
      low = merge([a%vertex, b%vertex], [b%vertex, a%vertex], &
                  between - a%angle/2 + b%angle/2 >= merge(-nearly, nearly, upright >= 0))
      high = merge([b%vertex, a%before], [a%vertex, b%before], &
                   between + a%angle/2 - b%angle/2 >= merge(-nearly, nearly, upright <= 0))
      call add_edge(low(1), low(2), meeting)
      meeting%encounter(1)%n_lines = 2
      meeting%encounter(1)%line(2) = line_of(high(:1), high(2:), [.true.])
    end if
  end function meet_as_shi

  !> Adds the edges of the hollow corner b on which corner a fits.
  pure subroutine meet_edges_that_fit(a, b, meeting)
    type(corner_t), intent(in) :: a, b
    type(encounters_t), intent(inout) :: meeting

    if (edges_lead_away(a, b%from, parallel)) call add_edge(a%vertex, b%vertex, meeting)
    if (edges_lead_away(a, b%into, parallel)) call add_edge(a%vertex, b%before, meeting)
  end subroutine meet_edges_that_fit

end module scree_shi_meeting
