"""The peer of benches/motion.rs: the same equations through SciPy and SUNDIALS, right-hand sides compiled by Numba.

`motion_peer.py race FOLDER/machine.json` runs the peers that the file names, each from a loose tolerance to tighter ones until its
error is about what is wanted, and prints a line `seconds error name` for each; times are those on the processor, without
compilation. It reads `reference.bin` and `outputs.json` from the same folder. `motion_peer.py truth FILE OUT` writes the states of a
linear machine at its samples, by a matrix exponential in whole numbers of 500 bits.

`DOP853`, `Radau` and `BDF` step in Python (SciPy's solve_ivp), `LSODA` in Fortran (odeint): these call the compiled right-hand side
through Python. `CVODE` steps in C and calls the compiled right-hand side, Jacobian and roots by their addresses: between two samples
no Python runs. Its library is the one that scikit-sundae brings.
"""

import json
import math
import multiprocessing
import os
import resource
import sys
import time

# Seconds on the processor after which a run is given up.
PATIENCE = 6

LAWS = {"linear": 0, "contact": 1, "friction": 2, "induction": 3}


def main():
    with open(sys.argv[2]) as file:
        machine = json.load(file)
    if sys.argv[1] == "truth":
        truth(machine, sys.argv[3])
    else:
        race(machine, os.path.dirname(sys.argv[2]))


# A matrix exponential in whole numbers.


def truth(machine, out):
    import struct

    import numpy as np

    bits = 500
    one = 1 << bits

    def fixed(x):
        top, bottom = float(x).as_integer_ratio()
        return (top << bits) // bottom

    def product(a, b):
        return a.dot(b) >> bits

    n = len(machine["mass"])
    # States, the constant one, cosine and sine of every harmonic.
    waves = [(at, h) for at, d in enumerate(machine["drives"]) for h in d["harmonics"]]
    size = 2 * n + 1 + 2 * len(waves)
    a = np.zeros((size, size), dtype=object)
    start = np.zeros(size, dtype=object)
    start[: 2 * n] = [fixed(x) for x in machine["start"]]
    start[2 * n] = one
    for i in range(n):
        a[i, n + i] = one

    def push(i, j, value):
        """Adds a force, in whole numbers, to an acceleration."""
        top, bottom = machine["mass"][i].as_integer_ratio()
        a[n + i, j] += value * bottom // top

    for b in machine["branches"]:
        assert b["law"] == "linear" and not b["imposed"] and not b["wave"]
        k, c = b["numbers"]
        for i, x in b["u"]:
            for j, y in b["w"]:
                both = fixed(x) * fixed(y) >> bits
                push(i, j, -(fixed(k) * both >> bits))
                push(i, n + j, -(fixed(c) * both >> bits))
    if machine["general"]:
        for which, matrix in enumerate(machine["general"]):
            for i in range(n):
                for j in range(n):
                    push(i, which * n + j, -fixed(matrix[i][j]))
    for i in range(n):
        a[n + i, n + i] -= fixed(machine["drag"])
    for d in machine["drives"]:
        assert all(knot[0] <= 0.0 and knot[2] == 0.0 for knot in d["knots"])
        for i, x in d["d"]:
            if d["knots"]:
                push(i, 2 * n, fixed(x) * fixed(d["knots"][-1][1]) >> bits)
    for place, (at, (amplitude, omega, phase)) in enumerate(waves):
        cos = 2 * n + 1 + 2 * place
        a[cos, cos + 1], a[cos + 1, cos] = -fixed(omega), fixed(omega)
        start[cos], start[cos + 1] = fixed(math.cos(phase)), fixed(math.sin(phase))
        for i, x in machine["drives"][at]["d"]:
            push(i, cos, fixed(x) * fixed(amplitude) >> bits)
    assert machine["from"] == 0.0
    step = fixed(machine["until"]) // machine["samples"]
    a = (a * step) >> bits
    largest = max(sum(abs(x) for x in row) for row in a)
    halvings = max(0, largest.bit_length() - bits + 1)
    a = a >> halvings
    # e^A − 1 is squared as 2E + E², so that what is small keeps its digits.
    term, total = a, a.copy()
    for order in range(2, 90):
        term = product(term, a) // order
        if not term.any():
            break
        total = total + term
    for _ in range(halvings):
        total = 2 * total + product(total, total)
    with open(out, "wb") as file:
        for _ in range(machine["samples"] + 1):
            file.write(struct.pack(f"<{2 * n}d", *(int(x) / one for x in start[: 2 * n])))
            start = start + product(total, start)


