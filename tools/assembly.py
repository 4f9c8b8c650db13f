"""M, C, G and K of a model file by an assembly of its own, for the scripts that make references.

Nothing of it is taken from the Rust sources: bodies have a displacement and a rotation vector, gears touch at a pitch point
along a tooth normal worked out from two rotations, and everything is summed in mpmath numbers. Frames: z along each shaft of
its own body; both shafts of a pair are parallel or, for bevels and worms, only turn.
"""

import re
import tomllib

import mpmath as mp

PREFIX = {"": 0, "k": 3, "M": 6, "G": 9, "m": -3, "c": -2, "µ": -6, "u": -6, "n": -9}
BASE = {"m": 1, "g": mp.mpf("1e-3"), "s": 1, "N": 1, "Pa": 1, "rad": 1}
DIRECT = {"deg": mp.pi / 180, "rpm": 2 * mp.pi / 60, "min": 60, "kg": 1}
MATERIALS = {  # Shigley's Mechanical Engineering Design, Table A-5; EN 1993-1-2, 3.2.2(1); EN 1999-1-1, 3.2.5
    "steel": ("79.3e9", "7850"),
    "cast_iron": ("41.4e9", "7200"),
    "bronze": ("41.4e9", "8170"),
    "aluminium": ("27e9", "2700"),
}


def number(value):
    return mp.mpf(repr(value)) if isinstance(value, float) else mp.mpf(value)


def quantity(value):
    """A number in SI from text with a unit; bare numbers stand as they are."""
    if not isinstance(value, str):
        return number(value)
    digits, _, unit = value.partition(" ")
    result, sign = mp.mpf(digits), 1
    for token in re.findall(r"[/·*]|[^/·* ]+", unit):
        if token == "/":
            sign = -1
        elif token not in "·*":
            result *= factor(token) ** sign
    return result


def factor(token):
    word = re.match(r"[^\d²³^]+", token).group()
    power = {"": 1, "²": 2, "³": 3, "2": 2, "3": 3, "^2": 2, "^3": 3}[token[len(word):]]
    if word in DIRECT:
        return mp.mpf(DIRECT[word]) ** power
    for base, size in BASE.items():
        if word.endswith(base) and word[: -len(base)] in PREFIX:
            return (mp.mpf(size) * mp.mpf(10) ** PREFIX[word[: -len(base)]]) ** power
    raise ValueError(token)


