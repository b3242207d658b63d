!> Where the outlines run as a step begins, their corners, and how far vertices may move.
module scree_corners
  use scree_contact_geometry, only: gap_of
  use scree_contact_lists, only: corner_t, survey_t
  use scree_contacts, only: outlines_t, parallel
  use scree_kinds, only: dp, pi
  implicit none
  private
  public :: along_edge, corner_t, edges_lead_away, find_corners, gap_at, is_straight, side_length, side_lengths, survey_edges, &
            survey_t, tilt, turn, way_at

  real(dp), parameter :: no_corner = 1e-9_dp !! an angle below is that of the end of a crack, a whole turn

contains

  !> Surveys listed edges of outlines whose elements have their vertices at `position`; with a corner the edge before it is.
  pure subroutine survey_edges(outlines, position, edge, corner, survey)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :) !! (2, n_vertices), length
    integer, intent(in) :: edge(:), corner(:) !! of the outlines
    type(survey_t), intent(inout) :: survey
    integer :: i, k

    if (.not. allocated(survey%edge)) then
      associate (n => size(outlines%start))
        allocate (survey%start(2, n), survey%finish(2, n), survey%side(n), survey%local(n), survey%local_side(n), &
            survey%reach_edge(n))
        allocate (survey%reach_at_rest(n), survey%turning(n), survey%reach_corner(n), survey%way(2, n), survey%corner(n))
        allocate (survey%length(n), source=0.0_dp)
      end associate
    else
      survey%length(survey%edge) = 0.0_dp
    end if
    survey%edge = edge
    do k = 1, size(edge)
      i = edge(k)
      survey%start(:, i) = position(:, outlines%start(i))
      survey%finish(:, i) = position(:, outlines%finish(i))
      survey%side(i) = side_length(outlines, position, i)
    end do
    survey%length(edge) = norm2(survey%finish(:, edge) - survey%start(:, edge), 1)
    do k = 1, size(corner)
      i = corner(k)
      associate (before => outlines%previous(i))
        survey%local(i) = min(survey%length(i), survey%length(before))
        survey%local_side(i) = min(survey%side(i), survey%side(before))
      end associate
    end do
  end subroutine survey_edges

  !> Distances between the ends of sides that were straight at first, at least the length of the edge, because a side may bend. They
  !> limit how far a vertex may jump, because the places where lines of the mesh cut a side must not matter.
  pure function side_lengths(outlines, position, edge) result(length)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :) !! (2, n_vertices), length
    integer, intent(in) :: edge(:)         !! (n) of the outlines
    real(dp) :: length(size(edge))         !! length
    integer :: k

    do k = 1, size(edge)
      length(k) = side_length(outlines, position, edge(k))
    end do
  end function side_lengths

  !> Likewise of one edge.
  pure real(dp) function side_length(outlines, position, edge) result(length)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :) !! (2, n_vertices), length
    integer, intent(in) :: edge            !! of the outlines

    length = max(norm2(position(:, outlines%side(2, edge)) - position(:, outlines%side(1, edge))), &
                 norm2(position(:, outlines%finish(edge)) - position(:, outlines%start(edge))))
  end function side_length

  !> Finds listed corners of surveyed edges.
  pure subroutine find_corners(previous, list, survey)
    integer, intent(in) :: previous(:)     !! (n) edge that ends at each vertex
    integer, intent(in) :: list(:)         !! corners
    type(survey_t), intent(inout) :: survey
    real(dp) :: own(2), back(2), on(2)
    integer :: i, k

    do k = 1, size(list)
      i = list(k)
      associate (corner => survey%corner(i), before => previous(i))
        own = survey%finish(:, i) - survey%start(:, i)
        back = survey%start(:, before) - survey%finish(:, before)
        on = survey%finish(:, before) - survey%start(:, before)
        corner%vertex = i
        corner%before = before
        corner%from = atan2(own(2), own(1))
        corner%into = atan2(on(2), on(1))
        corner%angle = modulo(atan2(back(2), back(1)) - corner%from, 2*pi)
        if (corner%angle < no_corner) corner%angle = 2*pi
      end associate
    end do
  end subroutine find_corners

  !> Whether both edges of a corner lead away from an edge of this direction, so that the corner fits on it.
  pure logical function edges_lead_away(corner, edge, tilt)
    type(corner_t), intent(in) :: corner
    real(dp), intent(in) :: edge  !! direction, rad
    real(dp), intent(in) :: tilt  !! by which corner and edge may be out of place, rad
    real(dp) :: lowest

    lowest = turn(corner%from + corner%angle/2 - edge + pi/2) ! against the outer normal of the edge, at edge - pi/2
    edges_lead_away = abs(lowest) + corner%angle/2 <= pi/2 + tilt
  end function edges_lead_away

  !> Whether the edges at a corner are parallel.
  pure logical function is_straight(corner)
    type(corner_t), intent(in) :: corner

    is_straight = abs(corner%angle - pi) <= parallel
  end function is_straight

  !> Angle by which the corners at two vertices may be out of place and yet meet in the step.
  pure real(dp) function tilt(survey, i, j)
    type(survey_t), intent(in) :: survey
    integer, intent(in) :: i, j

    tilt = parallel + survey%turning(i) + survey%turning(j)
  end function tilt

  !> Distance of the foot of vertex i on edge j from the start of the edge.
  pure real(dp) function along_edge(survey, i, j)
    type(survey_t), intent(in) :: survey
    integer, intent(in) :: i, j

    associate (x1 => survey%start(:, i), x2 => survey%start(:, j), x3 => survey%finish(:, j))
      along_edge = dot_product(x1 - x2, x3 - x2)/survey%length(j)
    end associate
  end function along_edge

  !> Gap of vertex i at the line of edge j.
  pure real(dp) function gap_at(survey, i, j)
    type(survey_t), intent(in) :: survey
    integer, intent(in) :: i, j

    gap_at = gap_of(survey%start(:, i), survey%start(:, j), survey%finish(:, j))
  end function gap_at

  !> Way of vertex i along edge j and across it that the velocities make in the step, length.
  pure function way_at(survey, next, i, j) result(along)
    type(survey_t), intent(in) :: survey
    integer, intent(in) :: next            !! edge after j
    integer, intent(in) :: i, j
    real(dp) :: along(2), share, t(2), way(2)

    share = along_edge(survey, i, j)/survey%length(j)
    t = (survey%finish(:, j) - survey%start(:, j))/survey%length(j)
    way = survey%way(:, i) - (1 - share)*survey%way(:, j) - share*survey%way(:, next)
    along = [dot_product(way, t), t(2)*way(1) - t(1)*way(2)]
  end function way_at

  !> The same angle between -pi and pi.
  pure real(dp) function turn(angle)
    real(dp), intent(in) :: angle

    turn = modulo(angle + pi, 2*pi) - pi
  end function turn

end module scree_corners
