//! Load over deflection of a mesh through its phase: δ(F, ψ) by the deflections and compliances of several loads at every position.
//!
//! Between two loads δ is the cubic of F with the deflections and the compliances `dδ/dF = 1/k_t` of both; below the first load
//! `δ = δ₁ (F/F₁)^p` with `p = F₁ δ₁'/δ₁`, which is 2/3 of Hertz's contact at a point and 1 of a spring; above the last load the tangent goes
//! on. Between positions deflections and compliances are linear in ψ. The secant stiffness is F/δ, the tangent stiffness dF/dδ. A mesh that
//! stores `V = F δ − ∫ δ dF` has `∂V/∂ψ = −∂/∂ψ ∫ δ dF` at constant F.

use super::flank_result::FlankMeshResult;
use crate::numeric::hermite_cubic::HermiteCubic;

/// Largest compliance over the slope of a chord with which a cubic rises everywhere (Fritsch and Carlson, SIAM J. Numer. Anal. 17 (1980)
/// 238).
const STEEPEST: f64 = 3.0;

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

/// Deflections of a mesh over load and phase, in one set of units.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadTable {
    /// Rising, above zero.
    loads: Vec<f64>,
    /// Position by position over a pitch, load by load.
    positions: Vec<Vec<LoadedNode>>,
}

/// Load over deflection at one phase.
#[derive(Debug, Clone, Copy)]
pub struct LoadCurve<'t> {
    loads: &'t [f64],
    /// At the positions before and after.
    ends: [&'t [LoadedNode]; 2],
    /// Way from one to the other.
    share: f64,
}

/// A mesh at a deflection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadPoint {
    /// F.
    pub load: f64,
    /// dF/dδ.
    pub tangent: f64,
}

/// Errors of a table between its loads: largest differences to every second load, left out and interpolated from the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadInterpolation {
    /// Error of the deflection.
    pub deflection: f64,
    /// Relative error of the secant stiffness.
    pub secant: f64,
    /// Relative error of the tangent stiffness, its mean over the positions: at single ones it jumps where edges or teeth begin to carry.
    pub tangent: f64,
}

impl LoadTable {
    /// A table of rising loads; `positions` holds deflection and compliance at every load.
    pub fn new(loads: Vec<f64>, positions: Vec<Vec<[f64; 2]>>) -> LoadTable {
        let of_position = |values: Vec<[f64; 2]>| {
            // The chord from rest to the first load, then from load to load; none begins at the last.
            let chord = |k: usize| {
                let (f, d) = match k {
                    0 => (0.0, 0.0),
                    _ => (loads[k - 1], values[k - 1][0]),
                };
                (values[k][0] - d) / (loads[k] - f)
            };
            let node = |k: usize| {
                let before = if k == 0 {
                    chord(0)
                } else {
                    STEEPEST * chord(k)
                };
                let after = (k + 1 < loads.len()).then(|| STEEPEST * chord(k + 1));
                LoadedNode {
                    deflection: values[k][0],
                    compliance: values[k][1].min(before).min(after.unwrap_or(before)),
                }
            };
            (0..loads.len()).map(node).collect()
        };
        LoadTable {
            positions: positions.into_iter().map(of_position).collect(),
            loads,
        }
    }

    /// Torque at the gear, N·m, over its turn from the unloaded flanks, rad; none of fewer than two torques.
    pub fn of(mesh: &FlankMeshResult) -> Option<LoadTable> {
        let unloaded = &mesh.unloaded_te;
        let first = (mesh.cycles.iter()).map(|c| {
            let load = &c.positions[0];
            load.secant * (unloaded[0] - load.te)
        });
        let position = |i: usize| {
            let of_load = mesh.cycles.iter().map(|c| {
                let load = &c.positions[i];
                [unloaded[i] - load.te, load.tangent.recip()]
            });
            of_load.collect()
        };
        (mesh.cycles.len() > 1)
            .then(|| LoadTable::new(first.collect(), (0..unloaded.len()).map(position).collect()))
    }

    /// The same with loads and deflections in other units.
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

    /// The same over the phase run backward.
    pub fn reversed(&self) -> LoadTable {
        let n = self.positions.len();
        LoadTable {
            loads: self.loads.clone(),
            positions: (0..n)
                .map(|i| self.positions[(n - i) % n].clone())
                .collect(),
        }
    }

    /// The loads.
    pub fn loads(&self) -> &[f64] {
        &self.loads
    }

    /// Positions in a pitch.
    pub fn position_count(&self) -> usize {
        self.positions.len()
    }

