//! Newton's method `x ← x − Δ`, `J Δ = g`, for a few equations with exact derivatives.

/// Steps before the search is given up.
const STEPS: usize = 40;
/// A step below this share of the scales is the last: the next would be its square, rounding.
const LAST_STEP: f64 = 3e-8;
/// Largest share of its scale that an unknown moves in a step.
const LARGEST_STEP: f64 = 0.5;
/// Pivots, relative to the largest of their row, below this mean that the equations are dependent: a line of contact or a limit.
const DEPENDENT: f64 = 1e-13;

/// The root of N equations nearest `start`; `system` gives their values and their rows of derivatives, none where they are not defined.
///
/// `scales` are sizes of the unknowns: steps are cut at half of them. None where the equations become dependent or nothing is found.
#[inline]
pub fn newton<const N: usize>(
    start: [f64; N],
    scales: [f64; N],
    mut system: impl FnMut([f64; N]) -> Option<([f64; N], [[f64; N]; N])>,
) -> Option<[f64; N]> {
    iterate(start, scales, |x| {
        let (values, mut rows) = system(x)?;
        for row in &mut rows {
            (0..N).for_each(|j| row[j] *= scales[j]);
        }
        solve(rows, values)
    })
}

/// The root as by [`newton`], of a system that gives its own step `J⁻¹ g` in units of the scales.
#[inline]
pub fn iterate<const N: usize>(
    start: [f64; N],
    scales: [f64; N],
    mut step: impl FnMut([f64; N]) -> Option<[f64; N]>,
) -> Option<[f64; N]> {
    let mut x = start;
    for _ in 0..STEPS {
        let step = step(x)?;
        let largest = step.iter().fold(0f64, |most, s| most.max(s.abs()));
        let cut = (LARGEST_STEP / largest).min(1.0);
        (0..N).for_each(|j| x[j] -= cut * step[j] * scales[j]);
        if largest <= LAST_STEP {
            return Some(x);
        }
    }
    None
}

/// Solves `A x = b` by elimination with row pivoting; none where A is singular to rounding or not finite.
#[inline]
pub fn solve<const N: usize>(mut a: [[f64; N]; N], mut b: [f64; N]) -> Option<[f64; N]> {
    for (row, right) in a.iter_mut().zip(&mut b) {
        let largest = row.iter().fold(0f64, |most, v| most.max(v.abs()));
        let scale = 1.0 / largest;
        row.iter_mut().for_each(|v| *v *= scale);
        *right *= scale;
    }
    for j in 0..N {
        let pivot = (j + 1..N).fold(j, |best, i| {
            if a[i][j].abs() > a[best][j].abs() {
                i
            } else {
                best
            }
        });
        a.swap(j, pivot);
        b.swap(j, pivot);
        if !(a[j][j].abs() > DEPENDENT) {
            return None;
        }
        let inverse = 1.0 / a[j][j];
        for i in j + 1..N {
            let factor = a[i][j] * inverse;
            for k in j + 1..N {
                a[i][k] -= factor * a[j][k];
            }
            b[i] -= factor * b[j];
        }
    }
    for j in (0..N).rev() {
        for k in j + 1..N {
            b[j] -= a[j][k] * b[k];
        }
        b[j] /= a[j][j];
    }
    b.iter().all(|x| x.is_finite()).then_some(b)
}
