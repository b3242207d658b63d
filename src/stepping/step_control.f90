!> Size of the next step: at most that of the deck, smaller after a cut, and such that the end and frames at set times are met.
module scree_step_control
  use scree_kinds, only: dp
  use scree_scene, only: settings_t
  use scree_state, only: state_t
  implicit none
  private
  public :: after_step, at_end, frame_due, has_no_step, is_past_peak, is_settled, next_size, resume_pace, share_done

  real(dp), parameter :: growth = 1.2_dp     !! of a step that was cut, once it goes well again
  integer, parameter :: easy_steps = 3       !! in a row, before it grows
  !> Of a static run that is to come to equilibrium: growth after a cut, and the largest step over the first.
  real(dp), parameter :: careful = 2.0_dp, largest = 1e6_dp
  !> A target is met where what is left is below this fraction of the step, so that round-off makes no step of its own.
  real(dp), parameter :: met = 1e-6_dp

contains

  !> Next time that a step must end at.
  pure real(dp) function target_time(settings, state)
    type(settings_t), intent(in) :: settings
    type(state_t), intent(in) :: state

    target_time = settings%end_time
    if (settings%frame_interval > 0) target_time = min(target_time, (state%pace%frames + 1)*settings%frame_interval)
  end function target_time

  !> Size to try.
  pure real(dp) function next_size(settings, state)
    type(settings_t), intent(in) :: settings
    type(state_t), intent(in) :: state

    next_size = state%pace%size
    associate (left => target_time(settings, state) - state%time)
      if (left < (1 + met)*next_size) then
        next_size = left
      else if (settings%aim > 0 .and. left < 2*next_size) then
        next_size = 0.5_dp*left ! not a step that is nearly nothing
      end if
    end associate
  end function next_size

  !> Fraction of a run that is done, from 0 to 1.
  pure real(dp) function share_done(settings, state)
    type(settings_t), intent(in) :: settings
    type(state_t), intent(in) :: state

    share_done = min(1.0_dp, max(state%time/settings%end_time, real(state%step, dp)/settings%most_steps))
  end function share_done

  !> Takes in how a step went that is done, and sets its time to a target that it met.
  pure subroutine after_step(settings, dt, rejected, state)
    type(settings_t), intent(in) :: settings
    real(dp), intent(in) :: dt           !! time
    integer, intent(in) :: rejected      !! tries
    type(state_t), intent(inout) :: state

    if (settles(state)) then
      call choose_size(settings, dt, rejected, state)
    else if (.not. settings%aim > 0) then ! else the error of the step has chosen the size
      if (rejected > 0) then
        state%pace%size = dt
        state%pace%easy = 0
      else
        state%pace%easy = state%pace%easy + 1
        if (state%pace%easy >= easy_steps) state%pace%size = min(growth*state%pace%size, settings%step_size)
        if (state%pace%easy >= easy_steps) state%pace%pseudo = grown(state%pace%pseudo, state%pace%size)
      end if
    end if
    if (abs(target_time(settings, state) - state%time) <= met*dt) state%time = target_time(settings, state)
  end subroutine after_step

  !> The size by which inertia resists the next static step; huge once it is that of the step.
  pure real(dp) function grown(pseudo, size)
    real(dp), intent(in) :: pseudo, size !! time

    grown = huge(1.0_dp)
    if (pseudo < size/growth) grown = growth*pseudo
  end function grown

  !> Whether a static run is to come to equilibrium under loads that stay.
  pure logical function settles(state)
    type(state_t), intent(in) :: state

    settles = .false.
    if (allocated(state%settling)) settles = state%settling%steady
  end function settles

  !> Chooses the size of the next step of a static run: as much larger as what moves allows, and carefully after a cut.
  pure subroutine choose_size(settings, dt, rejected, state)
    type(settings_t), intent(in) :: settings
    real(dp), intent(in) :: dt           !! time
    integer, intent(in) :: rejected      !! tries
    type(state_t), intent(inout) :: state
    real(dp) :: factor

    factor = state%settling%grows
    if (rejected > 0) state%pace%easy = -easy_steps
    if (rejected > 0) factor = min(factor, 1.0_dp)
    if (state%pace%easy < 0) factor = min(factor, careful)
    if (rejected == 0) state%pace%easy = state%pace%easy + 1
    state%pace%size = max(settings%least_step, min(factor*dt, largest*settings%step_size))
  end subroutine choose_size

  !> Fits the step control of a restarted run to settings that may have changed. With the same settings nothing changes.
  pure subroutine resume_pace(settings, state)
    type(settings_t), intent(in) :: settings
    type(state_t), intent(inout) :: state

    if (.not. (settings%chooses_step .or. settles(state))) state%pace%size = min(state%pace%size, settings%step_size)
    if (settings%frame_every > 0) return
    if (settings%frame_spacing > 0) then
      state%pace%frames = int(state%time/settings%frame_spacing + met)
    else if (state%pace%frames*settings%frame_interval > state%time .or. &
             (state%pace%frames + 1)*settings%frame_interval <= state%time) then
      state%pace%frames = int(state%time/settings%frame_interval + met)
    end if
  end subroutine resume_pace

  !> Whether the run is over; where it asks for that, past the peak of the force of moving supports, and a static one in equilibrium
  !> or where a body moves on.
  pure logical function at_end(settings, state)
    type(settings_t), intent(in) :: settings
    type(state_t), intent(in) :: state

    at_end = has_no_step(settings, state) .or. is_past_peak(settings, state)
    if (.not. allocated(state%settling)) return
    associate (own => state%settling)
      at_end = at_end .or. (own%steady .and. (own%unbalanced <= settings%balance .or. own%moving > 0))
    end associate
  end function at_end

  !> Whether time or number of the steps are used up.
  pure logical function has_no_step(settings, state)
    type(settings_t), intent(in) :: settings
    type(state_t), intent(in) :: state

    has_no_step = state%time >= settings%end_time .or. state%step >= settings%most_steps
  end function has_no_step

  !> Whether the force of moving supports has fallen to the fraction of its largest at which the run ends.
  pure logical function is_past_peak(settings, state)
    type(settings_t), intent(in) :: settings
    type(state_t), intent(in) :: state

    is_past_peak = .false.
    if (.not. (settings%past_peak >= 0 .and. state%pace%most_force > 0)) return
    is_past_peak = state%pace%support_force <= settings%past_peak*state%pace%most_force
  end function is_past_peak

  !> Whether what comes after a stage may begin: one that asks for equilibrium has come to it.
  pure logical function is_settled(settings, state)
    type(settings_t), intent(in) :: settings
    type(state_t), intent(in) :: state

    is_settled = .true.
    if (.not. allocated(state%settling)) return
    is_settled = state%settling%steady .and. state%settling%unbalanced <= settings%balance
  end function is_settled

  !> Whether the step that ended in this state makes a frame; counts it.
  logical function frame_due(settings, state)
    type(settings_t), intent(in) :: settings
    type(state_t), intent(inout) :: state
    integer :: passed

    if (settings%frame_every > 0) then
      frame_due = modulo(state%step, settings%frame_every) == 0
    else if (settings%frame_spacing > 0) then
      passed = int(state%time/settings%frame_spacing + met)
      frame_due = passed > state%pace%frames
      state%pace%frames = passed
    else
      frame_due = state%time >= target_time(settings, state)
      if (frame_due) state%pace%frames = state%pace%frames + 1
    end if
    frame_due = frame_due .or. at_end(settings, state)
  end function frame_due

end module scree_step_control
