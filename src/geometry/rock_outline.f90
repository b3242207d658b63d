!> The rock that is left of a window when tunnels and what lies above slopes are cut out: its boundary, and lines in it.
!>
!> One rule does it all. A line is split wherever it meets an outline; the middle of a piece, moved a little to either
!> side, tells whether there is rock on that side. A piece of an outline with rock on one side bounds the rock, a piece of
!> any line with rock on both sides lies in it. So outlines may overlap, share sides, and leave the window.
module scree_rock_outline
  use scree_kinds, only: dp
  use scree_polygon, only: holds, inner_place
  use scree_scene, only: line_t, point_t
  implicit none
  private
  public :: boundary_lines, clip_line, close_slope, crosses_itself, has_rock_at, hole_points, make_rock, meets_rock, outline_t, &
            reaches_into_window, rock_t, rounded

  integer, parameter, public :: window_outline = 1, tunnel_outline = 2, slope_outline = 3

  !> A closed polygon, in the coordinates of its deck.
  type :: outline_t
    integer :: kind = window_outline
    real(dp), allocatable :: corner(:, :)  !! (2, n) either way round, length
    integer :: material = 1                !! joint material of its sides
    integer :: deck_line = 0               !! where it stands in its deck
  end type outline_t

  !> A window and what is cut out of it.
  type :: rock_t
    type(outline_t), allocatable :: outline(:) !! the window first; about the middle, length
    real(dp) :: middle(2) = 0.0_dp             !! of the window, length
    real(dp) :: extent = 0.0_dp                !! the larger of its width and height, length
    integer :: decimals = 0                    !! coordinates are whole multiples of 10^-decimals
  end type rock_t

  !> Fractions of the extent. Each is ten times the one before, so that none takes the other's differences for its own.
  real(dp), parameter :: digit = 1e-10_dp !! coordinates are rounded to the next power of ten above it, at most 1e-9
  real(dp), parameter :: near = 2e-9_dp   !! what is closer touches
  real(dp), parameter :: aside = 2e-8_dp  !! distance of the places that tell whether there is rock beside a line
  !> Of the largest coordinate: what a real holds of it, with a digit to spare.
  real(dp), parameter :: resolved = 1e-15_dp

