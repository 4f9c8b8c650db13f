//! Eight shifted eliminations `K − σM` of a spring forest without loops in one pass over its nodes.
//!
//! The recurrence is that of [`super::forest_factor`]: from leaves to roots `p = d + k c²`, `d_parent += a² k d / p`,
//! `f_parent −= a c k f / p`; from roots to leaves `x = (f − a c k x_parent) / p`, deformation `δ = (a d x_parent + c f) / p`.
//! The shifts of a pass wait for the same divisions and read the nodes once.

use std::sync::Mutex;

use super::forest::Forest;

/// Shifts of one pass.
pub(super) const LANES: usize = 8;

type Lanes = [f64; LANES];

/// A pivot below this times its spring is put there: the same as changing the spring by so much.
const MIN_PIVOT: f64 = f64::EPSILON;

/// Nodes whose energies are summed before they join the total: rounding grows with the square root of their number.
const PIECE: usize = 512;

/// A node and the spring to its parent.
#[derive(Debug, Clone, Copy)]
struct Node {
    /// Position of the parent; of the node itself at a root, whose spring is zero.
    parent: usize,
    a: f64,
    c: f64,
    k: f64,
    ground: f64,
    mass: f64,
}

impl Node {
    /// `d + k c²`, kept away from zero.
    fn pivot(&self, d: &Lanes) -> Lanes {
        let own = self.k * self.c * self.c;
        let floor = MIN_PIVOT * own;
        d.map(|d| {
            let pivot = d + own;
            if pivot.abs() < floor { -floor } else { pivot }
        })
    }

    /// The same of a root; zero where it is held still, in a free tree without a shift.
    fn root_pivot(&self, d: &Lanes, shifts: &Lanes) -> Lanes {
        std::array::from_fn(|l| {
            let floor = MIN_PIVOT * self.ground.max(shifts[l] * self.mass);
            if d[l].abs() < floor { -floor } else { d[l] }
        })
    }
}

/// A vector with the shift that is solved for, and what the last solution gave.
#[derive(Debug, Clone, Default)]
pub(super) struct Iterate {
    /// σ, rad²/s².
    pub shift: f64,
    /// In elimination order.
    pub x: Vec<f64>,
    /// `√(xᵀMx)`.
    pub norm: f64,
    /// `xᵀKx / xᵀMx`, a sum of squares of deformations; rad²/s².
    pub quotient: f64,
    /// Number of eigenvalues below σ.
    pub n_below: usize,
}

/// Dynamic stiffnesses and solutions of one pass.
struct Workspace {
    d: Vec<Lanes>,
    x: Vec<Lanes>,
}

/// Nodes of a forest in elimination order.
pub(super) struct ForestLanes {
    nodes: Vec<Node>,
    idle: Mutex<Vec<Workspace>>,
}

