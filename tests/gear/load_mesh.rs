//! Loaded transmission error: Harris' V, conjugate pairs, conditions over random pairs, corners against involutes that turn, either gear driving.

use geardyn::internals::gear::cylindrical::basic_rack::BasicRack;
use geardyn::internals::gear::cylindrical::involute::InvoluteGear;
use geardyn::internals::gear::cylindrical::member::Member;
use geardyn::internals::gear::cylindrical::modification::{FlankModification, Relief};
use geardyn::internals::gear::cylindrical::pair::Pair;
use geardyn::internals::gear::load::compliance::StiffnessMethod;
use geardyn::internals::gear::load::contact_path::ContactPath;
use geardyn::internals::gear::load::iso6336::IsoStiffness;
use geardyn::internals::gear::load::material::Material;
use geardyn::internals::gear::load::mesh::{LoadedMesh, MeshOptions};
use geardyn::internals::gear::load::relief::optimal_tip_relief;
use geardyn::internals::numeric::statistics::peak_to_peak;

use crate::cases::{case, number, numbers};
use crate::verification::{order, within};

/// A gear of module 3 mm and profile A.
pub fn member(teeth: u32, helix: f64, shift: f64, internal: bool) -> Member {
    let gear = InvoluteGear {
        teeth,
        module: 3e-3,
        pressure_angle: 20f64.to_radians(),
        helix,
        profile_shift: shift,
        internal,
    };
    Member::new(gear, BasicRack::PROFILE_A, 0.03)
}

pub fn pair(teeth: [u32; 2], helix: f64, shifts: [f64; 2]) -> Pair {
    let [first, second] = [0, 1].map(|i| member(teeth[i], helix, shifts[i], false));
    Pair::new([first, second], None).unwrap()
}

pub const ISO: StiffnessMethod = StiffnessMethod::Iso6336 { webs: [None; 2] };

/// Tip reliefs of an amount from the points of single contact to the tips.
pub fn long_relief(path: &ContactPath, amount: f64) -> [FlankModification; 2] {
    let double = path.ends[1] - path.ends[0] - path.base_pitch;
    let relief = |gear: usize| FlankModification {
        tip_relief: Some(Relief {
            amount,
            from: path.flank_ends[gear][1] - double,
        }),
        ..FlankModification::default()
    };
    [relief(0), relief(1)]
}

/// Constant pair stiffness k, 1 < ε_α < 2, linear relief Δ from D to E and from B to A: the peak-to-peak of e is |W/k − Δ|/2 for every W.
#[test]
fn exact_harris_v() {
    let pair = pair([34, 34], 0.0, [0.0; 2]);
    let path = ContactPath::new(&pair);
    let iso = IsoStiffness::new(&pair, &[Material::default(); 2], [None; 2]);
    let (width, delta) = (pair.members[0].face_width, 15e-6);
    let k = iso.single * width;
    let options = MeshOptions {
        method: ISO,
        modifications: long_relief(&path, delta),
        slices: 1,
        ..MeshOptions::default()
    };
    let mesh = LoadedMesh::new(&pair, options).unwrap();
    let loads = [0.02, 0.3, 0.8, 1.0, 1.3, 2.0, 3.0].map(|share| share * k * delta);
    let torques = loads.map(|w| w * path.base[0]);
    let result = mesh.map(&torques).unwrap();
    let mut worst = 0.0f64;
    for (cycle, load) in result.cycles.iter().zip(loads) {
        let exact = 0.5 * (load / k - delta).abs();
        worst = worst.max((cycle.peak_to_peak() - exact).abs() / delta);
    }
    within("peak-to-peak loaded", worst, 1e-12);
    let unloaded = peak_to_peak(&result.unloaded_te);
    within(
        "peak-to-peak unloaded",
        (unloaded / (0.5 * delta) - 1.0).abs(),
        1e-12,
    );
    let designed = &result.cycles[3];
    within("at W = k Δ", designed.peak_to_peak() / delta, 1e-12);
}