class Machine:
    """Axes of node a: (a, 'theta'), (a, 'x') …; rigid joints are rows that must vanish."""

    def __init__(self, path_or_text):
        text = path_or_text if "\n" in path_or_text else open(path_or_text, encoding="utf-8").read()
        self.model = tomllib.loads(text)
        self.dofs, self.index = [], {}
        self.masses, self.springs, self.dampers, self.rigid, self.gyro = [], [], [], [], []
        self.ratios = []
        self.cross_k, self.cross_c = [], []
        self.build()

    def table(self, name):
        return self.model.get(name, [])

    def node(self, name, axes=("theta",)):
        for axis in axes:
            if (name, axis) not in self.index:
                self.index[(name, axis)] = len(self.dofs)
                self.dofs.append((name, axis))

    def material(self, part):
        shear, density = MATERIALS.get(part.get("material"), ("nan", "nan"))
        return (quantity(part.get("shear_modulus", float(shear))), quantity(part.get("density", float(density))))

    def body(self, part):
        if "J" in part:
            return (quantity(part["J"]), *(quantity(part[k]) if k in part else None for k in ("mass", "J_diametral")))
        outer, inner, width = (quantity(part.get(k, 0)) for k in ("diameter", "bore", "width"))
        ro, ri = outer / 2, inner / 2
        mass = self.material(part)[1] * mp.pi * (ro**2 - ri**2) * width
        polar = mass * (ro**2 + ri**2) / 2
        return polar, mass, polar / 2 + mass * width**2 / 12

    def spring(self, row, k, part):
        self.springs.append((row, k))
        if "c" in part:
            self.dampers.append((row, quantity(part["c"])))
        if "damping_ratio" in part:
            self.ratios.append((row, k, number(part["damping_ratio"])))

    def twist(self, ends):
        return {(n, "theta"): s for n, s in zip(ends, (mp.mpf(-1), mp.mpf(1))) if n != "ground"}

    def ends(self, part):
        return part.get("between") or [part["at"], "ground"]

    def build(self):
        for part in self.table("inertia"):
            self.node(part["name"])
        for bearing in self.table("bearing"):
            axes = {axis for key in bearing if key[:2] in ("k_", "c_") for axis in self.axes(key)}
            for name in self.ends(bearing):
                if name != "ground":
                    self.node(name, sorted(axes))
        for part in self.table("inertia"):
            polar, mass, diametral = self.body(part)
            for axis, value in zip(("theta", "x", "y", "z", "rx", "ry"), (polar, mass, mass, mass, diametral, diametral)):
                if (part["name"], axis) in self.index:
                    self.masses.append(({(part["name"], axis): mp.mpf(1)}, value))
            if (part["name"], "rx") in self.index and (part["name"], "ry") in self.index:
                # H = J Ω e_z turned by (rx, ry): Hx = J Ω ry, Hy = −J Ω rx; M = Ḣ + J_d r̈.
                self.gyro.append(((part["name"], "rx"), (part["name"], "ry"), polar, part["name"]))
        for part in self.table("shaft"):
            self.shaft(part)
        for part in self.table("coupling"):
            if "k" in part:
                self.spring(self.twist(self.ends(part)), quantity(part["k"]), part)
            else:
                self.rigid.append(self.twist(self.ends(part)))
        for part in self.table("damper"):
            self.dampers.append((self.twist(self.ends(part)), quantity(part["c"])))
        for part in self.table("belt"):
            one, two = (quantity(d) / 2 for d in part["diameters"])
            a, b = part["between"]
            self.spring({(a, "theta"): one, (b, "theta"): -two}, quantity(part["k"]), part)
        for part in self.table("gear_pair"):
            self.pair(part)
        for part in self.table("worm_pair"):
            lead, alpha, module = quantity(part["lead_angle"]), quantity(part.get("pressure_angle", "20 deg")), quantity(part["module"])
            (a, b), (z1, z2) = part["between"], part["teeth"]
            # Axial force per normal force cos α cos γ at the wheel's pitch radius z₂ m/2; the worm feeds z₁ m/2 per radian.
            arm = module / 2 * mp.cos(alpha) * mp.cos(lead)
            self.spring({(a, "theta"): z1 * arm, (b, "theta"): z2 * arm}, quantity(part["k"]), part)
        for part in self.table("bearing"):
            self.bearing(part)

    def shaft(self, part):
        a, b = part["between"]
        if "k" in part:
            return self.spring(self.twist((a, b)), quantity(part["k"]), part)
        if "length" not in part:
            return self.rigid.append(self.twist((a, b)))
        outer, inner, length = (quantity(part.get(k, 0)) for k in ("diameter", "bore", "length"))
        shear, density = self.material(part)
        area = mp.pi * (outer**4 - inner**4) / 32
        n = part.get("segments", 1)
        names = [a] + [f"{part['name']}.{i}" for i in range(1, n)] + [b]
        for name in names[1:-1]:
            self.node(name)
        piece = length / n
        for one, two in zip(names, names[1:]):
            self.spring(self.twist((one, two)), shear * area / piece, part)
            inertia = density * area * piece
            if part.get("mass") == "lumped":
                for name in (one, two):
                    self.masses.append(({(name, "theta"): mp.mpf(1)}, inertia / 2))
            assert part.get("mass", "none") in ("none", "lumped")

    def pair(self, part):
        """The tooth normal at the pitch point, from two turns of the pitch-plane normal's frame; δ = n·(u₁ − u₂)."""
        (a, b), (z1, z2) = part["between"], part["teeth"]
        alpha = quantity(part.get("pressure_angle", "20 deg"))
        internal = part.get("internal", False)
        if "module" not in part:
            return self.rigid.append({(a, "theta"): mp.mpf(z1), (b, "theta"): mp.mpf(-z2 if internal else z2)})
        module, helix = quantity(part["module"]), quantity(part.get("helix_angle", 0))
        lateral = any((n, x) in self.index for n in (a, b) for x in ("x", "y", "z", "rx", "ry"))
        if not lateral:
            # Whatever the spiral angle: the transverse pitch radius z m/(2 cos β), times cos β cos α.
            arm = module / 2 * mp.cos(alpha)
            return self.spring({(a, "theta"): z1 * arm, (b, "theta"): (-z2 if internal else z2) * arm}, quantity(part["k"]), part)
        assert not internal and part.get("mesh_angles", ["0 deg", "180 deg"]) == ["0 deg", "180 deg"]
        # x from gear 1 to gear 2; a left-hand helix on gear 1 climbs against the turning sense as z grows.
        hand = -1 if part.get("hand", "right") == "right" else 1
        r1, r2 = (z * module / (2 * mp.cos(helix)) for z in (z1, z2))
        # Normal of the pitch-plane trace in (y, z), then raised by the pressure angle towards gear 2 (x).
        normal = (mp.sin(alpha), mp.cos(alpha) * mp.cos(helix), hand * mp.cos(alpha) * mp.sin(helix))
        # Both bodies in one global frame: a displacement d and a turn ω move the pitch point by d + ω × ρ.
        row = {}
        for name, sign, arm in ((a, 1, (r1, 0, 0)), (b, -1, (-r2, 0, 0))):
            moment = (arm[1] * normal[2] - arm[2] * normal[1], arm[2] * normal[0] - arm[0] * normal[2], arm[0] * normal[1] - arm[1] * normal[0])
            for axis, value in zip(("x", "y", "z", "rx", "ry", "theta"), (*normal, *moment)):
                if (name, axis) in self.index:
                    row[(name, axis)] = sign * value
        self.spring(row, quantity(part["k"]), part)

    @staticmethod
    def axes(key):
        words = key[2:].split("_")
        out = []
        for word in words:
            out += {"radial": ["x", "y"], "tilt": ["rx", "ry"]}.get(word, [word])
        return out

    def bearing(self, part):
        for key, value in part.items():
            if key[:2] not in ("k_", "c_"):
                continue
            axes, value = self.axes(key), quantity(value)
            cross = len(axes) == 2 and key[2:] not in ("radial", "tilt")
            for row, column in [axes] if cross else [(x, x) for x in axes]:
                names = [(n, s) for n, s in zip(self.ends(part), (1, -1)) if n != "ground"]
                to = self.cross_k if key[0] == "k" else self.cross_c
                to.append(({(n, row): s for n, s in names}, {(n, column): s for n, s in names}, value))

    def matrices(self, speeds=None):
        """M, C + G, K over the freedoms that rigid joints leave, and how each freedom follows from them."""
        n = len(self.dofs)
        transform = self.null_space()
        m, c, k = (mp.zeros(n) for _ in range(3))

        def add(a, left, right, value):
            for i, x in left.items():
                for j, y in right.items():
                    a[self.index[i], self.index[j]] += value * x * y

        for row, value in self.masses:
            add(m, row, row, value)
        for row, value in self.springs:
            add(k, row, row, value)
        for row, value in self.dampers:
            add(c, row, row, value)
        for left, right, value in self.cross_k:
            add(k, left, right, value)
        for left, right, value in self.cross_c:
            add(c, left, right, value)
        mass = transform.T * m * transform
        for row, stiffness, zeta in self.ratios:
            w = mp.zeros(n, 1)
            for i, x in row.items():
                w[self.index[i]] = x
            w = transform.T * w
            mobility = mp.fsum(w[j] ** 2 / mass[j, j] for j in range(mass.rows) if w[j] != 0)
            add(c, row, row, 2 * zeta * mp.sqrt(stiffness / mobility))
        for rx, ry, polar, name in self.gyro if speeds else ():
            value = polar * speeds[name]
            i, j = self.index[rx], self.index[ry]
            c[i, j] += value
            c[j, i] -= value
        return tuple(transform.T * a * transform for a in (m, c, k))

    def null_space(self):
        """Two-ended rigid joints only: the later of two freedoms follows the earlier."""
        n = len(self.dofs)
        rows = [mp.matrix([[1 if i == j else 0 for j in range(n)]]) for i in range(n)]
        for joint in self.rigid:
            (p, a), (q, b) = [(self.index[i], x) for i, x in joint.items()]
            value = a * rows[p] + b * rows[q]
            j = max(i for i in range(n) if value[i] != 0)
            value /= value[j]
            rows = [r - r[j] * value for r in rows]
        free = [j for j in range(n) if any(r[j] != 0 for r in rows)]
        return mp.matrix([[r[j] for j in free] for r in rows])


