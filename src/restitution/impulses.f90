!> Impulses of bodies that meet, by Poisson's hypothesis.
!>
!> Bodies b with the mobility of their rigid motion q, contacts i with the rows G of their velocity across (n, positive where they
!> part) and along (t). An impact has two phases (Poisson 1838; Routh 1860; with many contacts and friction Glocker & Pfeiffer
!> 1995):
!>
!>     compression   qc = q- + M^-1 G^T P,     0 <= Pn  _|_  Gn qc - b >= 0,             |Pt| <= mu Pn  against  Gt qc
!>     restitution   q+ = qc + M^-1 G^T P',    0 <= Pn' - s Pn  _|_  Gn q+ - b >= 0,     |Pt'| <= mu Pn'  against  Gt q+
!>
!> With b <= 0 what kinetic energy changes by is P.Gqc - P.G M^-1 G^T P/2 < 0 in compression and at most s^2 of that in restitution,
!>
!>     K+ - Kc <= s P.G qc + s^2 P.G M^-1 G^T P/2 <= s^2 (K- - Kc)
!>
!> as friction and b make P.Gqc <= 0, and P' = s P is one of those that the phase of restitution chooses from. Without friction
!> s = 1 gives back exactly what compression took, whatever the number of contacts. With friction that is lost what it took in
!> compression, and it takes more in restitution.
!>
!> Both phases are projected Gauss-Seidel, each contact brought to its own law in turn (Moreau 1988; Jean 1999), made faster by
!> conjugate directions (Silcowitz, Niebe & Erleben 2010). Where these sweeps take too long, as in piles, impulses are those of
!> stiff springs (`stiff_impulses`). Impulses that neither finds say so (`settled`).
!>
!> Both phases are in doc/theory/impacts.md, eq-poisson.
module scree_impulses
  use scree_impulse_problem, only: apply, impulse_problem_t, impulses_t, push, resistance_of, velocity_along, velocity_at
  use scree_kinds, only: dp
  use scree_stiff_impulses, only: press_by_springs
  implicit none
  private
  public :: energy_of, restore, solve_compression

  !> Largest error of velocities over the fastest approach.
  real(dp), parameter :: met = 1e-12_dp
  !> Largest error with which no stiff springs are tried, likewise; in piles the error after the sweeps is many times larger.
  real(dp), parameter :: nearly_met = 1e-8_dp
  !> The fastest approach counts as at least this ratio of the velocities that cancel in an approach, because slower ones are
  !> inexact.
  real(dp), parameter :: sensed = 1e-3_dp
  !> A body counts as moved if an impulse changes velocities by more than this ratio to the fastest approach.
  real(dp), parameter :: unfelt = 1e-2_dp*met
  !> Largest error of velocities after stiff springs, over the fastest approach: with a larger error there is no solution.
  real(dp), parameter :: solved = 1e-3_dp
  integer, parameter :: most_sweeps = 50

