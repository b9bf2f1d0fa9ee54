"""Times scipy's shift-invert eigsh on the structures of tests/bench/sparse_modes.rs.

A unit square or cube of bilinear (trilinear) elements with consistent mass, its edges held: K = sum K1 x M1 (x M1),
M = M1 x M1 (x M1) with the tridiagonal matrices K1, M1 of a bar. Prints the fastest of three runs, factorisation
included, and the eigenvalues. `python3 sparse_eigsh.py DIMENSIONS NODES MODES`; the bench runs it so, on the machine that
it times.
"""

import sys
import time
from functools import reduce

import numpy
import scipy
import scipy.sparse as sparse
from scipy.sparse.linalg import eigsh

dimensions, nodes, modes = (int(argument) for argument in sys.argv[1:4])
h = 1.0 / (nodes + 1)
ones = numpy.ones(nodes)
k1 = sparse.diags([-ones[1:] / h, 2 * ones / h, -ones[1:] / h], [-1, 0, 1])
m1 = sparse.diags([ones[1:] * h / 6, 4 * ones * h / 6, ones[1:] * h / 6], [-1, 0, 1])


def product(along):
    factors = [k1 if axis == along else m1 for axis in range(dimensions)]
    return reduce(lambda a, b: sparse.kron(a, b, format="csc"), factors)


mass = product(None)
stiffness = sum(product(axis) for axis in range(dimensions)).tocsc()
seconds = []
for _ in range(3):
    start = time.perf_counter()
    values = eigsh(stiffness, k=modes, M=mass, sigma=0.0, which="LM", return_eigenvectors=True)[0]
    seconds.append(time.perf_counter() - start)
print(f"scipy {scipy.__version__} numpy {numpy.__version__} dimensions {dimensions} nodes {nodes}")
print(f"seconds {min(seconds):.3f}")
print("values", *(f"{value:.10e}" for value in sorted(values)))
