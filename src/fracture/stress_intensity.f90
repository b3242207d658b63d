!> Stress intensity factors of the tips of cracks, by the interaction integral over the discs around them (`scree_tip_disc`).
!>
!> The integral is one of small strains in the axes of a body that may have turned. R is the mean rotation of the disc since the
!> start. The displacement gradient is that of R^T F - I, the stress is R^T s R, and all forces are turned back by R^T. So K does
!> not change when everything turns.
module scree_stress_intensity
  use scree_contact_geometry, only: frame_of_edge
  use scree_contacts, only: contact_t, entrance_t, state_open
  use scree_crack_tip, only: crack_tip_t
  use scree_edge_load, only: load_at_ends
  use scree_kinds, only: dp
  use scree_model, only: cache_t, model_t
  use scree_near_tip_field, only: near_tip_field_t
  use scree_state, only: state_t
  use scree_system, only: values_of
  use scree_time_table, only: ramp_at, value_at
  use scree_tip_disc, only: fall, field_at, gauss_place, gauss_weight, n_gauss, weight_at
  implicit none
  private
  public :: place_of_tip, stress_intensity

  real(dp), parameter :: scatter = 5.0_dp !! sides of triangles from the tip, within which the forces of contacts scatter
  real(dp), parameter :: at_tip = 1e-6_dp !! of the radius of the disc: a vertex that is nearer to the tip is at it
  real(dp), parameter :: on_face = 1e-9_dp !! of the radius: a centre that is nearer to the line of a face is on it

