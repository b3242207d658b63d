!> Growth of cracks in the middle of a run: the model is cut further, and the state goes on in it.
module scree_growth
  use scree_block_input, only: blocks_t
  use scree_carry_over, only: carry_through_cut
  use scree_change_of_model, only: go_on_with, set_up_anew
  use scree_crack_cutting, only: cut_blocks
  use scree_crack_growth, only: find_growth
  use scree_crack_piece, only: growth_t
  use scree_crack_records, only: put_growth
  use scree_crack_speed, only: rayleigh_speed
  use scree_crack_tip, only: crack_tip_t
  use scree_element_term, only: term_t
  use scree_equilibrium, only: begin_settling
  use scree_errors, only: error_t, fail, status_bad_input, status_run_failed
  use scree_hold, only: hold_t
  use scree_kinds, only: dp
  use scree_lineage, only: lineage_of, lineage_t
  use scree_model, only: cache_t, model_t
  use scree_progress, only: progress_t, tell
  use scree_reactions, only: forces_at_rest
  use scree_regions, only: first_vertex_of, last_vertex_of
  use scree_run_output, only: change_layout, run_output_t
  use scree_scene, only: scene_t
  use scree_state, only: cracks_t, pace_t, state_t, time_of_run
  use scree_system, only: values_of
  use scree_text, only: number_text, place_text, rounded_text
  use scree_watch, only: watch_t
  implicit none
  private
  public :: grow_cracks, resume_cut

  integer, parameter :: steps_of_run = 10 !! without a break, after which a crack that grows is said to run

