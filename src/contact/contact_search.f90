!> Which vertices are near which edges: a search in a grid, with room to move, and whether a step outran it.
module scree_contact_search
  use scree_cell_grid, only: cell_grid_t, cells_of_box, number_of_cell, place_boxes, set_up_grid
  use scree_contact_rules, only: corners_turn
  use scree_contact_try, only: contact_try_t
  use scree_contacts, only: contact_search_t, outlines_t, parallel
  use scree_interpolation, only: displacement_matrix
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_polygon, only: distance_to_segment
  use scree_sorting, only: order_of_pairs
  use scree_state, only: state_t
  use scree_system, only: values_of
  implicit none
  private
  public :: at_outlines, find_nearby, most_turning, outran

  real(dp), parameter :: most_turning = acos(-1.0_dp)/6 !! of a corner in a step, rad
  real(dp), parameter :: room = 0.02_dp           !! of the edges about, that is looked at beyond the reach of contacts

contains

  !> Pairs of a vertex and an edge that are no farther apart than contacts of either reach and some room, so that a vertex inside
  !> a body is found too, in the order of the edges; then those that were inside when the run began and lie deeper. A search is made
  !> where what an earlier one listed may not do. The pairs do not tell when it was made.
  subroutine find_nearby(outlines, position, near, local, self_contact, search, nearby)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)          !! (2, n_vertices), length
    real(dp), intent(in) :: near(:)                 !! (n) how far a contact of each vertex reaches, length
    real(dp), intent(in) :: local(:)                !! (n) shorter edge at each vertex, length
    logical, intent(in) :: self_contact             !! a body may touch itself
    type(contact_search_t), intent(inout) :: search
    integer, allocatable, intent(out) :: nearby(:, :) !! (2, n)
    real(dp) :: wide(size(near))
    logical :: deep(size(outlines%inside, 2))
    logical, allocatable :: is_near(:)

    wide = near + room*local
    if (.not. still_holds(outlines, position, wide, search)) call list_candidates(outlines, position, wide, self_contact, search)
    is_near = are_near(outlines, position, wide, search%candidate)
    deep = .not. are_near(outlines, position, wide, outlines%inside)
    nearby = reshape([pack(search%candidate, spread(is_near, 1, 2)), pack(outlines%inside, spread(deep, 1, 2))], &
                     [2, count(is_near) + count(deep)])
  end subroutine find_nearby

  !> Whether vertex and edge of each pair are near each other.
  pure function are_near(outlines, position, wide, pair) result(is_near)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)          !! (2, n_vertices), length
    real(dp), intent(in) :: wide(:)                 !! (n) how far from each vertex pairs are near, length
    integer, intent(in) :: pair(:, :)               !! (2, m)
    logical :: is_near(size(pair, 2))
    integer :: k

    do k = 1, size(is_near)
      associate (i => pair(1, k), j => pair(2, k))
        is_near(k) = distance_to_segment(position(:, outlines%start(i)), position(:, outlines%start(j)), &
                                         position(:, outlines%finish(j))) &
                     <= wide(i) + max(wide(j), wide(outlines%next(j)))
      end associate
    end do
  end function are_near

  !> Whether no pair can be near that the search did not list: no vertex has left its room, nor any edge.
  pure logical function still_holds(outlines, position, wide, search)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)          !! (2, n_vertices), length
    real(dp), intent(in) :: wide(:)                 !! (n) how far from each vertex pairs are near, length
    type(contact_search_t), intent(in) :: search
    real(dp) :: moved(size(wide))

    still_holds = allocated(search%found_at)
    if (.not. still_holds) return
    moved = norm2(position(:, outlines%start) - search%found_at, 1)
    associate (next => outlines%next, reach => search%reach)
      still_holds = all(moved + wide <= reach) .and. all(max(moved, moved(next)) + max(wide, wide(next)) <= max(reach, reach(next)))
    end associate
  end function still_holds

  !> Searches vertices near edges in a grid, with room to move.
  subroutine list_candidates(outlines, position, wide, self_contact, search)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)  !! (2, n_vertices), length
    real(dp), intent(in) :: wide(:)         !! (n) how far from each vertex pairs are near, length
    logical, intent(in) :: self_contact
    type(contact_search_t), intent(inout) :: search
    type(cell_grid_t) :: grid
    real(dp), allocatable :: vertex(:, :)
    integer, allocatable :: list(:, :)
    integer :: seen(size(wide)), range(2, 2)
    integer :: c, column, i, j, k, n, row
    real(dp) :: reach

    vertex = position(:, outlines%start)
    search%found_at = vertex
    search%reach = 2*wide
    call set_up_grid(grid, vertex, size(wide))
    call place_boxes(grid, vertex - spread(search%reach, 1, 2), vertex + spread(search%reach, 1, 2))
    allocate (list(2, 4*size(wide)))
    n = 0
    seen = 0
    do j = 1, size(wide)
      associate (a => position(:, outlines%start(j)), b => position(:, outlines%finish(j)))
        reach = max(search%reach(j), search%reach(outlines%next(j)))
        range = cells_of_box(grid, min(a, b) - reach, max(a, b) + reach)
        do row = range(2, 1), range(2, 2)
          do column = range(1, 1), range(1, 2)
            c = number_of_cell(grid, column, row)
            do k = grid%first(c), grid%first(c + 1) - 1
              i = grid%item(k)
              if (seen(i) == j) cycle
              seen(i) = j
              if (.not. may_meet(outlines, i, j, self_contact)) cycle
              if (distance_to_segment(vertex(:, i), a, b) > reach + search%reach(i)) cycle
              if (n == size(list, 2)) list = reshape(list, [2, 2*n], pad=[0])
              n = n + 1
              list(:, n) = [i, j]
            end do
          end do
        end do
      end associate
    end do
    search%candidate = list(:, order_of_pairs(list(2, :n), list(1, :n)))
  end subroutine list_candidates

  !> Whether a vertex and an edge may touch: of two bodies, or of one that may touch itself.
  pure logical function may_meet(outlines, i, j, self_contact)
    type(outlines_t), intent(in) :: outlines
    integer, intent(in) :: i, j
    logical, intent(in) :: self_contact

    may_meet = .true.
    if (outlines%block(i) == outlines%block(j)) &
      may_meet = self_contact .and. outlines%element(i) /= outlines%element(j) .and. i /= outlines%next(j)
  end function may_meet

  !> What the vertices of the outlines have of a field that is `value` at the unknowns: displacement or velocity.
  pure function at_outlines(model, cache, state, value) result(there)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state               !! at the beginning of the step
    type(cache_t), intent(in) :: cache
    real(dp), intent(in) :: value(:)                 !! (n_unknowns)
    real(dp) :: there(2, size(model%outlines%start))
    integer :: i

    do i = 1, size(there, 2)
      associate (e => model%outlines%element(i))
        there(:, i) = matmul(displacement_matrix(cache%element(e)%kinematics, state%vertex(:, model%outlines%start(i))), &
                             values_of(model%elements, e, value))
      end associate
    end do
  end function at_outlines

  !> How far a vertex went beyond what the search for contacts looked at, 0 where none did; how far an edge that may touch turned
  !> beyond that, rad; and the largest of either, that of the way without what velocity makes, over the most that is looked at.
  pure function outran(model, cache, state, try, d) result(farthest)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state               !! at the beginning of the step
    type(cache_t), intent(in) :: cache
    type(contact_try_t), intent(in) :: try
    real(dp), intent(in) :: d(:)                     !! (n_unknowns)
    real(dp) :: farthest(3), beyond, turned, u(2, size(model%outlines%start))
    logical :: may_touch(size(model%outlines%start)) !! the corner at a vertex
    integer :: i

    farthest = 0.0_dp
    associate (outlines => model%outlines)
      may_touch = .false.
      may_touch(try%nearby(1, :)) = .true.
      may_touch(try%nearby(2, :)) = .true.
      may_touch(outlines%next(try%nearby(2, :))) = .true.
      u = at_outlines(model, cache, state, d)
      do i = 1, size(outlines%start)
        beyond = norm2(u(:, i)) - try%near(i)
        farthest(1) = max(farthest(1), beyond)
        if (beyond > 0) farthest(3) = max(farthest(3), (beyond/try%local(i) &
                                                        + min(try%margin/try%local(i), try%law%leap))/try%law%leap)
      end do
      if (.not. corners_turn(try%law)) return
      do i = 1, size(outlines%start)
        associate (next => outlines%next(i))
          if (.not. (may_touch(i) .or. may_touch(next))) cycle
          turned = norm2(u(:, next) - u(:, i))/norm2(state%vertex(:, outlines%start(next)) - state%vertex(:, outlines%start(i)))
          farthest(2) = max(farthest(2), turned - min(try%turning(i), try%turning(next)) - 0.5_dp*parallel)
          farthest(3) = max(farthest(3), turned/most_turning)
        end associate
      end do
    end associate
  end function outran

end module scree_contact_search
