//! The kernel of meshing in space: screw axes, curvature, helicoids from wheels, canal surface, hobs under two motions.

use std::f64::consts::{PI, TAU};

use geardyn::internals::gear::kernel::envelope::Envelope;
use geardyn::internals::gear::kernel::jet::Surface;
use geardyn::internals::gear::kernel::law::Law;
use geardyn::internals::gear::kernel::motion::Motion;
use geardyn::internals::gear::kernel::pose::Pose;
use geardyn::internals::gear::kernel::second_order::Curvature;
use geardyn::internals::gear::kernel::tool::{Arc, Curve, Tool};
use geardyn::internals::gear::kernel::twist::Twist;
use geardyn::internals::gear::kernel::vector::Vector;

use crate::cases::{case, number, numbers};
use crate::verification::within;

#[derive(Debug, Clone, Copy, PartialEq)]
struct Wheel;
#[derive(Debug, Clone, Copy, PartialEq)]
struct Hob;
#[derive(Debug, Clone, Copy, PartialEq)]
struct Work;

/// Relative difference of two numbers.
fn apart(a: f64, b: f64) -> f64 {
    (a - b).abs() / b.abs()
}

/// The relative screw axis of two bodies that turn about crossed axes.
/// Source: closed form of the screw axis by two routes, data/reference/gear/c46_screw_axis.json.
#[test]
fn ref_screw_axis() {
    let mut worst = 0f64;
    for row in case("c46_screw_axis")["expected"]["rows"]
        .as_array()
        .unwrap()
    {
        let [a, shaft_angle, ratio, r1, r2, pitch, angle, speed] = numbers(row)[..] else {
            panic!("{row}");
        };
        let (sin, cos) = shaft_angle.to_radians().sin_cos();
        let first = Twist::turn(Vector::Z, Vector::ZERO);
        let second = Twist::turn(Vector::new(0.0, sin, cos), a * Vector::X);
        let relative = first.plus(-ratio, &second);
        let axis = relative.screw_axis().unwrap();
        let found = [
            axis.point.x,
            a - axis.point.x,
            axis.pitch,
            f64::atan2(-axis.direction.y, axis.direction.z).to_degrees(),
            relative.w.norm(),
        ];
        for (found, expected) in found.iter().zip([r1, r2, pitch, angle, speed]) {
            worst = worst.max((found - expected).abs());
        }
        // The velocity of a point of the axis lies along it.
        let along = relative.at(axis.point + 7.0 * axis.direction);
        worst = worst.max(along.cross(axis.direction).norm());
    }
    within("axis, throats and pitch", worst, 1e-12);
}

