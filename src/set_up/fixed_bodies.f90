!> Bodies that cannot move leave the system: exact fixed points that do not move determine every unknown of theirs. So do bodies
!> that a stage removed.
!>
!> Their elements add no terms and have no equations, and nothing of theirs is updated; outlines of what is fixed stay, for others
!> to touch.
module scree_fixed_bodies
  use scree_constraints, only: clear_constraints, constraints_t
  use scree_errors, only: error_t
  use scree_fixed_point, only: constrain_fixed_points
  use scree_idle_points, only: are_idle
  use scree_interpolation, only: kinematics_of
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_scene, only: model_dda
  use scree_state, only: state_t
  use scree_system, only: element_unknowns, unknowns_at_rest
  implicit none
  private
  public :: leave_out_fixed

  integer, parameter :: n = element_unknowns

contains

  !> Lists what can move, and gives the blocks of the DDA that cannot six unknowns in common, the last, which stay zero.
  pure subroutine leave_out_fixed(model, state)
    type(model_t), intent(inout) :: model
    type(state_t), intent(inout) :: state    !! gets rates for the unknowns that are left
    logical :: is_free(model%n_blocks)
    real(dp) :: velocity(model%n_unknowns)
    integer :: e, i

    is_free = .true.
    if (allocated(model%effects%fixed_point) .and. .not. allocated(model%extension)) &
      is_free = .not. fixed_blocks(model, state)
    is_free = is_free .and. model%present
    associate (elements => model%elements)
      elements%free = pack([(e, e=1, model%n_elements)], is_free(elements%block))
      model%free_block = pack([(i, i=1, model%n_blocks)], is_free)
      model%points%free = pack([(i, i=1, size(model%points%element))], &
                               is_free(elements%block(model%points%element)) .and. .not. are_idle(model))
      model%at_rest = unknowns_at_rest(model, .not. is_free)
      state%velocity(model%at_rest) = 0.0_dp
      model%last_free = model%n_unknowns
      if (model%model /= model_dda .or. all(is_free)) return
      model%n_unknowns = n*(size(elements%free) + 1)
      velocity = 0.0_dp
      do e = 1, model%n_elements
        elements%unknown(:, e) = [(i, i=model%n_unknowns - n + 1, model%n_unknowns)]
      end do
      do e = 1, size(elements%free)
        velocity(n*e - n + 1:n*e) = state%velocity(n*elements%free(e) - n + 1:n*elements%free(e))
        elements%unknown(:, elements%free(e)) = [(i, i=n*e - n + 1, n*e)]
      end do
      model%last_free = model%n_unknowns - n
      model%at_rest = [(i, i=model%last_free + 1, model%n_unknowns)]
      state%velocity = velocity(:model%n_unknowns)
      state%acceleration = 0*state%velocity
    end associate
  end subroutine leave_out_fixed

  !> Blocks each of whose elements exact fixed points hold wholly and for ever.
  pure function fixed_blocks(model, state) result(fixed)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    logical :: fixed(model%n_blocks)
    integer :: e

    fixed = .not. model%effects%fixed_point%by_springs
    do e = 1, model%n_elements
      associate (of_block => fixed(model%elements%block(e)))
        if (of_block) of_block = is_fixed(model, state, e)
      end associate
    end do
  end function fixed_blocks

  !> Whether the fixed points of an element leave it no motion, and do not move.
  pure logical function is_fixed(model, state, e)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: e
    type(constraints_t) :: constraints
    type(error_t), allocatable :: error
    integer :: i

    is_fixed = .false.
    associate (points => model%effects%fixed_point)
      do i = points%first(e), points%first(e + 1) - 1
        if (allocated(points%table(i)%time)) return
      end do
      call clear_constraints(constraints, n)
      call constrain_fixed_points(points, e, state%point, 0.0_dp, model%extent, kinematics_of(model%system_t, state, e), &
                                  [(i, i=1, n)], constraints, error)
      is_fixed = .not. allocated(error) .and. constraints%n_rows == n
    end associate
  end function is_fixed

end module scree_fixed_bodies
