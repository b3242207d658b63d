!> The acceleration that a step of the energy-decaying form hands on turns with its block.
!>
!> The step compares its change of velocity D1 = a1 dt with that of the step before, D0: d = dt (v0 + v1)/2 + e dt (D1 - D0). In a
!> body that spins freely D1 is D0 turned by the angle of a step. With Q D0 in place of D0, Q that turn, the step of such a body is
!> that of the energy-momentum form, which has its spin and its stress for ever, however large the angle. Any Q keeps D0.M D0, and
!> with it the bound of the energy; so Q can be what is known when the step begins (doc/theory.md, section 3).
!>
!> The mean D0 of a free body does not turn, as its weight does not. A body that is held turns about where it is held, whose D0
!> is 0.
module scree_turning
  use scree_interpolation, only: turned_rates
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_state, only: state_t
  use scree_system, only: values_of
  implicit none
  private
  public :: acceleration_of_spin, turn_acceleration

contains

  !> Turns the acceleration of all that moves with its blocks.
  pure subroutine turn_acceleration(model, cache, angle, acceleration)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    real(dp), intent(in) :: angle(:)           !! (n_blocks) rad
    real(dp), intent(inout) :: acceleration(:) !! (n_unknowns)

    acceleration = turned_field(model, cache, angle, acceleration)
  end subroutine turn_acceleration

  !> Acceleration that a run begins with, as if its bodies had always turned as they do: what their spin will change their velocity
  !> by in a step, over its size.
  pure function acceleration_of_spin(model, cache, state) result(acceleration)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    real(dp) :: acceleration(model%n_unknowns)
    real(dp), dimension(model%n_blocks) :: area, spin
    real(dp) :: L(4)
    integer :: e, k

    area = 0.0_dp
    spin = 0.0_dp
    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      associate (block => model%elements%block(e), element => cache%element(e)%kinematics)
        L = matmul(element%gradient, values_of(model%elements, e, state%velocity))
        area(block) = area(block) + element%area
        spin(block) = spin(block) + element%area*0.5_dp*(L(2) - L(3))
      end associate
    end do
    where (area > 0) spin = spin/area
    associate (dt => model%settings%step_size)
      acceleration = (turned_field(model, cache, 2*atan(0.5_dp*dt*spin), state%velocity) - state%velocity)/dt
    end associate
  end function acceleration_of_spin

  !> A field of rates turned by an angle in each block; where supports move it stays.
  pure function turned_field(model, cache, angle, rates) result(turned)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    real(dp), intent(in) :: angle(:)           !! (n_blocks) rad
    real(dp), intent(in) :: rates(:)           !! (n_unknowns)
    real(dp) :: turned(size(rates))
    real(dp) :: base(2, model%n_blocks)
    logical :: turns(model%n_blocks)
    integer :: e, k

    turns = abs(angle) > 0
    base = mean_vectors(model, cache, rates)
    if (allocated(model%effects%fixed_point)) then
      associate (points => model%effects%fixed_point)
        do e = 1, model%n_elements
          associate (block => model%elements%block(e))
            if (points%first(e + 1) > points%first(e)) base(:, block) = 0.0_dp
            do k = points%first(e), points%first(e + 1) - 1
              if (allocated(points%table(k)%time)) turns(block) = .false.
            end do
          end associate
        end do
      end associate
    end if
    turned = rates
    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      associate (block => model%elements%block(e))
        if (turns(block)) turned(model%elements%unknown(:, e)) = &
            turned_rates(model%model, angle(block), base(:, block), values_of(model%elements, e, rates))
      end associate
    end do
  end function turned_field

  !> Mean over the mass of each block of a field of rates.
  pure function mean_vectors(model, cache, rates) result(mean)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    real(dp), intent(in) :: rates(:)           !! (n_unknowns)
    real(dp) :: mean(2, model%n_blocks)
    real(dp) :: mass(model%n_blocks)
    integer :: e, k

    mean = 0.0_dp
    mass = 0.0_dp
    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      associate (block => model%elements%block(e), own => cache%element(e))
        mass(block) = mass(block) + own%mass
        mean(:, block) = mean(:, block) + own%mass*matmul(own%kinematics%at_centroid, values_of(model%elements, e, rates))
      end associate
    end do
    do k = 1, model%n_blocks
      if (mass(k) > 0) mean(:, k) = mean(:, k)/mass(k)
    end do
  end function mean_vectors

end module scree_turning
