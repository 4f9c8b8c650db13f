//! Camus' theorem, second contact, the law of gearing, and laws over random cases.

use std::f64::consts::{PI, TAU};

use geardyn::internals::gear::kernel::envelope::Envelope;
use geardyn::internals::gear::plane::centrodes::{Centrodes, Mate};
use geardyn::internals::gear::plane::conjugate::conjugate;
use geardyn::internals::gear::plane::envelope::envelope;
use geardyn::internals::gear::plane::law_of_gearing::check_gearing;
use geardyn::internals::gear::plane::limits::limits;
use geardyn::internals::gear::plane::profile::{Profile, Shape};
use geardyn::internals::gear::plane::ratio_law::RatioLaw;
use geardyn::internals::gear::plane::rolling::{Centrode, Rolling};
use geardyn::internals::gear::plane::second_contact::second_contacts;
use geardyn::internals::numeric::Complex;

use crate::verification::within;

const R1: f64 = 0.05;
const R2: f64 = 0.1;

fn rolling(tool: f64, work: f64) -> Rolling {
    Rolling {
        tool: Centrode::circle(tool).unwrap(),
        work: Centrode::circle(work).unwrap(),
    }
}

/// Largest turn between a curve's points and a cycloid with its cusp free, of both hands the smaller.
fn off_cycloid(base: f64, rolling: f64, points: &[Complex]) -> f64 {
    let sum = base + rolling;
    let shape = Shape::cycloid(base, rolling, 0.0, [-20.0, 20.0]).unwrap();
    let spread = |side: f64| {
        let turn = |z: &Complex| {
            // |z|² = (R + r)² + r² − 2 r (R + r) cos x, x = θ R/r.
            let cos = (sum * sum + rolling * rolling - z.norm_sqr()) / (2.0 * rolling * sum);
            let theta = side * cos.clamp(-1.0, 1.0).acos() * rolling / base;
            (z / shape.jet(theta).unwrap().point).arg()
        };
        let first = turn(&points[0]);
        let apart = |z: &Complex| {
            let turns = (turn(z) - first) / TAU;
            (turns - turns.round()).abs() * TAU
        };
        points.iter().map(apart).fold(0.0, f64::max)
    };
    spread(1.0).min(spread(-1.0))
}

/// A point carried by a third circle that rolls inside gear 2 and outside gear 1 makes an epicycloid on one and a hypocycloid on the other;
/// they touch at the same instant in the same place, at the law's ratio to rounding.
#[test]
fn exact_camus_cycloidal_pair() {
    let rho = 0.015;
    let point = Shape::arc(Complex::new(-rho, 0.0), 0.0, [-1.2, -0.15]).unwrap();
    let on_1 = conjugate(&rolling(-rho, R1), point.clone(), 60).unwrap();
    let on_2 = conjugate(&rolling(-rho, -R2), point, 60).unwrap();
    let points = |c: &[geardyn::internals::gear::plane::contact::Contact]| {
        c.iter().map(|c| c.work_point).collect::<Vec<_>>()
    };
    within(
        "epicycloid",
        off_cycloid(R1, rho, &points(on_1.contacts())),
        1e-12,
    );
    within(
        "hypocycloid",
        off_cycloid(R2, -rho, &points(on_2.contacts())),
        1e-12,
    );
    for (a, b) in on_1.contacts().iter().zip(on_2.contacts()) {
        assert_eq!(a.arc, b.arc);
        within(
            "same place",
            (a.path_point - b.path_point).norm() / R1,
            1e-15,
        );
    }
    let law = RatioLaw::constant(R2 / R1).unwrap();
    let pair = Centrodes::of_gears(&law, R1 + R2, Mate::External).unwrap();
    let arcs: Vec<f64> = on_1.contacts().iter().map(|c| c.arc).collect();
    let angles: Vec<f64> = arcs[8..50].iter().map(|s| s / R1).collect();
    for check in check_gearing(&pair, &on_1, &on_2, &angles).unwrap() {
        within("transmission error", check.error.abs(), 1e-14);
        within(
            "miss of the pitch point",
            check.pitch_point_deviation.abs() / R1,
            1e-11,
        );
    }
}

