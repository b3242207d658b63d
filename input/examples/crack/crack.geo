! A plate of 2 x 4 m with a crack of 0.8 m in its middle, across the load.
1e-6                         ! least distance of edge and node, over the size
5 4                          ! lines, boundary lines
0                            ! material lines
0                            ! bolts
0                            ! fixed lines
0                            ! load points
2                            ! measured points
0                            ! hole points
-1 -2 1 -2 1
1 -2 1 2 1
1 2 -1 2 1
-1 2 -1 -2 1
-0.4 0 0.4 0 1               ! the crack
0  0.0001                    ! measured: upper lip of the crack
0 -0.0001                    ! measured: lower lip
