//! Ratio laws and centrodes: closed forms, worked examples, rolling without slip, refusals.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use geardyn::internals::gear::plane::centrodes::{Centrodes, Mate, Member};
use geardyn::internals::gear::plane::pitch_curve::PitchCurve;
use geardyn::internals::gear::plane::ratio_law::RatioLaw;
use geardyn::internals::numeric::quadrature;

use crate::verification::{order, printed, within};

/// Laws of every kind, at a centre distance of 0.1 m.
fn laws() -> Vec<(&'static str, RatioLaw, f64)> {
    let oval = PitchCurve::ellipse(0.04, 0.3, 2).unwrap();
    let a = oval.closing_centre_distance(2).unwrap();
    let angles: Vec<f64> = (0..=72).map(|i| TAU * f64::from(i) / 72.0).collect();
    let mates: Vec<f64> = angles.iter().map(|x| x + 0.2 * x.sin()).collect();
    vec![
        ("constant", RatioLaw::constant(1.7).unwrap(), 0.1),
        ("linear", RatioLaw::linear(2.0, 0.5, 1.5 * PI).unwrap(), 0.1),
        ("elliptic", RatioLaw::elliptic(0.3).unwrap(), 0.1),
        ("sine", RatioLaw::sine(1.25, 0.75, 2).unwrap(), 0.1),
        ("table", RatioLaw::table(&angles, &mates).unwrap(), 0.1),
        ("oval", RatioLaw::of_pitch_curve(&oval, a).unwrap(), a),
    ]
}

/// Centrodes for a ratio falling linearly with the angle from 2 to 1/2 over 270°, a = 100 mm.
///
/// Source: worked example of a gear handbook, recomputed: `φ₂ = −ln(1 − K φ₁/i₀)/K`, K = 0.3183098862.
#[test]
fn ref_linear_ratio() {
    let law = RatioLaw::linear(2.0, 0.5, 1.5 * PI).unwrap();
    let pair = Centrodes::of_gears(&law, 0.1, Mate::External).unwrap();
    let at = |degrees: f64| pair.at(degrees.to_radians()).unwrap();
    let half = at(135.0);
    printed("r1 at 135 deg", "mm", 44.4444, 1e3 * half.radius_1, 5e-5);
    let r2 = 1e3 * (0.1 - half.radius_1);
    printed("r2 at 135 deg", "mm", 55.5556, r2, 5e-5);
    let phi_2 = half.angle_2.to_degrees();
    printed("φ2 at 135 deg", "deg", 84.600653, phi_2, 5e-7);
    let phi_2 = at(270.0).angle_2.to_degrees();
    printed("φ2 at 270 deg", "deg", 249.532985, phi_2, 5e-7);
    assert!(pair.at(4.8).is_none() && pair.at(-0.1).is_none());
    assert!(pair.closed_arc(Member::First).is_err());
}

/// Two equal ellipses about foci, A = 50 mm, e = 0.3.
///
/// Source: case c21, closed form.
#[test]
fn ref_elliptic_centrodes() {
    let law = RatioLaw::elliptic(0.3).unwrap();
    let pair = Centrodes::of_gears(&law, 100e-3, Mate::External).unwrap();
    let rows = [
        (
            30.0,
            61.47050591062476,
            52.91170584317537,
            1.5954143017822715,
        ),
        (
            60.0,
            53.529411764705884,
            93.99217611435438,
            1.1518987341772153,
        ),
        (90.0, 45.5, 123.39848846798726, 0.8348623853211009),
        (
            150.0,
            36.11662545666747,
            163.58000321198116,
            0.565352499219798,
        ),
    ];
    for (phi, r1, phi_2, rate) in rows {
        let state = pair.at(f64::to_radians(phi)).unwrap();
        let relative = |x: f64, y: f64| (x / y - 1.0).abs();
        within("radius r1", relative(1e3 * state.radius_1, r1), 1e-14);
        within(
            "angle of gear 2",
            relative(state.angle_2.to_degrees(), phi_2),
            1e-14,
        );
        let ratio = law.at(f64::to_radians(phi)).unwrap().ratio;
        within("dφ2/dφ1", relative(ratio.recip(), rate), 1e-14);
    }
}

