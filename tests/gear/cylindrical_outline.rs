//! Outlines of cylindrical gears: closed form against the kernel and against the tool that cuts them.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use crate::verification::{printed, within};
use geardyn::internals::gear::cylindrical::basic_rack::BasicRack;
use geardyn::internals::gear::cylindrical::gear_outline::OutlineSteps;
use geardyn::internals::gear::cylindrical::involute::{InvoluteGear, angle_from_inv, inv};
use geardyn::internals::gear::cylindrical::member::Member;
use geardyn::internals::gear::cylindrical::outline::ToothOutline;
use geardyn::internals::gear::kernel::envelope::Envelope;
use geardyn::internals::gear::kernel::law::Law;
use geardyn::internals::gear::kernel::plane::{gear_rolling, plane_envelope, rack_rolling};
use geardyn::internals::gear::kernel::tool::{Arc, Curve, Tool};
use geardyn::internals::gear::kernel::twist::Twist;
use geardyn::internals::gear::kernel::vector::Vector;

#[derive(Clone, Copy)]
struct Work;
#[derive(Clone, Copy)]
struct Rack;
#[derive(Clone, Copy)]
struct Shaper;

const MODULE: f64 = 3e-3;

fn gear(teeth: u32, helix: f64, profile_shift: f64) -> InvoluteGear {
    InvoluteGear {
        teeth,
        module: MODULE,
        pressure_angle: 20f64.to_radians(),
        helix: helix.to_radians(),
        profile_shift,
        internal: false,
    }
}

/// Gears with every kind of external outline.
fn external() -> Vec<Member> {
    let protuberance = BasicRack {
        dedendum: 1.4,
        tip_radius: 0.4,
        protuberance: 0.02,
        ..BasicRack::PROFILE_A
    };
    let thinned = |mut member: Member| {
        member.thickness_deviation = [-80e-6, -40e-6];
        member
    };
    [
        Member::new(gear(24, 0.0, 0.0), BasicRack::PROFILE_A, 0.02),
        Member::new(gear(24, 25.0, 0.3), BasicRack::PROFILE_A, 0.02),
        Member::new(gear(95, 10.0, -0.6), BasicRack::PROFILE_C, 0.02),
        Member::new(gear(9, 0.0, 0.0), BasicRack::PROFILE_B, 0.02),
        Member::new(gear(8, 15.0, 0.1), BasicRack::PROFILE_A, 0.02),
        Member::new(gear(30, 20.0, 0.1), protuberance, 0.02),
        Member::new(gear(30, 0.0, -0.1), protuberance, 0.02),
        Member::new(gear(40, 0.0, 0.0), BasicRack::PROFILE_D, 0.02),
    ]
    .map(thinned)
    .to_vec()
}

/// Largest difference, in modules along the arc, between an outline at given radii and the envelope of a curve of the rack's normal
/// section that slides along the teeth.
fn against_rack<C: Curve>(
    member: &Member,
    curve: C,
    places: &[[f64; 2]],
    start: impl Fn(f64) -> f64,
) -> f64 {
    let gear = &member.gear;
    let along = Vector::new(gear.helix.sin(), 0.0, gear.helix.cos());
    let radius = 0.5 * gear.reference_diameter();
    let envelope = Envelope {
        surface: Tool::<C, Rack>::new(curve, Twist::slide(along)),
        motion: rack_rolling::<Work, Rack>(radius, 0.0),
        range: [-2.0, 2.0],
    };
    let mut largest = 0f64;
    for (i, [r, psi]) in places.iter().enumerate() {
        let u = start(i as f64 / (places.len() - 1) as f64);
        let [c, ..] = envelope.surface.curve.at(u);
        let slide = -c.z / gear.helix.cos();
        let turns = envelope.motion_parameters([u, slide]);
        let at = envelope
            .intersect_circle([0.0, *r], [u, slide, turns[0]])
            .unwrap_or_else(|| panic!("{i}: no point of the envelope at {r}"));
        let p = envelope.point(at).unwrap().point.coordinates;
        let from_space = p.x.atan2(p.y);
        let expected = PI / f64::from(gear.teeth) - psi;
        largest = largest.max((r * (from_space - expected)).abs() / gear.module);
    }
    largest
}

