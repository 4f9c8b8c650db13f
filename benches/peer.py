"""The peer of benches/modes.rs: the same problems through NumPy and SciPy (LAPACK, ARPACK with SuperLU).

`peer.py dense N` and `peer.py lowest N` print the best time of several runs in seconds and the worst relative error of the
frequencies; `peer.py whole FILE` reads a model of one [[chain]] and prints its frequencies, to be timed from outside.
"""

import sys
import time


def chain(n):
    import numpy as np

    k = 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    k[-1, -1] = 1.0
    return k, np.eye(n)


def exact(n):
    import numpy as np

    j = np.arange(1, n + 1)
    return 2.0 * np.sin((2 * j - 1) * np.pi / (2 * (2 * n + 1)))


def best(runs, work):
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        answer = work()
        times.append(time.perf_counter() - start)
    return min(times), answer


def dense(n):
    import numpy as np
    from scipy.linalg import eigh

    k, m = chain(n)
    seconds, (values, _) = best(max(3, 400 // n), lambda: eigh(k, m))
    omega = np.sqrt(np.abs(values))
    print(seconds, np.max(np.abs(omega / exact(n) - 1.0)))


def lowest(n):
    import numpy as np
    from scipy.sparse import diags, identity
    from scipy.sparse.linalg import eigsh

    main = np.full(n, 2.0)
    main[-1] = 1.0
    k = diags([main, -np.ones(n - 1), -np.ones(n - 1)], [0, 1, -1], format="csc")
    m = identity(n, format="csc")
    seconds, (values, _) = best(2, lambda: eigsh(k, 20, m, sigma=0.0, which="LM"))
    omega = np.sqrt(np.sort(values))
    print(seconds, np.max(np.abs(omega / exact(n)[:20] - 1.0)))


def whole(path):
    import tomllib

    import numpy as np
    from scipy.linalg import eigh

    with open(path, "rb") as file:
        (row,) = tomllib.load(file)["chain"]
    k, m = chain(row["count"])
    values, shapes = eigh(row["k"] * k, row["J"] * m)
    for number, value in enumerate(np.sqrt(np.abs(values)) / (2 * np.pi), start=1):
        print(number, value)


if __name__ == "__main__":
    kind, argument = sys.argv[1:3]
    {"dense": lambda: dense(int(argument)), "lowest": lambda: lowest(int(argument)), "whole": lambda: whole(argument)}[kind]()
