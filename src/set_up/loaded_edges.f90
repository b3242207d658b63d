!> The pieces of edges that lines of the deck load.
module scree_loaded_edges
  use scree_edge_load, only: edge_load_t
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_kinds, only: dp
  use scree_scene, only: scene_t
  use scree_setting_table, only: given_at
  use scree_state, only: state_t
  use scree_system, only: edge_end, system_t
  use scree_text, only: number_text
  implicit none
  private
  public :: load_edges

  !> An edge lies on a line that is nearer than this share of the extent to it, and leans from it by less than this (sine).
  real(dp), parameter :: nearest = 1e-4_dp, least_turn = 1e-2_dp
  !> Pieces shorter than this share of their line are none.
  real(dp), parameter :: shortest = 1e-9_dp

contains

  !> Finds the pieces of outer edges, and of both sides of joints, that lie on the lines of &boundary; their ends are points of the
  !> system. Not allocated where there are no lines.
  !>
  !> Errors: a line on which no edge lies.
  subroutine load_edges(scene, system, state, load, error)
    type(scene_t), intent(in) :: scene
    type(system_t), intent(inout) :: system
    type(state_t), intent(inout) :: state
    type(edge_load_t), allocatable, intent(out) :: load
    type(error_t), allocatable, intent(out) :: error
    logical :: found(max(1, size(scene%boundary_loads)))
    integer :: e, k, l, last, line

    if (size(scene%boundary_loads) == 0) return
    allocate (load)
    allocate (load%first(system%n_elements + 1), load%point(2, 0), load%pressure(2, 0), load%traction(2, 2, 0))
    load%ramp = scene%settings%boundary_ramp
    load%first(1) = 1
    found = .false.
    associate (shape => system%elements%shape)
      do e = 1, system%n_elements
        do l = shape%first_loop(e), shape%first_loop(e + 1) - 1
          last = shape%first_vertex(l + 1) - 1
          do k = shape%first_vertex(l), last
            if (shape%joint(k) == 0) cycle ! a line of the mesh
            do line = 1, size(scene%boundary_loads)
              call add_piece(line, e, state%vertex(:, [k, merge(shape%first_vertex(l), k + 1, k == last)]))
            end do
          end do
        end do
        load%first(e + 1) = size(load%point, 2) + 1
      end do
    end associate
    if (all(found)) return
    call fail(error, status_bad_input, given_at(scene%words, 'boundary.lines')//': expected lines that edges of blocks lie on, '// &
              'found none on line '//number_text(findloc(found, .false., 1)))

  contains

    !> Adds the piece of an edge that lies on a line, if any.
    subroutine add_piece(line, e, edge)
      integer, intent(in) :: line, e
      real(dp), intent(in) :: edge(2, 2)      !! its ends, length
      real(dp) :: along(2), ends(2, 2), length, side(2), span, s(2), share(2)
      integer :: k

      associate (given => scene%boundary_loads(line))
        ends = given%ends - spread(system%origin, 2, 2)
        span = norm2(ends(:, 2) - ends(:, 1))
        along = (ends(:, 2) - ends(:, 1))/span
        length = norm2(edge(:, 2) - edge(:, 1))
        do k = 1, 2
          s(k) = dot_product(edge(:, k) - ends(:, 1), along)/span
          side(k) = along(1)*(edge(2, k) - ends(2, 1)) - along(2)*(edge(1, k) - ends(1, 1))
        end do
        if (maxval(abs(side)) > nearest*scene%extent .or. abs(side(2) - side(1)) > least_turn*length) return
        share = min(1.0_dp, max(0.0_dp, s))
        if (abs(share(2) - share(1)) < shortest) return
        found(line) = .true.
        do k = 1, 2
          call add_point(e, edge(:, 1) + (share(k) - s(1))/(s(2) - s(1))*(edge(:, 2) - edge(:, 1)))
        end do
        associate (m => size(system%points%kind))
          load%point = reshape([load%point, m - 1, m], [2, size(load%point, 2) + 1])
        end associate
        load%pressure = reshape([load%pressure, (1 - share)*given%pressure(1) + share*given%pressure(2)], [2, size(load%point, 2)])
        length = length*abs((share(2) - share(1))/(s(2) - s(1)))
        load%traction = reshape([load%traction, (length*((1 - share(k))*given%traction(:, 1) + share(k)*given%traction(:, 2)), &
                                                 k=1, 2)], [2, 2, size(load%point, 2)])
      end associate
    end subroutine add_piece

    !> Adds a point of an element.
    subroutine add_point(e, position)
      integer, intent(in) :: e
      real(dp), intent(in) :: position(2)     !! length

      system%points%kind = [system%points%kind, edge_end]
      system%points%element = [system%points%element, e]
      state%point = reshape([state%point, position], [2, size(state%point, 2) + 1])
    end subroutine add_point

  end subroutine load_edges

end module scree_loaded_edges
