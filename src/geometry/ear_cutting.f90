!> Polygons cut up into triangles.
module scree_ear_cutting
  use scree_kinds, only: dp
  use scree_polygon, only: twice_area
  use scree_predicates, only: orientation
  implicit none
  private
  public :: ears_of

contains

  !> Triangles of a polygon, counter-clockwise: its corners are cut off one by one, the best triangle first.
  pure function ears_of(x) result(triangle)
    real(dp), intent(in) :: x(:, :)            !! (2, n) counter-clockwise; holes are joined to the outline, length
    integer, allocatable :: triangle(:, :)     !! (3, m) corners
    integer :: all_of_them(3, size(x, 2)), ear, i, m, n
    integer, allocatable :: left(:)

    n = 0
    left = [(i, i=1, size(x, 2))]
    do while (size(left) >= 3)
      m = size(left)
      ear = best_ear(x(:, left))
      associate (three => left([modulo(ear - 2, m) + 1, ear, modulo(ear, m) + 1]))
        if (twice_area(x(:, three)) > 0) then
          n = n + 1
          all_of_them(:, n) = three
        end if
      end associate
      left = [left(:ear - 1), left(ear + 1:)]
    end do
    triangle = all_of_them(:, :n)
  end function ears_of

  !> The corner of a polygon that is to be cut off first: one on a straight edge, as that makes no triangle, else the one with the
  !> best triangle that holds no other corner.
  pure integer function best_ear(x) result(best)
    real(dp), intent(in) :: x(:, :)     !! (2, n) counter-clockwise, length
    real(dp), parameter :: flat = 1e-12_dp !! twice the area over the longest edge squared: no triangle
    real(dp) :: most, three(2, 3), quality
    integer :: i, n

    n = size(x, 2)
    best = 1
    most = -huge(most)
    do i = 1, n
      three = x(:, [modulo(i - 2, n) + 1, i, modulo(i, n) + 1])
      quality = twice_area(three)/max(maxval(sum((three - three(:, [2, 3, 1]))**2, 1)), tiny(most))
      if (abs(quality) < flat) then
        best = i
        return
      end if
      if (quality <= most) cycle
      if (quality > 0) then
        if (any_inside(x, three)) cycle
      end if
      most = quality
      best = i
    end do
  end function best_ear

  !> Whether any corner of a polygon lies in a triangle of three of them, or on its edges, and is not one of its corners.
  pure logical function any_inside(x, three)
    real(dp), intent(in) :: x(:, :)     !! (2, n)
    real(dp), intent(in) :: three(2, 3) !! counter-clockwise
    integer :: i, k

    any_inside = .true.
    do i = 1, size(x, 2)
      if (any(all(abs(three - spread(x(:, i), 2, 3)) <= 0, 1))) cycle
      if (all([(orientation(three(:, k), three(:, modulo(k, 3) + 1), x(:, i)) >= 0, k=1, 3)])) return
    end do
    any_inside = .false.
  end function any_inside

end module scree_ear_cutting
