//! Flanks, contact, loaded contact, corrected settings, helicoids and hypoid designs against SciPy, in one run.
//!
//! `cargo bench --bench gears` prints times on the processor and ratios; each row is a thousand of its kind, or one where the row says so.
//! The peer needs `python3` with SciPy, on one thread as ours is. It solves the same equations without closed forms, by fsolve and brentq.
//! Of the loaded contact the column `error` of the peer is its difference from ours, of the correction both have the rms left over that
//! before.

use std::hint::black_box;
use std::sync::Arc;

use beside::{Took, best_on_processor};
use geardyn::internals::base::flags::Flags;
use geardyn::internals::base::source_span::SourceFile;
use geardyn::internals::gear::bevel::cutter::Cutter;
use geardyn::internals::gear::bevel::flank::BevelFlank;
use geardyn::internals::gear::bevel::flank_grid::FlankGrid;
use geardyn::internals::gear::bevel::pitch_cones::{PitchConeDesign, ToothLine};
use geardyn::internals::gear::contact::contact_path::{ContactPath, PITCHES};
use geardyn::internals::gear::contact::pair::FlankPair;
use geardyn::internals::gear::cut::correction::{CorrectionProblem, Unknown};
use geardyn::internals::gear::cut::measured_flank::{Deviations, FlankNode, MeasuredFlank};
use geardyn::internals::gear::cut::setting::{FlankSetup, Setting, SettingKind};
use geardyn::internals::gear::helicoid::axial_profile::AxialProfile;
use geardyn::internals::gear::helicoid::grinding_wheel::ToolAxis;
use geardyn::internals::gear::helicoid::plane_worm::PlaneWorm;
use geardyn::internals::gear::helicoid::worm_pair::WormPair;
use geardyn::internals::gear::helicoid::worm_thread::{FlankType, WormThread};
use geardyn::internals::gear::kernel::crossed_axes::CrossedAxes;
use geardyn::internals::gear::load::flank_mesh::{FlankMesh, FlankMeshOptions};
use geardyn::internals::gear::load::flank_position::ToothBending;
use geardyn::internals::numeric::parallel;
use geardyn::internals::plan::gear::{bevel_member, bevel_mesh};
use geardyn::internals::scene::bevel_file::{self, BevelFile};
use serde_json::{Value, json};

mod beside;

/// Of the first column.
const WIDTH: usize = 62;
/// Rows along the height and columns along the face of a whole gear.
const GRID: [usize; 2] = [30, 45];
/// Edge radius of the blades of the whole gear, m.
const EDGE_RADIUS: f64 = 0.6e-3;
/// The clock of the processor tells some milliseconds: a run lasts longer.
const RUNS: usize = 5;
/// Corrections of a run.
const CORRECTIONS: usize = 20;
/// Stations and positions of the loaded contact.
const MESH: [usize; 2] = [32, 60];
/// Torque of the pinion, N·m, and number of torques of the Harris map up to it.
const LOAD: (f64, usize) = (100.0, 20);
/// Rows and columns of the measured flanks.
const MEASURED: [usize; 2] = [5, 9];

/// A row: name of the peer's, words, time and error of ours.
type Row = (&'static str, &'static str, Took);

/// Time of a thousand calls, s: `batch` of them are one run.
fn thousand(batch: usize, mut call: impl FnMut(usize)) -> f64 {
    let (seconds, ()) = best_on_processor(RUNS, || (0..batch).for_each(&mut call));
    1e3 * seconds / batch as f64
}

/// A time without an error.
fn took(seconds: f64) -> Took {
    Took {
        seconds,
        error: None,
    }
}

/// The shipped pair of 12 and 36 teeth.
fn shipped_pair() -> BevelFile {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/models/gears/bevel_12_36.toml");
    let source = Arc::new(SourceFile {
        path: path.into(),
        text: std::fs::read_to_string(path).expect("the file is shipped"),
        first_line: 1,
    });
    bevel_file::read(&source, &Flags::default()).expect("the file is sound")
}

