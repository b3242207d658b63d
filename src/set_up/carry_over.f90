!> First state of a model from the last state of the model before.
!>
!> A stage may have other supports, loads, bolts and weights, and fewer blocks. A model that cracks have cut further has more parts,
!> and each is of one part before (`scree_lineage`). Places, stress, velocities and the memory of contacts and bolts go on. A point
!> may be new: the end of an edge that is supported or loaded from here on, or a vertex that a cut has made. The linear field of its
!> element has moved it to x_0 + F (X - X_0). Here X is its place at the start, and X_0 and x_0 are the first and the present
!> place of a vertex of the element.
module scree_carry_over
  use scree_bolt, only: begin_bolt
  use scree_contacts, only: contact_t, state_open
  use scree_hold, only: hold_t
  use scree_idle_points, only: are_idle, place_now
  use scree_joint_stiffness, only: change_stiffness, mean_of_bonds
  use scree_kinds, only: dp
  use scree_lineage, only: lineage_t, same_lineage
  use scree_model, only: model_t
  use scree_regions, only: first_vertex_of, last_vertex_of
  use scree_scene, only: reset_both, reset_displacements, reset_velocities
  use scree_sorting, only: columns, sort_into
  use scree_state, only: bolt_absent, reference_t, stage_clock_t, state_t, step_of_run, time_of_run
  use scree_system, only: absorber_end, bolt_end, roller_end
  use scree_time_table, only: value_at
  implicit none
  private
  public :: carry_over, carry_through_cut, carry_through_removal, take_supports

  !> What has become of the vertices and edges of outlines.
  type :: heirs_t
    integer, allocatable :: vertex(:)  !! (n_before) vertex; 0: none
    integer, allocatable :: first(:)   !! (n_before+1) edge i is cut into edge(first(i):first(i+1)-1)
    integer, allocatable :: edge(:)
    real(dp), allocatable :: from(:)   !! (n_edges) where each begins on the edge before, fraction of that
    real(dp), allocatable :: to(:)     !! (n_edges) where it ends
  end type heirs_t

  !> Distance from an edge of a point on it, by round-off, over the extent of the model.
  real(dp), parameter :: round_off = 1e-9_dp

