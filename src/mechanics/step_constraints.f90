!> Constraints of the unknowns of a step.
module scree_step_constraints
  use scree_constraints, only: add_followers, clear_constraints, constraints_t
  use scree_errors, only: error_t
  use scree_fixed_point, only: constrain_fixed_points
  use scree_interpolation, only: followed_covers
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_state, only: state_t
  use scree_trouble, only: new_trouble, words_of
  implicit none
  private
  public :: constraints_of_step

contains

  !> Covers that follow others, cells that follow covers, and exact fixed points, as constraints on the unknowns of a step that ends
  !> at `time`.
  pure subroutine constraints_of_step(model, cache, state, time, constraints, error)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    real(dp), intent(in) :: time
    type(constraints_t), intent(out) :: constraints
    type(error_t), allocatable, intent(out) :: error
    integer :: e, i, k

    call clear_constraints(constraints, model%n_unknowns, model%at_rest)
    if (allocated(model%extension)) then
      associate (x => model%extension)
        call add_followers(constraints, [2*x%cover - 1, 2*x%cover], &
                           reshape([2*x%master - 1, 2*x%master], [size(x%master, 1), 2*size(x%cover)]), &
                           reshape([x%weight, x%weight], [size(x%master, 1), 2*size(x%cover)]))
      end associate
    end if
    if (allocated(model%sampling)) then
      do k = 1, size(model%elements%free)
        e = model%elements%free(k)
        associate (cover => model%elements%cover(:, e), own => model%elements%unknown(:, e))
          call add_followers(constraints, own, spread([(2*cover(i) - 1, 2*cover(i), i=1, 6)], 2, size(own)), &
                             followed_covers(model, state, e))
        end associate
      end do
    end if
    if (.not. allocated(model%effects%fixed_point)) return
    if (model%effects%fixed_point%by_springs) return
    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      if (model%effects%fixed_point%first(e) == model%effects%fixed_point%first(e + 1)) cycle
      call constrain_fixed_points(model%effects%fixed_point, e, state%point, time, model%extent, cache%element(e)%kinematics, &
                                  model%elements%unknown(:, e), constraints, error)
      if (.not. allocated(error)) cycle
      error%message = words_of(new_trouble(error%message, element=e, position=cache%element(e)%kinematics%centroid, &
                                         advice='one table of displacement for all that holds a block'), model)
      return
    end do
  end subroutine constraints_of_step

end module scree_step_constraints
