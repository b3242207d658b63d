!> The pieces of edges that lines of the deck load, or that absorb waves.
module scree_loaded_edges
  use scree_absorbing_edge, only: absorbing_edge_t
  use scree_edge_load, only: edge_load_t
  use scree_edges_on_lines, only: add_point, gap_t, largest_gap, piece_t, pieces_beside, pieces_on_line, pieces_under_water
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_free_fields, only: add_free_fields
  use scree_kinds, only: dp
  use scree_material, only: elasticity
  use scree_scene, only: scene_t, time_table_t
  use scree_setting_table, only: given_at
  use scree_sorting, only: sort_into
  use scree_state, only: state_t
  use scree_system, only: absorber_end, edge_end, system_t
  use scree_text, only: append, number_text, short_text, text_t
  implicit none
  private
  public :: absorb_on_edges, find_pieces, gaps_of_lines, load_carriers, load_edges

  !> Fraction of a line without an edge above which a run is refused, and above which `check` and a run warn.
  real(dp), parameter :: most_gap = 0.1_dp, noticeable_gap = 1e-3_dp

contains

  !> Finds the pieces that the lines of &boundary and the water load; their ends become points of the system. Not allocated where
  !> there is neither.
  !>
  !> Errors: a line on which no edge lies, water that reaches none.
  subroutine load_edges(scene, system, state, load, error)
    type(scene_t), intent(in) :: scene
    type(system_t), intent(inout) :: system
    type(state_t), intent(inout) :: state
    type(edge_load_t), allocatable, intent(out) :: load
    type(error_t), allocatable, intent(out) :: error
    type(piece_t), allocatable :: more(:), piece(:)
    integer, allocatable :: line(:), order(:)
    real(dp) :: pressure(2), traction(2, 2)
    integer :: i, k

    if (size(scene%boundary_loads) == 0 .and. .not. allocated(scene%settings%water_table)) return
    allocate (piece(0), line(0))
    do i = 1, size(scene%boundary_loads)
      call find_pieces(scene, system, state, 'boundary.lines', i, scene%boundary_loads(i)%ends, more, error)
      if (allocated(error)) return
      piece = [piece, more]
      line = [line, spread(i, 1, size(more))]
    end do
    if (allocated(scene%settings%water_table)) then
      associate (table => scene%settings%water_table)
        more = pieces_under_water(system, state, reshape(table, [2, size(table)/2]))
      end associate
      if (size(more) == 0) then
        call fail(error, status_bad_input, given_at(scene%words, 'water.table')// &
                  ': expected edges of blocks below water.table, found none')
        return
      end if
      more = pack(more, is_there(system, more))
      piece = [piece, more]
      line = [line, spread(0, 1, size(more))]
    end if
    allocate (load)
    load%ramp = scene%settings%boundary_ramp
    call sort_into(piece%element, system%n_elements, load%first, order)
    allocate (load%point(2, 0), load%pressure(2, 0), load%traction(2, 2, 0))
    do i = 1, size(order)
      associate (own => piece(order(i)))
        pressure = scene%settings%water_weight*own%depth
        traction = 0.0_dp
        if (line(order(i)) > 0) then
          associate (given => scene%boundary_loads(line(order(i))), length => norm2(own%ends(:, 2) - own%ends(:, 1)))
            do k = 1, 2
              pressure(k) = (1 - own%share(k))*given%pressure(1) + own%share(k)*given%pressure(2)
              traction(:, k) = length*((1 - own%share(k))*given%traction(:, 1) + own%share(k)*given%traction(:, 2))
            end do
          end associate
        end if
        if (scene%settings%second_order) then
          call load_three_places(own, traction, system, state, load)
        else
          do k = 1, 2
            call add_point(edge_end, own%element, own%ends(:, k), system, state)
          end do
          call add_piece(load, size(system%points%kind) - [1, 0], pressure, traction)
        end if
      end associate
    end do
  end subroutine load_edges

  !> Adds a piece to a load.
  pure subroutine add_piece(load, point, pressure, traction)
    type(edge_load_t), intent(inout) :: load
    integer, intent(in) :: point(2)
    real(dp), intent(in) :: pressure(2), traction(2, 2)

    associate (n => size(load%point, 2))
      load%point = reshape([load%point, point], [2, n + 1])
      load%pressure = reshape([load%pressure, pressure], [2, n + 1])
      load%traction = reshape([load%traction, traction], [2, 2, n + 1])
    end associate
  end subroutine add_piece

  !> Adds a piece of an edge along which displacement is of second order. A traction q that is linear along it does the work of the
  !> forces q_A/6, (q_A + q_B)/3 and q_B/6 at its ends and middle. Each of these is a piece without length.
  pure subroutine load_three_places(piece, traction, system, state, load)
    type(piece_t), intent(in) :: piece
    real(dp), intent(in) :: traction(2, 2)   !! (xy, 2) at the ends times the length, force per unit thickness
    type(system_t), intent(inout) :: system
    type(state_t), intent(inout) :: state
    type(edge_load_t), intent(inout) :: load
    real(dp) :: force(2, 3), place(2, 3)
    integer :: k

    place = reshape([piece%ends(:, 1), 0.5_dp*(piece%ends(:, 1) + piece%ends(:, 2)), piece%ends(:, 2)], [2, 3])
    force = reshape([traction(:, 1)/6, (traction(:, 1) + traction(:, 2))/3, traction(:, 2)/6], [2, 3])
    do k = 1, 3
      call add_point(edge_end, piece%element, place(:, k), system, state)
      call add_piece(load, [1, 1]*size(system%points%kind), [0.0_dp, 0.0_dp], spread(force(:, k), 2, 2))
    end do
  end subroutine load_three_places

  !> Gives pieces without length to the elements that carry their points by now.
  pure subroutine load_carriers(system, load)
    type(system_t), intent(in) :: system
    type(edge_load_t), intent(inout) :: load
    integer, allocatable :: order(:)

    deallocate (load%first)
    call sort_into(system%points%element(load%point(1, :)), system%n_elements, load%first, order)
    load%point = load%point(:, order)
    load%traction = load%traction(:, :, order)
  end subroutine load_carriers

  !> Finds the pieces on the lines of &absorbing; their ends become points of the system. Not allocated where there are none.
  !>
  !> Errors: a line on which no edge lies; sides as of `add_free_fields`.
  subroutine absorb_on_edges(scene, system, state, absorbing, error)
    type(scene_t), intent(in) :: scene
    type(system_t), intent(inout) :: system
    type(state_t), intent(inout) :: state
    type(absorbing_edge_t), allocatable, intent(out) :: absorbing
    type(error_t), allocatable, intent(out) :: error
    type(piece_t), allocatable :: piece(:)
    logical, allocatable :: lets_in(:)
    integer, allocatable :: order(:), side(:)
    real(dp) :: D(3, 3)
    integer :: i, k

    associate (s => scene%settings)
      if (.not. (allocated(s%absorbing_lines) .or. allocated(s%absorbing_base) .or. allocated(s%absorbing_sides))) return
      allocate (piece(0), lets_in(0), side(0))
      call add_lines('absorbing.base', s%absorbing_base, .true.)
      call add_lines('absorbing.sides', s%absorbing_sides, .false.)
      call add_lines('absorbing.lines', s%absorbing_lines, .false.)
      if (allocated(error)) return
      allocate (absorbing)
      absorbing%wave = time_table_t([0.0_dp], reshape([0.0_dp, 0.0_dp], [2, 1]), .false.)
      if (allocated(scene%wave%time)) absorbing%wave = scene%wave
      call sort_into(piece%element, system%n_elements, absorbing%first, order)
      absorbing%lets_in = lets_in(order)
      allocate (absorbing%point(2, size(order)), absorbing%impedance(2, size(order)))
      allocate (absorbing%static_force(2, 2, size(order)), source=0.0_dp)
      do i = 1, size(order)
        associate (own => piece(order(i)), rock => scene%block_material(system%elements%material(piece(order(i))%element)))
          do k = 1, 2
            call add_point(absorber_end, own%element, own%ends(:, k), system, state)
            absorbing%point(k, i) = size(system%points%kind)
          end do
          D = elasticity(rock, s%plane)
          absorbing%impedance(:, i) = sqrt(rock%density)*sqrt([D(1, 1), D(3, 3)])
        end associate
      end do
    end associate
    call add_free_fields(scene, system, piece(order), side(order), absorbing, error)

  contains

    !> Adds the pieces on some lines, but for what absorbs already.
    subroutine add_lines(name, lines, comes_in)
      character(len=*), intent(in) :: name
      real(dp), allocatable, intent(in) :: lines(:)
      logical, intent(in) :: comes_in
      type(piece_t), allocatable :: more(:)
      integer :: line

      if (.not. allocated(lines) .or. allocated(error)) return
      do line = 1, size(lines)/4
        call find_pieces(scene, system, state, name, line, reshape(lines(4*line - 3:4*line), [2, 2]), more, error)
        if (allocated(error)) return
        more = pieces_beside(more, piece)
        piece = [piece, more]
        lets_in = [lets_in, spread(comes_in, 1, size(more))]
        side = [side, spread(merge(line, 0, name == 'absorbing.sides'), 1, size(more))]
      end do
    end subroutine add_lines

  end subroutine absorb_on_edges

  !> Which pieces are of blocks that no stage has removed.
  pure function is_there(system, piece)
    type(system_t), intent(in) :: system
    type(piece_t), intent(in) :: piece(:)
    logical :: is_there(size(piece))

    is_there = system%present(system%elements%block(piece%element))
  end function is_there

  !> Finds the pieces on a line of a setting, of blocks that no stage has removed. Errors: a line on which no edge lies, or none
  !> along more than a tenth of the line unless the deck allows it.
  subroutine find_pieces(scene, system, state, name, i, line, piece, error)
    type(scene_t), intent(in) :: scene
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    character(len=*), intent(in) :: name        !! of the setting
    integer, intent(in) :: i                    !! of the line in it
    real(dp), intent(in) :: line(2, 2)          !! (xy, end), length
    type(piece_t), allocatable, intent(out) :: piece(:)
    type(error_t), allocatable, intent(out) :: error

    type(gap_t) :: gap

    piece = pieces_on_line(system, state, line, scene%nearest)
    if (size(piece) == 0) then
      call fail(error, status_bad_input, given_at(scene%words, name)//': expected lines that edges of '// &
                'blocks lie on in '//name//', found none on line '//number_text(i))
      return
    end if
    gap = gap_of_line(scene, system, state, line, piece)
    if (gap%length > most_gap*gap%within .and. .not. scene%settings%allows_gaps) &
      call fail(error, status_bad_input, given_at(scene%words, name)//': expected edges of blocks all along line '// &
                number_text(i)//' of '//name//', found '//gap_text(gap)//'; &deck gaps=''allow'' takes such lines')
    piece = pack(piece, is_there(system, piece))
  end subroutine find_pieces

  !> The part of a line in the box around the blocks on which no edge lies.
  pure type(gap_t) function gap_of_line(scene, system, state, line, piece) result(gap)
    type(scene_t), intent(in) :: scene
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    real(dp), intent(in) :: line(2, 2)          !! (xy, end), length
    type(piece_t), intent(in) :: piece(:)

    gap = largest_gap(line, piece, minval(state%vertex, 2) + system%origin, maxval(state%vertex, 2) + system%origin, scene%nearest)
  end function gap_of_line

  !> A gap in words.
  function gap_text(gap) result(text)
    type(gap_t), intent(in) :: gap
    character(len=:), allocatable :: text

    text = 'none on '//short_text(gap%length)//' of its '//short_text(gap%within)//' in the model, most from ('// &
           short_text(gap%ends(1, 1))//', '//short_text(gap%ends(2, 1))//') to ('//short_text(gap%ends(1, 2))//', '// &
           short_text(gap%ends(2, 2))//')'
  end function gap_text

  !> A line for each line of &support, &boundary and &absorbing along which edges are missing by more than a thousandth.
  function gaps_of_lines(scene, system, state) result(text)
    type(scene_t), intent(in) :: scene
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    type(text_t), allocatable :: text(:)
    integer :: i

    allocate (text(0))
    associate (s => scene%settings)
      call look('support.normal', s%support_normal)
      call look('support.x', s%support_x)
      call look('support.y', s%support_y)
      call look('support.both', s%support_both)
      call look('support.moved', s%support_moved)
      call look('absorbing.base', s%absorbing_base)
      call look('absorbing.sides', s%absorbing_sides)
      call look('absorbing.lines', s%absorbing_lines)
      call look('boundary.lines', s%boundary_lines)
    end associate

  contains

    !> Looks at the lines of a setting.
    subroutine look(name, lines)
      character(len=*), intent(in) :: name
      real(dp), allocatable, intent(in) :: lines(:)
      type(gap_t) :: gap
      real(dp) :: line(2, 2)

      if (.not. allocated(lines)) return
      do i = 1, size(lines)/4
        line = reshape(lines(4*i - 3:4*i), [2, 2])
        gap = gap_of_line(scene, system, state, line, pieces_on_line(system, state, line, scene%nearest))
        if (gap%length > noticeable_gap*gap%within) &
          call append(text, 'expected edges of blocks all along line '//number_text(i)//' of '//name//', found '//gap_text(gap))
      end do
    end subroutine look

  end function gaps_of_lines

end module scree_loaded_edges
