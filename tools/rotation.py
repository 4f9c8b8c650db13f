#!/usr/bin/env python3
"""Reference answers for tests/signal/rotation.rs by NumPy and SciPy.

Writes data/reference/rotation.json: one short signal and, of it, the analytic signal, the real cepstrum, a spectrogram, and a decimation by five
with a Kaiser filter; a clamped cubic spline; the Kaiser window's shape and Bessel's function.
Run from the root of the repository: python3 tools/rotation.py
"""

import json
import platform

import numpy as np
import scipy
from scipy import interpolate, signal, special

RATE = 1000.0
N = 240


def kaiser_low_pass(edge_pass, edge_stop, db):
    """The filter of src/spectrum/kaiser_fir.rs by NumPy's window and sinc; edges over the sample rate."""
    depth = db + 1.5
    half = int(np.ceil((depth - 7.95) / (2.285 * 2 * np.pi * (edge_stop - edge_pass)) / 2))
    while True:
        j = np.arange(-half, half + 1)
        taps = np.sinc((edge_pass + edge_stop) * j) * np.kaiser(2 * half + 3, signal.kaiser_beta(depth))[1:-1]
        taps /= taps.sum()
        _, low = signal.freqz(taps, worN=np.linspace(0, edge_pass, 200), fs=1)
        _, high = signal.freqz(taps, worN=np.linspace(edge_stop, 0.5, 500), fs=1)
        if max(abs(abs(low) - 1).max(), abs(high).max()) < 10 ** (-db / 20):
            return taps, half
        half += 1


def main():
    rng = np.random.default_rng(20)
    t = np.arange(N) / RATE
    x = np.round(np.cos(2 * np.pi * 63.0 * t + 0.4) + 0.5 * np.sin(2 * np.pi * 11.3 * t) + 0.3 * rng.standard_normal(N) + 0.2, 4)

    analytic = signal.hilbert(x)
    cepstrum = np.fft.irfft(np.log(np.abs(np.fft.rfft(x))), N)[: N // 2 + 1]
    frequency, time, density = signal.spectrogram(
        x, RATE, window="hann", nperseg=48, noverlap=24, detrend="constant", scaling="density", mode="psd"
    )

    factor = 5
    taps, half = kaiser_low_pass(0.5 * 0.8 / factor, 0.5 / factor, 80.0)
    padded = np.concatenate([np.full(half, x[0]), x, np.full(half, x[-1])])
    decimated = signal.upfirdn(taps, padded, down=1)[2 * half : 2 * half + N : factor]

    knots = np.cumsum(0.02 + 0.01 * rng.random(30))
    angle = 40 * knots + 3 * np.sin(7 * knots)
    ends = []
    for part, at in ((slice(0, 4), 0), (slice(-4, None), 3)):
        lagrange = interpolate.BarycentricInterpolator(knots[part], angle[part])
        ends.append(float(lagrange.derivative(knots[part][at])))
    spline = interpolate.CubicSpline(knots, angle, bc_type=((1, ends[0]), (1, ends[1])))
    between = np.linspace(knots[0], knots[-1], 50)

    out = {
        "made_by": {
            "script": "tools/rotation.py",
            "python": platform.python_version(),
            "numpy": np.__version__,
            "scipy": scipy.__version__,
        },
        "rate_hz": RATE,
        "signal": x.tolist(),
        "analytic_im": analytic.imag.tolist(),
        "cepstrum": cepstrum.tolist(),
        "spectrogram": {
            "frequency_hz": frequency.tolist(),
            "time_s": time.tolist(),
            "density": density.T.tolist(),
        },
        "decimated_by_5": decimated.tolist(),
        "spline": {
            "time_s": knots.tolist(),
            "angle": angle.tolist(),
            "at_s": between.tolist(),
            "value": spline(between).tolist(),
            "speed": spline(between, 1).tolist(),
        },
        "bessel_i0": [[v, float(special.i0(v))] for v in (0.0, 0.5, 3.0, 9.0, 20.0)],
        "kaiser_beta": [[db, float(signal.kaiser_beta(db))] for db in (15.0, 30.0, 50.0, 80.0, 120.0)],
    }
    with open("data/reference/rotation.json", "w") as file:
        json.dump(out, file)
        file.write("\n")


if __name__ == "__main__":
    main()
