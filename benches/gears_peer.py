"""The peers of benches/gears.rs: the same problems through SciPy, as a lab's script would solve them.

Each line is the best time on the processor in seconds of a thousand (of one, where the bench says so), an error or a dash, and the name.
Equations are written down without closed forms and solved by fsolve and brentq from a near start. The argument is the loaded contact and
the correction as the bench solves them, in JSON.
"""

import json
import sys
import time
from math import atan2, cos, hypot, pi, sin, sqrt, tan
from pathlib import Path

import numpy as np
from scipy.optimize import brentq, fsolve, least_squares, minimize_scalar

sys.path.append(str(Path(__file__).parent.parent / "tools"))
import loaded_lines_peer as strips

INCH = 0.0254
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
        unit = f.get("unit", 1.0)
        self.h, self.r, self.psi = f["h"], unit * f["r"], deg(f["psi"])
        q, d, radial = deg(f["q"]), deg(f["deden"]), unit * f["s"]
        self.first = turn(0, self.h * q)
        self.centre = np.array([0.0, -self.h * radial * sin(q), radial * cos(q)])
        self.root = turn(1, -d)
        self.offset = unit * np.array([-f["lm"] * sin(d), self.h * f["em"], f["lm"] * cos(d)])
        self.last = turn(1, deg(f["mu"]))
        self.roll = 1.0 / f["mcw"]
        # Along the cradle's axis, the same for a radian of the cradle, along the work's axis.
        self.base, self.helical, self.back = (np.array(f.get(k, [0.0] * 3)) for k in ("base", "helical", "back"))
        u, theta, phi = f["seed_u_theta_phi"]
        self.seed = [unit * u, deg(theta), deg(phi)]

    def state(self, u, theta, phi):
        s, c = sin(theta), cos(theta)
        sp, cp = sin(self.psi), cos(self.psi)
        p = np.array([self.r / tan(self.psi) - u * cp, u * sp * s, u * sp * c])
        n = np.array([sp, cp * s, cp * c])
        cradle = turn(0, -self.h * phi)
        b = cradle @ (self.first @ p + self.centre) + self.base + self.helical * phi
        velocity = self.last @ (self.root @ (np.cross([-self.h, 0, 0], b) + self.helical))
        work = self.last @ (self.root @ b + self.offset) + self.back
        normal = self.last @ (self.root @ (cradle @ (self.first @ n)))
        velocity = velocity + np.cross([0, 0, -self.h * self.roll], work)
        back = turn(2, -self.h * self.roll * phi)
        return back @ work, back @ normal, normal @ velocity

    def on_circle(self, y, z, radius):
        r, _, f = self.state(*y)
        return [f, r[2] - z, hypot(r[0], r[1]) - radius]


def bevel(_):
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


