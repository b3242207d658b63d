!> The disc around a tip of a crack, with the weights of the interaction integral.
!>
!> Around the end of a crack linear triangles are too stiff. Far from it their field is that of a crack which ends about 0.3
!> sides of a triangle earlier. The centre of the disc is there, as the integral about another place would not have K alone.
!>
!> Axis 1 is the direction of the crack there, and u^m is the field of a mode with K = 1 (`scree_near_tip_field`). The function q
!> falls from 1 near the tip to 0 at the radius of the disc. The integral is
!>
!>     I_m = int [s_ij u^m_i,1 + s^m_ij u_i,1 - s_ij e^m_ij d_1j] q_,j dA
!>         + int [(rho a_i - b_i) u^m_i,1 - s0_ij,1 e^m_ij] q dA
!>         - int over faces [t_i u^m_i,1 + s^m_ij n_j u_i,1 - s_ij e^m_ij n_1] q ds,        K_m = E' I_m/2.
!>
!> It is a contour integral around the tip made a domain integral by the divergence theorem (Stern, Becker and Dunham 1976; Yau,
!> Wang and Corten 1980; Shih and Asaro 1988). Its energy is that of the whole stress s, so an initial stress s0 counts by its
!> gradient alone. Here a is the acceleration, b the body force, and t the traction on faces with the outer normal n. Only curved
!> faces and outlines have the last two terms. With t, any face may lie in the disc, but no other tip.
module scree_tip_disc
  use scree_crack_tip, only: crack_tip_t, tip_disc_t
  use scree_ear_cutting, only: ears_of
  use scree_keyholes, only: polygons_of
  use scree_kinds, only: dp, pi
  use scree_model, only: model_t
  use scree_near_tip_field, only: near_tip_field_t, singular_field
  use scree_polygon, only: twice_area
  use scree_regions, only: joint_between
  implicit none
  private
  public :: fall, field_at, is_measured, lay_discs, radius_of_disc, weight_at

  real(dp), parameter :: flat_share = 0.2_dp    !! of the radius, within which q is 1
  real(dp), parameter :: share_of_path = 0.3_dp !! of the crack from the tip to where it ends or branches, that a disc reaches
  real(dp), parameter :: fair_edges = 5.0_dp    !! sides of triangles that a disc spans where the crack is short
  real(dp), parameter :: least_edges = 2.5_dp   !! that it spans where faces are near
  real(dp), parameter :: least_radius = 1.5_dp  !! sides of a triangle below which a disc tells no stress intensity
  real(dp), parameter :: clear = 0.9_dp         !! of the distance to faces, and to other tips
  real(dp), parameter :: inward = 1e-8_dp       !! of the radius, by which a place lies behind the face that it is on
  real(dp), parameter :: straight = 1e-9_dp     !! of the radius: a face that is nearer to the line of the tip lies on it

  integer, parameter, public :: n_gauss = 8
  !> Points and weights of Gauss' rule from -1 to 1, of which 0 is the middle.
  real(dp), parameter :: half_gauss(4) = &
    [0.1834346424956498_dp, 0.5255324099163290_dp, 0.7966664774136267_dp, 0.9602898564975363_dp]
  real(dp), parameter :: half_weight(4) = &
    [0.3626837833783620_dp, 0.3137066458778873_dp, 0.2223810344533745_dp, 0.1012285362903763_dp]
  real(dp), parameter, public :: gauss_place(n_gauss) = 0.5_dp*(1 + [-half_gauss(4:1:-1), half_gauss])
  real(dp), parameter, public :: gauss_weight(n_gauss) = 0.5_dp*[half_weight(4:1:-1), half_weight]

