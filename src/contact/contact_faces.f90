!> Faces that lie on each other at a contact, and the joint between them.
module scree_contact_faces
  use scree_contacts, only: blocks_of, contact_t, entrance_t, outlines_t, parallel
  use scree_corners, only: along_edge, survey_t, turn
  use scree_joint_stiffness, only: at_end
  use scree_kinds, only: dp, pi
  implicit none
  private
  public :: faces_of, faces_of_entrance, is_between_same_blocks, is_between_same_faces, joint_of

contains

  !> Edges that lie on each other at a contact: that of its entrance, and at its vertex those parallel to it. None where there is
  !> none of these.
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

  !> Joint material of an entrance: the largest number of the edges that lie on each other before its vertex and behind it, along
  !> its edge, so that it does not matter which of two faces has the vertex; where none do, that of its edge.
  pure integer function joint_of(outlines, survey, entrance) result(joint)
    type(outlines_t), intent(in) :: outlines
    type(survey_t), intent(in) :: survey
    type(entrance_t), intent(in) :: entrance
    real(dp) :: at
    integer :: k, lies(2, 2) ! (edge at the vertex and that which it lies on, if it does, on either side of the vertex)

    associate (own => entrance%vertex, edge => entrance%edge, length => survey%length(entrance%edge))
      at = along_edge(survey, own, edge)
      lies(:, 1) = [own, merge(edge, outlines%previous(edge), at > at_end*length)]
      lies(:, 2) = [outlines%previous(own), merge(edge, outlines%next(edge), at < (1 - at_end)*length)]
      joint = 0
      do k = 1, 2
        if (lie_flat(survey, parallel, lies(1, k), edge) .and. lie_flat(survey, parallel, lies(1, k), lies(2, k))) &
          joint = max(joint, maxval(outlines%joint(lies(:, k))))
      end do
      if (joint == 0) joint = outlines%joint(edge)
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
