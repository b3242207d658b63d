!> Checkpoints: all that a run goes on from, in the results file with a frame (doc/running.md).
!>
!> That is the state, and what the watch has seen. `visit_run` alone says what it is made of: the same calls write it and read it.
!> A component of those types that it does not name is found by `tests/results/test_restart.py`.
module scree_checkpoint
  use scree_archive, only: archive_t
  use scree_contacts, only: contact_memory_t, contact_t, entrance_t
  use scree_errors, only: error_t
  use scree_hold, only: hold_t
  use scree_kinds, only: dp
  use scree_factored, only: factored_t
  use scree_results_file, only: declare_series, put_series, results_t, rows_of_series, store_words
  use scree_state, only: bolt_memory_t, books_t, cracks_t, deviation_t, reference_t, settling_t, sleep_t, stage_clock_t, state_t, &
                         step_of_run
  use scree_watch, only: watch_t
  implicit none
  private
  public :: checkpoints_t, components_of, declare_checkpoints, put_checkpoint, take_beginning, take_checkpoint

  !> Handles of the series, a row a checkpoint each but for the numbers.
  type :: checkpoints_t
    integer :: frame = 0, end = 0, rows = 0, numbers = 0
    integer :: n_series = 0   !! those before
    integer :: step = -1      !! of the last checkpoint
  end type checkpoints_t

