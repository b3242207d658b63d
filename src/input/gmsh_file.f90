!> A mathematical mesh from a Gmsh file: MSH 4.1 in text, its triangles of three nodes.
!>
!> Format: Gmsh reference manual, section "MSH file format". Sections other than $Nodes and $Elements, and elements that are
!> points or lines, are passed over; other elements are refused, as are coordinates off the plane.
module scree_gmsh_file
  use scree_deck_text, only: deck_t, expect, next_count, next_index, next_real, next_reals, next_word, numbers_left, read_deck
  use scree_errors, only: error_t
  use scree_kinds, only: dp
  use scree_mesh, only: mesh_t
  use scree_text, only: number_text, real_text
  implicit none
  private
  public :: read_gmsh_file

  integer, parameter :: gmsh_line = 1, gmsh_triangle = 2, gmsh_point = 15 !! element types
  integer, parameter :: most_tags = 100000000

  !> Nodes as they are found.
  type :: nodes_t
    real(dp), allocatable :: position(:, :)   !! (2, n)
    integer, allocatable :: number(:)      !! (tags) node of each tag, 0: none
  end type nodes_t

contains

  !> Reads the triangles of a file and the nodes that they use, counter-clockwise.
  !>
  !> Errors: anything that does not follow the format, no triangle, a triangle without area, with its line.
  subroutine read_gmsh_file(name, mesh, error)
    character(len=*), intent(in) :: name
    type(mesh_t), intent(out) :: mesh
    type(error_t), allocatable, intent(out) :: error
    type(deck_t) :: deck
    type(nodes_t) :: nodes
    character(len=:), allocatable :: word
    real(dp) :: version
    integer :: i

    call read_deck(name, deck, error, kind='mesh')
    if (allocated(error)) return
    allocate (mesh%triangle(3, 0))
    call next_word(deck, '$MeshFormat', word, error)
    if (allocated(error)) return
    if (word /= '$MeshFormat') then
      call expect(deck, '$MeshFormat', word, error)
      return
    end if
    call next_real(deck, 'the version of the format', version, error)
    if (allocated(error)) return
    if (abs(version - 4.1_dp) > 1e-6_dp) then
      call expect(deck, 'version 4.1 of the format', real_text(version), error)
      return
    end if
    call next_index(deck, 'the file type (0: text)', i, error, most=0)
    if (allocated(error)) return
    do while (numbers_left(deck) > 0)
      call next_word(deck, 'a section', word, error)
      if (allocated(error)) return
      if (word == '$Nodes') then
        if (allocated(nodes%number)) then
          call expect(deck, '$Nodes once', 'it again', error)
          return
        end if
        call read_nodes(deck, nodes, error)
        if (.not. allocated(error)) call end_section(deck, '$EndNodes', error)
      else if (word == '$Elements') then
        if (.not. allocated(nodes%number)) then
          call expect(deck, '$Nodes before $Elements', 'none', error)
        else
          call read_elements(deck, nodes, mesh, error)
          if (.not. allocated(error)) call end_section(deck, '$EndElements', error)
        end if
      end if
      if (allocated(error)) return
    end do
    if (size(mesh%triangle, 2) == 0) then
      call expect(deck, 'triangles in $Elements', 'none', error)
      return
    end if
    call drop_unused(nodes, mesh)
  end subroutine read_gmsh_file

  !> Reads the end of a section, without which the file is cut off or holds more than it announces.
  subroutine end_section(deck, last, error)
    type(deck_t), intent(inout) :: deck
    character(len=*), intent(in) :: last
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: word

    call next_word(deck, last, word, error)
    if (allocated(error)) return
    if (word /= last) call expect(deck, last, word, error)
  end subroutine end_section

  !> Reads the section $Nodes.
  subroutine read_nodes(deck, nodes, error)
    type(deck_t), intent(inout) :: deck
    type(nodes_t), intent(inout) :: nodes
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: position(3)
    integer :: block, dimension, i, highest, lowest, n, n_blocks, n_here, parametric
    integer, allocatable :: tag(:)

    call next_count(deck, 'blocks of nodes', 4, n_blocks, error, least=1)
    if (allocated(error)) return
    call next_count(deck, 'nodes', 4, n, error, least=3)
    if (allocated(error)) return
    call next_index(deck, 'the lowest tag of a node', lowest, error, least=1)
    if (allocated(error)) return
    call next_index(deck, 'the highest tag of a node', highest, error, least=lowest, most=most_tags)
    if (allocated(error)) return
    allocate (nodes%position(2, n), nodes%number(highest))
    nodes%number = 0
    n = 0
    do block = 1, n_blocks
      call next_index(deck, 'the dimension of an entity', dimension, error, most=3)
      if (allocated(error)) return
      call next_index(deck, 'the tag of an entity', i, error)
      if (allocated(error)) return
      call next_index(deck, 'whether nodes are parametric', parametric, error, most=1)
      if (allocated(error)) return
      call next_count(deck, 'nodes of an entity', 4, n_here, error)
      if (allocated(error)) return
      if (n + n_here > size(nodes%position, 2)) then
        call expect(deck, 'no more nodes than the '//number_text(size(nodes%position, 2))//' announced', number_text(n + n_here), &
                    error)
        return
      end if
      allocate (tag(n_here))
      do i = 1, n_here
        call next_index(deck, 'the tag of a node', tag(i), error, least=lowest, most=highest)
        if (allocated(error)) return
      end do
      do i = 1, n_here
        call next_reals(deck, 'x y z of a node', position, error)
        if (allocated(error)) return
        if (abs(position(3)) > 0) then
          call expect(deck, 'nodes in the plane z = 0', 'one off it', error)
          return
        end if
        if (nodes%number(tag(i)) > 0) then
          call expect(deck, 'each tag of a node once', number_text(tag(i))//' again', error)
          return
        end if
        nodes%position(:, n + i) = position(1:2)
        nodes%number(tag(i)) = n + i
        if (parametric == 1) call next_reals(deck, 'parametric coordinates', position(:dimension), error)
        if (allocated(error)) return
      end do
      n = n + n_here
      deallocate (tag)
    end do
  end subroutine read_nodes

  !> Reads the section $Elements.
  subroutine read_elements(deck, nodes, mesh, error)
    type(deck_t), intent(inout) :: deck
    type(nodes_t), intent(in) :: nodes
    type(mesh_t), intent(inout) :: mesh
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: a(2), b(2), twice_area
    integer :: block, element_type, found(3, numbers_left(deck)/4), i, k, n, n_blocks, n_here, tag

    call next_count(deck, 'blocks of elements', 4, n_blocks, error, least=1)
    if (allocated(error)) return
    do i = 1, 3
      call next_index(deck, 'the number of elements, the lowest and the highest tag', k, error)
      if (allocated(error)) return
    end do
    n = 0
    do block = 1, n_blocks
      call next_index(deck, 'the dimension of an entity', k, error, most=3)
      if (allocated(error)) return
      call next_index(deck, 'the tag of an entity', k, error)
      if (allocated(error)) return
      call next_index(deck, 'the type of elements', element_type, error)
      if (allocated(error)) return
      if (all(element_type /= [gmsh_line, gmsh_triangle, gmsh_point])) then
        call expect(deck, 'triangles of three nodes (type 2), lines and points', 'type '//number_text(element_type), &
                    error)
        return
      end if
      call next_count(deck, 'elements of an entity', 2, n_here, error)
      if (allocated(error)) return
      do i = 1, n_here
        call next_index(deck, 'the tag of an element', tag, error)
        if (allocated(error)) return
        if (element_type == gmsh_triangle) then
          n = n + 1
          do k = 1, 3
            call next_index(deck, 'a node of element '//number_text(tag), tag, error, least=1, most=size(nodes%number))
            if (allocated(error)) return
            found(k, n) = nodes%number(tag)
            if (found(k, n) == 0) then
              call expect(deck, 'a node of $Nodes', number_text(tag), error)
              return
            end if
          end do
          a = nodes%position(:, found(2, n)) - nodes%position(:, found(1, n))
          b = nodes%position(:, found(3, n)) - nodes%position(:, found(1, n))
          twice_area = a(1)*b(2) - a(2)*b(1)
          if (.not. abs(twice_area) > 1e-12_dp*max(sum(a**2), sum(b**2))) then
            call expect(deck, 'a triangle with an area', 'one without', error)
            return
          end if
          if (twice_area < 0) found(:, n) = found([1, 3, 2], n)
        else
          do k = 1, merge(2, 1, element_type == gmsh_line)
            call next_index(deck, 'a node of element '//number_text(tag), tag, error)
            if (allocated(error)) return
          end do
        end if
      end do
    end do
    mesh%triangle = reshape([mesh%triangle, found(:, :n)], [3, size(mesh%triangle, 2) + n])
  end subroutine read_elements

  !> Keeps the nodes of the triangles.
  pure subroutine drop_unused(nodes, mesh)
    type(nodes_t), intent(in) :: nodes
    type(mesh_t), intent(inout) :: mesh
    integer :: i, n, number(size(nodes%position, 2)), t

    number = 0
    do t = 1, size(mesh%triangle, 2)
      number(mesh%triangle(:, t)) = 1
    end do
    mesh%node = nodes%position(:, pack([(i, i=1, size(number))], number > 0))
    n = 0
    do i = 1, size(number)
      if (number(i) == 0) cycle
      n = n + 1
      number(i) = n
    end do
    do t = 1, size(mesh%triangle, 2)
      mesh%triangle(:, t) = number(mesh%triangle(:, t))
    end do
  end subroutine drop_unused

end module scree_gmsh_file
