!> The contacts in the iteration of one step.
module scree_contact_try
  use scree_contact_geometry, only: entrance_geometry_t
  use scree_contact_quantities, only: entrance_start_t
  use scree_contacts, only: contact_law_t, contact_t
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_system, only: element_unknowns, values_of
  implicit none
  private
  public :: beyond_reference, contact_try_t, of_elements

  integer, parameter :: n = 2*element_unknowns

  !> The contacts of a step, and what its iteration makes of them.
  type :: contact_try_t
    type(contact_law_t) :: law                           !! with the stiffness of this try
    type(contact_t), allocatable :: contact(:)
    integer, allocatable :: pair(:, :)                   !! (2, n_pairs) elements that the equations couple
    integer, allocatable :: inside(:, :)                 !! (2, n) vertices, each with the edge that it is inside of
    integer, allocatable :: nearby(:, :)                 !! (2, n) vertices and edges near enough to meet in the step
    real(dp), allocatable :: near(:)                     !! (n) how far a vertex may move in the step, length
    real(dp), allocatable :: local(:)                    !! (n) shorter edge at each vertex, length
    real(dp), allocatable :: turning(:)                  !! (n) how far the corner at each vertex may turn in the step, rad
    real(dp) :: margin = 0.0_dp                          !! of the way, beyond what velocity makes, length
    real(dp) :: swing = 0.0_dp                           !! of the turn, beyond what velocity makes, rad
    logical :: linear = .true.                           !! gaps and slips are, in displacements; else some follow the motion
    real(dp) :: weight = 1.0_dp                          !! of the displacement in the configuration where forces act
    real(dp) :: hardening = 1.0_dp                       !! of the springs across in this step, so that multipliers follow faster
    real(dp) :: left = huge(1.0_dp)                      !! largest gap or overlap above the bound of multipliers, length
    real(dp) :: dashpot = 0.0_dp                         !! viscosity over the size of the step, force/length
    type(entrance_start_t), allocatable :: start(:, :)   !! (2, n)
    type(entrance_geometry_t), allocatable :: geometry(:, :) !! (2, n), gaps from where the springs rest
    real(dp), allocatable :: reference(:)                !! (n_unknowns) displacement that the geometry is of
    logical :: lines_stay = .false.                      !! entrances that act, and anchors, as they are
    integer :: count(3) = 0                              !! contacts open, sliding, locked
    integer :: changes = 0                               !! of states, in the last judgement
  end type contact_try_t

contains

  !> Values of the unknowns of two elements.
  pure function of_elements(model, pair, d)
    type(model_t), intent(in) :: model
    integer, intent(in) :: pair(2)
    real(dp), intent(in) :: d(:) !! (n_unknowns)
    real(dp) :: of_elements(n)

    of_elements(:n/2) = values_of(model%elements, pair(1), d)
    of_elements(n/2 + 1:) = values_of(model%elements, pair(2), d)
  end function of_elements

  !> How far the unknowns of two elements are from a reference.
  pure function beyond_reference(model, pair, d, reference) result(change)
    type(model_t), intent(in) :: model
    integer, intent(in) :: pair(2)
    real(dp), intent(in) :: d(:), reference(:) !! (n_unknowns)
    real(dp) :: change(n)
    integer :: i

    do i = 1, n/2
      associate (first => model%elements%unknown(i, pair(1)), second => model%elements%unknown(i, pair(2)))
        change(i) = d(first) - reference(first)
        change(n/2 + i) = d(second) - reference(second)
      end associate
    end do
  end function beyond_reference

end module scree_contact_try
