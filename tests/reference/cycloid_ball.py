"""Angular frequencies of the cycloid ball transmission from the stiffness matrix as the paper prints it.

Run with: python3 cycloid_ball.py > cycloid_ball.txt   (needs numpy)
"""

import platform

import numpy as np

BALLS, PINS = 10, 6
K = dict(a=8.15e6, b=8.73e6, c=7.90e6, d=7.90e6, da=7.90e6, db=1.90e6, dc=1.90e6, dd=7.90e6)
SUPPORT = dict(k01=6e7, k1=6e7, k5y=6e7, k03x=7e7, k1u=6e5)
MASS = dict(m0=66.4e-3, m1=127e-3, m2=7.64e-3, m4=8.6e-3, m5=111e-3, j0=1.20e-6, j1=30.0e-6, j3=10.6e-6, j5=10.8e-6)
SETS = {  # m3 (kg), trochoid ratio, e (m), pin circle radius (m), k03y (N/m)
    "A": (96.4e-3, 0.3, 1.2e-3, 50e-3, 7e7),
    "B": (36.4e-3, 0.3, 1.2e-3, 50e-3, 7e7),
    "C": (36.4e-3, 0.8499, 1.199e-3, 50.06e-3, 7e7),
    "D": (36.4e-3, 0.8655, 1.2034e-3, 50.08e-3, 6.239e7),
}


def omegas(m3, ratio, e, radius, k03y):
    cos2 = 49176.0**2 * MASS["m2"] / (K["a"] + K["b"] + K["c"] + K["d"])
    cos2_pin = 33679.0**2 * MASS["m4"] / (K["da"] + K["db"] + K["dc"] + K["dd"])
    theta = 2 * np.pi * np.arange(BALLS) / BALLS
    phi = np.arctan2(np.sin(theta), np.cos(theta) + ratio)
    s, c = np.sin(phi), np.cos(phi)
    ab, cd = (K["a"] + K["b"]) * cos2, (K["c"] + K["d"]) * cos2
    g, h = (K["da"] + K["db"]) * cos2_pin, (K["dd"] + K["dc"]) * cos2_pin
    arm, sine = (BALLS + 1) * e, np.sin(2 * np.pi * np.arange(PINS) / PINS)
    n = 11 + 2 * BALLS + PINS
    p, q, o = 6 + 2 * BALLS, 9 + 2 * BALLS, 9 + 2 * BALLS + PINS
    stiffness = np.zeros((n, n))

    def tie(k, **row):
        b = np.zeros(n)
        for name, value in row.items():
            b[int(name[1:])] = value
        stiffness[:] += k * np.outer(b, b)

    tie(SUPPORT["k01"], _0=1, _3=-1)
    tie(SUPPORT["k01"], _1=1, _4=-1)
    tie(SUPPORT["k1"], _3=1)
    tie(SUPPORT["k1"], _4=1)
    tie(SUPPORT["k1u"], _5=1)
    tie(SUPPORT["k5y"], **{f"_{o}": 1})
    tie(SUPPORT["k03x"], _0=1, _2=-2 * e, **{f"_{p}": -1})
    tie(k03y, _1=1, **{f"_{p + 1}": -1})
    for i in range(BALLS):
        ball = {f"_{6 + 2 * i}": -s[i], f"_{7 + 2 * i}": c[i]}
        tie(ab, **ball, **{f"_{p}": s[i], f"_{p + 1}": -c[i], f"_{p + 2}": arm * s[i]})
        tie(cd, **ball, _3=s[i], _4=-c[i], _5=arm * s[i])
    for j in range(PINS):
        tie(g, **{f"_{q + j}": 1, f"_{p + 1}": -1, f"_{p + 2}": -radius * sine[j]})
        tie(h, **{f"_{q + j}": 1, f"_{o}": -1, f"_{o + 1}": -radius * sine[j]})
    mass = [MASS["m0"], MASS["m0"], MASS["j0"], MASS["m1"], MASS["m1"], MASS["j1"]]
    mass += [MASS["m2"]] * (2 * BALLS) + [m3, m3, MASS["j3"]] + [MASS["m4"]] * PINS + [MASS["m5"], MASS["j5"]]
    root = 1 / np.sqrt(np.array(mass))
    values = np.linalg.eigvalsh(stiffness * np.outer(root, root))
    return np.sqrt(np.clip(values, 0, None))


if __name__ == "__main__":
    print(f"# numpy {np.__version__}, Python {platform.python_version()}; rad/s, ascending")
    for name, values in SETS.items():
        for omega in omegas(*values):
            # The eleven zeros differ from 0 by rounding of the largest root.
            print(name, f"{0.0 if omega < 1.0 else omega:.9f}")
