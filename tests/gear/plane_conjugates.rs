//! Conjugate profiles by three routes, their curvature, sliding and limits.

use std::f64::consts::{FRAC_PI_2, PI};

use geardyn::internals::gear::plane::centrodes::{Centrodes, Mate};
use geardyn::internals::gear::plane::conjugate::{ConjugateProfile, conjugate};
use geardyn::internals::gear::plane::contact::Contact;
use geardyn::internals::gear::plane::envelope::envelope;
use geardyn::internals::gear::plane::limits::{
    LimitKind, check_limits, limiting_curvature, limits,
};
use geardyn::internals::gear::plane::line_of_action::LineOfAction;
use geardyn::internals::gear::plane::profile::{Profile, Shape};
use geardyn::internals::gear::plane::ratio_law::RatioLaw;
use geardyn::internals::gear::plane::rolling::{Centrode, Rolling};
use geardyn::internals::numeric::Complex;

use crate::verification::{printed, within};

/// Module of the examples, m; 20 and 40 teeth.
const MODULE: f64 = 5e-3;
const R1: f64 = 10.0 * MODULE;
const R2: f64 = 20.0 * MODULE;

fn circles(tool: f64, work: f64) -> Rolling {
    Rolling {
        tool: Centrode::circle(tool).unwrap(),
        work: Centrode::circle(work).unwrap(),
    }
}

fn pressure_angle() -> f64 {
    20_f64.to_radians()
}

/// Involute of gear 1 that crosses the pitch circle on the line of centres.
fn involute(rolls: [f64; 2]) -> Shape {
    let alpha = pressure_angle();
    let start = -(alpha.tan() - alpha);
    Shape::involute(R1 * alpha.cos(), start, true, rolls).unwrap()
}

fn distances(contacts: &[Contact]) -> Vec<f64> {
    let direction = contacts[0].path_point;
    let sign = |z: Complex| (z * direction.conj()).re.signum();
    contacts
        .iter()
        .map(|c| sign(c.path_point) * c.path_point.norm())
        .collect()
}

/// The kernel's envelope and a line of action give the points that the normals give, relative to the module.
fn compare_routes<P: Profile + Clone>(
    generated: &ConjugateProfile<P>,
    line: &LineOfAction,
    parameter: impl Fn(&Contact) -> f64,
    tolerance: f64,
) {
    let contacts = generated.contacts();
    let (first, last) = (contacts[0].arc, contacts[contacts.len() - 1].arc);
    let reach = 0.05 * (last - first).abs();
    let range = [first.min(last) - reach, first.max(last) + reach];
    let by_kernel = envelope(generated.rolling(), generated.tool().clone(), range).unwrap();
    let parameters: Vec<f64> = contacts.iter().map(parameter).collect();
    let by_line = line
        .contacts(generated.rolling(), &parameters, first)
        .unwrap();
    for (contact, on_line) in contacts.iter().zip(&by_line) {
        let arcs = by_kernel.motion_parameters([contact.parameter, 0.0]);
        let arc = *arcs
            .iter()
            .min_by(|a, b| {
                (*a - contact.arc)
                    .abs()
                    .total_cmp(&(*b - contact.arc).abs())
            })
            .unwrap();
        let point = by_kernel
            .point([contact.parameter, 0.0, arc])
            .unwrap()
            .profile();
        let [x, y] = point.point;
        let apart = (Complex::new(x, y) - contact.work_point).norm() / MODULE;
        within("kernel against normals", apart, tolerance);
        let bend = (point.curvature.abs() - contact.work_curvature.abs()) / contact.work_curvature;
        within("curvature, kernel against normals", bend.abs(), 1e-8);
        let apart = (on_line.work_point - contact.work_point).norm() / MODULE;
        within("line of action against normals", apart, tolerance);
        let apart = (on_line.tool_point - contact.tool_point).norm() / MODULE;
        within("line of action on the tool", apart, tolerance);
    }
}

