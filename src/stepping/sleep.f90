!> Islands of bodies at rest fall asleep: they are left as they are until something may change that.
!>
!> An island is a set of bodies that contacts of the step and bolts join, cut at bodies that cannot move. It falls asleep when all
!> of its bodies have been near equilibrium for some time. Then its remaining motion is set to 0 and booked, its contacts are laid
!> aside, and its bodies count among those that cannot move. It wakes before a step in which a body that is awake may reach one of
!> its bodies. It also wakes where a load, the ground or a support of one of them has changed since it fell asleep. So a sleeping
!> body touches nothing that moves.
!>
!> The bounds of rest are in doc/theory/equilibrium.md, eq-near-equilibrium.
module scree_sleep
  use scree_cache, only: note_fixed
  use scree_contacts, only: blocks_of, contact_search_t, contact_t, count_states, outlines_t
  use scree_disturbance, only: disturbed
  use scree_effects, only: is_held_without_contact
  use scree_energy, only: close_books
  use scree_equations, only: forget_groups
  use scree_errors, only: error_t
  use scree_inertia, only: kinetic_energy
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_sets, only: root_of, unite
  use scree_sorting, only: columns
  use scree_state, only: state_t
  use scree_step, only: advance
  use scree_system, only: last_of_block, unknowns_at_rest, values_of
  use scree_time_stepper, only: step_report_t
  use scree_timers, only: begin_phase, phase_sleep
  implicit none
  private
  public :: advance_awake, bodies_at_rest, wake_all

  !> Steps from one look at what is near equilibrium to the next, and looks in a row that find it so for an island to fall asleep.
  integer, parameter :: steps_apart = 8, quiet_looks = 3

