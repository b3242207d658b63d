!> Work in an accepted step, and the force of moving supports.
module scree_step_work
  use scree_contact_forces, only: work_of_contacts
  use scree_effects, only: supports_move, supports_move_exactly
  use scree_energy, only: find_work_of_step
  use scree_fixed_point, only: way_of_fastest
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_state, only: state_t
  use scree_step_try, only: try_t
  implicit none
  private
  public :: find_support_force, find_work

contains

  !> Work that loads, the ground and supports do in an accepted try, and the part of moving supports. Exact supports bear what
  !> contacts press their bodies with.
  pure subroutine find_work(model, cache, state, try, work, supports)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state        !! at the beginning of the step
    type(try_t), intent(in) :: try
    real(dp), intent(out) :: work, supports   !! force length per unit thickness
    type(state_t) :: began                    ! with what an impact pushes
    real(dp) :: contacts                      ! work of them on bodies that supports move

    if (allocated(try%impact%push) .and. supports_move(model)) then
      began = state
      began%velocity = began%velocity + try%impact%push
      call find_work_of_step(model, cache, began, try%rule, try%d, work, supports)
      work = work + try%impact%work
    else
      call find_work_of_step(model, cache, state, try%rule, try%d, work, supports)
    end if
    if (.not. supports_move_exactly(model)) return
    contacts = work_of_contacts(model, try%contacts, try%d)
    work = work - contacts
    supports = supports - contacts
  end subroutine find_work

  !> Puts the force of moving supports along their motion into the state, where they move in the step.
  pure subroutine find_support_force(model, dt, work, state)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: dt                !! size of the step, time
    real(dp), intent(in) :: work              !! of the supports in it, force length per unit thickness
    type(state_t), intent(inout) :: state     !! at its beginning
    real(dp) :: way

    if (.not. supports_move(model)) return
    way = way_of_fastest(model%effects%fixed_point, state%time, state%time + dt)
    if (.not. way > 0) return
    state%pace%support_force = work/way
    state%pace%most_force = max(state%pace%most_force, state%pace%support_force)
  end subroutine find_support_force

end module scree_step_work
