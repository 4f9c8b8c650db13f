//! Eight shifted eliminations of `K − σM` of a spring forest in one pass over its nodes.
//!
//! The recurrence is that of [`super::forest_factor`]: from leaves to roots `p = d + k c²`, `d_parent += a² k d / p`,
//! `f_parent −= a c k f / p`; from roots to leaves `x = (f − a c k x_parent) / p`, deformation `δ = (a d x_parent + c f) / p`.
//! The shifts of a pass share the division latency and read the nodes once.

use std::sync::Mutex;

use super::forest::Forest;

/// Number of shifts of one pass.
pub(super) const LANES: usize = 8;

type Lanes = [f64; LANES];

/// Smallest pivot, relative to the spring; a smaller one is replaced, which perturbs the spring by that share.
const MIN_PIVOT: f64 = f64::EPSILON;

/// Nodes per partial sum of the energies; blocked summation reduces the rounding error.
const PIECE: usize = 512;

/// Node with the spring to its parent.
#[derive(Debug, Clone, Copy)]
struct Node {
    /// Index of the parent; a root is its own parent with a zero spring.
    parent: usize,
    a: f64,
    c: f64,
    k: f64,
    ground: f64,
    mass: f64,
}

impl Node {
    /// Pivot `d + k c²`, bounded away from zero.
    fn pivot(&self, d: &Lanes) -> Lanes {
        let kc2 = self.k * self.c * self.c;
        let min = MIN_PIVOT * kc2;
        d.map(|d| {
            let pivot = d + kc2;
            if pivot.abs() < min { -min } else { pivot }
        })
    }

    /// Pivot of a root; zero for a free tree without a shift, whose root is then fixed.
    fn root_pivot(&self, d: &Lanes, shifts: &Lanes) -> Lanes {
        std::array::from_fn(|l| {
            let min = MIN_PIVOT * self.ground.max(shifts[l] * self.mass);
            if d[l].abs() < min { -min } else { d[l] }
        })
    }
}

/// Iterate of inverse iteration with its shift and the results of the last solution.
#[derive(Debug, Clone, Default)]
pub(super) struct Iterate {
    /// Shift σ, rad²/s².
    pub shift: f64,
    /// Vector x in elimination order.
    pub x: Vec<f64>,
    /// Mass norm `√(xᵀMx)`.
    pub norm: f64,
    /// Rayleigh quotient `xᵀKx / xᵀMx` from the squares of the deformations, rad²/s².
    pub quotient: f64,
    /// Number of eigenvalues below σ.
    pub n_below: usize,
}

/// Dynamic stiffnesses and solutions of one pass.
struct Workspace {
    d: Vec<Lanes>,
    x: Vec<Lanes>,
}

/// Forest with its nodes in elimination order and reusable workspaces.
pub(super) struct ForestLanes {
    nodes: Vec<Node>,
    idle: Mutex<Vec<Workspace>>,
}

impl ForestLanes {
    pub(super) fn new(forest: &Forest, mass: &[f64]) -> ForestLanes {
        let node = |i: usize| {
            let (ground, mass) = (forest.ground[i], mass[forest.order[i]]);
            let (parent, a, c, k) =
                forest.edges[i].map_or((i, 0.0, 0.0, 0.0), |e| (e.parent, e.a, e.c, e.k));
            Node {
                parent,
                a,
                c,
                k,
                ground,
                mass,
            }
        };
        ForestLanes {
            nodes: (0..forest.len()).map(node).collect(),
            idle: Mutex::default(),
        }
    }

    /// Masses in elimination order.
    pub(super) fn masses(&self) -> Vec<f64> {
        self.nodes.iter().map(|node| node.mass).collect()
    }

    /// Upper bound of the eigenvalues by `(a x + c y)² ≤ 2 a² x² + 2 c² y²`, rad²/s²; zero without mass or stiffness.
    pub(super) fn upper_bound(&self) -> f64 {
        let mut stiffness: Vec<f64> = self.nodes.iter().map(|node| node.ground).collect();
        for (i, node) in self.nodes.iter().enumerate() {
            stiffness[i] += 2.0 * node.k * node.c * node.c;
            stiffness[node.parent] += 2.0 * node.k * node.a * node.a;
        }
        let rows = stiffness.iter().zip(&self.nodes);
        // A small margin keeps an attained bound above the eigenvalue.
        1.000_001
            * rows
                .filter(|(_, node)| node.mass > 0.0)
                .fold(0.0_f64, |bound, (k, node)| bound.max(k / node.mass))
    }

    /// Number of eigenvalues below each of up to eight shifts.
    pub(super) fn count_below(&self, shifts: &[f64]) -> Vec<usize> {
        let lanes = std::array::from_fn(|l| shifts[l.min(shifts.len() - 1)]);
        let mut work = self.workspace();
        let negative = self.eliminate(&lanes, None, &mut work);
        self.release(work);
        negative[..shifts.len()].to_vec()
    }

