!> The equations of groups of elements that share unknowns, written for the free unknowns, and their solution.
!>
!> An element that shares no unknown and touches no other is a group of its own with a small matrix. All others are one
!> group with one sparse matrix, which only they make, with what acts between pairs of them.
module scree_equations
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use scree_blas, only: keep_to_one_thread
  use scree_constraints, only: constraints_t, reduce_element, reduction_t
  use scree_element_term, only: pair_term_t, term_t
  use scree_errors, only: error_t
  use scree_factored, only: factored_t
  use scree_friction_problem, only: friction_problem_t, place_springs, posed_problem_t
  use scree_kinds, only: dp
  use scree_linear_solver, only: forget_pattern, keep_matrix, linear_solver_t, recall_matrix, release_solver, small_matrix_t, &
                                 solve, solve_with_kept_factor, solver_work_t
  use scree_sparse_matrix, only: add_element, add_rest, build_pattern, clear_matrix, diagonal, sparse_matrix_t
  use scree_system, only: element_unknowns, elements_t
  implicit none
  private
  public :: add_equations, add_pair, begin_equations, constrain_equations, equations_t, group_elements, is_shared, &
            keep_factored, keep_posed, members, move_shared, out_of_balance, place_row, recall_factored, release_equations, &
            set_up_equations, share_out_of_balance, shared_problem, size_of_equations, solve_equations, weakest_element, &
            wholly_held, work_of_solutions

  integer, parameter :: n = element_unknowns

  !> The sparse equations of the elements that share unknowns.
  type :: shared_t
    integer, allocatable :: unknown(:)       !! (n_rows) free unknown of each row
    integer, allocatable :: rows(:, :)       !! (n_most, n_members + n_pairs) rows of each member and pair, then zeros
    type(sparse_matrix_t) :: matrix
    type(linear_solver_t) :: solver
  end type shared_t

  !> Groups, constraints and the sums of one iteration.
  type :: equations_t
    integer :: n_groups = 0
    logical :: has_shared = .false.          !! the last group is the one of many
    integer, allocatable :: first(:)         !! (n_groups+1) group g owns member(first(g):first(g+1)-1)
    integer, allocatable :: member(:)        !! elements that can move, by group
    integer, allocatable :: unknown(:, :)    !! (n, n_elements) unknowns of the elements
    integer, allocatable :: paired(:, :)     !! (2, n_pairs) elements that something acts between
    integer, allocatable :: pair(:, :)       !! (2 n, n_pairs) their unknowns
    type(reduction_t), allocatable :: reduction(:) !! (n_elements)
    type(reduction_t), allocatable :: pair_reduction(:) !! (n_pairs)
    real(dp), allocatable :: force(:)        !! (n_unknowns) out of balance, zero at slaves
    real(dp), allocatable :: scale(:)        !! (n_unknowns) magnitudes of the forces that balance
    real(dp), allocatable :: noise(:)        !! (n_unknowns) magnitudes of what cancelled in them
    real(dp), allocatable :: span(:)         !! (n_unknowns) displacement that a unit of each unknown makes
    real(dp), allocatable :: correction(:)   !! (n_unknowns) of the last solution
    type(small_matrix_t) :: small            !! matrix of a group of one
    type(shared_t), allocatable :: shared    !! of the group of many, the last
    type(posed_problem_t), allocatable :: posed(:) !! friction problems to be written, where any are
  end type equations_t

