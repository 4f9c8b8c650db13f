//! Whirl direction of a mode: sign of `Im(x̄ y)` at each node, weighted by kinetic energy.
//!
//! Displacements `x`, `y` and tilts `rx`, `ry` go round with the spin where `Im(x̄ y) < 0`: x = cos ωt, y = sin ωt.

use crate::machine::components::Machine;
use crate::numeric::Complex;
use crate::scene::model::Axis;

/// Sense of the orbits of a mode, relative to the spin of each node (of the reference for nodes that do not turn).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Whirl {
    /// All with the spin.
    Forward,
    /// All against it.
    Backward,
    /// Some nodes with it, some against.
    Mixed,
    /// Nodes move to and fro on lines.
    Planar,
}

impl Whirl {
    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            Whirl::Forward => "forward",
            Whirl::Backward => "backward",
            Whirl::Mixed => "mixed",
            Whirl::Planar => "planar",
        }
    }
}

/// Translations or tilts of a node along two axes across its shaft.
struct LateralAxes {
    x: usize,
    y: usize,
    mass: [f64; 2],
    turning: Option<usize>,
}

/// Nodes of a machine that can whirl: all that move across their axis but planets, whose places turn with the carrier.
pub struct WhirlNodes {
    pairs: Vec<LateralAxes>,
    mass: Vec<f64>,
}

/// Share of the kinetic energy across shafts below which a mode counts as torsional: a hundredth moves a bearing no more than a tenth of
/// what a whirl of the same energy does.
const MIN_LATERAL_SHARE: f64 = 1e-2;
/// Share of the orbits' area that may go the other way, or be flat, before a mode counts as mixed, or planar.
const MIXED_ORBIT_SHARE: f64 = 1e-3;

impl WhirlNodes {
    /// Finds the nodes that can whirl.
    pub fn new(machine: &Machine) -> WhirlNodes {
        let mass = mass_diagonal(machine);
        let mut pairs = Vec::new();
        for (node, made) in machine.nodes.iter().enumerate() {
            if machine.elements[made.element].kind == "planetary" {
                continue;
            }
            let dof = |axis| {
                machine
                    .dofs
                    .iter()
                    .position(|f| f.node == node && f.axis == axis)
            };
            for (x, y) in [(Axis::X, Axis::Y), (Axis::TiltX, Axis::TiltY)] {
                if let (Some(x), Some(y)) = (dof(x), dof(y)) {
                    pairs.push(LateralAxes {
                        x,
                        y,
                        mass: [mass[x], mass[y]],
                        turning: dof(Axis::Theta),
                    });
                }
            }
        }
        WhirlNodes { pairs, mass }
    }

    /// Whirl direction of a mode at the mean speeds given; `spin` are those at a positive speed of the reference, for zero speed
    /// everywhere. Nothing where it does not move across any shaft.
    pub fn whirl(
        &self,
        shape: &[Complex],
        speeds: &[f64],
        spin: &[f64],
        reference: usize,
    ) -> Option<Whirl> {
        let kinetic: f64 = self
            .mass
            .iter()
            .zip(shape)
            .map(|(m, q)| m * q.norm_sqr())
            .sum();
        let (mut with, mut against, mut across) = (0.0, 0.0, 0.0);
        for pair in &self.pairs {
            let (x, y) = (shape[pair.x], shape[pair.y]);
            let sense = |i: usize| if speeds[i] != 0.0 { speeds[i] } else { spin[i] };
            let turning = pair.turning.map_or(0.0, sense);
            let sense = if turning != 0.0 {
                turning
            } else {
                sense(reference)
            };
            let area =
                -2.0 * (pair.mass[0] * pair.mass[1]).sqrt() * (x.conj() * y).im * sense.signum();
            with += area.max(0.0);
            against += (-area).max(0.0);
            across += pair.mass[0] * x.norm_sqr() + pair.mass[1] * y.norm_sqr();
        }
        if across.is_nan() || across <= MIN_LATERAL_SHARE * kinetic {
            return None;
        }
        let round = with + against;
        Some(match () {
            () if round <= MIXED_ORBIT_SHARE * across => Whirl::Planar,
            () if against <= MIXED_ORBIT_SHARE * round => Whirl::Forward,
            () if with <= MIXED_ORBIT_SHARE * round => Whirl::Backward,
            () => Whirl::Mixed,
        })
    }
}

/// The diagonal of the mass matrix over all degrees of freedom.
pub fn mass_diagonal(machine: &Machine) -> Vec<f64> {
    let mut diagonal = vec![0.0; machine.dofs.len()];
    for mass in &machine.masses {
        mass.direction
            .entries()
            .for_each(|(i, a)| diagonal[i] += mass.value * a * a);
    }
    diagonal
}