/// Curvature of the envelope of a torus in a general motion of varying ratio.
/// Source: 60-digit second differences of the envelope, data/reference/gear/c51_induced_curvature_torus.json.
#[test]
fn ref_induced_curvature_of_a_torus() {
    let case = case("c51_induced_curvature_torus");
    let expected = &case["expected"];
    let arc = Arc::about(
        Vector::new(112.0, 7.0, 3.0),
        30.0,
        [Vector::X, Vector::Z],
        [0.0, TAU],
    );
    // The case's normal is r_u × r_v; its tube is parametrised as this arc.
    let torus = Tool::<_, Wheel>::new(arc, Twist::turn(Vector::Z, Vector::new(12.0, 7.0, 3.0)));
    let polynomial = |c1, c2, c3| Law::Polynomial([0.0, c1, c2, c3, 0.0, 0.0]);
    let motion = Motion::<Wheel, Wheel>::identity()
        .joint(
            Twist::turn(Vector::Z, Vector::ZERO),
            polynomial(1.0, 0.02, 0.0),
        )
        .then(Pose::<Wheel, Wheel>::shifted(Vector::new(
            35.0, -12.0, 20.0,
        )))
        .then(Pose::<Work, Wheel>::turned(Vector::X, 1.1))
        .joint(Twist::slide(Vector::Z), polynomial(3.0, 0.0, 0.0))
        .joint(
            Twist::turn(Vector::Z, Vector::ZERO),
            polynomial(-1.7, -0.11, -0.05),
        );
    let u = 30.0 * number(&expected["u"]);
    let (v, q) = (0.7, 0.2);
    let envelope = Envelope {
        surface: torus,
        motion,
        range: [0.0, 1.0],
    };
    let meeting = envelope.meeting([u, v, q]).unwrap();
    within(
        "equation of meshing",
        meeting.f.abs() / meeting.velocity.norm(),
        1e-14,
    );
    let point = envelope.point([u, v, q]).unwrap();
    let second = point.second_order;
    let work = second.envelope().unwrap();
    for (name, found) in [("W_tool", second.tool), ("W_work", work)] {
        let rows = expected[name].as_array().unwrap();
        let [w11, w12] = numbers(&rows[0])[..] else {
            panic!()
        };
        let w22 = numbers(&rows[1])[1];
        let size = w11.abs().max(w22.abs());
        let error = found
            .components
            .iter()
            .zip([w11, w12, w22])
            .map(|(a, b)| (a - b).abs());
        within(name, error.fold(0.0, f64::max) / size, 1e-12);
    }
    let [over_tool, over_work] = second.contact_line_speeds().unwrap();
    for (name, found) in [
        ("p_norm", f64::hypot(second.p[0], second.p[1])),
        ("D", second.undercut),
        ("Phi", second.second_limit),
        ("contact_line_speed_over_tool", over_tool),
        ("contact_line_speed_over_work", over_work),
    ] {
        within(name, apart(found, number(&expected[name])), 1e-12);
    }
    // The curvature of the envelope's own jet, which knows nothing of p and D.
    let own = Curvature::of(&meeting.envelope_jet().unwrap()).unwrap();
    for ((a, b), e) in own
        .principal()
        .iter()
        .zip(work.principal())
        .zip(["first", "second"])
    {
        within(
            &format!("{e} principal curvature of the envelope's jet"),
            apart(a.0, b.0),
            1e-11,
        );
    }
    // Geodesic torsion of the envelope's jet against (p·e)(p·e⊥)/D.
    let [e1, e2] = second.tool.tangents;
    let (sin, cos) = 0.5f64.sin_cos();
    let induced = own.torsion(e1 * cos + e2 * sin) - second.tool.torsion(e1 * cos + e2 * sin);
    let [p1, p2] = second.p;
    let torsion = (p1 * cos + p2 * sin) * (p2 * cos - p1 * sin) / second.undercut;
    within("induced geodesic torsion", apart(induced, torsion), 1e-11);
    // Baxter's reading: induced curvature across the contact line is |p| over its speed on the work.
    let across = point
        .normal
        .components
        .cross(second.contact_line().unwrap());
    let induced = work.normal(across) - second.tool.normal(across);
    within(
        "induced curvature by the contact line's speed",
        apart(f64::hypot(second.p[0], second.p[1]) / over_work, induced),
        1e-12,
    );
}

/// A plane wheel in a screw motion makes the involute helicoid of base radius p/tan γ_b: azimuth, and Gauss curvature 0.
#[test]
fn exact_plane_wheel_to_involute_helicoid() {
    let (pitch, gamma_b) = (6.0, 0.4f64);
    let base = pitch / gamma_b.tan();
    let (sin, cos) = gamma_b.sin_cos();
    let normal = Vector::new(0.0, -sin, cos);
    // A disk in the plane through the origin, its centre 80 away: a line across its axis, turned about it.
    let centre = Vector::new(80.0, 0.0, 0.0);
    let line = Arc::straight(centre, -Vector::X, [0.0, 79.0]);
    let wheel = Tool::<_, Wheel>::new(line, Twist::turn(normal, centre));
    let motion = Motion::fixed(Pose::<Work, Wheel>::shifted(Vector::ZERO)).joint(
        Twist::screw(Vector::Z, Vector::ZERO, pitch),
        Law::linear(-1.0),
    );
    let envelope = Envelope {
        surface: wheel,
        motion,
        range: [-1.0, 1.0],
    };
    let (mut azimuths, mut gauss, mut count) = (0f64, 0f64, 0);
    for x in [-0.7, 0.0, 0.3] {
        for i in -8..=8 {
            let Some(point) = envelope.flank([x, 0.04 * f64::from(i)]) else {
                continue;
            };
            let r = point.point.coordinates;
            let rho = f64::hypot(r.x, r.y);
            let along = ((rho - base) * (rho + base)).sqrt();
            // The generator touches the base helix at this azimuth; it lies either way of the tangent point.
            let residual = [1.0, -1.0].map(|side| {
                let touches = r.y.atan2(r.x) - side * (along / base).atan();
                (pitch * touches + side * along * gamma_b.tan() - r.z).abs() / pitch
            });
            azimuths = azimuths.max(residual[0].min(residual[1]));
            // The generator touches the base helix at β = 0: the edge of regression.
            let Some(work) = point.second_order.envelope() else {
                continue;
            };
            gauss = gauss.max(work.gaussian().abs() * rho * rho);
            count += 1;
        }
    }
    assert!(count > 30, "{count}");
    within("azimuth of the helicoid", azimuths, 1e-14);
    within("Gauss curvature × radius²", gauss, 1e-12);
}