/// Both flanks of the gear, cut by blades with an edge radius.
fn gear_with_fillet(file: &BevelFile) -> [BevelFlank; 2] {
    [0, 1].map(|side| {
        let cut = file.members[1].flanks[side].as_ref().expect("described");
        let cutter = Cutter {
            edge_radius: EDGE_RADIUS,
            ..cut.cutter
        };
        let section = file.members[1].section;
        BevelFlank::new(&cutter, &cut.settings, file.hand_of(1), section)
    })
}

/// Times of the bevel pair by the peer's names.
fn bevel(file: &BevelFile, rows: &mut Vec<Row>) {
    let flank = file.flank(0, 0).expect("described");
    let nodes = GRID[0] * GRID[1];
    let grid = thousand(30, |_| {
        black_box(FlankGrid::of(black_box(&flank), GRID[0], GRID[1]));
    });
    let start = thousand(100, |_| {
        black_box(black_box(&flank).middle());
    });
    rows.push((
        "flank",
        "1 000 flank points on the blank",
        took((grid - start) / nodes as f64),
    ));
    let flanks = gear_with_fillet(file);
    let gear = thousand(15, |_| {
        black_box(
            flanks
                .each_ref()
                .map(|f| FlankGrid::of(f, GRID[0], GRID[1])),
        );
    });
    rows.push((
        "gear",
        "one gear of 2 × 45 × 30 nodes (ours with fillet)",
        took(1e-3 * gear),
    ));
    let flanks = [flank, file.flank(1, 1).expect("described")];
    let teeth = file.members.each_ref().map(|m| m.teeth);
    let pair = FlankPair::new(flanks, teeth, file.hand, &file.assembly());
    let first = pair.first_contact().expect("the pair touches");
    let contact = thousand(20_000, |k| {
        let angle = first.pinion_angle + 0.002 * (k % 5) as f64;
        let contact = pair.contact(angle, first.unknowns);
        black_box(contact.and_then(|c| pair.ellipse(&c, 6.35e-6)));
    });
    rows.push((
        "contact",
        "1 000 contact points (ours with ellipse)",
        took(contact),
    ));
    let path = thousand(300, |_| {
        black_box(pair.path(first, 1.5, 20));
    });
    rows.push((
        "path",
        "one curve of 60 contacts over 3 pitches",
        took(1e-3 * path),
    ));
}

/// The touching flanks of a file with their path.
fn touching(file: &BevelFile) -> (FlankPair, ContactPath) {
    let flanks = [(0, 0), (1, 1)].map(|(k, side)| file.flank(k, side).expect("described"));
    let teeth = file.members.each_ref().map(|m| m.teeth);
    let pair = FlankPair::new(flanks, teeth, file.hand, &file.assembly());
    let path = pair.path_near_teeth(PITCHES, 60).expect("they touch");
    (pair, path)
}

/// Times of the loaded contact; what the peer needs to solve the same, and the turn to compare.
fn loaded(file: &BevelFile, rows: &mut Vec<Row>) -> Value {
    let (pair, path) = touching(file);
    let [stations, positions] = MESH;
    let (torque, count) = LOAD;
    let options = |positions: usize| FlankMeshOptions {
        stations,
        positions,
        ..FlankMeshOptions::default()
    };
    let tooth = [0, 1].map(|k| bevel_member::tooth(file, k));
    let materials = options(1).materials;
    let bending = bevel_mesh::bending_teeth(file, tooth.each_ref().map(Option::as_ref), &materials);
    let bending = bending.expect("sound").expect("both have teeth");
    // Time of a call and peak-to-peak of the unloaded and the loaded error, rad.
    let map = |positions: usize, torques: &[f64], teeth: Option<&dyn ToothBending>| {
        let mesh = FlankMesh::new(&pair, &path, options(positions), teeth);
        best_on_processor(RUNS, || mesh.map(torques).expect("the pair carries"))
    };
    let torques: Vec<f64> = (1..=count)
        .map(|i| torque * i as f64 / count as f64)
        .collect();
    let (one, rigid) = map(positions, &[torque], None);
    let name = "one loaded position of 32 stations, half spaces";
    rows.push(("position", name, took(one / positions as f64)));
    let (one, _) = map(positions, &[torque], Some(&bending));
    let name = "one loaded position of 32 stations, with teeth";
    rows.push(("", name, took(one / positions as f64)));
    let (all, harris) = map(positions, &torques, None);
    let name = "one Harris map of 20 torques × 60 positions, half spaces";
    rows.push(("harris", name, took(all)));
    let (all, _) = map(positions, &torques, Some(&bending));
    rows.push((
        "",
        "one Harris map of 20 torques × 60 positions, with teeth",
        took(all),
    ));
    json!({
        "sections": pair.flanks.each_ref().map(|flank| flank.section.corners),
        "assembly": file.assembly().pinion_axial,
        "stations": stations,
        "positions": positions,
        "torques": torques,
        "turn": rigid.unloaded_te[0] - rigid.cycles[0].positions[0].te,
        "turns": harris.cycles.iter().map(|c| harris.unloaded_te[0] - c.positions[0].te).collect::<Vec<_>>(),
    })
}

