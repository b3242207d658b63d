!> How long runs of a deck will take, told by short ones.
module scree_estimate
  use, intrinsic :: iso_c_binding, only: c_int, c_long
  use scree_block_input, only: blocks_t
  use scree_errors, only: error_t, status_signal
  use scree_kinds, only: dp
  use scree_forecast, only: begin_probe, forecast_of, forecast_t, probe_t, seconds_of, steps_of
  use scree_read_scene, only: read_scene
  use scree_scene, only: contact_none, model_dda, run_options_t, scene_t
  use scree_simulation, only: simulate
  use scree_text, only: number_text, rounded_text, text_t
  use scree_timers, only: begin_timers, timers_t
  implicit none
  private
  public :: estimate_runs

  real(dp), parameter :: probe_seconds = 10.0_dp !! that the steps of one run may take
  real(dp), parameter :: coarser = 8.0_dp        !! step or accuracy of a run that tells what comes later, over its own

  character(len=*), parameter :: small_steps = 'small steps', implicit = 'implicit'

  !> A scheme that a deck does not have: its name, and the setting that asks for it.
  type :: other_scheme_t
    character(len=:), allocatable :: name, setting
  end type other_scheme_t

  !> C: struct rusage on Linux and the BSDs, two times of two longs and fourteen longs.
  type, bind(c) :: usage_t
    integer(c_long) :: times(4)
    integer(c_long) :: most_resident      !! kB
    integer(c_long) :: others(13)
  end type usage_t

  interface
    function c_usage(who, usage) bind(c, name='getrusage')
      import :: c_int, usage_t
      integer(c_int), value :: who
      type(usage_t), intent(out) :: usage
      integer(c_int) :: c_usage
    end function c_usage

    function c_process() bind(c, name='getpid')
      import :: c_int
      integer(c_int) :: c_process
    end function c_process
  end interface