/// Unmodified flanks transmit without error at any centre distance, spur, helical and internal.
#[test]
fn exact_conjugate_pairs() {
    let ring = Pair::new(
        [member(22, 0.0, 0.0, false), member(71, 0.0, 0.0, true)],
        None,
    )
    .unwrap();
    let near = pair([23, 41], 0.3, [0.2, -0.1]);
    let far = Pair::new(near.members, Some(near.centre_distance * 1.006)).unwrap();
    let mut worst = 0.0f64;
    for pair in [ring, near, far, pair([17, 90], 0.0, [0.3, 0.0])] {
        let mesh = LoadedMesh::new(&pair, MeshOptions::default()).unwrap();
        let result = mesh.map(&[50.0]).unwrap();
        let errors = result
            .unloaded_te
            .iter()
            .map(|e| (e / result.driven_base_radius).abs());
        worst = errors.fold(worst, f64::max);
    }
    within("unloaded transmission error, rad", worst, 1e-14);
}

/// Lag of gear 2 about its axis until its flank touches that of gear 1 turned by `turn` from contact at the pitch point: the least over
/// the points of gear 1's outline of their angle to gear 2's outline at the same radius about gear 2. No normal, no line of action.
fn lag_by_outlines(pair: &Pair, turn: f64) -> f64 {
    let [first, second] = &pair.outlines;
    let working = |i: usize| pair.outlines[i].base_radius / pair.working_pressure_angle.cos();
    let [psi1, psi2] = [0, 1].map(|i| pair.outlines[i].half_angle(working(i)).unwrap());
    let turned = turn * f64::from(first.teeth) / f64::from(second.teeth);
    // Gear 1 at the origin turns counter-clockwise, gear 2 at (a, 0) clockwise; angles about gear 2 count clockwise from gear 1.
    let lag = |share: f64| {
        let [radius, half] = first.involute_point(share);
        let angle = turn + half - psi1;
        let (x, y) = (
            radius * angle.cos() - pair.centre_distance,
            radius * angle.sin(),
        );
        let mate = second.half_angle(x.hypot(y))?;
        Some(turned + psi2 - mate - y.atan2(-x))
    };
    let value = |share: f64| lag(share).unwrap_or(f64::INFINITY);
    let places = 4000;
    let place = |i: i32| f64::from(i.clamp(0, places)) / f64::from(places);
    let best = (0..=places)
        .min_by(|i, j| value(place(*i)).total_cmp(&value(place(*j))))
        .unwrap();
    let (mut low, mut high) = (place(best - 1), place(best + 1));
    for _ in 0..200 {
        let third = (high - low) / 3.0;
        if value(low + third) < value(high - third) {
            high -= third;
        } else {
            low += third;
        }
    }
    value(0.5 * (low + high)).min(value(place(best)))
}

/// Gaps on the line of action and of tip corners off it against outlines that are turned until they touch. The gap of a corner is the turn
/// of the gear whose flank it touches: of a corner of gear 2, that of the pair named the other way round.
#[test]
fn exact_contact_in_outlines() {
    let (mut inside, mut first, mut second) = (0.0f64, 0.0f64, 0.0f64);
    for pair in [
        pair([24, 60], 0.0, [0.2, 0.1]),
        pair([40, 21], 0.0, [0.0, 0.3]),
    ] {
        let path = ContactPath::new(&pair);
        let lag = |roll: f64| {
            let turn = (roll - path.pitch_rolls[0]) / path.base[0];
            path.base[1] * lag_by_outlines(&pair, turn)
        };
        let [one, two] = pair.members;
        let turned = ContactPath::new(&Pair::new([two, one], Some(pair.centre_distance)).unwrap());
        for share in [0.02, 0.2, 0.5, 0.9] {
            let roll = path.ends[0] + share * (path.ends[1] - path.ends[0]);
            inside = inside.max(lag(roll).abs() / path.base_pitch);
        }
        for pitches in [0.02, 0.05, 0.1] {
            let beyond = pitches * path.base_pitch;
            let after = path.place(path.ends[1] + beyond).unwrap();
            let before = path.place(path.ends[0] - beyond).unwrap();
            let other = turned.place(turned.ends[1] + beyond).unwrap();
            assert_eq!((after.corner, before.corner), (Some(0), Some(1)));
            first = first.max((after.gap / lag(path.ends[1] + beyond) - 1.0).abs());
            second = second.max((before.gap / other.gap - 1.0).abs());
        }
    }
    within("on the line of action", inside, 1e-14);
    within("corner of gear 1", first, 1e-9);
    within("corner of gear 2", second, 1e-9);
}

