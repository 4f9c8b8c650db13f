"""Charts of one simulated gear for data/index_gear*.csv: run from the project's folder with Python and numpy.

z 40, m 3 mm, 20 deg, spur. Every flank is its ideal involute plus: teeth eccentric by E at THETA, seen at each point of contact along
its own normal; a random walk of the dividing head; a profile slope, a form wave and the designed tip relief; readings with noise.
The single-flank record is the largest surplus of the teeth in contact, computed here from the flanks themselves and not from the
charts."""

import numpy as np

Z, M, ALPHA = 40, 3.0, np.radians(20)
D = Z * M
RB = 0.5 * D * np.cos(ALPHA)
PB = 2 * np.pi * RB / Z
E, THETA = 6.0, np.radians(130)  # µm
ACTIVE = (12.6, 28.1)  # mm of roll: with a mate of 60 teeth
S0 = RB * np.tan(ALPHA)
rng = np.random.default_rng(1979)

# The dividing head: places of the flanks on the reference circle, µm, the same for both sides but for a little.
walk = np.cumsum(rng.normal(0, 1.1, Z))
walk -= np.linspace(walk[0], walk[-1] + (walk[0] - walk[-1]) / Z, Z)
walk -= walk.mean()
cut = {"left": walk + rng.normal(0, 0.4, Z), "right": walk + rng.normal(0, 0.4, Z)}
SIGN = {"left": -1.0, "right": 1.0}
THIN = 45.0  # µm, half of what the teeth are thinner than nominal


def flank_angle(side, i):
    """Polar angle of flank i, clockwise: space i lies between right flank i and left flank i."""
    return 2 * np.pi * i / Z - SIGN[side] * np.pi / (2 * Z)


def eccentric(side, i, s):
    """Surplus along the normal at roll s, µm."""
    sign = SIGN[side]
    normal = flank_angle(side, i) + sign * (np.pi / 2 - ALPHA) - sign * (s - S0) / RB
    return E * np.cos(normal - THETA)


def profile(s):
    """The tool's profile, the same on all teeth, µm."""
    slope = 3.0 * (s - 20.35) / 15.5
    form = 0.8 * np.sin(2 * np.pi * (s - 12.6) / 6.0)
    relief = -6.0 * np.clip((s - 25.0) / 3.1, 0, 1)
    return slope + form + relief


def surplus(side, i, s):
    return SIGN[side] * cut[side][i % Z] * np.cos(ALPHA) + eccentric(side, i % Z, s) + profile(s)


def place(side, i):
    """Place of flank i on the reference circle, clockwise, µm: its surplus there without the profile's own height."""
    return SIGN[side] * (surplus(side, i, S0) - profile(S0)) / np.cos(ALPHA)


def write(name, header, columns, decimals):
    with open(f"data/index_gear_{name}.csv", "w", encoding="utf-8") as out:
        out.write(",".join(header) + "\n")
        for row in zip(*columns):
            out.write(",".join(f"{x:.{d}f}" for x, d in zip(row, decimals)) + "\n")


teeth = np.arange(Z)
places = {side: np.array([place(side, i) for i in teeth]) for side in cut}
noisy = {side: places[side] - places[side][0] + rng.normal(0, 0.3, Z) for side in cut}
ball = np.array([E * np.cos(2 * np.pi * i / Z - THETA) for i in teeth])
ball -= (cut["left"] - cut["right"]) / (2 * np.tan(ALPHA))
write(
    "pitch",
    ["tooth", "left [µm]", "right [µm]", "ball [µm]"],
    [teeth + 1, noisy["left"], noisy["right"], ball + rng.normal(0, 0.5, Z)],
    [0, 2, 2, 2],
)

roll = np.arange(11.6, 28.1001, 0.1)
header, columns = ["roll [mm]"], [roll]
for side in cut:
    for i in (0, 10, 20, 30):
        trace = np.array([surplus(side, i, s) - SIGN[side] * cut[side][i] * np.cos(ALPHA) for s in roll])
        header.append(f"{side}_{i + 1} [µm]")
        columns.append(trace - trace[0] + rng.normal(0, 0.1, len(roll)))
write("profile", header, columns, [2] + [2] * 8)

face = np.arange(0, 30.001, 0.25)
header, columns = ["face [mm]"], [face]
for side, slope in (("left", 3.5), ("right", -1.5)):
    for i in (0, 10, 20, 30):
        wobble = 1.0 * np.cos(2 * np.pi * i / Z)
        trace = (slope + wobble) * (face - 15) / 30 - 4.0 * ((face - 15) / 15) ** 2
        trace += 0.5 * np.sin(2 * np.pi * face / 7)
        header.append(f"{side}_{i + 1} [µm]")
        columns.append(trace + rng.normal(0, 0.15, len(face)))
write("helix", header, columns, [2] + [2] * 8)

k = 5
inv = np.tan(ALPHA) - ALPHA
nominal = M * np.cos(ALPHA) * ((k - 0.5) * np.pi + Z * inv)
spans = []
for i in range(0, Z, 5):
    thin = -2 * THIN + (cut["right"][(i + k) % Z] - cut["left"][i])
    spans.append(nominal + 1e-3 * thin * np.cos(ALPHA) + rng.normal(0, 0.001))
write("span", ["span [mm]"], [spans], [4])

PER_PITCH = 60
record = []
for n in range(Z * PER_PITCH):
    turned = n / PER_PITCH
    touching = [j for j in range(int(turned) - 2, int(turned) + 1) if 0 <= (turned - j) * PB <= ACTIVE[1] - ACTIVE[0] + 1e-9]
    record.append(max(surplus("left", j % Z, ACTIVE[0] + (turned - j) * PB) for j in touching))
record = np.array(record)
exact = record.copy()
record = record - record.mean() + rng.normal(0, 0.1, len(record))
write("single", ["left [arcsec]"], [record / RB * 206.26480625], [3])

both = []
for n in range(Z * PER_PITCH):
    turned = n / PER_PITCH
    near = [j for j in range(int(turned) - 2, int(turned) + 1) if 0 <= (turned - j) * PB <= ACTIVE[1] - ACTIVE[0] + 1e-9]
    # Left flanks roll from root to tip while right ones roll from tip to root.
    left = max(surplus("left", j % Z, ACTIVE[0] + (turned - j) * PB) for j in near)
    right = max(surplus("right", j % Z, ACTIVE[1] - (turned - j) * PB) for j in near)
    both.append((left + right) / (2 * np.sin(ALPHA)))
both = np.array(both)
write("double", ["centre [µm]"], [both - both.mean() + rng.normal(0, 0.2, len(both))], [2])

if __name__ == "__main__":
    f = {side: np.roll(places[side], -1) - places[side] for side in cut}
    for side in cut:
        print(side, "fp", np.abs(f[side]).max(), "Fp", np.ptp(places[side]))
    arc = exact / np.cos(ALPHA)
    short = np.array([np.ptp(np.append(arc, arc[:PER_PITCH])[i : i + PER_PITCH + 1]) for i in range(len(arc))])
    print("Fr by ball", np.ptp(ball), "Fi'", np.ptp(arc), "fi'", short.max())
    print("span", nominal, [f"{x:.4f}" for x in spans])
