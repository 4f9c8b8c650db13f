//! Readings of a gear: pitch, run-out, traces, tooth thickness, and how the uncertainty of readings reaches the values.

use std::f64::consts::TAU;

use crate::support::verification::{printed, within};
use geardyn::internals::base::code::Code;
use geardyn::internals::gear::cylindrical::involute::{InvoluteGear, angle_from_inv, inv};
use geardyn::internals::gear::cylindrical::modification::Modification;
use geardyn::internals::gear::measurement::pitch::{PitchDeviations, PitchMethod, default_span};
use geardyn::internals::gear::measurement::runout;
use geardyn::internals::gear::measurement::tooth_thickness::ThicknessMethod;
use geardyn::internals::gear::measurement::trace;

fn near(found: f64, expected: f64, tolerance: f64) {
    within("values, absolute", (found - expected).abs(), tolerance);
}

/// Normal deviates of variance 1, always the same.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn next(&mut self) -> f64 {
        let (u, v) = (self.uniform().max(1e-300), self.uniform());
        (-2.0 * u.ln()).sqrt() * (TAU * v).cos()
    }
}

/// Mean and standard deviation of `value` over readings with noise.
fn scatter(readings: &[f64], std: f64, value: impl Fn(&[f64]) -> f64) -> f64 {
    let mut noise = Noise(88172645463325252);
    let runs = 4000;
    let found: Vec<f64> = (0..runs)
        .map(|_| {
            let noisy: Vec<f64> = readings.iter().map(|r| r + std * noise.next()).collect();
            value(&noisy)
        })
        .collect();
    let mean = found.iter().sum::<f64>() / runs as f64;
    (found.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / runs as f64).sqrt()
}

/// 4000 runs tell a standard deviation to 1.1 %; four of those.
const SCATTER: f64 = 0.045;

const READINGS: [f64; 18] = [
    3.0, -2.0, 1.0, 0.0, -4.0, 2.0, 5.0, -1.0, -3.0, 2.0, 0.0, 1.0, -2.0, 4.0, -1.0, -3.0, 0.0,
    -2.0,
];

/// Eighteen readings whose answers are known: f_p 5, F_p 8, F_p2 7, f_u 6; by either method, whatever the comparator was set to.
/// Source: worked example of 18 pitch readings.
#[test]
fn ref_pitch_by_both_methods() {
    let mut sum = 0.0;
    let index: Vec<f64> = READINGS
        .iter()
        .map(|f| {
            sum += f;
            sum - f + 11.0
        })
        .collect();
    let shifted: Vec<f64> = READINGS.iter().map(|f| f + 30.0).collect();
    for (readings, method) in [
        (&READINGS[..], PitchMethod::Comparator),
        (&shifted, PitchMethod::Comparator),
        (&index, PitchMethod::Index),
    ] {
        let pitches = PitchDeviations::new(readings, method, 18, Some(0.5)).unwrap();
        near(pitches.single_pitch().estimate.value, 5.0, 1e-14);
        assert_eq!(pitches.single_pitch().first, 6);
        near(pitches.cumulative_total().estimate.value, 8.0, 1e-13);
        near(
            pitches.span_deviation(default_span(18)).estimate.value,
            7.0,
            1e-13,
        );
        near(pitches.adjacent().estimate.value, 6.0, 1e-14);
        assert_eq!(pitches.cumulative.last(), Some(&0.0));
        assert_eq!(pitches.flank_positions().len(), 18);
    }
    assert_eq!(default_span(18), 2);
    assert_eq!(default_span(40), 5);
}

/// Sums over k pitches and differences of neighbours wrap round the gear.
#[test]
fn exact_pitch_wraps_round() {
    let readings = [5.0, -1.0, -3.0, -3.0, -3.0, 5.0];
    let pitches = PitchDeviations::new(&readings, PitchMethod::Comparator, 6, None).unwrap();
    let over = pitches.span_deviation(2);
    near(over.estimate.value, 10.0, 1e-14);
    assert_eq!((over.first, over.end), (5, 7));
    let few = PitchDeviations::new(&[3.0, 0.0, -3.0], PitchMethod::Comparator, 3, None).unwrap();
    near(few.adjacent().estimate.value, 6.0, 1e-15);
    assert_eq!(few.adjacent().first, 2);
    assert_eq!(few.single_pitch().estimate.std, None);
}

