"""Writes data/reference/transfer.json: transfer functions by poles and residues as scipy.signal sees them.

    python3 tools/transfer.py

Poles and residues of the upper half plane are chosen here; scipy gives the response (freqs of the polynomials), zeros and
gain (tf2zpk of invres), residues back (residue), and the sampled forms (cont2discrete). numpy and scipy in double precision.
"""

import json
import pathlib

import numpy as np
import scipy
from scipy import signal

OUT = pathlib.Path(__file__).resolve().parent.parent / "data" / "reference" / "transfer.json"


def pack(values):
    return [[float(v.real), float(v.imag)] for v in np.atleast_1d(np.asarray(values, complex))]


def case(name, poles, residues, constant, step, lines):
    poles, residues = np.array(poles, complex), np.array(residues, complex)
    both = lambda v: np.array([x for p, y in zip(poles, v) for x in ([y, y.conj()] if p.imag > 0 else [y])])
    num, den = signal.invres(both(residues), both(poles), [constant] if constant else [])
    num, den = np.trim_zeros(num.real, "f"), den.real
    num = num[np.abs(num) > 1e-13 * np.abs(num).max()] if not constant else num
    zeros, _, gain = signal.tf2zpk(num, den)
    back, at, _ = signal.residue(num, den)
    w = 2 * np.pi * np.array(lines)
    form = signal.tf2ss(num, den)
    sampled = {}
    for method in ["zoh", "bilinear"] + ([] if constant else ["impulse"]):
        a, b, c, d, _ = signal.cont2discrete(form, step, method=method)
        z = np.exp(1j * w * step)
        response = [(c @ np.linalg.solve(x * np.eye(len(a)) - a, b) + d)[0, 0] for x in z]
        sampled[method] = {"response": pack(response), "poles": pack(np.linalg.eigvals(a))}
    return {
        "name": name, "poles": pack(poles), "residues": pack(residues), "constant": constant,
        "numerator": num.tolist(), "denominator": den.tolist(), "zeros": pack(zeros), "gain": float(gain),
        "residue_poles": pack(at), "residue_residues": pack(back),
        "lines_hz": list(lines), "response": pack(signal.freqs(num, den, w)[1]),
        "step_s": step, "sampled": sampled,
    }


lines = [0.1, 0.5, 1.0, 1.5, 2.2, 3.1]
cases = [
    case("two modes and a lag", [-0.2 + 6.1j, -0.5 + 12.7j, -3.0], [0.4 - 1.3j, -0.2 + 0.7j, 0.9], 0.25, 0.05, lines),
    case("without a constant", [-0.2 + 6.1j, -0.5 + 12.7j, -3.0], [0.4 - 1.3j, -0.2 + 0.7j, 0.9], 0.0, 0.05, lines),
    case("one resonance", [-0.05 + 9.0j], [0.3 - 0.8j], 0.0, 0.02, lines),
]
OUT.write_text(json.dumps({
    "made_by": f"tools/transfer.py with scipy {scipy.__version__}, numpy {np.__version__}",
    "cases": cases,
}, indent=1) + "\n")