contains

  !> Compression: impulses that end every approach.
  subroutine solve_compression(problem, motion, compressed)
    type(impulse_problem_t), intent(in) :: problem
    real(dp), intent(in) :: motion(:, :)       !! (3, n_bodies) before the impact
    type(impulses_t), intent(out) :: compressed
    integer :: i

    compressed%motion = motion
    allocate (compressed%P(2, size(problem%least)), source=0.0_dp)
    call relax(problem, [(0.0_dp, i=1, size(problem%least))], compressed)
  end subroutine solve_compression

  !> Kinetic energy that compression took, by the impulses alone; and the work of the impulses of compression in the motion at its
  !> end.
  pure subroutine energy_of(problem, compressed, taken, rest)
    type(impulse_problem_t), intent(in) :: problem
    type(impulses_t), intent(in) :: compressed
    real(dp), intent(out) :: taken             !! P.G M^-1 G^T P/2, force length
    real(dp), intent(out) :: rest              !! P.G qc, force length
    real(dp) :: change(3, size(compressed%motion, 2))
    integer :: i

    change = 0.0_dp
    rest = 0.0_dp
    taken = 0.0_dp
    do i = 1, size(problem%least)
      rest = rest + dot_product(compressed%P(:, i), velocity_at(problem, compressed%motion, i))
      call apply(problem, i, compressed%P(:, i), change)
    end do
    do i = 1, size(problem%least)
      taken = taken + 0.5_dp*dot_product(compressed%P(:, i), velocity_at(problem, change, i))
    end do
  end subroutine energy_of

  !> Restitution: adds impulses that are across at least `s` times the impulses of compression.
  subroutine restore(problem, s, impulses)
    type(impulse_problem_t), intent(in) :: problem
    real(dp), intent(in) :: s
    type(impulses_t), intent(inout) :: impulses !! of compression, then of both phases
    type(impulses_t) :: again
    real(dp) :: least(size(problem%least)) ! impulses change, what they are at least does not
    integer :: i

    if (.not. s > 0) return
    again%motion = impulses%motion
    again%P = s*impulses%P
    least = again%P(1, :)
    do i = 1, size(problem%least)
      call apply(problem, i, again%P(:, i), again%motion)
    end do
    call relax(problem, least, again)
    impulses%P = impulses%P + again%P
    impulses%motion = again%motion
    impulses%settled = impulses%settled .and. again%settled
  end subroutine restore

  !> Lets all contacts come to their laws: by sweeps, and where few do not do by stiff springs. Where these do not come near either,
  !> impulses are those of the sweeps.
  subroutine relax(problem, floor, impulses)
    type(impulse_problem_t), intent(in) :: problem
    real(dp), intent(in) :: floor(:)           !! (n) least impulse across, force time
    type(impulses_t), intent(inout) :: impulses
    type(impulses_t) :: pressed
    real(dp) :: fastest, left, resistance(2, size(floor)), velocity(2)
    integer :: i

    if (size(floor) == 0) return
    fastest = 0.0_dp
    do i = 1, size(floor)
      resistance(:, i) = resistance_of(problem, i)
      velocity = velocity_at(problem, impulses%motion, i)
      fastest = max(fastest, problem%least(i) - velocity(1), resistance(1, i)*floor(i), &
                    sensed*sum(abs(problem%row(:, :, 1, i)*impulses%motion(:, problem%body(:, i)))))
    end do
    call sweep(problem, floor, resistance, fastest, impulses, left)
    if (left <= nearly_met*fastest) return
    pressed = impulses
    call press_by_springs(problem, floor, resistance, fastest, pressed, left)
    impulses%settled = left <= solved*fastest
    if (.not. impulses%settled) return
    impulses%P = pressed%P
    impulses%motion = pressed%motion
  end subroutine relax

  !> Brings contacts to their laws one after the other, in conjugate directions. A contact both of whose bodies have not moved since
  !> it came to its law is left out of a sweep, as most are where an impact is local.
  pure subroutine sweep(problem, floor, resistance, fastest, impulses, wrong)
    type(impulse_problem_t), intent(in) :: problem
    real(dp), intent(in) :: floor(:)           !! (n) least impulse across, force time
    real(dp), intent(in) :: resistance(:, :)   !! (2, n) velocity that a unit of impulse makes
    real(dp), intent(in) :: fastest            !! approach, length/time
    type(impulses_t), intent(inout) :: impulses
    real(dp), intent(out) :: wrong             !! velocity that the last one changed most
    real(dp), dimension(2, size(floor)) :: before, change, direction
    logical :: moved(size(impulses%motion, 2)), moves(size(impulses%motion, 2)) !! bodies, in the last sweep and in this
    real(dp) :: length, length_before, share
    integer :: i, k

    direction = 0.0_dp
    length_before = 0.0_dp
    moves = .true.
    do k = 1, most_sweeps
      before = impulses%P
      moved = moves
      moves = .false.
      do i = 1, size(floor)
        associate (body => problem%body(:, i))
          if (.not. any(moved(body) .or. moves(body))) cycle
          call settle_contact(problem, i, floor(i), resistance(:, i), impulses)
          if (any(resistance(:, i)*abs(impulses%P(:, i) - before(:, i)) > unfelt*fastest)) call mark_moved(problem, i, moves)
        end associate
      end do
      change = impulses%P - before
      wrong = maxval(resistance*abs(change))
      if (wrong <= met*fastest) return
      length = sum(resistance*change**2)
      share = 0.0_dp
      if (k > 1 .and. length < length_before) share = length/length_before
      length_before = length
      direction = share*direction
      if (share > 0 .and. k < most_sweeps) then
        do i = 1, size(floor)
          if (.not. any(resistance(:, i)*abs(direction(:, i)) > 0)) cycle
          impulses%P(:, i) = impulses%P(:, i) + direction(:, i)
          call apply(problem, i, direction(:, i), impulses%motion)
          call mark_moved(problem, i, moves)
        end do
      end if
      direction = direction + change
    end do
  end subroutine sweep

  !> Marks the bodies that an impulse of contact i moves.
  pure subroutine mark_moved(problem, i, moves)
    type(impulse_problem_t), intent(in) :: problem
    integer, intent(in) :: i
    logical, intent(inout) :: moves(:)         !! (n_bodies)
    integer :: side

    do side = 1, 2
      if (any(abs(problem%answer(:, side, :, i)) > 0)) moves(problem%body(side, i)) = .true.
    end do
  end subroutine mark_moved

  !> Brings contact i to its law: no approach, then friction.
  pure subroutine settle_contact(problem, i, floor, resistance, impulses)
    type(impulse_problem_t), intent(in) :: problem
    integer, intent(in) :: i
    real(dp), intent(in) :: floor, resistance(2)
    type(impulses_t), intent(inout) :: impulses
    real(dp) :: limit, new

    associate (body => problem%body(:, i), P => impulses%P(:, i))
      if (resistance(1) > 0) then
        new = max(floor, P(1) + (problem%least(i) - velocity_along(problem%row(:, :, 1, i), impulses%motion, body))/resistance(1))
        call push(problem, i, 1, new - P(1), impulses%motion)
        P(1) = new
      end if
      limit = problem%friction(i)*max(P(1), 0.0_dp)
      if (resistance(2) > 0 .and. (limit > 0 .or. abs(P(2)) > 0)) then
        new = max(-limit, min(limit, P(2) - velocity_along(problem%row(:, :, 2, i), impulses%motion, body)/resistance(2)))
        call push(problem, i, 2, new - P(2), impulses%motion)
        P(2) = new
      end if
    end associate
  end subroutine settle_contact

end module scree_impulses
