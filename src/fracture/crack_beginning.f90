!> Cracks that begin: at outlines of blocks, holes and notches, where the mean tension over the half disc inwards has reached the
!> tensile strength of the rock.
!>
!> A place of an outline is the tip of a crack that has no length yet. So a crack begins by the criterion by which it grows
!> (`scree_mean_tension`): the average stress criterion (Whitney and Nuismer 1974), over a half disc in place of a line.
module scree_crack_beginning
  use scree_block_finder, only: block_finder_t
  use scree_block_input, only: blocks_t
  use scree_crack_piece, only: find_end, growth_t
  use scree_crack_tip, only: crack_start_t
  use scree_crack_tips, only: longest_side
  use scree_kinds, only: dp, pi
  use scree_mean_tension, only: find_tension, largest_principal, mean_stress_before
  use scree_model, only: model_t
  use scree_polygon, only: distance_to_segment
  use scree_regions, only: first_vertex_of, last_vertex_of, loops_of, vertices_after
  use scree_sorting, only: sort_by
  use scree_state, only: state_t
  use scree_system, only: system_t
  implicit none
  private
  public :: begin_cracks, find_starts

  real(dp), parameter :: same = 1e-9_dp !! of the extent: places that are nearer to each other are one
  !> Least angle between a crack and the outline where it begins, rad: half that of a triangle of equal sides. A flatter crack would
  !> peel off a sliver. Tension across an outline is that of a load or support there, whose joint with the rock is no part of it.
  real(dp), parameter :: least_angle = pi/6
  !> Tensions that differ by less are the same, as those along a bar are but for round-off.
  real(dp), parameter :: same_tension = 1e-6_dp

