!> Tables of cracks: a row each step for each tip that is there, in /tips, and a row for each piece by which they grow, in /growth.
!>
!> A crack that begins has the tip with the next free number. A tip that has met an outline or another crack has no more rows.
!> Where the disc of a tip has too little room, its stress intensity is 0.
module scree_crack_records
  use scree_errors, only: error_t
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_results_file, only: declare_series, put_series, results_t
  use scree_state, only: cracks_t, state_t, time_of_run
  use scree_stress_intensity, only: place_of_tip, stress_intensity
  use scree_tip_disc, only: is_measured
  implicit none
  private
  public :: declare_growth, declare_tips, growth_records_t, put_growth, put_tips, tip_records_t

  !> Handles of the series of tips; 0 where no stress intensity is asked for.
  type :: tip_records_t
    integer :: time = 0, tip = 0, opening = 0, shear = 0, place = 0, length = 0
  end type tip_records_t

  !> Handles of the series of pieces.
  type :: growth_records_t
    integer :: time = 0, tip = 0, start = 0, end = 0
  end type growth_records_t

contains

  !> Declares the series of the tips.
  subroutine declare_tips(results, records, error)
    type(results_t), intent(inout) :: results
    type(tip_records_t), intent(out) :: records
    type(error_t), allocatable, intent(inout) :: error

    call a_series('time', [integer ::], 'time', 'end of the step', records%time)
    call declare_series(results, '/tips/tip', [integer ::], '1', 'number of the tip, from 1', records%tip, error, whole=.true.)
    call a_series('K_I', [integer ::], 'force/length^2*length^(1/2)', 'stress intensity factor of mode I', records%opening)
    call a_series('K_II', [integer ::], 'force/length^2*length^(1/2)', 'stress intensity factor of mode II', records%shear)
    call a_series('place', [2], 'length', 'place of the tip', records%place)
    call a_series('length', [integer ::], 'length', 'length of its crack', records%length)

  contains

    !> Declares one series.
    subroutine a_series(name, shape, units, description, handle)
      character(len=*), intent(in) :: name, units, description
      integer, intent(in) :: shape(:)
      integer, intent(out) :: handle

      call declare_series(results, '/tips/'//name, shape, units, description, handle, error)
    end subroutine a_series

  end subroutine declare_tips

  !> Adds a row for each tip at the end of a step. Errors: a number that is not finite.
  subroutine put_tips(results, records, model, cache, state, error)
    type(results_t), intent(inout) :: results
    type(tip_records_t), intent(in) :: records
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(error_t), allocatable, intent(inout) :: error
    real(dp) :: K(2)
    integer :: i

    do i = 1, size(model%tip)
      associate (tip => model%tip(i))
        K = 0.0_dp
        if (is_measured(tip)) K = stress_intensity(model, cache, state, tip)
        call put_row(results, records%time, [time_of_run(state)], error)
        call put_row(results, records%tip, [real(tip%number, dp)], error)
        call put_row(results, records%opening, K(1:1), error)
        call put_row(results, records%shear, K(2:2), error)
        call put_row(results, records%place, place_of_tip(model, state, tip) + model%origin, error)
        call put_row(results, records%length, [tip%length], error)
      end associate
    end do
  end subroutine put_tips

  !> Declares the series of the pieces by which cracks grow.
  subroutine declare_growth(results, records, error)
    type(results_t), intent(inout) :: results
    type(growth_records_t), intent(out) :: records
    type(error_t), allocatable, intent(inout) :: error

    call declare_series(results, '/growth/time', [integer ::], 'time', 'when the piece grew', records%time, error)
    call declare_series(results, '/growth/tip', [integer ::], '1', 'number of the tip that it belongs to, from 1', records%tip, &
                        error, whole=.true.)
    call declare_series(results, '/growth/start', [2], 'length', 'where it begins, by the places of the start', &
                        records%start, error)
    call declare_series(results, '/growth/end', [2], 'length', 'where it ends, likewise', records%end, error)
  end subroutine declare_growth

  !> Adds a row for each of some pieces. Errors: a number that is not finite.
  subroutine put_growth(results, records, cracks, origin, error)
    type(results_t), intent(inout) :: results
    type(growth_records_t), intent(in) :: records
    type(cracks_t), intent(in) :: cracks
    real(dp), intent(in) :: origin(2)    !! of the blocks, length
    type(error_t), allocatable, intent(inout) :: error
    integer :: i

    do i = 1, size(cracks%time)
      call put_row(results, records%time, [cracks%time(i)], error)
      call put_row(results, records%tip, [real(cracks%tip(i), dp)], error)
      call put_row(results, records%start, cracks%piece(:2, i) + origin, error)
      call put_row(results, records%end, cracks%piece(3:, i) + origin, error)
    end do
  end subroutine put_growth

  !> Adds a row to one series, unless an error has come before.
  subroutine put_row(results, handle, values, error)
    type(results_t), intent(inout) :: results
    integer, intent(in) :: handle
    real(dp), intent(in) :: values(:)
    type(error_t), allocatable, intent(inout) :: error

    if (.not. allocated(error)) call put_series(results, handle, values, error)
  end subroutine put_row

end module scree_crack_records
