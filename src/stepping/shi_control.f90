!> The step size that Shi's programs choose for themselves ("step" of df), for comparison.
module scree_shi_control
  use scree_contacts, only: contact_memory_t
  use scree_kinds, only: dp
  use scree_scene, only: scene_t
  use scree_state, only: state_t
  use scree_system, only: system_t
  implicit none
  private
  public :: first_size, following_size

  real(dp), parameter :: growth = 1.3_dp    !! of a step over the one before, at most

contains

  !> Size of the first step, in which weight, initial stress or loads may move a block as far as a step may.
  pure real(dp) function first_size(scene, model, state)
    type(scene_t), intent(in) :: scene
    class(system_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(dp) :: push, stress
    integer :: i

    stress = 0.0_dp
    do i = 1, size(scene%block_material)
      stress = max(stress, maxval(abs(scene%block_material(i)%stress)))
    end do
    push = max(abs(scene%block_material(1)%unit_weight)/scene%block_material(1)%density, &
               (4*stress*sqrt(block_mass(scene, model)/scene%block_material(1)%density) + largest_load(scene)) &
               /block_mass(scene, model))
    first_size = time_to_move(scene%settings%most_travel, maxval(abs(state%velocity)), push, huge(push))
    if (first_size >= huge(push)) first_size = scene%settings%step_size
  end function first_size

  !> Size of the step after one of size `dt` that moved a vertex by `travel`, with the forces of its contacts and of loads.
  pure real(dp) function following_size(scene, model, contacts, dt, travel)
    type(scene_t), intent(in) :: scene
    class(system_t), intent(in) :: model
    type(contact_memory_t), intent(in) :: contacts
    real(dp), intent(in) :: dt, travel
    real(dp) :: force

    force = largest_load(scene)
    if (allocated(contacts%contact)) force = max(force, maxval(contacts%contact%force(1)))
    following_size = time_to_move(scene%settings%most_travel, merge(travel/dt, 0.0_dp, .not. scene%is_static()), &
                                  force/block_mass(scene, model), growth*dt)
  end function following_size

  !> Time in which a speed and an acceleration make a distance, at most `longest`.
  pure real(dp) function time_to_move(distance, speed, acceleration, longest) result(time)
    real(dp), intent(in) :: distance, speed, acceleration, longest

    time = longest
    if (speed + sqrt(acceleration*distance) > 0) &
      time = min(longest, 2*distance/(speed + sqrt(speed**2 + 2*acceleration*distance)))
  end function time_to_move

  !> Mass of a block of mean area, of material 1; per unit thickness. Areas are those of the blocks that have a mass.
  pure real(dp) function block_mass(scene, model)
    type(scene_t), intent(in) :: scene
    class(system_t), intent(in) :: model
    logical :: has_mass(model%n_blocks)
    real(dp) :: area
    integer :: e

    has_mass = .false.
    area = 0.0_dp
    do e = 1, size(model%elements%mass)
      if (.not. model%elements%mass(e) > 0) cycle
      has_mass(model%elements%block(e)) = .true.
      area = area + model%elements%mass(e)/scene%block_material(model%elements%material(e))%density
    end do
    block_mass = area/count(has_mass)*scene%block_material(1)%density
  end function block_mass

  !> Largest force of a load point at any time.
  pure real(dp) function largest_load(scene)
    type(scene_t), intent(in) :: scene
    integer :: i

    largest_load = 0.0_dp
    if (.not. allocated(scene%load_table)) return
    do i = 1, size(scene%load_table)
      if (allocated(scene%load_table(i)%value)) &
        largest_load = max(largest_load, maxval(norm2(scene%load_table(i)%value, 1)))
    end do
  end function largest_load

end module scree_shi_control
