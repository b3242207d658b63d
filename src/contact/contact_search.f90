!> Which vertices are near which edges: a search in a grid, with room to move, and whether a step outran it.
module scree_contact_search
  use scree_cell_grid, only: cell_grid_t, cells_of_box, number_of_cell, place_boxes, set_up_grid
  use scree_contacts, only: contacts_t, outlines_t, parallel
  use scree_effects, only: element_cache_t
  use scree_interpolation, only: displacement_matrix
  use scree_kinds, only: dp
  use scree_polygon, only: distance_to_segment
  use scree_system, only: state_t, system_t
  implicit none
  private
  public :: at_outlines, outran, search

  real(dp), parameter :: room = 0.02_dp           !! of the edges about, that a search gives a vertex beyond its reach

contains

  !> Lists vertices near edges, where what an earlier search listed may not do.
  pure subroutine search(outlines, position, near, local, self_contact, contacts)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)  !! (2, n_vertices), length
    real(dp), intent(in) :: near(:)      !! (n) how far a contact of each vertex reaches, length
    real(dp), intent(in) :: local(:)     !! (n) shorter edge at each vertex, length
    logical, intent(in) :: self_contact
    type(contacts_t), intent(inout) :: contacts
    type(cell_grid_t) :: grid
    real(dp), allocatable :: vertex(:, :)
    integer, allocatable :: list(:, :)
    integer :: seen(size(near)), range(2, 2)
    integer :: c, column, i, j, k, n, row
    real(dp) :: reach

    vertex = position(:, outlines%start)
    if (allocated(contacts%found_at)) then
      if (all(norm2(vertex - contacts%found_at, 1) + near <= contacts%reach)) return
    end if
    contacts%found_at = vertex
    contacts%reach = 1.5_dp*near + room*local
    call set_up_grid(grid, vertex, size(near))
    call place_boxes(grid, vertex - spread(contacts%reach, 1, 2), vertex + spread(contacts%reach, 1, 2))
    allocate (list(2, 4*size(near)))
    n = 0
    seen = 0
    do j = 1, size(near)
      associate (a => position(:, outlines%start(j)), b => position(:, outlines%finish(j)))
        reach = max(contacts%reach(j), contacts%reach(outlines%next(j)))
        range = cells_of_box(grid, min(a, b) - reach, max(a, b) + reach)
        do row = range(2, 1), range(2, 2)
          do column = range(1, 1), range(1, 2)
            c = number_of_cell(grid, column, row)
            do k = grid%first(c), grid%first(c + 1) - 1
              i = grid%item(k)
              if (seen(i) == j) cycle
              seen(i) = j
              if (outlines%block(i) == outlines%block(j)) then
                if (.not. self_contact .or. outlines%element(i) == outlines%element(j) .or. i == outlines%next(j)) cycle
              end if
              if (distance_to_segment(vertex(:, i), a, b) > reach + contacts%reach(i)) cycle
              if (n == size(list, 2)) list = reshape(list, [2, 2*n], pad=[0])
              n = n + 1
              list(:, n) = [i, j]
            end do
          end do
        end do
      end associate
    end do
    contacts%candidate = reshape([list(:, :n), contacts%inside], [2, n + size(contacts%inside, 2)])
    contacts%link = reshape([integer ::], [2, 0])
  end subroutine search

  !> What the vertices of the outlines have of a field that is `value` at the unknowns: displacement or velocity.
  pure function at_outlines(system, state, share, value) result(there)
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state               !! at the beginning of the step
    type(element_cache_t), intent(in) :: share(:)    !! (n_elements)
    real(dp), intent(in) :: value(:)                 !! (n_unknowns)
    real(dp) :: there(2, size(system%outlines%start))
    integer :: i

    do i = 1, size(there, 2)
      associate (e => system%outlines%element(i))
        there(:, i) = matmul(displacement_matrix(share(e)%kinematics, state%vertex(:, system%outlines%start(i))), &
                             value(system%elements%unknown(:, e)))
      end associate
    end do
  end function at_outlines

  !> How far a vertex went beyond what the search for contacts looked at, 0 where none did; how far an edge that may touch turned
  !> beyond that, rad; and the largest of either, that of the way without what velocity makes, over the most that is looked at.
  pure function outran(system, state, share, d) result(farthest)
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state               !! at the beginning of the step
    type(element_cache_t), intent(in) :: share(:)    !! (n_elements)
    real(dp), intent(in) :: d(:)                     !! (n_unknowns)
    real(dp) :: farthest(3), beyond, turned, u(2, size(system%outlines%start))
    logical :: may_touch(size(system%outlines%start)) !! the corner at a vertex
    integer :: i

    farthest = 0.0_dp
    associate (outlines => system%outlines, contacts => state%contacts)
      may_touch = .false.
      may_touch(contacts%candidate(1, :)) = .true.
      may_touch(contacts%candidate(2, :)) = .true.
      may_touch(outlines%next(contacts%candidate(2, :))) = .true.
      u = at_outlines(system, state, share, d)
      do i = 1, size(outlines%start)
        beyond = norm2(u(:, i)) - contacts%near(i)
        farthest(1) = max(farthest(1), beyond)
        if (beyond > 0) farthest(3) = max(farthest(3), (beyond/contacts%local(i) &
                                                        + min(contacts%margin/contacts%local(i), contacts%leap))/contacts%leap)
      end do
      if (contacts%by_name) return
      do i = 1, size(outlines%start)
        associate (next => outlines%next(i))
          if (.not. (may_touch(i) .or. may_touch(next))) cycle
          turned = norm2(u(:, next) - u(:, i))/norm2(state%vertex(:, outlines%start(next)) - state%vertex(:, outlines%start(i)))
          farthest(2) = max(farthest(2), turned - min(contacts%turning(i), contacts%turning(next)) - 0.5_dp*parallel)
          farthest(3) = max(farthest(3), turned/contacts%most_turning)
        end associate
      end do
    end associate
  end function outran

end module scree_contact_search