contains

  !> Runs a deck as it is, with each accuracy from the coarsest on, and by small steps or, if it has these, by the implicit scheme.
  !> Each run takes some seconds. Prints what whole runs take: steps, seconds of the processor with their range, memory. The rest
  !> of a run is assumed to cost as much as its first seconds, or as the rest of a coarser run that came to its end.
  !>
  !> Errors: decks that do not run, a run that fails or that a signal stops. If the other scheme cannot run the deck, a line says
  !> why.
  subroutine estimate_runs(geometry, analysis, settings, accuracy, unit, error)
    character(len=*), intent(in) :: geometry, analysis
    type(text_t), intent(in) :: settings(:)  !! given with --set
    type(text_t), intent(in) :: accuracy(:)  !! values of step.accuracy, the coarsest first
    integer, intent(in) :: unit
    type(error_t), allocatable, intent(out) :: error
    type(other_scheme_t), allocatable :: other
    type(probe_t) :: shape !! the last run of the scheme of the deck that came to its end
    character(len=:), allocatable :: asked
    integer :: i

    call find_other_scheme(geometry, analysis, settings, other, error)
    if (allocated(error)) return
    write (unit, '(a)') 'run               steps   seconds      from        to  memory, MB  told by'
    if (first(small_steps)) call estimate_other() ! memory is that of the largest run so far
    call estimate_run('as it is', settings, shape)
    do i = 1, size(accuracy)
      if (allocated(error)) return
      asked = 'step.accuracy='//accuracy(i)%text
      call estimate_run('accuracy '//accuracy(i)%text, [settings, text_t(asked)], shape)
    end do
    if (first(implicit)) call estimate_other()
    if (allocated(other) .and. .not. allocated(error)) &
      write (unit, '(a)') small_steps//' leave out the strain of blocks, waves and the stiffness of joints; the '//implicit// &
      ' scheme leaves out nothing'

  contains

    !> Whether the other scheme has a name and is to run next.
    logical function first(name)
      character(len=*), intent(in) :: name

      first = .false.
      if (allocated(other) .and. .not. allocated(error)) first = other%name == name
    end function first

    subroutine estimate_other()
      type(probe_t) :: shape

      asked = other%setting
      call estimate_run(other%name, [settings, text_t(asked)], shape)
      if (.not. allocated(error)) return
      if (error%status >= status_signal) return
      write (unit, '(a)') other%name//': '//error%message
      deallocate (error, other)
    end subroutine estimate_other

    subroutine estimate_run(name, settings, shape)
      character(len=*), intent(in) :: name
      type(text_t), intent(in) :: settings(:)
      type(probe_t), intent(inout) :: shape !! of a run that came to its end
      type(probe_t) :: coarse, probe
      type(forecast_t) :: seconds

      call run_probe(geometry, analysis, settings, 1.0_dp, probe, error)
      if (allocated(error)) return
      if (shape%ended) then
        call print_forecast(unit, name, probe, forecast_of(steps_of(probe), steps_of(shape)), &
                            forecast_of(seconds_of(probe), seconds_of(shape)), '')
      else
        if (.not. probe%ended) call run_coarsely(geometry, analysis, settings, coarse, error)
        if (allocated(error)) return
        seconds = forecast_of(seconds_of(probe))
        if (coarse%ended) seconds = joined(forecast_of(seconds_of(probe), seconds_of(coarse)), seconds)
        call print_forecast(unit, name, probe, forecast_of(steps_of(probe)), seconds, &
                            trim(merge(' and a whole one in longer steps', repeat(' ', 32), coarse%ended)))
      end if
      if (probe%ended) shape = probe
    end subroutine estimate_run

  end subroutine estimate_runs

  !> Finds the scheme that the first dynamic stage of a deck does not have, if it has blocks that may meet: small steps, or the
  !> implicit scheme if the deck has small steps. Errors: decks that cannot be read.
  subroutine find_other_scheme(geometry, analysis, settings, other, error)
    character(len=*), intent(in) :: geometry, analysis
    type(text_t), intent(in) :: settings(:)
    type(other_scheme_t), allocatable, intent(out) :: other
    type(error_t), allocatable, intent(out) :: error
    type(scene_t) :: scene
    type(blocks_t) :: blocks
    integer :: i, stage

    call read_scene(geometry, analysis, settings, scene, blocks, error)
    if (allocated(error)) return
    if (scene%settings%model /= model_dda .or. scene%settings%contact == contact_none .or. size(blocks%material) < 2) return
    stage = 0
    do i = size(scene%later), 1, -1
      if (.not. scene%later(i)%is_static()) stage = i + 1
    end do
    if (.not. scene%is_static()) stage = 1
    if (stage == 0) return
    other = other_scheme_t(small_steps, 'integrator.scheme=small_steps')
    if (stage == 1) then
      if (scene%settings%takes_small_steps()) other = other_scheme_t(implicit, 'integrator.scheme=energy_decaying')
    else
      if (scene%later(stage - 1)%settings%takes_small_steps()) &
        other = other_scheme_t(implicit, 'integrator.scheme=energy_decaying')
      other%setting = 'stage('//number_text(stage)//').'//other%setting
    end if
  end subroutine find_other_scheme

  !> Two forecasts of which none is known to be the better one: their geometric mean, with the spread of both.
  pure type(forecast_t) function joined(a, b)
    type(forecast_t), intent(in) :: a, b

    joined = forecast_t(sqrt(a%value*b%value), min(a%low, b%low), max(a%high, b%high))
  end function joined

  !> Runs a deck in longer steps, for as long as a probe, which is of no use where that does not come to its end. Small steps get
  !> longer by their accuracy.
  !>
  !> Errors: a signal. A run that fails in such steps tells nothing.
  subroutine run_coarsely(geometry, analysis, settings, probe, error)
    character(len=*), intent(in) :: geometry, analysis
    type(text_t), intent(in) :: settings(:)
    type(probe_t), intent(out) :: probe
    type(error_t), allocatable, intent(out) :: error

    call run_probe(geometry, analysis, settings, coarser, probe, error)
    if (.not. allocated(error)) return
    if (error%status < status_signal) deallocate (error)
  end subroutine run_coarsely

  !> Runs a deck for some seconds. Longer steps are for motions alone: of a static run they make another one.
  subroutine run_probe(geometry, analysis, settings, longer, probe, error)
    character(len=*), intent(in) :: geometry, analysis
    type(text_t), intent(in) :: settings(:)
    real(dp), intent(in) :: longer        !! factor of the steps of the deck
    type(probe_t), intent(out) :: probe
    type(error_t), allocatable, intent(out) :: error
    type(run_options_t) :: options
    type(scene_t) :: scene
    type(blocks_t) :: blocks
    type(timers_t) :: timers

    call begin_probe(probe_seconds, probe)
    call begin_timers(timers)
    call read_scene(geometry, analysis, settings, scene, blocks, error)
    if (allocated(error)) return
    if (longer > 1 .and. (size(scene%later) > 0 .or. scene%is_static())) return
    if (scene%settings%takes_small_steps()) then
      scene%settings%run_out = longer*scene%settings%run_out
    else
      scene%settings%step_size = longer*scene%settings%step_size
    end if
    options%results_path = scratch_folder()//'/scree-estimate-'//number_text(int(c_process()))//'.h5'
    options%restart_path = ''
    options%runs = .true.
    options%quiet = .true.
    call simulate(scene, blocks, timers, options, error, probe)
  end subroutine run_probe

  !> Where files go that are not to stay.
  function scratch_folder() result(folder)
    character(len=:), allocatable :: folder
    integer :: length

    call get_environment_variable('TMPDIR', length=length)
    allocate (character(len=length) :: folder)
    if (length > 0) call get_environment_variable('TMPDIR', folder)
    if (length == 0) folder = '/tmp'
  end function scratch_folder

  !> Prints a line of the table: steps and seconds of a whole run, memory of the probe, and by how much of the run that is told.
  subroutine print_forecast(unit, name, probe, steps, seconds, beside)
    integer, intent(in) :: unit
    character(len=*), intent(in) :: name, beside !! beside: what told it too
    type(probe_t), intent(in) :: probe
    type(forecast_t), intent(in) :: steps, seconds
    type(usage_t) :: usage
    character(len=:), allocatable :: by

    by = 'the whole run'
    if (.not. probe%ended) &
      by = number_text(probe%n - 1)//' steps, '//rounded_text(100*probe%share(probe%n))//' % of the run'//beside
    if (c_usage(0_c_int, usage) /= 0) usage%most_resident = 0
    write (unit, '(a16,i8,3(1x,a9),1x,i11,2x,a)') name//repeat(' ', max(0, 16 - len(name))), nint(min(steps%value, 1e9_dp)), &
      three_digits(seconds%value), three_digits(seconds%low), three_digits(seconds%high), usage%most_resident/1024, by
    flush (unit)
  end subroutine print_forecast

  !> A number of seconds, to three digits.
  pure function three_digits(x) result(text)
    real(dp), intent(in) :: x
    character(len=9) :: text

    write (text, '(es9.2)') x
    if (x >= 0.01_dp .and. x < 100) write (text, '(f9.3)') x
    if (x >= 100 .and. x < 1e8_dp) write (text, '(f9.0)') x
  end function three_digits

end module scree_estimate