/// Involute on 20 teeth → involute on 40: base circle, curvature, line of action; three routes to 1e-12 of the module.
#[test]
fn exact_involute_pair() {
    let generated = conjugate(&circles(R1, -R2), involute([0.15, 0.6]), 60).unwrap();
    let contacts = generated.contacts();
    assert_eq!(contacts.len(), 60);
    let base = R2 * pressure_angle().cos();
    for c in contacts {
        let arm = (c.work_point * c.work_tangent.conj()).re.abs();
        within(
            "base radius of the conjugate",
            (arm / base - 1.0).abs(),
            1e-13,
        );
        let sliding = c.normal_distance * (1.0 / R1 + 1.0 / R2);
        within("sliding velocity", (c.sliding() - sliding).abs(), 1e-14);
        let roll = (c.work_point.norm_sqr() - base * base).sqrt();
        within(
            "its curvature",
            ((c.work_curvature * roll).abs() - 1.0).abs(),
            1e-11,
        );
    }
    let angle = contacts[0].path_point.arg();
    let off = (angle.sin().abs() - pressure_angle().sin()).abs();
    within("line of action at the pressure angle", off, 1e-14);
    let line = LineOfAction::Straight { angle };
    let lengths = distances(contacts);
    let by_length = |c: &Contact| {
        let at = contacts.iter().position(|d| d.parameter == c.parameter);
        lengths[at.unwrap()]
    };
    compare_routes(&generated, &line, by_length, 1e-12);
}

/// Azimuth and radius of a cycloid agree with a curve up to a fixed rotation.
fn assert_on_cycloid(what: &str, base: f64, rolling: f64, points: &[Complex]) {
    let x_of = |z: &Complex| {
        // |z|² = (R + r)² + r² − 2 r (R + r) cos x.
        let sum = base + rolling;
        let cos = (sum * sum + rolling * rolling - z.norm_sqr()) / (2.0 * rolling * sum);
        cos.clamp(-1.0, 1.0).acos()
    };
    let turn = |z: &Complex, side: f64| {
        let theta = side * x_of(z) * rolling / base;
        let shape = Shape::cycloid(base, rolling, 0.0, [-10.0, 10.0]).unwrap();
        (z / shape.jet(theta).unwrap().point).arg()
    };
    let spread = |side: f64| {
        let turns: Vec<f64> = points.iter().map(|z| turn(z, side)).collect();
        let worst = |x: &f64| {
            let apart = (x - turns[0]) / (2.0 * PI);
            (apart - apart.round()).abs() * 2.0 * PI
        };
        turns.iter().map(worst).fold(0.0, f64::max)
    };
    within(what, spread(1.0).min(spread(-1.0)), 1e-11);
}

/// Epicycloid on gear 1 → hypocycloid on gear 2, along the rolling circle; three routes.
#[test]
fn exact_cycloid_pair() {
    let rho = 0.3 * R1;
    let tool = Shape::cycloid(R1, rho, 0.1, [0.05, 0.5]).unwrap();
    let generated = conjugate(&circles(R1, -R2), tool, 60).unwrap();
    let contacts = generated.contacts();
    let points: Vec<Complex> = contacts.iter().map(|c| c.work_point).collect();
    assert_on_cycloid("hypocycloid", R2, -rho, &points);
    for c in contacts {
        let off = (c.path_point - Complex::new(0.0, -rho)).norm() / rho - 1.0;
        within("path on the rolling circle", off.abs(), 1e-13);
    }
    let line = LineOfAction::Circle { radius: -rho };
    // l = 2 r sin α with r = −ρ: α follows from the direction of the path point.
    let parameter = |c: &Contact| {
        let angle = c.path_point.arg();
        if angle < -FRAC_PI_2 {
            angle + PI
        } else {
            angle
        }
    };
    compare_routes(&generated, &line, parameter, 1e-12);
}