# The right-hand side.


def equations(machine):
    """f(t, y, frozen, dy), compiled; frozen holds the stand of every branch (9: as y has it) and the piece of its wave (-1: as t has it)."""
    import numba
    import numpy as np

    n, branches, drives = len(machine["mass"]), machine["branches"], machine["drives"]
    count = len(branches)
    inner = [b["law"] == "induction" for b in branches]
    z_of = np.array([2 * n + sum(inner[:at]) for at in range(count)])
    law = np.array([LAWS[b["law"]] for b in branches])
    p = np.array([(b["numbers"] + 4 * [0.0])[:4] for b in branches])
    mass = np.array(machine["mass"])
    drag = machine["drag"]
    has_general = machine["general"] is not None
    k0, c0 = np.array(machine["general"]) if has_general else np.zeros((2, n, n))

    def flat(lists, width):
        lists = [x or [] for x in lists]
        ends = np.cumsum([0] + [len(x) for x in lists])
        values = [row for x in lists for row in x] or [width * [0.0]]
        return ends, np.array(values, dtype=float)

    w_ends, w = flat([b["w"] for b in branches], 2)
    u_ends, u = flat([b["u"] for b in branches], 2)
    d_ends, d = flat([x["d"] for x in drives], 2)
    signals = drives + [b["imposed"] or {"knots": [], "harmonics": []} for b in branches]
    knot_ends, knots = flat([s["knots"] for s in signals], 3)
    sine_ends, sines = flat([s["harmonics"] for s in signals], 3)
    knot_times = knots[:, 0].copy()
    imposed = np.array([b["imposed"] is not None for b in branches])
    waves = [b["wave"] or {"omega": 0.0, "start": 0.0} for b in branches]
    kind = np.array([1 if "steps" in x else 2 if "terms" in x else 0 for x in waves])
    phase = np.array([[x["omega"], x["start"]] for x in waves])
    steps = np.array([x.get("steps", [1.0, 1.0, 0.5]) for x in waves])
    mean = np.array([x.get("mean", 1.0) for x in waves])
    term_ends, term = flat([x.get("terms") for x in waves], 3)
    n_drives, n_imposed = len(drives), int(imposed.sum())
    tau = 2.0 * math.pi

    @numba.njit
    def signal(which, t):
        value = slope = 0.0
        first, last = knot_ends[which], knot_ends[which + 1]
        if last > first:
            at = first + np.searchsorted(knot_times[first:last], t, side="right") - 1
            if at >= first:
                value, slope = knots[at, 1], knots[at, 2]
                if slope != 0.0:
                    value += slope * (t - knots[at, 0])
        for i in range(sine_ends[which], sine_ends[which + 1]):
            angle = sines[i, 1] * t + sines[i, 2]
            value += sines[i, 0] * np.cos(angle)
            slope -= sines[i, 0] * sines[i, 1] * np.sin(angle)
        return value, slope

    @numba.njit
    def deflection(b, t, y):
        x = v = 0.0
        for i in range(w_ends[b], w_ends[b + 1]):
            j = int(w[i, 0])
            x += w[i, 1] * y[j]
            v += w[i, 1] * y[n + j]
        if imposed[b]:
            e, rate = signal(n_drives + b, t)
            x -= e
            v -= rate
        return x, v

    @numba.njit
    def factor(b, t, piece):
        if kind[b] == 0:
            return 1.0
        psi = (phase[b, 0] * t + phase[b, 1]) / tau
        if kind[b] == 1:
            if piece < 0:
                piece = 0 if psi - np.floor(psi) < steps[b, 2] else 1
            return steps[b, piece]
        k = mean[b]
        for i in range(term_ends[b], term_ends[b + 1]):
            k += term[i, 1] * np.cos(tau * term[i, 0] * psi + term[i, 2])
        return k

    @numba.njit
    def f(t, y, frozen, dy):
        for i in range(n):
            dy[i] = y[n + i]
            dy[n + i] = 0.0
        for at in range(n_drives):
            push, _ = signal(at, t)
            for i in range(d_ends[at], d_ends[at + 1]):
                dy[n + int(d[i, 0])] += d[i, 1] * push
        for b in range(count):
            x, v = deflection(b, t, y)
            if law[b] == 0:
                force = p[b, 0] * x + p[b, 1] * v
            elif law[b] == 1:
                k, c, half, losses = p[b, 0] * factor(b, t, frozen[count + b]), p[b, 1], p[b, 2], p[b, 3]
                stand = frozen[b]
                if stand == 9:
                    stand = 1 if x > half else -1 if x < -half else 0
                    if half == 0.0:
                        stand = 1
                force = c * v if losses == 0.0 else 0.0
                if stand != 0:
                    spring = k * (x - stand * half)
                    damper = c * v
                    if losses >= 2.0:
                        spring, damper = stand * spring, stand * damper
                        if losses == 3.0:
                            damper = min(damper, spring)
                        force = stand * max(0.0, spring + damper)
                    else:
                        force = spring + damper
            elif law[b] == 2:
                size = p[b, 0]
                if p[b, 1] != p[b, 0]:
                    size += (p[b, 1] - p[b, 0]) * np.exp(-((v / p[b, 2]) ** 2))
                force = np.sign(v) * size
            else:
                z = y[z_of[b]]
                s = 1.0 - v / p[b, 2]
                dy[z_of[b]] = (2.0 * p[b, 0] * s * p[b, 1] / (s * s + p[b, 1] * p[b, 1]) - z) / p[b, 3]
                force = -z
            for i in range(u_ends[b], u_ends[b + 1]):
                dy[n + int(u[i, 0])] -= u[i, 1] * force
        if has_general:
            for i in range(n):
                s = 0.0
                for j in range(n):
                    s += k0[i, j] * y[j] + c0[i, j] * y[n + j]
                dy[n + i] -= s
        for i in range(n):
            dy[n + i] = dy[n + i] / mass[i] - drag * y[n + i]

    contacts = np.array([b for b in range(count) if law[b] == 1], dtype=np.int64)

    @numba.njit
    def roots(t, y, values):
        for place in range(len(contacts)):
            b = contacts[place]
            x, _ = deflection(b, t, y)
            values[2 * place] = x - p[b, 2]
            values[2 * place + 1] = x + p[b, 2]

    return f, roots, contacts