contains

  !> Groups the elements, and keeps the BLAS to one thread.
  subroutine set_up_equations(elements, n_unknowns, equations)
    type(elements_t), intent(in) :: elements
    integer, intent(in) :: n_unknowns
    type(equations_t), intent(out) :: equations

    call keep_to_one_thread()
    equations%unknown = elements%unknown
    allocate (equations%reduction(size(elements%alone)))
    call group_elements(elements, reshape([integer ::], [2, 0]), equations)
    allocate (equations%force(n_unknowns), equations%scale(n_unknowns), equations%noise(n_unknowns), &
              equations%span(n_unknowns), equations%correction(n_unknowns), source=0.0_dp)
  end subroutine set_up_equations

  !> Groups the elements anew, with pairs between which something acts. Constraints have to be taken after it.
  subroutine group_elements(elements, pair, equations)
    type(elements_t), intent(in) :: elements
    integer, intent(in) :: pair(:, :)  !! (2, n_pairs) elements
    type(equations_t), intent(inout) :: equations
    logical :: alone(size(elements%alone))
    integer :: e, i

    if (allocated(equations%paired)) then
      if (size(pair, 2) == size(equations%paired, 2)) then
        if (all(pair == equations%paired)) return
      end if
    end if
    equations%paired = pair
    alone = elements%alone
    do i = 1, size(pair, 2)
      alone(pair(:, i)) = .false.
    end do
    equations%pair = reshape([((elements%unknown(:, pair(e, i)), e=1, 2), i=1, size(pair, 2))], [2*n, size(pair, 2)])
    if (allocated(equations%pair_reduction)) deallocate (equations%pair_reduction)
    allocate (equations%pair_reduction(size(pair, 2)))
    associate (free => elements%free)
      equations%member = [pack(free, alone(free)), pack(free, .not. alone(free))]
      equations%first = [(i, i=1, count(alone(free)) + 1)]
    end associate
    equations%has_shared = size(equations%first) <= size(equations%member)
    if (equations%has_shared) then
      equations%first = [equations%first, size(equations%member) + 1]
      if (.not. allocated(equations%shared)) then
        allocate (equations%shared)
        allocate (equations%shared%rows(0, 0), equations%shared%unknown(0))
      end if
    end if
    equations%n_groups = size(equations%first) - 1
  end subroutine group_elements

  !> Whether a group is the one with the sparse matrix.
  pure logical function is_shared(equations, group)
    type(equations_t), intent(in) :: equations
    integer, intent(in) :: group

    is_shared = equations%has_shared .and. group == equations%n_groups
  end function is_shared

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
    if (is_shared(equations, group)) then
      wholly_held = size(equations%shared%unknown) == 0
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

    do i = 1, size(equations%member)
      associate (e => equations%member(i))
        call reduce_element(constraints, equations%unknown(:, e), equations%reduction(e))
      end associate
    end do
    do i = 1, size(equations%pair_reduction)
      call reduce_element(constraints, equations%pair(:, i), equations%pair_reduction(i))
    end do
    if (is_shared(equations, equations%n_groups)) call number_rows(equations)
  end subroutine constrain_equations

  !> Numbers the free unknowns of the shared group; a new pattern is made only where they are others than before.
  subroutine number_rows(equations)
    type(equations_t), intent(inout) :: equations
    integer, allocatable :: list(:), member(:), row(:), rows(:, :)
    integer :: k, m, most, n_rows, u

    member = members(equations, equations%n_groups)
    m = size(member) + size(equations%pair, 2)
    most = 0
    do k = 1, m
      most = max(most, size(free_unknowns(equations, member, k)))
    end do
    allocate (rows(most, m), source=0)
    allocate (row(size(equations%force)), source=0)
    do k = 1, size(member)
      row(free_unknowns(equations, member, k)) = 1
    end do
    n_rows = 0
    do u = 1, size(row)
      if (row(u) == 0) cycle
      n_rows = n_rows + 1
      row(u) = n_rows
    end do
    do k = 1, m
      list = free_unknowns(equations, member, k)
      rows(:size(list), k) = row(list)
    end do
    associate (shared => equations%shared)
      list = pack([(u, u=1, size(row))], row > 0)
      if (.not. same(list, shared%unknown)) call release_solver(shared%solver)
      shared%unknown = list
      if (all(shape(rows) == shape(shared%rows))) then
        if (all(rows == shared%rows)) return
      end if
      shared%rows = rows
      call build_pattern(n_rows, rows, shared%matrix)
      call forget_pattern(shared%solver)
    end associate

  contains

    !> Whether two lists are the same.
    pure logical function same(a, b)
      integer, intent(in) :: a(:), b(:)

      same = size(a) == size(b)
      if (same) same = all(a == b)
    end function same

  end subroutine number_rows

  !> Free unknowns that the `k`-th member of the shared group contributes to; after the members come the pairs.
  pure function free_unknowns(equations, member, k) result(list)
    type(equations_t), intent(in) :: equations
    integer, intent(in) :: member(:), k
    integer, allocatable :: list(:)

    if (k > size(member)) then
      list = free_of(equations%pair_reduction(k - size(member)), equations%pair(:, k - size(member)))
    else
      list = free_of(equations%reduction(member(k)), equations%unknown(:, member(k)))
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

    if (is_shared(equations, group)) call clear_matrix(equations%shared%matrix)
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
    integer :: e

    e = equations%member(equations%first(group) + k - 1)
    associate (ids => equations%unknown(:, e), reduction => equations%reduction(e))
      equations%span(ids) = span
      if (allocated(reduction%Z)) then
        call add(reduction%free, matmul(transpose(reduction%Z), matmul(term%matrix, reduction%Z)), &
                 matmul(term%force, reduction%Z), matmul(term%scale, abs(reduction%Z)), &
                 matmul(term%noise, abs(reduction%Z)))
      else
        call add(ids, term%matrix, term%force, term%scale, term%noise)
      end if
    end associate

  contains

    !> Adds to the sums.
    subroutine add(free, matrix, force, scale, noise)
      integer, intent(in) :: free(:)
      real(dp), intent(in) :: matrix(:, :), force(:), scale(:), noise(:)

      equations%force(free) = equations%force(free) + force
      equations%scale(free) = equations%scale(free) + scale
      equations%noise(free) = equations%noise(free) + noise
      if (is_shared(equations, group)) then
        call add_element(equations%shared%matrix, k, matrix, term%symmetric)
      else
        equations%small%n = size(free)
        equations%small%symmetric = term%symmetric
        equations%small%value(:size(free), :size(free)) = matrix
      end if
    end subroutine add

  end subroutine add_equations

  !> Adds what acts between the elements of the pair with number `p`, to the shared group.
  subroutine add_pair(equations, p, term)
    type(equations_t), intent(inout) :: equations
    integer, intent(in) :: p
    type(pair_term_t), intent(in) :: term
    integer :: n_members

    n_members = equations%first(equations%n_groups + 1) - equations%first(equations%n_groups)
    associate (reduction => equations%pair_reduction(p))
      if (allocated(reduction%Z)) then
        call add(reduction%free, matmul(term%force, reduction%Z), matmul(term%scale, abs(reduction%Z)))
        call add_element(equations%shared%matrix, n_members + p, &
                         matmul(transpose(reduction%Z), matmul(term%matrix, reduction%Z)), term%symmetric)
        if (.not. term%symmetric) call add_rest(equations%shared%matrix, n_members + p, &
                                                matmul(transpose(reduction%Z), matmul(term%friction, reduction%Z)))
      else
        call add(equations%pair(:, p), term%force, term%scale)
        call add_element(equations%shared%matrix, n_members + p, term%matrix, term%symmetric)
        if (.not. term%symmetric) call add_rest(equations%shared%matrix, n_members + p, term%friction)
      end if
    end associate

  contains

    !> Adds to the sums, one by one: two elements may share an unknown.
    subroutine add(free, force, scale)
      integer, intent(in) :: free(:)
      real(dp), intent(in) :: force(:), scale(:)
      integer :: k

      do k = 1, size(free)
        equations%force(free(k)) = equations%force(free(k)) + force(k)
        equations%scale(free(k)) = equations%scale(free(k)) + scale(k)
        equations%noise(free(k)) = equations%noise(free(k)) + scale(k)
      end do
    end subroutine add

  end subroutine add_pair

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

  !> Largest share of the forces that balance on an element that is out of balance there.
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

  !> Solves for the correction of a group, to a residual below `tolerance` (as `solve` measures it), and adds it to `d`.
  !>
  !> Errors: a singular matrix.
  subroutine solve_equations(equations, group, tolerance, keeps_factor, roughly, d, residual, error)
    type(equations_t), intent(inout) :: equations
    integer, intent(in) :: group
    real(dp), intent(in) :: tolerance
    logical, intent(in) :: keeps_factor    !! that of a matrix before may do
    logical, intent(in) :: roughly         !! where it does, so exactly: another correction follows, whatever this one is
    real(dp), intent(inout) :: d(:)        !! (n_unknowns)
    real(dp), intent(out) :: residual
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: q(n)
    integer :: e, m

    residual = 0.0_dp
    if (wholly_held(equations, group)) then
      do m = equations%first(group), equations%first(group + 1) - 1
        equations%correction(equations%unknown(:, equations%member(m))) = 0.0_dp
      end do
      return
    end if
    if (is_shared(equations, group)) then
      call solve_shared(equations, tolerance, keeps_factor, roughly, d, residual, error)
      return
    end if
    e = equations%member(equations%first(group))
    associate (ids => equations%unknown(:, e), reduction => equations%reduction(e), m => equations%small%n)
      if (.not. allocated(reduction%Z)) then
        call solve(equations%small, equations%force(ids), tolerance, q, residual, error)
        if (allocated(error)) return
        equations%correction(ids) = q
      else
        call solve(equations%small, equations%force(reduction%free), tolerance, q(:m), residual, error)
        if (allocated(error)) return
        equations%correction(ids) = matmul(reduction%Z, q(:m))
      end if
      d(ids) = d(ids) + equations%correction(ids)
    end associate
  end subroutine solve_equations

  !> Solves for the correction of the shared group.
  subroutine solve_shared(equations, tolerance, keeps_factor, roughly, d, residual, error)
    type(equations_t), intent(inout) :: equations
    real(dp), intent(in) :: tolerance
    logical, intent(in) :: keeps_factor, roughly
    real(dp), intent(inout) :: d(:)        !! (n_unknowns)
    real(dp), intent(out) :: residual
    type(error_t), allocatable, intent(out) :: error
    real(dp), allocatable :: x(:)

    associate (shared => equations%shared)
      allocate (x(size(shared%unknown)))
      if (keeps_factor) then
        call solve_with_kept_factor(shared%solver, shared%matrix, equations%force(shared%unknown), tolerance, roughly, x, &
                                    residual, error)
      else
        call solve(shared%solver, shared%matrix, equations%force(shared%unknown), tolerance, x, residual, error)
      end if
    end associate
    if (.not. allocated(error)) call move_shared(equations, x, d)
  end subroutine solve_shared

  !> Adds a correction of the free unknowns of the shared group to `d`.
  subroutine move_shared(equations, x, d)
    type(equations_t), intent(inout) :: equations
    real(dp), intent(in) :: x(:)           !! (n_rows)
    real(dp), intent(inout) :: d(:)        !! (n_unknowns)
    logical :: moved(size(d))
    integer, allocatable :: member(:)
    integer :: e, k

    equations%correction(equations%shared%unknown) = x
    member = members(equations, equations%n_groups)
    moved = .false. ! an unknown that elements share moves once
    do k = 1, size(member)
      e = member(k)
      associate (ids => equations%unknown(:, e), reduction => equations%reduction(e))
        if (allocated(reduction%Z)) equations%correction(ids) = matmul(reduction%Z, equations%correction(reduction%free))
        moved(ids) = .true.
      end associate
    end do
    where (moved) d = d + equations%correction
  end subroutine move_shared

  !> The equations of the shared group as they are summed up, with room for `m` springs between pairs of elements.
  subroutine shared_problem(equations, m, problem)
    type(equations_t), intent(in) :: equations
    integer, intent(in) :: m
    type(friction_problem_t), intent(out) :: problem

    associate (shared => equations%shared)
      problem%matrix = shared%matrix
      problem%force = equations%force(shared%unknown)
      problem%span = equations%span(shared%unknown)
      call place_springs(problem, m, size(shared%rows, 1))
    end associate
  end subroutine shared_problem

  !> Places the rows of spring i, which acts between the elements of pair `p`, in a problem of the shared group.
  subroutine place_row(equations, p, i, row, problem)
    type(equations_t), intent(in) :: equations
    integer, intent(in) :: p, i
    real(dp), intent(in) :: row(2*n, 4) !! force across and along, change across and along, on the unknowns of the pair
    type(friction_problem_t), intent(inout) :: problem
    real(dp), allocatable :: reduced(:, :)
    integer :: w

    problem%spring(i)%slot = equations%first(equations%n_groups + 1) - equations%first(equations%n_groups) + p
    associate (reduction => equations%pair_reduction(p), rows => equations%shared%rows(:, problem%spring(i)%slot))
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
  end subroutine place_row

  !> Keeps a friction problem that is to be written.
  pure subroutine keep_posed(equations, problem, near, found)
    type(equations_t), intent(inout) :: equations
    type(friction_problem_t), intent(in) :: problem
    logical, intent(in) :: near, found       !! zero is near the solution; there is one

    if (.not. allocated(equations%posed)) allocate (equations%posed(0))
    equations%posed = [equations%posed, posed_problem_t(problem, near, found)]
  end subroutine keep_posed

  !> Unknowns that are solved, and entries of the matrices, as the last step had them.
  pure function size_of_equations(equations) result(numbers)
    type(equations_t), intent(in) :: equations
    integer :: numbers(2), group, n_free

    numbers = 0
    do group = 1, equations%n_groups
      if (is_shared(equations, group)) then
        numbers = numbers + [size(equations%shared%unknown), size(equations%shared%matrix%row)]
      else
        n_free = n
        associate (reduction => equations%reduction(equations%member(equations%first(group))))
          if (allocated(reduction%free)) n_free = size(reduction%free)
        end associate
        numbers = numbers + [n_free, n_free**2]
      end if
    end do
  end function size_of_equations

  !> What the solutions of the shared group took so far.
  pure type(solver_work_t) function work_of_solutions(equations) result(work)
    type(equations_t), intent(in) :: equations

    if (allocated(equations%shared)) work = equations%shared%solver%work
  end function work_of_solutions

  !> Hands on the matrix whose factor the solutions went on from, so that a run can go on with the same bits.
  pure subroutine keep_factored(equations, factored)
    type(equations_t), intent(inout) :: equations
    type(factored_t), intent(inout) :: factored

    if (is_shared(equations, equations%n_groups)) call keep_matrix(equations%shared%solver, equations%shared%unknown, factored)
  end subroutine keep_factored

  !> Goes on from the matrix that was handed on, whatever was factorised since.
  subroutine recall_factored(equations, factored)
    type(equations_t), intent(inout) :: equations
    type(factored_t), intent(in) :: factored

    if (is_shared(equations, equations%n_groups)) call recall_matrix(equations%shared%solver, equations%shared%unknown, factored)
  end subroutine recall_factored

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
    if (.not. is_shared(equations, group)) return
    stiffness = huge(least)
    associate (unknown => equations%shared%unknown)
      stiffness(unknown) = diagonal(equations%shared%matrix)/equations%span(unknown)**2
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

  !> Gives back the memory of the sparse solvers.
  subroutine release_equations(equations)
    type(equations_t), intent(inout) :: equations

    if (.not. allocated(equations%shared)) return
    call release_solver(equations%shared%solver)
  end subroutine release_equations

end module scree_equations
