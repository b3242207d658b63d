!> What the islands have taken so far, and what their solutions go on from.
module scree_islands
  use scree_equations, only: equations_t, is_island
  use scree_factored, only: factored_t, is_of, move_factored, number_of
  use scree_linear_solver, only: add_work, keep_matrix, recall_matrix, release_solver, solver_work_t
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: keep_factored, recall_factored, release_equations, size_of_equations, work_of_solutions

  integer, parameter :: n = element_unknowns

contains

  !> Unknowns that are solved, and entries of the matrices, as the last step had them.
  pure function size_of_equations(equations) result(numbers)
    type(equations_t), intent(in) :: equations
    integer :: numbers(2), group, n_free

    numbers = 0
    do group = 1, equations%n_groups
      if (is_island(equations, group)) then
        associate (island => equations%at(group - equations%n_alone)%island)
          numbers = numbers + [size(island%unknown), size(island%matrix%row)]
        end associate
      else
        n_free = n
        associate (reduction => equations%reduction(equations%member(equations%first(group))))
          if (allocated(reduction%free)) n_free = size(reduction%free)
        end associate
        numbers = numbers + [n_free, n_free**2]
      end if
    end do
  end function size_of_equations

  !> What the solutions of all islands took so far.
  pure type(solver_work_t) function work_of_solutions(equations) result(work)
    type(equations_t), intent(in) :: equations
    integer :: i

    work = equations%work
    if (.not. allocated(equations%at)) return
    do i = 1, size(equations%at)
      call add_work(equations%at(i)%island%solver%work, work)
    end do
  end function work_of_solutions

  !> Hands on the matrices whose factors the solutions went on from, so that a run can go on with the same bits.
  subroutine keep_factored(equations, factored)
    type(equations_t), intent(inout) :: equations
    type(factored_t), allocatable, intent(inout) :: factored(:) !! as of the step before, then one for each island
    type(factored_t), allocatable :: before(:)
    integer :: i, known
    logical :: same

    if (.not. allocated(factored)) allocate (factored(0))
    same = size(factored) == size(equations%at)
    do i = 1, size(equations%at)
      if (same) same = is_of(factored(i), equations%at(i)%island%unknown)
    end do
    if (.not. same) then
      call move_alloc(factored, before)
      allocate (factored(size(equations%at)))
      do i = 1, size(factored)
        known = number_of(before, equations%at(i)%island%unknown, i)
        if (known > 0) call move_factored(before(known), factored(i))
      end do
    end if
    do i = 1, size(factored)
      call keep_matrix(equations%at(i)%island%solver, equations%at(i)%island%unknown, factored(i))
    end do
  end subroutine keep_factored

  !> Goes on from the matrices that were handed on, whatever was factorised since.
  subroutine recall_factored(equations, factored)
    type(equations_t), intent(inout) :: equations
    type(factored_t), intent(in) :: factored(:)
    integer :: i, known

    do i = 1, size(equations%at)
      associate (island => equations%at(i)%island)
        known = number_of(factored, island%unknown, i)
        if (known > 0) then
          call recall_matrix(island%solver, island%unknown, factored(known))
        else
          call recall_matrix(island%solver, island%unknown, factored_t())
        end if
      end associate
    end do
  end subroutine recall_factored

  !> Gives back the memory of the sparse solvers.
  subroutine release_equations(equations)
    type(equations_t), intent(inout) :: equations
    integer :: i

    if (.not. allocated(equations%at)) return
    do i = 1, size(equations%at)
      call release_solver(equations%at(i)%island%solver)
    end do
  end subroutine release_equations

end module scree_islands