    /// The curve between a position and the next one.
    pub fn curve(&self, position: usize, share: f64) -> LoadCurve<'_> {
        let next = (position + 1) % self.positions.len();
        LoadCurve {
            loads: &self.loads,
            ends: [&self.positions[position], &self.positions[next]],
            share,
        }
    }

    /// The greatest tangent stiffness at a load of the table.
    pub fn greatest_tangent(&self) -> f64 {
        let nodes = self.positions.iter().flatten();
        nodes.fold(0.0, |most, node| most.max(node.compliance.recip()))
    }

    /// Errors between the loads; every second load is counted from the largest.
    pub fn interpolation(&self) -> LoadInterpolation {
        let n = self.loads.len();
        let is_kept = |k: &usize| (n - 1 - k).is_multiple_of(2);
        let kept: Vec<usize> = (0..n).filter(is_kept).collect();
        let thinned = |nodes: &Vec<LoadedNode>| kept.iter().map(|k| nodes[*k]).collect();
        let coarse = LoadTable {
            loads: kept.iter().map(|k| self.loads[*k]).collect(),
            positions: self.positions.iter().map(thinned).collect(),
        };
        let mut most = LoadInterpolation {
            deflection: 0.0,
            secant: 0.0,
            tangent: 0.0,
        };
        for k in (0..n).filter(|k| !is_kept(k)) {
            let mut tangents = 0.0;
            for (i, nodes) in self.positions.iter().enumerate() {
                let [deflection, compliance] = coarse.curve(i, 0.0).at_load(self.loads[k]);
                let off = (deflection - nodes[k].deflection).abs();
                most.deflection = most.deflection.max(off);
                most.secant = most.secant.max(off / deflection);
                tangents += (nodes[k].compliance / compliance - 1.0).abs();
            }
            most.tangent = most.tangent.max(tangents / self.positions.len() as f64);
        }
        most
    }
}

impl LoadCurve<'_> {
    fn node(&self, load: usize) -> LoadedNode {
        self.ends[0][load].blend(self.ends[1][load], self.share)
    }

    /// Change of a node from one position to the next.
    fn node_slope(&self, load: usize) -> LoadedNode {
        self.ends[1][load].minus(self.ends[0][load])
    }

    /// p of the first piece.
    fn exponent(&self, first: LoadedNode) -> f64 {
        first.compliance * self.loads[0] / first.deflection
    }

    /// The cubic after a load.
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

    /// Deflection and compliance at a load above zero.
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

    /// The mesh at a deflection; the law is odd.
    pub fn at_deflection(&self, deflection: f64) -> LoadPoint {
        let size = deflection.abs();
        let last = self.loads.len() - 1;
        let (load, tangent) = match self.passed(size) {
            0 => {
                let (first, most) = (self.node(0), self.loads[0]);
                let q = self.exponent(first).recip();
                let x = size / first.deflection;
                (
                    most * x.powf(q),
                    most / first.deflection * q * x.powf(q - 1.0),
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

    /// V at a deflection, and its change on the way from one position to the next.
    pub fn energy(&self, deflection: f64) -> [f64; 2] {
        let size = deflection.abs();
        let load = self.at_deflection(size).load;
        let [area, area_slope] = self.areas(load, self.passed(size));
        [load * size - area, -area_slope]
    }

    /// Number of loads of the table whose deflections a deflection above zero has passed.
    fn passed(&self, size: f64) -> usize {
        let nodes = 0..self.loads.len();
        nodes
            .take_while(|k| self.node(*k).deflection <= size)
            .count()
    }

    /// `∫ δ dF` from rest to a load that has passed so many of the table, and its change on the way from one position to the next.
    fn areas(&self, load: f64, passed: usize) -> [f64; 2] {
        let mut sum = self.first_areas(load.min(self.loads[0]));
        let last = self.loads.len() - 1;
        for k in 0..passed.min(last) {
            let to = load.min(self.loads[k + 1]);
            sum[0] += self.cubic(k, |k| self.node(k)).area(to);
            sum[1] += self.cubic(k, |k| self.node_slope(k)).area(to);
        }
        if passed > last {
            let beyond = load - self.loads[last];
            let triangle = |n: LoadedNode| beyond * (n.deflection + 0.5 * beyond * n.compliance);
            sum[0] += triangle(self.node(last));
            sum[1] += triangle(self.node_slope(last));
        }
        sum
    }

    /// The same below the first load: `δ₁ F₁ x^(p+1)/(p+1)`, `x = F/F₁`.
    fn first_areas(&self, load: f64) -> [f64; 2] {
        if load <= 0.0 {
            return [0.0; 2];
        }
        let (first, change, most) = (self.node(0), self.node_slope(0), self.loads[0]);
        let p = self.exponent(first);
        let p_change = (most * change.compliance - p * change.deflection) / first.deflection;
        let x = load / most;
        let size = most * x.powf(p + 1.0) / (p + 1.0);
        let by_exponent = p_change * (x.ln() - 1.0 / (p + 1.0));
        [
            size * first.deflection,
            size * (change.deflection + first.deflection * by_exponent),
        ]
    }
}
