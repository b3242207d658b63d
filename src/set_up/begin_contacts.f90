!> Outlines of blocks, and the memory of contacts with which a run begins.
module scree_begin_contacts
  use scree_begin_elements, only: middle_of
  use scree_block_input, only: block_source, blocks_t
  use scree_body_overlap, only: find_overlaps
  use scree_contact_rules, only: rests_inside
  use scree_contacts, only: outlines_t, overlap_t
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_in_situ, only: stress_edges
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_outlines, only: make_outlines
  use scree_scene, only: scene_t
  use scree_sorting, only: columns
  use scree_state, only: state_t
  use scree_text, only: number_text, real_text
  implicit none
  private
  public :: begin_contacts

  real(dp), parameter :: any_jump = 1e30_dp !! of sides: no limit where the step is chosen by the travel, which has its own

contains

  !> Makes the outlines of the blocks, and the memory of contacts with which the first step begins.
  !>
  !> Errors: an outline that does not close, blocks under a mesh that overlap.
  subroutine begin_contacts(scene, blocks, model, state, error)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(model_t), intent(inout) :: model
    type(state_t), intent(inout) :: state
    type(error_t), allocatable, intent(out) :: error
    logical, allocatable :: fixed(:) ! (n_blocks)

    call make_outlines(model%elements%shape, state%vertex, model%elements%block, model%outlines, error)
    if (allocated(error)) then
      associate (o => model%outlines, i => findloc(model%outlines%next, 0, 1))
        call fail(error, status_bad_input, block_source(scene, blocks, o%block(i))//': expected an outline of block '// &
                  number_text(o%block(i))//' that closes, found it open at '// &
                  real_text(state%vertex(1, o%finish(i)) + model%origin(1))//' '// &
                  real_text(state%vertex(2, o%finish(i)) + model%origin(2)))
      end associate
      return
    end if
    allocate (fixed(model%n_blocks), source=.true.)
    fixed(model%free_block) = .false.
    model%outlines%fixed = fixed(model%outlines%block)
    model%outlines%gone = .not. model%present(model%outlines%block)
    if (allocated(scene%settings%k0) .and. rests_inside(model%effects%contact)) &
      call stress_edges(scene, blocks, model%system_t, state%vertex, model%outlines)
    allocate (state%contacts%contact(0))
    allocate (state%contacts%extra_reach(model%n_blocks), state%contacts%extra_turn(model%n_blocks), source=0.0_dp)
    state%contacts%stiffness = [model%effects%contact%normal_stiffness, model%effects%contact%shear_stiffness]
    if (model%n_elements == model%n_blocks) then
      call find_overlaps(model%outlines, state%vertex, model%overlaps, state%contacts%inside)
    else
      call find_overlaps_under_mesh(blocks, model%overlaps, error)
      if (allocated(error)) return
      allocate (state%contacts%inside(2, 0))
    end if
    if (.not. rests_inside(model%effects%contact)) state%contacts%inside = reshape([integer ::], [2, 0])
    associate (inside => state%contacts%inside, fixed => model%outlines%fixed, gone => model%outlines%gone)
      model%outlines%inside = columns(inside, .not. (fixed(inside(1, :)) .and. fixed(inside(2, :)) .or. &
                                                     gone(inside(1, :)) .or. gone(inside(2, :))))
    end associate
    state%contacts%inside = model%outlines%inside
    if (allocated(model%effects%sleep)) call keep_awake(model%n_blocks, state)
    if (scene%settings%chooses_step) model%effects%contact%largest_jump = any_jump
  end subroutine begin_contacts

  !> Lets bodies fall asleep; all of them are awake at first.
  pure subroutine keep_awake(n_blocks, state)
    integer, intent(in) :: n_blocks
    type(state_t), intent(inout) :: state

    allocate (state%sleep)
    allocate (state%sleep%island(n_blocks), state%sleep%quiet(n_blocks), source=0)
    allocate (state%sleep%since(n_blocks), source=0.0_dp)
    allocate (state%sleep%contact(0), state%sleep%inside(2, 0))
  end subroutine keep_awake

  !> Overlaps of blocks that a mathematical mesh has cut: its elements lie in one block each.
  subroutine find_overlaps_under_mesh(blocks, overlaps, error)
    type(blocks_t), intent(in) :: blocks
    type(overlap_t), allocatable, intent(out) :: overlaps(:)
    type(error_t), allocatable, intent(out) :: error
    type(outlines_t) :: outlines
    real(dp) :: vertex(2, size(blocks%vertex, 2))
    integer, allocatable :: inside(:, :)
    integer :: b

    vertex = blocks%vertex - spread(middle_of(blocks), 2, size(vertex, 2))
    call make_outlines(blocks%shape, vertex, [(b, b=1, size(blocks%material))], outlines, error)
    if (.not. allocated(error)) call find_overlaps(outlines, vertex, overlaps, inside)
  end subroutine find_overlaps_under_mesh

end module scree_begin_contacts
