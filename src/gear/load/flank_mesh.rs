//! Loaded contact of flanks in space over one pitch: ridges of least gap as contact lines, `e(φ, T) = e₀(φ) − Δ(φ, T)` about the gear's axis.
//!
//! The gap of a station is arm × (highest e₀ − its own), the curvature across the ridge that along the height over sin² of the angle
//! between both. The ridge knows no load: it is computed once a position, for all torques. A line of a contact ellipse with a/b below
//! 2.9, which has too few cells, becomes one cell with the closed form of that ellipse; a/b knows no load either.

use super::contact_line::{ContactCell, ContactLine};
use super::elliptic_contact::EllipticContact;
use super::flank_position::{FlankPosition, ToothBending};
use super::flank_result::{FlankCycle, FlankMeshResult, StripChange};
use super::load_path::CarryingChange;
use super::loaded_lines::{LineLoads, LoadedLines};
use super::material::Material;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::contact::contact_path::ContactPath;
use crate::gear::contact::pair::FlankPair;
use crate::gear::contact::ridge::{RidgePoint, RidgeStations};
use crate::numeric::parallel;

/// Pitches from the reference contact within which a pair of teeth may carry.
const REACH: f64 = 2.5;
/// Least relative curvature across a contact, 1/m: flanks that fit closer are taken as a cylinder of 10 m.
const LEAST_CURVATURE: f64 = 0.1;
/// a/b from which strips have the cells to resolve a contact: with 1.2 half widths each, five.
pub const LEAST_ASPECT: f64 = 2.9;
/// Gap in transverse modules of the gear that no load closes: pairs of teeth further apart are left out.
const FARTHEST: f64 = 0.1;

/// Options of a mesh of flanks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlankMeshOptions {
    /// Elastic constants of pinion and gear.
    pub materials: [Material; 2],
    /// Positions in one pitch.
    pub positions: usize,
    /// Stations along the pinion's face.
    pub stations: usize,
}

impl Default for FlankMeshOptions {
    fn default() -> FlankMeshOptions {
        FlankMeshOptions {
            materials: [Material::default(); 2],
            positions: 60,
            stations: 32,
        }
    }
}

/// Metal that a member's flank has beyond its envelope at the parameters `[u, θ, x]`, along the normal, m.
pub type FlankSurplus<'a> = dyn Fn(usize, [f64; 3]) -> f64 + Sync + 'a;

/// Flanks ready to be loaded.
pub struct FlankMesh<'a> {
    pair: &'a FlankPair,
    path: &'a ContactPath,
    options: FlankMeshOptions,
    stations: RidgeStations,
    teeth: Option<&'a dyn ToothBending>,
    surplus: Option<&'a FlankSurplus<'a>>,
}