# The peers.


def compiled(f, roots, free, contacts, length, jacobian):
    """SUNDIALS as scikit-sundae brings it, and functions that it can call by their addresses; none where it is missing."""
    import ctypes
    import glob

    import numba
    import numpy as np
    from numba import types

    try:
        import sksundae
    except ImportError:
        return None, None
    beside = os.path.join(os.path.dirname(os.path.dirname(sksundae.__file__)), "scikit_sundae.libs")
    (path,) = glob.glob(os.path.join(beside, "libsundials_cvode-*.so*"))
    library = ctypes.CDLL(path)
    values, frozen_count, root_count = length, len(free), 2 * len(contacts)
    content = library.N_VGetArrayPointer
    content.restype, content.argtypes = ctypes.c_void_p, [ctypes.c_void_p]
    matrix = library.SUNDenseMatrix_Data
    matrix.restype, matrix.argtypes = ctypes.c_void_p, [ctypes.c_void_p]

    @numba.extending.intrinsic
    def as_doubles(context, address):
        def build(context, builder, signature, arguments):
            return builder.inttoptr(arguments[0], context.get_value_type(types.CPointer(types.float64)))

        return types.CPointer(types.float64)(types.uintp), build

    @numba.extending.intrinsic
    def as_integers(context, address):
        def build(context, builder, signature, arguments):
            return builder.inttoptr(arguments[0], context.get_value_type(types.CPointer(types.int64)))

        return types.CPointer(types.int64)(types.uintp), build

    word = types.uintp

    @numba.cfunc(types.int32(types.float64, word, word, word))
    def right_hand_side(t, y, dy, user):
        state = numba.carray(as_doubles(content(y)), (values,))
        slope = numba.carray(as_doubles(content(dy)), (values,))
        f(t, state, numba.carray(as_integers(user), (frozen_count,)), slope)
        return 0

    @numba.cfunc(types.int32(types.float64, word, word, word))
    def switches(t, y, out, user):
        state = numba.carray(as_doubles(content(y)), (values,))
        roots(t, state, numba.carray(as_doubles(out), (root_count,)))
        return 0

    known = None
    if jacobian is not None:
        columns = np.ascontiguousarray(jacobian.T).ravel()

        @numba.cfunc(types.int32(types.float64, word, word, word, word, word, word, word))
        def known(t, y, fy, into, user, a, b, c):
            data = numba.carray(as_doubles(matrix(into)), (values * values,))
            for at in range(values * values):
                data[at] = columns[at]
            return 0

    return library, (right_hand_side, switches, known)