contains

  !> Finds the places of outlines where cracks may begin: the corners, and where sides of triangles of the mesh end.
  subroutine find_starts(blocks, system, vertex, cover, starts)
    type(blocks_t), intent(in) :: blocks
    class(system_t), intent(in) :: system
    real(dp), intent(in) :: vertex(:, :)       !! (2, n_vertices) of the elements at the start, length
    real(dp), intent(in) :: cover(:, :)        !! (2, n_covers) nodes of the covers at the start, length
    type(crack_start_t), allocatable, intent(out) :: starts(:) !! in the order of the outlines
    real(dp), allocatable :: corner(:, :), way(:)
    integer, allocatable :: at(:), element(:), mine(:), next(:), on_edge(:)
    real(dp) :: along(2), back(2), length, reach, shift(2)
    integer :: b, i, k

    allocate (starts(0))
    reach = same*system%extent
    shift = blocks%origin - system%origin
    call list_faces(system, at, element)
    do b = 1, system%n_blocks
      mine = pack([(i, i=1, size(at))], system%elements%block(element) == b)
      next = vertices_after(loops_of(blocks%shape, b))
      corner = blocks%vertex(:, first_vertex_of(blocks%shape, b):last_vertex_of(blocks%shape, b)) + spread(shift, 2, size(next))
      do k = 1, size(next)
        along = corner(:, next(k)) - corner(:, k)
        length = norm2(along)
        along = along/length
        way = [(dot_product(vertex(:, at(mine(i))) - corner(:, k), along), i=1, size(mine))]
        on_edge = pack(mine, way >= -reach .and. way < length - reach .and. &
                       [(norm2(vertex(:, at(mine(i))) - corner(:, k) - way(i)*along) <= reach, i=1, size(mine))])
        way = [(dot_product(vertex(:, at(on_edge(i))) - corner(:, k), along), i=1, size(on_edge))]
        call sort_by(way, on_edge)
        back = corner(:, findloc(next, k, 1)) - corner(:, k) ! from a corner
        do i = 1, size(on_edge)
          if (i > 1) then
            if (way(i) - way(i - 1) <= reach) cycle
          end if
          call add_start(vertex(:, at(on_edge(i))), along, merge(back, -along, way(i) <= reach), element(on_edge(i)))
        end do
      end do
    end do

  contains

    !> Adds a place between two ways along the outline, with the block to the left of that onwards.
    subroutine add_start(place, onwards, back, e)
      real(dp), intent(in) :: place(2), onwards(2), back(2)
      integer, intent(in) :: e
      type(crack_start_t) :: start
      real(dp) :: half                         !! of the angle of the block there

      half = modulo(atan2(onwards(1)*back(2) - onwards(2)*back(1), dot_product(onwards, back)), 2*pi)/2
      if (half < least_angle) return
      start%place = place
      start%inward = cos(half)*onwards + sin(half)*[-onwards(2), onwards(1)]
      start%swing = half - least_angle
      start%element = e
      start%block = b
      start%edge = longest_side(cover(:, system%elements%cover(:3, e)))
      starts = [starts, start]
    end subroutine add_start

  end subroutine find_starts

  !> Lists the ends of edges of elements that are faces, once for each edge, and the elements.
  pure subroutine list_faces(system, at, element)
    class(system_t), intent(in) :: system
    integer, allocatable, intent(out) :: at(:)       !! (n) vertex of the elements
    integer, allocatable, intent(out) :: element(:)  !! (n)
    integer, allocatable :: next(:)
    integer :: before, e, k, n

    associate (shape => system%elements%shape)
      allocate (at(2*count(shape%joint > 0)), element(2*count(shape%joint > 0)))
      n = 0
      do e = 1, system%n_elements
        before = first_vertex_of(shape, e) - 1
        next = vertices_after(loops_of(shape, e))
        do k = 1, size(next)
          if (shape%joint(before + k) == 0) cycle
          at(n + 1:n + 2) = before + [k, next(k)]
          element(n + 1:n + 2) = e
          n = n + 2
        end do
      end do
    end associate
  end subroutine list_faces

  !> Adds to some growth the cracks that begin in a state, at most one a block: where the mean tension is largest. Of places with
  !> the same tension it is that nearest to the mean of all places of the block, as a bar breaks in its middle.
  !>
  !> Nearer than the length of the mean to a crack none begins. The tension there is that before its tip, which has the criterion of
  !> growth, or the crack has let it go.
  subroutine begin_cracks(model, state, finder, is_relieved, growth)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(block_finder_t), intent(in) :: finder   !! of the elements at the start
    logical, intent(in) :: is_relieved(:)        !! (n_blocks) by a crack that grows
    type(growth_t), intent(inout) :: growth
    real(dp) :: direction(2, size(model%crack_start)), middle(2), strained(model%n_elements), tension(size(model%crack_start))
    integer, allocatable :: hot(:), mine(:)
    integer :: b, best, e, i, number

    associate (strength => model%settings%crack_strength(model%elements%material))
      strained = [(largest_principal(state%stress(:, e)), e=1, model%n_elements)]
      hot = pack([(e, e=1, model%n_elements)], strength > 0 .and. strained >= strength)
    end associate
    if (size(hot) == 0) return
    do i = 1, size(model%crack_start)
      tension(i) = 0.0_dp ! where none begins
      associate (start => model%crack_start(i))
        if (is_relieved(start%block) .or. .not. may_break(start)) cycle
        call find_tension(mean_stress_before(start%place, start%inward, start%block, model%settings%crack_length, finder, model, &
                                             state), start%inward, tension(i), direction(:, i))
        if (tension(i) < model%settings%crack_strength(model%elements%material(start%element)) .or. &
            dot_product(direction(:, i), start%inward) < cos(start%swing)) tension(i) = 0.0_dp
      end associate
    end do
    number = maxval([0, model%tip%number])
    if (allocated(state%cracks)) number = max(number, maxval(state%cracks%tip))
    do b = 1, model%n_blocks
      mine = pack([(i, i=1, size(tension))], model%crack_start%block == b)
      if (.not. any(tension(mine) > 0)) cycle
      middle = [(sum(model%crack_start(mine)%place(i))/size(mine), i=1, 2)]
      mine = pack(mine, tension(mine) >= (1 - same_tension)*maxval(tension(mine)))
      best = mine(minloc([(norm2(model%crack_start(mine(i))%place - middle), i=1, size(mine))], 1))
      number = number + 1
      call begin_crack(model%crack_start(best), direction(:, best), number, finder, model, growth)
    end do

  contains

    !> Whether the mean tension before a place may have reached the strength: it is at most the largest of the elements near there.
    pure logical function may_break(start)
      type(crack_start_t), intent(in) :: start
      real(dp) :: beside(2)
      integer :: k, t

      may_break = .false.
      do t = 1, size(model%tip)
        if (model%tip(t)%block /= start%block) cycle
        associate (path => model%tip(t)%path)
          do k = 2, size(path, 2)
            if (distance_to_segment(start%place, path(:, k - 1), path(:, k)) < model%settings%crack_length) return
          end do
        end associate
      end do
      do k = 1, size(hot)
        if (model%elements%block(hot(k)) /= start%block) cycle
        associate (corner => model%start(:, first_vertex_of(model%elements%shape, hot(k)): &
                                         last_vertex_of(model%elements%shape, hot(k))))
          beside = max(0.0_dp, minval(corner, 2) - start%place, start%place - maxval(corner, 2))
        end associate
        may_break = norm2(beside) <= model%settings%crack_length
        if (may_break) return
      end do
    end function may_break

  end subroutine begin_cracks

  !> Adds the pieces by which a crack begins, from element to element in one direction, to the end of the half disc: the rock fails
  !> over the length over which its tension is averaged. A shorter crack would depend on the mesh, and stop where tension falls
  !> inwards, as in bending.
  subroutine begin_crack(start, direction, number, finder, model, growth)
    type(crack_start_t), intent(in) :: start
    real(dp), intent(in) :: direction(2)         !! of length 1
    integer, intent(in) :: number                !! of its tip
    type(block_finder_t), intent(in) :: finder
    type(model_t), intent(in) :: model
    type(growth_t), intent(inout) :: growth
    real(dp) :: end(2), from(2)
    logical :: is_there

    end = start%place
    do while (norm2(end - start%place) < model%settings%crack_length)
      from = end
      call find_end(from, direction, start%edge, start%block, finder, model, end, is_there)
      if (.not. is_there) return
      growth%piece = reshape([growth%piece, from, end], [4, size(growth%tip) + 1])
      growth%tip = [growth%tip, 0]
      growth%number = [growth%number, number]
      growth%joint = [growth%joint, model%settings%crack_begin_joint]
    end do
  end subroutine begin_crack

end module scree_crack_beginning