/// Involute and fillet, closed form, are the envelope of the rack's straight flank and of its tip rounding: spur, helical, undercut, with
/// protuberance.
#[test]
fn exact_outline_is_the_envelope_of_its_rack() {
    let (mut involutes, mut fillets) = (0f64, 0f64);
    for member in external() {
        let outline = ToothOutline::new(&member).unwrap();
        let (gear, rack, m) = (&member.gear, &member.rack, MODULE);
        let (sine, cosine) = gear.pressure_angle.sin_cos();
        let across = Vector::new(gear.helix.cos(), 0.0, -gear.helix.sin());
        let shift = outline.generating_shift * m;
        let share = |i: usize| i as f64 / 20.0;
        let places: Vec<_> = (0..=20).map(|i| outline.involute_point(share(i))).collect();
        let line = Arc::straight(
            across * (FRAC_PI_4 * m) + Vector::Y * shift,
            across * sine + Vector::Y * cosine,
            [-3.0 * m, 3.0 * m],
        );
        involutes = involutes.max(against_rack(&member, line, &places, |_| 0.0));
        // Offset line of the protuberance, then the centre at the radius inside it.
        let depth = rack.dedendum - rack.tip_radius;
        let aside =
            (FRAC_PI_4 * cosine + rack.protuberance - rack.tip_radius - sine * depth) / cosine;
        let arc = Arc::about(
            across * (aside * m) + Vector::Y * (shift - depth * m),
            rack.tip_radius * m,
            [Vector::Y * -1.0, across],
            [0.0, FRAC_PI_2],
        );
        // At the root circle itself the radius is stationary.
        let places: Vec<_> = (1..=20).map(|i| outline.fillet_point(share(i))).collect();
        let end = FRAC_PI_2 - gear.pressure_angle;
        fillets = fillets.max(against_rack(&member, arc, &places, |s| {
            rack.tip_radius * m * end * (0.1 + 0.85 * s)
        }));
    }
    within("involute of a rack, modules", involutes, 1e-12);
    within("fillet of a rack, modules", fillets, 1e-12);
}

/// The fillet of a ring is the envelope of the shaper's tip rounding under the rolling of shaper and ring.
#[test]
fn exact_ring_fillet_is_the_envelope_of_its_shaper() {
    let mut largest = 0f64;
    for (teeth, shaper, shift, tip_radius) in [
        (60, 24, 0.0, 0.25),
        (93, 30, -0.4, 0.3),
        (40, 20, -0.3, 0.2),
    ] {
        let rack = BasicRack {
            tip_radius,
            ..BasicRack::PROFILE_A
        };
        let ring = InvoluteGear {
            internal: true,
            ..gear(teeth, 0.0, shift)
        };
        let mut member = Member::new(ring, rack, 0.02);
        member.shaper_teeth = Some(shaper);
        let outline = ToothOutline::new(&member).unwrap();
        let alpha = ring.pressure_angle;
        let difference = f64::from(teeth - shaper);
        let working = angle_from_inv(inv(alpha) - 2.0 * shift * alpha.tan() / difference);
        let distance = 0.5 * MODULE * difference * alpha.cos() / working.cos();
        let base = 0.5 * MODULE * f64::from(shaper) * alpha.cos();
        let rho = tip_radius * MODULE;
        let centre = outline.root_radius - distance - rho;
        let roll = (centre * centre - base * base).sqrt();
        let aside =
            FRAC_PI_2 / f64::from(shaper) + inv(alpha) - rho / base - inv((roll / base).atan());
        // The ring's centre lies at −x of the shaper's; a space's middle starts on +x.
        let arc = Arc::about(
            Vector::new(centre * aside.cos(), -centre * aside.sin(), 0.0),
            rho,
            [Vector::X, Vector::Y * -1.0],
            [-0.5, 2.0],
        );
        let ratio = f64::from(shaper) / f64::from(teeth);
        let motion = gear_rolling::<Work, Shaper>(-distance, Law::linear(ratio));
        let envelope = plane_envelope(arc, motion, [-0.6, 0.6]);
        for i in 1..=20 {
            let [r, psi] = outline.fillet_point(f64::from(i) / 20.0);
            let start = |u: f64| envelope.motion_parameters([u, 0.0]);
            // The rounding turns with the shaper: u runs over less than the angle θ of its normal.
            let u = rho * 0.03 * f64::from(i) * (FRAC_PI_2 - working);
            let x = start(u)
                .into_iter()
                .min_by(|a, b| a.abs().total_cmp(&b.abs()))
                .unwrap();
            let at = envelope.intersect_circle([0.0, r], [u, 0.0, x]).unwrap();
            let p = envelope.point(at).unwrap().point.coordinates;
            let from_space = (-p.y).atan2(p.x);
            let expected = PI / f64::from(teeth) - psi;
            largest = largest.max((r * (from_space - expected)).abs() / MODULE);
        }
    }
    within("fillet of a shaper, modules", largest, 1e-12);
}