class Cvode:
    """CVODE with a dense Jacobian, the right-hand side called from C."""

    def __init__(self, race, name, tolerance, frozen, roots=0):
        import ctypes

        import numpy as np

        self.c, self.library, self.frozen, self.roots = ctypes, race.library, frozen, roots
        if self.library is None:
            raise RuntimeError("scikit-sundae is missing")
        right_hand_side, switches, known = race.addresses
        n = len(race.start)
        self.context = ctypes.c_void_p()
        self.call("SUNContext_Create", 0, ctypes.byref(self.context))
        self.vector, absolute = (self.new("N_VNew_Serial", ctypes.c_int64(n), self.context) for _ in range(2))
        self.y = self.array(self.vector, n)
        self.array(absolute, n)[:] = 1e-2 * tolerance * race.size
        self.memory = self.new("CVodeCreate", {"Adams": 1, "BDF": 2}[name], self.context)
        self.y[:] = race.start
        rhs = ctypes.c_void_p(right_hand_side.address)
        self.call("CVodeInit", self.memory, rhs, ctypes.c_double(0.0), self.vector)
        self.call("CVodeSVtolerances", self.memory, ctypes.c_double(tolerance), absolute)
        self.call("CVodeSetUserData", self.memory, ctypes.c_void_p(frozen.ctypes.data))
        size = ctypes.c_int64(n)
        matrix = self.new("SUNDenseMatrix", size, size, self.context)
        linear = self.new("SUNLinSol_Dense", self.vector, matrix, self.context)
        self.call("CVodeSetLinearSolver", self.memory, linear, matrix)
        if known is not None:
            self.call("CVodeSetJacFn", self.memory, ctypes.c_void_p(known.address))
        self.call("CVodeSetMaxNumSteps", self.memory, ctypes.c_long(10**8))
        if roots:
            self.call("CVodeRootInit", self.memory, roots, ctypes.c_void_p(switches.address))
        self.t, self.found = 0.0, np.zeros(max(roots, 1), dtype=np.intc)

    def new(self, name, *arguments):
        make = getattr(self.library, name)
        make.restype = self.c.c_void_p
        return self.c.c_void_p(make(*arguments))

    def call(self, name, *arguments):
        """The flag; below zero it failed."""
        flag = getattr(self.library, name)(*arguments)
        if flag < 0:
            raise RuntimeError(f"{name} ended with {flag}")
        return flag

    def array(self, vector, n):
        import numpy as np

        address = self.library.N_VGetArrayPointer(vector)
        return np.ctypeslib.as_array((self.c.c_double * n).from_address(address))

    def start(self, t, y):
        self.t, self.y[:] = t, y
        self.again()

    def again(self):
        self.call("CVodeReInit", self.memory, self.c.c_double(self.t), self.vector)

    def step(self, stop):
        """To `stop` or a root before it; gives which functions crossed zero, and how, where it was one."""
        ROOT = 2
        reached = self.c.c_double(self.t)
        self.call("CVodeSetStopTime", self.memory, self.c.c_double(stop))
        flag = self.call("CVode", self.memory, self.c.c_double(stop), self.vector, self.c.byref(reached), 1)
        self.t = reached.value
        if flag != ROOT:
            return None
        self.call("CVodeGetRootInfo", self.memory, self.c.c_void_p(self.found.ctypes.data))
        return self.found.copy()


