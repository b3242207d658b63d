!> Search for bodies that are near each other, which limits the contacts that a step looks for. For a body that is far from all
!> others only its displacement is checked.
!>
!> Around each body that can move lies a circle that contains its vertices and the places that they may reach in many steps. The
!> body is near others if an edge of another body, with the reach of this edge, comes into the circle. Only then the vertices and
!> edges of both bodies are looked at. The circles hold until a body has moved as far as they extend beyond the reach of its
!> contacts. The contacts found do not depend on when the circles were drawn.
module scree_body_search
  use scree_cell_grid, only: cell_grid_t, cells_of_box, number_of_cell, place_boxes, set_up_grid
  use scree_contact_rules, only: looks_at_all, set_reach
  use scree_contacts, only: body_search_t, contact_law_t, outlines_t, parallel
  use scree_corners, only: side_length, side_lengths
  use scree_interpolation, only: most_moved
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_polygon, only: distance_to_segment
  use scree_state, only: state_t
  use scree_system, only: element_unknowns, values_of
  implicit none
  private
  public :: beyond_way, draw_circles, list_all, list_unclear, move_circles, near_at_rest, reach_of, room, searches

  !> Distance beyond the end of an edge up to which a vertex may cross its line, over the length of the edges about.
  real(dp), parameter :: deepest = 0.05_dp
  !> Distance up to which a contact at rest is found, over the length of the edges about.
  real(dp), parameter :: near_at_rest = 1e-3_dp
  !> Displacement that the search allows for in a step, over that by the velocity.
  real(dp), parameter :: beyond_way = 1.2_dp
  !> Distance beyond the reach of contacts that circles contain, over the length of the edges about.
  real(dp), parameter :: room = 0.02_dp
  !> Displacement of a body after which its circle is drawn anew, over its longest side; or else in steps at its velocity.
  real(dp), parameter :: spare = 0.25_dp, steps = 20.0_dp
  !> A body that is clear of others may go this many times as far.
  real(dp), parameter :: many = 16.0_dp

