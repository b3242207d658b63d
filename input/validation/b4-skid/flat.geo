! Block 1 x 0.5 on a flat base
0.001                        ! least distance of edge and node, over the size
7 0                          ! lines, boundary lines
1                            ! material lines
0                            ! bolts
4                            ! fixed lines
0                            ! load points
1                            ! measured points
0                            ! hole points
-1 -0.5 13 -0.5 1            ! base
13 -0.5 13 0 1
13 0 -1 0 1
-1 0 -1 -0.5 1
1 0 1 0.5 1                  ! block on it
1 0.5 0 0.5 1
0 0.5 0 0 1
0.5 0.25 0.5 0.25 2          ! material 2: the block
-0.975 -0.475 -0.975 -0.475  ! fixed
12.975 -0.475 12.975 -0.475  ! fixed
12.975 -0.025 12.975 -0.025  ! fixed
-0.975 -0.025 -0.975 -0.025  ! fixed
0.5 0.25                     ! measured: centre of the block
