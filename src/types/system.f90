!> Result of the geometry: blocks, elements, covers and points, constant during the run.
module scree_system
  use scree_contacts, only: outlines_t, overlap_t
  use scree_kinds, only: dp
  use scree_regions, only: regions_t
  implicit none
  private
  public :: elements_t, extension_t, last_of_block, points_t, sampling_t, system_t, unknowns_at_rest, &
            values_of

  integer, parameter, public :: element_unknowns = 6 !! of a DDA block, of three constant covers, and of a cell

  integer, parameter, public :: fixed_point = 1, load_point = 2, measured_point = 3, bolt_end = 4, edge_end = 5, &
                                roller_end = 6, absorber_end = 7

  !> Elements, each with one linear displacement field: a DDA block, a manifold element, or a cell of one of second order.
  type :: elements_t
    type(regions_t) :: shape
    integer, allocatable :: block(:)      !! (n) block it belongs to; the elements of a block are consecutive
    integer, allocatable :: material(:)   !! (n) block material
    integer, allocatable :: cover(:, :)   !! (1, 3 or 6, n) covers that meet on it
    integer, allocatable :: unknown(:, :) !! (element_unknowns, n) their unknowns
    integer, allocatable :: linked(:)     !! (n) first of the elements that it shares unknowns with, directly or through others
    integer, allocatable :: free(:)       !! elements of blocks that can move; of the others every unknown is fixed for ever
    real(dp), allocatable :: mass(:)      !! (n) at the start, mass/length
  end type elements_t

  !> Cells of manifold elements of second order, each an element of its own (see `cut_into_cells`).
  !>
  !> The six unknowns of a cell are displacement and gradient at its one point, which follow from the six covers of its element.
  type :: sampling_t
    real(dp), allocatable :: value(:, :)     !! (6, n_elements) weights of its covers there
    real(dp), allocatable :: slope(:, :, :)  !! (xy, 6, n_elements) their gradients in the configuration of the start, 1/length
    real(dp), allocatable :: area(:)         !! (n_elements) at the start, 0 of what carries a point of the decks, length^2
    real(dp), allocatable :: at_vertex(:, :) !! (6, n_vertices) weights at the vertices of the cells
  end type sampling_t

  !> Covers that follow others: displacement of cover i = sum over k of weight(k, i) times that of master(k, i).
  type :: extension_t
    integer, allocatable :: cover(:)      !! (n)
    integer, allocatable :: master(:, :)  !! (3 or 6, n) covers that stand on their own
    real(dp), allocatable :: weight(:, :) !! (3 or 6, n)
  end type extension_t

  !> Fixed, load and measured points, ends of bolts, and of pieces of edges that are loaded, held or absorb waves.
  type :: points_t
    integer, allocatable :: kind(:)       !! (n) one of `fixed_point`, ..., `absorber_end`
    integer, allocatable :: element(:)    !! (n) element that carries it
    integer, allocatable :: free(:)       !! those that a step moves: of elements that can move, but for idle load points
  end type points_t

  !> The whole of it.
  type :: system_t
    integer :: n_blocks = 0
    integer :: n_elements = 0
    integer :: n_covers = 0
    integer :: n_unknowns = 0
    integer :: last_free = 0                    !! unknowns after it are at rest
    integer, allocatable :: free_block(:)       !! blocks that can move
    logical, allocatable :: present(:)          !! (n_blocks) blocks that no stage has removed
    integer, allocatable :: at_rest(:)          !! unknowns of the elements that cannot move; blocks of the DDA have six in common
    integer :: model = 0                  !! `model_dda` or `model_nmm` of the scene
    real(dp) :: origin(2) = 0.0_dp        !! added to every position for the results, length
    real(dp) :: extent = 0.0_dp           !! larger side of the box around the blocks, by which places are told, length
    type(elements_t) :: elements
    type(points_t) :: points
    type(sampling_t), allocatable :: sampling   !! of covers of second order
    type(extension_t), allocatable :: extension !! of covers too small to stand on their own
    type(outlines_t) :: outlines          !! of the bodies, where they may touch
    type(overlap_t), allocatable :: overlaps(:) !! of bodies at the start, where they may touch
  end type system_t

contains

  !> Values of the unknowns of an element. An array with a vector of subscripts would be copied to the heap first, and this is asked
  !> often.
  pure function values_of(elements, e, d) result(values)
    type(elements_t), intent(in) :: elements
    integer, intent(in) :: e
    real(dp), intent(in) :: d(:) !! (n_unknowns)
    real(dp) :: values(element_unknowns)
    integer :: i

    do i = 1, element_unknowns
      values(i) = d(elements%unknown(i, e))
    end do
  end function values_of

  !> Place among the elements that can move of the last one of the block of which the one at place `first` is.
  pure integer function last_of_block(elements, first) result(last)
    type(elements_t), intent(in) :: elements
    integer, intent(in) :: first

    associate (free => elements%free, block => elements%block)
      do last = first, size(free) - 1
        if (block(free(last + 1)) /= block(free(first))) return
      end do
    end associate
  end function last_of_block

  !> Unknowns of the elements of blocks that cannot move, in order, less those of covers that follow others, which rest with them.
  pure function unknowns_at_rest(system, block_rests) result(list)
    class(system_t), intent(in) :: system
    logical, intent(in) :: block_rests(:)   !! (n_blocks)
    integer, allocatable :: list(:)
    logical :: rests(system%n_unknowns)
    integer :: e, i

    rests = .false.
    do e = 1, system%n_elements
      if (block_rests(system%elements%block(e))) rests(system%elements%unknown(:, e)) = .true.
    end do
    if (allocated(system%extension)) then
      rests(2*system%extension%cover - 1) = .false.
      rests(2*system%extension%cover) = .false.
    end if
    list = pack([(i, i=1, size(rests))], rests)
  end function unknowns_at_rest

end module scree_system
