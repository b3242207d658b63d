!> Linear equations with springs that press and rub but do not pull. Their solution is the step of bodies in contact if entrance
!> lines and anchors of shear springs stay where they are.
!>
!>     f - A x + sum_i (N_i n_i + T_i t_i) = 0
!>     N_i = max(0, N0_i - p_i n'_i.x)                          pressing
!>     T_i = T0_i - k_i t'_i.x, held within +-max(0, mu_i N_i + c_i)   rubbing
!>
!> The left side is continuous and linear in pieces: a piece for each choice of states, open, sliding or locked, of its springs.
!> As inertia is in A, it has a solution. That is a solution of complementarity with friction, not of a minimum: pieces may have
!> matrices of negative determinant, where Newton's iteration runs in circles.
!>
!> The proof of existence is in doc/theory/open-close.md, eq-existence.
module scree_friction_problem
  use scree_kinds, only: dp
  use scree_sparse_matrix, only: add_element, on_fewer_places, sparse_matrix_t, times
  implicit none
  private
  public :: acts_on, add_spring_force, add_springs, closed_forces, forces_left, friction_problem_t, keep_rows_of_forces, obey_law, &
            of_springs, place_springs, posed_problem_t, rates_of, spring_t, unknowns_about

  !> State of a spring: open; sliding along its row or back; locked; or bonded and pulled, without friction.
  integer, parameter, public :: spring_open = 0, spring_forth = 1, spring_back = 2, spring_locked = 3, spring_pulled = 4
  !> That of one that a part of a problem does not have.
  integer, parameter, public :: spring_elsewhere = -1

  !> What a spring is, but for its rows.
  type :: spring_t
    integer :: slot = 0                   !! its place among the element matrices of the pattern
    real(dp) :: pressing = 0.0_dp         !! N0, force
    real(dp) :: stiffness = 0.0_dp        !! p, force/length
    real(dp) :: shear = 0.0_dp            !! T0, force
    real(dp) :: shear_stiffness = 0.0_dp  !! k, force/length
    real(dp) :: friction = 0.0_dp         !! mu
    real(dp) :: cohesion = 0.0_dp         !! c, force
    logical :: bonded = .false.           !! it pulls too: N is not held above 0
  end type spring_t

  !> The equations. Rows of springs are short; unused places have row 1 and value 0.
  type :: friction_problem_t
    type(sparse_matrix_t) :: matrix                !! A, on a pattern that has room for the springs
    logical :: symmetric = .true.                  !! n' is n, t' is t
    real(dp), allocatable :: force(:)              !! (n) f
    real(dp), allocatable :: span(:)               !! (n) displacement that a unit of each unknown makes
    type(spring_t), allocatable :: spring(:)       !! (m)
    integer, allocatable :: length(:)              !! (m) of the rows of each spring
    integer, allocatable :: row(:, :)              !! (w, m) unknowns of each spring
    real(dp), allocatable :: normal(:, :)          !! (w, m) n
    real(dp), allocatable :: shear(:, :)           !! (w, m) t
    real(dp), allocatable :: normal_change(:, :)   !! (w, m) n'
    real(dp), allocatable :: shear_change(:, :)    !! (w, m) t'
  end type friction_problem_t

  !> A problem, and what came of it.
  type :: posed_problem_t
    type(friction_problem_t) :: problem
    logical :: near = .false.                      !! zero was near the solution
    logical :: found = .false.                     !! there was one
  end type posed_problem_t

contains

  !> Forces of spring i across and along at `x` as if it were closed and locked.
  pure function closed_forces(problem, i, x) result(force)
    type(friction_problem_t), intent(in) :: problem
    integer, intent(in) :: i
    real(dp), intent(in), contiguous :: x(:)  !! (n)
    real(dp) :: force(2)

    associate (spring => problem%spring(i))
      force = [spring%pressing, spring%shear] - [spring%stiffness, spring%shear_stiffness]*rates_of(problem, i, x)
    end associate
  end function closed_forces

  !> What the rows of spring i change by with `x`, across and along.
  pure function rates_of(problem, i, x) result(rate)
    type(friction_problem_t), intent(in) :: problem
    integer, intent(in) :: i
    real(dp), intent(in), contiguous :: x(:) !! (n)
    real(dp) :: rate(2), across, along
    integer :: k

    across = 0.0_dp ! sums in memory, as those of a result are, wait for each other
    along = 0.0_dp
    do k = 1, problem%length(i)
      across = across + problem%normal_change(k, i)*x(problem%row(k, i))
      along = along + problem%shear_change(k, i)*x(problem%row(k, i))
    end do
    rate = [across, along]
  end function rates_of

  !> State and forces, across and along, of a spring.
  pure subroutine obey_law(spring, closed, state, force)
    type(spring_t), intent(in) :: spring
    real(dp), intent(in) :: closed(2)  !! as if closed and locked, force
    integer, intent(out) :: state
    real(dp), intent(out) :: force(2)
    real(dp) :: limit

    state = spring_open
    force = 0.0_dp
    if (closed(1) < 0 .and. .not. spring%bonded) return
    limit = spring%friction*closed(1) + spring%cohesion
    state = spring_locked
    force = closed
    if (abs(closed(2)) < limit) return
    state = merge(spring_back, spring_forth, closed(2) > 0)
    if (limit < 0) state = spring_pulled
    force(2) = sign(max(0.0_dp, limit), closed(2))
  end subroutine obey_law

  !> States of the springs at `x`, and the forces that they leave out of balance over the largest that acts.
  pure subroutine forces_left(problem, x, state, left)
    type(friction_problem_t), intent(in) :: problem
    real(dp), intent(in), contiguous :: x(:)
    integer, intent(out) :: state(:)
    real(dp), intent(out) :: left
    real(dp) :: rest(size(x)), closed(2), force(2), largest
    integer :: i

    rest = problem%force - times(problem%matrix, x)
    largest = max(maxval(abs(problem%force)/problem%span), tiny(largest))
    do i = 1, size(state)
      closed = closed_forces(problem, i, x)
      call obey_law(problem%spring(i), closed, state(i), force)
      largest = max(largest, force(1))
      call add_spring_force(problem, i, force, rest)
    end do
    left = maxval(abs(rest)/problem%span)/largest
    if (.not. left <= huge(left)) left = huge(left) ! NaN
  end subroutine forces_left

  !> Adds forces of spring i, across and along, to forces on the unknowns.
  pure subroutine add_spring_force(problem, i, force, sum)
    type(friction_problem_t), intent(in) :: problem
    integer, intent(in) :: i
    real(dp), intent(in) :: force(2)
    real(dp), intent(inout), contiguous :: sum(:) !! (n) force
    integer :: k

    do k = 1, problem%length(i)
      associate (own => sum(problem%row(k, i)))
        own = own + force(1)*problem%normal(k, i) + force(2)*problem%shear(k, i)
      end associate
    end do
  end subroutine add_spring_force

  !> Adds what the forces of the springs change by to a matrix of the problem's pattern. The symmetric matrix beside it is without
  !> friction, and so definite.
  pure subroutine add_springs(problem, change, matrix)
    type(friction_problem_t), intent(in) :: problem
    real(dp), intent(in) :: change(:, :, :)  !! (force across or along, change across or along, m) force/length
    type(sparse_matrix_t), intent(inout) :: matrix
    real(dp), dimension(size(problem%row, 1), size(problem%row, 1)) :: dense, friction
    real(dp) :: across, along, rubbing
    integer :: i, k

    do i = 1, size(problem%spring)
      associate (w => problem%length(i))
        do k = 1, w
          across = change(1, 1, i)*problem%normal_change(k, i)
          rubbing = change(2, 1, i)*problem%normal_change(k, i)
          along = rubbing + change(2, 2, i)*problem%shear_change(k, i)
          dense(:w, k) = across*problem%normal(:w, i) + along*problem%shear(:w, i)
          friction(:w, k) = rubbing*problem%shear(:w, i)
        end do
        call add_element(matrix, problem%spring(i)%slot, dense(:, :w), &
                         problem%symmetric .and. .not. abs(change(2, 1, i)) > 0, friction(:, :w))
      end associate
    end do
  end subroutine add_springs

  !> Lets gaps and slips change by the rows of the forces.
  pure subroutine keep_rows_of_forces(problem)
    type(friction_problem_t), intent(inout) :: problem

    problem%normal_change = problem%normal
    problem%shear_change = problem%shear
    problem%symmetric = .true.
  end subroutine keep_rows_of_forces

  !> The problem of some of its springs alone, on a pattern that has room for these.
  pure type(friction_problem_t) function of_springs(problem, list) result(few)
    type(friction_problem_t), intent(in) :: problem
    integer, intent(in) :: list(:)            !! springs
    logical :: is_kept(size(problem%matrix%place_first) - 1)

    is_kept = .false.
    is_kept(problem%spring(list)%slot) = .true.
    few%matrix = on_fewer_places(problem%matrix, is_kept)
    few%symmetric = problem%symmetric
    few%force = problem%force
    few%span = problem%span
    few%spring = problem%spring(list)
    few%length = problem%length(list)
    few%row = problem%row(:, list)
    few%normal = problem%normal(:, list)
    few%shear = problem%shear(:, list)
    few%normal_change = problem%normal_change(:, list)
    few%shear_change = problem%shear_change(:, list)
  end function of_springs

  !> Unknowns that some springs act on, and `reach` times those that the matrix has room to couple with them.
  pure function unknowns_about(problem, is_seed, reach) result(is_about)
    type(friction_problem_t), intent(in) :: problem
    logical, intent(in) :: is_seed(:)            !! (m) springs
    integer, intent(in) :: reach
    logical :: is_about(size(problem%force))     !! (n) unknowns
    logical :: before(size(problem%force))
    integer :: i, j

    is_about = .false.
    do i = 1, size(is_seed)
      if (is_seed(i)) is_about(problem%row(:problem%length(i), i)) = .true.
    end do
    associate (matrix => problem%matrix)
      do i = 1, reach
        before = is_about
        do j = 1, matrix%n
          if (before(j)) is_about(matrix%row(matrix%first(j) + 1:matrix%first(j + 1)) + 1) = .true.
        end do
      end do
    end associate
  end function unknowns_about

  !> Whether each spring acts on any of some unknowns.
  pure function acts_on(problem, unknown) result(acts)
    type(friction_problem_t), intent(in) :: problem
    logical, intent(in) :: unknown(:)            !! (n)
    logical :: acts(size(problem%spring))
    integer :: i

    do i = 1, size(acts)
      acts(i) = any(unknown(problem%row(:problem%length(i), i)))
    end do
  end function acts_on

  !> Gives the problem room for m springs with rows up to w unknowns.
  pure subroutine place_springs(problem, m, w)
    type(friction_problem_t), intent(inout) :: problem
    integer, intent(in) :: m, w

    allocate (problem%spring(m), problem%length(m))
    allocate (problem%row(w, m), source=1)
    allocate (problem%normal(w, m), problem%shear(w, m), problem%normal_change(w, m), problem%shear_change(w, m), source=0.0_dp)
  end subroutine place_springs

end module scree_friction_problem
