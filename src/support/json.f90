!> JSON, written member by member (RFC 8259).
module scree_json
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use scree_kinds, only: dp
  use scree_text, only: number_text, real_text
  implicit none
  private
  public :: begin_list, begin_object, end_list, end_object, json_t, put, put_null

  !> A text that is being written.
  type :: json_t
    character(len=:), allocatable :: text
  end type json_t

  !> Puts a member of an object, or with the name '' an item of a list. A number that is not finite is written as null.
  interface put
    module procedure put_logical, put_real, put_text, put_whole
  end interface put

contains

  !> Begins an object; without a name the whole, or an item of a list.
  subroutine begin_object(json, name)
    type(json_t), intent(inout) :: json
    character(len=*), intent(in) :: name

    call put_word(json, name, '{')
  end subroutine begin_object

  !> Ends an object.
  subroutine end_object(json)
    type(json_t), intent(inout) :: json

    json%text = json%text//'}'
  end subroutine end_object

  !> Begins a list.
  subroutine begin_list(json, name)
    type(json_t), intent(inout) :: json
    character(len=*), intent(in) :: name

    call put_word(json, name, '[')
  end subroutine begin_list

  !> Ends a list.
  subroutine end_list(json)
    type(json_t), intent(inout) :: json

    json%text = json%text//']'
  end subroutine end_list

  !> Puts true or false, or null where it is neither.
  subroutine put_logical(json, name, value)
    type(json_t), intent(inout) :: json
    character(len=*), intent(in) :: name
    logical, allocatable, intent(in) :: value

    if (.not. allocated(value)) then
      call put_null(json, name)
    else
      call put_word(json, name, trim(merge('true ', 'false', value)))
    end if
  end subroutine put_logical

  !> Puts a real, with all its digits.
  subroutine put_real(json, name, value)
    type(json_t), intent(inout) :: json
    character(len=*), intent(in) :: name
    real(dp), intent(in) :: value

    if (ieee_is_finite(value)) then
      call put_word(json, name, real_text(value))
    else
      call put_null(json, name)
    end if
  end subroutine put_real

  !> Puts a text.
  subroutine put_text(json, name, value)
    type(json_t), intent(inout) :: json
    character(len=*), intent(in) :: name, value

    call put_word(json, name, quoted(value))
  end subroutine put_text

  !> Puts a whole number.
  subroutine put_whole(json, name, value)
    type(json_t), intent(inout) :: json
    character(len=*), intent(in) :: name
    integer, intent(in) :: value

    call put_word(json, name, number_text(value))
  end subroutine put_whole

  !> Puts null: there is no such thing.
  subroutine put_null(json, name)
    type(json_t), intent(inout) :: json
    character(len=*), intent(in) :: name

    call put_word(json, name, 'null')
  end subroutine put_null

  !> Puts a word as it is.
  subroutine put_word(json, name, word)
    type(json_t), intent(inout) :: json
    character(len=*), intent(in) :: name, word

    if (.not. allocated(json%text)) json%text = ''
    if (len(json%text) > 0) then
      if (scan(json%text(len(json%text):), '{[') == 0) json%text = json%text//', '
    end if
    if (len(name) > 0) json%text = json%text//quoted(name)//': '
    json%text = json%text//word
  end subroutine put_word

  !> A text in quotation marks.
  pure function quoted(text)
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: quoted
    character(len=6) :: code
    integer :: i

    quoted = '"'
    do i = 1, len(text)
      if (iachar(text(i:i)) < 32) then
        write (code, '(a,z4.4)') '\u', iachar(text(i:i))
        quoted = quoted//code
      else
        if (scan(text(i:i), '"\') > 0) quoted = quoted//'\'
        quoted = quoted//text(i:i)
      end if
    end do
    quoted = quoted//'"'
  end function quoted

end module scree_json
