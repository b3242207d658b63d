!> Blocks that a file gives as polygons: taken apart into loops, and refused where they bound no block.
module scree_given_blocks
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_keyholes, only: part_loops
  use scree_kinds, only: dp
  use scree_outline_checks, only: find_wrong_area, folds_back, touches_itself
  use scree_polygon, only: twice_area
  use scree_regions, only: regions_t
  use scree_scene, only: polygons_t
  use scree_text, only: number_text, real_text
  implicit none
  private
  public :: take_polygons

  !> Of the size of a block: corners that are so near are one, by rounding; a run would cut its steps to pass from one to the
  !> other.
  real(dp), parameter :: faint = 1e-8_dp
  !> Of the size of a block: so wide may be what a self-crossing encloses, as the positions of a file may have six digits.
  real(dp), parameter :: coarse = 1e-6_dp
  real(dp), parameter :: least_area = 1e-12_dp !! of the square of its size

contains

  !> Parts polygons at their seams into the loops of regions.
  !>
  !> Errors, with the line of the file: corners that coincide, joint material 0, clockwise or without area, an outline that
  !> folds back, crosses itself or bounds other than one area.
  subroutine take_polygons(file, given, shape, corner, error)
    character(len=*), intent(in) :: file         !! its name
    type(polygons_t), intent(in) :: given
    type(regions_t), intent(out) :: shape
    integer, allocatable, intent(out) :: corner(:) !! (n_vertices) of the polygons
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: first_loop(:), first_vertex(:), loop_order(:), loop_first(:)
    integer :: i, n, n_loops, n_polygons

    n_polygons = size(given%material)
    allocate (corner(size(given%joint)), first_loop(n_polygons + 1), first_vertex(size(given%joint) + 1))
    n = 0
    n_loops = 0
    do i = 1, n_polygons
      associate (from => given%first_vertex(i), to => given%first_vertex(i + 1) - 1)
        call part_loops(given%vertex(:, from:to), loop_order, loop_first)
        call check_outline(file, given, i, from - 1 + loop_order, loop_first, error)
        if (allocated(error)) return
        first_loop(i) = n_loops + 1
        first_vertex(n_loops + 1:n_loops + size(loop_first) - 1) = loop_first(:size(loop_first) - 1) + n
        n_loops = n_loops + size(loop_first) - 1
        corner(n + 1:n + size(loop_order)) = loop_order + from - 1
        n = n + size(loop_order)
      end associate
    end do
    first_loop(n_polygons + 1) = n_loops + 1
    first_vertex(n_loops + 1) = n + 1
    corner = corner(:n)
    shape%first_loop = first_loop
    shape%first_vertex = first_vertex(:n_loops + 1)
    shape%joint = given%joint(corner)
  end subroutine take_polygons

  !> Error where the loops of a polygon bound no block.
  subroutine check_outline(file, given, i, corner, first, error)
    character(len=*), intent(in) :: file
    type(polygons_t), intent(in) :: given
    integer, intent(in) :: i                    !! number of the polygon
    integer, intent(in) :: corner(:), first(:)  !! vertices loop by loop, and where each loop begins among them
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: position(2), size_, vertex(2, size(corner))
    integer :: after, before, k, loop
    logical :: is_wrong

    if (any(first(2:) - first(:size(first) - 1) < 3)) then
      call wrong(outline_line(), 'an outline of block '//number_text(i)//' that does not fold back', 'one that does')
      return
    end if
    vertex = given%vertex(:, corner)
    size_ = maxval(maxval(vertex, 2) - minval(vertex, 2))
    do loop = 1, size(first) - 1
      before = first(loop + 1) - 1
      do k = first(loop), first(loop + 1) - 1
        if (.not. norm2(vertex(:, k) - vertex(:, before)) > faint*size_) then
          call wrong(given%vertex_line(corner(k)), 'corners of block '//number_text(i)//' farther than '//real_text(faint)// &
                     ' of its size from each other', 'one '//real_text(norm2(vertex(:, k) - vertex(:, before)))// &
                     ' from the corner before it')
          return
        else if (given%joint(corner(before)) < 1) then
          call wrong(given%joint_line(corner(before)), 'a joint material of at least 1 for an edge of block '//number_text(i), &
                     number_text(given%joint(corner(before))))
          return
        end if
        before = k
      end do
    end do
    if (.not. twice_area(vertex(:, :first(2) - 1)) > 2*least_area*size_**2) then
      call wrong(outline_line(), 'vertices counter-clockwise around an area', 'block '//number_text(i)//' '//turn())
      return
    end if
    do loop = 1, size(first) - 1
      before = first(loop + 1) - 1
      do k = first(loop), first(loop + 1) - 1
        after = merge(first(loop), k + 1, k + 1 == first(loop + 1))
        if (folds_back(vertex(:, before), vertex(:, k), vertex(:, after), faint*size_)) then
          call wrong(given%vertex_line(corner(k)), 'an outline of block '//number_text(i)//' that does not fold back', &
                     'one that goes straight back at this corner')
          return
        end if
        before = k
      end do
    end do
    is_wrong = size(first) > 2
    if (.not. is_wrong) is_wrong = touches_itself(vertex, first, faint*size_)
    if (.not. is_wrong) return
    call find_wrong_area(vertex, first, faint*size_, coarse*size_, position, is_wrong)
    if (is_wrong) call wrong(outline_line(), 'an outline of block '//number_text(i)//' that runs once around one area', &
                             'one that crosses itself or falls apart, near '//real_text(position(1))//' '//real_text(position(2)))

  contains

    !> Fault of an outline that does not turn counter-clockwise around an area, in words.
    function turn()
      character(len=:), allocatable :: turn

      if (twice_area(vertex(:, :first(2) - 1)) > -2*least_area*size_**2) then
        turn = 'without area, or whose edges cross'
      else if (touches_itself(vertex, first, faint*size_)) then
        turn = 'whose edges cross or touch'
      else
        turn = 'whose vertices go clockwise'
      end if
    end function turn

    !> Line of the file at which the outline begins.
    integer function outline_line()
      outline_line = given%vertex_line(given%first_vertex(i))
    end function outline_line

    !> Error at a line of the file.
    subroutine wrong(line, expected, found)
      integer, intent(in) :: line
      character(len=*), intent(in) :: expected, found

      call fail(error, status_bad_input, file//':'//number_text(line)//': expected '//expected//', found '//found)
    end subroutine wrong

  end subroutine check_outline

end module scree_given_blocks
