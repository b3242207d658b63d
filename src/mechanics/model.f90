!> Model and cache of a run: the model never changes, the cache follows from model and state.
!>
!> Dropping the cache after any step changes no bit of the run.
module scree_model
  use scree_absorbing_edge, only: absorbing_edge_t
  use scree_base_acceleration, only: base_acceleration_t
  use scree_bodies, only: bodies_t
  use scree_bolt, only: bolt_t
  use scree_contacts, only: contact_law_t, contact_search_t
  use scree_crack_tip, only: crack_start_t, crack_tip_t
  use scree_edge_load, only: edge_load_t
  use scree_equations, only: equations_t
  use scree_fixed_point, only: fixed_point_t
  use scree_friction_problem, only: posed_problem_t
  use scree_gravity, only: gravity_t
  use scree_interpolation, only: kinematics_t
  use scree_kinds, only: dp
  use scree_mass_damping, only: mass_damping_t
  use scree_point_load, only: point_load_t
  use scree_scene, only: rotation_linear, settings_t
  use scree_state, only: books_t
  use scree_stiffness_damping, only: stiffness_damping_t
  use scree_system, only: element_unknowns, system_t
  use scree_timers, only: timers_t
  implicit none
  private
  public :: cache_t, effects_t, element_cache_t, model_t

  integer, parameter :: n = element_unknowns

  !> Inertia and elasticity belong to every scene. The others are called for where they are allocated.
  type :: effects_t
    real(dp), allocatable :: elasticity(:, :, :)   !! (3, 3, n_materials) force/length^2
    logical :: large_deformation = .false.         !! stress and stiffness turn and stretch with their element
    logical :: strain_rotation = .false.           !! the decomposition into strain and rotation stands in for Green strain
    !> Error of a strain in a step up to which an element takes small strain; not allocated: all take one strain for ever.
    real(dp), allocatable :: accuracy
    integer :: rotation = rotation_linear          !! what moves a block of small strain that turns
    logical :: mass_follows_area = .false.         !! as in Shi's programs
    real(dp) :: carried = 1.0_dp                   !! fraction of the velocity that a step hands on (Shi: k01)
    integer :: transport = 0                       !! `transport_field` or `transport_rates` of the scene
    type(gravity_t), allocatable :: gravity
    type(base_acceleration_t), allocatable :: base_acceleration
    type(mass_damping_t), allocatable :: mass_damping
    type(stiffness_damping_t), allocatable :: stiffness_damping
    type(point_load_t), allocatable :: point_load
    type(fixed_point_t), allocatable :: fixed_point
    type(edge_load_t), allocatable :: edge_load
    type(absorbing_edge_t), allocatable :: absorbing_edge
    type(bolt_t), allocatable :: bolt
    type(contact_law_t), allocatable :: contact
    real(dp), allocatable :: sleep                 !! fraction of weight and speed below which islands at rest fall asleep
  contains
    procedure :: is_static
  end type effects_t

  !> Data of one element that stay the same through the iterations of a step.
  type :: element_cache_t
    type(kinematics_t) :: kinematics
    logical :: green = .false.                     !! Green strain or what stands in for it, else small strain
    real(dp) :: mass_matrix(n, n) = 0.0_dp         !! consistent, mass/length
    real(dp) :: elasticity(3, 3) = 0.0_dp          !! in the present configuration, force/length^2
    real(dp) :: stress(3) = 0.0_dp                 !! at the beginning of the step, force/length^2
    real(dp) :: mass = 0.0_dp                      !! at present, mass/length
    real(dp) :: mass_ratio = 1.0_dp                !! present mass over that at the start
  end type element_cache_t

  !> Bodies, their effects, and how the scene asks to step: what stays as it is from the first step to the last.
  type, extends(system_t) :: model_t
    type(effects_t) :: effects
    type(settings_t) :: settings
    real(dp), allocatable :: start(:, :)       !! (2, n_vertices) where the vertices of the elements begin, length
    real(dp), allocatable :: start_point(:, :) !! (2, n_points) where the points do, length
    type(crack_tip_t), allocatable :: tip(:)   !! of cracks, where they may grow or the scene asks for their stress intensity
    type(crack_start_t), allocatable :: crack_start(:) !! places where cracks may begin, where the scene lets them
    real(dp) :: pseudo_step = huge(1.0_dp)     !! by which inertia resists a static step that failed; huge: there is none, time
  end type model_t

  !> Data that follow from model and state, kept because they are expensive to compute; and problems that are to be written.
  type :: cache_t
    type(element_cache_t), allocatable :: element(:) !! (n_elements) of the state
    type(books_t) :: fixed                           !! energies of elements that cannot move
    real(dp) :: fixed_extent = 0.0_dp                !! largest coordinate of the vertices of these, length
    type(contact_search_t) :: search                 !! who is near whom
    type(equations_t) :: equations                   !! pattern and factor
    type(posed_problem_t), allocatable :: posed(:)   !! friction problems to be written, where any are
    type(bodies_t), allocatable :: bodies            !! of small steps: pieces of the blocks, and which are near each other
    type(timers_t) :: timers                         !! what the run costs; no bit of it follows from them
  end type cache_t

contains

  !> Whether steps hand no velocity on.
  pure logical function is_static(effects)
    class(effects_t), intent(in) :: effects

    is_static = .not. effects%carried > 0
  end function is_static
end module scree_model
