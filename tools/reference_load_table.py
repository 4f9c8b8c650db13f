"""A pair of gears with backlash whose mesh follows its load: SciPy's DOP853 for tests/machine/load_tables.rs.

The law is evaluated as SciPy has it: `CubicHermiteSpline` of the deflection over the load, inverted by `brentq`, its energy by
`integrate`. Without loads the phase goes by the angle of the pinion; with loads it goes by its mean speed.

    python tools/reference_load_table.py > data/reference/load_table.json
"""

import json
import platform

import numpy as np
import scipy
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq

K = 1e8
LOADS = np.array([2e-6, 5e-6, 1e-5, 2e-5])  # over K, m
POSITIONS = 6
SHAPE = 1.0 + 0.2 * np.cos(2 * np.pi * np.arange(POSITIONS) / POSITIONS)


def tables():
    """Deflection, m, and its derivative by load at every position."""
    hertz = 2e-6 * (LOADS / 1e-5) ** (2 / 3)
    return (np.outer(SHAPE, LOADS) + hertz,
            np.outer(SHAPE, np.ones(4)) + hertz * (2 / 3) / LOADS)


DEFLECTIONS, COMPLIANCES = tables()


def law(g, psi):
    """F/K, V/K and its derivative by psi at a penetration."""
    at = (psi % 1.0) * POSITIONS
    i = int(at) % POSITIONS
    s, j = at - int(at), (int(at) + 1) % POSITIONS
    d, c = [(1 - s) * x[i] + s * x[j] for x in (DEFLECTIONS, COMPLIANCES)]
    dd, dc = [x[j] - x[i] for x in (DEFLECTIONS, COMPLIANCES)]
    p = c[0] * LOADS[0] / d[0]
    dp = (dc[0] * LOADS[0] - p * dd[0]) / d[0]

    def first(x):
        """Integral of the deflection over the load below the first load, and its derivative by s."""
        if x <= 0.0:
            return 0.0, 0.0
        size = LOADS[0] * x ** (p + 1) / (p + 1)
        return size * d[0], size * (dd[0] + d[0] * dp * (np.log(x) - 1 / (p + 1)))

    if g < d[0]:
        load = LOADS[0] * (g / d[0]) ** (1 / p)
        area, slope = first(load / LOADS[0])
    else:
        curve, change = CubicHermiteSpline(LOADS, d, c), CubicHermiteSpline(LOADS, dd, dc)
        area, slope = first(1.0)
        if g < d[-1]:
            load = brentq(lambda f: curve(f) - g, LOADS[0] * (1 - 1e-9), LOADS[-1], xtol=1e-22, rtol=1e-15)
            end = load
        else:
            load, end = LOADS[-1] + (g - d[-1]) / c[-1], LOADS[-1]
        beyond = load - end
        area += curve.integrate(LOADS[0], end) + beyond * (d[-1] + beyond * c[-1] / 2)
        slope += change.integrate(LOADS[0], end) + beyond * (dd[-1] + beyond * dc[-1] / 2)
    return load, load * g - area, -slope * POSITIONS


J = np.array([0.01, 0.02])
LEVERS = np.cos(np.radians(20)) * np.array([0.02, 0.04])
HALF_PLAY = 5e-5
TEETH = 20
SPEED = 50.0  # rad/s of the pinion where the phase goes by it


def motion(by_angle, loads):
    def rates(t, y):
        q, v = y[:2], y[2:]
        psi = TEETH * (q[0] if by_angle else SPEED * t) / (2 * np.pi)
        delta = LEVERS @ q
        g = abs(delta) - HALF_PLAY
        torque = np.array(loads, dtype=float)
        if g > 0.0:
            load, _, slope = law(g, psi)
            torque -= LEVERS * K * load * np.sign(delta)
            if by_angle:
                torque[0] -= K * slope * TEETH / (2 * np.pi)
        return np.concatenate([v, torque / J])

    start = [0.0, 0.0, 52.0, -25.0]
    got = solve_ivp(rates, [0.0, 0.02], start, method="DOP853", rtol=1e-12, atol=1e-14, max_step=2e-6)
    return got.y[:, -1]


if __name__ == "__main__":
    print(json.dumps({
        "source": f"tools/reference_load_table.py, scipy {scipy.__version__}, python {platform.python_version()}",
        "state": "angles of pinion and gear, rad, then speeds, rad/s, after 0.02 s",
        "free": motion(True, [0, 0]).tolist(),
        "loaded": motion(False, [30, 60]).tolist(),
    }, indent=1))
