//! The view of a bevel pair in space: one pitch of each gear, their places, and the contact over a pitch for each V and H.

use serde_json::{Value, json};

use super::bevel_plot::Flat;
use super::view::{View, ViewKind};
use crate::gear::bevel::flank_grid::FlankGrid;
use crate::gear::bevel::tooth_section::ToothSection;
use crate::gear::contact::pair::FlankPair;
use crate::gear::load::flank_result::FlankMeshResult;
use crate::plan::gear::bevel::BevelResult;
use crate::plan::gear::bevel_contact::{BevelContact, BevelContactPoint, half_axes, one_pitch};
use crate::plan::gear_limits::MEMBERS;
use crate::scene::bevel_file::BevelFile;

/// Points along the height and along the face of a drawn tooth.
const SOLID_GRID: [usize; 2] = [7, 12];

/// Positions in a pitch that are shown.
const POSITIONS: usize = 60;

/// The view of a pair; none where a flank has gaps and no tooth is known.
pub fn pair_view(file: &BevelFile, result: &BevelResult) -> Option<View> {
    let sides = file.contact.side.flanks();
    let contact = result.contact.as_ref();
    let pair = match contact {
        Some(contact) => contact.pair.clone(),
        None => {
            let of = |k: usize| Some(result.members[k].flanks[sides[k]].as_ref()?.flank.clone());
            let teeth = [0, 1].map(|k| file.members[k].teeth);
            FlankPair::new([of(0)?, of(1)?], teeth, file.hand, &file.assembly())
        }
    };
    // Without a contact a tooth of the pinion is in a space of the gear, on the line of centres.
    let start = match contact {
        Some(c) => [c.path.reference.pinion_angle, c.path.reference.gear_angle()],
        None => [0.0, std::f64::consts::PI / f64::from(pair.teeth[1])],
    };
    let member = |k: usize| -> Option<Value> {
        let of = &result.members[k];
        let grid = &of.flanks[sides[k]].as_ref()?.grid;
        let tooth = of.tooth.as_ref();
        let [rows, columns] = SOLID_GRID;
        let sector = tooth.and_then(|t| Some((t, t.sector(rows, columns)?)));
        let place = pair.pose(k, 0.0);
        let surface = match sector {
            Some((tooth, sector)) => json!({
                "points": sector.points.as_flattened(),
                "rings": sector.rings,
                "closed": true,
                "turn_rad": if contact.is_some() { tooth.turn_to_cut(sides[k]) } else { 0.0 },
            }),
            None => {
                json!({ "points": places(grid)?, "rings": grid.rows, "closed": false, "turn_rad": 0.0 })
            }
        };
        Some(json!({
            "name": MEMBERS[k],
            "teeth": pair.teeth[k],
            "surface": surface,
            "flank": contact.and_then(|_| flank(grid)),
            "corners_m": Flat::of(&pair.flanks[k].section).corners(),
            "rotation": place.rotation.map(|axis| axis.array()).as_flattened(),
            "start_rad": start[k],
        }))
    };
    let states = contact.map(|c| states(file, result, c));
    let sections = [0, 1].map(|k| &pair.flanks[k].section);
    Some(View {
        kind: ViewKind::Pair,
        title: "Gears in mesh".into(),
        replaces: &[],
        data: json!({
            "members": [member(0)?, member(1)?],
            "centres_m": centres(&pair),
            "ratio": pair.ratio(),
            "side": file.contact.side.name(),
            "coating_m": file.contact.coating,
            "contact": states,
            "loaded": result.mesh.as_ref().map(|m| loaded(sections, &m.mesh)),
        }),
    })
}

/// Origins of both members in the fixed frame.
fn centres(pair: &FlankPair) -> [[f64; 3]; 2] {
    [0, 1].map(|k| pair.centre(k).array())
}

/// Places of the nodes of a flank, root row first; none where one is missing.
fn places(grid: &FlankGrid) -> Option<Vec<f64>> {
    let nodes: Option<Vec<[f64; 3]>> = (grid.nodes.iter())
        .map(|n| Some(n.as_ref()?.point.point.coordinates.array()))
        .collect();
    Some(nodes?.as_flattened().to_vec())
}

