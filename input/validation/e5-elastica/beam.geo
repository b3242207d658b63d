! Beam 1 x 0.02
0.001                        ! least distance of an edge and a node
4 4                          ! lines, boundary lines
0                            ! material lines
0                            ! bolts
0                            ! fixed lines
0                            ! load points
2                            ! measured points
0                            ! hole points
0 0  1 0  1
1 0  1 0.02  1
1 0.02  0 0.02  1
0 0.02  0 0  1
1 0                          ! measured: the free corners
1 0.02
