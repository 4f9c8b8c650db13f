//! Results of a mesh over one pitch: transmission error, stiffness, shares and pressure by position and torque; one pair as a spring.

use crate::base::error::Diagnostic;
use crate::numeric::statistics::peak_to_peak;

/// The mesh over one pitch at one torque.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadedCycle {
    /// Torque at the pinion, N·m.
    pub torque: f64,
    /// Transmission error e along the base tangent, by position, m.
    pub te: Vec<f64>,
    /// Secant stiffness between no load and this one, by position, N/m.
    pub secant: Vec<f64>,
    /// Tangent stiffness, by position, N/m.
    pub tangent: Vec<f64>,
    /// Share of the load of each pair, by position and pair.
    pub shares: Vec<Vec<f64>>,
    /// Greatest Hertzian pressure away from corners, by position, Pa; `None` where corners carry all.
    pub pressure: Vec<Option<f64>>,
    /// Share of the load on tip corners, whose pressure has no bound, by position.
    pub corner_share: Vec<f64>,
}

/// One tooth pair over all pitches in which it can touch, as a one-sided spring that carries its share at one torque.
#[derive(Debug, Clone, PartialEq)]
pub struct PairCurve {
    /// Pinion angles from contact at the pitch point, rad, ascending; other pairs are whole pitches apart.
    pub angles: Vec<f64>,
    /// Stiffness, N/m; 0 where the pair is out of reach.
    pub stiffness: Vec<f64>,
    /// Approach at which the pair touches, m; infinite where it is out of reach.
    pub gap: Vec<f64>,
}

/// Loaded transmission error over one pitch.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshResult {
    /// Name of the method.
    pub method: &'static str,
    /// Body models.
    pub bodies: [&'static str; 2],
    /// Base radius of the driven gear, m: transmission error over it is an angle.
    pub driven_base_radius: f64,
    /// Pinion angles, rad.
    pub pinion_angles: Vec<f64>,
    /// Numbers of the tooth pairs: pair 0 touches at the pitch point at angle 0, higher numbers are ahead.
    pub pairs: Vec<i32>,
    /// Transmission error without load, by position, m.
    pub unloaded_te: Vec<f64>,
    /// The pitch at each torque.
    pub cycles: Vec<LoadedCycle>,
    /// Warnings on the ranges of the method.
    pub warnings: Vec<Diagnostic>,
}

impl LoadedCycle {
    pub(super) fn new(torque: f64, count: usize) -> LoadedCycle {
        LoadedCycle {
            torque,
            te: Vec::with_capacity(count),
            secant: Vec::with_capacity(count),
            tangent: Vec::with_capacity(count),
            shares: Vec::with_capacity(count),
            pressure: Vec::with_capacity(count),
            corner_share: Vec::with_capacity(count),
        }
    }

    /// Peak-to-peak transmission error over the pitch, m.
    pub fn peak_to_peak(&self) -> f64 {
        peak_to_peak(&self.te)
    }
}
