"""Numbers about errors: observed orders, limits by extrapolation and how sure they are, who is beaten by nobody."""
import math

import numpy as np

ROUNDING = 1e-13    # an error below it is rounding
SURE = 3.0          # an error counts for an order where it is so many times what the reference may be off by
AGREE = 0.1         # two slopes that differ by no more tell one order
FLAT = 0.1          # a slope below it: the error does not come from what is made smaller
EVEN = 0.01         # ratios of sizes that differ by no more are one ratio
ORDERS = (0.3, 6.0)  # what a limit is extrapolated with


def distance(a, b):
    """The largest difference of two sets of numbers; infinite where one has no number."""
    difference = np.abs(np.asarray(a, float) - np.asarray(b, float)).max(initial=0.0)
    return float(difference) if math.isfinite(difference) else math.inf


class Limit:
    """The limit of a series of numbers, and how far it may be off (`doubt`)."""

    def __init__(self, value, doubt, order=None):
        self.value, self.doubt, self.order = np.atleast_1d(np.asarray(value, float)), float(doubt), order

    def __repr__(self):
        return f"<limit {self.value} to {self.doubt:.1e}>"


def extrapolate(sizes, values):
    """The limit of values at sizes that go to zero, by Richardson's extrapolation.

    Three sizes with one ratio tell order and limit: with r the ratio of sizes and d1, d2 the changes of the values from one to the
    next, r^p = |d1|/|d2| and the limit is d2/(r^p - 1) beyond the last. It may be off by as much as the limits of the last three
    sizes and of the three before are apart; with three sizes alone, by as much as it is beyond the last. Where no order is seen the
    limit is the last value, which may be off by as much as the larger of the last two changes.
    """
    pairs = sorted(zip(sizes, (np.atleast_1d(np.asarray(value, float)) for value in values)), key=lambda pair: -pair[0])
    values = [value for _, value in pairs]
    limits = [beyond(pairs[k - 3:k]) for k in range(3, len(pairs) + 1)]
    if limits and limits[-1] is not None:
        limit, order = limits[-1]
        if len(limits) > 1 and limits[-2] is not None:
            return Limit(limit, distance(limit, limits[-2][0]), order)
        return Limit(limit, distance(limit, values[-1]), order)
    changes = [distance(a, b) for a, b in zip(values, values[1:])]
    return Limit(values[-1], max(changes[-2:], default=math.inf))


def beyond(three):
    """Limit and order of values at three sizes; None where they have no order."""
    (h1, v1), (h2, v2), (h3, v3) = three
    d1, d2, ratio = np.linalg.norm(v2 - v1), np.linalg.norm(v3 - v2), h1 / h2
    if abs(h2 / h3 / ratio - 1) > EVEN or not 0 < d2 < d1 < math.inf:
        return None
    order = math.log(d1 / d2) / math.log(ratio)
    same_way = (v2 - v1) @ (v3 - v2) > 0.5 * d1 * d2
    if not (same_way and ORDERS[0] < order < ORDERS[1]):
        return None
    return v3 + (v3 - v2) / (ratio**order - 1), order


def agreed(limits):
    """Of limits of the same thing the surest; its doubt is what makes it agree with the others."""
    best = min(limits, key=lambda limit: limit.doubt)
    others = (distance(best.value, limit.value) - limit.doubt for limit in limits if math.isfinite(limit.doubt))
    return Limit(best.value, max([best.doubt, *others]), best.order)


def observed_order(sizes, errors, doubt=0.0, impacts=False):
    """(order, words) of errors at sizes: the order and its digits, or None and why there is none.

    The order is the mean of two slopes, of neighbours among three sizes, that agree, the finest that do. Errors that the reference
    cannot tell from none do not count (none: doubt). Without two slopes that agree there is none: of impacts where bodies met, as
    their phase in the step decides; of a floor where errors do not come from the step.
    """
    floor = max(SURE * doubt, ROUNDING)
    pairs = sorted((size, error) for size, error in zip(sizes, errors) if error is not None and math.isfinite(error))
    if not pairs:
        return None, "none: no runs"
    pairs = [(size, error) for size, error in pairs if error > floor]
    if not pairs:
        return None, "none: doubt"
    slopes = [math.log(b / a) / math.log(y / x) for (x, a), (y, b) in zip(pairs, pairs[1:]) if y > x]
    if slopes and max(map(abs, slopes)) < FLAT:
        return None, "none: a floor"
    for finer, coarser in zip(slopes, slopes[1:]):
        if abs(finer - coarser) <= AGREE and min(finer, coarser) > FLAT:
            order = (finer + coarser) / 2
            return order, f"{order:.2f}"
    if impacts:
        return None, "none: impacts"
    return None, "none: uneven" if len(slopes) > 1 else "none: sizes"


def front(errors, costs):
    """Whether no other run is both cheaper and at least as exact, nor as cheap and more exact, for each run."""
    best, marked = math.inf, [False] * len(errors)
    for i in sorted(range(len(errors)), key=lambda i: (costs[i], errors[i])):
        if errors[i] < best:
            best, marked[i] = errors[i], True
    return marked


def cost_to_reach(wanted, sizes, errors, costs):
    """Cost of a method at the size from which on all its errors are at most as wanted; None where there is none.

    Between two sizes error and cost go as powers of the size. Where the largest size will do it is that one's cost.
    """
    best = None
    runs = sorted(zip(sizes, errors, costs))
    for (_, error, cost), (_, coarser, lower) in zip(runs, [*runs[1:], (None, math.inf, None)]):
        if error > wanted:
            break
        best = cost
        if wanted < coarser < math.inf and error > 0:
            best = cost * (lower / cost)**(math.log(wanted / error) / math.log(coarser / error))
    return best
