#!/usr/bin/env python3
"""Writes data/reference/turning_stage.json: a planetary stage that turns, in the inertial frame, not linear.

Independent of geardyn: every body is a point with an angle in the inertial plane; its energy is written once and differentiated
by sympy. Nothing is said of frames, centripetal or Coriolis terms.

  bearings   1/2 k |P_n - A_n|^2, A_n = C + r_c (cos, sin)(theta_c + psi_n): the pin on the carrier
  sun mesh   delta = r_s theta_s + r_p theta_p - r_c cos(alpha) (phi + inv a), cos a = r_c cos(alpha) / |P - S|
  ring mesh  delta = r_r theta_r - r_p theta_p - r_c cos(alpha) (phi - inv a), the same with P - R
  supports   1/2 k |S|^2, 1/2 k |R|^2, 1/2 k |C|^2, 1/2 k_t theta_r^2

phi is the angle of the line of centres, inv a = tan a - a the involute (Litvin & Fuentes, Gear Geometry and Applied Theory, 2nd ed.
2004, sec. 10.2): the force acts along the common tangent of the base circles, wherever the centres are. The data are those of
models/lin_parker_n3.toml (Lin & Parker, J. Vib. Acoust. 121 (1999) 316).

1. `held_speed`: started in its steady turn, DOP853 at 1e-11 follows it for 0.1 s; the largest departure of the carrier's speed, relative.
   `held_speed_from_pins`: the same with planets at the pins' radius and at rest there, from where they stretch their bearings and swing.
2. `roots`: the equations in the turning frame, linearised about the steady turn that the equations themselves have (Newton), as
   eigenvalues: zero twice for the turn. Centrifugal stretch and everything of higher order are in them.
3. `without_supports`: the same without any support, where sun and ring float against the planets and depart: the root of the linearised
   equations. `followed_per_s`: with all stiffnesses a hundredth (so that it ends in a minute) the stage is started 1e-7 m off along that mode
   and followed for 0.06 s in the inertial frame; growth and frequency of its share of the mode, and `softer_per_s` the root it should have.

Run: python3 tools/reference_turning_stage.py > data/reference/turning_stage.json
"""
import json
import sys

import numpy as np
import scipy
import scipy.integrate
import scipy.linalg
import sympy as sp

RS, RP, RR, RC = 0.0387, 0.05015, 0.1375, 0.0884
ALPHA = np.deg2rad(24.6)
JS, JR, JC, JP = 0.0005840991, 0.05671875, 0.0491535824, 0.001534163725
MS, MR, MC, MP = 0.4, 2.35, 5.43, 0.66
KM, KB, KX, KT = 5e8, 1e8, 1e8, 18906250.0
PSI = [2 * np.pi * n / 3 for n in range(3)]
RPM = 1000.0

# q: sun x y t, ring x y t, carrier x y t, planets x y t
NAMES = [f"{b}.{a}" for b in ("sun", "ring", "carrier", "p1", "p2", "p3") for a in ("x", "y", "t")]
MASS = np.array([MS, MS, JS, MR, MR, JR, MC, MC, JC] + [MP, MP, JP] * 3)


def energy(q, supported):
    """Elastic energy over absolute positions; planets about the axis, angles absolute."""
    sx, sy, st, rx, ry, rt, cx, cy, ct = q[:9]
    e = 0
    for n, psi in enumerate(PSI):
        x, y, t = q[9 + 3 * n: 12 + 3 * n]
        ax, ay = cx + RC * sp.cos(ct + psi), cy + RC * sp.sin(ct + psi)
        e += KB * ((x - ax) ** 2 + (y - ay) ** 2) / 2
        big = RC * np.cos(ALPHA)
        inv0 = np.tan(ALPHA) - ALPHA
        for (mx, my), own, sign, side in (((sx, sy), RS * st + RP * t, 1, 0), ((rx, ry), RR * rt - RP * t, -1, 1)):
            u, v = x - mx, y - my
            a = sp.sqrt(u * u + v * v)
            # angle of the line of centres, measured from the carrier's so that it has no branch
            c, s = sp.cos(ct + psi), sp.sin(ct + psi)
            phi = ct + sp.atan2(v * c - u * s, u * c + v * s)
            press = sp.acos(big / a)
            delta = own - big * (phi + sign * (sp.tan(press) - press - inv0))
            e += KM * delta ** 2 / 2
    if supported:
        e += KX * (sx ** 2 + sy ** 2 + rx ** 2 + ry ** 2 + cx ** 2 + cy ** 2) / 2 + KT * rt ** 2 / 2
    return e


