!> Bodies that take an impact: their motion as rigid ones.
!>
!> The rates v of a body's unknowns are a rigid motion q = (velocity of its centre, rotation rate) and a deformation that is
!> orthogonal to every rigid one in its mass matrix M. With R the rates that units of q make,
!>
!>     v = R q + w,   q = (R^T M R)^-1 R^T M v,   R^T M w = 0,   v.M v/2 = q.(R^T M R) q/2 + w.M w/2
!>
!> so that impulses which change q alone leave strain rates and their energy as they are. A body that supports hold in part has
!> only the rigid motions that these leave it: with P its mobility, (R^T M R)^-1 of a free one, and q0 a motion of what holds it,
!>
!>     q = q0 + P (R^T M v - R^T M R q0),   P (R^T M R) P = P,
!>
!> and w has what it shears and turns by at once, which no impulse changes. A body of many manifold elements moves as one, and so do
!> blocks that bonds hold together: `part_of` tells of each block which stands for its body, the first of
!> those.
module scree_rigid_bodies
  use scree_effects, only: supports_move
  use scree_fixed_point, only: is_roller
  use scree_interpolation, only: displacement_matrix, rigid_modes
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_sorting, only: sort_into
  use scree_state, only: state_t
  use scree_system, only: element_unknowns, fixed_point
  implicit none
  private
  public :: add_motion, find_bodies, held_bodies, modes_of, motion_of, motion_of_holders, rigid_bodies_t, take_deformation

  !> Bodies in the configuration that contacts of a step act in.
  type :: rigid_bodies_t
    integer, allocatable :: part_of(:)          !! (n_blocks) the block that stands for the body; 0: it takes no part
    integer, allocatable :: number(:)           !! (n_blocks) of the body that a block is part of, 0: none
    integer, allocatable :: first(:)            !! (n + 1) body b has element(first(b):first(b+1)-1)
    integer, allocatable :: element(:)
    integer, allocatable :: held_by(:, :)       !! (2, n) fixed points in different places, 0: none
    logical, allocatable :: rolls(:)            !! (n) on lines of &support
    logical, allocatable :: held(:)             !! (n) it has no motion of its own
    real(dp), allocatable :: moved(:)           !! (n_unknowns) displacement to the configuration
    real(dp), allocatable :: centre(:, :)       !! (2, n) of mass, length
    real(dp), allocatable :: mass(:, :)         !! (3, n) mass twice, and inertia about the centre; per unit thickness
    real(dp), allocatable :: mobility(:, :, :)  !! (3, 3, n) change of q by a unit of impulse; 0 for a body that is held
  end type rigid_bodies_t

  !> Supports hold no turn of a body that is wider than them by the root of this, inverse.
  real(dp), parameter :: narrow = 1e-10_dp
  !> And where they are less wide than this, of the same, their velocities tell no turn: points of a guide that has turned a little
  !> are not at one height, and rounding or springs between them would be a fast turn.
  real(dp), parameter :: wide = 1e-2_dp

