! A wall, and fill behind it on rock that rises at 60 degrees from 0.5 m above the heel of the wall.
0.001                        ! least distance of edge and node, over the size
20 7                         ! lines, boundary lines
2                            ! material lines
0                            ! bolts
0                            ! fixed lines
0                            ! load points
0                            ! measured points
0                            ! hole points
-4 -2 10 -2 1                ! around all
10 -2 10 6 1
10 6 2.5 6 1
2.5 6 0 6 3
0 6 0 0 3                    ! face of the wall
0 0 -4 0 2                   ! ground
-4 0 -4 -2 1
0 0 2.5 0 2                  ! base of the wall
2.5 0 2.5 6 3                ! back of the wall
2.5 0.5 5.67542648 6 1   ! the rock below the fill
2.5 1.875 4.88156986 6 1
2.5 3.25 4.08771324 6 1
2.5 4.625 3.29385662 6 1
2.5 1.875 2.89692831 1.1875 1
2.5 3.25 3.29385662 1.875 1
2.5 4.625 3.69078493 2.5625 1
2.5 6 4.08771324 3.25 1
3.29385662 6 4.48464155 3.9375 1
4.08771324 6 4.88156986 4.625 1
4.88156986 6 5.27849817 5.3125 1
1 3 1 3 2                    ! the wall is of block material 2, the fill of 1
9 0 9 0 3                    ! the rock of 3
