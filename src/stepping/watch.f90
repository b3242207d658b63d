!> A watch on what a run makes: blocks that keep about their size, and energy that comes from somewhere.
!>
!> The equations of a step have a solution for materials that no rock has and for steps that are too large. It warns where that is
!> suspicious, once for each kind, and ends the run where it is nonsense.
module scree_watch
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use scree_energy, only: stored_energy
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_gravity, only: gravity_energy
  use scree_green_strain, only: least_stable_stretch, least_stretch
  use scree_inertia, only: kinetic_energy
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_progress, only: progress_t, warn
  use scree_state, only: state_t, time_of_run
  use scree_system, only: fixed_point
  use scree_text, only: rounded_text, short_text
  use scree_trouble, only: new_trouble, trouble_t, words_of
  implicit none
  private
  public :: begin_watch, check_numbers, energy_of, keep_watch, watch_impact, watch_step, watch_t

  !> Area over that at the start, or the inverse, that is suspicious with small strain, and with Green strain, where stretches are
  !> meant; and that ends the run. With small strain a block that turns grows, by 1 + r^2 in a step, in the runs of Shi's programs
  !> that scree is compared with up to 7 times.
  real(dp), parameter :: suspicious_small = 1.1_dp, suspicious_green = 3.0_dp, nonsense_area = 10.0_dp
  !> Stress over stiffness that ends a run with small strain. Its law then neglects half of a strain, makes and loses as much
  !> energy, and drives blocks through each other.
  real(dp), parameter :: nonsense_stress = 1.0_dp
  !> Energy that has come from nothing after any one step, over the energy that the scene can supply.
  real(dp), parameter :: suspicious_gain = 0.01_dp, nonsense_gain = 10.0_dp
  !> Strain, squared over two, whose energy in all blocks is too little to ask where it is from.
  real(dp), parameter :: faint_strain = 1e-10_dp

  !> Energy at the beginning of the watch, and its warnings so far.
  type :: watch_t
    real(dp) :: energy = 0.0_dp          !! at the start, and the work since, force length per unit thickness
    real(dp) :: scale = 0.0_dp           !! what the start, and loads since, have to give, likewise
    real(dp) :: height = 0.0_dp          !! energy of the whole weights when it looked last, likewise
    real(dp) :: given = 0.0_dp           !! by weights since the start, as much of them as acted, likewise
    real(dp) :: fallen = 0.0_dp          !! the most of that, likewise
    real(dp) :: least = 0.0_dp           !! energy above what there was and was given, at least so far: what was lost, below 0
    logical :: area_warned = .false., energy_warned = .false., impact_warned = .false.
    logical, allocatable :: soft(:)      !! (n_elements) warned of that Green strain lost its stiffness
    integer, allocatable :: grown(:)     !! (n_tips) steps without a break so far in which each tip of a crack has grown
  end type watch_t

