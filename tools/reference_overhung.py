"""Crossings and veerings of models/overhung_rotor.toml, assembled anew: the numbers of `ref_numpy_overhung_rotor` in tests/machine/campbell.rs.

The rotor is the same along x and y, so r = x + iy and β = dr/dz suffice: one real 6 × 6 problem −ω² M + ω G + K whose
positive roots whirl forward and whose negative ones backward. Run with numpy 2.4 and scipy: python tools/reference_overhung.py
"""

import numpy as np
from scipy.optimize import brentq, minimize_scalar

polar = [0.12, 0.036, 0.0]  # the headstock does not turn
M = np.diag([10, 0.065, 9, 0.0198, 85, 2.0])
K = np.zeros((6, 6))


def seat(body, other, across, tilt, cross):
    B = np.zeros((2, 6))
    B[:, 2 * body : 2 * body + 2] = np.eye(2)
    if other is not None:
        B[:, 2 * other : 2 * other + 2] -= np.eye(2)
    K[:] += B.T @ np.array([[across, cross], [cross, tilt]]) @ B


seat(0, 2, 63.7e6, 480e3, -1334e3)
seat(1, 2, 120e6, 220e3, 800e3)
seat(2, None, 150e6, 8e6, 0)


def frequencies(rpm):
    G = np.diag([x for J in polar for x in (0, J * rpm * np.pi / 30)])
    A = np.block([[np.zeros((6, 6)), np.eye(6)], [np.linalg.solve(M, K), np.linalg.solve(M, G)]])
    roots = np.sort(np.linalg.eigvals(A).real) / (2 * np.pi)
    return roots[roots > 0], -roots[roots < 0][::-1]


def F(n, rpm):
    return frequencies(rpm)[0][n - 1]


def B(n, rpm):
    return frequencies(rpm)[1][n - 1]


for f, b, low, high in ((4, 5, 1000, 3000), (3, 4, 8000, 9900), (2, 3, 12000, 15000)):
    rpm = brentq(lambda rpm: F(f, rpm) - B(b, rpm), low, high, xtol=1e-9)
    print(f"F{f} and B{b} cross at {rpm:.3f} rpm, {F(f, rpm):.4f} Hz")
for name, branch, low, high in (("F", F, 7000, 9500), ("B", B, 3000, 6500)):
    gap = minimize_scalar(lambda rpm: branch(5, rpm) - branch(4, rpm), bounds=(low, high), method="bounded")
    print(f"{name}4 and {name}5 come within {gap.fun:.4f} Hz at {gap.x:.1f} rpm")
