!> A stand-in for pFUnit's module of the same name: just the asserts that the suite uses, with pFUnit's meaning.
!>
!> A failed assert is kept with its place; the generated code then returns from the test. Tolerances are absolute and
!> 0 where not given. NaN equals nothing. Shapes must agree, or the expected value be a scalar.
module funit
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use, intrinsic :: iso_fortran_env, only: dp => real64, i8 => int64, error_unit, output_unit
  implicit none
  private
  public :: anyExceptions, assertEqual, assertFalse, assertGreaterThan, assertGreaterThanOrEqual, assertLessThan, &
            assertLessThanOrEqual, assertTrue, begin_test, end_test, end_tests, source_location_t

  !> Where an assert stands.
  type :: source_location_t
    character(len=80) :: file
    integer :: line
  end type source_location_t

  interface assertEqual
    module procedure equal_integer, equal_integers, equal_integer_matrix, equal_long, equal_text, &
      equal_real, equal_reals, equal_matrix, equal_all_reals, equal_all_matrix
  end interface assertEqual

  interface assertLessThan
    module procedure less_integer, less_real
  end interface assertLessThan

  interface assertGreaterThan
    module procedure greater_integer, greater_real
  end interface assertGreaterThan

  interface assertLessThanOrEqual
    module procedure at_most_integer, at_most_real
  end interface assertLessThanOrEqual

  interface assertGreaterThanOrEqual
    module procedure at_least_integer, at_least_real
  end interface assertGreaterThanOrEqual

  ! the state of the run; a test framework has one
  logical :: failed = .false.
  integer :: n_tests = 0, n_failed = 0
  character(len=120) :: test_name = ''

