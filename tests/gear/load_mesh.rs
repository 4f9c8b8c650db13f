//! Loaded transmission error: Harris' V, conjugate pairs, conditions over random pairs, corners against involutes that turn, either gear driving.

use geardyn::internals::gear::cylindrical::basic_rack::BasicRack;
use geardyn::internals::gear::cylindrical::involute::InvoluteGear;
use geardyn::internals::gear::cylindrical::member::Member;
use geardyn::internals::gear::cylindrical::pair::Pair;
use geardyn::internals::gear::load::compliance::{StiffnessMethod, compare_methods};
use geardyn::internals::gear::load::contact_path::ContactPath;
use geardyn::internals::gear::load::hertz::ContactModel;
use geardyn::internals::gear::load::iso6336::IsoStiffness;
use geardyn::internals::gear::load::material::Material;
use geardyn::internals::gear::load::mesh::{LoadedMesh, MeshOptions, MeshResult, peak_to_peak};
use geardyn::internals::gear::load::modification::{Modification, Relief};
use geardyn::internals::gear::load::relief::least_peak_to_peak;

use crate::verification::within;

/// A gear of module 3 mm and profile A.
fn member(teeth: u32, helix: f64, shift: f64, internal: bool) -> Member {
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

fn pair(teeth: [u32; 2], helix: f64, shifts: [f64; 2]) -> Pair {
    let [first, second] = [0, 1].map(|i| member(teeth[i], helix, shifts[i], false));
    Pair::new([first, second], None).unwrap()
}

const ISO: StiffnessMethod = StiffnessMethod::Iso6336 { webs: [None; 2] };

/// Tip reliefs of an amount from the points of single contact to the tips.
fn long_relief(path: &ContactPath, amount: f64) -> [Modification; 2] {
    let double = path.ends[1] - path.ends[0] - path.base_pitch;
    let relief = |gear: usize| Modification {
        tip_relief: Some(Relief {
            amount,
            from: path.flank_ends[gear][1] - double,
        }),
        ..Modification::default()
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

/// Gaps on the line of action and of tip corners off it against outlines that are turned until they touch. A corner of gear 1 is exact;
/// that of gear 2 is linear in the gap, whose second order shows.
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
        for share in [0.02, 0.2, 0.5, 0.9] {
            let roll = path.ends[0] + share * (path.ends[1] - path.ends[0]);
            inside = inside.max(lag(roll).abs() / path.base_pitch);
        }
        for pitches in [0.02, 0.05, 0.1] {
            let apart = |roll: f64| {
                let place = path.place(roll).unwrap();
                assert!(place.corner.is_some());
                (place.gap / place.arm / lag(roll) - 1.0).abs()
            };
            first = first.max(apart(path.ends[1] + pitches * path.base_pitch));
            second = second.max(apart(path.ends[0] - pitches * path.base_pitch));
        }
    }
    within("on the line of action", inside, 1e-14);
    within("corner of gear 1", first, 1e-9);
    within("corner of gear 2", second, 2e-3);
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

/// The second gear driving: the same errors, stiffness and shares, the cycle backward. Corners are kept off by relief; where they carry,
/// the arms about the two driven gears differ.
#[test]
fn law_second_gear_drives() {
    let one = pair([19, 43], 0.25, [0.3, 0.1]);
    let two = Pair::new([one.members[1], one.members[0]], Some(one.centre_distance)).unwrap();
    let relieved = |amount: f64| {
        let path = ContactPath::new(&one);
        let modifications = long_relief(&path, amount);
        let options = |modifications| MeshOptions {
            modifications,
            ..MeshOptions::default()
        };
        let [first, second] = modifications;
        let forward = LoadedMesh::new(&one, options([first, second])).unwrap();
        let backward = LoadedMesh::new(&two, options([second, first])).unwrap();
        let torques = [20.0, 60.0];
        let geared = torques.map(|t| t * path.base[1] / path.base[0]);
        (
            forward.map(&torques).unwrap(),
            backward.map(&geared).unwrap(),
        )
    };
    let apart = |(one, other): (_, _)| {
        let (one, other): (MeshResult, MeshResult) = (one, other);
        let n = one.pinion_angles.len();
        let mut worst = 0.0f64;
        for (a, b) in one.cycles.iter().zip(&other.cycles) {
            for i in 0..n {
                let j = (n - i) % n;
                worst = worst.max((a.te[i] / b.te[j] - 1.0).abs());
                worst = worst.max((a.tangent[i] / b.tangent[j] - 1.0).abs());
                worst = worst.max((a.secant[i] / b.secant[j] - 1.0).abs());
                worst = worst.max((a.pressure[i].unwrap() / b.pressure[j].unwrap() - 1.0).abs());
            }
        }
        worst
    };
    let (forward, backward) = relieved(100e-6);
    assert!(
        forward
            .cycles
            .iter()
            .all(|c| c.corner_share.iter().all(|s| *s == 0.0))
    );
    assert!(apart((forward, backward)) < 1e-10);
    assert!(apart(relieved(0.0)) < 0.05);
}

/// Mirrored teeth give the same bits, and lengths 25.4 times as large with torques 25.4³ times as large the same ratios.
#[test]
fn law_mirror_and_scale() {
    let plus = pair([19, 43], 0.25, [0.3, 0.1]);
    let minus = pair([19, 43], -0.25, [0.3, 0.1]);
    let map = |pair: &Pair, scale: f64| {
        let method = StiffnessMethod::Energy {
            bodies: Default::default(),
            contact: ContactModel::Logarithmic {
                line_load: 300e3 * scale,
            },
        };
        let mesh = LoadedMesh::new(
            pair,
            MeshOptions {
                method,
                ..MeshOptions::default()
            },
        )
        .unwrap();
        mesh.map(&[80.0 * scale.powi(3)]).unwrap()
    };
    let one = map(&plus, 1.0);
    assert_eq!(one, map(&minus, 1.0));
    let members = plus.members.map(|mut m| {
        m.gear.module *= 25.4;
        m.face_width *= 25.4;
        m.tip_diameter = m.tip_diameter.map(|d| 25.4 * d);
        m
    });
    let large = map(
        &Pair::new(members, Some(25.4 * plus.centre_distance)).unwrap(),
        25.4,
    );
    for (a, b) in one.cycles[0].te.iter().zip(&large.cycles[0].te) {
        assert!((b / a / 25.4 - 1.0).abs() < 1e-10, "{a} {b}");
    }
}

/// Half planes with the contact of Weber and Banaschek are the theory behind c′_th of ISO 6336-1: within 12 % of it on spur pairs.
#[test]
fn law_energy_near_iso_theory() {
    let steel = [Material::default(); 2];
    for teeth in [[24, 95], [30, 30], [62, 62], [20, 60]] {
        let pair = pair(teeth, 0.0, [0.0; 2]);
        let rows = compare_methods(&pair, &[StiffnessMethod::default(), ISO], &steel).unwrap();
        let iso = IsoStiffness::new(&pair, &steel, [None; 2]);
        let theory = iso.theoretical * iso.rack_factor;
        let ratio = rows[0].single / theory;
        assert!((0.88..1.12).contains(&ratio), "{teeth:?}: {ratio}");
        assert!(rows[0].at_pitch_point <= rows[0].single * (1.0 + 1e-12));
        assert!((rows[1].single / iso.single - 1.0).abs() < 1e-12);
        assert!((rows[0].mesh / rows[0].single / (rows[1].mesh / iso.single) - 1.0).abs() < 0.05);
        assert_ne!(rows[0].left_out, rows[1].left_out);
    }
}

/// Torques, counts, constants and reliefs that cannot be, and pairs whose teeth do not reach each other.
#[test]
fn refuses_meshes() {
    let pair = pair([20, 30], 0.0, [0.0; 2]);
    let refused = |options: MeshOptions| LoadedMesh::new(&pair, options).unwrap_err().code.as_str();
    assert_eq!(
        refused(MeshOptions {
            slices: 0,
            ..MeshOptions::default()
        }),
        "out-of-range"
    );
    assert_eq!(
        refused(MeshOptions {
            positions: 0,
            ..MeshOptions::default()
        }),
        "out-of-range"
    );
    assert_eq!(
        refused(MeshOptions {
            misalignment: f64::NAN,
            ..MeshOptions::default()
        }),
        "out-of-range"
    );
    let soft = Material {
        young: 0.0,
        poisson: 0.3,
    };
    assert_eq!(
        refused(MeshOptions {
            materials: [soft; 2],
            ..MeshOptions::default()
        }),
        "out-of-range"
    );
    let beyond = Modification {
        tip_relief: Some(Relief {
            amount: 10e-6,
            from: 1.0,
        }),
        ..Modification::default()
    };
    assert_eq!(
        refused(MeshOptions {
            modifications: [beyond; 2],
            ..MeshOptions::default()
        }),
        "out-of-range"
    );
    let mesh = LoadedMesh::new(&pair, MeshOptions::default()).unwrap();
    assert_eq!(mesh.map(&[0.0]).unwrap_err().code.as_str(), "out-of-range");
    assert_eq!(
        mesh.map(&[f64::INFINITY]).unwrap_err().code.as_str(),
        "out-of-range"
    );
    let apart = Pair::new(pair.members, Some(pair.centre_distance + 7e-3)).unwrap();
    let refusal = LoadedMesh::new(&apart, MeshOptions::default()).unwrap_err();
    assert_eq!(refusal.code.as_str(), "out-of-range");
}

/// A helical pair with relief, crowning and misalignment against a script with its own outline, adaptive quadrature and root search:
/// errors with and without load, and tangent stiffness.
/// Source: computed, tools/reference_mesh.py with SciPy.
#[test]
fn ref_loaded_helical_pair() {
    let text = std::fs::read_to_string("data/reference/gear/loaded_mesh.json").unwrap();
    let case: serde_json::Value = serde_json::from_str(&text).unwrap();
    let inputs = &case["inputs"];
    let list = |value: &serde_json::Value| -> Vec<f64> {
        value
            .as_array()
            .unwrap()
            .iter()
            .map(|x| x.as_f64().unwrap())
            .collect()
    };
    let number = |key: &str| inputs[key].as_f64().unwrap();
    let [tips, shifts, relief, length, crowning] = [
        "tip_diameter",
        "profile_shift",
        "relief",
        "relief_length",
        "helix_crowning",
    ]
    .map(|key| list(&inputs[key]));
    let members = [0, 1].map(|i| {
        let teeth = inputs["teeth"][i].as_u64().unwrap() as u32;
        let mut member = member(
            teeth,
            number("helix_angle_deg").to_radians(),
            shifts[i],
            false,
        );
        member.face_width = number("face_width");
        member.tip_diameter = Some(tips[i]);
        member
    });
    let pair = Pair::new(members, Some(number("centre_distance"))).unwrap();
    let path = ContactPath::new(&pair);
    let modifications = [0, 1].map(|i| Modification {
        tip_relief: Some(Relief {
            amount: relief[i],
            from: path.flank_ends[i][1] - length[i],
        }),
        helix_crowning: crowning[i],
        ..Modification::default()
    });
    let options = MeshOptions {
        modifications,
        misalignment: number("misalignment"),
        slices: inputs["slices"].as_u64().unwrap() as usize,
        positions: inputs["positions"].as_u64().unwrap() as usize,
        ..MeshOptions::default()
    };
    let mesh = LoadedMesh::new(&pair, options).unwrap();
    let result = mesh.map(&list(&inputs["torques"])).unwrap();
    let worst = |computed: &[f64], reference: &serde_json::Value| {
        let pairs = computed.iter().zip(list(reference));
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
    let least = least_peak_to_peak(&pair, &options, [low * radius, high * radius]).unwrap();
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

/// Energy method, helical: the relief lowers the worst peak-to-peak of the range, and no other amount of the same length is better.
#[test]
fn law_least_relief() {
    let pair = pair([23, 57], 0.2, [0.1, 0.0]);
    let options = MeshOptions {
        slices: 5,
        positions: 20,
        ..MeshOptions::default()
    };
    let least = least_peak_to_peak(&pair, &options, [60.0, 120.0]).unwrap();
    let worst = |values: &[f64]| values.iter().fold(0.0f64, |most, p| most.max(*p));
    assert!(worst(&least.peak_to_peak) < worst(&least.without));
    for factor in [0.5, 0.9, 1.1, 2.0] {
        let modifications = least.reliefs.map(|relief| Modification {
            tip_relief: Some(Relief {
                amount: factor * relief.amount,
                ..relief
            }),
            ..Modification::default()
        });
        let mesh = LoadedMesh::new(
            &pair,
            MeshOptions {
                modifications,
                ..options.clone()
            },
        )
        .unwrap();
        let result = mesh.map(&least.torques).unwrap();
        let other: Vec<f64> = result.cycles.iter().map(|c| c.peak_to_peak()).collect();
        assert!(worst(&other) >= worst(&least.peak_to_peak), "{factor}");
    }
}

/// Springs of one pair's curve, a pitch apart, carry the load at the approach of the map: relief, crowning, helix.
#[test]
fn law_pair_curve() {
    let pair = pair([23, 57], 0.2, [0.1, 0.0]);
    let path = ContactPath::new(&pair);
    let mut modifications = long_relief(&path, 8e-6);
    modifications[0].helix_crowning = 5e-6;
    let options = MeshOptions {
        modifications,
        slices: 7,
        positions: 12,
        ..MeshOptions::default()
    };
    let mesh = LoadedMesh::new(&pair, options).unwrap();
    let torque = 90.0;
    let (curve, result) = (
        mesh.pair_curve(torque).unwrap(),
        mesh.map(&[torque]).unwrap(),
    );
    assert!(curve.angles.windows(2).all(|w| w[1] > w[0]));
    let mut worst = 0.0f64;
    for (i, te) in result.cycles[0].te.iter().enumerate() {
        let springs = (i..curve.angles.len()).step_by(12);
        let force = |j: usize| match curve.gap[j].is_finite() {
            true => curve.stiffness[j] * (-te - curve.gap[j]).max(0.0),
            false => 0.0,
        };
        let load: f64 = springs.map(force).sum();
        worst = worst.max((load * path.base[0] / torque - 1.0).abs());
    }
    assert!(worst < 1e-10, "{worst}");
}

/// The mean tangent stiffness of unmodified spur teeth under a small load is the mean of the table of methods: corners add little.
#[test]
fn law_mean_stiffness() {
    let pair = pair([28, 45], 0.0, [0.1, 0.0]);
    let options = MeshOptions {
        slices: 1,
        positions: 2000,
        ..MeshOptions::default()
    };
    let mesh = LoadedMesh::new(&pair, options).unwrap();
    let tangent = mesh.map(&[0.01]).unwrap().cycles.remove(0).tangent;
    let mean = tangent.iter().sum::<f64>() / tangent.len() as f64;
    let steel = [Material::default(); 2];
    let rows = compare_methods(&pair, &[StiffnessMethod::default()], &steel).unwrap();
    let width = pair.members[0].face_width;
    assert!(
        (mean / (rows[0].mesh * width) - 1.0).abs() < 3e-3,
        "{mean} {}",
        rows[0].mesh * width
    );
}

/// Few teeth, large shifts, ratio 100, contact ratio below 1, a pinion at its pointed tip, a load of 1e6 times the usual: finite results
/// or a refusal with its reason.
#[test]
fn survives_extreme_pairs() {
    let mut computed = 0;
    for (teeth, shifts) in [
        ([5, 30], [0.6, 0.0]),
        ([8, 8], [0.8, 0.8]),
        ([20, 2000], [0.0, 0.0]),
        ([7, 700], [0.7, 0.0]),
        ([60, 60], [-0.8, -0.8]),
    ] {
        let members = [0, 1].map(|i| member(teeth[i], 0.0, shifts[i], false));
        for wider in [0.0, 1e-3, 3e-3] {
            let Ok(nominal) = Pair::new(members, None) else {
                continue;
            };
            let distance = nominal.centre_distance + wider;
            let Ok(pair) = Pair::new(nominal.members, Some(distance)) else {
                continue;
            };
            let mesh = match LoadedMesh::new(&pair, MeshOptions::default()) {
                Ok(mesh) => mesh,
                Err(refusal) => {
                    assert!(!refusal.message.is_empty());
                    continue;
                }
            };
            match mesh.map(&[1e-3, 50.0, 1e8]) {
                Ok(result) => {
                    computed += 1;
                    for cycle in &result.cycles {
                        let numbers = cycle.te.iter().chain(&cycle.secant).chain(&cycle.tangent);
                        assert!(numbers.clone().all(|x| x.is_finite()));
                        assert!(cycle.pressure.iter().flatten().all(|p| p.is_finite()));
                    }
                }
                Err(refusal) => assert_eq!(refusal.code.as_str(), "out-of-range", "{refusal}"),
            }
        }
    }
    println!("{computed} of 15 computed");
    assert!(computed >= 8, "{computed}");
}
