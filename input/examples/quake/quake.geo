! A slope 30 m high, and a joint that dips 30 degrees out of its face.
0.001                        ! least distance of edge and node, over the size
7 6                          ! lines, boundary lines
0                            ! material lines
0                            ! bolts
0                            ! fixed lines
0                            ! load points
2                            ! measured points
0                            ! hole points
0 0 200 0 1
200 0 200 20 1
200 20 120 20 1
120 20 100 50 1
100 50 0 50 1
0 50 0 0 1
118 23 71.2346 50 1
1 49.99                      ! measured: the side
99 49.9                      ! measured: the crest
