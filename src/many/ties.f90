!> What holds rigid bodies but contacts: fixed points, rollers, points that move by tables, and bolts.
!>
!> A tie is a row without friction between a point of a body and one of another body or of the ground. A fixed point has two
!> rows and a roller one: their impulses have no limit, and the first sweep takes back an error of the place as it does an
!> overlap. A bolt is one row along its axis, a spring by implicit Euler. Of its tension N(l) = k (l - r) at the end of the step the
!> impulse is h N, at most h times the strength.
module scree_ties
  use scree_bodies, only: bodies_t
  use scree_bolt, only: axis_of
  use scree_fixed_point, only: is_roller
  use scree_kinds, only: dp
  use scree_many_bodies, only: arm_of
  use scree_model, only: cache_t, model_t
  use scree_state, only: bolt_broken, bolt_memory_t, state_t
  use scree_sweeps, only: bias_rate, impulse_scale, mass_scale
  use scree_time_table, only: value_at
  implicit none
  private
  public :: count_ties, find_ties, move_points, start_ties_warm, sweep_ties, tie_t, turn_arms, work_of_ties

  !> A row between a point of a body and one of another body or of the ground.
  type :: tie_t
    integer :: body(2) = 0               !! 0: the ground
    real(dp) :: arm(2, 2) = 0.0_dp       !! (xy, end) from the centroid, length
    real(dp) :: axis(2) = 0.0_dp         !! of length 1, from the first end to the second
    real(dp) :: error = 0.0_dp           !! how far they are too much apart along it; of a bolt its stretch, length
    real(dp) :: speed = 0.0_dp           !! at which the ground moves the first end along it, length/time
    real(dp) :: stiffness = -1.0_dp      !! below 0: rigid, force/length per unit thickness
    real(dp) :: strength = huge(1.0_dp)  !! in tension, impulse
    real(dp) :: mass = 0.0_dp            !! that it sees, mass/length
    real(dp) :: impulse = 0.0_dp         !! on the second end along the axis, force time per unit thickness
  end type tie_t

