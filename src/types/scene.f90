!> The scene to simulate: everything the decks ask for, after defaults, checked and complete.
!>
!> A scene never changes once it is read. The choices that Shi's numbers have no place for are named constants here, in the
!> order of their words in `settings.f90`, which gives each setting its name in the deck, default, unit and range.
module scree_scene
  use scree_bolt_numbers, only: bolt_numbers_t
  use scree_contacts, only: rules_coulomb
  use scree_kinds, only: dp
  use scree_mesh, only: mesh_t
  use scree_text, only: text_t
  implicit none
  private
  public :: block_material_t, bolt_record_t, boundary_load_t, effect_t, joint_material_t, kind_of, line_t, order_text, point_t, &
            polygons_t, run_options_t, scene_of_stage, scene_t, settings_t, stage_t, time_table_t, word_t

  !> Order of the numbers of an analysis deck: told by their count, or said.
  integer, parameter, public :: dialect_auto = 1, dialect_short = 2, dialect_shi = 3
  !> Interpolation: one cover a block (Shi's DDA), or three weighted covers an element (Shi's NMM).
  integer, parameter, public :: model_dda = 1, model_nmm = 2
  !> Strain of a step: the same for all elements, or Green strain where small strain would be off by more than is asked; to compare
  !> with, that of the decomposition into strain and rotation.
  integer, parameter, public :: strain_small = 1, strain_green = 2, strain_auto = 3, strain_rotation = 4
  !> Displacement of a block of small strain that turns (`finite_rotation`): its linear field, or cures of its growth.
  integer, parameter, public :: rotation_linear = 1, rotation_exact = 2, rotation_adjusted = 3, rotation_second_order = 4, &
                                rotation_trigonometric = 5, rotation_exponential = 6
  integer, parameter, public :: plane_stress = 1, plane_strain = 2
  !> Mass of a block: constant, or density times the present area (Shi's programs).
  integer, parameter, public :: mass_constant = 1, mass_follows_area = 2
  !> Integrator: Newmark in the letters of Zhang et al. 2019, the energy-momentum form, or that which dissipates; to compare with,
  !> the generalized-alpha method, explicit central differences, and Bathe's composite.
  integer, parameter, public :: scheme_newmark = 1, scheme_energy_momentum = 2, scheme_energy_decaying = 3, &
                                scheme_generalized_alpha = 4, scheme_central_difference = 5, scheme_bathe = 6
  integer, parameter :: scheme_small_steps = 7 !! `takes_small_steps` asks for it
  !> First step: as it comes, one step with beta 1, consistent acceleration, or that and the stress to it.
  integer, parameter, public :: start_zero = 1, start_dissipative = 2, start_acceleration = 3, start_consistent = 4
  !> Velocity of a DDA block from step to step: a vector field, or Shi's six rates.
  integer, parameter, public :: transport_field = 1, transport_rates = 2
  !> Iteration of a step with Green strain: secant operator, tangent, or secant first and tangent near the solution.
  integer, parameter, public :: iterate_secant = 1, iterate_newton = 2, iterate_hybrid = 3
  integer, parameter, public :: test_theta = 1, test_residual = 2
  integer, parameter, public :: problems_none = 1, problems_failed = 2, problems_all = 3
  !> Bodies touch by springs, by springs and multipliers, or not at all.
  integer, parameter, public :: contact_penalty = 1, contact_augmented = 2, contact_none = 3
  !> Fixed points: eliminated exactly, or held by springs (Shi's df12).
  integer, parameter, public :: fixed_exact = 1, fixed_penalty = 2

  !> Quantities that a stage resets: none; velocities, to 0; displacements, counted from there; or both.
  integer, parameter, public :: reset_none = 1, reset_velocities = 2, reset_displacements = 3, reset_both = 4

  !> A block that is not said.
  integer, parameter, public :: somewhere = -1

  !> A line of a geometry deck.
  type :: line_t
    real(dp) :: ends(2, 2) = 0.0_dp !! (xy, end), length
    integer :: material = 1         !! joint or block material number
    integer :: deck_line = 0        !! where it stands in its deck
  end type line_t

  !> A point of a geometry deck.
  type :: point_t
    real(dp) :: position(2) = 0.0_dp   !! length
    integer :: deck_line = 0        !! where it stands in its deck
    integer :: block = 0            !! block that carries it, 0 where the deck does not say
  end type point_t

  !> An axial spring between two points (Shi: h), or a fully grouted bolt: springs along and across it at joints that it crosses.
  type :: bolt_record_t
    real(dp) :: ends(2, 2) = 0.0_dp         !! (xy, end), length
    integer :: block(2) = somewhere         !! block that carries each end, 0: the ground does, `somewhere`: what it lies in
    real(dp) :: stiffness = 0.0_dp          !! e0, force/length per unit thickness
    real(dp) :: strength = 0.0_dp           !! t0, 0: without limit, force per unit thickness
    real(dp) :: pretension = 0.0_dp         !! f0, force per unit thickness
    real(dp) :: shear_stiffness = 0.0_dp    !! across a grouted one, 0: not grouted; force/length per unit thickness
    real(dp) :: shear_strength = 0.0_dp     !! likewise, 0: without limit, force per unit thickness
    logical :: ground_holds = .false.       !! the ground holds an end that lies in no block; else such an end is refused
    character(len=:), allocatable :: source !! where it stands: file and line
  end type bolt_record_t

  !> Load on the edges of blocks that lie on a line: its values at the ends, linear between.
  type :: boundary_load_t
    real(dp) :: ends(2, 2) = 0.0_dp         !! (xy, end), length
    real(dp) :: pressure(2) = 0.0_dp        !! against the edges, force/length^2
    real(dp) :: traction(2, 2) = 0.0_dp     !! (xy, end), force/length^2
  end type boundary_load_t

  !> Closed loops, counter-clockwise, as a block file gives them.
  type :: polygons_t
    integer, allocatable :: first_vertex(:) !! (n+1) polygon i owns vertices first_vertex(i):first_vertex(i+1)-1
    real(dp), allocatable :: vertex(:, :)   !! (2, n_vertices), length
    integer, allocatable :: joint(:)        !! (n_vertices) joint material of the edge to the next vertex
    integer, allocatable :: material(:)     !! (n) block material
    integer, allocatable :: deck_line(:)    !! (n) line of the deck with its material
    integer, allocatable :: vertex_line(:)  !! (n_vertices) line of the deck with its position
    integer, allocatable :: joint_line(:)   !! (n_vertices) and with the joint material of the edge to the next vertex
  end type polygons_t

  !> Thirteen numbers of a block material (Shi: a0).
  type :: block_material_t
    real(dp) :: density = 0.0_dp            !! ma, mass/length^3
    real(dp) :: unit_weight = 0.0_dp        !! we, force/length^3, acts downwards
    real(dp) :: young = 0.0_dp              !! E, force/length^2
    real(dp) :: poisson = 0.0_dp            !! nu
    real(dp) :: stress(3) = 0.0_dp          !! xx, yy, xy at y = 0, tension positive, force/length^2
    real(dp) :: stress_gradient(3) = 0.0_dp !! its increase with y, force/length^3
    real(dp) :: velocity(3) = 0.0_dp        !! vx, vy length/time; rotation rate 1/time, about the centroid
  end type block_material_t

  !> Three numbers of a joint material (Shi: b0).
  type :: joint_material_t
    real(dp) :: friction_angle = 0.0_dp     !! degrees
    real(dp) :: cohesion = 0.0_dp           !! force/length^2
    real(dp) :: tensile_strength = 0.0_dp   !! force/length^2
  end type joint_material_t

  !> Values given at times, linear between them (Shi: k5, u0): displacement of a fixed point, force of a load point,
  !> acceleration of the ground, velocity of a wave.
  type :: time_table_t
    real(dp), allocatable :: time(:)        !! (n) ascending, time
    real(dp), allocatable :: value(:, :)    !! (2, n)
    logical :: kept = .true.                !! the first value before its time, the last after; else zero
  end type time_table_t

  !> Every choice and number of the named groups, after defaults. A component begins as a deck without its name leaves it, unless
  !> its default depends on others.
  type :: settings_t
    character(len=:), allocatable :: geometry !! file of the geometry
    integer :: dialect = dialect_auto
    character(len=:), allocatable :: unit_of_length, unit_of_force, unit_of_time !! names; not allocated: none is given
    logical :: allows_gaps = .false.        !! edges may be missing along lines that hold, load or absorb
    logical :: shi = .false.                !! preset='shi'
    integer :: model = model_dda
    integer :: strain = strain_small
    real(dp) :: accuracy = 1e-8_dp          !! error of a strain in a step that small strain may have, where the scene chooses
    integer :: rotation = rotation_linear   !! what moves a block of small strain that turns
    integer :: plane = plane_stress
    integer :: mass = mass_constant
    character(len=:), allocatable :: stage_name
    logical :: static = .false.             !! steps hand no velocity on
    real(dp), allocatable :: scene_rectangle(:)   !! x1 y1 x2 y2 of its lower left and upper right corner; what leaves it is removed
    real(dp), allocatable :: removed_blocks(:)    !! numbers of blocks that the stage removes
    real(dp), allocatable :: removed_materials(:) !! and of block materials, with all blocks of them
    real(dp), allocatable :: removed_inside(:) !! corners x y of polygons whose blocks too
    integer :: reset = reset_none           !! what the stage begins anew
    logical :: goes_on_without_loose = .false. !! a block that moves on and on does not end a static stage
    real(dp) :: cover_edge = 0.0_dp         !! of the triangles of the regular mathematical mesh, 0: none, length
    real(dp) :: cover_origin(2) = 0.0_dp    !! a node of it, length
    real(dp) :: cover_angle = 0.0_dp        !! of a family of its edges against x, degrees
    character(len=:), allocatable :: cover_mesh !! file of a mathematical mesh
    logical :: second_order = .false.       !! covers as linear functions on those of nodes make them
    real(dp) :: least_share = 0.1_dp        !! of its triangle that an element has to have to carry covers of its own
    integer :: scheme = scheme_newmark
    real(dp) :: beta = 1.0_dp               !! weight of the new acceleration in the velocity
    real(dp) :: gamma = 0.5_dp              !! weight of the new acceleration in the displacement
    real(dp) :: rho = 0.5_dp                !! spectral radius of generalized-alpha at infinite frequency
    integer :: start = start_zero
    integer :: transport = transport_rates
    real(dp) :: step_size = 0.0_dp          !! largest step, time
    real(dp) :: end_time = huge(1.0_dp)     !! time
    integer :: most_steps = huge(1)         !! after which a run ends
    real(dp) :: travel = huge(1.0_dp)       !! of a vertex in a step, at most, over half the size of the model
    logical :: chooses_step = .false.       !! by Shi's rules, from the displacement that a step may have
    real(dp) :: least_step = 0.0_dp         !! a step that must be smaller ends the run, time
    integer :: threads = 1                  !! that small steps may use, of the command line
    real(dp) :: run_out = 0.01_dp           !! likewise of small steps, by which they choose their size
    real(dp) :: step_overlap = 0.0_dp       !! of blocks over their size, by which small steps choose theirs; 0: by run_out
    real(dp) :: aim = 0.0_dp                !! fraction of its displacement that the run may be off by; 0: steps as given
    real(dp) :: balance = -1.0_dp           !! fraction of the forces out of balance at which a static run ends; below 0: none
    real(dp) :: past_peak = -1.0_dp         !! fraction of its largest to which the force of moving supports may fall; below 0: any
    real(dp) :: sleep = 0.0_dp              !! fraction of weight and speed below which bodies at rest fall asleep, 0: none does
    integer :: iterate = iterate_hybrid
    integer :: test = test_theta
    real(dp) :: tolerance = 1e-10_dp        !! of the chosen test
    integer :: most_iterations = 25
    integer :: anderson = 0                 !! earlier corrections by the secant that one is mixed with, where nothing touches
    real(dp) :: relaxation = 1.0_dp         !! fraction of a correction by the secant that is taken, where nothing touches
    integer :: contact = contact_penalty
    real(dp) :: contact_stiffness = 0.0_dp  !! across a contact, force/length per unit thickness
    real(dp) :: shear_ratio = 2.5_dp        !! of that to the stiffness along it
    real(dp) :: overlap = huge(1.0_dp)      !! that multipliers leave; huge: springs alone, length
    real(dp) :: initial_overlap = 0.02_dp   !! of blocks when the run begins, over the size of the smaller, at most
    real(dp) :: restitution = -1.0_dp       !! of impacts; below 0: as the springs have it
    real(dp) :: viscosity = 0.0_dp          !! across closed contacts, force time/length per unit thickness
    integer :: rules = rules_coulomb        !! of contact
    logical :: adapts_stiffness = .false.   !! of contacts, by Shi's rules
    real(dp), allocatable :: young(:)       !! (n_materials) in place of E of the deck, force/length^2
    real(dp), allocatable :: poisson(:)     !! (n_materials) in place of nu
    real(dp), allocatable :: unit_weight(:) !! (n_materials) in place of we, force/length^3
    real(dp), allocatable :: joint_phi(:)   !! (n_joints) in place of phi of the deck, degrees
    real(dp), allocatable :: joint_c(:)     !! (n_joints) in place of c, force/length^2
    real(dp), allocatable :: joint_t(:)     !! (n_joints) in place of T, force/length^2
    real(dp), allocatable :: joint_kn(:)    !! (n_joints) stiffness across; 0: that of a contact, force/length^3
    real(dp), allocatable :: joint_restitution(:) !! (n_joints) of impacts, in place of that of the scene
    real(dp), allocatable :: worn_angle(:)  !! (n_joints) friction angle that sliding leaves, degrees
    real(dp), allocatable :: worn_slip(:)   !! (n_joints) slip by then; 0: it stays as it is, length
    real(dp), allocatable :: worn_cohesion(:) !! (n_joints) cohesion that a broken bond leaves, force/length^2
    real(dp), allocatable :: jrc(:)         !! (n_joints) roughness coefficient, degrees a decade of the stress
    real(dp), allocatable :: jcs(:)         !! (n_joints) compressive strength of the walls, force/length^2
    real(dp), allocatable :: joint_energy(:) !! (n_joints) that opening takes of a bond, force/length; 0: it breaks at once
    real(dp), allocatable :: joint_shear_energy(:) !! (n_joints) that shear takes of it, likewise
    real(dp), allocatable :: joint_closure(:) !! (n_joints) largest, of a joint that stiffens as it closes; 0: it does not, length
    real(dp), allocatable :: dilation(:)    !! (n_joints) angle at which a joint opens as it slides, degrees
    real(dp), allocatable :: dilation_slip(:) !! (n_joints) slip at which that ends, length
    real(dp), allocatable :: joint_ks(:)    !! (n_joints) likewise along; not there: that across over the shear ratio
    real(dp), allocatable :: crack_strength(:)  !! (n_materials) mean tension at which tips grow; 0: none, force/length^2
    real(dp), allocatable :: crack_toughness(:) !! (n_materials) K_Ic at which tips grow; 0: none, force/length^(3/2)
    real(dp) :: crack_length = 0.0_dp       !! radius of the half disc of that mean, length
    integer :: crack_begin_joint = 0        !! joint material of cracks that begin by themselves; 0: none begins
    integer :: crack_parts = 0              !! blocks that may break off, for which the results have room
    logical :: nested = .false.             !! the open-close iteration runs inside each iteration of the deformation
    integer :: fixed = fixed_exact
    real(dp) :: fixed_stiffness = 0.0_dp    !! of a spring of a fixed point, force/length per unit thickness
    real(dp), allocatable :: load_force(:)  !! fx fy of each load point, force per unit thickness
    real(dp), allocatable :: in_situ_surface(:) !! x y of points of the ground surface, length
    real(dp), allocatable :: k0(:)          !! horizontal over vertical stress, of each block material, or of all
    real(dp) :: in_situ_gradient = 0.0_dp   !! of the vertical stress with depth; 0: the weight of the blocks, force/length^3
    real(dp) :: in_situ_pressure = 0.0_dp   !! on the surface, force/length^2
    real(dp), allocatable :: excavated(:)   !! corners x y of polygons that are cut, and removed in stages, length
    character(len=:), allocatable :: excavating_stages !! of each of these, by name
    real(dp), allocatable :: excavated_joint(:) !! joint material of each, or of all
    real(dp) :: gravity_ramp = 0.0_dp       !! in which the weight grows, time
    real(dp) :: least_block_area = 0.0_dp   !! a smaller one joins its neighbour, length^2
    real(dp), allocatable :: bolt_ends(:)   !! x1 y1 x2 y2 of each bolt, length
    type(bolt_numbers_t) :: bolt_numbers    !! of these
    logical :: keeps_bolts = .false.        !! those of the stage before stay beside these
    real(dp), allocatable :: row_lines(:)   !! x1 y1 x2 y2 of each row of bolts, length
    real(dp), allocatable :: row_spacing(:) !! of the heads of each, or of all, length
    real(dp), allocatable :: row_number(:)  !! likewise, in place of the spacing
    real(dp), allocatable :: row_length(:)  !! likewise, length
    real(dp), allocatable :: row_direction(:) !! likewise, against x; not there: to the left of the line, degrees
    type(bolt_numbers_t) :: row_numbers
    real(dp), allocatable :: ring_centres(:) !! x y of each ring of bolts, length
    real(dp), allocatable :: ring_radius(:) !! of the heads of each, or of all, length
    real(dp), allocatable :: ring_from(:)   !! likewise, angle of the first bolt, degrees
    real(dp), allocatable :: ring_to(:)     !! likewise, of the last; not there: a full circle, degrees
    real(dp), allocatable :: ring_spacing(:) !! likewise, along the circle, length
    real(dp), allocatable :: ring_number(:) !! likewise, in place of the spacing
    real(dp), allocatable :: ring_length(:) !! likewise, length
    type(bolt_numbers_t) :: ring_numbers
    logical :: bolts_break = .false.        !! at their strength, else they yield
    logical :: ground_holds_bolts = .false. !! at ends that lie in no block; else such ends are refused
    real(dp), allocatable :: support_normal(:) !! x1 y1 x2 y2 of each line, length
    real(dp), allocatable :: support_x(:)   !! likewise
    real(dp), allocatable :: support_y(:)   !! likewise
    real(dp), allocatable :: support_both(:) !! likewise
    real(dp), allocatable :: support_points(:)   !! x y of each point that is held, length
    real(dp), allocatable :: support_points_x(:) !! likewise, along x alone
    real(dp), allocatable :: support_points_y(:) !! likewise, along y alone
    real(dp), allocatable :: support_moved(:)    !! x1 y1 x2 y2 of each line that moves, length
    real(dp), allocatable :: support_velocity(:) !! vx vy of each of these, or of all, length/time
    real(dp), allocatable :: support_table(:)    !! t ux uy of all of them, at one time after the other
    real(dp), allocatable :: boundary_lines(:)    !! x1 y1 x2 y2 of each, length
    real(dp), allocatable :: boundary_pressure(:) !! at both ends of each, force/length^2
    real(dp), allocatable :: boundary_traction(:) !! tx ty at both ends of each, force/length^2
    real(dp) :: boundary_ramp = 0.0_dp      !! in which they and the pressure of water grow, time
    real(dp), allocatable :: water_table(:) !! x y of its points, length
    real(dp) :: water_weight = 0.0_dp       !! of a unit of volume, force/length^3
    real(dp), allocatable :: absorbing_lines(:) !! x1 y1 x2 y2 of each line, length
    real(dp), allocatable :: absorbing_base(:)  !! likewise, where the wave comes in
    real(dp), allocatable :: absorbing_sides(:) !! likewise, beside which a free field moves
    real(dp), allocatable :: wave_table(:)  !! t vx vy of it, at one time after the other
    character(len=:), allocatable :: wave_file !! file of such lines
    real(dp) :: wave_scale = 1.0_dp         !! factor of vx and vy
    real(dp), allocatable :: ground_table(:) !! t ax ay of the ground, at one time after the other
    character(len=:), allocatable :: ground_file !! file of such lines, or a PEER record of ax
    character(len=:), allocatable :: ground_vertical !! PEER record of ay
    real(dp) :: ground_scale = 1.0_dp       !! factor of ax and ay
    real(dp) :: mass_damping = 0.0_dp       !! force over mass and velocity, 1/time
    real(dp) :: stiffness_damping = 0.0_dp  !! viscous stress over elasticity and strain rate, time
    real(dp) :: damping_fraction = 0.0_dp   !! of critical damping, the least of all frequencies
    real(dp) :: damping_frequency = 0.0_dp  !! that has it, 1/time
    integer :: frame_every = 0              !! steps from frame to frame; 0 where time counts
    integer :: checkpoint_every = 0         !! frames from checkpoint to checkpoint; 0: one where the run ends
    real(dp) :: frame_interval = 0.0_dp     !! time from frame to frame, met by steps; 0 where another counts
    logical :: estimates_error = .false.    !! of the steps
    logical :: measures_tips = .false.      !! stress intensity of the tips of cracks, in each step
    integer :: problems = problems_none     !! of friction, that are written to the results
    ! what follows from these and the numbers of the deck
    logical :: loads_at_end = .false.       !! steps feel the loads of their end, not their mean
    real(dp) :: most_travel = huge(1.0_dp)  !! of a vertex in a step, length
    real(dp) :: frame_spacing = 0.0_dp      !! time from frame to frame, that of the step that passes it; 0 where another counts
  contains
    procedure :: cracks_may_grow, rayleigh, takes_small_steps
  end type settings_t

  !> One name of the named groups with its value, after defaults.
  type :: word_t
    character(len=:), allocatable :: name       !! group.name
    character(len=:), allocatable :: value      !! as text; not allocated: no value
    character(len=:), allocatable :: from       !! where it comes from: the deck's name and line, --set, or default
    logical :: stands_on = .false.              !! from the stage before
  end type word_t

  !> An effect that the scene calls for, and why.
  type :: effect_t
    character(len=:), allocatable :: name
    character(len=:), allocatable :: because
  end type effect_t

  !> Options of a run from the command line.
  type :: run_options_t
    character(len=:), allocatable :: results_path
    character(len=:), allocatable :: restart_path !! results file of the run to go on with, '': none
    logical :: runs = .false.               !! else the model alone
    logical :: with_xdmf = .false.
    logical :: with_classic = .false.       !! output of a run in Shi's form
    logical :: quiet = .false.
    logical :: with_json = .false.          !! a summary of a run, or the version, as a JSON object
    integer :: threads = 1                  !! that small steps may use
    integer :: steps = 0                    !! of a run before it pauses; 0: it goes on to its end
    logical :: strict = .false.             !! a model that calls for warnings does not run
  end type run_options_t

  !> Settings that may differ from stage to stage.
  type :: stage_t
    real(dp) :: carried = 1.0_dp            !! fraction of velocity that a step hands on; 0 static, 1 dynamic (Shi: k01)
    type(settings_t) :: settings
    type(word_t), allocatable :: words(:)   !! what the settings were read from, in the order of the table of settings
    type(block_material_t), allocatable :: block_material(:)
    type(joint_material_t), allocatable :: joint_material(:)
    type(boundary_load_t), allocatable :: boundary_loads(:)
    type(time_table_t), allocatable :: motions(:) !! displacement of each line of supports that moves
    type(time_table_t), allocatable :: load_table(:)  !! a load point each; without times: no load
    type(time_table_t) :: ground            !! its acceleration, scaled; without times: none, length/time^2
    type(time_table_t) :: wave              !! velocity of the wave that comes in, likewise, length/time
    logical, allocatable :: removed(:)      !! (n_blocks) blocks that are gone when the stage begins
    logical, allocatable :: installed(:)    !! (n_bolts) bolts that the stage has
  contains
    procedure :: is_static
  end type stage_t

  !> The whole scene: the first stage, and everything common to all stages.
  type, extends(stage_t) :: scene_t
    character(len=:), allocatable :: geometry_name, geometry_text !! geometry deck or block file as read
    character(len=:), allocatable :: analysis_name, analysis_text !! analysis deck as read
    type(text_t), allocatable :: options(:) !! GROUP.NAME=VALUE of the command line, over what the deck says
    logical :: in_shi_order = .false.       !! the numbers of the analysis deck: Shi's order with g0 and tables, else the short one
    integer :: n_steps = 0                  !! number of steps of the classic deck (Shi: n5)
    real(dp) :: displacement_ratio = 0.0_dp !! largest displacement of a step over half the model size (Shi: g2)
    real(dp) :: contact_stiffness = 0.0_dp  !! 0: the program chooses (Shi: g0), force/length per unit thickness
    real(dp) :: least_distance = 0.0_dp     !! edge to node, over half the model size (Shi: e0)
    real(dp) :: step_size = 0.0_dp          !! of the classic deck (Shi: g1), time
    real(dp) :: extent = 0.0_dp             !! larger side of the box around the blocks, length
    integer :: n_boundary = 0               !! boundary lines, the first of the lines
    real(dp) :: nearest = 0.0_dp            !! what is nearer to a line is on it, length
    real(dp), allocatable :: named_lines(:, :, :) !! (xy, end, n) on which stages hold, load, absorb or remove, length
    type(line_t), allocatable :: lines(:)          !! boundary and joints; empty where blocks are given
    type(line_t), allocatable :: material_lines(:)
    type(line_t), allocatable :: fixed_lines(:)    !! equal ends: a fixed point
    type(point_t), allocatable :: load_points(:), measured_points(:), hole_points(:)
    type(bolt_record_t), allocatable :: bolts(:)
    type(polygons_t), allocatable :: blocks        !! given by a block file
    type(mesh_t), allocatable :: mesh              !! mathematical mesh that a file gives
    type(point_t), allocatable :: fixed_points(:)  !! given by a block file
    type(time_table_t), allocatable :: fixed_table(:) !! a fixed point each; without times: fixed for ever
    type(stage_t), allocatable :: later(:)  !! the stages after the first
  end type scene_t

contains

  !> The order of the numbers of the analysis deck in words.
  pure function order_text(scene) result(order)
    type(scene_t), intent(in) :: scene
    character(len=:), allocatable :: order

    order = 'short'
    if (scene%in_shi_order) order = 'Shi''s, with the contact stiffness g0 and a table for each fixed and load point'
  end function order_text

  !> Coefficients of Rayleigh damping: alpha of the mass, 1/time, and beta of the stiffness, time.
  !>
  !> At the circular frequency w it is the fraction (alpha/w + beta w)/2 of critical damping, which is least at
  !> w0 = (alpha/beta)^1/2. With the fraction z there, alpha = z w0 and beta = z/w0.
  pure function rayleigh(settings)
    class(settings_t), intent(in) :: settings
    real(dp) :: rayleigh(2)
    real(dp), parameter :: turn = 8*atan(1.0_dp)

    rayleigh = [settings%mass_damping, settings%stiffness_damping]
    if (settings%damping_frequency > 0) &
      rayleigh = settings%damping_fraction*[turn*settings%damping_frequency, 1/(turn*settings%damping_frequency)]
  end function rayleigh

  !> Whether the integrator is that of small steps, which takes blocks for rigid.
  pure logical function takes_small_steps(settings)
    class(settings_t), intent(in) :: settings

    takes_small_steps = settings%scheme == scheme_small_steps
  end function takes_small_steps

  !> Whether a deck says what makes cracks grow.
  pure logical function cracks_may_grow(settings)
    class(settings_t), intent(in) :: settings

    cracks_may_grow = allocated(settings%crack_strength) .or. allocated(settings%crack_toughness)
  end function cracks_may_grow

  !> The kind of a stage, as `stage.kind` has it.
  pure function kind_of(stage) result(kind)
    class(stage_t), intent(in) :: stage
    character(len=:), allocatable :: kind

    kind = 'dynamic'
    if (stage%is_static()) kind = 'static'
  end function kind_of

  !> Whether the steps of a stage hand no velocity on.
  pure logical function is_static(stage)
    class(stage_t), intent(in) :: stage

    is_static = .not. stage%carried > 0
  end function is_static

  !> The scene as it is in a stage. Times of the tables of points count from the beginning of the run, all others from that of the
  !> stage.
  pure type(scene_t) function scene_of_stage(scene, number, begins) result(own)
    type(scene_t), intent(in) :: scene
    integer, intent(in) :: number           !! of the stage, from 1
    real(dp), intent(in) :: begins          !! when the stage does, time of the run
    integer :: i

    own = scene
    if (number == 1) return
    own%stage_t = scene%later(number - 1)
    do i = 1, size(own%fixed_table)
      if (allocated(own%fixed_table(i)%time)) own%fixed_table(i)%time = own%fixed_table(i)%time - begins
    end do
    do i = 1, size(own%load_table)
      if (allocated(own%load_table(i)%time)) own%load_table(i)%time = own%load_table(i)%time - begins
    end do
  end function scene_of_stage

end module scree_scene
