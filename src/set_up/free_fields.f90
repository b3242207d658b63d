!> The free fields beside absorbing edges at the sides: a column for each side, of the layers that its edges make.
module scree_free_fields
  use scree_absorbing_edge, only: absorbing_edge_t
  use scree_edges_on_lines, only: piece_t
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_free_field, only: column_t, move_column
  use scree_kinds, only: dp
  use scree_material, only: elasticity
  use scree_scene, only: scene_t, time_table_t
  use scree_setting_table, only: given_at
  use scree_sorting, only: sort_by
  use scree_system, only: system_t
  use scree_text, only: number_text
  implicit none
  private
  public :: add_free_fields

  !> Steps of a column in a step of the run.
  integer, parameter :: finer = 2
  !> Cells of a column for each edge, at least, and the way of a shear wave in a step of the column over the size of a cell.
  integer, parameter :: least_cells = 2
  !> Numbers that the motions of all columns may have.
  real(dp), parameter :: most_numbers = 2e8_dp

contains

  !> Moves a column beside each line of `absorbing.sides` through the stage, and notes its motion at the ends of the edges.
  !>
  !> Errors: a side that is not vertical or has gaps, one whose foot is not on a level base; a run that is too long.
  subroutine add_free_fields(scene, system, piece, side, absorbing, error)
    type(scene_t), intent(in) :: scene
    type(system_t), intent(in) :: system
    type(piece_t), intent(in) :: piece(:)          !! in the order of the absorbing edges
    integer, intent(in) :: side(:)                 !! line of `absorbing.sides` that each lies on, 0: of others
    type(absorbing_edge_t), intent(inout) :: absorbing
    type(error_t), allocatable, intent(out) :: error
    type(column_t) :: column
    type(time_table_t), allocatable :: velocity(:), displacement(:)
    integer, allocatable :: ends(:), list(:)
    real(dp) :: D(3, 3), dt
    integer :: i, k, line, n_steps

    allocate (absorbing%field(2, size(piece)), source=0)
    allocate (absorbing%modulus(2, size(piece)), source=0.0_dp)
    allocate (absorbing%field_velocity(0), absorbing%field_displacement(0))
    if (.not. any(side > 0)) return
    absorbing%stiffness_damping = 0.0_dp
    associate (s => scene%settings, rates => scene%settings%rayleigh())
      absorbing%stiffness_damping = rates(2)
      dt = s%step_size/finer
      n_steps = ceiling(min(s%end_time/dt, real(finer, dp)*s%most_steps, most_numbers)) + finer
    end associate
    if (12.0_dp*count(side > 0)*n_steps > most_numbers) then
      call fail(error, status_bad_input, given_at(scene%words, 'absorbing.sides')//': expected a run whose free fields fit the '// &
                'memory, found '//number_text(n_steps)//' steps of them; try a larger step.size or an earlier step.end_time')
      return
    end if
    do line = 1, maxval(side)
      list = pack([(i, i=1, size(side))], side == line)
      if (size(list) == 0) cycle
      list = list(order_of_height(piece(list)))
      call make_column(scene, system, piece, list, line, absorbing, dt, column, ends, error)
      if (allocated(error)) return
      allocate (velocity(size(ends)), displacement(size(ends)))
      call move_column(column, dt, n_steps, ends, velocity, displacement)
      do k = 1, size(list)
        i = list(k)
        D = elasticity(scene%block_material(system%elements%material(piece(i)%element)), scene%settings%plane)
        absorbing%modulus(:, i) = [D(1, 2), D(3, 3)]
        absorbing%field(:, i) = size(absorbing%field_velocity) &
                                + merge([k, k + 1], [k + 1, k], piece(i)%ends(2, 2) > piece(i)%ends(2, 1))
      end do
      absorbing%field_velocity = [absorbing%field_velocity, velocity]
      absorbing%field_displacement = [absorbing%field_displacement, displacement]
      deallocate (velocity, displacement)
    end do
  end subroutine add_free_fields

  !> Order of pieces by the height of their middles.
  pure function order_of_height(piece) result(order)
    type(piece_t), intent(in) :: piece(:)
    integer :: order(size(piece)), i
    real(dp) :: height(size(piece))

    order = [(i, i=1, size(piece))]
    height = [(sum(piece(i)%ends(2, :)), i=1, size(piece))]
    call sort_by(height, order)
  end function order_of_height

  !> Makes the column of a side, with nodes at the ends of its edges and between them.
  subroutine make_column(scene, system, piece, list, line, absorbing, dt, column, ends, error)
    type(scene_t), intent(in) :: scene
    type(system_t), intent(in) :: system
    type(piece_t), intent(in) :: piece(:)
    integer, intent(in) :: list(:)                 !! pieces of the side, from its foot to its top
    integer, intent(in) :: line                    !! of `absorbing.sides`
    type(absorbing_edge_t), intent(in) :: absorbing
    real(dp), intent(in) :: dt                     !! time
    type(column_t), intent(out) :: column
    integer, allocatable, intent(out) :: ends(:)   !! nodes at the ends of the edges
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: place
    real(dp) :: D(3, 3), foot(2), from, h, to
    integer :: cells, i, k

    place = given_at(scene%words, 'absorbing.sides')//': expected '
    foot = piece(list(1))%ends(:, minloc(piece(list(1))%ends(2, :), 1))
    column%rayleigh = scene%settings%rayleigh()
    column%y = [foot(2)]
    allocate (column%density(0), column%modulus(2, 0))
    ends = [1]
    do k = 1, size(list)
      associate (own => piece(list(k)), rock => scene%block_material(system%elements%material(piece(list(k))%element)))
        from = minval(own%ends(2, :))
        to = maxval(own%ends(2, :))
        if (any(abs(own%ends(1, :) - foot(1)) > scene%nearest)) then
          call fail(error, status_bad_input, place//'vertical lines in absorbing.sides, found line '//number_text(line)// &
                    ' that leans')
        else if (abs(from - column%y(size(column%y))) > scene%nearest) then
          call fail(error, status_bad_input, place//'edges one upon another on line '//number_text(line)// &
                    ' of absorbing.sides, found a gap or an overlap')
        end if
        if (allocated(error)) return
        D = elasticity(rock, scene%settings%plane)
        cells = max(least_cells, ceiling((to - from)/(dt*sqrt(D(3, 3)/rock%density))))
        h = (to - column%y(size(column%y)))/cells
        column%y = [column%y, (to - h*(cells - i), i=1, cells)]
        column%density = [column%density, spread(rock%density, 1, cells)]
        column%modulus = reshape([column%modulus, spread([D(3, 3), D(1, 1)], 2, cells)], [2, size(column%density)])
        ends = [ends, size(column%y)]
      end associate
    end do
    if (allocated(scene%ground%time)) column%ground = scene%ground
    do i = 1, size(piece)
      if (any(list == i) .or. .not. any(hypot(piece(i)%ends(1, :) - foot(1), piece(i)%ends(2, :) - foot(2)) <= scene%nearest)) cycle
      if (abs(piece(i)%ends(2, 2) - piece(i)%ends(2, 1)) > scene%nearest) cycle
      column%impedance = [absorbing%impedance(2, i), absorbing%impedance(1, i)]
      if (absorbing%lets_in(i)) column%wave = scene%wave
    end do
    if (allocated(scene%wave%time) .and. .not. allocated(column%wave%time)) &
      call fail(error, status_bad_input, place//'a level line of absorbing.base at the foot of line '//number_text(line)// &
                ' of absorbing.sides, where the wave comes in, found none')
  end subroutine make_column

end module scree_free_fields
