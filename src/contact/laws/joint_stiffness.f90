!> How stiff a contact is: joint stiffness (force/length^3) times the length of the joint that the contact stands for.
!>
!> Edges that lie on each other have a length in common, and two ends of it, each a vertex at an edge: each of these contacts stands
!> for half of that length. So the lengths of all contacts of a joint add up to its own, however many they are. As the faces slide
!> over each other the lengths follow: what a contact loses at the end of a face another wins at the beginning of the next.
module scree_joint_stiffness
  use scree_contact_geometry, only: frame_of_edge
  use scree_contacts, only: contact_law_t, contact_t, entrance_t, outlines_t, parallel
  use scree_joint_roughness, only: follows_stress
  use scree_joint_rules, only: energy_beside_spring, weaker_joint
  use scree_kinds, only: dp
  use scree_sets, only: root_of, unite
  implicit none
  private
  public :: bonded_entrance, change_stiffness, common_lengths, facing_edges, follow_slip, is_hard, &
            keep_stiffness, mean_of_bonds, measure_bond, measure_contact, stiffen_contact, take_stiffness

  !> Of the edges about: a vertex so near to the end of an edge is at it, and faces the edge beyond, too.
  real(dp), parameter, public :: at_end = 1e-3_dp
  !> Of the shorter edge: a corner that meets an edge beside its end, or another corner, stands for so much.
  real(dp), parameter :: least = 0.05_dp
  !> The same of edges that lie on each other from the start of the run, or of a stage that changes their stiffness. What comes
  !> later would sink as deep as its beginning is short, and win energy as it slides on.
  real(dp), parameter :: least_from_start = 1e-3_dp
  !> Of the mean of bonds: one is as stiff as if it stood for so much. Softer ones take steps more solutions.
  real(dp), parameter :: least_bond = 0.01_dp
  !> In a step, times the length that it has: what a contact that bears alone wins beside what it slides.
  real(dp), parameter :: most_won = 1.1_dp
  !> How fast an edge of a corner counts less as it turns from facing the contact's edge, while the other faces it better.
  integer, parameter :: turned_away = 8

  !> What the two edges at the vertex of an entrance, that which begins there and that which ends there, have to do with its edge.
  type :: vertex_edges_t
    logical :: flat(2)   !! they lie on it
    real(dp) :: common(2) !! in common with it, seen across it, length; of a corner, none of whose edges lies on it, the sides
    real(dp) :: facing(2) !! cosine of the angle by which each is turned from facing it
    real(dp) :: shorter  !! of it and the longer one at the vertex, length
  end type vertex_edges_t