/// Pins centred on the pitch circle, and an arc whose centre lies inside it: three routes.
#[test]
fn exact_pins_and_arcs() {
    for (distance, radius, angles) in [
        (R1, 0.9 * MODULE, [0.5 * PI + 0.03, 0.5 * PI + 0.35]),
        (0.95 * R1, 3.0 * MODULE, [0.5, 1.2]),
        (1.04 * R1, 2.5 * MODULE, [2.0, 2.6]),
    ] {
        let centre = Complex::new(distance, 0.0);
        let tool = Shape::arc(centre, radius, angles).unwrap();
        let generated = conjugate(&circles(R1, -R2), tool, 40).unwrap();
        // Centre of the arc in the pitch frame; the contact lies a radius from it, towards the pitch point or away.
        let c = generated.contacts()[0];
        let q = (centre * Complex::cis(-c.arc / R1) - R1) * Complex::new(0.0, -1.0);
        let towards = |sign: f64| (q - q / q.norm() * sign * radius - c.path_point).norm();
        let sign = if towards(1.0) < towards(-1.0) {
            1.0
        } else {
            -1.0
        };
        let line = LineOfAction::Arc {
            centre_distance: distance,
            pitch_radius: R1,
            arc_radius: sign * radius,
        };
        compare_routes(&generated, &line, |c| -c.arc / R1, 1e-12);
    }
}

/// A profile given as points of an involute: conjugate, and its line of action given as points, to 1e-9 of the module.
#[test]
fn exact_profile_as_points() {
    let exact = conjugate(&circles(R1, -R2), involute([0.1, 0.65]), 60).unwrap();
    let points: Vec<Complex> = (0..=80)
        .map(|i| {
            involute([0.1, 0.65])
                .jet(0.15 + 0.45 * f64::from(i) / 80.0)
                .unwrap()
                .point
        })
        .collect();
    let generated = conjugate(&circles(R1, -R2), Shape::points(&points).unwrap(), 60).unwrap();
    for c in generated.contacts() {
        // The involute through the point of the tool, and its contact.
        let base = R1 * pressure_angle().cos();
        let roll = ((c.tool_point.norm() / base).powi(2) - 1.0).sqrt();
        let contact = exact.at(roll).unwrap();
        let apart = (contact.work_point - c.work_point) * c.work_tangent.conj() / MODULE;
        within(
            "conjugate of points, across the profile",
            apart.im.abs(),
            1e-9,
        );
        within("along it, by the error of the normal", apart.re.abs(), 1e-7);
    }
    let contacts = exact.contacts();
    let path: Vec<Complex> = contacts.iter().map(|c| c.path_point).collect();
    let line = LineOfAction::points(&path).unwrap();
    let rows: Vec<f64> = (0..path.len()).map(|i| i as f64).collect();
    let by_line = line
        .contacts(exact.rolling(), &rows, contacts[0].arc)
        .unwrap();
    for (a, b) in contacts.iter().zip(&by_line) {
        within(
            "line of action as points",
            (a.work_point - b.work_point).norm() / MODULE,
            1e-9,
        );
    }
    let from_points =
        envelope(generated.rolling(), generated.tool().clone(), [-0.02, 0.02]).unwrap();
    let mut compared = 0;
    for c in generated.contacts() {
        let arcs = from_points.motion_parameters([c.parameter, 0.0]);
        let Some(arc) = arcs.iter().find(|s| (*s - c.arc).abs() < 1e-6) else {
            continue;
        };
        let [x, y] = from_points
            .point([c.parameter, 0.0, *arc])
            .unwrap()
            .profile()
            .point;
        within(
            "kernel on points",
            (Complex::new(x, y) - c.work_point).norm() / MODULE,
            1e-9,
        );
        compared += 1;
    }
    assert!(compared > 40, "{compared}");
}

