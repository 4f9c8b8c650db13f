"""Motion of gears whose teeth rub, written pair by pair, for tests/machine/friction.rs.

Two gears on parallel axes, z = 20 and 60, module 2 mm, 20 deg, tips one module above the pitch circles. Positive turns of
the two are opposite in a running pair: delta = rb1 theta1 + rb2 theta2. Pairs that touch at once share the force evenly; each
rubs with mu |F| at its own distance s from the pitch point, against the sense of s (theta1' - theta2').

Every stretch over which the same pairs touch on the same sides of the pitch point is integrated by itself (DOP853, rtol
1e-13), its end found as a root of the dense output.

Also a gear on a spring whose bearing carries the force of the mesh: T = T0 + mu r |F|, with sticking.

    python tools/reference_friction.py > data/reference/friction.json
"""

import json
import math
import platform

import numpy
import scipy
from scipy.integrate import solve_ivp

Z = (20, 60)
MODULE = 2e-3
ALPHA = math.radians(20)
RB = [0.5 * z * MODULE * math.cos(ALPHA) for z in Z]
RA = [0.5 * z * MODULE + MODULE for z in Z]
PB = math.pi * MODULE * math.cos(ALPHA)
RECESS = (math.sqrt(RA[0] ** 2 - RB[0] ** 2) - RB[0] * math.tan(ALPHA)) / PB
APPROACH = (math.sqrt(RA[1] ** 2 - RB[1] ** 2) - RB[1] * math.tan(ALPHA)) / PB
K, C, MU = 2e8, 400.0, 0.08
J = (2e-3, 0.08)
TORQUES = (30.0, 40.0)
DRAG = 2.0


def pairs(psi):
    """Places of the touching pairs, drive flank, in base pitches, for psi inside a stretch."""
    x = psi - APPROACH
    first = math.ceil(-APPROACH - x)
    places = []
    while x + first < RECESS:
        places.append(first)
        first += 1
    return places


def slope(touching, sides):
    def f(t, y):
        t1, t2, v1, v2 = y
        force = K * (RB[0] * t1 + RB[1] * t2) + C * (RB[0] * v1 + RB[1] * v2)
        psi = Z[0] * t1 / (2 * math.pi)
        sense = 1.0 if v1 - v2 > 0 else -1.0
        g1 = TORQUES[0] - RB[0] * force
        g2 = TORQUES[1] - RB[1] * force - DRAG * v2
        for pair, side in zip(touching, sides):
            s = (psi - APPROACH + pair) * PB
            rub = MU * abs(force) / len(touching) * side * sense
            g1 -= rub * (RB[0] * math.tan(ALPHA) + s)
            g2 -= rub * (RB[1] * math.tan(ALPHA) - s)
        return [v1, v2, g1 / J[0], g2 / J[1]]

    return f


def run(y, until, samples):
    edges = sorted({0.0, (APPROACH + RECESS) % 1.0, APPROACH % 1.0})
    times = numpy.linspace(0, until, samples + 1)
    out = [y]
    t, psi = 0.0, Z[0] * y[0] / (2 * math.pi)
    at = 1
    turn = math.floor(psi)
    piece = max(i for i, e in enumerate(edges) if e <= psi - turn)
    while t < until:
        lower = turn + edges[piece]
        upper = turn + (edges[piece + 1] if piece + 1 < len(edges) else 1.0)
        middle = 0.5 * (lower + upper)
        touching = pairs(middle)
        sides = [1.0 if middle - APPROACH + p > 0 else -1.0 for p in touching]

        def leaves(t, y, upper=upper):
            return Z[0] * y[0] / (2 * math.pi) - upper

        leaves.terminal, leaves.direction = True, 1
        wanted = times[at:]
        found = solve_ivp(
            slope(touching, sides), (t, until), y, method="DOP853", rtol=1e-13, atol=1e-15,
            events=leaves, dense_output=True,
        )
        end = found.t[-1]
        while at <= samples and times[at] <= end:
            out.append([float(x) for x in found.sol(times[at])])
            at += 1
        t, y = end, [float(x) for x in found.y[:, -1]]
        if found.status == 1:
            piece += 1
            if piece == len(edges):
                piece, turn = 0, turn + 1
    return times.tolist(), out


def stick(k, inertia, constant, lever, start, until, samples):
    """J x'' + k x = -sgn(x') (T0 + l k |x|), which sticks where k |x| <= T0 + l k |x|: closed between turns.

    The force that presses is the spring's own. On the way from +a to -b: x'' = -w^2 (1 -+ l) x + T0/J with the sign of x.
    """
    out = []
    times = numpy.linspace(0, until, samples + 1)

    def f(t, y, sense):
        return [y[1], (-k * y[0] - sense * (constant + lever * k * abs(y[0]))) / inertia]

    t, y = 0.0, [start, 0.0]
    at = 0
    while at <= samples:
        pull = -k * y[0]
        if abs(pull) <= constant + lever * k * abs(y[0]):
            out += [[y[0], 0.0]] * (samples + 1 - at)
            break
        sense = 1.0 if pull > 0 else -1.0
        found = integrate(f, t, y, sense, until + 1)
        end = found[-1].t[-1]
        while at <= samples and times[at] <= end:
            sol = next(p for p in found if p.t[-1] >= times[at])
            out.append([float(x) for x in sol.sol(times[at])])
            at += 1
        t, y = end, [float(found[-1].y[0, -1]), 0.0]
    return times.tolist(), out[: samples + 1]


def integrate(f, t, y, sense, until):
    """One swing, cut where x passes zero, for the corner of |x|."""
    parts = []
    for target in (0, 1):

        def event(t, y, sense, target=target):
            return y[target]

        event.terminal = True
        event.direction = sense if target == 0 else -sense
        part = solve_ivp(f, (t, until), y, args=(sense,), method="DOP853", rtol=1e-13, atol=1e-16,
                         events=event, dense_output=True, first_step=1e-4)
        parts.append(part)
        t, y = part.t[-1], [float(x) for x in part.y[:, -1]]
        if target == 0:
            y[0] = 0.0
    return parts


if __name__ == "__main__":
    speed = 40.0
    start = [0.0, 0.0, speed, -speed / 3]
    times, states = run(start, 0.05, 50)
    swings, places = stick(100.0, 1.0, 0.6, 0.15, 0.3, 4.0, 80)
    print(json.dumps({
        "source": f"tools/reference_friction.py, scipy {scipy.__version__}, python {platform.python_version()}",
        "teeth": {"time_s": times, "states": states},
        "bearing": {"time_s": swings, "states": places},
    }))
