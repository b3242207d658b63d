!> Which convex pieces are near each other: a grid over their boxes, widened by a skin, so that the answer holds for many steps.
module scree_near_pieces
  use scree_bodies, only: bodies_t, near_t
  use scree_cell_grid, only: cell_grid_t, cells_of_box, number_of_cell, place_boxes, set_up_grid
  use scree_kinds, only: dp
  implicit none
  private
  public :: find_near, grow_skin, is_worn, place_of_pair

  real(dp), parameter :: least_skin = 0.1_dp, most_skin = 0.5_dp !! of the mean size of what moves
  real(dp), parameter :: steps_ahead = 40.0_dp !! of the fastest body, that a skin is to last for

contains

  !> Whether bodies may have come nearer than the skin saw, or there is no list yet.
  pure logical function is_worn(near)
    type(near_t), intent(in) :: near

    is_worn = .not. allocated(near%edge) .or. 2*near%moved > near%skin
  end function is_worn

  !> Chooses the skin by how far the fastest body goes in a step.
  pure subroutine grow_skin(bodies, way)
    type(bodies_t), intent(inout) :: bodies
    real(dp), intent(in) :: way               !! length
    real(dp) :: mean

    mean = sum(bodies%size, mask=bodies%moves)/max(1, count(bodies%moves))
    bodies%near%skin = min(most_skin*mean, max(least_skin*mean, steps_ahead*way))
  end subroutine grow_skin

  !> Finds the pairs of pieces of different bodies, one of which at least moves, whose boxes are nearer than the skin. What pairs of
  !> the list before remember goes on.
  subroutine find_near(bodies)
    type(bodies_t), intent(inout) :: bodies
    real(dp), dimension(2, bodies%n_pieces) :: low, high ! of the boxes, length
    integer :: seen(bodies%n_pieces)                     ! by which piece each was looked at last
    integer, allocatable :: candidate(:)
    type(cell_grid_t) :: grid
    type(near_t) :: before
    integer :: a, n_candidates

    call hand_on(bodies%near, before)
    call empty(bodies%near, max(before%n + before%n/4, 4*bodies%n_pieces))
    if (bodies%n_pieces < 2) return
    do a = 1, bodies%n_pieces
      associate (x => bodies%at(:, bodies%first(a):bodies%first(a + 1) - 1))
        low(:, a) = minval(x, 2) - bodies%near%skin/2
        high(:, a) = maxval(x, 2) + bodies%near%skin/2
      end associate
    end do
    call set_up_grid(grid, 0.5_dp*(low + high), bodies%n_pieces)
    call place_boxes(grid, low, high)
    seen = 0
    allocate (candidate(bodies%n_pieces))
    do a = 1, bodies%n_pieces
      n_candidates = 0
      call list_candidates(a)
      call sort(candidate(:n_candidates))
      call append(a)
    end do

  contains

    !> Lists the pieces with higher numbers that are near a piece.
    subroutine list_candidates(p)
      integer, intent(in) :: p
      integer :: c, column, k, range(2, 2), row

      range = cells_of_box(grid, low(:, p), high(:, p))
      do row = range(2, 1), range(2, 2)
        do column = range(1, 1), range(1, 2)
          c = number_of_cell(grid, column, row)
          do k = grid%first(c), grid%first(c + 1) - 1
            if (grid%item(k) > p) call consider(p, grid%item(k))
          end do
        end do
      end do
    end subroutine list_candidates

    !> Adds a piece to the candidates if it is near another, once.
    subroutine consider(p, q)
      integer, intent(in) :: p, q

      if (seen(q) == p) return
      seen(q) = p
      if (any(low(:, p) > high(:, q)) .or. any(low(:, q) > high(:, p))) return
      if (bodies%body(p) == bodies%body(q)) return
      if (.not. (bodies%moves(bodies%body(p)) .or. bodies%moves(bodies%body(q)))) return
      n_candidates = n_candidates + 1
      candidate(n_candidates) = q
    end subroutine consider

    !> Appends the pairs of a piece, with what they remember.
    subroutine append(p)
      integer, intent(in) :: p
      integer :: k, old

      old = first_of(before, p)
      do k = 1, n_candidates
        associate (near => bodies%near)
          if (near%n == size(near%edge)) call enlarge(near)
          near%n = near%n + 1
          near%piece(:, near%n) = [p, candidate(k)]
          near%edge(near%n) = 0
          near%vertex(near%n) = 1
          near%apart_until(near%n) = 0.0_dp
          do while (old <= before%n)
            if (before%piece(1, old) > p .or. before%piece(2, old) >= candidate(k)) exit
            old = old + 1
          end do
          if (old > before%n) cycle
          if (any(before%piece(:, old) /= [p, candidate(k)])) cycle
          near%edge(near%n) = before%edge(old)
          near%vertex(near%n) = before%vertex(old)
          near%memory(near%n) = before%memory(old)
        end associate
      end do
    end subroutine append

  end subroutine find_near

  !> Place in a list of the first pair whose first piece is p or a later one.
  pure integer function first_of(near, p)
    type(near_t), intent(in) :: near
    integer, intent(in) :: p
    integer :: high, middle

    first_of = 1
    high = near%n + 1
    do while (first_of < high)
      middle = (first_of + high)/2
      if (near%piece(1, middle) < p) then
        first_of = middle + 1
      else
        high = middle
      end if
    end do
  end function first_of

  !> Place of a pair of pieces in the list, in whatever order they are given; 0: they are not near each other.
  pure integer function place_of_pair(near, p, q) result(place)
    type(near_t), intent(in) :: near
    integer, intent(in) :: p, q

    do place = first_of(near, min(p, q)), near%n
      if (near%piece(1, place) > min(p, q)) exit
      if (near%piece(2, place) == max(p, q)) return
    end do
    place = 0
  end function place_of_pair

  !> Hands the arrays of a list on to another; its skin stays.
  subroutine hand_on(near, to)
    type(near_t), intent(inout) :: near
    type(near_t), intent(out) :: to

    to%n = near%n
    near%n = 0
    if (.not. allocated(near%edge)) return
    call move_alloc(near%piece, to%piece)
    call move_alloc(near%edge, to%edge)
    call move_alloc(near%vertex, to%vertex)
    call move_alloc(near%memory, to%memory)
    deallocate (near%apart_until)
  end subroutine hand_on

  !> Empties a list, with room for some pairs.
  subroutine empty(near, room)
    type(near_t), intent(inout) :: near
    integer, intent(in) :: room

    near%n = 0
    allocate (near%piece(2, room), near%edge(room), near%vertex(room))
    allocate (near%memory(room), near%apart_until(room))
  end subroutine empty

  !> Doubles the room of a list.
  subroutine enlarge(near)
    type(near_t), intent(inout) :: near
    type(near_t) :: larger

    call empty(larger, 2*size(near%edge))
    larger%piece(:, :near%n) = near%piece
    larger%edge(:near%n) = near%edge
    larger%vertex(:near%n) = near%vertex
    larger%memory(:near%n) = near%memory
    larger%apart_until(:near%n) = near%apart_until
    call move_alloc(larger%piece, near%piece)
    call move_alloc(larger%edge, near%edge)
    call move_alloc(larger%vertex, near%vertex)
    call move_alloc(larger%memory, near%memory)
    call move_alloc(larger%apart_until, near%apart_until)
  end subroutine enlarge

  !> Sorts numbers ascending (insertion: candidates are few, and mostly in order).
  pure subroutine sort(list)
    integer, intent(inout) :: list(:)
    integer :: i, j, next

    do i = 2, size(list)
      next = list(i)
      do j = i - 1, 1, -1
        if (list(j) <= next) exit
        list(j + 1) = list(j)
      end do
      list(j + 1) = next
    end do
  end subroutine sort

end module scree_near_pieces
