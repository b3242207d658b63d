!> All settings of a scene, a row each: name, meaning, unit, range, choices, destination, default. Reader, errors, `explain` and
!> the manual follow them; `setting_rules` says which go together.
!>
!> To add one, write its row here and its component in `settings_t`.
module scree_settings
  use scree_contacts, only: rules_conserving, rules_coulomb, rules_shi
  use scree_deck_options, only: add_option, deck_options_t, is_of_deck
  use scree_deck_text, only: in_quotes
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_kinds, only: dp
  use scree_place_settings, only: visit_places
  use scree_scene, only: &
    contact_augmented, contact_penalty, dialect_auto, iterate_hybrid, iterate_newton, &
    mass_constant, mass_follows_area, model_dda, plane_stress, problems_none, reset_none, rotation_linear, scene_t, &
    scheme_bathe, scheme_central_difference, &
    scheme_energy_decaying, scheme_energy_momentum, scheme_generalized_alpha, scheme_newmark, settings_t, &
    start_dissipative, start_zero, strain_auto, strain_green, strain_rotation, strain_small, test_theta, &
    transport_field, transport_rates, word_t
  use scree_setting_checks, only: check_numbers
  use scree_setting_rows, only: fill_defaults, list_rows, setting_rows_t, store_given
  use scree_setting_table, only: index_of, put_word, setting_t
  implicit none
  private
  public :: fill_settings, set_word, settings_table, store_settings

  integer, parameter :: default_frames = 100

