!> Forces with which joints begin under a stress before the run.
!>
!> Two faces that lie on each other have a piece in common, of length l, with a contact at both of its ends. The traction t of the
!> stress on it is taken as linear, and each contact has the part that is work-equivalent to it for displacements linear along the
!> piece:
!>
!>     f = l (2 t_own + t_other)/6
!>
!> Displacements of blocks and of elements of a mesh are linear. So a linear stress in equilibrium with the weight leaves no force
!> out of balance, on no unknown. Derived in doc/theory/equilibrium.md, eq-joint-traction.
module scree_stressed_joints
  use scree_bond_rules, only: bond
  use scree_contact_geometry, only: frame_of_edge, gap_of
  use scree_contact_rules, only: has_bonds
  use scree_contacts, only: contact_law_t, contact_t, entrance_t, outlines_t, state_locked, state_sliding
  use scree_joint_rules, only: friction_of, overlap_under
  use scree_joint_stiffness, only: common_lengths, facing_edges, is_hard, measure_bond
  use scree_kinds, only: dp
  implicit none
  private
  public :: begin_stressed, entrance_on_face, force_of_stress, shear_strength

  !> Gap that rounded numbers of a file leave between faces that lie on each other, over the length that they have in common.
  real(dp), parameter :: of_a_file = 1e-4_dp

