#!/usr/bin/env python3
"""Reference frequencies of graded machines, by mpmath, for tests/machine/numeric_graded.rs.

Writes data/reference/graded.json (undamped, with and without massless nodes) and data/reference/damped.json.
Run from the root of the repository: python3 tools/reference_graded.py
"""

import json
import platform
import random

import mpmath as mp
import numpy as np
import scipy
import scipy.linalg

DIGITS = 140  # λ spread by up to 1e40, and a hundred digits to tell rigid from soft
mp.mp.dps = DIGITS

MADE_BY = {
    "script": "tools/reference_graded.py",
    "python": platform.python_version(),
    "mpmath": mp.__version__,
    "numpy": np.__version__,
    "scipy": scipy.__version__,
    "digits": DIGITS,
}


def spread(rng, decades):
    """A double of four digits, log-uniform over so many decades around one."""
    return float(f"{10 ** rng.uniform(-decades / 2, decades / 2):.3e}")


def text(x):
    return float(mp.nstr(x, 20))


def chain(rng, n, k_decades, j_decades, free):
    inertia = [spread(rng, j_decades) for _ in range(n)]
    branches = [] if free else [{"terms": [[0, 1]], "k": spread(rng, k_decades)}]
    branches += [{"terms": [[i, -1], [i + 1, 1]], "k": spread(rng, k_decades)} for i in range(n - 1)]
    return inertia, branches


