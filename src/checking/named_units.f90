!> Units that a deck names (&units). They are printed in place of dimensions, and no number is converted.
module scree_named_units
  use scree_kinds, only: dp
  use scree_scene, only: block_material_t, settings_t
  use scree_text, only: short_text
  implicit none
  private
  public :: doubt_of_gravity, with_units

  !> A unit whose size is known.
  type :: unit_t
    character(len=4) :: name
    real(dp) :: size !! in m or s
  end type unit_t

  type(unit_t), parameter :: lengths(*) = [unit_t('m', 1.0_dp), unit_t('mm', 1e-3_dp), unit_t('cm', 1e-2_dp), &
                                           unit_t('km', 1e3_dp), unit_t('ft', 0.3048_dp), unit_t('in', 0.0254_dp)]
  type(unit_t), parameter :: times(*) = [unit_t('s', 1.0_dp), unit_t('ms', 1e-3_dp), unit_t('min', 60.0_dp), unit_t('h', 3600.0_dp)]

  real(dp), parameter :: gravity = 9.81_dp !! of the earth, m/s^2
  real(dp), parameter :: leeway = 0.05_dp  !! of it: many take 10 m/s^2

contains

  !> A text with the names of units in place of the words length, force and time.
  pure function with_units(settings, text) result(named)
    type(settings_t), intent(in) :: settings
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: named

    named = text
    if (allocated(settings%unit_of_length)) named = put('length', settings%unit_of_length, named)
    if (allocated(settings%unit_of_force)) named = put('force', settings%unit_of_force, named)
    if (allocated(settings%unit_of_time)) named = put('time', settings%unit_of_time, named)
  end function with_units

  !> A text with a name in place of each whole word that is the dimension.
  pure recursive function put(dimension, name, text) result(named)
    character(len=*), intent(in) :: dimension, name, text
    character(len=:), allocatable :: named
    character(len=*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_'
    integer :: at, next
    logical :: alone

    named = text
    at = index(text, dimension)
    if (at == 0) return
    next = at + len(dimension)
    alone = .true.
    if (at > 1) alone = scan(text(at - 1:at - 1), letters) == 0
    if (next <= len(text)) alone = alone .and. scan(text(next:next), letters) == 0
    named = text(:at - 1)//name//put(dimension, name, text(next:))
    if (.not. alone) named = text(:next - 1)//put(dimension, name, text(next:))
  end function put

  !> Fault of a material whose unit weight over density is not the gravity of the earth in the named units; '' for none, and where a
  !> name is not known.
  pure function doubt_of_gravity(settings, material) result(doubt)
    type(settings_t), intent(in) :: settings
    type(block_material_t), intent(in) :: material
    character(len=:), allocatable :: doubt
    real(dp) :: expected, found, length, time

    doubt = ''
    if (.not. (allocated(settings%unit_of_length) .and. allocated(settings%unit_of_time))) return
    length = size_of(lengths, settings%unit_of_length)
    time = size_of(times, settings%unit_of_time)
    if (.not. (length > 0 .and. time > 0 .and. material%unit_weight > 0 .and. material%density > 0)) return
    expected = gravity*time**2/length
    found = material%unit_weight/material%density
    if (abs(found - expected) <= leeway*expected) return
    doubt = 'expected unit weight over density to be the gravity of the earth in &units, '//short_text(expected)// &
            with_units(settings, ' length/time^2')//', found '//short_text(found)
  end function doubt_of_gravity

  !> Size of the unit of a name; 0: it is not known.
  pure real(dp) function size_of(units, name)
    type(unit_t), intent(in) :: units(:)
    character(len=*), intent(in) :: name
    integer :: i

    size_of = 0.0_dp
    do i = 1, size(units)
      if (units(i)%name == name) size_of = units(i)%size
    end do
  end function size_of

end module scree_named_units
