#!/usr/bin/env python3
"""Graded trees with ratios, loops and ground springs, solved in 120 digits; writes data/reference/forest.json."""

import json
import random
import sys

import mpmath as mp

mp.mp.dps = 120


def case(name, seed, n, loops, grounds, spread_k, spread_m):
    rng = random.Random(seed)
    ratios = [1.0] + [0.0] * (n - 1)
    springs = []
    mass = [10.0 ** rng.uniform(-spread_m / 2, spread_m / 2) for _ in range(n)]
    stiffness = lambda: 10.0 ** rng.uniform(-spread_k / 2, spread_k / 2)
    teeth = [1.0] * n
    for j in range(1, n):
        i = rng.randrange(j)
        if rng.random() < 0.5:  # a mesh: base radii of either sign; powers of two keep loops consistent
            teeth[j] = teeth[i] * rng.choice([-0.5, -2.0, -4.0])
        else:
            teeth[j] = teeth[i]
        a = rng.uniform(0.1, 3.0) * teeth[i] ** -1
        springs.append([i, a, j, -a * teeth[i] / teeth[j], stiffness()])
    for _ in range(loops):
        i, j = rng.sample(range(n), 2)
        springs.append([i, 1.0 / teeth[i], j, -1.0 / teeth[j], stiffness()])
    for i in rng.sample(range(n), grounds):
        springs.append([i, 1.0, None, None, stiffness()])
    f = [rng.uniform(-1, 1) for _ in range(n)]
    k = mp.zeros(n)
    for i, a, j, c, s in springs:
        w = [(i, mp.mpf(a))] + ([] if j is None else [(j, mp.mpf(c))])
        for p, x in w:
            for q, y in w:
                k[p, q] += mp.mpf(s) * x * y
    root = [mp.sqrt(mp.mpf(m)) for m in mass]
    pencil = mp.matrix(n, n)
    for i in range(n):
        for j in range(n):
            pencil[i, j] = k[i, j] / root[i] / root[j]
    values = sorted(mp.eigsy(pencil, eigvals_only=True))
    free = grounds == 0
    out = dict(name=name, n=n, springs=springs, mass=mass, f=f,
               values=[float(v) for v in (values[1:] if free else values)], free=free)
    if free:
        assert abs(values[0]) < mp.mpf(10) ** -60
    else:
        out["x"] = [float(v) for v in mp.lu_solve(k, mp.matrix([mp.mpf(v) for v in f]))]
    return out


cases = [
    case("grounded tree", 1, 12, 0, 1, 14, 12),
    case("tree on three ground springs", 2, 13, 0, 3, 14, 12),
    case("free tree", 3, 14, 0, 0, 14, 12),
    case("grounded, three loops", 4, 13, 3, 1, 14, 12),
    case("free, six loops", 5, 14, 6, 0, 14, 12),
]
out = dict(program=f"mpmath {mp.__version__}, {mp.mp.dps} digits, python {sys.version.split()[0]}",
           script="tools/reference_forest.py", made="2026-11-21",
           meaning="springs are [i, a, j, c, k], energy k (a x_i + c x_j)^2 / 2; values are eigenvalues of (K, M) without the rigid one; K x = f",
           cases=cases)
with open("data/reference/forest.json", "w") as file:
    json.dump(out, file, indent=1)
    file.write("\n")
