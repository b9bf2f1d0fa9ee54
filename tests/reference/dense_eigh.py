"""Times numpy's LAPACK on a symmetric pair (K, M) that a bench wrote: Cholesky of M, reduction, eigh, back-transformation.

`python3 dense_eigh.py FOLDER SIZE` reads FOLDER/k.f64 and FOLDER/m.f64, little-endian, column after column, and prints the
fastest of five runs and the largest error of K phi = omega^2 M phi over the largest omega^2. Run with
OPENBLAS_NUM_THREADS=1, as the library runs on the calling thread.
"""

import sys
import time

import numpy

folder, size = sys.argv[1], int(sys.argv[2])
stiffness, mass = (
    numpy.fromfile(f"{folder}/{name}.f64", dtype="<f8").reshape(size, size).T for name in "km"
)


def modes():
    lower = numpy.linalg.cholesky(mass)
    half = numpy.linalg.solve(lower, stiffness)
    reduced = numpy.linalg.solve(lower, half.T)
    values, vectors = numpy.linalg.eigh(0.5 * (reduced + reduced.T))
    return values, numpy.linalg.solve(lower.T, vectors)


seconds = []
for _ in range(5):
    start = time.perf_counter()
    values, vectors = modes()
    seconds.append(time.perf_counter() - start)
residual = stiffness @ vectors - mass @ vectors * values
scaled = residual / numpy.sqrt(numpy.diag(mass))[:, None]
print(f"numpy {numpy.__version__} {numpy.show_config('dicts')['Build Dependencies']['lapack']['name']}")
print(f"seconds {min(seconds):.4f}")
print(f"residual {abs(scaled).max() / abs(values).max():.2e}")
