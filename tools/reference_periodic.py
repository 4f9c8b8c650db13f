"""Motions of machines with periodic stiffness and play, for data/reference/periodic.json.

`bench`: x'' + 0.1 x' + (1 + 0.2 cos(W t)) g(x) = 0.1 + 0.05 W^2 cos(W t), g with half-gap 1, W = 0.85, from (1.4, 0):
Taylor series of order 40 in 40 digits (mpmath), events by Newton's method in 40 digits; instants are the doubles
fl(fl(1000 * 2 pi / W) * j / 1000).
`trio`: three inertias in a row, two meshes with play and periodic stiffness, DOP853 of SciPy between events that are
located by its own root finder on the dense output, tolerance 1e-13.

Run: python tools/reference_periodic.py > data/reference/periodic.json
"""
import datetime, json, math, sys
import mpmath as mp
import numpy as np, scipy
from scipy.integrate import solve_ivp

mp.mp.dps = 40
ORDER = 40


def bench(periods, keep):
    W, f0 = mp.mpf(0.85), mp.mpf(0.1)
    fa = mp.mpf(0.05 * 0.85 * 0.85)
    d, eps = mp.mpf(0.1), mp.mpf(0.2)
    end = float(periods) * (2 * math.pi / 0.85)
    t, x, v = mp.mpf(0), mp.mpf(1.4), mp.mpf(0)
    side, events, out, sample = 1, 0, [], 0
    stops = [mp.mpf(end if j == periods else end * j / periods) for j in range(periods + 1)]
    while sample <= periods:
        c, s = mp.cos(W * t), mp.sin(W * t)
        C = []
        a = mp.mpf(1)
        for k in range(ORDER + 2):
            C.append(a * [c, -s, -c, s][k % 4])
            a = a * W / (k + 1)
        u = [x, v]
        g = [x - side]
        for k in range(ORDER - 1):
            f = fa * C[k] + (f0 if k == 0 else 0) - d * (k + 1) * u[k + 1]
            if side:
                f -= g[k]
                f -= eps * sum((C[j] * g[k - j] for j in range(k + 1)), mp.mpf(0))
            u.append(f / ((k + 1) * (k + 2)))
            g.append(u[k + 1])
        h = mp.mpf(0.6)
        poly = u[::-1]
        border = {1: [(1, 1)], 0: [(1, 1), (-1, -1)], -1: [(-1, -1)]}[side]
        # The first sign change among 64 points of the step; touches shorter than that would be seen in the doubles' answer.
        root = None
        for i in range(1, 65):
            y = mp.polyval(poly, h * i / 64)
            for at, _ in border:
                crossed = (y - at) * (side or -at) < 0 if side else (y > 1 if at > 0 else y < -1)
                if crossed:
                    root = (h * (i - mp.mpf(0.5)) / 64, at)
            if root:
                break
        step = h
        if root:
            r, at = root
            for _ in range(60):
                p, dp = mp.polyval(poly, r, derivative=True)
                n = r - (p - at) / dp
                if abs(n - r) < mp.mpf(10) ** -36:
                    break
                r = n
            step = n
        while sample <= periods and stops[sample] <= t + step:
            p, dp = mp.polyval(poly, stops[sample] - t, derivative=True)
            if sample % keep == 0:
                out.append([sample, float(stops[sample]), float(p), float(dp), events])
            sample += 1
        x, v = mp.polyval(poly, step, derivative=True)
        t += step
        if root:
            x = mp.mpf(at)
            side = 0 if side else at
            events += 1
    return out


def trio(kind):
    J = np.array([1.0, 0.5, 2.0])
    k, c, half = [40.0, 25.0], [0.3, 0.2], [0.05, 0.03]
    W = 3.0

    def wave(b, t, piece):
        n = [1, 2][b]
        if kind == "smooth":
            return 1 + [0.25, 0.2][b] * math.cos(n * W * t + [0.3, 1.1][b])
        psi = (n * W * t + [0.3, 1.1][b]) / (2 * math.pi)
        low = [0.6, 0.7][b]
        duty = [0.6, 0.45][b]
        return (1.0 if (psi % 1.0) < duty else low) if piece is None else piece

    def jumps(end):
        if kind == "smooth":
            return [end]
        at = []
        for b in range(2):
            n, start, duty = [1, 2][b], [0.3, 1.1][b], [0.6, 0.45][b]
            for j in range(0, int(end * n * W / 6) + 3):
                for e in (0.0, duty):
                    at.append(((j + e) * 2 * math.pi - start) / (n * W))
        return sorted(a for a in at if 0 < a < end) + [end]

    def drive(t):
        return 1.5 + 2.5 * math.cos(W * t)

    y, t, end = np.array([0.06, 0.0, -0.04, 0.0, 0.1, 0.0]), 0.0, 40.0
    side = [0, 0]
    for b in range(2):
        delta = y[b] - y[b + 1]
        side[b] = 1 if delta > half[b] else -1 if delta < -half[b] else 0
    events, out = 0, [[0.0, *y]]
    samples = [end * j / 40 for j in range(1, 41)]
    for stop in jumps(end):
        middle = [wave(b, 0.5 * (t + stop), None) for b in range(2)]
        while t < stop:
            def rhs(t, y):
                F = []
                for b in range(2):
                    delta, rate = y[b] - y[b + 1], y[3 + b] - y[4 + b]
                    kk = k[b] * (wave(b, t, None) if kind == "smooth" else middle[b])
                    F.append(side[b] and kk * (delta - side[b] * half[b]) + c[b] * rate or 0.0)
                f = [drive(t) - F[0] - 0.2 * y[3], F[0] - F[1], F[1] - 1.5 - 0.2 * y[5] - 3.0 * y[2]]
                return np.array([*y[3:], *(np.array(f) / J)])

            borders = []
            for b in range(2):
                for s in ([side[b]] if side[b] else [1, -1]):
                    fn = (lambda b, s: lambda t, y: s * (y[b] - y[b + 1]) - half[b])(b, s)
                    fn.terminal = True
                    fn.direction = -1.0 if side[b] else 1.0
                    fn.to = (b, 0 if side[b] else s)
                    borders.append(fn)
            r = solve_ivp(rhs, (t, stop), y, method="DOP853", rtol=1e-13, atol=1e-15, events=borders, dense_output=True, max_step=0.05)
            reached = r.t[-1]
            while samples and samples[0] <= reached:
                out.append([samples[0], *r.sol(samples[0])])
                samples.pop(0)
            y, t = r.y[:, -1].copy(), reached
            if r.status == 1:
                for fn, at in zip(borders, r.t_events):
                    if len(at) and at[-1] == reached:
                        b, to = fn.to
                        side[b] = to
                        events += 1
    return {"events": events, "samples": out}


answer = {
    "source": f"mpmath {mp.__version__}, SciPy {scipy.__version__}, tools/reference_periodic.py, {datetime.date.today()}",
    "bench": bench(int(sys.argv[1]) if len(sys.argv) > 1 else 1000, 50),
    "trio_smooth": trio("smooth"),
    "trio_steps": trio("steps"),
}
json.dump(answer, sys.stdout, indent=1)
