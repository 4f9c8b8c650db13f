"""Makes data/reference/gear/loaded_mesh.json: loaded transmission error of a helical pair with relief and misalignment, and its time.

Nothing of it is taken from the Rust sources. The fillet is traced by the centre of the rack's rounding, teeth are integrated by
scipy.integrate.quad over the outline, tip corners are turned into contact by brentq, and slices share the load by brentq on the sum of
their forces. Run: python3 tools/reference_mesh.py (numpy, scipy).
"""

import json
import math
import sys
import time

import numpy as np
import scipy
from scipy.integrate import quad
from scipy.optimize import brentq

E, NU = 206e9, 0.3
G = E / (2 * (1 + NU))
LINE_LOAD = 300e3
INPUTS = {
    "teeth": [24, 60], "module": 3e-3, "pressure_angle_deg": 20.0, "helix_angle_deg": 12.0, "profile_shift": [0.2, 0.1],
    "centre_distance": 0.1297, "tip_diameter": [0.0804, 0.1905], "face_width": 0.03, "rack": [1.0, 1.25, 0.38],
    "relief": [12e-6, 8e-6], "relief_length": [2.0e-3, 2.5e-3], "helix_crowning": [6e-6, 0.0], "misalignment": 3e-4,
    "slices": 5, "positions": 6, "torques": [40.0, 200.0],
}


class Tooth:
    """A tooth in the transverse section, middle along +y."""

    def __init__(self, i, p):
        self.z, mn = p["teeth"][i], p["module"]
        self.beta, an = math.radians(p["helix_angle_deg"]), math.radians(p["pressure_angle_deg"])
        at = math.atan(math.tan(an) / math.cos(self.beta))
        x, (_, self.hf, self.rho) = p["profile_shift"][i], p["rack"]
        self.r = self.z * mn / math.cos(self.beta) / 2
        self.rb, self.ra = self.r * math.cos(at), p["tip_diameter"][i] / 2
        self.rf = self.r - mn * (self.hf - x)
        thickness = mn * (math.pi / 2 + 2 * x * math.tan(an))
        self.psi_b = thickness / (mn * self.z) + math.tan(at) - at
        # Centre of the rounding of the tool's tip, from the middle of the tool's tooth and above the reference circle.
        aside = math.pi / 4 - self.hf * math.tan(an) - self.rho * (1 - math.sin(an)) / math.cos(an)
        self.centre = mn * aside, mn * (x - self.hf + self.rho)
        self.radius, self.end = mn * self.rho, math.pi / 2 - an
        roll = lambda r: math.sqrt(r * r - self.rb**2)
        self.form = roll(np.hypot(*self.fillet(self.end)))
        self.tip = roll(self.ra)
        root = self.fillet(1e-9)
        self.theta_f = math.atan2(root[0], root[1])
        self.memory = {}

    def fillet(self, t):
        """Rolling the rack without slip: where the rounding's normal passes the pitch point, its point is on the fillet."""
        up = self.centre[1] - self.radius * math.cos(t)
        across = (self.centre[0] + self.radius * math.sin(t)) / math.cos(self.beta)
        # In the transverse plane the normal leans by the helix.
        slope = math.tan(t) * math.cos(self.beta)
        rolled = across + up * slope
        x, y = across - rolled, self.r + up
        turn = rolled / self.r
        # Angle from the middle of the space, then to the middle of the tooth.
        at = math.atan2(x, y) + turn
        psi = math.pi / self.z - at
        return math.hypot(x, y) * math.sin(psi), math.hypot(x, y) * math.cos(psi)

    def involute(self, s):
        xi = s / self.rb
        b = xi - self.psi_b
        return self.rb * (xi * math.cos(b) - math.sin(b)), self.rb * (math.cos(b) + xi * math.sin(b))

    def compliance(self, s):
        key = round(s * 1e15)
        if key not in self.memory:
            self.memory[key] = self._compliance(s)
        return self.memory[key]

    def _compliance(self, s):
        b = s / self.rb - self.psi_b
        xl, yl = self.involute(s)
        c, sn = math.cos(b), math.sin(b)

        def density(x, y):
            m = c * (yl - y) - xl * sn
            return m * m / (E * 2 / 3 * x**3) + 1.2 * c * c / (G * 2 * x) + sn * sn / (E * 2 * x)

        def over_fillet(t):
            h = 1e-5
            rise = (self.fillet(t + h)[1] - self.fillet(t - h)[1]) / (2 * h)
            return density(*self.fillet(t)) * rise

        def over_involute(u):
            return density(*self.involute(u)) * u / self.rb * math.cos(u / self.rb - self.psi_b)

        bent = quad(over_fillet, 1e-9, self.end, epsrel=1e-9)[0] + quad(over_involute, self.form, s, epsrel=1e-10)[0]
        u = self.rb / c - self.rf
        ratio = u / (2 * self.rf * self.theta_f)
        foot = 16.67 / math.pi * ratio**2 + 2 * (1 - 2 * NU) / (1 - NU) * ratio
        foot += 1.534 * (1 + math.tan(b) ** 2 / (2.4 * (1 + NU)))
        return bent + (1 - NU**2) / E * c * c * foot, xl / c