/// The error of the midpoint slices under misalignment, mean over loads that close 10 to 80 % of the face, falls with their number squared.
#[test]
fn order_slices() {
    let pair = pair([34, 34], 0.0, [0.0; 2]);
    let iso = IsoStiffness::new(&pair, &[Material::default(); 2], [None; 2]);
    let (width, slope) = (pair.members[0].face_width, 4e-4);
    let radius = ContactPath::new(&pair).base[0];
    let error = |slices: usize| {
        let options = MeshOptions {
            method: ISO,
            misalignment: slope,
            slices,
            ..MeshOptions::default()
        };
        let position = LoadedMesh::new(&pair, options)
            .unwrap()
            .position(0.0)
            .unwrap();
        let apart = |i: u32| {
            let touching = width * (0.1 + 0.7 * f64::from(i) / 40.0);
            let load = 0.5 * iso.single * slope * touching * touching;
            let exact = slope * (touching - 0.5 * width);
            (position.solve(load * radius, None).unwrap().approach - exact).abs()
        };
        (0..=40).map(apart).sum::<f64>() / 41.0
    };
    let errors = [15, 30, 60, 120].map(error);
    println!("{errors:?}");
    order(
        "slices along the face",
        2.0,
        (errors[0] / errors[3]).log2() / 3.0,
    );
}

/// Slices under misalignment: a triangle of load while part of the face touches, `W = k′ θ x²/2`; a trapezium afterwards.
#[test]
fn exact_misaligned_face() {
    let pair = pair([34, 34], 0.0, [0.0; 2]);
    let iso = IsoStiffness::new(&pair, &[Material::default(); 2], [None; 2]);
    let (width, slope) = (pair.members[0].face_width, 4e-4);
    let options = MeshOptions {
        method: ISO,
        misalignment: slope,
        slices: 100,
        positions: 1,
        ..MeshOptions::default()
    };
    let mesh = LoadedMesh::new(&pair, options).unwrap();
    let radius = ContactPath::new(&pair).base[0];
    let position = mesh.position(0.0).unwrap();
    let approach = |load: f64| position.solve(load * radius, None).unwrap().approach;
    let whole = 0.5 * iso.single * slope * width * width;
    let part = 0.3 * whole;
    let touching = (2.0 * part / (iso.single * slope)).sqrt();
    let exact = slope * (touching - 0.5 * width);
    within(
        "part of the face",
        (approach(part) - exact).abs() / (slope * width),
        1e-5,
    );
    let exact = 1.7 * whole / (iso.single * width);
    within(
        "whole face",
        (approach(1.7 * whole) / exact - 1.0).abs(),
        1e-12,
    );
    let transitions = position
        .transitions(0.2 * whole * radius, 3.0 * whole * radius)
        .unwrap();
    let last = transitions.last().unwrap() / radius;
    within(
        "load that closes the face",
        (last / whole - 1.0).abs(),
        0.015,
    );
}

/// A helical pair with relief, crowning and misalignment against a script with its own outline, adaptive quadrature and root search:
/// errors with and without load, and tangent stiffness.
/// Source: computed, tools/reference_mesh.py with SciPy.
#[test]
fn ref_loaded_helical_pair() {
    let case = case("loaded_mesh");
    let inputs = &case["inputs"];
    let of = |key: &str| number(&inputs[key]);
    let [tips, shifts, relief, length, crowning] = [
        "tip_diameter",
        "profile_shift",
        "relief",
        "relief_length",
        "helix_crowning",
    ]
    .map(|key| numbers(&inputs[key]));
    let members = [0, 1].map(|i| {
        let teeth = inputs["teeth"][i].as_u64().unwrap() as u32;
        let mut member = member(teeth, of("helix_angle_deg").to_radians(), shifts[i], false);
        member.face_width = of("face_width");
        member.tip_diameter = Some(tips[i]);
        member
    });
    let pair = Pair::new(members, Some(of("centre_distance"))).unwrap();
    let path = ContactPath::new(&pair);
    let modifications = [0, 1].map(|i| FlankModification {
        tip_relief: Some(Relief {
            amount: relief[i],
            from: path.flank_ends[i][1] - length[i],
        }),
        helix_crowning: crowning[i],
        ..FlankModification::default()
    });
    let options = MeshOptions {
        modifications,
        misalignment: of("misalignment"),
        slices: inputs["slices"].as_u64().unwrap() as usize,
        positions: inputs["positions"].as_u64().unwrap() as usize,
        ..MeshOptions::default()
    };
    let mesh = LoadedMesh::new(&pair, options).unwrap();
    let result = mesh.map(&numbers(&inputs["torques"])).unwrap();
    let worst = |computed: &[f64], reference: &serde_json::Value| {
        let pairs = computed.iter().zip(numbers(reference));
        pairs.map(|(x, r)| (x / r - 1.0).abs()).fold(0.0, f64::max)
    };
    within(
        "unloaded e",
        worst(&result.unloaded_te, &case["unloaded_te"]),
        1e-8,
    );
    for (i, cycle) in result.cycles.iter().enumerate() {
        within(
            &format!("e at {} N·m", cycle.torque),
            worst(&cycle.te, &case["te"][i]),
            1e-7,
        );
        let stiffness = worst(&cycle.tangent, &case["tangent"][i]);
        within(&format!("k at {} N·m", cycle.torque), stiffness, 1e-7);
    }
}

