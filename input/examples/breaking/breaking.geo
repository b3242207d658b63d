! A block of 1 x 2 m with a notch of 0.3 m from either side.
1e-6                         ! least distance of edge and node, over the size
6 4                          ! lines, boundary lines
0                            ! material lines
0                            ! bolts
0                            ! fixed lines
0                            ! load points
0                            ! measured points
0                            ! hole points
0 0 1 0 1
1 0 1 2 1
1 2 0 2 1
0 2 0 0 1
0 1.01 0.3 1.01 1            ! the notches
1 1.01 0.7 1.01 1
