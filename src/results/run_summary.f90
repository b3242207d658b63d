!> Summary of a run, gathered in its steps. Every number is one of the results, too.
module scree_run_summary
  use scree_bearings, only: blow_t
  use scree_contacts, only: blocks_of, contact_t
  use scree_deviation, only: share_off
  use scree_effects, only: supports_move
  use scree_energy, only: dissipated_energy, stored_energy
  use scree_equilibrium, only: balance_t, tolerance_of
  use scree_joint_rules, only: joints_have_stiffness, joints_soften
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_regions, only: first_vertex_of, last_vertex_of
  use scree_run_records, only: displacement_of_vertices, velocity_of_vertices
  use scree_sleep, only: bodies_at_rest
  use scree_state, only: books_t, state_t, time_of_run
  use scree_step_control, only: is_past_peak
  use scree_step_try, only: cut_reasons
  use scree_time_stepper, only: step_report_t
  implicit none
  private
  public :: add_step, begin_stage, begin_summary, change_of_area, count_moving, end_stage, lost_otherwise, share_lost, &
            share_of_blows, stage_ending_t, sum_up, summary_t, vertex_most_t

  !> Fraction of its weight, and of sqrt(g size), below which a body counts as at rest.
  real(dp), parameter :: resting = 1e-3_dp

  !> The vertex at which something is largest.
  type :: vertex_most_t
    real(dp) :: value = 0.0_dp           !! length, or length/time
    integer :: block = 0                 !! from 1; 0: there is none
    real(dp) :: position(2) = 0.0_dp     !! length
  end type vertex_most_t

  !> The deepest overlap of a contact at the end of any step.
  type :: overlap_most_t
    real(dp) :: value = 0.0_dp           !! length
    real(dp) :: time = 0.0_dp
    integer :: blocks(2) = 0             !! of the vertex and of the edge, from 1; 0: there was none
    real(dp) :: position(2) = 0.0_dp     !! of the vertex, length
  end type overlap_most_t

  !> Summary of a stage of a run.
  type :: stage_ending_t
    character(len=:), allocatable :: name    !! with its number
    character(len=:), allocatable :: verdict !! in a word
    logical :: static = .false.
    real(dp) :: from = 0.0_dp, to = 0.0_dp   !! time of the run
    integer :: steps = 0                     !! of the stage
    real(dp) :: given = 0.0_dp               !! energy that the change to it gave; below 0: took
  end type stage_ending_t

  !> Summary of a run; after a restart, of the part since then.
  type :: summary_t
    real(dp) :: extent = 0.0_dp          !! of the model, length
    real(dp) :: from = 0.0_dp, reached = 0.0_dp !! time
    real(dp) :: asked = 0.0_dp           !! end, time; huge: none, a number of steps alone
    integer :: planned = -1              !! steps of the size that was asked for, -1: it is not the deck's to say
    integer :: taken = 0, cut = 0        !! steps accepted, tries rejected
    integer :: cuts(size(cut_reasons)) = 0 !! these, for each reason
    integer :: solves = 0
    type(vertex_most_t) :: displacement  !! since the start, at the end
    type(vertex_most_t) :: speed         !! at the end
    logical, allocatable :: at_rest      !! not allocated: there is no weight to tell by, or no speed, as in a static run
    type(balance_t), allocatable :: balance !! of a static run, after its last step
    real(dp) :: tolerance = 0.0_dp       !! share out of balance that counts as equilibrium
    logical :: touches = .false.         !! the scene has contact
    type(overlap_most_t) :: overlap
    type(blow_t) :: blows                !! of all steps, of what springs give back by chance; the shortest swing
    real(dp), allocatable :: off         !! estimated error over the displacement, where the run estimates it
    real(dp), allocatable :: support_force(:) !! where supports move: in the last step and at most, force/length
    logical :: past_peak = .false.       !! it fell so far that the run ended
    real(dp) :: aim = 0.0_dp             !! `step.accuracy`, what it may be off by; 0: its steps do not go by that
    real(dp) :: area = 0.0_dp            !! of all blocks, length^2
    real(dp) :: work = 0.0_dp            !! of loads, ground and supports, force length per unit thickness as all energies
    real(dp) :: fallen = 0.0_dp          !! most that the weights have given
    real(dp) :: friction = 0.0_dp, damping = 0.0_dp, yield = 0.0_dp, fracture = 0.0_dp, asleep = 0.0_dp, dissipated = 0.0_dp
    logical :: has_bolts = .false.       !! the scene has
    logical :: fractures = .false.       !! it has bonds that soften, or cracks that may grow
    logical :: may_leave = .false.       !! blocks may leave its scene
    logical :: may_swing = .false.       !! it has bolts, or joints with a stiffness of their own
    logical :: is_static = .false.       !! the run, or its last stage: its steps begin at rest
    type(stage_ending_t), allocatable :: stage(:) !! of a run of several those that it was in
    real(dp) :: staged = 0.0_dp          !! energy that the changes from stage to stage gave; below 0: took
    real(dp) :: given = 0.0_dp           !! kinetic and strain energy at the start, fallen, and absolute work
    type(books_t), private :: books_from
    real(dp), private :: area_from = 0.0_dp, absolute_work = 0.0_dp
    real(dp), private :: height_from = 0.0_dp !! energy of the weights, from which they fall
    real(dp), private :: fall = 0.0_dp        !! what they have given since then
    real(dp), private :: ramped = 0.0_dp !! work of what lets them grow, from there
    real(dp), private :: staged_from = 0.0_dp !! `staged` before the change to the stage
  end type summary_t

