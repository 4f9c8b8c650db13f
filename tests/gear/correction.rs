//! Correction of machine settings: sensitivities against differences of exact envelopes, settings recovered from a measured grid.

use geardyn::internals::gear::bevel::cutter::{Blade, Cutter};
use geardyn::internals::gear::bevel::flank_grid::FlankGrid;
use geardyn::internals::gear::bevel::tooth_section::ToothSection;
use geardyn::internals::gear::contact::pair::{Assembly, FlankPair};
use geardyn::internals::gear::cut::correction::{CorrectionProblem, Unknown};
use geardyn::internals::gear::cut::dial::{Dial, DialSteps};
use geardyn::internals::gear::cut::measured_flank::{FlankNode, MeasuredFlank};
use geardyn::internals::gear::cut::root_point::RootPoint;
use geardyn::internals::gear::cut::sensitivity::MachineChain;
use geardyn::internals::gear::cut::setting::{FlankSetup, Setting, SettingKind};
use geardyn::internals::gear::cut::shapes::residual_shapes;
use geardyn::internals::gear::cut::target::EaseOffTarget;
use geardyn::internals::gear::hand::Hand;

use crate::bevel_flank::{gear_38_51, nasa_cut};
use crate::cases::{case, number, numbers};
use crate::verification::within;

const ARCMIN: f64 = std::f64::consts::PI / 10_800.0;

/// A cut of the cases in metres.
fn scaled(setup: FlankSetup, section: ToothSection, unit: f64) -> (FlankSetup, ToothSection) {
    let lengths = [
        Setting::PointRadius,
        Setting::RadialDistance,
        Setting::BlankOffset,
        Setting::SlidingBase,
        Setting::CentreToBack,
    ];
    let scale = |setup: FlankSetup, of: Setting| setup.with(of, unit * setup.value(of));
    let corners = section
        .corners
        .map(|end| end.map(|place| place.map(|x| unit * x)));
    (
        lengths.into_iter().fold(setup, scale),
        ToothSection { corners },
    )
}

/// The gear of c16 in m.
fn gear() -> (FlankSetup, ToothSection) {
    let (setup, section) = gear_38_51(&case("c16_gear_38_51_flank"));
    scaled(setup, section, 1e-3)
}

/// A pinion of c12 in m.
fn pinion() -> (FlankSetup, Hand, ToothSection) {
    let (setup, hand, section) = nasa_cut(&case("c12_nasa_cr191009_flanks"), "pinion_concave");
    let (setup, section) = scaled(setup, section, 0.0254);
    (setup, hand, section)
}

fn reach(setting: Setting) -> f64 {
    match setting {
        Setting::Ratio => 1e-3,
        Setting::ProfileCurvature => 1.0,
        Setting::ModifiedRoll(k) => [1e-2, 1e-1, 1.0, 10.0][k],
        _ => match setting.kind() {
            SettingKind::Angle => 10.0 * ARCMIN,
            _ => 1e-4,
        },
    }
}

fn unknowns(settings: &[Setting]) -> Vec<Unknown> {
    let unknown = |setting: &Setting| Unknown {
        setting: *setting,
        flanks: vec![0],
        reach: reach(*setting),
    };
    settings.iter().map(unknown).collect()
}

/// Nodes of a flank at `rows` by `columns` shares within its section, a twentieth from its edges, where the blade leaves it.
fn nodes(
    setup: &FlankSetup,
    hand: Hand,
    section: ToothSection,
    [rows, columns]: [usize; 2],
) -> Vec<FlankNode> {
    let flank = setup.flank(hand, section);
    let middle = flank.middle().unwrap();
    let share = |i: usize, n: usize| 0.05 + 0.9 * i as f64 / (n - 1) as f64;
    let places = (0..columns).flat_map(|j| (0..rows).map(move |i| (i, j)));
    let nodes: Vec<FlankNode> = places
        .filter_map(|(i, j)| {
            let place = section.at(share(j, columns), share(i, rows));
            FlankNode::of(&flank, place, middle)
        })
        .collect();
    assert!(2 * nodes.len() >= rows * columns);
    nodes
}

