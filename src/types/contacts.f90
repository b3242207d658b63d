!> Data of contact: outlines, contacts and joints.
module scree_contacts
  use scree_contact_lists, only: entrances_t, survey_t
  use scree_joint_law, only: joint_memory_t, joint_t, laws_in_use_t
  use scree_kinds, only: dp, pi
  implicit none
  private
  public :: blocks_of, body_search_t, contact_law_t, contact_memory_t, contact_search_t, contact_t, count_states, &
            entrance_t, outlines_t, overlap_t, shi_law_t

  !> Edges whose directions differ by less are parallel, rad (Shi: h1).
  real(dp), parameter, public :: parallel = 3*pi/180

  !> Whose rules contacts follow.
  integer, parameter, public :: rules_coulomb = 1, rules_conserving = 2, rules_shi = 3

  !> State of a contact (Shi: m0).
  integer, parameter, public :: state_open = 0, state_sliding = 1, state_locked = 2

  !> Outlines of the bodies: edges with a joint, and the vertices between them. Vertex i begins edge i.
  type :: outlines_t
    integer, allocatable :: element(:)  !! (n) that carries the edge
    integer, allocatable :: of_vertex(:) !! (n) element that carries the vertex: another one where the edge begins with a sliver
    integer, allocatable :: block(:)    !! (n)
    integer, allocatable :: start(:)    !! (n) vertex of the elements where edge i begins
    integer, allocatable :: finish(:)   !! (n) vertex of the elements where it ends; but for slivers of the same element
    integer, allocatable :: side(:, :)  !! (2, n) vertices of the elements where the straight side of edge i begins and ends
    logical, allocatable :: begins_side(:) !! (n) edge i is the first of its side: its vertex is a corner
    integer, allocatable :: next(:)     !! (n) edge that begins where edge i ends
    integer, allocatable :: previous(:) !! (n)
    integer, allocatable :: joint(:)    !! (n) joint material of the edge
    integer, allocatable :: first(:)    !! (n_blocks+1) block b has the edges of_block(first(b):first(b+1)-1)
    integer, allocatable :: of_block(:) !! (n)
    logical, allocatable :: fixed(:)    !! (n) its block cannot move
    logical, allocatable :: gone(:)     !! (n) its block was removed: it touches nothing
    integer, allocatable :: inside(:, :) !! (2, m) vertices inside of bodies at the start, each with the edge behind which it is
    real(dp), allocatable :: stress(:, :, :) !! (3, 2, n) before the run at both ends of each edge, force/length^2
  end type outlines_t

  !> The line of an edge that a vertex of another body must cross to penetrate, and the memory of the contact there.
  type :: entrance_t
    integer :: vertex = 0                !! of the outlines
    integer :: edge = 0                  !! of the outlines
    integer :: joint = 1                 !! joint material of the edge
    integer :: pair = 0                  !! number of the pair of elements that vertex and edge belong to
    integer :: from = 0                  !! number of the entrance of the step before that it goes on from; 0: it is new
    integer :: state = state_open
    real(dp) :: direction = 1.0_dp       !! of sliding: 1 along the edge, -1 back, 0 of a bond pulled by more than it rubs by
    real(dp) :: anchor = 0.0_dp          !! fraction of the edge at which the shear spring holds the vertex
    real(dp) :: rest = 0.0_dp            !! gap without force; below 0: found inside; above 0: under stress before, length
    real(dp) :: multiplier(2) = 0.0_dp   !! forces across and along that the springs need not make up
    real(dp) :: stiffness(2) = 0.0_dp    !! across and along, of both entrances of a contact, force/length per unit thickness
    logical :: has_joint_stiffness = .false. !! its joint has a stiffness of its own, so multipliers do not hold it
    type(joint_memory_t) :: memory       !! of the joint
    real(dp) :: held = 0.0_dp            !! slip that friction holds in small steps, length
    real(dp) :: lagged_friction = 0.0_dp !! friction of the iteration before, by Shi's rules, force
  end type entrance_t

  !> A place where two bodies may touch: a vertex at an edge has one entrance; two convex corners have two, and enter each other
  !> only across both (Shi 1988).
  type :: contact_t
    integer :: n_entrances = 1
    integer :: active = 1               !! entrance that acts
    integer :: covered_line = 0         !! entrance line that a third block covers, so that it cannot be crossed; 0: none
    logical :: stands_for_both = .false. !! it is the one contact of two vertices that lie flat on each other
    real(dp) :: force(2) = 0.0_dp       !! at the end of the last step, pressing and along the edge, per unit thickness
    real(dp) :: pressed = 0.0_dp        !! overlap of its spring then, length
    real(dp) :: slipped = 0.0_dp        !! way that it slid in the last step, length
    real(dp) :: overlap = 0.0_dp        !! then, with what it rests at; of an open one as far as it rests inside, length
    real(dp) :: energy = 0.0_dp         !! of its springs then, force length per unit thickness
    integer :: end = 0                  !! of small steps: at which end of what two bodies have in common, 1 or 2; 0: of others
    integer :: strained = 0             !! steps in a row in which its bond has been at its limits, of small steps
    real(dp) :: inherits = -1.0_dp      !! overlap of the contact whose place it takes; below 0: none, length
    type(entrance_t) :: entrance(2)
  end type contact_t

  !> Memory of contacts from step to step.
  type :: contact_memory_t
    type(contact_t), allocatable :: contact(:)
    integer, allocatable :: inside(:, :)    !! (2, n) vertices, each with the edge that it has been inside of since the run began
    real(dp) :: stiffness(2) = 0.0_dp       !! across a contact and along it, force/length per unit thickness
    real(dp), allocatable :: extra_reach(:) !! (n_blocks) displacement beyond the velocity that the search looks at, length
    real(dp), allocatable :: extra_turn(:)  !! (n_blocks) turn beyond the velocity that the search looks at, rad
    real(dp) :: penetration = 0.0_dp        !! largest at the end of the last step, length
    real(dp) :: pressed = 0.0_dp            !! largest overlap of a spring then, length
    real(dp) :: gap = 0.0_dp                !! largest of a closed contact then, length
    integer :: count(3) = 0                 !! contacts open, sliding, locked then
    integer :: broken(2) = 0                !! bonds that broke in tension and in shear since the run began
  end type contact_memory_t

  !> Which bodies are near others, by circles that hold for many steps.
  type :: body_search_t
    real(dp), allocatable :: centre(:, :) !! (2, n_blocks) length
    real(dp), allocatable :: radius(:)    !! (n_blocks) of the circle that holds the vertices, length
    real(dp), allocatable :: longest(:)   !! (n_blocks) of the sides then, length
    real(dp), allocatable :: shortest(:)  !! (n_blocks) of the edges when the run began, length
    real(dp), allocatable :: reach(:)     !! (n_blocks) beyond the circle, length
    real(dp), allocatable :: moved(:)     !! (n_blocks) farthest that a vertex may have gone since, length
    real(dp), allocatable :: speed(:)     !! (n_blocks) bound of how fast a vertex goes at the beginning of the step, length/time
    real(dp) :: extra_reach = 0.0_dp, pressed = 0.0_dp !! of contacts, up to which the circles hold, length
    logical, allocatable :: near(:)       !! (n_blocks) can move, and others are near
    integer, allocatable :: edge(:)       !! of the outlines, that are looked at
    integer, allocatable :: vertex(:)     !! at their ends
    integer, allocatable :: about(:)      !! these, two before and two after each
    integer, allocatable :: farther(:)    !! and one more
  end type body_search_t

  !> Who is near whom: lists that hold for several steps, and what a step fills anew of what has room for all vertices.
  type :: contact_search_t
    integer, allocatable :: candidate(:, :) !! (2, n) vertices and edges that the search found near each other
    real(dp), allocatable :: found_at(:, :) !! (2, n) positions of the vertices then, length
    real(dp), allocatable :: reach(:)       !! (n) how far the search saw around each vertex, length
    type(body_search_t) :: bodies
    type(survey_t), allocatable :: survey   !! of the last search
    type(entrances_t) :: past, found        !! entrances of the contacts before it, and of those that it found
  end type contact_search_t

  !> One piece of the common area of two bodies, for a person.
  type :: overlap_t
    integer :: body(2) = 0        !! blocks
    real(dp) :: depth = 0.0_dp    !! across the edge by which the bodies entered, length
    real(dp) :: share = 0.0_dp    !! of the depth in the smaller body, by the root of its area
    real(dp) :: position(2) = 0.0_dp !! its middle, length
    logical :: crossing = .false. !! no vertex of either is inside the other: they cross like swords
  end type overlap_t

  !> Numbers of Shi's own rules.
  type :: shi_law_t
    real(dp) :: closing = 0.0_dp             !! overlap at which an open contact closes (s0), length
    real(dp) :: opening = 0.0_dp             !! gap at which a closed one opens (f0), length
    real(dp) :: touching = -huge(1.0_dp)     !! gap up to which contacts are closed when a run begins, length
    real(dp) :: backlash = 0.0_dp            !! slip back at which a sliding contact locks, length
    real(dp) :: search_gap = 0.0_dp          !! up to which contacts are found (d0); 0: as far as vertices move, length
    real(dp) :: search_depth = 0.0_dp        !! overlap up to which they are found (d9), length
    real(dp) :: guard = 0.0_dp               !! added to the square of an edge on which an anchor is placed, length^2
    real(dp) :: allowed_gap = 0.0_dp         !! of closed contacts, to which the stiffness adapts (2 g2 w0); 0: it does not, length
    real(dp) :: allowed_penetration = 0.0_dp !! likewise (g3 w0), length
  end type shi_law_t

  !> Data common to all contacts.
  type :: contact_law_t
    integer :: rules = rules_coulomb        !! whose apply; `contact_rules` alone asks
    real(dp) :: normal_stiffness = 0.0_dp   !! p, where the joint has none, force/length per unit thickness (Shi: g0)
    real(dp) :: shear_stiffness = 0.0_dp    !! p over the shear ratio (Shi: h2)
    type(joint_t), allocatable :: joint(:)  !! (n_joints)
    type(laws_in_use_t) :: uses             !! which laws any of these has; `joint_rules` alone asks
    real(dp) :: most_dilated = 0.0_dp       !! gap up to which a joint that has dilated is one, length
    real(dp) :: penetration = huge(1.0_dp)  !! that multipliers leave; huge: springs alone, length
    real(dp) :: restitution = -1.0_dp       !! fraction of the velocity that an impact gives back; below 0: as the springs have it
    real(dp) :: viscosity = 0.0_dp          !! across closed contacts, force time/length per unit thickness
    real(dp) :: settling = 0.0_dp           !! of a column as high as the scene under its own weight, length
    real(dp) :: largest_jump = 0.25_dp      !! of the sides about, that a vertex may move beyond what its velocity makes
    type(shi_law_t) :: shi
  end type contact_law_t

contains

  !> Blocks of the vertex and of the edge of an entrance.
  pure function blocks_of(outlines, entrance) result(block)
    type(outlines_t), intent(in) :: outlines
    type(entrance_t), intent(in) :: entrance
    integer :: block(2)

    block = outlines%block([entrance%vertex, entrance%edge])
  end function blocks_of

  !> How many contacts are open, sliding, locked.
  pure function count_states(contact) result(number)
    type(contact_t), intent(in) :: contact(:)
    integer :: number(3)
    integer :: i

    number = 0
    do i = 1, size(contact)
      associate (state => contact(i)%entrance(contact(i)%active)%state)
        number(state + 1) = number(state + 1) + 1
      end associate
    end do
  end function count_states

end module scree_contacts