contains

  !> Begins with the state that the run begins or goes on with.
  subroutine begin_summary(n_stages, model, cache, state, summary)
    integer, intent(in) :: n_stages
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(summary_t), intent(out) :: summary
    real(dp) :: planned

    summary%extent = model%extent
    summary%from = time_of_run(state)
    summary%books_from = state%books
    summary%height_from = state%books%gravity
    summary%staged_from = state%books%staged
    if (n_stages > 1) allocate (summary%stage(0))
    summary%area_from = area_of(cache)
    summary%touches = allocated(model%effects%contact)
    summary%tolerance = tolerance_of(model%settings)
    summary%has_bolts = allocated(model%effects%bolt)
    summary%may_swing = summary%has_bolts
    summary%may_leave = allocated(model%settings%scene_rectangle)
    summary%fractures = model%settings%cracks_may_grow()
    if (summary%touches) summary%fractures = summary%fractures .or. joints_soften(model%effects%contact)
    if (summary%touches) summary%may_swing = summary%may_swing .or. joints_have_stiffness(model%effects%contact)
    summary%asked = huge(summary%asked)
    if (n_stages > 1) return
    associate (s => model%settings)
      summary%asked = s%end_time
      if (s%chooses_step .or. s%balance > 0) return
      planned = (s%end_time - state%time)/s%step_size
      summary%planned = ceiling(min(real(s%most_steps - state%step, dp), planned*(1 - 1e-9_dp)))
    end associate
  end subroutine begin_summary

  !> Notes what a stage came to where it ends.
  pure subroutine end_stage(name, verdict, model, state, summary)
    character(len=*), intent(in) :: name, verdict
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(summary_t), intent(inout) :: summary

    summary%stage = [summary%stage, stage_ending_t(name, verdict, model%effects%is_static(), state%stage%begins, &
                                                   time_of_run(state), state%step, state%books%staged - summary%staged_from)]
    summary%staged_from = state%books%staged
  end subroutine end_stage

  !> Goes on with a stage at its first state.
  pure subroutine begin_stage(model, state, summary)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(summary_t), intent(inout) :: summary

    summary%height_from = state%books%gravity + summary%fall
    summary%ramped = 0.0_dp
    summary%tolerance = tolerance_of(model%settings)
    if (allocated(summary%balance)) deallocate (summary%balance)
  end subroutine begin_stage

  !> Number of blocks that move: in a static step those out of balance, else those that are not at rest. It is -1 where there is no
  !> weight to tell rest by.
  pure integer function count_moving(model, cache, state, balance) result(moving)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state       !! at the end of a step
    type(balance_t), intent(in), optional :: balance !! of a static step

    moving = -1
    if (present(balance)) then
      moving = balance%others + merge(1, 0, balance%share > tolerance_of(model%settings))
    else if (allocated(model%effects%gravity)) then
      moving = count(.not. bodies_at_rest(model, cache, state, resting))
    end if
  end function count_moving

  !> Adds a step that was accepted and written.
  subroutine add_step(model, state, report, summary)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state       !! at its end
    type(step_report_t), intent(in) :: report
    type(summary_t), intent(inout) :: summary

    summary%taken = summary%taken + 1
    summary%cut = summary%cut + report%rejected
    summary%cuts = summary%cuts + report%cuts
    summary%solves = summary%solves + report%solves
    summary%absolute_work = summary%absolute_work + abs(report%work)
    if (allocated(report%balance)) summary%balance = report%balance
    summary%blows = blow_t(summary%blows%energy + report%blow%energy, min(summary%blows%swing, report%blow%swing))
    summary%ramped = summary%ramped + report%ramp
    summary%fall = summary%height_from + summary%ramped - state%books%gravity
    summary%fallen = max(summary%fallen, summary%fall)
    if (state%contacts%penetration > summary%overlap%value) &
      call take_overlap(model, state, state%contacts%contact, summary%overlap)
    if (allocated(state%sleep)) then
      if (state%sleep%penetration > summary%overlap%value) call take_overlap(model, state, state%sleep%contact, summary%overlap)
    end if
  end subroutine add_step

  !> Updates the deepest overlap, by contacts of a step, also those of sleeping bodies.
  subroutine take_overlap(model, state, contact, overlap)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(contact_t), intent(in) :: contact(:)
    type(overlap_most_t), intent(inout) :: overlap
    type(contact_t) :: deepest

    deepest = contact(maxloc(contact%overlap, 1))
    overlap%value = deepest%overlap
    overlap%time = time_of_run(state)
    associate (entrance => deepest%entrance(deepest%active), outlines => model%outlines)
      overlap%blocks = blocks_of(outlines, entrance)
      overlap%position = state%vertex(:, outlines%start(entrance%vertex)) + model%origin
    end associate
  end subroutine take_overlap

  !> Sums up at the end, wherever that is.
  subroutine sum_up(model, cache, state, summary)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(summary_t), intent(inout) :: summary

    summary%reached = time_of_run(state)
    summary%displacement = most_of(model, state, displacement_of_vertices(model, state))
    summary%speed = most_of(model, state, velocity_of_vertices(model, cache, state))
    if (allocated(model%effects%gravity) .and. .not. model%effects%is_static()) &
      summary%at_rest = count_moving(model, cache, state) == 0
    if (allocated(state%deviation)) summary%off = share_off(model, cache, state%deviation)
    summary%aim = model%settings%aim
    if (supports_move(model) .and. .not. model%settings%takes_small_steps()) &
      summary%support_force = [state%pace%support_force, state%pace%most_force]
    summary%past_peak = is_past_peak(model%settings, state)
    summary%is_static = model%effects%is_static()
    summary%area = area_of(cache)
    associate (now => state%books, from => summary%books_from)
      summary%work = now%work - from%work
      summary%friction = now%friction - from%friction
      summary%damping = now%damping - from%damping
      summary%yield = now%yield - from%yield
      summary%fracture = now%fracture - from%fracture
      summary%asleep = now%asleep - from%asleep
      summary%staged = now%staged - from%staged
      summary%dissipated = dissipated_energy(now) - dissipated_energy(from)
      summary%given = stored_energy(from) - from%gravity + summary%fallen + summary%absolute_work
    end associate
  end subroutine sum_up

  !> Energy that went elsewhere than into friction, damping, bolts, fracture and sleep: by the integrator, in impacts, with bonds;
  !> below 0 it was made.
  pure real(dp) function lost_otherwise(summary) result(lost)
    type(summary_t), intent(in) :: summary

    lost = summary%dissipated - summary%friction - summary%damping - summary%yield - summary%fracture - summary%asleep
  end function lost_otherwise

  !> The same over the energy supplied; 0 where none was.
  pure real(dp) function share_lost(summary) result(share)
    type(summary_t), intent(in) :: summary

    share = 0.0_dp
    if (summary%given > 0) share = lost_otherwise(summary)/summary%given
  end function share_lost

  !> Energy of what struck in steps that do not resolve it, over what was given; 0 where nothing was.
  pure real(dp) function share_of_blows(summary) result(share)
    type(summary_t), intent(in) :: summary

    share = 0.0_dp
    if (summary%given > 0) share = summary%blows%energy/summary%given
  end function share_of_blows

  !> Area of all blocks at the end over that at the beginning, less 1.
  pure real(dp) function change_of_area(summary) result(change)
    type(summary_t), intent(in) :: summary

    change = (summary%area - summary%area_from)/summary%area_from
  end function change_of_area

  !> Area of all blocks, length^2.
  pure real(dp) function area_of(cache)
    type(cache_t), intent(in) :: cache

    area_of = sum(cache%element%kinematics%area)
  end function area_of

  !> Where a vector at all vertices is largest.
  pure type(vertex_most_t) function most_of(model, state, vector) result(most)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(dp), intent(in) :: vector(:, :)     !! (2, n_vertices)
    integer :: e, k

    do e = 1, model%n_elements
      if (.not. model%present(model%elements%block(e))) cycle
      do k = first_vertex_of(model%elements%shape, e), last_vertex_of(model%elements%shape, e)
        if (most%block > 0 .and. norm2(vector(:, k)) <= most%value) cycle
        most = vertex_most_t(norm2(vector(:, k)), model%elements%block(e), state%vertex(:, k) + model%origin)
      end do
    end do
  end function most_of

end module scree_run_summary
