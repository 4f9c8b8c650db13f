//! Cylindrical pairs: laws over random gears, symmetries, extremes.

use std::f64::consts::{PI, TAU};

use geardyn::internals::base::bound::Bound;
use geardyn::internals::gear::cylindrical::basic_rack::BasicRack;
use geardyn::internals::gear::cylindrical::involute::InvoluteGear;
use geardyn::internals::gear::cylindrical::member::Member;
use geardyn::internals::gear::cylindrical::modification::{FlankModification, Relief};
use geardyn::internals::gear::cylindrical::outline::ToothOutline;
use geardyn::internals::gear::cylindrical::pair::Pair;
use geardyn::internals::gear::cylindrical::remedy::Design;
use geardyn::internals::gear::cylindrical::warnings::{NearestValue, WarningKind};

use crate::load_random::processor_ms;

/// Random members of a pair, the second internal one time in four.
fn random_members(rng: &mut fastrand::Rng, wild: bool) -> [Member; 2] {
    let internal = rng.f64() < 0.25;
    let racks = [
        BasicRack::PROFILE_A,
        BasicRack::PROFILE_B,
        BasicRack::PROFILE_C,
        BasicRack::PROFILE_D,
    ];
    let rack = racks[rng.usize(0..4)];
    let module = 1e-3 * 10f64.powf(2.0 * rng.f64() - 0.5);
    let pressure_angle = [14.5, 15.0, 17.5, 20.0, 22.5, 25.0][rng.usize(0..6)];
    let helix = if rng.bool() { 0.0 } else { 35.0 * rng.f64() };
    let first = rng.u32(if wild { 5..30 } else { 14..60 });
    let second = match internal {
        false => rng.u32(if wild { 5..500 } else { 14..150 }),
        true => first + rng.u32(if wild { 4..40 } else { 25..120 }),
    };
    let mut shift = || match wild {
        false => 0.7 * rng.f64() - 0.2,
        true => 2.4 * rng.f64() - 1.2,
    };
    let mut shifts = [shift(), shift()];
    if wild && internal {
        // Teeth of a ring this thin stand outside its base circle beside few more teeth than the pinion has.
        shifts[1] = -shifts[1].abs();
    }
    [first, second].map(|teeth| {
        let index = usize::from(teeth == second);
        let gear = InvoluteGear {
            teeth,
            module,
            pressure_angle: f64::to_radians(pressure_angle),
            helix: f64::to_radians(helix),
            profile_shift: shifts[index],
            internal: internal && index == 1,
        };
        let mut member = Member::new(gear, rack, 10.0 * module);
        let thinner = module * rng.f64();
        member.thickness_deviation = [-0.03 * thinner, -0.01 * thinner];
        member
    })
}

/// Pairs that touch at the pitch point, without a warning but trimming, which is one of assembly.
fn sane_pairs(count: usize, seed: u64) -> impl Iterator<Item = Pair> {
    let mut rng = fastrand::Rng::with_seed(seed);
    std::iter::repeat_with(move || {
        let [first, second] = random_members(&mut rng, false);
        Pair::new([first, second], None).ok()
    })
    .flatten()
    .filter(|pair| {
        let mut warnings = pair.warnings().into_iter();
        let only_trimming = warnings.all(|w| w.kind == WarningKind::TrimmingInterference);
        only_trimming && pair.path_ends().iter().all(|end| *end > 0.0)
    })
    .take(count)
}

