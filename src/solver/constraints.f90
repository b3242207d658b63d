!> Unknowns that others determine are eliminated from the equations: exact fixed points, covers that follow others.
!>
!> A fixed point requires T(x) d = u of the unknowns of its element. Each such row is solved for one unknown, the slave, in terms of
!> the other unknowns, the masters, by elimination with pivoting. The equations are then written for the masters alone, Z^T K Z q =
!> Z^T f with d = Z q + h.
module scree_constraints
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_kinds, only: dp
  use scree_system, only: element_unknowns
  implicit none
  private
  public :: add_constraint, add_followers, clear_constraints, complete_unknowns, completed, constraints_t, reduce_element, &
            reduce_operator, reduced_operator, reduced_row, reduction_t

  !> Unknowns of a pair of elements.
  integer, parameter :: most_reduced = 2*element_unknowns
  !> A row is redundant if its largest entry p, as displacement per unit displacement, is below this ratio. A row solved for an
  !> entry p has errors of epsilon/p. A second row solved with the first one has errors of epsilon/p**2, for example at a support
  !> that runs across tips of triangles. These errors stay below the ratio if p is above the cube root of epsilon, 6e-6.
  real(dp), parameter :: redundant = 1e-5_dp
  !> A redundant row prescribes no displacement if its right side is below this ratio to the size of the element. A right side is
  !> also accepted that the displacements of the model can make with the row's small remaining entry.
  real(dp), parameter :: no_displacement = 1e-8_dp

  !> Rows d(slave) = sum coefficient d(master) + given. No slave is a master.
  !>
  !> A new row concerns the rows that have its slave as a master; `use` chains those of each unknown, so that what one element asks
  !> costs nothing to the others.
  type :: constraints_t
    integer :: n_rows = 0
    integer, allocatable :: slave(:)           !! (n_rows, then room)
    real(dp), allocatable :: given(:)          !! (n_rows, then room) displacement over what a unit of the slave makes
    integer, allocatable :: n(:)               !! (n_rows, then room) masters
    integer, allocatable :: master(:, :)       !! (most, n_rows, then room)
    real(dp), allocatable :: coefficient(:, :) !! (most, n_rows, then room)
    integer, allocatable :: row_of(:)          !! (n_unknowns) row that determines the unknown, 0: none, -1: it is 0
    integer :: n_uses = 0
    integer, allocatable :: use(:, :)          !! (2, n_uses, then room) row that took an unknown as a master, the use before of it
    integer, allocatable :: last_use(:)        !! (n_unknowns) 0: none
  end type constraints_t

  !> Z of one element: its unknowns in terms of free ones.
  type :: reduction_t
    integer, allocatable :: free(:)      !! (m) free unknowns
    real(dp), allocatable :: Z(:, :)     !! (n, m)
    integer, allocatable :: left(:)      !! (m) places of the free unknowns among those of the element, where all others are 0
  end type reduction_t

