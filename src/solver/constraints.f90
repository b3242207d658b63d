!> Unknowns that others determine are eliminated from the equations: exact fixed points, covers that follow others.
!>
!> A fixed point asks T(x) d = u of the unknowns of its element. Each such row is solved for one unknown,
!> the slave, in terms of the others, the masters, by elimination with pivoting; the equations are then
!> written for the masters alone, Z^T K Z q = Z^T f with d = Z q + h.
module scree_constraints
  use scree_errors, only: error_t, fail, status_run_failed
  use scree_kinds, only: dp
  implicit none
  private
  public :: add_constraint, add_followers, clear_constraints, complete_unknowns, constraints_t, reduce_element, reduction_t

  !> A row whose largest entry is below this share of a displacement says nothing new.
  real(dp), parameter :: redundant = 1e-8_dp

  !> One slave: d(slave) = sum coefficient d(master) + given.
  type :: row_t
    integer :: slave = 0
    integer, allocatable :: master(:)
    real(dp), allocatable :: coefficient(:)
    real(dp) :: given = 0.0_dp
  end type row_t

  !> All slaves. No slave is a master.
  type :: constraints_t
    type(row_t), allocatable :: row(:)
    integer, allocatable :: row_of(:)    !! (n_unknowns) row that determines the unknown, 0: none
  end type constraints_t

  !> Z of one element: its unknowns in terms of free ones.
  type :: reduction_t
    integer, allocatable :: free(:)      !! (m) free unknowns
    real(dp), allocatable :: Z(:, :)     !! (n, m)
  end type reduction_t

