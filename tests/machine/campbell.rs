//! Campbell diagrams: closed forms, crossings and veerings, an independent assembly.

use std::f64::consts::TAU;
use std::path::Path;

use crate::support::verification::{printed, within};
use geardyn::internals::machine::build::build;
use geardyn::internals::machine::components::Machine;
use geardyn::internals::machine::kinematics::Kinematics;
use geardyn::internals::machine::linear::LinearModel;
use geardyn::internals::machine::operating_point::OperatingPoint;
use geardyn::internals::modes::campbell::{
    CampbellBranch, CampbellDiagram, CampbellOptions, campbell_diagram,
};
use geardyn::internals::modes::damped;
use geardyn::internals::modes::excitation_orders::{
    ExcitationCause, OrderOptions, excitation_orders,
};
use geardyn::internals::modes::modal_basis::{self, ModalBasis, UndampedSolver};
use geardyn::internals::modes::modal_matrices;
use geardyn::internals::modes::mode::Mode;
use geardyn::internals::modes::tracking::TrackingOptions;
use geardyn::internals::modes::whirl::Whirl;
use geardyn::internals::numeric::Complex;
use geardyn::internals::scene;

struct Case {
    machine: Machine,
    kinematics: Kinematics,
    linear: LinearModel,
    basis: ModalBasis,
}

impl Case {
    fn of(scene: scene::Scene) -> Case {
        let machine = build(&scene.model).unwrap();
        let kinematics = Kinematics::new(&machine).unwrap();
        let operating = OperatingPoint::solve(&machine, &kinematics).unwrap();
        let model = LinearModel::new(&machine, &kinematics, &operating).unwrap();
        let basis = modal_basis::solve(&model, UndampedSolver::Factored).unwrap();
        Case {
            machine,
            kinematics,
            linear: model,
            basis,
        }
    }

    fn new(text: &str) -> Case {
        let head = "title = \"test\"\nsource = \"invented for a test\"\nunits = \"SI\"\n";
        Case::of(scene::read_text("test.toml", &format!("{head}{text}")).unwrap())
    }

    fn shipped(name: &str) -> Case {
        Case::of(
            scene::read(
                &Path::new(env!("CARGO_MANIFEST_DIR"))
                    .join("models")
                    .join(name),
            )
            .unwrap(),
        )
    }

    /// The diagram over speeds in rpm.
    fn diagram(&self, speeds_rpm: &[f64], damped: bool) -> CampbellDiagram {
        let options = CampbellOptions {
            speeds: speeds_rpm.iter().map(|rpm| rpm * TAU / 60.0).collect(),
            damped,
            orders: OrderOptions::default(),
            tracking: TrackingOptions::default(),
        };
        campbell_diagram(
            &self.machine,
            &self.kinematics,
            &self.linear,
            &self.basis,
            &options,
        )
        .unwrap()
    }

    fn modes(&self, rpm: f64, damped: bool) -> Vec<Mode> {
        let speeds = geardyn::internals::machine::kinematics::mean_speeds(
            &self.machine,
            &self.kinematics,
            Some(rpm * TAU / 60.0),
        )
        .unwrap();
        let modal = modal_matrices::project(
            &self.machine,
            &self.linear,
            &self.basis,
            Some(&speeds),
            damped,
        );
        damped::modes(&self.linear, &self.basis, &modal).unwrap()
    }
}

fn grid(first: f64, last: f64, steps: usize) -> Vec<f64> {
    (0..=steps)
        .map(|i| first + (last - first) * i as f64 / steps as f64)
        .collect()
}

/// |λ|/2π of `J_d λ² − iJΩ λ + k = 0`: forward, backward.
fn whirl_of_disc(polar: f64, diametral: f64, k: f64, rpm: f64) -> [f64; 2] {
    let spin = polar * rpm * TAU / 60.0;
    let root = (spin * spin + 4.0 * diametral * k).sqrt();
    // The smaller root as a quotient, without subtraction.
    [
        (spin + root) / (2.0 * diametral) / TAU,
        2.0 * k / (spin + root) / TAU,
    ]
}