contains

  !> Makes the series of the checkpoints, after all others.
  subroutine declare_checkpoints(results, state, watch, checkpoints, error)
    type(results_t), intent(inout) :: results
    type(state_t), intent(in) :: state           !! one that is as large as later ones, about
    type(watch_t), intent(in) :: watch
    type(checkpoints_t), intent(out) :: checkpoints
    type(error_t), allocatable, intent(out) :: error
    type(archive_t) :: archive

    call list_run(state, watch, archive)
    checkpoints%n_series = results%n_series
    call declare_series(results, '/checkpoint/frame', [integer ::], '1', 'frame that it goes with, from 0', checkpoints%frame, &
                        error, whole=.true., per_frame=.true.)
    call declare_series(results, '/checkpoint/end', [integer ::], '1', 'numbers up to its end', checkpoints%end, error, &
                        whole=.true., per_frame=.true.)
    call declare_series(results, '/checkpoint/rows', [checkpoints%n_series], '1', 'rows of each series then', checkpoints%rows, &
                        error, whole=.true., per_frame=.true.)
    call declare_series(results, '/checkpoint/numbers', [integer ::], '', 'all that the run goes on from', checkpoints%numbers, &
                        error, expected_rows=archive%n)
    if (allocated(error)) return
    call store_words(results, '/checkpoint/components', [archive%names], error)
  end subroutine declare_checkpoints

  !> Adds a checkpoint of the present state; it waits in memory with the rows of the series. Errors: a number that is not finite.
  subroutine put_checkpoint(results, checkpoints, frame, state, watch, error)
    type(results_t), intent(inout) :: results
    type(checkpoints_t), intent(inout) :: checkpoints
    integer, intent(in) :: frame                 !! from 0, of the same state
    type(state_t), intent(in) :: state
    type(watch_t), intent(in) :: watch
    type(error_t), allocatable, intent(out) :: error
    type(archive_t) :: archive
    integer :: i

    call list_run(state, watch, archive)
    call put_series(results, checkpoints%numbers, archive%number(:archive%n), error)
    if (allocated(error)) return
    call put_series(results, checkpoints%frame, [real(frame, dp)], error)
    call put_series(results, checkpoints%end, [real(rows_of_series(results, checkpoints%numbers), dp)], error)
    call put_series(results, checkpoints%rows, [(real(rows_of_series(results, i), dp), i=1, checkpoints%n_series)], error)
    checkpoints%step = step_of_run(state)
  end subroutine put_checkpoint

  !> Takes state and watch from the numbers of a checkpoint. Whether they are as many as those ask for.
  logical function take_checkpoint(numbers, state, watch) result(whole)
    real(dp), intent(in) :: numbers(:)
    type(state_t), intent(inout) :: state
    type(watch_t), intent(inout) :: watch
    type(archive_t) :: archive

    archive%reading = .true.
    archive%number = numbers
    call visit_run(archive, state, watch)
    whole = archive%n == size(numbers) .and. .not. archive%damaged
  end function take_checkpoint

  !> What of a checkpoint makes the model: its stage, how cracks have grown, and which blocks have left. Its numbers begin with
  !> them.
  subroutine take_beginning(numbers, stage, cracks, departed)
    real(dp), intent(in) :: numbers(:)
    type(stage_clock_t), intent(out) :: stage
    type(cracks_t), allocatable, intent(out) :: cracks
    integer, allocatable, intent(out) :: departed(:)
    type(archive_t) :: archive

    archive%reading = .true.
    archive%number = numbers
    call visit_beginning(archive, stage, cracks, departed)
  end subroutine take_beginning

  !> Names of all components of a checkpoint, in their order: what this program writes and reads.
  function components_of(state, watch) result(names)
    type(state_t), intent(in) :: state
    type(watch_t), intent(in) :: watch
    character(len=:), allocatable :: names
    type(archive_t) :: archive

    call list_run(state, watch, archive)
    names = archive%names
  end function components_of

  !> Lists state and watch.
  subroutine list_run(state, watch, archive)
    type(state_t), intent(in) :: state
    type(watch_t), intent(in) :: watch
    type(archive_t), intent(out) :: archive
    type(state_t) :: state_now
    type(watch_t) :: watch_now

    state_now = state
    watch_now = watch
    call visit_run(archive, state_now, watch_now)
  end subroutine list_run

  !> Lists all that a run goes on from, or takes it back.
  subroutine visit_run(archive, state, watch)
    type(archive_t), intent(inout) :: archive
    type(state_t), intent(inout) :: state
    type(watch_t), intent(inout) :: watch

    call visit_beginning(archive, state%stage, state%cracks, state%departed)
    call archive%part('time', state%time)
    call archive%part('step', state%step)
    call archive%part('pace%size', state%pace%size)
    call archive%part('pace%last', state%pace%last)
    call archive%part('pace%bound', state%pace%bound)
    call archive%part('pace%pseudo', state%pace%pseudo)
    call archive%part('pace%small', state%pace%small)
    call archive%part('pace%easy', state%pace%easy)
    call archive%part('pace%frames', state%pace%frames)
    call archive%part('pace%support_force', state%pace%support_force)
    call archive%part('pace%most_force', state%pace%most_force)
    call archive%array('vertex', state%vertex)
    call archive%array('point', state%point)
    call archive%array('home', state%home)
    call archive%array('static_force', state%static_force)
    call visit_reference(archive, state%reference)
    call archive%array('cover', state%cover)
    call archive%array('velocity', state%velocity)
    call archive%array('acceleration', state%acceleration)
    call archive%array('stress', state%stress)
    call archive%array('deformation', state%deformation)
    call archive%array('rotation', state%rotation)
    call archive%array('green', state%green)
    call archive%array('tied', state%tied)
    call archive%array('pair', state%pair)
    call visit_factored(archive, state%factored)
    call visit_contacts(archive, state%contacts)
    call visit_bolts(archive, state%bolts)
    call visit_sleep(archive, state%sleep)
    call visit_settling(archive, state%settling)
    call visit_deviation(archive, state%deviation)
    call visit_hold(archive, state%hold)
    call visit_books(archive, state%books)
    call archive%part('watch%energy', watch%energy)
    call archive%part('watch%scale', watch%scale)
    call archive%part('watch%height', watch%height)
    call archive%part('watch%given', watch%given)
    call archive%part('watch%fallen', watch%fallen)
    call archive%part('watch%least', watch%least)
    call archive%part('watch%area_warned', watch%area_warned)
    call archive%part('watch%energy_warned', watch%energy_warned)
    call archive%part('watch%impact_warned', watch%impact_warned)
    call archive%array('watch%soft', watch%soft)
    call archive%array('watch%grown', watch%grown)
  end subroutine visit_run

  !> The matrices whose factors are kept, one after the other: how many unknowns and entries each has, then these of all.
  subroutine visit_factored(archive, factored)
    type(archive_t), intent(inout) :: archive
    type(factored_t), allocatable, intent(inout) :: factored(:)
    type(factored_t) :: all_of_them
    integer, allocatable :: length(:, :), spent(:)
    integer :: i, j, k

    if (.not. archive%reading) then
      if (.not. allocated(factored)) allocate (factored(0))
      allocate (length(2, size(factored)))
      do i = 1, size(factored)
        length(:, i) = [size(factored(i)%unknown), -1]
        if (allocated(factored(i)%value)) length(2, i) = size(factored(i)%value)
      end do
      spent = factored%spent
      allocate (all_of_them%unknown(sum(length(1, :))), all_of_them%first(sum(length(1, :) + 1)))
      allocate (all_of_them%row(sum(max(length(2, :), 0))), all_of_them%value(sum(max(length(2, :), 0))))
    end if
    if (.not. archive%reading) call go_through()
    call archive%array('factored', length)
    call archive%array('factored%unknown', all_of_them%unknown)
    call archive%array('factored%first', all_of_them%first)
    call archive%array('factored%row', all_of_them%row)
    call archive%array('factored%value', all_of_them%value)
    call archive%array('factored%spent', spent)
    if (.not. archive%reading .or. archive%damaged) return
    if (allocated(factored)) deallocate (factored)
    allocate (factored(size(spent)))
    call go_through()

  contains

    !> Puts each matrix into the list of all, or takes it from there.
    subroutine go_through()

      j = 0
      k = 0
      do i = 1, size(factored)
        associate (own => factored(i), n => length(1, i), m => length(2, i))
          if (archive%reading) then
            own%spent = spent(i)
            own%unknown = all_of_them%unknown(j + 1:j + n)
            if (m >= 0) own%first = all_of_them%first(j + i:j + i + n)
            if (m >= 0) own%row = all_of_them%row(k + 1:k + m)
            if (m >= 0) own%value = all_of_them%value(k + 1:k + m)
          else
            all_of_them%unknown(j + 1:j + n) = own%unknown
            all_of_them%first(j + i:j + i + n) = 0
            if (m >= 0) all_of_them%first(j + i:j + i + n) = own%first
            if (m >= 0) all_of_them%row(k + 1:k + m) = own%row
            if (m >= 0) all_of_them%value(k + 1:k + m) = own%value
          end if
          j = j + n
          k = k + max(m, 0)
        end associate
      end do
    end subroutine go_through

  end subroutine visit_factored

  !> The books of energy.
  subroutine visit_books(archive, books)
    type(archive_t), intent(inout) :: archive
    type(books_t), intent(inout) :: books

    call archive%part('books%kinetic', books%kinetic)
    call archive%part('books%strain', books%strain)
    call archive%part('books%gravity', books%gravity)
    call archive%part('books%fixed_springs', books%fixed_springs)
    call archive%part('books%contact_springs', books%contact_springs)
    call archive%part('books%sleeping_springs', books%sleeping_springs)
    call archive%part('books%bolts', books%bolts)
    call archive%part('books%integrator', books%integrator)
    call archive%part('books%at_start', books%at_start)
    call archive%part('books%staged', books%staged)
    call archive%part('books%work', books%work)
    call archive%part('books%damping', books%damping)
    call archive%part('books%friction', books%friction)
    call archive%part('books%yield', books%yield)
    call archive%part('books%fracture', books%fracture)
    call archive%part('books%asleep', books%asleep)
    call archive%part('books%momentum', books%momentum)
  end subroutine visit_books

  !> Memory of contacts.
  subroutine visit_contacts(archive, memory)
    type(archive_t), intent(inout) :: archive
    type(contact_memory_t), intent(inout) :: memory

    call archive%array('contacts%inside', memory%inside)
    call archive%part('contacts%stiffness', memory%stiffness)
    call archive%array('contacts%extra_reach', memory%extra_reach)
    call archive%array('contacts%extra_turn', memory%extra_turn)
    call archive%part('contacts%penetration', memory%penetration)
    call archive%part('contacts%pressed', memory%pressed)
    call archive%part('contacts%gap', memory%gap)
    call archive%part('contacts%count', memory%count)
    call archive%part('contacts%broken', memory%broken)
    call visit_list(archive, memory%contact)
  end subroutine visit_contacts

  !> What the model is made with.
  subroutine visit_beginning(archive, stage, cracks, departed)
    type(archive_t), intent(inout) :: archive
    type(stage_clock_t), intent(inout) :: stage
    type(cracks_t), allocatable, intent(inout) :: cracks
    integer, allocatable, intent(inout) :: departed(:)

    call archive%part('stage%number', stage%number)
    call archive%part('stage%steps', stage%steps)
    call archive%part('stage%begins', stage%begins)
    call visit_cracks(archive, cracks)
    call archive%array('departed', departed)
  end subroutine visit_beginning

  !> How cracks have grown, where they have.
  subroutine visit_cracks(archive, cracks)
    type(archive_t), intent(inout) :: archive
    type(cracks_t), allocatable, intent(inout) :: cracks
    type(cracks_t), allocatable :: own

    if (allocated(cracks)) own = cracks
    if (.not. allocated(own)) allocate (own)
    call archive%array('cracks%piece', own%piece)
    call archive%array('cracks%joint', own%joint)
    call archive%array('cracks%tip', own%tip)
    call archive%array('cracks%time', own%time)
    if (archive%reading .and. allocated(own%piece)) call move_alloc(own, cracks)
  end subroutine visit_cracks

  !> Forces between new faces of cracks, where there are any.
  subroutine visit_hold(archive, hold)
    type(archive_t), intent(inout) :: archive
    type(hold_t), allocatable, intent(inout) :: hold
    type(hold_t), allocatable :: own

    if (allocated(hold)) own = hold
    if (.not. allocated(own)) allocate (own)
    call archive%array('hold%force', own%force)
    call archive%array('hold%piece', own%piece)
    call archive%array('hold%tip', own%tip)
    call archive%array('hold%duration', own%duration)
    call archive%array('hold%share', own%share)
    call archive%array('hold%next', own%next)
    if (archive%reading .and. allocated(own%force)) call move_alloc(own, hold)
  end subroutine visit_hold

  !> Memory of bolts, where there are any.
  subroutine visit_bolts(archive, bolts)
    type(archive_t), intent(inout) :: archive
    type(bolt_memory_t), allocatable, intent(inout) :: bolts
    type(bolt_memory_t), allocatable :: own

    if (allocated(bolts)) own = bolts
    if (.not. allocated(own)) allocate (own)
    call archive%array('bolts%rest', own%rest)
    call archive%array('bolts%across', own%across)
    call archive%array('bolts%state', own%state)
    if (archive%reading .and. allocated(own%rest)) call move_alloc(own, bolts)
  end subroutine visit_bolts

  !> Where displacements count from, where a stage counted them anew.
  subroutine visit_reference(archive, reference)
    type(archive_t), intent(inout) :: archive
    type(reference_t), allocatable, intent(inout) :: reference
    type(reference_t), allocatable :: own

    if (allocated(reference)) own = reference
    if (.not. allocated(own)) allocate (own)
    call archive%array('reference%vertex', own%vertex)
    call archive%array('reference%point', own%point)
    if (archive%reading .and. allocated(own%vertex)) call move_alloc(own, reference)
  end subroutine visit_reference

  !> What sleeps. Where nothing may, and a file has something that does, it sleeps on.
  subroutine visit_sleep(archive, sleep)
    type(archive_t), intent(inout) :: archive
    type(sleep_t), allocatable, intent(inout) :: sleep
    type(sleep_t), allocatable :: own

    if (allocated(sleep)) own = sleep
    if (.not. allocated(own)) allocate (own)
    call archive%array('sleep%island', own%island)
    call archive%array('sleep%quiet', own%quiet)
    call archive%array('sleep%since', own%since)
    call archive%array('sleep%inside', own%inside)
    call archive%part('sleep%count', own%count)
    call archive%part('sleep%penetration', own%penetration)
    call visit_list(archive, own%contact)
    if (archive%reading .and. allocated(own%island)) call move_alloc(own, sleep)
  end subroutine visit_sleep

  !> How a static run comes to equilibrium. Where a file has nothing of it, it begins.
  subroutine visit_settling(archive, settling)
    type(archive_t), intent(inout) :: archive
    type(settling_t), allocatable, intent(inout) :: settling
    type(settling_t), allocatable :: own

    if (allocated(settling) .and. .not. archive%reading) own = settling
    if (.not. allocated(own)) allocate (own)
    call archive%part('settling%unbalanced', own%unbalanced)
    call archive%part('settling%steady', own%steady)
    call archive%part('settling%grows', own%grows)
    call archive%part('settling%moving', own%moving)
    call archive%array('settling%loose', own%loose)
    call archive%array('settling%share', own%share)
    call archive%array('settling%way', own%way)
    call archive%array('settling%share_before', own%share_before)
    call archive%array('settling%force_before', own%force_before)
    if (archive%reading .and. allocated(own%share_before) .and. allocated(settling)) call move_alloc(own, settling)
  end subroutine visit_settling

  !> How far the run is off. Where nothing asks for it, and a file has it, it goes on; where a file has none, it begins.
  subroutine visit_deviation(archive, deviation)
    type(archive_t), intent(inout) :: archive
    type(deviation_t), allocatable, intent(inout) :: deviation
    type(deviation_t), allocatable :: own

    if (allocated(deviation) .and. .not. archive%reading) own = deviation
    if (.not. allocated(own)) allocate (own)
    call archive%array('deviation%from', own%from)
    call archive%array('deviation%place', own%place)
    call archive%array('deviation%motion', own%motion)
    call archive%array('deviation%growth', own%growth)
    call archive%array('deviation%impact', own%impact)
    call archive%array('deviation%late', own%late)
    call archive%array('deviation%acceleration', own%acceleration)
    call archive%array('deviation%path_gain', own%path_gain)
    call archive%array('deviation%path_square', own%path_square)
    call archive%array('deviation%mean_velocity', own%mean_velocity)
    call archive%array('deviation%mean_acceleration', own%mean_acceleration)
    call archive%array('deviation%mean_square', own%mean_square)
    call archive%array('deviation%added', own%added)
    call archive%array('deviation%added_size', own%added_size)
    call archive%array('deviation%added_over', own%added_over)
    call archive%array('deviation%smooth', own%smooth)
    call archive%part('deviation%way', own%way)
    call archive%part('deviation%step', own%step)
    call archive%part('deviation%excess', own%excess)
    call archive%part('deviation%rough', own%rough)
    call archive%part('deviation%lost', own%lost)
    if (archive%reading .and. allocated(own%place)) call move_alloc(own, deviation)
  end subroutine visit_deviation

  !> A list of contacts.
  subroutine visit_list(archive, contact)
    type(archive_t), intent(inout) :: archive
    type(contact_t), allocatable, intent(inout) :: contact(:)
    integer :: i, n

    n = -1
    if (allocated(contact)) n = size(contact)
    call archive%part('contacts', n)
    if (archive%reading) archive%damaged = archive%damaged .or. n > size(archive%number) - archive%n
    if (archive%damaged) n = -1
    if (archive%reading .and. allocated(contact)) deallocate (contact)
    if (archive%reading .and. n >= 0) allocate (contact(n))
    if (.not. allocated(contact)) allocate (contact(0)) ! the names are those of any state
    call archive%part('contact%n_entrances', contact%n_entrances)
    call archive%part('contact%active', contact%active)
    call archive%part('contact%covered_line', contact%covered_line)
    call archive%part('contact%stands_for_both', contact%stands_for_both)
    do i = 1, 2
      call archive%part('contact%force', contact%force(i))
    end do
    call archive%part('contact%pressed', contact%pressed)
    call archive%part('contact%slipped', contact%slipped)
    call archive%part('contact%overlap', contact%overlap)
    call archive%part('contact%energy', contact%energy)
    call archive%part('contact%end', contact%end)
    call archive%part('contact%strained', contact%strained)
    call archive%part('contact%inherits', contact%inherits)
    do i = 1, 2
      call visit_entrances(archive, contact%entrance(i))
    end do
    if (n < 0) deallocate (contact)
  end subroutine visit_list

  !> The first entrances of all contacts, or the second.
  subroutine visit_entrances(archive, entrance)
    type(archive_t), intent(inout) :: archive
    type(entrance_t), intent(inout) :: entrance(:)
    integer :: i

    call archive%part('entrance%vertex', entrance%vertex)
    call archive%part('entrance%edge', entrance%edge)
    call archive%part('entrance%joint', entrance%joint)
    call archive%part('entrance%pair', entrance%pair)
    call archive%part('entrance%state', entrance%state)
    call archive%part('entrance%direction', entrance%direction)
    call archive%part('entrance%anchor', entrance%anchor)
    call archive%part('entrance%rest', entrance%rest)
    do i = 1, 2
      call archive%part('entrance%multiplier', entrance%multiplier(i))
      call archive%part('entrance%stiffness', entrance%stiffness(i))
    end do
    call archive%part('entrance%has_joint_stiffness', entrance%has_joint_stiffness)
    call archive%part('entrance%length', entrance%memory%length)
    call archive%part('entrance%pressing', entrance%memory%pressing)
    call archive%part('entrance%bonded', entrance%memory%bonded)
    call archive%part('entrance%damage', entrance%memory%damage)
    call archive%part('entrance%slid', entrance%memory%slid)
    call archive%part('entrance%wear', entrance%memory%wear)
    call archive%part('entrance%displaced', entrance%memory%displaced)
    call archive%part('entrance%farthest', entrance%memory%farthest)
    call archive%part('entrance%dilated', entrance%memory%dilated)
    call archive%part('entrance%held', entrance%held)
    call archive%part('entrance%lagged_friction', entrance%lagged_friction)
  end subroutine visit_entrances

end module scree_checkpoint
