!> The named groups. One table says all that is known of a name; reader, errors, `explain` and the manual follow it.
module scree_settings
  use scree_deck_text, only: beyond_arithmetic, comma_remark, deck_t, in_quotes, word_is_real, word_is_whole
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_kinds, only: dp
  use scree_named_groups, only: group_begins, groups_end, groups_t, name_has_value, next_item, start_groups, wrong_item
  use scree_scene, only: &
    fixed_exact, fixed_penalty, iterate_hybrid, iterate_newton, iterate_secant, mass_constant, mass_follows_area, &
    model_dda, model_nmm, plane_strain, plane_stress, scene_t, scheme_energy_momentum, scheme_newmark, &
    start_acceleration, start_consistent, start_dissipative, start_zero, strain_green, strain_small, test_residual, test_theta, &
    transport_field, transport_rates, word_t
  use scree_text, only: number_text, real_of, real_text
  implicit none
  private
  public :: choices_text, complete_settings, known_groups, place_in, place_of, put_word, read_groups, set_word, setting_t, &
            settings_table

  integer, parameter, public :: kind_text = 1, kind_choice = 2, kind_real = 3, kind_whole = 4, kind_reals = 5

  real(dp), parameter :: boundless = huge(1.0_dp)
  integer, parameter :: default_frames = 100

  !> What is known of one name.
  type :: setting_t
    character(len=12) :: group
    character(len=11) :: name
    integer :: kind
    character(len=62) :: default                   !! in words
    character(len=88) :: meaning
    character(len=44) :: choices = ''              !! of a choice, each between bars
    character(len=17) :: dimension = ''            !! of a number
    real(dp) :: least = -boundless                 !! range of a number
    real(dp) :: most = boundless
    logical :: open = .false.                      !! `least` itself is not allowed
  end type setting_t

  type(setting_t), parameter :: settings_table(*) = [ &
    setting_t('deck', 'geometry', kind_text, 'the geometry on the command line', &
              'geometry deck or block file, from the folder of the analysis deck'), &
    setting_t('deck', 'dialect', kind_choice, 'auto', 'order of the numbers: told by their count, or said', &
              '|auto|short|shi|'), &
    setting_t('method', 'preset', kind_choice, 'none', 'shi: as Shi''s programs do; a name given beside it wins', &
              '|none|shi|'), &
    setting_t('method', 'model', kind_choice, 'dda', 'DDA blocks, or manifold elements', '|dda|nmm|'), &
    setting_t('method', 'strain', kind_choice, 'small', 'strain of a step', '|small|green|'), &
    setting_t('method', 'rotation', kind_choice, 'linear', &
              'what moves a block of small strain: its rotation r, or cos r and sin r', '|linear|exact|'), &
    setting_t('method', 'plane', kind_choice, 'stress', 'what E and nu mean in the plane', '|stress|strain|'), &
    setting_t('method', 'mass', kind_choice, 'constant; follows_area with preset shi', &
              'mass of a block: its own, or density times present area', '|constant|follows_area|'), &
    setting_t('cover', 'edge', kind_real, 'none: a triangle for each block', &
              'edge of the triangles of a regular mathematical mesh', '', 'length', 0.0_dp, open=.true.), &
    setting_t('cover', 'origin', kind_reals, '0 0', 'a node of the regular mesh', '', 'length'), &
    setting_t('cover', 'angle', kind_real, '0', 'of a family of its edges against x', '', 'degree', -360.0_dp, 360.0_dp), &
    setting_t('cover', 'mesh', kind_text, 'none', 'mesh of triangles, Gmsh 4.1, from the folder of the analysis deck'), &
    setting_t('cover', 'least', kind_real, '0.1', 'share of its triangle with which an element carries covers of its own', '', &
              '1', 0.0_dp, 1.0_dp), &
    setting_t('integrator', 'scheme', kind_choice, 'energy_momentum with Green strain, else newmark', &
              'integrator', '|newmark|energy_momentum|'), &
    setting_t('integrator', 'beta', kind_real, '1', &
              'weight of the new acceleration in the velocity; 1/2 + chi of energy_momentum', '', '1', 0.5_dp, 1.0_dp), &
    setting_t('integrator', 'gamma', kind_real, '1/2 without beta, else (beta + 1/2)^2/4', &
              'weight of the new acceleration in the displacement', '', '1', 0.0_dp, open=.true.), &
    setting_t('integrator', 'start', kind_choice, 'dissipative where beta < 1, else zero', &
              'first step: as it comes, with beta 1, or from a consistent state', &
              '|zero|dissipative|acceleration|consistent|'), &
    setting_t('integrator', 'transport', kind_choice, 'field with Green strain, else rates', &
              'velocity of a DDA block: a vector field, or Shi''s six rates', '|field|rates|'), &
    setting_t('step', 'size', kind_real, 'g1 of the deck', 'largest step', '', 'time', 0.0_dp, open=.true.), &
    setting_t('step', 'end_time', kind_real, 'n5 steps of the size; none with control shi', 'end of the run', '', 'time', &
              0.0_dp, open=.true.), &
    setting_t('step', 'count', kind_whole, 'none; n5 with control shi', 'steps after which the run ends', '', '1', 1.0_dp, &
              1e9_dp), &
    setting_t('step', 'travel', kind_real, 'none; g2 with control shi', &
              'of a vertex in a step, at most, over half the size of the model; a longer step is cut', '', '1', 0.0_dp, &
              open=.true.), &
    setting_t('step', 'control', kind_choice, 'fixed', &
              'the size given, or sizes that Shi''s programs would choose to keep the displacement', '|fixed|shi|'), &
    setting_t('step', 'least', kind_real, '1e-6 of the size', 'a step that must be smaller ends the run', '', 'time', &
              0.0_dp, open=.true.), &
    setting_t('iteration', 'method', kind_choice, 'hybrid', &
              'operator with Green strain: secant, tangent, or secant first and tangent near the end', &
              '|secant|newton|hybrid|'), &
    setting_t('iteration', 'test', kind_choice, 'theta', &
              'what must settle: the displacement gradient, or the balance of forces', '|theta|residual|'), &
    setting_t('iteration', 'tolerance', kind_real, '1e-10 for theta, 1e-9 for residual', &
              'largest change of theta, or largest force out of balance over the largest force', '', '1', 0.0_dp, 1.0_dp, .true.), &
    setting_t('iteration', 'most', kind_whole, '25', 'iterations before the step is cut', '', '1', 1.0_dp, 1e6_dp), &
    setting_t('contact', 'method', kind_choice, 'penalty', &
              'springs, springs and multipliers, or no contact between bodies', '|penalty|augmented|none|'), &
    setting_t('contact', 'stiffness', kind_real, 'g0 of the deck, or 50 times the largest E', &
              'of a spring across a contact, per unit thickness', '', 'force/length', 0.0_dp, open=.true.), &
    setting_t('contact', 'shear_ratio', kind_real, '2.5', 'stiffness across a contact over that along it', '', '1', 0.0_dp, &
              open=.true.), &
    setting_t('contact', 'overlap', kind_real, '1e-9 of the size of the model', 'largest that method augmented leaves', '', &
              'length', 0.0_dp, open=.true.), &
    setting_t('contact', 'initial', kind_real, '0.02', &
              'depth to which blocks may overlap at the start, over the size of the smaller', '', '1', 0.0_dp, 1.0_dp), &
    setting_t('contact', 'restitution', kind_real, 'none: what the springs give back', &
              'velocity after an impact over that before', '', '1', 0.0_dp, 1.0_dp), &
    setting_t('contact', 'viscosity', kind_real, 'none', 'of a dashpot across a closed contact, per unit thickness', '', &
              'force time/length', 0.0_dp), &
    setting_t('contact', 'energy', kind_choice, 'dissipating', 'forces of the end of a step, or those that conserve energy', &
              '|dissipating|conserving|'), &
    setting_t('contact', 'closing', kind_real, '0; with preset shi 1e-4 of the size of the model', &
              'overlap at which a contact closes; in a dynamic run, gap up to which it begins closed', '', 'length', 0.0_dp), &
    setting_t('contact', 'opening', kind_real, '0; with preset shi 1e-7 of the size of the model', &
              'gap at which a closed contact opens', '', 'length', 0.0_dp), &
    setting_t('contact', 'friction', kind_choice, 'current; lagging with preset shi', &
              'of the normal force of the same solution, or of the iteration before', '|current|lagging|'), &
    setting_t('contact', 'adapt', kind_choice, 'none', &
              'stiffness that stays, or follows gaps and overlaps as in Shi''s programs', '|none|shi|'), &
    setting_t('contact', 'coupling', kind_choice, 'merged', &
              'contacts and deformation in one iteration, or contacts settled in each of deformation', '|merged|nested|'), &
    setting_t('fixed_points', 'method', kind_choice, 'exact; penalty with preset shi', &
              'fixed points: eliminated, or held by springs', '|exact|penalty|'), &
    setting_t('fixed_points', 'stiffness', kind_real, '100 times that of contact', &
              'of the springs, per unit thickness', '', 'force/length', 0.0_dp, open=.true.), &
    setting_t('loads', 'force', kind_reals, 'none', &
              'fx fy of each load point, constant, per unit thickness; Shi''s order has tables', '', 'force'), &
    setting_t('acceleration', 'table', kind_reals, 'none', 't ax ay of the ground at ascending times'), &
    setting_t('acceleration', 'file', kind_text, 'none', 'file with lines t ax ay, from the folder of the analysis deck'), &
    setting_t('acceleration', 'scale', kind_real, '1', 'factor of ax and ay, in units of the deck', '', '1'), &
    setting_t('damping', 'mass', kind_real, '0', 'alpha of the force -alpha M v against the velocity', '', '1/time', 0.0_dp), &
    setting_t('output', 'every', kind_whole, 'about 100 frames, even in time; by count with step.control shi', &
              'steps from frame to frame', '', '1', 1.0_dp, 1e9_dp), &
    setting_t('output', 'interval', kind_real, 'none', 'time from frame to frame, met exactly; instead of every', '', 'time', &
              0.0_dp, open=.true.)]

