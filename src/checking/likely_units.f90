!> The units that a deck is likely to be written in, told by density and stiffness, and whether its weight is gravity in them.
!>
!> A deck names no units. But rock, soil, ice and steel lie within a factor of a hundred in density and of 1e9 in stiffness. So most
!> mixtures of units, such as kN beside kg or GPa beside Pa, fit no system.
module scree_likely_units
  use scree_kinds, only: dp
  use scree_scene, only: block_material_t
  use scree_text, only: real_text, short_text
  implicit none
  private
  public :: doubt_of_stiffness, doubt_of_strength, doubt_of_water, doubt_of_weight

  !> Units that go together, and in them the density and stiffness of solids and the gravity of the earth.
  type :: unit_system_t
    character(len=18) :: name
    real(dp) :: density(2) !! least and most
    real(dp) :: young(2)   !! least and most
    real(dp) :: gravity
  end type unit_system_t

  type(unit_system_t), parameter :: systems(*) = [ &
    unit_system_t('m, kg, N', [100.0_dp, 3e4_dp], [1e5_dp, 1e14_dp], 9.81_dp), & ! and kgf s2/m for mass
    unit_system_t('m, t, kN', [0.1_dp, 30.0_dp], [1e2_dp, 1e11_dp], 9.81_dp), &  ! and tf s2/m
    unit_system_t('m, 1000 t, MN', [1e-4_dp, 0.03_dp], [0.1_dp, 1e8_dp], 9.81_dp), &
    unit_system_t('mm, t, N', [1e-10_dp, 3e-8_dp], [0.1_dp, 1e8_dp], 9810.0_dp), &
    unit_system_t('cm, g, dyn', [0.1_dp, 30.0_dp], [1e6_dp, 1e15_dp], 981.0_dp), &
    unit_system_t('ft, slug, lbf', [0.2_dp, 60.0_dp], [2e3_dp, 2e12_dp], 32.17_dp), &
    unit_system_t('in, lbf s2/in, lbf', [1e-5_dp, 3e-3_dp], [15.0_dp, 1.5e10_dp], 386.1_dp)]

  real(dp), parameter :: round_gravity = 10/9.81_dp !! many take 10 m/s2
  real(dp), parameter :: leeway = 0.05_dp           !! of gravity

  !> Largest strength over Young's modulus. Clay has an undrained modulus of 100 to 1500 times its strength, rock one of 200 to 500
  !> times its compressive strength (Deere & Miller 1966); a factor of two is left.
  real(dp), parameter :: most_strength = 0.02_dp
  !> Least strength over Young's modulus: 1 kPa of a joint in rock of 100 GPa is 1e-8, and a factor of ten is left.
  real(dp), parameter :: least_strength = 1e-9_dp
  !> The same of the walls of joints: weathered rock has a tenth of the strength of rock, and a factor of ten is left.
  real(dp), parameter, public :: least_strength_of_walls = 1e-5_dp
  !> Least strength over the weight of a column as high as the model. A cohesion c holds a vertical bank of height 4 c over the unit
  !> weight (Culmann), so a smaller strength changes nothing visible.
  real(dp), parameter :: least_bearing = 1e-4_dp
  !> Unit weight of water over that of the material about it: 0.13 in steel, 0.2 to 0.5 in rock, 1 in peat; with a factor of two.
  real(dp), parameter :: water_share(2) = [0.06_dp, 2.0_dp]

