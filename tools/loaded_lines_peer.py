"""Three contact lines that share a torque, by NumPy and SciPy: the peer of tests/gear/load_space.rs, ref_three_lines_share_a_torque, and
of benches/gears_peer.py.

Cells of half spaces under semi-elliptic pressure as in src/gear/load/loaded_lines.rs, with the widths by plain repetition and the active
set by scipy.optimize.nnls on the factor of the compliance. Run: python3 tools/loaded_lines_peer.py (numpy, scipy); prints turn, greatest
pressure and shares for each torque, and the time of one torque.
"""

import time

import numpy as np
from scipy.linalg import block_diag, cholesky, solve_triangular
from scipy.optimize import nnls

SUM = 2.0 * (1.0 - 0.3**2) / 206e9
# Longer curvature 1/m, curvature across 1/m, gap at the middle m, arm m of each line; cells of each and their length m.
LINES = [(0.6, 64.5, 0.0, 0.1), (0.8, 70.0, 3e-6, 0.095), (0.5, 60.0, 8e-6, 0.105)]
CELLS, LENGTH = 32, 0.6e-3
# Change of the turn between two sweeps at which the widths are settled.
SETTLED = 1e-12


def cells():
    """The lines, each as columns: place along it, length, gap, arm, curvature across."""
    along = (np.arange(CELLS) - 0.5 * (CELLS - 1)) * LENGTH
    same = np.ones(CELLS)
    return [np.array([along, LENGTH * same, g + 0.5 * k1 * along**2, a * same, k2 * same]) for k1, k2, g, a in LINES]


def compliance(lines, widths):
    blocks = []
    for (along, length, *_), b in zip(lines, widths):
        apart = along[:, None] - along[None, :]
        y = 0.5 * b.max() * np.exp(-0.5)
        block = np.arcsinh((apart + 0.5 * length) / y) - np.arcsinh((apart - 0.5 * length) / y)
        block[np.diag_indices(len(b))] += 2.0 * np.log(b.max() / b)
        block = SUM / np.pi * block / length
        blocks.append(0.5 * (block + block.T))
    return block_diag(*blocks)


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


def half_widths(lines, forces):
    ends = np.cumsum([line.shape[1] for line in lines])[:-1]
    own = [np.maximum(f, 0.0) for f in np.split(forces, ends)]
    return [np.sqrt(4.0 * f / line[1] * SUM / np.pi / line[4]) for f, line in zip(own, lines)]


def loaded(lines, torque, forces=None):
    """Turn and forces of lines as `cells` has them, the sweeps; `forces` are those to start from."""
    gaps, arms = (np.concatenate([line[k] for line in lines]) for k in (2, 3))
    forces = np.full(len(arms), torque / arms.sum()) if forces is None else forces
    before = 0.0
    for sweep in range(60):
        widths = half_widths(lines, forces)
        largest = max(b.max() for b in widths)
        widths = [np.maximum(b, 1e-4 * b.max() if b.max() > 0.0 else largest) for b in widths]
        forces, turn = share(compliance(lines, widths), gaps, arms, torque)
        if abs(turn / before - 1.0 if before else 1.0) < SETTLED:
            break
        before = turn
    return turn, forces, sweep + 1


if __name__ == "__main__":
    lines = cells()
    for torque in (50.0, 200.0, 600.0):
        turn, forces, sweeps = loaded(lines, torque)
        length, arms = (np.concatenate([line[k] for line in lines]) for k in (1, 3))
        widths, on = np.concatenate(half_widths(lines, forces)), forces > 0.0
        pressure = (2.0 * forces[on] / (np.pi * widths[on] * length[on])).max()
        shares = (arms * forces).reshape(3, CELLS).sum(axis=1) / torque
        print(f"{torque:6.1f} N·m: turn {1e6 * turn:.6f} µrad, pressure {1e-6 * pressure:.4f} N/mm², shares "
              + ", ".join(f"{s:.6f}" for s in shares) + f", {sweeps} sweeps")
    times = []
    for _ in range(5):
        start = time.process_time()
        loaded(lines, 200.0)
        times.append(time.process_time() - start)
    print(f"one torque: {1e3 * min(times):.1f} ms")
