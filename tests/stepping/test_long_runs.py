"""Runs of so many steps that round-off and leaks would show: SCREE_STEPS of a stack, a tenth of that of a shaken wall."""
import os
import resource

import numpy as np
import scree
from scree.bench import effects, scenes

STEPS = int(os.environ.get("SCREE_STEPS", 20000))

def test_a_stack_at_rest_stays_where_it_is(tmp_path):
    """What is left of a step is round-off, which a run adds up: 1e-15 of a block a step at most, and no energy."""
    stack = effects.Scene([effects.ground(6), *((effects.REST, effects.box(0, 1, i, i + 1)) for i in range(3))], last=STEPS)
    r = scree.run(*stack.write(tmp_path, "stack"), settings=[f"output.every={STEPS // 4}"])
    began, ended = r.bodies.centroid[1], r.bodies.centroid[-1]
    assert r.history.rejected.sum() == 0 and len(r.history.time) == STEPS
    assert np.abs(ended - began).max() < 1e-15 * STEPS
    assert np.abs(r.history.rotation[-1]).max() < 1e-15 * STEPS
    assert np.ptp(r.history.energy.dissipated[STEPS // 4:]) < 1e-15 * STEPS * np.abs(r.history.energy.gravity[0])


def test_a_shaken_wall_keeps_its_books_and_its_memory(tmp_path):
    """Ground that shakes for good, at a third of what makes bricks slide: what the run has lost grows, and no memory is."""
    peaks = []
    for count in (STEPS // 100, STEPS // 10):
        wall = scenes.wall(5).write(tmp_path, 0.005)
        (tmp_path / "shakes.txt").write_text("".join(f"{0.1 * i:.1f} {2 * (-1) ** i} 0\n" for i in range(int(count * 0.05) + 2)))
        r = scree.run(*wall, settings=["acceleration.file=shakes.txt", f"step.end_time={0.005 * count}", "output.every=1000"])
        peaks.append(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
        assert len(r.history.time) == count and r.history.rejected.sum() == 0
    energy, scale = r.history.energy, np.abs(r.history.energy.gravity).max()
    assert np.diff(energy.dissipated).min() > -1e-9 * scale
    assert r.history.overlap.max() < 1e-4
    assert peaks[1] < 1.05 * peaks[0]