def functions(supported):
    q = sp.symbols("q0:18", real=True)
    e = energy(q, supported)
    grad = [sp.diff(e, x) for x in q]
    hess = [[sp.diff(g, x) for x in q] for g in grad]
    force = sp.lambdify([q], grad, "numpy", cse=True)
    stiff = sp.lambdify([q], hess, "numpy", cse=True)
    return (lambda z: np.array(force(z), float)), (lambda z: np.array(stiff(z), float))


def speeds(supported, omega):
    """Angular speeds of the steady turn: ring at rest where its support holds it, else turning as one whole."""
    big = RC * np.cos(ALPHA)
    ring = 0.0
    planet = (RR * ring - big * omega) / RP
    sun = (big * omega - RP * planet) / RS
    return sun, ring, omega, planet


def steady(force, stiff, omega):
    """Positions that turn with the carrier: grad U = centripetal m Omega^2 P on planets, at theta = 0 (Newton, least norm)."""
    q = np.zeros(18)
    for n, psi in enumerate(PSI):
        q[9 + 3 * n: 11 + 3 * n] = RC * np.cos(psi), RC * np.sin(psi)
    pull = np.zeros(18)
    for i in range(0, 18, 3):
        pull[i] = pull[i + 1] = MASS[i] * omega ** 2
    for _ in range(20):
        r = force(q) - pull * q
        q = q - np.linalg.lstsq(stiff(q) - np.diag(pull), r, rcond=1e-13)[0]
    return q, np.abs(force(q) - pull * q).max()


def roots(stiff, q, omega):
    """lambda of the equations in the frame that turns at Omega: M r'' + 2 Omega M S r' + (H - Omega^2 M_xy) r = 0.

    U does not change when everything turns, angles at the mesh by their own ratios; so its Hessian in the turned frame is constant.
    """
    h = stiff(q)
    g = np.zeros((18, 18))
    for i in range(0, 18, 3):
        g[i, i + 1], g[i + 1, i] = -2 * MASS[i] * omega, 2 * MASS[i] * omega
        h[i, i] -= MASS[i] * omega ** 2
        h[i + 1, i + 1] -= MASS[i] * omega ** 2
    m = np.sqrt(MASS)
    h, g = h / np.outer(m, m), g / np.outer(m, m)
    return np.block([[np.zeros((18, 18)), np.eye(18)], [-h, -g]])


def departing(force, stiff, omega):
    """The root with the largest real part, its mode and its left vector, in the turning frame."""
    q, _ = steady(force, stiff, omega)
    lam, left, right = scipy.linalg.eig(roots(stiff, q, omega), left=True)
    at = np.argmax(lam.real + 1e-9 * lam.imag)
    return q, lam[at], left[:, at], right[:, at]


