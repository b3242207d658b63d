!> The program: words of the command line, exit status, nothing else.
program scree
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use scree_block_file, only: may_replace_blocks, write_block_file
  use scree_block_input, only: block_moments, blocks_t, joined_text, make_blocks
  use scree_boundary_rock, only: boundary_warning
  use scree_check_scene, only: check_scene
  use scree_command_line, only: command_t, help, read_command_line, usage
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_estimate, only: estimate_runs
  use scree_explain, only: explain_scene, explain_setting, explain_settings, is_setting
  use scree_files, only: refuse_to_replace, same_file
  use scree_joints, only: make_joints
  use scree_made_by, only: fact_t, facts_of_program, json_of_facts, lines_of_facts
  use scree_read_scene, only: read_geometry, read_scene
  use scree_regions, only: first_vertex_of, last_vertex_of, loops_of, region_count
  use scree_restart, only: find_decks
  use scree_scene, only: scene_t
  use scree_simplex_integration, only: moments_t
  use scree_simulation, only: simulate
  use scree_text, only: number_text, text_t
  use scree_timers, only: begin_phase, begin_timers, cost_t, costs_of, phase_frames, phase_read, phase_set_up, timers_t
  implicit none

  type(command_t) :: command
  integer :: i
  type(error_t), allocatable :: error
  type(scene_t) :: scene
  type(blocks_t) :: blocks
  type(timers_t) :: timers

  call begin_timers(timers)
  call read_command_line(command, error)
  if (.not. allocated(error)) then
    select case (command%verb)
    case ('--version')
      call tell_version()
    case ('--help')
      write (output_unit, '(a)') (trim(help(i)), i=1, size(help))
    case ('usage')
      write (error_unit, '(a)') (trim(usage(i)), i=1, size(usage))
      call exit_with(status_bad_input)
    case default
      if (command%settings_only) then
        call explain_settings(output_unit)
      else if (command%verb == 'explain' .and. len(command%geometry) == 0 .and. is_setting(command%analysis)) then
        call explain_setting(command%analysis, output_unit)
      else if (command%verb == 'cut' .and. .not. command%cuts_analysis) then
        call cut_geometry()
      else if (command%verb == 'joints') then
        call make_joints(command%analysis, command%options%results_path, command%options%quiet, error)
      else if (command%verb == 'estimate') then
        call estimate_runs(command%geometry, command%analysis, command%settings, command%accuracy, output_unit, error)
      else
        call begin_phase(timers, phase_read)
        if (len(command%options%restart_path) > 0) &
          call find_decks(command%options%restart_path, command%geometry, command%analysis, command%settings, error)
        if (.not. allocated(error)) &
          call read_scene(command%geometry, command%analysis, command%settings, scene, blocks, error)
        if (.not. allocated(error)) call act()
      end if
    end select
  end if
  if (allocated(error)) then
    write (error_unit, '(a)') 'scree: '//error%message
    flush (error_unit)
    call exit_with(error%status)
  end if

contains

  !> Prints the version of the program, its compiler and its libraries.
  subroutine tell_version()
    type(fact_t), allocatable :: fact(:)
    type(text_t), allocatable :: line(:)
    integer :: i

    fact = facts_of_program(threads=0)
    if (command%options%with_json) then
      write (output_unit, '(a)') json_of_facts(fact)
    else
      line = lines_of_facts(fact)
      write (output_unit, '(a)') (line(i)%text, i=1, size(line))
    end if
  end subroutine tell_version

  !> Does what the verb asks with the scene.
  subroutine act()
    select case (command%verb)
    case ('run', 'cut')
      call simulate(scene, blocks, timers, command%options, error)
    case ('check')
      call check_scene(scene, blocks, command%options%quiet, command%options%strict, output_unit, error)
    case ('explain')
      call explain_scene(scene, output_unit)
    end select
  end subroutine act

  !> Cuts a geometry to a block file.
  subroutine cut_geometry()
    character(len=:), allocatable :: output
    type(text_t), allocatable :: warning(:)
    integer :: i

    output = command%options%results_path
    if (same_file(output, command%analysis)) then
      call fail(error, status_bad_input, output//': expected another file for what is cut, found the geometry')
    else if (.not. may_replace_blocks(output)) then
      call refuse_to_replace(output, 'a block file', error)
    end if
    if (allocated(error)) return
    scene%geometry_name = command%analysis
    call begin_phase(timers, phase_read)
    call read_geometry(scene, error)
    if (allocated(error)) return
    call begin_phase(timers, phase_set_up)
    call make_blocks(scene, blocks, error)
    if (allocated(error)) return
    call begin_phase(timers, phase_frames)
    call write_block_file(output, blocks, scene%words, error)
    if (allocated(error)) return
    warning = boundary_warning(blocks%boundary)
    do i = 1, size(warning)
      write (error_unit, '(a)') 'scree: warning: '//scene%geometry_name//': '//warning(i)%text
    end do
    if (size(blocks%crack_joint) > 0) write (error_unit, '(a)') 'scree: warning: '//output//' is without the '// &
      number_text(size(blocks%crack_joint))//' pieces of joints that end inside blocks, which a mesh would open'
    if (.not. command%options%quiet) call list_blocks(costs_of(timers))
  end subroutine cut_geometry

  !> Prints the blocks: material, corners, holes, area, centroid.
  subroutine list_blocks(cost)
    type(cost_t), intent(in) :: cost(:) !! of reading, set-up, which is cutting, and frames, which is writing
    type(moments_t) :: moments(region_count(blocks%shape))
    integer :: b

    do b = 1, size(moments)
      moments(b) = block_moments(blocks, b)
    end do
    write (output_unit, '(2(i0,a),es23.16,3(a,f7.3),a)') size(moments), ' blocks, ', size(blocks%crack_joint), &
      ' cracks, area ', sum(moments%area), '; read ', sum(cost%wall, cost%phase == 'read'), ' s, cut ', &
      sum(cost%wall, cost%phase == 'set-up'), ' s, write ', sum(cost%wall, cost%phase == 'frames'), ' s'
    if (blocks%n_joined > 0) write (output_unit, '(a)') joined_text(blocks, scene)
    write (output_unit, '(a)') '   block material  corners    holes                    area              x              y'
    do b = 1, size(moments)
      write (output_unit, '(i8,3i9,1x,es23.16,2(1x,es14.7))') b, blocks%material(b), &
        last_vertex_of(blocks%shape, b) - first_vertex_of(blocks%shape, b) + 1, size(loops_of(blocks%shape, b)) - 2, &
        moments(b)%area, moments(b)%centroid + blocks%origin
    end do
  end subroutine list_blocks

  !> Ends the program with a status (a variable stop code is not Fortran 2008).
  subroutine exit_with(status)
    integer, intent(in) :: status
    interface
      subroutine c_exit(status) bind(c, name='exit')
        use, intrinsic :: iso_c_binding, only: c_int
        integer(c_int), value :: status
      end subroutine c_exit
    end interface

    call c_exit(int(status))
  end subroutine exit_with

end program scree
