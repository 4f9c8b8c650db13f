//! Reversal of readings of unknown gears.

use std::f64::consts::PI;

use crate::verification::{printed, within};
use geardyn::internals::base::code::Code;
use geardyn::internals::gear::cylindrical::basic_rack::BasicRack;
use geardyn::internals::gear::cylindrical::involute::InvoluteGear;
use geardyn::internals::gear::cylindrical::member::Member;
use geardyn::internals::gear::cylindrical::pair::Pair;
use geardyn::internals::gear::cylindrical::reverse::candidate::Candidate;
use geardyn::internals::gear::cylindrical::reverse::confusion::Remedy;
use geardyn::internals::gear::cylindrical::reverse::readings::{
    GearReadings, MateReadings, Reading, SpanReading,
};
use geardyn::internals::gear::cylindrical::reverse::standard_sizes::ToothSize;

fn reading(value: f64, std: f64) -> Reading {
    Reading { value, std }
}

/// Spans of a gear over the usual number of teeth and one more, its teeth thinned by a deviation, with noise in standard uncertainties.
fn spans(gear: &InvoluteGear, deviation: f64, std: f64, noise: [f64; 2]) -> Vec<SpanReading> {
    let k = gear.default_span_teeth();
    let span = |i: usize| {
        let k = k + i as u32;
        let size = gear.span(k, gear.nominal_thickness() + deviation) + std * noise[i];
        SpanReading {
            k,
            size: reading(size, std),
        }
    };
    vec![span(0), span(1)]
}

fn spur(teeth: u32, module: f64, pressure_angle: f64, profile_shift: f64) -> InvoluteGear {
    InvoluteGear {
        teeth,
        module,
        pressure_angle: pressure_angle.to_radians(),
        helix: 0.0,
        profile_shift,
        internal: false,
    }
}

fn plain(gear: &InvoluteGear, std: f64) -> GearReadings {
    GearReadings {
        teeth: gear.teeth,
        internal: gear.internal,
        spans: spans(gear, 0.0, std, [0.0; 2]),
        tip_diameter: None,
        root_diameter: None,
        tip_helix: None,
        thickness_deviation: Some(0.0),
        mate: None,
    }
}

fn is(candidate: &Candidate, size: ToothSize, angle: f64) -> bool {
    candidate.size == size && (candidate.gear.pressure_angle.to_degrees() - angle).abs() < 1e-9
}

/// Pairs of standards whose base pitches nearly coincide are left open by spans, with what would part them.
/// Source: near-coincidences of metric and diametral-pitch standards, recomputed: 0.51, 1.0, 4.0, 7.0 and 7.9 µm.
#[test]
fn ref_near_coincidences() {
    use ToothSize::{DiametralPitch, Module};
    let rows = [
        (Module(1.75), 20.0, DiametralPitch(14.0), 25.0, 0.51, 0.005),
        (Module(3.5), 20.0, DiametralPitch(7.0), 25.0, 1.0, 0.05),
        (Module(1.25), 17.5, DiametralPitch(20.0), 20.0, 4.0, 0.05),
        (Module(1.0), 14.5, Module(1.0), 15.0, 7.0, 0.05),
        (Module(2.5), 17.5, DiametralPitch(10.0), 20.0, 7.9, 0.05),
    ];
    for (size, angle, twin, twin_angle, apart, digit) in rows {
        let Module(m) = size else { unreachable!() };
        let gear = spur(40, 1e-3 * m, angle, 0.1);
        let mut readings = plain(&gear, 3e-6);
        let found = readings.reverse().unwrap();
        let index = |size, angle| found.candidates.iter().position(|c| is(c, size, angle));
        assert!(
            is(&found.candidates[0], size, angle),
            "{size:?}: {:?}",
            found.candidates
        );
        let other = index(twin, twin_angle).unwrap();
        let confusion = found
            .ambiguities
            .iter()
            .find(|c| c.candidates == [0, other])
            .unwrap();
        printed(
            &format!("{size:?} and {twin:?}"),
            "µm",
            apart,
            1e6 * confusion.base_pitch_difference,
            digit,
        );
        // The reading named first puts the twin behind.
        let member = Member::new(gear, BasicRack::PROFILE_A, 0.01);
        match confusion.remedies[0] {
            Remedy::Spans { teeth, std, .. } => {
                let over = |k: u32| SpanReading {
                    k,
                    size: reading(gear.span(k, gear.nominal_thickness()), std),
                };
                readings.spans = teeth.map(over).to_vec();
            }
            Remedy::TipDiameter(_) => {
                readings.tip_diameter = Some(reading(member.tip_diameter(), 1e-5))
            }
            Remedy::RootDiameter(_) => {
                readings.root_diameter = Some(reading(member.root_diameter(0.1), 1e-5))
            }
        }
        let found = readings.reverse().unwrap();
        assert!(is(&found.candidates[0], size, angle));
        let behind = |i: usize| !is(&found.candidates[i], twin, twin_angle);
        assert!(
            found.ambiguities.iter().all(|c| behind(c.candidates[1])),
            "{:?}",
            found.ambiguities
        );
        readings.tip_diameter = Some(reading(member.tip_diameter(), 1e-5));
        readings.root_diameter = Some(reading(member.root_diameter(0.1), 1e-5));
        let found = readings.reverse().unwrap();
        assert!(is(&found.candidates[0], size, angle));
        let best = &found.candidates[0];
        within("x_E", (best.generating_shift.value - 0.1).abs(), 1e-10);
        within("h_aP", (best.addendum.unwrap()[0] - 1.0).abs(), 1e-10);
        within("c*", (best.clearance().unwrap() - 0.25).abs(), 1e-10);
    }
}