contains

  !> Takes `state` to the end of one step, as `advance` does, of what is awake; of all, where the scene lets none sleep.
  !>
  !> Errors: as of `advance`.
  subroutine advance_awake(model, dt, awake, cache, state, report, error)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: dt                             !! size to try, time
    type(model_t), allocatable, intent(inout) :: awake     !! the model in which what sleeps cannot move; made where it is not
    type(cache_t), intent(inout) :: cache                  !! of `state` and that model
    type(state_t), intent(inout) :: state
    type(step_report_t), intent(out) :: report
    type(error_t), allocatable, intent(out) :: error
    integer :: before

    if (.not. allocated(state%sleep)) then
      call advance(model, dt, cache, state, report, error)
      return
    end if
    call begin_phase(cache%timers, phase_sleep)
    before = state%step
    if (.not. allocated(awake)) then
      awake = model
      call leave_out_sleepers(model, awake, cache, state)
    end if
    if (size(awake%free_block) < size(model%free_block)) call wake(model, disturbed(model, dt, state), awake, cache, state)
    do
      call advance(awake, dt, cache, state, report, error)
      if (allocated(error)) return
      if (.not. allocated(report%reached)) exit
      call wake(model, report%reached, awake, cache, state)
    end do
    if (state%step == before) return ! a signal came
    call begin_phase(cache%timers, phase_sleep)
    if (modulo(state%step, steps_apart) == 0) call put_to_sleep(model, awake, cache, state)
  end subroutine advance_awake

  !> Takes what sleeps out of what can move, and makes anew what was kept of that.
  subroutine leave_out_sleepers(model, awake, cache, state)
    type(model_t), intent(in) :: model
    type(model_t), intent(inout) :: awake
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(inout) :: state
    logical :: rests(model%n_blocks), asleep(model%n_blocks)

    asleep = state%sleep%island > 0
    associate (elements => model%elements, free => model%elements%free, inside => model%outlines%inside)
      awake%elements%free = pack(free, .not. asleep(elements%block(free)))
      awake%free_block = pack(model%free_block, .not. asleep(model%free_block))
      awake%points%free = pack(model%points%free, .not. asleep(elements%block(model%points%element(model%points%free))))
      rests = .true.
      rests(awake%free_block) = .false.
      awake%at_rest = unknowns_at_rest(model, rests)
      awake%outlines%fixed = model%outlines%fixed .or. asleep(model%outlines%block)
      awake%outlines%inside = columns(inside, .not. (awake%outlines%fixed(inside(1, :)) .and. awake%outlines%fixed(inside(2, :))))
    end associate
    cache%search = contact_search_t()
    call forget_groups(cache%equations)
    call note_fixed(awake, state, cache)
  end subroutine leave_out_sleepers

  !> Wakes the islands of some blocks.
  subroutine wake(model, block, awake, cache, state)
    type(model_t), intent(in) :: model
    integer, intent(in) :: block(:)          !! that sleep
    type(model_t), intent(inout) :: awake
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(inout) :: state
    logical :: wakes(0:model%n_blocks)       !! islands

    if (size(block) == 0) return
    wakes = .false.
    wakes(state%sleep%island(block)) = .true.
    call wake_islands(model, wakes, state)
    call leave_out_sleepers(model, awake, cache, state)
  end subroutine wake

  !> Wakes all blocks, as a change of strength may move any of them.
  pure subroutine wake_all(model, state)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    logical :: wakes(0:model%n_blocks)       !! islands

    if (.not. allocated(state%sleep)) return
    wakes = .true.
    wakes(0) = .false.
    if (any(state%sleep%island > 0)) call wake_islands(model, wakes, state)
  end subroutine wake_all

  !> Has the blocks of islands take part again, with their contacts.
  pure subroutine wake_islands(model, wakes, state)
    type(model_t), intent(in) :: model
    logical, intent(in) :: wakes(0:)         !! islands, by their first block; 0: what is awake
    type(state_t), intent(inout) :: state

    associate (sleep => state%sleep, memory => state%contacts)
      call hand_over(model%outlines, wakes(sleep%island), sleep%contact, sleep%inside, memory%contact, memory%inside)
      where (wakes(sleep%island))
        sleep%island = 0
        sleep%quiet = 0
      end where
    end associate
    call sum_up_contacts(state)
  end subroutine wake_islands

  !> Puts the islands to sleep all of whose bodies have been near equilibrium for some time, and books their motion.
  subroutine put_to_sleep(model, awake, cache, state)
    type(model_t), intent(in) :: model
    type(model_t), intent(inout) :: awake
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(inout) :: state    !! at the end of a step
    integer :: island(model%n_blocks), i, k
    logical :: sleeps(0:model%n_blocks)      !! islands that fall asleep, by their first block
    logical, allocatable :: moves(:)
    real(dp) :: motion

    if (size(state%contacts%contact) == 0 .and. .not. is_held_without_contact(awake)) then ! all that is awake falls
      state%sleep%quiet(awake%free_block) = 0
      return
    end if
    call count_quiet_looks(awake, cache, state)
    if (.not. any(state%sleep%quiet(awake%free_block) >= quiet_looks)) return
    island = islands_of(model, state)
    sleeps = .false.
    sleeps(island(awake%free_block)) = .true.
    do k = 1, size(awake%free_block)
      associate (b => awake%free_block(k))
        if (state%sleep%quiet(b) < quiet_looks) sleeps(island(b)) = .false.
      end associate
    end do
    if (.not. any(sleeps)) return
    do k = 1, size(awake%free_block)
      associate (b => awake%free_block(k), sleep => state%sleep)
        if (.not. sleeps(island(b))) cycle
        sleep%island(b) = island(b)
        sleep%quiet(b) = 0
        sleep%since(b) = state%time
      end associate
    end do
    do k = 1, size(awake%elements%free)
      associate (e => awake%elements%free(k))
        if (state%sleep%island(model%elements%block(e)) == 0) cycle
        state%velocity(model%elements%unknown(:, e)) = 0.0_dp
        state%acceleration(model%elements%unknown(:, e)) = 0.0_dp
      end associate
    end do
    associate (sleep => state%sleep, memory => state%contacts)
      call hand_over(model%outlines, sleep%island > 0, memory%contact, memory%inside, sleep%contact, sleep%inside)
      moves = [(any(sleep%island(model%elements%block(state%pair(:, i))) > 0), i=1, size(state%pair, 2))]
      state%pair = columns(state%pair, .not. moves)
    end associate
    call sum_up_contacts(state)
    call leave_out_sleepers(model, awake, cache, state)
    motion = state%books%kinetic + state%books%integrator
    call close_books(awake, cache, state)
    state%books%asleep = state%books%asleep + motion - (state%books%kinetic + state%books%integrator)
  end subroutine put_to_sleep

  !> Hands contacts, and vertices that are inside, over to other lists, behind what those have.
  pure subroutine hand_over(outlines, moves, contact, inside, to_contact, to_inside)
    type(outlines_t), intent(in) :: outlines
    logical, intent(in) :: moves(:)          !! (n_blocks) of which all is handed over
    type(contact_t), allocatable, intent(inout) :: contact(:), to_contact(:)
    integer, allocatable, intent(inout) :: inside(:, :), to_inside(:, :) !! (2, n) vertices and edges
    logical :: goes(size(contact)), leaves(size(inside, 2))
    integer :: i

    goes = [(any(moves(blocks_of(outlines, contact(i)%entrance(1)))), i=1, size(contact))]
    leaves = [(any(moves(outlines%block(inside(:, i)))), i=1, size(inside, 2))]
    to_contact = [to_contact, pack(contact, goes)]
    contact = pack(contact, .not. goes)
    to_inside = reshape([to_inside, columns(inside, leaves)], [2, size(to_inside, 2) + count(leaves)])
    inside = columns(inside, .not. leaves)
  end subroutine hand_over

  !> Counts the looks in a row at which bodies that are awake were near equilibrium.
  subroutine count_quiet_looks(awake, cache, state)
    type(model_t), intent(in) :: awake
    type(cache_t), intent(in) :: cache
    type(state_t), intent(inout) :: state
    logical :: rests(awake%n_blocks)
    integer :: k

    rests = bodies_at_rest(awake, cache, state, awake%effects%sleep)
    do k = 1, size(awake%free_block)
      associate (quiet => state%sleep%quiet(awake%free_block(k)))
        quiet = merge(min(quiet + 1, quiet_looks), 0, rests(awake%free_block(k)))
      end associate
    end do
  end subroutine count_quiet_looks

  !> Bodies near equilibrium: with s the fraction asked for, their speed below s sqrt(g l) and the force out of balance below s
  !> times their weight, both as root mean squares over the body,
  !>
  !>     v^T M v < s^2 W l,      m a^T M a < (s W)^2,
  !>
  !> W = m g the weight, l the root of the area. A body without weight never is; one that cannot move always. v and a are those at
  !> the end of a step, of which it hands on a fraction.
  pure function bodies_at_rest(model, cache, state, share) result(rests)
    type(model_t), intent(in) :: model      !! with weight
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    real(dp), intent(in) :: share
    logical :: rests(model%n_blocks)
    real(dp) :: area, mass, speed, unbalanced, weight
    integer :: first, k, last

    rests = .true.
    associate (free => model%elements%free, block => model%elements%block, carried => model%effects%carried)
      last = 0
      do while (last < size(free)) ! of a body
        first = last + 1
        area = 0.0_dp
        mass = 0.0_dp
        speed = 0.0_dp
        weight = 0.0_dp
        last = last_of_block(model%elements, first)
        do k = first, last
          associate (e => free(k), own => cache%element(free(k)))
            area = area + own%kinematics%area
            mass = mass + own%mass
            weight = weight + abs(own%mass_ratio*model%effects%gravity%weight(e))
            speed = speed + 2*kinetic_energy(own%mass_matrix, values_of(model%elements, e, state%velocity))
          end associate
        end do
        rests(block(free(first))) = speed < (carried*share)**2*weight*sqrt(area)
        if (.not. rests(block(free(first)))) cycle
        unbalanced = 0.0_dp
        do k = first, last
          unbalanced = unbalanced + 2*kinetic_energy(cache%element(free(k))%mass_matrix, &
                                                     values_of(model%elements, free(k), state%acceleration))
        end do
        rests(block(free(first))) = mass*unbalanced < (carried*share*weight)**2
      end do
    end associate
  end function bodies_at_rest

  !> The island of each block: the first block of those that contacts and bolts join it to, itself included.
  pure function islands_of(model, state) result(island)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer :: island(model%n_blocks)
    logical :: can_move(model%n_blocks)
    integer :: b, i, joined(2)

    island = [(b, b=1, model%n_blocks)]
    do i = 1, size(state%contacts%contact)
      associate (entrance => state%contacts%contact(i)%entrance(1))
        if (model%outlines%fixed(entrance%vertex) .or. model%outlines%fixed(entrance%edge)) cycle
      end associate
      joined = blocks_of(model%outlines, state%contacts%contact(i)%entrance(1))
      call unite(island, joined(1), joined(2))
    end do
    if (allocated(model%effects%bolt)) then
      can_move = .false.
      can_move(model%free_block) = .true.
      do i = 1, size(model%effects%bolt%pair, 2)
        joined = model%elements%block(model%effects%bolt%pair(:, i))
        if (all(can_move(joined))) call unite(island, joined(1), joined(2))
      end do
    end if
    island = [(root_of(island, b), b=1, model%n_blocks)]
  end function islands_of

  !> Counts the contacts of what is awake and of what sleeps, finds how much they overlap, and books the energy of their springs.
  pure subroutine sum_up_contacts(state)
    type(state_t), intent(inout) :: state

    state%contacts%count = count_states(state%contacts%contact)
    state%sleep%count = count_states(state%sleep%contact)
    state%sleep%penetration = max(0.0_dp, maxval(state%sleep%contact%overlap))
    associate (memory => state%contacts)
      memory%pressed = max(0.0_dp, maxval(memory%contact%pressed))
      memory%penetration = max(0.0_dp, maxval(memory%contact%overlap))
      if (size(memory%contact) == 0) memory%gap = 0.0_dp ! as after a step without contacts
    end associate
    state%books%contact_springs = sum(state%contacts%contact%energy)
    state%books%sleeping_springs = sum(state%sleep%contact%energy)
  end subroutine sum_up_contacts

end module scree_sleep