def geared(rng, n, k_decades, j_decades, free, loops):
    """A random tree whose body i turns p_i times as fast as the slowest: branch i–j is p_j φ_i − p_i φ_j."""
    inertia = [spread(rng, j_decades) for _ in range(n)]
    p = [rng.choice([1, 2, 3, 4, 5, 7]) for _ in range(n)]

    def between(i, j):
        g = int(np.gcd(p[i], p[j]))
        return {"terms": [[i, p[j] // g], [j, -p[i] // g]], "k": spread(rng, k_decades)}

    branches = [between(i, rng.randrange(max(0, i - 4), i)) for i in range(1, n)]
    branches += [between(*rng.sample(range(n), 2)) for _ in range(loops)]
    if not free:
        branches.append({"terms": [[rng.randrange(n), 1]], "k": spread(rng, k_decades)})
    rng.shuffle(branches)
    return inertia, branches


def stiffness(n, branches):
    k = mp.zeros(n)
    for b in branches:
        for i, ci in b["terms"]:
            for j, cj in b["terms"]:
                k[i, j] += mp.mpf(b["k"]) * ci * cj
    return k


def condense(k, massless):
    """Schur complement over the massless freedoms, and x_massless = G x_rest."""
    n = k.rows
    rest = [i for i in range(n) if i not in massless]
    if not massless:
        return k, None
    sub = lambda r, c: mp.matrix([[k[i, j] for j in c] for i in r])
    g = -(sub(massless, massless) ** -1) * sub(massless, rest)
    return sub(rest, rest) + sub(rest, massless) * g, g


def frequencies(k, inertia, n_rigid):
    n = k.rows
    a = mp.matrix(n, n)
    for i in range(n):
        for j in range(n):
            a[i, j] = k[i, j] / mp.sqrt(mp.mpf(inertia[i]) * mp.mpf(inertia[j]))
    values = sorted(mp.eigsy(a, eigvals_only=True))
    # what is rigid stands apart from what is not by far more than the spread can explain
    assert all(abs(v) < mp.mpf(10) ** -100 * values[-1] for v in values[:n_rigid])
    assert all(v > mp.mpf(10) ** -60 * values[-1] for v in values[n_rigid:])
    return [0.0] * n_rigid + [text(mp.sqrt(v)) for v in values[n_rigid:]]


def lapack(k, inertia, omega):
    n = k.rows
    kd = np.array([[float(k[i, j]) for j in range(n)] for i in range(n)])
    found = np.sqrt(np.abs(scipy.linalg.eigh(kd, np.diag(inertia), eigvals_only=True)))
    worst = max(abs(f - w) / w for f, w in zip(found, omega) if w > 0)
    return float(f"{worst:.1e}")


def problem(name, kind, free, inertia, branches):
    massless = [i for i, j in enumerate(inertia) if j == 0]
    heavy = [j for j in inertia if j > 0]
    full = stiffness(len(inertia), branches)
    k, g = condense(full, massless)
    omega = frequencies(k, heavy, 1 if free else 0)
    out = {
        "name": name,
        "class": kind,
        "free": free,
        "inertia": inertia,
        "branches": branches,
        "omega_rad_s": omega,
        "lapack_rel_error": lapack(k, heavy, omega),
    }
    if massless:
        out["recovery"] = [[text(g[i, j]) for j in range(g.cols)] for i in range(g.rows)]
    print(f"{name:24} {kind:8} lapack {out['lapack_rel_error']:.1e}")
    return out


def graded():
    problems = []
    for seed, (kd, jd, free) in enumerate(
        [(6, 0, False), (10, 4, False), (14, 0, False), (14, 12, False), (14, 12, False), (14, 12, True), (14, 12, True), (10, 4, True)]
    ):
        rng = random.Random(seed)
        problems.append(problem(f"chain_{seed}", "chain", free, *chain(rng, 12, kd, jd, free)))
    for kind, loops in [("tree", 0), ("loops", 4)]:
        for seed in range(8):
            rng = random.Random(100 + seed)
            n, free = 12 + seed % 3, seed % 2 == 0
            kd, jd = (14, 12) if seed < 6 else (10, 4)
            problems.append(problem(f"{kind}_{seed}", kind, free, *geared(rng, n, kd, jd, free, loops + seed % 3 if loops else 0)))
    for seed, (kind, loops, free) in enumerate([("chain", 0, True), ("tree", 0, True), ("loops", 3, False), ("loops", 6, True)]):
        rng = random.Random(200 + seed)
        inertia, branches = chain(rng, 12, 14, 12, free) if kind == "chain" else geared(rng, 13, 14, 12, free, loops)
        for i in rng.sample(range(12), 4):
            inertia[i] = 0.0
        problems.append(problem(f"massless_{seed}", "massless", free, inertia, branches))
    extreme_j = [1000.0, 1e-9, 1.0, 1e-6, 100.0, 0.001, 1e-9, 10.0]  # ours; also data of the stiff integrator tests
    extreme_k = [1e12, 0.001, 1e6, 1e9, 1.0, 1000.0, 0.01]
    links = lambda ks: [{"terms": [[i, -1], [i + 1, 1]], "k": k} for i, k in enumerate(ks)]
    problems.append(problem("extreme_chain", "chain", True, extreme_j, links(extreme_k)))
    problems.append(problem("uniform_40", "chain", True, [1.0] * 40, links([1.0] * 39)))
    return problems


def damped_problem(name, seed, n, k_decades, j_decades, zeta):
    """A held chain with viscous branches of damping ratio zeta; every third branch has twice that."""
    rng = random.Random(seed)
    inertia, branches = chain(rng, n, k_decades, j_decades, False)
    for at, b in enumerate(branches):
        ends = [i for i, _ in b["terms"]]
        effective = 1 / sum(1 / inertia[i] for i in ends)
        b["c"] = float(f"{2 * zeta * (1 + (at % 3 == 2)) * np.sqrt(b['k'] * effective):.3e}")
    k = stiffness(n, branches)
    c = stiffness(n, [{"terms": b["terms"], "k": b["c"]} for b in branches])
    a = mp.zeros(2 * n)
    for i in range(n):
        a[i, n + i] = mp.mpf(1)
        for j in range(n):
            a[n + i, j] = -k[i, j] / mp.mpf(inertia[i])
            a[n + i, n + j] = -c[i, j] / mp.mpf(inertia[i])
    values = mp.eig(a, left=False, right=False)
    values = sorted(values, key=lambda v: (abs(v), mp.im(v)))
    print(f"{name:24} damped   |λ| {mp.nstr(abs(values[0]), 3)} … {mp.nstr(abs(values[-1]), 3)}")
    flat = lambda v: {"re": text(mp.re(v)), "im": text(mp.im(v)) if abs(mp.im(v)) > mp.mpf(10) ** -40 * abs(v) else 0.0}
    return {"name": name, "zeta": zeta, "inertia": inertia, "branches": branches, "lambda_rad_s": [flat(v) for v in values]}


def damped():
    cases = [("light", 0.01), ("slight", 1e-4), ("half", 0.5), ("heavy", 3.0)]
    return [
        damped_problem(f"{word}_{kd}", 300 + 10 * at + kd, 6 + at % 3, kd, jd, zeta)
        for at, (word, zeta) in enumerate(cases)
        for kd, jd in [(4, 2), (10, 4)]
    ]


def write(path, problems):
    with open(path, "w") as out:
        out.write('{"made_by": ' + json.dumps(MADE_BY) + ',\n"problems": [\n')
        out.write(",\n".join(json.dumps(p, ensure_ascii=False) for p in problems))
        out.write("\n]}\n")


if __name__ == "__main__":
    write("data/reference/graded.json", graded())
    write("data/reference/damped.json", damped())
