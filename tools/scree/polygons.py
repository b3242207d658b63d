"""Polygons: arrays of their corners."""
import numpy as np

SLOPE = 0.01  # sine of the angle between an edge and a line that it is on
LEAST_POLYGON_WITH_A_HOLE = 8  # two triangles, and two vertices there twice


def worst_overlap(polygons):
    """Depth of the deepest corner of a polygon, of any shape, in another: its distance from the outline.

    Convex ones that sink into each other side by side, with corners on the lines of sides, are for `deepest_overlap`.
    """
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


def boxes_that_meet(low, high):
    """Pairs (n, 2) of boxes, by their lower left and upper right corners (b, 2), that have a place in common."""
    order = np.argsort(low[:, 0], kind="stable")
    following = np.searchsorted(low[order, 0], high[order, 0], side="right") - np.arange(len(order)) - 1
    first = np.repeat(np.arange(len(order)), following)
    second = first + 1 + np.arange(len(first)) - np.repeat(np.cumsum(following) - following, following)
    a, b = order[first], order[second]
    meet = (low[a, 1] <= high[b, 1]) & (low[b, 1] <= high[a, 1])
    return np.column_stack([a[meet], b[meet]])


def deepest_overlap(polygons):
    """The least way that parts two convex polygons, of the two that overlap most; 0 where none do. Corners run counter-clockwise.

    The least way is across an edge of one of them: of all their edges the one whose line the other reaches behind the least.
    """
    most = max(map(len, polygons))
    corners = np.array([np.concatenate([p, np.repeat(p[-1:], most - len(p), axis=0)]) for p in map(np.asarray, polygons)], float)
    sides = np.roll(corners, -1, axis=1) - corners
    length = np.linalg.norm(sides, axis=2)
    real = length > 0  # not between the copies of the last corner, which make all have as many
    outward = np.stack([sides[..., 1], -sides[..., 0]], axis=2) / np.where(real, length, 1)[..., None]
    pairs = boxes_that_meet(corners.min(1), corners.max(1))
    if not len(pairs):
        return 0.0
    depth = np.full(len(pairs), np.inf)
    for a, b in (pairs.T, pairs.T[::-1]):
        behind = np.einsum("pkx,pckx->pkc", outward[a], corners[a][:, None] - corners[b][:, :, None]).max(2)
        depth = np.minimum(depth, np.where(real[a], behind, np.inf).min(1))
    return max(0.0, float(depth.max()))


def loops_of(polygon):
    """Vertices of each loop of a polygon whose holes are joined by seams, edges that it runs through both ways."""
    corners = list(map(tuple, polygon))

    def part(numbers):
        n = len(numbers)
        if n >= LEAST_POLYGON_WITH_A_HOLE:
            edges = {(corners[numbers[i]], corners[numbers[(i + 1) % n]]): i for i in range(n)}
            for i in range(n - 4):
                j = edges.get((corners[numbers[i + 1]], corners[numbers[i]]), 0)
                if j >= i + 4:  # each vertex that is there twice stays where no seam starts
                    return part(numbers[:i] + numbers[j + 1:]) + part(numbers[i + 1:j])
        return [np.array(numbers)]

    return part(list(range(len(corners))))


def on_lines(places, ways, lines, near):
    """Whether each place (n, 2) with a direction (n, 2) lies on one of some lines (x1, y1, x2, y2) and runs along it (n)."""
    order = np.argsort(places[:, 0])
    sorted_x, sizes, found = places[order, 0], np.linalg.norm(ways, axis=1), np.zeros(len(places), bool)
    for x1, y1, x2, y2 in lines:
        beside = order[slice(*np.searchsorted(sorted_x, (min(x1, x2) - near, max(x1, x2) + near)))]
        side = np.array([x2 - x1, y2 - y1])
        length = np.linalg.norm(side)
        across = np.array([-side[1], side[0]]) / length
        off = places[beside] - (x1, y1)
        share = off @ side / length
        found[beside] |= ((np.abs(off @ across) <= near) & (np.abs(ways[beside] @ across) <= SLOPE * sizes[beside])
                          & (share >= -near) & (share <= length + near))
    return found
