!> Summary of a run, in words for a screen, and as a JSON object (doc/results.md).
module scree_summary_words
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use scree_bearings, only: steps_in_swing
  use scree_equilibrium, only: words_of_balance
  use scree_json, only: begin_list, begin_object, end_list, end_object, json_t, put, put_null
  use scree_kinds, only: dp
  use scree_run_summary, only: change_of_area, lost_otherwise, share_lost, share_of_blows, stage_ending_t, summary_t, &
                               vertex_most_t
  use scree_step_try, only: cut_reasons
  use scree_text, only: append, number_text, place_text, rounded_text, short_text, text_t
  use scree_timers, only: cost_t
  implicit none
  private
  public :: ending_t, json_of, lines_of, warning_of_blows, warning_of_error, warning_of_swings

  integer, parameter :: most_phases = 5          !! named on the screen
  real(dp), parameter :: least_share = 0.02_dp   !! of the time that a phase named there took
  real(dp), parameter :: suspicious_blows = 0.1_dp !! fraction of the energy that is worth a warning
  real(dp), parameter :: suspicious_loss = 1e-2_dp !! fraction of the energy, where nothing says how far a run may be off
  real(dp), parameter :: too_far_off = 2.0_dp    !! times what was asked for that is, as far as an estimate can tell

  !> How a run ended.
  type :: ending_t
    character(len=:), allocatable :: status      !! as in doc/results.md: complete, cut, interrupted, stopped: reason, ...
    character(len=:), allocatable :: path        !! of the results, empty where they are lost
    type(text_t), allocatable :: warning(:)      !! that were given
    type(cost_t), allocatable :: cost(:)
  end type ending_t

