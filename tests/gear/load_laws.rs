//! Laws of a loaded mesh: either gear driving, mirror and scale, pair curves, mean stiffness, least relief; refusals and extremes.

use geardyn::internals::gear::cylindrical::modification::{FlankModification, Relief};
use geardyn::internals::gear::cylindrical::pair::Pair;
use geardyn::internals::gear::load::body::Body;
use geardyn::internals::gear::load::compliance::{StiffnessMethod, compare_methods};
use geardyn::internals::gear::load::contact_path::ContactPath;
use geardyn::internals::gear::load::hertz::ContactModel;
use geardyn::internals::gear::load::iso6336::IsoStiffness;
use geardyn::internals::gear::load::material::Material;
use geardyn::internals::gear::load::mesh::{LoadedMesh, MeshOptions};
use geardyn::internals::gear::load::mesh_result::MeshResult;
use geardyn::internals::gear::load::relief::optimal_tip_relief;

use crate::load_mesh::{ISO, long_relief, member, pair};
use crate::verification::within;

/// The second gear driving: the same errors, stiffness and pressure, the cycle backward; where relief keeps corners off, and where they carry.
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
                worst = worst.max((a.corner_share[i] - b.corner_share[j]).abs());
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
    within("relieved", apart((forward, backward)), 1e-10);
    let (forward, backward) = relieved(0.0);
    assert!(forward.cycles[1].corner_share.iter().any(|s| *s > 0.02));
    within("on corners", apart((forward, backward)), 1e-10);
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
    let beyond = FlankModification {
        tip_relief: Some(Relief {
            amount: 10e-6,
            from: 1.0,
        }),
        ..FlankModification::default()
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
    for bore_radius in [0.0, 1e-3, 0.04, f64::NAN] {
        let method = StiffnessMethod::Energy {
            bodies: [Body::Ring { bore_radius }; 2],
            contact: ContactModel::default(),
        };
        assert_eq!(
            refused(MeshOptions {
                method,
                ..MeshOptions::default()
            }),
            "out-of-range"
        );
    }
    let apart = Pair::new(pair.members, Some(pair.centre_distance + 7e-3)).unwrap();
    let refusal = LoadedMesh::new(&apart, MeshOptions::default()).unwrap_err();
    assert_eq!(refusal.code.as_str(), "out-of-range");
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
    let least = optimal_tip_relief(&pair, &options, [60.0, 120.0]).unwrap();
    let worst = |values: &[f64]| values.iter().fold(0.0f64, |most, p| most.max(*p));
    assert!(worst(&least.peak_to_peak) < worst(&least.without));
    for factor in [0.5, 0.9, 1.1, 2.0] {
        let modifications = least.reliefs.map(|relief| FlankModification {
            tip_relief: Some(Relief {
                amount: factor * relief.amount,
                ..relief
            }),
            ..FlankModification::default()
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
            // No tooth bears a load that deflects it by more than a twentieth of the module.
            let refusal = mesh.map(&[1e8]).unwrap_err();
            assert!(refusal.code.as_str() == "out-of-range" && refusal.hint.is_some());
            match mesh.map(&[1e-3, 50.0]) {
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