contains

  !> Rows that the fixed points of what moves and the bolts have.
  integer function count_ties(model, bodies) result(n)
    type(model_t), intent(in) :: model
    type(bodies_t), intent(in) :: bodies
    integer :: e, i, k

    n = 0
    if (allocated(model%effects%fixed_point)) then
      associate (fixed => model%effects%fixed_point)
        do k = 1, size(model%elements%free)
          e = model%elements%free(k)
          if (.not. bodies%moves(model%elements%block(e))) cycle
          do i = fixed%first(e), fixed%first(e + 1) - 1
            n = n + merge(1, 2, is_roller(fixed, i))
          end do
        end do
      end associate
    end if
    if (allocated(model%effects%bolt)) n = n + size(model%effects%bolt%stiffness, 2)
  end function count_ties

  !> Places where the points of bodies that move are now.
  subroutine move_points(model, cache, state, bodies, point)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache       !! of the state
    type(state_t), intent(in) :: state       !! when the step of the run began
    type(bodies_t), intent(in) :: bodies
    real(dp), intent(inout) :: point(:, :)   !! (2, n_points) length
    integer :: e, i, k

    do k = 1, size(model%points%free)
      i = model%points%free(k)
      e = model%points%element(i)
      associate (b => model%elements%block(e))
        point(:, i) = bodies%place(:, b) + arm_of(cache, state, bodies, e, b, i)
      end associate
    end do
  end subroutine move_points

  !> Places the ties at the beginning of a small step; their impulses stay.
  subroutine find_ties(model, bodies, point, bolts, from, h, ties)
    type(model_t), intent(in) :: model
    type(bodies_t), intent(in) :: bodies
    real(dp), intent(in) :: point(:, :)      !! (2, n_points) now, length
    type(bolt_memory_t), allocatable, intent(in) :: bolts
    real(dp), intent(in) :: from, h          !! when the small step begins, and its size; time
    type(tie_t), intent(inout) :: ties(:)
    integer :: e, k, n

    n = 0
    if (allocated(model%effects%fixed_point)) then
      do k = 1, size(model%elements%free)
        e = model%elements%free(k)
        if (bodies%moves(model%elements%block(e))) call hold_points(e)
      end do
    end if
    if (allocated(model%effects%bolt)) then
      do k = 1, size(model%effects%bolt%stiffness, 2)
        n = n + 1
        call span(k, ties(n))
      end do
    end if

  contains

    !> Rows of the points of an element.
    subroutine hold_points(e)
      integer, intent(in) :: e
      real(dp) :: target(2), speed(2)
      integer :: axis, i

      associate (fixed => model%effects%fixed_point, b => model%elements%block(e))
        do i = fixed%first(e), fixed%first(e + 1) - 1
          target = fixed%home(:, i)
          speed = 0.0_dp
          if (allocated(fixed%table(i)%time)) then
            speed = (value_at(fixed%table(i), from + h) - value_at(fixed%table(i), from))/h
            target = target + value_at(fixed%table(i), from) - value_at(fixed%table(i), 0.0_dp)
          end if
          if (is_roller(fixed, i)) then
            n = n + 1
            call hold(b, point(:, fixed%point(i)), target, speed, fixed%direction(:, i), ties(n))
          else
            do axis = 1, 2
              n = n + 1
              call hold(b, point(:, fixed%point(i)), target, speed, merge(1.0_dp, 0.0_dp, [axis == 1, axis == 2]), ties(n))
            end do
          end if
        end do
      end associate
    end subroutine hold_points

    !> A row that holds a point of a body in a direction.
    subroutine hold(b, x, target, speed, axis, tie)
      integer, intent(in) :: b
      real(dp), intent(in) :: x(2), target(2), speed(2), axis(2)
      type(tie_t), intent(inout) :: tie

      tie%body = [0, b]
      tie%arm(:, 2) = x - bodies%place(:, b)
      tie%axis = axis
      tie%error = dot_product(axis, x - target)
      tie%speed = dot_product(axis, speed)
      call weigh(tie)
    end subroutine hold

    !> The row of a bolt. One that is broken or absent sees no mass.
    subroutine span(i, tie)
      integer, intent(in) :: i
      type(tie_t), intent(inout) :: tie
      integer :: side

      associate (bolt => model%effects%bolt)
        tie%axis = axis_of(bolt, i, point)
        tie%error = norm2(tie%axis) - bolts%rest(i)
        tie%axis = tie%axis/norm2(tie%axis)
        tie%stiffness = bolt%stiffness(1, i)
        tie%strength = huge(1.0_dp)
        if (bolt%strength(1, i) < huge(1.0_dp)/max(1.0_dp, h)) tie%strength = bolt%strength(1, i)*h
        do side = 1, 2
          tie%body(side) = 0
          if (bolt%element(side, i) == 0) cycle
          tie%body(side) = model%elements%block(bolt%element(side, i))
          tie%arm(:, side) = point(:, bolt%point(side, i)) - bodies%place(:, tie%body(side))
        end do
      end associate
      call weigh(tie)
      if (bolts%state(i) < bolt_broken) return
      tie%mass = 0.0_dp
      tie%impulse = 0.0_dp
    end subroutine span

    !> Finds the mass that a tie sees: 0 between two ends that cannot move.
    subroutine weigh(tie)
      type(tie_t), intent(inout) :: tie
      real(dp) :: mobility
      integer :: side

      mobility = 0.0_dp
      do side = 1, 2
        if (tie%body(side) == 0) cycle
        associate (b => tie%body(side), arm => tie%arm(:, side))
          mobility = mobility + bodies%inverse_mass(b) &
                     + bodies%inverse_inertia(b)*(arm(1)*tie%axis(2) - arm(2)*tie%axis(1))**2
        end associate
      end do
      tie%mass = 0.0_dp
      if (mobility > 0) tie%mass = 1/mobility
    end subroutine weigh

  end subroutine find_ties

  !> Gives the bodies the impulses of the small step before.
  subroutine start_ties_warm(ties, bodies)
    type(tie_t), intent(in) :: ties(:)
    type(bodies_t), intent(inout) :: bodies
    integer :: i

    do i = 1, size(ties)
      call strike(ties(i), ties(i)%impulse, bodies)
    end do
  end subroutine start_ties_warm

  !> One sweep over all ties. That without bias leaves bolts alone, whose forces belong to the first one.
  subroutine sweep_ties(with_bias, h, ties, bodies)
    logical, intent(in) :: with_bias
    real(dp), intent(in) :: h                !! time
    type(tie_t), intent(inout) :: ties(:)
    type(bodies_t), intent(inout) :: bodies
    real(dp) :: change, speed
    integer :: i

    do i = 1, size(ties)
      associate (tie => ties(i))
        if (.not. tie%mass > 0) cycle
        if (tie%stiffness >= 0 .and. .not. with_bias) cycle
        speed = speed_apart(tie, bodies)
        if (tie%stiffness >= 0) then
          change = (-tie%stiffness*h*(tie%error + h*speed) - tie%impulse)/(1 + tie%stiffness*h**2/tie%mass)
          change = max(-tie%strength, tie%impulse + change) - tie%impulse
        else if (with_bias) then
          change = -tie%mass*mass_scale*(speed + bias_rate/h*tie%error) - impulse_scale*tie%impulse
        else
          change = -tie%mass*speed
        end if
        tie%impulse = tie%impulse + change
        call strike(tie, change, bodies)
      end associate
    end do
  end subroutine sweep_ties

  !> Speed at which the ends of a tie part, length/time.
  pure real(dp) function speed_apart(tie, bodies) result(speed)
    type(tie_t), intent(in) :: tie
    type(bodies_t), intent(in) :: bodies
    integer :: side

    speed = -tie%speed
    do side = 1, 2
      if (tie%body(side) == 0) cycle
      associate (b => tie%body(side), arm => tie%arm(:, side))
        speed = speed + (2*side - 3)*dot_product(tie%axis, bodies%velocity(:, b) + bodies%spin(b)*[-arm(2), arm(1)])
      end associate
    end do
  end function speed_apart

  !> Strikes both bodies of a tie.
  subroutine strike(tie, impulse, bodies)
    type(tie_t), intent(in) :: tie
    real(dp), intent(in) :: impulse          !! on the second, along the axis
    type(bodies_t), intent(inout) :: bodies
    integer :: side

    do side = 1, 2
      if (tie%body(side) == 0) cycle
      associate (b => tie%body(side), arm => tie%arm(:, side), own => (2*side - 3)*impulse)
        bodies%velocity(:, b) = bodies%velocity(:, b) + own*bodies%inverse_mass(b)*tie%axis
        bodies%spin(b) = bodies%spin(b) + own*bodies%inverse_inertia(b)*(arm(1)*tie%axis(2) - arm(2)*tie%axis(1))
      end associate
    end do
  end subroutine strike

  !> Turns the arms of the ties with their bodies as these move by a small step.
  subroutine turn_arms(h, bodies, ties)
    real(dp), intent(in) :: h                !! time
    type(bodies_t), intent(in) :: bodies
    type(tie_t), intent(inout) :: ties(:)
    integer :: i, side

    do i = 1, size(ties)
      do side = 1, 2
        if (ties(i)%body(side) == 0) cycle
        associate (arm => ties(i)%arm(:, side), turn => h*bodies%spin(ties(i)%body(side)))
          arm = [cos(turn)*arm(1) - sin(turn)*arm(2), sin(turn)*arm(1) + cos(turn)*arm(2)]
        end associate
      end do
    end do
  end subroutine turn_arms

  !> Work of what moves the ground ends in a small step, force length per unit thickness.
  pure real(dp) function work_of_ties(ties) result(work)
    type(tie_t), intent(in) :: ties(:)

    work = sum(ties%impulse*ties%speed)
  end function work_of_ties

end module scree_ties
