"""Scallops between two passes of a blade on the flanks of NASA CR-191009, in closed form and by fsolve: data/reference/gear/blade_scallops.json.

The machine is written anew from the report (data/reference/gear/c12_nasa_cr191009_flanks.json, `convention`); normals come from differences.
python3 tools/gear_blade_peer.py > data/reference/gear/blade_scallops.json
"""
import json
import warnings

import numpy as np
import scipy
from scipy.optimize import brentq, fsolve

warnings.simplefilter("ignore")
FOLDER = "data/reference/gear/"
MICROMETRES = 25400.0


def turn(axis, angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array({
        "x": [[1, 0, 0], [0, c, -s], [0, s, c]],
        "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
        "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
    }[axis])


def surface(f):
    h, r, s = f["h"], f["r"], f["s"]
    psi, q, root, mu = (np.radians(f[k]) for k in ("psi", "q", "deden", "mu"))

    def place(u, theta, x):
        p = np.array([r / np.tan(psi) - u * np.cos(psi), u * np.sin(psi) * np.sin(theta), u * np.sin(psi) * np.cos(theta)])
        p = turn("x", h * q) @ p + np.array([0, -s * np.sin(h * q), s * np.cos(h * q)])
        p = turn("y", -root) @ turn("x", -h * x) @ p
        p = p + np.array([-f["lm"] * np.sin(root), h * f["em"], f["lm"] * np.cos(root)])
        return turn("z", -h * x / f["mcw"]) @ turn("y", mu) @ p

    return place


def on_blank(f, common, face, height):
    root, tip = np.radians(f["deden"]), np.radians(f["addan"] + f["deden"])
    cone, width = np.radians(f["mu"]) - root, common["face_width"]
    along = (common["rl_mean_cone"] - 0.5 * width) * np.cos(root) + face * width
    z = along * np.cos(cone) - f["cl"] * np.sin(cone)
    r = z * np.tan(cone) + f["cl"] / np.cos(cone)
    depth = z * np.tan(tip) / np.cos(cone) - f["cl"]
    return z - height * depth * np.sin(cone), r + height * depth * np.cos(cone)


def scallop(place, blank, seed, step, drag, e=1e-5):
    def difference(at, k):
        shift = np.eye(3)[k] * e
        return (place(*(at + shift)) - place(*(at - shift))) / (2 * e)

    def normal(at):
        n = np.cross(difference(at, 0), difference(at, 1))
        return n / np.linalg.norm(n)

    def flank(at):
        p = place(*at)
        return [normal(at) @ difference(at, 2), p[2] - blank[0], np.hypot(p[0], p[1]) - blank[1]]

    at = fsolve(flank, seed, xtol=1e-13)
    point, n = place(*at), normal(at)

    def facet(x):
        ray = lambda w: place(w[0], w[1], at[2] + x + drag * (w[1] - at[1])) - point - n * w[2]
        return fsolve(ray, [at[0], at[1], 0.0], xtol=1e-14)[2]

    share = brentq(lambda s: facet(s * step) - facet((s + 1) * step), -0.9, -0.1, xtol=1e-10)
    return abs(facet(share * step)) * MICROMETRES


def main():
    case = json.load(open(FOLDER + "c12_nasa_cr191009_flanks.json"))
    rows = []
    for name, blades, degrees, face, height, *_ in json.load(open(FOLDER + "c26_discrete_blades_nasa.json"))["rows"]:
        f = case["flanks"][name]
        seed = np.array(f["seed_u_theta_phi"]) * [1, np.pi / 180, np.pi / 180]
        blank, step = on_blank(f, case["common_gear"], face, height), np.radians(degrees / blades)
        drag = np.radians(degrees) / (2 * np.pi)
        both = [round(scallop(surface(f), blank, seed, step, sign * drag), 7) for sign in (1, -1)]
        rows.append([name, blades, degrees, face, height, *both])
    text = ",\n  ".join(json.dumps(row) for row in rows)
    print('{\n "made_by": "tools/gear_blade_peer.py, numpy %s, scipy %s",' % (np.__version__, scipy.__version__))
    print(' "columns": "flank, blades, degrees of the cradle a turn, face, height, highest scallop um with the cradle turning with and against theta",')
    print(' "rows": [\n  %s\n ]\n}' % text)


main()
