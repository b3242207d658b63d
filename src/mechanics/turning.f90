!> The acceleration that a step of the energy-decaying form hands on turns with its block.
!>
!> The step compares its change of velocity D1 = a1 dt with that of the step before, D0: d = dt (v0 + v1)/2 + e dt (D1 - D0). In a
!> body that spins freely D1 is D0 turned by the angle of a step. With Q D0 in place of D0, Q that turn, the step of such a body is
!> that of the energy-momentum form, which has its spin and its stress for ever, however large the angle. Any Q keeps D0.M D0, and
!> with it the bound of the energy; so Q can be what is known when the step begins (doc/theory/integrators.md, eq-energy-decaying).
!>
!> The mean D0 of a free body does not turn, as its weight does not. A body that is held turns about where it is held, whose D0
!> is 0.
module scree_turning
  use scree_effects, only: has_fixed_point
  use scree_interpolation, only: turned_rates, turned_vector
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_state, only: state_t
  use scree_system, only: element_unknowns, last_of_block, values_of
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
    associate (dt => state%pace%size)
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
    integer :: from, to

    turned = rates
    from = 1
    associate (free => model%elements%free, block => model%elements%block)
      do while (from <= size(free))
        to = last_of_block(model%elements, from)
        if (abs(angle(block(free(to)))) > 0) call turn_block(model, cache, free(from:to), angle(block(free(to))), turned)
        from = to + 1
      end do
    end associate
  end function turned_field

  !> Turns rates in one block, about its mean over the mass, or about zero where it is held; where supports move it stays.
  pure subroutine turn_block(model, cache, members, angle, rates)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    integer, intent(in) :: members(:)          !! elements of the block
    real(dp), intent(in) :: angle              !! rad
    real(dp), intent(inout) :: rates(:)        !! (n_unknowns)
    real(dp) :: mass, mean(2), before(element_unknowns, size(members))
    integer :: i, k

    mass = 0.0_dp
    mean = 0.0_dp
    do i = 1, size(members)
      before(:, i) = values_of(model%elements, members(i), rates)
      associate (own => cache%element(members(i)))
        mass = mass + own%mass
        mean = mean + own%mass*matmul(own%kinematics%at_centroid, before(:, i))
      end associate
    end do
    if (mass > 0) mean = mean/mass
    if (allocated(model%effects%fixed_point)) then
      if (has_fixed_point(model, members)) mean = 0.0_dp
      associate (points => model%effects%fixed_point)
        do i = 1, size(members)
          do k = points%first(members(i)), points%first(members(i) + 1) - 1
            if (allocated(points%table(k)%time)) return
          end do
        end do
      end associate
    end if
    if (allocated(model%sampling)) then
      call turn_covers(model%elements%cover(:, members), angle, mean, rates)
      return
    end if
    do i = 1, size(members)
      rates(model%elements%unknown(:, members(i))) = turned_rates(model%model, angle, mean, before(:, i))
    end do
  end subroutine turn_block

  !> Turns rates of covers, each once. What follows them is left to who follows.
  pure subroutine turn_covers(cover, angle, base, rates)
    integer, intent(in) :: cover(:, :)
    real(dp), intent(in) :: angle              !! rad
    real(dp), intent(in) :: base(2)            !! rate that stays
    real(dp), intent(inout) :: rates(:)        !! (n_unknowns)
    logical :: done(maxval(cover))
    integer :: i, k

    done = .false.
    do i = 1, size(cover, 2)
      do k = 1, size(cover, 1)
        associate (c => cover(k, i))
          if (done(c)) cycle
          done(c) = .true.
          rates(2*c - 1:2*c) = turned_vector(angle, base, rates(2*c - 1:2*c))
        end associate
      end do
    end do
  end subroutine turn_covers

end module scree_turning
