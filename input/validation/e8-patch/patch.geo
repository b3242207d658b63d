! Polygon with a notch
0.001                        ! least distance of an edge and a node
7 7                          ! lines, boundary lines
0                            ! material lines
0                            ! bolts
0                            ! fixed lines
0                            ! load points
0                            ! measured points
0                            ! hole points
1 0  4 0.3  1
4 0.3  4.7 2  1
4.7 2  3.2 2.9  1
3.2 2.9  2.6 1.5  1
2.6 1.5  1.9 2.6  1
1.9 2.6  0.6 1.7  1
0.6 1.7  1 0  1
