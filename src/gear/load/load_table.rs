//! Load–deflection table of a mesh over its phase: δ(F, ψ) from deflections and compliances at several loads and positions.
//!
//! Between two loads δ is the cubic Hermite interpolant in F with the compliances `dδ/dF = 1/k_t` as slopes; below the first load
//! `δ = δ₁ (F/F₁)^p` with `p = F₁ δ₁'/δ₁`, which is 2/3 for Hertzian point contact and 1 for a linear spring; above the last load δ is
//! linear. Between positions deflections and compliances are linear in ψ. The secant stiffness is F/δ, the tangent stiffness dF/dδ. The
//! stored energy `V = F δ − ∫ δ dF` has the derivative ∂V/∂ψ at constant δ equal to `−∂/∂ψ ∫ δ dF` at constant F.

use super::flank_result::FlankMeshResult;
use crate::numeric::hermite_cubic::HermiteCubic;

/// Maximum ratio of compliance to chord slope for which the cubic is monotonic (Fritsch and Carlson, SIAM J. Numer. Anal. 17 (1980) 238).
const MAX_SLOPE_RATIO: f64 = 3.0;

/// Deflection and compliance at a load.
#[derive(Debug, Clone, Copy, PartialEq)]
struct LoadedNode {
    deflection: f64,
    compliance: f64,
}

impl LoadedNode {
    fn blend(self, other: LoadedNode, share: f64) -> LoadedNode {
        let mix = |a: f64, b: f64| a + share * (b - a);
        LoadedNode {
            deflection: mix(self.deflection, other.deflection),
            compliance: mix(self.compliance, other.compliance),
        }
    }

    fn minus(self, other: LoadedNode) -> LoadedNode {
        LoadedNode {
            deflection: self.deflection - other.deflection,
            compliance: self.compliance - other.compliance,
        }
    }
}

/// Deflections of a mesh over load and phase, in consistent units.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadTable {
    /// Positive loads in ascending order.
    loads: Vec<f64>,
    /// Nodes by position over a pitch, each by load.
    positions: Vec<Vec<LoadedNode>>,
}

/// Load–deflection curve at one phase.
#[derive(Debug, Clone, Copy)]
pub struct LoadCurve<'t> {
    loads: &'t [f64],
    /// Nodes at the positions before and after the phase.
    ends: [&'t [LoadedNode]; 2],
    /// Interpolation parameter between both positions, 0 to 1.
    share: f64,
}

/// Load and tangent stiffness at a deflection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadPoint {
    /// Load F.
    pub load: f64,
    /// Tangent stiffness dF/dδ.
    pub tangent: f64,
}

/// Interpolation errors of a table between its loads: maximum differences at every second load, interpolated from the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadInterpolation {
    /// Error of the deflection.
    pub deflection: f64,
    /// Relative error of the secant stiffness.
    pub secant: f64,
    /// Relative error of the tangent stiffness, averaged over the positions, since it jumps where edges or teeth become loaded.
    pub tangent: f64,
}

impl LoadTable {
    /// Table of ascending loads; `positions`: `[deflection, compliance]` by position, each by load.
    pub fn new(loads: Vec<f64>, positions: Vec<Vec<[f64; 2]>>) -> LoadTable {
        let position_nodes = |values: Vec<[f64; 2]>| {
            // Chord slope from zero to the first load, then between neighbouring loads.
            let chord = |k: usize| {
                let (f, d) = match k {
                    0 => (0.0, 0.0),
                    _ => (loads[k - 1], values[k - 1][0]),
                };
                (values[k][0] - d) / (loads[k] - f)
            };
            let node = |k: usize| {
                let left = if k == 0 {
                    chord(0)
                } else {
                    MAX_SLOPE_RATIO * chord(k)
                };
                let right = (k + 1 < loads.len()).then(|| MAX_SLOPE_RATIO * chord(k + 1));
                LoadedNode {
                    deflection: values[k][0],
                    compliance: values[k][1].min(left).min(right.unwrap_or(left)),
                }
            };
            (0..loads.len()).map(node).collect()
        };
        LoadTable {
            positions: positions.into_iter().map(position_nodes).collect(),
            loads,
        }
    }

