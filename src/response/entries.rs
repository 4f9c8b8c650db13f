//! The dynamic stiffness `s² M + s C + K + i sgn(Im s) H` entry by entry: of a train of thousands of bodies each sees its
//! neighbours alone, and nothing that is zero is stored.

use std::collections::BTreeMap;

use super::factor::{Factor, sign};
use crate::machine::spin::SpinTerms;
use crate::modes::equations::{Case, Equations};
use crate::numeric::{Complex, Matrix};

/// Index and value, indices rising, no value zero.
pub(super) type Sparse = Vec<(usize, f64)>;

/// Terms of like index summed in their order.
pub(super) fn gathered(terms: impl IntoIterator<Item = (usize, f64)>) -> Sparse {
    let mut all: Sparse = terms.into_iter().collect();
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
pub(super) struct Transform {
    columns: usize,
    rows: Vec<Sparse>,
}

impl Transform {
    /// Of columns over `n` coordinates p.
    pub fn of_columns(n: usize, columns: &[Sparse]) -> Transform {
        let mut rows = vec![Vec::new(); n];
        for (j, column) in columns.iter().enumerate() {
            column.iter().for_each(|&(i, a)| rows[i].push((j, a)));
        }
        Transform {
            columns: columns.len(),
            rows,
        }
    }

    /// Of a dense matrix.
    pub fn of_matrix(t: &Matrix) -> Transform {
        let row = |i| {
            let all = (0..t.ncols()).map(|j| (j, t[(i, j)]));
            all.filter(|term| term.1 != 0.0).collect()
        };
        Transform {
            columns: t.ncols(),
            rows: (0..t.nrows()).map(row).collect(),
        }
    }

    /// How many coordinates r has.
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
    pub fn sees(&self, p: impl IntoIterator<Item = (usize, f64)>) -> Sparse {
        let scaled = |(i, a): (usize, f64)| self.rows[i].iter().map(move |&(j, t)| (j, a * t));
        gathered(p.into_iter().flat_map(scaled))
    }
}

/// What M, C, K and H have in one place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Entry {
    pub row: usize,
    pub column: usize,
    pub mass: f64,
    pub damping: f64,
    pub stiffness: f64,
    pub lossy: f64,
}

impl Entry {
    /// Its share of `s² M + s C + K + i sgn(Im s) H`.
    pub fn at(&self, s: Complex) -> Complex {
        s * s * self.mass + s * self.damping + Complex::new(self.stiffness, sign(s) * self.lossy)
    }

    /// The sizes of its terms together, without signs.
    pub fn size(&self, s: Complex) -> f64 {
        self.stiffness.abs() + s.norm() * self.damping.abs() + s.norm_sqr() * self.mass.abs()
    }

    /// The matrices with their factors.
    pub fn parts(&self) -> [(Factor, f64); 4] {
        [
            (Factor::ONE, self.stiffness),
            (Factor::S, self.damping),
            (Factor::SS, self.mass),
            (Factor::LOSSY, self.lossy),
        ]
    }
}

/// All entries by columns, rows rising; the diagonal is always among them.
pub(super) struct Entries {
    pub n: usize,
    pub list: Vec<Entry>,
}