/// Exact distances of a changed flank along the normals of nodes.
fn distances(
    nodes: &[FlankNode],
    setup: &FlankSetup,
    hand: Hand,
    section: ToothSection,
) -> Vec<f64> {
    let envelope = setup.flank(hand, section).envelope;
    let distance = |n: &FlankNode| envelope.intersect_ray(n.point, n.normal, n.at).unwrap().1;
    nodes.iter().map(distance).collect()
}

/// The cut by a blade whose profile is an arc.
fn curved(setup: FlankSetup) -> FlankSetup {
    FlankSetup {
        cutter: Cutter {
            profile_curvature: 1.0 / 0.3,
            profile_height: 0.004,
            ..setup.cutter
        },
        ..setup
    }
}

/// `n·∂r/∂p` of every setting and cutter parameter, of straight and curved blades on a tilted machine with modified roll and helical motion of either hand, against fourth-order
/// differences of the exact envelope.
#[test]
fn law_columns_are_derivatives_of_the_envelope() {
    for (hand, is_curved) in [
        (Hand::Left, false),
        (Hand::Right, false),
        (Hand::Left, true),
    ] {
        let (setup, section) = gear();
        let setup = if is_curved { curved(setup) } else { setup };
        let setup = [
            (Setting::TiltCosine, 0.004),
            (Setting::TiltSine, -0.003),
            (Setting::HelicalMotion, 5e-4),
            (Setting::ModifiedRoll(0), 0.01),
            (Setting::ModifiedRoll(1), -0.02),
        ]
        .into_iter()
        .fold(setup, |setup, (setting, value)| setup.with(setting, value));
        let nodes = nodes(&setup, hand, section, [3, 4]);
        for setting in Setting::ALL {
            let step = 0.1 * reach(setting);
            let at = |by: f64| distances(&nodes, &setup.changed(setting, by * step), hand, section);
            let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(at);
            let (mut apart, mut size) = (0f64, 0f64);
            for (k, node) in nodes.iter().enumerate() {
                let [s, theta, x] = node.at;
                let chain = MachineChain::at(&setup, hand, x);
                let column = node
                    .normal
                    .components
                    .dot(chain.displacement(setting, [s, theta]));
                let difference = (a[k] - 8.0 * b[k] + 8.0 * c[k] - d[k]) / (12.0 * step);
                apart = apart.max((column - difference).abs());
                size = size.max(column.abs());
            }
            assert!(size > 0.0, "{setting:?} moves nothing");
            assert!(apart < 1e-6 * size, "{setting:?}: {apart:e} of {size:e}");
        }
    }
}

/// Deviations of a gear cut with four wrong settings: the print of the case has a millionth of a micrometre.
/// Source: exact distances of the changed envelope, data/reference/gear/c30_settings_recovered.json, on the gear of c16.
#[test]
fn ref_settings_from_a_measured_grid() {
    let case = case("c30_settings_recovered");
    let (setup, section) = gear();
    let flank = setup.flank(Hand::Right, section);
    let middle = flank.middle().unwrap();
    let rows: Vec<Vec<f64>> = case["rows"]
        .as_array()
        .unwrap()
        .iter()
        .map(numbers)
        .collect();
    let node =
        |row: &Vec<f64>| FlankNode::of(&flank, [1e-3 * row[0], 1e-3 * row[1]], middle).unwrap();
    let freed = [
        Setting::BladeAngle,
        Setting::RadialDistance,
        Setting::MachineRootAngle,
        Setting::Ratio,
    ];
    let problem = CorrectionProblem {
        flanks: vec![MeasuredFlank {
            setup,
            hand: Hand::Right,
            section,
            nodes: rows.iter().map(node).collect(),
            deviations: rows.iter().map(|row| 1e-6 * row[2]).collect(),
            roots: Vec::new(),
        }],
        unknowns: unknowns(&freed),
        least: 0.0,
    };
    let fit = problem.solve().unwrap();
    let hidden = &case["hidden"];
    let expected = [
        number(&hidden["blade_angle_arcmin"]) * ARCMIN,
        1e-3 * number(&hidden["radial_mm"]),
        number(&hidden["root_angle_arcmin"]) * ARCMIN,
        number(&hidden["work_over_cradle"]),
    ];
    for (k, name) in [
        "blade angle",
        "radial distance",
        "root angle",
        "ratio of roll",
    ]
    .into_iter()
    .enumerate()
    {
        within(
            &format!("{name}, of its change"),
            (fit.changes[k] / expected[k] - 1.0).abs(),
            1e-5,
        );
    }
    let largest = fit.residuals[0]
        .iter()
        .flatten()
        .fold(0f64, |most, x| most.max(x.abs()));
    within("largest rest, µm", 1e6 * largest, 1e-6);
    assert!(fit.is_converged);
}

