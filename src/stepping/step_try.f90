!> A try of a step. It lives in `advance` and dies there: what a rejected try found is in here alone.
module scree_step_try
  use scree_contact_try, only: contact_try_t
  use scree_element_term, only: step_rule_t
  use scree_impact, only: impact_t
  use scree_iteration, only: element_group_t, iteration_t
  use scree_kinds, only: dp
  use scree_trouble, only: new_trouble, trouble_t
  implicit none
  private
  public :: begin_outcome, outcome_t, reject, try_t

  !> What a rejected try asks for: a shorter step, contacts looked for farther away, or stiffer contacts.
  integer, parameter, public :: remedy_shorter = 1, remedy_wider = 2, remedy_stiffer = 3

  !> Why a try is rejected. Contacts do not settle, or overlap too much. The deformation does not settle. Equations have no
  !> solution. A vertex jumps beyond the search, or goes farther than allowed. An element turns too far.
  integer, parameter, public :: cut_by_contacts = 1, cut_by_overlap = 2, cut_by_deformation = 3, cut_by_equations = 4, &
                                cut_by_leap = 5, cut_by_travel = 6, cut_by_turn = 7
  character(len=*), parameter, public :: cut_reasons(*) = [character(len=11) :: 'contacts', 'overlap', 'deformation', &
                                                           'equations', 'leap', 'travel', 'turn']

  !> What tries of a step came to.
  type :: outcome_t
    logical :: settled = .false.         !! of the last
    integer :: iterations = 0            !! of the slowest group of the last
    type(trouble_t) :: trouble           !! why the last one has not settled
    type(trouble_t) :: cut               !! why the last that was rejected was
    type(trouble_t) :: impact            !! why an impact of the accepted one was left to springs
    type(trouble_t) :: as_one            !! why its last impacts were made as one
    logical :: left = .false.            !! the last one was, in a friction problem, as a signal asks to stop
    integer :: solves = 0                !! of all
    integer, allocatable :: judged(:, :) !! (4, n) contacts open, sliding, locked, changing, at each judgement of all
    integer :: rejected = 0              !! how many were
    integer :: reason = 0                !! of `cut_reasons`, of the last one that has not settled
    integer :: cuts(size(cut_reasons)) = 0 !! how many were rejected for each reason
  end type outcome_t

  !> A try of a step.
  type :: try_t
    real(dp) :: dt = 0.0_dp              !! time
    real(dp) :: bound = huge(1.0_dp)     !! of an explicit one, time
    real(dp) :: pseudo = huge(1.0_dp)    !! size by which inertia resists a static one, where that is less than `dt`, time
    type(step_rule_t) :: rule            !! with the operator of the iteration
    logical, allocatable :: green(:)     !! of the elements that can move: Green strain, else small; where the step chooses
    real(dp), allocatable :: d(:)        !! (n_unknowns) displacement of the step
    real(dp), allocatable :: predicted(:) !! (n_unknowns) what that would be without contact
    logical, allocatable :: smooth(:)    !! (n_elements) they begin with their acceleration
    type(impact_t) :: impact             !! at its end
    type(contact_try_t) :: contacts
    type(element_group_t) :: group               !! that settles now, or did last
    type(iteration_t) :: iteration       !! of that
    type(outcome_t) :: outcome           !! of it and of those before it
    integer :: remedy = remedy_shorter   !! where it has not settled
    integer :: most_solves = huge(1)     !! of all tries, after which this one is given up
    real(dp) :: shorter = 1.0_dp         !! fraction of the step that the next one takes then
    real(dp) :: travel = 0.0_dp          !! largest of a vertex, where a step may go only so far, length
    real(dp) :: jump = 0.0_dp            !! largest way of a vertex beyond what was looked at, in any try, over the most
    integer :: stiffened = 0             !! tries before it that were rejected because contacts overlapped too much
  end type try_t

contains

  !> The outcome of a try that begins; what all tries took stays.
  pure subroutine begin_outcome(outcome)
    type(outcome_t), intent(inout) :: outcome

    outcome%settled = .true.
    outcome%iterations = 0
    if (allocated(outcome%trouble%what)) deallocate (outcome%trouble%what)
    if (.not. allocated(outcome%judged)) allocate (outcome%judged(4, 0))
  end subroutine begin_outcome

  !> Rejects a try for the trouble in an element.
  pure subroutine reject(outcome, reason, what, advice, element, position)
    type(outcome_t), intent(inout) :: outcome
    integer, intent(in) :: reason                !! of `cut_reasons`
    character(len=*), intent(in) :: what, advice
    integer, intent(in) :: element               !! 0: none
    real(dp), intent(in), optional :: position(2) !! length

    outcome%settled = .false.
    outcome%reason = reason
    outcome%trouble = new_trouble(what, advice, element, position)
  end subroutine reject

end module scree_step_try
