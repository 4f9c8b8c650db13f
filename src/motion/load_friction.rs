//! Load-dependent dry friction with capacity `C = C₀ + μ l N`, l the lever of the contact point.
//!
//! Teeth at s from the pitch point push the gears against each other by `μ |N| Σ|s|` along `θ₁ − θ₂` and by `μ |N| Σ sign s` along
//! what sliding at the pitch point would be, both against the sense of `θ̇₁ − θ̇₂`.

use std::f64::consts::TAU;

use super::friction::FrictionLaw;
use super::wave::WavePhase;
use crate::gear::cylindrical::path_of_contact::{LoadLever, MeshCycleSegment};
use crate::machine::direction::Direction;

/// Friction pressed by forces of branches.
#[derive(Debug, Clone)]
pub struct LoadFriction {
    /// For a capacity of one.
    pub friction: FrictionLaw,
    /// C₀, N or N·m.
    pub constant: f64,
    /// μ l; of teeth μ alone.
    pub coefficient: f64,
    /// Components of N: forces of branches, so much of each.
    pub force_components: Vec<Vec<(usize, f64)>>,
    /// Friction levers over the path of contact, for teeth.
    pub path: Option<FrictionLevers>,
}

/// Friction levers where teeth touch.
#[derive(Debug, Clone)]
pub struct FrictionLevers {
    /// Sliding direction at the pitch point, on drive flanks and on coast flanks.
    pub pitch_point_sliding: [Direction; 2],
    /// Levers over the mesh cycle.
    pub pieces: Vec<MeshCycleSegment>,
    /// Phase of the mesh cycle; absent: levers are the same always.
    pub phase: Option<WavePhase>,
}

impl FrictionLevers {
    /// Which piece of the cycle holds ψ.
    pub fn piece(&self, psi: f64) -> usize {
        let psi = psi.rem_euclid(1.0);
        self.pieces.partition_point(|p| p.from <= psi).max(1) - 1
    }

    /// Edge of a piece in the cycle (beginning or end).
    pub fn edge(&self, at: usize) -> f64 {
        self.pieces.get(at).map_or(1.0, |p| p.from)
    }

    /// The levers at ψ with the piece `piece` carried on beyond its ends: of the load from the pitch point, m, and its balance.
    pub fn levers(&self, psi: f64, piece: usize, coasts: bool) -> (f64, f64) {
        let MeshCycleSegment { from, flanks } = &self.pieces[piece];
        let LoadLever {
            distance,
            slope,
            balance,
        } = flanks[usize::from(coasts)];
        let into = match self.phase {
            Some(_) => psi - from - (psi - 0.5 * (from + self.edge(piece + 1))).round(),
            None => 0.0,
        };
        (distance + slope * into, balance)
    }

    /// The next instant at which a piece ends, where time carries the cycle on, s.
    pub fn next_edge(&self, t: f64) -> f64 {
        let Some(WavePhase::Imposed { omega, start }) = self.phase else {
            return f64::INFINITY;
        };
        if omega == 0.0 {
            return f64::INFINITY;
        }
        let psi = (omega * t + start) / TAU;
        let whole = psi.floor();
        let edges = (-1..=2).flat_map(|turn| {
            let turn = whole + f64::from(turn);
            self.pieces.iter().map(move |p| turn + p.from)
        });
        // The instant of an edge and the edge at an instant differ by rounding.
        let near = 16.0 * f64::EPSILON * t.abs();
        edges
            .map(|edge| (edge * TAU - start) / omega)
            .filter(|&at| at > t + near)
            .fold(f64::INFINITY, f64::min)
    }
}

impl LoadFriction {
    /// In fewer coordinates and branches: what becomes of directions, of phases and of the numbers of branches.
    ///
    /// # Errors
    /// The number of a branch that presses it and is no more.
    pub fn with_coordinates(
        &self,
        direction: impl Fn(&Direction) -> Direction,
        phase: impl Fn(&WavePhase) -> WavePhase,
        numbers: &[Option<usize>],
    ) -> Result<LoadFriction, usize> {
        let renumbered = |&(at, share): &(usize, f64)| Ok((numbers[at].ok_or(at)?, share));
        let component = |forces: &Vec<(usize, f64)>| forces.iter().map(renumbered).collect();
        let path = self.path.as_ref().map(|path| FrictionLevers {
            pitch_point_sliding: [
                direction(&path.pitch_point_sliding[0]),
                direction(&path.pitch_point_sliding[1]),
            ],
            pieces: path.pieces.clone(),
            phase: path.phase.as_ref().map(phase),
        });
        Ok(LoadFriction {
            force_components: self
                .force_components
                .iter()
                .map(component)
                .collect::<Result<_, usize>>()?,
            path,
            ..self.clone()
        })
    }

    /// Everything it acts along next to its branch.
    pub fn directions(&self) -> impl Iterator<Item = &Direction> {
        self.path.iter().flat_map(|path| {
            let angle = path.phase.as_ref().and_then(WavePhase::angle);
            path.pitch_point_sliding.iter().chain(angle)
        })
    }
}
