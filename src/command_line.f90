!> The words of the command line.
module scree_command_line
  use scree_errors, only: error_t, fail, status_bad_input
  use scree_scene, only: run_options_t
  use scree_text, only: append, in_lower_case, text_t
  implicit none
  private
  public :: command_t, help, read_command_line, usage

  character(len=*), parameter :: help(*) = [character(len=104) :: &
    'scree: blocky and jointed rock by Discontinuous Deformation Analysis and the Numerical', &
    '       Manifold Method, with large deformation', &
    '', &
    'scree run     [GEOMETRY] ANALYSIS | STEM   reads the decks, simulates, writes results', &
    'scree run     --restart FILE               goes on with the run of a results file from its last', &
    '                                           checkpoint; its decks and settings are those of the run', &
    'scree check   [GEOMETRY] ANALYSIS | STEM   reads and checks, says what is in it, warns, runs nothing', &
    'scree estimate [GEOMETRY] ANALYSIS | STEM  tells from short runs how long whole ones will take, as the', &
    '                                           deck is, with each --accuracy and by the other scheme', &
    'scree explain [GEOMETRY] ANALYSIS | STEM   prints the decks back, each number with its meaning', &
    'scree explain --settings                   prints the table of all settings', &
    'scree explain GROUP.NAME                   prints what a setting means, or all settings of a GROUP', &
    'scree cut     GEOMETRY                     writes the blocks as a block file and prints their areas', &
    'scree cut     [GEOMETRY] ANALYSIS -o FILE  writes the model as a results file, runs nothing', &
    'scree joints  DECK                         draws statistical joint sets in a window with tunnels and', &
    '                                           slopes, writes a geometry deck', &
    'scree --version [json]                     prints the version, the compiler and the libraries in use', &
    'scree --help', &
    '', &
    '  -o, --output FILE         what run, cut or joints writes; default: the stem of the deck and', &
    '                            .h5, .blk or .geo, here; with --restart the file itself', &
    '  --accuracy A ...          estimate: values of step.accuracy, each of which is a run of its own', &
    '  --set GROUP.NAME=VALUE    a setting, in place of that of the deck; may be repeated', &
    '  --set "joint(1).phi=30"   a number of a deck, by its name in doc/decks.md, with the checks of the deck', &
    '  --restart FILE            run: goes on with a run; --set may change how it goes on', &
    '  --steps N                 run: pauses after N steps, such that --restart goes on', &
    '  --xdmf                    writes an XDMF side-car too', &
    '  --classic-output          run: writes the frames as Shi''s programs keep them too, .replay', &
    '  --strict                  run, check: warnings are errors', &
    '  --threads N               run: threads of small steps in scenes of 3000 blocks and more; default 1', &
    '  --quiet                   prints errors and warnings alone', &
    '  --summary json            run: prints the summary of the run as a JSON object, with --quiet too', &
    '', &
    'Exit status: 0 done, 1 the run failed, 2 bad input, 130 or 143 stopped by SIGINT (Ctrl-C) or SIGTERM;', &
    'the results file of a run that stops has all that it did.']

  !> What the program says where it is called without a word.
  character(len=*), parameter :: usage(*) = [character(len=88) :: &
    'usage: scree COMMAND DECK ... [options]', &
    '', &
    '  scree check   slope.ana      reads a deck, says what is in it and what may be wrong', &
    '  scree run     slope.ana      simulates it and writes slope.h5', &
    '  scree cut     slope.geo      cuts lines to blocks and writes slope.blk', &
    '  scree joints  slope.joints   draws joint sets and writes slope.geo', &
    '  scree explain slope.ana      prints every number of a deck with its meaning', &
    '  scree estimate slope.ana     tells how long a run will take', &
    '  scree --help                 all commands and options', &
    '', &
    'expected a command, found none']

  character(len=*), parameter :: verbs(*) = [character(len=8) :: 'run', 'check', 'estimate', 'explain', 'cut', 'joints']

  !> An option, and the verbs that it goes with.
  type :: command_option_t
    character(len=16) :: name
    character(len=40) :: verbs
  end type command_option_t

  character(len=*), parameter :: any_verb = 'run check estimate explain cut joints'
  type(command_option_t), parameter :: switches(*) = [ &
    command_option_t('--quiet', any_verb), command_option_t('--xdmf', any_verb), command_option_t('--classic-output', 'run'), &
    command_option_t('--strict', 'run or check'), command_option_t('--settings', 'explain')]
  type(command_option_t), parameter :: with_word(*) = [ & ! that belongs to them
    command_option_t('--set', 'run, check, estimate, explain or cut'), command_option_t('-o', 'run, cut or joints'), &
    command_option_t('--output', 'run, cut or joints'), command_option_t('--restart', 'run'), &
    command_option_t('--summary', 'run'), command_option_t('--threads', 'run'), command_option_t('--steps', 'run'), &
    command_option_t('--accuracy', 'estimate')]

  !> What the command line asks for.
  type :: command_t
    character(len=:), allocatable :: verb         !! one of the help, or --version, --help, usage
    character(len=:), allocatable :: geometry     !! '' where the analysis names it
    character(len=:), allocatable :: analysis     !! deck; of `cut` and `joints` the one there is
    type(text_t), allocatable :: settings(:)    !! given with --set
    type(text_t), allocatable :: accuracy(:)    !! estimate: values of step.accuracy
    logical :: settings_only = .false.            !! explain: the table of settings
    logical :: cuts_analysis = .false.            !! cut: an analysis deck, else a geometry
    type(run_options_t) :: options
  end type command_t

