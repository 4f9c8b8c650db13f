"""The peers of benches/transmission.rs: the same counts through NumPy, as a lab's script would.

Each prints the best time on the processor in seconds and the worst relative error of an amplitude. `interpolate FILE` brings the error
to even angles by straight lines and transforms whole hunting cycles; `fit FILE` solves for four orders by least squares.
"""

import sys
import time

import numpy as np

COUNTS = (40_000.0, 72_000.0)
RATIO = 21.0 / 64.0
ERRORS = ((1.0, 5e-5), (64.0 / 21.0, 2e-5), (64.0, 1.5e-5), (128.0, 4e-6))


def error(path):
    """Turns of the output and the error, rad."""
    first, second = np.split(np.fromfile(path), 2)
    return first, second


def difference(first, second):
    turns = first * (RATIO / COUNTS[0])
    return turns, 2.0 * np.pi * (second / COUNTS[1] - turns)


def interpolate(first, second):
    turns, e = difference(first, second)
    cells = 1024
    hunting = 21
    cycles = int((turns[-1] - turns[0]) // hunting)
    even = turns[0] + np.arange(cycles * hunting * cells) / cells
    amplitude = np.abs(np.fft.rfft(np.interp(even, turns, e))) * 2.0 / len(even)
    return [amplitude[round(order * cycles * hunting)] for order, _ in ERRORS]


def fit(first, second):
    turns, e = difference(first, second)
    columns = [np.ones_like(turns)]
    for order, _ in ERRORS:
        angle = (2.0 * np.pi * order) * turns
        columns += [np.cos(angle), np.sin(angle)]
    gram = np.array([[a @ b for b in columns] for a in columns])
    x = np.linalg.solve(gram, np.array([a @ e for a in columns]))
    return [np.hypot(x[2 * k + 1], x[2 * k + 2]) for k in range(len(ERRORS))]


def best(runs, work, path):
    data = error(path)
    times = []
    for _ in range(runs):
        start = time.process_time()
        found = work(*data)
        times.append(time.process_time() - start)
    off = max(abs(a / truth - 1.0) for a, (_, truth) in zip(found, ERRORS))
    print(min(times), off)


if __name__ == "__main__":
    best(2, {"interpolate": interpolate, "fit": fit}[sys.argv[1]], sys.argv[2])
