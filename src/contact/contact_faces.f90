!> Faces that lie on each other at a contact, and the joint between them.
module scree_contact_faces
  use scree_contacts, only: blocks_of, contact_law_t, contact_t, entrance_t, outlines_t, parallel
  use scree_corners, only: along_edge, survey_t, turn
  use scree_joint_rules, only: weaker_joint
  use scree_joint_stiffness, only: at_end
  use scree_kinds, only: dp, pi
  implicit none
  private
  public :: faces_of, faces_of_entrance, is_between_same_blocks, is_between_same_faces, joint_of

  !> Of the edges about: a vertex so near to the end of an edge stands more for the edge beyond. Half of a face of length L is the
  !> vertex's, and less than half of that half lies on this edge where its end is nearer than L/4.
  real(dp), parameter :: near_end = 0.25_dp

contains

  !> Edges that lie on each other at a contact: the edge of its entrance, and the edges at its vertex that are parallel to it. Empty
  !> if no edge at the vertex is parallel.
  pure function faces_of(outlines, survey, contact) result(faces)
    type(outlines_t), intent(in) :: outlines
    type(survey_t), intent(in) :: survey
    type(contact_t), intent(in) :: contact
    integer, allocatable :: faces(:)

    faces = faces_of_entrance(outlines, survey, parallel, contact%entrance(contact%active))
  end function faces_of

  !> Likewise at an entrance.
  pure function faces_of_entrance(outlines, survey, flat, entrance) result(faces)
    type(outlines_t), intent(in) :: outlines
    type(survey_t), intent(in) :: survey
    real(dp), intent(in) :: flat    !! angle up to which edges lie on each other, rad
    type(entrance_t), intent(in) :: entrance
    integer, allocatable :: faces(:)

    associate (own => entrance%vertex, before => outlines%previous(entrance%vertex), edge => entrance%edge)
      faces = pack([own, before], [lie_flat(survey, flat, own, edge), lie_flat(survey, flat, before, edge)])
      if (size(faces) > 0) faces = [faces, edge]
    end associate
  end function faces_of_entrance

  !> Joint material of an entrance: the material of the piece of joint that bears there.
  !>
  !> Where a face at the vertex lies on the edge, or near the end of the edge on the edge that goes on beyond it, the two are a
  !> piece of the joint. The vertex has up to two pieces, one on either side. The longer one bears; of two that are about as long,
  !> the weaker one. The material of a piece is the weaker one of its two edges, so that it does not matter which face has the
  !> vertex, nor which number a material has. A corner none of whose faces lies on the edge has the material of the edge.
  pure integer function joint_of(law, outlines, survey, entrance) result(joint)
    type(contact_law_t), intent(in) :: law
    type(outlines_t), intent(in) :: outlines
    type(survey_t), intent(in) :: survey
    type(entrance_t), intent(in) :: entrance
    integer :: beyond(2), face(2), k, piece(2) ! before the vertex along the edge, and behind it
    real(dp) :: common(2), to_end(2)           ! of the pieces; from the vertex to the ends of the edge; length

    associate (edge => entrance%edge, length => survey%length)
      face = [entrance%vertex, outlines%previous(entrance%vertex)]
      beyond = [outlines%previous(edge), outlines%next(edge)]
      joint = outlines%joint(edge)
      if (all(outlines%joint([face, beyond]) == joint)) return
      to_end(1) = along_edge(survey, entrance%vertex, edge)
      to_end(2) = length(edge) - to_end(1)
      common = 0.0_dp
      piece = joint
      do k = 1, 2
        if (.not. lie_flat(survey, parallel, face(k), edge)) cycle
        common(k) = min(length(face(k)), to_end(k))
        piece(k) = weaker_joint(law, outlines%joint(face(k)), outlines%joint(edge))
        if (lie_flat(survey, parallel, face(k), beyond(k)) .and. &
            to_end(k) < near_end*min(length(edge), length(face(k)), length(beyond(k)))) then
          common(k) = min(length(face(k)) - to_end(k), length(beyond(k)))
          piece(k) = weaker_joint(law, outlines%joint(face(k)), outlines%joint(beyond(k)))
        else if (common(k) < at_end*min(length(edge), length(face(k)))) then
          common(k) = 0.0_dp
        end if
      end do
      k = maxloc(common, 1)
      if (.not. common(k) > 0) return
      joint = piece(k)
      if (common(3 - k) > (1 - near_end)*common(k)) joint = weaker_joint(law, piece(k), piece(3 - k))
    end associate
  end function joint_of

  !> Whether two edges are looked at, and one runs against the other.
  pure logical function lie_flat(survey, flat, a, b)
    type(survey_t), intent(in) :: survey
    real(dp), intent(in) :: flat    !! up to this angle, rad
    integer, intent(in) :: a, b

    lie_flat = .false.
    associate (length => survey%length)
      if (.not. min(length(a), length(b)) > 0) return
      lie_flat = dot_product(survey%finish(:, a) - survey%start(:, a), survey%start(:, b) - survey%finish(:, b)) &
                 >= cos(flat)*length(a)*length(b)
    end associate
  end function lie_flat

  !> Whether two entrances are between the same blocks, of one joint material, and across edges that face alike, within 45 degrees.
  pure logical function is_between_same_faces(outlines, survey, a, b) result(same)
    type(outlines_t), intent(in) :: outlines
    type(survey_t), intent(in) :: survey
    type(entrance_t), intent(in) :: a, b
    real(dp) :: angle

    same = a%joint == b%joint .and. is_between_same_blocks(outlines, a, b)
    if (.not. same) return
    angle = survey%corner(a%edge)%from - survey%corner(b%edge)%from
    if (outlines%block(a%edge) /= outlines%block(b%edge)) angle = angle + pi
    same = abs(turn(angle)) <= pi/4
  end function is_between_same_faces

  !> Whether two entrances are between the same two blocks, whichever has the vertex.
  pure logical function is_between_same_blocks(outlines, a, b) result(same)
    type(outlines_t), intent(in) :: outlines
    type(entrance_t), intent(in) :: a, b

    associate (of_a => blocks_of(outlines, a), of_b => blocks_of(outlines, b))
      same = all(of_a == of_b) .or. all(of_a == of_b(2:1:-1))
    end associate
  end function is_between_same_blocks

end module scree_contact_faces
