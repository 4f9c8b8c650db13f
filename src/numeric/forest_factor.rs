//! LDLᵀ factorisation of `K − σM` of a spring forest from leaves to roots; at σ = 0 nothing is subtracted.
//!
//! d is the dynamic stiffness a node shows to what is above it, d′ that of a child behind its spring. K is never formed and, at σ = 0,
//! nothing is ever subtracted: a solution is right to a few rounding errors times the depth, whatever the spread of the springs.
//! Each rounding is the same as changing one inertia, spring or ratio by a few units in its last place, hence so is a Sturm count.
//! Springs that close loops are unknown forces F on the forest: `(k⁻¹ + wᵀA⁻¹w) F = wᵀA⁻¹f`.

use faer::Side;
use faer::linalg::solvers::{FullPivLu, Solve};

use super::Matrix;
use super::forest::{ClosingSpring, Forest};

/// Pivots below this times their spring are put there: the same as changing the spring by so much.
const MIN_PIVOT: f64 = f64::EPSILON;

/// The same where loops follow, whose small matrix must keep some digits next to the reciprocal of this.
const MIN_PIVOT_WITH_LOOPS: f64 = 1e-13;

/// A factorisation of `K − σM`; at σ = 0 of K, with one degree of freedom of each free tree held still.
#[derive(Debug)]
pub struct ForestFactor<'f> {
    forest: &'f Forest,
    /// `−σ m`, per position; empty at σ = 0.
    inertial: Vec<f64>,
    /// d of every node, per position.
    stiffness: Vec<f64>,
    /// `1 / (d + k c²)`; at a root 1/d, or zero where it is held still.
    flexibility: Vec<f64>,
    /// `−a c k / (d + k c²)`: what a force on the child is on the parent.
    ratio: Vec<f64>,
    loop_forces: Option<LoopForces>,
    negative: usize,
    smallest: f64,
}

/// The forces of the loops, and the turning of trees that only loops of contradicting ratios hold.
#[derive(Debug)]
struct LoopForces {
    scale: Vec<f64>,
    factor: FullPivLu<f64>,
    /// Which tree turns by each unknown behind the loops' forces.
    locked: Vec<usize>,
    negative: usize,
}

/// Deformations of the springs next to a solution.
struct SpringDeformation {
    links: Vec<f64>,
    forces: Vec<f64>,
}

impl Forest {
    /// K itself.
    pub fn factorise(&self) -> ForestFactor<'_> {
        ForestFactor::new(self, Vec::new())
    }

    /// `K − σM` for a diagonal M in kg·m² or kg, σ = ω² in rad²/s².
    pub fn factorise_shifted(&self, mass: &[f64], sigma: f64) -> ForestFactor<'_> {
        ForestFactor::new(self, self.order.iter().map(|&i| -sigma * mass[i]).collect())
    }

    /// Number of eigenvalues of (K, M) below σ, those of rigid motions among them.
    pub fn count_below(&self, mass: &[f64], sigma: f64) -> usize {
        if sigma > 0.0 {
            self.factorise_shifted(mass, sigma).n_negative()
        } else {
            0
        }
    }
}