contains

  !> Reads the groups of a deck. Errors: an unknown group or name, twice the same, a value of the wrong kind or range.
  subroutine read_groups(deck, words, error)
    type(deck_t), intent(in) :: deck
    type(word_t), allocatable, intent(out) :: words(:) !! in the order of the table
    type(error_t), allocatable, intent(out) :: error
    type(groups_t) :: groups
    character(len=:), allocatable :: done, place

    allocate (words(size(settings_table)))
    done = ' '
    call start_groups(deck, groups)
    do
      call next_item(deck, groups, error)
      if (allocated(error)) return
      select case (groups%item)
      case (groups_end)
        return
      case (group_begins)
        if (all(settings_table%group /= groups%group)) then
          call wrong_item(deck, groups, 'one of the groups '//known_groups(settings_table), in_quotes(groups%word), error)
          return
        end if
        if (index(done, ' '//groups%group//' ') > 0) then
          call wrong_item(deck, groups, 'each group once', 'a second &'//groups%group, error)
          return
        end if
        done = done//groups%group//' '
      case (name_has_value)
        place = deck%name//':'//number_text(groups%line)
        call put_word(settings_table, place//': ', groups%group, groups%name, groups%value, place, words, error)
        if (allocated(error)) return
      end select
    end do
  end subroutine read_groups

  !> Takes GROUP.NAME=VALUE of the command line, over what the deck says. Errors as of `read_groups`.
  subroutine set_word(option, words, error)
    character(len=*), intent(in) :: option
    type(word_t), intent(inout) :: words(:)
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: value
    integer :: dot, equal, i

    equal = index(option, '=')
    dot = index(option(:max(equal - 1, 0)), '.')
    if (dot < 2 .or. equal < dot + 2 .or. equal == len(option)) then
      call fail(error, status_bad_input, '--set: expected GROUP.NAME=VALUE, found '//in_quotes(option))
      return
    end if
    i = place_of(option(:dot - 1), option(dot + 1:equal - 1))
    if (i > 0) then
      if (allocated(words(i)%value)) deallocate (words(i)%value)
    end if
    value = option(equal + 1:)
    call put_word(settings_table, '--set '//option//': ', option(:dot - 1), option(dot + 1:equal - 1), value, '--set', words, &
                  error)
  end subroutine set_word

  !> Place of a name in the table of settings, 0 where it has none.
  pure integer function place_of(group, name)
    character(len=*), intent(in) :: group, name

    place_of = place_in(settings_table, group, name)
  end function place_of

  !> Place of a name in a table, 0 where it has none.
  pure integer function place_in(table, group, name)
    type(setting_t), intent(in) :: table(:)
    character(len=*), intent(in) :: group, name
    integer :: i

    place_in = 0
    do i = 1, size(table)
      if (table(i)%group == group .and. table(i)%name == name) place_in = i
    end do
  end function place_in

  !> Checks one value against a table and keeps it. Errors: an unknown name, one twice, a value of the wrong kind or range.
  subroutine put_word(table, where, group, name, value, from, words, error)
    type(setting_t), intent(in) :: table(:)
    character(len=*), intent(in) :: where, group, name, value, from
    type(word_t), intent(inout) :: words(:) !! in the order of the table
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    i = place_in(table, group, name)
    if (i == 0) then
      if (any(table%group == group)) then
        call fail(error, status_bad_input, where//'expected one of the names '//known_names(table, group)// &
                  ' in &'//group//', found '//in_quotes(name))
      else
        call fail(error, status_bad_input, where//'expected one of the groups '//known_groups(table)//', found '//in_quotes(group))
      end if
    else if (allocated(words(i)%value)) then
      call fail(error, status_bad_input, where//'expected each name once, found a second '//name//' in &'//group)
    else
      call check_value(where//'expected ', group//'.'//name, table(i), value, error)
      if (allocated(error)) return
      words(i)%value = value
      words(i)%from = from
    end if
  end subroutine put_word

  !> Error where a value is not what the table asks for.
  subroutine check_value(expected, full_name, setting, value, error)
    character(len=*), intent(in) :: expected, full_name
    type(setting_t), intent(in) :: setting
    character(len=*), intent(in) :: value
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: x
    integer :: from, to

    select case (setting%kind)
    case (kind_text)
      if (len_trim(value) == 0) call wrong('a name for '//full_name)
    case (kind_choice)
      if (index(trim(setting%choices), '|'//value//'|') == 0 .or. len(value) == 0) &
        call wrong('one of '//choices_text(setting%choices)//' for '//full_name)
    case (kind_whole)
      if (.not. word_is_whole(value)) then
        call wrong('a whole number of at most nine digits for '//full_name)
        return
      end if
      read (value, *) x
      call check_range()
    case default
      from = 1
      do
        to = index(value(from:), ' ') + from - 2
        if (to < from) to = len(value)
        if (.not. word_is_real(value(from:to))) then
          call wrong('a number for '//full_name, comma_remark(:merge(len(comma_remark), 0, index(value, ',') > 0)))
          return
        end if
        if (setting%kind == kind_real .and. to < len(value)) then
          call wrong('one number for '//full_name, comma_remark)
          return
        end if
        x = real_of(value(from:to))
        call check_range()
        if (allocated(error) .or. to == len(value)) return
        from = to + 2
      end do
    end select

  contains

    subroutine wrong(what, remark)
      character(len=*), intent(in) :: what
      character(len=*), intent(in), optional :: remark

      call fail(error, status_bad_input, expected//what//', found '//in_quotes(value))
      if (present(remark)) error%message = error%message//remark
    end subroutine wrong

    subroutine check_range()
      character(len=:), allocatable :: range

      range = beyond_arithmetic(x, setting%least)
      if (len(range) == 0 .and. (x < setting%least .or. (setting%open .and. x <= setting%least) .or. x > setting%most)) &
        range = range_text(setting)
      if (len(range) > 0) call wrong(full_name//' '//range)
    end subroutine check_range

  end subroutine check_value

  !> A range in words.
  pure function range_text(setting)
    type(setting_t), intent(in) :: setting
    character(len=:), allocatable :: range_text

    if (setting%open) then
      range_text = 'above '//real_text(setting%least)
    else
      range_text = 'at least '//real_text(setting%least)
    end if
    if (setting%most < boundless) range_text = range_text//' and at most '//real_text(setting%most)
  end function range_text

  !> All groups of a table.
  pure function known_groups(table)
    type(setting_t), intent(in) :: table(:)
    character(len=:), allocatable :: known_groups
    integer :: i

    known_groups = '&'//trim(table(1)%group)
    do i = 2, size(table)
      if (table(i)%group /= table(i - 1)%group) known_groups = known_groups//', &'//trim(table(i)%group)
    end do
  end function known_groups

  !> All names of a group of a table.
  pure function known_names(table, group)
    type(setting_t), intent(in) :: table(:)
    character(len=*), intent(in) :: group
    character(len=:), allocatable :: known_names
    integer :: i

    known_names = ''
    do i = 1, size(table)
      if (table(i)%group == group) known_names = known_names//', '//trim(table(i)%name)
    end do
    known_names = known_names(3:)
  end function known_names

  !> '|a|b|' as 'a, b'.
  pure function choices_text(choices)
    character(len=*), intent(in) :: choices
    character(len=:), allocatable :: choices_text
    integer :: i

    choices_text = ''
    do i = 2, len_trim(choices) - 1
      if (choices(i:i) == '|') then
        choices_text = choices_text//', '
      else
        choices_text = choices_text//choices(i:i)
      end if
    end do
  end function choices_text

  !> Gives every name that has no value its default, and makes the settings of the scene.
  !>
  !> The numbers of the classic deck must have been read. Errors: numbers that contradict each other; `setting_rules` has the
  !> choices that do.
  subroutine complete_settings(scene, error)
    type(scene_t), intent(inout) :: scene
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: beta, size_, end_time

    associate (words => scene%words, s => scene%settings)
      call default('deck', 'dialect', 'auto')
      call default('method', 'preset', 'none')
      s%shi = word('method', 'preset') == 'shi'
      call default('method', 'model', 'dda')
      s%model = merge(model_dda, model_nmm, word('method', 'model') == 'dda')
      call complete_cover()
      if (allocated(error)) return
      call default('method', 'strain', 'small')
      s%strain = merge(strain_small, strain_green, word('method', 'strain') == 'small')
      call default('method', 'rotation', 'linear')
      s%turns_exactly = word('method', 'rotation') == 'exact'
      call default('method', 'plane', 'stress')
      s%plane = merge(plane_stress, plane_strain, word('method', 'plane') == 'stress')
      call default('method', 'mass', either('follows_area', 'constant', s%shi))
      s%mass = merge(mass_constant, mass_follows_area, word('method', 'mass') == 'constant')

      call default('integrator', 'scheme', either('energy_momentum', 'newmark', s%strain == strain_green))
      s%scheme = merge(scheme_newmark, scheme_energy_momentum, word('integrator', 'scheme') == 'newmark')
      beta = 1.0_dp
      if (has('integrator', 'beta')) beta = number('integrator', 'beta')
      if (s%scheme == scheme_newmark) &
        call default('integrator', 'gamma', real_text(merge((beta + 0.5_dp)**2/4, 0.5_dp, has('integrator', 'beta'))))
      call default('integrator', 'beta', '1')
      s%beta = beta
      if (s%scheme == scheme_newmark) s%gamma = number('integrator', 'gamma')
      call default('integrator', 'start', either('dissipative', 'zero', beta < 1))
      select case (word('integrator', 'start'))
      case ('zero')
        s%start = start_zero
      case ('dissipative')
        s%start = start_dissipative
      case ('acceleration')
        s%start = start_acceleration
      case default
        s%start = start_consistent
      end select
      call default('integrator', 'transport', &
                   either('field', 'rates', s%strain == strain_green .or. s%model == model_nmm))
      s%transport = merge(transport_field, transport_rates, word('integrator', 'transport') == 'field')

      s%loads_at_end = s%shi .or. .not. scene%carried > 0

      call default('step', 'size', real_text(scene%step_size))
      size_ = number('step', 'size')
      call default('step', 'control', 'fixed')
      s%chooses_step = word('step', 'control') == 'shi'
      if (s%chooses_step) then
        call default('step', 'count', number_text(max(1, scene%n_steps)))
        call default('step', 'travel', real_text(scene%displacement_ratio))
      else
        call default('step', 'end_time', real_text(scene%n_steps*size_))
      end if
      end_time = huge(end_time)
      if (has('step', 'end_time')) end_time = number('step', 'end_time')
      if (has('step', 'count')) s%most_steps = nint(number('step', 'count'))
      if (has('step', 'travel')) s%most_travel = 0.5_dp*scene%extent*number('step', 'travel')
      call default('step', 'least', real_text(1e-6_dp*size_))
      s%step_size = size_
      s%end_time = end_time
      s%least_step = number('step', 'least')
      if (s%least_step > size_) then
        call contradict('step', 'least', 'step.least at most step.size', word('step', 'least'))
        return
      end if
      if (.not. end_time > 0) then
        call fail(error, status_bad_input, scene%analysis_name// &
                  ': expected steps (n5) or an end_time in &step, found 0 steps')
        return
      end if

      call default('iteration', 'method', 'hybrid')
      select case (word('iteration', 'method'))
      case ('secant')
        s%iterate = iterate_secant
      case ('newton')
        s%iterate = iterate_newton
      case default
        s%iterate = iterate_hybrid
      end select
      call default('iteration', 'test', 'theta')
      s%test = merge(test_theta, test_residual, word('iteration', 'test') == 'theta')
      call default('iteration', 'tolerance', either('1e-10', '1e-9', s%test == test_theta))
      s%tolerance = number('iteration', 'tolerance')
      call default('iteration', 'most', '25')
      s%most_iterations = nint(number('iteration', 'most'))

      call default('fixed_points', 'method', either('penalty', 'exact', s%shi))
      s%fixed = merge(fixed_exact, fixed_penalty, word('fixed_points', 'method') == 'exact')
      call default('contact', 'method', 'penalty')
      s%contact = word('contact', 'method') /= 'none'
      if (scene%contact_stiffness > 0) then
        call default('contact', 'stiffness', real_text(scene%contact_stiffness))
      else
        call default('contact', 'stiffness', real_text(50*maxval(scene%block_material%young)))
      end if
      s%contact_stiffness = number('contact', 'stiffness')
      call default('contact', 'shear_ratio', '2.5')
      s%shear_ratio = number('contact', 'shear_ratio')
      if (word('contact', 'method') == 'augmented') then
        call default('contact', 'overlap', real_text(1e-9_dp*scene%extent))
        s%overlap = number('contact', 'overlap')
      end if
      call default('contact', 'initial', '0.02')
      s%initial_overlap = number('contact', 'initial')
      if (has('contact', 'restitution')) s%restitution = number('contact', 'restitution')
      if (has('contact', 'viscosity')) s%viscosity = number('contact', 'viscosity')
      call default('contact', 'energy', 'dissipating')
      s%conserving = word('contact', 'energy') == 'conserving'
      call default('contact', 'closing', either(real_text(1e-4_dp*scene%extent), '0', s%shi))
      s%closing = number('contact', 'closing')
      call default('contact', 'opening', either(real_text(1e-7_dp*scene%extent), '0', s%shi))
      s%opening = number('contact', 'opening')
      call default('contact', 'friction', either('lagging', 'current', s%shi .and. word('contact', 'method') == 'penalty'))
      s%lags = word('contact', 'friction') == 'lagging'
      call default('contact', 'adapt', 'none')
      s%adapts_stiffness = word('contact', 'adapt') == 'shi'
      call default('contact', 'coupling', 'merged')
      s%nested = word('contact', 'coupling') == 'nested'
      call default('fixed_points', 'stiffness', real_text(100*s%contact_stiffness))
      s%fixed_stiffness = number('fixed_points', 'stiffness')

      if (has('acceleration', 'table') .or. has('acceleration', 'file')) call default('acceleration', 'scale', '1')
      if (has('damping', 'mass')) s%mass_damping = number('damping', 'mass')

      if (has('output', 'interval')) then
        s%frame_interval = number('output', 'interval')
        if (s%frame_interval < s%least_step) then ! steps end at frames
          call contradict('output', 'interval', 'output.interval at least step.least, '//word('step', 'least'), &
                          word('output', 'interval'))
          return
        end if
      else if (s%chooses_step) then
        call default('output', 'every', number_text(max(1, (s%most_steps + default_frames - 1)/default_frames)))
      end if
      if (has('output', 'every')) then
        s%frame_every = nint(number('output', 'every'))
      else if (.not. has('output', 'interval')) then
        s%frame_spacing = min(end_time, s%most_steps*size_)/default_frames
      end if
    end associate

  contains

    !> The mathematical mesh.
    subroutine complete_cover()
      character(len=:), allocatable :: value
      integer :: i

      if (has('cover', 'edge')) then
        scene%settings%cover_edge = number('cover', 'edge')
        call default('cover', 'origin', '0 0')
        call default('cover', 'angle', '0')
        value = word('cover', 'origin')
        if (count([(value(i:i) == ' ', i=1, len(value))]) /= 1) then
          call contradict('cover', 'origin', 'two numbers', value)
          return
        end if
        read (value, *) scene%settings%cover_origin
        scene%settings%cover_angle = number('cover', 'angle')
      else if (.not. has('cover', 'mesh')) then
        return
      end if
      call default('cover', 'least', '0.1')
      scene%settings%least_share = number('cover', 'least')
    end subroutine complete_cover

    !> Whether a name has a value.
    logical function has(group, name)
      character(len=*), intent(in) :: group, name

      has = allocated(scene%words(place_of(group, name))%value)
    end function has

    !> Its value.
    function word(group, name)
      character(len=*), intent(in) :: group, name
      character(len=:), allocatable :: word

      word = scene%words(place_of(group, name))%value
    end function word

    !> Its value as a number.
    real(dp) function number(group, name)
      character(len=*), intent(in) :: group, name
      character(len=:), allocatable :: value

      value = word(group, name)
      read (value, *) number
    end function number

    !> Gives a name its default.
    subroutine default(group, name, value)
      character(len=*), intent(in) :: group, name, value

      if (has(group, name)) return
      scene%words(place_of(group, name)) = word_t(value, 'default')
    end subroutine default

    !> One of two words.
    function either(a, b, first)
      character(len=*), intent(in) :: a, b
      logical, intent(in) :: first
      character(len=:), allocatable :: either

      if (first) then
        either = a
      else
        either = b
      end if
    end function either

    !> Error at the place a name came from.
    subroutine contradict(group, name, expected, found)
      character(len=*), intent(in) :: group, name, expected, found
      character(len=:), allocatable :: place

      place = scene%words(place_of(group, name))%from
      if (place == '--set') place = '--set '//group//'.'//name
      call fail(error, status_bad_input, place//': expected '//expected//', found '//found)
    end subroutine contradict

  end subroutine complete_settings

end module scree_settings