/// Straight, arc and involute flanks on elliptic centrodes: normals by arc against the kernel by the angle of gear 1.
#[test]
fn exact_elliptic_pair_by_two_routes() {
    let law = RatioLaw::elliptic(0.3).unwrap();
    let pair = Centrodes::of_gears(&law, 0.1, Mate::External).unwrap();
    let rolling = Rolling::of_pair(&pair);
    let alpha = pressure_angle();
    for start in [0.3, 1.4, 2.9] {
        let angle = start;
        let foot = rolling.tool.at(pair.arc(angle)).unwrap();
        let across = foot.tangent * Complex::cis(FRAC_PI_2 + alpha);
        let centre = foot.point + foot.tangent * Complex::cis(-alpha) * 0.03;
        let lean = (foot.tangent * Complex::cis(-alpha)).arg() + PI;
        for tool in [
            Shape::line(foot.point - across * 0.003, foot.point + across * 0.003).unwrap(),
            Shape::arc(centre, 0.03, [lean - 0.08, lean + 0.08]).unwrap(),
        ] {
            let generated = conjugate(&rolling, tool.clone(), 30).unwrap();
            let by_kernel = envelope(&rolling, tool, [angle - 0.4, angle + 0.4]).unwrap();
            for c in generated.contacts() {
                let angles = by_kernel.motion_parameters([c.parameter, 0.0]);
                let here = pair.angle_at_arc(c.arc).unwrap();
                let near = angles
                    .iter()
                    .min_by(|a, b| (*a - here).abs().total_cmp(&(*b - here).abs()))
                    .unwrap();
                let [x, y] = by_kernel
                    .point([c.parameter, 0.0, *near])
                    .unwrap()
                    .profile()
                    .point;
                let apart = (Complex::new(x, y) - c.work_point).norm() / MODULE;
                within("kernel against normals, ellipses", apart, 1e-12);
            }
        }
    }
}

/// Bobillier's construction: with A, A₀ centres of curvature of both profiles and B, B₀ those of the centrodes, the line from the pitch point
/// to AB × A₀B₀ makes with PA the angle that PB makes with the common tangent.
#[test]
fn exact_bobillier() {
    let alphas = [0.2, 0.35, 0.5];
    for (i, start) in alphas.into_iter().enumerate() {
        let tool = Shape::arc(
            Complex::new(0.93 * R1, 0.004),
            3.3 * MODULE,
            [start, start + 0.5],
        );
        let work = [-R2, -3.0 * R2, 4.0 * R1][i];
        let generated = conjugate(&circles(R1, work), tool.unwrap(), 20).unwrap();
        for c in generated.contacts() {
            let state = generated.rolling().at(c.arc).unwrap();
            let normal = Complex::new(0.0, 1.0) * c.work_tangent * state.work.tangent.conj();
            let a = c.path_point + normal / c.tool_curvature;
            let a0 = c.path_point + normal / c.work_curvature;
            let b = Complex::new(0.0, 1.0 / state.tool.curvature);
            let b0 = Complex::new(0.0, 1.0 / state.work.curvature);
            let cross = |p: Complex, q: Complex| (p.conj() * q).im;
            let (d, d0) = (b - a, b0 - a0);
            let q = a + d * (cross(a0 - a, d0) / cross(d, d0));
            let apart = (q.arg() - a.arg() - FRAC_PI_2) / PI;
            within(
                "collineation axis",
                (apart - apart.round()).abs() * PI,
                1e-10,
            );
        }
    }
}

