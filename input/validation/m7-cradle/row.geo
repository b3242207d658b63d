! Five blocks of equal mass in a row, 0.05 apart, 1 x 0.5 and 0.8 x 0.625 in turn so that corners meet edges
0.001                        ! least distance of edge and node, over the size
20 0                         ! lines, boundary lines
1                            ! material lines
0                            ! bolts
0                            ! fixed lines
0                            ! load points
5                            ! measured points
0                            ! hole points
0 -0.25 1 -0.25 1            ! block 1
1 -0.25 1 0.25 1
1 0.25 0 0.25 1
0 0.25 0 -0.25 1
1.05 -0.3125 1.85 -0.3125 1  ! block 2
1.85 -0.3125 1.85 0.3125 1
1.85 0.3125 1.05 0.3125 1
1.05 0.3125 1.05 -0.3125 1
1.9 -0.25 2.9 -0.25 1        ! block 3
2.9 -0.25 2.9 0.25 1
2.9 0.25 1.9 0.25 1
1.9 0.25 1.9 -0.25 1
2.95 -0.3125 3.75 -0.3125 1  ! block 4
3.75 -0.3125 3.75 0.3125 1
3.75 0.3125 2.95 0.3125 1
2.95 0.3125 2.95 -0.3125 1
3.8 -0.25 4.8 -0.25 1        ! block 5
4.8 -0.25 4.8 0.25 1
4.8 0.25 3.8 0.25 1
3.8 0.25 3.8 -0.25 1
0.5 0 0.5 0 2                ! material 2: thrown
0.5 0                        ! measured: block 1
1.45 0                       ! measured: block 2
2.4 0                        ! measured: block 3
3.35 0                       ! measured: block 4
4.3 0                        ! measured: block 5