/// How far the tooth of gear 2 could turn towards the flank of gear 1 from the place of constant ratio, rad: 0 in contact, negative where
/// they overlap. Only the outlines are used.
fn gap(pair: &Pair, turn: f64) -> f64 {
    let [first, second] = &pair.outlines;
    let [w1, w2] = pair.working_diameters().map(|d| 0.5 * d);
    let centred = [
        first.half_angle(w1).unwrap(),
        second.half_angle(w2).unwrap(),
    ];
    let place = centred[1] + turn / pair.ratio();
    let a = pair.centre_distance;
    let reached = |[r, psi]: [f64; 2]| {
        let angle = turn - centred[0] + psi;
        let (x, y) = (r * angle.sin(), r * angle.cos());
        let along = if second.internal { y + a } else { a - y };
        let mate = second.half_angle(x.hypot(along))?;
        Some(x.atan2(along) + mate)
    };
    let at = |share: f64| reached(first.involute_point(share)).unwrap_or(f64::NEG_INFINITY);
    let parts = 16;
    let share = |i: usize| i as f64 / parts as f64;
    let best = (0..=parts)
        .max_by(|i, j| at(share(*i)).total_cmp(&at(share(*j))))
        .unwrap();
    let (mut low, mut high) = (share(best.max(1) - 1), share((best + 1).min(parts)));
    for _ in 0..30 {
        let (p, q) = (low + 0.382 * (high - low), low + 0.618 * (high - low));
        if at(p) > at(q) { high = q } else { low = p }
    }
    let ends = [at(0.0), at(1.0), at(share(best)), at(0.5 * (low + high))];
    let fillet = (0..4).filter_map(|i| reached(first.fillet_point(i as f64 / 4.0)));
    place
        - ends
            .into_iter()
            .chain(fillet)
            .fold(f64::NEG_INFINITY, f64::max)
}

/// Contact ratio by following contact on the outlines from the pitch point both ways.
fn contact_ratio_on_outlines(pair: &Pair) -> f64 {
    let pitch = TAU / f64::from(pair.outlines[0].teeth);
    // Beyond an end of contact the gap grows with the square of the turn.
    let touches = |turn: f64| gap(pair, turn) < 2e-14;
    let end = |sense: f64| {
        let (mut inside, mut outside) = (0.0, 1.5 * pitch * sense);
        assert!(touches(0.0), "{} at C", gap(pair, 0.0));
        while touches(outside) {
            outside += pitch * sense;
        }
        for _ in 0..20 {
            let middle = 0.5 * (inside + outside);
            if touches(middle) {
                inside = middle
            } else {
                outside = middle
            }
        }
        inside * sense
    };
    (end(1.0) + end(-1.0)) / pitch
}

fn check_pairs(count: usize, seed: u64) {
    let (mut worst, mut pitch_error) = (0f64, 0f64);
    let mut internal = 0;
    for pair in sane_pairs(count, seed) {
        internal += usize::from(pair.outlines[1].internal);
        let ratios = pair.contact_ratios();
        worst = worst.max((contact_ratio_on_outlines(&pair) - ratios.transverse).abs());
        let radii = pair.working_diameters().map(|d| 0.5 * d);
        let thickness: f64 = (0..2)
            .map(|i| pair.outlines[i].thickness(radii[i]).unwrap())
            .sum();
        let mean = pair.members.map(|m| m.mean_thickness_deviation());
        let backlash = pair.backlash(pair.centre_distance, mean).unwrap();
        let pitch = TAU * radii[0] / f64::from(pair.outlines[0].teeth);
        pitch_error = pitch_error.max(((thickness + backlash.circumferential) / pitch - 1.0).abs());
        let limits = pair.backlash_limits([-1e-5, 1e-5]).unwrap();
        assert!(limits.least.normal < backlash.normal && backlash.normal < limits.greatest.normal);
        assert!(limits.nominal.circumferential.abs() < 1e-12 * pitch);
    }
    println!("contact ratio {worst:.1e}, pitch {pitch_error:.1e}, {internal} internal of {count}");
    assert!(internal > count / 20);
    assert!(worst < 3e-5 && pitch_error < 1e-12, "{worst} {pitch_error}");
}

/// Over 2 000 random pairs the contact ratio by geometry is that of contact followed on the outlines, and at the working circles
/// thicknesses and backlash fill the pitch.
#[test]
fn law_random_pairs() {
    check_pairs(2000, 21);
}