/// Exact deviations of changed settings give the settings back, of a blade with a profile arc.
#[test]
fn exact_settings_are_recovered() {
    let (setup, section) = gear();
    let setup = curved(setup);
    let changes = [
        (Setting::BladeAngle, 5.0 * ARCMIN),
        (Setting::ProfileCurvature, 0.7),
        (Setting::RadialDistance, -9e-5),
        (Setting::MachineRootAngle, -3.0 * ARCMIN),
        (Setting::Ratio, 7e-4),
    ];
    let nodes = nodes(&setup, Hand::Right, section, [5, 9]);
    let wrong = changes
        .iter()
        .fold(setup, |s, (setting, by)| s.changed(*setting, *by));
    let problem = CorrectionProblem {
        flanks: vec![MeasuredFlank {
            setup,
            hand: Hand::Right,
            section,
            deviations: distances(&nodes, &wrong, Hand::Right, section),
            nodes,
            roots: Vec::new(),
        }],
        unknowns: unknowns(&changes.map(|(setting, _)| setting)),
        least: 0.0,
    };
    let fit = problem.solve().unwrap();
    let worst = changes
        .iter()
        .zip(&fit.changes)
        .fold(0f64, |most, ((_, by), found)| {
            most.max((found / by - 1.0).abs())
        });
    within("settings, of their change", worst, 1e-9);
    // Dials without steps: the next cut has no deviation left.
    let dials: Vec<Dial> = changes
        .iter()
        .flat_map(|(s, _)| Dial::of(*s, None))
        .collect();
    let fine = DialSteps {
        length: 1e-15,
        angle: 1e-15,
        ratio: 1e-15,
    };
    let next = problem.next_cut(&fit, &[dials], &fine, &[None]).unwrap();
    let largest = next.deviations[0]
        .iter()
        .flatten()
        .fold(0f64, |most, x| most.max(x.abs()));
    within("largest deviation of the next cut, µm", 1e6 * largest, 1e-6);
}

/// Eleven settings of which the flank shows five: the settings are not recovered, the flank is.
#[test]
fn law_five_directions_are_seen() {
    let (setup, section) = gear();
    let nodes = nodes(&setup, Hand::Right, section, [5, 9]);
    let freed = [
        Setting::PointRadius,
        Setting::BladeAngle,
        Setting::RadialDistance,
        Setting::CradleAngle,
        Setting::BlankOffset,
        Setting::SlidingBase,
        Setting::CentreToBack,
        Setting::MachineRootAngle,
        Setting::TiltCosine,
        Setting::TiltSine,
        Setting::Ratio,
    ];
    let wrong = freed.iter().fold(setup, |s, setting| {
        s.changed(*setting, 0.5 * reach(*setting))
    });
    let problem = CorrectionProblem {
        flanks: vec![MeasuredFlank {
            setup,
            hand: Hand::Right,
            section,
            deviations: distances(&nodes, &wrong, Hand::Right, section),
            nodes,
            roots: Vec::new(),
        }],
        unknowns: unknowns(&freed),
        least: 5e-8,
    };
    let fit = problem.solve().unwrap();
    let values = fit.nominal.singular_values();
    assert_eq!((fit.kept, fit.is_converged), (5, true));
    assert!((13e-6..15e-6).contains(&values[0]) && (10e-6..12e-6).contains(&values[1]));
    assert!(values[5] < 5e-8 && values[10] < 1e-13);
    let squares: f64 = fit.residuals[0].iter().flatten().map(|x| x * x).sum();
    let rest = (squares / 45.0).sqrt();
    assert!(rest < 1e-8, "{rest:e}");
    let off = freed
        .iter()
        .zip(&fit.changes)
        .map(|(s, by)| (by / reach(*s) - 0.5).abs());
    assert!(
        off.fold(0.0, f64::max) > 0.1,
        "the flank does not show all settings"
    );
    for (k, rest) in residual_shapes(&problem.flanks, &fit.nominal, fit.kept)
        .iter()
        .enumerate()
    {
        let share = rest.share.unwrap();
        let range = match k {
            0 | 1 => 0.0..0.01,
            2..=4 => 0.01..0.1,
            5..=8 => 0.3..0.7,
            _ => 0.9..1.0,
        };
        assert!(range.contains(&share), "{}: {share}", rest.shape.name);
    }
}

