!> Numbers as text for people, and names of files.
module scree_text
  use scree_kinds, only: dp, i8
  implicit none
  private
  public :: append, in_lower_case, number_text, pair_text, place_text, real_of, real_text, rounded_text, same_length, short_text, &
            text_t, with_ending

  !> One of several texts.
  type :: text_t
    character(len=:), allocatable :: text
  end type text_t

  integer, parameter :: most_digits = 18      !! of a whole number of 64 bits
  integer, parameter :: exact_power = 22      !! of ten that a real holds: 5^22 < 2^53
  integer, parameter :: largest_power = 300   !! of ten, of what is read
  integer, parameter :: beyond_reals = 330    !! a power of ten whose inverse is below the least real
  integer :: k
  real(dp), parameter :: ten(0:exact_power) = [(10.0_dp**k, k=0, exact_power)]

contains

  !> Adds a text at the end of a list.
  !>
  !> gfortran 13 writes beyond the heap where a constructor is given a text that a function makes, as in `text_t(a//f(b))`. The text
  !> is an argument here, so it is whole before the constructor takes it.
  pure subroutine append(list, text)
    type(text_t), allocatable, intent(inout) :: list(:)
    character(len=*), intent(in) :: text

    list = [list, text_t(text)]
  end subroutine append

  !> A text with small letters for capitals.
  pure function in_lower_case(text)
    character(len=*), intent(in) :: text
    character(len=len(text)) :: in_lower_case
    integer :: i

    in_lower_case = text
    do i = 1, len(text)
      if (text(i:i) >= 'A' .and. text(i:i) <= 'Z') in_lower_case(i:i) = achar(iachar(text(i:i)) + 32)
    end do
  end function in_lower_case

  !> A whole number as text.
  pure function number_text(i)
    integer, intent(in) :: i
    character(len=:), allocatable :: number_text
    character(len=12) :: buffer

    write (buffer, '(i0)') i
    number_text = trim(buffer)
  end function number_text

  !> The real next to a decimal with an exponent after e or d, or none; huge where it is beyond 1e300.
  !>
  !> A decimal point is a point in every locale, which does not hold for C's `strtod`. A Fortran `read` gives the same bits ten
  !> times as slowly, and reads the few decimals that are not sure below. Method: Clinger 1990, "How to read floating point
  !> numbers accurately".
  pure real(dp) function real_of(word)
    character(len=*), intent(in) :: word
    integer(i8) :: whole
    integer :: digit, i, n, power
    logical :: in_fraction, sure

    whole = 0
    n = 0 ! digits from the first that is not 0
    power = 0
    in_fraction = .false.
    do i = 1, len(word)
      digit = iachar(word(i:i)) - iachar('0')
      if (digit >= 0 .and. digit <= 9) then
        if (n > 0 .or. digit > 0) n = n + 1
        if (n <= most_digits) whole = 10*whole + digit
        if (in_fraction) power = power - 1
      else if (word(i:i) == '.') then
        in_fraction = .true.
      else if (scan(word(i:i), 'eEdD') > 0) then
        power = power + whole_of(word(i + 1:))
        exit
      end if
    end do
    if (n > 0 .and. n + power > largest_power) then
      real_of = huge(real_of)
    else if (n == 0 .or. n + power < -beyond_reals) then
      real_of = 0.0_dp
    else
      sure = n <= most_digits
      if (sure) call scale_exactly(whole, power, real_of, sure)
      if (.not. sure) read (word, *) real_of
      real_of = abs(real_of)
    end if
    if (word(1:1) == '-') real_of = -real_of
  end function real_of

  !> A whole number times a power of ten, rounded once.
  !>
  !> A number of 53 bits and the power are reals, so one operation gives the result. A longer number is the sum of two reals, and
  !> the result another such sum, with an error of some 2^-104 (Dekker 1971). Where that sum is near the middle of two reals, or
  !> the power is no real, the result is not sure.
  pure subroutine scale_exactly(whole, power, x, sure)
    integer(i8), intent(in) :: whole         !! above 0
    integer, intent(in) :: power             !! of ten
    real(dp), intent(out) :: x
    logical, intent(out) :: sure
    real(dp), parameter :: doubt = 2.0_dp**(-40) !! of half a bit, far above the error of the sum
    real(dp) :: first, half, left, low, rest, scale

    sure = abs(power) <= exact_power
    x = real(whole, dp)
    if (.not. sure) return
    scale = ten(abs(power))
    low = real(whole - int(x, i8), dp)
    if (power < 0) then
      first = x/scale
      rest = ((x - first*scale) - rounded_off(first, scale) + low)/scale
    else
      first = x*scale
      rest = rounded_off(x, scale) + low*scale
    end if
    x = first
    if (whole <= 2_i8**digits(x)) return
    x = first + rest
    left = abs(rest - (x - first))
    half = 0.5_dp*spacing(x)
    sure = abs(left - half) > doubt*half .and. abs(left - 0.5_dp*half) > doubt*half ! below a power of two bits are half as large
  end subroutine scale_exactly

  !> Rounding error of the product of two reals, by halves of their digits, whose products are exact.
  elemental real(dp) function rounded_off(a, b)
    real(dp), intent(in) :: a, b
    real(dp), parameter :: splitter = 2.0_dp**27 + 1
    real(dp) :: a_high, a_low, b_high, b_low

    a_high = splitter*a - (splitter*a - a)
    b_high = splitter*b - (splitter*b - b)
    a_low = a - a_high
    b_low = b - b_high
    rounded_off = ((a_high*b_high - a*b) + a_high*b_low + a_low*b_high) + a_low*b_low
  end function rounded_off

  !> A whole number of a sign or none and at most nine digits.
  pure integer function whole_of(word)
    character(len=*), intent(in) :: word
    integer :: i

    whole_of = 0
    do i = 1, len(word)
      if (scan(word(i:i), '+-') == 0) whole_of = 10*whole_of + iachar(word(i:i)) - iachar('0')
    end do
    if (word(1:1) == '-') whole_of = -whole_of
  end function whole_of

  !> The shortest decimal that reads back as the same real; with an exponent where it is very large or small.
  pure function real_text(x)
    real(dp), intent(in) :: x
    character(len=:), allocatable :: real_text, digit, sign
    character(len=32) :: buffer
    character(len=16) :: form
    integer :: at, exponent, places
    real(dp) :: back

    ! a decimal of 15 digits or less is the only one near its real, so it is x to 15 digits, less zeros at the end; a real
    ! too small for all its digits may need fewer
    do places = merge(1, 14, abs(x) < tiny(x)), 16
      write (form, '(a,i0,a)') '(es28.', places, 'e3)'
      write (buffer, form) x
      read (buffer, *) back
      if (.not. abs(back - x) > 0.0_dp) exit
    end do
    buffer = adjustl(buffer)
    at = index(buffer, 'E')
    read (buffer(at + 1:), *) exponent
    sign = ''
    if (buffer(1:1) == '-') sign = '-'
    digit = buffer(len(sign) + 1:at - 1) ! d.ddd
    digit = digit(1:1)//digit(3:)
    if (exponent < -4 .or. exponent > 8) then
      real_text = sign//without_zeros(digit(1:1)//'.'//digit(2:))//'e'//number_text(exponent)
    else if (exponent < 0) then
      real_text = sign//without_zeros('0.'//repeat('0', -exponent - 1)//digit)
    else
      digit = digit//repeat('0', max(0, exponent + 1 - len(digit)))
      real_text = sign//without_zeros(digit(:exponent + 1)//'.'//digit(exponent + 2:))
    end if
  end function real_text

  !> A real to four digits, or as many as `digits`, up to 15.
  pure function short_text(x, digits)
    real(dp), intent(in) :: x
    integer, intent(in), optional :: digits
    character(len=:), allocatable :: short_text
    character(len=24) :: buffer
    character(len=11) :: form
    real(dp) :: rounded

    form = '(es24.3e3)'
    if (present(digits)) write (form, '(a,i0,a)') '(es24.', digits - 1, 'e3)'
    write (buffer, form) x
    read (buffer, *) rounded
    short_text = real_text(rounded)
  end function short_text

  !> A vector for people, (x, y), each to four digits.
  pure function pair_text(pair)
    real(dp), intent(in) :: pair(2)
    character(len=:), allocatable :: pair_text

    pair_text = '('//short_text(pair(1))//', '//short_text(pair(2))//')'
  end function pair_text

  !> Text of a place in a model for people, (x, y), to four digits or to `digits`.
  !>
  !> A coordinate has one digit more for each power of ten by which it is larger than the model, so that places of a model far from
  !> the origin can be told apart as well.
  pure function place_text(place, size, digits)
    real(dp), intent(in) :: place(2)
    real(dp), intent(in) :: size              !! of the model, length
    integer, intent(in), optional :: digits
    character(len=:), allocatable :: place_text
    integer :: i, least, needed(2)

    least = 4
    if (present(digits)) least = digits
    do i = 1, 2
      needed(i) = min(15, least + max(0, power_of_ten(place(i)) - power_of_ten(size)))
    end do
    place_text = '('//short_text(place(1), needed(1))//', '//short_text(place(2), needed(2))//')'
  end function place_text

  !> That below the size of a real.
  pure integer function power_of_ten(x)
    real(dp), intent(in) :: x

    power_of_ten = floor(log10(max(abs(x), tiny(x))))
  end function power_of_ten

  !> A time or ratio for people: to six digits.
  pure function rounded_text(x)
    real(dp), intent(in) :: x
    character(len=:), allocatable :: rounded_text

    rounded_text = short_text(x, 6)
  end function rounded_text

  !> A decimal without trailing zeros.
  pure function without_zeros(text)
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: without_zeros
    integer :: last

    last = verify(text, '0', back=.true.)
    if (text(last:last) == '.') last = last - 1
    without_zeros = text(:last)
  end function without_zeros

  !> A file name with another ending in place of its own.
  pure function with_ending(path, ending)
    character(len=*), intent(in) :: path, ending
    character(len=:), allocatable :: with_ending
    integer :: dot

    dot = index(path, '.', back=.true.)
    if (dot <= index(path, '/', back=.true.) + 1) dot = len(path) + 1
    with_ending = path(:dot - 1)//ending
  end function with_ending

  !> Texts padded to one length.
  pure function same_length(text) result(words)
    type(text_t), intent(in) :: text(:)
    character(len=:), allocatable :: words(:)
    integer :: i, longest

    longest = 1
    do i = 1, size(text)
      longest = max(longest, len(text(i)%text))
    end do
    allocate (character(len=longest) :: words(size(text)))
    do i = 1, size(text)
      words(i) = text(i)%text
    end do
  end function same_length

end module scree_text