/// A thinned tooth: spans give x_E, and x only with the allowance assumed.
#[test]
fn exact_shift_needs_the_allowance() {
    let gear = spur(30, 2e-3, 20.0, 0.2);
    let deviation = -60e-6;
    let over = |k: u32| SpanReading {
        k,
        size: reading(gear.span(k, gear.nominal_thickness() + deviation), 1e-6),
    };
    let mut readings = plain(&gear, 1e-6);
    readings.thickness_deviation = None;
    readings.spans = vec![over(3), over(5)];
    let generating = 0.2 + deviation / (2.0 * 2e-3 * gear.pressure_angle.tan());
    let blind = readings.reverse().unwrap().candidates.swap_remove(0);
    within(
        "x_E",
        (blind.generating_shift.value - generating).abs(),
        1e-10,
    );
    assert_eq!(blind.profile_shift(), None);
    // The tip is that of x: of two unknown values one usual coefficient leaves one.
    let member = Member::new(gear, BasicRack::PROFILE_A, 0.01);
    let tip = member.tip_diameter();
    readings.tip_diameter = Some(reading(tip, 1e-5));
    let of_tip = readings.reverse().unwrap().candidates.swap_remove(0);
    within(
        "allowance from the tip, µm",
        1e6 * (of_tip.thickness_deviation.unwrap() - deviation).abs(),
        1e-6,
    );
    readings.tip_diameter = None;
    readings.thickness_deviation = Some(deviation);
    let told = readings.reverse().unwrap().candidates.swap_remove(0);
    within(
        "x with the allowance",
        (told.profile_shift().unwrap() - 0.2).abs(),
        1e-10,
    );
}

/// The mate's spans narrow the candidates, and with the centre distance they give the backlash.
#[test]
fn exact_mate_and_backlash() {
    let [first, second] = [spur(24, 3e-3, 20.0, 0.3), spur(53, 3e-3, 20.0, -0.1)];
    let members = [first, second].map(|gear| Member::new(gear, BasicRack::PROFILE_A, 0.02));
    let pair = Pair::new(members, None).unwrap();
    let centre = pair.centre_distance + 50e-6;
    let mut readings = plain(&first, 2e-6);
    readings.mate = Some(MateReadings {
        teeth: 53,
        internal: false,
        spans: spans(&second, 0.0, 2e-6, [0.0; 2]),
        centre_distance: Some(reading(centre, 5e-6)),
    });
    let best = readings.reverse().unwrap().candidates.swap_remove(0);
    assert!(is(&best, ToothSize::Module(3.0), 20.0), "{best:?}");
    within(
        "shift of the mate",
        (best.mate_shift.unwrap() + 0.1).abs(),
        1e-10,
    );
    let backlash = pair.backlash(centre, [0.0; 2]).unwrap().normal;
    within(
        "normal backlash, µm",
        1e6 * (best.backlash.unwrap() - backlash).abs(),
        1e-6,
    );
    // Without its spans the mate's shift follows from the centre distance as if there were no backlash.
    readings.mate = Some(MateReadings {
        teeth: 53,
        internal: false,
        spans: Vec::new(),
        centre_distance: Some(reading(pair.centre_distance, 5e-6)),
    });
    let best = readings.reverse().unwrap().candidates.swap_remove(0);
    within(
        "shift from the centre distance",
        (best.mate_shift.unwrap() + 0.1).abs(),
        1e-10,
    );
}

