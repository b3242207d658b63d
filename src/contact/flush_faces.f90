!> Edges that a third block lies flush with: no corner enters its body by such an edge, as it would have to pass through the third
!> block.
!>
!> Contact is with the boundary of the union of the bodies. Where a block lies flush with an edge at a corner, that edge is inside
!> of the union there, and its entrance line is *covered*. A corner that slides over the joint of two flush blocks has sunk below
!> their faces by the penetration of its springs. The side of the block ahead would stop the corner, if that side were not
!> covered.
module scree_flush_faces
  use scree_body_search, only: near_at_rest
  use scree_contact_geometry, only: gap_of
  use scree_contact_look, only: look_t
  use scree_contacts, only: outlines_t, parallel
  use scree_corner_meeting, only: encounter_t, entrance_pairs_t
  use scree_corners, only: gap_at, turn
  use scree_kinds, only: dp
  implicit none
  private
  public :: cover_t, covered_edges, cover_of, give_of_tips

  real(dp), parameter :: flush = 1e-4_dp          !! ratio to the edges about: corners of flush blocks are no farther apart
  real(dp), parameter :: tips_flush = 5e-5_dp     !! likewise, of two tips across from each other, between which others are pressed
  real(dp), parameter :: most_flush = 1e-2_dp     !! likewise, at most, of blocks that springs let sink
  real(dp), parameter :: on_it = 1e-9_dp          !! likewise: a corner so near to a line lies on it

  !> What third blocks cover of the two entrance lines of two corners.
  type :: cover_t
    integer :: line = 0                           !! line that no corner can cross; 0: neither
    logical :: tips_give = .false.                !! both lines are covered: the tips bear nothing as far as flush blocks sink
    logical :: bears_beside = .false.             !! the covering block bears the corner: the tips bear nothing
  end type cover_t

