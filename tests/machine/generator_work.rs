//! Errors of a generator's chain on the flank of its work and in the pair: against the exact envelope and the contact of changed flanks.

use std::path::Path;

use geardyn::internals::base::flags::Flags;
use geardyn::internals::base::load;
use geardyn::internals::gear::bevel::flank::BevelFlank;
use geardyn::internals::gear::contact::contact_path::ContactPath;
use geardyn::internals::gear::contact::pair::FlankPair;
use geardyn::internals::gear::cut::roll_errors::{
    RollError, rolled_contacts, smooth, surplus_of_work,
};
use geardyn::internals::gear::kernel::law::Law;
use geardyn::internals::numeric::Complex;
use geardyn::internals::scene::bevel_file::{self, BevelFile};
use serde_json::Value;

use crate::support::verification::{order, within};

const NASA: &str = "models/gears/bevel_12_36.toml";
const MICROMETRES: f64 = 1e6;

fn file() -> BevelFile {
    let source = load::load(Path::new(NASA)).unwrap();
    let flags = Flags::default();
    bevel_file::read(&source, &flags).unwrap()
}

/// The concave flank of the pinion, cut with an error of the roll.
fn cut(file: &BevelFile, error: &RollError) -> BevelFlank {
    let settings = &file.members[0].flanks[0].as_ref().unwrap().settings;
    let mut flank = file.flank(0, 0).unwrap();
    let laws = [None, Law::sum(vec![error.law()])];
    let motion = settings.motion_with_errors(file.hand_of(0), laws);
    assert!(flank.edge.is_none(), "sharp blades");
    flank.envelope.motion = motion;
    flank
}

fn polar(size: f64, angle: f64) -> Complex {
    Complex::new(size * angle.cos(), size * angle.sin())
}

/// Surplus of the flank by an error of the roll: to first order by the envelope theorem, exact along the normal.
/// Source: two computations of the changed flank, data/reference/gear/c22_machine_te_to_flank_error.json.
#[test]
fn ref_roll_error_on_the_flank() {
    let text = std::fs::read_to_string("data/reference/gear/c22_machine_te_to_flank_error.json");
    let case: Value = serde_json::from_str(&text.unwrap()).unwrap();
    let file = file();
    let (flank, hand) = (file.flank(0, 0).unwrap(), file.hand_of(0));
    let middle = flank.middle().unwrap();
    let (mut first, mut exact) = (0f64, 0f64);
    for row in case["rows"].as_array().unwrap() {
        let row: Vec<f64> = (row.as_array().unwrap().iter())
            .map(|x| x.as_f64().unwrap())
            .collect();
        let error = RollError {
            value: polar(hand.sign() * (row[0] / 3600.0).to_radians(), 0.3),
            order: row[1],
        };
        let point = flank.point([row[2], row[3]], middle).unwrap();
        assert!(
            (point.at[2] - row[4]).abs() < 6e-6,
            "{} {row:?}",
            point.at[2]
        );
        // Normals of the case point into the metal.
        let surplus = surplus_of_work(&point, hand) * error.at(point.at[2], 0.0);
        first = first.max((surplus * MICROMETRES + row[5]).abs());
        let changed = cut(&file, &error).envelope;
        let (_, distance) = changed
            .intersect_ray(point.point, point.normal, point.at)
            .unwrap();
        exact = exact.max((distance * MICROMETRES + row[6]).abs());
    }
    within("first order, µm", first, 5.1e-5);
    within("exact, µm", exact, 5.1e-5);
}

fn pair_of(file: &BevelFile, pinion: BevelFlank) -> (FlankPair, ContactPath) {
    let flanks = [pinion, file.flank(1, 1).unwrap()];
    let pair = FlankPair::new(flanks, [12, 36], file.hand, &file.assembly());
    let path = pair.path(pair.first_contact().unwrap(), 1.5, 60);
    (pair, path)
}

/// The transmission error that an error of the roll adds: contact of the changed flanks against δ/r₂, whose rest falls with ε².
#[test]
fn order_roll_error_in_the_pair() {
    let file = file();
    let (pair, path) = pair_of(&file, file.flank(0, 0).unwrap());
    let contacts = rolled_contacts(&pair, &path, (0, file.hand_of(0)), 24).unwrap();
    let rest = |size: f64| {
        let error = RollError {
            value: polar(size, 0.7),
            order: 20.0,
        };
        let (changed, changed_path) = pair_of(&file, cut(&file, &error));
        let off = contacts.iter().map(|c| {
            let te = |pair: &FlankPair, path: &ContactPath| {
                pair.leading(path, c.pinion_angle).unwrap().te
            };
            let added = te(&changed, &changed_path) - te(&pair, &path);
            added - c.gain * error.at(c.turn, 0.0)
        });
        let off: Vec<f64> = off.collect();
        // Both count from their own reference contact.
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        off.iter().fold(0.0f64, |m, x| m.max((x - mean).abs()))
    };
    within("rest at 4e-6 rad, of the error", rest(4e-6) / 4e-6, 0.02);
    order(
        "rest of the first order",
        2.0,
        (rest(4e-6) / rest(2e-6)).log2(),
    );
}

/// Errors are put into an envelope from the smoothest on, as long as their second derivatives together leave it without edges.
#[test]
fn law_smooth_errors() {
    let file = file();
    let flank = file.flank(0, 0).unwrap();
    let middle = flank.middle().unwrap();
    let points = [0.2, 0.5, 0.8].map(|face| flank.point([face, 0.5], middle).unwrap());
    let wave = |order: f64| RollError {
        value: polar(1e-5, 0.0),
        order,
    };
    let errors = [wave(2000.0), wave(1.0), wave(60.0)];
    assert_eq!(smooth(&errors, points.iter()), [false, true, true]);
}