/// Fillet and involute meet at the form radius, external and internal, undercut and with protuberance; the angle at a radius is that of
/// the parametric points.
#[test]
fn law_fillet_joins_involute() {
    let ring = |teeth, shift| InvoluteGear {
        internal: true,
        ..gear(teeth, 20.0, shift)
    };
    let rings = [(60, 0.0), (93, -0.4), (40, 0.3)]
        .map(|(z, x)| Member::new(ring(z, x), BasicRack::PROFILE_A, 0.02));
    for member in external().into_iter().chain(rings) {
        let outline = ToothOutline::new(&member).unwrap();
        let ([r1, psi1], [r2, psi2]) = (outline.fillet_point(1.0), outline.involute_point(0.0));
        assert!(
            (r1 / r2 - 1.0).abs() < 1e-14 && (psi1 - psi2).abs() < 1e-13,
            "{psi1} {psi2}"
        );
        for i in 0..=10 {
            let share = f64::from(i) / 10.0;
            for [r, psi] in [outline.fillet_point(share), outline.involute_point(share)] {
                let again = outline.half_angle(r).unwrap();
                // The fillet is normal to the radius at the root circle, where rounding of r is its square root in the angle.
                let near_root = ((r - outline.root_radius) / r).abs() < 1e-12;
                let allowed = if near_root { 1e-7 } else { 1e-11 };
                assert!((again - psi).abs() < allowed, "{share} {again} {psi}");
            }
        }
        assert_eq!(
            outline.half_angle(2.0 * outline.tip_radius.max(outline.root_radius)),
            None
        );
    }
}

/// Distances of a point from the rounding and from the flanks of a tooth of the tool, negative inside; the tool's reference line is at height 0, its tip below.
fn distance_from_rack(rack: &BasicRack, alpha: f64, [across, height]: [f64; 2]) -> [f64; 2] {
    let (sine, cosine) = alpha.sin_cos();
    let depth = rack.dedendum - rack.tip_radius;
    let aside = (FRAC_PI_4 * cosine + rack.protuberance - rack.tip_radius - sine * depth) / cosine;
    let beyond = (across.abs() - aside).max(0.0);
    let rounding = beyond.hypot(height + depth) - rack.tip_radius;
    let flank = (across.abs() - FRAC_PI_4) * cosine - height * sine;
    [rounding, flank.max(-rack.straight_depth(alpha) - height)]
}

/// Least value of a function between two places; two minima nearer than a twentieth of their distance count as one.
fn minimum(low: f64, high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let step = (high - low) / 40.0;
    let places = (0..=40).map(|i| low + step * f64::from(i));
    let near = places.min_by(|a, b| f(*a).total_cmp(&f(*b))).unwrap();
    let (mut low, mut high) = (near - step, near + step);
    for _ in 0..100 {
        let (a, b) = (low + 0.382 * (high - low), low + 0.618 * (high - low));
        if f(a) < f(b) { high = b } else { low = a }
    }
    f(0.5 * (low + high))
}

/// Rolling on the reference circle, the tool touches every point of the outline and enters none: spur gears, with undercut and with
/// protuberance.
#[test]
fn law_tool_touches_and_never_enters() {
    let (mut inside, mut apart) = (0f64, 0f64);
    for member in external().into_iter().filter(|m| m.gear.helix == 0.0) {
        let outline = ToothOutline::new(&member).unwrap();
        let (gear, m) = (&member.gear, MODULE);
        let radius = 0.5 * gear.reference_diameter();
        let points = (0..=30).flat_map(|i| {
            let share = f64::from(i) / 30.0;
            [outline.fillet_point(share), outline.involute_point(share)]
        });
        for [r, psi] in points {
            let from_space = PI / f64::from(gear.teeth) - psi;
            let distance = |turn: f64| {
                let angle = from_space + turn;
                let at = [
                    r * angle.sin() - radius * turn,
                    r * angle.cos() - radius - outline.generating_shift * m,
                ];
                distance_from_rack(&member.rack, gear.pressure_angle, at.map(|x| x / m))
            };
            // Rounding and flank come near at turns of their own.
            let step = 1e-3;
            let mut least = f64::INFINITY;
            for part in 0..2 {
                let coarse: Vec<f64> = (-1500..=1500)
                    .map(|i| distance(step * f64::from(i))[part])
                    .collect();
                for (i, near) in coarse.windows(3).enumerate() {
                    if near[1] <= near[0].min(near[2]) {
                        let middle = step * (i as f64 - 1499.0);
                        let found =
                            minimum(middle - step, middle + step, |turn| distance(turn)[part]);
                        least = least.min(found);
                    }
                }
            }
            inside = inside.max(-least);
            apart = apart.max(least);
        }
    }
    assert!(inside < 1e-12 && apart < 1e-12, "{inside} {apart}");
}

