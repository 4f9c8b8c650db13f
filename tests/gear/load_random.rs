//! Loaded transmission error of random sane pairs: shares, stiffness by differences, order of secant and tangent, no NaN; speed.

use geardyn::internals::gear::cylindrical::basic_rack::BasicRack;
use geardyn::internals::gear::cylindrical::involute::InvoluteGear;
use geardyn::internals::gear::cylindrical::member::Member;
use geardyn::internals::gear::cylindrical::modification::{FlankModification, Relief};
use geardyn::internals::gear::cylindrical::pair::Pair;
use geardyn::internals::gear::load::body::Body;
use geardyn::internals::gear::load::compliance::StiffnessMethod;
use geardyn::internals::gear::load::contact_path::ContactPath;
use geardyn::internals::gear::load::mesh::{LoadedMesh, MeshOptions};

/// A pair of 12 to 90 teeth, external or internal, spur or helical, with shifts; `None` where the geometry refuses it.
fn random_pair(rng: &mut fastrand::Rng) -> Option<Pair> {
    let between = |rng: &mut fastrand::Rng, low: f64, high: f64| low + (high - low) * rng.f64();
    let internal = rng.u32(0..5) == 0;
    let first = rng.u32(12..60);
    let second = if internal {
        first + rng.u32(15..80)
    } else {
        rng.u32(12..90)
    };
    let module = between(rng, 0.5e-3, 12e-3);
    let helix = if rng.bool() {
        0.0
    } else {
        between(rng, -0.5, 0.5)
    };
    let member = |rng: &mut fastrand::Rng, teeth: u32, internal: bool| {
        let gear = InvoluteGear {
            teeth,
            module,
            pressure_angle: [20f64, 17.5, 25.0][rng.usize(0..3)].to_radians(),
            helix,
            profile_shift: between(rng, 0.0, 0.5),
            internal,
        };
        Member::new(gear, BasicRack::PROFILE_C, 10.0 * module)
    };
    let one = member(rng, first, false);
    let mut two = member(rng, second, internal);
    two.gear.pressure_angle = one.gear.pressure_angle;
    Pair::new([one, two], None).ok()
}

fn random_options(rng: &mut fastrand::Rng, pair: &Pair) -> MeshOptions {
    let path = ContactPath::new(pair);
    let module = pair.members[0].gear.module;
    let modification = |rng: &mut fastrand::Rng, gear: usize| {
        let [root, tip] = path.flank_ends[gear];
        let relief = Relief {
            amount: 5e-3 * module * rng.f64(),
            from: tip - (tip - root) * (0.1 + 0.4 * rng.f64()),
        };
        FlankModification {
            tip_relief: rng.bool().then_some(relief),
            helix_crowning: if rng.bool() {
                2e-3 * module * rng.f64()
            } else {
                0.0
            },
            profile_crowning: if rng.bool() {
                1e-3 * module * rng.f64()
            } else {
                0.0
            },
            ..FlankModification::default()
        }
    };
    let methods = [
        StiffnessMethod::default(),
        StiffnessMethod::Iso6336 { webs: [None; 2] },
        StiffnessMethod::Energy {
            bodies: [Body::Rigid; 2],
            contact: Default::default(),
        },
    ];
    MeshOptions {
        method: methods[rng.usize(0..3)],
        modifications: [modification(rng, 0), modification(rng, 1)],
        misalignment: if rng.bool() { 2e-4 * rng.f64() } else { 0.0 },
        positions: 5,
        slices: rng.usize(1..8),
        ..MeshOptions::default()
    }
}