fn worst(line: &CampbellBranch, exact: impl Fn(usize) -> f64) -> f64 {
    let relative = |(i, f): (usize, &Option<f64>)| (f.unwrap_or(f64::NAN) / exact(i) - 1.0).abs();
    line.frequency_hz
        .iter()
        .enumerate()
        .map(relative)
        .fold(0.0, |m, e| if e > m || e.is_nan() { e } else { m })
}

const ONE_DISC: &str = r#"
[[inertia]]
name = "disc"
J = 0.12
J_diametral = 0.065
[[bearing]]
name = "hub"
at = "disc"
k_rx = 4.0e5
k_ry = 4.0e5
[speed]
disc = 600.0
"#;

/// A disc that only tilts: one forward and one backward mode, in closed form at every speed.
#[test]
fn exact_whirl_of_a_tilting_disc() {
    let speeds = grid(0.0, 12000.0, 24);
    let found = Case::new(ONE_DISC).diagram(&speeds, false);
    assert_eq!(found.branches.len(), 2);
    for (line, which) in found.branches.iter().zip([Whirl::Backward, Whirl::Forward]) {
        let sense = if which == Whirl::Forward { 0 } else { 1 };
        let is_swapped = line.whirl[0] != Some(which);
        let sense = if is_swapped { 1 - sense } else { sense };
        let error = worst(line, |i| {
            whirl_of_disc(0.12, 0.065, 4.0e5, speeds[i])[sense]
        });
        within("frequencies from 0 to 12 000 rpm", error, 1e-14);
        assert!(
            line.whirl.iter().all(|w| *w == line.whirl[0]),
            "{:?}",
            line.whirl
        );
        assert!(line.uncertain_rpm.is_empty());
    }
    assert!(
        found
            .branches
            .iter()
            .all(|line| line.damping_ratio.iter().all(Option::is_none))
    );
}

/// `ω = n Ω` in the quadratic: `Ω² (n J − n² J_d) + k = 0` forward, with + JΩ² n turned round backward.
#[test]
fn exact_crossings_of_a_tilting_disc() {
    let found = Case::new(ONE_DISC).diagram(&grid(0.0, 30000.0, 6), false);
    let (polar, diametral, k) = (0.12, 0.065, 4.0e5);
    let mut exact: Vec<f64> = [1.0, 2.0]
        .iter()
        .flat_map(|&n: &f64| {
            [n * n * diametral - n * polar, n * n * diametral + n * polar]
                .into_iter()
                .filter(|a| *a > 0.0)
        })
        .map(|a| (k / a).sqrt() * 60.0 / TAU)
        .filter(|rpm| *rpm < 30000.0)
        .collect();
    exact.sort_by(f64::total_cmp);
    assert_eq!(found.crossings.len(), exact.len(), "{:?}", found.crossings);
    for (crossing, rpm) in found.crossings.iter().zip(exact) {
        within(
            "critical speeds",
            (crossing.speed_rpm / rpm - 1.0).abs(),
            1e-9,
        );
        let order = found.orders[crossing.order].value;
        assert!((crossing.frequency_hz / (order * rpm / 60.0) - 1.0).abs() < 1e-9);
        assert!(
            (crossing.participation - 1.0).abs() < 1e-12,
            "all the motion is the disc's"
        );
    }
}

const DISCS: &str = r#"
[[inertia]]
name = "a"
J = 0.12
J_diametral = 0.065
[[inertia]]
name = "b"
J = 0.01
J_diametral = 0.02
[[shaft]]
name = "shaft"
between = ["a", "b"]
k = 1.0e4
[[bearing]]
name = "hub_a"
at = "a"
k_rx = 4.0e5
k_ry = 4.0e5
[[bearing]]
name = "hub_b"
at = "b"
k_rx = 2.5e5
k_ry = 2.5e5
LINK
[speed]
a = 600.0
"#;