class Mesh:
    def __init__(self, p):
        self.p, self.t = p, [Tooth(0, p), Tooth(1, p)]
        rb = [t.rb for t in self.t]
        self.rb, self.a = rb, p["centre_distance"]
        alpha = math.acos(sum(rb) / self.a)
        self.alpha, self.c = alpha, [r * math.tan(alpha) for r in rb]
        self.length = sum(self.c)
        self.pitch = 2 * math.pi * rb[0] / p["teeth"][0]
        self.start, self.stop = self.length - self.t[1].tip, self.t[0].tip
        sine = math.sin(math.radians(p["helix_angle_deg"])) * math.cos(math.radians(p["pressure_angle_deg"]))
        self.lean = math.tan(math.asin(sine))

    def corner(self, tip, s):
        """Rolls on both flanks and gap where the tip corner of a gear faces the flank of its mate."""
        flank = 1 - tip
        rolls = [s, self.length - s]
        o = [(0.0, -self.rb[0]), (self.length, self.rb[1])]  # line of action along x, gear 1 below
        turn = (self.t[tip].tip - rolls[tip]) / self.rb[tip]
        side = 1 if tip == 0 else -1
        tangent = side * -math.sin(turn) * self.rb[tip], side * math.cos(turn) * self.rb[tip]
        along = side * math.cos(turn), side * math.sin(turn)
        p = [o[tip][k] + tangent[k] + self.t[tip].tip * along[k] for k in (0, 1)]
        side = -side
        d = [side * (p[k] - o[flank][k]) for k in (0, 1)]
        on = math.sqrt(d[0] ** 2 + d[1] ** 2 - self.rb[flank] ** 2)
        back = math.atan(on / self.rb[flank]) - math.atan2(d[0], d[1])
        gap = on - self.rb[flank] * back - rolls[flank]
        places = [0.0, 0.0]
        places[tip], places[flank] = self.t[tip].tip, on
        return places, gap

    def points(self, phi):
        p, b, n = self.p, self.p["face_width"], self.p["slices"]
        for j in range(-4, 5):
            for i in range(n):
                face = (i + 0.5) / n
                s = self.c[0] + self.rb[0] * phi + j * self.pitch - (face - 0.5) * b * self.lean
                if not self.start - 0.5 * self.pitch < s < self.stop + 0.5 * self.pitch:
                    continue
                if s < self.start:
                    rolls, gap = self.corner(1, s)
                elif s > self.stop:
                    rolls, gap = self.corner(0, s)
                else:
                    rolls, gap = [s, self.length - s], 0.0
                if rolls[0] < self.t[0].form or rolls[1] < self.t[1].form:
                    continue
                for k in (0, 1):
                    begin = self.t[k].tip - p["relief_length"][k]
                    share = (rolls[k] - begin) / p["relief_length"][k]
                    gap += p["relief"][k] * min(1.0, max(0.0, share))
                    gap += p["helix_crowning"][k] * (2 * face - 1) ** 2
                gap += p["misalignment"] * (face - 0.5) * b
                (one, h1), (two, h2) = self.t[0].compliance(rolls[0]), self.t[1].compliance(rolls[1])
                radius = rolls[0] * rolls[1] / (rolls[0] + rolls[1])
                star = E / (2 * (1 - NU**2))
                half = math.sqrt(4 * LINE_LOAD * radius / (math.pi * star))
                near = (1 - NU**2) / (math.pi * E) * sum(2 * math.log(2 * h / half) - NU / (1 - NU) for h in (h1, h2))
                yield gap, (one + two + near) / (b / n)

    def solve(self, phi, torque):
        g, c = map(np.array, zip(*self.points(phi)))
        load = torque / self.rb[0]
        forces = lambda d: np.maximum(0, (d - g) / c)
        first = g.min()
        d = brentq(lambda d: forces(d).sum() - load, first, first + 1e-3, xtol=1e-18, rtol=1e-14)
        stiffness = (1 / c)[forces(d) > 0].sum()
        return -d, stiffness, -first


