!> A record of the acceleration of the ground: t ax ay at ascending times, from a file or from the deck itself.
module scree_acceleration_record
  use scree_deck_text, only: deck_t, expect, next_reals, numbers_left, read_deck
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_kinds, only: dp
  use scree_scene, only: time_table_t
  use scree_text, only: number_text, real_text
  implicit none
  private
  public :: read_record_file, take_record

contains

  !> Reads a file whose lines are t ax ay.
  !>
  !> Errors: a line of other than three numbers, times that do not increase, fewer than two lines.
  subroutine read_record_file(name, record, error)
    character(len=*), intent(in) :: name
    type(time_table_t), intent(out) :: record
    type(error_t), allocatable, intent(out) :: error
    type(deck_t) :: deck
    real(dp), allocatable :: row(:, :)
    integer :: n

    call read_deck(name, deck, error)
    if (allocated(error)) return
    if (deck%groups_line > 0) then
      call fail(error, status_bad_input, name//':'//number_text(deck%groups_line)// &
                ': expected lines t ax ay alone, found ''&''')
      return
    end if
    allocate (row(3, (numbers_left(deck) + 2)/3))
    n = 0
    do while (numbers_left(deck) > 0)
      n = n + 1
      call check_line(deck, error)
      if (allocated(error)) return
      call next_reals(deck, 't ax ay', row(:, n), error)
      if (allocated(error)) return
      if (n == 1) cycle
      if (row(1, n) <= row(1, n - 1)) then
        call expect(deck, 'a time above '//real_text(row(1, n - 1)), real_text(row(1, n)), error)
        return
      end if
    end do
    if (n < 2) then
      call fail(error, status_bad_input, name//':'//number_text(deck%n_lines)//': expected two lines t ax ay or more, found '// &
                number_text(n))
      return
    end if
    record%time = row(1, :)
    record%value = row(2:, :)
  end subroutine read_record_file

  !> Error where the next line with words has other than three.
  subroutine check_line(deck, error)
    type(deck_t), intent(inout) :: deck
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
    call expect(deck, 'three numbers t ax ay', number_text(last), error)
  end subroutine check_line

  !> Takes the numbers of acceleration.table. Errors as of `read_record_file`.
  subroutine take_record(number, from, record, error)
    real(dp), intent(in) :: number(:)
    character(len=*), intent(in) :: from !! where they are given
    type(time_table_t), intent(out) :: record
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: row(3, size(number)/3)
    integer :: i, n

    n = size(number)
    if (modulo(n, 3) /= 0 .or. n < 6) then
      call fail(error, status_bad_input, from//': expected t ax ay of acceleration.table at two times or more, found '// &
                number_text(n)//' numbers')
      return
    end if
    row = reshape(number, shape(row))
    do i = 2, n/3
      if (row(1, i) > row(1, i - 1)) cycle
      call fail(error, status_bad_input, from//': expected times of acceleration.table that increase, found '// &
                real_text(row(1, i))//' after '//real_text(row(1, i - 1)))
      return
    end do
    record%time = row(1, :)
    record%value = row(2:, :)
  end subroutine take_record

end module scree_acceleration_record