/// The ellipse of the law and the ellipse given as a pitch curve are one: the distance that closes the mate is 2A, and for a mate of n lobes
/// `A (1 + √(n² − e²(n² − 1)))`; curvature at both apexes is A/b².
#[test]
fn exact_ellipse_and_its_mates() {
    let curve = PitchCurve::ellipse(0.05, 0.3, 1).unwrap();
    for n in 1..=5_u32 {
        let square = f64::from(n * n);
        let exact = 0.05 * (1.0 + (square - 0.09 * (square - 1.0)).sqrt());
        let a = curve.closing_centre_distance(n).unwrap();
        within(
            "centre distance from closure",
            (a / exact - 1.0).abs(),
            1e-14,
        );
        RatioLaw::of_pitch_curve(&curve, a)
            .unwrap()
            .check_closed()
            .unwrap();
    }
    let by_law =
        Centrodes::of_gears(&RatioLaw::elliptic(0.3).unwrap(), 0.1, Mate::External).unwrap();
    let by_curve = RatioLaw::of_pitch_curve(&curve, 0.1).unwrap();
    let by_curve = Centrodes::of_gears(&by_curve, 0.1, Mate::External).unwrap();
    for i in 0..40 {
        let x = -7.0 + 0.5 * f64::from(i);
        let (p, q) = (by_law.at(x).unwrap(), by_curve.at(x).unwrap());
        within("angle of gear 2", (p.angle_2 - q.angle_2).abs(), 1e-13);
        within("radius", (p.radius_1 - q.radius_1).abs() / 0.1, 1e-15);
        within(
            "curvature 2",
            (p.curvatures[1] / q.curvatures[1] - 1.0).abs(),
            1e-12,
        );
    }
    let apex = 1.0 / (0.05 * (1.0 - 0.09));
    let extremes = by_law.curvature_extremes(Member::First);
    within(
        "curvature at the apex",
        (extremes.largest[0] / apex - 1.0).abs(),
        1e-12,
    );
    let flat = (1.0_f64 - 0.09).sqrt() / 0.05;
    within(
        "curvature at the minor axis",
        (extremes.least[0] / flat - 1.0).abs(),
        1e-12,
    );
}

/// Eccentric circle: curvature 1/R everywhere, arc 2πR.
#[test]
fn exact_eccentric_circle() {
    let circle = PitchCurve::eccentric_circle(0.03, 0.01).unwrap();
    let a = circle.closing_centre_distance(2).unwrap();
    let law = RatioLaw::of_pitch_curve(&circle, a).unwrap();
    let pair = Centrodes::of_gears(&law, a, Mate::External).unwrap();
    for i in 0..20 {
        let state = pair.at(0.4 * f64::from(i)).unwrap();
        within("curvature", (0.03 * state.curvatures[0] - 1.0).abs(), 1e-13);
    }
    let arc = pair.closed_arc(Member::First).unwrap();
    within("arc of a turn", (arc / (TAU * 0.03) - 1.0).abs(), 1e-14);
    let arc = pair.closed_arc(Member::Second).unwrap();
    within(
        "arc of the mate",
        (arc / (2.0 * TAU * 0.03) - 1.0).abs(),
        1e-12,
    );
}

/// A rack on an eccentric circle of eccentricity e: its centrode advances by the integral of r, and the arc is 2πR in a turn.
#[test]
fn exact_rack_on_an_eccentric_circle() {
    let circle = PitchCurve::eccentric_circle(0.03, 0.01).unwrap();
    let pair = Centrodes::of_rack(&circle);
    let state = pair.at(TAU).unwrap();
    // ∫√(R² − e² sin²φ)dφ over a turn is the perimeter of an ellipse with axes R and √(R² − e²): 64-point sums converge exponentially.
    let sum: f64 = (0..64)
        .map(|i| (9e-4 - 1e-4 * (TAU * f64::from(i) / 64.0).sin().powi(2)).sqrt())
        .sum();
    within(
        "travel in a turn",
        (state.travel / (sum * TAU / 64.0) - 1.0).abs(),
        1e-14,
    );
    for i in 0..20 {
        let x = -3.0 + 0.5 * f64::from(i);
        let (origin, _) = pair.pose(Member::Second, &pair.at(x).unwrap());
        let slip = pair.at(x).unwrap();
        // The rack's centrode through differences of its points.
        let point = |x: f64| {
            let s = pair.at(x).unwrap();
            (s.radius_1, s.travel)
        };
        let (h, (x0, y0)) = (1e-5, point(x - 1e-5));
        let (x1, y1) = point(x + h);
        let rate = (x1 - x0).hypot(y1 - y0) / (2.0 * h);
        within(
            "arc rate of the rack",
            (rate / slip.arc_rate - 1.0).abs(),
            1e-9,
        );
        assert_eq!(origin.im, -slip.travel);
    }
}