/// Gerotor: the outer rotor's pins, carried by its own pitch circle, make the inner rotor, whose profile is the parallel of an epitrochoid
/// and touches every pin at once.
#[test]
fn exact_camus_gerotor() {
    let (teeth, eccentricity, distance, radius) = (4.0, 0.003, 0.022, 0.008);
    let (outer, inner) = ((teeth + 1.0) * eccentricity, teeth * eccentricity);
    let pin = Shape::arc(Complex::new(distance, 0.0), radius, [PI - 1.4, PI + 1.4]).unwrap();
    let rotor = conjugate(&rolling(outer, inner), pin, 400).unwrap();
    let centre = |arc: f64| {
        let state = rolling(outer, inner).at(arc).unwrap();
        state.to_work(Complex::new(distance, 0.0))
    };
    for c in rotor.contacts() {
        let off = (c.work_point - centre(c.arc)).norm() / radius - 1.0;
        within("parallel of the epitrochoid", off.abs(), 1e-13);
        let trochoid = (centre(c.arc + 1e-6) - centre(c.arc - 1e-6)) / 2e-6;
        let along = (trochoid * c.work_tangent.conj()).im / trochoid.norm();
        within("its tangent", along.abs(), 1e-8);
    }
    // The rotor's flanks, a quarter turn apart, against five pins at ten turns: none enters a pin, and the pins near the pitch point touch.
    let mut touched = 0;
    for turn in 0..10 {
        let state = rolling(outer, inner)
            .at(0.1 * outer * f64::from(turn))
            .unwrap();
        for pin in 0..5 {
            let at = Complex::cis(TAU * f64::from(pin) / 5.0) * distance;
            let at = state.to_work(at);
            let gaps = rotor.contacts().iter().flat_map(|c| {
                (0..4).map(move |k| {
                    (c.work_point * Complex::cis(TAU * f64::from(k) / 4.0) - at).norm() / radius
                        - 1.0
                })
            });
            let least = gaps.fold(f64::MAX, f64::min);
            assert!(least > -1e-12, "pin {pin} entered by {least}");
            touched += usize::from(least < 1e-5);
        }
    }
    assert!(touched >= 10, "{touched} touches");
}

/// Double generation of cycloids: a hypocycloid of gear 2 by ρ touches its generator again on the circle R₂ − ρ, an epicycloid on R₂ + ρ;
/// the second envelope is the cycloid of that circle on gear 1.
#[test]
fn exact_second_envelope_of_cycloids() {
    let rho = 0.015;
    for (sign, second) in [(1.0, R2 - rho), (-1.0, R2 + rho)] {
        let tool = Shape::cycloid(R1, sign * rho, 0.0, [0.05, 0.6]).unwrap();
        let generated = conjugate(&rolling(R1, -R2), tool, 30).unwrap();
        let contacts = second_contacts(&generated).unwrap();
        assert_eq!(contacts.len(), generated.contacts().len());
        let on_tool: Vec<Complex> = contacts.iter().map(|c| c.tool_point).collect();
        within("second envelope", off_cycloid(R1, second, &on_tool), 1e-11);
        for c in &contacts {
            let off = (c.path_point + Complex::new(0.0, second)).norm() / second - 1.0;
            within("second line of action", off.abs(), 1e-12);
            assert!((c.arc - c.first.arc).abs() > 1e-6);
        }
    }
}

/// Second contacts by normals against the kernel's roots of `f(x)/(x − first)` under the reversed motion, on circles and on ellipses.
#[test]
fn exact_second_contacts_by_the_kernel() {
    let law = RatioLaw::elliptic(0.2).unwrap();
    let pair = Centrodes::of_gears(&law, 0.1, Mate::External).unwrap();
    // The kernel's tool reaches beyond the ends, so that it finds the roots there.
    let arc = |x: f64| {
        [[0.6, 1.1], [0.59, 1.11]]
            .map(|range| Shape::arc(Complex::new(x, 0.0), 0.012, range).unwrap())
    };
    let cases = [
        (rolling(R1, -R2), arc(0.96 * R1), [-0.4, 0.4]),
        (Rolling::of_pair(&pair), arc(0.055), [-6.0, 6.0]),
    ];
    for (motion, [tool, wide], range) in cases {
        let generated = conjugate(&motion, tool, 12).unwrap();
        let first = envelope(&motion, wide, range).unwrap();
        let back = Envelope {
            motion: first.motion.inverse(),
            surface: first,
            range,
        };
        let by_angle = matches!(motion.tool, Centrode::Member { .. });
        let parameter = |arc: f64| {
            if by_angle {
                pair.angle_at_arc(arc).unwrap()
            } else {
                arc
            }
        };
        for contact in second_contacts(&generated).unwrap() {
            let (x, second) = (parameter(contact.first.arc), parameter(contact.arc));
            let roots = back.second_contacts([x, 0.0], x);
            let nearest = roots
                .iter()
                .map(|r| (r - second).abs())
                .fold(f64::MAX, f64::min);
            within(
                "place of the second contact",
                nearest / (range[1] - range[0]),
                1e-11,
            );
        }
    }
}

