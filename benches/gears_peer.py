"""The peers of benches/gears.rs: the same problems through SciPy, as a lab's script would solve them.

Each line is the best time on the processor in seconds of a thousand (of one, where the bench says so), a dash and the name. Equations
are written down without closed forms and solved by fsolve and brentq from a near start.
"""

import json
import time
from math import atan2, cos, hypot, pi, sin, sqrt, tan
from pathlib import Path

import numpy as np
from scipy.optimize import brentq, fsolve

CASE = Path(__file__).parent.parent / "data/reference/gear/c12_nasa_cr191009_flanks.json"


def best(runs, count, work):
    """Least time of one of `count` calls, s."""
    times = []
    for _ in range(runs):
        start = time.process_time()
        for k in range(count):
            work(k)
        times.append((time.process_time() - start) / count)
    return min(times)


def turn(axis, angle):
    c, s = cos(angle), sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    m = np.eye(3)
    m[i, i] = m[j, j] = c
    m[i, j], m[j, i] = -s, s
    return m


class Flank:
    """A flank of the case: place and normal in the work, the equation of meshing."""

    def __init__(self, f):
        deg = np.deg2rad
        self.h, self.r, self.psi = f["h"], f["r"], deg(f["psi"])
        q, d = deg(f["q"]), deg(f["deden"])
        self.first = turn(0, self.h * q)
        self.centre = np.array([0.0, -self.h * f["s"] * sin(q), f["s"] * cos(q)])
        self.root = turn(1, -d)
        self.offset = np.array([-f["lm"] * sin(d), self.h * f["em"], f["lm"] * cos(d)])
        self.last = turn(1, deg(f["mu"]))
        self.roll = 1.0 / f["mcw"]
        u, theta, phi = f["seed_u_theta_phi"]
        self.seed = [u, deg(theta), deg(phi)]

    def state(self, u, theta, phi):
        s, c = sin(theta), cos(theta)
        sp, cp = sin(self.psi), cos(self.psi)
        p = np.array([self.r / tan(self.psi) - u * cp, u * sp * s, u * sp * c])
        n = np.array([sp, cp * s, cp * c])
        cradle = turn(0, -self.h * phi)
        b = cradle @ (self.first @ p + self.centre)
        velocity = self.last @ (self.root @ np.cross([-self.h, 0, 0], b))
        work = self.last @ (self.root @ b + self.offset)
        normal = self.last @ (self.root @ (cradle @ (self.first @ n)))
        velocity = velocity + np.cross([0, 0, -self.h * self.roll], work)
        back = turn(2, -self.h * self.roll * phi)
        return back @ work, back @ normal, normal @ velocity

    def on_circle(self, y, z, radius):
        r, _, f = self.state(*y)
        return [f, r[2] - z, hypot(r[0], r[1]) - radius]


