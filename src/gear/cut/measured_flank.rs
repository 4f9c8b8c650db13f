//! Measured flank: nodes of a nominal flank with points and normals, and deviations along the normals.

use super::root_point::RootPoint;
use super::setting::FlankSetup;
use crate::gear::bevel::flank::BevelFlank;
use crate::gear::bevel::frames::WorkFrame;
use crate::gear::bevel::tooth_section::ToothSection;
use crate::gear::hand::Hand;
use crate::gear::kernel::pose::{Direction, Point};

/// Node of a nominal flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlankNode {
    /// Point, m.
    pub point: Point<WorkFrame>,
    /// Unit normal, out of the material.
    pub normal: Direction<WorkFrame>,
    /// Parameters `[s, θ, φ_c]` of the flank point, a start for neighbouring flanks.
    pub at: [f64; 3],
    /// Shares of face and height.
    pub shares: [f64; 2],
    /// Sign of D on the flank side of the undercut limit.
    pub side: f64,
}

/// Maximum distance of a node outside the section, in shares of face or height: blanks have machining allowances.
const MARGIN: f64 = 0.05;

impl FlankNode {
    /// Node of a flank at `[z, radius]` by Newton's method from `start`; `None` where the blade generates no flank there.
    pub fn of(flank: &BevelFlank, place: [f64; 2], start: [f64; 3]) -> Option<FlankNode> {
        let shares = flank.section.shares(place)?;
        if shares.iter().any(|x| !(-MARGIN..=1.0 + MARGIN).contains(x)) {
            return None;
        }
        let node = flank.tooth_point(place, start).filter(|p| !p.in_fillet)?;
        Some(FlankNode {
            point: node.point.point,
            normal: node.point.normal,
            at: node.point.at,
            shares,
            side: node.point.second_order.undercut.signum(),
        })
    }
}

/// Measured flank with the settings of its machine.
#[derive(Debug, Clone)]
pub struct MeasuredFlank {
    /// Cutter and machine settings of the cut.
    pub setup: FlankSetup,
    /// Hand of the work.
    pub hand: Hand,
    /// Axial section of the tooth.
    pub section: ToothSection,
    /// Nodes of the nominal flank.
    pub nodes: Vec<FlankNode>,
    /// Deviations along the normals of the nodes, m, positive for excess material.
    pub deviations: Vec<f64>,
    /// Root points whose height is a constraint on the settings; empty for a free slot depth.
    pub roots: Vec<RootPoint>,
}

/// Root mean square and maximum absolute value of deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviations {
    /// Number of existing nodes.
    pub nodes: usize,
    /// Root mean square, m.
    pub rms: f64,
    /// Maximum absolute value, m.
    pub largest: f64,
}

impl Deviations {
    /// Statistics over the nodes that exist, of deviations in m.
    pub fn of(values: &[Option<f64>]) -> Deviations {
        let existing = || values.iter().flatten();
        let nodes = existing().count();
        let squares: f64 = existing().map(|x| x * x).sum();
        Deviations {
            nodes,
            rms: (squares / nodes.max(1) as f64).sqrt(),
            largest: existing().fold(0.0, |largest, x| largest.max(x.abs())),
        }
    }
}
