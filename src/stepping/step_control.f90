!> Size of the next step: at most that of the deck, smaller after a cut, and such that the end and frames at set times are met.
module scree_step_control
  use scree_kinds, only: dp
  use scree_scene, only: settings_t
  implicit none
  private
  public :: after_step, at_end, begin_control, frame_due, next_size, step_control_t

  real(dp), parameter :: growth = 1.2_dp     !! of a step that was cut, once it goes well again
  integer, parameter :: easy_steps = 3       !! in a row, before it grows
  !> A target is met where what is left is below this share of a step, so that round-off makes no step of its own.
  real(dp), parameter :: met = 1e-6_dp

  !> What the control keeps from step to step.
  type :: step_control_t
    real(dp) :: size = 0.0_dp           !! that the next step may have, time
    real(dp) :: largest = 0.0_dp        !! that any step may have, time
    real(dp) :: end_time = 0.0_dp
    integer :: steps_left = huge(1)
    integer :: frame_every = 0          !! steps; 0: by time
    real(dp) :: frame_interval = 0.0_dp !! time that steps end at; 0: they need not
    real(dp) :: frame_spacing = 0.0_dp  !! time, where neither counts
    integer :: n_frames = 0             !! after the first; with a spacing, the last multiple of it that was passed
    integer :: easy = 0                 !! steps since the last cut
  end type step_control_t

contains

  !> Control at the start of a run.
  pure function begin_control(settings) result(control)
    type(settings_t), intent(in) :: settings
    type(step_control_t) :: control

    control%size = settings%step_size
    control%largest = settings%step_size
    control%end_time = settings%end_time
    control%steps_left = settings%most_steps
    control%frame_every = settings%frame_every
    control%frame_interval = settings%frame_interval
    control%frame_spacing = settings%frame_spacing
  end function begin_control

  !> Next time that a step must end at.
  pure real(dp) function target_time(control)
    type(step_control_t), intent(in) :: control

    target_time = control%end_time
    if (control%frame_interval > 0) &
      target_time = min(target_time, (control%n_frames + 1)*control%frame_interval)
  end function target_time

  !> Size to try.
  pure real(dp) function next_size(control, time)
    type(step_control_t), intent(in) :: control
    real(dp), intent(in) :: time

    next_size = control%size
    if (target_time(control) - time < (1 + met)*next_size) next_size = target_time(control) - time
  end function next_size

  !> Takes in how the step went, and sets `time` to a target that it met.
  pure subroutine after_step(control, dt, rejected, time)
    type(step_control_t), intent(inout) :: control
    real(dp), intent(in) :: dt
    integer, intent(in) :: rejected      !! tries
    real(dp), intent(inout) :: time

    control%steps_left = control%steps_left - 1
    if (rejected > 0) then
      control%size = dt
      control%easy = 0
    else
      control%easy = control%easy + 1
      if (control%easy >= easy_steps) control%size = min(growth*control%size, control%largest)
    end if
    if (abs(target_time(control) - time) <= met*dt) time = target_time(control)
  end subroutine after_step

  !> Whether the run is over.
  pure logical function at_end(control, time)
    type(step_control_t), intent(in) :: control
    real(dp), intent(in) :: time

    at_end = time >= control%end_time .or. control%steps_left <= 0
  end function at_end

  !> Whether the step that ended at `time` makes a frame; counts it.
  logical function frame_due(control, step, time)
    type(step_control_t), intent(inout) :: control
    integer, intent(in) :: step
    real(dp), intent(in) :: time
    integer :: passed

    if (control%frame_every > 0) then
      frame_due = modulo(step, control%frame_every) == 0
    else if (control%frame_spacing > 0) then
      passed = int(time/control%frame_spacing + met)
      frame_due = passed > control%n_frames
      control%n_frames = passed
    else
      frame_due = time >= target_time(control)
      if (frame_due) control%n_frames = control%n_frames + 1
    end if
    frame_due = frame_due .or. at_end(control, time)
  end function frame_due

end module scree_step_control