fn link(coupling: f64) -> String {
    format!(
        "[[bearing]]\nname = \"link\"\nbetween = [\"a\", \"b\"]\nk_rx = {coupling:?}\nk_ry = {coupling:?}\n"
    )
}

/// Two discs on one shaft; their tilts are coupled by `coupling`, N·m/rad, or not at all.
fn two_discs(coupling: f64) -> Case {
    let link = if coupling > 0.0 {
        link(coupling)
    } else {
        String::new()
    };
    Case::new(&DISCS.replace("LINK", &link))
}

/// Forward of the first disc crosses both branches of the second: each follows its own closed form, where the third or the
/// fourth frequency of every speed would jump from one to the other.
#[test]
fn exact_branches_that_cross() {
    let speeds = grid(0.0, 12000.0, 16);
    let found = two_discs(0.0).diagram(&speeds, false);
    assert_eq!(found.branches.len(), 5);
    let discs = [(0.12, 0.065, 4.0e5), (0.01, 0.02, 2.5e5)];
    let mut seen = Vec::new();
    for line in &found.branches {
        let at_last = |&(disc, sense): &(usize, usize)| {
            let (polar, diametral, k) = discs[disc];
            (line.frequency_hz[16].unwrap() / whirl_of_disc(polar, diametral, k, speeds[16])[sense]
                - 1.0)
                .abs()
        };
        let Some(own) = [(0, 0), (0, 1), (1, 0), (1, 1)]
            .into_iter()
            .find(|own| at_last(own) < 1e-9)
        else {
            assert!(
                line.whirl.iter().all(Option::is_none),
                "the torsional mode does not whirl"
            );
            continue;
        };
        let (polar, diametral, k) = discs[own.0];
        let error = worst(line, |i| {
            whirl_of_disc(polar, diametral, k, speeds[i])[own.1]
        });
        within("frequencies from 0 to 12 000 rpm", error, 1e-12);
        assert!(
            line.whirl
                .iter()
                .all(|w| *w == Some([Whirl::Forward, Whirl::Backward][own.1])),
            "{:?}",
            line.whirl
        );
        seen.push(own);
    }
    seen.sort();
    assert_eq!(seen, [(0, 0), (0, 1), (1, 0), (1, 1)]);
    let sorted = |i: usize| {
        let mut f: Vec<f64> = found
            .branches
            .iter()
            .map(|line| line.frequency_hz[i].unwrap())
            .collect();
        f.sort_by(f64::total_cmp);
        f
    };
    let third =
        |i: usize| (sorted(i)[4] / whirl_of_disc(0.12, 0.065, 4.0e5, speeds[i])[0] - 1.0).abs();
    assert!(
        third(0) > 1e-3 && third(16) < 1e-12,
        "by frequency alone the highest is another mode at the start"
    );
}

fn forward(found: &CampbellDiagram) -> Vec<&CampbellBranch> {
    let mut lines: Vec<&CampbellBranch> = found
        .branches
        .iter()
        .filter(|line| line.whirl.iter().all(|w| *w == Some(Whirl::Forward)))
        .collect();
    lines.sort_by(|a, b| a.frequency_hz[0].partial_cmp(&b.frequency_hz[0]).unwrap());
    lines
}

/// Branches of one direction repel, however weakly coupled: coarse steps find what very fine ones find.
#[test]
fn law_branches_that_veer_are_followed_at_any_step() {
    for coupling in [3.0e4, 1.0e3, 30.0, 1.0] {
        let case = two_discs(coupling);
        let coarse = case.diagram(&grid(0.0, 12000.0, 8), false);
        let fine = case.diagram(&grid(0.0, 12000.0, 512), false);
        let (coarse, fine) = (forward(&coarse), forward(&fine));
        assert_eq!((coarse.len(), fine.len()), (2, 2), "coupling {coupling}");
        for (rough, close) in coarse.iter().zip(&fine) {
            let error = worst(rough, |i| close.frequency_hz[64 * i].unwrap());
            assert!(error < 1e-12, "coupling {coupling}: {error:e}");
            assert!(
                rough.uncertain_rpm.is_empty() && close.uncertain_rpm.is_empty(),
                "coupling {coupling}"
            );
        }
        for i in 0..fine[0].frequency_hz.len() {
            assert!(
                fine[0].frequency_hz[i] < fine[1].frequency_hz[i],
                "coupling {coupling}: forward modes crossed"
            );
        }
    }
}