class Race:
    def __init__(self, machine, folder):
        import numpy as np

        self.machine = machine
        self.start = np.array(machine["start"], dtype=float)
        step = (machine["until"] - machine["from"]) / machine["samples"]
        self.times = machine["from"] + np.arange(machine["samples"] + 1) * step
        self.times[-1] = machine["until"]
        self.reference = np.fromfile(f"{folder}/reference.bin").reshape(-1, len(self.start))
        with open(f"{folder}/outputs.json") as file:
            outputs = json.load(file)
        self.rows, self.sizes = np.array(outputs["rows"]), np.array(outputs["sizes"])
        self.wanted = outputs["wanted"]
        self.size = np.abs(self.reference).max(axis=0)
        self.size[self.size == 0.0] = self.size.max()
        self.compile()

    def compile(self):
        import numba
        import numpy as np

        f, roots, self.contacts = equations(self.machine)
        free = np.array(len(self.machine["branches"]) * [9] + len(self.machine["branches"]) * [-1])
        length = len(self.start)

        @numba.njit
        def returning(t, y):
            dy = np.empty(length)
            f(t, y, free, dy)
            return dy

        returning(0.0, self.start)
        self.free, self.returning, self.roots = free, returning, roots
        self.jacobian = None
        if self.machine["is_linear"]:
            base = returning(0.0, np.zeros(length))
            self.jacobian = np.array([returning(0.0, e) - base for e in np.eye(length)]).T
        self.library, self.addresses = compiled(f, roots, self.free, self.contacts, length, self.jacobian)

    def error(self, states):
        import numpy as np

        off = np.abs((states - self.reference) @ self.rows.T).max(axis=0)
        return float(np.max(off / self.sizes))

    def scipy(self, name, tolerance):
        from scipy.integrate import solve_ivp

        options = {"jac": self.jacobian} if self.jacobian is not None and name != "DOP853" else {}
        solution = solve_ivp(
            self.returning,
            (self.times[0], self.times[-1]),
            self.start,
            method=name,
            t_eval=self.times,
            rtol=tolerance,
            atol=1e-2 * tolerance * self.size,
            **options,
        )
        return solution.y.T

    def odeint(self, tolerance):
        from scipy.integrate import odeint

        atol = 1e-2 * tolerance * self.size
        return odeint(
            self.returning, self.start, self.times, tfirst=True, rtol=tolerance, atol=atol, mxstep=10**8
        )

    def cvode(self, name, tolerance):
        import numpy as np

        solver = Cvode(self, name, tolerance, self.free)
        solver.start(self.times[0], self.start)
        states = [self.start]
        for target in self.times[1:]:
            solver.step(target)
            states.append(solver.y.copy())
        return np.array(states)

    def breaks(self):
        """When stiffness jumps."""
        found = set()
        for b in self.machine["branches"]:
            wave = b["wave"]
            if wave and "steps" in wave:
                turn = 2.0 * math.pi / wave["omega"]
                for k in range(-1, int(self.times[-1] / turn) + 2):
                    for share in (0.0, wave["steps"][2]):
                        found.add((k + share) * turn - wave["start"] / wave["omega"])
        return sorted(t for t in found if self.times[0] < t)

    def cvode_by_roots(self, name, tolerance):
        """Stopped at every contact lost or made and at every jump of a stiffness, and started anew."""
        import numpy as np

        frozen = self.free.copy()
        branches = self.machine["branches"]

        def pieces(t):
            for at, b in enumerate(branches):
                if b["wave"] and "steps" in b["wave"]:
                    psi = (b["wave"]["omega"] * t + b["wave"]["start"]) / (2.0 * math.pi)
                    frozen[len(branches) + at] = 0 if psi % 1.0 < b["wave"]["steps"][2] else 1

        values = np.empty(2 * len(self.contacts))
        self.roots(self.times[0], self.start, values)
        for place, b in enumerate(self.contacts):
            frozen[b] = 1 if values[2 * place] > 0.0 else -1 if values[2 * place + 1] < 0.0 else 0
        jumps = self.breaks() + [math.inf]
        near = 1e-9 * (self.times[1] - self.times[0])
        solver = Cvode(self, name, tolerance, frozen, 2 * len(self.contacts))
        pieces(0.5 * (self.times[0] + min(jumps[0], self.times[-1])))
        solver.start(self.times[0], self.start)
        states, t, jump = [self.start], self.times[0], 0
        for target in self.times[1:]:
            while t < target:
                # A jump and a sample that differ by rounding are one.
                stop = target if abs(jumps[jump] - target) < near else min(target, jumps[jump])
                signs = solver.step(stop)
                t = solver.t
                anew = signs is not None
                if anew:
                    for place, b in enumerate(self.contacts):
                        if signs[2 * place]:
                            frozen[b] = 1 if signs[2 * place] > 0 else 0
                        elif signs[2 * place + 1]:
                            frozen[b] = -1 if signs[2 * place + 1] < 0 else 0
                if t >= jumps[jump] - near:
                    jump += 1
                    pieces(0.5 * (jumps[jump - 1] + min(jumps[jump], self.times[-1] + 1.0)))
                    anew = True
                if anew:
                    solver.again()
            states.append(solver.y.copy())
        return np.array(states)

    def run(self, name, tolerance):
        parts = name.split("-")
        if parts[0] == "CVODE":
            return (self.cvode_by_roots if len(parts) > 2 else self.cvode)(parts[1], tolerance)
        return self.odeint(tolerance) if name == "LSODA" else self.scipy(name, tolerance)

    def timed(self, name, tolerance):
        """Seconds on the processor and error; None where the run was given up."""
        ours, theirs = multiprocessing.Pipe(duplex=False)

        def work():
            used = int(time.process_time())
            resource.setrlimit(resource.RLIMIT_CPU, (used + PATIENCE, used + PATIENCE + 1))
            os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
            least = math.inf
            for _ in range(3):
                start = time.process_time()
                states = self.run(name, tolerance)
                least = min(least, time.process_time() - start)
                if states.shape != self.reference.shape:
                    return
                theirs.send((least, self.error(states)))
                if least > 0.3:
                    break

        child = multiprocessing.get_context("fork").Process(target=work)
        child.start()
        theirs.close()
        answer = None
        try:
            while True:
                answer = ours.recv()
        except EOFError:
            child.join()
        return answer

    def best(self, name):
        tolerance, found = 1e-7, None
        for _ in range(4):
            answer = self.timed(name, tolerance)
            if answer is None or not math.isfinite(answer[1]):
                break
            if found is None or answer[1] < found[1]:
                found = (*answer, tolerance)
            if answer[1] <= 1.5 * self.wanted or tolerance <= 1e-13:
                break
            # Errors fall about as tolerances do.
            power = math.floor(2.0 * math.log10(tolerance * min(0.3, self.wanted / answer[1]))) / 2.0
            tolerance = max(1e-13, 10.0**power)
        return found


def race(machine, folder):
    race = Race(machine, folder)
    for name in machine["peers"]:
        found = race.best(name)
        if found is None:
            print("nan", "-", name, f"given up after {PATIENCE} s", flush=True)
        else:
            seconds, error, tolerance = found
            print(seconds, error, name, f"at {tolerance:.1g}", flush=True)


if __name__ == "__main__":
    main()
