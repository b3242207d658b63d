!> The convex chains of an outline: what lies between its hollow corners.
!>
!> Shi's contact theory is about convex angles: a hollow corner touches nothing, so an outline is cut there. Lines of a mesh leave
!> vertices on straight sides, and cutting leaves slivers. These are no corners, and are removed here, so the procedures that use
!> chains never see them.
!>
!> G.-H. Shi, *Contact theory*, Science China Technological Sciences 58 (2015) 1450-1496.
module scree_chains
  use scree_kinds, only: dp
  implicit none
  private
  public :: chains_t, corners_of, cut_at_hollow_corners, outline_edges

  !> Angle below which a vertex is on a straight side, as seen from either end of that side, rad. The simplified side is off by at
  !> most this ratio to the distance from its nearer end. That is a thousandth of the overlap that contacts are allowed, which is a
  !> thousandth of an edge. Coordinates of a deck with seven digits are within it.
  real(dp), parameter :: straight = 1e-6_dp
  !> Length of an edge over that of the longer one beside it, below which it is a sliver. Its direction is that of the rounding of
  !> its ends, and a corner that is moved by its length is moved by as little as `straight` allows.
  real(dp), parameter :: sliver = straight
  real(dp), parameter :: roundings = 8*epsilon(1.0_dp) !! of a distance from a line, over the largest coordinate
  integer, parameter :: least_corners = 3

  !> Convex chains of one outline. An outline without hollow corners is one closed chain; else every chain is open, and begins and
  !> ends at a hollow corner.
  type :: chains_t
    logical :: closed = .false.
    integer :: n_vertices = 0            !! of the outline
    integer, allocatable :: first(:)     !! (n+1) chain c has the edges first(c):first(c+1)-1, counterclockwise
    integer, allocatable :: start(:)     !! (n_edges) vertex of the outline where the edge begins
    integer, allocatable :: finish(:)    !! (n_edges) where it ends: the start of the next edge of its chain
  end type chains_t