/// A flank with its normals out of the metal.
fn flank(grid: &FlankGrid) -> Option<Value> {
    let normals: Vec<[f64; 3]> = (grid.nodes.iter().flatten())
        .map(|n| n.point.normal.components.array())
        .collect();
    Some(json!({
        "rows": grid.rows,
        "columns": grid.columns,
        "points": places(grid)?,
        "normals": normals.as_flattened(),
    }))
}

/// Contacts of all states in flat lists; `first` says where each state begins.
fn states(file: &BevelFile, result: &BevelResult, contact: &BevelContact) -> Value {
    let step = file.contact.positions.div_ceil(POSITIONS);
    let nominal: Vec<BevelContactPoint> = (one_pitch(&contact.points, file.contact.positions)
        .iter())
    .step_by(step)
    .copied()
    .collect();
    let mut lists = ContactLists::default();
    let (mut index, mut shifts) = (vec![Some(0)], [vec![0.0], vec![0.0]]);
    lists.add(&contact.pair, &nominal, contact.peak_to_peak);
    if let Some(states) = &result.states {
        shifts = [states.offsets.clone(), states.axials.clone()];
        // The unmoved state is known with more positions.
        let middle = states.states.len() / 2;
        index = (states.states.iter().enumerate())
            .map(|(i, state)| match state {
                _ if i == middle => Some(0),
                Some(state) => Some(lists.add(&state.pair, &state.points, state.peak_to_peak)),
                None => None,
            })
            .collect();
    }
    let [offsets, axials] = shifts;
    json!({
        "offsets_m": offsets,
        "pinion_axials_m": axials,
        "index": index,
        "first": lists.first,
        "centres_m": lists.centres,
        "peak_to_peak_rad": lists.peak_to_peak,
        "pinion_rad": lists.pinion,
        "gear_rad": lists.gear,
        "te_rad": lists.te,
        "pair": lists.number,
        "marks": lists.marks,
        "reference_rad": contact.path.reference.pinion_angle,
    })
}

/// Contacts of states one behind the other.
#[derive(Default)]
struct ContactLists {
    first: Vec<usize>,
    centres: Vec<[[f64; 3]; 2]>,
    peak_to_peak: Vec<Option<f64>>,
    pinion: Vec<f64>,
    gear: Vec<f64>,
    te: Vec<f64>,
    number: Vec<i32>,
    /// Shares of face and height of the middle and of both half axes, contact by contact, for each member.
    marks: [Vec<f64>; 2],
}

impl ContactLists {
    /// Adds a state and returns its index.
    fn add(&mut self, pair: &FlankPair, points: &[BevelContactPoint], te: Option<f64>) -> usize {
        self.first.push(self.pinion.len());
        self.centres.push(centres(pair));
        self.peak_to_peak.push(te);
        for point in points {
            let middles = [0, 1].map(|k| pair.shares(k, &point.contact));
            let [Some(a), Some(b)] = middles else {
                continue;
            };
            for (k, middle) in [a, b].into_iter().enumerate() {
                let axes = half_axes(pair, point, k).unwrap_or_default();
                self.marks[k].extend(middle.iter().chain(axes.as_flattened()));
            }
            self.pinion.push(point.pinion_angle);
            self.gear.push(point.gear_angle);
            self.te.push(point.te);
            self.number.push(point.pair);
        }
        self.first.len() - 1
    }
}

/// Cells that carry at the last torque, position by position, a pitch from the reference on.
fn loaded(sections: [&ToothSection; 2], mesh: &FlankMeshResult) -> Value {
    let Some(cycle) = mesh.cycles.last() else {
        return Value::Null;
    };
    let step = cycle.positions.len().div_ceil(POSITIONS);
    let (mut first, mut pair, mut pressure) = (Vec::new(), Vec::new(), Vec::new());
    let mut marks = [Vec::new(), Vec::new()];
    for position in cycle.positions.iter().step_by(step) {
        first.push(pair.len());
        for place in &position.places {
            let shares = [0, 1].map(|k| sections[k].shares(place.at[k]));
            let [Some(a), Some(b)] = shares else {
                continue;
            };
            marks[0].extend(a);
            marks[1].extend(b);
            pair.push(place.pair);
            pressure.push(1e-6 * place.pressure);
        }
    }
    json!({ "torque_nm": cycle.torque, "first": first, "pair": pair, "pressure_mpa": pressure, "marks": marks })
}
