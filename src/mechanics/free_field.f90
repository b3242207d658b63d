!> Motion of a column of horizontal layers under a wave from below, or on a ground that accelerates: the free field.
!>
!> The column has displacements u along x and y that depend on its height alone. Shear waves move it along x, pressure waves
!> along y:
!>
!>     rho u'' + alpha rho u' = d/dy (m (du/dy + beta du'/dy)) - rho a,   m = D33 along x, D11 along y
!>
!> with Rayleigh damping and the acceleration a of the ground. Its top is free. Its foot is at rest, or stands on rock that goes on
!> with the impedance z, in which a wave w comes up: m du/dy = z (u' - 2 w').
!>
!> Cells between nodes have linear displacements. Their mass matrix is the mean of the consistent and the lumped one, for which a
!> wave has its speed to the fourth order of the size of a cell. Steps are those of the trapezoidal rule, with the mean loads
!> of each step. The rock beside the column does not act on it. So the records alone say how it moves.
module scree_free_field
  use scree_kinds, only: dp
  use scree_scene, only: time_table_t
  use scree_time_table, only: mean_over
  implicit none
  private
  public :: column_t, move_column

  !> A column, from its foot to its top.
  type :: column_t
    real(dp), allocatable :: y(:)          !! (n) heights of the nodes, ascending, length
    real(dp), allocatable :: density(:)    !! (n-1) of the cells, mass/length^3
    real(dp), allocatable :: modulus(:, :) !! (2, n-1) D33 and D11 of the cells, force/length^2
    real(dp) :: rayleigh(2) = 0.0_dp       !! alpha, 1/time, and beta, time
    real(dp) :: impedance(2) = 0.0_dp      !! along x and y of the rock below, mass/(length^2 time); 0: the foot is at rest
    type(time_table_t) :: wave             !! velocity of the wave that comes up; without times: none
    type(time_table_t) :: ground           !! acceleration; without times: none
  end type column_t

contains

  !> Moves a column from rest at time 0. Gives the velocity and the displacement of chosen nodes at the multiples of a step.
  subroutine move_column(column, dt, n_steps, chosen, velocity, displacement)
    type(column_t), intent(in) :: column
    real(dp), intent(in) :: dt                         !! time
    integer, intent(in) :: n_steps
    integer, intent(in) :: chosen(:)                   !! (m) nodes
    type(time_table_t), intent(out) :: velocity(:)     !! (m) length/time
    type(time_table_t), intent(out) :: displacement(:) !! (m) length
    real(dp), dimension(size(column%y), 2) :: damper, diagonal, left, mass, operator, spring, u, v
    real(dp), dimension(size(column%y) - 1, 2) :: damper_beside, factor, mass_beside, operator_beside, spring_beside
    real(dp) :: load(2), ground(2), force(size(column%y)), w(size(column%y))
    integer :: i, k, step, xy

    call matrices()
    operator = 2/dt*mass + damper + 0.5_dp*dt*spring
    operator_beside = 2/dt*mass_beside + damper_beside + 0.5_dp*dt*spring_beside
    where (.not. column%impedance > 0) operator_beside(1, :) = 0.0_dp
    diagonal = operator
    do i = 2, size(column%y)
      factor(i - 1, :) = operator_beside(i - 1, :)/diagonal(i - 1, :)
      diagonal(i, :) = diagonal(i, :) - factor(i - 1, :)*operator_beside(i - 1, :)
    end do
    do k = 1, size(chosen)
      velocity(k) = time_table_t([(i*dt, i=0, n_steps)], reshape([(0.0_dp, i=0, 2*n_steps + 1)], [2, n_steps + 1]), .true.)
      displacement(k) = velocity(k)
    end do
    left = row_sums()
    u = 0.0_dp
    v = 0.0_dp
    do step = 1, n_steps
      load = 0.0_dp
      ground = 0.0_dp
      if (allocated(column%wave%time)) load = 2*column%impedance*mean_over(column%wave, (step - 1)*dt, step*dt)
      if (allocated(column%ground%time)) ground = mean_over(column%ground, (step - 1)*dt, step*dt)
      do xy = 1, 2
        force = times(2/dt*mass(:, xy), 2/dt*mass_beside(:, xy), v(:, xy)) - times(spring(:, xy), spring_beside(:, xy), u(:, xy)) &
                - ground(xy)*left(:, xy)
        force(1) = force(1) + load(xy)
        w = solution(xy)
        v(:, xy) = 2*w - v(:, xy)
        u(:, xy) = u(:, xy) + dt*w
      end do
      do k = 1, size(chosen)
        velocity(k)%value(:, step + 1) = v(chosen(k), :)
        displacement(k)%value(:, step + 1) = u(chosen(k), :)
      end do
    end do

  contains

    !> Mass, damping and stiffness of the nodes and between neighbours, per unit of width and thickness.
    subroutine matrices()
      real(dp) :: h, m, stiff(2)

      mass = 0.0_dp
      spring = 0.0_dp
      do i = 1, size(column%density)
        h = column%y(i + 1) - column%y(i)
        m = column%density(i)*h
        stiff = column%modulus(:, i)/h
        mass(i:i + 1, :) = mass(i:i + 1, :) + 5*m/12
        mass_beside(i, :) = m/12
        spring(i, :) = spring(i, :) + stiff
        spring(i + 1, :) = spring(i + 1, :) + stiff
        spring_beside(i, :) = -stiff
      end do
      damper = column%rayleigh(1)*mass + column%rayleigh(2)*spring
      damper_beside = column%rayleigh(1)*mass_beside + column%rayleigh(2)*spring_beside
      damper(1, :) = damper(1, :) + column%impedance
    end subroutine matrices

    !> Mass that the acceleration of the ground loads each node with.
    function row_sums() result(sums)
      real(dp) :: sums(size(column%y), 2)

      do xy = 1, 2
        sums(:, xy) = times(mass(:, xy), mass_beside(:, xy), [(1.0_dp, i=1, size(column%y))])
      end do
    end function row_sums

    !> A tridiagonal symmetric matrix times a vector.
    pure function times(own, beside, x) result(y)
      real(dp), intent(in) :: own(:), beside(:), x(:)
      real(dp) :: y(size(x))

      y = own*x
      y(:size(x) - 1) = y(:size(x) - 1) + beside*x(2:)
      y(2:) = y(2:) + beside*x(:size(x) - 1)
    end function times

    !> Mean velocity of a step along an axis. A foot that is at rest has none.
    function solution(axis) result(x)
      integer, intent(in) :: axis
      real(dp) :: x(size(column%y))

      x = force
      if (.not. column%impedance(axis) > 0) x(1) = 0.0_dp
      do i = 2, size(x)
        x(i) = x(i) - factor(i - 1, axis)*x(i - 1)
      end do
      x(size(x)) = x(size(x))/diagonal(size(x), axis)
      do i = size(x) - 1, 1, -1
        x(i) = (x(i) - operator_beside(i, axis)*x(i + 1))/diagonal(i, axis)
      end do
    end function solution

  end subroutine move_column

end module scree_free_field
