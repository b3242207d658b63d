!> The equations of groups of elements that share unknowns, written for the free unknowns, and their solution.
!>
!> An element that shares no unknown is a group of its own and is solved densely. All others are one group
!> with one sparse matrix, which only they make.
module scree_equations
  use scree_constraints, only: constraints_t, reduce_element, reduction_t
  use scree_dense_solver, only: solve_dense
  use scree_element_term, only: term_t
  use scree_errors, only: error_t
  use scree_kinds, only: dp
  use scree_system, only: element_unknowns, elements_t
  implicit none
  private
  public :: add_equations, begin_equations, constrain_equations, equations_t, members, out_of_balance, &
            set_up_equations, solve_equations

  integer, parameter :: n = element_unknowns

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
    if (n_alone < n_elements) equations%first = [equations%first, n_elements + 1]
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
    if (size(constraints%row) == 0) return
    do e = 1, size(equations%reduction)
      call reduce_element(constraints, equations%unknown(:, e), equations%reduction(e))
    end do
  end subroutine constrain_equations

  !> Clears the sums of a group.
  subroutine begin_equations(equations, group)
    type(equations_t), intent(inout) :: equations
    integer, intent(in) :: group
    integer :: k

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
      equations%dense(:size(free), :size(free)) = matrix
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

end module scree_equations