def followed(force, stiff, omega, until):
    """Growth and frequency of the departing mode, followed in time."""
    q, lam, left, right = departing(force, stiff, omega)
    scale = np.sqrt(np.concatenate([MASS, MASS]))
    off = (right / scale).real
    off *= 1e-7 / np.abs(off[:18]).max()
    sun, ring, carrier, planet = speeds(False, omega)
    rates = np.zeros(18)
    rates[2], rates[5], rates[8], rates[11::3] = sun, ring, carrier, planet

    def inertial(r, v, t):
        z, w = r.copy(), v.copy()
        c, s = np.cos(omega * t), np.sin(omega * t)
        for i in range(0, 18, 3):
            (x, y), (u, o) = r[i:i + 2], v[i:i + 2]
            u, o = u - omega * y, o + omega * x
            z[i:i + 2], w[i:i + 2] = (c * x - s * y, s * x + c * y), (c * u - s * o, s * u + c * o)
        return z + rates * t, w + rates

    def turning(z, w, t):
        z, w = z - rates * t, w - rates
        r, v = z.copy(), w.copy()
        c, s = np.cos(omega * t), -np.sin(omega * t)
        for i in range(0, 18, 3):
            (x, y), (u, o) = z[i:i + 2], w[i:i + 2]
            r[i:i + 2] = c * x - s * y, s * x + c * y
            v[i:i + 2] = c * u - s * o + omega * r[i + 1], s * u + c * o - omega * r[i]
        return r, v

    z, w = inertial(q + off[:18], off[18:], 0.0)
    run = scipy.integrate.solve_ivp(
        lambda t, y: np.concatenate([y[18:], -force(y[:18]) / MASS]), (0, until), np.concatenate([z, w]),
        method="DOP853", rtol=1e-11, atol=1e-14, t_eval=[0.0, until])
    share = []
    for k, t in enumerate(run.t):
        r, v = turning(run.y[:18, k], run.y[18:, k], t)
        share.append(left.conj() @ (scale * np.concatenate([r - q, v])))
    grown = share[1] / share[0]
    turns = np.round((lam.imag * until - np.angle(grown)) / (2 * np.pi))
    return [np.log(np.abs(grown)) / until, (np.angle(grown) + 2 * np.pi * turns) / until], [lam.real, abs(lam.imag)]


def held(force, q, omega, rates, until):
    v = np.zeros(18)
    for i in range(0, 18, 3):
        v[i], v[i + 1] = -omega * q[i + 1], omega * q[i]
    v[2], v[5], v[8] = rates[:3]
    v[11::3] = rates[3]
    run = scipy.integrate.solve_ivp(
        lambda t, y: np.concatenate([y[18:], -force(y[:18]) / MASS]), (0, until), np.concatenate([q, v]),
        method="DOP853", rtol=1e-11, atol=1e-13, t_eval=np.linspace(0, until, 401))
    return np.abs(run.y[18 + 8] / omega - 1).max(), run


def main():
    omega = RPM * 2 * np.pi / 60
    force, stiff = functions(True)
    rates = speeds(True, omega)
    start = np.zeros(18)
    for n, psi in enumerate(PSI):
        start[9 + 3 * n: 11 + 3 * n] = RC * np.cos(psi), RC * np.sin(psi)
    from_pins, _ = held(force, start, omega, rates, 0.1)
    q, rest = steady(force, stiff, omega)
    drift, run = held(force, q, omega, rates, 0.1)
    lam = np.linalg.eigvals(roots(stiff, q, omega))
    lam = lam[lam.imag > -1e-6]
    lam = lam[np.argsort(np.abs(lam))]
    stretch = np.hypot(q[9], q[10]) - RC
    force, stiff = functions(False)
    _, floating, _, _ = departing(force, stiff, omega)
    grown, softer = followed(lambda z: 0.01 * force(z), lambda z: 0.01 * stiff(z), omega, 0.06)
    out = {
        "made_by": f"tools/reference_turning_stage.py, Python {sys.version.split()[0]}, NumPy {np.__version__}, "
        f"SciPy {scipy.__version__}, SymPy {sp.__version__}",
        "machine": "models/lin_parker_n3.toml, carrier free",
        "rpm": RPM,
        "held_speed": drift,
        "held_speed_from_pins": from_pins,
        "planet_stretch_m": stretch,
        "residual_N": rest,
        "largest_growth_per_s": float(np.abs(lam.real[np.abs(lam) > 10]).max()),
        "zero_roots_abs": [float(x) for x in np.abs(lam[np.abs(lam) < 10])],
        "without_supports": {
            "floating_root_per_s": [floating.real, abs(floating.imag)],
            "followed_per_s": [grown[0], abs(grown[1])],
            "softer_per_s": softer,
        },
        "frequencies_hz": [float(x) for x in lam.imag[np.abs(lam) > 10] / (2 * np.pi)],
    }
    json.dump(out, sys.stdout, indent=1)
    print()


main()
