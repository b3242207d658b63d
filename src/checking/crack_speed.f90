!> The speed that a mesh and a step allow to cracks.
module scree_crack_speed
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_scene, only: scene_t
  use scree_text, only: append, short_text, text_t
  implicit none
  private
  public :: crack_step_warning, rayleigh_speed

contains

  !> Warns where a dynamic step is longer than Rayleigh waves, which no crack outruns, take along a side of a triangle at a tip, or
  !> where a crack may begin. A tip grows by one triangle in a step, so its crack would be slower than it can be.
  function crack_step_warning(scene, model) result(warning)
    type(scene_t), intent(in) :: scene
    type(model_t), intent(in) :: model
    type(text_t), allocatable :: warning(:)
    real(dp) :: longest
    integer :: i

    allocate (warning(0))
    if (.not. (allocated(model%tip) .and. model%settings%cracks_may_grow()) .or. scene%is_static()) return
    longest = huge(longest)
    do i = 1, size(model%tip)
      longest = min(longest, time_along(model%tip(i)%edge, model%tip(i)%element))
    end do
    if (allocated(model%crack_start)) then
      do i = 1, size(model%crack_start)
        longest = min(longest, time_along(model%crack_start(i)%edge, model%crack_start(i)%element))
      end do
    end if
    if (.not. scene%settings%step_size > longest) return
    call append(warning, 'the step '//short_text(scene%settings%step_size)//' lets cracks run at '// &
                short_text(longest/scene%settings%step_size)//' of the speed of Rayleigh waves, as each grows by one '// &
                'triangle in a step; a step below '//short_text(longest)//' lets them run as fast as they can')

  contains

    !> Time that Rayleigh waves take along a side of a triangle at an element; huge: its rock has no mass.
    real(dp) function time_along(edge, element)
      real(dp), intent(in) :: edge           !! length
      integer, intent(in) :: element

      time_along = huge(time_along)
      associate (material => model%elements%material(element))
        if (scene%block_material(material)%density > 0) &
          time_along = edge/rayleigh_speed(model%effects%elasticity(:, :, material), scene%block_material(material)%density)
      end associate
    end function time_along

  end function crack_step_warning

  !> Speed of Rayleigh waves, length/time: the root x = (c/c_s)^2 below 1 of (2 - x)^2 = 4 [(1 - x)(1 - x c_s^2/c_p^2)]^(1/2)
  !> (Rayleigh 1885), by bisection.
  pure real(dp) function rayleigh_speed(elasticity, density) result(speed)
    real(dp), intent(in) :: elasticity(3, 3) !! plane stress or strain, force/length^2
    real(dp), intent(in) :: density          !! mass/length^3
    real(dp) :: high, low, ratio, x
    integer :: i

    ratio = elasticity(3, 3)/elasticity(1, 1)
    low = 0.1_dp ! left of the root, and right of that at 0
    high = 1.0_dp
    do i = 1, digits(x)
      x = 0.5_dp*(low + high)
      if ((2 - x)**2 < 4*sqrt((1 - x)*(1 - ratio*x))) then
        low = x
      else
        high = x
      end if
    end do
    speed = sqrt(x*elasticity(3, 3)/density)
  end function rayleigh_speed

end module scree_crack_speed