def bevel():
    case = json.loads(CASE.read_text())
    flanks = {name: Flank(f) for name, f in case["flanks"].items()}
    pinion = flanks["pinion_concave"]
    nodes = [n["xyz"] for n in case["grid_computed_here"]["pinion_concave"]]

    def point(k):
        x = nodes[k % len(nodes)]
        fsolve(pinion.on_circle, pinion.seed, args=(x[2], hypot(x[0], x[1])), xtol=1e-13)

    seconds = best(5, len(nodes), point)
    yield 1e3 * seconds, "flank"
    yield 2 * 45 * 30 * seconds, "gear"
    gear = flanks["gear_convex"]
    shift = np.array([0.0, 0.0, 0.02])
    # The pinion's axis z, the gear's along x at 90°.
    into = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])

    def contact(y, angle):
        r1, n1, f1 = pinion.state(*y[:3])
        r2, n2, f2 = gear.state(*y[3:6])
        spin, mate = turn(2, angle), into @ turn(2, y[6])
        r1, n1, r2, n2 = spin @ r1 + shift, spin @ n1, mate @ r2, mate @ n2
        cross = np.cross(n1, n2)
        return [f1, f2, *(r1 - r2), cross[0], cross[1]]

    # A start: the place of the pinion's middle, the gear turned to it.
    middle = nodes[len(nodes) // 2]
    y1 = fsolve(pinion.on_circle, pinion.seed, args=(middle[2], hypot(middle[0], middle[1])), xtol=1e-13)
    found = None
    for angle in np.linspace(-pi, pi, 721):
        r = turn(2, angle) @ pinion.state(*y1)[0] + shift
        at = into.T @ r
        y2, _, flag, _ = fsolve(gear.on_circle, gear.seed, args=(at[2], hypot(at[0], at[1])), full_output=True)
        if flag != 1:
            continue
        r2 = gear.state(*y2)[0]
        start = [*y1, *y2, atan2(at[1], at[0]) - atan2(r2[1], r2[0])]
        y, info, flag, _ = fsolve(contact, start, args=(angle,), xtol=1e-13, full_output=True)
        if np.max(np.abs(info["fvec"])) < 1e-10 and np.max(np.abs(y[[0, 3]] - [y1[0], y2[0]])) < 1.0:
            found = angle, y
            break
    if found is None:
        return
    angle, y = found
    yield 1e3 * best(5, 20, lambda k: fsolve(contact, y, args=(angle + 0.002 * (k % 5),), xtol=1e-13)), "contact"

    def path(_):
        for way in (1, -1):
            at = y
            for k in range(30):
                at = fsolve(contact, at, args=(angle + way * k * 2 * pi / 12 / 20,), xtol=1e-13)

    yield best(2, 1, path), "path"


def screws():
    m, starts, q, alpha = 4.0, 2, 10.0, np.deg2rad(20.0)
    r, p = m * q / 2, starts * m / 2
    gamma = atan2(starts, q)
    wheel, distance, height = 150.0, 150.0 + r, pi * m * cos(gamma) / 4
    cs, ss, t = cos(gamma), sin(gamma), tan(alpha)
    place = lambda k: 16.0 + 8.0 * (k % 97) / 97.0

    def ground(k):
        radius = 170.0 - place(k)
        zeta = height - t * (radius - wheel)
        # The normal of the wheel against the screw's velocity.
        def f(beta):
            sb, cb = sin(beta), cos(beta)
            at = (distance - radius * cb, radius * sb * cs - zeta * ss, radius * sb * ss + zeta * cs)
            n = (-t * cb, t * sb * cs - ss, t * sb * ss + cs)
            return -n[0] * at[1] + n[1] * at[0] + n[2] * p
        brentq(f, -0.3, 0.3, xtol=1e-14)

    yield 1e3 * best(5, 500, ground), "ground"
    base = p / tan(np.arccos(cos(gamma) * cos(alpha)))

    def involute(rho):
        root = sqrt(rho * rho - base * base)
        return p * (root / base - np.arccos(base / rho)), p * root / (rho * base)

    def tool(k):
        rho = place(k)
        g, slope = involute(rho)
        # The normal of the helicoid meets the tool's axis.
        def f(chi):
            sc, cc = sin(chi), cos(chi)
            n = np.array([-slope * cc + p / rho * sc, -slope * sc - p / rho * cc, 1.0])
            at = np.array([rho * cc - 170.0, rho * sc, g + p * chi])
            return np.cross(at, n) @ np.array([0.0, -ss, cs])
        brentq(f, -0.5, 0.5, xtol=1e-14)

    yield 1e3 * best(5, 200, tool), "tool"

    def worm(k):
        rho, psi = place(k), 0.3
        g, slope = involute(rho)
        n = np.array([-slope * cos(psi) + p / rho * sin(psi), -slope * sin(psi) - p / rho * cos(psi), 1.0])
        def f(z):
            at = np.array([rho * cos(psi), rho * sin(psi), z[0]])
            v = np.cross([0, 0, 1.0], at) - 0.05 * np.cross([0, -1.0, 0], at - [100.0, 0, 0])
            return n @ v
        fsolve(f, [0.1], xtol=1e-13)

    yield 1e3 * best(5, 200, worm), "worm"
    a, i, rb, beta = 125.0, 1 / 40, 40.0, np.deg2rad(11.0)
    k2 = np.array([0.0, -1.0, 0.0])

    def place_and_normal(phi, xi, eta):
        s, c = sin(phi), cos(phi)
        zeta = rb + eta * tan(beta)
        x = np.array([a - xi * c - zeta * s, eta, zeta * c - xi * s])
        return x, np.array([-cos(beta) * s, -sin(beta), cos(beta) * c])

    def meshing(x, n):
        return n @ (np.cross([0, 0, 1.0], x) - i * np.cross(k2, x - [a, 0, 0]))

    def plane(k):
        eta = -4.0 + 8.0 * (k % 97) / 97.0
        xi = brentq(lambda xi: meshing(*place_and_normal(0.4, xi, eta)), 60.0, 140.0, xtol=1e-12)
        x, n = place_and_normal(0.4, xi, eta)
        # The worm's point turned on, the first contact divided out.
        def f(d):
            z = turn(2, d)
            return meshing(z @ x, z @ n) / sin(d / 2)
        turns = np.linspace(-3.0, 3.0, 24)
        values = [f(d) for d in turns]
        j = next(j for j in range(23) if values[j] * values[j + 1] < 0)
        brentq(f, turns[j], turns[j + 1], xtol=1e-13)

    yield 1e3 * best(5, 50, plane), "plane"

    def hypoid(k):
        shaft, offset, u = pi / 2, 15.0, 42 / 13
        wheel_radius, spiral, limit = 70.9 + 0.01 * (k % 7), np.deg2rad(50.0), 1 / 63.5
        k1, k2 = np.array([0, 0, 1.0]), np.array([0, sin(shaft), cos(shaft)])
        foot = np.array([offset, 0, 0])

        def f(x):
            x = np.asarray(x)
            t = np.cross(np.cross(k1, x), np.cross(k2, x - foot))
            t /= np.linalg.norm(t)
            v1, v2 = np.cross(k1, x), -np.cross(k2, x - foot) / u
            v = v1 - v2
            speed = np.linalg.norm(v)
            tau = v / speed
            e = x - k1 * (x @ t / (k1 @ t))
            e /= np.linalg.norm(e)
            sign = np.sign(tau @ e)
            w = k1 + k2 / u
            qn = np.cross(k1, v2) - np.cross(-k2 / u, v1)
            n = np.cross(tau, qn)
            n /= np.linalg.norm(n)
            lateral = np.cross(t, tau * sign)
            n *= np.sign(n @ lateral)
            curvature = -np.cross(n, w) @ (tau * sign) / (v @ tau * sign)
            beta = atan2(-t @ np.cross(e, tau * sign), abs(tau @ e))
            radius = np.linalg.norm(np.cross(k2, x - foot))
            return [radius / wheel_radius - 1, abs(beta) - spiral, wheel_radius * (abs(curvature) - limit)]

        fsolve(f, [1.5, 26.0, 70.0], xtol=1e-12)

    yield 1e3 * best(5, 20, hypoid), "hypoid"


if __name__ == "__main__":
    for work in (bevel, screws):
        for seconds, name in work():
            print(seconds, "-", name)
