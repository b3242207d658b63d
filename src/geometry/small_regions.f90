!> Small regions of a planar graph join a neighbour: what parts the two is taken out of the graph.
module scree_small_regions
  use scree_kinds, only: dp
  use scree_line_cutting, only: graph_t
  use scree_sorting, only: sort_by
  implicit none
  private
  public :: join_small_regions

contains

  !> Removes from a graph the pieces between each region that is too small and the neighbour with which it has the longest common
  !> edge.
  !>
  !> The smallest join first, and what has joined counts as one, until none can. Pieces of straight lines stay, and so do regions
  !> that are held. The passes end, as each that joins anything leaves fewer regions.
  pure subroutine join_small_regions(least, area, held, straight, beside, graph, joined)
    real(dp), intent(in) :: least          !! area that is not too small, length^2
    real(dp), intent(in) :: area(:)        !! (n_regions) length^2
    logical, intent(in) :: held(:)         !! (n_regions) stay as they are
    logical, intent(in) :: straight(:)     !! (n_lines) lines whose pieces stay
    integer, intent(in) :: beside(:, :)    !! (2, n_pieces) region left and right of each piece, 0: none
    type(graph_t), intent(inout) :: graph
    integer, intent(out) :: joined         !! regions that are no longer
    real(dp) :: length(size(graph%line)), sum_of(size(area))
    integer :: i, into(0:size(area)), other, r
    integer, allocatable :: beside_now(:, :), first(:), kept(:), own(:), pieces(:), small(:)
    logical :: parts(size(graph%line))

    into = [(i, i=0, size(area))]
    sum_of = area
    do i = 1, size(parts)
      length(i) = norm2(graph%position(:, graph%ends(2, i)) - graph%position(:, graph%ends(1, i)))
      parts(i) = .not. straight(graph%line(i)) .and. all(beside(:, i) > 0)
      if (parts(i)) parts(i) = .not. any(held(beside(:, i)))
    end do
    do
      joined = count([(into(r) /= r, r=1, size(area))])
      beside_now = reshape(into([beside]), shape(beside))
      small = in_order(sum_of, [(into(r) == r .and. sum_of(r) < least, r=1, size(area))])
      call list_pieces(small, beside_now, parts, first, pieces)
      do i = 1, size(small)
        r = small(i)
        if (into(r) /= r .or. .not. sum_of(r) < least) cycle ! it has joined, or grown, in this pass
        own = pieces(first(i):first(i + 1) - 1)
        other = longest_neighbour(r, root_of(into, beside(1, own)), root_of(into, beside(2, own)), length(own))
        if (other == 0) cycle
        into(r) = other
        sum_of(other) = sum_of(other) + sum_of(r)
      end do
      into = root_of(into, [(i, i=0, size(area))])
      if (count([(into(r) /= r, r=1, size(area))]) == joined) exit
    end do
    if (joined == 0) return
    kept = pack([(i, i=1, size(length))], beside(1, :) == beside(2, :) .or. into(beside(1, :)) /= into(beside(2, :)) &
                .or. straight(graph%line))
    graph%ends = graph%ends(:, kept)
    graph%line = graph%line(kept)
    graph%against = graph%against(kept)
  end subroutine join_small_regions

  !> The neighbour of a region with the longest edge between the two, of those alike the first; 0 where it has none.
  pure integer function longest_neighbour(region, left, right, length) result(longest)
    integer, intent(in) :: region
    integer, intent(in) :: left(:), right(:)  !! (n) regions beside pieces of its edge
    real(dp), intent(in) :: length(:)         !! (n)
    integer :: i, other(size(left))
    real(dp) :: best, shared

    other = merge(right, left, left == region)
    longest = 0
    best = 0.0_dp
    do i = 1, size(other)
      if (other(i) == region) cycle
      shared = sum(length, other == other(i))
      if (shared <= best) cycle
      best = shared
      longest = other(i)
    end do
  end function longest_neighbour

  !> The pieces around each of some regions that part it from another.
  pure subroutine list_pieces(regions, beside, parts, first, pieces)
    integer, intent(in) :: regions(:)
    integer, intent(in) :: beside(:, :)             !! (2, n_pieces) region left and right of each piece, 0: none
    logical, intent(in) :: parts(:)                 !! (n_pieces) whether the piece counts
    integer, allocatable, intent(out) :: first(:)   !! (n_regions+1) region i owns pieces(first(i):first(i+1)-1)
    integer, allocatable, intent(out) :: pieces(:)
    integer :: filled(0:size(regions)), i, place(0:maxval([0, beside])), side

    place = 0
    place(regions) = [(i, i=1, size(regions))]
    filled = 0
    do i = 1, size(parts)
      if (.not. parts(i) .or. beside(1, i) == beside(2, i)) cycle
      do side = 1, 2
        filled(place(beside(side, i))) = filled(place(beside(side, i))) + 1
      end do
    end do
    allocate (first(size(regions) + 1))
    first(1) = 1
    do i = 1, size(regions)
      first(i + 1) = first(i) + filled(i)
    end do
    allocate (pieces(first(size(first)) - 1))
    filled(1:) = first(:size(regions))
    do i = 1, size(parts)
      if (.not. parts(i) .or. beside(1, i) == beside(2, i)) cycle
      do side = 1, 2
        associate (at => place(beside(side, i)))
          if (at == 0) cycle
          pieces(filled(at)) = i
          filled(at) = filled(at) + 1
        end associate
      end do
    end do
  end subroutine list_pieces

  !> The regions that regions are part of.
  pure function root_of(into, region) result(root)
    integer, intent(in) :: into(0:)    !! of each region the one that it joined, itself where it joined none
    integer, intent(in) :: region(:)
    integer :: root(size(region))
    integer :: i

    root = region
    do i = 1, size(root)
      do while (into(root(i)) /= root(i))
        root(i) = into(root(i))
      end do
    end do
  end function root_of

  !> Numbers of those that count, by ascending area.
  pure function in_order(area, counts) result(list)
    real(dp), intent(in) :: area(:)
    logical, intent(in) :: counts(:)
    integer, allocatable :: list(:)
    real(dp), allocatable :: key(:)
    integer :: i

    list = pack([(i, i=1, size(area))], counts)
    key = area(list)
    call sort_by(key, list)
  end function in_order

end module scree_small_regions
