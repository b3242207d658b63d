!> Series of cracks: a row each step of their tips, in /history/cracks, and a row for each piece by which they grow, in /growth.
!>
!> The columns are the tips that the decks draw, as they grow; cracks that begin have none. A tip that has met an outline or another
!> crack has zeros. So has the stress intensity of a tip whose disc has too little room.
module scree_crack_records
  use scree_crack_tip, only: crack_tip_t
  use scree_errors, only: error_t
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_results_file, only: declare_series, put_series, results_t
  use scree_state, only: cracks_t, state_t
  use scree_stress_intensity, only: place_of_tip, stress_intensity
  use scree_tip_disc, only: is_measured
  implicit none
  private
  public :: crack_records_t, declare_cracks, declare_growth, growth_records_t, put_cracks, put_growth

  !> Handles of the series; 0 where no stress intensity is asked for.
  type :: crack_records_t
    integer :: place = 0, opening = 0, shear = 0, length = 0
    integer :: n = 0 !! tips
  end type crack_records_t

  !> Handles of the series of pieces.
  type :: growth_records_t
    integer :: time = 0, tip = 0, start = 0, end = 0
  end type growth_records_t

contains

  !> Declares the series of some tips.
  subroutine declare_cracks(results, tips, records, error)
    type(results_t), intent(inout) :: results
    type(crack_tip_t), intent(in) :: tips(:)
    type(crack_records_t), intent(out) :: records
    type(error_t), allocatable, intent(inout) :: error

    records%n = size(tips)
    call a_series('place', [2, size(tips)], 'length', 'place of each tip', records%place)
    call a_series('K_I', [size(tips)], 'force/length^2*length^(1/2)', 'stress intensity factor of mode I', records%opening)
    call a_series('K_II', [size(tips)], 'force/length^2*length^(1/2)', 'stress intensity factor of mode II', records%shear)
    call a_series('length', [size(tips)], 'length', 'length of the crack of each tip', records%length)

  contains

    !> Declares one series.
    subroutine a_series(name, shape, units, description, handle)
      character(len=*), intent(in) :: name, units, description
      integer, intent(in) :: shape(:)
      integer, intent(out) :: handle

      call declare_series(results, '/history/cracks/'//name, shape, units, description, handle, error)
    end subroutine a_series

  end subroutine declare_cracks

  !> A row of each series. Errors: a number that is not finite.
  subroutine put_cracks(results, records, model, cache, state, error)
    type(results_t), intent(inout) :: results
    type(crack_records_t), intent(in) :: records
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(error_t), allocatable, intent(inout) :: error
    real(dp), allocatable :: K(:, :), length(:), place(:, :)
    integer :: i

    allocate (K(2, records%n), place(2, records%n), length(records%n), source=0.0_dp)
    do i = 1, size(model%tip)
      associate (tip => model%tip(i), number => model%tip(i)%number)
        if (number > records%n) cycle
        place(:, number) = place_of_tip(model, state, tip) + model%origin
        length(number) = tip%length
        if (is_measured(tip)) K(:, number) = stress_intensity(model, cache, state, tip)
      end associate
    end do
    call put_row(results, records%place, [place], error)
    call put_row(results, records%opening, K(1, :), error)
    call put_row(results, records%shear, K(2, :), error)
    call put_row(results, records%length, length, error)
  end subroutine put_cracks

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