#[test]
#[ignore = "minutes: 1e5 random pairs"]
fn law_many_random_pairs() {
    check_pairs(100_000, 22);
}

/// Mirrored teeth, the second gear driving, and a pair in inches give the same numbers.
#[test]
fn law_mirror_driver_and_units() {
    for pair in sane_pairs(200, 23).filter(|p| !p.outlines[1].internal) {
        let same = |x: f64, y: f64| assert!((x - y).abs() <= 1e-12 * x.abs().max(1e-3), "{x} {y}");
        let mirrored = pair.members.map(|mut member| {
            member.gear.helix = -member.gear.helix;
            member
        });
        let mirrored = Pair::new(mirrored, Some(pair.centre_distance)).unwrap();
        same(mirrored.contact_ratios().total, pair.contact_ratios().total);
        assert_eq!(
            mirrored.outlines[0].half_angle(mirrored.outlines[0].form_radius),
            pair.outlines[0].half_angle(pair.outlines[0].form_radius)
        );
        let [first, second] = pair.members;
        let swapped = Pair::new([second, first], Some(pair.centre_distance)).unwrap();
        let (here, there) = (pair.path_points_driven_by_second(), swapped.path_points());
        for (p, q) in [
            (here.a, there.a),
            (here.b, there.b),
            (here.d, there.d),
            (here.e, there.e),
        ] {
            same(p.distance, q.distance);
            for i in 0..2 {
                same(p.diameter[i], q.diameter[1 - i]);
                same(p.specific_sliding[i], q.specific_sliding[1 - i]);
            }
        }
        // The same gears with every length in inches.
        let inch = |x: f64| x / 0.0254;
        let members = pair.members.map(|mut member| {
            member.gear.module = inch(member.gear.module);
            member.face_width = inch(member.face_width);
            member.tip_diameter = member.tip_diameter.map(inch);
            member.thickness_deviation = member.thickness_deviation.map(inch);
            member
        });
        let in_inches = Pair::new(members, Some(inch(pair.centre_distance))).unwrap();
        same(
            in_inches.contact_ratios().total,
            pair.contact_ratios().total,
        );
        same(
            in_inches.path_points().e.roll[0] * 0.0254,
            pair.path_points().e.roll[0],
        );
        for i in 0..2 {
            same(
                in_inches.outlines[i].form_radius * 0.0254,
                pair.outlines[i].form_radius,
            );
            let ball = pair.members[i].gear.default_ball_diameter();
            let [here, there] = [(pair.members[i], ball), (in_inches.members[i], inch(ball))]
                .map(|(member, ball)| member.over_balls(ball).unwrap());
            same(there.nominal * 0.0254, here.nominal);
            same(there.least * 0.0254, here.least);
        }
    }
}

/// A pair with the value a warning names, as it is printed, has that warning no more.
#[test]
fn law_nearest_value_avoids_the_warning() {
    let mut rng = fastrand::Rng::with_seed(24);
    let mut seen = std::collections::BTreeMap::new();
    let mut refused = 0;
    for _ in 0..6000 {
        let members = random_members(&mut rng, true);
        let stretch = 1.0 + 0.02 * rng.f64();
        let Ok(pair) = Pair::new(members, None) else {
            refused += 1;
            continue;
        };
        let Ok(pair) = Pair::new(pair.members, Some(stretch * pair.centre_distance)) else {
            continue;
        };
        for warning in pair.warnings() {
            assert!(warning.by.is_finite() && warning.by >= 0.0, "{warning:?}");
            let count = seen.entry(warning.kind).or_insert([0, 0]);
            count[0] += 1;
            let Some(nearest) = warning.nearest else {
                continue;
            };
            let mut changed = pair.members;
            let printed = |bound: Bound| bound.text(4).parse::<f64>().unwrap();
            let diameter = |bound: Bound| Some(1e-3 * printed(bound.scaled(1e3)));
            match nearest {
                NearestValue::ProfileShift { member, value } => {
                    changed[member].gear.profile_shift = printed(value)
                }
                NearestValue::TipDiameter { member, value } => {
                    changed[member].tip_diameter = diameter(value)
                }
                NearestValue::TipDiameters(tips) => {
                    for i in 0..2 {
                        changed[i].tip_diameter = diameter(tips[i]);
                    }
                }
                other => panic!("{other:?} of a pair alone"),
            }
            let Ok(again) = Pair::new(changed, Some(pair.centre_distance)) else {
                continue;
            };
            count[1] += 1;
            let still = again
                .warnings()
                .into_iter()
                .find(|w| w.kind == warning.kind && w.member == warning.member);
            assert_eq!(still, None, "{warning:?} of {pair:?}");
        }
    }
    println!("{seen:?}, {refused} refused");
    assert_eq!(seen.len(), 8, "every kind occurs: {seen:?}");
    for (kind, [found, cured]) in &seen {
        assert!(2 * cured > *found, "{kind:?}: {cured} of {found}");
    }
}

