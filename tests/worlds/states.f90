!> States compared to the bit.
module states
  use, intrinsic :: iso_fortran_env, only: int64
  use scree_contacts, only: contact_memory_t, contact_t
  use scree_factored, only: factored_t
  use scree_kinds, only: dp
  use scree_state, only: books_t, deviation_t, settling_t, state_t
  implicit none
  private
  public :: first_difference

contains

  !> Name of the first part of two states that differs by a bit, '' where none does.
  function first_difference(a, b) result(name)
    type(state_t), intent(in) :: a, b
    character(len=:), allocatable :: name
    integer :: i

    name = ''
    if (a%step /= b%step .or. .not. same([a%time], [b%time])) name = 'time'
    if (a%stage%number /= b%stage%number .or. a%stage%steps /= b%stage%steps .or. &
        .not. same([a%stage%begins], [b%stage%begins])) name = 'stage'
    if (a%pace%easy /= b%pace%easy .or. a%pace%frames /= b%pace%frames .or. .not. &
        same([a%pace%size, a%pace%last, a%pace%small, a%pace%bound, a%pace%pseudo, &
              a%pace%support_force, a%pace%most_force], &
             [b%pace%size, b%pace%last, b%pace%small, b%pace%bound, b%pace%pseudo, &
              b%pace%support_force, b%pace%most_force])) &
      name = 'pace'
    if (.not. same([a%vertex], [b%vertex])) name = 'vertex'
    if (.not. same([a%point], [b%point])) name = 'point'
    if (.not. same([a%home], [b%home])) name = 'home'
    if (allocated(a%reference) .neqv. allocated(b%reference)) name = 'whether displacements count from the start'
    if (allocated(a%reference) .and. allocated(b%reference)) then
      if (.not. same([a%reference%vertex, a%reference%point], [b%reference%vertex, b%reference%point])) name = 'reference'
    end if
    if (.not. same([a%cover], [b%cover])) name = 'cover'
    if (.not. same(a%velocity, b%velocity)) name = 'velocity'
    if (.not. same(a%acceleration, b%acceleration)) name = 'acceleration'
    if (.not. same([a%stress], [b%stress])) name = 'stress'
    if (.not. same([a%deformation], [b%deformation])) name = 'deformation'
    if (.not. same(a%rotation, b%rotation)) name = 'rotation'
    if (allocated(a%static_force) .neqv. allocated(b%static_force)) name = 'whether absorbing edges bear static forces'
    if (allocated(a%static_force) .and. allocated(b%static_force)) then
      if (.not. same([a%static_force], [b%static_force])) name = 'static forces'
    end if
    if (allocated(a%tied) .and. allocated(b%tied)) then
      if (.not. same(a%tied, b%tied)) name = 'tied'
    end if
    if (any(a%green .neqv. b%green)) name = 'strain'
    if (allocated(a%bolts) .neqv. allocated(b%bolts)) name = 'whether there are bolts'
    if (allocated(a%bolts) .and. allocated(b%bolts)) then
      if (.not. (same(a%bolts%rest, b%bolts%rest) .and. same(a%bolts%across, b%bolts%across) &
             .and. same_whole(a%bolts%state, b%bolts%state))) name = 'bolts'
    end if
    if (allocated(a%cracks) .neqv. allocated(b%cracks)) name = 'whether cracks have grown'
    if (allocated(a%cracks) .and. allocated(b%cracks)) then
      if (.not. (same([a%cracks%piece, a%cracks%time], [b%cracks%piece, b%cracks%time]) &
                 .and. same_whole([a%cracks%joint, a%cracks%tip], [b%cracks%joint, b%cracks%tip]))) name = 'cracks'
    end if
    if (allocated(a%hold) .neqv. allocated(b%hold)) name = 'whether new faces hold each other'
    if (allocated(a%hold) .and. allocated(b%hold)) then
      if (.not. (same([a%hold%force], [b%hold%force]) .and. same_whole([a%hold%piece, a%hold%tip], [b%hold%piece, b%hold%tip]) &
                 .and. same([a%hold%duration, a%hold%share, a%hold%next], [b%hold%duration, b%hold%share, b%hold%next]))) &
        name = 'what holds new faces'
    end if
    if (allocated(a%departed) .neqv. allocated(b%departed)) name = 'whether blocks have left'
    if (allocated(a%departed) .and. allocated(b%departed)) then
      if (.not. same_whole(a%departed, b%departed)) name = 'blocks that have left'
    end if
    if (.not. same(numbers_of(a%books), numbers_of(b%books))) name = 'books'
    if (.not. same_whole([a%pair], [b%pair])) name = 'pairs'
    if (size(a%factored) /= size(b%factored)) name = 'number of islands'
    do i = 1, size(a%factored)
      if (len(name) == 0) name = difference_of_factored(a%factored(i), b%factored(i))
    end do
    if (len(name) == 0) name = difference_of_contacts(a%contacts, b%contacts)
    if (len(name) > 0) return
    if (allocated(a%sleep) .neqv. allocated(b%sleep)) name = 'whether bodies sleep'
    if (allocated(a%sleep) .and. allocated(b%sleep)) then
      if (.not. same_whole([a%sleep%island, a%sleep%quiet, a%sleep%inside, a%sleep%count], &
                           [b%sleep%island, b%sleep%quiet, b%sleep%inside, b%sleep%count])) name = 'sleep'
      if (.not. same([a%sleep%since, a%sleep%penetration], [b%sleep%since, b%sleep%penetration])) name = 'times of sleep'
      if (len(name) == 0) name = difference_of_contacts(contact_memory_t(a%sleep%contact, a%sleep%inside), &
                                                        contact_memory_t(b%sleep%contact, b%sleep%inside))
    end if
    if (allocated(a%settling) .neqv. allocated(b%settling)) name = 'whether the run settles'
    if (allocated(a%settling) .and. allocated(b%settling)) then
      if (.not. same(numbers_of_settling(a%settling), numbers_of_settling(b%settling))) name = 'settling'
    end if
    if (allocated(a%deviation) .neqv. allocated(b%deviation)) name = 'whether the error is estimated'
    if (allocated(a%deviation) .and. allocated(b%deviation)) then
      if (.not. same(numbers_of_deviation(a%deviation), numbers_of_deviation(b%deviation))) name = 'deviation'
      if (any(a%deviation%smooth .neqv. b%deviation%smooth)) name = 'smooth steps'
    end if
  end function first_difference

  !> How a static run comes to equilibrium, as numbers.
  pure function numbers_of_settling(own) result(numbers)
    type(settling_t), intent(in) :: own
    real(dp), allocatable :: numbers(:)

    numbers = [own%unbalanced, merge(1.0_dp, 0.0_dp, own%steady), own%grows, real(own%moving, dp), own%share, own%way, &
               own%share_before, own%force_before]
  end function numbers_of_settling

  !> How far a run is off, as numbers.
  pure function numbers_of_deviation(own) result(numbers)
    type(deviation_t), intent(in) :: own
    real(dp), allocatable :: numbers(:)

    numbers = [own%from, own%place, own%motion, own%acceleration, own%mean_velocity, own%mean_acceleration, own%added, &
               own%path_gain, own%path_square, own%mean_square, own%added_size, own%added_over]
    numbers = [numbers, own%growth, own%impact, own%late, own%way, own%step, own%excess, real(own%rough, dp), &
               merge(1.0_dp, 0.0_dp, own%lost)]
  end function numbers_of_deviation

  !> Likewise of a matrix whose factor is kept.
  function difference_of_factored(a, b) result(name)
    type(factored_t), intent(in) :: a, b
    character(len=:), allocatable :: name

    name = ''
    if (a%spent /= b%spent .or. .not. same_whole(a%unknown, b%unknown)) name = 'island'
    if (allocated(a%value) .neqv. allocated(b%value)) name = 'whether a factor is kept'
    if (.not. (allocated(a%value) .and. allocated(b%value))) return
    if (.not. same_whole([a%first, a%row], [b%first, b%row])) name = 'pattern of the factored matrix'
    if (.not. same(a%value, b%value)) name = 'factored matrix'
  end function difference_of_factored

  !> Likewise of what contacts remember.
  function difference_of_contacts(a, b) result(name)
    type(contact_memory_t), intent(in) :: a, b
    character(len=:), allocatable :: name
    integer :: i

    name = ''
    if (.not. same([a%stiffness, a%penetration, a%pressed, a%gap], [b%stiffness, b%penetration, b%pressed, b%gap])) &
      name = 'contacts as a whole'
    if (allocated(a%extra_reach)) then ! a scene without contact has none
      if (.not. same([a%extra_reach, a%extra_turn], [b%extra_reach, b%extra_turn])) name = 'what the search adds'
    end if
    if (any(a%count /= b%count)) name = 'count of contacts'
    if (any(a%broken /= b%broken)) name = 'bonds that broke'
    if (allocated(a%contact) .neqv. allocated(b%contact)) name = 'contacts'
    if (.not. (allocated(a%contact) .and. allocated(b%contact))) return
    if (.not. same_whole([a%inside], [b%inside])) name = 'inside'
    if (size(a%contact) /= size(b%contact)) then
      name = 'number of contacts'
      return
    end if
    do i = 1, size(a%contact)
      if (.not. same_whole(whole_numbers_of(a%contact(i)), whole_numbers_of(b%contact(i)))) name = 'states of contacts'
      if (.not. same(numbers_of_contact(a%contact(i)), numbers_of_contact(b%contact(i)))) name = 'forces of contacts'
    end do
  end function difference_of_contacts

  !> Whole and logical numbers of a contact, of the entrances that it has.
  pure function whole_numbers_of(contact) result(numbers)
    type(contact_t), intent(in) :: contact
    integer, allocatable :: numbers(:)

    associate (entrance => contact%entrance(:contact%n_entrances))
      numbers = [contact%n_entrances, contact%active, contact%covered_line, contact%end, contact%strained, &
          merge(1, 0, contact%stands_for_both), &
                 entrance%vertex, entrance%edge, entrance%joint, entrance%pair, entrance%state, &
                 merge(1, 0, entrance%memory%bonded), merge(1, 0, entrance%has_joint_stiffness)]
    end associate
  end function whole_numbers_of

  !> Real numbers of a contact, of the entrances that it has.
  pure function numbers_of_contact(contact) result(numbers)
    type(contact_t), intent(in) :: contact
    real(dp), allocatable :: numbers(:)

    associate (entrance => contact%entrance(:contact%n_entrances))
      numbers = [contact%force, contact%pressed, contact%slipped, contact%overlap, contact%energy, contact%inherits, &
                 entrance%direction, entrance%anchor, entrance%rest, &
                 entrance%multiplier(1), entrance%multiplier(2), entrance%memory%length, entrance%memory%pressing, &
                 entrance%memory%slid, entrance%memory%wear, entrance%memory%displaced, &
                 entrance%memory%farthest, entrance%memory%dilated, &
                 entrance%held, entrance%lagged_friction, entrance%stiffness(1), entrance%stiffness(2)]
    end associate
  end function numbers_of_contact

  !> Numbers of the books.
  pure function numbers_of(books) result(numbers)
    type(books_t), intent(in) :: books
    real(dp), allocatable :: numbers(:)

    numbers = [books%kinetic, books%strain, books%gravity, books%fixed_springs, books%contact_springs, &
               books%sleeping_springs, books%bolts, books%asleep, books%fracture, books%integrator, &
               books%at_start, books%staged, books%work, books%damping, books%friction, books%yield, books%momentum]
  end function numbers_of

  !> Whether two lists of numbers are the same to the bit.
  pure logical function same(a, b)
    real(dp), intent(in) :: a(:), b(:)

    same = size(a) == size(b)
    if (same) same = all(transfer(a, [0_int64]) == transfer(b, [0_int64]))
  end function same

  !> Whether two lists of whole numbers are the same.
  pure logical function same_whole(a, b)
    integer, intent(in) :: a(:), b(:)

    same_whole = size(a) == size(b)
    if (same_whole) same_whole = all(a == b)
  end function same_whole

end module states