impl<'a> FlankMesh<'a> {
    /// Flanks with their unloaded path of contact; rigid teeth where none are given.
    pub fn new(
        pair: &'a FlankPair,
        path: &'a ContactPath,
        options: FlankMeshOptions,
        teeth: Option<&'a dyn ToothBending>,
    ) -> FlankMesh<'a> {
        let n = options.stations;
        let faces: Vec<f64> = (0..n).map(|i| (i as f64 + 0.5) / n as f64).collect();
        FlankMesh {
            stations: RidgeStations::new(pair, &path.reference, &faces),
            pair,
            path,
            options,
            teeth,
            surplus: None,
        }
    }

    /// The same flanks with a surplus, which to first order turns the gear ahead by surplus over arm where they touch. Contacts remain
    /// strips.
    pub fn with_surplus(self, surplus: &'a FlankSurplus<'a>) -> FlankMesh<'a> {
        FlankMesh {
            surplus: Some(surplus),
            ..self
        }
    }

    /// Turn by which the surplus of both flanks puts the gear ahead, rad, at their parameters and the arm of the normal.
    fn ahead(&self, unknowns: [[f64; 3]; 2], arm: f64) -> f64 {
        self.surplus.map_or(0.0, |surplus| {
            (surplus(0, unknowns[0]) + surplus(1, unknowns[1])) / arm
        })
    }

    /// The pinion's angle of a position, rad: a pitch from the reference contact on, by growing angle.
    pub fn angle(&self, position: usize) -> f64 {
        let share = position as f64 / self.options.positions as f64;
        self.path.reference.pinion_angle + share * self.pair.pitch()
    }

    /// The flanks at an angle of the pinion, rad.
    ///
    /// # Errors
    /// `OutOfRange`: no pair of teeth can touch there.
    pub fn position(&self, angle: f64) -> Result<FlankPosition, Error> {
        let (pitch, reference) = (self.pair.pitch(), self.path.reference.pinion_angle);
        let from = ((reference - angle) / pitch - REACH).ceil() as i32;
        let to = ((reference - angle) / pitch + REACH).floor() as i32;
        let numbers = (from..=to).map(|pair| {
            let mut ridge = self
                .stations
                .ridge(self.pair, angle + f64::from(pair) * pitch);
            for point in &mut ridge {
                point.te += self.ahead(point.unknowns, point.arm);
            }
            (pair, ridge)
        });
        let found: Vec<(i32, Vec<RidgePoint>)> = numbers.filter(|(_, r)| r.len() > 1).collect();
        let highest = found
            .iter()
            .flat_map(|(_, r)| r)
            .map(|p| p.te)
            .reduce(f64::max);
        let highest = highest.ok_or_else(|| {
            let message = format!("no tooth pair can touch at the pinion angle {:.4} deg", angle.to_degrees());
            Error::new(Code::OutOfRange, message)
                .with_hint("the teeth part before the next pair meets: give larger face angles or another [assembly]")
        })?;
        let leading = self.pair.leading(self.path, angle);
        let unloaded_te = leading.map_or(highest, |leading| {
            let [u, theta, x, u2, theta2, x2, _] = leading.contact.unknowns;
            let arm = self.pair.turn(1).at(leading.contact.point);
            let arm = arm.dot(leading.contact.normal).abs();
            let ahead = self.ahead([[u, theta, x], [u2, theta2, x2]], arm);
            highest.max(leading.te + ahead)
        });
        let lowest = unloaded_te - 2.0 * FARTHEST / f64::from(self.pair.teeth[1]);
        let spacing = 1.0 / self.options.stations as f64;
        let (mut lines, mut ridges, mut reaches) = (Vec::new(), Vec::new(), Vec::new());
        for (pair, ridge) in found {
            if ridge.iter().all(|p| p.te < lowest) {
                continue;
            }
            let mut cells = self.cells(&ridge, unloaded_te, spacing);
            let is_smooth = self.surplus.is_none();
            let ellipse = is_smooth.then(|| self.ellipse(&cells, &ridge)).flatten();
            reaches.push(ellipse.as_ref().map(|(_, cell)| {
                let [first, last] = [&cells[0], &cells[cells.len() - 1]];
                let before = cell.along - first.along + 0.5 * first.length;
                before.min(last.along + 0.5 * last.length - cell.along)
            }));
            match ellipse {
                Some((at, cell)) => {
                    ridges.push(vec![ridge[at]]);
                    cells = vec![cell];
                }
                None => ridges.push(ridge),
            }
            lines.push(ContactLine { pair, cells });
        }
        Ok(FlankPosition {
            unloaded_te,
            lines: LoadedLines::new(lines, self.options.materials),
            ridges,
            reaches,
        })
    }

    /// The pitch at several torques of the pinion, N·m.
    ///
    /// # Errors
    /// As `position` and `LoadedLines::solve`.
    pub fn map(&self, torques: &[f64]) -> Result<FlankMeshResult, Error> {
        let count = self.options.positions;
        let ratio = self.pair.ratio().abs();
        let angles: Vec<f64> = (0..count).map(|i| self.angle(i)).collect();
        let positions = parallel::try_map(&angles, |angle| {
            let position = self.position(*angle)?;
            let mut start: Option<LineLoads> = None;
            let mut loaded = Vec::with_capacity(torques.len());
            for torque in torques.iter().map(|t| t / ratio) {
                let solve = |start: Option<&LineLoads>| position.lines.solve(torque, start);
                // Cells that another torque loads may lead astray.
                let loads = solve(start.as_ref()).or_else(|_| solve(None))?;
                loaded.push(position.load(&loads, torque, self.teeth));
                start = Some(loads);
            }
            Ok::<_, Error>((position.unloaded_te, loaded))
        })?;
        let mut unloaded_te = Vec::with_capacity(count);
        let mut cycles: Vec<FlankCycle> = torques.iter().map(|t| FlankCycle::new(*t)).collect();
        for (te, loaded) in positions {
            unloaded_te.push(te);
            let pairs = cycles.iter_mut().zip(loaded);
            pairs.for_each(|(cycle, load)| cycle.positions.push(load));
        }
        Ok(FlankMeshResult {
            pinion_angles: angles,
            pitch: self.pair.pitch(),
            unloaded_te,
            cycles,
        })
    }

    /// Error of e(φ, T) from the stations, rad, by torque: half the greatest difference to half as many stations. Edges that cover a few
    /// stations converge with about the order 1.5, and unevenly.
    ///
    /// # Errors
    /// As `map`.
    pub fn te_errors(&self, fine: &FlankMeshResult) -> Result<Vec<f64>, Error> {
        /// Share of the difference that is left at the order 1.5, `1/(2^1.5 − 1)`, rounded.
        const ORDER_SHARE: f64 = 0.5;
        let torques: Vec<f64> = fine.cycles.iter().map(|c| c.torque).collect();
        let options = FlankMeshOptions {
            stations: self.options.stations / 2,
            ..self.options
        };
        let coarse = FlankMesh::new(self.pair, self.path, options, self.teeth).map(&torques)?;
        let apart = fine
            .cycles
            .iter()
            .zip(&coarse.cycles)
            .map(|(fine, coarse)| {
                let places = fine.positions.iter().zip(&coarse.positions);
                let most = places.map(|(a, b)| (a.te - b.te).abs()).fold(0.0, f64::max);
                ORDER_SHARE * most
            });
        Ok(apart.collect())
    }

    /// Torques of the pinion at which the set of strips that carry changes as the load is raised, by position, N·m.
    ///
    /// # Errors
    /// As `position` and `LoadedLines::changes`.
    pub fn changes(&self, torque: f64) -> Result<Vec<Vec<StripChange>>, Error> {
        let ratio = self.pair.ratio().abs();
        let at = |i: &usize| {
            let position = self.position(self.angle(*i))?;
            let changes = position.lines.changes(torque / ratio)?;
            let strip = |change: &CarryingChange| StripChange {
                torque: change.torque * ratio,
                pair: position.lines.lines[change.line].pair,
                face: position.ridges[change.line][change.cell].face,
                begins: change.begins,
            };
            Ok(changes.iter().map(strip).collect())
        };
        parallel::try_map(&(0..self.options.positions).collect::<Vec<_>>(), at)
    }

    /// The cell of a whole contact whose ellipse is shorter than strips resolve, and the place of its middle on the ridge; none where the
    /// ridge is highest at an end or on an edge.
    fn ellipse(&self, cells: &[ContactCell], ridge: &[RidgePoint]) -> Option<(usize, ContactCell)> {
        let by_gap = |a: &usize, b: &usize| cells[*a].gap.total_cmp(&cells[*b].gap);
        let top = (0..cells.len()).min_by(by_gap)?;
        let near = cells.get(top.checked_sub(1)?..top + 2)?;
        if near.iter().any(|cell| cell.on_edge) {
            return None;
        }
        // Parabola of the gap along the ridge through the highest place and its neighbours.
        let step = |i: usize| near[i + 1].along - near[i].along;
        let slope = |i: usize| (near[i + 1].gap - near[i].gap) / step(i);
        let along = 2.0 * (slope(1) - slope(0)) / (step(0) + step(1));
        let at_top = (slope(0) * step(1) + slope(1) * step(0)) / (step(0) + step(1));
        let off = -at_top / along;
        let here = &ridge[top];
        let chord = (ridge[top + 1].point - ridge[top - 1].point).unit()?;
        let curvatures = principal(along, here.curvature, chord.dot(here.along_height))?;
        let unit = EllipticContact::new(curvatures, 1.0, &self.options.materials)?;
        (unit.aspect() < LEAST_ASPECT).then(|| {
            let cell = ContactCell {
                along: cells[top].along + off,
                gap: (cells[top].gap + 0.5 * at_top * off).max(0.0),
                ellipse: Some(unit),
                ..cells[top].clone()
            };
            (top, cell)
        })
    }

    /// The cells of a ridge, each as long as the distance between the middles towards its neighbours.
    fn cells(&self, ridge: &[RidgePoint], highest: f64, spacing: f64) -> Vec<ContactCell> {
        let mut along = 0.0;
        let last = ridge.len() - 1;
        let cell = |i: usize| {
            let here = &ridge[i];
            let (before, after) = (&ridge[i.saturating_sub(1)], &ridge[(i + 1).min(last)]);
            let chord = after.point - before.point;
            let steps = ((after.face - before.face) / spacing).round().max(1.0);
            let length = chord.norm() / steps;
            let cos = chord.dot(here.along_height) / chord.norm();
            let across = here.curvature / (1.0 - cos * cos);
            if i > 0 {
                along += (here.point - before.point).norm();
            }
            ContactCell {
                along,
                length,
                gap: here.arm * (highest - here.te),
                arm: here.arm,
                curvature: across.max(LEAST_CURVATURE),
                on_edge: here.edge.is_some(),
                ellipse: None,
                teeth: self.teeth.and_then(|teeth| {
                    Some([teeth.at(0, here.places[0])?, teeth.at(1, here.places[1])?])
                }),
            }
        };
        (0..ridge.len()).map(cell).collect()
    }
}

/// Principal curvatures of a gap whose curvature is `along` a ridge and `over` the height, which it makes the angle of `cosine` with: the
/// two directions are conjugate, since the gap is least over the height on the ridge.
fn principal(along: f64, over: f64, cosine: f64) -> Option<[f64; 2]> {
    let sine_square = 1.0 - cosine * cosine;
    let across = (over + cosine * cosine * along) / sine_square;
    let mixed = -along * cosine / sine_square.sqrt();
    let (mean, half) = (0.5 * (along + across), 0.5 * (along - across));
    let apart = half.hypot(mixed);
    (mean > apart).then_some([mean - apart, mean + apart])
}