/// Values of a design can be followed: as printed they leave the pair without the warning and without a new one.
#[test]
fn law_values_of_a_design_bring_no_new_warning() {
    let mut rng = fastrand::Rng::with_seed(41);
    let (mut seen, mut valued, mut short, mut lengthened) = (0, 0, 0, 0);
    for _ in 0..400 {
        let members = random_members(&mut rng, true);
        let design = Design {
            members,
            centre_distance: None,
        };
        let Ok(pair) = Pair::new(members, None) else {
            continue;
        };
        let met = design.warnings(&pair);
        for warning in &met {
            seen += 1;
            let is_short = warning.kind == WarningKind::ContactRatio;
            short += usize::from(is_short);
            let Some(nearest) = warning.nearest else {
                continue;
            };
            valued += 1;
            lengthened += usize::from(is_short);
            let changed = design.with_nearest(nearest);
            let again = Pair::new(changed.members, changed.centre_distance).unwrap();
            for new in again.warnings() {
                let is_old = met
                    .iter()
                    .any(|w| w.kind == new.kind && w.member == new.member);
                let is_it = new.kind == warning.kind && new.member == warning.member;
                let is_assembly = new.kind == WarningKind::TrimmingInterference;
                assert!((is_old && !is_it) || is_assembly, "{warning:?} {new:?}");
            }
        }
    }
    println!("{valued} of {seen} warnings have a value, {lengthened} of {short} short contacts");
    assert!(10 * valued > 9 * seen && 10 * lengthened >= 9 * short);
}

/// Teeth cut just below the limit of undercut lose next to nothing: their form circle is the base circle up to the square of what is missing.
#[test]
fn survives_the_limit_of_undercut() {
    for (teeth, protuberance) in (5..=17).flat_map(|z| [(z, 0.0), (z, 0.02)]) {
        let gear = InvoluteGear {
            teeth,
            module: 2e-3,
            pressure_angle: 20f64.to_radians(),
            helix: 0.0,
            profile_shift: 0.0,
            internal: false,
        };
        let rack = BasicRack {
            protuberance,
            ..BasicRack::PROFILE_A
        };
        let mut member = Member::new(gear, rack, 0.02);
        let limit = member.least_shift_without_undercut();
        let missing = [0.0, 1e-16, 1e-12, 6e-7, 1e-5, 3e-5, 1e-4, 6e-4, 1e-3, 5e-3];
        for by in missing.into_iter().flat_map(|by: f64| [by, -by]) {
            member.gear.profile_shift = limit - by;
            let outline =
                ToothOutline::new(&member).unwrap_or_else(|e| panic!("{teeth} {by}: {e}"));
            let base = outline.base_radius;
            assert!(outline.form_radius >= base * (1.0 - 1e-12), "{teeth} {by}");
            let roll = by.abs() * 2e-3 / 20f64.to_radians().sin();
            let above = outline.form_radius - base;
            let bound = 0.5 * roll * roll / base + 1e-11;
            assert!(
                protuberance > 0.0 || above <= bound,
                "{teeth} {by}: {above} {bound}"
            );
        }
    }
}

