!> Compression of blocks by their own weight: the vertical column that is compressed most.
module scree_own_weight
  use scree_block_input, only: block_moments, blocks_t
  use scree_kinds, only: dp
  use scree_regions, only: first_vertex_of, last_vertex_of, loops_of, region_count
  use scree_scene, only: block_material_t
  use scree_simplex_integration, only: moments_t
  use scree_sorting, only: sort_by
  implicit none
  private
  public :: column_t, worst_column

  integer, parameter :: most_columns = 2000  !! of more blocks, some are looked at
  real(dp), parameter :: together = 1e-3_dp  !! of the height of a block: a gap that does not part a column

  !> A vertical line through blocks that stand on each other, down to where they are compressed most.
  type :: column_t
    integer :: block = 0           !! the lowest
    real(dp) :: height = 0.0_dp    !! length
    real(dp) :: stress = 0.0_dp    !! at the foot, force/length^2
    real(dp) :: strain = 0.0_dp    !! there
    real(dp) :: width = 0.0_dp     !! of the lowest block, length
    real(dp) :: eased = 0.0_dp     !! strain there that the initial stress has beforehand
  end type column_t

contains

  !> The column with the largest strain at its foot; none where nothing has weight.
  !>
  !> A line through the centroid of each block collects weight downwards, from block to block as long as they stand on each
  !> other. What is fixed as a whole bears and does not strain.
  pure function worst_column(blocks, material, is_rigid) result(worst)
    type(blocks_t), intent(in) :: blocks
    type(block_material_t), intent(in) :: material(:)
    logical, intent(in) :: is_rigid(:)        !! (n_blocks)
    type(column_t) :: worst, column
    type(moments_t) :: moments
    real(dp), dimension(size(is_rigid)) :: left, right, low, top, chord
    integer :: b, block(size(is_rigid)), i, n, stride
    real(dp) :: x

    do b = 1, region_count(blocks%shape)
      associate (own => blocks%vertex(1, first_vertex_of(blocks%shape, b):last_vertex_of(blocks%shape, b)))
        left(b) = minval(own)
        right(b) = maxval(own)
      end associate
    end do
    stride = (size(is_rigid) - 1)/most_columns + 1
    do i = 1, size(is_rigid), stride
      moments = block_moments(blocks, i)
      x = moments%centroid(1)
      n = 0
      do b = 1, size(is_rigid)
        if (x < left(b) .or. x >= right(b)) cycle
        n = n + 1
        block(n) = b
        call cut_block(blocks, b, x, low(n), top(n), chord(n))
      end do
      column = worst_on_line(block(:n), low(:n), top(:n), chord(:n), material(blocks%material(block(:n))), is_rigid(block(:n)))
      if (column%strain <= worst%strain) cycle
      b = findloc(block(:n), column%block, 1)
      associate (rock => material(blocks%material(column%block)))
        column%eased = max(0.0_dp, -(rock%stress(2) + (low(b) + blocks%origin(2))*rock%stress_gradient(2)))/rock%young
      end associate
      worst = column
      worst%width = right(worst%block) - left(worst%block)
    end do
  end function worst_column

  !> The column of a vertical line with the largest strain at its foot.
  pure function worst_on_line(block, low, top, chord, rock, is_rigid) result(worst)
    integer, intent(in) :: block(:)                    !! numbers of the blocks that the line cuts
    real(dp), intent(in) :: low(:), top(:), chord(:)   !! where, and how much of it they take up, length
    type(block_material_t), intent(in) :: rock(:)      !! of each
    logical, intent(in) :: is_rigid(:)
    type(column_t) :: worst, column
    integer :: order(size(block)), i, k
    real(dp) :: above, key(size(block))

    key = -low
    order = [(k, k=1, size(block))]
    call sort_by(key, order)
    above = huge(above) ! where the block above ends
    do i = 1, size(order)
      k = order(i)
      if (above - top(k) > together*(top(k) - low(k))) column = column_t()
      above = low(k)
      if (is_rigid(k)) then
        above = huge(above)
        cycle
      end if
      column%block = block(k)
      column%height = column%height + chord(k)
      column%stress = column%stress + max(rock(k)%unit_weight, 0.0_dp)*chord(k)
      column%strain = column%stress/rock(k)%young
      if (column%strain > worst%strain) worst = column
    end do
  end function worst_on_line

  !> Where a vertical line cuts a block: lowest and highest position, and the length within it.
  pure subroutine cut_block(blocks, b, x, low, top, chord)
    type(blocks_t), intent(in) :: blocks
    integer, intent(in) :: b
    real(dp), intent(in) :: x                    !! length
    real(dp), intent(out) :: low, top, chord     !! length
    integer, allocatable :: loop(:)
    integer :: first, k, l, next
    real(dp) :: y

    loop = loops_of(blocks%shape, b)
    first = first_vertex_of(blocks%shape, b) - 1
    low = huge(low)
    top = -huge(top)
    chord = 0.0_dp
    do l = 1, size(loop) - 1
      do k = loop(l), loop(l + 1) - 1
        next = merge(loop(l), k + 1, k + 1 == loop(l + 1))
        associate (p => blocks%vertex(:, first + k), q => blocks%vertex(:, first + next))
          if ((p(1) <= x) .eqv. (q(1) <= x)) cycle
          y = p(2) + (x - p(1))/(q(1) - p(1))*(q(2) - p(2))
          low = min(low, y)
          top = max(top, y)
          chord = chord + merge(y, -y, p(1) > q(1)) ! the rock is on the left of its outline: upper sides lead to the left
        end associate
      end do
    end do
  end subroutine cut_block

end module scree_own_weight
