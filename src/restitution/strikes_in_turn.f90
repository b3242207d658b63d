!> Impacts that follow each other within a step.
!>
!> Bodies move as rigid ones at constant velocities q between impacts. With t the time over the step, the gap of contact i is
!>
!>     g_i(t) = g_i(0) + dt (integral of G_i q from 0 to t)
!>
!> and the contact strikes when the gap is zero and the bodies approach, G_i q < 0. That impact has a compression and a restitution
!> (`scree_impulses`). Only the contacts that strike then have a part in the impact, with the contacts that bear or touch and are
!> connected with the former by bodies that move. The bodies go on with the new velocities, until the step ends. With the change
!> dq_k of the velocities by impact k at the time t_k, bodies are at the end of the step by
!>
!>     dt (sum of (1 - t_k) dq_k)
!>
!> farther than without impacts, so this sum is the velocity that makes up for the impacts where it is added when the step begins.
!> Momentum is kept in each impact, and no impact makes energy (`scree_impulses`), so none is made by any number of impacts.
!>
!> Contacts between the same two bodies, or between one body and bodies that do not move, are one impact, as are contacts whose
!> times over the step differ by no more than `together`.
module scree_strikes_in_turn
  use scree_impulse_problem, only: impulse_problem_t, impulses_t, velocity_at
  use scree_impulses, only: energy_of, restore, solve_compression
  use scree_kinds, only: dp
  implicit none
  private
  public :: course_t, share_given_back, strike_in_turn, strikers_t

  !> Impacts within this time over the step after the first of them are one impact, also if the step ends between them. An approach
  !> below this ratio to the fastest velocity does not count.
  real(dp), parameter, public :: together = 1e-6_dp
  !> Impacts of a step may solve so many contacts one after the other: eight times all contacts, or a number that takes
  !> hundredths of a second. What is left is one impact.
  integer, parameter :: most_of_all = 8, most_of_few = 10000

  !> What each contact is when the step begins.
  integer, parameter, public :: bears = 0      !! it touches from the start
  integer, parameter, public :: strikes = 1    !! it strikes at a known time over the step, unless impacts change that
  integer, parameter, public :: is_open = 2    !! it strikes only where impacts drive its bodies

  !> The contacts that may strike in a step.
  type :: strikers_t
    integer, allocatable :: kind(:)            !! (n) `bears`, `strikes` or `is_open`
    real(dp), allocatable :: at(:)             !! (n) time over the step at which a contact strikes
    real(dp), allocatable :: gap(:)            !! (n) when the step begins, length
    logical, allocatable :: driven(:)          !! (n) its bodies do not approach when the step begins
    logical, allocatable :: closes(:)          !! (n) it is known to close in the step
    logical, allocatable :: meets(:)           !! (n) its bodies touch at the end of the step, wherever impacts bring them
    real(dp) :: dt = 0.0_dp                    !! time
  end type strikers_t

  !> How the impacts follow each other.
  type :: course_t
    integer :: n_impacts = 0
    logical :: cut_short = .false.             !! the last impact is of more than would strike together
    real(dp) :: taken = 0.0_dp                 !! energy that compression took, less the work that is left in it, force length
    real(dp), allocatable :: pushed(:, :)      !! (3, n_bodies) velocities that make up for the impacts
    real(dp), allocatable :: first_at(:)       !! (n) time over the step at which a contact strikes first; huge: it does not
    real(dp), allocatable :: approach(:)       !! (n) at that time, length/time
  end type course_t

  !> Where the bodies are in the step.
  type :: progress_t
    real(dp) :: at = 0.0_dp                    !! time over the step
    real(dp) :: slow = 0.0_dp                  !! an approach that does not count, length/time
    real(dp) :: barred = 0.0_dp                !! energy that may not come back yet, force length
    integer :: solved = 0                      !! contacts of all impacts
    integer, allocatable :: pair(:, :)         !! (2, n) bodies that move, the lower first; 0: it does not move
    logical, allocatable :: moves(:)           !! (n_bodies)
    logical, allocatable :: struck(:)          !! (n_bodies)
    real(dp), allocatable :: gap(:)            !! (n) length
    real(dp), allocatable :: speed(:)          !! (n) at which contacts open, length/time
  end type progress_t