/// Random gears with allowances as for any gear with backlash, stated or not.
fn check_reversals(count: usize, seed: u64, is_stated: bool) {
    let mut rng = fastrand::Rng::with_seed(seed);
    let (mut first, mut total) = (0, 0);
    while total < count {
        let metric = rng.f64() < 0.7;
        let (size, module) = if metric {
            let m = [
                0.5, 1.0, 1.25, 1.75, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 8.0, 10.0, 16.0,
            ][rng.usize(0..14)];
            (ToothSize::Module(m), 1e-3 * m)
        } else {
            let p = [
                2.0, 3.0, 4.0, 5.0, 7.0, 8.0, 10.0, 12.0, 14.0, 16.0, 20.0, 32.0,
            ][rng.usize(0..12)];
            (ToothSize::DiametralPitch(p), 0.0254 / p)
        };
        let angle = [14.5, 15.0, 17.5, 20.0, 22.5, 25.0][rng.usize(0..6)];
        let internal = rng.f64() < 0.2;
        let helical = !internal && rng.bool();
        let gear = InvoluteGear {
            helix: if helical {
                f64::to_radians(5.0 + 30.0 * rng.f64())
            } else {
                0.0
            },
            internal,
            ..spur(
                rng.u32(if internal { 50..120 } else { 12..100 }),
                module,
                angle,
                rng.f64() - 0.3,
            )
        };
        let rack = [BasicRack::PROFILE_A, BasicRack::PROFILE_D][rng.usize(0..2)];
        let mut member = Member::new(gear, rack, 0.01);
        // A reading of noise within two standard uncertainties.
        let mut noise = || 4.0 * rng.f64() - 2.0;
        let std = 1e-6 + 5e-4 * module;
        let deviation = -f64::min(0.1 * module, 150e-6) * 0.25 * (noise() + 2.0);
        let spans = spans(&gear, deviation, std, [noise(), noise()]);
        let tip = member.tip_diameter();
        let has_tip = helical || noise() > 0.0;
        let has_root = noise() > 0.0;
        let at_tip = (gear.helix.tan() * tip / gear.reference_diameter()).atan();
        let helix_std = 5e-4;
        let readings = GearReadings {
            teeth: gear.teeth,
            internal,
            spans,
            tip_diameter: has_tip.then(|| reading(tip + 10e-6 * noise(), 10e-6)),
            root_diameter: has_root.then(|| {
                reading(
                    member.root_diameter(member.generating_shift(deviation)) + 20e-6 * noise(),
                    20e-6,
                )
            }),
            tip_helix: helical.then(|| reading(at_tip + helix_std * noise(), helix_std)),
            thickness_deviation: is_stated.then_some(deviation),
            mate: None,
        };
        member.tip_diameter = Some(tip);
        total += 1;
        let found = readings.reverse().unwrap();
        let Some(index) = found.candidates.iter().position(|c| is(c, size, angle)) else {
            panic!("{size:?} {angle} lost: {readings:?}\n{found:?}");
        };
        first += usize::from(index == 0);
        // Noise of two standard uncertainties in up to four readings.
        let left = found.candidates[index].misfit - found.candidates[0].misfit;
        assert!(index == 0 || left < 16.0, "{size:?} {angle}: {found:?}");
        let truth = &found.candidates[index];
        let tolerance = 4.0 * truth.generating_shift.std + if helical { 0.05 } else { 0.0 };
        let generating = member.generating_shift(deviation);
        assert!(
            (truth.generating_shift.value - generating).abs() < tolerance,
            "{gear:?} {truth:?}"
        );
        let x = truth
            .profile_shift()
            .map(|x| (x - gear.profile_shift).abs());
        assert_eq!(x.is_some(), is_stated || has_tip);
        assert!(!is_stated || x < Some(tolerance), "{gear:?} {truth:?}");
        for c in &found.ambiguities {
            let [a, b] = c.candidates.map(|i| &found.candidates[i]);
            assert!(b.misfit - a.misfit < 9.0);
            for remedy in &c.remedies {
                // Anvils reach the flanks of the gear named first, whose size the readings give within their noise.
                if let (Remedy::Spans { teeth, .. }, true, true) = (remedy, index == 0, has_tip) {
                    let roll = |k: u32| 0.5 * gear.span(k, gear.nominal_thickness());
                    let touched = teeth
                        .map(|k| gear.diameter_at_roll(roll(k) * gear.base_helix_angle().cos()));
                    let root = member.root_diameter(generating);
                    let inside = |d: f64| (d - root) * (d - tip) < 0.1 * module * tip;
                    assert!(touched.into_iter().all(inside), "{gear:?} {teeth:?}");
                }
            }
            let pitch = |c: &Candidate| PI * c.gear.module * c.gear.pressure_angle.cos();
            assert!((c.base_pitch_difference - (pitch(a) - pitch(b)).abs()).abs() < 1e-18);
        }
    }
    println!("first in {first} of {total}");
    // Where the allowance is open, more gears fit alike.
    let least = if is_stated { 8 } else { 5 };
    assert!(10 * first > least * total, "{first} of {total}");
}

