!> Shi's block file (what his dc writes and his df reads): polygons, and points with the blocks that carry them.
!>
!> Layout, number by number, in doc/decks.md. The points are `x y n`, or `type x y n` as the derivative ntdda writes;
!> the count of numbers tells which.
module scree_block_file
  use scree_deck_text, only: deck_t, expect, expect_end, next_count, next_index, next_real, next_reals, numbers_left
  use scree_errors, only: error_t
  use scree_kinds, only: dp
  use scree_scene, only: point_t, polygons_t, scene_t
  use scree_text, only: number_text
  implicit none
  private
  public :: read_block_file

contains

  !> Reads a block file into the scene. Errors: what is not as the layout says, with its line.
  subroutine read_block_file(deck, scene, error)
    type(deck_t), intent(inout) :: deck
    type(scene_t), intent(inout) :: scene
    type(error_t), allocatable, intent(out) :: error
    integer :: i, n_blocks, n_bolts, n_fixed, n_loads, n_measured, n_points, n_rows
    integer, allocatable :: first(:), last(:), line(:), material(:)
    real(dp), allocatable :: row(:, :)
    logical :: typed

    call next_count(deck, 'blocks', 3, n_blocks, error, least=1)
    if (allocated(error)) return
    call next_index(deck, 'the number of bolts', n_bolts, error)
    if (allocated(error)) return
    if (n_bolts > 0) then
      call expect(deck, '0 bolts, as bolts are not simulated', number_text(n_bolts), error)
      return
    end if
    call next_count(deck, 'vertex rows', 3, n_rows, error, least=1)
    if (allocated(error)) return
    call next_count(deck, 'fixed points', 3, n_fixed, error)
    if (allocated(error)) return
    call next_count(deck, 'load points', 3, n_loads, error)
    if (allocated(error)) return
    call next_count(deck, 'measured points', 3, n_measured, error)
    if (allocated(error)) return

    allocate (first(n_blocks), last(n_blocks), material(n_blocks), line(n_blocks))
    do i = 1, n_blocks
      call next_index(deck, 'the material of block '//number_text(i), material(i), error, least=1)
      if (allocated(error)) return
      line(i) = deck%line(deck%at)
      call next_index(deck, 'the first vertex row of block '//number_text(i), first(i), error, least=1, most=n_rows)
      if (allocated(error)) return
      call next_index(deck, 'the last vertex row of block '//number_text(i)//' (a block has three or more)', last(i), &
                      error, least=first(i) + 2, most=n_rows)
      if (allocated(error)) return
      if (i > 1) then
        if (first(i) <= last(i - 1)) then
          call expect(deck, 'rows of block '//number_text(i)//' after those of the block before', &
                      number_text(first(i)), error)
          return
        end if
      end if
    end do
    n_points = n_fixed + n_loads + n_measured
    typed = numbers_left(deck) == 3*n_rows + 4*n_points .and. n_points > 0
    allocate (row(3, n_rows))
    do i = 1, n_rows
      call next_reals(deck, 'jm x y of vertex row '//number_text(i), row(:, i), error)
      if (allocated(error)) return
    end do
    call take_polygons(first, last, line, material, row, scene%blocks)
    call read_points(deck, typed, 'fixed', n_fixed, n_blocks, scene%fixed_points, error)
    if (allocated(error)) return
    call read_points(deck, typed, 'load', n_loads, n_blocks, scene%load_points, error)
    if (allocated(error)) return
    call read_points(deck, typed, 'measured', n_measured, n_blocks, scene%measured_points, error)
    if (allocated(error)) return
    call expect_end(deck, error)
  end subroutine read_block_file

  !> Vertices without the spare rows between the blocks.
  pure subroutine take_polygons(first, last, line, material, row, polygons)
    integer, intent(in) :: first(:), last(:), line(:), material(:) !! (n_blocks)
    real(dp), intent(in) :: row(:, :)                             !! (3, n_rows) jm x y
    type(polygons_t), allocatable, intent(out) :: polygons
    integer :: i, k, n

    n = size(first)
    allocate (polygons)
    polygons%material = material
    polygons%deck_line = line
    allocate (polygons%first_vertex(n + 1))
    polygons%first_vertex(1) = 1
    do i = 1, n
      polygons%first_vertex(i + 1) = polygons%first_vertex(i) + last(i) - first(i) + 1
    end do
    allocate (polygons%vertex(2, polygons%first_vertex(n + 1) - 1), polygons%joint(polygons%first_vertex(n + 1) - 1))
    do i = 1, n
      associate (from => polygons%first_vertex(i))
        do k = 0, last(i) - first(i)
          polygons%vertex(:, from + k) = row(2:3, first(i) + k)
          polygons%joint(from + k) = nint(row(1, first(i) + k))
        end do
      end associate
    end do
  end subroutine take_polygons

  !> Reads points with their blocks.
  subroutine read_points(deck, typed, what, n, n_blocks, points, error)
    type(deck_t), intent(inout) :: deck
    logical, intent(in) :: typed !! a type code stands before x y n
    character(len=*), intent(in) :: what
    integer, intent(in) :: n, n_blocks
    type(point_t), allocatable, intent(out) :: points(:)
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: code
    integer :: i

    allocate (points(n))
    do i = 1, n
      if (typed) then
        call next_real(deck, 'the type of '//what//' point '//number_text(i), code, error)
        if (allocated(error)) return
      end if
      call next_reals(deck, 'x y of '//what//' point '//number_text(i), points(i)%place, error)
      if (allocated(error)) return
      call next_index(deck, 'the block of '//what//' point '//number_text(i), points(i)%block, error, &
                      least=1, most=n_blocks)
      if (allocated(error)) return
      points(i)%deck_line = deck%line(deck%at)
    end do
  end subroutine read_points

end module scree_block_file
