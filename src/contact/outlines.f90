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
  integer, parameter :: most_slivers = 8    !! in a row: where lines of the mesh meet they come by threes
  !> Direction in which they are joined: along no axis, as rounding would tell then.
  real(dp), parameter :: ahead(2) = [1.0_dp, 0.618_dp]

contains

  !> Edges that are no line of the mesh, and which follows which around the body. Slivers that the mesh leaves of a side are part of
  !> the edge beside them.
  !>
  !> Where an edge ends, the outline goes on in the same element or, where a line of the mesh follows, in another: of the
  !> edges that follow a line of the mesh and begin at the same position, to the last bit, with the one that is met first when
  !> turning clockwise from the way back; in between lies the body. Errors: an edge after which the outline
  !> does not go on, the first one without `next`.
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

  !> Joins edges that are slivers of a side to the next one of another element that is not, beyond others that are: in one direction
  !> of all sides, so that both sides of a joint keep the same vertices, and where a corner is there, in the other.
  pure subroutine join_slivers(vertex, outlines)
    real(dp), intent(in) :: vertex(:, :)           !! (2, n_vertices) at the start, length
    type(outlines_t), intent(inout) :: outlines
    logical :: to_next(size(outlines%start)), to_previous(size(outlines%start)) ! joined to the edge after it, before it
    integer :: number(size(outlines%start))        ! of what is left
    integer, allocatable :: left(:)
    integer :: i, n

    do i = 1, size(number)
      to_next(i) = ends_long(i, outlines%next)
      to_previous(i) = ends_long(i, outlines%previous)
      if (to_next(i) .and. to_previous(i)) then
        to_next(i) = dot_product(along(i), ahead) > 0
        to_previous(i) = .not. to_next(i)
      end if
    end do
    left = pack([(i, i=1, size(number))], .not. (to_next .or. to_previous))
    n = size(left)
    number = 0
    number(left) = [(i, i=1, n)]
    do i = 1, n
      associate (edge => left(i), next => outlines%next(left(i)), previous => outlines%previous(left(i)))
        do while (to_previous(next))
          outlines%finish(edge) = outlines%finish(next)
          next = outlines%next(next)
        end do
        do while (to_next(previous))
          outlines%start(edge) = outlines%start(previous)
          previous = outlines%previous(previous)
        end do
        do while (number(next) == 0)
          next = outlines%next(next)
        end do
        do while (number(previous) == 0)
          previous = outlines%previous(previous)
        end do
      end associate
    end do
    outlines%element = outlines%element(left)
    outlines%block = outlines%block(left)
    outlines%start = outlines%start(left)
    outlines%finish = outlines%finish(left)
    outlines%joint = outlines%joint(left)
    outlines%next = number(outlines%next(left))
    outlines%previous = number(outlines%previous(left))

  contains

    !> Whether an edge is a sliver of one of another element that follows one way around, beyond others that are.
    pure logical function ends_long(edge, beside)
      integer, intent(in) :: edge
      integer, intent(in) :: beside(:)             !! (n) edge that follows each
      integer :: j, k

      ends_long = .false.
      k = edge
      do j = 1, most_slivers + 1
        k = beside(k)
        if (k == edge .or. outlines%joint(k) /= outlines%joint(edge) .or. .not. in_line(edge, k)) return
        ends_long = norm2(along(edge)) <= sliver*norm2(along(k))
        if (ends_long) exit
      end do
      if (ends_long) ends_long = outlines%element(edge) /= outlines%element(k)
    end function ends_long

    !> Whether an edge goes on in the direction of another: by as much as the longer one tells.
    pure logical function in_line(a, b)
      integer, intent(in) :: a, b

      in_line = dot_product(along(a), along(b)) > 0
      if (in_line) in_line = abs(cross(along(a), along(b))) <= straight*max(norm2(along(a)), norm2(along(b)))**2
    end function in_line

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