    /// Table of gear torque, N·m, over gear rotation from the unloaded flanks, rad; `None` for fewer than two torques.
    pub fn of(mesh: &FlankMeshResult) -> Option<LoadTable> {
        let unloaded = &mesh.unloaded_te;
        let first = (mesh.cycles.iter()).map(|c| {
            let load = &c.positions[0];
            load.secant * (unloaded[0] - load.te)
        });
        let position = |i: usize| {
            let nodes = mesh.cycles.iter().map(|c| {
                let load = &c.positions[i];
                [unloaded[i] - load.te, load.tangent.recip()]
            });
            nodes.collect()
        };
        (mesh.cycles.len() > 1)
            .then(|| LoadTable::new(first.collect(), (0..unloaded.len()).map(position).collect()))
    }

    /// Table with loads and deflections multiplied by factors.
    pub fn scaled(&self, load: f64, deflection: f64) -> LoadTable {
        let node = |n: &LoadedNode| LoadedNode {
            deflection: deflection * n.deflection,
            compliance: deflection / load * n.compliance,
        };
        let positions = self.positions.iter();
        LoadTable {
            loads: self.loads.iter().map(|f| load * f).collect(),
            positions: positions.map(|p| p.iter().map(node).collect()).collect(),
        }
    }

    /// Table over the reversed phase.
    pub fn reversed(&self) -> LoadTable {
        let n = self.positions.len();
        LoadTable {
            loads: self.loads.clone(),
            positions: (0..n)
                .map(|i| self.positions[(n - i) % n].clone())
                .collect(),
        }
    }

    /// Loads in ascending order.
    pub fn loads(&self) -> &[f64] {
        &self.loads
    }

    /// Number of positions in a pitch.
    pub fn position_count(&self) -> usize {
        self.positions.len()
    }

    /// Load–deflection curve between a position and the next; `share`: interpolation parameter, 0 to 1.
    pub fn curve(&self, position: usize, share: f64) -> LoadCurve<'_> {
        let next = (position + 1) % self.positions.len();
        LoadCurve {
            loads: &self.loads,
            ends: [&self.positions[position], &self.positions[next]],
            share,
        }
    }

    /// Maximum tangent stiffness over all loads and positions of the table.
    pub fn max_tangent_stiffness(&self) -> f64 {
        let nodes = self.positions.iter().flatten();
        nodes.fold(0.0, |max, node| max.max(node.compliance.recip()))
    }

    /// Interpolation errors between the loads, at every second load from the last but one down.
    pub fn interpolation(&self) -> LoadInterpolation {
        let n = self.loads.len();
        let is_coarse = |k: &usize| (n - 1 - k).is_multiple_of(2);
        let coarse_loads: Vec<usize> = (0..n).filter(is_coarse).collect();
        let thinned = |nodes: &Vec<LoadedNode>| coarse_loads.iter().map(|k| nodes[*k]).collect();
        let coarse = LoadTable {
            loads: coarse_loads.iter().map(|k| self.loads[*k]).collect(),
            positions: self.positions.iter().map(thinned).collect(),
        };
        let mut errors = LoadInterpolation {
            deflection: 0.0,
            secant: 0.0,
            tangent: 0.0,
        };
        for k in (0..n).filter(|k| !is_coarse(k)) {
            let mut tangents = 0.0;
            for (i, nodes) in self.positions.iter().enumerate() {
                let [deflection, compliance] = coarse.curve(i, 0.0).at_load(self.loads[k]);
                let error = (deflection - nodes[k].deflection).abs();
                errors.deflection = errors.deflection.max(error);
                errors.secant = errors.secant.max(error / deflection);
                tangents += (nodes[k].compliance / compliance - 1.0).abs();
            }
            errors.tangent = errors.tangent.max(tangents / self.positions.len() as f64);
        }
        errors
    }
}

