! Column 1 x 40, a joint across its middle
0.00001                      ! least distance of an edge and a node
5 4                          ! lines, boundary lines
0                            ! material lines
0                            ! bolts
0                            ! fixed lines
0                            ! load points
1                            ! measured points
0                            ! hole points
0 0  1 0  1
1 0  1 40  1
1 40  0 40  1
0 40  0 0  1
0 20  1 20  2
0.5 25                       ! measured: 5 above the joint