def involute(tooth, rolls):
    """Points of the involute at lengths of roll, middle of the tooth along +y."""
    xi = rolls / tooth.rb
    psi = tooth.psi_b - (xi - np.arctan(xi))
    radius = tooth.rb * np.hypot(1.0, xi)
    return radius * np.sin(psi), radius * np.cos(psi)


def main():
    p = INPUTS
    mesh = Mesh(p)
    step = 2 * math.pi / p["teeth"][0] / p["positions"]
    rows = [[mesh.solve(i * step, t) for i in range(p["positions"])] for t in p["torques"]]
    out = {
        "source": f"tools/reference_mesh.py, scipy {scipy.__version__}",
        "inputs": p,
        "te": [[r[0] for r in row] for row in rows],
        "tangent": [[r[1] for r in row] for row in rows],
        "unloaded_te": [r[2] for r in rows[0]],
    }
    with open("data/reference/gear/loaded_mesh.json", "w") as file:
        json.dump(out, file, indent=1)
        file.write("\n")


def timed():
    """The problems of the speed measurement: k at 1000 positions of a spur pair, and a map of 20 torques, 60 positions, 11 slices."""
    base = INPUTS | {
        "helix_angle_deg": 0.0, "centre_distance": 0.12687, "tip_diameter": [0.0789, 0.1863], "relief": [0.0, 0.0],
        "helix_crowning": [0.0, 0.0], "misalignment": 0.0,
    }
    for what, positions, slices, torques in [("k at 1000 positions", 1000, 1, [100.0]),
                                             ("20 torques, 60 positions, 11 slices", 60, 11, [15.0 * i for i in range(1, 21)])]:
        mesh = Mesh(base | {"slices": slices})
        start = time.process_time()
        step = 2 * math.pi / 24 / positions
        for i in range(positions):
            for torque in torques:
                e, k, _ = mesh.solve(i * step, torque)
        print(f"{what}: {time.process_time() - start:.3f} s")
    start = time.process_time()
    for _ in range(100):
        tooth = Tooth(0, base)
        for i in range(100):
            tooth.fillet(1e-9 + (tooth.end - 1e-9) * i / 99)
        involute(tooth, np.linspace(tooth.form, tooth.tip, 100))
    print(f"flank of 200 points: {1e4 * (time.process_time() - start):.0f} µs")


if __name__ == "__main__":
    timed() if "--time" in sys.argv else main()
