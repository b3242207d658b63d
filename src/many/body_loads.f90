!> What acts on rigid bodies but contacts and ties: weight, the accelerated ground, loads on points and edges, water.
module scree_body_loads
  use scree_bodies, only: bodies_t
  use scree_edge_load, only: load_at_ends
  use scree_kinds, only: dp
  use scree_many_bodies, only: arm_of
  use scree_model, only: cache_t, model_t
  use scree_state, only: state_t
  use scree_time_table, only: mean_of_ramp, mean_over
  implicit none
  private
  public :: body_loads_t, find_loads, has_loads

  !> Forces on the bodies, per unit thickness: weight apart from all others, as its work is known from heights.
  type :: body_loads_t
    real(dp), allocatable :: weight(:, :) !! (2, n_bodies)
    real(dp), allocatable :: load(:, :)   !! (3, n_bodies) x, y, and the torque about the centroid
  end type body_loads_t

contains

  !> Whether anything but weight acts.
  pure logical function has_loads(model)
    type(model_t), intent(in) :: model

    associate (effects => model%effects)
      has_loads = allocated(effects%base_acceleration) .or. allocated(effects%point_load) .or. allocated(effects%edge_load)
    end associate
  end function has_loads

  !> Forces on the bodies where they are, as means over a time.
  subroutine find_loads(model, cache, state, bodies, from, to, loads)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache    !! of the state
    type(state_t), intent(in) :: state    !! when the step of the run began
    type(bodies_t), intent(in) :: bodies  !! now
    real(dp), intent(in) :: from, to      !! time
    type(body_loads_t), intent(inout) :: loads
    real(dp) :: share
    integer :: b, e, i, k

    if (.not. allocated(loads%weight)) then
      allocate (loads%weight(2, bodies%n), source=0.0_dp)
      allocate (loads%load(3, bodies%n), source=0.0_dp)
    end if
    associate (effects => model%effects, free => model%elements%free)
      if (allocated(effects%gravity)) then
        share = mean_of_ramp(effects%gravity%ramp, from, to)
        do k = 1, size(free)
          loads%weight(2, model%elements%block(free(k))) = -share*effects%gravity%weight(free(k))
        end do
      end if
      if (.not. has_loads(model)) return
      loads%load = 0.0_dp
      do k = 1, size(free)
        e = free(k)
        b = model%elements%block(e)
        if (.not. bodies%moves(b)) cycle
        if (allocated(effects%base_acceleration)) &
          loads%load(1:2, b) = loads%load(1:2, b) - mean_over(effects%base_acceleration%record, from, to)/bodies%inverse_mass(b)
        if (allocated(effects%point_load)) then
          do i = effects%point_load%first(e), effects%point_load%first(e + 1) - 1
            call add(mean_over(effects%point_load%table(i), from, to), &
                     arm_of(cache, state, bodies, e, b, effects%point_load%point(i)))
          end do
        end if
        if (allocated(effects%edge_load)) call add_edges()
      end do
    end associate

  contains

    !> Adds the loads on edges of a body.
    subroutine add_edges()
      real(dp) :: ends(2, 2), q(2, 2)
      integer :: i

      associate (edges => model%effects%edge_load)
        share = mean_of_ramp(edges%ramp, from, to)
        do i = edges%first(e), edges%first(e + 1) - 1
          ends(:, 1) = arm_of(cache, state, bodies, e, b, edges%point(1, i))
          ends(:, 2) = arm_of(cache, state, bodies, e, b, edges%point(2, i))
          q = share*load_at_ends(edges, i, ends(:, 2) - ends(:, 1))
          call add((2*q(:, 1) + q(:, 2))/6, ends(:, 1))
          call add((q(:, 1) + 2*q(:, 2))/6, ends(:, 2))
        end do
      end associate
    end subroutine add_edges

    !> Adds a force on a body.
    subroutine add(force, arm)
      real(dp), intent(in) :: force(2)    !! per unit thickness
      real(dp), intent(in) :: arm(2)      !! length

      loads%load(:, b) = loads%load(:, b) + [force, arm(1)*force(2) - arm(2)*force(1)]
    end subroutine add

  end subroutine find_loads

end module scree_body_loads
