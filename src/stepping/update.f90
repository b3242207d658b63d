!> What an accepted step changes: positions, stress, deformation, rotation and the rates (Shi's df25, df26).
module scree_update
  use scree_crack_hold, only: accept_hold
  use scree_element_term, only: step_rule_t
  use scree_impact, only: impact_t
  use scree_integrator, only: end_rates, turns_acceleration
  use scree_interpolation, only: carried_rates, follow_covers
  use scree_finite_rotation, only: turn_finitely
  use scree_green_strain, only: green_strain
  use scree_kinds, only: dp
  use scree_material, only: push_stress_forward
  use scree_model, only: cache_t, effects_t, model_t
  use scree_regions, only: first_vertex_of, last_vertex_of
  use scree_scene, only: rotation_linear
  use scree_state, only: state_t
  use scree_stiffness, only: small_strain
  use scree_strain_rotation, only: turned_stress
  use scree_system, only: element_unknowns, values_of
  use scree_turning, only: turn_acceleration
  implicit none
  private
  public :: update_state

  !> How an element moves in a step: as its centroid does, and by a gradient about it.
  type :: element_motion_t
    real(dp) :: centroid(2)     !! before, length
    real(dp) :: displacement(2) !! of it, length
    real(dp) :: gradient(4)     !! u_X, v_X, u_Y, v_Y
  end type element_motion_t

contains

  !> Moves `state` to the end of the step with unknowns `d`.
  pure subroutine update_state(model, cache, rule, d, impact, state)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(step_rule_t), intent(in) :: rule
    real(dp), intent(in) :: d(:)                  !! (n_unknowns) of the step
    type(impact_t), intent(in) :: impact          !! at its end
    type(state_t), intent(inout) :: state
    real(dp) :: theta(4), turned(4), F(4), own(element_unknowns), mean(4, model%n_blocks), angle(model%n_blocks)
    type(element_motion_t) :: motion(model%n_elements)
    integer :: e, i, k

    if (allocated(impact%push)) state%velocity = state%velocity + impact%push
    associate (last => model%last_free)
      call end_rates(rule, d(:last), state%velocity(:last), state%acceleration(:last))
    end associate
    if (allocated(impact%change)) state%velocity = state%velocity + impact%change
    do k = 1, size(model%free_block)
      mean(:, model%free_block(k)) = 0.0_dp
    end do
    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      associate (ids => model%elements%unknown(:, e), element => cache%element(e)%kinematics, shape => model%elements%shape, &
                 block => model%elements%block(e))
        own = values_of(model%elements, e, d)
        theta = matmul(element%gradient, own)
        call update_stress(model%effects, cache%element(e)%elasticity, theta, state%stress(:, e))
        motion(e) = element_motion_t(element%centroid, matmul(element%at_centroid, own), theta)
        if (model%effects%rotation /= rotation_linear) then
          turned = 0.0_dp
          call turn_finitely(model%effects%rotation, theta, turned, state%stress(:, e))
          motion(e)%gradient = theta + turned
        end if
        F = deformation_gradient(motion(e)%gradient)
        call move(motion(e), state%vertex(:, first_vertex_of(shape, e):last_vertex_of(shape, e)))
        state%deformation(:, e) = matrix_product(F, state%deformation(:, e))
        state%velocity(ids) = carried_rates(model%model, model%effects%transport, F, values_of(model%elements, e, state%velocity))
        state%acceleration(ids) = carried_rates(model%model, model%effects%transport, F, &
                                                values_of(model%elements, e, state%acceleration))
        mean(:, block) = mean(:, block) + element%area*F
      end associate
    end do
    do k = 1, size(model%points%free)
      i = model%points%free(k)
      call move(motion(model%points%element(i)), state%point(:, i:i))
    end do
    if (size(state%cover, 2) > 0) state%cover = state%cover + reshape(d, shape(state%cover)) ! a DDA block has no nodes
    angle = 0.0_dp
    do k = 1, size(model%free_block)
      i = model%free_block(k)
      associate (F => mean(:, i))
        angle(i) = atan2(F(2) - F(3), F(1) + F(4))
        state%rotation(i) = state%rotation(i) + angle(i)
      end associate
    end do
    if (allocated(state%hold)) call accept_hold(model%elements, d, angle, state%hold, state%books%fracture)
    if (turns_acceleration(model%settings)) call turn_acceleration(model, cache, angle, state%acceleration)
    if (allocated(model%sampling)) call follow_covers(model, state)
    if (model%effects%carried < 1) then
      state%velocity = model%effects%carried*state%velocity
      state%acceleration = model%effects%carried*state%acceleration
    end if
    state%time = state%time + rule%dt
    state%pace%last = rule%dt
    state%step = state%step + 1
  end subroutine update_state

  !> F = I + theta: xx, yx, xy, yy.
  pure function deformation_gradient(theta) result(F)
    real(dp), intent(in) :: theta(4) !! u_X, v_X, u_Y, v_Y
    real(dp) :: F(4)

    F = theta + [1.0_dp, 0.0_dp, 0.0_dp, 1.0_dp]
  end function deformation_gradient

  !> Adds the stress of the step: small strain adds components, Green strain pushes S forward with the step's F, the decomposition
  !> turns it.
  pure subroutine update_stress(effects, elasticity, theta, stress)
    type(effects_t), intent(in) :: effects
    real(dp), intent(in) :: elasticity(3, 3) !! force/length^2
    real(dp), intent(in) :: theta(4)
    real(dp), intent(inout) :: stress(3)

    if (effects%strain_rotation) then
      stress = turned_stress(elasticity, theta, stress)
    else if (effects%large_deformation) then
      stress = push_stress_forward(deformation_gradient(theta), stress + matmul(elasticity, green_strain(theta)))
    else
      stress = stress + matmul(elasticity, small_strain(theta))
    end if
  end subroutine update_stress

  !> Moves positions of an element.
  pure subroutine move(motion, position)
    type(element_motion_t), intent(in) :: motion
    real(dp), intent(inout) :: position(:, :) !! (2, n), length
    real(dp) :: arm(2)
    integer :: k

    do k = 1, size(position, 2)
      arm = position(:, k) - motion%centroid
      position(:, k) = position(:, k) + (motion%displacement + (motion%gradient(1:2)*arm(1) + motion%gradient(3:4)*arm(2)))
    end do
  end subroutine move

  !> A B of 2 x 2 matrices in columns.
  pure function matrix_product(A, B) result(C)
    real(dp), intent(in) :: A(4), B(4)
    real(dp) :: C(4)

    C = [A(1)*B(1) + A(3)*B(2), A(2)*B(1) + A(4)*B(2), A(1)*B(3) + A(3)*B(4), A(2)*B(3) + A(4)*B(4)]
  end function matrix_product

end module scree_update
