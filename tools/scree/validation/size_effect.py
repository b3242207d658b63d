"""A notched beam whose ligament softens, by finite elements of second order: the reference of case j7."""
import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu


def line(x):
    """Quadratic elements between places: matrices of the integrals of N_i' N_j', N_i N_j and N_i N_j', and the places of the nodes."""
    n = len(x) - 1
    own = (np.array([[7, -8, 1], [-8, 16, -8], [1, -8, 7]]) / 3, np.array([[4, 2, -1], [2, 16, 2], [-1, 2, 4]]) / 30,
           np.array([[-3, 4, -1], [-4, 0, 4], [1, -4, 3]]) / 6)
    node = 2 * np.arange(n)[:, None] + np.arange(3)
    rows, columns = np.repeat(node, 3, axis=1).ravel(), np.tile(node, 3).ravel()
    return *(sp.csr_matrix((np.multiply.outer(np.diff(x)**power, of_one).ravel(), (rows, columns)))
             for power, of_one in zip((-1, 1, 0), own)), np.interp(np.arange(2 * n + 1), 2 * np.arange(n + 1), x)


class NotchedBeam:
    """Half of a beam on three points of depth 1, span 4 and E = 1, nu = 0, cut in its middle from the lower side to half of the depth. It has
    n quadratic elements over the depth. `stiffness` and `pull` are for the nodes of the ligament: forces along the beam = stiffness u - P pull."""

    def __init__(self, n):
        widths = np.minimum(1.12**np.arange(200) / n, 0.12)
        ends = np.concatenate([[0], np.cumsum(widths)])
        ends = ends[:np.searchsorted(ends, 2) + 1]
        (kx, mx, cx, x), (ky, my, cy, y) = line(2 * ends / ends[-1]), line(np.linspace(0, 1, n + 1))
        shear = 0.5 * sp.kron(cx, cy.T)  # of u,y with v,x
        stiffness = sp.bmat([[sp.kron(kx, my) + 0.5 * sp.kron(mx, ky), shear], [shear.T, sp.kron(mx, ky) + 0.5 * sp.kron(kx, my)]], "csr")
        size, foot = len(x) * len(y), (len(x) - 1) * len(y)
        ligament = np.flatnonzero(y >= 0.5)
        rest = np.setdiff1d(np.arange(2 * size), [*ligament, size + foot])
        load = np.zeros(2 * size)
        load[size + len(y) - 1] = -0.5
        beside = stiffness[rest][:, ligament].toarray()
        moved = splu(stiffness[rest][:, rest].tocsc()).solve(np.column_stack([beside, load[rest]]))
        self.stiffness = stiffness[ligament][:, ligament].toarray() - beside.T @ moved[:, :-1]
        self.pull = -beside.T @ moved[:, -1]
        self.width = np.bincount(2 * np.arange(n // 2).repeat(3) + np.tile(np.arange(3), n // 2), np.tile([1, 4, 1], n // 2) / (6 * n))

    def peak(self, depth):
        """Largest load over T and the depth, for a depth over E G/T^2. The tip opens in steps; a spring in each node, of 2000 E over the depth,
        bears up to T, and falls linearly to 0 at the opening 2G/T."""
        first, last = 1 / 2000, 2 / depth  # openings over T/E
        u, load, largest, most = np.zeros(len(self.pull)), 0.0, np.zeros(len(self.pull)), 0.0
        for tip in np.linspace(0, last, 301)[1:]:
            for _ in range(60):
                now = np.maximum(largest, 2 * u)
                secant = np.where(now > first, np.maximum(0, last - now) / (last - first) / np.maximum(now, first), 2000)
                falls = (2 * u >= now) & (now > first) & (now < last)
                matrix = np.zeros((len(u) + 1, len(u) + 1))
                matrix[:-1, :-1] = self.stiffness + np.diag(2 * self.width * np.where(falls, -1 / (last - first), secant))
                matrix[:-1, -1], matrix[-1, 0] = -self.pull, 1
                out = self.stiffness @ u + self.width * secant * 2 * u - load * self.pull
                change = np.linalg.solve(matrix, [*-out, tip / 2 - u[0]])
                u, load = u + change[:-1], load + change[-1]
                if np.abs(change[:-1]).max() < 1e-10 * last:
                    break
            largest, most = np.maximum(largest, 2 * u), max(most, load)
            if load < 0.9 * most:
                break
        return most
