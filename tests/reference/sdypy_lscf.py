"""Times the LSCF of sdypy-EMA on the FRFs of tests/bench/identify.rs.

`python3 sdypy_lscf.py FRFS.npy STEP_HZ ORDER RUNS`; the bench runs it so, on the machine that it times. The file holds
functions x lines from 0 Hz, receptances, single references all of them. One BLAS thread. The time is that of `get_poles`, which
takes all orders from 1 to the highest, with real coefficients: as many poles at an order as complex ones have. Prints the version,
the fastest run by the clock and by processor time, and the poles of the highest order that are stable with positive frequency.

Used with sdypy-EMA 0.31.0 (`pip install sdypy-EMA==0.31.0`), numpy 2.4.6, scipy 1.17.1.
"""

import os

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

import importlib.metadata  # noqa: E402
import sys  # noqa: E402
import time  # noqa: E402

import numpy  # noqa: E402
from sdypy import EMA  # noqa: E402

frf = numpy.load(sys.argv[1])
step_hz, order, runs = float(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4])
axis = numpy.arange(frf.shape[1]) * step_hz
wall, processor = [], []
for _ in range(runs):
    # Lines from `upper` on are left out: one line more, so that all are used.
    model = EMA.Model(
        frf, axis, lower=axis[1], upper=axis[-1], pol_order_high=order, frf_form="receptance"
    )
    start = time.perf_counter(), time.process_time()
    model.get_poles(method="lscf", show_progress=False)
    wall.append(time.perf_counter() - start[0])
    processor.append(time.process_time() - start[1])
version = importlib.metadata.version("sdypy-EMA")
print(f"sdypy-EMA {version}, numpy {numpy.__version__}")
print(f"seconds {min(wall):.4f} {min(processor):.4f}")
for pole in model.all_poles[-1]:
    if pole.imag > 0 and pole.real < 0:
        print(f"pole {pole.real:.10e} {pole.imag:.10e}")
