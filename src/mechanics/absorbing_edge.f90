!> Edges that absorb waves, and let one in.
!>
!> On an edge with the outer normal n act the tractions of a rock that goes on behind it, in which waves go away (Lysmer &
!> Kuhlemeyer, *Finite dynamic model for infinite media*, J. Eng. Mech. Div. ASCE 95, 1969): against a velocity v
!>
!>     t = -Z v,   Z = rho cp n n^T + rho cs (I - n n^T),   rho cp = (rho D11)^1/2,   rho cs = (rho D33)^1/2
!>
!> with D the elasticity in the plane. A wave u that comes in from there adds Z u' for the force that makes it go, and as much
!> against what t takes of it: t = Z (2 u' - v). Velocities are linear along an edge, so that on the unknowns of its element
!>
!>     f = integral of T^T t = T12^T Z u' l - C v,   C = l/3 (T1^T Z T1 + T2^T Z T2) + l/6 (T1^T Z T2 + T2^T Z T1)
!>
!> with T1, T2 at its ends, T12 their sum. n and l are those of the beginning of the step. C is symmetric and not below 0: it takes
!> energy, at any angle, and does so fully from what comes along n.
!>
!> Beside an edge at a side a free field moves (`scree_free_field`). The rock there goes on as a column of its layers, with the
!> velocity w' and the stress s, so that t = Z (w' - v) + s n. The stress follows from the rise of the displacement w over the
!> height of the edge: s_xx = D12 dw_y/dy, s_xy = D33 dw_x/dy, and where stiffness is damped of w + beta w'.
!>
!> An edge that supports held in the stage before bears their reactions on, as constant forces at its ends. The tractions of a wave
!> add to them.
module scree_absorbing_edge
  use scree_element_term, only: add_force, step_rule_t, term_t
  use scree_integrator, only: velocity_at_balance
  use scree_interpolation, only: displacement_matrix, kinematics_t
  use scree_kinds, only: dp
  use scree_scene, only: time_table_t
  use scree_system, only: element_unknowns
  use scree_time_table, only: mean_over
  implicit none
  private
  public :: absorbed_energy, absorbing_edge_t, add_absorbing_edges, absorb_velocity, change_of_free_field, size_of_static_forces, &
            size_of_wave, work_on_absorbing_edges

  integer, parameter :: n = element_unknowns

  !> Called for when lines of the deck absorb waves.
  type :: absorbing_edge_t
    integer, allocatable :: first(:)         !! (n_elements+1) element e has the pieces first(e):first(e+1)-1
    integer, allocatable :: point(:, :)      !! (2, n) points of the system at the ends, counter-clockwise around the element
    real(dp), allocatable :: impedance(:, :) !! (2, n) density times speed of waves across and along the piece, mass/(length^2 time)
    logical, allocatable :: lets_in(:)       !! (n) the wave
    type(time_table_t) :: wave               !! its velocity, length/time
    real(dp), allocatable :: static_force(:, :, :) !! (xy, 2, n) at the ends, force per unit thickness
    integer, allocatable :: field(:, :)      !! (2, n) places of the free field at the ends; 0: there is none
    real(dp), allocatable :: modulus(:, :)   !! (2, n) D12 and D33, force/length^2
    type(time_table_t), allocatable :: field_velocity(:)     !! of each place, length/time
    type(time_table_t), allocatable :: field_displacement(:) !! of each place, length
    real(dp) :: stiffness_damping = 0.0_dp   !! beta of the free field, time
  end type absorbing_edge_t

