!> A try of a step. It lives in `advance` and dies there: what a rejected try found is in here alone.
module scree_step_try
  use scree_contact_try, only: contact_try_t
  use scree_element_term, only: step_rule_t
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_trouble, only: new_trouble, trouble_t
  implicit none
  private
  public :: reject, try_t

  !> What a rejected try asks for: a shorter step, contacts looked for farther away, or stiffer contacts.
  integer, parameter, public :: remedy_shorter = 1, remedy_wider = 2, remedy_stiffer = 3

  !> A try of a step, and what the tries before it came to.
  type :: try_t
    real(dp) :: dt = 0.0_dp              !! time
    type(step_rule_t) :: rule
    real(dp), allocatable :: d(:)        !! (n_unknowns) displacement of the step
    real(dp), allocatable :: motion(:)   !! (n_unknowns) displacement that the rates at the end follow from
    type(contact_try_t) :: contacts
    logical :: settled = .false.
    integer :: iterations = 0            !! of the slowest group
    integer :: remedy = remedy_shorter   !! where it has not settled
    real(dp) :: shorter = 1.0_dp         !! share of the step that the next one takes then
    type(trouble_t) :: trouble           !! why it has not
    real(dp) :: travel = 0.0_dp          !! largest of a vertex, where a step may go only so far, length
    integer :: rejected = 0              !! tries before it
    integer :: stiffened = 0             !! of these because contacts overlapped too much
    integer :: solves = 0                !! of all tries
    integer, allocatable :: judged(:, :) !! (4, n) contacts open, sliding, locked, changing, at each judgement of all tries
  end type try_t

contains

  !> Rejects a try for the trouble in an element.
  pure subroutine reject(try, what, advice, element, position)
    type(try_t), intent(inout) :: try
    character(len=*), intent(in) :: what, advice
    integer, intent(in) :: element               !! 0: none
    real(dp), intent(in), optional :: position(2) !! length

    try%settled = .false.
    try%trouble = new_trouble(what, advice, element, position)
  end subroutine reject

end module scree_step_try
