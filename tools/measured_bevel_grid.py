#!/usr/bin/env python3
"""The grid of data/bevel_12_36_grid.csv: the concave flank of models/gears/bevel_12_36.toml cut with wrong settings.

The machine cut with its radial distance 0.06 mm too large, its machine root angle 4' too small and its ratio of roll (cradle over work) 0.0003 too
large. Deviations lie along the nominal normals, positive where metal is left. Each reading has an error of 0.2 um (normal, seed 5), the work was
turned by the probe to zero at the middle node, and readings are rounded to 0.1 um, as a coordinate-measuring machine prints them.

Nothing is shared with the Rust sources: frames as in NASA CR-191009, the equation of meshing by central differences over the cradle's turn,
SciPy's fsolve. Ran with Python 3, NumPy and SciPy; `python3 tools/measured_bevel_grid.py > data/bevel_12_36_grid.csv`.
"""
import numpy as np
from scipy.optimize import fsolve

INCH = 25.4
SETTINGS = dict(point=2.96562137806 * INCH, blade=np.radians(18.045669752), radial=2.94780202969 * INCH, cradle=np.radians(63.9420304635),
                offset=0.154575896 * INCH, base=0.011672732029611077 * INCH, back=-0.040230616483779034 * INCH,
                root=np.radians(16.86666664), ratio=0.30838512709)
WRONG = dict(SETTINGS, radial=SETTINGS["radial"] + 0.06, root=SETTINGS["root"] - np.radians(4 / 60), ratio=SETTINGS["ratio"] + 3e-4)
ROWS, COLUMNS = 5, 9


def turn(axis, angle):
    c, s = np.cos(angle), np.sin(angle)
    i, j = [(1, 2), (2, 0), (0, 1)][axis]
    r = np.eye(3)
    r[i, i] = r[j, j] = c
    r[i, j], r[j, i] = -s, s
    return r


def point(m, y):
    """Point and normal of the outside blade in the work, left hand: blade length s, cutter angle, cradle angle."""
    s, theta, phi = y
    sin, cos = np.sin(m["blade"]), np.cos(m["blade"])
    across = np.array([np.cos(theta), np.sin(theta), 0.0])
    r = (m["point"] + s * sin) * across - np.array([0, 0, s * cos])
    n = cos * across + np.array([0, 0, sin])
    centre = m["radial"] * np.array([np.cos(m["cradle"]), -np.sin(m["cradle"]), 0.0])
    cradle, lift = turn(2, phi), turn(1, m["root"] - np.pi / 2)
    work = turn(2, -phi / m["ratio"])
    r = lift @ (cradle @ (r + centre) + np.array([0, m["offset"], -m["base"]]))
    return work @ (r - np.array([0, 0, m["back"]])), work @ (lift @ (cradle @ n))


def meshing(m, y):
    step = 1e-5
    ahead, _ = point(m, [y[0], y[1], y[2] + step])
    behind, _ = point(m, [y[0], y[1], y[2] - step])
    return point(m, y)[1] @ (ahead - behind) / (2 * step)


def place(face, height):
    """z and radius on the blank of the report."""
    dedendum, addendum, cl = np.radians(1.56666666), np.radians(3.8833334), 0.03
    g = np.radians(18.4333333) - dedendum
    along = (3.191 - 0.5) * np.cos(dedendum) + face
    z = along * np.cos(g) - cl * np.sin(g)
    r = z * np.tan(g) + cl / np.cos(g)
    depth = z * np.tan(addendum + dedendum) / np.cos(g) - cl
    return (z - height * depth * np.sin(g)) * INCH, (r + height * depth * np.cos(g)) * INCH


def main():
    rng = np.random.default_rng(5)
    nodes, deviations, at = [], [], None
    for column in range(COLUMNS):
        for row in range(ROWS):
            z, radius = place(0.06 + 0.88 * column / (COLUMNS - 1), 0.2 + 0.7 * row / (ROWS - 1))

            def on_blank(y):
                r, _ = point(SETTINGS, y)
                return [meshing(SETTINGS, y), r[2] - z, np.hypot(r[0], r[1]) - radius]

            at = near(on_blank) if at is None else fsolve(on_blank, at, xtol=1e-13)
            assert max(map(abs, on_blank(at))) < 1e-9
            p, n = point(SETTINGS, at)
            # Out of the metal, which lies beyond the blade's outside.
            outward = -n

            def on_ray(y):
                r, _ = point(WRONG, y[:3])
                return [meshing(WRONG, y[:3]), *(r - p - y[3] * outward)]

            found = fsolve(on_ray, [*at, 0.0], xtol=1e-13)
            assert max(map(abs, on_ray(found))) < 1e-9
            nodes.append((z, radius, outward @ np.cross([0, 0, 1], p)))
            deviations.append(found[3])
    deviations = np.array(deviations)
    lever = np.array([node[2] for node in nodes])
    middle = len(nodes) // 2
    deviations -= deviations[middle] / lever[middle] * lever
    deviations += rng.normal(0, 0.2e-3, len(nodes))
    print("# Concave flank of the pinion of models/gears/bevel_12_36.toml; made by tools/measured_bevel_grid.py, which states the true settings.")
    print("flank,z [mm],radius [mm],deviation [µm]")
    for (z, radius, _), d in zip(nodes, deviations):
        print(f"concave,{z:.4f},{radius:.4f},{1e3 * d:.1f}")


def near(equations):
    """The root of least cradle angle over starts around the cutter."""
    roots = []
    for theta in np.radians(np.arange(-180, 180, 15)):
        for phi in (-0.1, 0.0, 0.1):
            found, info, _, _ = fsolve(equations, [5.0, theta, phi], xtol=1e-13, full_output=True)
            if max(map(abs, info["fvec"])) < 1e-9 and 0 < found[0] < 15 and abs(found[2]) < 0.5:
                roots.append(found)
    return min(roots, key=lambda y: abs(y[2]))


main()
