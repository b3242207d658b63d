!> What disturbs a body that sleeps: a load, a weight, the ground, a wave or a support that is not as it was when it fell asleep. An
!> effect that may change in a run is asked here for what it changes by.
module scree_disturbance
  use scree_absorbing_edge, only: change_of_free_field, size_of_wave
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_scene, only: time_table_t
  use scree_state, only: state_t
  use scree_time_table, only: mean_over, ramp_at, value_at
  implicit none
  private
  public :: disturbed

contains

  !> Blocks that sleep and whose loads, ground or supports in the next step differ from those with which they fell asleep: forces by
  !> more than the fraction of their weight, supports at all.
  pure function disturbed(model, dt, state) result(block)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: dt          !! time
    type(state_t), intent(in) :: state
    integer, allocatable :: block(:)
    logical :: is_disturbed(model%n_blocks)
    real(dp) :: change
    integer :: b, i

    is_disturbed = grows(model, state, state%time + dt) .or. is_shaken(model, dt, state)
    associate (effects => model%effects, of_element => model%elements%block, of_point => model%points%element, &
               sleep => state%sleep, share => model%effects%sleep, to => state%time + dt)
      if (allocated(effects%point_load)) then
        do i = 1, size(effects%point_load%point)
          b = of_element(of_point(effects%point_load%point(i)))
          if (sleep%island(b) == 0) cycle
          change = norm2(mean_over(effects%point_load%table(i), state%time, to) &
                         - value_at(effects%point_load%table(i), sleep%since(b)))
          is_disturbed(b) = is_disturbed(b) .or. change > share*sum(abs(effects%gravity%weight), of_element == b)
        end do
      end if
      if (allocated(effects%fixed_point)) then
        do i = 1, size(effects%fixed_point%point)
          b = of_element(of_point(effects%fixed_point%point(i)))
          if (sleep%island(b) == 0 .or. .not. allocated(effects%fixed_point%table(i)%time)) cycle
          is_disturbed(b) = is_disturbed(b) .or. norm2(value_at(effects%fixed_point%table(i), to) &
                                                       - value_at(effects%fixed_point%table(i), sleep%since(b))) > 0
        end do
      end if
    end associate
    block = pack([(b, b=1, model%n_blocks)], is_disturbed)
  end function disturbed

  !> Blocks that sleep and that the ground, or a wave, moves in the next step by more than the fraction of their weight.
  pure function is_shaken(model, dt, state)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: dt          !! time
    type(state_t), intent(in) :: state
    logical :: is_shaken(model%n_blocks)
    real(dp) :: change
    integer :: b, k

    is_shaken = .false.
    if (.not. allocated(model%effects%base_acceleration) .and. .not. allocated(model%effects%absorbing_edge)) return
    do k = 1, size(model%elements%free)
      associate (e => model%elements%free(k), effects => model%effects)
        b = model%elements%block(e)
        if (state%sleep%island(b) == 0) cycle
        change = 0.0_dp
        if (allocated(effects%base_acceleration)) &
          change = model%elements%mass(e)*norm2(change_of(effects%base_acceleration%record, state%sleep%since(b)))
        if (allocated(effects%absorbing_edge)) &
          change = change + size_of_wave(effects%absorbing_edge, e, state%point, &
                                         change_of(effects%absorbing_edge%wave, state%sleep%since(b))) &
                   + change_of_free_field(effects%absorbing_edge, e, state%point, state%sleep%since(b), state%time, &
                                          state%time + dt)
        is_shaken(b) = is_shaken(b) .or. change > effects%sleep*abs(effects%gravity%weight(e))
      end associate
    end do

  contains

    !> Mean of a record in the step less its value at a time.
    pure function change_of(record, since) result(change)
      type(time_table_t), intent(in) :: record
      real(dp), intent(in) :: since     !! time
      real(dp) :: change(2)

      change = mean_over(record, state%time, state%time + dt) - value_at(record, since)
    end function change_of

  end function is_shaken

  !> Blocks that sleep and whose weight or loads on edges have grown on their ramps since they fell asleep.
  pure function grows(model, state, time)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(dp), intent(in) :: time
    logical :: grows(model%n_blocks)
    integer :: b, k

    grows = .false.
    do k = 1, size(model%elements%free)
      associate (e => model%elements%free(k), effects => model%effects)
        b = model%elements%block(e)
        if (state%sleep%island(b) == 0) cycle
        if (allocated(effects%gravity)) grows(b) = grows(b) .or. more(effects%gravity%ramp, state%sleep%since(b))
        if (.not. allocated(effects%edge_load)) cycle
        if (effects%edge_load%first(e + 1) > effects%edge_load%first(e)) &
          grows(b) = grows(b) .or. more(effects%edge_load%ramp, state%sleep%since(b))
      end associate
    end do

  contains

    !> Whether there is more on a ramp now than there was.
    pure logical function more(ramp, since)
      real(dp), intent(in) :: ramp, since  !! time

      more = ramp_at(ramp, time) > ramp_at(ramp, since)
    end function more

  end function grows

end module scree_disturbance
