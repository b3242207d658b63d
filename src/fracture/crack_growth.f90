!> Which cracks grow, and where to.
!>
!> A crack grows at its tip by the piece that lies in the next element, so that its new tip is on a side of a triangle of the mesh.
!> All places are those of the start: an element is the affine image of its polygon then, so nothing is cut in its deformed shape.
!>
!> The crack grows where the largest intensity of the circumferential stress has reached the toughness of the rock, in the direction
!> of that (`scree_crack_direction`). It also grows where the largest principal stress, averaged over a half disc before the tip,
!> has reached the tensile strength of the rock, across that stress.
module scree_crack_growth
  use scree_block_finder, only: block_at, block_finder_t, set_up_finder
  use scree_crack_direction, only: growth_angle, hoop_intensity
  use scree_crack_tip, only: crack_tip_t
  use scree_kinds, only: dp, pi
  use scree_model, only: cache_t, model_t
  use scree_regions, only: first_vertex_of, last_vertex_of, loops_of, vertices_after
  use scree_state, only: state_t
  use scree_stress_intensity, only: stress_intensity
  use scree_tip_disc, only: is_measured
  implicit none
  private
  public :: find_growth, growth_t

  !> Of an edge of the mesh: a piece that would end nearer to a vertex of an element ends in it, as smaller elements would have next
  !> to no stiffness. This turns the piece by at most 1.3 degrees, as it passes a triangle of equal sides.
  real(dp), parameter :: to_vertex = 0.02_dp
  !> Likewise: how far before the tip it is looked which element comes next, and length of a piece that is none.
  real(dp), parameter :: ahead = 1e-6_dp
  real(dp), parameter :: same = 1e-9_dp !! of the extent: places that are nearer to each other are one
  !> Mean over the half disc of radius r before a tip of the tension across the crack, in the singular field of mode I (Williams,
  !> 1957): this part of K/r^(1/2).
  real(dp), parameter :: tension_of_intensity = 10.4_dp/(3*pi*sqrt(pi))
  real(dp), parameter :: near_edges = 2.0_dp !! sides of a triangle in the radius of that half disc, where the next tip is near
  integer, parameter :: n_rings = 12, n_rays = 24 !! of the points over which stress is averaged

  !> Pieces by which cracks are to grow.
  type :: growth_t
    real(dp), allocatable :: piece(:, :)   !! (4, n) x1 y1 x2 y2, from the tip on, at the start, in coordinates of the model, length
    integer, allocatable :: tip(:)         !! (n) of the model
  end type growth_t

