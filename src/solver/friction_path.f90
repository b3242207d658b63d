!> The solution of a friction problem that Newton's iteration does not find: along a path, one spring at a time.
!>
!> From any x0 the path  F(x) = (1 - t) F(x0)  leads to a solution at t = 1. F is linear in pieces, and so the path is straight in
!> each; where it meets the face to another piece one spring changes its state, and the matrix by one row and column. Where the
!> determinant changes its sign with that, t turns back: the path goes on, where Newton's iteration with or without a line
!> search is lost (Eaves 1976; Ralph 1994). Another path brings springs together from apart (Lemke 1965): it is longer, and sure.
!>
!> The directions come from the factors of a matrix on the way, and those of a small one for the springs that have changed since
!> (Woodbury).
module scree_friction_path
  use scree_dense_solver, only: dgesv
  use scree_errors, only: error_t
  use scree_friction_problem, only: add_spring_force, add_springs, closed_forces, friction_problem_t, obey_law, &
                                    rates_of, spring_back, spring_forth, spring_locked, spring_open, spring_pulled, spring_t
  use scree_interruption, only: stop_signal
  use scree_kinds, only: dp
  use scree_linear_solver, only: factorise, linear_solver_t, solve_with_factors
  use scree_sparse_matrix, only: sparse_matrix_t, times
  use scree_timers, only: timers_t
  implicit none
  private
  public :: bring_together, follow_path

  !> Springs that change before a matrix is factorised anew.
  integer, parameter :: most_changed = 48
  !> Number of pieces after which t must be at least the fraction of `most` pieces that have been crossed since. A path that wanders
  !> hardly ever satisfies this.
  integer, parameter :: few_pieces = 100
  !> The start is moved by this ratio of the largest overlap, because in a symmetric scene several springs would touch at once.
  real(dp), parameter :: off_symmetry = 1e-8_dp
  real(dp), parameter :: golden = 0.6180339887498949_dp !! parts the unknowns from each other

  !> The path so far.
  type :: friction_path_t
    logical :: refines = .false.                    !! its directions, by what they leave
    logical :: goes_on = .false.                    !! its matrix and direction are known where it is
    logical :: found = .false.                      !! it has come to a solution
    integer :: pieces = 0                           !! crossed so far
    real(dp), allocatable :: x(:)                   !! (n)
    real(dp) :: t = 0.0_dp
    real(dp) :: sense = 1.0_dp                      !! of t
    integer, allocatable :: state(:)                !! (m)
    logical, allocatable :: turned(:)               !! (m) t turned back where they changed
    real(dp), allocatable :: pressing(:), shear(:)  !! (m) forces as if closed and locked
    real(dp), allocatable :: pressing_rate(:), shear_rate(:) !! (m) by t
    real(dp), allocatable :: start_force(:)         !! (n) F(x0)
    real(dp), allocatable :: apart(:, :)            !! (2, m) what pressing forces are lower and limits of shear higher by at t = 0
    real(dp), allocatable :: direction(:)           !! (n) of x by t
    ! the matrix that has factors
    type(sparse_matrix_t) :: matrix
    integer :: factors = 0                          !! so far
    integer, allocatable :: base_state(:)           !! (m) of its springs
    real(dp), allocatable :: base_direction(:)      !! (n)
    integer :: n_changed = 0
    integer :: changed(most_changed) = 0            !! springs that are not, or were not, in their base state
    real(dp), allocatable :: answer(:, :)           !! (n, 2 most_changed) of the matrix to unit forces across and along them
    real(dp), allocatable :: influence(:, :)        !! (2 most_changed, 2 most_changed) what those forces move their rows by
  end type friction_path_t

