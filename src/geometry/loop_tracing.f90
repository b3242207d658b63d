!> Lines that meet end to end, to closed loops.
!>
!> Ends closer than the snap distance are one node. Every node must join two lines; the loops are then the blocks.
!> The search for nodes and crossings runs over lines sorted along x.
module scree_loop_tracing
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_kinds, only: dp
  use scree_regions, only: regions_t
  use scree_scene, only: line_t
  implicit none
  private
  public :: trace_loops

contains

  !> Traces closed loops, each counter-clockwise, in the order of their first lines.
  !>
  !> Errors, with the line of the deck: lines that cross or touch elsewhere than at their ends, an end where not just
  !> two lines meet, a loop without area.
  subroutine trace_loops(deck_name, lines, snap, shape, vertex, error)
    character(len=*), intent(in) :: deck_name
    type(line_t), intent(in) :: lines(:)
    real(dp), intent(in) :: snap                          !! distance of ends that are one node, length
    type(regions_t), intent(out) :: shape
    real(dp), allocatable, intent(out) :: vertex(:, :)    !! (2, n_vertices), length
    type(error_t), allocatable, intent(out) :: error
    integer :: node(2, size(lines)), n_nodes, meeting(2, 2*size(lines)), degree(2*size(lines))
    real(dp) :: place(2, 2*size(lines))
    logical :: used(size(lines))
    integer :: at, start, i, k, line, n_loops, n_vertices, from

    call number_nodes(lines, snap, node, place, n_nodes)
    degree = 0
    do i = 1, size(lines)
      if (node(1, i) == node(2, i)) then
        call wrong(i, 'a line longer than the snap distance e0 w0', 'a shorter one')
        return
      end if
      do k = 1, 2
        at = node(k, i)
        degree(at) = degree(at) + 1
        if (degree(at) > 2) then
          call wrong(i, 'two lines at an end, as lines that cross or branch are not cut', 'a third line')
          return
        end if
        meeting(degree(at), at) = i
      end do
    end do
    do i = 1, size(lines)
      do k = 1, 2
        if (degree(node(k, i)) == 2) cycle
        call wrong(i, 'another line at each end, as lines must close', 'an end that is free')
        return
      end do
    end do
    call find_crossing(place, node, i)
    if (i > 0) then
      call wrong(i, 'lines that meet only at their ends, as lines that cross are not cut', 'a line that crosses another')
      return
    end if

    allocate (shape%first_vertex(size(lines) + 1), shape%joint(size(lines)), vertex(2, size(lines)))
    used = .false.
    n_loops = 0
    n_vertices = 0
    do start = 1, size(lines)
      if (used(start)) cycle
      n_loops = n_loops + 1
      from = n_vertices + 1
      shape%first_vertex(n_loops) = from
      line = start
      at = node(1, start)
      do
        used(line) = .true.
        n_vertices = n_vertices + 1
        vertex(:, n_vertices) = place(:, at)
        shape%joint(n_vertices) = lines(line)%material
        at = sum(node(:, line)) - at ! the other end
        line = sum(meeting(:, at)) - line
        if (line == start) exit
      end do
      if (n_vertices - from < 2) then
        call wrong(start, 'lines that enclose an area', 'two lines with the same ends')
        return
      end if
      call orient(vertex(:, from:n_vertices), shape%joint(from:n_vertices))
    end do
    shape%first_vertex = [shape%first_vertex(:n_loops), n_vertices + 1]
    shape%first_loop = [(i, i=1, n_loops + 1)]

  contains

    !> Error at a line of the deck.
    subroutine wrong(i, expected, found)
      integer, intent(in) :: i
      character(len=*), intent(in) :: expected, found
      character(len=12) :: number

      write (number, '(i0)') lines(i)%deck_line
      call fail(error, status_bad_input, deck_name//':'//trim(number)//': expected '//expected//', found '//found)
    end subroutine wrong

  end subroutine trace_loops

  !> Gives ends at one place one number.
  pure subroutine number_nodes(lines, snap, node, place, n_nodes)
    type(line_t), intent(in) :: lines(:)
    real(dp), intent(in) :: snap
    integer, intent(out) :: node(:, :)   !! (2, n_lines)
    real(dp), intent(out) :: place(:, :) !! (2, n_nodes)
    integer, intent(out) :: n_nodes
    integer :: order(2*size(lines)), number(2*size(lines)), i, k, other
    real(dp) :: x(2, 2*size(lines))

    do i = 1, size(lines)
      x(:, 2*i - 1:2*i) = lines(i)%ends
    end do
    order = sorted(x(1, :))
    number = 0
    n_nodes = 0
    place = 0.0_dp
    do i = 1, size(order)
      if (number(order(i)) > 0) cycle
      n_nodes = n_nodes + 1
      number(order(i)) = n_nodes
      place(:, n_nodes) = x(:, order(i))
      do k = i + 1, size(order)
        other = order(k)
        if (x(1, other) - x(1, order(i)) > snap) exit
        if (number(other) == 0 .and. norm2(x(:, other) - x(:, order(i))) <= snap) number(other) = n_nodes
      end do
    end do
    node = reshape(number, [2, size(lines)])
  end subroutine number_nodes

  !> A line that meets another elsewhere than at a node they share; 0 where there is none.
  pure subroutine find_crossing(place, node, crossing)
    real(dp), intent(in) :: place(:, :)
    integer, intent(in) :: node(:, :)
    integer, intent(out) :: crossing
    real(dp) :: low(size(node, 2)), high(size(node, 2))
    integer :: order(size(node, 2)), i, j, k

    do i = 1, size(node, 2)
      low(i) = minval(place(1, node(:, i)))
      high(i) = maxval(place(1, node(:, i)))
    end do
    order = sorted(low)
    crossing = 0
    do i = 1, size(order)
      do k = i + 1, size(order)
        j = order(k)
        if (low(j) > high(order(i))) exit
        if (touch(place(:, node(:, order(i))), place(:, node(:, j)), node(:, order(i)), node(:, j))) then
          crossing = max(order(i), j)
          return
        end if
      end do
    end do
  end subroutine find_crossing

  !> Whether two lines meet elsewhere than at a node they share.
  pure logical function touch(a, b, node_a, node_b)
    real(dp), intent(in) :: a(2, 2), b(2, 2)
    integer, intent(in) :: node_a(2), node_b(2)
    real(dp) :: s(2), t(2)
    integer :: i, j

    s = [side(a, b(:, 1)), side(a, b(:, 2))]
    t = [side(b, a(:, 1)), side(b, a(:, 2))]
    do i = 1, 2
      do j = 1, 2
        if (node_a(i) /= node_b(j)) cycle
        ! from a node they share they overlap only where the other ends lie on the same ray
        touch = .not. abs(s(3 - j)) > 0.0_dp .and. &
                dot_product(a(:, 3 - i) - a(:, i), b(:, 3 - j) - b(:, j)) > 0.0_dp
        return
      end do
    end do
    if (all(.not. abs(s) > 0.0_dp)) then ! on one straight line
      touch = maxval(a(1, :)) >= minval(b(1, :)) .and. maxval(b(1, :)) >= minval(a(1, :)) .and. &
              maxval(a(2, :)) >= minval(b(2, :)) .and. maxval(b(2, :)) >= minval(a(2, :))
    else
      touch = s(1)*s(2) <= 0.0_dp .and. t(1)*t(2) <= 0.0_dp
    end if
  end function touch

  !> Twice the signed area of a line and a point, divided by the largest size that keeps products in range: -1, 0 or 1.
  pure real(dp) function side(line, point)
    real(dp), intent(in) :: line(2, 2), point(2)
    real(dp) :: area, a(2), b(2)

    a = line(:, 2) - line(:, 1)
    b = point - line(:, 1)
    area = a(1)*b(2) - a(2)*b(1)
    side = 0.0_dp
    if (abs(area) > 4*epsilon(area)*(abs(a(1)*b(2)) + abs(a(2)*b(1)))) side = sign(1.0_dp, area)
  end function side

  !> Turns a loop counter-clockwise; the joint of an edge stays with its edge.
  pure subroutine orient(vertex, joint)
    real(dp), intent(inout) :: vertex(:, :)
    integer, intent(inout) :: joint(:)
    real(dp) :: area, a(2), b(2)
    integer :: k, n

    n = size(joint)
    area = 0.0_dp
    do k = 2, n - 1
      a = vertex(:, k) - vertex(:, 1)
      b = vertex(:, k + 1) - vertex(:, 1)
      area = area + a(1)*b(2) - a(2)*b(1)
    end do
    if (area >= 0.0_dp) return
    vertex(:, 2:) = vertex(:, n:2:-1)
    joint = joint(n:1:-1)
  end subroutine orient

  !> Places of the values in ascending order (merge sort, stable).
  pure function sorted(value) result(order)
    real(dp), intent(in) :: value(:)
    integer :: order(size(value)), merged(size(value)), width, low, middle, high, a, b, k, n

    n = size(value)
    order = [(k, k=1, n)]
    width = 1
    do while (width < n)
      do low = 1, n, 2*width
        middle = min(low + width, n + 1)
        high = min(low + 2*width, n + 1)
        a = low
        b = middle
        do k = low, high - 1
          if (b >= high) then
            merged(k) = order(a)
            a = a + 1
          else if (a >= middle) then
            merged(k) = order(b)
            b = b + 1
          else if (value(order(b)) < value(order(a))) then
            merged(k) = order(b)
            b = b + 1
          else
            merged(k) = order(a)
            a = a + 1
          end if
        end do
      end do
      order = merged
      width = 2*width
    end do
  end function sorted

end module scree_loop_tracing