impl Entries {
    /// Over the columns of T, the first `n_rigid` of which are the machine's rigid motions, as [`Equations::over`] has them; without
    /// modal damping, which fills the matrix.
    pub fn over(case: &Case, transform: &Transform, n_rigid: usize) -> Entries {
        let global = &case.machine.damping;
        let (alpha, beta) = (global.mass, global.stiffness);
        let mut sums = Sums::new(transform.columns);
        for mass in &case.linear.masses {
            let v = transform.sees(mass.direction.scaled());
            sums.add(|e| &mut e.mass, mass.value, &v, &v);
            sums.add(|e| &mut e.damping, alpha * mass.value, &v, &v);
        }
        for branch in &case.linear.branches {
            let still = match branch.stiffness != 0.0 {
                true => n_rigid,
                false => n_rigid.min(case.linear.n_undamped_rigid),
            };
            let mut along = transform.sees(branch.direction.scaled());
            along.retain(|term| term.0 >= still);
            let acts = match &branch.force {
                Some(force) => transform.sees(force.scaled()),
                None => along.clone(),
            };
            let k = branch.stiffness;
            sums.add(|e| &mut e.stiffness, k, &acts, &along);
            sums.add(|e| &mut e.damping, branch.damping, &acts, &along);
            sums.add(|e| &mut e.lossy, branch.loss_factor * k, &acts, &along);
            // Rayleigh damping goes with the symmetric part of K.
            sums.add(|e| &mut e.damping, 0.5 * beta * k, &acts, &along);
            sums.add(|e| &mut e.damping, 0.5 * beta * k, &along, &acts);
        }
        let terms = case
            .speeds
            .map(|speeds| SpinTerms::new(case.machine, case.linear, speeds, true));
        let terms = terms.unwrap_or_default();
        for (a, b, g) in &terms.gyroscopic {
            let [a, b] = [a, b].map(|d| transform.sees(d.scaled()));
            sums.add(|e| &mut e.damping, *g, &a, &b);
            sums.add(|e| &mut e.damping, -g, &b, &a);
        }
        for (v, m) in &terms.centripetal {
            let v = transform.sees(v.scaled());
            sums.add(|e| &mut e.stiffness, -m, &v, &v);
        }
        for (u, w, c) in &terms.circulatory {
            let [u, w] = [u, w].map(|d| transform.sees(d.scaled()));
            sums.add(|e| &mut e.stiffness, *c, &u, &w);
        }
        sums.entries()
    }

    /// What of dense equations is not zero.
    pub fn of(equations: &Equations) -> Entries {
        let n = equations.len();
        let mut sums = Sums::new(n);
        for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
            let lossy = equations.hysteretic.as_ref().map_or(0.0, |h| h[(i, j)]);
            let entry = Entry {
                mass: equations.mass[(i, j)],
                damping: equations.damping[(i, j)],
                stiffness: equations.stiffness[(i, j)],
                lossy,
                ..nothing(i, j)
            };
            if entry.parts().iter().any(|part| part.1 != 0.0) {
                sums.0.insert((j, i), entry);
            }
        }
        sums.entries()
    }

    /// The block of the first `n` rows and columns, and the entries beside it.
    pub fn split(self, n: usize) -> (Entries, Vec<Entry>) {
        let inside = |e: &Entry| e.row < n && e.column < n;
        let (list, beside) = self.list.into_iter().partition(inside);
        (Entries { n, list }, beside)
    }

    /// The block behind the first `n` rows and columns.
    pub fn behind(&self, n: usize) -> Entries {
        let inside = self.list.iter().filter(|e| e.row >= n && e.column >= n);
        let moved = inside.map(|e| Entry {
            row: e.row - n,
            column: e.column - n,
            ..*e
        });
        Entries {
            n: self.n - n,
            list: moved.collect(),
        }
    }
}

fn nothing(row: usize, column: usize) -> Entry {
    Entry {
        row,
        column,
        mass: 0.0,
        damping: 0.0,
        stiffness: 0.0,
        lossy: 0.0,
    }
}

/// Entries while they are summed, by column and row.
struct Sums(BTreeMap<(usize, usize), Entry>);

impl Sums {
    fn new(n: usize) -> Sums {
        Sums((0..n).map(|i| ((i, i), nothing(i, i))).collect())
    }

    /// Adds `value · u wᵀ` to one of the matrices.
    fn add(&mut self, of: fn(&mut Entry) -> &mut f64, value: f64, u: &Sparse, w: &Sparse) {
        if value == 0.0 {
            return;
        }
        for &(j, w) in w {
            for &(i, u) in u {
                let entry = self.0.entry((j, i)).or_insert_with(|| nothing(i, j));
                *of(entry) += value * u * w;
            }
        }
    }

    fn entries(self) -> Entries {
        let n = self.0.keys().filter(|at| at.0 == at.1).count();
        Entries {
            n,
            list: self.0.into_values().collect(),
        }
    }
}
