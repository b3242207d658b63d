!> The cache of a run: everything in it follows from model and state.
module scree_cache
  use scree_contacts, only: contact_search_t
  use scree_effects, only: refresh_elements
  use scree_energy, only: books_of_fixed
  use scree_equations, only: set_up_equations
  use scree_islands, only: release_equations
  use scree_model, only: cache_t, model_t
  use scree_state, only: state_t
  implicit none
  private
  public :: rebuild_cache

contains

  !> Makes the cache of a state anew, whatever it holds. A run goes on from it, to the bit, as with the one that it kept.
  subroutine rebuild_cache(model, state, cache)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(cache_t), intent(inout) :: cache

    cache%search = contact_search_t()
    if (allocated(cache%bodies)) deallocate (cache%bodies)
    if (allocated(cache%element)) deallocate (cache%element)
    call refresh_elements(model, state, cache)
    cache%fixed = books_of_fixed(model, cache, state)
    call release_equations(cache%equations)
    call set_up_equations(model%elements, model%n_unknowns, cache%equations)
  end subroutine rebuild_cache

end module scree_cache
