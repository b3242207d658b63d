!> Blocks that leave the scene in the middle of a run: they are removed, and the state goes on without them.
module scree_departures
  use scree_block_input, only: blocks_t
  use scree_carry_over, only: carry_through_removal
  use scree_change_of_model, only: go_on_with, set_up_anew
  use scree_departure_records, only: put_departure
  use scree_errors, only: error_t
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_progress, only: progress_t, tell
  use scree_regions, only: first_vertex_of, last_vertex_of
  use scree_run_output, only: run_output_t
  use scree_scene, only: scene_t
  use scree_state, only: state_t, time_of_run
  use scree_text, only: number_text, rounded_text
  use scree_watch, only: energy_of, keep_watch, watch_t
  implicit none
  private
  public :: remove_departed

contains

  !> Removes the blocks that lie outside the rectangle of the scene, writes and says which. They keep their places, and take their
  !> momentum, their kinetic energy and the energy of their stress and contacts with them.
  !>
  !> Errors: as of `set_up` and `put_departure`.
  subroutine remove_departed(scene, blocks, output, progress, model, cache, state, watch, have_left, error)
    type(scene_t), intent(inout) :: scene        !! of the stage, with what was removed
    type(blocks_t), intent(in) :: blocks
    type(run_output_t), intent(inout) :: output
    type(progress_t), intent(inout) :: progress
    type(model_t), intent(inout) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(inout) :: state
    type(watch_t), intent(inout) :: watch
    logical, intent(out) :: have_left            !! blocks have, and the model is another
    type(error_t), allocatable, intent(out) :: error
    type(model_t) :: rest
    type(state_t) :: on
    integer, allocatable :: before(:), block(:)
    character(len=:), allocatable :: others
    real(dp) :: watched                          !! energy before
    integer :: i

    block = blocks_outside(model, state)
    have_left = size(block) > 0
    if (.not. have_left) return
    do i = 1, size(block)
      call put_departure(output%file, output%records%departures, model, cache, state, block(i), error)
      if (allocated(error)) return
    end do
    others = ''
    if (size(block) > 1) others = ' and '//number_text(size(block) - 1)//' others'
    call tell(progress, 'block '//number_text(block(1))//others//' left the scene at time '//rounded_text(time_of_run(state)))
    scene%removed(blocks%drawn(block)) = .true.
    call set_up_anew(scene, blocks, model%tip, rest, on, error)
    if (allocated(error)) return
    call carry_through_removal(model, state, blocks%bolt%pretension, rest, on)
    before = [integer ::]
    if (allocated(state%departed)) before = state%departed
    on%departed = [before, block]
    watched = energy_of(model, cache, state)
    call go_on_with(rest, on, model, cache, state)
    call keep_watch(watch, model, cache, energy_of(model, cache, state) - watched)
  end subroutine remove_departed

  !> Blocks that can move and lie outside the rectangle of the scene: the box around each of their elements does.
  pure function blocks_outside(model, state) result(list)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, allocatable :: list(:)
    logical :: inside(model%n_blocks)
    real(dp) :: low(2), high(2)
    integer :: b, e, k

    low = model%settings%scene_rectangle(1:2) - model%origin
    high = model%settings%scene_rectangle(3:4) - model%origin
    inside = .true.
    inside(model%free_block) = .false.
    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      if (inside(model%elements%block(e))) cycle
      associate (corners => state%vertex(:, first_vertex_of(model%elements%shape, e):last_vertex_of(model%elements%shape, e)))
        inside(model%elements%block(e)) = all(maxval(corners, 2) >= low .and. minval(corners, 2) <= high)
      end associate
    end do
    list = pack([(b, b=1, model%n_blocks)], .not. inside)
  end function blocks_outside

end module scree_departures
