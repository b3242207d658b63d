"""Arrays as few bytes that a browser makes arrays of again (`packing.js`).

Each array is of whole numbers. Along its last axis, which is time where it has one, each number is replaced by its change from the one
before, the changes are folded to numbers from 0 (0, -1, 1, -2, ... become 0, 1, 2, 3, ...), and of these all lowest bytes stand
together, then all bytes above: what moves smoothly has few bytes above, and gzip finds what is alike.
"""
import base64
import gzip

import numpy as np

POSITIONS, SHADES, ROOTS = 8191, 2047, 511  # whole numbers on each side of zero: of motion, of stress and velocity, of roots of forces
PLACES = 2**30  # steps over the size of the scene that places at the start have


def quantised(series, levels, axes):
    """A series as whole numbers up to so many on each side of zero, and what they are multiples of: one factor for what is along
    the axes. What is off is at most half of the factor."""
    largest = np.abs(series).max(axis=axes, keepdims=True, initial=0.0)
    factor = np.where(largest > 0, largest, 1.0) / levels
    return np.rint(series / factor).astype(np.int64), factor.squeeze(axes)


class Pack:
    """Arrays by their names, to be written one after the other."""

    def __init__(self):
        self.directory, self.parts, self.end = {}, [], 0

    def add(self, name, values):
        """Adds an array of whole numbers below 2^31."""
        values = np.asarray(values, np.int64)
        change = np.diff(values, axis=-1, prepend=0).ravel()
        folded = np.where(change >= 0, 2 * change, -2 * change - 1).astype("<u8")
        n_bytes = max(1, (int(folded.max(initial=0)).bit_length() + 7) // 8)
        planes = folded.view(np.uint8).reshape(-1, 8)[:, :n_bytes].T
        self.directory[name] = {"at": self.end, "bytes": n_bytes, "shape": list(values.shape)}
        self.parts.append(np.ascontiguousarray(planes).tobytes())
        self.end += planes.size

    def text(self):
        """All of it as text."""
        return base64.b64encode(gzip.compress(b"".join(self.parts), 9, mtime=0)).decode()
