!> A watch on what a run makes: blocks that keep about their size, and energy that comes from somewhere.
!>
!> The equations of a step have a solution for materials that no rock has and for steps that are too large. It warns where that is
!> suspicious, once for each kind, and ends the run where it is nonsense.
module scree_watch
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use scree_effects, only: effects_t, element_cache_t
  use scree_energy, only: books_t
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_gravity, only: gravity_energy
  use scree_green_strain, only: least_stable_stretch, least_stretch
  use scree_inertia, only: kinetic_energy
  use scree_kinds, only: dp
  use scree_progress, only: progress_t, warn
  use scree_system, only: fixed_point, state_t, system_t
  use scree_text, only: rounded_text
  use scree_trouble, only: new_trouble, trouble_t, words_of
  implicit none
  private
  public :: begin_watch, check_numbers, watch_step, watch_t

  !> Area over that at the start, or the inverse, that is suspicious with small strain, and with Green strain, where stretches are
  !> meant; and that ends the run. With small strain a block that turns grows, by 1 + r^2 in a step, in the runs of Shi's programs
  !> that scree is compared with up to 7 times.
  real(dp), parameter :: suspicious_small = 1.1_dp, suspicious_green = 3.0_dp, nonsense_area = 10.0_dp
  !> Energy that comes from nothing, over all that the scene has to give.
  real(dp), parameter :: suspicious_gain = 0.1_dp, nonsense_gain = 10.0_dp
  !> Strain, squared over two, whose energy in all blocks is too little to ask where it is from.
  real(dp), parameter :: faint_strain = 1e-10_dp

  !> What the watch began with, and what it has warned of.
  type :: watch_t
    real(dp) :: energy = 0.0_dp          !! at the start less the work since, force length per unit thickness
    real(dp) :: scale = 0.0_dp           !! what the start, and loads since, have to give, likewise
    real(dp) :: height = 0.0_dp          !! energy of the weights at the start, likewise
    real(dp) :: fallen = 0.0_dp          !! most that they have given since, likewise
    logical :: area_warned = .false., energy_warned = .false.
    logical, allocatable :: soft(:)      !! (n_elements) warned of that Green strain lost its stiffness
  end type watch_t