/// A first flank read again at the end tells the drift, which is taken off evenly.
#[test]
fn exact_drift() {
    let true_places = [0.0, 3.0, -1.0, 2.0];
    let readings: Vec<f64> = (0..5)
        .map(|i| true_places[i % 4] + 0.8 * i as f64 / 4.0)
        .collect();
    let pitches = PitchDeviations::new(&readings, PitchMethod::Index, 4, None).unwrap();
    near(pitches.drift, 0.8, 1e-15);
    for (found, expected) in pitches.flank_positions().iter().zip(true_places) {
        near(*found, expected, 1e-15);
    }
}

/// Stated uncertainties against many runs with noisy readings, for both methods.
#[test]
fn law_pitch_uncertainty_is_the_scatter() {
    // One pitch, one sum, one difference well ahead of the others, so that noise does not choose another.
    let mut single = vec![0.0; 24];
    (single[3], single[4], single[15]) = (20.0, -30.0, 10.0);
    let places: Vec<f64> = (0..24).map(|i| single[..i].iter().sum()).collect();
    let u = 0.6;
    for (method, readings) in [
        (PitchMethod::Comparator, single),
        (PitchMethod::Index, places),
    ] {
        let of = |r: &[f64]| PitchDeviations::new(r, method, 24, Some(u)).unwrap();
        let check = |value: &dyn Fn(&PitchDeviations) -> f64, stated: f64| {
            let found = scatter(&readings, u, |r| value(&of(r)));
            assert!(
                (found / stated - 1.0).abs() < SCATTER,
                "{method:?}: {found} stated {stated}"
            );
        };
        let stated = of(&readings);
        check(
            &|p| p.single_pitch().estimate.value,
            stated.single_pitch().estimate.std.unwrap(),
        );
        check(
            &|p| p.adjacent().estimate.value,
            stated.adjacent().estimate.std.unwrap(),
        );
        check(
            &|p| p.span_deviation(4).estimate.value,
            stated.span_deviation(4).estimate.std.unwrap(),
        );
        let both = |p: &PitchDeviations| p.flank_positions()[9] - p.flank_positions()[2];
        check(&both, stated.std_over(7).unwrap());
    }
}

/// A gear whose teeth sit eccentric by e: F_r = 2e by the ball; F_p = 2e/cos α; both sides' pitches give the same run-out and place.
#[test]
fn exact_eccentric_gear() {
    let (z, e, at, alpha) = (36, 15e-6, 0.7, 20f64.to_radians());
    let angle = |i: usize| TAU * i as f64 / z as f64;
    let ball: Vec<f64> = (0..z).map(|i| e * (angle(i) - at).cos()).collect();
    let from_ball = runout::from_ball(&ball, z, Some(1e-6)).unwrap();
    near(from_ball.range.value, 2.0 * e, 0.004 * e);
    near(from_ball.eccentricity.value, e, 1e-18);
    near(from_ball.phase, at, 1e-12);
    near(from_ball.remainder, 0.0, 1e-18);
    // Moved by e, a flank stands e_t ± e_r tan α further on: left sides lag where right sides lead.
    let places = |side: f64| -> Vec<f64> {
        (0..z)
            .map(|i| e * (at - angle(i)).sin() + side * alpha.tan() * e * (angle(i) - at).cos())
            .collect()
    };
    let side =
        |s: f64| PitchDeviations::new(&places(s), PitchMethod::Index, z, Some(1e-6)).unwrap();
    let (left, right) = (side(-1.0), side(1.0));
    near(
        left.cumulative_total().estimate.value,
        2.0 * e / alpha.cos(),
        0.008 * e,
    );
    let found = runout::from_pitches(&left, &right, alpha).unwrap();
    near(found.eccentricity.value, e, 1e-17);
    near(found.phase, at, 1e-10);
    near(found.range.value, from_ball.range.value, 1e-17);
}