/// Over 2 000 random thinned gears with noisy readings the measured gear is among the candidates, and behind the first by no more than the
/// noise.
#[test]
fn law_measured_gear_is_a_candidate() {
    check_reversals(1000, 31, true);
    check_reversals(1000, 33, false);
}

#[test]
#[ignore = "minutes: 1e5 random gears"]
fn law_many_measured_gears() {
    check_reversals(50_000, 32, true);
    check_reversals(50_000, 34, false);
}

/// A tip turned for x over teeth cut with x_E does not speak against the gear: its readings fit without a stated allowance.
#[test]
fn exact_thinned_gears_fit_their_readings() {
    for (teeth, x, helix, deviation) in [
        (41, 0.5, 0.0, -150e-6),
        (31, 0.2, 18f64.to_radians(), -100e-6),
        (25, -0.1, 0.0, -30e-6),
    ] {
        let gear = InvoluteGear {
            helix,
            ..spur(teeth, 3e-3, 20.0, x)
        };
        let member = Member::new(gear, BasicRack::PROFILE_A, 0.03);
        let tip = member.tip_diameter();
        let root = member.root_diameter(member.generating_shift(deviation));
        let at_tip = (helix.tan() * tip / gear.reference_diameter()).atan();
        let readings = GearReadings {
            spans: spans(&gear, deviation, 4e-6, [0.0; 2]),
            tip_diameter: Some(reading(tip, 20e-6)),
            root_diameter: Some(reading(root, 20e-6)),
            tip_helix: (helix != 0.0).then_some(reading(at_tip, 1e-3)),
            thickness_deviation: None,
            ..plain(&gear, 4e-6)
        };
        let found = readings.reverse().unwrap();
        let index = found
            .candidates
            .iter()
            .position(|c| is(c, ToothSize::Module(3.0), 20.0))
            .unwrap();
        let truth = &found.candidates[index];
        within("misfit", truth.misfit, 1e-12);
        within("x", (truth.profile_shift().unwrap() - x).abs(), 1e-10);
        let first = found.candidates[0].misfit;
        assert!(
            index == 0 || found.ambiguities.iter().any(|c| c.candidates == [0, index]),
            "{first}: {:?}",
            found.candidates
        );
    }
}

/// Spans that no common reading of the gear can take are not advised: anvils over 14 of 30 teeth would pass the tips.
#[test]
fn exact_advised_spans_touch_the_flanks() {
    let gear = spur(30, 1.25e-3, 17.5, 0.1);
    let mut readings = plain(&gear, 4e-6);
    readings.tip_diameter = Some(reading(
        Member::new(gear, BasicRack::PROFILE_A, 0.01).tip_diameter(),
        20e-6,
    ));
    let found = readings.reverse().unwrap();
    let advised = found.ambiguities.iter().flat_map(|c| &c.remedies);
    let spans: Vec<[u32; 2]> = advised
        .filter_map(|remedy| match remedy {
            Remedy::Spans { teeth, .. } => Some(*teeth),
            _ => None,
        })
        .collect();
    // W_k² + d_b² ≤ d_a² of the gear: k up to 5.
    assert!(
        !spans.is_empty() && spans.iter().all(|k| *k == [2, 5]),
        "{spans:?}"
    );
}

#[test]
fn refuses_readings_that_do_not_determine_a_gear() {
    let gear = spur(30, 2e-3, 20.0, 0.0);
    let code = |change: &dyn Fn(&mut GearReadings)| {
        let mut readings = plain(&gear, 1e-6);
        change(&mut readings);
        let error = readings.reverse().unwrap_err();
        (error.code, error.hint.is_some())
    };
    assert_eq!(code(&|r| r.spans.truncate(1)), (Code::IllPosed, true));
    assert_eq!(code(&|r| r.spans.clear()), (Code::IllPosed, true));
    assert_eq!(
        code(&|r| r.tip_helix = Some(reading(0.2, 1e-3))),
        (Code::IllPosed, true)
    );
    assert_eq!(
        code(&|r| r.spans[0].size.value = f64::NAN),
        (Code::OutOfRange, false)
    );
    assert_eq!(
        code(&|r| r.spans[1].size.std = 0.0),
        (Code::OutOfRange, false)
    );
    assert_eq!(
        code(&|r| r.spans[1].size.value += 0.7e-3),
        (Code::NoConvergence, true)
    );
}

