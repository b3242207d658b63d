"""Scenes of small steps, as decks of a folder, and how far their blocks go."""
import numpy as np
import scree
from scree.block_files import block_file, box, held, turned

DENSITY, G = 2500.0, 9.81


def decks(folder, blocks, *, time, step=0.005, phi=30.0, gravity=G, tilt=0.0, joint="0 0", velocity=(0, 0, 0), groups="", fixed=None,
          scheme="small_steps", name="x", load=(), measured=(), carried=1, order="short", materials=1, joints=None, tables=None):
    """Blocks (material, corners), of which the first is held; material 2 has the velocity. The ground is turned by `tilt` degrees."""
    fixed = held(blocks[0][1], 1) if fixed is None else fixed
    (folder / f"{name}.blk").write_text(block_file(name, [(m, turned(b, -np.radians(tilt))) for m, b in blocks],
                                                   [(*turned(np.array([p[:2]]), -np.radians(tilt))[0], *p[2:]) for p in fixed], load,
                                                   measured))
    rows = [f"{carried} {max(1, round(time / step))} 2 {1 if joints is None else len(joints)} 0.05 {step}"]
    rows += [f"{DENSITY} {DENSITY * gravity} 1e10 0.25 0 0 0 0 0 0 {v[0]} {v[1]} {v[2]}" for v in ((0, 0, 0), velocity)]
    rows += [f"{phi} {joint}"] if joints is None else joints
    rows += ["&deck dialect='short' /", f"&integrator scheme='{scheme}' /" if scheme else "", groups, ""]
    (folder / f"{name}.ana").write_text("\n".join(rows))
    return [folder / f"{name}.blk", folder / f"{name}.ana"]


def run(folder, blocks, *settings, restart=None, **given):
    """The run of a scene."""
    files = decks(folder, blocks, **given)
    return scree.run(*files, output=folder / f"{given.get('name', 'x')}.h5", settings=list(settings))


def ways(result, free=slice(1, None), frame=-1):
    """Displacement of the centroids of the free blocks since the start."""
    centroid = result.bodies.centroid
    return np.linalg.norm((centroid[frame] - centroid[0])[free], axis=-1)


def column(n, side=0.05, tilt=25.0):
    """A column of n blocks on a slope that is turned by `tilt`, four times as high as wide."""
    w = int(np.sqrt(n // 4))
    boxes = [box(-40 * w, 40 * w, -8 * w, 0)] + [box(-w / 2 + i, -w / 2 + i + 1, k, k + 1) for i in range(w) for k in range(4 * w)]
    return [(1 if i == 0 else 2, side * b) for i, b in enumerate(boxes)]
