! A layer 60 x 40
0.001                        ! least distance of edge and node, over the size
4 4                          ! lines, boundary lines
0                            ! material lines
0                            ! bolts
0                            ! fixed lines
0                            ! load points
1                            ! measured points
0                            ! hole points
0 0 60 0 1
60 0 60 40 1
60 40 0 40 1
0 40 0 0 1
30 39.999                    ! measured: the middle of the top
