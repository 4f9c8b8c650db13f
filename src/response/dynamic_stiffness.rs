//! Dynamic stiffness `s² M + s C + K + i sgn(Im s) H`, stored by its nonzero entries.

use std::collections::BTreeMap;

use super::laplace_factor::{LaplaceFactor, sign};
use crate::machine::spin::SpinTerms;
use crate::modes::system_matrices::{AnalysisContext, SystemMatrices};
use crate::numeric::{Complex, Matrix};

/// Index and value, indices rising, no value zero.
pub(super) type SparseVector = Vec<(usize, f64)>;

/// Terms of like index summed in their order.
pub(super) fn sum_duplicates(terms: impl IntoIterator<Item = (usize, f64)>) -> SparseVector {
    let mut all: SparseVector = terms.into_iter().collect();
    all.sort_by_key(|term| term.0);
    all.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += next.1;
        }
        same
    });
    all.retain(|term| term.1 != 0.0);
    all
}

/// T of `p = T r`, by rows.
pub(super) struct SparseTransform {
    columns: usize,
    rows: Vec<SparseVector>,
}

impl SparseTransform {
    /// Transform given by its columns over `n` coordinates p.
    pub fn from_columns(n: usize, columns: &[SparseVector]) -> SparseTransform {
        let mut rows = vec![Vec::new(); n];
        for (j, column) in columns.iter().enumerate() {
            column.iter().for_each(|&(i, a)| rows[i].push((j, a)));
        }
        SparseTransform {
            columns: columns.len(),
            rows,
        }
    }

    /// Transform given by a dense matrix.
    pub fn from_matrix(t: &Matrix) -> SparseTransform {
        let row = |i| {
            let all = (0..t.ncols()).map(|j| (j, t[(i, j)]));
            all.filter(|term| term.1 != 0.0).collect()
        };
        SparseTransform {
            columns: t.ncols(),
            rows: (0..t.nrows()).map(row).collect(),
        }
    }

    /// Number of coordinates r.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// As a dense matrix.
    pub fn matrix(&self) -> Matrix {
        let mut t = Matrix::zeros(self.rows.len(), self.columns);
        for (i, row) in self.rows.iter().enumerate() {
            row.iter().for_each(|&(j, a)| t[(i, j)] = a);
        }
        t
    }

    /// `wᵀT`: a direction over p, seen by r.
    pub fn project(&self, p: impl IntoIterator<Item = (usize, f64)>) -> SparseVector {
        let scaled = |(i, a): (usize, f64)| self.rows[i].iter().map(move |&(j, t)| (j, a * t));
        sum_duplicates(p.into_iter().flat_map(scaled))
    }
}

/// Entries of M, C, K and H in one place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StiffnessEntry {
    pub row: usize,
    pub column: usize,
    pub mass: f64,
    pub damping: f64,
    pub stiffness: f64,
    pub hysteretic: f64,
}

impl StiffnessEntry {
    /// Contribution of the entry to `s² M + s C + K + i sgn(Im s) H`.
    pub fn value_at(&self, s: Complex) -> Complex {
        s * s * self.mass
            + s * self.damping
            + Complex::new(self.stiffness, sign(s) * self.hysteretic)
    }

    /// The sizes of its terms together, without signs.
    pub fn size(&self, s: Complex) -> f64 {
        self.stiffness.abs() + s.norm() * self.damping.abs() + s.norm_sqr() * self.mass.abs()
    }

    /// The matrices with their factors.
    pub fn factors(&self) -> [(LaplaceFactor, f64); 4] {
        [
            (LaplaceFactor::ONE, self.stiffness),
            (LaplaceFactor::S, self.damping),
            (LaplaceFactor::S_SQUARED, self.mass),
            (LaplaceFactor::HYSTERETIC, self.hysteretic),
        ]
    }
}

/// All entries by columns, rows rising; the diagonal is always among them.
pub(super) struct DynamicStiffness {
    pub n: usize,
    pub list: Vec<StiffnessEntry>,
}

