! A beam of 1 m x 0.1 m (Zhang et al. 2019, section 5.3); m, kg, N, s
0.001                        ! shortest edge
4 4                          ! lines, of which boundary
0                            ! material lines
0                            ! bolts
0                            ! fixed lines and points
2                            ! load points
2                            ! measured points
0                            ! holes
0 0 1 0 1
1 0 1 0.1 1
1 0.1 0 0.1 1
0 0.1 0 0 1
1 0                          ! loaded: the free corners
1 0.1
1 0                          ! measured: the same
1 0.1
