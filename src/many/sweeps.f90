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
  use scree_contact_rows, only: last_colour, row_t, rows_t
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
  integer, parameter :: sweeps_of_bounces = 8    !! two points of a flat block settle in these to 1 %

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
    integer :: k

    do k = 1, row%n
      call strike(row, k, row%push(k)*row%normal(:, k) + row%rub(k)*[-row%normal(2, k), row%normal(1, k)], bodies)
    end do
  end subroutine strike_again

  !> Strikes both bodies of a row at a point.
  subroutine strike(row, k, impulse, bodies)
    type(row_t), intent(in) :: row
    integer, intent(in) :: k
    real(dp), intent(in) :: impulse(2)         !! on b
    type(bodies_t), intent(inout) :: bodies

    if (bodies%moves(row%a)) then
      bodies%velocity(:, row%a) = bodies%velocity(:, row%a) - bodies%inverse_mass(row%a)*impulse
      bodies%spin(row%a) = bodies%spin(row%a) - bodies%inverse_inertia(row%a)*cross(row%arm_a(:, k), impulse)
    end if
    if (bodies%moves(row%b)) then
      bodies%velocity(:, row%b) = bodies%velocity(:, row%b) + bodies%inverse_mass(row%b)*impulse
      bodies%spin(row%b) = bodies%spin(row%b) + bodies%inverse_inertia(row%b)*cross(row%arm_b(:, k), impulse)
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
    real(dp) :: bias, change, iia, iib, ima, imb, impulse(2), limit, most_push, speed, t(2), va(2), vb(2), wa, wb
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
      speed = row%normal(1, k)*(vb(1) - wb*row%arm_b(2, k) - va(1) + wa*row%arm_a(2, k)) &
              + row%normal(2, k)*(vb(2) + wb*row%arm_b(1, k) - va(2) - wa*row%arm_a(1, k))
      if (row%gap(k) > 0 .and. .not. row%bonded) then
        change = -row%mass_across(k)*(speed + row%gap(k)/h)
      else if (with_bias) then
        bias = max(bias_rate/h*row%gap(k), -most_push)
        change = -row%mass_across(k)*mass_scale*(speed + bias) - impulse_scale*row%push(k)
      else
        change = -row%mass_across(k)*speed
      end if
      change = max(-row%strength(k), row%push(k) + change) - row%push(k)
      row%push(k) = row%push(k) + change
      impulse = change*row%normal(:, k)
      va = va - ima*impulse
      vb = vb + imb*impulse
      wa = wa - iia*(row%arm_a(1, k)*impulse(2) - row%arm_a(2, k)*impulse(1))
      wb = wb + iib*(row%arm_b(1, k)*impulse(2) - row%arm_b(2, k)*impulse(1))
    end do
    do k = 1, row%n
      t(1) = -row%normal(2, k)
      t(2) = row%normal(1, k)
      speed = t(1)*(vb(1) - wb*row%arm_b(2, k) - va(1) + wa*row%arm_a(2, k)) &
              + t(2)*(vb(2) + wb*row%arm_b(1, k) - va(2) - wa*row%arm_a(1, k))
      if (with_bias) then
        change = -row%mass_along(k)*mass_scale*(speed + bias_rate/h*row%held(k)) - impulse_scale*row%rub(k)
      else
        change = -row%mass_along(k)*speed
      end if
      limit = row%friction(k)*max(0.0_dp, row%push(k)) + row%cohesion(k)
      change = max(-limit, min(limit, row%rub(k) + change)) - row%rub(k)
      row%rub(k) = row%rub(k) + change
      impulse = change*t
      va = va - ima*impulse
      vb = vb + imb*impulse
      wa = wa - iia*(row%arm_a(1, k)*impulse(2) - row%arm_a(2, k)*impulse(1))
      wb = wb + iib*(row%arm_b(1, k)*impulse(2) - row%arm_b(2, k)*impulse(1))
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

  !> Moves the points of the rows on as the bodies move by a step: gaps, slips that friction holds, and arms. The arms of both
  !> bodies end at one place, half-way between where the two take the point, so that what the second sweep gives has no torque.
  subroutine advance_rows(h, bodies, rows)
    real(dp), intent(in) :: h                  !! time
    type(bodies_t), intent(in) :: bodies       !! with the velocities of the step
    type(rows_t), intent(inout) :: rows
    real(dp) :: apart(2), limit, slip, way_a(2), way_b(2)
    integer :: i, k

    !$omp do schedule(static)
    do i = 1, rows%n
      associate (row => rows%row(i), wa => bodies%spin(rows%row(i)%a), wb => bodies%spin(rows%row(i)%b))
        do k = 1, row%n
          way_a = h*wa*[-row%arm_a(2, k), row%arm_a(1, k)]
          way_b = h*wb*[-row%arm_b(2, k), row%arm_b(1, k)]
          apart = h*(bodies%velocity(:, row%b) - bodies%velocity(:, row%a)) + way_b - way_a
          slip = row%normal(1, k)*apart(2) - row%normal(2, k)*apart(1)
          row%gap(k) = row%gap(k) + dot_product(row%normal(:, k), apart)
          row%held(k) = row%held(k) + slip
          limit = row%friction(k)*max(0.0_dp, row%push(k)) + row%cohesion(k)
          row%slid(k) = 0.0_dp
          if (limit <= 0 .or. abs(row%rub(k)) >= at_limit*limit) then
            row%held(k) = 0.0_dp
            row%slid(k) = abs(slip)
          end if
          row%arm_a(:, k) = row%arm_a(:, k) + way_a + 0.5_dp*apart
          row%arm_b(:, k) = row%arm_b(:, k) + way_b - 0.5_dp*apart
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
    real(dp) :: apart(2), change, limit, t(2)
    integer :: i, k, round

    do round = 1, sweeps_of_bounces
      do i = 1, rows%n
        associate (row => rows%row(i))
          do k = 1, row%n
            if (row%came(k) > -least_speed .or. row%push(k) <= 0) cycle
            apart = parting(row, k, bodies)
            change = row%mass_across(k)*(dot_product(row%normal(:, k), apart) + row%restitution(k)*row%came(k))
            change = max(0.0_dp, row%push(k) - change) - row%push(k)
            row%push(k) = row%push(k) + change
            call strike(row, k, change*row%normal(:, k), bodies)
            t = [-row%normal(2, k), row%normal(1, k)]
            apart = parting(row, k, bodies)
            limit = row%friction(k)*row%push(k) + row%cohesion(k)
            change = max(-limit, min(limit, row%rub(k) - row%mass_along(k)*dot_product(t, apart))) - row%rub(k)
            row%rub(k) = row%rub(k) + change
            call strike(row, k, change*t, bodies)
          end do
        end associate
      end do
    end do
  end subroutine bounce

  !> Velocity at which the sides of a point part (2), length/time.
  pure function parting(row, k, bodies)
    type(row_t), intent(in) :: row
    integer, intent(in) :: k
    type(bodies_t), intent(in) :: bodies
    real(dp) :: parting(2)

    associate (va => bodies%velocity(:, row%a), vb => bodies%velocity(:, row%b), wa => bodies%spin(row%a), wb => bodies%spin(row%b))
      parting = vb + wb*[-row%arm_b(2, k), row%arm_b(1, k)] - va - wa*[-row%arm_a(2, k), row%arm_a(1, k)]
    end associate
  end function parting

  !> Of two vectors.
  pure real(dp) function cross(a, b)
    real(dp), intent(in) :: a(2), b(2)

    cross = a(1)*b(2) - a(2)*b(1)
  end function cross

end module scree_sweeps
