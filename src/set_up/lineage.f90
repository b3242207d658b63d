!> What the parts of a model come from, where a cut has made them of those of a model before.
!>
!> Both models cover the same rock with the same mathematical mesh. An element that a cut makes is part of one element before: both
!> lie in one triangle and one block. Its covers are those of that element, corner by corner, or copies of them.
module scree_lineage
  use scree_block_finder, only: block_at, block_finder_t, set_up_finder
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_polygon, only: distance_to_segment, inner_place
  use scree_regions, only: first_vertex_of, last_vertex_of, loops_of
  use scree_sorting, only: sort_into
  implicit none
  private
  public :: lineage_of, lineage_t, same_lineage

  !> Of the extent of the model: places that differ by less are one, as a cut rounds them anew.
  real(dp), parameter :: rounding = 1e-12_dp

  !> Parts of the model before, by the parts of the model.
  type :: lineage_t
    integer, allocatable :: block(:)       !! (n_blocks)
    integer, allocatable :: element(:)     !! (n_elements)
    integer, allocatable :: vertex(:)      !! (n_vertices) of the same place in that element; 0: a new one
    integer, allocatable :: cover(:)       !! (n_covers)
    integer, allocatable :: edge(:)        !! (n_edges) of the outlines; 0: a new face
  end type lineage_t

contains

  !> Lineage of a model whose parts are those of the model before, number by number.
  pure type(lineage_t) function same_lineage(model) result(lineage)
    type(model_t), intent(in) :: model
    integer :: i, n_edges

    n_edges = 0
    if (allocated(model%outlines%start)) n_edges = size(model%outlines%start)
    lineage%block = [(i, i=1, model%n_blocks)]
    lineage%element = [(i, i=1, model%n_elements)]
    lineage%vertex = [(i, i=1, size(model%start, 2))]
    lineage%cover = [(i, i=1, model%n_covers)]
    lineage%edge = [(i, i=1, n_edges)]
  end function same_lineage

  !> Lineage of a model that further cuts have made.
  type(lineage_t) function lineage_of(before, model) result(lineage)
    type(model_t), intent(in) :: before, model
    type(block_finder_t) :: finder
    real(dp) :: near
    integer :: e, k

    near = rounding*maxval(maxval(before%start, 2) - minval(before%start, 2))
    allocate (lineage%block(model%n_blocks), lineage%element(model%n_elements))
    allocate (lineage%vertex(size(model%start, 2)), lineage%cover(model%n_covers))
    call set_up_finder(finder, before%elements%shape, before%start, near)
    do e = 1, model%n_elements
      associate (first => first_vertex_of(model%elements%shape, e), last => last_vertex_of(model%elements%shape, e))
        associate (parent => lineage%element(e))
          parent = block_at(finder, before%elements%shape, before%start, &
                            inner_place(model%start(:, first:last), loops_of(model%elements%shape, e)))
          lineage%block(model%elements%block(e)) = before%elements%block(parent)
          lineage%cover(model%elements%cover(:, e)) = before%elements%cover(:, parent)
          do k = first, last
            lineage%vertex(k) = vertex_at(before, parent, model%start(:, k), near)
          end do
        end associate
      end associate
    end do
    allocate (lineage%edge(0))
    if (allocated(model%outlines%start)) lineage%edge = edges_of(before, model, lineage%element, near)
  end function lineage_of

  !> The vertex of an element at a place, 0 where it has none there.
  pure integer function vertex_at(model, e, place, near) result(vertex)
    type(model_t), intent(in) :: model
    integer, intent(in) :: e
    real(dp), intent(in) :: place(2)       !! at the start, length
    real(dp), intent(in) :: near           !! length
    integer :: k

    vertex = 0
    do k = first_vertex_of(model%elements%shape, e), last_vertex_of(model%elements%shape, e)
      if (norm2(model%start(:, k) - place) <= near) vertex = k
    end do
  end function vertex_at

  !> The edge of the outlines before that each edge is part of, 0 of a new face.
  pure function edges_of(before, model, parent, near) result(edge)
    type(model_t), intent(in) :: before, model
    integer, intent(in) :: parent(:)       !! (n_elements)
    real(dp), intent(in) :: near           !! length
    integer :: edge(size(model%outlines%start))
    integer, allocatable :: first(:), list(:)
    real(dp) :: along(2), middle(2)
    integer :: i, j, k

    edge = 0
    if (.not. allocated(before%outlines%start)) return
    call sort_into(before%outlines%element, before%n_elements, first, list)
    do j = 1, size(edge)
      associate (e => parent(model%outlines%element(j)), from => model%start(:, model%outlines%start(j)), &
                 to => model%start(:, model%outlines%finish(j)))
        middle = 0.5_dp*(from + to)
        do k = first(e), first(e + 1) - 1
          i = list(k)
          associate (a => before%start(:, before%outlines%start(i)), b => before%start(:, before%outlines%finish(i)))
            along = b - a
            if (distance_to_segment(middle, a, b) <= near .and. dot_product(to - from, along) > 0) edge(j) = i
          end associate
        end do
      end associate
    end do
  end function edges_of

end module scree_lineage
