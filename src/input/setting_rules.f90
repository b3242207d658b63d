!> Which settings go together. One table says it; the refusal of a deck, `explain --settings` and the manual follow it.
!>
!> Without such a rule two settings would contradict each other, as contact that conserves energy and springs whose stiffness
!> changes, or one would have no effect that its writer may believe in.
module scree_setting_rules
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_kinds, only: dp
  use scree_scene, only: scene_t, word_t
  use scree_setting_table, only: given_at, index_of, is_given_by
  use scree_text, only: real_of, real_text
  implicit none
  private
  public :: check_rules, condition_text, drop_idle, drop_overridden, setting_rules, subject_text

  !> What may be asked of the other setting but one of some choices: that it has a value in the deck, that it has none, that it
  !> is a number above 0, or 0.
  character(len=*), parameter :: is_given = 'given', is_not_given = 'not given', is_positive = 'above 0', is_zero = '0'

  !> Some settings, or a choice of one, go only with another setting.
  type :: setting_rule_t
    character(len=180) :: names  !! group.name; several between ', '
    character(len=60) :: value   !! the choice that the rule is about, or several between bars; '': whatever the deck gives
    character(len=40) :: other   !! group.name, several between ' or '; or g2 or k01 of the numbers of the deck
    character(len=70) :: allowed !! choices between bars, or one of the conditions above
    logical :: idle              !! true: settings that break the rule do nothing; false: they do harm
    character(len=102) :: why
  end type setting_rule_t

  !> Displacements of a block of small strain that are not its linear field.
  character(len=*), parameter :: cures = 'exact|adjusted|second_order|trigonometric|exponential'
  !> What makes cracks grow.
  character(len=*), parameter :: grows = 'cracks.strength, cracks.toughness'
  !> Integrators to compare with.
  character(len=*), parameter :: compared = 'generalized_alpha|bathe|central_difference'

  ! A statement has at most 255 continuations in Fortran 2008.
  type(setting_rule_t), parameter :: rules_before_contact(*) = [ &
    setting_rule_t('units.length', '', 'units.force', is_given, .false., 'a stress needs the names of both'), &
    setting_rule_t('units.force', '', 'units.length', is_given, .false., 'a stress needs the names of both'), &
    setting_rule_t('units.time', '', 'units.length', is_given, .false., 'a speed needs the names of both'), &
    setting_rule_t('method.rotation', cures, 'method.strain', '|small|', .true., &
                   'with Green strain the whole linear field moves a block'), &
    setting_rule_t('method.accuracy', '', 'method.strain', '|auto|', .true., 'the other strain measures choose nothing'), &
    setting_rule_t('method.rotation', cures, 'method.model', '|dda|', .true., 'covers have no rotation of their own'), &
    setting_rule_t('cover.edge, cover.mesh, cover.origin, cover.angle, cover.least, cover.order', '', &
                   'method.model', '|nmm|', .true., 'a DDA block has its own field, and no mesh'), &
    setting_rule_t('cover.mesh', '', 'cover.edge', is_not_given, .true., 'a scene has one mesh'), &
    setting_rule_t('cover.origin, cover.angle', '', 'cover.edge', is_given, .true., 'they place the regular mesh'), &
    setting_rule_t('cover.least', '', 'cover.edge or cover.mesh', is_given, .true., 'it is relative to the triangles of a mesh'), &
    setting_rule_t('cover.order', '', 'cover.edge or cover.mesh', is_given, .true., 'it is the order of covers of a mesh'), &
    setting_rule_t('cover.order', '1', 'integrator.scheme', '|newmark|energy_momentum|energy_decaying|', .false., &
                   'cells have no lumped mass matrix for explicit steps'), &
    setting_rule_t('cover.order', '1', 'step.accuracy', is_not_given, .false., 'the estimate of the error assumes linear fields'), &
    setting_rule_t('cover.order', '1', 'output.error', '|none|', .false., 'the estimate of the error assumes linear fields'), &
    setting_rule_t('cover.order', '1', 'boundary.pressure', is_not_given, .false., 'pressure is integrated over straight edges'), &
    setting_rule_t('cover.order', '1', 'water.table', is_not_given, .false., 'pressure is integrated over straight edges'), &
    setting_rule_t('cover.order', '1', 'scene.rectangle', is_not_given, .false., 'cells are those of one model'), &
    setting_rule_t('cover.order', '1', 'absorbing.lines', is_not_given, .false., 'absorbing edges must stay straight'), &
    setting_rule_t('cover.order', '1', 'absorbing.base', is_not_given, .false., 'absorbing edges must stay straight'), &
    setting_rule_t('integrator.scheme', 'energy_momentum', 'method.strain', '|green|auto|', .false., &
                   'it conserves the energy of Green strain'), &
    setting_rule_t('integrator.scheme', 'energy_decaying', 'method.strain', '|green|auto|', .false., &
                   'it dissipates the energy of Green strain'), &
    setting_rule_t('integrator.beta', '', 'integrator.scheme', '|newmark|energy_momentum|energy_decaying|', .true., &
                   'the other schemes have their own weights'), &
    setting_rule_t('integrator.gamma', '', 'integrator.scheme', '|newmark|', .true., 'the other schemes have their own weight'), &
    setting_rule_t('integrator.rho', '', 'integrator.scheme', '|generalized_alpha|', .true., &
                   'the other schemes have no spectral radius to choose'), &
    setting_rule_t('integrator.start', 'acceleration', 'integrator.scheme', &
                   '|newmark|energy_decaying|generalized_alpha|bathe|', .true., &
                   'the other schemes store no acceleration, or compute it when a step begins'), &
    setting_rule_t('integrator.start', 'dissipative|consistent', 'integrator.scheme', &
                   '|newmark|energy_momentum|energy_decaying|generalized_alpha|bathe|', .true., &
                   'explicit steps compute the acceleration when they begin'), &
    setting_rule_t('integrator.transport', 'rates', 'method.model', '|dda|', .false., 'covers carry a velocity field'), &
    setting_rule_t('step.control', 'shi', 'step.travel', is_positive, .false., 'it chooses steps to keep that displacement'), &
    setting_rule_t('step.accuracy', '', 'k01', is_positive, .false., 'a static step has no error in time'), &
    setting_rule_t('step.accuracy', '', 'step.control', '|fixed|', .false., 'Shi''s rules choose steps by displacement'), &
    setting_rule_t('step.accuracy', '', 'method.preset', '|none|', .false., &
                   'the preset is for comparison with Shi''s programs, step by step'), &
    setting_rule_t('step.accuracy', '', 'contact.rules', '|coulomb|conserving|', .false., &
                   'Shi''s contact has no limit as steps get small'), &
    setting_rule_t('step.accuracy', '', 'output.error or integrator.scheme', '|estimate|small_steps|', .false., &
                   'it chooses steps by that estimate'), &
    setting_rule_t('step.accuracy', '', 'step.overlap', is_not_given, .false., 'each of the two chooses the size of small steps'), &
    setting_rule_t('step.overlap', '', 'integrator.scheme', '|small_steps|', .true., 'the other schemes bound overlap by forces'), &
    setting_rule_t('output.error', 'estimate', 'k01', is_positive, .true., 'a static step has no error in time'), &
    setting_rule_t('output.error', 'estimate', 'integrator.scheme', '|newmark|energy_momentum|energy_decaying|', .false., &
                   'the estimate does not know the errors of the other schemes'), &
    setting_rule_t('output.error', 'estimate', 'method.strain', '|small|green|auto|', .false., &
                   'the estimate does not know the error of the decomposition'), &
    setting_rule_t('output.error', 'estimate', 'method.rotation', '|linear|exact|', .false., &
                   'the estimate does not know the errors of the other cures'), &
    setting_rule_t('step.balance', '', 'k01', is_zero, .false., 'a dynamic run does not end in equilibrium'), &
    setting_rule_t('step.balance', '', 'step.control', '|fixed|', .false., 'Shi''s rules choose steps by displacement'), &
    setting_rule_t('step.past_peak', '', 'step.balance', is_not_given, .false., &
                   'equilibrium needs supports that are at rest'), &
    setting_rule_t('step.past_peak', '', 'k01', is_zero, .false., 'in motion forces of supports swing'), &
    setting_rule_t('step.sleep', '', 'k01', is_positive, .false., 'a static step has no speed by which to judge rest'), &
    setting_rule_t('step.sleep', '', 'step.control', '|fixed|', .false., 'Shi''s rules treat all bodies in every step'), &
    setting_rule_t('step.sleep', '', 'contact.method', '|penalty|augmented|', .true., &
                   'without contact nothing could wake a body'), &
    setting_rule_t('step.sleep', '', 'contact.rules', '|coulomb|conserving|', .false., &
                   'Shi''s rules treat all bodies in every step'), &
    setting_rule_t('iteration.method, iteration.test, iteration.tolerance, iteration.relaxation, '// &
                   'iteration.anderson', '', 'method.strain', '|green|auto|strain_rotation|', .true., &
                   'small strain is linear, so its first solution is exact'), &
    setting_rule_t('boundary.pressure, boundary.traction', '', 'boundary.lines', is_given, .true., 'there is nothing to load'), &
    setting_rule_t('boundary.ramp', '', 'boundary.lines or water.table', is_given, .true., 'there is no load that grows'), &
    setting_rule_t('bolt_row.number', '', 'bolt_row.spacing', is_not_given, .false., 'each of the two gives the other'), &
    setting_rule_t('bolt_row.spacing, bolt_row.number, bolt_row.length, bolt_row.direction, bolt_row.stiffness', '', &
                   'bolt_row.line', is_given, .true., 'there is no row'), &
    setting_rule_t('bolt_row.pretension, bolt_row.strength, bolt_row.shear_stiffness, bolt_row.shear_strength', '', &
                   'bolt_row.line', is_given, .true., 'there is no row'), &
    setting_rule_t('bolt_row.line', '', 'bolt_row.spacing or bolt_row.number', is_given, .false., &
                   'the number of bolts follows from one of both'), &
    setting_rule_t('bolt_ring.number', '', 'bolt_ring.spacing', is_not_given, .false., 'each of the two gives the other'), &
    setting_rule_t('bolt_ring.radius, bolt_ring.from, bolt_ring.to, bolt_ring.spacing, bolt_ring.number, bolt_ring.length', '', &
                   'bolt_ring.centre', is_given, .true., 'there is no ring'), &
    setting_rule_t('bolt_ring.stiffness, bolt_ring.pretension, bolt_ring.strength, bolt_ring.shear_stiffness, '// &
                   'bolt_ring.shear_strength', '', 'bolt_ring.centre', is_given, .true., 'there is no ring'), &
    setting_rule_t('bolt_ring.centre', '', 'bolt_ring.spacing or bolt_ring.number', is_given, .false., &
                   'the number of bolts follows from one of both'), &
    setting_rule_t('in_situ.surface, in_situ.gradient, in_situ.pressure', '', 'in_situ.k0', is_given, .true., &
                   'the horizontal stress would be unknown'), &
    setting_rule_t('in_situ.k0', '', 'in_situ.surface', is_given, .false., 'stress grows with the depth below it'), &
    setting_rule_t('excavation.stage, excavation.joint', '', 'excavation.outline', is_given, .true., 'there is no polygon'), &
    setting_rule_t('excavation.outline', '', 'excavation.stage', is_given, .false., 'some stage has to remove the rock'), &
    setting_rule_t('support.table', '', 'support.velocity', is_not_given, .false., 'a line has one motion'), &
    setting_rule_t('support.velocity', '', 'step.balance', is_not_given, .false., &
                   'a support that moves on is never in equilibrium'), &
    setting_rule_t('support.velocity, support.table', '', 'support.moved', is_given, .true., 'there is nothing to move'), &
    setting_rule_t('support.moved', '', 'support.velocity or support.table', is_given, .false., 'its motion is unknown'), &
    setting_rule_t('water.unit_weight', '', 'water.table', is_given, .true., 'there is no water'), &
    setting_rule_t('water.table', '', 'water.unit_weight', is_given, .false., 'without a unit weight its pressure is unknown'), &
    setting_rule_t('damping.fraction', '', 'damping.mass', is_not_given, .true., 'it stands for damping.mass'), &
    setting_rule_t('damping.fraction', '', 'damping.stiffness', is_not_given, .true., 'it stands for damping.stiffness'), &
    setting_rule_t('damping.stiffness, damping.fraction', '', 'k01', is_positive, .false., 'a static step has no velocity'), &
    setting_rule_t('integrator.scheme', 'central_difference', 'damping.stiffness', is_not_given, .false., &
                   'explicit steps would become unstable with it'), &
    setting_rule_t('integrator.scheme', 'central_difference', 'damping.fraction', is_not_given, .false., &
                   'explicit steps would become unstable with it'), &
    setting_rule_t('integrator.scheme', 'small_steps', 'damping.stiffness', is_not_given, .false., &
                   'rigid blocks have no strain'), &
    setting_rule_t('integrator.scheme', 'small_steps', 'damping.fraction', is_not_given, .false., &
                   'rigid blocks have no strain'), &
    setting_rule_t('damping.fraction', '', 'damping.frequency', is_given, .false., 'damping depends on the frequency'), &
    setting_rule_t('damping.frequency', '', 'damping.fraction', is_given, .true., 'there is no fraction to have there'), &
    setting_rule_t('integrator.scheme', 'small_steps', 'absorbing.sides', is_not_given, .false., &
                   'no wave runs through rigid blocks'), &
    setting_rule_t('cover.order', '1', 'absorbing.sides', is_not_given, .false., 'absorbing edges must stay straight'), &
    setting_rule_t('absorbing.file', '', 'absorbing.table', is_not_given, .true., 'a scene has one wave'), &
    setting_rule_t('absorbing.scale', '', 'absorbing.table or absorbing.file', is_given, .true., 'there is nothing to scale'), &
    setting_rule_t('absorbing.lines, absorbing.base, absorbing.sides', '', 'k01', is_positive, .false., &
                   'a static step has no velocity'), &
    setting_rule_t('absorbing.base', '', 'absorbing.table or absorbing.file', is_given, .false., 'it needs a wave that comes in'), &
    setting_rule_t('absorbing.table, absorbing.file', '', 'absorbing.base', is_given, .false., 'a wave needs a base to come in'), &
    setting_rule_t('bolts.stiffness, bolts.pretension, bolts.strength, bolts.shear_stiffness, '// &
                   'bolts.shear_strength', '', 'bolts.ends', is_given, .true., &
                   'bolts of the geometry deck have their own numbers'), &
    setting_rule_t('iteration.relaxation, iteration.anderson', '', 'iteration.method', '|secant|hybrid|', .true., &
                   'corrections by the tangent are taken whole')]
  type(setting_rule_t), parameter :: rules_from_contact(*) = [ &
    setting_rule_t('contact.shear_ratio, contact.restitution, contact.viscosity, contact.rules, '// &
                   'contact.initial, contact.adapt, contact.coupling', '', &
                   'contact.method', '|penalty|augmented|', .true., 'without contact it has no effect'), &
    setting_rule_t('contact.overlap', '', 'contact.method', '|augmented|', .true., 'springs alone do not bound the overlap'), &
    setting_rule_t('contact.restitution', '', 'k01', is_positive, .true., 'a static step passes on no velocity'), &
    setting_rule_t('contact.restitution', '', 'step.control', '|fixed|', .false., &
                   'such long steps miss the time of an impact, and make energy in it'), &
    setting_rule_t('contact.restitution', '', 'contact.viscosity', is_not_given, .false., &
                   'restitution alone determines the loss of an impact'), &
    setting_rule_t('contact.restitution', '', 'joints.closure', is_not_given, .false., &
                   'impacts assume linear springs'), &
    setting_rule_t('joints.kn, joints.ks, joints.residual_phi, joints.residual_slip, joints.residual_c, '// &
                   'joints.jrc, joints.jcs', '', &
                   'contact.method', '|penalty|augmented|', .true., 'without contact it has no effect'), &
    setting_rule_t('joints.kn, joints.ks', '', 'contact.rules', '|coulomb|conserving|', .false., &
                   'Shi''s rules have one stiffness for all contacts'), &
    setting_rule_t('joints.ks', '', 'joints.kn', is_given, .true., 'a joint with a shear stiffness needs a normal stiffness'), &
    setting_rule_t('joints.residual_phi, joints.residual_slip, joints.residual_c, joints.jrc, joints.jcs', '', &
                   'contact.rules', '|coulomb|conserving|', .false., 'Shi''s rules have one friction angle'), &
    setting_rule_t('joints.jrc', '', 'joints.jcs', is_given, .true., 'the effect of roughness depends on the wall strength'), &
    setting_rule_t('joints.jcs', '', 'joints.jrc', is_given, .true., 'a smooth joint does not use the wall strength'), &
    setting_rule_t('joints.residual_phi', '', 'joints.residual_slip', is_given, .true., 'the angle falls over a slip'), &
    setting_rule_t('joints.residual_slip', '', 'joints.residual_phi', is_given, .true., 'there is no residual angle'), &
    setting_rule_t('joints.dilation, joints.dilation_slip', '', 'contact.method', '|penalty|', .false., &
                   'multipliers keep the walls in contact'), &
    setting_rule_t('joints.dilation, joints.dilation_slip', '', 'contact.rules', '|coulomb|', .false., &
                   'in the other rules the force depends on the gap alone'), &
    setting_rule_t('joints.dilation, joints.dilation_slip', '', 'contact.restitution', is_not_given, .false., &
                   'an impact would take dilation for a bounce'), &
    setting_rule_t('joints.closure', '', 'contact.method', '|penalty|', .false., 'with multipliers a joint does not close'), &
    setting_rule_t('joints.closure', '', 'contact.rules', '|coulomb|', .false., 'the other rules have linear springs'), &
    setting_rule_t('joints.closure', '', 'joints.kn', is_given, .true., 'kn is the stiffness at which closure begins'), &
    setting_rule_t('joints.energy, joints.shear_energy', '', 'contact.method', '|penalty|', .false., &
                   'multipliers know bonds that break at once'), &
    setting_rule_t('joints.energy, joints.shear_energy', '', 'contact.rules', '|coulomb|', .false., &
                   'the other rules know no bond that softens'), &
    setting_rule_t('joints.energy, joints.shear_energy', '', 'contact.restitution', is_not_given, .false., &
                   'impacts assume linear springs'), &
    setting_rule_t('joints.energy, joints.shear_energy', '', 'joints.dilation', is_not_given, .false., &
                   'a joint that dilates has no bond that opens'), &
    setting_rule_t('joints.dilation', '', 'joints.dilation_slip', is_given, .true., 'dilation ends after a slip'), &
    setting_rule_t('joints.dilation_slip', '', 'joints.dilation', is_given, .true., 'there is no dilation to end'), &
    setting_rule_t('cracks.length', '', 'cracks.strength', is_given, .true., 'there is no strength'), &
    setting_rule_t('cracks.begin_joint', '', 'cracks.strength', is_given, .true., 'a crack begins at a strength'), &
    setting_rule_t('cracks.parts', '', 'cracks.strength or cracks.toughness', is_given, .true., 'no crack grows'), &
    setting_rule_t(grows, '', 'method.model', '|nmm|', .false., 'a DDA block has one strain, and no stress at a tip'), &
    setting_rule_t(grows, '', 'cover.edge or cover.mesh', is_given, .false., &
                   'cracks grow from side to side of its triangles'), &
    setting_rule_t(grows, '', 'cover.order', '|0|', .false., 'cells have no contact'), &
    setting_rule_t(grows, '', 'integrator.scheme', '|newmark|energy_momentum|energy_decaying|', .false., &
                   'the other schemes keep more than a cut carries over'), &
    setting_rule_t(grows, '', 'step.control', '|fixed|', .false., &
                   'Shi''s rules are for comparison with his programs'), &
    setting_rule_t(grows, '', 'step.accuracy', is_not_given, .false., 'the estimate of the error assumes one mesh'), &
    setting_rule_t(grows, '', 'output.error', '|none|', .false., 'the estimate of the error assumes one mesh'), &
    setting_rule_t(grows, '', 'absorbing.lines', is_not_given, .false., &
                   'static forces on cut edges are not handed on'), &
    setting_rule_t(grows, '', 'absorbing.base', is_not_given, .false., &
                   'static forces on cut edges are not handed on'), &
    setting_rule_t(grows, '', 'scene.rectangle', is_not_given, .false., 'a part that breaks off stays in the scene'), &
    setting_rule_t(grows, '', 'step.sleep', is_not_given, .false., 'what sleeps would not crack'), &
    setting_rule_t('cracks.strength', '', 'cracks.length', is_given, .false., 'the stress at a tip has no bound'), &
    setting_rule_t('contact.coupling', 'nested', 'method.strain', '|green|auto|strain_rotation|', .true., &
                   'small strain has no iteration to nest contacts in'), &
    setting_rule_t('contact.adapt', 'shi', 'contact.rules', '|shi|', .false., &
                   'a loaded spring whose stiffness changes makes energy: it is for comparison alone'), &
    setting_rule_t('contact.rules', 'conserving', 'method.preset', '|none|', .false., 'Shi''s contact dissipates'), &
    setting_rule_t('contact.rules', 'conserving', 'method.strain', '|green|', .false., &
                   'small strain would lose or make the energy that contact returns'), &
    setting_rule_t('contact.rules', 'conserving', 'integrator.scheme', '|energy_momentum|', .false., &
                   'no other scheme conserves the energy that contact returns'), &
    setting_rule_t('contact.rules', 'conserving', 'contact.method', '|penalty|', .false., 'multipliers store no energy'), &
    setting_rule_t('contact.rules', 'conserving', 'contact.restitution', is_not_given, .false., &
                   'springs return the energy of an impact already'), &
    setting_rule_t('contact.rules', 'conserving', 'contact.viscosity', is_not_given, .false., &
                   'a dashpot dissipates energy'), &
    setting_rule_t('contact.rules', 'conserving', 'method.mass', '|constant|', .false., &
                   'a mass that changes does not conserve energy'), &
    setting_rule_t('contact.rules', 'conserving', 'integrator.transport', '|field|', .false., &
                   'the six rates of a block do not conserve the energy of its field'), &
    setting_rule_t('contact.rules', 'shi', 'method.preset', '|shi|', .false., &
                   'they can make energy without bound on stiff springs: they are for comparison alone'), &
    setting_rule_t('contact.rules', 'shi', 'method.strain', '|small|green|', .false., &
                   'Shi''s contact measures slip differently with small and Green strain'), &
    setting_rule_t('contact.rules', 'shi', 'contact.method', '|penalty|', .false., &
                   'multipliers need the friction of the same solution'), &
    setting_rule_t('contact.rules', 'shi', 'contact.coupling', '|merged|', .false., &
                   'friction that lags by an iteration does not settle in a nested one'), &
    setting_rule_t('contact.rules', 'shi', 'contact.restitution', is_not_given, .false., &
                   'lagged friction needs an iteration before, which an impact lacks'), &
    setting_rule_t('contact.adapt', 'shi', 'g2', is_positive, .false., 'it allows gaps in proportion to g2'), &
    setting_rule_t('contact.adapt', 'shi', 'integrator.scheme', '|newmark|', .false., &
                   'the other schemes would conserve the energy that this makes'), &
    setting_rule_t('integrator.scheme', 'central_difference', 'method.strain', '|small|green|', .false., &
                   'explicit steps take the forces of small or of Green strain'), &
    setting_rule_t('integrator.scheme', compared, 'method.preset', '|none|', .false., 'Shi''s programs use Newmark''s scheme'), &
    setting_rule_t('integrator.scheme', compared, 'k01', is_positive, .false., 'a static step has no acceleration'), &
    setting_rule_t('integrator.scheme', compared, 'step.control', '|fixed|', .false., 'Shi''s programs use Newmark''s scheme'), &
    setting_rule_t('integrator.scheme', compared, 'contact.restitution', is_not_given, .false., &
                   'impacts assume the velocities of Newmark''s step'), &
    setting_rule_t('integrator.scheme', 'small_steps', 'method.model', '|dda|', .false., 'rigid blocks have no mesh'), &
    setting_rule_t('integrator.scheme', 'small_steps', 'method.preset', '|none|', .false., 'Shi''s programs step otherwise'), &
    setting_rule_t('integrator.scheme', 'small_steps', 'k01', is_positive, .false., &
                   'a static stage solves the equations of equilibrium'), &
    setting_rule_t('integrator.scheme', 'small_steps', 'step.control', '|fixed|', .false., 'small steps choose their own size'), &
    setting_rule_t('integrator.scheme', 'small_steps', 'contact.method', '|penalty|', .false., &
                   'small steps have neither springs nor multipliers'), &
    setting_rule_t('integrator.scheme', 'small_steps', 'contact.viscosity', is_not_given, .false., &
                   'rigid contacts have no dashpot'), &
    setting_rule_t('integrator.scheme', 'small_steps', 'joints.closure', is_not_given, .false., &
                   'rigid joints do not close'), &
    setting_rule_t('integrator.scheme', 'small_steps', 'joints.energy', is_not_given, .false., &
                   'bonds of rigid blocks break at once'), &
    setting_rule_t('integrator.scheme', 'small_steps', 'joints.shear_energy', is_not_given, .false., &
                   'bonds of rigid blocks break at once'), &
    setting_rule_t('integrator.scheme', 'small_steps', 'joints.dilation', is_not_given, .false., &
                   'sequential impulses do not part faces that slide'), &
    setting_rule_t('integrator.scheme', 'small_steps', 'absorbing.lines', is_not_given, .false., &
                   'no wave runs through rigid blocks'), &
    setting_rule_t('integrator.scheme', 'small_steps', 'absorbing.base', is_not_given, .false., &
                   'no wave runs through rigid blocks'), &
    setting_rule_t('integrator.scheme', 'small_steps', 'fixed_points.method', '|exact|', .false., &
                   'small steps hold points without springs'), &
    setting_rule_t('joints.restitution', '', 'integrator.scheme', '|small_steps|', .false., &
                   'impacts of other integrators have one restitution'), &
    setting_rule_t('fixed_points.stiffness', '', 'fixed_points.method', '|penalty|', .true., &
                   'exact fixed points have no springs'), &
    setting_rule_t('acceleration.file', '', 'acceleration.table', is_not_given, .true., 'a scene has one ground'), &
    setting_rule_t('acceleration.vertical', '', 'acceleration.file', is_given, .true., &
                   'it is the other component of that record'), &
    setting_rule_t('acceleration.scale', '', 'acceleration.table or acceleration.file', is_given, .true., &
                   'there is nothing to scale'), &
    setting_rule_t('output.cracks', 'tips', 'cover.edge or cover.mesh', is_given, .true., &
                   'a crack has no tips in a block of one strain'), &
    setting_rule_t('output.interval', '', 'output.every', is_not_given, .true., 'frames are counted by time or by steps')]
  type(setting_rule_t), parameter :: setting_rules(*) = [rules_before_contact, rules_from_contact]

