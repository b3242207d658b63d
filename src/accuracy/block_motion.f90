!> How blocks move, as rigid ones, and when in a step they strike others.
!>
!> A vertex that closes on an edge in a step strikes it at the time t with g = w t + w' t^2/2. Here g is the gap when the step
!> begins and w the speed of approach. w' is its gain: the mean acceleration of the step before, with the effect of turning.
module scree_block_motion
  use scree_contact_geometry, only: frame_of_edge
  use scree_contacts, only: state_open
  use scree_effects, only: supported_blocks
  use scree_inertia, only: momentum
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_pairs, only: pairs_without, sorted_pairs
  use scree_state, only: deviation_t, state_t
  use scree_system, only: values_of
  implicit none
  private
  public :: block_motions_t, motions_of, strike_t, strikes_of

  !> How the blocks move, as rigid ones.
  type :: block_motions_t
    real(dp), allocatable :: centre(:, :)   !! (2, n_blocks) length
    real(dp), allocatable :: velocity(:, :) !! (3, n_blocks) x, y, spin times the radius of gyration, length/time
    real(dp), allocatable :: gyration(:)    !! (n_blocks) radius, length
    real(dp), allocatable :: rotation(:)    !! (n_blocks) rad
    integer, allocatable :: touching(:, :)  !! (2, n) vertices of the outlines that press, and the edges they press on, in order
    logical, allocatable :: held(:)         !! (n_blocks) by fixed points or contacts
  end type block_motions_t

  !> A blow on a block in a step: sums over what closes on it, each weighed by its speed.
  type :: strike_t
    real(dp) :: speed = 0.0_dp              !! of approach, 0: none, length/time
    real(dp) :: gain = 0.0_dp               !! of that, length/time^2
    real(dp) :: at = 0.0_dp                 !! time since the step began, times the speed
    real(dp) :: ahead = 0.0_dp              !! that the estimated errors bring bodies nearer, length
    real(dp) :: faster = 0.0_dp             !! likewise of the speed, length/time
    real(dp) :: arm(2) = 0.0_dp             !! from the centre of the block to the contact, length
  end type strike_t

