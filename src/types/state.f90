!> The state, which steps change. A run goes on from the model and the state alone.
module scree_state
  use scree_contacts, only: contact_memory_t, contact_t
  use scree_factored, only: factored_t
  use scree_hold, only: hold_t
  use scree_kinds, only: dp
  implicit none
  private
  public :: bolt_memory_t, books_t, cracks_t, deviation_t, pace_t, reference_t, settling_t, sleep_t, stage_clock_t, state_t, &
            step_of_run, time_of_run

  !> State of a bolt: elastic, has yielded, broken, or not in this stage; from `bolt_broken` on it has no force.
  integer, parameter, public :: bolt_elastic = 0, bolt_yielded = 1, bolt_broken = 2, bolt_absent = 3

  !> Energy at one time, supplied and dissipated energy since the start, and momentum about the origin of the decks.
  type :: books_t
    real(dp) :: kinetic = 0.0_dp         !! force length per unit thickness, as all energies
    real(dp) :: strain = 0.0_dp          !! of the present stress
    real(dp) :: gravity = 0.0_dp         !! weight times height above y = 0
    real(dp) :: fixed_springs = 0.0_dp   !! of springs that hold fixed points
    real(dp) :: contact_springs = 0.0_dp !! of what is awake
    real(dp) :: sleeping_springs = 0.0_dp !! of contacts of what sleeps
    real(dp) :: bolts = 0.0_dp
    real(dp) :: integrator = 0.0_dp      !! that the integrator holds, out of sudden changes of velocity
    real(dp) :: at_start = 0.0_dp        !! all of these when the run began
    real(dp) :: staged = 0.0_dp          !! that changes from stage to stage gave since then; below 0: took
    real(dp) :: work = 0.0_dp            !! of loads, ground and supports since then
    real(dp) :: damping = 0.0_dp         !! that damping of mass and stiffness and absorbing edges took since then
    real(dp) :: friction = 0.0_dp        !! lost in sliding since then
    real(dp) :: yield = 0.0_dp           !! lost in bolts that yielded or broke since then
    real(dp) :: fracture = 0.0_dp        !! taken by bonds that softened and cracks that grew since then
    real(dp) :: asleep = 0.0_dp          !! motion of what fell asleep, since then
    real(dp) :: momentum(3) = 0.0_dp     !! x, y: mass/time; angular: mass length/time
  end type books_t

  !> Number of the stage, and time and steps before it.
  type :: stage_clock_t
    integer :: number = 1
    integer :: steps = 0                 !! of the run before it
    real(dp) :: begins = 0.0_dp          !! time of the run
  end type stage_clock_t

  !> Where displacements count from, after a stage that counts them anew.
  type :: reference_t
    real(dp), allocatable :: vertex(:, :) !! (2, n_vertices) length
    real(dp), allocatable :: point(:, :) !! (2, n_points) length
  end type reference_t

  !> State of the step control, from one step to the next.
  type :: pace_t
    real(dp) :: size = 0.0_dp            !! that the next step may have, time
    real(dp) :: last = 0.0_dp            !! size of the last step, time
    real(dp) :: bound = huge(1.0_dp)     !! of an explicit step: the least that there was, time
    real(dp) :: pseudo = huge(1.0_dp)    !! size by which inertia resists a static step, where that is less than its own, time
    real(dp) :: small = 0.0_dp           !! size of the last small step; 0: the stage has had none, time
    real(dp) :: support_force = 0.0_dp   !! of moving supports in the last step: work over the way of the fastest, force/length
    real(dp) :: most_force = 0.0_dp      !! the largest of these
    integer :: easy = 0                  !! steps since the last cut
    integer :: frames = 0                !! after the first; with a spacing, the last multiple of it that was passed
  end type pace_t

  !> How near a static run is to equilibrium after its last step. Fractions are forces out of balance over the forces on a body.
  type :: settling_t
    real(dp) :: unbalanced = huge(1.0_dp)      !! the largest fraction of a body
    logical :: steady = .false.                !! loads and supports stay as they are from here on
    real(dp) :: grows = 1.0_dp                 !! size that the next step may have over that of the last
    integer :: moving = 0                      !! block that moves on and on; 0: none
    logical, allocatable :: loose(:)           !! (n_blocks) moves on and on, and the stage goes on without it
    real(dp), allocatable :: share(:)          !! (n_blocks)
    real(dp), allocatable :: way(:)            !! (n_blocks) gone in steps in a row that brought it no nearer, over its size
    real(dp), allocatable :: share_before(:)   !! (n_blocks) before the first of these
    real(dp), allocatable :: force_before(:)   !! (n_blocks) out of balance on all bodies then, summed, per unit thickness
  end type settling_t

  !> Sleeping bodies, which stay as they are. They touch only sleeping bodies and bodies that cannot move.
  type :: sleep_t
    integer, allocatable :: island(:)          !! (n_blocks) first block of the island that a block sleeps with, 0: it is awake
    integer, allocatable :: quiet(:)           !! (n_blocks) looks in a row near equilibrium, of what is awake
    real(dp), allocatable :: since(:)          !! (n_blocks) when it fell asleep, time
    type(contact_t), allocatable :: contact(:) !! as the last step before left them
    integer, allocatable :: inside(:, :)       !! (2, n) vertices, each with the edge that it is inside of
    integer :: count(3) = 0                    !! contacts open, sliding, locked
    real(dp) :: penetration = 0.0_dp           !! largest overlap of them, length
  end type sleep_t

  !> Memory of bolts.
  type :: bolt_memory_t
    real(dp), allocatable :: rest(:)           !! (n_bolts) length without force, or opening of a crossing of a grouted one
    real(dp), allocatable :: across(:)         !! (n_bolts) its slip without force, length
    integer, allocatable :: state(:)           !! (n_bolts) `bolt_elastic`, `bolt_yielded`, `bolt_broken`, `bolt_absent`
  end type bolt_memory_t

  !> Pieces by which cracks have grown, in the order in which they did. The model is that of the blocks of the decks, cut by them.
  type :: cracks_t
    real(dp), allocatable :: piece(:, :)       !! (4, n) x1 y1 x2 y2 from the tip on, at the start, by the blocks, length
    integer, allocatable :: joint(:)           !! (n) joint material of their faces
    integer, allocatable :: tip(:)             !! (n) number of the tip that ends there
    real(dp), allocatable :: time(:)           !! (n) of the run, when they grew; those of one time were cut at once
  end type cracks_t

  !> How far the run is estimated to be off, by what the steps so far have made of it. Of a block x, y and the rotation times its
  !> radius of gyration: their norm is the root mean square over the block.
  type :: deviation_t
    real(dp), allocatable :: from(:, :)        !! (2, n_blocks) where its centroid began, length
    real(dp), allocatable :: place(:, :)       !! (3, n_blocks) error of the place, length
    real(dp), allocatable :: motion(:, :)      !! (3, n_blocks) of the velocity, length/time
    real(dp), allocatable :: growth(:)         !! (n_blocks) area that small strain has made, over the area
    real(dp), allocatable :: impact(:)         !! (n_blocks) what the instants of impacts may have moved, length
    real(dp), allocatable :: late(:)           !! (n_blocks) delay of impacts, until a step has none, time
    real(dp), allocatable :: acceleration(:, :) !! (3, n_blocks) mean of the last step, before an impact, length/time^2
    real(dp), allocatable :: path_gain(:)      !! (n_blocks) sum of k v^2 dt, k of eq-error-growth, length^2/time^3
    real(dp), allocatable :: path_square(:)    !! (n_blocks) sum of v^2 dt, length^2/time
    real(dp), allocatable :: mean_velocity(:, :) !! (3, n_blocks) of late, length/time
    real(dp), allocatable :: mean_acceleration(:, :) !! (3, n_blocks) of late, length/time^2
    real(dp), allocatable :: mean_square(:)    !! (n_blocks) of the velocity, of late, length^2/time^2
    real(dp), allocatable :: added(:, :)       !! (3, n_blocks) sum of the errors that steps added of late, length
    real(dp), allocatable :: added_size(:)     !! (n_blocks) sum of the sizes of these, length
    real(dp), allocatable :: added_over(:)     !! (n_blocks) sum of dt^(p+1), p: order of the scheme, over which they were added
    logical, allocatable :: smooth(:)          !! (n_blocks) none of its contacts opened or closed in the last step
    real(dp) :: way = 0.0_dp                   !! largest displacement of a block so far, length
    real(dp) :: step = 0.0_dp                  !! largest error of the last step, length
    real(dp) :: excess = 1.0_dp                !! size of the last step over that which the accuracy asked for
    integer :: rough = 0                       !! blocks whose contacts opened or closed in the last step
    logical :: lost = .false.                  !! a block was off by more than all have gone, and than it is large
  end type deviation_t

  !> Positions, motion, stress and the memory of contacts at one time.
  type :: state_t
    real(dp) :: time = 0.0_dp                  !! since the stage began
    integer :: step = 0                        !! likewise
    type(stage_clock_t) :: stage
    type(pace_t) :: pace
    real(dp), allocatable :: vertex(:, :)      !! (2, n_vertices) of the elements, length
    real(dp), allocatable :: point(:, :)       !! (2, n_points), length
    real(dp), allocatable :: home(:, :)        !! (2, n_points) where those that are held were when that began, length
    real(dp), allocatable :: static_force(:, :) !! (2, n_points) that absorbing edges bear at their ends, force per unit thickness
    type(reference_t), allocatable :: reference !! not allocated: displacements count from the start
    real(dp), allocatable :: cover(:, :)       !! (2, n_covers) NMM: node of the mathematical mesh, length
    real(dp), allocatable :: velocity(:)       !! (n_unknowns) rates of the unknowns
    real(dp), allocatable :: acceleration(:)   !! (n_unknowns)
    real(dp), allocatable :: stress(:, :)      !! (3, n_elements) xx, yy, xy, tension positive, force/length^2
    real(dp), allocatable :: deformation(:, :) !! (4, n_elements) F since the start: xx, yx, xy, yy
    logical, allocatable :: green(:)           !! (n_elements) whether the last step took Green strain, else small strain
    real(dp), allocatable :: rotation(:)       !! (n_blocks) accumulated, rad
    integer, allocatable :: pair(:, :)         !! (2, n_pairs) elements that the equations of the last step coupled
    type(factored_t), allocatable :: factored(:) !! matrices whose factors the solutions of the next step go on from
    type(contact_memory_t) :: contacts
    real(dp), allocatable :: tied(:)           !! (n) forces of ties of small steps, force per unit thickness
    type(bolt_memory_t), allocatable :: bolts  !! where the scene has any
    type(sleep_t), allocatable :: sleep        !! where the scene lets bodies sleep
    type(settling_t), allocatable :: settling  !! of a static run that ends in equilibrium
    type(deviation_t), allocatable :: deviation !! where the scene asks for it
    type(cracks_t), allocatable :: cracks      !! where the scene lets cracks grow
    type(hold_t), allocatable :: hold          !! where new faces hold each other
    integer, allocatable :: departed(:)        !! blocks that have left the scene, in this order; not allocated: none
    type(books_t) :: books
  end type state_t

contains

  !> Time since the run began.
  pure real(dp) function time_of_run(state) result(time)
    type(state_t), intent(in) :: state

    time = state%stage%begins + state%time
  end function time_of_run

  !> Steps since the run began.
  pure integer function step_of_run(state) result(step)
    type(state_t), intent(in) :: state

    step = state%stage%steps + state%step
  end function step_of_run

end module scree_state
