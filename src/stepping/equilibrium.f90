!> Whether a static run has come to equilibrium, and what moves where it has not.
!>
!> A static step begins at rest and balances its forces with inertia, M d/(gamma dt^2). It is in equilibrium only where inertia is
!> 0. So at the end of a step the forces are summed up once more without inertia, in the places, stresses and contacts with which
!> the next step would begin. They are loads less elastic forces, with contacts, less the reactions of fixed points and followed
!> covers.
!>
!> On a body this is a force r of each unknown, over the displacement that a unit of it makes (`span`). A DDA block has two forces,
!> a moment and three forces of strain over its size. Manifold elements have two forces of each cover. The force out of balance is
!> the sum of their magnitudes, two by two. For a rigid body that accelerates it is the resultant, whatever the mesh; where the body
!> bends it is more.
!>
!> The ratio is that force over the weight and loads of the body. Without these it is compared with the forces on the scene; without
!> these too, with the elastic forces and contacts on all bodies, and with those of a negligible strain. A body that falls freely
!> has the ratio 1, one that slides down a plane sin a - cos a tan phi.
!>
!> A run that ends in equilibrium chooses its steps. Let the force out of balance go from r0 to r1 while the body moves by w (root
!> mean square). Were forces linear, the body would go on by w r1/(r0 - r1), in steps of any size. A body that would not go farther
!> than a small fraction of its size limits no step, and neither does a body that supports hold in both directions. Any other body
!> goes by at most that fraction in a step, because displacement goes with the square of the step.
!>
!> A body moves, without an equilibrium nearby, if two conditions hold. It would go on by more than its size, by its own force and
!> by those on all bodies. In such steps in a row it has gone by a hundredth of its size. The fall of forces is counted from the
!> first of these steps on, except where a step takes a hundredth of them, because bending makes them vary a little with the step
!> size. While other bodies still settle, they may come to support it.
!>
!> A stage may go on without bodies that move (`stage.loose`): then they are left out of the balance until they have come to rest.
!>
!> The formulas are in doc/theory/equilibrium.md, eq-unbalanced and eq-way-left.
module scree_equilibrium
  use scree_constraints, only: constraints_t
  use scree_contact_beginning, only: begin_contacts
  use scree_contact_rules, only: measure_contacts
  use scree_contact_try, only: contact_try_t, take_island
  use scree_effects, only: add_element_effects, load_on_element, steady_from
  use scree_element_term, only: step_rule_t, term_t
  use scree_equations, only: add_equations, begin_equations, constrain_equations, is_island, members, wholly_held
  use scree_errors, only: error_t
  use scree_fixed_point, only: is_roller
  use scree_inertia, only: kinetic_energy
  use scree_integrator, only: rule_at_rest
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_pair_effects, only: add_bolts, add_pair_effects, is_bolted
  use scree_scene, only: settings_t
  use scree_state, only: state_t
  use scree_step_constraints, only: constraints_of_step
  use scree_step_try, only: try_t
  use scree_system, only: element_unknowns, values_of
  use scree_text, only: number_text, pair_text, place_text, short_text
  implicit none
  private
  public :: balance_t, begin_settling, find_balance, is_balanced, tolerance_of, words_of_balance

  integer, parameter :: n = element_unknowns

  !> Share out of balance that is called equilibrium where a scene asks for none.
  real(dp), parameter :: usual = 1e-3_dp

  !> Strain that is nothing.
  real(dp), parameter :: no_strain = 1e-12_dp
  !> Largest and smallest ratio of a step to the one before.
  real(dp), parameter :: most_growth = 3.0_dp, least_growth = 0.1_dp
  !> Displacement of an unsupported body in a step, over its size.
  real(dp), parameter :: reach = 0.005_dp
  !> Displacement that a vertex may have in a step, over the displacement that ends a try.
  real(dp), parameter :: jumps = 0.5_dp
  !> Ratio of the force out of balance to that before a step, below which the step itself tells how far its body would go on.
  real(dp), parameter :: fell = 0.99_dp
  !> Displacement of a body that moves, and the displacement by which it would go on, over its size.
  real(dp), parameter :: gone = 0.01_dp, goes_on = 1.0_dp

  !> Fraction of the squared number of rollers of a body, above which they support it in both directions.
  real(dp), parameter :: across = 1e-6_dp

  !> How far a state is from equilibrium: of the body that is farthest, or that moves on and on.
  type :: balance_t
    real(dp) :: share = 0.0_dp           !! out of balance, over what acts
    integer :: block = 0                 !! from 1; 0: nothing can move
    real(dp) :: force = 0.0_dp           !! out of balance, per unit thickness
    real(dp) :: position(2) = 0.0_dp     !! of its centroid, length
    real(dp) :: extent = 0.0_dp          !! of the model, length
    real(dp) :: way(2) = 0.0_dp          !! that it went in the step, length
    real(dp) :: speed = 0.0_dp           !! that over the size of the step, length/time
    integer :: others = 0                !! bodies besides that are not in equilibrium either
    logical :: moves = .false.           !! no equilibrium is near
  end type balance_t

