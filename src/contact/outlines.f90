!> The outlines of bodies, from the polygons of their elements.
module scree_outlines
  use scree_contacts, only: outlines_t
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_kinds, only: dp, pi
  use scree_regions, only: region_count, regions_t
  use scree_sorting, only: sort_by, sort_into
  use scree_text, only: number_text
  implicit none
  private
  public :: make_outlines

  !> Length of an edge over that of the edge beside it on the same side, below which it is a sliver that a line of the mesh has
  !> left. The sliver becomes part of the other edge. Contacts are looked for as far as the edges about them are long, and the
  !> length of a sliver says nothing about its corner.
  real(dp), parameter :: sliver = 1e-2_dp
  real(dp), parameter :: straight = 1e-6_dp !! of an edge, up to which a vertex is on its line
  integer, parameter :: most_slivers = 8    !! in a row: where lines of the mesh meet they come by threes
  !> Direction in which they are joined: along no axis, as rounding would tell then.
  real(dp), parameter :: ahead(2) = [1.0_dp, 0.618_dp]

contains

  !> Edges that are no line of the mesh, and which follows which around the body. Slivers that the mesh leaves of a side are part of
  !> the edge beside them.
  !>
  !> Where an edge ends, the outline goes on in the same element or, if a line of the mesh follows, in another element. Candidates
  !> are then the edges that follow a line of the mesh and begin at the same position, to the last bit. The outline takes the
  !> candidate that is met first when turning clockwise from the way back; the body lies in between. Errors: an edge after which the
  !> outline does not go on, the first one without `next`.
  pure subroutine make_outlines(shape, vertex, block, outlines, error)
    type(regions_t), intent(in) :: shape    !! of the elements
    real(dp), intent(in) :: vertex(:, :)    !! (2, n_vertices) at the start, length
    integer, intent(in) :: block(:)         !! (n_elements)
    type(outlines_t), intent(out) :: outlines
    type(error_t), allocatable, intent(out) :: error
    integer :: after(size(vertex, 2)), before(size(vertex, 2)), element(size(vertex, 2)), number(size(vertex, 2))
    integer, allocatable :: order(:)
    real(dp), allocatable :: x(:)
    integer :: e, i, k, loop, n

    do e = 1, region_count(shape)
      do loop = shape%first_loop(e), shape%first_loop(e + 1) - 1
        do k = shape%first_vertex(loop), shape%first_vertex(loop + 1) - 1
          after(k) = k + 1
          element(k) = e
        end do
        after(shape%first_vertex(loop + 1) - 1) = shape%first_vertex(loop)
      end do
    end do
    do k = 1, size(after)
      before(after(k)) = k
    end do
    outlines%start = pack([(k, k=1, size(after))], shape%joint > 0)
    n = size(outlines%start)
    number = 0
    number(outlines%start) = [(i, i=1, n)]
    outlines%element = element(outlines%start)
    outlines%block = block(outlines%element)
    outlines%finish = after(outlines%start)
    outlines%joint = shape%joint(outlines%start)

    order = [(i, i=1, n)]
    x = vertex(1, outlines%start)
    call sort_by(x, order)
    allocate (outlines%next(n), outlines%previous(n), source=0)
    do i = 1, n
      outlines%next(i) = number(outlines%finish(i))
      if (outlines%next(i) == 0) outlines%next(i) = edge_after(i)
      if (outlines%next(i) > 0) then
        if (outlines%previous(outlines%next(i)) > 0) outlines%next(i) = 0
      end if
      if (outlines%next(i) == 0) then
        call fail(error, status_run_failed, 'the outline of block '//number_text(outlines%block(i))//' is not closed')
        return
      end if
      outlines%previous(outlines%next(i)) = i
    end do
    call join_slivers(vertex, outlines)
    outlines%of_vertex = element(outlines%start)
    call find_sides(vertex, outlines)
    call sort_into(outlines%block, maxval(outlines%block), outlines%first, outlines%of_block)
    allocate (outlines%inside(2, 0))
    allocate (outlines%fixed(size(outlines%start)), outlines%gone(size(outlines%start)), source=.false.)

  contains

    !> The edge that the outline goes on with in another element after edge i; 0 where there is none.
    pure integer function edge_after(i)
      integer, intent(in) :: i
      real(dp), parameter :: other_side = 1e-9_dp !! of a crack, which leads back: turn below, rad
      real(dp) :: back, least, turn
      integer :: high, j, low, middle

      edge_after = 0
      least = huge(least)
      associate (position => vertex(:, outlines%finish(i)))
        low = 1
        high = n
        do while (low < high)
          middle = (low + high)/2
          if (x(middle) < position(1)) then
            low = middle + 1
          else
            high = middle
          end if
        end do
        back = direction(vertex(:, outlines%start(i)) - position)
        do middle = low, n
          if (x(middle) > position(1)) exit
          j = order(middle)
          if (outlines%block(j) /= outlines%block(i) .or. number(before(outlines%start(j))) > 0) cycle
          if (abs(vertex(2, outlines%start(j)) - position(2)) > 0) cycle
          turn = modulo(back - direction(vertex(:, outlines%finish(j)) - position), 2*pi)
          if (turn < other_side) turn = 2*pi ! no corner is as sharp
          if (turn > least) cycle
          least = turn
          edge_after = j
        end do
      end associate
    end function edge_after

    !> Of a vector, rad.
    pure real(dp) function direction(v)
      real(dp), intent(in) :: v(2)

      direction = atan2(v(2), v(1))
    end function direction

  end subroutine make_outlines

  !> Joins slivers of a side to the next edge of the side that is no sliver and belongs to another element, beyond other slivers.
  !> The direction is the same for all sides, so that both sides of a joint keep the same vertices. If a corner is in this
  !> direction, the sliver is joined in the other direction.
  pure subroutine join_slivers(vertex, outlines)
    real(dp), intent(in) :: vertex(:, :)           !! (2, n_vertices) at the start, length
    type(outlines_t), intent(inout) :: outlines
    logical, dimension(size(outlines%start)) :: is_sliver, to_previous ! joined to the edge before it, else after it
    integer :: number(size(outlines%start))        ! of what is left; 0: joined
    integer, allocatable :: left(:)
    logical :: on_side(2)                          ! an edge that is none is before a sliver, after it
    integer :: begins, i, k, n

    do i = 1, size(number)
      is_sliver(i) = ends_long(i, outlines%previous) .or. ends_long(i, outlines%next)
    end do
    number = 1
    to_previous = .false.
    do i = 1, size(number)
      if (.not. is_sliver(i)) cycle
      on_side = [has_on_side(i, outlines%previous), has_on_side(i, outlines%next)]
      if (any(on_side)) number(i) = 0
      to_previous(i) = on_side(1)
      if (all(on_side)) to_previous(i) = dot_product(along(i), ahead) < 0
    end do
    left = pack([(i, i=1, size(number))], number > 0)
    n = size(left)
    number(left) = [(i, i=1, n)]
    do i = 1, n
      k = outlines%next(left(i))
      do while (number(k) == 0 .and. to_previous(k))
        outlines%finish(left(i)) = outlines%finish(k)
        k = outlines%next(k)
      end do
      begins = outlines%start(k)
      do while (number(k) == 0)
        k = outlines%next(k)
      end do
      outlines%start(k) = begins
      outlines%next(left(i)) = k
      outlines%previous(k) = left(i)
    end do
    outlines%element = outlines%element(left)
    outlines%block = outlines%block(left)
    outlines%start = outlines%start(left)
    outlines%finish = outlines%finish(left)
    outlines%joint = outlines%joint(left)
    outlines%next = number(outlines%next(left))
    outlines%previous = number(outlines%previous(left))

  contains

    !> Whether an edge is a sliver of one of another element that follows one way around, beyond others.
    pure logical function ends_long(edge, beside)
      integer, intent(in) :: edge
      integer, intent(in) :: beside(:)             !! (n) edge that follows each
      integer :: j, k

      ends_long = .false.
      k = edge
      do j = 1, most_slivers + 1
        k = beside(k)
        if (.not. on_the_same_side(edge, k)) return
        ends_long = norm2(along(edge)) <= sliver*norm2(along(k)) .and. outlines%element(edge) /= outlines%element(k)
        if (ends_long) return
      end do
    end function ends_long

    !> Whether an edge that is no sliver follows a sliver one way around on its side, beyond others.
    pure logical function has_on_side(edge, beside)
      integer, intent(in) :: edge
      integer, intent(in) :: beside(:)             !! (n) edge that follows each
      integer :: k

      k = beside(edge)
      do while (is_sliver(k) .and. on_the_same_side(edge, k))
        k = beside(k)
      end do
      has_on_side = .not. is_sliver(k) .and. on_the_same_side(edge, k)
    end function has_on_side

    !> Whether two edges are of one joint material, and on one line, to what the longer one tells.
    pure logical function on_the_same_side(a, b)
      integer, intent(in) :: a, b

      on_the_same_side = a /= b .and. outlines%joint(a) == outlines%joint(b) .and. dot_product(along(a), along(b)) > 0
      if (on_the_same_side) &
        on_the_same_side = abs(cross(along(a), along(b))) <= straight*max(norm2(along(a)), norm2(along(b)))**2
    end function on_the_same_side

    !> From the start of an edge to its end, length.
    pure function along(edge)
      integer, intent(in) :: edge
      real(dp) :: along(2)

      along = vertex(:, outlines%finish(edge)) - vertex(:, outlines%start(edge))
    end function along

    !> Of two vectors.
    pure real(dp) function cross(a, b)
      real(dp), intent(in) :: a(2), b(2)

      cross = a(1)*b(2) - a(2)*b(1)
    end function cross

  end subroutine join_slivers

  !> Finds the straight sides that edges lie on, with vertices in between where a line of the mesh or a corner of another ends.
  pure subroutine find_sides(vertex, outlines)
    real(dp), intent(in) :: vertex(:, :)           !! (2, n_vertices) at the start, length
    type(outlines_t), intent(inout) :: outlines
    real(dp) :: along(2, size(outlines%start))
    integer :: i, k, last

    allocate (outlines%side(2, size(outlines%start)), outlines%begins_side(size(outlines%start)))
    along = vertex(:, outlines%finish) - vertex(:, outlines%start)
    do i = 1, size(along, 2)
      associate (a => along(:, outlines%previous(i)), b => along(:, i))
        outlines%begins_side(i) = dot_product(a, b) <= 0 .or. abs(a(1)*b(2) - a(2)*b(1)) > straight*norm2(a)*norm2(b)
      end associate
    end do
    do i = 1, size(along, 2)
      if (.not. outlines%begins_side(i)) cycle
      last = i
      do while (.not. outlines%begins_side(outlines%next(last)))
        last = outlines%next(last)
      end do
      k = i
      do
        outlines%side(:, k) = [outlines%start(i), outlines%finish(last)]
        if (k == last) exit
        k = outlines%next(k)
      end do
    end do
  end subroutine find_sides

end module scree_outlines
