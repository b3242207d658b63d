!> Bolts as decks give them: rows of a geometry deck (Shi's dc), records of a block file, lists of the group &bolts, patterns of
!> &bolt_row and &bolt_ring.
!>
!> Each is `x1 y1 x2 y2 e0 t0 f0`: ends, stiffness, strength, pretension; a block file has the blocks `n1 n2` of the ends before e0.
module scree_bolt_records
  use scree_bolt_numbers, only: bolt_numbers_t
  use scree_bolt_patterns, only: bolts_of_rings, bolts_of_rows, one_for_each
  use scree_deck_options, only: begin_thing
  use scree_deck_text, only: deck_t, expect, next_real, next_reals
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_kinds, only: dp
  use scree_scene, only: bolt_record_t, scene_t
  use scree_setting_table, only: given_at
  use scree_text, only: number_text, real_text
  implicit none
  private
  public :: bolt_text, numbers_of_bolt, read_bolts, take_bolts

  integer, parameter :: numbers_of_bolt = 9 !! in a block file

contains

  !> Reads bolts. Errors: numbers that are no bolt, with their line.
  subroutine read_bolts(deck, n, n_blocks, bolts, error)
    type(deck_t), intent(inout) :: deck
    integer, intent(in) :: n
    integer, intent(in) :: n_blocks       !! of a block file; below 0: the deck names none
    type(bolt_record_t), allocatable, intent(out) :: bolts(:)
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: number(3)
    character(len=:), allocatable :: name
    integer :: i, k

    allocate (bolts(n))
    do i = 1, n
      name = 'bolt '//number_text(i)
      call begin_thing(deck%options, 'bolt', i)
      associate (bolt => bolts(i))
        call next_reals(deck, 'the first end x1 y1 of '//name, bolt%ends(:, 1), error, names=['x1', 'y1'])
        if (allocated(error)) return
        call next_reals(deck, 'the second end x2 y2 of '//name, bolt%ends(:, 2), error, names=['x2', 'y2'])
        if (allocated(error)) return
        do k = 1, merge(2, 0, n_blocks >= 0)
          call next_real(deck, 'the block of an end of '//name, number(k), error, least=0.0_dp, &
                         most=real(n_blocks, dp))
          if (allocated(error)) return
          if (nint(number(k)) > 0) bolt%block(k) = nint(number(k)) ! 0: in none that the cutter found
          if (abs(number(k) - anint(number(k))) > 0) then
            call expect(deck, 'the number of a block', real_text(number(k)), error)
            return
          end if
        end do
        call next_reals(deck, 'stiffness, strength, pretension e0 t0 f0 of '//name, number, error, &
                        names=['e0|stiffness ', 't0|strength  ', 'f0|pretension'])
        if (allocated(error)) return
        bolt%stiffness = number(1)
        bolt%strength = number(2)
        bolt%pretension = number(3)
        bolt%source = deck%name//':'//number_text(deck%line(deck%at))
        call check_bolt(bolt, i, error)
        if (allocated(error)) return
      end associate
    end do
  end subroutine read_bolts

  !> Adds the bolts of &bolts, and of the rows and rings of &bolt_row and &bolt_ring, to those of the geometry.
  !>
  !> Errors: lists of different lengths, numbers that make no bolt.
  subroutine take_bolts(scene, error)
    type(scene_t), intent(inout) :: scene
    type(error_t), allocatable, intent(out) :: error
    real(dp), allocatable :: ends(:, :, :)
    integer, allocatable :: of(:)
    integer :: i

    if (.not. allocated(scene%bolts)) allocate (scene%bolts(0))
    associate (s => scene%settings)
      if (allocated(s%bolt_ends)) then
        associate (n => size(s%bolt_ends)/4)
          if (n == 0 .or. size(s%bolt_ends) /= 4*n) then
            call fail(error, status_bad_input, given_at(scene%words, 'bolts.ends')//': expected four numbers x1 y1 x2 y2 for '// &
                      'each bolt in bolts.ends, found '//number_text(size(s%bolt_ends)))
            return
          end if
          call add_bolts(scene, 'bolts', 'ends', 'bolt', reshape(s%bolt_ends, [2, 2, n]), [(i, i=1, n)], s%bolt_numbers, error)
        end associate
        if (allocated(error)) return
      end if
      call bolts_of_rows(scene, ends, of, error)
      if (allocated(error)) return
      call add_bolts(scene, 'bolt_row', 'line', 'row', ends, of, s%row_numbers, error)
      if (allocated(error)) return
      call bolts_of_rings(scene, ends, of, error)
      if (allocated(error)) return
      call add_bolts(scene, 'bolt_ring', 'centre', 'ring', ends, of, s%ring_numbers, error)
    end associate
  end subroutine take_bolts

  !> Adds the bolts of a group with their numbers. Errors: those of `one_for_each`, no stiffness, numbers that make no bolt.
  subroutine add_bolts(scene, group, place, thing, ends, of, numbers, error)
    type(scene_t), intent(inout) :: scene
    character(len=*), intent(in) :: group
    character(len=*), intent(in) :: place               !! name of the group that has the places
    character(len=*), intent(in) :: thing               !! that the group has numbers for: bolt, row, ring
    real(dp), intent(in) :: ends(:, :, :)               !! (xy, end, n) length
    integer, intent(in) :: of(:)                        !! (n) thing of each bolt
    type(bolt_numbers_t), intent(in) :: numbers
    type(error_t), allocatable, intent(out) :: error
    type(bolt_record_t) :: bolts(size(of))
    real(dp), allocatable, dimension(:) :: pretension, shear_stiffness, shear_strength, stiffness, strength
    integer :: i

    if (size(of) == 0) return
    if (.not. allocated(numbers%stiffness)) then
      call fail(error, status_bad_input, given_at(scene%words, group//'.'//place)//': expected '//group//'.stiffness with '// &
                group//'.'//place//', found none')
      return
    end if
    call spread_out(numbers%stiffness, 'stiffness', stiffness)
    if (.not. allocated(error)) call spread_out(numbers%strength, 'strength', strength)
    if (.not. allocated(error)) call spread_out(numbers%pretension, 'pretension', pretension)
    if (.not. allocated(error)) call spread_out(numbers%shear_stiffness, 'shear_stiffness', shear_stiffness)
    if (.not. allocated(error)) call spread_out(numbers%shear_strength, 'shear_strength', shear_strength)
    if (allocated(error)) return
    do i = 1, size(of)
      bolts(i)%ends = ends(:, :, i)
      bolts(i)%stiffness = stiffness(of(i))
      bolts(i)%strength = strength(of(i))
      bolts(i)%pretension = pretension(of(i))
      bolts(i)%shear_stiffness = shear_stiffness(of(i))
      bolts(i)%shear_strength = shear_strength(of(i))
      bolts(i)%ground_holds = scene%settings%ground_holds_bolts
      bolts(i)%source = given_at(scene%words, group//'.'//place)
      call check_bolt(bolts(i), i, error)
      if (allocated(error)) return
    end do
    scene%bolts = [scene%bolts, bolts]

  contains

    !> A number for each thing.
    subroutine spread_out(given, name, values)
      real(dp), allocatable, intent(in) :: given(:)
      character(len=*), intent(in) :: name
      real(dp), allocatable, intent(out) :: values(:)

      call one_for_each(scene, group//'.'//name, given, maxval(of), thing//' of '//group//'.'//place, values, error)
    end subroutine spread_out

  end subroutine add_bolts

  !> Error where numbers are no bolt.
  subroutine check_bolt(bolt, i, error)
    type(bolt_record_t), intent(in) :: bolt
    integer, intent(in) :: i                !! its number where it stands
    type(error_t), allocatable, intent(out) :: error

    if (.not. bolt%stiffness > 0) then
      call wrong('a stiffness above 0', real_text(bolt%stiffness))
    else if (bolt%strength < 0) then
      call wrong('a strength from 0 (none)', real_text(bolt%strength))
    else if (bolt%pretension < 0) then
      call wrong('a pretension from 0', real_text(bolt%pretension))
    else if (bolt%strength > 0 .and. bolt%pretension > bolt%strength) then
      call wrong('a pretension up to the strength, '//real_text(bolt%strength), real_text(bolt%pretension))
    else if (bolt%shear_strength > 0 .and. .not. bolt%shear_stiffness > 0) then
      call wrong('no shear strength without a shear stiffness', real_text(bolt%shear_strength))
    else if (.not. norm2(bolt%ends(:, 2) - bolt%ends(:, 1)) > 0) then
      call wrong('two ends', 'one place')
    end if

  contains

    !> The error.
    subroutine wrong(expected, found)
      character(len=*), intent(in) :: expected, found

      call fail(error, status_bad_input, bolt%source//': expected '//expected//' of bolt '//number_text(i)//', found '//found)
    end subroutine wrong

  end subroutine check_bolt

  !> Stiffness, strength and pretension, as they read back.
  pure function bolt_text(bolt) result(text)
    type(bolt_record_t), intent(in) :: bolt
    character(len=:), allocatable :: text

    text = real_text(bolt%stiffness)//' '//real_text(bolt%strength)//' '//real_text(bolt%pretension)
  end function bolt_text

end module scree_bolt_records
