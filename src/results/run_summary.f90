!> What a run came to: gathered in its steps, summed up at its end. Every number is one that the run has for its results too.
module scree_run_summary
  use scree_contacts, only: contact_t
  use scree_energy, only: stored_energy
  use scree_equilibrium, only: balance_t, tolerance_of
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_regions, only: first_vertex_of, last_vertex_of
  use scree_run_records, only: velocity_of_vertices
  use scree_sleep, only: bodies_at_rest
  use scree_state, only: books_t, state_t
  use scree_time_stepper, only: step_report_t
  implicit none
  private
  public :: add_step, begin_summary, change_of_area, lost_otherwise, share_lost, sum_up, summary_t, vertex_most_t

  !> Share of its weight, and of sqrt(g size), below which a body counts as at rest.
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

  !> What a run came to; of one that was gone on with, since then.
  type :: summary_t
    real(dp) :: from = 0.0_dp, reached = 0.0_dp !! time
    real(dp) :: asked = 0.0_dp           !! end, time; huge: none, a number of steps alone
    integer :: planned = -1              !! steps of the size that was asked for, -1: it is not the deck's to say
    integer :: taken = 0, cut = 0        !! steps accepted, tries rejected
    integer :: solves = 0
    type(vertex_most_t) :: displacement  !! since the start, at the end
    type(vertex_most_t) :: speed         !! at the end
    logical, allocatable :: at_rest      !! not allocated: there is no weight to tell by, or no speed, as in a static run
    type(balance_t), allocatable :: balance !! of a static run, after its last step
    real(dp) :: tolerance = 0.0_dp       !! share out of balance that counts as equilibrium
    logical :: touches = .false.         !! the scene has contact
    type(overlap_most_t) :: overlap
    real(dp) :: area = 0.0_dp            !! of all blocks, length^2
    real(dp) :: work = 0.0_dp            !! of loads, ground and supports, force length per unit thickness as all energies
    real(dp) :: fallen = 0.0_dp          !! most that the weights have given
    real(dp) :: friction = 0.0_dp, damping = 0.0_dp, yield = 0.0_dp, asleep = 0.0_dp, dissipated = 0.0_dp
    logical :: has_bolts = .false.       !! the scene has
    real(dp) :: given = 0.0_dp           !! kinetic and strain energy at the start, fallen, and absolute work
    type(books_t), private :: books_from
    real(dp), private :: area_from = 0.0_dp, absolute_work = 0.0_dp
  end type summary_t

contains

  !> Begins with the state that the run begins or goes on with.
  subroutine begin_summary(model, cache, state, summary)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(summary_t), intent(out) :: summary
    real(dp) :: planned

    summary%from = state%time
    summary%books_from = state%books
    summary%area_from = area_of(cache)
    summary%touches = allocated(model%effects%contact)
    summary%tolerance = tolerance_of(model%settings)
    summary%has_bolts = allocated(model%effects%bolt)
    associate (s => model%settings)
      summary%asked = s%end_time
      if (s%chooses_step .or. s%balance > 0) return
      planned = (s%end_time - state%time)/s%step_size
      summary%planned = ceiling(min(real(s%most_steps - state%step, dp), planned*(1 - 1e-9_dp)))
    end associate
  end subroutine begin_summary

  !> Adds a step that was accepted and written.
  subroutine add_step(model, state, report, summary)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state       !! at its end
    type(step_report_t), intent(in) :: report
    type(summary_t), intent(inout) :: summary

    summary%taken = summary%taken + 1
    summary%cut = summary%cut + report%rejected
    summary%solves = summary%solves + report%solves
    summary%absolute_work = summary%absolute_work + abs(report%work)
    if (allocated(report%balance)) summary%balance = report%balance
    summary%fallen = max(summary%fallen, summary%books_from%gravity - state%books%gravity)
    if (state%contacts%penetration > summary%overlap%value) call take_overlap(model, state, summary%overlap)
  end subroutine add_step

  !> Takes the deepest overlap of a step.
  subroutine take_overlap(model, state, overlap)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(overlap_most_t), intent(inout) :: overlap
    type(contact_t) :: deepest
    integer :: i
    real(dp) :: most

    overlap%value = state%contacts%penetration
    overlap%time = state%time
    most = -huge(most)
    do i = 1, size(state%contacts%contact)
      associate (contact => state%contacts%contact(i))
        if (contact%overlap <= most) cycle
        most = contact%overlap
        deepest = contact
      end associate
    end do
    associate (entrance => deepest%entrance(deepest%active), outlines => model%outlines)
      overlap%blocks = outlines%block([entrance%vertex, entrance%edge])
      overlap%position = state%vertex(:, outlines%start(entrance%vertex)) + model%origin
    end associate
  end subroutine take_overlap

  !> Sums up at the end, wherever that is.
  subroutine sum_up(model, cache, state, summary)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(summary_t), intent(inout) :: summary

    summary%reached = state%time
    summary%displacement = most_of(model, state, state%vertex - model%start)
    summary%speed = most_of(model, state, velocity_of_vertices(model, cache, state))
    if (allocated(model%effects%gravity) .and. model%effects%carried > 0) &
      summary%at_rest = all(bodies_at_rest(model, cache, state, resting))
    summary%area = area_of(cache)
    associate (now => state%books, from => summary%books_from)
      summary%work = now%work - from%work
      summary%friction = now%friction - from%friction
      summary%damping = now%damping - from%damping
      summary%yield = now%yield - from%yield
      summary%asleep = now%asleep - from%asleep
      summary%dissipated = (now%at_start + now%work - stored_energy(now)) - (from%at_start + from%work - stored_energy(from))
      summary%given = stored_energy(from) - from%gravity + summary%fallen + summary%absolute_work
    end associate
  end subroutine sum_up

  !> Energy that went elsewhere than into friction, damping, bolts and sleep: by the integrator, in impacts, with bonds; below 0 it
  !> was made.
  pure real(dp) function lost_otherwise(summary) result(lost)
    type(summary_t), intent(in) :: summary

    lost = summary%dissipated - summary%friction - summary%damping - summary%yield - summary%asleep
  end function lost_otherwise

  !> That over what was given; 0 where nothing was.
  pure real(dp) function share_lost(summary) result(share)
    type(summary_t), intent(in) :: summary

    share = 0.0_dp
    if (summary%given > 0) share = lost_otherwise(summary)/summary%given
  end function share_lost

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
      do k = first_vertex_of(model%elements%shape, e), last_vertex_of(model%elements%shape, e)
        if (most%block > 0 .and. norm2(vector(:, k)) <= most%value) cycle
        most = vertex_most_t(norm2(vector(:, k)), model%elements%block(e), state%vertex(:, k) + model%origin)
      end do
    end do
  end function most_of

end module scree_run_summary
