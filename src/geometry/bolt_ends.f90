!> Which blocks carry the ends of bolts, and where grouted bolts cross joints (Shi's dc14).
module scree_bolt_ends
  use scree_block_finder, only: block_at, block_finder_t, blocks_along, find_nearest_block, block_path_t
  use scree_carried_points, only: add_point, check_inside, found_points_t
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_kinds, only: dp
  use scree_regions, only: regions_t
  use scree_scene, only: bolt_record_t, somewhere
  use scree_system, only: bolt_end
  use scree_text, only: number_text, place_text, short_text
  implicit none
  private
  public :: carried_bolts_t, carry_bolts

  !> Distance from all blocks, over the bolt's length, within which an end of a bolt is moved to the nearest block. The head and the
  !> plate of a bolt of 3 m stand out of the rock by some 3 cm.
  real(dp), parameter :: stands_out = 0.01_dp

  !> Bolts with what holds them.
  type :: carried_bolts_t
    type(bolt_record_t), allocatable :: bolt(:) !! with the blocks that carry their ends, in the coordinates of the deck; of grouted
                                               !! bolts one at each joint that they cross
    integer, allocatable :: bolt_of(:)         !! (n_bolts) their numbers in the decks
    integer, allocatable :: end_point(:, :)    !! (2, n_bolts) point at each end, 0: in the ground
    integer :: n_moved = 0                     !! ends of bolts that stood out of the blocks and were moved to the nearest one
    real(dp) :: moved = 0.0_dp                 !! the farthest way of these, length
    integer, allocatable :: joint_point(:, :)  !! (2, n_bolts) point of either block at the joint, 0: not grouted
  end type carried_bolts_t

contains

  !> Adds the bolts, with the ends of each to the blocks that hold them; of a grouted one a bolt at each joint that it crosses.
  !> Their ends are points, too.
  !>
  !> Errors: ends in no block where the ground does not hold them, bolts without an end in a block, no bolt that crosses a joint
  !> where all are grouted.
  subroutine carry_bolts(given, finder, shape, vertex, origin, points, bolts, error)
    type(bolt_record_t), intent(in) :: given(:)
    type(block_finder_t), intent(in) :: finder
    type(regions_t), intent(in) :: shape     !! of the blocks
    real(dp), intent(in) :: vertex(:, :), origin(2) !! of the blocks, length
    type(carried_bolts_t), intent(inout) :: bolts
    type(found_points_t), intent(inout) :: points
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    allocate (bolts%bolt(0), bolts%bolt_of(0), bolts%end_point(2, 0), bolts%joint_point(2, 0))
    do i = 1, size(given)
      if (given(i)%shear_stiffness > 0) then
        call add_crossings(given(i), i, finder, shape, vertex, origin, points, bolts, error)
      else
        call add_free_bolt(given(i), i, finder, shape, vertex, origin, points, bolts, error)
      end if
      if (allocated(error)) return
    end do
    if (size(bolts%bolt) > 0 .or. size(given) == 0) return
    call fail(error, status_bad_input, given(1)%source//': expected grouted bolts that cross joints between two blocks, '// &
              'found none that does')
  end subroutine carry_bolts

  !> Adds a bolt between two points, each in a block or in the ground. Errors: an end that lies in no block where the deck does not
  !> let the ground hold it, a bolt without an end in a block.
  subroutine add_free_bolt(given, number, finder, shape, vertex, origin, points, bolts, error)
    type(bolt_record_t), intent(in) :: given
    integer, intent(in) :: number
    type(block_finder_t), intent(in) :: finder
    type(regions_t), intent(in) :: shape     !! of the blocks
    real(dp), intent(in) :: vertex(:, :), origin(2) !! of the blocks, length
    type(carried_bolts_t), intent(inout) :: bolts
    type(found_points_t), intent(inout) :: points
    type(error_t), allocatable, intent(out) :: error
    type(bolt_record_t) :: bolt
    real(dp) :: position(2)
    integer :: end_point(2), k

    bolt = given
    end_point = 0
    do k = 1, 2
      position = bolt%ends(:, k) - origin
      if (bolt%block(k) == somewhere) then
        call carry_end(finder, shape, vertex, origin, k, bolt, bolts, position, error)
        if (allocated(error)) return
      else
        call check_inside(shape, vertex, bolt%block(k), position, 'an end of a bolt', bolt%source, error)
        if (allocated(error)) return
      end if
      if (bolt%block(k) == 0) cycle
      call add_point(points, bolt_end, position, bolt%block(k))
      end_point(k) = points%n
    end do
    call enter_bolt(bolt, number, end_point, [0, 0], bolts)
    if (any(bolt%block > 0)) return
    call fail(error, status_bad_input, bolt%source//': expected a bolt with an end in a block, found both outside')
  end subroutine add_free_bolt

  !> Finds the block that carries an end of a bolt. An end that stands out of the blocks is moved to the nearest one. An end farther
  !> away is in the ground, block 0, if the deck says so. Errors: else.
  subroutine carry_end(finder, shape, vertex, origin, k, bolt, bolts, position, error)
    type(block_finder_t), intent(in) :: finder
    type(regions_t), intent(in) :: shape     !! of the blocks
    real(dp), intent(in) :: vertex(:, :), origin(2) !! of the blocks, length
    integer, intent(in) :: k                 !! the end
    type(bolt_record_t), intent(inout) :: bolt
    type(carried_bolts_t), intent(inout) :: bolts
    real(dp), intent(inout) :: position(2)   !! of the end, length
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: distance, place(2), reach
    integer :: nearest

    bolt%block(k) = block_at(finder, shape, vertex, position)
    if (bolt%block(k) > 0) return
    call find_nearest_block(shape, vertex, position, nearest, place)
    distance = norm2(place - position)
    reach = stands_out*norm2(bolt%ends(:, 2) - bolt%ends(:, 1))
    if (distance <= reach) then
      bolt%block(k) = nearest
      bolt%ends(:, k) = place + origin
      position = place
      bolts%n_moved = bolts%n_moved + 1
      bolts%moved = max(bolts%moved, distance)
    else if (.not. bolt%ground_holds) then
      call fail(error, status_bad_input, bolt%source//': expected both ends of a bolt in blocks, or within '//short_text(reach)// &
                ' of one, '//short_text(stands_out)//' of its length, found the end '//place_text(bolt%ends(:, k), reach)//', '// &
                short_text(distance)//' from block '//number_text(nearest)// &
                ': move the end into the rock, or let the ground hold such ends by &bolts outside=''ground'' /')
    end if
  end subroutine carry_end

  !> Adds a bolt for each joint that a grouted bolt crosses. Its ends are the middles of the two lengths in the blocks on both
  !> sides, or the end of the grouted bolt.
  subroutine add_crossings(given, number, finder, shape, vertex, origin, points, bolts, error)
    type(bolt_record_t), intent(in) :: given
    integer, intent(in) :: number
    type(block_finder_t), intent(in) :: finder
    type(regions_t), intent(in) :: shape     !! of the blocks
    real(dp), intent(in) :: vertex(:, :), origin(2) !! of the blocks, length
    type(carried_bolts_t), intent(inout) :: bolts
    type(found_points_t), intent(inout) :: points
    type(error_t), allocatable, intent(out) :: error
    type(bolt_record_t) :: bolt
    type(block_path_t) :: path
    real(dp) :: ends(2, 2), share(2)
    integer :: end_point(2), joint_point(2), i, k, n
    logical, allocatable :: crossed(:) !! joint between a block and the next

    ends = given%ends - spread(origin, 2, 2)
    path = blocks_along(finder, shape, vertex, ends)
    n = size(path%block)
    if (n == 0) then
      call fail(error, status_bad_input, given%source//': expected a grouted bolt in blocks, found one outside')
      return
    end if
    crossed = [.false., .not. path%from(2:) > path%to(:n - 1), .false.]
    do i = 1, n - 1
      if (.not. crossed(i + 1)) cycle
      share = [path%from(i), path%to(i + 1)]
      if (crossed(i)) share(1) = 0.5_dp*(share(1) + path%to(i))
      if (crossed(i + 2)) share(2) = 0.5_dp*(share(2) + path%from(i + 1))
      bolt = given
      bolt%block = path%block(i:i + 1)
      do k = 1, 2
        bolt%ends(:, k) = given%ends(:, 1) + share(k)*(given%ends(:, 2) - given%ends(:, 1))
        call add_point(points, bolt_end, bolt%ends(:, k) - origin, bolt%block(k))
        end_point(k) = points%n
        call add_point(points, bolt_end, ends(:, 1) + path%to(i)*(ends(:, 2) - ends(:, 1)), bolt%block(k))
        joint_point(k) = points%n
      end do
      call enter_bolt(bolt, number, end_point, joint_point, bolts)
    end do
  end subroutine add_crossings

  !> Enters a bolt in the list.
  subroutine enter_bolt(bolt, number, end_point, joint_point, bolts)
    type(bolt_record_t), intent(in) :: bolt
    integer, intent(in) :: number                        !! in the decks
    integer, intent(in) :: end_point(2), joint_point(2)
    type(carried_bolts_t), intent(inout) :: bolts

    bolts%bolt = [bolts%bolt, bolt]
    bolts%bolt_of = [bolts%bolt_of, number]
    bolts%end_point = reshape([bolts%end_point, end_point], [2, size(bolts%bolt)])
    bolts%joint_point = reshape([bolts%joint_point, joint_point], [2, size(bolts%bolt)])
  end subroutine enter_bolt

end module scree_bolt_ends