/// Specific sliding of the FZG pair type C at the ends of contact.
///
/// Source: FZG gears 16/24, m 4.5 mm, a 91.5 mm, 20°, tip diameters 82.46 and 118.36 mm: ζ of ISO 21771, four digits.
#[test]
fn ref_sliding_of_fzg_type_c() {
    let (cos, a) = (pressure_angle().cos(), 91.5e-3);
    let (r1, r2) = (0.4 * a, 0.6 * a);
    let (base_1, base_2) = (36e-3 * cos, 54e-3 * cos);
    let line = ((a + base_1 + base_2) * (a - base_1 - base_2)).sqrt();
    let tip = |d: f64, base: f64| (0.25 * d * d - base * base).sqrt();
    let (rho_e, rho_a) = (tip(82.46e-3, base_1), line - tip(118.36e-3, base_2));
    let rolls = [rho_a / base_1, rho_e / base_1];
    let tool = Shape::involute(base_1, 0.0, true, rolls).unwrap();
    let generated = conjugate(&circles(r1, -r2), tool, 20).unwrap();
    let [at_a, at_e] = rolls.map(|u| generated.at(u).unwrap().specific_sliding());
    printed("ζ of gear 1 at A", "", -3.539, at_a[0], 5e-4);
    printed("ζ of gear 2 at A", "", 0.7797, at_a[1], 5e-5);
    printed("ζ of gear 1 at E", "", 0.6788, at_e[0], 5e-5);
    printed("ζ of gear 2 at E", "", -2.113, at_e[1], 5e-4);
}

/// A rack undercuts below `z = 2/sin²α` teeth: 17.0973 at 20°; the generated point of the limit lies on the base circle.
///
/// Source: `x_min = h_a* − z sin²α/2`.
#[test]
fn ref_undercut_by_a_rack() {
    let (alpha, radius) = (pressure_angle(), 6.0 * MODULE);
    let rolling = Rolling {
        tool: Centrode::Line,
        work: Centrode::circle(radius).unwrap(),
    };
    // Flank of the rack from its tip, one module inside the pitch line, to its root.
    let lean = Complex::new(1.0, alpha.tan());
    let tool = Shape::line(-lean * MODULE, lean * MODULE).unwrap();
    let generated = conjugate(&rolling, tool, 80).unwrap();
    let limits = limits(&generated);
    assert_eq!(limits.points.len(), 1);
    let limit = limits.points[0];
    assert_eq!(limit.kind, LimitKind::Undercut);
    let reach = radius * alpha.sin().powi(2);
    within(
        "height of the limit",
        (-limit.tool_point.re / reach - 1.0).abs(),
        1e-13,
    );
    let base = limit.work_point.norm() / (radius * alpha.cos());
    within("radius of the limit", (base - 1.0).abs(), 1e-13);
    assert!(limits.usable[0] == limit.parameter && limits.usable[1] == generated.tool().range()[1]);
    let curvature = limiting_curvature(&generated, &generated.contacts()[0]).unwrap();
    printed(
        "least number of teeth",
        "",
        17.0973,
        2.0 / (curvature * MODULE),
        5e-5,
    );
    let error = check_limits(&generated).unwrap_err();
    let text = format!("{error}");
    assert!(
        text.contains("undercuts the work") && text.contains("pitch curve the radius 42.7"),
        "{text}"
    );
}

/// A straight flank offset from its gear's axis has no contact where its foot distance exceeds the pitch radius.
#[test]
fn exact_end_of_contact() {
    let offset = 0.2 * R1;
    let at = |x: f64| Complex::new(x, offset);
    let tool = Shape::line(at(0.9 * R1), at(1.1 * R1)).unwrap();
    let generated = conjugate(&circles(R1, -R2), tool, 50).unwrap();
    let limits = limits(&generated);
    let limit = limits
        .points
        .iter()
        .find(|p| p.kind == LimitKind::EndOfContact)
        .unwrap();
    within(
        "end of contact",
        (limit.tool_point.re / R1 - 1.0).abs(),
        1e-12,
    );
    let tool = Shape::line(at(0.996 * R1), at(1.1 * R1)).unwrap();
    let generated = conjugate(&circles(R1, -R2), tool, 50).unwrap();
    let error = check_limits(&generated).unwrap_err();
    assert!(
        error.to_string().contains("has no contact beyond"),
        "{error}"
    );
}

