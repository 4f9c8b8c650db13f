//! Loaded contact of flanks in space over one pitch: ridges of least gap as contact lines, `e(φ, T) = e₀(φ) − Δ(φ, T)` about the gear's axis.
//!
//! The gap of a station is arm × (highest e₀ − its own), the curvature across the ridge that along the height over sin² of the angle
//! between both. The ridge knows no load: it is computed once a position, for all torques.

use super::contact_line::{ContactCell, ContactLine, ToothLoad};
use super::flank_result::{FlankCycle, FlankLoad, FlankMeshResult, LoadedPlace};
use super::loaded_lines::{LineLoads, LoadedLines};
use super::material::Material;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::contact::contact_path::ContactPath;
use crate::gear::contact::pair::FlankPair;
use crate::gear::contact::ridge::{RidgePoint, RidgeStations};

/// Pitches from the reference contact within which a pair of teeth may carry.
const REACH: f64 = 2.5;
/// Least relative curvature across a contact, 1/m: flanks that fit closer are taken as a cylinder of 10 m.
const LEAST_CURVATURE: f64 = 0.1;
/// Depth below a line contact of the greatest shear, in half widths, and that shear over the greatest pressure: Johnson, Contact
/// Mechanics (1985), eq. 4.47.
pub const SHEAR: [f64; 2] = [0.78, 0.30];

/// Teeth that bend under a force at a place of their section.
pub trait ToothBending {
    /// The load on the tooth of a member under a unit force along the normal at `[z, radius]`.
    fn at(&self, member: usize, place: [f64; 2]) -> Option<ToothLoad>;
}

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

/// Flanks ready to be loaded.
pub struct FlankMesh<'a> {
    pair: &'a FlankPair,
    path: &'a ContactPath,
    options: FlankMeshOptions,
    stations: RidgeStations,
    teeth: Option<&'a dyn ToothBending>,
}

/// The flanks at one angle.
#[derive(Debug, Clone)]
pub struct FlankPosition {
    /// Transmission error without load, rad.
    pub unloaded_te: f64,
    /// The contact lines under load.
    pub lines: LoadedLines,
    /// Places of their cells.
    pub ridges: Vec<Vec<RidgePoint>>,
}

impl FlankMesh<'_> {
    /// Flanks with their unloaded path of contact; rigid teeth where none are given.
    pub fn new<'a>(
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
        }
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
            let ridge = self
                .stations
                .ridge(self.pair, angle + f64::from(pair) * pitch);
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
        let unloaded_te = leading.map_or(highest, |l| l.te.max(highest));
        let spacing = 1.0 / self.options.stations as f64;
        let lines = found.iter().map(|(pair, ridge)| ContactLine {
            pair: *pair,
            cells: self.cells(ridge, unloaded_te, spacing),
        });
        Ok(FlankPosition {
            unloaded_te,
            lines: LoadedLines::new(lines.collect(), self.options.materials),
            ridges: found.into_iter().map(|(_, ridge)| ridge).collect(),
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
        let mut unloaded_te = Vec::with_capacity(count);
        let mut cycles: Vec<FlankCycle> = torques.iter().map(|t| FlankCycle::new(*t)).collect();
        for angle in &angles {
            let position = self.position(*angle)?;
            unloaded_te.push(position.unloaded_te);
            let mut start: Option<LineLoads> = None;
            for cycle in &mut cycles {
                let loads = position.lines.solve(cycle.torque / ratio, start.as_ref())?;
                cycle
                    .positions
                    .push(position.load(&loads, cycle.torque / ratio));
                start = Some(loads);
            }
        }
        Ok(FlankMeshResult {
            pinion_angles: angles,
            pitch: self.pair.pitch(),
            unloaded_te,
            cycles,
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
                teeth: self.teeth.and_then(|teeth| {
                    Some([teeth.at(0, here.places[0])?, teeth.at(1, here.places[1])?])
                }),
            }
        };
        (0..ridge.len()).map(cell).collect()
    }
}

impl FlankPosition {
    /// Results of a load at this position; `torque` is that of the gear, N·m.
    fn load(&self, loads: &LineLoads, torque: f64) -> FlankLoad {
        let mut load = FlankLoad {
            te: self.unloaded_te - loads.turn,
            secant: torque / loads.turn,
            tangent: loads.tangent,
            shares: Vec::with_capacity(self.lines.lines.len()),
            pressure: None,
            edge_share: 0.0,
            shear: None,
            coarse: 0.0,
            places: Vec::new(),
        };
        for (k, line) in self.lines.lines.iter().enumerate() {
            let mut share = 0.0;
            for (i, cell) in line.cells.iter().enumerate() {
                let (force, width) = (loads.forces[k][i], loads.widths[k][i]);
                if !(force > 0.0) {
                    continue;
                }
                let part = force * cell.arm / torque;
                share += part;
                let pressure = LoadedLines::pressure(cell, force, width);
                load.coarse = load.coarse.max(width / cell.length);
                load.places.push(LoadedPlace {
                    pair: line.pair,
                    at: self.ridges[k][i].places,
                    pressure,
                    width,
                    on_edge: cell.on_edge,
                });
                if cell.on_edge {
                    load.edge_share += part;
                } else if load.pressure.is_none_or(|most| pressure > most) {
                    load.pressure = Some(pressure);
                    load.shear = Some([SHEAR[0] * width, SHEAR[1] * pressure]);
                }
            }
            load.shares.push((line.pair, share));
        }
        load
    }
}
