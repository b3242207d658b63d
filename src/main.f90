!> The program: words of the command line, exit status, nothing else.
program scree
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use scree_block_file, only: may_replace_blocks, write_block_file
  use scree_block_input, only: block_moments, blocks_t, make_blocks
  use scree_check_scene, only: check_scene
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_explain, only: explain_scene, explain_settings
  use scree_files, only: refuse_to_replace, same_file
  use scree_joints, only: make_joints
  use scree_kinds, only: dp
  use scree_read_scene, only: option_t, read_geometry, read_scene
  use scree_regions, only: first_vertex_of, last_vertex_of, loops_of, region_count
  use scree_scene, only: scene_t
  use scree_simplex_integration, only: moments_t
  use scree_simulation, only: simulate, version
  use scree_timers, only: start_phase, stop_phase, timer_t
  implicit none

  character(len=*), parameter :: help(*) = [character(len=104) :: &
    'scree: blocky and jointed rock by Discontinuous Deformation Analysis and the Numerical', &
    '       Manifold Method, with large deformation', &
    '', &
    'scree run     [GEOMETRY] ANALYSIS | STEM   reads the decks, simulates, writes results', &
    'scree check   [GEOMETRY] ANALYSIS | STEM   reads and checks, says what is in it, warns, runs nothing', &
    'scree explain [GEOMETRY] ANALYSIS | STEM   prints the decks back, each number with its meaning', &
    'scree explain --settings                   prints the table of all settings', &
    'scree cut     GEOMETRY                     writes the blocks as a block file and prints their areas', &
    'scree cut     [GEOMETRY] ANALYSIS -o FILE  writes the model as a results file, runs nothing', &
    'scree joints  DECK                         draws statistical joint sets in a window with tunnels and', &
    '                                           slopes, writes a geometry deck', &
    'scree --version | --help', &
    '', &
    '  -o, --output FILE         what run, cut or joints writes; default: the stem of the deck and', &
    '                            .h5, .blk or .geo, here', &
    '  --set GROUP.NAME=VALUE    over what the deck says; may be repeated', &
    '  --xdmf                    writes an XDMF side-car too', &
    '  --classic-output          run: writes the frames as Shi''s programs keep them too, .replay', &
    '  --strict                  run, check: warnings are errors', &
    '  --quiet                   prints errors and warnings alone', &
    '', &
    'Exit status: 0 done, 1 the run failed, 2 bad input, 130 or 143 stopped by SIGINT (Ctrl-C) or SIGTERM;', &
    'what a run that stops has done is in its results file.']

  character(len=:), allocatable :: verb, analysis, geometry, output
  type(option_t), allocatable :: options(:)
  logical :: quiet, strict, with_xdmf, with_classic, settings_only, cuts_analysis
  integer :: i
  type(error_t), allocatable :: error
  type(scene_t) :: scene
  type(blocks_t) :: blocks
  type(timer_t) :: reading

  call read_command_line(error)
  if (.not. allocated(error)) then
    select case (verb)
    case ('--version')
      write (output_unit, '(a)') 'scree '//version
    case ('--help')
      write (output_unit, '(a)') (trim(help(i)), i=1, size(help))
    case default
      if (settings_only) then
        call explain_settings(output_unit)
      else if (verb == 'cut' .and. .not. cuts_analysis) then
        call cut_geometry()
      else if (verb == 'joints') then
        call make_joints(analysis, output, quiet, error)
      else
        call start_phase(reading)
        call read_scene(geometry, analysis, options, scene, blocks, error)
        call stop_phase(reading)
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

  !> Does what the verb asks with the scene.
  subroutine act()
    select case (verb)
    case ('run', 'cut')
      call simulate(scene, blocks, reading, output, verb == 'run', with_xdmf, with_classic, quiet, strict, error)
    case ('check')
      call check_scene(scene, blocks, quiet, strict, output_unit, error)
    case ('explain')
      call explain_scene(scene, output_unit)
    end select
  end subroutine act

  !> Cuts a geometry to a block file.
  subroutine cut_geometry()
    type(timer_t) :: timer(3) ! read, cut, write

    if (same_file(output, analysis)) then
      call fail(error, status_bad_input, output//': expected another file for what is cut, found the geometry')
    else if (.not. may_replace_blocks(output)) then
      call refuse_to_replace(output, 'a block file', error)
    end if
    if (allocated(error)) return
    scene%geometry_name = analysis
    call start_phase(timer(1))
    call read_geometry(scene, error)
    if (allocated(error)) return
    call stop_phase(timer(1))
    call start_phase(timer(2))
    call make_blocks(scene, blocks, error)
    if (allocated(error)) return
    call stop_phase(timer(2))
    call start_phase(timer(3))
    call write_block_file(output, blocks, error)
    if (allocated(error)) return
    call stop_phase(timer(3))
    if (.not. quiet) call list_blocks(timer%wall)
  end subroutine cut_geometry

  !> Prints the blocks: material, corners, holes, area, centroid.
  subroutine list_blocks(seconds)
    real(dp), intent(in) :: seconds(3)  !! that reading, cutting and writing took
    type(moments_t) :: moments(region_count(blocks%shape))
    integer :: b

    do b = 1, size(moments)
      moments(b) = block_moments(blocks, b)
    end do
    write (output_unit, '(2(i0,a),es23.16,3(a,f7.3),a)') size(moments), ' blocks, ', size(blocks%crack_joint), &
      ' cracks, area ', sum(moments%area), '; read ', seconds(1), ' s, cut ', seconds(2), ' s, write ', seconds(3), ' s'
    write (output_unit, '(a)') '   block material  corners    holes                    area              x              y'
    do b = 1, size(moments)
      write (output_unit, '(i8,3i9,1x,es23.16,2(1x,es14.7))') b, blocks%material(b), &
        last_vertex_of(blocks%shape, b) - first_vertex_of(blocks%shape, b) + 1, size(loops_of(blocks%shape, b)) - 2, &
        moments(b)%area, moments(b)%centroid + blocks%origin
    end do
  end subroutine list_blocks

  !> Takes the command line apart.
  subroutine read_command_line(error)
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: given, word
    integer :: i

    allocate (options(0))
    quiet = .false.
    strict = .false.
    with_xdmf = .false.
    with_classic = .false.
    settings_only = .false.
    cuts_analysis = .false.
    geometry = ''
    analysis = ''
    output = ''
    verb = argument(1)
    if (verb == '-h' .or. verb == 'help') verb = '--help'
    if (verb == '--version' .or. verb == '--help') return
    if (all(verb /= [character(len=7) :: 'run', 'check', 'explain', 'cut', 'joints'])) then
      call fail(error, status_bad_input, 'expected run, check, explain, cut, joints, --version or --help, found '''//verb//'''')
      return
    end if
    i = 2
    do while (i <= command_argument_count())
      word = argument(i)
      select case (word)
      case ('--help', '-h')
        verb = '--help'
        return
      case ('--quiet')
        quiet = .true.
      case ('--xdmf')
        with_xdmf = .true.
      case ('--classic-output')
        with_classic = verb == 'run'
        if (.not. with_classic) then
          call fail(error, status_bad_input, 'expected --classic-output with run, found it with '//verb)
          return
        end if
      case ('--strict')
        strict = verb == 'run' .or. verb == 'check'
        if (.not. strict) then
          call fail(error, status_bad_input, 'expected --strict with run or check, found it with '//verb)
          return
        end if
      case ('--settings')
        settings_only = verb == 'explain'
        if (.not. settings_only) then
          call fail(error, status_bad_input, 'expected --settings with explain, found it with '//verb)
          return
        end if
      case ('--set', '-o', '--output')
        i = i + 1
        if (i > command_argument_count()) then
          call fail(error, status_bad_input, 'expected a word after '//word//', found the end')
          return
        end if
        given = argument(i)
        if (word == '--set' .and. verb == 'joints') then
          call fail(error, status_bad_input, 'expected --set with run, check or explain, found it with joints')
          return
        else if (word == '--set') then
          options = [options, option_t(given)]
        else
          output = given
        end if
      case default
        if (index(word, '-') == 1) then
          call fail(error, status_bad_input, 'expected an option of --help, found '''//word//'''')
          return
        else if (verb == 'joints' .and. len(analysis) > 0) then
          call fail(error, status_bad_input, 'expected one deck after joints, found also '''//word//'''')
          return
        else if (len(geometry) > 0) then
          call fail(error, status_bad_input, 'expected at most a geometry and an analysis deck, found also '''//word//'''')
          return
        end if
        geometry = analysis
        analysis = word
      end select
      i = i + 1
    end do
    if (len(analysis) == 0 .and. .not. settings_only) then
      call fail(error, status_bad_input, 'expected a deck after '//verb//', found none')
      return
    end if
    cuts_analysis = verb == 'cut' .and. (len(geometry) > 0 .or. index(analysis, '.ana', back=.true.) == max(1, len(analysis) - 3))
    if (verb == 'cut' .and. .not. cuts_analysis .and. (size(options) > 0 .or. with_xdmf)) then
      call fail(error, status_bad_input, 'expected --set and --xdmf with an analysis deck, found them with cut '//analysis)
    else if (cuts_analysis .and. len(output) == 0) then
      call fail(error, status_bad_input, 'expected -o and a file for the model, as '//stem_of(analysis)// &
                '.h5 would be that of a run, found none')
    end if
    if (len(output) > 0 .or. allocated(error)) return
    select case (verb)
    case ('cut')
      output = stem_of(analysis)//'.blk'
    case ('joints')
      output = stem_of(analysis)//'.geo'
    case default
      output = stem_of(analysis)//'.h5'
    end select
  end subroutine read_command_line

  !> An argument of the command line, '' where there is none.
  function argument(i)
    integer, intent(in) :: i
    character(len=:), allocatable :: argument
    integer :: length

    call get_command_argument(i, length=length)
    allocate (character(len=length) :: argument)
    if (length > 0) call get_command_argument(i, argument)
  end function argument

  !> File name without folder and ending.
  function stem_of(name)
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: stem_of
    integer :: dot

    stem_of = name(index(name, '/', back=.true.) + 1:)
    dot = index(stem_of, '.', back=.true.)
    if (dot > 1) stem_of = stem_of(:dot - 1)
  end function stem_of

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
