!> The solution of a friction problem that Newton's iteration does not find: through the interior.
!>
!> Each spring has pairs of which one is zero in the solution, and none is below zero:
!>
!>     y w = 0      y: what presses, less the strength of a bond;  w = y - (what would press if it were closed)
!>     a s = 0      a = mu y - T: how far its shear is from the limit ahead;  s: how far it would be beyond
!>     b r = 0      b = mu y + T, and so behind
!>
!> An iteration keeps all of these numbers above zero and reduces the products together. It solves the equations as if each product
!> were a small number. It takes this number from the products that a first step towards zero would leave (Mehrotra 1992). No
!> theorem covers this iteration, because friction makes the problem unsymmetric. It needs some 20 matrices, whatever their size,
!> for steps in which Newton's iteration runs in circles (doc/theory/open-close.md, eq-complementarity). If it ends at a fold, the
!> limits of shear may follow the pressing forces with a delay of one iteration, which may lead round the fold. Each iteration then
!> solves a minimum problem, and its matrix is symmetric and definite wherever A is.
module scree_friction_interior
  use scree_errors, only: error_t
  use scree_friction_problem, only: add_spring_force, add_springs, closed_forces, forces_left, friction_problem_t, &
                                    rates_of, spring_t
  use scree_interruption, only: stop_signal
  use scree_kinds, only: dp
  use scree_linear_solver, only: approach, factorise, factorise_beside, linear_solver_t, solve_with_factors
  use scree_sparse_matrix, only: copy_values, sparse_matrix_t, times
  use scree_timers, only: timers_t
  implicit none
  private
  public :: begin_inside, few_unknowns, go_inside, inside_t

  !> Fraction of the longest step, at which the first number of a pair reaches zero, that an iteration goes.
  real(dp), parameter :: short_of = 0.99_dp
  !> A step shorter than this is taken again towards the middle of the interior.
  real(dp), parameter :: too_short = 0.1_dp
  !> Products are kept above the square of this ratio times the largest error of limits that follow. Smaller products make steps
  !> short.
  real(dp), parameter :: near_limits = 0.1_dp
  !> Residuals that the first try and the step itself may leave, over the forces. The next iteration takes up what is left.
  real(dp), parameter :: first_share = 1e-4_dp, step_share = 1e-6_dp
  !> Iterations from the symmetric matrix to a solution; where they take more, the factors of the matrix itself are cheaper.
  integer, parameter :: most_from_symmetric = 20
  !> Few unknowns: up to so many the matrices themselves are cheaper from the first on (columns and slopes of 100 to 697 blocks).
  integer, parameter :: few_unknowns = 3000

  !> Settings of a run of the interior iteration.
  type :: manner_t
    logical :: limits_follow           !! limits of shear follow what presses, an iteration behind: they change no matrix
    logical :: from_symmetric          !! solutions are found from the symmetric matrix at first
    integer :: most                    !! iterations
    integer :: most_short              !! short steps in a row, after which the way does not go on: it has a fold there
    real(dp) :: in_the_middle          !! of the mean of the products, to which a short step is taken again
  end type manner_t

  !> Ways of many unknowns have more folds. Where limits follow, short steps get round them, too: with half of the mean in the
  !> middle they stay short, with twice it products grow.
  type(manner_t), parameter :: with_few = manner_t(.false., .false., 45, 5, 0.5_dp)
  type(manner_t), parameter :: with_many = manner_t(.false., .true., 45, 5, 2.0_dp)
  type(manner_t), parameter :: following = manner_t(.true., .true., 200, 200, 1.0_dp)

  !> The pairs of one spring, forces.
  type :: pairs_t
    logical :: rubs = .false.          !! it has friction, or cohesion
    logical :: presses = .true.        !! y and w are a pair: but for a bond without friction
    real(dp) :: y = 1.0_dp, w = 1.0_dp
    real(dp) :: a = 1.0_dp, s = 1.0_dp
    real(dp) :: b = 1.0_dp, r = 1.0_dp
    logical :: follows = .false.       !! its limit does what presses, an iteration behind
    real(dp) :: limit = 1.0_dp         !! of T
    real(dp) :: shear = 0.0_dp         !! T
    real(dp) :: too_much(2) = 0.0_dp   !! what w and T are above what their equations say
  end type pairs_t

  !> A step of the pairs, or what their products are to be.
  type :: change_t
    real(dp) :: y = 0.0_dp, w = 0.0_dp, a = 0.0_dp, s = 0.0_dp, b = 0.0_dp, r = 0.0_dp, limit = 0.0_dp, shear = 0.0_dp
  end type change_t

  !> The way inside, as far as it went.
  type :: inside_t
    real(dp), allocatable :: x(:)            !! (n)
    integer :: factors = 0                   !! of matrices
    type(pairs_t), allocatable, private :: pairs(:)
    type(manner_t), private :: manner = with_few
    logical, private :: from_symmetric = .false. !! solutions are found from the symmetric matrix
  end type inside_t

