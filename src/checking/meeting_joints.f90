!> Where pieces of different joint materials meet at one contact, for a person who has to know which of them acts there.
module scree_meeting_joints
  use scree_contact_geometry, only: frame_of_edge
  use scree_contacts, only: contact_t, parallel
  use scree_joint_stiffness, only: at_end
  use scree_kinds, only: dp
  use scree_model, only: model_t
  use scree_state, only: state_t
  implicit none
  private
  public :: meeting_joints, meeting_joints_t

  !> A place where edges of more than one joint material lie on one line.
  type :: meeting_joints_t
    real(dp) :: position(2) = 0.0_dp  !! length
    integer, allocatable :: joint(:)  !! numbers of the joint materials, ascending
  end type meeting_joints_t

contains

  !> Places of contacts at which pieces of different joint materials meet, each place once.
  !>
  !> A face lies on an edge there. The pieces are those of the vertex, the edge, and the next edge where the vertex is at an end of
  !> it.
  pure function meeting_joints(model, state, contact) result(meeting)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(contact_t), intent(in) :: contact(:)
    type(meeting_joints_t), allocatable :: meeting(:)
    type(meeting_joints_t) :: place
    integer, allocatable :: edge(:), joint(:)
    real(dp) :: t(2), normal(2), length, at
    integer :: i, j

    allocate (meeting(0))
    do i = 1, size(contact)
      associate (entrance => contact(i)%entrance(contact(i)%active), outlines => model%outlines)
        associate (vertex => entrance%vertex, before => outlines%previous(entrance%vertex), own => entrance%edge)
          call frame_of_edge(state%vertex(:, outlines%start(own)), state%vertex(:, outlines%finish(own)), t, normal, length)
          if (max(cosine(vertex), cosine(before)) < cos(parallel)) cycle
          at = dot_product(t, state%vertex(:, outlines%start(vertex)) - state%vertex(:, outlines%start(own)))
          edge = [own, vertex, before]
          if (at < at_end*length) edge = [edge, outlines%previous(own)]
          if (length - at < at_end*length) edge = [edge, outlines%next(own)]
          edge = pack(edge, [(abs(cosine(edge(j))) >= cos(parallel), j=1, size(edge))])
          joint = outlines%joint(edge)
          if (all(joint == joint(1))) cycle
          place%position = state%vertex(:, outlines%start(vertex)) + model%origin
          place%joint = pack([(j, j=1, maxval(joint))], [(any(joint == j), j=1, maxval(joint))])
          if (any([(norm2(meeting(j)%position - place%position) < at_end*length, j=1, size(meeting))])) cycle
          meeting = [meeting, place]
        end associate
      end associate
    end do

  contains

    !> Cosine of the angle from the way back along the edge of the contact to another edge.
    pure real(dp) function cosine(edge)
      integer, intent(in) :: edge
      real(dp) :: way(2)

      associate (outlines => model%outlines)
        way = state%vertex(:, outlines%finish(edge)) - state%vertex(:, outlines%start(edge))
      end associate
      cosine = -dot_product(way, t)/norm2(way)
    end function cosine

  end function meeting_joints

end module scree_meeting_joints
