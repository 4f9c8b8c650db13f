//! Flanks cut by discrete blades: scallops by law and on rays, run-out of the head, errors of the generator.

use geardyn::internals::gear::bevel::cutter::Cutter;
use geardyn::internals::gear::bevel::flank::BevelFlank;
use geardyn::internals::gear::bevel::frames::WorkFrame;
use geardyn::internals::gear::bevel::settings::MachineSettings;
use geardyn::internals::gear::cut::angle_errors::{AngleError, AngleErrors};
use geardyn::internals::gear::cut::blade_passes::{
    BladePasses, CutConditions, angle_lever, scallop_height,
};
use geardyn::internals::gear::cut::cutter_head::{BladeFeed, BladeOffset};
use geardyn::internals::gear::hand::Hand;
use geardyn::internals::gear::kernel::envelope::FlankPoint;
use geardyn::internals::gear::kernel::jet::Surface;
use serde_json::Value;

use crate::bevel_flank::{nasa_cut, nasa_flank};
use crate::cases::{case, number};
use crate::verification::{order, within};

/// Cutter, settings and hand of a flank of c12, in inches.
fn machine_of(case: &Value, name: &str) -> (Cutter, MachineSettings, Hand) {
    let (setup, hand, _) = nasa_cut(case, name);
    (setup.cutter, setup.machine, hand)
}

/// A flank of c12, in inches, with its machine.
struct Cut {
    case: Value,
    name: &'static str,
    flank: BevelFlank,
    middle: [f64; 3],
}

impl Cut {
    fn of(name: &'static str) -> Cut {
        let case = case("c12_nasa_cr191009_flanks");
        let flank = nasa_flank(&case, name);
        let middle = flank.middle().unwrap();
        Cut {
            case,
            name,
            flank,
            middle,
        }
    }

    fn point(&self, face: f64, height: f64) -> FlankPoint<WorkFrame> {
        self.flank.point([face, height], self.middle).unwrap()
    }

    fn passes(&self, conditions: &CutConditions) -> BladePasses {
        let (cutter, settings, hand) = machine_of(&self.case, self.name);
        let depth = self.flank.section.depth();
        let machine = (&cutter, &settings, hand);
        BladePasses::new(machine, depth, self.middle[1], conditions)
    }

    fn regular(&self, feed: BladeFeed) -> BladePasses {
        self.passes(&CutConditions::regular(feed))
    }
}

fn feed(blades: u32, degrees_per_turn: f64) -> BladeFeed {
    BladeFeed {
        blades,
        cradle_per_turn: degrees_per_turn.to_radians(),
    }
}

const MICROMETRES: f64 = 25_400.0;

/// Scallops of a spiral bevel pair at five places of two flanks, 0.125°, 0.5° and 2° of the cradle from blade to blade: the law |D| Δx²/8,
/// and how far it is from the highest scallop on rays against the facets.
/// Source: data/reference/gear/c26_discrete_blades_nasa.json; its simulation differs from exact rays by up to 1 % of a scallop.
#[test]
fn ref_law_of_scallops() {
    let flanks = [Cut::of("gear_convex"), Cut::of("pinion_concave")];
    let (mut law, mut simulated, mut off) = (0f64, 0f64, [0f64; 3]);
    for row in case("c26_discrete_blades_nasa")["rows"].as_array().unwrap() {
        let cut = flanks.iter().find(|cut| row[0] == cut.name).unwrap();
        let feed = feed(number(&row[1]) as u32, number(&row[2]));
        let point = cut.point(number(&row[3]), number(&row[4]));
        let by_law = scallop_height(&point.second_order, feed.step()) * MICROMETRES;
        let on_rays = cut.regular(feed).scallop(&point).unwrap() * MICROMETRES;
        law = law.max((by_law - number(&row[6])).abs());
        simulated = simulated.max((on_rays / number(&row[7]) - 1.0).abs());
        let degrees = feed.step().to_degrees();
        let k = [0.2, 1.0, 3.0].iter().position(|d| degrees < *d).unwrap();
        off[k] = off[k].max((on_rays / by_law - 1.0).abs());
    }
    within("law, µm", law, 5.1e-6);
    within("highest scallop, relative", simulated, 1e-2);
    within("law against rays at 0.125°, relative", off[0], 2e-3);
    within("law against rays at 0.5°, relative", off[1], 8e-3);
    within("law against rays at 2°, relative", off[2], 3.6e-2);
}

