!> A record of motion, t x y at ascending times, from a file or from the deck: acceleration of the ground, or velocity of a wave.
!>
!> Files of the PEER strong motion databases hold one component of the acceleration each.
module scree_motion_record
  use scree_deck_text, only: deck_t, expect, find_words, in_quotes, next_index, next_real, next_reals, numbers_left, read_deck, &
                             read_text
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_kinds, only: dp
  use scree_scene, only: time_table_t
  use scree_text, only: in_lower_case, number_text, real_text
  implicit none
  private
  public :: is_peer_file, read_peer_files, read_record_file, take_record

  integer, parameter :: peer_head = 4 !! lines of a PEER record before its accelerations

contains

  !> Reads a file whose lines are a time and two components.
  !>
  !> Errors: a line of other than three numbers, times that do not increase, fewer than two lines.
  subroutine read_record_file(name, numbers, record, error)
    character(len=*), intent(in) :: name
    character(len=*), intent(in) :: numbers !! of a line, as 't ax ay'
    type(time_table_t), intent(out) :: record
    type(error_t), allocatable, intent(out) :: error
    type(deck_t) :: deck
    real(dp), allocatable :: row(:, :)
    integer :: n

    call read_deck(name, deck, error, kind='record')
    if (allocated(error)) return
    call refuse_groups(deck, 'lines '//numbers, error)
    if (allocated(error)) return
    allocate (row(3, (numbers_left(deck) + 2)/3))
    n = 0
    do while (numbers_left(deck) > 0)
      n = n + 1
      call check_line(deck, numbers, error)
      if (allocated(error)) return
      call next_reals(deck, numbers, row(:, n), error)
      if (allocated(error)) return
      if (n == 1) cycle
      if (row(1, n) <= row(1, n - 1)) then
        call expect(deck, 'a time above '//real_text(row(1, n - 1)), real_text(row(1, n)), error)
        return
      end if
    end do
    if (n < 2) then
      call fail(error, status_bad_input, name//':'//number_text(deck%n_lines)//': expected two lines '//numbers// &
                ' or more, found '//number_text(n))
      return
    end if
    record%time = row(1, :)
    record%value = row(2:, :)
  end subroutine read_record_file

  !> Whether a file is one of PEER, by its name.
  pure logical function is_peer_file(name)
    character(len=*), intent(in) :: name

    is_peer_file = in_lower_case(name(max(1, len(name) - 3):)) == '.at2'
  end function is_peer_file

  !> Reads a record of PEER, in fractions of the gravity: the component along x, and the one along y where a file of it is named.
  !> The first acceleration is that of time 0; the component that ends first is 0 from there.
  !>
  !> Errors: a file that is no such record, time steps that differ.
  subroutine read_peer_files(along_x, along_y, record, error)
    character(len=*), intent(in) :: along_x, along_y !! files; along_y '': none
    type(time_table_t), intent(out) :: record
    type(error_t), allocatable, intent(out) :: error
    real(dp), allocatable :: x(:), y(:)
    real(dp) :: step, step_y
    integer :: i, n

    call read_component(along_x, step, x, error)
    if (allocated(error)) return
    allocate (y(0))
    if (len(along_y) > 0) then
      call read_component(along_y, step_y, y, error)
      if (allocated(error)) return
      if (abs(step_y - step) > 0) then
        call fail(error, status_bad_input, along_y//':'//number_text(peer_head)//': expected the time step of '//along_x//' ('// &
                  real_text(step)//'), found '//real_text(step_y))
        return
      end if
    end if
    n = max(size(x), size(y))
    record%time = [(i*step, i=0, n - 1)]
    allocate (record%value(2, n), source=0.0_dp)
    record%value(1, :size(x)) = x
    record%value(2, :size(y)) = y
  end subroutine read_peer_files

  !> Reads a component of a record of PEER: three lines of words, the last of which tells the unit, a line with the number of
  !> accelerations NPTS and their time step DT, then these. Errors: a file of another kind or unit, another number of them.
  subroutine read_component(name, step, value, error)
    character(len=*), intent(in) :: name
    real(dp), intent(out) :: step
    real(dp), allocatable, intent(out) :: value(:)
    type(error_t), allocatable, intent(out) :: error
    type(deck_t) :: deck
    integer :: n

    step = 0.0_dp
    deck%name = name
    call read_text(name, deck%text, error, kind='record')
    if (allocated(error)) return
    call blank_head(deck, error)
    if (allocated(error)) return
    call find_words(deck)
    call refuse_groups(deck, 'numbers', error)
    if (allocated(error)) return
    call next_index(deck, 'NPTS, the number of accelerations', n, error, least=2)
    if (allocated(error)) return
    call next_real(deck, 'DT, the time between accelerations', step, error, above=0.0_dp)
    if (allocated(error)) return
    if (numbers_left(deck) /= n) then
      call expect(deck, 'as many accelerations as NPTS says ('//number_text(n)//')', number_text(numbers_left(deck)), error)
      return
    end if
    allocate (value(n))
    call next_reals(deck, 'an acceleration of the record', value, error)
  end subroutine read_component

  !> Leaves of the head of a PEER record its numbers NPTS and DT alone, the rest as blanks.
  !>
  !> Errors: the head is shorter, or its third line does not say that accelerations in units of g follow.
  subroutine blank_head(deck, error)
    type(deck_t), intent(inout) :: deck
    type(error_t), allocatable, intent(out) :: error
    character(len=*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ'
    character(len=*), parameter :: exponents = 'deDE'
    character(len=*), parameter :: ends_of_words = '.,;:()' !! 'G. FILTER POINTS: ...' in records from before NGA
    character(len=*), parameter :: ends_of_numbers = '0123456789.'
    character(len=:), allocatable :: unit, words
    integer :: first, i, k, last

    last = 0
    do k = 1, peer_head
      first = last + 1
      last = first + index(deck%text(first:), new_line('a')) - 1
      if (last < first) then
        call fail(error, status_bad_input, deck%name//':'//number_text(k)// &
                  ': expected a head of four lines, as PEER records have, found the end')
        return
      end if
      if (k == peer_head) exit
      unit = in_lower_case(deck%text(first:last - 1))
      deck%text(first:last - 1) = ' '
    end do
    words = unit//' '
    do i = 1, len(words)
      if (scan(words(i:i), ends_of_words) > 0) words(i:i) = ' '
    end do
    if (index(words, 'acceleration') == 0 .or. index(words, ' g ') == 0) then
      call fail(error, status_bad_input, deck%name//':'//number_text(peer_head - 1)// &
                ': expected a line that says ''acceleration ... in units of g'', found '//in_quotes(trim(adjustl(unit))))
      return
    end if
    do i = first, last - 1
      if (deck%text(i:i) == '=') deck%text(i:i) = ' '
      if (scan(deck%text(i:i), letters) == 0) cycle
      if (scan(deck%text(i:i), exponents) > 0 .and. scan(deck%text(i - 1:i - 1), ends_of_numbers) > 0) cycle
      deck%text(i:i) = ' '
    end do
  end subroutine blank_head

  !> Error where groups follow the numbers of a record.
  subroutine refuse_groups(deck, expected, error)
    type(deck_t), intent(in) :: deck
    character(len=*), intent(in) :: expected
    type(error_t), allocatable, intent(out) :: error

    if (deck%groups_line > 0) &
      call fail(error, status_bad_input, deck%name//':'//number_text(deck%groups_line)//': expected '//expected// &
                ' alone, found ''&''')
  end subroutine refuse_groups

  !> Error where the next line with words has other than three.
  subroutine check_line(deck, numbers, error)
    type(deck_t), intent(inout) :: deck
    character(len=*), intent(in) :: numbers
    type(error_t), allocatable, intent(out) :: error
    integer :: last

    last = deck%at + 1
    do while (last < deck%n_words)
      if (deck%line(last + 1) /= deck%line(deck%at + 1)) exit
      last = last + 1
    end do
    if (last - deck%at == 3) return
    last = last - deck%at
    deck%at = deck%at + 1
    call expect(deck, 'three numbers '//numbers, number_text(last), error)
  end subroutine check_line

  !> Takes the numbers of a setting. Errors as of `read_record_file`.
  subroutine take_record(number, name, numbers, from, record, error)
    real(dp), intent(in) :: number(:)
    character(len=*), intent(in) :: name    !! of the setting
    character(len=*), intent(in) :: numbers !! of a time, as 't ax ay'
    character(len=*), intent(in) :: from    !! where they are given
    type(time_table_t), intent(out) :: record
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: row(3, size(number)/3)
    integer :: i, n

    n = size(number)
    if (modulo(n, 3) /= 0 .or. n < 6) then
      call fail(error, status_bad_input, from//': expected '//numbers//' of '//name//' at two times or more, found '// &
                number_text(n)//' numbers')
      return
    end if
    row = reshape(number, shape(row))
    do i = 2, n/3
      if (row(1, i) > row(1, i - 1)) cycle
      call fail(error, status_bad_input, from//': expected times of '//name//' that increase, found '// &
                real_text(row(1, i))//' after '//real_text(row(1, i - 1)))
      return
    end do
    record%time = row(1, :)
    record%value = row(2:, :)
  end subroutine take_record

end module scree_motion_record