contains

  !> Finds the tips that grow in a state, and the pieces by which they do.
  subroutine find_growth(model, cache, state, growth)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(growth_t), intent(out) :: growth
    type(block_finder_t) :: finder
    real(dp) :: direction(2), end(2), piece(4, size(model%tip))
    logical :: breaks, grows(size(model%tip))
    integer :: i

    call set_up_finder(finder, model%elements%shape, model%start, same*model%extent)
    grows = .false.
    do i = 1, size(model%tip)
      associate (tip => model%tip(i), s => model%settings)
        breaks = .false.
        if (allocated(s%crack_toughness)) call judge_toughness(s%crack_toughness(model%elements%material(tip%element)), tip)
        if (allocated(s%crack_strength) .and. .not. breaks) &
          call judge_strength(s%crack_strength(model%elements%material(tip%element)), s%crack_length, tip)
        if (.not. breaks) cycle
        call find_end(tip, direction, finder, model, end, grows(i))
        piece(:, i) = [tip%end, end]
      end associate
    end do
    growth%tip = pack([(i, i=1, size(model%tip))], grows)
    growth%piece = piece(:, growth%tip)

  contains

    !> Whether a tip breaks rock of a toughness; 0: it does not. Where the next tip leaves no room for the disc of the stress
    !> intensity, the mean tension before the tip is compared with the one that the toughness has there.
    subroutine judge_toughness(toughness, tip)
      real(dp), intent(in) :: toughness    !! K_Ic, force/length^(3/2)
      type(crack_tip_t), intent(in) :: tip
      real(dp) :: radius

      radius = near_edges*tip%edge
      if (.not. is_measured(tip)) then
        call judge_strength(tension_of_intensity*toughness/sqrt(radius), radius, tip)
      else if (toughness > 0) then
        call judge_intensity(stress_intensity(model, cache, state, tip), toughness, tip%disc%direction, breaks, direction)
      end if
    end subroutine judge_toughness

    !> Whether the mean tension over a half disc before a tip breaks rock of a strength; 0: it does not.
    subroutine judge_strength(strength, radius, tip)
      real(dp), intent(in) :: strength     !! force/length^2
      real(dp), intent(in) :: radius       !! length
      type(crack_tip_t), intent(in) :: tip

      if (strength > 0) call judge_tension(mean_stress_before(tip, radius, finder, model, state), strength, tip%direction, breaks, &
                                           direction)
    end subroutine judge_strength

  end subroutine find_growth

  !> Whether the stress intensity of a tip breaks the rock, and in which direction: that of the largest circumferential stress.
  pure subroutine judge_intensity(K, toughness, onwards, breaks, direction)
    real(dp), intent(in) :: K(2)           !! of modes I and II, force/length^(3/2)
    real(dp), intent(in) :: toughness      !! K_Ic, force/length^(3/2)
    real(dp), intent(in) :: onwards(2)     !! direction of the crack
    logical, intent(out) :: breaks
    real(dp), intent(out) :: direction(2)  !! of length 1
    real(dp) :: angle

    angle = growth_angle(K)
    breaks = hoop_intensity(K, angle) >= toughness
    direction = cos(angle)*onwards + sin(angle)*[-onwards(2), onwards(1)]
  end subroutine judge_intensity

  !> Mean stress over the half disc before a tip, in the axes of the start: xx, yy, xy, force/length^2. What of the disc is not in
  !> the block of the tip does not count; without any of it the stress is 0.
  !>
  !> The half disc has points at equal areas, on rings and rays. The stress of an element is turned back by its rotation.
  function mean_stress_before(tip, radius, finder, model, state) result(stress)
    type(crack_tip_t), intent(in) :: tip
    real(dp), intent(in) :: radius         !! length
    type(block_finder_t), intent(in) :: finder !! of the elements at the start
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(dp) :: stress(3)
    real(dp) :: angle, r
    integer :: e, i, k, n

    stress = 0.0_dp
    n = 0
    do i = 1, n_rings
      r = radius*sqrt((i - 0.5_dp)/n_rings)
      do k = 1, n_rays
        angle = pi*((k - 0.5_dp)/n_rays - 0.5_dp)
        e = block_at(finder, model%elements%shape, model%start, &
                     tip%end + r*(cos(angle)*tip%direction + sin(angle)*[-tip%direction(2), tip%direction(1)]), &
                     model%elements%block, tip%block)
        if (e == 0) cycle
        n = n + 1
        stress = stress + turned_back(state%stress(:, e), state%deformation(:, e))
      end do
    end do
    if (n > 0) stress = stress/n
  end function mean_stress_before

  !> A stress in the axes of the start: those of an element have turned by the rotation of its deformation gradient.
  pure function turned_back(stress, deformation) result(own)
    real(dp), intent(in) :: stress(3)      !! xx, yy, xy, force/length^2
    real(dp), intent(in) :: deformation(4) !! F: xx, yx, xy, yy
    real(dp) :: own(3)
    real(dp) :: c, s, middle, double(2)

    c = deformation(1) + deformation(4)
    s = deformation(2) - deformation(3)
    double = [c*c - s*s, 2*c*s]/(c*c + s*s) ! cosine and sine of twice the rotation
    middle = (stress(1) + stress(2))/2
    own(1) = middle + (stress(1) - stress(2))/2*double(1) + stress(3)*double(2)
    own(2) = 2*middle - own(1)
    own(3) = stress(3)*double(1) - (stress(1) - stress(2))/2*double(2)
  end function turned_back

  !> Whether tension breaks the rock before a tip, and in which direction: across the largest principal stress, onwards.
  pure subroutine judge_tension(stress, strength, onwards, breaks, direction)
    real(dp), intent(in) :: stress(3)      !! xx, yy, xy, force/length^2
    real(dp), intent(in) :: strength       !! force/length^2
    real(dp), intent(in) :: onwards(2)     !! direction of the crack
    logical, intent(out) :: breaks
    real(dp), intent(out) :: direction(2)
    real(dp) :: angle

    breaks = (stress(1) + stress(2))/2 + sqrt(((stress(1) - stress(2))/2)**2 + stress(3)**2) >= strength
    angle = 0.5_dp*atan2(2*stress(3), stress(1) - stress(2))
    direction = [-sin(angle), cos(angle)]
    if (dot_product(direction, onwards) < 0) direction = -direction
  end subroutine judge_tension

  !> Finds where a crack that grows in a direction leaves the next element. It goes to a vertex of that where one is near.
  subroutine find_end(tip, direction, finder, model, end, is_there)
    type(crack_tip_t), intent(in) :: tip
    real(dp), intent(in) :: direction(2)   !! of length 1
    type(block_finder_t), intent(in) :: finder !! of the elements at the start
    type(model_t), intent(in) :: model
    real(dp), intent(out) :: end(2)        !! length
    logical, intent(out) :: is_there       !! else the tip has no element before it
    real(dp), allocatable :: vertex(:, :)
    integer, allocatable :: next(:)
    real(dp) :: a(2), b(2), across, nearest, t, way
    integer :: e, k

    end = tip%end
    is_there = .false.
    e = block_at(finder, model%elements%shape, model%start, tip%end + ahead*tip%edge*direction, model%elements%block, tip%block)
    if (e == 0) return
    vertex = model%start(:, first_vertex_of(model%elements%shape, e):last_vertex_of(model%elements%shape, e))
    next = vertices_after(loops_of(model%elements%shape, e))
    way = huge(way)
    do k = 1, size(next)
      a = vertex(:, k) - tip%end
      b = vertex(:, next(k)) - vertex(:, k)
      across = direction(1)*b(2) - direction(2)*b(1)
      if (.not. abs(across) > 0) cycle
      t = (a(1)*b(2) - a(2)*b(1))/across
      if (t < ahead*tip%edge .or. t > way) cycle
      a = a - t*direction ! from the crossing to the beginning of the edge
      if (dot_product(a, b) > 0 .or. dot_product(a + b, b) < 0) cycle
      way = t
    end do
    if (.not. way < huge(way)) return
    is_there = .true.
    end = tip%end + way*direction
    nearest = to_vertex*tip%edge
    do k = 1, size(next)
      if (norm2(vertex(:, k) - tip%end) <= to_vertex*tip%edge) cycle
      if (norm2(vertex(:, k) - tip%end - way*direction) > nearest) cycle
      nearest = norm2(vertex(:, k) - tip%end - way*direction)
      end = vertex(:, k)
    end do
  end subroutine find_end

end module scree_crack_growth
