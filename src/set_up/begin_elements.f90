!> What elements begin with: cells, mass, stress, velocity.
module scree_begin_elements
  use scree_block_input, only: block_moments, blocks_t
  use scree_in_situ, only: in_situ_stress
  use scree_interpolation, only: kinematics_of, kinematics_t, rigid_velocity
  use scree_kinds, only: dp
  use scree_scene, only: scene_t, strain_green, strain_rotation
  use scree_second_order, only: cut_into_cells
  use scree_simplex_integration, only: moments_t
  use scree_state, only: state_t
  use scree_system, only: system_t
  implicit none
  private
  public :: begin_elements, middle_of

contains

  !> Cuts elements of second order up into cells, and gives all elements what they begin with: mass, stress, velocity.
  subroutine begin_elements(scene, blocks, system, state)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(system_t), intent(inout) :: system
    type(state_t), intent(inout) :: state
    type(kinematics_t) :: element
    type(moments_t) :: moments
    real(dp) :: centroid(2, size(blocks%material)), middle(2)
    integer :: b, e, k

    middle = middle_of(blocks)
    do b = 1, size(blocks%material)
      moments = block_moments(blocks, b)
      centroid(:, b) = moments%centroid - middle
    end do
    if (scene%settings%second_order) then
      allocate (system%sampling)
      call cut_into_cells(state%cover, state%point, system%elements, state%vertex, system%points%element, system%sampling)
      system%n_elements = size(system%elements%block)
    end if
    system%n_unknowns = maxval(system%elements%unknown)
    allocate (system%elements%mass(system%n_elements))
    allocate (state%stress(3, system%n_elements), state%deformation(4, system%n_elements))
    allocate (state%velocity(system%n_unknowns), state%acceleration(system%n_unknowns), source=0.0_dp)
    allocate (state%green(system%n_elements), &
              source=any(scene%settings%strain == [strain_green, strain_rotation]))
    allocate (state%rotation(system%n_blocks), source=0.0_dp)
    allocate (state%pair(2, 0))
    do e = 1, system%n_elements
      element = kinematics_of(system, state, e)
      associate (material => scene%block_material(system%elements%material(e)))
        system%elements%mass(e) = material%density*element%area
        state%stress(:, e) = material%stress + (element%centroid(2) + system%origin(2))*material%stress_gradient
        if (allocated(scene%settings%k0)) &
          state%stress(:, e) = in_situ_stress(scene, blocks, element%centroid + system%origin, system%elements%material(e))
        state%deformation(:, e) = [1.0_dp, 0.0_dp, 0.0_dp, 1.0_dp]
        if (scene%is_static()) cycle ! a static run begins at rest
        state%velocity(system%elements%unknown(:, e)) = rigid_velocity(system, state, e, &
          centroid(:, system%elements%block(e)), material%velocity)
        if (.not. allocated(system%sampling)) cycle
        do k = 1, size(system%elements%cover, 1)
          associate (c => system%elements%cover(k, e), arm => state%cover(:, system%elements%cover(k, e)) &
                                                               - centroid(:, system%elements%block(e)))
            state%velocity(2*c - 1:2*c) = material%velocity(1:2) + material%velocity(3)*[-arm(2), arm(1)]
          end associate
        end do
      end associate
    end do
  end subroutine begin_elements

  !> Middle of the box around the blocks.
  pure function middle_of(blocks) result(middle)
    type(blocks_t), intent(in) :: blocks
    real(dp) :: middle(2)                   !! length

    middle = 0.5_dp*(minval(blocks%vertex, 2) + maxval(blocks%vertex, 2))
  end function middle_of

end module scree_begin_elements
