!> The iteration of a step: corrections d <- d + K^-1 (forces out of balance) until the deformation settles.
!>
!> K is the secant operator of Zhang et al. 2019 or the tangent. Written as a correction, the secant has the iterates
!> of the paper (K_s d = f) without its round-off floor of eps E dt^2 / (rho l^2). With small strain the first
!> correction is the solution.
module scree_deformation_iteration
  use scree_contact_forces, only: add_contacts, slides_with_friction
  use scree_effects, only: add_element_effects, effects_t, element_cache_t, symmetric_equations
  use scree_element_term, only: step_rule_t, term_t
  use scree_equations, only: add_equations, begin_equations, equations_t, members, out_of_balance, solve_equations, &
                             weakest_element, wholly_held
  use scree_errors, only: error_t
  use scree_kinds, only: dp
  use scree_impact, only: keep_rigid
  use scree_open_close, only: hold_contacts, judge_contacts, return_anchors
  use scree_scene, only: iterate_hybrid, iterate_newton, settings_t, test_residual
  use scree_system, only: state_t, system_t
  use scree_text, only: number_text
  use scree_contact_try, only: gaps_and_slips, place_contacts, contact_try_t
  use scree_trouble, only: new_trouble, trouble_t
  implicit none
  private
  public :: iteration_report_t, settle_deformation

  !> The hybrid method turns from secant to tangent when theta changes by less in an iteration.
  real(dp), parameter :: near_solution = 0.05_dp
  !> A residual below this share of what cancelled in it is round-off, whatever the tolerance.
  real(dp), parameter :: round_off = 50*epsilon(1.0_dp)
  !> An area that changes by more than this factor in a step is no iterate worth going on with.
  real(dp), parameter :: largest_area_change = 5.0_dp

  !> What a step took.
  type :: iteration_report_t
    logical :: settled = .false.
    integer :: iterations = 0              !! of the slowest group
    integer :: solves = 0                  !! of all groups
    integer, allocatable :: judged(:, :)   !! (4, n) contacts open, sliding, locked, and changing, at each judgement
    type(trouble_t) :: trouble             !! why it did not settle
  end type iteration_report_t