contains

  !> Whether an assert of the present test has failed.
  logical function anyExceptions()
    anyExceptions = failed
  end function anyExceptions

  !> Begins a test.
  subroutine begin_test(name)
    character(len=*), intent(in) :: name

    test_name = name
    failed = .false.
    n_tests = n_tests + 1
  end subroutine begin_test

  !> Ends a test.
  subroutine end_test()
    write (output_unit, '(a)', advance='no') merge('F', '.', failed)
    if (failed) n_failed = n_failed + 1
  end subroutine end_test

  !> Prints the verdict; a failure stops with an error status.
  subroutine end_tests()
    write (output_unit, '(a)') ''
    if (n_failed == 0) then
      write (output_unit, '(a)') 'OK'
      write (output_unit, '(a,i0,a)') ' (', n_tests, merge(' test) ', ' tests)', n_tests == 1)
    else
      write (output_unit, '(a)') 'FAILURES!!!'
      write (output_unit, '(2(a,i0))') 'Tests run: ', n_tests, ', Failures: ', n_failed
      flush (output_unit)
      error stop 1
    end if
  end subroutine end_tests

  !> Keeps a failure.
  subroutine report(what, message, location)
    character(len=*), intent(in) :: what
    character(len=*), intent(in), optional :: message
    type(source_location_t), intent(in), optional :: location

    failed = .true.
    write (error_unit, '(a)') 'Failure in '//trim(test_name)
    if (present(location)) write (error_unit, '(3a,i0,a)') '  [', trim(location%file), ':', location%line, ']'
    if (present(message)) write (error_unit, '(2a)') '  ', message
    write (error_unit, '(2a)') '  ', what
  end subroutine report

  !> Expected and found numbers as text.
  function pair(expected, found)
    real(dp), intent(in) :: expected, found
    character(len=:), allocatable :: pair
    character(len=80) :: buffer

    write (buffer, '(a,es24.16e3,a,es24.16e3)') 'expected ', expected, ', found ', found
    pair = trim(buffer)
  end function pair

  subroutine assertTrue(condition, message, location)
    logical, intent(in) :: condition
    character(len=*), intent(in), optional :: message
    type(source_location_t), intent(in), optional :: location

    if (.not. condition) call report('expected true, found false', message, location)
  end subroutine assertTrue

  subroutine assertFalse(condition, message, location)
    logical, intent(in) :: condition
    character(len=*), intent(in), optional :: message
    type(source_location_t), intent(in), optional :: location

    if (condition) call report('expected false, found true', message, location)
  end subroutine assertFalse

  subroutine equal_text(expected, found, message, location)
    character(len=*), intent(in) :: expected, found
    character(len=*), intent(in), optional :: message
    type(source_location_t), intent(in), optional :: location

    if (expected /= found .or. len_trim(expected) /= len_trim(found)) &
      call report('expected "'//expected//'", found "'//found//'"', message, location)
  end subroutine equal_text

  subroutine equal_integer(expected, found, message, location)
    integer, intent(in) :: expected, found
    character(len=*), intent(in), optional :: message
    type(source_location_t), intent(in), optional :: location

    if (expected /= found) call report(pair(real(expected, dp), real(found, dp)), message, location)
  end subroutine equal_integer

  subroutine equal_long(expected, found, message, location)
    integer(i8), intent(in) :: expected, found
    character(len=*), intent(in), optional :: message
    type(source_location_t), intent(in), optional :: location

    if (expected /= found) call report(pair(real(expected, dp), real(found, dp)), message, location)
  end subroutine equal_long

  subroutine equal_integers(expected, found, message, location)
    integer, intent(in) :: expected(:), found(:)
    character(len=*), intent(in), optional :: message
    type(source_location_t), intent(in), optional :: location

    call compare(real(expected, dp), real(found, dp), shape(expected), shape(found), 0.0_dp, message, location)
  end subroutine equal_integers

  subroutine equal_integer_matrix(expected, found, message, location)
    integer, intent(in) :: expected(:, :), found(:, :)
    character(len=*), intent(in), optional :: message
    type(source_location_t), intent(in), optional :: location

    call compare(reshape(real(expected, dp), [size(expected)]), reshape(real(found, dp), [size(found)]), shape(expected), &
                 shape(found), 0.0_dp, message, location)
  end subroutine equal_integer_matrix

  !> Compares numbers one by one; the first that differs is reported.
  subroutine compare(expected, found, expected_shape, found_shape, tolerance, message, location)
    real(dp), intent(in) :: expected(:), found(:), tolerance
    integer, intent(in) :: expected_shape(:), found_shape(:)
    character(len=*), intent(in), optional :: message
    type(source_location_t), intent(in), optional :: location
    character(len=24) :: at
    integer :: i

    if (any(expected_shape /= found_shape)) then
      call report('expected and found have different shapes', message, location)
      return
    end if
    do i = 1, size(expected)
      if (same(expected(i), found(i), tolerance)) cycle
      write (at, '(a,i0)') ' at element ', i
      if (size(expected) == 1) at = ''
      call report(pair(expected(i), found(i))//trim(at), message, location)
      return
    end do
  end subroutine compare

  !> Whether two numbers agree; NaN agrees with nothing.
  logical function same(expected, found, tolerance)
    real(dp), intent(in) :: expected, found, tolerance

    if (ieee_is_nan(expected) .or. ieee_is_nan(found)) then
      same = .false.
    else
      same = abs(found - expected) <= tolerance
    end if
  end function same

  subroutine equal_real(expected, found, tolerance, message, location)
    real(dp), intent(in) :: expected, found
    real(dp), intent(in), optional :: tolerance
    character(len=*), intent(in), optional :: message
    type(source_location_t), intent(in), optional :: location
    real(dp) :: allowed

    allowed = 0.0_dp
    if (present(tolerance)) allowed = tolerance
    call compare([expected], [found], [1], [1], allowed, message, location)
  end subroutine equal_real

  subroutine equal_reals(expected, found, tolerance, message, location)
    real(dp), intent(in) :: expected(:), found(:)
    real(dp), intent(in), optional :: tolerance
    character(len=*), intent(in), optional :: message
    type(source_location_t), intent(in), optional :: location
    real(dp) :: allowed

    allowed = 0.0_dp
    if (present(tolerance)) allowed = tolerance
    call compare(expected, found, shape(expected), shape(found), allowed, &
                 message, location)
  end subroutine equal_reals

  subroutine equal_matrix(expected, found, tolerance, message, location)
    real(dp), intent(in) :: expected(:, :), found(:, :)
    real(dp), intent(in), optional :: tolerance
    character(len=*), intent(in), optional :: message
    type(source_location_t), intent(in), optional :: location
    real(dp) :: allowed

    allowed = 0.0_dp
    if (present(tolerance)) allowed = tolerance
    call compare(reshape(expected, [size(expected)]), reshape(found, [size(found)]), shape(expected), shape(found), allowed, &
                 message, location)
  end subroutine equal_matrix

  subroutine equal_all_reals(expected, found, tolerance, message, location)
    real(dp), intent(in) :: expected, found(:)
    real(dp), intent(in), optional :: tolerance
    character(len=*), intent(in), optional :: message
    type(source_location_t), intent(in), optional :: location
    real(dp) :: allowed

    allowed = 0.0_dp
    if (present(tolerance)) allowed = tolerance
    call compare(spread(expected, 1, size(found)), found, shape(found), shape(found), allowed, &
                 message, location)
  end subroutine equal_all_reals

  subroutine equal_all_matrix(expected, found, tolerance, message, location)
    real(dp), intent(in) :: expected, found(:, :)
    real(dp), intent(in), optional :: tolerance
    character(len=*), intent(in), optional :: message
    type(source_location_t), intent(in), optional :: location
    real(dp) :: allowed

    allowed = 0.0_dp
    if (present(tolerance)) allowed = tolerance
    call compare(spread(expected, 1, size(found)), reshape(found, [size(found)]), shape(found), shape(found), allowed, &
                 message, location)
  end subroutine equal_all_matrix

  subroutine less_integer(a, b, message, location)
    integer, intent(in) :: a, b
    character(len=*), intent(in), optional :: message
    type(source_location_t), intent(in), optional :: location

    if (.not. a < b) call report('less than: '//pair(real(b, dp), real(a, dp)), message, location)
  end subroutine less_integer

  subroutine less_real(a, b, message, location)
    real(dp), intent(in) :: a, b
    character(len=*), intent(in), optional :: message
    type(source_location_t), intent(in), optional :: location

    if (.not. a < b) call report('less than: '//pair(b, a), message, location)
  end subroutine less_real

  subroutine greater_integer(a, b, message, location)
    integer, intent(in) :: a, b
    character(len=*), intent(in), optional :: message
    type(source_location_t), intent(in), optional :: location

    if (.not. a > b) call report('greater than: '//pair(real(b, dp), real(a, dp)), message, location)
  end subroutine greater_integer

  subroutine greater_real(a, b, message, location)
    real(dp), intent(in) :: a, b
    character(len=*), intent(in), optional :: message
    type(source_location_t), intent(in), optional :: location

    if (.not. a > b) call report('greater than: '//pair(b, a), message, location)
  end subroutine greater_real

  subroutine at_most_integer(a, b, message, location)
    integer, intent(in) :: a, b
    character(len=*), intent(in), optional :: message
    type(source_location_t), intent(in), optional :: location

    if (.not. a <= b) call report('at most: '//pair(real(b, dp), real(a, dp)), message, location)
  end subroutine at_most_integer

  subroutine at_most_real(a, b, message, location)
    real(dp), intent(in) :: a, b
    character(len=*), intent(in), optional :: message
    type(source_location_t), intent(in), optional :: location

    if (.not. a <= b) call report('at most: '//pair(b, a), message, location)
  end subroutine at_most_real

  subroutine at_least_integer(a, b, message, location)
    integer, intent(in) :: a, b
    character(len=*), intent(in), optional :: message
    type(source_location_t), intent(in), optional :: location

    if (.not. a >= b) call report('at least: '//pair(real(b, dp), real(a, dp)), message, location)
  end subroutine at_least_integer

  subroutine at_least_real(a, b, message, location)
    real(dp), intent(in) :: a, b
    character(len=*), intent(in), optional :: message
    type(source_location_t), intent(in), optional :: location

    if (.not. a >= b) call report('at least: '//pair(b, a), message, location)
  end subroutine at_least_real

end module funit