contains

  !> Makes a set that is empty but for unknowns that are 0.
  pure subroutine clear_constraints(constraints, n_unknowns, at_rest)
    type(constraints_t), intent(out) :: constraints
    integer, intent(in) :: n_unknowns
    integer, intent(in), optional :: at_rest(:)   !! unknowns that are 0

    allocate (constraints%row_of(n_unknowns), constraints%last_use(n_unknowns), source=0)
    if (present(at_rest)) constraints%row_of(at_rest) = -1
    allocate (constraints%use(2, 0))
    call make_room(constraints, element_unknowns, 1)
  end subroutine clear_constraints

  !> Makes room for masters of a row, and for rows.
  pure subroutine make_room(constraints, masters, rows)
    type(constraints_t), intent(inout) :: constraints
    integer, intent(in) :: masters, rows
    type(constraints_t) :: old
    integer :: m, n

    call move_alloc(constraints%slave, old%slave)
    call move_alloc(constraints%given, old%given)
    call move_alloc(constraints%n, old%n)
    call move_alloc(constraints%master, old%master)
    call move_alloc(constraints%coefficient, old%coefficient)
    allocate (constraints%slave(rows), constraints%n(rows), constraints%master(masters, rows), source=0)
    allocate (constraints%given(rows), constraints%coefficient(masters, rows), source=0.0_dp)
    if (.not. allocated(old%slave)) return
    m = size(old%master, 1)
    n = size(old%slave)
    constraints%slave(:n) = old%slave
    constraints%given(:n) = old%given
    constraints%n(:n) = old%n
    constraints%master(:m, :n) = old%master
    constraints%coefficient(:m, :n) = old%coefficient
  end subroutine make_room

  !> Adds unknowns that are sums of others. Those of the others that are such sums are in the set already.
  pure subroutine add_followers(constraints, follower, master, coefficient)
    type(constraints_t), intent(inout) :: constraints
    integer, intent(in) :: follower(:)            !! (n)
    integer, intent(in) :: master(:, :)           !! (m, n)
    real(dp), intent(in) :: coefficient(:, :)     !! (m, n)
    integer :: i, k, row

    do i = 1, size(follower)
      call begin_row(constraints, row)
      constraints%slave(row) = follower(i)
      do k = 1, size(master, 1)
        call add_terms(constraints, row, master(k, i), coefficient(k, i))
      end do
      call keep_row(constraints)
    end do
  end subroutine add_followers

  !> Adds coefficient . d(unknown) = given.
  !>
  !> A row that follows from earlier ones is left out. Errors: it contradicts them.
  pure subroutine add_constraint(constraints, unknown, coefficient, span, size_, extent, given, error)
    type(constraints_t), intent(inout) :: constraints
    integer, intent(in) :: unknown(:)
    real(dp), intent(in) :: coefficient(:) !! displacement per unknown
    real(dp), intent(in) :: span(:)        !! displacement that a unit of each unknown makes
    real(dp), intent(in) :: size_          !! of the element, length
    real(dp), intent(in) :: extent         !! of the model, an upper bound of displacements, length
    real(dp), intent(in) :: given          !! displacement
    type(error_t), allocatable, intent(out) :: error
    real(dp) :: share, largest
    integer :: i, k, new, pivot

    call begin_row(constraints, new)
    constraints%given(new) = given
    do i = 1, size(unknown)
      if (constraints%row_of(unknown(i)) > 0) &
        constraints%given(new) = constraints%given(new) - coefficient(i)*constraints%given(constraints%row_of(unknown(i)))
      call add_terms(constraints, new, unknown(i), coefficient(i))
    end do

    pivot = 0
    largest = 0.0_dp
    do i = 1, constraints%n(new)
      share = abs(constraints%coefficient(i, new))/span_of(constraints%master(i, new))
      if (share > largest) then
        pivot = i
        largest = share
      end if
    end do
    if (largest < redundant) then
      if (abs(constraints%given(new)) > max(no_displacement*size_, largest*extent)) &
        call fail(error, status_run_failed, 'its fixed points and supports prescribe displacements that contradict each other')
      return
    end if
    associate (slave => constraints%slave(new), of => constraints%coefficient(:constraints%n(new), new))
      slave = constraints%master(pivot, new)
      constraints%given(new) = constraints%given(new)/of(pivot)
      of = -of/of(pivot)
    end associate
    call drop_term(constraints, new, pivot)
    k = constraints%last_use(constraints%slave(new))
    do while (k > 0)
      call substitute(constraints, constraints%use(1, k), new)
      k = constraints%use(2, k)
    end do
    call keep_row(constraints)

  contains

    !> Span of an unknown of this element; 1 where another element brought it in.
    pure real(dp) function span_of(u)
      integer, intent(in) :: u
      integer :: at

      at = findloc(unknown, u, 1)
      span_of = 1.0_dp
      if (at > 0) span_of = span(at)
    end function span_of

  end subroutine add_constraint

  !> Begins a row without masters behind the others; it does not count before `keep_row`.
  pure subroutine begin_row(constraints, row)
    type(constraints_t), intent(inout) :: constraints
    integer, intent(out) :: row

    row = constraints%n_rows + 1
    if (row > size(constraints%slave)) call make_room(constraints, size(constraints%master, 1), 2*row)
    constraints%n(row) = 0
    constraints%given(row) = 0.0_dp
  end subroutine begin_row

  !> Counts the row that was begun.
  pure subroutine keep_row(constraints)
    type(constraints_t), intent(inout) :: constraints
    integer :: k

    constraints%n_rows = constraints%n_rows + 1
    associate (row => constraints%n_rows)
      constraints%row_of(constraints%slave(row)) = row
      do k = 1, constraints%n(row)
        call add_use(constraints, constraints%master(k, row), row)
      end do
    end associate
  end subroutine keep_row

  !> Adds a multiple of an unknown to a row, or of what determines that.
  pure subroutine add_terms(constraints, row, unknown, coefficient)
    type(constraints_t), intent(inout) :: constraints
    integer, intent(in) :: row, unknown
    real(dp), intent(in) :: coefficient
    integer :: k, known

    known = constraints%row_of(unknown)
    if (known == 0) then
      call add_term(constraints, row, unknown, coefficient)
    else if (known > 0) then
      do k = 1, constraints%n(known)
        call add_term(constraints, row, constraints%master(k, known), coefficient*constraints%coefficient(k, known))
      end do
    end if
  end subroutine add_terms

  !> Adds a multiple of an unknown to a row.
  pure subroutine add_term(constraints, row, unknown, coefficient)
    type(constraints_t), intent(inout) :: constraints
    integer, intent(in) :: row
    integer, value :: unknown      ! values: what they come from may be another row, and move
    real(dp), value :: coefficient
    integer :: k

    if (.not. abs(coefficient) > 0.0_dp) return
    do k = 1, constraints%n(row)
      if (constraints%master(k, row) /= unknown) cycle
      constraints%coefficient(k, row) = constraints%coefficient(k, row) + coefficient
      return
    end do
    if (k > size(constraints%master, 1)) call make_room(constraints, 2*k, size(constraints%slave))
    constraints%n(row) = k
    constraints%master(k, row) = unknown
    constraints%coefficient(k, row) = coefficient
  end subroutine add_term

  !> Takes the `k`-th master out of a row.
  pure subroutine drop_term(constraints, row, k)
    type(constraints_t), intent(inout) :: constraints
    integer, intent(in) :: row, k
    integer :: i

    do i = k + 1, constraints%n(row)
      constraints%master(i - 1, row) = constraints%master(i, row)
      constraints%coefficient(i - 1, row) = constraints%coefficient(i, row)
    end do
    constraints%n(row) = constraints%n(row) - 1
  end subroutine drop_term

  !> Notes that a row has an unknown among its masters.
  pure subroutine add_use(constraints, unknown, row)
    type(constraints_t), intent(inout) :: constraints
    integer, value :: unknown, row ! values: a master of a row, the number of rows
    integer, allocatable :: use(:, :)

    associate (n => constraints%n_uses)
      if (n == size(constraints%use, 2)) then
        allocate (use(2, 2*n + 32))
        use(:, :n) = constraints%use
        call move_alloc(use, constraints%use)
      end if
      n = n + 1
      constraints%use(:, n) = [row, constraints%last_use(unknown)]
      constraints%last_use(unknown) = n
    end associate
  end subroutine add_use

  !> Replaces the slave of row `new` where it is among the masters of `row`.
  pure subroutine substitute(constraints, row, new)
    type(constraints_t), intent(inout) :: constraints
    integer, value :: row, new ! values: parts of lists that grow here
    real(dp) :: share
    integer :: before, k

    do k = 1, constraints%n(row)
      if (constraints%master(k, row) == constraints%slave(new)) exit
    end do
    if (k > constraints%n(row)) return
    share = constraints%coefficient(k, row)
    call drop_term(constraints, row, k)
    constraints%given(row) = constraints%given(row) + share*constraints%given(new)
    before = constraints%n(row)
    do k = 1, constraints%n(new)
      call add_term(constraints, row, constraints%master(k, new), share*constraints%coefficient(k, new))
    end do
    do k = before + 1, constraints%n(row)
      call add_use(constraints, constraints%master(k, row), row)
    end do
  end subroutine substitute

  !> Sets every slave from its masters: a displacement with the given values, a rate or correction without.
  pure subroutine complete_unknowns(constraints, d, homogeneous)
    type(constraints_t), intent(in) :: constraints
    real(dp), intent(inout) :: d(:)       !! (n_unknowns)
    logical, intent(in) :: homogeneous
    integer :: k

    do k = 1, constraints%n_rows
      associate (n => constraints%n(k), slave => constraints%slave(k))
        d(slave) = dot_product(constraints%coefficient(:n, k), d(constraints%master(:n, k)))
        if (.not. homogeneous) d(slave) = d(slave) + constraints%given(k)
      end associate
    end do
  end subroutine complete_unknowns

  !> Free unknowns of one element and its Z; leaves both unallocated where no unknown is a slave.
  pure subroutine reduce_element(constraints, unknown, reduction)
    type(constraints_t), intent(in) :: constraints
    integer, intent(in) :: unknown(:)     !! (n) of the element
    type(reduction_t), intent(out) :: reduction
    integer :: i, k, row(size(unknown))

    row = constraints%row_of(unknown)
    if (all(row == 0)) return
    reduction%free = pack(unknown, row == 0)
    do i = 1, size(unknown)
      if (row(i) <= 0) cycle
      do k = 1, constraints%n(row(i))
        associate (master => constraints%master(k, row(i)))
          if (all(reduction%free /= master)) reduction%free = [reduction%free, master]
        end associate
      end do
    end do
    if (all(row <= 0)) reduction%left = pack([(i, i=1, size(row))], row == 0)
    allocate (reduction%Z(size(unknown), size(reduction%free)), source=0.0_dp)
    do i = 1, size(unknown)
      if (row(i) == 0) then
        reduction%Z(i, findloc(reduction%free, unknown(i), 1)) = 1.0_dp
      else if (row(i) > 0) then
        do k = 1, constraints%n(row(i))
          reduction%Z(i, findloc(reduction%free, constraints%master(k, row(i)), 1)) = constraints%coefficient(k, row(i))
        end do
      end if
    end do
  end subroutine reduce_element

  !> Z^T row; of magnitudes, with those of Z.
  pure function reduced_row(reduction, row, magnitudes) result(reduced)
    type(reduction_t), intent(in) :: reduction
    real(dp), intent(in) :: row(:)           !! (n)
    logical, intent(in) :: magnitudes
    real(dp) :: reduced(size(reduction%free))

    if (allocated(reduction%left)) then
      reduced = row(reduction%left)
    else if (magnitudes) then
      reduced = matmul(row, abs(reduction%Z))
    else
      reduced = matmul(row, reduction%Z)
    end if
  end function reduced_row

  !> Z^T A Z, the operator on the free unknowns of an element with slaves.
  pure function reduced_operator(reduction, A) result(reduced)
    type(reduction_t), intent(in) :: reduction
    real(dp), intent(in) :: A(:, :)          !! (n, n)
    real(dp) :: reduced(size(reduction%free), size(reduction%free))

    call reduce_operator(reduction, A, reduced)
  end function reduced_operator

  !> Makes Z^T A Z in place. Most of Z is zero.
  pure subroutine reduce_operator(reduction, A, reduced)
    type(reduction_t), intent(in) :: reduction
    real(dp), contiguous, intent(in) :: A(:, :) !! (n, n)
    real(dp), intent(inout) :: reduced(:, :)    !! (m, m)
    real(dp) :: product(most_reduced), sum
    integer :: i, j, k, n

    n = size(A, 1)
    do j = 1, size(reduction%free)
      if (allocated(reduction%left)) then
        do i = 1, size(reduction%free)
          reduced(i, j) = A(reduction%left(i), reduction%left(j))
        end do
        cycle
      end if
      product(:n) = 0.0_dp
      do k = 1, n
        if (abs(reduction%Z(k, j)) > 0) product(:n) = product(:n) + A(:, k)*reduction%Z(k, j)
      end do
      do i = 1, size(reduction%free)
        sum = 0.0_dp
        do k = 1, n
          if (abs(reduction%Z(k, i)) > 0) sum = sum + reduction%Z(k, i)*product(k)
        end do
        reduced(i, j) = sum
      end do
    end do
  end subroutine reduce_operator

  !> The unknowns of an element with slaves whose free ones are `q`, Z q.
  pure function completed(reduction, q) result(unknown)
    type(reduction_t), intent(in) :: reduction
    real(dp), intent(in) :: q(:)             !! (m)
    real(dp) :: unknown(size(reduction%Z, 1))
    integer :: j

    unknown = 0.0_dp
    do j = 1, size(q)
      unknown = unknown + reduction%Z(:, j)*q(j)
    end do
  end function completed

end module scree_constraints