contains

  !> Lets the impacts of a step follow each other: velocities after the last one, and all impulses.
  subroutine strike_in_turn(problem, strikers, restitution, barred, impulses, course)
    type(impulse_problem_t), intent(in) :: problem !! with the least velocities across of contacts that bear
    type(strikers_t), intent(in) :: strikers
    real(dp), intent(in) :: restitution
    real(dp), intent(in) :: barred             !! energy that may not come back, force length
    type(impulses_t), intent(inout) :: impulses !! with the motion before the first impact, then after the last
    type(course_t), intent(out) :: course
    type(progress_t) :: now
    real(dp) :: at
    logical :: strikes_now(size(strikers%kind))

    call begin(problem, strikers, barred, impulses, course, now)
    do
      call find_next(problem, strikers, impulses%motion, now, at, strikes_now)
      if (.not. any(strikes_now)) exit
      course%cut_short = now%solved > max(most_of_few, most_of_all*size(strikes_now))
      if (course%cut_short) strikes_now = strikers%closes .or. course%first_at <= 1
      call go_on_to(strikers, at, now)
      where (strikes_now .and. course%first_at > 1)
        course%first_at = at
        course%approach = -now%speed
      end where
      call strike(problem, strikers, restitution, strikes_now, now, impulses, course)
      if (course%cut_short) exit
    end do
  end subroutine strike_in_turn

  !> Places the bodies when the step begins.
  pure subroutine begin(problem, strikers, barred, impulses, course, now)
    type(impulse_problem_t), intent(in) :: problem
    type(strikers_t), intent(in) :: strikers
    real(dp), intent(in) :: barred
    type(impulses_t), intent(inout) :: impulses
    type(course_t), intent(out) :: course
    type(progress_t), intent(out) :: now
    integer :: i, k, n

    n = size(strikers%kind)
    if (allocated(impulses%P)) deallocate (impulses%P)
    allocate (impulses%P(2, n), source=0.0_dp)
    impulses%settled = .true.
    allocate (course%pushed, source=0*impulses%motion)
    allocate (course%first_at(n), source=huge(1.0_dp))
    allocate (course%approach(n), source=0.0_dp)
    now%barred = barred
    now%slow = together*maxval(abs(impulses%motion(:2, :)))
    now%moves = [(any(abs(problem%mobility(:, :, k)) > 0), k=1, size(problem%mobility, 3))]
    allocate (now%struck(size(now%moves)), source=.false.)
    allocate (now%pair(2, n), now%speed(n))
    now%gap = merge(strikers%gap, 0.0_dp, strikers%kind /= bears)
    do i = 1, n
      now%pair(:, i) = merge(problem%body(:, i), 0, now%moves(problem%body(:, i)))
      now%pair(:, i) = [minval(now%pair(:, i)), maxval(now%pair(:, i))]
      if (strikers%kind(i) /= strikes .or. strikers%driven(i)) cycle
      associate (velocity => velocity_at(problem, impulses%motion, i))
        if (-velocity(1) > now%slow .and. strikers%at(i) < 1) now%gap(i) = -strikers%at(i)*strikers%dt*velocity(1)
      end associate
    end do
  end subroutine begin

  !> Finds which contacts strike next, and when.
  pure subroutine find_next(problem, strikers, motion, now, at, strikes_now)
    type(impulse_problem_t), intent(in) :: problem
    type(strikers_t), intent(in) :: strikers
    real(dp), intent(in) :: motion(:, :)       !! (3, n_bodies)
    type(progress_t), intent(inout) :: now
    real(dp), intent(out) :: at                !! time over the step
    logical, intent(out) :: strikes_now(:)     !! (n)
    real(dp) :: time(size(strikes_now)), velocity(2)
    integer :: i

    time = huge(1.0_dp)
    do i = 1, size(time)
      velocity = velocity_at(problem, motion, i)
      now%speed(i) = velocity(1)
      if (.not. -velocity(1) > now%slow) cycle
      if (strikers%kind(i) /= strikes .and. .not. any(now%struck(problem%body(:, i)))) cycle
      if (strikers%kind(i) == bears .and. .not. now%gap(i) > now%slow*strikers%dt) cycle
      time(i) = now%at + max(0.0_dp, now%gap(i))/(-velocity(1)*strikers%dt)
      if (strikers%meets(i) .or. .not. any(now%struck(problem%body(:, i)))) time(i) = min(time(i), 1.0_dp)
    end do
    strikes_now = .false.
    at = minval(time)
    if (.not. at <= 1 + together) return
    strikes_now = time <= at + together
    do i = 1, size(time)
      if (.not. (time(i) <= at + together)) cycle
      strikes_now = strikes_now .or. (strikers%closes .and. now%pair(1, :) == now%pair(1, i) &
                                      .and. now%pair(2, :) == now%pair(2, i))
    end do
    at = max(now%at, min(1.0_dp, at))
  end subroutine find_next

  !> Lets the bodies go on to a time over the step. Contacts that bear part from the first impact on that moves their bodies.
  pure subroutine go_on_to(strikers, at, now)
    type(strikers_t), intent(in) :: strikers
    real(dp), intent(in) :: at
    type(progress_t), intent(inout) :: now
    integer :: i

    do i = 1, size(now%gap)
      if (strikers%kind(i) == bears) then
        if (.not. any(now%struck(pack(now%pair(:, i), now%pair(:, i) > 0)))) cycle
      end if
      now%gap(i) = max(0.0_dp, now%gap(i) + (at - now%at)*strikers%dt*now%speed(i))
    end do
    now%at = at
  end subroutine go_on_to

  !> One impact: of the contacts that strike, and of those that bear or touch and are connected with them.
  subroutine strike(problem, strikers, restitution, strikes_now, now, impulses, course)
    type(impulse_problem_t), intent(in) :: problem
    type(strikers_t), intent(in) :: strikers
    real(dp), intent(in) :: restitution
    logical, intent(in) :: strikes_now(:)      !! (n)
    type(progress_t), intent(inout) :: now
    type(impulses_t), intent(inout) :: impulses
    type(course_t), intent(inout) :: course
    type(impulse_problem_t) :: part
    type(impulses_t) :: own
    integer, allocatable :: contact(:)
    real(dp) :: rest, taken
    integer :: i

    contact = connected(problem, strikes_now .or. now%gap <= now%slow*strikers%dt, strikes_now, now%moves)
    part = part_of(problem, contact)
    where (strikes_now(contact) .or. strikers%kind(contact) /= bears) part%least = 0.0_dp
    now%solved = now%solved + size(contact)
    call solve_compression(part, impulses%motion, own)
    call energy_of(part, own, taken, rest)
    course%taken = course%taken + taken - rest
    call restore(part, share_given_back(restitution, taken, rest, taken - rest - max(0.0_dp, now%barred)), own)
    now%barred = now%barred - min(max(0.0_dp, now%barred), taken - rest)
    course%pushed = course%pushed + (1 - now%at)*(own%motion - impulses%motion)
    course%n_impacts = course%n_impacts + 1
    do i = 1, size(contact)
      now%struck(part%body(:, i)) = now%moves(part%body(:, i))
    end do
    impulses%P(:, contact) = impulses%P(:, contact) + own%P
    impulses%motion = own%motion
    impulses%settled = impulses%settled .and. own%settled
    where (strikes_now) now%gap = 0.0_dp
  end subroutine strike

  !> Contacts among some that are connected with those that strike by bodies that move, in order.
  pure function connected(problem, among, strikes_now, moves) result(contact)
    type(impulse_problem_t), intent(in) :: problem
    logical, intent(in) :: among(:), strikes_now(:) !! (n)
    logical, intent(in) :: moves(:)            !! (n_bodies)
    integer, allocatable :: contact(:)
    logical :: reached(size(moves)), taken(size(among))
    integer :: i
    logical :: grows

    taken = strikes_now
    reached = .false.
    do i = 1, size(taken)
      if (taken(i)) reached(problem%body(:, i)) = moves(problem%body(:, i))
    end do
    grows = .true.
    do while (grows)
      grows = .false.
      do i = 1, size(taken)
        if (taken(i) .or. .not. among(i)) cycle
        if (.not. any(reached(problem%body(:, i)))) cycle
        taken(i) = .true.
        reached(problem%body(:, i)) = moves(problem%body(:, i))
        grows = .true.
      end do
    end do
    contact = pack([(i, i=1, size(taken))], taken)
  end function connected

  !> Some contacts of a problem, with all of its bodies.
  pure function part_of(problem, contact) result(part)
    type(impulse_problem_t), intent(in) :: problem
    integer, intent(in) :: contact(:)
    type(impulse_problem_t) :: part

    part%body = problem%body(:, contact)
    part%row = problem%row(:, :, :, contact)
    part%answer = problem%answer(:, :, :, contact)
    part%friction = problem%friction(contact)
    part%least = problem%least(contact)
    part%mobility = problem%mobility
  end function part_of

  !> Share s of the impulses of compression that gives back e^2 of the energy that is there, s rest + s^2 taken = e^2 available; at
  !> most e.
  pure real(dp) function share_given_back(e, taken, rest, available) result(s)
    real(dp), intent(in) :: e
    real(dp), intent(in) :: taken, rest        !! of `energy_of`
    real(dp), intent(in) :: available          !! force length

    s = 0.0_dp
    if (taken > 0) s = min(e, (-rest + sqrt(rest**2 + 4*taken*e**2*max(0.0_dp, available)))/(2*taken))
  end function share_given_back

end module scree_strikes_in_turn
