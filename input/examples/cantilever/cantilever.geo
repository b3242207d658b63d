! A beam of 10 x 1 m, clamped at x = 0 (by the deck's &support).
1e-6                         ! least distance of edge and node, over the size
4 4                          ! lines, boundary lines
0                            ! material lines
0                            ! bolts
0                            ! fixed lines
0                            ! load points
1                            ! measured points
0                            ! hole points
0 0 10 0 1
10 0 10 1 1
10 1 0 1 1
0 1 0 0 1
10 0.5                       ! measured: the tip
