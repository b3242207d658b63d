!> Rows of the table of settings that say where something is: cutting, bolts, supports, loads, water, edges that absorb waves, the
!> ground before the run.
module scree_place_settings
  use scree_bolt_numbers, only: bolt_numbers_t
  use scree_kinds, only: dp
  use scree_scene, only: fixed_exact, fixed_penalty, settings_t
  use scree_setting_rows, only: setting_rows_t
  use scree_setting_table, only: setting_t
  implicit none
  private
  public :: visit_places

contains

  !> The rows of all of these.
  subroutine visit_places(row, modulus, with_contact, s)
    type(setting_rows_t), intent(inout) :: row
    real(dp), intent(in) :: modulus      !! the largest of the block materials, force/length^2
    logical, intent(in) :: with_contact  !! the numbers of the deck have the stiffness of contacts
    type(settings_t), intent(inout) :: s

    call visit_points(row, modulus, with_contact, s)
    call visit_blocks(row, s)
    call visit_bolts(row, s)
    call visit_patterns(row, s)
    call visit_ground_before(row, s)
    call visit_support(row, s)
    call visit_boundary(row, s)
  end subroutine visit_places

  !> Fixed points and load points.
  subroutine visit_points(row, modulus, with_contact, s)
    type(setting_rows_t), intent(inout) :: row
    real(dp), intent(in) :: modulus      !! the largest of the block materials, force/length^2
    logical, intent(in) :: with_contact  !! the numbers of the deck have the stiffness of contacts
    type(settings_t), intent(inout) :: s

    call row%choice(setting_t('fixed_points', 'method', 'fixed points and supports: exact, or springs', &
                              choices='|exact|penalty|', default='exact; penalty with preset shi'), &
                    s%fixed, merge(fixed_penalty, fixed_exact, s%shi))
    call row%real(setting_t('fixed_points', 'stiffness', &
                            'stiffness of the springs of fixed points, per unit thickness', 'force/length', 0.0_dp, &
                            open=.true., default='100 contact.stiffness where the deck has it, else 5000 times the largest E'), &
                  s%fixed_stiffness, merge(100*s%contact_stiffness, 5000*modulus, &
                                      with_contact .or. row%given('contact.stiffness')))
    call row%reals(setting_t('loads', 'force', &
                             'fx fy of each load point, constant, per unit thickness; tables need Shi''s order of the numbers', &
                             'force'), s%load_force)
  end subroutine visit_points

  !> Settings of the cutting of lines, and of the rectangle that blocks may leave.
  subroutine visit_blocks(row, s)
    type(setting_rows_t), intent(inout) :: row
    type(settings_t), intent(inout) :: s

    call row%real(setting_t('blocks', 'least_area', &
                            'least area of a block cut from lines; a smaller block joins its neighbour', 'length^2', &
                            0.0_dp, default='0'), s%least_block_area)
    call row%reals(setting_t('scene', 'rectangle', &
                             'x1 y1 x2 y2 of the lower left and the upper right corner; a block that leaves it is removed', &
                             'length'), s%scene_rectangle)
  end subroutine visit_blocks

  !> Settings of bolts, beside those of the geometry.
  subroutine visit_bolts(row, s)
    type(setting_rows_t), intent(inout) :: row
    type(settings_t), intent(inout) :: s

    call row%reals(setting_t('bolts', 'ends', 'x1 y1 x2 y2 of each bolt, each end in a block', 'length'), s%bolt_ends)
    call visit_bolt_numbers(row, 'bolts', s%bolt_numbers)
    call row%choice(setting_t('bolts', 'earlier', &
                              'bolts of the stage before: replaced by those of this stage, or kept beside them', &
                              choices='|replaced|kept|'), s%keeps_bolts, .false.)
    call row%choice(setting_t('bolts', 'limit', 'whether all bolts yield or break at their strength', &
                              choices='|yields|breaks|'), s%bolts_break, .false.)
    call row%choice(setting_t('bolts', 'outside', 'ends of bolts that lie in no block: refused, or fixed in the ground', &
                              choices='|refused|ground|'), s%ground_holds_bolts, .false.)
  end subroutine visit_bolts

  !> Settings of rows and rings of bolts.
  subroutine visit_patterns(row, s)
    type(setting_rows_t), intent(inout) :: row
    type(settings_t), intent(inout) :: s

    call row%reals(setting_t('bolt_row', 'line', 'x1 y1 x2 y2 of the line of the heads of each row, from the first bolt on', &
                             'length'), s%row_lines)
    call row%reals(setting_t('bolt_row', 'spacing', 'distance of the heads', 'length', 0.0_dp, open=.true.), s%row_spacing)
    call row%reals(setting_t('bolt_row', 'number', 'number of bolts from end to end of the line', '1', 1.0_dp), s%row_number)
    call row%reals(setting_t('bolt_row', 'length', 'length of the bolts', 'length', 0.0_dp, open=.true.), s%row_length)
    call row%reals(setting_t('bolt_row', 'direction', 'direction from the head to the end, counter-clockwise from x', 'degree', &
                             default='to the left of the line'), s%row_direction)
    call visit_bolt_numbers(row, 'bolt_row', s%row_numbers)
    call row%reals(setting_t('bolt_ring', 'centre', 'x y of the centre of each ring', 'length'), s%ring_centres)
    call row%reals(setting_t('bolt_ring', 'radius', 'distance of the heads from the centre', 'length', 0.0_dp, open=.true.), &
                   s%ring_radius)
    call row%reals(setting_t('bolt_ring', 'from', 'angle of the first bolt, counter-clockwise from x', 'degree', &
                             default='0 for each ring'), s%ring_from)
    call row%reals(setting_t('bolt_ring', 'to', 'angle of the last bolt, counter-clockwise from x', 'degree', &
                             default='a full circle'), s%ring_to)
    call row%reals(setting_t('bolt_ring', 'spacing', 'distance of the heads along the circle', 'length', 0.0_dp, open=.true.), &
                   s%ring_spacing)
    call row%reals(setting_t('bolt_ring', 'number', 'number of bolts from the first angle to the last', '1', 1.0_dp), &
                   s%ring_number)
    call row%reals(setting_t('bolt_ring', 'length', 'length of the bolts', 'length', 0.0_dp, open=.true.), s%ring_length)
    call visit_bolt_numbers(row, 'bolt_ring', s%ring_numbers)
  end subroutine visit_patterns

  !> Settings of the stress that the ground has before the run, and of what stages excavate.
  subroutine visit_ground_before(row, s)
    type(setting_rows_t), intent(inout) :: row
    type(settings_t), intent(inout) :: s

    call row%reals(setting_t('in_situ', 'surface', &
                             'x y of points of the ground surface, with ascending x; it is level beyond its ends', &
                             'length'), s%in_situ_surface)
    call row%reals(setting_t('in_situ', 'k0', 'horizontal over vertical stress, of each block material, or of all', '1', 0.0_dp), &
                   s%k0)
    call row%real(setting_t('in_situ', 'gradient', 'increase of the vertical stress with depth', 'force/length^3', 0.0_dp, &
                            open=.true., default='the weight of the blocks, and of the highest one above them'), &
                  s%in_situ_gradient)
    call row%real(setting_t('in_situ', 'pressure', 'vertical pressure on the surface', 'force/length^2', 0.0_dp, default='0'), &
                  s%in_situ_pressure)
    call row%reals(setting_t('excavation', 'outline', &
                             'x y of the corners of polygons, each closed by its first corner; their sides are cut', 'length'), &
                   s%excavated)
    call row%text(setting_t('excavation', 'stage', 'name of the stage that removes the rock of each polygon, with commas between', &
                            default='none'), s%excavating_stages)
    call row%reals(setting_t('excavation', 'joint', 'joint material of the sides of each polygon, or of all', '1', 1.0_dp, &
                             default='1 for all'), s%excavated_joint)
  end subroutine visit_ground_before

  !> Numbers of the bolts of a group.
  subroutine visit_bolt_numbers(row, group, numbers)
    type(setting_rows_t), intent(inout) :: row
    character(len=*), intent(in) :: group
    type(bolt_numbers_t), intent(inout) :: numbers

    call row%reals(setting_t(group, 'stiffness', &
                             'axial stiffness, per unit thickness; one number for each bolt, or one for all', &
                             'force/length', 0.0_dp, open=.true.), numbers%stiffness)
    call row%reals(setting_t(group, 'pretension', &
                             'tension at the start, one number for each bolt, or one for all', &
                             'force', 0.0_dp, default='0 of each'), numbers%pretension)
    call row%reals(setting_t(group, 'strength', &
                             'largest tension, one number for each bolt, or one for all; 0: no limit', 'force', 0.0_dp, &
                             default='0 of each'), numbers%strength)
    call row%reals(setting_t(group, 'shear_stiffness', &
                             'stiffness across a grouted bolt at each joint that it crosses; 0: not grouted', &
                             'force/length', 0.0_dp, default='0 of each'), numbers%shear_stiffness)
    call row%reals(setting_t(group, 'shear_strength', 'largest force across a grouted bolt; 0: no limit', 'force', 0.0_dp, &
                             default='0 of each'), numbers%shear_strength)
  end subroutine visit_bolt_numbers

  !> Settings of supports.
  subroutine visit_support(row, s)
    type(setting_rows_t), intent(inout) :: row
    type(settings_t), intent(inout) :: s

    call row%reals(setting_t('support', 'normal', 'x1 y1 x2 y2 of lines; edges of blocks on them do not move across the line', &
                             'length'), s%support_normal)
    call row%reals(setting_t('support', 'x', &
                             'x1 y1 x2 y2 of lines; edges of blocks on them do not move along x', 'length'), s%support_x)
    call row%reals(setting_t('support', 'y', &
                             'x1 y1 x2 y2 of lines; edges of blocks on them do not move along y', 'length'), s%support_y)
    call row%reals(setting_t('support', 'both', &
                             'x1 y1 x2 y2 of lines; edges of blocks on them do not move', 'length'), s%support_both)
    call row%reals(setting_t('support', 'points', 'x y of points of blocks that do not move', 'length'), s%support_points)
    call row%reals(setting_t('support', 'points_x', 'x y of points of blocks that do not move along x', 'length'), &
                   s%support_points_x)
    call row%reals(setting_t('support', 'points_y', 'x y of points of blocks that do not move along y', 'length'), &
                   s%support_points_y)
    call row%reals(setting_t('support', 'moved', &
                             'x1 y1 x2 y2 of lines; edges of blocks on them move as prescribed, and freely across that motion', &
                             'length'), s%support_moved)
    call row%reals(setting_t('support', 'velocity', 'vx vy of each line of support.moved, or of all', 'length/time'), &
                   s%support_velocity)
    call row%reals(setting_t('support', 'table', &
                             't ux uy at ascending times of the stage: displacement of the lines of support.moved'), &
                   s%support_table)
  end subroutine visit_support

  !> Settings of loads of edges, water, and edges that absorb waves.
  subroutine visit_boundary(row, s)
    type(setting_rows_t), intent(inout) :: row
    type(settings_t), intent(inout) :: s

    call row%reals(setting_t('boundary', 'lines', 'x1 y1 x2 y2 of lines; edges of blocks on them are loaded', &
                             'length'), s%boundary_lines)
    call row%reals(setting_t('boundary', 'pressure', 'p1 p2 at the ends of each line, linear between; it follows the edges', &
                             'force/length^2', default='0 of each'), s%boundary_pressure)
    call row%reals(setting_t('boundary', 'traction', &
                             'tx1 ty1 tx2 ty2 at the ends of each line, linear between; it keeps its direction', &
                             'force/length^2', default='0 of each'), s%boundary_traction)
    call row%real(setting_t('boundary', 'ramp', &
                            'time from the start in which boundary loads and water pressure grow from 0', 'time', 0.0_dp, &
                           default='0'), s%boundary_ramp)
    call row%reals(setting_t('water', 'table', 'x y of points of the water table, with ascending x; it is level beyond its ends', &
                             'length'), s%water_table)
    call row%real(setting_t('water', 'unit_weight', 'unit weight of the water', 'force/length^3', 0.0_dp, &
                           open=.true.), s%water_weight)
    call row%reals(setting_t('absorbing', 'lines', 'x1 y1 x2 y2 of lines; edges of blocks on them absorb waves', &
                             'length'), s%absorbing_lines)
    call row%reals(setting_t('absorbing', 'sides', &
                             'x1 y1 x2 y2 of vertical lines at the sides; edges on them absorb what differs from a free field', &
                             'length'), s%absorbing_sides)
    call row%reals(setting_t('absorbing', 'base', &
                             'x1 y1 x2 y2 of lines; edges of blocks on them absorb waves and let a wave in', &
                             'length'), s%absorbing_base)
    call row%reals(setting_t('absorbing', 'table', 't vx vy at ascending times: velocity of the wave that comes in'), s%wave_table)
    call row%text(setting_t('absorbing', 'file', &
                            'file with lines t vx vy of the wave that comes in, from the folder of the analysis deck'), s%wave_file)
    call row%real(setting_t('absorbing', 'scale', 'factor of vx and vy, in units of the deck', '1'), s%wave_scale, 1.0_dp, &
                  when=allocated(s%wave_table) .or. allocated(s%wave_file))
  end subroutine visit_boundary

end module scree_place_settings