/// `λ(−Ω)` are those of `λ(Ω)`; the branch that goes forward on one side goes backward on the other.
#[test]
fn law_speeds_of_either_sign_mirror_each_other() {
    let case = two_discs(3.0e4);
    for rpm in [500.0, 5000.0] {
        let (plus, minus) = (case.modes(rpm, false), case.modes(-rpm, false));
        for (a, b) in plus.iter().zip(&minus) {
            assert!((a.omega() - b.omega()).abs() <= 1e-13 * a.omega());
        }
    }
    let found = case.diagram(&grid(-6000.0, 6000.0, 12), false);
    assert_eq!(found.branches.len(), 5);
    let mirrored = |line: &CampbellBranch| {
        found.branches.iter().any(|other| {
            worst(line, |i| other.frequency_hz[12 - i].unwrap()) < 1e-12 && {
                let (a, b) = (line.whirl[0], other.whirl[12]);
                a == b
            }
        })
    };
    assert!(found.branches.iter().all(mirrored));
    let turned = found
        .branches
        .iter()
        .filter(|line| line.whirl[0].is_some() && line.whirl[0] != line.whirl[12]);
    assert_eq!(
        turned.count(),
        4,
        "what is forward at −6000 rpm is backward at 6000 rpm"
    );
}

/// Gyroscopic moments do no work: every root is imaginary to the last bit, repeated ones at rest included.
#[test]
fn exact_roots_without_losses_are_imaginary() {
    for (case, n) in [
        (Case::shipped("overhung_rotor.toml"), 12),
        (two_discs(3.0e4), 5),
    ] {
        for rpm in [0.0, 1.0, 1730.0, 12000.0] {
            let modes = case.modes(rpm, false);
            let elastic: Vec<&Mode> = modes.iter().filter(|mode| !mode.rigid).collect();
            assert!(elastic.len() >= n, "{}", elastic.len());
            for mode in elastic {
                assert_eq!(mode.eigenvalue.re, 0.0, "{rpm} rpm: {:?}", mode.eigenvalue);
                assert_eq!(mode.damping_ratio, None);
                assert!(mode.residual < 1e-12, "{rpm} rpm: {:e}", mode.residual);
            }
        }
    }
}

const GEARED: &str = r#"
[[inertia]]
name = "motor"
J = 0.01
[[inertia]]
name = "pinion"
J = 0.001
[[inertia]]
name = "wheel"
J = 0.05
[[inertia]]
name = "roll"
J = 0.2
[[shaft]]
name = "motor_shaft"
between = ["motor", "pinion"]
k = 8500.0
[[shaft]]
name = "roll_shaft"
between = ["wheel", "roll"]
k = 40000.0
[[gear_pair]]
name = "pair"
between = ["pinion", "wheel"]
teeth = [21, 63]
module = 0.003
pressure_angle = 0.349
k = 4.2e8
[speed]
motor = 150.0
"#;

