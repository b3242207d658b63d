!> Whether the loops that a file gives bound one area: outlines may cross themselves, fold back, or run round twice.
!>
!> Edges that are no neighbours and keep their distance do none of this. A sweep finds that for almost every block. Where edges come
!> nearer, the loops are cut at each other as any lines are. The loops must wind once around one of the resulting regions, which is
!> the block, and not around its holes.
module scree_outline_checks
  use scree_errors, only: error_t
  use scree_kinds, only: dp
  use scree_line_cutting, only: cut_lines, graph_t
  use scree_loop_tracing, only: trace_regions
  use scree_polygon, only: distance_to_segment, inner_place, winding_numbers
  use scree_predicates, only: orientation
  use scree_regions, only: first_vertex_of, last_vertex_of, loops_of, region_count, regions_t, vertices_after
  use scree_simplex_integration, only: polygon_area
  use scree_sorting, only: sort_by
  implicit none
  private
  public :: find_wrong_area, folds_back, touches_itself

contains

  !> Whether the way from a by v to b goes straight back at v: one of the two edges lies within `near` of the other.
  pure logical function folds_back(a, v, b, near)
    real(dp), intent(in) :: a(2), v(2), b(2) !! length
    real(dp), intent(in) :: near             !! length

    folds_back = dot_product(a - v, b - v) > 0
    if (folds_back) folds_back = min(distance_to_segment(a, v, b), distance_to_segment(b, a, v)) <= near
  end function folds_back

  !> Whether two edges of loops that are no neighbours come within `near` of each other.
  pure logical function touches_itself(vertex, first, near)
    real(dp), intent(in) :: vertex(:, :) !! (2, n), length
    integer, intent(in) :: first(:)      !! (n_loops+1) loop k owns vertices first(k):first(k+1)-1
    real(dp), intent(in) :: near         !! length
    real(dp) :: from(size(vertex, 2)), low(2, size(vertex, 2)), high(2, size(vertex, 2))
    integer :: next(size(vertex, 2)), order(size(vertex, 2))
    integer :: axis, i, j, k

    touches_itself = .true.
    next = vertices_after(first)
    low = min(vertex, vertex(:, next)) - near
    high = max(vertex, vertex(:, next))
    axis = maxloc(maxval(high, 2) - minval(low, 2), 1) ! along which edges overlap least
    order = [(k, k=1, size(order))]
    from = low(axis, :)
    call sort_by(from, order)
    do i = 1, size(order)
      do j = i + 1, size(order)
        if (from(j) > high(axis, order(i))) exit
        associate (a => order(i), b => order(j))
          if (next(a) == b .or. next(b) == a) cycle
          if (any(low(:, a) > high(:, b)) .or. any(low(:, b) > high(:, a))) cycle
          if (are_near(vertex(:, a), vertex(:, next(a)), vertex(:, b), vertex(:, next(b)), near)) return
        end associate
      end do
    end do
    touches_itself = .false.
  end function touches_itself

  !> Whether two edges cross or come within `near` of each other.
  pure logical function are_near(p, q, r, s, near)
    real(dp), intent(in) :: p(2), q(2), r(2), s(2), near !! length

    are_near = orientation(p, q, r)*orientation(p, q, s) < 0 .and. orientation(r, s, p)*orientation(r, s, q) < 0
    if (.not. are_near) are_near = min(distance_to_segment(p, r, s), distance_to_segment(q, r, s), &
                                       distance_to_segment(r, p, q), distance_to_segment(s, p, q)) <= near
  end function are_near

  !> Finds a place in an area that loops wind around other than they should: once around one area, nowhere else.
  !>
  !> Areas that are thinner than `coarse` do not count, as the positions of a file are rounded.
  subroutine find_wrong_area(vertex, first, near, coarse, position, is_wrong)
    real(dp), intent(in) :: vertex(:, :)   !! (2, n), length
    integer, intent(in) :: first(:)        !! (n_loops+1), as above
    real(dp), intent(in) :: near           !! nodes and edges that are so near are one, length
    real(dp), intent(in) :: coarse         !! length
    real(dp), intent(out) :: position(2)      !! length
    logical, intent(out) :: is_wrong
    type(graph_t) :: graph
    type(regions_t) :: shape
    type(error_t), allocatable :: error
    real(dp) :: ends(2, 2, size(vertex, 2)), local(2, size(vertex, 2)), sides
    real(dp), allocatable :: corner(:, :), place(:, :)
    integer, allocatable :: beside(:, :), line(:), loops(:), winding(:)
    integer :: areas, k, n, r

    local = vertex - spread(vertex(:, 1), 2, size(vertex, 2))
    position = vertex(:, 1)
    ends(:, 1, :) = local
    ends(:, 2, :) = local(:, vertices_after(first))
    call cut_lines(ends, spread(.false., 1, size(ends, 3)), near, graph, error)
    is_wrong = allocated(error)
    if (is_wrong) return
    call trace_regions(graph, reshape([(1, k=1, 2*size(graph%line))], [2, size(graph%line)]), shape, corner, line, beside)
    allocate (place(2, region_count(shape)))
    n = 0
    do r = 1, region_count(shape)
      associate (polygon => corner(:, first_vertex_of(shape, r):last_vertex_of(shape, r)))
        loops = loops_of(shape, r)
        sides = sum(norm2(polygon(:, vertices_after(loops)) - polygon, 1))
        if (2*polygon_area(polygon, loops) < coarse*sides) cycle
        n = n + 1
        place(:, n) = inner_place(polygon, loops)
      end associate
    end do
    winding = winding_numbers(local, place(:, :n), first)
    areas = 0
    do r = 1, n
      position = place(:, r) + vertex(:, 1)
      if (winding(r) == 1) areas = areas + 1
      is_wrong = winding(r) < 0 .or. winding(r) > 1 .or. areas > 1
      if (is_wrong) return
    end do
  end subroutine find_wrong_area

end module scree_outline_checks
