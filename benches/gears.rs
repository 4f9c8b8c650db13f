//! Flanks, contact, helicoids and hypoid designs against SciPy, in one run.
//!
//! `cargo bench --bench gears` prints times on the processor and ratios; each row is a thousand of its kind, or one where the row says so.
//! The peer needs `python3` with SciPy, on one thread as ours is. It solves the same equations without closed forms, by fsolve and brentq.

use std::hint::black_box;
use std::sync::Arc;

use beside::{Took, best_on_processor};
use geardyn::internals::base::flags::Flags;
use geardyn::internals::base::source_span::SourceFile;
use geardyn::internals::gear::bevel::cutter::Cutter;
use geardyn::internals::gear::bevel::flank::BevelFlank;
use geardyn::internals::gear::bevel::flank_grid::FlankGrid;
use geardyn::internals::gear::bevel::pitch_cones::{PitchConeDesign, ToothLine};
use geardyn::internals::gear::contact::pair::FlankPair;
use geardyn::internals::gear::helicoid::axial_profile::AxialProfile;
use geardyn::internals::gear::helicoid::grinding_wheel::ToolAxis;
use geardyn::internals::gear::helicoid::plane_worm::PlaneWorm;
use geardyn::internals::gear::helicoid::worm_pair::WormPair;
use geardyn::internals::gear::helicoid::worm_thread::{FlankType, WormThread};
use geardyn::internals::gear::kernel::crossed_axes::CrossedAxes;
use geardyn::internals::scene::bevel_file::{self, BevelFile};

mod beside;

/// Of the first column.
const WIDTH: usize = 62;
/// Rows along the height and columns along the face of a whole gear.
const GRID: [usize; 2] = [30, 45];
/// Edge radius of the blades of the whole gear, m.
const EDGE_RADIUS: f64 = 0.6e-3;
/// The clock of the processor tells some milliseconds: a run lasts longer.
const RUNS: usize = 5;

/// Time of a thousand calls, s: `batch` of them are one run.
fn thousand(batch: usize, mut call: impl FnMut(usize)) -> f64 {
    let (seconds, ()) = best_on_processor(RUNS, || (0..batch).for_each(&mut call));
    1e3 * seconds / batch as f64
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
fn bevel(rows: &mut Vec<(&'static str, &'static str, f64)>) {
    let file = shipped_pair();
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
        (grid - start) / nodes as f64,
    ));
    let flanks = gear_with_fillet(&file);
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
        1e-3 * gear,
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
        contact,
    ));
    let path = thousand(300, |_| {
        black_box(pair.path(first, 1.5, 20));
    });
    rows.push((
        "path",
        "one curve of 60 contacts over 3 pitches",
        1e-3 * path,
    ));
}

/// Times of helicoids, worms and hypoid designs.
fn screws(rows: &mut Vec<(&'static str, &'static str, f64)>) {
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
    rows.push(("ground", "1 000 points of a helicoid from its tool", made));
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
    rows.push(("tool", "1 000 points of a tool from its helicoid", tool));
    let pair = WormPair {
        worm: involute.through(20.0, 0.0).expect("the flank reaches"),
        ratio: 0.05,
        centre_distance: 100.0,
    };
    let field = thousand(1_000_000, |k| {
        black_box(pair.contact(black_box(place(k)), 0.3));
    });
    rows.push(("worm", "1 000 points of the field of a worm pair", field));
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
        both,
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
    rows.push(("hypoid", "1 000 pitch cones of hypoid pairs", designs));
}

fn main() {
    beside::head(WIDTH, "scipy");
    let peers = beside::peers("gears_peer.py", &[]);
    let mut rows = Vec::new();
    bevel(&mut rows);
    screws(&mut rows);
    for (name, what, seconds) in rows {
        let ours = Took {
            seconds,
            error: None,
        };
        let peer = peers.iter().find(|(peer, _)| peer == name);
        beside::row(WIDTH, what, ours, peer.map(|(_, took)| *took));
    }
}
