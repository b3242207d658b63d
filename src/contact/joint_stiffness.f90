!> How stiff a contact is: joint stiffness (force/length^3) times the length of the joint that the contact stands for.
!>
!> Edges that lie on each other have a length in common, and two ends of it, each a vertex at an edge: each of these contacts stands
!> for half of that length. So the lengths of all contacts of a joint add up to its own, however many they are.
module scree_joint_stiffness
  use scree_contact_geometry, only: frame_of_edge
  use scree_contacts, only: contact_law_t, contact_t, entrance_t, outlines_t, parallel
  use scree_kinds, only: dp
  implicit none
  private
  public :: bonded_entrance, bonded_length, is_hard, mean_of_bonds, measure_contact, stiffen_contact, take_stiffness

  !> Of an edge: a vertex so near to its end is at it, and faces the edge beyond, too.
  real(dp), parameter :: at_end = 1e-3_dp
  !> Of the shorter edge: a corner that meets an edge beside its end, or another corner, stands for so much.
  real(dp), parameter :: least = 0.05_dp
  !> Of the mean of bonds: one is as stiff as if it stood for so much. Softer ones take steps more solutions.
  real(dp), parameter :: least_bond = 0.1_dp
  !> How fast an edge of a corner counts less as it turns from facing the contact's edge, while the other faces it better.
  integer, parameter :: turned_away = 8