impl ForestLanes {
    pub(super) fn new(forest: &Forest, mass: &[f64]) -> ForestLanes {
        let node = |at: usize| {
            let (ground, mass) = (forest.ground[at], mass[forest.order[at]]);
            let (parent, a, c, k) =
                forest.edges[at].map_or((at, 0.0, 0.0, 0.0), |e| (e.parent, e.a, e.c, e.k));
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

    /// Above every eigenvalue: `(a x + c y)² ≤ 2 a² x² + 2 c² y²`; zero where nothing vibrates.
    pub(super) fn upper_bound(&self) -> f64 {
        let mut stiffness: Vec<f64> = self.nodes.iter().map(|node| node.ground).collect();
        for (at, node) in self.nodes.iter().enumerate() {
            stiffness[at] += 2.0 * node.k * node.c * node.c;
            stiffness[node.parent] += 2.0 * node.k * node.a * node.a;
        }
        let heavy = stiffness.iter().zip(&self.nodes);
        // A hair more, so that a bound that is met is no eigenvalue.
        1.000_001
            * heavy
                .filter(|(_, node)| node.mass > 0.0)
                .fold(0.0_f64, |top, (k, node)| top.max(k / node.mass))
    }

    /// Number of eigenvalues below up to eight shifts.
    pub(super) fn count_below(&self, shifts: &[f64]) -> Vec<usize> {
        let lanes = std::array::from_fn(|l| shifts[l.min(shifts.len() - 1)]);
        let mut work = self.workspace();
        let negative = self.eliminate(&lanes, None, &mut work);
        self.give_back(work);
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
        self.give_back(work);
        for (l, iterate) in block.iter_mut().enumerate() {
            iterate.norm = norm2[l].sqrt();
            iterate.quotient = energy[l] / norm2[l];
            iterate.n_below = n_below[l];
        }
    }

    /// From leaves to roots: d of every node, the forces `M x` carried along, negative pivots.
    fn eliminate(
        &self,
        shifts: &Lanes,
        loads: Option<(&[&[f64]; LANES], &Lanes)>,
        work: &mut Workspace,
    ) -> [usize; LANES] {
        let Workspace { d, x } = work;
        let mut negative = [0_u64; LANES];
        // Breadth first, the parent of an earlier node comes no later: what is set here is still in the cache when it is used.
        let mut set = self.nodes.len();
        for (at, node) in self.nodes.iter().enumerate().rev() {
            for up in (node.parent..set).rev() {
                let Node { ground, mass, .. } = self.nodes[up];
                d[up] = shifts.map(|shift| ground - shift * mass);
                if let Some((vectors, scale)) = loads {
                    x[up] = std::array::from_fn(|l| mass * (scale[l] * vectors[l][up]));
                }
            }
            set = set.min(node.parent);
            let (own, is_root) = (d[at], node.parent == at);
            let pivot = match is_root {
                true => node.root_pivot(&own, shifts),
                false => node.pivot(&own),
            };
            for l in 0..LANES {
                negative[l] += pivot[l].to_bits() >> 63;
            }
            if is_root {
                continue;
            }
            let inverse = pivot.map(|p| 1.0 / p);
            let (on_parent, carried) = (node.a * node.a * node.k, node.a * node.c * node.k);
            let parent = &mut d[node.parent];
            for l in 0..LANES {
                parent[l] += on_parent * (own[l] * inverse[l]);
            }
            if loads.is_some() {
                let force = x[at];
                let parent = &mut x[node.parent];
                for l in 0..LANES {
                    parent[l] -= carried * inverse[l] * force[l];
                }
            }
        }
        negative.map(|n| n as usize)
    }

    /// From roots to leaves over a part of the nodes: forces become motions; `xᵀKx` and `xᵀMx` of the part.
    fn substitute(
        &self,
        span: std::ops::Range<usize>,
        shifts: &Lanes,
        work: &mut Workspace,
    ) -> (Lanes, Lanes) {
        let (mut energy, mut norm2) = ([0.0; LANES], [0.0; LANES]);
        for at in span {
            let (node, d, force) = (&self.nodes[at], work.d[at], work.x[at]);
            let mut x = [0.0; LANES];
            if node.parent == at {
                let pivot = node.root_pivot(&d, shifts);
                for l in (0..LANES).filter(|&l| pivot[l] != 0.0) {
                    x[l] = force[l] / pivot[l];
                }
            } else {
                let (inverse, above) = (node.pivot(&d).map(|p| 1.0 / p), work.x[node.parent]);
                let carried = node.a * node.c * node.k;
                for l in 0..LANES {
                    let stretch = (node.a * d[l] * above[l] + node.c * force[l]) * inverse[l];
                    x[l] = (force[l] - carried * above[l]) * inverse[l];
                    energy[l] += node.k * stretch * stretch;
                }
            }
            for l in 0..LANES {
                energy[l] += node.ground * x[l] * x[l];
                norm2[l] += node.mass * x[l] * x[l];
            }
            work.x[at] = x;
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

    fn give_back(&self, work: Workspace) {
        if let Ok(mut idle) = self.idle.lock() {
            idle.push(work);
        }
    }
}