/// Rolling without slip: arcs of both centrodes by separate integrals agree, external and internal; in the fixed frame both pass the pitch point
/// with one tangent.
#[test]
fn exact_centrodes_roll_without_slip() {
    for (name, law, a) in laws() {
        for mate in [Mate::External, Mate::Internal] {
            let Ok(pair) = Centrodes::of_gears(&law, a, mate) else {
                assert_eq!(mate, Mate::Internal, "{name}");
                continue;
            };
            let side = if mate == Mate::External { 1.0 } else { -1.0 };
            for i in 1..30 {
                let x = 0.155 * f64::from(i);
                // Arc of centrode 2 over its own angle: r₂ and dr₂/dφ₂ by the law alone.
                let second = |x: f64| {
                    let s = law.at(x).unwrap();
                    let r2 = a * s.ratio / (s.ratio + side);
                    let slope = side * a * s.slope / (s.ratio + side).powi(2) * s.ratio;
                    r2.hypot(slope) / s.ratio
                };
                let parts = 200;
                let at = |k: i32| x * f64::from(k) / f64::from(parts);
                let arc_2: f64 = (0..parts)
                    .map(|k| quadrature::panel(second, at(k), at(k + 1)))
                    .sum();
                within(
                    &format!("slip of the centrodes, {name}"),
                    (arc_2 - pair.arc(x)).abs() / a,
                    1e-12,
                );
                let back = pair.angle_at_arc(pair.arc(x)).unwrap();
                within("angle from arc", (back - x).abs(), 1e-12);
            }
        }
    }
}

/// The tabled law `φ₂ = φ₁ + 0.2 sin φ₁` approaches its closed form with the order of the spline: 6 for the angle, 4 for the curvature.
#[test]
fn order_of_a_tabled_ratio() {
    let errors = |rows: u32| {
        let angles: Vec<f64> = (0..=rows)
            .map(|i| TAU * f64::from(i) / f64::from(rows))
            .collect();
        let mates: Vec<f64> = angles.iter().map(|x| x + 0.2 * x.sin()).collect();
        let law = RatioLaw::table(&angles, &mates).unwrap();
        let mut worst = [0.0_f64; 2];
        for i in 0..500 {
            let x = TAU * f64::from(i) / 500.0;
            let s = law.at(x).unwrap();
            let rate = 1.0 + 0.2 * x.cos();
            let second =
                2.0 * (0.2 * x.sin() / rate).powi(2) / rate + 0.2 * x.cos() / (rate * rate);
            worst[0] = worst[0].max((s.angle_2 - x - 0.2 * x.sin()).abs());
            worst[1] = worst[1].max((s.second - second).abs());
        }
        worst
    };
    let (coarse, fine) = (errors(18), errors(36));
    order("angle of a tabled law", 6.0, (coarse[0] / fine[0]).log2());
    order(
        "second derivative of its ratio",
        3.0,
        (coarse[1] / fine[1]).log2(),
    );
}

/// A sine law closes where `cycles √(mean² − amplitude²)` is whole, and the advice of the refusal closes.
#[test]
fn exact_sine_closes() {
    let law = RatioLaw::sine(1.25, 0.75, 2).unwrap();
    law.check_closed().unwrap();
    let [period, advance] = law.period().unwrap();
    within("period", (period - PI).abs(), 0.0);
    within("advance in a period", (advance - PI).abs(), 1e-15);
    let error = RatioLaw::sine(1.3, 0.75, 2)
        .unwrap()
        .check_closed()
        .unwrap_err();
    let hint = error.hint.unwrap();
    let mean: f64 = hint.rsplit(' ').next().unwrap().parse().unwrap();
    RatioLaw::sine(mean, 0.75, 2)
        .unwrap()
        .check_closed()
        .unwrap();
    let quarter = law.at(FRAC_PI_2).unwrap();
    within(
        "half a period",
        (quarter.angle_2 - quadrature_of_sine(FRAC_PI_2)).abs(),
        1e-14,
    );
}

fn quadrature_of_sine(to: f64) -> f64 {
    let f = |x: f64| 1.0 / (1.25 + 0.75 * (2.0 * x).sin());
    let at = |k: i32| to * f64::from(k) / 32.0;
    (0..32)
        .map(|k| quadrature::panel(f, at(k), at(k + 1)))
        .sum()
}

