!> Whether a step that settled may be accepted: what moved farther than contacts were looked for, or than a step may; what contacts
!> overlap; what turns too far; what is lost.
module scree_step_checks
  use scree_contact_acceptance, only: farthest_apart
  use scree_contact_search, only: find_outrun, outrun_t
  use scree_contact_rules, only: judges_anew, looks_as_far_as_it_moves, stiffness_adapts, stiffness_after
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_interpolation, only: displacement_matrix
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_polygon, only: twice_area
  use scree_regions, only: first_vertex_of, last_vertex_of
  use scree_state, only: state_t
  use scree_step_try, only: cut_by_leap, cut_by_overlap, cut_by_travel, cut_by_turn, reject, remedy_stiffer, &
                             remedy_wider, try_t
  use scree_strain_rotation, only: is_decomposed
  use scree_system, only: last_of_block, values_of
  use scree_trouble, only: new_trouble, words_of
  implicit none
  private
  public :: check_state, check_try

  real(dp), parameter :: leeway = 3.0_dp !! times as far as it should a vertex may go, where Shi's rules choose the step
  !> Where the stiffness of contacts adapts: overlap over that allowed for which it grows, by how much, and how often in a step.
  real(dp), parameter :: too_deep = 2.5_dp, stiffening = 10.0_dp
  integer, parameter :: most_stiffenings = 5
  real(dp), parameter :: least_size = 1e-12_dp !! of a block over its distance from the middle: four digits are left for its shape

