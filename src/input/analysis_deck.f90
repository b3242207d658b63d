!> Shi's analysis deck (the input of his df), in its two orders, then the named groups.
!>
!> The short order has 6 + 13 nb + 3 nj numbers; Shi's has the contact stiffness g0 and a table for each fixed and load
!> point as well, so it always has more. Layout, number by number, in doc/decks.md.
module scree_analysis_deck
  use scree_deck_options, only: begin_thing
  use scree_deck_text, only: count_numbers, deck_t, expect, expect_end, next_count, next_index, next_real, next_reals
  use scree_errors, only: error_t
  use scree_kinds, only: dp, i8
  use scree_scene, only: block_material_t, dialect_auto, dialect_short, joint_material_t, scene_t, time_table_t
  use scree_text, only: number_text
  implicit none
  private
  public :: read_analysis_deck

  integer, parameter :: per_block_material = 13, per_joint_material = 3

contains

  !> Reads the numbers of an analysis deck into the scene, in the order that its settings say.
  !>
  !> Errors: what is not as the layout says, with its line; a count of numbers that fits neither order.
  subroutine read_analysis_deck(deck, n_fixed, n_loads, scene, error)
    type(deck_t), intent(inout) :: deck
    integer, intent(in) :: n_fixed, n_loads !! fixed and load points, after the lines were cut
    type(scene_t), intent(inout) :: scene
    type(error_t), allocatable, intent(out) :: error
    integer :: n_block, n_joint
    integer(i8) :: short
    logical :: in_short_order

    call begin_thing(deck%options, 'deck')
    call next_real(deck, 'the share of velocity handed on (k01; 0 static, 1 dynamic)', scene%carried, error, &
                   least=0.0_dp, most=1.0_dp, name='k01')
    if (allocated(error)) return
    call next_index(deck, 'the number of steps (n5)', scene%n_steps, error, name='n5')
    if (allocated(error)) return
    call next_count(deck, 'block materials (nb)', per_block_material, n_block, error, least=1)
    if (allocated(error)) return
    call next_count(deck, 'joint materials (nj)', per_joint_material, n_joint, error)
    if (allocated(error)) return
    short = 6 + int(per_block_material, i8)*n_block + int(per_joint_material, i8)*n_joint
    in_short_order = is_short(scene%settings%dialect, count_numbers(deck) == short)
    if (scene%settings%dialect == dialect_auto .and. count_numbers(deck) < short) then
      call expect(deck, number_text(int(short))//' numbers (6 + 13 nb + 3 nj), or more in Shi''s order', &
                  number_text(count_numbers(deck)), error)
      return
    end if

    call next_real(deck, 'the largest displacement of a step over half the model size (g2)', scene%displacement_ratio, error, &
                   least=0.0_dp, name='g2')
    if (allocated(error)) return
    call next_real(deck, 'the step size (g1)', scene%step_size, error, above=0.0_dp, name='g1')
    if (allocated(error)) return
    allocate (scene%fixed_table(n_fixed), scene%load_table(n_loads))
    if (.not. in_short_order) then
      call next_real(deck, 'the stiffness of contact (g0; 0: the program chooses)', scene%contact_stiffness, error, &
                     least=0.0_dp, name='g0')
      if (allocated(error)) return
      call read_tables(deck, short, n_fixed, n_loads, scene, error)
      if (allocated(error)) return
    end if
    call read_block_materials(deck, n_block, scene%block_material, error)
    if (allocated(error)) return
    call read_joint_materials(deck, n_joint, scene%joint_material, error)
    if (allocated(error)) return
    call expect_end(deck, error)
  end subroutine read_analysis_deck

  !> Whether the numbers are in the short order: as the deck says, else by their count.
  pure logical function is_short(dialect, count_is_short)
    integer, intent(in) :: dialect
    logical, intent(in) :: count_is_short

    is_short = dialect == dialect_short .or. (dialect == dialect_auto .and. count_is_short)
  end function is_short

  !> Reads the counts k5 and then the tables of all fixed and load points.
  subroutine read_tables(deck, short, n_fixed, n_loads, scene, error)
    type(deck_t), intent(inout) :: deck
    integer(i8), intent(in) :: short
    integer, intent(in) :: n_fixed, n_loads
    type(scene_t), intent(inout) :: scene
    type(error_t), allocatable, intent(out) :: error
    integer :: k5(n_fixed + n_loads), i
    integer(i8) :: whole

    do i = 1, size(k5)
      call next_count(deck, 'times of the table of '//point_name(i)//' (k5)', 3, k5(i), error)
      if (allocated(error)) then
        if (scene%settings%dialect == dialect_auto) error%message = error%message//', in Shi''s order; in the short order: '// &
          'expected '//number_text(int(short))//' numbers, found '//number_text(count_numbers(deck))
        return
      end if
    end do
    whole = short + 1 + size(k5) + 3*sum(int(k5, i8))
    if (whole /= count_numbers(deck)) then
      call expect(deck, number_text(int(short))//' numbers in the short order or '//number_text(int(min(whole, 2000000000_i8)))// &
                  ' in Shi''s (with tables for '//number_text(n_fixed)//' fixed and '//number_text(n_loads)// &
                  ' load points; &deck dialect= says which)', number_text(count_numbers(deck)), error)
      return
    end if
    do i = 1, size(k5)
      if (k5(i) == 0) cycle
      if (i <= n_fixed) then
        call begin_thing(deck%options, 'fixed_point', i)
        call read_table(point_name(i), 'move', k5(i), scene%fixed_table(i))
      else
        call begin_thing(deck%options, 'load_point', i - n_fixed)
        call read_table(point_name(i), 'force', k5(i), scene%load_table(i - n_fixed))
      end if
      if (allocated(error)) return
    end do

  contains

    !> A point as a person calls it.
    function point_name(i)
      integer, intent(in) :: i
      character(len=:), allocatable :: point_name

      if (i <= n_fixed) then
        point_name = 'fixed point '//number_text(i)
      else
        point_name = 'load point '//number_text(i - n_fixed)
      end if
    end function point_name

    !> Reads t x y, by the names time(k), move_x(k), move_y(k), or force_x(k), force_y(k).
    subroutine read_table(what, name, n, table)
      character(len=*), intent(in) :: what, name
      integer, intent(in) :: n
      type(time_table_t), intent(out) :: table
      character(len=:), allocatable :: at
      integer :: k

      allocate (table%time(n), table%value(2, n))
      do k = 1, n
        at = '('//number_text(k)//')'
        call next_real(deck, 'time '//number_text(k)//' of '//what, table%time(k), error, name='time'//at)
        if (allocated(error)) return
        if (k > 1) then
          if (table%time(k) <= table%time(k - 1)) then
            call expect(deck, 'times that increase in the table of '//what, 'one that does not', error)
            return
          end if
        end if
        call next_reals(deck, 'the values of '//what//' at time '//number_text(k), table%value(:, k), error, &
                        names=[name//'_x'//at, name//'_y'//at])
        if (allocated(error)) return
      end do
    end subroutine read_table

  end subroutine read_tables

  !> Reads ma we E nu, stress, its gradient, velocity.
  subroutine read_block_materials(deck, n, materials, error)
    type(deck_t), intent(inout) :: deck
    integer, intent(in) :: n
    type(block_material_t), allocatable, intent(out) :: materials(:)
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: of
    integer :: i

    allocate (materials(n))
    do i = 1, n
      of = ' of block material '//number_text(i)
      call begin_thing(deck%options, 'material', i)
      associate (material => materials(i))
        call next_real(deck, 'the density (ma)'//of, material%density, error, least=0.0_dp, name='ma|density')
        if (allocated(error)) return
        call next_real(deck, 'the unit weight (we)'//of, material%unit_weight, error, name='we|unit_weight')
        if (allocated(error)) return
        call next_real(deck, 'the modulus E'//of, material%young, error, above=0.0_dp, name='E|young')
        if (allocated(error)) return
        call next_real(deck, 'Poisson''s ratio'//of, material%poisson, error, above=-1.0_dp, below=0.5_dp, &
                       name='nu|poisson')
        if (allocated(error)) return
        call next_reals(deck, 'the stress s11 s22 s12'//of, material%stress, error, names=['s11', 's22', 's12'])
        if (allocated(error)) return
        call next_reals(deck, 'the stress gradient t11 t22 t12'//of, material%stress_gradient, error, &
                        names=['t11', 't22', 't12'])
        if (allocated(error)) return
        call next_reals(deck, 'the velocity vx vy vr'//of, material%velocity, error, names=['vx', 'vy', 'vr'])
        if (allocated(error)) return
      end associate
    end do
  end subroutine read_block_materials

  !> Reads friction angle, cohesion, tensile strength.
  subroutine read_joint_materials(deck, n, materials, error)
    type(deck_t), intent(inout) :: deck
    integer, intent(in) :: n
    type(joint_material_t), allocatable, intent(out) :: materials(:)
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: of
    integer :: i

    allocate (materials(n))
    do i = 1, n
      of = ' of joint material '//number_text(i)
      call begin_thing(deck%options, 'joint', i, also='material')
      call next_real(deck, 'the friction angle'//of, materials(i)%friction_angle, error, least=0.0_dp, below=90.0_dp, &
                     name='phi|friction_angle')
      if (allocated(error)) return
      call next_real(deck, 'the cohesion'//of, materials(i)%cohesion, error, least=0.0_dp, name='c|cohesion')
      if (allocated(error)) return
      call next_real(deck, 'the tensile strength'//of, materials(i)%tensile_strength, error, least=0.0_dp, &
                     name='T|tensile_strength')
      if (allocated(error)) return
    end do
  end subroutine read_joint_materials

end module scree_analysis_deck