contains

  !> Lets the cracks grow that do in a state, each by one piece. Static steps come to equilibrium from one side, as damped ones do,
  !> so cracks need not wait for it.
  !>
  !> Errors: a stage has reset displacements; more blocks broke off than the results have room for; those of a cut.
  subroutine grow_cracks(scene, n_drawn, blocks, output, progress, model, cache, state, watch, have_grown, error)
    type(scene_t), intent(in) :: scene           !! of the stage
    integer, intent(in) :: n_drawn               !! blocks of the decks
    type(blocks_t), intent(inout) :: blocks      !! as cracks have cut them
    type(run_output_t), intent(inout) :: output
    type(progress_t), intent(inout) :: progress
    type(model_t), intent(inout) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(inout) :: state
    type(watch_t), intent(inout) :: watch
    logical, intent(out) :: have_grown           !! cracks have, and the model is another
    type(error_t), allocatable, intent(out) :: error
    type(growth_t) :: growth
    type(cracks_t) :: own
    type(lineage_t) :: lineage
    real(dp), allocatable :: duration(:)
    real(dp) :: shift(2)
    integer :: i, n, n_before

    have_grown = .false.
    if (.not. model%settings%cracks_may_grow()) return
    if (allocated(state%reference)) then
      call fail(error, status_bad_input, 'expected no stage.reset=displacements or both where cracks may grow, as new vertices '// &
                'count from the start, found it')
      return
    end if
    call find_growth(model, cache, state, growth)
    if (allocated(state%hold)) call move_tips(model, state%pace, state%hold, growth)
    call tell_tips(model, growth%tip, watch, progress)
    call tell_beginnings(model, growth, progress)
    n = size(growth%tip)
    if (n == 0) return
    n_before = size(blocks%material)
    duration = durations_of(scene, model, growth)
    own%piece = growth%piece + spread([model%origin - blocks%origin, model%origin - blocks%origin], 2, n)
    own%joint = growth%joint
    own%tip = growth%number
    own%time = [(time_of_run(state), i=1, n)]
    call cut_model(scene, own, blocks, model, cache, state, watch, lineage, error)
    if (allocated(error)) return
    have_grown = .true.
    shift = blocks%origin - model%origin
    call hold_faces(lineage, own%piece + spread([shift, shift], 2, n), growth%number, duration, model, cache, state)
    if (.not. allocated(state%cracks)) then
      allocate (state%cracks)
      allocate (state%cracks%piece(4, 0), state%cracks%joint(0), state%cracks%tip(0), state%cracks%time(0))
    end if
    associate (all_of_them => state%cracks)
      all_of_them%piece = reshape([all_of_them%piece, own%piece], [4, size(all_of_them%joint) + n])
      all_of_them%joint = [all_of_them%joint, own%joint]
      all_of_them%tip = [all_of_them%tip, own%tip]
      all_of_them%time = [all_of_them%time, own%time]
    end associate
    if (size(blocks%material) > n_before) &
      call tell(progress, 'a crack cuts through at time '//rounded_text(time_of_run(state))//': '// &
                number_text(size(blocks%material))//' blocks')
    if (size(blocks%material) > n_drawn + model%settings%crack_parts) then
      call fail(error, status_run_failed, 'a block breaks off for which the results have no room; try cracks.parts above '// &
                number_text(model%settings%crack_parts))
    else
      call change_layout(output, model, lineage%element, .false.)
      call put_growth(output%file, output%records%growth, own, blocks%origin, error)
    end if
  end subroutine grow_cracks

  !> Lets tips go on through the triangles of their new faces, while they break the rock and no faster than Rayleigh waves, and
  !> leaves those out of the growth that are still on their way. A tip that has met a face goes on at once.
  subroutine move_tips(model, pace, hold, growth)
    type(model_t), intent(in) :: model
    type(pace_t), intent(in) :: pace
    type(hold_t), intent(inout) :: hold
    type(growth_t), intent(inout) :: growth
    integer, allocatable :: on_its_way(:)
    logical :: goes(size(growth%tip))
    integer :: i, p

    associate (breaks => growth%number)
      do p = 1, size(hold%tip)
        hold%next(p) = hold%share(p)
        if (any(breaks == hold%tip(p)) .or. .not. (any(model%tip%number == hold%tip(p)) .and. hold%duration(p) > 0)) &
          hold%next(p) = share_after(hold%share(p), pace%last, hold%duration(p))
      end do
      on_its_way = pack(hold%tip, hold%next > 0)
      goes = [(.not. any(on_its_way == breaks(i)), i=1, size(goes))]
    end associate
    growth%tip = pack(growth%tip, goes)
    growth%number = pack(growth%number, goes)
    growth%joint = pack(growth%joint, goes)
    growth%piece = growth%piece(:, pack([(i, i=1, size(goes))], goes))
  end subroutine move_tips

  !> Times in which tips pass the pieces by which they grow, no faster than Rayleigh waves. In a static run, and where a crack
  !> begins, 0.
  function durations_of(scene, model, growth) result(duration)
    type(scene_t), intent(in) :: scene
    type(model_t), intent(in) :: model
    type(growth_t), intent(in) :: growth
    real(dp) :: duration(size(growth%tip))
    integer :: i

    duration = 0.0_dp
    if (model%effects%is_static()) return
    do i = 1, size(duration)
      if (growth%tip(i) == 0) cycle ! a crack that begins
      associate (material => model%elements%material(model%tip(growth%tip(i))%element))
        if (.not. scene%block_material(material)%density > 0) cycle
        duration(i) = norm2(growth%piece(3:, i) - growth%piece(:2, i)) &
                      /rayleigh_speed(model%effects%elasticity(:, :, material), scene%block_material(material)%density)
      end associate
    end do
  end function durations_of

  !> Factor of the forces between new faces at the end of a step. It falls evenly while a tip passes a piece.
  elemental real(dp) function share_after(share, dt, duration)
    real(dp), intent(in) :: share                !! at its beginning
    real(dp), intent(in) :: dt                   !! size of the step, time
    real(dp), intent(in) :: duration             !! of the passage, time

    share_after = 0.0_dp
    if (duration > 0) share_after = max(0.0_dp, share - dt/duration)
  end function share_after

  !> Has the sides of new faces hold each other, with the forces that they exerted on each other until they were cut.
  subroutine hold_faces(lineage, piece, number, duration, model, cache, state)
    type(lineage_t), intent(in) :: lineage
    real(dp), intent(in) :: piece(:, :)          !! (4, n) x1 y1 x2 y2 by which tips have grown, in coordinates of the model, length
    integer, intent(in) :: number(:)             !! (n) of these tips
    real(dp), intent(in) :: duration(:)          !! (n) of the passage of each piece, time
    type(model_t), intent(in) :: model           !! after the cut
    type(cache_t), intent(in) :: cache
    type(state_t), intent(inout) :: state
    type(state_t) :: now
    type(term_t) :: terms(model%n_elements)
    real(dp) :: force(2, model%n_covers), rest(2, maxval(lineage%cover)), unknown(model%n_unknowns)
    real(dp) :: nearest(model%n_covers), way(size(number))
    integer, dimension(maxval(lineage%cover)) :: copies, bearers
    integer :: elements(model%n_covers), next(model%n_covers), c, e, k, n_before
    logical :: bears(model%n_covers)               ! its part of what the copies lack to balance, the reaction of a support

    now = state
    if (allocated(now%hold)) now%hold%next = now%hold%share
    call forces_at_rest(model, cache, now, terms)
    unknown = 0.0_dp
    elements = 0
    nearest = huge(nearest)
    do e = 1, model%n_elements
      associate (own => model%elements%unknown(:, e))
        unknown(own) = unknown(own) + terms(e)%force &
                       - matmul(cache%element(e)%mass_matrix, values_of(model%elements, e, state%acceleration))
      end associate
      associate (corner => model%start(:, first_vertex_of(model%elements%shape, e):last_vertex_of(model%elements%shape, e)))
        way = [(norm2(0.5_dp*(piece(:2, k) + piece(3:, k)) - sum(corner, 2)/size(corner, 2)), k=1, size(number))]
      end associate
      associate (covers => model%elements%cover(:, e))
        elements(covers) = elements(covers) + 1
        where (nearest(covers) > minval(way)) next(covers) = minloc(way, 1)
        nearest(covers) = min(nearest(covers), minval(way))
      end associate
    end do
    force = reshape(unknown, shape(force))
    bears = .false.
    if (allocated(model%effects%fixed_point)) then
      associate (held => model%points%element(model%effects%fixed_point%point))
        do k = 1, size(held)
          bears(model%elements%cover(:, held(k))) = .true.
        end do
      end associate
    end if
    copies = 0
    bearers = 0
    rest = 0.0_dp
    do c = 1, model%n_covers
      associate (parent => lineage%cover(c))
        copies(parent) = copies(parent) + 1
        if (bears(c)) bearers(parent) = bearers(parent) + 1
        rest(:, parent) = rest(:, parent) + force(:, c)
      end associate
    end do
    bears = bears .or. bearers(lineage%cover) == 0
    where (bearers == 0) bearers = copies
    if (.not. allocated(state%hold)) then
      allocate (state%hold)
      allocate (state%hold%tip(0), state%hold%duration(0), state%hold%share(0), state%hold%next(0))
      allocate (state%hold%force(2, model%n_covers), source=0.0_dp)
      allocate (state%hold%piece(model%n_covers), source=0)
    end if
    associate (hold => state%hold)
      n_before = size(hold%tip)
      hold%tip = [hold%tip, number]
      hold%duration = [hold%duration, duration]
      hold%share = [hold%share, 0*duration + 1]
      hold%next = [hold%next, share_after(1.0_dp, state%pace%last, duration)]
      do c = 1, model%n_covers
        if (copies(lineage%cover(c)) == 1) cycle
        force(:, c) = -force(:, c)
        if (bears(c)) force(:, c) = force(:, c) + rest(:, lineage%cover(c))/bearers(lineage%cover(c))
        force(:, c) = force(:, c)/elements(c)
        if (hold%piece(c) > 0) force(:, c) = force(:, c) + hold%share(hold%piece(c))*hold%force(:, c)
        hold%force(:, c) = force(:, c)
        hold%piece(c) = n_before + next(c)
      end do
    end associate
    call let_go(model, state%hold)
  end subroutine hold_faces

  !> Has the faces of a piece let go of each other where its sides are in different blocks since the last cut, as no tip is between
  !> them.
  pure subroutine let_go(model, hold)
    type(model_t), intent(in) :: model
    type(hold_t), intent(inout) :: hold
    integer :: first(size(hold%tip)), last(size(hold%tip)) ! block of each piece
    integer :: e, k

    first = huge(first)
    last = 0
    do e = 1, model%n_elements
      do k = 1, size(model%elements%cover, 1)
        associate (p => hold%piece(model%elements%cover(k, e)), block => model%elements%block(e))
          if (p == 0) cycle
          first(p) = min(first(p), block)
          last(p) = max(last(p), block)
        end associate
      end do
    end do
    where (first < last) hold%duration = 0.0_dp
    where (first < last) hold%next = 0.0_dp
  end subroutine let_go

  !> Cuts blocks by the pieces of cracks that have grown so far, those of one time at once, as the run has done it.
  subroutine cut_by_cracks(cracks, blocks, error)
    type(cracks_t), intent(in) :: cracks
    type(blocks_t), intent(inout) :: blocks
    type(error_t), allocatable, intent(out) :: error
    integer :: from, to

    from = 1
    do while (from <= size(cracks%joint))
      to = from + count(.not. cracks%time(from:) > cracks%time(from)) - 1
      call cut_blocks(cracks%piece(:, from:to), cracks%joint(from:to), blocks, error)
      if (allocated(error)) return
      from = to + 1
    end do
  end subroutine cut_by_cracks

  !> Says which tips go on growing in a static run. Each is said once.
  subroutine tell_tips(model, grows, watch, progress)
    type(model_t), intent(in) :: model
    integer, intent(in) :: grows(:)              !! tips of the model that grow
    type(watch_t), intent(inout) :: watch
    type(progress_t), intent(inout) :: progress
    integer :: i

    if (size(model%tip) == 0) return
    if (.not. allocated(watch%grown)) allocate (watch%grown(0))
    watch%grown = [watch%grown, spread(0, 1, max(0, maxval(model%tip%number) - size(watch%grown)))]
    do i = 1, size(model%tip)
      associate (grown => watch%grown(model%tip(i)%number))
        grown = merge(grown + 1, 0, any(grows == i))
        if (grown == steps_of_run .and. model%effects%is_static()) &
          call tell(progress, name_of(i)//' runs: it has grown in each of '//number_text(steps_of_run)//' steps')
      end associate
    end do

  contains

    !> A tip in words.
    function name_of(i) result(name)
      integer, intent(in) :: i
      character(len=:), allocatable :: name

      name = 'crack tip '//number_text(model%tip(i)%number)//' at '// &
             place_text(model%tip(i)%place + model%origin, model%extent, digits=4)
    end function name_of

  end subroutine tell_tips

  !> Says where cracks begin.
  subroutine tell_beginnings(model, growth, progress)
    type(model_t), intent(in) :: model
    type(growth_t), intent(in) :: growth
    type(progress_t), intent(inout) :: progress
    integer :: i

    do i = 1, size(growth%tip)
      if (growth%tip(i) > 0 .or. any(growth%number(:i - 1) == growth%number(i))) cycle
      call tell(progress, 'crack tip '//number_text(growth%number(i))//' begins at '// &
                place_text(growth%piece(:2, i) + model%origin, model%extent, digits=4))
    end do
  end subroutine tell_beginnings

  !> Cuts the blocks of the decks as cracks have in a run that goes on, and makes the model of them.
  subroutine resume_cut(scene, cracks, blocks, model, state, error)
    type(scene_t), intent(in) :: scene           !! of the stage
    type(cracks_t), intent(in) :: cracks         !! pieces by which cracks have grown so far
    type(blocks_t), intent(inout) :: blocks
    type(model_t), intent(inout) :: model        !! of the decks, then of the cut blocks
    type(state_t), intent(inout) :: state
    type(error_t), allocatable, intent(out) :: error
    type(crack_tip_t), allocatable :: drawn(:)

    call move_alloc(model%tip, drawn)
    call set_up_cut(scene, cracks, drawn, blocks, model, state, error)
  end subroutine resume_cut

  !> Cuts blocks further, and makes the model of them. Its tips keep the numbers that they had.
  subroutine set_up_cut(scene, cracks, before, blocks, model, state, error)
    type(scene_t), intent(in) :: scene           !! of the stage
    type(cracks_t), intent(in) :: cracks         !! pieces by which cracks have grown further
    type(crack_tip_t), allocatable, intent(in) :: before(:) !! tips until then
    type(blocks_t), intent(inout) :: blocks
    type(model_t), intent(out) :: model
    type(state_t), intent(out) :: state
    type(error_t), allocatable, intent(out) :: error

    call cut_by_cracks(cracks, blocks, error)
    if (.not. allocated(error)) call set_up_anew(scene, blocks, before, model, state, error, cracks)
  end subroutine set_up_cut

  !> Cuts the blocks of a model further, makes the model of them, and has the state go on in it.
  subroutine cut_model(scene, cracks, blocks, model, cache, state, watch, lineage, error)
    type(scene_t), intent(in) :: scene           !! of the stage
    type(cracks_t), intent(in) :: cracks         !! further pieces, of one time
    type(blocks_t), intent(inout) :: blocks
    type(model_t), intent(inout) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(inout) :: state
    type(watch_t), intent(inout) :: watch
    type(lineage_t), intent(out) :: lineage
    type(error_t), allocatable, intent(out) :: error
    type(model_t) :: cut
    type(state_t) :: on

    call set_up_cut(scene, cracks, model%tip, blocks, cut, on, error)
    if (allocated(error)) return
    lineage = lineage_of(model, cut)
    call carry_through_cut(model, state, lineage, cut, on)
    watch%soft = watch%soft(lineage%element)
    call go_on_with(cut, on, model, cache, state)
    if (.not. model%settings%balance > 0) return
    call begin_settling(model, state)
    state%pace%size = model%settings%step_size
    state%pace%easy = 0
  end subroutine cut_model

end module scree_growth