/// Nothing tilts: one solution, straight lines, crossings at `60 f / order`.
#[test]
fn exact_constant_without_gyroscopic_terms() {
    let case = Case::new(GEARED);
    let found = case.diagram(&grid(0.0, 6000.0, 60), false);
    assert!(found.is_constant);
    assert_eq!(found.n_solves, 1);
    for line in &found.branches {
        assert!(
            line.frequency_hz
                .iter()
                .all(|f| *f == line.frequency_hz[0] && f.is_some())
        );
        assert!(line.whirl.iter().all(Option::is_none));
    }
    assert!(!found.crossings.is_empty());
    for crossing in &found.crossings {
        let order = &found.orders[crossing.order];
        let f = found.branches[crossing.branch].frequency_hz[0].unwrap();
        assert_eq!(crossing.frequency_hz, f);
        assert!((crossing.speed_rpm - 60.0 * f / order.value).abs() < 1e-12 * crossing.speed_rpm);
        assert!((0.0..=1.0).contains(&crossing.participation));
    }
    // The mode of the mesh takes part in the mesh's orders more than the others do.
    let share = |branch: usize| {
        let mesh = |c: &&geardyn::internals::modes::campbell::OrderCrossing| {
            c.branch == branch && found.orders[c.order].fraction == "21"
        };
        found.crossings.iter().find(mesh).map(|c| c.participation)
    };
    let shares: Vec<f64> = (0..found.branches.len()).filter_map(share).collect();
    assert!(
        shares.len() >= 2 && shares.windows(2).all(|s| s[0] < s[1]),
        "{shares:?}"
    );
}

/// The orders of both gears of a pair, those of the teeth once with both as sources.
#[test]
fn exact_orders_of_a_gear_pair() {
    let case = Case::new(GEARED);
    let found =
        excitation_orders(&case.machine, &case.kinematics, &OrderOptions::default()).unwrap();
    let fractions: Vec<&str> = found.iter().map(|order| order.fraction.as_str()).collect();
    assert_eq!(fractions, ["1/3", "2/3", "1", "2", "21", "42", "63"]);
    let teeth = &found[4];
    assert_eq!(teeth.value, 21.0);
    let members: Vec<&str> = teeth
        .sources
        .iter()
        .map(|source| source.member.as_str())
        .collect();
    assert_eq!(members, ["pinion", "wheel"]);
    assert!(
        teeth
            .sources
            .iter()
            .all(|source| source.cause == ExcitationCause::Mesh && source.element == "pair")
    );
    let turning: Vec<&str> = found[2]
        .sources
        .iter()
        .map(|source| source.member.as_str())
        .collect();
    assert_eq!(
        turning,
        ["pinion", "motor"],
        "the reference counts where it carries no gear"
    );
}

/// Willis: with the ring held the carrier turns at 18/(18 + 90), so the sun's teeth mesh 18 (1 − 1/6) = 15 times a turn;
/// with the ring stated at −1/3 of the sun's speed the carrier turns at (18 − 30)/108 = −1/9, and they mesh 20 times.
#[test]
fn exact_orders_of_a_planetary_stage() {
    let stage = |ring: &str, speed: &str| {
        Case::new(&format!(
            r#"
[[inertia]]
name = "sun"
J = 0.001
[[inertia]]
name = "carrier"
J = 0.05
[[inertia]]
name = "ring"
J = 0.05
[[planetary]]
name = "stage"
sun = "sun"
ring = "ring"
carrier = "carrier"
planets = 3
teeth = [18, 36, 90]
module = 0.002
pressure_angle = 0.349
planet_J = 0.0001
k_sun = 5.0e8
k_ring = 5.0e8
{ring}
[speed]
sun = 300.0
{speed}
"#
        ))
    };
    let held = "[[bearing]]\nname = \"seat\"\nat = \"ring\"\nk_theta = 1.0e7\n";
    for (ring, speed, mesh, carrier) in [
        (held, "", "15", None),
        ("", "ring = -100.0", "20", Some("1/3")),
    ] {
        let case = stage(ring, speed);
        let found =
            excitation_orders(&case.machine, &case.kinematics, &OrderOptions::default()).unwrap();
        let teeth = found
            .iter()
            .find(|order| {
                order
                    .sources
                    .iter()
                    .any(|source| source.cause == ExcitationCause::Mesh)
            })
            .unwrap();
        assert_eq!(teeth.fraction, mesh);
        let members: Vec<&str> = teeth
            .sources
            .iter()
            .map(|source| source.member.as_str())
            .collect();
        assert_eq!(members, ["sun", "ring"]);
        if let Some(fraction) = carrier {
            assert!(
                found.iter().any(|order| order.fraction == fraction),
                "the ring turns"
            );
        }
    }
}