/// A protuberance clears the fillet of the mate's tip: no interference is warned of where the outlines do not overlap.
#[test]
fn exact_protuberance_makes_room() {
    let rack = BasicRack {
        addendum: 1.0,
        dedendum: 1.4,
        tip_radius: 0.25,
        protuberance: 0.05,
    };
    let member = |teeth, profile_shift| {
        let gear = InvoluteGear {
            teeth,
            module: 3e-3,
            pressure_angle: 20f64.to_radians(),
            helix: 0.0,
            profile_shift,
            internal: false,
        };
        Member::new(gear, rack, 0.03)
    };
    let pair = Pair::new([member(24, 0.2), member(55, 0.0)], None).unwrap();
    let turns = (-100..=100).map(|i| 0.01 * f64::from(i) * TAU / 24.0);
    let least = turns
        .map(|turn| gap(&pair, turn))
        .fold(f64::INFINITY, f64::min);
    assert!(least > -1e-12, "{least}");
    assert_eq!(pair.warnings(), []);
    // Longer tips meet the fillet below the room.
    let mut long = pair.members;
    long[1].tip_diameter = long[1].tip_diameter.map(|tip| tip + 2.4e-3);
    let long = Pair::new(long, Some(pair.centre_distance)).unwrap();
    let kinds: Vec<_> = long.warnings().iter().map(|w| w.kind).collect();
    assert!(
        kinds.contains(&WarningKind::FilletInterference),
        "{kinds:?}"
    );
}

/// Whatever the numbers, an answer without NaN or a reason.
#[test]
fn survives_extreme_gears() {
    let gear = |teeth: u32, profile_shift: f64, internal: bool| InvoluteGear {
        teeth,
        module: 2e-3,
        pressure_angle: 20f64.to_radians(),
        helix: 0.0,
        profile_shift,
        internal,
    };
    let member = |z, x, internal| Member::new(gear(z, x, internal), BasicRack::PROFILE_A, 0.02);
    let five = Pair::new([member(5, 0.8, false), member(30, 0.0, false)], None).unwrap();
    let kinds: Vec<_> = five.warnings().iter().map(|w| w.kind).collect();
    assert!(kinds.contains(&WarningKind::PointedTip), "{kinds:?}");
    let one = Pair::new([member(30, 0.0, false), member(30, 0.0, false)], None).unwrap();
    assert_eq!(one.ratio(), 1.0);
    assert!(one.warnings().is_empty());
    let hundred = Pair::new([member(20, 0.0, false), member(2000, 0.0, false)], None).unwrap();
    assert!(hundred.warnings().is_empty() && hundred.contact_ratios().transverse > 1.7);
    // No answer, but the value that gives one.
    let hinted = [
        Pair::new([member(20, 0.0, false), member(30, 0.0, true)], None),
        Pair::new([member(20, -1.5, false), member(20, -1.5, false)], None),
        Pair::new([member(20, 0.0, false), member(30, 0.0, false)], Some(0.01)),
    ];
    for refused in hinted {
        let error = refused.unwrap_err();
        assert!(error.hint.is_some(), "{error}");
    }
    let mut rng = fastrand::Rng::with_seed(25);
    let mut odd = || match rng.usize(0..12) {
        0 => f64::NAN,
        1 => f64::INFINITY,
        2 => 0.0,
        3 => -1.0,
        4 => 1e300,
        5 => 1e-300,
        _ => 10f64.powf(4.0 * rng.f64() - 2.0) * if rng.bool() { 1.0 } else { -1.0 },
    };
    for i in 0..20_000u32 {
        let mut members = [
            member(5 + i % 37, 0.0, false),
            member(3 + i % 91, 0.0, i % 3 == 0),
        ];
        for m in &mut members {
            m.gear.profile_shift = odd();
            m.gear.helix = odd();
            m.gear.pressure_angle = 0.35 * if i % 5 == 0 { odd() } else { 1.0 };
            m.gear.module = 2e-3;
            m.rack.tip_radius = if i % 7 == 0 { odd() } else { 0.2 };
            m.rack.dedendum = if i % 11 == 0 { odd() } else { 1.25 };
            m.rack.protuberance = if i % 13 == 0 { odd() } else { 0.0 };
            m.tip_diameter = (i % 2 == 0).then(&mut odd);
            m.gear.helix = if i % 4 == 0 { 0.0 } else { m.gear.helix };
        }
        members[1].gear.helix = members[0].gear.helix;
        members[1].gear.pressure_angle = members[0].gear.pressure_angle;
        let centre = (i % 3 == 1).then(&mut odd);
        let Ok(pair) = Pair::new(members, centre) else {
            continue;
        };
        let ratios = pair.contact_ratios();
        let points = pair.path_points();
        let finite = [
            ratios.total,
            ratios.transverse,
            points.a.roll[0],
            points.e.roll[1],
            points.e.diameter[0],
        ];
        assert!(finite.iter().all(|x| x.is_finite()), "{pair:?}");
        assert!(pair.warnings().iter().all(|w| w.by.is_finite()));
        assert!(
            pair.outlines
                .iter()
                .all(|o| o.half_angle(o.form_radius).is_some_and(f64::is_finite))
        );
    }
}

