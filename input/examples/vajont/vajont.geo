! A valley, and a mass of rock on a surface in the shape of a chair: its back dips 38.7 degrees, its seat 7.6. Upright joints part the mass.
0.001                        ! least distance of edge and node, over the size
20 11                        ! lines, boundary lines
1                            ! material lines
0                            ! bolts
0                            ! fixed lines
0                            ! load points
1                            ! measured points
0                            ! hole points
-100 420 -100 -150 1
-100 -150 1100 -150 1
1100 -150 1100 250 1
1100 250 820 -20 1
820 -20 740 -60 1
740 -60 700 20 1
0 400 -100 420 1
0 400 150 390 1
150 390 400 270 1
400 270 700 190 1
700 190 700 20 1
0 400 400 80 1
400 80 400 60 1
400 60 700 20 1
100 320 100 393.333 2
200 240 200 366 2
300 160 300 318 2
400 80 400 270 2
500 46.6668 500 243.333 2
600 33.3334 600 216.667 2
1000 0 1000 0 2              ! the valley is of block material 2
650 150                      ! measured: near the front