contains

  !> Begins inside at `x`.
  subroutine begin_inside(problem, at_first, limits_follow, x, inside)
    type(friction_problem_t), intent(in) :: problem
    real(dp), intent(in) :: at_first      !! what the pairs begin with over the largest force
    logical, intent(in) :: limits_follow  !! limits of shear follow what presses, an iteration behind
    real(dp), intent(in), contiguous :: x(:) !! (n)
    type(inside_t), intent(inout) :: inside

    inside%x = x
    if (allocated(inside%pairs)) deallocate (inside%pairs)
    allocate (inside%pairs(size(problem%spring)))
    call begin_pairs(problem, at_first, x, inside%pairs)
    inside%pairs%follows = limits_follow
    inside%manner = merge(with_many, with_few, size(x) > few_unknowns)
    if (limits_follow) inside%manner = following
    inside%from_symmetric = inside%manner%from_symmetric
    inside%factors = 0
  end subroutine begin_inside

  !> Continues the interior iteration until the residual is below `tolerance` times the largest force. If it does not get there, or
  !> a signal asks to stop, `found` is false.
  subroutine go_inside(problem, tolerance, solver, timers, inside, state, found)
    type(friction_problem_t), intent(in) :: problem
    real(dp), intent(in) :: tolerance
    type(linear_solver_t), intent(inout) :: solver !! of matrices of the problem's pattern
    type(timers_t), intent(inout) :: timers
    type(inside_t), intent(inout) :: inside
    integer, intent(out) :: state(:)      !! (m) of the springs in the solution
    logical, intent(out) :: found
    type(change_t), dimension(size(state)) :: change, aim
    type(sparse_matrix_t) :: matrix
    type(error_t), allocatable :: error
    real(dp), dimension(size(inside%x)) :: dx, rest
    real(dp) :: left, way, middle, product
    integer :: n_short

    matrix = problem%matrix
    n_short = 0
    associate (x => inside%x, pairs => inside%pairs, factors => inside%factors, manner => inside%manner)
      do
        call forces_left(problem, x, state, left)
        found = left <= tolerance
        if (found .or. factors >= manner%most .or. n_short == manner%most_short .or. stop_signal() > 0) exit
        call linearise()
        if (allocated(error) .or. (manner%limits_follow .and. .not. inside%from_symmetric)) exit
        middle = mean_product(pairs)
        aim = change_t()
        call step(first_share)
        if (allocated(error)) exit
        product = mean_product(moved(problem%spring, pairs, change, longest(pairs, change)))
        product = middle*min(1.0_dp, max(1e-8_dp, (product/middle)**3))
        product = max(product, (near_limits*largest_lag(problem%spring, pairs))**2)
        aim%y = product - change%y*change%w
        aim%a = product - change%a*change%s
        aim%b = product - change%b*change%r
        call step(step_share)
        if (allocated(error)) exit
        n_short = merge(n_short + 1, 0, way < too_short)
        if (way < too_short) then
          product = middle*manner%in_the_middle
          aim%y = product
          aim%a = product
          aim%b = product
          call step(step_share)
          if (allocated(error)) exit
        end if
        x = x + min(1.0_dp, short_of*way)*dx
        pairs = moved(problem%spring, pairs, change, min(1.0_dp, short_of*way))
      end do
    end associate

  contains

    !> Factorises the matrix of the pairs as they are.
    subroutine linearise()
      call find_rest(problem, inside%x, inside%pairs, rest)
      call copy_values(problem%matrix, matrix)
      call add_springs(problem, change_of_pairs(problem%spring, inside%pairs), matrix)
      if (inside%from_symmetric) call factorise_beside(solver, matrix, timers, inside%from_symmetric, error)
      if (.not. (inside%from_symmetric .or. allocated(error))) call factorise(solver, matrix, timers, error)
      inside%factors = inside%factors + 1
    end subroutine linearise

    !> Finds the step to the products in `aim`, and how long it may be. The residual is at most `share` times the forces.
    subroutine step(share)
      real(dp), intent(in) :: share
      real(dp) :: force(size(inside%x)), rate(2)
      type(change_t) :: still
      integer :: i

      force = rest
      do i = 1, size(inside%pairs)
        still = answer(problem%spring(i), inside%pairs(i), aim(i), 0.0_dp, 0.0_dp)
        call add_spring_force(problem, i, [merge(0.0_dp, still%y, problem%spring(i)%bonded), still%shear], force)
      end do
      call solve_for(force, share)
      if (allocated(error)) return
      do i = 1, size(inside%pairs)
        rate = rates_of(problem, i, dx)
        change(i) = answer(problem%spring(i), inside%pairs(i), aim(i), rate(1), rate(2))
      end do
      way = longest(inside%pairs, change)
    end subroutine step

    !> The displacement that forces make: from the symmetric matrix, or by the factors of the matrix itself from where that takes
    !> many iterations.
    subroutine solve_for(force, share)
      real(dp), intent(in) :: force(:), share
      real(dp) :: share_left

      if (inside%from_symmetric) then
        call approach(solver, matrix, force, share, most_from_symmetric, dx, share_left, error)
        if (allocated(error)) return
        inside%from_symmetric = share_left <= share
        if (inside%from_symmetric) return
        call factorise(solver, matrix, timers, error)
        if (allocated(error)) return
      end if
      call solve_with_factors(solver, force, dx, error)
    end subroutine solve_for

  end subroutine go_inside

  !> Begins the pairs above zero at `x`.
  subroutine begin_pairs(problem, at_first, x, pairs)
    type(friction_problem_t), intent(in) :: problem
    real(dp), intent(in) :: at_first
    real(dp), intent(in), contiguous :: x(:)
    type(pairs_t), intent(out) :: pairs(:)
    real(dp) :: closed(2, size(pairs)), first, beyond
    integer :: i

    do i = 1, size(pairs)
      closed(:, i) = closed_forces(problem, i, x)
    end do
    first = at_first*max(maxval(closed(1, :)), sum(abs(problem%force)/problem%span), tiny(1.0_dp))
    do i = 1, size(pairs)
      associate (own => pairs(i), spring => problem%spring(i))
        own%rubs = spring%friction > 0 .or. spring%cohesion > 0
        own%presses = .not. (spring%bonded .and. .not. spring%friction > 0)
        if (own%presses) then
          own%y = positive(closed(1, i) + strength(spring))
          own%w = own%y - (closed(1, i) + strength(spring))
        end if
        if (.not. own%rubs) cycle
        own%limit = limit_at(spring, own%y)
        own%shear = 0.9_dp*own%limit*closed(2, i)/max(tiny(own%limit), abs(closed(2, i)) + own%limit)
        own%a = own%limit - own%shear
        own%b = own%limit + own%shear
        beyond = closed(2, i) - own%shear
        own%s = positive(beyond)
        own%r = own%s - beyond
      end associate
    end do

  contains

    !> The number above zero that leaves the product first**2 with that by which it exceeds another.
    pure real(dp) function positive(number)
      real(dp), intent(in) :: number

      positive = 0.5_dp*(abs(number) + sqrt(number**2 + 4*first**2))
      if (number < 0) positive = first**2/positive
    end function positive

  end subroutine begin_pairs

  !> What y exceeds the pressing force by: the strength of a bond without shear.
  pure real(dp) function strength(spring)
    type(spring_t), intent(in) :: spring

    strength = 0.0_dp
    if (spring%friction > 0) strength = spring%cohesion/spring%friction
  end function strength

  !> Limit of the shear.
  pure real(dp) function limit_at(spring, y) result(limit)
    type(spring_t), intent(in) :: spring
    real(dp), intent(in) :: y

    limit = spring%friction*y
    if (.not. spring%friction > 0) limit = spring%cohesion
  end function limit_at

  !> Forces out of balance with those of the pairs, and what the pairs are too much by.
  subroutine find_rest(problem, x, pairs, rest)
    type(friction_problem_t), intent(in) :: problem
    real(dp), intent(in), contiguous :: x(:)
    type(pairs_t), intent(inout) :: pairs(:)
    real(dp), intent(out), contiguous :: rest(:)
    real(dp) :: closed(2)
    integer :: i

    rest = problem%force - times(problem%matrix, x)
    do i = 1, size(pairs)
      associate (own => pairs(i), spring => problem%spring(i))
        closed = closed_forces(problem, i, x)
        own%too_much(1) = own%w - own%y + closed(1) + strength(spring)
        own%too_much(2) = own%shear - closed(2) + own%s - own%r
        call add_spring_force(problem, i, [merge(closed(1), own%y, spring%bonded), own%shear], rest)
      end associate
    end do
  end subroutine find_rest

  !> What the forces of springs change by: (force across or along, change across or along), force/length.
  pure function change_of_pairs(spring, pairs) result(change)
    type(spring_t), intent(in) :: spring(:)
    type(pairs_t), intent(in) :: pairs(:)
    real(dp) :: change(2, 2, size(pairs))
    real(dp) :: across
    integer :: i

    change = 0.0_dp
    do i = 1, size(pairs)
      associate (own => pairs(i))
        across = spring(i)%stiffness*own%y/(own%w + own%y)
        if (.not. own%presses) across = 0.0_dp
        change(1, 1, i) = merge(spring(i)%stiffness, across, spring(i)%bonded)
        if (.not. own%rubs) cycle
        if (.not. own%follows) change(2, 1, i) = -spring(i)%friction*coupling(own)/yielding(own)*across
        change(2, 2, i) = spring(i)%shear_stiffness/yielding(own)
      end associate
    end do
  end function change_of_pairs

  !> By how much more a spring slips than if it were locked.
  pure real(dp) function yielding(pairs)
    type(pairs_t), intent(in) :: pairs

    yielding = 1 + pairs%s/pairs%a + pairs%r/pairs%b
  end function yielding

  !> What the excess of shear changes by with the limit.
  pure real(dp) function coupling(pairs)
    type(pairs_t), intent(in) :: pairs

    coupling = pairs%r/pairs%b - pairs%s/pairs%a
  end function coupling

  !> Change of the pairs with a displacement across and along, to products `aim`.
  elemental type(change_t) function answer(spring, pairs, aim, across, along) result(change)
    type(spring_t), intent(in) :: spring
    type(pairs_t), intent(in) :: pairs
    type(change_t), intent(in) :: aim
    real(dp), intent(in) :: across, along !! length

    associate (own => pairs)
      if (own%presses) then
        change%y = (aim%y - own%y*own%w + own%y*(own%too_much(1) - spring%stiffness*across))/(own%w + own%y)
        change%w = change%y + spring%stiffness*across - own%too_much(1)
      end if
      if (.not. own%rubs) return
      change%limit = spring%friction*change%y
      if (own%follows) change%limit = limit_at(spring, own%y) - own%limit
      change%shear = (-own%too_much(2) - spring%shear_stiffness*along - (aim%a/own%a - own%s) + (aim%b/own%b - own%r) &
                      - coupling(own)*change%limit)/yielding(own)
      change%a = change%limit - change%shear
      change%b = change%limit + change%shear
      change%s = (aim%a - own%a*own%s - own%s*change%a)/own%a
      change%r = (aim%b - own%b*own%r - own%r*change%b)/own%b
    end associate
  end function answer

  !> Fraction of a change at which the first number of a pair reaches zero, at most 1.
  pure real(dp) function longest(pairs, change) result(share)
    type(pairs_t), intent(in) :: pairs(:)
    type(change_t), intent(in) :: change(:)
    integer :: i

    share = 1.0_dp
    do i = 1, size(pairs)
      if (pairs(i)%presses) share = min(share, to_zero(pairs(i)%y, change(i)%y), to_zero(pairs(i)%w, change(i)%w))
      if (pairs(i)%rubs) share = min(share, to_zero(pairs(i)%a, change(i)%a), to_zero(pairs(i)%s, change(i)%s), &
                                     to_zero(pairs(i)%b, change(i)%b), to_zero(pairs(i)%r, change(i)%r))
    end do
  end function longest

  !> Fraction of a change at which a number reaches zero, at most 1.
  pure real(dp) function to_zero(number, change)
    real(dp), intent(in) :: number, change

    to_zero = 1.0_dp
    if (change < -number) to_zero = -number/change
  end function to_zero

  !> Pairs after a fraction of a change. The smaller one of a and b is kept exactly, because their sum is known.
  elemental type(pairs_t) function moved(spring, pairs, change, share)
    type(spring_t), intent(in) :: spring
    type(pairs_t), intent(in) :: pairs
    type(change_t), intent(in) :: change
    real(dp), intent(in) :: share

    moved = pairs
    if (moved%presses) then
      moved%y = pairs%y + share*change%y
      moved%w = pairs%w + share*change%w
    end if
    if (.not. moved%rubs) return
    moved%a = pairs%a + share*change%a
    moved%b = pairs%b + share*change%b
    moved%s = pairs%s + share*change%s
    moved%r = pairs%r + share*change%r
    moved%limit = limit_at(spring, moved%y)
    if (moved%follows) moved%limit = pairs%limit + share*change%limit
    if (moved%a < moved%b) then
      moved%shear = moved%limit - moved%a
      moved%b = 2*moved%limit - moved%a
    else
      moved%shear = moved%b - moved%limit
      moved%a = 2*moved%limit - moved%b
    end if
  end function moved

  !> What a limit is off by at most, force: nothing where none follows.
  pure real(dp) function largest_lag(spring, pairs) result(largest)
    type(spring_t), intent(in) :: spring(:)
    type(pairs_t), intent(in) :: pairs(:)
    integer :: i

    largest = 0.0_dp
    do i = 1, size(pairs)
      if (pairs(i)%rubs) largest = max(largest, abs(limit_at(spring(i), pairs(i)%y) - pairs(i)%limit))
    end do
  end function largest_lag

  !> Mean of the products.
  pure real(dp) function mean_product(pairs)
    type(pairs_t), intent(in) :: pairs(:)
    integer :: n

    n = count(pairs%presses) + 2*count(pairs%rubs)
    mean_product = (sum(pairs%y*pairs%w, pairs%presses) + sum(pairs%a*pairs%s + pairs%b*pairs%r, pairs%rubs))/max(1, n)
  end function mean_product

end module scree_friction_interior