contains

  !> The summary as lines, the last of which names the results.
  function lines_of(summary, ending) result(line)
    type(summary_t), intent(in) :: summary
    type(ending_t), intent(in) :: ending
    type(text_t), allocatable :: line(:)
    integer :: i

    allocate (line(0))
    call add('ended: '//words_of_end(summary, ending%status))
    if (allocated(summary%stage)) then
      do i = 1, size(summary%stage)
        call add(words_of_stage(summary%stage(i)))
      end do
    end if
    call add('steps: '//words_of_steps(summary, ending))
    call add('displacement: '//words_of_vertex(summary%displacement, summary%extent))
    if (.not. summary%is_static) call add('speed: '//words_of_speed(summary))
    if (allocated(summary%balance)) call add('balance: '//words_of_forces(summary))
    call add('energy: '//words_of_energy(summary))
    call add('area: '//words_of_change(change_of_area(summary)))
    if (summary%touches) call add('overlap: '//words_of_overlap(summary))
    if (allocated(summary%off)) call add('error: '//words_of_error(summary))
    call add('time: '//words_of_time(ending%cost))
    if (size(ending%warning) > 0) call add('warnings: '//number_text(size(ending%warning)))
    if (len(ending%path) > 0) then
      call add('results: '//ending%path)
    else
      call add('results: none, as their file was removed, renamed or replaced')
    end if

  contains

    !> Adds a line.
    subroutine add(text)
      character(len=*), intent(in) :: text

      call append(line, text)
    end subroutine add

  end function lines_of

  !> How and when it ended.
  function words_of_end(summary, status) result(text)
    type(summary_t), intent(in) :: summary
    character(len=*), intent(in) :: status
    character(len=:), allocatable :: text

    text = status(:index(status//':', ':') - 1)//' at time '//words_of_instant(summary%reached)
    if (summary%asked < huge(summary%asked)) text = text//' of '//words_of_instant(summary%asked)
    if (summary%past_peak) text = text//', past the peak: moving supports push with '// &
                                  words(summary%support_force(1))//' after '//words(summary%support_force(2))
  end function words_of_end

  !> Summary of a stage.
  function words_of_stage(stage) result(text)
    type(stage_ending_t), intent(in) :: stage
    character(len=:), allocatable :: text

    text = stage%name//': '//trim(merge('static ', 'dynamic', stage%static))//', '//stage%verdict//', '// &
           number_text(stage%steps)//' steps to time '//words_of_instant(stage%to)
    if (abs(stage%given) > 0) &
      text = text//'; the change to it '//trim(merge('removed ', 'supplied', stage%given < 0))//' an energy of '// &
             words(abs(stage%given))
  end function words_of_stage

  !> Steps planned and taken, and what they took.
  function words_of_steps(summary, ending) result(text)
    type(summary_t), intent(in) :: summary
    type(ending_t), intent(in) :: ending
    character(len=:), allocatable :: text

    text = number_text(summary%taken)//' taken'
    if (summary%planned >= 0) text = text//' of '//number_text(summary%planned)//' planned'
    text = text//', '//number_text(summary%cut)//' tried again smaller'//words_of_cuts(summary)//'; '// &
           number_text(summary%solves)//' systems solved, '//number_text(factors_of(ending%cost))//' matrices factorised'
  end function words_of_steps

  !> How many tries were made again with a smaller step, by reason, in brackets; nothing where none was.
  function words_of_cuts(summary) result(text)
    type(summary_t), intent(in) :: summary
    character(len=:), allocatable :: text
    integer :: i

    text = ''
    do i = 1, size(cut_reasons)
      if (summary%cuts(i) > 0) text = text//', '//trim(cut_reasons(i))//' '//number_text(summary%cuts(i))
    end do
    if (len(text) > 0) text = ' ('//text(3:)//')'
  end function words_of_cuts

  !> The fastest vertex, and whether all blocks are at rest.
  function words_of_speed(summary) result(text)
    type(summary_t), intent(in) :: summary
    character(len=:), allocatable :: text

    text = words_of_vertex(summary%speed, summary%extent)
    if (.not. allocated(summary%at_rest)) return
    text = text//'; '//trim(merge('all blocks are at rest    ', 'not all blocks are at rest', summary%at_rest))
  end function words_of_speed

  !> Whether the forces of a static run balance, and how it moves where they do not.
  function words_of_forces(summary) result(text)
    type(summary_t), intent(in) :: summary
    character(len=:), allocatable :: text

    associate (balance => summary%balance)
      if (balance%block == 0) then
        text = 'nothing can move'
      else if (balance%share <= summary%tolerance) then
        text = 'in equilibrium; the largest unbalanced force is '//words(balance%share)//' of the forces on block '// &
               number_text(balance%block)
      else
        text = 'not in equilibrium: '//words_of_balance(balance)
      end if
    end associate
  end function words_of_forces

  !> The largest value, its block and its place.
  function words_of_vertex(most, extent) result(text)
    type(vertex_most_t), intent(in) :: most
    real(dp), intent(in) :: extent       !! of the model, length
    character(len=:), allocatable :: text

    text = 'none'
    if (abs(most%value) > 0 .or. .not. ieee_is_finite(most%value)) &
      text = 'at most '//words(most%value)//', of block '//number_text(most%block)//' at '//words_of_position(most%position, extent)
  end function words_of_vertex

  !> Energy supplied, and where it went. A static step drops the kinetic energy that it ends with: half of what a load supplies
  !> that acts on linear springs at once.
  function words_of_energy(summary) result(text)
    type(summary_t), intent(in) :: summary
    character(len=:), allocatable :: text

    associate (lost => lost_otherwise(summary))
      text = words(summary%given)//' supplied; friction took '//words(summary%friction)//', damping '//words(summary%damping)
      if (summary%has_bolts) text = text//', bolts '//words(summary%yield)
      if (summary%fractures) text = text//', fracture '//words(summary%fracture)
      if (summary%staged < 0 .and. (allocated(summary%stage) .or. summary%may_leave)) &
        text = text//trim(merge(', changes of stages', ', blocks that left ', allocated(summary%stage)))//' '// &
               words(-summary%staged)
      text = text//'; '//words(abs(lost))//' ('//words(100*abs(share_lost(summary)))//' %) was '
      if (lost < 0) then
        text = text//'gained, an error of the steps'
      else
        text = text//'lost in '//trim(merge('static steps     ', 'impacts and steps', summary%is_static))
      end if
    end associate
  end function words_of_energy

  !> A relative change in words.
  function words_of_change(change) result(text)
    real(dp), intent(in) :: change
    character(len=:), allocatable :: text

    text = 'the blocks '//trim(merge('shrank', 'grew  ', change < 0))//' by '//words(100*abs(change))//' %'
  end function words_of_change

  !> The deepest overlap, where and when.
  function words_of_overlap(summary) result(text)
    type(summary_t), intent(in) :: summary
    character(len=:), allocatable :: text

    associate (overlap => summary%overlap)
      text = 'none'
      if (overlap%blocks(1) > 0) text = 'at most '//words(overlap%value)//', of block '//number_text(overlap%blocks(1))// &
        ' in block '//number_text(overlap%blocks(2))//' at '//words_of_position(overlap%position, summary%extent)//', time '// &
        words_of_instant(overlap%time)
    end associate
  end function words_of_overlap

  !> Warning where more than a tenth of the energy strikes in steps that are too long for its bounce; nothing else.
  function warning_of_blows(summary) result(text)
    type(summary_t), intent(in) :: summary
    character(len=:), allocatable :: text

    text = ''
    if (share_of_blows(summary) > suspicious_blows) &
      text = words(100*min(1.0_dp, share_of_blows(summary)))//' % of the supplied energy went into impacts that the steps are '// &
             'too long to follow, so chance decides how far blocks bounce: set contact.restitution, from 0 (no bounce) to 1 '// &
             '(full bounce), or take steps of at most '//words(summary%blows%swing/steps_in_swing)
  end function warning_of_blows

  !> How far the run is off, by its own estimate.
  function words_of_error(summary) result(text)
    type(summary_t), intent(in) :: summary
    character(len=:), allocatable :: text

    text = 'the run estimates that its displacements are off by '//words(summary%off)//' of their size'
    if (summary%aim > 0) text = text//'; step.accuracy asks for '//words(summary%aim)
  end function words_of_error

  !> Warning where that is clearly more than was asked for; nothing else.
  function warning_of_error(summary) result(text)
    type(summary_t), intent(in) :: summary
    character(len=:), allocatable :: text

    text = ''
    if (.not. (allocated(summary%off) .and. summary%aim > 0)) return
    if (summary%off > too_far_off*summary%aim) &
      text = words_of_error(summary)//': lower step.accuracy until the results that you look at stay the same'
  end function warning_of_error

  !> Warning where more was lost than the estimate of the error may leave out: it has nothing of what steps take from blocks that
  !> swing on bolts and joints. Nothing else.
  function warning_of_swings(summary) result(text)
    type(summary_t), intent(in) :: summary
    character(len=:), allocatable :: text

    text = ''
    if (.not. (allocated(summary%off) .and. summary%may_swing)) return
    if (share_lost(summary) > merge(summary%aim, suspicious_loss, summary%aim > 0)) &
      text = words(100*share_lost(summary))//' % of the supplied energy was lost in impacts, or where blocks swing on bolts '// &
             'and joints; the estimated error does not contain that loss: try a tenth of step.size or of step.accuracy'
  end function warning_of_swings

  !> Time of the wall, and the phases that took most of it.
  function words_of_time(cost) result(text)
    type(cost_t), intent(in) :: cost(:)
    character(len=:), allocatable :: text
    logical :: left(size(cost))
    integer :: i, k

    text = short_text(sum(cost%wall), 3)//' s'
    left = .true.
    do i = 1, min(most_phases, size(cost))
      k = maxloc(cost%share, 1, mask=left)
      if (cost(k)%share < least_share) exit
      left(k) = .false.
      text = text//', '//trim(cost(k)%phase)//' '//number_text(nint(100*cost(k)%share))//' %'
    end do
  end function words_of_time

  !> A place in words, whatever became of it.
  function words_of_position(position, extent) result(text)
    real(dp), intent(in) :: position(2)
    real(dp), intent(in) :: extent       !! of the model, length
    character(len=:), allocatable :: text

    text = 'no place'
    if (all(ieee_is_finite(position))) text = place_text(position, extent)
  end function words_of_position

  !> A time in words.
  function words_of_instant(time) result(text)
    real(dp), intent(in) :: time
    character(len=:), allocatable :: text

    text = 'no number'
    if (ieee_is_finite(time)) text = rounded_text(time)
  end function words_of_instant

  !> A number for people, whatever became of it.
  function words(x)
    real(dp), intent(in) :: x
    character(len=:), allocatable :: words

    words = 'no number'
    if (ieee_is_finite(x)) words = short_text(x)
  end function words

  !> Matrices factorised.
  pure integer function factors_of(cost) result(factors)
    type(cost_t), intent(in) :: cost(:)

    factors = sum(cost%calls, cost%phase == 'factor')
  end function factors_of

  !> The summary as a JSON object on one line.
  function json_of(summary, ending) result(text)
    type(summary_t), intent(in) :: summary
    type(ending_t), intent(in) :: ending
    character(len=:), allocatable :: text
    type(json_t) :: json

    call begin_object(json, '')
    call put(json, 'status', ending%status)
    if (len(ending%path) > 0) then
      call put(json, 'results', ending%path)
    else
      call put_null(json, 'results')
    end if
    call put_stages(json, summary)
    call put_steps(json, summary, factors_of(ending%cost))
    call put_motion(json, summary)
    call put_balance(json, summary)
    call put_support_force(json, summary)
    call put_books(json, summary)
    call put(json, 'change_of_area', change_of_area(summary))
    call put_overlap(json, summary)
    call put_blows(json, summary)
    call put_error(json, summary)
    call put(json, 'warnings', size(ending%warning))
    call put_cost(json, ending%cost)
    call end_object(json)
    call move_alloc(json%text, text)
  end function json_of

  !> Summaries of the stages, where there are several.
  subroutine put_stages(json, summary)
    type(json_t), intent(inout) :: json
    type(summary_t), intent(in) :: summary
    integer :: i

    if (.not. allocated(summary%stage)) return
    call begin_list(json, 'stages')
    do i = 1, size(summary%stage)
      associate (stage => summary%stage(i))
        call begin_object(json, '')
        call put(json, 'name', stage%name)
        call put(json, 'kind', trim(merge('static ', 'dynamic', stage%static)))
        call put(json, 'status', stage%verdict)
        call put(json, 'from', stage%from)
        call put(json, 'reached', stage%to)
        call put(json, 'steps', stage%steps)
        call put(json, 'energy_given', stage%given)
        call end_object(json)
      end associate
    end do
    call end_list(json)
  end subroutine put_stages

  !> Times and steps.
  subroutine put_steps(json, summary, factors)
    type(json_t), intent(inout) :: json
    type(summary_t), intent(in) :: summary
    integer, intent(in) :: factors
    integer :: i

    call begin_object(json, 'time')
    call put(json, 'from', summary%from)
    call put(json, 'reached', summary%reached)
    if (summary%asked < huge(summary%asked)) then
      call put(json, 'asked', summary%asked)
    else
      call put_null(json, 'asked')
    end if
    call end_object(json)
    call begin_object(json, 'steps')
    if (summary%planned >= 0) then
      call put(json, 'planned', summary%planned)
    else
      call put_null(json, 'planned')
    end if
    call put(json, 'taken', summary%taken)
    call put(json, 'cut', summary%cut)
    call begin_object(json, 'cut_by')
    do i = 1, size(cut_reasons)
      call put(json, trim(cut_reasons(i)), summary%cuts(i))
    end do
    call end_object(json)
    call put(json, 'solves', summary%solves)
    call put(json, 'factors', factors)
    call end_object(json)
  end subroutine put_steps

  !> Motion at the end: displacement, speed, rest, balance.
  subroutine put_motion(json, summary)
    type(json_t), intent(inout) :: json
    type(summary_t), intent(in) :: summary

    call put_vertex('displacement', summary%displacement)
    call put_vertex('speed', summary%speed)
    call put(json, 'at_rest', summary%at_rest)

  contains

    !> The largest value, its block and its place.
    subroutine put_vertex(name, most)
      character(len=*), intent(in) :: name
      type(vertex_most_t), intent(in) :: most

      call begin_object(json, name)
      call put(json, 'largest', most%value)
      call put(json, 'block', most%block)
      call put_position(json, most%position)
      call end_object(json)
    end subroutine put_vertex

  end subroutine put_motion

  !> How far a static run is from equilibrium.
  subroutine put_balance(json, summary)
    type(json_t), intent(inout) :: json
    type(summary_t), intent(in) :: summary
    logical, allocatable :: moves

    if (.not. allocated(summary%balance)) then
      call put_null(json, 'balance')
      return
    end if
    associate (balance => summary%balance)
      call begin_object(json, 'balance')
      call put(json, 'share', balance%share)
      call put(json, 'tolerance', summary%tolerance)
      call put(json, 'force', balance%force)
      call put(json, 'block', balance%block)
      call put_position(json, balance%position)
      call put_pair(json, 'way', balance%way)
      call put(json, 'speed', balance%speed)
      call put(json, 'others', balance%others)
      moves = balance%moves
      call put(json, 'moves', moves)
      call end_object(json)
    end associate
  end subroutine put_balance

  !> Force of moving supports along their motion.
  subroutine put_support_force(json, summary)
    type(json_t), intent(inout) :: json
    type(summary_t), intent(in) :: summary

    if (.not. allocated(summary%support_force)) then
      call put_null(json, 'support_force')
      return
    end if
    call begin_object(json, 'support_force')
    call put(json, 'last', summary%support_force(1))
    call put(json, 'largest', summary%support_force(2))
    call end_object(json)
  end subroutine put_support_force

  !> The books of energy.
  subroutine put_books(json, summary)
    type(json_t), intent(inout) :: json
    type(summary_t), intent(in) :: summary

    call begin_object(json, 'energy')
    call put(json, 'given', summary%given)
    call put(json, 'work', summary%work)
    call put(json, 'fallen', summary%fallen)
    if (allocated(summary%stage) .or. summary%may_leave) call put(json, 'stages', summary%staged)
    call put(json, 'dissipated', summary%dissipated)
    call put(json, 'friction', summary%friction)
    call put(json, 'damping', summary%damping)
    if (summary%has_bolts) call put(json, 'bolts', summary%yield)
    if (summary%fractures) call put(json, 'fracture', summary%fracture)
    call put(json, 'asleep', summary%asleep)
    call put(json, 'lost_otherwise', lost_otherwise(summary))
    call put(json, 'share_lost', share_lost(summary))
    call end_object(json)
  end subroutine put_books

  !> The deepest overlap, if there is any.
  subroutine put_overlap(json, summary)
    type(json_t), intent(inout) :: json
    type(summary_t), intent(in) :: summary

    associate (overlap => summary%overlap)
      if (overlap%blocks(1) == 0) then
        call put_null(json, 'overlap')
        return
      end if
      call begin_object(json, 'overlap')
      call put(json, 'largest', overlap%value)
      call put(json, 'time', overlap%time)
      call begin_list(json, 'blocks')
      call put(json, '', overlap%blocks(1))
      call put(json, '', overlap%blocks(2))
      call end_list(json)
      call put_position(json, overlap%position)
      call end_object(json)
    end associate
  end subroutine put_overlap

  !> Impacts in steps that do not resolve them, if any.
  subroutine put_blows(json, summary)
    type(json_t), intent(inout) :: json
    type(summary_t), intent(in) :: summary

    if (.not. summary%blows%energy > 0) then
      call put_null(json, 'impacts')
      return
    end if
    call begin_object(json, 'impacts')
    call put(json, 'energy', summary%blows%energy)
    call put(json, 'share', share_of_blows(summary))
    call put(json, 'swing', summary%blows%swing)
    call end_object(json)
  end subroutine put_blows

  !> How far the run is off, where it estimates that.
  subroutine put_error(json, summary)
    type(json_t), intent(inout) :: json
    type(summary_t), intent(in) :: summary

    if (.not. allocated(summary%off)) then
      call put_null(json, 'error')
      return
    end if
    call begin_object(json, 'error')
    call put(json, 'share', summary%off)
    if (summary%aim > 0) then
      call put(json, 'asked', summary%aim)
    else
      call put_null(json, 'asked')
    end if
    call end_object(json)
  end subroutine put_error

  !> A place.
  subroutine put_position(json, position)
    type(json_t), intent(inout) :: json
    real(dp), intent(in) :: position(2)

    call put_pair(json, 'position', position)
  end subroutine put_position

  !> Two numbers.
  subroutine put_pair(json, name, pair)
    type(json_t), intent(inout) :: json
    character(len=*), intent(in) :: name
    real(dp), intent(in) :: pair(2)

    call begin_list(json, name)
    call put(json, '', pair(1))
    call put(json, '', pair(2))
    call end_list(json)
  end subroutine put_pair

  !> Costs of the phases.
  subroutine put_cost(json, cost)
    type(json_t), intent(inout) :: json
    type(cost_t), intent(in) :: cost(:)
    integer :: i

    call begin_object(json, 'cost')
    do i = 1, size(cost)
      call begin_object(json, trim(cost(i)%phase))
      call put(json, 'calls', cost(i)%calls)
      call put(json, 'wall_seconds', cost(i)%wall)
      call put(json, 'processor_seconds', cost(i)%processor)
      call put(json, 'share', cost(i)%share)
      call end_object(json)
    end do
    call end_object(json)
  end subroutine put_cost

end module scree_summary_words