/// Constant pair stiffness: over W₁ to W₂ the long relief of least peak-to-peak is Δ = (W₁ + W₂)/(2 k), which leaves (W₂ − W₁)/(4 k).
#[test]
fn exact_least_relief() {
    let pair = pair([34, 34], 0.0, [0.0; 2]);
    let iso = IsoStiffness::new(&pair, &[Material::default(); 2], [None; 2]);
    let k = iso.single * pair.members[0].face_width;
    let radius = ContactPath::new(&pair).base[0];
    let (low, high) = (1000.0, 3000.0);
    let options = MeshOptions {
        method: ISO,
        slices: 1,
        positions: 40,
        ..MeshOptions::default()
    };
    let least = optimal_tip_relief(&pair, &options, [low * radius, high * radius]).unwrap();
    let amount = 0.5 * (low + high) / k;
    within(
        "amount",
        (least.reliefs[0].amount / amount - 1.0).abs(),
        1e-4,
    );
    let worst = least
        .peak_to_peak
        .iter()
        .fold(0.0f64, |most, p| most.max(*p));
    within(
        "peak-to-peak left",
        (worst / (0.25 * (high - low) / k) - 1.0).abs(),
        1e-4,
    );
    assert!(
        least
            .without
            .iter()
            .zip(&least.peak_to_peak)
            .all(|(w, p)| w >= p)
    );
}

/// One pair alone at the pitch point of spur teeth: the contact stress `Z_H Z_E √(F_t/(d₁ b) (u ± 1)/u)` of ISO 6336-2, without Z_ε.
#[test]
fn exact_pressure_at_pitch_point() {
    let ring = Pair::new(
        [member(22, 0.0, 0.0, false), member(91, 0.0, 0.0, true)],
        None,
    )
    .unwrap();
    let mut worst = 0.0f64;
    for (pair, sign) in [(pair([34, 51], 0.0, [0.2, 0.1]), 1.0), (ring, -1.0)] {
        let gear = &pair.members[0].gear;
        let options = MeshOptions {
            positions: 1,
            slices: 1,
            ..MeshOptions::default()
        };
        let torque = 2.0;
        let result = LoadedMesh::new(&pair, options)
            .unwrap()
            .map(&[torque])
            .unwrap();
        let cycle = &result.cycles[0];
        assert!(cycle.shares[0].iter().filter(|s| **s > 0.0).count() == 1);
        let (at, awt) = (
            gear.transverse_pressure_angle(),
            pair.working_pressure_angle,
        );
        let zone = (2.0 * awt.cos() / (at.cos().powi(2) * awt.sin())).sqrt();
        let elasticity = (206e9 / (2.0 * std::f64::consts::PI * (1.0 - 0.09))).sqrt();
        let (d, width, ratio) = (
            gear.reference_diameter(),
            pair.members[0].face_width,
            pair.ratio(),
        );
        let force = 2.0 * torque / d;
        let stress = zone * elasticity * (force / (d * width) * (ratio + sign) / ratio).sqrt();
        worst = worst.max((cycle.pressure[0].unwrap() / stress - 1.0).abs());
    }
    within("contact stress", worst, 1e-12);
}
