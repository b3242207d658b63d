!> A region with holes as one polygon, and back.
!>
!> Where a format knows polygons only (block files, VTK), a hole is joined to the outside by an edge that is run through
!> both ways: the polygon encloses the same area, and what is run through both ways is the seam.
module scree_keyholes
  use scree_kinds, only: dp
  use scree_polygon, only: twice_area
  use scree_predicates, only: orientation
  use scree_regions, only: first_vertex_of, last_vertex_of, loops_of, region_count, regions_t
  use scree_sorting, only: sort_by
  implicit none
  private
  public :: join_loops, part_loops, polygons_of

contains

  !> Vertices of all loops in the order of one polygon. A hole is joined by the shortest edge that touches no other.
  pure function join_loops(vertex, first) result(order)
    real(dp), intent(in) :: vertex(:, :)   !! (2, n), length
    integer, intent(in) :: first(:)        !! (n_loops+1) loop k owns vertices first(k):first(k+1)-1, the outer one first
    integer, allocatable :: order(:)
    logical :: joined(size(first) - 1)
    integer :: best(3), h, i, k, left
    real(dp) :: distance, shortest

    order = [(i, i=first(1), first(2) - 1)]
    joined = .false.
    joined(1) = .true.
    do left = 1, size(first) - 2
      shortest = huge(shortest)
      best = 0
      do k = 2, size(first) - 1
        if (joined(k)) cycle
        do h = first(k), first(k + 1) - 1
          do i = 1, size(order)
            distance = sum((vertex(:, order(i)) - vertex(:, h))**2)
            if (distance >= shortest) cycle
            if (.not. sees(vertex, first, order(i), h)) cycle
            shortest = distance
            best = [k, h, i]
          end do
        end do
      end do
      if (best(1) == 0) return ! loops that cross: no polygon holds them
      associate (k => best(1), h => best(2), at => best(3))
        order = [order(:at), (i, i=h, first(k + 1) - 1), (i, i=first(k), h), order(at:)]
        joined(k) = .true.
      end associate
    end do
  end function join_loops

  !> Every region as one polygon: region i has the vertices corner(first(i):first(i+1)-1) in this order.
  pure subroutine polygons_of(shape, vertex, first, corner)
    type(regions_t), intent(in) :: shape
    real(dp), intent(in) :: vertex(:, :)             !! (2, n_vertices), length
    integer, allocatable, intent(out) :: first(:)    !! (n+1)
    integer, allocatable, intent(out) :: corner(:)
    integer :: i, k

    allocate (first(region_count(shape) + 1))
    first(1) = 1
    do i = 1, region_count(shape)
      first(i + 1) = first(i) + last_vertex_of(shape, i) - first_vertex_of(shape, i) + 1 &
                     + 2*(shape%first_loop(i + 1) - shape%first_loop(i) - 1)
    end do
    allocate (corner(first(region_count(shape) + 1) - 1))
    do i = 1, region_count(shape)
      associate (from => first_vertex_of(shape, i), to => last_vertex_of(shape, i))
        if (shape%first_loop(i + 1) == shape%first_loop(i) + 1) then
          corner(first(i):first(i + 1) - 1) = [(k, k=from, to)]
        else
          corner(first(i):first(i + 1) - 1) = from - 1 + join_loops(vertex(:, from:to), loops_of(shape, i))
        end if
      end associate
    end do
  end subroutine polygons_of

  !> Whether the straight between two vertices touches no edge but at its own ends.
  pure logical function sees(vertex, first, a, b)
    real(dp), intent(in) :: vertex(:, :)
    integer, intent(in) :: first(:), a, b
    integer :: i, k, next, turn(4)

    sees = .false.
    do k = 1, size(first) - 1
      do i = first(k), first(k + 1) - 1
        next = i + 1
        if (next == first(k + 1)) next = first(k)
        associate (p => vertex(:, i), q => vertex(:, next), pa => vertex(:, a), pb => vertex(:, b))
          if (any(i == [a, b]) .or. any(next == [a, b])) cycle
          if (minval([p(1), q(1)]) > maxval([pa(1), pb(1)]) .or. maxval([p(1), q(1)]) < minval([pa(1), pb(1)])) cycle
          if (minval([p(2), q(2)]) > maxval([pa(2), pb(2)]) .or. maxval([p(2), q(2)]) < minval([pa(2), pb(2)])) cycle
          turn = [orientation(pa, pb, p), orientation(pa, pb, q), orientation(p, q, pa), orientation(p, q, pb)]
          if (turn(1)*turn(2) <= 0 .and. turn(3)*turn(4) <= 0) return
        end associate
      end do
    end do
    sees = .true.
  end function sees

  !> The loops of a polygon whose seams are edges that it runs through both ways, the outer loop first.
  pure recursive subroutine part_loops(vertex, order, first)
    real(dp), intent(in) :: vertex(:, :)              !! (2, n)
    integer, allocatable, intent(out) :: order(:)     !! vertices by loop
    integer, allocatable, intent(out) :: first(:)     !! (n_loops+1)
    integer, allocatable :: inner(:), inner_first(:), outer(:), outer_first(:), inside(:), outside(:)
    logical :: is_repeated(size(vertex, 2))
    integer :: i, j, k, n

    n = size(vertex, 2)
    if (n > 4) is_repeated = repeated_places(vertex)
    do i = 1, n - 4
      if (.not. is_repeated(i + 1)) cycle
      do j = i + 4, n
        if (.not. (same(i, modulo(j, n) + 1) .and. same(i + 1, j))) cycle
        inside = [(k, k=i + 1, j - 1)] ! each vertex that is there twice stays where it is not the start of the seam
        outside = [(k, k=1, i - 1), (k, k=j + 1, n)]
        if (twice_area(vertex(:, inside)) > 0) then
          order = inside
          inside = outside
          outside = order
        end if
        call part_loops(vertex(:, inside), inner, inner_first)
        call part_loops(vertex(:, outside), outer, outer_first)
        order = [outside(outer), inside(inner)]
        first = [outer_first, inner_first(2:) + size(outer)]
        return
      end do
    end do
    order = [(i, i=1, n)]
    first = [1, n + 1]

  contains

    !> Whether two vertices are at one place.
    pure logical function same(p, q)
      integer, intent(in) :: p, q

      same = .not. any(abs(vertex(:, p) - vertex(:, q)) > 0)
    end function same

  end subroutine part_loops

  !> Whether each vertex has another one at its position.
  pure function repeated_places(vertex) result(is_repeated)
    real(dp), intent(in) :: vertex(:, :)  !! (2, n)
    logical :: is_repeated(size(vertex, 2))
    real(dp) :: x(size(vertex, 2)), y(size(vertex, 2))
    integer :: from, k, order(size(vertex, 2)), to

    order = [(k, k=1, size(order))]
    x = vertex(1, :)
    call sort_by(x, order)
    y = vertex(2, order)
    is_repeated = .false.
    from = 1
    do while (from <= size(order)) ! the vertices with one x are from:to
      to = from
      do while (to < size(order))
        if (x(to + 1) > x(from)) exit
        to = to + 1
      end do
      call sort_by(y(from:to), order(from:to))
      do k = from + 1, to
        if (.not. y(k) > y(k - 1)) is_repeated(order(k - 1:k)) = .true.
      end do
      from = to + 1
    end do
  end function repeated_places

end module scree_keyholes