contains

  !> Watch at the start of a run.
  subroutine begin_watch(model, cache, state, watch)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(watch_t), intent(out) :: watch
    integer :: e, i, n_fixed(model%n_blocks)
    real(dp) :: height

    allocate (watch%soft(model%n_elements), source=.false.)
    watch%height = energy_of_weights(model, cache)
    watch%energy = energy_of(model, cache, state)
    watch%scale = state%books%kinetic + state%books%strain + state%books%fixed_springs + state%books%bolts
    n_fixed = 0
    do i = 1, size(model%points%kind)
      associate (block => model%elements%block(model%points%element(i)))
        if (model%points%kind(i) == fixed_point) n_fixed(block) = n_fixed(block) + 1
      end associate
    end do
    height = maxval(state%vertex(2, :)) - minval(state%vertex(2, :))
    do e = 1, model%n_elements
      watch%scale = watch%scale + faint_strain*cache%element(e)%elasticity(1, 1)*cache%element(e)%kinematics%area
      if (allocated(model%effects%gravity) .and. n_fixed(model%elements%block(e)) < 2) &
        watch%scale = watch%scale + abs(model%effects%gravity%weight(e))*height ! it may fall
    end do
  end subroutine begin_watch

  !> Goes on with a model of which blocks are gone: what they took with them is neither lost nor won.
  pure subroutine keep_watch(watch, model, cache, change)
    type(watch_t), intent(inout) :: watch
    type(model_t), intent(in) :: model            !! without them
    type(cache_t), intent(in) :: cache
    real(dp), intent(in) :: change                !! of `energy_of`, force length per unit thickness

    watch%energy = watch%energy + change
    watch%height = energy_of_weights(model, cache)
  end subroutine keep_watch

  !> Error where energies are not finite: names an element whose own are not.
  subroutine check_numbers(model, cache, state, error)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(error_t), allocatable, intent(out) :: error
    type(trouble_t) :: trouble
    integer :: e

    if (ieee_is_finite(stored_energy(state%books))) return
    trouble%what = 'its velocity or stress is not a finite number'
    trouble%advice = 'a smaller step.size, and check density, E and loads'
    do e = 1, model%n_elements
      if (all(ieee_is_finite(state%velocity(model%elements%unknown(:, e)))) .and. &
          ieee_is_finite(sum(abs(state%stress(:, e))**2))) cycle
      trouble%element = e
      trouble%position = cache%element(e)%kinematics%centroid
      exit
    end do
    call fail(error, status_run_failed, words_of(trouble, model))
  end subroutine check_numbers

  !> Warns once of an impact that was left to springs, or of impacts that were made as one.
  subroutine watch_impact(watch, model, time, trouble, as_one, progress)
    type(watch_t), intent(inout) :: watch
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: time                  !! after the step
    type(trouble_t), intent(in) :: trouble, as_one !! nothing where there is none
    type(progress_t), intent(inout) :: progress

    if (watch%impact_warned .or. .not. (allocated(trouble%what) .or. allocated(as_one%what))) return
    watch%impact_warned = .true.
    if (allocated(trouble%what)) then
      call say(progress, time, 'contact.restitution was not applied to an impact, which the contact springs carried instead: '// &
               words_of(trouble, model))
    else
      call say(progress, time, words_of(as_one, model))
    end if
  end subroutine watch_impact

  !> Looks at areas and energy after a step.
  !>
  !> Errors: an area, a stress with small strain (but in the runs of Shi's programs), or a gain of energy that is nonsense.
  subroutine watch_step(watch, model, cache, state, work, weight_share, progress, error)
    type(watch_t), intent(inout) :: watch
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    real(dp), intent(in) :: work                  !! of loads, ground and supports in the step, force length per unit thickness
    real(dp), intent(in) :: weight_share          !! of the weights that acted in it
    type(progress_t), intent(inout) :: progress
    type(error_t), allocatable, intent(out) :: error

    call watch_areas(watch, model, cache, state, progress, error)
    if (allocated(error)) return
    if (model%effects%large_deformation) then
      call watch_stiffness(watch, model, cache, state, progress)
    else if (.not. model%settings%shi) then
      call watch_stress(model, cache, state, error)
      if (allocated(error)) return
    end if
    call watch_energy(watch, model, cache, state, work, weight_share, progress, error)
  end subroutine watch_step

  !> Compares each area with that at the start: det F, as the field of an element is linear.
  subroutine watch_areas(watch, model, cache, state, progress, error)
    type(watch_t), intent(inout) :: watch
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(progress_t), intent(inout) :: progress
    type(error_t), allocatable, intent(out) :: error
    type(trouble_t) :: trouble
    real(dp) :: ratio, factor, farthest
    integer :: e, k, worst
    logical :: finite

    finite = model%effects%large_deformation .or. model%effects%strain_rotation
    farthest = 1.0_dp
    worst = 0
    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      associate (F => state%deformation(:, e))
        ratio = F(1)*F(4) - F(2)*F(3)
      end associate
      factor = huge(factor)
      if (ratio > 0) factor = max(ratio, 1/ratio)
      if (factor <= farthest) cycle
      farthest = factor
      worst = e
    end do
    if (farthest <= merge(nonsense_area, merge(suspicious_green, suspicious_small, finite), &
                          watch%area_warned)) return
    associate (F => state%deformation(:, worst))
      ratio = F(1)*F(4) - F(2)*F(3)
    end associate
    trouble%element = worst
    trouble%position = cache%element(worst)%kinematics%centroid
    if (ratio < 1) then
      trouble%what = 'the block is crushed to '//rounded_text(ratio)//' of its initial area, under '// &
                     words_of_stress(model, state, worst)
      if (.not. ratio > 0) trouble%what = 'the block is turned inside out'
      trouble%advice = 'a smaller step.size, and check density, unit weight, E and loads for their units'
    else
      trouble%what = 'the block has grown to '//rounded_text(ratio)//' times its initial area'
      trouble%advice = 'method.strain=green or a smaller step.size, because small strain turns rotation into growth'
      if (finite) trouble%advice = 'a smaller step.size, and check loads and E for their units'
    end if
    if (farthest > nonsense_area) then
      call fail(error, status_run_failed, words_of(trouble, model))
    else
      watch%area_warned = .true.
      call say(progress, time_of_run(state), words_of(trouble, model))
    end if
  end subroutine watch_areas

  !> Compares stresses with the stiffness of small strain.
  subroutine watch_stress(model, cache, state, error)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(error_t), allocatable, intent(out) :: error
    integer :: e, k

    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      if (.not. maxval(abs(state%stress(:, e))) > nonsense_stress*stiffness_of(model, e)) cycle
      call fail(error, status_run_failed, words_of(new_trouble('the block is under '//words_of_stress(model, state, e)// &
                ', and the law of small strain does not hold there', 'method.strain=green, and check density, '// &
                'unit weight, E and loads for their units', e, cache%element(e)%kinematics%centroid), model))
      return
    end do
  end subroutine watch_stress

  !> Warns, once for each element, where the linear law in Green strain has lost its stiffness.
  subroutine watch_stiffness(watch, model, cache, state, progress)
    type(watch_t), intent(inout) :: watch
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(progress_t), intent(inout) :: progress
    type(trouble_t) :: trouble
    integer :: e, k

    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      if (watch%soft(e)) cycle
      if (least_stretch(state%deformation(:, e)) > least_stable_stretch) cycle
      watch%soft(e) = .true.
      trouble = new_trouble('the block is compressed to less than '//short_text(least_stable_stretch, 3)// &
                            ' of its length, where Green strain has lost its stiffness and results do not hold', &
                            'a larger E or smaller loads, and check their units', e, cache%element(e)%kinematics%centroid)
      call say(progress, time_of_run(state), words_of(trouble, model))
    end do
  end subroutine watch_stiffness

  !> Compares the energy, and what friction and the like have taken, with the least that it has been above that at the start and
  !> what weights, loads, ground and supports have given since.
  subroutine watch_energy(watch, model, cache, state, work, weight_share, progress, error)
    type(watch_t), intent(inout) :: watch
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    real(dp), intent(in) :: work                  !! of loads, ground and supports in the step, force length per unit thickness
    real(dp), intent(in) :: weight_share          !! of the weights that acted in it
    type(progress_t), intent(inout) :: progress
    type(error_t), allocatable, intent(out) :: error
    type(trouble_t) :: trouble
    real(dp) :: above, gain, height, own, most
    integer :: e

    height = energy_of_weights(model, cache)
    watch%given = watch%given + weight_share*(watch%height - height)
    watch%height = height
    watch%fallen = max(watch%fallen, watch%given)
    watch%energy = watch%energy + work
    watch%scale = watch%scale + abs(work)
    above = energy_of(model, cache, state) - watch%given - watch%energy
    watch%least = min(watch%least, above)
    gain = (above - watch%least)/(watch%scale + watch%fallen)
    if (.not. gain > merge(nonsense_gain, suspicious_gain, watch%energy_warned)) return
    most = -1.0_dp
    do e = 1, model%n_elements
      own = kinetic_energy(cache%element(e)%mass_matrix, state%velocity(model%elements%unknown(:, e)))
      if (own <= most) cycle
      most = own
      trouble%element = e
    end do
    trouble%position = cache%element(trouble%element)%kinematics%centroid
    associate (e => trouble%element)
      trouble%what = 'energy has come from nothing, '//rounded_text(gain)//' times what weight, loads and the initial state '// &
        'can supply; this block has most of it, at a mean speed of '//rounded_text(sqrt(2*most/cache%element(e)%mass))
    end associate
    trouble%advice = 'a smaller step.size or contact.stiffness, and look for wrong units and for blocks that overlap'
    if (gain > nonsense_gain) then
      call fail(error, status_run_failed, words_of(trouble, model))
    else
      watch%energy_warned = .true.
      call say(progress, time_of_run(state), words_of(trouble, model))
    end if
  end subroutine watch_energy

  !> A stress in words.
  function words_of_stress(model, state, e) result(words)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: e
    character(len=:), allocatable :: words

    associate (largest => maxval(abs(state%stress(:, e))))
      words = 'a stress of '//rounded_text(largest)//', which is '//rounded_text(largest/stiffness_of(model, e))// &
              ' of its stiffness'
    end associate
  end function words_of_stress

  !> Stiffness of the material of an element, with which its stress is compared, force/length^2.
  pure real(dp) function stiffness_of(model, e)
    type(model_t), intent(in) :: model
    integer, intent(in) :: e

    stiffness_of = model%effects%elasticity(1, 1, model%elements%material(e))
  end function stiffness_of

  !> Warns of what happened at a time.
  subroutine say(progress, time, words)
    type(progress_t), intent(inout) :: progress
    real(dp), intent(in) :: time
    character(len=*), intent(in) :: words

    call warn(progress, 'time '//rounded_text(time)//': '//words)
  end subroutine say

  !> Energy but for that of the weights, and what friction, damping, bolts and sleep have taken of it. Masses are those of the
  !> start, as are the weights: a mass that follows the area would bring energy of its own, the more the farther the scene is from
  !> y = 0.
  pure real(dp) function energy_of(model, cache, state) result(energy)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    integer :: e, k

    energy = state%books%strain + state%books%fixed_springs + state%books%contact_springs &
             + state%books%sleeping_springs + state%books%bolts + state%books%integrator &
             + state%books%friction + state%books%damping + state%books%yield + state%books%fracture &
             + state%books%asleep
    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      energy = energy + kinetic_energy(cache%element(e)%mass_matrix, &
          state%velocity(model%elements%unknown(:, e)))/cache%element(e)%mass_ratio
    end do
  end function energy_of

  !> Energy of the weights, about the middle of the scene.
  pure real(dp) function energy_of_weights(model, cache) result(energy)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    integer :: e, k

    energy = 0.0_dp
    if (.not. allocated(model%effects%gravity)) return
    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      energy = energy + gravity_energy(model%effects%gravity%weight(e), cache%element(e)%kinematics)
    end do
  end function energy_of_weights

end module scree_watch
