"""Two discs with a shaft and a hardening coupling in series, the node between without inertia, for tests/machine/light_nodes.rs.

Discs of 1 and 0.5 kg m2; shaft 400 N m/rad, coupling 30 N m (delta/0.1)^3, dampers of 0.4 N m s/rad along both; 20 N m cos(2 pi 0.8 t)
on the first disc, 6 N m on the node, rising from 0.3 s to 0.8 s. The node is taken out by hand: its balance of torques is solved for
its speed, which leaves five equations (Radau, rtol 1e-12).

    python tools/reference_light.py > data/reference/light.json
"""

import json
import math
import platform

import numpy
import scipy
from scipy.integrate import solve_ivp

J, K, HARD, C = (1.0, 0.5), 400.0, 30.0 / 0.1**3, 0.4
TIMES = [0.02 * k for k in range(51)]


def load(t):
    return 6.0 * min(max((t - 0.3) / 0.5, 0.0), 1.0)


def slope(t, y):
    a, n, b, va, vb = y
    vn = (load(t) - K * (n - a) + HARD * (b - n) ** 3 + C * (va + vb)) / (2 * C)
    shaft = K * (n - a) + C * (vn - va)
    hard = HARD * (b - n) ** 3 + C * (vb - vn)
    return [va, vn, vb, (shaft + 20 * math.cos(1.6 * math.pi * t)) / J[0], -hard / J[1]]


def main():
    y, rows = [0.0] * 5, []
    for begin, end in [(0.0, 0.3), (0.3, 0.8), (0.8, 1.0)]:
        times = [t for t in TIMES if begin <= t <= end + 1e-12]
        run = solve_ivp(slope, (begin, end + 1e-12), y, "Radau", t_eval=times, rtol=1e-12, atol=1e-14)
        rows += [list(r) for r in run.y.T][1 if rows else 0:]
        y = run.y[:, -1]
    document = {
        "made_by": f"tools/reference_light.py, Python {platform.python_version()}, NumPy {numpy.__version__}, SciPy {scipy.__version__}",
        "a_rad": [r[0] for r in rows],
        "n_rad": [r[1] for r in rows],
        "b_rad": [r[2] for r in rows],
    }
    print(json.dumps(document, indent=1))


main()
