"""200 rocks fall from a quarry face with a berm, and a barrier protects the road at its foot.

Rocks differ in size, shape, start, friction and restitution. The berm keeps a third of them.

Expect:
    rocks that stay on the berm = 64 within 25 %: a share, of which 200 rocks tell 0.07
    rocks that the barrier stops = 129 within 15 %: likewise
"""
import scree

face = [(0, 18), (4, 18), (6, 10), (9, 9.5), (11, 1), (16, 0), (24, 0)]
falls = scree.rockfall({
    "title": "A quarry face above a road", "number": 200, "time": 20,
    "slope": face, "ground": ["rock", "rock", "debris", "rock", "debris", "road"],
    "materials": {
        "rock": {"phi": 35, "restitution": {"from": 0.35, "to": 0.6}},
        "debris": {"phi": 32, "restitution": {"from": 0.2, "to": 0.35}},
        "road": {"phi": 30, "restitution": 0.25}},
    "rock": {"size": {"from": 0.4, "to": 1}},
    "start": {"line": [[4.5, 17], [6, 11]], "velocity": [0.5, 0]},
    "barrier": {"x": 17, "height": 1.5},
    "collectors": {"barrier": 16.5}})
on_berm = sum(x < 9 for x in falls.run_out)
print(f"rocks that stay on the berm: {on_berm}")
print(f"rocks that the barrier stops: {falls.stopped() - on_berm}")
falls.plot().savefig("quarry-paths.png", dpi=70)
falls.histograms().savefig("quarry.png", dpi=85)