contains

  !> Finds how far the end of a static step is from equilibrium.
  !>
  !> Errors: as of `constraints_of_step`.
  subroutine find_balance(model, cache, try, state, balance, error)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache          !! of the state; its equations hold the forces then
    type(try_t), intent(in) :: try                 !! that the step took
    type(state_t), intent(inout) :: state          !! at the end of the step; how it settles is written
    type(balance_t), intent(out) :: balance
    type(error_t), allocatable, intent(out) :: error
    real(dp), dimension(model%n_blocks) :: left, acts
    real(dp) :: force
    integer :: k

    call sum_up_forces(model, cache, state, try%contacts, error)
    if (allocated(error)) return
    call forces_of_bodies(model, cache, state, left, acts)
    force = sum(left(model%free_block))
    left = left/max(acts, tiny(acts))
    if (allocated(state%settling)) call take_in(model, cache, try, left, force, state)
    do k = 1, size(model%free_block)
      associate (b => model%free_block(k))
        if (balance%block > 0 .and. .not. left(b) > balance%share) cycle
        if (is_loose(state, b)) cycle
        balance%share = left(b)
        balance%block = b
      end associate
    end do
    if (allocated(state%settling)) then
      balance%moves = state%settling%moving > 0
      if (balance%moves) balance%block = state%settling%moving
    end if
    if (balance%block == 0) return
    balance%share = left(balance%block)
    balance%force = balance%share*acts(balance%block)
    balance%others = max(0, count([(left(model%free_block(k)) > tolerance_of(model%settings) .and. &
                                    .not. is_loose(state, model%free_block(k)), k=1, size(model%free_block))]) - 1)
    call place_body(model, cache, try%d, balance)
    balance%speed = norm2(balance%way)/state%pace%last
  end subroutine find_balance

  !> Whether a block moves on and on, and the stage goes on without it.
  pure logical function is_loose(state, b)
    type(state_t), intent(in) :: state
    integer, intent(in) :: b

    is_loose = .false.
    if (allocated(state%settling)) is_loose = state%settling%loose(b)
  end function is_loose

  !> Begins a run that is to end in equilibrium.
  pure subroutine begin_settling(model, state)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state

    allocate (state%settling)
    allocate (state%settling%loose(model%n_blocks), source=.false.)
    allocate (state%settling%share(model%n_blocks), source=huge(1.0_dp))
    allocate (state%settling%way(model%n_blocks), source=0.0_dp)
    allocate (state%settling%share_before(model%n_blocks), state%settling%force_before(model%n_blocks), source=huge(1.0_dp))
  end subroutine begin_settling

  !> Takes in how bodies moved in a step and what that took off their forces out of balance: which of them moves on and on, and how
  !> much larger the next step may be.
  pure subroutine take_in(model, cache, try, share, force, state)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(try_t), intent(in) :: try                 !! that the step took
    real(dp), intent(in) :: share(:)               !! (n_blocks) out of balance at its end
    real(dp), intent(in) :: force                  !! on all of them
    type(state_t), intent(inout) :: state
    real(dp) :: way(model%n_blocks), left, since
    logical :: first, held(model%n_blocks)
    integer :: b, k

    way = ways_of(model, cache, try%d)
    held = held_both_ways(model)
    associate (own => state%settling)
      own%steady = state%time >= steady_from(model)
      first = .not. own%unbalanced < huge(left)
      own%grows = min(most_growth, sqrt(jumps/max(try%jump, jumps/most_growth**2)))
      own%moving = 0
      do k = 1, size(model%free_block)
        b = model%free_block(k)
        left = way_left(way(b), own%share(b), share(b))
        if (.not. share(b) > tolerance_of(model%settings)) own%loose(b) = .false.
        if (held(b) .or. own%loose(b) .or. .not. share(b) > tolerance_of(model%settings)) left = 0.0_dp
        if (left > reach) &
          own%grows = min(own%grows, max(least_growth, sqrt(reach/max(way(b), tiny(left)))))
        since = own%way(b) + min(way(b), reach)
        if (share(b) > fell*own%share(b) .and. left > 0) left = way_left(since, own%share_before(b), share(b))
        left = min(left, way_left(since, own%force_before(b), force))
        if (left > goes_on .and. own%steady .and. .not. first) then
          own%way(b) = since
        else
          own%way(b) = 0.0_dp
          own%share_before(b) = share(b)
          own%force_before(b) = force
        end if
        if (.not. own%way(b) > gone) cycle
        own%loose(b) = model%settings%goes_on_without_loose
        if (own%moving == 0 .and. .not. own%loose(b)) own%moving = b
      end do
      own%share = share
      own%unbalanced = maxval([0.0_dp, pack(share(model%free_block), .not. own%loose(model%free_block))])
    end associate
  end subroutine take_in

  !> Which bodies fixed points and supports hold in both directions.
  pure function held_both_ways(model) result(held)
    type(model_t), intent(in) :: model
    logical :: held(model%n_blocks)
    real(dp) :: spread_of(3, model%n_blocks) ! sums of nx nx, ny ny, nx ny of the directions n in which rollers hold each body
    integer :: i

    held = .false.
    if (.not. allocated(model%effects%fixed_point)) return
    spread_of = 0.0_dp
    associate (holds => model%effects%fixed_point)
      do i = 1, size(holds%point)
        associate (b => model%elements%block(model%points%element(holds%point(i))))
          if (is_roller(holds, i)) then
            associate (n => holds%direction(:, i))
              spread_of(:, b) = spread_of(:, b) + [n(1)**2, n(2)**2, n(1)*n(2)]
            end associate
          else
            held(b) = .true.
          end if
        end associate
      end do
    end associate
    held = held .or. spread_of(1, :)*spread_of(2, :) - spread_of(3, :)**2 > across*(spread_of(1, :) + spread_of(2, :))**2
  end function held_both_ways

  !> How far a body is to go on, were forces linear: it went a way while the fraction out of balance went from one value to another.
  pure real(dp) function way_left(way, from, to)
    real(dp), intent(in) :: way, from, to

    way_left = huge(way)
    if (from < huge(from) .and. from > to) way_left = way*to/(from - to)
  end function way_left

  !> Root mean square of the displacement of each body in a step, over its size, the root of its area.
  pure function ways_of(model, cache, d) result(way)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    real(dp), intent(in) :: d(:)                   !! (n_unknowns) of the step
    real(dp), dimension(model%n_blocks) :: way, mass, area
    integer :: e, k

    way = 0.0_dp
    mass = 0.0_dp
    area = 0.0_dp
    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      associate (own => cache%element(e), b => model%elements%block(e))
        way(b) = way(b) + 2*kinetic_energy(own%mass_matrix, values_of(model%elements, e, d))
        mass(b) = mass(b) + own%mass
        area(b) = area(b) + own%kinematics%area
      end associate
    end do
    where (mass > 0) way = sqrt(max(way, 0.0_dp)/(mass*area))
  end function ways_of

  !> Sums up the forces of all groups at a state, at rest.
  subroutine sum_up_forces(model, cache, state, contacts, error)
    type(model_t), intent(in) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(in) :: state
    type(contact_try_t), intent(in) :: contacts
    type(error_t), allocatable, intent(out) :: error
    type(constraints_t) :: constraints
    type(contact_try_t) :: now
    type(step_rule_t) :: rule
    type(term_t) :: term
    real(dp) :: nothing(model%n_unknowns)
    logical :: meets, touches
    integer :: group, k

    call constraints_of_step(model, cache, state, state%time, constraints, error)
    if (allocated(error)) return
    call constrain_equations(cache%equations, constraints)
    rule = rule_at_rest(state%time, state%pace%last)
    nothing = 0.0_dp
    touches = allocated(model%effects%contact) .and. size(contacts%contact) > 0
    if (touches) then
      now = contacts
      now%contact = state%contacts%contact
      call begin_contacts(model, cache, state, rule, now)
    end if
    do group = 1, cache%equations%n_groups
      if (wholly_held(cache%equations, group)) cycle
      call begin_equations(cache%equations, group)
      associate (list => members(cache%equations, group))
        do k = 1, size(list)
          call add_element_effects(model, cache%element(list(k)), state, list(k), nothing(:n), rule, term)
          call add_equations(cache%equations, group, k, cache%element(list(k))%kinematics%span, term)
        end do
        if (is_bolted(model, list)) call add_bolts(model, state, group, rule, nothing, cache)
      end associate
      if (.not. (touches .and. is_island(cache%equations, group))) cycle
      call take_island(now, group - cache%equations%n_alone, meets)
      if (.not. meets) cycle
      call measure_contacts(model, nothing, now)
      call add_pair_effects(model, now, group, .true., .false., cache%equations)
    end do
  end subroutine sum_up_forces

  !> What is out of balance on each body, and what acts on it; of those that cannot move nothing.
  subroutine forces_of_bodies(model, cache, state, left, acts)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    real(dp), intent(out) :: left(:), acts(:)      !! (n_blocks) force per unit thickness
    logical :: counted(model%n_unknowns), held(model%n_elements)
    type(step_rule_t) :: rule
    real(dp) :: balancing, elastic, stiffness
    integer :: e, group, i, k

    left = 0.0_dp
    acts = 0.0_dp
    balancing = 0.0_dp
    elastic = 0.0_dp
    stiffness = 0.0_dp
    counted = .false.
    held = .false.
    do group = 1, cache%equations%n_groups
      if (wholly_held(cache%equations, group)) held(members(cache%equations, group)) = .true.
    end do
    rule = rule_at_rest(state%time, state%pace%last)
    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      associate (ids => cache%equations%unknown(:, e), span => cache%equations%span, b => model%elements%block(e))
        stiffness = stiffness + cache%element(e)%elasticity(1, 1)*sqrt(cache%element(e)%kinematics%area)
        elastic = elastic + maxval(abs(state%stress(:, e)))*sqrt(cache%element(e)%kinematics%area)
        acts(b) = acts(b) + load_on_element(model, cache%element(e), state, e, rule)
        if (held(e)) cycle
        do i = 1, size(ids), 2 ! unknowns come in twos, those of a cover together
          if (counted(ids(i))) cycle
          counted(ids(i)) = .true.
          left(b) = left(b) + norm2(cache%equations%force(ids(i:i + 1))/span(ids(i:i + 1)))
          balancing = balancing + norm2(cache%equations%scale(ids(i:i + 1))/span(ids(i:i + 1)))
        end do
      end associate
    end do
    if (.not. any(acts > 0)) acts = max(balancing, elastic) + no_strain*stiffness ! supports may bear the elastic forces
    where (.not. acts > 0) acts = sum(acts)
  end subroutine forces_of_bodies

  !> Places the body, and finds which way it went.
  pure subroutine place_body(model, cache, d, balance)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    real(dp), intent(in) :: d(:)                   !! (n_unknowns) of the step
    type(balance_t), intent(inout) :: balance
    real(dp) :: area
    integer :: e, k

    area = 0.0_dp
    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      if (model%elements%block(e) /= balance%block) cycle
      associate (element => cache%element(e)%kinematics)
        area = area + element%area
        balance%position = balance%position + element%area*(element%centroid + model%origin)
        balance%way = balance%way + element%area*matmul(element%at_centroid, values_of(model%elements, e, d))
      end associate
    end do
    balance%position = balance%position/area
    balance%extent = model%extent
    balance%way = balance%way/area
  end subroutine place_body

  !> Share out of balance up to which a state counts as in equilibrium.
  pure real(dp) function tolerance_of(settings) result(tolerance)
    type(settings_t), intent(in) :: settings

    tolerance = usual
    if (settings%balance > 0) tolerance = settings%balance
  end function tolerance_of

  !> Whether a state is in equilibrium.
  pure logical function is_balanced(settings, balance)
    type(settings_t), intent(in) :: settings
    type(balance_t), intent(in) :: balance

    is_balanced = balance%share <= tolerance_of(settings)
  end function is_balanced

  !> A state that is not in equilibrium in words: which body, where, by how much, and how it moves.
  pure function words_of_balance(balance) result(text)
    type(balance_t), intent(in) :: balance
    character(len=:), allocatable :: text

    text = 'block '//number_text(balance%block)//' at '//place_text(balance%position, balance%extent)// &
           ' has an unbalanced force, '//short_text(balance%share)//' of the forces on the block; it moved by '// &
           pair_text(balance%way)// &
           ' in the last step, at a speed of '//short_text(balance%speed)
    if (balance%moves) text = text//', and nothing stops it'
    if (balance%others == 1) text = text//'; another block is not in equilibrium either'
    if (balance%others > 1) text = text//'; '//number_text(balance%others)//' other blocks are not in equilibrium either'
  end function words_of_balance

end module scree_equilibrium
