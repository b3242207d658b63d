!> Sweeps of sequential impulses over the rows of a step.
!>
!> Each row in turn gets the impulses with which its two bodies satisfy it, as if there were no others. With the *bias* a row is
!> a spring with a dashpot, of frequency w = (pi/2)/h and damping ratio 10, in a step of size h of implicit Euler. The spring takes
!> back overlap over some steps, and slip that friction holds. After the bodies have moved a second sweep without
!> bias takes out the velocity that the bias has given. Impulses across come before those along, of the same row, else friction
!> lags by a step.
!>
!> E. Catto, *Soft constraints* (GDC 2011) and *Solver2D* (2024); M. Macklin et al., *Small steps in physics simulation* (SCA 2019).
module scree_sweeps
  use scree_bodies, only: bodies_t
  use scree_contact_rows, only: in_frame, last_colour, parting_speed, row_point_t, row_t, rows_t
  use scree_kinds, only: dp, pi
  implicit none
  private
  public :: advance_rows, bounce, start_warm, sweep

  real(dp), parameter :: turn_in_a_step = pi/2   !! frequency of a soft row times the size of the step, rad
  real(dp), parameter :: damping = 10.0_dp       !! ratio of a soft row
  real(dp), parameter :: along_w = 2*damping + turn_in_a_step, stiff = turn_in_a_step*along_w
  real(dp), parameter, public :: bias_rate = turn_in_a_step/along_w !! fraction of an error that a step takes back
  real(dp), parameter, public :: mass_scale = stiff/(1 + stiff)     !! of a soft row
  real(dp), parameter, public :: impulse_scale = 1/(1 + stiff)      !! fraction of its impulse that a soft row gives up
  real(dp), parameter :: most_pushed = 0.02_dp   !! of a body, that an overlap is taken back by in a step
  real(dp), parameter :: at_limit = 1 - 1e-9_dp  !! fraction of a limit from which on it is reached
  !> Sweeps over points that bounce: until none changes by more than this ratio to the largest impulse, and at most. A flat block
  !> that kept a spin of 1e-3 of its speed would strike with one corner the next time.
  real(dp), parameter :: settled_bounce = 1e-12_dp
  integer, parameter :: most_bounces = 200

