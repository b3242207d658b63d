"""Static runs of specimens whose bonds break: the load steps go on as planned, in any unit of length and time."""
import numpy as np
import scree
from scree import call
from scree.block_files import block_file, box, held
from scipy.spatial import Voronoi

WIDTH, HEIGHT = 2.0, 4.0
STEPS = 40


def grains(number, seed):
    """Voronoi cells of random points in the rectangle: a cell is cut by the mirror images of the points in its sides."""
    points = np.random.default_rng(seed).random((number, 2)) * [WIDTH, HEIGHT]
    for _ in range(2):
        images = [points * [-1, 1], points * [1, -1], [2 * WIDTH, 0] + points * [-1, 1], [0, 2 * HEIGHT] + points * [1, -1]]
        diagram = Voronoi(np.vstack([points, *images]))
        cells = [diagram.vertices[diagram.regions[diagram.point_region[i]]] for i in range(number)]
        points = np.array([cell.mean(0) for cell in cells])
    return [cell if area(cell) > 0 else cell[::-1] for cell in cells]


def area(p):
    return 0.5 * np.sum(p[:, 0] * np.roll(p[:, 1], -1) - p[:, 1] * np.roll(p[:, 0], -1))


def press(folder, size=1.0, seconds=1.0):
    """A specimen of bonded grains, pressed between two platens by 0.6 % in static load steps of `seconds`."""
    platens = [box(-0.1, WIDTH + 0.1, -0.2, 0), box(-0.1, WIDTH + 0.1, HEIGHT, HEIGHT + 0.2)]
    blocks = [(1, size * p, [3] * 4) for p in platens] + [(2, size * g, [2] * len(g)) for g in grains(60, 3)]
    fixed = [(*(size * (q + 0.02 * (p.mean(0) - q))), k + 1) for k, p in enumerate(platens) for q in p]
    folder.mkdir()
    (folder / "x.blk").write_text(block_file("specimen", blocks, fixed))
    down = f"0 0 0  {STEPS * seconds} 0 {-0.006 * HEIGHT * size}"
    rows = [f"0 {STEPS} 2 3 0.05 {seconds} 0", "1 1 1 1 2 2 2 2", *["0 0 0"] * 4, *[down] * 4,
            *["2600 0 5e10 0.25 0 0 0 0 0 0 0 0 0"] * 2, "0 0 0", "30 2e7 5e6", "5 0 0", "&deck dialect='shi' /"]
    (folder / "x.ana").write_text("\n".join(rows) + "\n")
    done = call("run", folder / "x.blk", folder / "x.ana", "-o", folder / "r.h5", "--quiet")
    assert done.returncode == 0, done.stderr
    return scree.read(folder / "r.h5")


def test_the_steps_of_a_broken_specimen_are_those_of_the_deck(tmp_path):
    """A step that fails is tried again with more inertia and the same load; the unit of length and time does not matter."""
    r = press(tmp_path / "m")
    assert r.history.rejected.sum() > 0, "the specimen breaks without trouble, so the test shows nothing"
    assert len(r.history.time) <= 1.25 * STEPS
    np.testing.assert_allclose(r.bodies.area[-1].sum(), r.bodies.area[0].sum(), rtol=1e-2)
    assert r.history.unbalanced[-1] < 1e-3
    scaled = press(tmp_path / "km", size=1024.0, seconds=1024.0)
    assert len(scaled.history.time) == len(r.history.time)
    np.testing.assert_allclose(scaled.bodies.stress[-1], r.bodies.stress[-1], rtol=1e-3, atol=1e3)
