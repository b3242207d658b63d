!> Which numbers of the settings contradict each other, or the decks; `setting_rules` has the choices that do.
module scree_setting_checks
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_kinds, only: dp
  use scree_scene, only: scene_t, scheme_newmark
  use scree_setting_table, only: given_at, index_of
  use scree_text, only: number_text, real_text
  implicit none
  private
  public :: check_numbers

contains

  !> Error where numbers contradict each other.
  subroutine check_numbers(scene, error)
    type(scene_t), intent(in) :: scene
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: origin
    integer :: i

    associate (s => scene%settings)
      if (s%cover_edge > 0) then
        origin = value_of('cover.origin')
        if (count([(origin(i:i) == ' ', i=1, len(origin))]) /= 1) call contradict('cover.origin', 'two numbers')
      end if
      if (allocated(error)) return
      call check_materials(scene, error)
      if (.not. allocated(error)) call check_joints(scene, error)
      if (allocated(error)) return
      if (s%least_step > s%step_size) then
        call contradict('step.least', 'step.least at most step.size')
      else if (.not. s%end_time > 0) then
        call fail(error, status_bad_input, scene%analysis_name// &
                  ': expected steps (n5) or an end_time in &step, found 0 steps')
      else if (s%frame_interval > 0 .and. s%frame_interval < s%least_step) then ! steps end at frames
        call contradict('output.interval', 'output.interval at least step.least, '//value_of('step.least'))
      else if (s%aim > 0 .and. s%scheme == scheme_newmark .and. .not. stays_bounded(s%beta, s%gamma)) then
        call contradict('integrator.gamma', 'integrator.gamma at most (beta + 1/2)^2/4, or a beta of 0.6 or more, or another '// &
                        'scheme, as step.accuracy changes steps, and what is stiffer than they can follow grows by that')
      end if
    end associate

  contains

    !> Error at the place a setting came from.
    subroutine contradict(name, expected)
      character(len=*), intent(in) :: name, expected

      call fail(error, status_bad_input, given_at(scene%words, name)//': expected '//expected//', found '//value_of(name))
    end subroutine contradict

    !> A setting as text.
    function value_of(name)
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: value_of

      value_of = scene%words(index_of(scene%words, name))%value
    end function value_of

  end subroutine check_numbers

  !> Whether Newmark's step keeps what is stiffer than it can follow bounded while steps grow by up to 1.25 and shrink to 0.2: where
  !> its roots at infinite frequency are real, or far enough within 1 (doc/theory/integrators.md, eq-area-of-changing-steps).
  pure logical function stays_bounded(beta, gamma)
    real(dp), intent(in) :: beta, gamma

    stays_bounded = beta >= 0.6_dp .or. gamma <= (beta + 0.5_dp)**2/4*(1 + epsilon(gamma))
  end function stays_bounded

  !> Error where a list is not one number for each joint material, or stiffness is only along or only across one.
  subroutine check_joints(scene, error)
    type(scene_t), intent(in) :: scene
    type(error_t), allocatable, intent(out) :: error

    associate (s => scene%settings)
      call check_count('joints.phi', s%joint_phi)
      call check_count('joints.cohesion', s%joint_c)
      call check_count('joints.tensile_strength', s%joint_t)
      call check_count('joints.energy', s%joint_energy)
      call check_count('joints.shear_energy', s%joint_shear_energy)
      if (.not. allocated(error) .and. allocated(scene%joint_material)) call check_softening(scene, error)
      call check_count('joints.kn', s%joint_kn)
      call check_count('joints.ks', s%joint_ks)
      call check_count('joints.restitution', s%joint_restitution)
      call check_count('joints.residual_phi', s%worn_angle)
      call check_count('joints.residual_slip', s%worn_slip)
      call check_count('joints.residual_c', s%worn_cohesion)
      call check_count('joints.jrc', s%jrc)
      call check_count('joints.jcs', s%jcs)
      call check_count('joints.closure', s%joint_closure)
      call check_count('joints.dilation', s%dilation)
      call check_count('joints.dilation_slip', s%dilation_slip)
      if (.not. allocated(error)) call check_dilation(scene, error)
      if (.not. allocated(error) .and. allocated(s%joint_closure) .and. allocated(s%joint_kn)) then
        if (any(s%joint_closure > 0 .and. .not. s%joint_kn > 0)) &
          call wrong_list(scene, 'joints.closure', 'numbers above 0 only where joints.kn is', 'other', error)
      end if
      if (allocated(error) .or. .not. (allocated(s%joint_kn) .and. allocated(s%joint_ks))) return
      if (any(s%joint_kn > 0 .neqv. s%joint_ks > 0)) &
        call wrong_list(scene, 'joints.ks', 'above 0 where joints.kn is, and 0 where that is', 'other', error)
    end associate

  contains

    !> Error where a list is not one number for each joint material.
    subroutine check_count(name, values)
      character(len=*), intent(in) :: name
      real(dp), allocatable, intent(in) :: values(:)
      integer :: n

      n = 0
      if (allocated(scene%joint_material)) n = size(scene%joint_material)
      if (.not. allocated(error)) call check_list(scene, name, values, n, 'joint', error)
    end subroutine check_count

  end subroutine check_joints

  !> Error where a bond is to take energy without a strength to take it with.
  subroutine check_softening(scene, error)
    type(scene_t), intent(in) :: scene
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: cohesion(size(scene%joint_material)), strength(size(cohesion))

    associate (s => scene%settings)
      cohesion = scene%joint_material%cohesion
      strength = scene%joint_material%tensile_strength
      if (allocated(s%joint_c)) cohesion = s%joint_c
      if (allocated(s%joint_t)) strength = s%joint_t
      if (allocated(s%joint_energy)) call check('joints.energy', s%joint_energy, 'a tensile strength', strength)
      if (allocated(s%joint_shear_energy)) call check('joints.shear_energy', s%joint_shear_energy, 'a cohesion', cohesion)
    end associate

  contains

    !> Error where a material has the energy and not the strength.
    subroutine check(name, energy, kind, least)
      character(len=*), intent(in) :: name, kind
      real(dp), intent(in) :: energy(:), least(:)
      integer :: i

      if (allocated(error)) return
      i = findloc(energy > 0 .and. .not. least > 0, .true., 1)
      if (i > 0) call wrong_list(scene, name, 'numbers above 0 only where the joint material has '//kind, &
                                 real_text(energy(i))//' for material '//number_text(i)//', which has none', error)
    end subroutine check

  end subroutine check_softening

  !> Error where a joint dilates at an angle above that of its friction, which would make energy, or without an end.
  subroutine check_dilation(scene, error)
    type(scene_t), intent(in) :: scene
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: least
    integer :: i

    associate (s => scene%settings)
      if (.not. (allocated(s%dilation) .and. allocated(s%dilation_slip))) return
      do i = 1, size(s%dilation)
        least = scene%joint_material(i)%friction_angle
        if (allocated(s%joint_phi)) least = s%joint_phi(i)
        if (allocated(s%worn_slip)) least = merge(min(least, s%worn_angle(i)), least, s%worn_slip(i) > 0)
        if (s%dilation(i) > least) then
          call wrong_list(scene, 'joints.dilation', 'no angle above that of friction (it would make energy), '// &
                          real_text(least)//' of material '//number_text(i), real_text(s%dilation(i)), error)
        else if (s%dilation(i) > 0 .and. .not. s%dilation_slip(i) > 0) then
          call wrong_list(scene, 'joints.dilation_slip', 'a slip above 0 where joints.dilation is', '0', error)
        end if
        if (allocated(error)) return
      end do
    end associate
  end subroutine check_dilation

  !> Error where a list is not one number for each block material, or the one that stands for all has no mass.
  subroutine check_materials(scene, error)
    type(scene_t), intent(in) :: scene
    type(error_t), allocatable, intent(out) :: error
    integer :: n, n_joints

    n = 0
    if (allocated(scene%block_material)) n = size(scene%block_material)
    n_joints = 0
    if (allocated(scene%joint_material)) n_joints = size(scene%joint_material)
    associate (s => scene%settings)
      call check_list(scene, 'materials.young', s%young, n, 'block', error)
      if (.not. allocated(error)) call check_list(scene, 'materials.poisson', s%poisson, n, 'block', error)
      if (.not. allocated(error)) call check_list(scene, 'materials.unit_weight', s%unit_weight, n, 'block', error)
      if (.not. allocated(error)) call check_list(scene, 'cracks.strength', s%crack_strength, n, 'block', error)
      if (.not. allocated(error)) call check_list(scene, 'cracks.toughness', s%crack_toughness, n, 'block', error)
      if (.not. allocated(error) .and. s%crack_begin_joint > n_joints) &
        call fail(error, status_bad_input, given_at(scene%words, 'cracks.begin_joint')//': expected a joint material up to '// &
                  number_text(n_joints)//' for cracks.begin_joint, found '//number_text(s%crack_begin_joint))
      if (.not. allocated(error) .and. allocated(s%k0)) call check_in_situ(scene, error)
      if (allocated(error) .or. n == 0 .or. .not. s%chooses_step) return
      if (.not. scene%block_material(1)%density > 0) &
        call fail(error, status_bad_input, given_at(scene%words, 'step.control')//': expected a density of block material 1 '// &
                  'above 0 with step.control=''shi'', which chooses by its mass, found 0')
    end associate
  end subroutine check_materials

  !> Error where K0 is not one number or one for each block material, or a material has an initial stress of its own.
  subroutine check_in_situ(scene, error)
    type(scene_t), intent(in) :: scene
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    associate (s => scene%settings, material => scene%block_material)
      if (size(s%k0) > 1) call check_list(scene, 'in_situ.k0', s%k0, size(material), 'block', error)
      if (allocated(error)) return
      i = findloc([(any(abs([material(i)%stress, material(i)%stress_gradient]) > 0), i=1, size(material))], .true., 1)
      if (i > 0) call fail(error, status_bad_input, given_at(scene%words, 'in_situ.k0')//': expected no initial stress of '// &
                           'block materials with in_situ.k0, found one of block material '//number_text(i))
    end associate
  end subroutine check_in_situ

  !> Error where a list is not one number for each material.
  subroutine check_list(scene, name, values, n, kind, error)
    type(scene_t), intent(in) :: scene
    character(len=*), intent(in) :: name, kind
    real(dp), allocatable, intent(in) :: values(:)
    integer, intent(in) :: n
    type(error_t), allocatable, intent(out) :: error

    if (.not. allocated(values)) return
    if (size(values) /= n) call wrong_list(scene, name, number_text(n)//' numbers, one for each '//kind//' material', &
                                           number_text(size(values)), error)
  end subroutine check_list

  !> Error at the place a list came from.
  subroutine wrong_list(scene, name, expected, found, error)
    type(scene_t), intent(in) :: scene
    character(len=*), intent(in) :: name, expected, found
    type(error_t), allocatable, intent(out) :: error

    call fail(error, status_bad_input, given_at(scene%words, name)//': expected '//name//' with '//expected//', found '//found)
  end subroutine wrong_list

end module scree_setting_checks
