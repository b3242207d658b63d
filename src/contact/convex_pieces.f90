!> Convex pieces that together are a polygon.
!>
!> The polygon is cut into triangles by its ears, of which that with the shortest cut goes first; then cuts that no hollow corner
!> needs are taken back, the longest first. At most four times as many pieces are left as the least number.
!>
!> G. H. Meisters, *Polygons have ears*, American Mathematical Monthly 82 (1975) 648-651; S. Hertel, K. Mehlhorn, *Fast
!> triangulation of simple polygons*, LNCS 158 (1983) 207-218.
module scree_convex_pieces
  use scree_chains, only: corners_of
  use scree_kinds, only: dp
  use scree_sorting, only: sort_by
  implicit none
  private
  public :: cut_into_pieces, pieces_t

  !> Convex pieces. The edge that begins at an entry of `vertex` ends at the next entry of its piece.
  type :: pieces_t
    integer, allocatable :: first(:)     !! (n+1) piece p has the vertices first(p):first(p+1)-1, counterclockwise
    integer, allocatable :: vertex(:)    !! of the polygon
    logical, allocatable :: face(:)      !! whether the edge that begins there is one of the polygon, else a cut through it
  end type pieces_t

  !> Vertices of one piece.
  type :: piece_t
    integer, allocatable :: vertex(:)
  end type piece_t