impl LoadCurve<'_> {
    fn node(&self, load: usize) -> LoadedNode {
        self.ends[0][load].blend(self.ends[1][load], self.share)
    }

    /// Derivative of a node with respect to the interpolation parameter: difference between both positions.
    fn node_slope(&self, load: usize) -> LoadedNode {
        self.ends[1][load].minus(self.ends[0][load])
    }

    /// Exponent p of the power law below the first load.
    fn exponent(&self, first: LoadedNode) -> f64 {
        first.compliance * self.loads[0] / first.deflection
    }

    /// Cubic Hermite interpolant between a load and the next.
    fn cubic(&self, load: usize, node: impl Fn(usize) -> LoadedNode) -> HermiteCubic {
        let (a, b) = (node(load), node(load + 1));
        HermiteCubic {
            ends: [
                (self.loads[load], a.deflection),
                (self.loads[load + 1], b.deflection),
            ],
            slopes: [a.compliance, b.compliance],
        }
    }

    /// Deflection and compliance at a positive load.
    pub fn at_load(&self, load: f64) -> [f64; 2] {
        let last = self.loads.len() - 1;
        match self.loads.partition_point(|f| *f <= load) {
            0 => {
                let first = self.node(0);
                let p = self.exponent(first);
                let deflection = first.deflection * (load / self.loads[0]).powf(p);
                [deflection, p * deflection / load]
            }
            n if n > last => {
                let node = self.node(last);
                let beyond = load - self.loads[last];
                [node.deflection + node.compliance * beyond, node.compliance]
            }
            n => {
                let cubic = self.cubic(n - 1, |k| self.node(k));
                [cubic.value(load), cubic.slope(load)]
            }
        }
    }

    /// Load and tangent stiffness at a deflection; the law is odd.
    pub fn at_deflection(&self, deflection: f64) -> LoadPoint {
        let size = deflection.abs();
        let last = self.loads.len() - 1;
        let (load, tangent) = match self.interval_of(size) {
            0 => {
                let (first, first_load) = (self.node(0), self.loads[0]);
                let q = self.exponent(first).recip();
                let x = size / first.deflection;
                (
                    first_load * x.powf(q),
                    first_load / first.deflection * q * x.powf(q - 1.0),
                )
            }
            n if n > last => {
                let node = self.node(last);
                let load = self.loads[last] + (size - node.deflection) / node.compliance;
                (load, node.compliance.recip())
            }
            n => {
                let cubic = self.cubic(n - 1, |k| self.node(k));
                let load = cubic.solve(size);
                (load, cubic.slope(load).recip())
            }
        };
        LoadPoint {
            load: load.copysign(deflection),
            tangent,
        }
    }

    /// Stored energy V at a deflection, and its derivative with respect to the interpolation parameter at constant deflection.
    pub fn energy(&self, deflection: f64) -> [f64; 2] {
        let size = deflection.abs();
        let load = self.at_deflection(size).load;
        let [area, area_slope] = self.areas(load, self.interval_of(size));
        [load * size - area, -area_slope]
    }

    /// Number of loads of the table with deflections up to a positive deflection.
    fn interval_of(&self, size: f64) -> usize {
        let nodes = 0..self.loads.len();
        nodes
            .take_while(|k| self.node(*k).deflection <= size)
            .count()
    }

    /// Integral `∫ δ dF` from zero to a load above `count` loads of the table, and its derivative over the interpolation parameter.
    fn areas(&self, load: f64, count: usize) -> [f64; 2] {
        let mut sum = self.first_areas(load.min(self.loads[0]));
        let last = self.loads.len() - 1;
        for k in 0..count.min(last) {
            let to = load.min(self.loads[k + 1]);
            sum[0] += self.cubic(k, |k| self.node(k)).area(to);
            sum[1] += self.cubic(k, |k| self.node_slope(k)).area(to);
        }
        if count > last {
            let beyond = load - self.loads[last];
            let triangle = |n: LoadedNode| beyond * (n.deflection + 0.5 * beyond * n.compliance);
            sum[0] += triangle(self.node(last));
            sum[1] += triangle(self.node_slope(last));
        }
        sum
    }

    /// Integral and derivative as in `areas` below the first load: `δ₁ F₁ x^(p+1)/(p+1)`, `x = F/F₁`.
    fn first_areas(&self, load: f64) -> [f64; 2] {
        if load <= 0.0 {
            return [0.0; 2];
        }
        let (first, slope, first_load) = (self.node(0), self.node_slope(0), self.loads[0]);
        let p = self.exponent(first);
        let p_slope = (first_load * slope.compliance - p * slope.deflection) / first.deflection;
        let x = load / first_load;
        let size = first_load * x.powf(p + 1.0) / (p + 1.0);
        let by_exponent = p_slope * (x.ln() - 1.0 / (p + 1.0));
        [
            size * first.deflection,
            size * (slope.deflection + first.deflection * by_exponent),
        ]
    }
}