contains

  !> Takes the command line apart.
  !>
  !> Errors: a word that is unknown or does not go with the verb, a word that is missing.
  subroutine read_command_line(command, error)
    type(command_t), intent(out) :: command
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    allocate (command%settings(0), command%accuracy(0))
    command%geometry = ''
    command%analysis = ''
    command%options%results_path = ''
    command%options%restart_path = ''
    command%verb = argument(1)
    if (command_argument_count() == 0) command%verb = 'usage'
    if (command%verb == '-h' .or. command%verb == 'help') command%verb = '--help'
    if (command%verb == '--version') call take_form(argument(2), command, error)
    if (any(command%verb == [character(len=9) :: '--version', '--help', 'usage'])) return
    if (all(command%verb /= verbs)) then
      call fail(error, status_bad_input, 'expected run, check, estimate, explain, cut, joints, --version or --help, found '''// &
                command%verb//'''')
      return
    end if
    i = 2
    do while (i <= command_argument_count() .and. command%verb /= '--help')
      call take_word(i, command, error)
      if (allocated(error)) return
    end do
    if (command%verb == '--help') return
    call complete(command, error)
  end subroutine read_command_line

  !> Takes the word after --version.
  subroutine take_form(given, command, error)
    character(len=*), intent(in) :: given
    type(command_t), intent(inout) :: command
    type(error_t), allocatable, intent(out) :: error

    command%options%with_json = given == 'json'
    if (len(given) > 0 .and. .not. command%options%with_json) &
      call fail(error, status_bad_input, 'expected json or nothing after --version, found '''//given//'''')
  end subroutine take_form

  !> Takes the word at `i`, and the one that belongs to it.
  subroutine take_word(i, command, error)
    integer, intent(inout) :: i
    type(command_t), intent(inout) :: command
    type(error_t), allocatable, intent(out) :: error
    character(len=:), allocatable :: given, word

    word = argument(i)
    i = i + 1
    call expect_verb([switches, with_word], word, command%verb, error)
    if (allocated(error)) return
    if (word == '--help' .or. word == '-h') then
      command%verb = '--help'
    else if (any(with_word%name == word)) then
      if (i > command_argument_count()) then
        call fail(error, status_bad_input, 'expected a word after '//word//', found the end')
        return
      end if
      do
        given = argument(i)
        call take_value(word, given, command, error)
        i = i + 1
        if (allocated(error) .or. word /= '--accuracy' .or. i > command_argument_count()) exit
        if (verify(argument(i), '0123456789.eEdD+-') > 0) exit
      end do
    else if (any(switches%name == word)) then
      call take_switch(word, command)
    else if (index(word, '-') == 1) then
      call fail(error, status_bad_input, 'expected an option of --help, found '''//word//'''')
    else
      call take_deck(word, command, error)
    end if
  end subroutine take_word

  !> Error where a word is an option that does not go with the verb.
  pure subroutine expect_verb(options, word, verb, error)
    type(command_option_t), intent(in) :: options(:)
    character(len=*), intent(in) :: word, verb
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    i = findloc(options%name == word, .true., 1)
    if (i == 0) return
    if (index(options(i)%verbs, verb) == 0) &
      call fail(error, status_bad_input, 'expected '//word//' with '//trim(options(i)%verbs)//', found it with '//verb)
  end subroutine expect_verb

  !> Takes the word that belongs to the one before it.
  subroutine take_value(word, given, command, error)
    character(len=*), intent(in) :: word, given
    type(command_t), intent(inout) :: command
    type(error_t), allocatable, intent(out) :: error

    if (len(given) == 0) then
      call fail(error, status_bad_input, 'expected a word after '//word//', found an empty one')
      return
    end if
    select case (word)
    case ('--set')
      call append(command%settings, given)
    case ('--accuracy')
      call append(command%accuracy, given)
    case ('--summary')
      command%options%with_json = given == 'json'
      if (.not. command%options%with_json) &
        call fail(error, status_bad_input, 'expected json after --summary, found '''//given//'''')
    case ('--threads')
      call take_count(word, given, command%options%threads, error)
    case ('--steps')
      call take_count(word, given, command%options%steps, error)
    case ('--restart')
      command%options%restart_path = given
    case default
      command%options%results_path = given
    end select
  end subroutine take_value

  !> Reads the number from 1 that belongs to a word.
  subroutine take_count(word, given, value, error)
    character(len=*), intent(in) :: word, given
    integer, intent(out) :: value
    type(error_t), allocatable, intent(out) :: error
    integer :: status

    read (given, '(i9)', iostat=status) value
    if (status /= 0 .or. value < 1) &
      call fail(error, status_bad_input, 'expected a number from 1 after '//word//', found '''//given//'''')
  end subroutine take_count

  !> Takes a word that turns something on.
  subroutine take_switch(word, command)
    character(len=*), intent(in) :: word
    type(command_t), intent(inout) :: command

    select case (word)
    case ('--quiet')
      command%options%quiet = .true.
    case ('--xdmf')
      command%options%with_xdmf = .true.
    case ('--classic-output')
      command%options%with_classic = .true.
    case ('--strict')
      command%options%strict = .true.
    case ('--settings')
      command%settings_only = .true.
    end select
  end subroutine take_switch

  !> Takes the name of a deck: of two the first is the geometry.
  subroutine take_deck(word, command, error)
    character(len=*), intent(in) :: word
    type(command_t), intent(inout) :: command
    type(error_t), allocatable, intent(out) :: error

    if (command%verb == 'joints' .and. len(command%analysis) > 0) then
      call fail(error, status_bad_input, 'expected one deck after joints, found also '''//word//'''')
    else if (len(command%geometry) > 0) then
      call fail(error, status_bad_input, 'expected at most a geometry and an analysis deck, found also '''//word//'''')
    else
      command%geometry = command%analysis
      command%analysis = word
    end if
  end subroutine take_deck

  !> Looks at the whole, and names the file that it writes.
  subroutine complete(command, error)
    type(command_t), intent(inout) :: command
    type(error_t), allocatable, intent(out) :: error

    associate (analysis => command%analysis, options => command%options)
      if (len(options%restart_path) > 0) then
        if (options%with_classic) call fail(error, status_bad_input, 'expected --classic-output without --restart, found both')
        if (len(options%results_path) == 0) options%results_path = options%restart_path
      else if (len(analysis) == 0 .and. .not. command%settings_only) then
        call fail(error, status_bad_input, 'expected a deck after '//command%verb//', found none')
        return
      end if
      options%runs = command%verb == 'run'
      if (command%verb == 'cut') command%cuts_analysis = &
        len(command%geometry) > 0 .or. index(in_lower_case(analysis), '.ana', back=.true.) == max(1, len(analysis) - 3)
      if (command%verb == 'cut' .and. .not. command%cuts_analysis .and. (size(command%settings) > 0 .or. options%with_xdmf)) then
        call fail(error, status_bad_input, 'expected --set and --xdmf with an analysis deck, found them with cut '//analysis)
      else if (command%cuts_analysis .and. len(options%results_path) == 0) then
        call fail(error, status_bad_input, 'expected -o and a file for the model, as '//stem_of(analysis)// &
                  '.h5 would be that of a run, found none')
      end if
    end associate
    if (len(command%options%results_path) == 0) command%options%results_path = stem_of(command%analysis)//ending_of(command%verb)
  end subroutine complete

  !> Ending of the file that a verb writes.
  pure function ending_of(verb)
    character(len=*), intent(in) :: verb
    character(len=:), allocatable :: ending_of

    select case (verb)
    case ('cut')
      ending_of = '.blk'
    case ('joints')
      ending_of = '.geo'
    case default
      ending_of = '.h5'
    end select
  end function ending_of

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

end module scree_command_line