/// Time of a correction of ten settings by both flanks of the gear, cut at one setting; the problem for the peer.
fn correction(file: &BevelFile, rows: &mut Vec<Row>) -> Value {
    let member = &file.members[1];
    let (hand, section) = (file.hand_of(1), member.section);
    let setups = [0, 1].map(|side| {
        let cut = member.flanks[side].as_ref().expect("described");
        FlankSetup {
            cutter: cut.cutter,
            machine: cut.settings,
        }
    });
    let reach = |setting: Setting| match setting.kind() {
        SettingKind::Length => 1e-4,
        SettingKind::Angle => std::f64::consts::PI / 1080.0,
        SettingKind::Ratio => 1e-2,
    };
    let machine = [
        Setting::RadialDistance,
        Setting::CradleAngle,
        Setting::BlankOffset,
        Setting::SlidingBase,
        Setting::HelicalMotion,
        Setting::CentreToBack,
        Setting::MachineRootAngle,
        Setting::Ratio,
    ];
    let unknown = |setting: Setting, flanks: Vec<usize>| Unknown {
        setting,
        flanks,
        reach: reach(setting),
    };
    let mut unknowns: Vec<Unknown> = machine.map(|s| unknown(s, vec![0, 1])).into();
    unknowns.extend([0, 1].map(|f| unknown(Setting::BladeAngle, vec![f])));
    // Half a reach of each setting, signs in turn.
    let wrong = |k: usize| [0.5, -0.5][k % 2] * unknowns[k].reach;
    let [lines, columns] = MEASURED;
    let share = |i: usize, n: usize| 0.1 + 0.8 * i as f64 / (n - 1) as f64;
    let measured = |f: usize| {
        let flank = setups[f].flank(hand, section);
        let middle = flank.middle().expect("the cutter reaches");
        let cut = (unknowns.iter().enumerate())
            .filter(|(_, unknown)| unknown.flanks.contains(&f))
            .fold(setups[f], |setup, (k, u)| {
                setup.changed(u.setting, wrong(k))
            })
            .flank(hand, section);
        let places = (0..lines * columns)
            .map(|i| section.at(share(i % columns, columns), share(i / columns, lines)));
        let nodes: Vec<FlankNode> = places
            .map(|place| FlankNode::of(&flank, place, middle).expect("on the flank"))
            .collect();
        let deviation = |n: &FlankNode| {
            cut.envelope
                .intersect_ray(n.point, n.normal, n.at)
                .expect("near")
                .1
        };
        MeasuredFlank {
            setup: setups[f],
            hand,
            section,
            deviations: nodes.iter().map(deviation).collect(),
            nodes,
            roots: Vec::new(),
        }
    };
    let problem = CorrectionProblem {
        flanks: vec![measured(0), measured(1)],
        unknowns: unknowns.clone(),
        least: 0.05e-6,
    };
    let rms = |values: Vec<Option<f64>>| Deviations::of(&values).rms;
    let before = rms(problem
        .flanks
        .iter()
        .flat_map(|f| &f.deviations)
        .map(|d| Some(*d))
        .collect());
    let solve = || problem.solve().expect("the flanks are reached");
    let (seconds, _) = best_on_processor(RUNS, || (0..CORRECTIONS).for_each(|_| drop(solve())));
    let (seconds, fit) = (seconds / CORRECTIONS as f64, solve());
    let left = rms(fit.residuals.concat());
    let error = Some(left / before);
    let name = "one correction of ten settings by 2 × 45 nodes";
    rows.push(("correction", name, Took { seconds, error }));
    let places = |f: usize| -> Vec<[f64; 2]> {
        let points = problem.flanks[f].nodes.iter().map(|n| n.point.coordinates);
        points.map(|r| [r.z, f64::hypot(r.x, r.y)]).collect()
    };
    json!({
        "places": [places(0), places(1)],
        "wrong": (0..unknowns.len()).map(wrong).collect::<Vec<_>>(),
        "before": before,
    })
}