/// A ball whose centre runs along a helix envelopes a canal surface: points at the ball's radius from the helix, one curvature 1/r, the
/// other κ cos/(1 − r κ cos) with the helix' curvature κ.
#[test]
fn exact_ball_to_canal_surface() {
    let (helix, pitch, ball) = (20.0, 5.0, 3.0);
    let centre = helix * Vector::X;
    let arc = Arc::about(centre, ball, [Vector::X, Vector::Z], [-1.5, 1.5]);
    let motion = Motion::fixed(Pose::<Work, Wheel>::shifted(Vector::ZERO)).joint(
        Twist::screw(Vector::Z, Vector::ZERO, pitch),
        Law::linear(1.0),
    );
    let tool = Tool::new(arc, Twist::turn(Vector::Z, centre));
    let envelope = Envelope {
        surface: tool,
        motion,
        range: [-1.0, 1.0],
    };
    let curvature = helix / (helix * helix + pitch * pitch);
    let (mut places, mut curvatures, mut count) = (0f64, 0f64, 0);
    for x in [-0.5, 0.2] {
        for i in -20..=20 {
            let Some(point) = envelope.flank([x, 0.07 * f64::from(i)]) else {
                continue;
            };
            let on_helix = Vector::new(helix * f64::cos(x), helix * f64::sin(x), pitch * x);
            let tangent = Vector::new(-helix * f64::sin(x), helix * f64::cos(x), pitch);
            let spoke = point.point.coordinates - on_helix;
            places = places.max((spoke.norm() - ball).abs());
            places = places.max((spoke.dot(tangent) / tangent.norm()).abs());
            let inward = -Vector::new(f64::cos(x), f64::sin(x), 0.0);
            let cos = spoke.dot(inward) / ball;
            let mut expected = [
                -1.0 / ball,
                curvature * cos / (1.0 - ball * curvature * cos),
            ];
            // The tool's normal points out of the ball: dn = dr/r.
            let side = point.normal.components.dot(spoke).signum();
            expected = expected.map(|k| k * side);
            expected.sort_by(f64::total_cmp);
            let work = point.second_order.envelope().unwrap();
            for (found, expected) in work.principal().iter().zip(expected) {
                curvatures = curvatures.max((found.0 - expected).abs());
            }
            count += 1;
        }
    }
    assert!(count > 30, "{count}");
    within("place", places, 1e-13);
    within("curvatures", curvatures, 1e-14);
}

/// Value of the extremum of `f` in an interval by golden section: it needs no derivative and no normal.
fn extremum(mut interval: [f64; 2], f: impl Fn(f64) -> f64) -> f64 {
    let shrink = 0.5 * (5f64.sqrt() - 1.0);
    let middle = 0.5 * (interval[0] + interval[1]);
    let sign = (f(interval[0]) + f(interval[1]) - 2.0 * f(middle)).signum();
    for _ in 0..90 {
        let [a, b] = interval;
        let (c, d) = (b - shrink * (b - a), a + shrink * (b - a));
        interval = if sign * f(c) < sign * f(d) {
            [a, d]
        } else {
            [c, b]
        };
    }
    f(0.5 * (interval[0] + interval[1]))
}