class Position:
    """The pair at the angle at which its ratio is that of the tooth numbers: ridges of least gap, loads on half spaces."""

    HEIGHTS = 13
    STEP = 0.02

    def __init__(self, problem):
        case = json.loads(CASE.read_text())["flanks"]
        self.flanks = [Flank(case[name] | {"unit": INCH}) for name in ("pinion_concave", "gear_convex")]
        self.sections = [np.array(s) for s in problem["sections"]]
        self.shift = np.array([0.0, 0.0, problem["assembly"]])
        self.into = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
        self.stations = problem["stations"]
        self.sides = [self.side(0), self.side(1), self.tip()]
        self.angle, self.zero, self.sign = 0.0, 0.0, 1.0
        self.reference()

    def place(self, member, face, height):
        (a, d), (b, c) = self.sections[member]
        return (1 - face) * ((1 - height) * a + height * d) + face * ((1 - height) * b + height * c)

    def line(self, a, b, inside):
        n = np.array([a[1] - b[1], b[0] - a[0]]) / np.linalg.norm(b - a)
        n *= -np.sign(n @ (inside - a))
        return n, n @ a

    def side(self, end):
        corners = self.sections[1]
        return self.line(corners[end, 0], corners[end, 1], corners[1 - end, 0])

    def tip(self):
        corners = self.sections[1]
        return self.line(corners[0, 1], corners[1, 1], corners[0, 0])

    def reference(self):
        """The contact at the ratio of the tooth numbers, from which the error is counted."""
        pinion, gear = self.flanks

        def contact(y, angle):
            r1, n1, f1 = pinion.state(*y[:3])
            r2, n2, f2 = gear.state(*y[3:6])
            spin, mate = turn(2, angle), self.into @ turn(2, y[6])
            r1, n1, r2, n2 = spin @ r1 + self.shift, spin @ n1, mate @ r2, mate @ n2
            cross = np.cross(n1, n2)
            return [f1 / INCH, f2 / INCH, *((r1 - r2) / INCH), cross[0], cross[1]]

        z, radius = self.place(0, 0.5, 0.5)
        y1 = fsolve(pinion.on_circle, pinion.seed, args=(z, radius), xtol=1e-13)
        # The middle of the pinion faces the gear at the angle 0.
        at = self.into.T @ (pinion.state(*y1)[0] + self.shift)
        y2 = fsolve(gear.on_circle, gear.seed, args=self.circle(at), xtol=1e-13)
        r2 = gear.state(*y2)[0]
        y = fsolve(contact, [*y1, *y2, atan2(at[1], at[0]) - atan2(r2[1], r2[0])], args=(0.0,), xtol=1e-13)
        step = 1e-3

        def off(angle):
            ends = [fsolve(contact, y, args=(angle + s,), xtol=1e-13)[6] for s in (-step, step)]
            return (ends[1] - ends[0]) / (2 * step) + 1 / 3

        self.angle = brentq(off, -0.1, 0.1, xtol=1e-9)
        y = fsolve(contact, y, args=(self.angle,), xtol=1e-13)
        self.zero, self.starts = y[6], [y[:3], y[3:6]]
        place = self.circle(pinion.state(*y[:3])[0])
        face, height = fsolve(lambda x: self.place(0, *x) - place, [0.5, 0.5])
        te = [self.at(self.angle, face, height + s, self.starts)["te"] for s in (-0.1, 0.0, 0.1)]
        self.sign = -np.sign(te[0] - 2 * te[1] + te[2])

    @staticmethod
    def circle(r):
        return r[2], hypot(r[0], r[1])

    def beyond(self, point):
        """Distance beyond the gear's blank."""
        place = np.array(self.circle(self.into.T @ point))
        return max(n @ place - c for n, c in self.sides)

    def point(self, angle, face, height, near):
        flank, target = self.flanks[0], np.array(self.place(0, face, height))
        start = np.array(self.circle(flank.state(*near)[0]))
        # Where a far step fails, small ones do not.
        for parts in (1, 8):
            y, flag = near, 1
            for k in range(1, parts + 1):
                place = tuple(start + k / parts * (target - start))
                y, _, flag, _ = fsolve(flank.on_circle, y, args=place, xtol=1e-13, full_output=True)
            if flag == 1:
                return turn(2, angle) @ flank.state(*y)[0] + self.shift, y
        return None, near

    def at(self, angle, face, height, starts):
        point, y1 = self.point(angle, face, height, starts[0])
        at = self.into.T @ point
        y2 = fsolve(self.flanks[1].on_circle, starts[1], args=self.circle(at), xtol=1e-13)
        r, n, _ = self.flanks[1].state(*y2)
        phi = atan2(at[1], at[0]) - atan2(r[1], r[0])
        ahead = phi - self.zero + (angle - self.angle) / 3
        mate = self.into @ turn(2, phi)
        arm = abs((mate @ n) @ np.cross(self.into[:, 2], point))
        te = self.sign * (ahead - 2 * pi * round(ahead / (2 * pi)))
        return {"te": te, "point": point, "arm": arm, "height": height, "starts": [y1, y2]}

    def ridge(self, angle):
        found, starts = [], self.starts
        for i in range(self.stations):
            face = (i + 0.5) / self.stations
            heights = np.linspace(0.0, 1.0, self.HEIGHTS)
            points = [self.point(angle, face, h, starts[0])[0] for h in heights]
            inside = [p is not None and self.beyond(p) <= 0.0 for p in points]
            if not any(inside):
                continue
            first = inside.index(True)
            last = first
            while last + 1 < self.HEIGHTS and inside[last + 1]:
                last += 1
            outside = lambda h: self.beyond(self.point(angle, face, h, starts[0])[0])
            low = brentq(outside, heights[first - 1], heights[first], xtol=1e-6) if first > 0 else 0.0
            high = brentq(outside, heights[last], heights[last + 1], xtol=1e-6) if last + 1 < self.HEIGHTS else 1.0
            te = lambda h: -self.at(angle, face, h, starts)["te"]
            top = minimize_scalar(te, bounds=(low, high), method="bounded", options={"xatol": 1e-4}).x
            here = min((self.at(angle, face, h, starts) for h in (low, top, high)), key=lambda p: -p["te"])
            near = [self.at(angle, face, here["height"] + s, starts) for s in (-self.STEP, self.STEP)]
            up = (near[1]["point"] - near[0]["point"]) / (2 * self.STEP)
            bend = (near[0]["te"] - 2 * here["te"] + near[1]["te"]) / self.STEP**2
            here["up"] = up / np.linalg.norm(up)
            here["curvature"] = -bend * here["arm"] / (up @ up)
            here["face"] = face
            starts = here["starts"]
            found.append(here)
        return found

    def lines(self):
        ridges = [self.ridge(self.angle + k * pi / 6) for k in (-2, -1, 0, 1, 2)]
        ridges = [r for r in ridges if len(r) > 1]
        # At the reference contact the error is zero.
        highest = max(0.0, max(p["te"] for r in ridges for p in r))
        lowest = highest - 0.2 / 36
        lines = []
        for ridge in ridges:
            if all(p["te"] < lowest for p in ridge):
                continue
            points = np.array([p["point"] for p in ridge])
            faces = np.array([p["face"] for p in ridge])
            index = np.arange(len(ridge))
            before, after = np.maximum(index - 1, 0), np.minimum(index + 1, len(ridge) - 1)
            chord = points[after] - points[before]
            size = np.linalg.norm(chord, axis=1)
            length = size / np.maximum(np.round((faces[after] - faces[before]) * self.stations), 1.0)
            cosine = np.array([p["up"] @ c for p, c in zip(ridge, chord)]) / size
            along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
            arm = np.array([p["arm"] for p in ridge])
            gap = arm * (highest - np.array([p["te"] for p in ridge]))
            across = np.array([p["curvature"] for p in ridge]) / (1.0 - cosine**2)
            lines.append(np.array([along, length, gap, arm, np.maximum(across, 0.1)]))
        return lines