contains

  !> Makes an empty set.
  pure subroutine clear_constraints(constraints, n_unknowns)
    type(constraints_t), intent(out) :: constraints
    integer, intent(in) :: n_unknowns

    allocate (constraints%row(0), constraints%row_of(n_unknowns))
    constraints%row_of = 0
  end subroutine clear_constraints

  !> Adds, to an empty set, unknowns that are sums of others which are no such sums.
  pure subroutine add_followers(constraints, follower, master, coefficient)
    type(constraints_t), intent(inout) :: constraints
    integer, intent(in) :: follower(:)            !! (n)
    integer, intent(in) :: master(:, :)           !! (m, n)
    real(dp), intent(in) :: coefficient(:, :)     !! (m, n)
    integer :: i

    deallocate (constraints%row)
    allocate (constraints%row(size(follower)))
    do i = 1, size(follower)
      constraints%row(i)%slave = follower(i)
      constraints%row(i)%master = master(:, i)
      constraints%row(i)%coefficient = coefficient(:, i)
      constraints%row_of(follower(i)) = i
    end do
  end subroutine add_followers

  !> Adds coefficient . d(unknown) = given.
  !>
  !> A row that follows from earlier ones is left out. Errors: it contradicts them.
  pure subroutine add_constraint(constraints, unknown, coefficient, span, given, error)
    type(constraints_t), intent(inout) :: constraints
    integer, intent(in) :: unknown(:)
    real(dp), intent(in) :: coefficient(:) !! displacement per unknown
    real(dp), intent(in) :: span(:)        !! displacement that a unit of each unknown makes
    real(dp), intent(in) :: given          !! displacement
    type(error_t), allocatable, intent(out) :: error
    type(row_t) :: new
    integer, allocatable :: all_unknown(:)
    real(dp), allocatable :: all_coefficient(:)
    real(dp) :: share, largest
    integer :: i, k, row, pivot

    allocate (all_unknown(0), all_coefficient(0))
    new%given = given
    do i = 1, size(unknown)
      row = constraints%row_of(unknown(i))
      if (row == 0) then
        call accumulate(all_unknown, all_coefficient, unknown(i), coefficient(i))
      else
        associate (known => constraints%row(row))
          new%given = new%given - coefficient(i)*known%given
          do k = 1, size(known%master)
            call accumulate(all_unknown, all_coefficient, known%master(k), coefficient(i)*known%coefficient(k))
          end do
        end associate
      end if
    end do

    pivot = 0
    largest = redundant
    do i = 1, size(all_unknown)
      share = abs(all_coefficient(i))/span_of(all_unknown(i))
      if (share > largest) then
        pivot = i
        largest = share
      end if
    end do
    if (pivot == 0) then
      if (abs(new%given) > redundant*maxval(abs(coefficient))*maxval(span)) &
        call fail(error, status_run_failed, 'its fixed points prescribe displacements that contradict each other')
      return
    end if
    new%slave = all_unknown(pivot)
    new%given = new%given/all_coefficient(pivot)
    all_coefficient = -all_coefficient/all_coefficient(pivot)
    new%master = pack(all_unknown, all_unknown /= new%slave)
    new%coefficient = pack(all_coefficient, all_unknown /= new%slave)

    do k = 1, size(constraints%row)
      call substitute(constraints%row(k), new)
    end do
    constraints%row = [constraints%row, new]
    constraints%row_of(new%slave) = size(constraints%row)

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

  !> Adds a coefficient to a list of unknowns.
  pure subroutine accumulate(unknown, coefficient, new_unknown, new_coefficient)
    integer, allocatable, intent(inout) :: unknown(:)
    real(dp), allocatable, intent(inout) :: coefficient(:)
    integer, intent(in) :: new_unknown
    real(dp), intent(in) :: new_coefficient
    integer :: at

    at = findloc(unknown, new_unknown, 1)
    if (at > 0) then
      coefficient(at) = coefficient(at) + new_coefficient
    else
      unknown = [unknown, new_unknown]
      coefficient = [coefficient, new_coefficient]
    end if
  end subroutine accumulate

  !> Replaces the slave of `new` among the masters of `row`.
  pure subroutine substitute(row, new)
    type(row_t), intent(inout) :: row
    type(row_t), intent(in) :: new
    real(dp) :: share
    integer :: at, k

    at = findloc(row%master, new%slave, 1)
    if (at == 0) return
    share = row%coefficient(at)
    row%master = [row%master(:at - 1), row%master(at + 1:)]
    row%coefficient = [row%coefficient(:at - 1), row%coefficient(at + 1:)]
    row%given = row%given + share*new%given
    do k = 1, size(new%master)
      call accumulate(row%master, row%coefficient, new%master(k), share*new%coefficient(k))
    end do
  end subroutine substitute

  !> Sets every slave from its masters: a displacement with the given values, a rate or correction without.
  pure subroutine complete_unknowns(constraints, d, homogeneous)
    type(constraints_t), intent(in) :: constraints
    real(dp), intent(inout) :: d(:)       !! (n_unknowns)
    logical, intent(in) :: homogeneous
    integer :: k

    do k = 1, size(constraints%row)
      associate (row => constraints%row(k))
        d(row%slave) = dot_product(row%coefficient, d(row%master))
        if (.not. homogeneous) d(row%slave) = d(row%slave) + row%given
      end associate
    end do
  end subroutine complete_unknowns

  !> Free unknowns of one element and its Z; leaves both unallocated where no unknown is a slave.
  pure subroutine reduce_element(constraints, unknown, reduction)
    type(constraints_t), intent(in) :: constraints
    integer, intent(in) :: unknown(:)     !! (n) of the element
    type(reduction_t), intent(out) :: reduction
    integer :: i, k

    if (all(constraints%row_of(unknown) == 0)) return
    reduction%free = pack(unknown, constraints%row_of(unknown) == 0)
    do i = 1, size(unknown)
      if (constraints%row_of(unknown(i)) == 0) cycle
      associate (master => constraints%row(constraints%row_of(unknown(i)))%master)
        do k = 1, size(master)
          if (all(reduction%free /= master(k))) reduction%free = [reduction%free, master(k)]
        end do
      end associate
    end do
    allocate (reduction%Z(size(unknown), size(reduction%free)), source=0.0_dp)
    do i = 1, size(unknown)
      if (constraints%row_of(unknown(i)) == 0) then
        reduction%Z(i, findloc(reduction%free, unknown(i), 1)) = 1.0_dp
      else
        associate (row => constraints%row(constraints%row_of(unknown(i))))
          do k = 1, size(row%master)
            reduction%Z(i, findloc(reduction%free, row%master(k), 1)) = row%coefficient(k)
          end do
        end associate
      end if
    end do
  end subroutine reduce_element

end module scree_constraints
