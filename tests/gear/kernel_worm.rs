//! The kernel of meshing on worms: contact and limits of cylindrical worm pairs, transition and limits of disk tools, second contact.

use std::f64::consts::PI;

use geardyn::internals::gear::kernel::envelope::Envelope;
use geardyn::internals::gear::kernel::jet::Surface;
use geardyn::internals::gear::kernel::law::Law;
use geardyn::internals::gear::kernel::limits::{Limit, limit_points};
use geardyn::internals::gear::kernel::motion::Motion;
use geardyn::internals::gear::kernel::pose::{Pose, Transform};
use geardyn::internals::gear::kernel::root::sign_change;
use geardyn::internals::gear::kernel::tool::{Arc, Tool};
use geardyn::internals::gear::kernel::twist::Twist;
use geardyn::internals::gear::kernel::vector::Vector;

use crate::cases::{case, number, numbers};
use crate::verification::within;

#[derive(Debug, Clone, Copy, PartialEq)]
struct Worm;
#[derive(Debug, Clone, Copy, PartialEq)]
struct Wheel;

/// Largest difference of two lists.
fn apart(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let pairs = found.iter().zip(expected);
    pairs.fold(0.0, |worst, (a, b)| f64::max(worst, (a - b).abs()))
}

/// A cylindrical worm whose flank rises outwards through z = 0 on the reference cylinder, as a line swept by a screw.
fn worm_flank(involute: bool, radius: f64, pitch: f64, alpha_n: f64) -> Tool<Arc, Worm> {
    let gamma = (pitch / radius).atan();
    let screw = Twist::screw(Vector::Z, Vector::ZERO, pitch);
    let line = if involute {
        let gamma_b = (gamma.cos() * alpha_n.cos()).acos();
        let base = pitch / gamma_b.tan();
        let along = ((radius - base) * (radius + base)).sqrt();
        // Generator from the base cylinder, rising outwards; at the reference cylinder it has z = 0 at azimuth 0.
        let (sin, cos) = (along.atan2(base)).sin_cos();
        Arc::straight(
            Vector::new(base * cos, -base * sin, -along * gamma_b.tan()),
            Vector::new(sin, cos, gamma_b.tan()),
            [0.0, 80.0],
        )
    } else {
        let slope = alpha_n.tan() / gamma.cos();
        Arc::straight(
            Vector::new(0.0, 0.0, -radius * slope),
            Vector::new(1.0, 0.0, slope),
            [1.0, 80.0],
        )
    };
    // c′ × S(c) points to −y first, that is to larger z.
    Tool::new(line, screw)
}

/// The worm in the wheel's frame over the worm's turn: axis of the wheel through (a, 0, 0) along −y, the wheel turns by `ratio` times as much.
fn worm_in_wheel(a: f64, ratio: f64) -> Motion<Wheel, Worm> {
    Motion::<Worm, Worm>::identity()
        .joint(Twist::turn(Vector::Z, Vector::ZERO), Law::linear(1.0))
        .then(Pose::<Wheel, Worm>::shifted(-a * Vector::X))
        .joint(Twist::turn(Vector::Y, Vector::ZERO), Law::linear(ratio))
}

/// Places, limit functions, induced curvature and speeds of the contact line of cylindrical worm pairs.
/// Source: closed forms against extrema of azimuth, data/reference/gear/c52_worm_pair_za.json and c53_worm_pair_zi.json.
#[test]
fn ref_worm_pairs() {
    for (name, involute) in [("c52_worm_pair_za", false), ("c53_worm_pair_zi", true)] {
        let case = case(name);
        let expected = &case["expected"];
        let (a, pitch) = (number(&expected["a"]), number(&expected["p"]));
        let worm = worm_flank(involute, 25.0, pitch, 20f64.to_radians());
        let envelope = Envelope {
            surface: worm,
            motion: worm_in_wheel(a, 2.0 / 40.0),
            range: [-4.0, 4.0],
        };
        let (mut places, mut seconds) = (0f64, 0f64);
        for row in expected["contact"].as_array().unwrap() {
            let row = numbers(row);
            let [rho, psi, z, phi] = row[..4] else {
                panic!()
            };
            let (x, psi) = (phi.to_radians(), psi.to_radians());
            // On the screw of the worm ψ = χ + φ, and the line's own azimuth for the involute worm.
            let start = if involute {
                (rho * rho - 11.858690415559908f64.powi(2)).sqrt()
            } else {
                rho
            };
            let own = |u: f64| {
                let r = envelope.surface.jet([u, 0.0]).unwrap().r;
                r.y.atan2(r.x)
            };
            let theta = psi - x - own(start);
            let u = envelope.surface_parameter([x, theta]).unwrap();
            let in_worm = envelope.surface.jet([u, theta]).unwrap().r;
            let point = envelope.point([u, theta, x]).unwrap();
            let r = point.point.coordinates;
            places = places.max(apart(
                &[f64::hypot(in_worm.x, in_worm.y), in_worm.z, r.x, r.y, r.z],
                &[rho, z, row[4], row[5], row[6]],
            ));
            let second = point.second_order;
            let p = f64::hypot(second.p[0], second.p[1]);
            let [over_worm, over_wheel] = second.contact_line_speeds().unwrap();
            let v = envelope.meeting([u, theta, x]).unwrap().velocity;
            let lubrication = (v.dot(second.contact_line().unwrap()) / v.norm())
                .abs()
                .acos();
            let found = [
                second.second_limit,
                second.undercut,
                p * p / second.undercut,
                lubrication.to_degrees(),
                v.norm(),
                over_worm,
                over_wheel,
                over_wheel - over_worm,
            ];
            seconds = seconds.max(apart(&found, &row[7..15]));
        }
        within(&format!("{name}: places, mm"), places, 1e-9);
        within(
            &format!("{name}: Φ, D, curvature, angle, speeds"),
            seconds,
            1e-9,
        );
    }
}

