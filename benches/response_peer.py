"""The peer of benches/response.rs: frequency responses of a uniform chain through NumPy and SciPy.

`response_peer.py DISCS LINES LOSS` prints lines of `seconds on the processor, error, name`: `dense`, numpy.linalg.solve at every line; `banded`,
scipy.linalg.solve_banded at every line; `modes`, eigh once and the sum over all modes at all lines together. Errors are against
the modes in closed form, by the largest value.
"""

import sys
import time

import numpy as np
from scipy.linalg import eigh, solve_banded

n, lines, loss = int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3])
omega = 2.2 * np.arange(1, lines + 1) / lines
theta = (2 * np.arange(1, n + 1) - 1) * np.pi / (2 * n + 1)
square = (2 * np.sin(theta / 2)) ** 2
shapes = 4 * np.sin(theta) * np.sin(n * theta) / (2 * n + 1)
truth = np.array([np.sum(shapes / (square * (1 + 1j * w * loss) - w * w)) for w in omega])
largest = np.max(np.abs(truth))

k = 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
k[-1, -1] = 1.0
m = np.eye(n)
b = np.zeros(n)
b[0] = 1.0


def dense():
    return np.array([np.linalg.solve(k * (1 + 1j * w * loss) - w * w * m, b)[-1] for w in omega])


def banded():
    bands = np.zeros((3, n))
    bands[0, 1:], bands[2, :-1], bands[1] = -1.0, -1.0, np.diag(k)
    unit = np.zeros((3, n))
    unit[1] = 1.0
    out = []
    for w in omega:
        out.append(solve_banded((1, 1), bands * (1 + 1j * w * loss) - w * w * unit, b)[-1])
    return np.array(out)


def modes():
    values, vectors = eigh(k, m)
    weights = vectors[0] * vectors[-1]
    return (1.0 / (np.outer(1 + 1j * omega * loss, values) - (omega * omega)[:, None])) @ weights


for name, work, runs in [("dense", dense, 1), ("banded", banded, 2), ("modes", modes, 3)]:
    best = np.inf
    for _ in range(runs):
        start = time.process_time()
        answer = work()
        best = min(best, time.process_time() - start)
    print(best, np.max(np.abs(answer - truth)) / largest, name)