contains

  !> The entrance of a contact whose faces lie on each other; 0: none.
  pure integer function entrance_on_face(outlines, position, contact) result(k)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)       !! (2, n_vertices) at the start, length
    type(contact_t), intent(in) :: contact
    real(dp) :: gap, length(2)
    integer :: i

    length = 0.0_dp
    do i = 1, contact%n_entrances
      length(i) = sum(common_lengths(outlines, position, contact%stands_for_both, contact%entrance(i)))
    end do
    k = maxloc(length, 1)
    gap = gap_of_entrance(outlines, position, contact%entrance(k))
    if (.not. (length(k) > 0 .and. gap <= of_a_file*length(k))) k = 0
  end function entrance_on_face

  !> Begins a contact between faces that lie on each other with the force of the stress before the run. Its springs are compressed
  !> and sheared by it, or its multipliers hold it. A shear beyond the strength of the joint is cut off, and the joint slides.
  pure subroutine begin_stressed(outlines, position, law, contact)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)       !! (2, n_vertices) at the start, length
    type(contact_law_t), intent(in) :: law
    type(contact_t), intent(inout) :: contact    !! with its stiffness
    real(dp) :: along, force(2), length, most, normal(2), t(2)
    integer :: k

    k = entrance_on_face(outlines, position, contact)
    if (k == 0) return
    force = force_of_stress(outlines, position, contact, k)
    if (.not. force(1) > 0) return
    contact%active = k
    most = shear_strength(outlines, position, law, contact, k, force(1))
    associate (entrance => contact%entrance(k), start => position(:, outlines%start(contact%entrance(k)%edge)))
      entrance%state = state_locked
      if (abs(force(2)) > most) then
        entrance%state = state_sliding
        entrance%direction = sign(1.0_dp, -force(2))
        force(2) = sign(most, force(2))
      end if
      entrance%memory%pressing = force(1)
      call frame_of_edge(start, position(:, outlines%finish(entrance%edge)), t, normal, length)
      along = dot_product(t, position(:, outlines%start(entrance%vertex)) - start)
      entrance%rest = gap_of_entrance(outlines, position, entrance)
      entrance%anchor = along/length
      if (is_hard(law, entrance)) then
        entrance%multiplier = force
      else
        entrance%rest = entrance%rest + overlap_under(law, entrance, force(1))
        entrance%anchor = (along + force(2)/entrance%stiffness(2))/length
      end if
    end associate
  end subroutine begin_stressed

  !> Force of the stress before the run on the vertex of an entrance: across its edge (pressing where positive) and along it.
  !> Per unit thickness, by the mean of the stresses of both bodies.
  pure function force_of_stress(outlines, position, contact, k) result(force)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)       !! (2, n_vertices) at the start, length
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k                     !! entrance
    real(dp) :: force(2)
    real(dp), dimension(2) :: along, common, edge_normal, far, f, near, normal, t
    real(dp) :: length, own(3, 2)
    integer :: edge, facing(2), i

    f = 0.0_dp
    associate (entrance => contact%entrance(k), at => position(:, outlines%start(contact%entrance(k)%vertex)))
      common = common_lengths(outlines, position, contact%stands_for_both, entrance)
      facing = facing_edges(outlines, position, contact%stands_for_both, entrance)
      do i = 1, 2
        if (.not. common(i) > 0) cycle
        edge = merge(entrance%vertex, outlines%previous(entrance%vertex), i == 1)
        call frame_of_edge(position(:, outlines%start(edge)), position(:, outlines%finish(edge)), along, normal, length)
        far = at + merge(common(i), -common(i), i == 1)*along
        own(:, 1) = 0.5_dp*(stress_on(edge, at) + stress_on(facing(i), at))
        own(:, 2) = 0.5_dp*(stress_on(edge, far) + stress_on(facing(i), far))
        near = traction(own(:, 1), normal)
        far = traction(own(:, 2), normal)
        f = f + common(i)*(2*near + far)/6
      end do
      call frame_of_edge(position(:, outlines%start(entrance%edge)), position(:, outlines%finish(entrance%edge)), t, edge_normal, &
                         length)
    end associate
    force = [dot_product(f, edge_normal), dot_product(f, t)]

  contains

    !> Stress of the body of an edge at a place on its line, linear between the ends of the edge and beyond.
    pure function stress_on(edge, place) result(stress)
      integer, intent(in) :: edge
      real(dp), intent(in) :: place(2)           !! length
      real(dp) :: stress(3), from(2), share, way(2)

      from = position(:, outlines%start(edge))
      way = position(:, outlines%finish(edge)) - from
      share = dot_product(place - from, way)/dot_product(way, way)
      stress = (1 - share)*outlines%stress(:, 1, edge) + share*outlines%stress(:, 2, edge)
    end function stress_on

    !> Traction of a stress on a face.
    pure function traction(stress, normal) result(of_face)
      real(dp), intent(in) :: stress(3), normal(2)
      real(dp) :: of_face(2)

      of_face = [stress(1)*normal(1) + stress(3)*normal(2), stress(3)*normal(1) + stress(2)*normal(2)]
    end function traction

  end function force_of_stress

  !> Shear force that the joint of an entrance bears under a pressing force when the run begins, its faces lying on each other.
  pure real(dp) function shear_strength(outlines, position, law, contact, k, pressing) result(strength)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)       !! (2, n_vertices) at the start, length
    type(contact_law_t), intent(in) :: law
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k                     !! entrance
    real(dp), intent(in) :: pressing             !! force per unit thickness
    type(entrance_t) :: own
    logical :: bonds(size(law%joint))

    bonds = has_bonds(law)
    own = contact%entrance(k)
    own%memory%pressing = pressing
    call measure_bond(outlines, position, law, bonds, contact%stands_for_both, own)
    strength = friction_of(law, own)*pressing + bond(own, law%joint(own%joint)%cohesion)
  end function shear_strength

  !> Distance of the vertex of an entrance from the line of its edge, below 0 behind it, length.
  pure real(dp) function gap_of_entrance(outlines, position, entrance) result(gap)
    type(outlines_t), intent(in) :: outlines
    real(dp), intent(in) :: position(:, :)       !! (2, n_vertices), length
    type(entrance_t), intent(in) :: entrance

    gap = gap_of(position(:, outlines%start(entrance%vertex)), position(:, outlines%start(entrance%edge)), &
                 position(:, outlines%finish(entrance%edge)))
  end function gap_of_entrance

end module scree_stressed_joints
