!> Bodies that meet in contacts, and impulses that act there.
module scree_impulse_problem
  use scree_kinds, only: dp
  implicit none
  private
  public :: apply, impulse_problem_t, impulses_t, push, resistance_of, takes_no_part, velocity_along, velocity_at

  !> Least velocity across of what has no part in an impact: below all that there are, length/time.
  real(dp), parameter :: takes_no_part = -sqrt(huge(1.0_dp))

  !> Who meets, and how.
  type :: impulse_problem_t
    integer, allocatable :: body(:, :)         !! (2, n) of each contact
    real(dp), allocatable :: row(:, :, :, :)   !! (3, 2, 2, n) of the motion of either body, for velocity across and along
    real(dp), allocatable :: answer(:, :, :, :) !! (3, 2, 2, n) change of the motion of either body by a unit of impulse
    real(dp), allocatable :: friction(:)       !! (n)
    real(dp), allocatable :: mobility(:, :, :) !! (3, 3, n_bodies) of which `answer` is made
    real(dp), allocatable :: least(:)          !! (n) b, velocity across that compression leaves at least, length/time
  end type impulse_problem_t

  !> Impulses of the contacts, and the motion of the bodies with them.
  type :: impulses_t
    logical :: settled = .true.                !! they obey the laws of their contacts
    real(dp), allocatable :: P(:, :)           !! (2, n) across and along, force time
    real(dp), allocatable :: motion(:, :)      !! (3, n_bodies)
  end type impulses_t

contains

  !> Velocities across and along contact i.
  pure function velocity_at(problem, motion, i) result(velocity)
    type(impulse_problem_t), intent(in) :: problem
    real(dp), intent(in) :: motion(:, :)       !! (3, n_bodies)
    integer, intent(in) :: i
    real(dp) :: velocity(2)
    integer :: k

    do k = 1, 2
      velocity(k) = velocity_along(problem%row(:, :, k, i), motion, problem%body(:, i))
    end do
  end function velocity_at

  !> Velocity along the row of two bodies.
  pure real(dp) function velocity_along(row, motion, body)
    real(dp), intent(in) :: row(3, 2)
    real(dp), intent(in) :: motion(:, :)       !! (3, n_bodies)
    integer, intent(in) :: body(2)
    integer :: side

    velocity_along = 0.0_dp
    do side = 1, 2
      associate (b => body(side))
        velocity_along = velocity_along + row(1, side)*motion(1, b) + row(2, side)*motion(2, b) + row(3, side)*motion(3, b)
      end associate
    end do
  end function velocity_along

  !> Changes the motion by an impulse of contact i, across or along.
  pure subroutine push(problem, i, k, impulse, motion)
    type(impulse_problem_t), intent(in) :: problem
    integer, intent(in) :: i, k                !! k: 1 across, 2 along
    real(dp), intent(in) :: impulse            !! force time
    real(dp), intent(inout) :: motion(:, :)    !! (3, n_bodies)
    integer :: side

    do side = 1, 2
      associate (b => problem%body(side, i))
        motion(1, b) = motion(1, b) + impulse*problem%answer(1, side, k, i)
        motion(2, b) = motion(2, b) + impulse*problem%answer(2, side, k, i)
        motion(3, b) = motion(3, b) + impulse*problem%answer(3, side, k, i)
      end associate
    end do
  end subroutine push

  !> Changes the motion by an impulse of contact i.
  pure subroutine apply(problem, i, impulse, motion)
    type(impulse_problem_t), intent(in) :: problem
    integer, intent(in) :: i
    real(dp), intent(in) :: impulse(2)         !! across and along, force time
    real(dp), intent(inout) :: motion(:, :)    !! (3, n_bodies)
    integer :: k

    do k = 1, 2
      call push(problem, i, k, impulse(k), motion)
    end do
  end subroutine apply

  !> Velocity across, and along, that a unit of impulse there makes.
  pure function resistance_of(problem, i) result(resistance)
    type(impulse_problem_t), intent(in) :: problem
    integer, intent(in) :: i
    real(dp) :: resistance(2)
    integer :: k

    resistance = [(sum(problem%row(:, :, k, i)*problem%answer(:, :, k, i)), k=1, 2)]
  end function resistance_of

end module scree_impulse_problem
