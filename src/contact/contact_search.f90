!> Which vertices are near which edges: a search in a grid, with room to move, and whether a step outran it.
module scree_contact_search
  use scree_body_search, only: list_all, list_unclear, reach_of, room
  use scree_cell_grid, only: cell_grid_t, cells_of_box, number_of_cell, place_boxes, set_up_grid
  use scree_contact_rules, only: corners_turn
  use scree_contact_try, only: contact_try_t
  use scree_contacts, only: contact_search_t, outlines_t, parallel
  use scree_corners, only: side_length
  use scree_interpolation, only: displacement_matrix
  use scree_kinds, only: dp, pi
  use scree_model, only: cache_t, model_t
  use scree_polygon, only: distance_to_segment
  use scree_sorting, only: columns, order_of_pairs
  use scree_state, only: state_t
  use scree_system, only: values_of
  implicit none
  private
  public :: find_at_outlines, find_nearby, find_outrun, most_turning, outrun_t, predict_ways

  !> Room to move of a fast vertex: so many times the reach of pairs, up to a fraction of the edges about it.
  real(dp), parameter :: steps = 4.0_dp, spare = 0.25_dp
  real(dp), parameter :: most_turning = pi/6 !! of a corner in a step, rad

  !> How far a try moved beyond the distances and angles that the search for contacts covered.
  type :: outrun_t
    real(dp), allocatable :: way(:)  !! (n_blocks) largest displacement of a vertex beyond that, 0: none, length
    real(dp), allocatable :: turn(:) !! (n_blocks) largest turn of an edge that may touch beyond that, 0: none, rad
    real(dp), allocatable :: jump(:) !! (n_blocks) largest displacement beyond the predicted one, over the most that is looked at
    real(dp) :: most_turned = 0.0_dp !! largest turn of an edge that may touch, over the most that is looked at
  end type outrun_t

