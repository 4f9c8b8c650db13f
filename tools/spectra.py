"""Spectra of a short signal by scipy: data/reference/spectra.json, read by tests/signal/spectra.rs.

The signal is made of integers, so that both programs hold the same: x_j = ((a j² + b j) mod m)/m − ½ summed with the channel
before it, delayed by three samples. Run with numpy 2 and scipy 1: python tools/spectra.py
"""

import json

import numpy as np
import scipy
from scipy import signal

n, rate = 1000, 512.0
j = np.arange(n, dtype=np.int64)
x = ((37 * j * j + 11 * j) % 1009) / 1009 - 0.5
y = ((53 * j * j * j + 29 * j) % 997) / 997 - 0.5
y[3:] += 2.0 * x[:-3]
y += 0.25 + 0.001 * j


def ri(z):
    return {"re": list(z.real), "im": list(z.imag)}


windows = {
    "hann": "hann",
    "hamming": "hamming",
    "flat-top": "flattop",
    "blackman-harris": "blackmanharris",
    "kaiser:8.6": ("kaiser", 8.6),
}
cases = []
for ours, block, overlap, detrend in [
    ("hann", 64, 32, "constant"),
    ("flat-top", 50, 40, "linear"),
    ("kaiser:8.6", 63, 21, False),
]:
    keys = dict(fs=rate, window=windows[ours], nperseg=block, noverlap=overlap, detrend=detrend)
    f, pxx = signal.welch(x, **keys)
    pyy = signal.welch(y, **keys)[1]
    pxy = signal.csd(x, y, **keys)[1]
    coherence = signal.coherence(x, y, **keys)[1]
    cases.append(
        dict(window=ours, block=block, overlap=overlap, detrend=str(detrend), frequency_hz=list(f),
             pxx=list(pxx), pyy=list(pyy), pxy=ri(pxy), coherence=list(coherence))
    )

out = dict(
    made_by=f"tools/spectra.py, scipy {scipy.__version__}, numpy {np.__version__}",
    rate_hz=rate,
    windows={name: list(signal.get_window(word, 16, fftbins=True)) for name, word in windows.items()},
    welch=cases,
)
with open("data/reference/spectra.json", "w") as file:
    json.dump(out, file)