/// Times of helicoids, worms and hypoid designs.
fn screws(rows: &mut Vec<Row>) {
    let thread = WormThread {
        flank: FlankType::Zk {
            wheel_radius: 150.0,
        },
        starts: 2,
        module: 4.0,
        diameter_quotient: 10.0,
        pressure_angle: 20f64.to_radians(),
    };
    let ground = thread.helicoid().expect("the wheel reaches");
    let AxialProfile::Ground(wheel) = ground.profile else {
        unreachable!("ZK is ground")
    };
    let place = |k: usize| 16.0 + 8.0 * (k % 97) as f64 / 97.0;
    let made = thousand(400_000, |k| {
        black_box(wheel.ground(ground.lead, black_box(170.0 - place(k))));
    });
    rows.push((
        "ground",
        "1 000 points of a helicoid from its tool",
        took(made),
    ));
    let involute = WormThread {
        flank: FlankType::Zi,
        ..thread
    };
    let involute = involute.helicoid().expect("an involute");
    let axis = ToolAxis {
        distance: 170.0,
        angle: thread.lead_angle(),
    };
    let tool = thousand(400_000, |k| {
        black_box(axis.disk_point(&involute, black_box(place(k)), 0.0));
    });
    rows.push((
        "tool",
        "1 000 points of a tool from its helicoid",
        took(tool),
    ));
    let pair = WormPair {
        worm: involute.through(20.0, 0.0).expect("the flank reaches"),
        ratio: 0.05,
        centre_distance: 100.0,
    };
    let field = thousand(1_000_000, |k| {
        black_box(pair.contact(black_box(place(k)), 0.3));
    });
    rows.push((
        "worm",
        "1 000 points of the field of a worm pair",
        took(field),
    ));
    let plane = PlaneWorm {
        centre_distance: 125.0,
        ratio: 1.0 / 40.0,
        base_radius: 40.0,
        plane_angle: 11f64.to_radians(),
    };
    let line = plane.generating_line(0.4);
    let both = thousand(400_000, |k| {
        let eta = -4.0 + 8.0 * (k % 97) as f64 / 97.0;
        black_box(black_box(&line).first_contact(eta));
        black_box(black_box(&line).second_contact(0.4 + 0.01 * eta));
    });
    rows.push((
        "plane",
        "1 000 points of both contact lines of a plane worm",
        took(both),
    ));
    let design = |k: usize| PitchConeDesign {
        axes: CrossedAxes {
            offset: 15.0,
            shaft_angle: std::f64::consts::FRAC_PI_2,
            ratio: -13.0 / 42.0,
        },
        wheel_radius: 70.9 + 0.01 * (k % 7) as f64,
        outwards: 0.0,
        tooth_line: ToothLine::Limit {
            pinion_spiral_angle: 50f64.to_radians(),
            curvature: 1.0 / 63.5,
        },
    };
    let designs = thousand(10_000, |k| {
        black_box(design(k).solve());
    });
    rows.push(("hypoid", "1 000 pitch cones of hypoid pairs", took(designs)));
}

fn main() {
    parallel::set_threads(1);
    let file = shipped_pair();
    let mut rows = Vec::new();
    bevel(&file, &mut rows);
    let problem = json!({
        "loaded": loaded(&file, &mut rows),
        "correction": correction(&file, &mut rows),
    });
    screws(&mut rows);
    beside::head(WIDTH, "scipy");
    let peers = beside::peers("gears_peer.py", &[&problem.to_string()]);
    for (name, what, ours) in rows {
        let peer = peers.iter().find(|(peer, _)| peer == name);
        beside::row(WIDTH, what, ours, peer.map(|(_, took)| *took));
    }
}
