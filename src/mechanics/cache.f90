!> The cache of a run: everything in it follows from model and state.
module scree_cache
  use scree_contacts, only: contact_search_t
  use scree_effects, only: refresh_elements
  use scree_energy, only: books_of_fixed
  use scree_equations, only: set_up_equations
  use scree_islands, only: release_equations
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_regions, only: first_vertex_of, last_vertex_of
  use scree_state, only: state_t
  implicit none
  private
  public :: note_fixed, rebuild_cache

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
    call note_fixed(model, state, cache)
    call release_equations(cache%equations)
    call set_up_equations(model%elements, model%n_unknowns, cache%equations)
  end subroutine rebuild_cache

  !> Notes what elements that cannot move have, once for all steps: their energies, and how far from the origin they reach.
  pure subroutine note_fixed(model, state, cache)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(cache_t), intent(inout) :: cache   !! with the elements of the state
    logical :: fixed(model%n_elements)
    integer :: e

    cache%fixed = books_of_fixed(model, cache, state)
    cache%fixed_extent = 0.0_dp
    fixed = .true.
    fixed(model%elements%free) = .false.
    associate (shape => model%elements%shape)
      do e = 1, model%n_elements
        if (fixed(e)) cache%fixed_extent = max(cache%fixed_extent, &
                                               maxval(abs(state%vertex(:, first_vertex_of(shape, e):last_vertex_of(shape, e)))))
      end do
    end associate
  end subroutine note_fixed

end module scree_cache