/// A gear whose flanks are cut at one setting by two blades: the machine's changes are found once, the blades' for each flank, each flank turned by itself.
#[test]
fn exact_flanks_of_one_setting() {
    let (convex, hand, section) = nasa_cut(&case("c12_nasa_cr191009_flanks"), "gear_convex");
    let (convex, section) = scaled(convex, section, 0.0254);
    let concave = FlankSetup {
        cutter: Cutter {
            blade: Blade::Outside,
            point_radius: 3.0325 * 0.0254,
            ..convex.cutter
        },
        ..convex
    };
    let machine = [
        (Setting::RadialDistance, 5e-5),
        (Setting::MachineRootAngle, 2.0 * ARCMIN),
    ];
    let blades = [3.0 * ARCMIN, -4.0 * ARCMIN];
    let flank = |(setup, blade): (FlankSetup, f64)| {
        let nodes = nodes(&setup, hand, section, [4, 6]);
        let wrong = machine
            .iter()
            .fold(setup, |s, (setting, by)| s.changed(*setting, *by))
            .changed(Setting::BladeAngle, blade);
        MeasuredFlank {
            setup,
            hand,
            section,
            deviations: distances(&nodes, &wrong, hand, section),
            nodes,
            roots: Vec::new(),
        }
    };
    let unknown = |setting: Setting, flanks: &[usize]| Unknown {
        setting,
        flanks: flanks.to_vec(),
        reach: reach(setting),
    };
    let problem = CorrectionProblem {
        flanks: [convex, concave]
            .into_iter()
            .zip(blades)
            .map(flank)
            .collect(),
        unknowns: vec![
            unknown(Setting::RadialDistance, &[0, 1]),
            unknown(Setting::MachineRootAngle, &[0, 1]),
            unknown(Setting::BladeAngle, &[0]),
            unknown(Setting::BladeAngle, &[1]),
        ],
        least: 0.0,
    };
    let fit = problem.solve().unwrap();
    let expected = [machine[0].1, machine[1].1, blades[0], blades[1]];
    let worst = expected
        .iter()
        .zip(&fit.changes)
        .map(|(a, b)| (b / a - 1.0).abs());
    within("settings, of their change", worst.fold(0.0, f64::max), 1e-8);
}

