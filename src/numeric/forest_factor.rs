//! LDLᵀ factorisation of `K − σM` of a spring forest from leaves to roots; at σ = 0 no pivot needs a subtraction.
//!
//! d is the dynamic stiffness of the subtree of a node, without the edge to its parent. K is never formed, and at σ = 0 all pivots are
//! sums of positive terms: the error of a solution is a few roundings times the depth, whatever the spread of the springs.
//! Each rounding equals a change of one inertia, spring or ratio by a few units in its last place; the same holds for a Sturm count.
//! Springs that close loops act as unknown forces F on the forest: `(k⁻¹ + wᵀA⁻¹w) F = wᵀA⁻¹f`.

use faer::Side;
use faer::linalg::solvers::{FullPivLu, Solve};

use super::Matrix;
use super::forest::{ClosingSpring, Forest};

/// Smallest pivot relative to its spring; a smaller one is replaced, which equals a relative change of the spring by this much.
const MIN_PIVOT: f64 = f64::EPSILON;

/// Smallest relative pivot with loops: the matrix of the loop forces contains its reciprocal and must keep some digits.
const MIN_PIVOT_WITH_LOOPS: f64 = 1e-13;

/// Factorisation of `K − σM`; at σ = 0 of K, with the root of each free tree fixed.
#[derive(Debug)]
pub struct ForestFactor<'f> {
    forest: &'f Forest,
    /// `−σ m`, per position; empty at σ = 0.
    inertial: Vec<f64>,
    /// Dynamic stiffness d, per position.
    stiffness: Vec<f64>,
    /// `1 / (d + k c²)`; at a root 1/d, or zero where the root is fixed.
    flexibility: Vec<f64>,
    /// `−a c k / (d + k c²)`: force on the parent per unit force on the child.
    ratio: Vec<f64>,
    loop_forces: Option<LoopForces>,
    negative: usize,
    smallest: f64,
}

/// Factorised equations of the loop forces and of the rigid rotations of the locked trees.
#[derive(Debug)]
struct LoopForces {
    scale: Vec<f64>,
    factor: FullPivLu<f64>,
    /// Index of the tree of each rotation unknown; these follow the loop forces.
    locked: Vec<usize>,
    negative: usize,
}

struct SpringDeformation {
    delta: Vec<f64>,
    forces: Vec<f64>,
}

