! Square of edge 0.5, 1 above a flat base
0.001                        ! least distance of edge and node, over the size
8 0                          ! lines, boundary lines
1                            ! material lines
0                            ! bolts
4                            ! fixed lines
0                            ! load points
1                            ! measured points
0                            ! hole points
-1 -0.5 1.5 -0.5 1           ! base
1.5 -0.5 1.5 0 1
1.5 0 -1 0 1
-1 0 -1 -0.5 1
0 1 0.5 1 1                  ! block
0.5 1 0.5 1.5 1
0.5 1.5 0 1.5 1
0 1.5 0 1 1
0.25 1.25 0.25 1.25 2        ! material 2: the block
-0.975 -0.475 -0.975 -0.475  ! fixed
1.475 -0.475 1.475 -0.475    ! fixed
1.475 -0.025 1.475 -0.025    ! fixed
-0.975 -0.025 -0.975 -0.025  ! fixed
0.25 1.25                    ! measured: centre of the block
