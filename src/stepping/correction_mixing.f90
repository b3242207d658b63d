!> Corrections by the secant, of which a fraction is taken, mixed with those before.
module scree_correction_mixing
  use scree_anderson, only: anderson_t, mix_step
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  implicit none
  private
  public :: mix

contains

  !> Takes the fraction of a correction that is asked for, mixed with those before. Elements may share unknowns: each counts once.
  subroutine mix(model, cache, member, mixing, d)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    integer, intent(in) :: member(:)              !! elements of the group
    type(anderson_t), intent(inout) :: mixing     !! of its corrections
    real(dp), intent(inout) :: d(:)               !! (n_unknowns) with the correction
    logical :: listed(size(d))
    integer, allocatable :: ids(:)
    real(dp), allocatable :: step(:)
    real(dp) :: span(size(d))
    integer :: i, k

    listed = .false.
    span = 1.0_dp ! of covers
    do k = 1, size(member)
      associate (e => member(k))
        listed(cache%equations%unknown(:, e)) = .true.
        span(model%elements%unknown(:, e)) = cache%element(e)%kinematics%span
      end associate
    end do
    ids = pack([(i, i=1, size(d))], listed)
    step = cache%equations%correction(ids)
    d(ids) = d(ids) - step
    call mix_step(mixing, model%settings%anderson, model%settings%relaxation, span(ids), d(ids), step)
    d(ids) = d(ids) + step
  end subroutine mix

end module scree_correction_mixing
