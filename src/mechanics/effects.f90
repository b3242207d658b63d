!> The effects of a scene. This file is the only one that asks which are present.
module scree_effects
  use scree_base_acceleration, only: add_base_acceleration, base_acceleration_t
  use scree_contacts, only: contact_law_t
  use scree_element_term, only: step_rule_t, term_t
  use scree_fixed_point, only: add_fixed_springs, fixed_point_t
  use scree_gravity, only: add_gravity, gravity_t
  use scree_green_strain, only: add_green_strain
  use scree_inertia, only: add_inertia, mass_matrix
  use scree_interpolation, only: kinematics_of, kinematics_t
  use scree_kinds, only: dp
  use scree_mass_damping, only: add_mass_damping, mass_damping_t
  use scree_material, only: push_elasticity_forward
  use scree_point_load, only: add_point_loads, point_load_t
  use scree_stiffness, only: add_small_strain
  use scree_system, only: element_unknowns, state_t, system_t
  implicit none
  private
  public :: add_element_effects, effects_t, element_cache_t, cache_of_element, symmetric_equations

  integer, parameter :: n = element_unknowns

  !> Inertia and elasticity belong to every scene. The others are called for where they are allocated.
  type :: effects_t
    real(dp), allocatable :: elasticity(:, :, :)   !! (3, 3, n_materials) force/length^2
    logical :: large_deformation = .false.         !! Green strain, else small strain
    logical :: turns_exactly = .false.             !! blocks move by cos and sin of their rotation, with small strain
    logical :: mass_follows_area = .false.         !! as in Shi's programs
    real(dp) :: carried = 1.0_dp                   !! share of the velocity that a step hands on (Shi: k01)
    integer :: transport = 0                       !! `transport_field` or `transport_rates` of the scene
    type(gravity_t), allocatable :: gravity
    type(base_acceleration_t), allocatable :: base_acceleration
    type(mass_damping_t), allocatable :: mass_damping
    type(point_load_t), allocatable :: point_load
    type(fixed_point_t), allocatable :: fixed_point
    type(contact_law_t), allocatable :: contact
  end type effects_t

  !> What stays the same for one element through the iterations of a step.
  type :: element_cache_t
    type(kinematics_t) :: kinematics
    real(dp) :: mass_matrix(n, n) = 0.0_dp         !! consistent, mass/length
    real(dp) :: elasticity(3, 3) = 0.0_dp          !! in the present configuration, force/length^2
    real(dp) :: mass = 0.0_dp                      !! at present, mass/length
    real(dp) :: mass_ratio = 1.0_dp                !! present mass over that at the start
  end type element_cache_t

contains

  !> What element `e` keeps through the iterations of a step that begins at `state`.
  pure function cache_of_element(effects, system, state, e) result(share)
    type(effects_t), intent(in) :: effects
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state
    integer, intent(in) :: e
    type(element_cache_t) :: share

    share%kinematics = kinematics_of(system, state, e)
    associate (F => state%deformation(:, e), D => effects%elasticity(:, :, system%elements%material(e)))
      if (effects%mass_follows_area) share%mass_ratio = F(1)*F(4) - F(2)*F(3)
      share%mass = share%mass_ratio*system%elements%mass(e)
      share%mass_matrix = mass_matrix(share%kinematics, share%mass)
      if (effects%large_deformation) then
        share%elasticity = push_elasticity_forward(F, D)
      else
        share%elasticity = D
      end if
    end associate
  end function cache_of_element

  !> Adds every present effect to element `e`.
  pure subroutine add_element_effects(effects, system, state, e, share, unknown, rule, term)
    type(effects_t), intent(in) :: effects
    type(system_t), intent(in) :: system
    type(state_t), intent(in) :: state         !! at the beginning of the step
    integer, intent(in) :: e
    type(element_cache_t), intent(in) :: share
    real(dp), intent(in) :: unknown(n)         !! of the step so far
    type(step_rule_t), intent(in) :: rule
    type(term_t), intent(out) :: term

    associate (element => share%kinematics, ids => system%elements%unknown(:, e))
      call add_inertia(share%mass_matrix, state%velocity(ids), state%acceleration(ids), unknown, rule, term)
      if (effects%large_deformation) then
        call add_green_strain(element, share%elasticity, state%stress(:, e), unknown, rule, term)
      else
        call add_small_strain(element, share%elasticity, state%stress(:, e), unknown, rule, term)
      end if
      if (allocated(effects%gravity)) &
        call add_gravity(share%mass_ratio*effects%gravity%weight(e), element, term)
      if (allocated(effects%base_acceleration)) &
        call add_base_acceleration(effects%base_acceleration, share%mass, rule, element, term)
      if (allocated(effects%mass_damping)) &
        call add_mass_damping(effects%mass_damping, share%mass_matrix, state%velocity(ids), state%acceleration(ids), unknown, &
                              rule, term)
      if (allocated(effects%point_load)) &
        call add_point_loads(effects%point_load, e, state%point, rule, element, term)
      if (allocated(effects%fixed_point)) then
        if (effects%fixed_point%by_springs) &
          call add_fixed_springs(effects%fixed_point, e, state%point, rule%end_time, element, unknown, term)
      end if
    end associate
  end subroutine add_element_effects

  !> Whether the matrix of an iteration is symmetric.
  pure logical function symmetric_equations(effects, rule)
    type(effects_t), intent(in) :: effects
    type(step_rule_t), intent(in) :: rule
    real(dp), parameter :: same = 1e-12_dp

    symmetric_equations = .true.
    if (.not. effects%large_deformation) return
    if (rule%tangent) then
      symmetric_equations = abs(rule%operator_weight - 1) < same .and. abs(rule%stress_weight - 1) < same
    else
      symmetric_equations = abs(rule%operator_weight - 0.5_dp) < same
    end if
  end function symmetric_equations

end module scree_effects
