!> Shi's analysis deck (the input of his df), in its two orders, then the named groups.
!>
!> The short order has 6 + 13 nb + 3 nj numbers; Shi's has the contact stiffness g0 and a table for each fixed and load
!> point as well, so it always has more. A deck with named groups is in the short order unless it names the other, because its
!> writer knows of groups, and one number too many would shift all that follow it. Layout, number by number, in doc/decks.md.
module scree_analysis_deck
  use scree_deck_options, only: begin_thing
  use scree_deck_rows, only: add_row, begin_rows, blame_line, deck_rows_t, fits_lines
  use scree_deck_text, only: count_numbers, deck_t, expect, expect_end, next_count, next_index, next_real, next_reals, &
                             word_after, word_is_whole
  use scree_errors, only: error_t
  use scree_kinds, only: dp, i8
  use scree_scene, only: block_material_t, dialect_auto, dialect_shi, dialect_short, joint_material_t, scene_t, time_table_t
  use scree_text, only: number_text
  implicit none
  private
  public :: read_analysis_deck

  integer, parameter :: per_block_material = 13, per_joint_material = 3
  character(len=*), parameter :: to_name_shi = '; Shi''s order needs &deck dialect=''shi'' / in a deck with groups'

  !> How much there is of everything in a deck.
  type :: counts_t
    integer :: block = 0, joint = 0         !! materials
    integer :: fixed = 0, loads = 0         !! points
    integer :: short = 0                    !! numbers of the short order
    integer :: shi = 0                      !! numbers of Shi's order as the deck counts its tables, 0: it does not
    integer, allocatable :: times(:)        !! (fixed + loads) of each table in Shi's order
  end type counts_t

