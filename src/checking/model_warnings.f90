!> Facts of a model that are likely mistakes: units, signs, missing supports.
module scree_model_warnings
  use scree_contact_rules, only: may_make_energy, only_presses
  use scree_kinds, only: dp
  use scree_likely_units, only: doubt_of_stiffness, doubt_of_weight
  use scree_model_facts, only: facts_t, hold_t, list_text, n_sides, side_name
  use scree_named_units, only: doubt_of_gravity
  use scree_scene, only: contact_none, model_dda, scene_t, scheme_bathe, scheme_central_difference, scheme_generalized_alpha, &
                         scheme_newmark, strain_small
  use scree_scene_warnings, only: warnings_of_scene
  use scree_text, only: append, number_text, place_text, short_text, text_t
  implicit none
  private
  public :: warnings_of

  !> Of compression: rock crushes at 1/500 to 1/200 (Deere & Miller 1966: the modulus is 200 to 500 times the strength).
  real(dp), parameter :: most_strain = 0.003_dp
  real(dp), parameter :: most_penetration = 0.01_dp  !! under own weight, of the width of the block
  real(dp), parameter :: least_angle = 1.0_dp        !! degrees; a friction angle below is one in radians, up to 57 degrees of them

  integer, parameter :: few_blocks = 10 !! up to which contacts by central differences take less than a millisecond a step

  character(len=*), parameter :: another_scheme = 'expected another integrator.scheme where blocks may meet, found '