/// Refusals name the row, the value and the remedy.
#[test]
fn refuses_laws_that_cannot_be() {
    let turn = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, TAU];
    let says = |error: geardyn::internals::base::error::Error, text: &str| {
        let all = error.to_string();
        assert!(all.contains(text), "{all}");
    };
    let mut down = turn;
    down[3] = 1.9;
    says(
        RatioLaw::table(&turn, &down).unwrap_err(),
        "row 4: angle 108.861981 deg of gear 2 does not rise",
    );
    says(
        RatioLaw::table(&down, &turn).unwrap_err(),
        "row 4: angle 108.861981 deg does not rise",
    );
    let short = turn.map(|x| 0.9 * x);
    says(
        RatioLaw::table(&turn, &short).unwrap_err(),
        "row 7: gear 2 turns",
    );
    says(
        RatioLaw::table(&short, &turn).unwrap_err(),
        "row 7: the angles span",
    );
    let steep = [0.0, 0.01, 0.02, 0.03, 6.0, 6.01, TAU];
    says(
        RatioLaw::table(&turn, &steep).unwrap_err(),
        "falls between them",
    );
    let mut bad = turn;
    bad[2] = f64::NAN;
    says(
        RatioLaw::table(&turn, &bad).unwrap_err(),
        "row 3: not a finite number",
    );
    says(RatioLaw::sine(1.0, 1.0, 1).unwrap_err(), "reaches its mean");
    says(RatioLaw::constant(0.0).unwrap_err(), "must be positive");
    says(RatioLaw::elliptic(1.0).unwrap_err(), "below 1");
    let law = RatioLaw::constant(0.8).unwrap();
    says(
        Centrodes::of_gears(&law, 0.1, Mate::Internal).unwrap_err(),
        "i12 must exceed 1",
    );
    says(
        Centrodes::of_gears(&law, -0.1, Mate::External).unwrap_err(),
        "must be positive",
    );
    let mut radii = [0.05; 7];
    PitchCurve::table(&turn, &radii).unwrap();
    radii[6] = 0.051;
    says(
        PitchCurve::table(&turn, &radii).unwrap_err(),
        "row 7: radius 51 mm after one turn",
    );
    let curve = PitchCurve::ellipse(0.05, 0.3, 1).unwrap();
    says(
        RatioLaw::of_pitch_curve(&curve, 0.06).unwrap_err(),
        "does not exceed the largest radius",
    );
    let law = RatioLaw::of_pitch_curve(&curve, 0.11).unwrap();
    says(law.check_closed().unwrap_err(), "does not close");
}

/// Random laws, sane and not: an answer without NaN, or a refusal.
#[test]
fn survives_random_laws() {
    let mut random = fastrand::Rng::with_seed(7);
    let odd = [0.0, -1.0, 1e-300, 1e300, f64::NAN, f64::INFINITY, 1.0];
    let (mut built, mut refused) = (0, 0);
    for case in 0..2000 {
        let mut number = |a: f64, b: f64| match random.u32(0..20) {
            0 => odd[random.usize(0..odd.len())],
            _ => a + (b - a) * random.f64(),
        };
        let law = match case % 6 {
            0 => RatioLaw::constant(number(0.1, 10.0)),
            1 => RatioLaw::linear(number(0.2, 3.0), number(0.2, 3.0), number(0.5, 20.0)),
            2 => RatioLaw::elliptic(number(0.0, 0.9)),
            3 => RatioLaw::sine(number(0.5, 3.0), number(-0.4, 0.4), case % 5),
            4 => {
                let rows = 8 + case % 30;
                let at = |i: u32| TAU * f64::from(i) / f64::from(rows);
                let angles: Vec<f64> = (0..=rows).map(at).collect();
                let wave = number(-0.2, 0.2);
                let mates: Vec<f64> = angles.iter().map(|x| x + wave * (2.0 * x).sin()).collect();
                RatioLaw::table(&angles, &mates)
            }
            _ => PitchCurve::ellipse(number(0.01, 1.0), number(0.0, 0.6), case % 4).and_then(
                |curve| {
                    let a = curve.closing_centre_distance(case % 3)?;
                    RatioLaw::of_pitch_curve(&curve, a)
                },
            ),
        };
        let mate = if case % 5 == 0 {
            Mate::Internal
        } else {
            Mate::External
        };
        let pair = law.and_then(|law| Centrodes::of_gears(&law, number(0.01, 1.0), mate));
        let Ok(pair) = pair else {
            refused += 1;
            continue;
        };
        built += 1;
        for _ in 0..4 {
            let x = number(-10.0, 10.0);
            let Some(s) = pair.at(x) else { continue };
            let values = [
                s.angle_2,
                s.radius_1,
                s.radius_slope,
                s.arc_rate,
                s.tangent_angle,
                s.curvatures[0],
                s.curvatures[1],
            ];
            assert!(
                values.iter().all(|v| v.is_finite()),
                "case {case}, {x}: {s:?}"
            );
            if x.abs() < 20.0 {
                let back = pair.angle_at_arc(pair.arc(x)).unwrap();
                assert!((back - x).abs() < 1e-9, "case {case}: {x} {back}");
            }
        }
    }
    assert!(built > 1200 && refused > 100, "{built} {refused}");
}