/// Uncertainty of the eccentricity and run-out from both sides against the scatter, by both methods.
#[test]
fn law_runout_uncertainty_is_the_scatter() {
    let (z, alpha, u) = (20, 20f64.to_radians(), 0.3);
    let wave: Vec<f64> = (0..z)
        .map(|i| 40.0 * (TAU * i as f64 / z as f64).cos())
        .collect();
    let pitches: Vec<f64> = (0..z).map(|i| wave[(i + 1) % z] - wave[i]).collect();
    for (readings, method) in [
        (&wave, PitchMethod::Index),
        (&pitches, PitchMethod::Comparator),
    ] {
        let evaluated = |noisy: &[f64]| {
            let (l, r) = noisy.split_at(z);
            let side = |r: &[f64]| PitchDeviations::new(r, method, z, Some(u)).unwrap();
            runout::from_pitches(&side(l), &side(r), alpha).unwrap()
        };
        let mirrored: Vec<f64> = readings.iter().map(|x| -x).collect();
        let both = [&readings[..], &mirrored].concat();
        let stated = evaluated(&both).eccentricity.std.unwrap();
        let found = scatter(&both, u, |r| evaluated(r).eccentricity.value);
        assert!(
            (found / stated - 1.0).abs() < SCATTER,
            "{method:?}: {found} stated {stated}"
        );
    }
}

/// A straight inclined trace with one bump: slope, form and total are known; the slope is told over the reach asked.
#[test]
fn exact_trace() {
    let along: Vec<f64> = (0..101).map(|i| 1e-4 * f64::from(i)).collect();
    let tilted: Vec<f64> = along.iter().map(|x| 1e-6 + 4e-4 * x).collect();
    let found = trace::fit_mean_line(&along, &tilted, (1e-3, 9e-3), 10e-3, Some(1e-7)).unwrap();
    near(found.total.value, 3.2e-6, 1e-18);
    near(found.slope.value, 4e-6, 1e-18);
    near(found.form.value, 0.0, 1e-18);
    near(found.height_at(0.0), 1e-6, 1e-18);
    // A cubic over [−1, 1]: its line has slope 3/5, and about it the extremes are 4/(5√5)·½ each side and at the ends 2/5.
    let n = 4001;
    let along: Vec<f64> = (0..n)
        .map(|i| 2.0 * f64::from(i) / f64::from(n - 1) - 1.0)
        .collect();
    let cubic: Vec<f64> = along.iter().map(|x| x.powi(3)).collect();
    let found = trace::fit_mean_line(&along, &cubic, (-1.0, 1.0), 2.0, None).unwrap();
    near(found.slope.value, 1.2, 2e-3);
    near(found.form.value, 0.8, 2e-3);
    near(found.total.value, 2.0, 1e-12);
    assert_eq!(found.slope.std, None);
}

#[test]
fn law_trace_uncertainty_is_the_scatter() {
    let along: Vec<f64> = (0..60).map(|i| 0.2 * f64::from(i)).collect();
    let design: Vec<f64> = along
        .iter()
        .map(|x| if *x > 9.0 { -4.0 * (x - 9.0) } else { 0.1 * x } + if *x == 4.0 { 9.0 } else { 0.0 })
        .collect();
    let u = 0.2;
    let line = |r: &[f64]| trace::fit_mean_line(&along, r, (1.0, 9.0), 11.0, Some(u)).unwrap();
    let relief = |r: &[f64]| trace::tip_relief(&along, r, (1.0, 9.0), false, Some(u)).unwrap();
    let stated = line(&design);
    for (found, stated) in [
        (
            scatter(&design, u, |r| line(r).slope.value),
            stated.slope.std.unwrap(),
        ),
        (
            scatter(&design, u, |r| relief(r).value),
            relief(&design).std.unwrap(),
        ),
    ] {
        assert!(
            (found / stated - 1.0).abs() < SCATTER,
            "{found} stated {stated}"
        );
    }
    // Of a range the lower end is free to move to where noise is lowest: the first order is an upper estimate here.
    let found = scatter(&design, u, |r| line(r).form.value);
    assert!(found < 1.05 * stated.form.std.unwrap() && found > 0.6 * stated.form.std.unwrap());
}