def loaded(problem):
    problem = problem["loaded"]
    position = Position(problem)
    strips.SETTLED = 1e-8
    start = time.process_time()
    lines = position.lines()
    ridges = time.process_time() - start
    start = time.process_time()
    turn, _, _ = strips.loaded(lines, 3 * problem["torques"][-1])
    yield ridges + time.process_time() - start, abs(turn / problem["turn"] - 1), "position"
    start = time.process_time()
    forces, turns = None, []
    for torque in problem["torques"]:
        turn, forces, _ = strips.loaded(lines, 3 * torque, forces)
        turns.append(turn)
    apart = np.max(np.abs(np.array(turns) / problem["turns"] - 1))
    # One position of the map, times their number.
    yield problem["positions"] * (ridges + time.process_time() - start), apart, "harris"


def correction(problem):
    """Ten settings and a turn of each flank by least squares of exact distances, with differences."""
    problem = problem["correction"]
    gear = json.loads(CASE.read_text())["flanks"]["gear_convex"] | {"unit": INCH}
    # The outside blade of the concave flank: its angle is counted to 180°.
    concave = gear | {"r": 3.0325, "psi": 158.0, "seed_u_theta_phi": [9.5, 235.0, -12.3]}
    flanks = [concave, gear]
    reaches = np.array([1e-4, pi / 1080, 1e-4, 1e-4, 1e-4, 1e-4, pi / 1080, 1e-2, pi / 1080, pi / 1080])

    def changed(k, x):
        f = dict(flanks[k])
        f["s"] += x[0] / INCH
        f["q"] += np.rad2deg(x[1])
        f["em"] += x[2] / INCH
        f["base"], f["helical"], f["back"] = [x[3], 0, 0], [x[4], 0, 0], [0, 0, -x[5]]
        f["mu"] += np.rad2deg(x[6])
        f["mcw"] = 1 / (1 / f["mcw"] + x[7])
        f["psi"] += np.rad2deg(x[8 + k]) * (-1 if k == 0 else 1)
        return Flank(f)

    def nodes(k):
        flank, near = changed(k, np.zeros(10)), None
        for z, radius in problem["places"][k]:
            y = fsolve(flank.on_circle, flank.seed if near is None else near, args=(z, radius), xtol=1e-13)
            near = y
            r, n, _ = flank.state(*y)
            yield y, r, n

    both = [list(nodes(k)) for k in (0, 1)]

    def distances(k, x, twist):
        flank = changed(k, x)
        around = turn(2, twist)

        def on_ray(y, r, n):
            at, _, f = flank.state(*y[:3])
            return [f / INCH, *((around @ at - r - y[3] * n) / INCH)]

        return [fsolve(on_ray, [*y, 0.0], args=(r, n), xtol=1e-13)[3] for y, r, n in both[k]]

    # Before the clock: the deviations of the wrong settings.
    wrong = np.array(problem["wrong"])
    measured = np.array([distances(k, wrong, 0.0) for k in (0, 1)])
    before = np.sqrt(np.mean(measured**2))
    scale = np.append(reaches, [1e-4, 1e-4])

    def rests(x):
        x = x * scale
        return 1e6 * (measured - [distances(k, x[:10], x[10 + k]) for k in (0, 1)]).ravel()

    start = time.process_time()
    fit = least_squares(rests, np.zeros(12), method="trf", diff_step=1e-4, xtol=1e-8, ftol=1e-6, max_nfev=10)
    seconds = time.process_time() - start
    print(f"rms before {1e6 * before:.6f} µm, ours {1e6 * problem['before']:.6f}; {fit.nfev} steps", file=sys.stderr)
    yield seconds, 1e-6 * np.sqrt(np.mean(fit.fun**2)) / before, "correction"


def screws(_):
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
    problem = json.loads(sys.argv[1])
    for work in (bevel, loaded, correction, screws):
        for seconds, *error, name in work(problem):
            print(seconds, *(error or ["-"]), name)
