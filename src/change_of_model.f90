!> Another model in the place of that of a run, in the middle of it or of a stage: cracks have cut blocks further, blocks have left,
!> or the next stage begins.
module scree_change_of_model
  use scree_block_input, only: blocks_t
  use scree_cache, only: rebuild_cache
  use scree_crack_tip, only: crack_tip_t
  use scree_crack_tips, only: number_tips
  use scree_energy, only: close_books, stored_energy
  use scree_errors, only: error_t
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_scene, only: effect_t, scene_t
  use scree_set_up, only: set_up
  use scree_state, only: cracks_t, state_t
  implicit none
  private
  public :: go_on_with, set_up_anew

contains

  !> Sets a scene up again, as it has become. Tips of cracks keep the numbers that they had.
  !>
  !> Errors: as of `set_up`.
  subroutine set_up_anew(scene, blocks, before, model, state, error, grown)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(crack_tip_t), allocatable, intent(in) :: before(:) !! tips until then
    type(model_t), intent(out) :: model
    type(state_t), intent(out) :: state          !! at the start of the scene
    type(error_t), allocatable, intent(out) :: error
    type(cracks_t), intent(in), optional :: grown !! pieces by which cracks have grown since; not there: none
    type(effect_t), allocatable :: list(:)
    type(cracks_t) :: since
    real(dp) :: shift(2)

    call set_up(scene, blocks, model, state, list, error)
    if (allocated(error) .or. .not. (allocated(before) .and. allocated(model%tip))) return
    allocate (since%piece(4, 0), since%joint(0), since%tip(0), since%time(0))
    if (present(grown)) since = grown
    shift = model%origin - blocks%origin
    call number_tips(before, since%piece - spread([shift, shift], 2, size(since%tip)), since%tip, model%extent, model%tip)
  end subroutine set_up_anew

  !> Has a run go on in another model within a stage. What this changes in the energy is booked as staged.
  subroutine go_on_with(next, first, model, cache, state)
    type(model_t), intent(in) :: next
    type(state_t), intent(in) :: first           !! state of that, carried over from the one before
    type(model_t), intent(inout) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(inout) :: state
    real(dp) :: before                           !! energy
    integer :: threads

    before = stored_energy(state%books)
    threads = model%settings%threads
    model = next
    model%settings%threads = threads
    state = first
    allocate (state%factored(0)) ! its matrices are others
    call rebuild_cache(model, state, cache)
    state%books%sleeping_springs = 0.0_dp ! all are awake
    if (allocated(state%contacts%contact)) state%books%contact_springs = sum(state%contacts%contact%energy)
    call close_books(model, cache, state)
    state%books%staged = state%books%staged + stored_energy(state%books) - before
  end subroutine go_on_with

end module scree_change_of_model