contains

  !> Gives the bodies the impulses of the step before.
  subroutine start_warm(rows, bodies)
    type(rows_t), intent(in) :: rows
    type(bodies_t), intent(inout) :: bodies
    integer :: c, i

    do c = 0, min(rows%n_colours, last_colour) - 1
      !$omp do schedule(static)
      do i = rows%first(c), rows%first(c + 1) - 1
        call strike_again(rows%row(i), bodies)
      end do
      !$omp end do
    end do
    if (rows%n_colours <= last_colour) return
    !$omp single
    do i = rows%first(last_colour), rows%first(last_colour + 1) - 1
      call strike_again(rows%row(i), bodies)
    end do
    !$omp end single
  end subroutine start_warm

  !> Gives both bodies of a row its impulses.
  subroutine strike_again(row, bodies)
    type(row_t), intent(in) :: row
    type(bodies_t), intent(inout) :: bodies
    real(dp) :: push, rub
    integer :: k

    do k = 1, row%n
      push = row%point(k)%push
      rub = row%point(k)%rub
      call strike(row%a, row%b, row%point(k), push, rub, bodies)
    end do
  end subroutine strike_again

  !> Strikes both bodies of a point.
  subroutine strike(a, b, point, across, along, bodies)
    integer, intent(in) :: a, b                !! bodies
    type(row_point_t), intent(in) :: point
    real(dp), intent(in) :: across, along      !! impulse on b
    type(bodies_t), intent(inout) :: bodies
    real(dp) :: impulse(2)

    impulse(1) = across*point%normal(1) - along*point%normal(2)
    impulse(2) = across*point%normal(2) + along*point%normal(1)
    if (bodies%moves(a)) then
      bodies%velocity(:, a) = bodies%velocity(:, a) - bodies%inverse_mass(a)*impulse
      bodies%spin(a) = bodies%spin(a) - bodies%inverse_inertia(a)*(point%arm_a(1)*along - point%arm_a(2)*across)
    end if
    if (bodies%moves(b)) then
      bodies%velocity(:, b) = bodies%velocity(:, b) + bodies%inverse_mass(b)*impulse
      bodies%spin(b) = bodies%spin(b) + bodies%inverse_inertia(b)*(point%arm_b(1)*along - point%arm_b(2)*across)
    end if
  end subroutine strike

  !> One sweep over all rows, colour by colour.
  subroutine sweep(with_bias, h, rows, bodies)
    logical, intent(in) :: with_bias
    real(dp), intent(in) :: h                  !! time
    type(rows_t), intent(inout) :: rows
    type(bodies_t), intent(inout) :: bodies
    integer :: c, i

    do c = 0, min(rows%n_colours, last_colour) - 1
      !$omp do schedule(static)
      do i = rows%first(c), rows%first(c + 1) - 1
        call settle_row(with_bias, h, rows%row(i), bodies)
      end do
      !$omp end do
    end do
    if (rows%n_colours <= last_colour) return
    !$omp single
    do i = rows%first(last_colour), rows%first(last_colour + 1) - 1
      call settle_row(with_bias, h, rows%row(i), bodies)
    end do
    !$omp end single
  end subroutine sweep

  !> Settles one row: its points across, then along.
  subroutine settle_row(with_bias, h, row, bodies)
    logical, intent(in) :: with_bias
    real(dp), intent(in) :: h                  !! time
    type(row_t), intent(inout) :: row
    type(bodies_t), intent(inout) :: bodies
    real(dp) :: bias, change, iia, iib, ima, imb, limit, most_push, speed, va(2), vb(2), wa, wb
    integer :: k

    va = bodies%velocity(:, row%a)
    vb = bodies%velocity(:, row%b)
    wa = bodies%spin(row%a)
    wb = bodies%spin(row%b)
    ima = bodies%inverse_mass(row%a)
    imb = bodies%inverse_mass(row%b)
    iia = bodies%inverse_inertia(row%a)
    iib = bodies%inverse_inertia(row%b)
    most_push = most_pushed*min(bodies%size(row%a), bodies%size(row%b))/h
    do k = 1, row%n
      associate (point => row%point(k), n => row%point(k)%normal)
        speed = n(1)*(vb(1) - va(1)) + n(2)*(vb(2) - va(2)) - wb*point%arm_b(2) + wa*point%arm_a(2)
        if (point%gap > 0 .and. .not. row%bonded) then
          change = -point%mass_across*(speed + point%gap/h)
        else if (with_bias) then
          bias = max(bias_rate/h*point%gap, -most_push)
          change = -point%mass_across*mass_scale*(speed + bias) - impulse_scale*point%push
        else
          change = -point%mass_across*speed
        end if
        change = max(-point%strength, point%push + change) - point%push
        point%push = point%push + change
        va(1) = va(1) - ima*change*n(1)
        va(2) = va(2) - ima*change*n(2)
        vb(1) = vb(1) + imb*change*n(1)
        vb(2) = vb(2) + imb*change*n(2)
        wa = wa + iia*point%arm_a(2)*change
        wb = wb - iib*point%arm_b(2)*change
      end associate
    end do
    do k = 1, row%n
      associate (point => row%point(k), n => row%point(k)%normal)
        speed = n(1)*(vb(2) - va(2)) - n(2)*(vb(1) - va(1)) + wb*point%arm_b(1) - wa*point%arm_a(1)
        if (with_bias) then
          change = -point%mass_along*mass_scale*(speed + bias_rate/h*point%held) - impulse_scale*point%rub
        else
          change = -point%mass_along*speed
        end if
        limit = point%friction*max(0.0_dp, point%push) + point%cohesion
        change = max(-limit, min(limit, point%rub + change)) - point%rub
        point%rub = point%rub + change
        va(1) = va(1) + ima*change*n(2)
        va(2) = va(2) - ima*change*n(1)
        vb(1) = vb(1) - imb*change*n(2)
        vb(2) = vb(2) + imb*change*n(1)
        wa = wa - iia*point%arm_a(1)*change
        wb = wb + iib*point%arm_b(1)*change
      end associate
    end do
    if (ima > 0) then
      bodies%velocity(:, row%a) = va
      bodies%spin(row%a) = wa
    end if
    if (imb > 0) then
      bodies%velocity(:, row%b) = vb
      bodies%spin(row%b) = wb
    end if
  end subroutine settle_row

  !> Moves the points of the rows on as the bodies move by a step: gaps, slips that friction holds, and arms. A point whose friction
  !> is at its limit holds the slip at which its spring bears that limit, as a slider in series with a spring does. A point that
  !> forgot the slip would lose a part of its friction in each step, and creep. The arms of both bodies end at one place, half-way
  !> between where the two take the point, so that what the second sweep gives has no torque.
  subroutine advance_rows(h, bodies, rows)
    real(dp), intent(in) :: h                  !! time
    type(bodies_t), intent(in) :: bodies       !! with the velocities of the step
    type(rows_t), intent(inout) :: rows
    real(dp) :: apart(2), limit, turn_a, turn_b, way(2), way_a(2), way_b(2)
    integer :: i, k

    !$omp do schedule(static)
    do i = 1, rows%n
      associate (row => rows%row(i))
        turn_a = h*bodies%spin(row%a)
        turn_b = h*bodies%spin(row%b)
        way(1) = h*(bodies%velocity(1, row%b) - bodies%velocity(1, row%a))
        way(2) = h*(bodies%velocity(2, row%b) - bodies%velocity(2, row%a))
        do k = 1, row%n
          associate (point => row%point(k))
            way_a = turn_a*[-point%arm_a(2), point%arm_a(1)]
            way_b = turn_b*[-point%arm_b(2), point%arm_b(1)]
            apart = in_frame(way, point%normal) + way_b - way_a
            point%gap = point%gap + apart(1)
            point%held = point%held + apart(2)
            limit = point%friction*max(0.0_dp, point%push) + point%cohesion
            if (limit <= 0 .or. abs(point%rub) >= at_limit*limit) then
              point%held = -h*point%rub/(point%mass_along*turn_in_a_step**2)
              point%slid = abs(apart(2))
            end if
            point%arm_a = point%arm_a + way_a + 0.5_dp*apart
            point%arm_b = point%arm_b + way_b - 0.5_dp*apart
          end associate
        end do
      end associate
    end do
    !$omp end do
  end subroutine advance_rows

  !> Lets points that were new in the step part by a fraction of the speed at which they came together. Friction bears up to its
  !> limit of the whole impulse across, that of compression and that of restitution (Poisson's hypothesis).
  subroutine bounce(least_speed, rows, bodies)
    real(dp), intent(in) :: least_speed        !! slower ones do not bounce, length/time
    type(rows_t), intent(inout) :: rows
    type(bodies_t), intent(inout) :: bodies
    real(dp) :: change, changed, largest, limit
    integer :: i, k, round

    do round = 1, most_bounces
      changed = 0.0_dp
      largest = 0.0_dp
      do i = 1, rows%n
        associate (row => rows%row(i))
          do k = 1, row%n
            associate (point => row%point(k))
              if (point%came > -least_speed .or. point%push <= 0) cycle
              change = point%mass_across*(parting_speed(row%a, row%b, point, bodies) + point%restitution*point%came)
              change = max(0.0_dp, point%push - change) - point%push
              point%push = point%push + change
              changed = max(changed, abs(change))
              largest = max(largest, point%push)
              call strike(row%a, row%b, point, change, 0.0_dp, bodies)
              limit = point%friction*point%push + point%cohesion
              change = point%rub - point%mass_along*slip_speed(row%a, row%b, point, bodies)
              change = max(-limit, min(limit, change)) - point%rub
              point%rub = point%rub + change
              changed = max(changed, abs(change))
              call strike(row%a, row%b, point, 0.0_dp, change, bodies)
            end associate
          end do
        end associate
      end do
      if (changed <= settled_bounce*largest) return
    end do
  end subroutine bounce

  !> Speed at which the sides of a point slide along its edge.
  pure real(dp) function slip_speed(a, b, point, bodies) result(speed)
    integer, intent(in) :: a, b                !! its bodies
    type(row_point_t), intent(in) :: point
    type(bodies_t), intent(in) :: bodies

    speed = point%normal(1)*(bodies%velocity(2, b) - bodies%velocity(2, a)) &
            - point%normal(2)*(bodies%velocity(1, b) - bodies%velocity(1, a)) &
            + bodies%spin(b)*point%arm_b(1) - bodies%spin(a)*point%arm_a(1)
  end function slip_speed

end module scree_sweeps
