!> Growth of cracks in the middle of a run: the model is cut further, and the state goes on in it.
module scree_growth
  use scree_block_input, only: blocks_t
  use scree_carry_over, only: carry_through_cut
  use scree_change_of_model, only: go_on_with, set_up_anew
  use scree_crack_cutting, only: cut_blocks
  use scree_crack_growth, only: find_growth
  use scree_crack_piece, only: growth_t
  use scree_crack_tip, only: crack_tip_t
  use scree_equilibrium, only: begin_settling
  use scree_errors, only: error_t, fail, status_bad_input, status_run_failed
  use scree_kinds, only: dp
  use scree_lineage, only: lineage_of, lineage_t
  use scree_model, only: cache_t, model_t
  use scree_progress, only: progress_t, tell
  use scree_scene, only: scene_t
  use scree_state, only: cracks_t, state_t, time_of_run
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
  subroutine grow_cracks(scene, n_drawn, blocks, model, cache, state, watch, progress, parent, error)
    type(scene_t), intent(in) :: scene           !! of the stage
    integer, intent(in) :: n_drawn               !! blocks of the decks
    type(blocks_t), intent(inout) :: blocks      !! as cracks have cut them
    type(model_t), intent(inout) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(inout) :: state
    type(watch_t), intent(inout) :: watch
    type(progress_t), intent(inout) :: progress
    integer, allocatable, intent(out) :: parent(:) !! (n_elements) element before that each is part of; not allocated: none grew
    type(error_t), allocatable, intent(out) :: error
    type(growth_t) :: growth
    type(cracks_t) :: own
    integer :: i, n, n_before

    if (.not. model%settings%cracks_may_grow()) return
    if (allocated(state%reference)) then
      call fail(error, status_bad_input, 'expected no stage.reset=displacements or both where cracks may grow, as new vertices '// &
                'count from the start, found it')
      return
    end if
    call find_growth(model, cache, state, growth)
    call tell_tips(model, growth%tip, watch, progress)
    call tell_beginnings(model, growth, progress)
    n = size(growth%tip)
    if (n == 0) return
    n_before = size(blocks%material)
    own%piece = growth%piece + spread([model%origin - blocks%origin, model%origin - blocks%origin], 2, n)
    own%joint = growth%joint
    own%tip = growth%number
    own%time = [(time_of_run(state), i=1, n)]
    call cut_model(scene, own, blocks, model, cache, state, watch, parent, error)
    if (allocated(error)) return
    if (.not. allocated(state%cracks)) &
      state%cracks = cracks_t(reshape([real(dp) ::], [4, 0]), [integer ::], [integer ::], [real(dp) ::])
    associate (all_of_them => state%cracks)
      all_of_them%piece = reshape([all_of_them%piece, own%piece], [4, size(all_of_them%joint) + n])
      all_of_them%joint = [all_of_them%joint, own%joint]
      all_of_them%tip = [all_of_them%tip, own%tip]
      all_of_them%time = [all_of_them%time, own%time]
    end associate
    if (size(blocks%material) == n_before) return
    call tell(progress, 'a crack cuts through at time '//rounded_text(time_of_run(state))//': '// &
              number_text(size(blocks%material))//' blocks')
    if (size(blocks%material) > n_drawn + model%settings%crack_parts) &
      call fail(error, status_run_failed, 'a block breaks off for which the results have no room; try cracks.parts above '// &
                number_text(model%settings%crack_parts))
  end subroutine grow_cracks

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
  subroutine cut_model(scene, cracks, blocks, model, cache, state, watch, parent, error)
    type(scene_t), intent(in) :: scene           !! of the stage
    type(cracks_t), intent(in) :: cracks         !! further pieces, of one time
    type(blocks_t), intent(inout) :: blocks
    type(model_t), intent(inout) :: model
    type(cache_t), intent(inout) :: cache
    type(state_t), intent(inout) :: state
    type(watch_t), intent(inout) :: watch
    integer, allocatable, intent(out) :: parent(:) !! (n_elements) element before that each is part of
    type(error_t), allocatable, intent(out) :: error
    type(model_t) :: cut
    type(state_t) :: on
    type(lineage_t) :: lineage

    call set_up_cut(scene, cracks, model%tip, blocks, cut, on, error)
    if (allocated(error)) return
    lineage = lineage_of(model, cut)
    call carry_through_cut(model, state, lineage, cut, on)
    watch%soft = watch%soft(lineage%element)
    parent = lineage%element
    call go_on_with(cut, on, model, cache, state)
    if (.not. model%settings%balance > 0) return
    call begin_settling(model, state)
    state%pace%size = model%settings%step_size
    state%pace%easy = 0
  end subroutine cut_model

end module scree_growth
