!> What a search for contacts fills anew in each step, with room for the whole scene that stays from step to step.
module scree_contact_lists
  use scree_kinds, only: dp
  implicit none
  private
  public :: corner_t, entrances_t, survey_t

  !> Corner at a vertex, seen from inside: from its edge counter-clockwise to the one before. It has no default values: there is
  !> room for all corners, and few are found.
  type :: corner_t
    integer :: vertex  !! which begins the edge of the same number
    integer :: before  !! edge that ends there
    real(dp) :: from   !! direction of its edge, rad
    real(dp) :: into   !! direction of the edge before, rad
    real(dp) :: angle  !! rad, up to a whole turn
  end type corner_t

  !> Edges, corners and reaches of the outlines, of which a step surveys those that are listed. There is room for all, which stays
  !> from step to step; what is not listed is as it was, but for its length.
  type :: survey_t
    integer, allocatable :: edge(:)       !! edges that are listed
    real(dp), allocatable :: start(:, :)  !! (2, n) where each edge begins, length
    real(dp), allocatable :: finish(:, :) !! (2, n) where it ends, length
    real(dp), allocatable :: length(:)    !! (n) of each edge, 0 of one that is not listed
    real(dp), allocatable :: side(:)      !! (n) from end to end of the straight side of each edge, length
    real(dp), allocatable :: local(:)     !! (n) shorter edge at each vertex and at what is near it, length
    real(dp), allocatable :: local_side(:) !! (n) shorter side at each vertex and at what is near it, length
    real(dp), allocatable :: reach_edge(:) !! (n) how far edges may be that each vertex may meet in the step, length
    real(dp), allocatable :: reach_corner(:) !! (n) how far corners may be that it may meet, length
    real(dp), allocatable :: reach_at_rest(:) !! (n) how far both would be if it were at rest, length
    real(dp), allocatable :: way(:, :)    !! (2, n) by which the velocity of each vertex takes it in the step, length
    real(dp), allocatable :: turning(:)   !! (n) how far the corner at each vertex may turn in the step, rad
    type(corner_t), allocatable :: corner(:)
  end type survey_t

  !> Entrances of contacts by their vertices, and those of a vertex by their edges. Room for all vertices stays from list to list.
  type :: entrances_t
    integer, allocatable :: first(:)  !! (n_vertices) vertex v has those from first(v) to last(v)
    integer, allocatable :: last(:)   !! (n_vertices) before first(v) where it has none
    integer, allocatable :: vertex(:) !! vertices that have some
    integer, allocatable :: edge(:)   !! ascending for each vertex
    integer, allocatable :: number(:) !! of the entrance; `contact_of` and `entrance_of` tell which that is
  end type entrances_t

end module scree_contact_lists
