"""Three contact lines that share a torque, by NumPy and SciPy: the peer of tests/gear/load_space.rs, ref_three_lines_share_a_torque.

Cells of half spaces under semi-elliptic pressure as in src/gear/load/loaded_lines.rs, with the widths by plain repetition and the active
set by scipy.optimize.nnls on the factor of the compliance. Run: python3 tools/loaded_lines_peer.py (numpy, scipy); prints turn, greatest
pressure and shares for each torque, and the time of one torque.
"""

import time

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import nnls

SUM = 2.0 * (1.0 - 0.3**2) / 206e9
# Longer curvature 1/m, curvature across 1/m, gap at the middle m, arm m of each line; cells of each and their length m.
LINES = [(0.6, 64.5, 0.0, 0.1), (0.8, 70.0, 3e-6, 0.095), (0.5, 60.0, 8e-6, 0.105)]
CELLS, LENGTH = 32, 0.6e-3


def cells():
    along = (np.arange(CELLS) - 0.5 * (CELLS - 1)) * LENGTH
    gaps = np.concatenate([g + 0.5 * k1 * along**2 for k1, _, g, _ in LINES])
    arms = np.concatenate([np.full(CELLS, a) for _, _, _, a in LINES])
    across = np.concatenate([np.full(CELLS, k2) for _, k2, _, _ in LINES])
    return along, gaps, arms, across


def compliance(along, widths):
    whole = np.zeros((3 * CELLS, 3 * CELLS))
    apart = along[:, None] - along[None, :]
    for k in range(3):
        rows = slice(k * CELLS, (k + 1) * CELLS)
        b = widths[rows]
        y = 0.5 * b.max() * np.exp(-0.5)
        block = np.arcsinh((apart + 0.5 * LENGTH) / y) - np.arcsinh((apart - 0.5 * LENGTH) / y)
        block[np.diag_indices(CELLS)] += 2.0 * np.log(b.max() / b)
        whole[rows, rows] = SUM / np.pi / LENGTH * block
    return whole


def share(c, gaps, arms, torque):
    """min 1/2 F C F + g F over a F = torque, F >= 0: nnls on the factor, the equation as a heavy row."""
    factor = cholesky(c)
    right = -solve_triangular(factor, gaps, trans="T")
    heavy = 1e4 * np.abs(factor).max() / arms.max()
    rows = np.vstack([factor, heavy * arms])
    forces, _ = nnls(rows, np.append(right, heavy * torque), maxiter=10000)
    # The multiplier on the active set, exact.
    on = forces > 0.0
    by_arms = np.linalg.solve(c[np.ix_(on, on)], arms[on])
    by_gaps = np.linalg.solve(c[np.ix_(on, on)], gaps[on])
    turn = (torque + arms[on] @ by_gaps) / (arms[on] @ by_arms)
    forces[on] = turn * by_arms - by_gaps
    return forces, turn


def loaded(torque):
    along, gaps, arms, across = cells()
    forces = np.full(len(arms), torque / arms.sum())
    before = 0.0
    for sweep in range(60):
        widths = np.sqrt(4.0 * np.maximum(forces, 0.0) / LENGTH * SUM / np.pi / across)
        largest = widths.max()
        for k in range(3):
            rows = slice(k * CELLS, (k + 1) * CELLS)
            own = widths[rows].max()
            widths[rows] = np.maximum(widths[rows], 1e-4 * own if own > 0.0 else largest)
        forces, turn = share(compliance(along, widths), gaps, arms, torque)
        if abs(turn / before - 1.0 if before else 1.0) < 1e-12:
            break
        before = turn
    widths = np.sqrt(4.0 * np.maximum(forces, 0.0) / LENGTH * SUM / np.pi / across)
    on = forces > 0.0
    pressure = (2.0 * forces[on] / (np.pi * widths[on] * LENGTH)).max()
    shares = [(arms * forces)[k * CELLS : (k + 1) * CELLS].sum() / torque for k in range(3)]
    return turn, pressure, shares, sweep + 1


if __name__ == "__main__":
    for torque in (50.0, 200.0, 600.0):
        turn, pressure, shares, sweeps = loaded(torque)
        print(f"{torque:6.1f} N·m: turn {1e6 * turn:.6f} µrad, pressure {1e-6 * pressure:.4f} N/mm², shares "
              + ", ".join(f"{s:.6f}" for s in shares) + f", {sweeps} sweeps")
    times = []
    for _ in range(5):
        start = time.process_time()
        loaded(200.0)
        times.append(time.process_time() - start)
    print(f"one torque: {1e3 * min(times):.1f} ms")