contains

  !> Finds how bodies move as rigid ones.
  !>
  !> A body with a fixed point turns about it, and one with two of them does not move, whether they are exact or springs. One on
  !> supports has the motions that these leave it.
  pure subroutine find_bodies(model, cache, state, moved, part_of, bodies)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state        !! at the beginning of the step
    real(dp), intent(in) :: moved(:)          !! (n_unknowns) displacement to where contacts act
    integer, intent(in) :: part_of(:)         !! (n_blocks) the block that stands for the body; 0: it takes no part
    type(rigid_bodies_t), intent(out) :: bodies
    integer :: b, i, k, n

    bodies%part_of = part_of
    bodies%moved = moved
    allocate (bodies%number(size(part_of)), source=0)
    n = 0
    do i = 1, size(part_of)
      if (part_of(i) == i) then
        n = n + 1
        bodies%number(i) = n
      else if (part_of(i) > 0) then
        bodies%number(i) = bodies%number(part_of(i))
      end if
    end do
    call sort_into(bodies%number(model%elements%block), n, bodies%first, bodies%element)
    allocate (bodies%centre(2, n), bodies%mass(3, n), bodies%mobility(3, 3, n), source=0.0_dp)
    do b = 1, n
      do k = bodies%first(b), bodies%first(b + 1) - 1
        associate (own => cache%element(bodies%element(k)), d => moved(model%elements%unknown(:, bodies%element(k))))
          bodies%mass(1:2, b) = bodies%mass(1:2, b) + own%mass
          bodies%centre(:, b) = bodies%centre(:, b) + own%mass*(own%kinematics%centroid + matmul(own%kinematics%at_centroid, d))
        end associate
      end do
      bodies%centre(:, b) = bodies%centre(:, b)/bodies%mass(1, b)
      do k = bodies%first(b), bodies%first(b + 1) - 1
        associate (turn => modes_of(model, cache, state, bodies, bodies%element(k)))
          bodies%mass(3, b) = bodies%mass(3, b) + &
                              dot_product(turn(:, 3), matmul(cache%element(bodies%element(k))%mass_matrix, turn(:, 3)))
        end associate
      end do
      bodies%mobility(:, :, b) = diagonal_matrix(1/bodies%mass(:, b))
    end do
    call hold(model, cache, state, bodies)
  end subroutine find_bodies

  !> The matrix with a diagonal, and nothing beside it.
  pure function diagonal_matrix(diagonal) result(matrix)
    real(dp), intent(in) :: diagonal(3)
    real(dp) :: matrix(3, 3)
    integer :: k

    matrix = 0.0_dp
    do k = 1, 3
      matrix(k, k) = diagonal(k)
    end do
  end function diagonal_matrix

  !> Blocks of bodies that fixed points in two places, or supports, leave no motion.
  pure function held_bodies(model, state, part_of) result(held)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: part_of(:)         !! (n_blocks) the block that stands for the body
    logical :: held(size(part_of)), rolls(size(part_of))
    integer, allocatable :: support(:)
    real(dp), allocatable :: position(:, :)
    real(dp) :: mobility(3, 3), motion(3), size_of_it
    integer :: b, by(2, size(part_of)), left

    by = holding_points(model, state, part_of)
    held = by(2, :) > 0
    rolls = rolling_bodies(model, part_of)
    do b = 1, size(part_of)
      if (held(b) .or. .not. rolls(b)) cycle
      support = supports_of(model, part_of, b)
      position = state%point(:, model%effects%fixed_point%point(support))
      size_of_it = maxval(norm2(position - spread(position(:, 1), 2, size(support)), 1))
      mobility = diagonal_matrix([1.0_dp, 1.0_dp, 1/size_of_it**2])
      motion = 0.0_dp
      call obey(support_rows(model, support, position, position(:, 1)), mobility, motion, left)
      held(b) = left == 0
    end do
    do b = 1, size(part_of)
      if (part_of(b) > 0) held(b) = held(part_of(b))
    end do
  end function held_bodies

  !> Which blocks stand for bodies on lines of &support.
  pure function rolling_bodies(model, part_of) result(rolls)
    type(model_t), intent(in) :: model
    integer, intent(in) :: part_of(:)         !! (n_blocks)
    logical :: rolls(size(part_of))
    integer :: i

    rolls = .false.
    if (.not. allocated(model%effects%fixed_point)) return
    associate (held => model%effects%fixed_point)
      do i = 1, size(held%point)
        associate (b => part_of(model%elements%block(model%points%element(held%point(i)))))
          if (b > 0 .and. is_roller(held, i)) rolls(b) = .true.
        end associate
      end do
    end associate
  end function rolling_bodies

  !> Fixed points and ends of supports of the body that block `b` stands for, numbers among those that are held.
  pure function supports_of(model, part_of, b) result(support)
    type(model_t), intent(in) :: model
    integer, intent(in) :: part_of(:), b      !! (n_blocks)
    integer, allocatable :: support(:)
    integer :: i

    associate (point => model%effects%fixed_point%point)
      support = pack([(i, i=1, size(point))], part_of(model%elements%block(model%points%element(point))) == b)
    end associate
  end function supports_of

  !> Rows of the velocities that supports hold: (x, y, turn) of a rigid motion about a centre, twice for each of them.
  pure function support_rows(model, support, position, centre) result(row)
    type(model_t), intent(in) :: model
    integer, intent(in) :: support(:)
    real(dp), intent(in) :: position(:, :)    !! (2, size(support)) length
    real(dp), intent(in) :: centre(2)
    real(dp) :: row(3, 2*size(support)), direction(2, 2)
    integer :: i, k

    do i = 1, size(support)
      direction = reshape([1.0_dp, 0.0_dp, 0.0_dp, 1.0_dp], [2, 2])
      if (is_roller(model%effects%fixed_point, support(i))) &
        direction = spread(model%effects%fixed_point%direction(:, support(i)), 2, 2)
      associate (arm => position(:, i) - centre)
        do k = 1, 2
          row(:, 2*i - 2 + k) = [direction(:, k), direction(2, k)*arm(1) - direction(1, k)*arm(2)]
        end do
      end associate
    end do
  end function support_rows

  !> Takes from a rigid motion q and its mobility P what supports hold, one after the other: with c the row of a velocity that is to
  !> be w, a = P c,
  !>
  !>     q <- q + a (w - c.q)/(c.a),   P <- P - a a^T/(c.a)
  !>
  !> after which c.q = w and P c = 0, so that what comes later changes nothing of it.
  pure subroutine obey(row, mobility, motion, left, rate)
    real(dp), intent(in) :: row(:, :)         !! (3, n)
    real(dp), intent(inout) :: mobility(3, 3), motion(3)
    integer, intent(out) :: left              !! motions that are free
    real(dp), intent(in), optional :: rate(:) !! (n) w, length/time; 0 where absent
    real(dp) :: a(3), free(3, 3), own
    integer :: i, k

    free = mobility
    left = 3
    do i = 1, size(row, 2)
      a = matmul(mobility, row(:, i))
      own = dot_product(row(:, i), a)
      if (.not. own > narrow*dot_product(row(:, i), matmul(free, row(:, i)))) cycle
      motion = motion - a*dot_product(row(:, i), motion)/own
      if (present(rate)) then
        if (own > wide*dot_product(row(:, i), matmul(free, row(:, i)))) motion = motion + a*rate(i)/own
      end if
      do k = 1, 3
        mobility(:, k) = mobility(:, k) - a*a(k)/own
      end do
      left = left - 1
      if (left == 0) exit
    end do
    if (left == 0) mobility = 0.0_dp
  end subroutine obey

  !> Where the supports of body `b` are in the configuration that contacts act in.
  pure function places_of(model, cache, state, bodies, support) result(position)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(rigid_bodies_t), intent(in) :: bodies
    integer, intent(in) :: support(:)
    real(dp) :: position(2, size(support))
    integer :: i

    do i = 1, size(support)
      associate (point => model%effects%fixed_point%point(support(i)))
        position(:, i) = state%point(:, point) + moved_point(model, cache, state, point, bodies%moved)
      end associate
    end do
  end function places_of

  !> Two fixed points of each body in different places, at the block that stands for it; 0 where there are none.
  pure function holding_points(model, state, part_of) result(by)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: part_of(:)         !! (n_blocks)
    integer :: by(2, size(part_of)), b, i

    by = 0
    do i = 1, size(model%points%element)
      if (model%points%kind(i) /= fixed_point) cycle
      b = part_of(model%elements%block(model%points%element(i)))
      if (b == 0) cycle
      if (by(1, b) == 0) then
        by(1, b) = i
      else if (by(2, b) == 0 .and. norm2(state%point(:, i) - state%point(:, by(1, b))) > 0) then
        by(2, b) = i
      end if
    end do
  end function holding_points

  !> Takes from bodies with fixed points or supports what these hold.
  pure subroutine hold(model, cache, state, bodies)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(rigid_bodies_t), intent(inout) :: bodies
    real(dp) :: motion(3), turn(3)
    integer, allocatable :: stands(:), support(:)
    integer :: b, by(2, size(bodies%part_of)), k, left
    logical :: rolls(size(bodies%part_of))

    stands = standing_for(bodies)
    by = holding_points(model, state, bodies%part_of)
    bodies%held_by = by(:, stands)
    rolls = rolling_bodies(model, bodies%part_of)
    bodies%rolls = rolls(stands)
    bodies%held = bodies%held_by(2, :) > 0
    do b = 1, size(bodies%held)
      if (bodies%rolls(b)) then
        support = supports_of(model, bodies%part_of, stands(b))
        motion = 0.0_dp
        call obey(support_rows(model, support, places_of(model, cache, state, bodies, support), bodies%centre(:, b)), &
                  bodies%mobility(:, :, b), motion, left)
        bodies%held(b) = left == 0
      else if (bodies%held_by(2, b) > 0) then
        bodies%mobility(:, :, b) = 0.0_dp
      else if (bodies%held_by(1, b) > 0) then
        associate (arm => bodies%centre(:, b) - state%point(:, bodies%held_by(1, b)) &
                   - moved_point(model, cache, state, bodies%held_by(1, b), bodies%moved))
          turn = [-arm(2), arm(1), 1.0_dp]
        end associate
        do k = 1, 3
          bodies%mobility(:, k, b) = turn*turn(k)/sum(bodies%mass(:, b)*turn**2)
        end do
      end if
    end do
  end subroutine hold

  !> The blocks that stand for the bodies.
  pure function standing_for(bodies) result(block)
    type(rigid_bodies_t), intent(in) :: bodies
    integer, allocatable :: block(:)
    integer :: i

    block = pack(bodies%part_of, bodies%part_of == [(i, i=1, size(bodies%part_of))])
  end function standing_for

  !> What unknowns, or their rates, move a point by.
  pure function moved_point(model, cache, state, i, unknown) result(moved)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    integer, intent(in) :: i
    real(dp), intent(in) :: unknown(:)        !! (n_unknowns)
    real(dp) :: moved(2)

    associate (e => model%points%element(i))
      moved = matmul(displacement_matrix(cache%element(e)%kinematics, state%point(:, i)), unknown(model%elements%unknown(:, e)))
    end associate
  end function moved_point

  !> Rates of the unknowns of element `e` in unit motions of its body: along x, along y, and turning about its centre.
  pure function modes_of(model, cache, state, bodies, e) result(modes)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(rigid_bodies_t), intent(in) :: bodies
    integer, intent(in) :: e
    real(dp) :: modes(element_unknowns, 3)

    modes = rigid_modes(model, state, e, cache%element(e)%kinematics, bodies%moved(model%elements%unknown(:, e)), &
                        bodies%centre(:, bodies%number(model%elements%block(e))))
  end function modes_of

  !> Rigid motions q (3, n) of the bodies in a field of rates; of those that are held, the motion of what holds them, and of those
  !> that are held in part what that leaves them beside it.
  pure function motion_of(model, cache, state, bodies, rates) result(motion)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(rigid_bodies_t), intent(in) :: bodies
    real(dp), intent(in) :: rates(:)          !! (n_unknowns)
    real(dp) :: motion(3, size(bodies%held)), momentum(3)
    integer :: b, e, k

    motion = motion_of_holders(model, cache, state, bodies, rates)
    do b = 1, size(bodies%held)
      if (bodies%held(b)) cycle
      momentum = 0.0_dp
      do k = bodies%first(b), bodies%first(b + 1) - 1
        e = bodies%element(k)
        momentum = momentum + matmul(matmul(cache%element(e)%mass_matrix, rates(model%elements%unknown(:, e))), &
                                     modes_of(model, cache, state, bodies, e))
      end do
      if (bodies%rolls(b) .or. bodies%held_by(1, b) > 0) then
        motion(:, b) = motion(:, b) + matmul(bodies%mobility(:, :, b), momentum - bodies%mass(:, b)*motion(:, b))
      else
        motion(:, b) = momentum/bodies%mass(:, b)
      end if
    end do
  end function motion_of

  !> Rigid motions (3, n) of what holds the bodies, in whole or in part, in a field of rates: none where no table moves it.
  pure function motion_of_holders(model, cache, state, bodies, rates) result(motion)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(rigid_bodies_t), intent(in) :: bodies
    real(dp), intent(in) :: rates(:)          !! (n_unknowns)
    real(dp) :: motion(3, size(bodies%held))
    integer :: b

    motion = 0.0_dp
    if (.not. supports_move(model)) return
    do b = 1, size(bodies%held)
      if (bodies%rolls(b)) then
        motion(:, b) = motion_of_supports(model, cache, state, bodies, b, rates)
      else if (bodies%held(b)) then
        motion(:, b) = motion_of_held(model, cache, state, bodies, b, rates)
      else if (bodies%held_by(1, b) > 0) then
        motion(:, b) = [moved_point(model, cache, state, bodies%held_by(1, b), rates), 0.0_dp]
      end if
    end do
  end function motion_of_holders

  !> Rigid motion of a body that is held, by two of its fixed points.
  pure function motion_of_held(model, cache, state, bodies, b, rates) result(motion)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(rigid_bodies_t), intent(in) :: bodies
    integer, intent(in) :: b
    real(dp), intent(in) :: rates(:)          !! (n_unknowns)
    real(dp) :: motion(3), position(2, 2), moving(2, 2), apart(2), arm(2)
    integer :: k

    do k = 1, 2
      associate (i => bodies%held_by(k, b))
        position(:, k) = state%point(:, i) + moved_point(model, cache, state, i, bodies%moved)
        moving(:, k) = moved_point(model, cache, state, i, rates)
      end associate
    end do
    apart = position(:, 2) - position(:, 1)
    motion(3) = dot_product([-apart(2), apart(1)], moving(:, 2) - moving(:, 1))/sum(apart**2)
    arm = bodies%centre(:, b) - position(:, 1)
    motion(1:2) = moving(:, 1) + motion(3)*[-arm(2), arm(1)]
  end function motion_of_held

  !> Rigid motion of what holds a body in whole or in part, of supports with some fixed points or without.
  pure function motion_of_supports(model, cache, state, bodies, b, rates) result(motion)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(rigid_bodies_t), intent(in) :: bodies
    integer, intent(in) :: b
    real(dp), intent(in) :: rates(:)          !! (n_unknowns)
    real(dp) :: mobility(3, 3), motion(3), moving(2)
    real(dp), allocatable :: rate(:), row(:, :)
    integer, allocatable :: stands(:), support(:)
    integer :: i, left

    stands = standing_for(bodies)
    support = supports_of(model, bodies%part_of, stands(b))
    row = support_rows(model, support, places_of(model, cache, state, bodies, support), bodies%centre(:, b))
    allocate (rate(size(row, 2)))
    do i = 1, size(support)
      moving = moved_point(model, cache, state, model%effects%fixed_point%point(support(i)), rates)
      rate(2*i - 1:2*i) = matmul(moving, row(1:2, 2*i - 1:2*i))
    end do
    mobility = diagonal_matrix(1/bodies%mass(:, b))
    motion = 0.0_dp
    call obey(row, mobility, motion, left, rate)
  end function motion_of_supports

  !> Adds rigid motions of the bodies to a field of rates.
  pure subroutine add_motion(model, cache, state, bodies, motion, rates)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(rigid_bodies_t), intent(in) :: bodies
    real(dp), intent(in) :: motion(:, :)      !! (3, n)
    real(dp), intent(inout) :: rates(:)       !! (n_unknowns)
    real(dp) :: before(size(rates))
    integer :: b, e, k

    before = rates
    do b = 1, size(bodies%held)
      do k = bodies%first(b), bodies%first(b + 1) - 1
        e = bodies%element(k)
        associate (ids => model%elements%unknown(:, e))
          rates(ids) = before(ids) + matmul(modes_of(model, cache, state, bodies, e), motion(:, b)) ! elements share covers
        end associate
      end do
    end do
  end subroutine add_motion

  !> Takes a share of the rates of deformation from bodies of one element that nothing holds. Their strain is constant, so what a
  !> step makes of them is no wave that could go on: it rings at the infinite frequency of the integrator.
  pure subroutine take_deformation(model, cache, state, bodies, share, motion, rates, change)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(rigid_bodies_t), intent(in) :: bodies
    real(dp), intent(in) :: share
    real(dp), intent(in) :: motion(:, :)      !! (3, n) of `rates`
    real(dp), intent(in) :: rates(:)          !! (n_unknowns)
    real(dp), intent(inout) :: change(:)      !! (n_unknowns) of the rates
    integer :: b

    do b = 1, size(bodies%held)
      if (bodies%first(b + 1) > bodies%first(b) + 1 .or. bodies%held_by(1, b) > 0 .or. bodies%rolls(b)) cycle
      associate (e => bodies%element(bodies%first(b)), ids => model%elements%unknown(:, bodies%element(bodies%first(b))))
        change(ids) = change(ids) - share*(rates(ids) - matmul(modes_of(model, cache, state, bodies, e), motion(:, b)))
      end associate
    end do
  end subroutine take_deformation

end module scree_rigid_bodies