/// Of a helical gear u²(x_E) = u²(W)/(n (2 m sin α)²) + (∂x_E/∂β)² u²(β), with ∂x_E/∂β = −z/(2 tan α) tan² α_t dα_t/dβ, dα_t/dβ = cos² α_t tan α
/// sin β/cos² β, and u(β) of the helix angle and the diameter at the tip. With m 4 mm, z 30, β 30° and 4 µm, 20 µm, 0.1° it is 0.0035, as
/// 60 sets of noisy readings scatter; spans alone would leave 0.0010.
#[test]
fn exact_uncertainty_of_a_helical_shift() {
    let gear = InvoluteGear {
        helix: 30f64.to_radians(),
        ..spur(30, 4e-3, 20.0, 0.3)
    };
    let (z, m, alpha, beta) = (30.0, gear.module, gear.pressure_angle, gear.helix);
    let tip = gear.reference_diameter() + 2.0 * 1.3 * m;
    let at_tip = (tip / gear.reference_diameter() * beta.tan()).atan();
    let (u_span, u_tip, u_helix) = (4e-6, 20e-6, 0.1f64.to_radians());
    let mut readings = plain(&gear, u_span);
    readings.tip_diameter = Some(reading(tip, u_tip));
    readings.tip_helix = Some(reading(at_tip, u_helix));
    let found = readings.reverse().unwrap();
    let best = found
        .candidates
        .iter()
        .find(|c| is(c, ToothSize::Module(4.0), 20.0));
    let std = best.unwrap().generating_shift.std;
    let alpha_t = gear.transverse_pressure_angle();
    let turn = (alpha_t.cos() / beta.cos()).powi(2) * alpha.tan() * beta.sin();
    let slope = z / (2.0 * alpha.tan()) * alpha_t.tan().powi(2) * turn;
    let of_helix = z * m / (tip * at_tip.cos().powi(2) * beta.cos()) * u_helix;
    let of_tip = beta.tan() / tip * u_tip;
    let of_spans = u_span / (2f64.sqrt() * 2.0 * m * alpha.sin());
    let exact = of_spans.hypot(slope * of_helix).hypot(slope * of_tip);
    assert!((std / exact - 1.0).abs() < 0.01, "{std} {exact}");
    assert!((std - 0.0035).abs() < 2e-4, "{std}");
}

/// A centre distance below that at which the base circles touch fits no candidate, and the refusal names it.
#[test]
fn refuses_a_centre_distance_inside_the_base_circles() {
    let (gear, other) = (spur(32, 2.5e-3, 20.0, 0.12), spur(57, 2.5e-3, 20.0, -0.05));
    let mut readings = plain(&gear, 4e-6);
    for with_spans in [true, false] {
        let of_mate = spans(&other, 0.0, 4e-6, [0.0; 2]);
        readings.mate = Some(MateReadings {
            teeth: 57,
            internal: false,
            spans: if with_spans { of_mate } else { Vec::new() },
            centre_distance: Some(reading(0.09, 20e-6)),
        });
        let error = readings.reverse().unwrap_err();
        assert!(error.code == Code::NoConvergence);
        assert!(
            error.message.contains("misses the centre distance"),
            "{}",
            error.message
        );
    }
}

/// m 3.5 mm/20° against P 7/25° with spans of 2 µm: a tip diameter tells them apart by its value, and the answer says so.
#[test]
fn law_a_tip_diameter_may_separate() {
    let gear = spur(30, 3.5e-3, 20.0, 0.1);
    let mut readings = plain(&gear, 2e-6);
    readings.thickness_deviation = None;
    let found = readings.reverse().unwrap();
    let twin = |c: &Candidate| is(c, ToothSize::DiametralPitch(7.0), 25.0);
    let open = (found.ambiguities.iter()).find(|c| {
        twin(&found.candidates[c.candidates[1]]) || twin(&found.candidates[c.candidates[0]])
    });
    let may = |remedy: &Remedy| matches!(remedy, Remedy::TipDiameter([_, most]) if *most > 60e-6);
    assert!(open.unwrap().remedies.iter().any(may), "{open:?}");
}
