!> Numbers as text for people, and names of files.
module scree_text
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_null_char, c_null_ptr, c_ptr
  use scree_kinds, only: dp
  implicit none
  private
  public :: in_lower_case, number_text, pair_text, place_text, real_of, real_text, rounded_text, same_length, short_text, text_t, &
            with_ending

  !> One of several texts.
  type :: text_t
    character(len=:), allocatable :: text
  end type text_t

  interface
    pure real(c_double) function strtod(text, end) bind(c, name='strtod')
      import :: c_char, c_double, c_ptr
      character(kind=c_char), intent(in) :: text(*)
      type(c_ptr), value :: end
    end function strtod
  end interface

contains

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

  !> The real next to a decimal with an exponent after e or d, or none; huge where it is beyond 1e300. A Fortran `read` of
  !> it gives the same, ten times as slowly, and fails where it is infinite.
  pure real(dp) function real_of(word)
    character(len=*), intent(in) :: word
    character(len=len(word) + 1, kind=c_char) :: text
    integer :: exponent, first, letter, mantissa, point

    text = word//c_null_char
    letter = scan(word, 'eEdD')
    mantissa = len(word)
    exponent = 0
    if (letter > 0) then
      text(letter:letter) = 'e'
      mantissa = letter - 1
      exponent = whole_of(word(letter + 1:))
    end if
    point = index(word(:mantissa), '.')
    if (point == 0) point = mantissa + 1
    first = scan(word(:mantissa), '123456789')
    if (first > 0 .and. exponent + point - first + merge(0, 1, first < point) > 300) then
      real_of = merge(-huge(1.0_dp), huge(1.0_dp), word(1:1) == '-')
    else
      real_of = strtod(text, c_null_ptr)
    end if
  end function real_of

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

  !> A place in or about a model for people, (x, y): to four digits, or as many as `digits`, and to one more for each power of ten
  !> by which a coordinate is larger than the model, so that a model far from the origin is told as well as one that is not.
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

  !> Texts as those of one length.
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
