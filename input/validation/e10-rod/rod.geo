! Rod 24 x 1
0.001                        ! least distance of an edge and a node
4 4                          ! lines, boundary lines
0                            ! material lines
0                            ! bolts
0                            ! fixed lines
0                            ! load points
2                            ! measured points
0                            ! hole points
0 0  24 0  1
24 0  24 1  1
24 1  0 1  1
0 1  0 0  1
5 0.5                        ! measured: where it passes
15 0.5