contains

  !> Reads the numbers of an analysis deck into the scene, in the order that its settings say.
  !>
  !> Errors: anything that does not follow the layout, with its line; a count of numbers that fits neither order.
  subroutine read_analysis_deck(deck, n_fixed, n_loads, scene, error)
    type(deck_t), intent(inout) :: deck
    integer, intent(in) :: n_fixed, n_loads !! fixed and load points, after the lines were cut
    type(scene_t), intent(inout) :: scene
    type(error_t), allocatable, intent(out) :: error
    type(counts_t) :: n

    n%fixed = n_fixed
    n%loads = n_loads
    call begin_thing(deck%options, 'deck')
    call next_real(deck, 'the fraction of the velocity passed on (k01; 0 static, 1 dynamic)', scene%carried, error, &
                   least=0.0_dp, most=1.0_dp, name='k01')
    if (allocated(error)) return
    call next_index(deck, 'the number of steps (n5)', scene%n_steps, error, name='n5')
    if (allocated(error)) return
    call next_count(deck, 'block materials (nb)', per_block_material, n%block, error, least=1)
    if (allocated(error)) return
    call next_count(deck, 'joint materials (nj)', per_joint_material, n%joint, error)
    if (allocated(error)) return
    n%short = 6 + per_block_material*n%block + per_joint_material*n%joint
    call count_shi(deck, n)
    call choose_order(deck, n, scene%settings%dialect, scene%in_shi_order, error)
    if (allocated(error)) return

    call next_real(deck, 'the largest displacement of a step over half the model size (g2)', scene%displacement_ratio, error, &
                   least=0.0_dp, name='g2')
    if (allocated(error)) return
    call next_real(deck, 'the step size (g1)', scene%step_size, error, above=0.0_dp, name='g1')
    if (allocated(error)) return
    allocate (scene%fixed_table(n_fixed), scene%load_table(n_loads))
    if (scene%in_shi_order) then
      call next_real(deck, 'the stiffness of contact (g0; 0: the program chooses)', scene%contact_stiffness, error, &
                     least=0.0_dp, name='g0')
      if (allocated(error)) return
      call read_tables(deck, n_fixed, n_loads, scene, error)
      if (allocated(error)) return
    end if
    call read_block_materials(deck, n%block, scene%block_material, error)
    if (allocated(error)) return
    call read_joint_materials(deck, n%joint, scene%joint_material, error)
    if (allocated(error)) return
    call expect_end(deck, error)
  end subroutine read_analysis_deck

  !> Counts the numbers of Shi's order by the counts k5 of its tables, where these are counts.
  pure subroutine count_shi(deck, n)
    type(deck_t), intent(in) :: deck         !! nb and nj are read
    type(counts_t), intent(inout) :: n
    integer, parameter :: before = 3         !! numbers from nj to the first k5: g2, g1, g0
    integer, parameter :: most = 2           !! numbers that may be missing are as many as there are: another number is no count
    character(len=:), allocatable :: word
    integer(i8) :: whole
    integer :: i

    allocate (n%times(n%fixed + n%loads), source=0)
    whole = n%short + 1_i8 + size(n%times)
    do i = 1, size(n%times)
      word = word_after(deck, before + i)
      if (.not. word_is_whole(word)) return
      read (word, *) n%times(i)
      whole = whole + 3_i8*n%times(i)
      if (n%times(i) < 0 .or. whole > int(most, i8)*count_numbers(deck)) return
    end do
    n%shi = int(whole)
  end subroutine count_shi

  !> Finds the order of the numbers: the one that the deck names, else by its groups and the count of its numbers.
  !>
  !> Errors: a count that does not fit the order, at the line that alone explains the count where there is one; a deck with groups
  !> in Shi's order that does not name it.
  pure subroutine choose_order(deck, n, dialect, in_shi_order, error)
    type(deck_t), intent(in) :: deck
    type(counts_t), intent(in) :: n
    integer, intent(in) :: dialect
    logical, intent(out) :: in_shi_order
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: counted, orders
    logical :: fits_shi, fits_short, may_be_shi
    integer :: found

    found = count_numbers(deck)
    fits_short = found == n%short .and. dialect /= dialect_shi
    fits_shi = found == n%shi .and. dialect /= dialect_short
    may_be_shi = dialect == dialect_shi .or. (dialect == dialect_auto .and. deck%groups_line == 0)
    in_shi_order = may_be_shi .and. fits_shi
    if (fits_short) return

    orders = number_text(n%short)//' in the short order (6 + 13 nb + 3 nj)'
    if (dialect == dialect_shi) orders = number_text(shi_or_least(n))//' in Shi''s order'
    counted = '; the deck has '//number_text(found)//' numbers, expected '//orders
    if (fits_shi .and. .not. may_be_shi) counted = counted//to_name_shi
    if (in_shi_order) then
      if (dialect == dialect_shi .or. size(n%times) > 0) return
      if (fits_lines(deck, rows_of(n, .true.))) return
    end if
    if (dialect /= dialect_shi) call blame_line(deck, rows_of(n, .false.), counted, error)
    if (allocated(error) .or. in_shi_order) return
    if (may_be_shi .and. n%shi > 0) call blame_line(deck, rows_of(n, .true.), counted, error)
    if (allocated(error)) return
    if (dialect == dialect_auto .and. may_be_shi) orders = orders//', or '//number_text(shi_or_least(n))//' in Shi''s order'
    if (may_be_shi) orders = orders//' with tables for '//number_text(n%fixed)//' fixed and '//number_text(n%loads)//' load points'
    counted = number_text(found)
    if (fits_shi) counted = counted//to_name_shi
    call expect(deck, 'as many numbers as '//orders, counted, error)
  end subroutine choose_order

  !> Numbers of Shi's order, or the least of them where its tables are not counted.
  pure integer function shi_or_least(n)
    type(counts_t), intent(in) :: n

    shi_or_least = n%shi
    if (n%shi == 0) shi_or_least = n%short + 1 + size(n%times)
  end function shi_or_least

  !> The rows of a deck in one of its orders.
  pure type(deck_rows_t) function rows_of(n, in_shi_order) result(rows)
    type(counts_t), intent(in) :: n
    logical, intent(in) :: in_shi_order
    character(len=*), parameter :: head(*) = [character(len=3) :: 'k01', 'n5', 'nb', 'nj', 'g2', 'g1', 'g0']
    character(len=:), allocatable :: of
    integer :: i, k

    call begin_rows(merge(n%shi, n%short, in_shi_order), rows)
    call add_row(head(:merge(7, 6, in_shi_order)), '', rows, is_loose=.true.)
    if (in_shi_order) then
      do i = 1, size(n%times)
        call add_row(['k5'], 'the points', rows)
      end do
      do i = 1, size(n%times)
        of = 'fixed point '//number_text(i)
        if (i > n%fixed) of = 'load point '//number_text(i - n%fixed)
        do k = 1, n%times(i)
          call add_row(['t', 'x', 'y'], of, rows)
        end do
      end do
    end if
    do i = 1, n%block
      of = 'block material '//number_text(i)
      call add_row([character(len=2) :: 'ma', 'we', 'E', 'nu'], of, rows)
      call add_row(['s11', 's22', 's12'], of, rows)
      call add_row(['t11', 't22', 't12'], of, rows)
      call add_row(['vx', 'vy', 'vr'], of, rows)
    end do
    do i = 1, n%joint
      call add_row([character(len=3) :: 'phi', 'c', 'T'], 'joint material '//number_text(i), rows)
    end do
  end function rows_of

  !> Reads the counts k5 and then the tables of all fixed and load points.
  subroutine read_tables(deck, n_fixed, n_loads, scene, error)
    type(deck_t), intent(inout) :: deck
    integer, intent(in) :: n_fixed, n_loads
    type(scene_t), intent(inout) :: scene
    type(error_t), allocatable, intent(out) :: error
    integer :: k5(n_fixed + n_loads), i

    do i = 1, size(k5)
      call next_count(deck, 'times of the table of '//point_name(i)//' (k5)', 3, k5(i), error)
      if (allocated(error)) return
    end do
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
