!> Bodies that take an impact: their motion as rigid ones.
!>
!> The rates v of a body's unknowns are a rigid motion q = (velocity of its centre, rotation rate) and a deformation w. In the mass
!> matrix M of the body, w is orthogonal to every rigid motion. With R the rates that units of q make,
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
  use scree_effects, only: supported_blocks, supports_move
  use scree_fixed_point, only: is_roller
  use scree_interpolation, only: displacement_matrix, rigid_modes
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_sorting, only: sort_into
  use scree_state, only: state_t
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: add_motion, find_bodies, held_bodies, modes_of, motion_of, motion_of_holders, rigid_bodies_t, take_deformation

  !> Bodies in the configuration that contacts of a step act in.
  type :: rigid_bodies_t
    integer, allocatable :: part_of(:)          !! (n_blocks) the block that stands for the body; 0: it takes no part
    integer, allocatable :: number(:)           !! (n_blocks) of the body that a block is part of, 0: none
    integer, allocatable :: first(:)            !! (n + 1) body b has element(first(b):first(b+1)-1)
    integer, allocatable :: element(:)
    logical, allocatable :: supported(:)        !! (n) it has fixed points, or ends of lines of &support
    logical, allocatable :: held(:)             !! (n) it has no motion of its own
    real(dp), allocatable :: moved(:)           !! (n_unknowns) displacement to the configuration
    real(dp), allocatable :: centre(:, :)       !! (2, n) of mass, length
    real(dp), allocatable :: mass(:, :)         !! (3, n) mass twice, and inertia about the centre; per unit thickness
    real(dp), allocatable :: mobility(:, :, :)  !! (3, 3, n) change of q by a unit of impulse; 0 for a body that is held
  end type rigid_bodies_t

  !> A support holds a motion only if the mobility that earlier supports left in its direction is above this ratio to the free
  !> mobility.
  real(dp), parameter :: narrow = 1e-10_dp
  !> The velocity of a support is imposed only above this ratio, and taken as zero below it. Points of a guide that has turned a
  !> little are not at one height, so rounding or springs between them would appear as a fast turn.
  real(dp), parameter :: wide = 1e-2_dp