impl DynamicStiffness {
    /// Over the columns of T, the first `n_rigid` of which are the machine's rigid motions, as [`SystemMatrices::in_basis`] has them; without
    /// modal damping, which fills the matrix.
    pub fn assemble(
        context: &AnalysisContext,
        transform: &SparseTransform,
        n_rigid: usize,
    ) -> DynamicStiffness {
        let global = &context.machine.damping;
        let (alpha, beta) = (global.mass, global.stiffness);
        let mut sums = EntrySums::new(transform.columns);
        for mass in &context.model.masses {
            let v = transform.project(mass.direction.entries());
            sums.add(|e| &mut e.mass, mass.value, &v, &v);
            sums.add(|e| &mut e.damping, alpha * mass.value, &v, &v);
        }
        for branch in &context.model.branches {
            let still = match branch.stiffness != 0.0 {
                true => n_rigid,
                false => n_rigid.min(context.model.n_undamped_rigid),
            };
            let mut along = transform.project(branch.direction.entries());
            along.retain(|term| term.0 >= still);
            let acts = match &branch.force {
                Some(force) => transform.project(force.entries()),
                None => along.clone(),
            };
            let k = branch.stiffness;
            sums.add(|e| &mut e.stiffness, k, &acts, &along);
            sums.add(|e| &mut e.damping, branch.damping, &acts, &along);
            sums.add(|e| &mut e.hysteretic, branch.loss_factor * k, &acts, &along);
            // Rayleigh damping goes with the symmetric part of K.
            sums.add(|e| &mut e.damping, 0.5 * beta * k, &acts, &along);
            sums.add(|e| &mut e.damping, 0.5 * beta * k, &along, &acts);
        }
        let terms = context
            .speeds
            .map(|speeds| SpinTerms::new(context.machine, context.model, speeds, true));
        let terms = terms.unwrap_or_default();
        for (a, b, g) in &terms.gyroscopic {
            let [a, b] = [a, b].map(|d| transform.project(d.entries()));
            sums.add(|e| &mut e.damping, *g, &a, &b);
            sums.add(|e| &mut e.damping, -g, &b, &a);
        }
        for (v, m) in &terms.centripetal {
            let v = transform.project(v.entries());
            sums.add(|e| &mut e.stiffness, -m, &v, &v);
        }
        for (u, w, c) in &terms.circulatory {
            let [u, w] = [u, w].map(|d| transform.project(d.entries()));
            sums.add(|e| &mut e.stiffness, *c, &u, &w);
        }
        sums.entries()
    }

    /// Nonzero entries of dense equations.
    pub fn from_dense(matrices: &SystemMatrices) -> DynamicStiffness {
        let n = matrices.len();
        let mut sums = EntrySums::new(n);
        for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
            let lossy = matrices.hysteretic.as_ref().map_or(0.0, |h| h[(i, j)]);
            let entry = StiffnessEntry {
                mass: matrices.mass[(i, j)],
                damping: matrices.damping[(i, j)],
                stiffness: matrices.stiffness[(i, j)],
                hysteretic: lossy,
                ..zero_entry(i, j)
            };
            if entry.factors().iter().any(|part| part.1 != 0.0) {
                sums.0.insert((j, i), entry);
            }
        }
        sums.entries()
    }

    /// The block of the first `n` rows and columns, and the entries next to it.
    pub fn split(self, n: usize) -> (DynamicStiffness, Vec<StiffnessEntry>) {
        let inside = |e: &StiffnessEntry| e.row < n && e.column < n;
        let (list, beside) = self.list.into_iter().partition(inside);
        (DynamicStiffness { n, list }, beside)
    }

    /// The block behind the first `n` rows and columns.
    pub fn trailing_block(&self, n: usize) -> DynamicStiffness {
        let inside = self.list.iter().filter(|e| e.row >= n && e.column >= n);
        let moved = inside.map(|e| StiffnessEntry {
            row: e.row - n,
            column: e.column - n,
            ..*e
        });
        DynamicStiffness {
            n: self.n - n,
            list: moved.collect(),
        }
    }
}

fn zero_entry(row: usize, column: usize) -> StiffnessEntry {
    StiffnessEntry {
        row,
        column,
        mass: 0.0,
        damping: 0.0,
        stiffness: 0.0,
        hysteretic: 0.0,
    }
}

/// Entries while they are summed, by column and row.
struct EntrySums(BTreeMap<(usize, usize), StiffnessEntry>);

impl EntrySums {
    fn new(n: usize) -> EntrySums {
        EntrySums((0..n).map(|i| ((i, i), zero_entry(i, i))).collect())
    }

    /// Adds `value · u wᵀ` to one of the matrices.
    fn add(
        &mut self,
        of: fn(&mut StiffnessEntry) -> &mut f64,
        value: f64,
        u: &SparseVector,
        w: &SparseVector,
    ) {
        if value == 0.0 {
            return;
        }
        for &(j, w) in w {
            for &(i, u) in u {
                let entry = self.0.entry((j, i)).or_insert_with(|| zero_entry(i, j));
                *of(entry) += value * u * w;
            }
        }
    }

    fn entries(self) -> DynamicStiffness {
        let n = self.0.keys().filter(|at| at.0 == at.1).count();
        DynamicStiffness {
            n,
            list: self.0.into_values().collect(),
        }
    }
}
