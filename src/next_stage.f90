!> Model and first state of a stage, from the last state of the stage before.
module scree_next_stage
  use scree_block_input, only: blocks_t
  use scree_carry_over, only: carry_over
  use scree_change_of_model, only: set_up_anew
  use scree_effects, only: refresh_elements
  use scree_errors, only: error_t
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_reactions, only: find_reactions
  use scree_scene, only: scene_t
  use scree_state, only: state_t
  use scree_text, only: pair_text
  implicit none
  private
  public :: set_up_next

contains

  !> Sets a stage up and has it go on from the stage before. Where it has absorbing edges, they bear what supports did.
  !>
  !> Errors: as of `set_up` and `find_reactions`.
  subroutine set_up_next(scene, blocks, model_before, before, cache, model, state, said, error)
    type(scene_t), intent(in) :: scene             !! of the stage
    type(blocks_t), intent(in) :: blocks
    type(model_t), intent(in) :: model_before
    type(state_t), intent(in) :: before
    type(cache_t), intent(inout) :: cache          !! of the state before
    type(model_t), intent(out) :: model
    type(state_t), intent(out) :: state
    character(len=:), allocatable, intent(out) :: said !! what absorbing edges bear, in words; '' for nothing
    type(error_t), allocatable, intent(out) :: error
    real(dp), allocatable :: reaction(:, :)

    said = ''
    call set_up_anew(scene, blocks, model_before%tip, model, state, error)
    if (allocated(error)) return
    allocate (reaction(2, size(model_before%points%kind)), source=0.0_dp)
    if (allocated(model%effects%absorbing_edge)) then
      call refresh_elements(model_before, before, cache)
      call find_reactions(model_before, cache, before, reaction, error)
      if (allocated(error)) return
    end if
    call carry_over(model_before, before, reaction, blocks%bolt%pretension, model, state)
    if (any(abs(state%static_force) > 0)) &
      said = 'absorbing edges bear forces that supports did, in sum '//pair_text(sum(state%static_force, 2))
  end subroutine set_up_next

end module scree_next_stage