/// Both contacts meet at the limit of the second kind.
#[test]
fn law_contacts_meet_at_the_second_limit() {
    let at = |x: f64| Complex::new(x, 0.2 * R1);
    let tool = Shape::line(at(0.9 * R1), at(1.1 * R1)).unwrap();
    let generated = conjugate(&rolling(R1, -R2), tool, 400).unwrap();
    let limit = limits(&generated).points[0];
    let seconds = second_contacts(&generated).unwrap();
    let apart: Vec<f64> = seconds
        .iter()
        .map(|c| (c.tool_point - c.first.tool_point).norm())
        .collect();
    let near = |c: &geardyn::internals::gear::plane::second_contact::SecondContact| {
        (c.first.parameter - limit.parameter).abs()
    };
    let nearest = seconds
        .iter()
        .map(near)
        .enumerate()
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap()
        .0;
    let farthest = seconds
        .iter()
        .map(near)
        .enumerate()
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap()
        .0;
    assert!(
        apart[nearest] < 0.2 * apart[farthest],
        "{} {}",
        apart[nearest],
        apart[farthest]
    );
}

fn involute(base: f64, is_rising: bool, pitch_radius: f64, towards: f64) -> Shape {
    let alpha = (base / pitch_radius).acos();
    let hand = if is_rising { 1.0 } else { -1.0 };
    let start = towards - hand * (alpha.tan() - alpha);
    Shape::involute(base, start, is_rising, [0.02, 0.9]).unwrap()
}

/// Involutes keep the ratio of their base circles at another centre distance, cycloids do not; the ratio from the normal is the derivative of
/// the turn.
#[test]
fn exact_law_of_gearing_at_another_distance() {
    let cos = 20_f64.to_radians().cos();
    let law = RatioLaw::constant(2.0).unwrap();
    let angles: Vec<f64> = (0..=20).map(|i| -0.05 + 0.01 * f64::from(i)).collect();
    for stretch in [1.0, 1.01, 1.03] {
        let pair = Centrodes::of_gears(&law, (R1 + R2) * stretch, Mate::External).unwrap();
        let (base_1, base_2) = (R1 * cos, R2 * cos);
        let gear_1 = involute(base_1, true, R1 * stretch, 0.0);
        let gear_2 = involute(base_2, true, R2 * stretch, PI);
        let checks = check_gearing(&pair, &gear_1, &gear_2, &angles).unwrap();
        for check in &checks {
            within("error of involutes", check.error.abs(), 1e-14);
            within("ratio of involutes", (check.ratio / 2.0 - 1.0).abs(), 1e-12);
        }
    }
    let rho = 0.015;
    let tool = Shape::cycloid(R1, rho, 0.0, [0.02, 0.8]).unwrap();
    let generated = conjugate(&rolling(R1, -R2), tool.clone(), 60).unwrap();
    let arcs: Vec<f64> = generated.contacts().iter().map(|c| c.arc / R1).collect();
    let step = (arcs[45] - arcs[25]) / 30.0;
    let angles: Vec<f64> = (0..=30).map(|i| arcs[25] + step * f64::from(i)).collect();
    for (stretch, least, most) in [(1.0, 0.0, 1e-14), (1.002, 1e-6, 1e-2)] {
        let pair = Centrodes::of_gears(&law, (R1 + R2) * stretch, Mate::External).unwrap();
        let checks = check_gearing(&pair, &tool, &generated, &angles).unwrap();
        let errors: Vec<f64> = checks.iter().map(|c| c.error).collect();
        let span = errors.iter().fold(f64::MIN, |m, x| m.max(*x))
            - errors.iter().fold(f64::MAX, |m, x| m.min(*x));
        assert!((least..=most).contains(&span), "{stretch}: {span}");
        for three in checks.windows(3) {
            let slope = 0.5 + (three[2].error - three[0].error) / (2.0 * step);
            within(
                "ratio from the turn",
                (slope * three[1].ratio - 1.0).abs(),
                2e-5,
            );
        }
    }
}

