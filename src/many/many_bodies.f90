!> The blocks of a DDA scene as rigid bodies made of convex pieces, and back.
!>
!> A block with holes is cut along seams. What cannot move is a body without inverse mass; what a stage has removed has no pieces.
module scree_many_bodies
  use scree_bodies, only: bodies_t
  use scree_convex_pieces, only: cut_into_pieces, pieces_t
  use scree_entrance_block, only: normals_of
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_fixed_point, only: is_roller
  use scree_interpolation, only: turn
  use scree_keyholes, only: join_loops
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_regions, only: first_vertex_of, last_vertex_of, loops_of
  use scree_sorting, only: sort_into
  use scree_state, only: state_t
  use scree_text, only: number_text
  implicit none
  private
  public :: arm_of, cut_bodies, place_corners, put_bodies_back, take_bodies

  integer, parameter :: points_that_hold = 2 !! fixed points by which a rigid body cannot move

contains

  !> Cuts the blocks into convex pieces; without contact there is no need of any.
  !>
  !> Errors: an outline that crosses itself.
  subroutine cut_bodies(model, position, bodies, error)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: position(:, :)      !! (2, n_vertices) at any time, length
    type(bodies_t), intent(out) :: bodies
    type(error_t), allocatable, intent(out) :: error
    integer :: edge_at(size(position, 2))       ! edge of the outlines that begins at each vertex
    integer, allocatable :: order(:)
    type(pieces_t) :: pieces
    integer :: e, i

    edge_at = 0
    if (allocated(model%effects%contact)) edge_at(model%outlines%start) = [(i, i=1, size(model%outlines%start))]
    bodies%n = model%n_blocks
    allocate (bodies%body(0), bodies%corner(0), bodies%face(0))
    bodies%first = [1]
    do e = 1, model%n_elements
      if (.not. (allocated(model%effects%contact) .and. model%present(model%elements%block(e)))) cycle
      associate (from => first_vertex_of(model%elements%shape, e), to => last_vertex_of(model%elements%shape, e))
        order = from - 1 + join_loops(position(:, from:to), loops_of(model%elements%shape, e))
      end associate
      pieces = cut_into_pieces(position(:, order))
      if (size(pieces%first) < 2) then
        call fail(error, status_run_failed, 'block '//number_text(model%elements%block(e))//': its outline crosses itself, and '// &
                  'small steps find no convex pieces of it')
        return
      end if
      bodies%body = [bodies%body, spread(model%elements%block(e), 1, size(pieces%first) - 1)]
      bodies%first = [bodies%first, bodies%first(size(bodies%first)) + pieces%first(2:) - 1]
      bodies%corner = [bodies%corner, order(pieces%vertex)]
      bodies%face = [bodies%face, pieces%face]
    end do
    bodies%n_pieces = size(bodies%body)
    bodies%edge = edge_at(bodies%corner)
    if (allocated(model%effects%contact)) call place_edges(model, position, bodies)
    associate (n => bodies%n, m => size(bodies%corner))
      allocate (bodies%moves(n), source=.false.)
      allocate (bodies%place(2, n), bodies%velocity(2, n), bodies%angle(n), bodies%spin(n), bodies%inverse_mass(n), &
                bodies%inverse_inertia(n), bodies%size(n), bodies%radius(n), source=0.0_dp)
      allocate (bodies%arm(2, m), bodies%own_normal(2, m), bodies%at(2, m), bodies%normal(2, m))
    end associate
  end subroutine cut_bodies

  !> Lengths of the edges of the outlines, and the pieces that have them: an edge of a piece may span several.
  subroutine place_edges(model, position, bodies)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: position(:, :)      !! (2, n_vertices) length
    type(bodies_t), intent(inout) :: bodies
    integer :: edge, end_edge, k, p

    associate (outlines => model%outlines)
      bodies%length = norm2(position(:, outlines%finish) - position(:, outlines%start), 1)
      allocate (bodies%piece_of(size(outlines%start)), bodies%begins_with(size(outlines%start)), &
                bodies%piece_at(size(bodies%corner)), &
                source=0)
      call sort_into(bodies%edge, size(outlines%start), bodies%first_corner, bodies%corners_at)
      do p = 1, bodies%n_pieces
        do k = bodies%first(p), bodies%first(p + 1) - 1
          bodies%piece_at(k) = p
          if (.not. bodies%face(k)) cycle
          end_edge = bodies%edge(k + 1 - merge(bodies%first(p + 1) - bodies%first(p), 0, k + 1 == bodies%first(p + 1)))
          edge = bodies%edge(k)
          do while (edge /= end_edge)
            bodies%piece_of(edge) = p
            bodies%begins_with(edge) = bodies%edge(k)
            edge = outlines%next(edge)
          end do
        end do
      end do
    end associate
  end subroutine place_edges

  !> Takes places, motion and masses from a state, in which the bodies have turned by nothing.
  subroutine take_bodies(model, cache, state, bodies)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(bodies_t), intent(inout) :: bodies
    integer :: b, e, k, p

    bodies%moves = can_move(model)
    bodies%angle = 0.0_dp
    bodies%velocity = 0.0_dp
    bodies%spin = 0.0_dp
    bodies%inverse_mass = 0.0_dp
    bodies%inverse_inertia = 0.0_dp
    bodies%radius = 0.0_dp
    do e = 1, model%n_elements
      b = model%elements%block(e)
      associate (own => cache%element(e))
        bodies%place(:, b) = own%kinematics%centroid
        bodies%size(b) = sqrt(own%kinematics%area)
        if (.not. bodies%moves(b)) cycle
        bodies%velocity(:, b) = state%velocity(model%elements%unknown(1:2, e))
        bodies%spin(b) = state%velocity(model%elements%unknown(3, e))
        bodies%inverse_mass(b) = 1/own%mass
        bodies%inverse_inertia(b) = own%kinematics%area/(own%mass*sum(own%kinematics%second(1:2)))
      end associate
    end do
    do p = 1, bodies%n_pieces
      b = bodies%body(p)
      associate (from => bodies%first(p), to => bodies%first(p + 1) - 1)
        do k = from, to
          bodies%arm(:, k) = state%vertex(:, bodies%corner(k)) - bodies%place(:, b)
          bodies%radius(b) = max(bodies%radius(b), norm2(bodies%arm(:, k)))
        end do
        bodies%own_normal(:, from:to) = normals_of(bodies%arm(:, from:to))
      end associate
    end do
    call place_corners(bodies, all_of_them=.true.)
  end subroutine take_bodies

  !> Which blocks move: those that can, but for rigid ones that two points hold whose places stay.
  pure function can_move(model)
    type(model_t), intent(in) :: model
    logical :: can_move(model%n_blocks)
    integer :: e, held, i, k

    can_move = .false.
    can_move(model%free_block) = .true.
    if (.not. allocated(model%effects%fixed_point)) return
    associate (fixed => model%effects%fixed_point)
      do k = 1, size(model%elements%free)
        e = model%elements%free(k)
        held = 0
        do i = fixed%first(e), fixed%first(e + 1) - 1
          if (.not. (is_roller(fixed, i) .or. allocated(fixed%table(i)%time))) held = held + 1
        end do
        if (held >= points_that_hold) can_move(model%elements%block(e)) = .false.
      end do
    end associate
  end function can_move

  !> Places the corners where their bodies are now.
  subroutine place_corners(bodies, all_of_them)
    type(bodies_t), intent(inout) :: bodies
    logical, intent(in) :: all_of_them          !! those of bodies that cannot move too
    real(dp) :: c, s
    integer :: b, k, p

    !$omp do schedule(static)
    do p = 1, bodies%n_pieces
      b = bodies%body(p)
      if (.not. (bodies%moves(b) .or. all_of_them)) cycle
      c = cos(bodies%angle(b))
      s = sin(bodies%angle(b))
      do k = bodies%first(p), bodies%first(p + 1) - 1
        bodies%at(1, k) = bodies%place(1, b) + c*bodies%arm(1, k) - s*bodies%arm(2, k)
        bodies%at(2, k) = bodies%place(2, b) + s*bodies%arm(1, k) + c*bodies%arm(2, k)
        bodies%normal(1, k) = c*bodies%own_normal(1, k) - s*bodies%own_normal(2, k)
        bodies%normal(2, k) = s*bodies%own_normal(1, k) + c*bodies%own_normal(2, k)
      end do
    end do
    !$omp end do
  end subroutine place_corners

  !> From the centroid of the body of an element to one of its points, as the body has turned since the step of the run began.
  pure function arm_of(cache, state, bodies, element, body, point) result(arm)
    type(cache_t), intent(in) :: cache          !! of the state
    type(state_t), intent(in) :: state          !! when the step of the run began
    type(bodies_t), intent(in) :: bodies
    integer, intent(in) :: element, body, point
    real(dp) :: arm(2)                          !! length

    arm = state%point(:, point) - cache%element(element)%kinematics%centroid
    associate (c => cos(bodies%angle(body)), s => sin(bodies%angle(body)))
      arm = [c*arm(1) - s*arm(2), s*arm(1) + c*arm(2)]
    end associate
  end function arm_of

  !> Moves vertices, points, velocities, rotations and deformation of a state to where the bodies are.
  subroutine put_bodies_back(model, cache, bodies, state)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache          !! of the state as it was
    type(bodies_t), intent(in) :: bodies
    type(state_t), intent(inout) :: state
    real(dp) :: rotation(2, 2)
    integer :: b, e, i, k

    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      b = model%elements%block(e)
      rotation = turn(bodies%angle(b))
      do i = first_vertex_of(model%elements%shape, e), last_vertex_of(model%elements%shape, e)
        state%vertex(:, i) = moved(cache%element(e)%kinematics%centroid, state%vertex(:, i))
      end do
      state%velocity(model%elements%unknown(:, e)) = [bodies%velocity(:, b), bodies%spin(b), 0.0_dp, 0.0_dp, 0.0_dp]
      state%rotation(b) = state%rotation(b) + bodies%angle(b)
      state%deformation(:, e) = reshape(matmul(rotation, reshape(state%deformation(:, e), [2, 2])), [4])
    end do
    do k = 1, size(model%points%free)
      i = model%points%free(k)
      e = model%points%element(i)
      b = model%elements%block(e)
      rotation = turn(bodies%angle(b))
      state%point(:, i) = moved(cache%element(e)%kinematics%centroid, state%point(:, i))
    end do

  contains

    !> Where the body takes a position.
    pure function moved(centre, x)
      real(dp), intent(in) :: centre(2), x(2)   !! length
      real(dp) :: moved(2)

      moved = bodies%place(:, b) + matmul(rotation, x - centre)
    end function moved

  end subroutine put_bodies_back

end module scree_many_bodies
