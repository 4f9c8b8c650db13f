"""Time of a flank point of data/reference/gear/c12_nasa_cr191009_flanks.json with SciPy: the three equations of a node by fsolve.

The problem of tests/gear/gear_speed.rs: meshing, axial place and radius in the blade coordinate, the cutter's angle and the cradle's.
Run: python tools/gear_flank_peer.py (numpy, scipy); prints seconds a point and the largest residual against the file's points.
"""

import json
import time

import numpy as np
from scipy.optimize import fsolve

CASE = json.load(open("data/reference/gear/c12_nasa_cr191009_flanks.json"))


def turn(axis, angle):
    c, s = np.cos(angle), np.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    m = np.eye(3)
    m[i, i] = m[j, j] = c
    m[i, j], m[j, i] = -s, s
    return m


class Flank:
    def __init__(self, f):
        deg = np.deg2rad
        self.h, self.r, self.psi, self.s = f["h"], f["r"], deg(f["psi"]), f["s"]
        q, d, mu = deg(f["q"]), deg(f["deden"]), deg(f["mu"])
        self.first = turn(0, self.h * q)
        self.centre = np.array([0.0, -self.h * self.s * np.sin(q), self.s * np.cos(q)])
        self.root = turn(1, -d)
        self.offset = np.array([-f["lm"] * np.sin(d), self.h * f["em"], f["lm"] * np.cos(d)])
        self.last = turn(1, mu)
        self.roll = 1.0 / f["mcw"]

    def state(self, u, theta, phi):
        s, c = np.sin(theta), np.cos(theta)
        sp, cp = np.sin(self.psi), np.cos(self.psi)
        p = np.array([self.r / np.tan(self.psi) - u * cp, u * sp * s, u * sp * c])
        n = np.array([sp, cp * s, cp * c])
        a = self.first @ p + self.centre
        cradle = turn(0, -self.h * phi)
        b = cradle @ a
        velocity = self.last @ (self.root @ np.cross([-self.h, 0, 0], b))
        work = self.last @ (self.root @ b + self.offset)
        normal = self.last @ (self.root @ (cradle @ (self.first @ n)))
        velocity = velocity + np.cross([0, 0, -self.h * self.roll], work)
        return turn(2, -self.h * self.roll * phi) @ work, normal @ velocity

    def residual(self, y, z, radius):
        r, f = self.state(*y)
        return [f, r[2] - z, np.hypot(r[0], r[1]) - radius]


def main():
    for name, f in CASE["flanks"].items():
        flank = Flank(f)
        u, theta, phi = f["seed_u_theta_phi"]
        y = [u, np.deg2rad(theta), np.deg2rad(phi)]
        nodes = CASE["grid_computed_here"][name]
        best, worst = np.inf, 0.0
        for _ in range(20):
            start = time.process_time()
            found = [fsolve(flank.residual, y, args=(n["xyz"][2], np.hypot(*n["xyz"][:2])), xtol=1e-13) for n in nodes]
            best = min(best, (time.process_time() - start) / len(nodes))
        for y1, n in zip(found, nodes):
            worst = max(worst, np.linalg.norm(flank.state(*y1)[0] - n["xyz"]))
        print(f"{name}: {best * 1e6:.0f} us a point, {worst:.1e} in")


main()