/// Axial section g(ρ) of the helicoid a wheel leaves, against the extremum of `z − pχ` over the wheel's points at the same radius.
fn axial_section_error<C: Curve>(profile: C, shift: f64, tilt: f64, pitch: f64) -> f64 {
    let axis = Vector::new(0.0, -tilt.sin(), tilt.cos());
    let wheel = Tool::<_, Wheel>::new(profile, Twist::turn(axis, shift * Vector::X));
    let motion = Motion::fixed(Pose::<Work, Wheel>::shifted(Vector::ZERO)).joint(
        Twist::screw(Vector::Z, Vector::ZERO, pitch),
        Law::linear(1.0),
    );
    let [from, to] = wheel.range();
    let envelope = Envelope {
        surface: wheel,
        motion,
        range: [-1.0, 1.0],
    };
    let section = |r: Vector| (f64::hypot(r.x, r.y), r.z - pitch * r.y.atan2(r.x));
    let (mut worst, mut count) = (0f64, 0);
    for i in -10..=10 {
        let beta = 0.003 * f64::from(i);
        let Some(point) = envelope.flank([0.0, beta]) else {
            continue;
        };
        let (radius, g) = section(point.point.coordinates);
        let place = |u: f64, beta: f64| envelope.surface.jet([u, beta]).unwrap().r;
        let at_radius = |beta: f64| {
            let (mut a, mut b) = (from, to);
            let grows = section(place(b, beta)).0 > section(place(a, beta)).0;
            for _ in 0..60 {
                let u = 0.5 * (a + b);
                if (section(place(u, beta)).0 < radius) == grows {
                    a = u
                } else {
                    b = u
                }
            }
            section(place(0.5 * (a + b), beta)).1
        };
        worst = worst.max((extremum([beta - 0.02, beta + 0.02], at_radius) - g).abs());
        count += 1;
    }
    assert!(count > 5, "{count}");
    worst
}

/// Cone and torus wheels leave helicoids whose axial sections are those of an extremum without normals.
#[test]
fn exact_wheel_to_helicoid() {
    let (m, starts, q) = (4.0, 2.0, 10f64);
    let (pitch, radius) = (0.5 * m * starts, 0.5 * m * q);
    let (tilt, tool_radius) = ((starts / q).atan(), 100.0);
    let shift = tool_radius + radius;
    let axis = Vector::new(0.0, -tilt.sin(), tilt.cos());
    let alpha = 20f64.to_radians();
    let mean = tool_radius * -Vector::X + shift * Vector::X;
    let direction = -Vector::X * alpha.cos() - axis * alpha.sin();
    let cone = Arc::straight(mean, direction, [-5.0, 6.0]);
    within(
        "cone wheel, mm",
        axial_section_error(cone, shift, tilt, pitch),
        1e-13,
    );
    let rho = 40.0;
    let outward = axis * alpha.cos() - Vector::X * alpha.sin();
    let torus = Arc::about(
        mean - outward * rho,
        rho,
        [outward, direction],
        [-0.12, 0.14],
    );
    within(
        "torus wheel, mm",
        axial_section_error(torus, shift, tilt, pitch),
        1e-12,
    );
}

/// A hob as a line swept by its own screw: the flank of a thread that falls outwards, through `z = quarter` on the reference cylinder.
fn hob_flank(
    involute: bool,
    radius: f64,
    pitch: f64,
    alpha_n: f64,
    quarter: f64,
) -> Tool<Arc, Hob> {
    let gamma = (pitch / radius).atan();
    let screw = Twist::screw(Vector::Z, Vector::ZERO, pitch);
    let line = if involute {
        let gamma_b = (gamma.cos() * alpha_n.cos()).acos();
        let base = pitch / gamma_b.tan();
        let along = ((radius - base) * (radius + base)).sqrt();
        // Generator from the base cylinder, falling outwards; at the reference cylinder it has z = quarter at azimuth 0.
        let azimuth = -(-along).atan2(base);
        let (sin, cos) = azimuth.sin_cos();
        let touch = Vector::new(base * cos, base * sin, quarter + along * gamma_b.tan());
        let tangent = Vector::new(sin, -cos, -gamma_b.tan());
        Arc::straight(touch, tangent, [0.0, 60.0])
    } else {
        let slope = alpha_n.tan() / gamma.cos();
        Arc::straight(
            Vector::new(0.0, 0.0, quarter + radius * slope),
            Vector::new(1.0, 0.0, -slope),
            [0.0, 60.0],
        )
    };
    Tool::new(line, screw)
}

