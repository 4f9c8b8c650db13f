//! Loaded tooth contact of bevel flanks over one pitch, with ridges of smallest gap as contact lines: `e(φ, T) = e₀(φ) − Δ(φ, T)`, rad.
//!
//! The gap of a station is arm × (maximum e₀ − e₀ of the station); the curvature across the ridge is that along the height over sin² of the
//! angle between both. The ridge does not depend on load: one computation per position serves all torques. A contact ellipse with a/b below
//! 2.9, with too few cells, becomes one cell with the closed form of the ellipse; a/b does not depend on load either.

use super::contact_line::{ContactCell, ContactLine};
use super::elliptic_contact::EllipticContact;
use super::flank_position::{FlankPosition, ToothBending};
use super::flank_result::{FlankCycle, FlankMeshResult, StripChange};
use super::load_path::ActiveSetChange;
use super::loaded_lines::{LineLoads, LoadedLines};
use super::material::Material;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::contact::contact_path::ContactPath;
use crate::gear::contact::pair::FlankPair;
use crate::gear::contact::ridge::{RidgePoint, RidgeStations};
use crate::numeric::parallel;

/// Largest distance of a loaded tooth pair from the reference contact, in pitches.
const MAX_PITCHES: f64 = 2.5;
/// Smallest relative curvature across a contact, 1/m: radius limit of 10 m for closely conforming flanks.
const MIN_CURVATURE: f64 = 0.1;
/// Smallest aspect ratio a/b resolved by strips: five cells of 1.2 half widths.
pub const MIN_ASPECT: f64 = 2.9;
/// Largest gap of a tooth pair closed by load, in transverse modules of the gear; pairs with a larger gap are excluded.
const MAX_GAP: f64 = 0.1;

/// Options of a loaded flank mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlankMeshOptions {
    /// Elastic constants of pinion and gear.
    pub materials: [Material; 2],
    /// Number of positions per pitch.
    pub positions: usize,
    /// Number of stations along the pinion face.
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

/// Excess material of a member's flank over the envelope at the parameters `[u, θ, x]`, along the normal, m.
pub type FlankSurplus<'a> = dyn Fn(usize, [f64; 3]) -> f64 + Sync + 'a;

/// Loaded mesh of bevel flanks.
pub struct FlankMesh<'a> {
    pair: &'a FlankPair,
    path: &'a ContactPath,
    options: FlankMeshOptions,
    stations: RidgeStations,
    teeth: Option<&'a dyn ToothBending>,
    surplus: Option<&'a FlankSurplus<'a>>,
}

impl<'a> FlankMesh<'a> {
    /// Loaded mesh with the unloaded path of contact; rigid teeth for `teeth = None`.
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

