! Column of ten blocks 2 x 1
0.001                        ! least distance of an edge and a node
13 4                         ! lines, boundary lines
0                            ! material lines
0                            ! bolts
0                            ! fixed lines
0                            ! load points
1                            ! measured points
0                            ! hole points
0 0  2 0  1
2 0  2 10  1
2 10  0 10  1
0 10  0 0  1
0 1  2 1  1
0 2  2 2  1
0 3  2 3  1
0 4  2 4  1
0 5  2 5  1
0 6  2 6  1
0 7  2 7  1
0 8  2 8  1
0 9  2 9  1
1 9.999                      ! measured point