/// The highest scallop where the facets of two passes meet on the normal, the cradle rolling on with and against the blade.
/// Source: another program from the report's machine, tools/gear_blade_peer.py, data/reference/gear/blade_scallops.json.
#[test]
fn ref_scallops_on_rays() {
    let flanks = [Cut::of("gear_convex"), Cut::of("pinion_concave")];
    let mut apart = 0f64;
    for row in case("blade_scallops")["rows"].as_array().unwrap() {
        let cut = flanks.iter().find(|cut| row[0] == cut.name).unwrap();
        let point = cut.point(number(&row[3]), number(&row[4]));
        for (column, sign) in [(5, 1.0), (6, -1.0)] {
            let feed = feed(number(&row[1]) as u32, sign * number(&row[2]));
            let found = cut.regular(feed).scallop(&point).unwrap() * MICROMETRES;
            apart = apart.max((found - number(&row[column])).abs());
        }
    }
    within("highest scallop, µm", apart, 1e-5);
}

/// The height of a simulated scallop falls with the square of the cradle angle from blade to blade.
#[test]
fn order_scallops() {
    let cut = Cut::of("pinion_concave");
    let point = cut.point(0.3, 0.6);
    let height = |degrees: f64| cut.regular(feed(16, degrees)).scallop(&point).unwrap();
    order(
        "height of a scallop",
        2.0,
        (height(4.0) / height(2.0)).log2(),
    );
}

/// The highest point that the passes leave over all phases is the scallop, and every pass stays outside the ideal flank.
#[test]
fn law_scallop_is_the_worst_phase() {
    for name in ["gear_convex", "pinion_concave"] {
        let cut = Cut::of(name);
        let point = cut.point(0.4, 0.7);
        let passes = cut.regular(feed(16, 6.0));
        let scallop = passes.scallop(&point).unwrap();
        let phases = (0..400).map(|i| f64::from(i) / 400.0);
        let left: Vec<f64> = phases
            .map(|phase| passes.cut(&point, phase).unwrap().deviation)
            .collect();
        let [low, high] = left.iter().fold([f64::INFINITY, 0.0], |[low, high], d| {
            [d.min(low), d.max(high)]
        });
        assert!((high / scallop - 1.0).abs() < 0.01, "{high} {scallop}");
        assert!((0.0..0.01 * scallop).contains(&low), "{low} {scallop}");
    }
}

/// Blades that finish a place over all phases of a turn.
fn finishing(passes: &BladePasses, point: &FlankPoint<WorkFrame>, blades: u32) -> Vec<bool> {
    let mut finish = vec![false; blades as usize];
    for i in 0..400 * blades {
        let cut = passes.cut(point, f64::from(i) / 400.0).unwrap();
        finish[cut.blade] = true;
    }
    finish
}

/// A blade that stands out by e along the flank's normal: from e = 8 h its neighbours no longer cut, from N² h no other of an even number N
/// does, and the scallop is then N² h.
#[test]
fn law_run_out_leaves_fewer_blades() {
    let cut = Cut::of("pinion_concave");
    let (cutter, ..) = machine_of(&cut.case, cut.name);
    let point = cut.point(0.5, 0.5);
    let n = cutter.surfaces(1.0).blade.jet([0.5, 0.0]).unwrap().n;
    const BLADES: u32 = 4;
    let feed = feed(BLADES, 0.5);
    let h = cut.regular(feed).scallop(&point).unwrap();
    let standing_out = |heights: f64| {
        // Normals point into the blade, so that it cuts deeper against them.
        let offset = BladeOffset {
            radial: -heights * h * n.x,
            axial: -heights * h * n.z,
        };
        let mut conditions = CutConditions::regular(feed);
        conditions.offsets = vec![BladeOffset::default(); BLADES as usize];
        conditions.offsets[0] = offset;
        cut.passes(&conditions)
    };
    let blades = |heights: f64| finishing(&standing_out(heights), &point, BLADES);
    assert_eq!(blades(7.8), [true; 4]);
    assert_eq!(blades(8.2), [true, false, true, false]);
    assert_eq!(blades(15.7), [true, false, true, false]);
    assert_eq!(blades(16.3), [true, false, false, false]);
    let passes = standing_out(100.0);
    let phases = (0..1600).map(|i| f64::from(i) / 400.0);
    let left = phases.map(|phase| passes.cut(&point, phase).unwrap().deviation);
    let highest = left.fold(f64::NEG_INFINITY, f64::max);
    assert!((highest / h + 100.0 - 16.0).abs() < 0.05, "{}", highest / h);
}

/// A small constant error of the work moves the facet that touches by `n·(k×r) ε` (envelope theorem); the rest falls with ε².
#[test]
fn order_constant_error_of_the_work() {
    let cut = Cut::of("pinion_concave");
    let point = cut.point(0.3, 0.6);
    let feed = feed(16, 2.0);
    let (.., hand) = machine_of(&cut.case, cut.name);
    let touching = point.at[2] - feed.drag() * (point.at[1] - cut.middle[1]);
    let rest = |error: f64| {
        let errors = AngleErrors {
            work: vec![AngleError::harmonic(error, 0.0, 0.0)],
            ..AngleErrors::default()
        };
        let passes = cut.passes(&CutConditions {
            errors,
            ..CutConditions::regular(feed)
        });
        let moved = passes.facet(0, touching, &point).unwrap();
        (moved - hand.sign() * angle_lever(&point) * error).abs()
    };
    within("rest at 1e-4 rad, in", rest(1e-4), 1e-7);
    order("rest of n·(k×r) ε", 2.0, (rest(2e-3) / rest(1e-3)).log2());
}

