"""Polygons: arrays of their corners."""
import numpy as np


def worst_overlap(polygons):
    """Depth of the deepest corner of a polygon in another: its distance from the outline."""
    corners = np.concatenate(polygons)
    owner = np.repeat(np.arange(len(polygons)), [len(p) for p in polygons])
    worst = 0.0
    for j, polygon in enumerate(polygons):
        near = (owner != j) & np.all((corners > polygon.min(0)) & (corners < polygon.max(0)), axis=1)
        p, a, b = corners[near][:, None], polygon, np.roll(polygon, -1, axis=0)
        side = b - a
        crosses = (a[:, 1] > p[..., 1]) != (b[:, 1] > p[..., 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            right = p[..., 0] < a[:, 0] + (p[..., 1] - a[:, 1]) * side[:, 0] / side[:, 1]
        inside = (crosses & right).sum(1) % 2 == 1
        share = np.clip(((p - a) * side).sum(2) / (side**2).sum(1), 0, 1)
        depth = np.linalg.norm(p - a - share[..., None] * side, axis=2).min(1) if near.any() else np.zeros(0)
        worst = max(worst, depth[inside].max(initial=0.0))
    return worst