/// Six settings of a pinion towards crowns of 60 µm along the face and 12 µm along the profile, from starts 2.5 to 5 mm and 1° to 2° off: at least four of
/// five end in one optimum.
#[test]
fn law_synthesis_from_far_starts() {
    let case = case("c12_nasa_cr191009_flanks");
    let (pinion, hand, section) = pinion();
    let (gear, gear_hand, gear_section) = nasa_cut(&case, "gear_convex");
    let (gear, gear_section) = scaled(gear, gear_section, 0.0254);
    let assembly = Assembly {
        shaft_angle: std::f64::consts::FRAC_PI_2,
        ..Assembly::default()
    };
    let target = EaseOffTarget {
        place: [0.5, 0.5],
        lengthwise_crowning: 60e-6,
        profile_crowning: 12e-6,
        twist: 0.0,
        te_parabola: 0.0,
    };
    let freed = [
        Setting::BladeAngle,
        Setting::PointRadius,
        Setting::RadialDistance,
        Setting::BlankOffset,
        Setting::MachineRootAngle,
        Setting::Ratio,
    ];
    let pair = |setup: &FlankSetup| {
        let flanks = [
            setup.flank(hand, section),
            gear.flank(gear_hand, gear_section),
        ];
        FlankPair::new(flanks, [12, 36], hand, &assembly)
    };
    fastrand::seed(12);
    let mut found = Vec::new();
    for _ in 0..5 {
        let start = freed.iter().fold(pinion, |setup, setting| {
            let sign = if fastrand::bool() { 1.0 } else { -1.0 };
            let size = sign * (1.0 + fastrand::f64());
            let by = match setting.kind() {
                SettingKind::Length => 2.54e-3 * size,
                SettingKind::Angle => size.to_radians(),
                SettingKind::Ratio => 0.0,
            };
            setup.changed(*setting, by)
        });
        let Some(flank) = target.on(&pair(&start), start, hand) else {
            continue;
        };
        let mut problem = CorrectionProblem {
            flanks: vec![flank],
            unknowns: unknowns(&freed),
            least: 0.0,
        };
        // The optimum lies far off in the ratio of roll.
        problem.unknowns[5].reach = 1e-2;
        let Ok(fit) = problem.solve() else {
            continue;
        };
        let rests: Vec<f64> = fit.residuals[0].iter().flatten().copied().collect();
        if rests.len() == problem.flanks[0].nodes.len() {
            let squares: f64 = rests.iter().map(|x| x * x).sum();
            found.push((squares / rests.len() as f64).sqrt());
        }
    }
    let least = found.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(least < 3e-6, "{least:e}");
    let same = found.iter().filter(|rms| **rms < 1.01 * least).count();
    assert!(same >= 4, "{found:?}");
}

/// A grid of the whole blank is found from the middle of its flank.
#[test]
fn law_nodes_are_those_of_the_grid() {
    let (setup, hand, section) = pinion();
    let flank = setup.flank(hand, section);
    let grid = FlankGrid::of(&flank, 3, 3).unwrap();
    let middle = flank.middle().unwrap();
    let node = FlankNode::of(&flank, section.at(0.5, 0.5), middle).unwrap();
    let apart = node.point.coordinates - grid.node(1, 1).unwrap().point.point.coordinates;
    assert!(apart.norm() < 1e-15);
}

/// A sliding base moves the tip plane along its normal, so that the slot becomes shallower by as much everywhere; a root angle tilts it. Heights are the least
/// over a fine grid of the roll.
#[test]
fn exact_depth_of_the_slot() {
    let (pinion, hand, section) = pinion();
    let roots = RootPoint::of(&pinion.flank(hand, section)).unwrap();
    let deeper = |setting: Setting, by: f64| {
        roots.map(|root| {
            root.depth_change(&pinion.changed(setting, by), hand)
                .unwrap()
        })
    };
    for depth in deeper(Setting::SlidingBase, 1e-4) {
        within("sliding base, m", (depth + 1e-4).abs(), 1e-12);
    }
    let [toe, middle, heel] = deeper(Setting::MachineRootAngle, 1e-3);
    let face = section.at(1.0, 0.0)[0] - section.at(0.0, 0.0)[0];
    let along_root = face / pinion.machine.machine_root_angle.cos();
    within(
        "root angle, share of its depth",
        ((heel - toe).abs() / (1e-3 * along_root) - 1.0).abs(),
        0.02,
    );
    assert!((heel - middle) * (middle - toe) > 0.0);
    let motion = pinion.machine.motion(hand);
    for root in &roots {
        let height = |k: i32| {
            let pose = motion.at(f64::from(k) * 1e-4).pose;
            pose.inverse().apply(root.point.coordinates).z
        };
        let least = (-5000..=5000).map(height).fold(f64::INFINITY, f64::min);
        within("height, m", (root.height - least).abs(), 1e-9);
    }
}
