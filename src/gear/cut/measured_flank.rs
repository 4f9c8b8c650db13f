//! Nodes of a flank with their deviations: points and normals of a nominal flank, and how far another flank lies beyond them.

use super::root_point::RootPoint;
use super::setting::FlankSetup;
use crate::gear::bevel::flank::BevelFlank;
use crate::gear::bevel::frames::WorkFrame;
use crate::gear::bevel::tooth_section::ToothSection;
use crate::gear::hand::Hand;
use crate::gear::kernel::pose::{Direction, Point};

/// A node of a nominal flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlankNode {
    /// Point, m.
    pub point: Point<WorkFrame>,
    /// Unit normal out of the metal.
    pub normal: Direction<WorkFrame>,
    /// Parameters `[s, θ, φ_c]` of a flank near it.
    pub at: [f64; 3],
    /// Shares of face and height.
    pub shares: [f64; 2],
    /// Sign of D on the side of the undercut limit that is the flank.
    pub side: f64,
}

/// Share of face or height by which a node may lie beyond the section: blanks are turned with allowances.
const BEYOND: f64 = 0.05;

impl FlankNode {
    /// The node of a flank at `[z, radius]`, sought from parameters near it; none where the cutter's blade leaves no flank there.
    pub fn of(flank: &BevelFlank, place: [f64; 2], near: [f64; 3]) -> Option<FlankNode> {
        let shares = flank.section.shares(place)?;
        if shares.iter().any(|x| !(-BEYOND..=1.0 + BEYOND).contains(x)) {
            return None;
        }
        let found = flank.tooth_point(place, near).filter(|p| !p.in_fillet)?;
        Some(FlankNode {
            point: found.point.point,
            normal: found.point.normal,
            at: found.point.at,
            shares,
            side: found.point.second_order.undercut.signum(),
        })
    }
}

/// A measured flank.
#[derive(Debug, Clone)]
pub struct MeasuredFlank {
    /// Cutter and machine as they were set.
    pub setup: FlankSetup,
    /// Hand of the work.
    pub hand: Hand,
    /// Axial section of its tooth.
    pub section: ToothSection,
    /// Nodes.
    pub nodes: Vec<FlankNode>,
    /// Deviations along the nodes' normals, m: positive where metal is left beyond the node.
    pub deviations: Vec<f64>,
    /// Points of the root whose height the settings keep; empty where the depth of the slot is free.
    pub roots: Vec<RootPoint>,
}

/// Root mean square and largest size of deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviations {
    /// Number of nodes.
    pub nodes: usize,
    /// Root mean square, m.
    pub rms: f64,
    /// Largest size, m.
    pub largest: f64,
}

impl Deviations {
    /// Those of nodes that exist.
    pub fn of(values: &[Option<f64>]) -> Deviations {
        let all = || values.iter().flatten();
        let nodes = all().count();
        let squares: f64 = all().map(|x| x * x).sum();
        Deviations {
            nodes,
            rms: (squares / nodes.max(1) as f64).sqrt(),
            largest: all().fold(0.0, |most, x| most.max(x.abs())),
        }
    }
}