contains

  !> Rejects a try that went beyond what it may, and says what the next one is to do.
  subroutine check_try(model, cache, state, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(inout) :: try

    if (allocated(model%effects%contact)) call check_search(model, cache, state, try)
    if (try%outcome%settled .and. model%settings%most_travel < huge(1.0_dp)) call check_travel(model, cache, state, try)
    if (try%outcome%settled .and. allocated(model%effects%contact)) call check_penetration(model, try)
    if (try%outcome%settled .and. model%effects%strain_rotation) call check_rotations(model, cache, try)
  end subroutine check_try

  !> Rejects a try in which an element turns farther than strain beside rotation is defined.
  subroutine check_rotations(model, cache, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(try_t), intent(inout) :: try
    integer :: e, k

    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      associate (element => cache%element(e)%kinematics)
        if (is_decomposed(matmul(element%gradient, values_of(model%elements, e, try%d)))) cycle
        call reject(try%outcome, cut_by_turn, 'it turns by a right angle, beside which there is no strain', 'method.strain=green', &
                    e, element%centroid)
      end associate
      return
    end do
  end subroutine check_rotations

  !> Rejects a try in which a vertex went beyond the range of the search for contacts. The next try searches farther, or is shorter.
  !>
  !> A vertex may jump beyond the search, such as one of small edges that gets its weight at once. Then the search is extended once,
  !> as far as the vertex went. It is not extended where the whole body jumps, nor in steps towards equilibrium, which are limited
  !> by this.
  subroutine check_search(model, cache, state, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(inout) :: try
    type(outrun_t) :: beyond
    real(dp) :: farthest
    integer :: e
    logical :: again, jumps

    if (.not. looks_as_far_as_it_moves(model%effects%contact)) return
    call find_outrun(model, cache, state, try%dt, try%contacts, try%d, beyond)
    try%jump = max(try%jump, maxval(beyond%jump), beyond%most_turned)
    jumps = any(beyond%jump > 1)
    again = jumps .and. .not. (beyond%most_turned > 1 .or. allocated(try%contacts%jumped) .or. allocated(state%settling))
    if (again) again = .not. any_body_leaps(model, cache, state, try)
    if (again) then
      try%outcome%settled = .false.
      try%remedy = remedy_wider
      try%contacts%jumped = of_blocks(model, beyond%jump > 1, try%d)
    else if (jumps .or. beyond%most_turned > 1) then
      call find_farthest(model, cache, state, try%d, farthest, e)
      call reject(try%outcome, cut_by_leap, 'a vertex jumped over an edge near it, or turned too far', 'a smaller step.least', e, &
                  cache%element(e)%kinematics%centroid)
    else if (any(beyond%way > 0) .or. any(beyond%turn > 0)) then
      try%outcome%settled = .false.
      try%remedy = remedy_wider
      try%contacts%extra_reach = try%contacts%extra_reach + 2*beyond%way
      try%contacts%extra_turn = try%contacts%extra_turn + 2*beyond%turn
      try%contacts%goes_on = judges_anew(try%contacts%law)
    end if
  end subroutine check_search

  !> The displacement of some blocks, and none of the others.
  pure function of_blocks(model, block, d) result(own)
    type(model_t), intent(in) :: model
    logical, intent(in) :: block(:)                  !! (n_blocks) whose displacement is taken
    real(dp), intent(in) :: d(:)                     !! (n_unknowns)
    real(dp) :: own(size(d))
    integer :: e

    own = 0.0_dp
    do e = 1, model%n_elements
      if (block(model%elements%block(e))) own(model%elements%unknown(:, e)) = d(model%elements%unknown(:, e))
    end do
  end function of_blocks

  !> Whether a body went farther beyond its velocity than a vertex of its longest edges may.
  pure logical function any_body_leaps(model, cache, state, try) result(jumps)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(in) :: try
    real(dp) :: beyond(2)
    integer :: e, k

    jumps = .true.
    if (.not. allocated(cache%search%bodies%longest)) return
    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      beyond = matmul(cache%element(e)%kinematics%at_centroid, &
                      values_of(model%elements, e, try%d) - try%dt*values_of(model%elements, e, state%velocity))
      if (norm2(beyond) > model%effects%contact%largest_jump*cache%search%bodies%longest(model%elements%block(e))) return
    end do
    jumps = .false.
  end function any_body_leaps

  !> Rejects a try in which a vertex goes too far.
  subroutine check_travel(model, cache, state, try)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(try_t), intent(inout) :: try
    real(dp) :: ratio
    integer :: e

    call find_farthest(model, cache, state, try%d, try%travel, e)
    ratio = try%travel/model%settings%most_travel
    if (ratio <= merge(leeway, 1.0_dp, model%settings%chooses_step)) return
    call reject(try%outcome, cut_by_travel, 'a vertex went farther than step.travel lets it', &
                'a larger step.travel or a smaller step.least', e, cache%element(e)%kinematics%centroid)
    if (model%settings%chooses_step) try%shorter = 1/sqrt(ratio)
  end subroutine check_travel

  !> Rejects a try with contacts that overlap too much, and makes their springs stiffer, where these adapt.
  subroutine check_penetration(model, try)
    type(model_t), intent(in) :: model
    type(try_t), intent(inout) :: try
    real(dp) :: apart(2), stiffness(2)

    if (.not. stiffness_adapts(try%contacts%law) .or. try%stiffened == most_stiffenings) return
    apart = farthest_apart(model, try%contacts, try%d)
    if (apart(2) <= too_deep*try%contacts%law%shi%allowed_penetration) return
    stiffness = stiffness_after(try%contacts%law, apart(1), apart(2))
    try%contacts%law%normal_stiffness = stiffening*stiffness(1)
    try%contacts%law%shear_stiffness = stiffening*stiffness(2)
    try%stiffened = try%stiffened + 1
    try%remedy = remedy_stiffer
    call reject(try%outcome, cut_by_overlap, 'contacts overlapped too much', 'a larger contact.stiffness', 0)
  end subroutine check_penetration

  !> Farthest that a vertex goes, and its element.
  pure subroutine find_farthest(model, cache, state, d, farthest, element)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state               !! at the beginning of the step
    real(dp), intent(in) :: d(:)                     !! (n_unknowns)
    real(dp), intent(out) :: farthest                !! length
    integer, intent(out) :: element
    real(dp) :: way
    integer :: e, i, k

    farthest = 0.0_dp
    element = 1
    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      do i = first_vertex_of(model%elements%shape, e), last_vertex_of(model%elements%shape, e)
        way = norm2(matmul(displacement_matrix(cache%element(e)%kinematics, state%vertex(:, i)), values_of(model%elements, e, d)))
        if (way <= farthest) cycle
        farthest = way
        element = e
      end do
    end do
  end subroutine find_farthest

  !> Error where a block is lost: without area, its elements taken together, or farther away than its digits reach.
  subroutine check_state(model, state, error)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state               !! at the end of a step
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: area, high(2), low(2)
    integer :: first, k, last, loop

    last = 0
    associate (shape => model%elements%shape, block => model%elements%block, free => model%elements%free)
      do while (last < size(free)) ! of a block
        first = last + 1
        last = last_of_block(model%elements, first)
        area = 0.0_dp
        low = huge(low)
        high = -huge(high)
        do k = first, last
          do loop = shape%first_loop(free(k)), shape%first_loop(free(k) + 1) - 1
            associate (vertex => state%vertex(:, shape%first_vertex(loop):shape%first_vertex(loop + 1) - 1))
              area = area + twice_area(vertex)
              low = min(low, minval(vertex, 2))
              high = max(high, maxval(vertex, 2))
            end associate
          end do
        end do
        if (area > 0 .and. maxval(high - low) > least_size*maxval(max(abs(low), abs(high)))) cycle
        associate (e => findloc(block, block(free(first)), 1))
          call fail(error, status_run_failed, words_of(new_trouble( &
            'it is lost: crushed to nothing, or so far away that 16 digits do not tell its shape', &
            'a smaller step.size, and check density, E and loads', e, state%vertex(:, first_vertex_of(shape, e))), model))
        end associate
        return
      end do
    end associate
  end subroutine check_state

end module scree_step_checks
