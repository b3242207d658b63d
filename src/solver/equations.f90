!> The equations of groups of elements that share unknowns, written for the free unknowns, and their solution.
!>
!> An element that shares no unknown is a group of its own and is solved densely. All others are one group
!> with one sparse matrix, which only they make.
module scree_equations
  use scree_cholmod, only: cholmod_t, release_cholmod, solve_cholmod
  use scree_constraints, only: constraints_t, reduce_element, reduction_t
  use scree_dense_solver, only: solve_dense
  use scree_element_term, only: term_t
  use scree_errors, only: error_t
  use scree_kinds, only: dp
  use scree_sparse_matrix, only: add_element, build_pattern, clear_matrix, sparse_matrix_t
  use scree_system, only: element_unknowns, elements_t
  use scree_umfpack, only: release_umfpack, solve_umfpack, umfpack_t
  implicit none
  private
  public :: add_equations, begin_equations, constrain_equations, equations_t, members, out_of_balance, &
            release_equations, set_up_equations, solve_equations

  integer, parameter :: n = element_unknowns

  !> The sparse equations of the elements that share unknowns.
  type :: shared_t
    integer, allocatable :: unknown(:)       !! (n_rows) free unknown of each row
    integer, allocatable :: rows(:, :)       !! (n_most, n_members) rows of each member, then zeros
    type(sparse_matrix_t) :: matrix
    type(cholmod_t) :: cholmod               !! where the matrix is symmetric and positive definite
    type(umfpack_t) :: umfpack               !! else
  end type shared_t

  !> Groups, constraints and the sums of one iteration.
  type :: equations_t
    integer :: n_groups = 0
    integer, allocatable :: first(:)         !! (n_groups+1) group g owns member(first(g):first(g+1)-1)
    integer, allocatable :: member(:)        !! (n_elements) elements by group
    integer, allocatable :: unknown(:, :)    !! (n, n_elements) unknowns of the elements
    type(constraints_t) :: constraints
    type(reduction_t), allocatable :: reduction(:) !! (n_elements)
    real(dp), allocatable :: force(:)        !! (n_unknowns) out of balance, zero at slaves
    real(dp), allocatable :: scale(:)        !! (n_unknowns) magnitudes of the forces that balance
    real(dp), allocatable :: noise(:)        !! (n_unknowns) magnitudes of what cancelled in them
    real(dp), allocatable :: span(:)         !! (n_unknowns) displacement that a unit of each unknown makes
    real(dp), allocatable :: correction(:)   !! (n_unknowns) of the last solution
    real(dp) :: dense(n, n) = 0.0_dp         !! matrix of a group of one
    type(shared_t), allocatable :: shared    !! of the group of many, the last
  end type equations_t