contains

  !> Lists the pairs of a vertex and an edge whose distance is at most the reach of contacts and some room, so that a vertex inside
  !> a body is found, too. Pairs are in the order of the edges. Pairs that were inside when the run began and lie deeper come last.
  !> A new search is made when the list of an earlier search may be incomplete. The pairs do not depend on when the search was made.
  subroutine find_nearby(outlines, position, near, local, self_contact, search, nearby, n_in_order)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)          !! (2, n_vertices), length
    real(dp), intent(in) :: near(:)                 !! (n) how far a contact of each vertex reaches, length
    real(dp), intent(in) :: local(:)                !! (n) shorter edge at each vertex, length
    logical, intent(in) :: self_contact             !! a body may touch itself
    type(contact_search_t), intent(inout) :: search
    integer, allocatable, intent(out) :: nearby(:, :) !! (2, n)
    integer, intent(out), optional :: n_in_order    !! pairs before those that were inside
    real(dp) :: wide(size(near))
    logical :: deep(size(outlines%inside, 2))
    logical, allocatable :: is_near(:)

    if (.not. allocated(search%bodies%vertex)) call list_all(outlines, search%bodies)
    associate (list => search%bodies%vertex)
      wide(list) = near(list) + room*local(list)
    end associate
    if (.not. still_holds(outlines, position, wide, search)) &
      call list_candidates(outlines, position, wide, local, self_contact, search)
    is_near = are_near(outlines, position, wide, search%candidate)
    deep = .not. are_near(outlines, position, wide, outlines%inside)
    nearby = reshape([columns(search%candidate, is_near), columns(outlines%inside, deep)], [2, count(is_near) + count(deep)])
    if (present(n_in_order)) n_in_order = count(is_near)
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
    integer :: i, k

    still_holds = allocated(search%found_at)
    if (.not. still_holds) return
    associate (next => outlines%next, reach => search%reach, bodies => search%bodies)
      do k = 1, size(bodies%vertex)
        i = bodies%vertex(k)
        moved(i) = norm2(position(:, outlines%start(i)) - search%found_at(:, i))
        still_holds = moved(i) + wide(i) <= reach(i)
        if (.not. still_holds) return
      end do
      do k = 1, size(bodies%edge)
        i = bodies%edge(k)
        still_holds = max(moved(i), moved(next(i))) + max(wide(i), wide(next(i))) <= max(reach(i), reach(next(i)))
        if (.not. still_holds) return
      end do
    end associate
  end function still_holds

  !> Searches vertices near edges in a grid, with room to move.
  subroutine list_candidates(outlines, position, wide, local, self_contact, search)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)  !! (2, n_vertices), length
    real(dp), intent(in) :: wide(:)         !! (n) how far from each vertex pairs are near, length
    real(dp), intent(in) :: local(:)        !! (n) shorter edge at each vertex, length
    logical, intent(in) :: self_contact
    type(contact_search_t), intent(inout) :: search
    type(cell_grid_t) :: grid
    real(dp), allocatable :: vertex(:, :), around(:)
    integer, allocatable :: pair(:, :)
    integer :: seen(size(wide)), range(2, 2)
    integer :: c, column, i, j, k, l, n, row
    real(dp) :: reach

    if (.not. allocated(search%reach)) allocate (search%reach(size(wide)))
    if (.not. allocated(search%found_at)) allocate (search%found_at(2, size(wide)))
    vertex = position(:, outlines%start(search%bodies%vertex))
    associate (list => search%bodies%vertex)
      around = wide(list) + max(wide(list), min(steps*wide(list), spare*local(list)))
    end associate
    search%found_at(:, search%bodies%vertex) = vertex
    search%reach(search%bodies%vertex) = around
    search%candidate = reshape([integer ::], [2, 0])
    if (size(around) == 0) return
    call set_up_grid(grid, vertex, size(around))
    call place_boxes(grid, vertex - spread(around, 1, 2), vertex + spread(around, 1, 2))
    allocate (pair(2, 4*size(around)))
    n = 0
    seen = 0
    do l = 1, size(search%bodies%edge)
      j = search%bodies%edge(l)
      associate (a => position(:, outlines%start(j)), b => position(:, outlines%finish(j)))
        reach = max(search%reach(j), search%reach(outlines%next(j)))
        range = cells_of_box(grid, min(a, b) - reach, max(a, b) + reach)
        do row = range(2, 1), range(2, 2)
          do column = range(1, 1), range(1, 2)
            c = number_of_cell(grid, column, row)
            do k = grid%first(c), grid%first(c + 1) - 1
              i = search%bodies%vertex(grid%item(k))
              if (seen(i) == j) cycle
              seen(i) = j
              if (.not. may_meet(outlines, i, j, self_contact)) cycle
              if (distance_to_segment(vertex(:, grid%item(k)), a, b) > reach + search%reach(i)) cycle
              if (n == size(pair, 2)) pair = reshape(pair, [2, 2*n], pad=[0])
              n = n + 1
              pair(:, n) = [i, j]
            end do
          end do
        end do
      end associate
    end do
    search%candidate = pair(:, order_of_pairs(pair(2, :n), pair(1, :n)))
  end subroutine list_candidates

  !> Whether a vertex and an edge may touch. Neither body has been removed, and one of them can move, or it is one body that may
  !> touch itself.
  pure logical function may_meet(outlines, i, j, self_contact)
    type(outlines_t), intent(in) :: outlines
    integer, intent(in) :: i, j
    logical, intent(in) :: self_contact

    may_meet = .not. (outlines%fixed(i) .and. outlines%fixed(j)) .and. .not. (outlines%gone(i) .or. outlines%gone(j))
    if (outlines%block(i) == outlines%block(j)) &
      may_meet = may_meet .and. self_contact .and. outlines%of_vertex(i) /= outlines%element(j) .and. i /= outlines%next(j)
  end function may_meet

  !> Values at listed vertices of a field that is `value` at the unknowns: displacement or velocity, or a multiple.
  pure subroutine find_at_outlines(model, cache, state, value, times, list, there)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state               !! at the beginning of the step
    type(cache_t), intent(in) :: cache
    real(dp), intent(in) :: value(:)                 !! (n_unknowns)
    real(dp), intent(in) :: times
    integer, intent(in) :: list(:)                   !! vertices
    real(dp), intent(inout) :: there(:, :)           !! (2, n) of the listed
    integer :: i, k

    do k = 1, size(list)
      i = list(k)
      there(:, i) = 0.0_dp
      if (model%outlines%fixed(i)) cycle
      associate (e => model%outlines%of_vertex(i))
        there(:, i) = times*matmul(displacement_matrix(cache%element(e)%kinematics, state%vertex(:, model%outlines%start(i))), &
                                   values_of(model%elements, e, value))
      end associate
    end do
  end subroutine find_at_outlines

  !> Predicts the displacement of listed vertices in a step: by their velocity, or where that is farther as in the try before.
  pure subroutine predict_ways(model, cache, state, dt, try, list, predicted)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state               !! at the beginning of the step
    type(cache_t), intent(in) :: cache
    real(dp), intent(in) :: dt                       !! of the step, time
    type(contact_try_t), intent(in) :: try
    integer, intent(in) :: list(:)                   !! vertices
    real(dp), intent(inout) :: predicted(:, :)       !! (2, n) of the listed
    real(dp), allocatable :: jumped(:, :)
    integer :: k

    call find_at_outlines(model, cache, state, state%velocity, dt, list, predicted)
    if (.not. allocated(try%jumped)) return
    allocate (jumped, mold=predicted)
    call find_at_outlines(model, cache, state, try%jumped, 1.0_dp, list, jumped)
    do k = 1, size(list)
      if (norm2(jumped(:, list(k))) > norm2(predicted(:, list(k)))) predicted(:, list(k)) = jumped(:, list(k))
    end do
  end subroutine predict_ways

  !> Finds how far a try moved beyond the distances and angles that the search for contacts covered.
  pure subroutine find_outrun(model, cache, state, dt, try, d, outrun)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state               !! at the beginning of the step
    type(cache_t), intent(in) :: cache
    real(dp), intent(in) :: dt                       !! of the step, time
    type(contact_try_t), intent(inout) :: try        !! is told whether all is clear
    real(dp), contiguous, intent(in) :: d(:)         !! (n_unknowns)
    type(outrun_t), intent(out) :: outrun
    real(dp), allocatable :: u(:, :)
    integer, allocatable :: unclear(:)
    integer :: b, i, k

    allocate (outrun%way(model%n_blocks), outrun%turn(model%n_blocks), outrun%jump(model%n_blocks), source=0.0_dp)
    associate (outlines => model%outlines, bodies => cache%search%bodies, survey => cache%search%survey)
      if (allocated(bodies%near)) call list_unclear(model, state, dt, try%extra_reach, d, bodies, unclear)
      try%all_clear = allocated(bodies%near) .and. .not. allocated(unclear)
      if (allocated(unclear)) then
        do k = 1, size(unclear)
          call add_way(model, cache, state, dt, try, d, &
                       outlines%of_block(outlines%first(unclear(k)):outlines%first(unclear(k) + 1) - 1), outrun)
        end do
      end if
      if (size(bodies%vertex) == 0) return
      allocate (u(2, size(outlines%start)))
      call find_at_outlines(model, cache, state, d, 1.0_dp, bodies%farther, u)
      do k = 1, size(bodies%vertex)
        i = bodies%vertex(k)
        b = outlines%block(i)
        call add_beyond(norm2(u(:, i)) - survey%reach_edge(i), survey%local_side(i), try%extra_reach(b), &
            try%law%largest_jump, outrun%way(b), &
                        outrun%jump(b))
      end do
    end associate
    if (corners_turn(try%law)) call add_turns(model, state, cache%search, try%nearby, u, outrun)
  end subroutine find_outrun

  !> Adds the displacement of a vertex beyond the distance that was covered.
  pure subroutine add_beyond(beyond, side, extra_reach, most, farthest, jump)
    real(dp), intent(in) :: beyond, side, extra_reach !! length
    real(dp), intent(in) :: most                     !! of the sides about, that a vertex may go beyond the predicted displacement
    real(dp), intent(inout) :: farthest              !! length
    real(dp), intent(inout) :: jump

    farthest = max(farthest, beyond)
    if (beyond > 0) jump = max(jump, (beyond/side + min(extra_reach/side, most))/most)
  end subroutine add_beyond

  !> Adds the displacements of vertices of a body without others near it, beyond the distances that a search would have covered.
  pure subroutine add_way(model, cache, state, dt, try, d, list, outrun)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state               !! at the beginning of the step
    real(dp), intent(in) :: dt                       !! time
    type(contact_try_t), intent(in) :: try
    real(dp), intent(in) :: d(:)                     !! (n_unknowns)
    integer, intent(in) :: list(:)                   !! vertices of the outlines
    type(outrun_t), intent(inout) :: outrun
    real(dp), dimension(2, size(model%outlines%start)) :: u, predicted
    real(dp) :: edge, near, pressed, side
    integer :: b, k

    call find_at_outlines(model, cache, state, d, 1.0_dp, list, u)
    call predict_ways(model, cache, state, dt, try, list, predicted)
    if (size(list) == 0) return
    b = model%outlines%block(list(1))
    pressed = 0.0_dp
    if (allocated(try%pressed)) pressed = try%pressed(b)
    associate (outlines => model%outlines, x => state%vertex, law => model%effects%contact)
      do k = 1, size(list)
        associate (i => list(k), before => outlines%previous(list(k)))
          edge = min(norm2(x(:, outlines%finish(i)) - x(:, outlines%start(i))), &
                     norm2(x(:, outlines%finish(before)) - x(:, outlines%start(before))))
          side = min(side_length(outlines, x, i), side_length(outlines, x, before))
          near = reach_of(law, try%extra_reach(b), pressed, norm2(predicted(:, i)), edge, side)
          call add_beyond(norm2(u(:, i)) - near, side, try%extra_reach(b), law%largest_jump, outrun%way(b), outrun%jump(b))
        end associate
      end do
    end associate
  end subroutine add_way

  !> Adds how far edges that may touch turned beyond the angle that was covered.
  pure subroutine add_turns(model, state, search, nearby, u, outrun)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state               !! at the beginning of the step
    type(contact_search_t), intent(in) :: search
    integer, intent(in) :: nearby(:, :)              !! (2, n) vertices and edges near enough to meet in the step
    real(dp), intent(in) :: u(:, :)                  !! (2, n) displacement of the vertices looked at, those after and before
    type(outrun_t), intent(inout) :: outrun
    real(dp) :: turned
    logical :: may_touch(size(model%outlines%start)) !! the corner at a vertex
    integer :: i, k, side

    associate (outlines => model%outlines, list => search%bodies%vertex, turning => search%survey%turning)
      may_touch(list) = .false.
      may_touch(nearby(1, :)) = .true.
      may_touch(nearby(2, :)) = .true.
      may_touch(outlines%next(nearby(2, :))) = .true.
      do k = 1, size(list)
        if (.not. may_touch(list(k))) cycle
        do side = 1, 2
          i = merge(list(k), outlines%previous(list(k)), side == 1)
          associate (next => outlines%next(i), start => outlines%start)
            turned = norm2(u(:, next) - u(:, i))/norm2(state%vertex(:, start(next)) - state%vertex(:, start(i)))
            associate (farthest => outrun%turn(outlines%block(i)))
              farthest = max(farthest, turned - min(turning(i), turning(next)) - 0.5_dp*parallel)
            end associate
            outrun%most_turned = max(outrun%most_turned, turned/most_turning)
          end associate
        end do
      end do
    end associate
  end subroutine add_turns

end module scree_contact_search
