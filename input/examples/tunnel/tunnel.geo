! A tunnel 6 m wide and 5 m high in bedded rock, and two joints that part a wedge from its roof: 5 m wide and 5 m high.
0.001                        ! least distance of edge and node, over the size
13 8                         ! lines, boundary lines
0                            ! material lines
0                            ! bolts
0                            ! fixed lines
0                            ! load points
1                            ! measured points
1                            ! hole points
-15 -8 15 -8 1               ! around all
15 -8 15 16 1
15 16 -15 16 1
-15 16 -15 -8 1
-3 0 3 0 1                   ! the tunnel
3 0 3 5 1
3 5 -3 5 1
-3 5 -3 0 1
-2.5 5 3 16 2                ! the joints
2.5 5 -3 16 2
-15 0 -3 0 1                 ! bedding
3 0 15 0 1
-15 -4 15 -4 1
0 6                          ! measured: in the wedge
0 2                          ! hole: the tunnel
