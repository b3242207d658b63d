!> Where cracks end: the tips of joints that end inside blocks.
module scree_crack_tips
  use scree_block_finder, only: block_at, block_finder_t, set_up_finder
  use scree_block_input, only: blocks_t
  use scree_crack_tip, only: crack_tip_t
  use scree_kinds, only: dp
  use scree_sets, only: root_of, unite
  use scree_system, only: system_t
  implicit none
  private
  public :: find_tips, longest_side, number_tips

  !> Of the last piece of a crack: how far beyond its end lies the triangle of its tip. An end on a side, or in a node, is in
  !> several, and rounding must not choose among them, as the disc has its size by the triangle.
  real(dp), parameter :: ahead = 1e-6_dp
  real(dp), parameter :: same = 1e-9_dp !! of the size of the model: places that are nearer to each other are one

  !> Pieces of cracks and the edges of blocks, and how the pieces meet.
  type :: pieces_t
    real(dp), allocatable :: ends(:, :, :)    !! (xy, end, n) of the pieces, length
    integer, allocatable :: node(:, :)        !! (2, n) where they end
    integer, allocatable :: degree(:)         !! (n_nodes) pieces that end there
    logical, allocatable :: on_outline(:)     !! (n_nodes) the node lies on the outline of a block
    integer, allocatable :: crack(:)          !! (n) of the pieces
    real(dp), allocatable :: outline(:, :, :) !! (xy, end, m) edges of the blocks, length
  end type pieces_t

