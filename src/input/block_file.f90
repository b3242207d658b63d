!> Reads and writes Shi's block file, which his dc writes and his df reads: polygons, and points with the blocks that carry them.
!>
!> Layout, number by number, in doc/decks.md. The points are `x y n`, or `type x y n` as the derivative ntdda writes;
!> the count of numbers tells which. The joint material of a row is that of the edge that ends there, as the files show
!> (the first edge's stands at the second vertex). A block with holes is one polygon with seams (scree_keyholes).
module scree_block_file
  use scree_bolt_records, only: bolt_text, numbers_of_bolt, read_bolts
  use scree_block_input, only: block_moments, blocks_t
  use scree_deck_options, only: begin_thing
  use scree_deck_text, only: deck_t, expect, expect_end, next_count, next_index, next_real, next_reals, numbers_left, &
                             read_deck
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_files, only: holds_something
  use scree_groups_of_places, only: groups_text
  use scree_keyholes, only: polygons_of
  use scree_kinds, only: dp
  use scree_scene, only: point_t, polygons_t, scene_t, word_t
  use scree_system, only: bolt_end, fixed_point, load_point, measured_point
  use scree_regions, only: first_vertex_of, joint_between, last_vertex_of, region_count
  use scree_simplex_integration, only: moments_t
  use scree_text, only: number_text, real_text
  use scree_text_file, only: close_text_file, open_text_file, put_line, text_file_t
  implicit none
  private
  public :: may_replace_blocks, read_block_file, write_block_file

  real(dp), parameter :: most_joints = 999999999.0_dp !! highest number of a joint material, nine digits as of all numbers of things

  character(len=1), parameter :: lf = new_line('a')
  integer, parameter :: row_letters = 64 !! room for a whole number and two reals

  !> How many things a block file has of each kind.
  type :: counts_t
    integer :: blocks = 0, bolts = 0, rows = 0, fixed = 0, loads = 0, measured = 0
  end type counts_t

contains

  !> Reads a block file into the scene. Errors: anything that does not follow the layout, with its line.
  subroutine read_block_file(deck, scene, error)
    type(deck_t), intent(inout) :: deck
    type(scene_t), intent(inout) :: scene
    type(error_t), allocatable, intent(out) :: error
    type(counts_t) :: n
    integer, allocatable :: first(:), last(:), line(:), material(:), row_line(:)
    real(dp), allocatable :: row(:, :)
    logical :: typed
    integer :: n_points

    call read_counts(deck, n, error)
    if (allocated(error)) return
    allocate (first(n%blocks), last(n%blocks), material(n%blocks), line(n%blocks))
    call read_ranges(deck, n%rows, first, last, line, material, error)
    if (allocated(error)) return
    n_points = n%fixed + n%loads + n%measured
    typed = numbers_left(deck) == 3*n%rows + numbers_of_bolt*n%bolts + 4*n_points .and. n_points > 0
    allocate (row(3, n%rows), row_line(n%rows))
    call read_rows(deck, first, last, row, row_line, error)
    if (allocated(error)) return
    call take_polygons(first, last, line, material, row, row_line, scene%blocks)
    call read_bolts(deck, n%bolts, n%blocks, scene%bolts, error)
    if (allocated(error)) return
    call read_points(deck, typed, 'fixed', n%fixed, n%blocks, scene%fixed_points, error)
    if (allocated(error)) return
    call read_points(deck, typed, 'load', n%loads, n%blocks, scene%load_points, error)
    if (allocated(error)) return
    call read_points(deck, typed, 'measured', n%measured, n%blocks, scene%measured_points, error)
    if (allocated(error)) return
    call expect_end(deck, error)
  end subroutine read_block_file

  !> Reads how many things there are of each kind.
  subroutine read_counts(deck, n, error)
    type(deck_t), intent(inout) :: deck
    type(counts_t), intent(out) :: n
    type(error_t), allocatable, intent(out) :: error

    call next_count(deck, 'blocks', 3, n%blocks, error, least=1)
    if (allocated(error)) return
    call next_count(deck, 'bolts', numbers_of_bolt, n%bolts, error)
    if (allocated(error)) return
    call next_count(deck, 'vertex rows', 3, n%rows, error, least=1)
    if (allocated(error)) return
    call next_count(deck, 'fixed points', 3, n%fixed, error)
    if (allocated(error)) return
    call next_count(deck, 'load points', 3, n%loads, error)
    if (allocated(error)) return
    call next_count(deck, 'measured points', 3, n%measured, error)
  end subroutine read_counts

  !> Reads material, first and last vertex row of each block.
  subroutine read_ranges(deck, n_rows, first, last, line, material, error)
    type(deck_t), intent(inout) :: deck
    integer, intent(in) :: n_rows
    integer, intent(out) :: first(:), last(:), line(:), material(:) !! (n_blocks)
    type(error_t), allocatable, intent(out) :: error
    integer :: before, i

    before = 0
    do i = 1, size(first)
      call next_index(deck, 'the material of block '//number_text(i), material(i), error, least=1)
      if (allocated(error)) return
      line(i) = deck%line(deck%at)
      call next_index(deck, 'the first vertex row of block '//number_text(i), first(i), error, least=1, most=n_rows)
      if (allocated(error)) return
      call next_index(deck, 'the last vertex row of block '//number_text(i)//' (a block has three or more)', last(i), &
                      error, least=first(i) + 2, most=n_rows)
      if (allocated(error)) return
      if (first(i) <= before) then
        call expect(deck, 'rows of block '//number_text(i)//' after those of the block before', number_text(first(i)), error)
        return
      end if
      before = last(i)
    end do
  end subroutine read_ranges

  !> Reads the vertex rows. The rows between blocks, which Shi's programs use for themselves, may hold anything.
  subroutine read_rows(deck, first, last, row, row_line, error)
    type(deck_t), intent(inout) :: deck
    integer, intent(in) :: first(:), last(:)      !! (n_blocks)
    real(dp), intent(out) :: row(:, :)            !! (3, n_rows) jm x y
    integer, intent(out) :: row_line(:)           !! (n_rows)
    type(error_t), allocatable, intent(out) :: error
    logical :: spare(size(row_line))
    integer :: i

    spare = .true.
    do i = 1, size(first)
      spare(first(i):last(i)) = .false.
    end do
    do i = 1, size(row_line)
      call next_reals(deck, 'jm x y of a vertex row', row(:, i), error)
      if (allocated(error)) return
      row_line(i) = deck%line(deck%at)
      if (spare(i)) cycle
      if (abs(row(1, i)) > most_joints .or. abs(row(1, i) - anint(row(1, i))) > 0) then
        call expect(deck, 'a whole number for the joint material jm of a vertex row', real_text(row(1, i)), error)
        return
      end if
    end do
  end subroutine read_rows

  !> Whether a block file may take the place of a file: it holds nothing, or is one by its counts.
  logical function may_replace_blocks(path)
    character(len=*), intent(in) :: path
    type(error_t), allocatable :: error
    type(deck_t) :: deck
    integer :: i, n(6) ! blocks, bolts, vertex rows; fixed, load, measured points

    may_replace_blocks = .not. holds_something(path)
    if (may_replace_blocks) return
    call read_deck(path, deck, error)
    do i = 1, size(n)
      if (.not. allocated(error)) call next_index(deck, 'a count', n(i), error)
    end do
    if (allocated(error)) return
    associate (numbers => real(numbers_left(deck), dp) - 3*(real(n(1), dp) + n(3)) - numbers_of_bolt*real(n(2), dp), &
               points => sum(real(n(4:), dp)))
      may_replace_blocks = n(1) > 0 .and. (nint(numbers - 3*points) == 0 .or. nint(numbers - 4*points) == 0)
    end associate
  end function may_replace_blocks

  !> Vertices without the spare rows between the blocks.
  pure subroutine take_polygons(first, last, line, material, row, row_line, polygons)
    integer, intent(in) :: first(:), last(:), line(:), material(:) !! (n_blocks)
    real(dp), intent(in) :: row(:, :)                             !! (3, n_rows) jm x y
    integer, intent(in) :: row_line(:)                            !! (n_rows)
    type(polygons_t), allocatable, intent(out) :: polygons
    integer :: ends, i, k, n

    n = size(first)
    allocate (polygons)
    polygons%material = material
    polygons%deck_line = line
    allocate (polygons%first_vertex(n + 1))
    polygons%first_vertex(1) = 1
    do i = 1, n
      polygons%first_vertex(i + 1) = polygons%first_vertex(i) + last(i) - first(i) + 1
    end do
    associate (n_vertices => polygons%first_vertex(n + 1) - 1)
      allocate (polygons%vertex(2, n_vertices), polygons%joint(n_vertices))
      allocate (polygons%vertex_line(n_vertices), polygons%joint_line(n_vertices))
    end associate
    do i = 1, n
      associate (from => polygons%first_vertex(i))
        do k = 0, last(i) - first(i)
          polygons%vertex(:, from + k) = row(2:3, first(i) + k)
          polygons%vertex_line(from + k) = row_line(first(i) + k)
          ends = first(i) + modulo(k + 1, last(i) - first(i) + 1) ! the row of the vertex at which the edge ends
          polygons%joint(from + k) = nint(row(1, ends))
          polygons%joint_line(from + k) = row_line(ends)
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
      call begin_thing(deck%options, what//'_point', i)
      if (typed) then
        call next_real(deck, 'the type of '//what//' point '//number_text(i), code, error)
        if (allocated(error)) return
      end if
      call next_reals(deck, 'x y of '//what//' point '//number_text(i), points(i)%position, error, &
                      names=['x', 'y'])
      if (allocated(error)) return
      call next_real(deck, 'the block of '//what//' point '//number_text(i), code, error, least=0.0_dp, &
                     most=real(n_blocks, dp))
      if (allocated(error)) return
      points(i)%block = nint(code) ! 0: in none that the cutter found
      if (abs(code - points(i)%block) > 0) then
        call expect(deck, 'the number of a block', 'a fraction', error)
        return
      end if
      points(i)%deck_line = deck%line(deck%at)
    end do
  end subroutine read_points

  !> Writes blocks and points, every number so that it reads back as it was.
  !>
  !> Errors: the file cannot be written.
  subroutine write_block_file(path, blocks, words, error)
    character(len=*), intent(in) :: path
    type(blocks_t), intent(in) :: blocks
    type(word_t), intent(in) :: words(:) !! settings, of which groups of places are written
    type(error_t), allocatable, intent(out) :: error
    type(moments_t) :: moments(region_count(blocks%shape))
    type(text_file_t) :: file
    character(len=160) :: line
    character(len=:), allocatable :: groups
    integer, allocatable :: corner(:), first(:)
    integer :: b, k, n(region_count(blocks%shape)), row
    real(dp) :: radius

    call polygons_of(blocks%shape, blocks%vertex, first, corner)
    n = first(2:) - first(:size(n))
    do b = 1, size(n)
      moments(b) = block_moments(blocks, b)
      moments(b)%centroid = moments(b)%centroid + blocks%origin
    end do
    call open_text_file(path, file, error)
    if (allocated(error)) return
    call put_line(file, number_text(size(n))//' '//number_text(size(blocks%bolt))//' '//number_text(sum(n + 4)))
    call put_line(file, number_text(count(blocks%point_kind == fixed_point))//' '// &
                  number_text(count(blocks%point_kind == load_point))//' '//number_text(count(blocks%point_kind == measured_point)))
    row = 1
    do b = 1, size(n)
      call put_line(file, number_text(blocks%material(b))//' '//number_text(row)//' '//number_text(row + n(b) - 1))
      row = row + n(b) + 4
    end do
    do b = 1, size(n)
      associate (from => first_vertex_of(blocks%shape, b), to => last_vertex_of(blocks%shape, b))
        radius = sqrt(maxval((blocks%vertex(1, from:to) + blocks%origin(1) - moments(b)%centroid(1))**2 &
                             + (blocks%vertex(2, from:to) + blocks%origin(2) - moments(b)%centroid(2))**2))
      end associate
      call put_line(file, rows_of(b))
    end do
    do k = 1, size(blocks%bolt)
      associate (bolt => blocks%bolt(k))
        write (line, '(3(es23.16,1x))') bolt%ends(:, 1), bolt%ends(1, 2)
        call put_line(file, trim(line))
        write (line, '(es23.16,2(1x,i0))') bolt%ends(2, 2), bolt%block
        call put_line(file, trim(line))
        call put_line(file, bolt_text(bolt))
      end associate
    end do
    do k = 1, count(blocks%point_kind /= bolt_end)
      write (line, '(2(es23.16,1x),i0)') blocks%point(:, k) + blocks%origin, blocks%point_block(k)
      call put_line(file, trim(line))
    end do
    groups = groups_text(words, cut=.true.)
    if (len(groups) > 0) call put_line(file, groups)
    call close_text_file(file, error)

  contains

    !> The rows of a block: joint material and place of each vertex, the first one twice, then radius, area, moments and centroid.
    function rows_of(b) result(rows)
      integer, intent(in) :: b
      character(len=:), allocatable :: rows
      integer :: k, v(n(b) + 1)

      allocate (character(len=row_letters*(n(b) + 4)) :: rows)
      v(:n(b)) = corner(first(b):first(b + 1) - 1)
      v(n(b) + 1) = v(1)
      write (rows, '(*(i0,2(1x,es23.16),:,a))') &
        (joint_between(blocks%shape, b, v(merge(n(b), k - 1, k == 1)), v(k)), blocks%vertex(:, v(k)) + blocks%origin, lf, &
         k=1, n(b) + 1), 0, radius, moments(b)%area, lf, 0, moments(b)%area*moments(b)%centroid, lf, 0, moments(b)%centroid
      rows = trim(rows)
    end function rows_of

  end subroutine write_block_file

end module scree_block_file