impl<'f> ForestFactor<'f> {
    fn new(forest: &'f Forest, inertial: Vec<f64>) -> ForestFactor<'f> {
        let n = forest.len();
        let mut this = ForestFactor {
            forest,
            stiffness: forest.ground.clone(),
            flexibility: vec![0.0; n],
            ratio: vec![0.0; n],
            loop_forces: None,
            negative: 0,
            smallest: 1.0,
            inertial,
        };
        this.stiffness
            .iter_mut()
            .zip(&this.inertial)
            .for_each(|(d, s)| *d += s);
        this.pivot();
        if !forest.loops.is_empty() {
            let loop_forces = this.factor_loops();
            this.negative = this.negative.saturating_sub(loop_forces.negative);
            this.loop_forces = Some(loop_forces);
        }
        this
    }

    fn pivot(&mut self) {
        let floor = if self.forest.loops.is_empty() {
            MIN_PIVOT
        } else {
            MIN_PIVOT_WITH_LOOPS
        };
        for at in (0..self.stiffness.len()).rev() {
            let d = self.stiffness[at];
            let Some(link) = self.forest.edges[at] else {
                self.pivot_root(at, floor);
                continue;
            };
            let own = link.k * link.c * link.c;
            let mut pivot = d + own;
            self.smallest = self.smallest.min((pivot / own).abs());
            if pivot.abs() < floor * own {
                pivot = -floor * own;
            }
            self.negative += usize::from(pivot < 0.0);
            self.flexibility[at] = 1.0 / pivot;
            self.ratio[at] = if d == 0.0 {
                -link.a / link.c
            } else {
                -link.a * link.c * (link.k / pivot)
            };
            self.stiffness[link.parent] += link.a * link.a * link.k * (d / pivot);
        }
    }

    fn pivot_root(&mut self, at: usize, floor: f64) {
        let Some(inertial) = self.inertial.get(at) else {
            self.flexibility[at] = if self.stiffness[at] > 0.0 {
                1.0 / self.stiffness[at]
            } else {
                0.0
            };
            return;
        };
        let size = self.forest.ground[at].max(inertial.abs());
        let mut pivot = self.stiffness[at];
        if pivot.abs() < floor * size {
            pivot = -floor * size;
        }
        if size > 0.0 {
            self.smallest = self.smallest.min((pivot / size).abs());
        }
        self.negative += usize::from(pivot < 0.0);
        self.flexibility[at] = if pivot == 0.0 { 0.0 } else { 1.0 / pivot };
    }

    /// The small matrix of the loops: symmetric, `[k⁻¹ + wᵀA⁻¹w, −G; −Gᵀ, 0]` with G the slip of each locked tree.
    fn factor_loops(&self) -> LoopForces {
        let forest = self.forest;
        let p = forest.loops.len();
        let locked: Vec<usize> = match self.inertial.is_empty() {
            true => (0..forest.trees.len())
                .filter(|&t| forest.trees[t].locked)
                .collect(),
            false => Vec::new(),
        };
        let mut small = Matrix::zeros(p + locked.len(), p + locked.len());
        let (mut x, mut links) = (vec![0.0; forest.len()], vec![0.0; forest.len()]);
        for (col, closing) in forest.loops.iter().enumerate() {
            x.fill(0.0);
            closing.ends.iter().for_each(|&(at, w)| x[at] += w);
            self.solve_forest(&mut x, &mut links);
            for (row, other) in forest.loops.iter().enumerate() {
                small[(row, col)] = other.deformation(&x, &links);
            }
            small[(col, col)] += 1.0 / closing.k;
            for (t, &tree) in locked.iter().enumerate() {
                let slip = if forest.tree_contains(tree, closing.apex) {
                    closing.slip * forest.rigid_shape[closing.apex]
                } else {
                    0.0
                };
                small[(col, p + t)] = -slip;
                small[(p + t, col)] = -slip;
            }
        }
        let size = |i: usize| {
            let column = (0..p)
                .map(|row| small[(row, i)].abs())
                .fold(f64::MIN_POSITIVE, f64::max);
            let diagonal = small[(i, i)].abs();
            if i < p && diagonal > 0.0 {
                diagonal.sqrt()
            } else {
                column
            }
        };
        let scale: Vec<f64> = (0..p + locked.len()).map(|i| 1.0 / size(i)).collect();
        let scaled = Matrix::from_fn(scale.len(), scale.len(), |i, j| {
            0.5 * (small[(i, j)] + small[(j, i)]) * scale[i] * scale[j]
        });
        let negative = match self.inertial.is_empty() || !scaled.as_ref().is_all_finite() {
            true => 0,
            false => scaled
                .self_adjoint_eigenvalues(Side::Lower)
                .map_or(0, |values| values.iter().filter(|v| **v < 0.0).count()),
        };
        LoopForces {
            scale,
            factor: scaled.full_piv_lu(),
            locked,
            negative,
        }
    }

    /// Overwrites a force by the motion it causes, `x = (K − σM)⁻¹ f`.
    ///
    /// At σ = 0 a force on a free tree must do no work on its rigid motion; the answer is the one that vanishes at the tree's root.
    /// Away from zero one step of refinement follows, since pivots are then small by chance.
    pub fn solve(&self, f: &mut [f64]) {
        let load = self.gather(f);
        let (mut x, _) = self.solve_closed(load.clone());
        if !self.inertial.is_empty() {
            let residual = self.residual(&load, &x);
            let (correction, _) = self.solve_closed(residual);
            x.iter_mut().zip(&correction).for_each(|(x, c)| *x += c);
        }
        self.scatter(&x, f);
    }

    /// The same at σ = 0 without refinement, and twice the strain energy `xᵀKx = Σ k δ²`, a sum without cancellation.
    pub fn solve_with_energy(&self, f: &mut [f64]) -> f64 {
        let (x, deformed) = self.solve_closed(self.gather(f));
        self.scatter(&x, f);
        let in_links: f64 = deformed
            .links
            .iter()
            .zip(&self.forest.edges)
            .map(|(d, link)| link.map_or(0.0, |l| l.k * d * d))
            .sum();
        let in_ground: f64 = x
            .iter()
            .zip(&self.forest.ground)
            .map(|(x, g)| g * x * x)
            .sum();
        let in_loops: f64 = deformed
            .forces
            .iter()
            .zip(&self.forest.loops)
            .map(|(force, l)| force * force / l.k)
            .sum();
        in_links + in_ground + in_loops
    }

    /// Number of eigenvalues below σ.
    pub fn n_negative(&self) -> usize {
        self.negative
    }

    /// The smallest pivot relative to its own spring; far below 1e-8 means σ is an eigenvalue of the machine or of a part of it.
    pub fn smallest_pivot(&self) -> f64 {
        self.smallest
    }

    fn gather(&self, f: &[f64]) -> Vec<f64> {
        self.forest.order.iter().map(|&i| f[i]).collect()
    }

    fn scatter(&self, x: &[f64], f: &mut [f64]) {
        self.forest
            .order
            .iter()
            .zip(x)
            .for_each(|(&i, x)| f[i] = *x);
    }

    fn solve_forest(&self, x: &mut [f64], links: &mut [f64]) {
        let forest = self.forest;
        for at in (0..x.len()).rev() {
            if let Some(link) = &forest.edges[at] {
                x[link.parent] += self.ratio[at] * x[at];
            }
        }
        for at in 0..x.len() {
            let (force, flexibility) = (x[at], self.flexibility[at]);
            x[at] = match &forest.edges[at] {
                None => force * flexibility,
                Some(link) => {
                    let above = x[link.parent];
                    links[at] =
                        (link.a * self.stiffness[at] * above + link.c * force) * flexibility;
                    force * flexibility + self.ratio[at] * above
                }
            };
        }
    }

    fn solve_closed(&self, mut load: Vec<f64>) -> (Vec<f64>, SpringDeformation) {
        let forest = self.forest;
        let mut links = vec![0.0; load.len()];
        let Some(loop_forces) = &self.loop_forces else {
            self.solve_forest(&mut load, &mut links);
            return (
                load,
                SpringDeformation {
                    links,
                    forces: Vec::new(),
                },
            );
        };
        let p = forest.loops.len();
        let mut open = load.clone();
        self.solve_forest(&mut open, &mut links);
        let mut right = Matrix::zeros(loop_forces.scale.len(), 1);
        for (row, closing) in forest.loops.iter().enumerate() {
            right[(row, 0)] = loop_forces.scale[row] * closing.deformation(&open, &links);
        }
        for (t, &tree) in loop_forces.locked.iter().enumerate() {
            let span = forest.trees[tree].start..forest.trees[tree].end;
            let work: f64 = span.map(|at| forest.rigid_shape[at] * load[at]).sum();
            right[(p + t, 0)] = -loop_forces.scale[p + t] * work;
        }
        let unknown = loop_forces.factor.solve(&right);
        let forces: Vec<f64> = (0..p)
            .map(|row| loop_forces.scale[row] * unknown[(row, 0)])
            .collect();
        for (closing, force) in forest.loops.iter().zip(&forces) {
            closing
                .ends
                .iter()
                .for_each(|&(at, w)| load[at] -= w * force);
        }
        self.solve_forest(&mut load, &mut links);
        for (t, &tree) in loop_forces.locked.iter().enumerate() {
            let turn = loop_forces.scale[p + t] * unknown[(p + t, 0)];
            (forest.trees[tree].start..forest.trees[tree].end)
                .for_each(|at| load[at] += turn * forest.rigid_shape[at]);
        }
        (load, SpringDeformation { links, forces })
    }

    fn residual(&self, load: &[f64], x: &[f64]) -> Vec<f64> {
        let forest = self.forest;
        let own = |at: usize| load[at] - (forest.ground[at] + self.inertial[at]) * x[at];
        let mut residual: Vec<f64> = (0..x.len()).map(own).collect();
        for (at, link) in forest.edges.iter().enumerate() {
            let Some(link) = link else { continue };
            let force = link.k * (link.a * x[link.parent] + link.c * x[at]);
            residual[link.parent] -= link.a * force;
            residual[at] -= link.c * force;
        }
        for closing in &forest.loops {
            let force = closing.k * closing.ends.iter().map(|&(at, w)| w * x[at]).sum::<f64>();
            closing
                .ends
                .iter()
                .for_each(|&(at, w)| residual[at] -= w * force);
        }
        residual
    }
}

impl ClosingSpring {
    fn deformation(&self, x: &[f64], links: &[f64]) -> f64 {
        self.along
            .iter()
            .map(|&(at, factor)| factor * links[at])
            .sum::<f64>()
            + self.slip * x[self.apex]
    }
}

impl Forest {
    fn tree_contains(&self, tree: usize, at: usize) -> bool {
        (self.trees[tree].start..self.trees[tree].end).contains(&at)
    }
}