contains

  !> Lays the discs of tips.
  subroutine lay_discs(model, back, gradient, tips)
    type(model_t), intent(in) :: model
    real(dp), intent(in) :: back(:)               !! (n_tips) ways from the ends of the cracks to the centres, length
    real(dp), intent(in) :: gradient(:, :)        !! (3, n_materials) of the initial stress, its increase with y, force/length^3
    type(crack_tip_t), intent(inout) :: tips(:)
    integer, allocatable :: corner(:), first(:)
    integer :: i

    if (size(tips) == 0) return
    call polygons_of(model%elements%shape, model%start, first, corner)
    do i = 1, size(tips)
      call place_disc(back(i), tips(i))
      call lay_disc(model, first, corner, gradient, radius_of_disc(tips(i)), tips(i))
    end do
  end subroutine lay_discs

  !> Radius of a disc, length.
  !>
  !> It is 0.3 of the crack, or five sides of triangles where the crack is short. It reaches neither another tip nor, as long as it
  !> spans 2.5 sides, other faces.
  pure real(dp) function radius_of_disc(tip) result(radius)
    type(crack_tip_t), intent(in) :: tip

    radius = max(share_of_path*length_of(tip%path), fair_edges*tip%edge)
    radius = max(least_edges*tip%edge, min(radius, clear*tip%to_face))
    if (tip%to_tip < radius/clear) radius = clear*tip%to_tip
  end function radius_of_disc

  !> Whether the disc of a tip spans enough triangles for its stress intensity. The next tip may leave it too little room.
  pure logical function is_measured(tip)
    type(crack_tip_t), intent(in) :: tip

    is_measured = .not. radius_of_disc(tip) < least_radius*tip%edge
  end function is_measured

  !> Puts the centre of a disc on the crack, back from its end; at most to the middle of the crack.
  pure subroutine place_disc(back, tip)
    real(dp), intent(in) :: back                  !! along the crack, length
    type(crack_tip_t), intent(inout) :: tip
    real(dp) :: along(2), length, left
    integer :: k

    left = min(back, 0.5_dp*length_of(tip%path))
    do k = 2, size(tip%path, 2)
      along = tip%path(:, k) - tip%path(:, k - 1)
      length = norm2(along)
      if (left < length) exit
      left = left - length
    end do
    tip%disc%path = tip%path(:, k - 1:)
    tip%disc%place = tip%path(:, k - 1) + left/length*along
    tip%disc%path(:, 1) = tip%disc%place
    tip%disc%direction = -along/length
  end subroutine place_disc

  !> Length of a polyline.
  pure real(dp) function length_of(path)
    real(dp), intent(in) :: path(:, :)            !! (2, n) length
    integer :: k

    length_of = sum([(norm2(path(:, k) - path(:, k - 1)), k=2, size(path, 2))])
  end function length_of

  !> Lays one disc: finds its elements and the weights of their fields.
  subroutine lay_disc(model, first, corner, gradient, radius, tip)
    type(model_t), intent(in) :: model
    integer, intent(in) :: first(:), corner(:)    !! polygons of the elements
    real(dp), intent(in) :: gradient(:, :)        !! (3, n_materials) force/length^3
    real(dp), intent(in) :: radius                !! length
    type(crack_tip_t), intent(inout) :: tip
    integer, allocatable :: inside(:), ears(:, :)
    real(dp) :: ahead, change(3), spread_of(3)
    integer :: e, i, k, n

    tip%disc%radius = radius
    ahead = length_of(tip%path) - length_of(tip%disc%path)
    associate (D => model%effects%elasticity(:, :, model%elements%material(tip%element)))
      tip%disc%shear = D(3, 3)
      tip%disc%kappa = (3*D(1, 1) - D(1, 2))/(D(1, 1) + D(1, 2))
      tip%disc%modulus = (D(1, 1)**2 - D(1, 2)**2)/D(1, 1)
    end associate
    inside = pack([(e, e=1, model%n_elements)], [(reaches(e), e=1, model%n_elements)])
    n = size(inside)
    tip%disc%element = inside
    allocate (tip%disc%area(n), tip%disc%of_stress(3, 2, n), tip%disc%of_gradient(2, 2, n), tip%disc%of_force(2, 2, n), &
              source=0.0_dp)
    change = in_axes(tip%disc%direction, tip%disc%direction(2)*gradient(:, model%elements%material(tip%element)))
    tip%disc%of_start = 0.0_dp
    do i = 1, n
      e = inside(i)
      associate (own => corner(first(e):first(e + 1) - 1))
        if (allocated(model%sampling)) then
          call add_point(i, place_of_cell(model, e), model%sampling%area(e))
        else
          ears = ears_of(model%start(:, own))
          do k = 1, size(ears, 2)
            call add_triangle(i, model%start(:, own(ears(:, k))))
          end do
        end if
        do k = 1, size(own)
          associate (next => own(modulo(k, size(own)) + 1))
            if (joint_between(model%elements%shape, e, own(k), next) > 0) &
              call add_face(i, model%start(:, own(k)), model%start(:, next))
          end associate
        end do
      end associate
    end do

  contains

    !> Whether an element may lie in the disc.
    pure logical function reaches(e)
      integer, intent(in) :: e
      real(dp) :: low(2), high(2)

      reaches = model%elements%block(e) == tip%block
      if (.not. reaches) return
      if (allocated(model%sampling)) then
        reaches = model%sampling%area(e) > 0
        if (.not. reaches) return
      end if
      associate (own => corner(first(e):first(e + 1) - 1))
        low = minval(model%start(:, own), 2)
        high = maxval(model%start(:, own), 2)
      end associate
      reaches = norm2(max(low - tip%disc%place, tip%disc%place - high, 0.0_dp)) < radius
    end function reaches

    !> Adds the area of a triangle of an element, by 64 points.
    subroutine add_triangle(i, x)
      integer, intent(in) :: i                    !! element of the disc
      real(dp), intent(in) :: x(2, 3)             !! length
      real(dp) :: area
      integer :: k, l

      area = 0.5_dp*twice_area(x)
      do k = 1, n_gauss
        do l = 1, n_gauss
          spread_of = [1 - gauss_place(k), gauss_place(k)*(1 - gauss_place(l)), gauss_place(k)*gauss_place(l)]
          call add_point(i, matmul(x, spread_of), 2*area*gauss_place(k)*gauss_weight(k)*gauss_weight(l))
        end do
      end do
    end subroutine add_triangle

    !> Adds what a point stands for.
    subroutine add_point(i, place, area)
      integer, intent(in) :: i
      real(dp), intent(in) :: place(2), area      !! length, length^2
      type(near_tip_field_t) :: field
      complex(dp) :: root
      real(dp) :: q, g(2)
      integer :: mode

      associate (disc => tip%disc)
        disc%area(i) = disc%area(i) + area
        call weight_at(tip, place, q, g)
        if (.not. q > 0) return
        root = root_at(tip, place)
        do mode = 1, 2
          field = singular_field(mode, root, disc%shear, disc%kappa)
          associate (s => field%stress, e => field%strain, v => field%slope)
            disc%of_stress(:, mode, i) = disc%of_stress(:, mode, i) &
              + area*[v(1)*g(1) - e(1)*g(1), v(2)*g(2) - e(2)*g(1), v(1)*g(2) + v(2)*g(1) - e(3)*g(1)]
            disc%of_gradient(:, mode, i) = disc%of_gradient(:, mode, i) + area*[s(1)*g(1) + s(3)*g(2), s(3)*g(1) + s(2)*g(2)]
            disc%of_force(:, mode, i) = disc%of_force(:, mode, i) + area*q*v
            disc%of_start(mode) = disc%of_start(mode) - area*q*dot_product(change, e)
          end associate
        end do
      end associate
    end subroutine add_point

    !> Adds a face of an element where it is not on the line of the tip: there the field of the mode has tractions. The piece of the
    !> crack ahead of the centre does not count.
    subroutine add_face(i, a, b)
      integer, intent(in) :: i
      real(dp), intent(in) :: a(2), b(2)          !! ends, counter-clockwise around the element, length
      type(near_tip_field_t) :: field
      real(dp) :: n(2), outer(2), q, g(2), length, place(2)
      integer :: k, mode

      associate (along => tip%disc%direction, from => tip%disc%place)
        if (max(abs(cross(along, a - from)), abs(cross(along, b - from))) < straight*radius) return
        if (max(norm2(a - from), norm2(b - from)) < (1 + straight)*ahead .and. dot_product(along, a + b - 2*from) > 0) return
      end associate
      length = norm2(b - a)
      outer = [b(2) - a(2), a(1) - b(1)]/length
      n = [dot_product(tip%disc%direction, outer), cross(tip%disc%direction, outer)]
      do k = 1, n_gauss
        place = a + gauss_place(k)*(b - a)
        call weight_at(tip, place, q, g)
        if (.not. q > 0) cycle
        q = q*length*gauss_weight(k)
        do mode = 1, 2
          field = field_at(tip, mode, place, -outer)
          associate (s => field%stress, disc => tip%disc)
            disc%of_gradient(:, mode, i) = disc%of_gradient(:, mode, i) - q*[s(1)*n(1) + s(3)*n(2), s(3)*n(1) + s(2)*n(2)]
            disc%of_stress(:, mode, i) = disc%of_stress(:, mode, i) + q*n(1)*field%strain
          end associate
        end do
      end do
    end subroutine add_face

  end subroutine lay_disc

  !> Place of the point of a cell of second order at the start, length: an affine function of its vertices, as of its covers' nodes.
  pure function place_of_cell(model, e) result(place)
    type(model_t), intent(in) :: model
    integer, intent(in) :: e
    real(dp) :: place(2)
    real(dp) :: a(2), b(2), weight(2, 0:3), x(2), det
    integer :: k, v

    v = model%elements%shape%first_vertex(model%elements%shape%first_loop(e)) - 1
    weight(:, 0) = linear(model%sampling%value(:, e))
    do k = 1, 3
      weight(:, k) = linear(model%sampling%at_vertex(:, v + k))
    end do
    a = weight(:, 2) - weight(:, 1)
    b = weight(:, 3) - weight(:, 1)
    x = weight(:, 0) - weight(:, 1)
    det = cross(a, b)
    place = model%start(:, v + 1) + cross(x, b)/det*(model%start(:, v + 2) - model%start(:, v + 1)) &
            + cross(a, x)/det*(model%start(:, v + 3) - model%start(:, v + 1))

  contains

    !> Linear weights of the first two nodes, from those of six covers: an edge counts half to each of its ends.
    pure function linear(six)
      real(dp), intent(in) :: six(6)
      real(dp) :: linear(2)

      linear = [six(1) + 0.5_dp*(six(4) + six(6)), six(2) + 0.5_dp*(six(4) + six(5))]
    end function linear

  end function place_of_cell

  !> The function q at a place and its gradient in the axes of the tip: 1 near the tip, 0 at the radius, of fifth degree between.
  pure subroutine weight_at(tip, place, q, gradient)
    type(crack_tip_t), intent(in) :: tip
    real(dp), intent(in) :: place(2)       !! length
    real(dp), intent(out) :: q
    real(dp), intent(out) :: gradient(2)   !! 1/length
    real(dp) :: from(2), r, s

    from = place - tip%disc%place
    r = norm2(from)
    q = fall(r, tip%disc%radius)
    gradient = 0.0_dp
    s = (r/tip%disc%radius - flat_share)/(1 - flat_share)
    if (s > 0 .and. s < 1) then
      gradient = -30*s**2*(1 - s)**2/((1 - flat_share)*tip%disc%radius*r) &
                 *[dot_product(tip%disc%direction, from), cross(tip%disc%direction, from)]
    end if
  end subroutine weight_at

  !> A function that falls from 1 near a tip to 0 at a radius.
  pure real(dp) function fall(r, radius)
    real(dp), intent(in) :: r, radius      !! length
    real(dp) :: s

    s = max(0.0_dp, min(1.0_dp, (r/radius - flat_share)/(1 - flat_share)))
    fall = 1 - s**3*(10 - 15*s + 6*s**2)
  end function fall

  !> The field of a mode with K = 1 at a place of the start, in the axes of the tip.
  pure type(near_tip_field_t) function field_at(tip, mode, place, behind) result(field)
    type(crack_tip_t), intent(in) :: tip
    integer, intent(in) :: mode
    real(dp), intent(in) :: place(2)               !! not the tip, length
    real(dp), intent(in), optional :: behind(2)    !! of a face: direction from it into the block, of length 1

    field = singular_field(mode, root_at(tip, place, behind), tip%disc%shear, tip%disc%kappa)
  end function field_at

  !> Root of the place as a complex number from the tip, in the axes of the tip: r^(1/2) e^(i angle/2), length^(1/2). Its cut is the
  !> crack.
  pure complex(dp) function root_at(tip, place, behind) result(root)
    type(crack_tip_t), intent(in) :: tip
    real(dp), intent(in) :: place(2)               !! not the tip, length
    real(dp), intent(in), optional :: behind(2)    !! of a face: direction from it into the block, of length 1
    real(dp) :: from(2), angle, r

    from = place - tip%disc%place
    r = norm2(from)
    if (present(behind)) from = from + inward*tip%disc%radius*behind
    angle = atan2(cross(tip%disc%direction, from), dot_product(tip%disc%direction, from))
    associate (cut => angle_of_crack(tip, r))
      if (angle > cut) angle = angle - 2*pi
      if (angle < cut - 2*pi) angle = angle + 2*pi
    end associate
    root = sqrt(r)*exp(cmplx(0.0_dp, 0.5_dp*angle, dp))
  end function root_at

  !> Angle from 0 to 2 pi at which the crack leaves a circle about its tip, rad: pi on its last piece.
  pure real(dp) function angle_of_crack(tip, r) result(angle)
    type(crack_tip_t), intent(in) :: tip
    real(dp), intent(in) :: r                      !! length
    real(dp) :: a(2), along(2), share
    integer :: k, n

    n = size(tip%disc%path, 2)
    do k = 2, n - 1
      if (norm2(tip%disc%path(:, k) - tip%disc%place) >= r) exit
    end do
    angle = pi
    if (k == 2) return
    a = tip%disc%path(:, k - 1) - tip%disc%place
    along = tip%disc%path(:, k) - tip%disc%path(:, k - 1)
    associate (p => dot_product(a, along), c => dot_product(along, along))
      share = min(1.0_dp, (-p + sqrt(max(0.0_dp, p**2 - c*(dot_product(a, a) - r**2))))/c)
    end associate
    a = a + share*along
    angle = atan2(cross(tip%disc%direction, a), dot_product(tip%disc%direction, a))
    if (angle < 0) angle = angle + 2*pi
  end function angle_of_crack

  !> Components of a symmetric tensor (xx, yy, xy) in axes of which the first has a direction.
  pure function in_axes(direction, tensor) result(turned)
    real(dp), intent(in) :: direction(2), tensor(3)
    real(dp) :: turned(3)

    associate (c => direction(1), s => direction(2))
      turned = [c**2*tensor(1) + s**2*tensor(2) + 2*c*s*tensor(3), s**2*tensor(1) + c**2*tensor(2) - 2*c*s*tensor(3), &
                c*s*(tensor(2) - tensor(1)) + (c**2 - s**2)*tensor(3)]
    end associate
  end function in_axes

  !> The third component of a vector product.
  pure real(dp) function cross(a, b)
    real(dp), intent(in) :: a(2), b(2)

    cross = a(1)*b(2) - a(2)*b(1)
  end function cross

end module scree_tip_disc
