!> How small small steps are.
!>
!> With size s of a block (that which one in twenty of those that move is below), speed v of the fastest and weight g of a unit
!> mass, a step h is at most
!>
!>     min(0.02 s/v, sqrt(s/g)/300) (a/0.01)^0.63
!>
!> for an accuracy a of the run-out: blocks overlap by v h when they meet, and settle under their weight in steps of sqrt(s/g).
!> A deepest overlap o over s may be given instead, for which the last factor is (o/0.015)^0.7. The
!> numbers are measured (doc/small-steps.md). A step of the run has as many small ones of one size as this asks for.
module scree_step_choice
  use scree_bodies, only: bodies_t
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_scene, only: settings_t
  use scree_sorting, only: sort_by
  implicit none
  private
  public :: fastest_vertex, largest_weight, number_of_steps

  real(dp), parameter :: way_of_step = 0.02_dp    !! of the fastest block in a step, over the size of a block, for 1 %
  real(dp), parameter :: falls_of_step = 300.0_dp !! steps in sqrt(size/g), for 1 %
  real(dp), parameter :: measured_at = 0.01_dp    !! accuracy of both
  real(dp), parameter :: order = 0.63_dp          !! halves of the step for 1 % make it 3 %
  real(dp), parameter :: overlap_then = 0.015_dp   !! deepest overlap over the size of a block, for 1 %
  real(dp), parameter :: order_of_overlap = 0.7_dp !! half the step makes the overlap 0.37 times as deep
  real(dp), parameter :: small_ones = 0.05_dp     !! fraction of the blocks that may be smaller than the size
  real(dp), parameter :: most_steps = 1e6_dp      !! of a step of the run

contains

  !> Small steps of one size that a step of the run is made of.
  integer function number_of_steps(model, bodies, dt) result(n)
    type(model_t), intent(in) :: model
    type(bodies_t), intent(in) :: bodies
    real(dp), intent(in) :: dt                    !! time
    real(dp) :: gravity, least, needed, speed

    least = size_of_small(pack(bodies%size, bodies%moves))
    gravity = largest_weight(model, bodies)
    speed = sqrt(maxval(sum(bodies%velocity**2, 1))) + gravity*dt
    needed = dt*max(speed/(way_of_step*least), falls_of_step*sqrt(gravity/least))/factor_of(model%settings)
    n = max(1, ceiling(min(needed*(1 - epsilon(needed)), most_steps)))
  end function number_of_steps

  !> Size of a step over that for an accuracy of 1 %.
  pure real(dp) function factor_of(settings) result(factor)
    type(settings_t), intent(in) :: settings

    factor = (settings%run_out/measured_at)**order
    if (settings%step_overlap > 0) factor = (settings%step_overlap/overlap_then)**order_of_overlap
  end function factor_of

  !> The size that one block in twenty is below.
  pure real(dp) function size_of_small(sizes) result(least)
    real(dp), intent(in) :: sizes(:)              !! length
    real(dp) :: sorted(size(sizes))
    integer :: number(size(sizes))

    least = 1.0_dp
    if (size(sizes) == 0) return
    sorted = sizes
    number = 0                                    ! of no use here
    call sort_by(sorted, number)
    least = sorted(1 + int(small_ones*size(sizes)))
  end function size_of_small

  !> Largest weight of a unit of mass of what moves, length/time^2.
  pure real(dp) function largest_weight(model, bodies) result(gravity)
    type(model_t), intent(in) :: model
    type(bodies_t), intent(in) :: bodies
    integer :: k

    gravity = 0.0_dp
    if (.not. allocated(model%effects%gravity)) return
    do k = 1, size(model%elements%free)
      associate (e => model%elements%free(k))
        gravity = max(gravity, abs(model%effects%gravity%weight(e))*bodies%inverse_mass(model%elements%block(e)))
      end associate
    end do
  end function largest_weight

  !> A speed that no vertex is faster than.
  pure real(dp) function fastest_vertex(bodies) result(speed)
    type(bodies_t), intent(in) :: bodies
    integer :: b

    speed = 0.0_dp
    do b = 1, bodies%n
      speed = max(speed, 2*(sum(bodies%velocity(:, b)**2) + (bodies%radius(b)*bodies%spin(b))**2))
    end do
    speed = sqrt(speed)                           ! |v| + r |w| is at most sqrt(2 (v^2 + r^2 w^2))
  end function fastest_vertex

end module scree_step_choice