contains

  !> Follows the path from `x` to a solution. Where it ends elsewhere, `found` is false and `x` and `state` mean nothing; `turned`
  !> tells what it is that leads it back.
  subroutine follow_path(problem, most, patient, solver, timers, x, state, found, factors, pieces, turned)
    type(friction_problem_t), intent(in) :: problem
    integer, intent(in) :: most                !! pieces to cross
    logical, intent(in) :: patient             !! it may wander
    type(linear_solver_t), intent(inout) :: solver !! of matrices of the problem's pattern
    type(timers_t), intent(inout) :: timers
    real(dp), intent(inout), contiguous :: x(:)            !! (n)
    integer, intent(out) :: state(:)           !! (m) at the solution
    logical, intent(out) :: found
    integer, intent(out) :: factors            !! of matrices
    integer, intent(out) :: pieces             !! crossed
    logical, intent(out) :: turned(:)          !! (m) springs where t turned back as they changed
    type(friction_path_t) :: path

    call begin_path(problem, x, solver, timers, path)
    call cross_pieces(problem, most, patient, solver, timers, path)
    call take_end(path, x, state, found, factors, pieces)
    turned = path%turned
  end subroutine follow_path

  !> Follows the path on which springs come together from apart. At t = 0 their gaps are widened until none of them presses. The
  !> limits of shear of their bonds are raised until no bond yields. As t grows to 1 both changes are taken back.
  !>
  !> If all springs come from apart, A is positive definite and forces act along the rows of changes, the path leads to a solution.
  !> Solutions are then bounded for every t, and before t = 0 there is nothing but the start, so the path can neither end nor return
  !> there (doc/theory/open-close.md, eq-apart). The widening differs from spring to spring, so that no two springs touch at once.
  !> Bonds come from apart only together with all springs.
  subroutine bring_together(problem, is_apart, most, refined, solver, timers, x, state, found, factors, pieces)
    type(friction_problem_t), intent(in) :: problem
    logical, intent(in) :: is_apart(:)         !! (m) these springs
    integer, intent(in) :: most                !! pieces to cross
    logical, intent(in) :: refined             !! directions are, against rounding that turns the path round
    type(linear_solver_t), intent(inout) :: solver !! of matrices of the problem's pattern
    type(timers_t), intent(inout) :: timers
    real(dp), intent(inout), contiguous :: x(:) !! (n) where the others settle, then the solution
    integer, intent(out) :: state(:)           !! (m) at the solution
    logical, intent(out) :: found
    integer, intent(out) :: factors            !! of matrices
    integer, intent(out) :: pieces             !! crossed
    type(friction_path_t) :: path

    path%refines = refined
    call begin_apart(problem, is_apart, x, solver, timers, path)
    call cross_pieces(problem, most, .true., solver, timers, path)
    call take_end(path, x, state, found, factors, pieces)
  end subroutine bring_together

  !> Crosses the pieces of a path to a solution. If the path ends elsewhere, or a signal asks to stop, `path%found` is false.
  subroutine cross_pieces(problem, most, patient, solver, timers, path)
    type(friction_problem_t), intent(in) :: problem
    integer, intent(in) :: most                !! pieces to cross
    logical, intent(in) :: patient             !! it may wander
    type(linear_solver_t), intent(inout) :: solver !! of matrices of the problem's pattern
    type(timers_t), intent(inout) :: timers
    type(friction_path_t), intent(inout) :: path
    real(dp) :: way
    integer :: i, to

    do while (path%goes_on .and. stop_signal() == 0)
      call find_face(problem, path, way, i, to)
      path%found = path%sense > 0 .and. path%t + way >= 1
      if (path%found) way = 1 - path%t
      if (.not. path%found .and. i == 0) exit
      call go(path, way)
      if (path%found) exit
      path%pieces = path%pieces + 1
      if (path%pieces > most .or. (path%t*most < path%pieces - few_pieces .and. .not. patient)) exit
      call cross(problem, path, i, to, solver, timers)
    end do
    if (path%found) call end_path(problem, solver, path)
  end subroutine cross_pieces

  !> What a path has come to.
  pure subroutine take_end(path, x, state, found, factors, pieces)
    type(friction_path_t), intent(in) :: path
    real(dp), intent(out), contiguous :: x(:)  !! (n) where it ends
    integer, intent(out) :: state(:)           !! (m) there
    logical, intent(out) :: found
    integer, intent(out) :: factors            !! of matrices
    integer, intent(out) :: pieces             !! crossed

    x = path%x
    state = path%state
    found = path%found
    factors = path%factors
    pieces = path%pieces
  end subroutine take_end

  !> Begins the path near `x`.
  subroutine begin_path(problem, x, solver, timers, path)
    type(friction_problem_t), intent(in) :: problem
    real(dp), intent(in), contiguous :: x(:)
    type(linear_solver_t), intent(inout) :: solver
    type(timers_t), intent(inout) :: timers
    type(friction_path_t), intent(inout) :: path
    real(dp) :: overlap
    integer :: i, n

    n = size(x)
    call allocate_path(n, size(problem%spring), path)
    overlap = maxval(abs(problem%spring%pressing)/problem%spring%stiffness)
    path%x = x + off_symmetry*overlap*[(modulo(golden*i, 1.0_dp) - 0.5_dp, i=1, n)]/problem%span
    call find_rest(problem, path%x, path%state, path%start_force)
    call rebase(problem, path, solver, timers)
    if (path%goes_on) call find_direction(problem, solver, path)
  end subroutine begin_path

  !> Begins the path from apart: where forces balance without some contacts, and some bonds hold any shear.
  subroutine begin_apart(problem, is_apart, x, solver, timers, path)
    type(friction_problem_t), intent(in) :: problem
    logical, intent(in) :: is_apart(:)          !! (m) these springs
    real(dp), intent(in), contiguous :: x(:)    !! (n) where the others settle
    type(linear_solver_t), intent(inout) :: solver
    type(timers_t), intent(inout) :: timers
    type(friction_path_t), intent(inout) :: path
    real(dp) :: beyond, gap, limit
    integer :: i

    call allocate_path(size(problem%force), size(problem%spring), path)
    associate (spring => problem%spring)
      path%x = x
      call find_rest(problem, x, path%state, path%start_force)
      where (is_apart) path%state = merge(spring_locked, spring_open, spring%bonded)
      call measure(problem, path)
      path%start_force = problem%force - times(problem%matrix, x)
      do i = 1, size(spring)
        limit = spring(i)%friction*path%pressing(i) + spring(i)%cohesion
        call add_spring_force(problem, i, forces_in(path%state(i), path%pressing(i), path%shear(i), limit), path%start_force)
      end do
      call rebase(problem, path, solver, timers)
      if (.not. path%goes_on) return
      path%x = path%x + path%base_direction
      path%start_force = 0.0_dp
      path%base_direction = 0.0_dp
      call measure(problem, path)
      gap = max(0.0_dp, maxval(abs(path%pressing)/spring%stiffness, is_apart .and. .not. spring%bonded))
      beyond = max(0.0_dp, maxval(abs(path%shear) + spring%friction*abs(path%pressing), is_apart .and. spring%bonded))
      do i = 1, size(spring)
        if (.not. is_apart(i)) cycle
        if (spring(i)%bonded) path%apart(2, i) = beyond*(1 + modulo(golden*i, 1.0_dp))
        if (.not. spring(i)%bonded) path%apart(1, i) = gap*spring(i)%stiffness*(1 + modulo(golden*i, 1.0_dp))
      end do
      call measure(problem, path)
    end associate
    call find_direction(problem, solver, path)
  end subroutine begin_apart

  !> Makes room for n unknowns and m springs.
  pure subroutine allocate_path(n, m, path)
    integer, intent(in) :: n, m
    type(friction_path_t), intent(inout) :: path

    allocate (path%pressing(m), path%shear(m), path%pressing_rate(m), path%shear_rate(m), path%state(m), &
              path%answer(n, 2*most_changed), path%influence(2*most_changed, 2*most_changed), path%start_force(n))
    allocate (path%apart(2, m), source=0.0_dp)
    allocate (path%turned(m), source=.false.)
  end subroutine allocate_path

  !> Forces of the springs as if closed and locked, where the path is.
  pure subroutine measure(problem, path)
    type(friction_problem_t), intent(in) :: problem
    type(friction_path_t), intent(inout) :: path
    real(dp) :: closed(2)
    integer :: i

    do i = 1, size(path%state)
      closed = closed_forces(problem, i, path%x)
      path%pressing(i) = closed(1) - (1 - path%t)*path%apart(1, i)
      path%shear(i) = closed(2)
    end do
  end subroutine measure

  !> Takes away what rounding left on the way: a correction in the last piece.
  subroutine end_path(problem, solver, path)
    type(friction_problem_t), intent(in) :: problem
    type(linear_solver_t), intent(inout) :: solver
    type(friction_path_t), intent(inout) :: path
    type(error_t), allocatable :: error
    integer :: state(size(path%state))

    call find_rest(problem, path%x, state, path%start_force)
    if (any(state /= path%state)) return
    path%apart = 0.0_dp
    call solve_with_factors(solver, path%start_force, path%base_direction, error)
    if (allocated(error)) return
    call find_direction(problem, solver, path)
    if (path%goes_on) path%x = path%x + path%direction
  end subroutine end_path

  !> States of the springs at `x`, and what they leave out of balance.
  pure subroutine find_rest(problem, x, state, rest)
    type(friction_problem_t), intent(in) :: problem
    real(dp), intent(in), contiguous :: x(:)
    integer, intent(out) :: state(:)
    real(dp), intent(out), contiguous :: rest(:)
    real(dp) :: force(2)
    integer :: i

    rest = problem%force - times(problem%matrix, x)
    do i = 1, size(state)
      call obey_law(problem%spring(i), closed_forces(problem, i, x), state(i), force)
      call add_spring_force(problem, i, force, rest)
    end do
  end subroutine find_rest

  !> Factorises the matrix of the present piece.
  subroutine rebase(problem, path, solver, timers)
    type(friction_problem_t), intent(in) :: problem
    type(friction_path_t), intent(inout) :: path
    type(linear_solver_t), intent(inout) :: solver
    type(timers_t), intent(inout) :: timers
    type(error_t), allocatable :: error
    real(dp) :: change(2, 2, size(path%state)), force(size(path%x))
    integer :: i

    path%matrix = problem%matrix
    do i = 1, size(path%state)
      change(:, :, i) = change_of_state(problem%spring(i), path%state(i))
    end do
    call add_springs(problem, change, path%matrix)
    call factorise(solver, path%matrix, timers, error)
    path%factors = path%factors + 1
    path%goes_on = .not. allocated(error)
    if (.not. path%goes_on) return
    if (.not. allocated(path%base_direction)) allocate (path%base_direction(size(path%x)))
    force = path%start_force
    do i = 1, size(path%state)
      call add_spring_force(problem, i, gain(problem, path, i, path%state(i)), force)
    end do
    call solve_with_factors(solver, force, path%base_direction, error)
    path%goes_on = .not. allocated(error)
    path%base_state = path%state
    path%n_changed = 0
    call measure(problem, path)
  end subroutine rebase

  !> What the forces of spring i, across and along, gain in a state as it comes from apart, by t where nothing moves.
  pure function gain(problem, path, i, state) result(force)
    type(friction_problem_t), intent(in) :: problem
    type(friction_path_t), intent(in) :: path
    integer, intent(in) :: i, state
    real(dp) :: force(2)

    associate (apart => path%apart(:, i))
      force = forces_in(state, apart(1), 0.0_dp, problem%spring(i)%friction*apart(1) - apart(2))
    end associate
  end function gain

  !> Forces of a spring across and along in a state, or what they change by: of those as if closed and locked, and of the limit.
  pure function forces_in(state, pressing, shear, limit) result(force)
    integer, intent(in) :: state
    real(dp), intent(in) :: pressing, shear, limit
    real(dp) :: force(2)

    force = [pressing, 0.0_dp]
    select case (state)
    case (spring_open)
      force = 0.0_dp
    case (spring_locked)
      force(2) = shear
    case (spring_forth)
      force(2) = -limit
    case (spring_back)
      force(2) = limit
    end select
  end function forces_in

  !> What the forces of a spring change by: (force across or along, change across or along), force/length.
  pure function change_of_state(spring, state) result(change)
    type(spring_t), intent(in) :: spring
    integer, intent(in) :: state
    real(dp) :: change(2, 2)

    change = 0.0_dp
    if (state == spring_open) return
    change(1, 1) = spring%stiffness
    select case (state)
    case (spring_locked)
      change(2, 2) = spring%shear_stiffness
    case (spring_forth)
      change(2, 1) = -spring%friction*spring%stiffness
    case (spring_back)
      change(2, 1) = spring%friction*spring%stiffness
    end select
  end function change_of_state

  !> Direction in the present piece, and what the forces of the springs change by on it.
  subroutine find_direction(problem, solver, path)
    type(friction_problem_t), intent(in) :: problem
    type(linear_solver_t), intent(inout) :: solver
    type(friction_path_t), intent(inout) :: path
    type(error_t), allocatable :: error
    real(dp) :: change(size(path%x)), more(2*path%n_changed)
    integer :: k
    logical :: done

    do k = 1, path%n_changed
      associate (s => path%changed(k))
        more(2*k - 1:2*k) = gain(problem, path, s, path%state(s)) - gain(problem, path, s, path%base_state(s))
      end associate
    end do
    change = path%base_direction
    call answer_as_changed(problem, path, more, change, done)
    path%direction = change
    call find_rates(problem, path)
    path%goes_on = done
    if (.not. (done .and. path%refines)) return
    call solve_with_factors(solver, left_by_direction(problem, path), change, error)
    done = .not. allocated(error)
    more = 0.0_dp
    if (done) call answer_as_changed(problem, path, more, change, done)
    path%goes_on = done
    path%direction = path%direction + change
    call find_rates(problem, path)
  end subroutine find_direction

  !> Takes what the matrix that has factors answers to forces to what that of the present piece does, to more of them (Woodbury).
  subroutine answer_as_changed(problem, path, more, answer, done)
    type(friction_problem_t), intent(in) :: problem
    type(friction_path_t), intent(in) :: path
    real(dp), intent(in) :: more(:)                  !! (2 n_changed) forces across and along the springs that have changed
    real(dp), intent(inout), contiguous :: answer(:) !! (n)
    logical, intent(out) :: done
    real(dp) :: change(2, 2)
    real(dp) :: A(2*path%n_changed, 2*path%n_changed), force(2*path%n_changed, 1)
    integer :: info, k, pivot(2*path%n_changed)

    done = .true.
    associate (m => path%n_changed)
      if (m == 0) return
      do k = 1, m
        associate (s => path%changed(k))
          change = change_of_state(problem%spring(s), path%state(s)) - change_of_state(problem%spring(s), path%base_state(s))
          A(2*k - 1:2*k, :) = matmul(change, path%influence(2*k - 1:2*k, :2*m))
          force(2*k - 1:2*k, 1) = more(2*k - 1:2*k) - matmul(change, rates_of(problem, s, answer))
        end associate
      end do
      do k = 1, 2*m
        A(k, k) = A(k, k) + 1.0_dp
      end do
      call dgesv(2*m, 1, A, 2*m, pivot, force, 2*m, info)
      done = info == 0
      answer = answer + matmul(path%answer(:, :2*m), force(:, 1))
    end associate
  end subroutine answer_as_changed

  !> What the forces of the springs, as if closed and locked, change by along the direction.
  pure subroutine find_rates(problem, path)
    type(friction_problem_t), intent(in) :: problem
    type(friction_path_t), intent(inout) :: path
    real(dp) :: moved(2)
    integer :: i

    do i = 1, size(path%state)
      moved = rates_of(problem, i, path%direction)
      path%pressing_rate(i) = path%apart(1, i) - problem%spring(i)%stiffness*moved(1)
      path%shear_rate(i) = -problem%spring(i)%shear_stiffness*moved(2)
    end do
  end subroutine find_rates

  !> Forces by t that the direction leaves out of balance: those of rounding.
  pure function left_by_direction(problem, path) result(rest)
    type(friction_problem_t), intent(in) :: problem
    type(friction_path_t), intent(in) :: path
    real(dp) :: rest(size(path%x))
    real(dp) :: limit
    integer :: i

    rest = path%start_force - times(problem%matrix, path%direction)
    do i = 1, size(path%state)
      if (path%state(i) == spring_open) cycle
      limit = problem%spring(i)%friction*path%pressing_rate(i) - path%apart(2, i)
      call add_spring_force(problem, i, forces_in(path%state(i), path%pressing_rate(i), path%shear_rate(i), limit), rest)
    end do
  end function left_by_direction

  !> The next face on the way: how far, of which spring (0: none), and the state behind it.
  pure subroutine find_face(problem, path, way, spring, to)
    type(friction_problem_t), intent(in) :: problem
    type(friction_path_t), intent(in) :: path
    real(dp), intent(out) :: way !! in t
    integer, intent(out) :: spring, to
    real(dp) :: left(2), rate(2), own
    integer :: behind(2), i, k

    way = huge(way)
    spring = 0
    to = spring_open
    do i = 1, size(path%state)
      call faces_of(problem%spring(i), path%state(i), path%pressing(i), path%shear(i), path%sense*path%pressing_rate(i), &
                    path%sense*path%shear_rate(i), (1 - path%t)*path%apart(2, i), -path%sense*path%apart(2, i), left, rate, behind)
      do k = 1, 2
        if (.not. rate(k) < 0) cycle
        own = max(left(k), 0.0_dp)/(-rate(k))
        if (own >= way) cycle
        way = own
        spring = i
        to = behind(k)
      end do
    end do
  end subroutine find_face

  !> How far the forces of a spring are from its faces, how fast that changes, and which states are behind them. What begins to rub
  !> may turn out to slide back where it does.
  pure subroutine faces_of(spring, state, pressing, shear, pressing_rate, shear_rate, higher, higher_rate, left, rate, behind)
    type(spring_t), intent(in) :: spring
    integer, intent(in) :: state
    real(dp), intent(in) :: pressing, shear             !! force
    real(dp), intent(in) :: pressing_rate, shear_rate   !! force
    real(dp), intent(in) :: higher, higher_rate         !! what the limit of shear is higher by, and what that changes by, force
    real(dp), intent(out) :: left(2), rate(2)           !! force
    integer, intent(out) :: behind(2)
    real(dp) :: limit, limit_rate, turn

    left = 0.0_dp
    rate = 0.0_dp
    behind = state
    limit = spring%friction*pressing + spring%cohesion + higher
    limit_rate = spring%friction*pressing_rate + higher_rate
    turn = merge(1.0_dp, -1.0_dp, state == spring_back)
    select case (state)
    case (spring_open)
      left(1) = -pressing
      rate(1) = -pressing_rate
      behind(1) = spring_forth
    case (spring_forth, spring_back)
      if (spring%bonded) then
        left(1) = limit
        rate(1) = limit_rate
        behind(1) = spring_pulled
      else
        left(1) = pressing
        rate(1) = pressing_rate
        behind(1) = spring_open
      end if
      if (spring%friction > 0 .or. spring%cohesion > 0) then
        left(2) = turn*shear - limit
        rate(2) = turn*shear_rate - limit_rate
        behind(2) = spring_locked
      end if
    case (spring_locked)
      left = limit - [shear, -shear]
      rate = limit_rate - [shear_rate, -shear_rate]
      behind = [spring_back, spring_forth]
    case (spring_pulled)
      left(1) = -limit
      rate(1) = -limit_rate
      behind(1) = spring_forth
    end select
  end subroutine faces_of

  !> Goes along the direction.
  pure subroutine go(path, way)
    type(friction_path_t), intent(inout) :: path
    real(dp), intent(in) :: way !! in t

    path%x = path%x + path%sense*way*path%direction
    path%t = path%t + path%sense*way
    path%pressing = path%pressing + path%sense*way*path%pressing_rate
    path%shear = path%shear + path%sense*way*path%shear_rate
  end subroutine go

  !> Crosses the face to another state of a spring, and finds the direction behind it, which leads away from the face.
  subroutine cross(problem, path, i, to, solver, timers)
    type(friction_problem_t), intent(in) :: problem
    type(friction_path_t), intent(inout) :: path
    integer, intent(in) :: i, to
    type(linear_solver_t), intent(inout) :: solver
    type(timers_t), intent(inout) :: timers
    real(dp) :: left(2), rate(2)
    integer :: behind(2), from, k

    from = path%state(i)
    path%state(i) = to
    if ((from == spring_open .or. from == spring_pulled) .and. slides_back(path%shear(i), path%sense*path%shear_rate(i))) &
      path%state(i) = spring_back
    call register(problem, path, i, solver, timers)
    if (path%goes_on) call find_direction(problem, solver, path)
    if (.not. path%goes_on) return
    call faces_of(problem%spring(i), path%state(i), path%pressing(i), path%shear(i), path%pressing_rate(i), path%shear_rate(i), &
                  (1 - path%t)*path%apart(2, i), -path%apart(2, i), left, rate, behind)
    k = max(1, findloc(behind == from, .true., 1))
    path%turned(i) = path%turned(i) .or. rate(k)*path%sense < 0
    path%sense = sign(1.0_dp, rate(k))
  end subroutine cross

  !> Whether a spring that begins to rub, as its limit grows from nothing, slides back.
  pure logical function slides_back(shear, rate)
    real(dp), intent(in) :: shear, rate !! force, and what it changes by on the way

    slides_back = shear > 0 .or. (.not. shear < 0 .and. rate > 0)
  end function slides_back

  !> Makes spring i one of those that have changed.
  subroutine register(problem, path, i, solver, timers)
    type(friction_problem_t), intent(in) :: problem
    type(friction_path_t), intent(inout) :: path
    integer, intent(in) :: i
    type(linear_solver_t), intent(inout) :: solver
    type(timers_t), intent(inout) :: timers
    type(error_t), allocatable :: error
    real(dp) :: unit(size(path%x))
    integer :: c, k, m

    path%goes_on = .true.
    if (any(path%changed(:path%n_changed) == i)) return
    if (path%n_changed == most_changed) then
      call rebase(problem, path, solver, timers)
      return
    end if
    m = path%n_changed + 1
    path%n_changed = m
    path%changed(m) = i
    do c = 2*m - 1, 2*m
      unit = 0.0_dp
      call add_spring_force(problem, i, merge([1.0_dp, 0.0_dp], [0.0_dp, 1.0_dp], c == 2*m - 1), unit)
      call solve_with_factors(solver, unit, path%answer(:, c), error)
      path%goes_on = .not. allocated(error)
      if (.not. path%goes_on) return
      do k = 1, m
        path%influence(2*k - 1:2*k, c) = rates_of(problem, path%changed(k), path%answer(:, c))
      end do
    end do
    do c = 1, 2*m - 2
      path%influence(2*m - 1:2*m, c) = rates_of(problem, i, path%answer(:, c))
    end do
  end subroutine register

end module scree_friction_path