contains

  !> Each row once, in the order in which `explain` and the results print them.
  !>
  !> A default may depend on the numbers of the deck, on what the deck gives, and on the defaults of the rows before it.
  subroutine visit_settings(row, scene)
    type(setting_rows_t), intent(inout) :: row
    type(scene_t), intent(inout) :: scene

    call visit_deck(row, scene%settings)
    call visit_units(row, scene%settings)
    call visit_stage(row, scene%settings)
    call visit_method(row, scene%settings)
    call visit_cover(row, scene%settings)
    call visit_integrator(row, .not. scene%is_static(), scene%settings)
    call visit_step(row, scene)
    call visit_iteration(row, scene%settings)
    call visit_contact(row, scene)
    call visit_contact_states(row, scene%settings)
    call visit_materials(row, scene%settings)
    call visit_joints(row, scene%settings)
    call visit_cracks(row, scene%settings)
    call visit_places(row, largest_modulus(scene), scene%contact_stiffness > 0, scene%settings)
    call visit_ground(row, scene%settings)
    call visit_output(row, scene%settings)
  end subroutine visit_settings

  !> The files, and how to read them.
  subroutine visit_deck(row, s)
    type(setting_rows_t), intent(inout) :: row
    type(settings_t), intent(inout) :: s

    call row%text(setting_t('deck', 'geometry', 'geometry deck or block file, from the folder of the analysis deck', &
                            default='the geometry on the command line'), s%geometry)
    call row%choice(setting_t('deck', 'dialect', &
                              'order of the numbers; auto: short in a deck with groups, otherwise '// &
                              'the order that their count fits', &
                              choices='|auto|short|shi|'), s%dialect, dialect_auto)
    call row%choice(setting_t('deck', 'gaps', &
                              'whether a line of &support, &boundary or &absorbing may lack edges '// &
                              'along a tenth or more of its length', choices='|refuse|allow|'), s%allows_gaps, .false.)
  end subroutine visit_deck

  !> Names of the units that the numbers are in. No number is converted.
  subroutine visit_units(row, s)
    type(setting_rows_t), intent(inout) :: row
    type(settings_t), intent(inout) :: s

    call row%text(setting_t('units', 'length', 'name of the unit of length, such as m', default='none'), s%unit_of_length)
    call row%text(setting_t('units', 'force', 'name of the unit of force, such as N', default='none'), s%unit_of_force)
    call row%text(setting_t('units', 'time', 'name of the unit of time, such as s', default='none'), s%unit_of_time)
  end subroutine visit_units

  !> A stage of a run, which its group begins.
  subroutine visit_stage(row, s)
    type(setting_rows_t), intent(inout) :: row
    type(settings_t), intent(inout) :: s
    logical :: later

    call row%text(setting_t('stage', 'name', 'name of the stage that begins here', default='stage and its number'), &
                  s%stage_name)
    later = allocated(s%stage_name)
    call row%choice(setting_t('stage', 'kind', &
                              'whether steps pass on velocity; with it nothing of &step is taken over from the stage before', &
                              choices='|dynamic|static|', default='as the stage before'), s%static, s%static, when=.false.)
    call row%reals(setting_t('stage', 'remove_blocks', 'numbers of blocks to remove from here on', '1', 1.0_dp), &
                   s%removed_blocks)
    call row%reals(setting_t('stage', 'remove_materials', &
                             'block materials; all blocks of these are removed from here on', '1', 1.0_dp), &
                   s%removed_materials)
    call row%reals(setting_t('stage', 'remove_inside', &
                             'x y of the corners of polygons, each closed by its first corner; blocks inside are removed', &
                             'length'), s%removed_inside)
    call row%choice(setting_t('stage', 'reset', 'velocities to set to 0, displacements and rotations to count from here', &
                              choices='|none|velocities|displacements|both|'), s%reset, reset_none, when=later)
    call row%choice(setting_t('stage', 'loose', &
                              'static stages with step.balance: whether a block that moves on and on ends the run', &
                              choices='|stop|go on|'), s%goes_on_without_loose, .false., when=later)
  end subroutine visit_stage

  !> Settings of the model.
  subroutine visit_method(row, s)
    type(setting_rows_t), intent(inout) :: row
    type(settings_t), intent(inout) :: s

    call row%choice(setting_t('method', 'preset', 'shi: the methods of Shi''s programs; a setting beside it wins', &
                              choices='|none|shi|'), s%shi, .false.)
    call row%choice(setting_t('method', 'model', 'DDA blocks, or manifold elements', choices='|dda|nmm|'), s%model, model_dda)
    call row%choice(setting_t('method', 'strain', &
                              'strain measure; auto: Green strain in elements and steps for which small strain is not enough', &
                              choices='|small|green|auto|strain_rotation|', &
                              default='auto; small with preset shi, a rotation, central_difference and small_steps; '// &
                              'green with rules conserving'), &
                    s%strain, default_strain(s))
    call row%real(setting_t('method', 'accuracy', 'largest error of a strain in a step for which strain auto takes small strain', &
                            '1', 0.0_dp, 1.0_dp), s%accuracy, 1e-8_dp, when=s%strain == strain_auto)
    call row%choice(setting_t('method', 'rotation', &
                              'displacement of a block of small strain that turns: its linear '// &
                              'field, or a published cure of its growth', &
                              choices='|linear|exact|adjusted|second_order|trigonometric|exponential|'), &
                    s%rotation, rotation_linear)
    call row%choice(setting_t('method', 'plane', &
                              'plane stress or plane strain: the meaning of E and nu', choices='|stress|strain|'), &
                    s%plane, plane_stress)
    call row%choice(setting_t('method', 'mass', 'mass of a block: constant, or density times its present area', &
                              choices='|constant|follows_area|', default='constant; follows_area with preset shi'), &
                    s%mass, merge(mass_follows_area, mass_constant, s%shi))
  end subroutine visit_method

  !> The mathematical mesh.
  subroutine visit_cover(row, s)
    type(setting_rows_t), intent(inout) :: row
    type(settings_t), intent(inout) :: s
    logical :: regular

    call row%real(setting_t('cover', 'edge', 'edge of the triangles of a regular mathematical mesh', 'length', 0.0_dp, &
                            open=.true., default='none: a triangle for each block'), s%cover_edge)
    regular = s%cover_edge > 0
    call row%pair(setting_t('cover', 'origin', 'a node of the regular mesh', 'length'), s%cover_origin, [0.0_dp, 0.0_dp], &
                  when=regular)
    call row%real(setting_t('cover', 'angle', &
                            'angle of one family of edges of the regular mesh against the x axis', 'degree', -360.0_dp, 360.0_dp), &
                  s%cover_angle, 0.0_dp, when=regular)
    call row%text(setting_t('cover', 'mesh', &
                            'file with a mesh of triangles, Gmsh 4.1, from the folder of the analysis deck'), s%cover_mesh)
    call row%real(setting_t('cover', 'least', &
                            'least area of an element over that of its triangle at which it has its own covers', '1', &
                            0.0_dp, 1.0_dp), s%least_share, 0.1_dp, when=regular .or. allocated(s%cover_mesh))
    call row%choice(setting_t('cover', 'order', 'order of the cover functions; 1: displacements of second order', &
                              choices='|0|1|'), s%second_order, .false., when=regular .or. allocated(s%cover_mesh))
  end subroutine visit_cover

  !> The integrator in time.
  subroutine visit_integrator(row, dynamic, s)
    type(setting_rows_t), intent(inout) :: row
    logical, intent(in) :: dynamic !! steps hand velocity on
    type(settings_t), intent(inout) :: s

    call row%choice(setting_t('integrator', 'scheme', 'integrator of the equations of motion', &
                              choices='|newmark|energy_momentum|energy_decaying|generalized_alpha|central_difference|bathe|'// &
                              'small_steps|', &
                              default='newmark with small strain and strain_rotation, with gamma and in static runs; '// &
                              'else energy_decaying; energy_momentum with rules conserving'), &
                    s%scheme, default_scheme(dynamic, row%given('integrator.gamma'), s))
    call row%real(setting_t('integrator', 'beta', &
                            'weight of the new acceleration in the velocity; 1/2 + chi of the energy_... schemes', &
                            '1', 0.5_dp, 1.0_dp), s%beta, 1.0_dp, &
                  when=s%scheme <= scheme_energy_decaying)
    call row%real(setting_t('integrator', 'rho', 'spectral radius of generalized_alpha at infinite frequency', '1', 0.0_dp, &
                            1.0_dp), s%rho, 0.5_dp, when=s%scheme == scheme_generalized_alpha)
    call row%real(setting_t('integrator', 'gamma', 'weight of the new acceleration in the displacement', '1', 0.0_dp, &
                            open=.true., default='(beta + 1/2)^2/4; 1/2 with beta 1 and preset shi'), &
                  s%gamma, merge(0.5_dp, (s%beta + 0.5_dp)**2/4, s%shi .and. .not. s%beta < 1), &
                  when=s%scheme == scheme_newmark)
    call row%choice(setting_t('integrator', 'start', &
                              'acceleration before the first step: zero, that of a first step with beta 1, or a consistent one', &
                              choices='|zero|dissipative|acceleration|consistent|', &
                              default='dissipative where beta < 1 and with generalized_alpha and bathe, else zero'), &
                    s%start, merge(start_dissipative, start_zero, &
                                   s%beta < 1 .or. any(s%scheme == [scheme_generalized_alpha, scheme_bathe])))
    call row%choice(setting_t('integrator', 'transport', 'velocity of a DDA block: a vector field, or Shi''s six rates', &
                              choices='|field|rates|', default='rates with small strain and model dda, else field'), &
                    s%transport, merge(transport_rates, transport_field, s%strain == strain_small .and. s%model == model_dda))
  end subroutine visit_integrator

  !> A new deck takes small strain where it is as good as Green strain, and nowhere else.
  pure integer function default_strain(s) result(strain)
    type(settings_t), intent(in) :: s

    strain = strain_auto
    if (s%rules == rules_conserving) strain = strain_green
    if (s%shi .or. s%rotation /= rotation_linear .or. s%scheme == scheme_central_difference) strain = strain_small
    if (s%takes_small_steps()) strain = strain_small
  end function default_strain

  !> Stiff contacts are to die out in a scene that is left to itself; but energy that is asked to stay stays. A static run is to
  !> balance where a step ends, not in its middle.
  pure integer function default_scheme(dynamic, has_gamma, s) result(scheme)
    logical, intent(in) :: dynamic   !! steps hand velocity on
    logical, intent(in) :: has_gamma !! the scene gives a weight that newmark alone has
    type(settings_t), intent(in) :: s

    scheme = scheme_newmark
    if (any(s%strain == [strain_small, strain_rotation]) .or. has_gamma) return
    if (s%rules == rules_conserving) scheme = scheme_energy_momentum
    if (s%rules /= rules_conserving .and. dynamic) scheme = scheme_energy_decaying
  end function default_scheme

  !> The size of a step and the end of the run.
  subroutine visit_step(row, scene)
    type(setting_rows_t), intent(inout) :: row
    type(scene_t), intent(inout) :: scene
    logical :: counts !! it is the number of steps that ends the run, not their time
    integer :: steps

    counts = scene%settings%chooses_step .or. scene%settings%balance > 0
    associate (s => scene%settings)
      call row%real(setting_t('step', 'size', 'largest step; with step.balance the first step', 'time', 0.0_dp, open=.true., &
                              default='g1 of the deck'), &
                    s%step_size, scene%step_size)
      call row%whole(setting_t('step', 'count', 'number of steps after which the run ends', '1', 1.0_dp, 1e9_dp, &
                               default='none; n5 with balance and control shi'), &
                     s%most_steps, max(1, scene%n_steps), when=counts)
      steps = scene%n_steps
      if (s%most_steps < huge(steps)) steps = max(steps, s%most_steps)
      call row%real(setting_t('step', 'end_time', 'time at which the run ends', 'time', 0.0_dp, open=.true., &
                              default='n5 steps of the size, or count if that is more; none with balance and control shi'), &
                    s%end_time, steps*s%step_size, when=.not. counts)
      call row%real(setting_t('step', 'travel', &
                              'largest displacement of a vertex in a step over half the size of the model; a longer step is cut', &
                              '1', &
                              0.0_dp, open=.true., default='none; g2 with control shi'), &
                    s%travel, scene%displacement_ratio, when=s%chooses_step)
      call row%choice(setting_t('step', 'control', &
                                'constant steps, or steps of Shi''s programs, which keep the displacement', &
                                choices='|fixed|shi|'), s%chooses_step, .false.)
      call row%real(setting_t('step', 'accuracy', &
                              'largest error of the displacement at the end over the displacement; '// &
                              'the run chooses its steps for it', '1', &
                              0.0_dp, 1.0_dp, .true., default='none: steps of step.size; 0.01 with small_steps'), s%aim)
      if (s%takes_small_steps() .and. s%aim > 0) then ! small steps choose their size by it, not the step of the run
        s%run_out = s%aim
        s%aim = 0.0_dp
      end if
      call row%real(setting_t('step', 'overlap', &
                              'deepest overlap of moving blocks over their size; small steps choose their size for it', '1', &
                              0.0_dp, 1.0_dp, .true., default='none: step.accuracy chooses it'), s%step_overlap)
      call row%real(setting_t('step', 'least', &
                              'smallest step; a run that would need a smaller one ends', 'time', 0.0_dp, open=.true., &
                              default='1e-6 of the size, 1e-12 with balance'), &
                    s%least_step, merge(1e-12_dp, 1e-6_dp, s%balance > 0)*s%step_size)
      call row%real(setting_t('step', 'balance', &
                              'force out of balance on a body over its weight and loads with which a static run ends', '1', &
                              0.0_dp, 1.0_dp, .true., default='none: a static run takes all its steps'), s%balance)
      call row%real(setting_t('step', 'past_peak', &
                              'force of moving supports over its largest at which the run ends', '1', &
                              0.0_dp, 1.0_dp, .true., default='none: the run goes on after the peak'), s%past_peak)
      call row%real(setting_t('step', 'sleep', &
                              'force over weight, and speed over sqrt(g size), below which bodies at rest fall asleep; 0: never', &
                              '1', 0.0_dp, 1.0_dp, default='1e-8 where there are weight and contact, in a dynamic run'), &
                    s%sleep, 1e-8_dp)
    end associate
  end subroutine visit_step

  !> The iteration of a step with Green strain.
  subroutine visit_iteration(row, s)
    type(setting_rows_t), intent(inout) :: row
    type(settings_t), intent(inout) :: s

    call row%choice(setting_t('iteration', 'method', &
                              'matrix with Green strain: secant, tangent, or secant first and tangent near the end', &
                              choices='|secant|newton|hybrid|', default='hybrid; newton with step.balance'), &
                    s%iterate, merge(iterate_newton, iterate_hybrid, s%balance > 0))
    call row%choice(setting_t('iteration', 'test', &
                              'what must converge: the displacement gradient theta, or the residual of the forces', &
                              choices='|theta|residual|'), s%test, test_theta)
    call row%real(setting_t('iteration', 'tolerance', &
                            'largest change of theta, or largest force out of balance over the largest force', '1', &
                            0.0_dp, 1.0_dp, .true., default='1e-10 for theta, 1e-7 with step.balance; 1e-9 for residual'), &
                  s%tolerance, merge(merge(1e-7_dp, 1e-10_dp, s%balance > 0), 1e-9_dp, s%test == test_theta))
    call row%whole(setting_t('iteration', 'most', 'iterations after which the step is cut', '1', 1.0_dp, 1e6_dp), &
                   s%most_iterations, 25)
    call row%real(setting_t('iteration', 'relaxation', 'factor of each correction by the secant, where nothing touches', '1', &
                            0.0_dp, 1.0_dp, .true.), s%relaxation, 1.0_dp)
    call row%whole(setting_t('iteration', 'anderson', &
                             'number of earlier corrections that a correction by the secant is mixed with, where nothing touches', &
                             '1', &
                             0.0_dp, 20.0_dp), s%anderson, 0)
  end subroutine visit_iteration

  !> The forces of contact.
  subroutine visit_contact(row, scene)
    type(setting_rows_t), intent(inout) :: row
    type(scene_t), intent(inout) :: scene

    associate (s => scene%settings)
      call row%choice(setting_t('contact', 'method', 'springs, springs with multipliers, or no contact between bodies', &
                                choices='|penalty|augmented|none|'), s%contact, contact_penalty)
      call row%real(setting_t('contact', 'stiffness', &
                              'normal stiffness of a contact, per unit thickness; of a bond, by the '// &
                              'length of joint of its contact', 'force/length', 0.0_dp, &
                              open=.true., default='g0 of the deck, or 5 times the largest E; 50 times with preset shi'), &
                    s%contact_stiffness, merge(scene%contact_stiffness, merge(50, 5, s%shi)*largest_modulus(scene), &
                                               scene%contact_stiffness > 0))
      call row%real(setting_t('contact', 'shear_ratio', 'normal stiffness of a contact over its shear stiffness', '1', 0.0_dp, &
                              open=.true.), s%shear_ratio, 2.5_dp)
      call row%real(setting_t('contact', 'overlap', 'largest overlap that method augmented leaves', 'length', 0.0_dp, open=.true., &
                              default='1e-7 of the size of the model'), &
                    s%overlap, 1e-7_dp*scene%extent, when=s%contact == contact_augmented)
      call row%real(setting_t('contact', 'initial', 'largest initial overlap of two blocks over the size of the smaller one', '1', &
                              0.0_dp, 1.0_dp), s%initial_overlap, 0.02_dp)
      call row%real(setting_t('contact', 'restitution', 'normal velocity after an impact over that before', '1', 0.0_dp, 1.0_dp, &
                              default='none: what the springs give back'), s%restitution)
      call row%real(setting_t('contact', 'viscosity', 'viscosity of a dashpot across a closed contact, per unit thickness', &
                              'force time/length', 0.0_dp), s%viscosity)
    end associate
  end subroutine visit_contact

  !> When contacts open, close and slide.
  subroutine visit_contact_states(row, s)
    type(setting_rows_t), intent(inout) :: row
    type(settings_t), intent(inout) :: s

    call row%choice(setting_t('contact', 'rules', &
                              'Coulomb''s rules; the same with forces that conserve energy; or the rules of Shi''s programs', &
                              choices='|coulomb|conserving|shi|', default='coulomb; shi with preset shi and method penalty'), &
                    s%rules, merge(rules_shi, rules_coulomb, s%shi .and. s%contact == contact_penalty))
    call row%choice(setting_t('contact', 'adapt', &
                              'constant stiffness, or one that follows gaps and overlaps as in Shi''s programs', &
                              choices='|none|shi|'), s%adapts_stiffness, .false.)
    call row%choice(setting_t('contact', 'coupling', &
                              'contacts and deformation in one iteration, or contacts settled '// &
                              'within each iteration of deformation', &
                              choices='|merged|nested|'), s%nested, .false.)
  end subroutine visit_contact_states

  !> Settings of block materials, in place of numbers of the deck.
  subroutine visit_materials(row, s)
    type(setting_rows_t), intent(inout) :: row
    type(settings_t), intent(inout) :: s

    call row%reals(setting_t('materials', 'young', &
                             'Young''s modulus of each block material', &
                             'force/length^2', 0.0_dp, open=.true., default='numbers of the deck'), s%young)
    call row%reals(setting_t('materials', 'poisson', &
                             'Poisson''s ratio of each block material', &
                             '1', -0.9999_dp, 0.4999_dp, default='numbers of the deck'), &
                   s%poisson)
    call row%reals(setting_t('materials', 'unit_weight', &
                             'unit weight of each block material', 'force/length^3', &
                             default='numbers of the deck'), s%unit_weight)
  end subroutine visit_materials

  !> When cracks grow.
  subroutine visit_cracks(row, s)
    type(setting_rows_t), intent(inout) :: row
    type(settings_t), intent(inout) :: s

    call row%reals(setting_t('cracks', 'strength', &
                             'mean tension before a tip at which it grows in each block material; 0: it does not', &
                             'force/length^2', 0.0_dp), s%crack_strength)
    call row%reals(setting_t('cracks', 'toughness', &
                             'fracture toughness K_Ic at which a tip grows in each block material; 0: it does not', &
                             'force/length^(3/2)', 0.0_dp), s%crack_toughness)
    call row%real(setting_t('cracks', 'length', 'radius of the half disc over which that tension is averaged', 'length', &
                            0.0_dp, open=.true.), s%crack_length)
    call row%whole(setting_t('cracks', 'begin_joint', &
                             'joint material of cracks that begin at outlines by that tension; 0: none does', &
                             '1', 0.0_dp, 1e6_dp), s%crack_begin_joint, 0)
    call row%whole(setting_t('cracks', 'parts', 'blocks that may break off; the results have room for them', '1', 0.0_dp, 1e6_dp, &
                             default='100 where cracks may grow'), s%crack_parts, 100, when=s%cracks_may_grow())
  end subroutine visit_cracks

  !> Settings of joint materials, beside their row of the deck.
  subroutine visit_joints(row, s)
    type(setting_rows_t), intent(inout) :: row
    type(settings_t), intent(inout) :: s

    call row%reals(setting_t('joints', 'phi', 'friction angle of each joint material', &
                             'degree', 0.0_dp, 89.9_dp, default='numbers of the deck'), s%joint_phi)
    call row%reals(setting_t('joints', 'cohesion', &
                             'cohesion of each joint material', &
                             'force/length^2', 0.0_dp, &
                             default='numbers of the deck'), s%joint_c)
    call row%reals(setting_t('joints', 'tensile_strength', &
                             'tensile strength of each joint material', &
                             'force/length^2', 0.0_dp, &
                             default='numbers of the deck'), s%joint_t)
    call row%reals(setting_t('joints', 'energy', &
                             'energy that a bond takes as it opens; 0: it breaks at once', &
                             'force/length', 0.0_dp), s%joint_energy)
    call row%reals(setting_t('joints', 'shear_energy', &
                             'energy that a bond takes as it shears; 0: it breaks at once', &
                             'force/length', 0.0_dp), s%joint_shear_energy)
    call row%reals(setting_t('joints', 'kn', &
                             'normal stiffness of each joint material; 0: contact.stiffness', &
                             'force/length^3', 0.0_dp), s%joint_kn)
    call row%reals(setting_t('joints', 'ks', &
                             'shear stiffness of each joint material; '// &
                             'without it kn over contact.shear_ratio', &
                             'force/length^3', 0.0_dp), s%joint_ks)
    call row%reals(setting_t('joints', 'restitution', &
                             'restitution of impacts, in place of contact.restitution', '1', 0.0_dp, most=1.0_dp, &
                             default='contact.restitution'), s%joint_restitution)
    call row%reals(setting_t('joints', 'residual_phi', &
                             'residual friction angle of each joint material, after residual_slip', 'degree', &
                             0.0_dp, most=89.0_dp), s%worn_angle)
    call row%reals(setting_t('joints', 'residual_slip', &
                             'slip over which friction falls to residual_phi; 0: it does not fall', &
                             'length', &
                             0.0_dp), s%worn_slip)
    call row%reals(setting_t('joints', 'residual_c', &
                             'cohesion of contacts that are not bonded; '// &
                             'with a friction of at most 70 degrees', &
                             'force/length^2', 0.0_dp), s%worn_cohesion)
    call row%reals(setting_t('joints', 'jrc', &
                             'joint roughness coefficient of Barton; 0: smooth', '1', 0.0_dp, &
                             most=30.0_dp), s%jrc)
    call row%reals(setting_t('joints', 'jcs', &
                             'joint wall compressive strength of Barton', &
                             'force/length^2', 0.0_dp), s%jcs)
    call row%reals(setting_t('joints', 'closure', &
                             'largest closure of a joint whose stiffness begins with kn and grows; 0: linear', &
                             'length', 0.0_dp), s%joint_closure)
    call row%reals(setting_t('joints', 'dilation', 'dilation angle of each joint material', 'degree', &
                             0.0_dp, most=89.0_dp), s%dilation)
    call row%reals(setting_t('joints', 'dilation_slip', &
                             'slip after which a joint dilates no more', 'length', 0.0_dp), &
                   s%dilation_slip)
  end subroutine visit_joints

  !> Settings of the ground and of damping.
  subroutine visit_ground(row, s)
    type(setting_rows_t), intent(inout) :: row
    type(settings_t), intent(inout) :: s

    call row%real(setting_t('gravity', 'ramp', &
                            'time from the start in which the weight grows from 0', 'time', 0.0_dp, default='0'), &
                  s%gravity_ramp)
    call row%reals(setting_t('acceleration', 'table', 't ax ay at ascending times: acceleration of the ground'), s%ground_table)
    call row%text(setting_t('acceleration', 'file', &
                            'file with lines t ax ay, or PEER record (.at2) along x, from the folder of the analysis deck'), &
                  s%ground_file)
    call row%text(setting_t('acceleration', 'vertical', &
                            'PEER record (.at2) along y, from the folder of the analysis deck'), s%ground_vertical)
    call row%real(setting_t('acceleration', 'scale', 'factor of ax and ay, in units of the deck', '1'), s%ground_scale, 1.0_dp, &
                  when=allocated(s%ground_table) .or. allocated(s%ground_file))
    call row%real(setting_t('damping', 'mass', 'alpha of the damping force -alpha M v', '1/time', 0.0_dp, &
                            default='0'), s%mass_damping)
    call row%real(setting_t('damping', 'stiffness', 'beta of the damping force -beta K v of the rock', 'time', 0.0_dp, &
                            default='0'), s%stiffness_damping)
    call row%real(setting_t('damping', 'fraction', 'fraction of critical damping at damping.frequency, half of it by stiffness', &
                            '1', 0.0_dp, default='0'), s%damping_fraction)
    call row%real(setting_t('damping', 'frequency', 'frequency at which damping.fraction is least', '1/time', 0.0_dp, open=.true., &
                            default='0'), s%damping_frequency)
  end subroutine visit_ground

  !> The frames of the results.
  subroutine visit_output(row, s)
    type(setting_rows_t), intent(inout) :: row
    type(settings_t), intent(inout) :: s

    call row%whole(setting_t('output', 'every', 'number of steps from frame to frame', '1', 1.0_dp, 1e9_dp, &
                             default='about 100 frames, even in time; by count with step.balance and control shi'), &
                   s%frame_every, 1 + (s%most_steps - 1)/default_frames, &
                   when=(s%chooses_step .or. s%balance > 0) .and. .not. s%frame_interval > 0)
    call row%real(setting_t('output', 'interval', &
                            'time from frame to frame, which steps meet exactly; in place of output.every', 'time', 0.0_dp, &
                            open=.true.), s%frame_interval)
    call row%choice(setting_t('output', 'error', 'estimate of the error of the steps', choices='|none|estimate|', &
                              default='none; estimate with step.accuracy'), s%estimates_error, s%aim > 0)
    call row%choice(setting_t('output', 'cracks', 'stress intensity factors of the tips of cracks, in each step', &
                              choices='|none|tips|', default='none'), s%measures_tips, .false.)
    call row%choice(setting_t('output', 'problems', &
                              'friction problems to write for tools/bench problems: those that were not solved, or all', &
                              choices='|none|failed|all|'), s%problems, problems_none)
    call row%whole(setting_t('output', 'checkpoint', &
                             'number of frames from checkpoint to checkpoint; the last frame always has one', &
                             '1', 1.0_dp, 1e9_dp), s%checkpoint_every)
  end subroutine visit_output

  !> Table of all settings.
  function settings_table() result(table)
    type(setting_t), allocatable :: table(:)
    type(setting_rows_t) :: row
    type(scene_t) :: nothing

    row%purpose = list_rows
    call visit_settings(row, nothing)
    call move_alloc(row%table, table)
  end function settings_table

  !> Takes GROUP.NAME=VALUE of the command line, over what the deck says. THING.NAME=VALUE, a number of the decks, is kept for who
  !> reads them. Errors as of `read_groups`.
  subroutine set_word(option, words, numbers, error)
    character(len=*), intent(in) :: option
    type(word_t), intent(inout) :: words(:)
    type(deck_options_t), intent(inout) :: numbers
    type(error_t), allocatable, intent(out) :: error
    type(word_t) :: given
    integer :: dot, equal, i

    equal = index(option, '=')
    dot = index(option(:max(equal - 1, 0)), '.')
    if (dot < 2 .or. equal < dot + 2 .or. equal == len(option)) then
      call fail(error, status_bad_input, '--set: expected GROUP.NAME=VALUE, found '//in_quotes(option))
      return
    end if
    given%name = option(:equal - 1)
    given%value = with_single_blanks(option(equal + 1:))
    given%from = '--set'
    i = index_of(words, given%name)
    if (i > 0) then
      if (allocated(words(i)%value)) deallocate (words(i)%value)
    else if (is_of_deck(given%name)) then
      call add_option(option, numbers)
      return
    end if
    call put_word(settings_table(), '--set '//option//': ', given, words, error)
  end subroutine set_word

  !> Numbers with one blank between them, as groups hand them on; any other text as it is.
  pure function with_single_blanks(text)
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: with_single_blanks
    integer :: i

    with_single_blanks = text
    if (verify(text, ' +-.0123456789dDeE') > 0) return
    with_single_blanks = trim(adjustl(text))
    do
      i = index(with_single_blanks, '  ')
      if (i == 0) return
      with_single_blanks = with_single_blanks(:i)//with_single_blanks(i + 2:)
    end do
  end function with_single_blanks

  !> Puts the values that are given where they belong. Whatever is not given stays as it is.
  subroutine store_settings(scene)
    type(scene_t), intent(inout) :: scene

    call pass_over(store_given, scene)
  end subroutine store_settings

  !> Gives every name that has no value its default, and makes the settings of the scene complete.
  !>
  !> The numbers of the classic deck must have been read, and the given values stored. Errors: numbers that contradict each other;
  !> `setting_rules` has the choices that do.
  subroutine fill_settings(scene, error)
    type(scene_t), intent(inout) :: scene
    type(error_t), allocatable, intent(out) :: error

    call pass_over(fill_defaults, scene)
    associate (s => scene%settings)
      s%loads_at_end = s%shi .or. scene%is_static()
      if (s%travel < huge(s%travel)) s%most_travel = 0.5_dp*scene%extent*s%travel
      if (s%frame_every == 0 .and. .not. s%frame_interval > 0) &
        s%frame_spacing = min(s%end_time, s%most_steps*s%step_size)/default_frames
    end associate
    call check_numbers(scene, error)
  end subroutine fill_settings

  !> One pass over the rows with the words of a scene.
  subroutine pass_over(purpose, scene)
    integer, intent(in) :: purpose
    type(scene_t), intent(inout) :: scene
    type(setting_rows_t) :: row

    row%purpose = purpose
    call move_alloc(scene%words, row%words)
    call visit_settings(row, scene)
    call move_alloc(row%words, scene%words)
  end subroutine pass_over

  !> The largest modulus E of the block materials, 0 without any; force/length^2.
  pure real(dp) function largest_modulus(scene)
    type(scene_t), intent(in) :: scene

    largest_modulus = 0.0_dp
    if (allocated(scene%block_material)) largest_modulus = maxval(scene%block_material%young)
  end function largest_modulus

end module scree_settings