/// Shares sum to 1, loads close the gap, secant ≤ tangent, dW/dδ by differences inside the same active set is the tangent stiffness.
fn laws_of(pair: &Pair, mesh: &LoadedMesh, rng: &mut fastrand::Rng) {
    let path = ContactPath::new(pair);
    let width = pair.members[0].face_width;
    let torque = path.base[0] * width * 10f64.powf(4.0 + 2.0 * rng.f64());
    let near = 1e-6;
    let torques = [torque, torque * (1.0 + near), 1.7 * torque];
    let result = match mesh.map(&torques) {
        Ok(result) => result,
        // More than the teeth bear.
        Err(refusal) => {
            assert_eq!(refusal.code.as_str(), "out-of-range", "{refusal}");
            return;
        }
    };
    let [one, next, more] = &result.cycles[..] else {
        panic!("three torques");
    };
    let load = torque / path.base[0];
    for i in 0..result.pinion_angles.len() {
        for cycle in &result.cycles {
            assert!((cycle.shares[i].iter().sum::<f64>() - 1.0).abs() < 1e-10);
            assert!(
                cycle.shares[i]
                    .iter()
                    .all(|s| (0.0..1.0 + 1e-10).contains(s))
            );
            assert!(cycle.secant[i] > 0.0 && cycle.secant[i] <= cycle.tangent[i] * (1.0 + 1e-9));
            assert!(cycle.te[i].is_finite() && cycle.te[i] < result.unloaded_te[i]);
            assert!(cycle.pressure[i].is_none_or(|p| p > 0.0 && p.is_finite()));
        }
        assert!(more.te[i] < one.te[i] && more.tangent[i] >= one.tangent[i] * (1.0 - 1e-9));
        let whole = one.secant[i] * (result.unloaded_te[i] - one.te[i]);
        assert!((whole / load - 1.0).abs() < 1e-9);
        let by_difference = near * load / (one.te[i] - next.te[i]);
        if one.tangent[i] == next.tangent[i] {
            assert!((by_difference / one.tangent[i] - 1.0).abs() < 1e-5);
        } else {
            assert!(by_difference >= one.tangent[i] * (1.0 - 1e-5));
        }
    }
}

/// Random pairs keep the laws; those that are refused are refused as out of range.
fn random_meshes(count: u32) {
    let mut rng = fastrand::Rng::with_seed(6336);
    let (mut computed, mut refused) = (0, 0);
    while computed < count {
        let pair = random_pair(&mut rng).and_then(|pair| {
            let options = random_options(&mut rng, &pair);
            match LoadedMesh::new(&pair, options) {
                Ok(mesh) => Some((pair, mesh)),
                Err(refusal) => {
                    assert_eq!(refusal.code.as_str(), "out-of-range", "{refusal}");
                    None
                }
            }
        });
        match pair {
            Some((pair, mesh)) => {
                laws_of(&pair, &mesh, &mut rng);
                computed += 1;
            }
            None => refused += 1,
        }
    }
    // Internal gears that the default shaper cannot cut or whose teeth leave no free centre distance.
    assert!(refused < count / 2, "{refused} refused");
}

#[test]
fn law_random_meshes() {
    random_meshes(2000);
}

/// The same over 100 000 pairs.
#[test]
#[ignore = "14 s of processor time in a development build"]
fn law_many_random_meshes() {
    random_meshes(100_000);
}

/// Processor time of this thread so far, ms (Linux).
pub fn processor_ms() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap();
    1e-6 * text.split(' ').next().unwrap().parse::<f64>().unwrap()
}

/// Processor time of k(φ) at 1 000 positions and of a Harris map; run in release: `cargo test --release speed_of_meshes -- --ignored --nocapture`.
#[test]
#[ignore = "a measurement, for release builds"]
fn speed_of_meshes() {
    let mut members = Vec::new();
    for (teeth, shift) in [(24, 0.2), (60, 0.1)] {
        let gear = InvoluteGear {
            teeth,
            module: 3e-3,
            pressure_angle: 20f64.to_radians(),
            helix: 0.0,
            profile_shift: shift,
            internal: false,
        };
        members.push(Member::new(gear, BasicRack::PROFILE_A, 0.03));
    }
    let pair = Pair::new([members[0], members[1]], None).unwrap();
    // The clock of the scheduler ticks every few milliseconds: the mean of many runs.
    let runs = 100;
    let time = |what: &str, options: MeshOptions, torques: &[f64]| {
        let run = || {
            let mesh = LoadedMesh::new(&pair, options.clone()).unwrap();
            mesh.map(torques).unwrap()
        };
        let start = processor_ms();
        let results: Vec<_> = (0..runs).map(|_| run()).collect();
        let each = (processor_ms() - start) / f64::from(runs);
        let cycle = &results[0].cycles[0];
        println!(
            "{what}: {each:.3} ms, e(0) {:.6} µm, k(0) {:.6e} N/m",
            1e6 * cycle.te[0],
            cycle.tangent[0]
        );
    };
    let one = MeshOptions {
        positions: 1000,
        slices: 1,
        ..MeshOptions::default()
    };
    time("k(φ) at 1000 positions", one, &[100.0]);
    let torques: Vec<f64> = (1..=20).map(|i| 15.0 * f64::from(i)).collect();
    time(
        "20 torques, 60 positions, 11 slices",
        MeshOptions::default(),
        &torques,
    );
}