    /// Replaces x of up to eight iterates by `(K − σM)⁻¹ M x / ‖x‖`.
    pub(super) fn solve(&self, block: &mut [&mut Iterate]) {
        let last = block.len() - 1;
        let shifts = std::array::from_fn(|l| block[l.min(last)].shift);
        let scale = std::array::from_fn(|l| 1.0 / block[l.min(last)].norm);
        let vectors: [&[f64]; LANES] = std::array::from_fn(|l| &block[l.min(last)].x[..]);
        let mut work = self.workspace();
        let n_below = self.eliminate(&shifts, Some((&vectors, &scale)), &mut work);
        let (mut energy, mut norm2) = ([0.0; LANES], [0.0; LANES]);
        for start in (0..self.nodes.len()).step_by(PIECE) {
            let end = self.nodes.len().min(start + PIECE);
            let (e, n) = self.substitute(start..end, &shifts, &mut work);
            for l in 0..LANES {
                energy[l] += e[l];
                norm2[l] += n[l];
            }
            for (l, iterate) in block.iter_mut().enumerate() {
                (iterate.x[start..end].iter_mut().zip(&work.x[start..end]))
                    .for_each(|(to, from)| *to = from[l]);
            }
        }
        self.release(work);
        for (l, iterate) in block.iter_mut().enumerate() {
            iterate.norm = norm2[l].sqrt();
            iterate.quotient = energy[l] / norm2[l];
            iterate.n_below = n_below[l];
        }
    }

    /// Eliminates from the leaves to the roots: d of every node and the forces `M x`; returns the number of negative pivots.
    fn eliminate(
        &self,
        shifts: &Lanes,
        loads: Option<(&[&[f64]; LANES], &Lanes)>,
        work: &mut Workspace,
    ) -> [usize; LANES] {
        let Workspace { d, x } = work;
        let mut negative = [0_u64; LANES];
        // In breadth-first order parents are sorted like their nodes: values set here are still in the cache when they are used.
        let mut n_unset = self.nodes.len();
        for (i, node) in self.nodes.iter().enumerate().rev() {
            for j in (node.parent..n_unset).rev() {
                let Node { ground, mass, .. } = self.nodes[j];
                d[j] = shifts.map(|shift| ground - shift * mass);
                if let Some((vectors, scale)) = loads {
                    x[j] = std::array::from_fn(|l| mass * (scale[l] * vectors[l][j]));
                }
            }
            n_unset = n_unset.min(node.parent);
            let (d_node, is_root) = (d[i], node.parent == i);
            let pivot = match is_root {
                true => node.root_pivot(&d_node, shifts),
                false => node.pivot(&d_node),
            };
            for l in 0..LANES {
                negative[l] += pivot[l].to_bits() >> 63;
            }
            if is_root {
                continue;
            }
            let inverse = pivot.map(|p| 1.0 / p);
            let (d_factor, f_factor) = (node.a * node.a * node.k, node.a * node.c * node.k);
            let parent = &mut d[node.parent];
            for l in 0..LANES {
                parent[l] += d_factor * (d_node[l] * inverse[l]);
            }
            if loads.is_some() {
                let force = x[i];
                let parent = &mut x[node.parent];
                for l in 0..LANES {
                    parent[l] -= f_factor * inverse[l] * force[l];
                }
            }
        }
        negative.map(|n| n as usize)
    }

    /// Substitutes from the roots to the leaves over a range of nodes; returns `xᵀKx` and `xᵀMx` of the range.
    fn substitute(
        &self,
        span: std::ops::Range<usize>,
        shifts: &Lanes,
        work: &mut Workspace,
    ) -> (Lanes, Lanes) {
        let (mut energy, mut norm2) = ([0.0; LANES], [0.0; LANES]);
        for i in span {
            let (node, d, force) = (&self.nodes[i], work.d[i], work.x[i]);
            let mut x = [0.0; LANES];
            if node.parent == i {
                let pivot = node.root_pivot(&d, shifts);
                for l in (0..LANES).filter(|&l| pivot[l] != 0.0) {
                    x[l] = force[l] / pivot[l];
                }
            } else {
                let (inverse, x_parent) = (node.pivot(&d).map(|p| 1.0 / p), work.x[node.parent]);
                let f_factor = node.a * node.c * node.k;
                for l in 0..LANES {
                    let delta = (node.a * d[l] * x_parent[l] + node.c * force[l]) * inverse[l];
                    x[l] = (force[l] - f_factor * x_parent[l]) * inverse[l];
                    energy[l] += node.k * delta * delta;
                }
            }
            for l in 0..LANES {
                energy[l] += node.ground * x[l] * x[l];
                norm2[l] += node.mass * x[l] * x[l];
            }
            work.x[i] = x;
        }
        (energy, norm2)
    }

    fn workspace(&self) -> Workspace {
        let idle = self.idle.lock().ok().and_then(|mut idle| idle.pop());
        let lanes = || vec![[0.0; LANES]; self.nodes.len()];
        idle.unwrap_or_else(|| Workspace {
            d: lanes(),
            x: lanes(),
        })
    }

    fn release(&self, work: Workspace) {
        if let Ok(mut idle) = self.idle.lock() {
            idle.push(work);
        }
    }
}