def undamped(m, k):
    """ω of M (diagonal up to rigid joints) and K, rad/s, ascending; massless coordinates condensed."""
    n = m.rows
    light = [i for i in range(n) if m[i, i] == 0]
    heavy = [i for i in range(n) if m[i, i] != 0]
    cut = lambda a, r, c: mp.matrix([[a[i, j] for j in c] for i in r])
    if light:
        k = cut(k, heavy, heavy) - cut(k, heavy, light) * mp.lu_solve(cut(k, light, light), cut(k, light, heavy))
        m = cut(m, heavy, heavy)
    inverse = mp.inverse(mp.cholesky(m))
    values = mp.eigsy(inverse * k * inverse.T, eigvals_only=True)
    top = max(abs(v) for v in values)
    return [mp.sqrt(v) if v > top * mp.mpf(10) ** (-mp.mp.dps * 3 // 4) else mp.mpf(0) for v in sorted(values)]


def complex_roots(m, c, k):
    """Roots of det(λ²M + λC + K), every mass positive; those of rigid motions exactly zero."""
    n = m.rows
    inverse = mp.inverse(m)
    a = mp.zeros(2 * n)
    a[:n, n:] = mp.eye(n)
    a[n:, :n] = -inverse * k
    a[n:, n:] = -inverse * c
    values = mp.eig(a, left=False, right=False)
    top = max(abs(v) for v in values)
    tiny = top * mp.mpf(10) ** (-mp.mp.dps // 3)
    values = [mp.mpc(0) if abs(v) < tiny else v for v in values]
    values = [mp.mpc(v.real) if abs(v.imag) < tiny * mp.mpf(10) ** -2 else v for v in values]
    return sorted(values, key=lambda v: (abs(v), v.imag))