/// Profiles with designed crowning and slope: form and slope deviations are those put in.
#[test]
fn exact_designs() {
    let relief = Modification::Relief {
        from: 6.0,
        to: 10.0,
        amount: 8.0,
    };
    assert_eq!(
        [5.0, 6.0, 8.0, 10.0, 11.0].map(|x| relief.deviation_at(x)),
        [0.0, 0.0, -4.0, -8.0, -8.0]
    );
    let root = Modification::Relief {
        from: 3.0,
        to: 1.0,
        amount: 2.0,
    };
    assert_eq!(
        [1.0, 2.0, 4.0].map(|x| root.deviation_at(x)),
        [-2.0, -1.0, 0.0]
    );
    let crown = Modification::Crowning {
        from: 0.0,
        to: 20.0,
        amount: 5.0,
    };
    assert_eq!(
        [0.0, 10.0, 15.0, 20.0].map(|x| crown.deviation_at(x)),
        [-5.0, 0.0, -1.25, -5.0]
    );
}

#[test]
fn refuses_readings_without_sense() {
    let pitch = |r: &[f64], method, z| PitchDeviations::new(r, method, z, None).unwrap_err();
    let error = pitch(&[0.0; 17], PitchMethod::Comparator, 18);
    assert_eq!(error.code, Code::OutOfRange);
    assert!(error.message.contains("17") && error.message.contains("18"));
    assert_eq!(
        pitch(&[0.0; 19], PitchMethod::Comparator, 18).code,
        Code::OutOfRange
    );
    assert_eq!(
        pitch(&[0.0; 2], PitchMethod::Index, 2).code,
        Code::OutOfRange
    );
    let error = pitch(&[0.0, f64::NAN, 1.0], PitchMethod::Index, 3);
    assert_eq!(error.code, Code::NotANumber);
    assert!(error.message.contains("reading 2"));
    assert!(PitchDeviations::new(&[0.0; 19], PitchMethod::Index, 18, None).is_ok());
    assert_eq!(
        runout::from_ball(&[0.0; 4], 5, None).unwrap_err().code,
        Code::OutOfRange
    );
    let line = |x: &[f64], y: &[f64]| {
        trace::fit_mean_line(x, y, (0.0, 9.0), 9.0, None)
            .unwrap_err()
            .code
    };
    assert_eq!(line(&[0.0, 1.0, 1.0, 2.0], &[0.0; 4]), Code::OutOfRange);
    assert_eq!(line(&[0.0, 1.0, 2.0], &[0.0; 4]), Code::OutOfRange);
    assert_eq!(line(&[0.0, 1.0, 12.0], &[0.0; 3]), Code::TooShort);
    assert_eq!(
        line(&[0.0, 1.0, 2.0], &[0.0, f64::INFINITY, 0.0]),
        Code::NotANumber
    );
}

fn spur(teeth: u32, module: f64, shift: f64) -> InvoluteGear {
    InvoluteGear {
        teeth,
        module,
        pressure_angle: 20f64.to_radians(),
        helix: 0.0,
        profile_shift: shift,
        internal: false,
    }
}

