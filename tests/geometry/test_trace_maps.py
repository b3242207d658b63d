"""Maps of hundreds and thousands of traces: the blocks are the rock, and as many as an independent polygoniser finds."""
import pytest
import scree
from shapely.geometry import LineString, Polygon
from shapely.ops import polygonize, unary_union
from shapely.prepared import prep
from trace_maps import lengthened, trace_map

# Accidental near misses within e0 w0, where the cutter makes one point of what the polygoniser keeps apart, grow with the number of
# nodes times the length of all traces in an area. So the larger maps have a smaller e0, as their drawings have finer details.
MAPS = [(240, 1e-4), (500, 3e-5), (900, 1e-5), (1600, 5e-6), (3000, 1e-6), (5400, 1e-6)]
ALIKE = 3  # number of blocks that such near misses may cost or make


def polygonised(corners, traces, e):
    """Faces in the boundary of the traces, with their ends lengthened by the snap distance."""
    rock = Polygon(corners)
    lines = unary_union([LineString(lengthened(trace, e)) for trace in traces] + [rock.exterior])
    inside = prep(rock)
    return [face for face in polygonize(lines) if inside.contains(face.representative_point())]


@pytest.mark.parametrize("n, e0", MAPS)
def test_blocks_of_a_map_are_its_rock_and_as_many_as_its_faces(n, e0, tmp_path):
    corners, traces, e = trace_map(n, e0, n)
    boundary = [a + b for a, b in zip(corners, corners[1:] + corners[:1])]
    joints = [a + b for trace in traces for a, b in zip(trace, trace[1:])]
    (tmp_path / "m.geo").write_text(f"{e0} {len(boundary) + len(joints)} {len(boundary)} 0 0 0 0 0 0\n"
                                    + "".join(" ".join(map(repr, line)) + " 1\n" for line in boundary + joints))
    done = scree.call("cut", "m.geo", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    rows = [line.split() for line in done.stdout.splitlines()[2:]]
    rock = Polygon(corners)
    faces = polygonised(corners, traces, e)
    assert sum(float(row[4]) for row in rows) == pytest.approx(rock.area, rel=1e-9)
    words = [line.split() for line in (tmp_path / "m.blk").read_text().splitlines()]
    count, _, vertices = map(int, words[0])
    places = [tuple(map(float, row[-2:])) for row in words[2 + count:2 + count + vertices]]
    blocks = [Polygon(places[int(first) - 1:int(last)]) for _, first, last in words[2:2 + count]]
    reach = prep(rock.buffer(e))
    assert all(reach.contains(block) for block in blocks)
    assert abs(count - len(faces)) <= ALIKE, (count, len(faces))
    assert len(faces) > 0.3 * n and "outside of it" in done.stderr