contains

  !> Adds the tractions on the edges of element `e`, with the velocity at the time of the balance and the mean of the wave.
  pure subroutine add_absorbing_edges(self, e, position, velocity, acceleration, unknown, rule, element, term)
    type(absorbing_edge_t), intent(in) :: self
    integer, intent(in) :: e
    real(dp), intent(in) :: position(:, :)    !! (2, n_points) at the beginning of the step, length
    real(dp), intent(in) :: velocity(n), acceleration(n) !! at the beginning of the step
    real(dp), intent(in) :: unknown(n)        !! of the step so far
    type(step_rule_t), intent(in) :: rule
    type(kinematics_t), intent(in) :: element
    type(term_t), intent(inout) :: term
    real(dp) :: c, carried(n), drag(n, n)

    if (self%first(e + 1) == self%first(e)) return
    call velocity_at_balance(rule, velocity, acceleration, c, carried)
    drag = drag_matrix(self, e, position, element)
    term%matrix = term%matrix + c*drag
    call add_force(term, -matmul(drag, carried))
    call add_force(term, -c*matmul(drag, unknown))
    call add_force(term, wave_force(self, e, position, rule%load_from, rule%load_to, element))
    call add_force(term, static_forces(self, e, position, element))
    call add_force(term, field_force(self, e, position, rule%load_from, rule%load_to, element))
  end subroutine add_absorbing_edges

  !> Adds what the edges of element `e` do against a velocity.
  pure subroutine absorb_velocity(self, e, position, velocity, element, term)
    type(absorbing_edge_t), intent(in) :: self
    integer, intent(in) :: e
    real(dp), intent(in) :: position(:, :)    !! (2, n_points) length
    real(dp), intent(in) :: velocity(n)       !! rates of the unknowns of the element
    type(kinematics_t), intent(in) :: element
    type(term_t), intent(inout) :: term

    if (self%first(e + 1) > self%first(e)) call add_force(term, -matmul(drag_matrix(self, e, position, element), velocity))
  end subroutine absorb_velocity

  !> Energy that the edges of element `e` take in a step, d^T C d/dt, force per unit thickness times length: never below zero.
  pure real(dp) function absorbed_energy(self, e, position, dt, element, unknown) result(energy)
    type(absorbing_edge_t), intent(in) :: self
    integer, intent(in) :: e
    real(dp), intent(in) :: position(:, :)    !! (2, n_points) at the beginning of the step, length
    real(dp), intent(in) :: dt                !! time
    type(kinematics_t), intent(in) :: element
    real(dp), intent(in) :: unknown(n)        !! of the step

    energy = 0.0_dp
    if (self%first(e + 1) > self%first(e)) &
      energy = dot_product(unknown, matmul(drag_matrix(self, e, position, element), unknown))/dt
  end function absorbed_energy

  !> Work of the wave, the free field and the static forces on element `e` in a step, force per unit thickness times length.
  pure real(dp) function work_on_absorbing_edges(self, e, position, rule, element, unknown) result(work)
    type(absorbing_edge_t), intent(in) :: self
    integer, intent(in) :: e
    real(dp), intent(in) :: position(:, :)    !! (2, n_points) at the beginning of the step, length
    type(step_rule_t), intent(in) :: rule
    type(kinematics_t), intent(in) :: element
    real(dp), intent(in) :: unknown(n)        !! of the step

    work = dot_product(wave_force(self, e, position, rule%end_time - rule%dt, rule%end_time, element) &
                       + field_force(self, e, position, rule%end_time - rule%dt, rule%end_time, element) &
                       + static_forces(self, e, position, element), unknown)
  end function work_on_absorbing_edges

  !> Magnitudes of the static forces on the edges of element `e`, summed; force per unit thickness.
  pure real(dp) function size_of_static_forces(self, e) result(load)
    type(absorbing_edge_t), intent(in) :: self
    integer, intent(in) :: e
    integer :: i, k

    load = 0.0_dp
    do i = self%first(e), self%first(e + 1) - 1
      do k = 1, 2
        load = load + norm2(self%static_force(:, k, i))
      end do
    end do
  end function size_of_static_forces

  !> Magnitude of the force on element `e` of a wave with some velocity, per unit thickness.
  pure real(dp) function size_of_wave(self, e, position, velocity) result(force)
    type(absorbing_edge_t), intent(in) :: self
    integer, intent(in) :: e
    real(dp), intent(in) :: position(:, :)    !! (2, n_points) at the beginning of the step, length
    real(dp), intent(in) :: velocity(2)       !! length/time
    real(dp) :: length, z(2, 2)
    integer :: i

    force = 0.0_dp
    do i = self%first(e), self%first(e + 1) - 1
      if (.not. self%lets_in(i)) cycle
      call impedance_of(self, i, position, z, length)
      force = force + norm2(2*length*matmul(z, velocity))
    end do
  end function size_of_wave

  !> Force of the wave on the unknowns of element `e`, with its mean between two times.
  pure function wave_force(self, e, position, from, to, element) result(force)
    type(absorbing_edge_t), intent(in) :: self
    integer, intent(in) :: e
    real(dp), intent(in) :: position(:, :), from, to
    type(kinematics_t), intent(in) :: element
    real(dp) :: force(n), length, z(2, 2)
    integer :: i, k

    force = 0.0_dp
    do i = self%first(e), self%first(e + 1) - 1
      if (.not. self%lets_in(i)) cycle
      call impedance_of(self, i, position, z, length)
      do k = 1, 2
        force = force + length*matmul(matmul(z, mean_over(self%wave, from, to)), &
                                      displacement_matrix(element, position(:, self%point(k, i))))
      end do
    end do
  end function wave_force

  !> Magnitude of the change of the force of the free field on element `e` since a time, per unit thickness.
  pure real(dp) function change_of_free_field(self, e, position, since, from, to) result(force)
    type(absorbing_edge_t), intent(in) :: self
    integer, intent(in) :: e
    real(dp), intent(in) :: position(:, :)    !! (2, n_points) at the beginning of the step, length
    real(dp), intent(in) :: since, from, to   !! time, and the window of the step
    real(dp) :: change(2, 2)
    integer :: i

    force = 0.0_dp
    do i = self%first(e), self%first(e + 1) - 1
      if (self%field(1, i) == 0) cycle
      change = field_load(self, i, position, from, to) - field_load(self, i, position, since, since)
      force = force + 0.5_dp*(norm2(change(:, 1)) + norm2(change(:, 2)))
    end do
  end function change_of_free_field

  !> Force of the free field on the unknowns of element `e`, with its mean between two times.
  pure function field_force(self, e, position, from, to, element) result(force)
    type(absorbing_edge_t), intent(in) :: self
    integer, intent(in) :: e
    real(dp), intent(in) :: position(:, :), from, to
    type(kinematics_t), intent(in) :: element
    real(dp) :: force(n), q(2, 2)
    integer :: i, k

    force = 0.0_dp
    do i = self%first(e), self%first(e + 1) - 1
      if (self%field(1, i) == 0) cycle
      q = field_load(self, i, position, from, to)
      do k = 1, 2
        force = force + matmul((q(:, 1) + q(:, 2) + q(:, k))/6, displacement_matrix(element, position(:, self%point(k, i))))
      end do
    end do
  end function field_force

  !> Load of the free field at both ends of a piece, times its length, with its mean between two times.
  pure function field_load(self, i, position, from, to) result(q)
    type(absorbing_edge_t), intent(in) :: self
    integer, intent(in) :: i                  !! piece
    real(dp), intent(in) :: position(:, :), from, to
    real(dp) :: q(2, 2), along(2), length, slope(2), strained(2, 2), velocity(2, 2), z(2, 2)
    integer :: k

    call impedance_of(self, i, position, z, length)
    do k = 1, 2
      velocity(:, k) = mean_over(self%field_velocity(self%field(k, i)), from, to)
      strained(:, k) = mean_over(self%field_displacement(self%field(k, i)), from, to) + self%stiffness_damping*velocity(:, k)
    end do
    along = position(:, self%point(2, i)) - position(:, self%point(1, i))
    slope = (strained(:, 2) - strained(:, 1))/along(2)
    do k = 1, 2 ! the outer normal times the length is (along y, 0)
      q(:, k) = length*matmul(z, velocity(:, k)) + along(2)*[self%modulus(1, i)*slope(2), self%modulus(2, i)*slope(1)]
    end do
  end function field_load

  !> Static forces on the unknowns of element `e`.
  pure function static_forces(self, e, position, element) result(force)
    type(absorbing_edge_t), intent(in) :: self
    integer, intent(in) :: e
    real(dp), intent(in) :: position(:, :)
    type(kinematics_t), intent(in) :: element
    real(dp) :: force(n)
    integer :: i, k

    force = 0.0_dp
    do i = self%first(e), self%first(e + 1) - 1
      do k = 1, 2
        force = force + matmul(self%static_force(:, k, i), displacement_matrix(element, position(:, self%point(k, i))))
      end do
    end do
  end function static_forces

  !> C of element `e`, force time/length per unit thickness.
  pure function drag_matrix(self, e, position, element) result(drag)
    type(absorbing_edge_t), intent(in) :: self
    integer, intent(in) :: e
    real(dp), intent(in) :: position(:, :)
    type(kinematics_t), intent(in) :: element
    real(dp) :: drag(n, n), length, T(2, n, 2), z(2, 2)
    integer :: i, k

    drag = 0.0_dp
    do i = self%first(e), self%first(e + 1) - 1
      call impedance_of(self, i, position, z, length)
      do k = 1, 2
        T(:, :, k) = displacement_matrix(element, position(:, self%point(k, i)))
      end do
      do k = 1, 2
        drag = drag + length/6*matmul(transpose(T(:, :, k)), matmul(z, T(:, :, 1) + T(:, :, 2) + T(:, :, k)))
      end do
    end do
  end function drag_matrix

  !> Z and length of a piece.
  pure subroutine impedance_of(self, i, position, z, length)
    type(absorbing_edge_t), intent(in) :: self
    integer, intent(in) :: i                  !! piece
    real(dp), intent(in) :: position(:, :)
    real(dp), intent(out) :: z(2, 2), length
    real(dp) :: along(2), normal(2)
    integer :: k

    along = position(:, self%point(2, i)) - position(:, self%point(1, i))
    length = norm2(along)
    along = along/length
    normal = [along(2), -along(1)]
    do k = 1, 2
      z(:, k) = self%impedance(1, i)*normal*normal(k) + self%impedance(2, i)*along*along(k)
    end do
  end subroutine impedance_of

end module scree_absorbing_edge