contains

  !> How far contacts of vertices are looked for in a step, with the length of the edges about them.
  !>
  !> The line of an edge may be crossed beyond its end, up to a distance of the overlap over the sine of the corner. A contact that
  !> is found or lost there would add or remove the energy of its spring. The reach covers this distance, except at corners that
  !> turn by less than `parallel`.
  elemental real(dp) function reach_of(law, extra_reach, pressed, way, edge, side) result(near)
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: extra_reach          !! added to the displacement by the velocity, length
    real(dp), intent(in) :: pressed              !! largest overlap of a spring of the body, length
    real(dp), intent(in) :: way                  !! displacement by the velocity, length
    real(dp), intent(in) :: edge                 !! shortest edge about, length
    real(dp), intent(in) :: side                 !! shortest side about, length

    near = reach_in_motion(law%largest_jump, extra_reach, pressed, way, edge, side)
    call set_reach(law, near)
  end function reach_of

  !> Likewise where contacts are looked for as far as vertices move.
  elemental real(dp) function reach_in_motion(largest_jump, extra_reach, pressed, way, edge, side) result(near)
    real(dp), intent(in) :: largest_jump         !! largest displacement beyond that by the velocity, over the sides about
    real(dp), intent(in) :: extra_reach, pressed, way, edge, side !! length

    near = beyond_way*way + min(extra_reach, largest_jump*side) + near_at_rest*edge + min(pressed/sin(parallel), deepest*edge)
  end function reach_in_motion

  !> Whether bodies are looked for before their vertices are; else all vertices are looked at in each step.
  pure logical function searches(model)
    type(model_t), intent(in) :: model

    searches = .not. looks_at_all(model%effects%contact)
  end function searches

  !> Draws the circles anew if a body may leave its circle in a step of size `dt`, by its velocity or by the displacement of the try
  !> before.
  subroutine draw_circles(model, state, dt, extra_reach, bodies, drawn, jumped)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(dp), intent(in) :: dt                    !! time
    real(dp), intent(in) :: extra_reach(:)        !! (n_blocks) that the search adds to the way of a vertex, length
    type(body_search_t), intent(inout) :: bodies
    logical, intent(out) :: drawn
    real(dp), intent(in), optional :: jumped(:)   !! (n_unknowns) displacement of the try before
    real(dp), allocatable :: reach(:), way(:)
    integer :: i

    drawn = .not. allocated(bodies%reach)
    if (.not. drawn) drawn = maxval(extra_reach) > bodies%extra_reach .or. state%contacts%pressed > bodies%pressed
    if (drawn) call measure_bodies(model, state, maxval(extra_reach), state%contacts%pressed, bodies)
    way = bodies%speed
    call find_largest(model, state%velocity, bodies, way)
    bodies%speed = way
    if (present(jumped)) then
      way = 0.0_dp
      call find_largest(model, jumped, bodies, way)
      bodies%speed = max(bodies%speed, way/dt)
    end if
    do i = 1, size(model%free_block)
      if (drawn) exit
      associate (b => model%free_block(i))
        drawn = bodies%moved(b) + reach_in_step(model, state, extra_reach(b), bodies%longest(b) + 2*bodies%moved(b), &
                                                dt*bodies%speed(b)) > bodies%reach(b)
      end associate
    end do
    if (.not. drawn) return
    call measure_bodies(model, state, maxval(extra_reach), state%contacts%pressed, bodies)
    associate (b => model%free_block)
      reach = reach_in_step(model, state, extra_reach(b), bodies%longest(b), dt*bodies%speed(b)) + steps*dt*bodies%speed(b) &
              + spare*bodies%longest(b)
    end associate
    call find_near(model, state, reach, bodies)
  end subroutine draw_circles

  !> How far contacts of a body are looked for in a step, length.
  elemental real(dp) function reach_in_step(model, state, extra_reach, longest, way) result(reach)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(dp), intent(in) :: extra_reach           !! that the search adds to the way of a vertex, length
    real(dp), intent(in) :: longest               !! side of the body, length
    real(dp), intent(in) :: way                   !! by its velocity, length

    reach = room*longest + reach_in_motion(model%effects%contact%largest_jump, extra_reach, state%contacts%pressed, way, &
        longest, longest)
  end function reach_in_step

  !> Circles, edges and reaches at rest of all bodies as they stand.
  subroutine measure_bodies(model, state, extra_reach, pressed, bodies)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(dp), intent(in) :: extra_reach, pressed  !! length
    type(body_search_t), intent(inout) :: bodies
    real(dp) :: high(2), low(2)
    integer :: b, k

    if (.not. allocated(bodies%reach)) then
      allocate (bodies%centre(2, model%n_blocks), bodies%radius(model%n_blocks), bodies%longest(model%n_blocks), &
                bodies%shortest(model%n_blocks), bodies%moved(model%n_blocks), bodies%reach(model%n_blocks), &
                bodies%speed(model%n_blocks))
      bodies%speed = 0.0_dp ! of bodies that cannot move, which nothing measures
    end if
    bodies%extra_reach = 2*extra_reach
    bodies%pressed = 2*pressed
    bodies%moved = 0.0_dp
    associate (outlines => model%outlines, x => state%vertex)
      do b = 1, model%n_blocks
        low = huge(low)
        high = -huge(high)
        bodies%longest(b) = maxval(side_lengths(outlines, x, outlines%of_block(outlines%first(b):outlines%first(b + 1) - 1)))
        bodies%shortest(b) = huge(1.0_dp)
        do k = outlines%first(b), outlines%first(b + 1) - 1
          associate (start => x(:, outlines%start(outlines%of_block(k))))
            low = min(low, start)
            high = max(high, start)
          end associate
          associate (start => model%start(:, outlines%start(outlines%of_block(k))), &
                     finish => model%start(:, outlines%finish(outlines%of_block(k))))
            bodies%shortest(b) = min(bodies%shortest(b), norm2(finish - start))
          end associate
        end do
        bodies%centre(:, b) = 0.5_dp*(low + high)
        bodies%radius(b) = 0.5_dp*norm2(high - low)
      end do
      bodies%extra_reach = bodies%extra_reach + near_at_rest*minval(bodies%shortest)
      bodies%pressed = bodies%pressed + near_at_rest*near_at_rest*minval(bodies%shortest)
      bodies%reach = reach_at_rest(model, bodies, bodies%longest, bodies%longest)
    end associate
  end subroutine measure_bodies

  !> Reach of contacts of a body that does not move, as long as circles hold, from the longest edge and side about.
  elemental real(dp) function reach_at_rest(model, bodies, edge, side) result(reach)
    type(model_t), intent(in) :: model
    type(body_search_t), intent(in) :: bodies
    real(dp), intent(in) :: edge, side            !! longest about, length

    reach = reach_in_motion(model%effects%contact%largest_jump, bodies%extra_reach, bodies%pressed, 0.0_dp, edge, side) &
        + room*edge &
            + model%effects%contact%most_dilated
  end function reach_at_rest

  !> Adds an upper bound of the displacement of a step. If all bodies kept clear of others, it is the displacement by velocity and
  !> the largest additional one that they could have had.
  subroutine move_circles(model, dt, extra_reach, d, all_clear, bodies)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: dt                    !! of the step, time
    real(dp), intent(in) :: extra_reach(:)        !! (n_blocks) that the search added to the way of a vertex, length
    real(dp), intent(in) :: d(:)                  !! (n_unknowns)
    logical, intent(in) :: all_clear              !! all bodies that no other is near kept clear
    type(body_search_t), intent(inout) :: bodies
    real(dp), allocatable :: way(:)
    integer :: i

    if (all_clear .and. size(bodies%vertex) == 0) then
      do i = 1, size(model%free_block)
        associate (b => model%free_block(i))
          bodies%moved(b) = bodies%moved(b) + dt*bodies%speed(b) &
                            + beyond_velocity(model, extra_reach(b), bodies%longest(b) + 2*bodies%moved(b))
        end associate
      end do
    else
      allocate (way(model%n_blocks))
      call find_largest(model, d, bodies, way)
      bodies%moved(model%free_block) = bodies%moved(model%free_block) + way(model%free_block)
    end if
  end subroutine move_circles

  !> How far a vertex may move beyond its displacement by velocity and still be within the reach of contacts.
  elemental real(dp) function beyond_velocity(model, extra_reach, local) result(way)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: extra_reach           !! length
    real(dp), intent(in) :: local                 !! of the edges about, length

    way = near_at_rest*local + min(extra_reach, model%effects%contact%largest_jump*local)
  end function beyond_velocity

  !> Bounds of how far, or how fast, the vertices of each body that can move go: the largest of its elements.
  pure subroutine find_largest(model, d, bodies, largest)
    type(model_t), intent(in) :: model
    real(dp), contiguous, intent(in) :: d(:)      !! (n_unknowns)
    type(body_search_t), intent(in) :: bodies
    real(dp), intent(inout) :: largest(:)         !! (n_blocks), of those that can move
    real(dp) :: own
    integer :: b, e, k, last

    last = 0
    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      b = model%elements%block(e)
      own = most_moved(model%model, model%effects%rotation, values_of(model%elements, e, d), &
                       2*(bodies%radius(b) + bodies%moved(b)))
      if (b == last) own = max(own, largest(b))
      largest(b) = own
      last = b
    end do
  end subroutine find_largest

  !> Lists the bodies without others near them of which a vertex may have moved farther, beyond its displacement by velocity, than
  !> the reach of contacts at rest. No vertex of the other bodies has.
  pure subroutine list_unclear(model, state, dt, extra_reach, d, bodies, unclear)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(dp), intent(in) :: dt                    !! time
    real(dp), intent(in) :: extra_reach(:)        !! (n_blocks) length
    real(dp), contiguous, intent(in) :: d(:)      !! (n_unknowns)
    type(body_search_t), intent(in) :: bodies
    integer, allocatable, intent(out) :: unclear(:) !! not allocated: none
    real(dp) :: beyond(element_unknowns), local
    integer :: b, e, i, k

    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      b = model%elements%block(e)
      if (bodies%near(b)) cycle
      associate (F => state%deformation(:, e)) ! which shortens no edge more than this
        local = bodies%shortest(b)*max(0.0_dp, 0.99_dp*(F(1)*F(4) - F(2)*F(3))/sqrt(F(1)**2 + F(2)**2 + F(3)**2 + F(4)**2))
      end associate
      do i = 1, element_unknowns
        beyond(i) = d(model%elements%unknown(i, e)) - dt*state%velocity(model%elements%unknown(i, e))
      end do
      if (most_moved(model%model, model%effects%rotation, beyond, 2*(bodies%radius(b) + bodies%moved(b))) &
          <= beyond_velocity(model, extra_reach(b), local)) cycle
      if (.not. allocated(unclear)) allocate (unclear(0))
      if (all(unclear /= b)) unclear = [unclear, b]
    end do
  end subroutine list_unclear

  !> Finds the bodies that others are near, and lists the edges and vertices to look at. A circle is as large as it can be without
  !> others in it, between the least reach and a multiple of it. If others are near all bodies at the least reach, larger circles
  !> are not tried.
  subroutine find_near(model, state, least, bodies)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(dp), intent(in) :: least(:)              !! reach of the bodies that can move, length
    type(body_search_t), intent(inout) :: bodies
    logical :: is_near(model%n_blocks), looked_at(size(model%outlines%start))
    real(dp) :: clear(model%n_blocks)
    integer :: b, i, k

    associate (outlines => model%outlines, free => model%free_block)
      bodies%reach(free) = least
      call mark_near(model, state, bodies, is_near, looked_at, clear)
      if (.not. all(is_near(free))) then
        bodies%reach(free) = many*least
        call mark_near(model, state, bodies, is_near, looked_at, clear)
        if (any(is_near)) then
          bodies%reach(free) = max(least, min(bodies%reach(free), 0.99_dp*clear(free)))
          call mark_near(model, state, bodies, is_near, looked_at, clear)
        end if
      end if
      do k = 2, size(model%elements%free) ! elements of one body may touch each other
        associate (of_block => model%elements%block(model%elements%free(k - 1:k)))
          if (of_block(1) == of_block(2)) is_near(of_block(1)) = .true.
        end associate
      end do
      call look_inside(outlines%inside)
      call look_inside(state%contacts%inside)
      do i = 1, size(free)
        b = free(i)
        if (is_near(b)) looked_at(outlines%of_block(outlines%first(b):outlines%first(b + 1) - 1)) = .true.
      end do
      bodies%near = is_near
    end associate
    call list_looked_at(model%outlines, looked_at, bodies)

  contains

    !> Looks at vertices inside of bodies, wherever they are.
    subroutine look_inside(pair)
      integer, intent(in) :: pair(:, :)           !! (2, n) vertices, each with an edge
      integer :: k

      do k = 1, size(pair, 2)
        looked_at(pair(:, k)) = .true.
        is_near(model%outlines%block(pair(:, k))) = .true.
      end do
    end subroutine look_inside

  end subroutine find_near

  !> Marks bodies that can move with edges of others in their circles, and these edges.
  subroutine mark_near(model, state, bodies, is_near, looked_at, clear)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(body_search_t), intent(in) :: bodies
    logical, intent(out) :: is_near(:), looked_at(:)
    real(dp), intent(out) :: clear(:)             !! (n_blocks) reach with which no edge would be in the circle of a body, length
    type(cell_grid_t) :: grid
    integer :: seen(model%n_blocks), range(2, 2)
    real(dp) :: gap, reach, share
    integer :: b, c, column, i, j, row

    is_near = .false.
    looked_at = .false.
    clear = huge(clear)
    seen = 0
    associate (outlines => model%outlines, x => state%vertex, free => model%free_block)
      if (size(free) == 0) return
      call set_up_grid(grid, reshape([bodies%centre(:, free) - spread(bodies%radius(free), 1, 2), &
                                      bodies%centre(:, free) + spread(bodies%radius(free), 1, 2)], [2, 2*size(free)]), size(free))
      call place_boxes(grid, bodies%centre(:, free) - spread(bodies%radius(free) + bodies%reach(free), 1, 2), &
                       bodies%centre(:, free) + spread(bodies%radius(free) + bodies%reach(free), 1, 2))
      do j = 1, size(looked_at)
        if (outlines%gone(j)) cycle
        associate (start => x(:, outlines%start(j)), finish => x(:, outlines%finish(j)))
          reach = bodies%reach(outlines%block(j))
          if (outlines%fixed(j)) reach = reach_at_rest(model, bodies, norm2(finish - start), side_length(outlines, x, j))
          range = cells_of_box(grid, min(start, finish) - reach, max(start, finish) + reach)
          do row = range(2, 1), range(2, 2)
            do column = range(1, 1), range(1, 2)
              c = number_of_cell(grid, column, row)
              do i = grid%first(c), grid%first(c + 1) - 1
                b = free(grid%item(i))
                if (seen(b) == j .or. b == outlines%block(j)) cycle
                seen(b) = j
                gap = distance_to_segment(bodies%centre(:, b), start, finish) - bodies%radius(b)
                if (gap > bodies%reach(b) + reach) cycle
                is_near(b) = .true.
                looked_at(j) = .true.
                if (outlines%fixed(j)) then
                  clear(b) = min(clear(b), gap - reach)
                else
                  share = gap/(bodies%reach(b) + reach)
                  clear(b) = min(clear(b), share*bodies%reach(b))
                  clear(outlines%block(j)) = min(clear(outlines%block(j)), share*reach)
                end if
              end do
            end do
          end do
        end associate
      end do
    end associate
  end subroutine mark_near

  !> Lists all vertices and edges.
  pure subroutine list_all(outlines, bodies)
    type(outlines_t), intent(in) :: outlines
    type(body_search_t), intent(inout) :: bodies
    logical :: looked_at(size(outlines%start))

    looked_at = .true.
    call list_looked_at(outlines, looked_at, bodies)
  end subroutine list_all

  !> Lists edges, the vertices at their ends, and the vertices and edges about these.
  pure subroutine list_looked_at(outlines, edge, bodies)
    type(outlines_t), intent(in) :: outlines
    logical, intent(in) :: edge(:)                !! (n) is looked at
    type(body_search_t), intent(inout) :: bodies
    logical :: listed(size(edge))
    integer :: i, k

    bodies%edge = pack([(i, i=1, size(edge))], edge)
    listed = edge
    listed(outlines%next(bodies%edge)) = .true.
    bodies%vertex = pack([(i, i=1, size(edge))], listed)
    bodies%about = bodies%vertex
    do k = 1, 2
      listed(outlines%previous(bodies%about)) = .true.
      listed(outlines%next(bodies%about)) = .true.
      bodies%about = pack([(i, i=1, size(edge))], listed)
    end do
    listed(outlines%previous(bodies%about)) = .true.
    listed(outlines%next(bodies%about)) = .true.
    bodies%farther = pack([(i, i=1, size(edge))], listed)
  end subroutine list_looked_at

end module scree_body_search