/// With a fine feed a wavy roll leaves the envelope of the wavy motion.
/// Source: the exact envelope, data/reference/gear/c22_machine_te_to_flank_error.json.
#[test]
fn ref_wavy_roll() {
    let cut = Cut::of("pinion_concave");
    let (.., hand) = machine_of(&cut.case, cut.name);
    let mut apart = 0f64;
    for row in case("c22_machine_te_to_flank_error")["rows"]
        .as_array()
        .unwrap()
    {
        let row: Vec<f64> = row.as_array().unwrap().iter().map(number).collect();
        let amplitude = hand.sign() * (row[0] / 3600.0).to_radians();
        let errors = AngleErrors {
            work: vec![AngleError::harmonic(amplitude, row[1], 0.3)],
            ..AngleErrors::default()
        };
        let passes = cut.passes(&CutConditions {
            errors,
            ..CutConditions::regular(feed(16, 0.2))
        });
        let point = cut.point(row[2], row[3]);
        // Normals of the case point into the metal.
        let left = -passes.cut(&point, 0.0).unwrap().deviation * MICROMETRES;
        apart = apart.max((left - row[6]).abs());
    }
    within("fine feed against the envelope, µm", apart, 1.1e-3);
}

/// A cutter that turns ahead by ε at the same turn of the cradle reaches θ earlier: x falls by drag ε.
#[test]
fn exact_error_of_the_cutter() {
    let cut = Cut::of("gear_convex");
    let point = cut.point(0.5, 0.5);
    let feed = feed(8, 6.0);
    let error = 3e-3;
    let passes = cut.passes(&CutConditions {
        errors: AngleErrors {
            cutter: vec![AngleError::harmonic(error, 0.0, 0.0)],
            ..AngleErrors::default()
        },
        ..CutConditions::regular(feed)
    });
    let turn = point.at[2] + 0.01;
    let late = cut
        .regular(feed)
        .facet(0, turn - feed.drag() * error, &point);
    let apart = (passes.facet(0, turn, &point).unwrap() - late.unwrap()).abs();
    within("distance, in", apart, 1e-14);
}

/// A formate flank has no scallop: its points lie on the cone of the cutter, and the blade that stands out most cuts it.
#[test]
fn law_formate() {
    let cut = Cut::of("gear_convex");
    let (cutter, settings, hand) = machine_of(&cut.case, cut.name);
    let formate = MachineSettings {
        roll: None,
        ..settings
    };
    let flank = BevelFlank::new(&cutter, &formate, hand, cut.flank.section);
    let point = flank.point([0.5, 0.5], flank.middle().unwrap()).unwrap();
    let mut conditions = CutConditions::regular(feed(8, 0.0));
    conditions.offsets = vec![BladeOffset::default(); 8];
    conditions.offsets[5].axial = 1e-4;
    let depth = flank.section.depth();
    let passes = BladePasses::new((&cutter, &formate, hand), depth, point.at[1], &conditions);
    assert_eq!(passes.scallop(&point), Some(0.0));
    let left = passes.cut(&point, 0.7).unwrap();
    assert_eq!(left.blade, 5);
    let deeper = -1e-4 * cutter.blade_angle.sin();
    assert!(
        (left.deviation / deeper - 1.0).abs() < 1e-6,
        "{left:?} {deeper}"
    );
}

/// Near an undercut limit and beyond the blade a point is left out, and readings hold beyond their ends.
#[test]
fn survives_extremes() {
    let cut = Cut::of("pinion_concave");
    let mut point = cut.point(0.5, 0.5);
    let errors = AngleErrors {
        work: vec![AngleError::harmonic(1e-3, 10.0, 0.0)],
        ..AngleErrors::default()
    };
    let passes = cut.passes(&CutConditions {
        errors,
        ..CutConditions::regular(feed(16, 0.1))
    });
    point.second_order.undercut = 0.0;
    assert_eq!(passes.cut(&point, 0.0), None);
    assert_eq!(cut.regular(feed(0, 1.0)).cut(&point, 0.0), None);
    assert!(AngleError::readings(vec![0.0], vec![1.0]).is_none());
    let held = AngleError::readings(vec![0.0, 1.0], vec![2.0, -3.0]).unwrap();
    assert_eq!(held.law.at(-5.0)[0], 2.0);
    assert_eq!(held.law.at(0.5)[0], -0.5);
    assert_eq!(held.law.at(7.0)[0], -3.0);
    assert_eq!(held.bound, 3.0);
}
