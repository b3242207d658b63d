! A hillside with a cliff, a dam at its foot, and a rock of five corners, 1.3 m across, that has come off the cliff.
0.001                        ! least distance of edge and node, over the size
18 0                         ! lines, boundary lines
1                            ! material lines
0                            ! bolts
4                            ! fixed lines
0                            ! load points
1                            ! measured points
0                            ! hole points
-3 20 0 20 1                 ! the hillside
0 20 1 15.5 1
1 15.5 6 13 1
6 13 13 7 1
13 7 20 3 1
20 3 25 3 1
25 3 26.5 5 1                ! the dam
26.5 5 28 5 1
28 5 29.5 3 1
29.5 3 33 3 1
33 3 33 -1 1
33 -1 -3 -1 1
-3 -1 -3 20 1
1.9 19 2.8 19.1 1            ! the rock
2.8 19.1 3.1 19.9 1
3.1 19.9 2.4 20.4 1
2.4 20.4 1.8 20 1
1.8 20 1.9 19 1
2.4 19.7 2.4 19.7 2          ! it is of block material 2
-2.8 -0.8 -2.8 -0.8          ! fixed, four times
32.8 -0.8 32.8 -0.8
-2.8 19.5 -2.8 19.5
32.8 2.8 32.8 2.8
2.394271 19.658203           ! measured: the centre of the rock
