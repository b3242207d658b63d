!> Prints the meaning of decks: every number with its name and dimension, every setting with its source.
module scree_explain
  use scree_kinds, only: dp
  use scree_scene, only: line_t, point_t, scene_t, time_table_t
  use scree_setting_rules, only: condition_text, setting_rules, subject_text
  use scree_setting_table, only: choices_text, full_name, kind_choice, setting_t
  use scree_settings, only: settings_table
  use scree_stages, only: lines_of_stages
  use scree_text, only: number_text, real_text, text_t
  implicit none
  private
  public :: explain_scene, explain_setting, explain_settings, is_setting

contains

  !> Prints the decks back.
  subroutine explain_scene(scene, unit)
    type(scene_t), intent(in) :: scene
    integer, intent(in) :: unit
    integer :: i

    call title('geometry: '//scene%geometry_name)
    if (allocated(scene%blocks)) then
      call number('blocks', real(size(scene%blocks%material), dp), '1')
      call number('vertices', real(size(scene%blocks%joint), dp), '1')
      call points('fixed point', scene%fixed_points)
    else
      call number('least distance of edge and node over the size (e0)', scene%least_distance, '1')
      call lines('line', 'joint material', scene%lines)
      call lines('material line', 'block material', scene%material_lines)
      call lines('fixed line', '', scene%fixed_lines)
      call points('hole point', scene%hole_points)
    end if
    call points('load point', scene%load_points)
    call points('measured point', scene%measured_points)
    do i = 1, size(scene%bolts)
      associate (bolt => scene%bolts(i))
        call numbers('bolt '//number_text(i)//' x1 y1 x2 y2', [bolt%ends], 'length')
        call number('bolt '//number_text(i)//' stiffness (e0)', bolt%stiffness, 'force/length')
        call number('bolt '//number_text(i)//' strength (t0; 0: without limit)', bolt%strength, 'force')
        call number('bolt '//number_text(i)//' pretension (f0)', bolt%pretension, 'force')
        if (bolt%shear_stiffness > 0) then
          call number('bolt '//number_text(i)//' shear stiffness', bolt%shear_stiffness, 'force/length')
          call number('bolt '//number_text(i)//' shear strength (0: without limit)', bolt%shear_strength, 'force')
        end if
      end associate
    end do

    call title('analysis: '//scene%analysis_name)
    do i = 1, size(scene%options)
      call title('  given: --set '//scene%options(i)%text)
    end do
    call number('fraction of the velocity passed on (k01)', scene%carried, '1')
    call number('steps (n5)', real(scene%n_steps, dp), '1')
    call number('largest displacement of a step over half the model size (g2)', scene%displacement_ratio, '1')
    call number('step size (g1)', scene%step_size, 'time')
    call number('contact stiffness (g0; 0: the program chooses)', scene%contact_stiffness, 'force/length')
    do i = 1, size(scene%fixed_table)
      call table('fixed point '//number_text(i), 'length', scene%fixed_table(i))
    end do
    do i = 1, size(scene%load_table)
      call table('load point '//number_text(i), 'force', scene%load_table(i))
    end do
    call table('acceleration of the ground', 'length/time^2', scene%ground)
    call table('velocity of the wave', 'length/time', scene%wave)
    call block_materials()
    call joint_materials()
    call settings()

  contains

    subroutine title(text)
      character(len=*), intent(in) :: text

      write (unit, '(a)') text
    end subroutine title

    subroutine number(name, value, dimension)
      character(len=*), intent(in) :: name, dimension
      real(dp), intent(in) :: value

      call numbers(name, [value], dimension)
    end subroutine number

    subroutine numbers(name, values, dimension)
      character(len=*), intent(in) :: name, dimension
      real(dp), intent(in) :: values(:)
      character(len=:), allocatable :: text
      integer :: k

      text = '  '//name//':'
      do k = 1, size(values)
        text = text//' '//real_text(values(k))
      end do
      write (unit, '(a)') text//dimension_text(dimension)
    end subroutine numbers

    subroutine lines(name, material, list)
      character(len=*), intent(in) :: name, material
      type(line_t), intent(in) :: list(:)
      integer :: k

      do k = 1, size(list)
        if (len(material) > 0) then
          call numbers(name//' '//number_text(k)//' ('//material//' '//number_text(list(k)%material)//') x1 y1 x2 y2', &
                       [list(k)%ends], 'length')
        else
          call numbers(name//' '//number_text(k)//' x1 y1 x2 y2', [list(k)%ends], 'length')
        end if
      end do
    end subroutine lines

    subroutine points(name, list)
      character(len=*), intent(in) :: name
      type(point_t), intent(in) :: list(:)
      integer :: k

      do k = 1, size(list)
        call numbers(name//' '//number_text(k)//' x y', list(k)%position, 'length')
      end do
    end subroutine points

    subroutine table(name, dimension, values)
      character(len=*), intent(in) :: name, dimension
      type(time_table_t), intent(in) :: values
      integer :: k

      if (.not. allocated(values%time)) return
      do k = 1, size(values%time)
        call numbers(name//' at time '//real_text(values%time(k))//' x y', values%value(:, k), dimension)
      end do
    end subroutine table

    subroutine block_materials()
      integer :: i

      do i = 1, size(scene%block_material)
        associate (m => scene%block_material(i))
          call title('block material '//number_text(i)//' (material('//number_text(i)//') for --set)')
          call number('density (ma)', m%density, 'mass/length^3')
          call number('unit weight (we)', m%unit_weight, 'force/length^3')
          call number('Young''s modulus (E)', m%young, 'force/length^2')
          call number('Poisson''s ratio (nu)', m%poisson, '1')
          call numbers('initial stress (s11 s22 s12)', m%stress, 'force/length^2')
          call numbers('its increase with y (t11 t22 t12)', m%stress_gradient, 'force/length^3')
          call numbers('initial velocity (vx vy)', m%velocity(1:2), 'length/time')
          call number('initial rotation rate (vr)', m%velocity(3), 'rad/time')
        end associate
      end do
    end subroutine block_materials

    subroutine joint_materials()
      integer :: i

      do i = 1, size(scene%joint_material)
        associate (m => scene%joint_material(i))
          call title('joint material '//number_text(i)//' (joint('//number_text(i)//') for --set)')
          call number('friction angle (phi)', m%friction_angle, 'degree')
          call number('cohesion (c)', m%cohesion, 'force/length^2')
          call number('tensile strength (T)', m%tensile_strength, 'force/length^2')
        end associate
      end do
    end subroutine joint_materials

    subroutine settings()
      type(setting_t), allocatable :: setting(:)
      type(text_t), allocatable :: stage(:)
      integer :: i

      call title('settings')
      setting = settings_table()
      do i = 1, size(setting)
        associate (word => scene%words(i))
          if (allocated(word%value)) write (unit, '(a)') '  '//word%name//' = '//word%value// &
            dimension_text(trim(setting(i)%dimension))//'  ('//word%from//')'
        end associate
      end do
      stage = lines_of_stages(scene)
      do i = 1, size(stage)
        call title(stage(i)%text)
      end do
    end subroutine settings

  end subroutine explain_scene

  !> Prints the table of all settings, and the table of their rules, as Markdown.
  subroutine explain_settings(unit)
    integer, intent(in) :: unit
    type(setting_t), allocatable :: setting(:)
    integer :: i

    setting = settings_table()
    write (unit, '(a)') '| name | values | unit | default | meaning |', '|---|---|---|---|---|'
    do i = 1, size(setting)
      associate (s => setting(i))
        write (unit, '(a)') '| `'//full_name(s)//'` | '//values(s)//' | '//trim(s%dimension)//' | '//trim(s%default)//' | '// &
          trim(s%meaning)//' |'
      end associate
    end do
    write (unit, '(a)') '', '| setting | only | because |', '|---|---|---|'
    do i = 1, size(setting_rules)
      write (unit, '(a)') '| `'//subject_text(setting_rules(i))//'` | '//condition_text(setting_rules(i))//' | '// &
        trim(setting_rules(i)%why)//' |'
    end do
  end subroutine explain_settings

  !> Whether a word is the name of a setting, GROUP.NAME, or of a group.
  function is_setting(word)
    character(len=*), intent(in) :: word
    logical :: is_setting
    type(setting_t), allocatable :: setting(:)
    integer :: i

    setting = settings_table()
    is_setting = .false.
    do i = 1, size(setting)
      is_setting = is_setting .or. word == full_name(setting(i)) .or. word == setting(i)%group
    end do
  end function is_setting

  !> Prints what a setting, or each setting of a group, means: default, values, dimension, and the rules about it.
  subroutine explain_setting(word, unit)
    character(len=*), intent(in) :: word         !! GROUP.NAME or GROUP
    integer, intent(in) :: unit
    type(setting_t), allocatable :: setting(:)
    character(len=:), allocatable :: name
    integer :: i, k

    setting = settings_table()
    do i = 1, size(setting)
      name = full_name(setting(i))
      if (word /= name .and. word /= setting(i)%group) cycle
      write (unit, '(a)') name//': '//trim(setting(i)%meaning)
      write (unit, '(a)') '  default: '//trim(setting(i)%default)
      if (len(values(setting(i))) > 0) write (unit, '(a)') '  values: '//values(setting(i))
      if (len(dimension_text(trim(setting(i)%dimension))) > 0) write (unit, '(a)') '  unit: '//trim(setting(i)%dimension)
      do k = 1, size(setting_rules)
        associate (rule => setting_rules(k))
          if (index(', '//trim(rule%names)//',', ', '//name//',') == 0) cycle
          if (len_trim(rule%value) == 0) then
            write (unit, '(a)') '  only '//condition_text(rule)//': '//trim(rule%why)
          else
            write (unit, '(a)') '  '//subject_text(rule)//' only '//condition_text(rule)//': '//trim(rule%why)
          end if
        end associate
      end do
    end do
  end subroutine explain_setting

  !> Values that a setting may have.
  function values(setting)
    type(setting_t), intent(in) :: setting
    character(len=:), allocatable :: values

    values = ''
    if (setting%kind == kind_choice) then
      values = choices_text(setting%choices)
    else if (setting%open) then
      values = 'above '//real_text(setting%least)
    else if (setting%least > -huge(1.0_dp)) then
      values = 'from '//real_text(setting%least)
    end if
    if (setting%most < huge(1.0_dp)) values = values//' to '//real_text(setting%most)
  end function values

  !> A dimension in brackets.
  function dimension_text(dimension)
    character(len=*), intent(in) :: dimension
    character(len=:), allocatable :: dimension_text

    dimension_text = ''
    if (len(dimension) > 0 .and. dimension /= '1') dimension_text = ' ['//dimension//']'
  end function dimension_text

end module scree_explain