/// Closed numbers of the handbooks on undercut, root circle, span and chords, with 20° and a tooth height of 2.25 modules.
/// Source: worked examples of handbooks, recomputed: 17.0973 teeth, 41.454 teeth, W/m = 2.9521 (k − 1/2) + 0.0140055 z.
#[test]
fn ref_handbook_numbers() {
    let alpha = 20f64.to_radians();
    let rack = |z| Member::new(gear(z, 0.0, 0.0), BasicRack::PROFILE_A, 0.02);
    // The handbooks count the straight depth of the rack as one module.
    let sharp = BasicRack {
        dedendum: 1.0,
        tip_radius: 0.0,
        ..BasicRack::PROFILE_A
    };
    let least = |z| Member::new(gear(z, 0.0, 0.0), sharp, 0.02).least_shift_without_undercut();
    let z_min = 10.0 + 10.0 * least(10) / (least(10) - least(20));
    printed("teeth without undercut", "", 17.0973, z_min, 5e-5);
    let depth = |z: u32| rack(z).root_diameter(0.0) - gear(z, 0.0, 0.0).base_diameter();
    let switch = 41.0 + depth(41) / (depth(41) - depth(42));
    printed(
        "teeth where root and base circle coincide",
        "",
        41.454,
        switch,
        5e-4,
    );
    printed("inv 20°", "", 0.014904384, inv(alpha), 5e-10);
    let g = gear(24, 0.0, 0.0);
    let (s, tip) = (g.nominal_thickness(), rack(24).tip_diameter());
    printed(
        "W/m over 3 of 24 teeth",
        "",
        7.716462,
        g.span(3, s) / MODULE,
        5e-7,
    );
    let (chord, height) = g.chordal_thickness(tip, s);
    printed(
        "chord of 24 teeth",
        "modules",
        1.569675,
        chord / MODULE,
        5e-7,
    );
    printed("its height", "modules", 1.025693, height / MODULE, 5e-7);
    let (chord, height) = g.constant_chord(tip, s);
    printed("constant chord", "modules", 1.387048, chord / MODULE, 5e-7);
    printed(
        "its height from the tip",
        "modules",
        0.747578,
        height / MODULE,
        5e-7,
    );
}

/// Points of a polygon of eight times the steps lie within 1e-4 modules of its chords from 5 teeth on, of undercut teeth within 3e-4.
#[test]
fn law_chords_of_outlines() {
    const FINER: usize = 8;
    let steps = OutlineSteps::default();
    let finer = OutlineSteps {
        fillet: FINER * steps.fillet,
        involute: FINER * steps.involute,
        land: FINER * steps.land,
    };
    let shapes = [
        (5, 0.0, 0.7),
        (8, 0.0, 0.55),
        (6, 0.0, 0.8),
        (12, 0.0, 0.0),
        (17, 25.0, 0.3),
        (40, 0.0, 0.0),
    ];
    for (teeth, helix, shift) in shapes {
        for degrees in [14.5, 20.0, 28.0] {
            let mut shape = gear(teeth, helix, shift);
            shape.pressure_angle = f64::to_radians(degrees);
            let mut rack = BasicRack::PROFILE_A;
            rack.tip_radius = rack
                .tip_radius
                .min(rack.full_tip_radius(shape.pressure_angle));
            let Ok(outline) = ToothOutline::new(&Member::new(shape, rack, 0.02)) else {
                continue;
            };
            let (coarse, fine) = (
                outline.polygon(0.0, 0..2, steps),
                outline.polygon(0.0, 0..2, finer),
            );
            assert_eq!(fine.len(), FINER * coarse.len());
            let off = |i: usize| {
                let ([x0, y0], [x1, y1]) = (coarse[i], coarse[i + 1]);
                let length = (x1 - x0).hypot(y1 - y0);
                let from =
                    |[x, y]: [f64; 2]| ((x - x0) * (y1 - y0) - (y - y0) * (x1 - x0)).abs() / length;
                fine[FINER * i..FINER * (i + 1)]
                    .iter()
                    .map(|p| from(*p))
                    .fold(0.0, f64::max)
            };
            let most = (0..coarse.len() / 2).map(off).fold(0.0, f64::max) / MODULE;
            let limit = if outline.undercut { 3e-4 } else { 1e-4 };
            assert!(
                most < limit,
                "{teeth} teeth, x {shift}, {degrees}°: {most:e} modules"
            );
        }
    }
}
