!> Forces of the supports on their points, at a state at rest.
!>
!> Exact supports have no force of their own. At rest they take up what all other forces f lack to equilibrium. The displacement
!> of the held points along their directions is C d, with the unknowns d of their elements over the displacement that a unit of
!> each makes. So the reactions R do C^T R = -f on all that is held. Supports may hold more often than needed, as two edges do
!> that share a corner. Of all reactions that balance f, those with the least sum of squares are taken. They are the solution of
!>
!>     min |C^T R + f|
!>
!> that conjugate gradients on the normal equations find from 0 (CGLS: Björck, *Numerical Methods for Least Squares Problems*,
!> SIAM 1996, section 7.4).
module scree_reactions
  use scree_effects, only: add_element_effects
  use scree_element_term, only: step_rule_t, term_t
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_fixed_point, only: is_roller, spring_force
  use scree_integrator, only: rule_at_rest
  use scree_interpolation, only: displacement_matrix
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_pair_effects, only: add_forces_of_bolts, add_forces_of_contacts
  use scree_scene, only: model_dda
  use scree_state, only: state_t
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: find_reactions, forces_at_rest

  integer, parameter :: n = element_unknowns

  !> Part of the forces along the supports that the reactions may leave.
  real(dp), parameter :: left_over = 1e-12_dp
  !> Rounds for each support. Without round-off one would do.
  integer, parameter :: most_rounds = 20

  !> The matrix C, by rows.
  type :: held_t
    integer, allocatable :: point(:)        !! (n_rows) point of the system
    integer, allocatable :: element(:)      !! (n_rows) that carries it
    real(dp), allocatable :: along(:, :)    !! (2, n_rows) direction in which it is held
    real(dp), allocatable :: row(:, :)      !! (n, n_rows) displacement in it that a unit displacement of each unknown makes
  end type held_t

