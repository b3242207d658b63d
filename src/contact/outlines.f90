!> The outlines of bodies, from the polygons of their elements.
module scree_outlines
  use scree_contacts, only: outlines_t
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_kinds, only: dp
  use scree_regions, only: region_count, regions_t
  use scree_sorting, only: sort_by
  use scree_text, only: number_text
  implicit none
  private
  public :: make_outlines

  !> An edge that lines of the mesh leave of a side, over the edge beside it on that side, up to which it is part of that: contacts
  !> are looked for as far as the edges about them are long, and such an edge tells nothing of its corner.
  real(dp), parameter :: sliver = 1e-2_dp
  real(dp), parameter :: straight = 1e-6_dp !! of an edge, up to which a vertex is on its line

contains

  !> Edges that are no line of the mesh, and which follows which around the body. Slivers that the mesh leaves of a side are part of
  !> the edge beside them.
  !>
  !> Where an edge ends, the outline goes on in the same element or, where a line of the mesh follows, in another: of the
  !> edges that follow a line of the mesh and begin at the same position, to the last bit, with the one that is met first when
  !> turning clockwise from the way back; in between lies the body. Errors: an edge after which the outline
  !> does not go on, the first one without `next`.
  subroutine make_outlines(shape, vertex, block, outlines, error)
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
    call group_by_block(outlines)
    allocate (outlines%inside(2, 0))
    allocate (outlines%fixed(size(outlines%start)), outlines%gone(size(outlines%start)), source=.false.)

  contains

    !> The edge that the outline goes on with in another element after edge i; 0 where there is none.
    pure integer function edge_after(i)
      integer, intent(in) :: i
      real(dp), parameter :: whole_turn = 2*acos(-1.0_dp)
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
          turn = modulo(back - direction(vertex(:, outlines%finish(j)) - position), whole_turn)
          if (turn < other_side) turn = whole_turn ! no corner is as sharp
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

  !> Joins edges that are slivers of a side to the longer one of those beside them on that side, of another element; the shortest
  !> may become beside a long one as others are joined to that.
  subroutine join_slivers(vertex, outlines)
    real(dp), intent(in) :: vertex(:, :)           !! (2, n_vertices) at the start, length
    type(outlines_t), intent(inout) :: outlines
    integer :: number(size(outlines%start))        ! of what is left; 0: joined
    integer, allocatable :: left(:)
    integer :: before, i, n

    number = 1
    do
      before = count(number > 0)
      do i = 1, size(number)
        if (number(i) > 0) call join(i)
      end do
      if (count(number > 0) == before) exit
    end do
    left = pack([(i, i=1, size(number))], number > 0)
    n = size(left)
    number(left) = [(i, i=1, n)]
    outlines%element = outlines%element(left)
    outlines%block = outlines%block(left)
    outlines%start = outlines%start(left)
    outlines%finish = outlines%finish(left)
    outlines%joint = outlines%joint(left)
    outlines%next = number(outlines%next(left))
    outlines%previous = number(outlines%previous(left))

  contains

    !> Joins edge i to one beside it, if it is a sliver of its side.
    subroutine join(i)
      integer, intent(in) :: i
      integer :: beside(2)

      beside = [outlines%previous(i), outlines%next(i)]
      if (.not. is_sliver(i, beside(1))) beside(1) = 0
      if (.not. is_sliver(i, beside(2))) beside(2) = 0
      if (all(beside > 0)) beside(merge(1, 2, length_of(beside(1)) < length_of(beside(2)))) = 0
      if (beside(1) > 0) then
        outlines%finish(beside(1)) = outlines%finish(i)
      else if (beside(2) > 0) then
        outlines%start(beside(2)) = outlines%start(i)
      else
        return
      end if
      outlines%next(outlines%previous(i)) = outlines%next(i)
      outlines%previous(outlines%next(i)) = outlines%previous(i)
      number(i) = 0
    end subroutine join

    !> Whether an edge is a sliver of the side that the one beside it lies on.
    pure logical function is_sliver(edge, beside)
      integer, intent(in) :: edge, beside
      real(dp) :: along(2), own(2)

      is_sliver = .false.
      if (outlines%element(edge) == outlines%element(beside) .or. outlines%joint(edge) /= outlines%joint(beside)) return
      own = vertex(:, outlines%finish(edge)) - vertex(:, outlines%start(edge))
      along = vertex(:, outlines%finish(beside)) - vertex(:, outlines%start(beside))
      if (norm2(own) > sliver*norm2(along) .or. dot_product(own, along) < 0) return
      is_sliver = abs(own(1)*along(2) - own(2)*along(1)) <= straight*norm2(along)**2
    end function is_sliver

    !> Length of an edge.
    pure real(dp) function length_of(edge)
      integer, intent(in) :: edge

      length_of = norm2(vertex(:, outlines%finish(edge)) - vertex(:, outlines%start(edge)))
    end function length_of

  end subroutine join_slivers

  !> Lists the edges by blocks.
  pure subroutine group_by_block(outlines)
    type(outlines_t), intent(inout) :: outlines
    integer :: b, i

    allocate (outlines%first(maxval(outlines%block) + 1), source=0)
    allocate (outlines%of_block(size(outlines%block)))
    do i = 1, size(outlines%block)
      outlines%first(outlines%block(i)) = outlines%first(outlines%block(i)) + 1
    end do
    outlines%first(1) = outlines%first(1) + 1
    do b = 2, size(outlines%first)
      outlines%first(b) = outlines%first(b) + outlines%first(b - 1)
    end do
    do i = size(outlines%block), 1, -1
      b = outlines%block(i)
      outlines%first(b) = outlines%first(b) - 1
      outlines%of_block(outlines%first(b)) = i
    end do
  end subroutine group_by_block

end module scree_outlines
