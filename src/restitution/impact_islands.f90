!> Impacts of a step that have no body in common.
module scree_impact_islands
  use scree_bearings, only: bearing_t
  use scree_kinds, only: dp
  implicit none
  private
  public :: find_islands

  !> An impact reaches a contact if it strikes the contact by more than this ratio to the largest impulse of the closing contacts.
  real(dp), parameter :: felt = 1e-2_dp

contains

  !> Tells the impacts apart: contacts of one island have bodies in common that are free to move. 0: no impact reaches it.
  !>
  !> An impact spreads from closing contacts over every contact that it strikes by more than `felt` times the largest impulse of the
  !> closing contacts there. All contacts of the bodies that it reaches belong to it, because it must not bring these bodies closer.
  pure subroutine find_islands(held, bearing)
    logical, intent(in) :: held(:)               !! (n_blocks)
    type(bearing_t), intent(inout) :: bearing(:)
    real(dp) :: strongest(size(held))            !! impulse of what closes in the island of a label
    integer :: label(size(held)), i
    logical :: grows

    label = 0
    strongest = 0.0_dp
    do i = 1, size(bearing)
      associate (own => bearing(i))
        if (own%reached) call join(held, own%block, merge(own%struck, 0.0_dp, own%closes), label, strongest)
      end associate
    end do
    grows = .true.
    do while (grows)
      grows = .false.
      do i = 1, size(bearing)
        associate (own => bearing(i))
          if (own%reached .or. .not. own%struck > 0) cycle
          if (own%struck < felt*strength(held, own%block, label, strongest)) cycle
          if (.not. strength(held, own%block, label, strongest) > 0) cycle
          own%reached = .true.
          call join(held, own%block, 0.0_dp, label, strongest)
          grows = .true.
        end associate
      end do
    end do
    bearing%island = [(merge(1, 0, strength(held, bearing(i)%block, label, strongest) > 0), i=1, size(bearing))]
    do i = 1, size(bearing)
      if (bearing(i)%island > 0) call join(held, bearing(i)%block, 0.0_dp, label, strongest)
    end do
    do i = 1, size(bearing)
      if (bearing(i)%island > 0) bearing(i)%island = maxval(pack(label(bearing(i)%block), .not. held(bearing(i)%block)))
    end do
  end subroutine find_islands

  !> Largest impulse of what closes in the islands of two blocks; 0 where there is none.
  pure real(dp) function strength(held, block, label, strongest)
    logical, intent(in) :: held(:)               !! (n_blocks)
    integer, intent(in) :: block(2), label(:)    !! (n_blocks)
    real(dp), intent(in) :: strongest(:)         !! (n_blocks)
    integer :: side

    strength = 0.0_dp
    do side = 1, 2
      if (held(block(side)) .or. label(block(side)) == 0) cycle
      strength = max(strength, strongest(label(block(side))))
    end do
  end function strength

  !> Makes one island of those of two blocks, between which this impulse acts.
  pure subroutine join(held, block, impulse, label, strongest)
    logical, intent(in) :: held(:)               !! (n_blocks)
    integer, intent(in) :: block(2)
    real(dp), intent(in) :: impulse
    integer, intent(inout) :: label(:)           !! (n_blocks)
    real(dp), intent(inout) :: strongest(:)      !! (n_blocks)
    integer :: gone, side, whole

    whole = 0
    do side = 1, 2
      if (held(block(side))) cycle
      if (label(block(side)) == 0) label(block(side)) = block(side)
      gone = label(block(side))
      if (whole == 0) whole = gone
      strongest(whole) = max(strongest(whole), strongest(gone), impulse)
      where (label == gone) label = whole
    end do
  end subroutine join

end module scree_impact_islands