/// Teeth that no centre distance or tip lets touch twice are warned of, with both tips that would.
#[test]
fn refuses_contact_ratio_below_one() {
    let gear = InvoluteGear {
        teeth: 20,
        module: 2e-3,
        pressure_angle: 20f64.to_radians(),
        helix: 0.0,
        profile_shift: 0.0,
        internal: false,
    };
    let stub = BasicRack {
        addendum: 0.4,
        ..BasicRack::PROFILE_A
    };
    let pair = Pair::new([Member::new(gear, stub, 0.02); 2], None).unwrap();
    let warnings = pair.warnings();
    assert_eq!(warnings.len(), 1);
    assert_eq!(warnings[0].kind, WarningKind::ContactRatio);
    let Some(NearestValue::TipDiameters([tip, _])) = warnings[0].nearest else {
        panic!("{warnings:?}");
    };
    let mut members = pair.members;
    let tip = Some(tip.value());
    members.iter_mut().for_each(|m| m.tip_diameter = tip);
    let whole = Pair::new(members, Some(pair.centre_distance)).unwrap();
    assert!((whole.contact_ratios().total - 1.0).abs() < 1e-12);
}

/// Reliefs, crownings and slope over the flank: nothing where they begin, their amounts at the ends, their sum in between.
#[test]
fn exact_flank_modification() {
    let ends = [4e-3, 20e-3];
    let flank = FlankModification {
        tip_relief: Some(Relief {
            amount: 30e-6,
            from: 16e-3,
        }),
        root_relief: Some(Relief {
            amount: 10e-6,
            from: 6e-3,
        }),
        profile_crowning: 0.0,
        helix_crowning: 8e-6,
        helix_slope: 5e-6,
    };
    flank.check(ends, 3e-3).unwrap();
    let near = |roll: f64, face: f64, expected: f64| {
        let found = flank.removed(roll, ends, face);
        assert!((found - expected).abs() < 1e-18, "{found} {expected}");
    };
    near(12e-3, 0.5, 2.5e-6);
    near(20e-3, 0.5, 32.5e-6);
    near(18e-3, 0.0, 23e-6);
    near(4e-3, 1.0, 23e-6);
    near(5e-3, 0.5, 7.5e-6);
    let crowned = FlankModification {
        profile_crowning: 6e-6,
        ..FlankModification::default()
    };
    assert_eq!(crowned.removed(12e-3, ends, 0.3), 0.0);
    assert!((crowned.removed(4e-3, ends, 0.3) - 6e-6).abs() < 1e-18);
    let off = FlankModification {
        tip_relief: Some(Relief {
            amount: 1e-5,
            from: 21e-3,
        }),
        ..flank
    };
    assert!(off.check(ends, 3e-3).unwrap_err().hint.is_some());
}