/// Handbook examples: span, chord, constant chord; a report of a planetary stage: span and dimension over balls.
/// Source: Kohara Gear Industry, Gear technical reference; a KISSsoft 03/2017 report of a planetary stage.
#[test]
fn ref_sizes() {
    let plain = spur(24, 1.0, 0.0);
    printed(
        "z 24, m 1: span over 3",
        "mm",
        7.716462,
        plain.span(3, plain.nominal_thickness()),
        5e-7,
    );
    assert_eq!(plain.default_span_teeth(), 3);
    let tip = 26.0;
    let chord = ThicknessMethod::Chord(tip).nominal(&plain).unwrap();
    printed("z 24, m 1: chord", "mm", 1.569675, chord.size, 5e-7);
    printed(
        "z 24, m 1: height of the chord",
        "mm",
        1.025693,
        chord.height.unwrap(),
        5e-7,
    );
    let constant = ThicknessMethod::ConstantChord(tip).nominal(&plain).unwrap();
    printed(
        "z 24, m 1: constant chord",
        "mm",
        1.387048,
        constant.size,
        5e-7,
    );
    printed(
        "z 24, m 1: height of the constant chord",
        "mm",
        0.747578,
        constant.height.unwrap(),
        5e-7,
    );
    let shifted = spur(24, 3.0, 0.4);
    assert_eq!(shifted.default_span_teeth(), 4);
    printed(
        "z 24, m 3, x 0.4: span over 4",
        "mm",
        32.8266,
        shifted.span(4, shifted.nominal_thickness()),
        5e-5,
    );
    let ten = spur(12, 10.0, 0.3);
    printed(
        "z 12, m 10, x 0.3: thickness",
        "mm",
        17.8918,
        ten.nominal_thickness(),
        5e-5,
    );
    let chord = ThicknessMethod::Chord(146.0).nominal(&ten).unwrap();
    printed("z 12, m 10, x 0.3: chord", "mm", 17.8256, chord.size, 5e-5);
    printed(
        "z 12, m 10, x 0.3: height of the chord",
        "mm",
        13.6657,
        chord.height.unwrap(),
        1e-4,
    );
    for (gear, k, ball, span, over) in [
        (spur(18, 21.0, 0.389), 3, 45.0, 165.869, 466.306),
        (spur(36, 21.0, 0.5039), 5, 40.0, 296.803, 836.492),
    ] {
        let (by_span, by_balls) = (ThicknessMethod::Span(k), ThicknessMethod::Balls(ball));
        let found = [by_span, by_balls].map(|method| method.nominal(&gear).unwrap().size);
        printed(&format!("m 21: span over {k}"), "mm", span, found[0], 6e-4);
        printed(
            &format!("m 21: over balls of {ball} mm"),
            "mm",
            over,
            found[1],
            6e-3,
        );
    }
}

/// Every way tells the same thinning, which their readings were made from exactly.
#[test]
fn law_every_way_tells_the_same_thickness() {
    for (teeth, helix) in [(25, 0.0), (40, 0.3), (12, 0.5)] {
        let gear = InvoluteGear {
            helix,
            ..spur(teeth, 3e-3, 0.2)
        };
        let tip = gear.reference_diameter() + 2.0 * 1.2 * gear.module;
        let thin = -90e-6;
        let s = gear.nominal_thickness() + thin;
        let k = gear.default_span_teeth();
        let ball = 1.75 * gear.module;
        let readings = [
            (ThicknessMethod::Span(k), gear.span(k, s), 1e-15),
            (
                ThicknessMethod::Balls(ball),
                gear.dimension_over_balls(ball, s),
                1e-13,
            ),
            // A chord is set at the nominal height, so what it tells is right to the second order.
            (
                ThicknessMethod::Chord(tip),
                gear.chordal_thickness(tip, s).0,
                2e-8,
            ),
            (
                ThicknessMethod::ConstantChord(tip),
                gear.constant_chord(tip, s).0,
                1e-15,
            ),
        ];
        for (method, reading, tolerance) in readings {
            let found = method
                .thickness_deviation(&gear, reading, Some(1e-6))
                .unwrap();
            near(found.value, thin, tolerance);
            // What the gauge's uncertainty becomes, by moving the reading.
            let moved = method
                .thickness_deviation(&gear, reading + 1e-6, None)
                .unwrap();
            near(found.std.unwrap(), moved.value - found.value, 2e-9);
        }
    }
}

