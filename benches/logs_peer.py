"""The peers of benches/logs.rs: the same files and numbers through pandas, Polars, SciPy, scikit-rf and sdypy-EMA.

Each prints the best time on the processor of some runs in seconds and the relative error of the answer. `pandas FILE` and `polars FILE` read a log;
`h1 FILE BLOCK RADIUS ANGLE` averages two signals of a file of numbers, `h1_by_hand` with one transform for each block and channel;
`vector_fit FILE MODES LINES` and `lscf FILE MODES LINES` find the poles of responses in a file of numbers.
"""

import sys
import time
import warnings


def best(runs, work):
    times = []
    for _ in range(runs):
        start = time.process_time()
        answer = work()
        times.append(time.process_time() - start)
    return min(times), answer


def misread(columns):
    """The largest relative distance of a value from the number nearest to what was written."""
    import numpy as np

    worst = 0.0
    for x in columns:
        written = np.round(x * 1e6) / 1e6
        worst = max(worst, np.max(np.abs(x - written) / np.maximum(np.abs(written), 1e-6)))
    return worst


def pandas(path):
    import pandas as pd

    seconds, table = best(2, lambda: pd.read_csv(path))
    print(seconds, misread(table[name].to_numpy() for name in table))


def polars(path):
    import polars as pl

    seconds, table = best(3, lambda: pl.read_csv(path))
    print(seconds, misread(column.to_numpy() for column in table))


def response_error(h, block, radius, angle):
    """Root mean square of the relative error of all lines but the first and the last."""
    import numpy as np

    back = np.exp(-2j * np.pi * np.arange(block // 2 + 1) / block)
    below = 1.0 - 2.0 * radius * np.cos(angle) * back + radius**2 * back**2
    return np.sqrt(np.mean(np.abs(h * below - 1.0)[1:-1] ** 2))


def signals(path):
    import numpy as np

    return np.split(np.fromfile(path), 2)


def h1(path, block, radius, angle):
    from scipy.signal import csd, welch

    x, y = signals(path)
    block = int(block)
    how = {"fs": 51200.0, "window": "hann", "nperseg": block, "noverlap": block // 2, "detrend": "constant"}

    def work():
        _, xy = csd(x, y, **how)
        _, xx = welch(x, **how)
        _, yy = welch(y, **how)
        return xy / xx, abs(xy) ** 2 / (xx * yy)

    seconds, (h, _) = best(2, work)
    print(seconds, response_error(h, block, float(radius), float(angle)))


def h1_by_hand(path, block, radius, angle):
    import numpy as np
    from scipy.signal import get_window

    x, y = signals(path)
    block = int(block)
    window = get_window("hann", block)
    together = 64

    def transforms(signal):
        blocks = np.lib.stride_tricks.sliding_window_view(signal, block)[:: block // 2]
        for first in range(0, len(blocks), together):
            some = blocks[first : first + together]
            yield np.fft.rfft((some - some.mean(axis=1, keepdims=True)) * window)

    def work():
        xx = yy = xy = 0.0
        for fx, fy in zip(transforms(x), transforms(y)):
            xx = xx + np.einsum("ij,ij->j", fx.conj(), fx).real
            yy = yy + np.einsum("ij,ij->j", fy.conj(), fy).real
            xy = xy + np.einsum("ij,ij->j", fx.conj(), fy)
        return xy / xx, abs(xy) ** 2 / (xx * yy)

    seconds, (h, _) = best(2, work)
    print(seconds, response_error(h, block, float(radius), float(angle)))


def responses(path, modes, lines):
    """True poles, lines in Hz, responses by rows."""
    import numpy as np

    modes, lines = int(modes), int(lines)
    numbers = np.fromfile(path)
    truth, rest = numbers[: 2 * modes].view(complex), numbers[2 * modes :]
    return truth, rest[:lines], rest[lines:].view(complex).reshape(-1, lines)


def worst(truth, found):
    """The worst relative distance of a true pole from the nearest one found."""
    return max(min(abs(q - p) for q in found) / abs(p) for p in truth)


def vector_fit(path, modes, lines):
    import numpy as np
    import skrf
    from skrf.vectorFitting import VectorFitting

    truth, f, h = responses(path, modes, lines)
    ports = int(np.sqrt(len(h)))
    s = h.T.reshape(-1, ports, ports)
    network = skrf.Network(f=f, f_unit="Hz", s=s, z0=50.0)

    def work():
        fit = VectorFitting(network)
        fit.vector_fit(n_poles_real=0, n_poles_cmplx=int(modes), enforce_dc=False)
        return fit

    seconds, fit = best(1, work)
    print(seconds, worst(truth, fit.poles), len(fit.d_res_history))


def lscf(path, modes, lines):
    import numpy as np
    from sdypy import EMA

    truth, f, h = responses(path, modes, lines)

    def work():
        model = EMA.Model(h, f, lower=f[0], upper=f[-1], pol_order_high=2 * int(modes), frf_form="receptance")
        model.get_poles(show_progress=False)
        return model

    seconds, model = best(1, work)
    # Its picker is told where to look; the usual window of 50 Hz reaches below the first mode.
    model.select_closest_poles(list(abs(truth) / (2.0 * np.pi)), f_window=10)
    size, damping = 2.0 * np.pi * np.array(model.nat_freq), np.array(model.nat_xi)
    print(seconds, worst(truth, size * (-damping + 1j * np.sqrt(1.0 - damping**2))))


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    kinds = {k.__name__: k for k in (pandas, polars, h1, h1_by_hand, vector_fit, lscf)}
    kinds[sys.argv[1]](*sys.argv[2:])