contains

  !> Removes settings of the deck that settings of the command line make idle: the command line wins over the deck.
  pure subroutine drop_overridden(words)
    type(word_t), intent(inout) :: words(:) !! as given, in the order of the table of settings
    type(setting_rule_t) :: rule
    character(len=:), allocatable :: name
    integer :: a, at, b, i

    do i = 1, size(setting_rules)
      rule = setting_rules(i)
      b = index_of(words, trim(rule%other))
      if (.not. rule%idle .or. b == 0 .or. rule%allowed == is_given .or. rule%allowed == is_positive) cycle
      at = 1
      do while (at <= len_trim(rule%names))
        call next_name(rule%names, ', ', at, name)
        a = index_of(words, name)
        if (.not. (is_given_by(words(a)) .and. is_given_by(words(b)))) cycle
        if (.not. concerns(rule, words(a)) .or. index(rule%allowed, '|'//words(b)%value//'|') > 0) cycle
        if (words(a)%from /= '--set' .and. words(b)%from == '--set') then
          deallocate (words(a)%value)
        else if (rule%allowed == is_not_given .and. words(a)%from == '--set' .and. words(b)%from /= '--set') then
          deallocate (words(b)%value)
        end if
      end do
    end do
  end subroutine drop_overridden

  !> Removes settings that a stage took over, where it has taken away the setting that they need.
  pure subroutine drop_idle(taken_over, words)
    logical, intent(in) :: taken_over(:)    !! (n_words)
    type(word_t), intent(inout) :: words(:) !! as given, in the order of the table of settings
    type(setting_rule_t) :: rule
    character(len=:), allocatable :: name
    integer :: a, at, i
    logical :: has_other

    do i = 1, size(setting_rules)
      rule = setting_rules(i)
      if (.not. rule%idle .or. rule%allowed /= is_given) cycle
      has_other = .false.
      at = 1
      do while (at <= len_trim(rule%other))
        call next_name(rule%other, ' or ', at, name)
        has_other = has_other .or. is_given_by(words(index_of(words, name)))
      end do
      if (has_other) cycle
      at = 1
      do while (at <= len_trim(rule%names))
        call next_name(rule%names, ', ', at, name)
        a = index_of(words, name)
        if (taken_over(a) .and. allocated(words(a)%value)) deallocate (words(a)%value)
      end do
    end do
  end subroutine drop_idle

  !> Error where the settings of a scene, complete, break a rule; at the place of the one that the deck gives.
  subroutine check_rules(scene, error)
    type(scene_t), intent(in) :: scene
    type(error_t), allocatable, intent(out) :: error
    type(setting_rule_t) :: rule
    character(len=:), allocatable :: found, name
    integer :: at, i

    do i = 1, size(setting_rules)
      rule = setting_rules(i)
      at = 1
      do while (at <= len_trim(rule%names))
        call next_name(rule%names, ', ', at, name)
        if (.not. concerns(rule, scene%words(index_of(scene%words, name)))) cycle
        ! what goes with it was given with it, and may be of that stage alone, as a wave
        if (rule%allowed == is_given .and. scene%words(index_of(scene%words, name))%stands_on) cycle
        found = against(rule, scene)
        if (len(found) == 0) cycle
        call fail(error, status_bad_input, where_given(scene, name, trim(rule%other))//': expected '// &
                  with_value(name, choice_found(rule, scene, name))//' only '//condition_text(rule)//' ('// &
                  trim(rule%why)//'), found '//found)
        return
      end do
    end do
  end subroutine check_rules

  !> The settings that a rule is about, in words.
  pure function subject_text(rule) result(text)
    type(setting_rule_t), intent(in) :: rule
    character(len=:), allocatable :: text

    text = with_value(trim(rule%names), rule%value)
  end function subject_text

  !> The condition of a rule on the other setting, in words: with ..., without ...
  pure function condition_text(rule) result(text)
    type(setting_rule_t), intent(in) :: rule
    character(len=:), allocatable :: text

    select case (rule%allowed)
    case (is_given)
      text = 'with '//trim(rule%other)
    case (is_not_given)
      text = 'without '//trim(rule%other)
    case (is_positive)
      text = 'with '//trim(rule%other)//' above 0'
    case (is_zero)
      text = 'with '//trim(rule%other)//' 0'
    case default
      text = 'with '//with_value(trim(rule%other), rule%allowed(2:len_trim(rule%allowed) - 1))
    end select
  end function condition_text

  !> The value of the other setting that breaks a rule, '' where the rule is kept.
  function against(rule, scene) result(found)
    type(setting_rule_t), intent(in) :: rule
    type(scene_t), intent(in) :: scene
    character(len=:), allocatable :: found, name
    integer :: at

    found = ''
    select case (rule%allowed)
    case (is_given)
      at = 1
      do while (at <= len_trim(rule%other))
        call next_name(rule%other, ' or ', at, name)
        if (is_given_by(scene%words(index_of(scene%words, name)))) return
      end do
      found = 'none'
    case (is_not_given)
      associate (word => scene%words(index_of(scene%words, trim(rule%other))))
        if (is_given_by(word)) found = trim(rule%other)//'='//word%value
      end associate
    case (is_positive)
      if (.not. number_of(scene, trim(rule%other)) > 0) found = with_number()
    case (is_zero)
      if (abs(number_of(scene, trim(rule%other))) > 0) found = with_number()
    case default
      at = 1
      do while (at <= len_trim(rule%other))
        call next_name(rule%other, ' or ', at, name)
        associate (word => scene%words(index_of(scene%words, name)))
          if (index(rule%allowed, '|'//word%value//'|') > 0) then
            found = ''
            return
          end if
          if (len(found) == 0) found = with_value(name, word%value)
        end associate
      end do
    end select

  contains

    !> The other setting with its number.
    function with_number() result(text)
      character(len=:), allocatable :: text

      text = trim(rule%other)//'='//real_text(number_of(scene, trim(rule%other)))
    end function with_number

  end function against

  !> Whether a rule is about a setting as it is.
  pure logical function concerns(rule, word)
    type(setting_rule_t), intent(in) :: rule
    type(word_t), intent(in) :: word

    concerns = is_given_by(word)
    if (len_trim(rule%value) == 0 .or. .not. allocated(word%value)) return
    concerns = index('|'//trim(rule%value)//'|', '|'//word%value//'|') > 0
  end function concerns

  !> A number of the deck or of a setting.
  real(dp) function number_of(scene, name)
    type(scene_t), intent(in) :: scene
    character(len=*), intent(in) :: name

    select case (name)
    case ('g2')
      number_of = scene%displacement_ratio
    case ('k01')
      number_of = scene%carried
    case default
      number_of = real_of(scene%words(index_of(scene%words, name))%value)
    end select
  end function number_of

  !> File and line, or the command line, that the first of two settings comes from, or else the second, or the deck.
  pure function where_given(scene, name, other) result(place)
    type(scene_t), intent(in) :: scene
    character(len=*), intent(in) :: name, other
    character(len=:), allocatable :: place

    place = given_at(scene%words, name)
    if (len(place) == 0) place = given_at(scene%words, other)
    if (len(place) == 0) place = scene%analysis_name
  end function where_given

  !> The choice of a setting that a rule is about, '' where it is about any value.
  pure function choice_found(rule, scene, name) result(value)
    type(setting_rule_t), intent(in) :: rule
    type(scene_t), intent(in) :: scene
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: value

    value = ''
    if (len_trim(rule%value) > 0) value = scene%words(index_of(scene%words, name))%value
  end function choice_found

  !> A setting with a choice in quotes, or several that are between bars, or alone.
  pure function with_value(name, value) result(text)
    character(len=*), intent(in) :: name, value
    character(len=:), allocatable :: text
    integer :: i

    text = name
    if (len_trim(value) == 0) return
    text = name//'='''
    do i = 1, len_trim(value)
      if (value(i:i) == '|') then
        text = text//''' or '''
      else
        text = text//value(i:i)
      end if
    end do
    text = text//''''
  end function with_value

  !> The name that begins at a place of a list; the place moves on to the next one.
  pure subroutine next_name(list, separator, at, name)
    character(len=*), intent(in) :: list, separator
    integer, intent(inout) :: at
    character(len=:), allocatable, intent(out) :: name
    integer :: length

    length = index(list(at:), separator) - 1
    if (length < 0) length = len_trim(list(at:))
    name = list(at:at + length - 1)
    at = at + length + len(separator)
  end subroutine next_name

end module scree_setting_rules
