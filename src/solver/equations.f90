!> The equations of groups of elements that share unknowns, written for the free unknowns, and their solution.
!>
!> An element that shares no unknown and touches nothing is a group of its own with a small matrix. The others are islands:
!> elements that share unknowns or that something acts between, directly or through others that can move, each with a sparse matrix
!> of its own. What cannot move joins no islands.
module scree_equations
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use scree_blas, only: keep_memory, keep_to_one_thread
  use scree_constraints, only: completed, constraints_t, reduce_element, reduce_operator, reduced_operator, reduced_row, &
                               reduction_t
  use scree_element_term, only: pair_term_t, term_t
  use scree_errors, only: error_t
  use scree_friction_problem, only: friction_problem_t, place_springs
  use scree_grouping, only: find_groups
  use scree_kinds, only: dp
  use scree_linear_solver, only: add_work, dense_matrix, exactness_t, largest_dense, linear_solver_t, release_solver, &
                                 small_matrix_t, solve, solve_with_kept_factor, solver_work_t
  use scree_sorting, only: sort_by, sort_into
  use scree_sparse_matrix, only: add_element, build_pattern, clear_matrix, diagonal, sparse_matrix_t
  use scree_system, only: element_unknowns, elements_t
  use scree_timers, only: timers_t
  implicit none
  private
  public :: add_equations, add_pair, begin_equations, constrain_equations, equations_t, forget_groups, group_elements, &
            has_no_pairs, is_island, island_problem, members, move_island, out_of_balance, pairs_of_group, &
            place_row, set_up_equations, share_out_of_balance, solve_equations, weakest_element, wholly_held

  integer, parameter :: n = element_unknowns

  !> The sparse equations of an island.
  type :: island_t
    integer, allocatable :: pair(:)          !! pairs that it has, by their numbers
    integer, allocatable :: moved(:)         !! unknowns of its elements, each once
    integer, allocatable :: unknown(:)       !! (n_rows) free unknown of each row
    integer, allocatable :: rows(:, :)       !! (n_most, n_members + size(pair)) rows of each member and pair, then zeros
    type(sparse_matrix_t) :: matrix
    type(linear_solver_t) :: solver
  end type island_t

  !> Holds an island, to be handed on.
  type :: place_t
    type(island_t), allocatable :: island
  end type place_t

  !> Groups, constraints and the sums of one iteration.
  type :: equations_t
    integer :: n_groups = 0
    integer :: n_alone = 0                   !! groups of one element that is alone; the islands come after them
    integer, allocatable :: first(:)         !! (n_groups+1) group g owns member(first(g):first(g+1)-1)
    integer, allocatable :: member(:)        !! elements that can move, by group
    integer, allocatable :: group_of(:)      !! (n_elements) 0: it cannot move
    integer, allocatable :: unknown(:, :)    !! (n, n_elements) unknowns of the elements; of cells (n + 12, n_elements), then
                                             !! those of the covers that they follow, which no element has
    integer, allocatable :: paired(:, :)     !! (2, n_pairs) elements that something acts between
    integer, allocatable :: pair(:, :)       !! (2 n, n_pairs) their unknowns
    integer, allocatable :: island_of(:)     !! (n_pairs) that has each pair, 0: none
    integer, allocatable :: place_of(:)      !! (n_pairs) of each among the pairs of its island
    type(reduction_t), allocatable :: reduction(:) !! (n_elements)
    type(reduction_t), allocatable :: cover_reduction(:) !! (n_elements) of the covers that cells follow; where there are cells
    type(reduction_t), allocatable :: pair_reduction(:) !! (n_pairs)
    logical :: reduced = .false.             !! all three are of these groups, and of no constraint that may change
    integer, allocatable :: row(:)           !! (n_unknowns) zero between uses
    real(dp), allocatable :: force(:)        !! (n_unknowns) out of balance, zero at slaves
    real(dp), allocatable :: scale(:)        !! (n_unknowns) magnitudes of the forces that balance
    real(dp), allocatable :: noise(:)        !! (n_unknowns) magnitudes of what cancelled in them
    real(dp), allocatable :: span(:)         !! (n_unknowns) displacement that a unit of each unknown makes
    real(dp), allocatable :: correction(:)   !! (n_unknowns) of the last solution
    type(small_matrix_t) :: small            !! matrix of a group of one
    type(place_t), allocatable :: at(:)      !! (n_groups - n_alone) the islands
    type(solver_work_t) :: work              !! that islands took which are no more
  end type equations_t

