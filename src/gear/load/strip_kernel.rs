//! Half spaces under the cells of one contact line: `∫ ds/√(s² + y²) = asinh(f/y) − asinh(n/y)` between the ends n, f of a cell.
//!
//! Beyond ten y the integral is `ln(f/n) + ¼ y² (1/f² − 1/n²) − 3/32 y⁴ (1/f⁴ − 1/n⁴) + 5/96 y⁶ (1/f⁶ − 1/n⁶)` to 4e-10 (the series of
//! asinh, Abramowitz & Stegun 1964, 4.6.31), whose coefficients do not depend on the width: they are computed once a line.

use super::contact_line::{ContactCell, asinh_between};

/// Distance in y from which the series holds.
const FAR: f64 = 10.0;

/// The integrals of a line's cells about each other's middles, each pair of cells by the mean of both views.
#[derive(Debug, Clone)]
pub(super) struct StripKernel {
    /// Lower triangle row by row, diagonal included.
    entries: Vec<KernelEntry>,
}

/// Two cells as they see each other.
#[derive(Debug, Clone, Copy)]
struct KernelEntry {
    /// Least distance from a middle to an end, m; zero within a cell.
    nearest: f64,
    /// Ends `[near, far]` of each from the other's middle, m, with half the reciprocal of its length.
    views: [([f64; 2], f64); 2],
    /// Coefficients of 1, y², y⁴ and y⁶.
    series: [f64; 4],
}

impl StripKernel {
    pub(super) fn new(cells: &[ContactCell]) -> StripKernel {
        let rows = cells.iter().enumerate();
        let entries = rows.flat_map(|(i, cell)| {
            let up_to = &cells[..=i];
            up_to.iter().map(move |other| KernelEntry::new(cell, other))
        });
        StripKernel {
            entries: entries.collect(),
        }
    }

    /// The integrals over each cell by its length, 1/m, at `y` from the line: lower triangle row by row.
    pub(super) fn at(&self, y: f64) -> impl Iterator<Item = f64> {
        self.entries.iter().map(move |entry| entry.at(y))
    }
}

impl KernelEntry {
    fn new(one: &ContactCell, other: &ContactCell) -> KernelEntry {
        let apart = (one.along - other.along).abs();
        let views = [one, other].map(|cell| {
            let half = 0.5 * cell.length;
            ([apart - half, apart + half], 0.5 / cell.length)
        });
        let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
            let terms = views
                .iter()
                .map(|([near, far], weight)| weight * of(*near, *far));
            terms.sum()
        };
        let power = |n: i32| sum(&|near: f64, far: f64| far.powi(-n) - near.powi(-n));
        KernelEntry {
            nearest: views[0].0[0].min(views[1].0[0]).max(0.0),
            views,
            series: [
                sum(&|near: f64, far: f64| (far / near).ln()),
                power(2) / 4.0,
                -3.0 / 32.0 * power(4),
                5.0 / 96.0 * power(6),
            ],
        }
    }

    fn at(&self, y: f64) -> f64 {
        if self.nearest > FAR * y {
            let [one, two, four, six] = self.series;
            let y2 = y * y;
            return one + y2 * (two + y2 * (four + y2 * six));
        }
        let of = |(ends, weight): &([f64; 2], f64)| {
            let ends = ends.map(|end| end / y);
            weight * asinh_between(ends, ends.map(|s| (s * s + 1.0).sqrt()))
        };
        self.views.iter().map(of).sum()
    }
}