/// Hobbing as one surface under two motions, roll and feed: hob and gear points of an involute and of an Archimedean hob.
/// Source: closed form and two-variable extremum, data/reference/gear/c47_hobbing_zi_za.json.
#[test]
fn ref_hobbing_under_two_motions() {
    let case = case("c47_hobbing_zi_za");
    let expected = &case["expected"];
    let get = |name: &str| number(&expected[name]);
    let (p1, p2, a) = (get("hob_p1"), get("gear_p2"), get("centre_distance"));
    let (shaft, ratio) = (get("axis_angle_S_deg").to_radians(), get("ratio_i"));
    for (name, involute) in [("ZI", true), ("ZA", false)] {
        let hob = hob_flank(involute, 40.0, p1, 20f64.to_radians(), 0.25 * PI * p1);
        // The gear's axis is its z, its x points away from the hob.
        let to_gear = Pose::<Work, Hob>::turned(Vector::X, shaft);
        let motion = Motion::<Hob, Hob>::identity()
            .joint(Twist::turn(Vector::Z, Vector::ZERO), Law::linear(1.0))
            .then(Pose::<Hob, Hob>::shifted(-a * Vector::X))
            .then(to_gear)
            .joint(Twist::turn(Vector::Z, Vector::ZERO), Law::linear(-ratio));
        let envelope = Envelope {
            surface: hob,
            motion,
            range: [-4.0, 4.0],
        };
        let feed = Twist::screw(Vector::Z, Vector::ZERO, p2);
        let (mut lengths, mut angles, mut bases) = (0f64, 0f64, 0f64);
        for row in expected["points"][name].as_array().unwrap() {
            let row = numbers(row);
            let [rho, psi, z, phi, radius, azimuth] = row[..6] else {
                panic!()
            };
            let phi = phi.to_radians();
            let start_u = if involute { 38.0 } else { 40.0 };
            let [u, theta] = envelope
                .two_motion_point(phi, &feed, [start_u, -phi])
                .unwrap();
            let in_hob = envelope.surface.jet([u, theta]).unwrap().r;
            let found_psi = (in_hob.y.atan2(in_hob.x) + phi).to_degrees();
            lengths = lengths.max((f64::hypot(in_hob.x, in_hob.y) - rho).abs());
            lengths = lengths.max((in_hob.z - z).abs());
            angles = angles.max(((found_psi - psi + 180.0).rem_euclid(360.0) - 180.0).abs());
            let meeting = envelope.meeting([u, theta, phi]).unwrap();
            let r = meeting.jet.r;
            lengths = lengths.max((f64::hypot(r.x, r.y) - radius).abs());
            // In the transverse section, counted from the side of the hob.
            let found = (-r.y).atan2(-r.x).to_degrees() - (r.z / p2).to_degrees();
            angles = angles.max((found - azimuth).abs());
            let n = meeting.jet.n;
            let moment = n.dot(Vector::Z.cross(r)).abs() / (n.x * n.x + n.y * n.y).sqrt();
            bases = bases.max((moment - get("gear_base_radius")).abs());
        }
        within(&format!("{name}: lengths, mm"), lengths, 1e-9);
        within(&format!("{name}: angles, deg"), angles, 1e-9);
        if involute {
            within("ZI: base radius of the gear, mm", bases, 1e-12);
        }
    }
}

/// A third motion, the hob shifted along its axis, gives no new equation: its n·v is that of the hob's turn divided by the lead.
#[test]
fn exact_shifted_hob() {
    let (pitch, turn) = (4.0, Twist::turn(Vector::Z, Vector::ZERO));
    let hob = hob_flank(true, 40.0, pitch, 20f64.to_radians(), PI);
    let motion = Motion::<Hob, Hob>::identity().joint(turn, Law::linear(1.0));
    let envelope = Envelope {
        surface: hob,
        motion,
        range: [-1.0, 1.0],
    };
    let mut worst = 0f64;
    for at in [[30.0, 0.4, 0.1], [38.0, -1.0, 0.7], [45.0, 2.0, -0.3]] {
        let meeting = envelope.meeting(at).unwrap();
        let (shift, _) = meeting.under(&Twist::slide(Vector::Z));
        worst = worst.max((meeting.f + pitch * shift).abs());
    }
    within("n·v of turn and shift, mm", worst, 1e-13);
}

/// Motions of random joints with values that are no numbers, lengths of zero, tools without a normal: no panic, and no number that is none.
#[test]
fn survives_degenerate_envelopes() {
    fastrand::seed(83);
    let odd = [0.0, -0.0, 1.0, -1.0, 1e-300, 1e300, f64::NAN, f64::INFINITY];
    let pick = || match fastrand::usize(..3) {
        0 => odd[fastrand::usize(..odd.len())],
        _ => 10.0 * (fastrand::f64() - 0.5),
    };
    for _ in 0..3000 {
        let vector = || Vector::new(pick(), pick(), pick());
        let line = Arc::straight(vector(), vector(), [-1.0, 1.0]);
        let tool = Tool::<_, Wheel>::new(
            line,
            Twist {
                w: vector(),
                s: vector(),
            },
        );
        let joint = Twist {
            w: vector(),
            s: vector(),
        };
        let motion = Motion::<Wheel, Wheel>::identity().joint(joint, Law::linear(pick()));
        let envelope = Envelope {
            surface: tool,
            motion,
            range: [-1.0, 1.0],
        };
        let (x, theta) = (pick(), pick());
        if let Some(point) = envelope.flank([x, theta]) {
            let numbers = [
                point.at,
                point.point.coordinates.array(),
                point.normal.components.array(),
            ];
            assert!(numbers.iter().flatten().all(|v| v.is_finite()), "{point:?}");
        }
        let _ = envelope.motion_parameters([0.5, theta]);
        let _ = envelope.intersect_circle([1.0, 2.0], [0.5, theta, x]);
        let _ = envelope.two_motion_point(x, &joint, [0.5, theta]);
    }
}

