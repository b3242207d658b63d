!> Which blocks touch when a run begins, and which sides of blocks nothing holds up.
module scree_initial_contacts
  use scree_contact_detection, only: find_contacts
  use scree_contact_geometry, only: frame_of_edge
  use scree_contact_try, only: contact_try_t
  use scree_contacts, only: contact_memory_t, contact_search_t, contact_t, parallel, rules_coulomb
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_sets, only: root_of, unite
  use scree_sorting, only: sort_by
  use scree_state, only: state_t
  implicit none
  private
  public :: free_lengths, initial_contacts, reached_from

  real(dp), parameter :: flush = 1e-2_dp !! of an edge: a gap or an overlap of faces that lie on each other

contains

  !> What touches, were all at rest, by scree's rules also where the run has Shi's. Nothing where no contact is asked for.
  subroutine initial_contacts(model, state, contact, candidate)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(contact_t), allocatable, intent(out) :: contact(:)
    integer, allocatable, intent(out) :: candidate(:, :) !! (2, n) vertices and edges that are close to each other
    type(contact_memory_t) :: memory
    type(contact_search_t) :: search
    type(contact_try_t) :: contacts
    real(dp), allocatable :: at_rest(:, :)

    allocate (contact(0), candidate(2, 0), memory%contact(0))
    if (.not. allocated(state%contacts%contact)) return
    contacts%law = model%effects%contact
    contacts%law%rules = rules_coulomb
    memory%inside = state%contacts%inside
    allocate (at_rest(2, size(model%outlines%start)), source=0.0_dp)
    call find_contacts(model%outlines, state%vertex, at_rest, model%n_elements > model%n_blocks, memory, search, contacts)
    contact = contacts%contact
    candidate = reshape([search%candidate, memory%inside], [2, size(search%candidate, 2) + size(memory%inside, 2)])
  end subroutine initial_contacts

  !> Blocks that contacts lead to from some blocks, these included.
  pure function reached_from(model, contact, begin) result(reached)
    type(model_t), intent(in) :: model
    type(contact_t), intent(in) :: contact(:)
    logical, intent(in) :: begin(:)     !! (n_blocks)
    logical :: reached(size(begin))
    integer :: root(size(begin)), i, k

    root = [(i, i=1, size(begin))]
    do i = 1, size(contact)
      do k = 1, contact(i)%n_entrances
        associate (entrance => contact(i)%entrance(k), block => model%outlines%block)
          call unite(root, block(entrance%vertex), block(entrance%edge))
        end associate
      end do
    end do
    reached = .false.
    do i = 1, size(begin)
      root(i) = root_of(root, i)
      if (begin(i)) reached(root(i)) = .true.
    end do
    reached = reached(root)
  end function reached_from

  !> Length of each edge of the elements that no other body lies on; 0 of lines of the mesh.
  pure function free_lengths(model, state, candidate) result(free)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: candidate(:, :)    !! (2, n) vertices and edges that are close to each other
    real(dp) :: free(size(state%vertex, 2))   !! (n_vertices) of the edge that begins at each vertex, length
    real(dp), allocatable :: key(:)
    integer, allocatable :: a(:), b(:), order(:)
    real(dp) :: common
    integer :: i, k, next, n

    free = 0.0_dp
    associate (shape => model%elements%shape, x => state%vertex)
      do i = 1, size(shape%first_vertex) - 1
        do k = shape%first_vertex(i), shape%first_vertex(i + 1) - 1
          next = merge(shape%first_vertex(i), k + 1, k + 1 == shape%first_vertex(i + 1))
          if (shape%joint(k) > 0) free(k) = norm2(x(:, next) - x(:, k))
        end do
      end do
    end associate
    if (size(candidate, 2) == 0) return
    associate (outlines => model%outlines, corner => candidate(1, :), edge => candidate(2, :))
      ! of two faces that lie on each other one has a corner at the other: its edge before or after that corner
      a = [corner, outlines%previous(corner)]
      b = [edge, edge]
      n = size(outlines%start)
      key = real(min(a, b), dp)*n + max(a, b)
      order = [(i, i=1, size(key))]
      call sort_by(key, order)
      do i = 1, size(key)
        if (i > 1) then
          if (.not. key(i) - key(i - 1) > 0.5_dp) cycle
        end if
        common = flush_length(a(order(i)), b(order(i)))
        associate (at => outlines%start([a(order(i)), b(order(i))]))
          free(at) = max(0.0_dp, free(at) - common)
        end associate
      end do
    end associate

  contains

    !> Length that two edges of the outlines have in common where they lie on each other, 0 where they do not.
    pure real(dp) function flush_length(a, b)
      integer, intent(in) :: a, b
      real(dp) :: t(2), normal(2), length, other(2, 2), along(2)

      associate (x => state%vertex, outlines => model%outlines)
        call frame_of_edge(x(:, outlines%start(a)), x(:, outlines%finish(a)), t, normal, length)
        other(:, 1) = x(:, outlines%finish(b)) - x(:, outlines%start(a))
        other(:, 2) = x(:, outlines%start(b)) - x(:, outlines%start(a))
      end associate
      along = matmul(t, other)
      flush_length = 0.0_dp
      if (along(2) - along(1) < cos(parallel)*norm2(other(:, 2) - other(:, 1))) return ! not against each other
      if (minval(abs(matmul(normal, other))) > flush*min(length, along(2) - along(1))) return
      flush_length = max(0.0_dp, min(length, along(2)) - max(0.0_dp, along(1)))
    end function flush_length

  end function free_lengths

end module scree_initial_contacts
