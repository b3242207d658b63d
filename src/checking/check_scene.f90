!> `scree check`: what a scene calls for, its facts in words of an engineer, and warnings.
module scree_check_scene
  use scree_block_input, only: blocks_t, joined_text
  use scree_boundary_rock, only: boundary_warning
  use scree_crack_speed, only: crack_step_warning
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_initial_overlaps, only: overlap_texts, overlap_warning, refuse_overlaps
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_model_facts, only: block_fact_t, facts_of, facts_t, list_text, n_sides, side_name
  use scree_model_warnings, only: warnings_of
  use scree_named_units, only: with_units
  use scree_progress, only: progress_t, warn
  use scree_scene, only: effect_t, order_text, scene_of_stage, scene_t
  use scree_set_up, only: set_up
  use scree_stages, only: lines_of_stages
  use scree_state, only: state_t
  use scree_text, only: append, number_text, place_text, short_text, text_t
  implicit none
  private
  public :: check_scene, warn_of_model

  integer, parameter :: label_width = 30

contains

  !> Prints effects and facts, unless quiet, and warnings. Errors: what set-up refuses; warnings where they are to be errors.
  subroutine check_scene(scene, blocks, quiet, strict, unit, error)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    logical, intent(in) :: quiet
    logical, intent(in) :: strict       !! warnings are errors
    integer, intent(in) :: unit
    type(error_t), allocatable, intent(out) :: error
    type(model_t) :: model
    type(state_t) :: state
    type(effect_t), allocatable :: list(:)
    type(facts_t) :: facts
    type(text_t), allocatable :: line(:)
    integer :: i

    call set_up(scene, blocks, model, state, list, error)
    if (allocated(error)) return
    call facts_of(scene, blocks, model, state, facts)
    if (.not. quiet) then
      write (unit, '(3(i0,a))') facts%n_blocks, ' blocks, ', facts%n_elements, ' elements, ', facts%n_unknowns, ' unknowns'
      if (blocks%n_joined > 0) write (unit, '(a)') joined_text(blocks, scene)
      do i = 1, size(list)
        write (unit, '(a)') 'effect: '//list(i)%name//' - '//list(i)%because
      end do
      line = lines_of(scene, facts)
      do i = 1, size(line)
        write (unit, '(a)') line(i)%text
      end do
      line = overlap_texts(model)
      do i = 1, size(line)
        write (unit, '(a)') 'overlap: '//line(i)%text
      end do
    end if
    call refuse_overlaps(scene, blocks, model, error)
    if (allocated(error)) return
    call check_stages(scene, blocks, quiet, unit, error)
    if (allocated(error)) return
    line = [boundary_warning(blocks%boundary), warnings_of(scene, facts), overlap_warning(model), &
            crack_step_warning(scene, model)]
    do i = 1, size(line)
      write (unit, '(a)') 'warning: '//line(i)%text
    end do
    if (strict) call refuse(size(line), error)
  end subroutine check_scene

  !> Sets up the stages after the first, and says what each changes. Errors: what set-up refuses.
  subroutine check_stages(scene, blocks, quiet, unit, error)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    logical, intent(in) :: quiet
    integer, intent(in) :: unit
    type(error_t), allocatable, intent(out) :: error
    type(model_t) :: model
    type(state_t) :: state
    type(effect_t), allocatable :: list(:)
    type(text_t), allocatable :: line(:)
    integer :: k

    line = lines_of_stages(scene)
    do k = 1, size(line)
      call set_up(scene_of_stage(scene, k + 1, 0.0_dp), blocks, model, state, list, error)
      if (allocated(error)) return
      if (.not. quiet) write (unit, '(a)') line(k)%text
    end do
  end subroutine check_stages

  !> Warns of a model that is about to run. Errors: warnings where they are to be errors.
  subroutine warn_of_model(scene, blocks, model, state, strict, progress, error)
    type(scene_t), intent(in) :: scene
    type(blocks_t), intent(in) :: blocks
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    logical, intent(in) :: strict       !! warnings are errors
    type(progress_t), intent(inout) :: progress
    type(error_t), allocatable, intent(out) :: error
    type(facts_t) :: facts
    type(text_t), allocatable :: line(:)
    integer :: i

    call facts_of(scene, blocks, model, state, facts)
    line = [boundary_warning(blocks%boundary), warnings_of(scene, facts), overlap_warning(model), &
            crack_step_warning(scene, model)]
    do i = 1, size(line)
      call warn(progress, line(i)%text)
    end do
    if (strict) call refuse(size(line), error)
  end subroutine warn_of_model

  !> Makes warnings an error.
  subroutine refuse(n_warnings, error)
    integer, intent(in) :: n_warnings
    type(error_t), allocatable, intent(out) :: error

    if (n_warnings > 0) &
      call fail(error, status_bad_input, '--strict: expected no warnings, found '//number_text(n_warnings))
  end subroutine refuse

  !> The facts, one a line.
  function lines_of(scene, facts) result(line)
    type(scene_t), intent(in) :: scene
    type(facts_t), intent(in) :: facts
    type(text_t), allocatable :: line(:)
    character(len=:), allocatable :: numbers
    integer :: i

    allocate (line(0))
    call add('order of the numbers', order_text(scene))
    do i = 1, size(facts%block_material)
      numbers = ' of material '//number_text(facts%block_material(i))
      associate (rock => scene%block_material(facts%block_material(i)))
        if (.not. rock%density > 0) cycle
        call add('gravity'//numbers, short_text(rock%unit_weight/rock%density)//' length/time^2 (unit weight over density)')
        call add('wave speed'//numbers, short_text(sqrt(rock%young)/sqrt(rock%density))//' length/time')
      end associate
    end do
    call add('largest block', block_text(facts%largest))
    call add('smallest block', block_text(facts%smallest))
    call add('shortest edge', short_text(facts%shortest_edge)//' length')
    call add('slivers', list_text(facts%sliver))
    call add('fixed points', number_text(sum(facts%fixed_points))//' in '// &
             list_text(pack([(i, i=1, facts%n_blocks)], facts%fixed_points > 0)))
    call add('touch nothing that is held', list_text(facts%unheld))
    if (size(facts%meeting) > 0) call add('joint materials that meet', meeting_text(facts, scene%extent))
    if (facts%face_stiffness > 0) &
      call add('stiffness of contact', short_text(scene%settings%contact_stiffness)//' force/length'//joints_text(scene)// &
               '; a mass of blocks has '//short_text(facts%modulus)//' of the modulus of its rock')
    if (facts%column%strain > 0) then
      call add('strain under own weight', short_text(facts%column%strain)//' in block '//number_text(facts%column%block)// &
               ' under '//short_text(facts%column%height)//' length, '//short_text(facts%column%stress)//' force/length^2')
      if (facts%penetration > 0) &
        call add('overlap of contacts there', short_text(facts%penetration)//' length')
    end if
    if (facts%fall > 0) &
      call add('fall in a step', short_text(facts%fall)//' length, '//short_text(facts%fall/facts%shortest_edge)// &
               ' of the shortest edge')
    do i = 1, n_sides
      if (facts%side(i)%force > 0) &
        call add('initial stress, '//trim(side_name(i)), short_text(facts%side(i)%force)// &
                 ' force without support, most of block '//number_text(facts%side(i)%block))
    end do

  contains

    !> Adds a line, aligned.
    subroutine add(label, fact)
      character(len=*), intent(in) :: label, fact

      call append(line, label//repeat(' ', max(1, label_width - len(label)))//with_units(scene%settings, fact))
    end subroutine add

  end function lines_of

  !> Places where pieces of different joint materials meet, the first of many, and which of them acts.
  pure function meeting_text(facts, extent) result(text)
    type(facts_t), intent(in) :: facts
    real(dp), intent(in) :: extent      !! of the model, length
    character(len=:), allocatable :: text
    integer, parameter :: most = 3
    integer :: i, k

    text = number_text(size(facts%meeting))//' places, '
    if (size(facts%meeting) == 1) text = '1 place, '
    do i = 1, min(most, size(facts%meeting))
      associate (meeting => facts%meeting(i))
        do k = 1, size(meeting%joint)
          text = text//number_text(meeting%joint(k))//' '
          if (k < size(meeting%joint)) text = text//'and '
        end do
        text = text//'at '//place_text(meeting%position, extent)//', '
      end associate
    end do
    if (size(facts%meeting) > most) text = text//'...; '
    text = text(:len(text) - 2)//': the longer piece acts, of like pieces the weaker'
  end function meeting_text

  !> The stiffness of joint materials in words, where the scene has some.
  pure function joints_text(scene) result(text)
    type(scene_t), intent(in) :: scene
    character(len=:), allocatable :: text
    integer :: i

    text = ''
    if (.not. allocated(scene%settings%joint_kn)) return
    do i = 1, size(scene%settings%joint_kn)
      if (scene%settings%joint_kn(i) > 0) &
        text = text//', joint material '//number_text(i)//' '//short_text(scene%settings%joint_kn(i))//' force/length^3'
    end do
  end function joints_text

  !> A block in words.
  pure function block_text(block)
    type(block_fact_t), intent(in) :: block
    character(len=:), allocatable :: block_text

    block_text = number_text(block%number)//', '//short_text(block%area)//' length^2, about '// &
                 place_text(block%position, sqrt(block%area))
  end function block_text

end module scree_check_scene
