! Column 1 x 8
0.001                        ! least distance of an edge and a node
4 4                          ! lines, boundary lines
0                            ! material lines
0                            ! bolts
0                            ! fixed lines
0                            ! load points
1                            ! measured points
0                            ! hole points
0 0  1 0  1
1 0  1 8  1
1 8  0 8  1
0 8  0 0  1
0.5 8                        ! measured: the top