/// Random sane cases: normals pass the pitch point, the conjugate of the conjugate is the tool, curvature keeps Euler–Savary, nothing is NaN.
#[test]
fn law_random_conjugates() {
    let mut random = fastrand::Rng::with_seed(21);
    let mut between = |a: f64, b: f64| a + (b - a) * random.f64();
    let (mut whole, mut refused, mut worst) = (0, 0, 0.0_f64);
    for case in 0..2000 {
        let r1 = between(0.01, 0.2);
        let work = match case % 4 {
            0 => Centrode::circle(r1 * between(1.3, 6.0)),
            1 => Ok(Centrode::Line),
            _ => Centrode::circle(-r1 * between(0.3, 5.0)),
        };
        let motion = Rolling {
            tool: Centrode::circle(r1).unwrap(),
            work: work.unwrap(),
        };
        let tool = match case % 3 {
            0 => {
                let alpha = between(0.2, 0.5);
                let start = between(0.05, 0.3);
                Shape::involute(
                    r1 * f64::cos(alpha),
                    between(-1.0, 1.0),
                    case % 2 == 0,
                    [start, start + between(0.05, 0.4)],
                )
            }
            1 => {
                let lean = between(-0.6, 0.6);
                let centre = Complex::cis(between(-3.0, 3.0)) * r1 * between(0.75, 0.96);
                Shape::arc(
                    centre,
                    r1 * between(0.02, 0.4),
                    [lean, lean + between(0.05, 0.5)],
                )
            }
            _ => Shape::cycloid(
                r1,
                r1 * between(0.1, 0.6),
                between(-3.0, 3.0),
                [between(0.02, 0.1), between(0.15, 0.8)],
            ),
        }
        .unwrap();
        let generated = match conjugate(&motion, tool, 12) {
            Ok(generated) => generated,
            Err(error) => {
                refused += 1;
                assert!(!error.message.contains("NaN"), "{error}");
                continue;
            }
        };
        let bounds = limits(&generated);
        assert!(bounds.usable[0] <= bounds.usable[1]);
        let back = generated.rolling().reversed();
        for c in generated.contacts() {
            let through = (c.path_point.norm() - c.normal_distance.abs()).abs() / r1;
            worst = worst.max(through);
            let values = [
                c.arc,
                c.work_point.re,
                c.work_point.im,
                c.normal_distance,
                c.tool_speed,
                c.work_speed,
            ];
            assert!(values.iter().all(|x| x.is_finite()), "case {case}: {c:?}");
            // Carried back by the reversed motion the generated point touches at the same arc.
            let state = back.at(c.arc).unwrap();
            let again = (state.to_work(c.work_point) - c.tool_point).norm() / r1;
            worst = worst.max(again);
        }
        whole += 1;
    }
    within("normals through the pitch point, and back", worst, 1e-11);
    assert!(whole > 1700, "{whole} whole, {refused} refused");
}

/// The conjugate of a conjugate is the tool's profile, with its curvature, also on elliptic centrodes.
#[test]
fn law_conjugate_of_the_conjugate() {
    let elliptic = RatioLaw::elliptic(0.2).unwrap();
    let pair = Centrodes::of_gears(&elliptic, 0.1, Mate::External).unwrap();
    let tools = [
        (
            rolling(R1, -R2),
            Shape::arc(Complex::new(0.95 * R1, 0.0), 0.012, [0.4, 1.1]).unwrap(),
        ),
        (
            rolling(R1, 3.0 * R1),
            Shape::arc(Complex::new(0.95 * R1, 0.0), 0.012, [0.4, 1.1]).unwrap(),
        ),
        (
            Rolling::of_pair(&pair),
            Shape::arc(Complex::new(0.055, 0.0), 0.012, [0.4, 1.1]).unwrap(),
        ),
    ];
    for (motion, tool) in tools {
        let generated = conjugate(&motion, tool, 25).unwrap();
        let contacts = generated.contacts().to_vec();
        let again = conjugate(&motion.reversed(), generated, 25).unwrap();
        assert_eq!(again.contacts().len(), contacts.len());
        for (a, b) in contacts.iter().zip(again.contacts()) {
            within("arc again", (a.arc - b.arc).abs() / R1, 1e-11);
            within(
                "point again",
                (a.tool_point - b.work_point).norm() / R1,
                1e-12,
            );
            within(
                "curvature again",
                (a.tool_curvature / b.work_curvature - 1.0).abs(),
                1e-8,
            );
        }
    }
}