contains

  !> Forces of all effects on each element at a state whose velocities count as 0, contacts and bolts between elements included.
  pure subroutine forces_at_rest(model, cache, state, terms)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache      !! of the state
    type(state_t), intent(in) :: state
    type(term_t), intent(out) :: terms(:)   !! (n_elements)
    type(state_t) :: at_rest
    type(step_rule_t) :: rule
    real(dp) :: nothing(n)
    integer :: e

    at_rest = state
    at_rest%velocity = 0.0_dp
    at_rest%acceleration = 0.0_dp
    rule = rule_at_rest(state%time, 1.0_dp)
    nothing = 0.0_dp
    do e = 1, model%n_elements
      call add_element_effects(model, cache%element(e), at_rest, e, nothing, rule, terms(e))
    end do
    call add_forces_of_bolts(model, cache, at_rest, rule, terms)
    call add_forces_of_contacts(model, cache, state, terms)
  end subroutine forces_at_rest

  !> Finds the force of the supports on each point of the system, per unit thickness; 0 where none holds it.
  !>
  !> Errors: round-off hides the reactions, as where the held edge of a block is far shorter than the block.
  subroutine find_reactions(model, cache, state, reaction, error)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache      !! of the state
    type(state_t), intent(in) :: state
    real(dp), allocatable, intent(out) :: reaction(:, :) !! (2, n_points)
    type(error_t), allocatable, intent(out) :: error
    type(held_t) :: held
    type(state_t) :: all_awake
    type(term_t), allocatable :: terms(:)
    real(dp), allocatable :: force(:), R(:)
    integer :: e, i

    allocate (reaction(2, size(model%points%kind)), source=0.0_dp)
    if (.not. allocated(model%effects%fixed_point)) return
    associate (fixed => model%effects%fixed_point)
      if (fixed%by_springs) then
        do i = 1, size(fixed%point)
          reaction(:, fixed%point(i)) = reaction(:, fixed%point(i)) + spring_force(fixed, i, state%point, state%time)
        end do
        return
      end if
    end associate
    all_awake = state
    if (allocated(state%sleep)) all_awake%contacts%contact = [state%contacts%contact, state%sleep%contact]
    allocate (terms(model%n_elements))
    call forces_at_rest(model, cache, all_awake, terms)
    held = rows_of(model, cache, state)
    allocate (force(n*model%n_elements), source=0.0_dp)
    do e = 1, model%n_elements
      call add_to(model, e, terms(e)%force/cache%element(e)%kinematics%span, force)
    end do
    call follow_masters(model, force)
    call solve(model, held, force, R, error)
    do i = 1, size(R)
      reaction(:, held%point(i)) = reaction(:, held%point(i)) + R(i)*held%along(:, i)
    end do
  end subroutine find_reactions

  !> The rows of C: one for each roller, two for each point that is fixed in both directions.
  pure type(held_t) function rows_of(model, cache, state) result(held)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    real(dp), parameter :: axes(2, 2) = reshape([1.0_dp, 0.0_dp, 0.0_dp, 1.0_dp], [2, 2])
    real(dp) :: along(2, 2), T(2, n)
    integer :: i, k, n_rows

    associate (fixed => model%effects%fixed_point)
      n_rows = 2*size(fixed%point)
      allocate (held%point(n_rows), held%element(n_rows), held%along(2, n_rows), held%row(n, n_rows))
      n_rows = 0
      do i = 1, size(fixed%point)
        associate (e => model%points%element(fixed%point(i)))
          T = displacement_matrix(cache%element(e)%kinematics, state%point(:, fixed%point(i)))
          along = axes
          if (is_roller(fixed, i)) along(:, 1) = fixed%direction(:, i)
          do k = 1, merge(1, 2, is_roller(fixed, i))
            n_rows = n_rows + 1
            held%point(n_rows) = fixed%point(i)
            held%element(n_rows) = e
            held%along(:, n_rows) = along(:, k)
            held%row(:, n_rows) = matmul(along(:, k), T)/cache%element(e)%kinematics%span
          end do
        end associate
      end do
    end associate
    held%point = held%point(:n_rows)
    held%element = held%element(:n_rows)
    held%along = held%along(:, :n_rows)
    held%row = held%row(:, :n_rows)
  end function rows_of

  !> Solves min |C^T R + f| for the R of the least size.
  !>
  !> Errors: as of `find_reactions`.
  pure subroutine solve(model, held, f, R, error)
    type(model_t), intent(in) :: model
    type(held_t), intent(in) :: held
    real(dp), intent(in) :: f(:)
    real(dp), allocatable, intent(out) :: R(:)       !! (n_rows) force per unit thickness
    type(error_t), allocatable, intent(out) :: error
    real(dp), dimension(size(held%point)) :: direction, slope
    real(dp), dimension(size(f)) :: change, left
    real(dp) :: alpha, first, now, next
    integer :: round

    allocate (R(size(held%point)), source=0.0_dp)
    left = -f
    slope = along_supports(model, held, left)
    direction = slope
    now = sum(slope**2)
    first = now
    do round = 1, most_rounds*size(R)
      if (.not. now > left_over**2*first) return
      change = of_supports(model, held, direction)
      alpha = now/sum(change**2)
      R = R + alpha*direction
      left = left - alpha*change
      slope = along_supports(model, held, left)
      next = sum(slope**2)
      direction = slope + next/now*direction
      now = next
    end do
    if (now > left_over**2*first) &
      call fail(error, status_run_failed, 'expected supports whose reactions can be told apart, to hand them over to absorbing '// &
                'edges, found held edges that are too short against their blocks; try rounder blocks there')
  end subroutine solve

  !> C times a vector of the unknowns.
  pure function along_supports(model, held, x) result(y)
    type(model_t), intent(in) :: model
    type(held_t), intent(in) :: held
    real(dp), intent(in) :: x(:)
    real(dp) :: y(size(held%point)), full(size(x))
    integer :: i

    full = x
    if (allocated(model%extension)) then
      associate (follows => model%extension)
        do i = 1, size(follows%cover)
          full(2*follows%cover(i) - 1) = dot_product(follows%weight(:, i), x(2*follows%master(:, i) - 1))
          full(2*follows%cover(i)) = dot_product(follows%weight(:, i), x(2*follows%master(:, i)))
        end do
      end associate
    end if
    do i = 1, size(y)
      y(i) = dot_product(held%row(:, i), full(unknowns_of(model, held%element(i))))
    end do
  end function along_supports

  !> C^T times reactions.
  pure function of_supports(model, held, R) result(force)
    type(model_t), intent(in) :: model
    type(held_t), intent(in) :: held
    real(dp), intent(in) :: R(:)
    real(dp) :: force(n*model%n_elements)
    integer :: i

    force = 0.0_dp
    do i = 1, size(R)
      call add_to(model, held%element(i), R(i)*held%row(:, i), force)
    end do
    call follow_masters(model, force)
  end function of_supports

  !> Adds the force on an element to that on all unknowns.
  pure subroutine add_to(model, e, own, force)
    type(model_t), intent(in) :: model
    integer, intent(in) :: e
    real(dp), intent(in) :: own(n)
    real(dp), intent(inout) :: force(:)

    associate (ids => unknowns_of(model, e))
      force(ids) = force(ids) + own
    end associate
  end subroutine add_to

  !> Gives the force on covers that follow others to these.
  pure subroutine follow_masters(model, force)
    type(model_t), intent(in) :: model
    real(dp), intent(inout) :: force(:)
    integer :: i, k, xy

    if (.not. allocated(model%extension)) return
    associate (follows => model%extension)
      do i = 1, size(follows%cover)
        do xy = 0, 1
          associate (own => force(2*follows%cover(i) - xy))
            do k = 1, size(follows%master, 1)
              associate (master => force(2*follows%master(k, i) - xy))
                master = master + follows%weight(k, i)*own
              end associate
            end do
            own = 0.0_dp
          end associate
        end do
      end do
    end associate
  end subroutine follow_masters

  !> Numbers of the unknowns of an element. Blocks of the DDA that cannot move, which have six in common, have their own here.
  pure function unknowns_of(model, e) result(ids)
    type(model_t), intent(in) :: model
    integer, intent(in) :: e
    integer :: ids(n), i

    ids = model%elements%unknown(:, e)
    if (model%model == model_dda) ids = [(i, i=n*e - n + 1, n*e)]
  end function unknowns_of

end module scree_reactions