contains

  !> Cuts a polygon into convex pieces; corners alone are kept of its vertices (`corners_of`). A hole may be joined to it by a seam,
  !> an edge that it runs through both ways, which is a cut. A polygon that crosses itself has no pieces.
  pure function cut_into_pieces(x) result(pieces)
    real(dp), intent(in) :: x(:, :)      !! (2, n) vertices, counterclockwise, length
    type(pieces_t) :: pieces
    type(piece_t), allocatable :: piece(:)
    integer, allocatable :: cut(:, :), order(:)
    real(dp), allocatable :: shortness(:)
    integer :: i, k

    order = corners_of(x)
    call clip_ears(x, order, piece, cut)
    shortness = [(-norm2(x(:, cut(1, i)) - x(:, cut(2, i))), i=1, size(cut, 2))]
    order = [(i, i=1, size(cut, 2))]
    call sort_by(shortness, order)
    do i = 1, size(order)
      call take_back(x, cut(:, order(i)), piece)
    end do
    pieces%first = [1, (1 + sum([(size(piece(k)%vertex), k=1, i)]), i=1, size(piece))]
    pieces%vertex = [(piece(i)%vertex, i=1, size(piece))]
    allocate (pieces%face(size(pieces%vertex)))
    do i = 1, size(piece)
      associate (own => piece(i)%vertex, from => pieces%first(i))
        pieces%face(from:from + size(own) - 1) = &
          [(is_face(own(k), own(modulo(k, size(own)) + 1)), k=1, size(own))]
      end associate
    end do

  contains

    !> Whether an edge is no cut, neither of the ears nor along a seam.
    pure logical function is_face(from, to)
      integer, intent(in) :: from, to
      integer :: k

      is_face = .true.
      do k = 1, size(cut, 2)
        if (all(cut(:, k) == [from, to]) .or. all(cut(:, k) == [to, from])) is_face = .false.
      end do
      do k = 1, size(pieces%vertex)
        if (.not. is_face) return
        if (same_place(x(:, from), x(:, pieces%vertex(k)))) &
          is_face = .not. same_place(x(:, to), x(:, before(k)))
      end do
    end function is_face

    !> Vertex before entry k of its piece.
    pure integer function before(k)
      integer, intent(in) :: k
      integer :: p

      p = count(pieces%first <= k)
      before = pieces%vertex(merge(pieces%first(p + 1) - 1, k - 1, k == pieces%first(p)))
    end function before

  end function cut_into_pieces

  !> Cuts ears off a polygon until a triangle is left. A polygon that crosses itself may have none before, and has
  !> no pieces then.
  pure subroutine clip_ears(x, corner, piece, cut)
    real(dp), intent(in) :: x(:, :)                       !! (2, n)
    integer, intent(in) :: corner(:)                      !! vertices of the polygon in order
    type(piece_t), allocatable, intent(out) :: piece(:)
    integer, allocatable, intent(out) :: cut(:, :)        !! (2, n) ends
    integer, allocatable :: left(:)
    real(dp), allocatable :: length(:)                    ! of the cut of an ear, else huge
    integer :: i, k, m

    allocate (piece(0))
    allocate (cut(2, 0))
    left = corner
    if (size(left) < 3) return
    length = [(cut_of_ear(x, left, k), k=1, size(left))]
    do while (size(left) > 3)
      m = size(left)
      i = minloc(length, 1)
      if (.not. length(i) < huge(length)) then
        piece = piece(:0)
        return
      end if
      associate (from => left(modulo(i - 2, m) + 1), to => left(modulo(i, m) + 1))
        piece = [piece, piece_t([from, left(i), to])]
        cut = reshape([cut, [from, to]], [2, size(cut, 2) + 1])
      end associate
      left = [left(:i - 1), left(i + 1:)]
      length = [length(:i - 1), length(i + 1:)]
      do k = i - 1, i
        length(modulo(k - 1, m - 1) + 1) = cut_of_ear(x, left, modulo(k - 1, m - 1) + 1)
      end do
    end do
    piece = [piece, piece_t(left)]
    if (turn(x(:, left(1)), x(:, left(2)), x(:, left(3))) <= 0) piece = piece(:0)
  end subroutine clip_ears

  !> Length of the cut that takes off the ear at a vertex; `huge` where there is no ear, as the corner is hollow or another
  !> vertex is in the way.
  pure real(dp) function cut_of_ear(x, left, i) result(length)
    real(dp), intent(in) :: x(:, :)      !! (2, n)
    integer, intent(in) :: left(:)       !! vertices that are left of the polygon
    integer, intent(in) :: i             !! among these
    integer :: k

    length = huge(length)
    associate (a => x(:, left(modulo(i - 2, size(left)) + 1)), b => x(:, left(i)), c => x(:, left(modulo(i, size(left)) + 1)))
      if (turn(a, b, c) <= 0) return
      do k = 1, size(left)
        associate (p => x(:, left(k)))
          if (same_place(p, a) .or. same_place(p, b) .or. same_place(p, c)) cycle
          if (turn(a, b, p) >= 0 .and. turn(b, c, p) >= 0 .and. turn(c, a, p) >= 0) return
        end associate
      end do
      length = norm2(c - a)
    end associate
  end function cut_of_ear

  !> Takes back a cut where the two pieces on its sides are a convex one together.
  pure subroutine take_back(x, cut, piece)
    real(dp), intent(in) :: x(:, :)      !! (2, n)
    integer, intent(in) :: cut(2)
    type(piece_t), allocatable, intent(inout) :: piece(:)
    integer, allocatable :: one(:), other(:)
    integer :: i, k, p(2)

    p = 0
    do i = 1, size(piece)
      k = place_of_edge(piece(i)%vertex, cut(1), cut(2))
      if (k > 0) p(1) = i
      if (k > 0) one = cshift(piece(i)%vertex, k)   ! begins at cut(2), ends at cut(1)
      k = place_of_edge(piece(i)%vertex, cut(2), cut(1))
      if (k > 0) p(2) = i
      if (k > 0) other = cshift(piece(i)%vertex, k) ! begins at cut(1), ends at cut(2)
    end do
    if (any(p == 0)) return
    if (turn(x(:, one(size(one) - 1)), x(:, cut(1)), x(:, other(2))) < 0) return
    if (turn(x(:, other(size(other) - 1)), x(:, cut(2)), x(:, one(2))) < 0) return
    piece(minval(p))%vertex = [one, other(2:size(other) - 1)]
    piece = [piece(:maxval(p) - 1), piece(maxval(p) + 1:)]
  end subroutine take_back

  !> Place of the edge from one vertex to another in a piece; 0: it has none.
  pure integer function place_of_edge(vertex, from, to) result(place)
    integer, intent(in) :: vertex(:), from, to

    place = findloc(vertex, from, 1)
    if (place == 0) return
    if (vertex(modulo(place, size(vertex)) + 1) /= to) place = 0
  end function place_of_edge

  !> Twice the area of a triangle: above 0 where it turns left.
  pure real(dp) function turn(a, b, c)
    real(dp), intent(in) :: a(2), b(2), c(2)

    turn = (b(1) - a(1))*(c(2) - b(2)) - (b(2) - a(2))*(c(1) - b(1))
  end function turn

  !> Whether two positions are the same to the last bit, as the two ends of a seam are.
  pure logical function same_place(a, b)
    real(dp), intent(in) :: a(2), b(2)

    same_place = .not. any(abs(a - b) > 0)
  end function same_place

end module scree_convex_pieces