contains

  !> Finds the tips of a model: the ends of cracks that neither lie on the outline of a block nor meet another piece.
  !>
  !> A triangle of the mesh in which the line of a crack ends stays whole. So the faces end at the side where the line enters the
  !> triangle. This is the tip, as the field of stress knows it. A crack grows on from the end of its line, to a side. So only
  !> drawn lines end inside triangles.
  !>
  !> Blocks that no mesh cuts have one strain each, so a crack in them has no tips.
  subroutine find_tips(blocks, system, vertex, cover, tips)
    type(blocks_t), intent(in) :: blocks
    class(system_t), intent(in) :: system
    real(dp), intent(in) :: vertex(:, :)       !! (2, n_vertices) of the elements at the start, length
    real(dp), intent(in) :: cover(:, :)        !! (2, n_covers) nodes of the covers at the start, length
    type(crack_tip_t), allocatable, intent(out) :: tips(:) !! in the order of the pieces; their discs are not laid
    type(pieces_t) :: pieces
    type(block_finder_t) :: finder
    real(dp), allocatable :: lost(:)
    integer :: i, k, n

    n = 0
    if (system%n_elements == system%n_blocks .or. size(blocks%crack_joint) == 0) then
      allocate (tips(0))
      return
    end if
    call gather(blocks, system, pieces)
    allocate (tips(count(is_tip(pieces))), lost(count(is_tip(pieces))))
    call set_up_finder(finder, system%elements%shape, vertex, same*system%extent)
    do i = 1, size(pieces%crack)
      do k = 1, 2
        associate (node => pieces%node(k, i))
          if (pieces%degree(node) > 1 .or. pieces%on_outline(node)) cycle
        end associate
        n = n + 1
        tips(n)%number = n
        tips(n)%joint = blocks%crack_joint(i)
        associate (end => pieces%ends(:, k, i), begin => pieces%ends(:, 3 - k, i))
          tips(n)%element = block_at(finder, system%elements%shape, vertex, end + ahead*(end - begin))
          if (tips(n)%element == 0) tips(n)%element = block_at(finder, system%elements%shape, vertex, end)
        end associate
        tips(n)%block = system%elements%block(tips(n)%element)
        call describe(pieces, i, k, cover(:, system%elements%cover(:3, tips(n)%element)), same*system%extent, tips(n), lost(n))
      end do
    end do
    do i = 1, n
      tips(i)%length = tips(i)%length - sum(lost, mask=tips%crack == tips(i)%crack)
      tips(i)%to_tip = huge(1.0_dp)
      do k = 1, n
        if (k /= i .and. tips(k)%block == tips(i)%block) &
          tips(i)%to_tip = min(tips(i)%to_tip, norm2(tips(k)%place - tips(i)%place))
      end do
    end do
  end subroutine find_tips

  !> Gives tips the numbers that they had before their cracks grew, and those that cracks have begun with since. Tips that have met
  !> an outline or a crack are not among them.
  pure subroutine number_tips(before, piece, number, extent, tips)
    type(crack_tip_t), intent(in) :: before(:)
    real(dp), intent(in) :: piece(:, :)        !! (4, n) x1 y1 x2 y2 by which cracks have grown since, in their order, length
    integer, intent(in) :: number(:)           !! (n) of the tip at the end of each piece
    real(dp), intent(in) :: extent             !! size of the model, length
    type(crack_tip_t), intent(inout) :: tips(:)
    integer :: i, k

    do k = 1, size(tips)
      do i = 1, size(before)
        if (norm2(before(i)%end - tips(k)%end) <= same*extent) tips(k)%number = before(i)%number
      end do
      do i = 1, size(piece, 2)
        if (norm2(piece(3:, i) - tips(k)%end) <= same*extent) tips(k)%number = number(i)
      end do
    end do
  end subroutine number_tips

  !> Which nodes are tips.
  pure function is_tip(pieces)
    type(pieces_t), intent(in) :: pieces
    logical :: is_tip(size(pieces%degree))

    is_tip = pieces%degree == 1 .and. .not. pieces%on_outline
  end function is_tip

  !> Gathers the pieces of the cracks in the coordinates of the model, and finds how they meet.
  pure subroutine gather(blocks, system, pieces)
    type(blocks_t), intent(in) :: blocks
    class(system_t), intent(in) :: system
    type(pieces_t), intent(out) :: pieces
    real(dp) :: shift(2), end(2), reach
    integer :: b, first, i, j, k, l, n, n_nodes, next

    shift = blocks%origin - system%origin
    reach = same*system%extent
    n = size(blocks%crack_joint)
    allocate (pieces%ends(2, 2, n), pieces%outline(2, 2, size(blocks%vertex, 2)))
    do k = 1, 2
      do i = 1, 2
        pieces%ends(i, k, :) = blocks%crack(i, k, :) + shift(i)
      end do
    end do
    do b = 1, size(blocks%shape%first_vertex) - 1
      first = blocks%shape%first_vertex(b)
      do i = first, blocks%shape%first_vertex(b + 1) - 1
        next = merge(first, i + 1, i + 1 == blocks%shape%first_vertex(b + 1))
        pieces%outline(:, 1, i) = blocks%vertex(:, i) + shift
        pieces%outline(:, 2, i) = blocks%vertex(:, next) + shift
      end do
    end do
    allocate (pieces%node(2, n), source=0)
    pieces%crack = [(i, i=1, n)]
    n_nodes = 0
    do i = 1, n
      do k = 1, 2
        end = pieces%ends(:, k, i)
        do j = 1, i
          do l = 1, 2
            if (pieces%node(l, j) == 0 .or. norm2(pieces%ends(:, l, j) - end) > reach) cycle
            pieces%node(k, i) = pieces%node(l, j)
            call unite(pieces%crack, i, j)
          end do
        end do
        if (pieces%node(k, i) > 0) cycle
        n_nodes = n_nodes + 1
        pieces%node(k, i) = n_nodes
      end do
    end do
    pieces%crack = [(root_of(pieces%crack, i), i=1, n)]
    allocate (pieces%degree(n_nodes), source=0)
    allocate (pieces%on_outline(n_nodes))
    do i = 1, n
      do k = 1, 2
        associate (node => pieces%node(k, i))
          pieces%degree(node) = pieces%degree(node) + 1
          pieces%on_outline(node) = distance_to(pieces%outline, pieces%ends(:, k, i)) <= reach
        end associate
      end do
    end do
  end subroutine gather

  !> What the pieces and a triangle say of the tip at end `k` of piece `i`.
  pure subroutine describe(pieces, i, k, corner, reach, tip, lost)
    type(pieces_t), intent(in) :: pieces
    integer, intent(in) :: i, k
    real(dp), intent(in) :: corner(2, 3)       !! of the triangle that holds that end, length
    real(dp), intent(in) :: reach              !! of a place on a side, length
    type(crack_tip_t), intent(inout) :: tip
    real(dp), intent(out) :: lost              !! piece of the crack that the mesh leaves out, length
    logical :: on_path(size(pieces%crack))
    integer :: j, n

    tip%end = pieces%ends(:, k, i)
    tip%place = tip%end
    tip%direction = tip%place - pieces%ends(:, 3 - k, i)
    tip%direction = tip%direction/norm2(tip%direction)
    tip%crack = count([(pieces%crack(j) == j, j=1, pieces%crack(i))]) ! the first of its pieces stands for it
    do j = 1, size(pieces%crack)
      if (pieces%crack(j) == pieces%crack(i)) tip%length = tip%length + norm2(pieces%ends(:, 2, j) - pieces%ends(:, 1, j))
    end do
    tip%edge = longest_side(corner)
    call follow(pieces, i, k, tip%path, on_path)
    call end_at_side(corner, reach, tip, lost)
    tip%to_face = distance_to(pieces%outline, tip%place)
    n = count(.not. on_path)
    if (n > 0) tip%to_face = min(tip%to_face, distance_to(pieces%ends(:, :, pack([(j, j=1, size(on_path))], .not. on_path)), &
                                                          tip%place))
  end subroutine describe

  !> Follows a crack from the tip at end `k` of piece `i` to where it ends, branches, or meets an outline.
  pure subroutine follow(pieces, i, k, path, on_path)
    type(pieces_t), intent(in) :: pieces
    integer, intent(in) :: i, k
    real(dp), allocatable, intent(out) :: path(:, :) !! (2, n) length
    logical, intent(out) :: on_path(:)               !! (n_pieces)
    real(dp) :: at(2, size(on_path) + 1)
    integer :: end, j, n, node, piece

    on_path = .false.
    at(:, 1) = pieces%ends(:, k, i)
    n = 1
    piece = i
    end = 3 - k
    do
      on_path(piece) = .true.
      n = n + 1
      at(:, n) = pieces%ends(:, end, piece)
      node = pieces%node(end, piece)
      if (pieces%degree(node) /= 2 .or. pieces%on_outline(node)) exit
      do j = 1, size(on_path)
        if (j /= piece .and. any(pieces%node(:, j) == node)) exit
      end do
      if (on_path(j)) exit
      end = merge(2, 1, pieces%node(1, j) == node)
      piece = j
    end do
    path = at(:, :n)
  end subroutine follow

  !> Moves a tip inside a triangle back to the side where its crack enters.
  pure subroutine end_at_side(corner, reach, tip, lost)
    real(dp), intent(in) :: corner(2, 3)       !! of the triangle, length
    real(dp), intent(in) :: reach              !! of a place on a side, length
    type(crack_tip_t), intent(inout) :: tip
    real(dp), intent(out) :: lost              !! way that it moves, length
    real(dp) :: along(2), share, way
    integer :: i, k

    lost = 0.0_dp
    if (distance_to(reshape([corner, corner(:, [2, 3, 1])], [2, 2, 3], order=[1, 3, 2]), tip%place) <= reach) return
    way = 0.0_dp
    do k = 2, size(tip%path, 2)
      along = tip%path(:, k) - tip%path(:, k - 1)
      share = huge(share)
      do i = 1, 3
        associate (side => corner(:, modulo(i, 3) + 1) - corner(:, i), from => corner(:, i) - tip%path(:, k - 1))
          associate (enters => along(2)*side(1) - along(1)*side(2)) ! below 0 where the way leads out of the triangle
            if (enters < 0) share = min(share, (from(2)*side(1) - from(1)*side(2))/enters)
          end associate
        end associate
      end do
      if (share < 1) exit
      way = way + norm2(along)
    end do
    if (k > size(tip%path, 2)) return
    tip%path = tip%path(:, k - 1:)
    tip%path(:, 1) = tip%path(:, 1) + share*along
    tip%place = tip%path(:, 1)
    tip%direction = -along/norm2(along)
    lost = way + share*norm2(along)
  end subroutine end_at_side

  !> Distance of a position from the nearest of some lines.
  pure real(dp) function distance_to(ends, position) result(nearest)
    real(dp), intent(in) :: ends(:, :, :)   !! (xy, end, n) length
    real(dp), intent(in) :: position(2)     !! length
    real(dp) :: along(2), from(2), share
    integer :: i

    nearest = huge(nearest)
    do i = 1, size(ends, 3)
      along = ends(:, 2, i) - ends(:, 1, i)
      from = position - ends(:, 1, i)
      share = max(0.0_dp, min(1.0_dp, dot_product(from, along)/max(dot_product(along, along), tiny(share))))
      nearest = min(nearest, norm2(from - share*along))
    end do
  end function distance_to

  !> Longest side of a triangle.
  pure real(dp) function longest_side(corner)
    real(dp), intent(in) :: corner(2, 3)    !! length

    longest_side = sqrt(maxval(sum((corner - corner(:, [2, 3, 1]))**2, 1)))
  end function longest_side

end module scree_crack_tips