/// A disc braked so hard that it creeps at rest swings once it spins: `J_d λ² + (c − iJΩ) λ + k = 0`.
#[test]
fn exact_modes_that_appear() {
    let braked = ONE_DISC.replace("k_rx", "c_rx = 600.0\nc_ry = 600.0\nk_rx");
    let speeds = grid(0.0, 12000.0, 12);
    let found = Case::new(&braked).diagram(&speeds, true);
    assert_eq!(found.branches.len(), 2, "{:?}", found.branches);
    let exact = |rpm: f64| {
        let (a, b, c) = (0.065, Complex::new(600.0, -0.12 * rpm * TAU / 60.0), 4.0e5);
        let root = (b * b - 4.0 * a * c).sqrt();
        [(-b + root) / (2.0 * a), (-b - root) / (2.0 * a)].map(|l| l.re.hypot(l.im) / TAU)
    };
    for line in &found.branches {
        assert_eq!(line.frequency_hz[0], None);
        for (i, f) in line.frequency_hz.iter().enumerate().skip(1) {
            let nearest = exact(speeds[i]).map(|e| (f.unwrap() / e - 1.0).abs());
            within(
                "frequencies to 12 000 rpm",
                nearest[0].min(nearest[1]),
                1e-12,
            );
            assert!(line.damping_ratio[i].unwrap() > 0.0);
        }
    }
}

/// The mode that is the n-th forward, or backward, just above standstill.
fn numbered(found: &CampbellDiagram, sense: Whirl, n: usize) -> &CampbellBranch {
    let mut lines: Vec<&CampbellBranch> = found
        .branches
        .iter()
        .filter(|line| line.whirl[1] == Some(sense))
        .collect();
    lines.sort_by(|a, b| a.frequency_hz[1].partial_cmp(&b.frequency_hz[1]).unwrap());
    lines[n - 1]
}

/// Where two branches meet, by linear interpolation, rpm and Hz.
fn meet(found: &CampbellDiagram, a: &CampbellBranch, b: &CampbellBranch) -> Vec<(f64, f64)> {
    let gap = |i: usize| a.frequency_hz[i].unwrap() - b.frequency_hz[i].unwrap();
    let between = |i: usize| {
        let t = gap(i) / (gap(i) - gap(i + 1));
        let at = |x: f64, y: f64| x + t * (y - x);
        let f = at(a.frequency_hz[i].unwrap(), a.frequency_hz[i + 1].unwrap());
        (at(found.speeds_rpm[i], found.speeds_rpm[i + 1]), f)
    };
    (1..found.speeds_rpm.len() - 1)
        .filter(|&i| (gap(i) < 0.0) != (gap(i + 1) < 0.0))
        .map(between)
        .collect()
}