/// Undercut of worm wheels: the limit of the first kind.
/// Source: closed forms against the area of a patch, data/reference/gear/c55_worm_first_limit.json.
#[test]
fn ref_undercut_of_worm_wheels() {
    let case = case("c55_worm_first_limit");
    let (radius, pitch, alpha_n) = (25.0, 5.0, 15f64.to_radians());
    for (name, involute) in [("ZA", false), ("ZI", true)] {
        let worm = worm_flank(involute, radius, pitch, alpha_n);
        let envelope = Envelope {
            surface: worm,
            motion: worm_in_wheel(75.0, 0.1),
            range: [-6.0, 6.0],
        };
        let (mut places, mut count) = (0f64, 0);
        for row in case["expected"][name]["rows"].as_array().unwrap() {
            let [psi, rho, z, wheel_radius, y] = numbers(row)[..] else {
                panic!()
            };
            // The worm's own parameters of the listed point.
            let off = |u: f64| {
                let r = envelope.surface.jet([u, 0.0]).unwrap().r;
                Some(f64::hypot(r.x, r.y) - rho)
            };
            let u = sign_change([0.5, 79.0], off).unwrap();
            let own = envelope.surface.jet([u, 0.0]).unwrap().r;
            let theta = (z - own.z) / pitch;
            let x = psi.to_radians() - theta - own.y.atan2(own.x);
            let line = [[x - 0.02, theta], [x + 0.02, theta]];
            let found = limit_points(&envelope, Limit::Undercut, line, 1);
            let point = found[0];
            let r = point.point.coordinates;
            places = places.max(apart(
                &[point.at[0], point.at[2] * radius, f64::hypot(r.x, r.z), r.y],
                &[u, x * radius, wheel_radius, y],
            ));
            count += 1;
        }
        assert_eq!(count, 7);
        within(&format!("{name}: places, mm"), places, 1e-9);
    }
}

/// The wheel of c45 and c40: axis through (A, 0, 0) along (0, −sin S, cos S); β counts along −θ of the recipe.
struct DiskTool {
    shift: f64,
    tilt: f64,
}

impl DiskTool {
    fn axis(&self) -> Vector {
        Vector::new(0.0, -self.tilt.sin(), self.tilt.cos())
    }

    /// A straight profile through `(R, ζ)` with `dζ/dR = slope`; the curve's parameter is R − R₀ for `along_axis` false, ζ − ζ₀ otherwise.
    fn profile(&self, radius: f64, height: f64, slope: Option<f64>) -> Tool<Arc, Wheel> {
        let point = (self.shift - radius) * Vector::X + height * self.axis();
        let direction = match slope {
            Some(slope) => slope * self.axis() - Vector::X,
            None => self.axis(),
        };
        let turn = Twist::turn(-self.axis(), self.shift * Vector::X);
        Tool::new(Arc::straight(point, direction, [-30.0, 40.0]), turn)
    }

    fn helicoid(&self, tool: Tool<Arc, Wheel>, pitch: f64) -> Envelope<Tool<Arc, Wheel>, Worm> {
        let motion = Motion::fixed(Pose::<Worm, Wheel>::new(Transform::IDENTITY)).joint(
            Twist::screw(Vector::Z, Vector::ZERO, pitch),
            Law::linear(1.0),
        );
        Envelope {
            surface: tool,
            motion,
            range: [-1.0, 1.0],
        }
    }

    /// Angle β at which the point u of a profile touches.
    fn contact_angle(&self, tool: Tool<Arc, Wheel>, pitch: f64, u: f64) -> f64 {
        let envelope = self.helicoid(tool, pitch);
        sign_change([-0.3, 0.3], |beta| {
            Some(envelope.meeting([u, beta, 0.0])?.f)
        })
        .unwrap()
    }
}