contains

  !> What third blocks cover of an encounter of corners i and j with two entrance lines.
  !>
  !> One line is covered where a third block lies flush with the edge of that line. At the joint itself a block lies flush with both
  !> lines. Then the covered line is the one that the corner is about to cross while it has crossed the other one, and that it
  !> crosses farther than the other one. The tips give where the corner goes no farther in the step than springs let blocks sink, as
  !> where four blocks meet at rest.
  pure type(cover_t) function cover_of(outlines, look, i, j, encounter) result(cover)
    type(outlines_t), intent(in) :: outlines
    type(look_t), intent(in) :: look
    integer, intent(in) :: i, j
    type(encounter_t), intent(in) :: encounter
    logical :: covered(2)                         ! edges that begin at the corners, edges that end there
    logical :: at_j(2)                            ! those of them that are at corner j
    real(dp) :: ahead(2), gap(2), on_line
    integer :: corner, k

    at_j = covered_edges(outlines, look, i, j)
    covered = at_j .or. covered_edges(outlines, look, j, i)
    if (.not. any(covered)) return
    associate (survey => look%survey, line => encounter%line)
      gap = [(gap_at(survey, line(k)%vertex(1), line(k)%edge(1)), k=1, 2)]
      if (all(covered)) then
        on_line = on_it*min(survey%local(i), survey%local(j))
        ahead = [(gap_ahead(outlines, look, line(k)%vertex(1), line(k)%edge(1)), k=1, 2)]
        if (maxval(abs(ahead - gap)) <= give_by(flush, outlines, look, i, j)) cover%tips_give = .true.
        do k = 1, 2
          if (.not. (gap(3 - k) < on_line .and. gap(k) > -on_line .and. ahead(k) < min(0.0_dp, ahead(3 - k)) - on_line)) cycle
          cover%line = k
          cover%tips_give = .false.
        end do
      else
        k = merge(1, 2, covered(1))
        cover%line = k
        corner = merge(i, j, at_j(k))
        if (stands_before(outlines, look, corner, i + j - corner, line(k), k) .and. gap(3 - k) < 0 .and. line(3 - k)%n == 1) then
          cover%line = 0
          cover%bears_beside = .true. ! the corner is not flat on the row of blocks
        end if
      end if
    end associate
  end function cover_of

  !> Whether vertex i is still in front of the edge that begins at corner j (side 1) or ends there (side 2), while the entrance line
  !> of these corners belongs to other edges.
  pure logical function stands_before(outlines, look, i, j, line, side)
    type(outlines_t), intent(in) :: outlines
    type(look_t), intent(in) :: look
    integer, intent(in) :: i, j, side
    type(entrance_pairs_t), intent(in) :: line
    integer :: edge

    edge = merge(j, outlines%previous(j), side == 1)
    stands_before = gap_at(look%survey, i, edge) > 0 .and. all(line%edge(:line%n) /= edge)
  end function stands_before

  !> Gap of vertex i at the line of edge j where their velocities take them in the step.
  pure real(dp) function gap_ahead(outlines, look, i, j)
    type(outlines_t), intent(in) :: outlines
    type(look_t), intent(in) :: look
    integer, intent(in) :: i, j

    associate (survey => look%survey, next => outlines%next(j))
      gap_ahead = gap_of(survey%start(:, i) + survey%way(:, i), survey%start(:, j) + survey%way(:, j), &
                         survey%finish(:, j) + survey%way(:, next))
    end associate
  end function gap_ahead

  !> Whether a third block lies flush with the edge that begins at corner j, and with the edge that ends there, by a corner near
  !> vertex i.
  pure function covered_edges(outlines, look, i, j) result(covered)
    type(outlines_t), intent(in) :: outlines
    type(look_t), intent(in) :: look
    integer, intent(in) :: i, j
    logical :: covered(2)
    integer :: k

    covered = .false.
    do k = first_at_edge(look, i), look%n_sorted
      if (look%nearby(2, k) /= i) return
      associate (c => look%nearby(1, k), block => outlines%block, survey => look%survey)
        if (any(block(c) == block([i, j]))) cycle
        if (norm2(survey%start(:, c) - survey%start(:, j)) > give_by(flush, outlines, look, c, j)) cycle
        if (norm2(survey%way(:, c) - survey%way(:, j)) > near_at_rest*min(survey%local(c), survey%local(j))) cycle ! it slides by
        associate (own => survey%corner(j), cover => survey%corner(c))
          covered(1) = covered(1) .or. abs(turn(cover%from + cover%angle - own%from)) < parallel
          covered(2) = covered(2) .or. abs(turn(own%from + own%angle - cover%from)) < parallel
        end associate
      end associate
    end do
  end function covered_edges

  !> Largest penetration at which two tips, between which other blocks lie flush, bear nothing, length. How far springs sink under a
  !> load that comes at once is not known as long as no spring of the two blocks is pressed.
  pure real(dp) function give_of_tips(outlines, look, i, j)
    type(outlines_t), intent(in) :: outlines
    type(look_t), intent(in) :: look
    integer, intent(in) :: i, j

    give_of_tips = give_by(merge(tips_flush, flush, any(look%pressed(outlines%block([i, j])) > 0)), outlines, look, i, j)
  end function give_of_tips

  !> Largest distance of corners i and j of flush blocks, length: a fraction of the edges about, plus twice the largest penetration
  !> of a spring of either block.
  pure real(dp) function give_by(share, outlines, look, i, j)
    real(dp), intent(in) :: share
    type(outlines_t), intent(in) :: outlines
    type(look_t), intent(in) :: look
    integer, intent(in) :: i, j

    associate (local => min(look%survey%local(i), look%survey%local(j)))
      give_by = min(most_flush*local, share*local + 2*maxval(look%pressed(outlines%block([i, j]))))
    end associate
  end function give_by

  !> First pair nearby with edge i, by bisection.
  pure integer function first_at_edge(look, i) result(low)
    type(look_t), intent(in) :: look
    integer, intent(in) :: i
    integer :: high, middle

    low = 1
    high = look%n_sorted + 1
    do while (low < high)
      middle = (low + high)/2
      if (look%nearby(2, middle) < i) then
        low = middle + 1
      else
        high = middle
      end if
    end do
  end function first_at_edge

end module scree_flush_faces
