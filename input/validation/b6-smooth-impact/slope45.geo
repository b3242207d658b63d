! Square of edge 0.05, lowest corner 0.05 above a plane of 45 degrees
0.001                        ! least distance of edge and node, over the size
7 0                          ! lines, boundary lines
1                            ! material lines
0                            ! bolts
3                            ! fixed lines
0                            ! load points
1                            ! measured points
0                            ! hole points
0 0.5 0.5 0 1                ! slope
0.5 0 0 0 1
0 0 0 0.5 1
0.1 0.45 0.15 0.45 1         ! block
0.15 0.45 0.15 0.5 1
0.15 0.5 0.1 0.5 1
0.1 0.5 0.1 0.45 1
0.125 0.475 0.125 0.475 2    ! material 2: the block
0.01 0.01 0.01 0.01          ! fixed
0.4 0.01 0.4 0.01            ! fixed
0.01 0.4 0.01 0.4            ! fixed
0.125 0.475                  ! measured: centre of the block
