!> Troubles of a run: what, where, and what may help. The words of warnings and of runs that stop.
module scree_trouble
  use scree_kinds, only: dp
  use scree_scene, only: model_nmm
  use scree_system, only: system_t
  use scree_text, only: number_text, place_text
  implicit none
  private
  public :: new_trouble, trouble_t, words_of

  !> One trouble. Blocks and elements have their numbers of the deck, from 1.
  type :: trouble_t
    character(len=:), allocatable :: what   !! goes wrong
    integer :: element = 0                  !! where; 0: in no one element
    integer :: against = 0                  !! the element that it touches there, 0: none
    real(dp) :: position(2) = 0.0_dp           !! about the middle of the scene, of which `system%origin` is the place, length
    character(len=:), allocatable :: advice !! what to try
  end type trouble_t

contains

  !> A trouble in an element, or in no one element. (The compiler's own constructor loses the lengths of texts.)
  pure function new_trouble(what, advice, element, position) result(trouble)
    character(len=*), intent(in) :: what
    character(len=*), intent(in), optional :: advice
    integer, intent(in), optional :: element
    real(dp), intent(in), optional :: position(2)
    type(trouble_t) :: trouble

    trouble%what = what
    if (present(advice)) trouble%advice = advice
    if (present(element)) trouble%element = element
    if (present(position)) trouble%position = position
  end function new_trouble

  !> A trouble in one line: what, where, and what to try; `consequence` comes before that.
  pure function words_of(trouble, system, consequence) result(line)
    type(trouble_t), intent(in) :: trouble
    class(system_t), intent(in) :: system
    character(len=*), intent(in), optional :: consequence
    character(len=:), allocatable :: line

    line = trouble%what
    if (trouble%element > 0) then
      line = name_of(system, trouble%element)
      if (trouble%against > 0) line = line//' at '//name_of(system, trouble%against)
      line = line//', '//place_text(trouble%position + system%origin, system%extent, digits=6)//': '//trouble%what
    end if
    if (present(consequence)) line = line//'; '//consequence
    if (allocated(trouble%advice)) line = line//'; try '//trouble%advice
  end function words_of

  !> An element, as a person who wrote the deck knows it: a block of DDA is one.
  pure function name_of(system, element) result(name)
    class(system_t), intent(in) :: system
    integer, intent(in) :: element
    character(len=:), allocatable :: name

    name = 'block '//number_text(system%elements%block(element))
    if (system%model == model_nmm) name = 'element '//number_text(element)//' of '//name
  end function name_of

end module scree_trouble