/// The shipped overhung rotor against an assembly of its own: `tools/reference_overhung.py`, numpy 2.4.6.
/// Source: NumPy 2.4.6 (tools/reference_overhung.py).
#[test]
fn ref_numpy_overhung_rotor() {
    let found = Case::shipped("overhung_rotor.toml").diagram(&grid(0.0, 15000.0, 300), false);
    let (f, b) = (
        |n| numbered(&found, Whirl::Forward, n),
        |n| numbered(&found, Whirl::Backward, n),
    );
    for (forward, backward, rpm, hz) in [
        (4, 5, 1734.957, 497.4830),
        (3, 4, 8944.455, 408.2676),
        (2, 3, 13656.356, 320.0909),
    ] {
        let met = meet(&found, f(forward), b(backward));
        // Straight lines between speeds 50 rpm apart are off by 0.01 rpm here.
        let nearest = met
            .iter()
            .min_by(|a, b| (a.0 - rpm).abs().total_cmp(&(b.0 - rpm).abs()));
        let (at, f) = *nearest.unwrap();
        let what = format!("F{forward} meets B{backward}");
        printed(&format!("{what}, speed"), "rpm", rpm, at, 0.02);
        printed(&format!("{what}, frequency"), "Hz", hz, f, 1e-3);
    }
    for (low, high, rpm, hz) in [(f(4), f(5), 8112.5, 19.5151), (b(4), b(5), 4686.5, 23.8329)] {
        let gap = |i: usize| high.frequency_hz[i].unwrap() - low.frequency_hz[i].unwrap();
        let i = (0..found.speeds_rpm.len())
            .min_by(|&i, &j| gap(i).total_cmp(&gap(j)))
            .unwrap();
        // A parabola through the three nearest speeds.
        let (slope, bend) = (
            (gap(i + 1) - gap(i - 1)) / 2.0,
            gap(i + 1) - 2.0 * gap(i) + gap(i - 1),
        );
        let (at, least) = (
            found.speeds_rpm[i] - 50.0 * slope / bend,
            gap(i) - slope * slope / bend / 2.0,
        );
        printed(
            &format!("branches veer {hz} Hz apart, speed"),
            "rpm",
            rpm,
            at,
            0.3,
        );
        printed(
            &format!("branches veer {hz} Hz apart, gap"),
            "Hz",
            hz,
            least,
            2e-4,
        );
    }
    assert!(
        found
            .branches
            .iter()
            .all(|line| line.uncertain_rpm.is_empty())
    );
}

/// Coarse steps give every branch of the overhung rotor that fine ones give, through crossings and veerings.
#[test]
fn law_overhung_rotor_at_any_step() {
    let case = Case::shipped("overhung_rotor.toml");
    let (coarse, fine) = (
        case.diagram(&grid(0.0, 15000.0, 5), false),
        case.diagram(&grid(0.0, 15000.0, 300), false),
    );
    assert_eq!(coarse.branches.len(), fine.branches.len());
    for line in &coarse.branches {
        let is_same =
            |other: &&CampbellBranch| worst(line, |i| other.frequency_hz[60 * i].unwrap()) < 1e-12;
        assert!(
            fine.branches.iter().any(|other| is_same(&other)),
            "{line:?}"
        );
    }
    println!(
        "{} speeds solved for 6, {} for 301",
        coarse.n_solves, fine.n_solves
    );
}

/// A stage in its carrier's frame: Coriolis and centrifugal terms, repeated planet modes; at rest the paper's frequencies.
#[test]
fn survives_a_planetary_stage_in_a_turning_frame() {
    for name in [
        "lin_parker_n3.toml",
        "lin_parker_n4.toml",
        "lin_parker_n5.toml",
    ] {
        let case = Case::shipped(name);
        let found = case.diagram(&grid(0.0, 3000.0, 6), false);
        assert!(!found.is_constant);
        let rest: Vec<f64> = case
            .basis
            .omega
            .iter()
            .skip(case.basis.n_rigid)
            .map(|w| w / TAU)
            .collect();
        let mut first: Vec<f64> = found
            .branches
            .iter()
            .filter_map(|line| line.frequency_hz[0])
            .collect();
        first.sort_by(f64::total_cmp);
        assert_eq!(first.len(), rest.len(), "{name}");
        assert!(
            first
                .iter()
                .zip(&rest)
                .all(|(a, b)| (a / b - 1.0).abs() < 1e-10),
            "{name}: {first:?} {rest:?}"
        );
        let whole = found
            .branches
            .iter()
            .filter(|line| line.frequency_hz.iter().all(Option::is_some))
            .count();
        assert_eq!(whole, rest.len(), "{name}: no branch is lost on the way");
        println!("{name}: {} speeds solved for 7", found.n_solves);
    }
}