contains

  !> One line a mistake.
  pure function warnings_of(scene, facts) result(warning)
    type(scene_t), intent(in) :: scene
    type(facts_t), intent(in) :: facts
    type(text_t), allocatable :: warning(:)
    character(len=:), allocatable :: where
    integer :: i

    allocate (warning(0))
    do i = 1, size(facts%block_material)
      associate (rock => scene%block_material(facts%block_material(i)))
        where = 'block material '//number_text(facts%block_material(i))//': '
        call add_doubt(where, doubt_of_stiffness(rock))
        call add_doubt(where, doubt_of_weight(rock))
        call add_doubt(where, doubt_of_gravity(scene%settings, rock))
        if (any(abs(rock%velocity) > 0) .and. scene%is_static()) &
          call add(where//'expected no velocity in a static run, which begins at rest, found '// &
                   short_text(rock%velocity(1))//' '//short_text(rock%velocity(2))//' '//short_text(rock%velocity(3)))
      end associate
    end do
    do i = 1, size(facts%joint_material)
      associate (joint => scene%joint_material(facts%joint_material(i)))
        where = 'joint material '//number_text(facts%joint_material(i))//': '
        if (joint%friction_angle > 0 .and. joint%friction_angle < least_angle) &
          call add(where//'expected a friction angle of 0 or from '//short_text(least_angle)//' degree, found '// &
                   short_text(joint%friction_angle)//': radians?')
        if (joint%tensile_strength > 0 .and. only_presses(scene%settings%rules)) &
          call add(where//'expected no tensile strength with contact.rules=''conserving'', which only presses, found '// &
                   short_text(joint%tensile_strength))
      end associate
    end do
    warning = [warning, warnings_of_scene(scene, facts%block_material, facts%joint_material)]
    associate (column => facts%column)
      if (column%strain - column%eased > most_strain) &
        call add('expected own weight to compress by at most '//short_text(100*most_strain)//' %, found a strain gamma H/E of '// &
                 short_text(100*(column%strain - column%eased))//' % in block '//number_text(column%block)//' under H = '// &
                 short_text(column%height)//' of rock: units of E or of the unit weight? Soft rock needs an initial stress '// &
                 '(s22, t22) that bears its weight')
    end associate
    do i = 1, size(scene%boundary_loads)
      if (facts%has_weight .and. strain_under(scene, facts, i) > most_strain) &
        call add('expected loads to compress by at most '//short_text(100*most_strain)//' %, found a strain of '// &
                 short_text(100*strain_under(scene, facts, i))//' % under line '//number_text(i)// &
                 ' of boundary.lines: units of E or of the load?')
    end do
    if (facts%penetration > most_penetration*facts%column%width) &
      call add('expected contacts to bear own weight with an overlap of at most '//short_text(100*most_penetration)// &
               ' % of the block, found '//short_text(100*facts%penetration/facts%column%width)//' % of block '// &
               number_text(facts%column%block)//': contact.stiffness or joints.kn too small?')
    if (facts%has_weight .and. .not. any(facts%held)) &
      call add('expected a fixed point or a support, found none: all '//number_text(facts%n_blocks)//' blocks fall')
    do i = 1, size(facts%short_line)
      associate (line => facts%short_line(i))
        call add(scene%geometry_name//':'//number_text(scene%fixed_lines(line%line)%deck_line)// &
                 ': expected a fixed line that crosses edges of a block twice, found one that '// &
                 trim(merge('crosses one edge', 'crosses no edge ', line%crosses))//' and makes one fixed point, '// &
                 place_of(line)//': draw the line across the whole block')
      end associate
    end do
    do i = 1, size(facts%hinge)
      call add('expected a block that is held in two points, found one fixed point, '//place_of(facts%hinge(i))// &
               ', about which the block can turn: add a second fixed point, or lines of &support')
    end do
    do i = 1, size(facts%idle_bolt)
      call add('expected bolts between two blocks, or a block and the ground, found bolt '//number_text(facts%idle_bolt(i))// &
               ' with both ends in one block, whose joints it does not hold')
    end do
    warning = [warning, facts%gap]
    associate (slip => facts%slip)
      if (slip%number > 0) &
        call add('expected joints that bear the shear of the stress before the run (&in_situ), found '// &
                 number_text(slip%number)//' contacts that do not, and slip when it begins: at '// &
                 place_text(slip%position, scene%extent)//' block '//number_text(slip%block)//' has friction and cohesion for '// &
                 short_text(100*slip%borne)//' % of it')
    end associate
    if (size(facts%sliver) > 0) &
      call add('expected no block thinner than 1/100 of its length or sharper than 3 degrees, found '//list_text(facts%sliver))
    if (may_make_energy(scene%settings%rules) .and. scene%settings%strain == strain_small .and. .not. scene%is_static()) &
      call add('expected contact.rules=''coulomb'' in a dynamic run of small strain, found ''shi'': '// &
               'Shi''s contact can make energy without bound there, the more the stiffer its springs')
    if (scene%settings%contact /= contact_none .and. facts%n_blocks > 1) then
      if (scene%settings%scheme == scheme_bathe) call add(another_scheme//'''bathe'': its impacts make energy')
      if (scene%settings%scheme == scheme_generalized_alpha) &
        call add(another_scheme//'''generalized_alpha'': its impacts make energy')
      if (scene%settings%scheme == scheme_central_difference .and. scene%settings%model == model_dda .and. &
          facts%n_blocks > few_blocks) &
        call add('expected integrator.scheme=''small_steps'' or no integrator.scheme for '//number_text(facts%n_blocks)// &
                 ' blocks that may meet, found ''central_difference'': it solves for all contact forces in each of its many steps')
      if (lets_friction_ring(scene)) &
        call add('expected integrator.beta above 0.5 in a dynamic run of small strain with friction, found 0.5: '// &
                 'contact that rings while it rubs can make energy without bound')
    end if
    if (any(facts%side%force > 0)) &
      call add('expected support where the initial stress pushes, found free edges '//side_text(facts))

  contains

    !> Where a point holds a block.
    pure function place_of(hold) result(text)
      type(hold_t), intent(in) :: hold
      character(len=:), allocatable :: text

      text = 'at '//place_text(hold%position, scene%extent)//' in block '//number_text(hold%block)
    end function place_of

    !> Adds a line.
    pure subroutine add(line)
      character(len=*), intent(in) :: line

      call append(warning, line)
    end subroutine add

    !> Adds a doubt where there is one.
    pure subroutine add_doubt(where, doubt)
      character(len=*), intent(in) :: where, doubt

      if (len(doubt) > 0) call add(where//doubt)
    end subroutine add_doubt

  end function warnings_of

  !> Strain of the softest rock under the larger of the loads at the ends of a line, 0 where an initial stress may bear them.
  pure real(dp) function strain_under(scene, facts, line) result(strain)
    type(scene_t), intent(in) :: scene
    type(facts_t), intent(in) :: facts
    integer, intent(in) :: line
    integer :: k

    associate (load => scene%boundary_loads(line), rock => scene%block_material(facts%block_material))
      strain = 0.0_dp
      if (any([(any(abs([rock(k)%stress, rock(k)%stress_gradient]) > 0), k=1, size(rock))])) return
      strain = max(maxval(abs(load%pressure)), norm2(load%traction(:, 1)), norm2(load%traction(:, 2)))/minval(rock%young)
    end associate
  end function strain_under

  !> Sides that the initial stress pushes without support: the force, and the block that has most of it.
  pure function side_text(facts) result(text)
    type(facts_t), intent(in) :: facts
    character(len=:), allocatable :: text
    integer :: i

    text = ''
    do i = 1, n_sides
      if (facts%side(i)%force > 0) &
        text = text//', facing '//trim(side_name(i))//' with '//short_text(facts%side(i)%force)//' force, most of block '// &
               number_text(facts%side(i)%block)
    end do
    text = text(3:)
  end function side_text

  !> Whether the integrator damps nothing of what is stiff, so that the load of sliding contacts swings for ever: with
  !> friction, that is not symmetric, more and more.
  pure logical function lets_friction_ring(scene)
    type(scene_t), intent(in) :: scene

    associate (s => scene%settings)
      lets_friction_ring = s%scheme == scheme_newmark .and. .not. (s%beta > 0.5_dp .or. s%gamma >= 0.5_dp) .and. &
                           s%strain == strain_small .and. .not. scene%is_static() .and. .not. may_make_energy(s%rules) .and. &
                           any(scene%joint_material%friction_angle > 0)
    end associate
  end function lets_friction_ring

end module scree_model_warnings