#[test]
fn law_involute_and_back() {
    for angle in [1e-8, 1e-4, 0.1, 0.35, 1.0, 1.5, 1.57] {
        let back = angle_from_inv(inv(angle));
        // Where the series end, tan α − α has lost two digits.
        near(back / angle, 1.0, 64.0 * f64::EPSILON);
    }
    assert_eq!(angle_from_inv(0.0), 0.0);
    assert!(angle_from_inv(-1e-3).is_nan() && angle_from_inv(f64::NAN).is_nan());
}

#[test]
fn refuses_gauges_that_do_not_fit() {
    let gear = spur(24, 3e-3, 0.0);
    let nominal = |method: ThicknessMethod| method.nominal(&gear).unwrap_err();
    assert!(
        nominal(ThicknessMethod::Span(12))
            .hint
            .unwrap()
            .contains('3')
    );
    assert_eq!(nominal(ThicknessMethod::Span(0)).code, Code::OutOfRange);
    assert_eq!(
        nominal(ThicknessMethod::Balls(0.1e-3)).code,
        Code::OutOfRange
    );
    assert_eq!(
        nominal(ThicknessMethod::Chord(60e-3)).code,
        Code::OutOfRange
    );
    // Millimetres taken for metres.
    let wrong = ThicknessMethod::Span(3)
        .thickness_deviation(&gear, 23.1, None)
        .unwrap_err();
    assert!(wrong.hint.unwrap().contains("unit"));
    let none = ThicknessMethod::Span(3)
        .thickness_deviation(&gear, f64::NAN, None)
        .unwrap_err();
    assert_eq!(none.code, Code::NotANumber);
}

fn ring(teeth: u32, module: f64, shift: f64) -> InvoluteGear {
    InvoluteGear {
        internal: true,
        ..spur(teeth, module, shift)
    }
}

/// Between pins of 1.7 mm on an internal spur gear of 40 teeth, module 1 (Kohara Gear Industry, Gear technical reference, internal spur
/// gears: 37.5951 mm).
/// Source: Kohara Gear Industry, Gear technical reference.
#[test]
fn ref_between_pins() {
    let gear = ring(40, 1.0, 0.0);
    let between = gear.dimension_over_balls(1.7, gear.nominal_thickness());
    printed("between pins", "mm", 37.5951, between, 5e-5);
    let found = ThicknessMethod::Balls(1.7).nominal(&gear).unwrap();
    near(found.size, 37.5951, 5e-5);
}

/// What gauges read on an internal gear, found from points of its flanks: the tooth's half angle grows outward, `ψ = s/d − inv α + inv α_r`.
#[test]
fn exact_gauges_on_internal_flanks() {
    for (teeth, shift) in [(40, 0.0), (41, 0.3), (77, -0.2)] {
        let gear = ring(teeth, 3.0, shift);
        let s = gear.nominal_thickness() - 0.08;
        let (d, base) = (gear.reference_diameter(), gear.base_diameter());
        let tau = TAU;
        let alpha = gear.transverse_pressure_angle();
        let half_tooth = |r: f64| s / d - inv(alpha) + inv((0.5 * base / r).acos());
        let half_space = |r: f64| tau / 2.0 / f64::from(teeth) - half_tooth(r);
        let radii = |f: &dyn Fn(f64) -> f64| -> f64 {
            (1..200_000)
                .map(|i| f(0.5 * base + 2.0 * 3.0 * 2.2 * f64::from(i) / 200_000.0))
                .fold(f64::INFINITY, f64::min)
        };
        // A ball on the axis of a space: the distance from its centre to the flank is its radius.
        let ball = 1.65 * 3.0;
        let over = gear.dimension_over_balls(ball, s);
        let centre = 0.5 * (over + ball)
            / match teeth % 2 {
                0 => 1.0,
                _ => (tau / 4.0 / f64::from(teeth)).cos(),
            };
        let away = |r: f64| {
            let at = half_space(r);
            (r * at.cos() - centre).hypot(r * at.sin())
        };
        near(radii(&away), 0.5 * ball, 1e-7);
        near(gear.thickness_from_balls(ball, over), s, 1e-9);
        // A span over k spaces: along a tangent of the base circle, from the flank of the first space to that of the last.
        let k = gear.default_span_teeth();
        let inside = 0.5 * f64::from(k - 1) * tau / f64::from(teeth);
        let span = gear.span(k, s);
        let r = (0.5 * base).hypot(0.5 * span);
        // The middle of the spaces lies on the axis; the tangent is across it, and touches the flank where it is that wide.
        near(r * (inside + half_space(r)).sin(), 0.5 * span, 1e-9);
        assert!(
            (r - (0.5 * d - 3.0 * shift)).abs() <= 3.0,
            "near the pitch circle: {r}"
        );
        // Chords, seen from the tip, which lies inward.
        let tip = d - 2.0 * 3.0;
        let (chord, height) = gear.chordal_thickness(tip, s);
        near(chord, d * half_tooth(0.5 * d).sin(), 1e-12);
        near(
            height,
            0.5 * d * half_tooth(0.5 * d).cos() - 0.5 * tip,
            1e-12,
        );
        // The constant chord lies on the flank, and the flank's normal there passes the pitch point.
        let (chord, height) = gear.constant_chord(tip, s);
        let y = 0.5 * tip + height;
        let r = (0.5 * chord).hypot(y);
        let normal = (0.5 * d - y) / (0.5 * chord);
        near(normal, gear.pressure_angle.tan(), 1e-12);
        near((0.5 * chord / y).atan(), half_tooth(r), 1e-12);
    }
}