/// Axial section of a helicoid's point: radius, and `z − pχ`.
fn axial(r: Vector, pitch: f64) -> [f64; 2] {
    [f64::hypot(r.x, r.y), r.z - pitch * r.y.atan2(r.x)]
}

/// The transition a wheel's edge leaves, the tilt that avoids it, and undercut of a steep worm by its wheel and of a wheel by its worm.
/// Source: closed forms against extrema of distance, data/reference/gear/c45_transition_and_first_limit.json.
#[test]
fn ref_transition_and_limits_of_a_disk_tool() {
    let case = case("c45_transition_and_first_limit");
    let expected = &case["expected"];
    let get = |name: &str| number(&expected[name]);
    let (pitch, slope) = (4.0, -20f64.to_radians().tan());
    let (edge, height) = (get("edge_radius_Re"), get("edge_height"));
    let angles = |tilt: f64| {
        let disk = DiskTool { shift: 120.0, tilt };
        let flank = disk.contact_angle(disk.profile(edge, height, Some(slope)), pitch, 0.0);
        let land = disk.contact_angle(disk.profile(edge, height, None), pitch, 0.0);
        [flank, land]
    };
    let tilt = get("axis_angle_deg").to_radians();
    let [flank, land] = angles(tilt);
    within(
        "contact angles at the edge, °",
        apart(
            &[flank.to_degrees(), land.to_degrees()],
            &[get("beta_flank_deg"), get("beta_land_deg")],
        ),
        1e-9,
    );
    let disk = DiskTool { shift: 120.0, tilt };
    let wheel = disk.profile(edge, height, None);
    let mut worst = 0f64;
    for (i, row) in expected["transition_axial_rho_z"]
        .as_array()
        .unwrap()
        .iter()
        .enumerate()
    {
        let beta = flank + (land - flank) * i as f64 / 4.0;
        let r = wheel.jet([0.0, beta]).unwrap().r;
        worst = worst.max(apart(&axial(r, pitch), &numbers(row)));
    }
    within("transition surface, mm", worst, 1e-9);
    let without = sign_change([0.2, 0.3], |tilt| {
        let [flank, land] = angles(tilt);
        Some(flank - land)
    });
    let without = without.unwrap().to_degrees();
    within(
        "tilt without transition, °",
        (without - get("setting_without_transition_deg")).abs(),
        1e-9,
    );
    let mut worst = 0f64;
    for row in expected["first_limit"].as_array().unwrap() {
        let get = |name: &str| number(&row[name]);
        let (r0, r, pitch) = (
            get("R0"),
            0.5 * get("m") * get("q"),
            0.5 * get("m") * get("z1"),
        );
        let disk = DiskTool {
            shift: r0 + r,
            tilt: (pitch / r).atan(),
        };
        let envelope = disk.helicoid(disk.profile(r0, get("half_width"), Some(slope)), pitch);
        let found = limit_points(&envelope, Limit::Undercut, [[0.0, -0.5], [0.0, 0.5]], 40);
        assert_eq!(found.len(), 1);
        let radius = axial(found[0].point.coordinates, pitch)[0];
        worst = worst.max(apart(
            &[r0 + found[0].at[0], radius],
            &[get("limit_tool_radius"), get("limit_worm_radius")],
        ));
    }
    within("limit of the first kind of the worm, mm", worst, 1e-9);
    let (mut worst, mut count) = (0f64, 0);
    for row in expected["tool_from_helicoid_limits"].as_array().unwrap() {
        let Some(rho) = row["tool_profile_turns_back_at_rho"].as_f64() else {
            continue;
        };
        let get = |name: &str| number(&row[name]);
        let (r0, r, pitch) = (
            get("R0"),
            0.5 * get("m") * get("q"),
            0.5 * get("m") * get("z1"),
        );
        let gamma = (pitch / r).atan();
        let disk = DiskTool {
            shift: r0 + r,
            tilt: gamma + get("S_minus_lead_angle_deg").to_radians(),
        };
        let slope = get("alpha_n_deg").to_radians().tan() / gamma.cos();
        let line = Arc::straight(
            Vector::new(0.0, 0.0, 0.25 * PI * get("m") - r * slope),
            Vector::new(1.0, 0.0, slope),
            [9.0, 25.0],
        );
        let worm = Tool::<_, Worm>::new(line, Twist::screw(Vector::Z, Vector::ZERO, pitch));
        let turn = Twist::turn(disk.axis(), disk.shift * Vector::X);
        let motion = Motion::fixed(Pose::<Wheel, Worm>::new(Transform::IDENTITY))
            .joint(turn, Law::linear(1.0));
        let envelope = Envelope {
            surface: worm,
            motion,
            range: [-1.0, 1.0],
        };
        let found = limit_points(&envelope, Limit::Undercut, [[0.0, -1.0], [0.0, 1.0]], 200);
        let errors = found.iter().map(|point| {
            let off = point.point.coordinates - disk.shift * Vector::X;
            let zeta = off.dot(disk.axis());
            let radius = (off - zeta * disk.axis()).norm();
            apart(
                &[point.at[0], radius, zeta],
                &[rho, get("tool_R"), get("tool_zeta")],
            )
        });
        worst = worst.max(errors.fold(f64::INFINITY, f64::min));
        count += 1;
    }
    assert_eq!(count, 3);
    within("limit of a wheel made to a helicoid, mm", worst, 1e-8);
}

