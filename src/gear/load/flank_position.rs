//! Flanks in space at one angle: their contact lines, and the results of a load on them.

use super::contact_line::{ContactLine, ToothLoad};
use super::elliptic_contact::greatest_shear;
use super::flank_result::{FlankLoad, LoadedCell};
use super::loaded_lines::{LineLoads, LoadedLines};
use super::tooth_plate::RootMoment;
use crate::gear::contact::ridge::RidgePoint;

/// The contact line has a kink where it runs onto an edge, at which the pressure has no bound: strips nearer to an edge that carries than so
/// many lengths of theirs, or half widths, do not tell the pressure within the flanks.
const EDGE_STRIPS: f64 = 2.5;
const EDGE_WIDTHS: f64 = 4.0;

/// Teeth that bend under a force at a place of their section.
pub trait ToothBending: Sync {
    /// The load on the tooth of a member under a unit force along the normal at `[z, radius]`.
    fn at(&self, member: usize, place: [f64; 2]) -> Option<ToothLoad>;

    /// Moment in the root line of a member's tooth under the sum of its shape functions, each times its force, N.
    fn root_moment(&self, member: usize, loading: &[f64]) -> RootMoment;
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
    /// Distance of each line's ellipse from the nearer end of its ridge, m; none of strips.
    pub(super) reaches: Vec<Option<f64>>,
}

impl FlankPosition {
    /// Results of a load at this position; `torque` is that of the gear, N·m.
    pub(super) fn load(
        &self,
        loads: &LineLoads,
        torque: f64,
        teeth: Option<&dyn ToothBending>,
    ) -> FlankLoad {
        let mut load = FlankLoad {
            te: self.unloaded_te - loads.turn,
            secant: torque / loads.turn,
            tangent: loads.tangent,
            shares: Vec::with_capacity(self.lines.lines.len()),
            pressure: None,
            edge_share: 0.0,
            shear: None,
            cell_width_ratio: 0.0,
            ellipses: 0,
            overhang: 0.0,
            root_moments: Vec::with_capacity(self.lines.lines.len()),
            places: Vec::new(),
        };
        for (k, line) in self.lines.lines.iter().enumerate() {
            let mut share = 0.0;
            let carries = |i: &usize| line.cells[*i].on_edge && loads.forces[k][*i] > 0.0;
            let edges: Vec<f64> = (0..line.cells.len())
                .filter(carries)
                .map(|i| line.cells[i].along)
                .collect();
            for (i, cell) in line.cells.iter().enumerate() {
                let (force, width) = (loads.forces[k][i], loads.widths[k][i]);
                if !(force > 0.0) {
                    continue;
                }
                let part = force * cell.arm / torque;
                share += part;
                let pressure = LoadedLines::pressure(cell, force, width);
                let aspect = cell.ellipse.map(|ellipse| ellipse.aspect());
                match (aspect, self.reaches[k]) {
                    (Some(aspect), Some(reach)) => {
                        load.ellipses += 1;
                        load.overhang = load.overhang.max(aspect * width / reach);
                    }
                    _ => load.cell_width_ratio = load.cell_width_ratio.max(width / cell.length),
                }
                load.places.push(LoadedCell {
                    pair: line.pair,
                    at: self.ridges[k][i].places,
                    face: self.ridges[k][i].face,
                    force,
                    line_load: 0.5 * std::f64::consts::PI * width * pressure,
                    pressure,
                    width,
                    on_edge: cell.on_edge,
                });
                let reach = f64::max(EDGE_STRIPS * cell.length, EDGE_WIDTHS * width);
                let is_near_edge = edges.iter().any(|edge| (cell.along - edge).abs() < reach);
                if cell.on_edge {
                    load.edge_share += part;
                } else if !is_near_edge && load.pressure.is_none_or(|most| pressure > most) {
                    load.pressure = Some(pressure);
                    let [depth, size] = greatest_shear(aspect.map_or(0.0, f64::recip));
                    load.shear = Some([depth * width, size * pressure]);
                }
            }
            load.shares.push((line.pair, share));
            let moments = teeth.and_then(|teeth| root_moments(teeth, line, &loads.forces[k]));
            load.root_moments.extend(moments.map(|m| (line.pair, m)));
        }
        load
    }
}

/// Moments in the root lines of both teeth of a line under its forces; none where teeth are rigid there.
fn root_moments(
    teeth: &dyn ToothBending,
    line: &ContactLine,
    forces: &[f64],
) -> Option<[RootMoment; 2]> {
    let member = |k: usize| {
        let mut loading: Vec<f64> = Vec::new();
        for (cell, force) in line.cells.iter().zip(forces) {
            let shape = &cell.teeth.as_ref()?[k].shape;
            loading.resize(shape.len(), 0.0);
            let sums = loading.iter_mut().zip(shape);
            sums.for_each(|(sum, value)| *sum += force * value);
        }
        Some(teeth.root_moment(k, &loading))
    };
    Some([member(0)?, member(1)?])
}
