"""Three discs run up at a prescribed speed, a clutch across their ends, for tests/machine/clutch.rs.

Discs of 5, 11 and 22 kg m2 on shafts of 100 and 200 kN m/rad; the first goes from rest to 50 rpm within 1 s. A clutch between
the first and the last is pressed from 0.5 s to 0.8 s, up to 400 N m sliding and 480 N m sticking, Stribeck speed 2 rpm.

Each stretch over which the clutch slides one way or sticks is integrated by itself (DOP853, rtol 1e-13); while it sticks the last
disc has the speed of the first. Its end is a root of the dense output.

    python tools/reference_clutch.py > data/reference/clutch.json
"""

import json
import math
import platform

import numpy
import scipy
from scipy.integrate import solve_ivp

J = (5.0, 11.0, 22.0)
K = (1e5, 2e5)
TOP, RISE = 50 * math.pi / 30, 1.0
SLIDING, RATIO, STRIBECK = 400.0, 1.2, 2 * math.pi / 30
PRESSED = (0.5, 0.8)
END, SAMPLES = 1.2, 59


def first(t):
    """Angle, speed and acceleration of the first disc."""
    if t < RISE:
        return 0.5 * TOP / RISE * t * t, TOP / RISE * t, TOP / RISE
    return 0.5 * TOP * RISE + TOP * (t - RISE), TOP, 0.0


def capacity(t):
    return SLIDING * min(max((t - PRESSED[0]) / (PRESSED[1] - PRESSED[0]), 0.0), 1.0)


def torque(t, y, mode, bend):
    """What the clutch carries: it turns the last disc back where positive."""
    if mode == 0:
        return -K[1] * (y[1] - y[0]) - J[2] * bend
    rate = y[3] - first(t)[1]
    return mode * capacity(t) * (1 + (RATIO - 1) * math.exp(-((rate / STRIBECK) ** 2)))


def slope(t, y, mode, bend):
    inner = (K[0] * (first(t)[0] - y[0]) - K[1] * (y[0] - y[1])) / J[1]
    last = (-K[1] * (y[1] - y[0]) - torque(t, y, mode, bend)) / J[2]
    return [y[2], y[3], inner, last, abs(torque(t, y, mode, bend) * (y[3] - first(t)[1]))]


def main():
    times = [END * k / SAMPLES for k in range(SAMPLES + 1)]
    stops = [PRESSED[0], PRESSED[1], RISE, END]
    t, y, mode, rows = 0.0, [0.0, 0.0, 0.0, 0.0, 0.0], -1, []
    while t < END - 1e-12:
        stop = min(s for s in stops if s > t + 1e-12)
        bend = first(0.5 * (t + stop))[2]

        def border(u, x, mode=mode, bend=bend):
            if mode == 0:
                return RATIO * capacity(u) - abs(torque(u, x, 0, bend))
            return mode * (x[3] - first(u)[1])

        reached, sol, hit = stretch(t, stop, y, mode, bend, border)
        for u in times[len(rows):]:
            if u > reached and not (reached >= END - 1e-12):
                break
            x = sol(min(u, reached))
            held = torque(u, x, mode, bend)
            drive = J[0] * bend + K[0] * (first(u)[0] - x[0]) - held
            rows.append([x[3], held, drive, x[4]])
        y, t = list(sol(reached)), reached
        if hit:
            if mode == 0:
                mode = 1 if torque(t, y, 0, bend) > 0 else -1
            else:
                y[3] = first(t)[1]
                mode = 0 if abs(torque(t, y, 0, bend)) <= RATIO * capacity(t) else -mode
    document = {
        "made_by": f"tools/reference_clutch.py, Python {platform.python_version()}, NumPy {numpy.__version__}, SciPy {scipy.__version__}",
        "time_s": times,
        "speed_rad_s": [r[0] for r in rows],
        "clutch_nm": [r[1] for r in rows],
        "drive_nm": [r[2] for r in rows],
        "lost_j": [r[3] for r in rows],
    }
    print(json.dumps(document, indent=1))


def stretch(t, stop, y, mode, bend, border):
    """To the stop or the border."""

    def event(u, x):
        # What has just been crossed is not looked for again at once.
        return border(u, x) if u > t + 1e-9 else 1.0

    event.terminal, event.direction = True, -1
    run = solve_ivp(
        lambda u, x: slope(u, x, mode, bend), (t, stop), y, "DOP853",
        rtol=1e-13, atol=1e-13, events=event, dense_output=True, max_step=1e-3,
    )
    hit = len(run.t_events[0]) > 0
    return (run.t_events[0][0] if hit else stop), run.sol, hit


main()
