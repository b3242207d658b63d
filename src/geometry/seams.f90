!> Seams: straight lines inside a region that join each of its holes to its outline, so that one polygon holds them all.
!>
!> A vertical line sweeps over the region from left to right. The edges with the region above them, from bottom to top, are its
!> floors. Between a floor and the edge above it, the region is a trapezoid, whose left side a vertex has made: the mark of the
!> floor. The first vertex of a hole lies on the right side of a trapezoid. So the line to the mark runs inside it and meets neither
!> an edge nor another seam, because these lie in other trapezoids. (de Berg et al. 2008, "Computational Geometry", section 3.2,
!> diagonals of split vertices). n vertices take a time of order n log n.
!>
!> Of vertices with the same x the lower one comes first, as if the sweep line leaned a little. Loops may touch at vertices. There
!> the sweep takes holes and the outside to be a little smaller: edges that end at the place come first, and edges that begin there
!> come last. Edges that leave the place are told apart by their directions.
module scree_seams
  use scree_kinds, only: dp
  use scree_ordered_list, only: bring_up, find_before, insert_after, ordered_list_t, remove_item, replace_item, set_up_list
  use scree_predicates, only: orientation
  use scree_regions, only: vertices_after
  use scree_sorting, only: order_of_places, sort_into
  implicit none
  private
  public :: find_seams, seam_below, seam_left, seam_above

  !> The seams of a vertex, clockwise from the edge that arrives to the edge that leaves.
  integer, parameter :: seam_below = 1, seam_left = 2, seam_above = 3

  !> Kinds of vertices by their edges, in the order in which the sweep takes vertices at one place.
  integer, parameter :: region_begins = 1    !! both leave to the right, with the region between them
  integer, parameter :: gap_ends = 2         !! both arrive from the left, with the region around them
  integer, parameter :: floor_goes_on = 3    !! one on each side, with the region above
  integer, parameter :: ceiling_goes_on = 4  !! one on each side, with the region below
  integer, parameter :: gap_begins = 5       !! both leave to the right, with the region around them
  integer, parameter :: region_ends = 6      !! both arrive from the left, with the region between them

contains

  !> Finds a seam from the first vertex of each hole, from left to right, to a vertex before it.
  !>
  !> Every hole gets a seam, and the seams make a tree of the loops, whatever the loops are. Where loops cross, seams may cross
  !> them. No two vertices of one loop may be at one place.
  subroutine find_seams(vertex, first, seam, n_compared)
    real(dp), intent(in) :: vertex(:, :)           !! (2, n), length
    integer, intent(in) :: first(:)                !! (n_loops+1) loop k owns vertices first(k):first(k+1)-1, the outline first
    integer, allocatable, intent(out) :: seam(:, :)  !! (3, n) vertex to which a seam leads below, left and above, 0: none
    integer, intent(out), optional :: n_compared   !! how often the sweep has held a vertex against an edge
    type(ordered_list_t) :: floors                 !! an edge has the number of its left vertex, from which it leaves
    integer, dimension(size(vertex, 2)) :: after, before, loop, mark, order, what
    logical :: is_joined(size(first) - 1)
    integer :: compared, i, k, last, under, v

    after = vertices_after(first)
    before(after) = [(k, k=1, size(after))]
    do k = 1, size(first) - 1
      loop(first(k):first(k + 1) - 1) = k
    end do
    what = [(what_happens(k), k=1, size(what))]
    order = order_of_sweep()
    allocate (seam(3, size(order)), source=0)
    call set_up_list(floors, size(order))
    is_joined = .false.
    is_joined(1) = .true.
    compared = 0
    last = 0
    do i = 1, size(order)
      v = order(i)
      under = 0
      select case (what(v))
      case (floor_goes_on)
        call replace_item(floors, before(v), v)
      case (region_ends)
        call remove_item(floors, before(v))
      case (gap_ends)
        call find_before(floors, before(v), under)
        call remove_item(floors, before(v))
      case default
        call find_floor(v, under)
      end select
      if (.not. is_joined(loop(v))) then
        is_joined(loop(v)) = .true.
        if (under > 0) then
          call join(v, mark(under))
        else ! loops cross: the vertex before has no seam to the right yet, and gets no other one
          call join(v, last)
          mark(last) = -v
        end if
      end if
      if (under > 0 .and. what(v) /= region_begins) mark(under) = -v
      if (what(v) == region_begins .or. what(v) == gap_begins) call insert_after(floors, v, under)
      mark(v) = v
      last = v
    end do
    if (present(n_compared)) n_compared = compared

  contains

    !> Kind of a vertex, by its edges.
    pure integer function what_happens(v)
      integer, intent(in) :: v
      logical :: right(2)

      right = [is_before(v, before(v)), is_before(v, after(v))]
      if (right(1) .neqv. right(2)) then
        what_happens = merge(floor_goes_on, ceiling_goes_on, right(2))
      else if (orientation(vertex(:, before(v)), vertex(:, v), vertex(:, after(v))) > 0) then
        what_happens = merge(region_begins, region_ends, right(1))
      else
        what_happens = merge(gap_begins, gap_ends, right(1))
      end if
    end function what_happens

    !> Whether the sweep comes to the place of a vertex before it comes to the place of another one.
    pure logical function is_before(v, w)
      integer, intent(in) :: v, w

      is_before = vertex(1, v) < vertex(1, w) .or. (.not. vertex(1, v) > vertex(1, w) .and. vertex(2, v) < vertex(2, w))
    end function is_before

    !> The vertices from left to right, at one place by what happens; a vertex of the outline comes first even where holes reach
    !> out of it.
    pure function order_of_sweep() result(order)
      integer :: order(size(what))
      integer, allocatable :: first_of(:), list(:)
      integer :: k

      call sort_into(what, region_ends, first_of, list)
      order = list(order_of_places(vertex(:, list)))
      k = findloc(loop(order) == 1, .true., 1)
      order(:k) = cshift(order(:k), -1)
    end function order_of_sweep

    !> Finds the floor directly under a vertex, 0 where there is none.
    subroutine find_floor(v, under)
      integer, intent(in) :: v
      integer, intent(out) :: under
      integer :: last, next

      under = 0
      last = 0
      next = floors%root
      do while (next > 0)
        last = next
        compared = compared + 1
        if (is_above(v, last)) then
          under = last
          next = floors%upper(last)
        else
          next = floors%lower(last)
        end if
      end do
      if (last > 0) call bring_up(floors, last)
    end subroutine find_floor

    !> Whether a vertex is above a floor. Where the vertex is on the floor, one of its edges tells: an edge to the right, or, where
    !> the floor ends at the place, an edge to the left.
    pure logical function is_above(v, floor)
      integer, intent(in) :: v, floor
      integer :: k, turn, w(3)

      w = [v, before(v), after(v)]
      turn = 0
      do k = 1, 3
        if (k > 1) then
          if (is_before(v, w(k)) .neqv. is_before(v, after(floor))) cycle
        end if
        turn = orientation(vertex(:, floor), vertex(:, after(floor)), vertex(:, w(k)))
        if (turn /= 0) exit
      end do
      is_above = turn > 0
    end function is_above

    !> Makes a seam from a vertex to the left, to a mark: above a vertex, or, where it is negative, below one.
    subroutine join(v, mark)
      integer, intent(in) :: v, mark

      seam(seam_left, v) = abs(mark)
      seam(merge(seam_above, seam_below, mark > 0), abs(mark)) = v
    end subroutine join

  end subroutine find_seams

end module scree_seams