contains

  !> Groups the elements, and keeps the BLAS to one thread.
  subroutine set_up_equations(elements, n_unknowns, equations)
    type(elements_t), intent(in) :: elements
    integer, intent(in) :: n_unknowns
    type(equations_t), intent(out) :: equations

    call keep_to_one_thread()
    call keep_memory()
    equations%unknown = elements%unknown
    if (size(elements%cover, 1) == 6) then
      equations%unknown = with_covers(elements)
      allocate (equations%cover_reduction(size(elements%linked)))
    end if
    allocate (equations%reduction(size(elements%linked)), equations%at(0))
    allocate (equations%group_of(size(elements%linked)), equations%row(n_unknowns), source=0)
    call group_elements(elements, reshape([integer ::], [2, 0]), .false., equations)
    allocate (equations%force(n_unknowns), equations%scale(n_unknowns), equations%noise(n_unknowns), &
              equations%correction(n_unknowns), source=0.0_dp)
    allocate (equations%span(n_unknowns), source=1.0_dp)
  end subroutine set_up_equations

  !> Unknowns of cells, and of their covers.
  pure function with_covers(elements) result(unknown)
    type(elements_t), intent(in) :: elements
    integer :: unknown(n + 12, size(elements%cover, 2))

    unknown(:n, :) = elements%unknown
    unknown(n + 1::2, :) = 2*elements%cover - 1
    unknown(n + 2::2, :) = 2*elements%cover
  end function with_covers

  !> Groups the elements anew, with pairs between which something acts. Constraints have to be taken after it.
  subroutine group_elements(elements, pair, one_island, equations)
    type(elements_t), intent(in) :: elements
    integer, intent(in) :: pair(:, :)  !! (2, n_pairs) elements
    logical, intent(in) :: one_island  !! all that is not alone is one
    type(equations_t), intent(inout) :: equations

    if (allocated(equations%paired)) then
      if (size(pair, 2) == size(equations%paired, 2)) then
        if (all(pair == equations%paired)) return
      end if
    end if
    call group_anew(elements, pair, one_island, equations)
  end subroutine group_elements

  !> Groups elements by other pairs than before.
  subroutine group_anew(elements, pair, one_island, equations)
    type(elements_t), intent(in) :: elements
    integer, intent(in) :: pair(:, :)  !! (2, n_pairs) elements
    logical, intent(in) :: one_island  !! all that is not alone is one
    type(equations_t), intent(inout) :: equations
    integer, allocatable :: before(:)
    integer :: e, i

    equations%paired = pair
    equations%pair = reshape([((elements%unknown(:, pair(e, i)), e=1, 2), i=1, size(pair, 2))], [2*n, size(pair, 2)])
    if (allocated(equations%pair_reduction)) deallocate (equations%pair_reduction)
    allocate (equations%pair_reduction(size(pair, 2)))
    equations%reduced = .false.
    before = equations%group_of - equations%n_alone
    call find_groups(elements, pair, one_island, equations%group_of, equations%n_alone, equations%n_groups)
    call sort_into(equations%group_of(elements%free), equations%n_groups, equations%first, equations%member)
    equations%member = elements%free(equations%member)
    call hand_on_islands(before, equations)
    call list_pairs_of_islands(equations)
  end subroutine group_anew

  !> Whether elements are grouped, and nothing acts between two of them.
  pure logical function has_no_pairs(equations)
    type(equations_t), intent(in) :: equations

    has_no_pairs = .false.
    if (allocated(equations%paired)) has_no_pairs = size(equations%paired, 2) == 0
  end function has_no_pairs

  !> Lets the elements be grouped anew, as what can move has changed.
  pure subroutine forget_groups(equations)
    type(equations_t), intent(inout) :: equations

    if (allocated(equations%paired)) deallocate (equations%paired)
  end subroutine forget_groups

  !> Gives each island what the one had that its first element was in: pattern and factors, which hold where its rows are the same.
  subroutine hand_on_islands(before, equations)
    integer, intent(in) :: before(:)          !! (n_elements) island that the element was in, none below 1
    type(equations_t), intent(inout) :: equations
    type(place_t), allocatable :: old(:)
    integer :: e, i

    call move_alloc(equations%at, old)
    allocate (equations%at(equations%n_groups - equations%n_alone))
    do i = 1, size(equations%at)
      e = equations%member(equations%first(equations%n_alone + i))
      if (before(e) > 0) call move_alloc(old(before(e))%island, equations%at(i)%island)
      if (.not. allocated(equations%at(i)%island)) then
        allocate (equations%at(i)%island)
        allocate (equations%at(i)%island%rows(0, 0), equations%at(i)%island%unknown(0))
      end if
    end do
    do i = 1, size(old)
      if (.not. allocated(old(i)%island)) cycle
      call add_work(old(i)%island%solver%work, equations%work)
      call release_solver(old(i)%island%solver)
    end do
  end subroutine hand_on_islands

  !> Lists the pairs of the islands, and the unknowns of their elements.
  pure subroutine list_pairs_of_islands(equations)
    type(equations_t), intent(inout) :: equations
    integer, allocatable :: first(:), pair(:)
    integer :: i, k, m, u

    equations%island_of = [(max(0, maxval(equations%group_of(equations%paired(:, i))) - equations%n_alone), &
                            i=1, size(equations%paired, 2))] ! the element that cannot move has none
    call sort_into(equations%island_of, size(equations%at), first, pair)
    equations%place_of = 0*equations%island_of
    do i = 1, size(equations%at)
      associate (island => equations%at(i)%island, row => equations%row)
        island%pair = pair(first(i):first(i + 1) - 1)
        equations%place_of(island%pair) = [(k, k=1, size(island%pair))]
        m = 0
        do k = equations%first(equations%n_alone + i), equations%first(equations%n_alone + i + 1) - 1
          do u = 1, size(equations%unknown, 1)
            associate (own => row(equations%unknown(u, equations%member(k))))
              if (own == 0) m = m + 1
              if (own == 0) own = m
            end associate
          end do
        end do
        if (allocated(island%moved)) deallocate (island%moved)
        allocate (island%moved(m))
        do k = equations%first(equations%n_alone + i), equations%first(equations%n_alone + i + 1) - 1
          do u = 1, size(equations%unknown, 1)
            associate (own => row(equations%unknown(u, equations%member(k))))
              if (own > 0) island%moved(own) = equations%unknown(u, equations%member(k))
              own = 0
            end associate
          end do
        end do
      end associate
    end do
  end subroutine list_pairs_of_islands

  !> Whether a group is an island.
  pure logical function is_island(equations, group)
    type(equations_t), intent(in) :: equations
    integer, intent(in) :: group

    is_island = group > equations%n_alone
  end function is_island

  !> Pairs that the island of a group has, by their numbers: none of what is alone.
  pure function pairs_of_group(equations, group) result(pair)
    type(equations_t), intent(in) :: equations
    integer, intent(in) :: group
    integer, allocatable :: pair(:)

    if (is_island(equations, group)) then
      pair = equations%at(group - equations%n_alone)%island%pair
    else
      allocate (pair(0))
    end if
  end function pairs_of_group

  !> Elements of a group.
  pure function members(equations, group)
    type(equations_t), intent(in) :: equations
    integer, intent(in) :: group
    integer, allocatable :: members(:)

    members = equations%member(equations%first(group):equations%first(group + 1) - 1)
  end function members

  !> Whether constraints leave no unknown of a group free. It has no equations then.
  pure logical function wholly_held(equations, group)
    type(equations_t), intent(in) :: equations
    integer, intent(in) :: group

    wholly_held = .false.
    if (is_island(equations, group)) then
      wholly_held = size(equations%at(group - equations%n_alone)%island%unknown) == 0
    else
      associate (reduction => equations%reduction(equations%member(equations%first(group))))
        if (allocated(reduction%free)) wholly_held = size(reduction%free) == 0
      end associate
    end if
  end function wholly_held

  !> Takes the constraints of a step.
  subroutine constrain_equations(equations, constraints)
    type(equations_t), intent(inout) :: equations
    type(constraints_t), intent(in) :: constraints
    integer :: i

    if (equations%reduced .and. constraints%n_rows == 0) return
    equations%reduced = constraints%n_rows == 0
    do i = 1, size(equations%member)
      associate (e => equations%member(i))
        call reduce_element(constraints, equations%unknown(:n, e), equations%reduction(e))
        if (allocated(equations%cover_reduction)) &
          call reduce_element(constraints, equations%unknown(n + 1:, e), equations%cover_reduction(e))
      end associate
    end do
    do i = 1, size(equations%pair_reduction)
      call reduce_element(constraints, equations%pair(:, i), equations%pair_reduction(i))
    end do
    do i = equations%n_alone + 1, equations%n_groups
      call number_rows(equations, i)
    end do
  end subroutine constrain_equations

  !> Numbers the free unknowns of an island; a new pattern is made only where they are others than before.
  subroutine number_rows(equations, group)
    type(equations_t), intent(inout) :: equations
    integer, intent(in) :: group
    integer, allocatable :: list(:), member(:), of_rows(:), rows(:, :)
    integer :: k, m, most, n_rows, u

    member = members(equations, group)
    associate (island => equations%at(group - equations%n_alone)%island)
      m = size(member) + size(island%pair)
      most = 0
      do k = 1, m
        most = max(most, size(free_unknowns(equations, member, island%pair, k)))
      end do
      allocate (rows(most, m), source=0)
      allocate (of_rows(size(island%moved)))
      n_rows = 0
      do k = 1, size(member)
        list = free_unknowns(equations, member, island%pair, k)
        do u = 1, size(list)
          if (equations%row(list(u)) > 0) cycle
          n_rows = n_rows + 1
          of_rows(n_rows) = list(u)
          equations%row(list(u)) = n_rows
        end do
      end do
      of_rows = of_rows(:n_rows)
      call put_in_order(of_rows)
      equations%row(of_rows) = [(u, u=1, n_rows)]
      do k = 1, m
        list = free_unknowns(equations, member, island%pair, k)
        rows(:size(list), k) = equations%row(list)
      end do
      equations%row(of_rows) = 0
      if (.not. same(of_rows, island%unknown)) call release_solver(island%solver)
      island%unknown = of_rows
      if (all(shape(rows) == shape(island%rows))) then
        if (all(rows == island%rows)) return
      end if
      island%rows = rows
      call build_pattern(n_rows, rows, island%matrix)
    end associate

  contains

    !> Sorts numbers, where they are not.
    pure subroutine put_in_order(number)
      integer, intent(inout) :: number(:)
      real(dp) :: key(size(number))

      if (all(number(2:) > number(:size(number) - 1))) return
      key = number
      call sort_by(key, number)
    end subroutine put_in_order

    !> Whether two lists are the same.
    pure logical function same(a, b)
      integer, intent(in) :: a(:), b(:)

      same = size(a) == size(b)
      if (same) same = all(a == b)
    end function same

  end subroutine number_rows

  !> Free unknowns that the `k`-th member of an island contributes to; after the members come the pairs.
  pure function free_unknowns(equations, member, pair, k) result(list)
    type(equations_t), intent(in) :: equations
    integer, intent(in) :: member(:), pair(:), k
    integer, allocatable :: list(:)

    if (k > size(member)) then
      associate (p => pair(k - size(member)))
        list = free_of(equations%pair_reduction(p), equations%pair(:, p))
      end associate
    else
      list = free_of(equations%reduction(member(k)), equations%unknown(:n, member(k)))
    end if

  contains

    !> Those of the reduction, or all.
    pure function free_of(reduction, unknown)
      type(reduction_t), intent(in) :: reduction
      integer, intent(in) :: unknown(:)
      integer, allocatable :: free_of(:)

      if (allocated(reduction%free)) then
        free_of = reduction%free
      else
        free_of = unknown
      end if
    end function free_of

  end function free_unknowns

  !> Clears the sums of a group.
  subroutine begin_equations(equations, group)
    type(equations_t), intent(inout) :: equations
    integer, intent(in) :: group
    integer :: k

    if (is_island(equations, group)) call clear_matrix(equations%at(group - equations%n_alone)%island%matrix)
    do k = equations%first(group), equations%first(group + 1) - 1
      associate (ids => equations%unknown(:, equations%member(k)))
        equations%force(ids) = 0.0_dp
        equations%scale(ids) = 0.0_dp
        equations%noise(ids) = 0.0_dp
      end associate
    end do
  end subroutine begin_equations

  !> Adds what the `k`-th member of a group contributes.
  subroutine add_equations(equations, group, k, span, term)
    type(equations_t), intent(inout) :: equations
    integer, intent(in) :: group, k
    real(dp), intent(in) :: span(n)  !! displacement that a unit of each of its unknowns makes
    type(term_t), intent(in) :: term
    integer :: e, i, m

    e = equations%member(equations%first(group) + k - 1)
    associate (ids => equations%unknown(:n, e), reduction => equations%reduction(e), small => equations%small)
      equations%span(ids) = span
      if (.not. allocated(reduction%Z)) then
        call add_at(ids, term%force, equations%force)
        call add_at(ids, term%scale, equations%scale)
        call add_at(ids, term%noise, equations%noise)
        if (is_island(equations, group)) then
          call add_element(equations%at(group - equations%n_alone)%island%matrix, k, term%matrix, term%symmetric)
        else
          small%n = n
          small%value(:n, :n) = term%matrix
        end if
      else
        m = size(reduction%free)
        do i = 1, m
          associate (u => reduction%free(i), Z => reduction%Z(:, i))
            equations%force(u) = equations%force(u) + dot_product(term%force, Z)
            equations%scale(u) = equations%scale(u) + dot_product(term%scale, abs(Z))
            equations%noise(u) = equations%noise(u) + dot_product(term%noise, abs(Z))
          end associate
        end do
        if (is_island(equations, group)) then
          call add_element(equations%at(group - equations%n_alone)%island%matrix, k, reduced_operator(reduction, term%matrix), &
                           term%symmetric)
        else
          small%n = m
          call reduce_operator(reduction, term%matrix, small%value(:m, :m))
        end if
      end if
      if (.not. is_island(equations, group)) small%symmetric = term%symmetric
    end associate
  end subroutine add_equations

  !> Adds what acts between the elements of the `k`-th pair of an island.
  subroutine add_pair(equations, group, k, term)
    type(equations_t), intent(inout) :: equations
    integer, intent(in) :: group, k
    type(pair_term_t), intent(in) :: term
    real(dp), allocatable :: scale(:)
    integer :: slot

    associate (island => equations%at(group - equations%n_alone)%island)
      slot = equations%first(group + 1) - equations%first(group) + k
      associate (reduction => equations%pair_reduction(island%pair(k)))
        if (allocated(reduction%Z)) then
          call add_at(reduction%free, reduced_row(reduction, term%force, .false.), equations%force)
          scale = reduced_row(reduction, term%scale, .true.)
          call add_at(reduction%free, scale, equations%scale)
          call add_at(reduction%free, scale, equations%noise)
          if (term%symmetric) then
            call add_element(island%matrix, slot, reduced_operator(reduction, term%matrix), .true.)
          else
            call add_element(island%matrix, slot, reduced_operator(reduction, term%matrix), .false., &
                             reduced_operator(reduction, term%friction))
          end if
        else
          associate (ids => equations%pair(:, island%pair(k)))
            call add_at(ids, term%force, equations%force)
            call add_at(ids, term%scale, equations%scale)
            call add_at(ids, term%scale, equations%noise)
          end associate
          call add_element(island%matrix, slot, term%matrix, term%symmetric, term%friction)
        end if
      end associate
    end associate
  end subroutine add_pair

  !> Adds numbers to sums, one by one: two elements may share an unknown.
  pure subroutine add_at(place, number, sum)
    integer, intent(in) :: place(:)
    real(dp), intent(in) :: number(:)  !! (size(place))
    real(dp), intent(inout) :: sum(:)
    integer :: i

    do i = 1, size(place)
      sum(place(i)) = sum(place(i)) + number(i)
    end do
  end subroutine add_at

  !> Largest force out of balance over the largest force that balances, and over the largest that cancelled.
  pure function out_of_balance(equations, group) result(share)
    type(equations_t), intent(in) :: equations
    integer, intent(in) :: group
    real(dp) :: share(2)
    real(dp) :: force, scale, noise
    integer :: k

    force = 0.0_dp
    scale = tiny(scale)
    noise = tiny(noise)
    do k = equations%first(group), equations%first(group + 1) - 1
      associate (ids => equations%unknown(:, equations%member(k)))
        force = max(force, maxval(abs(equations%force(ids))/equations%span(ids)))
        scale = max(scale, maxval(equations%scale(ids)/equations%span(ids)))
        noise = max(noise, maxval(equations%noise(ids)/equations%span(ids)))
      end associate
    end do
    share = force/[scale, noise]
  end function out_of_balance

  !> Largest ratio of the force that is out of balance on an element of the group to the forces that balance there.
  pure real(dp) function share_out_of_balance(equations, group) result(share)
    type(equations_t), intent(in) :: equations
    integer, intent(in) :: group
    integer :: k

    share = 0.0_dp
    do k = equations%first(group), equations%first(group + 1) - 1
      associate (ids => equations%unknown(:, equations%member(k)))
        share = max(share, maxval(abs(equations%force(ids))/equations%span(ids)) &
                    /max(maxval(equations%scale(ids)/equations%span(ids)), tiny(share)))
      end associate
    end do
  end function share_out_of_balance

  !> Solves for the correction of a group, as exactly as is asked for, and adds it to `d`.
  !>
  !> Errors: a singular matrix.
  subroutine solve_equations(equations, timers, group, exactness, d, residual, error)
    type(equations_t), intent(inout) :: equations
    type(timers_t), intent(inout) :: timers
    integer, intent(in) :: group
    type(exactness_t), intent(in) :: exactness
    real(dp), intent(inout) :: d(:)        !! (n_unknowns)
    real(dp), intent(out) :: residual
    type(error_t), allocatable, intent(out) :: error
    real(dp), dimension(n) :: force, q
    integer :: e, i, m

    residual = 0.0_dp
    if (wholly_held(equations, group)) then
      do m = equations%first(group), equations%first(group + 1) - 1
        equations%correction(equations%unknown(:, equations%member(m))) = 0.0_dp
      end do
      return
    end if
    if (is_island(equations, group)) then
      call solve_island(equations, timers, group, exactness, d, residual, error)
      return
    end if
    e = equations%member(equations%first(group))
    associate (ids => equations%unknown(:n, e), reduction => equations%reduction(e), m => equations%small%n)
      if (.not. allocated(reduction%Z)) then
        force = equations%force(ids)
        call solve(equations%small, force, exactness%tolerance, q, residual, error)
      else
        force(:m) = equations%force(reduction%free)
        call solve(equations%small, force(:m), exactness%tolerance, q(:m), residual, error)
        if (.not. allocated(error)) q = completed(reduction, q(:m))
      end if
      if (allocated(error)) return
      do i = 1, n
        equations%correction(ids(i)) = q(i)
        d(ids(i)) = d(ids(i)) + q(i)
      end do
    end associate
  end subroutine solve_equations

  !> Solves for the correction of an island.
  subroutine solve_island(equations, timers, group, exactness, d, residual, error)
    type(equations_t), intent(inout) :: equations
    type(timers_t), intent(inout) :: timers
    integer, intent(in) :: group
    type(exactness_t), intent(in) :: exactness
    real(dp), intent(inout) :: d(:)        !! (n_unknowns)
    real(dp), intent(out) :: residual
    type(error_t), allocatable, intent(out) :: error
    real(dp), allocatable :: scale(:), x(:)

    associate (island => equations%at(group - equations%n_alone)%island)
      allocate (x(size(island%unknown)))
      if (.not. exactness%keeps_factor) then
        call solve(island%solver, island%matrix, equations%force(island%unknown), exactness%tolerance, timers, x, residual, error)
      else if (size(x) <= largest_dense) then
        equations%small = dense_matrix(island%matrix)
        call solve(equations%small, equations%force(island%unknown), exactness%tolerance, x, residual, error)
      else
        scale = abs(equations%force(island%unknown))
        if (exactness%by_balance) scale = equations%scale(island%unknown)
        call solve_with_kept_factor(island%solver, island%matrix, equations%force(island%unknown), scale, exactness, timers, &
                                    x, residual, error)
      end if
    end associate
    if (.not. allocated(error)) call move_island(equations, group, x, d)
  end subroutine solve_island

  !> Adds a correction of the free unknowns of an island to `d`.
  subroutine move_island(equations, group, x, d)
    type(equations_t), intent(inout) :: equations
    integer, intent(in) :: group
    real(dp), intent(in) :: x(:)           !! (n_rows)
    real(dp), intent(inout) :: d(:)        !! (n_unknowns)
    integer :: i, k

    associate (island => equations%at(group - equations%n_alone)%island, correction => equations%correction)
      do i = 1, size(x)
        correction(island%unknown(i)) = x(i)
      end do
      do k = equations%first(group), equations%first(group + 1) - 1
        associate (ids => equations%unknown(:n, equations%member(k)), reduction => equations%reduction(equations%member(k)))
          if (allocated(reduction%Z)) correction(ids) = matmul(reduction%Z, correction(reduction%free))
        end associate
        if (allocated(equations%cover_reduction)) then
          associate (ids => equations%unknown(n + 1:, equations%member(k)), &
                     reduction => equations%cover_reduction(equations%member(k)))
            if (allocated(reduction%Z)) correction(ids) = matmul(reduction%Z, correction(reduction%free))
          end associate
        end if
      end do
      do i = 1, size(island%moved)
        d(island%moved(i)) = d(island%moved(i)) + correction(island%moved(i))
      end do
    end associate
  end subroutine move_island

  !> The equations of an island as they are summed up, with room for `m` springs between pairs of elements.
  subroutine island_problem(equations, group, m, problem)
    type(equations_t), intent(in) :: equations
    integer, intent(in) :: group, m
    type(friction_problem_t), intent(out) :: problem

    associate (island => equations%at(group - equations%n_alone)%island)
      problem%matrix = island%matrix
      problem%force = equations%force(island%unknown)
      problem%span = equations%span(island%unknown)
      call place_springs(problem, m, size(island%rows, 1))
    end associate
  end subroutine island_problem

  !> Places the rows of spring i, which acts between the elements of the `k`-th pair of an island, in a problem of it.
  subroutine place_row(equations, group, k, i, row, problem)
    type(equations_t), intent(in) :: equations
    integer, intent(in) :: group, k, i
    real(dp), intent(in) :: row(2*n, 4) !! force across and along, change across and along, on the unknowns of the pair
    type(friction_problem_t), intent(inout) :: problem
    real(dp), allocatable :: reduced(:, :)
    integer :: w

    problem%spring(i)%slot = equations%first(group + 1) - equations%first(group) + k
    associate (island => equations%at(group - equations%n_alone)%island)
      associate (reduction => equations%pair_reduction(island%pair(k)), rows => island%rows(:, problem%spring(i)%slot))
        if (allocated(reduction%Z)) then
          reduced = matmul(transpose(reduction%Z), row)
        else
          reduced = row
        end if
        w = size(reduced, 1)
        problem%length(i) = w
        problem%row(:w, i) = rows(:w)
        problem%normal(:w, i) = reduced(:, 1)
        problem%shear(:w, i) = reduced(:, 2)
        problem%normal_change(:w, i) = reduced(:, 3)
        problem%shear_change(:w, i) = reduced(:, 4)
      end associate
    end associate
  end subroutine place_row

  !> The element of a group with the least stiffness on the diagonal, or one that is no number: where a matrix that cannot be solved
  !> is looked at first. 0 where the group has no free unknown.
  pure integer function weakest_element(equations, group) result(element)
    type(equations_t), intent(in) :: equations
    integer, intent(in) :: group
    integer, allocatable :: member(:)
    real(dp) :: least, stiffness(size(equations%force))
    integer :: k

    member = members(equations, group)
    element = member(1)
    if (.not. is_island(equations, group)) return
    stiffness = huge(least)
    associate (island => equations%at(group - equations%n_alone)%island)
      stiffness(island%unknown) = diagonal(island%matrix)/equations%span(island%unknown)**2
    end associate
    element = 0
    least = huge(least)
    do k = 1, size(member)
      associate (own => stiffness(equations%unknown(:, member(k))))
        if (all(own >= least)) cycle
        element = member(k)
        least = minval(own)
        if (any(ieee_is_nan(own))) return
      end associate
    end do
  end function weakest_element

end module scree_equations