contains

  !> Watch at the start of a run.
  subroutine begin_watch(system, effects, share, state, books, watch)
    type(system_t), intent(in) :: system
    type(effects_t), intent(in) :: effects
    type(element_cache_t), intent(in) :: share(:) !! (n_elements)
    type(state_t), intent(in) :: state
    type(books_t), intent(in) :: books
    type(watch_t), intent(out) :: watch
    integer :: e, i, n_fixed(system%n_blocks)
    real(dp) :: height

    allocate (watch%soft(system%n_elements), source=.false.)
    watch%height = energy_of_weights(effects, share)
    watch%energy = energy_of(system, share, state, books) + watch%height
    watch%scale = books%kinetic + books%strain + books%fixed_springs
    n_fixed = 0
    do i = 1, size(system%points%kind)
      associate (block => system%elements%block(system%points%element(i)))
        if (system%points%kind(i) == fixed_point) n_fixed(block) = n_fixed(block) + 1
      end associate
    end do
    height = maxval(state%vertex(2, :)) - minval(state%vertex(2, :))
    do e = 1, system%n_elements
      watch%scale = watch%scale + faint_strain*share(e)%elasticity(1, 1)*share(e)%kinematics%area
      if (allocated(effects%gravity) .and. n_fixed(system%elements%block(e)) < 2) &
        watch%scale = watch%scale + abs(effects%gravity%weight(e))*height ! it may fall
    end do
  end subroutine begin_watch

  !> Error where energies are not finite: names an element whose own are not.
  subroutine check_numbers(system, share, state, books, error)
    type(system_t), intent(in) :: system
    type(element_cache_t), intent(in) :: share(:) !! (n_elements) of `state`
    type(state_t), intent(in) :: state
    type(books_t), intent(in) :: books
    type(error_t), allocatable, intent(out) :: error
    type(trouble_t) :: trouble
    integer :: e

    if (all(ieee_is_finite([books%kinetic, books%strain, books%gravity, books%fixed_springs]))) return
    trouble%what = 'velocity or stress is beyond all numbers'
    trouble%advice = 'a smaller step.size, and check density, E and loads'
    do e = 1, system%n_elements
      if (all(ieee_is_finite(state%velocity(system%elements%unknown(:, e)))) .and. &
          ieee_is_finite(sum(abs(state%stress(:, e))**2))) cycle
      trouble%element = e
      trouble%position = share(e)%kinematics%centroid
      exit
    end do
    call fail(error, status_run_failed, words_of(trouble, system))
  end subroutine check_numbers

  !> Looks at areas and energy after a step.
  !>
  !> Errors: an area or a gain of energy that is nonsense.
  subroutine watch_step(watch, system, effects, share, state, books, work, progress, error)
    type(watch_t), intent(inout) :: watch
    type(system_t), intent(in) :: system
    type(effects_t), intent(in) :: effects
    type(element_cache_t), intent(in) :: share(:) !! (n_elements) of `state`
    type(state_t), intent(in) :: state
    type(books_t), intent(in) :: books
    real(dp), intent(in) :: work                  !! of loads, ground and supports in the step, force length per unit thickness
    type(progress_t), intent(inout) :: progress
    type(error_t), allocatable, intent(out) :: error

    call watch_areas()
    if (allocated(error)) return
    if (effects%large_deformation) call watch_stiffness()
    call watch_energy()

  contains

    !> Compares each area with that at the start: det F, as the field of an element is linear.
    subroutine watch_areas()
      type(trouble_t) :: trouble
      real(dp) :: ratio, factor, farthest
      integer :: e, worst

      farthest = 1.0_dp
      worst = 0
      do e = 1, system%n_elements
        associate (F => state%deformation(:, e))
          ratio = F(1)*F(4) - F(2)*F(3)
        end associate
        factor = huge(factor)
        if (ratio > 0) factor = max(ratio, 1/ratio)
        if (factor <= farthest) cycle
        farthest = factor
        worst = e
      end do
      if (farthest <= merge(nonsense_area, merge(suspicious_green, suspicious_small, effects%large_deformation), &
                            watch%area_warned)) return
      associate (F => state%deformation(:, worst))
        ratio = F(1)*F(4) - F(2)*F(3)
      end associate
      trouble%element = worst
      trouble%position = share(worst)%kinematics%centroid
      if (ratio < 1) then
        trouble%what = 'it is crushed to '//rounded_text(ratio)//' of its area at the start, under a stress of '// &
          rounded_text(maxval(abs(state%stress(:, worst))))//', '// &
          rounded_text(maxval(abs(state%stress(:, worst)))/effects%elasticity(1, 1, system%elements%material(worst)))// &
          ' of its stiffness'
        if (.not. ratio > 0) trouble%what = 'it is turned inside out'
        trouble%advice = 'a smaller step.size, and check density, unit weight, E and loads for their units'
      else
        trouble%what = 'it has grown to '//rounded_text(ratio)//' times its area at the start'
        trouble%advice = 'method.strain=green or a smaller step.size, as small strain takes rotation for growth'
        if (effects%large_deformation) trouble%advice = 'a smaller step.size, and check loads and E for their units'
      end if
      if (farthest > nonsense_area) then
        call fail(error, status_run_failed, words_of(trouble, system))
      else
        watch%area_warned = .true.
        call say(trouble)
      end if
    end subroutine watch_areas

    !> Warns, once for each element, where the linear law in Green strain has lost its stiffness.
    subroutine watch_stiffness()
      integer :: e

      do e = 1, system%n_elements
        if (watch%soft(e)) cycle
        if (least_stretch(state%deformation(:, e)) > least_stable_stretch) cycle
        watch%soft(e) = .true.
        call say(new_trouble('it is compressed to a stretch below 0.577, where Green strain has lost its stiffness', &
                           element=e, position=share(e)%kinematics%centroid))
      end do
    end subroutine watch_stiffness

    !> Compares the energy with that at the start and what loads, ground and supports have given since.
    subroutine watch_energy()
      type(trouble_t) :: trouble
      real(dp) :: gain, height, own, most
      integer :: e

      height = energy_of_weights(effects, share)
      watch%fallen = max(watch%fallen, watch%height - height)
      watch%energy = watch%energy + work
      watch%scale = watch%scale + abs(work)
      gain = (energy_of(system, share, state, books) + height - watch%energy)/(watch%scale + watch%fallen)
      if (.not. gain > merge(nonsense_gain, suspicious_gain, watch%energy_warned)) return
      most = -1.0_dp
      do e = 1, system%n_elements
        own = kinetic_energy(share(e)%mass_matrix, state%velocity(system%elements%unknown(:, e)))
        if (own <= most) cycle
        most = own
        trouble%element = e
      end do
      trouble%position = share(trouble%element)%kinematics%centroid
      associate (e => trouble%element)
        trouble%what = 'energy has come from nothing, '//rounded_text(gain)//' times all that weight, loads and the start can '// &
          'give; most of it moves this block, at a mean speed of '//rounded_text(sqrt(2*most/share(e)%mass))
      end associate
      trouble%advice = 'a smaller step.size or contact.stiffness, and check units and blocks that overlap'
      if (gain > nonsense_gain) then
        call fail(error, status_run_failed, words_of(trouble, system))
      else
        watch%energy_warned = .true.
        call say(trouble)
      end if
    end subroutine watch_energy

    !> Warns of a trouble at the present time.
    subroutine say(trouble)
      type(trouble_t), intent(in) :: trouble

      call warn(progress, 'time '//rounded_text(state%time)//': '//words_of(trouble, system))
    end subroutine say

  end subroutine watch_step

  !> Energy but for that of the weights. Masses are those of the start, as are the weights: a mass that follows the area would bring
  !> energy of its own, the more the farther the scene is from y = 0.
  pure real(dp) function energy_of(system, share, state, books) result(energy)
    type(system_t), intent(in) :: system
    type(element_cache_t), intent(in) :: share(:) !! (n_elements) of `state`
    type(state_t), intent(in) :: state
    type(books_t), intent(in) :: books
    integer :: e

    energy = books%strain + books%fixed_springs + state%contacts%energy
    do e = 1, system%n_elements
      energy = energy + kinetic_energy(share(e)%mass_matrix, state%velocity(system%elements%unknown(:, e)))/share(e)%mass_ratio
    end do
  end function energy_of

  !> Energy of the weights, about the middle of the scene.
  pure real(dp) function energy_of_weights(effects, share) result(energy)
    type(effects_t), intent(in) :: effects
    type(element_cache_t), intent(in) :: share(:) !! (n_elements)
    integer :: e

    energy = 0.0_dp
    if (.not. allocated(effects%gravity)) return
    do e = 1, size(share)
      energy = energy + gravity_energy(effects%gravity%weight(e), share(e)%kinematics)
    end do
  end function energy_of_weights

end module scree_watch
