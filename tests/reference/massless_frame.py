"""Condensed problems of lumped-mass space frames whose rotations carry no mass.

The frame of tests/suite/massless.rs: 4 x 5 columns on clamped feet, storeys of beams along x and y, Euler-Bernoulli members
along the axes, masses at the translations of every node, two nodes of the last storey left out, one node propped along x
and y. All entries of K and M are whole numbers, so that two programs assemble the same matrices. Eight storeys have 946
coordinates, 474 of them massless.

Statics removes the rotations: K_c = K_aa - K_ao K_oo^-1 K_oa. Prints the lowest natural frequencies (Hz), their relative
sensitivities p/f df/dp to the three parameters, and the parameters that minimise
sum ((f/f_test - 1)/sigma)^2 + sum (ln(p/p_0)/0.03)^2 for the lowest 12 frequencies of the frame with other parameters.

Run with: python3 massless_frame.py > massless_frame.txt   (needs numpy)
"""

import platform

import numpy as np

NX, NY, LENGTH = 4, 5, 4.0
MODES, MEASURED, FLOOR, PRIOR = 30, 12, 1e-6, 0.03
TRUTH = {"columns": 1.1, "beams": 0.93, "live": 1.2}
# EA, GJ, EI for bending along the first and the second axis after the axis of the member, in the order x, y, z, x, ...
COLUMN = (4.0e9, 3.2e7, 6.4e7, 1.28e8)
BEAM_X = (2.0e9, 1.6e7, 3.2e7, 9.6e7)
BEAM_Y = (2.4e9, 2.4e7, 1.28e8, 4.8e7)


def frame(storeys):
    """Stiffness of columns and beams, permanent and live mass, over the free coordinates; which of them are massless."""
    last = [(storeys, NY - 1, NX - 1), (storeys, NY - 1, NX - 2)]
    nodes = [(s, y, x) for s in range(storeys + 1) for y in range(NY) for x in range(NX)]
    nodes = [node for node in nodes if node not in last]
    place = {node: i for i, node in enumerate(nodes)}
    size = 6 * len(nodes)
    columns, beams = np.zeros((size, size)), np.zeros((size, size))

    def member(matrix, first, second, axis, section):
        a, b = 6 * place[first], 6 * place[second]
        ea, gj, *bending = section
        for offset, k in [(axis, ea / LENGTH), (3 + axis, gj / LENGTH)]:
            i, j = a + offset, b + offset
            matrix[i, i] += k
            matrix[j, j] += k
            matrix[i, j] -= k
            matrix[j, i] -= k
        h = LENGTH
        for turn, ei in enumerate(bending):
            across, about = (axis + 1 + turn) % 3, (axis + 2 - turn) % 3
            sign = 1.0 if turn == 0 else -1.0
            at = [a + across, a + 3 + about, b + across, b + 3 + about]
            signs = np.array([1.0, sign, 1.0, sign])
            element = np.array(
                [[12, 6 * h, -12, 6 * h], [6 * h, 4 * h * h, -6 * h, 2 * h * h],
                 [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h * h, -6 * h, 4 * h * h]])
            matrix[np.ix_(at, at)] += ei / h**3 * element * np.outer(signs, signs)

    for s, y, x in nodes:
        if s > 0:
            member(columns, (s - 1, y, x), (s, y, x), 2, COLUMN)
            if (s, y, x + 1) in place:
                member(beams, (s, y, x), (s, y, x + 1), 0, BEAM_X)
            if (s, y + 1, x) in place:
                member(beams, (s, y, x), (s, y + 1, x), 1, BEAM_Y)
    permanent, live = np.zeros(size), np.zeros(size)
    for (s, y, x), i in place.items():
        number = (s * NY + y) * NX + x + 1
        permanent[6 * i : 6 * i + 3] = 2000.0 + 100.0 * (number % 7)
        live[6 * i : 6 * i + 3] = 800.0 if s % 2 == 0 else 0.0
    propped = 6 * place[(4, 0, 0)]
    free = [i for i in range(6 * NX * NY, size) if i not in (propped, propped + 1)]
    massless = np.array([i % 6 > 2 for i in free])
    cut = np.ix_(free, free)
    return columns[cut], beams[cut], permanent[free], live[free], massless


class Frame:
    def __init__(self, storeys):
        self.columns, self.beams, self.permanent, self.live, self.massless = frame(storeys)

    def solve(self, p, count):
        """Angular frequencies, shapes at all coordinates of unit modal mass."""
        k = p["columns"] * self.columns + p["beams"] * self.beams
        m = self.permanent + p["live"] * self.live
        a, o = ~self.massless, self.massless
        follow = -np.linalg.solve(k[np.ix_(o, o)], k[np.ix_(o, a)])
        condensed = k[np.ix_(a, a)] + k[np.ix_(a, o)] @ follow
        root = 1.0 / np.sqrt(m[a])
        condensed = 0.5 * (condensed + condensed.T) * np.outer(root, root)
        values, vectors = np.linalg.eigh(condensed)
        phi = np.zeros((k.shape[0], count))
        phi[a] = root[:, None] * vectors[:, :count]
        phi[o] = follow @ phi[a]
        # A Rayleigh quotient, whose error is the square of that of the shape.
        wide = phi.astype(np.longdouble)
        values = np.sum(wide * (k.astype(np.longdouble) @ wide), axis=0) / (m.astype(np.longdouble) @ wide**2)
        return np.sqrt(values.astype(float)), phi

    def sensitivities(self, p, omega, phi):
        """p/f df/dp, one column for each parameter."""
        by = [p["columns"] * np.sum(phi * (self.columns @ phi), axis=0),
              p["beams"] * np.sum(phi * (self.beams @ phi), axis=0),
              -p["live"] * omega**2 * (self.live @ phi**2)]
        return np.array(by).T / (2 * omega[:, None] ** 2)

    def updated(self):
        names = ["columns", "beams", "live"]
        measured = self.solve(TRUTH, MEASURED)[0]
        z = np.zeros(3)
        for _ in range(30):
            p = dict(zip(names, np.exp(PRIOR * z)))
            omega, phi = self.solve(p, MEASURED)
            residual = np.concatenate([(omega / measured - 1) / FLOOR, z])
            slopes = self.sensitivities(p, omega, phi) * PRIOR * (omega / measured)[:, None] / FLOOR
            step = np.linalg.lstsq(np.vstack([slopes, np.eye(3)]), -residual, rcond=None)[0]
            z = z + step
            if np.max(np.abs(step)) < 1e-13:
                break
        return dict(zip(names, np.exp(PRIOR * z)))


def main():
    print(f"# numpy {np.__version__}, Python {platform.python_version()}; Hz, then p/f df/dp of columns, beams, live")
    for name, storeys in [("small", 4), ("dense", 8), ("sparse", 11)]:
        structure = Frame(storeys)
        nominal = {"columns": 1.0, "beams": 1.0, "live": 1.0}
        omega, phi = structure.solve(nominal, MODES)
        by = structure.sensitivities(nominal, omega, phi)
        print(f"{name} coordinates {structure.massless.size} {structure.massless.sum()}")
        for f, row in zip(omega / (2 * np.pi), by):
            print(name, "mode", f"{f:.15e}", *(f"{value:.15e}" for value in row))
        if name != "sparse":
            print(name, "updated", *(f"{value:.15e}" for value in structure.updated().values()))


if __name__ == "__main__":
    main()