contains

  !> Has the first state of a stage go on from the last of the stage before.
  pure subroutine carry_over(model_before, before, reaction, pretension, model, state)
    type(model_t), intent(in) :: model_before
    type(state_t), intent(in) :: before
    real(dp), intent(in) :: reaction(:, :)   !! (2, n_points before) of the supports, force per unit thickness
    real(dp), intent(in) :: pretension(:)    !! (n_bolts) force per unit thickness
    type(model_t), intent(inout) :: model    !! of the stage, as set up
    type(state_t), intent(inout) :: state    !! likewise

    state%stage = stage_clock_t(before%stage%number + 1, step_of_run(before), time_of_run(before))
    call carry_what_stays(model_before, before, before%static_force + reaction, pretension, model, state)
    state%acceleration = 0.0_dp
    if (model%effects%is_static() .or. any(model%settings%reset == [reset_velocities, reset_both])) state%velocity = 0.0_dp
    if (any(model%settings%reset == [reset_displacements, reset_both])) then
      state%reference = reference_t(state%vertex, state%point)
      state%rotation = 0.0_dp
    end if
  end subroutine carry_over

  !> Has the state go on without blocks that have left the scene, within a stage. The motion of the others goes on as it was.
  pure subroutine carry_through_removal(model_before, before, pretension, model, state)
    type(model_t), intent(in) :: model_before
    type(state_t), intent(in) :: before
    real(dp), intent(in) :: pretension(:)    !! (n_bolts) force per unit thickness
    type(model_t), intent(inout) :: model    !! without them, as set up
    type(state_t), intent(inout) :: state    !! likewise

    state%time = before%time
    state%step = before%step
    state%stage = before%stage
    state%pace = before%pace
    call carry_what_stays(model_before, before, before%static_force, pretension, model, state)
    if (allocated(before%settling)) state%settling = before%settling
  end subroutine carry_through_removal

  !> Carries over what a model with the same parts has, of which some blocks may be gone.
  pure subroutine carry_what_stays(model_before, before, static_force, pretension, model, state)
    type(model_t), intent(in) :: model_before
    type(state_t), intent(in) :: before
    real(dp), intent(in) :: static_force(:, :) !! (2, n_points before) on edges, per unit thickness
    real(dp), intent(in) :: pretension(:)    !! (n_bolts) force per unit thickness
    type(model_t), intent(inout) :: model    !! as set up
    type(state_t), intent(inout) :: state    !! likewise
    integer :: e

    call carry_fields(model_before, before, same_lineage(model_before), model, state)
    do e = 1, model%n_elements
      if (.not. model%present(model%elements%block(e))) state%stress(:, e) = 0.0_dp
    end do
    call carry_static_forces(model_before, static_force, model, state)
    call take_supports(state, model)
    call keep_what_is_there(model_before, model, state)
    if (allocated(state%bolts)) call carry_bolts(before, pretension, model, state)
    if (allocated(before%reference)) call carry_reference(before%reference, model, state)
    if (allocated(before%deviation) .and. model%settings%estimates_error) state%deviation = before%deviation
  end subroutine carry_what_stays

  !> Has the state go on in a model that cracks have cut further, within a stage. Nothing is at rest or in motion for it: kinetic
  !> energy, momentum and stress stay as they are.
  pure subroutine carry_through_cut(model_before, before, lineage, model, state)
    type(model_t), intent(in) :: model_before
    type(state_t), intent(in) :: before
    type(lineage_t), intent(in) :: lineage
    type(model_t), intent(inout) :: model    !! as set up
    type(state_t), intent(inout) :: state    !! likewise

    state%time = before%time
    state%step = before%step
    state%stage = before%stage
    state%pace = before%pace
    call carry_fields(model_before, before, lineage, model, state)
    call take_supports(state, model)
    if (allocated(before%bolts)) state%bolts = before%bolts
  end subroutine carry_through_cut

  !> Carries over what every model has: places, motion, stress, contacts, and the books.
  pure subroutine carry_fields(model_before, before, lineage, model, state)
    type(model_t), intent(in) :: model_before
    type(state_t), intent(in) :: before
    type(lineage_t), intent(in) :: lineage
    type(model_t), intent(inout) :: model
    type(state_t), intent(inout) :: state
    integer :: e, k

    state%deformation = before%deformation(:, lineage%element)
    state%green = before%green(lineage%element)
    state%stress = before%stress(:, lineage%element)
    state%rotation = before%rotation(lineage%block)
    do e = 1, model%n_elements
      do k = first_vertex_of(model%elements%shape, e), last_vertex_of(model%elements%shape, e)
        if (lineage%vertex(k) > 0) state%vertex(:, k) = before%vertex(:, lineage%vertex(k))
        if (lineage%vertex(k) == 0) state%vertex(:, k) = place_now(model_before, before, lineage%element(e), model%start(:, k))
      end do
    end do
    if (size(state%cover, 2) > 0) state%cover = before%cover(:, lineage%cover)
    call carry_rates(model_before, before, lineage, model, state)
    call carry_points(model_before, before, lineage, model, state)
    call carry_contacts(model_before, before, lineage, model, state)
    if (allocated(before%cracks)) state%cracks = before%cracks
    if (allocated(before%hold)) call carry_hold(model_before, before%hold, lineage, model, state)
    if (allocated(before%departed)) state%departed = before%departed
    state%books = before%books
  end subroutine carry_fields

  !> What holds new faces together. The copies of a cover that a cut has made hold as it did.
  pure subroutine carry_hold(model_before, before, lineage, model, state)
    type(model_t), intent(in) :: model_before
    type(hold_t), intent(in) :: before
    type(lineage_t), intent(in) :: lineage
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    real(dp) :: elements_before(model_before%n_covers), elements(model_before%n_covers) ! of each cover, and of all its copies
    integer :: e, k

    elements_before = 0.0_dp
    elements = 0.0_dp
    do e = 1, model_before%n_elements
      do k = 1, size(model_before%elements%cover, 1)
        associate (n => elements_before(model_before%elements%cover(k, e)))
          n = n + 1
        end associate
      end do
    end do
    do e = 1, model%n_elements
      do k = 1, size(model%elements%cover, 1)
        associate (n => elements(lineage%cover(model%elements%cover(k, e))))
          n = n + 1
        end associate
      end do
    end do
    state%hold = before
    state%hold%piece = before%piece(lineage%cover)
    state%hold%force = before%force(:, lineage%cover)*spread(elements_before(lineage%cover)/elements(lineage%cover), 1, 2)
  end subroutine carry_hold

  !> Holds points where they are to be held by the state, and loads absorbing edges as they are loaded there.
  pure subroutine take_supports(state, model)
    type(state_t), intent(in) :: state
    type(model_t), intent(inout) :: model
    integer :: i

    if (allocated(model%effects%fixed_point)) &
      model%effects%fixed_point%home = state%home(:, model%effects%fixed_point%point)
    if (.not. allocated(model%effects%absorbing_edge)) return
    associate (absorbing => model%effects%absorbing_edge)
      do i = 1, size(absorbing%point, 2)
        absorbing%static_force(:, :, i) = state%static_force(:, absorbing%point(:, i))
      end do
    end associate
  end subroutine take_supports

  !> Hands the static forces on edges over to the absorbing edges of the stage that lie there: the reactions of supports, and what
  !> absorbing edges bore. A force between the ends of an edge goes to both, which is the same to an edge that stays straight.
  pure subroutine carry_static_forces(model_before, force, model, state)
    type(model_t), intent(in) :: model_before
    real(dp), intent(in) :: force(:, :)      !! (2, n_points before) per unit thickness
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    real(dp) :: along(2), from(2), share
    integer :: e, i, k

    if (.not. allocated(model%effects%absorbing_edge)) return
    associate (absorbing => model%effects%absorbing_edge, points => model_before%points)
      do i = 1, size(points%kind)
        if (all(points%kind(i) /= [roller_end, absorber_end])) cycle
        e = points%element(i)
        do k = absorbing%first(e), absorbing%first(e + 1) - 1
          associate (ends => absorbing%point(:, k))
            from = model_before%start_point(:, i) - model%start_point(:, ends(1))
            along = model%start_point(:, ends(2)) - model%start_point(:, ends(1))
            share = max(0.0_dp, min(1.0_dp, dot_product(from, along)/dot_product(along, along)))
            if (norm2(from - share*along) > round_off*model%extent) cycle
            state%static_force(:, ends(1)) = state%static_force(:, ends(1)) + (1 - share)*force(:, i)
            state%static_force(:, ends(2)) = state%static_force(:, ends(2)) + share*force(:, i)
            exit
          end associate
        end do
      end do
    end associate
  end subroutine carry_static_forces

  !> Velocities and accelerations of what can move.
  pure subroutine carry_rates(model_before, before, lineage, model, state)
    type(model_t), intent(in) :: model_before
    type(state_t), intent(in) :: before
    type(lineage_t), intent(in) :: lineage
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    integer :: e, k

    state%velocity = 0.0_dp
    state%acceleration = 0.0_dp
    do k = 1, size(model%elements%free)
      e = model%elements%free(k)
      associate (own => model%elements%unknown(:, e), parent => model_before%elements%unknown(:, lineage%element(e)))
        state%velocity(own) = before%velocity(parent)
        state%acceleration(own) = before%acceleration(parent)
      end associate
    end do
  end subroutine carry_rates

  !> How far tables have moved each point that they hold since the stage began.
  pure function moved_by_tables(model, time) result(way)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: time             !! since then
    real(dp) :: way(2, size(model%points%kind)) !! length
    integer :: i

    way = 0.0_dp
    if (.not. allocated(model%effects%fixed_point)) return
    associate (held => model%effects%fixed_point)
      do i = 1, size(held%point)
        if (.not. allocated(held%table(i)%time)) cycle
        way(:, held%point(i)) = value_at(held%table(i), time) - value_at(held%table(i), 0.0_dp)
      end do
    end associate
  end function moved_by_tables

  !> Places of the points, and where those are to be that are held. What the decks mark comes first, in the same order in all
  !> models; of the rollers those are the same that are of one element, began in one place and hold it one way.
  pure subroutine carry_points(model_before, before, lineage, model, state)
    type(model_t), intent(in) :: model_before
    type(state_t), intent(in) :: before
    type(lineage_t), intent(in) :: lineage
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    logical :: idle(size(model_before%points%kind))
    real(dp) :: along(2, size(model%points%kind)) ! directions of rollers, 0: of none
    real(dp) :: way(2, size(model%points%kind))   ! by tables
    real(dp) :: along_before(2, size(model_before%points%kind)), way_before(2, size(model_before%points%kind))
    integer, allocatable :: first(:), list(:)
    integer :: i, same

    along = directions_of(model)
    along_before = directions_of(model_before)
    way = moved_by_tables(model, state%time)
    way_before = moved_by_tables(model_before, before%time)
    idle = are_idle(model_before)
    call sort_into(merge(model_before%points%element, 0, model_before%points%kind == roller_end), model_before%n_elements, first, &
                   list)
    do i = 1, size(model%points%kind)
      associate (e => model%points%element(i), own => model%start_point(:, i))
        same = 0
        if (model%points%kind(i) <= bolt_end) same = merge(0, i, idle(i))
        if (model%points%kind(i) == roller_end) same = roller_at(lineage%element(e), own, along(:, i))
        if (same > 0) then
          state%point(:, i) = before%point(:, same)
          state%home(:, i) = before%home(:, same) + (way_before(:, same) - way(:, i))
        else
          state%point(:, i) = place_now(model, state, e, own)
          state%home(:, i) = state%point(:, i) - way(:, i)
        end if
      end associate
    end do

  contains

    !> The roller of the model before that began in a place of an element, and holds it in a direction; 0: there is none.
    pure integer function roller_at(e, place, direction) result(found)
      integer, intent(in) :: e
      real(dp), intent(in) :: place(2), direction(2)
      integer :: k

      found = 0
      do k = first(e), first(e + 1) - 1
        if (any(abs(model_before%start_point(:, list(k)) - place) > 0)) cycle
        if (.not. any(abs(along_before(:, list(k)) - direction) > 0)) found = list(k)
      end do
    end function roller_at

  end subroutine carry_points

  !> Directions of the rollers among the points; 0: it is none.
  pure function directions_of(model) result(direction)
    type(model_t), intent(in) :: model
    real(dp) :: direction(2, size(model%points%kind))

    direction = 0.0_dp
    if (.not. allocated(model%effects%fixed_point)) return
    associate (held => model%effects%fixed_point)
      if (allocated(held%direction)) direction(:, held%point) = held%direction
    end associate
  end function directions_of

  !> What contacts remember, those of what slept too.
  pure subroutine carry_contacts(model_before, before, lineage, model, state)
    type(model_t), intent(in) :: model_before
    type(state_t), intent(in) :: before
    type(lineage_t), intent(in) :: lineage
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    type(heirs_t) :: heirs
    real(dp) :: stiffness(2)
    integer :: i

    if (.not. allocated(before%contacts%contact)) return
    stiffness = state%contacts%stiffness
    state%contacts = before%contacts
    if (.not. model%settings%adapts_stiffness) state%contacts%stiffness = stiffness
    state%contacts%extra_reach = before%contacts%extra_reach(lineage%block)
    state%contacts%extra_turn = before%contacts%extra_turn(lineage%block)
    associate (memory => state%contacts)
      if (allocated(before%sleep)) then
        memory%contact = [memory%contact, before%sleep%contact]
        memory%inside = reshape([memory%inside, before%sleep%inside], [2, size(memory%inside, 2) + size(before%sleep%inside, 2)])
      end if
      heirs = heirs_of(model_before, lineage, model)
      do i = 1, size(memory%contact)
        call hand_on(heirs, memory%contact(i))
      end do
      memory%contact = pack(memory%contact, are_known(memory%contact))
      do i = 1, size(memory%inside, 2)
        memory%inside(:, i) = [heirs%vertex(memory%inside(1, i)), heirs%vertex(memory%inside(2, i))]
      end do
      memory%inside = columns(memory%inside, .not. any(memory%inside == 0, 1))
    end associate
  end subroutine carry_contacts

  !> Drops the memory of contacts of what a stage has removed. Closed ones have the stiffness of the stage.
  pure subroutine keep_what_is_there(model_before, model, state)
    type(model_t), intent(in) :: model_before
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    real(dp), allocatable :: bonds(:)
    integer :: i

    if (.not. allocated(state%contacts%contact) .or. .not. allocated(model%effects%contact)) return
    associate (memory => state%contacts)
      memory%contact = pack(memory%contact, are_there(model, memory%contact))
      memory%inside = columns(memory%inside, .not. any(parts_gone(memory%inside), 1))
      if (model%settings%adapts_stiffness) return
      bonds = mean_of_bonds(model%outlines, model%effects%contact, memory%contact)
      do i = 1, size(memory%contact)
        if (memory%contact(i)%entrance(memory%contact(i)%active)%state == state_open) cycle
        call change_stiffness(model%outlines, state%vertex, model_before%effects%contact, model%effects%contact, bonds(i), &
                              memory%contact(i))
      end do
    end associate

  contains

    !> Which vertices and edges are gone.
    pure function parts_gone(pair)
      integer, intent(in) :: pair(:, :)      !! (2, n)
      logical :: parts_gone(2, size(pair, 2))
      integer :: i

      do i = 1, size(pair, 2)
        parts_gone(:, i) = model%outlines%gone(pair(:, i))
      end do
    end function parts_gone

  end subroutine keep_what_is_there

  !> Which vertices and edges of the outlines those of the model before have become.
  pure type(heirs_t) function heirs_of(model_before, lineage, model) result(heirs)
    type(model_t), intent(in) :: model_before
    type(lineage_t), intent(in) :: lineage
    type(model_t), intent(in) :: model
    real(dp) :: along(2)
    integer :: at_place(size(model_before%start, 2)), i, j, k

    allocate (heirs%vertex(size(model_before%outlines%start)), heirs%from(size(lineage%edge)), heirs%to(size(lineage%edge)))
    call sort_into(lineage%edge, size(heirs%vertex), heirs%first, heirs%edge)
    at_place = 0
    do j = 1, size(lineage%edge)
      k = lineage%vertex(model%outlines%start(j))
      if (k > 0) at_place(k) = j
    end do
    do i = 1, size(heirs%vertex)
      heirs%vertex(i) = at_place(model_before%outlines%start(i))
      associate (a => model_before%start(:, model_before%outlines%start(i)))
        along = model_before%start(:, model_before%outlines%finish(i)) - a
        along = along/dot_product(along, along)
        do k = heirs%first(i), heirs%first(i + 1) - 1
          j = heirs%edge(k)
          heirs%from(j) = dot_product(along, model%start(:, model%outlines%start(j)) - a)
          heirs%to(j) = dot_product(along, model%start(:, model%outlines%finish(j)) - a)
          if (lineage%vertex(model%outlines%start(j)) == model_before%outlines%start(i)) heirs%vertex(i) = j
        end do
      end associate
    end do
  end function heirs_of

  !> Hands the memory of a contact on to the vertices and edges of the model; those are 0 where there is none. Of an edge that was
  !> cut the part gets it at which the contact is held.
  pure subroutine hand_on(heirs, contact)
    type(heirs_t), intent(in) :: heirs
    type(contact_t), intent(inout) :: contact
    integer :: best, i, j, k
    real(dp) :: beyond, least

    do i = 1, contact%n_entrances
      associate (entrance => contact%entrance(i))
        entrance%vertex = heirs%vertex(entrance%vertex)
        best = 0
        least = huge(least)
        do k = heirs%first(entrance%edge), heirs%first(entrance%edge + 1) - 1
          j = heirs%edge(k)
          beyond = max(0.0_dp, heirs%from(j) - entrance%anchor, entrance%anchor - heirs%to(j))
          if (beyond < least) best = j
          least = min(least, beyond)
        end do
        if (best > 0 .and. heirs%first(entrance%edge + 1) - heirs%first(entrance%edge) > 1) &
          entrance%anchor = (entrance%anchor - heirs%from(best))/(heirs%to(best) - heirs%from(best))
        entrance%edge = best
      end associate
    end do
  end subroutine hand_on

  !> Which contacts have all their vertices and edges.
  pure function are_known(contact)
    type(contact_t), intent(in) :: contact(:)
    logical :: are_known(size(contact))
    integer :: i

    do i = 1, size(contact)
      associate (entrance => contact(i)%entrance(:contact(i)%n_entrances))
        are_known(i) = all(entrance%vertex > 0 .and. entrance%edge > 0)
      end associate
    end do
  end function are_known

  !> Which contacts are of blocks that are there.
  pure function are_there(model, contact)
    type(model_t), intent(in) :: model
    type(contact_t), intent(in) :: contact(:)
    logical :: are_there(size(contact))
    integer :: i

    do i = 1, size(contact)
      associate (entrance => contact(i)%entrance(1))
        are_there(i) = .not. any(model%outlines%gone([entrance%vertex, entrance%edge]))
      end associate
    end do
  end function are_there

  !> Memory of bolts; bolts that the stage before did not have begin with their pretension.
  pure subroutine carry_bolts(before, pretension, model, state)
    type(state_t), intent(in) :: before
    real(dp), intent(in) :: pretension(:)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    integer :: i

    do i = 1, size(pretension)
      if (state%bolts%state(i) == bolt_absent) cycle
      state%bolts%state(i) = before%bolts%state(i)
      state%bolts%rest(i) = before%bolts%rest(i)
      state%bolts%across(i) = before%bolts%across(i)
      if (before%bolts%state(i) == bolt_absent) call begin_bolt(model%effects%bolt, i, state%point, pretension(i), state%bolts)
    end do
  end subroutine carry_bolts

  !> Where displacements count from, as in the stage before; points that this did not have count from their start.
  pure subroutine carry_reference(before, model, state)
    type(reference_t), intent(in) :: before
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    integer :: n

    n = count(model%points%kind <= bolt_end)
    state%reference = reference_t(before%vertex, model%start_point)
    state%reference%point(:, :n) = before%point(:, :n)
  end subroutine carry_reference

end module scree_carry_over
