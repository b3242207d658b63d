!> Series of the blocks that leave the scene, a row for each.
module scree_departure_records
  use scree_errors, only: error_t
  use scree_inertia, only: kinetic_energy, momentum
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_results_file, only: declare_series, put_series, results_t
  use scree_state, only: state_t, time_of_run
  use scree_system, only: values_of
  implicit none
  private
  public :: declare_departures, departure_records_t, put_departure

  !> Handles of the series.
  type :: departure_records_t
    integer :: block = 0, time = 0, momentum = 0, energy = 0
  end type departure_records_t

contains

  !> Declares the series.
  subroutine declare_departures(results, records, error)
    type(results_t), intent(inout) :: results
    type(departure_records_t), intent(out) :: records
    type(error_t), allocatable, intent(inout) :: error

    call declare_series(results, '/departures/block', [integer ::], '1', 'block that left the scene, from 1', records%block, &
                        error, whole=.true.)
    call declare_series(results, '/departures/time', [integer ::], 'time', 'end of the step in which it did', records%time, error)
    call declare_series(results, '/departures/momentum', [3], &
                        'mass*length/time (x, y), mass*length^2/time (about the origin), per unit thickness', &
                        'momentum and angular momentum that it took with it', records%momentum, error)
    call declare_series(results, '/departures/energy', [integer ::], 'force*length/length', &
                        'kinetic energy that it took with it', records%energy, error)
  end subroutine declare_departures

  !> Adds the row of a block that is outside of the scene at the end of a step. Errors: a number that is not finite.
  subroutine put_departure(results, records, model, cache, state, block, error)
    type(results_t), intent(inout) :: results
    type(departure_records_t), intent(in) :: records
    type(model_t), intent(in) :: model           !! with the block
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    integer, intent(in) :: block
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: kinetic, p(3), total(3)
    integer :: e

    kinetic = 0.0_dp
    total = 0.0_dp
    do e = 1, model%n_elements
      if (model%elements%block(e) /= block) cycle
      associate (velocity => values_of(model%elements, e, state%velocity), element => cache%element(e))
        p = momentum(element%kinematics, element%mass, velocity)
        total = total + [p(1:2), p(3) + model%origin(1)*p(2) - model%origin(2)*p(1)]
        kinetic = kinetic + kinetic_energy(element%mass_matrix, velocity)
      end associate
    end do
    call put_series(results, records%block, [real(block, dp)], error)
    if (.not. allocated(error)) call put_series(results, records%time, [time_of_run(state)], error)
    if (.not. allocated(error)) call put_series(results, records%momentum, total, error)
    if (.not. allocated(error)) call put_series(results, records%energy, [kinetic], error)
  end subroutine put_departure

end module scree_departure_records
