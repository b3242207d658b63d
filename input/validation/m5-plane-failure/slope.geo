! Slope of 60 m, face 50 degrees; plane of 35 degrees through its toe to a tension crack 14 m deep
0.001                        ! least distance of edge and node, over the size
7 0                          ! lines, boundary lines
1                            ! material lines
0                            ! bolts
3                            ! fixed lines
0                            ! load points
1                            ! measured points
0                            ! hole points
-40 -28.008301528388387 65.69480831013728 46 1 ! sliding plane
65.69480831013728 46 65.69480831013728 60 2 ! tension crack
0 0 50.3459778706368 60 2    ! face
50.3459778706368 60 130 60 2 ! ground
130 60 130 -60 2
130 -60 -40 -60 2
-40 -60 -40 -28.008301528388387 2
35 35 35 35 2                ! material 2: the block on the plane
125 -55 125 -55              ! fixed
-35 -55 -35 -55              ! fixed
125 55 125 55                ! fixed
35 35                        ! measured: the block