/// Trochoid and trimming interference of rings against the outlines: the corners' places at every turn.
#[test]
fn law_corner_interference_on_outlines() {
    let mut rng = fastrand::Rng::with_seed(26);
    let mut counts = [[0; 2]; 2];
    for _ in 0..8000 {
        let [mut pinion, mut ring] = random_members(&mut rng, true);
        if !ring.gear.internal {
            continue;
        }
        for member in [&mut pinion, &mut ring] {
            member.thickness_deviation = [0.0; 2];
        }
        let Ok(pair) = Pair::new([pinion, ring], None) else {
            continue;
        };
        let [first, second] = &pair.outlines;
        let warned = |kind| pair.warnings().iter().any(|w| w.kind == kind);
        let [w1, w2] = pair.working_diameters().map(|d| 0.5 * d);
        // Tip corners turn with the flanks that touch at the pitch point.
        let corners = |turn: f64| {
            let lead = |o: &ToothOutline, w: f64| {
                o.half_angle(o.tip_radius).unwrap() - half_angle_beyond(o, w)
            };
            (
                turn + lead(first, w1),
                turn / pair.ratio() - lead(second, w2),
            )
        };
        let (tip1, tip2, a) = (first.tip_radius, second.tip_radius, pair.centre_distance);
        // Trimming: sideways distance of the corners as the pinion moves along the line of centres.
        let aside = |turn: f64| {
            let (p, q) = corners(turn);
            let inside = p.abs() < 0.5 * PI && q.abs() < 0.5 * PI;
            if inside {
                tip2 * q.sin() - tip1 * p.sin()
            } else {
                f64::INFINITY
            }
        };
        let least = (0..4000)
            .map(|i| aside(4e-4 * f64::from(i)))
            .fold(f64::INFINITY, f64::min);
        // A corner within rounding and the step of the scan of touching decides nothing.
        if least.abs() > 1e-5 * a {
            counts[0][usize::from(least < 0.0)] += 1;
            assert_eq!(
                least < 0.0,
                warned(WarningKind::TrimmingInterference),
                "{least} {pair:?}"
            );
        }
        // Trochoid: where the pinion's corner crosses the ring's tip circle it has passed the ring's corner.
        let cosine = (tip2 * tip2 - tip1 * tip1 - a * a) / (2.0 * a * tip1);
        if cosine.abs() < 1.0 {
            let turn = cosine.acos() - corners(0.0).0;
            let (p, q) = corners(turn);
            let (x, y) = (tip1 * p.sin(), tip1 * p.cos() + a);
            let room = q - x.atan2(y);
            assert!((x.hypot(y) / tip2 - 1.0).abs() < 1e-9);
            if room.abs() > 1e-9 {
                counts[1][usize::from(room < 0.0)] += 1;
                assert_eq!(
                    room < 0.0,
                    warned(WarningKind::TrochoidInterference),
                    "{room} {pair:?}"
                );
            }
        }
    }
    println!("{counts:?}");
    assert!(
        counts[0][0] > 50 && counts[1].iter().all(|n| *n > 10),
        "{counts:?}"
    );
}

/// ψ of the involute, continued beyond the tip.
fn half_angle_beyond(outline: &ToothOutline, radius: f64) -> f64 {
    let base = outline.base_radius;
    let involute = |r: f64| {
        let tangent = ((r - base) * (r + base)).sqrt() / base;
        tangent - tangent.atan()
    };
    let [tip, psi] = outline.involute_point(1.0);
    let sense = if outline.internal { -1.0 } else { 1.0 };
    psi + sense * (involute(tip) - involute(radius))
}