contains

  !> Finds how bodies move as rigid ones.
  !>
  !> A body with a fixed point turns about this point, and a body with two fixed points in different places does not move, whether
  !> they are exact or springs. A body on lines of &support has the motions that these lines leave it.
  pure subroutine find_bodies(model, cache, state, moved, part_of, bodies)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state        !! at the beginning of the step
    real(dp), intent(in) :: moved(:)          !! (n_unknowns) displacement to where contacts act
    integer, intent(in) :: part_of(:)         !! (n_blocks) the block that stands for the body; 0: it takes no part
    type(rigid_bodies_t), intent(out) :: bodies
    real(dp), allocatable :: weight(:)        ! of the elements of a body: their mass; their area where none has mass: it is held
    integer :: b, i, k, n
    logical :: has_mass

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
      weight = cache%element(bodies%element(bodies%first(b):bodies%first(b + 1) - 1))%mass
      has_mass = any(weight > 0)
      if (.not. has_mass) weight = cache%element(bodies%element(bodies%first(b):bodies%first(b + 1) - 1))%kinematics%area
      bodies%mass(1:2, b) = sum(weight)
      do k = bodies%first(b), bodies%first(b + 1) - 1
        associate (own => cache%element(bodies%element(k))%kinematics, d => moved(model%elements%unknown(:, bodies%element(k))))
          bodies%centre(:, b) = bodies%centre(:, b) + weight(k - bodies%first(b) + 1)/bodies%mass(1, b) &
                                *(own%centroid + matmul(own%at_centroid, d))
        end associate
      end do
      do k = bodies%first(b), bodies%first(b + 1) - 1
        associate (turn => modes_of(model, cache, state, bodies, bodies%element(k)))
          bodies%mass(3, b) = bodies%mass(3, b) + &
                              dot_product(turn(:, 3), matmul(cache%element(bodies%element(k))%mass_matrix, turn(:, 3)))
        end associate
      end do
      if (.not. has_mass) bodies%mass(3, b) = sum(weight**2)
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

  !> Blocks of bodies that supports leave no motion.
  pure function held_bodies(model, state, part_of) result(held)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: part_of(:)         !! (n_blocks) the block that stands for the body
    logical :: held(size(part_of)), supported(size(part_of))
    integer, allocatable :: support(:)
    real(dp), allocatable :: position(:, :)
    real(dp) :: mobility(3, 3), motion(3), reach(size(part_of))
    integer :: b, left

    supported = supported_bodies(model, part_of)
    reach = reaches_of(model, state, part_of, supported)
    held = .false.
    do b = 1, size(part_of)
      if (.not. supported(b)) cycle
      support = supports_of(model, part_of, b)
      position = state%point(:, model%effects%fixed_point%point(support))
      mobility = diagonal_matrix([1.0_dp, 1.0_dp, 1/reach(b)**2])
      motion = 0.0_dp
      call obey(support_rows(model, support, position, position(:, 1)), mobility, motion, left)
      held(b) = left == 0
    end do
    do b = 1, size(part_of)
      if (part_of(b) > 0) held(b) = held(part_of(b))
    end do
  end function held_bodies

  !> How far bodies with supports reach from the first of these, at the blocks that stand for them, length.
  pure function reaches_of(model, state, part_of, supported) result(reach)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: part_of(:)         !! (n_blocks)
    logical, intent(in) :: supported(:)       !! (n_blocks) of `supported_bodies`
    real(dp) :: reach(size(part_of))
    integer :: first(size(part_of)), i        ! support of a body

    reach = 0.0_dp
    if (.not. any(supported)) return
    associate (point => model%effects%fixed_point%point, outlines => model%outlines)
      do i = size(point), 1, -1
        associate (b => part_of(model%elements%block(model%points%element(point(i)))))
          if (b > 0) first(b) = point(i)
        end associate
      end do
      do i = 1, size(outlines%block)
        associate (b => part_of(outlines%block(i)))
          if (b == 0) cycle
          if (supported(b)) reach(b) = max(reach(b), norm2(state%vertex(:, outlines%start(i)) - state%point(:, first(b))))
        end associate
      end do
    end associate
  end function reaches_of

  !> Which blocks stand for bodies with fixed points or on lines of &support.
  pure function supported_bodies(model, part_of) result(supported)
    type(model_t), intent(in) :: model
    integer, intent(in) :: part_of(:)         !! (n_blocks)
    logical :: supported(size(part_of)), of_block(size(part_of))
    integer :: b

    supported = .false.
    of_block = supported_blocks(model)
    do b = 1, size(part_of)
      if (of_block(b) .and. part_of(b) > 0) supported(part_of(b)) = .true.
    end do
  end function supported_bodies

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
  !> after which c.q = w and P c = 0, so that what comes later changes nothing of it. Those that are wide come first.
  pure subroutine obey(row, mobility, motion, left, rate)
    real(dp), intent(in) :: row(:, :)         !! (3, n)
    real(dp), intent(inout) :: mobility(3, 3), motion(3)
    integer, intent(out) :: left              !! motions that are free
    real(dp), intent(in), optional :: rate(:) !! (n) w, length/time; 0 where absent
    real(dp) :: a(3), free(3, 3), own
    real(dp), parameter :: least(2) = [wide, narrow]
    integer :: i, k, pass

    free = mobility
    left = 3
    do pass = 1, 2
      do i = 1, size(row, 2)
        if (left == 0) exit
        a = matmul(mobility, row(:, i))
        own = dot_product(row(:, i), a)
        if (.not. own > least(pass)*dot_product(row(:, i), matmul(free, row(:, i)))) cycle
        motion = motion - a*dot_product(row(:, i), motion)/own
        if (present(rate) .and. pass == 1) motion = motion + a*rate(i)/own
        do k = 1, 3
          mobility(:, k) = mobility(:, k) - a*a(k)/own
        end do
        left = left - 1
      end do
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

  !> Takes from bodies what supports hold of them.
  pure subroutine hold(model, cache, state, bodies)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(rigid_bodies_t), intent(inout) :: bodies
    real(dp) :: motion(3)
    integer, allocatable :: stands(:), support(:)
    integer :: b, left
    logical :: supported(size(bodies%part_of))

    stands = standing_for(bodies)
    supported = supported_bodies(model, bodies%part_of)
    bodies%supported = supported(stands)
    allocate (bodies%held(size(stands)), source=.false.)
    do b = 1, size(stands)
      if (.not. bodies%supported(b)) cycle
      support = supports_of(model, bodies%part_of, stands(b))
      motion = 0.0_dp
      call obey(support_rows(model, support, places_of(model, cache, state, bodies, support), bodies%centre(:, b)), &
                bodies%mobility(:, :, b), motion, left)
      bodies%held(b) = left == 0
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

  !> Rigid motions q (3, n) of the bodies in a field of rates. A held body has the motion of its supports. A partly held body has
  !> this motion too, and in addition the motion that its supports leave free.
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
      if (bodies%supported(b)) then
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
      if (bodies%supported(b)) motion(:, b) = motion_of_supports(model, cache, state, bodies, b, rates)
    end do
  end function motion_of_holders

  !> Rigid motion of what holds a body in whole or in part.
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

  !> Takes a fraction of the rates of deformation from bodies of one element that nothing holds. Their strain is constant, so their
  !> deformation in a step is no wave that could go on: it vibrates at the infinite frequency of the integrator.
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
      if (bodies%first(b + 1) > bodies%first(b) + 1 .or. bodies%supported(b)) cycle
      associate (e => bodies%element(bodies%first(b)), ids => model%elements%unknown(:, bodies%element(bodies%first(b))))
        change(ids) = change(ids) - share*(rates(ids) - matmul(modes_of(model, cache, state, bodies, e), motion(:, b)))
      end associate
    end do
  end subroutine take_deformation

end module scree_rigid_bodies
