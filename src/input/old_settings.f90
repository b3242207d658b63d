!> Settings that have another name now, so that a deck of yesterday is told today's.
module scree_old_settings
  implicit none
  private
  public :: name_now

  !> A former setting, with a choice or any value, and the setting that replaces it.
  type :: old_setting_t
    character(len=16) :: name
    character(len=11) :: value
    character(len=27) :: now
  end type old_setting_t

  type(old_setting_t), parameter :: old_settings(*) = [ &
    old_setting_t('contact.energy', 'dissipating', "contact.rules='coulomb'"), &
    old_setting_t('contact.energy', 'conserving', "contact.rules='conserving'"), &
    old_setting_t('contact.friction', 'current', "contact.rules='coulomb'"), &
    old_setting_t('contact.friction', 'lagging', "contact.rules='shi'"), &
    old_setting_t('contact.closing', '', "part of contact.rules='shi'"), &
    old_setting_t('contact.opening', '', "part of contact.rules='shi'")]

contains

  !> "OLD is now NEW" for a setting that has another name now, '' for any other.
  pure function name_now(name, value) result(text)
    character(len=*), intent(in) :: name  !! group.name
    character(len=*), intent(in) :: value
    character(len=:), allocatable :: text
    integer :: i

    text = ''
    do i = 1, size(old_settings)
      if (old_settings(i)%name /= name) cycle
      if (old_settings(i)%value == '') text = name//' is now '//trim(old_settings(i)%now)
      if (old_settings(i)%value == value) text = name//"='"//value//"' is now "//trim(old_settings(i)%now)
    end do
  end function name_now

end module scree_old_settings
