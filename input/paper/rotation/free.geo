! The triangle of triangle.geo without a fixed point.
0.001                        ! least distance of edge and node, over the size
3 0                          ! lines, boundary lines
0                            ! material lines
0                            ! bolts
0                            ! fixed lines
0                            ! load points
1                            ! measured points
0                            ! hole points
0.0  0.0                  0.1  0.0                  1
0.1  0.0                  0.05 0.08660254037844387  1
0.05 0.08660254037844387  0.0  0.0                  1
0.05 0.028867513459481287    ! measured point: the centroid