contains

  !> Fault of a joint strength, compared with the stiffness and the weight of the blocks; '' for none.
  pure function doubt_of_strength(what, strength, rock, height, least_share) result(doubt)
    character(len=*), intent(in) :: what                  !! the strength is
    real(dp), intent(in) :: strength                      !! force/length^2
    type(block_material_t), intent(in) :: rock(:)         !! that blocks are made of
    real(dp), intent(in) :: height                        !! of the model, length
    real(dp), intent(in), optional :: least_share         !! of Young's modulus; that of joints where absent
    character(len=:), allocatable :: doubt
    real(dp) :: least, weight

    doubt = ''
    if (.not. strength > 0 .or. size(rock) == 0) return
    weight = maxval(abs(rock%unit_weight))*height
    least = least_strength
    if (present(least_share)) least = least_share
    least = max(least*minval(rock%young), least_bearing*weight)
    if (strength > most_strength*maxval(rock%young)) then
      doubt = 'expected a '//what//' up to '//short_text(most_strength)//' of Young''s modulus, '// &
              short_text(most_strength*maxval(rock%young))//', found '//short_text(strength)//': Pa beside MPa?'
    else if (strength < least) then
      doubt = 'expected a '//what//' of 0 or from '//short_text(least)//', found '//short_text(strength)
      if (least_bearing*weight < least) then
        doubt = doubt//', which is nothing beside Young''s modulus: MPa beside Pa?'
      else
        doubt = doubt//', which is nothing beside the weight of the model, '//short_text(weight)//': MPa beside Pa?'
      end if
    end if
  end function doubt_of_strength

  !> Fault of the unit weight of water, compared with those of the blocks; '' for none.
  pure function doubt_of_water(water, rock) result(doubt)
    real(dp), intent(in) :: water, rock(:)                !! unit weights, force/length^3
    character(len=:), allocatable :: doubt
    real(dp) :: heaviest

    doubt = ''
    if (size(rock) == 0) return
    heaviest = maxval(rock)
    if (.not. heaviest > 0 .or. within(water, water_share*heaviest)) return
    doubt = 'expected a unit weight from '//short_text(water_share(1)*heaviest)//' to '//short_text(water_share(2)*heaviest)// &
            ', as that of the blocks is '//short_text(heaviest)//', found '//short_text(water)//': kN beside N?'
  end function doubt_of_water

  !> Fault of the stiffness of a material, compared with its density; '' for none.
  pure function doubt_of_stiffness(material) result(doubt)
    type(block_material_t), intent(in) :: material
    character(len=:), allocatable :: doubt
    integer :: i

    doubt = ''
    if (any(fits(material, with_young=.true.)) .or. .not. any(fits(material, with_young=.false.))) return
    i = findloc(fits(material, with_young=.false.), .true., 1)
    doubt = 'expected a Young''s modulus from '//real_text(systems(i)%young(1))//' to '//real_text(systems(i)%young(2))// &
            ' with the density '//short_text(material%density)//' ('//trim(systems(i)%name)//'), found '// &
            short_text(material%young)//': GPa or MPa beside Pa?'
  end function doubt_of_stiffness

  !> Fault of the weight of a material; '' for none.
  pure function doubt_of_weight(material) result(doubt)
    type(block_material_t), intent(in) :: material
    character(len=:), allocatable :: doubt
    logical :: likely(size(systems))
    real(dp) :: g
    integer :: power
    integer :: i

    doubt = ''
    if (.not. abs(material%unit_weight) > 0) return
    if (material%unit_weight < 0) then
      doubt = 'expected a unit weight of at least 0, which acts downwards, found '//short_text(material%unit_weight)
      return
    else if (.not. material%density > 0) then
      doubt = 'expected a density above 0 beside a unit weight, found 0'
      return
    end if
    g = material%unit_weight/material%density
    likely = fits(material, with_young=.true.)
    if (.not. any(likely)) likely = fits(material, with_young=.false.)
    if (.not. any(likely)) likely = .true.
    if (any(likely .and. is_gravity(g, systems%gravity))) return
    doubt = 'expected unit weight over density to be 0'
    do i = 1, size(systems)
      if (likely(i)) doubt = doubt//' or '//real_text(systems(i)%gravity)//' ('//trim(systems(i)%name)//')'
    end do
    doubt = doubt//', found '//short_text(g)
    do i = 1, size(systems)
      power = 3*nint((log10(systems(i)%gravity) - log10(max(g, tiny(g))))/3) ! of kilo, mega
      if (.not. likely(i) .or. abs(power) > 12) cycle
      if (.not. is_gravity(g*10.0_dp**power, systems(i)%gravity)) cycle
      doubt = doubt//': a factor of '//real_text(10.0_dp**abs(power))//', such as kN beside N'
      return
    end do
  end function doubt_of_weight

  !> The systems that the density of a material is likely in, or both its density and its stiffness.
  pure function fits(material, with_young)
    type(block_material_t), intent(in) :: material
    logical, intent(in) :: with_young
    logical :: fits(size(systems))
    integer :: i

    do i = 1, size(systems)
      fits(i) = within(material%density, systems(i)%density) .and. (within(material%young, systems(i)%young) .or. .not. with_young)
    end do
  end function fits

  !> Whether a number lies in a range.
  pure logical function within(x, range)
    real(dp), intent(in) :: x, range(2)

    within = x >= range(1) .and. x <= range(2)
  end function within

  !> Whether a weight over density is gravity, also the round one.
  elemental logical function is_gravity(g, gravity)
    real(dp), intent(in) :: g, gravity

    is_gravity = g >= (1 - leeway)*gravity .and. g <= (1 + leeway)*round_gravity*gravity
  end function is_gravity

end module scree_likely_units