/// A plane generates an hourglass worm, which touches its wheel twice: contact and limits of the plane, the second contact by division by
/// the first.
/// Source: closed forms against extrema of azimuth, data/reference/gear/c56_plane_double_enveloping.json.
#[test]
fn ref_plane_double_enveloping_worm() {
    let case = case("c56_plane_double_enveloping");
    let expected = &case["expected"];
    let (a, ratio, base, beta) = (125.0, 1.0 / 40.0, 40.0, 11f64.to_radians());
    // In the wheel X points away from the worm: ξ = −X. The plane is a line along ξ, slid along η.
    let line = Arc::straight(base * Vector::Z, -Vector::X, [40.0, 180.0]);
    let slide = Twist::slide(Vector::new(0.0, 1.0, beta.tan()));
    let plane = Tool::<_, Wheel>::new(line, slide).flipped();
    let wheel_turn = Twist::turn(-Vector::Y, Vector::ZERO);
    let motion = Motion::<Wheel, Wheel>::identity()
        .joint(wheel_turn, Law::linear(ratio))
        .then(Pose::<Worm, Wheel>::shifted(a * Vector::X))
        .joint(Twist::turn(Vector::Z, Vector::ZERO), Law::linear(-1.0));
    let back = motion.inverse();
    let worm = Envelope {
        surface: plane,
        motion,
        range: [0.0, 50f64.to_radians() / ratio],
    };
    let (mut first, mut second, mut orders) = (0f64, 0f64, 0f64);
    for row in expected["contact"].as_array().unwrap() {
        let row = numbers(row);
        let (x, eta) = (row[0].to_radians() / ratio, row[1]);
        let point = worm.flank([x, eta]).unwrap();
        let made = point.second_order;
        let r =
            Transform::exp(&Twist::turn(Vector::Z, Vector::ZERO), x).apply(point.point.coordinates);
        first = first.max(apart(&[point.at[0], r.x, r.y, r.z], &row[2..6]));
        let curvature = made.p[0].hypot(made.p[1]).powi(2) / made.undercut;
        orders = orders.max(apart(
            &[made.second_limit, made.undercut, curvature],
            &row[6..9],
        ));
        let wheel = Envelope {
            surface: &worm,
            motion: back.clone(),
            range: [x - 3.0, x + 3.1],
        };
        let again = wheel.second_contacts([x, eta], x);
        assert_eq!(again.len(), 1, "{again:?}");
        let delta = again[0] - x;
        let touched = wheel.point([x, eta, again[0]]).unwrap();
        let s = touched.point.coordinates;
        let above = (s - base * Vector::Z).dot(Vector::new(0.0, -beta.sin(), beta.cos()));
        second = second.max(apart(
            &[
                delta.to_degrees(),
                (again[0] * ratio).to_degrees(),
                -s.x,
                s.y,
                s.z,
                above,
            ],
            &[row[10], row[11], row[12], row[13], row[14], row[15]],
        ));
        let o = touched.second_order;
        let curvature = o.p[0].hypot(o.p[1]).powi(2) / o.undercut;
        orders = orders.max((curvature - row[16]).abs());
    }
    within("first contact, mm", first, 1e-9);
    within("Φ, D and curvatures", orders, 1e-10);
    within("second contact, mm and °", second, 1e-9);
    let (mut limits, mut edges) = (0f64, 0f64);
    for row in expected["limit"].as_array().unwrap() {
        let row = numbers(row);
        let x = row[0].to_radians() / ratio;
        let across = [[x, -10.0], [x, 10.0]];
        let found = limit_points(&worm, Limit::Second, across, 20);
        assert_eq!(found.len(), 1);
        let [xi, eta, _] = found[0].at;
        limits = limits.max(apart(
            &[xi, eta, found[0].second_order.undercut],
            &[row[4], row[5], row[7]],
        ));
        let found = limit_points(&worm, Limit::Undercut, across, 20);
        assert_eq!(found.len(), 1);
        edges = edges.max((found[0].at[1] - row[9]).abs());
    }
    within("second limit, mm", limits, 1e-9);
    within("edge of regression of the worm, mm", edges, 1e-9);
}