contains

  !> How the blocks move; those that cannot are at rest.
  pure function motions_of(model, cache, state) result(motion)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(block_motions_t) :: motion
    real(dp), dimension(model%n_blocks) :: mass, polar
    real(dp) :: p(3)
    integer :: b, e, k

    associate (n => model%n_blocks)
      allocate (motion%centre(2, n), motion%velocity(3, n), motion%gyration(n), source=0.0_dp)
    end associate
    motion%rotation = state%rotation
    mass = 0.0_dp
    polar = 0.0_dp
    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      b = model%elements%block(e)
      associate (element => cache%element(e))
        mass(b) = mass(b) + element%mass
        motion%centre(:, b) = motion%centre(:, b) + element%mass*element%kinematics%centroid
      end associate
    end do
    do k = 1, size(model%free_block)
      b = model%free_block(k)
      if (mass(b) > 0) motion%centre(:, b) = motion%centre(:, b)/mass(b)
    end do
    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      b = model%elements%block(e)
      associate (element => cache%element(e), centre => motion%centre(:, b))
        p = momentum(element%kinematics, element%mass, values_of(model%elements, e, state%velocity))
        p(3) = p(3) - centre(1)*p(2) + centre(2)*p(1)
        motion%velocity(:, b) = motion%velocity(:, b) + p
        polar(b) = polar(b) + element%mass*(sum((element%kinematics%centroid - centre)**2) &
                                        + sum(element%kinematics%second(1:2))/element%kinematics%area)
      end associate
    end do
    do k = 1, size(model%free_block)
      b = model%free_block(k)
      if (.not. mass(b) > 0) cycle
      motion%gyration(b) = sqrt(polar(b)/mass(b))
      motion%velocity(:, b) = motion%velocity(:, b)/[mass(b), mass(b), mass(b)*motion%gyration(b)]
    end do
    call find_touching(model, state, motion)
  end function motions_of

  !> Which vertices press on which edges, and which blocks are held by that or by fixed points.
  pure subroutine find_touching(model, state, motion)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(block_motions_t), intent(inout) :: motion
    integer, allocatable :: pair(:, :)
    integer :: i, n

    motion%held = supported_blocks(model)
    n = 0
    if (allocated(model%effects%contact)) n = size(state%contacts%contact)
    allocate (pair(2, n))
    n = 0
    do i = 1, size(pair, 2)
      associate (contact => state%contacts%contact(i), block => model%outlines%block)
        associate (entrance => contact%entrance(contact%active))
          if (entrance%state == state_open) cycle
          n = n + 1
          pair(:, n) = [entrance%vertex, entrance%edge]
          motion%held(block(pair(:, n))) = .true.
        end associate
      end associate
    end do
    motion%touching = sorted_pairs(pair(:, :n))
  end subroutine find_touching

  !> Blows in a step on each block, by what closes in it. What comes no faster than it speeds up in the step is none: loads press.
  pure function strikes_of(model, before, after, began, dt, deviation) result(strike)
    type(model_t), intent(in) :: model
    type(block_motions_t), intent(in) :: before, after   !! at both ends of the step
    type(state_t), intent(in) :: began            !! at its beginning
    real(dp), intent(in) :: dt                    !! time
    type(deviation_t), intent(in) :: deviation    !! when the step began
    type(strike_t) :: strike(model%n_blocks)
    type(strike_t) :: one
    integer, allocatable :: closed(:, :)          !! (2, n)
    integer :: b, i, side

    closed = pairs_without(after%touching, before%touching)
    do i = 1, size(closed, 2)
      one = strike_of(model, before, began, closed(1, i), closed(2, i), dt, deviation)
      if (.not. one%speed > 0) cycle
      do side = 1, 2
        b = model%outlines%block(closed(side, i))
        one%arm = began%vertex(:, model%outlines%start(closed(1, i))) - before%centre(:, b)
        call add(one, strike(b))
      end do
    end do

  contains

    !> Adds a blow to the sum of those on a block, each weighed by its speed.
    pure subroutine add(one, total)
      type(strike_t), intent(in) :: one
      type(strike_t), intent(inout) :: total

      total = strike_t(total%speed + one%speed, total%gain + one%gain, total%at + one%at, total%ahead + one%ahead, &
                       total%faster + one%faster, total%arm + one%speed*one%arm)
    end subroutine add

  end function strikes_of

  !> The blow of the vertex that edge i begins with on another edge.
  pure type(strike_t) function strike_of(model, before, began, i, edge, dt, deviation) result(one)
    type(model_t), intent(in) :: model
    type(block_motions_t), intent(in) :: before
    type(state_t), intent(in) :: began
    integer, intent(in) :: i, edge
    real(dp), intent(in) :: dt                    !! time
    type(deviation_t), intent(in) :: deviation
    real(dp) :: gap, length, normal(2), t(2), time

    associate (outlines => model%outlines, vertex => began%vertex(:, model%outlines%start(i)))
      associate (corner => began%vertex(:, outlines%start(edge)), block => outlines%block([i, edge]))
        call frame_of_edge(corner, began%vertex(:, outlines%finish(edge)), t, normal, length)
        gap = max(0.0_dp, dot_product(normal, vertex - corner))
        one%speed = -dot_product(normal, apart(before%velocity, block, vertex))
        one%gain = -dot_product(normal, apart(deviation%acceleration, block, vertex) &
                                - inwards(block(1), vertex) + inwards(block(2), vertex))
        one%ahead = -dot_product(normal, apart(deviation%place, block, vertex))
        one%faster = -dot_product(normal, apart(deviation%motion, block, vertex))
      end associate
    end associate
    time = 2*gap/max(tiny(gap), one%speed + sqrt(max(0.0_dp, one%speed**2 + 2*one%gain*gap)))
    if (.not. one%speed > abs(one%gain)*dt) one = strike_t()
    one%at = one%speed*min(time, dt)

  contains

    !> What the two blocks differ in at a position.
    pure function apart(q, block, position)
      real(dp), intent(in) :: q(:, :)             !! (3, n_blocks)
      integer, intent(in) :: block(2)
      real(dp), intent(in) :: position(2)         !! length
      real(dp) :: apart(2)

      apart = there(q(:, block(1)), block(1), position) - there(q(:, block(2)), block(2), position)
    end function apart

    !> Of x, y and the rotation times the radius of gyration of block b, what that is at a position.
    pure function there(q, b, position)
      real(dp), intent(in) :: q(3)
      integer, intent(in) :: b
      real(dp), intent(in) :: position(2)         !! length
      real(dp) :: there(2)

      there = q(:2)
      if (before%gyration(b) > 0) there = there + q(3)/before%gyration(b)*[before%centre(2, b) - position(2), &
                                                                         position(1) - before%centre(1, b)]
    end function there

    !> Acceleration of a position on block b towards its centre as it turns.
    pure function inwards(b, position)
      integer, intent(in) :: b
      real(dp), intent(in) :: position(2)         !! length
      real(dp) :: inwards(2)

      inwards = 0.0_dp
      if (before%gyration(b) > 0) inwards = (before%velocity(3, b)/before%gyration(b))**2*(position - before%centre(:, b))
    end function inwards

  end function strike_of

end module scree_block_motion