/// Of a planetary stage that turns, modes come in pairs of translation, which whirl one forward and one backward, and single ones of
/// rotation or of planets alone, which do not whirl.
/// Source: J. Lin and R. G. Parker, J. Vib. Acoust. 121 (1999) 316: six pairs whatever the number of planets.
#[test]
fn ref_lin_parker_pairs_of_translation_whirl() {
    for (name, planets) in [("lin_parker_n3.toml", 3), ("lin_parker_n4.toml", 4)] {
        let found = Case::shipped(name).diagram(&[1000.0, 1500.0], false);
        let of = |sense: Whirl| -> Vec<f64> {
            let lines = found.branches.iter();
            let own = lines.filter(|line| line.whirl[1] == Some(sense));
            own.map(|line| line.frequency_hz[1].unwrap()).collect()
        };
        let (forward, backward) = (of(Whirl::Forward), of(Whirl::Backward));
        assert_eq!((forward.len(), backward.len()), (6, 6), "{name}");
        // The members of a pair part with the speed, by less than pairs lie apart.
        for (f, b) in forward.iter().zip(&backward) {
            assert!((f / b - 1.0).abs() < 0.05, "{name}: {f} {b}");
        }
        let still = found.branches.iter().filter(|line| line.whirl[1].is_none());
        assert_eq!(still.count(), 3 * planets + 9 - 12 - 1, "{name}");
    }
}

/// Nothing turns freely past a torsional support, so the body it holds turns with it; the whirl of its tilting disc is that without.
#[test]
fn exact_support_turns_with_its_body() {
    let disc = "inertia = [{ name = \"a\", J = 0.1, mass = 5.0, J_diametral = 0.06 }, { name = \"b\", J = 0.2 }]\n\
         shaft = [{ name = \"s\", between = [\"a\", \"b\"], k = 5e3 }]\n\
         [[bearing]]\nname = \"lat\"\nat = \"a\"\nk_radial = 1e6\nk_tilt = 1e4\n";
    let held = format!("{disc}[[bearing]]\nname = \"ctl\"\nat = \"b\"\nk_theta = 1e3\n");
    let [free, held] = [disc.to_string(), held].map(|text| {
        let found = Case::new(&text).diagram(&[0.0, 1500.0, 3000.0], false);
        let tilts = found
            .branches
            .into_iter()
            .filter(|line| line.whirl[1].is_some());
        tilts
            .map(|line| line.frequency_hz[1].unwrap())
            .collect::<Vec<f64>>()
    });
    assert_eq!(free.len(), 4);
    for (a, b) in free.iter().zip(&held) {
        assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
    }
}

/// Light dampers at one hub: branches are followed as without them, and a line of uncertainty is not drawn.
#[test]
fn law_light_losses_move_no_branch() {
    let text = DISCS.replace(
        "name = \"hub_b\"",
        "name = \"hub_b\"\nc_rx = 0.2\nc_ry = 0.2",
    );
    let case = Case::new(&text.replace("LINK", &link(3.0e4)));
    let speeds = grid(0.0, 12000.0, 12);
    let (with, without) = (case.diagram(&speeds, true), case.diagram(&speeds, false));
    assert_eq!(with.branches.len(), without.branches.len());
    for line in &with.branches {
        assert!(line.uncertain_rpm.is_empty());
        let is_same = |other: &&CampbellBranch| {
            worst(line, |i| other.frequency_hz[i].unwrap()) < 1e-5 && line.whirl == other.whirl
        };
        let same = without.branches.iter().find(is_same);
        assert!(same.is_some(), "{line:?}");
        let is_lateral = line.whirl[0].is_some();
        let damped = |z: &Option<f64>| z.is_some_and(|z| z > 1e-7);
        assert!(
            line.damping_ratio
                .iter()
                .all(|z| if is_lateral { damped(z) } else { z.is_none() }),
            "{line:?}"
        );
    }
}
