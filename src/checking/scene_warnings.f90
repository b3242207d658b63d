!> Numbers of a scene that are likely mistakes, whatever its blocks are: strengths, units, loads that end before the run.
module scree_scene_warnings
  use scree_kinds, only: dp
  use scree_likely_units, only: doubt_of_strength, doubt_of_water, least_strength_of_walls
  use scree_scene, only: scene_t, stage_t, time_table_t
  use scree_text, only: append, number_text, pair_text, rounded_text, short_text, text_t
  implicit none
  private
  public :: warnings_of_scene

  real(dp), parameter :: same_time = 1e-9_dp !! of the end of the run: rounding of n5 steps
  real(dp), parameter :: zone_edges = 4.0_dp !! edges that resolve the zone in which a bond softens
  real(dp), parameter :: at_rest = 1e-3_dp   !! of the largest value of a record: where it ends, it has died out

contains

  !> One line a mistake.
  pure function warnings_of_scene(scene, block_material, joint_material) result(warning)
    type(scene_t), intent(in) :: scene
    integer, intent(in) :: block_material(:) !! numbers of those that blocks are made of
    integer, intent(in) :: joint_material(:) !! numbers of those of edges that may touch
    type(text_t), allocatable :: warning(:)
    integer :: i, j

    allocate (warning(0))
    do i = 1, size(joint_material)
      j = joint_material(i)
      call add_doubts(j)
    end do
    if (allocated(scene%settings%water_table)) &
      call add('water: ', doubt_of_water(scene%settings%water_weight, scene%block_material(block_material)%unit_weight))
    call add_ends_of_tables()
    call add_ends_of_records(scene%stage_t, '')
    do i = 1, size(scene%later)
      call add_ends_of_records(scene%later(i), ' of stage '//number_text(i + 1))
    end do

  contains

    !> Adds a line where there is something to say.
    pure subroutine add(where, line)
      character(len=*), intent(in) :: where, line

      if (len(line) > 0) call append(warning, where//line)
    end subroutine add

    !> Adds what is strange about the strength of a joint material.
    pure subroutine add_doubts(j)
      integer, intent(in) :: j
      character(len=:), allocatable :: where

      where = 'joint material '//number_text(j)//': '
      associate (joint => scene%joint_material(j), s => scene%settings, rock => scene%block_material(block_material))
        if (allocated(s%worn_angle)) call add(where, doubt_of_residual('friction angle', joint%friction_angle, s%worn_angle(j)))
        if (allocated(s%worn_cohesion) .and. max(joint%cohesion, joint%tensile_strength) > 0) &
          call add(where, doubt_of_residual('cohesion', joint%cohesion, s%worn_cohesion(j)))
        if (allocated(s%joint_energy)) &
          call add(where, doubt_of_energy(s%joint_energy(j), joint%tensile_strength, own_stiffness(j), &
                                          s%cover_edge, minval(rock%young)))
        if (abs(joint%cohesion - joint%tensile_strength) > 0) then ! else a bond that is to hold, whatever comes
          call add(where, doubt_of_strength('cohesion', joint%cohesion, rock, scene%extent))
          call add(where, doubt_of_strength('tensile strength', joint%tensile_strength, rock, scene%extent))
        end if
        if (allocated(s%jcs)) call add(where, doubt_of_strength('strength of the walls (jcs)', s%jcs(j), rock, scene%extent, &
                                                                least_strength_of_walls))
      end associate
    end subroutine add_doubts

    !> Normal stiffness of its own of a joint material; 0: it has none, force/length^3.
    pure real(dp) function own_stiffness(j)
      integer, intent(in) :: j

      own_stiffness = 0.0_dp
      if (allocated(scene%settings%joint_kn)) own_stiffness = scene%settings%joint_kn(j)
    end function own_stiffness

    !> Adds the tables of fixed and load points that still change where they end.
    pure subroutine add_ends_of_tables()
      real(dp) :: end_time
      integer :: i

      end_time = scene%settings%end_time
      do i = 1, size(scene%later)
        end_time = end_time + min(scene%later(i)%settings%end_time, huge(end_time) - end_time)
      end do
      do i = 1, size(scene%fixed_table)
        call add('fixed point '//number_text(i)//': ', end_of(scene%fixed_table(i), end_time, 'a displacement'))
      end do
      do i = 1, size(scene%load_table)
        call add('load point '//number_text(i)//': ', end_of(scene%load_table(i), end_time, 'a force'))
      end do
    end subroutine add_ends_of_tables

    !> Adds the records of a stage that end with what has not died out.
    pure subroutine add_ends_of_records(stage, of_stage)
      class(stage_t), intent(in) :: stage
      character(len=*), intent(in) :: of_stage

      call add('acceleration of the ground'//of_stage//': ', end_of(stage%ground, stage%settings%end_time, 'an acceleration'))
      call add('wave'//of_stage//': ', end_of(stage%wave, stage%settings%end_time, 'a velocity'))
    end subroutine add_ends_of_records

  end function warnings_of_scene

  !> Fault of a fracture energy, '' for none. The spring of the bond stores more, or the mesh is too coarse for the zone in which
  !> the bond softens. That zone is about E G/T^2 long (Hillerborg, Modeer & Petersson 1976).
  pure function doubt_of_energy(energy, strength, stiffness, edge, young) result(doubt)
    real(dp), intent(in) :: energy    !! force/length
    real(dp), intent(in) :: strength  !! in tension, force/length^2
    real(dp), intent(in) :: stiffness !! of the joint; 0: that of contact, force/length^3
    real(dp), intent(in) :: edge      !! of the mesh; 0: there is none, length
    real(dp), intent(in) :: young     !! force/length^2
    character(len=:), allocatable :: doubt

    doubt = ''
    if (.not. energy > 0) return
    if (2*energy*stiffness <= strength**2 .and. stiffness > 0) then
      doubt = 'expected an energy above T^2/(2 kn) = '//short_text(strength**2/(2*stiffness))//', which the spring of the bond '// &
              'stores at its strength, found '//short_text(energy)//': the bond breaks at once'
    else if (young*energy < zone_edges*edge*strength**2) then
      doubt = 'expected edges of the mesh up to a quarter of E G/T^2, '//short_text(young*energy/strength**2/zone_edges)// &
              ', found '//short_text(edge)//': the load at which a crack grows depends on the mesh'
    end if
  end function doubt_of_energy

  !> Fault of a residual strength, '' for none: it is above that of the joint before it slid.
  pure function doubt_of_residual(what, peak, residual) result(doubt)
    character(len=*), intent(in) :: what
    real(dp), intent(in) :: peak, residual
    character(len=:), allocatable :: doubt

    doubt = ''
    if (residual > peak) &
      doubt = 'expected a residual '//what//' up to the '//what//' of the joint, '//short_text(peak)//', found '// &
              short_text(residual)//': the joint would be stronger where it has failed'
  end function doubt_of_residual

  !> What a table does from its last time to a later end of the run, '' where that goes without saying: the table has come to a
  !> value that stays, or the record has died out.
  pure function end_of(table, end_time, what) result(words)
    type(time_table_t), intent(in) :: table
    real(dp), intent(in) :: end_time
    character(len=*), intent(in) :: what  !! the table gives, with an article
    character(len=:), allocatable :: words
    logical :: changes
    integer :: n

    words = ''
    if (.not. allocated(table%time) .or. end_time >= huge(end_time)) return
    n = size(table%time)
    if (table%time(n) >= (1 - same_time)*end_time) return
    associate (v => table%value)
      if (table%kept) then
        changes = any(abs(v(:, n) - v(:, max(1, n - 1))) > 0)
      else
        changes = any(abs(v(:, n)) > at_rest*maxval(abs(v)))
      end if
      if (.not. changes) return
      words = 'expected '//what//' up to the end of the run at '//rounded_text(end_time)//', found '//pair_text(v(:, n))// &
              ' at the last time, '//rounded_text(table%time(n))
    end associate
    if (table%kept) then
      words = words//'; it stays so from there; a last row at the end of the run says that this is meant'
    else
      words = words//'; it is 0 from there; a last row with 0 0 says that this is meant'
    end if
  end function end_of

end module scree_scene_warnings