contains

  !> Iterates every group of elements that share unknowns, each until it has settled.
  subroutine settle_deformation(system, effects, settings, state, share, step_rule, equations, d, contact_try, report)
    type(system_t), intent(in) :: system
    type(effects_t), intent(in) :: effects
    type(settings_t), intent(in) :: settings
    type(state_t), intent(in) :: state             !! at the beginning of the step
    type(element_cache_t), intent(in) :: share(:)  !! (n_elements)
    type(step_rule_t), intent(in) :: step_rule
    type(equations_t), intent(inout) :: equations
    real(dp), intent(inout) :: d(:)                !! (n_unknowns) prediction, then solution
    type(contact_try_t), intent(inout) :: contact_try          !! contacts as the step finds them, then in their states
    type(iteration_report_t), intent(inout) :: report
    integer :: group, touching !! group of the elements that may touch others

    touching = 0
    if (allocated(effects%contact)) then
      if (size(contact_try%link, 2) > 0) touching = equations%n_groups
    end if
    do group = 1, equations%n_groups
      call settle_group(group)
      if (.not. report%settled) return
    end do

  contains

    !> Iterates one group.
    subroutine settle_group(group)
      integer, intent(in) :: group
      type(step_rule_t) :: rule
      type(term_t) :: term
      type(error_t), allocatable :: error
      real(dp) :: balance(2), change
      type(term_t), allocatable :: linear(:)   ! of the members, at d_linear
      real(dp), allocatable :: d_linear(:)
      logical :: in_contact, inner, large, nested, possible, symmetric
      integer :: e, fewest, i, k, stalled, worst
      integer, allocatable :: before(:, :), member(:) ! states of the lines of the contacts before a judgement

      rule = step_rule
      rule%tangent = settings%iterate == iterate_newton
      large = effects%large_deformation
      member = members(equations, group)
      in_contact = group == touching
      if (.not. in_contact .and. wholly_held(equations, group)) then
        call check_areas(member, report%settled)
        return
      end if
      if (in_contact .and. .not. allocated(report%judged)) allocate (report%judged(4, 0))
      nested = in_contact .and. settings%nested .and. large
      inner = .false.
      if (nested) allocate (linear(size(member)))
      if (in_contact) then
        if (contact_try%bends) call place_contacts(system, state, share, rule%operator_weight, d, contact_try)
        if (.not. effects%contact%lags) call judge_contacts(system, effects%contact, d, .true., contact_try)
      end if
      fewest = huge(fewest)
      stalled = 0
      report%settled = .false.
      do i = 1, merge(4, 1, in_contact)*settings%most_iterations
        call begin_equations(equations, group)
        do k = 1, size(member)
          e = member(k)
          if (inner) then
            term = linear(k)
            associate (ids => system%elements%unknown(:, e))
              term%force = term%force - matmul(term%matrix, d(ids) - d_linear(ids))
            end associate
          else
            call add_element_effects(effects, system, state, e, share(e), d(system%elements%unknown(:, e)), rule, term)
            if (allocated(contact_try%rigidity)) call keep_rigid(system, contact_try, e, share(e), d, term)
            if (nested) linear(k) = term
          end if
          call add_equations(equations, group, k, share(e)%kinematics%span, term)
        end do
        if (in_contact .and. .not. inner) d_linear = d
        symmetric = symmetric_equations(effects, rule)
        if (in_contact) then
          call add_contacts(system, effects%contact, d, symmetric, contact_try, equations)
          symmetric = symmetric .and. .not. slides_with_friction(system%outlines, effects%contact, contact_try) &
                      .and. .not. (large .and. allocated(contact_try%rigidity))
        end if
        if (settings%test == test_residual .and. large) then
          balance = out_of_balance(equations, group)
          report%settled = (balance(1) <= settings%tolerance .or. balance(2) <= round_off) &
                           .and. .not. (in_contact .and. contact_try%changes > 0 .and. i > 1)
          if (report%settled .and. in_contact) then
            call hold()
            stalled = 0
            if (.not. report%settled) cycle
          end if
          if (report%settled) exit
        end if

        call solve_equations(equations, group, symmetric, d, error)
        report%solves = report%solves + 1
        report%iterations = max(report%iterations, i)
        if (allocated(error)) then
          call blame(weakest_element(equations, group), error%message, &
                     'a smaller step.size, and check density, E and fixed points there')
          return
        end if
        call check_areas(member, possible)
        if (.not. possible) return
        call find_change(member, change, worst, d_linear)
        report%settled = .not. large .or. (settings%test /= test_residual .and. change < settings%tolerance)
        if (in_contact) then
          if (effects%contact%lags .and. state%step == 0 .and. i == 1) report%settled = .false. ! the first of a run: as Shi's
          if (stalled == effects%contact%most_stalled) before = states_of(contact_try)
          if (nested) call judge_contacts(system, effects%contact, d, .false., contact_try)
          inner = nested .and. contact_try%changes > 0
          if (contact_try%bends .and. .not. inner) call place_contacts(system, state, share, rule%operator_weight, d, contact_try)
          if (.not. inner) call judge_contacts(system, effects%contact, d, .false., contact_try)
          report%judged = reshape([report%judged, contact_try%count, contact_try%changes], [4, size(report%judged, 2) + 1])
          if (contact_try%changes > 0) then
            report%settled = .false.
            if (contact_try%changes < fewest .and. .not. effects%contact%lags) then
              fewest = contact_try%changes
            else
              stalled = stalled + 1
            end if
            if (stalled > effects%contact%most_stalled) then
              call blame_contact(before, i)
              return
            end if
          end if
        end if
        if (report%settled .and. in_contact) then
          call hold()
          stalled = 0
        end if
        if (report%settled) exit
        if (settings%iterate == iterate_hybrid) rule%tangent = change < near_solution
      end do
      if (report%settled) return
      call blame(worst, 'the deformation did not settle in '//number_text(report%iterations)//' iterations', &
                 'iteration.method=newton or a larger iteration.most, and check E, density and loads there')
    end subroutine settle_group

    !> Says that an element kept the iteration from settling.
    subroutine blame(e, what, advice)
      integer, intent(in) :: e
      character(len=*), intent(in) :: what, advice

      report%trouble = new_trouble(what, element=e, advice=advice)
      if (e > 0) report%trouble%position = share(e)%kinematics%centroid
    end subroutine blame

    !> Says which contact kept it from settling: of those that the last judgement changed the one that presses most.
    subroutine blame_contact(before, iterations)
      integer, intent(in) :: before(:, :) !! (2, n_contacts) states of its lines before the last judgement
      integer, intent(in) :: iterations
      integer :: now(2, size(before, 2)), i, worst
      real(dp) :: both(2, 2), deepest, gap

      now = states_of(contact_try)
      deepest = -huge(deepest)
      worst = 0
      do i = 1, size(now, 2)
        if (all(now(:, i) == before(:, i))) cycle
        both = gaps_and_slips(system, contact_try, i, d)
        gap = maxval(both(1, :contact_try%contact(i)%n_entrances))
        if (-gap <= deepest) cycle
        deepest = -gap
        worst = i
      end do
      report%trouble = new_trouble('contacts did not settle in '//number_text(iterations)//' open-close iterations, '// &
                                 number_text(contact_try%changes)//' still change', &
                                 advice='another contact.stiffness, contact.viscosity, or a smaller step.least')
      if (worst == 0) return
      associate (line => contact_try%contact(worst)%entrance(contact_try%contact(worst)%active))
        report%trouble%element = system%outlines%element(line%vertex)
        report%trouble%against = system%outlines%element(line%edge)
        report%trouble%position = state%vertex(:, system%outlines%start(line%vertex))
      end associate
    end subroutine blame_contact

    !> Lets contacts hold what has settled, by multipliers and where they closed; it has not where they change by that.
    subroutine hold()
      call hold_contacts(system, effects%contact, d, contact_try, report%settled)
      if (report%settled) call return_anchors(system, effects%contact, d, contact_try, report%settled)
    end subroutine hold

    !> Largest change of a component of theta since the last linearisation, and its element; where bodies touch, of the place over
    !> the size too.
    subroutine find_change(member, change, element, before)
      integer, intent(in) :: member(:)
      real(dp), intent(out) :: change
      integer, intent(out) :: element
      real(dp), intent(in), optional :: before(:) !! displacement at the last linearisation, where bodies touch
      real(dp) :: moved(size(system%elements%unknown, 1)), own
      integer :: k

      change = 0.0_dp
      element = member(1)
      do k = 1, size(member)
        associate (ids => system%elements%unknown(:, member(k)))
          moved = equations%correction(ids)
          if (present(before)) moved = d(ids) - before(ids)
          own = maxval(abs(matmul(share(member(k))%kinematics%gradient, moved)))
          if (present(before)) own = max(own, maxval(abs(matmul(share(member(k))%kinematics%at_centroid, moved))) &
                                              /sqrt(share(member(k))%kinematics%area))
          if (own <= change) cycle
          change = own
          element = member(k)
        end associate
      end do
    end subroutine find_change

    !> Whether every element of the group has kept a finite area; blames one that has not.
    subroutine check_areas(member, possible)
      integer, intent(in) :: member(:)
      logical, intent(out) :: possible
      real(dp) :: theta(4), ratio
      integer :: k

      do k = 1, size(member)
        theta = matmul(share(member(k))%kinematics%gradient, d(system%elements%unknown(:, member(k))))
        ratio = (1 + theta(1))*(1 + theta(4)) - theta(2)*theta(3)
        possible = ratio < largest_area_change .and. ratio*largest_area_change > 1.0_dp ! false for NaN
        if (possible) cycle
        call blame(member(k), 'the iteration ran away (its area changed by more than a factor of 5)', &
                   'a smaller step.size, and check density, E and loads there')
        return
      end do
    end subroutine check_areas

  end subroutine settle_deformation

  !> States of the lines of all contacts.
  pure function states_of(contact_try) result(states)
    type(contact_try_t), intent(in) :: contact_try
    integer :: states(2, size(contact_try%contact))

    states(1, :) = contact_try%contact%entrance(1)%state
    states(2, :) = contact_try%contact%entrance(2)%state
  end function states_of

end module scree_deformation_iteration