impl Forest {
    /// Factorises K.
    pub fn factorise(&self) -> ForestFactor<'_> {
        ForestFactor::new(self, Vec::new())
    }

    /// Factorises `K − σM` for a diagonal M, kg·m² or kg, at σ = ω², rad²/s².
    pub fn factorise_shifted(&self, mass: &[f64], sigma: f64) -> ForestFactor<'_> {
        ForestFactor::new(self, self.order.iter().map(|&i| -sigma * mass[i]).collect())
    }

    /// Number of eigenvalues of (K, M) below σ, rad²/s², those of rigid motions included.
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
        let mut result = ForestFactor {
            forest,
            stiffness: forest.ground.clone(),
            flexibility: vec![0.0; n],
            ratio: vec![0.0; n],
            loop_forces: None,
            negative: 0,
            smallest: 1.0,
            inertial,
        };
        (result.stiffness.iter_mut())
            .zip(&result.inertial)
            .for_each(|(d, s)| *d += s);
        result.pivot();
        if !forest.loops.is_empty() {
            let loop_forces = result.factor_loops();
            result.negative = result.negative.saturating_sub(loop_forces.negative);
            result.loop_forces = Some(loop_forces);
        }
        result
    }

    fn pivot(&mut self) {
        let floor = if self.forest.loops.is_empty() {
            MIN_PIVOT
        } else {
            MIN_PIVOT_WITH_LOOPS
        };
        for pos in (0..self.stiffness.len()).rev() {
            let d = self.stiffness[pos];
            let Some(edge) = self.forest.edges[pos] else {
                self.pivot_root(pos, floor);
                continue;
            };
            let edge_stiffness = edge.k * edge.c * edge.c;
            let mut pivot = d + edge_stiffness;
            self.smallest = self.smallest.min((pivot / edge_stiffness).abs());
            if pivot.abs() < floor * edge_stiffness {
                pivot = -floor * edge_stiffness;
            }
            self.negative += usize::from(pivot < 0.0);
            self.flexibility[pos] = 1.0 / pivot;
            self.ratio[pos] = if d == 0.0 {
                -edge.a / edge.c
            } else {
                -edge.a * edge.c * (edge.k / pivot)
            };
            self.stiffness[edge.parent] += edge.a * edge.a * edge.k * (d / pivot);
        }
    }

    fn pivot_root(&mut self, pos: usize, floor: f64) {
        let Some(inertial) = self.inertial.get(pos) else {
            self.flexibility[pos] = if self.stiffness[pos] > 0.0 {
                1.0 / self.stiffness[pos]
            } else {
                0.0
            };
            return;
        };
        let size = self.forest.ground[pos].max(inertial.abs());
        let mut pivot = self.stiffness[pos];
        if pivot.abs() < floor * size {
            pivot = -floor * size;
        }
        if size > 0.0 {
            self.smallest = self.smallest.min((pivot / size).abs());
        }
        self.negative += usize::from(pivot < 0.0);
        self.flexibility[pos] = if pivot == 0.0 { 0.0 } else { 1.0 / pivot };
    }

    /// Factorises the symmetric matrix of the loop forces, `[k⁻¹ + wᵀA⁻¹w, −G; −Gᵀ, 0]` with G the slip of each locked tree.
    fn factor_loops(&self) -> LoopForces {
        let forest = self.forest;
        let p = forest.loops.len();
        let locked: Vec<usize> = match self.inertial.is_empty() {
            true => (0..forest.trees.len())
                .filter(|&t| forest.trees[t].locked)
                .collect(),
            false => Vec::new(),
        };
        let mut matrix = Matrix::zeros(p + locked.len(), p + locked.len());
        let (mut x, mut delta) = (vec![0.0; forest.len()], vec![0.0; forest.len()]);
        for (col, closing) in forest.loops.iter().enumerate() {
            x.fill(0.0);
            closing.ends.iter().for_each(|&(pos, w)| x[pos] += w);
            self.solve_forest(&mut x, &mut delta);
            for (row, other) in forest.loops.iter().enumerate() {
                matrix[(row, col)] = other.deformation(&x, &delta);
            }
            matrix[(col, col)] += 1.0 / closing.k;
            for (t, &tree) in locked.iter().enumerate() {
                let slip = if forest.tree_contains(tree, closing.apex) {
                    closing.slip * forest.rigid_shape[closing.apex]
                } else {
                    0.0
                };
                matrix[(col, p + t)] = -slip;
                matrix[(p + t, col)] = -slip;
            }
        }
        let size = |i: usize| {
            let column = (0..p)
                .map(|row| matrix[(row, i)].abs())
                .fold(f64::MIN_POSITIVE, f64::max);
            let diagonal = matrix[(i, i)].abs();
            if i < p && diagonal > 0.0 {
                diagonal.sqrt()
            } else {
                column
            }
        };
        let scale: Vec<f64> = (0..p + locked.len()).map(|i| 1.0 / size(i)).collect();
        let scaled = Matrix::from_fn(scale.len(), scale.len(), |i, j| {
            0.5 * (matrix[(i, j)] + matrix[(j, i)]) * scale[i] * scale[j]
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

    /// Overwrites the force f by the motion `x = (K − σM)⁻¹ f`.
    ///
    /// At σ = 0 the force on a free tree must do no work on its rigid motion; the solution vanishes at the root of the tree.
    /// For σ ≠ 0 one step of iterative refinement follows, since pivots can be small.
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

    /// Solves as [`Self::solve`] at σ = 0 without refinement; returns twice the strain energy, `xᵀKx = Σ k δ²`, without cancellation.
    pub fn solve_with_energy(&self, f: &mut [f64]) -> f64 {
        let (x, deformation) = self.solve_closed(self.gather(f));
        self.scatter(&x, f);
        let tree_energy: f64 = deformation
            .delta
            .iter()
            .zip(&self.forest.edges)
            .map(|(d, edge)| edge.map_or(0.0, |l| l.k * d * d))
            .sum();
        let ground_energy: f64 = x
            .iter()
            .zip(&self.forest.ground)
            .map(|(x, g)| g * x * x)
            .sum();
        let loop_energy: f64 = deformation
            .forces
            .iter()
            .zip(&self.forest.loops)
            .map(|(force, l)| force * force / l.k)
            .sum();
        tree_energy + ground_energy + loop_energy
    }

    /// Number of eigenvalues below σ.
    pub fn n_negative(&self) -> usize {
        self.negative
    }

    /// Smallest pivot relative to its spring; far below 1e-8, σ is an eigenvalue of the machine or of a subtree.
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

    fn solve_forest(&self, x: &mut [f64], delta: &mut [f64]) {
        let forest = self.forest;
        for i in (0..x.len()).rev() {
            if let Some(edge) = &forest.edges[i] {
                x[edge.parent] += self.ratio[i] * x[i];
            }
        }
        for i in 0..x.len() {
            let (force, flexibility) = (x[i], self.flexibility[i]);
            x[i] = match &forest.edges[i] {
                None => force * flexibility,
                Some(edge) => {
                    let x_parent = x[edge.parent];
                    delta[i] =
                        (edge.a * self.stiffness[i] * x_parent + edge.c * force) * flexibility;
                    force * flexibility + self.ratio[i] * x_parent
                }
            };
        }
    }

    fn solve_closed(&self, mut load: Vec<f64>) -> (Vec<f64>, SpringDeformation) {
        let forest = self.forest;
        let mut delta = vec![0.0; load.len()];
        let Some(loop_forces) = &self.loop_forces else {
            self.solve_forest(&mut load, &mut delta);
            return (
                load,
                SpringDeformation {
                    delta,
                    forces: Vec::new(),
                },
            );
        };
        let p = forest.loops.len();
        let mut open_x = load.clone();
        self.solve_forest(&mut open_x, &mut delta);
        let mut rhs = Matrix::zeros(loop_forces.scale.len(), 1);
        for (row, closing) in forest.loops.iter().enumerate() {
            rhs[(row, 0)] = loop_forces.scale[row] * closing.deformation(&open_x, &delta);
        }
        for (t, &tree) in loop_forces.locked.iter().enumerate() {
            let nodes = forest.trees[tree].start..forest.trees[tree].end;
            let work: f64 = nodes.map(|pos| forest.rigid_shape[pos] * load[pos]).sum();
            rhs[(p + t, 0)] = -loop_forces.scale[p + t] * work;
        }
        let unknown = loop_forces.factor.solve(&rhs);
        let forces: Vec<f64> = (0..p)
            .map(|row| loop_forces.scale[row] * unknown[(row, 0)])
            .collect();
        for (closing, force) in forest.loops.iter().zip(&forces) {
            closing
                .ends
                .iter()
                .for_each(|&(pos, w)| load[pos] -= w * force);
        }
        self.solve_forest(&mut load, &mut delta);
        for (t, &tree) in loop_forces.locked.iter().enumerate() {
            let rotation = loop_forces.scale[p + t] * unknown[(p + t, 0)];
            (forest.trees[tree].start..forest.trees[tree].end)
                .for_each(|pos| load[pos] += rotation * forest.rigid_shape[pos]);
        }
        (load, SpringDeformation { delta, forces })
    }

    fn residual(&self, load: &[f64], x: &[f64]) -> Vec<f64> {
        let forest = self.forest;
        let nodal = |i: usize| load[i] - (forest.ground[i] + self.inertial[i]) * x[i];
        let mut residual: Vec<f64> = (0..x.len()).map(nodal).collect();
        for (i, edge) in forest.edges.iter().enumerate() {
            let Some(edge) = edge else { continue };
            let force = edge.k * (edge.a * x[edge.parent] + edge.c * x[i]);
            residual[edge.parent] -= edge.a * force;
            residual[i] -= edge.c * force;
        }
        for closing in &forest.loops {
            let force = closing.k * closing.ends.iter().map(|&(i, w)| w * x[i]).sum::<f64>();
            closing
                .ends
                .iter()
                .for_each(|&(i, w)| residual[i] -= w * force);
        }
        residual
    }
}

impl ClosingSpring {
    fn deformation(&self, x: &[f64], delta: &[f64]) -> f64 {
        self.path
            .iter()
            .map(|&(pos, factor)| factor * delta[pos])
            .sum::<f64>()
            + self.slip * x[self.apex]
    }
}

impl Forest {
    fn tree_contains(&self, tree: usize, pos: usize) -> bool {
        (self.trees[tree].start..self.trees[tree].end).contains(&pos)
    }
}