contains

  !> Makes the rock of closed outlines, the window first.
  pure subroutine make_rock(outline, rock)
    type(outline_t), intent(in) :: outline(:)
    type(rock_t), intent(out) :: rock
    real(dp) :: low(2), high(2)
    integer :: i, k

    low = minval(outline(1)%corner, 2)
    high = maxval(outline(1)%corner, 2)
    rock%extent = maxval(high - low)
    rock%decimals = -ceiling(log10(max(digit*rock%extent, resolved*maxval(abs([low, high])))))
    rock%middle = rounded(rock%decimals, low + (high - low)/2)
    rock%outline = outline
    do i = 1, size(outline)
      do k = 1, size(outline(i)%corner, 2)
        rock%outline(i)%corner(:, k) = rounded(rock%decimals, outline(i)%corner(:, k)) - rock%middle
      end do
    end do
  end subroutine make_rock

  !> A number to so many decimals, the same on every computer but for a tie.
  elemental real(dp) function rounded(decimals, x)
    integer, intent(in) :: decimals
    real(dp), intent(in) :: x

    if (decimals >= 0) then
      rounded = anint(x*10.0_dp**decimals)/10.0_dp**decimals
    else
      rounded = anint(x/10.0_dp**(-decimals))*10.0_dp**(-decimals)
    end if
    rounded = rounded + 0.0_dp ! no -0
  end function rounded

  !> Lines around the rock, in the order of the outlines. Lines of no length are left out, and no others: a missing side would
  !> open the outline.
  pure subroutine boundary_lines(rock, lines)
    type(rock_t), intent(in) :: rock
    type(line_t), allocatable, intent(out) :: lines(:)
    real(dp), allocatable :: position(:, :)
    integer :: i, k, m, n
    logical :: beside(2)

    allocate (lines(16))
    n = 0
    do i = 1, size(rock%outline)
      do k = 1, size(rock%outline(i)%corner, 2)
        call split_line(rock, side_of(rock%outline(i), k), position)
        do m = 1, size(position, 2) - 1
          beside = rock_beside(rock, position(:, m:m + 1))
          if (beside(1) .eqv. beside(2)) cycle
          if (any_near(rock, i - 1, middle_of(position(:, m:m + 1)))) cycle ! an earlier outline has this piece
          call add_line(rock, position(:, m:m + 1), 0.0_dp, rock%outline(i)%material, rock%outline(i)%deck_line, lines, n)
        end do
      end do
    end do
    lines = lines(:n)
  end subroutine boundary_lines

  !> Adds the parts of a line (about the middle) that lie in the rock and are longer than `shortest`.
  pure subroutine clip_line(rock, ends, shortest, material, deck_line, lines, n)
    type(rock_t), intent(in) :: rock
    real(dp), intent(in) :: ends(2, 2), shortest
    integer, intent(in) :: material, deck_line
    type(line_t), allocatable, intent(inout) :: lines(:)
    integer, intent(inout) :: n !! lines in use
    real(dp), allocatable :: position(:, :)
    real(dp) :: part(2, 2)
    integer :: m
    logical :: open

    call split_line(rock, ends, position)
    open = .false.
    do m = 1, size(position, 2) - 1
      if (all(rock_beside(rock, position(:, m:m + 1)))) then
        if (.not. open) part(:, 1) = position(:, m)
        part(:, 2) = position(:, m + 1)
        open = .true.
      else
        if (open) call add_line(rock, part, shortest, material, deck_line, lines, n)
        open = .false.
      end if
    end do
    if (open) call add_line(rock, part, shortest, material, deck_line, lines, n)
  end subroutine clip_line

  !> Adds a line about the middle, in the coordinates of the deck, rounded; not where it is too short.
  pure subroutine add_line(rock, ends, shortest, material, deck_line, lines, n)
    type(rock_t), intent(in) :: rock
    real(dp), intent(in) :: ends(2, 2), shortest
    integer, intent(in) :: material, deck_line
    type(line_t), allocatable, intent(inout) :: lines(:)
    integer, intent(inout) :: n
    type(line_t) :: line
    type(line_t), allocatable :: longer(:)
    integer :: k

    do k = 1, 2
      line%ends(:, k) = rounded(rock%decimals, ends(:, k) + rock%middle)
    end do
    if (norm2(line%ends(:, 2) - line%ends(:, 1)) <= shortest) return
    line%material = material
    line%deck_line = deck_line
    if (n == size(lines)) then
      allocate (longer(2*n + 16))
      longer(:n) = lines
      call move_alloc(longer, lines)
    end if
    n = n + 1
    lines(n) = line
  end subroutine add_line

  !> A point in each hole that tunnels make in the rock and that no opening joins to the outside, as its inside would be
  !> a block. Tunnels that overlap or share a wall are one hole.
  pure subroutine hole_points(rock, points)
    type(rock_t), intent(in) :: rock
    type(point_t), allocatable, intent(out) :: points(:)
    integer :: hole(size(rock%outline)) ! the first outline of the hole; 1, the window, is the outside
    real(dp), allocatable :: position(:, :)
    real(dp) :: at(2)
    integer :: from, to, i, j, k, m

    hole = [(i, i=1, size(hole))]
    do i = 2, size(hole)
      if (rock%outline(i)%kind == slope_outline) hole(i) = 1
    end do
    do i = 2, size(hole)
      do k = 1, size(rock%outline(i)%corner, 2)
        call split_line(rock, side_of(rock%outline(i), k), position)
        do m = 1, size(position, 2) - 1
          at = middle_of(position(:, m:m + 1))
          do j = 1, size(hole)
            if (j == i) cycle
            if ((holds(rock%outline(j)%corner, at) .eqv. j == 1) .and. .not. is_near(rock, j, at)) cycle
            from = max(hole(i), hole(j))
            to = min(hole(i), hole(j))
            where (hole == from) hole = to
          end do
        end do
      end do
    end do
    allocate (points(0))
    do i = 2, size(hole)
      if (hole(i) /= i) cycle
      at = rounded(rock%decimals, inner_place(rock%outline(i)%corner) + rock%middle)
      points = [points, point_t(at, rock%outline(i)%deck_line, 0)]
    end do
  end subroutine hole_points

  !> Whether a position, in the coordinates of the deck, is in the rock or on its boundary.
  pure logical function has_rock_at(rock, position)
    type(rock_t), intent(in) :: rock
    real(dp), intent(in) :: position(2)
    integer :: i

    has_rock_at = holds(rock%outline(1)%corner, position - rock%middle) .or. is_near(rock, 1, position - rock%middle)
    do i = 2, size(rock%outline)
      if (holds(rock%outline(i)%corner, position - rock%middle) .and. .not. is_near(rock, i, position - rock%middle)) &
        has_rock_at = .false.
    end do
  end function has_rock_at

  !> Whether a line, in the coordinates of the deck, begins in the rock or runs in it or along it somewhere.
  pure logical function meets_rock(rock, ends)
    type(rock_t), intent(in) :: rock
    real(dp), intent(in) :: ends(2, 2)
    real(dp), allocatable :: position(:, :)
    integer :: m

    meets_rock = has_rock_at(rock, ends(:, 1))
    call split_line(rock, ends - spread(rock%middle, 2, 2), position)
    do m = 1, size(position, 2) - 1
      meets_rock = meets_rock .or. any(rock_beside(rock, position(:, m:m + 1)))
    end do
  end function meets_rock

  !> Whether an outline takes something from the window.
  pure logical function reaches_into_window(rock, i)
    type(rock_t), intent(in) :: rock
    integer, intent(in) :: i
    real(dp), allocatable :: position(:, :)
    real(dp) :: at(2)
    integer :: k, m

    reaches_into_window = .true.
    do k = 1, size(rock%outline(i)%corner, 2)
      call split_line(rock, side_of(rock%outline(i), k), position)
      do m = 1, size(position, 2) - 1
        at = middle_of(position(:, m:m + 1))
        if (holds(rock%outline(1)%corner, at) .and. .not. is_near(rock, 1, at)) return
      end do
    end do
    reaches_into_window = holds(rock%outline(i)%corner, inner_place(rock%outline(1)%corner))
  end function reaches_into_window

  !> Closes a slope around everything above it, well outside the window.
  !>
  !> From a point left of the window, or above it, to a point right of the window, or above it, either way round;
  !> `closed` is not allocated for any other.
  pure subroutine close_slope(window, slope, closed)
    real(dp), intent(in) :: window(:, :), slope(:, :)
    real(dp), allocatable, intent(out) :: closed(:, :)
    real(dp) :: low(2), high(2), far, edge(2), line(size(slope, 1), size(slope, 2))
    integer :: n

    n = size(slope, 2)
    line = slope
    if (line(1, n) < line(1, 1)) line = line(:, n:1:-1)
    low = minval(window, 2)
    high = maxval(window, 2)
    if (.not. (line(1, 1) <= low(1) .or. line(2, 1) >= high(2))) return
    if (.not. (line(1, n) >= high(1) .or. line(2, n) >= high(2)) .or. .not. line(1, n) > line(1, 1)) return
    far = max(high(2), maxval(line(2, :))) + maxval(high - low)
    closed = line
    edge = line(1, [1, n])
    if (line(1, n) >= high(1)) then ! level to the right, else straight up
      edge(2) = maxval(line(1, :)) + maxval(high - low)
      closed = reshape([closed, edge(2), line(2, n)], [2, size(closed, 2) + 1])
    end if
    if (line(1, 1) <= low(1)) then
      edge(1) = minval(line(1, :)) - maxval(high - low)
      closed = reshape([edge(1), line(2, 1), closed], [2, size(closed, 2) + 1])
    end if
    closed = reshape([closed, edge(2), far, edge(1), far], [2, size(closed, 2) + 2])
  end subroutine close_slope

  !> Whether sides of a polygon meet elsewhere than at the corner they share.
  pure logical function crosses_itself(corner)
    real(dp), intent(in) :: corner(:, :)
    real(dp) :: a(2, 2), b(2, 2)
    integer :: i, j, n

    n = size(corner, 2)
    crosses_itself = .true.
    do i = 1, n
      a = corner(:, [i, modulo(i, n) + 1])
      do j = i + 1, n
        b = corner(:, [j, modulo(j, n) + 1])
        if (j == i + 1) then
          if (folds(a(:, 1), a(:, 2), b(:, 2))) return
        else if (i == 1 .and. j == n) then
          if (folds(b(:, 1), b(:, 2), a(:, 2))) return
        else if (meet(a, b)) then
          return
        end if
      end do
    end do
    crosses_itself = .false.
  end function crosses_itself

  !> Whether the way from p by q to r goes straight back.
  pure logical function folds(p, q, r)
    real(dp), intent(in) :: p(2), q(2), r(2)

    folds = turn(p, q, r) == 0 .and. dot_product(p - q, r - q) >= 0.0_dp
  end function folds

  !> Whether two lines have a point in common.
  pure logical function meet(a, b)
    real(dp), intent(in) :: a(2, 2), b(2, 2)
    integer :: s(2), t(2)

    meet = .false.
    if (any(maxval(a, 2) < minval(b, 2)) .or. any(maxval(b, 2) < minval(a, 2))) return
    s = [turn(a(:, 1), a(:, 2), b(:, 1)), turn(a(:, 1), a(:, 2), b(:, 2))]
    t = [turn(b(:, 1), b(:, 2), a(:, 1)), turn(b(:, 1), b(:, 2), a(:, 2))]
    meet = s(1)*s(2) <= 0 .and. t(1)*t(2) <= 0
  end function meet

  !> 1 where the way from p by q to r turns left, -1 to the right, 0 where it is straight to round-off.
  pure integer function turn(p, q, r)
    real(dp), intent(in) :: p(2), q(2), r(2)
    real(dp) :: area, a(2), b(2)

    a = q - p
    b = r - p
    area = a(1)*b(2) - a(2)*b(1)
    turn = 0
    if (abs(area) > 4*epsilon(area)*(abs(a(1)*b(2)) + abs(a(2)*b(1)))) turn = merge(1, -1, area > 0.0_dp)
  end function turn

  !> Ends of side `k` of an outline.
  pure function side_of(outline, k) result(ends)
    type(outline_t), intent(in) :: outline
    integer, intent(in) :: k
    real(dp) :: ends(2, 2)

    ends = outline%corner(:, [k, modulo(k, size(outline%corner, 2)) + 1])
  end function side_of

  !> Middle of a line.
  pure function middle_of(ends) result(middle)
    real(dp), intent(in) :: ends(2, 2)
    real(dp) :: middle(2)

    middle = (ends(:, 1) + ends(:, 2))/2
  end function middle_of

  !> Places that split a line where outlines meet it, with its ends, in order.
  pure subroutine split_line(rock, ends, position)
    type(rock_t), intent(in) :: rock
    real(dp), intent(in) :: ends(2, 2)
    real(dp), allocatable, intent(out) :: position(:, :) !! (2, n)
    real(dp), allocatable :: along(:)
    real(dp) :: way(2), length, touching, side(2, 2), off(2), on(2), at
    integer :: i, k

    length = norm2(ends(:, 2) - ends(:, 1))
    touching = near*rock%extent
    position = ends
    along = [0.0_dp, length]
    if (length <= touching) return
    way = (ends(:, 2) - ends(:, 1))/length
    do i = 1, size(rock%outline)
      do k = 1, size(rock%outline(i)%corner, 2)
        side = side_of(rock%outline(i), k)
        off = way(1)*(side(2, :) - ends(2, 1)) - way(2)*(side(1, :) - ends(1, 1))
        on = way(1)*(side(1, :) - ends(1, 1)) + way(2)*(side(2, :) - ends(2, 1))
        if (abs(off(1)) <= touching) call keep(on(1), side(:, 1), touching, along, position)
        if (any(abs(off) <= touching) .or. (off(1) > 0.0_dp .eqv. off(2) > 0.0_dp)) cycle
        at = on(1) + (on(2) - on(1))*off(1)/(off(1) - off(2))
        call keep(at, crossing_of(ends, side), touching, along, position)
      end do
    end do
  end subroutine split_line

  !> Keeps a position on a line, in order; not where one is already there.
  pure subroutine keep(at, here, touching, along, position)
    real(dp), intent(in) :: at      !! from the first end, length
    real(dp), intent(in) :: here(2)
    real(dp), intent(in) :: touching
    real(dp), allocatable, intent(inout) :: along(:), position(:, :)
    integer :: before

    if (any(abs(along - at) <= touching) .or. at < 0.0_dp .or. at > along(size(along))) return
    before = count(along < at)
    along = [along(:before), at, along(before + 1:)]
    position = reshape([position(:, :before), here, position(:, before + 1:)], [2, size(along)])
  end subroutine keep

  !> Where two lines that are not parallel cross; the same position to the last bit for either order of the two.
  pure function crossing_of(a, b) result(at)
    real(dp), intent(in) :: a(2, 2), b(2, 2)
    real(dp) :: at(2), off(2), way(2)

    if (a(1, 1) > b(1, 1) .or. (.not. a(1, 1) < b(1, 1) .and. a(2, 1) > b(2, 1))) then
      way = a(:, 2) - a(:, 1)
      off = way(1)*(b(2, :) - a(2, 1)) - way(2)*(b(1, :) - a(1, 1))
      at = b(:, 1) + (b(:, 2) - b(:, 1))*(off(1)/(off(1) - off(2)))
    else
      way = b(:, 2) - b(:, 1)
      off = way(1)*(a(2, :) - b(2, 1)) - way(2)*(a(1, :) - b(1, 1))
      at = a(:, 1) + (a(:, 2) - a(:, 1))*(off(1)/(off(1) - off(2)))
    end if
  end function crossing_of

  !> Whether there is rock to the left and to the right of the middle of a piece.
  pure function rock_beside(rock, ends) result(beside)
    type(rock_t), intent(in) :: rock
    real(dp), intent(in) :: ends(2, 2)
    logical :: beside(2)
    real(dp) :: step(2)

    step = ends(:, 2) - ends(:, 1)
    step = aside*rock%extent*[-step(2), step(1)]/max(norm2(step), tiny(step))
    beside = [is_rock(middle_of(ends) + step), is_rock(middle_of(ends) - step)]

  contains

    !> Whether a position is in the window and in nothing cut out.
    pure logical function is_rock(position)
      real(dp), intent(in) :: position(2)
      integer :: i

      is_rock = holds(rock%outline(1)%corner, position)
      do i = 2, size(rock%outline)
        if (.not. is_rock) return
        is_rock = .not. holds(rock%outline(i)%corner, position)
      end do
    end function is_rock

  end function rock_beside

  !> Whether one of the first `n` outlines passes through a position.
  pure logical function any_near(rock, n, position)
    type(rock_t), intent(in) :: rock
    integer, intent(in) :: n
    real(dp), intent(in) :: position(2)
    integer :: i

    any_near = .false.
    do i = 1, n
      any_near = any_near .or. is_near(rock, i, position)
    end do
  end function any_near

  !> Whether an outline passes through a position.
  pure logical function is_near(rock, i, position)
    type(rock_t), intent(in) :: rock
    integer, intent(in) :: i
    real(dp), intent(in) :: position(2)
    integer :: k

    is_near = .false.
    do k = 1, size(rock%outline(i)%corner, 2)
      is_near = is_near .or. distance(side_of(rock%outline(i), k), position) <= near*rock%extent
    end do
  end function is_near

  !> Distance of a position from a line.
  pure real(dp) function distance(ends, position)
    real(dp), intent(in) :: ends(2, 2), position(2)
    real(dp) :: way(2), share

    way = ends(:, 2) - ends(:, 1)
    share = dot_product(position - ends(:, 1), way)/max(dot_product(way, way), tiny(share))
    distance = norm2(ends(:, 1) + min(max(share, 0.0_dp), 1.0_dp)*way - position)
  end function distance

end module scree_rock_outline