contains

  !> Gives a contact its stiffness across and along: the stiffer one of its lines, by their joints, of which those without a
  !> stiffness have that of contact; of a bond, that of its line, by the length that it stands for.
  pure subroutine stiffen_contact(outlines, position, law, bonds, contact)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)     !! (2, n_vertices), length
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: bonds              !! that a bond with the stiffness of contact stands for; 0: each has that; length
    type(contact_t), intent(inout) :: contact
    real(dp) :: own(2), stiffness(2)
    logical :: gives_way
    integer :: bond, k

    bond = bonded_entrance(contact)
    stiffness = 0.0_dp
    gives_way = .false.
    do k = 1, contact%n_entrances
      if (bond > 0 .and. k /= bond) cycle
      associate (entrance => contact%entrance(k))
        own = [law%normal_stiffness, law%shear_stiffness]
        if (has_its_own(law, entrance)) then
          own = law%joint_stiffness(:, entrance%joint)*length_of_contact(outlines, position, entrance)
        else if (bond > 0 .and. bonds > 0) then
          own = max(entrance%length/bonds, least_bond)*own
        end if
        if (own(1) > stiffness(1)) then
          stiffness = own
          gives_way = has_its_own(law, entrance)
        end if
      end associate
    end do
    call set_stiffness(stiffness, gives_way, contact)
  end subroutine stiffen_contact

  !> Gives both entrances of a contact the stiffness of one, of this contact or of one before.
  pure subroutine take_stiffness(from, contact)
    type(entrance_t), intent(in) :: from
    type(contact_t), intent(inout) :: contact

    call set_stiffness(from%stiffness, from%gives_way, contact)
  end subroutine take_stiffness

  !> Gives both entrances of a contact a stiffness.
  pure subroutine set_stiffness(stiffness, gives_way, contact)
    real(dp), intent(in) :: stiffness(2)       !! across and along, force/length
    logical, intent(in) :: gives_way           !! it is that of a joint of its own
    type(contact_t), intent(inout) :: contact
    integer :: k

    do k = 1, 2
      contact%entrance(k)%stiffness = stiffness
      contact%entrance(k)%gives_way = gives_way
    end do
  end subroutine set_stiffness

  !> The entrance by which a contact is bonded; 0: none.
  pure integer function bonded_entrance(contact) result(k)
    type(contact_t), intent(in) :: contact

    k = contact%active
    if (.not. contact%entrance(k)%bonded) k = 3 - k
    if (.not. contact%entrance(k)%bonded) k = 0
  end function bonded_entrance

  !> Whether the joint of an entrance has a stiffness of its own.
  pure logical function has_its_own(law, entrance)
    type(contact_law_t), intent(in) :: law
    type(entrance_t), intent(in) :: entrance

    has_its_own = allocated(law%joint_stiffness)
    if (has_its_own) has_its_own = law%joint_stiffness(1, entrance%joint) > 0
  end function has_its_own

  !> Whether multipliers hold a contact: it does not have the stiffness of a joint with its own, which is to give way by that.
  pure logical function is_hard(law, entrance)
    type(contact_law_t), intent(in) :: law
    type(entrance_t), intent(in) :: entrance

    is_hard = law%penetration < huge(law%penetration) .and. .not. entrance%gives_way
  end function is_hard

  !> Length that a bond without a stiffness of its own stands for on the mean; 0 where there is none.
  pure real(dp) function mean_of_bonds(law, contact) result(length)
    type(contact_law_t), intent(in) :: law
    type(contact_t), intent(in) :: contact(:)
    integer :: i, k, n

    length = 0.0_dp
    n = 0
    do i = 1, size(contact)
      k = bonded_entrance(contact(i))
      if (k == 0) cycle
      if (has_its_own(law, contact(i)%entrance(k))) cycle
      length = length + contact(i)%entrance(k)%length
      n = n + 1
    end do
    if (n > 0) length = length/n
  end function mean_of_bonds

  !> Gives the entrances of a contact whose friction follows their stress the length that they stand for. Bonds keep theirs.
  pure subroutine measure_contact(outlines, position, law, contact)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)     !! (2, n_vertices), length
    type(contact_law_t), intent(in) :: law
    type(contact_t), intent(inout) :: contact
    integer :: k

    do k = 1, contact%n_entrances
      associate (entrance => contact%entrance(k))
        if (.not. entrance%bonded .and. any(law%roughness(:, entrance%joint) > 0)) &
          entrance%length = length_of_contact(outlines, position, entrance)
      end associate
    end do
  end subroutine measure_contact

  !> Length of the joint that a contact stands for: half of what the edges at its vertex have in common with its edge.
  !>
  !> Where no edge at the vertex is parallel to that one, a corner, it is half of what their shadows on it have in common with it,
  !> and that edge counts that faces it better.
  pure real(dp) function length_of_contact(outlines, position, entrance) result(length)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)     !! (2, n_vertices), length
    type(entrance_t), intent(in) :: entrance
    real(dp) :: common(2), facing(2), shorter

    call face(outlines, position, entrance, common, facing, shorter)
    if (any(facing >= cos(parallel))) then
      length = 0.5_dp*sum(common, facing >= cos(parallel))
    else
      length = 0.5_dp*sum(common*(facing/maxval(facing))**turned_away, facing > 0)
    end if
    length = max(length, least*shorter)
  end function length_of_contact

  !> Length of a bonded joint that a contact stands for: 0 where no edge at its vertex is parallel to its own.
  pure real(dp) function bonded_length(outlines, position, entrance) result(length)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)     !! (2, n_vertices), length
    type(entrance_t), intent(in) :: entrance
    real(dp) :: common(2), facing(2), shorter

    call face(outlines, position, entrance, common, facing, shorter)
    length = 0.5_dp*sum(common, facing >= cos(parallel))
  end function bonded_length

  !> What each of the two edges at the vertex of an entrance has in common with its edge, seen across it.
  pure subroutine face(outlines, position, entrance, common, facing, shorter)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)     !! (2, n_vertices), length
    type(entrance_t), intent(in) :: entrance
    real(dp), intent(out) :: common(2)         !! of the edge that begins at the vertex and the one that ends there, length
    real(dp), intent(out) :: facing(2)         !! cosine of the angle by which each is turned from facing the edge
    real(dp), intent(out) :: shorter           !! of the edge and the longer one at the vertex, length
    real(dp) :: t(2), normal(2), own(2), length, longer, at, ends(2), from, to
    integer :: edge, i

    call frame_of_edge(position(:, outlines%start(entrance%edge)), position(:, outlines%finish(entrance%edge)), t, normal, length)
    at = dot_product(t, position(:, outlines%start(entrance%vertex)) - position(:, outlines%start(entrance%edge)))
    from = 0.0_dp
    to = length
    if (at < at_end*length) from = -going_on(outlines%previous(entrance%edge))
    if (at > (1 - at_end)*length) to = length + going_on(outlines%next(entrance%edge))
    longer = 0.0_dp
    do i = 1, 2
      edge = merge(entrance%vertex, outlines%previous(entrance%vertex), i == 1)
      own = position(:, outlines%finish(edge)) - position(:, outlines%start(edge))
      longer = max(longer, norm2(own))
      facing(i) = -dot_product(own, t)/norm2(own)
      at = dot_product(t, position(:, outlines%start(edge)) - position(:, outlines%start(entrance%edge)))
      ends = [at + dot_product(t, own), at]
      common(i) = max(0.0_dp, min(to, ends(2)) - max(from, ends(1)))
    end do
    shorter = min(length, longer)

  contains

    !> Length of an edge beside that of the entrance, where it goes on in its direction, else 0.
    pure real(dp) function going_on(beside)
      integer, intent(in) :: beside
      real(dp) :: way(2)

      way = position(:, outlines%finish(beside)) - position(:, outlines%start(beside))
      going_on = merge(norm2(way), 0.0_dp, dot_product(way, t) >= cos(parallel)*norm2(way))
    end function going_on

  end subroutine face

end module scree_joint_stiffness
