! Plate 1 x 0.04 on a base
0.001                        ! least distance of edge and node, over the size
7 0                          ! lines, boundary lines
1                            ! material lines
0                            ! bolts
4                            ! fixed lines
0                            ! load points
0                            ! measured points
0                            ! hole points
-1 -1 4 -1 1                 ! base
4 -1 4 0 1
4 0 -1 0 1
-1 0 -1 -1 1
1 0 1 0.04 1                 ! plate on it
1 0.04 0 0.04 1
0 0.04 0 0 1
0.5 0.02 0.5 0.02 2          ! material 2: the plate
-0.95 -0.95 -0.95 -0.95      ! fixed
3.95 -0.95 3.95 -0.95        ! fixed
3.95 -0.05 3.95 -0.05        ! fixed
-0.95 -0.05 -0.95 -0.05      ! fixed