/// Every way tells the same thinning of an internal gear, which their readings were made from exactly.
#[test]
fn law_every_way_tells_the_thickness_of_a_ring() {
    let gear = ring(61, 3e-3, 0.2);
    let thin = -90e-6;
    let s = gear.nominal_thickness() + thin;
    let tip = gear.reference_diameter() - 2.0 * gear.module;
    let (k, ball) = (gear.default_span_teeth(), 1.7 * gear.module);
    for (method, reading, tolerance) in [
        (ThicknessMethod::Span(k), gear.span(k, s), 1e-15),
        (
            ThicknessMethod::Balls(ball),
            gear.dimension_over_balls(ball, s),
            1e-13,
        ),
        (
            ThicknessMethod::Chord(tip),
            gear.chordal_thickness(tip, s).0,
            2e-8,
        ),
        (
            ThicknessMethod::ConstantChord(tip),
            gear.constant_chord(tip, s).0,
            1e-15,
        ),
    ] {
        let found = method
            .thickness_deviation(&gear, reading, Some(1e-6))
            .unwrap();
        near(found.value, thin, tolerance);
        let moved = method
            .thickness_deviation(&gear, reading + 1e-6, None)
            .unwrap();
        near(found.std.unwrap(), (moved.value - found.value).abs(), 2e-9);
    }
    // Thinner teeth leave more between the balls and over the spaces.
    assert!(gear.span(k, s) > gear.span(k, gear.nominal_thickness()));
    assert!(
        gear.dimension_over_balls(ball, s)
            > gear.dimension_over_balls(ball, gear.nominal_thickness())
    );
    let helical = InvoluteGear { helix: 0.2, ..gear };
    let refused = ThicknessMethod::Span(k).nominal(&helical).unwrap_err();
    assert!(refused.hint.unwrap().contains("balls"));
    assert!(ThicknessMethod::Balls(ball).nominal(&helical).is_ok());
    let outside = ThicknessMethod::Chord(gear.reference_diameter() + 6e-3)
        .nominal(&gear)
        .unwrap_err();
    assert!(outside.hint.unwrap().contains("below"));
}

/// The tip of an internal gear is where the roll is shortest.
#[test]
fn exact_relief_of_an_internal_tip() {
    let along: Vec<f64> = (0..=20).map(|i| 10.0 + 0.5 * f64::from(i)).collect();
    let trace: Vec<f64> = along.iter().map(|x| -4e-3 * (12.0 - x).max(0.0)).collect();
    let found = trace::tip_relief(&along, &trace, (12.0, 20.0), true, None).unwrap();
    near(found.value, 8e-3, 1e-15);
}
