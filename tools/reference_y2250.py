#!/usr/bin/env python3
"""Frequencies of larger shipped models by an assembly of its own, for tests/machine/published_cases.rs.

Writes data/reference/y2250.json, helical_lateral.json and overhung_rotor.json. Run from the root: python3 tools/reference_y2250.py
"""

import json
import platform

import mpmath as mp

from assembly import Machine, complex_roots, undamped

mp.mp.dps = 60


def text(x):
    return float(mp.nstr(x, 14))


def write(name, **lists):
    made_by = {"script": "tools/reference_y2250.py", "python": platform.python_version(), "mpmath": mp.__version__, "digits": mp.mp.dps}
    out = {"source": "assembled from the model file independently of geardyn (tools/assembly.py)", "model": f"models/{name}.toml", "made_by": made_by, "rtol": 1e-10, **lists}
    with open(f"data/reference/{name}.json", "w", encoding="utf-8") as file:
        json.dump(out, file, indent=1, ensure_ascii=False)
        file.write("\n")
    print(name, lists)


def hertz(machine):
    m, _, k = machine.matrices()
    return [text(w / (2 * mp.pi)) for w in undamped(m, k)]


for name in ("y2250", "helical_lateral"):
    write(name, recomputed_hz=hertz(Machine(f"models/{name}.toml")))

rotor = Machine("models/overhung_rotor.toml")
lists = {"recomputed_hz": hertz(rotor)}
turns = {"wheel": mp.mpf(1), "pulley": mp.mpf(1), "headstock": mp.mpf(0)}  # the slide holds the headstock
speed = 3000 * 2 * mp.pi / 60
roots = complex_roots(*rotor.matrices({name: speed * r for name, r in turns.items()}))
# The two zero roots, angle and speed of the spindle, are one rigid mode.
lists["at_3000_rpm_hz"] = [0.0] + [text(abs(v) / (2 * mp.pi)) for v in roots if v.imag > 0]
write("overhung_rotor", **lists)