    /// Loaded mesh with excess material of the flanks: to first order te increases by surplus over arm at a contact. Contacts are solved
    /// with strips only.
    pub fn with_surplus(self, surplus: &'a FlankSurplus<'a>) -> FlankMesh<'a> {
        FlankMesh {
            surplus: Some(surplus),
            ..self
        }
    }

    /// Change of te by the surplus of both flanks, rad, at their parameters and the lever arm of the normal, m.
    fn surplus_te(&self, unknowns: [[f64; 3]; 2], arm: f64) -> f64 {
        self.surplus.map_or(0.0, |surplus| {
            (surplus(0, unknowns[0]) + surplus(1, unknowns[1])) / arm
        })
    }

    /// Pinion angle of a position, rad, in ascending order over one pitch from the reference contact.
    pub fn angle(&self, position: usize) -> f64 {
        let share = position as f64 / self.options.positions as f64;
        self.path.reference.pinion_angle + share * self.pair.pitch()
    }

    /// Contact lines of all tooth pairs at a pinion angle, rad.
    ///
    /// # Errors
    /// `OutOfRange`: no tooth pair in possible contact.
    pub fn position(&self, angle: f64) -> Result<FlankPosition, Error> {
        let (pitch, reference) = (self.pair.pitch(), self.path.reference.pinion_angle);
        let from = ((reference - angle) / pitch - MAX_PITCHES).ceil() as i32;
        let to = ((reference - angle) / pitch + MAX_PITCHES).floor() as i32;
        let numbers = (from..=to).map(|pair| {
            let mut ridge = self
                .stations
                .ridge(self.pair, angle + f64::from(pair) * pitch);
            for point in &mut ridge {
                point.te += self.surplus_te(point.unknowns, point.arm);
            }
            (pair, ridge)
        });
        let pairs: Vec<(i32, Vec<RidgePoint>)> = numbers.filter(|(_, r)| r.len() > 1).collect();
        let highest = pairs
            .iter()
            .flat_map(|(_, r)| r)
            .map(|p| p.te)
            .reduce(f64::max);
        let highest = highest.ok_or_else(|| {
            let message = format!("no tooth pair can touch at the pinion angle {:.4} deg", angle.to_degrees());
            Error::new(Code::OutOfRange, message)
                .with_hint("the teeth separate before the next pair touches: give larger face angles or another [assembly]")
        })?;
        let leading = self.pair.leading(self.path, angle);
        let unloaded_te = leading.map_or(highest, |leading| {
            let [u, theta, x, u2, theta2, x2, _] = leading.contact.unknowns;
            let arm = self.pair.turn(1).at(leading.contact.point);
            let arm = arm.dot(leading.contact.normal).abs();
            let change = self.surplus_te([[u, theta, x], [u2, theta2, x2]], arm);
            highest.max(leading.te + change)
        });
        let lowest = unloaded_te - 2.0 * MAX_GAP / f64::from(self.pair.teeth[1]);
        let spacing = 1.0 / self.options.stations as f64;
        let (mut lines, mut ridges, mut reaches) = (Vec::new(), Vec::new(), Vec::new());
        for (pair, ridge) in pairs {
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

    /// Loaded results over one pitch at several pinion torques, N·m.
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
                // The active cells of another torque can prevent convergence.
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

    /// Discretisation error of e(φ, T) by torque, rad: half the largest difference to half the number of stations. Edge contacts over few
    /// stations converge irregularly, with an order of about 1.5.
    ///
    /// # Errors
    /// As `map`.
    pub fn te_errors(&self, fine: &FlankMeshResult) -> Result<Vec<f64>, Error> {
        /// Remaining share of the difference at the order 1.5, `1/(2^1.5 − 1)`, rounded.
        const ORDER_SHARE: f64 = 0.5;
        let torques: Vec<f64> = fine.cycles.iter().map(|c| c.torque).collect();
        let options = FlankMeshOptions {
            stations: self.options.stations / 2,
            ..self.options
        };
        let coarse = FlankMesh::new(self.pair, self.path, options, self.teeth).map(&torques)?;
        let errors = fine
            .cycles
            .iter()
            .zip(&coarse.cycles)
            .map(|(fine, coarse)| {
                let pairs = fine.positions.iter().zip(&coarse.positions);
                let max = pairs.map(|(a, b)| (a.te - b.te).abs()).fold(0.0, f64::max);
                ORDER_SHARE * max
            });
        Ok(errors.collect())
    }

    /// Pinion torques of changes in the set of loaded strips during loading, by position, N·m.
    ///
    /// # Errors
    /// As `position` and `LoadedLines::changes`.
    pub fn changes(&self, torque: f64) -> Result<Vec<Vec<StripChange>>, Error> {
        let ratio = self.pair.ratio().abs();
        let changes_at = |i: &usize| {
            let position = self.position(self.angle(*i))?;
            let changes = position.lines.changes(torque / ratio)?;
            let strip = |change: &ActiveSetChange| StripChange {
                torque: change.torque * ratio,
                pair: position.lines.lines[change.line].pair,
                face: position.ridges[change.line][change.cell].face,
                begins: change.begins,
            };
            Ok(changes.iter().map(strip).collect())
        };
        parallel::try_map(&(0..self.options.positions).collect::<Vec<_>>(), changes_at)
    }

    /// Cell of a contact ellipse too short for strips, with the ridge index of its centre; `None` for a
    /// maximum at an end of the ridge or on an edge.
    fn ellipse(&self, cells: &[ContactCell], ridge: &[RidgePoint]) -> Option<(usize, ContactCell)> {
        let by_gap = |a: &usize, b: &usize| cells[*a].gap.total_cmp(&cells[*b].gap);
        let top = (0..cells.len()).min_by(by_gap)?;
        let three = cells.get(top.checked_sub(1)?..top + 2)?;
        if three.iter().any(|cell| cell.on_edge) {
            return None;
        }
        // Parabola of the gap along the ridge through the point of smallest gap and its neighbours.
        let step = |i: usize| three[i + 1].along - three[i].along;
        let slope = |i: usize| (three[i + 1].gap - three[i].gap) / step(i);
        let along = 2.0 * (slope(1) - slope(0)) / (step(0) + step(1));
        let at_top = (slope(0) * step(1) + slope(1) * step(0)) / (step(0) + step(1));
        let offset = -at_top / along;
        let centre = &ridge[top];
        let chord = (ridge[top + 1].point - ridge[top - 1].point).unit()?;
        let curvatures = principal(along, centre.curvature, chord.dot(centre.along_height))?;
        let unit = EllipticContact::new(curvatures, 1.0, &self.options.materials)?;
        (unit.aspect() < MIN_ASPECT).then(|| {
            let cell = ContactCell {
                along: cells[top].along + offset,
                gap: (cells[top].gap + 0.5 * at_top * offset).max(0.0),
                ellipse: Some(unit),
                ..cells[top].clone()
            };
            (top, cell)
        })
    }

    /// Cells of a ridge; cell boundaries are midway between neighbouring points.
    fn cells(&self, ridge: &[RidgePoint], highest: f64, spacing: f64) -> Vec<ContactCell> {
        let mut along = 0.0;
        let last = ridge.len() - 1;
        let cell = |i: usize| {
            let point = &ridge[i];
            let (before, after) = (&ridge[i.saturating_sub(1)], &ridge[(i + 1).min(last)]);
            let chord = after.point - before.point;
            let steps = ((after.face - before.face) / spacing).round().max(1.0);
            let length = chord.norm() / steps;
            let cos = chord.dot(point.along_height) / chord.norm();
            let across = point.curvature / (1.0 - cos * cos);
            if i > 0 {
                along += (point.point - before.point).norm();
            }
            ContactCell {
                along,
                length,
                gap: point.arm * (highest - point.te),
                arm: point.arm,
                curvature: across.max(MIN_CURVATURE),
                on_edge: point.edge.is_some(),
                ellipse: None,
                teeth: self.teeth.and_then(|teeth| {
                    Some([teeth.at(0, point.places[0])?, teeth.at(1, point.places[1])?])
                }),
            }
        };
        (0..ridge.len()).map(cell).collect()
    }
}

/// Principal curvatures of a gap, 1/m, from the curvatures `along` a ridge and `over` the height, at an angle of `cosine`: the
/// two directions are conjugate, since the gap on the ridge is minimal over the height.
fn principal(along: f64, over: f64, cosine: f64) -> Option<[f64; 2]> {
    let sine_square = 1.0 - cosine * cosine;
    let across = (over + cosine * cosine * along) / sine_square;
    let mixed = -along * cosine / sine_square.sqrt();
    let (mean, half) = (0.5 * (along + across), 0.5 * (along - across));
    let radius = half.hypot(mixed);
    (mean > radius).then_some([mean - radius, mean + radius])
}