contains

  !> K_I and K_II of a tip whose disc is laid, force/length^(3/2).
  !>
  !> Faces bear their contacts and the loads on edges. Body forces are weight, the moving ground, mass damping and inertia. Point
  !> loads, bolts and supports in the disc are not counted.
  pure function stress_intensity(model, cache, state, tip) result(K)
    type(model_t), intent(in) :: model
    type(cache_t), intent(in) :: cache
    type(state_t), intent(in) :: state
    type(crack_tip_t), intent(in) :: tip
    real(dp) :: K(2)
    real(dp) :: axes(2, 2), force(2), gradient(2), stress(3)
    integer :: e, i, mode

    axes = axes_of_tip(state, tip)
    K = tip%disc%of_start
    do i = 1, size(tip%disc%element)
      e = tip%disc%element(i)
      stress = stress_in(axes, state%stress(:, e))
      gradient = matmul(state%deformation(1:2, e)*tip%disc%direction(1) + state%deformation(3:4, e)*tip%disc%direction(2), axes) &
                 - [1.0_dp, 0.0_dp]
      force = matmul(lost_force(e)/tip%disc%area(i), axes)
      do mode = 1, 2
        K(mode) = K(mode) + dot_product(tip%disc%of_stress(:, mode, i), stress) &
                  + dot_product(tip%disc%of_gradient(:, mode, i), gradient) + dot_product(tip%disc%of_force(:, mode, i), force)
      end do
    end do
    if (allocated(model%effects%contact)) then
      call add_contacts(model, state, tip, axes, state%contacts%contact, K)
      if (allocated(state%sleep)) call add_contacts(model, state, tip, axes, state%sleep%contact, K)
    end if
    if (allocated(model%effects%edge_load)) call add_edge_loads(model, state, tip, axes, K)
    K = 0.5_dp*tip%disc%modulus*K

  contains

    !> Mass times acceleration of an element less its body forces, per unit thickness.
    pure function lost_force(e) result(force)
      integer, intent(in) :: e
      real(dp) :: force(2), rates(2)

      associate (effects => model%effects, T => cache%element(e)%kinematics%at_centroid, mass => model%elements%mass(e))
        rates = matmul(T, values_of(model%elements, e, state%acceleration))
        if (allocated(effects%mass_damping)) &
          rates = rates + effects%mass_damping%rate*matmul(T, values_of(model%elements, e, state%velocity))
        if (allocated(effects%base_acceleration)) rates = rates + value_at(effects%base_acceleration%record, state%time)
        force = mass*rates
        if (allocated(effects%gravity)) &
          force(2) = force(2) + ramp_at(effects%gravity%ramp, state%time)*effects%gravity%weight(e)
      end associate
    end function lost_force

  end function stress_intensity

  !> Where a tip is now: its place moves with the element that holds it, length.
  pure function place_of_tip(model, state, tip) result(place)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(crack_tip_t), intent(in) :: tip
    real(dp) :: place(2), from(2)
    integer :: v

    v = model%elements%shape%first_vertex(model%elements%shape%first_loop(tip%element))
    from = tip%place - model%start(:, v)
    place = state%vertex(:, v) + state%deformation(1:2, tip%element)*from(1) + state%deformation(3:4, tip%element)*from(2)
  end function place_of_tip

  !> Axes of a tip as they stand, in columns: those of the start, turned by the mean rotation of the disc.
  pure function axes_of_tip(state, tip) result(axes)
    type(state_t), intent(in) :: state
    type(crack_tip_t), intent(in) :: tip
    real(dp) :: axes(2, 2), c, s
    integer :: i

    c = 0.0_dp
    s = 0.0_dp
    do i = 1, size(tip%disc%element)
      associate (F => state%deformation(:, tip%disc%element(i)))
        c = c + tip%disc%area(i)*(F(1) + F(4))
        s = s + tip%disc%area(i)*(F(2) - F(3))
      end associate
    end do
    associate (along => tip%disc%direction)
      axes(:, 1) = [c*along(1) - s*along(2), s*along(1) + c*along(2)]/norm2([c, s])
    end associate
    axes(:, 2) = [-axes(2, 1), axes(1, 1)]
  end function axes_of_tip

  !> Components xx, yy, xy of a stress in axes given in columns.
  pure function stress_in(axes, stress) result(turned)
    real(dp), intent(in) :: axes(2, 2), stress(3)
    real(dp) :: turned(3), along(2), across(2)

    along = [stress(1)*axes(1, 1) + stress(3)*axes(2, 1), stress(3)*axes(1, 1) + stress(2)*axes(2, 1)]
    across = [stress(1)*axes(1, 2) + stress(3)*axes(2, 2), stress(3)*axes(1, 2) + stress(2)*axes(2, 2)]
    turned = [dot_product(axes(:, 1), along), dot_product(axes(:, 2), across), dot_product(axes(:, 2), along)]
  end function stress_in

  !> Adds the forces of contacts on the faces in the disc.
  !>
  !> Beside the tip the forces of contacts scatter as the singular stress of an element does, and they count as r^(-1/2). So where
  !> the crack touches itself there, the mean traction of the contacts farther away takes their place.
  pure subroutine add_contacts(model, state, tip, axes, contact, K)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(crack_tip_t), intent(in) :: tip
    real(dp), intent(in) :: axes(2, 2)
    type(contact_t), intent(in) :: contact(:)
    real(dp), intent(inout) :: K(2)               !! over half the modulus
    real(dp), dimension(2, size(contact)) :: force, shift !! on the block of the vertex; to where it acts on the other side
    real(dp), dimension(size(contact)) :: q, near, side   !! weights of disc and neighbourhood; 1 on the left face of the crack
    real(dp) :: core, length, traction(2)
    logical :: own(size(contact)), touches(2, size(contact))
    integer :: i

    core = min(scatter*tip%edge, 0.5_dp*tip%disc%radius)
    do i = 1, size(contact)
      associate (entrance => contact(i)%entrance(contact(i)%active))
        touches(:, i) = model%outlines%block([entrance%vertex, entrance%edge]) == tip%block .and. entrance%state /= state_open
        force(:, i) = 0.0_dp
        shift(:, i) = 0.0_dp
        q(i) = 0.0_dp
        near(i) = 0.0_dp
        side(i) = 0.0_dp
        if (any(touches(:, i))) call place_contact(contact(i), entrance, force(:, i), shift(:, i), q(i), near(i), side(i))
      end associate
    end do
    own = touches(1, :) .and. touches(2, :) .and. q > 0
    if (any(own .and. near > 0.5_dp) .and. any(own .and. near < 0.5_dp)) then
      call measure_face(tip, core, length)
      traction = [(sum(q*(1 - near)*side*force(i, :), mask=own), i=1, 2)]/length
      call add_core(tip, core, traction, K)
      do i = 1, size(contact)
        if (own(i)) force(:, i) = (1 - near(i))*force(:, i)
      end do
    end if
    do i = 1, size(contact)
      associate (vertex => contact(i)%entrance(contact(i)%active)%vertex)
        if (touches(1, i)) call add_force(vertex, [0.0_dp, 0.0_dp], 1, force(:, i), K)
        if (touches(2, i)) call add_force(vertex, shift(:, i), -1, -force(:, i), K)
      end associate
    end do

  contains

    !> Finds where a contact is at the start, and its force now.
    pure subroutine place_contact(contact, entrance, force, shift, q, near, side)
      type(contact_t), intent(in) :: contact
      type(entrance_t), intent(in) :: entrance    !! that acts
      real(dp), intent(out) :: force(2), shift(2), q, near, side
      real(dp) :: a(2), along(2), edge, normal(2), t(2), x(2)

      associate (outlines => model%outlines, start => model%start)
        a = state%vertex(:, outlines%start(entrance%edge))
        call frame_of_edge(a, state%vertex(:, outlines%finish(entrance%edge)), t, normal, edge)
        force = matmul(contact%force(1)*normal + contact%force(2)*t, axes)
        x = start(:, outlines%start(entrance%vertex))
        shift = start(:, outlines%start(entrance%edge)) - x + dot_product(state%vertex(:, outlines%start(entrance%vertex)) - a, t) &
                /edge*(start(:, outlines%finish(entrance%edge)) - start(:, outlines%start(entrance%edge)))
        along = start(:, outlines%start(outlines%next(entrance%vertex))) - x
        side = sign(1.0_dp, dot_product(tip%disc%direction, along)) ! the block is left of its edges
        near = fall(norm2(x - tip%disc%place), core)
        q = fall(norm2(x - tip%disc%place), tip%disc%radius)
      end associate
    end subroutine place_contact

    !> Adds the force of a contact at a vertex, as a traction that falls linearly to 0 at the vertices beside it. To the tip, which
    !> has no contact, it stays as it is at the vertex beside it.
    pure subroutine add_force(vertex, shift, side, force, K)
      integer, intent(in) :: vertex
      real(dp), intent(in) :: shift(2)            !! where it acts, from the vertex, length
      integer, intent(in) :: side                 !! 1: on the block of the vertex; -1: on the other side of its edges
      real(dp), intent(in) :: force(2)            !! in the axes of the tip, per unit thickness
      real(dp), intent(inout) :: K(2)
      real(dp) :: along(2, 2), at(2)

      at = model%start(:, model%outlines%start(vertex)) + shift
      along(:, 1) = model%start(:, model%outlines%start(model%outlines%previous(vertex))) - at + shift
      along(:, 2) = model%start(:, model%outlines%start(model%outlines%next(vertex))) - at + shift
      call add_half(at, along(:, 1), [along(2, 1), -along(1, 1)]*side, 2*force/sum(norm2(along, 1)), K)
      call add_half(at, along(:, 2), [-along(2, 2), along(1, 2)]*side, 2*force/sum(norm2(along, 1)), K)
    end subroutine add_force

    !> Adds the traction of one side of a vertex.
    pure subroutine add_half(at, along, behind, traction, K)
      real(dp), intent(in) :: at(2), along(2)     !! the vertex, and the way to the next, length
      real(dp), intent(in) :: behind(2)           !! direction from the face into the block
      real(dp), intent(in) :: traction(2)         !! at the vertex, in the axes of the tip, force/length^2
      real(dp), intent(inout) :: K(2)
      type(near_tip_field_t) :: field
      real(dp) :: g(2), place(2), q, share(n_gauss), weight(n_gauss)
      integer :: i, mode

      if (.not. norm2(along) > 0) return
      call place_points(tip, at, along, share, weight)
      weight = weight*norm2(along)
      if (norm2(at + along - tip%place) > at_tip*tip%disc%radius) weight = (1 - share)*weight
      do i = 1, n_gauss
        place = at + share(i)*along
        call weight_at(tip, place, q, g)
        if (.not. q > 0) cycle
        do mode = 1, 2
          field = field_at(tip, mode, place, behind/norm2(behind))
          K(mode) = K(mode) - weight(i)*q*dot_product(traction, field%slope)
        end do
      end do
    end subroutine add_half

  end subroutine add_contacts

  !> Length of a face in the disc, weighted as the contacts beyond the core.
  pure subroutine measure_face(tip, core, length)
    type(crack_tip_t), intent(in) :: tip
    real(dp), intent(in) :: core                  !! radius, length
    real(dp), intent(out) :: length
    real(dp) :: place(2)
    integer :: i, k, l
    integer, parameter :: parts = 8

    length = 0.0_dp
    associate (path => tip%disc%path)
      do k = 2, size(path, 2)
        do l = 1, parts
          do i = 1, n_gauss
            place = path(:, k - 1) + (l - 1 + gauss_place(i))/parts*(path(:, k) - path(:, k - 1)) - tip%disc%place
            length = length + gauss_weight(i)/parts*norm2(path(:, k) - path(:, k - 1)) &
                     *fall(norm2(place), tip%disc%radius)*(1 - fall(norm2(place), core))
          end do
        end do
      end do
    end associate
  end subroutine measure_face

  !> Adds a constant traction on both faces near the tip.
  pure subroutine add_core(tip, core, traction, K)
    type(crack_tip_t), intent(in) :: tip
    real(dp), intent(in) :: core                  !! radius within which it acts, length
    real(dp), intent(in) :: traction(2)           !! on the left face, in the axes of the tip, force/length^2
    real(dp), intent(inout) :: K(2)               !! over half the modulus
    type(near_tip_field_t) :: field
    real(dp) :: along(2), left(2), place(2), q, share(n_gauss), weight(n_gauss)
    integer :: i, l, mode, side

    do l = 2, size(tip%disc%path, 2)
      along = tip%disc%path(:, l) - tip%disc%path(:, l - 1)
      along = min(1.0_dp, core/norm2(along))*along
      left = [along(2), -along(1)]/norm2(along)   ! of the crack on the way to the tip
      call place_points(tip, tip%disc%path(:, l - 1), along, share, weight)
      do i = 1, n_gauss
        place = tip%disc%path(:, l - 1) + share(i)*along
        q = norm2(along)*weight(i)*fall(norm2(place - tip%disc%place), core)
        if (.not. q > 0) cycle
        do mode = 1, 2
          do side = -1, 1, 2
            field = field_at(tip, mode, place, side*left)
            K(mode) = K(mode) - q*side*dot_product(traction, field%slope)
          end do
        end do
      end do
    end do
  end subroutine add_core

  !> Adds pressure and traction on the edges in the disc, linear along each.
  pure subroutine add_edge_loads(model, state, tip, axes, K)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(crack_tip_t), intent(in) :: tip
    real(dp), intent(in) :: axes(2, 2)
    real(dp), intent(inout) :: K(2)               !! over half the modulus
    type(near_tip_field_t) :: field
    real(dp) :: along(2), g(2), load(2, 2), place(2), q, share(n_gauss), weight(n_gauss)
    integer :: i, j, mode

    associate (loads => model%effects%edge_load)
      do i = 1, size(loads%point, 2)
        if (model%elements%block(model%points%element(loads%point(1, i))) /= tip%block) cycle
        along = model%start_point(:, loads%point(2, i)) - model%start_point(:, loads%point(1, i))
        load = load_at_ends(loads, i, state%point(:, loads%point(2, i)) - state%point(:, loads%point(1, i)))
        load = ramp_at(loads%ramp, state%time)*matmul(transpose(axes), load)
        call place_points(tip, model%start_point(:, loads%point(1, i)), along, share, weight)
        do j = 1, n_gauss
          place = model%start_point(:, loads%point(1, i)) + share(j)*along
          call weight_at(tip, place, q, g)
          if (.not. q > 0) cycle
          do mode = 1, 2
            field = field_at(tip, mode, place, [-along(2), along(1)]/norm2(along))
            K(mode) = K(mode) - weight(j)*q*dot_product((1 - share(j))*load(:, 1) + share(j)*load(:, 2), field%slope)
          end do
        end do
      end do
    end associate
  end subroutine add_edge_loads

  !> Points of a face, which are dense toward its end that is nearer to the tip: a traction there times r^(-1/2) is integrated
  !> exactly. Of a face through the centre of the disc only the part behind counts, as ahead the two faces of a crack cancel.
  pure subroutine place_points(tip, from, along, share, weight)
    type(crack_tip_t), intent(in) :: tip
    real(dp), intent(in) :: from(2), along(2)     !! where the face begins, and to where it ends, length
    real(dp), intent(out) :: share(n_gauss)       !! of the way
    real(dp), intent(out) :: weight(n_gauss)
    real(dp) :: at(2), dense, sparse              ! shares of the ends of the part that counts

    dense = merge(1.0_dp, 0.0_dp, norm2(from + along - tip%disc%place) < norm2(from - tip%disc%place))
    sparse = 1 - dense
    at = tip%disc%place - from
    associate (reach => dot_product(at, along)/dot_product(along, along))
      if (reach > 0 .and. reach < 1 .and. norm2(at - reach*along) < on_face*tip%disc%radius) then
        dense = reach
        sparse = merge(0.0_dp, 1.0_dp, dot_product(along, tip%disc%direction) > 0)
      end if
    end associate
    share = dense + (sparse - dense)*gauss_place**2
    weight = 2*abs(sparse - dense)*gauss_place*gauss_weight
  end subroutine place_points

end module scree_stress_intensity
