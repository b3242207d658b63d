! Zhang, Li, Jiang, Lin 2019, section 6.1: a square block above a slope of 45 degrees, 0.5 m high.
! The paper gives neither its size nor its height: edge 0.05, lowest corner 0.05 above the slope are chosen here.
0.001                        ! least distance of edge and node, over the size
9 0                          ! lines, boundary lines
1                            ! material lines
0                            ! bolts
4                            ! fixed lines
0                            ! load points
1                            ! measured points
0                            ! hole points
0 0.5 0.5 0 1                ! slope
0.5 0 3 0 1                  ! floor
3 0 3 -0.2 1
3 -0.2 0 -0.2 1
0 -0.2 0 0.5 1
0.1 0.45 0.15 0.45 1         ! block
0.15 0.45 0.15 0.5 1
0.15 0.5 0.1 0.5 1
0.1 0.5 0.1 0.45 1
0.125 0.475 0.125 0.475 2    ! material 2: the block
0.05 -0.15 0.05 -0.15        ! fixed
2.9 -0.15 2.9 -0.15          ! fixed
0.05 0.35 0.05 0.35          ! fixed
2.9 -0.05 2.9 -0.05          ! fixed
0.125 0.475                  ! measured: centre of the block
