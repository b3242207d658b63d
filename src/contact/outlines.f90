!> The outlines of bodies, from the polygons of their elements.
module scree_outlines
  use scree_contacts, only: outlines_t
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_kinds, only: dp
  use scree_regions, only: region_count, regions_t
  use scree_sorting, only: sort_by
  use scree_text, only: number_text
  implicit none
  private
  public :: make_outlines

contains

  !> Edges that are no line of the mesh, and which follows which around the body.
  !>
  !> Where an edge ends at a line of the mesh, the outline goes on in the neighbour across it, or in the one beyond, around
  !> the vertex. Elements have the vertices of a common edge at the same places to the last bit.
  !> Errors: a line of the mesh with an element on one side alone.
  pure subroutine make_outlines(shape, vertex, block, outlines, error)
    type(regions_t), intent(in) :: shape    !! of the elements
    real(dp), intent(in) :: vertex(:, :)    !! (2, n_vertices) at the start, length
    integer, intent(in) :: block(:)         !! (n_elements)
    type(outlines_t), intent(out) :: outlines
    type(error_t), allocatable, intent(out) :: error
    integer :: after(size(vertex, 2)), element(size(vertex, 2)), number(size(vertex, 2))
    integer, allocatable :: inner(:)
    real(dp), allocatable :: x(:)
    integer :: e, i, k, loop, n

    do e = 1, region_count(shape)
      do loop = shape%first_loop(e), shape%first_loop(e + 1) - 1
        do k = shape%first_vertex(loop), shape%first_vertex(loop + 1) - 1
          after(k) = k + 1
          element(k) = e
        end do
        after(shape%first_vertex(loop + 1) - 1) = shape%first_vertex(loop)
      end do
    end do
    number = 0
    outlines%start = pack([(k, k=1, size(number))], shape%joint > 0)
    n = size(outlines%start)
    number(outlines%start) = [(i, i=1, n)]
    outlines%element = element(outlines%start)
    outlines%block = block(outlines%element)
    outlines%finish = after(outlines%start)
    outlines%joint = shape%joint(outlines%start)

    inner = pack([(k, k=1, size(number))], shape%joint == 0)
    x = vertex(1, inner)
    call sort_by(x, inner)
    allocate (outlines%next(n), outlines%previous(n))
    do i = 1, n
      k = outlines%finish(i)
      do while (number(k) == 0)
        k = other_side(k)
        if (k == 0) then
          call fail(error, status_run_failed, 'an element of block '//number_text(outlines%block(i))// &
                    ' has no neighbour across a line of the mesh')
          return
        end if
        k = after(k)
      end do
      outlines%next(i) = number(k)
      outlines%previous(number(k)) = i
    end do

  contains

    !> The same edge of the mesh, as the element across it runs through it; 0 where there is none.
    pure integer function other_side(k)
      integer, intent(in) :: k
      integer :: high, i_edge, low, middle

      low = 1
      high = size(x)
      do while (low < high)
        middle = (low + high)/2
        if (x(middle) < vertex(1, after(k))) then
          low = middle + 1
        else
          high = middle
        end if
      end do
      do i_edge = low, size(x)
        other_side = inner(i_edge)
        if (all(same(vertex(:, other_side), vertex(:, after(k)))) .and. all(same(vertex(:, after(other_side)), vertex(:, k))) &
            .and. block(element(other_side)) == block(element(k))) return
      end do
      other_side = 0
    end function other_side

    !> Whether two numbers are one, to the last bit.
    pure elemental logical function same(a, b)
      real(dp), intent(in) :: a, b

      same = .not. (a < b .or. b < a)
    end function same

  end subroutine make_outlines

end module scree_outlines
