!> Which cracks grow, and where to.
!>
!> A crack grows at its tip by the piece that lies in the next element, so that its new tip is on a side of a triangle of the mesh.
!> All places are those of the start: an element is the affine image of its polygon then, so nothing is cut in its deformed shape.
!>
!> The crack grows where the largest intensity of the circumferential stress has reached the toughness of the rock, in the direction
!> of that (`scree_crack_direction`). It also grows where the largest principal stress, averaged over a half disc before the tip,
!> has reached the tensile strength of the rock, across that stress.
module scree_crack_growth
  use scree_block_finder, only: block_finder_t, set_up_finder
  use scree_crack_beginning, only: begin_cracks
  use scree_crack_direction, only: growth_angle, hoop_intensity
  use scree_crack_piece, only: find_end, growth_t
  use scree_crack_tip, only: crack_tip_t
  use scree_kinds, only: dp, pi
  use scree_mean_tension, only: find_tension, mean_stress_before
  use scree_model, only: cache_t, model_t
  use scree_state, only: state_t
  use scree_stress_intensity, only: stress_intensity
  use scree_tip_disc, only: is_measured
  implicit none
  private
  public :: find_growth

  real(dp), parameter :: same = 1e-9_dp !! of the extent: places that are nearer to each other are one
  !> Mean over the half disc of radius r before a tip of the tension across the crack, in the singular field of mode I (Williams,
  !> 1957): this part of K/r^(1/2).
  real(dp), parameter :: tension_of_intensity = 10.4_dp/(3*pi*sqrt(pi))
  real(dp), parameter :: near_edges = 2.0_dp !! sides of a triangle in the radius of that half disc, where the next tip is near

contains

  !> Finds the tips that grow in a state, the cracks that begin, and the pieces by which they do.
  !>
  !> In a static run no crack begins in a block of which one grows, as that lets the tension go. Waves do so in motion.
  subroutine find_growth(model, cache, state, growth)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(growth_t), intent(out) :: growth
    type(block_finder_t) :: finder
    real(dp) :: direction(2), end(2), piece(4, size(model%tip))
    logical :: breaks, grows(size(model%tip)), is_relieved(model%n_blocks)
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
        call find_end(tip%end, direction, tip%edge, tip%block, finder, model, end, grows(i))
        piece(:, i) = [tip%end, end]
      end associate
    end do
    growth%tip = pack([(i, i=1, size(model%tip))], grows)
    growth%piece = piece(:, growth%tip)
    growth%number = model%tip(growth%tip)%number
    growth%joint = model%tip(growth%tip)%joint
    if (.not. allocated(model%crack_start)) return
    is_relieved = .false.
    if (model%effects%is_static()) is_relieved(model%tip(growth%tip)%block) = .true.
    call begin_cracks(model, state, finder, is_relieved, growth)

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
      real(dp) :: tension

      if (.not. strength > 0) return
      call find_tension(mean_stress_before(tip%end, tip%direction, tip%block, radius, finder, model, state), tip%direction, &
                        tension, direction)
      breaks = tension >= strength
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

end module scree_crack_growth