contains

  !> Gives a contact its stiffness across and along, which is that of its stiffest line. A line has the stiffness of its joint, or
  !> the stiffness of contact if the joint has none. A bonded contact has the stiffness of its bonded line, by the length of the
  !> bond.
  pure subroutine stiffen_contact(outlines, position, law, from_start, bonds, contact)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)     !! (2, n_vertices), length
    type(contact_law_t), intent(in) :: law
    logical, intent(in) :: from_start          !! of the run, or of a stage
    real(dp), intent(in) :: bonds              !! that a bond with the stiffness of contact stands for; 0: each has that; length
    type(contact_t), intent(inout) :: contact
    real(dp) :: own(2), stiffness(2)
    logical :: has_joint_stiffness
    integer :: bond, k

    bond = bonded_entrance(contact)
    stiffness = 0.0_dp
    has_joint_stiffness = .false.
    do k = 1, contact%n_entrances
      if (bond > 0 .and. k /= bond) cycle
      associate (entrance => contact%entrance(k))
        own = [law%normal_stiffness, law%shear_stiffness]
        if (has_its_own(law, entrance)) then
          own = stiffness_of(law, entrance%joint)*length_of_contact(outlines, position, contact%stands_for_both, from_start, &
              entrance)
        else if (bond > 0 .and. bonds > 0) then
          own = max(entrance%memory%length/bonds, least_bond)*own
        end if
        if (own(1) > stiffness(1)) then
          stiffness = own
          has_joint_stiffness = has_its_own(law, entrance)
        end if
      end associate
    end do
    call set_stiffness(stiffness, has_joint_stiffness, contact)
  end subroutine stiffen_contact

  !> Gives both entrances of a contact the stiffness of one of a contact before.
  pure subroutine take_stiffness(from, contact)
    type(entrance_t), intent(in) :: from
    type(contact_t), intent(inout) :: contact

    call set_stiffness(from%stiffness, from%has_joint_stiffness, contact)
  end subroutine take_stiffness

  !> Gives both entrances of a contact a stiffness.
  pure subroutine set_stiffness(stiffness, has_joint_stiffness, contact)
    real(dp), intent(in) :: stiffness(2)       !! across and along, force/length
    logical, intent(in) :: has_joint_stiffness !! it is that of a joint of its own
    type(contact_t), intent(inout) :: contact
    integer :: k

    do k = 1, 2
      contact%entrance(k)%stiffness = stiffness
      contact%entrance(k)%has_joint_stiffness = has_joint_stiffness
    end do
  end subroutine set_stiffness

  !> The entrance by which a contact is bonded; 0: none.
  pure integer function bonded_entrance(contact) result(k)
    type(contact_t), intent(in) :: contact

    k = contact%active
    if (.not. contact%entrance(k)%memory%bonded) k = 3 - k
    if (.not. contact%entrance(k)%memory%bonded) k = 0
  end function bonded_entrance

  !> Whether the joint of an entrance has a stiffness of its own.
  pure logical function has_its_own(law, entrance)
    type(contact_law_t), intent(in) :: law
    type(entrance_t), intent(in) :: entrance

    has_its_own = law%joint(entrance%joint)%stiffness%normal > 0
  end function has_its_own

  !> Whether multipliers hold a contact: it does not have the stiffness of a joint with its own, which is to give way by that.
  pure logical function is_hard(law, entrance)
    type(contact_law_t), intent(in) :: law
    type(entrance_t), intent(in) :: entrance

    is_hard = law%penetration < huge(law%penetration) .and. .not. entrance%has_joint_stiffness
  end function is_hard

  !> Length that bonds without a stiffness of their own stand for on the mean, for each contact: of those that hold the same blocks
  !> together, through whatever can move; 0 where there is none.
  pure function mean_of_bonds(outlines, law, contact) result(length)
    type(outlines_t), intent(in) :: outlines
    type(contact_law_t), intent(in) :: law
    type(contact_t), intent(in) :: contact(:)
    real(dp) :: length(size(contact))
    real(dp) :: total(maxval(outlines%block))      ! of the bonds of a set of blocks, by its first, length
    integer :: n(size(total)), root(size(total)), set(size(contact)) ! set of the bond of a contact; 0: there is none
    integer :: bond, i

    root = [(i, i=1, size(root))]
    set = 0
    do i = 1, size(contact)
      bond = bonded_entrance(contact(i))
      if (bond == 0) cycle
      associate (entrance => contact(i)%entrance(bond), block => outlines%block, fixed => outlines%fixed)
        if (has_its_own(law, entrance)) cycle
        set(i) = block(merge(entrance%edge, entrance%vertex, fixed(entrance%vertex)))
        if (.not. (fixed(entrance%vertex) .or. fixed(entrance%edge))) call unite(root, block(entrance%vertex), block(entrance%edge))
      end associate
    end do
    total = 0.0_dp
    n = 0
    do i = 1, size(contact)
      if (set(i) == 0) cycle
      set(i) = root_of(root, set(i))
      total(set(i)) = total(set(i)) + contact(i)%entrance(bonded_entrance(contact(i)))%memory%length
      n(set(i)) = n(set(i)) + 1
    end do
    length = 0.0_dp
    do i = 1, size(contact)
      if (set(i) > 0) length(i) = total(set(i))/n(set(i))
    end do
  end function mean_of_bonds

  !> Gives both entrances of a contact the stiffness of the one that acts.
  pure subroutine keep_stiffness(contact)
    type(contact_t), intent(inout) :: contact
    type(entrance_t) :: active

    active = contact%entrance(contact%active)
    call set_stiffness(active%stiffness, active%has_joint_stiffness, contact)
  end subroutine keep_stiffness

  !> Gives a closed contact of a vertex over an edge, whose joint has a stiffness of its own and which slides, that of the length
  !> which it stands for now. Where others press on its faces, too, their sliding changes it by no more than both ends of a face
  !> slide, but for what it begins or ceases to stand for beside another vertex. One that bears alone, as a corner does whose faces
  !> turn off, loses none, and wins some at the energy that it has. Bonds keep theirs.
  pure subroutine follow_slip(outlines, position, law, slip, is_borne, was, contact)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)     !! (2, n_vertices), length
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: slip               !! in a step, length
    logical, intent(in) :: is_borne            !! others press on its faces
    type(contact_t), intent(in) :: was         !! the contact that it goes on from
    type(contact_t), intent(inout) :: contact
    type(vertex_edges_t) :: faces
    real(dp) :: length, now

    associate (entrance => contact%entrance(1))
      if (contact%n_entrances > 1 .or. entrance%memory%bonded) return
      if (.not. (entrance%has_joint_stiffness .and. has_its_own(law, entrance))) return
      faces = faces_at(outlines, position, contact%stands_for_both, .false., entrance)
      associate (own => stiffness_of(law, entrance%joint))
        now = entrance%stiffness(1)/own(1)
        if (is_borne .and. any(faces%flat)) then
          length = max(0.5_dp*sum(faces%common, faces%flat), min(now, least*faces%shorter))
          if (contact%stands_for_both .eqv. was%stands_for_both) length = min(max(now - 2*slip, length), now + 2*slip)
        else
          length = length_by_faces(faces, .false.)
          length = max(now, min(most_won*now + 2*slip, length))
          call keep_energy(outlines, position, sqrt(now/length), was%pressed, entrance)
        end if
        call set_stiffness(own*length, .true., contact)
      end associate
    end associate
  end subroutine follow_slip

  !> Sets the rest positions of the springs of an entrance so that their strain becomes `share` times the present one.
  pure subroutine keep_energy(outlines, position, share, pressed, entrance)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)     !! (2, n_vertices), length
    real(dp), intent(in) :: share
    real(dp), intent(in) :: pressed            !! overlap of the spring across, length
    type(entrance_t), intent(inout) :: entrance
    real(dp) :: t(2), normal(2), length, at

    associate (start => position(:, outlines%start(entrance%edge)))
      call frame_of_edge(start, position(:, outlines%finish(entrance%edge)), t, normal, length)
      at = dot_product(t, position(:, outlines%start(entrance%vertex)) - start)/length
    end associate
    entrance%rest = entrance%rest - (1 - share)*pressed
    entrance%anchor = at - share*(at - entrance%anchor)
  end subroutine keep_energy

  !> Gives a closed contact its stiffness under another law, as a stage may have. If the stiffness of its joints changes, it is
  !> computed anew. Otherwise it is scaled with the stiffness of contact. The energy of its springs changes with it.
  pure subroutine change_stiffness(outlines, position, before, law, bonds, contact)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)     !! (2, n_vertices), length
    type(contact_law_t), intent(in) :: before, law
    real(dp), intent(in) :: bonds              !! of `mean_of_bonds` by the other law, length
    type(contact_t), intent(inout) :: contact
    type(entrance_t) :: was
    real(dp) :: across, along
    logical :: another
    integer :: k

    associate (active => contact%entrance(contact%active))
      was = active
      another = .false.
      do k = 1, contact%n_entrances
        associate (joint => contact%entrance(k)%joint)
          another = another .or. any(abs(stiffness_of(law, joint) - stiffness_of(before, joint)) > 0)
        end associate
      end do
      if (another) then
        call stiffen_contact(outlines, position, law, .true., bonds, contact)
      else if (.not. active%has_joint_stiffness) then
        call set_stiffness(was%stiffness*[law%normal_stiffness/before%normal_stiffness, &
                                          law%shear_stiffness/before%shear_stiffness], .false., contact)
      end if
      if (.not. all(was%stiffness > 0)) return
      across = contact%energy
      across = across - energy_beside_spring(before, was, contact%pressed)
      along = 0.0_dp
      if (.not. is_hard(before, was)) along = min(across, 0.5_dp*contact%force(2)**2/was%stiffness(2))
      across = (across - along)*(active%stiffness(1)/was%stiffness(1))
      across = across + energy_beside_spring(law, active, contact%pressed)
      contact%energy = across + along*(active%stiffness(2)/was%stiffness(2))
    end associate
  end subroutine change_stiffness

  !> Stiffness of a joint across and along it; 0: it has none of its own, force/length^3.
  pure function stiffness_of(law, joint) result(stiffness)
    type(contact_law_t), intent(in) :: law
    integer, intent(in) :: joint
    real(dp) :: stiffness(2)

    stiffness = [law%joint(joint)%stiffness%normal, law%joint(joint)%stiffness%shear]
  end function stiffness_of

  !> Gives the entrances of a contact whose friction follows their stress the length that they stand for. Bonds keep theirs.
  pure subroutine measure_contact(outlines, position, law, contact)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)     !! (2, n_vertices), length
    type(contact_law_t), intent(in) :: law
    type(contact_t), intent(inout) :: contact
    integer :: k

    do k = 1, contact%n_entrances
      associate (entrance => contact%entrance(k))
        if (.not. entrance%memory%bonded .and. follows_stress(law%joint(entrance%joint)%roughness)) &
          entrance%memory%length = length_of_contact(outlines, position, contact%stands_for_both, .false., entrance)
      end associate
    end do
  end subroutine measure_contact

  !> Length of the joint that a contact stands for: half of what the edges at its vertex have in common with its edge.
  !>
  !> If no edge at the vertex is parallel to the edge of the entrance, the vertex is a corner. The length is then half of what the
  !> projections of the corner's sides have in common with the side of that edge. The side that faces the edge better counts more.
  pure real(dp) function length_of_contact(outlines, position, stands_for_both, from_start, entrance) result(length)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)     !! (2, n_vertices), length
    logical, intent(in) :: stands_for_both     !! the vertex at the nearer end of the edge has the contact, too, however far
    logical, intent(in) :: from_start          !! of the run, or of a stage
    type(entrance_t), intent(in) :: entrance

    length = length_by_faces(faces_at(outlines, position, stands_for_both, from_start, entrance), from_start)
  end function length_of_contact

  !> Likewise, where the faces are known.
  pure real(dp) function length_by_faces(faces, from_start) result(length)
    type(vertex_edges_t), intent(in) :: faces
    logical, intent(in) :: from_start          !! of the run, or of a stage

    associate (common => faces%common, facing => faces%facing)
      if (any(faces%flat)) then
        length = max(0.5_dp*sum(common, faces%flat), merge(least_from_start, least, from_start)*faces%shorter)
      else
        length = max(0.5_dp*sum(common*(facing/maxval(facing))**turned_away, facing > 0), least*faces%shorter)
      end if
    end associate
  end function length_by_faces

  !> Measures the bond of an entrance: the length of bonded joint that the entrance stands for, which is half of each piece of the
  !> joint at its vertex whose material has bonds. So the bonds of a joint add up to the bonded part of it, wherever that ends.
  !>
  !> The length is 0 if no such piece is there, or if edges only lie beside each other up to rounding, as at the crossing of two
  !> joints. The entrance gets the material of the bonded piece, unless one of its bonded pieces has its own material.
  pure subroutine measure_bond(outlines, position, law, bonds, stands_for_both, entrance)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)     !! (2, n_vertices), length
    type(contact_law_t), intent(in) :: law
    logical, intent(in) :: bonds(:)            !! (n_joints) the contacts of a joint are bonded
    logical, intent(in) :: stands_for_both     !! the vertex at the nearer end of the edge has the contact, too, however far
    type(entrance_t), intent(inout) :: entrance
    type(vertex_edges_t) :: faces
    real(dp) :: bonded(2)                      ! of each piece, length
    integer :: face(2), facing(2), k, piece(2)

    face = [entrance%vertex, outlines%previous(entrance%vertex)]
    facing = facing_edges(outlines, position, stands_for_both, entrance)
    piece = [(weaker_joint(law, outlines%joint(face(k)), outlines%joint(facing(k))), k=1, 2)]
    bonded = merge(common_lengths(outlines, position, stands_for_both, entrance), 0.0_dp, bonds(piece))
    faces = faces_at(outlines, position, stands_for_both, .true., entrance)
    entrance%memory%length = 0.5_dp*sum(bonded)
    if (entrance%memory%length < at_end*faces%shorter) entrance%memory%length = 0.0_dp
    entrance%memory%bonded = entrance%memory%length > 0
    if (entrance%memory%bonded .and. .not. any(piece == entrance%joint .and. bonded > 0)) entrance%joint = piece(maxloc(bonded, 1))
  end subroutine measure_bond

  !> Edges that the edge which begins at the vertex of an entrance, and the edge which ends there, face. A contact that stands for
  !> two vertices is between all four edges there, which may bend; another one is at its own edge alone.
  pure function facing_edges(outlines, position, stands_for_both, entrance) result(facing)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)     !! (2, n_vertices), length
    logical, intent(in) :: stands_for_both     !! the vertex at the nearer end of the edge has the contact, too
    type(entrance_t), intent(in) :: entrance
    integer :: facing(2), other

    facing = entrance%edge
    if (.not. stands_for_both) return
    associate (at => position(:, outlines%start(entrance%vertex)), edge => entrance%edge)
      other = merge(edge, outlines%next(edge), norm2(at - position(:, outlines%start(edge))) < &
                                               norm2(at - position(:, outlines%finish(edge))))
    end associate
    facing = [outlines%previous(other), other]
  end function facing_edges

  !> Length that the edges at the vertex of an entrance have in common with those that they face, from the vertex on. It is 0 for an
  !> edge that does not lie on the one that it faces.
  pure function common_lengths(outlines, position, stands_for_both, entrance) result(common)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)     !! (2, n_vertices) at the start, length
    logical, intent(in) :: stands_for_both     !! the vertex at the nearer end of the edge has the contact, too
    type(entrance_t), intent(in) :: entrance
    real(dp) :: common(2)
    type(entrance_t) :: own
    type(vertex_edges_t) :: faces
    integer :: facing(2), i

    facing = facing_edges(outlines, position, stands_for_both, entrance)
    own = entrance
    do i = 1, 2
      own%edge = facing(i)
      faces = faces_at(outlines, position, stands_for_both, .true., own)
      common(i) = merge(faces%common(i), 0.0_dp, faces%flat(i))
    end do
  end function common_lengths

  !> Measures the edges at the vertex of an entrance against its edge.
  pure type(vertex_edges_t) function faces_at(outlines, position, stands_for_both, from_start, entrance) result(faces)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)     !! (2, n_vertices), length
    logical, intent(in) :: stands_for_both     !! the vertex at the nearer end of the edge has the contact, too, however far
    logical, intent(in) :: from_start          !! of the run, or of a stage
    type(entrance_t), intent(in) :: entrance
    real(dp) :: t(2), normal(2), way(2), length, shortest, at, ends(2), from, to, beside
    real(dp) :: own(2, 2)                      ! of the vertex's edges, from it on
    integer :: i

    call frame_of_edge(position(:, outlines%start(entrance%edge)), position(:, outlines%finish(entrance%edge)), t, normal, length)
    at = dot_product(t, position(:, outlines%start(entrance%vertex)) - position(:, outlines%start(entrance%edge)))
    do i = 1, 2
      way = way_along(merge(entrance%vertex, outlines%previous(entrance%vertex), i == 1))
      faces%facing(i) = -dot_product(way, t)/norm2(way)
    end do
    faces%flat = faces%facing >= cos(parallel)
    if (any(faces%flat)) then
      shortest = min(length, norm2(way_along(entrance%vertex)), norm2(way_along(outlines%previous(entrance%vertex))))
      if (from_start) shortest = 0.0_dp ! the vertex at the end has a contact of its own
      from = 0.0_dp
      to = length
      beside = going_on(outlines%previous(entrance%edge))
      if (at < merge(0.5_dp*length, at_end*min(shortest, beside), stands_for_both)) from = -beside
      beside = going_on(outlines%next(entrance%edge))
      if (length - at < merge(0.5_dp*length, at_end*min(shortest, beside), stands_for_both)) to = length + beside
      own(:, 1) = way_along(entrance%vertex)
      own(:, 2) = -way_along(outlines%previous(entrance%vertex))
    else
      from = dot_product(t, side_from(entrance%edge, outlines%previous)) + length
      to = dot_product(t, side_from(entrance%edge, outlines%next))
      own(:, 1) = side_from(entrance%vertex, outlines%next)
      own(:, 2) = side_from(outlines%previous(entrance%vertex), outlines%previous)
    end if
    do i = 1, 2
      ends = at + [min(0.0_dp, dot_product(t, own(:, i))), max(0.0_dp, dot_product(t, own(:, i)))]
      faces%common(i) = max(0.0_dp, min(to, ends(2)) - max(from, ends(1)))
    end do
    faces%shorter = min(merge(length, to - from, any(faces%flat)), maxval(norm2(own, 1)))

  contains

    !> From the start of an edge to its end.
    pure function way_along(edge)
      integer, intent(in) :: edge
      real(dp) :: way_along(2)

      way_along = position(:, outlines%finish(edge)) - position(:, outlines%start(edge))
    end function way_along

    !> From one end of an edge to where the side ends that it lies in, over edges that go on in its direction: from its start
    !> forward, or from its end back.
    pure function side_from(edge, following) result(way)
      integer, intent(in) :: edge
      integer, intent(in) :: following(:)          !! edge after each, or before
      real(dp) :: way(2), more(2)
      integer :: k

      way = way_along(edge)
      k = following(edge)
      do while (k /= edge)
        more = way_along(k)
        if (dot_product(more, way) < cos(parallel)*norm2(more)*norm2(way)) exit
        way = way + more
        k = following(k)
      end do
      if (following(edge) == outlines%previous(edge)) way = -way
    end function side_from

    !> Length of an edge beside that of the entrance, where it goes on in its direction, else 0.
    pure real(dp) function going_on(beside)
      integer, intent(in) :: beside

      associate (way => way_along(beside))
        going_on = merge(norm2(way), 0.0_dp, dot_product(way, t) >= cos(parallel)*norm2(way))
      end associate
    end function going_on

  end function faces_at

end module scree_joint_stiffness