contains

  !> Groups the elements.
  subroutine set_up_equations(elements, n_unknowns, equations)
    type(elements_t), intent(in) :: elements
    integer, intent(in) :: n_unknowns
    type(equations_t), intent(out) :: equations
    integer :: e, n_alone, n_elements

    n_elements = size(elements%alone)
    n_alone = count(elements%alone)
    equations%member = [pack([(e, e=1, n_elements)], elements%alone), pack([(e, e=1, n_elements)], .not. elements%alone)]
    equations%first = [(e, e=1, n_alone + 1)]
    if (n_alone < n_elements) then
      equations%first = [equations%first, n_elements + 1]
      allocate (equations%shared)
      allocate (equations%shared%rows(0, 0))
    end if
    equations%n_groups = size(equations%first) - 1
    equations%unknown = elements%unknown
    allocate (equations%reduction(n_elements))
    allocate (equations%force(n_unknowns), equations%scale(n_unknowns), equations%noise(n_unknowns), &
              equations%span(n_unknowns), equations%correction(n_unknowns), source=0.0_dp)
  end subroutine set_up_equations

  !> Elements of a group.
  pure function members(equations, group)
    type(equations_t), intent(in) :: equations
    integer, intent(in) :: group
    integer, allocatable :: members(:)

    members = equations%member(equations%first(group):equations%first(group + 1) - 1)
  end function members

  !> Takes the constraints of a step.
  subroutine constrain_equations(equations, constraints)
    type(equations_t), intent(inout) :: equations
    type(constraints_t), intent(in) :: constraints
    integer :: e

    equations%constraints = constraints
    if (size(constraints%row) > 0) then
      do e = 1, size(equations%reduction)
        call reduce_element(constraints, equations%unknown(:, e), equations%reduction(e))
      end do
    end if
    if (allocated(equations%shared)) call number_rows(equations)
  end subroutine constrain_equations

  !> Numbers the free unknowns of the shared group; a new pattern is made only where they are others than before.
  subroutine number_rows(equations)
    type(equations_t), intent(inout) :: equations
    integer, allocatable :: list(:), member(:), row(:), rows(:, :)
    integer :: k, most, n_rows, u

    member = members(equations, equations%n_groups)
    most = 0
    do k = 1, size(member)
      most = max(most, size(free_unknowns(equations, member(k))))
    end do
    allocate (rows(most, size(member)), source=0)
    allocate (row(size(equations%force)), source=0)
    do k = 1, size(member)
      list = free_unknowns(equations, member(k))
      row(list) = 1
    end do
    n_rows = 0
    do u = 1, size(row)
      if (row(u) == 0) cycle
      n_rows = n_rows + 1
      row(u) = n_rows
    end do
    do k = 1, size(member)
      list = free_unknowns(equations, member(k))
      rows(:size(list), k) = row(list)
    end do
    associate (shared => equations%shared)
      shared%unknown = pack([(u, u=1, size(row))], row > 0)
      if (all(shape(rows) == shape(shared%rows))) then
        if (all(rows == shared%rows)) return
      end if
      shared%rows = rows
      call build_pattern(n_rows, rows, shared%matrix)
      call release_cholmod(shared%cholmod)
      call release_umfpack(shared%umfpack)
    end associate
  end subroutine number_rows

  !> Free unknowns that an element contributes to.
  pure function free_unknowns(equations, e) result(list)
    type(equations_t), intent(in) :: equations
    integer, intent(in) :: e
    integer, allocatable :: list(:)

    if (allocated(equations%reduction(e)%free)) then
      list = equations%reduction(e)%free
    else
      list = equations%unknown(:, e)
    end if
  end function free_unknowns

  !> Clears the sums of a group.
  subroutine begin_equations(equations, group)
    type(equations_t), intent(inout) :: equations
    integer, intent(in) :: group
    integer :: k

    if (equations%first(group + 1) - equations%first(group) > 1) call clear_matrix(equations%shared%matrix)
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
      if (equations%first(group + 1) - equations%first(group) > 1) then
        call add_element(equations%shared%matrix, k, matrix)
      else
        equations%dense(:size(free), :size(free)) = matrix
      end if
    end subroutine add

  end subroutine add_equations

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

  !> Solves for the correction of a group and adds it to `d`.
  !>
  !> Errors: a singular matrix.
  subroutine solve_equations(equations, group, symmetric, d, error)
    type(equations_t), intent(inout) :: equations
    integer, intent(in) :: group
    logical, intent(in) :: symmetric
    real(dp), intent(inout) :: d(:)   !! (n_unknowns)
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: q(n)
    integer :: e, m

    if (equations%first(group + 1) - equations%first(group) > 1) then
      call solve_shared(equations, symmetric, d, error)
      return
    end if
    e = equations%member(equations%first(group))
    associate (ids => equations%unknown(:, e), reduction => equations%reduction(e))
      if (.not. allocated(reduction%Z)) then
        call solve_dense(equations%dense, equations%force(ids), symmetric, q, error)
        if (allocated(error)) return
        equations%correction(ids) = q
      else
        m = size(reduction%free)
        if (m > 0) call solve_dense(equations%dense(:m, :m), equations%force(reduction%free), symmetric, q(:m), error)
        if (allocated(error)) return
        equations%correction(ids) = matmul(reduction%Z, q(:m))
      end if
      d(ids) = d(ids) + equations%correction(ids)
    end associate
  end subroutine solve_equations

  !> Solves for the correction of the shared group: CHOLMOD where the matrix is symmetric, UMFPACK where it is not or
  !> turns out not to be positive definite.
  subroutine solve_shared(equations, symmetric, d, error)
    type(equations_t), intent(inout) :: equations
    logical, intent(in) :: symmetric
    real(dp), intent(inout) :: d(:)   !! (n_unknowns)
    type(error_t), allocatable, intent(out) :: error
    real(dp), allocatable :: f(:), x(:)
    logical :: moved(size(d)), solved
    integer, allocatable :: member(:)
    integer :: e, k

    associate (shared => equations%shared)
      f = equations%force(shared%unknown)
      allocate (x(size(f)))
      solved = .false.
      if (symmetric) call solve_cholmod(shared%cholmod, shared%matrix, f, x, solved, error)
      if (.not. (solved .or. allocated(error))) call solve_umfpack(shared%umfpack, shared%matrix, f, x, error)
      if (allocated(error)) return
      equations%correction(shared%unknown) = x
    end associate
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
  end subroutine solve_shared

  !> Gives back the memory of the sparse solvers.
  subroutine release_equations(equations)
    type(equations_t), intent(inout) :: equations

    if (.not. allocated(equations%shared)) return
    call release_cholmod(equations%shared%cholmod)
    call release_umfpack(equations%shared%umfpack)
  end subroutine release_equations

end module scree_equations
