!> Random numbers that are the same on every compiler: splitmix64, in integers modulo 2^64.
!>
!> G. L. Steele, D. Lea, C. H. Flood, *Fast splittable pseudorandom number generators* (OOPSLA 2014), with the constants of
!> S. Vigna's splitmix64.c. Sums and products modulo 2^64 are made of halves that fit, so that nothing overflows.
module scree_random_numbers
  use scree_kinds, only: dp, i8
  implicit none
  private
  public :: next_random, next_uniform, random_t, split_random

  !> A stream of random numbers: its seed, then wherever it is.
  type :: random_t
    integer(i8) :: state = 0_i8
  end type random_t

  integer(i8), parameter :: low_half = int(z'FFFFFFFF', i8), low_quarter = int(z'FFFF', i8)
  ! the constants in halves, as the whole of one is beyond the range of a signed integer
  integer(i8), parameter :: golden_ratio = ior(ishft(int(z'9E3779B9', i8), 32), int(z'7F4A7C15', i8))
  integer(i8), parameter :: mix_1 = ior(ishft(int(z'BF58476D', i8), 32), int(z'1CE4E5B9', i8))
  integer(i8), parameter :: mix_2 = ior(ishft(int(z'94D049BB', i8), 32), int(z'133111EB', i8))

contains

  !> Next 64 random bits.
  pure subroutine next_random(random, bits)
    type(random_t), intent(inout) :: random
    integer(i8), intent(out) :: bits

    random%state = sum_modulo(random%state, golden_ratio)
    bits = random%state
    bits = product_modulo(ieor(bits, ishft(bits, -30)), mix_1)
    bits = product_modulo(ieor(bits, ishft(bits, -27)), mix_2)
    bits = ieor(bits, ishft(bits, -31))
  end subroutine next_random

  !> Next number of a uniform law: one of the 2^53 multiples of 2^-53 in [0, 1), exactly.
  pure subroutine next_uniform(random, u)
    type(random_t), intent(inout) :: random
    real(dp), intent(out) :: u
    integer(i8) :: bits

    call next_random(random, bits)
    u = scale(real(ishft(bits, -11), dp), -53)
  end subroutine next_uniform

  !> A stream of its own, seeded by the next number of this one.
  pure subroutine split_random(random, own)
    type(random_t), intent(inout) :: random
    type(random_t), intent(out) :: own

    call next_random(random, own%state)
  end subroutine split_random

  !> a + b modulo 2^64.
  pure integer(i8) function sum_modulo(a, b)
    integer(i8), intent(in) :: a, b
    integer(i8) :: low, high

    low = iand(a, low_half) + iand(b, low_half)
    high = ishft(a, -32) + ishft(b, -32) + ishft(low, -32)
    sum_modulo = ior(ishft(high, 32), iand(low, low_half))
  end function sum_modulo

  !> a b modulo 2^64: the halves of a times the quarters of b.
  pure integer(i8) function product_modulo(a, b)
    integer(i8), intent(in) :: a, b
    integer(i8) :: quarter, part
    integer :: k

    product_modulo = 0_i8
    do k = 0, 48, 16
      quarter = iand(ishft(b, -k), low_quarter)
      part = sum_modulo(iand(a, low_half)*quarter, ishft(ishft(a, -32)*quarter, 32))
      product_modulo = sum_modulo(product_modulo, ishft(part, k))
    end do
  end function product_modulo

end module scree_random_numbers