/// An arc centred on the pitch circle touches at one instant: refused with the reason, on circles, racks and ellipses, also given as points.
#[test]
fn refuses_arcs_centred_on_the_pitch_circle() {
    let pair = RatioLaw::elliptic(0.3).unwrap();
    let pair = Centrodes::of_gears(&pair, 0.1, Mate::External).unwrap();
    let ellipse = Rolling::of_pair(&pair);
    let line = Rolling {
        tool: Centrode::Line,
        work: Centrode::circle(R2).unwrap(),
    };
    for rolling in [circles(R1, -R2), line, ellipse] {
        let foot = rolling.tool.at(0.011).unwrap();
        let lean = foot.tangent.arg() + 0.4;
        let arc = Shape::arc(foot.point, 1.5 * MODULE, [lean, lean + 0.5]).unwrap();
        let points: Vec<Complex> = (0..40)
            .map(|i| arc.jet(lean + 0.5 * f64::from(i) / 39.0).unwrap().point)
            .collect();
        for tool in [arc, Shape::points(&points).unwrap()] {
            let text = conjugate(&rolling, tool, 20).unwrap_err().to_string();
            assert!(
                text.contains("one instant") && text.contains("contact ratio is 0"),
                "{text}"
            );
        }
    }
}

/// Profiles, lines of action and motions that cannot be: the value, the row and the remedy.
#[test]
fn refuses_profiles_that_cannot_be() {
    let z = Complex::new;
    let says = |text: String, part: &str| assert!(text.contains(part), "{text}");
    let text = |shape: Result<Shape, geardyn::internals::base::error::Error>| {
        shape.unwrap_err().to_string()
    };
    says(
        text(Shape::line(z(0.1, 0.0), z(0.1, 0.0))),
        "give two points apart",
    );
    says(
        text(Shape::arc(z(0.1, 0.0), -1e-3, [0.0, 1.0])),
        "not negative",
    );
    says(
        text(Shape::arc(z(0.1, 0.0), 1e-3, [1.0, 0.0])),
        "limits must increase",
    );
    says(
        text(Shape::involute(R1, 0.0, true, [-0.1, 0.5])),
        "from the base circle",
    );
    says(
        text(Shape::involute(f64::NAN, 0.0, true, [0.1, 0.5])),
        "must be positive",
    );
    says(
        text(Shape::cycloid(R1, -R1, 0.0, [0.1, 0.5])),
        "gives no cycloid",
    );
    let mut points: Vec<Complex> = (0..9).map(|i| z(0.05, 1e-3 * f64::from(i))).collect();
    says(
        text(Shape::points(&points[..6])),
        "6 points; give 7 or more",
    );
    points[4] = points[3];
    says(text(Shape::points(&points)), "row 5");
    let path: Vec<Complex> = (-4..5).map(|i| z(1e-3 * f64::from(i), 0.0)).collect();
    says(
        LineOfAction::points(&path).unwrap_err().to_string(),
        "row 5",
    );
    let steep = LineOfAction::Straight { angle: FRAC_PI_2 };
    let error = steep
        .contacts(&circles(R1, -R2), &[0.0, 1e-3], 0.0)
        .unwrap_err();
    says(error.to_string(), "perpendicular");
    says(Centrode::circle(0.0).unwrap_err().to_string(), "not zero");
    // A line far from the pitch circle, its normals parallel to the tangent beyond it.
    let far = Shape::line(z(2.0 * R1, 0.0), z(3.0 * R1, 0.0)).unwrap();
    let error = conjugate(&circles(R1, -R2), far, 10).unwrap_err();
    says(
        error.to_string(),
        "no normal of the profile meets the pitch curve",
    );
    let law = RatioLaw::elliptic(0.3).unwrap();
    let pair = Centrodes::of_gears(&law, 0.1, Mate::External).unwrap();
    let mixed = Rolling {
        tool: Centrode::Line,
        work: Rolling::of_pair(&pair).work,
    };
    let line = Shape::line(z(-1e-3, 0.0), z(1e-3, 3e-4)).unwrap();
    let error = envelope(&mixed, line, [-0.1, 0.1]).unwrap_err();
    says(error.to_string(), "use the conjugate by normals");
}