/// Drawing readings: limits follow the thickness, anvils must touch the flanks, pins of odd helical gears lie straight across, and the
/// default ball touches the flanks at d + 2 x m.
#[test]
fn exact_drawing_readings() {
    let mut rng = fastrand::Rng::with_seed(29);
    let mut internal = 0;
    for pair in sane_pairs(200, 30) {
        let member = pair.members[rng.usize(0..2)];
        let gear = &member.gear;
        internal += usize::from(gear.internal);
        let near = |x: f64, y: f64| {
            assert!(
                (x - y).abs() < 1e-11 * gear.reference_diameter(),
                "{x} {y} {member:?}"
            )
        };
        let [lower, upper] = member.thickness_deviation;
        if let Some(span) = member.span(gear.default_span_teeth()) {
            let sense = if gear.internal { -1.0 } else { 1.0 };
            let ends = [lower, upper].map(|e| span.nominal + sense * e * gear.pressure_angle.cos());
            near(span.least, ends[0].min(ends[1]));
            near(span.greatest, ends[0].max(ends[1]));
        } else {
            assert!(gear.internal || gear.teeth < 20, "{member:?}");
        }
        assert_eq!(member.span(0), None);
        assert_eq!(member.span(gear.teeth), None);
        let ball = gear.default_ball_diameter();
        if ball > 0.0 {
            // The ball's centre has rolled half its diameter, in the transverse section, farther than the point it touches.
            let sense = if gear.internal { -1.0 } else { 1.0 };
            let centre = gear.ball_centre_diameter(ball, gear.nominal_thickness());
            let roll =
                gear.roll_length(centre) - sense * 0.5 * ball / gear.base_helix_angle().cos();
            let middle = gear.reference_diameter() + 2.0 * sense * gear.profile_shift * gear.module;
            near(gear.diameter_at_roll(roll), middle);
            let across = centre + sense * ball;
            near(
                2.0 * gear.radial_dimension_over_ball(ball, gear.nominal_thickness()),
                across,
            );
            match member.over_pins(ball) {
                Some(pins) if gear.helix != 0.0 => near(pins.nominal, across),
                Some(pins) => near(pins.nominal, member.over_balls(ball).unwrap().nominal),
                None => assert!(gear.internal && gear.helix != 0.0),
            }
        }
        let ((chord, height), (constant, depth)) =
            (member.chord().unwrap(), member.constant_chord().unwrap());
        assert!(
            chord.least < chord.nominal && chord.nominal < gear.nominal_thickness() && height > 0.0
        );
        near(
            constant.nominal,
            gear.nominal_thickness() * gear.pressure_angle.cos().powi(2),
        );
        assert!(depth < height && constant.greatest < constant.nominal);
    }
    assert!(internal > 10);
}

/// Prints the processor time of an outline with 200 points of its flank, and of a pair: `cargo test --release -- --ignored flank_time --nocapture`.
#[test]
#[ignore = "a measurement of time"]
fn flank_time() {
    let mut rng = fastrand::Rng::with_seed(27);
    let members: Vec<Member> = std::iter::repeat_with(|| random_members(&mut rng, false)[0])
        .take(1000)
        .collect();
    let start = processor_ms();
    let mut points = 0;
    for member in &members {
        points += ToothOutline::new(member).map_or(0, |outline| outline.flank(100, 99).len());
    }
    let each = 1e3 * (processor_ms() - start) / members.len() as f64;
    println!("{each:.2} µs a flank of 200 points, {points} points");
    let start = processor_ms();
    let pairs = sane_pairs(1000, 28)
        .map(|pair| pair.contact_ratios().total)
        .sum::<f64>();
    let each = processor_ms() - start;
    println!("{each:.2} µs a pair with its warnings (with rejected ones), {pairs}");
}