/// Geodesic torsion of a right helicoid of pitch c: its helices are asymptotic lines, whose geodesic torsion is their torsion `c/(ρ² + c²)`,
/// positive for a right hand; along the rulings it is the negative of that. It does not depend on the side of the normal.
#[test]
fn exact_geodesic_torsion_of_a_right_helicoid() {
    for pitch in [4.0, -3.0] {
        let ruling = Arc::straight(Vector::ZERO, Vector::X, [0.0, 20.0]);
        let screw = Twist::screw(Vector::Z, Vector::ZERO, pitch);
        let surface = Tool::<_, Work>::new(ruling, screw);
        let radius = 7.0;
        let expected = pitch / (radius * radius + pitch * pitch);
        for surface in [surface, surface.flipped()] {
            let jet = surface.jet([radius, 0.3]).unwrap();
            let curvature = Curvature::of(&jet).unwrap();
            let (sin, cos) = 0.3f64.sin_cos();
            let ruling = Vector::new(cos, sin, 0.0);
            let helix = Vector::new(-radius * sin, radius * cos, pitch)
                .unit()
                .unwrap();
            within(
                "along the helix",
                apart(curvature.torsion(helix), expected),
                1e-13,
            );
            within(
                "along the ruling",
                apart(curvature.torsion(ruling), -expected),
                1e-13,
            );
        }
    }
}

/// Geodesic torsion of an envelope, `−n′·(n×r′)/r′²` by fourth-order differences of its points and normals along a line of its parameters.
#[test]
fn exact_geodesic_torsion_by_differences() {
    let arc = Arc::about(
        Vector::new(112.0, 7.0, 3.0),
        30.0,
        [Vector::X, Vector::Z],
        [0.0, TAU],
    );
    let surface = Tool::<_, Wheel>::new(arc, Twist::turn(Vector::Z, Vector::new(12.0, 7.0, 3.0)));
    let turn = |factor: f64| Law::Polynomial([0.0, factor, 0.01, 0.0, 0.0, 0.0]);
    let motion = Motion::<Wheel, Wheel>::identity()
        .joint(Twist::turn(Vector::Z, Vector::ZERO), turn(1.0))
        .then(Pose::<Wheel, Wheel>::shifted(Vector::new(
            35.0, -12.0, 20.0,
        )))
        .then(Pose::<Work, Wheel>::turned(Vector::X, 1.1))
        .joint(Twist::turn(Vector::Z, Vector::ZERO), turn(-1.7));
    let envelope = Envelope {
        surface,
        motion,
        range: [0.0, 1.0],
    };
    let mut worst = 0f64;
    for [dx, d_theta] in [[1.0, 0.3], [-0.4, 1.0], [0.7, -0.6]] {
        let at = |s: f64| envelope.flank([0.2 + dx * s, 0.7 + d_theta * s]).unwrap();
        let h = 2e-3;
        let slope = |of: &dyn Fn(f64) -> Vector| {
            let inner = (of(h) - of(-h)) * 8.0;
            (inner - (of(2.0 * h) - of(-2.0 * h))) * (1.0 / (12.0 * h))
        };
        let dr = slope(&|s| at(s).point.coordinates);
        let dn = slope(&|s| at(s).normal.components);
        let here = at(0.0);
        let n = here.normal.components;
        let torsion = -dn.dot(n.cross(dr)) / dr.dot(dr);
        let exact = here
            .second_order
            .envelope()
            .unwrap()
            .torsion(dr.unit().unwrap());
        worst = worst.max(apart(torsion, exact));
    }
    within("geodesic torsion of the envelope", worst, 1e-8);
}