contains

  !> Cuts an outline at its hollow corners. An outline that encloses nothing, as fewer than three corners are left of it, has no
  !> chains. The outline of a hole runs clockwise, with the body on its left like every outline.
  pure function cut_at_hollow_corners(x) result(chains)
    real(dp), intent(in) :: x(:, :)      !! (2, n) vertices in order, the body on the left, length
    type(chains_t) :: chains
    integer, allocatable :: corner(:)
    logical, allocatable :: hollow(:)
    integer :: i, m

    chains%n_vertices = size(x, 2)
    corner = corners_of(x)
    m = size(corner)
    if (m < least_corners) then
      allocate (chains%first(1), source=1)
      allocate (chains%start(0), chains%finish(0))
      return
    end if
    allocate (hollow(m))
    do i = 1, m
      associate (at => x(:, corner(i)))
        hollow(i) = cross(at - x(:, corner(before(i))), x(:, corner(after(i))) - at) < 0
      end associate
    end do
    chains%closed = .not. any(hollow)
    if (chains%closed) then
      chains%first = [1, m + 1]
    else
      corner = cshift(corner, findloc(hollow, .true., 1) - 1)
      hollow = cshift(hollow, findloc(hollow, .true., 1) - 1)
      chains%first = [pack([(i, i=1, m)], hollow), m + 1]
    end if
    chains%start = corner
    chains%finish = cshift(corner, 1)

  contains

    !> Corner before the i-th.
    pure integer function before(i)
      integer, intent(in) :: i

      before = modulo(i - 2, m) + 1
    end function before

    !> Corner after the i-th.
    pure integer function after(i)
      integer, intent(in) :: i

      after = modulo(i, m) + 1
    end function after

  end function cut_at_hollow_corners

  !> Edges of the outline that an edge of a chain spans, in order. Edge i of the outline begins at its vertex i.
  pure function outline_edges(chains, edge) result(edges)
    type(chains_t), intent(in) :: chains
    integer, intent(in) :: edge          !! among all chains
    integer, allocatable :: edges(:)
    integer :: i

    associate (from => chains%start(edge), n => chains%n_vertices)
      edges = [(modulo(from + i - 1, n) + 1, i=0, modulo(chains%finish(edge) - from - 1, n))]
    end associate
  end function outline_edges

  !> Vertices that are corners: neither the end of a sliver nor on a straight side. They stand in the order of the outline, from the
  !> lowest number. The time grows with the square of the number of vertices on one side.
  pure function corners_of(x) result(corner)
    real(dp), intent(in) :: x(:, :)      !! (2, n) vertices of an outline in order, length
    integer, allocatable :: corner(:)
    integer, allocatable :: left(:)      ! vertices without slivers, then from the sharpest corner on
    logical :: is_corner(size(x, 2))
    real(dp) :: rounding
    integer :: from, i, to

    left = without_slivers(x)
    is_corner = .false.
    if (size(left) >= least_corners) then
      left = cshift(left, sharpest(x(:, left)) - 1)
      left = [left, left(1)]
      rounding = roundings*maxval(abs(x))
      from = 1
      do while (from < size(left))
        is_corner(left(from)) = .true.
        to = from + 1
        do while (to < size(left))
          if (.not. is_straight(x(:, left(from:to + 1)), rounding)) exit
          to = to + 1
        end do
        from = to
      end do
    end if
    corner = pack([(i, i=1, size(x, 2))], is_corner)
    if (size(corner) < least_corners) corner = [integer ::]
  end function corners_of

  !> Vertices of an outline less the ends of slivers, in order.
  pure function without_slivers(x) result(left)
    real(dp), intent(in) :: x(:, :)      !! (2, n)
    integer, allocatable :: left(:)
    real(dp), allocatable :: length(:)
    logical, allocatable :: goes(:)
    integer :: i

    left = [(i, i=1, size(x, 2))]
    do while (size(left) >= least_corners)
      length = norm2(x(:, cshift(left, 1)) - x(:, left), 1)
      goes = cshift(length <= sliver*max(cshift(length, 1), cshift(length, -1)), -1)
      if (.not. any(goes)) return
      left = pack(left, .not. goes)
    end do
  end function without_slivers

  !> Vertex at which an outline without slivers turns most.
  pure integer function sharpest(x)
    real(dp), intent(in) :: x(:, :)      !! (2, n)
    real(dp) :: along(2, size(x, 2))
    integer :: i

    do i = 1, size(x, 2)
      along(:, i) = x(:, modulo(i, size(x, 2)) + 1) - x(:, i)
      along(:, i) = along(:, i)/norm2(along(:, i))
    end do
    sharpest = minloc(sum(along*cshift(along, -1, 2), 1), 1)
  end function sharpest

  !> Whether all vertices between the first and the last one are on the line between them, one after the other.
  pure logical function is_straight(x, rounding)
    real(dp), intent(in) :: x(:, :)      !! (2, n), length
    real(dp), intent(in) :: rounding     !! of a distance, length
    real(dp) :: chord(2), length, way(2), way_on(2)
    integer :: k, n

    n = size(x, 2)
    chord = x(:, n) - x(:, 1)
    length = norm2(chord)
    is_straight = length > 0
    do k = 2, n - 1
      if (.not. is_straight) return
      way = x(:, k) - x(:, 1)
      way_on = x(:, n) - x(:, k)
      is_straight = abs(cross(chord, way)) <= length*(straight*min(norm2(way), norm2(way_on)) + rounding) &
                    .and. dot_product(chord, x(:, k) - x(:, k - 1)) > 0 .and. dot_product(chord, way_on) > 0
    end do
  end function is_straight

  !> Of two vectors.
  pure real(dp) function cross(a, b)
    real(dp), intent(in) :: a(2), b(2)

    cross = a(1)*b(2) - a(2)*b(1)
  end function cross

end module scree_chains
