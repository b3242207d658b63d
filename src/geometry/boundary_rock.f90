!> Rock and air of a map: the boundary lines enclose the rock, and regions that other lines enclose outside of it are air.
module scree_boundary_rock
  use scree_kinds, only: dp
  use scree_line_cutting, only: graph_t
  use scree_sets, only: root_of, unite
  use scree_text, only: append, number_text, place_text, short_text, text_t
  implicit none
  private
  public :: boundary_t, boundary_warning, is_air, lone_ends, outside_text

  !> A warning names as many places at most.
  integer, parameter :: most_places = 4

  !> The regions that lines enclose, divided by the boundary lines into rock and air.
  type :: boundary_t
    integer :: n_outside = 0                !! regions outside of the boundary lines, which are left out
    real(dp) :: area = 0.0_dp               !! theirs, length^2
    real(dp) :: largest(2) = 0.0_dp         !! centroid of the largest in the coordinates of the deck, length
    logical :: encloses = .true.            !! false: the boundary lines enclose no rock, and every region is a block
    real(dp), allocatable :: lone_end(:, :) !! (2, n) where boundary lines that enclose no rock meet no other line, length
    logical, allocatable :: has_hole(:)     !! (n_hole_points) whose region is left out
    real(dp) :: scale = 0.0_dp              !! of the lines, length
  end type boundary_t

contains

  !> Whether each region of a planar graph is air: a way leads there from outside of all lines that crosses no boundary line.
  !>
  !> Regions are united across the pieces of all other lines. What is united with the outside is air.
  pure function is_air(n_regions, n_boundary, beside, graph)
    integer, intent(in) :: n_regions
    integer, intent(in) :: n_boundary      !! lines, the first, that are boundary
    integer, intent(in) :: beside(:, :)    !! (2, n_pieces) region left and right of each piece, 0: outside of all lines
    type(graph_t), intent(in) :: graph
    logical :: is_air(n_regions)
    integer :: i, root(n_regions + 1)      !! the first is the outside

    root = [(i, i=1, n_regions + 1)]
    do i = 1, size(graph%line)
      if (graph%line(i) > n_boundary) call unite(root, beside(1, i) + 1, beside(2, i) + 1)
    end do
    is_air = [(root_of(root, i + 1) == 1, i=1, n_regions)]
  end function is_air

  !> Places at which a boundary line ends and meets no other line, (2, n), length.
  pure function lone_ends(n_boundary, graph) result(place)
    integer, intent(in) :: n_boundary      !! lines, the first, that are boundary
    type(graph_t), intent(in) :: graph
    real(dp), allocatable :: place(:, :)
    integer :: i, k, n_pieces(size(graph%position, 2))
    logical :: bounds(size(n_pieces))

    n_pieces = 0
    bounds = .false.
    do i = 1, size(graph%line)
      do k = 1, 2
        n_pieces(graph%ends(k, i)) = n_pieces(graph%ends(k, i)) + 1
        if (graph%line(i) <= n_boundary) bounds(graph%ends(k, i)) = .true.
      end do
    end do
    place = graph%position(:, pack([(i, i=1, size(n_pieces))], bounds .and. n_pieces == 1))
  end function lone_ends

  !> One line where regions outside of the boundary lines are left out, or where the boundary lines enclose no rock; else none.
  pure function boundary_warning(boundary) result(warning)
    type(boundary_t), intent(in) :: boundary
    type(text_t), allocatable :: warning(:)
    character(len=:), allocatable :: places
    integer :: i

    allocate (warning(0))
    if (boundary%n_outside > 0) then
      call append(warning, 'the boundary lines enclose the rock: '//outside_text(boundary)// &
                  '; a deck with 0 boundary lines (nb) keeps such blocks')
    else if (.not. boundary%encloses) then
      places = ''
      do i = 1, min(size(boundary%lone_end, 2), most_places)
        places = places//' '//place_text(boundary%lone_end(:, i), boundary%scale)
      end do
      if (len(places) > 0) places = ' and meet no other line at'//places
      call append(warning, 'expected boundary lines that enclose rock, found lines that enclose none'//places// &
                  ': blocks are what all lines enclose')
    end if
  end function boundary_warning

  !> The regions outside of the boundary lines, in words.
  pure function outside_text(boundary) result(text)
    type(boundary_t), intent(in) :: boundary
    character(len=:), allocatable :: text

    text = 'left out '//number_text(boundary%n_outside)//trim(merge(' block ', ' blocks', boundary%n_outside == 1))// &
           ' outside of it, of area '//short_text(boundary%area)//', the largest about '// &
           place_text(boundary%largest, boundary%scale)
  end function outside_text

end module scree_boundary_rock
