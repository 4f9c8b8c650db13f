#!/usr/bin/env python3
"""Roots of machines that are no sums of squares: oil films, negative stiffness, gyroscopic moments, for tests/machine/digits_trusted.rs.

Writes data/reference/digits.json, each case with its model. Run from the root: python3 tools/reference_digits.py
"""

import json
import platform
import random

import mpmath as mp

from assembly import Machine, complex_roots

mp.mp.dps = 90


def text(x):
    return float(mp.nstr(x, 18))


def body(name, polar, mass=None, diametral=None):
    rest = f", mass = {mass!r}, J_diametral = {diametral!r}" if mass else ""
    return f'  {{ name = "{name}", J = {polar!r}{rest} }},'


def rotor(rng, decades, cross, damping):
    """Two discs on a shaft, each in a bearing whose cross terms are not symmetric, its stiffness spread over so many decades."""
    spread = lambda around: float(f"{around * 10 ** rng.uniform(-decades / 2, decades / 2):.3e}")
    bodies, bearings = [], []
    for name in ("front", "rear"):
        polar = spread(0.05)
        bodies.append(body(name, polar, spread(10.0), float(f"{0.6 * polar:.3e}")))
        kx, ky = spread(1e8), spread(1e8)
        size = min(kx, ky)
        keys = {"k_x": kx, "k_y": ky, "k_rx": spread(1e6), "k_ry": spread(1e6)}
        if cross:
            keys |= {"k_x_y": float(f"{cross * size:.3e}"), "k_y_x": float(f"{-0.7 * cross * size:.3e}")}
        if damping:
            keys |= {"c_x": float(f"{damping * kx:.3e}"), "c_y": float(f"{damping * ky:.3e}"), "c_x_y": float(f"{0.2 * damping * size:.3e}")}
        bearings.append(f'  {{ name = "{name}_bearing", at = "{name}", ' + ", ".join(f"{k} = {v!r}" for k, v in keys.items()) + " },")
    # What couples the discs: a seat between them, front against rear, with one symmetric cross term.
    k, tilt = spread(1e7), spread(1e5)
    seat = f'  {{ name = "seat", between = ["front", "rear"], k_x = {k!r}, k_y = {k!r}, k_rx = {tilt!r}, k_ry = {tilt!r} }},'
    shaft = f'shaft = [ {{ name = "shaft", between = ["front", "rear"], k = {spread(1e5)!r} }} ]'
    return "\n".join(["inertia = [", *bodies, "]", "bearing = [", *bearings, seat, "]", shaft])


def negative(rng, n, decades, held, zeta):
    """A chain with one negative spring to ground, small beside its neighbours, and perhaps dampers."""
    spread = lambda d: float(f"{10 ** rng.uniform(-d / 2, d / 2):.3e}")
    bodies = [body(f"n{i}", spread(decades / 2)) for i in range(n)]
    joints = []
    for i in range(n):
        ends = f'["n{i - 1}", "n{i}"]' if i else '["ground", "n0"]'
        if i or held:
            k = spread(decades)
            loss = f", c = {float(f'{zeta * k ** 0.5:.3e}')!r}" if zeta else ""
            joints.append(f'  {{ name = "s{i}", between = {ends}, k = {k!r}{loss} }},')
    joints.append(f'  {{ name = "magnet", between = ["n{n // 2}", "ground"], k = {-spread(decades) * 0.01!r} }},')
    return "\n".join(["inertia = [", *bodies, "]", "coupling = [", *joints, "]"])


def case(name, parts, speed=0.0):
    model = f'title = "{name}"\nsource = "a test"\nunits = "SI"\n{parts}\n'
    machine = Machine(model)
    turning = {node: mp.mpf(speed) for node, _ in machine.dofs}
    roots = complex_roots(*machine.matrices(turning if speed else None))
    zeros = sum(1 for v in roots if v == 0)
    keep = [[text(v.real), text(v.imag)] for v in roots if v != 0 and v.imag >= 0]
    print(f"{name:28} {zeros} zeros, |λ| {mp.nstr(min(abs(v) for v in roots if v != 0), 3)} … {mp.nstr(abs(roots[-1]), 3)}", flush=True)
    return {"name": name, "model": model, "speed_rad_s": speed, "zeros": zeros, "roots_rad_s": keep}


cases = []
for at, decades in enumerate([1, 4, 8]):
    rng = random.Random(500 + at)
    cases.append(case(f"oil film {decades}", rotor(rng, decades, 0.3, 0.0)))
    cases.append(case(f"oil film, damped {decades}", rotor(rng, decades, 0.3, 1e-4)))
    cases.append(case(f"gyroscopic {decades}", rotor(rng, decades, 0.0, 0.0), 600.0))
    cases.append(case(f"gyroscopic, damped {decades}", rotor(rng, decades, 0.2, 1e-4), 600.0))
for at, decades in enumerate([2, 6, 10]):
    rng = random.Random(600 + at)
    cases.append(case(f"negative, held {decades}", negative(rng, 7, decades, True, 0.0)))
    cases.append(case(f"negative, free {decades}", negative(rng, 7, decades, False, 0.0)))
    cases.append(case(f"negative, damped {decades}", negative(rng, 7, decades, True, 0.05)))

made_by = {"script": "tools/reference_digits.py", "python": platform.python_version(), "mpmath": mp.__version__, "digits": mp.mp.dps}
with open("data/reference/digits.json", "w", encoding="utf-8") as file:
    file.write('{"made_by": ' + json.dumps(made_by) + ',\n"cases": [\n')
    file.write(",\n".join(json.dumps(c, ensure_ascii=False) for c in cases))
    file.write("\n]}\n")
